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
//! they fall geometrically, about the square of the last ones, the last ones times [`SAFETY`] are a bound with room; two in a
//! row, because one may pass through 0. Orders grow until the bound is met; where it is not, and where F has edges that
//! could hide between the nodes, [`super::facets`] takes over.

mod kernel;
mod orders;
mod rules;
#[cfg(test)]
mod tests;

use crate::bxdf::Microfacet;
use crate::distribution::Isotropic;
use crate::fresnel::Fresnel;
use crate::geometry::Polar;
use crate::masking::Masking;
use crate::numerics::gaussian::ierfc;
use crate::numerics::quadrature::{Bounded, Integral};
use crate::spectrum::Channels;
use glam::DVec3;
use kernel::{Constants, Scratch, Sums};
use orders::Orders;
use rules::{circle, legendre};
use std::cell::RefCell;
use std::f64::consts::PI;

/// Share of the tolerance that is cut off in the tail.
const TAIL_SHARE: f64 = 0.05;

/// Ratio of the stated error to the last coefficients. The true error was at most 1.7 times them over 10 000 random cases of
/// all orders, at orders too low to meet any tolerance; 1e-3 is typical.
const SAFETY: f64 = 3.0;

/// Rounding of the sum of up to 12 000 positive terms that add up to 1, and of the variables.
const ROUNDING: f64 = 2e-14;

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

/// rho_hd of a microfacet lobe under Smith masking at cos theta_o = `mu`, with an absolute error of at most `tolerance`; `None`
/// where these rules do not apply or do not get there.
pub(super) fn rho_hd(microfacet: &Microfacet, mu: f64, tolerance: f64) -> Option<Integral> {
    let (slopes, alpha) = match microfacet.distribution.isotropic()? {
        Isotropic::Ggx(ggx) => (Slopes::Ggx, ggx.alpha()),
        Isotropic::Beckmann(beckmann) => (Slopes::Gaussian, beckmann.m()),
        Isotropic::Vmf(_) | Isotropic::Phong(_) => return None,
    };
    let correlated = match microfacet.masking {
        Masking::Smith => false,
        Masking::SmithCorrelated => true,
        Masking::None | Masking::VGroove => return None,
    };
    if mu < LEAST_MU || tolerance < LEAST_TOLERANCE || !microfacet.fresnel.edges().is_empty() {
        return None;
    }
    let constants = constants(slopes, correlated, alpha, mu, TAIL_SHARE * tolerance);
    let depth = ((1.0 + constants.sin_o) / mu).ln();
    let mut orders = Orders::new(slopes, alpha, mu, depth, tolerance);
    let fixed = TAIL_SHARE * tolerance + ROUNDING;
    let share = (0.5 - 1e-9) * (tolerance - fixed) / SAFETY;
    SCRATCH.with_borrow_mut(|scratch| {
        let mut evaluations = 0;
        loop {
            let sums = estimate(microfacet, &constants, orders, scratch);
            evaluations += ((orders.outer + 1) * orders.inner) as u64;
            let (outer, inner) = (sums.outer.max_element(), sums.inner.max_element());
            if outer + inner <= 2.0 * share {
                return Some(Integral {
                    bounded: Bounded {
                        value: sums.value,
                        error: SAFETY * (sums.outer + sums.inner) + DVec3::splat(fixed),
                    },
                    evaluations,
                });
            }
            let dominant = outer.max(inner).min(share);
            orders = orders.grown(outer >= dominant, inner >= dominant)?;
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
    let reflectance = |theta_d: Polar| microfacet.facet_reflectance_at(theta_d);
    let channels = microfacet.reflectance.channels().max(microfacet.fresnel.channels());
    scratch.reflect(constants, legendre, channels == Channels::Grey, reflectance);
    match channels {
        Channels::Grey => scratch.sums(circle, legendre, Some(0)),
        Channels::Rgb => Sums::of_channels([0, 1, 2].map(|channel| scratch.sums(circle, legendre, Some(channel)))),
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
            let root = mu.hypot(across);
            let seen = 0.5 * (mu + root);
            let power = (8.0 * mu / (seen * allowed)).sqrt();
            (
                seen,
                root,
                power.max(8.0 * across / (PI * seen * allowed)).max(2.0).ln(),
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
            (seen, seen, alpha * (bound.ln() - allowed.ln()).max(1.0).sqrt())
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
