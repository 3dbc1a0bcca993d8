//! What the shape of a table costs: the error that a shader sees against texels, mapping of mu, storage and bytes.

use super::clock::{Seconds, timed};
use super::settings::{Budget, Settings};
use super::subject::plan_of;
use super::{CostError, workers};
use crate::integrate::seen::Reference;
use crate::integrate::texels;
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

/// Error of the reference over that of the texels.
const REFERENCE_SHARE: f64 = 0.1;

/// Errors on the screen that answers are for: one step of 8 bits is 4e-3, one of 10 bits 1e-3.
const TARGETS: [f64; 3] = [1e-2, 1e-3, 1e-4];

/// Share of the error on the screen that texels of an answer may have.
const TEXEL_SHARE: f64 = 0.05;

/// A material on which tables are judged.
struct Ground {
    found: Shapes,
    /// Nothing where there are no tables.
    judged: Option<(TablePlan, Reference)>,
}

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
    let grounds = workers::run(settings.threads, materials, |material| ground(material, settings))?;
    let mut grounds: Vec<Ground> = grounds.into_iter().collect::<Result<_, _>>()?;
    let mut jobs: Vec<(usize, Vec<Axis>)> = Vec::new();
    for (index, ground) in grounds.iter().enumerate() {
        if let Some((plan, _)) = &ground.judged {
            jobs.extend(ladder(plan, settings).into_iter().map(|axes| (index, axes)));
        }
    }
    // the small tables of all materials first: when time is up, all have come equally far
    jobs.sort_by_key(|(_, axes)| axes.iter().map(|axis| axis.size).product::<usize>());
    let results = workers::run(settings.threads, &jobs, |(index, axes)| {
        let (plan, judge) = grounds[*index].judged.as_ref()?;
        budget.allows(0.0).then(|| of_axes(plan, judge, axes))
    })?;
    for ((index, _), result) in jobs.iter().zip(results) {
        let found = &mut grounds[*index].found;
        match result {
            Some(shapes) => found.shapes.extend(shapes),
            None => found.left_out += 1,
        }
    }
    let answered = workers::run(settings.threads, &grounds, |ground| {
        let answers = ground
            .judged
            .as_ref()
            .map_or_else(Vec::new, |(plan, _)| answers(plan, &ground.found.shapes, settings));
        progress(1);
        answers
    })?;
    let found = grounds.into_iter().zip(answered);
    Ok(found
        .map(|(ground, answers)| Shapes {
            answers,
            ..ground.found
        })
        .collect())
}

fn ground(material: &Material, settings: &Settings) -> Result<Ground, CostError> {
    let mut found = Shapes {
        material: material.name.clone(),
        skipped: None,
        shapes: Vec::new(),
        answers: Vec::new(),
        left_out: 0,
    };
    let judged = if material.model.at(None)?.is_irregular() {
        found.skipped = Some("the noise of samples hides what the shape of a table costs".into());
        None
    } else {
        let plan = with_tolerance(plan_of(material, 2, 2)?, settings.texel_tolerance);
        match Reference::new(
            &plan,
            REFERENCE_SHARE * settings.texel_tolerance,
            settings.seed,
            settings.places,
        ) {
            Ok(judge) => Some((plan, judge)),
            Err(error) => {
                found.skipped = Some(error.to_string());
                None
            }
        }
    };
    Ok(Ground { found, judged })
}

/// The table over `axes` in every storage that holds its values.
fn of_axes(plan: &TablePlan, judge: &Reference, axes: &[Axis]) -> Vec<Shape> {
    let (table, seconds) = timed(|| texels(plan, axes, &|_| {}));
    // axes that reach a place where the integral diverges are no choice
    let Ok(table) = table else { return Vec::new() };
    let storages = Storage::ALL.into_iter().filter(|storage| table.fits(*storage));
    let shape = |storage| {
        let seen = judge.seen(&table, storage);
        Shape {
            axes: axes.to_vec(),
            storage,
            bytes: table.texture_bytes(storage),
            max_error: seen.max,
            rms_error: seen.rms,
            anywhere: seen.anywhere,
            seconds,
            evaluations: table.evaluations,
        }
    };
    storages.map(shape).collect()
}

fn with_tolerance(mut plan: TablePlan, tolerance: f64) -> TablePlan {
    plan.effort.tolerance = tolerance;
    plan
}

/// The axes of all tables, the smallest first: each size with each mapping of mu.
fn ladder(plan: &TablePlan, settings: &Settings) -> Vec<Vec<Axis>> {
    let mut all = Vec::new();
    for &size in &settings.sizes {
        for axes in &plan.alternatives {
            let crossed = axes.len() > 1;
            // the second axis half as fine as the first
            let second = size.div_ceil(2).max(2);
            if crossed && size * second > settings.crossed {
                continue;
            }
            let sized = axes.iter().enumerate().map(|(k, axis)| Axis {
                size: if k == 0 { size } else { second },
                ..axis.clone()
            });
            all.push(sized.collect());
        }
    }
    all
}

/// For each target the smallest table whose lookups met it everywhere, computed to no more than it needs and judged again, at
/// other places; the next larger one when that finds fault.
fn answers(plan: &TablePlan, shapes: &[Shape], settings: &Settings) -> Vec<Answer> {
    let mut by_size: Vec<&Shape> = shapes.iter().collect();
    // the simplest mapping first among equals, which is the order of the alternatives; the sort is stable
    by_size.sort_by_key(|shape| shape.bytes);
    let other = settings.seed.wrapping_add(1);
    let Ok(judge) = Reference::new(plan, REFERENCE_SHARE * settings.texel_tolerance, other, settings.places) else {
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
