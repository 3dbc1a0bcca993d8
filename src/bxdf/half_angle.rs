//! A measured isotropic BRDF, tabulated over half and difference angles [pbrt 2010, section 8.6.2].

use super::{Bxdf, BxdfSample, Flags, cosine_hemisphere};
use crate::geometry::{Polar, half_vector, reflect};
use crate::measured::merl::{self, MerlTable, PHI_D_CELLS, THETA_D_CELLS, THETA_H_CELLS};
use crate::spectrum::Channels;
use glam::DVec3;
use std::f64::consts::{FRAC_1_PI, TAU};
use std::sync::Arc;

/// f is the value of the cell that (theta_h, theta_d, phi_d) falls into, constant within a cell.
///
/// Three things differ from the printed lookup. Where h points below the surface both directions are turned over with it;
/// phi_d is folded to [0, pi]; and f = 0 across hemispheres, where the printed one looks up whatever h there is. All angles
/// come from s = wo + wi and d = wo - wi, of which the exchange of the directions only changes the sign of d: f(wo, wi) and
/// f(wi, wo) agree to the last bit.
///
/// Where one of the directions is the normal, phi_d is on the seam between its first and its last cell for every other
/// direction. f is the mean of the two there, the limit of what all azimuths see on the way to the normal; with either of
/// them alone rho_hd would jump at mu = 1.
#[derive(Debug, Clone, PartialEq)]
pub struct HalfAngle {
    table: Arc<MerlTable>,
    rings: Arc<Rings>,
}

impl HalfAngle {
    /// The BRDF of `table`, with the density of half vectors that [`Bxdf::sample_f`] draws from.
    pub fn new(table: Arc<MerlTable>) -> Self {
        let rings = Arc::new(Rings::new(&table));
        Self { table, rings }
    }

    /// The table.
    pub fn table(&self) -> &MerlTable {
        &self.table
    }

    /// f at phi_d plus f at pi - phi_d, for phi_d in cell `k`: what two half vectors see that mirror each other in the plane
    /// of incidence.
    pub(crate) fn mirrored_pair(&self, i: usize, j: usize, k: usize) -> DVec3 {
        self.table.at(i, j, k) + self.table.at(i, j, PHI_D_CELLS - 1 - k)
    }

    /// The value at phi_d = 0 and pi, where the first and the last cell meet.
    pub(crate) fn at_seam(&self, i: usize, j: usize) -> DVec3 {
        0.5 * (self.table.at(i, j, 0) + self.table.at(i, j, PHI_D_CELLS - 1))
    }

    /// The cell value for two directions that are not below the surface; 0 for opposite ones, which have no half vector.
    ///
    /// theta_h is the polar angle of s, tan theta_d = |d|/|s|. wo projected on y_h and x_h, the axes of azimuth around h,
    /// both times |s_xy| |s|: |s| (s_x d_y - s_y d_x)/2 and (s_z s_xy.d_xy - d_z s_xy.s_xy)/2; those of wi are the
    /// negatives, which folding makes the same.
    fn lookup(&self, wo: DVec3, wi: DVec3) -> DVec3 {
        let (s, d) = (wo + wi, wo - wi);
        // phi_d is made of products of two components of s, which underflow where the directions are almost opposite
        let scale = if s.abs().max_element() < 1e-140 {
            2f64.powi(500)
        } else {
            1.0
        };
        let s = s * scale;
        let radius = libm::hypot(s.x, s.y);
        let length = s.length();
        if length == 0.0 {
            return DVec3::ZERO;
        }
        let i = merl::theta_h_cell(libm::atan2(radius, s.z));
        let j = merl::theta_d_cell(libm::atan2(d.length(), length / scale));
        let normal = |w: DVec3| w.x == 0.0 && w.y == 0.0;
        if normal(wo) || normal(wi) {
            return self.at_seam(i, j);
        }
        let y = length * (s.x * d.y - s.y * d.x);
        let x = s.z * (s.x * d.x + s.y * d.y) - d.z * (radius * radius);
        let phi_d = if y == 0.0 {
            0.0 // and pi, which folds to it
        } else if y < 0.0 {
            libm::atan2(-y, -x)
        } else {
            libm::atan2(y, x)
        };
        self.table.at(i, j, merl::phi_d_cell(phi_d))
    }
}

/// Both directions turned over where they lie below the surface, wo deciding where wi is at the horizon.
fn above(wo: DVec3, wi: DVec3) -> (DVec3, DVec3) {
    if wo.z + wi.z < 0.0 { (-wo, -wi) } else { (wo, wi) }
}

impl Bxdf for HalfAngle {
    fn channels(&self) -> Channels {
        self.table.channels()
    }

    fn flags(&self) -> Flags {
        Flags::REFLECTION | Flags::GLOSSY
    }

    fn f(&self, wo: DVec3, wi: DVec3) -> DVec3 {
        let (wo, wi) = above(wo, wi);
        if wo.z < 0.0 || wi.z < 0.0 {
            return DVec3::ZERO;
        }
        self.lookup(wo, wi)
    }

