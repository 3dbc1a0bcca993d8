//! Visible normals and masking for many draws at once: the formulae of [`super::Masking`] and [`Smith`], without branches.

use super::smith::{Shape, Smith};
use super::{LARGEST, Masking, neubelt};
use crate::distribution::Distribution;
use crate::numerics::lanes::sin_cos_turns;
use crate::numerics::points::BLOCK;
use multiversion::multiversion;

/// One number for each draw.
type Lane = [f64; BLOCK];

/// The cosines of many facets: n.wi, o.h, and for directions that are not drawn through it n.h.
pub(crate) struct Facets {
    pub(crate) h: [Lane; 3],
    pub(crate) cos_d: Lane,
}

/// A masking term that has formulae here.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Mask {
    None,
    VGroove,
    /// With the widths of the slopes along the tangents.
    Smith([f64; 2]),
    SmithCorrelated([f64; 2]),
    Neubelt,
}

impl Mask {
    /// `None` for the Smith terms of Beckmann, whose Lambda is no elementary function, and for the fitted Lambda of sheen.
    pub(crate) fn new(masking: Masking, distribution: &Distribution) -> Option<Self> {
        let ggx = || Smith::new(distribution).filter(|smith| smith.shape == Shape::Ggx);
        match masking {
            Masking::None => Some(Self::None),
            Masking::VGroove => Some(Self::VGroove),
            Masking::Smith => ggx().map(|smith| Self::Smith(smith.axes.to_array())),
            Masking::SmithCorrelated => ggx().map(|smith| Self::SmithCorrelated(smith.axes.to_array())),
            Masking::Neubelt => Some(Self::Neubelt),
            Masking::Charlie => None,
        }
    }

    /// The widths of the slopes under Smith masking.
    pub(crate) fn slopes(self) -> Option<[f64; 2]> {
        match self {
            Self::None | Self::VGroove | Self::Neubelt => None,
            Self::Smith(axes) | Self::SmithCorrelated(axes) => Some(axes),
        }
    }

    /// [`Masking::weight`] of the facets `h`, and o.h; 0 where the facet faces away or wi points down.
    pub(crate) fn weights(self, wo: &[Lane; 3], facets: &mut Facets, out: &mut Lane) {
        match self {
            Self::None => drawn(wo, facets, out, Unmasked),
            Self::VGroove => drawn(wo, facets, out, Groove),
            Self::Smith(axes) => drawn(wo, facets, out, Ggx::<false> { axes }),
            Self::SmithCorrelated(axes) => drawn(wo, facets, out, Ggx::<true> { axes }),
            Self::Neubelt => drawn(wo, facets, out, Neubelt),
        }
    }

    /// [`Masking::visible_weight`] of the facets `h`, and o.h; 0 where the facet faces away or wi points down.
    pub(crate) fn visible_weights(self, wo: &[Lane; 3], facets: &mut Facets, out: &mut Lane) {
        match self {
            Self::None => drawn(wo, facets, out, Visible(Unmasked)),
            Self::VGroove => drawn(wo, facets, out, Visible(Groove)),
            Self::Smith(axes) => drawn(wo, facets, out, Visible(Ggx::<false> { axes })),
            Self::SmithCorrelated(axes) => drawn(wo, facets, out, Visible(Ggx::<true> { axes })),
            Self::Neubelt => drawn(wo, facets, out, Visible(Neubelt)),
        }
    }

    /// Half vectors of wo and wi, and V'/(4 (n.o)(n.i)), which is [`Masking::shape`] times n.h.
    pub(crate) fn visibilities(self, wo: &[Lane; 3], wi: &[Lane; 3], facets: &mut Facets, out: &mut Lane) {
        match self {
            Self::None => between(wo, wi, facets, out, Unmasked),
            Self::VGroove => between(wo, wi, facets, out, Groove),
            Self::Smith(axes) => between(wo, wi, facets, out, Ggx::<false> { axes }),
            Self::SmithCorrelated(axes) => between(wo, wi, facets, out, Ggx::<true> { axes }),
            Self::Neubelt => between(wo, wi, facets, out, Neubelt),
        }
    }
}

