//! What the page reads: names, parameters and tables.

use super::base64;
use super::cast::{Cast, Part, Surface, Term, r0};
use super::sheets::{SIZES, STORAGES, Sheets, TOLERANCE, mu_axis, roughness_axis};
use crate::distribution::Family;
use crate::export::VERSION;
use crate::fresnel::Fresnel;
use crate::masking::Masking;
use crate::printable::printable;
use crate::spectrum::Spectrum;
use crate::table::Storage;
use crate::table::axis::{Axis, AxisError};
use crate::table::texture::Texture;
use half::f16;
use serde_json::{Value, json};

/// Everything but the shaders.
pub(super) fn json(scene: &str, cast: &Cast, sheets: &[Vec<Sheets>]) -> Result<Value, AxisError> {
    let pairs = cast.surfaces.iter().zip(sheets);
    let surfaces: Vec<Value> = pairs
        .map(|(surface, sheets)| of_surface(surface, sheets))
        .collect::<Result<_, _>>()?;
    let left_out = cast
        .left_out
        .iter()
        .map(|left| json!({ "name": printable(&left.name), "reason": printable(&left.reason) }));
    Ok(json!({
        "version": VERSION,
        "scene": printable(scene),
        "sizes": SIZES,
        "storages": STORAGES.map(Storage::name),
        "tolerance": TOLERANCE,
        "surfaces": surfaces,
        "materials": cast.parts.iter().map(of_part).collect::<Vec<_>>(),
        "leftOut": left_out.collect::<Vec<_>>(),
    }))
}

/// The number by which shaders know a family.
fn family_code(family: Family) -> u32 {
    match family {
        Family::Ggx => 0,
        Family::Beckmann => 1,
        Family::Vmf => 2,
        Family::Phong => 3,
        Family::Charlie => 4,
    }
}

fn masking_code(masking: Masking) -> u32 {
    match masking {
        Masking::None => 0,
        Masking::VGroove => 1,
        Masking::Smith => 2,
        Masking::SmithCorrelated => 3,
        Masking::Neubelt => 4,
        Masking::Charlie => 5,
    }
}

fn of_surface(surface: &Surface, sheets: &[Sheets]) -> Result<Value, AxisError> {
    let (mu, roughness) = (mu_axis(2)?, roughness_axis(surface, 2)?);
    let sheets = surface.terms.iter().zip(sheets).map(|(term, sheets)| {
        let table = |(albedo, mean): (&Vec<Texture>, &Vec<Texture>)| {
            let each = STORAGES.iter().zip(albedo.iter().zip(mean));
            Value::Object(
                each.map(|(storage, (albedo, mean))| {
                    (storage.name().to_owned(), json!([packed(albedo), packed(mean)]))
                })
                .collect(),
            )
        };
        json!({
            "channels": sheets.reference.channels.len(),
            "term": match term {
                Term::Pair => "pair",
                Term::Own(_) => "own",
            },
            "tables": sheets.albedo.iter().zip(&sheets.mean).map(table).collect::<Vec<_>>(),
            "reference": {
                "size": sheets.reference.size()[..2],
                "albedo": packed(&sheets.reference),
                "mean": packed(&sheets.reference_mean),
            },
        })
    });
    Ok(json!({
        "family": surface.family.name(),
        "familyCode": family_code(surface.family),
        "masking": surface.masking.name(),
        "maskingCode": masking_code(surface.masking),
        "mu": of_axis(&mu),
        "roughness": of_axis(&roughness),
        "sheets": sheets.collect::<Vec<_>>(),
    }))
}

fn of_axis(axis: &Axis) -> Value {
    json!({
        "name": axis.parameter,
        "mapping": axis.mapping.name(),
        "rule": axis.rule.name(),
        "min": axis.min,
        "max": axis.max,
    })
}

fn of_part(part: &Part) -> Value {
    let zero = Spectrum::grey(0.0);
    let (kind, code, eta, k) = match part.fresnel {
        Fresnel::None => ("none", 0, zero, zero),
        Fresnel::Dielectric { eta } => ("dielectric", 1, eta, zero),
        Fresnel::Conductor { eta, k } => ("conductor", 2, eta, k),
        Fresnel::Schlick { r0 } => ("schlick", 3, r0, zero),
        Fresnel::ConductorApproximate { eta, k } => ("conductor-approximate", 4, eta, k),
    };
    json!({
        "name": printable(&part.name),
        "surface": part.surface,
        "sheet": part.sheet,
        "fresnel": kind,
        "fresnelCode": code,
        "r0": r0(part.fresnel).to_array(),
        "eta": eta.value().to_array(),
        "k": k.value().to_array(),
        "roughness": part.roughness,
        "ks": part.ks.value().to_array(),
        "kd": part.kd.value().to_array(),
        "coupling": part.coupling.map_or("none", |coupling| coupling.name()),
    })
}

/// The texels, little endian, as the storage format has them.
fn packed(texture: &Texture) -> String {
    let values = texture.values.iter();
    let bytes: Vec<u8> = match texture.storage {
        Storage::F16 => values.flat_map(|value| f16::from_f64(*value).to_le_bytes()).collect(),
        _ => values.flat_map(|value| (*value as f32).to_le_bytes()).collect(),
    };
    base64::encode(&bytes)
}
