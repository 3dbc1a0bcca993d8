//! Bidirectional scattering functions: one contract, one file per model.
//!
//! [`Bxdf`] is what the Monte Carlo integrators and the statistical tests are generic over, so that tests can supply models
//! that are wrong on purpose. [`Model`] is the closed set that scenes name and that the deterministic integrators know from
//! the inside.

mod adapters;
mod diffuse_specular;
mod error;
mod flags;
mod fresnel_blend;
mod half_angle;
mod irregular;
mod lambertian;
mod layered;
mod microfacet;
mod model;
mod oren_nayar;
mod rough_dielectric;
mod specular;
mod weights;

pub use adapters::{BrdfToBtdf, Scaled, Sum};
pub use diffuse_specular::{CoupledBxdf, Coupling, DiffuseSpecular, SpecularAlbedo};
pub use error::ModelError;
pub use flags::Flags;
pub use fresnel_blend::FresnelBlend;
pub use half_angle::HalfAngle;
pub use irregular::Irregular;
pub use lambertian::Lambertian;
pub use layered::{Layered, Veil, VeiledBxdf};
pub use microfacet::Microfacet;
pub use model::{Model, Needs};
pub use oren_nayar::OrenNayar;
pub use rough_dielectric::{LEAST_BEND, Media, RoughDielectric};
pub use specular::{FresnelSpecular, SpecularReflection, SpecularTransmission, Transport};
pub use weights::{BLOCK, Draws, Lane};

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

impl Sampling {
    /// Every way.
    pub const ALL: [Self; 5] = [Self::Uniform, Self::Cosine, Self::Normals, Self::Visible, Self::Bxdf];
}

/// A direction drawn for the integral int f(wo, wi) |cos theta_i| dwi.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BxdfSample {
    /// The direction drawn; it may lie where f = 0, below the surface for a reflection, and the weight is 0 then.
    pub wi: DVec3,
    /// Its density over solid angle, sr^-1, under the sampling that drew it; for a [`Flags::SPECULAR`] direction the
    /// probability of that direction [pbrt 2016, section 8.2].
    pub pdf: f64,
    /// f |cos theta_i|/pdf, formed with all common factors cancelled, so that it stays finite where f and pdf do not.
    pub weight: DVec3,
    /// The part of the model that the direction belongs to; empty when it belongs to none.
    pub flags: Flags,
}

impl BxdfSample {
    /// A draw that contributes nothing.
    pub(crate) fn lost(wi: DVec3) -> Self {
        Self {
            wi,
            pdf: 0.0,
            weight: DVec3::ZERO,
            flags: Flags::empty(),
        }
    }
}

/// The contract of a scattering model. Directions are unit vectors in the local frame (n = +z), away from the surface.
pub trait Bxdf: Sync {
    /// Number of independent channels of f.
    fn channels(&self) -> Channels;

    /// Sides and sharpness of all its parts.
    fn flags(&self) -> Flags;

    /// f(wo, wi) in sr^-1, without the cosine. Specular parts are deltas, which no pair of directions meets: they count 0.
    fn f(&self, wo: DVec3, wi: DVec3) -> DVec3;

    /// Density with which [`Bxdf::sample_f`] draws `wi`, sr^-1, specular parts not counted.
    fn pdf(&self, wo: DVec3, wi: DVec3) -> f64;

    /// Draws wi for the given wo, u uniform in [0, 1)^3.
    fn sample_f(&self, wo: DVec3, u: [f64; 3]) -> BxdfSample;

    /// Bound of the error that interpolated parts of the model add to rho_hd at cos theta_o = `mu`; 0 for formulae.
    fn albedo_error(&self, _mu: f64) -> DVec3 {
        DVec3::ZERO
    }

    /// Whether [`Bxdf::sample`] can draw in this way and so reach every part of the model.
    fn supports(&self, sampling: Sampling) -> bool {
        match sampling {
            Sampling::Uniform | Sampling::Cosine => !self.flags().contains(Flags::SPECULAR),
            Sampling::Normals | Sampling::Visible => false,
            Sampling::Bxdf => true,
        }
    }

    /// Draws wi in the way asked for. The mean weight over uniform u is rho_hd(wo), of both sides together.
    ///
    /// Samplings that are not supported fall back to [`Bxdf::sample_f`]; ask [`Bxdf::supports`] first.
    fn sample(&self, sampling: Sampling, wo: DVec3, u: [f64; 3]) -> BxdfSample {
        match sampling {
            Sampling::Uniform => sample_uniform(self, wo, u),
            Sampling::Cosine => sample_cosine(self, wo, u),
            Sampling::Normals | Sampling::Visible | Sampling::Bxdf => self.sample_f(wo, u),
        }
    }

