//! What a scene calls for: the tables to compute, with their axes, and what is left out and why.

use crate::bxdf::{Flags, Model, ModelError};
use crate::estimate::{Effort, Estimator, default_tolerance};
use crate::scene::{Material, ModelSpec, Scene};
use crate::spectrum::Channels;
use crate::table::axis::{AZIMUTH, Axis, AxisError, Mapping, TexelRule};
use crate::table::names::{file_stem, file_stems};
use crate::table::{Lobe, MAX_TEXELS, Quantity};
use std::f64::consts::FRAC_PI_2;
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
    /// Largest absolute error of any texel; `None` for [`default_tolerance`] of each model.
    pub tolerance: Option<f64>,
    /// Fixed number of Monte Carlo samples instead of the tolerance.
    pub samples: Option<u64>,
    /// Seed of the random streams.
    pub seed: u64,
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
    /// Names of the materials, in the order of the scene.
    pub materials: Vec<String>,
    /// The tables, in the order of the materials.
    pub tables: Vec<TablePlan>,
    /// What no material calls for.
    pub left_out: Vec<LeftOut>,
    /// Measured data that count as 0 though they are not: `material: what and how many`.
    pub clipped: Vec<String>,
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
            clipped: scene.materials.iter().flat_map(clipped).collect(),
        })
    }
}

/// rho_hd and rho_hh of every side that the material scatters to, and of the specular lobe alone where eq. 28 couples it to a
/// diffuse base.
fn material_tables(material: &Material, stem: &str, request: &Request) -> Result<Vec<TablePlan>, PlanError> {
    let mut tables = Vec::new();
    if let ModelSpec::DiffuseSpecular { specular, .. } = &material.model {
        let purposes = [
            "rho(mu) of eq. 28, specular lobe with ks = 1",
            "rho_bar of the specular lobe with ks = 1",
        ];
        tables.extend(pair(
            material,
            format!("{stem}.specular"),
            specular,
            Lobe::Reflection,
            purposes,
            request,
        )?);
    }
    let flags = material.model.at(None)?.flags();
    for lobe in Lobe::ALL.into_iter().filter(|lobe| flags.contains(lobe.flag())) {
        let (stem, purposes) = match lobe {
            Lobe::Reflection => (
                stem.to_owned(),
                [
                    "directional albedo of the whole material",
                    "mean albedo of the whole material",
                ],
            ),
            Lobe::Transmission => (
                format!("{stem}.transmission"),
                [
                    "share of light from one direction that passes",
                    "mean share of light that passes",
                ],
            ),
        };
        tables.extend(pair(material, stem, &material.model, lobe, purposes, request)?);
    }
    Ok(tables)
}

/// rho_hd and rho_hh of one side of a model.
fn pair(
    material: &Material,
    stem: String,
    model: &ModelSpec,
    lobe: Lobe,
    purposes: [&'static str; 2],
    request: &Request,
) -> Result<[TablePlan; 2], PlanError> {
    let sample = model.at(None)?;
    let tolerance = request.tolerance.unwrap_or_else(|| default_tolerance(&sample));
    let table = |quantity: Quantity, purpose| -> Result<TablePlan, PlanError> {
        let plan = TablePlan {
            id: format!("{stem}.{}", quantity.name()),
            purpose,
            quantity,
            lobe,
            materials: vec![material.name.clone()],
            model: model.clone(),
            channels: sample.channels(),
            alternatives: alternatives(quantity, model, &sample, request)?,
            estimator: request.estimator,
            effort: Effort {
                tolerance,
                samples: request.samples,
                seed: request.seed,
            },
        };
        match plan.texels() {
            texels if texels > MAX_TEXELS => Err(PlanError::TooLarge { id: plan.id, texels }),
            _ => Ok(plan),
        }
    };
    let [hd, hh] = purposes;
    Ok([table(Quantity::RhoHd, hd)?, table(Quantity::RhoHh, hh)?])
}

fn alternatives(
    quantity: Quantity,
    spec: &ModelSpec,
    model: &Model,
    request: &Request,
) -> Result<Vec<Vec<Axis>>, AxisError> {
    let roughness = roughness_axis(spec, request.roughness_resolution)?;
    if quantity == Quantity::RhoHh {
        return Ok(vec![roughness.into_iter().collect()]);
    }
    let azimuth = match model.is_anisotropic() {
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

fn clipped(material: &Material) -> Vec<String> {
    let clipped = material.model.clipped().into_iter();
    clipped.map(|what| format!("{}: {what}", material.name)).collect()
}

fn left_out(scene: &Scene) -> Vec<LeftOut> {
    let specs = || scene.materials.iter().map(|material| &material.model);
    let models: Vec<Model> = specs().filter_map(|spec| spec.at(None).ok()).collect();
    let any = |test: fn(&Model) -> bool| models.iter().any(test);
    let uses = [
        (
            any(Model::is_anisotropic),
            "azimuth axis",
            "every material is isotropic",
        ),
        (
            any(|model| model.flags().contains(Flags::TRANSMISSION)),
            "transmission",
            "no material transmits light",
        ),
        (
            specs().any(|spec| spec.roughness_range().is_some()),
            "roughness axis",
            "every roughness is one value",
        ),
        (
            any(Model::is_coupled),
            "diffuse coupling",
            "no material is diffuse-specular",
        ),
        (
            any(|model| model.channels() == Channels::Rgb),
            "colour",
            "every parameter is grey: one channel each",
        ),
    ];
    let unused = uses.into_iter().filter(|(used, ..)| !used);
    unused
        .map(|(_, effect, reason)| LeftOut {
            effect,
            reason: reason.into(),
        })
        .collect()
}
