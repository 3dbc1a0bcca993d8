//! Disks that are full or read-only, directories without permission or taken away: exit code 2, a message with the path, and
//! no half-written file.

use super::directory::{
    assert_finished, assert_whole, bake, begun, cached, errors, files, good, long_scene, names, refused, scene,
};
use std::fs;
use std::path::Path;
use std::process::Command;

/// Whether this system lets a test mount file systems of its own.
pub(crate) fn can_mount() -> bool {
    let probe = Command::new("unshare")
        .args(["-rm", "mount", "-t", "tmpfs", "none", "/mnt"])
        .output();
    let can = probe.is_ok_and(|output| output.status.success());
    if !can {
        println!("skipped: no name space with mounts of its own (unshare -rm) on this system");
    }
    can
}

/// Runs `script` where it may mount; `$1` is the binary, `$2` the scene, `$3` a directory to mount on.
pub(crate) fn mounted(script: &str, scene: &Path, mount: &Path) -> (Option<i32>, String, String) {
    let output = Command::new("unshare")
        .args(["-rm", "sh", "-c", script, "sh", env!("CARGO_BIN_EXE_furnace")])
        .arg(scene)
        .arg(mount)
        .output()
        .unwrap();
    let out = String::from_utf8_lossy(&output.stdout).into_owned();
    (output.status.code(), out, errors(&output))
}

/// Room for some of the tables, but not for all: the rest is lost to nobody, and with more room the bake goes on.
#[test]
fn a_full_disk_is_said_and_the_bake_goes_on_with_more_room() {
    if !can_mount() {
        return;
    }
    let directory = tempfile::tempdir().unwrap();
    let path = long_scene(directory.path(), 40);
    let [mount, copy, fresh] = ["mount", "copy", "fresh"].map(|name| directory.path().join(name));
    fs::create_dir(&mount).unwrap();
    fs::create_dir(&copy).unwrap();
    good(bake(&path, &fresh));
    let script = r#"
        mount -t tmpfs -o size=100k none "$3" || exit 99
        "$1" bake "$2" --out "$3/out"
        echo "code $?"
        ls -A "$3/out"
        mount -o remount,size=10m "$3" || exit 99
        "$1" bake "$2" --out "$3/out" || exit 98
        cp -r "$3/out/." "$3/../copy"
    "#;
    let (code, out, message) = mounted(script, &path, &mount);
    assert_eq!(code, Some(0), "{out}{message}");
    let lines: Vec<&str> = out.lines().collect();
    assert_eq!(lines[..2], ["code 2", ".furnace"], "{out}");
    assert!(
        message.contains("error: cannot write") && message.contains("mount/out/.furnace"),
        "{message}"
    );
    assert!(
        message.contains("No space left") && message.contains("are finished and kept in"),
        "{message}"
    );
    assert!(out.contains("of them found finished"), "{out}");
    assert_finished(&copy, &files(&fresh), "after the disk was full");
}

/// A disk that is full from the start, and one that cannot be written to.
#[test]
fn unusable_disks_are_refused_before_the_work() {
    if !can_mount() {
        return;
    }
    let directory = tempfile::tempdir().unwrap();
    let path = scene(directory.path(), "s.toml", &[17.0]);
    let mount = directory.path().join("mount");
    fs::create_dir(&mount).unwrap();
    let script = r#"
        mount -t tmpfs -o ro none "$3" || exit 99
        "$1" bake "$2" --out "$3/out"
    "#;
    let (code, out, message) = mounted(script, &path, &mount);
    assert_eq!((code, out.as_str()), (Some(2), ""), "{message}");
    assert!(
        message.contains("error: cannot create directory") && message.contains("mount/out"),
        "{message}"
    );
    assert!(message.contains("Read-only"), "{message}");
}

/// A directory that belongs to somebody else.
#[cfg(unix)]
#[test]
fn a_directory_without_permission_is_refused() {
    use std::os::unix::fs::PermissionsExt;
    let directory = tempfile::tempdir().unwrap();
    fs::set_permissions(directory.path(), fs::Permissions::from_mode(0o755)).unwrap();
    let path = scene(directory.path(), "s.toml", &[17.0]);
    let closed = directory.path().join("closed");
    fs::create_dir(&closed).unwrap();
    fs::set_permissions(&closed, fs::Permissions::from_mode(0o555)).unwrap();
    // the superuser may write anywhere
    let is_root = fs::write(closed.join("probe"), b"").is_ok();
    let mut command = bake(&path, &closed);
    if is_root {
        fs::remove_file(closed.join("probe")).unwrap();
        // somebody else has to be able to run the program: a copy of it, where everybody may look
        let binary = directory.path().join("furnace");
        fs::copy(env!("CARGO_BIN_EXE_furnace"), &binary).unwrap();
        let arguments: Vec<_> = command.get_args().map(std::ffi::OsStr::to_owned).collect();
        command = Command::new("setpriv");
        command
            .args(["--reuid=65534", "--regid=65534", "--clear-groups"])
            .arg(&binary)
            .args(arguments);
        if Command::new("setpriv").arg("--version").output().is_err() {
            println!("skipped: the superuser may write anywhere, and there is no setpriv to be somebody else");
            return;
        }
    }
    let message = refused(command);
    assert!(message.contains(closed.to_str().unwrap()), "{message}");
    assert!(message.contains("ermission denied"), "{message}");
    assert_eq!(names(&closed), [""; 0]);
}

