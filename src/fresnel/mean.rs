//! Means of the Fresnel terms over the hemisphere, F_bar = 2 int_0^1 F(mu) mu dmu, where a formula gives them.

use super::Fresnel;
use crate::numerics::quadrature::Bounded;
use glam::DVec3;

impl Fresnel {
    /// F_bar per channel with a bound of its rounding error, or `None` for conductors, whose means want quadrature.
    ///
    /// 1 for [`Fresnel::None`], r0 + (1 - r0)/21 for [`Fresnel::Schlick`], [`dielectric_mean`] for [`Fresnel::Dielectric`].
    pub fn mean_reflectance(&self) -> Option<Bounded> {
        match self {
            Self::None => Some(Bounded::exact(DVec3::ONE)),
            Self::Dielectric { eta } => {
                let means = eta.value().to_array().map(dielectric_mean);
                Some(Bounded {
                    value: DVec3::from_array(means.map(|(value, _)| value)),
                    error: DVec3::from_array(means.map(|(_, error)| error)),
                })
            }
            Self::Schlick { r0 } => {
                // 2 int (1 - mu)^5 mu dmu = 2 B(2, 6) = 1/21; the sum of two terms in [0, 1] makes four roundings
                let value = r0.value() + (DVec3::ONE - r0.value()) / 21.0;
                Some(Bounded {
                    value,
                    error: value * (4.0 * f64::EPSILON),
                })
            }
            Self::Conductor { .. } | Self::ConductorApproximate { .. } => None,
        }
    }
}

/// Bound of the relative rounding error of every term of [`from_rarer_side`]; against 60-digit arithmetic the sum is off by
/// less than a quarter of what this states.
const ROUNDING: f64 = 8.0 * f64::EPSILON;

/// F_bar of a dielectric interface for any relative index eta > 0, and a bound of its rounding error.
///
/// The value keeps its relative precision for matched indices, where F_bar tends to |eta - 1|/3 from the rarer side and to
/// 7 |eta - 1|/3 from the denser one.
pub fn dielectric_mean(eta: f64) -> (f64, f64) {
    if eta >= 1.0 {
        return from_rarer_side(eta, eta - 1.0);
    }
    // What crosses the interface does so in both directions alike: (1 - F_bar(eta)) = eta^2 (1 - F_bar(1/eta)). The first
    // term is what is reflected totally.
    let step = 1.0 - eta;
    let (value, error) = from_rarer_side(eta.recip(), step / eta);
    let total = step * (1.0 + eta);
    (total + eta * eta * value, ROUNDING * total + eta * eta * error)
}

/// 1 - F_bar of a dielectric interface over eta^2 for eta < 1, and 1 - F_bar for eta >= 1, with a bound of its rounding error:
/// what enters the rarer side, which for large and small indices alike keeps the digits that 1 - F_bar would lose.
pub fn dielectric_mean_transmittance(eta: f64) -> (f64, f64) {
    let (mean, error) = if eta >= 1.0 {
        from_rarer_side(eta, eta - 1.0)
    } else {
        from_rarer_side(eta.recip(), (1.0 - eta) / eta)
    };
    (1.0 - mean, error + f64::EPSILON)
}

/// F_bar for n >= 1, given n - 1 with all its digits.
///
/// [Walsh 1926] integrates to
///
/// 1/2 + (n - 1)(3n + 1)/(6 (n + 1)^2) + n^2 (n^2 - 1)^2/(n^2 + 1)^3 ln((n - 1)/(n + 1))
///     - 2 n^3 (n^2 + 2n - 1)/((n^2 + 1)(n^4 - 1)) + 8 n^4 (n^4 + 1)/((n^2 + 1)(n^4 - 1)^2) ln n,
///
/// whose last two terms grow like 1/(n - 1) and cancel. With x = 2 ln n they are
/// 2 n^2/(n^2 + 1) (q(x) - n/(n^2 + 1)) and q(x) = (x cosh x - sinh x)/sinh^2 x, and the part without q joins the 1/2 in
/// (n - 1)(n^3 - 3 n^2 - n - 1)/(2 (n^2 + 1)^2).
fn from_rarer_side(n: f64, step: f64) -> (f64, f64) {
    if step == 0.0 {
        return (0.0, 0.0);
    }
    let square = n * n;
    let sum = square + 1.0;
    let smooth = step / (2.0 * sum * sum);
    let rational = smooth * (((n - 3.0) * n - 1.0) * n - 1.0);
    let rational_size = smooth * (((n + 3.0) * n + 1.0) * n + 1.0);
    let normal = step * (3.0 * n + 1.0) / (6.0 * (n + 1.0) * (n + 1.0));
    // the logarithm of a small number, then that of a number near 1
    let ln_ratio = if n < 3.0 {
        libm::log(step / (n + 1.0))
    } else {
        libm::log1p(-2.0 / (n + 1.0))
    };
    let difference = step * (n + 1.0) / sum;
    let logarithmic = square / sum * difference * difference * ln_ratio;
    let ln = if step < 1.0 { libm::log1p(step) } else { libm::log(n) };
    let hyperbolic = 2.0 * square / sum * q(2.0 * ln);
    (
        rational + normal + logarithmic + hyperbolic,
        ROUNDING * (rational_size + normal - logarithmic + hyperbolic),
    )
}

