//! The integral that is asked for.

use super::Lobe;

/// One side of a material, seen from one direction or from all.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Target {
    /// The side that light leaves on.
    pub lobe: Lobe,
    /// The direction of rho_hd, `None` for rho_hh.
    pub outgoing: Option<Angles>,
}

/// A direction above the surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Angles {
    /// Cosine in [0, 1]; 0 stands for the limit.
    pub mu: f64,
    /// Azimuth in radians.
    pub phi: f64,
}

impl Target {
    /// rho_hd of the reflection at cos theta_o = `mu` in [0, 1], [`MU`](crate::parameter::MU), and azimuth `phi` in radians.
    /// Callers check: a cosine outside that range has no meaning.
    pub fn rho_hd(mu: f64, phi: f64) -> Self {
        Self {
            lobe: Lobe::Reflection,
            outgoing: Some(Angles { mu, phi }),
        }
    }

    /// rho_hh of the reflection.
    pub fn rho_hh() -> Self {
        Self {
            lobe: Lobe::Reflection,
            outgoing: None,
        }
    }

    /// The same of the side `lobe`.
    pub fn of(self, lobe: Lobe) -> Self {
        Self { lobe, ..self }
    }
}
