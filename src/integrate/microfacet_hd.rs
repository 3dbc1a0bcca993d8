//! rho_hd of an isotropic microfacet lobe of V-grooves or without masking, deterministically.
//!
//! rho_hd(o) = int p(h) F(o.h) w(h) dh over o.h > 0 and n.i > 0, with the weight w of [`Masking::weight`]. For a fixed
//! theta_h everything that w is made of is linear in x = cos phi: o.h = (n.o) cos theta_h (1 + tau x) with
//! tau = tan theta_o tan theta_h. So is w itself between kinks: with t = (o.h)/((n.o)(n.h)) it is the smallest of
//! t, 2 and 2 (2 cos^2 theta_h t - 1), and 0 below n.i = 0.
//!
//! - For F = 1 the azimuth integral is elementary and rho is a one-dimensional integral over theta_h.
//! - Otherwise each segment is integrated over phi on its own.
//! - In theta_h the pattern of segments changes where a kink enters or leaves at phi = 0 or pi. Those are angles in the
//!   plane of incidence, simple fractions of the elevation beta = pi/2 - theta_o.

use super::IntegrateError;
use super::lobe::{Kink, LobeIntegral, NODE_LIMIT};
use super::segment::{Place, Segment, azimuth_mean, mean_between};
use super::unbounded::UNMASKED;
use crate::bxdf::Microfacet;
use crate::distribution::Isotropic;
use crate::fresnel::{Edge, Fresnel};
use crate::geometry::Polar;
use crate::masking::Masking;
use crate::numerics::quadrature::{Bounded, Integral, NotConverged, Piece, integrate};
use glam::DVec3;
use std::f64::consts::{FRAC_1_PI, FRAC_PI_2, FRAC_PI_4, PI};

/// rho_hd at cos theta_o = `mu`, with an absolute error of at most `tolerance`.
pub(super) fn rho_hd(
    microfacet: &Microfacet,
    distribution: &Isotropic,
    mu: f64,
    tolerance: f64,
) -> Result<Integral, IntegrateError> {
    // the reciprocal of a subnormal number is infinite
    let mu = if mu < f64::MIN_POSITIVE { 0.0 } else { mu };
    let grooves = microfacet.masking == Masking::VGroove;
    if !grooves && mu == 0.0 {
        return Err(IntegrateError::Diverges(UNMASKED));
    }
    let azimuth = Azimuth::new(mu, microfacet.masking);
    let edges = microfacet.fresnel.edges();
    let kinks = kinks(mu, microfacet.masking, &edges);
    let lobe = LobeIntegral {
        distribution,
        kinks: &kinks,
        end: (mu > 0.0).then(|| at_elevation(0.5 * libm::asin(mu))),
        // w <= 2 for grooves; unmasked (n.o) t <= n.o + tan theta_h, largest at the end
        bound: if grooves { 2.0 } else { 2.0 + 2.0 / mu },
        pole_bound: 2.0,
        tolerance,
    };
    if !grooves {
        return unmasked(microfacet, mu, &azimuth, &edges, lobe);
    }
    match microfacet.fresnel {
        Fresnel::None => {
            // what is lost, 1 - rho, keeps its digits where rho is close to 1
            let whole = LobeIntegral { end: None, ..lobe };
            let lost = whole.integrate(|theta, _| Ok(one(DVec3::splat(azimuth.lost(theta)))))?;
            Ok(lost.complement().scaled(microfacet.reflectance.value()))
        }
        _ => lobe.integrate(|theta, allowed| azimuth.reflected(theta, microfacet, &edges, allowed)),
    }
}

