//! rho_hd of any lobe made of facets, deterministically: any distribution, masked in any way, anisotropic ones included; but
//! for facets that stand off the surface, see [`super::sheen`].
//!
//! In the standard variates of the distribution, rho_hd(o) = (1/2 pi) int dpsi int_0^q_max q exp(-q^2/2) F(o.h) w dq, with
//! the weight w = f cos_i 4 (o.h)/(p F) of a half vector. The azimuth is the outer variable: along a fixed azimuth every
//! change of the integrand is known. With x = tan theta_o cos phi, t = tan theta_h and xi = atan x,
//!
//! - (o.h)/((n.o)(n.h)) = 1 + x t and n.i/n.o = cos 2 theta_h + x sin 2 theta_h;
//! - n.i = 0 at theta_h = (pi/2 + xi)/2, the end of the integral, which is t = exp(asinh x);
//! - o.h = 2 (n.h)(n.i) at (pi/2 + xi)/3, o.h = 2 (n.h)(n.o) at pi/2 - xi, n.i = n.o at xi;
//! - the Fresnel term has an edge where mu + sin theta_o cos phi t = cos_e sqrt(1 + t^2), a quadratic in t.
//!
//! The outer integrand is analytic but where two of those meet: at x = 1 for V-grooves, and where an edge appears or leaves
//! over the horizon. At grazing angles it has a layer around cos phi = 0, as thin as x is steep there, in whose logarithm it
//! is smooth. With v = (a_x o_x, a_y o_y) for semi-axes a of the lobe, x = tan theta_o |v| sin delta/|(a_x, a_y) dir| along
//! the standard direction dir at the angle delta from the perpendicular of v.

#[cfg(test)]
mod tests;

use super::hemisphere::Mean;
use super::lobe::{Kink, NODE_LIMIT, pieces};
use super::unbounded::{UNMASKED, UNMASKED_COAT, is_vmf};
use super::{IntegrateError, smith_hd};
use crate::bxdf::{FresnelBlend, Microfacet};
use crate::distribution::{Distribution, Isotropic};
use crate::fresnel::Edge;
use crate::geometry::{Polar, at_azimuth};
use crate::masking::{Cosines, Masking};
use crate::numerics::quadrature::{Bounded, Integral, NotConverged, Piece, integrate};
use glam::{DVec2, DVec3};
use std::f64::consts::{FRAC_PI_2, PI};

/// Shares of the tolerance: what is cut off in the tail and in the layer, what the inner integrals may leave, and the rest
/// for the outer one.
const TAIL_SHARE: f64 = 0.03;
const LAYER_SHARE: f64 = 0.02;
const INNER_SHARE: f64 = 0.35;
const OUTER_SHARE: f64 = 0.6;

/// The weight of a half vector that is drawn from p(h), without the Fresnel term.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Weight {
    /// V' (o.h)/((n.o)(n.h)) [Mikkelsen 2009, eq. 30].
    Masked(Masking),
    /// min(1, (n.i)/(n.o))/(n.h), the coat of a FresnelBlend.
    Coat,
}

/// A lobe of facets.
pub(super) struct Facets<'a> {
    pub(super) distribution: &'a Distribution,
    pub(super) weight: Weight,
    /// Reflectance of a facet at the angle theta_d.
    pub(super) reflectance: &'a (dyn Fn(Polar) -> DVec3 + 'a),
    /// Cosines at which the reflectance changes its behaviour.
    pub(super) edges: Vec<Edge>,
}

/// rho_hd of a microfacet lobe at cos theta_o = `mu` and azimuth `phi`, with an absolute error of at most `tolerance`.
pub(super) fn rho_hd(microfacet: &Microfacet, mu: f64, phi: f64, tolerance: f64) -> Result<Integral, IntegrateError> {
    Facets {
        distribution: &microfacet.distribution,
        weight: Weight::Masked(microfacet.masking),
        reflectance: &|theta_d| microfacet.facet_reflectance_at(theta_d),
        edges: microfacet.fresnel.edges(),
    }
    .rho_hd(mu, phi, tolerance)
}

