//! Scenes as people write them, right and wrong.

use super::refusals::{all_refused, refusal};
use super::*;
use crate::bxdf::Coupling;
use crate::distribution::Family;
use crate::fresnel::Fresnel;
use crate::masking::Masking;
use crate::spectrum::Spectrum;
use std::io::Write;

/// A scene of one material with the given bxdf.
fn parse_bxdf(bxdf: &str) -> Result<ModelSpec, SceneError> {
    let text = format!("[[material]]\nname = \"a\"\nbxdf = {bxdf}\n");
    Scene::parse(&text, "scene.toml").map(|scene| scene.materials[0].model.clone())
}

fn microfacet(distribution: &str, masking: &str, fresnel: &str) -> String {
    format!("{{ type = \"microfacet\", distribution = {distribution}, masking = {masking}, fresnel = {fresnel} }}")
}

#[test]
fn the_default_scene_is_the_one_of_the_figure_and_more() {
    let scene = Scene::default_scene();
    let names: Vec<&str> = scene.materials.iter().map(|material| &*material.name).collect();
    assert_eq!(
        names,
        [
            "methanol-k17",
            "methanol-k1024",
            "aluminium-k17",
            "aluminium-k1024",
            "beckmann-m0.2",
            "phong-n48",
            "ggx-a0.3",
            "ashikhmin-shirley-10-100",
            "vmf-any-roughness"
        ]
    );
    let family = |material: &Material| match &material.model {
        ModelSpec::Microfacet {
            distribution: DistributionSpec::Isotropic { family, .. },
            ..
        } => Some(*family),
        _ => None,
    };
    assert_eq!(family(&scene.materials[4]), Some(Family::Beckmann));
    assert_eq!(family(&scene.materials[5]), Some(Family::Phong));
    assert_eq!(family(&scene.materials[6]), Some(Family::Ggx));
    assert_eq!(family(&scene.materials[7]), None);
    assert_eq!(
        scene.materials[8].model.roughness_range(),
        Some((Family::Vmf, 1.0, 4096.0))
    );
    for material in &scene.materials {
        assert!(material.model.at(None).is_ok());
        let line = include_str!("default.toml").lines().nth(material.line.unwrap() - 1);
        assert_eq!(line, Some("[[material]]"));
    }
    let ModelSpec::DiffuseSpecular {
        specular,
        ks,
        kd,
        coupling,
    } = &scene.materials[3].model
    else {
        panic!("{:?}", scene.materials[3]);
    };
    assert_eq!((*ks, *coupling), (Spectrum::grey(1.0), Coupling::Mikkelsen));
    assert_eq!(*kd, Spectrum::rgb([0.08, 0.172, 1.0]));
    assert_eq!(
        **specular,
        ModelSpec::Microfacet {
            reflectance: Spectrum::grey(1.0),
            distribution: DistributionSpec::Isotropic {
                family: Family::Vmf,
                roughness: Roughness::Fixed(1024.0),
            },
            masking: Masking::VGroove,
            fresnel: Fresnel::conductor(Spectrum::grey(0.769), Spectrum::grey(6.08)).unwrap(),
        }
    );
}

#[test]
fn names_of_scenes_default_to_the_file() {
    let body = "[[material]]\nname = \"a\"\nbxdf = { type = \"lambertian\", reflectance = 1 }\n";
    let named = |head: &str, source| Scene::parse(&format!("{head}{body}"), source).unwrap().name;
    assert_eq!(named("", "dir/my scene.toml"), "my scene");
    assert_eq!(named("[scene]\n", "my.scene.toml"), "my.scene");
    assert_eq!(named("\u{feff}[scene]\nname = \"Ä/b\"\r\n", "x"), "Ä/b");
    assert_eq!(named("", ".."), "..");
}

