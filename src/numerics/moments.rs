//! Running mean, variance and skewness, merged in a fixed order, and the confidence interval that they support.

use glam::DVec3;
use statrs::distribution::{ContinuousCDF, Normal, StudentsT};

/// Count, mean and central moments of a stream of values, per channel.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Moments {
    /// Number of values.
    pub count: u64,
    /// Number of values that were not zero in every channel.
    pub hits: u64,
    mean: DVec3,
    /// Sum of squared deviations.
    m2: DVec3,
    /// Sum of cubed deviations.
    m3: DVec3,
}

impl Moments {
    /// Adds one value.
    pub fn push(&mut self, value: DVec3) {
        self.count += 1;
        self.hits += u64::from(value != DVec3::ZERO);
        let n = self.count as f64;
        let delta = value - self.mean;
        let step = delta / n;
        let term = delta * step * (n - 1.0);
        self.mean += step;
        self.m3 += term * step * (n - 2.0) - 3.0 * step * self.m2;
        self.m2 += term;
    }

    /// The moments of both streams together [Chan et al. 1983].
    pub fn merge(self, other: Self) -> Self {
        if self.count == 0 {
            return other;
        }
        if other.count == 0 {
            return self;
        }
        let (a, b) = (self.count as f64, other.count as f64);
        let n = a + b;
        let delta = other.mean - self.mean;
        let m2 = self.m2 + other.m2 + delta * delta * (a * b / n);
        let m3 = self.m3
            + other.m3
            + delta * delta * delta * (a * b * (a - b) / (n * n))
            + 3.0 * delta * (a * other.m2 - b * self.m2) / n;
        Self {
            count: self.count + other.count,
            hits: self.hits + other.hits,
            mean: self.mean + delta * (b / n),
            m2,
            m3,
        }
    }

    /// Mean.
    pub fn mean(&self) -> DVec3 {
        self.mean
    }

    /// Unbiased variance of one value.
    pub fn variance(&self) -> DVec3 {
        self.m2 / (self.count.max(2) - 1) as f64
    }

    /// Skewness of one value, 0 where there is no variance.
    pub fn skewness(&self) -> DVec3 {
        let deviation = (self.m2 / self.count.max(1) as f64).powf(1.5);
        let third = self.m3 / self.count.max(1) as f64;
        DVec3::select(deviation.cmpgt(DVec3::ZERO), third / deviation, DVec3::ZERO)
    }

    /// Half-width of the interval that covers the mean with probability `confidence`.
    ///
    /// Student's t times s/sqrt(n), widened by the shift (1 + 2 t^2) |g| s/(6 n) by which a skewness g displaces the
    /// studentised mean [Johnson 1978]: estimators that rarely hit a narrow lobe are skewed, and the plain interval covers
    /// too little for them.
    pub fn half_width(&self, confidence: f64) -> DVec3 {
        let n = self.count as f64;
        if self.count < 2 {
            return DVec3::INFINITY;
        }
        let t = student_quantile(n - 1.0, confidence);
        let deviation = self.variance().powf(0.5);
        t * deviation / n.sqrt() + (1.0 + 2.0 * t * t) * self.skewness().abs() * deviation / (6.0 * n)
    }
}

/// Two-sided quantile of Student's t.
///
/// Beyond 200 degrees of freedom by its expansion about the normal quantile [Abramowitz and Stegun 1964, eq. 26.7.5],
/// which is then good to 2e-6; the search for the exact one takes minutes there.
fn student_quantile(freedom: f64, confidence: f64) -> f64 {
    let tail = 0.5 + 0.5 * confidence;
    if freedom < 200.0 {
        return StudentsT::new(0.0, 1.0, freedom).map_or(f64::INFINITY, |t| t.inverse_cdf(tail));
    }
    let z = Normal::standard().inverse_cdf(tail);
    let z2 = z * z;
    let first = z * (z2 + 1.0) / 4.0;
    let second = z * ((5.0 * z2 + 16.0) * z2 + 3.0) / 96.0;
    z + (first + second / freedom) / freedom
}

#[cfg(test)]
mod tests {
    use super::*;

    fn values() -> Vec<DVec3> {
        (0..1000)
            .map(|i| DVec3::new((f64::from(i) * 0.618).fract().powi(3), f64::from(i % 2), 2.0))
            .collect()
    }

    #[test]
    fn moments_match_their_definitions_and_merge() {
        let values = values();
        let mut all = Moments::default();
        values.iter().for_each(|v| all.push(*v));
        let n = values.len() as f64;
        let mean: DVec3 = values.iter().sum::<DVec3>() / n;
        let central = |k: i32| -> DVec3 {
            values
                .iter()
                .map(|v| (*v - mean).to_array().map(|d| d.powi(k)))
                .map(DVec3::from_array)
                .sum()
        };
        assert!((all.mean() - mean).abs().max_element() < 1e-14);
        assert!((all.variance() - central(2) / (n - 1.0)).abs().max_element() < 1e-14);
        let skewness = central(3).x / n / (central(2).x / n).powf(1.5);
        assert!((all.skewness().x - skewness).abs() < 1e-12);
        assert_eq!(all.skewness().z, 0.0);
        let mut parts = Moments::default();
        for chunk in values.chunks(77) {
            let mut part = Moments::default();
            chunk.iter().for_each(|v| part.push(*v));
            parts = parts.merge(part);
        }
        assert_eq!(parts.count, all.count);
        assert_eq!(parts.hits, all.hits);
        assert!((parts.skewness() - all.skewness()).abs().max_element() < 1e-12);
        assert!((parts.variance() - all.variance()).abs().max_element() < 1e-14);
    }

    /// Student's t at 99 %, from tables: 2.576 for many degrees of freedom, 3.250 for nine.
    #[test]
    fn quantiles_are_those_of_the_tables() {
        assert!((student_quantile(1e9, 0.99) - 2.5758).abs() < 1e-4);
        assert!((student_quantile(9.0, 0.99) - 3.2498).abs() < 1e-4);
        let (below, above) = (student_quantile(199.9999, 0.99), student_quantile(200.0, 0.99));
        assert!((below - above).abs() < 3e-6, "{below} and {above}");
    }

    #[test]
    fn too_few_values_know_nothing() {
        assert_eq!(Moments::default().half_width(0.99), DVec3::INFINITY);
    }
}
