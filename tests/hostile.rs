//! The binary against scenes, files and arguments that mean harm: bounded, refused with a reason, harmless on a terminal, and
//! never outside of the directory that it was given.

use ::exr::prelude::*;
use serde_json::Value;
use std::collections::BTreeSet;
use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::time::{Duration, Instant};
use whitefurnace::printable::is_hidden;

/// Runs the binary, for a minute at most: what waits for ever fails.
fn furnace(directory: &Path, arguments: &[&str], input: &[u8]) -> Output {
    let mut child = Command::new(env!("CARGO_BIN_EXE_furnace"))
        .current_dir(directory)
        .args(arguments)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    // one that does not read it is none of our business
    drop(child.stdin.take().unwrap().write_all(input));
    let reading = std::thread::spawn({
        let (mut out, mut errors) = (child.stdout.take().unwrap(), child.stderr.take().unwrap());
        move || {
            let errors = std::thread::spawn(move || std::io::read_to_string(&mut errors).unwrap());
            (std::io::read_to_string(&mut out).unwrap(), errors.join().unwrap())
        }
    });
    let end = Instant::now() + Duration::from_secs(60);
    let status = loop {
        match child.try_wait().unwrap() {
            Some(status) => break status,
            None if Instant::now() > end => {
                child.kill().unwrap();
                panic!("{arguments:?} does not end");
            }
            None => std::thread::sleep(Duration::from_millis(5)),
        }
    };
    let (stdout, stderr) = reading.join().unwrap();
    for text in [&stdout, &stderr] {
        let acts = text.chars().find(|c| is_hidden(*c) && *c != '\n');
        assert_eq!(acts, None, "{arguments:?}: {text:?}");
    }
    Output {
        status,
        stdout: stdout.into_bytes(),
        stderr: stderr.into_bytes(),
    }
}

fn good(directory: &Path, arguments: &[&str]) -> String {
    let output = furnace(directory, arguments, b"");
    let errors = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(0), "{arguments:?}: {errors}");
    String::from_utf8(output.stdout).unwrap()
}

/// Standard error of a run that is refused with exit code 2.
fn refused(directory: &Path, arguments: &[&str]) -> String {
    let output = furnace(directory, arguments, b"");
    let errors = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(2), "{arguments:?}: {errors}");
    assert!(
        errors.starts_with("error: ") && !errors.contains("panicked"),
        "{arguments:?}: {errors}"
    );
    errors
}

fn assert_names(text: &str, parts: &[&str]) {
    for part in parts {
        assert!(text.contains(part), "{part} is not in {text}");
    }
}

/// Names that try to leave the directory, to act on the terminal, to look like others, or to be devices.
const NAMES: [&str; 16] = [
    "../../x",
    "/tmp/x",
    "..",
    ".",
    "a/b\\c",
    "C:\\x",
    "nul",
    "con.exr",
    "-rf",
    "a\u{0}b",
    "line\nbreak\r",
    "\u{1b}[2J\u{1b}]0;title\u{7}",
    "\u{9b}31m",
    "\u{202e}dlog",
    "Größe 金 💡",
    "manifest.json",
];

/// A scene of white materials with these names, quoted as TOML wants it, each with tables of its own.
fn white(names: &[&str]) -> String {
    let quoted = |(index, name): (usize, &&str)| {
        let units: String = name.chars().map(|c| format!("\\U{:08x}", u32::from(c))).collect();
        let kappa = index + 1;
        format!(
            "[[material]]\nname = \"{units}\"\nbxdf = {{ type = \"microfacet\", distribution = {{ type = \"vmf\", kappa = {kappa} \
             }}, masking = \"v-groove\", fresnel = \"none\" }}\n"
        )
    };
    names.iter().enumerate().map(quoted).collect()
}

/// Every file and directory below `directory`.
fn tree(directory: &Path) -> BTreeSet<PathBuf> {
    let mut all = BTreeSet::new();
    for entry in fs::read_dir(directory).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            all.extend(tree(&path));
        }
        all.insert(path);
    }
    all
}

