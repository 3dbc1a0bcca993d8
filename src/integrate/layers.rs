//! Layers: their albedo from those of the layer and of what lies below, and the same made ready for sampling.

use super::deterministic::{closed_form, quadrature, quadrature_with, unspent};
use super::hemisphere::Mean;
use super::{Angles, ErrorKind, Estimate, Estimator, IntegrateError, Lobe, Target, sampled, unbounded};
use crate::bxdf::{Bxdf, Layered, Model, Sampling, Sum, Veil, VeiledBxdf};
use crate::distribution::Isotropic;
use crate::masking::Masking;
use crate::numerics::quadrature::{Bounded, Integral};
use crate::numerics::surface::Surface;
use glam::DVec3;

/// Shares of the tolerance that the layer and what lies below may use; the error of the layer counts twice, since it dims, too.
const TOP_SHARE: f64 = 0.25;
const BASE_SHARE: f64 = 0.4;

/// Share of it that goes to what all directions of a coupling share.
const SHARED_SHARE: f64 = 0.05;

/// Errors of the interpolated albedo of a layer, as of couplings.
const CURVE_TOLERANCE: f64 = 1e-7;
const SURFACE_TOLERANCE: f64 = 1e-5;

/// What rho_hd of both is rounded by.
const ROUNDING: f64 = 4.0 * f64::EPSILON;

/// rho_hd of all layers from those of the layer, on the side that it reflects to, and of what lies below.
fn total(layered: &Layered, lobe: Lobe, mu: f64, top: Estimate, base: Estimate) -> Estimate {
    let left = layered.left(mu, top.value);
    let off = match layered.veil() {
        Veil::Albedo => top.error.max_element(),
        Veil::Fresnel => 0.0,
    };
    let (own, own_error) = match lobe {
        Lobe::Reflection => (top.value, top.error),
        Lobe::Transmission => (DVec3::ZERO, DVec3::ZERO),
    };
    let worst = if top.kind > base.kind { top } else { base };
    Estimate {
        value: own + left * base.value,
        error: own_error + left * base.error + off * (base.value.abs() + base.error) + DVec3::splat(ROUNDING),
        evaluations: top.evaluations + base.evaluations,
        ..worst
    }
}

/// rho_hd where both have closed forms.
pub(super) fn closed(layered: &Layered, target: Target) -> Option<Estimate> {
    let mu = target.outgoing?.mu;
    let top = closed_form(layered.top(), target.of(Lobe::Reflection))?;
    Some(total(
        layered,
        target.lobe,
        mu,
        top,
        closed_form(layered.base(), target)?,
    ))
}

/// rho_hd and rho_hh.
pub(super) fn integrated(layered: &Layered, target: Target, tolerance: f64) -> Result<Estimate, IntegrateError> {
    // what a coupling below needs to know of all directions is computed once
    let shared = match layered.base() {
        Model::DiffuseSpecular(coupled) => Some(unspent(coupled, SHARED_SHARE * tolerance)?),
        _ => None,
    };
    let along = |angles: Angles, tolerance: f64| {
        let target = Target::rho_hd(angles.mu, angles.phi).of(target.lobe);
        let top = quadrature(layered.top(), target.of(Lobe::Reflection), TOP_SHARE * tolerance)?;
        let base = match &shared {
            Some(shared) => quadrature_with(layered.base(), target, BASE_SHARE * tolerance, shared)?,
            None => quadrature(layered.base(), target, BASE_SHARE * tolerance)?,
        };
        Ok(total(layered, target.lobe, angles.mu, top, base))
    };
    if let Some(angles) = target.outgoing {
        return along(angles, tolerance);
    }
    let parts = [layered.top(), layered.base()];
    let mean = Mean {
        marks: &parts.map(|part| (part.width(), false)),
        anisotropic: parts.into_iter().any(Model::is_anisotropic),
        bound: parts.into_iter().map(bound).sum(),
        grows: parts.into_iter().any(grows),
    }
    .integrate(tolerance, |mu, phi, allowed| {
        let estimate = along(Angles { mu, phi }, allowed)?;
        Ok(Integral {
            bounded: Bounded {
                value: estimate.value,
                error: estimate.error,
            },
            evaluations: estimate.evaluations.max(1),
        })
    })?;
    Ok(Estimate {
        value: mean.bounded.value,
        error: mean.bounded.error,
        kind: ErrorKind::Bound,
        estimator: Estimator::Quadrature,
        evaluations: mean.evaluations,
    })
}

/// Bound of rho near mu = 0, or of mu rho where that grows.
fn bound(model: &Model) -> f64 {
    match model {
        Model::Microfacet(lobe) => match lobe.distribution.isotropic() {
            Some(Isotropic::Charlie(charlie)) => 0.5 * (2.0 + charlie.exponent()),
            _ => 2.0,
        },
        _ => model.parts().into_iter().map(bound).fold(2.0, f64::max),
    }
}

fn grows(model: &Model) -> bool {
    match model {
        Model::Microfacet(lobe) => lobe.masking == Masking::None,
        Model::FresnelBlend(blend) => unbounded::is_vmf(blend.distribution()),
        _ => model.parts().into_iter().any(grows),
    }
}

/// The layers as a [`Bxdf`].
///
/// # Errors
/// [`IntegrateError`] when the albedo of the layer is needed and cannot be computed.
pub(super) fn bxdf(layered: &Layered) -> Result<Box<dyn Bxdf + '_>, IntegrateError> {
    let top = layered.top();
    let albedo = match layered.veil() {
        Veil::Fresnel => None,
        Veil::Albedo if top.is_irregular() => {
            return Err(unsupported(
                "between directions the albedo of irregular samples is not known well enough; use auto",
            ));
        }
        Veil::Albedo if grows(top) => {
            return Err(unsupported(
                "its veil needs the albedo of the layer from every direction, and that grows without bound as mu -> 0; use \
                 quadrature, or another masking or distribution",
            ));
        }
        Veil::Albedo => Some(albedo(top)?),
    };
    let veiled = VeiledBxdf::new(layered, sampled(layered.base())?, albedo);
    let parts: Vec<Box<dyn Bxdf + '_>> = vec![sampled(top)?, Box::new(veiled)];
    Ok(Box::new(Sum::new(parts)))
}

fn unsupported(reason: &'static str) -> IntegrateError {
    IntegrateError::Unsupported {
        estimator: Estimator::random(Sampling::Bxdf),
        reason,
    }
}

/// rho_hd of `top` over all directions.
fn albedo(top: &Model) -> Result<Surface, IntegrateError> {
    let rho = |mu: f64, phi: f64, tolerance: f64| {
        let rho = quadrature(top, Target::rho_hd(mu, phi), 0.1 * tolerance)?;
        Ok::<_, IntegrateError>(Bounded {
            value: rho.value,
            error: rho.error,
        })
    };
    if top.is_anisotropic() {
        return Surface::anisotropic(SURFACE_TOLERANCE, top.width(), |mu, phi| {
            rho(mu, phi, SURFACE_TOLERANCE)
        });
    }
    Surface::isotropic(CURVE_TOLERANCE, top.width(), |mu| rho(mu, 0.0, CURVE_TOLERANCE))
}
