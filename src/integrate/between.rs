//! The error of a table as a shader sees it: a linear-filtered lookup against the integral, anywhere in the domain.

use super::fill::{FillError, Progress, integrals, model_at};
use super::{Effort, Estimate, Estimator, IntegrateError};
use crate::numerics::stream::{Stream, StreamId};
use crate::plan::TablePlan;
use crate::table::axis::{Axis, MU};
use crate::table::{Between, Table};
use rayon::prelude::*;
use std::collections::HashSet;

/// Compares a linear-filtered lookup of the stored table with the integral at many places between texels, and climbs from
/// the worst of them to the local maximum.
///
/// The reference is the best estimator at the tolerance of the texels or [`FINEST`], whichever is smaller; its error is added,
/// and the result is widened by [`MARGIN`] or [`MARGIN_OF_SHEETS`].
pub(super) fn between(plan: &TablePlan, table: &Table, progress: Progress<'_>) -> Result<Between, FillError> {
    let axes = &table.axes;
    let is_irregular = model_at(plan, None).is_ok_and(|model| model.is_irregular());
    let effort = reference_effort(plan);
    let lookup_error = |place: &[f64], estimate: &Estimate| {
        let difference = (table.sample(place) - estimate.value).abs() + estimate.error;
        difference.to_array()[..table.channels.count()]
            .iter()
            .fold(0.0, |a: f64, b| a.max(*b))
    };
    let places = places(plan, axes);
    let references = match integrals(plan, axes, &places, Estimator::Auto, effort, progress) {
        Ok((references, _)) => references,
        Err(FillError::Integral {
            source: IntegrateError::Diverges(_),
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
    let probes = places.len() as u64;
    if is_irregular {
        // noise has no maximum to climb to
        let worst = (0..places.len()).max_by(|a, b| errors[*a].total_cmp(&errors[*b]));
        return Ok(Between {
            error: worst.map_or(0.0, |worst| errors[worst] * MARGIN),
            at: worst.map_or_else(Vec::new, |worst| places[worst].clone()),
            probes,
        });
    }
    let starts = starts(axes, &places, &errors);
    let margin = if axes.len() > 1 { MARGIN_OF_SHEETS } else { MARGIN };
    let error_at = |place: &[f64]| -> Result<f64, FillError> {
        let place = place.to_vec();
        let (rho, _) = integrals(
            plan,
            axes,
            std::slice::from_ref(&place),
            Estimator::Auto,
            effort,
            &|_| {},
        )?;
        Ok(lookup_error(&place, &rho[0]))
    };
    let tops: Vec<Between> = starts
        .par_iter()
        .map(|start| climb(axes, &places, (&places[*start], errors[*start]), &error_at))
        .collect::<Result<_, FillError>>()?;
    let climbed: u64 = tops.iter().map(|top| top.probes).sum();
    let top = tops.into_iter().reduce(|a, b| if b.error > a.error { b } else { a });
    Ok(top.map_or_else(
        || Between {
            error: 0.0,
            at: axes.iter().map(|axis| axis.min).collect(),
            probes,
        },
        |top| Between {
            error: top.error * margin,
            probes: probes + climbed,
            ..top
        },
    ))
}

/// To which error the references of `plan` are computed.
pub(super) fn reference_effort(plan: &TablePlan) -> Effort {
    let is_irregular = model_at(plan, None).is_ok_and(|model| model.is_irregular());
    Effort {
        // samples cost the square of what they gain
        tolerance: if is_irregular {
            plan.effort.tolerance
        } else {
            plan.effort.tolerance.min(FINEST)
        },
        samples: None,
        ..plan.effort
    }
}

/// Error of the references of coarse tables, so that they tell the table's error and not their own.
const FINEST: f64 = 1e-6;

/// What a search by places may have missed: with kinks only at texels, the maxima of the cells that were not climbed are
/// known to a few per cent and those that were to the square of their last interval.
const MARGIN: f64 = 1.01;

/// The same of sheets, where a climb goes along one axis after the other.
const MARGIN_OF_SHEETS: f64 = 1.02;

/// From where to climb: the place that looks worst need not lie under the highest of the maxima, so that there is one start in
/// each of the cells that look nearly as bad.
fn starts(axes: &[Axis], places: &[Vec<f64>], errors: &[f64]) -> Vec<usize> {
    let mut order: Vec<usize> = (0..places.len()).collect();
    order.sort_by(|a, b| errors[*b].total_cmp(&errors[*a]));
    let (most, nearly) = CLIMBS[axes.len().clamp(1, 2) - 1];
    let mut cells: HashSet<Vec<usize>> = HashSet::new();
    let mut starts = Vec::new();
    for index in order {
        if starts.len() == most || errors[index] < nearly * starts.first().map_or(0.0, |first| errors[*first]) {
            break;
        }
        if cells.insert(cell(axes, &places[index])) {
            starts.push(index);
        }
    }
    starts
}

/// Between which texels a place lies, along each axis. Beyond the outermost texels, where lookups stay as they are, are cells too.
fn cell(axes: &[Axis], place: &[f64]) -> Vec<usize> {
    let index = |(axis, value): (&Axis, &f64)| (0..axis.size).filter(|i| axis.texel(*i) <= *value).count();
    axes.iter().zip(place).map(index).collect()
}

/// Climbs from one of the `places` to a maximum of the error, along one axis after the other, by golden sections.
fn climb(
    axes: &[Axis],
    places: &[Vec<f64>],
    (start, error): (&[f64], f64),
    error_at: &(dyn Fn(&[f64]) -> Result<f64, FillError> + Sync),
) -> Result<Between, FillError> {
    let mut best = Between {
        error,
        at: start.to_vec(),
        probes: 0,
    };
    // a second round where the position along one axis moves the maximum along the other
    for axis in (0..axes.len()).cycle().take(axes.len() * axes.len()) {
        let (mut low, mut high) = bracket(&axes[axis], places, axis, best.at[axis]);
        let mut try_at = |value: f64| -> Result<f64, FillError> {
            let mut place = best.at.clone();
            place[axis] = value;
            let error = error_at(&place)?;
            best.probes += 1;
            if error > best.error {
                (best.error, best.at) = (error, place);
            }
            Ok(error)
        };
        let mut inner = [high - GOLDEN * (high - low), low + GOLDEN * (high - low)];
        let mut found = [try_at(inner[0])?, try_at(inner[1])?];
        for _ in 0..CLIMB {
            if found[0] > found[1] {
                high = inner[1];
                inner = [high - GOLDEN * (high - low), inner[0]];
                found = [try_at(inner[0])?, found[0]];
            } else {
                low = inner[0];
                inner = [inner[1], low + GOLDEN * (high - low)];
                found = [found[1], try_at(inner[1])?];
            }
        }
    }
    Ok(best)
}

/// The nearest places or texels on both sides of `value`: the error has kinks at the texels, and one maximum between places.
fn bracket(axis: &Axis, places: &[Vec<f64>], index: usize, value: f64) -> (f64, f64) {
    let texels = (0..axis.size).map(|i| axis.texel(i));
    let others = places.iter().map(|place| place[index]).chain(texels);
    let (mut low, mut high) = (axis.min, axis.max);
    for other in others {
        if other < value {
            low = low.max(other);
        } else if other > value {
            high = high.min(other);
        }
    }
    (low, high)
}

/// Most cells that are searched for the maximum of the error, and how close to the worst they have to look, along a line and on a
/// sheet. Where rho is smooth the places of a cell miss the top of its parabola by a ninth at most. On a sheet of narrow lobes it bends
/// within cells, at mu near alpha, and a place there may see half of what another of its cell does.
const CLIMBS: [(usize, f64); 2] = [(8, 0.8), (32, 0.5)];

/// Steps of the climb; each keeps 0.618 of the interval, and at a maximum the square of what is left counts.
const CLIMB: usize = 8;
const GOLDEN: f64 = 0.618_033_988_749_894_8;

/// Places at which a lookup is compared, runs of equal roughness together.
///
/// Irregular samples are known to some per mille only, reach no thinner than their kernels, and cost a second a place.
pub(super) fn places(plan: &TablePlan, axes: &[Axis]) -> Vec<Vec<f64>> {
    let is_irregular = model_at(plan, None).is_ok_and(|model| model.is_irregular());
    match axes {
        [only] if is_irregular => parts(only, PLACES_ON_SHEET)
            .into_iter()
            .map(|value| vec![value])
            .collect(),
        [] => Vec::new(),
        [only] => line(only, PLACES_ON_LINE)
            .into_iter()
            .map(|value| vec![value])
            .collect(),
        [mu, rest, ..] => {
            let columns = line(mu, PLACES_ON_SHEET);
            let rows = line(rest, ROWS_ON_SHEET);
            rows.iter()
                .flat_map(|row| columns.iter().map(move |column| vec![*column, *row]))
                .collect()
        }
    }
}

/// Places between two neighbouring texels, where there is one axis and where there are two.
const PLACES_ON_LINE: usize = 6;
const PLACES_ON_SHEET: usize = 2;
const ROWS_ON_SHEET: usize = 2;

/// [`parts`], and towards mu = 0 places at all scales, for boundary layers are as thin as lobes are narrow.
fn line(axis: &Axis, count: usize) -> Vec<f64> {
    let mut values = parts(axis, count);
    if axis.parameter == MU {
        // with texels at the ends the first one is mu = 0 itself
        let first = axis.texel(0).max(axis.texel(1));
        values.extend((0..LAYERS).map(|i| first * libm::exp10(-7.0 * f64::from(i) / f64::from(LAYERS))));
    }
    values.sort_by(f64::total_cmp);
    values
}

/// `count` places, one in each of `count` equal parts, between neighbouring texels, also beyond the outermost ones, and both ends.
fn parts(axis: &Axis, count: usize) -> Vec<f64> {
    let mut jitter = Stream::new(StreamId {
        seed: 0,
        cell: axis.size as u64,
        batch: count as u64,
    });
    let texels = (0..axis.size).map(|i| axis.u(axis.texel(i)));
    let borders: Vec<f64> = [0.0].into_iter().chain(texels).chain([1.0]).collect();
    let mut values = vec![axis.min, axis.max];
    for cell in borders.windows(2).filter(|cell| cell[1] > cell[0]) {
        let place = |i: usize| {
            // off the middle of a part, where a wave of the rate of the texels would hide
            let within = (i as f64 + 0.5 + JITTER * (jitter.uniform() - 0.5)) / count as f64;
            axis.value(cell[0] + within * (cell[1] - cell[0]))
        };
        values.extend((0..count).map(place));
    }
    values
}

/// Share of its part within which a place lies.
const JITTER: f64 = 0.4;

/// Places between mu = 0 and the first texel, over seven decades.
const LAYERS: i32 = 42;
