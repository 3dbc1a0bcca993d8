//! Distributions of microfacet normals, isotropic about the surface normal.
//!
//! Every distribution is handled through its density over solid angle p(h) = D(h) (n.h) [Mikkelsen 2009, eq. 17], which
//! integrates to 1 over the hemisphere, and never through D alone: D = p/(n.h) diverges at the horizon.
//!
//! The second handle is the *exposure* E(theta) = -ln(1 - P(theta)), with P the distribution function of the polar angle.
//! E is the standard exponential variate of the distribution: for the three families it is elementary, its inverse is too,
//! and both keep all digits from the pole (E -> 0) to the far tail (E -> infinity). Inverse-CDF sampling is
//! theta(-ln(1 - u)); the deterministic integrator uses q = sqrt(2 E), in which every lobe has the weight q exp(-q^2/2)
//! whatever its width.

mod beckmann;
mod phong;
mod vmf;

pub use beckmann::Beckmann;
pub use phong::Phong;
pub use vmf::Vmf;

use crate::geometry::Polar;
use crate::parameter::{Legal, ParameterError};
use glam::DVec3;
use std::f64::consts::TAU;

/// A distribution of microfacet normals.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Distribution {
    /// von Mises-Fisher, renormalised to the hemisphere.
    Vmf(Vmf),
    /// Beckmann.
    Beckmann(Beckmann),
    /// Normalised Phong, also called Blinn.
    Phong(Phong),
}

/// The families of distributions, each with one roughness parameter.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Family {
    /// von Mises-Fisher with concentration kappa.
    Vmf,
    /// Beckmann with slope m.
    Beckmann,
    /// Normalised Phong with exponent n.
    Phong,
}

impl Family {
    /// The member of the family with the given roughness parameter.
    ///
    /// # Errors
    /// [`ParameterError`] outside [`Family::legal`].
    pub fn with(self, roughness: f64) -> Result<Distribution, ParameterError> {
        Ok(match self {
            Self::Vmf => Distribution::Vmf(Vmf::new(roughness)?),
            Self::Beckmann => Distribution::Beckmann(Beckmann::new(roughness)?),
            Self::Phong => Distribution::Phong(Phong::new(roughness)?),
        })
    }

    /// Name and legal range of the roughness parameter.
    pub fn legal(self) -> Legal {
        match self {
            Self::Vmf => crate::parameter::KAPPA,
            Self::Beckmann => crate::parameter::BECKMANN_M,
            Self::Phong => crate::parameter::PHONG_N,
        }
    }

    /// Name as it stands in a scene file.
    pub fn name(self) -> &'static str {
        match self {
            Self::Vmf => "vmf",
            Self::Beckmann => "beckmann",
            Self::Phong => "phong",
        }
    }
}

macro_rules! each {
    ($self:expr, $d:ident => $body:expr) => {
        match $self {
            Distribution::Vmf($d) => $body,
            Distribution::Beckmann($d) => $body,
            Distribution::Phong($d) => $body,
        }
    };
}

impl Distribution {
    /// Density of normals over solid angle, p(theta) in sr^-1; int p dh = 1 over the hemisphere.
    pub fn p(&self, theta: Polar) -> f64 {
        each!(self, d => d.p(theta))
    }

    /// The distribution of eq. 14, D = p/(n.h) in sr^-1; int D (n.h) dh = 1. It may be infinite at the horizon.
    pub fn d(&self, theta: Polar) -> f64 {
        each!(self, d => d.d(theta))
    }

    /// Exposure E(theta) = -ln(1 - P(theta)) in [0, infinity].
    pub fn exposure(&self, theta: Polar) -> f64 {
        each!(self, d => d.exposure(theta))
    }

    /// The polar angle at which the exposure is `exposure`, the inverse of [`Distribution::exposure`].
    pub fn at_exposure(&self, exposure: f64) -> Polar {
        each!(self, d => d.at_exposure(exposure))
    }

    /// P(theta), the probability that a normal lies within theta of the pole.
    pub fn cdf(&self, theta: Polar) -> f64 {
        -(-self.exposure(theta)).exp_m1()
    }

    /// The angle theta with P(theta) = u, for u in [0, 1).
    pub fn inverse_cdf(&self, u: f64) -> Polar {
        self.at_exposure(-(-u).ln_1p())
    }

