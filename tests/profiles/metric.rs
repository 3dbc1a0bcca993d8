//! One measure for all tables of E: the error over a dense grid that no fit and no stated error has seen.

use crate::shared::within;
use crate::truth;
use rayon::prelude::*;
use std::sync::OnceLock;

/// Parts of each axis: not a multiple of any number of texels.
const CELLS: usize = 317;

/// Mean and largest |E_true/E - 1| over mu in [0.01, 1] and r in [0.05, 1], uniform in both.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Error {
    pub(crate) mean: f64,
    pub(crate) max: f64,
}

/// Values from `from` to 1 with their weights: borders of parts that are equal in v^(1/power), the ends among them. Each stands for the
/// values that are nearest to it in that.
fn along(from: f64, power: i32) -> impl Iterator<Item = (f64, f64)> + Clone {
    let start = from.powf(1.0 / f64::from(power));
    let value = move |part: f64| {
        within(start, (part / CELLS as f64).clamp(0.0, 1.0))
            .powi(power)
            .max(from)
    };
    (0..=CELLS).map(move |i| {
        let i = i as f64;
        (value(i), (value(i + 0.5) - value(i - 0.5)) / (1.0 - from))
    })
}

/// mu, r, weight and E; integrated once. Places crowd towards grazing mu, where tables of sqrt mu have several texels in a hundredth.
fn truths() -> &'static [[f64; 4]] {
    static ALL: OnceLock<Vec<[f64; 4]>> = OnceLock::new();
    ALL.get_or_init(|| {
        let places: Vec<[f64; 3]> = along(0.05, 1)
            .flat_map(|(r, b)| along(0.01, 2).map(move |(mu, a)| [mu, r, a * b]))
            .collect();
        let with_truth = |[mu, r, weight]: [f64; 3]| [mu, r, weight, truth::metal(mu, r * r)];
        places.into_par_iter().map(with_truth).collect()
    })
}

/// Of the lookup `e(mu, r)`.
pub(crate) fn error(e: impl Fn(f64, f64) -> f64) -> Error {
    let mut error = Error { mean: 0.0, max: 0.0 };
    for [mu, r, weight, truth] in truths() {
        let one = (truth / e(*mu, *r) - 1.0).abs();
        error.mean += weight * one;
        error.max = error.max.max(one);
    }
    error
}
