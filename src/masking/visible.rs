//! Normals drawn from those that a direction sees under Smith masking.
//!
//! D_o(h) = G1(o) max(0, o.h) D(h)/(n.o) = max(0, o.h) D(h)/seen(o) is a density over solid angle, int D_o dh = 1
//! [Heitz and d'Eon 2014]. Slopes that are stretched by (a_x, a_y) are seen from o as the round ones are from the
//! stretched direction o' = (a_x o.x, a_y o.y, o.z)/length: it is enough to draw a normal of the round distribution seen
//! from o', and to stretch its slopes.

use super::smith::{Shape, Smith};
use crate::geometry::at_azimuth;
use crate::numerics::gaussian::{HALF_STEP, exp_minus_square, ierfc, quantile};
use glam::{DVec2, DVec3};
use std::f64::consts::{FRAC_2_SQRT_PI, TAU};

/// 1/sqrt(pi)
const FRAC_1_SQRT_PI: f64 = 0.5 * FRAC_2_SQRT_PI;

impl Smith {
    /// A normal that `wo`, n.o >= 0, sees; u in [0, 1)^2.
    pub fn sample_visible(&self, wo: DVec3, u: [f64; 2]) -> DVec3 {
        let stretched = (self.axes * wo.truncate()).extend(wo.z).normalize();
        let normal = match self.shape {
            Shape::Gaussian => gaussian_visible(stretched, u),
            Shape::Ggx => sphere_visible(stretched, u),
        };
        (self.axes * normal.truncate()).extend(normal.z).normalize()
    }
}

/// A normal of the round GGX distribution that `wo` sees, of any length.
///
/// Unit GGX is the distribution of the normals of the upper half sphere. Those that a beam along wo meets, in proportion
/// to its cross section, mirror it into directions that are uniform over the sphere, and the upper half of the sphere is
/// what mirrors it into wi.z > -wo.z [Dupuy and Benyoub 2023]. The normal is along wo + wi.
fn sphere_visible(wo: DVec3, u: [f64; 2]) -> DVec3 {
    // wi.z runs down from 1 to -wo.z; sin^2 = (1 - wi.z)(1 + wi.z) with both factors free of cancellation
    let whole = 1.0 + wo.z;
    let short = (wo.x * wo.x + wo.y * wo.y) / whole; // 1 - wo.z
    let sin = (u[0] * whole * (2.0 * (1.0 - u[0]) + u[0] * short)).sqrt();
    let around = at_azimuth(TAU * u[1]) * sin;
    (wo.truncate() + around).extend((1.0 - u[0]) * whole)
}

/// A normal of the round Beckmann distribution that `wo` sees, of any length.
///
/// The normal of the slopes (x, y), the first along the azimuth of wo, is along (-x, -y, 1). With n.o = cos and the sine of
/// wo, the density of slopes that wo sees is proportional to max(0, cos - x sin) e^(-x^2) e^(-y^2): y is Gaussian.
fn gaussian_visible(wo: DVec3, u: [f64; 2]) -> DVec3 {
    let sin = libm::hypot(wo.x, wo.y);
    let azimuth = if sin > 0.0 { wo.truncate() / sin } else { DVec2::X };
    let slopes = DVec2::new(visible_slope(wo.z, sin, u[0]), quantile(u[1]));
    (-azimuth.rotate(slopes)).extend(1.0)
}

/// Beyond this slope on either side, no uniform number reaches.
const STEEPEST: f64 = 6.5;

/// Largest step, of what is left of the range, after which the next one would be lost in rounding.
///
/// A step of Halley's method leaves the cube of the last error, times at most some fifty.
const LAST_STEP: f64 = 1e-6;

/// The slope x below which the density proportional to max(0, cos - x sin) e^(-x^2) holds `u`: the root of
///
/// F(x) C = cos (1 + erf x)/2 + sin e^(-x^2)/(2 sqrt(pi)) = u C, C = cos + sin ierfc(cos/sin)/2.
///
/// In the upper half (1 - F) C = cos erfc(x)/2 - sin e^(-x^2)/(2 sqrt(pi)) + sin ierfc(cos/sin)/2 takes its place, so that
/// both tails keep their digits. The roots for sin = 0 and cos = 0 are elementary; between them they make a good start
/// for Halley's method, which is kept within a bracket by bisection.
pub(super) fn visible_slope(cos: f64, sin: f64, u: f64) -> f64 {
    let u = u.max(HALF_STEP);
    let end = cos / sin; // infinite at the normal, where every slope is seen
    let hidden = if sin > 0.0 { 0.5 * sin * ierfc(end) } else { 0.0 };
    let whole = cos + hidden;
    let scale = 0.5 * FRAC_1_SQRT_PI * sin;
    let excess = |x: f64, gauss: f64| {
        if u <= 0.5 {
            0.5 * cos * libm::erfc(-x) + scale * gauss - u * whole
        } else {
            (1.0 - u) * whole - (0.5 * cos * libm::erfc(x) - scale * gauss + hidden)
        }
    };
    let (mut low, mut high) = (-STEEPEST, end.min(STEEPEST));
    let share = cos / (cos + START * sin);
    let mut x = share * quantile(u) - (1.0 - share) * (-libm::log(u)).sqrt();
    if x >= high {
        x = 0.5 * (low + high);
    }
    for _ in 0..MOST_STEPS {
        let gauss = exp_minus_square(x);
        let excess = excess(x, gauss);
        if excess > 0.0 {
            high = x;
        } else {
            low = x;
        }
        let room = cos - x * sin;
        let newton = excess / (FRAC_1_SQRT_PI * room * gauss);
        // the density falls by 2 x + sin/room per slope
        let step = newton / (1.0 + 0.5 * newton * (2.0 * x + sin / room)).max(0.5);
        let next = x - step;
        if step.abs() <= LAST_STEP * (end - x).min(1.0) {
            return next.clamp(low, high);
        }
        x = if next > low && next < high {
            next
        } else {
            0.5 * (low + high)
        };
    }
    x
}

/// Where between the two elementary roots the start lies: found by counting steps, of which three are usual.
const START: f64 = 0.35;

/// Bisection alone needs this many to exhaust the bracket.
const MOST_STEPS: u32 = 64;
