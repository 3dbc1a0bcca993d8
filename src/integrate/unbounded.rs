//! Directions from which rho_hd has no finite value.

use super::{Angles, IntegrateError, Target};
use crate::bxdf::Model;
use crate::distribution::{Distribution, Isotropic};
use crate::masking::Masking;

/// Where [`IntegrateError::Diverges`] comes from.
pub(super) const UNMASKED: &str = "when masking = \"none\": ask for mu > 0, or use another masking";
pub(super) const UNMASKED_COAT: &str = "under a fresnel-blend of vmf facets, whose D is infinite at the horizon: ask for \
                                        mu > 0, or use another distribution";

/// Refuses a `target` at the horizon, or so near that 1/mu is no number, from which a part of `model` sends back infinitely
/// much: samples would not notice, since of f there, which has no limit, they see 0.
pub(super) fn refuse(model: &Model, target: Target) -> Result<(), IntegrateError> {
    match (model, target.outgoing) {
        (Model::Microfacet(lobe), Some(Angles { mu, .. }))
            if mu < f64::MIN_POSITIVE && lobe.masking == Masking::None =>
        {
            Err(IntegrateError::Diverges(UNMASKED))
        }
        (Model::FresnelBlend(blend), Some(Angles { mu, .. }))
            if mu < f64::MIN_POSITIVE && is_vmf(blend.distribution()) =>
        {
            Err(IntegrateError::Diverges(UNMASKED_COAT))
        }
        _ => model.parts().into_iter().try_for_each(|part| refuse(part, target)),
    }
}

/// Whether D, the quotient of p and the cosine, is infinite at the horizon.
pub(super) fn is_vmf(distribution: &Distribution) -> bool {
    matches!(distribution, Distribution::Isotropic(Isotropic::Vmf(_)))
}
