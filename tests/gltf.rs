//! Materials of glTF files that others published, against what is known of them, and of those that a validator refuses.

mod skip;

use serde_json::{Value, json};
use skip::skip;
use std::collections::BTreeMap;
use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use whitefurnace::bxdf::Veil;
use whitefurnace::fresnel::Fresnel;
use whitefurnace::masking::Masking;
use whitefurnace::scene::{DistributionSpec, ModelSpec, Roughness, Scene};

/// What a file calls for.
struct Expected {
    file: &'static str,
    /// Materials in use, that of primitives without one included.
    materials: usize,
    /// How many of them call for each effect.
    effects: &'static [(&'static str, usize)],
    /// Every perceptual roughness of a lobe that is one value.
    roughness: &'static [f64],
    /// Ends of the perceptual roughness of lobes that a texture makes rough.
    range: Option<[f64; 2]>,
    /// Every index of refraction, of dielectrics whose specular colour is white.
    indices: &'static [f64],
}

const SIXTHS: [f64; 7] = [0.0, 1.0 / 6.0, 2.0 / 6.0, 0.5, 4.0 / 6.0, 5.0 / 6.0, 1.0];

/// alpha = 0.001 in place of 0, along the bitangent of stretched mirrors.
const STRETCHED: f64 = 0.0316227766;

/// The smallest roughness of a texture that is no mirror, alpha = 1e-6.
const LEAST: f64 = 1e-3;

/// What the sample assets and their descriptions say. AnisotropyStrengthTest varies the strength in sevenths of rows, of which
/// one is 0; DispersionTest has 25 drops, 5 without dispersion and 4 more with the index of air.
const KEY: [Expected; 15] = [
    Expected {
        file: "MetalRoughSpheresNoTextures.gltf",
        materials: 99,
        effects: &[("dielectric", 84), ("diffuse", 84), ("metal", 85)],
        roughness: &SIXTHS,
        range: None,
        indices: &[1.5],
    },
    Expected {
        file: "UnlitTest.gltf",
        materials: 2,
        effects: &[],
        roughness: &[],
        range: None,
        indices: &[],
    },
    Expected {
        file: "AnisotropyStrengthTest.gltf",
        materials: 50,
        effects: &[("anisotropy", 42), ("dielectric", 1), ("diffuse", 1), ("metal", 49)],
        roughness: &[
            0.0,
            STRETCHED,
            1.0 / 6.0,
            2.0 / 6.0,
            0.5,
            4.0 / 6.0,
            0.8,
            5.0 / 6.0,
            1.0,
        ],
        range: None,
        indices: &[1.5],
    },
    Expected {
        file: "AttenuationTest.gltf",
        materials: 18,
        effects: &[("dielectric", 2), ("diffuse", 2), ("transmission", 16)],
        roughness: &[0.0, 0.5, 0.8],
        range: None,
        indices: &[1.5],
    },
    Expected {
        file: "ClearCoatTest.gltf",
        materials: 19,
        effects: &[
            ("clearcoat", 6),
            ("dielectric", 19),
            ("diffuse", 13),
            // a base and a coat
            ("roughness-range", 2),
        ],
        roughness: &[0.03, 0.44, 0.6, 0.9],
        range: Some([LEAST, 1.0]),
        indices: &[1.5],
    },
    Expected {
        file: "DispersionTest.gltf",
        materials: 27,
        effects: &[
            ("dielectric", 2),
            ("diffuse", 2),
            ("dispersion", 16),
            ("transmission", 25),
        ],
        roughness: &[0.0, 0.4935, 0.8],
        range: None,
        indices: &[1.0, 1.33, 1.5, 1.76, 2.42],
    },
    Expected {
        file: "EmissiveStrengthTest.gltf",
        materials: 6,
        effects: &[("dielectric", 6), ("diffuse", 1)],
        roughness: &[0.5, 0.8],
        range: None,
        indices: &[1.5],
    },
    Expected {
        file: "SpecularTest.gltf",
        materials: 24,
        effects: &[("dielectric", 23), ("diffuse", 1)],
        roughness: &[0.0, 0.8],
        range: None,
        indices: &[],
    },
    Expected {
        file: "TransmissionRoughnessTest.glb",
        materials: 9,
        effects: &[
            ("dielectric", 4),
            ("diffuse", 4),
            ("metal", 6),
            ("roughness-range", 6),
            ("transmission", 5),
        ],
        // an index of 1 bends nothing, however rough
        roughness: &[0.0, 0.5, 0.8],
        range: Some([LEAST, 1.0]),
        indices: &[1.0, 1.33, 1.5, 1.76, 2.42],
    },
    Expected {
        file: "ToyCar.materials.gltf",
        materials: 3,
        effects: &[
            ("clearcoat", 1),
            ("dielectric", 2),
            ("diffuse", 2),
            ("metal", 1),
            ("roughness-range", 1),
            ("sheen", 1),
            ("transmission", 1),
        ],
        roughness: &[0.0, 1.0],
        range: Some([LEAST, 1.0]),
        indices: &[1.5],
    },
    Expected {
        file: "SheenChair.materials.gltf",
        materials: 4,
        effects: &[
            ("dielectric", 3),
            ("diffuse", 3),
            ("metal", 3),
            ("roughness-range", 2),
            ("sheen", 1),
        ],
        roughness: &[0.6, 1.0],
        range: Some([LEAST, 1.0]),
        indices: &[1.5],
    },
    Expected {
        file: "15_transmission.gltf",
        materials: 5,
        effects: &[("metal", 5)],
        roughness: &[1.0],
        range: None,
        indices: &[],
    },
    Expected {
        file: "17_ior.gltf",
        materials: 5,
        effects: &[("dielectric", 5), ("diffuse", 5), ("transmission", 3)],
        roughness: &[0.4],
        range: None,
        indices: &[1.45, 1.5, 2.0],
    },
    Expected {
        file: "18_variants.gltf",
        materials: 5,
        effects: &[("dielectric", 5), ("diffuse", 5)],
        roughness: &[0.4, 0.5],
        range: None,
        indices: &[1.5],
    },
    Expected {
        file: "BoxTextured_specgloss.gltf",
        materials: 1,
        effects: &[("dielectric", 1), ("diffuse", 1)],
        roughness: &[0.0],
        range: None,
        // F0 = 0.2
        indices: &[2.618034],
    },
];

