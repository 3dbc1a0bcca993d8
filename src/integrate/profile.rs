//! rho along lines through the domain of a table, known well enough to judge a linear lookup of any size without further
//! integrals.
//!
//! Along each axis rho is followed by piecewise Chebyshev interpolation, some 100 to 600 integrals a line. What a table with n
//! texels would err follows from the curve alone, so that sizes, mappings and texel rules are searched at no cost. For two
//! axes the lines cross the domain at a few places of the other axis, ends included; a bilinear lookup then errs by about the
//! sum of what linear lookups along both axes err, which is what the sum of their worst bounds.

use super::fill::{FillError, model_at};
use super::{Effort, Estimator, IntegrateError, Integrator, Target};
use crate::bxdf::Model;
use crate::numerics::curve::Curve;
use crate::numerics::quadrature::Bounded;
use crate::plan::TablePlan;
use crate::table::Quantity;
use crate::table::axis::{AZIMUTH, Axis, MU, Mapping, TexelRule};
use glam::DVec3;
use rayon::prelude::*;

/// What is known along every axis of a table.
#[derive(Debug, Clone)]
pub(super) struct Profile {
    /// One for each axis, in the order of the table.
    pub(super) axes: Vec<Lines>,
    /// Largest value met.
    pub(super) largest: f64,
    /// Largest error of a curve: of its integrals and of the interpolation.
    pub(super) error: f64,
}

/// Why lines cannot be drawn.
#[derive(Debug)]
pub(super) enum Stop {
    /// The integral grows without bound in the domain.
    Diverges,
    /// More pieces than a smooth function needs.
    Rough,
    /// An integral failed.
    Failed(FillError),
}

/// rho along one axis, at several places of the other.
#[derive(Debug, Clone)]
pub(super) struct Lines {
    /// Parameter and range; mapping and rule of the plan.
    pub(super) axis: Axis,
    curves: Vec<Curve>,
    channels: usize,
}

/// Integrals are this much more exact than the curves through them: their errors must not pass for structure.
const FINER: f64 = 0.1;

/// Most integrals of one line. Smooth ones need some hundred, those with a kink a thousand.
const MOST: usize = 8000;

/// Coordinates of a roughness axis, in shares of the axis, at which lines along mu are drawn; fewer azimuths, whose lines cost
/// a hundred times more.
const ROWS: [f64; 5] = [0.0, 0.25, 0.5, 0.75, 1.0];
const AZIMUTHS: [f64; 3] = [0.0, 0.5, 1.0];

/// mu^(1/4) at which lines along a roughness axis are drawn, and along the azimuth: layers at grazing angles are as thin as
/// lobes are narrow.
const COLUMNS: [f64; 8] = [0.0, 0.15, 0.3, 0.45, 0.6, 0.75, 0.9, 1.0];
const FEW_COLUMNS: [f64; 5] = [0.0, 0.3, 0.5, 0.7, 0.9];

impl Profile {
    /// Draws the lines to an error of about `tolerance`.
    pub(super) fn new(plan: &TablePlan, tolerance: f64) -> Result<Self, Stop> {
        let axes = plan.alternatives.first().map_or(&[][..], |axes| &axes[..]);
        let crossing = |axis: usize| -> Vec<Option<f64>> {
            let other = axes
                .iter()
                .enumerate()
                .find(|(index, _)| *index != axis)
                .map(|(_, other)| other);
            let azimuth = axes.iter().any(|axis| axis.parameter == AZIMUTH);
            let of_mu = if azimuth { &FEW_COLUMNS[..] } else { &COLUMNS };
            let of_rows = if azimuth { &AZIMUTHS[..] } else { &ROWS };
            match other {
                None => vec![None],
                Some(other) if other.parameter == MU => of_mu.iter().map(|x| Some(x.powi(4))).collect(),
                Some(other) => of_rows.iter().map(|x| Some(other.value(*x))).collect(),
            }
        };
        let lines = |index: usize| -> Result<Lines, Stop> {
            let curves = crossing(index).into_par_iter().map(|other| {
                Line {
                    plan,
                    axes,
                    index,
                    other,
                }
                .follow(tolerance)
            });
            Ok(Lines {
                axis: axes[index].clone(),
                curves: curves.collect::<Result<_, Stop>>()?,
                channels: plan.channels.count(),
            })
        };
        let axes: Vec<Lines> = (0..axes.len()).map(lines).collect::<Result<_, Stop>>()?;
        let curves = || axes.iter().flat_map(|lines| &lines.curves);
        let values = curves().flat_map(|curve| (0..=200).map(|i| curve.at(f64::from(i) / 200.0).max_element()));
        Ok(Self {
            largest: values.fold(0.0, f64::max),
            error: curves().map(Curve::error).fold(0.0, f64::max),
            axes,
        })
    }
}

