//! What a bake takes over from those before: what is the same and whole, and nothing else.

use super::directory::{
    Files, assert_finished, assert_whole, bake, begun, files, good, long_scene, refused, scene, taken_over,
};
use serde_json::Value;
use std::fs;
use whitefurnace::export::store::CACHE;

#[test]
fn only_what_changed_is_computed_again() {
    let directory = tempfile::tempdir().unwrap();
    let out = directory.path().join("out");
    let path = scene(directory.path(), "s.toml", &[1.0, 17.0, 300.0]);
    assert_eq!(taken_over(&path, &out, &[]), [""; 0]);
    let first = files(&out);
    let stamp = |name: &str| fs::metadata(out.join(name)).unwrap().modified().unwrap();
    let stamps = || -> Vec<_> { first.keys().map(|name| stamp(name)).collect() };
    let before = stamps();
    // the same again: every table is taken over, and no file is touched but the manifest, which says so
    assert_eq!(taken_over(&path, &out, &[]).len(), 6);
    let again = stamps();
    let touched = |a: &[_], b: &[_]| -> Vec<String> {
        let names = first.keys().zip(a.iter().zip(b));
        names
            .filter(|(_, (a, b))| a != b)
            .map(|(name, _)| name.clone())
            .collect()
    };
    assert_eq!(touched(&before, &again), ["manifest.json"]);
    assert_eq!(taken_over(&path, &out, &[]).len(), 6);
    assert_eq!(touched(&again, &stamps()), [""; 0]);
    assert_finished(&out, &first, "again");
    // another resolution: the tables of one texel have none
    let means = ["k1.rho_hh", "k17.rho_hh", "k300.rho_hh"];
    assert_eq!(taken_over(&path, &out, &["--roughness-resolution", "7"]).len(), 6);
    let finer = ["--tolerance", "1e-3"];
    assert_eq!(taken_over(&path, &out, &finer), [""; 0]);
    assert_eq!(taken_over(&path, &out, &finer).len(), 6);
    let chosen = files(&out);
    assert_ne!(chosen, first);
    // and back
    assert_eq!(taken_over(&path, &out, &[]).len(), 6);
    assert_finished(&out, &first, "back");
    assert_eq!(taken_over(&path, &out, &finer).len(), 6);
    assert_finished(&out, &chosen, "there again");
    // another material in the place of one
    let path = scene(directory.path(), "s.toml", &[1.0, 18.0, 300.0]);
    assert_eq!(
        taken_over(&path, &out, &finer),
        ["k1.rho_hd", "k1.rho_hh", "k300.rho_hd", "k300.rho_hh"]
    );
    // everything by request, with the same bytes
    let other = files(&out);
    assert_eq!(taken_over(&path, &out, &["--tolerance", "1e-3", "--no-cache"]), [""; 0]);
    assert_eq!(files(&out), other);
    // rules draw no samples: for them a seed changes nothing, and for samples everything
    assert_eq!(
        taken_over(&path, &out, &["--tolerance", "1e-3", "--seed", "1"]).len(),
        6
    );
    let sampled = [
        "--estimator",
        "mc-normals",
        "--samples",
        "4096",
        "--resolution",
        "2",
        "--seed",
    ];
    assert_eq!(taken_over(&path, &out, &[&sampled[..], &["1"]].concat()), [""; 0]);
    assert_eq!(taken_over(&path, &out, &[&sampled[..], &["2"]].concat()), [""; 0]);
    assert_eq!(taken_over(&path, &out, &[&sampled[..], &["1"]].concat()).len(), 6);
    assert!(means.iter().all(|mean| out.join(format!("{mean}.exr")).exists()));
}

