//! KTX 2.0: header, level index, key/value data and level 0. The data format descriptor is not looked at: the number of the format
//! says the same, and the parser of the crate panics on damaged ones.

use super::said::{Image, Said};
use super::{Found, MAX_FACT_BYTES, padded_kinds, ranges};
use crate::export::formats::ktx2::{PREFIX, vulkan_format};
use ::ktx2::{Header, LevelIndex};

/// What the bytes of a file hold.
pub(super) fn decode(bytes: &[u8]) -> Result<Found, String> {
    const CUT: &str = "it is cut short within its header";
    let header = Header::from_bytes(bytes.first_chunk().ok_or(CUT)?).map_err(|error| error.to_string())?;
    let level = bytes.get(Header::LENGTH..).and_then(<[u8]>::first_chunk).ok_or(CUT)?;
    let level = LevelIndex::from_bytes(level);
    let part = |offset: u64, length: u64| {
        let [start, end] = [Some(offset), offset.checked_add(length)].map(|at| usize::try_from(at?).ok());
        bytes.get(start?..end?)
    };
    let (offset, length) = (header.index.kvd_byte_offset, header.index.kvd_byte_length);
    let pairs = part(offset.into(), length.into()).ok_or("its key/value data lie beyond its end")?;
    let texels = part(level.byte_offset, level.byte_length).ok_or("its texels lie beyond its end")?;
    let size = [
        header.pixel_width,
        header.pixel_height.max(1),
        header.pixel_depth.max(1),
    ]
    .map(u64::from);
    let is_plain = header.supercompression_scheme.is_none() && header.layer_count <= 1 && header.face_count == 1;
    let kind = padded_kinds()
        .filter(|_| is_plain)
        .find(|(storage, channels)| header.format == Some(vulkan_format(*storage, *channels)));
    let mut channels = match kind {
        Some((storage, channels)) => ranges(texels, storage, channels, size)?,
        None => Vec::new(),
    };
    let facts = Said::new(key_values(pairs)?)?;
    let storage = kind.map(|(storage, _)| storage);
    let image = Image {
        size,
        tiled: false,
        storage: storage.map(|storage| storage.name()),
    };
    facts.check(&image, &mut channels)?;
    Ok(Found {
        size,
        texel: texel(&header),
        storage,
        channels,
        facts,
    })
}

/// What the header says of texels.
fn texel(header: &Header) -> String {
    let mut text = match header.format {
        Some(format) => format!("{format:?}"),
        None => "no Vulkan format".into(),
    };
    if let Some(scheme) = header.supercompression_scheme {
        text += &format!(", supercompressed by {scheme:?}");
    }
    for (count, of) in [
        (header.layer_count, "layers"),
        (header.face_count, "faces"),
        (header.level_count, "mip levels"),
    ] {
        if count > 1 {
            text += &format!(", {count} {of}");
        }
    }
    text
}

/// Our names and values among the key/value data.
fn key_values(bytes: &[u8]) -> Result<Vec<(String, String)>, String> {
    if bytes.len() > MAX_FACT_BYTES {
        return Err(format!("its key/value data take more than {MAX_FACT_BYTES} bytes"));
    }
    let (mut pairs, mut rest) = (Vec::new(), bytes);
    while !rest.is_empty() {
        let at = bytes.len() - rest.len();
        let damaged = || format!("its key/value data are damaged {at} bytes from their start");
        let length = rest.first_chunk().ok_or_else(damaged)?;
        let length = usize::try_from(u32::from_le_bytes(*length)).map_err(|_| damaged())?;
        let pair = rest[4..].get(..length).ok_or_else(damaged)?;
        let end = pair.iter().position(|byte| *byte == 0).ok_or_else(damaged)?;
        let (key, value) = (&pair[..end], &pair[end + 1..]);
        if let Some(name) = key.strip_prefix(PREFIX.as_bytes()) {
            let value = value.strip_suffix(b"\0").unwrap_or(value);
            let [name, value] = [name, value].map(|part| std::str::from_utf8(part).map_err(|_| damaged()));
            pairs.push((name?.to_owned(), value?.to_owned()));
        }
        // pairs are padded to 4 bytes, the last one perhaps not
        rest = rest[4..].get(length.next_multiple_of(4)..).unwrap_or_default();
    }
    Ok(pairs)
}
