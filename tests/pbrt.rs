//! Scenes of pbrt from files, and what the binary makes of them.

use std::fs;
use std::path::Path;
use std::process::{Command, Output};
use whitefurnace::scene::{Effect, ModelSpec, Scene};

fn furnace(arguments: &[&str], directory: &Path) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_furnace"));
    command.args(arguments).current_dir(directory).output().unwrap()
}

const SCENE: &str = r#"
Film "image" "string filename" "room.exr"
LookAt 0 1 5  0 0 0  0 1 0
Camera "perspective" "float fov" [ 40 ]
WorldBegin
Include "geometry/floor.pbrt"
MakeNamedMaterial "gilt" "string type" "metal"
  "spectrum eta" "spds/Au.eta.spd" "spectrum k" "spds/Au.k.spd"
  "float roughness" 0.2
MakeNamedMaterial "spare" "string type" "mirror"
AttributeBegin
  NamedMaterial "gilt"
  Shape "sphere" "float radius" 1
AttributeEnd
Material "none"
Shape "sphere" "float radius" 9
WorldEnd
"#;

const FLOOR: &str = r#"
Texture "planks" "spectrum" "imagemap" "string filename" "planks.png"
Material "matte" "texture Kd" "planks"
Shape "trianglemesh" "integer indices" [ 0 1 2 ] "point P" [ 0 0 0  1 0 0  0 0 1 ]
"#;

fn room() -> tempfile::TempDir {
    let directory = tempfile::tempdir().unwrap();
    fs::create_dir(directory.path().join("geometry")).unwrap();
    fs::write(directory.path().join("room.PBRT"), SCENE).unwrap();
    fs::write(directory.path().join("geometry/floor.pbrt"), FLOOR).unwrap();
    directory
}

#[test]
fn a_scene_is_read_with_its_files() {
    let directory = room();
    let scene = Scene::load(&directory.path().join("room.PBRT")).unwrap();
    let names: Vec<&str> = scene.materials.iter().map(|material| material.name.as_str()).collect();
    assert_eq!(names, ["matte at line 3 of floor.pbrt", "gilt", "none at line 15"]);
    assert_eq!(
        (scene.name.as_str(), scene.means, scene.unused.as_slice()),
        ("room", false, &["spare".to_owned()][..])
    );
    assert_eq!(scene.warnings.len(), 2, "{:?}", scene.warnings);
    assert!(scene.warnings[0].starts_with("line 8: there is no file spds/Au.eta.spd"));
    let gilt = &scene.materials[1];
    let effects: Vec<Effect> = gilt.calls.iter().map(|call| call.effect).collect();
    assert_eq!(effects, [Effect::Metal, Effect::Colour]);
    assert_eq!(gilt.line, Some(7));
    assert!(matches!(&scene.materials[2].model, ModelSpec::Sum(none) if none.is_empty()));
}

#[test]
fn a_plan_is_made_for_it() {
    let directory = room();
    let output = furnace(&["plan", "room.PBRT"], directory.path());
    let (stdout, stderr) = (
        String::from_utf8_lossy(&output.stdout),
        String::from_utf8_lossy(&output.stderr),
    );
    assert_eq!(output.status.code(), Some(0), "{stderr}");
    assert!(stdout.contains("gilt") && !stdout.contains("spare.rho"), "{stdout}");
}

#[test]
fn what_cannot_be_read_says_where() {
    let directory = room();
    fs::write(
        directory.path().join("geometry/floor.pbrt"),
        "\nMaterial \"matte\" \"rgb Kd\" [1.5 0 0]\n",
    )
    .unwrap();
    let output = furnace(&["plan", "room.PBRT"], directory.path());
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{stderr}");
    let place = "geometry/floor.pbrt:2:27: Kd = [1.5, 0.0, 0.0] is not allowed: Kd lies in [0, 1]";
    assert!(stderr.contains(place), "{stderr}");
}
