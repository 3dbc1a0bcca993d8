//! The graphics state: which statement a shape has its material from, and under which name.

use super::{names, read, refused};
use crate::scene::error::SceneError;
use crate::scene::pbrt::scene;
use crate::scene::spec::ModelSpec;
use crate::scene::{Material, Scene};

/// The reflectance of a diffuse material.
pub(super) fn kd(material: &Material) -> f64 {
    match &material.model {
        ModelSpec::Lambertian(diffuse) => diffuse.albedo().x,
        other => panic!("{other:?}"),
    }
}

/// A statement that makes grey the current material.
pub(super) fn grey(value: f64) -> String {
    format!("Material \"matte\" \"rgb Kd\" [{value} {value} {value}]\n")
}

fn named(name: &str, value: f64) -> String {
    format!("MakeNamedMaterial \"{name}\" \"string type\" \"matte\" \"rgb Kd\" [{value} {value} {value}]\n")
}

pub(super) fn uses(scene: &Scene) -> Vec<(&str, f64)> {
    scene
        .materials
        .iter()
        .map(|material| (material.name.as_str(), kd(material)))
        .collect()
}

#[test]
fn the_last_material_before_a_shape_wins() {
    let text = format!(
        "{}{}Shape \"sphere\" Shape \"disk\"\n{}",
        grey(0.1),
        grey(0.2),
        grey(0.3)
    );
    let scene = read(&text);
    assert_eq!(uses(&scene), [("matte at line 2", 0.2)]);
    assert_eq!(scene.unused, ["matte at line 1", "matte at line 4"]);
    assert_eq!(scene.materials[0].line, Some(2));
}

#[test]
fn attributes_give_back_what_was_current() {
    let text = format!(
        "{}AttributeBegin\n{}AttributeBegin\n{}Shape \"sphere\"\nAttributeEnd\nTransformBegin\n{}TransformEnd\n\
         Shape \"sphere\"\nAttributeEnd\nShape \"sphere\"\n",
        grey(0.1),
        grey(0.2),
        grey(0.3),
        grey(0.4)
    );
    // transforms end without giving back a material
    let expected = [
        ("matte at line 1", 0.1),
        ("matte at line 5", 0.3),
        ("matte at line 9", 0.4),
    ];
    let scene = read(&text);
    assert_eq!(uses(&scene), expected);
    assert_eq!(scene.unused, ["matte at line 3"]);
}

#[test]
fn names_mean_their_last_definition_in_scope() {
    let text = format!(
        "{}AttributeBegin\n{}NamedMaterial \"a\"\nShape \"sphere\"\nAttributeEnd\nNamedMaterial \"a\"\nShape \"sphere\"\n{}\
         Shape \"disk\"\nNamedMaterial \"a\"\nShape \"sphere\"\n{}",
        named("a", 0.1),
        named("a", 0.2),
        named("a", 0.3),
        named("b", 0.4)
    );
    let scene = read(&text);
    // the disk has the definition that was current when it was named
    assert_eq!(uses(&scene), [("a", 0.1), ("a (2)", 0.2), ("a (3)", 0.3)]);
    assert_eq!(scene.unused, ["b"]);
    let error = refused(&format!(
        "AttributeBegin {} AttributeEnd NamedMaterial \"gold\"",
        named("gould", 0.1)
    ));
    assert!(
        error.contains("\"gold\" is not allowed: no MakeNamedMaterial"),
        "{error}"
    );
    let error = refused(&format!("{} NamedMaterial \"gold\"", named("gould", 0.1)));
    assert!(
        error.starts_with("s.pbrt:2:16: ") && error.contains("did you mean \"gould\"?"),
        "{error}"
    );
    // a definition does not make a material current
    assert_eq!(
        names(&read(&format!("{}Shape \"sphere\"", named("a", 0.1)))),
        ["default matte"]
    );
}

#[test]
fn names_that_come_again_get_a_number_that_is_free() {
    let mut text = String::new();
    for name in ["a", "a (2)", "a", "a"] {
        text += &format!("{}NamedMaterial \"{name}\"\nShape \"sphere\"\n", named(name, 0.1));
    }
    assert_eq!(names(&read(&text)), ["a", "a (2)", "a (3)", "a (4)"]);
}

#[test]
fn objects_count_when_they_are_used() {
    let object =
        |name: &str, value: f64| format!("ObjectBegin \"{name}\"\n{}Shape \"sphere\"\nObjectEnd\n", grey(value));
    let text = format!(
        "{}{}{}ObjectInstance \"a\"\nObjectInstance \"a\"\nShape \"sphere\"\n",
        grey(0.1),
        object("a", 0.2),
        object("b", 0.3)
    );
    let scene = read(&text);
    assert_eq!(uses(&scene), [("matte at line 1", 0.1), ("matte at line 3", 0.2)]);
    assert_eq!(scene.unused, ["matte at line 7"]);
    let scene = read("ObjectInstance \"nobody\" Shape \"sphere\"");
    assert!(scene.warnings[0].contains("there is no object \"nobody\""));
}

