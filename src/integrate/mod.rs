//! Reflectance integrals, each with its value, its error and what it cost.
//!
//! rho_hd(wo) = int f(wo, wi) |cos theta_i| dwi and rho_hh = (1/pi) int rho_hd(wo) |cos theta_o| dwo, in [`deterministic`]
//! and in [`monte_carlo`] form; [`Integrator`] chooses between them.

mod coupled;
pub mod deterministic;
mod integrator;
mod lobe;
mod microfacet_hd;
mod microfacet_hh;
pub mod monte_carlo;
mod segment;

pub use coupled::coupled_bxdf;
pub use integrator::{Effort, Integrator, Target};

use crate::bxdf::Sampling;
use crate::numerics::quadrature::NotConverged;
use glam::DVec3;
use std::fmt;
use std::str::FromStr;
use thiserror::Error;

/// What the stated error of an estimate means.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum ErrorKind {
    /// A closed form; the error is rounding alone.
    Exact,
    /// A bound from nested deterministic rules.
    Bound,
    /// The half-width of a 99 % confidence interval.
    Ci99,
}

impl ErrorKind {
    /// Name in JSON and in tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::Exact => "exact",
            Self::Bound => "bound",
            Self::Ci99 => "ci99",
        }
    }
}

/// A computed integral: value, error, and the evaluations of the integrand that it took.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Estimate {
    /// Value per channel.
    pub value: DVec3,
    /// Error per channel, in the sense of `kind`.
    pub error: DVec3,
    /// Meaning of `error`.
    pub kind: ErrorKind,
    /// How it was computed.
    pub estimator: Estimator,
    /// Evaluations of the integrand; 0 for closed forms.
    pub evaluations: u64,
}

/// A way to compute the integrals.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Estimator {
    /// The cheapest of the others that meets the tolerance.
    Auto,
    /// A formula.
    ClosedForm,
    /// Deterministic adaptive integration.
    Quadrature,
    /// Monte Carlo integration with the given sampling.
    MonteCarlo(Sampling),
}

impl Estimator {
    /// Every estimator, in the order of help texts.
    pub const ALL: [Self; 8] = [
        Self::Auto,
        Self::ClosedForm,
        Self::Quadrature,
        Self::MonteCarlo(Sampling::Uniform),
        Self::MonteCarlo(Sampling::Cosine),
        Self::MonteCarlo(Sampling::Normals),
        Self::MonteCarlo(Sampling::Visible),
        Self::MonteCarlo(Sampling::Bxdf),
    ];

    /// Name on the command line, in JSON and in tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::Auto => "auto",
            Self::ClosedForm => "closed-form",
            Self::Quadrature => "quadrature",
            Self::MonteCarlo(Sampling::Uniform) => "mc-uniform",
            Self::MonteCarlo(Sampling::Cosine) => "mc-cosine",
            Self::MonteCarlo(Sampling::Normals) => "mc-normals",
            Self::MonteCarlo(Sampling::Visible) => "mc-visible",
            Self::MonteCarlo(Sampling::Bxdf) => "mc-bxdf",
        }
    }
}

impl fmt::Display for Estimator {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

impl FromStr for Estimator {
    type Err = String;

    fn from_str(name: &str) -> Result<Self, String> {
        Self::ALL
            .into_iter()
            .find(|estimator| estimator.name() == name)
            .ok_or_else(|| {
                let known: Vec<&str> = Self::ALL.iter().map(|estimator| estimator.name()).collect();
                format!("unknown estimator `{name}`; known are {}", known.join(", "))
            })
    }
}

/// Why an integral has no stated value.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum IntegrateError {
    /// The tolerance was not met.
    #[error("the tolerance was not met: {0}")]
    NotConverged(#[from] NotConverged),
    /// The tolerance would need more samples than allowed.
    #[error(
        "{estimator} would need about {needed:.1e} samples for an error of {tolerance:.1e}, more than the {limit:.0e} allowed: \
         loosen the tolerance, fix the count with --samples, or use quadrature"
    )]
    TooManySamples {
        /// The estimator.
        estimator: Estimator,
        /// Samples needed.
        needed: f64,
        /// Samples allowed.
        limit: f64,
        /// Error asked for.
        tolerance: f64,
    },
    /// Too few samples hit the lobe for their spread to be known.
    #[error(
        "{hits} of {samples} samples of {estimator} contribute, too few to state an error: \
         take more samples, or use mc-normals, mc-visible or quadrature"
    )]
    TooFewHits {
        /// The estimator.
        estimator: Estimator,
        /// Samples that contributed.
        hits: u64,
        /// Samples drawn.
        samples: u64,
    },
    /// The integral has no finite value.
    #[error(
        "rho_hd grows without bound as mu -> 0 when masking = \"none\": ask for mu > 0, or use masking = \"v-groove\""
    )]
    Diverges,
    /// The estimator cannot compute this model.
    #[error("{estimator} cannot compute this material: {reason}")]
    Unsupported {
        /// The estimator.
        estimator: Estimator,
        /// Why not, and what can.
        reason: &'static str,
    },
}
