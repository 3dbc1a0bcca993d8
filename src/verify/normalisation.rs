//! Distributions of normals cover the surface once: int D (n.h) dh = 1 [Mikkelsen 2009, eq. 14], and what a direction sees of
//! them is what it sees of the surface, int G1 max(0, o.h) D dh = n.o.
//!
//! The densities themselves are integrated, over charts that resolve lobes down to 1e-8 radians around the normal and ridges
//! as narrow along the tangents; nothing of the sampling code is used.

use super::chart::{Axis, Chart, Mass, Rectangle};
use super::sampling::COSINES;
use super::{Density, Outcome, Place, Statistic, Test, VisibleDensity};
use crate::geometry::Polar;
use glam::DVec3;
use rayon::prelude::*;
use std::f64::consts::{FRAC_PI_2, FRAC_PI_4};

/// Angle below which nothing is resolved: a hundredth of the narrowest legal lobe.
const FINEST: f64 = 1e-8;

/// Errors to which the densities are integrated.
const TOLERANCE: f64 = 1e-7;
const VISIBLE_TOLERANCE: f64 = 1e-5;

/// Difference from 1 beyond the error of the quadrature that is put down to rounding: of D at the horizon, and of angles of
/// 1e-6 that are good to 1e-16.
const ROUNDING: f64 = 2e-9;

/// Azimuth of wo, one that no axis prefers.
const OBLIQUE: f64 = 0.7;

/// Most panels of a part of an octant; a density that is not known by then is far from smooth, and its error says so.
const MOST_PANELS: usize = 4000;

/// Parts of an octant along theta, four for each of two along phi.
const PARTS: usize = 8;

/// The integral of a density over the upper hemisphere.
fn integrate(density: impl Fn(DVec3) -> f64 + Sync, tolerance: f64) -> Mass {
    let mut parts = Vec::new();
    for octant in 0..8 {
        // each of the eight begins at an axis of the tangent plane
        let (axis, side) = (octant / 2, octant % 2);
        let chart = Chart {
            below: false,
            axis: Axis::Z,
            centre: [0.0, f64::from(axis) * FRAC_PI_2],
            scale: [FINEST, FINEST],
        };
        let far = (FRAC_PI_4 / FINEST).asinh();
        let over = Rectangle {
            low: [0.0, if side == 0 { 0.0 } else { -far }],
            high: [(FRAC_PI_2 / FINEST).asinh(), if side == 0 { far } else { 0.0 }],
        };
        let at = |axis: usize, k: usize, of: usize| {
            over.low[axis] + (over.high[axis] - over.low[axis]) * k as f64 / of as f64
        };
        for i in 0..PARTS {
            for j in 0..PARTS / 2 {
                let part = Rectangle {
                    low: [at(0, i, PARTS), at(1, j, PARTS / 2)],
                    high: [at(0, i + 1, PARTS), at(1, j + 1, PARTS / 2)],
                };
                parts.push((chart, part));
            }
        }
    }
    let share = tolerance / parts.len() as f64;
    let masses: Vec<Mass> = parts
        .par_iter()
        .map(|(chart, part)| chart.integrate(*part, (&[], 0.0), |_| share, MOST_PANELS, &density))
        .collect();
    masses.into_iter().fold(Mass::default(), Mass::plus)
}

/// Whether an integral is 1 within its error.
fn is_one(mass: Mass) -> bool {
    (mass.value - 1.0).abs() <= mass.error + ROUNDING
}

/// int p(h) dh = 1 over the upper hemisphere, for p = D (n.h).
pub fn normals(density: &Density<'_>) -> Outcome {
    let mass = integrate(density, TOLERANCE);
    let note = format!("int = {:.9} to {:.1e}", mass.value, mass.error);
    let holds = is_one(mass);
    Outcome::certain(Test::Normals, Statistic::new("int - 1", mass.value - 1.0), holds).noted((!holds).then_some(note))
}

/// int G1 max(0, o.h) D/(n.o) dh = 1 at some directions, for the density of visible normals.
pub fn visible_normals(density: &VisibleDensity<'_>) -> Outcome {
    let masses = COSINES.map(|mu| {
        let wo = Polar::from_cos(mu).direction(OBLIQUE);
        (wo, integrate(|h| density(wo, h), VISIBLE_TOLERANCE))
    });
    let rank = |(_, mass): &(DVec3, Mass)| {
        let rank = (mass.value - 1.0).abs() - mass.error;
        if rank.is_nan() { f64::INFINITY } else { rank }
    };
    let worst = masses
        .into_iter()
        .reduce(|a, b| if rank(&b) > rank(&a) { b } else { a });
    let Some((wo, mass)) = worst else {
        return Outcome::skipped(Test::VisibleNormals, "no direction");
    };
    let holds = is_one(mass);
    let note = format!("int = {:.9} to {:.1e}", mass.value, mass.error);
    Outcome::certain(Test::VisibleNormals, Statistic::new("int - 1", mass.value - 1.0), holds)
        .at(Place::direction(wo))
        .noted((!holds).then_some(note))
}