#[test]
fn no_name_leaves_the_directory_or_acts_on_the_terminal() {
    let directory = tempfile::tempdir().unwrap();
    let here = directory.path().join("deep/down");
    fs::create_dir_all(&here).unwrap();
    let long = "x".repeat(300);
    let names: Vec<&str> = NAMES.into_iter().chain([long.as_str()]).collect();
    fs::write(here.join("s.toml"), white(&names)).unwrap();
    let before = tree(directory.path());
    let baked = good(&here, &["bake", "s.toml", "--out", "out"]);
    assert_names(&baked, &["34 tables"]);
    let out = here.join("out");
    let written: BTreeSet<PathBuf> = tree(directory.path()).difference(&before).cloned().collect();
    assert!(written.iter().all(|path| path.starts_with(&out)), "{written:?}");
    // two tables each, and the manifest
    let files = written
        .iter()
        .filter(|path| path.is_file() && path.parent() == Some(&out))
        .count();
    assert_eq!(files, 2 * names.len() + 1, "{written:?}");
    for file in &written {
        let name = file.file_name().unwrap().to_str().unwrap();
        assert!(
            name.len() < 120 && name.bytes().all(|byte| byte.is_ascii_graphic()),
            "{name}"
        );
    }
    let table = fs::read_dir(&out)
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .find(|path| path.to_str().unwrap().contains("dlog"))
        .unwrap();
    let table = table.to_str().unwrap();
    for arguments in [
        &["plan", "s.toml"][..],
        &["rho", "s.toml", "--mu", "1"],
        &["inspect", table],
        &["verify", "s.toml", "--tables", "out", "--material", "\u{202e}dlog"],
    ] {
        assert_names(&good(&here, arguments), &["dlog"]);
    }
    // JSON escapes what acts, and says the same
    for arguments in [
        &["plan", "s.toml", "--json"][..],
        &["rho", "s.toml", "--mu", "1", "--json"],
    ] {
        let value: Value = serde_json::from_str(&good(&here, arguments)).unwrap();
        let list = value["materials"].as_array().or(value["results"].as_array()).unwrap();
        let found: Vec<&str> = list
            .iter()
            .map(|one| one["name"].as_str().or(one["material"].as_str()).unwrap())
            .collect();
        assert_eq!(found, names);
    }
    assert_names(
        &refused(&here, &["rho", "s.toml", "--material", "\u{1b}c"]),
        &["\u{fffd}c"],
    );
    assert_names(&refused(&here, &["rho", "\u{1b}[2J.toml", "\u{202e}"]), &["\u{fffd}"]);
}

#[test]
fn too_much_is_refused_before_it_costs_memory() {
    let directory = tempfile::tempdir().unwrap();
    let here = directory.path();
    let keys = format!(
        "[[material]]\nname='a'\nbxdf={{type='lambertian',reflectance=1}}\n{}",
        "[a]\n".repeat(1 << 20)
    );
    let dots = format!("a.{}=1\n", "a.".repeat(1 << 22));
    let numbers = format!("x=[{}]\n", "1,".repeat(2_000_000));
    let large = " ".repeat((16 << 20) + 1);
    for (text, parts) in [
        (keys, ["[ { , . =", "1048576"]),
        (dots, ["[ { , . =", "1048576"]),
        (numbers, ["[ { , . =", "1048576"]),
        (large, ["bytes", "16777216"]),
        (
            white(&["x"]).repeat(2) + &"[".repeat(100_000),
            ["not valid TOML", "s.toml:"],
        ),
    ] {
        fs::write(here.join("s.toml"), text).unwrap();
        assert_names(&refused(here, &["plan", "s.toml"]), &parts);
    }
    let many: String = (0..65537)
        .map(|i| format!("[[material]]\nname='m{i}'\nbxdf={{type='lambertian',reflectance=1}}\n"))
        .collect();
    fs::write(here.join("s.toml"), &many).unwrap();
    assert_names(&refused(here, &["plan", "s.toml"]), &["65536 materials"]);
    // tens of thousands are legal, and a wrong name among them gets no list of all
    let fewer = many.match_indices("[[").nth(30_000).unwrap().0;
    fs::write(here.join("s.toml"), &many[..fewer]).unwrap();
    let errors = refused(here, &["rho", "s.toml", "--material", "gold"]);
    assert_names(&errors, &["m39 and 29 960 more"]);
}

#[test]
fn strange_numbers_in_a_scene_are_numbers_in_range_or_refused() {
    let directory = tempfile::tempdir().unwrap();
    let here = directory.path();
    for (kappa, taken) in [
        ("0x10", true),
        ("0o17", true),
        ("1_000.5", true),
        ("9007199254740993", false),
        ("999999999999", true),
        ("-0.0", true),
        ("1e-400", true),
        ("{ min = nan, max = 1 }", false),
        ("{ min = 1, max = inf }", false),
        ("{ min = 2, max = 1 }", false),
        ("{ min = 1, max = 1 }", false),
        ("{ min = 0x1, max = 0b11 }", true),
        ("1979-05-27", false),
        ("[[1]]", false),
        ("'1'", false),
    ] {
        let text = format!(
            "[[material]]\nname='a'\n[material.bxdf]\ntype='microfacet'\nmasking='none'\nfresnel='none'\n\
             distribution={{type='vmf',kappa={kappa}}}\n"
        );
        fs::write(here.join("s.toml"), text).unwrap();
        if taken {
            good(here, &["rho", "s.toml", "--mu", "1", "--tolerance", "1e-2"]);
        } else {
            assert_names(&refused(here, &["rho", "s.toml", "--mu", "1"]), &["s.toml:7:", "kappa"]);
        }
    }
}

