//! The closed set of models that scenes name.

use super::{
    BrdfToBtdf, Bxdf, DiffuseSpecular, Flags, FresnelBlend, FresnelSpecular, HalfAngle, Irregular, Lambertian, Layered,
    Microfacet, OrenNayar, RoughDielectric, Scaled, SpecularReflection, SpecularTransmission, Sum,
};
use crate::spectrum::Channels;

/// The models that a scene can name.
#[derive(Debug, Clone, PartialEq)]
pub enum Model {
    /// Ideal diffuse reflection.
    Lambertian(Lambertian),
    /// Rough diffuse reflection.
    OrenNayar(OrenNayar),
    /// Microfacet reflection.
    Microfacet(Microfacet),
    /// A glossy coat over a diffuse base.
    FresnelBlend(FresnelBlend),
    /// A mirror.
    SpecularReflection(SpecularReflection),
    /// Refraction by a smooth surface.
    SpecularTransmission(SpecularTransmission),
    /// Both by a smooth surface.
    FresnelSpecular(FresnelSpecular),
    /// Both by a rough surface.
    RoughDielectric(RoughDielectric),
    /// A measured half-angle table.
    HalfAngle(HalfAngle),
    /// Irregular measured samples.
    Irregular(Irregular),
    /// A reflection that goes to the other side.
    BrdfToBtdf(Box<BrdfToBtdf<Model>>),
    /// A model times a colour.
    Scaled(Box<Scaled<Model>>),
    /// Several models at once.
    Sum(Sum<Model>),
    /// A specular lobe over a diffuse base.
    DiffuseSpecular(Box<DiffuseSpecular>),
    /// A layer over another model.
    Layered(Box<Layered>),
}

