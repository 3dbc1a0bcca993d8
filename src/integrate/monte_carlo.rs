//! Monte Carlo integration: the mean of f |cos theta_i|/pdf over drawn directions is rho_hd.
//!
//! Samples come in batches, each from a random stream that is a function of seed, cell and batch alone, and batches are
//! merged in order: the result is the same to the bit on any number of threads.

use super::{ErrorKind, Estimate, Estimator, IntegrateError, Lobe};
use crate::bxdf::{Bxdf, Sampling, cosine_hemisphere};
use crate::geometry::Polar;
use crate::numerics::moments::Moments;
use crate::numerics::stream::{Stream, StreamId};
use glam::{DVec2, DVec3};
use rayon::prelude::*;
use std::f64::consts::{FRAC_1_SQRT_2, PI, TAU};

/// Samples per random stream.
const BATCH: u64 = 1 << 14;

/// Samples after which the variance is first looked at.
const PILOT: u64 = BATCH;

/// Samples that carry the mean, [`Moments::effective`], below which no spread is stated.
const FEWEST_HITS: f64 = 100.0;

/// Probability with which the stated interval covers the value.
pub const CONFIDENCE: f64 = 0.99;

/// How many samples to draw.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Samples {
    /// This many.
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

/// Estimates rho_hd or rho_hh of one side of `bxdf`.
///
/// With a tolerance the count is fixed by a first batch: n = (t s/tolerance)^2 with a margin for the error of s itself, and
/// raised while the interval is still too wide.
///
/// # Errors
/// [`IntegrateError::TooManySamples`], [`IntegrateError::TooFewHits`], or [`IntegrateError::Unsupported`] when the model has
/// no such sampling.
pub fn estimate<B: Bxdf + ?Sized>(bxdf: &B, trial: Trial) -> Result<Estimate, IntegrateError> {
    let estimator = Estimator::MonteCarlo(trial.sampling);
    if !bxdf.supports(trial.sampling) {
        return Err(IntegrateError::Unsupported {
            estimator,
            reason: match trial.sampling {
                Sampling::Uniform | Sampling::Cosine => "it never meets a specular direction; use mc-bxdf or auto",
                _ => "it has no facet normals; use mc-bxdf or auto",
            },
        });
    }
    let draw = |moments: Moments, upto: u64| extend(bxdf, trial, moments, upto);
    let mut start = Moments::default();
    start.expect(peak(bxdf, trial));
    let moments = match trial.samples {
        Samples::Fixed(count) => draw(start, count),
        Samples::UpTo { tolerance, limit } => {
            let mut moments = draw(start, PILOT.min(limit));
            loop {
                let reached = half_width(&moments).max_element();
                let enough = moments.effective() >= FEWEST_HITS || nothing(&moments);
                if reached <= tolerance && enough {
                    break moments;
                }
                let n = moments.count as f64;
                // a margin of 5 % covers the spread of s for any but the first batches
                let needed = (1.05 * moments.count_for(tolerance, CONFIDENCE)).max(2.0 * n);
                if needed > limit as f64 {
                    if !enough {
                        return Err(too_few(estimator, &moments));
                    }
                    let limit = limit as f64;
                    return Err(IntegrateError::TooManySamples {
                        estimator,
                        needed,
                        limit,
                        tolerance,
                    });
                }
                moments = draw(moments, needed as u64);
            }
        }
    };
    if moments.effective() < FEWEST_HITS && !constant(&moments) {
        return Err(too_few(estimator, &moments));
    }
    let interpolated = match trial.outgoing {
        Outgoing::Fixed(wo) => bxdf.albedo_error(wo.z.abs()),
        Outgoing::Cosine => bxdf.albedo_error(1.0).max(bxdf.albedo_error(0.0)),
    };
    Ok(Estimate {
        value: moments.mean(),
        error: half_width(&moments) + interpolated,
        kind: ErrorKind::Ci99,
        estimator,
        evaluations: moments.count,
    })
}

