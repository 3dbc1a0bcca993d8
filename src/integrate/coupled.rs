//! Eq. 28 made ready for sampling: the specular albedo that it needs, computed once.

use super::deterministic::{quadrature, unspent};
use super::{IntegrateError, Target};
use crate::bxdf::{Bxdf, CoupledBxdf, DiffuseSpecular, Model, SpecularAlbedo};
use crate::numerics::curve::Curve;
use crate::numerics::quadrature::Bounded;

/// Error of the interpolated specular albedo: far below what Monte Carlo resolves, and cheap.
const CURVE_TOLERANCE: f64 = 1e-7;

/// The coupled BRDF of `parameters`, whose specular lobe as a [`Bxdf`] is `specular`.
///
/// # Errors
/// [`IntegrateError`] when the specular albedo cannot be computed, for a lobe that diverges at grazing angles above all.
pub fn coupled_bxdf<S: Bxdf>(parameters: &DiffuseSpecular, specular: S) -> Result<CoupledBxdf<S>, IntegrateError> {
    let lobe = parameters.specular();
    let layer = match lobe {
        Model::Microfacet(microfacet) => microfacet.distribution.width(),
        Model::Lambertian(_) | Model::DiffuseSpecular(_) => 1.0,
    };
    // a curve would follow 1/mu for ever: ask at the limit first
    quadrature(lobe, Target::rho_hd(0.0, 0.0), CURVE_TOLERANCE)?;
    let rho_hd = Curve::fit(CURVE_TOLERANCE, layer, &mut |mu| {
        let rho = quadrature(lobe, Target::rho_hd(mu, 0.0), 0.1 * CURVE_TOLERANCE)?;
        Ok::<_, IntegrateError>(Bounded {
            value: rho.value,
            error: rho.error,
        })
    })?;
    let unspent = unspent(parameters, CURVE_TOLERANCE)?.value;
    Ok(CoupledBxdf::new(
        parameters.clone(),
        specular,
        SpecularAlbedo { rho_hd, unspent },
    ))
}