#[test]
fn every_name_of_the_format_is_read() {
    for (distribution, family, roughness) in [
        ("{ type = \"vmf\", kappa = 17 }", Family::Vmf, Roughness::Fixed(17.0)),
        ("{ type = \"vmf\", kappa = 0x11 }", Family::Vmf, Roughness::Fixed(17.0)),
        (
            "{ type = \"vmf\", kappa = 1_0e1_1 }",
            Family::Vmf,
            Roughness::Fixed(1e12),
        ),
        (
            "{ type = \"beckmann\", m = +0.5 }",
            Family::Beckmann,
            Roughness::Fixed(0.5),
        ),
        ("{ type = \"phong\", n = 48.0 }", Family::Phong, Roughness::Fixed(48.0)),
        (
            "{ type = \"blinn\", exponent = 0 }",
            Family::Phong,
            Roughness::Fixed(0.0),
        ),
        (
            "{ type = \"blinn\", exponent = { min = 0, max = 1e8 } }",
            Family::Phong,
            Roughness::Range { min: 0.0, max: 1e8 },
        ),
    ] {
        let model = parse_bxdf(&microfacet(distribution, "\"none\"", "{ type = \"none\" }")).unwrap();
        let expected = ModelSpec::Microfacet {
            reflectance: Spectrum::grey(1.0),
            distribution: DistributionSpec::Isotropic { family, roughness },
            masking: Masking::None,
            fresnel: Fresnel::None,
        };
        assert_eq!(model, expected, "{distribution}");
    }
    let (eta, k) = (Spectrum::grey(1.5), Spectrum::rgb([1.0, 2.0, 3.5]));
    for (fresnel, expected) in [
        ("\"none\"", Fresnel::None),
        ("{ type = \"dielectric\", eta = 1.5 }", Fresnel::Dielectric { eta }),
        (
            "{ type = \"conductor\", k = [1, 2, 3.5], eta = [1.5, 1.5, 1.5] }",
            Fresnel::Conductor { eta, k },
        ),
        (
            "{ type = \"conductor-approximate\", eta = 1.5, k = [1, 2, 3.5] }",
            Fresnel::ConductorApproximate { eta, k },
        ),
        (
            "{ type = \"schlick\", r0 = 0 }",
            Fresnel::Schlick {
                r0: Spectrum::grey(0.0),
            },
        ),
    ] {
        let model = parse_bxdf(&microfacet("{ type = \"vmf\", kappa = 1 }", "\"v-groove\"", fresnel)).unwrap();
        assert!(
            matches!(model, ModelSpec::Microfacet { fresnel, masking: Masking::VGroove, .. } if fresnel == expected)
        );
    }
    let coupled = parse_bxdf(
        "{ type = \"diffuse-specular\", coupling = \"energy-preserving\", ks = 0, kd = 1, specular = { type = \
         \"lambertian\", reflectance = [0, 0.5, 1] } }",
    );
    let facts = coupled.unwrap().describe();
    assert_eq!(facts[1].1, "energy-preserving");
    assert_eq!(
        facts[5],
        ("specular.reflectance".to_owned(), "[0.0, 0.5, 1.0]".to_owned())
    );
}

#[test]
fn minus_zero_is_zero() {
    let model = parse_bxdf("{ type = \"lambertian\", reflectance = -0.0 }").unwrap();
    let facts = model.describe();
    assert_eq!(facts[1].1, "0");
}