/// Nothing varies, however few samples there are.
fn constant(moments: &Moments) -> bool {
    moments.count >= 2 && moments.variance() == DVec3::ZERO && (nothing(moments) || moments.mean() != DVec3::ZERO)
}

/// Nothing contributes, and nothing is expected to.
fn nothing(moments: &Moments) -> bool {
    moments.half_width(CONFIDENCE) == DVec3::ZERO
}

fn too_few(estimator: Estimator, moments: &Moments) -> IntegrateError {
    IntegrateError::TooFewHits {
        estimator,
        hits: moments.effective() as u64,
        samples: moments.count,
    }
}

/// The interval, and the rounding of the mean where nothing varies.
fn half_width(moments: &Moments) -> DVec3 {
    moments.half_width(CONFIDENCE) + moments.mean().abs() * (4.0 * f64::EPSILON)
}

/// Draws samples until there are `upto`, continuing whole batches.
fn extend<B: Bxdf + ?Sized>(bxdf: &B, trial: Trial, moments: Moments, upto: u64) -> Moments {
    let Trial { seed, cell, .. } = trial;
    let first = moments.count.div_ceil(BATCH);
    let last = upto.div_ceil(BATCH).max(first);
    let batches: Vec<Moments> = (first..last)
        .into_par_iter()
        .map(|batch| {
            let mut stream = Stream::new(StreamId { seed, cell, batch });
            let mut moments = Moments::default();
            for _ in 0..BATCH.min(upto - batch * BATCH) {
                let wo = match trial.outgoing {
                    Outgoing::Fixed(wo) => wo,
                    Outgoing::Cosine => cosine_hemisphere([stream.uniform(), stream.uniform()]),
                };
                let drawn = bxdf.sample(trial.sampling, wo, stream.uniform3());
                let counts = trial.lobe.holds(wo, drawn.wi);
                moments.push(if counts { drawn.weight } else { DVec3::ZERO });
            }
            moments
        })
        .collect();
    batches.into_iter().fold(moments, Moments::merge)
}

/// A weight about as large as the largest, for samplings that know nothing of the lobe.
///
/// They may miss a narrow lobe altogether, and would then state a spread without it. The lobe is looked for in the mirror
/// direction, and up the plane of incidence in octaves of the cosine, where it lies at grazing angles. Where wo is drawn,
/// its median stands for it: the largest weight of all is at the horizon, and too rare to count.
fn peak<B: Bxdf + ?Sized>(bxdf: &B, trial: Trial) -> DVec3 {
    let wo = match trial.outgoing {
        Outgoing::Fixed(wo) => wo,
        Outgoing::Cosine => Polar::from_cos(FRAC_1_SQRT_2).direction(0.0),
    };
    let radius = wo.x.hypot(wo.y);
    let away = if radius > 0.0 {
        -wo.truncate() / radius
    } else {
        DVec2::X
    };
    let octaves = (0..OCTAVES).map(|k| 0.5f64.powi(k));
    let weight = |cos: f64| {
        let up = if trial.lobe.holds(wo, DVec3::Z) { cos } else { -cos };
        let wi = (away * Polar::from_cos(cos).sin).extend(up);
        match trial.sampling {
            Sampling::Uniform => bxdf.f(wo, wi) * (TAU * cos),
            Sampling::Cosine => bxdf.f(wo, wi) * PI,
            Sampling::Normals | Sampling::Visible | Sampling::Bxdf => DVec3::ZERO,
        }
    };
    octaves.chain([wo.z.abs()]).map(weight).fold(DVec3::ZERO, DVec3::max)
}

/// Octaves of the cosine that are looked at; what lies below 1e-6 has no weight.
const OCTAVES: i32 = 20;

/// wo at cos theta = `mu` and azimuth `phi` in radians.
pub fn outgoing(mu: f64, phi: f64) -> Outgoing {
    Outgoing::Fixed(Polar::from_cos(mu).direction(phi))
}
