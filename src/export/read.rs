//! Files back into tables. Our own come back completely; of others it says what they hold.
//!
//! A file is input like any other: it may be cut short, damaged, or announce more than memory holds. What its header
//! announces is checked against fixed limits and against the length of the file before anything is allocated. Reading takes
//! at most the length of the file and [`MAX_SAMPLE_BYTES`] together, twice the latter for a table of ours, and a header a
//! hundred times [`MAX_HEADER_BYTES`].
//!
//! Samples in B44, DWA or several resolutions are not decoded. No table of worth is kept so, and on damaged blocks the
//! decoders at hand overflow (B44), allocate whatever the block asks for, which ends the process (DWA), or take one
//! resolution for another.

use super::attributes::{self, Facts};
use super::exr::{ERROR_LAYER, channel_names, sample_hash};
use super::formats::read::said::{Image, Said};
use super::{ExportError, sha256_hex};
use crate::regular;
use crate::spectrum::Channels;
use crate::table::Table;
use ::exr::image::read::image::ReadLayers;
use ::exr::image::read::layers::ReadChannels;
use ::exr::image::{AnyChannel, AnyChannels, FlatSamples, Layer};
use ::exr::meta::attribute::{AttributeValue, ChannelDescription, LevelMode, SampleType, Text};
use ::exr::meta::header::Header;
use ::exr::meta::{BlockDescription, MetaData};
use ::exr::prelude::Compression;
use glam::DVec3;
use std::io::{Cursor, Read};
use std::path::{Path, PathBuf};

/// Longest file that is read, in bytes.
pub const MAX_FILE_BYTES: u64 = 1 << 30;
/// Most pixels that a file may announce.
pub const MAX_PIXELS: u64 = 1 << 26;
/// Most bytes of samples that a file may announce.
pub const MAX_SAMPLE_BYTES: u64 = 1 << 30;
/// Most bytes that the headers of a file may take together.
pub const MAX_HEADER_BYTES: usize = 1 << 22;
/// The strongest compression believed: deflate reaches 1032 to 1.
pub(super) const MAX_COMPRESSION: u64 = 1100;
/// The least that a block of samples takes: its offset, its place and its length.
const CHUNK_BYTES: u64 = 16;

/// An OpenEXR file and what it holds.
#[derive(Debug, Clone, PartialEq)]
pub struct TableFile {
    /// Where it was found.
    pub path: PathBuf,
    /// Its length.
    pub bytes: u64,
    /// SHA-256 of the whole file, as in the manifest.
    pub sha256: String,
    /// What it holds.
    pub contents: Contents,
}

/// A table of ours, or any other image.
#[derive(Debug, Clone, PartialEq)]
pub enum Contents {
    /// Written by this program: values and errors are those stored, all facts as they were, the id the stem of the file.
    Table {
        /// The table; its values are exact in f32, and its errors count the rounding already.
        table: Box<Table>,
        /// Version of the program that wrote it.
        version: String,
    },
    /// No attributes of this program: of unknown origin.
    Foreign(Vec<ForeignLayer>),
}

/// One part of a file of unknown origin.
#[derive(Debug, Clone, PartialEq)]
pub struct ForeignLayer {
    /// Its name, if it has one.
    pub name: Option<String>,
    /// Width and height in pixels.
    pub size: [usize; 2],
    /// How its samples are compressed.
    pub compression: String,
    /// The program that wrote it, if the file says so.
    pub software: Option<String>,
    /// What it says of a texture of this program, see [`super::formats`]; empty where it is none.
    pub facts: Said,
    /// In the order of the file.
    pub channels: Vec<ForeignChannel>,
}

/// One channel of a file of unknown origin.
#[derive(Debug, Clone, PartialEq)]
pub struct ForeignChannel {
    /// Its name.
    pub name: String,
    /// `f16`, `f32` or `u32`.
    pub kind: &'static str,
    /// What its samples are; `None` when they were not decoded, see `compression` of the layer.
    pub samples: Option<SampleSummary>,
}

/// Samples of one channel of a file of unknown origin.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SampleSummary {
    /// Smallest and largest finite sample; `None` when there is none.
    pub range: Option<(f64, f64)>,
    /// Number of samples that are NaN or infinite.
    pub not_finite: u64,
}

