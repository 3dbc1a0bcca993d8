//! Monte Carlo integration: the mean of f |cos theta_i|/pdf over drawn directions is rho_hd.
//!
//! Samples come in batches, each from a random stream that is a function of seed, cell and batch alone, and batches are
//! merged in order: the result is the same to the bit on any number of threads.

use super::{ErrorKind, Estimate, Estimator, IntegrateError};
use crate::bxdf::{Bxdf, Sampling, cosine_hemisphere};
use crate::geometry::Polar;
use crate::numerics::moments::Moments;
use crate::numerics::stream::{Stream, StreamId};
use glam::DVec3;
use rayon::prelude::*;

/// Samples per random stream.
const BATCH: u64 = 1 << 14;

/// Samples after which the variance is first looked at.
const PILOT: u64 = BATCH;

/// Contributing samples below which no spread is stated.
const FEWEST_HITS: u64 = 100;

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

/// Estimates rho_hd or rho_hh of `bxdf`; `cell` and `seed` name the random streams.
///
/// With a tolerance the count is fixed by a first batch: n = (t s/tolerance)^2 with a margin for the error of s itself, and
/// raised while the interval is still too wide.
///
/// # Errors
/// [`IntegrateError::TooManySamples`], [`IntegrateError::TooFewHits`], or [`IntegrateError::Unsupported`] when the model has
/// no such sampling.
pub fn estimate<B: Bxdf + ?Sized>(
    bxdf: &B,
    sampling: Sampling,
    outgoing: Outgoing,
    samples: Samples,
    seed: u64,
    cell: u64,
) -> Result<Estimate, IntegrateError> {
    let estimator = Estimator::MonteCarlo(sampling);
    if !bxdf.supports(sampling) {
        return Err(IntegrateError::Unsupported {
            estimator,
            reason: "it has no facet normals; use mc-bxdf or auto",
        });
    }
    let draw = |moments: Moments, upto: u64| extend(bxdf, sampling, outgoing, seed, cell, moments, upto);
    let moments = match samples {
        Samples::Fixed(count) => draw(Moments::default(), count),
        Samples::UpTo { tolerance, limit } => {
            let mut moments = draw(Moments::default(), PILOT.min(limit));
            loop {
                let reached = half_width(&moments).max_element();
                if reached <= tolerance && moments.hits >= FEWEST_HITS {
                    break moments;
                }
                let n = moments.count as f64;
                let ratio = (reached / tolerance).powi(2);
                // a margin of 5 % covers the spread of s for any but the first batches
                let needed = (n * ratio * 1.05).max(2.0 * n);
                if needed > limit as f64 {
                    if moments.hits < FEWEST_HITS {
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
    if moments.hits < FEWEST_HITS && !constant(&moments) {
        return Err(too_few(estimator, &moments));
    }
    Ok(Estimate {
        value: moments.mean(),
        error: half_width(&moments),
        kind: ErrorKind::Ci99,
        estimator,
        evaluations: moments.count,
    })
}

/// Every sample contributed, however few there are.
fn constant(moments: &Moments) -> bool {
    moments.count >= 2 && moments.hits == moments.count
}

fn too_few(estimator: Estimator, moments: &Moments) -> IntegrateError {
    IntegrateError::TooFewHits {
        estimator,
        hits: moments.hits,
        samples: moments.count,
    }
}

/// The interval, and the rounding of the mean where nothing varies.
fn half_width(moments: &Moments) -> DVec3 {
    moments.half_width(CONFIDENCE) + moments.mean().abs() * (4.0 * f64::EPSILON)
}

/// Draws samples until there are `upto`, continuing whole batches.
fn extend<B: Bxdf + ?Sized>(
    bxdf: &B,
    sampling: Sampling,
    outgoing: Outgoing,
    seed: u64,
    cell: u64,
    moments: Moments,
    upto: u64,
) -> Moments {
    let first = moments.count.div_ceil(BATCH);
    let last = upto.div_ceil(BATCH).max(first);
    let batches: Vec<Moments> = (first..last)
        .into_par_iter()
        .map(|batch| {
            let mut stream = Stream::new(StreamId { seed, cell, batch });
            let mut moments = Moments::default();
            for _ in 0..BATCH.min(upto - batch * BATCH) {
                let wo = match outgoing {
                    Outgoing::Fixed(wo) => wo,
                    Outgoing::Cosine => cosine_hemisphere([stream.uniform(), stream.uniform()]),
                };
                moments.push(bxdf.sample(sampling, wo, stream.uniform3()).weight);
            }
            moments
        })
        .collect();
    batches.into_iter().fold(moments, Moments::merge)
}

/// wo at cos theta = `mu` and azimuth `phi` in radians.
pub fn outgoing(mu: f64, phi: f64) -> Outgoing {
    Outgoing::Fixed(Polar::from_cos(mu).direction(phi))
}
