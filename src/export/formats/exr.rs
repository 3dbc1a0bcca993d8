//! A texture as OpenEXR: scanlines, not compressed, channels `Y`, `R G`, `R G B` or `R G B A`, HALF or FLOAT by the storage.
//!
//! Unlike the file of a table it has no error layer and cannot become a table again; its facts are strings. Of three axes the
//! slices stand side by side. `A` is the fourth channel as it is: nothing is multiplied by it.

use super::facts;
use super::texels::{tiled, tiled_size, tiling};
use crate::export::attributes::text;
use crate::export::exr::sort_header;
use crate::table::Storage;
use crate::table::texture::Texture;
use ::exr::image::{AnyChannel, AnyChannels, Blocks, Encoding, FlatSamples, Image, Layer};
use ::exr::meta::attribute::{AttributeValue, LineOrder};
use ::exr::meta::header::LayerAttributes;
use ::exr::prelude::{Compression, WritableImage};
use half::f16;
use std::io::Cursor;

/// The file of `texture`, whose storage is one of floats.
pub(super) fn encode(texture: &Texture) -> Result<Vec<u8>, String> {
    let mut facts = facts::list(texture, &tiling(texture));
    let software = facts.iter().position(|(name, _)| name == "software");
    let software = software.map(|index| facts.remove(index).1);
    let header = LayerAttributes {
        software_name: software.map(|name| text(&name)),
        other: facts
            .iter()
            .map(|(name, value)| (text(name), AttributeValue::Text(text(value))))
            .collect(),
        ..LayerAttributes::default()
    };
    let names: &[&str] = match texture.channels.len() {
        1 => &["Y"],
        _ => &["R", "G", "B", "A"],
    };
    let channel = |(index, name): (usize, &&str)| {
        let values = tiled(texture).map(|texel| texel[index]);
        let samples = match texture.storage {
            Storage::F16 => FlatSamples::F16(values.map(f16::from_f64).collect()),
            _ => FlatSamples::F32(values.map(|value| value as f32).collect()),
        };
        AnyChannel::new(*name, samples)
    };
    let list = names.iter().take(texture.channels.len()).enumerate().map(channel);
    let encoding = Encoding {
        compression: Compression::Uncompressed,
        blocks: Blocks::ScanLines,
        line_order: LineOrder::Increasing,
    };
    let [width, height] = tiled_size(texture);
    let layer = Layer::new((width, height), header, encoding, AnyChannels::sort(list.collect()));
    let mut bytes = Vec::new();
    Image::from_layer(layer)
        .write()
        .non_parallel()
        .to_buffered(Cursor::new(&mut bytes))
        .map_err(|error| error.to_string())?;
    sort_header(&mut bytes).ok_or("its own header cannot be parsed")?;
    Ok(bytes)
}
