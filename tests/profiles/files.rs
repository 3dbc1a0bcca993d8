//! Numbers survive the file: written in the format of the engine, read again by other code, looked up.

use crate::check::check;
use crate::engines::Tables;
use crate::gpu::Raw;
use crate::shared::baked;
use half::f16;
use std::io::Cursor;
use whitefurnace::engine::Profile;
use whitefurnace::export::formats::{Format, Language, files};
use whitefurnace::table::Storage;
use whitefurnace::table::texture::Texture;

fn halves(bytes: &[u8]) -> Vec<f64> {
    let number = |pair: &[u8]| f16::from_le_bytes([pair[0], pair[1]]).to_f64();
    bytes.chunks_exact(2).map(number).collect()
}

fn words(bytes: &[u8]) -> Vec<f64> {
    let number = |pair: &[u8]| f64::from(u16::from_le_bytes([pair[0], pair[1]])) / 65535.0;
    bytes.chunks_exact(2).map(number).collect()
}

/// `kept` of every `stored` channels.
fn channels(values: &[f64], stored: usize, kept: usize) -> Vec<f64> {
    values
        .chunks_exact(stored)
        .flat_map(|texel| texel[..kept].to_vec())
        .collect()
}

fn word(bytes: &[u8], at: usize) -> u32 {
    u32::from_le_bytes(bytes[at..at + 4].try_into().unwrap())
}

/// DDS by its documented layout: "DDS ", a header of 124 bytes with height and width, one of 20 bytes with the DXGI format, texels.
fn dds(bytes: &[u8], kept: usize) -> Raw {
    assert_eq!(&bytes[..4], b"DDS ");
    assert_eq!(
        (word(bytes, 4), word(bytes, 76 + 8)),
        (124, u32::from_le_bytes(*b"DX10"))
    );
    let [height, width] = [12, 16].map(|at| word(bytes, at) as usize);
    let (values, stored) = match word(bytes, 128) {
        10 => (halves(&bytes[148..]), 4), // DXGI_FORMAT_R16G16B16A16_FLOAT
        35 => (words(&bytes[148..]), 2),  // DXGI_FORMAT_R16G16_UNORM
        other => panic!("DXGI format {other}"),
    };
    assert_eq!(values.len(), width * height * stored);
    Raw {
        size: [width, height, 1],
        channels: kept,
        values: channels(&values, stored, kept),
    }
}

fn ktx2(bytes: &[u8]) -> Raw {
    let reader = ktx2::Reader::new(bytes).unwrap();
    let header = reader.header();
    let level = reader.levels().next().unwrap().data;
    let (values, stored, kept) = match header.format.unwrap() {
        ktx2::Format::R16G16_SFLOAT => (halves(level), 2, 2),
        ktx2::Format::R16_SFLOAT => (halves(level), 1, 1),
        ktx2::Format::R16_UNORM => {
            let number = |two: &[u8]| f64::from(u16::from_le_bytes(two.try_into().unwrap())) / 65535.0;
            (level.chunks_exact(2).map(number).collect(), 1, 1)
        }
        ktx2::Format::R32_SFLOAT => {
            let number = |four: &[u8]| f64::from(f32::from_le_bytes(four.try_into().unwrap()));
            (level.chunks_exact(4).map(number).collect(), 1, 1)
        }
        other => panic!("{other:?}"),
    };
    let size = [header.pixel_width, header.pixel_height, header.pixel_depth];
    Raw {
        size: size.map(|size| size.max(1) as usize),
        channels: kept,
        values: channels(&values, stored, kept),
    }
}

fn png(bytes: &[u8], kept: usize) -> Raw {
    let mut reader = png::Decoder::new(Cursor::new(bytes)).read_info().unwrap();
    let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
    let info = reader.next_frame(&mut pixels).unwrap();
    assert_eq!(info.bit_depth, png::BitDepth::Eight);
    let values: Vec<f64> = pixels.iter().map(|value| f64::from(*value) / 255.0).collect();
    Raw {
        size: [info.width as usize, info.height as usize, 1],
        channels: kept,
        values: channels(&values, info.color_type.samples(), kept),
    }
}

