//! The materials of a scene as it describes them: models whose roughness may still be a range.

use crate::bxdf::{Bxdf, Coupling, DiffuseSpecular, Lambertian, Microfacet, Model, ModelError};
use crate::distribution::{Anisotropic, Distribution, Family};
use crate::fresnel::Fresnel;
use crate::masking::Masking;
use crate::parameter::ParameterError;
use crate::spectrum::{Channels, Spectrum};
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

/// A model whose roughness may be a range.
#[derive(Debug, Clone, PartialEq)]
pub enum ModelSpec {
    /// Ideal diffuse reflection.
    Lambertian(Lambertian),
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
    fn range(&self) -> Option<(Family, f64, f64)> {
        match self {
            Self::Isotropic {
                family,
                roughness: Roughness::Range { min, max },
            } => Some((*family, *min, *max)),
            _ => None,
        }
    }

    fn describe_to(&self, facts: &mut Facts, prefix: &str) {
        match self {
            Self::Isotropic { family, roughness } => {
                facts.add(prefix, "distribution", family.name());
                facts.add(prefix, family.legal().name, roughness);
            }
            Self::Anisotropic(anisotropic) => {
                let kind = anisotropic.kind();
                facts.add(prefix, "distribution", kind.name());
                for (legal, value) in kind.legal().iter().zip(anisotropic.parameters()) {
                    facts.add(prefix, legal.name, value);
                }
            }
        }
    }
}

impl ModelSpec {
    /// Family and ends of the roughness range, `None` when the roughness is fixed or the model has none.
    pub fn roughness_range(&self) -> Option<(Family, f64, f64)> {
        match self {
            Self::Lambertian(_) => None,
            Self::Microfacet { distribution, .. } => distribution.range(),
            Self::DiffuseSpecular { specular, .. } => specular.roughness_range(),
        }
    }

    /// The model at one roughness.
    ///
    /// `roughness` replaces a range, and `None` stands for its minimum, the roughness at which tables begin. A fixed
    /// roughness stays what it is, whatever is passed.
    ///
    /// # Errors
    /// [`ModelError`] when a parameter is outside its legal range or parts do not go together; models that were read from a
    /// scene have none such, so that only `roughness` itself can be refused.
    pub fn at(&self, roughness: Option<f64>) -> Result<Model, ModelError> {
        Ok(match self {
            Self::Lambertian(lambertian) => Model::Lambertian(*lambertian),
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
            Self::DiffuseSpecular {
                specular,
                ks,
                kd,
                coupling,
            } => {
                let coupled = DiffuseSpecular::new(specular.at(roughness)?, *ks, *kd, *coupling)?;
                Model::DiffuseSpecular(Box::new(coupled))
            }
        })
    }

    /// Number of independent channels of f.
    pub fn channels(&self) -> Channels {
        match self {
            Self::Lambertian(lambertian) => lambertian.channels(),
            Self::Microfacet {
                reflectance, fresnel, ..
            } => reflectance.channels().max(fresnel.channels()),
            Self::DiffuseSpecular { specular, ks, kd, .. } => specular.channels().max(ks.channels()).max(kd.channels()),
        }
    }

    /// Every parameter by its scene-file name, in a fixed order, aliases resolved and defaults filled in.
    ///
    /// Numbers are the shortest decimals that read back as the same f64, spectra are `[r, g, b]`, ranges `min..max`. The
    /// keys of a specular lobe begin with `specular.`.
    pub fn describe(&self) -> Vec<(String, String)> {
        let mut facts = Facts::default();
        self.describe_to(&mut facts, "");
        facts.0
    }

    fn describe_to(&self, facts: &mut Facts, prefix: &str) {
        match self {
            Self::Lambertian(lambertian) => {
                facts.add(prefix, "type", "lambertian");
                facts.add(prefix, "reflectance", spectrum(lambertian_reflectance(lambertian)));
            }
            Self::Microfacet {
                reflectance,
                distribution,
                masking,
                fresnel,
            } => {
                facts.add(prefix, "type", "microfacet");
                facts.add(prefix, "reflectance", spectrum(*reflectance));
                distribution.describe_to(facts, prefix);
                facts.add(prefix, "masking", masking.name());
                describe_fresnel(fresnel, facts, prefix);
            }
            Self::DiffuseSpecular {
                specular,
                ks,
                kd,
                coupling,
            } => {
                facts.add(prefix, "type", "diffuse-specular");
                facts.add(prefix, "coupling", coupling_name(*coupling));
                facts.add(prefix, "ks", spectrum(*ks));
                facts.add(prefix, "kd", spectrum(*kd));
                specular.describe_to(facts, &format!("{prefix}specular."));
            }
        }
    }
}

/// Key and value pairs in the order in which they were added.
#[derive(Default)]
struct Facts(Vec<(String, String)>);

impl Facts {
    fn add(&mut self, prefix: &str, key: &str, value: impl fmt::Display) {
        self.0.push((format!("{prefix}{key}"), value.to_string()));
    }
}

fn describe_fresnel(fresnel: &Fresnel, facts: &mut Facts, prefix: &str) {
    match fresnel {
        Fresnel::None => facts.add(prefix, "fresnel", "none"),
        Fresnel::Dielectric { eta } => {
            facts.add(prefix, "fresnel", "dielectric");
            facts.add(prefix, "eta", spectrum(*eta));
        }
        Fresnel::Conductor { eta, k } => {
            facts.add(prefix, "fresnel", "conductor");
            facts.add(prefix, "eta", spectrum(*eta));
            facts.add(prefix, "k", spectrum(*k));
        }
        Fresnel::ConductorApproximate { eta, k } => {
            facts.add(prefix, "fresnel", "conductor-approximate");
            facts.add(prefix, "eta", spectrum(*eta));
            facts.add(prefix, "k", spectrum(*k));
        }
        Fresnel::Schlick { r0 } => {
            facts.add(prefix, "fresnel", "schlick");
            facts.add(prefix, "r0", spectrum(*r0));
        }
    }
}

/// The reflectance is the albedo, in as many channels as are independent.
fn lambertian_reflectance(lambertian: &Lambertian) -> Spectrum {
    Spectrum::rgb(lambertian.albedo().to_array())
}

fn spectrum(spectrum: Spectrum) -> String {
    match &spectrum.channels().of(spectrum.value())[..] {
        [grey] => grey.to_string(),
        channels => format!("{channels:?}"),
    }
}

fn coupling_name(coupling: Coupling) -> &'static str {
    match coupling {
        Coupling::Mikkelsen => "mikkelsen",
        Coupling::EnergyPreserving => "energy-preserving",
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
            Model::Lambertian(_) => panic!("no distribution"),
            Model::Microfacet(microfacet) => microfacet.distribution,
            Model::DiffuseSpecular(coupled) => kappa_of(coupled.specular()),
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
    fn channels_agree_with_the_model() {
        let fixed = microfacet(Roughness::Fixed(3.0));
        let lambertian = ModelSpec::Lambertian(Lambertian::new(Spectrum::rgb([0.1, 0.2, 0.3])).unwrap());
        for (spec, channels) in [
            (coupled(fixed.clone()), Channels::Rgb),
            (fixed, Channels::Grey),
            (lambertian, Channels::Rgb),
        ] {
            assert_eq!(spec.channels(), channels);
            assert_eq!(spec.at(None).unwrap().channels(), channels);
        }
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
