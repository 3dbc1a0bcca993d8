//! The effects of a model, by the properties that a TOML scene gives it.

use super::effect::{Call, Effect};
use super::spec::{DistributionSpec, ModelSpec};
use crate::distribution::Family;
use crate::fresnel::Fresnel;
use crate::spectrum::{Channels, Spectrum};
use glam::DVec3;

/// Largest reflectance at normal incidence that Schlick's approximation still takes for a dielectric's: 0.172 of diamond.
/// The glTF and pbrt materials say which they are; the parameters of a scene that lists BxDFs do not.
const DIELECTRIC_R0: f64 = 0.18;

impl ModelSpec {
    /// What a material of this model calls for, each effect once, in the order of [`Effect::ALL`]. Parts that scatter
    /// nothing, of reflectance or scale 0, call for nothing.
    pub fn calls(&self) -> Vec<Call> {
        let mut calls = Calls::default();
        calls.of(self, "bxdf.");
        calls.0.sort_by_key(|call| call.effect);
        calls.0
    }
}

/// Whether light of some wavelength is left.
fn some(spectrum: Spectrum) -> bool {
    spectrum.value() != DVec3::ZERO
}

/// The first reason for each effect.
#[derive(Default)]
struct Calls(Vec<Call>);

impl Calls {
    fn add(&mut self, effect: Effect, by: String) {
        if self.0.iter().all(|call| call.effect != effect) {
            self.0.push(Call { effect, by });
        }
    }

    /// Those of `model`, whose properties begin with `prefix`.
    fn of(&mut self, model: &ModelSpec, prefix: &str) {
        let kind = || format!("{prefix}type = {}", model.type_name());
        match model {
            ModelSpec::Lambertian(diffuse) if diffuse.albedo() != DVec3::ZERO => self.add(Effect::Diffuse, kind()),
            ModelSpec::OrenNayar(diffuse) if some(diffuse.reflectance()) => self.add(Effect::Diffuse, kind()),
            ModelSpec::Lambertian(_) | ModelSpec::OrenNayar(_) => {}
            ModelSpec::Microfacet {
                reflectance,
                distribution,
                fresnel,
                ..
            } if some(*reflectance) => {
                match distribution {
                    DistributionSpec::Isotropic {
                        family: Family::Charlie,
                        ..
                    } => self.sheen(fresnel, prefix),
                    _ => self.fresnel(fresnel, prefix),
                }
                self.distribution(distribution, prefix);
            }
            ModelSpec::Microfacet { .. } => {}
            ModelSpec::FresnelBlend { rd, rs, distribution } => {
                self.add(Effect::Dielectric, kind());
                if some(*rd) {
                    self.add(Effect::Diffuse, format!("{prefix}rd"));
                }
                for (name, colour) in [("rd", rd), ("rs", rs)] {
                    if colour.channels() == Channels::Rgb {
                        self.add(Effect::Colour, format!("{prefix}{name} differs between channels"));
                    }
                }
                self.distribution(distribution, prefix);
            }
            ModelSpec::SpecularReflection(mirror) if some(mirror.reflectance()) => {
                self.reflector(mirror.fresnel(), prefix);
            }
            ModelSpec::SpecularReflection(_) => {}
            ModelSpec::SpecularTransmission(window) if some(window.transmittance()) => {
                self.add(Effect::Transmission, kind());
            }
            ModelSpec::SpecularTransmission(_) => {}
            ModelSpec::FresnelSpecular(glass) => {
                if some(glass.transmittance()) {
                    self.add(Effect::Transmission, kind());
                } else if some(glass.reflectance()) {
                    self.add(Effect::Dielectric, kind());
                }
            }
            ModelSpec::RoughDielectric {
                reflectance,
                transmittance,
                family,
                roughness,
                ..
            } => {
                if some(*transmittance) {
                    self.add(Effect::Transmission, kind());
                } else if some(*reflectance) {
                    self.add(Effect::Dielectric, kind());
                } else {
                    return;
                }
                let (family, roughness) = (*family, *roughness);
                self.distribution(&DistributionSpec::Isotropic { family, roughness }, prefix);
            }
            ModelSpec::HalfAngle(table) => self.measured(kind(), table.table().channels()),
            ModelSpec::Irregular(samples) => self.measured(kind(), samples.data().channels()),
            ModelSpec::BrdfToBtdf(bxdf) => {
                let inner = format!("{prefix}bxdf.");
                self.of(bxdf, &inner);
                if !bxdf.calls().is_empty() {
                    self.add(Effect::Transmission, kind());
                }
            }
            ModelSpec::Scaled { bxdf, scale } if some(*scale) => self.of(bxdf, &format!("{prefix}bxdf.")),
            ModelSpec::Scaled { .. } => {}
            ModelSpec::Sum(parts) => {
                for (index, part) in parts.iter().enumerate() {
                    self.of(part, &format!("{prefix}bxdfs[{index}]."));
                }
            }
            ModelSpec::DiffuseSpecular { specular, ks, kd, .. } => {
                if some(*ks) {
                    self.of(specular, &format!("{prefix}specular."));
                }
                if some(*kd) {
                    self.add(Effect::Diffuse, format!("{prefix}kd"));
                }
            }
            ModelSpec::Layered { top, base, .. } => {
                let inner = format!("{prefix}top.");
                let is_sheen = top.calls().iter().any(|call| call.effect == Effect::Sheen);
                if !is_sheen && !top.calls().is_empty() {
                    self.add(Effect::Clearcoat, format!("{inner}type = {}", top.type_name()));
                }
                self.of(top, &inner);
                self.of(base, &format!("{prefix}base."));
            }
        }
    }

