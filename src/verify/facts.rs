//! What is known of a model beyond its [`Bxdf`](crate::bxdf::Bxdf).

use crate::bxdf::{DiffuseSpecular, Microfacet, Model, Transport};
use crate::distribution::Distribution;
use crate::fresnel::Fresnel;
use crate::masking::{Masking, Smith, visible_groove_pdf};
use crate::spectrum::Spectrum;
use glam::DVec3;

/// A density over the normals of the upper hemisphere, sr^-1.
pub type Density<'a> = Box<dyn Fn(DVec3) -> f64 + Sync + 'a>;

/// A density of visible normals, as a function of wo and the normal, sr^-1.
pub type VisibleDensity<'a> = Box<dyn Fn(DVec3, DVec3) -> f64 + Sync + 'a>;

/// A distribution of normals by its densities.
pub struct Normals<'a> {
    /// p(h) = D(h) (n.h), which integrates to 1.
    pub all: Density<'a>,
    /// G1 max(0, o.h) D(h)/(n.o), which integrates to 1; or why there is none.
    pub visible: Result<VisibleDensity<'a>, &'static str>,
}

/// How the throughput of transmitted light behaves when it runs the other way.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum TransmissionRule {
    /// The same both ways: no indices, or importance transport.
    Plain,
    /// Radiance transport between media of these indices: the throughput of light that enters wi's medium from wo's is
    /// scaled by (eta_o/eta_i)^2, and so the two ways differ by (eta_o/eta_i)^4 [pbrt 2016, section 8.2].
    ///
    /// For smooth transmission f(wo, wi)/eta_o^2 = f(wi, wo)/eta_i^2: of f, the other half of that factor is in the solid
    /// angles, cos theta_i eta_i^2 dwi = cos theta_o eta_o^2 dwo.
    Scaled {
        /// Index above the surface.
        eta_above: f64,
        /// Index below it.
        eta_below: f64,
    },
    /// Importance transport through rough interfaces of media of these indices: eta_o^2 f(wo, wi) = eta_i^2 f(wi, wo)
    /// [Walter et al. 2007, section 5].
    Refracted {
        /// Index above the surface.
        eta_above: f64,
        /// Index below it.
        eta_below: f64,
    },
}

/// What is known of a model.
pub struct Facts<'a> {
    /// Its distributions of normals.
    pub normals: Vec<Normals<'a>>,
    /// How transmitted light behaves.
    pub transmission: TransmissionRule,
    /// Its approximate Fresnel terms, each with the exact one.
    pub approximations: Vec<[Fresnel; 2]>,
    /// The coupling, when it is one.
    pub coupled: Option<&'a DiffuseSpecular>,
}

impl Default for Facts<'_> {
    fn default() -> Self {
        Self {
            normals: Vec::new(),
            transmission: TransmissionRule::Plain,
            approximations: Vec::new(),
            coupled: None,
        }
    }
}

/// The facts of a model that scenes can name, those of its parts included.
pub fn facts(model: &Model) -> Facts<'_> {
    match model {
        Model::Microfacet(microfacet) => Facts {
            normals: vec![normals(microfacet)],
            approximations: approximation(microfacet.fresnel),
            ..Facts::default()
        },
        Model::FresnelBlend(blend) => Facts {
            normals: vec![Normals {
                all: every(blend.distribution()),
                visible: Err("a fresnel-blend masks nothing"),
            }],
            ..Facts::default()
        },
        Model::SpecularReflection(mirror) => Facts {
            approximations: approximation(*mirror.fresnel()),
            ..Facts::default()
        },
        Model::SpecularTransmission(window) => Facts {
            transmission: rule(window.transport(), window.eta_a(), window.eta_b()),
            ..Facts::default()
        },
        Model::FresnelSpecular(glass) => Facts {
            transmission: rule(glass.transport(), glass.eta_a(), glass.eta_b()),
            ..Facts::default()
        },
        Model::RoughDielectric(glass) => Facts {
            normals: vec![Normals {
                all: every(glass.distribution()),
                visible: visible(glass.distribution(), glass.masking()),
            }],
            transmission: match rule(glass.transport(), glass.eta_a(), glass.eta_b()) {
                TransmissionRule::Plain => TransmissionRule::Refracted {
                    eta_above: glass.eta_a(),
                    eta_below: glass.eta_b(),
                },
                scaled => scaled,
            },
            ..Facts::default()
        },
        Model::DiffuseSpecular(coupled) => Facts {
            coupled: Some(coupled),
            ..facts(coupled.specular())
        },
        made => {
            let parts = made.parts().into_iter().map(facts);
            parts.fold(Facts::default(), |mut all, part| {
                all.normals.extend(part.normals);
                all.approximations.extend(part.approximations);
                if part.transmission != TransmissionRule::Plain {
                    all.transmission = part.transmission;
                }
                all
            })
        }
    }
}

fn rule(transport: Transport, eta_above: f64, eta_below: f64) -> TransmissionRule {
    match transport {
        Transport::Radiance => TransmissionRule::Scaled { eta_above, eta_below },
        Transport::Importance => TransmissionRule::Plain,
    }
}

fn approximation(fresnel: Fresnel) -> Vec<[Fresnel; 2]> {
    exact(fresnel).map(|exact| [fresnel, exact]).into_iter().collect()
}

/// D (n.h): p by the other of the two forms that every distribution has.
fn every(distribution: &Distribution) -> Density<'_> {
    Box::new(|h| distribution.d(h) * h.z)
}

fn normals(microfacet: &Microfacet) -> Normals<'_> {
    let distribution = &microfacet.distribution;
    Normals {
        all: every(distribution),
        visible: visible(distribution, microfacet.masking),
    }
}

fn visible(distribution: &Distribution, masking: Masking) -> Result<VisibleDensity<'_>, &'static str> {
    match (masking, Smith::new(distribution)) {
        (Masking::None, _) => Err("without masking there are no visible normals"),
        (Masking::VGroove, _) => Ok(Box::new(|wo, h| {
            visible_groove_pdf(distribution, wo.z, h, wo.dot(h).min(1.0))
        })),
        (Masking::Smith | Masking::SmithCorrelated, Some(smith)) => Ok(Box::new(move |wo, h| {
            distribution.d(h) * wo.dot(h).clamp(0.0, 1.0) / smith.seen(wo, wo.z)
        })),
        (Masking::Smith | Masking::SmithCorrelated, None) => Err("its distribution has no Lambda"),
        (Masking::Neubelt | Masking::Charlie, _) => Err("the maskings of sheen say of no facet whether it is seen"),
    }
}

/// What an approximate Fresnel term approximates.
fn exact(fresnel: Fresnel) -> Option<Fresnel> {
    let pair = |eta: Spectrum, k: Spectrum| Fresnel::conductor(eta, k).ok();
    match fresnel {
        Fresnel::ConductorApproximate { eta, k } => pair(eta, k),
        Fresnel::None | Fresnel::Dielectric { .. } | Fresnel::Conductor { .. } | Fresnel::Schlick { .. } => None,
    }
}
