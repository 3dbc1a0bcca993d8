//! `furnace bake --format`: which files there are, what the manifest says of them, and that nothing else changes.

use serde_json::Value;
use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::process::{Command, Output};
use whitefurnace::export::sha256_hex;

const ALL: &str = "exr,ktx2,dds,png,raw,c,rust,glsl,hlsl,wgsl";

/// Two materials, with the tables of both albedos each: over mu and a single texel, and the same over a roughness.
const SCENE: &str = r#"
[[material]]
name = "rough"
bxdf = { type = "microfacet", masking = "v-groove", distribution = { type = "vmf", kappa = 17.0 }, fresnel = { type = "none" } }

[[material]]
name = "range"
bxdf = { type = "microfacet", masking = "v-groove", distribution = { type = "vmf", kappa = { min = 1.0, max = 64.0 } }, fresnel = { type = "none" } }
"#;

fn furnace(directory: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_furnace"))
        .current_dir(directory)
        .args(arguments)
        .output()
        .unwrap()
}

/// Bakes `scene.toml` into `out` and returns what was printed.
fn bake(directory: &Path, out: &str, arguments: &[&str]) -> String {
    let small = [
        "bake",
        "scene.toml",
        "--resolution",
        "8",
        "--roughness-resolution",
        "4",
        "--out",
        out,
    ];
    let output = furnace(directory, &[&small, arguments].concat());
    let errors = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(0), "{arguments:?}: {errors}");
    String::from_utf8(output.stdout).unwrap()
}

fn refused(directory: &Path, arguments: &[&str]) -> String {
    let output = furnace(
        directory,
        &[&["bake", "scene.toml", "--resolution", "8", "--out", "out"], arguments].concat(),
    );
    let errors = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(2), "{arguments:?}: {errors}");
    assert!(
        errors.starts_with("error: ") && !errors.contains("panicked"),
        "{errors}"
    );
    errors
}

fn scene(text: &str) -> tempfile::TempDir {
    let directory = tempfile::tempdir().unwrap();
    fs::write(directory.path().join("scene.toml"), text).unwrap();
    directory
}

/// Names and contents of the files of a directory.
fn contents(directory: &Path) -> BTreeMap<String, Vec<u8>> {
    let paths = fs::read_dir(directory).unwrap().map(|entry| entry.unwrap().path());
    let read = |path: std::path::PathBuf| {
        let name = path.file_name().unwrap().to_string_lossy().into_owned();
        (name, fs::read(path).unwrap())
    };
    paths.filter(|path| path.is_file()).map(read).collect()
}

fn manifest(directory: &Path) -> Value {
    let mut manifest: Value = serde_json::from_slice(&fs::read(directory.join("manifest.json")).unwrap()).unwrap();
    // the only part that depends on what was there before
    manifest["reused"] = Value::Null;
    manifest
}

#[test]
fn every_format_is_written_listed_and_the_same_again() {
    let directory = scene(SCENE);
    let [out, again] = ["out", "again"].map(|name| directory.path().join(name));
    let printed = bake(directory.path(), "out", &["--format", ALL, "--threads", "1"]);
    assert!(
        printed.contains("ktx2 in f16: 4 files") && printed.contains("png in unorm16: 4 files"),
        "{printed}"
    );
    bake(directory.path(), "again", &["--format", ALL, "--threads", "3"]);
    assert_eq!(contents(&out), contents(&again));

    let (files, about) = (contents(&out), manifest(&out));
    let tables = about["tables"].as_array().unwrap();
    // 10 formats, two files of the raw one
    assert_eq!((tables.len(), files.len()), (4, 4 * 11 + 1));
    for table in tables {
        let id = table["id"].as_str().unwrap();
        let ends: Vec<&str> = table["files"]
            .as_array()
            .unwrap()
            .iter()
            .map(|file| {
                let name = file["file"].as_str().unwrap();
                let bytes = &files[name];
                assert_eq!(file["bytes"], bytes.len());
                assert_eq!(file["sha256"], sha256_hex(bytes).as_str());
                let (error, of_table) = (
                    file["lookup_error"].as_f64().unwrap(),
                    table["between"]["error"]
                        .as_f64()
                        .or(table["max_texel_error"].as_f64())
                        .unwrap(),
                );
                // half a step of each storage at 1, and f32 for the texels themselves
                let most = match file["storage"].as_str().unwrap() {
                    "f32" => 0.0,
                    "f16" => 2f64.powi(-11),
                    "unorm16" => 0.5 / 65535.0,
                    other => panic!("{other}"),
                };
                assert!(
                    error >= of_table && error <= of_table + most + 2f64.powi(-23),
                    "{name} {error} {of_table}"
                );
                name.strip_prefix(id).unwrap()
            })
            .collect();
        assert_eq!(
            ends,
            [
                ".ktx2", ".dds", ".png", ".bin", ".json", ".h", ".rs", ".glsl", ".hlsl", ".wgsl"
            ]
        );
    }
    // the table itself is what it is without formats
    bake(directory.path(), "plain", &[]);
    for (name, bytes) in contents(&directory.path().join("plain")) {
        assert!(name == "manifest.json" || files[&name] == bytes, "{name}");
    }
}