/// rho_hh of a microfacet lobe, with an absolute error of at most `tolerance`.
pub(super) fn rho_hh(microfacet: &Microfacet, tolerance: f64) -> Result<Integral, IntegrateError> {
    Mean {
        marks: &mean_marks(microfacet),
        anisotropic: microfacet.distribution.isotropic().is_none(),
        bound: 2.0,
        grows: microfacet.masking == Masking::None,
    }
    .integrate(tolerance, |mu, phi, allowed| {
        smith_hd::rho_hd(microfacet, mu, allowed).map_or_else(|| rho_hd(microfacet, mu, phi, allowed), Ok)
    })
}

/// Cosines of wo at which rho_hd changes its behaviour: the layer at the horizon, and what F does, blurred by the lobe.
///
/// A narrow lobe follows F through total internal reflection within a few of its widths of the edge, and has its square root
/// beyond: a step that few nodes would miss.
pub(super) fn mean_marks(microfacet: &Microfacet) -> Vec<(f64, bool)> {
    let width = microfacet.distribution.width();
    let mut marks = vec![(width, false)];
    for edge in microfacet.fresnel.edges() {
        marks.push((edge.cos, edge.kink));
        if edge.kink {
            let theta_e = libm::acos(edge.cos);
            let distances = std::iter::successors(Some(width), |d| Some(STEP_FROM_EDGE * d)).take_while(|d| *d < 1.0);
            marks.extend(distances.flat_map(|d| [theta_e - d, theta_e + d].map(|theta| (libm::cos(theta), false))));
        }
    }
    marks
}

/// Ratio of the distances from an edge of F at which its mean over a lobe is split: beyond the lobe it is a square root, all
/// but polynomial over such ranges.
const STEP_FROM_EDGE: f64 = 6.0;

/// rho_hd of the coat of a FresnelBlend at cos theta_o = `mu` and azimuth `phi`, with an absolute error of at most
/// `tolerance`.
pub(super) fn coat_rho_hd(blend: &FresnelBlend, mu: f64, phi: f64, tolerance: f64) -> Result<Integral, IntegrateError> {
    Facets {
        distribution: blend.distribution(),
        weight: Weight::Coat,
        reflectance: &|theta_d| blend.coat_reflectance(theta_d.cos),
        edges: Vec::new(),
    }
    .rho_hd(mu, phi, tolerance)
}

/// rho_hh of the coat of a FresnelBlend, with an absolute error of at most `tolerance`.
pub(super) fn coat_rho_hh(blend: &FresnelBlend, tolerance: f64) -> Result<Integral, IntegrateError> {
    Mean {
        marks: &[(blend.distribution().width(), false)],
        anisotropic: blend.distribution().isotropic().is_none(),
        bound: 2.0,
        // like a logarithm for facets whose D is infinite at the horizon
        grows: is_vmf(blend.distribution()),
    }
    .integrate(tolerance, |mu, phi, allowed| coat_rho_hd(blend, mu, phi, allowed))
}

