//! What a scene calls for: the tables to compute, with their axes, and what is left out and why.

use crate::estimate::{Effort, Estimator};
use crate::scene::{Material, ModelSpec, Scene};
use crate::spectrum::Channels;
use crate::table::axis::{Axis, AxisError, Mapping, TexelRule};
use crate::table::names::{file_stem, file_stems};
use crate::table::{Lobe, MAX_TEXELS, Quantity};
use thiserror::Error;

/// What the caller of a bake may choose.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Request {
    /// Texels along mu.
    pub resolution: usize,
    /// Texels along a roughness axis.
    pub roughness_resolution: usize,
    /// Mapping of the mu axis; `None` keeps the one whose lookup errs least.
    pub mapping: Option<Mapping>,
    /// How the texels are computed.
    pub estimator: Estimator,
    /// To which error.
    pub effort: Effort,
}

/// The tables of a scene.
#[derive(Debug, Clone, PartialEq)]
pub struct Plan {
    /// Name of the scene.
    pub scene: String,
    /// A directory name made from it.
    pub directory: String,
    /// Names of the materials, in the order of the scene.
    pub materials: Vec<String>,
    /// The tables, in the order of the materials.
    pub tables: Vec<TablePlan>,
    /// What no material calls for.
    pub left_out: Vec<LeftOut>,
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

/// Something that the scene does not call for.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct LeftOut {
    /// The effect.
    pub effect: &'static str,
    /// Why it is not computed.
    pub reason: String,
}

/// A table that cannot be computed as asked for.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum PlanError {
    /// An axis of the table.
    #[error(transparent)]
    Axis(#[from] AxisError),
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
        let names: Vec<&str> = scene.materials.iter().map(|material| material.name.as_str()).collect();
        let mut tables = Vec::new();
        for (material, stem) in scene.materials.iter().zip(file_stems(&names)) {
            tables.extend(material_tables(material, &stem, request)?);
        }
        Ok(Self {
            scene: scene.name.clone(),
            directory: file_stem(&scene.name),
            materials: scene.materials.iter().map(|material| material.name.clone()).collect(),
            tables,
            left_out: left_out(scene),
        })
    }
}

/// rho_hd and rho_hh of the whole material, and of the specular lobe alone where eq. 28 couples it to a diffuse base.
fn material_tables(material: &Material, stem: &str, request: &Request) -> Result<Vec<TablePlan>, PlanError> {
    let table = |suffix: &str, purpose, quantity, model: &ModelSpec| -> Result<TablePlan, PlanError> {
        let plan = TablePlan {
            id: format!("{stem}.{suffix}"),
            purpose,
            quantity,
            lobe: Lobe::Reflection,
            materials: vec![material.name.clone()],
            model: model.clone(),
            channels: model.channels(),
            alternatives: alternatives(quantity, model, request)?,
            estimator: request.estimator,
            effort: request.effort,
        };
        match plan.texels() {
            texels if texels > MAX_TEXELS => Err(PlanError::TooLarge { id: plan.id, texels }),
            _ => Ok(plan),
        }
    };
    let mut tables = Vec::new();
    if let ModelSpec::DiffuseSpecular { specular, .. } = &material.model {
        tables.push(table(
            "specular.rho_hd",
            "rho(mu) of eq. 28, specular lobe with ks = 1",
            Quantity::RhoHd,
            specular,
        )?);
        tables.push(table(
            "specular.rho_hh",
            "rho_bar of the specular lobe with ks = 1",
            Quantity::RhoHh,
            specular,
        )?);
    }
    tables.push(table(
        "rho_hd",
        "directional albedo of the whole material",
        Quantity::RhoHd,
        &material.model,
    )?);
    tables.push(table(
        "rho_hh",
        "mean albedo of the whole material",
        Quantity::RhoHh,
        &material.model,
    )?);
    Ok(tables)
}

fn alternatives(quantity: Quantity, model: &ModelSpec, request: &Request) -> Result<Vec<Vec<Axis>>, AxisError> {
    let roughness = roughness_axis(model, request.roughness_resolution)?;
    if quantity == Quantity::RhoHh {
        return Ok(vec![roughness.into_iter().collect()]);
    }
    let choices = match (request.mapping, model) {
        (Some(mapping), _) => vec![(mapping, TexelRule::Centres)],
        // constant: nothing to choose
        (None, ModelSpec::Lambertian(_)) => vec![(Mapping::Mu, TexelRule::Centres)],
        (None, _) => MU_AXES.to_vec(),
    };
    choices
        .into_iter()
        .map(|(mapping, rule)| {
            let mu = Axis::new("mu", mapping, rule, [0.0, 1.0], request.resolution)?;
            Ok([Some(mu), roughness.clone()].into_iter().flatten().collect())
        })
        .collect()
}

/// The axes to choose from, the simplest for a shader first: u = mu needs no arithmetic, sqrt mu gives the boundary layer at
/// grazing angles more texels, and texels at the ends hold the limits themselves.
const MU_AXES: [(Mapping, TexelRule); 3] = [
    (Mapping::Mu, TexelRule::Centres),
    (Mapping::SqrtMu, TexelRule::Centres),
    (Mapping::SqrtMu, TexelRule::Ends),
];

/// Roughness parameters act by their ratios; those that may be 0 by the ratios of 1 + value.
///
/// Texels sit at the ends: the ends of a range are materials of the scene, and clamping half a texel before them errs by a
/// few per cent.
fn roughness_axis(model: &ModelSpec, size: usize) -> Result<Option<Axis>, AxisError> {
    let Some((family, min, max)) = model.roughness_range() else {
        return Ok(None);
    };
    let legal = family.legal();
    let mapping = if legal.min > 0.0 { Mapping::Log } else { Mapping::Log1p };
    Axis::new(legal.name, mapping, TexelRule::Ends, [min, max], size).map(Some)
}

fn left_out(scene: &Scene) -> Vec<LeftOut> {
    let mut left_out = vec![
        LeftOut {
            effect: "azimuth axis",
            reason: "every material is isotropic".into(),
        },
        LeftOut {
            effect: "transmission",
            reason: "no material transmits light".into(),
        },
    ];
    let any = |test: fn(&ModelSpec) -> bool| scene.materials.iter().any(|material| test(&material.model));
    if !any(|model| model.roughness_range().is_some()) {
        left_out.push(LeftOut {
            effect: "roughness axis",
            reason: "every roughness is one value".into(),
        });
    }
    if !any(|model| matches!(model, ModelSpec::DiffuseSpecular { .. })) {
        left_out.push(LeftOut {
            effect: "diffuse coupling",
            reason: "no material is diffuse-specular".into(),
        });
    }
    if !any(|model| model.channels() == Channels::Rgb) {
        left_out.push(LeftOut {
            effect: "colour",
            reason: "every parameter is grey: one channel each".into(),
        });
    }
    left_out
}
