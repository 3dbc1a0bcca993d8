//! Words, strings and brackets of a pbrt file, and where they stand.
//!
//! Nothing is kept of a token but its place, so that long arrays cost no memory to pass over; and lines are counted on the
//! way, as the starts of all lines of a large file would take more memory than the file.

use crate::printable::printable;
use crate::scene::error::{Refusal, SceneError};
use std::borrow::Cow;
use std::ops::Range;
use std::path::Path;
use std::rc::Rc;

/// Longest piece of a file that a message quotes, in characters.
const LONGEST_QUOTE: usize = 40;

/// A file of the scene.
#[derive(Debug)]
pub(super) struct Source {
    /// The file as messages name it.
    pub(super) name: String,
    /// Whether it was included by another.
    pub(super) included: bool,
    pub(super) text: String,
}

/// A piece of a file.
#[derive(Debug, Clone)]
pub(super) struct Place {
    source: Rc<Source>,
    span: Range<usize>,
    /// Line of its beginning, counted from 1.
    pub(super) line: usize,
}

/// Kinds of tokens.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum What {
    /// A directive or a number.
    Word,
    /// A string, with its quotes.
    Quoted,
    /// `[`
    Open,
    /// `]`
    Close,
}

/// A token and the bytes that it stands at.
#[derive(Debug, Clone)]
pub(super) struct Token {
    pub(super) what: What,
    pub(super) span: Range<usize>,
    pub(super) line: usize,
}

/// The tokens of a file, one after the other.
pub(super) struct Lexer {
    source: Rc<Source>,
    at: usize,
    line: usize,
    peeked: Option<Token>,
}

impl Source {
    pub(super) fn new(name: &str, text: &str, included: bool) -> Rc<Self> {
        Rc::new(Self {
            name: name.to_owned(),
            included,
            text: text.to_owned(),
        })
    }

    /// The directory that file names in it are relative to.
    pub(super) fn directory(&self) -> &Path {
        Path::new(&self.name).parent().unwrap_or(Path::new(""))
    }

    /// The error that says `message` about the bytes of `span`; carets go as far as its first line.
    fn refuse(&self, span: &Range<usize>, message: String) -> SceneError {
        let text = self.text.as_str();
        let at = text.floor_char_boundary(span.start);
        let before = &text[..at];
        let start = before.rfind('\n').map_or(0, |newline| newline + 1);
        let line = before.bytes().filter(|byte| *byte == b'\n').count() + 1;
        let content = text[start..].split('\n').next().unwrap_or_default();
        let content = content.strip_suffix('\r').unwrap_or(content);
        let at = (at - start).min(content.len());
        let end = content.floor_char_boundary(span.end.saturating_sub(start).clamp(at, content.len()));
        let column = content[..at].chars().count() + 1;
        let length = content[at..end].chars().count();
        SceneError::Refused(Box::new(Refusal::new(
            &self.name,
            (line, column),
            content,
            length,
            message,
        )))
    }
}

impl Place {
    pub(super) fn refuse(&self, message: impl Into<String>) -> SceneError {
        self.source.refuse(&self.span, message.into())
    }

    /// `line 12`, with the name of an included file.
    pub(super) fn label(&self) -> String {
        match self.source.included {
            true => {
                let file = Path::new(&self.source.name).file_name().unwrap_or_default();
                format!("line {} of {}", self.line, quote(&file.to_string_lossy()))
            }
            false => format!("line {}", self.line),
        }
    }

    pub(super) fn directory(&self) -> &Path {
        self.source.directory()
    }

    /// The place from here to the end of `last`.
    pub(super) fn up_to(mut self, last: &Token) -> Self {
        self.span.end = last.span.end;
        self
    }
}

/// `text` in one short line.
pub(super) fn quote(text: &str) -> String {
    let mut quote: String = text.chars().take(LONGEST_QUOTE).collect();
    if quote.len() < text.len() {
        quote.push_str("...");
    }
    printable(&quote)
}

fn is_blank(byte: u8) -> bool {
    matches!(byte, b' ' | b'\t' | b'\r' | b'\n')
}

