//! The lobes of a material: what of it is a factor, what a closed form, and what needs a table.

use super::Economy;
use crate::bxdf::{Coupling, Lambertian, ModelError, Transport, Veil};
use crate::fresnel::Fresnel;
use crate::scene::{Material, ModelSpec};
use crate::spectrum::Spectrum;
use crate::table::Lobe;
use glam::DVec3;

/// The diffuse base that eq. 28 couples to a lobe.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Base {
    /// Scale of the specular lobe.
    pub ks: Spectrum,
    /// Albedo of the base.
    pub kd: Spectrum,
    /// How both share their energy.
    pub coupling: Coupling,
    /// What the sum of both is multiplied with.
    pub outer: Spectrum,
    /// Which of the couplings of the material it belongs to, from 0: lobes of the same one share one base.
    pub index: usize,
}

/// A layer that a lobe lies below.
#[derive(Debug, Clone, PartialEq)]
pub struct Layer {
    /// The lobes of the layer, as places among those of the material; their albedos add up.
    pub lobes: Vec<usize>,
    /// How it dims what lies below.
    pub veil: Veil,
}

/// A lobe of a material on one side of the surface: `scale` times the albedo of `model`.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Part {
    /// The model without the factors that its albedo is linear in.
    pub(super) model: ModelSpec,
    /// Their product.
    pub(super) scale: Spectrum,
    /// r0 of Schlick's Fresnel term, where `model` stands for every r0.
    pub(super) r0: Option<Spectrum>,
    pub(super) lobe: Lobe,
    /// The base that it is coupled to, where that scatters light.
    pub(super) base: Option<Base>,
    /// Whether it is the specular lobe of a coupling, with or without a base that scatters.
    pub(super) specular: bool,
    /// Whether rho_hd is a closed form.
    pub(super) closed: bool,
    /// The layers above it, the uppermost first.
    pub(super) layers: Vec<Layer>,
}

/// What has been gathered on the way down to a lobe.
#[derive(Clone, Copy)]
struct Above {
    scale: Spectrum,
    /// Whether reflection and transmission have changed sides.
    mirrored: bool,
    base: Option<Base>,
    specular: bool,
}

/// The lobes of `material` that scatter light, in the order of its definition.
///
/// # Errors
/// [`ModelError`] for a model that no scene holds.
pub(super) fn parts(material: &Material, economy: Economy) -> Result<Vec<Part>, ModelError> {
    let mut parts = Vec::new();
    let above = Above {
        scale: Spectrum::grey(1.0),
        mirrored: false,
        base: None,
        specular: false,
    };
    gather(&material.model, above, economy, (&mut parts, &mut 0))?;
    Ok(parts)
}

fn lambertian(kd: Spectrum) -> Result<ModelSpec, ModelError> {
    Ok(ModelSpec::Lambertian(Lambertian::new(kd)?))
}

/// Adds the lobes of `model` to `parts`; `couplings` counts those that were met.
fn gather(
    model: &ModelSpec,
    above: Above,
    economy: Economy,
    (parts, couplings): (&mut Vec<Part>, &mut usize),
) -> Result<(), ModelError> {
    match model {
        ModelSpec::Scaled { bxdf, scale } => {
            let scale = times(above.scale, *scale);
            gather(bxdf, Above { scale, ..above }, economy, (parts, couplings))
        }
        ModelSpec::BrdfToBtdf(bxdf) => {
            let mirrored = !above.mirrored;
            gather(bxdf, Above { mirrored, ..above }, economy, (parts, couplings))
        }
        ModelSpec::Sum(all) => all
            .iter()
            .try_for_each(|part| gather(part, above, economy, (&mut *parts, &mut *couplings))),
        ModelSpec::DiffuseSpecular {
            specular,
            ks,
            kd,
            coupling,
        } => {
            let base = Base {
                ks: *ks,
                kd: *kd,
                coupling: *coupling,
                outer: above.scale,
                index: *couplings,
            };
            *couplings += 1;
            if economy.closed_forms && is_black(*ks) {
                // what is left is a Lambertian; of one the reflectance is a colour within [0, 1], as kd is
                return gather(&lambertian(*kd)?, above, economy, (parts, couplings));
            }
            let is_bare = economy.coupling && is_black(*kd);
            let below = Above {
                scale: if is_bare {
                    times(above.scale, *ks)
                } else {
                    Spectrum::grey(1.0)
                },
                base: (!is_bare).then_some(base),
                specular: true,
                ..above
            };
            let before = parts.len();
            gather(specular, below, economy, (parts, couplings))?;
            if parts.len() == before && !is_bare {
                // the same where the specular lobe scatters nothing
                return gather(&lambertian(*kd)?, above, economy, (parts, couplings));
            }
            Ok(())
        }
        ModelSpec::Layered { top, base, veil } => {
            let before = parts.len();
            gather(top, above, economy, (&mut *parts, &mut *couplings))?;
            let between = parts.len();
            gather(base, above, economy, (&mut *parts, couplings))?;
            let reflects = |index: &usize| parts[*index].lobe == Lobe::Reflection;
            let layer = Layer {
                lobes: (before..between).filter(reflects).collect(),
                veil: *veil,
            };
            // a layer that scatters nothing dims nothing
            if !layer.lobes.is_empty() {
                for part in &mut parts[between..] {
                    part.layers.insert(0, layer.clone());
                }
            }
            Ok(())
        }
        leaf => {
            parts.extend(lobes(leaf, above, economy)?);
            Ok(())
        }
    }
}

