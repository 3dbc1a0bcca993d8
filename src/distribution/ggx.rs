//! GGX distribution, also named after Trowbridge and Reitz [Walter et al. 2007, eq. 33].

use crate::geometry::Polar;
use crate::parameter::{GGX_ALPHA, ParameterError};
use std::f64::consts::PI;

/// D(h) = alpha^2/(pi (alpha^2 cos^2 + sin^2)^2), p = D cos.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ggx {
    alpha: f64,
}

impl Ggx {
    /// Width `alpha` of the slopes in [1e-6, 10], [`GGX_ALPHA`], a tangent.
    ///
    /// # Errors
    /// [`ParameterError`] outside that range, with the value and the range.
    pub fn new(alpha: f64) -> Result<Self, ParameterError> {
        Ok(Self {
            alpha: GGX_ALPHA.check(alpha)?,
        })
    }

    /// A profile of an anisotropic distribution, between two legal ones.
    pub(super) fn between(alpha: f64) -> Self {
        Self { alpha }
    }

    /// Width of the slopes.
    pub fn alpha(&self) -> f64 {
        self.alpha
    }

    pub(super) fn p(&self, theta: Polar) -> f64 {
        self.d(theta) * theta.cos
    }

    pub(super) fn d(&self, theta: Polar) -> f64 {
        // (alpha/(alpha^2 cos^2 + sin^2))^2/pi: the square of what is at most 1/alpha does not overflow
        let stretched = self.alpha * theta.cos;
        let root = self.alpha / (stretched * stretched + theta.sin * theta.sin);
        root * root / PI
    }

    /// 1 - P = 1/(1 + tan^2/alpha^2).
    pub(super) fn exposure(&self, theta: Polar) -> f64 {
        let slope = theta.tan() / self.alpha;
        if slope > 1e150 {
            return 2.0 * libm::log(slope);
        }
        libm::log1p(slope * slope)
    }

    pub(super) fn at_exposure(&self, exposure: f64) -> Polar {
        let slope = if exposure < 40.0 {
            libm::expm1(exposure).sqrt()
        } else {
            libm::exp(0.5 * exposure)
        };
        Polar::from_tan(self.alpha * slope)
    }
}
