//! Closed forms and quadrature of the models that scenes name.

use super::hemisphere::Mean;
use super::{
    Angles, ErrorKind, Estimate, Estimator, IntegrateError, Lobe, Target, facets, half_angle_hd, half_angle_hh, layers,
    microfacet_hd, microfacet_hh, rough_dielectric, sheen, smith_hd,
};
use crate::bxdf::{DiffuseSpecular, Flags, FresnelBlend, Microfacet, Model, SpecularReflection};
use crate::distribution::Isotropic;
use crate::fresnel::Fresnel;
use crate::masking::Masking;
use crate::numerics::quadrature::{Bounded, Integral};
use glam::DVec3;

/// Share of the tolerance that goes to rho_bar of a coupling.
pub(super) const UNSPENT_SHARE: f64 = 0.1;

/// The closed form, where there is one.
pub fn closed_form(model: &Model, target: Target) -> Option<Estimate> {
    let sides = target.lobe.flag();
    if !model.flags().contains(sides) {
        // nothing goes there
        return Some(rounded(Bounded::exact(DVec3::ZERO)));
    }
    match model {
        Model::Lambertian(lambertian) => Some(exact(lambertian.albedo())),
        Model::OrenNayar(rough) => Some(exact(match target.outgoing {
            Some(Angles { mu, .. }) => rough.rho_hd(mu),
            None => rough.rho_hh(),
        })),
        Model::SpecularReflection(mirror) => match target.outgoing {
            Some(Angles { mu, .. }) => Some(exact(mirror.rho_hd(sides, mu))),
            None => mirror.rho_hh(sides).map(rounded),
        },
        Model::SpecularTransmission(window) => Some(match target.outgoing {
            Some(Angles { mu, .. }) => exact(window.rho_hd(sides, mu)),
            None => rounded(window.rho_hh(sides)),
        }),
        Model::FresnelSpecular(glass) => Some(match target.outgoing {
            Some(Angles { mu, .. }) => exact(glass.rho_hd(sides, mu)),
            None => rounded(glass.rho_hh(sides)),
        }),
        Model::Microfacet(_)
        | Model::FresnelBlend(_)
        | Model::RoughDielectric(_)
        | Model::HalfAngle(_)
        | Model::Irregular(_) => None,
        Model::BrdfToBtdf(mirrored) => closed_form(mirrored.bxdf(), target.of(target.lobe.other())),
        Model::Scaled(scaled) => Some(closed_form(scaled.bxdf(), target)?.scaled(scaled.scale().value())),
        Model::Sum(sum) => {
            let parts: Option<Vec<Estimate>> = sum.parts().iter().map(|part| closed_form(part, target)).collect();
            Some(added(parts?))
        }
        Model::DiffuseSpecular(coupled) => {
            let mean = closed_form(coupled.specular(), Target::rho_hh())?;
            let unspent = unspent_of(coupled, mean);
            match target.outgoing {
                Some(_) => Some(total_albedo(
                    coupled,
                    closed_form(coupled.specular(), target)?,
                    &unspent,
                )),
                None => Some(total_mean(coupled, unspent)),
            }
        }
        Model::Layered(layered) => layers::closed(layered, target),
    }
}

/// Deterministic integration to an absolute error of at most `tolerance`.
///
/// # Errors
/// [`IntegrateError::NotConverged`], [`IntegrateError::Diverges`] where the integral has no finite value, and
/// [`IntegrateError::Unsupported`] for irregular samples.
pub fn quadrature(model: &Model, target: Target, tolerance: f64) -> Result<Estimate, IntegrateError> {
    if let Some(estimate) = closed_form(model, target) {
        return Ok(estimate);
    }
    match model {
        Model::Microfacet(microfacet) => Ok(bound(of_microfacet(microfacet, target, tolerance)?)),
        Model::FresnelBlend(blend) => of_blend(blend, target, tolerance),
        Model::RoughDielectric(glass) => Ok(bound(rough_dielectric::quadrature(glass, target, tolerance)?)),
        Model::HalfAngle(table) => Ok(bound(match target.outgoing {
            Some(Angles { mu, .. }) => half_angle_hd::rho_hd(table, mu, tolerance)?,
            None => half_angle_hh::rho_hh(table, tolerance)?,
        })),
        Model::SpecularReflection(mirror) => Ok(bound(mean_of_mirror(mirror, tolerance)?)),
        Model::BrdfToBtdf(mirrored) => quadrature(mirrored.bxdf(), target.of(target.lobe.other()), tolerance),
        Model::Scaled(scaled) => Ok(quadrature(scaled.bxdf(), target, tolerance)?.scaled(scaled.scale().value())),
        Model::Sum(sum) => {
            let share = tolerance / sum.parts().len() as f64;
            let parts: Result<Vec<Estimate>, IntegrateError> =
                sum.parts().iter().map(|part| quadrature(part, target, share)).collect();
            Ok(added(parts?))
        }
        Model::DiffuseSpecular(coupled) => {
            let unspent = unspent(coupled, UNSPENT_SHARE * tolerance)?;
            let estimate = coupled_albedo(coupled, target, tolerance, &unspent)?;
            Ok(Estimate {
                evaluations: estimate.evaluations + unspent.evaluations,
                ..estimate
            })
        }
        Model::Layered(layered) => layers::integrated(layered, target, tolerance),
        Model::Irregular(_) => Err(IntegrateError::Unsupported {
            estimator: Estimator::Quadrature,
            reason: "f jumps between irregular samples; use auto or qmc-bxdf",
        }),
        Model::Lambertian(_) | Model::OrenNayar(_) | Model::SpecularTransmission(_) | Model::FresnelSpecular(_) => {
            Err(IntegrateError::Unsupported {
                estimator: Estimator::Quadrature,
                reason: "it has a closed form; use auto",
            })
        }
    }
}