    /// Half of it cos theta/pi, half of it p(h)/(4 o.h), also where that h mirrors wo to below the surface.
    fn pdf(&self, wo: DVec3, wi: DVec3) -> f64 {
        let (wo, wi) = if wo.z < 0.0 { (-wo, -wi) } else { (wo, wi) };
        let cosine = wi.z.max(0.0) * FRAC_1_PI;
        let Some(half) = half_vector(wo, wi) else {
            return (1.0 - HALF_VECTOR_SHARE) * cosine;
        };
        // h and -h mirror alike: the one that was drawn is the upper one
        let theta_h = libm::atan2(libm::hypot(half.wh.x, half.wh.y), half.wh.z.abs());
        let mirrored = self.rings.density(theta_h) / (4.0 * half.cos_d);
        HALF_VECTOR_SHARE * mirrored + (1.0 - HALF_VECTOR_SHARE) * cosine
    }

    fn sample_f(&self, wo: DVec3, u: [f64; 3]) -> BxdfSample {
        if wo.z < 0.0 {
            let above = self.sample_f(-wo, u);
            return BxdfSample { wi: -above.wi, ..above };
        }
        let wi = if u[2] < HALF_VECTOR_SHARE {
            reflect(wo, self.rings.draw(u[0]).direction(TAU * u[1])).normalize()
        } else {
            cosine_hemisphere([u[0], u[1]])
        };
        let pdf = self.pdf(wo, wi);
        if !(pdf > 0.0 && pdf.is_finite()) {
            return BxdfSample::lost(wi);
        }
        BxdfSample {
            wi,
            pdf,
            weight: self.f(wo, wi) * (wi.z.abs() / pdf),
            flags: self.flags(),
        }
    }
}

/// Probability of drawing a half vector; the cosine lobe takes the rest and keeps the weight of what the rings miss bounded.
const HALF_VECTOR_SHARE: f64 = 0.5;

/// Density of half vectors: constant over solid angle in each ring of theta_h, uniform in azimuth.
#[derive(Debug, PartialEq)]
struct Rings {
    /// Where each ring starts in the distribution function, and 1.
    starts: [f64; THETA_H_CELLS + 1],
    /// sr^-1.
    densities: [f64; THETA_H_CELLS],
}

impl Rings {
    /// Rings with the share of the reflected light that the table has in them, were all of it above the horizon:
    /// int f (n.o)(n.i) do di, of which do di = 4 cos theta_d dh dd, with n.o and n.i replaced by their mean over phi_d,
    /// cos theta_h cos theta_d.
    ///
    /// Only the noise of the estimate depends on how well this describes the lobe, not its mean.
    fn new(table: &MerlTable) -> Self {
        let ring_weights = (0..THETA_H_CELLS).map(|i| {
            let mean: f64 = (0..THETA_D_CELLS)
                .map(|j| {
                    let sum: f64 = (0..PHI_D_CELLS).map(|k| table.at(i, j, k).element_sum()).sum();
                    let (from, to) = (libm::cos(merl::theta_d_edge(j)), libm::cos(merl::theta_d_edge(j + 1)));
                    sum * (from.powi(4) - to.powi(4))
                })
                .sum();
            let (from, to) = (Self::edge(i).cos, Self::edge(i + 1).cos);
            mean * (from.powi(3) - to.powi(3))
        });
        let mut weights: Vec<f64> = ring_weights.collect();
        let mut total: f64 = weights.iter().sum();
        // a table of zeros, or of values too small to add up
        if total <= f64::MIN_POSITIVE {
            weights = (0..THETA_H_CELLS).map(Self::solid_angle).collect();
            total = TAU;
        }
        let (mut starts, mut densities) = ([0.0; THETA_H_CELLS + 1], [0.0; THETA_H_CELLS]);
        for (i, weight) in weights.iter().enumerate() {
            starts[i + 1] = starts[i] + weight / total;
        }
        let end = starts[THETA_H_CELLS];
        starts.iter_mut().for_each(|start| *start /= end);
        for i in 0..THETA_H_CELLS {
            densities[i] = (starts[i + 1] - starts[i]) / Self::solid_angle(i);
        }
        Self { starts, densities }
    }

    /// The angle at which ring `i` starts.
    fn edge(i: usize) -> Polar {
        Polar::from_angle(merl::theta_h_edge(i))
    }

    fn solid_angle(i: usize) -> f64 {
        TAU * Self::versines(i).1
    }

    /// 1 - cos theta at the start of ring `i`, and what it grows by.
    fn versines(i: usize) -> (f64, f64) {
        let start = Self::edge(i).versine();
        (start, Self::edge(i + 1).versine() - start)
    }

    /// p(h) in sr^-1.
    fn density(&self, theta_h: f64) -> f64 {
        self.densities[merl::theta_h_cell(theta_h)]
    }

    /// The polar angle of a half vector; u in [0, 1).
    fn draw(&self, u: f64) -> Polar {
        let i = self.starts[1..THETA_H_CELLS].partition_point(|start| *start <= u);
        let share = ((u - self.starts[i]) / (self.starts[i + 1] - self.starts[i])).clamp(0.0, 1.0);
        let (start, growth) = Self::versines(i);
        let versine = start + growth * share;
        Polar::from_versine(versine, 1.0 - versine)
    }
}

#[cfg(test)]
mod tests;
