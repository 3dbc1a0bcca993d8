//! The materials of pbrt 3 as models.
//!
//! Names, defaults and lobes are those of its materials. What varies over the surface counts as 1, or, for a roughness, as a
//! range; bump maps change normals and no table.

use super::build::{Build, Colour, Outcome, is_coloured, merged, spectrum};
use super::definitions::Definition;
use super::textures::Range;
use super::tokens::quote;
use crate::bxdf::{
    FresnelSpecular, LEAST_BEND, Lambertian, Media, OrenNayar, SpecularReflection, SpecularTransmission, Transport,
};
use crate::fresnel::Fresnel;
use crate::masking::Masking;
use crate::measured::index::ConductorIndex;
use crate::parameter::{ETA, EXTINCTION, Legal, Number, SIGMA_DEG};
use crate::scene::effect::{Effect, Gap};
use crate::scene::error::SceneError;
use crate::scene::spec::{DistributionSpec, ModelSpec, Roughness};
use glam::DVec3;
use std::rc::Rc;

/// Names of the parameters that some material has.
pub(super) const NAMES: [&str; 25] = [
    "type",
    "Kd",
    "Ks",
    "Kr",
    "Kt",
    "sigma",
    "roughness",
    "uroughness",
    "vroughness",
    "remaproughness",
    "eta",
    "k",
    "index",
    "opacity",
    "reflect",
    "transmit",
    "amount",
    "namedmaterial1",
    "namedmaterial2",
    "bumpmap",
    "metallic",
    "anisotropic",
    "sheen",
    "clearcoat",
    "spectrans",
];

/// Most lobes of a material, as in pbrt.
const MOST_LOBES: usize = 8;
/// Most gaps of a mixture: every lobe may have several, and parts without any lobe would have 2^8 within mixtures of mixtures.
const MOST_GAPS: usize = 8 * MOST_LOBES;
/// Most levels of mixtures within mixtures: each has a lobe of its own, or it is none.
pub(super) const DEEPEST_MIX: usize = MOST_LOBES;

/// Names of the parameters of the type `kind`, beside `bumpmap`; `None` for a type without models here.
pub(super) fn names(kind: &str) -> Option<&'static [&'static str]> {
    Some(match kind {
        "" | "none" => &[],
        "matte" => &["Kd", "sigma"],
        "plastic" => &["Kd", "Ks", "roughness", "remaproughness"],
        "metal" => &["eta", "k", "roughness", "uroughness", "vroughness", "remaproughness"],
        "glass" => &["Kr", "Kt", "eta", "index", "uroughness", "vroughness", "remaproughness"],
        "mirror" => &["Kr"],
        "uber" => &[
            "Kd",
            "Ks",
            "Kr",
            "Kt",
            "roughness",
            "uroughness",
            "vroughness",
            "eta",
            "index",
            "opacity",
            "remaproughness",
        ],
        "substrate" => &["Kd", "Ks", "uroughness", "vroughness", "remaproughness"],
        "mix" => &["amount", "namedmaterial1", "namedmaterial2"],
        "translucent" => &["Kd", "Ks", "reflect", "transmit", "roughness", "remaproughness"],
        _ => return None,
    })
}

/// What the material of the type `kind` comes to; `parts` are those of a mixture.
pub(super) fn material(kind: &str, build: Build<'_>, parts: &[Rc<Definition>]) -> Result<Outcome, SceneError> {
    match kind {
        // the surface between two media: nothing is scattered
        "" | "none" => Ok(build.done(Vec::new())),
        "matte" => matte(build),
        "plastic" => plastic(build),
        "metal" => metal(build),
        "glass" => glass(build),
        "mirror" => mirror(build),
        "uber" => uber(build),
        "substrate" => substrate(build),
        "mix" => mix(build, parts),
        "translucent" => translucent(build),
        _ => unsupported(kind, build),
    }
}

fn lambertian(reflectance: DVec3, build: &Build<'_>) -> Result<ModelSpec, SceneError> {
    let diffuse = Lambertian::new(spectrum(reflectance)).map_err(build.refused())?;
    Ok(ModelSpec::Lambertian(diffuse))
}

