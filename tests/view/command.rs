//! The command: files, messages, JSON, and names that are up to no good.

use crate::browser::{Visit, assert_quiet, visit};
use serde_json::Value;
use std::fs;
use std::path::Path;
use std::process::{Command, Output};

pub(crate) fn furnace(directory: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_furnace"))
        .current_dir(directory)
        .args(arguments)
        .output()
        .unwrap()
}

fn lobe(name: &str) -> String {
    format!(
        "[[material]]\nname = {name:?}\n[material.bxdf]\ntype = \"microfacet\"\ndistribution = {{ type = \"beckmann\", m = 0.4 }}\n\
         masking = \"v-groove\"\nfresnel = {{ type = \"none\" }}\n"
    )
}

const HOSTILE: &str =
    "</script><script>document.title='taken'</script><img src=x onerror=alert(1)>&amp;{{script}}\"'`${1}";

#[test]
fn hostile_names_are_text_and_the_same_scene_gives_the_same_bytes() {
    let directory = tempfile::tempdir().unwrap();
    let scene = format!("[scene]\nname = {HOSTILE:?}\n{}", lobe(HOSTILE));
    fs::write(directory.path().join("scene.toml"), scene).unwrap();
    let pages = ["1", "2"].map(|threads| {
        let out = format!("deep/er/{threads}.html");
        let output = furnace(
            directory.path(),
            &["view", "scene.toml", "--out", &out, "--threads", threads],
        );
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        assert!(String::from_utf8_lossy(&output.stdout).contains("Open it in a browser"));
        fs::read_to_string(directory.path().join(out)).unwrap()
    });
    assert!(pages[0] == pages[1], "threads are no part of a page");
    // two blocks of script, both ours
    assert_eq!(pages[0].matches("<script").count(), 2);
    assert_eq!(pages[0].matches("</script").count(), 2);
    let page = fs::canonicalize(directory.path().join("deep/er/1.html")).unwrap();
    let Some(seen) = visit(&page, &Visit::default()) else {
        return;
    };
    assert_quiet(&seen, &page);
    assert_eq!(seen["title"], format!("{HOSTILE}: tables at work"));
    assert_eq!(seen["options"][0], HOSTILE);
}

#[test]
fn what_cannot_be_shown_or_written_is_refused() {
    let directory = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| fs::write(directory.path().join(name), text).unwrap();
    write("good.toml", &lobe("a"));
    write(
        "diffuse.toml",
        "[[material]]\nname = \"chalk\"\nbxdf = { type = \"lambertian\", reflectance = 0.5 }\n",
    );
    write("file", "");
    for (arguments, reason) in [
        (
            ["diffuse.toml", "--out", "page.html"],
            "`chalk` is not shown: no microfacet lobe",
        ),
        (["good.toml", "--out", "."], ". is a directory"),
        (["good.toml", "--out", "file/page.html"], "file is a file"),
        (["good.toml", "--material", "b"], "no material `b`"),
        (["missing.toml", "--out", "page.html"], "missing.toml"),
    ] {
        let output = furnace(directory.path(), &[&["view"][..], &arguments].concat());
        let errors = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {errors}");
        assert!(
            errors.starts_with("error: ") && errors.contains(reason),
            "{arguments:?}: {errors}"
        );
        assert!(output.stdout.is_empty());
    }
    assert!(!directory.path().join("page.html").exists());
}

#[test]
fn json_says_where_the_file_is_and_what_is_not_in_it() {
    let directory = tempfile::tempdir().unwrap();
    let chalk = "[[material]]\nname = \"chalk\"\nbxdf = { type = \"lambertian\", reflectance = 0.5 }\n";
    fs::write(directory.path().join("two.toml"), lobe("a") + chalk).unwrap();
    let output = furnace(directory.path(), &["view", "two.toml", "--json"]);
    let said: Value = serde_json::from_slice(&output.stdout).unwrap();
    let file = directory.path().join(said["file"].as_str().unwrap());
    assert_eq!(said["file"], "outputs/two/view.html");
    assert_eq!(fs::metadata(file).unwrap().len(), said["bytes"].as_u64().unwrap());
    assert_eq!(said["materials"][0], "a");
    assert_eq!(said["left_out"][0]["name"], "chalk");
}
