//! Reflectance integrals, each with its value, its error and what it cost.
//!
//! rho_hd(wo) = int f(wo, wi) |cos theta_i| dwi and rho_hh = (1/pi) int rho_hd(wo) |cos theta_o| dwo, in [`deterministic`]
//! and in [`monte_carlo`] form; [`Integrator`] chooses between them.

mod between;
pub mod choice;
mod coordinates;
mod coupled;
pub mod deterministic;
mod facets;
mod fill;
mod forecast;
mod half_angle_hd;
mod half_angle_hh;
mod hemisphere;
mod integrator;
mod layers;
mod lobe;
mod microfacet_hd;
mod microfacet_hh;
pub mod monte_carlo;
mod parts;
mod profile;
mod request;
mod rough_dielectric;
mod sampled;
pub mod seen;
mod segment;
mod sheen;
mod smith_hd;
mod target;
mod unbounded;
mod whole;
mod within;

pub use coordinates::Coordinates;
pub use coupled::coupled_bxdf;
pub use fill::{FillError, Progress, fill, texels, work};
pub use forecast::{Forecast, Forecasts, forecast, forecasts};
pub use integrator::Integrator;
pub use request::{answers, request};
pub use rough_dielectric::{InterfaceAlbedos, RoughInterface};
pub use sampled::sampled;
pub use target::{Angles, Target};
pub use whole::{WholeExcess, whole_excess};
pub use within::fill_within;

pub use crate::estimate::{Effort, ErrorKind, Estimate, Estimator, Lobe};

use crate::bxdf::Sampling;
use crate::numerics::quadrature::NotConverged;
use thiserror::Error;

/// Why an integral has no stated value.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum IntegrateError {
    /// The tolerance was not met.
    #[error("the tolerance was not met: {0}")]
    NotConverged(#[from] NotConverged),
    /// The tolerance would need more samples than allowed.
    #[error(
        "{estimator} would need about {needed:.1e} samples for an error of {tolerance:.1e}, more than the {limit:.0e} allowed: \
         loosen --tolerance, fix the count with --samples, or use --estimator auto"
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
        "{hits} of {samples} samples of {estimator} carry the mean, too few to state an error: {}",
        enough_hits(*estimator, *hits, *samples)
    )]
    TooFewHits {
        /// The estimator.
        estimator: Estimator,
        /// Samples that carry the mean.
        hits: u64,
        /// Samples drawn.
        samples: u64,
    },
    /// The integral has no finite value.
    #[error("rho_hd grows without bound as mu -> 0 {0}")]
    Diverges(&'static str),
    /// The estimator cannot compute this model.
    #[error("{estimator} cannot compute this material: {reason}")]
    Unsupported {
        /// The estimator.
        estimator: Estimator,
        /// Why not, and what can.
        reason: &'static str,
    },
}

/// What gives enough samples that carry the mean: more of them, or a way to draw them that is not the one in use.
fn enough_hits(estimator: Estimator, hits: u64, samples: u64) -> String {
    let others = match estimator {
        Estimator::MonteCarlo { sampling, .. } => match sampling {
            Sampling::Uniform | Sampling::Cosine => "mc-normals, mc-visible or auto",
            Sampling::Normals => "mc-visible or auto",
            Sampling::Visible => "mc-normals or auto",
            Sampling::Bxdf => "mc-visible, mc-normals or, but for irregular samples, quadrature",
        },
        Estimator::Auto | Estimator::ClosedForm | Estimator::Quadrature => "another estimator",
    };
    let needed = samples as f64 * monte_carlo::FEWEST_HITS / hits.max(1) as f64;
    let least = if hits == 0 { "more than " } else { "" };
    format!("take {least}{needed:.0e} samples with --samples, or use {others}")
}

impl IntegrateError {
    /// The failure of a part, in terms of the `tolerance` of the whole; see [`NotConverged::of_whole`].
    pub(crate) fn of_whole(self, tolerance: f64) -> Self {
        match self {
            Self::NotConverged(error) => Self::NotConverged(error.of_whole(tolerance)),
            other => other,
        }
    }

    /// The same failure, after as many evaluations of the integrand.
    fn costing(self, evaluations: u64) -> Self {
        match self {
            Self::NotConverged(error) => Self::NotConverged(NotConverged { evaluations, ..error }),
            other => other,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn failures_say_what_to_do() {
        let part = NotConverged {
            reached: 3e-9,
            tolerance: 1e-10,
            evaluations: 7,
        };
        let whole = IntegrateError::from(part).of_whole(1e-8).costing(12);
        assert_eq!(
            whole.to_string(),
            "the tolerance was not met: an error of 3.0e-7 was reached instead of the 1e-8 asked for, after 12 evaluations: \
             loosen --tolerance to 1e-6"
        );
        let overflow = NotConverged {
            reached: f64::INFINITY,
            ..part
        };
        assert_eq!(overflow.within_reach(), None);
        assert!(overflow.to_string().contains("the integrand overflows"), "{overflow}");
        assert_eq!(NotConverged { reached: 0.7, ..part }.within_reach(), None);
    }

    /// Nobody is told to use what has just failed.
    #[test]
    fn too_few_hits_advise_another_way() {
        for estimator in Estimator::ALL {
            let error = IntegrateError::TooFewHits {
                estimator,
                hits: 10,
                samples: 4096,
            };
            let (_, advice) = error
                .to_string()
                .split_once("error: ")
                .map(|(a, b)| (a.to_owned(), b.to_owned()))
                .unwrap();
            assert!(
                advice.starts_with("take 4e4 samples with --samples, or use "),
                "{advice}"
            ); // 100 of them
            let Estimator::MonteCarlo { sampling, .. } = estimator else {
                continue;
            };
            assert!(
                !advice.contains(Estimator::random(sampling).name()),
                "{estimator}: {advice}"
            );
        }
    }
}
