//! Models made ready for sampling.

use super::{Estimator, IntegrateError, coupled_bxdf, layers};
use crate::bxdf::{Bxdf, DiffuseSpecular, Model, Needs, Sampling};

/// The model as a [`Bxdf`]; couplings and layers get the albedo that they need computed.
///
/// # Errors
/// [`IntegrateError`] when that albedo cannot be computed.
pub fn sampled(model: &Model) -> Result<Box<dyn Bxdf + '_>, IntegrateError> {
    model.as_bxdf(&|needs| match needs {
        Needs::Coupling(coupled) => couple(coupled),
        Needs::Layers(layered) => layers::bxdf(layered),
    })
}

fn couple(coupled: &DiffuseSpecular) -> Result<Box<dyn Bxdf + '_>, IntegrateError> {
    if coupled.specular().is_irregular() {
        return Err(IntegrateError::Unsupported {
            estimator: Estimator::random(Sampling::Bxdf),
            reason: "between directions the albedo of irregular samples is not known well enough; use auto",
        });
    }
    Ok(Box::new(coupled_bxdf(coupled, sampled(coupled.specular())?)?))
}