/// Reads the OpenEXR file at `path`.
///
/// # Errors
/// [`ExportError::Io`] when the system refuses, [`ExportError::Unreadable`] when the file is no OpenEXR file, damaged,
/// cut short, larger than the limits of this module, or contradicts its own header.
pub fn read_exr(path: &Path) -> Result<TableFile, ExportError> {
    parse_exr(path, &read_limited(path)?)
}

/// The same from the bytes of the file, which messages call `path`, and whose stem is the id of a table.
///
/// # Errors
/// [`ExportError::Unreadable`] as [`read_exr`].
pub fn parse_exr(path: &Path, bytes: &[u8]) -> Result<TableFile, ExportError> {
    let id = path.file_stem().unwrap_or_default().to_string_lossy();
    let contents = decode(&id, bytes).map_err(|reason| unreadable(path, reason))?;
    Ok(TableFile {
        path: path.to_path_buf(),
        bytes: bytes.len() as u64,
        sha256: sha256_hex(bytes),
        contents,
    })
}

fn unreadable(path: &Path, reason: String) -> ExportError {
    let path = path.to_path_buf();
    ExportError::Unreadable { path, reason }
}

/// The bytes of a regular file that begins like OpenEXR. The first four are looked at alone, so that an archive given by
/// mistake is not read into memory.
fn read_limited(path: &Path) -> Result<Vec<u8>, ExportError> {
    let (file, _) = regular::open(path).map_err(ExportError::io("read", path))?;
    let mut bytes = Vec::new();
    let take = |most: u64, bytes: &mut Vec<u8>| {
        let read = (&file).take(most).read_to_end(bytes);
        read.map_err(ExportError::io("read", path))
    };
    take(4, &mut bytes)?;
    if bytes != ::exr::meta::magic_number::BYTES {
        return Err(unreadable(path, "it does not begin like an OpenEXR file".into()));
    }
    take(MAX_FILE_BYTES - 4, &mut bytes)?;
    if take(1, &mut Vec::new())? > 0 {
        return Err(unreadable(path, format!("it is longer than {MAX_FILE_BYTES} bytes")));
    }
    Ok(bytes)
}

/// What the bytes of a file hold, or what is wrong with them. A table is called `id`.
fn decode(id: &str, bytes: &[u8]) -> Result<Contents, String> {
    let head = &bytes[..bytes.len().min(MAX_HEADER_BYTES)];
    let meta = MetaData::read_from_buffered(Cursor::new(head), false).map_err(|error| {
        if head.len() < bytes.len() {
            format!("{error} (headers have at most {MAX_HEADER_BYTES} bytes)")
        } else {
            error.to_string()
        }
    })?;
    check_announced(&meta.headers, bytes.len() as u64)?;
    if let Some(header) = meta.headers.iter().find(|header| !is_decodable(header)) {
        return match attributes::is_ours(&header.own_attributes.other) {
            true => Err(format!(
                "its samples are kept with {} or in several resolutions, where tables are plain",
                header.compression
            )),
            false => meta
                .headers
                .iter()
                .map(undecoded)
                .collect::<Result<_, _>>()
                .map(Contents::Foreign),
        };
    }
    let image = ::exr::image::read::read()
        .no_deep_data()
        .largest_resolution_level()
        .all_channels()
        .all_layers()
        .all_attributes()
        .non_parallel()
        .from_buffered(Cursor::new(bytes))
        .map_err(|error| error.to_string())?;
    match image.layer_data.as_slice() {
        [layer] if attributes::is_ours(&layer.attributes.other) => our_table(id, layer),
        layers => {
            let layers: Result<Vec<ForeignLayer>, String> = meta.headers.iter().zip(layers).map(decoded).collect();
            layers.map(Contents::Foreign)
        }
    }
}

/// Whether the samples of a part can be decoded without trusting them.
fn is_decodable(header: &Header) -> bool {
    use Compression::{PIZ, PXR24, RLE, Uncompressed, ZIP1, ZIP16};
    let one_level = match header.blocks {
        BlockDescription::ScanLines => true,
        BlockDescription::Tiles(tiles) => tiles.level_mode == LevelMode::Singular,
    };
    one_level && matches!(header.compression, Uncompressed | RLE | ZIP1 | ZIP16 | PIZ | PXR24)
}

