//! What accuracy costs in time: every estimator over a ladder of efforts, tables of every shape as a shader sees them, and how
//! cost grows with the work.
//!
//! Errors are true ones: differences from a converged reference, whose own error is told. Times are CPU seconds of one thread;
//! every computation runs alone on one. Times never enter tables.

pub mod chart;
mod clock;
mod contest;
pub mod data;
mod families;
mod fit;
mod ladder;
mod report;
mod scaling;
mod settings;
mod shape;
mod subject;
mod workers;

pub use clock::Seconds;
pub use contest::{Contest, ERROR as CONTEST_ERROR, Rival};
pub use families::Kin;
pub use fit::Line;
pub use ladder::{Accuracy, Curve, Measured, Outcome, Point, Reference, Run, Rung};
pub use report::{Report, Unwatched, Watch, run};
pub use scaling::{Grown, Growth};
pub use settings::{Budget, Settings};
pub use shape::{Answer, Shape, Shapes};
pub use subject::{Subject, default_scene};

use crate::bxdf::ModelError;
use crate::integrate::IntegrateError;
use crate::plan::PlanError;
use rayon::ThreadPoolBuildError;
use thiserror::Error;

/// A study that cannot be made.
#[derive(Debug, Error)]
pub enum CostError {
    /// The system has no threads left.
    #[error(transparent)]
    Threads(#[from] ThreadPoolBuildError),
    /// No table of the material can be planned.
    #[error(transparent)]
    Plan(#[from] PlanError),
    /// A material makes no model.
    #[error(transparent)]
    Model(#[from] ModelError),
    /// Nothing can be computed of the material.
    #[error("material `{0}` has no directional albedo")]
    Nothing(String),
    /// Nothing converges.
    #[error("material `{material}`: nothing to compare with: {source}")]
    Reference {
        /// The material.
        material: String,
        /// What the last estimator said.
        source: IntegrateError,
    },
}
