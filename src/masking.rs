//! Masking and shadowing: which part of the facets both directions see.

use crate::distribution::Distribution;
use glam::DVec3;

/// Masking-shadowing terms.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Masking {
    /// Every facet is seen. Does not conserve energy: the albedo grows without bound at grazing angles.
    None,
    /// Symmetric V-shaped grooves [Mikkelsen 2009, eq. 25], with the indicators o.h > 0 and n.i > 0 that the printed
    /// equation leaves out.
    VGroove,
}

/// The cosines that a masking term needs, all non-negative.
#[derive(Debug, Clone, Copy)]
pub struct Cosines {
    /// n.wo
    pub o: f64,
    /// n.wi
    pub i: f64,
    /// n.wh
    pub h: f64,
    /// wo.wh = wi.wh
    pub d: f64,
}

impl Masking {
    /// Weight of a half vector drawn from p(h): V' (o.h)/((n.o)(n.h)) [Mikkelsen 2009, eq. 30].
    ///
    /// For V-grooves this is min((o.h)/((n.o)(n.h)), 2, 2 (n.i)/(n.o)): bounded by 2, and finite as n.o -> 0.
    pub fn weight(self, cos: Cosines) -> f64 {
        let unmasked = cos.d / (cos.o * cos.h);
        match self {
            Self::None => unmasked,
            Self::VGroove => unmasked.min(2.0).min(2.0 * cos.i / cos.o),
        }
    }

    /// The factor of p in the BRDF, V'/(4 (n.i)(n.o)(n.h)) [Mikkelsen 2009, eq. 18].
    ///
    /// For V-grooves it is min(1/(4 (n.i)(n.o)(n.h)), 1/(2 (o.h) max(n.i, n.o))), which is finite with one direction at
    /// the horizon and symmetric in the two directions to the last bit.
    pub fn shape(self, cos: Cosines) -> f64 {
        let unmasked = 0.25 / (cos.i * cos.o * cos.h);
        match self {
            Self::None => unmasked,
            Self::VGroove => unmasked.min(0.5 / (cos.d * cos.i.max(cos.o))),
        }
    }
}

/// A normal drawn from those that `wo` sees on V-grooves: density G1(o, h) max(0, o.h) D(h)/(n.o), with `u` in [0, 1)^3.
///
/// A groove has the two normals h and h' = (-h.x, -h.y, h.z), and their cosines add up to 2 (n.h)(n.o). The groove is drawn
/// from p(h); of its two walls each is seen in proportion to max(0, o.h) and max(0, o.h').
pub fn sample_visible_groove(distribution: &Distribution, wo: DVec3, u: [f64; 3]) -> DVec3 {
    let wm = distribution.sample([u[0], u[1]]);
    let twin = DVec3::new(-wm.x, -wm.y, wm.z);
    let (near, far) = (wo.dot(wm).max(0.0), wo.dot(twin).max(0.0));
    if u[2] * (near + far) < near { wm } else { twin }
}

/// Density of [`sample_visible_groove`] over solid angle, p(h) min((o.h)/((n.h)(n.o)), 2), for o.h > 0; 0 otherwise.
pub fn visible_groove_pdf(distribution: &Distribution, cos_o: f64, h: DVec3, cos_d: f64) -> f64 {
    if cos_d <= 0.0 {
        return 0.0;
    }
    distribution.p(h) * (cos_d / (h.z * cos_o)).min(2.0)
}
