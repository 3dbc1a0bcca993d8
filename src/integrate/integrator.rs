//! The choice of an estimator for a model, and its run.

use super::deterministic::{UNSPENT_SHARE, closed_form, quadrature, quadrature_with, unspent};
use super::monte_carlo::{self, Outgoing, Samples, Trial, outgoing};
use super::{Effort, Estimate, Estimator, IntegrateError, Target, sampled};
use crate::bxdf::{Bxdf, Model};

/// Most samples that a tolerance may ask for: some minutes of one core.
const SAMPLE_LIMIT: u64 = 1 << 34;

/// A model with the estimator that computes its integrals.
pub struct Integrator<'a> {
    model: &'a Model,
    estimator: Estimator,
    effort: Effort,
    /// The model as a [`Bxdf`], where Monte Carlo needs one.
    bxdf: Option<Box<dyn Bxdf + 'a>>,
    /// 1 - ks rho_bar, shared by all directions of a coupling.
    unspent: Option<Estimate>,
}

impl<'a> Integrator<'a> {
    /// Settles `auto` for this model and prepares what the estimator needs.
    ///
    /// `auto` is the closed form where there is one and quadrature otherwise: at every tolerance the rules need fewer
    /// evaluations than the first batch of samples that a confidence interval is built on. The closest seen was a coupling
    /// to 1e-2 with 1190 of 16384, see `tests/bounds.rs`.
    ///
    /// # Errors
    /// [`IntegrateError::Unsupported`] when the estimator cannot compute the model.
    pub fn new(model: &'a Model, estimator: Estimator, effort: Effort) -> Result<Self, IntegrateError> {
        let estimator = match estimator {
            Estimator::Auto if closed_form(model).is_some() => Estimator::ClosedForm,
            Estimator::Auto => Estimator::Quadrature,
            Estimator::ClosedForm if closed_form(model).is_none() => {
                return Err(IntegrateError::Unsupported {
                    estimator,
                    reason: "it has no closed form; use auto",
                });
            }
            chosen => chosen,
        };
        let bxdf = match estimator {
            Estimator::MonteCarlo(_) => Some(sampled(model)?),
            _ => None,
        };
        let unspent = match (estimator, model) {
            (Estimator::Quadrature, Model::DiffuseSpecular(coupled)) => {
                Some(unspent(coupled, UNSPENT_SHARE * effort.tolerance)?)
            }
            _ => None,
        };
        Ok(Self {
            model,
            estimator,
            effort,
            bxdf,
            unspent,
        })
    }

    /// The estimator in use, never [`Estimator::Auto`].
    pub fn estimator(&self) -> Estimator {
        self.estimator
    }

    /// Evaluations spent on what all directions share, not counted in their estimates.
    pub fn shared_evaluations(&self) -> u64 {
        self.unspent.map_or(0, |unspent| unspent.evaluations)
    }

    /// Computes the integral; `cell` names the random streams and has no effect on deterministic estimators.
    ///
    /// # Errors
    /// [`IntegrateError`]
    pub fn estimate(&self, target: Target, cell: u64) -> Result<Estimate, IntegrateError> {
        let Effort {
            tolerance,
            samples,
            seed,
        } = self.effort;
        match (self.estimator, &self.bxdf) {
            (Estimator::MonteCarlo(sampling), Some(bxdf)) => monte_carlo::estimate(
                bxdf.as_ref(),
                Trial {
                    sampling,
                    lobe: target.lobe,
                    outgoing: target
                        .outgoing
                        .map_or(Outgoing::Cosine, |angles| outgoing(angles.mu, angles.phi)),
                    samples: samples.map_or(
                        Samples::UpTo {
                            tolerance,
                            limit: SAMPLE_LIMIT,
                        },
                        Samples::Fixed,
                    ),
                    seed,
                    cell,
                },
            ),
            (Estimator::ClosedForm, _) => match closed_form(self.model) {
                Some(estimate) => Ok(estimate),
                None => quadrature(self.model, target, tolerance),
            },
            _ => match &self.unspent {
                Some(unspent) => quadrature_with(self.model, target, tolerance, unspent),
                None => quadrature(self.model, target, tolerance),
            },
        }
    }
}
