//! What the readers of measured data share: files of bounded size, and numbers in text that know their lines.

use super::MeasuredError;
use crate::regular;
use sha2::{Digest, Sha256};
use std::io::Read;
use std::path::Path;

/// A token of a refused file, quoted and short enough for a message.
pub(super) fn shown(token: &[u8]) -> String {
    const LONGEST: usize = 32;
    let head = String::from_utf8_lossy(&token[..token.len().min(LONGEST)]);
    let dots = if token.len() > LONGEST { "..." } else { "" };
    format!("\"{}{dots}\"", head.escape_debug())
}

/// The whole file, at most `limit` bytes of it.
///
/// A regular file tells its size before it is read; should it grow meanwhile, one byte more than the limit is read at most.
///
/// # Errors
/// [`MeasuredError::Unreadable`], for what is no regular file too, and [`MeasuredError::Size`].
pub(super) fn read_whole(path: &Path, limit: u64) -> Result<Vec<u8>, MeasuredError> {
    let name = || path.display().to_string();
    let unreadable = |reason| MeasuredError::Unreadable { path: name(), reason };
    let too_long = |bytes, more| MeasuredError::Size {
        path: name(),
        bytes,
        allowed: format!("a file of this kind has at most {limit} bytes{more}"),
    };
    let (file, length) = regular::open(path).map_err(unreadable)?;
    if length > limit {
        return Err(too_long(length, ""));
    }
    let mut bytes = Vec::new();
    file.take(limit + 1).read_to_end(&mut bytes).map_err(unreadable)?;
    if bytes.len() as u64 > limit {
        return Err(too_long(bytes.len() as u64, ", and this one goes on"));
    }
    Ok(bytes)
}

/// SHA-256 of `bytes` in lower-case hexadecimal digits.
pub(super) fn sha256_hex(bytes: &[u8]) -> String {
    Sha256::digest(bytes).iter().map(|byte| format!("{byte:02x}")).collect()
}

/// One line of a text file of numbers, without its comment.
pub(super) struct Line<'a> {
    /// Counted from 1.
    pub(super) number: usize,
    text: &'a [u8],
}

impl<'a> Line<'a> {
    /// What white space separates.
    pub(super) fn tokens(&self) -> impl Iterator<Item = &'a [u8]> + use<'a> {
        self.text
            .split(u8::is_ascii_whitespace)
            .filter(|token| !token.is_empty())
    }
}

/// The lines of a text in any ASCII superset, whatever their ends; `#` starts a comment. Bytes beyond ASCII may stand in
/// comments only: elsewhere they are no numbers.
pub(super) fn lines(bytes: &[u8]) -> impl Iterator<Item = Line<'_>> {
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    bytes.split(|byte| *byte == b'\n').enumerate().map(|(i, line)| Line {
        number: i + 1,
        text: line.split(|byte| *byte == b'#').next().unwrap_or_default(),
    })
}

/// The finite number that `token` spells.
///
/// # Errors
/// What is wrong with it.
pub(super) fn number(token: &[u8], name: &str) -> Result<f64, String> {
    let value: Option<f64> = std::str::from_utf8(token).ok().and_then(|text| text.parse().ok());
    match value {
        Some(value) if value.is_finite() => Ok(value),
        _ => Err(format!("{} is not allowed: {name} is a finite number", shown(token))),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_are_known_before_files_are_read() {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("ten");
        std::fs::write(&path, b"0123456789").unwrap();
        assert_eq!(read_whole(&path, 10).unwrap(), b"0123456789");
        let text = read_whole(&path, 9).unwrap_err().to_string();
        assert!(
            text.ends_with("ten: 10 bytes are not allowed: a file of this kind has at most 9 bytes"),
            "{text}"
        );
        assert!(matches!(
            read_whole(&directory.path().join("none"), 9),
            Err(MeasuredError::Unreadable { .. })
        ));
        assert!(matches!(
            read_whole(directory.path(), 9),
            Err(MeasuredError::Unreadable { .. })
        ));
    }

    #[test]
    fn numbers_are_finite() {
        assert_eq!(number(b"-1.5e3", "x"), Ok(-1500.0));
        for token in ["nan", "inf", "1e999", "0x10", "1,5", "", "\u{fffd}"] {
            assert!(number(token.as_bytes(), "x").is_err(), "{token}");
        }
        let error = number(&[0xff; 100], "x").unwrap_err();
        assert!(
            error.contains("...\" is not allowed: x is a finite number") && error.len() < 200,
            "{error}"
        );
    }
}
