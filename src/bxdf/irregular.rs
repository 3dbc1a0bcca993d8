//! An isotropic BRDF given by irregularly spaced samples [pbrt 2010, section 8.6.1].

use super::{Bxdf, BxdfSample, Flags, opposite_sides};
use crate::geometry::Polar;
use crate::measured::irregular::{IrregularSamples, remap};
use crate::spectrum::Channels;
use glam::DVec3;
use rayon::prelude::*;
use std::f64::consts::{FRAC_1_PI, PI};
use std::sync::Arc;

/// Cells of the sampling density in mu_o, in sin^2 theta_i and in dphi each: about as wide as the kernel of the lookup.
const CELLS: usize = 32;
/// Share of the draws that follow the cosine alone, so that no direction is rarer than that: a peak that the corners of its
/// cell miss is weighed up to 1/COSINE_SHARE times as much as cosine sampling would.
const COSINE_SHARE: f64 = 0.25;

/// f looked up among measured samples, see [`IrregularSamples::f`]; 0 where the directions are on different sides.
///
/// `sample_f` draws from a piecewise constant density over (sin^2 theta_i, dphi), which the samples themselves determine:
/// with dwi |cos theta_i| = d(sin^2 theta_i) dphi/2 the integrand of rho_hd over these coordinates is f alone. A cell is
/// drawn in proportion to the root of the mean square of f at its corners, mixed with the cosine distribution, which is
/// uniform over these coordinates. For the published files that divides the variance of the cosine alone by 120 to 230 at
/// mu = 0.2, by 25 to 45 at 0.5 and by 1 to 8 at 0.9. A lobe of fixed shape would have to be fitted to every file.
#[derive(Debug, Clone)]
pub struct Irregular {
    data: Arc<IrregularSamples>,
    /// One for every cell of mu_o.
    rows: Arc<[Row]>,
}

/// The cells of one range of mu_o, dphi running fastest.
#[derive(Debug)]
struct Row {
    probability: Vec<f64>,
    /// Their running sums.
    cumulative: Vec<f64>,
}

/// The same data; all else follows from it.
impl PartialEq for Irregular {
    fn eq(&self, other: &Self) -> bool {
        self.data == other.data
    }
}

impl Irregular {
    /// The BRDF of these samples. Looks some 36 000 values up, once, to learn where to draw.
    pub fn new(data: Arc<IrregularSamples>) -> Self {
        // the mean of the squared channels at every corner of every cell
        let corners: Vec<Vec<f64>> = (0..=CELLS)
            .into_par_iter()
            .map(|mu| {
                let wo = Polar::from_cos(mu as f64 / CELLS as f64).direction(0.0);
                let at = |i: usize| {
                    let sin2 = (i / (CELLS + 1)) as f64 / CELLS as f64;
                    let dphi = PI * (i % (CELLS + 1)) as f64 / CELLS as f64;
                    data.f(wo, from_sin2(sin2).direction(dphi)).length_squared()
                };
                (0..(CELLS + 1) * (CELLS + 1)).map(at).collect()
            })
            .collect();
        let rows = corners.windows(2).map(|pair| Row::new(&pair[0], &pair[1])).collect();
        Self { data, rows }
    }

    /// The samples.
    pub fn data(&self) -> &IrregularSamples {
        &self.data
    }

    fn row(&self, wo: DVec3) -> &Row {
        &self.rows[cell(wo.z.abs())]
    }
}

impl Row {
    /// From the squares of f at the corners at both ends of the range of mu_o.
    fn new(low: &[f64], high: &[f64]) -> Self {
        let f: Vec<f64> = (0..CELLS * CELLS)
            .map(|i| {
                let corner = i / CELLS * (CELLS + 1) + i % CELLS;
                let four = |end: &[f64]| {
                    [0, 1, CELLS + 1, CELLS + 2]
                        .map(|step| end[corner + step])
                        .iter()
                        .sum::<f64>()
                };
                (four(low) + four(high)).sqrt()
            })
            .collect();
        let sum: f64 = f.iter().sum();
        let uniform = 1.0 / f.len() as f64;
        let probability: Vec<f64> = f
            .iter()
            .map(|f| {
                if sum > 0.0 {
                    COSINE_SHARE * uniform + (1.0 - COSINE_SHARE) * f / sum
                } else {
                    uniform
                }
            })
            .collect();
        let running = probability.iter().scan(0.0, |sum, p| {
            *sum += p;
            Some(*sum)
        });
        let cumulative = running.collect();
        Self {
            probability,
            cumulative,
        }
    }