fn exr(bytes: &[u8]) -> Raw {
    use exr::prelude::{ReadChannels, ReadLayers, read};
    let reader = read()
        .no_deep_data()
        .largest_resolution_level()
        .all_channels()
        .first_valid_layer();
    let image = reader.all_attributes().from_buffered(Cursor::new(bytes)).unwrap();
    let layer = &image.layer_data;
    let find = |name: &str| layer.channel_data.list.iter().find(|channel| channel.name.eq(name));
    // the order of channels in a file is that of the alphabet
    let names: Vec<&str> = ["Y", "R", "G", "B", "A"]
        .into_iter()
        .filter(|name| find(name).is_some())
        .collect();
    let all: Vec<Vec<f32>> = names
        .iter()
        .map(|name| find(name).unwrap().sample_data.values_as_f32().collect())
        .collect();
    let values = (0..all[0].len()).flat_map(|i| all.iter().map(move |channel| f64::from(channel[i])));
    Raw {
        size: [layer.size.0, layer.size.1, 1],
        channels: names.len(),
        values: values.collect(),
    }
}

/// The numbers between the braces of the array, `x` to `z` from the text too.
fn c_text(bytes: &[u8]) -> Raw {
    let text = std::str::from_utf8(bytes).unwrap();
    let defined = |what: &str| {
        let line = text
            .lines()
            .find(|line| line.starts_with(&format!("#define {what}_")))
            .unwrap();
        line.split(' ').nth(2).unwrap().parse::<usize>().unwrap()
    };
    let array = text.split("= {").nth(1).unwrap().split('}').next().unwrap();
    let number = |text: &str| f64::from(text.trim().strip_suffix('f').unwrap().parse::<f32>().unwrap());
    Raw {
        size: ["WIDTH", "HEIGHT", "DEPTH"].map(defined),
        channels: defined("CHANNELS"),
        values: array.split(',').map(number).collect(),
    }
}

fn decoded(texture: &Texture, format: Format) -> Raw {
    let bytes = files(texture, format).unwrap().remove(0).1;
    let kept = texture.channels.len();
    match format {
        Format::Raw => {
            assert_eq!(texture.storage, Storage::F16);
            // the file has no header; the engine knows the size
            Raw {
                size: texture.size(),
                channels: kept,
                values: halves(&bytes),
            }
        }
        Format::Ktx2 => ktx2(&bytes),
        Format::Dds => dds(&bytes, kept),
        Format::Png => png(&bytes, kept),
        Format::Exr => exr(&bytes),
        Format::Source(Language::C) => c_text(&bytes),
        Format::Source(_) => panic!("no engine has {format:?}"),
    }
}

/// Every profile in its own format: the same numbers, and the same lookups within the same errors.
#[test]
fn what_is_written_is_read() {
    let mut seen = Vec::new();
    for profile in Profile::ALL {
        // its volumes are padded images of the same formats, read by the tests of formats
        let baked = baked(profile);
        let mut tables = Tables::new();
        for (sheet, texture) in baked {
            if profile == Profile::OpenPbr && sheet.axes.len() == 3 {
                tables.insert(sheet.name, Raw::of(texture));
                continue;
            }
            let format = profile.format_of(sheet);
            let found = decoded(texture, format);
            assert_eq!(found, Raw::of(texture), "{profile:?} {}", sheet.name);
            seen.push(format);
            tables.insert(sheet.name, found);
        }
        check(profile, baked, &tables, 50);
    }
    for format in [
        Format::Raw,
        Format::Ktx2,
        Format::Dds,
        Format::Png,
        Format::Exr,
        Format::Source(Language::C),
    ] {
        assert!(seen.contains(&format), "{format:?}");
    }
}
