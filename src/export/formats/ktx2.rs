//! KTX 2.0: header, one mip level, the data format descriptor, and the facts as key/value data.
//!
//! Texels are not supercompressed, transfer is linear, alpha straight. A table over one axis is an image of height 1: engines load
//! 2D textures everywhere and 1D textures hardly anywhere, WebGL not at all. Keys are those of [`super::facts`] behind
//! `whitefurnace.`, beside `KTXorientation`, row 0 at the top, and `KTXwriter`.

use super::facts;
use super::texels::{padded, padded_channels, padding};
use crate::export::{SOFTWARE, VERSION};
use crate::table::Storage;
use crate::table::texture::Texture;
use ::ktx2::dfd::{Basic, Block};
use ::ktx2::{Format, Header, Index, LevelIndex};

/// What our keys begin with.
pub(super) const PREFIX: &str = "whitefurnace.";

/// The file of `texture`.
pub(super) fn encode(texture: &Texture) -> Result<Vec<u8>, String> {
    let format = vulkan_format(texture.storage, padded_channels(texture));
    let (descriptor, type_size) = Basic::from_format(format).map_err(|error| format!("{error:?}"))?;
    let descriptor = Block::Basic(descriptor).to_vec();
    let pairs = key_values(texture);
    let texels = padded(texture);

    let dfd_offset = Header::LENGTH + LevelIndex::LENGTH;
    let dfd_length = 4 + descriptor.len(); // its length comes first
    let kvd_offset = dfd_offset + dfd_length;
    // the least common multiple of 4 and the size of a texel, a power of two
    let alignment = (padded_channels(texture) * texture.storage.bytes()).max(4);
    let start = (kvd_offset + pairs.len()).next_multiple_of(alignment);

    let small = |size: usize| u32::try_from(size).map_err(|_| format!("{size} does not fit 32 bits"));
    let [width, height, depth] = texture.size();
    let header = Header {
        format: Some(format),
        type_size,
        pixel_width: small(width)?,
        pixel_height: small(height)?,
        pixel_depth: if texture.axes.len() == 3 { small(depth)? } else { 0 },
        layer_count: 0,
        face_count: 1,
        level_count: 1,
        supercompression_scheme: None,
        index: Index {
            dfd_byte_offset: small(dfd_offset)?,
            dfd_byte_length: small(dfd_length)?,
            kvd_byte_offset: small(kvd_offset)?,
            kvd_byte_length: small(pairs.len())?,
            sgd_byte_offset: 0,
            sgd_byte_length: 0,
        },
    };
    let level = LevelIndex {
        byte_offset: start as u64,
        byte_length: texels.len() as u64,
        uncompressed_byte_length: texels.len() as u64,
    };
    let mut bytes = header.as_bytes().to_vec();
    bytes.extend(level.as_bytes());
    bytes.extend(small(dfd_length)?.to_le_bytes());
    bytes.extend(descriptor);
    bytes.extend(pairs);
    bytes.resize(start, 0);
    bytes.extend(texels);
    Ok(bytes)
}

/// The format with so many channels, 1, 2 or 4.
pub(super) fn vulkan_format(storage: Storage, channels: usize) -> Format {
    match (storage, channels) {
        (Storage::F32, 1) => Format::R32_SFLOAT,
        (Storage::F32, 2) => Format::R32G32_SFLOAT,
        (Storage::F32, _) => Format::R32G32B32A32_SFLOAT,
        (Storage::F16, 1) => Format::R16_SFLOAT,
        (Storage::F16, 2) => Format::R16G16_SFLOAT,
        (Storage::F16, _) => Format::R16G16B16A16_SFLOAT,
        (Storage::Unorm16, 1) => Format::R16_UNORM,
        (Storage::Unorm16, 2) => Format::R16G16_UNORM,
        (Storage::Unorm16, _) => Format::R16G16B16A16_UNORM,
        (Storage::Unorm8, 1) => Format::R8_UNORM,
        (Storage::Unorm8, 2) => Format::R8G8_UNORM,
        (Storage::Unorm8, _) => Format::R8G8B8A8_UNORM,
    }
}

/// Keys and values, each ended by a zero, each pair padded to 4 bytes, sorted by the bytes of the keys.
fn key_values(texture: &Texture) -> Vec<u8> {
    let facts = facts::list(texture, padding(texture)).into_iter();
    let mut pairs: Vec<(String, String)> = facts.map(|(key, value)| (format!("{PREFIX}{key}"), value)).collect();
    let orientation = if texture.axes.len() == 3 { "rdi" } else { "rd" };
    pairs.push(("KTXorientation".into(), orientation.into()));
    pairs.push(("KTXwriter".into(), format!("{SOFTWARE} {VERSION}")));
    pairs.sort();
    let mut bytes = Vec::new();
    for (key, value) in pairs {
        let length = key.len() + value.len() + 2;
        bytes.extend((length as u32).to_le_bytes());
        bytes.extend([key.as_bytes(), b"\0", value.as_bytes(), b"\0"].concat());
        bytes.resize(bytes.len().next_multiple_of(4), 0);
    }
    bytes
}
