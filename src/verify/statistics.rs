//! Tests of hypotheses: what a difference means when chance has a part in it.
//!
//! The significance is fixed before any number is looked at and shared by the whole family of tests [Sidak 1967]. Where
//! nothing exact is known, a p-value errs on the large side: a check that cries wolf is soon ignored.

use crate::numerics::moments::Moments;
use glam::DVec3;
use statrs::distribution::{ChiSquared, ContinuousCDF, DiscreteCDF, Normal, Poisson};

/// The level of each of `tests` independent tests, so that all of them pass with probability 1 - `error` when everything is
/// right: 1 - (1 - error)^(1/tests) [Sidak 1967].
pub fn sidak(error: f64, tests: usize) -> f64 {
    -((-error).ln_1p() / tests.max(1) as f64).exp_m1()
}

/// The p-value of the smallest of several independent ones: 1 - (1 - p)^n. It is 1 when there are none.
pub fn smallest(p: &[f64]) -> f64 {
    let least = p.iter().copied().fold(1.0, f64::min);
    if least >= 1.0 {
        return 1.0;
    }
    -(p.len() as f64 * (-least).ln_1p()).exp_m1()
}

/// Two-sided p-value of a sum of independent standard normal scores, which sees small differences that all have one sign
/// [Stouffer et al. 1949].
pub fn common_sign(z: &[f64]) -> f64 {
    if z.is_empty() {
        return 1.0;
    }
    let sum: f64 = z.iter().sum();
    2.0 * Normal::standard().cdf(-(sum / (z.len() as f64).sqrt()).abs())
}

/// What makes the mean of random numbers uncertain.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Spread {
    /// Standard error of the mean.
    pub deviation: f64,
    /// Largest value over their number: how far one more rare value moves the mean.
    pub unseen: f64,
}

impl Spread {
    /// The spread of each channel of a mean.
    pub fn of(moments: &Moments) -> [Self; 3] {
        let n = moments.count.max(1) as f64;
        let deviation = (moments.variance() / n).powf(0.5).to_array();
        let unseen = (moments.largest() / n).to_array();
        [0, 1, 2].map(|channel| Self {
            deviation: deviation[channel],
            unseen: unseen[channel],
        })
    }

    /// The spread of a difference of two independent means.
    pub fn with(self, other: Self) -> Self {
        Self {
            deviation: self.deviation.hypot(other.deviation),
            unseen: self.unseen + other.unseen,
        }
    }

    /// Distance that the mean exceeds with a probability of at most e^-`exponent`: z deviation + exponent unseen.
    ///
    /// This is [`Moments::half_width`] as a function of its confidence, in the form of empirical Bernstein bounds [Maurer
    /// and Pontil 2009].
    fn quantile(self, exponent: f64) -> f64 {
        let z = -Normal::standard().inverse_cdf(0.5 * (-exponent).exp());
        z * self.deviation + exponent * self.unseen
    }

    /// p-value of a mean that is `distance` away from what it should be, on either side; 1 when that is 0 or less.
    pub fn p(self, distance: f64) -> f64 {
        if distance.is_nan() {
            return 0.0;
        }
        if distance <= 0.0 {
            return 1.0;
        }
        let (mut low, mut high) = (0.0, SMALLEST_EXPONENT);
        if self.quantile(high) < distance {
            return 0.0;
        }
        // the quantile grows with the exponent; 60 halvings leave its last bit
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if self.quantile(middle) < distance {
                low = middle;
            } else {
                high = middle;
            }
        }
        (-low).exp()
    }
}

/// e^-690 is about as small as f64 goes.
const SMALLEST_EXPONENT: f64 = 690.0;

/// Standard score whose two-sided p-value is `p`.
pub fn score(p: f64) -> f64 {
    if p >= 1.0 {
        return 0.0;
    }
    -Normal::standard().inverse_cdf(0.5 * p.max((-SMALLEST_EXPONENT).exp()))
}

/// p-value of the largest of three channels, which share their samples: three times the smallest.
pub fn channels_p(spread: [Spread; 3], distance: DVec3, channels: usize) -> f64 {
    let least = (0..channels.min(3))
        .map(|channel| spread[channel].p(distance[channel]))
        .fold(1.0, f64::min);
    (least * channels as f64).min(1.0)
}

/// Outcome of Pearson's test of counts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CountsTest {
    /// Sum of (count - expected)^2/expected.
    pub chi_squared: f64,
    /// Degrees of freedom: bins less one.
    pub freedom: u64,
    /// Probability of counts at least as far from the expected ones.
    pub p: f64,
    /// The bin that adds most to the sum, of those that are not pooled.
    pub worst: Option<usize>,
}