impl Facets<'_> {
    /// rho_hd at cos theta_o = `mu` and azimuth `phi`, with an absolute error of at most `tolerance`.
    pub(super) fn rho_hd(&self, mu: f64, phi: f64, tolerance: f64) -> Result<Integral, IntegrateError> {
        // the reciprocal of a subnormal number is infinite
        let mu = if mu < f64::MIN_POSITIVE { 0.0 } else { mu };
        // without masking rho grows like 1/mu: mu rho is what is integrated, to as many digits as rho can have
        let scale = match self.weight {
            Weight::Masked(Masking::None) if mu == 0.0 => return Err(IntegrateError::Diverges(UNMASKED)),
            Weight::Coat if mu == 0.0 && is_vmf(self.distribution) => {
                return Err(IntegrateError::Diverges(UNMASKED_COAT));
            }
            Weight::Masked(Masking::None) => mu,
            Weight::Masked(_) | Weight::Coat => 1.0,
        };
        let tolerance = if scale < 1.0 {
            (tolerance * scale).max(ROUNDING * self.distribution.width())
        } else {
            tolerance
        };
        let view = View::new(self.distribution, mu, phi);
        let q_tail = self.tail(mu, TAIL_SHARE * tolerance);
        let cut = LAYER_SHARE * tolerance / self.mean_bound(mu);
        let mut total = Integral {
            bounded: Bounded::exact(DVec3::ZERO),
            evaluations: 0,
        };
        let (halves, share) = if view.symmetric {
            (&[1.0][..], 1.0)
        } else {
            (&[1.0, -1.0][..], 0.5)
        };
        for half in halves {
            let pieces = self.outer_pieces(&view, *half, cut);
            let mut evaluations = 0;
            let mut failure = None;
            let outer = integrate(&pieces, PI * OUTER_SHARE * tolerance, NODE_LIMIT, |delta| {
                let slice = view.slice(*half, delta);
                match self.slice(&view, &slice, q_tail, INNER_SHARE * tolerance) {
                    Ok(integral) => {
                        evaluations += integral.evaluations;
                        integral.bounded
                    }
                    Err(error) => {
                        failure.get_or_insert(error);
                        Bounded::exact(DVec3::NAN)
                    }
                }
            });
            let outer = match (failure, outer) {
                (Some(error), _) | (None, Err(error)) => return Err(error.into()),
                (None, Ok(outer)) => outer.bounded.scaled(share / (PI * scale)),
            };
            total.bounded.value += outer.value;
            total.bounded.error += outer.error;
            total.evaluations += evaluations;
        }
        total.bounded.error += DVec3::splat((TAIL_SHARE + LAYER_SHARE) * tolerance / scale);
        if total.bounded.value.is_finite() && total.bounded.error.is_finite() {
            Ok(total)
        } else {
            Err(IntegrateError::Diverges(UNMASKED))
        }
    }

    /// Bound of the mean of w over one azimuth, or of mu w where there is no masking.
    fn mean_bound(&self, mu: f64) -> f64 {
        match self.weight {
            Weight::Masked(Masking::VGroove | Masking::None) => 2.0,
            // 1 + c times the mean of r: 1 + 2 (pi/2) and 1 + 2 sqrt(pi) (sqrt(pi)/2)
            Weight::Masked(_) => 5.0,
            // the mean of 1/(n.h), which is the logarithm of its bound for facets that are infinitely many at the horizon
            Weight::Coat if is_vmf(self.distribution) => 2.0 + libm::log(mu.recip()),
            // and below 2 for all others: (n + 2)/(n + 1) for Phong
            Weight::Coat => 2.0 + libm::tan(self.distribution.width()),
        }
    }

    /// The q beyond which the lobe adds at most `allowed`.
    fn tail(&self, mu: f64, allowed: f64) -> f64 {
        let exposure = match self.weight {
            Weight::Masked(Masking::VGroove) => libm::log(2.0f64) - libm::log(allowed),
            // (n.o) t <= n.o + tan theta_h, which is 2/n.o at the end
            Weight::Masked(Masking::None) => libm::log(2.0 + 2.0 / mu) - libm::log(allowed),
            // w <= G1 (1 + x t) <= 1 + c r with the stretched radius r of the normal, since Lambda is at least r_o/c with
            // c = 2 for GGX, where r = sqrt(e^E - 1), and c = 2 sqrt(pi) for Beckmann, where r = sqrt E
            Weight::Masked(_) => 2.0 * (libm::log(6.0f64) - libm::log(allowed)),
            Weight::Coat => return self.coat_tail(mu, allowed),
        };
        (2.0 * exposure.max(1.0)).sqrt()
    }

    /// w <= min(1/(n.o), 1/(n.h)), where 1/(n.h) grows no faster than e^(E/2) but for vMF.
    fn coat_tail(&self, mu: f64, allowed: f64) -> f64 {
        let most = |exposure: f64| {
            let cosines =
                [DVec2::X, DVec2::Y].map(|tangent| self.distribution.along(tangent).at_exposure(exposure).cos);
            let grown = if is_vmf(self.distribution) {
                f64::INFINITY
            } else {
                2.0 / cosines[0].min(cosines[1])
            };
            libm::log(grown.min(mu.recip())) - exposure
        };
        let mut exposure = 1.0;
        while most(exposure) > libm::log(allowed) && exposure < 4000.0 {
            exposure += 1.0;
        }
        (2.0f64 * exposure).sqrt()
    }

    /// The pieces of delta in [-pi/2, pi/2] on which the outer integrand is smooth.
    fn outer_pieces(&self, view: &View, half: f64, cut: f64) -> Vec<Piece> {
        let mut marks = Vec::with_capacity(8);
        let slope = view.perpendicular_slope();
        for x in [1.0, slope.recip()] {
            marks.extend([(x / view.tau, false), (-x / view.tau, false)]);
        }
        if self.weight == Weight::Coat {
            // n.i = n.o passes through the lobe
            marks.extend([(slope / view.tau, false), (8.0 * slope / view.tau, false)]);
        }
        for edge in &self.edges {
            let product = |cos: f64| (cos - view.mu) * (cos + view.mu);
            // the azimuth at which the edge is the largest o.h, and the one at which a kink meets the horizon
            if edge.cos > view.mu {
                marks.push((product(edge.cos).sqrt() / view.sin_o, edge.kink));
            }
            if edge.kink && 2.0 * edge.cos > view.mu {
                let root = product(2.0 * edge.cos).sqrt();
                marks.push((0.5 * (root - view.mu * view.mu / root) / view.sin_o, true));
            }
        }
        let marks = marks
            .into_iter()
            .flat_map(|(cos_phi, kink)| view.deltas(half, cos_phi).into_iter().map(move |delta| (delta, kink)));
        let turns = view.turns(half).into_iter().map(|delta| (delta, false));
        let (back, front): (Vec<_>, Vec<_>) = marks.chain(turns).partition(|(delta, _)| *delta < 0.0);
        let mut all = Vec::new();
        for (side, sign) in [(back, -1.0), (front, 1.0)] {
            // behind wo nothing is seen at the horizon
            if sign < 0.0 && view.mu == 0.0 {
                continue;
            }
            let mut cuts: Vec<(f64, Kink)> = side
                .into_iter()
                .map(|(delta, kink)| (delta.abs(), Kink::between_pieces(kink)))
                .filter(|(delta, _)| *delta > cut && *delta < FRAC_PI_2)
                .collect();
            // a layer that lies within the cut altogether is left out
            let layer = view
                .deltas(half, view.tau.recip())
                .into_iter()
                .fold(FRAC_PI_2, f64::min);
            let ends = [if layer < cut { cut } else { 0.0 }, FRAC_PI_2];
            cuts.extend(ends.map(|end| (end, Kink::between_pieces(false))));
            cuts.sort_by(|(a, _), (b, _)| a.total_cmp(b));
            for window in cuts.windows(2).filter(|w| w[1].0 > w[0].0) {
                all.extend(pieces(window[0], window[1]).into_iter().map(|piece| {
                    let piece = piece.careful();
                    if sign < 0.0 { piece.mirrored() } else { piece }
                }));
            }
        }
        all
    }

    /// int_0^q_max q exp(-q^2/2) F w dq along one azimuth.
    fn slice(&self, view: &View, slice: &Slice, q_tail: f64, allowed: f64) -> Result<Integral, NotConverged> {
        let q_at = |theta: Polar| (2.0 * slice.profile.exposure(theta)).sqrt();
        let end = slice.horizon();
        let q_end = q_at(end).min(q_tail);
        let mut cuts: Vec<(f64, Kink)> = Vec::with_capacity(8);
        let mut cut = |theta: Polar, kink: bool| {
            let q = q_at(theta);
            if q > 0.0 && q < q_end {
                cuts.push((q, Kink::between_pieces(kink)));
            }
        };
        match self.weight {
            Weight::Masked(Masking::VGroove) if slice.x <= 1.0 => {
                cut(Polar::from_angle(slice.elevation() / 3.0), false)
            }
            Weight::Masked(Masking::VGroove) => {
                cut(Polar::from_tan(slice.x.recip()), false);
                cut(Polar::from_tan(slice.x), false);
            }
            // 1 + x t begins to grow
            Weight::Coat if slice.x > 0.0 => {
                cut(Polar::from_tan(slice.x), false);
                if slice.x > 1.0 {
                    cut(Polar::from_tan(slice.x.recip()), false);
                }
            }
            Weight::Masked(_) if slice.x > 1.0 => cut(Polar::from_tan(slice.x.recip()), false),
            Weight::Masked(_) | Weight::Coat => {}
        }
        if matches!(self.weight, Weight::Masked(masking) if masking.is_smith()) {
            for t in view.narrow_tangents(slice.azimuth) {
                cut(Polar::from_tan(t), false);
            }
            for t in slice.layer_tangents(view.mu, allowed) {
                cut(Polar::from_tan(t), false);
            }
        }
        for edge in &self.edges {
            for t in view.edge_tangents(slice.cos_phi, edge.cos) {
                cut(Polar::from_tan(t), edge.kink);
            }
        }
        cuts.extend([(0.0, Kink::between_pieces(false)), (q_end, Kink::between_pieces(false))]);
        cuts.sort_by(|(a, _), (b, _)| a.total_cmp(b));
        let pieces: Vec<Piece> = cuts
            .windows(2)
            .filter(|w| w[1].0 > w[0].0)
            .flat_map(|w| pieces(w[0], w[1]))
            .map(Piece::careful)
            .collect();
        integrate(&pieces, allowed, NODE_LIMIT, |q| {
            let theta = slice.profile.at_exposure(0.5 * q * q);
            let weight = self.weight.of(view, slice, theta);
            let reflected = (self.reflectance)(view.facet_angle(slice, theta));
            Bounded::exact(reflected * (weight * q * libm::exp(-0.5 * q * q)))
        })
    }
}

