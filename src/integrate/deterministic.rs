//! Closed forms and quadrature of the models that scenes name.

use super::{Angles, ErrorKind, Estimate, Estimator, IntegrateError, Target, facets, microfacet_hd, microfacet_hh};
use crate::bxdf::{DiffuseSpecular, Model};
use crate::fresnel::Fresnel;
use crate::masking::Masking;
use crate::numerics::quadrature::Integral;
use glam::DVec3;

/// Share of the tolerance that goes to rho_bar of a coupling.
pub(super) const UNSPENT_SHARE: f64 = 0.1;

/// The closed form, where there is one.
pub fn closed_form(model: &Model) -> Option<Estimate> {
    match model {
        Model::Lambertian(lambertian) => Some(exact(lambertian.albedo())),
        Model::Microfacet(_) => None,
        Model::DiffuseSpecular(coupled) => {
            let rho = closed_form(coupled.specular())?.value;
            let unspent = DVec3::ONE - coupled.ks().value() * rho;
            Some(exact(coupled.total_albedo(rho, unspent)))
        }
    }
}

/// Deterministic integration to an absolute error of at most `tolerance`.
///
/// # Errors
/// [`IntegrateError::NotConverged`], or [`IntegrateError::Diverges`] where the integral has no finite value.
pub fn quadrature(model: &Model, target: Target, tolerance: f64) -> Result<Estimate, IntegrateError> {
    match model {
        Model::Lambertian(lambertian) => Ok(exact(lambertian.albedo())),
        Model::Microfacet(microfacet) => {
            let grooves = !microfacet.masking.is_smith();
            let Some(distribution) = microfacet.distribution.isotropic().filter(|_| grooves) else {
                return Ok(bound(match target.outgoing {
                    Some(Angles { mu, phi }) => facets::rho_hd(microfacet, mu, phi, tolerance)?,
                    None => facets::rho_hh(microfacet, tolerance)?,
                }));
            };
            if microfacet.masking.is_smith() {
                return Err(IntegrateError::Unsupported {
                    estimator: Estimator::Quadrature,
                    reason: "its masking is of Smith's kind; use mc-visible",
                });
            }
            Ok(bound(match target.outgoing {
                Some(Angles { mu, .. }) => microfacet_hd::rho_hd(microfacet, distribution, mu, tolerance)?,
                None => microfacet_hh::rho_hh(microfacet, distribution, tolerance)?,
            }))
        }
        Model::DiffuseSpecular(coupled) => {
            let unspent = unspent(coupled, UNSPENT_SHARE * tolerance)?;
            let estimate = coupled_albedo(coupled, target, tolerance, &unspent)?;
            Ok(Estimate {
                evaluations: estimate.evaluations + unspent.evaluations,
                ..estimate
            })
        }
    }
}

/// 1 - ks rho_hh of the specular lobe, as accurate as its use needs: relative accuracy where rho_hh is close to 1.
///
/// # Errors
/// As [`quadrature`].
pub fn unspent(coupled: &DiffuseSpecular, tolerance: f64) -> Result<Estimate, IntegrateError> {
    let ks = coupled.ks().value();
    if let Model::Microfacet(microfacet) = coupled.specular()
        && microfacet.masking == Masking::VGroove
        && microfacet.fresnel == Fresnel::None
        && let Some(distribution) = microfacet.distribution.isotropic()
    {
        // what a narrow lobe loses is of the order of its squared width
        let width = distribution.width();
        let lost = microfacet_hh::lost_hh(distribution, tolerance * (width * width).min(1.0))?;
        let scale = ks * microfacet.reflectance.value();
        let value = (DVec3::ONE - scale) + scale * lost.bounded.value;
        return Ok(Estimate {
            value,
            error: scale * lost.bounded.error,
            ..bound(lost)
        });
    }
    let rho = quadrature(coupled.specular(), Target::rho_hh(), tolerance)?;
    Ok(Estimate {
        value: DVec3::ONE - ks * rho.value,
        error: ks * rho.error,
        ..rho
    })
}

/// [`quadrature`] of a coupling whose 1 - ks rho_bar is known already; its evaluations are not counted again.
///
/// # Errors
/// As [`quadrature`].
pub fn quadrature_with(
    model: &Model,
    target: Target,
    tolerance: f64,
    unspent: &Estimate,
) -> Result<Estimate, IntegrateError> {
    match model {
        Model::DiffuseSpecular(coupled) => coupled_albedo(coupled, target, tolerance, unspent),
        other => quadrature(other, target, tolerance),
    }
}

/// The albedo of eq. 28 from those of its specular lobe, which takes what rho_bar leaves of the tolerance.
fn coupled_albedo(
    coupled: &DiffuseSpecular,
    target: Target,
    tolerance: f64,
    unspent: &Estimate,
) -> Result<Estimate, IntegrateError> {
    match target.outgoing {
        Some(_) => {
            let rho = quadrature(coupled.specular(), target, (1.0 - UNSPENT_SHARE) * tolerance)?;
            Ok(Estimate {
                value: coupled.total_albedo(rho.value, unspent.value),
                error: coupled.total_albedo_error(rho.value, rho.error, unspent.value, unspent.error),
                ..rho
            })
        }
        None => Ok(Estimate {
            value: coupled.total_mean_albedo(unspent.value),
            evaluations: 0,
            // the slope in 1 - ks rho_bar is between -1 and 1
            ..*unspent
        }),
    }
}

fn exact(value: DVec3) -> Estimate {
    // a handful of roundings
    let error = value.abs() * 4.0 * f64::EPSILON;
    Estimate {
        value,
        error,
        kind: ErrorKind::Exact,
        estimator: Estimator::ClosedForm,
        evaluations: 0,
    }
}

fn bound(integral: Integral) -> Estimate {
    Estimate {
        value: integral.bounded.value,
        error: integral.bounded.error,
        kind: ErrorKind::Bound,
        estimator: Estimator::Quadrature,
        evaluations: integral.evaluations,
    }
}