impl Lexer {
    pub(super) fn new(source: Rc<Source>) -> Self {
        // a byte order mark is no part of the first word
        let at = source.text.len() - source.text.strip_prefix('\u{feff}').unwrap_or(&source.text).len();
        Self {
            source,
            at,
            line: 1,
            peeked: None,
        }
    }

    pub(super) fn place(&self, token: &Token) -> Place {
        Place {
            source: self.source.clone(),
            span: token.span.clone(),
            line: token.line,
        }
    }

    /// What is written at `token`.
    pub(super) fn written(&self, token: &Token) -> &str {
        &self.source.text[token.span.clone()]
    }

    /// The string that `token` stands for, when it is one.
    pub(super) fn string(&self, token: &Token) -> Result<Option<Cow<'_, str>>, SceneError> {
        if token.what != What::Quoted {
            return Ok(None);
        }
        let inner = token.span.start + 1..token.span.end - 1;
        let raw = &self.source.text[inner.clone()];
        if !raw.contains('\\') {
            return Ok(Some(Cow::Borrowed(raw)));
        }
        let mut string = String::with_capacity(raw.len());
        let mut chars = raw.char_indices();
        while let Some((at, c)) = chars.next() {
            if c != '\\' {
                string.push(c);
                continue;
            }
            string.push(match chars.next().map(|(_, escaped)| escaped) {
                Some('b') => '\u{8}',
                Some('f') => '\u{c}',
                Some('n') => '\n',
                Some('r') => '\r',
                Some('t') => '\t',
                Some(same @ ('\\' | '\'' | '"')) => same,
                other => {
                    let start = inner.start + at;
                    let end = start + 1 + other.map_or(0, char::len_utf8);
                    let found = quote(&self.source.text[start..end]);
                    let message = format!(
                        "{found} is not allowed in a string: escapes are \\b, \\f, \\n, \\r, \\t, \\\\, \\' and \\\""
                    );
                    return Err(self.source.refuse(&(start..end), message));
                }
            });
        }
        Ok(Some(Cow::Owned(string)))
    }

    pub(super) fn peek(&mut self) -> Result<Option<&Token>, SceneError> {
        if self.peeked.is_none() {
            self.peeked = self.scan()?;
        }
        Ok(self.peeked.as_ref())
    }

    pub(super) fn next(&mut self) -> Result<Option<Token>, SceneError> {
        match self.peeked.take() {
            Some(token) => Ok(Some(token)),
            None => self.scan(),
        }
    }

    /// The next token, where a file may not end; `rule` says what belongs there.
    pub(super) fn required(&mut self, rule: &str) -> Result<Token, SceneError> {
        match self.next()? {
            Some(token) => Ok(token),
            None => {
                let end = self
                    .source
                    .text
                    .trim_end_matches(|c: char| c.is_ascii_whitespace())
                    .len();
                Err(self
                    .source
                    .refuse(&(end..end), format!("the file ends too early: {rule}")))
            }
        }
    }

    fn scan(&mut self) -> Result<Option<Token>, SceneError> {
        let source = self.source.clone();
        let bytes = source.text.as_bytes();
        loop {
            match bytes.get(self.at) {
                None => return Ok(None),
                Some(b'\n') => {
                    self.line += 1;
                    self.at += 1;
                }
                Some(byte) if is_blank(*byte) => self.at += 1,
                Some(b'#') => {
                    let rest = &bytes[self.at..];
                    let ends = |byte: &u8| matches!(byte, b'\n' | b'\r');
                    self.at += rest.iter().position(ends).unwrap_or(rest.len());
                }
                Some(_) => break,
            }
        }
        let start = self.at;
        let (what, length) = match bytes[start] {
            b'[' => (What::Open, 1),
            b']' => (What::Close, 1),
            b'"' => (What::Quoted, quoted_length(&source, start)?),
            _ => {
                let ends = |byte: &u8| is_blank(*byte) || matches!(byte, b'"' | b'[' | b']');
                let rest = &bytes[start..];
                (What::Word, rest.iter().position(ends).unwrap_or(rest.len()))
            }
        };
        self.at = start + length;
        Ok(Some(Token {
            what,
            span: start..self.at,
            line: self.line,
        }))
    }
}

