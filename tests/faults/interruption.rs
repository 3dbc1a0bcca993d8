//! Killed at any moment, a bake leaves whole files only, and the next one goes on and ends with the same bytes.

use super::directory::{
    Files, assert_finished, assert_whole, bake, begun, cached, entry_name, errors, files, good, long_scene,
    quick_directory, refused, scene, single_texels,
};
use std::fs;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};
use whitefurnace::export::manifest::Manifest;
use whitefurnace::export::store::CACHE;
use whitefurnace::numerics::stream::{Stream, StreamId};

/// How many bakes are killed in each test; `FURNACE_KILLS` sets more for a long run.
fn kills() -> u64 {
    let more = std::env::var("FURNACE_KILLS").ok();
    more.map_or(30, |text| text.parse().expect("FURNACE_KILLS is a count"))
}

fn stream(cell: u64) -> Stream {
    Stream::new(StreamId {
        seed: 5,
        cell,
        batch: 0,
    })
}

const OLD: [f64; 3] = [1.0, 17.0, 300.0];
const NEW: [f64; 7] = [1.0, 17.5, 300.0, 2000.0, 0.5, 40.0, 1e5];

/// The files of one bake in one go, and how long it takes.
fn reference(scene: &Path, out: &Path) -> (Files, Duration) {
    let start = Instant::now();
    good(bake(scene, out));
    (files(out), start.elapsed())
}

/// A bake over an earlier one, killed again and again until it comes through, at moments spread over all of its length.
#[test]
fn killed_bakes_leave_whole_files_and_end_with_the_same_bytes() {
    let directory = quick_directory();
    let path = |name: &str| directory.path().join(name);
    let [old, new] = [scene(&path(""), "s.toml", &OLD), scene(&path(""), "new.toml", &NEW)];
    let (before, _) = reference(&old, &path("before"));
    // the scene has the name of its file: the manifests of both say `s`
    fs::rename(new, &old).unwrap();
    let (mut after, length) = reference(&old, &path("after"));
    // a table that only the earlier bake had stays where it is
    let left: Files = before
        .iter()
        .filter(|(name, _)| !after.contains_key(*name))
        .map(|(name, bytes)| (name.clone(), bytes.clone()))
        .collect();
    after.extend(left);
    let mut random = stream(0);
    let (mut killed, mut rounds, mut resumed) = (0, 0, 0);
    while killed < kills() {
        rounds += 1;
        let out = path(&format!("out{rounds}"));
        fs::create_dir(&out).unwrap();
        before
            .iter()
            .for_each(|(name, bytes)| fs::write(out.join(name), bytes).unwrap());
        loop {
            let mut child = bake(&old, &out).spawn().unwrap();
            std::thread::sleep(length.mul_f64(0.7 * random.uniform()));
            child.kill().unwrap();
            let done = child.wait().unwrap().success();
            assert_whole(&out, &[&before, &after], &format!("round {rounds}, kill {killed}"));
            if done {
                break;
            }
            killed += 1;
            // beyond the four tables that both bakes have
            resumed += u64::from(cached(&out).len() > 4);
        }
        assert_finished(&out, &after, &format!("round {rounds}"));
    }
    println!("{killed} kills in {rounds} bakes; {resumed} left something to go on from");
    assert!(resumed > 0, "no bake was killed after its first table");
}

/// The moments at which files take their names, killed again and again: of hundreds of tables at once, so that some kills
/// fall in between.
#[test]
fn bakes_killed_while_files_take_their_names_leave_whole_files() {
    let directory = quick_directory();
    let path = |name: &str| directory.path().join(name);
    const COUNT: usize = 800;
    let scene = single_texels(directory.path(), "s.toml", COUNT, 0.5);
    let (before, _) = reference(&scene, &path("before"));
    single_texels(directory.path(), "s.toml", COUNT, 0.75);
    let (after, _) = reference(&scene, &path("after"));
    // all tables of the new bake are kept: a directory in the place of one of them is in the way of the renames
    let (out, kept_files) = (path("out"), path("kept"));
    fs::create_dir_all(out.join("m7.specular.rho_hh.exr")).unwrap();
    let message = refused(bake(&scene, &out));
    assert!(message.contains("m7.specular.rho_hh.exr"), "{message}");
    assert_eq!(cached(&out).len(), COUNT);
    fs::rename(out.join(CACHE), &kept_files).unwrap();
    let prepare = || {
        drop(fs::remove_dir_all(&out));
        fs::create_dir_all(out.join(CACHE)).unwrap();
        let write = |(name, bytes): (&String, &Vec<u8>)| fs::write(out.join(name), bytes).unwrap();
        before.iter().for_each(write);
        for entry in fs::read_dir(&kept_files).unwrap() {
            let from = entry.unwrap().path();
            fs::copy(&from, out.join(CACHE).join(from.file_name().unwrap())).unwrap();
        }
    };
    prepare();
    let start = Instant::now();
    good(bake(&scene, &out));
    let length = start.elapsed();
    let mut random = stream(1);
    let mut between = 0;
    for kill in 0..kills() {
        prepare();
        // nobody reads the report, which is longer than a pipe holds
        let mut child = bake(&scene, &out).stdout(Stdio::null()).spawn().unwrap();
        if kill % 2 == 0 {
            std::thread::sleep(length.mul_f64(0.4 + 0.6 * random.uniform()));
        } else {
            // the renames take the last few milliseconds, and begin when the manifest goes
            while out.join("manifest.json").exists() && child.try_wait().unwrap().is_none() {
                // not all the time: a core that only waits is one that the child does not get
                std::thread::sleep(Duration::from_micros(50));
            }
            std::thread::sleep(Duration::from_secs_f64(2e-3 * random.uniform()));
        }
        child.kill().unwrap();
        child.wait().unwrap();
        let what = format!("kill {kill}");
        assert_whole(&out, &[&before, &after], &what);
        between += u64::from(!out.join("manifest.json").exists());
        good(bake(&scene, &out));
        assert_finished(&out, &after, &what);
    }
    println!(
        "{between} of {} kills fell between the first rename and the last",
        kills()
    );
    assert!(between > 0, "no kill fell between the renames");
}

