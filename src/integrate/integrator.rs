//! The choice of an estimator for a model, and its run.

use super::deterministic::{Integrand, UNSPENT_SHARE, closed_form, quadrature, quadrature_with, unspent};
use super::monte_carlo::{self, Outgoing, Samples, outgoing};
use super::{Effort, Estimate, Estimator, IntegrateError, coupled_bxdf};
use crate::bxdf::{Bxdf, CoupledBxdf, Model, Sampling};

/// Most samples that a tolerance may ask for: some minutes of one core.
const SAMPLE_LIMIT: u64 = 1 << 34;

/// The quantity and the direction that an estimate is for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Target {
    /// rho_hd at cos theta_o = `mu` and azimuth `phi` in radians.
    RhoHd {
        /// Cosine in [0, 1].
        mu: f64,
        /// Azimuth in radians.
        phi: f64,
    },
    /// rho_hh.
    RhoHh,
}

impl Target {
    fn integrand(self) -> Integrand {
        match self {
            Self::RhoHd { mu, .. } => Integrand::RhoHd(mu),
            Self::RhoHh => Integrand::RhoHh,
        }
    }
}

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
            (Estimator::MonteCarlo(sampling), Some(bxdf)) => {
                let outgoing = match target {
                    Target::RhoHd { mu, phi } => outgoing(mu, phi),
                    Target::RhoHh => Outgoing::Cosine,
                };
                let samples = samples.map_or(
                    Samples::UpTo {
                        tolerance,
                        limit: SAMPLE_LIMIT,
                    },
                    Samples::Fixed,
                );
                bxdf.estimate(sampling, outgoing, samples, seed, cell)
            }
            (Estimator::ClosedForm, _) => match closed_form(self.model) {
                Some(estimate) => Ok(estimate),
                None => quadrature(self.model, target.integrand(), tolerance),
            },
            _ => match &self.unspent {
                Some(unspent) => quadrature_with(self.model, target.integrand(), tolerance, unspent),
                None => quadrature(self.model, target.integrand(), tolerance),
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
    fn estimate(
        &self,
        sampling: Sampling,
        outgoing: Outgoing,
        samples: Samples,
        seed: u64,
        cell: u64,
    ) -> Result<Estimate, IntegrateError> {
        match self {
            Self::Plain(bxdf) => monte_carlo::estimate(*bxdf, sampling, outgoing, samples, seed, cell),
            Self::Coupled(bxdf) => {
                let estimate = monte_carlo::estimate(bxdf.as_ref(), sampling, outgoing, samples, seed, cell)?;
                // the curve that the coupling reads its albedo from is off by a little everywhere
                let curve = match outgoing {
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