fn matte(mut build: Build<'_>) -> Result<Outcome, SceneError> {
    let kd = build.factor("Kd", 0.5, &[Effect::Diffuse])?;
    if kd == DVec3::ZERO {
        return Ok(build.done(Vec::new()));
    }
    let sigma = build.scalar("sigma", 0.0)?;
    let sigma = build.fixed(
        &sigma,
        Legal {
            name: "sigma",
            ..SIGMA_DEG
        },
    )?;
    let part = match sigma {
        0.0 => lambertian(kd, &build)?,
        _ => ModelSpec::OrenNayar(OrenNayar::new(spectrum(kd), sigma).map_err(build.refused())?),
    };
    Ok(build.done(vec![part]))
}

/// The distribution for `roughness` alone.
fn isotropic(build: &mut Build<'_>) -> Result<DistributionSpec, SceneError> {
    let remap = build.flag("remaproughness", true)?;
    let roughness = ("roughness", build.scalar("roughness", 0.1)?);
    build.distribution([roughness, roughness], remap)
}

/// The distribution for `uroughness` and `vroughness`, which have `roughness` for a default if it has one itself.
fn elliptic(build: &mut Build<'_>, default: f64, roughness: bool) -> Result<DistributionSpec, SceneError> {
    let remap = build.flag("remaproughness", true)?;
    let fallback = match roughness {
        true => Some(("roughness", build.scalar("roughness", default)?)),
        false => None,
    };
    let along = |name| match (build.given.scalar(name)?, fallback) {
        (Some(scalar), _) => Ok((name, scalar)),
        (None, Some(fallback)) => Ok(fallback),
        (None, None) => Ok((name, build.scalar(name, default)?)),
    };
    let pair = [along("uroughness")?, along("vroughness")?];
    build.distribution(pair, remap)
}

fn plastic(mut build: Build<'_>) -> Result<Outcome, SceneError> {
    let kd = build.factor("Kd", 0.25, &[Effect::Diffuse])?;
    let ks = build.factor("Ks", 0.25, &[Effect::Dielectric])?;
    let mut parts = Vec::new();
    if kd != DVec3::ZERO {
        parts.push(lambertian(kd, &build)?);
    }
    if ks != DVec3::ZERO {
        let distribution = isotropic(&mut build)?;
        // pbrt's code passes the indices as 1.5 above and 1 below, which would reflect all light beyond 42 degrees; a coat of
        // plastic in air is 1 above and 1.5 below, as in its other materials
        parts.push(Build::microfacet(ks, distribution, build.dielectric(1.5)?));
    }
    Ok(build.done(parts))
}

fn metal(mut build: Build<'_>) -> Result<Outcome, SceneError> {
    let copper = ConductorIndex::named("Cu").map(|copper| [copper.eta(), copper.k()].map(|it| it.value()));
    let [copper_eta, copper_k] = copper.unwrap_or([DVec3::ONE, DVec3::ZERO]);
    let eta = build.colour(ETA, copper_eta, copper_eta)?;
    let k = build.colour(EXTINCTION, copper_k, copper_k)?;
    for (name, colour) in [("eta", &eta), ("k", &k)] {
        if colour.varies {
            let why = "it varies over the surface and no table has an axis for it: the tables are of copper's";
            build.gap(name, why);
        }
    }
    let distribution = elliptic(&mut build, 0.01, true)?;
    let statement = build.statement.label();
    build.because(Effect::Metal, statement);
    build.because(Effect::Colour, if is_coloured(eta.value) { eta.by } else { k.by });
    let fresnel = Fresnel::conductor(spectrum(eta.value), spectrum(k.value)).map_err(build.refused())?;
    Ok(build.done(vec![Build::microfacet(DVec3::ONE, distribution, fresnel)]))
}