/// Bytes of the string whose first quote stands at `start`, both quotes included.
fn quoted_length(source: &Source, start: usize) -> Result<usize, SceneError> {
    let rest = &source.text.as_bytes()[start..];
    let mut at = 1;
    loop {
        match rest.get(at) {
            Some(b'"') => return Ok(at + 1),
            Some(b'\\') if rest.get(at + 1).is_some_and(|next| *next != b'\n') => at += 2,
            Some(byte) if *byte != b'\n' => at += 1,
            _ => {
                let message = "this string has no end: it ends with \" on the line that it begins on";
                return Err(source.refuse(&(start..start + at), message.to_owned()));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lexer(text: &str) -> Lexer {
        Lexer::new(Source::new("s.pbrt", text, false))
    }

    fn tokens(text: &str) -> Vec<(What, String, usize)> {
        let mut lexer = lexer(text);
        let mut tokens = Vec::new();
        while let Some(token) = lexer.next().unwrap() {
            tokens.push((token.what, lexer.written(&token).to_owned(), token.line));
        }
        tokens
    }

    #[test]
    fn words_strings_and_brackets_know_their_lines() {
        let found = tokens("\u{feff}Shape \"a b\"# \"c\n[1\t2.5]\r\n\"#\"x # end");
        let expected = [
            (What::Word, "Shape", 1),
            (What::Quoted, "\"a b\"", 1),
            (What::Open, "[", 2),
            (What::Word, "1", 2),
            (What::Word, "2.5", 2),
            (What::Close, "]", 2),
            (What::Quoted, "\"#\"", 3),
            (What::Word, "x", 3),
        ];
        assert_eq!(found, expected.map(|(what, text, line)| (what, text.to_owned(), line)));
    }

    #[test]
    fn escapes_are_those_of_pbrt() {
        let string = |text: &str| {
            let mut lexer = lexer(text);
            let token = lexer.next().unwrap().unwrap();
            lexer.string(&token).map(|string| string.unwrap().into_owned())
        };
        assert_eq!(string("\"a\\\"b\\\\\\n\"").unwrap(), "a\"b\\\n");
        let error = string("\n \"é\\é\"").unwrap_err().to_string();
        assert!(
            error.starts_with("s.pbrt:2:4: \\é is not allowed in a string"),
            "{error}"
        );
    }

    #[test]
    fn strings_end_on_their_line() {
        for text in ["\"", "a \"b", "a \"b\nc\"", "\"\\", "\"\\\n\"", "\"a\\\""] {
            let mut lexer = lexer(text);
            let error = loop {
                match lexer.next() {
                    Ok(token) => assert!(token.is_some(), "{text:?}"),
                    Err(error) => break error.to_string(),
                }
            };
            assert!(error.contains("this string has no end"), "{text:?}: {error}");
        }
    }

    #[test]
    fn places_are_lines_and_columns_of_characters() {
        let mut lexer = lexer("a\r\n  éé \"x\" ");
        let tokens: Vec<Token> = (0..3).map(|_| lexer.next().unwrap().unwrap()).collect();
        let errors: Vec<String> = tokens
            .iter()
            .map(|token| lexer.place(token).refuse("no").to_string())
            .collect();
        assert!(errors[0].starts_with("s.pbrt:1:1: no\n 1 | a\n"), "{}", errors[0]);
        assert!(
            errors[1].starts_with("s.pbrt:2:3: no\n 2 |   éé \"x\"\n   |   ^^"),
            "{}",
            errors[1]
        );
        assert!(errors[2].starts_with("s.pbrt:2:6: no"), "{}", errors[2]);
        let error = lexer.required("a number").unwrap_err().to_string();
        assert!(
            error.starts_with("s.pbrt:2:9: the file ends too early: a number"),
            "{error}"
        );
    }
}