/// Error of mu rho, relative to the width of the lobe, below which no tolerance asks: the rounding of F and of some hundred
/// terms, with a margin.
const ROUNDING: f64 = 1e-13;

/// Ratio of the axes of a lobe up to which its turns are split off, and the ratio of the distances.
const LARGEST_TURN: f64 = 0.35;
const TURN_STEP: f64 = 6.0;

impl Weight {
    /// w for a facet at the angle `theta` along the azimuth of `slice`.
    fn of(self, view: &View, slice: &Slice, theta: Polar) -> f64 {
        let t = 1.0 + slice.x * theta.tan();
        let double = (theta.cos - theta.sin) * (theta.cos + theta.sin);
        // n.i/n.o, which rounding must not take below the horizon
        let ratio = (double + 2.0 * slice.x * theta.sin * theta.cos).max(0.0);
        match self {
            // times n.o
            Self::Masked(Masking::None) => view.mu + view.sin_o * slice.cos_phi * theta.tan(),
            Self::Masked(Masking::VGroove) => t.min(2.0).min(2.0 * ratio).max(0.0),
            Self::Coat => ratio.min(1.0) / theta.cos,
            Self::Masked(smith) => {
                let wm = (slice.azimuth * theta.sin).extend(theta.cos);
                let cos_d = view.facet_angle(slice, theta).cos;
                let cosines = Cosines {
                    o: view.mu,
                    i: if view.mu > 0.0 {
                        view.mu * ratio
                    } else {
                        2.0 * cos_d * theta.cos
                    },
                    h: theta.cos,
                    d: cos_d,
                };
                let wi = 2.0 * cos_d * wm - view.wo;
                smith.weight(view.distribution, view.wo, wi, cosines)
            }
        }
    }
}

