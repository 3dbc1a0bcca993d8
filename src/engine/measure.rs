//! How far lookups in a finished texture are off.

use super::bake::{DIELECTRIC_R0, SheetError, Truths, dielectric, probes, total_of, truths};
use super::grid::{Grid, Places, borders};
use super::sheet::{Along, Sheet, Term};
use super::truth::Quantity;
use crate::table::texture::{LookupError, Texture, TextureAxis};
use rayon::prelude::*;
use std::collections::HashSet;

/// Cells from which the largest error is searched, and how near to the worst of all places theirs has to be.
const STARTS: usize = 64;
const NEARLY_WORST: f64 = 0.5;

/// What such a search may have missed, as a share of what it found.
const MARGIN: f64 = 1.01;

/// Rounds of a search, each with half the steps of the one before, from a quarter of a cell on, and most steps along each axis in a round.
const ROUNDS: usize = 9;
const SWEEPS: usize = 4;

/// One way to look at the channels.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Gauge {
    /// |E_true/E - 1|: what a furnace with F = 1 reads more or less than 1 where E compensates; of an interface, both sides together.
    Furnace(Quantity),
    /// |rho/rho_true - 1| of a dielectric of r0 = [`DIELECTRIC_R0`].
    Dielectric,
    /// |x - x_true| of a channel.
    Absolute(Term),
}

/// The truths at one place, in the order of the quantities.
type At<'a> = (&'a [Quantity], Vec<f64>);

fn truth((quantities, values): &At<'_>, wanted: Quantity) -> Option<f64> {
    quantities
        .iter()
        .position(|quantity| *quantity == wanted)
        .map(|k| values[k])
}

impl Gauge {
    /// Those that the channels of `sheet` tell.
    fn of(sheet: &Sheet) -> Vec<Self> {
        let has = |term: &Term| sheet.channels.contains(term);
        let mut gauges = Vec::new();
        let zeros = vec![0.0; sheet.channels.len()];
        if total_of(&sheet.channels, &zeros).is_some() {
            gauges.push(Self::Furnace(Quantity::Total));
            if has(&Term::Bias) {
                gauges.push(Self::Dielectric);
            }
        }
        if has(&Term::Interface) {
            gauges.push(Self::Furnace(Quantity::Interface));
        }
        let absolute = [Term::Sheen, Term::DisneyDiffuse, Term::Reflected, Term::Transmitted];
        gauges.extend(absolute.into_iter().filter(has).map(Self::Absolute));
        gauges
    }

    fn name(self) -> String {
        match self {
            Self::Furnace(_) => "furnace".into(),
            Self::Dielectric => format!("r0 = {DIELECTRIC_R0}"),
            Self::Absolute(term) => term.name().into(),
        }
    }

    /// What the truth may be off by, in the unit of the gauge: E is at least 0.2.
    fn doubt(self) -> f64 {
        match self {
            Self::Furnace(quantity) => 5.0 * quantity.tolerance(),
            Self::Dielectric => 50.0 * Quantity::Bias.tolerance(),
            Self::Absolute(term) => term.code().map_or(0.0, |(quantity, ..)| quantity.tolerance()),
        }
    }

    /// The same for means over the domain, where E is above 1/2 on average.
    fn doubt_of_mean(self) -> f64 {
        match self {
            Self::Furnace(quantity) => 2.0 * quantity.tolerance(),
            _ => self.doubt(),
        }
    }

    /// The error of what lookups read, `channels`.
    fn error(self, terms: &[Term], channels: &[f64], at: &At<'_>) -> Option<f64> {
        let read = |wanted: Term| terms.iter().position(|term| *term == wanted).map(|k| channels[k]);
        match self {
            Self::Furnace(Quantity::Interface) => {
                Some((truth(at, Quantity::Interface)? / read(Term::Interface)? - 1.0).abs())
            }
            Self::Furnace(_) => Some((truth(at, Quantity::Total)? / total_of(terms, channels)? - 1.0).abs()),
            Self::Dielectric => {
                let found = dielectric(read(Term::Bias)?, total_of(terms, channels)?);
                Some((found / dielectric(truth(at, Quantity::Bias)?, truth(at, Quantity::Total)?) - 1.0).abs())
            }
            Self::Absolute(term) => {
                let (quantity, constant, sign) = term.code()?;
                Some((read(term)? - constant - sign * truth(at, quantity)?).abs())
            }
        }
    }
}

/// Places that the fit has not seen, and the truths there.
pub(super) struct Probes {
    grid: Grid,
    truths: Truths,
}

impl Probes {
    /// For lookups in textures of `sheet` with these axes.
    pub(super) fn new(sheet: &Sheet, axes: &[TextureAxis], done: &(dyn Fn(u64) + Sync)) -> Result<Self, SheetError> {
        let places = |(axis, domain): (&TextureAxis, &[f64; 2])| {
            Places::spread(axis, probes(sheet, axis.axis.size), *domain).and_ends(axis, *domain, 0.0)
        };
        let grid = Grid::new(axes, axes.iter().zip(&sheet.domain()).map(places).collect());
        let truths = truths(sheet, &grid, done)?;
        Ok(Self { grid, truths })
    }

