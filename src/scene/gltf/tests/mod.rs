//! glTF as people and programs write it, right and wrong.

mod container;
mod extensions;
mod translation;
mod use_and_names;
mod wrong;

use super::*;
use std::fmt::Write as _;

const SOURCE: &str = "dir/test.gltf";

/// The scene of a file with these members besides `asset`.
fn file(members: &str) -> Result<Scene, SceneError> {
    scene(
        format!("{{\"asset\":{{\"version\":\"2.0\"}},{members}}}").as_bytes(),
        SOURCE,
    )
}

/// Members of a file with one texture and these materials, whose extensions are declared.
fn library(materials: &str) -> String {
    let declared = KNOWN.map(|name| format!("\"{name}\"")).join(",");
    format!("\"extensionsUsed\":[{declared}],\"textures\":[{{}}],\"materials\":[{materials}]")
}

/// A material of these properties, which must not be worth a warning.
fn material(properties: &str) -> Material {
    let mut scene =
        file(&library(&format!("{{{properties}}}"))).unwrap_or_else(|error| panic!("{properties}: {error}"));
    assert_eq!(scene.warnings, [""; 0], "{properties}");
    let material = scene.materials.remove(0);
    assert!(material.model.at(None).is_ok(), "{properties}");
    material
}

/// A metallic-roughness material with extensions, each given without its prefix.
fn surface(metallic_roughness: &str, extensions: &[(&str, &str)]) -> Material {
    material(&properties(metallic_roughness, extensions))
}

fn properties(metallic_roughness: &str, extensions: &[(&str, &str)]) -> String {
    let mut text = format!("\"pbrMetallicRoughness\":{{{metallic_roughness}}},\"extensions\":{{");
    for (index, (name, members)) in extensions.iter().enumerate() {
        let comma = if index > 0 { "," } else { "" };
        write!(text, "{comma}\"KHR_materials_{name}\":{{{members}}}").unwrap();
    }
    text + "}"
}

fn effects(material: &Material) -> Vec<&'static str> {
    material.calls.iter().map(|call| call.effect.name()).collect()
}

fn gaps(material: &Material) -> Vec<&str> {
    material.gaps.iter().map(|gap| gap.what.as_str()).collect()
}

fn facts(material: &Material) -> String {
    let facts = material.model.describe();
    let facts: Vec<String> = facts.iter().map(|(key, value)| format!("{key}={value}")).collect();
    facts.join(" ")
}

/// What the file is refused with, or told.
fn message(members: &str) -> String {
    match file(members) {
        Err(error) => error.to_string(),
        Ok(scene) => scene.warnings.join("\n"),
    }
}

const PLASTIC: &str = "\"metallicFactor\":0,\"roughnessFactor\":0.5,\"baseColorFactor\":[0.2,0.4,0.6,1]";
const SMOOTH: &str = "\"metallicFactor\":0,\"roughnessFactor\":0,\"baseColorFactor\":[0.2,0.4,0.6,1]";