/// The sides of a model that is not made of others.
fn lobes(leaf: &ModelSpec, above: Above, economy: Economy) -> Result<Vec<Part>, ModelError> {
    let mut parts = Vec::new();
    for lobe in Lobe::ALL {
        let (model, own, r0) = stripped(leaf, if above.mirrored { lobe.other() } else { lobe }, economy);
        let scale = times(above.scale, own);
        if economy.closed_forms && is_black(scale) {
            continue;
        }
        let model = match above.mirrored {
            true => ModelSpec::BrdfToBtdf(Box::new(model)),
            false => model,
        };
        let flags = model.at(None)?.flags();
        if economy.sides && !flags.contains(lobe.flag()) {
            continue;
        }
        parts.push(Part {
            closed: is_closed(&model) || !flags.contains(lobe.flag()),
            model,
            scale: if economy.sharing { scale } else { above.scale },
            r0,
            lobe,
            base: above.base,
            specular: above.specular,
            layers: Vec::new(),
        });
    }
    Ok(parts)
}

/// Schlick's r0 in the channels of a pair of tables: rho is linear in r0, rho(r0) = (1 - r0) R + r0 G.
const PAIR: [f64; 3] = [0.0, 1.0, 1.0];

/// The model without the factors that its albedo on the side `lobe` is linear in, their product, and r0 where a pair holds
/// all.
fn stripped(leaf: &ModelSpec, lobe: Lobe, economy: Economy) -> (ModelSpec, Spectrum, Option<Spectrum>) {
    match leaf {
        ModelSpec::Microfacet {
            reflectance,
            distribution,
            masking,
            fresnel,
        } => {
            let (fresnel, r0) = match fresnel {
                Fresnel::Schlick { r0 } if economy.split_sum => {
                    let all = Fresnel::Schlick {
                        r0: Spectrum::rgb(PAIR),
                    };
                    (all, Some(*r0))
                }
                other => (*other, None),
            };
            let unit = ModelSpec::Microfacet {
                reflectance: if economy.sharing {
                    Spectrum::grey(1.0)
                } else {
                    *reflectance
                },
                distribution: *distribution,
                masking: *masking,
                fresnel,
            };
            (unit, *reflectance, r0)
        }
        ModelSpec::RoughDielectric {
            reflectance,
            transmittance,
            family,
            roughness,
            masking,
            media,
        } => {
            let own = match lobe {
                Lobe::Reflection => *reflectance,
                Lobe::Transmission => *transmittance,
            };
            if !economy.sharing {
                return (leaf.clone(), own, None);
            }
            let unit = ModelSpec::RoughDielectric {
                reflectance: Spectrum::grey(1.0),
                transmittance: Spectrum::grey(1.0),
                family: *family,
                roughness: *roughness,
                masking: *masking,
                media: *media,
            };
            (unit, own, None)
        }
        ModelSpec::Lambertian(base) if base.albedo() == DVec3::ZERO => (leaf.clone(), Spectrum::grey(0.0), None),
        other => (other.clone(), Spectrum::grey(1.0), None),
    }
}

/// Whether rho_hd of a model that is not made of others is a formula that a shader evaluates; adapters aside.
fn is_closed(model: &ModelSpec) -> bool {
    match model {
        ModelSpec::Lambertian(_)
        | ModelSpec::OrenNayar(_)
        | ModelSpec::SpecularReflection(_)
        | ModelSpec::SpecularTransmission(_)
        | ModelSpec::FresnelSpecular(_) => true,
        ModelSpec::BrdfToBtdf(bxdf) => is_closed(bxdf),
        _ => false,
    }
}

/// The closed form of rho_hd, in words of the scene.
pub(super) fn formula(model: &ModelSpec) -> &'static str {
    match model {
        ModelSpec::Lambertian(_) => "rho_hd = rho_hh = reflectance",
        ModelSpec::OrenNayar(_) => "rho_hd(mu) of Oren and Nayar's qualitative model, in elementary functions",
        ModelSpec::SpecularReflection(_) => "rho_hd = reflectance F(mu)",
        ModelSpec::SpecularTransmission(window) => match window.transport() {
            Transport::Importance => "rho_hd = transmittance (1 - F(mu))",
            Transport::Radiance => "rho_hd = transmittance (1 - F(mu)) (eta_a/eta_b)^2",
        },
        ModelSpec::FresnelSpecular(glass) => match glass.transport() {
            Transport::Importance => "rho_hd = reflectance F(mu), and transmittance (1 - F(mu)) on the other side",
            Transport::Radiance => {
                "rho_hd = reflectance F(mu), and transmittance (1 - F(mu)) (eta_a/eta_b)^2 on the other side"
            }
        },
        ModelSpec::BrdfToBtdf(bxdf) => formula(bxdf),
        _ => "nothing is scattered",
    }
}

fn is_black(spectrum: Spectrum) -> bool {
    spectrum.value() == DVec3::ZERO
}

fn times(a: Spectrum, b: Spectrum) -> Spectrum {
    Spectrum::rgb((a.value() * b.value()).to_array())
}