/// One line: along axis `index`, at `other` of the second axis where there is one.
struct Line<'a> {
    plan: &'a TablePlan,
    axes: &'a [Axis],
    index: usize,
    other: Option<f64>,
}

impl Line<'_> {
    fn follow(&self, tolerance: f64) -> Result<Curve, Stop> {
        let axis = &self.axes[self.index];
        let effort = Effort {
            tolerance: FINER * tolerance,
            samples: None,
            ..self.plan.effort
        };
        let model_of = |roughness: Option<f64>| model_at(self.plan, roughness).map_err(Stop::Failed);
        let failed = |source: IntegrateError| match source {
            IntegrateError::Diverges(_) => Stop::Diverges,
            source => Stop::Failed(FillError::Integral {
                id: self.plan.id.clone(),
                at: format!("a line along {}", axis.parameter),
                source,
            }),
        };
        let integral = |integrator: &Integrator, value: f64| {
            let estimate = integrator.estimate(self.target(value), 0).map_err(failed)?;
            Ok(Bounded {
                value: estimate.value,
                error: estimate.error,
            })
        };
        let mut left = MOST;
        let mut count = || {
            left = left.checked_sub(1)?;
            Some(())
        };
        if axis.parameter == MU || axis.parameter == AZIMUTH {
            let model: Model = model_of(self.roughness(0.0))?;
            let integrator = Integrator::new(&model, Estimator::Auto, effort).map_err(failed)?;
            if axis.parameter == MU {
                // a curve would follow 1/mu for ever: ask at the limit first
                integral(&integrator, 0.0)?;
            }
            let layer = if axis.parameter == MU {
                model.width().sqrt().sqrt()
            } else {
                1.0
            };
            return Curve::fit(tolerance, layer, &mut |x| {
                count().ok_or(Stop::Rough)?;
                integral(&integrator, value(axis, x))
            });
        }
        Curve::fit(tolerance, 1.0, &mut |x| {
            count().ok_or(Stop::Rough)?;
            let at = value(axis, x);
            let model = model_of(self.roughness(at))?;
            let integrator = Integrator::new(&model, Estimator::Auto, effort).map_err(failed)?;
            integral(&integrator, at)
        })
    }

    /// The roughness where the line is at `along`.
    fn roughness(&self, along: f64) -> Option<f64> {
        self.parameter(along, |axis| axis.parameter != MU && axis.parameter != AZIMUTH)
    }

    /// The coordinate of the first axis that `is` the one, where the line is at `along`.
    fn parameter(&self, along: f64, is: impl Fn(&Axis) -> bool) -> Option<f64> {
        let index = self.axes.iter().position(is)?;
        if index == self.index { Some(along) } else { self.other }
    }

    fn target(&self, along: f64) -> Target {
        let target = match self.plan.quantity {
            Quantity::RhoHd => Target::rho_hd(
                self.parameter(along, |axis| axis.parameter == MU).unwrap_or(1.0),
                self.parameter(along, |axis| axis.parameter == AZIMUTH).unwrap_or(0.0),
            ),
            Quantity::RhoHh => Target::rho_hh(),
        };
        target.of(self.plan.lobe)
    }
}

