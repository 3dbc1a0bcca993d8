//! Charlie and its maskings: against independent sums, between tolerances, against samples, and where they gain energy.

mod common;

use common::cases::{Dice, dielectric, sheen};
use glam::DVec3;
use rayon::prelude::*;
use std::f64::consts::{PI, TAU};
use std::fs;
use std::process::Command;
use whitefurnace::bxdf::{Bxdf, FresnelBlend, Microfacet, Model, Sampling};
use whitefurnace::distribution::Family;
use whitefurnace::estimate::{Effort, Estimator};
use whitefurnace::fresnel::Fresnel;
use whitefurnace::geometry::Polar;
use whitefurnace::integrate::deterministic::quadrature;
use whitefurnace::integrate::{Integrator, Target};
use whitefurnace::masking::Masking;
use whitefurnace::parameter::CHARLIE_ALPHA;
use whitefurnace::scene::Scene;
use whitefurnace::spectrum::Spectrum;

const MASKINGS: [Masking; 2] = [Masking::Neubelt, Masking::Charlie];

fn rho_hd(lobe: &Microfacet, mu: f64, tolerance: f64) -> (f64, f64) {
    let model = Model::Microfacet(*lobe);
    let found = quadrature(&model, Target::rho_hd(mu, 0.0), tolerance).unwrap();
    (found.value.x, found.error.x)
}

/// Published implementations take alpha = roughness^2: at a roughness of 0.1 that is 0.01, and Ashikhmin's visibility reflects 1.74
/// of what comes from mu = 0.05. Taken as alpha itself, 0.1 conserves energy there.
#[test]
fn ashikhmins_visibility_exceeds_one() {
    for (alpha, expected) in [(0.01, 1.74116385), (0.1, 0.98275692)] {
        let (value, error) = rho_hd(&sheen(alpha, Masking::Neubelt, Fresnel::None), 0.05, 1e-9);
        // the expected ones have nine digits
        assert!((value - expected).abs() < error + 1e-8, "{alpha}: {value}");
    }
}

/// The midpoint rule over the hemisphere of wi, in the square root of n.i, of f itself.
fn brute_force(lobe: &Microfacet, mu: f64, [heights, azimuths]: [usize; 2]) -> f64 {
    let wo = Polar::from_cos(mu).direction(0.3);
    let rows = (0..heights).into_par_iter().map(|row| {
        let root = (row as f64 + 0.5) / heights as f64;
        let around = (0..azimuths).map(|column| {
            let phi = 0.3 + PI * (column as f64 + 0.5) / azimuths as f64;
            lobe.f(wo, Polar::from_cos(root * root).direction(phi)).x
        });
        around.sum::<f64>() / azimuths as f64 * TAU * root * root * 2.0 * root / heights as f64
    });
    rows.sum()
}

#[test]
fn rules_agree_with_sums_over_the_hemisphere() {
    for masking in MASKINGS {
        for (alpha, fresnel) in [
            (1.0, Fresnel::None),
            (0.25, dielectric(1.5)),
            (0.25, dielectric(0.66)),
            (0.01, Fresnel::None),
        ] {
            let lobe = sheen(alpha, masking, fresnel);
            for mu in [0.02, 0.1, 0.5, 0.9, 1.0] {
                let (value, error) = rho_hd(&lobe, mu, 1e-8);
                let [coarse, fine] = [[300, 200], [600, 400]].map(|size| brute_force(&lobe, mu, size));
                // the midpoint rule is of second order: halving the steps leaves a third of the change, and half a power
                // less at edges of F
                let allowed = error + (fine - coarse).abs() + 1e-9;
                assert!(
                    (value - fine).abs() <= allowed,
                    "{masking:?} {alpha} {mu}: {value} {fine}"
                );
                assert!(
                    (fine - coarse).abs() < 1e-3 * (1.0 + value),
                    "{masking:?} {alpha} {mu}: {coarse} {fine}"
                );
            }
        }
    }
}

fn random(case: u64) -> (Microfacet, f64) {
    let mut dice = Dice::new(41, case);
    let alpha = match dice.pick(&[0, 0, 0, 1]) {
        0 => dice.log(-3.0, 0.0).clamp(CHARLIE_ALPHA.min, CHARLIE_ALPHA.max),
        _ => dice.pick(&[CHARLIE_ALPHA.min, CHARLIE_ALPHA.max]),
    };
    let masking = dice.pick(&MASKINGS);
    let fresnel = dice.fresnel();
    let mu = dice.mu();
    (sheen(alpha, masking, fresnel), mu)
}

