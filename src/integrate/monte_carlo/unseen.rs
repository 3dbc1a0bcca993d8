//! What a sample need not have met, and what that adds to its interval.

use super::draw::{Block, dimensions};
use super::{CONFIDENCE, FEWEST_HITS, Outgoing, Trial};
use crate::bxdf::{BLOCK, Bxdf, Sampling};
use crate::geometry::Polar;
use crate::numerics::moments::Moments;
use crate::numerics::points::{BELOW_ONE, DIMENSIONS};
use crate::numerics::stream::{Stream, StreamId};
use glam::{DVec2, DVec3};
use std::f64::consts::{FRAC_1_SQRT_2, PI, TAU};

/// The part of the half-width that the spread of sets of points does not show.
///
/// A region of the cube of volume ln(1/(1 - confidence))/N need not hold one of N points, whether they keep clear of each
/// other or not. Three things may hide there:
///
/// - A jump, where samples below the horizon or of another lobe are lost. Points that keep clear of each other meet either
///   side of it equally often in every set, but for a point that some set has and the others have not: when none has met it,
///   their spread is nought, and the mean is off by the largest weight times that volume. Dips of weights that are much alike
///   elsewhere are of this kind; elongated narrow lobes have such layers of normals across wo at grazing angles. Samplings
///   that know nothing of the lobe have weights that are continuous and large at few places: there a dip is worth the mean.
/// - A peak. It changes the mean by the largest weight, seen or expected, times that volume. The more samples are about as
///   large, the better is the peak known, so beyond [`FEWEST_HITS`] of them the term falls in proportion.
/// - An end of a coordinate, where normals are steep and directions grazing and weights may differ from all others, being
///   lost for instance. Weights are compared there, shell by shell, with those at the edge of the region.
pub(super) fn unseen<B: Bxdf + ?Sized>(bxdf: &B, trial: &Trial, all: &Moments, spent: &mut u64) -> DVec3 {
    let n = all.count as f64;
    let volume = -libm::log(1.0 - CONFIDENCE) / n;
    let hits = n * all.largest_share();
    let peak = DVec3::select(
        all.largest().cmpgt(DVec3::ZERO),
        all.largest() * (volume * (FEWEST_HITS / hits).min(DVec3::ONE)),
        DVec3::ZERO,
    );
    // nothing to miss where nothing is drawn
    let jump = if dimensions(bxdf, trial) == 0 {
        DVec3::ZERO
    } else {
        let height = match trial.sampling {
            Sampling::Uniform | Sampling::Cosine => all.mean().abs(),
            Sampling::Normals | Sampling::Visible | Sampling::Bxdf => all.largest(),
        };
        height * volume.min(1.0)
    };
    peak.max(jump) + ends(bxdf, trial, volume, spent)
}

/// The half-width when every weight was 0: what none of the samples has met may reflect all that it gets.
pub(super) fn of_nothing<B: Bxdf + ?Sized>(bxdf: &B, trial: &Trial, all: &Moments) -> DVec3 {
    if dimensions(bxdf, trial) == 0 {
        return DVec3::ZERO;
    }
    DVec3::ONE * (-libm::log(1.0 - CONFIDENCE) / all.count as f64).min(1.0)
}

/// Shells towards the end of a coordinate, each a [`SHRINK`]th of the one before: the last ends at 1e-14 of the first.
const SHELLS: usize = 16;
const SHRINK: f64 = 8.0;

/// Places at which every shell is looked at.
const PLACES: usize = BLOCK / SHELLS;

/// Bound of what the ends of the coordinates, each of the given volume, add beyond the weights at their edge.
fn ends<B: Bxdf + ?Sized>(bxdf: &B, trial: &Trial, volume: f64, spent: &mut u64) -> DVec3 {
    let volume = volume.min(0.5);
    let dimensions = dimensions(bxdf, trial);
    let mut stream = Stream::new(StreamId {
        seed: trial.seed,
        cell: trial.cell,
        batch: u64::MAX,
    });
    let mut block = Block::new(trial.outgoing);
    let mut sum = DVec3::ZERO;
    for dimension in 0..dimensions {
        for top in [false, true] {
            let mut points = [[0.5; BLOCK]; DIMENSIONS];
            for place in 0..PLACES {
                let at: [f64; DIMENSIONS] = std::array::from_fn(|_| stream.uniform());
                for shell in 0..SHELLS {
                    let index = place * SHELLS + shell;
                    for (points, at) in points.iter_mut().zip(at) {
                        points[index] = at;
                    }
                    let distance = volume * SHRINK.powi(-(shell as i32));
                    points[dimension][index] = if top { (1.0 - distance).min(BELOW_ONE) } else { distance };
                }
            }
            block.weigh(bxdf, trial, &points, BLOCK);
            *spent += BLOCK as u64;
            for shell in 1..SHELLS {
                let share = volume * (SHRINK.powi(1 - shell as i32) - SHRINK.powi(-(shell as i32)));
                let departure = (0..PLACES).map(|place| {
                    let edge = block.weight(bxdf, place * SHELLS);
                    (block.weight(bxdf, place * SHELLS + shell) - edge).abs()
                });
                sum += share * departure.fold(DVec3::ZERO, DVec3::max);
            }
        }
    }
    sum
}

/// A weight about as large as the largest, for samplings that know nothing of the lobe.
///
/// They may miss a narrow lobe altogether, and would then state a spread without it. The lobe is looked for in the mirror
/// direction, and up the plane of incidence in octaves of the cosine, where it lies at grazing angles. Where wo is drawn,
/// its median stands for it: the largest weight of all is at the horizon, and too rare to count.
pub(super) fn peak<B: Bxdf + ?Sized>(bxdf: &B, trial: &Trial) -> DVec3 {
    let wo = match trial.outgoing {
        Outgoing::Fixed(wo) => wo,
        Outgoing::Cosine => Polar::from_cos(FRAC_1_SQRT_2).direction(0.0),
    };
    let radius = libm::hypot(wo.x, wo.y);
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
