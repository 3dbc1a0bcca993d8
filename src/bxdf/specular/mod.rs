//! Perfectly smooth surfaces: delta distributions, which `sample_f` alone sees [pbrt 2010, section 8.2; pbrt 2016, 8.2].
//!
//! The BRDF is F delta(wi - R(wo))/|cos theta_i|, the BTDF (1 - F) delta(wi - T(wo))/|cos theta_i|. Both are integrated by
//! looking where the delta points, so `f` and `pdf` are 0, `sample_f` returns the direction with its probability as pdf,
//! and in the weight f |cos theta_i|/pdf the cosine has cancelled before it can be 0.

mod fresnel_specular;
mod reflection;
#[cfg(test)]
mod tests;
mod transmission;

pub use fresnel_specular::FresnelSpecular;
pub use reflection::SpecularReflection;
pub use transmission::SpecularTransmission;

use super::across;
use crate::fresnel::{dielectric_at, dielectric_mean, dielectric_mean_transmittance};
use crate::geometry::{Polar, squared_beyond};
use crate::parameter::{ETA_A, ETA_B, ParameterError};
use glam::DVec3;

/// What travels along a path: it decides how light that is refracted is scaled.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Transport {
    /// Radiance, from the light to the eye. Refraction squeezes it into another solid angle: 1 - F is scaled by
    /// (eta_o/eta_i)^2, eta_o the index of the medium of wo. [pbrt 2010, eq. 8.5] prints that ratio; its code has the
    /// inverse.
    Radiance,
    /// Importance, or energy: nothing is scaled, and the albedos of both sides add up to 1 where nothing is absorbed.
    #[default]
    Importance,
}

impl Transport {
    /// The name in scene files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Radiance => "radiance",
            Self::Importance => "importance",
        }
    }

    /// The mode called `name`, if there is one.
    pub fn from_name(name: &str) -> Option<Self> {
        [Self::Radiance, Self::Importance]
            .into_iter()
            .find(|transport| transport.name() == name)
    }
}

/// The mirror image of `wo` about the surface normal.
fn mirrored(wo: DVec3) -> DVec3 {
    DVec3::new(-wo.x, -wo.y, wo.z)
}

/// The polar angle of `w` on its own side of the surface.
fn polar(w: DVec3) -> Polar {
    Polar::of(w.with_z(w.z.abs()))
}

/// The surface between two dielectrics, medium a above it and medium b below. A direction at the horizon counts as above.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Interface {
    pub(super) eta_a: f64,
    pub(super) eta_b: f64,
    pub(super) transport: Transport,
}

impl Interface {
    pub(super) fn new(eta_a: f64, eta_b: f64, transport: Transport) -> Result<Self, ParameterError> {
        Ok(Self {
            eta_a: ETA_A.check(eta_a)?,
            eta_b: ETA_B.check(eta_b)?,
            transport,
        })
    }

    /// The same with importance transport.
    pub(super) fn accounted(self) -> Self {
        Self {
            transport: Transport::Importance,
            ..self
        }
    }

    /// Index of the far side over that of the side of `wo`, in [1e-4, 1e4].
    pub(super) fn relative_eta(&self, wo: DVec3) -> f64 {
        if wo.z < 0.0 {
            self.eta_a / self.eta_b
        } else {
            self.eta_b / self.eta_a
        }
    }

    /// F for light that leaves along `wo`.
    fn reflectance(&self, wo: DVec3) -> f64 {
        dielectric_at(polar(wo), self.relative_eta(wo))
    }

    /// The direction from which light is refracted into `wo`; `None` under total internal reflection.
    ///
    /// By Snell's law its tangential part is that of -wo over eta. Its cosine is sqrt(eta^2 - sin^2)/eta with the square
    /// that the Fresnel term uses, so that both agree on where total reflection begins.
    fn refracted(&self, wo: DVec3) -> Option<DVec3> {
        let eta = self.relative_eta(wo);
        if eta == 1.0 {
            return Some(across(wo, -wo));
        }
        let square = squared_beyond(polar(wo), eta);
        if square <= 0.0 {
            return None;
        }
        let cos = square.sqrt() / eta;
        let z = if wo.z < 0.0 { cos } else { -cos };
        Some(DVec3::new(-wo.x / eta, -wo.y / eta, z))
    }

    /// What transport multiplies 1 - F by: (eta_o/eta_i)^2 for radiance.
    pub(super) fn scale(&self, wo: DVec3) -> f64 {
        match self.transport {
            Transport::Radiance => self.relative_eta(wo).powi(-2),
            Transport::Importance => 1.0,
        }
    }

    /// F at a direction above the surface with cosine `mu`.
    fn reflectance_above(&self, mu: f64) -> f64 {
        dielectric_at(Polar::from_cos(mu), self.relative_eta(DVec3::Z))
    }

    /// Cosine-weighted mean of F over the directions above the surface, with a bound of its rounding error, which counts
    /// the rounding of the quotient of both indices: eta dF_bar/deta is 7/3 at most.
    fn mean_reflectance_above(&self) -> (f64, f64) {
        let (mean, error) = dielectric_mean(self.relative_eta(DVec3::Z));
        (mean, error + 7.0 / 6.0 * f64::EPSILON)
    }

    /// Cosine-weighted mean of 1 - F over the directions above the surface, scaled as transport has it, with a bound of its
    /// rounding error. Below a denser medium 1 - F_bar is eta^2 times what crosses the other way, and radiance is scaled by
    /// its inverse: neither is formed from the other, whose digits a small eta would take.
    fn mean_transmittance_above(&self) -> (f64, f64) {
        let eta = self.relative_eta(DVec3::Z);
        let (mean, error) = dielectric_mean_transmittance(eta);
        let scale = match self.transport {
            Transport::Radiance if eta < 1.0 => 1.0,
            Transport::Radiance => self.scale(DVec3::Z),
            Transport::Importance if eta < 1.0 => eta * eta,
            Transport::Importance => 1.0,
        };
        // the rounding of the quotient of the indices counts as above, and twice in its square
        (mean * scale, scale * (error + (7.0 / 6.0 + 2.0) * f64::EPSILON))
    }
}