/// Over the legal range, mu = 0 and 1e-300 included: what two tolerances find differs by no more than both state, and both keep
/// what was asked for.
#[test]
fn stated_errors_hold() {
    (0..300).into_par_iter().for_each(|case| {
        let (lobe, mu) = random(case);
        let model = Model::Microfacet(lobe);
        let at = |tolerance: f64| {
            let found = quadrature(&model, Target::rho_hd(mu, 0.0), tolerance);
            found.unwrap_or_else(|error| panic!("{case} {tolerance}: {error}: {lobe:?} {mu}"))
        };
        let fine = at(1e-9);
        for tolerance in [1e-2, 1e-4, 1e-6] {
            let coarse = at(tolerance);
            let off = (coarse.value - fine.value).abs();
            assert!(
                off.cmple(coarse.error + fine.error).all(),
                "{case} {tolerance}: {off} {coarse:?} {lobe:?} {mu}"
            );
            // rounding on top
            assert!(
                coarse.error.max_element() <= tolerance + 2e-14,
                "{case} {tolerance}: {coarse:?}"
            );
        }
    });
}

#[test]
fn means_are_those_of_all_directions() {
    for masking in MASKINGS {
        for alpha in [1e-3, 0.1, 1.0] {
            let lobe = sheen(alpha, masking, Fresnel::None);
            let model = Model::Microfacet(lobe);
            let mean = quadrature(&model, Target::rho_hh(), 1e-6).unwrap();
            // 2 int mu rho dmu in the square root of mu, by midpoints
            let count = 400;
            let sum: f64 = (0..count)
                .into_par_iter()
                .map(|k| {
                    let root = (f64::from(k) + 0.5) / f64::from(count);
                    4.0 * root.powi(3) * rho_hd(&lobe, root * root, 1e-7).0 / f64::from(count)
                })
                .sum();
            // the rule errs by step^2/24 times the slopes at the ends and their differences, some tens for the narrowest lobe
            assert!(
                (mean.value.x - sum).abs() < 2e-5,
                "{masking:?} {alpha}: {} {sum}",
                mean.value.x
            );
        }
    }
}

/// Every sampling that is supported has the same mean, by random and by quasi-random numbers.
#[test]
fn samples_agree_with_rules() {
    for masking in MASKINGS {
        for alpha in [0.01, 0.3, 1.0] {
            let lobe = sheen(alpha, masking, dielectric(1.5));
            let model = Model::Microfacet(lobe);
            assert!(!lobe.supports(Sampling::Visible));
            for sampling in [Sampling::Uniform, Sampling::Cosine, Sampling::Normals, Sampling::Bxdf] {
                let effort = Effort {
                    tolerance: 1e-6,
                    samples: Some(1 << 15),
                    seed: 7,
                };
                let integrator = Integrator::new(&model, Estimator::random(sampling), effort).unwrap();
                for (cell, mu) in [0.05, 0.4, 0.95].into_iter().enumerate() {
                    let Ok(drawn) = integrator.estimate(Target::rho_hd(mu, 0.2), cell as u64) else {
                        // too few normals of a narrow lobe are seen from above
                        assert!(alpha < 0.1 && mu > 0.3, "{masking:?} {alpha} {sampling:?} {mu}");
                        continue;
                    };
                    let (value, error) = rho_hd(&lobe, mu, 1e-8);
                    // twice the half width of 99 % is five standard deviations: none of 72 is beyond
                    assert!(
                        (drawn.value.x - value).abs() <= 2.0 * drawn.error.x + error,
                        "{masking:?} {alpha} {sampling:?} {mu}: {drawn:?} {value}"
                    );
                }
            }
        }
    }
}

/// Values, densities and draws are numbers over the whole range, directions at the horizon included.
#[test]
fn everything_is_a_number() {
    let directions: Vec<DVec3> = [0.0, 5e-324, 1e-300, 1e-160, 1e-9, 1e-3, 0.5, 1.0]
        .into_iter()
        .flat_map(|mu| [0.0, 0.7, PI].map(|phi| Polar::from_cos(mu).direction(phi)))
        .collect();
    for masking in MASKINGS {
        for alpha in [CHARLIE_ALPHA.min, 0.03, CHARLIE_ALPHA.max] {
            let lobe = sheen(alpha, masking, dielectric(0.66));
            for (wo, wi) in directions
                .iter()
                .flat_map(|wo| directions.iter().map(move |wi| (*wo, *wi)))
            {
                let (f, back) = (lobe.f(wo, wi), lobe.f(wi, wo));
                assert!(
                    f.is_finite() && f.min_element() >= 0.0,
                    "{masking:?} {alpha} {wo} {wi}: {f}"
                );
                assert_eq!(f, back, "{masking:?} {alpha} {wo} {wi}");
                assert!(lobe.pdf(wo, wi).is_finite());
            }
            for (wo, sampling) in directions
                .iter()
                .flat_map(|wo| Sampling::ALL.map(|sampling| (*wo, sampling)))
            {
                for u in [[0.0; 3], [0.5, 0.25, 0.75], [1.0 - 0.5 * f64::EPSILON, 0.9, 0.0]] {
                    let drawn = lobe.sample(sampling, wo, u);
                    let is_number = drawn.wi.is_finite() && drawn.weight.is_finite() && drawn.pdf.is_finite();
                    assert!(is_number, "{masking:?} {alpha} {sampling:?} {wo}: {drawn:?}");
                }
            }
        }
    }
}

