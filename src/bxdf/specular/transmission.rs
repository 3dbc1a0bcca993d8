//! Refraction at a smooth interface [pbrt 2010, section 8.2.3].

use super::{Interface, Transport};
use crate::bxdf::{Bxdf, BxdfSample, Flags};
use crate::numerics::quadrature::Bounded;
use crate::parameter::{ParameterError, TRANSMITTANCE};
use crate::spectrum::{Channels, Spectrum};
use glam::DVec3;

/// f = T (1 - F(cos theta_o)) delta(wi - T(wo))/|cos theta_i|, for radiance times (eta_o/eta_i)^2.
///
/// The indices are numbers, not spectra: where they differ by colour, so does the refracted direction.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SpecularTransmission {
    transmittance: Spectrum,
    interface: Interface,
}

impl SpecularTransmission {
    /// Transmittance in [0, 1] in every channel, [`TRANSMITTANCE`]; the indices `eta_a` above and `eta_b` below the surface in
    /// [0.01, 100], [`ETA_A`](crate::parameter::ETA_A) and [`ETA_B`](crate::parameter::ETA_B).
    ///
    /// # Errors
    /// [`ParameterError`] outside those ranges, with the value and the range.
    pub fn new(transmittance: Spectrum, eta_a: f64, eta_b: f64, transport: Transport) -> Result<Self, ParameterError> {
        Ok(Self {
            transmittance: transmittance.check(TRANSMITTANCE)?,
            interface: Interface::new(eta_a, eta_b, transport)?,
        })
    }

    /// Scale T of the transmitted light.
    pub fn transmittance(&self) -> Spectrum {
        self.transmittance
    }

    /// The same with importance transport.
    pub fn accounted(&self) -> Self {
        Self {
            interface: self.interface.accounted(),
            ..*self
        }
    }

    /// Index of refraction above the surface.
    pub fn eta_a(&self) -> f64 {
        self.interface.eta_a
    }

    /// Index of refraction below the surface.
    pub fn eta_b(&self) -> f64 {
        self.interface.eta_b
    }

    /// What is transported.
    pub fn transport(&self) -> Transport {
        self.interface.transport
    }

    /// rho_hd to the given sides at a direction above the surface with cosine `mu`: T (1 - F(mu)), scaled for radiance, if
    /// `sides` has TRANSMISSION, otherwise 0. Exact to the rounding of F.
    pub fn rho_hd(&self, sides: Flags, mu: f64) -> DVec3 {
        if sides.contains(Flags::TRANSMISSION) {
            let scale = self.interface.scale(DVec3::Z);
            self.transmittance.value() * (scale * (1.0 - self.interface.reflectance_above(mu)))
        } else {
            DVec3::ZERO
        }
    }

    /// rho_hh from above to the given sides with a bound of its rounding error: T (1 - F_bar), scaled for radiance.
    pub fn rho_hh(&self, sides: Flags) -> Bounded {
        if !sides.contains(Flags::TRANSMISSION) {
            return Bounded::exact(DVec3::ZERO);
        }
        let (mean, error) = self.interface.mean_transmittance_above();
        let factor = self.transmittance.value();
        Bounded {
            value: factor * mean,
            // and four roundings of the product
            error: factor * (error + 4.0 * f64::EPSILON * mean),
        }
    }
}

impl Bxdf for SpecularTransmission {
    fn channels(&self) -> Channels {
        self.transmittance.channels()
    }

    fn flags(&self) -> Flags {
        Flags::TRANSMISSION | Flags::SPECULAR
    }

    fn f(&self, _: DVec3, _: DVec3) -> DVec3 {
        DVec3::ZERO
    }

    fn pdf(&self, _: DVec3, _: DVec3) -> f64 {
        0.0
    }

    /// The refracted direction, with certainty; lost under total internal reflection, where there is none.
    fn sample_f(&self, wo: DVec3, _: [f64; 3]) -> BxdfSample {
        let Some(wi) = self.interface.refracted(wo) else {
            return BxdfSample::lost(-wo);
        };
        let transmitted = self.interface.scale(wo) * (1.0 - self.interface.reflectance(wo));
        BxdfSample {
            wi,
            pdf: 1.0,
            weight: self.transmittance.value() * transmitted,
            flags: self.flags(),
        }
    }
}
