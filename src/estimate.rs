//! The vocabulary of results: how an integral is computed, what came out, and what its error means.

use crate::bxdf::{Flags, Model, Sampling};
pub use crate::numerics::points::Points;
use glam::DVec3;
use std::fmt;
use std::str::FromStr;

/// What the stated error of an estimate means.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum ErrorKind {
    /// A closed form: the error is that of its arithmetic.
    Exact,
    /// The true value is no further away: deterministic integration with nested rules.
    Bound,
    /// Half-width of a 99 % confidence interval.
    Ci99,
}

impl ErrorKind {
    /// The name in files, manifests and messages.
    pub fn name(self) -> &'static str {
        match self {
            Self::Exact => "exact",
            Self::Bound => "bound",
            Self::Ci99 => "ci99",
        }
    }

    /// The kind called `name`, if there is one.
    pub fn from_name(name: &str) -> Option<Self> {
        [Self::Exact, Self::Bound, Self::Ci99]
            .into_iter()
            .find(|kind| kind.name() == name)
    }
}

/// The side that light leaves on.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Lobe {
    /// The side of the fixed direction.
    Reflection,
    /// The other side.
    Transmission,
}

impl Lobe {
    /// Both sides.
    pub const ALL: [Self; 2] = [Self::Reflection, Self::Transmission];

    /// The name in files, manifests and messages.
    pub fn name(self) -> &'static str {
        match self {
            Self::Reflection => "reflection",
            Self::Transmission => "transmission",
        }
    }

    /// The side called `name`, if there is one.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|lobe| lobe.name() == name)
    }

    /// The opposite side.
    pub fn other(self) -> Self {
        match self {
            Self::Reflection => Self::Transmission,
            Self::Transmission => Self::Reflection,
        }
    }

    /// What a model that scatters to this side has among its flags.
    pub fn flag(self) -> Flags {
        match self {
            Self::Reflection => Flags::REFLECTION,
            Self::Transmission => Flags::TRANSMISSION,
        }
    }

    /// Whether `wi` lies on this side, seen from `wo`; a direction at the horizon counts as above it.
    pub fn holds(self, wo: DVec3, wi: DVec3) -> bool {
        let same = (wo.z < 0.0) == (wi.z < 0.0);
        same == (self == Self::Reflection)
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

/// Largest absolute error where nobody asks for another: what a rule integrates at a few hundred evaluations, and for
/// irregular samples, whose f jumps, what some ten thousand samples know.
pub fn default_tolerance(model: &Model) -> f64 {
    if model.is_irregular() { 1e-2 } else { 1e-6 }
}

impl Estimate {
    /// Value and error times a non-negative `scale` per channel.
    pub fn scaled(self, scale: DVec3) -> Self {
        Self {
            value: scale * self.value,
            error: scale * self.error,
            ..self
        }
    }
}

/// How much work an estimate may take.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Effort {
    /// Largest absolute error.
    pub tolerance: f64,
    /// Fixed number of Monte Carlo samples instead of the tolerance.
    pub samples: Option<u64>,
    /// Seed of the random streams.
    pub seed: u64,
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
    /// The mean of f |cos theta_i|/pdf over drawn directions.
    MonteCarlo {
        /// How directions are drawn.
        sampling: Sampling,
        /// The numbers that they are made of.
        points: Points,
    },
}

impl Estimator {
    /// Every estimator, in the order of help texts.
    pub const ALL: [Self; 18] = {
        let mut all = [Self::Auto; 18];
        all[1] = Self::ClosedForm;
        all[2] = Self::Quadrature;
        let mut index = 0;
        while index < 15 {
            all[3 + index] = Self::MonteCarlo {
                sampling: Sampling::ALL[index % 5],
                points: Points::ALL[index / 5],
            };
            index += 1;
        }
        all
    };

    /// Monte Carlo with random points.
    pub fn random(sampling: Sampling) -> Self {
        let points = Points::Random;
        Self::MonteCarlo { sampling, points }
    }

    /// Name on the command line, in JSON and in tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::Auto => "auto",
            Self::ClosedForm => "closed-form",
            Self::Quadrature => "quadrature",
            Self::MonteCarlo { sampling, points } => match (points, sampling) {
                (Points::Random, Sampling::Uniform) => "mc-uniform",
                (Points::Random, Sampling::Cosine) => "mc-cosine",
                (Points::Random, Sampling::Normals) => "mc-normals",
                (Points::Random, Sampling::Visible) => "mc-visible",
                (Points::Random, Sampling::Bxdf) => "mc-bxdf",
                (Points::Stratified, Sampling::Uniform) => "stratified-uniform",
                (Points::Stratified, Sampling::Cosine) => "stratified-cosine",
                (Points::Stratified, Sampling::Normals) => "stratified-normals",
                (Points::Stratified, Sampling::Visible) => "stratified-visible",
                (Points::Stratified, Sampling::Bxdf) => "stratified-bxdf",
                (Points::Quasi, Sampling::Uniform) => "qmc-uniform",
                (Points::Quasi, Sampling::Cosine) => "qmc-cosine",
                (Points::Quasi, Sampling::Normals) => "qmc-normals",
                (Points::Quasi, Sampling::Visible) => "qmc-visible",
                (Points::Quasi, Sampling::Bxdf) => "qmc-bxdf",
            },
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
