//! `furnace inspect` on textures: those of every shape, those of other programs, and damaged ones.

use super::sample::{all, texture};
use serde_json::Value;
use std::fs;
use std::path::Path;
use std::process::{Command, Output};
use whitefurnace::export::formats::read::{Found, Said, parse_texture, read_texture};
use whitefurnace::export::formats::{Format, facts, files};
use whitefurnace::export::read::{Contents, parse_exr};
use whitefurnace::table::Storage;
use whitefurnace::table::texture::Texture;

const READ: [Format; 4] = [Format::Ktx2, Format::Dds, Format::Png, Format::Raw];

/// Whether `said` is what was written, but for what formats do with texels.
fn assert_said(texture: &Texture, said: &Said) {
    for (name, value) in facts::list(texture, "").iter().filter(|(name, _)| name != "layout") {
        assert_eq!(said.get(name), Some(value.as_str()), "{} {name}", texture.id);
    }
    let (tree, written) = (said.tree(), facts::tree(texture, ""));
    for (name, value) in written.iter().filter(|(name, _)| *name != "layout") {
        assert_eq!(tree[name], *value, "{} {name}", texture.id);
    }
}

fn ranges(texture: &Texture) -> Vec<Option<(f64, f64)>> {
    let of = |index| {
        let values = texture.values.iter().skip(index).step_by(texture.channels.len());
        Some(values.fold((2.0f64, -2.0f64), |(min, max), value| {
            (min.min(*value), max.max(*value))
        }))
    };
    (0..texture.channels.len()).map(of).collect()
}

#[test]
fn facts_sizes_and_ranges_come_back() {
    let directory = tempfile::tempdir().unwrap();
    let mut read = 0;
    for texture in all() {
        for format in READ.into_iter().filter(|format| format.takes(texture.storage)) {
            for (name, bytes) in files(&texture, format).unwrap() {
                fs::write(directory.path().join(name), bytes).unwrap();
            }
            for end in format.extensions() {
                let file = read_texture(&directory.path().join(format!("{}.{end}", texture.id))).unwrap();
                assert_eq!(file.format, format);
                assert_eq!(file.bytes, fs::metadata(&file.path).unwrap().len());
                let Found {
                    size,
                    storage,
                    channels,
                    facts,
                    ..
                } = file.contents;
                let [width, height, depth] = texture.size().map(|size| size as u64);
                let is_tiled = format == Format::Png;
                assert_eq!(
                    size,
                    if is_tiled {
                        [width * depth, height, 1]
                    } else {
                        [width, height, depth]
                    }
                );
                assert_eq!(storage, Some(texture.storage));
                let found: Vec<_> = channels.iter().map(|channel| channel.range).collect();
                if format == Format::Dds {
                    assert!(facts.is_empty());
                    // padding too: nothing says that it is none of the channels
                    assert_eq!(found[..texture.channels.len()], ranges(&texture));
                } else {
                    assert_said(&texture, &facts);
                    assert_eq!(found, ranges(&texture), "{} {format:?}", texture.id);
                }
                read += 1;
            }
        }
    }
    // 12 shapes in 4 storages as KTX 2.0, DDS and two files of the raw format, in two of them as PNG
    assert_eq!(read, 12 * 4 * 4 + 12 * 2);
}

#[test]
fn facts_of_openexr_come_back() {
    for texture in all().filter(|texture| Format::Exr.takes(texture.storage)) {
        let (name, bytes) = files(&texture, Format::Exr).unwrap().remove(0);
        let Contents::Foreign(layers) = parse_exr(Path::new(&name), &bytes).unwrap().contents else {
            panic!("{name} passes for a table");
        };
        assert_said(&texture, &layers[0].facts);
        // the last sample: A, or B, G or R in the last row
        let mut changed = bytes.clone();
        let last = changed.len() - 1;
        changed[last] = 0x44;
        let error = parse_exr(Path::new(&name), &changed).unwrap_err().to_string();
        assert!(error.contains(&name) && error.contains("its facts say"), "{error}");
    }
}

fn inspect(directory: &Path, arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_furnace"));
    command
        .current_dir(directory)
        .arg("inspect")
        .args(arguments)
        .output()
        .unwrap()
}

