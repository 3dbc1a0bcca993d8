//! Models made of other models [pbrt 2010, section 8.1]: mirrored to the other side, scaled, added up.

use super::{Bxdf, BxdfSample, Draws, Flags, Lane, Sampling, across, opposite_sides, other_hemisphere};
use crate::parameter::{ParameterError, SCALE};
use crate::spectrum::{Channels, Spectrum};
use glam::DVec3;

/// A BRDF used as a BTDF, and the reverse: f(wo, wi) is that of the model with wi mirrored by the surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BrdfToBtdf<B> {
    bxdf: B,
}

impl<B> BrdfToBtdf<B> {
    /// The model that scatters to the other side what `bxdf` scatters to this one.
    pub fn new(bxdf: B) -> Self {
        Self { bxdf }
    }

    /// The model that is mirrored.
    pub fn bxdf(&self) -> &B {
        &self.bxdf
    }
}

/// `sample` with its direction on the other side.
fn mirrored(wo: DVec3, sample: BxdfSample) -> BxdfSample {
    let wi = other_hemisphere(sample.wi);
    let flags = sample.flags.mirrored();
    BxdfSample {
        wi: if flags.contains(Flags::TRANSMISSION) {
            across(wo, wi)
        } else {
            wi
        },
        flags,
        ..sample
    }
}

impl<B: Bxdf> Bxdf for BrdfToBtdf<B> {
    fn channels(&self) -> Channels {
        self.bxdf.channels()
    }

    fn flags(&self) -> Flags {
        self.bxdf.flags().mirrored()
    }

    fn f(&self, wo: DVec3, wi: DVec3) -> DVec3 {
        self.bxdf.f(wo, other_hemisphere(wi))
    }

    fn pdf(&self, wo: DVec3, wi: DVec3) -> f64 {
        self.bxdf.pdf(wo, other_hemisphere(wi))
    }

    fn sample_f(&self, wo: DVec3, u: [f64; 3]) -> BxdfSample {
        mirrored(wo, self.bxdf.sample_f(wo, u))
    }

    fn albedo_error(&self, mu: f64) -> DVec3 {
        self.bxdf.albedo_error(mu)
    }

    fn supports(&self, sampling: Sampling) -> bool {
        self.bxdf.supports(sampling)
    }

    fn sample(&self, sampling: Sampling, wo: DVec3, u: [f64; 3]) -> BxdfSample {
        mirrored(wo, self.bxdf.sample(sampling, wo, u))
    }

    fn dimensions(&self, sampling: Sampling) -> usize {
        self.bxdf.dimensions(sampling)
    }

    fn weights(&self, sampling: Sampling, side: Flags, draws: Draws<'_>, weights: &mut [Lane; 3]) {
        self.bxdf.weights(sampling, side.mirrored(), draws, weights);
    }
}

/// A model times a colour.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Scaled<B> {
    bxdf: B,
    scale: Spectrum,
}

impl<B> Scaled<B> {
    /// Scale in [0, 1] in every channel, [`SCALE`].
    ///
    /// # Errors
    /// [`ParameterError`] outside that range, with the value and the range.
    pub fn new(bxdf: B, scale: Spectrum) -> Result<Self, ParameterError> {
        Ok(Self {
            bxdf,
            scale: scale.check(SCALE)?,
        })
    }

    /// Another model on the same scale.
    pub fn with<C>(&self, bxdf: C) -> Scaled<C> {
        Scaled {
            bxdf,
            scale: self.scale,
        }
    }

    /// The model that is scaled.
    pub fn bxdf(&self) -> &B {
        &self.bxdf
    }

    /// What it is multiplied by.
    pub fn scale(&self) -> Spectrum {
        self.scale
    }

    fn scaled(&self, sample: BxdfSample) -> BxdfSample {
        BxdfSample {
            weight: self.scale.value() * sample.weight,
            ..sample
        }
    }
}

impl<B: Bxdf> Bxdf for Scaled<B> {
    fn channels(&self) -> Channels {
        self.bxdf.channels().max(self.scale.channels())
    }

    fn flags(&self) -> Flags {
        self.bxdf.flags()
    }

    fn f(&self, wo: DVec3, wi: DVec3) -> DVec3 {
        self.scale.value() * self.bxdf.f(wo, wi)
    }

    fn pdf(&self, wo: DVec3, wi: DVec3) -> f64 {
        self.bxdf.pdf(wo, wi)
    }

    fn sample_f(&self, wo: DVec3, u: [f64; 3]) -> BxdfSample {
        self.scaled(self.bxdf.sample_f(wo, u))
    }

    fn albedo_error(&self, mu: f64) -> DVec3 {
        self.scale.value() * self.bxdf.albedo_error(mu)
    }

    fn supports(&self, sampling: Sampling) -> bool {
        self.bxdf.supports(sampling)
    }

    fn sample(&self, sampling: Sampling, wo: DVec3, u: [f64; 3]) -> BxdfSample {
        self.scaled(self.bxdf.sample(sampling, wo, u))
    }

    fn dimensions(&self, sampling: Sampling) -> usize {
        self.bxdf.dimensions(sampling)
    }