#[test]
fn messages_show_the_line_the_value_and_what_is_allowed() {
    let head = "[[material]]\nname = \"a\"\n[material.bxdf]\ntype = \"microfacet\"\n";
    for (line, expected) in [
        (
            "distribution = { type = \"vmf\", kappa = -3 }",
            "\
scene.toml:5:40: kappa = -3 is not allowed: kappa lies in [0, 1e12]
 5 | distribution = { type = \"vmf\", kappa = -3 }
   |                                        ^^",
        ),
        (
            "distribution = { type = \"vmf\", kapa = 3 }",
            "\
scene.toml:5:32: unknown key kapa: the keys of vmf are type, kappa; did you mean kappa?
 5 | distribution = { type = \"vmf\", kapa = 3 }
   |                                ^^^^",
        ),
        (
            "distribution = { type = \"gxx\", alpha = 0.2 }",
            "\
scene.toml:5:25: type = \"gxx\" is not allowed: distribution is one of \"vmf\", \"beckmann\", \"phong\", \"blinn\", \
\"ashikhmin-shirley\", \"ggx\", \"charlie\"; did you mean \"ggx\"?
 5 | distribution = { type = \"gxx\", alpha = 0.2 }
   |                         ^^^^^",
        ),
        (
            "distribution = { type = \"vmf\", kappa = [1 }",
            "\
scene.toml:5:43: not valid TOML: missing comma between array elements, expected `,`
 5 | distribution = { type = \"vmf\", kappa = [1 }
   |                                           ^",
        ),
    ] {
        let shown = refusal(&format!("{head}{line}\n")).to_string();
        assert_eq!(shown, expected);
    }
    assert_eq!(
        refusal("").to_string(),
        "scene.toml:1:1: missing key material: a scene holds at least one [[material]], each with name and bxdf\n 1 |\n   \
         | ^"
    );
}

#[test]
fn wrong_toml() {
    let only = str::to_owned;
    all_refused(
        3,
        only,
        &[(
            "[[material]]\nname = 'a'\nname = 'b'\n",
            "not valid TOML: duplicate key",
        )],
    );
    all_refused(
        2,
        only,
        &[
            ("\n= 3\n", "not valid TOML"),
            ("\r\na = '", "not valid TOML"),
            ("[scene]\nname = '\u{0}'\n", "not valid TOML"),
        ],
    );
}

#[test]
fn no_depth_of_nesting_overflows_the_stack() {
    let keys = vec!["a"; 79].join(".");
    let dotted_and_nested = format!("{keys} = {}", format!("{{ {keys} = ").repeat(79)) + "1" + &" }".repeat(79);
    let header = format!("[{keys}]\n{dotted_and_nested}");
    for text in [
        format!("a = {}{}", "[".repeat(10_000), "]".repeat(10_000)),
        format!("a = {}", "[".repeat(1_000_000)),
        format!("a = {}1{}", "{ a = ".repeat(10_000), " }".repeat(10_000)),
        format!("a = {}", "[{ a = ".repeat(200_000)),
        format!("# first\n{} = 1", vec!["a"; 10_000].join(".")),
        format!("[{}]", vec!["a"; 10_000].join(".")),
        dotted_and_nested,
        header,
    ] {
        let refusal = refusal(&text);
        assert!(refusal.to_string().lines().all(|line| line.len() <= 200), "{refusal}");
        assert!(refusal.line <= 2);
    }
}

#[test]
fn many_materials_are_read_in_reasonable_time() {
    let mut text = String::new();
    for i in 0..50_000 {
        text += &format!("[[material]]\nname=\"{i}\"\nbxdf={{type=\"lambertian\",reflectance=0.5}}\n");
    }
    let scene = Scene::parse(&text, "many").unwrap();
    assert_eq!(scene.materials.len(), 50_000);
    assert_eq!(scene.materials[49_999].line, Some(149_998));
}

#[test]
fn files_that_cannot_be_scenes() {
    let directory = tempfile::tempdir().unwrap();
    let missing = directory.path().join("missing.toml");
    let error = Scene::load(&missing).unwrap_err();
    assert!(matches!(error, SceneError::Unreadable { .. }), "{error}");
    assert!(error.to_string().starts_with(&*missing.to_string_lossy()));
    assert!(error.to_string().contains("No such file"), "{error}");
    assert!(matches!(
        Scene::load(directory.path()).unwrap_err(),
        SceneError::Unreadable { .. }
    ));

    let write = |name: &str, bytes: &[u8]| {
        let path = directory.path().join(name);
        File::create(&path).unwrap().write_all(bytes).unwrap();
        path
    };
    let error = Scene::load(&write("latin1.toml", b"[scene]\nname = \"\xe9\"\n")).unwrap_err();
    assert!(matches!(error, SceneError::NotUtf8 { offset: 16, .. }), "{error}");
    assert!(error.to_string().contains("byte 16 (counted from 0)"));

    let large = write("large.toml", b"");
    let file = File::options().write(true).open(&large).unwrap();
    file.set_len(LARGEST as u64 + 1).unwrap();
    let error = Scene::load(&large).unwrap_err();
    assert!(matches!(error, SceneError::TooLarge { .. }), "{error}");
    let file = File::open(&large).unwrap();
    assert_eq!(read_at_most(Vec::new(), &file, 3).unwrap(), None);
    let small = File::open(write("small.toml", b"abcd")).unwrap();
    assert_eq!(read_at_most(Vec::new(), &small, 4).unwrap(), Some(b"abcd".to_vec()));

    let good = write("tour.toml", include_bytes!("default.toml"));
    let scene = Scene::load(&good).unwrap();
    assert_eq!(scene.materials, Scene::default_scene().materials);
    assert_eq!(scene.source, good.display().to_string());
}

#[test]
fn the_format_follows_from_the_first_bytes_and_the_name() {
    for (head, name, format) in [
        (&b"glTF"[..], "a.toml", Format::Glb),
        (b"glT", "a.toml", Format::Toml),
        (b"", "a.glb", Format::Glb),
        (b"{", "dir.glb/a.GLTF", Format::Gltf),
        (b"[sce", "a.gltf/b", Format::Toml),
        (b"", "gltf", Format::Toml),
    ] {
        assert_eq!(Format::of(head, Path::new(name)), format, "{name}");
    }
}

#[test]
fn texts_of_other_formats_are_read_without_a_file() {
    let json = br#"{"asset":{"version":"2.0"},"materials":[{"name":"gold"}]} "#;
    let length = json.len() as u32;
    let header = [
        *b"glTF",
        2u32.to_le_bytes(),
        (20 + length).to_le_bytes(),
        length.to_le_bytes(),
    ]
    .concat();
    let contained = [&header[..], b"JSON", json].concat();
    for bytes in [&json[..], &contained] {
        let scene = Scene::parse_gltf(bytes, "some/ring.gltf").unwrap();
        assert_eq!(
            (scene.name.as_str(), scene.materials[0].name.as_str()),
            ("ring", "gold")
        );
    }
    let error = Scene::parse_gltf(&contained[..30], "ring.glb").unwrap_err().to_string();
    assert!(
        error.contains("ring.glb") && error.contains("within the chunk of JSON"),
        "{error}"
    );
    let scene = Scene::parse_pbrt("Material \"mirror\"\nShape \"sphere\"", "some/ring.pbrt").unwrap();
    assert_eq!((scene.name.as_str(), scene.materials[0].line), ("ring", Some(1)));
    let error = Scene::parse_pbrt("Bogus", "ring.pbrt").unwrap_err().to_string();
    assert!(error.starts_with("ring.pbrt:1:1: unknown directive Bogus"), "{error}");
}
