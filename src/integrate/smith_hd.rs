//! rho_hd of isotropic GGX and Beckmann lobes under Smith masking: two rules that converge geometrically, at all nodes at once.
//!
//! In the slopes of the facets, with t = tan theta_h, phi the azimuth from wo and x = tan theta_o cos phi,
//!
//! rho_hd = (1/pi) int_0^pi dphi int_0^T 2 pi P22(t) t F(o.h) G2 (1 + x t) dt,
//!
//! since D (n.h) dh = P22 t dt dphi and (o.h)/((n.o)(n.h)) = 1 + x t [Walter et al. 2007; Heitz 2014]. The light direction is
//! above the horizon for t < T = e^a with a = asinh x:
//!
//! n.i/n.o = (1 + 2 x t - t^2)/(1 + t^2) = (T - t)(t + 1/T)/(1 + t^2),
//!
//! a form without cancellation and without a kink inside. Multiplied through by mu = n.o, in X = mu x and mu T, everything is
//! finite at grazing angles. With S(w) = sqrt((n.w)^2 + alpha^2 sin^2 theta_w), the weight G2 (1 + x t) is for GGX
//!
//! - 2 (mu + X t) (n.i)/((n.i) S(o) + mu S(i)), height-correlated;
//! - 4 (mu + X t) (n.i)/((mu + S(o))(n.i + S(i))), uncorrelated;
//!
//! and for Beckmann the same made of hidden(w) = (alpha sin theta_w/2) ierfc((n.w)/(alpha sin theta_w)), see
//! [`crate::masking::Smith`].
//!
//! **Inner rule.** GGX: t = alpha sinh s turns 2 pi P22 t dt into 2 sinh s/cosh^3 s ds, whose poles are i pi/2 away from the
//! axis whatever alpha is, and whose range grows like the logarithm of 1/alpha and of the tolerance. Beckmann: t = 2u/(1 - u^2),
//! which moves the poles at t = +-i, those of (n.h)^2, away from the ends. Gauss-Legendre rules in s and u converge
//! geometrically.
//!
//! **Outer rule.** The integrand depends on phi through a in [-A, A], A = ln((1 + sin theta_o)/mu), and is analytic in a strip
//! about that interval, so the layer in which cos phi passes through 0 at grazing angles is no layer here. With
//! a = A cos psi, p = A - a = 2 A sin^2(psi/2) and q = A + a,
//!
//! dphi/dpsi = A sin psi cosh a/sqrt(sinh p sinh q) = cosh a/sqrt((sinh p/p)(sinh q/q)),
//!
//! which is even and periodic in psi: the trapezoidal rule on [0, pi] converges geometrically too, at a rate that falls like
//! 1/A = 1/ln(1/mu).
//!
//! **Error.** The last two coefficients that each rule resolves, of the cosines N - 1 and N and of the Legendre polynomials
//! n - 2 and n - 1, come from the values at hand. What the rules leave is made of the coefficients from 2 N and 2 n on. As
//! they fall geometrically, about the square of the last ones, the last ones times a factor ([`Safety`]) are a bound; two in a
//! row, because one may pass through 0. Orders grow until the bound is met; where it is not, and where F has edges that
//! could hide between the nodes, [`super::facets`] takes over.
//!
//! One thing does hide between the nodes. Where alpha is far below mu, G2 of GGX is 1 up to the horizon but for a layer there,
//! n.i of the order of alpha. With n.i = mu (S - s) near the end S of the range it is alpha/mu wide, and holds the weight
//!
//! 2 (alpha/T)^2 (1 + x T) (alpha/mu) int_0^inf (sqrt(1 + u^2) - u)^2 du = (2/3) (alpha^3/mu) (1 + 1/T^2),
//!
//! of which the mean over phi is (2/3) (alpha^3/mu) (1 + 1/mu^2) ([`Layer`]). The first node of a rule of n lies 1.4 S/n^2 from
//! the end: what a layer thinner than that holds is added to the bound.