fn shown(directory: &Path, arguments: &[&str]) -> String {
    let output = inspect(directory, arguments);
    assert_eq!(
        output.status.code(),
        Some(0),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
    String::from_utf8(output.stdout).unwrap()
}

fn refused(directory: &Path, name: &str) -> String {
    let output = inspect(directory, &[name]);
    let errors = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(2), "{errors}");
    assert!(
        errors.starts_with("error: cannot read ") && !errors.contains("panicked"),
        "{errors}"
    );
    errors
}

#[test]
fn the_command_says_what_is_known() {
    let directory = tempfile::tempdir().unwrap();
    let here = directory.path();
    for format in READ.into_iter().chain([Format::Exr]) {
        let storage = if format == Format::Png {
            Storage::Unorm16
        } else {
            Storage::F16
        };
        let texture = texture(2, 3, storage);
        for (name, bytes) in files(&texture, format).unwrap() {
            fs::write(here.join(name), bytes).unwrap();
        }
        for end in format.extensions() {
            let name = format!("{}.{end}", texture.id);
            let out = shown(here, &[&name]);
            let json: Value = serde_json::from_str(&shown(here, &["--json", &name])).unwrap();
            assert!(out.contains("7 x 5") && out.contains("sha256"), "{out}");
            let facts = match format {
                Format::Exr => &json["foreign"][0]["facts"],
                _ => {
                    assert_eq!(json["format"], format.name());
                    assert_eq!(json["storage"], storage.name());
                    &json["facts"]
                }
            };
            if format == Format::Dds {
                assert!(
                    out.contains("It has no facts of whitefurnace, for which DDS has no room"),
                    "{out}"
                );
                assert!(facts.is_null(), "{json}");
                continue;
            }
            for part in [
                "kappa 0.5 .. 4096",
                "flipped",
                "größer als null",
                "error         scale: at most 0.333",
                "f16",
            ] {
                assert!(
                    part == "f16" && storage != Storage::F16 || out.contains(part),
                    "{part}: {out}"
                );
            }
            assert_eq!(facts["axes"][1]["flipped"], true);
            assert_eq!(facts["axes"][0]["size"], 7);
            assert_eq!(facts["errors"][0]["probes"], 1u64 << 60);
            assert!(!out.contains("no facts") && !out.contains("no attributes"), "{out}");
        }
    }
}

/// Of a bake with its manifest: whether the file is still the one that was written.
#[test]
fn the_list_beside_a_texture_is_compared() {
    let directory = tempfile::tempdir().unwrap();
    let here = directory.path();
    let (name, bytes) = files(&texture(2, 2, Storage::F16), Format::Dds).unwrap().remove(0);
    fs::write(here.join(&name), &bytes).unwrap();
    for list in ["profile.json", "manifest.json"] {
        let entry = |sha256: &str| serde_json::json!({ "tables": [{ "files": [{ "file": name, "sha256": sha256 }] }] });
        fs::write(
            here.join(list),
            entry(&whitefurnace::export::sha256_hex(&bytes)).to_string(),
        )
        .unwrap();
        let out = shown(here, &[&name]);
        assert!(
            out.contains(&format!(", as in {list}")) && out.contains("says what it is"),
            "{out}"
        );
        fs::write(here.join(list), entry("0").to_string()).unwrap();
        let out = shown(here, &[&name]);
        assert!(
            out.contains(&format!("finding: {list} beside it has another hash")),
            "{out}"
        );
        let json: Value = serde_json::from_str(&shown(here, &["--json", &name])).unwrap();
        assert_eq!(json["listed"], serde_json::json!({ "in": list, "same": false }));
        // the lists themselves are no textures
        let error = refused(here, list);
        assert!(
            error.contains(list) && error.contains("no description of raw numbers"),
            "{error}"
        );
    }
}

