//! A sheet computed, fitted, rounded, and measured.

use super::fit::{Fitted, Problem, fit};
use super::grid::{Grid, Places};
use super::mean::means;
use super::measure::Probes;
use super::round::{Code, round};
use super::sheet::{Along, Sheet, Term};
use super::truth::{Quantity, TruthError};
use crate::table::axis::AxisError;
use crate::table::texture::{LookupError, Texture, TextureAxis, TextureError};
use rayon::prelude::*;
use std::collections::BTreeMap;
use thiserror::Error;

/// Places along each axis of two at which lookups are fitted, about: of few texels many a cell, of many a few.
const PLACES: usize = 256;

/// Places along each axis of two at which lookups are measured: not those of the fit.
const PROBES: usize = 337;

/// The same within one cell at most: in a square of cells a thousand and more.
const MOST_PLACES: usize = 32;
const MOST_PROBES: usize = 43;

/// The stretch of values that an end of the domain stands for in a fit: enough to be heard.
const END: f64 = 1e-3;

/// r0 of the dielectric whose albedo is measured beside that of r0 = 1: 0.04, glass and plastic.
pub const DIELECTRIC_R0: f64 = 0.04;

/// Why a sheet has no texture.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum SheetError {
    /// An axis that no texture has.
    #[error("{sheet}: {source}")]
    Axis {
        /// The sheet.
        sheet: &'static str,
        /// Why.
        source: AxisError,
    },
    /// An integral without a value.
    #[error("{sheet}: {source}")]
    Truth {
        /// The sheet.
        sheet: &'static str,
        /// Why.
        source: TruthError,
    },
    /// Texels that a texture cannot hold.
    #[error(transparent)]
    Texture(#[from] TextureError),
    /// A mean of a table that is not there.
    #[error("{sheet}: no table before it has the axes of this one and mu")]
    Mean {
        /// The sheet.
        sheet: &'static str,
    },
}

/// Truths at all places of a grid.
pub(super) type Truths = BTreeMap<Quantity, Vec<f64>>;

/// A finished table.
#[derive(Debug, Clone, PartialEq)]
pub struct Baked {
    /// Texels so that interpolated values come nearest to the truth, with the errors of lookups.
    pub texture: Texture,
    /// The errors that the same texels would leave if each held the truth at its place, as generators of engines compute them. Of tables
    /// with two axes; none otherwise.
    pub sampled: Vec<LookupError>,
}

/// How texel values come to be.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Texels {
    Fitted,
    Sampled,
}

/// The texture of `sheet`. `earlier` are those of the same profile that come before: means are of what lookups in one of them read.
/// `done` hears of every integral that is computed; see [`work`].
///
/// # Errors
/// [`SheetError`]
pub fn bake(sheet: &Sheet, earlier: &[(&Sheet, &Texture)], done: &(dyn Fn(u64) + Sync)) -> Result<Baked, SheetError> {
    let axis = |along: &Along| {
        along.axis().map_err(|source| SheetError::Axis {
            sheet: sheet.name,
            source,
        })
    };
    let axes: Vec<TextureAxis> = sheet.axes.iter().map(axis).collect::<Result<_, _>>()?;
    let texture = |columns: Vec<Vec<f64>>| {
        let count = columns.first().map_or(0, Vec::len);
        let values = (0..count).flat_map(|texel| columns.iter().map(move |column| column[texel]));
        let texture = Texture {
            id: sheet.name.into(),
            values: values.collect(),
            axes: axes.clone(),
            channels: sheet.channels.iter().map(|term| term.channel()).collect(),
            storage: sheet.storage,
            errors: Vec::new(),
            facts: facts(sheet),
        };
        texture.rounded()
    };
    let mut sampled = Vec::new();
    if sheet.is_mean() {
        let texture = texture(means(sheet, &axes, earlier)?)?;
        return Ok(Baked { texture, sampled });
    }
    let mut fitted = texture(columns(sheet, &axes, Texels::Fitted, done)?)?;
    let probes = Probes::new(sheet, &axes, done)?;
    fitted.errors = probes.errors(sheet, &fitted)?;
    if sheet.is_compared() {
        let plain = texture(columns(sheet, &axes, Texels::Sampled, done)?)?;
        sampled = probes.errors(sheet, &plain)?;
    }
    Ok(Baked {
        texture: fitted,
        sampled,
    })
}

/// Number of places at which [`bake`] computes integrals.
pub fn work(sheet: &Sheet) -> u64 {
    if sheet.is_mean() {
        return 0;
    }
    let all = |per_cell: &dyn Fn(usize) -> usize| -> u64 {
        let count = |along: &Along| per_cell(along.size) * (along.size + 3) + 3;
        sheet.axes.iter().map(count).product::<usize>() as u64
    };
    let texels: usize = sheet.axes.iter().map(|along| along.size).product();
    let compared = if sheet.is_compared() { texels as u64 } else { 0 };
    all(&|size| fit_places(sheet, size)) + all(&|size| probes(sheet, size)) + compared
}

/// Parts of a cell whose borders are places of the fit.
fn fit_places(sheet: &Sheet, size: usize) -> usize {
    match sheet.slow_places() {
        Some(places) => places.div_ceil(size).max(2),
        None => PLACES.div_ceil(size).clamp(3, MOST_PLACES),
    }
}

/// Places of a cell at which lookups are measured, in as many parts.
pub(super) fn probes(sheet: &Sheet, size: usize) -> usize {
    match sheet.slow_places() {
        Some(places) => places.div_ceil(size).max(2),
        None => PROBES.div_ceil(size).clamp(3, MOST_PROBES),
    }
}

