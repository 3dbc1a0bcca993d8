//! Textures back from files, as far as saying what they hold: size, storage, facts, and the range of each channel.
//!
//! A file is input like any other: what its header announces is checked against the length of the file and the limits of
//! [`crate::export::read`] before anything is allocated. Reading takes a few times the length of the file, of a PNG its pixels beside
//! it, and of facts, which have at most [`MAX_FACT_BYTES`], a hundred times their length. Facts that contradict the texels are those
//! of a damaged file, and refused.
//!
//! OpenEXR is read by [`crate::export::read::read_exr`].

pub(in crate::export) mod said;

mod dds;
mod ktx2;
mod listed;
mod png;
mod raw;

use super::Format;
use crate::export::read::{MAX_FILE_BYTES, MAX_HEADER_BYTES, SampleSummary};
use crate::export::{ExportError, sha256_hex};
use crate::regular;
use crate::table::Storage;
use half::f16;
use std::io::Read;
use std::path::{Path, PathBuf};

pub use listed::{Listed, listed_beside};
pub use said::Said;

/// Most bytes of facts, and of the JSON beside raw numbers.
pub const MAX_FACT_BYTES: usize = MAX_HEADER_BYTES;

/// A texture file and what it holds.
#[derive(Debug, Clone, PartialEq)]
pub struct TextureFile {
    /// The file with the texels.
    pub path: PathBuf,
    /// Its length.
    pub bytes: u64,
    /// SHA-256 of the whole file.
    pub sha256: String,
    /// Its format.
    pub format: Format,
    /// What it holds.
    pub contents: Found,
}

/// What a texture file holds.
#[derive(Debug, Clone, PartialEq)]
pub struct Found {
    /// Width, height and depth of the image in texels; PNG keeps slices side by side.
    pub size: [u64; 3],
    /// The format of a texel, as the file format calls it.
    pub texel: String,
    /// How a channel is kept, where the texels are in a format that this program writes.
    pub storage: Option<Storage>,
    /// The range of each channel, padding left out where facts tell; empty where texels are not decoded.
    pub channels: Vec<SampleSummary>,
    /// Facts of this program; none in files of others.
    pub facts: Said,
}

/// The format that the name of a file says, if it is one that [`read_texture`] reads; letters may be of either case.
pub fn format_of(path: &Path) -> Option<Format> {
    match path.extension()?.to_str()?.to_ascii_lowercase().as_str() {
        "ktx2" => Some(Format::Ktx2),
        "dds" => Some(Format::Dds),
        "png" => Some(Format::Png),
        "bin" | "json" => Some(Format::Raw),
        _ => None,
    }
}

/// Reads the texture at `path`: KTX 2.0, DDS, PNG, or raw numbers by either of their two files.
///
/// # Errors
/// [`ExportError::Io`] when the system refuses, [`ExportError::Unreadable`] when the file is too long, damaged, cut short, of
/// another format than its name says, or contradicts its own facts.
pub fn read_texture(path: &Path) -> Result<TextureFile, ExportError> {
    let format = format_of(path).ok_or_else(|| unreadable(path, NAMES.into()))?;
    if format != Format::Raw {
        let begins = |first: &[u8]| wrong_beginning(format, first).map_or(Ok(()), Err);
        return parse_texture(path, format, &limited(path, MAX_FILE_BYTES, &begins)?, &[]);
    }
    let [numbers, about] = ["bin", "json"].map(|end| match path.extension() {
        Some(found) if found.eq_ignore_ascii_case(end) => path.to_path_buf(),
        _ => path.with_extension(end),
    });
    let about_bytes = limited(&about, MAX_FACT_BYTES as u64, &|_| Ok(()))?;
    raw::check(&about_bytes).map_err(|reason| unreadable(&about, reason))?;
    parse_texture(
        &numbers,
        format,
        &limited(&numbers, MAX_FILE_BYTES, &|_| Ok(()))?,
        &about_bytes,
    )
}

const NAMES: &str = "its name ends with none of .ktx2, .dds, .png, .bin and .json";

/// The same from the bytes of a file, which messages call `path`, in `format`, and of raw numbers those of the JSON beside it.
///
/// # Errors
/// [`ExportError::Unreadable`] as [`read_texture`].
pub fn parse_texture(path: &Path, format: Format, bytes: &[u8], json: &[u8]) -> Result<TextureFile, ExportError> {
    let sha256 = sha256_hex(bytes);
    let contents = match (wrong_beginning(format, bytes), format) {
        (Some(reason), _) => Err(reason),
        (None, Format::Ktx2) => ktx2::decode(bytes),
        (None, Format::Dds) => dds::decode(bytes),
        (None, Format::Png) => png::decode(bytes),
        (None, Format::Raw) => raw::decode(json, bytes, &sha256),
        (None, Format::Exr | Format::Source(_)) => Err(NAMES.into()),
    };
    Ok(TextureFile {
        bytes: bytes.len() as u64,
        sha256,
        format,
        contents: contents.map_err(|reason| unreadable(path, reason))?,
        path: path.to_path_buf(),
    })
}

