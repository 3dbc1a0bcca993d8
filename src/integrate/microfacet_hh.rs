//! rho_hh of an isotropic microfacet lobe of V-grooves or without masking, deterministically and for any Fresnel term at once.
//!
//! rho_hh = (1/pi) int int f (n.o)(n.i) do di. With di = 4 (o.h) dh and o in polar coordinates (theta_d, phi_d) around h,
//!
//! rho_hh = int p(h) dh (1/pi) int F(cos theta_d) sin theta_d dtheta_d int min(cos theta_d/(n.h), 2 (n.o), 2 (n.i))+ dphi_d
//!
//! for V-grooves, and cos theta_d/(n.h) where both directions are above the horizon without masking. The cosines are
//! n.o, n.i = (n.h) cos theta_d -+ sin theta_h sin theta_d cos phi_d, so that the inner integral is elementary and F stands
//! outside of it. The variable is delta = pi/2 - theta_d, which is small where narrow lobes lose energy.

use super::IntegrateError;
use super::lobe::{Kink, LobeIntegral, NODE_LIMIT};
use super::segment::Segment;
use crate::bxdf::Microfacet;
use crate::distribution::Isotropic;
use crate::fresnel::{Edge, Fresnel};
use crate::geometry::Polar;
use crate::masking::Masking;
use crate::numerics::quadrature::{Bounded, Integral, NotConverged, Piece, integrate};
use glam::DVec3;
use std::f64::consts::{FRAC_PI_2, FRAC_PI_3, FRAC_PI_4, PI};

/// rho_hh with an absolute error of at most `tolerance`.
pub(super) fn rho_hh(
    microfacet: &Microfacet,
    distribution: &Isotropic,
    tolerance: f64,
) -> Result<Integral, IntegrateError> {
    if microfacet.masking == Masking::VGroove && microfacet.fresnel == Fresnel::None {
        let lost = lost_hh(distribution, tolerance)?;
        return Ok(lost.complement().scaled(microfacet.reflectance.value()));
    }
    let edges = microfacet.fresnel.edges();
    // sin theta_d times the azimuth integral, over pi, is at most 4 in both cases
    integrate_lobe(distribution, &edges, 4.0, tolerance, |theta, allowed| {
        inner(theta, &edges, FRAC_PI_2, allowed, |delta| {
            let theta_d = Polar {
                sin: delta.cos,
                cos: delta.sin,
            };
            let reflectance = microfacet.facet_reflectance_at(theta_d);
            reflectance * (delta.cos * kept(theta, delta, microfacet.masking))
        })
    })
}

/// 1 - rho_hh of grooves with F = R = 1, to an absolute error of at most `tolerance`, free of cancellation.
///
/// Of the facets that wo sees, the light lost is what wi does not see: the azimuth integral of
/// min(cos theta_d/(n.h), 2 (n.o)) less the same with n.i, over the half circle where n.i is the smaller.
pub(super) fn lost_hh(distribution: &Isotropic, tolerance: f64) -> Result<Integral, IntegrateError> {
    integrate_lobe(distribution, &[], 1.0, tolerance, |theta, allowed| {
        let angle = theta.angle();
        // for theta < pi/4 no groove hides anything beyond delta = 2 theta
        let end = if angle < FRAC_PI_4 { 2.0 * angle } else { FRAC_PI_2 };
        inner(theta, &[], end, allowed, |delta| {
            DVec3::splat(delta.cos * hidden(theta, delta))
        })
    })
}

/// The lobe with the angles theta_h at which the segments are ordered anew: pi/4, pi/3, and where a kink in delta passes an
/// edge of the Fresnel term.
fn integrate_lobe(
    distribution: &Isotropic,
    edges: &[Edge],
    bound: f64,
    tolerance: f64,
    inner: impl FnMut(Polar, f64) -> Result<Integral, NotConverged>,
) -> Result<Integral, IntegrateError> {
    let mut kinks = vec![
        Kink {
            theta: Polar::from_angle(FRAC_PI_4),
            below: false,
            above: false,
        },
        Kink {
            theta: Polar::from_angle(FRAC_PI_3),
            below: false,
            above: false,
        },
    ];
    for edge in edges {
        let delta = libm::asin(edge.cos);
        kinks.extend([delta, 0.5 * delta, 0.5 * (PI - delta)].map(|theta| Kink {
            theta: Polar::from_angle(theta),
            below: edge.kink,
            above: edge.kink,
        }));
    }
    LobeIntegral {
        distribution,
        kinks: &kinks,
        end: None,
        bound,
        pole_bound: bound,
        tolerance,
    }
    .integrate(inner)
}

