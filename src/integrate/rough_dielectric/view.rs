//! A direction in front of a rough interface: the integrand over the slopes of the facets, and where it is smooth.
//!
//! A facet has the slope (p, q) along and across the azimuth of wo, its normal is along (p, q, 1). With mu = n.o,
//! s = sin theta_o, t^2 = p^2 + q^2 and the cosine n.h = k = (1 + t^2)^(-1/2),
//!
//! rho = int dp dq P22(p, q) (mu + s p)/mu G2 W, since D (n.h) dh = P22 dp dq and (o.h)/((n.o)(n.h)) = (mu + s p)/mu,
//!
//! with W one of F and 1 - F. With c = o.h = (mu + s p) k and g = sqrt(eta^2 - 1 + c^2) the other direction has
//!
//! - n.i = 2 c k - mu where it is reflected, positive within the circle (mu p - s)^2 + mu^2 q^2 < 1;
//! - n.i = (mu + (g - c) k)/eta where it is refracted: always positive for eta > 1. For eta < 1 its product with
//!   eta (g k + c k - mu) is k^2 C, C = eta^2 - 1 + mu^2 + 2 mu s p - mu^2 t^2, positive within a circle of radius eta; what of
//!   the slopes with c k > mu lies outside of that circle is lost.
//!
//! For eta < 1 light passes only where c > c_e = sqrt(1 - eta^2), the inside of a conic section:
//! (mu + s p)^2 > c_e^2 (1 + t^2). There g has a square root, which the variable p - p_e = y^2 takes away. Both curves and
//! n.i = 0 are met by every row q = const at known places.
//!
//! With q = b sinh w and p = b cosh w sinh u, b the smaller of alpha and 1, everything varies on the scale of 1: poles of P22,
//! those of k and the tails are all pi/2 away from the axis or farther.

use crate::masking::Smith;
use crate::numerics::lanes::{exp, scaled_ierfc};
use glam::DVec3;
use multiversion::multiversion;
use std::f64::consts::{FRAC_1_PI, PI};

/// What becomes of the light, and how it is weighed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Way {
    /// Reflected, F.
    Reflected,
    /// What F = 1 would reflect beyond that: 1 - F, masked as reflection is.
    Missing,
    /// Refracted, 1 - F.
    Refracted,
}

/// The round distributions of slopes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Slopes {
    /// GGX.
    Ggx,
    /// Beckmann.
    Gaussian,
}

/// Facets and media.
#[derive(Debug, Clone, Copy)]
pub(super) struct Facets {
    pub(super) slopes: Slopes,
    pub(super) alpha: f64,
    pub(super) correlated: bool,
    /// Index of the far side over that of the side of wo.
    pub(super) eta: f64,
}

/// The integrand for one direction.
#[derive(Debug, Clone, Copy)]
pub(super) struct View {
    facets: Facets,
    way: Way,
    mu: f64,
    s: f64,
    /// (n.o) (1 + Lambda(o)).
    seen: f64,
    /// Scale of both variables, the smaller of alpha and 1.
    base: f64,
    /// (eta - 1)(eta + 1), and the cosine of total reflection.
    step: f64,
    edge: f64,
    /// Ends of the lobe: the radius of all slopes, and of those that face away from wo.
    ahead: f64,
    behind: f64,
}

/// A part of a row, in u or in the root of its distance from an edge.
#[derive(Debug, Clone, Copy)]
pub(super) struct Part {
    pub(super) from: f64,
    pub(super) to: f64,
    /// u = edge + sign y^2 where there is an edge.
    edge: Option<(f64, f64)>,
}

impl Part {
    /// u and du/dy.
    #[inline(always)]
    pub(super) fn at(&self, y: f64) -> (f64, f64) {
        match self.edge {
            Some((edge, sign)) => (edge + sign * y * y, 2.0 * y),
            None => (y, 1.0),
        }
    }

    /// From `from` to `to` in u.
    fn new(from: f64, to: f64, edge: Option<(f64, f64)>) -> Self {
        match edge {
            Some((e, sign)) if sign > 0.0 => Self {
                from: (from - e).max(0.0).sqrt(),
                to: (to - e).max(0.0).sqrt(),
                edge,
            },
            Some((e, _)) => Self {
                from: (e - to).max(0.0).sqrt(),
                to: (e - from).max(0.0).sqrt(),
                edge,
            },
            None => Self { from, to, edge },
        }
    }
}

/// Most parts of a row.
pub(super) const MOST_PARTS: usize = 12;

