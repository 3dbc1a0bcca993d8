//! What an integral states: a value, a bound of its error and what it cost, or how far it got.

use crate::parameter::Number;
use glam::DVec3;
use std::fmt;
use thiserror::Error;

/// A value of an integrand, or an integral, with a bound of its error, per channel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bounded {
    /// Value.
    pub value: DVec3,
    /// Bound of the absolute error.
    pub error: DVec3,
}

impl Bounded {
    /// A value without error of its own.
    pub fn exact(value: DVec3) -> Self {
        Self {
            value,
            error: DVec3::ZERO,
        }
    }

    /// Value and error times `factor`.
    pub fn scaled(self, factor: f64) -> Self {
        Self {
            value: self.value * factor,
            error: self.error * factor.abs(),
        }
    }
}

/// A one-channel integral with its error bound and its cost.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ScalarIntegral {
    /// Value.
    pub value: f64,
    /// Bound of the absolute error.
    pub error: f64,
    /// Integrand evaluations.
    pub evaluations: u64,
}

/// An integral over all pieces.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Integral {
    /// Value and bound of the absolute error per channel.
    pub bounded: Bounded,
    /// Integrand evaluations.
    pub evaluations: u64,
}

impl Integral {
    /// Value and error times a non-negative `factor` per channel.
    pub fn scaled(self, factor: DVec3) -> Self {
        let Bounded { value, error } = self.bounded;
        Self {
            bounded: Bounded {
                value: factor * value,
                error: factor * error,
            },
            ..self
        }
    }

    /// 1 less the value, with the same error.
    pub fn complement(mut self) -> Self {
        self.bounded.value = DVec3::ONE - self.bounded.value;
        self
    }
}

/// The tolerance was not met within the allowed number of evaluations.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
pub struct NotConverged {
    /// Error bound reached; infinite where there is none, the integrand being no finite number somewhere.
    pub reached: f64,
    /// Error asked for.
    pub tolerance: f64,
    /// Evaluations spent.
    pub evaluations: u64,
}

impl NotConverged {
    /// The same failure of a part, in terms of the `tolerance` of the whole.
    ///
    /// The tolerances of all parts are fixed shares of that of the whole: what missed its own by some factor needs the whole
    /// to be looser by that factor.
    pub fn of_whole(self, tolerance: f64) -> Self {
        Self {
            reached: self.reached * (tolerance / self.tolerance),
            tolerance,
            ..self
        }
    }

    /// A round tolerance within reach, if there is any that says something of an albedo: the next power of ten above twice the
    /// error reached, at most 0.1.
    pub fn within_reach(&self) -> Option<f64> {
        let exponent = libm::ceil(libm::log10(2.0 * self.reached));
        // through its digits, which powers of 10 are off by
        (exponent.is_finite() && exponent <= -1.0)
            .then(|| format!("1e{exponent}").parse().ok())
            .flatten()
    }
}

impl fmt::Display for NotConverged {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (asked, evaluations) = (Number(self.tolerance), self.evaluations);
        if !self.reached.is_finite() {
            return write!(
                f,
                "no error was reached instead of the {asked} asked for, after {evaluations} evaluations: \
                 the integrand overflows"
            );
        }
        let reached = self.reached;
        write!(
            f,
            "an error of {reached:.1e} was reached instead of the {asked} asked for, after {evaluations} evaluations: "
        )?;
        match self.within_reach() {
            Some(tolerance) => write!(f, "loosen --tolerance to {tolerance:e}"),
            None => write!(f, "no tolerance is within reach"),
        }
    }
}