/// Without masking rho grows like 1/mu: mu rho is what is integrated, to as many digits as rho can have.
fn unmasked(
    microfacet: &Microfacet,
    mu: f64,
    azimuth: &Azimuth,
    edges: &[Edge],
    lobe: LobeIntegral,
) -> Result<Integral, IntegrateError> {
    // mu rho is at least about a fifth of the width of the lobe
    let tolerance = (lobe.tolerance * mu).max(ROUNDING * microfacet.distribution.width());
    let lobe = LobeIntegral { tolerance, ..lobe };
    let product = match microfacet.fresnel {
        Fresnel::None => {
            let integral = lobe.integrate(|theta, _| Ok(one(DVec3::splat(azimuth_mean(azimuth.segments(theta))))))?;
            integral.scaled(microfacet.reflectance.value())
        }
        _ => lobe.integrate(|theta, allowed| azimuth.reflected(theta, microfacet, edges, allowed))?,
    };
    let bounded = Bounded {
        value: product.bounded.value / mu,
        error: product.bounded.error / mu,
    };
    if bounded.value.is_finite() && bounded.error.is_finite() {
        Ok(Integral { bounded, ..product })
    } else {
        Err(IntegrateError::Diverges(UNMASKED))
    }
}

/// Error of mu rho, relative to the width of the lobe, below which no tolerance asks: the rounding of F and of some hundred
/// terms, with a margin.
const ROUNDING: f64 = 1e-13;

fn one(value: DVec3) -> Integral {
    Integral {
        bounded: Bounded::exact(value),
        evaluations: 1,
    }
}

/// Angles theta_h at which the segments of the azimuth change.
///
/// With all directions in the plane of incidence: n.i = 0 at beta/2 and pi/2 - beta/2; o.h = 2 (n.h)(n.o) at beta;
/// o.h = 2 (n.h)(n.i) at beta/3 and (pi - beta)/3; n.i = n.o at theta_o. A kink that enters the circle there leaves
/// 3/2 powers on its far side, one that leaves it on the near side. At pi/4 the branch o.h gives way to the others, without
/// such powers. An edge of the Fresnel term at the facet angle theta_e is reached at |theta_o - theta_e| and
/// theta_o + theta_e, where its square root integrates to logarithms, and it crosses the kinks n.i = 0,
/// o.h = 2 (n.h)(n.i), o.h = 2 (n.h)(n.o) and n.i = n.o, where half powers remain on both sides. Without masking w grows
/// like 1/(n.h) until n.h is of the order of mu: the approach is split too.
fn kinks(mu: f64, masking: Masking, edges: &[Edge]) -> Vec<Kink> {
    let beta = libm::asin(mu);
    let theta_o = FRAC_PI_2 - beta;
    let enters = |theta| Kink {
        theta: Polar::from_angle(theta),
        below: false,
        above: true,
    };
    let leaves = |theta| Kink {
        theta,
        below: true,
        above: false,
    };
    let passes = |theta| Kink {
        theta,
        below: false,
        above: false,
    };
    let at = Polar::from_angle;
    let mut kinks = vec![
        enters(beta / 3.0),
        enters(beta / 2.0),
        enters(beta),
        passes(at(FRAC_PI_4)),
    ];
    kinks.push(leaves(if beta > FRAC_PI_4 {
        at((PI - beta) / 3.0)
    } else {
        Polar::from_cos(mu)
    }));
    kinks.push(leaves(at_elevation(beta / 2.0)));
    if masking == Masking::None {
        let approach = [8.0, 64.0].map(|times| times * beta);
        kinks.extend(
            approach
                .into_iter()
                .filter(|b| *b < FRAC_PI_4)
                .map(|b| passes(at_elevation(b))),
        );
    }
    for edge in edges {
        let theta_e = libm::acos(edge.cos);
        let reached = [(theta_o - theta_e).abs(), theta_o + theta_e];
        kinks.extend(reached.map(|theta| Kink {
            theta: at(theta),
            below: edge.kink,
            above: edge.kink,
        }));
        if edge.kink {
            // close to the normal both are one square root from afar
            let distances = std::iter::successors(Some(theta_o), |d| Some(6.0 * d));
            let near = distances.take_while(|d| theta_o > 1e-7 && *d < 0.1).skip(1);
            kinks.extend(near.flat_map(|d| [passes(at(theta_e - d)), passes(at(theta_e + d))]));
            let root = (mu * mu + 4.0 * edge.cos * edge.cos).sqrt();
            let crossings = [
                0.5 * mu / edge.cos,
                0.25 * (mu + root) / edge.cos,
                0.5 * edge.cos / mu,
                mu / edge.cos,
            ];
            kinks.extend(crossings.into_iter().filter(|c| *c < 1.0).map(|c| Kink {
                theta: Polar::from_cos(c),
                below: true,
                above: true,
            }));
        }
    }
    kinks.retain(|kink| kink.theta.sin > 0.0 && kink.theta.cos > 0.0);
    kinks
}

