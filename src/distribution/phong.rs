//! Normalised Phong distribution, also named after Blinn [Mikkelsen 2009, eq. 19; pbrt 2010, eq. 8.9].

use crate::geometry::Polar;
use crate::parameter::{PHONG_N, ParameterError};
use std::f64::consts::TAU;

/// D(h) = (n + 2)/(2 pi) (n.h)^n, p = D cos.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Phong {
    n: f64,
}

impl Phong {
    /// Exponent `n` in [0, 1e8], [`PHONG_N`], without a unit.
    ///
    /// # Errors
    /// [`ParameterError`] outside that range, with the value and the range.
    pub fn new(n: f64) -> Result<Self, ParameterError> {
        Ok(Self { n: PHONG_N.check(n)? })
    }

    /// A profile of an anisotropic distribution, between two legal ones.
    pub(super) fn between(n: f64) -> Self {
        Self { n }
    }

    /// Exponent.
    pub fn n(&self) -> f64 {
        self.n
    }

    pub(super) fn p(&self, theta: Polar) -> f64 {
        self.power(theta, self.n + 1.0)
    }

    pub(super) fn d(&self, theta: Polar) -> f64 {
        self.power(theta, self.n)
    }

    /// (n + 2)/(2 pi) cos^power through the logarithm, which keeps the digits of cos near 1 for large powers.
    fn power(&self, theta: Polar, power: f64) -> f64 {
        let exponent = if power == 0.0 { 0.0 } else { power * theta.ln_cos() };
        (self.n + 2.0) / TAU * libm::exp(exponent)
    }

    /// 1 - P = cos^(n + 2).
    pub(super) fn exposure(&self, theta: Polar) -> f64 {
        -(self.n + 2.0) * theta.ln_cos()
    }

    pub(super) fn at_exposure(&self, exposure: f64) -> Polar {
        let log = exposure / (self.n + 2.0);
        Polar::from_versine(-libm::expm1(-log), libm::exp(-log))
    }
}
