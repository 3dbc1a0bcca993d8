//! Smith masking: facets whose heights and normals know nothing of each other [Smith 1967; Heitz 2014].
//!
//! Beckmann and GGX are one round distribution of slopes each, stretched along the tangents by (a_x, a_y). A direction w
//! sees the round one under the angle with the tangent t/(n.w), t = hypot(a_x w.x, a_y w.y). Its shape decides how much
//! facet area is turned towards w and how much away from it, both projected along w and per area of the surface:
//!
//! seen(w) = int D(h) max(0, w.h) dh, hidden(w) = int D(h) max(0, -w.h) dh, seen - hidden = n.w.
//!
//! In the usual notation hidden = (n.w) Lambda(w) and seen = (n.w) (1 + Lambda(w)). The areas stay finite where n.w = 0 and
//! Lambda is infinite, and everything here is made of them:
//!
//! - G1(w) = 1/(1 + Lambda) = (n.w)/seen(w), for every facet turned towards w;
//! - uncorrelated G2 = G1(o) G1(i) = (n.o)(n.i)/(seen(o) seen(i));
//! - height-correlated G2 = 1/(1 + Lambda(o) + Lambda(i)) = (n.o)(n.i)/J with
//!   J = (n.o)(n.i) + (n.i) hidden(o) + (n.o) hidden(i) [Heitz 2014, eq. 99].

use super::{Cosines, LARGEST};
use crate::distribution::{Distribution, Elliptic, Isotropic};
use crate::numerics::gaussian::ierfc;
use glam::{DVec2, DVec3};

/// A distribution of slopes under Smith masking.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Smith {
    pub(super) shape: Shape,
    /// Widths of the slopes along the tangents.
    pub(super) axes: DVec2,
}

/// The round distributions of slopes of unit width.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Shape {
    /// e^(-s^2)/pi, Beckmann.
    Gaussian,
    /// 1/(pi (1 + s^2)^2), GGX.
    Ggx,
}

impl Smith {
    /// `None` for distributions that are not stretched from a round one: only Beckmann and GGX have a Lambda here.
    pub fn new(distribution: &Distribution) -> Option<Self> {
        let (shape, axes) = match distribution {
            Distribution::Isotropic(Isotropic::Beckmann(d)) => (Shape::Gaussian, DVec2::splat(d.m())),
            Distribution::Isotropic(Isotropic::Ggx(d)) => (Shape::Ggx, DVec2::splat(d.alpha())),
            Distribution::Isotropic(Isotropic::Vmf(_) | Isotropic::Phong(_) | Isotropic::Charlie(_)) => return None,
            Distribution::Anisotropic(d) => match d.kind() {
                Elliptic::Beckmann => (Shape::Gaussian, d.axes()),
                Elliptic::Ggx => (Shape::Ggx, d.axes()),
                Elliptic::AshikhminShirley => return None,
            },
        };
        Some(Self { shape, axes })
    }

    /// Whether it is GGX, and its width along the first tangent: all there is to know of an isotropic one.
    pub(crate) fn round(&self) -> (bool, f64) {
        (self.shape == Shape::Ggx, self.axes.x)
    }

    /// t = hypot(a_x w.x, a_y w.y), the sine of w as the round distribution sees it, for a cosine that is kept.
    fn sine(&self, w: DVec3) -> f64 {
        let stretched = self.axes * w.truncate();
        libm::hypot(stretched.x, stretched.y)
    }

    /// int D(h) max(0, -w.h) dh = (n.w) Lambda(w), for w with n.w = `cos` in [0, 1].
    ///
    /// - Beckmann: t ierfc(a)/2 with a = (n.w)/t; this is Lambda = (erf(a) - 1)/2 + e^(-a^2)/(2 sqrt(pi) a)
    ///   [Heitz 2014, eq. 66] times n.w, with the difference of its terms formed as one function.
    /// - GGX: (sqrt((n.w)^2 + t^2) - n.w)/2 [Heitz 2014, eq. 72], without the difference.
    pub fn hidden(&self, w: DVec3, cos: f64) -> f64 {
        let t = self.sine(w);
        if t == 0.0 {
            return 0.0;
        }
        match self.shape {
            Shape::Gaussian => 0.5 * t * ierfc(cos / t),
            Shape::Ggx => 0.5 * t * (t / (cos + libm::hypot(cos, t))),
        }
    }

    /// int D(h) max(0, w.h) dh = (n.w) (1 + Lambda(w)), for w with n.w = `cos` in [0, 1]; never 0.
    pub fn seen(&self, w: DVec3, cos: f64) -> f64 {
        cos + self.hidden(w, cos)
    }

    /// Lambda(w), from 0 at the normal to infinity at the horizon, for w with n.w = `cos` in [0, 1].
    pub fn lambda(&self, w: DVec3, cos: f64) -> f64 {
        self.hidden(w, cos) / cos
    }

    /// G1(w) = 1/(1 + Lambda(w)) for w with n.w = `cos` in [0, 1].
    pub fn g1(&self, w: DVec3, cos: f64) -> f64 {
        cos / self.seen(w, cos)
    }

    /// G2/(4 (n.o)(n.i)), the factor of D in the BRDF: 1/(4 seen(o) seen(i)), or correlated 1/(4 J).
    ///
    /// Symmetric in the two directions to the last bit. With one direction at the horizon both are finite, with both there
    /// the correlated one is infinite.
    pub(crate) fn visibility(&self, correlated: bool, wo: DVec3, wi: DVec3, cos: Cosines) -> f64 {
        if correlated {
            let hidden = cos.i * self.hidden(wo, cos.o) + cos.o * self.hidden(wi, cos.i);
            0.25 / (cos.o * cos.i + hidden)
        } else {
            0.25 / (self.seen(wo, cos.o) * self.seen(wi, cos.i))
        }
    }

    /// G2 (o.h)/((n.o)(n.h)) for h half way between the directions.
    ///
    /// In i = (n.i)/(n.h) and o = (n.o)/(n.h), which add up to 2 (o.h), it is (o.h) i/(seen(o) seen(i)), or correlated
    /// (o.h)/(n.h) i/(i seen(o) + o hidden(i)): nothing is divided by n.o. The correlated one grows without bound as n.h -> 0
    /// with n.o = 0, though p times it does not; at n.h = 0, where p = 0, the largest number stands for it.
    pub(super) fn weight(&self, correlated: bool, wo: DVec3, wi: DVec3, cos: Cosines) -> f64 {
        // at n.h = 0 both directions lie at the horizon; the limit is that of wo staying there
        let (o, i) = if cos.h > 0.0 {
            (cos.o / cos.h, cos.i / cos.h)
        } else {
            (0.0, 2.0 * cos.d)
        };
        let seen = self.seen(wo, cos.o);
        if correlated {
            (cos.d / cos.h * (i / (i * seen + o * self.hidden(wi, cos.i)))).min(LARGEST)
        } else {
            cos.d / seen * (i / self.seen(wi, cos.i))
        }
    }

    /// G2/G1(o), which is at most 1: G1(i), or correlated 1/(1 + G1(o) Lambda(i)).
    pub(crate) fn visible_weight(&self, correlated: bool, wo: DVec3, wi: DVec3, cos: Cosines) -> f64 {
        if !correlated {
            return self.g1(wi, cos.i);
        }
        let g1 = self.g1(wo, cos.o);
        // nothing of wi is masked that wo, at the horizon, does not see: 0 times an infinite Lambda
        if g1 == 0.0 {
            return 1.0;
        }
        1.0 / (1.0 + g1 * self.lambda(wi, cos.i))
    }
}
