//! From the properties of a material to a model, with what calls for it and what it leaves out.
//!
//! [Khronos 2021, appendix B] mixes a conductor and a dielectric by the metallic factor m: both are microfacets with GGX of
//! alpha = roughness^2 and height-correlated masking under Schlick's Fresnel term. That of the conductor has the base colour
//! as r0; that of the dielectric lies over a diffuse base in that colour and has
//! r0 = min(((ior - 1)/(ior + 1))^2 specularColor, 1), times the specular factor like its limit at grazing angles.
//!
//! - How both share their energy the appendix leaves open; here the base gets what the lobe does not reflect.
//! - A texture scales a factor to anything from 0 to the factor. Of colours the factor is taken, which scales a table and is
//!   not in it. A roughness becomes a range. A mixing weight w becomes the middle of its range, w/2: which lobes occur is what
//!   tables depend on, not how much of each there is.
//! - A roughness of 0, or one whose alpha is below 1e-6, is a mirror; fibres have at least alpha = 1e-3.
//! - Layers lie over all that: KHR_materials_sheen is its colour times Charlie, under the masking that was fitted to it, and
//!   leaves 1 - max(colour) E(mu) to what lies below; KHR_materials_clearcoat is its factor times a lobe with r0 = 0.04, and
//!   leaves 1 - factor F(mu). Both depend on the direction of sight alone, as in the simpler form of the extensions. F of the
//!   coat itself is that of its facets, and not that of the surface, which rough coats would reflect too much by.
//! - What is transmitted passes a smooth interface, or, where the surface is rough and `KHR_materials_volume` gives it a thickness,
//!   a rough one: reflection and refraction with the exact Fresnel term of the index.
//! - A rough surface without thickness is a thin wall, whose transmitted lobe the extension defines as the mirror image of the
//!   reflected one under 1 - F. No model here has that factor; the albedo is the one for F = 1 less that of the reflected lobe,
//!   which the pair of tables of r0 = 0 and r0 = 1 tells: (1 - r0) (G - R). The model has what it reflects.

use super::surface::{Base, Dielectric, Factor, Layers, MetallicRoughness, SpecularGlossiness, Surface};
use super::vocabulary::{CLEARCOAT, SHEEN, SPECULAR, SPECULAR_GLOSSINESS};
use super::words::{Made, property};
use crate::bxdf::{Coupling, FresnelSpecular, LEAST_BEND, Lambertian, Media, SpecularReflection, Transport, Veil};
use crate::distribution::{Anisotropic, Elliptic, Family};
use crate::fresnel::Fresnel;
use crate::masking::Masking;
use crate::parameter::{CHARLIE_ALPHA, ETA_B, GGX_ALPHA, Number, ParameterError};
use crate::scene::effect::Effect;
use crate::scene::spec::{DistributionSpec, ModelSpec, Roughness};
use crate::spectrum::Spectrum;
use glam::DVec3;

/// Stands for alpha = 0 along the bitangent of an anisotropic lobe, which no distribution has: 0.06 degrees wide, sharper than
/// the texels of any environment, and three orders of magnitude above the smallest alpha, where a lobe is a line.
const SHARPEST_BITANGENT: f64 = 1e-3;

/// How a surface is finished: the distribution of its facets, `None` for a mirror.
type Finish = Option<DistributionSpec>;

/// The model of `surface`, with its calls and gaps.
///
/// # Errors
/// [`ParameterError`] for properties outside the ranges of the specification.
pub(super) fn made(surface: &Surface) -> Result<Made, ParameterError> {
    let mut made = Made::default();
    made.model = match &surface.base {
        Base::Unlit => nothing(),
        Base::SpecularGlossiness(gloss) => specular_glossiness(gloss, &mut made)?,
        Base::MetallicRoughness(metal, dielectric, layers) => {
            let model = metallic_roughness(metal, dielectric, layers, &mut made)?;
            let model = layered(model, layers, &mut made)?;
            made.layers(layers);
            model
        }
    };
    if !matches!(surface.base, Base::Unlit) {
        made.unknown(&surface.unknown);
    }
    Ok(made.in_order())
}

/// What scatters no light.
fn nothing() -> ModelSpec {
    ModelSpec::Sum(Vec::new())
}

