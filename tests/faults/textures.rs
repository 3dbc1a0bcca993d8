//! Bakes that write textures, of a scene or of an engine, on full disks, over files in the way, and killed.

use super::directory::{
    Files, assert_finished, assert_whole, bake, cached, errors, files, good, long_scene, names, quick_directory,
    refused, scene,
};
use super::disk::{can_mount, mounted};
use std::fs;
use std::io::{BufRead, BufReader, Read};
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};
use whitefurnace::export::sha256_hex;
use whitefurnace::numerics::stream::{Stream, StreamId};

/// Room for all tables, but not for all of their textures: nothing takes its name, and with more room the bake goes on.
#[test]
fn textures_that_find_no_room_change_nothing() {
    if !can_mount() {
        return;
    }
    let directory = tempfile::tempdir().unwrap();
    let path = long_scene(directory.path(), 10);
    let [mount, copy, fresh] = ["mount", "copy", "fresh"].map(|name| directory.path().join(name));
    fs::create_dir(&mount).unwrap();
    fs::create_dir(&copy).unwrap();
    let mut command = bake(&path, &fresh);
    command.args(["--format", "ktx2,png,raw"]);
    good(command);
    // the tables take less than a third of all, see below
    let script = r#"
        mount -t tmpfs -o size=10m none "$3" || exit 99
        "$1" bake "$2" --out "$3/out" > /dev/null || exit 98
        used=$(df -k --output=used "$3" | tail -n 1)
        mount -o remount,size=$((used + 60))k "$3" || exit 97
        cp "$3/out/manifest.json" "$3/../before.json"
        "$1" bake "$2" --out "$3/out" --format ktx2,png,raw
        echo "code $?"
        ls "$3/out" | grep -c -v -e '[.]exr$' -e '^manifest.json$'
        ls -A "$3/out/.furnace" | grep -c -v '[.]exr$'
        cmp "$3/out/manifest.json" "$3/../before.json" && echo same
        mount -o remount,size=10m "$3" || exit 96
        "$1" bake "$2" --out "$3/out" --format ktx2,png,raw || exit 95
        cp -r "$3/out/." "$3/../copy"
    "#;
    let (code, out, message) = mounted(script, &path, &mount);
    assert_eq!(code, Some(0), "{out}{message}");
    let lines: Vec<&str> = out.lines().collect();
    assert_eq!(lines[..4], ["code 2", "0", "0", "same"], "{out}{message}");
    assert!(
        message.contains("error: cannot write") && message.contains(".part"),
        "{message}"
    );
    assert!(
        message.contains("No space left") && message.contains("20 tables are finished"),
        "{message}"
    );
    assert!(out.contains("20 of them found finished"), "{out}");
    assert_finished(&copy, &files(&fresh), "after the disk was full");
}

/// Bakes of other textures over earlier ones, killed again and again until they come through.
#[test]
fn killed_bakes_of_textures_leave_whole_files() {
    let directory = quick_directory();
    let path = scene(directory.path(), "s.toml", &[1.0, 17.0, 300.0]);
    let textures = |out: &Path, storage: &str| {
        let mut command = bake(&path, out);
        command.args(["--format", "ktx2,dds,raw,wgsl", "--storage", storage]);
        command
    };
    let reference = |name: &str, storage: &str| -> (Files, Duration) {
        let (out, start) = (directory.path().join(name), Instant::now());
        good(textures(&out, storage));
        (files(&out), start.elapsed())
    };
    let (before, _) = reference("before", "f32");
    let (after, length) = reference("after", "unorm16");
    let mut random = Stream::new(StreamId {
        seed: 5,
        cell: 2,
        batch: 0,
    });
    let mut killed = 0;
    for round in 0.. {
        if killed >= 20 {
            break;
        }
        let out = directory.path().join(format!("out{round}"));
        fs::create_dir(&out).unwrap();
        for (name, bytes) in &before {
            fs::write(out.join(name), bytes).unwrap();
        }
        loop {
            let mut child = textures(&out, "unorm16").spawn().unwrap();
            std::thread::sleep(length.mul_f64(random.uniform()));
            child.kill().unwrap();
            let done = child.wait().unwrap().success();
            let what = format!("kill {killed}");
            assert_whole(&out, &[&before, &after], &what);
            assert_listed(&out, &what);
            if done {
                break;
            }
            killed += 1;
        }
        assert_finished(&out, &after, "at last");
        assert_eq!(names(&out.join(".furnace")).len(), cached(&out).len());
    }
}