/// Integral over delta in [0, end], split where a kink of the azimuth integral enters at phi_d = 0: at theta, and at
/// 2 theta or pi - 2 theta.
fn inner(
    theta: Polar,
    edges: &[Edge],
    end: f64,
    allowed: f64,
    mut f: impl FnMut(Polar) -> DVec3,
) -> Result<Integral, NotConverged> {
    let angle = theta.angle();
    let mirror = (2.0 * angle).min(PI - 2.0 * angle);
    // entering kinks leave 3/2 powers above them; an edge of F is a square root on its steep side, below delta = asin(edge)
    let mut cuts = vec![(0.0, false), (angle, true), (mirror, true), (end, false)];
    cuts.extend(edges.iter().map(|edge| (libm::asin(edge.cos), edge.kink)));
    cuts.retain(|(cut, _)| *cut <= end);
    cuts.sort_by(|(a, _), (b, _)| a.total_cmp(b));
    let pieces: Vec<Piece> = cuts
        .windows(2)
        .filter(|w| w[1].0 > w[0].0)
        .map(|w| Piece::kinked(w[0].0, w[1].0, w[0].1, w[1].1))
        .collect();
    integrate(&pieces, allowed, NODE_LIMIT, |delta| {
        Bounded::exact(f(Polar::from_angle(delta)))
    })
}

/// (4/pi) times the integral over one quadrant of phi_d of the smaller cosine's branch.
fn kept(theta: Polar, delta: Polar, masking: Masking) -> f64 {
    let (s, c) = (theta.sin, theta.cos);
    let (rise, fall) = (c * delta.sin, (s * delta.cos).max(f64::MIN_POSITIVE));
    let horizon = rise / fall;
    let level = delta.sin / c;
    let pieces = match masking {
        Masking::None => [Segment::clipped(0.0, horizon, 0.0, (level, 0.0)), None],
        // the others have integrators of their own, see `super::deterministic`
        _ => {
            let meet = (rise - 0.5 * level) / fall;
            [
                Segment::clipped(0.0, meet, 0.0, (level, 0.0)),
                Segment::clipped(meet, horizon, 0.0, (2.0 * rise, -2.0 * fall)),
            ]
        }
    };
    4.0 * pieces
        .into_iter()
        .flatten()
        .map(|segment| segment.azimuth_mean())
        .sum::<f64>()
}

/// (2/pi) times the integral over one quadrant of what wo sees and wi does not.
fn hidden(theta: Polar, delta: Polar) -> f64 {
    let (s, c) = (theta.sin, theta.cos);
    let (rise, slope) = (c * delta.sin, (s * delta.cos).max(f64::MIN_POSITIVE));
    let level = delta.sin / c;
    // level - 2 rise = sin delta (1 - 2 c^2)/c without the difference of near-equal terms
    let gap = delta.sin * (s - c) * (s + c) / c;
    let meet = 0.5 * gap / slope;
    let horizon = rise / slope;
    let mut cuts = [0.0, meet.abs().min(1.0), horizon.min(1.0), 1.0];
    cuts.sort_by(f64::total_cmp);
    let line = |x: f64| {
        let seen_by_o = if x >= meet {
            (level, 0.0)
        } else {
            (2.0 * rise, 2.0 * slope)
        };
        let level_for_i = x <= -meet;
        if x >= horizon {
            seen_by_o
        } else if level_for_i {
            (0.0, 0.0) // then x >= meet too: both see the whole wall
        } else if x >= meet {
            (gap, 2.0 * slope)
        } else {
            (0.0, 4.0 * slope)
        }
    };
    let pieces = cuts
        .windows(2)
        .filter_map(|w| Segment::clipped(w[0], w[1], 0.0, line(0.5 * (w[0] + w[1]))));
    2.0 * pieces.map(|segment| segment.azimuth_mean()).sum::<f64>()
}
