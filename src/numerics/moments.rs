//! Running mean and variance, merged in a fixed order, and the confidence interval that they support.

use glam::DVec3;
use multiversion::multiversion;
use statrs::distribution::{ContinuousCDF, Normal, StudentsT};

/// Count, mean, variance and largest size of a stream of values, per channel.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Moments {
    /// Number of values.
    pub count: u64,
    mean: DVec3,
    /// Sum of squared deviations.
    m2: DVec3,
    /// Largest absolute value, seen or expected.
    largest: DVec3,
}

impl Moments {
    /// Adds one value.
    pub fn push(&mut self, value: DVec3) {
        self.count += 1;
        let n = self.count as f64;
        let delta = value - self.mean;
        self.mean += delta / n;
        self.m2 += delta * (value - self.mean);
        self.largest = self.largest.max(value.abs());
    }

    /// The moments of a block of values: one slice for all channels, or one for each of three.
    ///
    /// In two passes, so that squares of deviations are added and not differences of squares [Chan et al. 1983].
    pub fn of(channels: &[&[f64]]) -> Self {
        let mut block = Self {
            count: channels[0].len() as u64,
            ..Self::default()
        };
        for c in 0..3 {
            // equal channels are summed once
            let Some(values) = channels.get(c) else {
                block.mean[c] = block.mean.x;
                block.m2[c] = block.m2.x;
                block.largest[c] = block.largest.x;
                continue;
            };
            let (sum, largest) = sum_and_largest(values);
            block.mean[c] = sum / values.len().max(1) as f64;
            block.m2[c] = squared_deviations(values, block.mean[c]);
            block.largest[c] = largest;
        }
        block
    }

    /// Says that values may be as large as `value`, though none has been seen.
    pub fn expect(&mut self, value: DVec3) {
        self.largest = self.largest.max(value.abs());
    }