/// A row of slopes of one q.
#[derive(Debug, Clone, Copy)]
pub(super) struct Row {
    q2: f64,
    /// sqrt(b^2 + q^2) = b cosh w.
    width: f64,
    /// P22 dq/dw but for what depends on u.
    scale: f64,
    pub(super) parts: [Part; MOST_PARTS],
    pub(super) count: usize,
}

impl Row {
    fn push(&mut self, part: Part) {
        if part.to > part.from && self.count < MOST_PARTS {
            self.parts[self.count] = part;
            self.count += 1;
        }
    }

    pub(super) fn parts(&self) -> &[Part] {
        &self.parts[..self.count]
    }
}

/// Distance from an edge in u up to which its root shows.
const REACH: f64 = 1.5;

/// Widths of n.i over alpha from which on a layer at the horizon is split off, and the ratio of its splits.
const LAYER: f64 = 8.0;
const LAYER_STEP: f64 = 8.0;

/// Cosines below this at which the Fresnel term turns are split off, and the ratio of the splits.
const LARGEST_TURN: f64 = 0.2;
const TURN_STEP: f64 = 8.0;

impl View {
    /// The view from cos theta_o = `mu`, without a tail that weighs at most `tail`.
    ///
    /// G2 <= G1(o) bounds the integrand by P22 (mu + s p)/seen(o), where the mean of the positive part of p is t/pi. Beyond
    /// t = alpha v GGX has at most 1/v^2 + (2/pi) (alpha s/seen)/v of that, Beckmann (mu + 3.4 alpha s)/seen e^(-v^2) as in
    /// [`super::super::smith_hd`]; of the facets with p < 0 it is at most 1/v^2 and e^(-v^2).
    pub(super) fn new(facets: Facets, way: Way, mu: f64, tail: f64) -> Self {
        let Facets { slopes, alpha, eta, .. } = facets;
        let s = ((1.0 - mu) * (1.0 + mu)).sqrt();
        let seen = seen(slopes, alpha * s, mu);
        let allowed = tail / 3.0;
        let (ahead, behind) = match slopes {
            Slopes::Ggx => {
                let back = allowed.recip().sqrt();
                (back.max(2.0 * alpha * s / (PI * seen * allowed)), back)
            }
            Slopes::Gaussian => {
                let end = |bound: f64| libm::log(bound / allowed).max(1.0).sqrt();
                (end((mu + 3.4 * alpha * s) / seen), end(1.0))
            }
        };
        let step = (eta - 1.0) * (eta + 1.0);
        Self {
            facets,
            way,
            mu,
            s,
            seen,
            base: alpha.min(1.0),
            step,
            edge: (-step).max(0.0).sqrt(),
            ahead: alpha * ahead,
            behind: alpha * behind,
        }
    }

    /// Whether total reflection ends the domain.
    fn has_edge(&self) -> bool {
        self.facets.eta < 1.0 && self.way != Way::Reflected
    }

    /// The ends of the pieces of w >= 0, of which the rows are the integrand; with those at which it has half-integer powers.
    pub(super) fn outer(&self) -> Vec<(f64, bool)> {
        let w = |q: f64| libm::asinh(q / self.base);
        let Self { mu, s, edge, .. } = *self;
        let eta = self.facets.eta;
        let mut end = (self.ahead, false);
        let mut marks = Vec::with_capacity(4);
        let mut bounded = |q: f64| {
            if q < end.0 {
                end = (q, true);
            }
        };
        if self.has_edge() && s < edge {
            bounded(eta / ((edge - s) * (edge + s)).sqrt());
        }
        if self.way != Way::Refracted {
            bounded(mu.recip());
        }
        // where the edge of total reflection meets the horizon
        if self.has_edge() {
            let cos = match self.way {
                Way::Refracted => eta / s,
                _ => (2.0 * edge * edge - 1.0) / s,
            };
            if cos.abs() < 1.0 {
                let radius = if self.way == Way::Refracted { eta } else { 1.0 };
                marks.push(radius * ((1.0 - cos) * (1.0 + cos)).sqrt() / mu);
            }
        }
        marks.retain(|q| *q > 1e-9 * end.0 && *q < end.0);
        let mut ends = vec![(0.0, false)];
        ends.extend(marks.into_iter().map(|q| (w(q), true)));
        ends.push((w(end.0), end.1));
        ends
    }

