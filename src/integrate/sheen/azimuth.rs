//! The integral over the azimuth where F = 1, by the trapezoidal rule, with a bound known beforehand.
//!
//! With tan(delta/2) = e^w
//!
//! int_0^pi g ddelta = int_-inf^inf g sech(w) dw, g = (t^2/(t^2 + s^2))^(n/2), t^2 = (near + far e^(2 w))/(1 + e^(2 w)),
//!
//! s = n.o + n.i, where `near` and `far` are t^2 at delta = 0 and pi. With v = e^(-2 w), t^2/(t^2 + s^2) is the quotient of
//! far + near v and far + s^2 + (near + s^2) v. Where Re v >= 0, that is for |Im w| <= pi/4, both lie in the right half plane and
//! the quotient is at most its value at delta = pi, so that |g| <= g(pi) in a strip as wide as pi/2, however narrow the lobe and
//! however near the horizon. The rule of step h is then off by no more than 2 M/(e^(pi^2/(2 h)) - 1) [Trefethen and Weideman
//! 2014, theorem 5.1] with M = g(pi) int |sech(x + i pi/4)| dx = g(pi) 2 K(1/sqrt 2). Beyond the last node g is monotone and the
//! hyperbolic secant nearly a power of e^h, whose sum is known.

use crate::numerics::lanes::{exp, ln_sum};
use crate::numerics::quadrature::{NotConverged, ScalarIntegral};
use multiversion::multiversion;
use std::f64::consts::PI;

/// 2 K(1/sqrt 2), with K the complete elliptic integral of the first kind.
const ACROSS: f64 = 3.708_149_354_602_744;

/// The longest step: coarser ones have no more than the nodes of one block either.
const LONGEST: f64 = 1.0;

/// Error of rounding in units of g (1 + |ln g|), at its largest at delta = pi: some forty roundings of t^2, of which the weights
/// make pi times as much.
const ROUNDING: f64 = 2e-14;

/// What lies below the smallest numbers is taken for one of them.
const UNDERFLOW: f64 = 1e-300;

/// Nodes that are computed together.
const BLOCK: usize = 8;

/// Nodes on one side at most: e^(-700 h) is nothing for any step.
const MOST: usize = 1 << 14;

/// g on a half circle.
#[derive(Debug, Clone, Copy)]
pub(super) struct Azimuth {
    /// t^2 at delta = 0, where the tangential parts of both directions are opposite, and at delta = pi.
    pub(super) near: f64,
    pub(super) far: f64,
    /// (n.o + n.i)^2
    pub(super) square: f64,
    /// n/2
    pub(super) power: f64,
}

impl Azimuth {
    /// int_0^pi g ddelta, with an absolute error of at most `allowed`.
    pub(super) fn integral(&self, allowed: f64) -> Result<ScalarIntegral, NotConverged> {
        let most = self.g(self.far);
        let rounding = ROUNDING * most * (1.0 - libm::log(most.max(f64::MIN_POSITIVE))) + UNDERFLOW;
        let share = 0.5 * (allowed - rounding);
        if share <= 0.0 {
            return Err(NotConverged {
                reached: 4.0 * rounding,
                tolerance: allowed,
                evaluations: 0,
            });
        }
        let bound = 2.0 * ACROSS * most;
        let step = (0.5 * PI * PI / libm::log1p(bound / share)).min(LONGEST);
        let ratio = libm::exp(-step);
        // towards delta = pi from the middle on, and towards delta = 0 from the node after it
        let sides = [(self.near, self.far, 1.0), (self.far, self.near, ratio)].map(|(start, end, first)| {
            let side = Side {
                start,
                end,
                limit: self.g(end),
                square: self.square,
                power: self.power,
            };
            side.sum(first, ratio, 0.5 * share / step)
        });
        let [a, b] = sides;
        Ok(ScalarIntegral {
            value: step * (a.value + b.value),
            error: step * (a.error + b.error) + bound / libm::expm1(0.5 * PI * PI / step) + rounding,
            evaluations: a.evaluations + b.evaluations,
        })
    }

    /// g where t^2 = `t2`.
    fn g(&self, t2: f64) -> f64 {
        if t2 > 0.0 {
            libm::exp(-self.power * libm::log1p(self.square / t2))
        } else {
            0.0
        }
    }
}

/// One side of the middle, where x = e^-|w| falls from 1 to 0 and t^2 = (end + start x^2)/(1 + x^2).
#[derive(Clone, Copy)]
struct Side {
    start: f64,
    end: f64,
    /// g at the end.
    limit: f64,
    square: f64,
    power: f64,
}

impl Side {
    /// Sum of g sech over the nodes x = `first`, `first` `ratio`, ... to infinity, off by at most `allowed`.
    fn sum(&self, first: f64, ratio: f64, allowed: f64) -> ScalarIntegral {
        let mut x = [first; BLOCK];
        for k in 1..BLOCK {
            x[k] = x[k - 1] * ratio;
        }
        sum(*self, x, ratio, allowed)
    }
}