fn glass(mut build: Build<'_>) -> Result<Outcome, SceneError> {
    let kt = build.factor("Kt", 1.0, &[Effect::Transmission])?;
    let kr = build.factor("Kr", 1.0, &[Effect::Dielectric])?;
    if kr == DVec3::ZERO && kt == DVec3::ZERO {
        return Ok(build.done(Vec::new()));
    }
    let eta = build.index()?;
    let (u, v) = (build.scalar("uroughness", 0.0)?, build.scalar("vroughness", 0.0)?);
    let smooth = Range::single(0.0);
    if u.range == smooth && v.range == smooth {
        let glass = FresnelSpecular::new(spectrum(kr), spectrum(kt), 1.0, eta, Transport::Importance);
        let glass = ModelSpec::FresnelSpecular(glass.map_err(build.refused())?);
        return Ok(build.done(vec![glass]));
    }
    if (eta - 1.0).abs() < LEAST_BEND {
        // what bends nothing is not rough
        let clear = FresnelSpecular::new(spectrum(kr), spectrum(kt), 1.0, eta, Transport::Importance);
        let clear = ModelSpec::FresnelSpecular(clear.map_err(build.refused())?);
        return Ok(build.done(vec![clear]));
    }
    let distribution = elliptic(&mut build, 0.0, false)?;
    let mut parts = Vec::new();
    match distribution {
        DistributionSpec::Isotropic { family, roughness } if kt != DVec3::ZERO => {
            parts.push(ModelSpec::RoughDielectric {
                reflectance: spectrum(kr),
                transmittance: spectrum(kt),
                family,
                roughness,
                masking: Masking::SmithCorrelated,
                media: Media {
                    eta_a: 1.0,
                    eta_b: eta,
                    transport: Transport::Importance,
                },
            });
        }
        _ => {
            if kt != DVec3::ZERO {
                build.rough_transmission();
            }
            if kr != DVec3::ZERO {
                parts.push(Build::microfacet(kr, distribution, build.dielectric(eta)?));
            }
        }
    }
    Ok(build.done(parts))
}

fn mirror(mut build: Build<'_>) -> Result<Outcome, SceneError> {
    let kr = build.factor("Kr", 0.9, &[Effect::Metal])?;
    if kr == DVec3::ZERO {
        return Ok(build.done(Vec::new()));
    }
    let mirror = SpecularReflection::new(spectrum(kr), Fresnel::None).map_err(build.refused())?;
    Ok(build.done(vec![ModelSpec::SpecularReflection(mirror)]))
}

fn uber(mut build: Build<'_>) -> Result<Outcome, SceneError> {
    let legal = Legal::new("opacity", 0.0, 1.0);
    let Colour {
        value: opacity,
        by,
        varies,
    } = build.colour(legal, DVec3::ONE, DVec3::ONE)?;
    if varies {
        let why = "it varies over the surface: the tables are of the opaque material, which a shader scales by it";
        build.gap("opacity", why);
    }
    let through = DVec3::ONE - opacity;
    if through != DVec3::ZERO {
        build.because(Effect::Transmission, by);
    }
    let kd = opacity * build.factor("Kd", 0.25, &[Effect::Diffuse])?;
    let ks = opacity * build.factor("Ks", 0.25, &[Effect::Dielectric])?;
    let kr = opacity * build.factor("Kr", 0.0, &[Effect::Dielectric])?;
    let kt = opacity * build.factor("Kt", 0.0, &[Effect::Transmission])?;
    let mut parts = Vec::new();
    if through != DVec3::ZERO {
        // straight on, as through a hole
        parts.push(window(through, 1.0, &build)?);
    }
    if kd != DVec3::ZERO {
        parts.push(lambertian(kd, &build)?);
    }
    if [ks, kr, kt] == [DVec3::ZERO; 3] {
        return Ok(build.done(parts));
    }
    let eta = build.index()?;
    if ks != DVec3::ZERO {
        let distribution = elliptic(&mut build, 0.1, true)?;
        parts.push(Build::microfacet(ks, distribution, build.dielectric(eta)?));
    }
    if kr != DVec3::ZERO {
        let mirror = SpecularReflection::new(spectrum(kr), build.dielectric(eta)?).map_err(build.refused())?;
        parts.push(ModelSpec::SpecularReflection(mirror));
    }
    if kt != DVec3::ZERO {
        parts.push(window(kt, eta, &build)?);
    }
    Ok(build.done(parts))
}

