//! Same scene, seed and version: the same bytes, on any number of threads.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::process::Command;
use whitefurnace::export::read::{Contents, read_exr};
use whitefurnace::table::Table;

/// Bakes the default scene into `directory` and returns every file that is there for others.
fn bake(directory: &Path, arguments: &[&str]) -> BTreeMap<String, Vec<u8>> {
    let output = Command::new(env!("CARGO_BIN_EXE_furnace"))
        .arg("bake")
        .arg("--out")
        .arg(directory)
        .args(arguments)
        .output()
        .unwrap();
    assert!(
        output.status.success(),
        "{arguments:?}: {}",
        String::from_utf8_lossy(&output.stderr)
    );
    let paths = fs::read_dir(directory).unwrap().map(|entry| entry.unwrap().path());
    let read = |path: std::path::PathBuf| {
        let name = path.file_name().unwrap().to_string_lossy().into_owned();
        (name, fs::read(path).unwrap())
    };
    paths.filter(|path| path.is_file()).map(read).collect()
}

fn assert_same(first: &BTreeMap<String, Vec<u8>>, second: &BTreeMap<String, Vec<u8>>, what: &str) {
    let names = |files: &BTreeMap<String, Vec<u8>>| files.keys().cloned().collect::<Vec<_>>();
    assert_eq!(names(first), names(second), "{what}");
    for (name, bytes) in first {
        assert!(*bytes == second[name], "{what}: {name} differs");
    }
}

fn table(directory: &Path, name: &str) -> Table {
    match read_exr(&directory.join(name)).unwrap().contents {
        Contents::Table { table, .. } => *table,
        Contents::Foreign(_) => panic!("{name} is no table"),
    }
}

/// Bakes on 1, 2 and 8 threads.
fn same_on_any_threads(arguments: &[&str]) {
    let directory = tempfile::tempdir().unwrap();
    let run = |threads: &str| {
        let arguments = [arguments, &["--threads", threads]].concat();
        bake(&directory.path().join(threads), &arguments)
    };
    let first = run("1");
    assert!(first.len() > 15 && first.contains_key("manifest.json"));
    for threads in ["2", "8"] {
        assert_same(&first, &run(threads), &format!("{arguments:?} on {threads} threads"));
    }
}

#[test]
fn quadrature_gives_the_same_bytes_on_any_threads() {
    same_on_any_threads(&[
        "--resolution",
        "16",
        "--roughness-resolution",
        "4",
        "--azimuth-resolution",
        "4",
    ]);
}

/// Sizes that are chosen are chosen alike.
#[test]
fn chosen_sizes_give_the_same_bytes_on_any_threads() {
    same_on_any_threads(&["--tolerance", "1e-2"]);
}

/// The size that users get, once against another number of threads.
#[test]
fn the_default_bake_gives_the_same_bytes() {
    let directory = tempfile::tempdir().unwrap();
    let first = bake(&directory.path().join("first"), &["--threads", "1"]);
    let second = bake(&directory.path().join("second"), &["--threads", "8"]);
    assert_same(&first, &second, "default bake");
}

/// More samples than one batch holds, so that batches are merged too.
#[test]
fn monte_carlo_gives_the_same_bytes_on_any_threads() {
    same_on_any_threads(&[
        "--estimator",
        "mc-visible",
        "--samples",
        "40000",
        "--resolution",
        "4",
        "--roughness-resolution",
        "2",
        "--tolerance",
        "1e-3",
    ]);
}

#[test]
fn seeds_change_monte_carlo_and_nothing_else() {
    let directory = tempfile::tempdir().unwrap();
    let small = [
        "--resolution",
        "4",
        "--roughness-resolution",
        "2",
        "--tolerance",
        "1e-3",
    ];
    for (estimator, random) in [("mc-normals", true), ("quadrature", false)] {
        let paths = ["0", "1"].map(|seed| directory.path().join(format!("{estimator}-{seed}")));
        let [first, second] = [0, 1].map(|seed: usize| {
            let seed_text = seed.to_string();
            let chosen = ["--estimator", estimator, "--samples", "2000", "--seed", &seed_text];
            bake(&paths[seed], &[&small[..], &chosen].concat())
        });
        for name in first.keys().filter(|name| name.ends_with(".exr")) {
            let [a, b] = [0, 1].map(|seed: usize| table(&paths[seed], name));
            // rules draw no samples, and their tables say so whatever the seed
            assert_eq!((a.seed, b.seed), (0, u64::from(random)));
            if random {
                assert_ne!(a.values, b.values, "{name}");
                // both are right: 6 half-widths of 99 % apart would be 11 standard deviations of the difference
                for ((a, b), error) in a.values.iter().zip(&b.values).zip(&a.errors) {
                    assert!(
                        ((*a - *b).abs() - 6.0 * *error).max_element() <= 0.0,
                        "{name}: {a} and {b}"
                    );
                }
            } else {
                assert_eq!(a.values, b.values, "{name}");
                assert_eq!(a.errors, b.errors, "{name}");
                assert_eq!(a.between, b.between, "{name}");
            }
        }
        assert_eq!(first.len(), second.len());
    }
}
