//! Deterministic integration of lobes that have no integrator of their own: Smith masking, anisotropy, the coat of
//! FresnelBlend. Stated errors hold over the whole legal range, and the tolerance is met.

mod common;

use common::cases::{Dice, ashikhmin_shirley};
use rayon::prelude::*;
use std::f64::consts::TAU;
use whitefurnace::bxdf::{FresnelBlend, Microfacet, Model};
use whitefurnace::distribution::Distribution;
use whitefurnace::integrate::deterministic::quadrature;
use whitefurnace::integrate::{IntegrateError, Target};
use whitefurnace::masking::Masking;
use whitefurnace::spectrum::Spectrum;

/// A random lobe that takes the general route.
fn random_model(dice: &mut Dice) -> Model {
    match dice.pick(&[0, 0, 0, 1, 1, 2, 3]) {
        0 => Model::Microfacet(dice.smith()),
        1 => {
            let distribution = anisotropic(dice);
            let masking = dice.pick(&[Masking::VGroove, Masking::VGroove, Masking::None]);
            let fresnel = dice.fresnel();
            Model::Microfacet(Microfacet::new(Spectrum::grey(1.0), distribution, masking, fresnel).unwrap())
        }
        2 => {
            let distribution = anisotropic(dice);
            blend(dice, distribution)
        }
        _ => {
            let distribution = dice.distribution().into();
            blend(dice, distribution)
        }
    }
}

fn anisotropic(dice: &mut Dice) -> Distribution {
    match dice.pick(&[0, 1]) {
        0 => dice.slopes(),
        _ => {
            let mut exponent = || dice.log(-2.0, 8.0).min(1e8);
            let (x, y) = (exponent(), exponent());
            ashikhmin_shirley(x, y)
        }
    }
}

fn blend(dice: &mut Dice, distribution: Distribution) -> Model {
    let (rd, rs) = (dice.uniform(), dice.uniform());
    Model::FresnelBlend(FresnelBlend::new(Spectrum::grey(rd), Spectrum::grey(rs), distribution).unwrap())
}

/// |value - reference| <= stated error + error of the reference, for every legal parameter.
#[test]
fn stated_errors_hold_over_the_whole_legal_range() {
    const CASES: u64 = 2000;
    let found: Vec<String> = (0..CASES)
        .into_par_iter()
        .map(|case| {
            let mut dice = Dice::new(7, case);
            let model = random_model(&mut dice);
            let target = Target::rho_hd(dice.mu(), TAU * dice.uniform());
            let mut found = Vec::new();
            let what = |tolerance: f64| format!("case {case}: {target:?} of {model:?} at {tolerance:e}");
            let mu = target.outgoing.unwrap().mu;
            let truth = match quadrature(&model, target, 1e-9) {
                Ok(truth) => truth,
                Err(IntegrateError::Diverges(_)) if mu < 1e-100 => return found,
                Err(error) => {
                    found.push(format!("{}: {error}", what(1e-9)));
                    return found;
                }
            };
            for tolerance in [1e-3, 1e-6] {
                match quadrature(&model, target, tolerance) {
                    Ok(estimate) => {
                        let difference = (estimate.value - truth.value).abs();
                        if difference.cmpgt(estimate.error + truth.error).any() {
                            found.push(format!("{}: {estimate:?}, but {truth:?}", what(tolerance)));
                        }
                        // without masking values grow like 1/mu, and rounding with them
                        let rounding = 4e-13 / mu;
                        let error = estimate.error.max_element();
                        if error.is_nan() || error > tolerance + rounding || !estimate.value.is_finite() {
                            found.push(format!("{}: {estimate:?} misses the tolerance", what(tolerance)));
                        }
                    }
                    Err(error) => found.push(format!("{}: {error}", what(tolerance))),
                }
            }
            found
        })
        .collect::<Vec<_>>()
        .concat();
    assert!(found.is_empty(), "{} of {CASES}:\n{}", found.len(), found.join("\n"));
}
