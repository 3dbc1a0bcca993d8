//! rho_hh of a half-angle table, deterministically.
//!
//! rho_hh = (1/pi) int int f (n.o)(n.i) do di. In half and difference angles do di = 4 cos theta_d dh dd, and with
//! n.o, n.i = cos theta_h cos theta_d -+ sin theta_h sin theta_d cos phi_d,
//!
//! rho_hh = 16 int sin theta_h dtheta_h int sin theta_d cos theta_d dtheta_d int_0^(pi/2) dphi_d
//!          (f(phi_d) + f(pi - phi_d)) (cos^2 theta_h cos^2 theta_d - sin^2 theta_h sin^2 theta_d cos^2 phi_d)+
//!
//! Cells are boxes in these variables and f is constant in them: a cell above the horizon has a closed form, one below it
//! is 0, and only those that the horizon passes through need a rule, over theta_h and theta_d. It is no integral of
//! rho_hd(mu), which would cost as much for every mu.

use super::IntegrateError;
use super::parts::{Part, Place, Ruled, integrate_parts, interval};
use crate::bxdf::HalfAngle;
use crate::measured::merl::{PHI_D_CELLS, THETA_D_CELLS, THETA_H_CELLS, phi_d_edge, theta_d_edge, theta_h_edge};
use crate::numerics::quadrature::{Bounded, Integral};
use glam::DVec3;
use std::f64::consts::{FRAC_PI_2, PI};

/// Most evaluations of the azimuth integral: some ten seconds.
const LIMIT: u64 = 100_000_000;

/// Relative rounding error of the sum over the cells with a closed form: all terms are positive, each good to some units.
const ROUNDING: f64 = 1e-14;

/// rho_hh with an absolute error of at most `tolerance`.
///
/// # Errors
/// [`IntegrateError::NotConverged`].
pub(super) fn rho_hh(bxdf: &HalfAngle, tolerance: f64) -> Result<Integral, IntegrateError> {
    let half = PHI_D_CELLS / 2;
    // a constant added to f adds pi times itself to rho
    let base = bxdf.mirrored_pair(THETA_H_CELLS / 2, THETA_D_CELLS / 2, half);
    let (mut whole, mut size) = (DVec3::ZERO, DVec3::ZERO);
    let mut parts = Vec::new();
    let cos_2: Vec<f64> = (0..half)
        .map(|k| cos_squared(phi_d_edge(k), phi_d_edge(k + 1)))
        .collect();
    let cos: Vec<f64> = (0..=half).map(|k| libm::cos(phi_d_edge(k))).collect();
    for i in 0..THETA_H_CELLS {
        let theta_h = [theta_h_edge(i), theta_h_edge(i + 1)];
        let (c2_h, s2_h) = half_angle_moments(theta_h);
        for j in 0..THETA_D_CELLS {
            let theta_d = [theta_d_edge(j), theta_d_edge(j + 1)];
            let (c2_d, s2_d) = difference_angle_moments(theta_d);
            // n.o and n.i are positive where tan theta_h tan theta_d cos phi_d < 1
            let least = libm::tan(theta_h[0]) * libm::tan(theta_d[0]);
            let most = if i + 1 == THETA_H_CELLS || j + 1 == THETA_D_CELLS {
                f64::INFINITY
            } else {
                libm::tan(theta_h[1]) * libm::tan(theta_d[1])
            };
            for k in 0..half {
                if least * cos[k + 1] >= 1.0 {
                    continue;
                }
                let weight = bxdf.mirrored_pair(i, j, k) - base;
                if most * cos[k] <= 1.0 {
                    let width = phi_d_edge(k + 1) - phi_d_edge(k);
                    let term = weight * (16.0 * (c2_h * c2_d * width - s2_h * s2_d * cos_2[k]));
                    whole += term;
                    size += term.abs();
                } else if weight != DVec3::ZERO {
                    let phi_d = [phi_d_edge(k), phi_d_edge(k + 1)];
                    let strips = Strip::all(theta_h, theta_d, phi_d);
                    parts.extend(strips.map(|place| Part { place, weight }));
                }
            }
        }
    }
    let mut integral = integrate_parts(parts, tolerance, LIMIT, |place, level| place.ruled(level))?;
    let Bounded { value, error } = &mut integral.bounded;
    *value += whole + (0.5 * PI) * base;
    *error += ROUNDING * size + value.abs() * (4.0 * f64::EPSILON);
    Ok(integral)
}

/// int cos^2 phi dphi.
fn cos_squared(from: f64, to: f64) -> f64 {
    0.5 * ((to - from) + libm::sin(to - from) * libm::cos(to + from))
}

/// int sin theta cos^2 theta dtheta and int sin^3 theta dtheta, the difference of cosines as a product.
fn half_angle_moments([from, to]: [f64; 2]) -> (f64, f64) {
    let (a, b) = (libm::cos(from), libm::cos(to));
    let width = 2.0 * libm::sin(0.5 * (from + to)) * libm::sin(0.5 * (to - from));
    let mean = (a * a + a * b + b * b) / 3.0;
    (width * mean, width * (1.0 - mean))
}