/// One flipped bit, wherever it is, is found out, and the table computed again. The file in place and its entry are one.
#[test]
fn damaged_tables_are_not_taken_over() {
    let directory = tempfile::tempdir().unwrap();
    let out = directory.path().join("out");
    let path = scene(directory.path(), "s.toml", &[17.0]);
    good(bake(&path, &out));
    let first = files(&out);
    let name = "k17.rho_hd.exr";
    let length = first[name].len();
    for place in (0..length).step_by(length / 16) {
        let mut bytes = first[name].clone();
        bytes[place] ^= 4;
        fs::write(out.join(name), bytes).unwrap();
        assert_eq!(taken_over(&path, &out, &[]), ["k17.rho_hh"], "byte {place}");
        assert_finished(&out, &first, &format!("byte {place}"));
    }
    let forget = || fs::remove_dir_all(out.join(CACHE)).unwrap();
    // cut short, gone, or replaced by another table
    for bytes in [&first[name][..length / 2], &[], &first["k17.rho_hh.exr"]] {
        forget();
        fs::write(out.join(name), bytes).unwrap();
        assert_eq!(taken_over(&path, &out, &[]), ["k17.rho_hh"]);
        assert_finished(&out, &first, "replaced");
    }
    forget();
    fs::remove_file(out.join(name)).unwrap();
    assert_eq!(taken_over(&path, &out, &[]), ["k17.rho_hh"]);
    // a manifest that somebody has edited does not make one table pass for another
    let json = std::str::from_utf8(&first["manifest.json"]).unwrap();
    let mut forged: Value = serde_json::from_str(json).unwrap();
    let keys = forged["requests"].as_object_mut().unwrap();
    let [one, other] = ["k17.rho_hd", "k17.rho_hh"].map(|id| keys[id].clone());
    keys.insert("k17.rho_hd".into(), other);
    keys.insert("k17.rho_hh".into(), one);
    forget();
    fs::write(out.join("manifest.json"), forged.to_string()).unwrap();
    assert_eq!(taken_over(&path, &out, &[]), [""; 0]);
    assert_finished(&out, &first, "forged");
    // a manifest that is damaged vouches for nothing, and the cache needs none
    for json in ["", "{", "[]", "{\"format\": 1}"] {
        fs::write(out.join("manifest.json"), json).unwrap();
        assert_eq!(taken_over(&path, &out, &[]).len(), 2, "{json}");
        assert_finished(&out, &first, json);
        forget();
        fs::write(out.join("manifest.json"), json).unwrap();
        assert_eq!(taken_over(&path, &out, &[]), [""; 0], "{json}");
        assert_finished(&out, &first, json);
    }
}

/// What was kept is checked like what is in place, and parts of files are swept away.
#[test]
fn damaged_files_that_were_kept_are_not_taken_over() {
    let directory = tempfile::tempdir().unwrap();
    let path = long_scene(directory.path(), 40);
    let (out, fresh) = (directory.path().join("out"), directory.path().join("fresh"));
    good(bake(&path, &fresh));
    let mut child = begun(bake(&path, &out), &out);
    child.kill().unwrap();
    child.wait().unwrap();
    let cache = out.join(CACHE);
    let mut kept = files(&cache);
    kept.retain(|name, _| name.ends_with(".exr"));
    let (damaged, bytes) = kept.first_key_value().unwrap();
    let mut bytes = bytes.clone();
    *bytes.last_mut().unwrap() ^= 1;
    fs::write(cache.join(damaged), bytes).unwrap();
    fs::write(cache.join(".furnace-abc.part"), b"half").unwrap();
    // what nobody asks for is not looked at
    let digits = "0".repeat(32);
    let stray = cache.join(format!("{digits}-{digits}.exr"));
    fs::write(&stray, b"no table").unwrap();
    assert_eq!(taken_over(&path, &out, &[]).len(), kept.len() - 1);
    fs::remove_file(stray).unwrap();
    assert_finished(&out, &files(&fresh), "damaged while kept");
}

/// Two bakes into one directory would take each other's files apart.
#[test]
fn a_second_bake_is_kept_out() {
    let directory = tempfile::tempdir().unwrap();
    let path = long_scene(directory.path(), 60);
    let out = directory.path().join("out");
    let first = begun(bake(&path, &out), &out);
    let message = refused(bake(&path, &out));
    assert!(
        message.contains("another bake is writing into") && message.contains(out.to_str().unwrap()),
        "{message}"
    );
    let output = first.wait_with_output().unwrap();
    assert!(output.status.success(), "the first bake is not disturbed");
    // and the lock is gone with it
    assert_eq!(taken_over(&path, &out, &[]).len(), 120);
    let both: [&Files; 1] = [&files(&out)];
    assert_whole(&out, &both, "after both");
}
