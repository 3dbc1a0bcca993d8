//! Real scenes through the program: what a plan says in JSON, what a bake makes of it, and what it costs to do without.

mod skip;

use rayon::prelude::*;
use serde_json::Value;
use skip::skip;
use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

const EFFECTS: [&str; 12] = [
    "metal",
    "dielectric",
    "diffuse",
    "transmission",
    "anisotropy",
    "sheen",
    "clearcoat",
    "iridescence",
    "dispersion",
    "measured",
    "roughness-range",
    "colour",
];

/// Standard output of a run that ends well.
fn furnace(directory: &Path, arguments: &[&str]) -> String {
    let output = Command::new(env!("CARGO_BIN_EXE_furnace"))
        .current_dir(directory)
        .args(arguments)
        .output()
        .unwrap();
    let errors = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(0), "{arguments:?}: {errors}");
    String::from_utf8(output.stdout).unwrap()
}

fn json(directory: &Path, arguments: &[&str]) -> Value {
    serde_json::from_str(&furnace(directory, arguments)).unwrap()
}

fn data(name: &str) -> String {
    let path: PathBuf = [env!("CARGO_MANIFEST_DIR"), "tests/data/gltf", name].iter().collect();
    path.to_str().unwrap().to_owned()
}

fn strings(value: &Value) -> Vec<&str> {
    value
        .as_array()
        .unwrap()
        .iter()
        .map(|text| text.as_str().unwrap())
        .collect()
}

/// Small tables: what is asked here does not depend on their size.
const SMALL: [&str; 6] = [
    "--resolution",
    "8",
    "--roughness-resolution",
    "6",
    "--azimuth-resolution",
    "3",
];

#[test]
fn ninety_eight_materials_are_a_handful_of_tables() {
    let directory = tempfile::tempdir().unwrap();
    let here = directory.path();
    let scene = data("MetalRoughSpheresNoTextures.gltf");
    let plan = json(here, &["plan", "--json", &scene]);
    assert_eq!(plan["materials"].as_array().unwrap().len(), 98);
    let tables = plan["tables"].as_array().unwrap();
    assert_eq!(tables.len(), 2);
    for table in tables {
        for key in [
            "id",
            "quantity",
            "axes",
            "channels",
            "materials",
            "seconds",
            "estimator",
            "tolerance",
        ] {
            assert!(!table[key].is_null(), "{key} is missing in {table}");
        }
        assert_eq!(table["channels"], 2);
        // the roughnesses of the file are 0, which is a mirror, 1/6, .., 1
        let axes = table["axes"].as_array().unwrap();
        let alpha = axes.iter().find(|axis| axis["parameter"] == "alpha").unwrap();
        let sixth = f64::from(1.0f32 / 6.0);
        assert!((alpha["min"].as_f64().unwrap() - sixth * sixth).abs() < 1e-8); // printed as f32
        assert_eq!(alpha["max"], 1.0);
        // and those of 14 materials that are mirrors have no use for it
        assert_eq!(table["materials"].as_array().unwrap().len(), 85);
    }
    let all = &plan["cost_of_all_effects"];
    assert!(all["tables"].as_u64().unwrap() > 300, "{all}");
    assert!(all["times_as_long"].as_f64().unwrap() > 10.0, "{all}");

    let bake = json(here, &[&["bake", "--json", &scene], &SMALL[..]].concat());
    let manifest = &bake["manifest"];
    assert_eq!(manifest["tables"].as_array().unwrap().len(), 2);
    assert_eq!(bake["findings"], Value::Array(vec![]));
    // the metal of mat_48 is half of what reflects, the rest a coat over a diffuse base
    let lobes = &manifest["materials"][25]["lobes"];
    assert!(lobes.as_array().unwrap().len() == 2, "{lobes}");
}

#[test]
fn all_effects_of_the_same_scene_are_a_bake_apart() {
    let directory = tempfile::tempdir().unwrap();
    let here = directory.path();
    // two of the spheres, one of metal and one not, so that it takes no minutes
    let text = fs::read_to_string(data("MetalRoughSpheresNoTextures.gltf")).unwrap();
    let mut gltf: Value = serde_json::from_str(&text).unwrap();
    let materials = gltf["materials"].as_array().unwrap();
    gltf["materials"] = Value::Array(vec![materials[3].clone(), materials[45].clone()]);
    for name in ["meshes", "nodes", "scenes"] {
        gltf.as_object_mut().unwrap().remove(name);
    }
    fs::write(here.join("two.gltf"), gltf.to_string()).unwrap();
    let bake = |flags: &[&str]| json(here, &[&["bake", "two.gltf", "--json"], &SMALL[..], flags].concat());
    let sum = |bake: &Value, key: &str| -> u64 {
        let tables = bake["manifest"]["tables"].as_array().unwrap();
        tables.iter().map(|table| table[key].as_u64().unwrap()).sum()
    };
    let own = bake(&["--out", "own"]);
    let all = bake(&["--out", "all", "--all-effects"]);
    assert!(sum(&all, "bytes") > 3 * sum(&own, "bytes"));
    assert!(sum(&all, "evaluations") > sum(&own, "evaluations"));
    assert_eq!(all["manifest"]["all_effects"], true);
    // and the tables are those that verification expects
    furnace(here, &["verify", "two.gltf", "--tables", "all"]);
    furnace(here, &["verify", "two.gltf", "--tables", "own"]);
}

