//! rho_hd and rho_hh of facets that stand off the surface, deterministically.
//!
//! Their maskings are functions of n.o and n.i alone, and so the cosine of wi is the outer variable:
//!
//! rho_hd(o) = int_0^1 (n.i) V(o, i) A(o, i) d(n.i), A = 2 int_0^pi D(h) F(o.h) ddelta,
//!
//! where delta = 0 is where the tangential parts of both directions are opposite. With t^2 = |tangential part of o + i|^2,
//!
//! t^2 = ((n.i)^2 - (n.o)^2)^2/(sin_o + sin_i)^2 + 4 sin_o sin_i sin^2(delta/2), 4 (o.h)^2 = t^2 + (n.o + n.i)^2,
//!
//! sin^2 theta_h = t^2/(t^2 + (n.o + n.i)^2), and nothing cancels from the normal to the horizon. What the maskings have of
//! logarithms, powers and curvatures is in the outer variable, whose pieces are logarithmic, with the scales of n.o and of
//! the lobe split off; D rises from 0 around delta = 0 in a layer as wide as n.o + n.i.

mod azimuth;

use super::IntegrateError;
use super::hemisphere::Mean;
use super::lobe::{Kink, NODE_LIMIT, pieces};
use crate::bxdf::Microfacet;
use crate::distribution::Charlie;
use crate::fresnel::{Edge, Fresnel};
use crate::geometry::Polar;
use crate::masking::{Fit, HALF, Masking, neubelt};
use crate::numerics::quadrature::{Bounded, Integral, NotConverged, Piece, integrate};
use azimuth::Azimuth;
use glam::DVec3;
use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// Shares of the tolerance: what is cut off at the horizon, what the inner integrals may leave, and the rest for the outer one.
const HORIZON_SHARE: f64 = 0.05;
const INNER_SHARE: f64 = 0.35;
const OUTER_SHARE: f64 = 0.6;

/// rho_hd at cos theta_o = `mu`, with an absolute error of at most `tolerance`.
pub(super) fn rho_hd(
    microfacet: &Microfacet,
    charlie: &Charlie,
    mu: f64,
    tolerance: f64,
) -> Result<Integral, IntegrateError> {
    let sheen = Sheen {
        microfacet,
        charlie,
        fit: Fit::new(charlie.alpha()),
        mu,
        sin_o: Polar::from_cos(mu).sin,
        edges: microfacet.fresnel.edges(),
    };
    sheen.integrate(tolerance)
}

/// rho_hh with an absolute error of at most `tolerance`.
pub(super) fn rho_hh(microfacet: &Microfacet, charlie: &Charlie, tolerance: f64) -> Result<Integral, IntegrateError> {
    let mut marks = vec![
        (charlie.alpha().sqrt(), false),
        (HALF, false),
        (Fit::new(charlie.alpha()).least(), false),
    ];
    marks.extend(microfacet.fresnel.edges().iter().map(|edge| (edge.cos, edge.kink)));
    Mean {
        marks: &marks,
        anisotropic: false,
        bound: bound(charlie),
        grows: false,
    }
    .integrate(tolerance, |mu, _, allowed| rho_hd(microfacet, charlie, mu, allowed))
}

/// Bound of A/2, which is one of rho: (n.i) V is at most 1/4 under `neubelt` and 1/(4 (n.o)(1 + Lambda)), below 1/2, under
/// `charlie`; and D is at most (2 + 1/alpha)/(2 pi).
fn bound(charlie: &Charlie) -> f64 {
    0.5 * (2.0 + charlie.exponent())
}

/// A lobe seen from one direction.
struct Sheen<'a> {
    microfacet: &'a Microfacet,
    charlie: &'a Charlie,
    fit: Fit,
    mu: f64,
    sin_o: f64,
    edges: Vec<Edge>,
}