    fn measured(&mut self, by: String, channels: Channels) {
        if channels == Channels::Rgb {
            self.add(Effect::Colour, format!("{by}, whose channels differ"));
        }
        self.add(Effect::Measured, by);
    }

    /// A metal or a dielectric.
    fn reflector(&mut self, fresnel: &Fresnel, prefix: &str) {
        let by = |what: &str| format!("{prefix}fresnel = {what}");
        match fresnel {
            Fresnel::None => self.add(Effect::Metal, by("none: it reflects all, as a perfect conductor")),
            Fresnel::Dielectric { .. } => self.add(Effect::Dielectric, by("dielectric")),
            Fresnel::Conductor { .. } => self.add(Effect::Metal, by("conductor")),
            Fresnel::ConductorApproximate { .. } => self.add(Effect::Metal, by("conductor-approximate")),
            Fresnel::Schlick { r0 } => {
                let most = r0.value().max_element();
                if most <= DIELECTRIC_R0 {
                    self.add(Effect::Dielectric, by(&format!("schlick, r0 up to {most}")));
                } else {
                    self.add(
                        Effect::Metal,
                        by(&format!("schlick, r0 up to {most}, more than of any dielectric")),
                    );
                }
            }
        }
    }

    /// Fibres, whose Fresnel term does not say what they are made of.
    fn sheen(&mut self, fresnel: &Fresnel, prefix: &str) {
        self.add(Effect::Sheen, format!("{prefix}distribution = charlie"));
        self.colour(fresnel, prefix);
    }

    fn fresnel(&mut self, fresnel: &Fresnel, prefix: &str) {
        self.reflector(fresnel, prefix);
        self.colour(fresnel, prefix);
    }

    fn colour(&mut self, fresnel: &Fresnel, prefix: &str) {
        // r0 of Schlick's approximation is a factor of two tables that know no colour
        if fresnel.channels() == Channels::Rgb && !matches!(fresnel, Fresnel::Schlick { .. }) {
            self.add(Effect::Colour, format!("{prefix}fresnel differs between channels"));
        }
    }

    fn distribution(&mut self, distribution: &DistributionSpec, prefix: &str) {
        match distribution {
            DistributionSpec::Anisotropic(anisotropic) => {
                let [x, y] = anisotropic.kind().legal().map(|legal| legal.name);
                let values = anisotropic.parameters();
                let by = format!("{prefix}distribution: {x} = {} and {y} = {}", values[0], values[1]);
                self.add(Effect::Anisotropy, by);
            }
            DistributionSpec::Isotropic { family, .. } => {
                if let Some((_, min, max)) = distribution.range() {
                    let name = family.legal().name;
                    self.add(
                        Effect::RoughnessRange,
                        format!("{prefix}distribution: {name} in [{min}, {max}]"),
                    );
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use crate::scene::Scene;

    fn calls(bxdf: &str) -> Vec<(&'static str, String)> {
        let scene = Scene::parse(&format!("[[material]]\nname = \"m\"\n{bxdf}"), "s.toml").unwrap();
        let calls = &scene.materials[0].calls;
        calls.iter().map(|call| (call.effect.name(), call.by.clone())).collect()
    }

    fn names(bxdf: &str) -> Vec<&'static str> {
        calls(bxdf).into_iter().map(|(name, _)| name).collect()
    }

    #[test]
    fn effects_follow_from_the_parameters() {
        for (bxdf, expected) in [
            ("bxdf = { type = \"lambertian\", reflectance = 0.5 }", vec!["diffuse"]),
            ("bxdf = { type = \"lambertian\", reflectance = 0.0 }", vec![]),
            (
                "[material.bxdf]\ntype = \"microfacet\"\ndistribution = { type = \"ggx\", alpha_x = 0.1, alpha_y = 0.2 }\n\
                 masking = \"smith\"\nfresnel = { type = \"conductor\", metal = \"Au\" }",
                vec!["metal", "anisotropy", "colour"],
            ),
            (
                "[material.bxdf]\ntype = \"diffuse-specular\"\nks = 1.0\nkd = 0.0\ncoupling = \"mikkelsen\"\n\
                 [material.bxdf.specular]\ntype = \"microfacet\"\ndistribution = { type = \"ggx\", alpha = { min = 0.1, max = 0.2 } }\n\
                 masking = \"smith\"\nfresnel = { type = \"dielectric\", eta = 1.5 }",
                vec!["dielectric", "roughness-range"],
            ),
            (
                "bxdf = { type = \"fresnel-specular\", eta_b = 1.5 }",
                vec!["transmission"],
            ),
            (
                "bxdf = { type = \"scaled\", scale = 0.0, bxdf = { type = \"lambertian\", reflectance = 0.5 } }",
                vec![],
            ),
        ] {
            assert_eq!(names(bxdf), expected, "{bxdf}");
        }
    }

    #[test]
    fn calls_name_the_property() {
        let found = calls(
            "[material.bxdf]\ntype = \"diffuse-specular\"\nks = 1.0\nkd = 0.5\ncoupling = \"mikkelsen\"\n\
             [material.bxdf.specular]\ntype = \"microfacet\"\ndistribution = { type = \"ggx\", alpha = 0.1 }\n\
             masking = \"smith\"\nfresnel = { type = \"schlick\", r0 = 0.04 }",
        );
        assert_eq!(
            found,
            [
                (
                    "dielectric",
                    "bxdf.specular.fresnel = schlick, r0 up to 0.04".to_owned()
                ),
                ("diffuse", "bxdf.kd".to_owned()),
            ]
        );
    }
}