/// int sin theta cos^3 theta dtheta and int sin^3 theta cos theta dtheta, differences as products.
fn difference_angle_moments([from, to]: [f64; 2]) -> (f64, f64) {
    let width = libm::sin(from + to) * libm::sin(to - from); // cos^2 from - cos^2 to
    let cos_2 = 0.5 * (libm::cos(from).powi(2) + libm::cos(to).powi(2));
    (0.5 * width * cos_2, 0.5 * width * (1.0 - cos_2))
}

/// Part of a cell that the horizon passes through, within which it meets the same sides for every theta_d.
///
/// The integrand is smooth on both sides of the curves on which the horizon passes the ends of phi_d,
/// tan theta_h tan theta_d cos phi_d = 1, and smoother than linear across them. A rule over a whole cell does not see a
/// corner that such a curve cuts off, and states no error; so theta_d is split where a curve passes an end of theta_h, and
/// theta_h at the curves.
#[derive(Debug, Clone, Copy)]
struct Strip {
    theta_h: [f64; 2],
    theta_d: [f64; 2],
    phi_d: [f64; 2],
}

impl Place for Strip {
    fn split(self) -> impl IntoIterator<Item = Self> {
        let halves = |[from, to]: [f64; 2]| {
            let middle = 0.5 * (from + to);
            [[from, middle], [middle, to]]
        };
        halves(self.theta_h).into_iter().flat_map(move |theta_h| {
            let strips = move |theta_d| Self::all(theta_h, theta_d, self.phi_d);
            halves(self.theta_d).into_iter().flat_map(strips)
        })
    }
}

impl Strip {
    /// The strips of a cell, those below the horizon left out.
    fn all(theta_h: [f64; 2], theta_d: [f64; 2], phi_d: [f64; 2]) -> impl Iterator<Item = Self> {
        let mut ends = [theta_d[0]; 6];
        for (n, end) in ends[1..5].iter_mut().enumerate() {
            *end = horizon(theta_h[n % 2], phi_d[n / 2]).clamp(theta_d[0], theta_d[1]);
        }
        ends[5] = theta_d[1];
        ends.sort_unstable_by(f64::total_cmp);
        (0..5)
            .map(move |n| Self {
                theta_h,
                theta_d: [ends[n], ends[n + 1]],
                phi_d,
            })
            .filter(|strip| {
                let [from, to] = strip.theta_d;
                to > from && horizon(0.5 * (from + to), strip.phi_d[1]) > strip.theta_h[0]
            })
    }

    /// The product of the rules over theta_h and theta_d of the exact integral over phi_d.
    fn ruled(self, level: usize) -> Ruled {
        let mut evaluations = 0;
        let mut worst: f64 = 0.0;
        let outer = interval(self.theta_d[0], self.theta_d[1], level, |theta_d| {
            let (sin_d, cos_d) = libm::sincos(theta_d);
            // above the horizon for all phi_d up to the first of these, for none from the second on
            let [first, second] = self.phi_d.map(|phi_d| horizon(theta_d, phi_d));
            let [from, to] = self.theta_h;
            let (whole, cut) = ((from, first.min(to)), (first.max(from), second.min(to)));
            let (mut value, mut difference) = (0.0, 0.0);
            for (from, to) in [whole, cut] {
                if from < to {
                    let inner = interval(from, to, level, |theta_h| {
                        self.azimuth_integral(libm::sincos(theta_h), (sin_d, cos_d))
                    });
                    value += inner.value;
                    difference += inner.difference;
                    evaluations += inner.evaluations;
                }
            }
            worst = worst.max(difference);
            value
        });
        let width = self.theta_d[1] - self.theta_d[0];
        Ruled {
            value: outer.value,
            // the outer rule has positive weights, which add up to the width
            difference: outer.difference + width * worst,
            evaluations,
        }
    }

    /// 16 sin theta_h sin theta_d cos theta_d int (c_h^2 c_d^2 - s_h^2 s_d^2 cos^2 phi)+ dphi, which starts at
    /// cos phi = c_h c_d/(s_h s_d).
    fn azimuth_integral(&self, (sin_h, cos_h): (f64, f64), (sin_d, cos_d): (f64, f64)) -> f64 {
        let (product_c, product_s) = (cos_h * cos_d, sin_h * sin_d);
        let start = if product_c >= product_s {
            0.0
        } else {
            libm::acos((product_c / product_s).clamp(0.0, 1.0)).min(FRAC_PI_2)
        };
        let from = self.phi_d[0].max(start);
        let to = self.phi_d[1];
        if from >= to {
            return 0.0;
        }
        let over_phi = product_c * product_c * (to - from) - product_s * product_s * cos_squared(from, to);
        16.0 * sin_h * sin_d * cos_d * over_phi
    }
}

/// The one of theta_h and theta_d that puts the horizon at phi_d, given the other: tan theta_h tan theta_d cos phi_d = 1.
fn horizon(other: f64, phi_d: f64) -> f64 {
    let (sin, cos) = libm::sincos(other);
    libm::atan2(cos, sin * libm::cos(phi_d))
}

#[cfg(test)]
mod tests;
