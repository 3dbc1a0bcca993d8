//! The white furnace: a coupling of a specular lobe with a diffuse base, under light that is 1 everywhere.

use super::energy::ROUNDING;
use super::search::{graded, largest};
use super::statistics::{Spread, channels_p, common_sign, score, smallest};
use super::{Outcome, Place, Settings, Source, Stated, Statistic, Test};
use crate::bxdf::{Bxdf, DiffuseSpecular, Flags, Model};
use crate::geometry::Polar;
use crate::integrate::{Effort, Estimator, IntegrateError, Integrator, Target};
use crate::spectrum::Spectrum;
use glam::DVec3;
use std::fmt;

/// Angles at which the furnace is looked into, in degrees.
pub const ANGLES: [f64; 6] = [0.0, 30.0, 60.0, 75.0, 85.0, 89.0];

/// Azimuth of the furnace, one that no model prefers.
const PHI: f64 = 0.3;

/// Compares the mean of f |cos theta_i|/pdf, with f and pdf themselves and not the weight that the sampler forms, with the
/// stated albedo (two-sided) and with 1 (from above), at each of [`ANGLES`].
///
/// # Errors
/// Why the albedo is not known.
pub fn white_furnace(
    bxdf: &dyn Bxdf,
    stated: &Stated<'_>,
    settings: &Settings,
    source: Source,
) -> Result<Outcome, IntegrateError> {
    let source = source.part("white furnace");
    let mut ps = Vec::new();
    let mut scores = Vec::new();
    for (index, angle) in ANGLES.into_iter().enumerate() {
        let wo = Polar::from_angle(angle.to_radians()).direction(PHI);
        let truth = stated(wo.z, PHI)?;
        let quotient = |wi: DVec3| {
            let pdf = bxdf.pdf(wo, wi);
            if pdf > 0.0 {
                bxdf.f(wo, wi) * (wi.z.abs() / pdf)
            } else {
                DVec3::ZERO
            }
        };
        let moments = source.number(index).mean(settings.samples, |stream| {
            let draw = bxdf.sample_f(wo, stream.uniform3());
            // a delta is not seen by f, and a draw without density belongs to no direction
            if draw.flags.contains(Flags::SPECULAR) || draw.pdf == 0.0 {
                draw.weight
            } else {
                quotient(draw.wi)
            }
        });
        let allowed = truth.error + bxdf.albedo_error(wo.z) + truth.value.abs() * ROUNDING;
        let spread = Spread::of(&moments);
        let channels = bxdf.channels().count();
        let difference = moments.mean() - truth.value;
        ps.push(channels_p(spread, difference.abs() - allowed, channels));
        ps.push(channels_p(spread, moments.mean() - DVec3::ONE - allowed, channels));
        let most = difference.abs().max_position();
        scores.push(score(ps[2 * index]) * difference[most].signum());
    }
    let worst = (0..scores.len()).fold(0, |a, b| if scores[b].abs() > scores[a].abs() { b } else { a });
    let p = smallest(&[smallest(&ps), common_sign(&scores)]);
    let wo = Polar::from_angle(ANGLES[worst].to_radians()).direction(PHI);
    let statistic = Statistic::of("max z", scores[worst], ANGLES.len() as u64);
    Ok(Outcome::chance(Test::WhiteFurnace, statistic, p).at(Place::direction(wo)))
}

/// What a coupling loses at kd = 1, with the ks that it has: 1 - rho_hd by angle, and the most of all.
#[derive(Debug, Clone, PartialEq)]
pub struct Loss {
    /// In percent at each of [`ANGLES`], of the channel that loses most.
    pub at: Vec<f64>,
    /// The largest, in percent, and its angle in degrees.
    pub largest: [f64; 2],
}

impl fmt::Display for Loss {
    /// `loses at kd = 1: 4.2 % at 0 deg, ...; 15.1 % at 83.1 deg at most`
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [most, angle] = self.largest;
        let at = ANGLES.iter().zip(&self.at);
        let parts: Vec<String> = at.map(|(angle, loss)| format!("{loss:.2} % at {angle}")).collect();
        write!(
            f,
            "loses at kd = 1: {} deg; {most:.2} % at {angle:.2} deg at most",
            parts.join(", ")
        )
    }
}

/// The losses of `coupled` with a white base.
///
/// # Errors
/// Why the albedo is not known.
pub fn loss(coupled: &DiffuseSpecular) -> Result<Loss, IntegrateError> {
    let white = DiffuseSpecular::new(
        coupled.specular().clone(),
        coupled.ks(),
        Spectrum::grey(1.0),
        coupled.coupling(),
    );
    let Ok(white) = white else {
        // ks comes from a coupling, and 1 is legal
        return Err(IntegrateError::Unsupported {
            estimator: Estimator::Auto,
            reason: "ks is out of its range",
        });
    };
    let model = Model::DiffuseSpecular(Box::new(white));
    let effort = Effort {
        tolerance: 1e-5,
        samples: None,
        seed: 0,
    };
    let integrator = Integrator::new(&model, Estimator::Auto, effort)?;
    let lost = |mu: f64| -> Result<f64, IntegrateError> {
        let albedo = integrator.estimate(Target::rho_hd(mu, PHI), 0)?;
        Ok(100.0 * (DVec3::ONE - albedo.value).max_element())
    };
    let at = ANGLES.map(|angle| lost(angle.to_radians().cos()));
    let at = at.into_iter().collect::<Result<Vec<f64>, _>>()?;
    let top = largest(&graded(1e-6, 3, 16), &[PHI], |mu, _| {
        lost(mu).unwrap_or(f64::NEG_INFINITY)
    });
    Ok(Loss {
        at,
        largest: [top.value, top.mu.acos().to_degrees()],
    })
}
