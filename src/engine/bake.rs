//! A sheet computed, fitted, rounded, and measured.

use super::fit::{Problem, Score, fit};
use super::grid::{Grid, Places};
use super::mean::means;
use super::measure::measured;
use super::round::{Code, round};
use super::sheet::{Along, Parameter, Sheet, Term};
use super::truth::{Quantity, TruthError};
use crate::table::axis::AxisError;
use crate::table::texture::{Channel, Texture, TextureAxis, TextureError};
use rayon::prelude::*;
use std::collections::BTreeMap;
use thiserror::Error;

/// Places along each axis at which lookups are fitted, about: of few texels many a cell, of many a few.
const PLACES: usize = 256;

/// The stretch of values that an end of the domain stands for in a fit: enough to be heard.
const END: f64 = 1e-3;

/// Places along each axis at which lookups are measured: not those of the fit.
const PROBES: usize = 337;

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
    #[error("{sheet}: {reason}")]
    Mean {
        /// The sheet.
        sheet: &'static str,
        /// What is missing.
        reason: &'static str,
    },
}

/// Truths at all places of a grid.
pub(super) type Truths = BTreeMap<Quantity, Vec<f64>>;

/// How texel values come to be.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Texels {
    /// So that interpolated values come nearest to the truth.
    Fitted,
    /// The truth at the place of each texel, as generators of engines compute them.
    Sampled,
}

/// The texture of `sheet`. `earlier` are the textures of the same profile that come before: means are those of what lookups in the
/// last of them read. `done` hears of every integral that is computed; see [`work`].
///
/// # Errors
/// [`SheetError`]
pub fn bake(
    sheet: &Sheet,
    texels: Texels,
    earlier: &[(&Sheet, &Texture)],
    done: &(dyn Fn(u64) + Sync),
) -> Result<Texture, SheetError> {
    let axes = axes(sheet)?;
    let mut texture = Texture {
        id: sheet.name.into(),
        channels: sheet.channels.iter().map(|term| channel(*term)).collect(),
        storage: sheet.storage,
        values: Vec::new(),
        errors: Vec::new(),
        facts: facts(sheet, texels),
        axes,
    };
    let columns = match sheet.axes.iter().any(|along| along.parameter == Parameter::Mu) {
        true => columns(sheet, &texture.axes, texels, done)?,
        false => means(sheet, &texture.axes, earlier)?,
    };
    let count = columns.first().map_or(0, Vec::len);
    texture.values = (0..count)
        .flat_map(|texel| columns.iter().map(move |column| column[texel]))
        .collect();
    let mut texture = texture.rounded()?;
    if sheet.axes.iter().any(|along| along.parameter == Parameter::Mu) {
        texture.errors = measured(sheet, &texture, &|size| per_cell(size, PROBES), done)?;
    }
    Ok(texture)
}

/// Number of integrals that [`bake`] computes.
pub fn work(sheet: &Sheet) -> u64 {
    let count = |along: &Along, places: usize| per_cell(along.size, places) * (along.size + 1) + 3;
    let all = |places: usize| sheet.axes.iter().map(|along| count(along, places)).product::<usize>() as u64;
    all(PLACES) + all(PROBES)
}

fn per_cell(size: usize, places: usize) -> usize {
    places.div_ceil(size).max(3)
}

fn axes(sheet: &Sheet) -> Result<Vec<TextureAxis>, SheetError> {
    let sheet_name = sheet.name;
    let axis = |along: &Along| {
        along.axis().map_err(|source| SheetError::Axis {
            sheet: sheet_name,
            source,
        })
    };
    sheet.axes.iter().map(axis).collect()
}

fn channel(term: Term) -> Channel {
    Channel {
        name: term.name().into(),
        meaning: term.meaning().into(),
    }
}

fn facts(sheet: &Sheet, texels: Texels) -> Vec<(String, String)> {
    [
        ("purpose", sheet.purpose),
        ("distribution", sheet.lobe.family.name()),
        ("masking", sheet.lobe.masking.name()),
        (
            "texels",
            match texels {
                Texels::Fitted => "fitted so that interpolated values come nearest to the truth",
                Texels::Sampled => "the truth at the place of each texel",
            },
        ),
    ]
    .map(|(name, value)| (name.to_owned(), value.to_owned()))
    .into()
}

