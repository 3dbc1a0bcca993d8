//! Layers: the documented total, from rules and from samples, and what scenes, plans and manifests say of it.

use std::fs;
use std::process::Command;
use whitefurnace::bxdf::{Bxdf, Layered, Model, Sampling, Veil};
use whitefurnace::estimate::{Effort, Estimator};
use whitefurnace::geometry::Polar;
use whitefurnace::integrate::{Integrator, Target, sampled};
use whitefurnace::plan::{Plan, Request, Source};
use whitefurnace::scene::Scene;

const SHEEN: &str = "{ type = \"microfacet\", reflectance = [0.9, 0.5, 0.1], distribution = { type = \"charlie\", alpha = 0.25 }, \
                     masking = \"charlie\", fresnel = \"none\" }";
const COAT: &str = "{ type = \"microfacet\", reflectance = 0.5, distribution = { type = \"ggx\", alpha = 0.25 }, masking = \
                    \"smith-correlated\", fresnel = { type = \"schlick\", r0 = 0.04 } }";
const MIRROR: &str = "{ type = \"specular-reflection\", fresnel = { type = \"schlick\", r0 = 0.04 } }";
const DIFFUSE: &str = "{ type = \"lambertian\", reflectance = [0.2, 0.5, 0.8] }";
const PLASTIC: &str = "{ type = \"diffuse-specular\", coupling = \"energy-preserving\", ks = 1.0, kd = 0.5, specular = { type = \
                       \"microfacet\", distribution = { type = \"ggx\", alpha = 0.3 }, masking = \"smith-correlated\", fresnel = { \
                       type = \"schlick\", r0 = 0.04 } } }";

fn layers(top: &str, base: &str, veil: &str) -> String {
    format!("{{ type = \"layered\", veil = \"{veil}\", top = {top}, base = {base} }}")
}

fn scene(bxdf: &str) -> Scene {
    Scene::parse(&format!("[[material]]\nname = \"m\"\nbxdf = {bxdf}\n"), "s.toml").unwrap()
}

fn model(bxdf: &str) -> Model {
    scene(bxdf).materials[0].model.at(None).unwrap()
}

fn rho(model: &Model, target: Target) -> (glam::DVec3, glam::DVec3) {
    let effort = Effort {
        tolerance: 1e-7,
        samples: None,
        seed: 0,
    };
    let found = Integrator::new(model, Estimator::Auto, effort)
        .unwrap()
        .estimate(target, 0)
        .unwrap();
    (found.value, found.error)
}

fn all() -> [(String, Veil); 4] {
    [
        (layers(SHEEN, PLASTIC, "albedo"), Veil::Albedo),
        (layers(COAT, PLASTIC, "fresnel"), Veil::Fresnel),
        (layers(MIRROR, DIFFUSE, "fresnel"), Veil::Fresnel),
        (
            layers(COAT, &layers(SHEEN, DIFFUSE, "albedo"), "fresnel"),
            Veil::Fresnel,
        ),
    ]
}

/// rho = rho_top + max(0, 1 - max rho_top) rho_base, and with 1 - max R F(mu) in place of the factor.
#[test]
fn totals_are_the_documented_ones() {
    for (bxdf, veil) in all() {
        let whole = model(&bxdf);
        let Model::Layered(layered) = &whole else {
            panic!("{whole:?}")
        };
        assert_eq!(layered.veil(), veil);
        for mu in [0.0, 1e-3, 0.1, 0.5, 1.0] {
            let target = Target::rho_hd(mu, 0.4);
            let ((top, top_error), (base, base_error)) = (rho(layered.top(), target), rho(layered.base(), target));
            let spent = match veil {
                Veil::Albedo => top.max_element(),
                // the coat has half of Schlick's, the mirror all
                Veil::Fresnel => {
                    let scale = if bxdf.contains("reflectance = 0.5,") { 0.5 } else { 1.0 };
                    scale * (0.04 + 0.96 * (1.0 - mu).powi(5))
                }
            };
            let expected = top + (1.0 - spent).max(0.0) * base;
            let (found, error) = rho(&whole, target);
            // errors of the layer count twice, as it dims; and rounding
            let allowed = error + 2.0 * top_error + base_error + 1e-14;
            assert!(
                (found - expected).abs().cmple(allowed).all(),
                "{bxdf} {mu}: {found} {expected}"
            );
            assert!(
                found.max_element() <= 1.0 && error.max_element() <= 1e-7 + 1e-13,
                "{bxdf} {mu}: {found} {error}"
            );
        }
    }
}

/// What is sampled has the albedo that is integrated; quasi-random draws of a lobe that is a mirror count too.
#[test]
fn samples_agree_with_rules() {
    for (bxdf, _) in all() {
        let whole = model(&bxdf);
        let effort = Effort {
            tolerance: 1e-3,
            samples: Some(1 << 13),
            seed: 3,
        };
        let integrator = Integrator::new(&whole, Estimator::random(Sampling::Bxdf), effort).unwrap();
        let targets = [Target::rho_hd(0.1, 0.4), Target::rho_hd(0.7, 0.4), Target::rho_hh()];
        for (cell, target) in targets.into_iter().enumerate() {
            let drawn = integrator.estimate(target, cell as u64).unwrap();
            let (value, error) = rho(&whole, target);
            // twice the half width of 99 %, five standard deviations, so that none of 36 is beyond
            let allowed = 2.0 * drawn.error + error;
            assert!(
                (drawn.value - value).abs().cmple(allowed).all(),
                "{bxdf}: {drawn:?} {value}"
            );
        }
    }
}

