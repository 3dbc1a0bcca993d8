//! Integrals of the Gaussian e^(-x^2).

use std::f64::consts::{FRAC_2_SQRT_PI, PI};

/// 1/sqrt(pi)
const FRAC_1_SQRT_PI: f64 = 0.5 * FRAC_2_SQRT_PI;

/// Beyond this, e^(-x^2) is below the smallest number.
const UNDERFLOW: f64 = 27.5;

/// From here on the difference of [`ierfc`] would lose a tenth, and more and more, of its digits.
const FAR: f64 = 2.0;

/// Step and number of nodes of the trapezoidal rule in [`ierfc`]. The integrand is analytic within x >= [`FAR`] of the real
/// axis, so that the rule errs by e^(-2 pi FAR/STEP) = 9e-18; beyond the last node it is below 1e-17.
const STEP: f64 = 0.32;
const NODES: i32 = 20;

/// ierfc(x) = int_x^inf erfc(t) dt = e^(-x^2)/sqrt(pi) - x erfc(x) for x in [0, infinity] [Abramowitz and Stegun 1964,
/// 7.2.1].
///
/// The difference cancels to e^(-x^2)/(2 sqrt(pi) x^2). For large x it is formed as
/// e^(-x^2)/pi int t^2 e^(-t^2)/(x^2 + t^2) dt over the real line, in which every term is positive.
pub fn ierfc(x: f64) -> f64 {
    if x >= UNDERFLOW {
        return 0.0;
    }
    let gauss = exp_minus_square(x);
    if x < FAR {
        return FRAC_1_SQRT_PI * gauss - x * libm::erfc(x);
    }
    let square = x * x;
    let sum: f64 = WEIGHTS.iter().map(|(t2, weight)| weight / (square + t2)).sum();
    gauss * (2.0 * STEP / PI) * sum
}

/// (t^2, t^2 e^(-t^2)) at the nodes t = k STEP, k = 1, 2, ...; the integrand vanishes at t = 0.
static WEIGHTS: std::sync::LazyLock<[(f64, f64); NODES as usize]> = std::sync::LazyLock::new(|| {
    std::array::from_fn(|k| {
        let t = (k + 1) as f64 * STEP;
        (t * t, t * t * (-t * t).exp())
    })
});

/// e^(-x^2), with what the square loses by rounding put back: the exponential would multiply it by x^2.
pub fn exp_minus_square(x: f64) -> f64 {
    let square = x * x;
    let gauss = (-square).exp();
    if gauss == 0.0 {
        return 0.0;
    }
    gauss * (1.0 - x.mul_add(x, -square))
}

/// The x below which the density e^(-x^2)/sqrt(pi) holds `u`, for u in [0, 1]; 0 and 1 stand for half a step of the grid of
/// uniform numbers, 2^-54, away from them.
pub fn quantile(u: f64) -> f64 {
    if u <= 0.5 {
        -statrs::function::erf::erfc_inv(2.0 * u.max(HALF_STEP))
    } else {
        statrs::function::erf::erfc_inv(2.0 * (1.0 - u).max(HALF_STEP))
    }
}

/// Half the distance of neighbouring uniform numbers, 2^-54.
pub const HALF_STEP: f64 = 0.25 * f64::EPSILON;