fn of_microfacet(microfacet: &Microfacet, target: Target, tolerance: f64) -> Result<Integral, IntegrateError> {
    if let Some(Isotropic::Charlie(charlie)) = microfacet.distribution.isotropic() {
        return match target.outgoing {
            Some(Angles { mu, .. }) => sheen::rho_hd(microfacet, charlie, mu, tolerance),
            None => sheen::rho_hh(microfacet, charlie, tolerance),
        };
    }
    // V-grooves and no masking have integrators of their own, with the azimuth integral inside, for isotropic lobes
    let isotropic = microfacet
        .distribution
        .isotropic()
        .filter(|_| !microfacet.masking.is_smith());
    match (isotropic, target.outgoing) {
        (Some(lobe), Some(Angles { mu, .. })) => microfacet_hd::rho_hd(microfacet, lobe, mu, tolerance),
        (Some(lobe), None) => microfacet_hh::rho_hh(microfacet, lobe, tolerance),
        // isotropic Smith lobes have rules of their own, where those certify
        (None, Some(Angles { mu, phi })) => match smith_hd::rho_hd(microfacet, mu, tolerance) {
            Some(integral) => Ok(integral),
            None => facets::rho_hd(microfacet, mu, phi, tolerance),
        },
        (None, None) => facets::rho_hh(microfacet, tolerance),
    }
}

/// The diffuse part in closed form, the coat by quadrature.
fn of_blend(blend: &FresnelBlend, target: Target, tolerance: f64) -> Result<Estimate, IntegrateError> {
    let (diffuse, coat) = match target.outgoing {
        Some(Angles { mu, phi }) => (
            blend.diffuse_rho_hd(mu),
            facets::coat_rho_hd(blend, mu, phi, tolerance)?,
        ),
        None => (blend.diffuse_rho_hh(), facets::coat_rho_hh(blend, tolerance)?),
    };
    Ok(added(vec![exact(diffuse), bound(coat)]))
}

/// rho_hh of a mirror whose Fresnel term has no mean in closed form: 2 int F mu dmu.
fn mean_of_mirror(mirror: &SpecularReflection, tolerance: f64) -> Result<Integral, IntegrateError> {
    let edges = mirror.fresnel().edges();
    let marks: Vec<(f64, bool)> = edges.iter().map(|edge| (edge.cos, edge.kink)).collect();
    Mean {
        marks: &marks,
        anisotropic: false,
        bound: 1.0,
        grows: false,
    }
    .integrate(tolerance, |mu, _, _| {
        Ok(Integral {
            bounded: Bounded::exact(mirror.rho_hd(Flags::REFLECTION, mu)),
            evaluations: 1,
        })
    })
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
    let mean = quadrature(coupled.specular(), Target::rho_hh(), tolerance)?;
    Ok(unspent_of(coupled, mean))
}

/// 1 - ks rho_hh from rho_hh.
pub(super) fn unspent_of(coupled: &DiffuseSpecular, mean: Estimate) -> Estimate {
    let ks = coupled.ks().value();
    Estimate {
        value: DVec3::ONE - ks * mean.value,
        error: ks * mean.error,
        ..mean
    }
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
        Model::DiffuseSpecular(coupled) if target.lobe == Lobe::Reflection => {
            coupled_albedo(coupled, target, tolerance, unspent)
        }
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
            Ok(total_albedo(coupled, rho, unspent))
        }
        None => Ok(Estimate {
            evaluations: 0,
            ..total_mean(coupled, *unspent)
        }),
    }
}

/// rho_hd of the whole from that of its specular lobe.
pub(super) fn total_albedo(coupled: &DiffuseSpecular, rho: Estimate, unspent: &Estimate) -> Estimate {
    Estimate {
        value: coupled.total_albedo(rho.value, unspent.value),
        error: coupled.total_albedo_error(rho.value, rho.error, unspent.value, unspent.error) + DVec3::splat(ROUNDING),
        kind: rho.kind.max(unspent.kind),
        estimator: if unspent.kind > rho.kind {
            unspent.estimator
        } else {
            rho.estimator
        },
        ..rho
    }
}

/// rho_hh of the whole; its slope in 1 - ks rho_bar is between -1 and 1.
pub(super) fn total_mean(coupled: &DiffuseSpecular, unspent: Estimate) -> Estimate {
    Estimate {
        value: coupled.total_mean_albedo(unspent.value),
        error: unspent.error + DVec3::splat(ROUNDING),
        ..unspent
    }
}

/// The sum of all parts; of what is exact and what is not the worst is said.
fn added(parts: Vec<Estimate>) -> Estimate {
    let none = rounded(Bounded::exact(DVec3::ZERO));
    parts.into_iter().fold(none, |sum, part| Estimate {
        value: sum.value + part.value,
        error: sum.error + part.error,
        kind: sum.kind.max(part.kind),
        estimator: if part.kind > sum.kind {
            part.estimator
        } else {
            sum.estimator
        },
        evaluations: sum.evaluations + part.evaluations,
    })
}

/// A handful of roundings of numbers up to 1, which small values may be differences of.
const ROUNDING: f64 = 4.0 * f64::EPSILON;

fn exact(value: DVec3) -> Estimate {
    rounded(Bounded {
        value,
        error: value.abs().max(DVec3::ONE) * ROUNDING,
    })
}

fn rounded(closed: Bounded) -> Estimate {
    Estimate {
        value: closed.value,
        error: closed.error,
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