/// (x cosh x - sinh x)/sinh^2 x for x > 0; x/3 near 0.
fn q(x: f64) -> f64 {
    // sum of 2k x^(2k + 1)/(2k + 1)!; sixteen terms leave 1e-25 at x = 2, beyond which the difference does not cancel
    let numerator = if x < 2.0 {
        let mut power = x;
        (1..=16)
            .map(|k| {
                let even = f64::from(2 * k);
                power *= x * x / (even * (even + 1.0));
                even * power
            })
            .sum()
    } else {
        x * libm::cosh(x) - libm::sinh(x)
    };
    numerator / libm::sinh(x).powi(2)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fresnel::dielectric_at;
    use crate::geometry::Polar;
    use crate::numerics::quadrature::{Piece, integrate_scalar};
    use crate::spectrum::Spectrum;

    /// [Walsh 1926]'s formula in 40-digit arithmetic at the f64 nearest to the index, confirmed there by quadrature.
    #[test]
    fn means_match_40_digits() {
        for (eta, mean) in [
            (1.329, 0.065_772_352_696_136),
            (1.000_29, 9.636_154_319_672_237e-5),
            (2.42, 0.212_540_794_738_842_13),
            (100.0, 0.950_161_171_239_651_4),
            (1e4, 0.999_467_383_504_556_4),
            (0.75, 0.474_882_895_214_688),
            (0.01, 0.999_995_016_117_123_9),
        ] {
            let (value, error) = dielectric_mean(eta);
            assert!((value - mean).abs() <= 0.5 * error, "eta {eta}: {value}, {error:e}");
            assert!(error <= 2e-14 * mean, "eta {eta}: {error:e}"); // the terms are at most ten times their sum
        }
    }

    /// F_bar = 2 int F sin d(sin), split where total reflection begins, against the formula over six decades of eta.
    #[test]
    fn means_match_quadrature() {
        for i in -40..=40 {
            let eta = 10f64.powf(f64::from(i) / 20.0) * if i == 0 { 1.000_001 } else { 1.0 };
            let f = |sin: f64| {
                let cos = ((1.0 - sin) * (1.0 + sin)).sqrt();
                2.0 * sin * dielectric_at(Polar { sin, cos }, eta)
            };
            let refracted = eta.min(1.0);
            let quadrature = integrate_scalar(&[Piece::kinked(0.0, refracted, false, true)], 1e-14, f).unwrap();
            let reference = quadrature.value + (1.0 - refracted) * (1.0 + refracted);
            let (value, error) = dielectric_mean(eta);
            let apart = (value - reference).abs();
            assert!(apart <= error + quadrature.error, "eta {eta}: {apart:e}");
            assert!(apart < 1e-12 && (0.0..=1.0).contains(&value), "eta {eta}: {apart:e}");
        }
    }

    #[test]
    fn nearly_matched_indices_keep_their_digits() {
        for step in [1e-3, 1e-6, 1e-9, f64::EPSILON] {
            let (rarer, _) = dielectric_mean(1.0 + step);
            let (denser, _) = dielectric_mean(1.0 - step);
            let step = (1.0 + step) - 1.0;
            // the next term is of the order step ln(step)
            let next = 10.0 * step * step.ln().abs() + 1e-14;
            assert!((rarer / (step / 3.0) - 1.0).abs() < next, "{step:e}: {rarer:e}");
            assert!((denser / (7.0 * step / 3.0) - 1.0).abs() < next, "{step:e}: {denser:e}");
        }
        assert_eq!(dielectric_mean(1.0), (0.0, 0.0));
    }

    #[test]
    fn other_terms() {
        assert_eq!(Fresnel::None.mean_reflectance().unwrap().value, DVec3::ONE);
        let schlick = Fresnel::schlick(Spectrum::rgb([0.0, 0.04, 1.0])).unwrap();
        let mean = schlick.mean_reflectance().unwrap();
        let quadrature = integrate_scalar(&[Piece::smooth(0.0, 1.0)], 1e-15, |mu| {
            2.0 * mu * schlick.reflectance(mu).y
        })
        .unwrap();
        assert!((mean.value.y - quadrature.value).abs() <= quadrature.error + mean.error.y);
        assert_eq!(mean.value.z, 1.0);
        let rgb = Fresnel::dielectric(Spectrum::rgb([1.0, 1.5, 0.75])).unwrap();
        assert_eq!(rgb.mean_reflectance().unwrap().value.y, dielectric_mean(1.5).0);
        let metal = Fresnel::conductor(Spectrum::grey(0.769), Spectrum::grey(6.08)).unwrap();
        assert!(metal.mean_reflectance().is_none());
    }

    #[test]
    fn the_other_side_of_an_interface() {
        let water = Fresnel::dielectric(Spectrum::grey(1.329)).unwrap();
        assert_eq!(
            water.reversed(),
            Fresnel::dielectric(Spectrum::grey(1.0 / 1.329)).unwrap()
        );
        // the same light crosses in both directions: F is equal at the two angles that Snell's law connects
        let (cos, cos_t) = (0.6_f64, (1.0 - (0.8_f64 / 1.329).powi(2)).sqrt());
        let apart = water.reflectance(cos).x - water.reversed().reflectance(cos_t).x;
        assert!(apart.abs() < 1e-15); // a few roundings of numbers below 0.1
        assert_eq!(Fresnel::None.reversed(), Fresnel::None);
    }
}