    /// A normal drawn from p(h); u in [0, 1)^2.
    pub fn sample(&self, u: [f64; 2]) -> DVec3 {
        self.inverse_cdf(u[0]).direction(TAU * u[1])
    }

    /// A typical polar angle of the lobe in radians: the median of P.
    pub fn width(&self) -> f64 {
        self.inverse_cdf(0.5).angle()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numerics::quadrature::{Piece, integrate_scalar};

    fn all() -> Vec<Distribution> {
        let mut all = Vec::new();
        for kappa in [0.0, 1e-17, 1e-9, 1e-3, 0.5, 1.0, 17.0, 720.0, 1e5, 1e12] {
            all.push(Family::Vmf.with(kappa).unwrap());
        }
        for m in [1e-6, 1e-3, 0.2, 1.0, 10.0] {
            all.push(Family::Beckmann.with(m).unwrap());
        }
        for n in [0.0, 1e-6, 1.0, 48.0, 1e4, 1e8] {
            all.push(Family::Phong.with(n).unwrap());
        }
        all
    }

    /// Eq. 14: int D cos dh = 2 pi int p sin dtheta = 1, by quadrature of the density itself over the bulk and the tail.
    #[test]
    fn densities_integrate_to_one() {
        for d in all() {
            // panels between quantiles resolve any width; the tail beyond E = 40 holds 4e-18
            let angles: Vec<f64> = [0.0, 0.01, 0.1, 0.5, 1.0, 2.0, 4.0, 8.0, 16.0, 40.0]
                .iter()
                .map(|e| d.at_exposure(*e).angle())
                .collect();
            let pieces: Vec<Piece> = angles
                .windows(2)
                .filter(|w| w[1] > w[0])
                .map(|w| Piece::smooth(w[0], w[1]))
                .collect();
            let total = integrate_scalar(&pieces, 1e-12, |theta| {
                let polar = Polar::from_angle(theta);
                TAU * d.p(polar) * polar.sin
            })
            .unwrap();
            assert!((total.value - 1.0).abs() < 1e-11, "{d:?}: {total:?}"); // twice the tolerance and rounding of angles
            assert!(d.d(Polar::POLE) == d.p(Polar::POLE));
        }
    }

    /// The density is the derivative of the CDF: 2 pi sin theta p = exp(-E) dE/dtheta.
    #[test]
    fn exposure_and_its_inverse_agree_from_pole_to_tail() {
        for d in all() {
            let mut previous = -1.0;
            for exponent in -40..=12 {
                let e = 2f64.powi(exponent) * 0.01;
                let polar = d.at_exposure(e);
                assert!((polar.sin.hypot(polar.cos) - 1.0).abs() < 1e-15);
                let back = d.exposure(polar);
                if polar.cos > 0.0 {
                    // where E is almost log cos, cos carries E as an exponent: rounding grows with E
                    assert!(
                        (back - e).abs() <= 1e-14 * e * (1.0 + e),
                        "{d:?}: E {e} came back as {back}"
                    );
                }
                let theta = polar.angle();
                assert!(theta >= previous, "{d:?}: not monotone at E {e}");
                previous = theta;
            }
        }
    }

    #[test]
    fn exposure_covers_the_hemisphere() {
        for d in all() {
            assert_eq!(d.exposure(Polar::POLE), 0.0);
            assert_eq!(d.exposure(Polar { sin: 1.0, cos: 0.0 }), f64::INFINITY, "{d:?}");
            assert_eq!(d.inverse_cdf(0.0), Polar::POLE);
            assert!((d.cdf(d.inverse_cdf(0.25)) - 0.25).abs() < 1e-15);
        }
    }

    #[test]
    fn parameters_outside_the_legal_range_are_refused() {
        for (family, values) in [
            (Family::Vmf, [-1.0, 1.1e12, f64::NAN]),
            (Family::Beckmann, [0.0, 10.1, f64::INFINITY]),
            (Family::Phong, [-1e-9, 1.1e8, f64::NAN]),
        ] {
            for value in values {
                assert!(family.with(value).is_err(), "{family:?} {value}");
            }
        }
    }
}
