//! Microfacet reflection, the Torrance-Sparrow model [Mikkelsen 2009, eq. 18; pbrt 2010, section 8.4.2].

mod lanes;
#[cfg(test)]
mod tests;

use super::weights::one_by_one;
use super::{Bxdf, BxdfSample, Draws, Flags, Lane, ModelError, Sampling, opposite_sides};
use crate::distribution::{Distribution, Isotropic};
use crate::fresnel::Fresnel;
use crate::geometry::{Polar, half_vector, reflect};
use crate::masking::{Cosines, LARGEST, Masking, Smith};
use crate::parameter::REFLECTANCE;
use crate::spectrum::{Channels, Spectrum};
use glam::DVec3;
use std::f64::consts::TAU;

/// f = R F(o.h) V'(h, o, i) p(h)/(4 (n.i)(n.o)(n.h)).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Microfacet {
    /// Scale R of the lobe.
    pub reflectance: Spectrum,
    /// Distribution of the normals.
    pub distribution: Distribution,
    /// Masking-shadowing V'.
    pub masking: Masking,
    /// Fresnel term F.
    pub fresnel: Fresnel,
}

impl Microfacet {
    /// Reflectance in [0, 1] in every channel, [`REFLECTANCE`]; distribution and Fresnel term were checked when they were made.
    ///
    /// # Errors
    /// [`ModelError::Parameter`] outside that range, with the value and the range; [`ModelError::SmithNeedsSlopes`] for Smith masking of a distribution
    /// other than Beckmann and GGX; [`ModelError::SheenNeedsCharlie`] for Charlie without one of the maskings of sheen, and for those
    /// with another distribution.
    pub fn new(
        reflectance: Spectrum,
        distribution: impl Into<Distribution>,
        masking: Masking,
        fresnel: Fresnel,
    ) -> Result<Self, ModelError> {
        let distribution = distribution.into();
        let is_charlie = matches!(distribution, Distribution::Isotropic(Isotropic::Charlie(_)));
        if masking.is_smith() && Smith::new(&distribution).is_none() {
            return Err(ModelError::SmithNeedsSlopes {
                masking: masking.name(),
                distribution: distribution.name(),
            });
        }
        if masking.is_sheen() != is_charlie {
            return Err(ModelError::SheenNeedsCharlie {
                masking: masking.name(),
                distribution: distribution.name(),
            });
        }
        Ok(Self {
            reflectance: reflectance.check(REFLECTANCE)?,
            distribution,
            masking,
            fresnel,
        })
    }

    /// R F(o.h).
    pub fn facet_reflectance(&self, cos_d: f64) -> DVec3 {
        self.reflectance.value() * self.fresnel.reflectance(cos_d)
    }

    /// R F at the facet angle theta_d.
    pub fn facet_reflectance_at(&self, theta_d: Polar) -> DVec3 {
        self.reflectance.value() * self.fresnel.reflectance_at(theta_d)
    }

    /// What stands for `sampling`: see [`Bxdf::sample_f`].
    fn drawn(&self, sampling: Sampling) -> Sampling {
        match sampling {
            Sampling::Visible | Sampling::Bxdf if self.masking.is_sheen() => Sampling::Uniform,
            other => other,
        }
    }

    /// wi from wo mirrored by the facet normal, with its cosines; `None` where the facet faces away or wi points down.
    ///
    /// Without masking f has no limit for wo at the horizon, where it counts 0 and draws are in vain.
    fn mirrored(&self, wo: DVec3, wm: DVec3) -> (DVec3, Option<Cosines>) {
        let wi = reflect(wo, wm);
        let cos_d = wo.dot(wm).min(1.0);
        let cos_i = 2.0 * cos_d * wm.z - wo.z;
        let cosines = Cosines {
            o: wo.z.abs(), // -0 is above
            i: cos_i,
            h: wm.z,
            d: cos_d,
        };
        let has_limit = self.masking != Masking::None || wo.z != 0.0;
        let seen = cos_d > 0.0 && cos_i > 0.0 && wm.z > 0.0;
        (wi, (seen && has_limit).then_some(cosines))
    }
}

impl Bxdf for Microfacet {
    fn channels(&self) -> Channels {
        self.reflectance.channels().max(self.fresnel.channels())
    }

    fn flags(&self) -> Flags {
        Flags::REFLECTION | Flags::GLOSSY
    }

