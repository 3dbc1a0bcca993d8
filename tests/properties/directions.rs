//! f, densities and draws of every model, at every pair of directions.

use crate::strategies::{BELOW_ONE, Subject, coupling, direction, model, pair, specular, uniform};
use crate::{check, ensure};
use glam::DVec3;
use proptest::prelude::*;
use proptest::test_runner::TestCaseError;
use whitefurnace::bxdf::{Bxdf, BxdfSample, Flags, FresnelSpecular, Model, Sampling, Transport};
use whitefurnace::integrate::sampled;
use whitefurnace::spectrum::Spectrum;

fn fine(value: f64) -> bool {
    value.is_finite() && value >= 0.0
}

fn all_fine(value: DVec3) -> bool {
    value.to_array().into_iter().all(fine)
}

/// Nothing that can be asked of a model is infinite, negative or no number, and draws are what they say.
fn is_sound(bxdf: &dyn Bxdf, (wo, wi): (DVec3, DVec3), u: [f64; 3]) -> Result<(), TestCaseError> {
    let (f, pdf) = (bxdf.f(wo, wi), bxdf.pdf(wo, wi));
    ensure!(all_fine(f) && fine(pdf), "f({wo:?}, {wi:?}) = {f:?}, pdf {pdf:e}");
    for sampling in Sampling::ALL {
        if !bxdf.supports(sampling) {
            continue;
        }
        let sample = bxdf.sample(sampling, wo, u);
        let BxdfSample { wi, pdf, weight, flags } = sample;
        ensure!(all_fine(weight) && fine(pdf), "{sampling:?} from {wo:?}: {sample:?}");
        ensure!((wi.length() - 1.0).abs() < 1e-9, "{sampling:?} from {wo:?}: {sample:?}"); // narrow lobes lose some digits
        ensure!(bxdf.flags().contains(flags), "{sampling:?} from {wo:?}: {sample:?}");
        ensure!(
            weight == DVec3::ZERO || pdf > 0.0 || wi.z.abs() <= f64::MIN_POSITIVE, // a cosine of 0 has cancelled
            "{sampling:?} from {wo:?}: a draw of no density, {sample:?}"
        );
        let is_delta = flags.contains(Flags::SPECULAR);
        if is_delta && weight != DVec3::ZERO {
            let across = (wi.z < 0.0) != (wo.z < 0.0);
            ensure!(across == flags.contains(Flags::TRANSMISSION), "{wo:?}: {sample:?}");
        }
        // densities are quotients by cosines, and subnormal ones have no digits to divide by
        let has_digits = wi.z.abs() >= f64::MIN_POSITIVE && wo.z.abs() >= f64::MIN_POSITIVE;
        if sampling == Sampling::Bxdf && !is_delta && weight != DVec3::ZERO && has_digits {
            let (again, spread) = steadiness(bxdf, wo, wi);
            ensure!(
                (again - pdf).abs() <= 4.0 * spread + 1e-11 * pdf, // some roundings of densities that are products of ten
                "from {wo:?}: drawn with {sample:?}, but pdf = {again:e} +- {spread:e}"
            );
        }
    }
    Ok(())
}

/// The density at `wi`, and how much of it roundings of `wi` and `wo` change: more than all of it within a rounding of the
/// horizon, where the lobe of a direction that is drawn may end.
fn steadiness(bxdf: &dyn Bxdf, wo: DVec3, wi: DVec3) -> (f64, f64) {
    let pdf = bxdf.pdf(wo, wi);
    let mut spread: f64 = 0.0;
    for axis in DVec3::AXES {
        for step in [-4e-16, 4e-16] {
            let apart = |there: f64| (there - pdf).abs();
            spread = spread
                .max(apart(bxdf.pdf(wo, wi + step * axis)))
                .max(apart(bxdf.pdf(wo + step * axis, wi)));
        }
    }
    (pdf, spread)
}

#[test]
fn every_model_is_finite_and_draws_what_it_says() {
    let cases = (model(), pair(), [uniform(), uniform(), uniform()]);
    check(6000, &cases, |(Subject(model), directions, u)| {
        is_sound(&*bxdf(&model), directions, u)
    });
}