#[test]
fn tables_are_computed_once_whatever_their_formats() {
    let directory = scene(SCENE);
    let out = directory.path().join("out");
    bake(directory.path(), "out", &[]);
    let plain = manifest(&out);
    let found = |printed: &str| {
        serde_json::from_str::<Value>(printed).unwrap()["found_finished"]
            .as_array()
            .unwrap()
            .len()
    };
    // from the cache, then from what is in place, in a new format each time
    let printed = bake(directory.path(), "out", &["--json", "--format", "ktx2,wgsl"]);
    assert_eq!(found(&printed), 4);
    fs::remove_dir_all(out.join(".furnace")).unwrap();
    let printed = bake(
        directory.path(),
        "out",
        &["--json", "--format", "raw,ktx2,ktx2", "--storage", "unorm8"],
    );
    assert_eq!(found(&printed), 4);
    bake(
        directory.path(),
        "fresh",
        &["--format", "raw,ktx2", "--storage", "unorm8"],
    );
    let fresh = directory.path().join("fresh");
    assert_eq!(manifest(&out), manifest(&fresh));
    let old = contents(&out);
    for (name, bytes) in contents(&fresh).iter().filter(|(name, _)| *name != "manifest.json") {
        assert_eq!(old[name], *bytes, "{name}");
    }
    // files that are right are not written again, what was damaged is
    let name = old.keys().find(|name| name.ends_with(".ktx2")).unwrap();
    fs::write(out.join(name), b"damaged").unwrap();
    bake(
        directory.path(),
        "out",
        &["--format", "raw,ktx2", "--storage", "unorm8"],
    );
    assert_eq!(fs::read(out.join(name)).unwrap(), old[name]);
    // without formats the manifest is as it was, and files of earlier bakes are told of
    let printed = bake(directory.path(), "out", &[]);
    assert_eq!(manifest(&out), plain);
    assert!(
        printed.contains("that this bake did not write") && printed.contains(name.as_str()),
        "{printed}"
    );
    // nothing is kept in the cache but tables
    let cache = fs::read_dir(out.join(".furnace")).unwrap();
    let names: Vec<String> = cache
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    assert!(names.iter().all(|name| name.ends_with(".exr")), "{names:?}");
}

#[test]
fn no_cache_writes_formats_too() {
    let directory = scene(SCENE);
    bake(directory.path(), "out", &["--no-cache", "--format", "png"]);
    let out = directory.path().join("out");
    assert_eq!(contents(&out).keys().filter(|name| name.ends_with(".png")).count(), 4);
    assert!(!out.join(".furnace").exists());
}

#[test]
fn wrong_names_and_combinations_are_refused_before_the_work() {
    let directory = scene(SCENE);
    let refused = |arguments: &[&str]| refused(directory.path(), arguments);
    assert!(refused(&["--format", "jpeg"]).contains("jpeg is none of exr, ktx2, dds, png, raw, c, rust"));
    assert!(refused(&["--format", ""]).contains("is none of exr"));
    assert!(refused(&["--format", "ktx2,,png"]).contains("is none of exr"));
    assert!(refused(&["--format", "KTX2"]).contains("KTX2 is none of"));
    assert!(refused(&["--format", "ktx2", "--storage", "f64"]).contains("f64 is none of f32, f16, unorm16, unorm8"));
    let float = refused(&["--format", "ktx2,png", "--storage", "f16"]);
    assert!(
        float.contains("--storage f16 is not allowed with --format png: choose --storage unorm16 or unorm8"),
        "{float}"
    );
    let alone = refused(&["--storage", "f16"]);
    assert!(alone.contains("not allowed with --format exr alone"), "{alone}");
    assert!(!directory.path().join("out").exists());
}