/// A model that needs the albedo of another before it can be evaluated.
#[derive(Debug, Clone, Copy)]
pub enum Needs<'a> {
    /// A coupling, that of its specular lobe.
    Coupling(&'a DiffuseSpecular),
    /// Layers, that of the top.
    Layers(&'a Layered),
}

/// `$body` with `$leaf` bound to a model that is a [`Bxdf`] by itself, and the arms of those that are made of others.
macro_rules! each {
    ($self:expr, $leaf:ident => $body:expr, $($made:tt)*) => {
        match $self {
            Model::Lambertian($leaf) => $body,
            Model::OrenNayar($leaf) => $body,
            Model::Microfacet($leaf) => $body,
            Model::FresnelBlend($leaf) => $body,
            Model::SpecularReflection($leaf) => $body,
            Model::SpecularTransmission($leaf) => $body,
            Model::FresnelSpecular($leaf) => $body,
            Model::RoughDielectric($leaf) => $body,
            Model::HalfAngle($leaf) => $body,
            Model::Irregular($leaf) => $body,
            $($made)*
        }
    };
}

impl Model {
    /// The model as a [`Bxdf`]; `make` makes one of what needs an albedo for that.
    ///
    /// # Errors
    /// Those of `make`.
    pub fn as_bxdf<'a, E>(
        &'a self,
        make: &dyn Fn(Needs<'a>) -> Result<Box<dyn Bxdf + 'a>, E>,
    ) -> Result<Box<dyn Bxdf + 'a>, E> {
        each!(self, leaf => Ok(Box::new(leaf)),
            Self::BrdfToBtdf(mirrored) => Ok(Box::new(BrdfToBtdf::new(mirrored.bxdf().as_bxdf(make)?))),
            Self::Scaled(scaled) => Ok(Box::new(scaled.with(scaled.bxdf().as_bxdf(make)?))),
            Self::Sum(sum) => {
                let parts: Result<Vec<_>, E> = sum.parts().iter().map(|part| part.as_bxdf(make)).collect();
                Ok(Box::new(Sum::new(parts?)))
            }
            Self::DiffuseSpecular(coupled) => make(Needs::Coupling(coupled)),
            Self::Layered(layered) => make(Needs::Layers(layered)),
        )
    }

    /// The models that it is made of.
    pub fn parts(&self) -> Vec<&Model> {
        match self {
            Self::BrdfToBtdf(mirrored) => vec![mirrored.bxdf()],
            Self::Scaled(scaled) => vec![scaled.bxdf()],
            Self::Sum(sum) => sum.parts().iter().collect(),
            Self::DiffuseSpecular(coupled) => vec![coupled.specular()],
            Self::Layered(layered) => vec![layered.top(), layered.base()],
            _ => Vec::new(),
        }
    }

    /// Number of independent channels of f.
    pub fn channels(&self) -> Channels {
        each!(self, leaf => leaf.channels(),
            Self::BrdfToBtdf(mirrored) => mirrored.bxdf().channels(),
            Self::Scaled(scaled) => scaled.bxdf().channels().max(scaled.scale().channels()),
            Self::Sum(sum) => sum.parts().iter().map(Self::channels).max().unwrap_or(Channels::Grey),
            Self::DiffuseSpecular(coupled) => coupled.channels(),
            Self::Layered(layered) => layered.top().channels().max(layered.base().channels()),
        )
    }

    /// Sides and sharpness of all its parts.
    pub fn flags(&self) -> Flags {
        each!(self, leaf => leaf.flags(),
            Self::BrdfToBtdf(mirrored) => mirrored.bxdf().flags().mirrored(),
            Self::Scaled(scaled) => scaled.bxdf().flags(),
            Self::Sum(sum) => sum.parts().iter().map(Self::flags).collect(),
            Self::DiffuseSpecular(coupled) => coupled.specular().flags() | Flags::REFLECTION | Flags::DIFFUSE,
            Self::Layered(layered) => layered.top().flags() | layered.base().flags(),
        )
    }

    /// The same model with importance transport, in which energy is accounted: radiance is scaled by refraction.
    pub fn accounted(&self) -> Self {
        match self {
            Self::SpecularTransmission(window) => Self::SpecularTransmission(window.accounted()),
            Self::FresnelSpecular(glass) => Self::FresnelSpecular(glass.accounted()),
            Self::RoughDielectric(glass) => Self::RoughDielectric(glass.accounted()),
            Self::BrdfToBtdf(mirrored) => Self::BrdfToBtdf(Box::new(BrdfToBtdf::new(mirrored.bxdf().accounted()))),
            Self::Scaled(scaled) => Self::Scaled(Box::new(scaled.with(scaled.bxdf().accounted()))),
            Self::Sum(sum) => Self::Sum(Sum::new(sum.parts().iter().map(Self::accounted).collect())),
            Self::Layered(layered) => {
                let below = layered.base().accounted();
                Self::Layered(Box::new(layered.with(layered.top().clone(), below)))
            }
            other => other.clone(),
        }
    }

    /// Whether rho_hd depends on the azimuth. It is then the same at phi, -phi and pi - phi.
    pub fn is_anisotropic(&self) -> bool {
        match self {
            Self::Microfacet(microfacet) => microfacet.distribution.isotropic().is_none(),
            Self::FresnelBlend(blend) => blend.distribution().isotropic().is_none(),
            other => other.parts().into_iter().any(Self::is_anisotropic),
        }
    }

    /// Whether f jumps between irregular samples, so that only Monte Carlo integrates it.
    pub fn is_irregular(&self) -> bool {
        matches!(self, Self::Irregular(_)) || self.parts().into_iter().any(Self::is_irregular)
    }

    /// Whether a coupling of specular and diffuse is part of it.
    pub fn is_coupled(&self) -> bool {
        matches!(self, Self::DiffuseSpecular(_)) || self.parts().into_iter().any(Self::is_coupled)
    }

    /// A typical width of its narrowest lobe in radians; layers of rho_hd at grazing angles are as thin.
    pub fn width(&self) -> f64 {
        match self {
            Self::Microfacet(microfacet) => microfacet.distribution.width(),
            Self::FresnelBlend(blend) => blend.distribution().width(),
            Self::RoughDielectric(glass) => glass.distribution().width(),
            other => other.parts().into_iter().map(Self::width).fold(1.0, f64::min),
        }
    }
}
