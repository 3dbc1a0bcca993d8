//! Scenes of pbrt from their text.

mod files;
mod hostile;
mod materials;
mod state;
mod values;

use super::scene;
use crate::scene::{Effect, Material, Scene};

fn read(text: &str) -> Scene {
    scene(text, "s.pbrt").unwrap_or_else(|error| panic!("{error}\n{text}"))
}

fn refused(text: &str) -> String {
    match scene(text, "s.pbrt") {
        Ok(scene) => panic!("{text} is read as {:?}", scene.materials),
        Err(error) => error.to_string(),
    }
}

/// The one material of a scene with `statements` before a sphere.
fn one(statements: &str) -> Material {
    let mut scene = read(&format!("WorldBegin\n{statements}\nShape \"sphere\"\nWorldEnd\n"));
    assert_eq!(
        (scene.materials.len(), scene.warnings.as_slice()),
        (1, &[][..]),
        "{statements}"
    );
    scene.materials.remove(0)
}

fn names(scene: &Scene) -> Vec<&str> {
    scene.materials.iter().map(|material| material.name.as_str()).collect()
}

fn effects(material: &Material) -> Vec<Effect> {
    material.calls.iter().map(|call| call.effect).collect()
}

fn gaps(material: &Material) -> Vec<&str> {
    material.gaps.iter().map(|gap| gap.what.as_str()).collect()
}
