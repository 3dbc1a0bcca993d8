//! A directory of tables, before, during and after a bake, and how a bake is started.

use serde_json::Value;
use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, Instant};
use whitefurnace::export::manifest::Manifest;
use whitefurnace::export::read::read_exr;
use whitefurnace::export::sha256_hex;
use whitefurnace::export::store::CACHE;

/// Names and contents of files.
pub(crate) type Files = BTreeMap<String, Vec<u8>>;

/// A directory in memory where the system has one: what is killed there need not wait for a disk.
pub(crate) fn quick_directory() -> tempfile::TempDir {
    tempfile::tempdir_in("/dev/shm")
        .or_else(|_| tempfile::tempdir())
        .unwrap()
}

/// A scene file of several quick tables.
pub(crate) fn scene(directory: &Path, name: &str, kappas: &[f64]) -> PathBuf {
    let material = |kappa: &f64| {
        format!(
            "[[material]]\nname = \"k{kappa}\"\n[material.bxdf]\ntype = \"microfacet\"\nmasking = \"v-groove\"\n\
             distribution = {{ type = \"vmf\", kappa = {kappa} }}\nfresnel = {{ type = \"none\" }}\n"
        )
    };
    let path = directory.join(name);
    fs::write(&path, kappas.iter().map(material).collect::<String>()).unwrap();
    path
}

/// The scene file `s.toml` of so many lobes: long enough to be interrupted.
pub(crate) fn long_scene(directory: &Path, lobes: i32) -> PathBuf {
    let kappas: Vec<f64> = (0..lobes).map(|i| 3.0 + f64::from(i)).collect();
    scene(directory, "s.toml", &kappas)
}

/// A scene file of so many materials called `m0`, `m1`, ... with a table each that takes no time, all of them different: the mean
/// of a smooth metal over a diffuse base is a single texel.
pub(crate) fn single_texels(directory: &Path, name: &str, count: usize, eta: f64) -> PathBuf {
    let material = |i: usize| {
        let eta = eta + i as f64 / 4096.0;
        format!(
            "[[material]]\nname = \"m{i}\"\nbxdf = {{ type = \"diffuse-specular\", ks = 1.0, kd = 0.5, specular = {{ type = \
             \"specular-reflection\", fresnel = {{ type = \"conductor\", eta = {eta}, k = 2.0 }} }} }}\n"
        )
    };
    let path = directory.join(name);
    fs::write(&path, (0..count).map(material).collect::<String>()).unwrap();
    path
}

/// A bake of `scene` into `out`, ready to be started.
pub(crate) fn bake(scene: &Path, out: &Path) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_furnace"));
    command.arg("bake").arg(scene).arg("--out").arg(out);
    command
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped());
    command
}

/// Runs a bake that has to succeed.
pub(crate) fn good(mut command: Command) -> Output {
    let output = command.output().unwrap();
    assert!(output.status.success(), "{}", errors(&output));
    output
}