/// A fixed direction wo, seen in the standard circle of a distribution.
struct View<'a> {
    distribution: &'a Distribution,
    wo: DVec3,
    mu: f64,
    sin_o: f64,
    /// tan theta_o, infinite at the horizon.
    tau: f64,
    /// Azimuth of wo.
    azimuth: DVec2,
    /// Semi-axes of the lobe, relative to the larger.
    axes: DVec2,
    /// |v| for v = axes times azimuth, and the unit vectors along and across v.
    length: f64,
    along: DVec2,
    across: DVec2,
    /// Whether both halves of the circle are mirror images.
    symmetric: bool,
}

/// One azimuth of the facets.
struct Slice {
    profile: Isotropic,
    azimuth: DVec2,
    /// tan theta_o cos phi.
    x: f64,
    cos_phi: f64,
    /// 1 - cos phi.
    versine_phi: f64,
}

impl<'a> View<'a> {
    fn new(distribution: &'a Distribution, mu: f64, phi: f64) -> Self {
        // along a tangent the rounding of phi must not break the symmetry
        let azimuth = at_azimuth(phi).map(|c| if c.abs() < 1e-15 { 0.0 } else { c });
        let axes = match distribution {
            Distribution::Isotropic(_) => DVec2::ONE,
            Distribution::Anisotropic(anisotropic) => anisotropic.axes() / anisotropic.axes().max_element(),
        };
        let v = axes * azimuth;
        let length = v.length();
        let along = v / length;
        let sin_o = Polar::from_cos(mu).sin;
        Self {
            distribution,
            wo: (azimuth * sin_o).extend(mu),
            mu,
            sin_o,
            tau: sin_o / mu,
            azimuth,
            axes,
            length,
            along,
            across: along.perp(),
            symmetric: axes.x == axes.y || azimuth.x == 0.0 || azimuth.y == 0.0 || sin_o == 0.0,
        }
    }