#[test]
fn textures_of_others_have_no_facts() {
    let directory = tempfile::tempdir().unwrap();
    let here = directory.path();
    let mut encoder = png::Encoder::new(fs::File::create(here.join("grey.png")).unwrap(), 3, 2);
    encoder.set_color(png::ColorType::GrayscaleAlpha);
    encoder.add_text_chunk("Software".into(), "another".into()).unwrap();
    let mut writer = encoder.write_header().unwrap();
    writer
        .write_image_data(&[0, 255, 51, 255, 102, 255, 0, 255, 0, 255, 0, 255])
        .unwrap();
    writer.finish().unwrap();
    let out = shown(here, &["grey.png"]);
    assert!(
        out.contains("GrayscaleAlpha, 8 bits") && out.contains("3 x 2 x 1"),
        "{out}"
    );
    assert!(out.contains("0: 0 .. 0.4\n") && out.contains("1: 1 .. 1\n"), "{out}");
    assert!(
        out.contains("It has no facts of whitefurnace: axes, channels and errors are unknown."),
        "{out}"
    );

    // block compression and mip levels: what the header says, and nothing of the texels
    let (_, ktx2) = files(&texture(2, 1, Storage::F16), Format::Ktx2).unwrap().remove(0);
    let mut other = ktx2.clone();
    other[12..16].copy_from_slice(&131u32.to_le_bytes());
    other[40..44].copy_from_slice(&3u32.to_le_bytes());
    // no key/value data
    other[60..64].copy_from_slice(&0u32.to_le_bytes());
    fs::write(here.join("blocks.ktx2"), other).unwrap();
    let out = shown(here, &["blocks.ktx2"]);
    assert!(
        out.contains("BC1_RGB_UNORM_BLOCK, 3 mip levels") && out.contains("texels not decoded"),
        "{out}"
    );

    let (_, mut dds) = files(&texture(2, 1, Storage::F16), Format::Dds).unwrap().remove(0);
    dds[84..88].copy_from_slice(b"DXT1");
    fs::write(here.join("old.DDS"), dds).unwrap();
    let out = shown(here, &["old.DDS"]);
    assert!(out.contains("DXT1") && out.contains("texels not decoded"), "{out}");
}

#[test]
fn wrong_names_are_told_from_damage() {
    let directory = tempfile::tempdir().unwrap();
    let here = directory.path();
    let texture = texture(1, 1, Storage::Unorm8);
    let names = [("KTX 2.0", "ktx2"), ("DDS", "dds"), ("PNG", "png")];
    for ((begins, _), format) in names.iter().zip(READ) {
        let (_, bytes) = files(&texture, format).unwrap().remove(0);
        for (says, end) in names.iter().filter(|(_, end)| *end != format.extensions()[0]) {
            let name = format!("wrong.{end}");
            fs::write(here.join(&name), &bytes).unwrap();
            let error = refused(here, &name);
            let expected = format!("{name}: it begins like {begins}, where its name says {says}");
            assert!(error.contains(&expected), "{error}");
        }
        fs::write(here.join("wrong.exr"), &bytes).unwrap();
        assert!(refused(here, "wrong.exr").contains("it does not begin like an OpenEXR file"));
        fs::write(here.join("wrong.hdr"), &bytes).unwrap();
        assert!(refused(here, "wrong.hdr").contains("wrong.hdr"));
    }
    for (name, reason) in [
        ("empty.ktx2", "it does not begin like KTX 2.0"),
        ("empty.dds", "it does not begin like DDS"),
        ("empty.json", "no description of raw numbers"),
    ] {
        fs::write(here.join(name), if name.ends_with("json") { "{}" } else { "" }).unwrap();
        let error = refused(here, name);
        assert!(error.contains(name) && error.contains(reason), "{error}");
    }
    for name in ["missing.dds", "missing.json", "missing.bin"] {
        assert!(refused(here, name).contains("missing."));
    }
    // one of the two files of raw numbers without the other
    let raw = files(&texture, Format::Raw).unwrap();
    for (name, bytes) in &raw {
        fs::write(here.join(name), bytes).unwrap();
    }
    for [gone, (asked, _)] in [[&raw[0], &raw[1]], [&raw[1], &raw[0]]] {
        fs::rename(here.join(&gone.0), here.join("away")).unwrap();
        assert!(refused(here, asked).contains(&gone.0));
        fs::rename(here.join("away"), here.join(&gone.0)).unwrap();
    }
    fs::create_dir(here.join("directory.png")).unwrap();
    assert!(refused(here, "directory.png").contains("directory"));
}