fn specular_glossiness(gloss: &SpecularGlossiness, made: &mut Made) -> Result<ModelSpec, ParameterError> {
    let by = |name: &str| property(SPECULAR_GLOSSINESS, name);
    let Factor { value, texture, .. } = gloss.glossiness;
    let sharpest = (1.0 - value) * (1.0 - value);
    let roughness = match texture {
        // no gloss at all comes out of a texture too
        true => span(sharpest, 1.0),
        false => fixed(sharpest),
    };
    if let Some(Roughness::Range { .. }) = roughness {
        let by = by("glossinessFactor");
        made.call(
            Effect::RoughnessRange,
            format!("{by} = {}, times specularGlossinessTexture", Number(value)),
        );
    }
    made.call(
        Effect::Dielectric,
        format!("{} = {:?}", by("specularFactor"), gloss.specular),
    );
    if gloss.diffuse != [0.0; 3] {
        made.call(
            Effect::Diffuse,
            format!("{} = {:?}", by("diffuseFactor"), gloss.diffuse),
        );
    }
    let r0 = Spectrum::rgb(gloss.specular);
    coupled(&isotropic(roughness), r0, 1.0, gloss.diffuse)
}

fn metallic_roughness(
    metal: &MetallicRoughness,
    dielectric: &Dielectric,
    layers: &Layers,
    made: &mut Made,
) -> Result<ModelSpec, ParameterError> {
    let metallic = metal.metallic;
    let is_metal = metallic.value > 0.0;
    let finish = if is_metal || dielectric.specular.value > 0.0 || dielectric.transmission.value > 0.0 {
        finish(metal.roughness, layers.anisotropy, made)?
    } else {
        None
    };
    let by = metallic.told("pbrMetallicRoughness.metallicFactor");
    let conductor = if is_metal {
        made.call(Effect::Metal, by.clone());
        reflection(&finish, Spectrum::rgb(metal.colour))?
    } else {
        nothing()
    };
    if !metal.is_partly_dielectric() {
        return Ok(conductor);
    }
    let rest = dielectric_part(metal, dielectric, &finish, &by, made)?;
    Ok(mixed(conductor, rest, weight(metallic)))
}

/// The dielectric part, opaque, transmitting or both.
fn dielectric_part(
    metal: &MetallicRoughness,
    dielectric: &Dielectric,
    finish: &Finish,
    by: &str,
    made: &mut Made,
) -> Result<ModelSpec, ParameterError> {
    let share = dielectric.transmission;
    // a black base lets nothing through
    let transmits = share.value > 0.0 && metal.colour != [0.0; 3];
    let through = if transmits {
        made.transmission(dielectric);
        if share.value == 1.0 && !share.texture {
            return transmitting(metal, dielectric, finish, made);
        }
        transmitting(metal, dielectric, finish, made)?
    } else {
        nothing()
    };
    if dielectric.specular.value > 0.0 {
        made.call(Effect::Dielectric, by.to_owned());
    }
    if metal.colour != [0.0; 3] {
        let colour = format!("{:?}", metal.colour);
        made.call(
            Effect::Diffuse,
            format!("pbrMetallicRoughness.baseColorFactor = {colour} where {by}"),
        );
    }
    let opaque = coupled(
        finish,
        normal_reflectance(dielectric),
        dielectric.specular.value,
        metal.colour,
    )?;
    Ok(if transmits {
        mixed(through, opaque, weight(share))
    } else {
        opaque
    })
}

/// The interface alone, tinted by the base colour.
fn transmitting(
    metal: &MetallicRoughness,
    dielectric: &Dielectric,
    finish: &Finish,
    made: &mut Made,
) -> Result<ModelSpec, ParameterError> {
    let scale = dielectric.specular.value;
    let r0 = normal_reflectance(dielectric);
    let facets = match finish {
        None => None,
        Some(DistributionSpec::Isotropic { family, roughness }) if dielectric.thick => Some((*family, *roughness)),
        Some(_) => {
            made.gap(
                Effect::Transmission.name(),
                match dielectric.thick {
                    false => {
                        "a rough surface without thickness lets light through as a mirror image of what it reflects, with 1 - F in \
                         the place of F: of channels R and G of the table of what it reflects, (1 - r0) (G - R)"
                    }
                    true => {
                        "light that is refracted by a surface with two roughnesses has no table: those of the material hold what \
                         it reflects"
                    }
                },
            );
            return Ok(scaled(reflection(finish, r0)?, scale));
        }
    };
    if ETA_B.check(dielectric.ior).is_err() {
        made.gap(
            Effect::Transmission.name(),
            format!(
                "light refracted with an index of {} is left out, which lies outside of [{}, {}]: tables hold what is reflected",
                Number(dielectric.ior),
                ETA_B.min,
                ETA_B.max
            ),
        );
        return Ok(scaled(reflection(finish, r0)?, scale));
    }
    if scale != 1.0 || dielectric.specular_colour != [1.0; 3] {
        made.gap(
            SPECULAR,
            "the tables of a transmitting surface have the Fresnel term of its index of refraction, unscaled",
        );
    }
    let tint = Spectrum::rgb(metal.colour);
    // an index of 1 bends nothing, however rough
    if let Some((family, roughness)) = facets
        && (dielectric.ior - 1.0).abs() >= LEAST_BEND
    {
        return Ok(ModelSpec::RoughDielectric {
            reflectance: Spectrum::grey(1.0),
            transmittance: tint,
            family,
            roughness,
            masking: Masking::SmithCorrelated,
            media: Media {
                eta_a: 1.0,
                eta_b: dielectric.ior,
                transport: Transport::Importance,
            },
        });
    }
    let glass = FresnelSpecular::new(Spectrum::grey(1.0), tint, 1.0, dielectric.ior, Transport::Importance)?;
    Ok(ModelSpec::FresnelSpecular(glass))
}

