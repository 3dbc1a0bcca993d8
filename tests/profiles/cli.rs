//! `furnace bake --profile` as its users meet it.

use serde_json::Value;
use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::Path;
use std::process::{Command, Output};
use whitefurnace::engine::Profile;
use whitefurnace::export::sha256_hex;

fn furnace(directory: &Path, arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_furnace"));
    command
        .current_dir(directory)
        .arg("bake")
        .args(arguments)
        .output()
        .unwrap()
}

fn text(bytes: &[u8]) -> &str {
    std::str::from_utf8(bytes).unwrap()
}

/// The directory `out` of a run that succeeds: profile.json, and all files by name.
fn baked(directory: &Path, arguments: &[&str]) -> (Value, BTreeMap<String, Vec<u8>>, String) {
    let output = furnace(directory, arguments);
    assert_eq!(output.status.code(), Some(0), "{arguments:?}: {}", text(&output.stderr));
    let all: BTreeMap<String, Vec<u8>> = fs::read_dir(directory.join("out"))
        .unwrap()
        .map(|entry| entry.unwrap())
        .map(|entry| {
            (
                entry.file_name().into_string().unwrap(),
                fs::read(entry.path()).unwrap(),
            )
        })
        .collect();
    let description = serde_json::from_slice(&all["profile.json"]).unwrap();
    (description, all, text(&output.stdout).to_owned())
}

/// Standard error of a run that is refused.
fn refused(arguments: &[&str]) -> String {
    let directory = tempfile::tempdir().unwrap();
    let output = furnace(directory.path(), arguments);
    assert_eq!(output.status.code(), Some(2), "{arguments:?}");
    assert_eq!(text(&output.stdout), "");
    assert_eq!(fs::read_dir(directory.path()).unwrap().count(), 0, "nothing is written");
    text(&output.stderr).to_owned()
}

/// Names, sizes and hashes of what was written are those that are listed, and nothing else is there.
fn all_are_listed(description: &Value, files: &BTreeMap<String, Vec<u8>>) {
    let mut listed: BTreeSet<&str> = ["profile.json"].into();
    for table in description["tables"].as_array().unwrap() {
        for file in table["files"].as_array().unwrap() {
            let name = file["file"].as_str().unwrap();
            assert_eq!(file["bytes"], files[name].len());
            assert_eq!(file["sha256"], sha256_hex(&files[name]).as_str());
            assert!(listed.insert(name), "{name} twice");
        }
    }
    assert_eq!(listed, files.keys().map(String::as_str).collect());
}

#[test]
fn a_profile_writes_what_its_description_lists() {
    let directory = tempfile::tempdir().unwrap();
    let (description, files, out) = baked(directory.path(), &["--profile", "three", "--out", "out"]);
    all_are_listed(&description, &files);
    assert_eq!(description["profile"], "three");
    assert_eq!(description["lookup"], Profile::Three.note());
    assert_eq!(files["dfgLUT.bin"].len(), 1024);
    assert_eq!(description["tables"][0]["texelBytes"], 1024);
    assert_eq!(description["tables"][0]["axes"][0]["parameter"], "roughness");
    // the errors that people read are those of the file
    let errors = description["tables"][0]["errors"].as_array().unwrap();
    let furnace = errors.iter().find(|error| error["of"] == "furnace").unwrap();
    let max = format!("{:.4} %", 100.0 * furnace["max"].as_f64().unwrap());
    assert!(
        out.contains(&max) && out.contains(Profile::Three.note()),
        "{max} in {out}"
    );
}

#[test]
fn threads_do_not_change_bytes() {
    let files = ["1", "2"].map(|threads| {
        let directory = tempfile::tempdir().unwrap();
        let sizes = ["--resolution", "4", "--roughness-resolution", "3"];
        let arguments = [&["--profile", "bevy", "--out", "out", "--threads", threads], &sizes[..]].concat();
        baked(directory.path(), &arguments).1
    });
    assert_eq!(files[0], files[1]);
}

#[test]
fn formats_storage_and_sizes_replace_those_of_the_engine() {
    let directory = tempfile::tempdir().unwrap();
    let arguments = [
        "--profile",
        "three",
        "--out",
        "out",
        "--format",
        "ktx2",
        "--storage",
        "f32",
        "--resolution",
        "8",
    ];
    let (description, files, _) = baked(directory.path(), &arguments);
    all_are_listed(&description, &files);
    let reader = ktx2::Reader::new(&files["dfgLUT.ktx2"]).unwrap();
    let header = reader.header();
    assert_eq!(header.format, Some(ktx2::Format::R32G32_SFLOAT));
    // columns are roughness, rows mu, and --resolution is of mu
    assert_eq!((header.pixel_width, header.pixel_height), (16, 8));
    assert_eq!(description["tables"][0]["storage"], "f32");
}

#[test]
fn sheen_is_skipped_where_nothing_calls_for_it() {
    let directory = tempfile::tempdir().unwrap();
    let scene = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/gltf/MetalRoughSpheresNoTextures.gltf");
    let scene = scene.to_str().unwrap();
    let sizes = ["--resolution", "4", "--roughness-resolution", "4"];
    let arguments = [&[scene, "--profile", "generic", "--out", "out"], &sizes[..]].concat();
    let (description, files, out) = baked(directory.path(), &arguments);
    all_are_listed(&description, &files);
    let names: Vec<&str> = files.keys().map(String::as_str).collect();
    assert_eq!(names, ["pair.ktx2", "pair_mean.ktx2", "profile.json"]);
    assert_eq!(description["skipped"]["sheen"], "no material calls for sheen");
    assert!(out.contains("Skipped sheen: no material calls for sheen."), "{out}");
}

#[test]
fn what_is_not_allowed_is_refused_with_what_is() {
    let errors = refused(&["--profile", "frostbite"]);
    let words = errors.split_whitespace().collect::<Vec<_>>().join(" ");
    assert!(words.contains("frostbite"), "{errors}");
    assert!(
        Profile::ALL.iter().all(|profile| words.contains(profile.name())),
        "{errors}"
    );
    for (option, value) in [
        ("--tolerance", "1e-5"),
        ("--samples", "64"),
        ("--axis", "mu"),
        ("--seed", "7"),
        ("--estimator", "mc-uniform"),
    ] {
        let errors = refused(&["--profile", "three", option, value]);
        assert!(errors.contains(option), "{errors}");
        if option == "--tolerance" {
            assert!(
                errors.contains("not allowed with --profile") && errors.contains("--resolution"),
                "{errors}"
            );
        }
    }
    // before the work
    let errors = refused(&["--profile", "filament", "--format", "png"]);
    assert!(
        errors.contains("filament keeps dfg in f16") && errors.contains("add --storage unorm16 or unorm8"),
        "{errors}"
    );
    let errors = refused(&[
        "--profile",
        "three",
        "--resolution",
        "16384",
        "--roughness-resolution",
        "16384",
    ]);
    assert!(errors.contains("integrals, more than 200 000 000"), "{errors}");
    let errors = refused(&["--profile", "three", "--format", "png", "--storage", "f16"]);
    assert!(
        errors.contains("--storage f16 is not allowed with --format png"),
        "{errors}"
    );
}
