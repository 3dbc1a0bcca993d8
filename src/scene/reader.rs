//! From the tables of a scene file to its materials.

use super::error::SceneError;
use super::spec::{DistributionSpec, ModelSpec, Roughness};
use super::table::{Entry, Rule, Table};
use super::text::Text;
use super::vocabulary::{BXDFS, BxdfType, COUPLINGS, DISTRIBUTIONS, DistributionType, FRESNELS, FresnelType, MASKINGS};
use super::{Material, Scene};
use crate::bxdf::{Coupling, Lambertian};
use crate::distribution::{Anisotropic, Elliptic};
use crate::fresnel::Fresnel;
use crate::parameter::{ETA, EXTINCTION, KD, KS, Legal, ParameterError, R0, REFLECTANCE};
use crate::spectrum::Spectrum;
use std::collections::HashMap;
use std::fmt;
use std::path::Path;
use toml::de::DeTable;

/// Where a bxdf stands, which decides what it may be.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Place {
    /// The bxdf of a material.
    Material,
    /// The specular lobe of a diffuse-specular one.
    Specular,
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let key = match self {
            Self::Material => "bxdf",
            Self::Specular => "specular",
        };
        write!(f, "{key} is a table with a type and its parameters")
    }
}

/// Reads the scene in `content`, which `source` names.
pub(super) fn scene(content: &str, source: &str) -> Result<Scene, SceneError> {
    let text = Text::new(source, content);
    let root = DeTable::parse(text.content()).map_err(|error| syntax_error(&text, &error))?;
    let root = Table::new(&text, root.get_ref(), 0..0);
    root.only("a scene", &["scene", "material"])?;
    Ok(Scene {
        name: scene_name(&root, source)?,
        materials: materials(&root)?,
        source: source.to_owned(),
    })
}

fn syntax_error(text: &Text<'_>, error: &toml::de::Error) -> SceneError {
    // the limit on dotted keys is the one complaint that comes without a place; the line with the most dots exceeds it
    let span = error.span().unwrap_or_else(|| {
        let lines = text.content().split_inclusive('\n').scan(0, |end, line| {
            let start = *end;
            *end += line.len();
            Some((line.bytes().filter(|byte| *byte == b'.').count(), start))
        });
        let (_, start) = lines.max_by_key(|(dots, _)| *dots).unwrap_or_default();
        start..start
    });
    text.refuse(span, format!("not valid TOML: {}", error.message()))
}

fn scene_name(root: &Table<'_>, source: &str) -> Result<String, SceneError> {
    if let Some(entry) = root.optional("scene") {
        let table = entry.table(&"scene is one table, [scene]")?;
        table.only("[scene]", &["name"])?;
        if let Some(name) = table.optional("name") {
            return Ok(name.name()?.to_owned());
        }
    }
    let stem = Path::new(source).file_stem().map(|stem| stem.to_string_lossy());
    Ok(stem.map_or_else(|| source.to_owned(), |stem| stem.into_owned()))
}

fn materials(root: &Table<'_>) -> Result<Vec<Material>, SceneError> {
    const RULE: &str = "a scene holds at least one [[material]], each with name and bxdf";
    let entry = root.required("material", &RULE)?;
    let mut materials = Vec::new();
    let mut lines = HashMap::new();
    for element in entry.elements(&"materials are tables, each under a header [[material]]")? {
        let table = element.table(&"materials are tables with name and bxdf")?;
        table.only("[[material]]", &["name", "bxdf"])?;
        let name = table.required("name", &"every material has a name of its own")?;
        let material = Material {
            name: name.name()?.to_owned(),
            model: bxdf(table.required("bxdf", &Place::Material)?, Place::Material)?,
            line: table.line(),
        };
        if let Some(line) = lines.insert(name.name()?, material.line) {
            let verdict = format!("is not allowed: the material at line {line} has that name already");
            return Err(name.refuse(verdict));
        }
        materials.push(material);
    }
    if materials.is_empty() {
        return Err(entry.refuse(format!("is not allowed: {RULE}")));
    }
    Ok(materials)
}