/// The published files, `None` where they are not at hand.
fn published(folder: &str) -> Option<PathBuf> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../shared/data")
        .join(folder);
    let is_there = path.is_dir();
    if !is_there {
        skip(format!("{} is not here", path.display()));
    }
    is_there.then_some(path)
}

fn own(file: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/gltf").join(file)
}

/// The parameters of lobes.
#[derive(Default)]
struct Found {
    roughness: Vec<f64>,
    ranges: Vec<[f64; 2]>,
    indices: Vec<f64>,
}

impl Found {
    fn walk(&mut self, model: &ModelSpec) {
        match model {
            ModelSpec::Microfacet {
                distribution, fresnel, ..
            } => {
                self.fresnel(fresnel);
                match distribution {
                    DistributionSpec::Isotropic { roughness, .. } => match roughness {
                        Roughness::Fixed(alpha) => self.roughness.push(alpha.sqrt()),
                        Roughness::Range { min, max } => self.ranges.push([min.sqrt(), max.sqrt()]),
                    },
                    DistributionSpec::Anisotropic(lobe) => self.roughness.push(lobe.parameters()[1].sqrt()),
                }
            }
            ModelSpec::SpecularReflection(mirror) => {
                self.roughness.push(0.0);
                self.fresnel(mirror.fresnel());
            }
            ModelSpec::FresnelSpecular(glass) => {
                self.roughness.push(0.0);
                self.indices.push(glass.eta_b());
            }
            // layers have a test of their own
            ModelSpec::Layered { base, .. } => self.walk(base),
            ModelSpec::RoughDielectric { roughness, media, .. } => {
                match roughness {
                    Roughness::Fixed(alpha) => self.roughness.push(alpha.sqrt()),
                    Roughness::Range { min, max } => self.ranges.push([min.sqrt(), max.sqrt()]),
                }
                self.indices.push(media.eta_b);
            }
            other => other.parts().into_iter().for_each(|part| self.walk(part)),
        }
    }

    /// Grey reflectances up to that of diamond are those of dielectrics; no metal of these files is as dark.
    fn fresnel(&mut self, fresnel: &Fresnel) {
        let Fresnel::Schlick { r0 } = fresnel else {
            panic!("{fresnel:?}")
        };
        if r0.value().max_element() <= 0.2 + 1e-6 && r0.value().min_element() == r0.value().max_element() {
            let root = r0.value().x.sqrt();
            self.indices.push((1.0 + root) / (1.0 - root));
        }
    }
}

/// The different ones of `values`; they were written with seven digits.
fn distinct(mut values: Vec<f64>) -> Vec<f64> {
    values.sort_by(f64::total_cmp);
    values.dedup_by(|a, b| (*a - *b).abs() < 1e-6);
    values
}

fn assert_close(file: &str, found: Vec<f64>, expected: &[f64]) {
    let found = distinct(found);
    let is_close = |(a, b): (&f64, &f64)| (a - b).abs() < 1e-6;
    assert!(
        found.len() == expected.len() && found.iter().zip(expected).all(is_close),
        "{file}: {found:?}, expected {expected:?}"
    );
}