mod kernel;
mod orders;
mod rules;
#[cfg(test)]
mod tests;

use crate::bxdf::Microfacet;
use crate::distribution::Isotropic;
use crate::fresnel::Fresnel;
use crate::masking::Masking;
use crate::numerics::gaussian::ierfc;
use crate::numerics::quadrature::{Bounded, Integral};
use crate::spectrum::{Channels, Spectrum};
use glam::DVec3;
use kernel::{Constants, Scratch, Sums};
use orders::Orders;
use rules::{MOST_INNER, circle};
pub(super) use rules::{inner_order, legendre};
use std::cell::RefCell;
use std::f64::consts::PI;

/// Share of the tolerance that is cut off in the tail.
const TAIL_SHARE: f64 = 0.05;

/// Ratios of the stated error to the last coefficients.
#[derive(Debug, Clone, Copy)]
struct Safety {
    outer: f64,
    inner: f64,
}

impl Safety {
    /// At least twice the largest ratio of the true error, found over 30 000 random cases of all orders where the last
    /// coefficients were below a thousand tolerances; the typical one is 1e-3.
    ///
    /// With alpha up to 1 and no Fresnel term the family of integrands is known, and the ratio at most 0.06 and 0.3 for the
    /// azimuth under GGX and Beckmann, and 0.04 and 0.02 for the slope. For rough lobes G2 varies with n.i near the normal
    /// within a sine of 1/alpha, and for Fresnel terms nothing is presumed: 1.5.
    fn new(slopes: Slopes, alpha: f64, fresnel: &Fresnel, layer_is_resolved: bool) -> Self {
        if alpha > 1.0 || *fresnel != Fresnel::None {
            return Self { outer: 3.0, inner: 3.0 };
        }
        match slopes {
            Slopes::Ggx => Self {
                outer: 0.2,
                inner: if layer_is_resolved { 0.1 } else { 3.0 },
            },
            Slopes::Gaussian => Self {
                outer: 0.6,
                inner: 0.05,
            },
        }
    }
}

/// Rounding of the sum of up to 12 000 positive terms that add up to 1, and of the variables.
const ROUNDING: f64 = 2e-14;

/// Resolution n^2 (alpha/mu)/S from which on the coefficients see the layer at the horizon. Of a layer alone the rules miss
/// 0.98, 0.63, 0.36, 0.19 and 0.10 at 0.03, 0.5, 1, 1.5 and 2, and [`Safety`] times the coefficients of 96 nodes, of all
/// the least, are 0.02, 0.3, 0.5, 0.6 and 0.7.
const RESOLVED: f64 = 1.5;

/// Resolution from which on nothing of the layer is left but what falls geometrically.
const WELL_RESOLVED: f64 = 6.0;

/// Below this tolerance rounding takes too much of it.
const LEAST_TOLERANCE: f64 = 1e-12;

/// Below this cosine the rules grow long.
const LEAST_MU: f64 = 1e-9;

thread_local! {
    static SCRATCH: RefCell<Scratch> = RefCell::default();
}

/// The round distributions of slopes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Slopes {
    /// 1/(pi alpha^2 (1 + t^2/alpha^2)^2), GGX.
    Ggx,
    /// e^(-t^2/alpha^2)/(pi alpha^2), Beckmann.
    Gaussian,
}

/// The layer of GGX at the horizon.
struct Layer {
    /// Its part of rho_hd.
    weight: f64,
    /// Its width in s, relative to the longest range.
    width: f64,
}

impl Layer {
    fn new(constants: &Constants) -> Self {
        let Constants { alpha, mu, .. } = *constants;
        let ratio = alpha / mu;
        // the longest range ends at T = (1 + sin theta_o)/mu
        let reach = (1.0 + constants.sin_o) / (alpha * mu);
        let length = libm::log(reach + libm::hypot(reach, 1.0)).min(constants.end);
        match constants.slopes {
            Slopes::Ggx => Self {
                weight: 2.0 / 3.0 * ratio * (alpha * alpha + ratio * ratio),
                width: ratio / length,
            },
            // it lies where e^(-t^2/alpha^2) has vanished
            Slopes::Gaussian => Self {
                weight: 0.0,
                width: f64::INFINITY,
            },
        }
    }