impl Sheen<'_> {
    fn integrate(&self, allowed: f64) -> Result<Integral, IntegrateError> {
        let least = (HORIZON_SHARE * allowed / bound(self.charlie)).min(0.25);
        let mut cuts: Vec<(f64, Kink)> = self
            .marks()
            .into_iter()
            .filter(|(i, _)| *i > least && *i < 1.0)
            .map(|(i, kink)| (i, Kink::between_pieces(kink)))
            .collect();
        cuts.extend([least, 1.0].map(|end| (end, Kink::between_pieces(false))));
        cuts.sort_by(|(a, _), (b, _)| a.total_cmp(b));
        let outer: Vec<Piece> = cuts
            .windows(2)
            .filter(|w| w[1].0 > w[0].0)
            .flat_map(|w| pieces(w[0], w[1]))
            .map(Piece::careful)
            .collect();
        let mut evaluations = 0;
        let mut failure = None;
        let integral = integrate(&outer, OUTER_SHARE * allowed, NODE_LIMIT, |i| {
            let kernel = self.kernel(i);
            // the range of n.i is shorter than 1
            match self.around(i, INNER_SHARE * allowed / kernel) {
                Ok(integral) => {
                    evaluations += integral.evaluations;
                    integral.bounded.scaled(kernel)
                }
                Err(error) => {
                    failure.get_or_insert(error);
                    Bounded::exact(DVec3::NAN)
                }
            }
        });
        match (failure, integral) {
            (Some(error), _) | (None, Err(error)) => Err(error.into()),
            (None, Ok(mut integral)) => {
                integral.bounded.error += DVec3::splat(HORIZON_SHARE * allowed);
                Ok(Integral {
                    evaluations,
                    ..integral
                })
            }
        }
    }

    /// Cosines n.i at which A or V changes its behaviour: that of wo, where the mirror image of wo is the pole, in which sin^n
    /// has a cone; the scale of the lobe; where the branches of Lambda meet; and
    /// where an edge of F appears.
    fn marks(&self) -> Vec<(f64, bool)> {
        let width = self.charlie.alpha().sqrt();
        let scales = [width, 4.0 * width, HALF, self.fit.least()].map(|i| (i, false));
        let mut marks = vec![(self.mu, true)];
        marks.extend(scales);
        let theta_o = libm::atan2(self.sin_o, self.mu);
        for edge in &self.edges {
            let double = 2.0 * libm::acos(edge.cos);
            let angles = [theta_o + double, (theta_o - double).abs()].into_iter();
            marks.extend(
                angles
                    .filter(|theta| *theta < FRAC_PI_2)
                    .map(|theta| (libm::cos(theta), edge.kink)),
            );
        }
        marks
    }

    /// (n.i) V.
    fn kernel(&self, i: f64) -> f64 {
        match self.microfacet.masking {
            Masking::Charlie => i * self.fit.visibility(self.mu, i),
            _ => i * neubelt(self.mu, i),
        }
    }

    /// A at n.i = `i`.
    fn around(&self, i: f64, allowed: f64) -> Result<Integral, NotConverged> {
        let sin_i = Polar::from_cos(i).sin;
        let product = self.sin_o * sin_i;
        let sum = self.mu + i;
        let apart = if self.sin_o + sin_i > 0.0 {
            (i - self.mu) * sum / (self.sin_o + sin_i)
        } else {
            0.0
        };
        let n = self.charlie.exponent();
        let peak = 2.0 * (n + 2.0) / TAU;
        if self.microfacet.fresnel == Fresnel::None {
            let near = apart * apart;
            let azimuth = Azimuth {
                near,
                far: near + 4.0 * product,
                square: sum * sum,
                power: 0.5 * n,
            };
            let around = azimuth.integral(allowed / peak)?;
            let bounded = Bounded {
                value: DVec3::splat(peak * around.value),
                error: DVec3::splat(peak * around.error),
            };
            let whole = Integral {
                bounded,
                evaluations: around.evaluations,
            };
            return Ok(whole.scaled(self.microfacet.reflectance.value()));
        }
        let root = product.sqrt();
        // |delta| where both terms of t^2 are equal, where t = n.o + n.i, and where D has risen
        let scales = [apart.abs(), sum, sum * n.sqrt()].map(|scale| (scale / root, false));
        let edges = self.edges.iter().filter_map(|edge| {
            let square = (4.0 * edge.cos * edge.cos - sum * sum - apart * apart) / (4.0 * product);
            (square > 0.0 && square < 1.0).then(|| (2.0 * libm::asin(square.sqrt()), edge.kink))
        });
        let mut cuts: Vec<(f64, Kink)> = scales
            .into_iter()
            .chain(edges)
            .filter(|(delta, _)| *delta > 0.0 && *delta < PI)
            .map(|(delta, kink)| (delta, Kink::between_pieces(kink)))
            .collect();
        cuts.extend([0.0, PI].map(|end| (end, Kink::between_pieces(false))));
        cuts.sort_by(|(a, _), (b, _)| a.total_cmp(b));
        let inner: Vec<Piece> = cuts
            .windows(2)
            .filter(|w| w[1].0 > w[0].0)
            .flat_map(|w| pieces(w[0], w[1]))
            .collect();
        // sin(theta_o - theta_i)^2/(1 + cos(theta_o - theta_i)), the versine of the smallest angle between the directions
        let closest = self.sin_o * i - self.mu * sin_i;
        let closest = closest * closest / (1.0 + self.mu * i + product);
        integrate(&inner, allowed, NODE_LIMIT, |delta| {
            let (sin, cos) = libm::sincos(0.5 * delta);
            let square = apart * apart + 4.0 * product * sin * sin;
            let density = libm::exp(-0.5 * n * libm::log1p(sum * sum / square));
            let theta_d = Polar {
                sin: (0.5 * closest + product * cos * cos).sqrt().min(1.0),
                cos: (0.5 * libm::sqrt(square + sum * sum)).min(1.0),
            };
            Bounded::exact(self.microfacet.facet_reflectance_at(theta_d) * (peak * density))
        })
    }
}