/// The polar angle pi/2 - beta with all digits of its cosine.
fn at_elevation(beta: f64) -> Polar {
    let elevation = Polar::from_angle(beta);
    Polar {
        sin: elevation.cos,
        cos: elevation.sin,
    }
}

/// The azimuth integral around the normal for a fixed wo.
struct Azimuth {
    mu: f64,
    sin_o: f64,
    masking: Masking,
}

impl Azimuth {
    fn new(mu: f64, masking: Masking) -> Self {
        // at normal incidence x has no meaning; any positive sine puts every kink outside [-1, 1]
        let sin_o = Polar::from_cos(mu).sin.max(1e-150);
        Self { mu, sin_o, masking }
    }

    /// s sin theta_o, the amplitude of o.h around its mean.
    fn amplitude(&self, theta: Polar) -> f64 {
        (theta.sin * self.sin_o).max(f64::MIN_POSITIVE)
    }

    /// tan theta_o tan theta_h, possibly infinite.
    fn tau(&self, theta: Polar) -> f64 {
        self.amplitude(theta) / (self.mu * theta.cos)
    }

    /// The kinks in x: where n.i = 0, where the branch 2 (2 c^2 t - 1) ends, and where the branch 2 begins.
    fn breaks(&self, theta: Polar) -> [f64; 3] {
        let (s, c) = (theta.sin, theta.cos);
        let unit = self.mu / self.amplitude(theta);
        let cos_2 = (c - s) * (c + s);
        let horizon = -unit * cos_2 / (2.0 * c);
        if cos_2 > 0.0 {
            // t crosses the rising branch at 2 c/(4 c^2 - 1) and the constant one at 2 c
            let square = 4.0 * c * c;
            [horizon, unit * c * (3.0 - square) / (square - 1.0), unit * c]
        } else {
            let level = unit * s * s / c;
            [horizon, level, level]
        }
    }

    /// F = 1: the segments of w, and of (n.o) w without masking; those with w = 0 left out.
    fn segments(&self, theta: Polar) -> impl Iterator<Item = Segment> + use<> {
        let tau = self.tau(theta);
        let [horizon, rising, level] = self.breaks(theta);
        let c2 = theta.cos * theta.cos;
        let cos_2 = (theta.cos - theta.sin) * (theta.cos + theta.sin);
        let candidates = if self.mu == 0.0 {
            [(0.0, 1.0, (2.0, 0.0)), (1.0, 1.0, (0.0, 0.0)), (1.0, 1.0, (0.0, 0.0))]
        } else if self.masking == Masking::None {
            [
                (horizon, 1.0, (self.mu, self.amplitude(theta) / theta.cos)),
                (1.0, 1.0, (0.0, 0.0)),
                (1.0, 1.0, (0.0, 0.0)),
            ]
        } else {
            [
                (horizon, rising, (2.0 * cos_2, 4.0 * c2 * tau)),
                (rising, level, (1.0, tau)),
                (level, 1.0, (2.0, 0.0)),
            ]
        };
        candidates
            .into_iter()
            .filter_map(|(from, to, line)| Segment::clipped(from, to, -1.0, line))
    }