    /// Density over the one of cos theta/pi.
    fn ratio(&self, wo: DVec3, wi: DVec3) -> f64 {
        let sin2 = wi.x * wi.x + wi.y * wi.y;
        let [_, dphi, _] = remap(wo, wi);
        self.probability[cell(sin2) * CELLS + cell(dphi)] * (CELLS * CELLS) as f64
    }
}

/// The cell of `x` in [0, 1].
fn cell(x: f64) -> usize {
    ((x * CELLS as f64) as usize).min(CELLS - 1)
}

fn from_sin2(sin2: f64) -> Polar {
    Polar {
        sin: sin2.sqrt(),
        cos: (1.0 - sin2).sqrt(),
    }
}

impl Bxdf for Irregular {
    fn channels(&self) -> Channels {
        self.data.channels()
    }

    fn flags(&self) -> Flags {
        Flags::REFLECTION | Flags::GLOSSY
    }

    fn f(&self, wo: DVec3, wi: DVec3) -> DVec3 {
        if opposite_sides(wo, wi) {
            DVec3::ZERO
        } else {
            self.data.f(wo, wi)
        }
    }

    fn pdf(&self, wo: DVec3, wi: DVec3) -> f64 {
        if opposite_sides(wo, wi) {
            0.0
        } else {
            wi.z.abs() * FRAC_1_PI * self.row(wo).ratio(wo, wi)
        }
    }

