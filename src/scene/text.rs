//! The text of a scene, and how byte offsets become lines and columns.

use super::error::{Refusal, SceneError};
use super::library::Library;
use crate::printable::printable;
use std::ops::Range;
use std::path::Path;

/// Longest piece of the source that a message quotes, in characters.
const LONGEST_QUOTE: usize = 40;

/// A scene as it was written, with the starts of its lines, and the files that it names.
pub(super) struct Text<'t> {
    file: &'t str,
    content: &'t str,
    line_starts: Vec<usize>,
    library: Library,
}

impl<'t> Text<'t> {
    pub(super) fn new(file: &'t str, content: &'t str) -> Self {
        let breaks = content.bytes().enumerate().filter(|(_, byte)| *byte == b'\n');
        let line_starts = std::iter::once(0).chain(breaks.map(|(i, _)| i + 1)).collect();
        Self {
            file,
            content,
            line_starts,
            library: Library::default(),
        }
    }

    /// Where measured files are read.
    pub(super) fn library(&self) -> &Library {
        &self.library
    }

    pub(super) fn content(&self) -> &'t str {
        self.content
    }

    /// The directory that file names in the text are relative to.
    pub(super) fn directory(&self) -> &'t Path {
        Path::new(self.file).parent().unwrap_or(Path::new(""))
    }

    /// Line of the byte at `offset`, counted from 1.
    pub(super) fn line(&self, offset: usize) -> usize {
        self.line_starts.partition_point(|start| *start <= offset)
    }

    /// What is written at `span`: its first line, cut to a readable length.
    pub(super) fn quote(&self, span: Range<usize>) -> String {
        let written = self.content.get(span).unwrap_or_default();
        let line = written.lines().next().unwrap_or_default();
        let mut quote: String = line.chars().take(LONGEST_QUOTE).collect();
        if quote.len() < written.len() {
            quote.push_str("...");
        }
        printable(&quote)
    }

    /// The error that says `message` about `span`; carets go as far as its first line.
    pub(super) fn refuse(&self, span: Range<usize>, message: impl Into<String>) -> SceneError {
        let at = self.content.floor_char_boundary(span.start);
        let line = self.line(at);
        let start = self.line_starts[line - 1];
        let rest = self.content.get(start..).unwrap_or_default();
        let content = rest.split('\n').next().unwrap_or_default();
        let content = content.strip_suffix('\r').unwrap_or(content);
        // an error at the end of a line or of the file stands just behind its last character
        let at = (at - start).min(content.len());
        let end = span.end.saturating_sub(start).clamp(at, content.len());
        let column = content[..at].chars().count() + 1;
        let length = content.get(at..end).unwrap_or_default().chars().count();
        SceneError::Refused(Box::new(Refusal::new(
            self.file,
            (line, column),
            content,
            length,
            message.into(),
        )))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn any_span_finds_its_line() {
        let content = "a\r\n\nbé\n";
        let text = Text::new("s", content);
        let place = |at: usize| match text.refuse(at..at + 1, "") {
            SceneError::Refused(refusal) => (refusal.line, refusal.column),
            other => panic!("{other}"),
        };
        assert_eq!([0, 1, 2, 3, 4, 5].map(place)[..3], [(1, 1), (1, 2), (1, 2)]);
        assert_eq!([3, 4, 5, 6, 7, 8].map(place)[..2], [(2, 1), (3, 1)]);
        assert_eq!([5, 6, 7, 8, 900].map(place), [(3, 2), (3, 2), (3, 3), (4, 1), (4, 1)]);
    }

    #[test]
    fn quotes_are_short_and_single_lines() {
        let long = format!("{}\nsecond", "é".repeat(60));
        let text = Text::new("s", &long);
        assert_eq!(text.quote(0..4), "éé");
        assert_eq!(text.quote(0..long.len()), format!("{}...", "é".repeat(40)));
        assert_eq!(text.quote(1..2), "");
    }
}