    fn slice(&self, half: f64, delta: f64) -> Slice {
        let (sin, cos) = libm::sincos(delta);
        let stretched = self.axes * (self.along * sin + self.across * (half * cos));
        let radius = stretched.length();
        let azimuth = stretched / radius;
        let cos_phi = (self.length * sin / radius).clamp(-1.0, 1.0);
        Slice {
            profile: self.distribution.along(azimuth),
            azimuth,
            // at normal incidence 0, and at the horizon infinite
            x: if cos_phi == 0.0 { 0.0 } else { self.tau * cos_phi },
            cos_phi,
            versine_phi: 0.5 * (azimuth - self.azimuth).length_squared(),
        }
    }

    /// The values of delta at which cos phi has the given value; two where the azimuth of wo lies between them.
    ///
    /// (|v| sin)^2 = cos^2 phi |axes dir|^2 with dir = along sin + half across cos is a quadratic in tan delta.
    fn deltas(&self, half: f64, cos_phi: f64) -> Vec<f64> {
        let (a, c) = (self.axes * self.along, self.axes * self.across * half);
        let reach = self.length / cos_phi;
        let square = reach * reach - a.length_squared();
        let (linear, constant) = (a.dot(c), c.length_squared());
        let discriminant = linear * linear + square * constant;
        if !discriminant.is_finite() {
            return vec![0.0];
        }
        if discriminant < 0.0 {
            return Vec::new();
        }
        // square T^2 - 2 linear T - constant = 0; of both roots the larger in size first, the other from their product
        let big = linear + discriminant.sqrt().copysign(linear);
        let roots = [big / square, -constant / big];
        let found = roots.into_iter().filter(|t| t.is_finite() && t * cos_phi > 0.0);
        found.map(libm::atan).collect()
    }

    /// Splits in delta around the shorter axis of the lobe, where the azimuth of the facets turns from one long side of the
    /// ellipse to the other within an angle of the ratio of the axes: the axis itself, and distances that grow in steps.
    fn turns(&self, half: f64) -> Vec<f64> {
        let ratio = self.axes.min_element();
        if ratio > LARGEST_TURN {
            return Vec::new();
        }
        let short = if self.axes.x < self.axes.y { DVec2::X } else { DVec2::Y };
        // along sin + half across cos is parallel to the short axis
        let centre = libm::atan2(half * self.across.perp_dot(short), -self.along.perp_dot(short));
        let centre = (centre + FRAC_PI_2).rem_euclid(PI) - FRAC_PI_2;
        let steps =
            std::iter::successors(Some(ratio), |step| Some(TURN_STEP * step)).take_while(|step| *step < FRAC_PI_2);
        // the far side of the circle of directions is the near side of the next turn, half a circle on
        let around = steps.flat_map(|step| [centre - step, centre + step]).map(|delta| {
            if delta.abs() > FRAC_PI_2 {
                delta - PI.copysign(delta)
            } else {
                delta
            }
        });
        around.chain([centre]).collect()
    }

    /// Slope of a typical facet across wo.
    fn perpendicular_slope(&self) -> f64 {
        let azimuth = (self.axes * self.across).normalize();
        self.distribution.along(azimuth).inverse_cdf(0.5).tan()
    }

    /// The slopes t > 0 at which o.h = `cos`: (mu + s t)^2 = cos^2 (1 + t^2) with s = sin theta_o cos phi.
    fn edge_tangents(&self, cos_phi: f64, cos: f64) -> impl Iterator<Item = f64> + use<> {
        let (mu, s) = (self.mu, self.sin_o * cos_phi);
        let square = (cos - s) * (cos + s);
        let constant = (cos - mu) * (cos + mu);
        // square t^2 - 2 mu s t + constant = 0
        let discriminant = (mu * s).powi(2) - square * constant;
        let big = mu * s + (mu * s).signum() * discriminant.max(0.0).sqrt();
        let roots = if discriminant < 0.0 {
            [f64::NAN; 2]
        } else {
            [big / square, constant / big]
        };
        roots
            .into_iter()
            .filter(move |t| *t > 0.0 && t.is_finite() && mu + s * t > 0.0)
    }

