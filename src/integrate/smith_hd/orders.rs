//! The orders that a lobe, a direction and a tolerance are likely to need.
//!
//! They only save work: whether an order was enough is read off the values of the rule itself. Each is the exponential of a
//! quadratic polynomial, fitted to the smallest orders that met their level in 30 000 random cases (alpha and mu uniform and
//! log-uniform, three to eleven digits) so that about one case in ten falls short and is computed again.

use super::Slopes;
use super::rules::{MOST_INNER, MOST_OUTER, OUTER_STEP, inner_order};

/// Orders of the outer and of the inner rule.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Orders {
    pub(super) outer: usize,
    pub(super) inner: usize,
}

const LEAST_OUTER: usize = 4;
const LEAST_INNER: usize = 6;

/// Growth of a rule that fell short.
const GROWTH: f64 = 1.25;

impl Orders {
    /// A first guess for last coefficients below `levels` of the outer and the inner rule, for a direction with
    /// A = ln((1 + sin theta_o)/mu) = `depth`.
    pub(super) fn new(slopes: Slopes, alpha: f64, mu: f64, depth: f64, levels: [f64; 2]) -> Self {
        let off = libm::log(alpha / mu) / 3.0;
        let variables = |level: f64| {
            [
                libm::log(0.2 + depth),
                libm::log10(alpha) / 3.0,
                (-libm::log10(level)).clamp(1.0, 13.0) / 10.0,
                // lobes as wide as the direction is high
                1.0 / (1.0 + off * off),
                1.0 / (1.0 + alpha),
            ]
        };
        let (outer, inner) = match slopes {
            Slopes::Ggx => (GGX_OUTER, GGX_INNER),
            Slopes::Gaussian => (GAUSSIAN_OUTER, GAUSSIAN_INNER),
        };
        let order = |coefficients: &[f64; 21], level: f64| libm::exp(quadratic(&variables(level), coefficients));
        Self {
            outer: outer_of(order(&outer, levels[0]), LEAST_OUTER),
            inner: inner_of(order(&inner, levels[1]), LEAST_INNER),
        }
    }

    /// With an inner rule of at least `inner` nodes; `None` if there is none.
    pub(super) fn at_least(self, inner: f64) -> Option<Self> {
        if inner > MOST_INNER as f64 {
            return None;
        }
        let inner = inner_of(inner, self.inner);
        Some(Self { inner, ..self })
    }

    /// Larger orders for the rules that fell short; `None` where there are none.
    pub(super) fn grown(self, outer: bool, inner: bool) -> Option<Self> {
        if (outer && self.outer == MOST_OUTER) || (inner && self.inner == MOST_INNER) {
            return None;
        }
        let grow = |order: usize| GROWTH * order as f64;
        Some(Self {
            outer: if outer {
                outer_of(grow(self.outer), 0)
            } else {
                self.outer
            },
            inner: if inner {
                inner_of(grow(self.inner), 0)
            } else {
                self.inner
            },
        })
    }
}

fn outer_of(order: f64, least: usize) -> usize {
    (order as usize + 1)
        .max(least)
        .next_multiple_of(OUTER_STEP)
        .min(MOST_OUTER)
}

fn inner_of(order: f64, least: usize) -> usize {
    inner_order((order as usize + 1).max(least)).min(MOST_INNER)
}

/// c_0 + sum c_i x_i + sum c_ij x_i x_j over i <= j.
fn quadratic(x: &[f64; 5], coefficients: &[f64; 21]) -> f64 {
    let mut sum = coefficients[0];
    let mut k = 6;
    for i in 0..5 {
        sum += coefficients[1 + i] * x[i];
        for j in i..5 {
            sum += coefficients[k] * x[i] * x[j];
            k += 1;
        }
    }
    sum
}

/// Of the azimuth under GGX.
const GGX_OUTER: [f64; 21] = [
    -2.252, -0.372, 16.288, 2.104, -2.285, 12.927, 0.064, -0.112, 0.271, 0.407, 0.464, 0.281, 0.096, 0.845, -15.513,
    -0.633, 0.069, 0.039, 0.406, 2.025, -9.016,
];

/// Of the slope under GGX.
const GGX_INNER: [f64; 21] = [
    -4.203, 0.708, 20.826, 2.175, 0.604, 15.513, 0.067, -0.137, -0.369, 0.215, -0.758, 0.341, 0.357, -0.485, -19.741,
    -0.602, -1.064, 1.695, 0.226, -1.162, -8.639,
];

/// Of the azimuth under Beckmann.
const GAUSSIAN_OUTER: [f64; 21] = [
    9.707, -0.093, -21.215, 4.124, -2.822, -22.696, 0.057, -0.071, 0.341, 0.513, 0.17, -0.197, 0.09, 1.039, 20.548,
    -0.954, 0.238, -1.5, 0.641, 2.885, 13.411,
];

/// Of the slope under Beckmann.
const GAUSSIAN_INNER: [f64; 21] = [
    6.725, 0.207, -14.964, 4.322, 0.763, -16.473, 0.019, -0.024, 0.018, 0.098, -0.277, -0.056, -0.32, 0.015, 15.052,
    -0.445, 0.049, -2.829, -0.112, -0.873, 12.029,
];