/// The value at x in [0, 1] of the variable that curves run over: mu^(1/4), in which the powers of sqrt(mu) and the thin layers
/// at grazing angles are smooth, or the coordinate of the plan's axis.
fn value(axis: &Axis, x: f64) -> f64 {
    if axis.parameter == MU { x.powi(4) } else { axis.value(x) }
}

fn variable(axis: &Axis, value: f64) -> f64 {
    if axis.parameter == MU {
        value.sqrt().sqrt()
    } else {
        axis.u(value)
    }
}

/// Places between two neighbouring texels: the middle, where the error of a smooth function is largest, and around it.
const BETWEEN: [f64; 5] = [0.125, 0.3, 0.5, 0.7, 0.875];

/// Places in the half texels at both ends, which centres hold constant, and towards mu = 0 below the first texels.
const BEYOND: i32 = 60;

impl Lines {
    /// The axis with another mapping, rule and size; `None` where that is not possible.
    pub(super) fn shaped(&self, mapping: Mapping, rule: TexelRule, size: usize) -> Option<Axis> {
        Axis::new(
            self.axis.parameter.clone(),
            mapping,
            rule,
            [self.axis.min, self.axis.max],
            size,
        )
        .ok()
    }

    /// Largest error of a linear-filtered lookup of exact texels on `axis`, on any of the lines.
    pub(super) fn error(&self, axis: &Axis) -> f64 {
        self.curves
            .iter()
            .map(|curve| self.error_on(curve, axis))
            .fold(0.0, f64::max)
    }

    fn error_on(&self, curve: &Curve, axis: &Axis) -> f64 {
        let at = |value: f64| curve.at(variable(&self.axis, value));
        let texels: Vec<DVec3> = (0..axis.size).map(|i| at(axis.texel(i))).collect();
        let off = |value: f64| {
            let position = axis.texel_position(axis.u(value));
            let low = position.floor() as usize;
            let high = (low + 1).min(axis.size - 1);
            let found = texels[low] + (texels[high] - texels[low]) * (position - position.floor());
            let off = (found - at(value)).abs();
            off.to_array()[..self.channels].iter().fold(0.0, |a: f64, b| a.max(*b))
        };
        let (first, last) = (axis.texel_u(0), axis.texel_u(axis.size - 1));
        let step = (last - first) / (axis.size - 1).max(1) as f64;
        let inner = (0..axis.size - 1).flat_map(|i| BETWEEN.map(|part| first + step * (i as f64 + part)));
        let ends = (0..=8).flat_map(|i| {
            let part = f64::from(i) / 8.0;
            [first * part, last + (1.0 - last) * part]
        });
        let layers = (0..BEYOND).filter(|_| axis.parameter == MU).map(|i| {
            let below = axis.texel(1.min(axis.size - 1));
            below * libm::exp10(-9.0 * f64::from(i) / f64::from(BEYOND))
        });
        let values = inner.chain(ends).map(|u| axis.value(u)).chain(layers);
        values.map(off).fold(0.0, f64::max)
    }

    /// The smallest size of at most `most` texels whose error is at most `allowed`, within a per cent.
    pub(super) fn size(&self, mapping: Mapping, rule: TexelRule, allowed: f64, most: usize) -> Option<usize> {
        let error = |size: usize| self.shaped(mapping, rule, size).map(|axis| self.error(&axis));
        let (mut low, mut size) = (1, LEAST);
        loop {
            let found = error(size)?;
            if found <= allowed {
                break;
            }
            if size >= most {
                return None;
            }
            low = size;
            // error falls with the square of the size, or more slowly where the ends of an axis are held constant
            let factor = (found / allowed).sqrt().clamp(1.2, 4.0);
            size = ((size as f64 * factor).ceil() as usize).min(most);
        }
        while size > LEAST && size - low > 1 + size / 100 {
            let middle = low.midpoint(size);
            if error(middle)? <= allowed {
                size = middle;
            } else {
                low = middle;
            }
        }
        Some(size)
    }
}

/// Fewest texels of a chosen axis.
const LEAST: usize = 2;
