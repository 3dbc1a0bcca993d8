//! A layer over another model, which it dims: the sheen and the clearcoat of engines.

use super::{Bxdf, BxdfSample, Flags, Model, ModelError, Sampling};
use crate::geometry::Polar;
use crate::numerics::surface::Surface;
use crate::spectrum::Channels;
use glam::DVec3;

/// What a layer leaves to the model below it. The largest channel counts in all, so that what lies below keeps its hue.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Veil {
    /// max(0, 1 - max rho_hd(mu)), with the albedo of the layer in the direction of sight: what it does not send back. Nothing
    /// is left where the layer sends back more than it gets.
    Albedo,
    /// 1 - max R F(mu), with reflectance and Fresnel term of the layer in the direction of sight, as of a smooth one.
    Fresnel,
}

impl Veil {
    /// The name in scene files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Albedo => "albedo",
            Self::Fresnel => "fresnel",
        }
    }

    /// The factor of what lies below, for people.
    pub fn formula(self) -> &'static str {
        match self {
            Self::Albedo => "max(0, 1 - max over channels of scale rho_hd(mu))",
            Self::Fresnel => "1 - max over channels of scale reflectance F(mu)",
        }
    }
}

/// f = f_top(wo, wi) + veil(wo) f_base(wo, wi), and so rho_hd = rho_top + veil rho_base, in every direction of sight.
///
/// That is the layering of KHR_materials_sheen (albedo, in the form that depends on the direction of sight alone) and of
/// KHR_materials_clearcoat (Fresnel). As there, f is not reciprocal.
#[derive(Debug, Clone, PartialEq)]
pub struct Layered {
    top: Model,
    base: Model,
    veil: Veil,
}

impl Layered {
    /// `top` over `base`.
    ///
    /// # Errors
    /// [`ModelError::LayerLetsThrough`] for a top that transmits or does not reflect, and [`ModelError::LayerWithoutFresnel`] for the veil of a Fresnel
    /// term that the top does not have: only a microfacet and a specular reflection have one.
    pub fn new(top: Model, base: Model, veil: Veil) -> Result<Self, ModelError> {
        let sides = top.flags();
        if !sides.contains(Flags::REFLECTION) || sides.contains(Flags::TRANSMISSION) {
            return Err(ModelError::LayerLetsThrough);
        }
        if veil == Veil::Fresnel && facet(&top, Polar::POLE).is_none() {
            return Err(ModelError::LayerWithoutFresnel);
        }
        Ok(Self { top, base, veil })
    }

    /// The layer.
    pub fn top(&self) -> &Model {
        &self.top
    }

    /// What lies below it.
    pub fn base(&self) -> &Model {
        &self.base
    }

    /// How the layer dims what lies below.
    pub fn veil(&self) -> Veil {
        self.veil
    }

    /// The same layering of other models.
    pub(super) fn with(&self, top: Model, base: Model) -> Self {
        Self {
            top,
            base,
            veil: self.veil,
        }
    }

    /// The factor of what lies below, for a top whose albedo from the same direction, cos theta_o = `mu`, is `rho`.
    pub fn left(&self, mu: f64, rho: DVec3) -> f64 {
        let spent = match self.veil {
            Veil::Albedo => rho,
            Veil::Fresnel => facet(&self.top, Polar::from_cos(mu)).unwrap_or(DVec3::ONE),
        };
        (1.0 - spent.max_element()).max(0.0)
    }
}

/// R F at the angle `theta` of a model that is made of one kind of facet.
fn facet(model: &Model, theta: Polar) -> Option<DVec3> {
    match model {
        Model::Microfacet(microfacet) => Some(microfacet.facet_reflectance_at(theta)),
        Model::SpecularReflection(mirror) => Some(mirror.rho_hd(Flags::REFLECTION, theta.cos)),
        _ => None,
    }
}

/// What lies below the layer of a [`Layered`], dimmed, ready to be evaluated and sampled.
pub struct VeiledBxdf<'a, B> {
    layered: &'a Layered,
    bxdf: B,
    /// rho_hd of the layer over all directions, where the veil depends on it.
    albedo: Option<Surface>,
}

impl<'a, B: Bxdf> VeiledBxdf<'a, B> {
    /// `bxdf` is the base of `layered`, and `albedo` that of its top, which [`Veil::Albedo`] needs.
    pub fn new(layered: &'a Layered, bxdf: B, albedo: Option<Surface>) -> Self {
        Self { layered, bxdf, albedo }
    }

    fn left(&self, wo: DVec3) -> f64 {
        let rho = self.albedo.as_ref().map_or(DVec3::ZERO, |albedo| albedo.at(wo));
        self.layered.left(wo.z.abs().min(1.0), rho)
    }

    fn veiled(&self, wo: DVec3, sample: BxdfSample) -> BxdfSample {
        BxdfSample {
            weight: sample.weight * self.left(wo),
            ..sample
        }
    }
}

impl<B: Bxdf> Bxdf for VeiledBxdf<'_, B> {
    fn channels(&self) -> Channels {
        self.bxdf.channels()
    }

    fn flags(&self) -> Flags {
        self.bxdf.flags()
    }

    fn f(&self, wo: DVec3, wi: DVec3) -> DVec3 {
        self.bxdf.f(wo, wi) * self.left(wo)
    }

    fn pdf(&self, wo: DVec3, wi: DVec3) -> f64 {
        self.bxdf.pdf(wo, wi)
    }

    fn sample_f(&self, wo: DVec3, u: [f64; 3]) -> BxdfSample {
        self.veiled(wo, self.bxdf.sample_f(wo, u))
    }

    /// The error of the layer's albedo is one of the base, whose albedo is at most about 1.
    fn albedo_error(&self, mu: f64) -> DVec3 {
        let own = self.albedo.as_ref().map_or(0.0, Surface::error);
        self.bxdf.albedo_error(mu) + DVec3::splat(own)
    }

    fn supports(&self, sampling: Sampling) -> bool {
        self.bxdf.supports(sampling)
    }

    fn sample(&self, sampling: Sampling, wo: DVec3, u: [f64; 3]) -> BxdfSample {
        self.veiled(wo, self.bxdf.sample(sampling, wo, u))
    }

    fn dimensions(&self, sampling: Sampling) -> usize {
        self.bxdf.dimensions(sampling)
    }
}
