//! Texts that mean harm: an answer or a refusal, never a panic, in time and memory in proportion to their size.

use super::read;
use crate::scene::Scene;
use crate::scene::error::SceneError;
use std::time::{Duration, Instant};

fn scene(text: &str) -> Result<Scene, SceneError> {
    crate::scene::pbrt::scene(text, "s.pbrt")
}

/// A scene with a bit of everything that is read.
const RICH: &str = r#"Film "image" "integer xresolution" [ 7 ] # comment
WorldBegin
Texture "é" "float" "mix" "float tex1" .1 "float tex2" [0.2]
Texture "c" "spectrum" "scale" "rgb tex1" [.1 .2 .3] "texture tex2" "none"
MakeNamedMaterial "m\"1" "string type" "metal" "texture roughness" "é" "spectrum k" [400 1 500 2 600 3]
MakeNamedMaterial "m2" "string type" "uber" "rgb opacity" [.5 .5 .5] "xyz Kd" [.1 .1 .1]
AttributeBegin
Material "mix" "string namedmaterial1" "m\"1" "string namedmaterial2" "m2" "texture amount" "c"
ObjectBegin "o"
Shape "sphere" "float radius" 3 "rgb amount" [.1 .1 .1]
ObjectEnd
AttributeEnd
ObjectInstance "o"
NamedMaterial "m2"
Shape "trianglemesh" "point P" [ 0 0 0 1 0 0 0 1 0 ] "blackbody Kr" [ 5000 .1 ]
MediumInterface "" Transform [ 1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1 ]
WorldEnd
"#;

#[test]
fn scenes_cut_anywhere_are_read_or_refused() {
    assert!(read(RICH).materials.len() == 2);
    for at in 0..=RICH.len() {
        if let Some(text) = RICH.get(..at) {
            let _ = scene(text);
            let _ = scene(&format!("{text}\0"));
        }
        if let Some(rest) = RICH.get(at..) {
            let _ = scene(rest);
        }
    }
}

#[test]
fn scenes_with_any_byte_changed_are_read_or_refused() {
    for (at, _) in RICH.char_indices() {
        for other in ["\"", "[", "]", "#", "\n", "\\", "-", "9", "\u{202e}", "e"] {
            let mut text = RICH[..at].to_owned();
            text.push_str(other);
            text.extend(RICH[at..].chars().skip(1));
            if let Err(error) = scene(&text) {
                let said = error.to_string();
                assert!(said.lines().all(|line| line.chars().count() < 1200), "{said}");
                assert!(!said.contains('\u{202e}'), "{said}");
            }
        }
    }
}

#[test]
fn words_for_numbers_are_refused() {
    for word in [
        "nan", "inf", "-inf", "NaN", "infinity", "1e999", "0x10", "1,5", "--1", "1e", "true", "[", "\u{661}",
    ] {
        let text = format!("Material \"matte\" \"float sigma\" [{word}] Shape \"sphere\"");
        assert!(scene(&text).is_err(), "{word}");
    }
    for huge in ["1e308", "-1e308", "123456789012345678901234567890", "1e-400"] {
        let text = format!(
            "Texture \"a\" \"float\" \"scale\" \"float tex1\" {huge} \"float tex2\" {huge}\n\
             Texture \"b\" \"float\" \"mix\" \"texture tex1\" \"a\" \"texture tex2\" \"a\" \"texture amount\" \"a\"\n\
             Material \"metal\" \"texture roughness\" \"b\" \"bool remaproughness\" \"false\""
        );
        let _ = scene(&text);
        let _ = scene(&format!("Material \"matte\" \"blackbody Kd\" [{huge} {huge}]"));
        let _ = scene(&format!(
            "Material \"matte\" \"spectrum Kd\" [{huge} {huge} 500 {huge}]"
        ));
        let _ = scene(&format!("Material \"matte\" \"xyz Kd\" [{huge} {huge} {huge}]"));
    }
}

