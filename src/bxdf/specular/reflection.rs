//! A mirror [pbrt 2010, section 8.2.2].

use super::{mirrored, polar};
use crate::bxdf::{Bxdf, BxdfSample, Flags};
use crate::fresnel::Fresnel;
use crate::numerics::quadrature::Bounded;
use crate::parameter::{ParameterError, REFLECTANCE};
use crate::spectrum::{Channels, Spectrum};
use glam::DVec3;

/// f = R F(cos theta_o) delta(wi - R(wo))/|cos theta_i|.
///
/// From below a dielectric Fresnel term sees its indices exchanged, see [`Fresnel::reversed`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SpecularReflection {
    reflectance: Spectrum,
    fresnel: Fresnel,
    /// The Fresnel term from below.
    reversed: Fresnel,
}

impl SpecularReflection {
    /// Reflectance in [0, 1] in every channel, [`REFLECTANCE`]; the Fresnel term was checked when it was made.
    ///
    /// # Errors
    /// [`ParameterError`] outside that range, with the value and the range.
    pub fn new(reflectance: Spectrum, fresnel: Fresnel) -> Result<Self, ParameterError> {
        Ok(Self {
            reflectance: reflectance.check(REFLECTANCE)?,
            fresnel,
            reversed: fresnel.reversed(),
        })
    }

    /// Scale R of the reflected light.
    pub fn reflectance(&self) -> Spectrum {
        self.reflectance
    }

    /// Fresnel term F from above.
    pub fn fresnel(&self) -> &Fresnel {
        &self.fresnel
    }

    /// rho_hd to the given sides at a direction above the surface with cosine `mu`: R F(mu) if `sides` has REFLECTION,
    /// otherwise 0. Exact to the rounding of F.
    pub fn rho_hd(&self, sides: Flags, mu: f64) -> DVec3 {
        if sides.contains(Flags::REFLECTION) {
            self.reflectance.value() * self.fresnel.reflectance(mu)
        } else {
            DVec3::ZERO
        }
    }

    /// rho_hh from above to the given sides with a bound of its rounding error; `None` for conductors, see
    /// [`Fresnel::mean_reflectance`].
    pub fn rho_hh(&self, sides: Flags) -> Option<Bounded> {
        if !sides.contains(Flags::REFLECTION) {
            return Some(Bounded::exact(DVec3::ZERO));
        }
        let mean = self.fresnel.mean_reflectance()?;
        let value = self.reflectance.value() * mean.value;
        Some(Bounded {
            value,
            error: self.reflectance.value() * mean.error + value * f64::EPSILON,
        })
    }
}

impl Bxdf for SpecularReflection {
    fn channels(&self) -> Channels {
        self.reflectance.channels().max(self.fresnel.channels())
    }

    fn flags(&self) -> Flags {
        Flags::REFLECTION | Flags::SPECULAR
    }

    fn f(&self, _: DVec3, _: DVec3) -> DVec3 {
        DVec3::ZERO
    }

    fn pdf(&self, _: DVec3, _: DVec3) -> f64 {
        0.0
    }

    /// The mirror image of wo, with certainty.
    fn sample_f(&self, wo: DVec3, _: [f64; 3]) -> BxdfSample {
        let fresnel = if wo.z < 0.0 { &self.reversed } else { &self.fresnel };
        BxdfSample {
            wi: mirrored(wo),
            pdf: 1.0,
            weight: self.reflectance.value() * fresnel.reflectance_at(polar(wo)),
            flags: self.flags(),
        }
    }
}