    /// The row at `w`, with what is split off for layers that hold more than `allowed`.
    pub(super) fn row(&self, w: f64, allowed: f64) -> Row {
        let Self { mu, s, edge, base, .. } = *self;
        let Facets { slopes, alpha, eta, .. } = self.facets;
        let (sinh, cosh) = (libm::sinh(w), libm::cosh(w));
        let (q, width) = (base * sinh, base * cosh);
        let q2 = q * q;
        let within = |radius: f64| ((radius - q) * (radius + q)).max(0.0).sqrt();
        let (mut low, mut high) = (-within(self.behind), within(self.ahead));
        let (mut rim_low, mut rim_high) = (false, false);
        // o.h = 0
        low = low.max(-mu / s);
        let (mut from_edge, mut to_edge) = (None, None);
        if self.has_edge() {
            let rise = (s - edge) * (s + edge);
            let square = eta * eta + rise * q2;
            if square <= 0.0 {
                low = high;
            } else {
                let root = edge * square.sqrt();
                let first = (edge * edge * (1.0 + q2) - mu * mu) / (root + mu * s);
                low = low.max(first);
                from_edge = Some(libm::asinh(first / width));
                if rise < 0.0 {
                    let last = -(root + mu * s) / rise;
                    high = high.min(last);
                    to_edge = Some(libm::asinh(last / width));
                }
            }
        }
        // n.i = 0
        let radius = if self.way == Way::Refracted { eta } else { 1.0 };
        let square = (radius - mu * q) * (radius + mu * q);
        if self.way == Way::Refracted && eta < 1.0 {
            // what lies outside of the circle and within the one of c k > mu, if the edge does not end the row before
            if square > 0.0 && s > eta && q < eta * ((s - eta) * (s + eta)).sqrt() / (s * mu) {
                let nearest = ((s - eta) * (s + eta) + mu * mu * q2) / (mu * (s + square.sqrt()));
                if nearest >= low {
                    low = nearest;
                    rim_low = true;
                }
            }
        } else if self.way != Way::Refracted {
            if square <= 0.0 {
                low = high;
            } else {
                let root = square.sqrt();
                let nearest = mu * (q2 - 1.0) / (s + root);
                let farthest = (s + root) / mu;
                if nearest >= low {
                    (low, rim_low) = (nearest, true);
                }
                if farthest <= high {
                    (high, rim_high) = (farthest, true);
                }
            }
        }
        let scale = match slopes {
            Slopes::Ggx => FRAC_1_PI * alpha * alpha * width * width,
            Slopes::Gaussian => FRAC_1_PI * width * width / (alpha * alpha),
        };
        let nowhere = Part {
            from: 0.0,
            to: 0.0,
            edge: None,
        };
        let mut row = Row {
            q2,
            width,
            scale,
            parts: [nowhere; MOST_PARTS],
            count: 0,
        };
        if low.is_nan() || high <= low {
            return row;
        }
        let turns = self.turns(q2, allowed).map(|p| libm::asinh(p / width));
        let (low, high) = (libm::asinh(low / width), libm::asinh(high / width));
        if high <= low {
            return row;
        }
        let near_low = from_edge.filter(|edge| low - edge < REACH);
        let near_high = to_edge.filter(|edge| edge - high < REACH);
        let from = near_low.map(|edge| (edge.min(low), 1.0));
        let to = near_high.map(|edge| (edge.max(high), -1.0));
        // the peak of the lobe, or the middle between two roots, parts the row
        let peak = if low < -0.5 && high > 0.5 {
            Some(0.0)
        } else if (from.is_some() && to.is_some()) || high - low > 4.0 {
            Some(0.5 * (low + high))
        } else {
            None
        };
        let layered = [rim_low || from.is_some(), rim_high || to.is_some()];
        let mut cuts = [peak.unwrap_or(f64::NAN), turns[0], turns[1]];
        cuts.sort_by(f64::total_cmp);
        let mut start = low;
        for cut in cuts {
            // edges count on their own side of the row
            if cut > start && cut < high {
                let edge = if start == low || to.is_none() { from } else { to };
                self.split(
                    &mut row,
                    Part::new(start, cut, edge),
                    [layered[0] && start == low, false],
                    allowed,
                );
                start = cut;
            }
        }
        let edge = if start == low { from.or(to) } else { to };
        self.split(
            &mut row,
            Part::new(start, high, edge),
            [layered[0] && start == low, layered[1]],
            allowed,
        );
        row
    }

    /// Where the Fresnel term turns: for nearly equal indices and for very different ones from 1 to what it is elsewhere within
    /// a cosine of sqrt(|eta^2 - 1|) or 1/eta of o.h = 0. What lies there weighs about the square of that.
    fn turns(&self, q2: f64, allowed: f64) -> [f64; 2] {
        let cos = self.step.abs().sqrt().min(self.facets.eta.recip());
        if cos > LARGEST_TURN || cos * cos < 0.01 * allowed {
            return [f64::NAN; 2];
        }
        let first = -self.mu / self.s;
        let distance = cos * (1.0 + q2 + first * first).sqrt() / self.s;
        [first + 2.0 * distance, first + 2.0 * TURN_STEP * distance]
    }

