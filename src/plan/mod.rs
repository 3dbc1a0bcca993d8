//! What a scene calls for: the tables to compute, with their axes, and what is left out and why.
//!
//! A material is taken apart into lobes (`lobes.rs`), whose albedos add up. Factors of a lobe go, closed forms need no table, and
//! lobes that are then the same share theirs (`shared.rs`), over axes that span what they have (`axes.rs`).

mod axes;
mod economy;
mod lobes;
mod shared;
mod skipped;

pub use economy::Economy;
pub use lobes::{Base, Layer};
pub use skipped::Skipped;

use crate::bxdf::ModelError;
use crate::estimate::{Effort, Estimator};
use crate::scene::{Call, Gap, Material, ModelSpec, Scene};
use crate::spectrum::{Channels, Spectrum};
use crate::table::axis::{Axis, AxisError, Mapping};
use crate::table::names::file_stem;
use crate::table::{Lobe, MAX_TEXELS, Quantity};
use thiserror::Error;

/// What the caller of a bake may choose.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Request {
    /// Texels along mu.
    pub resolution: usize,
    /// Texels along a roughness axis.
    pub roughness_resolution: usize,
    /// Texels along an azimuth axis.
    pub azimuth_resolution: usize,
    /// Mapping of the mu axis; `None` keeps the one whose lookup errs least.
    pub mapping: Option<Mapping>,
    /// How the texels are computed.
    pub estimator: Estimator,
    /// Largest absolute error of any texel; `None` for [`crate::estimate::default_tolerance`] of each model.
    pub tolerance: Option<f64>,
    /// Fixed number of Monte Carlo samples instead of the tolerance.
    pub samples: Option<u64>,
    /// Seed of the random streams.
    pub seed: u64,
    /// What may be saved.
    pub economy: Economy,
}

/// Tables of 64, 32 and 16 texels along their axes, by the estimator that `auto` takes, to the default tolerance of each model.
impl Default for Request {
    fn default() -> Self {
        Self {
            resolution: 64,
            roughness_resolution: 32,
            azimuth_resolution: 16,
            mapping: None,
            estimator: Estimator::Auto,
            tolerance: None,
            samples: None,
            seed: 0,
            economy: Economy::FULL,
        }
    }
}

/// The tables of a scene.
#[derive(Debug, Clone, PartialEq)]
pub struct Plan {
    /// Name of the scene.
    pub scene: String,
    /// A directory name made from it.
    pub directory: String,
    /// The materials, in the order of the scene.
    pub materials: Vec<MaterialPlan>,
    /// The tables, each before those of later materials.
    pub tables: Vec<TablePlan>,
    /// The effects that no material calls for.
    pub skipped: Vec<Skipped>,
    /// Names of the materials that nothing in the scene uses.
    pub unused: Vec<String>,
    /// Measured data that count as 0 though they are not: `material: what and how many`.
    pub clipped: Vec<String>,
    /// What the reader of the scene had to look past.
    pub warnings: Vec<String>,
}

/// A material and what becomes of it.
#[derive(Debug, Clone, PartialEq)]
pub struct MaterialPlan {
    /// Name in the scene.
    pub name: String,
    /// What it calls for.
    pub calls: Vec<Call>,
    /// What it asks for and no table covers.
    pub gaps: Vec<Gap>,
    /// Whether the rules of the format make it and no definition in the file.
    pub implied: bool,
    /// Its lobes: their albedos add up, dimmed by the layers that they lie below.
    pub terms: Vec<Term>,
}

/// A lobe of a material: `scale` times the albedo of `model`, from tables or from a formula.
#[derive(Debug, Clone, PartialEq)]
pub struct Term {
    /// The side that light leaves on.
    pub lobe: Lobe,
    /// The model, with its own roughness and without the factors in `scale`.
    pub model: ModelSpec,
    /// Factor of the albedo.
    pub scale: Spectrum,
    /// The diffuse base that eq. 28 couples to the lobe.
    pub base: Option<Base>,
    /// The layers above it and its base, the uppermost first.
    pub layers: Vec<Layer>,
    /// Where rho_hd comes from.
    pub albedo: Source,
    /// Where rho_hh comes from; `None` where nobody needs it.
    pub mean: Option<Source>,
}

/// Where an albedo comes from.
#[derive(Debug, Clone, PartialEq)]
pub enum Source {
    /// A table.
    Table {
        /// Its id.
        id: String,
        /// r0 of Schlick's Fresnel term, for a table of two channels: the albedo is mix(R, G, r0).
        r0: Option<Spectrum>,
    },
    /// A formula, of no cost.
    ClosedForm(&'static str),
}

/// One table.
#[derive(Debug, Clone, PartialEq)]
pub struct TablePlan {
    /// Stem of its file name.
    pub id: String,
    /// What a person should know it for.
    pub purpose: &'static str,
    /// The integral.
    pub quantity: Quantity,
    /// The side it covers.
    pub lobe: Lobe,
    /// Materials that use it.
    pub materials: Vec<String>,
    /// The model that is integrated, with its roughness range where it has one.
    pub model: ModelSpec,
    /// Independent channels.
    pub channels: Channels,
    /// The axes, or several alternatives of which the one whose lookup errs least is kept.
    pub alternatives: Vec<Vec<Axis>>,
    /// How the texels are computed.
    pub estimator: Estimator,
    /// To which error.
    pub effort: Effort,
}

/// A table that cannot be computed as asked for.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum PlanError {
    /// An axis of the table.
    #[error(transparent)]
    Axis(#[from] AxisError),
    /// A model of the scene.
    #[error(transparent)]
    Model(#[from] ModelError),
    /// More texels than a file holds.
    #[error("table {id}: {texels} texels are not allowed: a table has at most {MAX_TEXELS}; lower the resolutions")]
    TooLarge {
        /// The table.
        id: String,
        /// Texels asked for.
        texels: usize,
    },
}

impl TablePlan {
    /// Number of texels of one alternative.
    pub fn texels(&self) -> usize {
        self.alternatives
            .first()
            .map_or(1, |axes| axes.iter().map(|axis| axis.size).product())
    }
}

impl Plan {
    /// The plan for `scene`.
    ///
    /// # Errors
    /// [`PlanError`] for resolutions that no axis or no table can have.
    pub fn new(scene: &Scene, request: &Request) -> Result<Self, PlanError> {
        let (materials, tables) = shared::tables(scene, request)?;
        let skipped = skipped::skipped(scene, &tables, request.economy);
        Ok(Self {
            scene: scene.name.clone(),
            directory: file_stem(&scene.name),
            materials,
            tables,
            skipped,
            unused: scene.unused.clone(),
            clipped: scene.materials.iter().flat_map(clipped).collect(),
            warnings: scene.warnings.clone(),
        })
    }

    /// Names of the materials.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.materials.iter().map(|material| material.name.as_str())
    }
}

fn clipped(material: &Material) -> Vec<String> {
    let clipped = material.model.clipped().into_iter();
    clipped.map(|what| format!("{}: {what}", material.name)).collect()
}
