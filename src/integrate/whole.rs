//! What the lobes of a material reflect together, from their tables and formulae: the check that they conserve energy as a
//! whole, at the cost of lookups.

use super::Target;
use super::deterministic::closed_form;
use crate::bxdf::ModelError;
use crate::plan::{MaterialPlan, Source, Term};
use crate::scene::ModelSpec;
use crate::table::Table;
use crate::table::axis::{AZIMUTH, MU};
use glam::DVec3;

/// By how much a material reflects more than it gets.
#[derive(Debug, Clone, PartialEq)]
pub struct WholeExcess {
    /// Beyond 1 and the stated errors of its tables.
    pub excess: f64,
    /// The cosine of the direction.
    pub mu: f64,
    /// The roughness, where it varies.
    pub roughness: Option<f64>,
}

/// Directions that are looked at, both ends included.
const DIRECTIONS: usize = 65;

/// Places along a range of roughness.
const ROUGHNESSES: usize = 9;

/// What sums of a few formulae round off.
const ROUNDING: f64 = 1e-13;

/// The largest excess of `material` over all directions, both sides together; `None` where there is none, and for couplings,
/// which eq. 28 keeps within what their specular lobe leaves; of layers the uppermost is looked at. `table` finds a table by its id.
///
/// # Errors
/// [`ModelError`] for a model that no scene holds, and what `table` fails with.
pub fn whole_excess<E: From<ModelError>>(
    material: &MaterialPlan,
    mut table: impl FnMut(&str) -> Result<Table, E>,
) -> Result<Option<WholeExcess>, E> {
    // what lies below a layer gets what that leaves: counted as 0, which is the least that it reflects
    let terms: Vec<&Term> = material.terms.iter().filter(|term| term.layers.is_empty()).collect();
    let is_told = |term: &Term| matches!(term.albedo, Source::Table { r0: None, .. });
    if terms.iter().any(|term| term.base.is_some()) || (terms.len() == 1 && terms.iter().copied().all(is_told)) {
        return Ok(None);
    }
    let mut lobes = Vec::with_capacity(terms.len());
    for term in terms.iter().copied() {
        lobes.push(match &term.albedo {
            Source::Table { id, .. } => (term, Some(table(id)?)),
            Source::ClosedForm(_) => (term, None),
        });
    }
    let roughnesses: Vec<Option<f64>> = match terms.iter().find_map(|term| term.model.roughness_range()) {
        None => vec![None],
        Some((_, min, max)) => {
            let along = |i: usize| i as f64 / (ROUGHNESSES - 1) as f64;
            (0..ROUGHNESSES)
                .map(|i| Some(min + (max - min) * along(i) * along(i)))
                .collect()
        }
    };
    let mut worst: Option<WholeExcess> = None;
    for roughness in roughnesses {
        for step in 0..DIRECTIONS {
            // crowded towards the horizon, where models gain
            let root = step as f64 / (DIRECTIONS - 1) as f64;
            let mu = root * root;
            let mut sum = DVec3::ZERO;
            for (term, table) in &lobes {
                sum += least(term, table.as_ref(), mu, roughness)?;
            }
            let excess = (sum - DVec3::ONE).max_element() - ROUNDING;
            if excess > worst.as_ref().map_or(0.0, |worst| worst.excess) {
                worst = Some(WholeExcess { excess, mu, roughness });
            }
        }
    }
    Ok(worst)
}

/// The least that a lobe reflects, as far as its table knows.
fn least(term: &Term, table: Option<&Table>, mu: f64, roughness: Option<f64>) -> Result<DVec3, ModelError> {
    let (Some(table), Source::Table { r0, .. }) = (table, &term.albedo) else {
        let model = term.model.at(roughness)?.accounted();
        let estimate = closed_form(&model, Target::rho_hd(mu, 0.0).of(term.lobe));
        return Ok(estimate.map_or(DVec3::ZERO, |estimate| {
            term.scale.value() * (estimate.value - estimate.error)
        }));
    };
    let own = own_roughness(&term.model).or(roughness);
    let place: Vec<f64> = table
        .axes
        .iter()
        .map(|axis| match axis.parameter.as_str() {
            MU => mu,
            AZIMUTH => 0.0,
            _ => own.unwrap_or(axis.min).clamp(axis.min, axis.max),
        })
        .collect();
    let found = table.sample(&place);
    let rho = match r0 {
        Some(r0) => found.x + (found.y - found.x) * r0.value(),
        None => found,
    };
    Ok(term.scale.value() * (rho - table.max_lookup_error()).max(DVec3::ZERO))
}

/// The one roughness of a model, `None` for a range and for models without.
fn own_roughness(model: &ModelSpec) -> Option<f64> {
    model.roughness().and_then(|roughness| {
        let [min, max] = roughness.ends();
        (min == max).then_some(min)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::integrate::fill;
    use crate::plan::{Plan, Request};
    use crate::scene::Scene;

    fn excess(bxdf: &str) -> Option<WholeExcess> {
        let scene = Scene::parse(&format!("[[material]]\nname = \"m\"\nbxdf = {bxdf}\n"), "s.toml").unwrap();
        let request = Request {
            resolution: 64,
            ..Request::default()
        };
        let plan = Plan::new(&scene, &request).unwrap();
        let find = |id: &str| -> Result<Table, ModelError> {
            let plan = plan.tables.iter().find(|table| table.id == id).unwrap();
            Ok(fill(plan, &|_| {}).unwrap())
        };
        whole_excess(&plan.materials[0], find).unwrap()
    }

    const LOBE: &str = "{ type = \"microfacet\", distribution = { type = \"beckmann\", m = 0.3 }, masking = \"v-groove\", fresnel \
                        = { type = \"schlick\", r0 = 0.5 } }";

    #[test]
    fn sums_that_reflect_more_than_they_get_are_found() {
        let sum = |grey: f64| {
            format!("{{ type = \"sum\", bxdfs = [{{ type = \"lambertian\", reflectance = {grey:?} }}, {LOBE}] }}")
        };
        // the lobe reflects half at normal incidence, and all at grazing angles but for its losses
        let worst = excess(&sum(0.6)).unwrap();
        assert!(worst.mu < 0.3 && worst.excess > 0.2, "{worst:?}");
        assert_eq!(excess(&sum(0.01)), None);
    }

    /// The qualitative model of Oren and Nayar gains up to 1.52 %, at the horizon.
    #[test]
    fn formulae_that_gain_energy_are_found() {
        let rough = |sigma: f64| {
            excess(&format!(
                "{{ type = \"oren-nayar\", reflectance = 1.0, sigma_deg = {sigma:?} }}"
            ))
        };
        assert!(rough(10.0).unwrap().mu < 0.1);
        assert_eq!(rough(30.0), None);
        assert_eq!(excess("{ type = \"fresnel-specular\", eta_b = 1.5 }"), None);
    }
}
