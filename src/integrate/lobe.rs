//! Integrals over the normals of a lobe, in the coordinate in which every lobe looks alike.
//!
//! For an isotropic distribution, int p(h) W(theta_h) dh = int_0^inf q exp(-q^2/2) W(theta(q)) dq, where theta(q) is the
//! angle whose exposure -ln(1 - P) is q^2/2. The density itself is gone: kappa = 0 and kappa = 10^12 have the same weight,
//! nothing overflows, and what lies beyond q is at most exp(-q^2/2) times the bound of W.

use super::IntegrateError;
use crate::distribution::Isotropic;
use crate::geometry::Polar;
use crate::numerics::lanes;
use crate::numerics::quadrature::{Bounded, Integral, NotConverged, Piece, integrate};
use glam::DVec3;

/// Shares of the tolerance: what is cut off at the pole and in the tail, what the inner integrals may leave, and the rest
/// for the outer one.
const POLE_SHARE: f64 = 0.02;
const TAIL_SHARE: f64 = 0.03;
const INNER_SHARE: f64 = 0.35;
const OUTER_SHARE: f64 = 0.6;

/// Most nodes of an outer or an inner integral. Converging ones need some hundred.
pub(super) const NODE_LIMIT: u64 = 20_000;

/// Beyond this ratio of its ends, a piece is integrated in the logarithm of q: between a kink at the scale of mu and the
/// width of the lobe, W varies with theta/mu.
const LOGARITHMIC_RATIO: f64 = 16.0;

/// Longest logarithmic piece, in e-foldings.
const LONGEST_LOG: f64 = 7.0;

/// An angle at which W(theta) changes its form.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Kink {
    pub(super) theta: Polar,
    /// Whether W has half-integer powers of the distance just below the angle, and just above it.
    pub(super) below: bool,
    pub(super) above: bool,
}

impl Kink {
    /// The end of a piece of any variable, where only its smoothness counts.
    pub(super) fn between_pieces(kink: bool) -> Self {
        Self {
            theta: Polar::POLE,
            below: kink,
            above: kink,
        }
    }
}

/// A lobe with the angles at which W(theta) has kinks.
pub(super) struct LobeIntegral<'a> {
    pub(super) distribution: &'a Isotropic,
    /// Angles at which W is not smooth, in any order; only those within (0, pi/2) count.
    pub(super) kinks: &'a [Kink],
    /// W vanishes beyond this angle, itself a kink from below.
    pub(super) end: Option<Polar>,
    /// Bound of |W|.
    pub(super) bound: f64,
    /// Bound of |W| within 45 degrees of the pole.
    pub(super) pole_bound: f64,
    /// Largest absolute error allowed.
    pub(super) tolerance: f64,
}

impl LobeIntegral<'_> {
    /// Integrates W, given by `inner` as a function of theta and of the tolerance it has to meet, together with the number
    /// of evaluations that it took.
    pub(super) fn integrate(
        &self,
        mut inner: impl FnMut(Polar, f64) -> Result<Integral, NotConverged>,
    ) -> Result<Integral, IntegrateError> {
        // as a difference of logarithms: the quotient may overflow
        let q_tail = (2.0 * (libm::log(self.bound) - libm::log(TAIL_SHARE * self.tolerance)).max(1.0)).sqrt();
        let q_at = |theta: Polar| (2.0 * self.distribution.exposure(theta)).sqrt();
        let q_end = self.end.map_or(f64::INFINITY, q_at);
        let q_max = q_tail.min(q_end);
        // the normals within q of the pole weigh q^2/2; kinks that all lie there, at grazing angles, are not resolved
        let q_pole = (2.0 * POLE_SHARE * self.tolerance / self.pole_bound).sqrt();
        let mut cuts: Vec<(f64, Kink)> = self.kinks.iter().map(|kink| (q_at(kink.theta), *kink)).collect();
        let crowded = cuts.iter().any(|(q, _)| *q > 0.0 && *q <= q_pole);
        let q_min = if crowded { q_pole } else { 0.0 };
        cuts.retain(|(q, _)| *q > q_min && *q < q_max);
        let smooth = Kink {
            theta: Polar::POLE,
            below: false,
            above: false,
        };
        cuts.extend([
            (q_min, smooth),
            (
                q_max,
                Kink {
                    below: q_end <= q_tail,
                    ..smooth
                },
            ),
        ]);
        cuts.sort_by(|(a, _), (b, _)| a.total_cmp(b));
        let pieces: Vec<Piece> = cuts
            .windows(2)
            .filter(|w| w[1].0 > w[0].0)
            .flat_map(|w| pieces(w[0], w[1]))
            .collect();
        let mut evaluations = 0;
        let mut failure = None;
        let outer = integrate(&pieces, OUTER_SHARE * self.tolerance, NODE_LIMIT, |q| {
            let weight = q * lanes::exp(-0.5 * q * q);
            // half of the inner share spread over the mass, half over the length: either way it adds up to the share
            let allowed = 0.5 * INNER_SHARE * self.tolerance * (1.0 + (q_max * weight).recip());
            match inner(self.distribution.at_exposure(0.5 * q * q), allowed) {
                Ok(integral) => {
                    evaluations += integral.evaluations;
                    integral.bounded.scaled(weight)
                }
                Err(error) => {
                    failure.get_or_insert(error);
                    Bounded::exact(DVec3::NAN)
                }
            }
        });
        let tail = if q_tail < q_end {
            libm::exp(-0.5 * q_tail * q_tail)
        } else {
            0.0
        };
        let cut_off = self.bound * tail + self.pole_bound * 0.5 * q_min * q_min;
        match (failure, outer) {
            (Some(error), _) | (None, Err(error)) => Err(error.into()),
            (None, Ok(mut integral)) => {
                integral.bounded.error += DVec3::splat(cut_off);
                Ok(Integral {
                    evaluations,
                    ..integral
                })
            }
        }
    }
}

/// The pieces between two kinks; long ranges are split so that nothing in them hides between the nodes.
pub(super) fn pieces((from, start): (f64, Kink), (to, end): (f64, Kink)) -> Vec<Piece> {
    if from == 0.0 || to <= LOGARITHMIC_RATIO * from {
        return vec![Piece::kinked(from, to, start.above, end.below)];
    }
    // the quotient may overflow
    let log = libm::log(to) - libm::log(from);
    let count = (log / LONGEST_LOG).ceil().max(1.0) as usize;
    let at = |i: usize| {
        if i == count {
            to
        } else {
            from * libm::exp(log * i as f64 / count as f64)
        }
    };
    (0..count)
        .map(|i| Piece::kinked(at(i), at(i + 1), i == 0 && start.above, i + 1 == count && end.below).logarithmic())
        .collect()
}
