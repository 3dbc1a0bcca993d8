//! The closed set of models that scenes name.

use super::{
    BrdfToBtdf, Bxdf, DiffuseSpecular, Flags, FresnelBlend, FresnelSpecular, HalfAngle, Irregular, Lambertian,
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
    /// The model as a [`Bxdf`]; `couple` makes one of a coupling, which needs the albedo of its specular lobe.
    ///
    /// # Errors
    /// Those of `couple`.
    pub fn as_bxdf<'a, E>(
        &'a self,
        couple: &dyn Fn(&'a DiffuseSpecular) -> Result<Box<dyn Bxdf + 'a>, E>,
    ) -> Result<Box<dyn Bxdf + 'a>, E> {
        each!(self, leaf => Ok(Box::new(leaf)),
            Self::BrdfToBtdf(mirrored) => Ok(Box::new(BrdfToBtdf::new(mirrored.bxdf().as_bxdf(couple)?))),
            Self::Scaled(scaled) => Ok(Box::new(scaled.with(scaled.bxdf().as_bxdf(couple)?))),
            Self::Sum(sum) => {
                let parts: Result<Vec<_>, E> = sum.parts().iter().map(|part| part.as_bxdf(couple)).collect();
                Ok(Box::new(Sum::new(parts?)))
            }
            Self::DiffuseSpecular(coupled) => couple(coupled),
        )
    }

    /// The models that it is made of.
    pub fn parts(&self) -> Vec<&Model> {
        match self {
            Self::BrdfToBtdf(mirrored) => vec![mirrored.bxdf()],
            Self::Scaled(scaled) => vec![scaled.bxdf()],
            Self::Sum(sum) => sum.parts().iter().collect(),
            Self::DiffuseSpecular(coupled) => vec![coupled.specular()],
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
        )
    }

    /// Sides and sharpness of all its parts.
    pub fn flags(&self) -> Flags {
        each!(self, leaf => leaf.flags(),
            Self::BrdfToBtdf(mirrored) => mirrored.bxdf().flags().mirrored(),
            Self::Scaled(scaled) => scaled.bxdf().flags(),
            Self::Sum(sum) => sum.parts().iter().map(Self::flags).collect(),
            Self::DiffuseSpecular(coupled) => coupled.specular().flags() | Flags::REFLECTION | Flags::DIFFUSE,
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