fn unreadable(path: &Path, reason: String) -> ExportError {
    let path = path.to_path_buf();
    ExportError::Unreadable { path, reason }
}

/// What every file of a format begins with.
const BEGINNINGS: [(Format, &str, &[u8]); 4] = [
    (Format::Ktx2, "KTX 2.0", &::ktx2::MAGIC),
    (Format::Dds, "DDS", b"DDS "),
    (Format::Png, "PNG", b"\x89PNG\r\n\x1a\n"),
    (Format::Exr, "OpenEXR", &::exr::meta::magic_number::BYTES),
];

/// What is wrong when a file begins with these bytes.
fn wrong_beginning(format: Format, bytes: &[u8]) -> Option<String> {
    let (_, name, beginning) = BEGINNINGS.into_iter().find(|(of, ..)| *of == format)?;
    if bytes.starts_with(beginning) {
        return None;
    }
    let other = BEGINNINGS.into_iter().find(|(.., other)| bytes.starts_with(other));
    Some(match other {
        Some((_, other, _)) => format!("it begins like {other}, where its name says {name}"),
        None => format!("it does not begin like {name}, which its name says it is"),
    })
}

/// The bytes of a regular file of limited length. The first few are looked at alone, so that an archive given by mistake is not read
/// into memory.
fn limited(path: &Path, most: u64, begins: &dyn Fn(&[u8]) -> Result<(), String>) -> Result<Vec<u8>, ExportError> {
    let (file, _) = regular::open(path).map_err(ExportError::io("read", path))?;
    let mut bytes = Vec::new();
    let take = |most: u64, bytes: &mut Vec<u8>| {
        let read = (&file).take(most).read_to_end(bytes);
        read.map_err(ExportError::io("read", path))
    };
    take(16, &mut bytes)?;
    begins(&bytes).map_err(|reason| unreadable(path, reason))?;
    take(most - 16, &mut bytes)?;
    if take(1, &mut Vec::new())? > 0 {
        return Err(unreadable(path, format!("it is longer than {most} bytes")));
    }
    Ok(bytes)
}

/// The storages and numbers of channels of textures that are padded for hardware.
fn padded_kinds() -> impl Iterator<Item = (Storage, usize)> {
    let of = |storage| [1, 2, 4].map(|channels| (storage, channels));
    Storage::ALL.into_iter().flat_map(of)
}

/// The range of each of `channels` little-endian channels, if `bytes` are as many as `size` asks for.
fn ranges(bytes: &[u8], storage: Storage, channels: usize, size: [u64; 3]) -> Result<Vec<SampleSummary>, String> {
    let texel = (channels * storage.bytes()) as u64;
    let expected = size.iter().try_fold(texel, |all, size| all.checked_mul(*size));
    if expected != Some(bytes.len() as u64) {
        let [width, height, depth] = size;
        return Err(format!(
            "it has {} bytes of texels, where {width} x {height} x {depth} texels of {texel} bytes are announced",
            bytes.len()
        ));
    }
    let numbers = bytes.chunks_exact(storage.bytes());
    Ok(summaries(numbers.map(|number| decode(number, storage)), channels))
}

/// The range of each of `count` channels, whose samples take turns.
fn summaries(samples: impl Iterator<Item = f64>, count: usize) -> Vec<SampleSummary> {
    let nothing = SampleSummary {
        range: None,
        not_finite: 0,
    };
    let mut all = vec![nothing; count];
    for (index, sample) in samples.enumerate() {
        let summary = &mut all[index % count];
        if sample.is_finite() {
            let (min, max) = summary.range.unwrap_or((sample, sample));
            summary.range = Some((min.min(sample), max.max(sample)));
        } else {
            summary.not_finite += 1;
        }
    }
    all
}

/// A number of as many bytes as `storage` has.
fn decode(number: &[u8], storage: Storage) -> f64 {
    match (storage, number) {
        (Storage::F32, &[a, b, c, d]) => f64::from(f32::from_le_bytes([a, b, c, d])),
        (Storage::F16, &[a, b]) => f16::from_le_bytes([a, b]).to_f64(),
        (Storage::Unorm16, &[a, b]) => f64::from(u16::from_le_bytes([a, b])) / 65535.0,
        (Storage::Unorm8, &[a]) => f64::from(a) / 255.0,
        _ => f64::NAN,
    }
}
