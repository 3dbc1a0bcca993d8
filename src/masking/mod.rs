//! Masking and shadowing: which part of the facets both directions see.
//!
//! Directions lie above the surface; callers flip those below it.

pub(crate) mod lanes;
mod sheen;
mod smith;
#[cfg(test)]
mod tests;
mod v_groove;
mod visible;

pub(crate) use sheen::{Fit, HALF, neubelt};
pub use smith::Smith;
pub use v_groove::{sample_visible_groove, visible_groove_pdf};

use crate::distribution::Distribution;
use glam::DVec3;

/// Where f and densities that diverge, with both directions near the horizon, end, so that sums of several stay finite.
pub const LARGEST: f64 = 1e300;

/// Masking-shadowing terms.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Masking {
    /// Every facet is seen. Does not conserve energy: the albedo grows without bound at grazing angles.
    None,
    /// Symmetric V-shaped grooves [Mikkelsen 2009, eq. 25], with the indicators o.h > 0 and n.i > 0 that the printed
    /// equation leaves out.
    VGroove,
    /// Smith, G2 = G1(o) G1(i): being seen by one direction says nothing about the other. Beckmann and GGX only.
    Smith,
    /// Smith, G2 = 1/(1 + Lambda(o) + Lambda(i)): high facets are seen by both directions. Beckmann and GGX only.
    SmithCorrelated,
    /// The smooth visibility of Ashikhmin and Premoze, which Neubelt and Pettineo made popular:
    /// V'/(4 (n.o)(n.i)) = 1/(4 (n.o + n.i - (n.o)(n.i))), whatever the distribution is. Exceeds what conserves energy.
    /// Charlie only.
    Neubelt,
    /// G = 1/(1 + Lambda(o) + Lambda(i)) with the Lambda that Estevez and Kulla fitted to their distribution, continued with a
    /// pole below n.w = 5e-5, where the fit loses it. Charlie only.
    Charlie,
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
    /// Name as it stands in a scene file.
    pub fn name(self) -> &'static str {
        match self {
            Self::None => "none",
            Self::VGroove => "v-groove",
            Self::Smith => "smith",
            Self::SmithCorrelated => "smith-correlated",
            Self::Neubelt => "neubelt",
            Self::Charlie => "charlie",
        }
    }

    /// Whether this is one of the two Smith terms, which need a [`Smith`] distribution.
    pub fn is_smith(self) -> bool {
        matches!(self, Self::Smith | Self::SmithCorrelated)
    }

    /// Whether this is one of the two terms of sheen, which go with [`crate::distribution::Charlie`] only.
    pub fn is_sheen(self) -> bool {
        matches!(self, Self::Neubelt | Self::Charlie)
    }

    /// The slopes that a Smith term needs. `None` for other terms, and for distributions that no Smith term goes with:
    /// [`crate::bxdf::Microfacet::new`] refuses those, and here such a pair masks everything.
    fn smith(self, distribution: &Distribution) -> Option<Smith> {
        Smith::new(distribution).filter(|_| self.is_smith())
    }

    /// Weight of a half vector drawn from p(h): V' (o.h)/((n.o)(n.h)) [Mikkelsen 2009, eq. 30].
    ///
    /// For V-grooves this is min((o.h)/((n.o)(n.h)), 2, 2 (n.i)/(n.o)): bounded by 2, and finite as n.o -> 0. For Smith it
    /// is (o.h) (n.i)/(n.h) over seen(o) seen(i), or over the correlated form of that, see [`Smith`]: finite as n.o -> 0
    /// too, but for facets far off the lobe it grows like the inverse of the roughness.
    pub fn weight(self, distribution: &Distribution, wo: DVec3, wi: DVec3, cos: Cosines) -> f64 {
        let unmasked = cos.d / (cos.o * cos.h);
        match self {
            Self::None => unmasked.min(LARGEST),
            Self::VGroove => unmasked.min(2.0).min(2.0 * cos.i / cos.o),
            Self::Smith | Self::SmithCorrelated => self
                .smith(distribution)
                .map_or(0.0, |smith| smith.weight(self == Self::SmithCorrelated, wo, wi, cos)),
            Self::Neubelt | Self::Charlie => {
                (4.0 * self.sheen(distribution, cos) * cos.i * (cos.d / cos.h)).min(LARGEST)
            }
        }
    }

    /// The factor of p in the BRDF, V'/(4 (n.i)(n.o)(n.h)) [Mikkelsen 2009, eq. 18].
    ///
    /// Symmetric in the two directions to the last bit. For V-grooves it is
    /// min(1/(4 (n.i)(n.o)(n.h)), 1/(2 (o.h) max(n.i, n.o))), for Smith 1/(4 (n.h) seen(o) seen(i)) or the correlated form
    /// of that: finite with one direction at the horizon.
    pub fn shape(self, distribution: &Distribution, wo: DVec3, wi: DVec3, cos: Cosines) -> f64 {
        let unmasked = 0.25 / (cos.i * cos.o * cos.h);
        match self {
            Self::None => unmasked,
            Self::VGroove => unmasked.min(0.5 / (cos.d * cos.i.max(cos.o))),
            Self::Smith | Self::SmithCorrelated => self.smith(distribution).map_or(0.0, |smith| {
                smith.visibility(self == Self::SmithCorrelated, wo, wi, cos) / cos.h
            }),
            Self::Neubelt | Self::Charlie => self.sheen(distribution, cos) / cos.h,
        }
    }

    /// The BRDF but for its Fresnel term, V' D(h)/(4 (n.i)(n.o)) = [`Masking::shape`] times p, in sr^-1.
    ///
    /// With both directions within 1e-150 or so of the horizon and of each other's mirror image it may exceed the largest
    /// number, which then takes its place.
    pub fn lobe(self, distribution: &Distribution, wo: DVec3, wi: DVec3, h: DVec3, cos: Cosines) -> f64 {
        let (shape, density) = match self {
            Self::None | Self::VGroove => (self.shape(distribution, wo, wi, cos), distribution.p(h)),
            // D of Beckmann and GGX is finite at the horizon: n.h, which may underflow in p, is not needed
            Self::Smith | Self::SmithCorrelated => match self.smith(distribution) {
                Some(smith) => (
                    smith.visibility(self == Self::SmithCorrelated, wo, wi, cos),
                    distribution.d(h),
                ),
                None => return 0.0,
            },
            Self::Neubelt | Self::Charlie => (self.sheen(distribution, cos), distribution.d(h)),
        };
        // a density that vanishes outweighs a shape that has overflowed
        if density == 0.0 {
            0.0
        } else {
            (shape * density).min(LARGEST)
        }
    }

    /// A normal drawn from those that `wo` sees: density G1(o, h) max(0, o.h) D(h)/(n.o), with `u` in [0, 1)^3.
    ///
    /// Without masking, and under that of sheen, these are the normals that V-grooves show.
    pub fn sample_visible(self, distribution: &Distribution, wo: DVec3, u: [f64; 3]) -> DVec3 {
        match self.smith(distribution) {
            Some(smith) => smith.sample_visible(wo, [u[0], u[1]]),
            None => sample_visible_groove(distribution, wo, u),
        }
    }

    /// Density of the direction that a normal of [`Masking::sample_visible`] mirrors `wo` into, for n.o = `cos_o` >= 0,
    /// n.h > 0 and o.h = `cos_d` > 0; in sr^-1.
    ///
    /// dwi = 4 (o.h) dh [Mikkelsen 2009, eq. 15]; for Smith D_o(h)/(4 (o.h)) = D(h)/(4 seen(o)).
    pub fn visible_pdf(self, distribution: &Distribution, wo: DVec3, cos_o: f64, h: DVec3, cos_d: f64) -> f64 {
        match self.smith(distribution) {
            Some(smith) => 0.25 * distribution.d(h) / smith.seen(wo, cos_o),
            None => (visible_groove_pdf(distribution, cos_o, h, cos_d) / (4.0 * cos_d)).min(LARGEST),
        }
    }

    /// f |cos theta_i|/pdf of such a direction but for the Fresnel term: V'/G1(o, h), at most 1 for V-grooves and Smith.
    pub fn visible_weight(self, distribution: &Distribution, wo: DVec3, wi: DVec3, cos: Cosines) -> f64 {
        match self {
            // the sheen terms have no visible normals of their own
            Self::None | Self::VGroove | Self::Neubelt | Self::Charlie => {
                let density = (cos.d / (cos.h * cos.o)).min(2.0);
                self.weight(distribution, wo, wi, cos) / density
            }
            Self::Smith | Self::SmithCorrelated => self.smith(distribution).map_or(0.0, |smith| {
                smith.visible_weight(self == Self::SmithCorrelated, wo, wi, cos)
            }),
        }
    }
}