    /// n^2 times the width.
    fn resolution(&self, inner: usize) -> f64 {
        self.width * (inner * inner) as f64
    }

    /// The order of a resolution.
    fn order(&self, resolution: f64) -> f64 {
        (resolution / self.width).sqrt()
    }

    /// What a rule of `inner` nodes may miss of it without a trace.
    fn hidden(&self, inner: usize) -> f64 {
        self.weight * (1.0 - self.resolution(inner) / RESOLVED).max(0.0)
    }

    /// The resolution at which no more than `allowed` hides.
    fn needed(&self, allowed: f64) -> f64 {
        RESOLVED * (1.0 - allowed / self.weight).max(0.0)
    }
}

/// rho_hd of a microfacet lobe under Smith masking at cos theta_o = `mu`, with an absolute error of at most `tolerance`; `None`
/// where these rules do not apply or do not get there.
pub(super) fn rho_hd(microfacet: &Microfacet, mu: f64, tolerance: f64) -> Option<Integral> {
    let (slopes, alpha) = match microfacet.distribution.isotropic()? {
        Isotropic::Ggx(ggx) => (Slopes::Ggx, ggx.alpha()),
        Isotropic::Beckmann(beckmann) => (Slopes::Gaussian, beckmann.m()),
        Isotropic::Vmf(_) | Isotropic::Phong(_) | Isotropic::Charlie(_) => return None,
    };
    let correlated = match microfacet.masking {
        Masking::Smith => false,
        Masking::SmithCorrelated => true,
        Masking::None | Masking::VGroove | Masking::Neubelt | Masking::Charlie => return None,
    };
    if mu < LEAST_MU || tolerance < LEAST_TOLERANCE || !microfacet.fresnel.edges().is_empty() {
        return None;
    }
    let constants = constants(slopes, correlated, alpha, mu, TAIL_SHARE * tolerance);
    let depth = libm::log((1.0 + constants.sin_o) / mu);
    let fixed = TAIL_SHARE * tolerance + ROUNDING;
    let share = (tolerance - fixed) / 2.0;
    let layer = Layer::new(&constants);
    let safety_of = |inner| {
        Safety::new(
            slopes,
            alpha,
            &microfacet.fresnel,
            layer.resolution(inner) > WELL_RESOLVED,
        )
    };
    let guess = |safety: Safety| Orders::new(slopes, alpha, mu, depth, [share / safety.outer, share / safety.inner]);
    let mut orders = guess(safety_of(MOST_INNER));
    // where the layer is not resolved, either it will be, or the coefficients have to be smaller
    let resolving = layer.order(WELL_RESOLVED);
    if (orders.inner as f64) < resolving {
        let careful = guess(safety_of(0)).at_least(layer.order(layer.needed(share)))?;
        orders = if (careful.inner as f64) < resolving {
            careful
        } else {
            orders.at_least(resolving)?
        };
    }
    SCRATCH.with_borrow_mut(|scratch| {
        let mut evaluations = 0;
        loop {
            let sums = estimate(microfacet, &constants, orders, scratch);
            evaluations += ((orders.outer + 1) * orders.inner) as u64;
            let safety = safety_of(orders.inner);
            let (outer, inner) = (safety.outer * sums.outer, safety.inner * sums.inner);
            let error = outer + inner + DVec3::splat(fixed + layer.hidden(orders.inner));
            if error.max_element() <= tolerance {
                let value = sums.value;
                return Some(Integral {
                    bounded: Bounded { value, error },
                    evaluations,
                });
            }
            // whichever is above its share; of both below it, which together are not, the larger
            let (outer, inner) = (outer.max_element(), inner.max_element());
            let most = outer.max(inner).min(share);
            orders = orders.grown(outer >= most, inner >= most)?;
        }
    })
}

