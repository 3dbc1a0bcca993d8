//! Ideal diffuse reflection [Mikkelsen 2009, eq. 26; pbrt 2010, section 8.3].

use super::{Bxdf, BxdfSample, Flags, cosine_hemisphere, opposite_sides};
use crate::parameter::{ParameterError, REFLECTANCE};
use crate::spectrum::{Channels, Spectrum};
use glam::DVec3;
use std::f64::consts::FRAC_1_PI;

/// f = R/pi, so that rho_hd = rho_hh = R.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Lambertian {
    reflectance: Spectrum,
}

impl Lambertian {
    /// Reflectance in [0, 1] in every channel, [`REFLECTANCE`].
    ///
    /// # Errors
    /// [`ParameterError`] outside that range, with the value and the range.
    pub fn new(reflectance: Spectrum) -> Result<Self, ParameterError> {
        Ok(Self {
            reflectance: reflectance.check(REFLECTANCE)?,
        })
    }

    /// rho_hd for every direction, and rho_hh: the reflectance itself.
    pub fn albedo(&self) -> DVec3 {
        self.reflectance.value()
    }
}

impl Bxdf for Lambertian {
    fn channels(&self) -> Channels {
        self.reflectance.channels()
    }

    fn flags(&self) -> Flags {
        Flags::REFLECTION | Flags::DIFFUSE
    }

    fn f(&self, wo: DVec3, wi: DVec3) -> DVec3 {
        if opposite_sides(wo, wi) {
            DVec3::ZERO
        } else {
            self.reflectance.value() * FRAC_1_PI
        }
    }

    fn pdf(&self, wo: DVec3, wi: DVec3) -> f64 {
        if opposite_sides(wo, wi) {
            0.0
        } else {
            wi.z.abs() * FRAC_1_PI
        }
    }

    fn sample_f(&self, wo: DVec3, u: [f64; 3]) -> BxdfSample {
        let mut wi = cosine_hemisphere([u[0], u[1]]);
        let pdf = wi.z * FRAC_1_PI;
        if wo.z < 0.0 {
            wi.z = -wi.z;
        }
        BxdfSample {
            wi,
            pdf,
            weight: self.reflectance.value(),
            flags: self.flags(),
        }
    }
}
