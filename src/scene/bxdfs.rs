//! The bxdfs of a scene.

use super::error::SceneError;
use super::facets::{DISTRIBUTION_RULE, FRESNEL_RULE, SLOPES_RULE, distribution, fresnel};
use super::library::Library;
use super::spec::{DistributionSpec, ModelSpec};
use super::table::{Entry, Rule, Table};
use super::vocabulary::{BXDFS, BxdfType, COUPLINGS, MASKINGS, SMITHS, TRANSPORTS, VEILS};
use crate::bxdf::{
    Coupling, Flags, FresnelSpecular, Lambertian, Media, ModelError, OrenNayar, SpecularReflection,
    SpecularTransmission, Transport, Veil,
};
use crate::parameter::{
    ETA_A, ETA_B, KD, KS, Legal, ParameterError, RD, REFLECTANCE, RS, SCALE, SIGMA_DEG, TRANSMITTANCE,
};
use crate::spectrum::Spectrum;

pub(super) const BXDF_RULE: &str = "bxdf is a table with a type and its parameters";

/// The bxdf of a material.
pub(super) fn material_bxdf(entry: Entry<'_>) -> Result<ModelSpec, SceneError> {
    let model = bxdf(entry, BXDF_RULE)?;
    if model.ranges().len() > 1 {
        return Err(
            entry.refuse("is not allowed: one roughness of a material may be a range; a table has one axis for it")
        );
    }
    Ok(model)
}

fn bxdf(entry: Entry<'_>, rule: &'static str) -> Result<ModelSpec, SceneError> {
    let table = entry.table(&rule)?;
    let kind = table.required("type", &BXDFS)?;
    match kind.choice(&BXDFS)? {
        BxdfType::Lambertian => lambertian(&table),
        BxdfType::OrenNayar => oren_nayar(&table),
        BxdfType::Microfacet => microfacet(&table),
        BxdfType::FresnelBlend => fresnel_blend(&table),
        BxdfType::SpecularReflection => specular_reflection(&table),
        BxdfType::SpecularTransmission => specular_transmission(&table),
        BxdfType::FresnelSpecular => fresnel_specular(&table),
        BxdfType::RoughDielectric => rough_dielectric(&table),
        BxdfType::BrdfToBtdf => brdf_to_btdf(&table),
        BxdfType::Scaled => scaled(&table),
        BxdfType::Sum => sum(&table),
        BxdfType::Merl => merl(&table),
        BxdfType::Irregular => irregular(&table),
        BxdfType::DiffuseSpecular => diffuse_specular(&table),
        BxdfType::Layered => layered(&table),
    }
}

fn lambertian(table: &Table<'_>) -> Result<ModelSpec, SceneError> {
    table.only("lambertian", &["type", "reflectance"])?;
    let lambertian = Lambertian::new(table.spectrum(REFLECTANCE)?).map_err(refused(table))?;
    Ok(ModelSpec::Lambertian(lambertian))
}

fn oren_nayar(table: &Table<'_>) -> Result<ModelSpec, SceneError> {
    table.only("oren-nayar", &["type", "reflectance", "sigma_deg"])?;
    let rough = OrenNayar::new(table.spectrum(REFLECTANCE)?, number(table, SIGMA_DEG)?).map_err(refused(table))?;
    Ok(ModelSpec::OrenNayar(rough))
}

fn microfacet(table: &Table<'_>) -> Result<ModelSpec, SceneError> {
    let keys = ["type", "reflectance", "distribution", "masking", "fresnel"];
    table.only("microfacet", &keys)?;
    let reflectance = or_white(table, REFLECTANCE)?;
    let distribution = distribution(table.required("distribution", &DISTRIBUTION_RULE)?)?;
    let masking = table.required("masking", &MASKINGS)?;
    let model = ModelSpec::Microfacet {
        reflectance,
        distribution,
        masking: masking.choice(&MASKINGS)?,
        fresnel: fresnel(table.required("fresnel", &FRESNEL_RULE)?)?,
    };
    // what is legal by itself may still not go together
    model
        .at(None)
        .map_err(|error| masking.refuse(format!("does not go with the rest: {error}")))?;
    Ok(model)
}

fn fresnel_blend(table: &Table<'_>) -> Result<ModelSpec, SceneError> {
    table.only("fresnel-blend", &["type", "rd", "rs", "distribution"])?;
    let facets = table.required("distribution", &DISTRIBUTION_RULE)?;
    let model = ModelSpec::FresnelBlend {
        rd: table.spectrum(RD)?,
        rs: table.spectrum(RS)?,
        distribution: distribution(facets)?,
    };
    model
        .at(None)
        .map_err(|error| facets.refuse(format!("does not go with the rest: {error}")))?;
    Ok(model)
}

