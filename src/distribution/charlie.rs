//! Charlie, the exponentiated sinusoid of fibres that stand off the surface [Estevez and Kulla 2017, eq. 2].

use crate::geometry::Polar;
use crate::parameter::{CHARLIE_ALPHA, ParameterError};
use std::f64::consts::{LN_2, TAU};

/// D(h) = (2 + n)/(2 pi) sin^n with n = 1/alpha, p = D cos: Phong's distribution, seen from the horizon.
///
/// P(theta) = sin^(n + 2). Nothing lies at the pole, and for small alpha all facets stand upright, sqrt(alpha) from the
/// horizon. Near the pole the logarithm of sin^n carries its digits, near the horizon cos does: every form here takes the
/// logarithm of the sine, which keeps both.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Charlie {
    alpha: f64,
    /// 1/alpha
    n: f64,
}

impl Charlie {
    /// Spread `alpha` of the fibres in [1e-3, 1], [`CHARLIE_ALPHA`], without a unit.
    ///
    /// # Errors
    /// [`ParameterError`] outside that range, with the value and the range.
    pub fn new(alpha: f64) -> Result<Self, ParameterError> {
        let alpha = CHARLIE_ALPHA.check(alpha)?;
        let n = alpha.recip();
        Ok(Self { alpha, n })
    }

    /// Spread of the fibres.
    pub fn alpha(&self) -> f64 {
        self.alpha
    }

    /// The exponent 1/alpha of the sine.
    pub fn exponent(&self) -> f64 {
        self.n
    }

    pub(super) fn p(&self, theta: Polar) -> f64 {
        self.d(theta) * theta.cos
    }

    pub(super) fn d(&self, theta: Polar) -> f64 {
        (self.n + 2.0) / TAU * libm::exp(self.n * theta.ln_sin())
    }

    /// -ln(1 - sin^(n + 2)).
    pub(super) fn exposure(&self, theta: Polar) -> f64 {
        let power = self.n + 2.0;
        if theta.cos < HORIZON {
            // 1 - P = (n + 2)/2 cos^2 to the last bit
            return -(libm::log(0.5 * power) + 2.0 * libm::log(theta.cos));
        }
        let log = power * theta.ln_sin();
        if log < -LN_2 {
            -libm::log1p(-libm::exp(log))
        } else {
            -libm::log(-libm::expm1(log))
        }
    }

    /// sin^(n + 2) = 1 - e^-E.
    pub(super) fn at_exposure(&self, exposure: f64) -> Polar {
        let power = self.n + 2.0;
        if exposure > LOST {
            // e^-E may underflow where its root does not
            let cos = (2.0 / power).sqrt() * libm::exp(-0.5 * exposure);
            return Polar { sin: 1.0, cos };
        }
        let log = if exposure < LN_2 {
            libm::log(-libm::expm1(-exposure))
        } else {
            libm::log1p(-libm::exp(-exposure))
        };
        let log = log / power;
        Polar {
            sin: libm::exp(log),
            cos: (-libm::expm1(2.0 * log)).sqrt(),
        }
    }
}

/// Cosine below which the square of it is lost beside 1, times any exponent.
const HORIZON: f64 = 1e-10;

/// Exposure beyond which e^-E is lost beside 1.
const LOST: f64 = 40.0;
