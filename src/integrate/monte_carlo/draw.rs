//! Draws of a set of points, block by block.

use super::{Outgoing, Trial};
use crate::bxdf::{BLOCK, Bxdf, Draws};
use crate::numerics::lanes::sin_cos_turns;
use crate::numerics::moments::Moments;
use crate::numerics::points::{DIMENSIONS, PointSet};
use crate::numerics::stream::StreamId;
use glam::DVec3;
use multiversion::multiversion;
use std::ops::Range;

/// Coordinates of a point that a draw uses: those of the direction, and two for wo where it is drawn as well.
pub(super) fn dimensions<B: Bxdf + ?Sized>(bxdf: &B, trial: &Trial) -> usize {
    let direction = bxdf.dimensions(trial.sampling);
    match trial.outgoing {
        Outgoing::Fixed(_) => direction,
        Outgoing::Cosine => direction + 2,
    }
}

/// The set of points numbered `set` of the trial.
pub(super) fn point_set<B: Bxdf + ?Sized>(bxdf: &B, trial: &Trial, set: u64, count: u64) -> PointSet {
    let id = StreamId {
        seed: trial.seed,
        cell: trial.cell,
        batch: set,
    };
    PointSet::new(trial.points, id, count, dimensions(bxdf, trial))
}

/// The weights of the points `range` of a set, which starts at a multiple of [`crate::numerics::points::START`].
pub(super) fn batch<B: Bxdf + ?Sized>(bxdf: &B, trial: &Trial, set: &PointSet, range: Range<u64>) -> Moments {
    let dimensions = dimensions(bxdf, trial);
    let mut stream = set.stream(range.start);
    let mut points = [[0.0; BLOCK]; DIMENSIONS];
    let mut block = Block::new(trial.outgoing);
    let mut moments = Moments::default();
    let mut from = range.start;
    while from < range.end {
        let end = range.end.min((from / BLOCK as u64 + 1) * BLOCK as u64);
        let len = (end - from) as usize;
        set.fill(&mut stream, from, &mut points[..dimensions], len);
        block.weigh(bxdf, trial, &points, len);
        moments = moments.merge(block.moments(bxdf, len));
        from = end;
    }
    moments
}

/// The directions and the weights of a block of draws.
pub(super) struct Block {
    wo: [[f64; BLOCK]; 3],
    weights: [[f64; BLOCK]; 3],
}

impl Block {
    pub(super) fn new(outgoing: Outgoing) -> Self {
        let wo = match outgoing {
            Outgoing::Fixed(wo) => wo.to_array().map(|w| [w; BLOCK]),
            Outgoing::Cosine => [[0.0; BLOCK]; 3],
        };
        Self {
            wo,
            weights: [[0.0; BLOCK]; 3],
        }
    }

    /// Draws with the first `len` points.
    pub(super) fn weigh<B: Bxdf + ?Sized>(
        &mut self,
        bxdf: &B,
        trial: &Trial,
        points: &[[f64; BLOCK]; DIMENSIONS],
        len: usize,
    ) {
        if trial.outgoing == Outgoing::Cosine {
            let direction = bxdf.dimensions(trial.sampling);
            cosine_hemispheres(&points[direction], &points[direction + 1], &mut self.wo);
        }
        let draws = Draws {
            wo: &self.wo,
            u: [0, 1, 2].map(|k| &points[k]),
            len,
        };
        bxdf.weights(trial.sampling, trial.lobe.flag(), draws, &mut self.weights);
    }

    pub(super) fn moments<B: Bxdf + ?Sized>(&self, bxdf: &B, len: usize) -> Moments {
        let [x, y, z] = self.weights.each_ref().map(|w| &w[..len]);
        Moments::of(&[x, y, z][..bxdf.channels().count()])
    }

    /// The weight of draw `index`.
    pub(super) fn weight<B: Bxdf + ?Sized>(&self, bxdf: &B, index: usize) -> DVec3 {
        let last = bxdf.channels().count() - 1;
        DVec3::from_array([0, 1, 2].map(|c: usize| self.weights[c.min(last)][index]))
    }
}

/// [`crate::bxdf::cosine_hemisphere`] of every point.
#[multiversion(targets("x86_64+avx512f+avx512dq", "x86_64+avx2", "x86_64+avx"))]
fn cosine_hemispheres(u: &[f64; BLOCK], v: &[f64; BLOCK], [x, y, z]: &mut [[f64; BLOCK]; 3]) {
    for i in 0..BLOCK {
        let (sin, cos) = sin_cos_turns(v[i]);
        let radius = u[i].sqrt();
        x[i] = radius * cos;
        y[i] = radius * sin;
        z[i] = (1.0 - u[i]).sqrt();
    }
}
