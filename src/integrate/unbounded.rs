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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bxdf::{FresnelBlend, Microfacet, Sampling, Scaled};
    use crate::distribution::Family;
    use crate::estimate::{Effort, Estimator};
    use crate::fresnel::Fresnel;
    use crate::integrate::Integrator;
    use crate::spectrum::Spectrum;

    /// Rules and samples alike; the smallest cosine is as good as 0, and no reason to panic.
    #[test]
    fn no_estimator_has_a_value_where_there_is_none() {
        let (grey, lobe) = (Spectrum::grey(0.5), Family::Vmf.with(1.0).unwrap());
        let open = Model::Microfacet(Microfacet::new(grey, lobe, Masking::None, Fresnel::None).unwrap());
        let models = [
            open.clone(),
            Model::FresnelBlend(FresnelBlend::new(grey, grey, lobe).unwrap()),
            Model::Scaled(Box::new(Scaled::new(open, grey).unwrap())),
        ];
        let effort = Effort {
            tolerance: 1e-2,
            samples: Some(4096),
            seed: 0,
        };
        for model in &models {
            for estimator in [
                Estimator::Quadrature,
                Estimator::random(Sampling::Normals),
                Estimator::random(Sampling::Cosine),
            ] {
                let integrator = Integrator::new(model, estimator, effort).unwrap();
                for mu in [0.0, 5e-324] {
                    let found = integrator.estimate(Target::rho_hd(mu, 0.0), 0);
                    assert!(
                        matches!(found, Err(IntegrateError::Diverges(_))),
                        "{estimator} {mu}: {found:?}"
                    );
                }
                assert!(integrator.estimate(Target::rho_hd(0.5, 0.0), 0).is_ok(), "{estimator}");
            }
        }
    }
}