    /// How many of the coordinates of u, from the first, [`Bxdf::sample`] looks at.
    fn dimensions(&self, sampling: Sampling) -> usize {
        let both = Flags::REFLECTION | Flags::TRANSMISSION;
        match sampling {
            Sampling::Uniform | Sampling::Cosine if !self.flags().contains(both) => 2,
            _ => 3,
        }
    }

    /// The weights of [`Bxdf::sample`] for many draws, 0 for directions on the other side than `side`, seen from wo:
    /// [`Flags::REFLECTION`] or [`Flags::TRANSMISSION`]. Only the independent channels of `weights` are written.
    ///
    /// A model may override it by something faster that gives the same numbers but for rounding.
    fn weights(&self, sampling: Sampling, side: Flags, draws: Draws<'_>, weights: &mut [Lane; 3]) {
        weights::one_by_one(self, sampling, side, draws, weights);
    }
}

/// Pointers to a model are the model.
macro_rules! point_to_a_bxdf {
    ($($pointer:ty),*) => {$(
impl<B: Bxdf + ?Sized> Bxdf for $pointer {
    fn channels(&self) -> Channels {
        (**self).channels()
    }

    fn flags(&self) -> Flags {
        (**self).flags()
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

    fn albedo_error(&self, mu: f64) -> DVec3 {
        (**self).albedo_error(mu)
    }

    fn supports(&self, sampling: Sampling) -> bool {
        (**self).supports(sampling)
    }

    fn sample(&self, sampling: Sampling, wo: DVec3, u: [f64; 3]) -> BxdfSample {
        (**self).sample(sampling, wo, u)
    }

    fn dimensions(&self, sampling: Sampling) -> usize {
        (**self).dimensions(sampling)
    }

    fn weights(&self, sampling: Sampling, side: Flags, draws: Draws<'_>, weights: &mut [Lane; 3]) {
        (**self).weights(sampling, side, draws, weights);
    }
}
    )*};
}

point_to_a_bxdf!(&B, Box<B>);

/// wi uniform over the hemispheres that the model scatters into, pdf = 1/(2 pi) for one and 1/(4 pi) for two.
fn sample_uniform<B: Bxdf + ?Sized>(bxdf: &B, wo: DVec3, u: [f64; 3]) -> BxdfSample {
    let (wi, share) = on_a_side(bxdf, wo, Polar::from_cos(u[0]).direction(TAU * u[1]), u[2]);
    BxdfSample {
        wi,
        pdf: share / TAU,
        weight: bxdf.f(wo, wi) * (TAU * wi.z.abs() / share),
        flags: bxdf.flags(),
    }
}

/// wi proportional to its cosine over the hemispheres that the model scatters into, pdf = |cos theta|/pi or half of it.
fn sample_cosine<B: Bxdf + ?Sized>(bxdf: &B, wo: DVec3, u: [f64; 3]) -> BxdfSample {
    let (wi, share) = on_a_side(bxdf, wo, cosine_hemisphere([u[0], u[1]]), u[2]);
    BxdfSample {
        wi,
        pdf: wi.z.abs() * FRAC_1_PI * share,
        weight: bxdf.f(wo, wi) * (PI / share),
        flags: bxdf.flags(),
    }
}

/// `above`, a direction of the upper hemisphere, moved to a side that `bxdf` scatters to, and the probability of that side.
fn on_a_side<B: Bxdf + ?Sized>(bxdf: &B, wo: DVec3, above: DVec3, u: f64) -> (DVec3, f64) {
    let flags = bxdf.flags();
    let both = flags.contains(Flags::REFLECTION | Flags::TRANSMISSION);
    let across = if both {
        u < 0.5
    } else {
        !flags.contains(Flags::REFLECTION)
    };
    let wi = if across != (wo.z < 0.0) {
        other_hemisphere(above)
    } else {
        above
    };
    (wi, if both { 0.5 } else { 1.0 })
}

/// `w` reflected in the surface.
pub fn other_hemisphere(w: DVec3) -> DVec3 {
    DVec3::new(w.x, w.y, -w.z)
}

/// Whether the surface lies between two directions; one at the horizon is on both sides of it.
///
/// The sign of wo.z wi.z says the same, unless the product underflows.
pub(crate) fn opposite_sides(wo: DVec3, wi: DVec3) -> bool {
    (wo.z < 0.0 && wi.z > 0.0) || (wo.z > 0.0 && wi.z < 0.0)
}

/// `wi` when it belongs to the side across the surface from `wo`: one at the horizon is moved off it by less than any sum
/// of cosines notices, so that nobody takes it for reflected.
fn across(wo: DVec3, wi: DVec3) -> DVec3 {
    let least = if wo.z < 0.0 {
        f64::MIN_POSITIVE
    } else {
        -f64::MIN_POSITIVE
    };
    if wi.z == 0.0 { DVec3::new(wi.x, wi.y, least) } else { wi }
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
