//! Tables from plans: every texel integrated, and of several axes the one kept whose lookup errs least.

use super::between::{between, places};
use super::coordinates::Coordinates;
use super::request::subject;
use super::{Effort, Estimate, Estimator, IntegrateError, Integrator};
use crate::bxdf::{Model, ModelError};
use crate::plan::TablePlan;
use crate::table::axis::{Axis, texel_places};
use crate::table::{ErrorKind, Table, TableError};
use rayon::prelude::*;
use thiserror::Error;

/// Why a table could not be computed.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum FillError {
    /// An integral failed; says which.
    #[error("table {id}, at {at}: {source}")]
    Integral {
        /// The table.
        id: String,
        /// Axis values of the texel.
        at: String,
        /// What failed.
        source: IntegrateError,
    },
    /// A roughness of the axis makes no model.
    #[error("table {id}: {source}")]
    Model {
        /// The table.
        id: String,
        /// What was refused.
        source: ModelError,
    },
    /// The result cannot be stored.
    #[error(transparent)]
    Table(#[from] TableError),
}

/// Reports that some integrals are done; called from any thread.
pub type Progress<'a> = &'a (dyn Fn(u64) + Sync);

/// Number of integrals that [`fill`] may compute for `plan`, what its progress counts up to.
pub fn work(plan: &TablePlan) -> u64 {
    plan.alternatives
        .iter()
        .map(|axes| plan.texels() as u64 + places(plan, axes).len() as u64)
        .sum()
}

/// Computes the table that `plan` asks for.
///
/// Of several alternative axes the first is kept when its lookup meets the tolerance anywhere, and otherwise the one
/// whose lookup errs least.
///
/// # Errors
/// [`FillError`] with the texel that failed.
pub fn fill(plan: &TablePlan, progress: Progress<'_>) -> Result<Table, FillError> {
    let mut best: Option<Table> = None;
    for axes in &plan.alternatives {
        let table = match fill_axes(plan, axes, progress) {
            // axes that reach a place where the integral diverges are no choice; those that stay clear of it may be
            Err(FillError::Integral {
                source: IntegrateError::Diverges(_),
                ..
            }) if best.is_some() => continue,
            table => table?,
        };
        let error = |table: &Table| table.between.as_ref().map_or(0.0, |between| between.error);
        let met = error(&table) <= plan.effort.tolerance;
        if best.as_ref().is_none_or(|best| error(&table) < error(best)) {
            best = Some(table);
        }
        if met {
            break;
        }
    }
    let empty = || TableError::Shape {
        id: plan.id.clone(),
        reason: "no axes were planned".into(),
    };
    Ok(best.ok_or_else(empty)?.checked()?)
}

/// The texels over `axes`, and the error between them.
pub(super) fn fill_axes(plan: &TablePlan, axes: &[Axis], progress: Progress<'_>) -> Result<Table, FillError> {
    let mut table = texels(plan, axes, progress)?;
    if !axes.is_empty() {
        table.between = Some(between(plan, &table, progress)?);
    }
    Ok(table)
}

/// Computes the texels of the table that `plan` asks for over `axes`, whatever axes the plan itself has in mind, and leaves
/// the error between them open: a fraction of the work of [`fill`].
///
/// The axes have the parameters of the plan's, in the same order; mapping, rule and size are free.
///
/// # Errors
/// [`FillError`] with the texel that failed.
pub fn texels(plan: &TablePlan, axes: &[Axis], progress: Progress<'_>) -> Result<Table, FillError> {
    let places = texel_places(axes);
    let (estimates, shared) = integrals(plan, axes, &places, plan.estimator, plan.effort, progress)?;
    let estimator = estimates.first().map_or(plan.estimator, |estimate| estimate.estimator);
    let table = Table {
        id: plan.id.clone(),
        quantity: plan.quantity,
        lobe: plan.lobe,
        axes: axes.to_vec(),
        channels: plan.channels,
        values: estimates.iter().map(|estimate| estimate.value).collect(),
        errors: estimates.iter().map(|estimate| estimate.error).collect(),
        error_kind: estimates
            .iter()
            .map(|estimate| estimate.kind)
            .max()
            .unwrap_or(ErrorKind::Exact),
        parameters: plan.model.describe(),
        estimator: estimator.name().into(),
        tolerance: plan.effort.tolerance,
        evaluations: shared + estimates.iter().map(|estimate| estimate.evaluations).sum::<u64>(),
        seed: plan.effort.seed,
        goal: None,
        between: None,
    };
    Ok(table.checked()?)
}

/// The integral at each place of `at`, and the evaluations that places of one roughness shared.
pub(super) fn integrals(
    plan: &TablePlan,
    axes: &[Axis],
    at: &[Vec<f64>],
    estimator: Estimator,
    effort: Effort,
    progress: Progress<'_>,
) -> Result<(Vec<Estimate>, u64), FillError> {
    let first_cell = stable_hash(&subject(plan));
    let failed = |place: &[f64]| {
        let at = describe(axes, place);
        move |source| FillError::Integral {
            id: plan.id.clone(),
            at,
            source,
        }
    };
    let along = Coordinates::new(axes);
    // places come in runs of equal roughness: one model, prepared once, for each run
    let runs: Vec<&[Vec<f64>]> = at.chunk_by(|a, b| along.roughness(a) == along.roughness(b)).collect();
    let starts: Vec<u64> = runs
        .iter()
        .scan(0, |next, run| {
            let start = *next;
            *next += run.len() as u64;
            Some(start)
        })
        .collect();
    let results: Vec<(Vec<Estimate>, u64)> = runs
        .par_iter()
        .zip(&starts)
        .map(|(run, start)| {
            let model = model_at(plan, along.roughness(&run[0]))?;
            let integrator = Integrator::new(&model, estimator, effort).map_err(failed(&run[0]))?;
            let estimates: Result<Vec<Estimate>, FillError> = run
                .par_iter()
                .enumerate()
                .map(|(i, place)| {
                    let target = along.target(plan.quantity, place).of(plan.lobe);
                    let cell = first_cell.wrapping_add(start + i as u64);
                    let estimate = integrator.estimate(target, cell).map_err(failed(place));
                    progress(1);
                    estimate
                })
                .collect();
            Ok((estimates?, integrator.shared_evaluations()))
        })
        .collect::<Result<_, FillError>>()?;
    let shared = results.iter().map(|(_, shared)| shared).sum();
    Ok((
        results.into_iter().flat_map(|(estimates, _)| estimates).collect(),
        shared,
    ))
}

pub(super) fn model_at(plan: &TablePlan, roughness: Option<f64>) -> Result<Model, FillError> {
    plan.model.at(roughness).map_err(|source| FillError::Model {
        id: plan.id.clone(),
        source,
    })
}

fn describe(axes: &[Axis], place: &[f64]) -> String {
    if axes.is_empty() {
        return "its only texel".into();
    }
    let values: Vec<String> = axes
        .iter()
        .zip(place)
        .map(|(axis, value)| format!("{} = {value}", axis.parameter))
        .collect();
    values.join(", ")
}

/// A number that names the streams of a table by what is integrated: FNV-1a, the same in every version.
pub(super) fn stable_hash(text: &str) -> u64 {
    text.bytes().fold(0xcbf2_9ce4_8422_2325, |hash, byte| {
        (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3)
    })
}
