//! Integrals of every model: finite, to the tolerance or refused, within their errors of each other, and of energy at most 1.

use crate::strategies::{Subject, conserving, log_uniform, microfacet, model, mu, phi};
use crate::{check, ensure};
use glam::DVec3;
use proptest::prelude::*;
use whitefurnace::bxdf::{Model, Sampling};
use whitefurnace::estimate::{Effort, Estimate, Estimator, Lobe, Points};
use whitefurnace::integrate::{IntegrateError, Integrator, Target};
use whitefurnace::masking::Masking;

/// What the estimator states, or why it does not; `None` where there is no value: it grows without bound, or is sampled.
fn stated(model: &Model, target: Target, tolerance: f64) -> Result<Option<Estimate>, TestCaseError> {
    let effort = Effort {
        tolerance,
        samples: None,
        seed: 0,
    };
    let found = Integrator::new(model, Estimator::Auto, effort).and_then(|integrator| integrator.estimate(target, 0));
    let estimate = match found {
        Ok(estimate) => estimate,
        Err(IntegrateError::Diverges(_)) => return Ok(None),
        Err(IntegrateError::NotConverged(failure)) => {
            // refused, and it has to say how far it got; limits of rough interfaces are refused for their rounding alone
            ensure!(
                failure.tolerance == tolerance
                    && failure.reached > tolerance
                    && (failure.evaluations > 0 || failure.reached < 1e-7),
                "{failure:?}"
            );
            // what needs this few digits is never refused, unless it is as large as 1/mu
            ensure!(
                tolerance < 1e-4 || is_unmasked(model),
                "{target:?} to {tolerance:e}: {failure}"
            );
            return Ok(None);
        }
        Err(error) => return Err(TestCaseError::fail(error.to_string())),
    };
    let (value, error) = (estimate.value, estimate.error);
    ensure!(value.is_finite() && error.is_finite(), "{target:?}: {estimate:?}");
    ensure!(error.cmpge(DVec3::ZERO).all(), "{target:?}: {estimate:?}");
    ensure!((value + error).cmpge(DVec3::ZERO).all(), "{target:?}: {estimate:?}");
    // 2e-14 of the value, or of 1, are roundings
    let most = DVec3::splat(tolerance) + 2e-14 * value.max(DVec3::ONE);
    ensure!(error.cmple(most).all(), "{target:?} to {tolerance:e}: {estimate:?}");
    Ok(Some(estimate))
}

/// Whether rho grows like 1/mu, and its digits end above any tolerance.
fn is_unmasked(model: &Model) -> bool {
    matches!(model, Model::Microfacet(lobe) if lobe.masking == Masking::None)
        || model.parts().into_iter().any(is_unmasked)
}

/// Errors hold: values to a loose and to a fine tolerance are no further apart than they say.
#[test]
fn tolerances_are_met_and_errors_hold() {
    let tolerances = (log_uniform(-7.0, -1.0), log_uniform(-10.0, -7.0));
    check(
        250,
        &(model(), mu(), phi(), tolerances),
        |(Subject(model), mu, phi, (loose, fine))| {
            if model.is_irregular() {
                return Ok(()); // sampled; its errors are tested where those of samples are
            }
            for lobe in Lobe::ALL {
                let target = Target::rho_hd(mu, phi).of(lobe);
                let (Some(a), Some(b)) = (stated(&model, target, loose)?, stated(&model, target, fine)?) else {
                    continue;
                };
                let beyond = (a.value - b.value).abs() - a.error - b.error;
                ensure!(
                    beyond.max_element() <= 0.0,
                    "{target:?} to {loose:e} and {fine:e}: {a:?} and {b:?}"
                );
            }
            Ok(())
        },
    );
}

/// Both sides together give back no more than 1, beyond the error.
#[test]
fn models_that_conserve_energy_do() {
    check(
        300,
        &(conserving(), mu(), phi(), log_uniform(-8.0, -2.0)),
        |(Subject(model), mu, phi, tolerance)| {
            let mut excess = -DVec3::ONE;
            for lobe in Lobe::ALL {
                match stated(&model, Target::rho_hd(mu, phi).of(lobe), tolerance)? {
                    Some(side) => excess += side.value - side.error,
                    None => return Ok(()),
                }
            }
            // values of 1 that roundings put above it
            ensure!(
                excess.max_element() <= 1e-15,
                "at mu = {mu:e}, phi = {phi}: {excess:?} above 1"
            );
            Ok(())
        },
    );
}

/// Quasi-random points and quadrature agree: the intervals hold for 99 of 100, so three times their width do for all.
#[test]
fn samples_agree_with_quadrature() {
    check(200, &(microfacet(), mu(), phi()), |(microfacet, mu, phi)| {
        if microfacet.masking == Masking::None {
            return Ok(()); // weights without bound
        }
        let target = Target::rho_hd(mu, phi);
        let model = Model::Microfacet(microfacet);
        let effort = Effort {
            tolerance: 1e-3,
            samples: Some(1 << 12),
            seed: 1,
        };
        let way = Estimator::MonteCarlo {
            sampling: Sampling::Visible,
            points: Points::Quasi,
        };
        let drawn = Integrator::new(&model, way, effort).and_then(|integrator| integrator.estimate(target, 0));
        let (Ok(drawn), Some(exact)) = (drawn, stated(&model, target, 1e-7)?) else {
            return Ok(());
        };
        let beyond = (drawn.value - exact.value).abs() - 3.0 * drawn.error - exact.error;
        ensure!(beyond.max_element() <= 0.0, "{target:?}: {drawn:?} and {exact:?}");
        Ok(())
    });
}
