//! DirectDraw Surface with the header of Direct3D 10, as a 2D or a volume texture without mipmaps.
//!
//! The format has no room for facts: a manifest or the JSON of [`super::Format::Raw`] has to say them. A table over one axis has
//! height 1.

use super::texels::{padded, padded_channels};
use crate::table::Storage;
use crate::table::texture::Texture;
use ddsfile::{
    AlphaMode, Caps, Caps2, D3D10ResourceDimension, Dds, DxgiFormat, HeaderFlags, NewDxgiParams, PixelFormatFlags,
};

/// Where the flags are: behind magic number and size.
const FLAGS: usize = 8;

/// The file of `texture`.
pub(super) fn encode(texture: &Texture) -> Result<Vec<u8>, String> {
    let is_volume = texture.axes.len() == 3;
    let [width, height, depth] = texture.size().map(|size| size as u32); // at most 16384
    let channels = padded_channels(texture);
    let mut dds = Dds::new_dxgi(NewDxgiParams {
        height,
        width,
        depth: is_volume.then_some(depth),
        format: dxgi_format(texture.storage, channels),
        mipmap_levels: None,
        array_layers: None,
        caps2: is_volume.then_some(Caps2::VOLUME),
        is_cubemap: false,
        resource_dimension: match is_volume {
            true => D3D10ResourceDimension::Texture3D,
            false => D3D10ResourceDimension::Texture2D,
        },
        alpha_mode: match texture.channels.len() {
            3 => AlphaMode::Opaque,
            // the fourth is data, no coverage
            4 => AlphaMode::Custom,
            _ => AlphaMode::Unknown,
        },
    })
    .map_err(|error| error.to_string())?;
    // as Direct3D's own tools write it: the number in the second header says everything, and bits per pixel nothing
    dds.header.spf.flags = PixelFormatFlags::FOURCC;
    dds.header.spf.rgb_bit_count = None;
    dds.data = padded(texture);
    if is_volume {
        dds.header.caps |= Caps::COMPLEX;
    }
    let mut bytes = Vec::new();
    dds.write(&mut bytes).map_err(|error| error.to_string())?;
    if is_volume {
        // the crate leaves the flag out for a volume of one slice
        for (byte, flag) in bytes[FLAGS..].iter_mut().zip(HeaderFlags::DEPTH.bits().to_le_bytes()) {
            *byte |= flag;
        }
    }
    Ok(bytes)
}

/// The format with so many channels, 1, 2 or 4.
pub(super) fn dxgi_format(storage: Storage, channels: usize) -> DxgiFormat {
    match (storage, channels) {
        (Storage::F32, 1) => DxgiFormat::R32_Float,
        (Storage::F32, 2) => DxgiFormat::R32G32_Float,
        (Storage::F32, _) => DxgiFormat::R32G32B32A32_Float,
        (Storage::F16, 1) => DxgiFormat::R16_Float,
        (Storage::F16, 2) => DxgiFormat::R16G16_Float,
        (Storage::F16, _) => DxgiFormat::R16G16B16A16_Float,
        (Storage::Unorm16, 1) => DxgiFormat::R16_UNorm,
        (Storage::Unorm16, 2) => DxgiFormat::R16G16_UNorm,
        (Storage::Unorm16, _) => DxgiFormat::R16G16B16A16_UNorm,
        (Storage::Unorm8, 1) => DxgiFormat::R8_UNorm,
        (Storage::Unorm8, 2) => DxgiFormat::R8G8_UNorm,
        (Storage::Unorm8, _) => DxgiFormat::R8G8B8A8_UNorm,
    }
}
