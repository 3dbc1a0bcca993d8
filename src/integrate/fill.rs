//! Tables from plans: every texel integrated, then the lookup between texels compared with the integral itself.

use super::{Effort, Estimate, Estimator, IntegrateError, Integrator, Target};
use crate::bxdf::Model;
use crate::numerics::stream::{Stream, StreamId};
use crate::parameter::ParameterError;
use crate::plan::TablePlan;
use crate::table::axis::Axis;
use crate::table::{Between, ErrorKind, Quantity, Table, TableError};
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
    /// A roughness of the axis is no legal parameter.
    #[error("table {id}: {source}")]
    Parameter {
        /// The table.
        id: String,
        /// The refused value.
        source: ParameterError,
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
        .map(|axes| plan.texels() as u64 + places(axes).len() as u64)
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
                source: IntegrateError::Diverges,
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

fn fill_axes(plan: &TablePlan, axes: &[Axis], progress: Progress<'_>) -> Result<Table, FillError> {
    let texels: Vec<Vec<f64>> = texels(axes);
    let (estimates, shared) = integrals(plan, axes, &texels, plan.estimator, plan.effort, progress)?;
    let estimator = estimates.first().map_or(plan.estimator, |estimate| estimate.estimator);
    let mut table = Table {
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
        materials: plan.materials.clone(),
        parameters: plan.model.describe(),
        estimator: estimator.name().into(),
        tolerance: plan.effort.tolerance,
        evaluations: shared + estimates.iter().map(|estimate| estimate.evaluations).sum::<u64>(),
        seed: plan.effort.seed,
        between: None,
    };
    if !axes.is_empty() {
        table.between = Some(between(plan, &table, progress)?);
    }
    Ok(table)
}

/// Axis values of every texel, in the order of the table.
fn texels(axes: &[Axis]) -> Vec<Vec<f64>> {
    let mut texels = vec![Vec::new()];
    for axis in axes.iter().rev() {
        texels = texels
            .into_iter()
            .flat_map(|rest: Vec<f64>| (0..axis.size).map(move |i| [vec![axis.texel(i)], rest.clone()].concat()))
            .collect();
    }
    texels
}

/// The integral at each place of `at`, and the evaluations that places of one roughness shared.
fn integrals(
    plan: &TablePlan,
    axes: &[Axis],
    at: &[Vec<f64>],
    estimator: Estimator,
    effort: Effort,
    progress: Progress<'_>,
) -> Result<(Vec<Estimate>, u64), FillError> {
    let first_cell = stable_hash(&plan.id);
    let failed = |place: &[f64]| {
        let at = describe(axes, place);
        move |source| FillError::Integral {
            id: plan.id.clone(),
            at,
            source,
        }
    };
    // places come in runs of equal roughness: one model, prepared once, for each run
    let roughness_index = usize::from(plan.quantity == Quantity::RhoHd);
    let runs: Vec<&[Vec<f64>]> = at
        .chunk_by(|a, b| a.get(roughness_index) == b.get(roughness_index))
        .collect();
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
            let model = model_at(plan, run[0].get(roughness_index).copied())?;
            let integrator = Integrator::new(&model, estimator, effort).map_err(failed(&run[0]))?;
            let estimates: Result<Vec<Estimate>, FillError> = run
                .par_iter()
                .enumerate()
                .map(|(i, place)| {
                    let target = match plan.quantity {
                        Quantity::RhoHd => Target::RhoHd { mu: place[0], phi: 0.0 },
                        Quantity::RhoHh => Target::RhoHh,
                    };
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

fn model_at(plan: &TablePlan, roughness: Option<f64>) -> Result<Model, FillError> {
    plan.model.at(roughness).map_err(|source| FillError::Parameter {
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

/// A number that names the streams of a table: FNV-1a of its id, the same in every version.
fn stable_hash(text: &str) -> u64 {
    text.bytes().fold(0xcbf2_9ce4_8422_2325, |hash, byte| {
        (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3)
    })
}

/// Compares a linear-filtered lookup of the stored table with the integral at many places between texels, and climbs from
/// the worst of them to the local maximum.
///
/// The reference is the best estimator at the tolerance of the texels or 1e-6, whichever is smaller; its own error is added.
fn between(plan: &TablePlan, table: &Table, progress: Progress<'_>) -> Result<Between, FillError> {
    let axes = &table.axes;
    let effort = Effort {
        tolerance: plan.effort.tolerance.min(1e-6),
        samples: None,
        ..plan.effort
    };
    let lookup_error = |place: &[f64], estimate: &Estimate| {
        let difference = (table.sample(place) - estimate.value).abs() + estimate.error;
        difference.to_array()[..table.channels.count()]
            .iter()
            .fold(0.0, |a: f64, b| a.max(*b))
    };
    let places = places(axes);
    let references = match integrals(plan, axes, &places, Estimator::Auto, effort, progress) {
        Ok((references, _)) => references,
        Err(FillError::Integral {
            source: IntegrateError::Diverges,
            ..
        }) => {
            let at = axes.iter().map(|axis| axis.min).collect();
            return Ok(Between {
                error: f64::INFINITY,
                at,
                probes: places.len() as u64,
            });
        }
        Err(error) => return Err(error),
    };
    let errors: Vec<f64> = places
        .iter()
        .zip(&references)
        .map(|(place, rho)| lookup_error(place, rho))
        .collect();
    let worst = errors
        .iter()
        .enumerate()
        .max_by(|a, b| a.1.total_cmp(b.1))
        .map_or(0, |(index, _)| index);
    let mut at = places[worst].clone();
    let mut error = errors[worst];
    let mut probes = places.len() as u64;
    for axis in 0..axes.len() {
        // the neighbouring places along this axis enclose the maximum
        let mut values: Vec<f64> = places.iter().map(|place| place[axis]).collect();
        values.sort_by(f64::total_cmp);
        values.dedup();
        let here = values.partition_point(|value| *value < at[axis]);
        let (mut low, mut high) = (values[here.saturating_sub(1)], values[(here + 1).min(values.len() - 1)]);
        for _ in 0..CLIMB {
            let thirds = [low + (high - low) / 3.0, high - (high - low) / 3.0];
            let tried: Vec<Vec<f64>> = thirds
                .iter()
                .map(|value| {
                    let mut place = at.clone();
                    place[axis] = *value;
                    place
                })
                .collect();
            let mut found = [0.0; 2];
            for (place, found) in tried.iter().zip(&mut found) {
                let (rho, _) = integrals(
                    plan,
                    axes,
                    std::slice::from_ref(place),
                    Estimator::Auto,
                    effort,
                    &|_| {},
                )?;
                *found = lookup_error(place, &rho[0]);
                probes += 1;
                if *found > error {
                    (error, at) = (*found, place.clone());
                }
            }
            if found[0] > found[1] {
                high = thirds[1]
            } else {
                low = thirds[0]
            }
        }
    }
    Ok(Between { error, at, probes })
}

/// Steps of the climb to a local maximum; each keeps two thirds of the interval.
const CLIMB: usize = 12;

/// Places at which a lookup is compared, runs of equal roughness together.
fn places(axes: &[Axis]) -> Vec<Vec<f64>> {
    match axes {
        [] => Vec::new(),
        [only] => line(only, PLACES_ON_LINE)
            .into_iter()
            .map(|value| vec![value])
            .collect(),
        [mu, rest, ..] => {
            let columns = line(mu, PLACES_ON_SHEET);
            let rows = line(rest, 1);
            rows.iter()
                .flat_map(|row| columns.iter().map(move |column| vec![*column, *row]))
                .collect()
        }
    }
}

/// Places between two neighbouring texels, where there is one axis and where there are two.
const PLACES_ON_LINE: usize = 6;
const PLACES_ON_SHEET: usize = 2;

/// `count` places, one in each of `count` equal parts, between neighbouring texels; both ends; and towards mu = 0 places at
/// all scales, for boundary layers are as thin as lobes are narrow.
fn line(axis: &Axis, count: usize) -> Vec<f64> {
    let mut jitter = Stream::new(StreamId {
        seed: 0,
        cell: axis.size as u64,
        batch: count as u64,
    });
    let parts = (axis.size + 1) * count;
    let mut values: Vec<f64> = (0..parts)
        .map(|i| axis.value((i as f64 + jitter.uniform()) / parts as f64))
        .collect();
    values.extend([axis.min, axis.max]);
    if axis.parameter == "mu" {
        let first = axis.texel(0);
        values.extend((0..LAYERS).map(|i| first * 10f64.powf(-7.0 * f64::from(i) / f64::from(LAYERS))));
    }
    values.sort_by(f64::total_cmp);
    values
}

/// Places between mu = 0 and the first texel, over seven decades.
const LAYERS: i32 = 42;
