//! Legal ranges of parameters, stated once, and the error that a value outside them gets.
//!
//! Values are refused, never repaired: a clamped roughness would bake a table for another material than the one asked for.

use std::fmt;
use thiserror::Error;

/// The closed interval of values that a parameter may take.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Legal {
    /// Name as it stands in a scene file.
    pub name: &'static str,
    /// Smallest legal value.
    pub min: f64,
    /// Largest legal value.
    pub max: f64,
}

/// A parameter outside its legal range, NaN and infinities included.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
#[error(
    "{parameter} = {} is not allowed: {parameter} lies in [{}, {}]",
    Number(*value), Number(*min), Number(*max)
)]
pub struct ParameterError {
    /// Name of the parameter.
    pub parameter: &'static str,
    /// The refused value.
    pub value: f64,
    /// Smallest legal value.
    pub min: f64,
    /// Largest legal value.
    pub max: f64,
}

/// A number as people write it: 17, 0.25, 1e12.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Number(pub f64);

impl fmt::Display for Number {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let size = self.0.abs();
        if size != 0.0 && size.is_finite() && !(1e-4..1e6).contains(&size) {
            write!(f, "{:e}", self.0)
        } else {
            write!(f, "{}", self.0)
        }
    }
}

impl Legal {
    /// A legal range `[min, max]` for the parameter `name`.
    pub const fn new(name: &'static str, min: f64, max: f64) -> Self {
        Self { name, min, max }
    }

    /// `value` itself when it is legal.
    ///
    /// # Errors
    /// [`ParameterError`] when `value` is outside the range or NaN.
    pub fn check(self, value: f64) -> Result<f64, ParameterError> {
        if value >= self.min && value <= self.max {
            Ok(value)
        } else {
            Err(ParameterError {
                parameter: self.name,
                value,
                min: self.min,
                max: self.max,
            })
        }
    }
}

/// Concentration of the von Mises-Fisher distribution; 0 is uniform over the hemisphere.
pub const KAPPA: Legal = Legal::new("kappa", 0.0, 1e12);
/// Root-mean-square slope of the Beckmann distribution.
pub const BECKMANN_M: Legal = Legal::new("m", 1e-6, 10.0);
/// Slope width of the GGX distribution.
pub const GGX_ALPHA: Legal = Legal::new("alpha", 1e-6, 10.0);
/// Spread of the fibres of the Charlie distribution. Engines take the square of a sheen roughness in [0, 1] with a floor of
/// 0.04 to 0.07, so that all they use is legal, and the fit of the `charlie` masking was made for (0, 1].
pub const CHARLIE_ALPHA: Legal = Legal::new("alpha", 1e-3, 1.0);
/// Exponent of the normalised Phong distribution.
pub const PHONG_N: Legal = Legal::new("n", 0.0, 1e8);
/// Relative index of refraction, transmitted over incident side.
pub const ETA: Legal = Legal::new("eta", 0.01, 100.0);
/// Index of refraction of the medium above a refracting surface.
pub const ETA_A: Legal = Legal::new("eta_a", ETA.min, ETA.max);
/// Index of refraction of the medium below it.
pub const ETA_B: Legal = Legal::new("eta_b", ETA.min, ETA.max);
/// Extinction coefficient of a conductor.
pub const EXTINCTION: Legal = Legal::new("k", 0.0, 100.0);
/// Reflectance at normal incidence of Schlick's approximation.
pub const R0: Legal = Legal::new("r0", 0.0, 1.0);
/// Albedo of a lobe.
pub const REFLECTANCE: Legal = Legal::new("reflectance", 0.0, 1.0);
/// Scale of the transmitted light.
pub const TRANSMITTANCE: Legal = Legal::new("transmittance", 0.0, 1.0);
/// Standard deviation of the facet angle of Oren and Nayar, in degrees.
pub const SIGMA_DEG: Legal = Legal::new("sigma_deg", 0.0, 90.0);
/// Reflectance of the diffuse base of a Fresnel blend.
pub const RD: Legal = Legal::new("rd", 0.0, 1.0);
/// Reflectance at normal incidence of the coat of a Fresnel blend.
pub const RS: Legal = Legal::new("rs", 0.0, 1.0);
/// Factor of a scaled model.
pub const SCALE: Legal = Legal::new("scale", 0.0, 1.0);
/// Scale of the specular lobe in the diffuse-specular coupling.
pub const KS: Legal = Legal::new("ks", 0.0, 1.0);
/// Scale of the diffuse lobe in the diffuse-specular coupling.
pub const KD: Legal = Legal::new("kd", 0.0, 1.0);
/// Cosine between a direction and the surface normal; 0 stands for the limit.
pub const MU: Legal = Legal::new("mu", 0.0, 1.0);

/// Every range above, but for [`CHARLIE_ALPHA`], whose name another one has. The two parameters of an anisotropic distribution
/// have the range of the isotropic one, under names of their own, see [`crate::distribution::Elliptic::legal`].
pub const ALL: [Legal; 18] = [
    KAPPA,
    BECKMANN_M,
    GGX_ALPHA,
    PHONG_N,
    ETA,
    ETA_A,
    ETA_B,
    EXTINCTION,
    R0,
    REFLECTANCE,
    TRANSMITTANCE,
    SIGMA_DEG,
    RD,
    RS,
    SCALE,
    KS,
    KD,
    MU,
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ends_are_legal_and_the_rest_is_refused() {
        assert_eq!(KAPPA.check(0.0), Ok(0.0));
        assert_eq!(KAPPA.check(1e12), Ok(1e12));
        for value in [-1e-300, 1.0000001e12, f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            let error = KAPPA.check(value).unwrap_err();
            assert!(error.to_string().contains("kappa lies in [0, 1e12]"), "{error}");
        }
    }
}