/// What a run wrote to standard error.
pub(crate) fn errors(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// Standard error of a run that has to end with exit code 2, and how many lines it has.
pub(crate) fn refused(mut command: Command) -> String {
    let output = command.output().unwrap();
    let text = errors(&output);
    assert_eq!(output.status.code(), Some(2), "{text}");
    assert!(text.contains("error: ") && !text.contains("panicked"), "{text}");
    text
}

/// Files under their final names. Of manifests without what they say to be reused: that depends on what was there before.
pub(crate) fn files(directory: &Path) -> Files {
    let Ok(entries) = fs::read_dir(directory) else {
        return Files::new();
    };
    let paths = entries.map(|entry| entry.unwrap().path()).filter(|path| path.is_file());
    let name = |path: &Path| path.file_name().unwrap().to_str().unwrap().to_owned();
    let content = |path: &Path| match Manifest::read(path) {
        Ok(manifest) => {
            let reused = Vec::new();
            Manifest { reused, ..manifest }.to_json().unwrap().into_bytes()
        }
        Err(_) => fs::read(path).unwrap(),
    };
    paths.map(|path| (name(&path), content(&path))).collect()
}

/// Everything in the directory, hidden files too, by name.
pub(crate) fn names(directory: &Path) -> Vec<String> {
    let mut names: Vec<String> = fs::read_dir(directory)
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    names.sort();
    names
}

/// Whether every visible file is one of the allowed ones, complete, and a manifest speaks of what is there.
pub(crate) fn assert_whole(directory: &Path, allowed: &[&Files], what: &str) {
    let found = files(directory);
    for (name, bytes) in &found {
        assert!(
            allowed.iter().any(|files| files.get(name) == Some(bytes)),
            "{what}: {name} is neither of the bake before nor of this one"
        );
        if name.ends_with(".exr") {
            read_exr(&directory.join(name)).unwrap();
        }
    }
    if let Some(json) = found.get("manifest.json") {
        let manifest = Manifest::from_json(std::str::from_utf8(json).unwrap()).unwrap();
        for entry in &manifest.tables {
            let bytes = found.get(&entry.file);
            assert!(
                bytes.is_some_and(|bytes| sha256_hex(bytes) == entry.sha256),
                "{what}: the manifest speaks of another {}",
                entry.file
            );
        }
    }
}

/// Whether the directory holds exactly `expected`, and a cache with an entry for each table and nothing but entries.
pub(crate) fn assert_finished(directory: &Path, expected: &Files, what: &str) {
    let found = files(directory);
    let mut all: Vec<String> = expected.keys().cloned().collect();
    all.insert(0, CACHE.into());
    assert_eq!(names(directory), all, "{what}");
    assert!(found == *expected, "{what}: other bytes than those of a bake in one go");
    let cache = directory.join(CACHE);
    for name in names(&cache) {
        let hash = name[33..].strip_suffix(".exr").unwrap();
        let bytes = fs::read(cache.join(&name)).unwrap();
        assert!(sha256_hex(&bytes).starts_with(hash), "{what}: entry {name} is damaged");
    }
    let manifest = Manifest::read(&directory.join("manifest.json")).unwrap();
    for entry in &manifest.tables {
        let name = entry_name(&manifest, &entry.id);
        assert!(cache.join(&name).exists(), "{what}: no entry {name} for {}", entry.id);
    }
}

/// Name of the entry of the table `id` of a manifest.
pub(crate) fn entry_name(manifest: &Manifest, id: &str) -> String {
    let table = manifest.tables.iter().find(|entry| entry.id == id).unwrap();
    format!("{}-{}.exr", &manifest.requests[id][..32], &table.sha256[..32])
}

/// Names of the entries of the cache.
pub(crate) fn cached(out: &Path) -> Vec<String> {
    let entries = fs::read_dir(out.join(CACHE)).into_iter().flatten().flatten();
    let names = entries.map(|entry| entry.file_name().into_string().unwrap());
    names.filter(|name| name.ends_with(".exr")).collect()
}

/// Starts a bake and waits until the first tables are kept.
pub(crate) fn begun(mut command: Command, out: &Path) -> Child {
    let mut child = command.spawn().unwrap();
    let start = Instant::now();
    while cached(out).len() < 3 {
        if let Some(status) = child.try_wait().unwrap() {
            panic!("the bake ended with {status} before anything was kept");
        }
        assert!(start.elapsed() < Duration::from_secs(60));
        std::thread::sleep(Duration::from_millis(1));
    }
    child
}

/// Bakes, and returns the ids of the tables that were taken over.
pub(crate) fn taken_over(scene: &Path, out: &Path, arguments: &[&str]) -> Vec<String> {
    let mut command = bake(scene, out);
    command.arg("--json").args(arguments);
    let output = good(command);
    let value: Value = serde_json::from_slice(&output.stdout).unwrap();
    let ids = value["found_finished"].as_array().unwrap();
    assert_eq!(value["manifest"]["reused"], value["found_finished"]);
    ids.iter().map(|id| id.as_str().unwrap().to_owned()).collect()
}