    /// F = 1 and grooves: 1 - W, where W is the azimuth mean of w.
    ///
    /// The mean of t over the circle is 1, so 1 - W is also the mean of t - w, whose segments do not cancel as long as
    /// t stays positive, tau <= 1; it vanishes exactly where no kink is on the circle.
    fn lost(&self, theta: Polar) -> f64 {
        let tau = self.tau(theta);
        if tau > 1.0 {
            return 1.0 - azimuth_mean(self.segments(theta));
        }
        let [horizon, rising, level] = self.breaks(theta);
        let [horizon, rising, level] = [horizon, rising.max(horizon), level].map(Place::at);
        let square = 4.0 * theta.cos * theta.cos;
        mean_between(Place::FIRST, horizon, (1.0, tau))
            + mean_between(horizon, rising, (3.0 - square, tau * (1.0 - square)))
            + mean_between(level, Place::LAST, (-1.0, tau))
    }

    /// Any F: (1/pi) int R F(o.h) w dphi, segment by segment.
    fn reflected(
        &self,
        theta: Polar,
        microfacet: &Microfacet,
        edges: &[Edge],
        allowed: f64,
    ) -> Result<Integral, NotConverged> {
        let (mean, amplitude) = (self.mu * theta.cos, self.amplitude(theta));
        let edges: Vec<(f64, bool)> = edges
            .iter()
            .map(|edge| ((edge.cos - mean) / amplitude, edge.kink))
            .collect();
        let mut pieces = Vec::with_capacity(8);
        let mut lines: Vec<Segment> = Vec::with_capacity(4);
        let mut skipped = 0.0;
        for segment in self.segments(theta) {
            // without F the segment is known exactly, and F is between 0 and 1
            let most = segment.azimuth_mean().max(0.0);
            if skipped + most <= SKIPPED_SHARE * allowed {
                skipped += most;
                continue;
            }
            let thin = most <= THIN_FACTOR * allowed;
            let (from, to) = segment.psi();
            let inside = edges.iter().filter(|(x, _)| *x > segment.from && *x < segment.to);
            let mut start = (from, false);
            for end in inside.map(|(x, kink)| (libm::asin(*x), *kink)).chain([(to, false)]) {
                let piece = Piece::kinked(start.0, end.0, start.1, end.1);
                pieces.push(if thin { piece.thin() } else { piece });
                start = end;
            }
            lines.push(segment);
        }
        let in_plane = self.sin_o * theta.cos - self.mu * theta.sin;
        let closest = in_plane * in_plane / (1.0 + mean + amplitude);
        let mut integral = integrate(&pieces, (allowed - skipped).max(0.5 * allowed), NODE_LIMIT, |psi| {
            let x = libm::sin(psi);
            let line = lines.iter().find(|line| x <= line.to).or(lines.last());
            let weight = line.map_or(0.0, |line| line.at(x).max(0.0));
            let cos_d = (mean + amplitude * x).clamp(0.0, 1.0);
            // versin theta_d = versin(theta_o - theta_h) + amplitude (1 - x), with 1 - sin psi as a square
            let half = libm::sin(FRAC_PI_4 - 0.5 * psi);
            let theta_d = Polar::from_versine((closest + 2.0 * amplitude * half * half).min(1.0), cos_d);
            Bounded::exact(microfacet.facet_reflectance_at(theta_d) * (FRAC_1_PI * weight))
        })?;
        integral.bounded.value += DVec3::splat(0.5 * skipped);
        integral.bounded.error += DVec3::splat(0.5 * skipped);
        Ok(integral)
    }
}

/// Share of the error allowed to an azimuth integral that may be spent on not evaluating segments at all.
const SKIPPED_SHARE: f64 = 0.5;

/// Segments that hold at most this many times the error allowed are begun with three nodes: F varies little over them.
const THIN_FACTOR: f64 = 1e3;