/// The normals that wo sees of GGX slopes, as [`Smith::sample_visible`] draws them.
#[multiversion(targets("x86_64+avx512f+avx512dq", "x86_64+avx2", "x86_64+avx"))]
pub(crate) fn visible_slopes(axes: [f64; 2], wo: &[Lane; 3], u: [&Lane; 2], h: &mut [Lane; 3]) {
    let [hx, hy, hz] = h;
    for k in 0..BLOCK {
        let (x, y, z) = (axes[0] * wo[0][k], axes[1] * wo[1][k], wo[2][k]);
        let across = x * x + y * y;
        let scale = 1.0 / (across + z * z).sqrt();
        let (x, y, z) = (x * scale, y * scale, z * scale);
        let whole = 1.0 + z;
        let short = (x * x + y * y) / whole;
        let rest = 1.0 - u[0][k];
        let radius = (u[0][k] * whole * (2.0 * rest + u[0][k] * short)).sqrt();
        let (sin, cos) = sin_cos_turns(u[1][k]);
        let (x, y, z) = (axes[0] * (x + radius * cos), axes[1] * (y + radius * sin), rest * whole);
        let scale = 1.0 / (x * x + y * y + z * z).sqrt();
        (hx[k], hy[k], hz[k]) = (x * scale, y * scale, z * scale);
    }
}

/// Turns a normal drawn from p(h) into its twin on the other wall of the groove where wo sees that one, as
/// [`super::sample_visible_groove`] does.
#[multiversion(targets("x86_64+avx512f+avx512dq", "x86_64+avx2", "x86_64+avx"))]
pub(crate) fn visible_walls(wo: &[Lane; 3], u: &Lane, h: &mut [Lane; 3]) {
    let [hx, hy, hz] = h;
    for k in 0..BLOCK {
        let (across, up) = (wo[0][k] * hx[k] + wo[1][k] * hy[k], wo[2][k] * hz[k]);
        let (near, far) = ((up + across).max(0.0), (up - across).max(0.0));
        let side = if u[k] * (near + far) < near { 1.0 } else { -1.0 };
        (hx[k], hy[k]) = (side * hx[k], side * hy[k]);
    }
}

/// The cosines of a pair of directions, and their coordinates along the tangents.
#[derive(Clone, Copy)]
struct Pair {
    o: f64,
    i: f64,
    h: f64,
    d: f64,
    wo: [f64; 2],
    wi: [f64; 2],
}

#[multiversion(targets("x86_64+avx512f+avx512dq", "x86_64+avx2", "x86_64+avx"))]
fn drawn<T: Term>(wo: &[Lane; 3], facets: &mut Facets, out: &mut Lane, term: T) {
    let Facets { h: [hx, hy, hz], cos_d } = facets;
    for k in 0..BLOCK {
        let wo = [wo[0][k], wo[1][k], wo[2][k]];
        let h = [hx[k], hy[k], hz[k]];
        let along = wo[0] * h[0] + wo[1] * h[1] + wo[2] * h[2];
        let d = if along < 1.0 { along } else { 1.0 };
        let i = 2.0 * d * h[2] - wo[2];
        let pair = Pair {
            o: wo[2].abs(), // -0 is above
            i,
            h: h[2],
            d,
            wo: [wo[0], wo[1]],
            wi: [2.0 * along * h[0] - wo[0], 2.0 * along * h[1] - wo[1]],
        };
        let weight = term.weight(pair);
        cos_d[k] = d;
        out[k] = if (d > 0.0) & (i > 0.0) & (h[2] > 0.0) {
            weight
        } else {
            0.0
        };
    }
}

#[multiversion(targets("x86_64+avx512f+avx512dq", "x86_64+avx2", "x86_64+avx"))]
fn between<T: Term>(wo: &[Lane; 3], wi: &[Lane; 3], facets: &mut Facets, out: &mut Lane, term: T) {
    let Facets { h: [hx, hy, hz], cos_d } = facets;
    for k in 0..BLOCK {
        let sum = [wo[0][k] + wi[0][k], wo[1][k] + wi[1][k], wo[2][k] + wi[2][k]];
        let length = (sum[0] * sum[0] + sum[1] * sum[1] + sum[2] * sum[2]).sqrt();
        let scale = 1.0 / length;
        let half = 0.5 * length;
        let pair = Pair {
            o: wo[2][k].abs(), // -0 is above
            i: wi[2][k],
            h: sum[2] * scale,
            d: if half < 1.0 { half } else { 1.0 },
            wo: [wo[0][k], wo[1][k]],
            wi: [wi[0][k], wi[1][k]],
        };
        (hx[k], hy[k], hz[k]) = (sum[0] * scale, sum[1] * scale, pair.h);
        cos_d[k] = pair.d;
        let visibility = term.visibility(pair);
        out[k] = if pair.h > 0.0 { visibility } else { 0.0 };
    }
}

/// A masking term made ready for loops.
trait Term: Copy {
    /// V' (o.h)/((n.o)(n.h)).
    fn weight(self, p: Pair) -> f64;

    /// The same over G1(o, h).
    fn visible_weight(self, p: Pair) -> f64;

    /// V'/(4 (n.o)(n.i)).
    fn visibility(self, p: Pair) -> f64;
}

