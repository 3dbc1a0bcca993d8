//! What is studied: the directional albedo of a material at the texels of a small table.

use super::CostError;
use crate::bxdf::{Irregular, Model};
use crate::estimate::{Effort, Estimator};
use crate::integrate::{Coordinates, IntegrateError, Integrator, Target};
use crate::measured::irregular::IrregularSamples;
use crate::plan::{Economy, Plan, Request, TablePlan};
use crate::scene::{Material, ModelSpec, Scene};
use crate::table::Quantity;
use crate::table::axis::{Mapping, texel_places};
use std::sync::Arc;

/// Texels along an axis that is not mu.
const ACROSS: usize = 4;

/// Of irregular samples, whose lookups take microseconds, this share of the texels is enough.
const MEASURED_SHARE: usize = 4;

/// A material with the places at which its albedo is computed.
#[derive(Debug)]
pub struct Subject {
    /// The material.
    pub material: String,
    /// Its table of rho_hd: of the specular lobe where eq. 28 couples one to a base, of the reflection, or of the
    /// transmission of what does not reflect.
    pub plan: TablePlan,
    /// The integrals, in runs of equal model.
    pub(super) runs: Vec<(Model, Vec<Target>)>,
}

/// The scene that is studied when nobody names one: `cost.toml` and 30 records of a measured acrylic paint.
pub fn default_scene() -> Scene {
    let parsed = Scene::parse(include_str!("cost.toml"), "built-in scene");
    let mut scene = parsed.unwrap_or_else(|error| unreachable!("{error}"));
    let bytes = include_bytes!("data/acryl-blue-30.brdf");
    let samples = IrregularSamples::parse("acryl-blue-30.brdf", bytes);
    let samples = samples.unwrap_or_else(|error| unreachable!("{error}"));
    let samples = ModelSpec::Irregular(Irregular::new(Arc::new(samples)));
    scene.materials.push(Material::new("acrylic-paint-measured", samples));
    scene
}

/// The plan of the table of `material` that a study is about, with `resolution` texels along mu.
///
/// # Errors
/// [`CostError::Plan`]
pub(super) fn plan_of(material: &Material, resolution: usize, across: usize) -> Result<TablePlan, CostError> {
    plan_over(material, resolution, across, None)
}

fn plan_over(
    material: &Material,
    resolution: usize,
    across: usize,
    mapping: Option<Mapping>,
) -> Result<TablePlan, CostError> {
    let scene = Scene::new("cost", vec![material.clone()]);
    let request = Request {
        resolution,
        roughness_resolution: across,
        azimuth_resolution: across,
        mapping,
        estimator: Estimator::Auto,
        tolerance: None,
        samples: None,
        economy: Economy {
            // their cost is a subject, too
            closed_forms: false,
            ..Economy::FULL
        },
        seed: 0,
    };
    let tables = Plan::new(&scene, &request)?.tables;
    let hd = tables.into_iter().find(|table| table.quantity == Quantity::RhoHd);
    hd.ok_or_else(|| CostError::Nothing(material.name.clone()))
}

impl Subject {
    /// The table of `material` with `texels` texels in all, at least 2 along mu.
    ///
    /// # Errors
    /// [`CostError`] for a material that no table can be planned for.
    pub fn new(material: &Material, texels: usize) -> Result<Self, CostError> {
        let is_irregular = material.model.at(None)?.is_irregular();
        let texels = if is_irregular { texels / MEASURED_SHARE } else { texels };
        // dense at grazing angles, where the horizon cuts lobes
        let over = |resolution: usize| plan_over(material, resolution.max(2), ACROSS, Some(Mapping::SqrtMu));
        let flat = over(texels)?;
        let plan = if flat.texels() > texels.max(2) {
            over(texels / ACROSS)?
        } else {
            flat
        };
        let axes = plan.alternatives.first().cloned().unwrap_or_default();
        let along = Coordinates::new(&axes);
        let runs = texel_places(&axes)
            .chunk_by(|a, b| along.roughness(a) == along.roughness(b))
            .map(|run| {
                let model = plan.model.at(along.roughness(&run[0]))?;
                let targets = run.iter().map(|place| along.target(plan.quantity, place).of(plan.lobe));
                Ok((model, targets.collect()))
            })
            .collect::<Result<_, CostError>>()?;
        Ok(Self {
            material: material.name.clone(),
            plan,
            runs,
        })
    }

    /// Number of integrals.
    pub fn texels(&self) -> usize {
        self.runs.iter().map(|(_, targets)| targets.len()).sum()
    }

    /// Whether it is measured, and known by samples alone.
    pub fn is_irregular(&self) -> bool {
        self.runs.iter().any(|(model, _)| model.is_irregular())
    }

    /// Why `estimator` cannot compute the material at all, `None` if it can.
    pub(super) fn unsupported(&self, estimator: Estimator) -> Option<String> {
        let effort = Effort {
            tolerance: 0.5,
            samples: Some(2),
            seed: 0,
        };
        let (model, targets) = self.runs.first()?;
        let target = *targets.first()?;
        let tried = Integrator::new(model, estimator, effort).and_then(|integrator| integrator.estimate(target, 0));
        match tried {
            Err(IntegrateError::Unsupported { reason, .. }) => Some(reason.into()),
            _ => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_default_material_has_a_table_of_the_size_asked_for() {
        for material in &default_scene().materials {
            let subject = Subject::new(material, 64).unwrap();
            let measured = if subject.is_irregular() { 4 } else { 1 };
            assert_eq!(subject.texels() * measured, 64, "{}", material.name);
        }
    }

    #[test]
    fn a_range_of_roughness_makes_a_model_for_each_row() {
        let scene = Scene::default_scene();
        let ranged = scene.materials.iter().find(|m| m.name == "vmf-any-roughness").unwrap();
        let subject = Subject::new(ranged, 64).unwrap();
        assert_eq!((subject.runs.len(), subject.texels()), (ACROSS, 64));
    }
}
