//! Models that are wrong on purpose: a test that lets them pass is decoration.

use glam::DVec3;
use whitefurnace::bxdf::{Bxdf, BxdfSample, Flags, Microfacet, Sampling};
use whitefurnace::geometry::reflect;
use whitefurnace::spectrum::Channels;

/// What is wrong with [`Wrong`].
#[derive(Debug, Clone, Copy)]
pub(crate) enum Mistake {
    /// Nothing.
    Nothing,
    /// The density of wi is taken for that of the half vector: the Jacobian 4 (o.h) of eq. 15 is missing.
    Jacobian,
    /// f is 2 % too large.
    Gain,
    /// |o.h| and |n.i| take the place of the indicators in V', as eq. 25 and 30 are printed.
    AbsoluteMasking,
    /// Directions are drawn from the lobe, but divided by the density of another lobe.
    Density(Microfacet),
}

/// A microfacet lobe with a mistake in it.
pub(crate) struct Wrong {
    pub(crate) lobe: Microfacet,
    pub(crate) mistake: Mistake,
}

impl Bxdf for Wrong {
    fn channels(&self) -> Channels {
        self.lobe.channels()
    }

    fn flags(&self) -> Flags {
        self.lobe.flags()
    }

    fn f(&self, wo: DVec3, wi: DVec3) -> DVec3 {
        match self.mistake {
            Mistake::Gain => 1.02 * self.lobe.f(wo, wi),
            _ => self.lobe.f(wo, wi),
        }
    }

    fn pdf(&self, wo: DVec3, wi: DVec3) -> f64 {
        match &self.mistake {
            Mistake::Density(other) => other.pdf(wo, wi),
            _ => self.lobe.pdf(wo, wi),
        }
    }

    fn supports(&self, _: Sampling) -> bool {
        true
    }

    fn sample_f(&self, wo: DVec3, u: [f64; 3]) -> BxdfSample {
        self.sample(Sampling::Bxdf, wo, u)
    }

    fn sample(&self, sampling: Sampling, wo: DVec3, u: [f64; 3]) -> BxdfSample {
        let right = self.lobe.sample(sampling, wo, u);
        let weight = match &self.mistake {
            Mistake::Nothing => right.weight,
            Mistake::Jacobian => right.weight / (2.0 * (wo + right.wi).length()), // |wo + wi| = 2 (o.h)
            Mistake::Gain => 1.02 * right.weight,
            Mistake::AbsoluteMasking => {
                let wm = self.lobe.distribution.sample([u[0], u[1]]);
                let (cos_d, cos_i) = (wo.dot(wm).abs(), reflect(wo, wm).z.abs());
                let seen = (cos_d / (wo.z * wm.z)).min(2.0).min(2.0 * cos_i / wo.z);
                self.lobe.facet_reflectance(cos_d.min(1.0)) * seen
            }
            Mistake::Density(other) => right.weight * (right.pdf / other.pdf(wo, right.wi)),
        };
        // a direction that was lost has no density to divide by
        let lost = right.weight == DVec3::ZERO && !matches!(self.mistake, Mistake::AbsoluteMasking);
        BxdfSample {
            weight: if lost { DVec3::ZERO } else { weight },
            ..right
        }
    }
}
