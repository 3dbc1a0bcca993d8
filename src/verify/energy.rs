//! No direction gets more light back than it sent: rho_hd(wo) <= 1, both sides together.

use super::search::{Top, graded, largest};
use super::statistics::{Spread, channels_p};
use super::{Outcome, Place, Settings, Source, Stated, Statistic, Test};
use crate::bxdf::{Bxdf, other_hemisphere};
use crate::geometry::Polar;
use crate::integrate::IntegrateError;
use glam::DVec3;
use std::f64::consts::PI;
use std::sync::Mutex;

/// Azimuths at which anisotropic models are looked at before the climb. f(wo, wi) = f(-wo, -wi) of the tangent plane is not
/// assumed of a model, but its albedo at phi and phi + pi is that of one material turned round.
const AZIMUTHS: usize = 8;

/// Azimuths of a search.
fn azimuths(isotropic: bool) -> Vec<f64> {
    let count = if isotropic { 1 } else { AZIMUTHS };
    (0..count).map(|k| PI * k as f64 / AZIMUTHS as f64).collect()
}

/// Searches the stated albedo for its maximum, mu = 0 included, at all scales down to 1e-9 for isotropic models.
///
/// The albedo counts less its error: what exceeds 1 then does so for certain.
pub fn energy(stated: &Stated<'_>, isotropic: bool) -> Outcome {
    let mus = if isotropic {
        graded(1e-9, 4, 24)
    } else {
        graded(1e-4, 2, 8)
    };
    let refused: Mutex<Option<(f64, IntegrateError)>> = Mutex::new(None);
    let least = |mu: f64, phi: f64| match stated(mu, phi) {
        Ok(estimate) => (estimate.value - estimate.error).max_element(),
        Err(IntegrateError::Diverges(_)) => f64::INFINITY,
        Err(error) => {
            if let Ok(mut refused) = refused.lock()
                && refused.as_ref().is_none_or(|(at, _)| *at > mu)
            {
                *refused = Some((mu, error));
            }
            f64::NEG_INFINITY
        }
    };
    let phis = azimuths(isotropic);
    let top = largest(&mus, &phis, least);
    let known = refused.lock().ok().and_then(|refused| refused.clone());
    let refused = known.map(|(mu, error)| format!("not known at mu = {mu:.2e}: {error}"));
    if top.value == f64::NEG_INFINITY {
        return Outcome::skipped(Test::Energy, refused.unwrap_or_default());
    }
    let value = stated(top.mu, top.phi).map_or(f64::INFINITY, |estimate| estimate.value.max_element());
    let place = Place::direction(Polar::from_cos(top.mu).direction(top.phi));
    let excess = (top.value > 1.0).then(|| {
        let from = beginning(&mus, top, &least);
        format!("exceeds 1 beyond {from:.4} deg, by {} at most", amount(value - 1.0))
    });
    Outcome::certain(Test::Energy, Statistic::new("max rho", value), top.value <= 1.0)
        .at(place)
        .noted(excess.or(refused))
}

fn amount(excess: f64) -> String {
    if excess.is_infinite() {
        "any amount".into()
    } else {
        format!("{excess:.3e}")
    }
}

/// Angle in degrees at which the excess around the top begins, seen from the normal.
fn beginning(mus: &[f64], top: Top, least: &impl Fn(f64, f64) -> f64) -> f64 {
    let above = mus
        .iter()
        .filter(|mu| **mu > top.mu)
        .find(|mu| least(**mu, top.phi) <= 1.0);
    let (mut exceeds, mut holds) = (top.mu, above.copied().unwrap_or(1.0));
    if least(holds, top.phi) > 1.0 {
        return 0.0;
    }
    for _ in 0..30 {
        let middle = 0.5 * (exceeds + holds);
        if least(middle, top.phi) > 1.0 {
            exceeds = middle;
        } else {
            holds = middle;
        }
    }
    exceeds.acos().to_degrees()
}

/// The same where the albedo is only known from samples, from above or `below`.
///
/// The maximum is searched for with the same random numbers at every direction, which makes their mean a smooth function;
/// fresh ones then decide, in a one-sided test, whether it exceeds 1: where to look does not depend on them.
pub fn sampled_energy(bxdf: &dyn Bxdf, below: bool, isotropic: bool, settings: &Settings, source: Source) -> Outcome {
    let test = if below { Test::EnergyBelow } else { Test::Energy };
    let source = source.part(test.name());
    let direction = |mu: f64, phi: f64| {
        let above = Polar::from_cos(mu).direction(phi);
        if below { other_hemisphere(above) } else { above }
    };
    let search = (settings.samples / 64).max(256);
    let mean = |mu: f64, phi: f64| {
        let mut stream = source.stream(0);
        let wo = direction(mu, phi);
        let sum: DVec3 = (0..search).map(|_| bxdf.sample_f(wo, stream.uniform3()).weight).sum();
        sum.max_element() / search as f64
    };
    // the limit itself is no direction that a sampler must know
    let mus: Vec<f64> = graded(1e-4, 3, 12).into_iter().filter(|mu| *mu > 0.0).collect();
    let top = largest(&mus, &azimuths(isotropic), mean);
    let wo = direction(top.mu, top.phi);
    let fresh = source.part("fresh");
    let moments = fresh.mean(settings.samples, |stream| bxdf.sample_f(wo, stream.uniform3()).weight);
    let allowed = bxdf.albedo_error(top.mu) + moments.mean().abs() * ROUNDING;
    let distance = moments.mean() - DVec3::ONE - allowed;
    let p = channels_p(Spread::of(&moments), distance, bxdf.channels().count());
    let value = moments.mean().max_element();
    let excess = (value > 1.0 && p < 0.01).then(|| format!("exceeds 1 by {:.3e}", value - 1.0));
    Outcome::chance(test, Statistic::new("max rho", value), p)
        .at(Place::direction(wo))
        .noted(excess)
}

/// Relative rounding of a mean of many values.
pub(super) const ROUNDING: f64 = 1e-12;
