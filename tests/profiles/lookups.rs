//! The shaders of every engine against integrals.

use crate::check::check;
use crate::shared::{baked, tables};
use whitefurnace::engine::Profile;

fn at_fresh_places(profile: Profile) {
    let baked = baked(profile);
    check(profile, baked, &tables(baked), 2000);
}

#[test]
fn generic() {
    at_fresh_places(Profile::Generic);
}

#[test]
fn filament() {
    at_fresh_places(Profile::Filament);
}

#[test]
fn filament_with_multiple_scattering() {
    at_fresh_places(Profile::FilamentMultiscatter);
}

#[test]
fn three() {
    at_fresh_places(Profile::Three);
}

#[test]
fn bevy() {
    at_fresh_places(Profile::Bevy);
}

#[test]
fn godot() {
    at_fresh_places(Profile::Godot);
}

#[test]
fn gltf() {
    at_fresh_places(Profile::Gltf);
}

#[test]
fn unity() {
    at_fresh_places(Profile::UnityHdrp);
}

#[test]
fn unreal() {
    at_fresh_places(Profile::Unreal);
}

#[test]
fn materialx() {
    at_fresh_places(Profile::MaterialX);
}

#[test]
fn cycles() {
    at_fresh_places(Profile::Cycles);
}

#[test]
fn openpbr() {
    at_fresh_places(Profile::OpenPbr);
}