/// Every state between the first rename and the last, set up by hand: the next bake computes nothing and does all renames.
#[test]
fn a_bake_goes_on_from_every_rename() {
    let directory = quick_directory();
    let path = |name: &str| directory.path().join(name);
    let scene = scene(directory.path(), "s.toml", &[17.0, 300.0]);
    let (after, _) = reference(&scene, &path("after"));
    let manifest = Manifest::from_json(std::str::from_utf8(&after["manifest.json"]).unwrap()).unwrap();
    for renamed in 0..=manifest.tables.len() {
        let out = path(&format!("out{renamed}"));
        fs::create_dir_all(out.join(CACHE)).unwrap();
        fs::write(out.join(CACHE).join("manifest.part"), &after["manifest.json"]).unwrap();
        for (index, entry) in manifest.tables.iter().enumerate() {
            let kept = out.join(CACHE).join(entry_name(&manifest, &entry.id));
            fs::write(&kept, &after[&entry.file]).unwrap();
            let linked = match index < renamed {
                true => out.join(&entry.file),
                false => out.join(CACHE).join(format!("{index}.part")),
            };
            fs::hard_link(kept, linked).unwrap();
        }
        let report = good(bake(&scene, &out));
        let report = String::from_utf8_lossy(&report.stdout).into_owned();
        assert!(
            report.contains("4 of them found finished"),
            "{renamed} renamed: {report}"
        );
        assert_finished(&out, &after, &format!("{renamed} renamed"));
    }
}

/// What a bake says to Ctrl-C.
#[cfg(unix)]
fn interrupted(child: Child) -> String {
    let signal = Command::new("kill").args(["-INT", &child.id().to_string()]).status();
    assert!(signal.unwrap().success());
    let output = child.wait_with_output().unwrap();
    let message = errors(&output);
    assert_eq!(output.status.code(), Some(130), "{message}");
    message
}

/// Ctrl-C says what is kept, in so many words, and the same command goes on.
#[cfg(unix)]
#[test]
fn an_interrupt_says_what_is_kept() {
    let directory = tempfile::tempdir().unwrap();
    let scene = long_scene(directory.path(), 60);
    let out = directory.path().join("out");
    let child = begun(bake(&scene, &out), &out);
    let message = interrupted(child);
    let words: Vec<&str> = message.split_whitespace().collect();
    let [said, "of", "120", "tables", "are", "finished", "and", "kept", "in", ..] = words[1..] else {
        panic!("{message}");
    };
    assert!(message.contains(out.to_str().unwrap()), "{message}");
    // what it says is what there is
    let kept = cached(&out).len();
    assert_eq!(said.parse(), Ok(kept), "{message}");
    let report = good(bake(&scene, &out));
    let report = String::from_utf8_lossy(&report.stdout).into_owned();
    assert!(
        report.contains(&format!(
            "120 tables in {}, {kept} of them found finished",
            out.display()
        )),
        "{report}"
    );
    let fresh = directory.path().join("fresh");
    good(bake(&scene, &fresh));
    assert_finished(&out, &files(&fresh), "interrupted");
}

/// Also when the reader of its messages has gone: they are no reason to go on.
#[cfg(unix)]
#[test]
fn an_interrupt_ends_a_bake_that_nobody_listens_to() {
    let directory = tempfile::tempdir().unwrap();
    let scene = long_scene(directory.path(), 60);
    let out = directory.path().join("out");
    let mut child = begun(bake(&scene, &out), &out);
    drop(child.stderr.take());
    let signal = Command::new("kill").args(["-INT", &child.id().to_string()]).status();
    assert!(signal.unwrap().success());
    assert_eq!(child.wait().unwrap().code(), Some(130));
}

/// Interrupted before anything is finished, a bake leaves nothing at all.
#[cfg(unix)]
#[test]
fn an_early_interrupt_leaves_nothing() {
    let directory = tempfile::tempdir().unwrap();
    let text = "[[material]]\nname = \"slow\"\n[material.bxdf]\ntype = \"microfacet\"\nmasking = \"smith\"\n\
                distribution = { type = \"ggx\", alpha_x = 0.001, alpha_y = 0.9 }\n\
                fresnel = { type = \"dielectric\", eta = 0.6 }\n";
    let scene = directory.path().join("s.toml");
    fs::write(&scene, text).unwrap();
    let out = directory.path().join("made/in/vain");
    let mut command = bake(&scene, &out);
    command.args(["--azimuth-resolution", "4096"]);
    let child = command.spawn().unwrap();
    let start = Instant::now();
    while !out.join(CACHE).exists() {
        assert!(start.elapsed() < Duration::from_secs(60));
        std::thread::sleep(Duration::from_millis(1));
    }
    // the handler stands right after the directory
    std::thread::sleep(Duration::from_millis(300));
    let message = interrupted(child);
    assert!(
        message.contains("interrupted: no table was finished, nothing is kept"),
        "{message}"
    );
    assert!(!directory.path().join("made").exists());
}