#[test]
fn attributes_have_a_limit() {
    let begins = "AttributeBegin ".repeat(65_536);
    let scene_of = |text: &str| scene(text).map(|scene| scene.materials.len());
    assert_eq!(scene_of(&format!("{begins}Shape \"sphere\"")).unwrap(), 1);
    let error = scene_of(&format!("{begins}AttributeBegin")).unwrap_err().to_string();
    assert!(error.contains("at most 65536 attributes and objects"), "{error}");
    let error = scene_of(&"ObjectBegin \"a\" ".repeat(65_537)).unwrap_err().to_string();
    assert!(error.contains("at most 65536"), "{error}");
}

#[test]
fn what_is_no_text_is_refused() {
    for text in [
        "\0\0\0",
        "PK\u{3}\u{4}",
        "\u{1b}[2J",
        "{}",
        "]",
        "[",
        "\"",
        "#",
        "\"a",
        "Shape \"a\" \"b",
    ] {
        if let Err(error) = scene(text) {
            assert!(!error.to_string().contains(['\0', '\u{1b}']), "{error}");
        }
    }
}

/// Ten seconds are ten times what an idle machine takes in the test profile; anything quadratic takes hours.
fn in_time(what: &str, text: &str) -> Result<Scene, SceneError> {
    let begun = Instant::now();
    let read = scene(text);
    let took = begun.elapsed();
    assert!(took < Duration::from_secs(10), "{what} takes {took:?}");
    read
}

#[test]
fn large_scenes_take_seconds() {
    let mesh = format!(
        "Shape \"trianglemesh\" \"integer indices\" [{}] \"point P\" [{}]\n",
        "0 1 2 ".repeat(100_000),
        "-0.123456 1.5e-3 7 ".repeat(100_000)
    );
    let meshes = mesh.repeat((64 << 20) / mesh.len());
    assert_eq!(in_time("a scene of meshes", &meshes).unwrap().materials.len(), 1);
    let shapes = "Shape \"a\"".repeat((32 << 20) / 9);
    assert_eq!(in_time("a scene of shapes", &shapes).unwrap().materials.len(), 1);
    let lines = "\n".repeat(64 << 20);
    in_time("a scene of lines", &lines).unwrap();
    let brackets = format!("Shape \"a\" \"float b\" {}", "[".repeat(32 << 20));
    assert!(in_time("a scene of brackets", &brackets).is_err());
}

#[test]
fn many_names_take_no_longer_than_their_text() {
    let scopes = "MakeNamedMaterial \"a\" \"string type\" \"none\" AttributeBegin\n".repeat(60_000);
    in_time("names in scopes", &scopes).unwrap();
    let mut textures: String = (0..200_000)
        .map(|i| format!("Texture \"t{i}\" \"float\" \"constant\"\n"))
        .collect();
    textures += &"AttributeBegin AttributeEnd ".repeat(200_000);
    in_time("textures and scopes", &textures).unwrap();
    let instances = format!(
        "ObjectBegin \"o\" {} ObjectEnd {}",
        "Material \"matte\" Shape \"a\"".repeat(60_000),
        "ObjectInstance \"o\"".repeat(500_000)
    );
    assert_eq!(in_time("instances", &instances).unwrap().materials.len(), 60_000);
    let slips: String = (0..60_000)
        .map(|i| format!("Material \"plastic\" \"float roughness{i}\" 1 Shape \"a\"\n"))
        .collect();
    in_time("misspelt parameters", &slips).unwrap();
    let same = "MakeNamedMaterial \"a\" \"string type\" \"matte\" NamedMaterial \"a\" Shape \"s\"\n".repeat(60_000);
    assert_eq!(in_time("one name", &same).unwrap().materials.len(), 60_000);
    let variants: String = (0..60_000)
        .map(|i| format!("Shape \"s\" \"rgb Kd\" [0.{i} 0 0]\n"))
        .collect();
    in_time("variants", &variants).unwrap();
}
