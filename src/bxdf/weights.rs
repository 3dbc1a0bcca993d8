//! Many draws at once, as structures of arrays.

use super::{Bxdf, Flags, Sampling};
use glam::DVec3;

/// Draws that a block of the integrators holds, at most.
pub const BLOCK: usize = crate::numerics::points::BLOCK;

/// Many draws: entry k of every slice belongs to draw k.
#[derive(Debug, Clone, Copy)]
pub struct Draws<'a> {
    /// The fixed directions, by coordinate.
    pub wo: [&'a [f64]; 3],
    /// Uniform numbers; those beyond [`Bxdf::dimensions`] may be anything.
    pub u: [&'a [f64]; 3],
}

/// Where the weights go, one slice for each channel.
pub type Weights<'a> = [&'a mut [f64]; 3];

/// By [`Bxdf::sample`] for each draw.
pub(super) fn one_by_one<B: Bxdf + ?Sized>(
    bxdf: &B,
    sampling: Sampling,
    side: Flags,
    draws: Draws<'_>,
    mut weights: Weights<'_>,
) {
    let channels = bxdf.channels().count();
    for i in 0..weights[0].len() {
        let wo = DVec3::from_array(draws.wo.map(|w| w[i]));
        let drawn = bxdf.sample(sampling, wo, draws.u.map(|u| u[i]));
        let reflected = (wo.z < 0.0) == (drawn.wi.z < 0.0);
        let counts = reflected == side.contains(Flags::REFLECTION);
        for (channel, weights) in weights.iter_mut().enumerate().take(channels) {
            weights[i] = if counts { drawn.weight[channel] } else { 0.0 };
        }
    }
}
