//! Bidirectional scattering functions: one contract, one file per model.
//!
//! [`Bxdf`] is what the Monte Carlo integrators and the statistical tests are generic over, so that tests can supply models
//! that are wrong on purpose. [`Model`] is the closed set that scenes name and that the deterministic integrators know from
//! the inside.

mod diffuse_specular;
mod lambertian;
mod microfacet;

pub use diffuse_specular::{CoupledBxdf, Coupling, DiffuseSpecular, SpecularAlbedo};
pub use lambertian::Lambertian;
pub use microfacet::Microfacet;

use crate::geometry::Polar;
use crate::spectrum::Channels;
use glam::DVec3;
use std::f64::consts::{FRAC_1_PI, PI, TAU};

/// How directions are drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Sampling {
    /// wi uniform over the hemisphere.
    Uniform,
    /// wi proportional to its cosine.
    Cosine,
    /// Half vectors from p(h) [Mikkelsen 2009, eq. 30 to 33].
    Normals,
    /// Half vectors from the normals that wo sees.
    Visible,
    /// The model's own `sample_f`.
    Bxdf,
}

/// A direction drawn for the integral int f(wo, wi) |cos theta_i| dwi.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BxdfSample {
    /// The direction drawn; it may lie below the surface, where the weight is 0.
    pub wi: DVec3,
    /// Its density over solid angle, sr^-1, under the sampling that drew it.
    pub pdf: f64,
    /// f |cos theta_i|/pdf, formed with all common factors cancelled, so that it stays finite where f and pdf do not.
    pub weight: DVec3,
}

impl BxdfSample {
    /// A draw that contributes nothing.
    pub(crate) fn lost(wi: DVec3) -> Self {
        Self {
            wi,
            pdf: 0.0,
            weight: DVec3::ZERO,
        }
    }
}

/// The contract of a scattering model. Directions are unit vectors in the local frame (n = +z), away from the surface.
pub trait Bxdf: Sync {
    /// Number of independent channels of f.
    fn channels(&self) -> Channels;

    /// f(wo, wi) in sr^-1, without the cosine.
    fn f(&self, wo: DVec3, wi: DVec3) -> DVec3;

    /// Density with which [`Bxdf::sample_f`] draws `wi`, sr^-1.
    fn pdf(&self, wo: DVec3, wi: DVec3) -> f64;

    /// Draws wi for the given wo, u uniform in [0, 1)^3.
    fn sample_f(&self, wo: DVec3, u: [f64; 3]) -> BxdfSample;

    /// Whether [`Bxdf::sample`] can draw in this way.
    fn supports(&self, sampling: Sampling) -> bool {
        !matches!(sampling, Sampling::Normals | Sampling::Visible)
    }

    /// Draws wi in the way asked for. The mean weight over uniform u is rho_hd(wo).
    ///
    /// Samplings that are not supported fall back to [`Bxdf::sample_f`]; ask [`Bxdf::supports`] first.
    fn sample(&self, sampling: Sampling, wo: DVec3, u: [f64; 3]) -> BxdfSample {
        match sampling {
            Sampling::Uniform => sample_uniform(self, wo, u),
            Sampling::Cosine => sample_cosine(self, wo, u),
            Sampling::Normals | Sampling::Visible | Sampling::Bxdf => self.sample_f(wo, u),
        }
    }
}

impl<B: Bxdf + ?Sized> Bxdf for &B {
    fn channels(&self) -> Channels {
        (**self).channels()
    }

    fn f(&self, wo: DVec3, wi: DVec3) -> DVec3 {
        (**self).f(wo, wi)
    }

    fn pdf(&self, wo: DVec3, wi: DVec3) -> f64 {
        (**self).pdf(wo, wi)
    }

    fn sample_f(&self, wo: DVec3, u: [f64; 3]) -> BxdfSample {
        (**self).sample_f(wo, u)
    }

    fn supports(&self, sampling: Sampling) -> bool {
        (**self).supports(sampling)
    }

    fn sample(&self, sampling: Sampling, wo: DVec3, u: [f64; 3]) -> BxdfSample {
        (**self).sample(sampling, wo, u)
    }
}

/// wi uniform over the hemisphere of +z, pdf = 1/(2 pi).
fn sample_uniform<B: Bxdf + ?Sized>(bxdf: &B, wo: DVec3, u: [f64; 3]) -> BxdfSample {
    let wi = Polar::from_cos(u[0]).direction(TAU * u[1]);
    BxdfSample {
        wi,
        pdf: TAU.recip(),
        weight: bxdf.f(wo, wi) * (TAU * wi.z),
    }
}

/// wi proportional to its cosine, pdf = cos theta/pi.
fn sample_cosine<B: Bxdf + ?Sized>(bxdf: &B, wo: DVec3, u: [f64; 3]) -> BxdfSample {
    let wi = cosine_hemisphere([u[0], u[1]]);
    BxdfSample {
        wi,
        pdf: wi.z * FRAC_1_PI,
        weight: bxdf.f(wo, wi) * PI,
    }
}

/// A direction with density cos theta/pi; u in [0, 1)^2.
pub fn cosine_hemisphere(u: [f64; 2]) -> DVec3 {
    // sin^2 theta is uniform
    Polar {
        sin: u[0].sqrt(),
        cos: (1.0 - u[0]).sqrt(),
    }
    .direction(TAU * u[1])
}

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
}
