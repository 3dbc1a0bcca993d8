//! Random points: every sample says as much as any other, and their spread is the error.

use super::draw::{batch, point_set};
use super::unseen::{of_nothing, peak};
use super::{CONFIDENCE, Finding, Samples, Trial, known, nothing, too_few, too_many};
use crate::bxdf::Bxdf;
use crate::integrate::IntegrateError;
use crate::numerics::moments::Moments;
use crate::numerics::points::BATCH;
use glam::DVec3;
use rayon::prelude::*;

/// Samples after which the variance is first looked at.
const PILOT: u64 = BATCH;

/// Batches whose moments are held at once.
const ROUND: usize = 1 << 12;

/// With a tolerance the count is fixed by a first batch: n = (t s/tolerance)^2 with a margin for the error of s itself, and
/// raised while the interval is still too wide.
pub(super) fn find<B: Bxdf + ?Sized>(bxdf: &B, trial: Trial) -> Result<Finding, IntegrateError> {
    let mut moments = Moments::default();
    moments.expect(peak(bxdf, &trial));
    match trial.samples {
        Samples::Fixed(count) => moments = extend(bxdf, &trial, moments, count),
        Samples::UpTo { tolerance, limit } => {
            moments = extend(bxdf, &trial, moments, PILOT.min(limit));
            loop {
                let reached = half_width(bxdf, &trial, &moments).max_element();
                if reached <= tolerance && (known(&moments) || nothing(&moments)) {
                    break;
                }
                // a margin of 5 % covers the spread of s for any but the first batches
                let needed = (1.05 * moments.count_for(tolerance, CONFIDENCE)).max(2.0 * moments.count as f64);
                if needed > limit as f64 {
                    return Err(too_many(&trial, &moments, needed, tolerance, limit));
                }
                moments = extend(bxdf, &trial, moments, (needed as u64).next_multiple_of(BATCH));
            }
        }
    }
    if !known(&moments) {
        return Err(too_few(&trial, &moments));
    }
    Ok(Finding {
        value: moments.mean(),
        half_width: half_width(bxdf, &trial, &moments),
        evaluations: moments.count,
    })
}

fn half_width<B: Bxdf + ?Sized>(bxdf: &B, trial: &Trial, moments: &Moments) -> DVec3 {
    if nothing(moments) {
        return of_nothing(bxdf, trial, moments);
    }
    moments.half_width(CONFIDENCE)
}

/// Draws samples until there are `upto`, continuing whole batches.
fn extend<B: Bxdf + ?Sized>(bxdf: &B, trial: &Trial, mut moments: Moments, upto: u64) -> Moments {
    let set = point_set(bxdf, trial, 0, upto);
    let first = moments.count.div_ceil(BATCH);
    let last = upto.div_ceil(BATCH).max(first);
    for from in (first..last).step_by(ROUND) {
        let batches: Vec<Moments> = (from..last.min(from + ROUND as u64))
            .into_par_iter()
            .map(|index| batch(bxdf, trial, &set, index * BATCH..upto.min((index + 1) * BATCH)))
            .collect();
        moments = batches.into_iter().fold(moments, Moments::merge);
    }
    moments
}