/// Also from below, and at the horizon.
#[test]
fn layers_have_values_everywhere() {
    for (bxdf, _) in all() {
        let whole = model(&bxdf);
        let sampled = sampled(&whole).unwrap();
        for mu in [-1.0f64, -0.3, -1e-300, 0.0, 5e-324, 1e-160, 1e-9, 0.5, 1.0] {
            let wo = Polar::from_cos(mu.abs()).direction(0.2) * mu.signum();
            for (i, u) in [0.0, 0.3, 0.99].into_iter().enumerate() {
                let drawn = sampled.sample_f(wo, [u, 0.2 * i as f64, 0.9 - 0.9 * u]);
                assert!(
                    drawn.weight.is_finite() && drawn.weight.min_element() >= 0.0,
                    "{bxdf} {wo}: {drawn:?}"
                );
                let f = sampled.f(wo, drawn.wi);
                assert!(f.is_finite() && f.min_element() >= 0.0, "{bxdf} {wo}: {f}");
            }
        }
    }
}

#[test]
fn what_is_no_layer_is_refused() {
    let [diffuse, coat] = [DIFFUSE, COAT].map(model);
    let glass = model("{ type = \"fresnel-specular\", eta_b = 1.5 }");
    assert!(Layered::new(diffuse.clone(), coat.clone(), Veil::Fresnel).is_err());
    assert!(Layered::new(glass.clone(), coat, Veil::Albedo).is_err());
    assert!(Layered::new(diffuse, glass, Veil::Albedo).is_ok());
    for (bxdf, told) in [
        (layers(DIFFUSE, PLASTIC, "fresnel"), "goes with a microfacet"),
        (
            layers("{ type = \"fresnel-specular\", eta_b = 1.5 }", DIFFUSE, "albedo"),
            "lets nothing through",
        ),
        (layers(COAT, DIFFUSE, "lace"), "veil is one of \"albedo\", \"fresnel\""),
        (
            "{ type = \"layered\", top = { type = \"lambertian\", reflectance = 1.0 } }".into(),
            "base",
        ),
    ] {
        let text = format!("[[material]]\nname = \"m\"\nbxdf = {bxdf}\n");
        let error = Scene::parse(&text, "s.toml").unwrap_err().to_string();
        assert!(error.contains(told) && error.contains("s.toml"), "{error}");
    }
}

/// Each lobe has its own term and table, in the split-sum sheet where it has Schlick's Fresnel term, and those below know what
/// lies above them.
#[test]
fn plans_have_the_lobes_and_what_lies_above_them() {
    let bxdf = layers(COAT, &layers(SHEEN, PLASTIC, "albedo"), "fresnel");
    let scene = scene(&bxdf);
    let effects: Vec<&str> = scene.materials[0].calls.iter().map(|call| call.effect.name()).collect();
    assert_eq!(effects, ["dielectric", "diffuse", "sheen", "clearcoat"]);
    let plan = Plan::new(&scene, &Request::default()).unwrap();
    let terms = &plan.materials[0].terms;
    let above: Vec<Vec<(Vec<usize>, Veil)>> = terms
        .iter()
        .map(|term| {
            term.layers
                .iter()
                .map(|layer| (layer.lobes.clone(), layer.veil))
                .collect()
        })
        .collect();
    let coat = (vec![0], Veil::Fresnel);
    assert_eq!(above, [vec![], vec![coat.clone()], vec![coat, (vec![1], Veil::Albedo)]]);
    let tables: Vec<&str> = terms
        .iter()
        .map(|term| match &term.albedo {
            Source::Table { id, .. } => id.as_str(),
            Source::ClosedForm(_) => "",
        })
        .collect();
    assert_eq!(tables[0], "ggx-smith-correlated.split-sum.rho_hd");
    assert_eq!(tables[0], tables[2]);
    assert_ne!(tables[0], tables[1]);
    assert!(terms[2].base.is_some() && terms[0].base.is_none());
}

#[test]
fn manifests_state_the_factors() {
    let directory = tempfile::tempdir().unwrap();
    let here = directory.path();
    let text = format!(
        "[[material]]\nname = \"m\"\nbxdf = {}\n",
        layers(SHEEN, DIFFUSE, "albedo")
    );
    fs::write(here.join("s.toml"), text).unwrap();
    let output = Command::new(env!("CARGO_BIN_EXE_furnace"))
        .args(["bake", "s.toml", "--resolution", "8", "--out", "out"])
        .current_dir(here)
        .output()
        .unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let manifest = fs::read_to_string(here.join("out/manifest.json")).unwrap();
    let manifest: serde_json::Value = serde_json::from_str(&manifest).unwrap();
    let lobes = &manifest["materials"][0]["lobes"];
    assert_eq!(lobes[0].get("under"), None);
    assert_eq!(lobes[1]["under"][0]["lobes"], serde_json::json!([0]));
    assert_eq!(
        lobes[1]["under"][0]["factor"],
        "max(0, 1 - max over channels of scale rho_hd(mu))"
    );
}