    fn weights(&self, sampling: Sampling, side: Flags, draws: Draws<'_>, weights: &mut [Lane; 3]) {
        self.bxdf.weights(sampling, side, draws, weights);
        let last = self.bxdf.channels().count() - 1;
        // from the last, as a grey model has only written the first
        for channel in (0..self.channels().count()).rev() {
            weights[channel] = weights[channel.min(last)];
            let scale = self.scale.value()[channel];
            weights[channel].iter_mut().for_each(|weight| *weight *= scale);
        }
    }
}

/// Several models at once: f is the sum of theirs. Nothing keeps the sum of their albedos below 1.
#[derive(Debug, Clone, PartialEq)]
pub struct Sum<B> {
    parts: Vec<B>,
}

impl<B> Sum<B> {
    /// The sum of `parts`; that of none is black.
    pub fn new(parts: Vec<B>) -> Self {
        Self { parts }
    }

    /// The models that add up.
    pub fn parts(&self) -> &[B] {
        &self.parts
    }

    /// A part, each equally likely, and what `u` in [0, 1) has left in [0, 1) after choosing it.
    fn pick(&self, u: f64) -> Option<(&B, f64)> {
        let scaled = u * self.parts.len() as f64;
        let index = (scaled as usize).min(self.parts.len().checked_sub(1)?);
        // the product may round up to the number of parts
        let rest = (scaled - index as f64).min(1.0 - 0.5 * f64::EPSILON);
        Some((&self.parts[index], rest))
    }

    /// A draw of one part, which happens with the probability of [`Sum::pick`].
    fn shared(&self, sample: BxdfSample) -> BxdfSample {
        let count = self.parts.len() as f64;
        BxdfSample {
            pdf: sample.pdf / count,
            weight: sample.weight * count,
            ..sample
        }
    }
}

impl<B: Bxdf> Sum<B> {
    /// What scatters from `wi` to `wo` without being a delta.
    fn flags_at(&self, wo: DVec3, wi: DVec3) -> Flags {
        let side = if opposite_sides(wo, wi) {
            Flags::TRANSMISSION
        } else {
            Flags::REFLECTION
        };
        let parts = self.parts.iter().filter(|part| part.f(wo, wi) != DVec3::ZERO);
        parts.map(Bxdf::flags).collect::<Flags>() & (side | Flags::DIFFUSE | Flags::GLOSSY)
    }

    /// The parts all of whose flags are wanted [pbrt 2010, section 8.1].
    pub fn matching(&self, wanted: Flags) -> Sum<&B> {
        Sum::new(self.parts.iter().filter(|part| part.flags().matches(wanted)).collect())
    }
}

impl<B: Bxdf> Bxdf for Sum<B> {
    fn channels(&self) -> Channels {
        self.parts.iter().map(Bxdf::channels).max().unwrap_or(Channels::Grey)
    }

    fn flags(&self) -> Flags {
        self.parts.iter().map(Bxdf::flags).collect()
    }

    fn f(&self, wo: DVec3, wi: DVec3) -> DVec3 {
        self.parts.iter().map(|part| part.f(wo, wi)).sum()
    }

    fn pdf(&self, wo: DVec3, wi: DVec3) -> f64 {
        // so many parts that their number rounds do not fit into memory; the sum of none is 0/1
        self.parts.iter().map(|part| part.pdf(wo, wi)).sum::<f64>() / self.parts.len().max(1) as f64
    }

    /// One part is drawn, each equally likely, and the weight is that of the mixture density; a specular direction, which no
    /// other part draws, keeps its own.
    ///
    /// A direction that its own part draws in vain may lie where another part scatters to. It counts there if the part's
    /// `pdf` owns up to it, and is lost if not: either way the mixture density is that of the directions that count.
    fn sample_f(&self, wo: DVec3, u: [f64; 3]) -> BxdfSample {
        let Some((part, rest)) = self.pick(u[2]) else {
            return BxdfSample::lost(wo);
        };
        let sample = part.sample_f(wo, [u[0], u[1], rest]);
        // a single part has no mixture, and its own weight is formed with more cancelled
        if sample.flags.contains(Flags::SPECULAR) || self.parts.len() == 1 {
            return self.shared(sample);
        }
        let wi = sample.wi;
        if part.pdf(wo, wi) <= 0.0 {
            return BxdfSample::lost(wi);
        }
        let pdf = self.pdf(wo, wi);
        BxdfSample {
            wi,
            pdf,
            weight: self.f(wo, wi) * (wi.z.abs() / pdf),
            flags: self.flags_at(wo, wi),
        }
    }

    fn albedo_error(&self, mu: f64) -> DVec3 {
        self.parts.iter().map(|part| part.albedo_error(mu)).sum()
    }

    fn supports(&self, sampling: Sampling) -> bool {
        self.parts.iter().all(|part| part.supports(sampling))
    }

    /// For half-vector samplings each part is drawn in its own way and weighted alone, without any quotient of narrow
    /// densities.
    fn sample(&self, sampling: Sampling, wo: DVec3, u: [f64; 3]) -> BxdfSample {
        match sampling {
            Sampling::Uniform => super::sample_uniform(self, wo, u),
            Sampling::Cosine => super::sample_cosine(self, wo, u),
            Sampling::Bxdf => self.sample_f(wo, u),
            Sampling::Normals | Sampling::Visible => match self.pick(u[2]) {
                Some((part, rest)) => self.shared(part.sample(sampling, wo, [u[0], u[1], rest])),
                None => BxdfSample::lost(wo),
            },
        }
    }
}
