//! A table as the bytes of an OpenEXR file.
//!
//! One part, scanlines, f32 channels `Y`, `R G` or `R G B`, and the per-texel error as a second layer in OpenEXR's sense:
//! channels `error.Y` or `error.R error.G error.B` of the same part. A second part would say the same, but many loaders
//! of engines refuse multi-part files altogether, and those that read only `R G B` never notice a layer.
//!
//! Samples are not compressed. Smooth tables of floats shrink by little, a few kilobytes each; in return the bytes do
//! not depend on the version of a compressor and the smallest of loaders reads them.

use super::{ExportError, SOFTWARE, attributes, sha256_hex};
use crate::spectrum::Channels;
use crate::table::Table;
use ::exr::image::{AnyChannel, AnyChannels, Blocks, Encoding, FlatSamples, Image, Layer};
use ::exr::meta::attribute::LineOrder;
use ::exr::meta::header::LayerAttributes;
use ::exr::prelude::{Compression, WritableImage};
use std::io::Cursor;

/// Channel names of the values and, with `error.` before them, of the errors. In the order of a file: alphabetical.
pub(super) fn channel_names(channels: Channels) -> &'static [(&'static str, usize)] {
    match channels {
        Channels::Grey => &[("Y", 0)],
        Channels::Pair => &[("G", 1), ("R", 0)],
        Channels::Rgb => &[("B", 2), ("G", 1), ("R", 0)],
    }
}

/// Prefix of the channels that hold errors.
pub(super) const ERROR_LAYER: &str = "error.";

/// The file of `table`: the same bytes for the same table, always, whatever its id.
///
/// # Errors
/// [`ExportError::Table`] when the table fails its checks, [`ExportError::Encode`] when the format cannot hold it.
pub fn to_bytes(table: &Table) -> Result<Vec<u8>, ExportError> {
    table.check()?;
    let encode_error = |reason: String| ExportError::Encode {
        id: table.id.clone(),
        reason,
    };
    let channels = file_channels(table);
    let hash = sample_hash(channels.iter().map(|(_, samples)| samples.as_slice()));
    let header = LayerAttributes {
        software_name: Some(attributes::text(&format!("{SOFTWARE} {}", super::VERSION))),
        other: attributes::from_table(table, &hash),
        ..LayerAttributes::default()
    };
    let list = channels
        .into_iter()
        .map(|(name, samples)| AnyChannel::new(name.as_str(), FlatSamples::F32(samples)));
    let encoding = Encoding {
        compression: Compression::Uncompressed,
        blocks: Blocks::ScanLines,
        line_order: LineOrder::Increasing,
    };
    let [width, height] = table.size();
    let layer = Layer::new((width, height), header, encoding, AnyChannels::sort(list.collect()));
    let mut bytes = Vec::new();
    Image::from_layer(layer)
        .write()
        .non_parallel()
        .to_buffered(Cursor::new(&mut bytes))
        .map_err(|error| encode_error(error.to_string()))?;
    sort_header(&mut bytes).ok_or_else(|| encode_error("its own header cannot be parsed".into()))?;
    Ok(bytes)
}

/// Names and samples of all channels, in the order of the file.
fn file_channels(table: &Table) -> Vec<(String, Vec<f32>)> {
    let texels = 0..table.values.len();
    let names = channel_names(table.channels);
    let values = names.iter().map(|&(name, channel)| {
        let samples = texels.clone().map(|i| table.stored(i)[channel] as f32);
        (name.to_string(), samples.collect())
    });
    let errors = names.iter().map(|&(name, channel)| {
        let samples = texels.clone().map(|i| table.texel_error(i)[channel] as f32);
        (format!("{ERROR_LAYER}{name}"), samples.collect())
    });
    values.chain(errors).collect()
}

/// SHA-256 of the samples, little-endian, channel after channel in the order of the file. The format has no checksum
/// of its own, and without compression a flipped bit would pass for a value.
pub(super) fn sample_hash<'a>(channels: impl Iterator<Item = &'a [f32]>) -> String {
    let bytes: Vec<u8> = channels.flatten().flat_map(|sample| sample.to_le_bytes()).collect();
    sha256_hex(&bytes)
}

/// Sorts the attributes of the (single) header by name. The `exr` crate keeps custom ones in a hash map and writes
/// them in an order that changes from run to run; as no length changes, every offset in the file stays right.
///
/// `None` when `bytes` is not a file with a complete header; they are then left as they were.
pub(super) fn sort_header(bytes: &mut [u8]) -> Option<()> {
    const START: usize = 8; // magic number and version, 4 bytes each
    let mut entries: Vec<&[u8]> = Vec::new();
    let mut rest = bytes.get(START..)?;
    while *rest.first()? != 0 {
        let (entry, after) = rest.split_at_checked(attribute_length(rest)?)?;
        entries.push(entry);
        rest = after;
    }
    entries.sort_by(|a, b| attribute_name(a).cmp(attribute_name(b)));
    let sorted = entries.concat();
    bytes.get_mut(START..START + sorted.len())?.copy_from_slice(&sorted);
    Some(())
}

/// The name that `entry` starts with, up to its terminating zero.
fn attribute_name(entry: &[u8]) -> &[u8] {
    entry.split(|&byte| byte == 0).next().unwrap_or_default()
}

/// Bytes of the attribute that `bytes` starts with: name and type, zero-terminated, the size as i32, the value.
fn attribute_length(bytes: &[u8]) -> Option<usize> {
    let terminated = |bytes: &[u8]| bytes.iter().position(|&byte| byte == 0).map(|end| end + 1);
    let name = terminated(bytes)?;
    let kind = name + terminated(bytes.get(name..)?)?;
    let size = bytes.get(kind..kind + 4)?.try_into().ok().map(i32::from_le_bytes)?;
    (kind + 4).checked_add(usize::try_from(size).ok()?)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::table::samples::{grey_2d, rgb_1d, scalar};

    #[test]
    fn twenty_writes_give_the_same_bytes() {
        for table in [grey_2d(), rgb_1d(), scalar()] {
            let first = to_bytes(&table).unwrap();
            assert!((0..20).all(|_| to_bytes(&table).unwrap() == first), "{}", table.id);
        }
    }

    #[test]
    fn headers_are_sorted_and_nothing_else_moves() {
        let entry = |name: &str, value: &[u8]| {
            let size = (value.len() as i32).to_le_bytes();
            [name.as_bytes(), b"\0int\0", &size, value].concat()
        };
        let [a, b, c] = [entry("a", &[9; 4]), entry("b", &[]), entry("bc", &[0, 7])];
        let file = |order: &[&[u8]]| [b"magicver", order.concat().as_slice(), b"\0pixels"].concat();
        let mut bytes = file(&[&c, &a, &b]);
        assert_eq!(sort_header(&mut bytes), Some(()));
        assert_eq!(bytes, file(&[&a, &b, &c]));

        let whole = file(&[&c, &a, &b]);
        let header_end = whole.len() - b"pixels".len();
        for cut in 0..header_end {
            let mut bytes = whole[..cut].to_vec();
            assert_eq!(sort_header(&mut bytes), None, "{cut}");
            assert_eq!(bytes, whole[..cut]);
        }
        let mut endless = file(&[&entry("a", &[])]);
        endless[14..18].copy_from_slice(&(-1i32).to_le_bytes());
        assert_eq!(sort_header(&mut endless), None);
    }

    #[test]
    fn bad_tables_are_not_encoded() {
        let mut table = grey_2d();
        table.values[3].x = f64::NAN;
        assert!(matches!(to_bytes(&table), Err(ExportError::Table(_))));
    }
}
