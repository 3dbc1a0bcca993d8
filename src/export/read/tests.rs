use super::*;
use crate::export::FORMAT;
use crate::export::exr::to_bytes;
use crate::export::write::write_whole;
use crate::table::samples::{grey_2d, rgb_1d, scalar};
use ::exr::image::{Blocks, Encoding, Image};
use ::exr::math::Vec2;
use ::exr::meta::attribute::LineOrder;
use ::exr::meta::header::LayerAttributes;
use ::exr::prelude::{Compression, WritableImage, f16};

/// What a file called `some.exr` holds.
fn decode(bytes: &[u8]) -> Result<Contents, String> {
    super::decode("some", bytes)
}

/// Writes `bytes` where `read_exr` finds them.
fn read_bytes(bytes: &[u8]) -> Result<TableFile, ExportError> {
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("some.exr");
    write_whole(&path, bytes).unwrap();
    read_exr(&path)
}

/// Two parts, halves and floats, with a NaN, in blocks of the given kind.
fn foreign_file(compression: Compression, blocks: Blocks) -> Vec<u8> {
    let layer = |name: &str| {
        let halves = (0..35).map(|i| f16::from_f32(i as f32)).collect();
        let mut floats: Vec<f32> = (0..35).map(|i| 0.5 - i as f32).collect();
        floats[3] = f32::NAN;
        let list = [
            AnyChannel::new("depth", FlatSamples::F32(floats)),
            AnyChannel::new("id", FlatSamples::U32((7..42).collect())),
            AnyChannel::new("half", FlatSamples::F16(halves)),
        ];
        let encoding = Encoding {
            compression,
            blocks,
            line_order: LineOrder::Increasing,
        };
        let channels = AnyChannels::sort(list.into_iter().collect());
        Layer::new((7, 5), LayerAttributes::named(name), encoding, channels)
    };
    let mut bytes = Vec::new();
    let image = Image::from_layers(
        ::exr::meta::header::ImageAttributes::new(::exr::meta::attribute::IntegerBounds::from_dimensions((7, 5))),
        vec![layer("one"), layer("two")],
    );
    let write = image.write().non_parallel();
    write.to_buffered(Cursor::new(&mut bytes)).unwrap();
    bytes
}

#[test]
fn our_tables_come_back_bit_by_bit() {
    for table in [grey_2d(), rgb_1d(), scalar()] {
        let bytes = to_bytes(&table).unwrap();
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join(format!("{}.exr", table.id));
        write_whole(&path, &bytes).unwrap();
        let file = read_exr(&path).unwrap();
        assert_eq!((file.bytes, file.sha256), (bytes.len() as u64, sha256_hex(&bytes)));
        let Contents::Table { table: again, version } = file.contents else {
            panic!("{} is taken for foreign", table.id)
        };
        assert_eq!(version, env!("CARGO_PKG_VERSION"));
        for i in 0..table.values.len() {
            assert_eq!(again.values[i], table.stored(i));
            assert_eq!(again.errors[i], table.texel_error(i));
        }
        let facts = Table {
            values: table.values.clone(),
            errors: table.errors.clone(),
            ..*again.clone()
        };
        assert_eq!(facts, table);
        assert_eq!(to_bytes(&again).unwrap(), bytes);
    }
}

#[test]
fn tables_go_by_the_names_of_their_files() {
    let table = grey_2d();
    let other = Table {
        id: "Größe".into(),
        ..table.clone()
    };
    let bytes = to_bytes(&table).unwrap();
    assert_eq!(to_bytes(&other).unwrap(), bytes);
    for (path, id) in [
        ("a/k17.specular.rho_hd.exr", "k17.specular.rho_hd"),
        ("Größe", "Größe"),
        ("..", ""),
    ] {
        match parse_exr(Path::new(path), &bytes).unwrap().contents {
            Contents::Table { table, .. } => assert_eq!(table.id, id),
            Contents::Foreign(_) => panic!("{path} is taken for foreign"),
        }
    }
}

#[test]
fn foreign_files_say_what_they_hold() {
    let file = read_bytes(&foreign_file(Compression::ZIP16, Blocks::ScanLines)).unwrap();
    let Contents::Foreign(layers) = file.contents else {
        panic!()
    };
    assert_eq!(layers.len(), 2);
    assert_eq!((layers[1].name.as_deref(), layers[1].size), (Some("two"), [7, 5]));
    assert_eq!(layers[1].compression, "zip block compression");
    let channel = |i: usize| {
        let channel = &layers[0].channels[i];
        let samples = channel.samples.unwrap();
        (channel.name.as_str(), channel.kind, samples.range, samples.not_finite)
    };
    assert_eq!(channel(0), ("depth", "f32", Some((-33.5, 0.5)), 1));
    assert_eq!(channel(1), ("half", "f16", Some((0.0, 34.0)), 0));
    assert_eq!(channel(2), ("id", "u32", Some((7.0, 41.0)), 0));
}

