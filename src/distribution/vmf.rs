//! von Mises-Fisher distribution, renormalised to the hemisphere [Mikkelsen 2009, eq. 29 and 31].

use crate::geometry::Polar;
use crate::numerics::lanes;
use crate::parameter::{KAPPA, ParameterError};
use std::f64::consts::TAU;

/// p(h) = kappa/(2 pi (e^kappa - 1)) e^(kappa n.h).
///
/// All forms below are in v = 1 - n.h and in e^-kappa, which neither overflow for kappa above 709 nor lose the
/// difference e^kappa - 1 for small kappa.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Vmf {
    kappa: f64,
    /// e^-kappa and 1 - e^-kappa.
    decay: f64,
    whole: f64,
    /// kappa/(2 pi (1 - e^-kappa)), the density at the pole.
    peak: f64,
}

/// Below this, 1 - e^-kappa equals kappa to the last bit and the distribution is uniform to the last bit.
const UNIFORM: f64 = 1e-16;

impl Vmf {
    /// Concentration `kappa` in [0, 1e12], [`KAPPA`], without a unit; 0 is the uniform hemisphere.
    ///
    /// # Errors
    /// [`ParameterError`] outside that range, with the value and the range.
    pub fn new(kappa: f64) -> Result<Self, ParameterError> {
        KAPPA.check(kappa)?;
        let (decay, whole) = (libm::exp(-kappa), -libm::expm1(-kappa));
        let peak = if kappa < UNIFORM {
            TAU.recip()
        } else {
            kappa / (TAU * whole)
        };
        Ok(Self {
            kappa,
            decay,
            whole,
            peak,
        })
    }

    /// Concentration.
    pub fn kappa(&self) -> f64 {
        self.kappa
    }

    /// The density at the pole, in sr^-1.
    pub(super) fn peak(&self) -> f64 {
        self.peak
    }

    pub(super) fn p(&self, theta: Polar) -> f64 {
        self.peak * libm::exp(-self.kappa * theta.versine())
    }

    pub(super) fn d(&self, theta: Polar) -> f64 {
        let p = self.p(theta);
        // what has vanished at the horizon stays so
        if p == 0.0 { 0.0 } else { p / theta.cos }
    }

    /// P = (1 - e^(-kappa v))/(1 - e^-kappa) and 1 - P = e^(-kappa v) (1 - e^(-kappa cos))/(1 - e^-kappa): the smaller
    /// of the two is formed without cancellation.
    pub(super) fn exposure(&self, theta: Polar) -> f64 {
        let (kappa, v) = (self.kappa, theta.versine());
        if kappa < UNIFORM {
            return -theta.ln_cos();
        }
        let cdf = -libm::expm1(-kappa * v) / self.whole;
        if cdf < 0.5 {
            -libm::log1p(-cdf)
        } else {
            kappa * v - libm::log(-libm::expm1(-kappa * theta.cos) / self.whole)
        }
    }

    /// Solved for v and for cos, each in a form that is accurate where it is small: kappa v = -ln(e^-kappa + (1 - e^-kappa) e^-E),
    /// of which kappa cos = ln(1 + (e^kappa - 1) e^-E) is what remains to kappa.
    pub(super) fn at_exposure(&self, exposure: f64) -> Polar {
        let kappa = self.kappa;
        if kappa < UNIFORM {
            return Polar::from_versine(-libm::expm1(-exposure), libm::exp(-exposure));
        }
        if kappa - exposure > 40.0 {
            // e^(E - kappa) is lost beside 1: nothing of the lobe reaches the horizon
            let versine = exposure / kappa;
            return Polar::from_versine(versine, 1.0 - versine);
        }
        let versine = if kappa < 1.0 || exposure < 0.7 {
            -libm::log1p(libm::expm1(-exposure) * self.whole) / kappa
        } else if exposure < 600.0 {
            // a sum of two positive numbers, whose logarithm is not near 0
            -lanes::ln(self.decay + self.whole * lanes::exp(-exposure)) / kappa
        } else {
            // e^E - 1 = e^E to the last bit; of ln(1 + e^(E - kappa)) the form that does not overflow
            let beyond = exposure - kappa;
            let rest = libm::log1p(libm::exp(-beyond.abs()));
            (exposure.min(kappa) - rest) / kappa
        };
        if versine < 0.5 {
            return Polar::from_versine(versine.max(0.0), 1.0 - versine);
        }
        let rest = kappa - exposure;
        let cos = if rest < -40.0 {
            // ln(1 + x) = x to the last bit, and x itself may underflow where x/kappa does not
            libm::exp(rest) * (self.whole / kappa)
        } else {
            libm::log1p(self.whole * libm::exp(rest)) / kappa
        };
        Polar::from_versine(versine.min(1.0), cos.clamp(0.0, 1.0))
    }
}
