//! What a manifest says of a material: how its albedo comes from tables and formulae.

use super::strings;
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};

/// A material and its tables.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct MaterialEntry {
    /// Name in the scene.
    pub name: String,
    /// Ids of the tables that it uses; none when closed forms suffice.
    pub tables: Vec<String>,
    /// Its lobes, whose albedos add up, each times the factors of the layers above it.
    pub lobes: Vec<LobeEntry>,
}

/// A lobe: `scale` times an albedo, with a diffuse base coupled to it or not.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct LobeEntry {
    /// `reflection` or `transmission`.
    pub side: String,
    /// Parameters of its model by name, without the factors in `scale`; all are strings.
    #[serde(deserialize_with = "strings")]
    pub model: Map<String, Value>,
    /// Factor of rho_hd and rho_hh, one number or three.
    pub scale: Vec<f64>,
    /// Where rho_hd comes from.
    pub rho_hd: AlbedoEntry,
    /// Where rho_hh comes from; null where nothing depends on it.
    pub rho_hh: Option<AlbedoEntry>,
    /// The base that eq. 28 couples to the lobe; null where there is none.
    pub diffuse_base: Option<BaseEntry>,
    /// The layers above lobe and base, each with a factor of both.
    #[serde(skip_serializing_if = "Vec::is_empty", default)]
    pub under: Vec<LayerEntry>,
}

/// A layer above a lobe.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct LayerEntry {
    /// The lobes of the layer, by their places in the list of the material.
    pub lobes: Vec<usize>,
    /// What it leaves of what lies below, in the albedo and the parameters of those lobes.
    pub factor: String,
}

/// Where an albedo comes from: a table or a formula.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct AlbedoEntry {
    /// Id of the table.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub table: Option<String>,
    /// For a table of two channels, r0 of Schlick's Fresnel term: the albedo is mix(R, G, r0).
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub r0: Option<Vec<f64>>,
    /// The formula, in the parameters of the model.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub closed_form: Option<String>,
}

/// A diffuse base under a specular lobe.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct BaseEntry {
    /// Scale of the specular lobe, one number or three.
    pub ks: Vec<f64>,
    /// Albedo of the base, one number or three.
    pub kd: Vec<f64>,
    /// `mikkelsen` or `energy-preserving`.
    pub coupling: String,
    /// Factor of base and lobe together, one number or three.
    pub scale: Vec<f64>,
    /// Which coupling of the material this is: lobes with the same number share one base, which counts once.
    pub coupled: usize,
}
