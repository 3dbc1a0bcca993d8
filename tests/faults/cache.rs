//! The cache beside the tables: no name, no order and no way back costs a computation, and what is damaged costs nothing but one.

use super::directory::{
    Files, assert_finished, bake, cached, entry_name, errors, files, good, names, scene, taken_over,
};
use std::fs;
use std::path::{Path, PathBuf};
use whitefurnace::export::manifest::Manifest;
use whitefurnace::export::store::CACHE;

const SCENE: [f64; 3] = [1.0, 17.0, 300.0];

/// The scene file `s.toml` with one name replaced by another.
fn renamed(path: &Path, name: &str, other: &str) -> PathBuf {
    let text = fs::read_to_string(path).unwrap();
    let renamed = text.replace(&format!("name = \"{name}\""), &format!("name = \"{other}\""));
    assert_ne!(renamed, text);
    fs::write(path, renamed).unwrap();
    path.to_path_buf()
}

fn manifest(out: &Path) -> Manifest {
    Manifest::read(&out.join("manifest.json")).unwrap()
}

#[test]
fn names_and_order_cost_no_computation() {
    let directory = tempfile::tempdir().unwrap();
    let out = directory.path().join("out");
    let path = scene(directory.path(), "s.toml", &SCENE);
    good(bake(&path, &out));
    let first = files(&out);
    // the bytes are those of a bake that never knew another name
    let path = renamed(&path, "k17", "methanol");
    let all = [
        "k1.rho_hd",
        "k1.rho_hh",
        "methanol.rho_hd",
        "methanol.rho_hh",
        "k300.rho_hd",
        "k300.rho_hh",
    ];
    assert_eq!(taken_over(&path, &out, &[]), all);
    for quantity in ["rho_hd", "rho_hh"] {
        let bytes = fs::read(out.join(format!("methanol.{quantity}.exr"))).unwrap();
        assert_eq!(bytes, first[&format!("k17.{quantity}.exr")]);
    }
    let fresh = directory.path().join("fresh");
    assert_eq!(taken_over(&path, &fresh, &[]), [""; 0]);
    let mut expected = files(&fresh);
    // the tables of a name that nobody uses any more stay
    let left = first.iter().filter(|(name, _)| name.starts_with("k17."));
    expected.extend(left.map(|(name, bytes)| (name.clone(), bytes.clone())));
    assert_finished(&out, &expected, "renamed");
    // names that change places
    let path = renamed(&path, "k1", "other");
    let path = renamed(&path, "k300", "k1");
    let path = renamed(&path, "other", "k300");
    assert_eq!(taken_over(&path, &out, &[]).len(), 6);
    assert_eq!(fs::read(out.join("k1.rho_hd.exr")).unwrap(), first["k300.rho_hd.exr"]);
    // and their order
    let path = scene(directory.path(), "s.toml", &[300.0, 17.0, 1.0]);
    assert_eq!(taken_over(&path, &out, &[]).len(), 6);
    let left = |name: &str| !name.starts_with("methanol.") && name != "manifest.json";
    let tables = |files: Files| -> Files { files.into_iter().filter(|(name, _)| left(name)).collect() };
    assert_eq!(tables(files(&out)), tables(first));
}

/// Random streams are named by what is sampled: another name gives the same samples, another model gives others.
#[test]
fn samples_do_not_depend_on_names() {
    let directory = tempfile::tempdir().unwrap();
    let sampled = ["--estimator", "mc-visible", "--samples", "1000", "--resolution", "4"];
    let baked = |path: &Path, name: &str| {
        let out = directory.path().join(name);
        assert_eq!(taken_over(path, &out, &sampled), [""; 0]);
        files(&out)
    };
    let path = scene(directory.path(), "s.toml", &[17.0]);
    let first = baked(&path, "first");
    let second = baked(&renamed(&path, "k17", "methanol"), "second");
    assert_eq!(first["k17.rho_hd.exr"], second["methanol.rho_hd.exr"]);
    assert_eq!(first["k17.rho_hh.exr"], second["methanol.rho_hh.exr"]);
}

#[test]
fn one_change_costs_one_computation_and_the_way_back_none() {
    let directory = tempfile::tempdir().unwrap();
    let out = directory.path().join("out");
    let path = scene(directory.path(), "s.toml", &SCENE);
    good(bake(&path, &out));
    let first = files(&out);
    let others = ["k1.rho_hd", "k1.rho_hh", "k300.rho_hd", "k300.rho_hh"];
    for kappa in [18.0, 19.0] {
        // under the same name
        let path = renamed(
            &scene(directory.path(), "s.toml", &[1.0, kappa, 300.0]),
            &format!("k{kappa}"),
            "k17",
        );
        assert_eq!(taken_over(&path, &out, &[]), others);
    }
    assert_ne!(files(&out), first);
    let before = std::time::SystemTime::now();
    let path = scene(directory.path(), "s.toml", &SCENE);
    assert_eq!(taken_over(&path, &out, &[]).len(), 6);
    assert_eq!(files(&out), first);
    // a name with another file has another time: who converts tables that are newer than his own finds it. Clocks of file
    // systems lag behind by a few ticks.
    let modified = fs::metadata(out.join("k17.rho_hd.exr")).unwrap().modified().unwrap();
    assert!(modified + std::time::Duration::from_millis(50) > before);
    assert_eq!(cached(&out).len(), 2 * 5);
}

