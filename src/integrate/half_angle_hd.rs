//! rho_hd of a half-angle table, deterministically.
//!
//! rho_hd(o) = int f (n.i) di = int f 4 (o.h) (n.i) dh over n.i > 0, with n.i = 2 (o.h)(n.h) - n.o. f is constant over a cell,
//! and the cells that o sees are patches of the sphere of h, bounded by circles theta_h = const around n, circles
//! theta_d = const around o, and curves phi_d = const from o to n. Tens of thousands of patches with corners are no domain
//! for a rule, but their sides are smooth. With x the azimuth of h around n, counted from o, let
//!
//! W(theta_h, x) = int_0^x 4 (o.h)(n.i) dx', o.h = (n.o) cos theta_h + sin theta_o sin theta_h cos x',
//!
//! which is elementary. Summed along x for a fixed theta_h, rho_hd = int sin theta_h dtheta_h sum_p f_p [W(end) - W(start)]
//! over the patches p, and gathered by sides instead of patches
//!
//! rho_hd = sum_sides (jump of f across the side) int W sin theta_h dtheta_h along the side.
//!
//! Circles around n do not count, as dtheta_h = 0 on them. What is left are arcs with smooth integrands, ended by the other
//! curves; every end is a closed form. The domain ends at x = pi and at the horizon n.i = 0: arcs across which f drops
//! to 0. Half vectors that mirror each other in the plane of incidence, x and -x, have phi_d and pi - phi_d: the half circle
//! 0 < x < pi with the sum of both values stands for the whole.
//!
//! Integrating azimuths exactly and theta_h adaptively was the alternative; the integrand then has a kink at each of the
//! sixteen thousand corners.

use super::IntegrateError;
use super::parts::{Part, Place, Ruled, integrate_parts, interval};
use crate::bxdf::HalfAngle;
use crate::geometry::Polar;
use crate::measured::merl::{
    PHI_D_CELLS, THETA_D_CELLS, THETA_H_CELLS, phi_d_cell, phi_d_edge, theta_d_cell, theta_d_edge, theta_h_cell,
    theta_h_edge,
};
use crate::numerics::quadrature::{Bounded, Integral};
use glam::DVec3;
use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI};

/// Most evaluations of W: several seconds. The hardest tables need 3e5 for 1e-9.
const LIMIT: u64 = 50_000_000;

/// rho_hd at cos theta_o = `mu`, with an absolute error of at most `tolerance`.
///
/// # Errors
/// [`IntegrateError::NotConverged`].
pub(super) fn rho_hd(bxdf: &HalfAngle, mu: f64, tolerance: f64) -> Result<Integral, IntegrateError> {
    let view = View::new(mu);
    if view.sin_o == 0.0 {
        return Ok(at_normal(bxdf));
    }
    // a constant added to f adds pi times itself to rho: without the value of a typical cell, a diffuse base costs nothing
    let base = bxdf.mirrored_pair(TYPICAL[0], TYPICAL[1], TYPICAL[2]);
    let mut parts = Vec::new();
    for curve in Curve::all() {
        view.arcs(curve, |from, to, [i, j, k]| {
            let pair = |j, k| bxdf.mirrored_pair(i, j, k);
            let weight = match curve {
                Curve::Difference(edge) => pair(edge, k) - pair(edge - 1, k),
                Curve::Azimuth(edge) => pair(j, edge) - pair(j, edge - 1),
                Curve::Plane | Curve::Horizon => pair(j, k) - base,
            };
            if weight != DVec3::ZERO {
                let place = Arc { curve, from, to };
                parts.push(Part { place, weight });
            }
        });
    }
    let mut integral = integrate_parts(parts, tolerance, LIMIT, |arc, level| view.along(arc, level))?;
    let Bounded { value, error } = &mut integral.bounded;
    *value += (0.5 * PI) * base;
    *error += value.abs() * (4.0 * f64::EPSILON);
    Ok(integral)
}

/// Width in radians below which a turn of a curve is fast: twice the size of a cell.
const FAST: f64 = 0.035;