fn specular_reflection(table: &Table<'_>) -> Result<ModelSpec, SceneError> {
    table.only("specular-reflection", &["type", "reflectance", "fresnel"])?;
    let fresnel = fresnel(table.required("fresnel", &FRESNEL_RULE)?)?;
    let mirror = SpecularReflection::new(or_white(table, REFLECTANCE)?, fresnel).map_err(refused(table))?;
    Ok(ModelSpec::SpecularReflection(mirror))
}

fn specular_transmission(table: &Table<'_>) -> Result<ModelSpec, SceneError> {
    let keys = ["type", "transmittance", "eta_a", "eta_b", "transport"];
    table.only("specular-transmission", &keys)?;
    let (eta_a, eta_b, transport) = interface(table)?;
    let transmittance = or_white(table, TRANSMITTANCE)?;
    let window = SpecularTransmission::new(transmittance, eta_a, eta_b, transport).map_err(refused(table))?;
    Ok(ModelSpec::SpecularTransmission(window))
}

fn fresnel_specular(table: &Table<'_>) -> Result<ModelSpec, SceneError> {
    let keys = ["type", "reflectance", "transmittance", "eta_a", "eta_b", "transport"];
    table.only("fresnel-specular", &keys)?;
    let (eta_a, eta_b, transport) = interface(table)?;
    let (reflectance, transmittance) = (or_white(table, REFLECTANCE)?, or_white(table, TRANSMITTANCE)?);
    let glass = FresnelSpecular::new(reflectance, transmittance, eta_a, eta_b, transport).map_err(refused(table))?;
    Ok(ModelSpec::FresnelSpecular(glass))
}

fn rough_dielectric(table: &Table<'_>) -> Result<ModelSpec, SceneError> {
    let keys = [
        "type",
        "reflectance",
        "transmittance",
        "eta_a",
        "eta_b",
        "distribution",
        "masking",
        "transport",
    ];
    table.only("rough-dielectric", &keys)?;
    let (eta_a, eta_b, transport) = interface(table)?;
    let facets = table.required("distribution", &SLOPES_RULE)?;
    let DistributionSpec::Isotropic { family, roughness } = distribution(facets)? else {
        return Err(facets.refuse("is not allowed: a rough-dielectric has one roughness, the same along both tangents"));
    };
    let masking = table.required("masking", &SMITHS)?;
    let model = ModelSpec::RoughDielectric {
        reflectance: or_white(table, REFLECTANCE)?,
        transmittance: or_white(table, TRANSMITTANCE)?,
        family,
        roughness,
        masking: masking.choice(&SMITHS)?,
        media: Media {
            eta_a,
            eta_b,
            transport,
        },
    };
    match model.at(None) {
        Ok(_) => Ok(model),
        Err(error @ ModelError::NoBend { .. }) => Err(match table.optional("eta_b") {
            Some(entry) => entry.refuse(format!("is not allowed: {error}")),
            None => table.refuse(error.to_string()),
        }),
        Err(error) => Err(masking.refuse(format!("does not go with the rest: {error}"))),
    }
}

/// eta_a (1 unless given), eta_b and what is transported.
fn interface(table: &Table<'_>) -> Result<(f64, f64, Transport), SceneError> {
    let eta_a = table.optional("eta_a").map_or(Ok(1.0), |entry| entry.number(ETA_A))?;
    let transport = match table.optional("transport") {
        Some(transport) => transport.choice(&TRANSPORTS)?,
        None => Transport::default(),
    };
    Ok((eta_a, number(table, ETA_B)?, transport))
}

fn brdf_to_btdf(table: &Table<'_>) -> Result<ModelSpec, SceneError> {
    table.only("brdf-to-btdf", &["type", "bxdf"])?;
    Ok(ModelSpec::BrdfToBtdf(Box::new(bxdf(
        table.required("bxdf", &BXDF_RULE)?,
        BXDF_RULE,
    )?)))
}

fn scaled(table: &Table<'_>) -> Result<ModelSpec, SceneError> {
    table.only("scaled", &["type", "bxdf", "scale"])?;
    Ok(ModelSpec::Scaled {
        scale: table.spectrum(SCALE)?,
        bxdf: Box::new(bxdf(table.required("bxdf", &BXDF_RULE)?, BXDF_RULE)?),
    })
}