/// Whether the manifest, if there is one, speaks of the textures that are there.
fn assert_listed(out: &Path, what: &str) {
    for list in ["manifest.json", "profile.json"] {
        let Ok(bytes) = fs::read(out.join(list)) else { continue };
        let list: serde_json::Value = serde_json::from_slice(&bytes).unwrap();
        let tables = list["tables"].as_array().unwrap();
        for file in tables.iter().flat_map(|table| table["files"].as_array().unwrap()) {
            let bytes = fs::read(out.join(file["file"].as_str().unwrap())).unwrap();
            assert_eq!(file["sha256"], sha256_hex(&bytes).as_str(), "{what}: {file}");
        }
    }
}

/// A profile of small tables.
fn profile(out: &Path, storage: &str) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_furnace"));
    command.args([
        "bake",
        "--profile",
        PROFILE,
        "--resolution",
        "4",
        "--roughness-resolution",
        "4",
    ]);
    command
        .args(["--format", "ktx2,raw", "--storage", storage, "--out"])
        .arg(out);
    command
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped());
    command
}

const PROFILE: &str = "bevy";

#[test]
fn files_in_the_way_of_a_profile_change_nothing() {
    let directory = quick_directory();
    let out = directory.path().join("out");
    good(profile(&out, "f16"));
    let before = everything(&out);
    assert_listed(&out, "first");
    assert!(before.contains_key("profile.json") && before.len() > 2);
    let name = before.keys().find(|name| name.ends_with(".ktx2")).unwrap();
    for taken in [name.as_str(), "profile.json"] {
        let path = out.join(taken);
        fs::remove_file(&path).unwrap();
        fs::create_dir(&path).unwrap();
        let message = refused(profile(&out, "f32"));
        assert!(message.contains(path.to_str().unwrap()), "{message}");
        fs::remove_dir(&path).unwrap();
        fs::write(&path, &before[taken]).unwrap();
        assert!(everything(&out) == before, "{taken} in the way changed something");
    }
    // a file where the directory should be
    let file = directory.path().join("file");
    fs::write(&file, b"precious").unwrap();
    let message = refused(profile(&file, "f16"));
    assert!(message.contains("file is a file"), "{message}");
    assert_eq!(fs::read(&file).unwrap(), b"precious");
    // over the earlier one, all is new
    good(profile(&out, "f32"));
    assert_listed(&out, "second");
    assert_ne!(everything(&out), before);
}

fn everything(out: &Path) -> Files {
    let read = |name: String| (name.clone(), fs::read(out.join(name)).unwrap());
    names(out).into_iter().map(read).collect()
}

#[test]
fn a_profile_on_a_full_or_closed_disk_changes_nothing() {
    if !can_mount() {
        return;
    }
    let directory = tempfile::tempdir().unwrap();
    let mount = directory.path().join("mount");
    fs::create_dir(&mount).unwrap();
    let bake = |storage: &str, more: &str| {
        format!(
            "\"$1\" bake --profile {PROFILE} --resolution 4 --roughness-resolution 4 --storage {storage} --format {more} --out \
             \"$3/out\" > /dev/null; echo \"code $?\"\n"
        )
    };
    let sums = " (cd \"$3/out\" && ls -A && sha256sum *) ";
    let (first, second) = (bake("f16", "ktx2"), bake("f32", "ktx2,raw,wgsl,glsl,hlsl"));
    let script = format!(
        "mount -t tmpfs -o size=10m none \"$3\" || exit 99\n{first}\
         before=$({sums})\n\
         used=$(df -k --output=used \"$3\" | tail -n 1)\n\
         mount -o remount,size=$((used + 12))k \"$3\" || exit 98\n{second}\
         test \"$before\" = \"$({sums})\" && echo same\n\
         mount -o remount,ro \"$3\" || exit 97\n{second}\
         test \"$before\" = \"$({sums})\" && echo same\n"
    );
    let (code, out, message) = mounted(&script, Path::new("-"), &mount);
    assert_eq!(code, Some(0), "{out}{message}");
    let lines: Vec<&str> = out.lines().collect();
    assert_eq!(lines, ["code 0", "code 2", "same", "code 2", "same"], "{message}");
    assert!(
        message.contains("No space left") && message.contains("Read-only"),
        "{message}"
    );
    assert!(
        message.contains("error: cannot write") && message.contains("mount/out"),
        "{message}"
    );
}

