//! Distributions of normals and Fresnel terms of a scene.

use super::error::SceneError;
use super::library::Library;
use super::spec::{DistributionSpec, Roughness};
use super::table::{Entry, Rule, Table};
use super::vocabulary::{DISTRIBUTIONS, DistributionType, FRESNELS, FresnelType};
use crate::distribution::{Anisotropic, Elliptic};
use crate::fresnel::Fresnel;
use crate::measured::index::{ConductorIndex, NAMES};
use crate::parameter::{ETA, EXTINCTION, Legal, R0};
use crate::spectrum::Spectrum;

pub(super) const SLOPES_RULE: &str =
    "distribution is a table such as { type = \"ggx\", alpha = 0.3 }, of ggx or beckmann";

pub(super) const DISTRIBUTION_RULE: &str = "distribution is a table such as { type = \"vmf\", kappa = 17.0 }";

pub(super) fn distribution(entry: Entry<'_>) -> Result<DistributionSpec, SceneError> {
    let table = entry.table(&DISTRIBUTION_RULE)?;
    let kind = table.required("type", &DISTRIBUTIONS)?;
    let what = kind.as_str().unwrap_or_default();
    let DistributionType { isotropic, elliptic } = kind.choice(&DISTRIBUTIONS)?;
    let one = isotropic.map(|(_, legal)| legal.name);
    let two = elliptic.map(|elliptic| elliptic.legal().map(|legal| legal.name));
    let keys: Vec<&str> = ["type"]
        .into_iter()
        .chain(one)
        .chain(two.into_iter().flatten())
        .collect();
    table.only(what, &keys)?;
    let is_pair = two.is_some_and(|two| one.is_none() || two.iter().any(|key| table.optional(key).is_some()));
    match (isotropic, elliptic) {
        (_, Some(elliptic)) if is_pair => {
            if let Some(entry) = one.and_then(|one| table.optional(one)) {
                let [x, y] = elliptic.legal().map(|legal| legal.name);
                return Err(entry.refuse(format!("is not allowed beside {x} and {y}: a {what} has either")));
            }
            anisotropic(&table, elliptic)
        }
        (Some((family, legal)), _) => {
            let roughness = table.required(legal.name, &Rule(ROUGHNESS, legal))?;
            Ok(DistributionSpec::Isotropic {
                family,
                roughness: read_roughness(roughness, legal)?,
            })
        }
        (None, _) => Err(kind.wrong_type(&DISTRIBUTIONS)),
    }
}

/// Two equal parameters are the isotropic distribution, whose tables need no azimuth.
fn anisotropic(table: &Table<'_>, kind: Elliptic) -> Result<DistributionSpec, SceneError> {
    let [x, y] = kind.legal().map(|legal| {
        let entry = table.required(legal.name, &Rule("a number", legal))?;
        if entry.as_table().is_some() {
            return Err(entry.refuse(
                "is not allowed: a roughness along each tangent is a number; a table has no third axis for its range",
            ));
        }
        entry.number(legal)
    });
    let (x, y) = (x?, y?);
    if x == y {
        return Ok(DistributionSpec::Isotropic {
            family: kind.family(),
            roughness: Roughness::Fixed(x),
        });
    }
    let anisotropic = Anisotropic::new(kind, x, y).map_err(|error| table.refuse(error.to_string()))?;
    Ok(DistributionSpec::Anisotropic(anisotropic))
}

/// What a roughness parameter may be.
const ROUGHNESS: &str = "a number or a range { min = .., max = .. }";

fn read_roughness(entry: Entry<'_>, legal: Legal) -> Result<Roughness, SceneError> {
    let Some(range) = entry.as_table() else {
        return Ok(Roughness::Fixed(entry.number_or(legal, ROUGHNESS)?));
    };
    range.only("a range", &["min", "max"])?;
    let end = |key| {
        range
            .required(key, &Rule("a range { min = .., max = .. }", legal))?
            .number(legal)
    };
    let (min, max) = (end("min")?, end("max")?);
    if min >= max {
        return Err(entry.refuse("is not allowed: in a range min is smaller than max"));
    }
    Ok(Roughness::Range { min, max })
}