/// `term` over the density of visible normals.
#[derive(Clone, Copy)]
struct Visible<T>(T);

impl<T: Term> Term for Visible<T> {
    #[inline(always)]
    fn weight(self, p: Pair) -> f64 {
        self.0.visible_weight(p)
    }

    #[inline(always)]
    fn visible_weight(self, p: Pair) -> f64 {
        self.0.visible_weight(p)
    }

    #[inline(always)]
    fn visibility(self, p: Pair) -> f64 {
        self.0.visibility(p)
    }
}

#[derive(Clone, Copy)]
struct Unmasked;

impl Term for Unmasked {
    #[inline(always)]
    fn weight(self, p: Pair) -> f64 {
        p.d / (p.o * p.h)
    }

    #[inline(always)]
    fn visible_weight(self, p: Pair) -> f64 {
        let unmasked = self.weight(p);
        unmasked / unmasked.min(2.0)
    }

    /// f is 0 at the horizon, where its limit is infinite.
    #[inline(always)]
    fn visibility(self, p: Pair) -> f64 {
        let product = p.o * p.i;
        if product > 0.0 { 0.25 / product } else { 0.0 }
    }
}

#[derive(Clone, Copy)]
struct Groove;

impl Term for Groove {
    #[inline(always)]
    fn weight(self, p: Pair) -> f64 {
        let unmasked = p.d / (p.o * p.h);
        unmasked.min(2.0).min(2.0 * p.i / p.o)
    }

    #[inline(always)]
    fn visible_weight(self, p: Pair) -> f64 {
        let density = (p.d / (p.o * p.h)).min(2.0);
        density.min(2.0 * p.i / p.o) / density
    }

    #[inline(always)]
    fn visibility(self, p: Pair) -> f64 {
        let highest = p.i.max(p.o);
        let masked = (0.25 / (p.i * p.o)).min(0.5 * p.h / (p.d * highest));
        if highest > 0.0 { masked } else { 0.0 }
    }
}

#[derive(Clone, Copy)]
struct Neubelt;

impl Term for Neubelt {
    #[inline(always)]
    fn weight(self, p: Pair) -> f64 {
        (4.0 * neubelt(p.o, p.i) * p.i * (p.d / p.h)).min(LARGEST)
    }

    #[inline(always)]
    fn visible_weight(self, p: Pair) -> f64 {
        self.weight(p) / (p.d / (p.o * p.h)).min(2.0)
    }

    #[inline(always)]
    fn visibility(self, p: Pair) -> f64 {
        if p.o + p.i > 0.0 { neubelt(p.o, p.i) } else { 0.0 }
    }
}

/// Smith masking of GGX slopes.
#[derive(Clone, Copy)]
struct Ggx<const CORRELATED: bool> {
    axes: [f64; 2],
}

impl<const CORRELATED: bool> Ggx<CORRELATED> {
    /// [`Smith::hidden`]
    #[inline(always)]
    fn hidden(self, w: [f64; 2], cos: f64) -> f64 {
        let (x, y) = (self.axes[0] * w[0], self.axes[1] * w[1]);
        let square = x * x + y * y;
        0.5 * square / (cos + (cos * cos + square).sqrt())
    }
}

impl<const CORRELATED: bool> Term for Ggx<CORRELATED> {
    #[inline(always)]
    fn weight(self, p: Pair) -> f64 {
        let (hidden_o, hidden_i) = (self.hidden(p.wo, p.o), self.hidden(p.wi, p.i));
        let seen = p.o + hidden_o;
        if CORRELATED {
            let weight = p.d / p.h * (p.i / (p.i * seen + p.o * hidden_i));
            weight.min(LARGEST)
        } else {
            p.d / seen * (p.i / (p.h * (p.i + hidden_i)))
        }
    }

    #[inline(always)]
    fn visible_weight(self, p: Pair) -> f64 {
        let hidden_i = self.hidden(p.wi, p.i);
        if CORRELATED {
            let g1 = p.o / (p.o + self.hidden(p.wo, p.o));
            p.i / (p.i + g1 * hidden_i)
        } else {
            p.i / (p.i + hidden_i)
        }
    }

    #[inline(always)]
    fn visibility(self, p: Pair) -> f64 {
        let (hidden_o, hidden_i) = (self.hidden(p.wo, p.o), self.hidden(p.wi, p.i));
        let visibility = if CORRELATED {
            0.25 / (p.o * p.i + (p.i * hidden_o + p.o * hidden_i))
        } else {
            0.25 / ((p.o + hidden_o) * (p.i + hidden_i))
        };
        if p.o + p.i > 0.0 { visibility } else { 0.0 }
    }
}
