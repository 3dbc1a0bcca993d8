//! Reflection and refraction at a smooth interface in one model [pbrt 2016, section 8.2].

use super::{Interface, Transport, mirrored};
use crate::bxdf::{Bxdf, BxdfSample, Flags};
use crate::numerics::quadrature::Bounded;
use crate::parameter::{ParameterError, REFLECTANCE, TRANSMITTANCE};
use crate::spectrum::{Channels, Spectrum};
use glam::DVec3;

/// The sum of R F delta(wi - R(wo))/|cos theta_i| and T (1 - F) delta(wi - T(wo))/|cos theta_i|, the latter times
/// (eta_o/eta_i)^2 for radiance, with F of the interface of two dielectrics.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FresnelSpecular {
    reflectance: Spectrum,
    transmittance: Spectrum,
    interface: Interface,
}

impl FresnelSpecular {
    /// Reflectance and transmittance in [0, 1] in every channel, [`REFLECTANCE`] and [`TRANSMITTANCE`]; the indices `eta_a`
    /// above and `eta_b` below the surface in [0.01, 100], [`ETA_A`](crate::parameter::ETA_A) and
    /// [`ETA_B`](crate::parameter::ETA_B).
    ///
    /// # Errors
    /// [`ParameterError`] outside those ranges, with the value and the range.
    pub fn new(
        reflectance: Spectrum,
        transmittance: Spectrum,
        eta_a: f64,
        eta_b: f64,
        transport: Transport,
    ) -> Result<Self, ParameterError> {
        Ok(Self {
            reflectance: reflectance.check(REFLECTANCE)?,
            transmittance: transmittance.check(TRANSMITTANCE)?,
            interface: Interface::new(eta_a, eta_b, transport)?,
        })
    }

    /// Scale R of the reflected light.
    pub fn reflectance(&self) -> Spectrum {
        self.reflectance
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

    /// rho_hd to the given sides together, at a direction above the surface with cosine `mu`: R F(mu) and T (1 - F(mu)),
    /// the latter scaled for radiance. Exact to the rounding of F.
    pub fn rho_hd(&self, sides: Flags, mu: f64) -> DVec3 {
        self.divided(sides, self.interface.reflectance_above(mu))
    }

    /// rho_hh from above to the given sides together, with a bound of its rounding error: F_bar in the place of F.
    pub fn rho_hh(&self, sides: Flags) -> Bounded {
        let (mean, error) = self.interface.mean_reflectance_above();
        let [reflected, transmitted] = self.factors(sides);
        // together F_bar and 1 - F_bar lose nothing
        let together = Bounded {
            value: self.divided(sides, mean),
            // and four roundings of each product
            error: (reflected - transmitted).abs() * error + (reflected + transmitted) * (4.0 * f64::EPSILON),
        };
        let (passes, passes_error) = self.interface.mean_transmittance_above();
        let transmittance = if sides.contains(Flags::TRANSMISSION) {
            self.transmittance.value()
        } else {
            DVec3::ZERO
        };
        let value = reflected * mean + transmittance * passes;
        let apart = Bounded {
            value,
            error: reflected * error + transmittance * passes_error + value * (4.0 * f64::EPSILON),
        };
        let better = apart.error.cmplt(together.error);
        Bounded {
            value: DVec3::select(better, apart.value, together.value),
            error: DVec3::select(better, apart.error, together.error),
        }
    }

    /// What F and 1 - F count from above.
    fn factors(&self, sides: Flags) -> [DVec3; 2] {
        let counted = |side: Flags, factor: DVec3| if sides.contains(side) { factor } else { DVec3::ZERO };
        let transmittance = self.transmittance.value() * self.interface.scale(DVec3::Z);
        [
            counted(Flags::REFLECTION, self.reflectance.value()),
            counted(Flags::TRANSMISSION, transmittance),
        ]
    }

    fn divided(&self, sides: Flags, fresnel: f64) -> DVec3 {
        let [reflected, transmitted] = self.factors(sides);
        reflected * fresnel + transmitted * (1.0 - fresnel)
    }
}

impl Bxdf for FresnelSpecular {
    fn channels(&self) -> Channels {
        self.reflectance.channels().max(self.transmittance.channels())
    }

    fn flags(&self) -> Flags {
        Flags::REFLECTION | Flags::TRANSMISSION | Flags::SPECULAR
    }

    fn f(&self, _: DVec3, _: DVec3) -> DVec3 {
        DVec3::ZERO
    }

    fn pdf(&self, _: DVec3, _: DVec3) -> f64 {
        0.0
    }

    /// The mirror image of wo with probability F, the refracted direction with 1 - F; the first of `u` decides. F and
    /// 1 - F cancel in the weights. Total internal reflection has F = 1.
    fn sample_f(&self, wo: DVec3, u: [f64; 3]) -> BxdfSample {
        let fresnel = self.interface.reflectance(wo);
        let refracted = if u[0] < fresnel {
            None
        } else {
            self.interface.refracted(wo)
        };
        match refracted {
            Some(wi) => BxdfSample {
                wi,
                pdf: 1.0 - fresnel,
                weight: self.transmittance.value() * self.interface.scale(wo),
                flags: Flags::TRANSMISSION | Flags::SPECULAR,
            },
            None => BxdfSample {
                wi: mirrored(wo),
                pdf: fresnel,
                weight: self.reflectance.value(),
                flags: Flags::REFLECTION | Flags::SPECULAR,
            },
        }
    }
}