/// Longest arc in radians of the parameter; most are about a degree long.
const LONGEST: f64 = 0.3;

/// A cell that the horizon passes through from most directions.
const TYPICAL: [usize; 3] = [THETA_H_CELLS * 2 / 3, THETA_D_CELLS / 2, PHI_D_CELLS / 2];

/// mu = 1: theta_h = theta_d everywhere, the cells are rings, and 2 pi int 4 c (2 c^2 - 1) dc = 2 pi [2 c^4 - 2 c^2].
fn at_normal(bxdf: &HalfAngle) -> Integral {
    let mut edges: Vec<f64> = (0..THETA_H_CELLS).map(theta_h_edge).collect();
    edges.extend((1..THETA_D_CELLS).map(theta_d_edge));
    edges.retain(|edge| *edge < FRAC_PI_4); // beyond it i is below the horizon
    edges.push(FRAC_PI_4);
    edges.sort_by(f64::total_cmp);
    let mut value = DVec3::ZERO;
    for ring in edges.windows(2) {
        let middle = 0.5 * (ring[0] + ring[1]);
        let f = bxdf.at_seam(theta_h_cell(middle), theta_d_cell(middle));
        // 2 c^2 - 2 c^4 = sin^2(2 theta)/2, of which the difference is a product
        let growth = 0.5 * libm::sin(2.0 * (ring[1] + ring[0])) * libm::sin(2.0 * (ring[1] - ring[0]));
        value += f * (2.0 * PI * growth);
    }
    Integral {
        bounded: Bounded {
            value,
            error: value.abs() * 1e-14, // some hundred positive terms
        },
        evaluations: edges.len() as u64 - 1,
    }
}

/// Where f jumps.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Curve {
    /// theta_d = edge of this cell; the parameter is the azimuth psi around o, counted from n.
    Difference(usize),
    /// phi_d = edge of this cell; the parameter is half the difference of the angles at n and at o.
    Azimuth(usize),
    /// x = pi; the parameter is theta_h.
    Plane,
    /// n.i = 0; the parameter tau has theta_h = pi/4 - (theta_o/2) cos tau, smooth where the curve touches x = 0 and pi.
    Horizon,
}

impl Curve {
    fn all() -> impl Iterator<Item = Self> {
        let differences = (1..THETA_D_CELLS).map(Self::Difference);
        let azimuths = (1..PHI_D_CELLS).map(Self::Azimuth);
        differences.chain(azimuths).chain([Self::Plane, Self::Horizon])
    }
}

/// Part of a curve on which no other curve ends it.
#[derive(Debug, Clone, Copy)]
struct Arc {
    curve: Curve,
    from: f64,
    to: f64,
}

impl Place for Arc {
    fn split(self) -> impl IntoIterator<Item = Self> {
        let middle = 0.5 * (self.from + self.to);
        [Self { to: middle, ..self }, Self { from: middle, ..self }]
    }
}

/// A half vector on a curve.
struct Point {
    theta_h: Polar,
    /// Azimuth of h around n, counted from o, in [0, pi], with its sine and cosine.
    x: f64,
    sin_x: f64,
    cos_x: f64,
    /// sin theta_h dtheta_h over the step of the parameter, with the sign that the side has in the sum.
    slope: f64,
}

impl Point {
    fn at(theta_h: Polar, x: f64, slope: f64) -> Self {
        let (sin_x, cos_x) = libm::sincos(x);
        Self {
            theta_h,
            x,
            sin_x,
            cos_x,
            slope,
        }
    }
}

/// The fixed direction o.
struct View {
    mu: f64,
    sin_o: f64,
    theta_o: f64,
    /// sin theta_o/2
    sin_half: f64,
}

impl View {
    fn new(mu: f64) -> Self {
        let polar = Polar::from_cos(mu);
        let theta_o = polar.angle();
        Self {
            mu,
            sin_o: polar.sin,
            theta_o,
            sin_half: libm::sin(0.5 * theta_o),
        }
    }