/// Files in the way of directories, and directories in the way of files.
#[test]
fn whatever_is_in_the_way_is_named_and_stays() {
    let directory = tempfile::tempdir().unwrap();
    let path = scene(directory.path(), "s.toml", &[17.0]);
    let file = directory.path().join("file");
    fs::write(&file, b"precious").unwrap();
    for out in [file.clone(), file.join("below")] {
        let message = refused(bake(&path, &out));
        assert!(message.contains(&format!("{} is a file", file.display())), "{message}");
    }
    assert_eq!(fs::read(&file).unwrap(), b"precious");
    // where tables are kept
    let out = directory.path().join("out");
    fs::create_dir(&out).unwrap();
    fs::write(out.join(".furnace"), b"precious").unwrap();
    let message = refused(bake(&path, &out));
    assert!(message.contains("out/.furnace is a file"), "{message}");
    assert_eq!(fs::read(out.join(".furnace")).unwrap(), b"precious");
    fs::remove_file(out.join(".furnace")).unwrap();
    // a directory under the name of a table, and of the manifest
    for name in ["k17.rho_hd.exr", "manifest.json"] {
        let taken = out.join(name);
        fs::create_dir_all(&taken).unwrap();
        fs::write(taken.join("precious"), b"").unwrap();
        let message = refused(bake(&path, &out));
        assert!(message.contains(taken.to_str().unwrap()), "{message}");
        assert!(taken.join("precious").exists());
        fs::remove_dir_all(&taken).unwrap();
        good(bake(&path, &out));
        assert_whole(&out, &[&files(&out)], name);
        fs::remove_dir_all(&out).unwrap();
    }
}

/// A directory that is taken away in the midst of a bake.
#[test]
fn a_directory_that_vanishes_is_named() {
    let directory = tempfile::tempdir().unwrap();
    let path = long_scene(directory.path(), 60);
    let [out, elsewhere] = ["out", "elsewhere"].map(|name| directory.path().join(name));
    let child = begun(bake(&path, &out), &out);
    fs::rename(&out, &elsewhere).unwrap();
    let output = child.wait_with_output().unwrap();
    let message = errors(&output);
    assert_eq!(output.status.code(), Some(2), "{message}");
    assert!(
        message.contains("error: cannot write") && message.contains("out/.furnace"),
        "{message}"
    );
    assert!(
        !out.exists(),
        "the directory is not made again behind the back of who moved it"
    );
    // what was finished is where the directory went
    let report = good(bake(&path, &elsewhere));
    assert!(String::from_utf8_lossy(&report.stdout).contains("of them found finished"));
}

/// Kept tables that somebody takes away in the midst of a bake: it does not end as if they were there.
#[test]
fn tables_that_vanish_are_named() {
    let directory = tempfile::tempdir().unwrap();
    let path = long_scene(directory.path(), 60);
    let out = directory.path().join("out");
    let child = begun(bake(&path, &out), &out);
    let name = cached(&out).remove(0);
    fs::remove_file(out.join(".furnace").join(&name)).unwrap();
    let output = child.wait_with_output().unwrap();
    let message = errors(&output);
    assert_eq!(output.status.code(), Some(2), "{message}");
    assert!(message.contains(&format!("{name} is gone")), "{message}");
    assert!(!out.join("manifest.json").exists());
    // all others are kept
    let report = good(bake(&path, &out));
    assert!(String::from_utf8_lossy(&report.stdout).contains("119 of them found finished"));
}

/// Tables have to be kept on the file system that they go to, and not where somebody else has pointed to.
#[cfg(unix)]
#[test]
fn tables_are_not_kept_behind_a_link() {
    let directory = tempfile::tempdir().unwrap();
    let path = scene(directory.path(), "s.toml", &[17.0]);
    let [out, elsewhere] = ["out", "elsewhere"].map(|name| directory.path().join(name));
    fs::create_dir(&elsewhere).unwrap();
    fs::create_dir(&out).unwrap();
    std::os::unix::fs::symlink(&elsewhere, out.join(".furnace")).unwrap();
    let message = refused(bake(&path, &out));
    assert!(
        message.contains("out/.furnace") && message.contains("symbolic link"),
        "{message}"
    );
    assert_eq!(names(&elsewhere), [""; 0]);
}

/// What is not ours stays, also where tables are kept.
#[test]
fn files_of_others_stay() {
    let directory = tempfile::tempdir().unwrap();
    let path = scene(directory.path(), "s.toml", &[17.0]);
    let out = directory.path().join("out");
    fs::create_dir_all(out.join(".furnace")).unwrap();
    for name in ["precious", "notes.exr"] {
        fs::write(out.join(".furnace").join(name), b"precious").unwrap();
    }
    good(bake(&path, &out));
    let mut left = names(&out.join(".furnace"));
    left.retain(|name| !cached(&out).contains(name) || name == "notes.exr");
    assert_eq!(left, ["notes.exr", "precious"]);
}

/// Nobody can be told, and that is no reason to fail otherwise than without.
#[cfg(target_os = "linux")]
#[test]
fn messages_that_cannot_be_written_change_nothing() {
    let directory = tempfile::tempdir().unwrap();
    let path = scene(directory.path(), "s.toml", &[17.0]);
    let full = || fs::OpenOptions::new().write(true).open("/dev/full").unwrap();
    let missing = directory.path().join("missing.toml");
    for (scene, code) in [(&path, 0), (&missing, 2)] {
        let status = bake(scene, &directory.path().join("out")).stderr(full()).status();
        assert_eq!(status.unwrap().code(), Some(code));
    }
}