fn check(path: &Path, expected: &Expected) {
    let file = expected.file;
    let scene = Scene::load(path).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(scene.materials.len(), expected.materials, "{file}");
    assert_eq!(scene.name, Path::new(file).file_stem().unwrap().to_str().unwrap());
    assert_eq!((scene.means, scene.unused.len()), (false, 0), "{file}");
    assert!(scene.warnings.is_empty(), "{file}: {:?}", scene.warnings);
    let (mut effects, mut found) = (BTreeMap::new(), Found::default());
    for material in &scene.materials {
        assert!(material.model.at(None).is_ok(), "{file}: {}", material.name);
        assert!(
            material.calls.is_sorted_by(|a, b| a.effect < b.effect),
            "{file}: {}",
            material.name
        );
        for call in &material.calls {
            *effects.entry(call.effect.name()).or_insert(0) += 1;
        }
        found.walk(&material.model);
    }
    assert_eq!(effects, expected.effects.iter().copied().collect(), "{file}");
    assert_close(file, found.roughness, expected.roughness);
    let ends: Vec<f64> = found.ranges.concat();
    assert_close(file, ends, expected.range.as_ref().map_or(&[], |range| &range[..]));
    if !expected.indices.is_empty() {
        assert_close(file, found.indices, expected.indices);
    }
}

#[test]
fn copies_call_for_what_they_show() {
    for expected in &KEY[..2] {
        check(&own(expected.file), expected);
    }
    let scene = Scene::load(&own("MetalRoughSpheresNoTextures.gltf")).unwrap();
    let last = scene.materials.last().unwrap();
    assert_eq!((last.name.as_str(), last.implied), ("default material", true));
    assert_eq!(last.calls[0].by, "25 primitives that name no material");
}

#[test]
fn published_files_call_for_what_they_show() {
    let Some(folder) = published("gltf") else { return };
    for expected in &KEY {
        check(&folder.join(expected.file), expected);
    }
    // none is left out of the key
    assert_eq!(fs::read_dir(&folder).unwrap().count(), KEY.len());
}

/// Sheen and clearcoat are lobes with their published roughnesses, and nothing of them is left out.
#[test]
fn layers_of_published_files_are_lobes() {
    let Some(folder) = published("gltf") else { return };
    for (file, sheens, coats) in [
        ("ToyCar.materials.gltf", 1, 1),
        ("SheenChair.materials.gltf", 1, 0),
        ("ClearCoatTest.gltf", 0, 6),
    ] {
        let scene = Scene::load(&folder.join(file)).unwrap();
        let mut found = (0, 0);
        for material in &scene.materials {
            let gaps: Vec<&str> = material.gaps.iter().map(|gap| gap.what.as_str()).collect();
            assert!(
                !gaps.contains(&"sheen") && !gaps.contains(&"clearcoat"),
                "{file}: {gaps:?}"
            );
            let ModelSpec::Layered { top, veil, .. } = &material.model else {
                continue;
            };
            let (masking, r0) = match top.as_ref() {
                ModelSpec::Microfacet { masking, fresnel, .. } => (Some(*masking), *fresnel),
                ModelSpec::SpecularReflection(mirror) => (None, *mirror.fresnel()),
                other => panic!("{file}: {other:?}"),
            };
            if masking == Some(Masking::Charlie) {
                assert_eq!((*veil, r0), (Veil::Albedo, Fresnel::None), "{file}");
                found.0 += 1;
            } else {
                assert!(matches!(r0, Fresnel::Schlick { r0 } if r0.value().x == 0.04), "{file}");
                assert_eq!(*veil, Veil::Fresnel, "{file}");
                found.1 += 1;
            }
        }
        assert_eq!(found, (sheens, coats), "{file}");
    }
}

#[test]
fn specular_factors_scale_the_lobe_and_its_reflectance() {
    let Some(folder) = published("gltf") else { return };
    let scene = Scene::load(&folder.join("SpecularTest.gltf")).unwrap();
    let model = |name: &str| {
        &scene
            .materials
            .iter()
            .find(|material| material.name == name)
            .unwrap()
            .model
    };
    assert_eq!(*model("M1.1_specFac"), ModelSpec::Sum(vec![]));
    let ModelSpec::Scaled { scale, .. } = model("M1.3_specFac") else {
        panic!("{:?}", model("M1.3_specFac"))
    };
    assert_eq!(scale.value().x, 0.212231);
    let r0 = |name: &str| match model(name) {
        ModelSpec::SpecularReflection(mirror) => match mirror.fresnel() {
            Fresnel::Schlick { r0 } => r0.value().to_array(),
            other => panic!("{other:?}"),
        },
        other => panic!("{other:?}"),
    };
    assert_eq!(r0("M7.5_HDR"), [1.0; 3]);
    assert_eq!(r0("M5.5_yellowFac")[2], 0.0);
    assert!((r0("M5.5_yellowFac")[0] - 0.04).abs() < 1e-15); // rounding of (0.5/2.5)^2
}

