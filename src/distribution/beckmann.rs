//! Beckmann distribution [Mikkelsen 2009, eq. 20].

use crate::geometry::Polar;
use crate::parameter::{BECKMANN_M, ParameterError};
use std::f64::consts::PI;

/// D(h) = e^(-tan^2/m^2)/(pi m^2 cos^4), p = D cos.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Beckmann {
    m: f64,
}

impl Beckmann {
    /// Root-mean-square slope `m` in [1e-6, 10], [`BECKMANN_M`], a tangent.
    ///
    /// # Errors
    /// [`ParameterError`] outside that range, with the value and the range.
    pub fn new(m: f64) -> Result<Self, ParameterError> {
        Ok(Self {
            m: BECKMANN_M.check(m)?,
        })
    }

    /// A profile of an anisotropic distribution, between two legal ones.
    pub(super) fn between(m: f64) -> Self {
        Self { m }
    }

    /// Root-mean-square slope.
    pub fn m(&self) -> f64 {
        self.m
    }

    pub(super) fn p(&self, theta: Polar) -> f64 {
        self.over_power(theta, 3)
    }

    pub(super) fn d(&self, theta: Polar) -> f64 {
        self.over_power(theta, 4)
    }

    /// e^-E/(pi m^2 cos^power); the exponential vanishes long before the power of the cosine underflows.
    fn over_power(&self, theta: Polar, power: i32) -> f64 {
        let exponential = libm::exp(-self.exposure(theta));
        if exponential == 0.0 {
            return 0.0;
        }
        exponential / (PI * self.m * self.m * theta.cos.powi(power))
    }

    /// 1 - P = e^(-tan^2/m^2).
    pub(super) fn exposure(&self, theta: Polar) -> f64 {
        let slope = theta.tan() / self.m;
        slope * slope
    }

    pub(super) fn at_exposure(&self, exposure: f64) -> Polar {
        Polar::from_tan(self.m * exposure.sqrt())
    }
}
