//! Tests of hypotheses. A significance is fixed before any number is looked at and shared by the whole family of tests.

use statrs::distribution::{Binomial, ChiSquared, ContinuousCDF, DiscreteCDF, Normal};
use whitefurnace::verify::statistics;

/// Probability that any test of a family fails although everything is right.
pub(crate) const SIGNIFICANCE: f64 = 1e-3;

/// The level of each of `tests` independent tests, so that all pass with probability 1 - [`SIGNIFICANCE`] [Sidak 1967].
pub(crate) fn sidak(tests: usize) -> f64 {
    statistics::sidak(SIGNIFICANCE, tests)
}

/// Probability of a sum of squares at least as far out as that of `z`, on either side, if all are standard normal.
pub(crate) fn squares_p(z: &[f64]) -> f64 {
    let sum = z.iter().map(|z| z * z).sum::<f64>();
    let distribution = ChiSquared::new(z.len() as f64).unwrap();
    2.0 * distribution.cdf(sum).min(distribution.sf(sum))
}

/// Probability of a largest distance to the standard normal's distribution function at least as large as that of `z`
/// [Kolmogorov 1933], with the correction of [Stephens 1970] for finite samples.
pub(crate) fn kolmogorov_p(z: &[f64]) -> f64 {
    let normal = Normal::standard();
    let mut sorted = z.to_vec();
    sorted.sort_by(f64::total_cmp);
    let n = sorted.len() as f64;
    let distance = sorted
        .iter()
        .enumerate()
        .map(|(i, z)| {
            let cdf = normal.cdf(*z);
            (cdf - i as f64 / n).max((i + 1) as f64 / n - cdf)
        })
        .fold(0.0, f64::max);
    let lambda = (n.sqrt() + 0.12 + 0.11 / n.sqrt()) * distance;
    let series: f64 = (1..=100)
        .map(|k| {
            let k = f64::from(k);
            let sign = if k % 2.0 == 1.0 { 2.0 } else { -2.0 };
            sign * (-2.0 * (k * lambda).powi(2)).exp()
        })
        .sum();
    // the alternating series has not converged where the probability is 1 anyway
    if lambda < 0.2 { 1.0 } else { series.clamp(0.0, 1.0) }
}

/// Probability of at most `covered` of `cells` intervals covering if each does with probability `confidence`.
pub(crate) fn coverage_p(covered: u64, cells: u64, confidence: f64) -> f64 {
    Binomial::new(confidence, cells).unwrap().cdf(covered)
}

/// Probability of counts at least as far from the expected ones, by Pearson's chi-squared; bins of fewer than 5 are pooled.
pub(crate) fn counts_p(counts: &[u64], expected: &[f64]) -> f64 {
    statistics::chi_squared(counts, expected, &vec![0.0; counts.len()]).p
}
