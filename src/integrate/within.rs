//! Tables to the error that a shader may see: chosen, computed, measured, and corrected.

use super::Estimator;
use super::choice::{Choice, Chooser, MOST_TEXELS};
use super::fill::{FillError, Progress, fill, fill_axes};
use crate::table::axis::{Axis, MAX_SIZE};
use crate::table::{Goal, Storage, Table};
use std::f64::consts::SQRT_2;

/// How often sizes are corrected: measured errors follow the square of the sizes, so that one correction is the rule.
const CORRECTIONS: usize = 4;

/// A table whose error is below this share of the tolerance is worth making smaller.
const WASTEFUL: f64 = 0.8;

/// Computes the table of `choice`, what `chooser` chose for f32 by [`Chooser::wished`], and corrects the sizes until its measured lookup error is within the
/// tolerance, or no more texels are allowed. The [`Goal`] of the table says which.
///
/// # Errors
/// [`FillError`] with the texel that failed.
pub fn fill_within(chooser: &Chooser<'_>, choice: &Choice, progress: Progress<'_>) -> Result<Table, FillError> {
    let tolerance = chooser.wish.tolerance;
    let with_goal = |table: Table, unmet: Option<String>| Table {
        goal: Some(Goal { tolerance, unmet }),
        ..table
    };
    if let Some(obstacle) = choice.obstacle {
        let table = fill(&choice.plan, progress)?;
        let met = table.max_lookup_error() <= tolerance;
        return Ok(with_goal(table, (!met).then(|| obstacle.reason().into())));
    }
    let plan = &choice.plan;
    let mut axes = plan.alternatives.first().cloned().unwrap_or_default();
    let free: Vec<bool> = axes.iter().map(|axis| chooser.wish.size(axis).is_none()).collect();
    let mut kept: Option<Table> = None;
    // more texels cure neither given sizes nor noise
    let sampled = matches!(plan.estimator, Estimator::MonteCarlo { .. });
    let mut corrections = if choice.error <= tolerance && !sampled {
        CORRECTIONS
    } else {
        0
    };
    loop {
        let table = fill_axes(plan, &axes, progress)?;
        let found = table.max_lookup_error();
        let met = found <= tolerance;
        if let (false, Some(kept)) = (met, kept.take()) {
            // the smaller one was too small
            return Ok(with_goal(kept, None));
        }
        let wasteful = met && axes.len() > 1 && found < WASTEFUL * tolerance;
        let factor = if met {
            (found / (0.95 * tolerance)).sqrt()
        } else {
            1.02 * (found / tolerance).sqrt().min(SQRT_2)
        };
        let next = resized(&axes, &free, factor);
        if corrections == 0 || next == axes || (met && !wasteful) {
            return Ok(with_goal(table, (!met).then(|| chooser.unmet(&axes, tolerance))));
        }
        kept = met.then_some(table);
        axes = next;
        corrections -= 1;
    }
}

/// The free axes with `factor` as many texels, within what is allowed.
fn resized(axes: &[Axis], free: &[bool], factor: f64) -> Vec<Axis> {
    let scaled = axes.iter().zip(free).map(|(axis, free)| {
        let size = (axis.size as f64 * factor).clamp(2.0, MAX_SIZE as f64);
        // whichever way, by one texel at least
        let size = if factor > 1.0 { size.ceil() } else { size.floor() } as usize;
        Axis {
            size: if *free { size } else { axis.size },
            ..axis.clone()
        }
    });
    let scaled: Vec<Axis> = scaled.collect();
    let texels: usize = scaled.iter().map(|axis| axis.size).product();
    if axes.len() > 1 && texels > MOST_TEXELS {
        axes.to_vec()
    } else {
        scaled
    }
}

impl Chooser<'_> {
    /// What stands in the way of `tolerance`, and what to do.
    fn unmet(&self, axes: &[Axis], tolerance: f64) -> String {
        let given = axes.iter().find(|axis| self.wish.size(axis).is_some());
        let rounding = Storage::F32.rounding(1.0);
        if let Estimator::MonteCarlo { .. } = self.plan.estimator {
            return "samples leave noise at the texels: take more, or use --estimator auto".into();
        }
        if let Some(axis) = given {
            return format!(
                "{} texels along {} were asked for: leave the size open",
                axis.size, axis.parameter
            );
        }
        if tolerance <= 2.0 * rounding {
            return format!("f32 itself is off by up to {rounding:.0e}: ask for a larger --tolerance");
        }
        match axes {
            [] => "ask for a larger --tolerance".into(),
            [_] => format!("an axis has at most {MAX_SIZE} texels: ask for a larger --tolerance"),
            _ => format!(
                "of two axes at most {MOST_TEXELS} texels are chosen: ask for a larger --tolerance, for a smaller range of \
                 roughness, or set --resolution and the others"
            ),
        }
    }
}