    /// Adds `part`, with splits towards its ends where n.i falls to 0 within less than alpha there.
    fn split(&self, row: &mut Row, part: Part, ends: [bool; 2], allowed: f64) {
        // a root runs backwards in u at a far end
        let ends = match part.edge {
            Some((_, sign)) if sign < 0.0 => [ends[1], ends[0]],
            _ => ends,
        };
        let length = part.to - part.from;
        let layer = |start: f64, sign: f64| {
            let mut share = 0.3;
            let mut found = 1.0;
            while share > 1e-6 {
                let (u, slope) = part.at(start + sign * share * length);
                if self.cos_i(row, u) < LAYER * self.facets.alpha {
                    break;
                }
                if self.value(row, u) * slope * share * length < 0.02 * allowed {
                    return 1.0;
                }
                found = share;
                share /= LAYER_STEP;
            }
            found
        };
        let first = if ends[0] { layer(part.from, 1.0) } else { 1.0 };
        let last = if ends[1] { layer(part.to, -1.0) } else { 1.0 };
        let mut cuts = [0.0; MOST_PARTS];
        let mut count = 0;
        let mut cut = |share: f64| {
            if count < MOST_PARTS {
                cuts[count] = share;
                count += 1;
            }
        };
        let mut share = first;
        while share < 0.5 {
            cut(share);
            share *= LAYER_STEP;
        }
        let mut share = last;
        let mut far = [0.0; MOST_PARTS];
        let mut far_count = 0;
        while share < 0.5 && far_count < MOST_PARTS {
            far[far_count] = 1.0 - share;
            far_count += 1;
            share *= LAYER_STEP;
        }
        for share in far[..far_count].iter().rev() {
            cut(*share);
        }
        let mut from = part.from;
        for share in &cuts[..count] {
            let to = part.from + share * length;
            row.push(Part { from, to, ..part });
            from = to;
        }
        row.push(Part { from, ..part });
    }

    fn cos_i(&self, row: &Row, u: f64) -> f64 {
        let p = row.width * libm::sinh(u);
        match self.way {
            Way::Reflected => self.other::<REFLECTED>(p, row.q2).0,
            Way::Missing => self.other::<MISSING>(p, row.q2).0,
            Way::Refracted => self.other::<REFRACTED>(p, row.q2).0,
        }
    }

    /// n.i, the weight W, and mu + s p, each 0 where there is no light.
    #[inline(always)]
    fn other<const WAY: u8>(&self, p: f64, q2: f64) -> (f64, f64, f64) {
        let Self { mu, s, step, .. } = *self;
        let eta = self.facets.eta;
        let t2 = p * p + q2;
        let k2 = (1.0 + t2).recip();
        let k = k2.sqrt();
        let faced = (mu + s * p).max(0.0);
        let c = (faced * k).min(1.0);
        let g = (step + c * c).max(0.0).sqrt();
        let (sum, par) = (c + g, eta * eta * c + g);
        // one quotient for both polarisations
        let (a, b) = (par, eta * sum);
        let product = (sum * par).max(f64::MIN_POSITIVE);
        let passes = (2.0 * c * g * (a * a + b * b) / (product * product).max(f64::MIN_POSITIVE)).min(1.0);
        let (cos_i, weight) = match WAY {
            REFLECTED => (2.0 * c * k - mu, 1.0 - passes),
            MISSING => (2.0 * c * k - mu, passes),
            _ => {
                let ahead = c * k - mu;
                let rise = step + mu * mu + 2.0 * mu * s * p - mu * mu * t2;
                let across = eta < 1.0 && ahead > 0.0;
                let (numerator, denominator) = if across {
                    (k2 * rise, g * k + ahead)
                } else {
                    (mu * sum + step * k, sum)
                };
                (numerator / (eta * denominator).max(f64::MIN_POSITIVE), passes)
            }
        };
        (cos_i.clamp(0.0, 1.0), weight, faced)
    }

    /// The integrand over u and w.
    pub(super) fn value(&self, row: &Row, u: f64) -> f64 {
        let mut one = [u];
        self.values(row, &mut one);
        one[0]
    }

