//! The closed set of models that scenes name.

use super::{Bxdf, DiffuseSpecular, Flags, Lambertian, Microfacet};
use crate::spectrum::Channels;

/// The models that a scene can name.
#[derive(Debug, Clone, PartialEq)]
pub enum Model {
    /// Ideal diffuse reflection.
    Lambertian(Lambertian),
    /// Microfacet reflection.
    Microfacet(Microfacet),
    /// A specular lobe over a diffuse base.
    DiffuseSpecular(Box<DiffuseSpecular>),
}

impl Model {
    /// Number of independent channels of f.
    pub fn channels(&self) -> Channels {
        match self {
            Self::Lambertian(lambertian) => lambertian.channels(),
            Self::Microfacet(microfacet) => microfacet.channels(),
            Self::DiffuseSpecular(coupled) => coupled.channels(),
        }
    }

    /// Sides and sharpness of all its parts.
    pub fn flags(&self) -> Flags {
        match self {
            Self::Lambertian(lambertian) => lambertian.flags(),
            Self::Microfacet(microfacet) => microfacet.flags(),
            Self::DiffuseSpecular(coupled) => coupled.specular().flags() | Flags::REFLECTION | Flags::DIFFUSE,
        }
    }

    /// Whether rho_hd depends on the azimuth. It is then the same at phi, -phi and pi - phi.
    pub fn is_anisotropic(&self) -> bool {
        match self {
            Self::Lambertian(_) => false,
            Self::Microfacet(microfacet) => microfacet.distribution.isotropic().is_none(),
            Self::DiffuseSpecular(coupled) => coupled.specular().is_anisotropic(),
        }
    }

    /// Whether f jumps between irregular samples, so that only Monte Carlo integrates it.
    pub fn is_irregular(&self) -> bool {
        match self {
            Self::Lambertian(_) | Self::Microfacet(_) => false,
            Self::DiffuseSpecular(coupled) => coupled.specular().is_irregular(),
        }
    }

    /// A typical width of its narrowest lobe in radians; layers of rho_hd at grazing angles are as thin.
    pub fn width(&self) -> f64 {
        match self {
            Self::Lambertian(_) => 1.0,
            Self::Microfacet(microfacet) => microfacet.distribution.width(),
            Self::DiffuseSpecular(coupled) => coupled.specular().width(),
        }
    }
}