fn bxdf(entry: Entry<'_>, place: Place) -> Result<ModelSpec, SceneError> {
    let table = entry.table(&place)?;
    let kind = table.required("type", &BXDFS)?;
    match kind.choice(&BXDFS)? {
        BxdfType::Lambertian => lambertian(&table),
        BxdfType::Microfacet => microfacet(&table),
        BxdfType::DiffuseSpecular if place == Place::Specular => Err(kind.refuse(
            "is not allowed: a diffuse-specular cannot be the specular lobe of another; specular is a \"lambertian\" or \
             a \"microfacet\"",
        )),
        BxdfType::DiffuseSpecular => diffuse_specular(&table),
    }
}

fn lambertian(table: &Table<'_>) -> Result<ModelSpec, SceneError> {
    table.only("lambertian", &["type", "reflectance"])?;
    let reflectance = required_spectrum(table, REFLECTANCE)?;
    let lambertian = Lambertian::new(reflectance).map_err(refused(table))?;
    Ok(ModelSpec::Lambertian(lambertian))
}

fn microfacet(table: &Table<'_>) -> Result<ModelSpec, SceneError> {
    let keys = ["type", "reflectance", "distribution", "masking", "fresnel"];
    table.only("microfacet", &keys)?;
    let reflectance = table.optional("reflectance").map(|entry| entry.spectrum(REFLECTANCE));
    Ok(ModelSpec::Microfacet {
        reflectance: reflectance.unwrap_or(Ok(Spectrum::grey(1.0)))?,
        distribution: distribution(table.required("distribution", &DISTRIBUTION_RULE)?)?,
        masking: table.required("masking", &MASKINGS)?.choice(&MASKINGS)?,
        fresnel: fresnel(table.required("fresnel", &FRESNEL_RULE)?)?,
    })
}

fn diffuse_specular(table: &Table<'_>) -> Result<ModelSpec, SceneError> {
    table.only("diffuse-specular", &["type", "coupling", "ks", "kd", "specular"])?;
    Ok(ModelSpec::DiffuseSpecular {
        coupling: match table.optional("coupling") {
            Some(coupling) => coupling.choice(&COUPLINGS)?,
            // the paper's own
            None => Coupling::Mikkelsen,
        },
        ks: required_spectrum(table, KS)?,
        kd: required_spectrum(table, KD)?,
        specular: Box::new(bxdf(table.required("specular", &Place::Specular)?, Place::Specular)?),
    })
}

const DISTRIBUTION_RULE: &str = "distribution is a table such as { type = \"vmf\", kappa = 17.0 }";

fn distribution(entry: Entry<'_>) -> Result<DistributionSpec, SceneError> {
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
    let anisotropic = Anisotropic::new(kind, x, y).map_err(refused(table))?;
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

const FRESNEL_RULE: &str = "fresnel is a table such as { type = \"dielectric\", eta = 1.5 }, or \"none\"";

/// `"none"` alone stands for `{ type = "none" }`, which has no parameters.
fn fresnel(entry: Entry<'_>) -> Result<Fresnel, SceneError> {
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
            Fresnel::dielectric(required_spectrum(&table, ETA)?).map_err(refused(&table))
        }
        FresnelType::Conductor => {
            let (eta, k) = conductor_index(&table, "conductor")?;
            Fresnel::conductor(eta, k).map_err(refused(&table))
        }
        FresnelType::ConductorApproximate => {
            let (eta, k) = conductor_index(&table, "conductor-approximate")?;
            Fresnel::conductor_approximate(eta, k).map_err(refused(&table))
        }
        FresnelType::Schlick => {
            table.only("schlick", &["type", "r0"])?;
            Fresnel::schlick(required_spectrum(&table, R0)?).map_err(refused(&table))
        }
    }
}

fn conductor_index(table: &Table<'_>, what: &str) -> Result<(Spectrum, Spectrum), SceneError> {
    table.only(what, &["type", "eta", "k"])?;
    Ok((required_spectrum(table, ETA)?, required_spectrum(table, EXTINCTION)?))
}

fn required_spectrum(table: &Table<'_>, legal: Legal) -> Result<Spectrum, SceneError> {
    let rule = Rule("a number or an array of three numbers", legal);
    table.required(legal.name, &rule)?.spectrum(legal)
}

/// The models check their parameters once more; what they refuse is told about the table.
fn refused(table: &Table<'_>) -> impl Fn(ParameterError) -> SceneError {
    |error| table.refuse(error.to_string())
}
