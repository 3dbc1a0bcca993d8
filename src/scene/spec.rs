//! The materials of a scene as it describes them: models whose roughness may still be a range.

use crate::bxdf::{
    BrdfToBtdf, Coupling, DiffuseSpecular, FresnelBlend, FresnelSpecular, HalfAngle, Irregular, Lambertian, Layered,
    Media, Microfacet, Model, ModelError, OrenNayar, RoughDielectric, Scaled, SpecularReflection, SpecularTransmission,
    Sum, Veil,
};
use crate::distribution::{Anisotropic, Distribution, Family};
use crate::fresnel::Fresnel;
use crate::masking::Masking;
use crate::parameter::ParameterError;
use crate::spectrum::Spectrum;
use std::fmt;

/// A roughness parameter, in the units of its family: one value, or a range that asks for a table with a roughness axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Roughness {
    /// One value.
    Fixed(f64),
    /// All values of [min, max], min < max.
    Range {
        /// Smallest value.
        min: f64,
        /// Largest value.
        max: f64,
    },
}

/// A distribution of normals whose roughness may be a range.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum DistributionSpec {
    /// The same along every azimuth.
    Isotropic {
        /// The family.
        family: Family,
        /// Its roughness parameter, within [`Family::legal`].
        roughness: Roughness,
    },
    /// With a roughness along each tangent.
    Anisotropic(Anisotropic),
}

/// A model whose roughness may be a range; where several of its distributions have one, it is the same in all of them.
#[derive(Debug, Clone, PartialEq)]
pub enum ModelSpec {
    /// Ideal diffuse reflection.
    Lambertian(Lambertian),
    /// Rough diffuse reflection.
    OrenNayar(OrenNayar),
    /// Microfacet reflection.
    Microfacet {
        /// Scale of the lobe.
        reflectance: Spectrum,
        /// Distribution of the normals.
        distribution: DistributionSpec,
        /// Masking-shadowing.
        masking: Masking,
        /// Fresnel term.
        fresnel: Fresnel,
    },
    /// A glossy coat over a diffuse base.
    FresnelBlend {
        /// Reflectance of the base.
        rd: Spectrum,
        /// Reflectance of the coat at normal incidence.
        rs: Spectrum,
        /// Distribution of the normals of the coat.
        distribution: DistributionSpec,
    },
    /// A mirror.
    SpecularReflection(SpecularReflection),
    /// Refraction by a smooth surface.
    SpecularTransmission(SpecularTransmission),
    /// Both by a smooth surface.
    FresnelSpecular(FresnelSpecular),
    /// Both by a rough surface.
    RoughDielectric {
        /// Scale of the reflected light.
        reflectance: Spectrum,
        /// Scale of the transmitted light.
        transmittance: Spectrum,
        /// Family of the facets, GGX or Beckmann.
        family: Family,
        /// Its roughness parameter.
        roughness: Roughness,
        /// Masking-shadowing, one of the two Smith terms.
        masking: Masking,
        /// Indices of both sides, and what is transported.
        media: Media,
    },
    /// A measured half-angle table in MERL's layout.
    HalfAngle(HalfAngle),
    /// Irregular measured samples.
    Irregular(Irregular),
    /// A reflection that goes to the other side.
    BrdfToBtdf(Box<ModelSpec>),
    /// A model times a colour.
    Scaled {
        /// The model.
        bxdf: Box<ModelSpec>,
        /// The colour.
        scale: Spectrum,
    },
    /// Several models at once.
    Sum(Vec<ModelSpec>),
    /// A specular lobe over a diffuse base.
    DiffuseSpecular {
        /// The specular lobe, unscaled.
        specular: Box<ModelSpec>,
        /// Scale of the specular lobe.
        ks: Spectrum,
        /// Albedo of the diffuse base.
        kd: Spectrum,
        /// How both share their energy.
        coupling: Coupling,
    },
    /// A layer over another model.
    Layered {
        /// The layer.
        top: Box<ModelSpec>,
        /// What lies below it.
        base: Box<ModelSpec>,
        /// How it dims what lies below.
        veil: Veil,
    },
}

impl Roughness {
    /// The fixed value; of a range, `chosen` or else its minimum.
    fn pick(self, chosen: Option<f64>) -> f64 {
        match self {
            Self::Fixed(value) => value,
            Self::Range { min, .. } => chosen.unwrap_or(min),
        }
    }
}