#[test]
fn couplings_are_finite_and_draw_what_they_say() {
    let draws = prop::collection::vec((pair(), [uniform(), uniform(), uniform()]), 40);
    check(24, &(coupling(specular()), draws), |(Subject(model), draws)| {
        let bxdf = bxdf(&model);
        draws
            .into_iter()
            .try_for_each(|(directions, u)| is_sound(&*bxdf, directions, u))
    });
}

/// The model with what it needs to be sampled.
fn bxdf(model: &Model) -> Box<dyn Bxdf + '_> {
    sampled(model).unwrap()
}

/// f(wo, wi) = f(wi, wo) to the last bit for what reflects, and for what is mirrored to the other side.
#[test]
fn exchanging_directions_changes_nothing() {
    check(6000, &(model(), pair()), |(Subject(model), (wo, wi))| {
        if refracts(&model) {
            return Ok(()); // reciprocal by the square of the indices: see tests/rough_dielectric.rs
        }
        let bxdf = bxdf(&model);
        let (there, back) = (bxdf.f(wo, wi), bxdf.f(wi, wo));
        ensure!(there == back, "{wo:?} {wi:?}: {there:?} and {back:?}");
        Ok(())
    });
}

/// Whether a rough interface is part of it.
fn refracts(model: &Model) -> bool {
    matches!(model, Model::RoughDielectric(_)) || model.parts().into_iter().any(refracts)
}

/// Light that is refracted goes the same way back: w (eta_i/eta_o)^2 is the same from both ends for radiance, and w itself for
/// importance.
#[test]
fn refraction_is_reciprocal_with_the_square_of_the_indices() {
    let index = || crate::strategies::parameter(whitefurnace::parameter::ETA);
    check(3000, &(index(), index(), direction()), |(a, b, wo)| {
        let pane_of = |a: f64, b: f64, transport| {
            let (a, b) = (a.clamp(0.01, 100.0), b.clamp(0.01, 100.0));
            FresnelSpecular::new(Spectrum::grey(1.0), Spectrum::grey(1.0), a, b, transport).unwrap()
        };
        let pane = |transport| FresnelSpecular::new(Spectrum::grey(1.0), Spectrum::grey(1.0), a, b, transport).unwrap();
        let there = pane(Transport::Importance).sample_f(wo, [0.999_999, 0.5, 0.5]);
        if !there.flags.contains(Flags::TRANSMISSION) {
            return Ok(());
        }
        let radiance = pane(Transport::Radiance).sample_f(wo, [0.999_999, 0.5, 0.5]);
        let (eta_o, eta_i) = if wo.z < 0.0 { (b, a) } else { (a, b) };
        let scale = (eta_o / eta_i).powi(2);
        ensure!(
            (radiance.weight.x / there.weight.x / scale - 1.0).abs() < 1e-14, // a few roundings
            "{radiance:?} {there:?}"
        );
        // 1 - F is the probability of going through; its condition is that of the refracted cosine, which hangs on the
        // direction and on the quotient of the indices
        let through = |a: f64, w: DVec3| {
            let drawn = pane_of(a, b, Transport::Importance).sample_f(w, [BELOW_ONE, 0.5, 0.5]);
            if drawn.flags.contains(Flags::TRANSMISSION) {
                drawn.pdf
            } else {
                0.0
            }
        };
        let back = through(a, there.wi);
        let mut spread = 0f64;
        for step in [-4e-16, 4e-16] {
            for axis in DVec3::AXES {
                spread = spread.max((through(a, there.wi + step * axis) - back).abs());
            }
            // of indices at the ends of their range one of the two stays where it is
            spread = spread.max((through(a * (1.0 + step), there.wi) - back).abs());
        }
        ensure!(
            (back - there.pdf).abs() <= 4.0 * spread + 1e-14,
            "eta {a} {b}, {wo:?}: {} there, {back} back, +- {spread:e}",
            there.pdf
        );
        Ok(())
    });
}