#[test]
fn maskings_of_others_are_refused() {
    let [grey, charlie] = [Family::Ggx, Family::Charlie].map(|family| family.with(0.5).unwrap());
    let one = Spectrum::grey(1.0);
    for masking in [
        Masking::None,
        Masking::VGroove,
        Masking::Smith,
        Masking::SmithCorrelated,
    ] {
        let error = Microfacet::new(one, charlie, masking, Fresnel::None)
            .unwrap_err()
            .to_string();
        assert!(error.contains("\"charlie\""), "{error}");
    }
    for masking in MASKINGS {
        let error = Microfacet::new(one, grey, masking, Fresnel::None)
            .unwrap_err()
            .to_string();
        assert!(error.contains("\"ggx\""), "{error}");
    }
    assert!(FresnelBlend::new(one, one, charlie).is_err());
    let scene = |bxdf: &str| Scene::parse(&format!("[[material]]\nname = \"m\"\nbxdf = {bxdf}\n"), "s.toml");
    for (bxdf, place) in [
        (
            "{ type = \"microfacet\", distribution = { type = \"charlie\", alpha = 0.1 }, masking = \"smith\", fresnel = \"none\" }",
            "masking = \"smith\"",
        ),
        (
            "{ type = \"microfacet\", distribution = { type = \"charlie\", alpha = 1e-4 }, masking = \"neubelt\", fresnel = \"none\" }",
            "alpha lies in [0.001, 1]",
        ),
        (
            "{ type = \"fresnel-blend\", rd = 0.5, rs = 0.5, distribution = { type = \"charlie\", alpha = 0.1 } }",
            "does not go with the rest",
        ),
    ] {
        let told = scene(bxdf).unwrap_err().to_string();
        assert!(told.starts_with("s.toml: line 3") || told.contains("s.toml"), "{told}");
        assert!(told.contains(place), "{told}");
    }
    // the name that the source has for the same
    let [one, other] = ["neubelt", "ashikhmin"].map(|masking| {
        let bxdf = format!(
            "{{ type = \"microfacet\", distribution = {{ type = \"charlie\", alpha = 0.1 }}, masking = \"{masking}\", fresnel = \"none\" }}"
        );
        scene(&bxdf).unwrap().materials.remove(0).model
    });
    assert_eq!(one, other);
}

/// The gain is a finding of `verify`, with its direction, and of `bake`, and no failure of either; nothing is cut off.
#[test]
fn gains_are_reported_and_not_clamped() {
    let directory = tempfile::tempdir().unwrap();
    let scene = directory.path().join("s.toml");
    let text = "[[material]]\nname = \"velvet\"\nbxdf = { type = \"microfacet\", distribution = { type = \"charlie\", alpha = 0.01 }, \
                masking = \"neubelt\", fresnel = \"none\" }\n";
    fs::write(&scene, text).unwrap();
    let furnace = |arguments: &[&str]| {
        let output = Command::new(env!("CARGO_BIN_EXE_furnace"))
            .args(arguments)
            .arg(&scene)
            .current_dir(directory.path())
            .output()
            .unwrap();
        let told = String::from_utf8_lossy(&output.stdout).into_owned() + &String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success(), "{arguments:?}: {told}");
        told
    };
    let verified = furnace(&["verify"]);
    for part in [
        "max rho = 4.019256",
        "finding",
        "theta 90 phi 0",
        "exceeds 1 beyond 84.7",
    ] {
        assert!(verified.contains(part), "{part}: {verified}");
    }
    let baked = furnace(&["bake", "--out", "out"]);
    assert!(baked.contains("finding: velvet.rho_hd exceeds 1 by 3.0"), "{baked}");
    assert!(baked.contains("4.01926"), "{baked}");
}
