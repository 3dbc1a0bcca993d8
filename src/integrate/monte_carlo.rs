//! Monte Carlo integration: the mean of f |cos theta_i|/pdf over drawn directions is rho_hd.
//!
//! Draws come in batches, each from a random stream that is a function of seed, cell, set of points and batch alone, and
//! batches are merged in order: the result is the same to the bit on any number of threads.

mod draw;
mod independent;
mod replicated;
mod unseen;

use super::{ErrorKind, Estimate, Estimator, IntegrateError, Lobe};
use crate::bxdf::{Bxdf, Sampling};
use crate::geometry::Polar;
use crate::numerics::moments::Moments;
use crate::numerics::points::Points;
use glam::DVec3;

/// Samples that carry the mean, [`Moments::effective`], below which no spread is stated.
pub(super) const FEWEST_HITS: f64 = 100.0;

/// Probability with which the stated interval covers the value.
pub const CONFIDENCE: f64 = 0.99;

/// How many samples to draw.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Samples {
    /// This many; of points in independent sets, the next multiple of the number of sets.
    Fixed(u64),
    /// As many as the tolerance needs, at most `limit`.
    UpTo {
        /// Largest half-width of the interval.
        tolerance: f64,
        /// Most samples.
        limit: u64,
    },
}

/// Where the outgoing direction comes from.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Outgoing {
    /// The same for all samples: rho_hd.
    Fixed(DVec3),
    /// Drawn proportional to its cosine for each sample: rho_hh = int rho_hd(wo) cos theta_o/pi dwo.
    Cosine,
}

/// What to sample, how often, and with which random numbers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Trial {
    /// How directions are drawn.
    pub sampling: Sampling,
    /// The numbers that they are made of.
    pub points: Points,
    /// The side that counts.
    pub lobe: Lobe,
    /// The fixed direction, or none.
    pub outgoing: Outgoing,
    /// How many.
    pub samples: Samples,
    /// Seed of the run.
    pub seed: u64,
    /// Names the random streams together with the seed.
    pub cell: u64,
}

impl Trial {
    fn estimator(&self) -> Estimator {
        let Self { sampling, points, .. } = *self;
        Estimator::MonteCarlo { sampling, points }
    }
}

/// What the samples say.
struct Finding {
    value: DVec3,
    half_width: DVec3,
    evaluations: u64,
}

/// Estimates rho_hd or rho_hh of one side of `bxdf`.
///
/// # Errors
/// [`IntegrateError::TooManySamples`], [`IntegrateError::TooFewHits`], or [`IntegrateError::Unsupported`] when the model has
/// no such sampling.
pub fn estimate<B: Bxdf + ?Sized>(bxdf: &B, trial: Trial) -> Result<Estimate, IntegrateError> {
    let estimator = trial.estimator();
    if !bxdf.supports(trial.sampling) {
        return Err(IntegrateError::Unsupported {
            estimator,
            reason: match trial.sampling {
                Sampling::Uniform | Sampling::Cosine => "it never meets a specular direction; use mc-bxdf or auto",
                _ => "it has no facet normals; use mc-bxdf or auto",
            },
        });
    }
    let found = match trial.points {
        Points::Random => independent::find(bxdf, trial)?,
        Points::Stratified | Points::Quasi => replicated::find(bxdf, trial)?,
    };
    let interpolated = match trial.outgoing {
        Outgoing::Fixed(wo) => bxdf.albedo_error(wo.z.abs()),
        Outgoing::Cosine => bxdf.albedo_error(1.0).max(bxdf.albedo_error(0.0)),
    };
    Ok(Estimate {
        value: found.value,
        // the rounding of the mean counts where nothing varies
        error: found.half_width + found.value.abs() * (4.0 * f64::EPSILON) + interpolated,
        kind: ErrorKind::Ci99,
        estimator,
        evaluations: found.evaluations,
    })
}

/// Nothing varies, however few samples there are.
fn constant(moments: &Moments) -> bool {
    moments.count >= 2 && moments.variance() == DVec3::ZERO && (nothing(moments) || moments.mean() != DVec3::ZERO)
}

/// Nothing contributes, and nothing is expected to.
fn nothing(moments: &Moments) -> bool {
    moments.count >= 2 && moments.largest() == DVec3::ZERO
}

/// Enough samples carry the mean for their spread to be known, or there is none.
fn known(moments: &Moments) -> bool {
    moments.effective() >= FEWEST_HITS || constant(moments)
}

fn too_few(trial: &Trial, moments: &Moments) -> IntegrateError {
    IntegrateError::TooFewHits {
        estimator: trial.estimator(),
        hits: moments.effective() as u64,
        samples: moments.count,
    }
}

/// More than `limit` samples are `needed`.
fn too_many(trial: &Trial, moments: &Moments, needed: f64, tolerance: f64, limit: u64) -> IntegrateError {
    if !known(moments) {
        return too_few(trial, moments);
    }
    IntegrateError::TooManySamples {
        estimator: trial.estimator(),
        needed,
        limit: limit as f64,
        tolerance,
    }
}

/// wo at cos theta = `mu` and azimuth `phi` in radians.
pub fn outgoing(mu: f64, phi: f64) -> Outgoing {
    Outgoing::Fixed(Polar::from_cos(mu).direction(phi))
}