#[test]
fn worlds_begin_anew() {
    let text = format!(
        "{}Shape \"sphere\"\nWorldBegin\nShape \"sphere\"\nWorldEnd\nWorldBegin\n{}Shape \"sphere\"\nWorldEnd\n",
        grey(0.1),
        grey(0.2)
    );
    let scene = read(&text);
    assert_eq!(uses(&scene), [("default matte", 0.5), ("matte at line 7", 0.2)]);
    assert_eq!(scene.warnings.len(), 1);
    assert!(scene.warnings[0].starts_with("line 3: materials and shapes before WorldBegin are ignored"));
    for (text, warning) in [
        ("WorldBegin Shape \"sphere\"", "there is no WorldEnd"),
        (
            "WorldBegin AttributeBegin Shape \"sphere\" WorldEnd",
            "no end of this before WorldEnd",
        ),
        (
            "WorldBegin AttributeBegin Shape \"sphere\"",
            "no end of this, of 1 that are open",
        ),
        (
            "WorldBegin AttributeEnd Shape \"sphere\" WorldEnd",
            "nothing is open that this could end",
        ),
        (
            "WorldBegin WorldBegin Shape \"sphere\" WorldEnd",
            "the world has begun before",
        ),
        ("Shape \"sphere\" WorldEnd", "no WorldBegin before this WorldEnd"),
        ("ObjectEnd Shape \"sphere\"", "no object begins before this ObjectEnd"),
        ("WorldBegin WorldEnd", "no shape has a material"),
        ("", "no shape has a material"),
    ] {
        let scene = read(text);
        assert!(
            scene.warnings.iter().any(|it| it.contains(warning)),
            "{text}: {:?}",
            scene.warnings
        );
    }
}

#[test]
fn shapes_have_a_say_in_their_material() {
    let shape = |value: f64| format!("Shape \"sphere\" \"float radius\" 2 \"rgb Kd\" [{value} {value} {value}]\n");
    let text = format!(
        "{}{}{}{}Shape \"disk\"\n{}",
        grey(0.1),
        shape(0.2),
        shape(0.3),
        shape(0.2),
        grey(0.4)
    );
    let scene = read(&text);
    let expected = [
        ("matte at line 1", 0.1),
        ("matte at line 1, shape at line 2", 0.2),
        ("matte at line 1, shape at line 3", 0.3),
    ];
    assert_eq!(uses(&scene), expected);
    assert_eq!(scene.materials[1].calls[0].by, "line 2: rgb Kd");
    assert_eq!(scene.materials[1].line, Some(1));
    // of the default material, of a named one, and what a material has no parameter for
    let scene = read(&format!(
        "{}NamedMaterial \"a\"\n{}Shape \"plymesh\" \"string filename\" \"a.ply\" \"rgb Ks\" [.5 .5 .5] \"texture alpha\" \"x\"",
        named("a", 0.1),
        shape(0.2)
    ));
    assert_eq!(uses(&scene), [("a", 0.1), ("a, shape at line 3", 0.2)]);
    let scene = read(&shape(0.2));
    assert_eq!(uses(&scene), [("default matte, shape at line 1", 0.2)]);
    assert!(!scene.materials[0].implied);
    // a texture of the shape comes before a value of the material, and means what it means at the shape
    let texture =
        |value: f64| format!("Texture \"t\" \"color\" \"constant\" \"rgb value\" [{value} {value} {value}]\n");
    let textured = "Shape \"sphere\" \"texture Kd\" \"t\"\n";
    let text = format!("{}{}{textured}{}{textured}", texture(0.2), grey(0.1), texture(0.3));
    let values: Vec<f64> = read(&text).materials.iter().map(kd).collect();
    assert_eq!(values, [0.2, 0.3]);
    let error = refused(&format!("{}{}", grey(0.1), shape(1.5)));
    assert!(
        error.starts_with("s.pbrt:2:42: Kd = [1.5, 1.5, 1.5] is not allowed: Kd lies in [0, 1]"),
        "{error}"
    );
}

#[test]
fn everything_else_is_passed_over() {
    let text = "# a scene\nFilm \"image\" \"integer xresolution\" [7] \"string filename\" \"a.exr\"\nLookAt 0 0 5  0 0 0  0 1 0\n\
                Camera \"perspective\" \"float fov\" 30 Sampler \"halton\" Integrator \"path\" Accelerator \"bvh\"\n\
                PixelFilter \"box\" TransformTimes 0 1 ActiveTransform StartTime ActiveTransform All\nWorldBegin\n\
                Identity Translate 1 -2 .5 Scale 1 1 1 Rotate 90 0 0 1 Transform [1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1]\n\
                ConcatTransform [1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1] CoordinateSystem \"a\" CoordSysTransform \"a\"\n\
                MakeNamedMedium \"fog\" \"string type\" \"homogeneous\" MediumInterface \"fog\" \"\" MediumInterface \"fog\"\n\
                LightSource \"infinite\" \"rgb L\" [1 1 1] AreaLightSource \"diffuse\" \"rgb L\" [9 9 9] ReverseOrientation\n\
                TransformBegin Shape \"trianglemesh\" \"integer indices\" [0 1 2] \"point P\" [0 0 0 1 0 0 0 1 0] TransformEnd\nWorldEnd";
    let scene = read(text);
    assert_eq!((names(&scene), scene.warnings.len()), (vec!["default matte"], 0));
}

