//! Texels as bytes.

use crate::table::Storage;
use crate::table::texture::Texture;
use half::f16;

/// What pads three channels to four, as graphics hardware has no textures of three.
pub(super) const PADDED: &str = "padded to 4 channels: the last is 1 and means nothing";
/// Where nothing is to be said.
pub(super) const PLAIN: &str = "as they are";

/// The channels of a texel as hardware keeps them: three become four.
pub(super) fn padded_channels(texture: &Texture) -> usize {
    match texture.channels.len() {
        3 => 4,
        count => count,
    }
}

/// What to say of [`padded`] texels.
pub(super) fn padding(texture: &Texture) -> &'static str {
    if padded_channels(texture) == texture.channels.len() {
        PLAIN
    } else {
        PADDED
    }
}

/// All texels in their order, little-endian, three channels padded to four by 1.
pub(super) fn padded(texture: &Texture) -> Vec<u8> {
    let mut bytes = Vec::new();
    for texel in texture.values.chunks(texture.channels.len()) {
        let fill = std::iter::repeat_n(&1.0, padded_channels(texture) - texel.len());
        for value in texel.iter().chain(fill) {
            put(&mut bytes, texture.storage, *value);
        }
    }
    bytes
}

/// All values in their order, little-endian.
pub(super) fn plain(texture: &Texture) -> Vec<u8> {
    let mut bytes = Vec::new();
    for value in &texture.values {
        put(&mut bytes, texture.storage, *value);
    }
    bytes
}

/// Appends a value that `storage` holds exactly.
fn put(bytes: &mut Vec<u8>, storage: Storage, value: f64) {
    match storage {
        Storage::F32 => bytes.extend((value as f32).to_le_bytes()),
        Storage::F16 => bytes.extend(f16::from_f64(value).to_le_bytes()),
        Storage::Unorm16 => bytes.extend(unorm16(value).to_le_bytes()),
        Storage::Unorm8 => bytes.push(unorm8(value)),
    }
}

/// The step of a 16-bit integer that stands for `value`.
pub(super) fn unorm16(value: f64) -> u16 {
    (value * 65535.0).round() as u16
}

/// The step of an 8-bit integer that stands for `value`.
pub(super) fn unorm8(value: f64) -> u8 {
    (value * 255.0).round() as u8
}

/// What to say of the image of [`tiled`].
pub(super) fn tiling(texture: &Texture) -> String {
    let [width, _, depth] = texture.size();
    match texture.axes.len() {
        3 => format!(
            "{depth} slices side by side: slice z begins at column {width}*z, so that a lookup must not filter across its edges"
        ),
        _ => PLAIN.into(),
    }
}

/// Width and height of an image that shows the slices of three axes side by side.
pub(super) fn tiled_size(texture: &Texture) -> [usize; 2] {
    let [width, height, depth] = texture.size();
    [width * depth, height]
}

/// The texels of that image, row by row.
pub(super) fn tiled(texture: &Texture) -> impl Iterator<Item = &[f64]> {
    let [width, height, depth] = texture.size();
    (0..height).flat_map(move |y| (0..depth).flat_map(move |z| (0..width).map(move |x| texture.texel([x, y, z]))))
}
