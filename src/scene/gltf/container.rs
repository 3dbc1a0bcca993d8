//! The binary container, `.glb`: a header, a chunk of JSON, and chunks that materials have no need of.
//!
//! All numbers are little-endian u32. The header is the magic `glTF`, the version 2 and the length of all; a chunk is its
//! length, its type and its data [Khronos 2021, section 4.4].

use super::MOST_JSON;
use super::place::{Notes, Problem};
use crate::scene::error::SceneError;
use crate::scene::too_large;
use std::io::{self, Read, Seek, SeekFrom};

/// What a container begins with.
pub(in crate::scene) const MAGIC: &[u8] = b"glTF";

/// Where the data of the first chunk begin.
pub(super) const JSON_OFFSET: u64 = 20;

const JSON: u32 = u32::from_le_bytes(*b"JSON");
const BIN: u32 = u32::from_le_bytes(*b"BIN\0");

/// Most chunks whose headers are looked at; two have a meaning.
const MOST_CHUNKS: usize = 16;

/// The JSON of the container in `file`; of other chunks no more than their headers are read.
pub(super) fn json(file: &mut (impl Read + Seek), source: &str, notes: &mut Notes) -> Result<Vec<u8>, SceneError> {
    let unreadable = |reason| SceneError::Unreadable {
        path: source.to_owned(),
        reason,
    };
    let found = read(file, notes).map_err(unreadable)?;
    found.map_err(|refused| match refused {
        Refused::Wrong(problem) => problem.of(source),
        Refused::TooLarge => too_large(source, "bytes of JSON", MOST_JSON),
    })
}

/// Why there is no JSON, though the system did nothing wrong.
enum Refused {
    Wrong(Problem),
    TooLarge,
}

fn read(file: &mut (impl Read + Seek), notes: &mut Notes) -> io::Result<Result<Vec<u8>, Refused>> {
    let refused = |offset: u64, message: String| Ok(Err(Refused::Wrong(Problem::new(byte(offset), message))));
    let actual = file.seek(SeekFrom::End(0))?;
    file.rewind()?;
    let header = up_to(file, 12)?;
    if !header.starts_with(MAGIC) {
        return refused(
            0,
            "does not begin a binary glTF, whose first four bytes are `glTF`".into(),
        );
    }
    let (Some(version), Some(stated)) = (number(&header, 4), number(&header, 8)) else {
        return refused(actual, "ends the file within the header, which has 12 bytes".into());
    };
    if version != 2 {
        return refused(
            4,
            format!("states the version {version} of the container, which is not allowed: it is 2"),
        );
    }
    if u64::from(stated) != actual {
        notes.add(
            &byte(8),
            &format!("states a length of {stated} bytes, and the file has {actual}"),
        );
    }
    let chunk = up_to(file, 8)?;
    let (Some(length), Some(kind)) = (number(&chunk, 0), number(&chunk, 4)) else {
        return refused(actual, "ends the file before the chunk of JSON".into());
    };
    if kind != JSON {
        return refused(
            12,
            format!("begins a chunk of type 0x{kind:08x}, which is not allowed: the first is JSON"),
        );
    }
    if length == 0 {
        return refused(12, "begins a chunk of JSON without any".into());
    }
    if length as usize > MOST_JSON {
        return Ok(Err(Refused::TooLarge));
    }
    let json = up_to(file, u64::from(length))?;
    if json.len() < length as usize {
        return refused(
            actual,
            format!("ends the file within the chunk of JSON, which has {length} bytes"),
        );
    }
    unaligned(JSON_OFFSET - 8, length, notes);
    rest(file, JSON_OFFSET + u64::from(length), actual.min(stated.into()), notes)?;
    Ok(Ok(json))
}

/// Looks at the headers of the chunks from `start` to `end`.
fn rest(file: &mut (impl Read + Seek), start: u64, end: u64, notes: &mut Notes) -> io::Result<()> {
    let mut at = start;
    for index in 1..MOST_CHUNKS {
        if at >= end {
            return Ok(());
        }
        file.seek(SeekFrom::Start(at))?;
        let chunk = up_to(file, 8)?;
        let (Some(length), Some(kind)) = (number(&chunk, 0), number(&chunk, 4)) else {
            notes.add(&byte(at), "begins a chunk whose header the end of the file cuts off");
            return Ok(());
        };
        match kind {
            BIN if index == 1 => {}
            BIN => notes.add(
                &byte(at),
                "begins a chunk of buffers that is not the second of all; it was passed over",
            ),
            JSON => notes.add(&byte(at), "begins a second chunk of JSON; it was passed over"),
            other => notes.add(
                &byte(at),
                &format!("begins a chunk of the unknown type 0x{other:08x}; it was passed over"),
            ),
        }
        unaligned(at, length, notes);
        let next = at + 8 + u64::from(length);
        if next > end {
            notes.add(
                &byte(at),
                &format!("begins a chunk of {length} bytes, more than there are"),
            );
        }
        at = next;
    }
    notes.add(
        &byte(at),
        &format!("and what follows was not looked at: there are more than {MOST_CHUNKS} chunks"),
    );
    Ok(())
}

fn unaligned(at: u64, length: u32, notes: &mut Notes) {
    if !length.is_multiple_of(4) {
        notes.add(
            &byte(at),
            &format!("begins a chunk of {length} bytes, which is no multiple of 4"),
        );
    }
}

fn byte(offset: u64) -> String {
    format!("byte {offset}")
}

/// The next `count` bytes, or as many as there are.
fn up_to(file: &mut impl Read, count: u64) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    file.take(count).read_to_end(&mut bytes)?;
    Ok(bytes)
}

/// The number at `offset`.
fn number(bytes: &[u8], offset: usize) -> Option<u32> {
    let four = bytes.get(offset..offset + 4)?;
    Some(u32::from_le_bytes(four.try_into().ok()?))
}
