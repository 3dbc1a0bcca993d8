//! Distributions of normals that are isotropic about the surface normal, with one roughness parameter each.
//!
//! The handle of the integrators is the *exposure* E(theta) = -ln(1 - P(theta)), with P the distribution function of the
//! polar angle. E is the standard exponential variate of the distribution: for all families it is elementary, its inverse
//! is too, and both keep all digits from the pole (E -> 0) to the far tail (E -> infinity). Inverse-CDF sampling is
//! theta(-ln(1 - u)); the deterministic integrators use q = sqrt(2 E), in which every lobe has the weight q exp(-q^2/2)
//! whatever its width.

use super::{Beckmann, Charlie, Ggx, Phong, Vmf};
use crate::geometry::Polar;
use crate::parameter::{Legal, ParameterError};
use glam::DVec3;
use std::f64::consts::TAU;

/// A distribution of microfacet normals that depends on their polar angle alone.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Isotropic {
    /// von Mises-Fisher, renormalised to the hemisphere.
    Vmf(Vmf),
    /// Beckmann.
    Beckmann(Beckmann),
    /// Normalised Phong, also called Blinn.
    Phong(Phong),
    /// GGX, also called Trowbridge-Reitz.
    Ggx(Ggx),
    /// Charlie, of facets that stand off the surface.
    Charlie(Charlie),
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
    /// GGX with slope alpha.
    Ggx,
    /// Charlie with spread alpha.
    Charlie,
}

impl Family {
    /// Every family.
    pub const ALL: [Self; 5] = [Self::Vmf, Self::Beckmann, Self::Phong, Self::Ggx, Self::Charlie];

    /// The member of the family with the given roughness parameter: kappa in [0, 1e12] for vMF, the slopes m and alpha in
    /// [1e-6, 10] for Beckmann and GGX, n in [0, 1e8] for Phong, alpha in [1e-3, 1] for Charlie; see [`Family::legal`].
    ///
    /// # Errors
    /// [`ParameterError`] outside that range, with the value and the range.
    pub fn with(self, roughness: f64) -> Result<Isotropic, ParameterError> {
        Ok(match self {
            Self::Vmf => Isotropic::Vmf(Vmf::new(roughness)?),
            Self::Beckmann => Isotropic::Beckmann(Beckmann::new(roughness)?),
            Self::Phong => Isotropic::Phong(Phong::new(roughness)?),
            Self::Ggx => Isotropic::Ggx(Ggx::new(roughness)?),
            Self::Charlie => Isotropic::Charlie(Charlie::new(roughness)?),
        })
    }

    /// Name and legal range of the roughness parameter.
    pub fn legal(self) -> Legal {
        match self {
            Self::Vmf => crate::parameter::KAPPA,
            Self::Beckmann => crate::parameter::BECKMANN_M,
            Self::Phong => crate::parameter::PHONG_N,
            Self::Ggx => crate::parameter::GGX_ALPHA,
            Self::Charlie => crate::parameter::CHARLIE_ALPHA,
        }
    }

    /// Name as it stands in a scene file.
    pub fn name(self) -> &'static str {
        match self {
            Self::Vmf => "vmf",
            Self::Beckmann => "beckmann",
            Self::Phong => "phong",
            Self::Ggx => "ggx",
            Self::Charlie => "charlie",
        }
    }
}

macro_rules! each {
    ($self:expr, $d:ident => $body:expr) => {
        match $self {
            Isotropic::Vmf($d) => $body,
            Isotropic::Beckmann($d) => $body,
            Isotropic::Phong($d) => $body,
            Isotropic::Ggx($d) => $body,
            Isotropic::Charlie($d) => $body,
        }
    };
}

impl Isotropic {
    /// The family that it is a member of.
    pub fn family(&self) -> Family {
        match self {
            Self::Vmf(_) => Family::Vmf,
            Self::Beckmann(_) => Family::Beckmann,
            Self::Phong(_) => Family::Phong,
            Self::Ggx(_) => Family::Ggx,
            Self::Charlie(_) => Family::Charlie,
        }
    }

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

    /// The polar angle at which the exposure is `exposure`, the inverse of [`Isotropic::exposure`].
    pub fn at_exposure(&self, exposure: f64) -> Polar {
        each!(self, d => d.at_exposure(exposure))
    }

    /// P(theta), the probability that a normal lies within theta of the pole.
    pub fn cdf(&self, theta: Polar) -> f64 {
        -libm::expm1(-self.exposure(theta))
    }

    /// The angle theta with P(theta) = u, for u in [0, 1).
    pub fn inverse_cdf(&self, u: f64) -> Polar {
        self.at_exposure(-libm::log1p(-u))
    }

    /// A normal drawn from p(h); u in [0, 1)^2.
    pub fn sample(&self, u: [f64; 2]) -> DVec3 {
        self.inverse_cdf(u[0]).direction(TAU * u[1])
    }

    /// A typical width of the lobe in radians: the median angle of its facets from the pole, or from the horizon where they
    /// stand off the surface.
    pub fn width(&self) -> f64 {
        let median = self.inverse_cdf(0.5);
        match self {
            Self::Charlie(_) => libm::atan2(median.cos, median.sin),
            _ => median.angle(),
        }
    }
}