impl Roughness {
    /// Smallest and largest value.
    pub fn ends(self) -> [f64; 2] {
        match self {
            Self::Fixed(value) => [value; 2],
            Self::Range { min, max } => [min, max],
        }
    }
}

impl fmt::Display for Roughness {
    /// `17`, or `1..4096` for a range.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Fixed(value) => write!(f, "{value}"),
            Self::Range { min, max } => write!(f, "{min}..{max}"),
        }
    }
}

impl DistributionSpec {
    /// The distribution with a range replaced by `roughness`, or by its minimum when that is `None`.
    ///
    /// # Errors
    /// [`ParameterError`] outside [`Family::legal`].
    pub fn at(&self, roughness: Option<f64>) -> Result<Distribution, ParameterError> {
        Ok(match self {
            Self::Isotropic { family, roughness: own } => family.with(own.pick(roughness))?.into(),
            Self::Anisotropic(anisotropic) => (*anisotropic).into(),
        })
    }

    /// Family and ends of the roughness range, `None` when the roughness is fixed.
    pub(super) fn range(&self) -> Option<(Family, f64, f64)> {
        match self {
            Self::Isotropic { family, roughness } => roughness_range(*family, *roughness),
            Self::Anisotropic(_) => None,
        }
    }
}

/// Family and ends of a range, `None` of a fixed roughness.
fn roughness_range(family: Family, roughness: Roughness) -> Option<(Family, f64, f64)> {
    match roughness {
        Roughness::Range { min, max } => Some((family, min, max)),
        Roughness::Fixed(_) => None,
    }
}

impl ModelSpec {
    /// The models that it is made of.
    pub fn parts(&self) -> Vec<&ModelSpec> {
        match self {
            Self::BrdfToBtdf(bxdf) | Self::Scaled { bxdf, .. } => vec![bxdf],
            Self::Sum(parts) => parts.iter().collect(),
            Self::DiffuseSpecular { specular, .. } => vec![specular],
            Self::Layered { top, base, .. } => vec![top, base],
            _ => Vec::new(),
        }
    }

    /// Family and ends of every roughness range in it. More than one is the same one, as of the two parts of a glTF material
    /// that share a texture; of a TOML scene it is refused.
    pub(super) fn ranges(&self) -> Vec<(Family, f64, f64)> {
        match self {
            Self::Microfacet { distribution, .. } | Self::FresnelBlend { distribution, .. } => {
                distribution.range().into_iter().collect()
            }
            Self::RoughDielectric { family, roughness, .. } => {
                roughness_range(*family, *roughness).into_iter().collect()
            }
            made => made.parts().into_iter().flat_map(Self::ranges).collect(),
        }
    }

    /// Family and ends of the roughness range, `None` when the roughness is fixed or the model has none.
    pub fn roughness_range(&self) -> Option<(Family, f64, f64)> {
        self.ranges().into_iter().next()
    }

    /// The roughness of an isotropic lobe, on either side of the surface; `None` for other models.
    pub fn roughness(&self) -> Option<Roughness> {
        match self {
            Self::Microfacet {
                distribution: DistributionSpec::Isotropic { roughness, .. },
                ..
            }
            | Self::RoughDielectric { roughness, .. } => Some(*roughness),
            Self::BrdfToBtdf(bxdf) => bxdf.roughness(),
            _ => None,
        }
    }