/// Refuses headers that announce more than the limits, or more than the file can hold.
fn check_announced(headers: &[Header], file_bytes: u64) -> Result<(), String> {
    let (mut samples, mut chunks) = (0u64, 0u64);
    for header in headers {
        let [width, height] = [header.layer_size.width(), header.layer_size.height()].map(|size| size as u64);
        let pixels = width.saturating_mul(height);
        if header.deep {
            return Err("it holds deep data, which is no table".into());
        }
        if pixels > MAX_PIXELS {
            return Err(format!(
                "its header announces {width} x {height} pixels, where {MAX_PIXELS} are allowed"
            ));
        }
        chunks = chunks.saturating_add(header.chunk_count as u64);
        samples = samples.saturating_add(pixels.saturating_mul(header.channels.bytes_per_pixel as u64));
    }
    if samples > MAX_SAMPLE_BYTES {
        return Err(format!(
            "its header announces {samples} bytes of samples, where {MAX_SAMPLE_BYTES} are allowed"
        ));
    }
    if chunks > file_bytes / CHUNK_BYTES {
        return Err(format!(
            "its header announces {chunks} blocks of samples, which {file_bytes} bytes of file cannot hold"
        ));
    }
    if samples > file_bytes.saturating_mul(MAX_COMPRESSION) {
        return Err(format!(
            "its header announces {samples} bytes of samples, which {file_bytes} bytes of file cannot hold"
        ));
    }
    Ok(())
}

type FlatLayer = Layer<AnyChannels<FlatSamples>>;

/// The table in a layer that carries our attributes.
fn our_table(id: &str, layer: &FlatLayer) -> Result<Contents, String> {
    let facts = Facts(&layer.attributes.other);
    facts.check_format()?;
    let found: Vec<&AnyChannel<FlatSamples>> = layer.channel_data.list.iter().collect();
    let channels = match found.len() {
        2 => Channels::Grey,
        4 => Channels::Pair,
        6 => Channels::Rgb,
        count => return Err(format!("it has {count} channels, where tables have 2, 4 or 6")),
    };
    let mut table = facts.table(id, channels)?;
    let size = [layer.size.width(), layer.size.height()];
    if size != table.size() {
        return Err(format!("its image is {size:?}, its axes say {:?}", table.size()));
    }
    let names = channel_names(channels);
    let (values, errors) = found.split_at(names.len());
    table.values = vectors(values, "", channels)?;
    table.errors = vectors(errors, ERROR_LAYER, channels)?;
    check_samples(&facts, &found)?;
    table.check().map_err(|error| error.to_string())?;
    check_stated(&facts, &table)?;
    Ok(Contents::Table {
        version: facts.string(attributes::VERSION)?,
        table: Box::new(table),
    })
}

/// Texels from the channels called `prefix` and the names of a table.
fn vectors(found: &[&AnyChannel<FlatSamples>], prefix: &str, channels: Channels) -> Result<Vec<DVec3>, String> {
    let mut texels = Vec::new();
    for (channel, &(name, index)) in found.iter().zip(channel_names(channels)) {
        let name = format!("{prefix}{name}");
        if channel.name.as_slice() != name.as_bytes() {
            return Err(format!("its channel {} should be {name}", channel.name));
        }
        let samples = f32_samples(channel)?;
        texels.resize(samples.len(), DVec3::ZERO);
        for (texel, &sample) in texels.iter_mut().zip(samples) {
            match channels {
                Channels::Grey => *texel = DVec3::splat(f64::from(sample)),
                // G comes first, and stands for the blue that nobody stores
                Channels::Pair if name.ends_with('G') => *texel = DVec3::splat(f64::from(sample)),
                Channels::Pair | Channels::Rgb => texel[index] = f64::from(sample),
            }
        }
    }
    Ok(texels)
}

fn f32_samples(channel: &AnyChannel<FlatSamples>) -> Result<&[f32], String> {
    match &channel.sample_data {
        FlatSamples::F32(samples) => Ok(samples),
        _ => Err(format!("its channel {} is not f32", channel.name)),
    }
}

