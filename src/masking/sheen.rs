//! Maskings of facets that stand off the surface.

use super::{Cosines, Masking};
use crate::distribution::{Distribution, Isotropic};

impl Masking {
    /// V'/(4 (n.o)(n.i)) of the sheen terms; symmetric in both directions to the last bit.
    ///
    /// Other terms, and other distributions than Charlie, have none: [`crate::bxdf::Microfacet::new`] refuses such pairs, and
    /// here they mask everything.
    pub(super) fn sheen(self, distribution: &Distribution, cos: Cosines) -> f64 {
        let Distribution::Isotropic(Isotropic::Charlie(charlie)) = distribution else {
            return 0.0;
        };
        match self {
            Self::Neubelt => neubelt(cos.o, cos.i),
            Self::Charlie => Fit::new(charlie.alpha()).visibility(cos.o, cos.i),
            Self::None | Self::VGroove | Self::Smith | Self::SmithCorrelated => 0.0,
        }
    }
}

/// 1/(4 (n.o + n.i - (n.o)(n.i))) [Ashikhmin and Premoze 2007; Neubelt and Pettineo 2013].
pub(crate) fn neubelt(cos_o: f64, cos_i: f64) -> f64 {
    0.25 / (cos_o + cos_i - cos_o * cos_i)
}

/// Lambda of Charlie for one alpha: e^l(x) for x = cos theta below 1/2, e^(2 l(1/2) - l(1 - x)) above, with
/// l(x) = a/(1 + b x^c) + d x + e. The five parameters go from those of alpha = 1 to those of alpha = 0 with
/// (1 - alpha)^2 [Estevez and Kulla 2017, section 3].
///
/// Every Lambda of a rough surface grows like 1/x at the horizon, so that as much of it is hidden from there as is seen. The
/// fit grows faster and then, below some x = 5e-5, more slowly, to the finite e^17 or e^20, of which the albedo would be
/// infinite. From the x where it has just grown as fast as 1/x it is continued like that.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Fit {
    a: f64,
    b: f64,
    c: f64,
    d: f64,
    e: f64,
    /// The x from which on the fit holds, and x Lambda(x) there.
    least: f64,
    grazing: f64,
}

impl Fit {
    pub(crate) fn new(alpha: f64) -> Self {
        let share = (1.0 - alpha) * (1.0 - alpha);
        let between = |widest: f64, narrowest: f64| widest + (narrowest - widest) * share;
        let mut fit = Self {
            a: between(21.5473, 25.3245),
            b: between(3.82987, 3.32435),
            c: between(0.19823, 0.16801),
            d: between(-1.97760, -1.27393),
            e: between(-4.32054, -4.85967),
            least: 0.0,
            grazing: 0.0,
        };
        // x l'(x) = -1, but for d x: a b c u = (1 + b u)^2 with u = x^c
        let (b, half) = (fit.b, 0.5 * fit.a * fit.b * fit.c - fit.b);
        let u = 1.0 / (half + (half * half - b * b).sqrt());
        fit.least = libm::pow(u, fit.c.recip());
        fit.grazing = fit.least * libm::exp(fit.exponent(fit.least));
        fit
    }

    /// The x below which Lambda is continued like 1/x.
    pub(crate) fn least(&self) -> f64 {
        self.least
    }

    /// l(x)
    fn exponent(&self, x: f64) -> f64 {
        self.a / (1.0 + self.b * libm::pow(x, self.c)) + self.d * x + self.e
    }

    /// (n.w) Lambda(w) at n.w = `cos` in [0, 1], finite at the horizon.
    pub(crate) fn hidden(&self, cos: f64) -> f64 {
        if cos < self.least {
            return self.grazing;
        }
        let exponent = if cos < HALF {
            self.exponent(cos)
        } else {
            2.0 * self.exponent(HALF) - self.exponent((1.0 - cos).max(0.0))
        };
        cos * libm::exp(exponent)
    }

    /// G/(4 (n.o)(n.i)) with G = 1/(1 + Lambda(o) + Lambda(i)), finite with one direction at the horizon.
    pub(crate) fn visibility(&self, cos_o: f64, cos_i: f64) -> f64 {
        0.25 / (cos_o * cos_i + (cos_i * self.hidden(cos_o) + cos_o * self.hidden(cos_i)))
    }
}

/// Where both branches of the fit meet, with one slope and two curvatures.
pub(crate) const HALF: f64 = 0.5;

#[cfg(test)]
mod tests {
    use super::*;

    /// Values of the published formula by Python's `math`, at both ends of alpha and on both branches.
    #[test]
    fn lambda_is_the_published_fit() {
        for (alpha, cos, value) in LAMBDAS {
            let found = Fit::new(alpha).hidden(cos) / cos;
            // some roundings of an exponent of up to 20
            assert!((found / value - 1.0).abs() < 1e-13, "{alpha} {cos}: {found:e}");
        }
    }

    const LAMBDAS: [(f64, f64, f64); 12] = [
        (0.001, 0.0001, 21388.014566697868),
        (0.001, 0.1, 16.184051479426866),
        (0.001, 0.75, 1.0060119117523263),
        (0.001, 1.0, 7.844122551577297e-09),
        (0.25, 0.0001, 14302.110773909402),
        (0.25, 0.1, 10.117027367759391),
        (0.25, 0.75, 0.52852512832145),
        (0.25, 1.0, 1.0150832592808307e-08),
        (1.0, 0.0001, 8143.610591415992),
        (1.0, 0.1, 5.873188816822575),
        (1.0, 0.75, 0.25125093603879006),
        (1.0, 1.0, 1.6636573530025296e-08),
    ];

    /// Both branches meet, and Lambda falls from the horizon to the normal, where sight is free.
    #[test]
    fn lambda_falls_towards_the_normal() {
        for alpha in [1e-3, 0.01, 0.25, 1.0] {
            let fit = Fit::new(alpha);
            let at = |cos: f64| fit.hidden(cos) / cos;
            let values: Vec<f64> = (1..=1000).map(|i| at(f64::from(i) / 1000.0)).collect();
            assert!(values.windows(2).all(|w| w[1] < w[0]), "{alpha}");
            assert!(values[999] < 1e-5, "{alpha}: {}", values[999]);
        }
    }

    /// Where the fit is left behind it has the slope of what takes its place, all below what a lookup of mu resolves.
    #[test]
    fn lambda_has_a_pole_at_the_horizon() {
        for alpha in [1e-3, 0.01, 0.25, 1.0] {
            let fit = Fit::new(alpha);
            assert!(fit.least > 1e-5 && fit.least < 1e-4, "{alpha}: {}", fit.least);
            for step in [1e-6, 1e-4, 1e-2] {
                let change = fit.hidden(fit.least * (1.0 + step)) / fit.hidden(0.0) - 1.0;
                // the slope that is left is d x, 2e-4 at most; the curvature is below 1
                assert!(change.abs() < step * (2e-4 + step), "{alpha} {step}: {change:e}");
            }
        }
    }

    #[test]
    fn neubelt_has_its_limits() {
        assert_eq!(neubelt(1.0, 1.0), 0.25);
        assert_eq!(neubelt(1.0, 0.0), 0.25);
        assert_eq!(neubelt(0.0, 0.5), 0.5);
        assert_eq!(neubelt(0.3, 0.7).to_bits(), neubelt(0.7, 0.3).to_bits());
    }
}