#[test]
fn what_no_scene_holds_is_refused_at_its_place() {
    for (text, place, reason) in [
        (
            "Shap \"sphere\"",
            "1:1",
            "unknown directive Shap: pbrt 3 has Accelerator, ",
        ),
        ("\n Shap \"sphere\"", "2:2", "did you mean Shape?"),
        (
            "\"sphere\"",
            "1:1",
            "a directive such as Material or Shape begins a statement",
        ),
        ("Shape sphere", "1:7", "sphere is not allowed here: the type of a shape"),
        ("Shape", "1:6", "the file ends too early: the type of a shape"),
        ("Translate 1 2", "1:14", "the file ends too early: 3 numbers follow"),
        ("Translate 1 2 x", "1:15", "x is not allowed here: 3 numbers follow"),
        ("Transform 1", "1:11", "sixteen numbers in [ ] follow"),
        ("ActiveTransform None", "1:17", "All, StartTime or EndTime"),
        (
            "Texture \"t\" \"int\" \"constant\"",
            "1:13",
            "\"int\" is not allowed: a texture is of",
        ),
        ("MakeNamedMaterial \"a\"", "1:19", "MakeNamedMaterial \"a\" has no type"),
        (
            "MakeNamedMaterial \" \" \"string type\" \"matte\"",
            "1:19",
            "not allowed to be empty",
        ),
        (
            "Material \"matte\" \"rgb Kd\" [1 2]",
            "1:27",
            "Kd = [1.0, 2.0] is not allowed: rgb Kd is three numbers",
        ),
        (
            "Material \"matte\" \"float sigma\" 91",
            "1:32",
            "sigma = 91 is not allowed: sigma lies in [0, 90]",
        ),
        (
            "Material \"matte\" \"float sigma\" []",
            "1:32",
            "float sigma is a number",
        ),
        (
            "Material \"plastic\" \"float roughness\" -1",
            "1:38",
            "roughness = -1 is not allowed: a roughness is at least 0",
        ),
        (
            "Material \"plastic\" \"float roughness\" 99",
            "1:38",
            "it gives alpha = ",
        ),
        (
            "Material \"plastic\" \"texture roughness\" \"t\"",
            "1:40",
            "no float texture has that name",
        ),
        (
            "Material \"plastic\" \"bool remaproughness\" \"no\"",
            "1:42",
            "is \"true\" or \"false\"",
        ),
        (
            "Material \"glass\" \"float eta\" 0",
            "1:30",
            "eta = 0 is not allowed: eta lies in [0.01, 100]",
        ),
        (
            "Material \"metal\" \"rgb k\" [1 2 101]",
            "1:26",
            "k = [1.0, 2.0, 101.0] is not allowed: k lies in [0, 100]",
        ),
        (
            "Material \"matte\" \"spectrum Kd\" [400 1 500]",
            "1:32",
            "pairs of a wavelength in nm and a value",
        ),
        (
            "Material \"matte\" \"spectrum Kd\" [400 1 400 1]",
            "1:32",
            "cannot be used: sample 2",
        ),
        (
            "Material \"matte\" \"blackbody Kd\" [0 1]",
            "1:33",
            "the temperature of a blackbody lies in",
        ),
    ] {
        let error = refused(text);
        assert!(
            error.starts_with(&format!("s.pbrt:{place}: ")) && error.contains(reason),
            "{text}: {error}"
        );
    }
}

#[test]
fn what_is_not_read_is_told() {
    let scene = read(
        "Material \"plastic\" \"float rougness\" .5 \"float Kd\" 1 \"texture bumpmap\" \"b\" \"rgb Kr\" [1 1 1]\nShape \"sphere\"",
    );
    let warnings: Vec<&str> = scene.warnings.iter().map(String::as_str).collect();
    assert_eq!(warnings.len(), 3, "{warnings:?}");
    assert!(
        warnings[2].starts_with("line 1: rougness is not read") && warnings[2].contains("did you mean \"roughness\"?")
    );
    assert!(warnings[1].starts_with("line 1: Kr is not read"), "{warnings:?}");
    assert!(
        warnings[0].starts_with("line 1: float Kd is not read: Kd is "),
        "{warnings:?}"
    );
    // in full, and then by their number
    let many = "Material \"matte\" \"float x\" 1\n".repeat(150);
    let scene = read(&many);
    assert_eq!(scene.warnings.len(), 102);
    assert_eq!(scene.warnings[100], "50 more warnings like these");
}

#[test]
fn materials_are_bounded_in_number() {
    let text = "Material \"none\" ".repeat(65_537);
    let refused = scene(&text, "s.pbrt").unwrap_err();
    assert!(
        matches!(refused, SceneError::TooLarge { limit: 65_536, .. }),
        "{refused}"
    );
    assert!(scene(&"Material \"none\" ".repeat(65_536), "s.pbrt").is_ok());
}