    fn f(&self, wo: DVec3, wi: DVec3) -> DVec3 {
        // the sum, so that a direction at the horizon goes with either side
        let (wo, wi) = if wo.z + wi.z < 0.0 { (-wo, -wi) } else { (wo, wi) };
        let highest = wo.z.max(wi.z);
        let lowest = wo.z.min(wi.z);
        // without masking the limit at the horizon is infinite; with it one direction may lie there
        if lowest < 0.0 || highest <= 0.0 || (self.masking == Masking::None && lowest == 0.0) {
            return DVec3::ZERO;
        }
        let Some(half) = half_vector(wo, wi) else {
            return DVec3::ZERO;
        };
        let cosines = Cosines {
            o: wo.z.abs(), // -0 is above
            i: wi.z.abs(),
            h: half.wh.z,
            d: half.cos_d,
        };
        self.facet_reflectance(half.cos_d) * self.masking.lobe(&self.distribution, wo, wi, half.wh, cosines)
    }

    /// The density of visible normals, mirrored; under the maskings of sheen 1/(2 pi).
    fn pdf(&self, wo: DVec3, wi: DVec3) -> f64 {
        if self.masking.is_sheen() {
            return if opposite_sides(wo, wi) { 0.0 } else { TAU.recip() };
        }
        let (wo, wi) = if wo.z < 0.0 { (-wo, -wi) } else { (wo, wi) };
        let Some(half) = half_vector(wo, wi) else { return 0.0 };
        if half.wh.z <= 0.0 {
            return 0.0;
        }
        self.masking
            .visible_pdf(&self.distribution, wo, wo.z.abs(), half.wh, half.cos_d)
    }

    /// Visible normals; under the maskings of sheen, whose facets all directions meet at a slant, the hemisphere uniformly,
    /// as their authors do: of normals drawn from p the weights have no bound.
    fn sample_f(&self, wo: DVec3, u: [f64; 3]) -> BxdfSample {
        self.sample(Sampling::Bxdf, wo, u)
    }

    /// All but visible normals under the maskings of sheen, which say of no facet whether it is seen.
    fn supports(&self, sampling: Sampling) -> bool {
        sampling != Sampling::Visible || !self.masking.is_sheen()
    }

    /// A third number chooses between the walls of a groove.
    fn dimensions(&self, sampling: Sampling) -> usize {
        match sampling {
            Sampling::Visible | Sampling::Bxdf if !self.masking.is_smith() && !self.masking.is_sheen() => 3,
            _ => 2,
        }
    }

    fn weights(&self, sampling: Sampling, side: Flags, draws: Draws<'_>, weights: &mut [Lane; 3]) {
        if !self.lanes(sampling, side, draws, weights) {
            one_by_one(self, sampling, side, draws, weights);
        }
    }

    fn sample(&self, sampling: Sampling, wo: DVec3, u: [f64; 3]) -> BxdfSample {
        match self.drawn(sampling) {
            Sampling::Uniform => super::sample_uniform(self, wo, u),
            Sampling::Cosine => super::sample_cosine(self, wo, u),
            Sampling::Normals | Sampling::Visible | Sampling::Bxdf if wo.z < 0.0 => {
                let above = self.sample(sampling, -wo, u);
                BxdfSample { wi: -above.wi, ..above }
            }
            // f cos/pdf = F V' (o.h)/((n.o)(n.h)) with pdf = p/(4 o.h)
            Sampling::Normals => {
                let wm = self.distribution.sample([u[0], u[1]]);
                let (wi, Some(cosines)) = self.mirrored(wo, wm) else {
                    return BxdfSample::lost(reflect(wo, wm));
                };
                // narrow lobes at mu = 1e-300 exceed the largest number
                let pdf = (self.distribution.p(wm) / (4.0 * cosines.d)).min(LARGEST);
                if pdf == 0.0 {
                    // no facet of Charlie lies flat, and u = 0 draws the one that does
                    return BxdfSample::lost(wi);
                }
                let weight =
                    self.facet_reflectance(cosines.d) * self.masking.weight(&self.distribution, wo, wi, cosines);
                BxdfSample {
                    wi,
                    pdf,
                    weight,
                    flags: self.flags(),
                }
            }
            // f cos/pdf = F V'/G1(o, h), which V-grooves and Smith bound by 1; without masking V' = 1 stays over the density
            // of V-grooves
            Sampling::Visible | Sampling::Bxdf => {
                let wm = self.masking.sample_visible(&self.distribution, wo, u);
                let (wi, Some(cosines)) = self.mirrored(wo, wm) else {
                    return BxdfSample::lost(reflect(wo, wm));
                };
                let seen = self.masking.visible_weight(&self.distribution, wo, wi, cosines);
                let weight = self.facet_reflectance(cosines.d) * seen;
                let pdf = self
                    .masking
                    .visible_pdf(&self.distribution, wo, cosines.o, wm, cosines.d);
                let flags = self.flags();
                BxdfSample { wi, pdf, weight, flags }
            }
        }
    }
}