fn facts(sheet: &Sheet) -> Vec<(String, String)> {
    let (distribution, masking) = sheet.lobes();
    let facts = [
        ("purpose", sheet.purpose.to_owned()),
        ("distribution", distribution),
        ("masking", masking),
        (
            "texels",
            "fitted so that interpolated values come nearest to the truth".to_owned(),
        ),
    ];
    facts.map(|(name, value)| (name.to_owned(), value)).into()
}

/// The quantities of a sheet at every place of `grid`.
pub(super) fn truths(sheet: &Sheet, grid: &Grid, done: &(dyn Fn(u64) + Sync)) -> Result<Truths, SheetError> {
    let quantities = sheet.quantities();
    let at = |index: usize| {
        let values = sheet.lobe.values(&quantities, sheet.place(&grid.values(index)));
        done(1);
        values
    };
    let all: Result<Vec<Vec<f64>>, TruthError> = (0..grid.len()).into_par_iter().map(at).collect();
    let all = all.map_err(|source| SheetError::Truth {
        sheet: sheet.name,
        source,
    })?;
    let column = |(k, quantity): (usize, &Quantity)| (*quantity, all.iter().map(|values| values[k]).collect());
    Ok(quantities.iter().enumerate().map(column).collect())
}

/// What errors of a quantity are divided by in a fit: E and the share of an interface by themselves, B by the albedo of a dielectric, and
/// the rest by 1.
fn unit(quantity: Quantity, truths: &Truths) -> Vec<f64> {
    match quantity {
        Quantity::Total | Quantity::Interface => truths[&quantity].clone(),
        Quantity::Bias => {
            let pairs = truths[&Quantity::Bias].iter().zip(&truths[&Quantity::Total]);
            pairs.map(|(bias, total)| dielectric(*bias, *total)).collect()
        }
        _ => vec![1.0; truths[&quantity].len()],
    }
}

/// r0 A + B.
pub(super) fn dielectric(bias: f64, total: f64) -> f64 {
    DIELECTRIC_R0 * (total - bias) + bias
}

/// Texels per channel of a sheet that is no mean.
fn columns(
    sheet: &Sheet,
    axes: &[TextureAxis],
    texels: Texels,
    done: &(dyn Fn(u64) + Sync),
) -> Result<Vec<Vec<f64>>, SheetError> {
    let domain = sheet.domain();
    let places = |(axis, domain): (&TextureAxis, &[f64; 2])| match texels {
        Texels::Fitted => Places::borders(axis, fit_places(sheet, axis.axis.size)).and_ends(axis, *domain, END),
        Texels::Sampled => Places::texels(axis),
    };
    let grid = Grid::new(axes, axes.iter().zip(&domain).map(places).collect());
    let truths = truths(sheet, &grid, done)?;
    if texels == Texels::Sampled {
        return Ok(sampled(sheet, &truths));
    }
    let units: Truths = truths
        .keys()
        .map(|quantity| (*quantity, unit(*quantity, &truths)))
        .collect();
    let problem = |quantity: Quantity| Problem {
        grid: &grid,
        truth: &truths[&quantity],
        unit: &units[&quantity],
        domain: &domain,
        legal: quantity.legal(),
    };
    let quantities: Vec<Quantity> = truths.keys().copied().collect();
    let fitted: BTreeMap<Quantity, Fitted> = quantities
        .into_par_iter()
        .map(|quantity| (quantity, fit(&problem(quantity))))
        .collect();
    let stored = |quantity: Quantity, constant: &[f64], sign: f64| {
        let code = Code { constant, sign };
        round(&problem(quantity), &fitted[&quantity], &code, sheet.storage)
    };
    let all = |value: f64| vec![value; grid.texels()];
    let bias = match sheet.channels.contains(&Term::Bias) {
        true => stored(Quantity::Bias, &all(0.0), 1.0),
        false => Vec::new(),
    };
    let column = |term: &Term| match (term, term.code()) {
        (Term::Bias, _) => bias.clone(),
        // on top of B as it is stored, so that their sum is what is rounded well
        (Term::Scale, _) => stored(Quantity::Total, &bias, 1.0),
        // decoded = (stored - constant)/sign, and sign is its own inverse
        (_, Some((quantity, constant, sign))) => stored(quantity, &all(-constant * sign), sign),
        (_, None) => all(0.0),
    };
    Ok(sheet.channels.iter().map(column).collect())
}

/// Texels that are the truth at their places.
fn sampled(sheet: &Sheet, truths: &Truths) -> Vec<Vec<f64>> {
    let column = |term: &Term| match (term, term.code()) {
        (Term::Scale, _) => {
            let pairs = truths[&Quantity::Bias].iter().zip(&truths[&Quantity::Total]);
            pairs.map(|(bias, total)| total - bias).collect()
        }
        (_, Some((quantity, constant, sign))) => {
            truths[&quantity].iter().map(|value| constant + sign * value).collect()
        }
        (_, None) => Vec::new(),
    };
    sheet.channels.iter().map(column).collect()
}

/// E as a lookup finds it among `channels`, where they tell.
pub(super) fn total_of(terms: &[Term], channels: &[f64]) -> Option<f64> {
    let of = |wanted: Term| terms.iter().position(|term| *term == wanted).map(|k| channels[k]);
    of(Term::Total)
        .or(of(Term::Loss).map(|loss| 1.0 - loss))
        .or(of(Term::Scale).zip(of(Term::Bias)).map(|(scale, bias)| scale + bias))
}
