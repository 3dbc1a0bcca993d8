//! Eq. 28 made ready for sampling: the specular albedo that it needs, computed once.

use super::deterministic::{quadrature, unspent};
use super::{Estimator, IntegrateError, Target};
use crate::bxdf::{Bxdf, CoupledBxdf, DiffuseSpecular, Sampling, SpecularAlbedo};
use crate::numerics::quadrature::Bounded;
use crate::numerics::surface::Surface;

/// Error of the interpolated specular albedo: far below what Monte Carlo resolves, and cheap.
const CURVE_TOLERANCE: f64 = 1e-7;

/// The same with an azimuth, which takes a curve for each of its nodes.
const SURFACE_TOLERANCE: f64 = 1e-5;

/// The coupled BRDF of `parameters`, whose specular lobe as a [`Bxdf`] is `specular`.
///
/// # Errors
/// [`IntegrateError`] when the specular albedo cannot be computed, for a lobe that diverges at grazing angles above all.
pub fn coupled_bxdf<S: Bxdf>(parameters: &DiffuseSpecular, specular: S) -> Result<CoupledBxdf<S>, IntegrateError> {
    let lobe = parameters.specular();
    // a curve would follow 1/mu for ever: ask at the limit first
    quadrature(lobe, Target::rho_hd(0.0, 0.0), CURVE_TOLERANCE).map_err(|error| match error {
        IntegrateError::Diverges(_) => IntegrateError::Unsupported {
            estimator: Estimator::random(Sampling::Bxdf),
            reason: "its coupling needs the albedo of the specular lobe from every direction, and that grows without bound as \
                     mu -> 0; use quadrature, or another masking or distribution",
        },
        error => error,
    })?;
    let rho = |mu: f64, phi: f64, tolerance: f64| {
        let rho = quadrature(lobe, Target::rho_hd(mu, phi), 0.1 * tolerance)?;
        Ok::<_, IntegrateError>(Bounded {
            value: rho.value,
            error: rho.error,
        })
    };
    let (rho_hd, tolerance) = if lobe.is_anisotropic() {
        let rho = |mu: f64, phi: f64| rho(mu, phi, SURFACE_TOLERANCE);
        (
            Surface::anisotropic(SURFACE_TOLERANCE, lobe.width(), rho)?,
            SURFACE_TOLERANCE,
        )
    } else {
        let rho = |mu: f64| rho(mu, 0.0, CURVE_TOLERANCE);
        (Surface::isotropic(CURVE_TOLERANCE, lobe.width(), rho)?, CURVE_TOLERANCE)
    };
    let unspent = unspent(parameters, tolerance)?.value;
    Ok(CoupledBxdf::new(
        parameters.clone(),
        specular,
        SpecularAlbedo { rho_hd, unspent },
    ))
}