/// Killed anywhere, a profile leaves whole files, and a description only of what is there; the next one ends with the same bytes.
#[test]
fn killed_profiles_leave_no_description_of_other_files() {
    let directory = quick_directory();
    let [after, out] = ["after", "out"].map(|name| directory.path().join(name));
    let start = Instant::now();
    good(profile(&after, "unorm16"));
    let length = start.elapsed();
    let after = everything(&after);
    good(profile(&out, "f32"));
    let before = everything(&out);
    let mut random = Stream::new(StreamId {
        seed: 5,
        cell: 3,
        batch: 0,
    });
    for kill in 0..20 {
        let mut child = profile(&out, "unorm16").spawn().unwrap();
        if kill % 2 == 0 {
            std::thread::sleep(length.mul_f64(random.uniform()));
        } else {
            // the renames begin when the description goes
            while out.join("profile.json").exists() && child.try_wait().unwrap().is_none() {
                // not all the time: a core that only waits is one that the child does not get
                std::thread::sleep(Duration::from_micros(50));
            }
            std::thread::sleep(Duration::from_secs_f64(1e-3 * random.uniform()));
        }
        child.kill().unwrap();
        let output = child.wait_with_output().unwrap();
        assert!(!errors(&output).contains("panicked"));
        assert_listed(&out, &format!("kill {kill}"));
        for (name, bytes) in everything(&out).iter().filter(|(name, _)| !name.starts_with('.')) {
            assert!(
                [&before, &after].iter().any(|files| files.get(name) == Some(bytes)),
                "kill {kill}: {name}"
            );
        }
        for (name, bytes) in &before {
            fs::write(out.join(name), bytes).unwrap();
        }
    }
    good(profile(&out, "unorm16"));
    let left = everything(&out);
    assert!(after.iter().all(|(name, bytes)| left.get(name) == Some(bytes)));
}

/// Ctrl-C says that nothing is written, and nothing is.
#[cfg(unix)]
#[test]
fn an_interrupted_profile_leaves_what_was_there() {
    let directory = quick_directory();
    let out = directory.path().join("out");
    good(profile(&out, "f16"));
    let before = everything(&out);
    // at its own size it takes seconds
    let mut command = Command::new(env!("CARGO_BIN_EXE_furnace"));
    command.args(["bake", "--profile", PROFILE, "--out"]).arg(&out);
    let mut child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    // by what it announces it is known to have begun
    let mut messages = BufReader::new(child.stderr.take().unwrap());
    let mut announced = String::new();
    messages.read_line(&mut announced).unwrap();
    assert!(
        announced.contains("1 table to fit") && announced.contains(out.to_str().unwrap()),
        "{announced}"
    );
    let signal = Command::new("kill").args(["-INT", &child.id().to_string()]).status();
    assert!(signal.unwrap().success());
    let mut rest = String::new();
    messages.read_to_string(&mut rest).unwrap();
    assert_eq!(child.wait().unwrap().code(), Some(130), "{rest}");
    assert!(rest.contains("interrupted: nothing is written"), "{rest}");
    assert!(everything(&out) == before);
}

/// A bake of other formats says which files it leaves that its description no longer lists.
#[test]
fn files_of_earlier_profiles_are_told_of() {
    let directory = quick_directory();
    let out = directory.path().join("out");
    good(profile(&out, "f16"));
    let mut command = profile(&out, "f16");
    command.args(["--format", "dds"]);
    let message = errors(&good(command));
    assert!(!message.contains("earlier"), "{message}");
    let sizes = ["--resolution", "4", "--roughness-resolution", "4"];
    let mut command = Command::new(env!("CARGO_BIN_EXE_furnace"));
    command.args(["bake", "--profile", PROFILE]).args(sizes);
    command
        .args(["--format", "png", "--storage", "unorm16", "--out"])
        .arg(&out);
    let message = errors(&good(command));
    assert!(
        message.contains("files of an earlier bake") && message.contains("dfg.ktx2, dfg.bin, dfg.json, dfg.dds"),
        "{message}"
    );
    assert!(message.contains("the code of bevy reads dfg as f16"), "{message}");
}