#[cfg(unix)]
#[test]
fn pipes_are_scenes_and_never_data() {
    let directory = tempfile::tempdir().unwrap();
    let here = directory.path();
    let output = furnace(here, &["plan", "/dev/stdin"], white(&["piped"]).as_bytes());
    assert_eq!(output.status.code(), Some(0));
    assert_names(&String::from_utf8(output.stdout).unwrap(), &["piped"]);
    let pipe = |name: &str| assert!(Command::new("mkfifo").arg(here.join(name)).status().unwrap().success());
    pipe("pipe");
    pipe("manifest.json");
    for (kind, key) in [("merl", "path"), ("irregular", "path")] {
        let text = format!("[[material]]\nname='a'\nbxdf={{type='{kind}',{key}='pipe'}}\n");
        fs::write(here.join("s.toml"), text).unwrap();
        let errors = refused(here, &["plan", "s.toml"]);
        assert_names(
            &errors,
            &[
                "s.toml:3:",
                "pipe: cannot be read: it is a pipe, where only a regular file is allowed",
            ],
        );
    }
    assert_names(&refused(here, &["inspect", "pipe"]), &["pipe", "only a regular file"]);
    assert_names(
        &refused(here, &["verify", "--tables", "."]),
        &["manifest.json", "only a regular file"],
    );
    // somebody reads from it: a bake does not take it away
    fs::write(here.join("s.toml"), white(&["a"])).unwrap();
    assert_names(
        &refused(here, &["bake", "s.toml", "--out", "."]),
        &["manifest.json", "a pipe"],
    );
    fs::remove_file(here.join("manifest.json")).unwrap();
    good(here, &["bake", "s.toml", "--out", "."]);
    assert!(here.join("manifest.json").is_file());
}

/// A scene of somebody else may name any file, and its messages may be shown to him.
#[test]
fn messages_about_data_quote_a_few_characters_of_it() {
    let directory = tempfile::tempdir().unwrap();
    let here = directory.path();
    let secret = "root:x:0:0:0123456789abcdefghijklmnopqrstuvwxyz:/root:/bin/bash\n".repeat(3);
    fs::write(here.join("passwd"), &secret).unwrap();
    let conductor = |keys: &str| {
        format!(
            "{{type='microfacet',masking='none',distribution={{type='vmf',kappa=1}},fresnel={{type='conductor',{keys}}}}}"
        )
    };
    for bxdf in [
        "{type='merl',path='passwd'}".to_owned(),
        "{type='irregular',path='passwd'}".to_owned(),
        conductor("nk='passwd'"),
        conductor("eta='passwd',k='passwd'"),
    ] {
        fs::write(here.join("s.toml"), format!("[[material]]\nname='a'\nbxdf={bxdf}\n")).unwrap();
        let errors = refused(here, &["plan", "s.toml"]);
        assert!(!errors.contains("abcdefghijklmnopq"), "{bxdf}: {errors}");
    }
}

#[test]
fn names_in_foreign_images_are_harmless() {
    let directory = tempfile::tempdir().unwrap();
    let here = directory.path();
    let samples = FlatSamples::F32(vec![0.5; 4]);
    let list = [AnyChannel::new("Y\u{1b}[2J\u{85}", samples)];
    let layer = Layer::new(
        (2, 2),
        LayerAttributes {
            software_name: Some(Text::from("tool\u{9b}31m\n\u{7}")),
            ..LayerAttributes::named("layer\u{1b}]0;x\u{7}")
        },
        Encoding::UNCOMPRESSED,
        AnyChannels::sort(list.into_iter().collect()),
    );
    Image::from_layer(layer)
        .write()
        .to_file(here.join("foreign.exr"))
        .unwrap();
    assert_names(
        &good(here, &["inspect", "foreign.exr"]),
        &["tool\u{fffd}31m\u{fffd}\u{fffd}", "Y\u{fffd}[2J"],
    );
    let value: Value = serde_json::from_str(&good(here, &["inspect", "foreign.exr", "--json"])).unwrap();
    assert_eq!(value["foreign"][0]["channels"][0]["name"], "Y\u{1b}[2J\u{85}");
}

