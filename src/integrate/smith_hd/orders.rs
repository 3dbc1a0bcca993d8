//! The orders that a lobe, a direction and a tolerance are likely to need.
//!
//! They only save work: whether an order was enough is read off the values of the rule itself. Each is the exponential of a
//! quadratic polynomial, fitted to the smallest orders that certified 24 000 random cases (alpha and mu log-uniform and
//! uniform, three to eleven digits) so that about one case in eight falls short and is computed again.

use super::Slopes;
use super::rules::{INNER_STEP, MOST_INNER, MOST_OUTER, OUTER_STEP};

/// Orders of the outer and of the inner rule.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Orders {
    pub(super) outer: usize,
    pub(super) inner: usize,
}

const LEAST_OUTER: usize = 4;
const LEAST_INNER: usize = 8;

/// Growth of a rule that fell short.
const GROWTH: f64 = 1.35;

impl Orders {
    /// A first guess for a direction with A = ln((1 + sin theta_o)/mu) = `depth`.
    pub(super) fn new(slopes: Slopes, alpha: f64, mu: f64, depth: f64, tolerance: f64) -> Self {
        let off = (alpha / mu).ln() / 3.0;
        let variables = [
            (0.2 + depth).ln(),
            alpha.log10() / 3.0,
            (-tolerance.log10()).clamp(2.0, 12.0) / 10.0,
            // lobes as wide as the direction is high
            1.0 / (1.0 + off * off),
            1.0 / (1.0 + alpha),
        ];
        let (outer, inner) = match slopes {
            Slopes::Ggx => (GGX_OUTER, GGX_INNER),
            Slopes::Gaussian => (GAUSSIAN_OUTER, GAUSSIAN_INNER),
        };
        Self {
            outer: rounded(quadratic(&variables, &outer).exp(), OUTER_STEP, LEAST_OUTER, MOST_OUTER),
            inner: rounded(quadratic(&variables, &inner).exp(), INNER_STEP, LEAST_INNER, MOST_INNER),
        }
    }

    /// Larger orders for the rules that fell short; `None` where there are none.
    pub(super) fn grown(self, outer: bool, inner: bool) -> Option<Self> {
        let grow = |order: usize, short: bool, step: usize, most: usize| match short {
            true if order == most => None,
            true => Some(rounded(GROWTH * order as f64, step, order + step, most)),
            false => Some(order),
        };
        Some(Self {
            outer: grow(self.outer, outer, OUTER_STEP, MOST_OUTER)?,
            inner: grow(self.inner, inner, INNER_STEP, MOST_INNER)?,
        })
    }
}

/// Up to a multiple of `step` from `least` to `most`.
fn rounded(order: f64, step: usize, least: usize, most: usize) -> usize {
    ((order / step as f64).ceil() as usize * step).clamp(least.min(most), most)
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
    1.571, -0.576, 7.719, 1.908, -2.639, 3.84, 0.063, -0.102, 0.26, 0.488, 0.635, 0.277, 0.029, 0.63, -6.862, -0.529,
    0.117, -0.194, 0.457, 2.028, -3.236,
];

/// Of the slope under GGX.
const GGX_INNER: [f64; 21] = [
    -0.696, 0.695, 11.409, 1.689, 0.853, 6.481, 0.055, -0.086, -0.242, 0.087, -0.746, 0.345, 0.274, -0.72, -10.326,
    -0.571, -0.7, 1.448, 0.028, -1.349, -2.67,
];

/// Of the azimuth under Beckmann.
const GAUSSIAN_OUTER: [f64; 21] = [
    8.683, -0.402, -15.259, 3.386, -2.885, -17.219, 0.077, -0.059, 0.253, 0.656, 0.486, -0.068, -0.041, 0.951, 15.069,
    -0.733, 0.483, -1.48, 0.428, 2.722, 9.821,
];

/// Of the slope under Beckmann.
const GAUSSIAN_INNER: [f64; 21] = [
    7.286, 0.057, -14.46, 3.727, 0.54, -16.203, 0.027, -0.021, 0.068, 0.129, -0.172, -0.114, -0.137, 0.121, 14.283,
    -0.199, 0.039, -2.645, -0.095, -0.626, 11.455,
];