    /// The model at one roughness.
    ///
    /// `roughness` replaces a range, and `None` stands for its minimum, the roughness at which tables begin. A fixed
    /// roughness stays what it is, whatever is passed.
    ///
    /// # Errors
    /// [`ModelError`] when a parameter is outside its legal range or does not go with another; models that were read from a
    /// scene have none such, so that only `roughness` itself can be refused.
    pub fn at(&self, roughness: Option<f64>) -> Result<Model, ModelError> {
        Ok(match self {
            Self::Lambertian(lambertian) => Model::Lambertian(*lambertian),
            Self::OrenNayar(rough) => Model::OrenNayar(*rough),
            Self::Microfacet {
                reflectance,
                distribution,
                masking,
                fresnel,
            } => Model::Microfacet(Microfacet::new(
                *reflectance,
                distribution.at(roughness)?,
                *masking,
                *fresnel,
            )?),
            Self::FresnelBlend { rd, rs, distribution } => {
                Model::FresnelBlend(FresnelBlend::new(*rd, *rs, distribution.at(roughness)?)?)
            }
            Self::SpecularReflection(mirror) => Model::SpecularReflection(*mirror),
            Self::SpecularTransmission(window) => Model::SpecularTransmission(*window),
            Self::FresnelSpecular(glass) => Model::FresnelSpecular(*glass),
            Self::RoughDielectric {
                reflectance,
                transmittance,
                family,
                roughness: own,
                masking,
                media,
            } => Model::RoughDielectric(RoughDielectric::new(
                *reflectance,
                *transmittance,
                family.with(own.pick(roughness))?,
                *masking,
                *media,
            )?),
            Self::HalfAngle(table) => Model::HalfAngle(table.clone()),
            Self::Irregular(irregular) => Model::Irregular(irregular.clone()),
            Self::BrdfToBtdf(bxdf) => Model::BrdfToBtdf(Box::new(BrdfToBtdf::new(bxdf.at(roughness)?))),
            Self::Scaled { bxdf, scale } => Model::Scaled(Box::new(Scaled::new(bxdf.at(roughness)?, *scale)?)),
            Self::Sum(parts) => {
                let parts: Result<Vec<Model>, ModelError> = parts.iter().map(|part| part.at(roughness)).collect();
                Model::Sum(Sum::new(parts?))
            }
            Self::DiffuseSpecular {
                specular,
                ks,
                kd,
                coupling,
            } => {
                let coupled = DiffuseSpecular::new(specular.at(roughness)?, *ks, *kd, *coupling)?;
                Model::DiffuseSpecular(Box::new(coupled))
            }
            Self::Layered { top, base, veil } => {
                let layered = Layered::new(top.at(roughness)?, base.at(roughness)?, *veil)?;
                Model::Layered(Box::new(layered))
            }
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn microfacet(roughness: Roughness) -> ModelSpec {
        ModelSpec::Microfacet {
            reflectance: Spectrum::grey(1.0),
            distribution: DistributionSpec::Isotropic {
                family: Family::Vmf,
                roughness,
            },
            masking: Masking::VGroove,
            fresnel: Fresnel::dielectric(Spectrum::grey(1.329)).unwrap(),
        }
    }

    fn coupled(specular: ModelSpec) -> ModelSpec {
        ModelSpec::DiffuseSpecular {
            specular: Box::new(specular),
            ks: Spectrum::grey(1.0),
            kd: Spectrum::rgb([0.08, 0.172, 1.0]),
            coupling: Coupling::EnergyPreserving,
        }
    }

    fn kappa_of(model: &Model) -> Distribution {
        match model {
            Model::Microfacet(microfacet) => microfacet.distribution,
            made => kappa_of(made.parts()[0]),
        }
    }

    #[test]
    fn a_roughness_replaces_a_range_and_nothing_else() {
        let range = Roughness::Range { min: 1.0, max: 4096.0 };
        let kappa = |value| Distribution::from(Family::Vmf.with(value).unwrap());
        for spec in [microfacet(range), coupled(microfacet(range))] {
            assert_eq!(spec.roughness_range(), Some((Family::Vmf, 1.0, 4096.0)));
            assert_eq!(kappa_of(&spec.at(Some(17.0)).unwrap()), kappa(17.0));
            assert_eq!(kappa_of(&spec.at(None).unwrap()), kappa(1.0));
            let refused = spec.at(Some(f64::NAN)).unwrap_err();
            assert!(matches!(refused, ModelError::Parameter(error) if error.parameter == "kappa"));
        }
        let fixed = coupled(microfacet(Roughness::Fixed(3.0)));
        assert_eq!(fixed.roughness_range(), None);
        assert_eq!(kappa_of(&fixed.at(Some(17.0)).unwrap()), kappa(3.0));
    }

    #[test]
    fn descriptions_hold_every_parameter_by_its_name() {
        let range = Roughness::Range { min: 0.5, max: 1e12 };
        let facts = coupled(microfacet(range)).describe();
        let facts: Vec<String> = facts.iter().map(|(key, value)| format!("{key}={value}")).collect();
        assert_eq!(
            facts.join(" "),
            "type=diffuse-specular coupling=energy-preserving ks=1 kd=[0.08, 0.172, 1.0] specular.type=microfacet \
             specular.reflectance=1 specular.distribution=vmf specular.kappa=0.5..1000000000000 \
             specular.masking=v-groove specular.fresnel=dielectric specular.eta=1.329"
        );
        let lambertian = ModelSpec::Lambertian(Lambertian::new(Spectrum::grey(0.5)).unwrap());
        assert_eq!(
            lambertian.describe(),
            [("type", "lambertian"), ("reflectance", "0.5")].map(|(k, v)| (k.to_owned(), v.to_owned()))
        );
    }
}