/// Compares counts with their expectations by Pearson's chi-squared; bins of fewer than 5 expected are pooled.
///
/// `slack` is how far each expectation itself may be off, and counts in favour of the hypothesis. Where all pooled bins
/// together expect fewer than 5, their count is judged by the Poisson distribution.
pub fn chi_squared(counts: &[u64], expected: &[f64], slack: &[f64]) -> CountsTest {
    let (mut sum, mut bins) = (0.0, 0u64);
    let (mut pooled_count, mut pooled_expected, mut pooled_slack) = (0u64, 0.0, 0.0);
    let mut worst: (f64, Option<usize>) = (0.0, None);
    let mut add = |count: u64, expected: f64, slack: f64| {
        let part = ((count as f64 - expected).abs() - slack).max(0.0).powi(2) / expected;
        sum += part;
        bins += 1;
        part
    };
    for (index, ((count, expected), slack)) in counts.iter().zip(expected).zip(slack).enumerate() {
        if *expected >= 5.0 {
            let part = add(*count, *expected, *slack);
            if part > worst.0 {
                worst = (part, Some(index));
            }
        } else {
            pooled_count += count;
            pooled_expected += expected.max(0.0);
            pooled_slack += slack;
        }
    }
    let mut rare_p = None;
    if pooled_expected >= 5.0 {
        add(pooled_count, pooled_expected, pooled_slack);
    } else if pooled_expected > 0.0 || pooled_count > 0 {
        let most = Poisson::new(pooled_expected + pooled_slack);
        rare_p = Some(match pooled_count {
            0 => 1.0,
            count => most.map_or(0.0, |poisson| poisson.sf(count - 1)),
        });
    }
    let freedom = bins.saturating_sub(1);
    let bins_p = match ChiSquared::new(freedom as f64) {
        Ok(distribution) if sum.is_finite() => distribution.sf(sum),
        _ if sum == 0.0 => 1.0,
        // one bin holds everything, or an expectation is not finite
        Ok(_) => 0.0,
        Err(_) => Spread {
            deviation: 1.0,
            unseen: 0.0,
        }
        .p(sum.sqrt()),
    };
    CountsTest {
        chi_squared: sum,
        freedom,
        p: rare_p.map_or(bins_p, |rare_p| smallest(&[bins_p, rare_p])),
        worst: worst.1,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn levels_and_smallest_values_are_inverse() {
        let level = sidak(1e-3, 40);
        let mut p = vec![0.7; 40];
        p[3] = level;
        assert!((smallest(&p) / 1e-3 - 1.0).abs() < 1e-12);
        assert_eq!(smallest(&[]), 1.0);
        assert_eq!(smallest(&[1.0, 1.0]), 1.0);
    }

    /// Without rare values p is that of the normal distribution: 1.96 for 5 %, 3.2905 for 0.1 %, from tables.
    #[test]
    fn distances_in_deviations_have_the_p_of_tables() {
        let spread = Spread {
            deviation: 2.0,
            unseen: 0.0,
        };
        for (z, p) in [(1.959_964, 0.05), (3.290_527, 1e-3), (4.417_173, 1e-5)] {
            assert!((spread.p(2.0 * z) / p - 1.0).abs() < 1e-5, "{z}");
            assert!((score(p) - z).abs() < 1e-5);
        }
        assert_eq!(spread.p(-1.0), 1.0);
        assert_eq!(spread.p(f64::NAN), 0.0);
        assert_eq!(spread.p(1e9), 0.0);
        let certain = Spread::default();
        assert_eq!((certain.p(1e-300), certain.p(0.0)), (0.0, 1.0));
    }

    /// A rare value of probability p, not seen in n draws, is no surprise while (1 - p)^n is not small.
    #[test]
    fn what_was_not_seen_is_allowed_for() {
        let mut moments = Moments::default();
        (0..10_000).for_each(|_| moments.push(DVec3::splat(1.0001)));
        // all 10^4 values above the true mean of 1, for want of the one that is 0
        let p = Spread::of(&moments)[0].p(1e-4);
        assert!((p - (-1f64).exp()).abs() < 1e-3, "{p}"); // e^-1 = (1 - 1e-4)^1e4 to 5e-5, over 1.0001
    }

    #[test]
    fn counts_are_judged_by_chi_squared_and_rare_ones_by_poisson() {
        let exact = [0.0; 4];
        let fair = chi_squared(&[105, 95, 98, 102], &[100.0; 4], &exact);
        assert_eq!((fair.freedom, fair.worst), (3, Some(0)));
        assert!((fair.chi_squared - 0.58).abs() < 1e-12 && fair.p > 0.9); // (25 + 25 + 4 + 4)/100
        assert!(chi_squared(&[150, 50, 100, 100], &[100.0; 4], &exact).p < 1e-9);
        assert_eq!(chi_squared(&[150, 50, 100, 100], &[100.0; 4], &[50.0; 4]).p, 1.0);
        // 1 - e^-0.5 of at least one where 0.5 are expected, twice looked at
        let rare = chi_squared(&[100, 1], &[100.0, 0.5], &[0.0; 2]);
        assert!((rare.p - (1.0 - (-0.5f64).exp().powi(2))).abs() < 1e-9, "{rare:?}");
        assert!(chi_squared(&[100, 30], &[100.0, 0.5], &[0.0; 2]).p < 1e-9);
        assert_eq!(chi_squared(&[100, 0], &[100.0, 0.0], &[0.0; 2]).p, 1.0);
        assert_eq!(chi_squared(&[100, 1], &[100.0, 0.0], &[0.0; 2]).p, 0.0);
    }

    #[test]
    fn small_differences_of_one_sign_add_up() {
        assert!(common_sign(&[1.5; 16]) < 1e-8);
        assert!(common_sign(&[1.5, -1.5]) > 0.999);
        assert_eq!(common_sign(&[]), 1.0);
    }
}
