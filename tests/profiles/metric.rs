//! One measure for all tables of E: the error over a dense grid that no fit and no stated error has seen.

use crate::shared::within;
use crate::truth;
use rayon::prelude::*;
use std::sync::OnceLock;

/// Parts of each axis.
const CELLS: usize = 240;

/// Mean and largest |E_true/E - 1| over mu in [0.01, 1] and r in [0.05, 1], uniform in both.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Error {
    pub(crate) mean: f64,
    pub(crate) max: f64,
}

/// Values of a parameter with their weights: borders of equal parts, the ends among them and by half.
fn along(from: f64) -> impl Iterator<Item = (f64, f64)> + Clone {
    (0..=CELLS).map(move |i| {
        let weight = if i == 0 || i == CELLS { 0.5 } else { 1.0 };
        (within(from, i as f64 / CELLS as f64), weight / CELLS as f64)
    })
}

/// mu, r, weight and E; integrated once.
fn truths() -> &'static [[f64; 4]] {
    static ALL: OnceLock<Vec<[f64; 4]>> = OnceLock::new();
    ALL.get_or_init(|| {
        let places: Vec<[f64; 3]> = along(0.05)
            .flat_map(|(r, b)| along(0.01).map(move |(mu, a)| [mu, r, a * b]))
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