/// The sums of one pair of rules, per channel.
fn estimate(microfacet: &Microfacet, constants: &Constants, orders: Orders, scratch: &mut Scratch) -> Sums {
    let (circle, legendre) = (circle(orders.outer), legendre(orders.inner));
    scratch.evaluate(constants, circle, legendre);
    if microfacet.fresnel == Fresnel::None {
        return scratch
            .sums(circle, legendre, None)
            .scaled(microfacet.reflectance.value());
    }
    let channels = channels(microfacet);
    scratch.reflect(constants, (circle, legendre), microfacet, channels);
    let mut each = [Sums::default(); 3];
    for (channel, sums) in each.iter_mut().enumerate().take(channels) {
        *sums = scratch.sums(circle, legendre, Some(channel));
    }
    // those that are not computed equal the last
    Sums::of_channels([0, 1, 2].map(|channel: usize| each[channel.min(channels - 1)]))
}

/// How many channels differ: r0 = (0, 1, 1) stands for the two albedos that those of all r0 are mixed from.
fn channels(microfacet: &Microfacet) -> usize {
    let repeats = |spectrum: Spectrum| spectrum.value().y == spectrum.value().z;
    match (
        microfacet.reflectance.channels().max(microfacet.fresnel.channels()),
        microfacet.fresnel,
    ) {
        (Channels::Grey, _) => 1,
        (_, Fresnel::Schlick { r0 }) if repeats(r0) && repeats(microfacet.reflectance) => 2,
        _ => 3,
    }
}

/// The constants of the integrand, with the end of the lobe where what lies beyond weighs at most `allowed`.
///
/// G2 <= G1(o) = mu/seen(o) bounds the weight by (mu + X t)/seen(o), and the mean of the positive part of X is
/// sin theta_o/pi.
///
/// - GGX: 1/cosh^2 s <= 4 e^(-2 s) of the facets lie beyond s, and t <= alpha e^s/2 makes the other term at most
///   4 X alpha e^(-s). Each gets half of `allowed`.
/// - Beckmann: e^(-v^2) of the facets lie beyond t = alpha v, and int_v^inf 2 v^2 e^(-v^2) dv <= 1.5 v e^(-v^2) for v >= 1.
///   v is below 7 for all tolerances, and 1.5 * 7/pi < 3.4.
fn constants(slopes: Slopes, correlated: bool, alpha: f64, mu: f64, allowed: f64) -> Constants {
    let sin_o = ((1.0 - mu) * (1.0 + mu)).sqrt();
    let across = alpha * sin_o;
    let (seen, other, end) = match slopes {
        Slopes::Ggx => {
            let root = libm::hypot(mu, across);
            let seen = 0.5 * (mu + root);
            let power = (8.0 * mu / (seen * allowed)).sqrt();
            (
                seen,
                root,
                libm::log(power.max(8.0 * across / (PI * seen * allowed)).max(2.0)),
            )
        }
        Slopes::Gaussian => {
            let hidden = if across > 0.0 {
                0.5 * across * ierfc(mu / across)
            } else {
                0.0
            };
            let seen = mu + hidden;
            let bound = (mu + 3.4 * across) / seen;
            (
                seen,
                seen,
                alpha * (libm::log(bound) - libm::log(allowed)).max(1.0).sqrt(),
            )
        }
    };
    // the half of GGX is S, of which (S - n.i)/2 is the hidden area
    let (factor, own, other) = match (slopes, correlated) {
        (Slopes::Ggx, true) => (2.0, other, mu),
        (Slopes::Ggx, false) => (2.0 / seen, 1.0, 1.0),
        (Slopes::Gaussian, true) => (1.0, other, mu),
        (Slopes::Gaussian, false) => (seen.recip(), 1.0, 1.0),
    };
    Constants {
        slopes,
        alpha,
        mu,
        sin_o,
        factor,
        own,
        other,
        end,
    }
}