    /// Calls `add` with the ends of every arc of `curve` that lies above the horizon, and with the cell at its middle.
    ///
    /// The arcs end where the curve meets another one. Candidates that are no meeting points do no harm, and so each
    /// equation contributes all of its solutions.
    fn arcs(&self, curve: Curve, mut add: impl FnMut(f64, f64, [usize; 3])) {
        let (from, to) = self.range(curve);
        let mut ends = Vec::with_capacity(1024);
        self.meetings(curve, |end| {
            if end > from && end < to {
                ends.push(end);
            }
        });
        // three nodes say nothing of a long arc
        let shares = ((to - from) / LONGEST).ceil();
        ends.extend((1..shares as usize).map(|n| from + (to - from) * (n as f64 / shares)));
        ends.push(to);
        ends.sort_unstable_by(f64::total_cmp);
        let mut start = from;
        for end in ends {
            if end > start {
                let point = self.point(curve, 0.5 * (start + end));
                if let Some(cell) = point.and_then(|point| self.cell(curve, &point)) {
                    add(start, end, cell);
                }
            }
            start = end;
        }
    }

    /// The values of the parameter of `curve`.
    fn range(&self, curve: Curve) -> (f64, f64) {
        match curve {
            Curve::Difference(_) | Curve::Horizon => (0.0, PI),
            // at o the angles are 0 and phi_d, at n the other way round
            Curve::Azimuth(k) => (-0.5 * phi_d_edge(k), 0.5 * phi_d_edge(k)),
            Curve::Plane => (0.0, 0.5 * (FRAC_PI_2 - self.theta_o)),
        }
    }

    /// The half vector at `t`, `None` where the curve has none.
    fn point(&self, curve: Curve, t: f64) -> Option<Point> {
        Some(match curve {
            Curve::Difference(j) => {
                let d = Polar::from_angle(theta_d_edge(j));
                let (sin, cos) = libm::sincos(t);
                let along = self.sin_o * d.cos - self.mu * d.sin * cos;
                let across = d.sin * sin;
                let radius = libm::hypot(along, across);
                let theta_h = Polar {
                    sin: radius,
                    cos: self.mu * d.cos + self.sin_o * d.sin * cos,
                };
                Point {
                    theta_h,
                    x: libm::atan2(across, along),
                    sin_x: if radius > 0.0 { across / radius } else { 0.0 },
                    cos_x: if radius > 0.0 { along / radius } else { 1.0 },
                    // theta_d grows with x: its side is an end of the lower cell, and sin theta_h dtheta_h = -dcos theta_h
                    slope: -self.sin_o * d.sin * sin,
                }
            }
            // Delambre's analogies [Todhunter 1886] for the triangle with angles x, psi and pi - phi_d at n, o and h, whose
            // opposite sides are theta_d, theta_h and theta_o: with v = (x - psi)/2, p, q = (theta_d +- theta_h)/2,
            //   sin p cos(phi_d/2) = cos v sin(theta_o/2),  sin q sin(phi_d/2) = sin v sin(theta_o/2),
            //   tan (x + psi)/2 = cos q sin(phi_d/2)/(cos p cos(phi_d/2))
            Curve::Azimuth(k) => {
                let (sin_phi, cos_phi) = libm::sincos(0.5 * phi_d_edge(k));
                let (sin_v, cos_v) = libm::sincos(t);
                let (ratio_p, ratio_q) = (self.sin_half / cos_phi, self.sin_half / sin_phi);
                let (sin_p, sin_q) = (cos_v * ratio_p, sin_v * ratio_q);
                if !(sin_p < 1.0 && sin_q.abs() < 1.0) {
                    return None;
                }
                let (cos_p, cos_q) = (Polar::from_cos(sin_p).sin, Polar::from_cos(sin_q).sin);
                let theta_h = libm::asin(sin_p) - libm::asin(sin_q);
                let theta_h_slope = -sin_v * ratio_p / cos_p - cos_v * ratio_q / cos_q;
                let x = t + libm::atan2(cos_q * sin_phi, cos_p * cos_phi);
                let theta_h = Polar {
                    sin: sin_p * cos_q - cos_p * sin_q,
                    cos: libm::cos(theta_h),
                };
                // for theta_h < theta_o phi_d grows with x, while theta_h falls with v
                Point::at(theta_h, x, theta_h.sin * theta_h_slope)
            }
            Curve::Plane => {
                let theta_h = Polar::from_angle(t);
                Point::at(theta_h, PI, theta_h.sin)
            }
            // n.i = 0 is cos x = -cot theta_o cot 2 theta_h
            Curve::Horizon => {
                let (sin, cos) = libm::sincos(t);
                let theta_h = Polar::from_angle(FRAC_PI_4 - 0.5 * self.theta_o * cos);
                let cos_x = -self.mu / self.sin_o * libm::tan(self.theta_o * cos);
                let x = libm::acos(cos_x.clamp(-1.0, 1.0));
                Point::at(theta_h, x, theta_h.sin * (0.5 * self.theta_o) * sin)
            }
        })
    }

