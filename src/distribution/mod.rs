//! Distributions of microfacet normals.
//!
//! Every distribution is handled through its density over solid angle p(h) = D(h) (n.h) [Mikkelsen 2009, eq. 17], which
//! integrates to 1 over the hemisphere, and never through D alone: D = p/(n.h) diverges at the horizon.
//!
//! A normal is a function of two standard variates, the exposure E of its polar angle (see [`Isotropic`]), exponentially
//! distributed, and an angle psi, uniform over the circle, from which the azimuth follows (see [`Anisotropic`]):
//! int p(h) W(h) dh = (1/2 pi) int dpsi int_0^inf e^-E W(h(E, psi)) dE, for every distribution alike.

mod anisotropic;
mod beckmann;
mod charlie;
mod ggx;
mod isotropic;
pub(crate) mod lanes;
mod phong;
#[cfg(test)]
mod tests;
mod vmf;

pub use anisotropic::{Anisotropic, Elliptic};
pub use beckmann::Beckmann;
pub use charlie::Charlie;
pub use ggx::Ggx;
pub use isotropic::{Family, Isotropic};
pub use phong::Phong;
pub use vmf::Vmf;

use crate::geometry::{Polar, at_azimuth, azimuth_of};
use glam::{DVec2, DVec3};
use std::f64::consts::TAU;

/// A distribution of microfacet normals.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Distribution {
    /// The same along every azimuth.
    Isotropic(Isotropic),
    /// Symmetric about both tangents.
    Anisotropic(Anisotropic),
}

impl From<Isotropic> for Distribution {
    fn from(isotropic: Isotropic) -> Self {
        Self::Isotropic(isotropic)
    }
}

impl From<Anisotropic> for Distribution {
    fn from(anisotropic: Anisotropic) -> Self {
        Self::Anisotropic(anisotropic)
    }
}

impl Distribution {
    /// Name as it stands in a scene file.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Isotropic(isotropic) => isotropic.family().name(),
            Self::Anisotropic(anisotropic) => anisotropic.kind().name(),
        }
    }

    /// Density of normals over solid angle at the unit vector `h` of the upper hemisphere, in sr^-1; int p dh = 1.
    pub fn p(&self, h: DVec3) -> f64 {
        self.times_weight(h, Isotropic::p)
    }

    /// The distribution of eq. 14, D = p/(n.h) in sr^-1; int D (n.h) dh = 1. It may be infinite at the horizon.
    pub fn d(&self, h: DVec3) -> f64 {
        self.times_weight(h, Isotropic::d)
    }

    fn times_weight(&self, h: DVec3, density: fn(&Isotropic, Polar) -> f64) -> f64 {
        match self {
            Self::Isotropic(isotropic) => density(isotropic, Polar::of(h)),
            Self::Anisotropic(anisotropic) => {
                // the pole is approached from every azimuth with the same limit
                let azimuth = azimuth_of(h);
                density(&anisotropic.along(azimuth), Polar::of(h)) * anisotropic.azimuth_weight(azimuth)
            }
        }
    }

    /// A normal drawn from p(h); u in [0, 1)^2.
    pub fn sample(&self, u: [f64; 2]) -> DVec3 {
        match self {
            Self::Isotropic(isotropic) => isotropic.sample(u),
            Self::Anisotropic(anisotropic) => {
                let azimuth = anisotropic.azimuth(TAU * u[1]);
                let theta = anisotropic.along(azimuth).inverse_cdf(u[0]);
                (azimuth * theta.sin).extend(theta.cos)
            }
        }
    }

    /// The distribution when it depends on the polar angle alone.
    pub fn isotropic(&self) -> Option<&Isotropic> {
        match self {
            Self::Isotropic(isotropic) => Some(isotropic),
            Self::Anisotropic(_) => None,
        }
    }

    /// The profile along the unit vector `azimuth`.
    pub fn along(&self, azimuth: DVec2) -> Isotropic {
        match self {
            Self::Isotropic(isotropic) => *isotropic,
            Self::Anisotropic(anisotropic) => anisotropic.along(azimuth),
        }
    }

    /// The azimuth whose share of the normals before it is psi/(2 pi).
    pub fn azimuth(&self, psi: f64) -> DVec2 {
        match self {
            Self::Isotropic(_) => at_azimuth(psi),
            Self::Anisotropic(anisotropic) => anisotropic.azimuth(psi),
        }
    }

    /// A typical width of the lobe in radians, along the tangent where it is narrower, see [`Isotropic::width`].
    pub fn width(&self) -> f64 {
        match self {
            Self::Isotropic(isotropic) => isotropic.width(),
            Self::Anisotropic(anisotropic) => {
                let [x, y] = [DVec2::X, DVec2::Y].map(|tangent| anisotropic.along(tangent).width());
                x.min(y)
            }
        }
    }
}