/// Whatever becomes of an entry: it is said, and in the end everything is as it should be.
#[test]
fn damaged_entries_are_said_and_replaced() {
    let directory = tempfile::tempdir().unwrap();
    let out = directory.path().join("out");
    let path = scene(directory.path(), "s.toml", &[17.0]);
    good(bake(&path, &out));
    let first = files(&out);
    let name = entry_name(&manifest(&out), "k17.rho_hd");
    let (entry, place) = (out.join(CACHE).join(&name), out.join("k17.rho_hd.exr"));
    let whole = fs::read(&entry).unwrap();
    let put = |bytes: &[u8]| {
        fs::remove_file(&entry).unwrap();
        fs::write(&entry, bytes).unwrap();
    };
    let mut flipped = whole.clone();
    flipped[whole.len() / 2] ^= 1;
    let other = fs::read(out.join("k17.rho_hh.exr")).unwrap();
    let damages: [(&str, &dyn Fn()); 7] = [
        ("one byte", &|| put(&flipped)),
        ("cut short", &|| put(&whole[..whole.len() - 1])),
        ("empty", &|| put(b"")),
        ("another table", &|| put(&other)),
        ("a directory", &|| {
            fs::remove_file(&entry).unwrap();
            fs::create_dir(&entry).unwrap();
        }),
        ("a directory with something in it", &|| {
            fs::remove_file(&entry).unwrap();
            fs::create_dir_all(entry.join("more")).unwrap();
        }),
        ("unreadable", &|| {
            #[cfg(unix)]
            {
                put(&whole);
                let mode = std::os::unix::fs::PermissionsExt::from_mode(0o000);
                fs::set_permissions(&entry, mode).unwrap();
                if fs::read(&entry).is_ok() {
                    println!("the superuser may read anything: a link to nowhere instead");
                    fs::remove_file(&entry).unwrap();
                    std::os::unix::fs::symlink("nowhere", &entry).unwrap();
                }
            }
        }),
    ];
    for (what, damage) in damages {
        for in_place in [true, false] {
            damage();
            if !in_place {
                fs::remove_file(&place).unwrap();
            }
            let mut command = bake(&path, &out);
            command.arg("--json");
            let output = good(command);
            let message = errors(&output);
            let next = match in_place {
                true => "k17.rho_hd is taken from another file",
                false => "k17.rho_hd is computed again",
            };
            assert!(
                message.starts_with("note: ")
                    && message.contains(&format!("{name} is damaged: "))
                    && message.contains(next)
                    && message.lines().count() == 1,
                "{what}: {message}"
            );
            assert_finished(&out, &first, what);
        }
    }
}

/// A file in place that is not what it was, over an entry that is.
#[test]
fn damaged_tables_are_put_back_from_the_cache() {
    let directory = tempfile::tempdir().unwrap();
    let out = directory.path().join("out");
    let path = scene(directory.path(), "s.toml", &[17.0]);
    good(bake(&path, &out));
    let first = files(&out);
    let place = out.join("k17.rho_hd.exr");
    for bytes in [Some(&b"damaged"[..]), Some(b""), Some(&first["k17.rho_hh.exr"]), None] {
        fs::remove_file(&place).unwrap();
        if let Some(bytes) = bytes {
            fs::write(&place, bytes).unwrap();
        }
        assert_eq!(taken_over(&path, &out, &[]).len(), 2);
        assert_finished(&out, &first, "put back");
    }
}

/// Tables in place stand for the cache where somebody has deleted it, also under other names.
#[test]
fn a_deleted_cache_is_made_again_from_the_tables() {
    let directory = tempfile::tempdir().unwrap();
    let out = directory.path().join("out");
    let path = scene(directory.path(), "s.toml", &SCENE);
    good(bake(&path, &out));
    let first = files(&out);
    fs::remove_dir_all(out.join(CACHE)).unwrap();
    assert_eq!(taken_over(&path, &out, &[]).len(), 6);
    assert_finished(&out, &first, "taken from their places");
    fs::remove_dir_all(out.join(CACHE)).unwrap();
    let path = renamed(&path, "k17", "methanol");
    assert_eq!(taken_over(&path, &out, &[]).len(), 6);
    // copied elsewhere without the cache: a checkout, an archive
    let copy = directory.path().join("copy");
    fs::create_dir(&copy).unwrap();
    first
        .iter()
        .for_each(|(name, bytes)| fs::write(copy.join(name), bytes).unwrap());
    let path = renamed(&path, "methanol", "k17");
    assert_eq!(taken_over(&path, &copy, &[]).len(), 6);
    assert_finished(&copy, &first, "copied");
}

/// A bake that is to compute everything finds nothing, replaces what it computes, and leaves no entries of its own.
#[test]
fn no_cache_leaves_no_entries() {
    let directory = tempfile::tempdir().unwrap();
    let (out, fresh) = (directory.path().join("out"), directory.path().join("fresh"));
    let path = scene(directory.path(), "s.toml", &[17.0]);
    assert_eq!(taken_over(&path, &fresh, &["--no-cache"]), [""; 0]);
    let expected = files(&fresh);
    assert_eq!(names(&fresh), expected.keys().cloned().collect::<Vec<_>>());
    // over a cache with the same tables and others: the others stay
    let other = scene(directory.path(), "other.toml", &[300.0]);
    good(bake(&other, &out));
    good(bake(&path, &out));
    assert_eq!(cached(&out).len(), 4);
    assert_eq!(taken_over(&path, &out, &["--no-cache"]), [""; 0]);
    assert_eq!(cached(&out).len(), 2);
    for (name, bytes) in expected {
        assert_eq!(files(&out)[&name], bytes, "{name}");
    }
    assert_eq!(taken_over(&other, &out, &[]).len(), 2);
}
