//! The choice of an estimator for a model, and its run.

use super::deterministic::{UNSPENT_SHARE, closed_form, quadrature, quadrature_with, unspent};
use super::monte_carlo::{self, Outgoing, Samples, Trial, outgoing};
use super::{Effort, Estimate, Estimator, IntegrateError, Target, coupled_bxdf};
use crate::bxdf::{Bxdf, CoupledBxdf, Model};

/// Most samples that a tolerance may ask for: some minutes of one core.
const SAMPLE_LIMIT: u64 = 1 << 34;

/// A model with the estimator that computes its integrals.
pub struct Integrator<'a> {
    model: &'a Model,
    estimator: Estimator,
    effort: Effort,
    /// The model as a [`Bxdf`], where Monte Carlo needs one.
    bxdf: Option<Sampled<'a>>,
    /// 1 - ks rho_bar, shared by all directions of a coupling.
    unspent: Option<Estimate>,
}

/// A model that can be sampled; couplings carry their precomputed albedo.
enum Sampled<'a> {
    Plain(&'a dyn Bxdf),
    Coupled(Box<CoupledBxdf<&'a dyn Bxdf>>),
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
            (Estimator::MonteCarlo(sampling), Some(bxdf)) => bxdf.estimate(Trial {
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
            }),
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

fn sampled(model: &Model) -> Result<Sampled<'_>, IntegrateError> {
    Ok(match model {
        Model::DiffuseSpecular(coupled) => {
            Sampled::Coupled(Box::new(coupled_bxdf(coupled, plain(coupled.specular()))?))
        }
        other => Sampled::Plain(plain(other)),
    })
}

fn plain(model: &Model) -> &dyn Bxdf {
    match model {
        Model::Lambertian(lambertian) => lambertian,
        Model::Microfacet(microfacet) => microfacet,
        // the scene refuses a coupling within a coupling
        Model::DiffuseSpecular(coupled) => plain(coupled.specular()),
    }
}

impl Sampled<'_> {
    fn estimate(&self, trial: Trial) -> Result<Estimate, IntegrateError> {
        match self {
            Self::Plain(bxdf) => monte_carlo::estimate(*bxdf, trial),
            Self::Coupled(bxdf) => {
                let estimate = monte_carlo::estimate(bxdf.as_ref(), trial)?;
                // the curve that the coupling reads its albedo from is off by a little everywhere
                let curve = match trial.outgoing {
                    Outgoing::Fixed(wo) => bxdf.albedo_error(wo.z),
                    Outgoing::Cosine => bxdf.albedo_error(1.0).max(bxdf.albedo_error(0.0)),
                };
                Ok(Estimate {
                    error: estimate.error + curve,
                    ..estimate
                })
            }
        }
    }
}
