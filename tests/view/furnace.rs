//! The furnace in the page, against albedos that are integrated here and now.

use crate::browser::{Visit, assert_quiet, visit};
use crate::command::furnace;
use glam::DVec3;
use serde_json::{Value, json};
use std::fs;
use std::path::Path;
use whitefurnace::bxdf::{Coupling, DiffuseSpecular, Microfacet, Model};
use whitefurnace::distribution::Family;
use whitefurnace::estimate::{Effort, Estimator};
use whitefurnace::fresnel::Fresnel;
use whitefurnace::integrate::{Integrator, Target};
use whitefurnace::masking::Masking;
use whitefurnace::scene::Scene;
use whitefurnace::spectrum::Spectrum;

/// What the reference of a page errs by between its points, beside its integrals' 1e-5: 5e-6 was found. A page states the rest.
const BETWEEN: f64 = 3e-5;

/// A choice in the page, and what the furnace reads for it.
struct Case {
    choice: Value,
    truth: DVec3,
}

fn rho(model: &Model, target: Target) -> DVec3 {
    let effort = Effort {
        tolerance: 1e-7,
        samples: None,
        seed: 0,
    };
    let integrator = Integrator::new(model, Estimator::Auto, effort).unwrap();
    integrator.estimate(target, 0).unwrap().value
}

fn lobe(family: Family, masking: Masking, roughness: f64, r0: f64) -> Model {
    let fresnel = Fresnel::schlick(Spectrum::grey(r0)).unwrap();
    let distribution = family.with(roughness).unwrap();
    Model::Microfacet(Microfacet::new(Spectrum::grey(1.0), distribution, masking, fresnel).unwrap())
}

fn coupled(lobe: Model, coupling: Coupling) -> Model {
    let one = Spectrum::grey(1.0);
    Model::DiffuseSpecular(Box::new(DiffuseSpecular::new(lobe, one, one, coupling).unwrap()))
}

/// The mean Fresnel term of Schlick, over cosines.
fn multiple(r0: f64, mean: f64) -> f64 {
    let fresnel = (20.0 * r0 + 1.0) / 21.0;
    fresnel * fresnel * mean / (1.0 - fresnel * (1.0 - mean))
}

/// Every surface of the built-in scene at several roughnesses, under every way to keep or lose energy.
fn free_cases() -> Vec<Case> {
    let surfaces = [
        (Family::Vmf, Masking::VGroove, [5.0, 60.0, 1500.0]),
        (Family::Beckmann, Masking::VGroove, [0.08, 0.3, 0.9]),
        (Family::Phong, Masking::VGroove, [5.0, 60.0, 1500.0]),
        (Family::Ggx, Masking::SmithCorrelated, [0.08, 0.3, 0.9]),
    ];
    let sizes = [8, 16, 32, 64, 128];
    let mut cases = Vec::new();
    for (family, masking, roughnesses) in surfaces {
        for (i, roughness) in roughnesses.into_iter().enumerate() {
            for (j, mu) in [0.07, 0.4, 1.0].into_iter().enumerate() {
                let at = Target::rho_hd(mu, 0.0);
                let e = rho(&lobe(family, masking, roughness, 1.0), at).x;
                let e_mean = rho(&lobe(family, masking, roughness, 1.0), Target::rho_hh()).x;
                let albedo = |r0| rho(&lobe(family, masking, roughness, r0), at).x;
                let whole = |r0, coupling| rho(&coupled(lobe(family, masking, roughness, r0), coupling), at).x;
                let name = format!("any {}, {}", family.name(), masking.name());
                let mut add = |r0: f64, coupling: &str, compensation: &str, truth: f64| {
                    let place = cases.len();
                    let (size, storage) = (sizes[(i + j + place) % 5], ["f32", "f16"][place % 2]);
                    cases.push(Case {
                        choice: json!({
                            "material": name, "roughness": roughness, "mu": mu, "r0": r0, "ks": 1, "kd": 1,
                            "coupling": coupling, "compensation": compensation,
                            "size": size, "storage": storage,
                        }),
                        truth: DVec3::splat(truth),
                    });
                };
                // nothing is lost
                add(0.04, "energy-preserving", "none", 1.0);
                add(0.6, "energy-preserving", "kulla-conty", 1.0);
                add(1.0, "none", "kulla-conty", 1.0);
                add(1.0, "none", "turquin", 1.0);
                // what is lost is known
                add(1.0, "none", "none", e);
                add(0.04, "mikkelsen", "none", whole(0.04, Coupling::Mikkelsen));
                add(
                    0.3,
                    "none",
                    "kulla-conty",
                    albedo(0.3) + multiple(0.3, e_mean) * (1.0 - e),
                );
                add(0.3, "none", "turquin", albedo(0.3) * (1.0 + 0.3 * (1.0 - e) / e));
            }
        }
    }
    cases
}

