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
mod lobe;
mod microfacet_hd;
mod microfacet_hh;
pub mod monte_carlo;
mod parts;
mod profile;
mod request;
mod sampled;
pub mod seen;
mod segment;
mod smith_hd;
mod target;
mod within;

pub use coordinates::Coordinates;
pub use coupled::coupled_bxdf;
pub use fill::{FillError, Progress, fill, texels, work};
pub use forecast::{Forecast, forecast, forecasts};
pub use integrator::Integrator;
pub use request::request;
pub use sampled::sampled;
pub use target::{Angles, Target};
pub use within::fill_within;

pub use crate::estimate::{Effort, ErrorKind, Estimate, Estimator, Lobe};

use crate::numerics::quadrature::NotConverged;
use thiserror::Error;

/// Where [`IntegrateError::Diverges`] comes from.
const UNMASKED: &str = "when masking = \"none\": ask for mu > 0, or use another masking";
const UNMASKED_COAT: &str = "under a fresnel-blend of vmf facets, whose D is infinite at the horizon: ask for mu > 0, or use \
                             another distribution";

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
        "{hits} of {samples} samples of {estimator} carry the mean, too few to state an error: \
         take more samples, or use mc-normals, mc-visible or quadrature"
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
