//! KTX 2.0 by the crate that wrote the headers, by the rules of the specification, and by ktx-parse under node.

use super::sample::{all, texture};
use super::tools::{installed, script, written};
use std::process::Command;
use whitefurnace::export::formats::{Format, files};
use whitefurnace::table::Storage;
use whitefurnace::table::texture::Texture;

fn bytes(texture: &Texture) -> Vec<u8> {
    files(texture, Format::Ktx2).unwrap().remove(0).1
}

/// Rules of the specification that the crate does not look after.
#[test]
fn files_keep_the_rules_of_the_format() {
    for texture in all() {
        let bytes = bytes(&texture);
        let reader = ktx2::Reader::new(&bytes).unwrap();
        let header = reader.header();
        let padded = [1, 2, 4, 4][texture.channels.len() - 1];
        let texel = padded * texture.storage.bytes();
        let word = |at: usize| u64::from_le_bytes(bytes[at..at + 8].try_into().unwrap()) as usize;
        let (offset, length) = (word(80), word(88));
        let kvd_end = (header.index.kvd_byte_offset + header.index.kvd_byte_length) as usize;
        let (four, multiple) = (kvd_end.div_ceil(4) * 4, texel.max(4));
        assert_eq!(offset % multiple, 0, "{}", texture.id);
        assert!(offset - four < multiple, "no more padding than it takes");
        assert!(bytes[kvd_end..offset].iter().all(|byte| *byte == 0));
        assert_eq!(offset + length, bytes.len());
        assert_eq!(length, texture.size().iter().product::<usize>() * texel);
        let [width, height, depth] = texture.size().map(|size| size as u32);
        let found = [header.pixel_width, header.pixel_height, header.pixel_depth];
        let depth = if texture.axes.len() == 3 { depth } else { 0 };
        assert_eq!(found, [width, height, depth]);
        assert_eq!((header.layer_count, header.face_count, header.level_count), (0, 1, 1));
        assert_eq!(header.type_size as usize, texture.storage.bytes());
        assert_eq!(reader.transfer_function(), Some(ktx2::TransferFunction::Linear));
        assert_eq!(reader.is_alpha_premultiplied(), Some(false));
        let keys: Vec<&str> = reader.key_value_data().map(|(key, _)| key).collect();
        assert!(keys.is_sorted() && keys.len() > 20, "{keys:?}");
        let value = |key: &str| {
            let value = reader.key_value_data().find(|(found, _)| *found == key).unwrap().1;
            String::from_utf8(value.to_vec()).unwrap()
        };
        assert_eq!(value("KTXorientation"), if depth > 0 { "rdi\0" } else { "rd\0" });
        assert!(value("KTXwriter").starts_with("whitefurnace "));
        assert_eq!(
            value("whitefurnace.layout").contains("the last is 1"),
            texture.channels.len() == 3
        );
    }
}

#[test]
fn formats_are_those_of_vulkan() {
    for (channels, storage, format) in [
        (1, Storage::Unorm8, ktx2::Format::R8_UNORM),
        (1, Storage::Unorm16, ktx2::Format::R16_UNORM),
        (2, Storage::F16, ktx2::Format::R16G16_SFLOAT),
        (2, Storage::F32, ktx2::Format::R32G32_SFLOAT),
        (3, Storage::F16, ktx2::Format::R16G16B16A16_SFLOAT),
        (4, Storage::F32, ktx2::Format::R32G32B32A32_SFLOAT),
    ] {
        let bytes = bytes(&texture(2, channels, storage));
        assert_eq!(ktx2::Reader::new(&bytes).unwrap().header().format, Some(format));
    }
}

/// Sizes, formats, facts and every texel, decoded by the script on its own.
#[test]
fn ktx_parse_reads_the_same() {
    let directory = tempfile::tempdir().unwrap();
    written(directory.path(), all(), Format::Ktx2);
    let module = installed("node/node_modules/ktx-parse/dist/index.mjs");
    script(Command::new("node"), "ktx2.mjs", &[directory.path(), &module]);
}
