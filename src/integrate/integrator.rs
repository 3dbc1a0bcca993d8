//! The choice of an estimator for a model, and its run.

use super::deterministic::{
    UNSPENT_SHARE, closed_form, quadrature, quadrature_with, total_albedo, total_mean, unspent, unspent_of,
};
use super::monte_carlo::{self, Outgoing, Samples, Trial, outgoing};
use super::{Effort, Estimate, Estimator, IntegrateError, Lobe, Target, sampled, unbounded};
use crate::bxdf::{Bxdf, DiffuseSpecular, Model, Sampling};
use crate::numerics::points::Points;
use crate::numerics::quadrature::NotConverged;
use glam::DVec3;

/// Most samples that a tolerance may ask for: some minutes of one core.
const SAMPLE_LIMIT: u64 = 1 << 34;

/// For irregular samples. Published files take 3600 to 75 000 quasi-random draws of the model's own to 1e-2 where random ones
/// take 4100 to 1.5 million; to 1e-3 the middle one of them takes a quarter.
const MEASURED: Estimator = Estimator::MonteCarlo {
    sampling: Sampling::Bxdf,
    points: Points::Quasi,
};

/// What sums of some hundred terms of albedos round off comes on top of the tolerance.
const ROUNDING: f64 = 2e-14;

/// Cell of the random streams of what all directions share; cells of directions count from 0.
const SHARED_CELL: u64 = u64::MAX;

/// A model with the estimator that computes its integrals.
pub struct Integrator<'a> {
    model: &'a Model,
    estimator: Estimator,
    effort: Effort,
    /// The model, or of a coupling over irregular samples its specular lobe, where Monte Carlo needs it.
    bxdf: Option<Box<dyn Bxdf + 'a>>,
    /// 1 - ks rho_bar, shared by all directions of a coupling.
    unspent: Option<Estimate>,
}

impl<'a> Integrator<'a> {
    /// Prepares what the estimator needs.
    ///
    /// `auto` is the closed form where there is one, Monte Carlo for irregular samples and quadrature otherwise: at every
    /// tolerance the rules need fewer evaluations than the first batch of samples that a confidence interval is built on.
    /// See `tests/bounds.rs`.
    ///
    /// # Errors
    /// [`IntegrateError::Unsupported`] when the estimator cannot compute the model.
    pub fn new(model: &'a Model, estimator: Estimator, effort: Effort) -> Result<Self, IntegrateError> {
        let mut integrator = Self {
            model,
            estimator,
            effort,
            bxdf: None,
            unspent: None,
        };
        let share = UNSPENT_SHARE * effort.tolerance;
        match (estimator, model) {
            (Estimator::MonteCarlo { .. }, _) => integrator.bxdf = Some(sampled(model)?),
            (Estimator::Auto, Model::DiffuseSpecular(coupled)) if model.is_irregular() => {
                // the lobe is sampled and the coupling computed, so that no albedo between directions is needed
                integrator.bxdf = Some(sampled(coupled.specular())?);
                let mean = integrator.draw((Sampling::Bxdf, Points::Quasi), Target::rho_hh(), share, SHARED_CELL)?;
                integrator.unspent = Some(unspent_of(coupled, mean));
            }
            (Estimator::Auto, _) if model.is_irregular() => integrator.bxdf = Some(sampled(model)?),
            (Estimator::Auto | Estimator::Quadrature, Model::DiffuseSpecular(coupled)) => {
                let shared = unspent(coupled, share).map_err(|error| error.of_whole(effort.tolerance))?;
                integrator.unspent = Some(shared);
            }
            _ => {}
        }
        Ok(integrator)
    }

    /// The estimator that `target` gets, never [`Estimator::Auto`].
    pub fn estimator(&self, target: Target) -> Estimator {
        match self.estimator {
            Estimator::Auto if closed_form(self.model, target).is_some() => Estimator::ClosedForm,
            Estimator::Auto if self.model.is_irregular() => MEASURED,
            Estimator::Auto => Estimator::Quadrature,
            chosen => chosen,
        }
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
        let tolerance = self.effort.tolerance;
        match (self.estimator(target), &self.unspent) {
            (estimator @ Estimator::ClosedForm, _) => {
                closed_form(self.model, target).ok_or(IntegrateError::Unsupported {
                    estimator,
                    reason: "it has no closed form; use auto",
                })
            }
            (Estimator::MonteCarlo { sampling, points }, Some(unspent)) => match self.model {
                Model::DiffuseSpecular(coupled) if target.lobe == Lobe::Reflection => {
                    self.over_samples(coupled, unspent, (sampling, points), target, cell)
                }
                _ => self.draw((sampling, points), target, tolerance, cell),
            },
            (Estimator::MonteCarlo { sampling, points }, None) => {
                self.draw((sampling, points), target, tolerance, cell)
            }
            (_, Some(unspent)) => self.kept(quadrature_with(self.model, target, tolerance, unspent)),
            (_, None) => self.kept(quadrature(self.model, target, tolerance)),
        }
    }

    /// What quadrature found, if it has kept the tolerance; failures in terms of that.
    fn kept(&self, found: Result<Estimate, IntegrateError>) -> Result<Estimate, IntegrateError> {
        let tolerance = self.effort.tolerance;
        let estimate = found.map_err(|error| error.of_whole(tolerance))?;
        if estimate.error.cmple(DVec3::splat(tolerance + ROUNDING)).all() {
            return Ok(estimate);
        }
        Err(NotConverged {
            reached: estimate.error.max_element(),
            tolerance,
            evaluations: estimate.evaluations,
        }
        .into())
    }

    /// A coupling over a lobe that only samples know.
    fn over_samples(
        &self,
        coupled: &DiffuseSpecular,
        unspent: &Estimate,
        (sampling, points): (Sampling, Points),
        target: Target,
        cell: u64,
    ) -> Result<Estimate, IntegrateError> {
        if target.outgoing.is_none() {
            return Ok(total_mean(coupled, *unspent));
        }
        let share = (1.0 - UNSPENT_SHARE) * self.effort.tolerance;
        let rho = self.draw((sampling, points), target, share, cell)?;
        Ok(total_albedo(coupled, rho, unspent))
    }

    fn draw(
        &self,
        (sampling, points): (Sampling, Points),
        target: Target,
        tolerance: f64,
        cell: u64,
    ) -> Result<Estimate, IntegrateError> {
        let Some(bxdf) = &self.bxdf else {
            return Err(IntegrateError::Unsupported {
                estimator: Estimator::MonteCarlo { sampling, points },
                reason: "it was not made ready for sampling; use auto",
            });
        };
        unbounded::refuse(self.model, target)?;
        let samples = self.effort.samples.map_or(
            Samples::UpTo {
                tolerance,
                limit: SAMPLE_LIMIT,
            },
            Samples::Fixed,
        );
        let trial = Trial {
            sampling,
            points,
            lobe: target.lobe,
            outgoing: target
                .outgoing
                .map_or(Outgoing::Cosine, |angles| outgoing(angles.mu, angles.phi)),
            samples,
            seed: self.effort.seed,
            cell,
        };
        monte_carlo::estimate(bxdf.as_ref(), trial)
    }
}
