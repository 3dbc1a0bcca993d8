//! What the shape of a table costs: the error that a shader sees against texels, mapping of mu, storage and bytes.

use super::clock::{Seconds, timed};
use super::settings::{Budget, Settings};
use super::subject::plan_of;
use super::{CostError, workers};
use crate::integrate::texels;
use crate::integrate::seen::Reference;
use crate::plan::TablePlan;
use crate::scene::Material;
use crate::table::Storage;
use crate::table::axis::Axis;

/// One table in one storage, as a shader sees it.
#[derive(Debug, Clone, PartialEq)]
pub struct Shape {
    /// Its axes.
    pub axes: Vec<Axis>,
    /// How a texture keeps its texels.
    pub storage: Storage,
    /// Bytes of the texture, all channels.
    pub bytes: usize,
    /// Largest error of a linear-filtered lookup at random places, what the reference does not know included.
    pub max_error: f64,
    /// Root of the mean square there.
    pub rms_error: f64,
    /// Largest error at places of stress too: at all scales towards mu = 0, and at the ends of axes.
    pub anywhere: f64,
    /// What computing the texels took.
    pub seconds: Seconds,
    /// Evaluations of the integrand.
    pub evaluations: u64,
}

/// The cheapest table for an error on the screen.
#[derive(Debug, Clone, PartialEq)]
pub struct Answer {
    /// The largest error that a lookup may have.
    pub error: f64,
    /// The table, computed for that error alone, and judged at places of its own; nothing if none of the study is enough.
    pub table: Option<Shape>,
}

/// The tables of one material.
#[derive(Debug, Clone, PartialEq)]
pub struct Shapes {
    /// The material.
    pub material: String,
    /// Why there are none.
    pub skipped: Option<String>,
    /// Every combination that was studied.
    pub shapes: Vec<Shape>,
    /// For errors from the largest.
    pub answers: Vec<Answer>,
    /// Tables that there was no time for.
    pub left_out: usize,
}

/// Error of the texels of studied tables, and of the reference: both well below what shapes cost.
const TEXELS: f64 = 1e-7;
const REFERENCE: f64 = 1e-8;

/// Errors on the screen that answers are for: one step of 8 bits is 4e-3, one of 10 bits 1e-3.
const TARGETS: [f64; 3] = [1e-2, 1e-3, 1e-4];

/// Share of the error on the screen that texels of an answer may have.
const TEXEL_SHARE: f64 = 0.05;

/// Texels of the largest table with two axes, over those of the largest with one.
const CROSSED: usize = 16;

/// Studies the tables of `materials`.
///
/// # Errors
/// [`CostError`] for a material that no table can be planned for.
pub(super) fn shapes(
    materials: &[&Material],
    settings: &Settings,
    budget: &Budget,
    progress: &(dyn Fn(u64) + Sync),
) -> Result<Vec<Shapes>, CostError> {
    let results = workers::run(settings.threads, materials, |material| {
        let found = of_material(material, settings, budget);
        progress(1);
        found
    })?;
    results.into_iter().collect()
}

fn of_material(material: &Material, settings: &Settings, budget: &Budget) -> Result<Shapes, CostError> {
    let mut found = Shapes {
        material: material.name.clone(),
        skipped: None,
        shapes: Vec::new(),
        answers: Vec::new(),
        left_out: 0,
    };
    if material.model.at(None)?.is_irregular() {
        found.skipped = Some("the noise of samples hides what the shape of a table costs".into());
        return Ok(found);
    }
    let plan = with_tolerance(plan_of(material, 2, 2)?, TEXELS);
    let judge = match Reference::new(&plan, REFERENCE, settings.seed, settings.places) {
        Ok(judge) => judge,
        Err(error) => {
            found.skipped = Some(error.to_string());
            return Ok(found);
        }
    };
    for axes in ladder(&plan, settings)? {
        if !budget.allows(0.0) {
            found.left_out += 1;
            continue;
        }
        let (table, seconds) = timed(|| texels(&plan, &axes, &|_| {}));
        // axes that reach a place where the integral diverges are no choice
        let Ok(table) = table else { continue };
        for storage in Storage::ALL {
            if !table.fits(storage) {
                continue;
            }
            let seen = judge.seen(&table, storage);
            found.shapes.push(Shape {
                axes: axes.clone(),
                storage,
                bytes: table.texture_bytes(storage),
                max_error: seen.max,
                rms_error: seen.rms,
                anywhere: seen.anywhere,
                seconds,
                evaluations: table.evaluations,
            });
        }
    }
    found.answers = answers(&plan, &found.shapes, settings);
    Ok(found)
}

fn with_tolerance(mut plan: TablePlan, tolerance: f64) -> TablePlan {
    plan.effort.tolerance = tolerance;
    plan
}

/// The axes of all tables, the smallest first: each size with each mapping of mu.
fn ladder(plan: &TablePlan, settings: &Settings) -> Result<Vec<Vec<Axis>>, CostError> {
    let mut all = Vec::new();
    let largest = settings.sizes.iter().copied().max().unwrap_or(0);
    for &size in &settings.sizes {
        for axes in &plan.alternatives {
            let crossed = axes.len() > 1;
            // the second axis half as fine as the first
            let second = size.div_ceil(2).max(2);
            if crossed && size * second > CROSSED * largest {
                continue;
            }
            let sized = axes.iter().enumerate().map(|(k, axis)| Axis {
                size: if k == 0 { size } else { second },
                ..axis.clone()
            });
            all.push(sized.collect());
        }
    }
    Ok(all)
}

/// For each target the smallest table whose lookups met it everywhere, computed to no more than it needs and judged again, at
/// other places; the next larger one when that finds fault.
fn answers(plan: &TablePlan, shapes: &[Shape], settings: &Settings) -> Vec<Answer> {
    let mut by_size: Vec<&Shape> = shapes.iter().collect();
    // the simplest mapping first among equals, which is the order of the alternatives; the sort is stable
    by_size.sort_by_key(|shape| shape.bytes);
    let other = settings.seed.wrapping_add(1);
    let Ok(judge) = Reference::new(plan, REFERENCE, other, settings.places) else {
        return Vec::new();
    };
    let answer = |target: f64| {
        let cheap = with_tolerance(plan.clone(), TEXEL_SHARE * target);
        let mut candidates = by_size.iter().filter(|shape| shape.anywhere <= target);
        let table = candidates.find_map(|shape| {
            let (table, seconds) = timed(|| texels(&cheap, &shape.axes, &|_| {}));
            let table = table.ok().filter(|table| table.fits(shape.storage))?;
            let seen = judge.seen(&table, shape.storage);
            (seen.anywhere <= target).then(|| Shape {
                max_error: seen.max,
                rms_error: seen.rms,
                anywhere: seen.anywhere,
                seconds,
                evaluations: table.evaluations,
                ..(*shape).clone()
            })
        });
        Answer { error: target, table }
    };
    TARGETS.map(answer).to_vec()
}

impl Shape {
    /// `64 x 16`, or `64`.
    pub fn size(&self) -> String {
        let sizes: Vec<String> = self.axes.iter().map(|axis| axis.size.to_string()).collect();
        sizes.join(" x ")
    }

    /// Mapping and texel rule of mu.
    pub fn mapping(&self) -> String {
        self.axes.first().map_or_else(|| "-".into(), Axis::label)
    }

    /// Number of texels.
    pub fn texels(&self) -> usize {
        self.axes.iter().map(|axis| axis.size).product()
    }
}