    /// The integrand at every u of `nodes`, in their place.
    pub(super) fn values(&self, row: &Row, nodes: &mut [f64]) {
        let run = match (self.facets.slopes, self.way) {
            (Slopes::Ggx, Way::Reflected) => ggx_reflected,
            (Slopes::Ggx, Way::Missing) => ggx_missing,
            (Slopes::Ggx, Way::Refracted) => ggx_refracted,
            (Slopes::Gaussian, Way::Reflected) => gaussian_reflected,
            (Slopes::Gaussian, Way::Missing) => gaussian_missing,
            (Slopes::Gaussian, Way::Refracted) => gaussian_refracted,
        };
        run(self, row, nodes);
    }

    #[inline(always)]
    fn run<const GGX: bool, const WAY: u8>(&self, row: &Row, nodes: &mut [f64]) {
        let alpha = self.facets.alpha;
        let square = alpha * alpha;
        let (own, other) = match self.facets.correlated {
            true => (self.seen, self.mu),
            false => (self.seen, self.seen),
        };
        for node in nodes {
            let power = exp(*node);
            let inverse = power.recip();
            let (sinh, cosh) = (0.5 * (power - inverse), 0.5 * (power + inverse));
            let p = row.width * sinh;
            let (cos_i, weight, faced) = self.other::<WAY>(p, row.q2);
            let t2 = p * p + row.q2;
            let sine = (1.0 - cos_i) * (1.0 + cos_i);
            let (density, hidden) = if GGX {
                let root = (square + t2).recip();
                let across = square * sine;
                let hidden = 0.5 * ((cos_i * cos_i + across).sqrt() - cos_i);
                (root * root, hidden)
            } else {
                (
                    exp((-t2 / square).max(-MOST_SQUARE)),
                    hidden_gaussian(alpha * sine.sqrt(), cos_i),
                )
            };
            let shown = cos_i * own + other * hidden;
            *node = row.scale * cosh * density * weight * faced * cos_i / shown.max(f64::MIN_POSITIVE);
        }
    }

    /// The same in three channels, for the adaptive rules.
    pub(super) fn splatted(&self, row: &Row, part: &Part, y: f64) -> DVec3 {
        let (u, slope) = part.at(y);
        DVec3::splat(self.value(row, u) * slope)
    }
}

const REFLECTED: u8 = 0;
const MISSING: u8 = 1;
const REFRACTED: u8 = 2;

/// One loop for each pair of facets and ways, so that nothing is chosen inside of it.
macro_rules! loops {
    ($($name:ident: $ggx:literal, $way:ident;)*) => {$(
        #[multiversion(targets("x86_64+avx512f+avx512dq", "x86_64+avx2", "x86_64+avx"))]
        fn $name(view: &View, row: &Row, nodes: &mut [f64]) {
            view.run::<$ggx, $way>(row, nodes);
        }
    )*};
}

loops! {
    ggx_reflected: true, REFLECTED;
    ggx_missing: true, MISSING;
    ggx_refracted: true, REFRACTED;
    gaussian_reflected: false, REFLECTED;
    gaussian_missing: false, MISSING;
    gaussian_refracted: false, REFRACTED;
}

/// (n.w) Lambda(w) of Beckmann for n.w = `cos` and `across` = alpha sin theta_w, see [`Smith`].
#[inline(always)]
fn hidden_gaussian(across: f64, cos: f64) -> f64 {
    let square = (across * across).max(f64::MIN_POSITIVE);
    let ratio = (cos * cos / square).min(MOST_SQUARE);
    let sum = cos + across;
    let scaled = scaled_ierfc((cos - 3.0 * across) / (cos + 3.0 * across).max(f64::MIN_POSITIVE));
    0.5 * (across * square) * exp(-ratio) * scaled / (sum * sum).max(f64::MIN_POSITIVE)
}

/// Squared ratio from which on nothing is hidden: e^-700.
const MOST_SQUARE: f64 = 700.0;

/// (n.w) (1 + Lambda(w)).
fn seen(slopes: Slopes, across: f64, cos: f64) -> f64 {
    match slopes {
        Slopes::Ggx => 0.5 * (cos + libm::hypot(cos, across)),
        Slopes::Gaussian => cos + hidden_gaussian(across, cos),
    }
}

impl Facets {
    /// Those of a distribution that a Smith term goes with.
    pub(super) fn round(smith: &Smith, correlated: bool, eta: f64) -> Self {
        let (is_ggx, alpha) = smith.round();
        Self {
            slopes: if is_ggx { Slopes::Ggx } else { Slopes::Gaussian },
            alpha,
            correlated,
            eta,
        }
    }
}