/// Refraction from air into what has the index `beyond`.
fn window(tint: DVec3, beyond: f64, build: &Build<'_>) -> Result<ModelSpec, SceneError> {
    let window = SpecularTransmission::new(spectrum(tint), 1.0, beyond, Transport::Importance);
    Ok(ModelSpec::SpecularTransmission(window.map_err(build.refused())?))
}

fn substrate(mut build: Build<'_>) -> Result<Outcome, SceneError> {
    let of = |name| Legal::new(name, 0.0, 1.0);
    let half = DVec3::splat(0.5);
    let (rd, rs) = (
        build.colour(of("Kd"), half, DVec3::ONE)?,
        build.colour(of("Ks"), half, DVec3::ONE)?,
    );
    if rd.value == DVec3::ZERO && rs.value == DVec3::ZERO {
        return Ok(build.done(Vec::new()));
    }
    build.because(Effect::Diffuse, rd.by.clone());
    build.because(Effect::Dielectric, rs.by.clone());
    build.because(Effect::Colour, if is_coloured(rd.value) { rd.by } else { rs.by });
    let distribution = elliptic(&mut build, 0.1, false)?;
    Ok(build.done(vec![ModelSpec::FresnelBlend {
        rd: spectrum(rd.value),
        rs: spectrum(rs.value),
        distribution,
    }]))
}

fn translucent(mut build: Build<'_>) -> Result<Outcome, SceneError> {
    let reflect = build.factor("reflect", 0.5, &[])?;
    let transmit = build.factor("transmit", 0.5, &[Effect::Transmission])?;
    let kd = build.factor("Kd", 0.25, &[Effect::Diffuse])?;
    let ks = build.factor("Ks", 0.25, &[Effect::Dielectric])?;
    let mut parts = Vec::new();
    if reflect * kd != DVec3::ZERO {
        parts.push(lambertian(reflect * kd, &build)?);
    }
    if transmit * kd != DVec3::ZERO {
        parts.push(ModelSpec::BrdfToBtdf(Box::new(lambertian(transmit * kd, &build)?)));
    }
    if reflect * ks != DVec3::ZERO {
        let distribution = isotropic(&mut build)?;
        parts.push(Build::microfacet(reflect * ks, distribution, build.dielectric(1.5)?));
    }
    if transmit * ks != DVec3::ZERO {
        build.rough_transmission();
    }
    Ok(build.done(parts))
}

/// amount of the first material and 1 - amount of the second; half of each where the amount varies over the surface.
fn mix(mut build: Build<'_>, parts: &[Rc<Definition>]) -> Result<Outcome, SceneError> {
    let legal = Legal::new("amount", 0.0, 1.0);
    let half = DVec3::splat(0.5);
    let Colour {
        value: amount, varies, ..
    } = build.colour(legal, half, half)?;
    if varies {
        let why = "it varies over the surface: the tables are of half of each material, and a shader mixes their own";
        build.gap("amount", why);
    }
    let (mut lobes, mut calls, mut gaps) = (Vec::new(), Vec::new(), Vec::new());
    for (part, share) in parts.iter().zip([amount, DVec3::ONE - amount]) {
        let outcome = &part.outcome;
        if share == DVec3::ZERO {
            continue;
        }
        calls = merged(calls, outcome.calls.clone());
        for gap in &outcome.gaps {
            if !gaps.contains(gap) {
                gaps.push(gap.clone());
            }
        }
        if !matches!(&outcome.model, ModelSpec::Sum(none) if none.is_empty()) {
            lobes.push(ModelSpec::Scaled {
                bxdf: Box::new(outcome.model.clone()),
                scale: spectrum(share),
            });
        }
    }
    let count: usize = lobes.iter().map(count).sum();
    if count > MOST_LOBES {
        return Err(build.statement.place.refuse(format!(
            "this mixture is not allowed: it has {count} lobes, and pbrt takes at most {MOST_LOBES}"
        )));
    }
    if gaps.len() > MOST_GAPS {
        return Err(build.statement.place.refuse(format!(
            "this mixture is not allowed: its parts leave {} different things out, and at most {MOST_GAPS} are told",
            gaps.len()
        )));
    }
    one_range(&mut lobes, &mut gaps);
    let own = build.done(lobes);
    Ok(Outcome {
        model: own.model,
        // those of a part tell the line of the part, and a part without a model has some, too
        calls: merged(calls, own.calls),
        gaps: gaps.into_iter().chain(own.gaps).collect(),
    })
}