/// Block after block, until what follows is known by what g does at the end.
///
/// There 2 x (1 - x^2) <= sech <= 2 x, and g lies between its last value and its limit: of their mean, times the sum of all 2 x,
/// half the difference of both and the share x^2 may be missing.
#[multiversion(targets("x86_64+avx512f+avx512dq", "x86_64+avx2", "x86_64+avx"))]
fn sum(side: Side, mut x: [f64; BLOCK], ratio: f64, allowed: f64) -> ScalarIntegral {
    let leap = x[BLOCK - 1] / x[0] * ratio;
    let mut sums = [0.0; BLOCK];
    let mut blocks = 0;
    loop {
        let mut g = [0.0; BLOCK];
        for k in 0..BLOCK {
            let square = x[k] * x[k];
            // with a limit where t^2 underflows
            let odds = (side.square * (1.0 + square) / (side.end + side.start * square)).min(1e300);
            g[k] = exp(-side.power * ln_sum(1.0, odds));
            sums[k] += 2.0 * x[k] / (1.0 + square) * g[k];
        }
        blocks += 1;
        for value in &mut x {
            *value *= leap;
        }
        let last = g[BLOCK - 1];
        let rest = 2.0 * x[0] / (1.0 - ratio);
        let off = rest * (0.5 * (last - side.limit).abs() + x[0] * x[0] * last.max(side.limit));
        if off <= allowed || blocks * BLOCK >= MOST {
            return ScalarIntegral {
                value: sums.iter().sum::<f64>() + 0.5 * rest * (last + side.limit),
                error: off,
                evaluations: (blocks * BLOCK) as u64,
            };
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numerics::quadrature::{Piece, integrate_scalar};

    /// By Patterson's rules between powers of two of delta.
    fn patterson(azimuth: &Azimuth) -> ScalarIntegral {
        let mut pieces: Vec<Piece> = (0..120)
            .map(|k| Piece::smooth(PI * 0.5f64.powi(k + 1), PI * 0.5f64.powi(k)))
            .collect();
        pieces.push(Piece::smooth(0.0, PI * 0.5f64.powi(120)));
        let product = azimuth.far - azimuth.near;
        let g = |delta: f64| {
            let sin = libm::sin(0.5 * delta);
            azimuth.g(azimuth.near + product * sin * sin)
        };
        integrate_scalar(&pieces, 1e-13, g).unwrap()
    }

    fn between(cos_o: f64, cos_i: f64, alpha: f64) -> Azimuth {
        let [sin_o, sin_i] = [cos_o, cos_i].map(|cos| ((1.0 - cos) * (1.0 + cos)).sqrt());
        let sum = cos_o + cos_i;
        let apart = (cos_i - cos_o) * sum / (sin_o + sin_i);
        Azimuth {
            near: apart * apart,
            far: apart * apart + 4.0 * sin_o * sin_i,
            square: sum * sum,
            power: 0.5 / alpha,
        }
    }

    #[test]
    fn stated_errors_hold() {
        let cosines = [1e-12, 1e-6, 1e-3, 0.02, 0.1, 0.100001, 0.3, 0.7, 0.99, 0.99999];
        for (k, cos_o) in cosines.into_iter().enumerate() {
            for cos_i in &cosines[k..] {
                for alpha in [1e-3, 0.01, 0.1, 0.37, 1.0] {
                    let azimuth = between(cos_o, *cos_i, alpha);
                    let truth = patterson(&azimuth);
                    for allowed in [1.0, 1e-2, 1e-5, 1e-9, 1e-12] {
                        let found = azimuth.integral(allowed).unwrap();
                        let off = (found.value - truth.value).abs();
                        assert!(
                            off <= found.error + truth.error && found.error <= allowed,
                            "{cos_o} {cos_i} {alpha} {allowed}: {off:e} {found:?} {truth:?}"
                        );
                    }
                }
            }
        }
    }

    /// Some hundred nodes are enough for ten digits, next to the horizon too.
    #[test]
    fn nodes_are_few() {
        for (cos_o, cos_i) in [(0.5, 0.5), (1e-6, 1e-6), (1e-6, 0.9), (1e-3, 2e-3)] {
            for alpha in [1e-3, 0.1, 1.0] {
                let azimuth = between(cos_o, cos_i, alpha);
                for (allowed, most) in [(1e-5, 80), (1e-10, 200)] {
                    let found = azimuth.integral(allowed).unwrap();
                    assert!(
                        found.evaluations <= most,
                        "{cos_o} {cos_i} {alpha} {allowed}: {found:?}"
                    );
                }
            }
        }
    }

    #[test]
    fn directions_at_the_pole_see_nothing() {
        let azimuth = Azimuth {
            near: 0.0,
            far: 0.0,
            square: 4.0,
            power: 5.0,
        };
        let found = azimuth.integral(1e-12).unwrap();
        assert!(found.value.abs() < 1e-300 && found.error < 1e-12, "{found:?}");
    }

    #[test]
    fn what_rounding_forbids_is_refused() {
        assert!(between(0.2, 0.3, 0.1).integral(1e-20).is_err());
    }
}