/// Tables whose identifiers are the same would be one in a program, whichever the compiler took.
#[test]
fn names_that_source_text_cannot_tell_apart_are_refused() {
    for [one, other] in [["rough", "rough_"], ["a-b", "a_b"], ["a.b", "a-b"]] {
        let text = SCENE.replace("\"rough\"", &format!("\"{one}\""));
        let directory = scene(&text.replace("\"range\"", &format!("\"{other}\"")));
        let errors = refused(directory.path(), &["--format", "ktx2,c"]);
        assert!(
            errors.contains(&format!("--format c: the tables {one}.rho_hd and {other}.rho_hd"))
                && errors.contains("rename a material"),
            "{errors}"
        );
        assert!(!directory.path().join("out").exists());
        bake(directory.path(), "out", &["--format", "ktx2"]);
    }
}

/// What rounding adds to the error that was asked for is told.
#[test]
fn tolerances_that_a_storage_exceeds_are_told_of() {
    let directory = scene(SCENE);
    let arguments = [
        "bake",
        "scene.toml",
        "--tolerance",
        "1e-3",
        "--format",
        "png,ktx2",
        "--storage",
        "unorm8",
    ];
    let output = furnace(directory.path(), &[&arguments[..], &["--out", "out"]].concat());
    let text = String::from_utf8(output.stdout).unwrap();
    assert!(
        text.contains("png in unorm8") && text.contains("more than 1e-3: rounding adds"),
        "{text}"
    );
}

/// What cannot be written is found out before anything takes its name.
#[test]
fn nothing_is_published_when_a_format_fails() {
    let directory = scene(SCENE);
    let out = directory.path().join("out");
    bake(directory.path(), "out", &["--format", "ktx2"]);
    let before = contents(&out);
    let name = before.keys().find(|name| name.ends_with(".ktx2")).unwrap();
    let taken = out.join(name.replace("ktx2", "dds"));
    fs::create_dir(&taken).unwrap();
    // another estimator: other tables
    let other = [
        "--format",
        "dds,ktx2",
        "--estimator",
        "qmc-visible",
        "--samples",
        "4096",
    ];
    let error = refused(directory.path(), &other);
    assert!(
        error.contains(&taken.file_name().unwrap().to_string_lossy().into_owned()),
        "{error}"
    );
    assert_eq!(contents(&out), before);
    let parts = fs::read_dir(out.join(".furnace")).unwrap();
    assert!(
        parts
            .flatten()
            .all(|entry| entry.file_name().to_string_lossy().ends_with(".exr"))
    );
}

/// A lobe that reflects more than it gets has no place in [0, 1].
#[test]
fn values_beyond_a_storage_are_named() {
    let directory = scene(
        "[[material]]\nname = \"bright\"\nbxdf = { type = \"microfacet\", masking = \"none\", distribution = { type = \"vmf\", \
         kappa = 17.0 }, fresnel = { type = \"none\" } }\n",
    );
    let out = directory.path().join("out");
    let error = refused(directory.path(), &["--format", "ktx2,png"]);
    assert!(
        error.contains("bright") && error.contains("is beyond unorm16: choose f16 or f32"),
        "{error}"
    );
    assert!(error.contains("2 tables are finished and kept"), "{error}");
    assert!(contents(&out).is_empty());
    bake(directory.path(), "out", &["--format", "ktx2"]);
}

#[test]
fn no_file_replaces_the_manifest() {
    let directory = scene(&SCENE.replace("\"rough\"", "\"manifest\""));
    // the name of a table is that of its material and its quantity, so that this is no more than a precaution
    bake(directory.path(), "out", &["--format", "raw"]);
    assert!(manifest(&directory.path().join("out"))["tables"].is_array());
}