fn sum(table: &Table<'_>) -> Result<ModelSpec, SceneError> {
    const RULE: &str = "bxdfs is an array of at least one bxdf";
    const PART_RULE: &str = "bxdfs holds tables, each with a type and its parameters";
    table.only("sum", &["type", "bxdfs"])?;
    let entry = table.required("bxdfs", &RULE)?;
    let parts: Result<Vec<ModelSpec>, SceneError> = entry.elements(&RULE)?.map(|part| bxdf(part, PART_RULE)).collect();
    match parts? {
        none if none.is_empty() => Err(entry.refuse(format!("is not allowed: {RULE}"))),
        parts => Ok(ModelSpec::Sum(parts)),
    }
}

fn merl(table: &Table<'_>) -> Result<ModelSpec, SceneError> {
    table.only("merl", &["type", "path"])?;
    let entry = table.required("path", &PATH_RULE)?;
    Ok(ModelSpec::HalfAngle(entry.data(Library::merl)?.as_ref().clone()))
}

fn irregular(table: &Table<'_>) -> Result<ModelSpec, SceneError> {
    table.only("irregular", &["type", "path"])?;
    let entry = table.required("path", &PATH_RULE)?;
    Ok(ModelSpec::Irregular(entry.data(Library::irregular)?.as_ref().clone()))
}

const PATH_RULE: &str = "path is the name of a file, relative to the scene file";

fn diffuse_specular(table: &Table<'_>) -> Result<ModelSpec, SceneError> {
    const RULE: &str = "specular is a table with a type and its parameters";
    table.only("diffuse-specular", &["type", "coupling", "ks", "kd", "specular"])?;
    let entry = table.required("specular", &RULE)?;
    let specular = bxdf(entry, RULE)?;
    if holds_coupling(&specular) {
        return Err(entry.refuse("is not allowed: a diffuse-specular cannot be the specular lobe of another"));
    }
    let sides = specular.at(None).map(|model| model.flags()).unwrap_or(Flags::empty());
    if !sides.contains(Flags::REFLECTION) || sides.contains(Flags::TRANSMISSION) {
        return Err(entry.refuse(
            "is not allowed: the specular lobe reflects and lets nothing through; eq. 28 gives the base what it does not reflect",
        ));
    }
    Ok(ModelSpec::DiffuseSpecular {
        coupling: match table.optional("coupling") {
            Some(coupling) => coupling.choice(&COUPLINGS)?,
            // the paper's own
            None => Coupling::Mikkelsen,
        },
        ks: table.spectrum(KS)?,
        kd: table.spectrum(KD)?,
        specular: Box::new(specular),
    })
}

/// What lies below gets what the albedo of the layer leaves, unless the veil is another.
fn layered(table: &Table<'_>) -> Result<ModelSpec, SceneError> {
    const TOP: &str = "top is a table with a type and its parameters";
    const BASE: &str = "base is a table with a type and its parameters";
    table.only("layered", &["type", "top", "base", "veil"])?;
    let top = table.required("top", &TOP)?;
    let model = ModelSpec::Layered {
        top: Box::new(bxdf(top, TOP)?),
        base: Box::new(bxdf(table.required("base", &BASE)?, BASE)?),
        veil: match table.optional("veil") {
            Some(veil) => veil.choice(&VEILS)?,
            None => Veil::Albedo,
        },
    };
    model
        .at(None)
        .map_err(|error| top.refuse(format!("does not go with the rest: {error}")))?;
    Ok(model)
}

fn holds_coupling(model: &ModelSpec) -> bool {
    matches!(model, ModelSpec::DiffuseSpecular { .. }) || model.parts().into_iter().any(holds_coupling)
}

fn number(table: &Table<'_>, legal: Legal) -> Result<f64, SceneError> {
    table.required(legal.name, &Rule("a number", legal))?.number(legal)
}

/// The spectrum under the name of `legal`, 1 unless given.
fn or_white(table: &Table<'_>, legal: Legal) -> Result<Spectrum, SceneError> {
    let given = table.optional(legal.name).map(|entry| entry.spectrum(legal));
    given.unwrap_or(Ok(Spectrum::grey(1.0)))
}

/// The models check their parameters once more; what they refuse is told about the table.
fn refused(table: &Table<'_>) -> impl Fn(ParameterError) -> SceneError {
    |error| table.refuse(error.to_string())
}