    /// The slopes t > 0 at which wi lies across the longer axis of the lobe, which hides facets from it in proportion to
    /// |wi.x| almost everywhere: 2 (o.h) h.x = o.x, with x along that axis, is a quadratic in t.
    fn narrow_tangents(&self, azimuth: DVec2) -> impl Iterator<Item = f64> + use<> {
        let long = if self.axes.x < self.axes.y { DVec2::Y } else { DVec2::X };
        let (o, h) = (self.sin_o * self.azimuth.dot(long), azimuth.dot(long));
        let cos_phi = self.azimuth.dot(azimuth);
        // square t^2 + 2 half t - o = 0
        let (square, half) = (2.0 * self.sin_o * cos_phi * h - o, self.mu * h);
        let discriminant = half * half + square * o;
        let big = -(half + half.signum() * discriminant.max(0.0).sqrt());
        let is_narrow = self.axes.min_element() < LARGEST_TURN && discriminant >= 0.0;
        let roots = if is_narrow {
            [big / square, -o / big]
        } else {
            [f64::NAN; 2]
        };
        roots.into_iter().filter(|t| *t > 0.0 && t.is_finite())
    }

    /// The angle between wo and a facet: versin theta_d = versin(theta_o - theta_h) + sin theta_o sin theta_h versin phi.
    fn facet_angle(&self, slice: &Slice, theta: Polar) -> Polar {
        let in_plane = self.sin_o * theta.cos - self.mu * theta.sin;
        let cos_in_plane = self.mu * theta.cos + self.sin_o * theta.sin;
        let closest = in_plane * in_plane / (1.0 + cos_in_plane);
        let lateral = self.sin_o * theta.sin;
        let cos = (self.mu * theta.cos + lateral * slice.cos_phi).clamp(0.0, 1.0);
        Polar::from_versine((closest + lateral * slice.versine_phi).min(1.0), cos)
    }
}

/// Width of the layer of [`Slice::layer_tangents`] from which on the rules see it by themselves, and the ratio of its splits.
const LARGEST_LAYER: f64 = 0.02;
const LAYER_STEP: f64 = 8.0;

impl Slice {
    /// Splits around the layer at the horizon in which G2 of GGX falls from 1 to 0 when alpha is far below mu: n.i is
    /// mu ln(T/t) there and the layer alpha/mu wide in ln t. It holds (2/3) (alpha/mu) of 2 (alpha/T)^2 (1 + x T), see
    /// [`super::smith_hd`]; the tail of Beckmann has vanished there.
    fn layer_tangents(&self, mu: f64, allowed: f64) -> impl Iterator<Item = f64> + use<> {
        let end = self.horizon().tan();
        let (width, weight) = match self.profile {
            Isotropic::Ggx(ggx) => {
                let (alpha, width) = (ggx.alpha(), ggx.alpha() / mu);
                (width, 2.0 * width * (alpha / end).powi(2) * (1.0 + self.x * end))
            }
            Isotropic::Vmf(_) | Isotropic::Beckmann(_) | Isotropic::Phong(_) | Isotropic::Charlie(_) => (1.0, 0.0),
        };
        let first = (width < LARGEST_LAYER && weight > 0.01 * allowed).then_some(2.0 * width);
        std::iter::successors(first, |distance| Some(LAYER_STEP * distance))
            .take_while(|distance| *distance < 1.0)
            .map(move |distance| end * libm::exp(-distance))
    }

    /// pi/2 + atan x, with all its digits where x is large and negative.
    fn elevation(&self) -> f64 {
        if self.x < 0.0 {
            libm::atan(-self.x.recip())
        } else {
            FRAC_PI_2 + libm::atan(self.x)
        }
    }

    /// The angle at which n.i = 0: tan = exp(asinh x).
    fn horizon(&self) -> Polar {
        let root = libm::hypot(self.x, 1.0);
        Polar::from_tan(if self.x < 0.0 {
            (root - self.x).recip()
        } else {
            root + self.x
        })
    }
}
