//! Textures: KTX 2.0, DDS and PNG by what they begin with, and anything else as the JSON beside raw numbers, a zero, and the numbers.

use crate::seeds::tables;
use std::path::Path;
use whitefurnace::export::formats::read::parse_texture;
use whitefurnace::export::formats::{Format, files};
use whitefurnace::table::Storage;
use whitefurnace::table::texture::Texture;

pub(crate) const WORDS: [&str; 24] = [
    "whitefurnace.size\0[1,1,1]\0",
    "whitefurnace.range\0[0.0,1.0]\0",
    "whitefurnace.axes.0.size\x001\0",
    "whitefurnace.channels.4.name\0x\0",
    "whitefurnace.textureFormat\x002\0",
    "\"size\": [18446744073709551615, 2, 1]",
    "\"channels\": [{}]",
    "\"axes\": [[[[",
    "\"storage\": \"unorm8\"",
    "\"sha256\": \"\"",
    "\"byteOrder\": \"little-endian\"",
    "DX10",
    "DXT1",
    "IHDR",
    "PLTE",
    "tRNS",
    "tEXt",
    "zTXt",
    "iTXt",
    "iCCP",
    "acTL",
    "fcTL",
    "IDAT",
    "IEND",
];

/// The tables of the OpenEXR seeds, in all formats and storages.
pub(crate) fn seeds() -> Vec<Vec<u8>> {
    let mut all = Vec::new();
    for table in tables() {
        for storage in Storage::ALL.into_iter().filter(|storage| table.fits(*storage)) {
            let texture = Texture::of(&table, storage).unwrap();
            for format in [Format::Ktx2, Format::Dds, Format::Png, Format::Raw] {
                if format.takes(storage) {
                    let mut parts: Vec<Vec<u8>> =
                        files(&texture, format).unwrap().into_iter().map(|(_, b)| b).collect();
                    parts.reverse();
                    all.push(parts.join(&0));
                }
            }
        }
    }
    all
}

pub(crate) fn parse(bytes: &[u8]) -> Result<String, String> {
    let begins = [
        (Format::Ktx2, &b"\xabKTX 20"[..]),
        (Format::Dds, b"DDS "),
        (Format::Png, b"\x89PNG"),
    ];
    let found = begins.into_iter().find(|(_, begin)| bytes.starts_with(begin));
    let format = found.map_or(Format::Raw, |(format, _)| format);
    let (numbers, json) = match format {
        Format::Raw => {
            let end = bytes.iter().position(|byte| *byte == 0).unwrap_or(bytes.len());
            (bytes.get(end + 1..).unwrap_or_default(), &bytes[..end])
        }
        _ => (bytes, &b""[..]),
    };
    let file = parse_texture(Path::new("fuzz"), format, numbers, json).map_err(|error| error.to_string())?;
    let contents = file.contents;
    for channel in &contents.channels {
        let (min, max) = channel.range.unwrap_or_default();
        assert!(min <= max && min.is_finite() && max.is_finite(), "{channel:?}");
    }
    let is_ours = !contents.facts.is_empty();
    if is_ours {
        let axes = contents.facts.list("axes");
        assert!((1..=3).contains(&axes.len()));
        let count = contents.facts.list("channels").len();
        assert!(contents.channels.is_empty() || contents.channels.len() == count);
        assert!(contents.channels.iter().all(|channel| channel.not_finite == 0));
    }
    serde_json::to_string(&contents.facts.tree()).unwrap();
    Ok(format!(
        "{} {} {is_ours} {}",
        format.name(),
        contents.channels.len(),
        contents.texel.len()
    ))
}