/// The materials of the scene as they are.
fn scene_cases(shown: &[&str]) -> Vec<Case> {
    let scene = Scene::default_scene();
    let materials = scene
        .materials
        .iter()
        .filter(|material| shown.contains(&material.name.as_str()));
    let of = |material: &whitefurnace::scene::Material| {
        let range = material.model.roughness_range();
        let roughness = range.map(|(_, min, max)| (min * max).sqrt());
        let model = material.model.at(roughness).unwrap();
        [0.15, 0.8].map(|mu| {
            let mut choice = json!({ "material": material.name, "mu": mu, "size": 128 });
            if let Some(roughness) = roughness {
                choice["roughness"] = json!(roughness);
            }
            let truth = rho(&model, Target::rho_hd(mu, 0.0));
            Case { choice, truth }
        })
    };
    materials.flat_map(of).collect()
}

fn triple(value: &Value) -> DVec3 {
    DVec3::from_array([0, 1, 2].map(|i| value[i].as_f64().unwrap_or(f64::NAN)))
}

fn assert_reads(cases: &[Case], reads: &[Value]) {
    assert_eq!(cases.len(), reads.len());
    let mut least = [f64::INFINITY; 2];
    let mut worst = [0.0_f64; 2];
    for (Case { choice, truth }, read) in cases.iter().zip(reads) {
        let (shader, expected) = (triple(&read["shader"]), triple(&read["expected"]));
        let error = read["error"].as_f64().unwrap();
        let off = (expected - *truth).abs().max_element();
        worst[0] = worst[0].max(off);
        assert!(
            off <= BETWEEN,
            "{choice}: predicts {expected} for {truth}, off by {off:e}"
        );
        let off = (shader - *truth).abs().max_element();
        assert!(
            off <= error + BETWEEN,
            "{choice}: reads {shader} for {truth}, off by {off:e}, stated {error:e}"
        );
        if choice["compensation"] == "none" && choice["coupling"] == "none" {
            worst[1] = worst[1].max(off);
        }
        // a stated error that is always large would make that hold of anything
        let size = choice["size"].as_u64().unwrap();
        if size >= 64 {
            assert!(error < 0.01, "{choice}: states {error}");
        }
        least = [least[0].min(truth.min_element()), least[1].min(error)];
    }
    eprintln!(
        "predictions are off by {:.1e} at most, the shader's rule by {:.1e}",
        worst[0], worst[1]
    );
    // there were cases with much lost and with tables that are good
    assert!(least[0] < 0.6 && least[1] < 1e-3, "{least:?}");
}

fn assert_keyboard(seen: &Value) {
    let ids = |value: &Value| -> Vec<String> {
        let all = value.as_array().unwrap().iter();
        all.map(|id| id.as_str().unwrap().to_owned()).collect()
    };
    let reached = ids(&seen["reached"]);
    let controls = seen["controls"].as_array().unwrap();
    assert!(controls.len() >= 16, "{controls:?}");
    for control in controls {
        let id = control["id"].as_str().unwrap();
        assert!(
            reached.iter().any(|other| other == id),
            "Tab does not reach {id}: {reached:?}"
        );
        assert!(
            control["labels"].as_u64() > Some(0) || id == "reset",
            "{id} has no label"
        );
        if id != "reset" && id != "summary" {
            assert_eq!(seen["moved"][id], true, "keys do not change {id}");
        }
    }
}

#[test]
fn the_furnace_reads_what_is_kept_and_what_is_lost() {
    let directory = Path::new(env!("CARGO_TARGET_TMPDIR")).join("view");
    fs::create_dir_all(&directory).unwrap();
    let output = furnace(&directory, &["view", "--out", "view.html"]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let page = directory.join("view.html");
    assert!(
        fs::metadata(&page).unwrap().len() < 3 << 20,
        "a page is to be passed on"
    );
    let shown = [
        "methanol-k17",
        "methanol-k1024",
        "aluminium-k17",
        "aluminium-k1024",
        "beckmann-m0.2",
        "phong-n48",
        "ggx-a0.3",
        "vmf-any-roughness",
    ];
    let cases: Vec<Case> = free_cases().into_iter().chain(scene_cases(&shown)).collect();
    let asked = Visit {
        reads: cases.iter().map(|case| case.choice.clone()).collect(),
        keyboard: true,
        shots: Some(directory.join("shots")),
    };
    let Some(seen) = visit(&page, &asked) else { return };
    assert_quiet(&seen, &page);
    for name in shown {
        assert!(seen["materials"].as_array().unwrap().contains(&json!(name)), "{name}");
    }
    assert_reads(&cases, seen["reads"].as_array().unwrap());
    assert_keyboard(&seen["keyboard"]);
    let summary = seen["summary"].as_str().unwrap();
    assert!(
        summary.contains("the shader reads") && summary.contains("stated error"),
        "{summary}"
    );
}