/// Lobes of `model`.
fn count(model: &ModelSpec) -> usize {
    match model.parts() {
        none if none.is_empty() => 1,
        parts => parts.into_iter().map(count).sum(),
    }
}

/// Leaves one range of roughness, as a table has one axis for it: any further is replaced by its largest value.
fn one_range(lobes: &mut [ModelSpec], gaps: &mut Vec<Gap>) {
    fn each(model: &mut ModelSpec, seen: &mut bool, gaps: &mut Vec<Gap>) {
        match model {
            ModelSpec::Microfacet {
                distribution: DistributionSpec::Isotropic { roughness, .. },
                ..
            }
            | ModelSpec::FresnelBlend {
                distribution: DistributionSpec::Isotropic { roughness, .. },
                ..
            }
            | ModelSpec::RoughDielectric { roughness, .. } => {
                let Roughness::Range { max, .. } = *roughness else {
                    return;
                };
                if *seen {
                    *roughness = Roughness::Fixed(max);
                    let why = format!(
                        "both materials of a mixture have one, and a table has one axis for it: the tables are of the second's \
                         alpha = {}",
                        Number(max)
                    );
                    gaps.push(Gap::new(Effect::RoughnessRange.name(), why));
                }
                *seen = true;
            }
            ModelSpec::Scaled { bxdf, .. } | ModelSpec::BrdfToBtdf(bxdf) => each(bxdf, seen, gaps),
            ModelSpec::Sum(parts) => parts.iter_mut().for_each(|part| each(part, seen, gaps)),
            _ => {}
        }
    }
    let mut seen = false;
    lobes.iter_mut().for_each(|lobe| each(lobe, &mut seen, gaps));
}

/// A material without a model here calls for what its type and parameters leave no doubt about.
fn unsupported(kind: &str, mut build: Build<'_>) -> Result<Outcome, SceneError> {
    let statement = build.statement.label();
    let calls: Vec<Effect> = match kind {
        "disney" => {
            let above = |name: &str| build.given.about(name, 0.0).max > 0.0;
            let metallic = build.given.about("metallic", 0.0);
            let asked = [
                (Effect::Metal, metallic.max > 0.0),
                (Effect::Dielectric, metallic.min < 1.0),
                (Effect::Diffuse, metallic.min < 1.0),
                (Effect::Transmission, above("spectrans")),
                (Effect::Anisotropy, above("anisotropic")),
                (Effect::Sheen, above("sheen")),
                (Effect::Clearcoat, above("clearcoat")),
            ];
            asked
                .into_iter()
                .filter(|(_, asked)| *asked)
                .map(|(effect, _)| effect)
                .collect()
        }
        // light enters through a dielectric surface, and leaves it elsewhere
        "subsurface" | "kdsubsurface" => vec![Effect::Dielectric, Effect::Transmission],
        _ => Vec::new(),
    };
    for effect in calls {
        build.call(effect, statement.clone());
    }
    let known = ["disney", "hair", "fourier", "subsurface", "kdsubsurface"];
    let why = match known.contains(&kind) {
        true => "there are no tables for this material of pbrt: nothing of it is covered",
        false => "pbrt 3 has no material of this type: nothing of it is covered",
    };
    let shown = quote(kind);
    let what = match shown.trim() {
        "" => format!("\"{shown}\""),
        _ => shown,
    };
    build.gap(what, why);
    Ok(build.done(Vec::new()))
}