#[test]
fn what_a_validator_refuses_is_refused_or_told() {
    let Some(folder) = published("gltf-bad") else { return };
    let mut counts = [0; 3];
    for family in fs::read_dir(&folder).unwrap() {
        for entry in fs::read_dir(family.unwrap().path()).unwrap() {
            let path = entry.unwrap().path();
            if path.extension().is_some_and(|ending| ending == "json") {
                continue;
            }
            let report = fs::read_to_string(format!("{}.report.json", path.display())).unwrap();
            let report: Value = serde_json::from_str(&report).unwrap();
            let errors = report["issues"]["numErrors"].as_u64().unwrap();
            let read = Scene::load(&path);
            let index = match (&read, errors) {
                (Err(error), 0) => panic!("{error}"),
                (Err(error), _) => {
                    let message = error.to_string();
                    assert!(message.starts_with(&path.display().to_string()), "{message}");
                    0
                }
                (Ok(scene), 0) => {
                    assert!(scene.materials.iter().all(|material| material.model.at(None).is_ok()));
                    1
                }
                (Ok(scene), _) => {
                    // that there are no materials does not tell what is wrong
                    let tells = |warning: &String| !warning.ends_with("nothing to compute");
                    assert!(
                        scene.warnings.iter().any(tells),
                        "{}: {:?}",
                        path.display(),
                        scene.warnings
                    );
                    2
                }
            };
            counts[index] += 1;
        }
    }
    let [refused, fine, told] = counts;
    assert!(refused > 15 && fine > 40 && told > 25, "{counts:?}");
}

fn furnace(arguments: &[&str], input: &[u8]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_furnace"));
    let command = command.args(arguments).stdin(Stdio::piped()).stdout(Stdio::piped());
    let mut child = command.stderr(Stdio::piped()).spawn().unwrap();
    // it may have gone without reading all
    let _ = child.stdin.take().unwrap().write_all(input);
    child.wait_with_output().unwrap()
}

#[test]
fn scenes_with_nothing_to_compute_are_told_as_such() {
    let directory = tempfile::tempdir().unwrap();
    let empty = directory.path().join("empty.gltf");
    fs::write(&empty, json!({ "asset": { "version": "2.0" } }).to_string()).unwrap();
    let out = directory.path().join("out");
    for (scene, expected) in [
        (empty, "the file has no materials, so that there is nothing to compute"),
        (
            own("UnlitTest.gltf"),
            "no material scatters light, so that there is nothing to compute",
        ),
    ] {
        let scene = scene.to_str().unwrap();
        for arguments in [
            &["rho", scene][..],
            &["plan", scene],
            &["plan", "--tolerance", "1e-3", scene],
            &["verify", scene],
            &["bake", "--out", out.to_str().unwrap(), scene],
        ] {
            let output = furnace(arguments, b"");
            let errors = String::from_utf8_lossy(&output.stderr);
            assert_eq!(output.status.code(), Some(0), "{arguments:?}: {errors}");
            assert!(errors.contains(expected), "{arguments:?}: {errors}");
        }
    }
}

#[cfg(unix)]
#[test]
fn binary_files_come_through_pipes_and_mistakes_are_told_with_their_place() {
    let mut json = json!({ "asset": { "version": "2.0" }, "materials": [{ "name": "gold" }] }).to_string();
    while !json.len().is_multiple_of(4) {
        json.push(' ');
    }
    let mut bytes = b"glTF\x02\0\0\0".to_vec();
    bytes.extend((20 + json.len() as u32).to_le_bytes());
    bytes.extend((json.len() as u32).to_le_bytes());
    bytes.extend(b"JSON");
    bytes.extend(json.as_bytes());
    let output = furnace(&["plan", "--json", "/dev/stdin"], &bytes);
    let plan: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(plan["materials"][0]["name"], "gold");
    assert!(output.stderr.is_empty(), "{}", String::from_utf8_lossy(&output.stderr));

    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("a.gltf");
    let rough = json!({ "pbrMetallicRoughness": { "roughnessFactor": 7 } });
    let file = json!({ "asset": { "version": "2.0" }, "materials": [rough] });
    fs::write(&path, file.to_string()).unwrap();
    let output = furnace(&["plan", path.to_str().unwrap()], b"");
    assert_eq!(output.status.code(), Some(2));
    assert_eq!(
        String::from_utf8_lossy(&output.stderr),
        format!(
            "error: {}: materials[0].pbrMetallicRoughness.roughnessFactor = 7 is not allowed: roughnessFactor lies in [0, 1]\n",
            path.display()
        )
    );
}
