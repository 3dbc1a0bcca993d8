//! Files that a scene includes, and those of its spectra.

use super::state::{grey, kd, uses};
use crate::scene::error::SceneError;
use crate::scene::pbrt::load;
use std::fs;
use std::path::Path;

fn write(directory: &Path, name: &str, text: &str) {
    let path = directory.join(name);
    fs::create_dir_all(path.parent().unwrap()).unwrap();
    fs::write(path, text).unwrap();
}

#[test]
fn included_files_are_read_in_their_place() {
    let directory = tempfile::tempdir().unwrap();
    let at = |name: &str, text: &str| write(directory.path(), name, text);
    at(
        "main.pbrt",
        "WorldBegin\nInclude \"parts/a.pbrt\"\nShape \"sphere\"\nWorldEnd\n",
    );
    // b lies beside a; c beside the scene, as pbrt has it
    at(
        "parts/a.pbrt",
        "Include \"b.pbrt\"\nInclude \"c.pbrt\"\nShape \"sphere\"\n",
    );
    at("parts/b.pbrt", &format!("\n{}Shape \"sphere\"\n", grey(0.1)));
    at("c.pbrt", &format!("Include \"parts/b.pbrt\"\n{}", grey(0.2)));
    let scene = load(&directory.path().join("main.pbrt")).unwrap();
    // the same statement twice makes two materials
    assert_eq!(
        uses(&scene),
        [
            ("matte at line 2 of b.pbrt", 0.1),
            ("matte at line 2 of b.pbrt (2)", 0.1),
            ("matte at line 2 of c.pbrt", 0.2)
        ]
    );
    assert_eq!(scene.materials[2].calls[0].by, "line 2 of c.pbrt: rgb Kd");
}

#[test]
fn files_that_cannot_be_included_are_refused() {
    let directory = tempfile::tempdir().unwrap();
    let at = |name: &str, text: &str| write(directory.path(), name, text);
    let error = |name: &str| load(&directory.path().join(name)).unwrap_err().to_string();
    at("missing.pbrt", "\nInclude \"none.pbrt\"");
    let text = error("missing.pbrt");
    assert!(
        text.contains("missing.pbrt:2:9: \"none.pbrt\" cannot be included: No such file"),
        "{text}"
    );
    at("directory.pbrt", "Include \".\"");
    assert!(error("directory.pbrt").contains("it is a directory"));
    at("self.pbrt", "Include \"self.pbrt\"");
    assert!(error("self.pbrt").contains("\"self.pbrt\" is not allowed: a file cannot include itself"));
    at("ring.pbrt", "Include \"./a/../ring2.pbrt\"");
    at("ring2.pbrt", "\n\nInclude \"ring.pbrt\"");
    at("a/x", "");
    let text = error("ring.pbrt");
    assert!(text.contains("ring2.pbrt:3:9: "), "{text}");
    for i in 0..17 {
        at(&format!("deep{i}.pbrt"), &format!("Include \"deep{}.pbrt\"", i + 1));
    }
    at("deep17.pbrt", "");
    let text = error("deep0.pbrt");
    assert!(
        text.contains("deep15.pbrt:1:9: ") && text.contains("at most 16 files"),
        "{text}"
    );
    assert!(load(&directory.path().join("deep2.pbrt")).is_ok());
    at("cut.pbrt", "Include \"half.pbrt\" \"float x\" 3");
    at("half.pbrt", "Shape");
    assert!(error("cut.pbrt").contains("half.pbrt:1:6: the file ends too early"));
    fs::write(directory.path().join("latin.pbrt"), b"# \xe9").unwrap();
    at("includes.pbrt", "Include \"latin.pbrt\"");
    for name in ["latin.pbrt", "includes.pbrt"] {
        assert!(error(name).contains("latin.pbrt: byte 2 (counted from 0) is not UTF-8"));
    }
    // all that is included counts, however often
    at("large.pbrt", &"#".repeat(1 << 20));
    at("many.pbrt", &"Include \"large.pbrt\"\n".repeat(65));
    let refused = load(&directory.path().join("many.pbrt")).unwrap_err();
    assert!(
        matches!(refused, SceneError::TooLarge { limit, .. } if limit == 64 << 20),
        "{refused}"
    );
}

#[test]
fn spectra_lie_beside_the_file_that_names_them() {
    let directory = tempfile::tempdir().unwrap();
    let at = |name: &str, text: &str| write(directory.path(), name, text);
    at("main.pbrt", "Include \"parts/a.pbrt\"\nShape \"sphere\"");
    at("parts/a.pbrt", "Material \"matte\" \"spectrum Kd\" \"grey.spd\"");
    at("parts/grey.spd", "400 .25\n700 .25\n");
    let path = directory.path().join("main.pbrt");
    assert_eq!(kd(&load(&path).unwrap().materials[0]), 0.25);
    at("parts/grey.spd", "400 red\n");
    let error = load(&path).unwrap_err().to_string();
    assert!(
        error.contains("a.pbrt:1:32: ") && error.contains("grey.spd: line 1"),
        "{error}"
    );
    at("parts/grey.spd", "1000 .5\n2000 .5\n");
    let error = load(&path).unwrap_err().to_string();
    assert!(error.contains("it spans 1000 to 2000 nm"), "{error}");
}