/// ((ior - 1)/(ior + 1))^2 times the specular colour, at most 1; ior = 0 reflects everything.
fn normal_reflectance(dielectric: &Dielectric) -> Spectrum {
    let ratio = (dielectric.ior - 1.0) / (dielectric.ior + 1.0);
    // of the largest numbers both differences are infinite or round to the same
    let f0 = if ratio.is_nan() { 1.0 } else { ratio * ratio };
    Spectrum::rgb(dielectric.specular_colour.map(|colour| (f0 * colour).min(1.0)))
}

/// A lobe scaled by `ks` over a diffuse base; either may be missing.
fn coupled(finish: &Finish, r0: Spectrum, ks: f64, base: [f64; 3]) -> Result<ModelSpec, ParameterError> {
    let kd = Spectrum::rgb(base);
    let is_black = kd.value() == DVec3::ZERO;
    Ok(match (ks > 0.0, is_black) {
        (false, true) => nothing(),
        (false, false) => ModelSpec::Lambertian(Lambertian::new(kd)?),
        (true, true) => scaled(reflection(finish, r0)?, ks),
        (true, false) => ModelSpec::DiffuseSpecular {
            specular: Box::new(reflection(finish, r0)?),
            ks: Spectrum::grey(ks),
            kd,
            coupling: Coupling::EnergyPreserving,
        },
    })
}

/// A specular lobe with Schlick's Fresnel term.
fn reflection(finish: &Finish, r0: Spectrum) -> Result<ModelSpec, ParameterError> {
    lobe(finish, Spectrum::grey(1.0), r0)
}

/// The same times `reflectance`.
fn lobe(finish: &Finish, reflectance: Spectrum, r0: Spectrum) -> Result<ModelSpec, ParameterError> {
    let fresnel = Fresnel::schlick(r0)?;
    Ok(match finish {
        None => ModelSpec::SpecularReflection(SpecularReflection::new(reflectance, fresnel)?),
        Some(distribution) => ModelSpec::Microfacet {
            reflectance,
            distribution: *distribution,
            masking: Masking::SmithCorrelated,
            fresnel,
        },
    })
}

/// The finish of the specular lobes, with what a table does not have of it.
fn finish(roughness: Factor, anisotropy: Factor, made: &mut Made) -> Result<Finish, ParameterError> {
    let alpha = roughness.value * roughness.value;
    let spread = if roughness.texture {
        span(0.0, alpha)
    } else {
        fixed(alpha)
    };
    let is_range = matches!(spread, Some(Roughness::Range { .. }));
    if is_range {
        let by = roughness.told("pbrMetallicRoughness.roughnessFactor");
        made.call(Effect::RoughnessRange, by);
    }
    if anisotropy.value == 0.0 {
        return Ok(isotropic(spread));
    }
    made.anisotropy(anisotropy);
    if is_range {
        made.gap(
            Effect::Anisotropy.name(),
            "the roughness comes from a texture, and a table has no third axis: the lobe is taken as isotropic",
        );
        return Ok(isotropic(spread));
    }
    let across = match spread {
        None => {
            made.gap(
                Effect::Anisotropy.name(),
                format!("a roughness of 0 along one tangent has no table: it is taken as alpha = {SHARPEST_BITANGENT}"),
            );
            SHARPEST_BITANGENT
        }
        Some(_) => alpha,
    };
    // of the roughness itself, as the extension has it, and not of what stands for 0 across
    let along = alpha + (1.0 - alpha) * anisotropy.value * anisotropy.value;
    let along = along.max(across);
    if along == across {
        return Ok(isotropic(Some(Roughness::Fixed(across))));
    }
    let distribution = Anisotropic::new(Elliptic::Ggx, along, across)?;
    Ok(Some(DistributionSpec::Anisotropic(distribution)))
}

