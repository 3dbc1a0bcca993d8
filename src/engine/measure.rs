//! How far lookups in a finished texture are off.

use super::bake::{DIELECTRIC_R0, SheetError, dielectric, total_of, truths};
use super::grid::{Grid, Places};
use super::sheet::{Sheet, Term};
use super::truth::{Quantity, TOLERANCE};
use crate::table::texture::{LookupError, Texture};
use rayon::prelude::*;

/// Starts of the search for the largest error, and its rounds: each halves a step of a part of a cell.
const STARTS: usize = 4;
const ROUNDS: usize = 8;

/// One way to look at the channels.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Gauge {
    /// |E_true/E - 1|: what a furnace with F = 1 reads more or less than 1 where E compensates.
    Furnace,
    /// |rho/rho_true - 1| of a dielectric of r0 = [`DIELECTRIC_R0`].
    Dielectric,
}

impl Gauge {
    fn name(self) -> String {
        match self {
            Self::Furnace => "furnace".into(),
            Self::Dielectric => format!("r0 = {DIELECTRIC_R0}"),
        }
    }

    /// The error of what lookups read, `channels`, where B and E are the truth; `None` where the channels do not tell.
    fn error(self, terms: &[Term], channels: &[f64], [bias, total]: [f64; 2]) -> Option<f64> {
        let e = total_of(terms, channels)?;
        match self {
            Self::Furnace => Some((total / e - 1.0).abs()),
            Self::Dielectric => {
                let b = terms.iter().position(|term| *term == Term::Bias).map(|k| channels[k])?;
                Some((dielectric(b, e) / dielectric(bias, total) - 1.0).abs())
            }
        }
    }
}

/// Errors of lookups with F = 1 and of a dielectric, over the domain and over all of it.
///
/// Places are those of a grid that the fit has not seen, and of a search from the worst of them; what the truth may be off by is
/// added.
pub(super) fn measured(
    sheet: &Sheet,
    texture: &Texture,
    per_cell: &dyn Fn(usize) -> usize,
    done: &(dyn Fn(u64) + Sync),
) -> Result<Vec<LookupError>, SheetError> {
    let domain = sheet.domain();
    let axes = &texture.axes;
    let places = |(axis, domain): (&_, &[f64; 2])| {
        let axis: &crate::table::texture::TextureAxis = axis;
        Places::midpoints(axis, per_cell(axis.axis.size)).and_ends(axis, *domain, 0.0)
    };
    let grid = Grid::new(axes, axes.iter().zip(&domain).map(places).collect());
    let truths = truths(sheet, &grid, done)?;
    let whole = vec![[0.0, 1.0]; axes.len()];
    let mut errors = Vec::new();
    for gauge in [Gauge::Furnace, Gauge::Dielectric] {
        let all: Option<Vec<f64>> = (0..grid.len())
            .into_par_iter()
            .map(|index| {
                let truth = [Quantity::Bias, Quantity::Total].map(|quantity| truths[&quantity][index]);
                gauge.error(&sheet.channels, &texture.lookup(&grid.values(index)), truth)
            })
            .collect();
        let Some(all) = all else { continue };
        for domain in [&domain, &whole] {
            errors.push(summary(sheet, texture, gauge, (&grid, &all), domain)?);
        }
    }
    Ok(errors)
}

fn summary(
    sheet: &Sheet,
    texture: &Texture,
    gauge: Gauge,
    (grid, all): (&Grid, &[f64]),
    domain: &[[f64; 2]],
) -> Result<LookupError, SheetError> {
    let (mut sum, mut measure) = (0.0, 0.0);
    let mut inside: Vec<usize> = (0..grid.len()).filter(|index| grid.is_within(*index, domain)).collect();
    for index in &inside {
        sum += grid.measure(*index) * all[*index];
        measure += grid.measure(*index);
    }
    inside.sort_by(|a, b| all[*b].total_cmp(&all[*a]));
    let mut worst = (0.0, Vec::new());
    for index in inside.iter().take(STARTS) {
        let found = climb(sheet, texture, gauge, (grid.values(*index), all[*index]), domain)?;
        if found.1 > worst.0 || worst.1.is_empty() {
            worst = (found.1, found.0);
        }
    }
    Ok(LookupError {
        of: gauge.name(),
        max: worst.0 + TOLERANCE,
        mean: sum / measure + TOLERANCE,
        at: worst.1,
        domain: domain.to_vec(),
        probes: inside.len() as u64,
    })
}

/// The largest error near `start`, along each axis in turn with steps that halve.
fn climb(
    sheet: &Sheet,
    texture: &Texture,
    gauge: Gauge,
    (mut at, mut error): (Vec<f64>, f64),
    domain: &[[f64; 2]],
) -> Result<(Vec<f64>, f64), SheetError> {
    for round in 0..ROUNDS {
        for k in 0..at.len() {
            let axis = &texture.axes[k].axis;
            let step = 0.25 / axis.size as f64 / f64::from(1u32 << round);
            for sign in [-1.0, 1.0] {
                let mut tried = at.clone();
                let u = (axis.u(at[k]) + sign * step).clamp(0.0, 1.0);
                tried[k] = axis.value(u).clamp(domain[k][0], domain[k][1]);
                let truth = sheet
                    .lobe
                    .pair(sheet.place(&tried))
                    .map_err(|source| SheetError::Truth {
                        sheet: sheet.name,
                        source,
                    })?;
                let found = gauge
                    .error(&sheet.channels, &texture.lookup(&tried), truth)
                    .unwrap_or(0.0);
                if found > error {
                    (at, error) = (tried, found);
                }
            }
        }
    }
    Ok((at, error))
}