pub(super) const FRESNEL_RULE: &str = "fresnel is a table such as { type = \"dielectric\", eta = 1.5 }, or \"none\"";

/// `"none"` alone stands for `{ type = "none" }`, which has no parameters.
pub(super) fn fresnel(entry: Entry<'_>) -> Result<Fresnel, SceneError> {
    if let Some(name) = entry.as_str() {
        return match entry.choice(&FRESNELS)? {
            FresnelType::None => Ok(Fresnel::None),
            _ => Err(entry.refuse(format!(
                "is not allowed: {name} has parameters, and stands in a table {{ type = \"{name}\", .. }}"
            ))),
        };
    }
    let table = entry.table(&FRESNEL_RULE)?;
    match table.required("type", &FRESNELS)?.choice(&FRESNELS)? {
        FresnelType::None => {
            table.only("none", &["type"])?;
            Ok(Fresnel::None)
        }
        FresnelType::Dielectric => {
            table.only("dielectric", &["type", "eta"])?;
            Fresnel::dielectric(table.spectrum(ETA)?).map_err(|error| table.refuse(error.to_string()))
        }
        FresnelType::Conductor => {
            let (eta, k) = conductor_index(&table, "conductor")?;
            Fresnel::conductor(eta, k).map_err(|error| table.refuse(error.to_string()))
        }
        FresnelType::ConductorApproximate => {
            let (eta, k) = conductor_index(&table, "conductor-approximate")?;
            Fresnel::conductor_approximate(eta, k).map_err(|error| table.refuse(error.to_string()))
        }
        FresnelType::Schlick => {
            table.only("schlick", &["type", "r0"])?;
            Fresnel::schlick(table.spectrum(R0)?).map_err(|error| table.refuse(error.to_string()))
        }
    }
}

/// eta and k as numbers, as the names of two files of samples, by the name of a metal, or from one table of both.
fn conductor_index(table: &Table<'_>, what: &str) -> Result<(Spectrum, Spectrum), SceneError> {
    table.only(what, &["type", "eta", "k", "metal", "nk"])?;
    let read = match (table.optional("metal"), table.optional("nk")) {
        (None, None) => return eta_and_k(table),
        (Some(metal), None) => ConductorIndex::named(metal.name()?).ok_or_else(|| {
            let names = NAMES.map(|name| format!("\"{name}\"")).join(", ");
            metal.refuse(format!(
                "is not allowed: metal is one of {names}; others are numbers eta and k, two files, or a table nk"
            ))
        })?,
        (None, Some(nk)) => *nk.data(Library::index)?,
        (Some(_), Some(nk)) => return Err(nk.refuse("is not allowed beside metal: a conductor has either")),
    };
    for key in ["eta", "k"] {
        if let Some(entry) = table.optional(key) {
            return Err(entry.refuse("is not allowed beside metal or nk, which give both eta and k"));
        }
    }
    Ok((read.eta(), read.k()))
}

fn eta_and_k(table: &Table<'_>) -> Result<(Spectrum, Spectrum), SceneError> {
    const RULE: &str = "a number, an array of three numbers, or the name of an .spd file,";
    let entry = |legal: Legal| table.required(legal.name, &Rule(RULE, legal));
    let (eta, k) = (entry(ETA)?, entry(EXTINCTION)?);
    match (eta.as_str(), k.as_str()) {
        (None, None) => Ok((eta.spectrum(ETA)?, k.spectrum(EXTINCTION)?)),
        (Some(_), Some(_)) => {
            let read = |entry: &Entry<'_>| {
                let samples = entry.data(Library::spectrum)?;
                Ok::<_, SceneError>((entry.path()?.display().to_string(), samples))
            };
            let ((eta_name, eta_samples), (k_name, k_samples)) = (read(&eta)?, read(&k)?);
            let index = ConductorIndex::from_samples(&eta_name, &eta_samples, &k_name, &k_samples)
                .map_err(|error| eta.unusable(&error))?;
            Ok((index.eta(), index.k()))
        }
        (Some(_), None) => Err(k.refuse("is not allowed beside a file of eta: both are numbers or both are files")),
        (None, Some(_)) => Err(k.refuse("is not allowed beside a number eta: both are numbers or both are files")),
    }
}
