//! Many draws at once, as structures of arrays.

use super::{Bxdf, Flags, Sampling};
use glam::DVec3;

pub use crate::numerics::points::BLOCK;

/// One number for each draw of a block.
pub type Lane = [f64; BLOCK];

/// Many draws: entry k of every lane belongs to draw k.
#[derive(Debug, Clone, Copy)]
pub struct Draws<'a> {
    /// The fixed directions, by coordinate.
    pub wo: &'a [Lane; 3],
    /// Numbers in [0, 1); those beyond [`Bxdf::dimensions`] may be any of them.
    pub u: [&'a Lane; 3],
    /// How many are asked for; lanes are full, and what lies beyond is of no interest.
    pub len: usize,
}

/// By [`Bxdf::sample`] for each draw.
pub(super) fn one_by_one<B: Bxdf + ?Sized>(
    bxdf: &B,
    sampling: Sampling,
    side: Flags,
    draws: Draws<'_>,
    weights: &mut [Lane; 3],
) {
    let channels = bxdf.channels().count();
    for i in 0..draws.len {
        let wo = DVec3::from_array([0, 1, 2].map(|axis: usize| draws.wo[axis][i]));
        let drawn = bxdf.sample(sampling, wo, draws.u.map(|u| u[i]));
        let reflected = (wo.z < 0.0) == (drawn.wi.z < 0.0);
        let counts = reflected == side.contains(Flags::REFLECTION);
        for (channel, weights) in weights.iter_mut().enumerate().take(channels) {
            weights[i] = if counts { drawn.weight[channel] } else { 0.0 };
        }
    }
}