/// Whether the samples are those that were written.
fn check_samples(facts: &Facts, channels: &[&AnyChannel<FlatSamples>]) -> Result<(), String> {
    let samples: Result<Vec<&[f32]>, String> = channels.iter().map(|channel| f32_samples(channel)).collect();
    if facts.string(attributes::SAMPLES)? == sample_hash(samples?.into_iter()) {
        return Ok(());
    }
    Err("its samples are not those that were written: their hash differs from the one in the header".into())
}

/// Whether the summaries in the header agree with the samples.
fn check_stated(facts: &Facts, table: &Table) -> Result<(), String> {
    let (min, max) = table.range();
    for (name, found) in [("min", min), ("max", max), ("maxTexelError", table.max_texel_error())] {
        let stated = facts.number(name)?;
        if stated != found {
            return Err(format!("attribute {name} is {stated}, the samples say {found}"));
        }
    }
    Ok(())
}

/// What the header of a foreign layer says.
fn undecoded(header: &Header) -> Result<ForeignLayer, String> {
    let channel = |channel: &ChannelDescription| ForeignChannel {
        name: channel.name.to_string(),
        kind: match channel.sample_type {
            SampleType::F16 => "f16",
            SampleType::F32 => "f32",
            SampleType::U32 => "u32",
        },
        samples: None,
    };
    Ok(ForeignLayer {
        name: header.own_attributes.layer_name.as_ref().map(Text::to_string),
        size: [header.layer_size.width(), header.layer_size.height()],
        compression: header.compression.to_string(),
        software: header.own_attributes.software_name.as_ref().map(Text::to_string),
        facts: texture_facts(header)?,
        channels: header.channels.list.iter().map(channel).collect(),
    })
}

/// The facts of a texture, if the header has any: attributes of text, as [`super::formats`] writes them.
fn texture_facts(header: &Header) -> Result<Said, String> {
    let attributes = &header.own_attributes.other;
    if !attributes.contains_key(&attributes::text("textureFormat")) {
        return Ok(Said::default());
    }
    let texts = attributes.iter().filter_map(|(name, value)| match value {
        AttributeValue::Text(text) => Some((name, text)),
        _ => None,
    });
    let software = header.own_attributes.software_name.as_ref();
    let software = software.map(|name| ("software".to_owned(), name.to_string()));
    let pairs = texts.map(|(name, value)| (name.to_string(), String::from_utf8_lossy(value.as_slice()).into_owned()));
    Said::new(pairs.chain(software))
}

/// What the header and the samples of a foreign layer say.
fn decoded((header, layer): (&Header, &FlatLayer)) -> Result<ForeignLayer, String> {
    let mut found = undecoded(header)?;
    for (channel, from) in found.channels.iter_mut().zip(&layer.channel_data.list) {
        channel.samples = Some(match &from.sample_data {
            FlatSamples::F16(samples) => summary(samples.iter().map(|sample| sample.to_f64())),
            FlatSamples::F32(samples) => summary(samples.iter().map(|&sample| f64::from(sample))),
            FlatSamples::U32(samples) => summary(samples.iter().map(|&sample| f64::from(sample))),
        });
    }
    let kinds: Vec<&str> = found.channels.iter().map(|channel| channel.kind).collect();
    let [width, height] = found.size.map(|size| size as u64);
    let image = Image {
        size: [width, height, 1],
        tiled: true,
        storage: kinds
            .first()
            .copied()
            .filter(|first| kinds.iter().all(|kind| kind == first)),
    };
    let mut samples: Vec<SampleSummary> = found.channels.iter().filter_map(|channel| channel.samples).collect();
    found.facts.check(&image, &mut samples)?;
    Ok(found)
}

/// Range of the finite samples and the number of all others.
fn summary(samples: impl Iterator<Item = f64>) -> SampleSummary {
    let (mut range, mut not_finite) = (None, 0);
    for sample in samples {
        if sample.is_finite() {
            let (min, max) = range.unwrap_or((sample, sample));
            range = Some((sample.min(min), sample.max(max)));
        } else {
            not_finite += 1;
        }
    }
    SampleSummary { range, not_finite }
}

#[cfg(test)]
mod tests;