    /// Errors of lookups in `texture`, over the domain and over all of it.
    ///
    /// The largest is that of a search from the worst of these places; what the truth may be off by is added.
    pub(super) fn errors(&self, sheet: &Sheet, texture: &Texture) -> Result<Vec<LookupError>, SheetError> {
        let Self { grid, truths } = self;
        let domains = [sheet.domain(), sheet.axes.iter().map(Along::whole).collect()];
        let mut errors = Vec::new();
        let quantities = sheet.quantities();
        for gauge in Gauge::of(sheet) {
            let error = |index: usize| {
                let values = quantities.iter().map(|quantity| truths[quantity][index]).collect();
                let channels = texture.lookup(&grid.values(index));
                gauge.error(&sheet.channels, &channels, &(&quantities, values))
            };
            let all: Option<Vec<f64>> = (0..grid.len()).into_par_iter().map(error).collect();
            let Some(all) = all else { continue };
            for domain in &domains {
                errors.push(summary(sheet, texture, gauge, (grid, &all), domain)?);
            }
        }
        Ok(errors)
    }
}

fn summary(
    sheet: &Sheet,
    texture: &Texture,
    gauge: Gauge,
    (grid, all): (&Grid, &[f64]),
    domain: &[[f64; 2]],
) -> Result<LookupError, SheetError> {
    let (mut sum, mut measure) = (0.0, 0.0);
    let inside: Vec<usize> = (0..grid.len()).filter(|index| grid.is_within(*index, domain)).collect();
    for index in &inside {
        sum += grid.measure(*index) * all[*index];
        measure += grid.measure(*index);
    }
    let tops: Vec<(Vec<f64>, f64)> = starts(texture, (grid, all), inside.clone())
        .into_par_iter()
        .flat_map(|index| [(index, false), (index, true)])
        .map(|(index, from_texel)| {
            climb(
                sheet,
                texture,
                gauge,
                (grid.values(index), all[index], from_texel),
                domain,
            )
        })
        .collect::<Result<_, SheetError>>()?;
    let higher = |a: (Vec<f64>, f64), b: (Vec<f64>, f64)| if b.1 > a.1 { b } else { a };
    let worst = tops.into_iter().reduce(higher).unwrap_or_default();
    Ok(LookupError {
        of: gauge.name(),
        max: MARGIN * worst.1 + gauge.doubt(),
        mean: sum / measure + gauge.doubt_of_mean(),
        at: worst.0,
        domain: domain.to_vec(),
        probes: inside.len() as u64,
    })
}

/// The worst place of each of the cells that look bad: what looks worst need not lie under the highest of the maxima.
fn starts(texture: &Texture, (grid, all): (&Grid, &[f64]), mut inside: Vec<usize>) -> Vec<usize> {
    inside.sort_by(|a, b| all[*b].total_cmp(&all[*a]));
    let cell = |index: &usize| -> Vec<usize> {
        let borders = texture.axes.iter().map(borders);
        let values = grid.values(*index);
        let below = |(borders, (axis, value)): (Vec<f64>, (&TextureAxis, &f64))| {
            let u = axis.axis.u(*value);
            borders.iter().filter(|border| **border <= u).count()
        };
        borders.zip(texture.axes.iter().zip(&values)).map(below).collect()
    };
    let least = NEARLY_WORST * inside.first().map_or(0.0, |first| all[*first]);
    let mut cells = HashSet::new();
    let bad = inside.into_iter().take_while(|index| all[*index] >= least);
    bad.filter(|index| cells.insert(cell(index))).take(STARTS).collect()
}

/// The largest error near a place, along each axis in turn, as often as that leads upwards, with steps that halve; or, `from_texel`, near
/// the texel beside it where that errs by more: either may stand at the foot of the higher peak.
fn climb(
    sheet: &Sheet,
    texture: &Texture,
    gauge: Gauge,
    (mut at, mut error, from_texel): (Vec<f64>, f64, bool),
    domain: &[[f64; 2]],
) -> Result<(Vec<f64>, f64), SheetError> {
    let quantities = sheet.quantities();
    // the step of infinite length is that to the nearest texel, where what rounding adds is not mixed with any other
    let mut try_at = |at: &mut Vec<f64>, k: usize, step: f64| -> Result<bool, SheetError> {
        let axis = &texture.axes[k].axis;
        let mut tried = at.clone();
        let u = match step.is_finite() {
            true => (axis.u(at[k]) + step / axis.size as f64).clamp(0.0, 1.0),
            false => axis.texel_u(axis.texel_position(axis.u(at[k])).round() as usize),
        };
        tried[k] = axis.value(u).clamp(domain[k][0], domain[k][1]);
        if tried == *at {
            return Ok(false);
        }
        let values = sheet.lobe.values(&quantities, sheet.place(&tried));
        let values = values.map_err(|source| SheetError::Truth {
            sheet: sheet.name,
            source,
        })?;
        let found = gauge.error(&sheet.channels, &texture.lookup(&tried), &(&quantities, values));
        let found = found.unwrap_or(0.0);
        let is_higher = found > error;
        if is_higher {
            (*at, error) = (tried, found);
        }
        Ok(is_higher)
    };
    if from_texel {
        for k in (0..at.len()).chain(0..at.len()) {
            try_at(&mut at, k, f64::INFINITY)?;
        }
    }
    for round in 0..ROUNDS {
        let step = 0.25 / f64::from(1u32 << round);
        for _ in 0..SWEEPS {
            let mut is_higher = false;
            for k in 0..at.len() {
                is_higher |= try_at(&mut at, k, -step)? || try_at(&mut at, k, step)?;
            }
            if !is_higher {
                break;
            }
        }
    }
    Ok((at, error))
}
