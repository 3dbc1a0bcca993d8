//! A model in words: every parameter by the name that it has in a scene file.

use super::spec::{DistributionSpec, ModelSpec};
use crate::bxdf::{Lambertian, Transport};
use crate::fresnel::Fresnel;
use crate::spectrum::Spectrum;
use std::fmt;

impl ModelSpec {
    /// Every parameter by its scene-file name, in a fixed order, aliases resolved and defaults filled in.
    ///
    /// Numbers are the shortest decimals that read back as the same f64, spectra are `[r, g, b]`, ranges `min..max`. The
    /// keys of a model within another begin with its place there: `specular.`, `bxdf.`, `bxdfs.0.`,
    /// `top.`, `base.`.
    pub fn describe(&self) -> Vec<(String, String)> {
        let mut facts = Facts::default();
        self.describe_to(&mut facts, "");
        facts.0
    }

    fn describe_to(&self, facts: &mut Facts, prefix: &str) {
        facts.add(prefix, "type", self.type_name());
        match self {
            Self::Lambertian(lambertian) => {
                facts.add(prefix, "reflectance", spectrum(lambertian_reflectance(lambertian)));
            }
            Self::OrenNayar(rough) => {
                facts.add(prefix, "reflectance", spectrum(rough.reflectance()));
                facts.add(prefix, "sigma_deg", rough.sigma_deg());
            }
            Self::Microfacet {
                reflectance,
                distribution,
                masking,
                fresnel,
            } => {
                facts.add(prefix, "reflectance", spectrum(*reflectance));
                distribution.describe_to(facts, prefix);
                facts.add(prefix, "masking", masking.name());
                describe_fresnel(fresnel, facts, prefix);
            }
            Self::FresnelBlend { rd, rs, distribution } => {
                facts.add(prefix, "rd", spectrum(*rd));
                facts.add(prefix, "rs", spectrum(*rs));
                distribution.describe_to(facts, prefix);
            }
            Self::SpecularReflection(mirror) => {
                facts.add(prefix, "reflectance", spectrum(mirror.reflectance()));
                describe_fresnel(mirror.fresnel(), facts, prefix);
            }
            Self::SpecularTransmission(window) => {
                facts.add(prefix, "transmittance", spectrum(window.transmittance()));
                describe_interface((window.eta_a(), window.eta_b(), window.transport()), facts, prefix);
            }
            Self::FresnelSpecular(glass) => {
                facts.add(prefix, "reflectance", spectrum(glass.reflectance()));
                facts.add(prefix, "transmittance", spectrum(glass.transmittance()));
                describe_interface((glass.eta_a(), glass.eta_b(), glass.transport()), facts, prefix);
            }
            Self::RoughDielectric {
                reflectance,
                transmittance,
                family,
                roughness,
                masking,
                media,
            } => {
                facts.add(prefix, "reflectance", spectrum(*reflectance));
                facts.add(prefix, "transmittance", spectrum(*transmittance));
                let (family, roughness) = (*family, *roughness);
                DistributionSpec::Isotropic { family, roughness }.describe_to(facts, prefix);
                facts.add(prefix, "masking", masking.name());
                describe_interface((media.eta_a, media.eta_b, media.transport), facts, prefix);
            }
            // a table goes with the data, wherever the file is
            Self::HalfAngle(table) => {
                facts.add(prefix, "invalid", table.table().invalid());
                facts.add(prefix, "sha256", table.table().sha256());
            }
            Self::Irregular(irregular) => {
                facts.add(prefix, "samples", irregular.data().len());
                let [red, green, blue] = irregular.data().negative();
                facts.add(prefix, "negative", format!("{red} {green} {blue}"));
                facts.add(prefix, "sha256", irregular.data().sha256());
            }
            Self::BrdfToBtdf(bxdf) => bxdf.describe_to(facts, &format!("{prefix}bxdf.")),
            Self::Scaled { bxdf, scale } => {
                facts.add(prefix, "scale", spectrum(*scale));
                bxdf.describe_to(facts, &format!("{prefix}bxdf."));
            }
            Self::Sum(parts) => {
                for (index, part) in parts.iter().enumerate() {
                    part.describe_to(facts, &format!("{prefix}bxdfs.{index}."));
                }
            }
            Self::DiffuseSpecular {
                specular,
                ks,
                kd,
                coupling,
            } => {
                facts.add(prefix, "coupling", coupling.name());
                facts.add(prefix, "ks", spectrum(*ks));
                facts.add(prefix, "kd", spectrum(*kd));
                specular.describe_to(facts, &format!("{prefix}specular."));
            }
            Self::Layered { top, base, veil } => {
                facts.add(prefix, "veil", veil.name());
                top.describe_to(facts, &format!("{prefix}top."));
                base.describe_to(facts, &format!("{prefix}base."));
            }
        }
    }

    /// Which of its measured data count as 0 though they are not, in words; empty where none do.
    pub fn clipped(&self) -> Vec<String> {
        let own = match self {
            Self::HalfAngle(table) if table.table().invalid() > 0 => {
                let invalid = table.table().invalid();
                vec![format!(
                    "{invalid} of its 4374000 values are marked as invalid and count as 0"
                )]
            }
            Self::Irregular(irregular) if irregular.data().negative() != [0; 3] => {
                let [red, green, blue] = irregular.data().negative();
                let all = irregular.data().len();
                vec![format!(
                    "of its {all} samples {red} have a red below 0, {green} a green and {blue} a blue, outside of the gamut of \
                     sRGB; means that are below 0 count as 0"
                )]
            }
            _ => Vec::new(),
        };
        own.into_iter()
            .chain(self.parts().into_iter().flat_map(Self::clipped))
            .collect()
    }

    /// Name of its type in a scene file.
    pub fn type_name(&self) -> &'static str {
        match self {
            Self::Lambertian(_) => "lambertian",
            Self::OrenNayar(_) => "oren-nayar",
            Self::Microfacet { .. } => "microfacet",
            Self::FresnelBlend { .. } => "fresnel-blend",
            Self::SpecularReflection(_) => "specular-reflection",
            Self::SpecularTransmission(_) => "specular-transmission",
            Self::FresnelSpecular(_) => "fresnel-specular",
            Self::RoughDielectric { .. } => "rough-dielectric",
            Self::HalfAngle(_) => "merl",
            Self::Irregular(_) => "irregular",
            Self::BrdfToBtdf(_) => "brdf-to-btdf",
            Self::Scaled { .. } => "scaled",
            Self::Sum(_) => "sum",
            Self::DiffuseSpecular { .. } => "diffuse-specular",
            Self::Layered { .. } => "layered",
        }
    }
}

impl DistributionSpec {
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

fn describe_interface((eta_a, eta_b, transport): (f64, f64, Transport), facts: &mut Facts, prefix: &str) {
    facts.add(prefix, "eta_a", eta_a);
    facts.add(prefix, "eta_b", eta_b);
    facts.add(prefix, "transport", transport.name());
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