#[test]
fn damaged_manifests_are_errors_and_lead_nowhere_else() {
    let directory = tempfile::tempdir().unwrap();
    let here = directory.path();
    fs::write(here.join("s.toml"), white(&["a"])).unwrap();
    good(here, &["bake", "s.toml", "--out", "out"]);
    let path = here.join("out/manifest.json");
    let json = fs::read_to_string(&path).unwrap();
    let verify = ["verify", "s.toml", "--tables", "out"];
    fs::rename(here.join("out/a.rho_hd.exr"), here.join("away.exr")).unwrap();
    for far in ["../away.exr", "/dev/zero", "..", "", "out/../away.exr"] {
        fs::write(&path, json.replace("a.rho_hd.exr", far)).unwrap();
        let output = furnace(here, &verify, b"");
        assert_eq!(output.status.code(), Some(1), "{far}");
        assert_names(
            &String::from_utf8(output.stdout).unwrap(),
            &["is no name of a file beside the manifest"],
        );
    }
    let long = format!("{{\"format\":2,\"tables\":[{}]}}", "[],".repeat(6_000_000));
    for (text, part) in [
        ("[".repeat(1_000_000), "line 1"),
        (format!("{{\"format\":2,\"more\":{}", "[".repeat(1_000_000)), "line 1"),
        (json.replace("\"format\": 2", "\"format\": 7"), "its format is 7"),
        (json.replace("\"format\": 2", "\"format\": 1e99"), "line 2"),
        (json[..json.len() / 2].to_owned(), "EOF"),
        (long, "line 1"),
        ("[,".repeat(9_000_000), "16777216 brackets"),
        ("\u{feff}\u{0}".to_owned(), "line 1"),
    ] {
        fs::write(&path, text).unwrap();
        assert_names(&refused(here, &verify), &["manifest.json", part]);
    }
    // longer than any, most of it a hole
    fs::File::create(&path).unwrap().set_len(1 << 40).unwrap();
    assert_names(
        &refused(here, &verify),
        &["manifest.json", "longer than 268435456 bytes"],
    );
}

#[test]
fn wrong_numbers_are_quoted_as_written_with_what_is_allowed() {
    let directory = tempfile::tempdir().unwrap();
    let here = directory.path();
    for (option, value, allowed) in [
        ("--tolerance", "-1", "[1e-12, 0.5]"),
        ("--tolerance", "abc", "[1e-12, 0.5]"),
        ("--tolerance", "1e-400", "[1e-12, 0.5]"),
        ("--tolerance", "", "[1e-12, 0.5]"),
        ("--tolerance", "nan", "[1e-12, 0.5]"),
        ("--tolerance", "1e999", "[1e-12, 0.5]"),
        ("--mu", "-inf", "[0, 1]"),
        ("--mu", "1e999", "[0, 1]"),
        ("--theta-deg", "NaN", "[0, 90]"),
        ("--phi-deg", "-361", "[-360, 360]"),
        ("--samples", "-5", "from 2 to 1099511627776"),
        ("--samples", "1e6", "from 2 to 1099511627776"),
        ("--seed", "-1", "from 0 to 18446744073709551615"),
        ("--seed", "18446744073709551616", "from 0 to 18446744073709551615"),
        ("--threads", "-1", "from 1 to 1024"),
        ("--threads", "99999999999999999999", "from 1 to 1024"),
    ] {
        let errors = refused(here, &["rho", option, value]);
        assert_names(&errors, &[option, &format!("'{value}'"), allowed]);
        assert!(!errors.contains("tip:"), "{errors}");
    }
    for option in ["--resolution", "--roughness-resolution", "--azimuth-resolution"] {
        for value in ["-1", "0", "1e3", "1000000000", "nan", ""] {
            assert_names(&refused(here, &["plan", option, value]), &[option, "from 2 to 16384"]);
        }
    }
    assert_names(
        &refused(here, &["verify", "--confidence", "-1"]),
        &["between 0.5 and 1"],
    );
    assert_names(&refused(here, &["cost", "--seconds", "-1"]), &["[1, 86400]"]);
    fs::write(here.join("file"), "").unwrap();
    assert_names(
        &refused(here, &["cost", "--quick", "--out", "file/x"]),
        &["cannot create directory file/x", "file is a file"],
    );
    if cfg!(target_os = "linux") {
        assert_names(
            &refused(here, &["cost", "--quick", "--out", "/proc/nope/x"]),
            &["cannot create directory /proc/nope/x", "/proc takes no"],
        );
    }
}

#[test]
fn many_directions_take_no_longer_than_they_are_many() {
    let directory = tempfile::tempdir().unwrap();
    let here = directory.path();
    fs::write(here.join("s.toml"), white(&["a"])).unwrap();
    let values = vec!["0.5"; 30_000].join(",");
    let out = good(here, &["rho", "s.toml", "--mu", &values]);
    assert_eq!(out.lines().count(), 30_001);
}