/// B and E at every place of `grid`.
pub(super) fn truths(sheet: &Sheet, grid: &Grid, done: &(dyn Fn(u64) + Sync)) -> Result<Truths, SheetError> {
    let pairs: Result<Vec<[f64; 2]>, TruthError> = (0..grid.len())
        .into_par_iter()
        .map(|index| {
            let pair = sheet.lobe.pair(sheet.place(&grid.values(index)));
            done(1);
            pair
        })
        .collect();
    let pairs = pairs.map_err(|source| SheetError::Truth {
        sheet: sheet.name,
        source,
    })?;
    Ok(BTreeMap::from([
        (Quantity::Bias, pairs.iter().map(|pair| pair[0]).collect()),
        (Quantity::Total, pairs.iter().map(|pair| pair[1]).collect()),
    ]))
}

/// What errors of a quantity are relative to: E, and for B the albedo of a dielectric.
fn unit(quantity: Quantity, truths: &Truths) -> Vec<f64> {
    let [bias, total] = [Quantity::Bias, Quantity::Total].map(|quantity| &truths[&quantity]);
    match quantity {
        Quantity::Total => total.clone(),
        Quantity::Bias => bias.iter().zip(total).map(|(b, e)| dielectric(*b, *e)).collect(),
    }
}

/// r0 A + B.
pub(super) fn dielectric(bias: f64, total: f64) -> f64 {
    DIELECTRIC_R0 * (total - bias) + bias
}

/// Texels per channel of a sheet over mu.
fn columns(
    sheet: &Sheet,
    axes: &[TextureAxis],
    texels: Texels,
    done: &(dyn Fn(u64) + Sync),
) -> Result<Vec<Vec<f64>>, SheetError> {
    let places = |(axis, domain): (&TextureAxis, &[f64; 2])| match texels {
        Texels::Fitted => Places::borders(axis, per_cell(axis.axis.size, PLACES)).and_ends(axis, *domain, END),
        Texels::Sampled => Places::texels(axis),
    };
    let domain = sheet.domain();
    let grid = Grid::new(axes, axes.iter().zip(&domain).map(places).collect());
    let truths = truths(sheet, &grid, done)?;
    let units = truths
        .keys()
        .map(|quantity| (*quantity, unit(*quantity, &truths)))
        .collect::<BTreeMap<_, _>>();
    let problem = |quantity: Quantity| Problem {
        grid: &grid,
        truth: &truths[&quantity],
        unit: &units[&quantity],
        domain: &domain,
    };
    if texels == Texels::Sampled {
        let value = |term: &Term, texel: usize| {
            let sum: f64 = term
                .parts()
                .iter()
                .map(|(quantity, factor)| factor * truths[quantity][texel])
                .sum();
            sum + if *term == Term::Loss { 1.0 } else { 0.0 }
        };
        let column = |term: &Term| (0..grid.texels()).map(|texel| value(term, texel)).collect();
        return Ok(sheet.channels.iter().map(column).collect());
    }
    let zero = vec![0.0; grid.texels()];
    let one = vec![1.0; grid.texels()];
    let quantities: Vec<Quantity> = truths.keys().copied().collect();
    let fitted: BTreeMap<Quantity, (Vec<f64>, Score)> = quantities
        .into_par_iter()
        .map(|quantity| (quantity, fit(&problem(quantity))))
        .collect();
    let stored = |quantity: Quantity, constant: &[f64], sign: f64| {
        let code = Code { constant, sign };
        let (texels, score) = &fitted[&quantity];
        round(&problem(quantity), (texels, *score), &code, sheet.storage)
    };
    let bias = stored(Quantity::Bias, &zero, 1.0);
    let column = |term: &Term| match term {
        Term::Bias => bias.clone(),
        // on top of B as it is stored, so that their sum is what is rounded well
        Term::Scale => stored(Quantity::Total, &bias, 1.0),
        Term::Total => stored(Quantity::Total, &zero, 1.0),
        Term::Loss => stored(Quantity::Total, &one, -1.0),
        Term::MeanTotal | Term::MeanLoss | Term::Unused => zero.clone(),
    };
    Ok(sheet.channels.iter().map(column).collect())
}

/// E as a lookup finds it among `channels`, where they tell.
pub(super) fn total_of(terms: &[Term], channels: &[f64]) -> Option<f64> {
    let of = |wanted: Term| terms.iter().position(|term| *term == wanted).map(|k| channels[k]);
    of(Term::Total)
        .or(of(Term::Loss).map(|loss| 1.0 - loss))
        .or(of(Term::Scale).zip(of(Term::Bias)).map(|(scale, bias)| scale + bias))
}
