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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bxdf::{BrdfToBtdf, Lambertian, Scaled};
    use crate::geometry::Polar;
    use crate::numerics::stream::{Stream, StreamId};
    use crate::spectrum::Spectrum;

    /// Adapters pass blocks on, with the side and the channels that a single draw would have.
    #[test]
    fn adapters_weigh_blocks_as_single_draws() {
        let grey = Lambertian::new(Spectrum::grey(0.7)).unwrap();
        let scaled = Scaled::new(grey, Spectrum::rgb([0.2, 0.5, 1.0])).unwrap();
        let across = BrdfToBtdf::new(scaled);
        let models: [&dyn Bxdf; 3] = [&grey, &scaled, &across];
        let mut stream = Stream::new(StreamId {
            seed: 0,
            cell: 0,
            batch: 0,
        });
        let mut u = [[0.0; BLOCK]; 3];
        u.as_flattened_mut().fill_with(|| stream.uniform());
        let wo = Polar::from_cos(0.4).direction(0.3).to_array().map(|w| [w; BLOCK]);
        let draws = Draws {
            wo: &wo,
            u: [&u[0], &u[1], &u[2]],
            len: BLOCK,
        };
        for bxdf in models {
            for side in [Flags::REFLECTION, Flags::TRANSMISSION] {
                for sampling in [Sampling::Uniform, Sampling::Cosine, Sampling::Bxdf] {
                    let (mut found, mut single) = ([[0.0; BLOCK]; 3], [[0.0; BLOCK]; 3]);
                    bxdf.weights(sampling, side, draws, &mut found);
                    one_by_one(bxdf, sampling, side, draws, &mut single);
                    let channels = bxdf.channels().count();
                    for (found, single) in found.iter().zip(single).take(channels) {
                        let difference = |k: usize| (found[k] - single[k]).abs();
                        assert!((0..BLOCK).all(|k| difference(k) < 1e-15), "{side:?} {sampling:?}"); // one rounding
                    }
                    let counted = bxdf.flags().contains(side);
                    assert_eq!(
                        single[0].iter().any(|weight| *weight > 0.0),
                        counted,
                        "{side:?} {sampling:?}"
                    );
                }
            }
        }
    }
}
