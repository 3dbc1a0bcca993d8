//! Models made ready for sampling.

use super::{IntegrateError, coupled_bxdf};
use crate::bxdf::{Bxdf, Model};

/// The model as a [`Bxdf`]; couplings get the specular albedo that they need computed.
///
/// # Errors
/// [`IntegrateError`] when that albedo cannot be computed.
pub fn sampled(model: &Model) -> Result<Box<dyn Bxdf + '_>, IntegrateError> {
    Ok(match model {
        Model::Lambertian(lambertian) => Box::new(lambertian),
        Model::Microfacet(microfacet) => Box::new(microfacet),
        Model::DiffuseSpecular(coupled) => Box::new(coupled_bxdf(coupled, sampled(coupled.specular())?)?),
    })
}