fn parse(format: Format, written: &[(String, Vec<u8>)], damaged: &[u8], which: usize) -> Result<(), String> {
    let mut parts: Vec<&[u8]> = written.iter().map(|(_, bytes)| bytes.as_slice()).collect();
    parts[which] = damaged;
    let json = parts.get(1).copied().unwrap_or_default();
    match parse_texture(Path::new(&written[0].0), format, parts[0], json) {
        Ok(_) => Ok(()),
        Err(error) => {
            let error = error.to_string();
            assert!(
                error.starts_with("cannot read ") && error.contains(&written[0].0),
                "{error}"
            );
            assert!(error.len() < 1000, "{error}");
            Err(error)
        }
    }
}

/// Cut short anywhere a file is refused; with a byte changed, or a word, it is read or refused, and nothing else happens.
#[test]
fn damaged_files_are_read_or_refused() {
    let texture = texture(3, 2, Storage::Unorm8);
    for format in READ {
        let written = files(&texture, format).unwrap();
        for (which, (name, bytes)) in written.iter().enumerate() {
            // the line feed behind JSON is all that may be missing
            for cut in (0..bytes.len() - 2).step_by(bytes.len() / 500 + 1) {
                assert!(
                    parse(format, &written, &bytes[..cut], which).is_err(),
                    "{name} cut at {cut}"
                );
            }
            let (mut taken, mut tried) = (0, 0);
            // headers byte by byte, the rest here and there
            for at in (0..bytes.len()).filter(|at| *at < 300 || at % 7 == 0) {
                for bit in 0..8 {
                    let mut damaged = bytes.clone();
                    damaged[at] ^= 1 << bit;
                    tried += 1;
                    taken += u32::from(parse(format, &written, &damaged, which).is_ok());
                }
                for word in [0u32, 1, 0x7fff_ffff, 0x8000_0000, u32::MAX] {
                    let mut damaged = bytes.clone();
                    for (byte, of_word) in damaged[at..].iter_mut().zip(word.to_le_bytes()) {
                        *byte = of_word;
                    }
                    drop(parse(format, &written, &damaged, which));
                }
            }
            // both happen: a test of files that are all refused at once would be none
            println!("{name}: {taken} of {tried} flips taken");
            assert!(
                taken < tried && (taken > 0 || format == Format::Raw || format == Format::Png),
                "{name}"
            );
        }
    }
}

/// Facts that do not go with the texels.
#[test]
fn contradictions_are_damage() {
    let texture = texture(2, 2, Storage::Unorm8);
    let written = files(&texture, Format::Ktx2).unwrap();
    let bytes = &written[0].1;
    let replaced = |from: &str, to: &str| {
        assert_eq!(from.len(), to.len());
        let at = bytes.windows(from.len()).position(|window| window == from.as_bytes());
        let mut changed = bytes.clone();
        let at = at.unwrap_or_else(|| panic!("no {from}"));
        changed[at..at + from.len()].copy_from_slice(to.as_bytes());
        parse(Format::Ktx2, &written, &changed, 0).unwrap_err()
    };
    assert!(replaced("[7,5,1]", "[7,4,1]").contains("its image is [7, 5, 1], its facts say [7, 4, 1]"));
    assert!(replaced("[7,5,1]", "{{{{{{{").contains("its fact size is {{{{{{{"));
    assert!(replaced("axes.0.size\x007", "axes.0.size\x008").contains("its axes are not those"));
    assert!(replaced("storage\0unorm8", "storage\0unorm9").contains("its facts speak of unorm9"));
    assert!(replaced("textureFormat\x001", "textureFormat\x002").contains("its textureFormat is 2"));
    assert!(replaced("textureFormat\x001", "textureFermat\x001").contains("lack textureFormat"));
    let mut changed = bytes.clone();
    let start = bytes.len() - 70;
    changed[start..].fill(7);
    let error = parse(Format::Ktx2, &written, &changed, 0).unwrap_err();
    assert!(
        error.contains("its texels lie in") && error.contains("it was changed"),
        "{error}"
    );
}