    /// The moments of both streams together [Chan et al. 1983].
    pub fn merge(self, other: Self) -> Self {
        let largest = self.largest.max(other.largest);
        if self.count == 0 {
            return Self { largest, ..other };
        }
        if other.count == 0 {
            return Self { largest, ..self };
        }
        let (a, b) = (self.count as f64, other.count as f64);
        let n = a + b;
        let delta = other.mean - self.mean;
        Self {
            count: self.count + other.count,
            mean: self.mean + delta * (b / n),
            m2: self.m2 + other.m2 + delta * delta * (a * b / n),
            largest,
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

    /// Largest absolute value, seen or expected.
    pub fn largest(&self) -> DVec3 {
        self.largest
    }

    /// How many equal values would spread as much: (sum w)^2/(sum w^2), the least of all channels that are not 0.
    ///
    /// A lobe's tail contributes to every sample and says nothing; this counts the samples that carry the mean.
    pub fn effective(&self) -> f64 {
        let n = self.count as f64;
        let squares = n * self.mean * self.mean + self.m2;
        let each = (n * self.mean) * (n * self.mean) / squares;
        let carried = (0..3).filter(|c| squares[*c] > 0.0).map(|c| each[c]);
        carried.reduce(f64::min).unwrap_or(0.0)
    }

    /// Half-width of the interval that covers the mean with probability `confidence`.
    ///
    /// Student's t times s/sqrt(n), and the rare event: what occurs less often than ln(1/(1 - confidence))/n need not have
    /// been seen once, and changes a value by as much as the largest one. This is the form of empirical Bernstein bounds
    /// [Maurer and Pontil 2009]; it also exceeds the shift of the studentised mean by skewness [Johnson 1978].
    pub fn half_width(&self, confidence: f64) -> DVec3 {
        self.student(confidence) + self.unseen(confidence) / self.count.max(1) as f64
    }

    /// Student's t times s/sqrt(n): the half-width for values that are normally distributed.
    pub fn student(&self, confidence: f64) -> DVec3 {
        if self.count < 2 {
            return DVec3::INFINITY;
        }
        let n = self.count as f64;
        student_quantile(n - 1.0, confidence) * (self.variance() / n).map(f64::sqrt)
    }

    /// Mean of the squares over the square of the largest: the share of values that would be as large, were the rest 0.
    pub fn largest_share(&self) -> DVec3 {
        let squares = self.mean * self.mean + self.m2 / self.count.max(1) as f64;
        squares / (self.largest * self.largest)
    }

    /// The number of values at which the half-width would be `width`, if they go on like this.
    pub fn count_for(&self, width: f64, confidence: f64) -> f64 {
        let t = student_quantile((self.count.max(2) - 1) as f64, confidence);
        // the positive root of width n = t s sqrt(n) + u
        let (spread, unseen) = (t * self.variance().map(f64::sqrt), self.unseen(confidence));
        let root = (spread + (spread * spread + 4.0 * width * unseen).map(f64::sqrt)) / (2.0 * width);
        (root * root).max_element()
    }

    fn unseen(&self, confidence: f64) -> DVec3 {
        -libm::log(1.0 - confidence) * self.largest
    }
}

/// Sums run in this many lanes, added up in order: the same bits from vector units of every width.
const LANES: usize = 8;

#[multiversion(targets("x86_64+avx512f+avx512dq", "x86_64+avx2", "x86_64+avx"))]
fn sum_and_largest(values: &[f64]) -> (f64, f64) {
    let (mut sums, mut largest) = ([0.0; LANES], [0.0f64; LANES]);
    let chunks = values.chunks_exact(LANES);
    let rest = chunks.remainder();
    for chunk in chunks {
        for lane in 0..LANES {
            let size = chunk[lane].abs();
            sums[lane] += chunk[lane];
            largest[lane] = if size > largest[lane] { size } else { largest[lane] };
        }
    }
    for (lane, value) in rest.iter().enumerate() {
        sums[lane] += value;
        largest[lane] = largest[lane].max(value.abs());
    }
    (sums.iter().sum(), largest.into_iter().fold(0.0, f64::max))
}

#[multiversion(targets("x86_64+avx512f+avx512dq", "x86_64+avx2", "x86_64+avx"))]
fn squared_deviations(values: &[f64], mean: f64) -> f64 {
    let mut sums = [0.0; LANES];
    let chunks = values.chunks_exact(LANES);
    let rest = chunks.remainder();
    for chunk in chunks {
        for lane in 0..LANES {
            let deviation = chunk[lane] - mean;
            sums[lane] += deviation * deviation;
        }
    }
    for (lane, value) in rest.iter().enumerate() {
        sums[lane] += (value - mean) * (value - mean);
    }
    sums.iter().sum()
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
        let sums: DVec3 = values.iter().map(|v| *v * *v).sum();
        let effective = (n * mean * n * mean / sums).min_element();
        assert!((all.effective() / effective - 1.0).abs() < 1e-12);
        let mut parts = Moments::default();
        for chunk in values.chunks(77) {
            let mut part = Moments::default();
            chunk.iter().for_each(|v| part.push(*v));
            parts = parts.merge(part);
        }
        let blocks = values.chunks(77).fold(Moments::default(), |all, chunk| {
            let channels = [0, 1, 2].map(|c| chunk.iter().map(|v| v[c]).collect::<Vec<_>>());
            let block = Moments::of(&[&channels[0], &channels[1], &channels[2]]);
            let grey = Moments::of(&[&channels[0]]);
            assert_eq!((grey.mean, grey.m2.y), (DVec3::splat(block.mean.x), block.m2.x));
            all.merge(block)
        });
        assert!((blocks.mean() - mean).abs().max_element() < 1e-14);
        assert!((blocks.variance() - all.variance()).abs().max_element() < 1e-14);
        assert_eq!((blocks.count, blocks.largest()), (all.count, all.largest()));
        assert_eq!(parts.count, all.count);
        assert!((parts.effective() / all.effective() - 1.0).abs() < 1e-12);
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
        assert_eq!(Moments::default().effective(), 0.0);
    }

    /// n equal values leave room for an event of probability p with (1 - p)^n = 1 %.
    #[test]
    fn values_without_spread_leave_room_for_the_unseen() {
        let mut moments = Moments::default();
        (0..1000).for_each(|_| moments.push(DVec3::splat(0.5)));
        let unseen = 1.0 - 0.01f64.powf(1e-3);
        let width = moments.half_width(0.99).x;
        assert!((width / (0.5 * unseen) - 1.0).abs() < 3e-3, "{width}"); // (1 - p)^n = e^(-p n) to second order
        assert!((moments.count_for(width, 0.99) / 1000.0 - 1.0).abs() < 1e-9);
        moments.expect(DVec3::splat(5.0));
        assert!((moments.half_width(0.99).x / width - 10.0).abs() < 1e-9);
    }
}
