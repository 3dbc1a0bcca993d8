//! PNG with 16 or 8 bits, linear: gamma 1, no sRGB chunk, the facts as text chunks.
//!
//! One channel is greyscale. Two are red and green beside a blue of 0, as engines do it: greyscale with alpha would be multiplied
//! or thrown away by tools that take the second for coverage. Three and four are RGB and RGBA. Of three axes the slices stand
//! side by side. Many loaders cut 16 bits to 8 unless they are told otherwise, which turns unorm16 into unorm8.

use super::facts;
use super::texels::{tiled, tiled_size, tiling, unorm8, unorm16};
use crate::table::Storage;
use crate::table::texture::Texture;
use ::png::{BitDepth, ColorType, DeflateCompression, Encoder, ScaledFloat};

/// What our keywords begin with.
pub(super) const PREFIX: &str = "whitefurnace.";

/// The file of `texture`, whose storage is one of integers.
pub(super) fn encode(texture: &Texture) -> Result<Vec<u8>, String> {
    write(texture).map_err(|error| error.to_string())
}

fn write(texture: &Texture) -> Result<Vec<u8>, ::png::EncodingError> {
    let mut bytes = Vec::new();
    let [width, height] = tiled_size(texture).map(|size| size as u32); // at most 65536
    let mut encoder = Encoder::new(&mut bytes, width, height);
    let (color, depth) = (color(texture), depth(texture));
    encoder.set_color(color);
    encoder.set_depth(depth);
    // the bytes do not depend on the version of a compressor
    encoder.set_deflate_compression(DeflateCompression::NoCompression);
    encoder.set_source_gamma(ScaledFloat::from_scaled(100_000));
    for (name, value) in facts::list(texture, &layout(texture)) {
        let keyword = format!("{PREFIX}{name}");
        if value.is_ascii() {
            encoder.add_text_chunk(keyword, value)?;
        } else {
            // tEXt is Latin-1
            encoder.add_itxt_chunk(keyword, value)?;
        }
    }
    let mut writer = encoder.write_header()?;
    writer.write_image_data(&samples(texture, color.samples()))?;
    writer.finish()?;
    Ok(bytes)
}

fn color(texture: &Texture) -> ColorType {
    match texture.channels.len() {
        1 => ColorType::Grayscale,
        4 => ColorType::Rgba,
        _ => ColorType::Rgb,
    }
}

fn depth(texture: &Texture) -> BitDepth {
    match texture.storage {
        Storage::Unorm8 => BitDepth::Eight,
        _ => BitDepth::Sixteen,
    }
}

fn layout(texture: &Texture) -> String {
    match texture.channels.len() {
        2 => format!("{}; two channels as red and green, blue is 0", tiling(texture)),
        _ => tiling(texture),
    }
}

/// The samples, row by row, `count` per pixel, 16 bits big-endian.
fn samples(texture: &Texture, count: usize) -> Vec<u8> {
    let mut bytes = Vec::new();
    for texel in tiled(texture) {
        let fill = std::iter::repeat_n(&0.0, count - texel.len());
        for value in texel.iter().chain(fill) {
            match texture.storage {
                Storage::Unorm8 => bytes.push(unorm8(*value)),
                _ => bytes.extend(unorm16(*value).to_be_bytes()),
            }
        }
    }
    bytes
}