    /// The cell around a half vector; `None` below the horizon.
    fn cell(&self, curve: Curve, point: &Point) -> Option<[usize; 3]> {
        let (s, c) = (point.theta_h.sin, point.theta_h.cos);
        let cos_d = self.mu * c + self.sin_o * s * point.cos_x;
        let above = s >= 0.0 && c > 0.0 && cos_d > 0.0 && 2.0 * cos_d * c > self.mu;
        if !above && curve != Curve::Horizon {
            return None;
        }
        let y = self.sin_o * point.sin_x;
        let phi_d = libm::atan2(y, c * self.sin_o * point.cos_x - s * self.mu);
        Some([
            theta_h_cell(libm::atan2(s, c)),
            theta_d_cell(libm::acos(cos_d.clamp(0.0, 1.0))),
            phi_d_cell(phi_d),
        ])
    }

    /// Calls `end` with the places where `curve` may meet another one.
    fn meetings(&self, curve: Curve, mut end: impl FnMut(f64)) {
        let theta_h_edges = || (1..=THETA_H_CELLS).map(theta_h_edge);
        let theta_d_edges = || (1..=THETA_D_CELLS).map(theta_d_edge);
        let phi_d_edges = || (1..PHI_D_CELLS).map(phi_d_edge);
        match curve {
            Curve::Difference(j) => {
                let d = Polar::from_angle(theta_d_edge(j));
                let horizon = 0.5 * self.mu / d.cos; // n.h where n.i = 0
                for cos_h in theta_h_edges().map(libm::cos).chain([horizon]) {
                    end(libm::acos((cos_h - self.mu * d.cos) / (self.sin_o * d.sin)));
                }
                // cos theta_d cos psi = sin theta_d cot theta_o - sin psi cot(pi - phi_d)
                for (sin_phi, cos_phi) in phi_d_edges().map(libm::sincos) {
                    let (along, across) = (self.sin_o * d.cos * sin_phi, -self.sin_o * cos_phi);
                    solve(along, across, self.mu * d.sin * sin_phi)
                        .into_iter()
                        .for_each(&mut end);
                }
            }
            Curve::Azimuth(k) => {
                let (sin_phi, cos_phi) = libm::sincos(0.5 * phi_d_edge(k));
                let cos_angle = -libm::cos(phi_d_edge(k));
                // cos theta_o = cos theta_d cos theta_h + sin theta_d sin theta_h cos(pi - phi_d)
                let other = |side: f64| {
                    let (sin, cos) = libm::sincos(side);
                    solve(cos, sin * cos_angle, self.mu)
                };
                let mut meet = |theta_d: f64, theta_h: f64| {
                    let (p, q) = (0.5 * (theta_d + theta_h), 0.5 * (theta_d - theta_h));
                    end(libm::atan2(libm::sin(q) * sin_phi, libm::sin(p) * cos_phi));
                };
                for theta_d in theta_d_edges() {
                    other(theta_d).into_iter().for_each(|theta_h| meet(theta_d, theta_h));
                }
                for theta_h in theta_h_edges() {
                    other(theta_h).into_iter().for_each(|theta_d| meet(theta_d, theta_h));
                }
                // n.i = 0 is 2 cos theta_d cos theta_h = cos theta_o, or sin^2 p + sin^2 q = 1/2 + sin^2(theta_o/2)
                let square = self.sin_half * self.sin_half;
                let (by_p, by_q) = ((cos_phi * cos_phi).recip(), (sin_phi * sin_phi).recip());
                let horizon = libm::asin((((0.5 + square) / square - by_p) / (by_q - by_p)).sqrt());
                let extent = libm::acos(cos_phi / self.sin_half);
                [horizon, -horizon, extent, -extent].into_iter().for_each(&mut end);
                // cos^2 p = turn^2 + r^2 sin^2 v with r = sin(theta_o/2)/cos(phi_d/2): where turn is small, for o and h at the
                // horizon, p turns within that width, and is split in steps of its own size
                let ratio = self.sin_half / cos_phi;
                let turn = ((1.0 - ratio) * (1.0 + ratio)).abs().sqrt();
                if turn < FAST {
                    end(0.0);
                    let steps = std::iter::successors(Some(turn.max(1e-9)), |step| Some(4.0 * step));
                    steps.take_while(|step| *step < FAST).for_each(|step| {
                        end(step);
                        end(-step);
                    });
                }
            }
            Curve::Plane => {
                theta_h_edges().for_each(&mut end);
                theta_d_edges().for_each(|theta_d| end(theta_d - self.theta_o));
            }
            Curve::Horizon => {
                let mut meet = |theta_h: f64| end(libm::acos((FRAC_PI_2 - 2.0 * theta_h) / self.theta_o));
                theta_h_edges().for_each(&mut meet);
                theta_d_edges().for_each(|theta_d| meet(libm::acos(0.5 * self.mu / libm::cos(theta_d))));
                // with i = (cos alpha, sin alpha, 0): tan^2 phi_d = 2 sin_o^2 sin^2 alpha/(mu^2 (1 + sin_o cos alpha)) and
                // z = 2 (n.h)^2 = mu^2/(1 + sin_o cos alpha), so that
                //   2 cos^2 phi z^2 + (mu^2 sin^2 phi - 4 cos^2 phi) z + 2 mu^2 cos^2 phi = 0
                let mu_2 = self.mu * self.mu;
                for cos_2 in phi_d_edges().map(|phi| libm::cos(phi).powi(2)) {
                    let middle = mu_2 * (1.0 - cos_2) - 4.0 * cos_2;
                    let root = (middle * middle - 16.0 * mu_2 * cos_2 * cos_2).sqrt();
                    let sum = -0.5 * (middle + root.copysign(middle));
                    for z in [0.5 * sum / cos_2, 2.0 * mu_2 * cos_2 / sum] {
                        meet(libm::acos((0.5 * z).sqrt()));
                    }
                }
            }
        }
    }

    /// int W sin theta_h dtheta_h along an arc.
    fn along(&self, arc: Arc, level: usize) -> Ruled {
        interval(arc.from, arc.to, level, |t| match self.point(arc.curve, t) {
            Some(point) => point.slope * self.azimuth_integral(&point),
            None => 0.0,
        })
    }

    /// W = int_0^x 4 d (2 d c - mu) dx' with d = o.h = m + a cos x'.
    fn azimuth_integral(&self, point: &Point) -> f64 {
        let Point { x, sin_x, cos_x, .. } = *point;
        let c = point.theta_h.cos;
        let (m, a) = (self.mu * c, self.sin_o * point.theta_h.sin);
        let first = m * x + a * sin_x;
        let second = m * first + a * (m * sin_x + 0.5 * a * (x + sin_x * cos_x));
        4.0 * (2.0 * c * second - self.mu * first)
    }
}

/// The solutions t of along cos t + across sin t = level; NaN where there are none.
fn solve(along: f64, across: f64, level: f64) -> [f64; 2] {
    let (middle, reach) = (
        libm::atan2(across, along),
        libm::acos(level / libm::hypot(along, across)),
    );
    [middle - reach, middle + reach]
}

#[cfg(test)]
mod tests;