#[test]
fn a_scene_without_light_has_an_empty_plan() {
    let directory = tempfile::tempdir().unwrap();
    let here = directory.path();
    let scene = data("UnlitTest.gltf");
    let plan = json(here, &["plan", "--json", &scene]);
    assert_eq!(plan["tables"], Value::Array(vec![]));
    for material in plan["materials"].as_array().unwrap() {
        assert_eq!(material["effects"], Value::Array(vec![]), "{material}");
    }
    let skipped: Vec<&str> = plan["skipped"]
        .as_array()
        .unwrap()
        .iter()
        .map(|skipped| skipped["effect"].as_str().unwrap())
        .collect();
    assert_eq!(skipped, EFFECTS);
    let report = furnace(here, &["bake", &scene, "--out", "out"]);
    assert!(report.contains("Nothing to compute"), "{report}");
    let manifest: Value = serde_json::from_slice(&fs::read(here.join("out/manifest.json")).unwrap()).unwrap();
    assert_eq!(manifest["tables"], Value::Array(vec![]));
}

/// Every effect is called for by some material or skipped, never both, and each with words.
#[test]
fn every_effect_is_called_for_or_skipped() {
    let directory = tempfile::tempdir().unwrap();
    let here = directory.path();
    fs::write(
        here.join("scene.pbrt"),
        "WorldBegin\nMaterial \"metal\" \"float roughness\" .2\nShape \"sphere\"\nMaterial \"matte\"\nShape \"sphere\"\n\
         Material \"hair\"\nShape \"sphere\"\nWorldEnd\n",
    )
    .unwrap();
    let shared = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/data/gltf");
    let mut scenes = vec!["scene.pbrt".to_owned(), data("MetalRoughSpheresNoTextures.gltf")];
    match fs::read_dir(&shared) {
        Ok(entries) => scenes.extend(entries.map(|entry| entry.unwrap().path().to_str().unwrap().to_owned())),
        Err(_) => skip(format!("{} is not there; two scenes are", shared.display())),
    }
    scenes.par_iter().for_each(|scene| {
        let plan = json(
            here,
            &[
                "plan",
                "--json",
                scene,
                "--resolution",
                "4",
                "--azimuth-resolution",
                "2",
            ],
        );
        let mut called = BTreeSet::new();
        for kind in ["materials", "implied_materials"] {
            for material in plan[kind].as_array().unwrap() {
                for effect in strings(&material["effects"]) {
                    assert!(EFFECTS.contains(&effect), "{scene}: {effect}");
                    let by = material["called_for_by"][effect].as_str().unwrap();
                    assert!(!by.is_empty(), "{scene}: {material}");
                    called.insert(effect);
                }
                for gap in strings(&material["not_covered"]) {
                    assert!(
                        !material["not_covered_because"][gap].as_str().unwrap().is_empty(),
                        "{scene}"
                    );
                }
            }
        }
        for skipped in plan["skipped"].as_array().unwrap() {
            let effect = skipped["effect"].as_str().unwrap();
            assert!(called.insert(effect), "{scene}: {effect} is called for and skipped");
            assert!(!skipped["reason"].as_str().unwrap().is_empty());
        }
        assert_eq!(called.len(), EFFECTS.len(), "{scene}: {called:?}");
    });
}

#[test]
fn what_is_not_covered_is_said_and_the_rest_is_baked() {
    let directory = tempfile::tempdir().unwrap();
    let here = directory.path();
    let gltf = r#"{"asset": {"version": "2.0"}, "materials": [{"name": "velvet", "pbrMetallicRoughness": {"metallicFactor": 0,
        "roughnessFactor": 0.5}, "extensions": {"KHR_materials_sheen": {"sheenColorFactor": [1, 0, 0]}, "ACME_glitter": {}}}]}"#;
    fs::write(here.join("velvet.gltf"), gltf).unwrap();
    let report = furnace(here, &[&["bake", "velvet.gltf", "--out", "out"], &SMALL[..]].concat());
    assert!(!report.contains("not covered: velvet: sheen"), "{report}");
    assert!(here.join("out/velvet.rho_hd.exr").exists(), "{report}");
    assert!(report.contains("not covered: velvet: ACME_glitter"), "{report}");
    assert!(here.join("out/ggx-smith-correlated.split-sum.rho_hd.exr").exists());
    let plan = furnace(here, &["plan", "velvet.gltf"]);
    assert!(
        !plan.contains("sheen not covered") && plan.contains("ACME_glitter not covered"),
        "{plan}"
    );
}

/// One changed material of three costs its own tables; another name none.
#[test]
fn a_changed_material_costs_its_own_tables() {
    let directory = tempfile::tempdir().unwrap();
    let here = directory.path();
    let scene = |eta: f64, name: &str| {
        let lobe = |name: &str, eta: f64| {
            format!(
                "[[material]]\nname = \"{name}\"\nbxdf = {{ type = \"microfacet\", distribution = {{ type = \"beckmann\", m = 0.3 }}, \
                 masking = \"smith\", fresnel = {{ type = \"dielectric\", eta = {eta:?} }} }}\n"
            )
        };
        let text = [lobe("a", 1.3), lobe("b", eta), lobe(name, 1.6)].concat();
        fs::write(here.join("scene.toml"), text).unwrap();
        let bake = json(
            here,
            &[&["bake", "scene.toml", "--json", "--out", "out"], &SMALL[..]].concat(),
        );
        let found: Vec<String> = strings(&bake["found_finished"])
            .into_iter()
            .map(str::to_owned)
            .collect();
        assert_eq!(strings(&bake["manifest"]["reused"]), found);
        found
    };
    assert_eq!(scene(1.4, "c"), [""; 0]);
    assert_eq!(scene(1.5, "c"), ["a.rho_hd", "a.rho_hh", "c.rho_hd", "c.rho_hh"]);
    assert_eq!(scene(1.5, "d").len(), 6);
    assert_eq!(scene(1.4, "c").len(), 6, "the way back costs nothing");
}