#[test]
fn samples_of_fragile_decoders_are_left_alone() {
    for compression in [Compression::B44, Compression::DWAB(None)] {
        let file = read_bytes(&foreign_file(compression, Blocks::ScanLines)).unwrap();
        let Contents::Foreign(layers) = file.contents else {
            panic!()
        };
        assert_eq!((layers.len(), layers[0].size), (2, [7, 5]));
        assert!(layers[0].channels.iter().all(|channel| channel.samples.is_none()));
    }
    let ours = to_bytes(&grey_2d()).unwrap();
    let kept = b"compression\0compression\0\x01\0\0\0\0";
    let dwaa = b"compression\0compression\0\x01\0\0\0\x08";
    assert!(
        decode(&edited(&ours, kept, dwaa))
            .unwrap_err()
            .contains("dwaa compression")
    );
}

#[test]
fn cut_files_are_errors_that_name_the_file() {
    for table in [grey_2d(), rgb_1d(), scalar()] {
        let bytes = to_bytes(&table).unwrap();
        for cut in (0..bytes.len()).step_by(7).chain([bytes.len() - 1]) {
            let error = read_bytes(&bytes[..cut]).unwrap_err().to_string();
            assert!(error.contains("some.exr"), "{cut}: {error}");
        }
    }
}

#[test]
fn no_flipped_byte_panics_or_changes_a_sample() {
    for table in [grey_2d(), rgb_1d(), scalar()] {
        let bytes = to_bytes(&table).unwrap();
        for at in 0..bytes.len() {
            for flip in [0x01, 0x80, 0xff] {
                let mut damaged = bytes.clone();
                damaged[at] ^= flip;
                if let Ok(Contents::Table { table: read, .. }) = decode(&damaged) {
                    let unchanged = (0..read.values.len())
                        .all(|i| read.values[i] == table.stored(i) && read.errors[i] == table.texel_error(i));
                    assert!(unchanged, "byte {at} ^ {flip:#x}");
                }
            }
        }
    }
}

#[test]
fn damaged_foreign_files_do_not_panic() {
    let tiles = Blocks::Tiles(Vec2(4, 3));
    for blocks in [Blocks::ScanLines, tiles] {
        for compression in [
            Compression::Uncompressed,
            Compression::RLE,
            Compression::ZIP1,
            Compression::ZIP16,
            Compression::PIZ,
            Compression::PXR24,
            Compression::B44,
            Compression::B44A,
            Compression::DWAA(None),
        ] {
            let bytes = foreign_file(compression, blocks);
            for at in 0..bytes.len() {
                let mut damaged = bytes.clone();
                damaged[at] ^= if at % 2 == 0 { 0xff } else { 0x11 };
                let _ = decode(&damaged);
                if at % 7 == 0 {
                    let _ = decode(&bytes[..at]);
                }
            }
        }
    }
}

/// `bytes` with the attribute `name` renamed or its value overwritten, at the same length.
fn edited(bytes: &[u8], from: &[u8], to: &[u8]) -> Vec<u8> {
    let at = bytes.windows(from.len()).position(|window| window == from).unwrap();
    let mut edited = bytes.to_vec();
    edited[at..at + to.len()].copy_from_slice(to);
    edited
}

#[test]
fn huge_announcements_are_refused_before_allocation() {
    let bytes = to_bytes(&grey_2d()).unwrap();
    let window = |right: i32, bottom: i32| {
        let box2i = [0i32, 0, right, bottom].map(i32::to_le_bytes).concat();
        let from = [b"dataWindow\0box2i\0".as_slice(), &16i32.to_le_bytes()].concat();
        decode(&edited(&bytes, &from, &[from.clone(), box2i].concat())).unwrap_err()
    };
    for (right, bottom) in [(i32::MAX - 1, i32::MAX - 1), (1 << 20, 1 << 20), (1 << 14, 1 << 14)] {
        let error = window(right, bottom);
        assert!(error.contains("pixels") || error.contains("window"), "{error}");
    }
    let error = window(8191, 8191);
    assert!(error.contains("cannot hold"), "{error}");
}

#[test]
fn contradictions_and_unknown_facts_are_named() {
    let bytes = to_bytes(&grey_2d()).unwrap();
    for (from, to, reason) in [
        ("errorKind", "errorKund", "attribute errorKind is missing"),
        ("log1p", "log9p", "\"log9p\", which this version does not know"),
        (
            "evaluations\0string\0\x05\0\0\x0012345",
            "evaluations\0string\0\x05\0\0\x001234x",
            "\"1234x\", not a number",
        ),
        ("Y\0", "Z\0", "should be"),
    ] {
        let error = decode(&edited(&bytes, from.as_bytes(), to.as_bytes())).unwrap_err();
        assert!(error.contains(reason), "{error}");
    }
    let mark = |format: i32| [b"whitefurnaceFormat\0int\0\x04\0\0\0".as_slice(), &format.to_le_bytes()].concat();
    for other in [FORMAT - 1, FORMAT + 1] {
        let error = decode(&edited(&bytes, &mark(FORMAT), &mark(other))).unwrap_err();
        let reason = format!("is {other}, where this version reads {FORMAT}");
        assert!(error.contains(&reason), "{error}");
    }
}

#[test]
fn what_is_no_image_says_so() {
    for bytes in [b"".as_slice(), b"v/1", b"\x89PNG\r\n", b"v/1\x01"] {
        assert!(matches!(read_bytes(bytes), Err(ExportError::Unreadable { .. })));
    }
    let missing = read_exr(Path::new("no/such/table.exr")).unwrap_err().to_string();
    assert!(missing.contains("no/such/table.exr"), "{missing}");
    assert!(read_exr(&std::env::temp_dir()).is_err());
}
