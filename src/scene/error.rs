//! What a scene that cannot be used gets told: where, which value, and what is allowed.

use crate::printable::printable;
use std::fmt;
use thiserror::Error;

/// Longest line that an excerpt prints, gutter included, in characters.
const LINE_WIDTH: usize = 100;
/// Characters kept on the left of the offending place when a line is cut.
const LEAD: usize = 40;
/// Stands for the part of a line that was cut away.
const CUT: &str = "...";

/// Why a scene was refused.
///
/// The system's reason is part of the message, and not a source of the error, so that an error chain says it once.
#[derive(Debug, Error)]
pub enum SceneError {
    /// The file could not be opened or read.
    #[error("{}: cannot be read: {reason}", printable(path))]
    Unreadable {
        /// The file as it was named.
        path: String,
        /// What the system said.
        reason: std::io::Error,
    },
    /// There is more in the file than in any scene; it was not read, or not parsed.
    #[error(
        "{}: more than {limit} {what} are not allowed: that is the most that a scene may hold",
        printable(path)
    )]
    TooLarge {
        /// The file as it was named.
        path: String,
        /// What there is too much of.
        what: &'static str,
        /// The most that is allowed.
        limit: usize,
    },
    /// The file is not text.
    #[error(
        "{}: byte {offset} (counted from 0) is not UTF-8; a scene is a UTF-8 text file",
        printable(path)
    )]
    NotUtf8 {
        /// The file as it was named.
        path: String,
        /// Number of valid bytes before the first that is not.
        offset: usize,
    },
    /// A value or a byte of a file whose places have no lines.
    #[error("{}: {}", printable(path), printable(&format!("{place} {message}")))]
    Misfit {
        /// The file as it was named.
        path: String,
        /// The value, `materials[3].pbrMetallicRoughness.roughnessFactor`, or the byte.
        place: String,
        /// What is wrong with it and what is allowed, as it goes on behind the place.
        message: String,
    },
    /// A place in the text: a syntax error, a wrong name or a value that is not allowed.
    #[error("{0}")]
    Refused(Box<Refusal>),
}

/// A message about one place in a scene, with the line that it is about.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Refusal {
    /// The file as it was named.
    pub file: String,
    /// Line, counted from 1.
    pub line: usize,
    /// Column in characters, counted from 1.
    pub column: usize,
    /// What is wrong and what is allowed.
    pub message: String,
    excerpt: Excerpt,
}

/// A line of the source, cut to a readable width, and where the carets go.
#[derive(Debug, Clone, PartialEq, Eq)]
struct Excerpt {
    shown: String,
    before_caret: usize,
    carets: usize,
}

impl Refusal {
    /// A message about `length` characters from `column` (counted from 1) of the line `content`.
    pub(super) fn new(
        file: &str,
        (line, column): (usize, usize),
        content: &str,
        length: usize,
        message: String,
    ) -> Self {
        // one more for a caret behind the last character
        let width = LINE_WIDTH - 1 - gutter(line).len();
        Self {
            file: printable(file),
            line,
            column,
            // it may quote names of files
            message: printable(&message),
            excerpt: Excerpt::new(content, column - 1, length, width),
        }
    }
}

impl fmt::Display for Refusal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            file,
            line,
            column,
            message,
            excerpt,
        } = self;
        writeln!(f, "{file}:{line}:{column}: {message}")?;
        let gutter = gutter(*line);
        writeln!(f, "{}", format!("{gutter}{}", excerpt.shown).trim_end())?;
        let indent = gutter.len() - 2;
        let before = excerpt.before_caret;
        write!(
            f,
            "{:indent$}| {:before$}{:^>carets$}",
            "",
            "",
            "^",
            carets = excerpt.carets
        )
    }
}

impl Excerpt {
    /// Shows at most `width` characters of `content`, among them the one at `start` and what fits of `length`.
    fn new(content: &str, start: usize, length: usize, width: usize) -> Self {
        let total = content.chars().count();
        let (from, to) = if total <= width {
            (0, total)
        } else {
            let from = start.saturating_sub(LEAD).min(total - (width - CUT.len()));
            let room = if from > 0 { width - CUT.len() } else { width };
            let all = total - from <= room;
            (from, if all { total } else { from + room - CUT.len() })
        };
        let head = if from > 0 { CUT } else { "" };
        let tail = if to < total { CUT } else { "" };
        let middle: String = content.chars().skip(from).take(to - from).collect();
        Self {
            shown: format!("{head}{}{tail}", printable(&middle)),
            before_caret: start - from + head.len(),
            carets: length.min(to.saturating_sub(start)).max(1),
        }
    }
}

/// What is said of data that cannot be used. Their path, which the reason begins with, may be as long as a scene: of that the end
/// tells most.
pub(super) fn unusable(error: &dyn fmt::Display) -> String {
    const LONGEST: usize = 600;
    let reason = error.to_string();
    let excess = reason.chars().count().saturating_sub(LONGEST);
    let cut = if excess > 0 { "..." } else { "" };
    let end: String = reason.chars().skip(excess).collect();
    format!("cannot be used: {cut}{end}")
}

/// ` 12 | `
fn gutter(line: usize) -> String {
    format!(" {line} | ")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shown(content: &str, column: usize, length: usize) -> Vec<String> {
        let refusal = Refusal::new("s.toml", (7, column), content, length, "no".to_owned());
        refusal.to_string().lines().map(str::to_owned).collect()
    }

    #[test]
    fn the_caret_stands_under_the_value() {
        let lines = shown("\tkappa = -3 # é", 10, 2);
        assert_eq!(lines, ["s.toml:7:10: no", " 7 |  kappa = -3 # é", "   |          ^^"]);
    }

    #[test]
    fn long_lines_are_cut_around_the_caret() {
        for total in [50, 95, 96, 97, 200, 5000] {
            let content: String = (0..total).map(|i| if i % 2 == 0 { 'é' } else { 'b' }).collect();
            for start in (0..=total).step_by(7) {
                for length in [0, 1, 3, 500] {
                    let lines = shown(&content, start + 1, length);
                    assert!(lines.iter().all(|line| line.chars().count() <= LINE_WIDTH), "{lines:?}");
                    let under = lines[2].chars().position(|c| c == '^').unwrap();
                    let pointed = lines[1].chars().nth(under);
                    assert_eq!(pointed, content.chars().nth(start), "{start} of {total}: {lines:?}");
                }
            }
        }
    }

    #[test]
    fn controls_do_not_reach_the_terminal() {
        let refusal = Refusal::new("a\u{1b}.toml", (1, 1), "\u{202e}x", 1, "b\u{9b}\nc".to_owned());
        assert_eq!(
            refusal.to_string(),
            "a\u{fffd}.toml:1:1: b\u{fffd}\u{fffd}c\n 1 | \u{fffd}x\n   | ^"
        );
    }
}