/// One alpha, `None` for a mirror.
fn fixed(alpha: f64) -> Option<Roughness> {
    (alpha >= GGX_ALPHA.min).then_some(Roughness::Fixed(alpha))
}

/// All alpha of [min, max] that are no mirror, `None` when there is none.
fn span(min: f64, max: f64) -> Option<Roughness> {
    let min = min.max(GGX_ALPHA.min);
    if min < max {
        Some(Roughness::Range { min, max })
    } else {
        fixed(max)
    }
}

fn isotropic(roughness: Option<Roughness>) -> Finish {
    let family = Family::Ggx;
    roughness.map(|roughness| DistributionSpec::Isotropic { family, roughness })
}

/// r0 of the coat, of an index of refraction of 1.5 in air whatever lies below.
const COAT_R0: f64 = 0.04;

/// `model` below its layers, the sheen and then the coat.
///
/// The sheen is its colour times Charlie with alpha = roughness^2 under its own masking, and leaves what its albedo does; the coat
/// is a dielectric lobe times its factor, and leaves 1 - factor F(mu).
fn layered(model: ModelSpec, layers: &Layers, made: &mut Made) -> Result<ModelSpec, ParameterError> {
    let mut model = model;
    if layers.sheen != [0.0; 3] {
        let least = CHARLIE_ALPHA.min;
        let roughness = layer_roughness(layers.sheen_roughness, least, &model, (Effect::Sheen, SHEEN), made);
        let sheen = ModelSpec::Microfacet {
            reflectance: Spectrum::rgb(layers.sheen),
            distribution: DistributionSpec::Isotropic {
                family: Family::Charlie,
                // fibres that hardly diverge stand for those that do not
                roughness: roughness.unwrap_or(Roughness::Fixed(least)),
            },
            masking: Masking::Charlie,
            fresnel: Fresnel::None,
        };
        model = over(sheen, model, Veil::Albedo);
    }
    let factor = weight(layers.clearcoat);
    if factor > 0.0 {
        let least = GGX_ALPHA.min;
        let coat = (Effect::Clearcoat, CLEARCOAT);
        let roughness = layer_roughness(layers.clearcoat_roughness, least, &model, coat, made);
        let coat = lobe(&isotropic(roughness), Spectrum::grey(factor), Spectrum::grey(COAT_R0))?;
        model = over(coat, model, Veil::Fresnel);
    }
    Ok(model)
}

/// Alpha of a layer over `below`, `None` where it is less than `least`.
fn layer_roughness(
    roughness: Factor,
    least: f64,
    below: &ModelSpec,
    (effect, extension): (Effect, &str),
    made: &mut Made,
) -> Option<Roughness> {
    let alpha = roughness.value * roughness.value;
    let one = (alpha >= least).then_some(Roughness::Fixed(alpha));
    if !roughness.texture || alpha <= least {
        return one;
    }
    if below.roughness_range().is_some() {
        made.one_axis(effect);
        return one;
    }
    let name = match effect {
        Effect::Sheen => "sheenRoughnessFactor",
        _ => "clearcoatRoughnessFactor",
    };
    made.call(Effect::RoughnessRange, roughness.told(&property(extension, name)));
    Some(Roughness::Range { min: least, max: alpha })
}

/// `top` over `base`, which may scatter nothing.
fn over(top: ModelSpec, base: ModelSpec, veil: Veil) -> ModelSpec {
    if base == nothing() {
        return top;
    }
    ModelSpec::Layered {
        top: Box::new(top),
        base: Box::new(base),
        veil,
    }
}

/// The weight of what `factor` mixes in: the factor, or the middle of its range.
fn weight(factor: Factor) -> f64 {
    if factor.texture {
        0.5 * factor.value
    } else {
        factor.value
    }
}

/// `one` times `weight` and `other` times the rest.
fn mixed(one: ModelSpec, other: ModelSpec, weight: f64) -> ModelSpec {
    let parts = [(one, weight), (other, 1.0 - weight)];
    let scatters = |(model, weight): &(ModelSpec, f64)| *weight > 0.0 && *model != nothing();
    let parts = parts.into_iter().filter(scatters);
    let mut parts: Vec<ModelSpec> = parts.map(|(model, weight)| scaled(model, weight)).collect();
    match parts.len() {
        1 => parts.remove(0),
        _ => ModelSpec::Sum(parts),
    }
}

fn scaled(model: ModelSpec, scale: f64) -> ModelSpec {
    if scale == 1.0 || model == nothing() {
        return model;
    }
    ModelSpec::Scaled {
        bxdf: Box::new(model),
        scale: Spectrum::grey(scale),
    }
}
