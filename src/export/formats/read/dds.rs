//! DDS: the headers, and the texels behind the one of Direct3D 10.

use super::said::Said;
use super::{Found, padded_kinds, ranges};
use crate::export::formats::dds::dxgi_format;
use ddsfile::{Dds, MiscFlag};

/// What the bytes of a file hold.
pub(super) fn decode(bytes: &[u8]) -> Result<Found, String> {
    let dds = Dds::read(bytes).map_err(|error| format!("its header is damaged or cut short: {error}"))?;
    let size = [dds.header.width, dds.header.height, dds.get_depth().max(1)].map(u64::from);
    let levels = dds.header.mip_map_count.unwrap_or(1);
    let layers = dds.header10.as_ref().map_or(1, |header| header.array_size);
    let is_cube = dds
        .header10
        .as_ref()
        .is_some_and(|header| header.misc_flag.contains(MiscFlag::TEXTURECUBE));
    let format = dds.header10.as_ref().map(|header| header.dxgi_format);
    let kind = padded_kinds()
        .filter(|_| levels <= 1 && layers <= 1 && !is_cube)
        .find(|(storage, channels)| format == Some(dxgi_format(*storage, *channels)));
    let mut texel = match (format, dds.get_d3d_format()) {
        (Some(format), _) => format!("{format:?}"),
        (None, Some(format)) => format!("{format:?}"),
        (None, None) => "no format of Direct3D".into(),
    };
    for (count, of) in [(layers, "layers"), (levels, "mip levels")] {
        if count > 1 {
            texel += &format!(", {count} {of}");
        }
    }
    if is_cube {
        texel += ", a cube";
    }
    Ok(Found {
        size,
        texel,
        storage: kind.map(|(storage, _)| storage),
        channels: match kind {
            Some((storage, channels)) => ranges(&dds.data, storage, channels, size)?,
            None => Vec::new(),
        },
        facts: Said::default(),
    })
}
