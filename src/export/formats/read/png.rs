//! PNG: text chunks and pixels.

use super::said::{Image, Said};
use super::{Found, summaries};
use crate::export::formats::png::PREFIX;
use crate::export::read::{MAX_COMPRESSION, MAX_SAMPLE_BYTES};
use crate::table::Storage;
use ::png::{BitDepth, ColorType, Decoder, Info, Limits};
use std::io::Cursor;

/// What the bytes of a file hold.
pub(super) fn decode(bytes: &[u8]) -> Result<Found, String> {
    let most = usize::try_from(MAX_SAMPLE_BYTES).unwrap_or(usize::MAX);
    let mut decoder = Decoder::new_with_limits(Cursor::new(bytes), Limits { bytes: most });
    decoder.set_ignore_iccp_chunk(true); // compressed, and of no use
    let mut reader = decoder.read_info().map_err(|error| error.to_string())?;
    let length = reader.output_buffer_size().unwrap_or(usize::MAX);
    let believed = bytes
        .len()
        .saturating_mul(usize::try_from(MAX_COMPRESSION).unwrap_or(usize::MAX));
    if length > most.min(believed) {
        return Err(format!(
            "it announces {length} bytes of pixels, which {} bytes of file cannot hold, or more than the {most} allowed",
            bytes.len()
        ));
    }
    let mut pixels = vec![0; length];
    reader.next_frame(&mut pixels).map_err(|error| error.to_string())?;
    // text may stand behind the pixels
    reader.finish().map_err(|error| error.to_string())?;
    let info = reader.info();
    let facts = Said::new(texts(info)?)?;
    let (color, depth) = (info.color_type, info.bit_depth);
    let count = color.samples();
    let (storage, mut channels) = match (color, depth) {
        (ColorType::Indexed, _) => (None, Vec::new()),
        (_, BitDepth::Sixteen) => {
            let pairs = pixels
                .chunks_exact(2)
                .map(|pair| u16::from_be_bytes([pair[0], pair[1]]));
            let samples = pairs.map(|sample| f64::from(sample) / 65535.0);
            (Some(Storage::Unorm16), summaries(samples, count))
        }
        (_, BitDepth::Eight) => {
            let samples = pixels.iter().map(|byte| f64::from(*byte) / 255.0);
            (Some(Storage::Unorm8), summaries(samples, count))
        }
        _ => (None, Vec::new()),
    };
    let size = [info.width.into(), info.height.into(), 1];
    let image = Image {
        size,
        tiled: true,
        storage: storage.map(Storage::name),
    };
    facts.check(&image, &mut channels)?;
    Ok(Found {
        size,
        texel: format!("{color:?}, {} bits", depth as u8),
        storage,
        channels,
        facts,
    })
}

/// Our names and values among the texts that are not compressed.
fn texts(info: &Info) -> Result<Vec<(String, String)>, String> {
    let mut pairs = Vec::new();
    for text in &info.uncompressed_latin1_text {
        if let Some(name) = text.keyword.strip_prefix(PREFIX) {
            pairs.push((name.to_owned(), text.text.clone()));
        }
    }
    for text in info.utf8_text.iter().filter(|text| !text.compressed) {
        if let Some(name) = text.keyword.strip_prefix(PREFIX) {
            pairs.push((name.to_owned(), text.get_text().map_err(|error| error.to_string())?));
        }
    }
    Ok(pairs)
}
