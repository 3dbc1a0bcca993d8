//! The axes of a table.

use super::Request;
use crate::bxdf::Model;
use crate::fresnel::Fresnel;
use crate::scene::ModelSpec;
use crate::table::Quantity;
use crate::table::axis::{AZIMUTH, Axis, AxisError, Mapping, TexelRule};
use std::f64::consts::FRAC_PI_2;

/// Axes to choose from for `quantity` of the model `spec`, which at one roughness is `model`. A table has at most two axes: one of
/// roughness leaves no place for one of azimuth.
pub(super) fn alternatives(
    quantity: Quantity,
    spec: &ModelSpec,
    model: &Model,
    request: &Request,
) -> Result<Vec<Vec<Axis>>, AxisError> {
    let roughness = roughness_axis(spec, request.roughness_resolution)?;
    if quantity == Quantity::RhoHh {
        return Ok(vec![roughness.into_iter().collect()]);
    }
    let azimuth = match model.is_anisotropic() || (!request.economy.azimuth && roughness.is_none()) {
        true => Some(azimuth_axis(request.azimuth_resolution)?),
        false => None,
    };
    let choices = match request.mapping {
        Some(mapping) => vec![(mapping, TexelRule::Centres)],
        // constant, or known no better than to some per mille: nothing to choose
        None if matches!(spec, ModelSpec::Lambertian(_)) || model.is_irregular() => {
            vec![(Mapping::Mu, TexelRule::Centres)]
        }
        None => MU_AXES.to_vec(),
    };
    choices
        .into_iter()
        .map(|(mapping, rule)| {
            let mu = Axis::new("mu", mapping, rule, [0.0, 1.0], request.resolution)?;
            Ok([Some(mu), azimuth.clone(), roughness.clone()]
                .into_iter()
                .flatten()
                .collect())
        })
        .collect()
}

/// Every anisotropic model is symmetric about both tangents: a quarter of the circle tells all, and both of its ends are
/// stored, where the albedo is stationary.
fn azimuth_axis(size: usize) -> Result<Axis, AxisError> {
    Axis::new(AZIMUTH, Mapping::Linear, TexelRule::Ends, [0.0, FRAC_PI_2], size)
}

/// The axes to choose from, the simplest for a shader first: u = mu needs no arithmetic, sqrt mu gives the boundary layer at
/// grazing angles more texels, and texels at the ends hold the limits themselves.
const MU_AXES: [(Mapping, TexelRule); 3] = [
    (Mapping::Mu, TexelRule::Centres),
    (Mapping::SqrtMu, TexelRule::Centres),
    (Mapping::SqrtMu, TexelRule::Ends),
];

/// Widest ratio of slopes that is spread by its logarithm: of one beyond, most texels would lie where lobes are mirrors.
const WIDEST_LOG: f64 = 1e4;

/// Roughness parameters act by their ratios; those that may be 0 by the ratios of 1 + value. Slopes under Schlick's Fresnel term, and
/// wide ranges of slopes, are spread by their root, the perceptual roughness that engines interpolate along.
///
/// Texels sit at the ends: the ends of a range are materials of the scene, and clamping half a texel before them errs by a
/// few per cent.
fn roughness_axis(model: &ModelSpec, size: usize) -> Result<Option<Axis>, AxisError> {
    let Some((family, min, max)) = model.roughness_range() else {
        return Ok(None);
    };
    let legal = family.legal();
    let is_slope = legal.min > 0.0;
    let mapping = match is_slope {
        false => Mapping::Log1p,
        true if is_schlick(model) || max / min > WIDEST_LOG => Mapping::Sqrt,
        true => Mapping::Log,
    };
    Axis::new(legal.name, mapping, TexelRule::Ends, [min, max], size).map(Some)
}

fn is_schlick(model: &ModelSpec) -> bool {
    match model {
        ModelSpec::Microfacet { fresnel, .. } => matches!(fresnel, Fresnel::Schlick { .. }),
        made => made.parts().into_iter().any(is_schlick),
    }
}