    /// u\[0\] chooses the cell and the place of sin^2 theta_i in it, u\[1\] that of dphi, u\[2\] its sign.
    fn sample_f(&self, wo: DVec3, u: [f64; 3]) -> BxdfSample {
        let row = self.row(wo);
        let chosen = row
            .cumulative
            .partition_point(|sum| *sum <= u[0])
            .min(CELLS * CELLS - 1);
        let before = if chosen == 0 { 0.0 } else { row.cumulative[chosen - 1] };
        // u[0] within its cell is uniform again
        let within = ((u[0] - before) / row.probability[chosen]).clamp(0.0, 1.0);
        let sin2 = (((chosen / CELLS) as f64 + within) / CELLS as f64).min(1.0);
        let dphi = PI * ((chosen % CELLS) as f64 + u[1]) / CELLS as f64;
        // a pole has the azimuth of the x axis, as in the lookup
        let azimuth = libm::atan2(wo.y, wo.x);
        let mut wi = from_sin2(sin2).direction(azimuth + if u[2] < 0.5 { dphi } else { -dphi });
        if wo.z < 0.0 {
            wi.z = -wi.z;
        }
        // of the direction as it was rounded, which may have crossed into the next cell
        let ratio = row.ratio(wo, wi);
        BxdfSample {
            wi,
            pdf: wi.z.abs() * FRAC_1_PI * ratio,
            weight: self.data.f(wo, wi) * (PI / ratio),
            flags: self.flags(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bxdf::Sampling;
    use crate::numerics::stream::{Stream, StreamId};

    /// A lobe about the mirror direction over a diffuse base.
    fn lobe() -> Irregular {
        let mut text = String::from("3\n450 550 650\n");
        for (i, j, k) in (0..8).flat_map(|i| (0..8).flat_map(move |j| (0..13).map(move |k| (i, j, k)))) {
            let (theta_i, theta_o, dphi) = (f64::from(i) * 0.2, f64::from(j) * 0.2, f64::from(k) * PI / 12.0);
            let off = (theta_i - theta_o).powi(2) + (dphi - PI).powi(2);
            let f = 0.05 + 2.0 * (-8.0 * off).exp();
            text += &format!("{theta_i:.6} 0 {theta_o:.6} {dphi:.6} {f} {} {}\n", 0.9 * f, 0.8 * f);
        }
        Irregular::new(Arc::new(IrregularSamples::parse("lobe", text.as_bytes()).unwrap()))
    }

    fn stream(cell: u64) -> Stream {
        Stream::new(StreamId {
            seed: 3,
            cell,
            batch: 0,
        })
    }

    fn outgoing() -> Vec<DVec3> {
        let at = |mu, phi| Polar::from_cos(mu).direction(phi);
        vec![
            DVec3::Z,
            at(0.9, 1.0),
            at(0.5, -2.0),
            at(0.2, 3.0),
            -at(0.3, 0.5),
            DVec3::X,
        ]
    }

    #[test]
    fn weights_are_the_quotients_they_stand_for() {
        let bxdf = lobe();
        assert_eq!((bxdf.channels(), bxdf.data().len()), (Channels::Rgb, 832));
        for (i, wo) in (0..).zip(outgoing()) {
            let mut stream = stream(i);
            for _ in 0..2000 {
                let draw = bxdf.sample_f(wo, stream.uniform3());
                assert!((draw.wi.length() - 1.0).abs() < 1e-15 && draw.wi.z * wo.z >= 0.0);
                assert_eq!(draw.pdf, bxdf.pdf(wo, draw.wi));
                let quotient = bxdf.f(wo, draw.wi) * (draw.wi.z.abs() / draw.pdf);
                // the cosine that the weight cancels costs the quotient a few roundings
                assert!((draw.weight - quotient).abs().max_element() <= 1e-14 * quotient.max_element());
                if wo.z != 0.0 && draw.wi.z != 0.0 {
                    assert_eq!(bxdf.f(wo, -draw.wi), DVec3::ZERO);
                    assert_eq!(bxdf.pdf(wo, -draw.wi), 0.0);
                }
            }
        }
    }

    /// Counts in bins that do not line up with the cells, against the integral of the pdf over the hemisphere. Of 6 x 63 bins
    /// the largest deviation, in standard deviations, exceeds 5 in one of 4000 families of right samplers.
    #[test]
    fn draws_follow_the_density() {
        let bxdf = lobe();
        let bin = |wo: DVec3, wi: DVec3| {
            let phi = (wi.y.atan2(wi.x) - wo.y.atan2(wo.x)).rem_euclid(2.0 * PI) / (2.0 * PI);
            ((7.0 * wi.z.abs()) as usize).min(6) * 9 + ((9.0 * phi) as usize).min(8)
        };
        for (i, wo) in (0..).zip(outgoing()) {
            // midpoints of a grid that divides the cells: the density is the same all over each of its meshes
            let (n, m) = (20 * CELLS as u32, 40 * CELLS as u32);
            let mut expected = [0.0; 63];
            for (a, b) in (0..n).flat_map(|a| (0..m).map(move |b| (a, b))) {
                let phi = 2.0 * PI * (f64::from(b) + 0.5) / f64::from(m) + wo.y.atan2(wo.x);
                let mut wi = from_sin2((f64::from(a) + 0.5) / f64::from(n)).direction(phi);
                let cos = wi.z;
                wi.z = wi.z.copysign(wo.z);
                expected[bin(wo, wi)] += bxdf.pdf(wo, wi) / cos * PI / f64::from(n * m);
            }
            // a million roundings
            assert!((expected.iter().sum::<f64>() - 1.0).abs() < 1e-9);
            let draws = 50_000;
            let mut counts = [0.0; 63];
            let mut stream = stream(100 + i);
            for _ in 0..draws {
                counts[bin(wo, bxdf.sample_f(wo, stream.uniform3()).wi)] += 1.0;
            }
            for (count, p) in counts.into_iter().zip(expected) {
                let mean = p * f64::from(draws);
                let deviation: f64 = count - mean;
                // meshes that straddle a border of two bins are a hundredth of either; a count is a whole number
                assert!(
                    deviation.abs() < 5.0 * mean.sqrt() + 1e-2 * mean + 1.0,
                    "{wo} {count} {mean}"
                );
            }
        }
    }

    /// All samplings estimate the same rho_hd; 5 standard errors of the difference.
    #[test]
    fn samplings_agree() {
        let bxdf = lobe();
        for (i, wo) in (0..).zip(outgoing()) {
            let mean = |sampling, cell| {
                let mut stream = stream(cell);
                let draws: Vec<f64> = (0..20_000)
                    .map(|_| bxdf.sample(sampling, wo, stream.uniform3()).weight.x)
                    .collect();
                let n = draws.len() as f64;
                let mean = draws.iter().sum::<f64>() / n;
                (mean, draws.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / n / n)
            };
            let (a, var_a) = mean(Sampling::Bxdf, 200 + i);
            let (b, var_b) = mean(Sampling::Cosine, 300 + i);
            assert!((a - b).abs() < 5.0 * (var_a + var_b).sqrt(), "{wo} {a} {b}");
            assert!(var_a < var_b);
        }
    }
}
