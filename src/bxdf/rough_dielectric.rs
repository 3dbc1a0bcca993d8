//! Reflection and refraction by the facets of a rough interface of two dielectrics [Walter et al. 2007].
//!
//! With eta the index of the far side over that of the side of wo, and every direction and facet on that side counted with
//! positive cosines,
//!
//! - f_r = R F(o.h) G2 D(h)/(4 (n.o)(n.i)), h half way between the directions, the Torrance-Sparrow lobe;
//! - f_t = T (1 - F(o.h)) G2 D(h) (o.h)/((n.o)(n.i)) dh/di, with h along -(o + eta i) for eta > 1 and along o + eta i for
//!   eta < 1 [eq. 16], and dh/di = eta^2 |i.h|/((o.h) + eta (i.h))^2 [eq. 17; eq. 21].
//!
//! The sum in that Jacobian is the length of o + eta i but for its sign. Energy is accounted without the radiance scaling,
//! so that rho_t = int (1 - F) G2/G1 over the normals that wo sees; for radiance f_t is scaled by (eta_o/eta_i)^2 = eta^-2.
//! Then eta_o^2 f_t(o, i) = eta_i^2 f_t(i, o), and for radiance f_t(o, i)/eta_o^2 = f_t(i, o)/eta_i^2.

use super::specular::Interface;
use super::{Bxdf, BxdfSample, Flags, ModelError, Sampling, Transport, across, opposite_sides};
use crate::distribution::{Distribution, Isotropic};
use crate::fresnel::{dielectric_at, dielectric_passes};
use crate::geometry::{HalfVector, Polar, half_vector, reflect, squared_beyond};
use crate::masking::{Cosines, LARGEST, Masking, Smith};
use crate::parameter::{REFLECTANCE, TRANSMITTANCE};
use crate::spectrum::{Channels, Spectrum};
use glam::DVec3;

/// Least |eta_b/eta_a - 1| of a rough interface. The half vector of refraction is o + eta i, what is left of two nearly
/// opposite directions: at this bend it has ten digits.
pub const LEAST_BEND: f64 = 1e-6;

/// A rough interface of two dielectrics, medium a above it and medium b below.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RoughDielectric {
    reflectance: Spectrum,
    transmittance: Spectrum,
    distribution: Distribution,
    smith: Smith,
    masking: Masking,
    interface: Interface,
}

/// The media of an interface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Media {
    /// Index of refraction above the surface.
    pub eta_a: f64,
    /// Index of refraction below the surface.
    pub eta_b: f64,
    /// What is transported.
    pub transport: Transport,
}

impl RoughDielectric {
    /// Reflectance and transmittance in [0, 1] in every channel; GGX or Beckmann facets under one of the two Smith terms; the
    /// indices in [0.01, 100].
    ///
    /// Equal indices are refused: no facet bends light then, all of f_t is a delta, and of a rough interface nothing is left
    /// but its masking, which no light notices. [`FresnelSpecular`](super::FresnelSpecular) is the model of that.
    ///
    /// # Errors
    /// [`ModelError::Parameter`] outside of the ranges; [`ModelError::NeedsSmith`] and [`ModelError::SmithNeedsSlopes`] for
    /// other maskings and distributions; [`ModelError::NoBend`] for indices within [`LEAST_BEND`] of each other.
    pub fn new(
        reflectance: Spectrum,
        transmittance: Spectrum,
        distribution: Isotropic,
        masking: Masking,
        media: Media,
    ) -> Result<Self, ModelError> {
        let distribution = Distribution::from(distribution);
        if !masking.is_smith() {
            return Err(ModelError::NeedsSmith {
                masking: masking.name(),
            });
        }
        let smith = Smith::new(&distribution).ok_or(ModelError::SmithNeedsSlopes {
            masking: masking.name(),
            distribution: distribution.name(),
        })?;
        let interface = Interface::new(media.eta_a, media.eta_b, media.transport)?;
        if (media.eta_b / media.eta_a - 1.0).abs() < LEAST_BEND {
            return Err(ModelError::NoBend {
                eta_a: media.eta_a,
                eta_b: media.eta_b,
            });
        }
        Ok(Self {
            reflectance: reflectance.check(REFLECTANCE)?,
            transmittance: transmittance.check(TRANSMITTANCE)?,
            distribution,
            smith,
            masking,
            interface,
        })
    }

    /// Scale R of the reflected light.
    pub fn reflectance(&self) -> Spectrum {
        self.reflectance
    }

    /// Scale T of the transmitted light.
    pub fn transmittance(&self) -> Spectrum {
        self.transmittance
    }

    /// Distribution of the facets.
    pub fn distribution(&self) -> &Distribution {
        &self.distribution
    }

    /// Smith masking, uncorrelated or height-correlated: G2 = 1/(1 + Lambda(o) + Lambda(i)) on both sides.
    pub fn masking(&self) -> Masking {
        self.masking
    }

    /// Index of refraction above the surface.
    pub fn eta_a(&self) -> f64 {
        self.interface.eta_a
    }

    /// Index of refraction below the surface.
    pub fn eta_b(&self) -> f64 {
        self.interface.eta_b
    }

    /// What is transported.
    pub fn transport(&self) -> Transport {
        self.interface.transport
    }

    /// The same with importance transport.
    pub fn accounted(&self) -> Self {
        Self {
            interface: self.interface.accounted(),
            ..*self
        }
    }

    /// The same with the media exchanged: what light meets that comes from below.
    pub fn reversed(&self) -> Self {
        let Interface {
            eta_a,
            eta_b,
            transport,
        } = self.interface;
        Self {
            interface: Interface {
                eta_a: eta_b,
                eta_b: eta_a,
                transport,
            },
            ..*self
        }
    }

    pub(crate) fn smith(&self) -> Smith {
        self.smith
    }

    /// Index below the surface over that above it.
    pub(crate) fn eta(&self) -> f64 {
        self.interface.relative_eta(DVec3::Z)
    }

    /// What transport multiplies the light by that is transmitted from above.
    pub(crate) fn scale(&self) -> f64 {
        self.interface.scale(DVec3::Z)
    }

    fn correlated(&self) -> bool {
        self.masking == Masking::SmithCorrelated
    }

    /// f_r but for R, for directions above.
    fn reflected(&self, eta: f64, wo: DVec3, wi: DVec3) -> f64 {
        let Some(half) = half_vector(wo, wi) else { return 0.0 };
        let cosines = cosines(wo, wi, half.wh, half.cos_d);
        let fresnel = dielectric_at(facet_angle(wo, half.wh, half.cos_d), eta);
        fresnel * self.masking.lobe(&self.distribution, wo, wi, half.wh, cosines)
    }

    /// The half vector of refraction from `wo` above to `wi` below with the cosine o.h, the cosine |i.h| and dh/di.
    fn refracting(eta: f64, wo: DVec3, wi: DVec3) -> Option<Refraction> {
        let sum = wo + eta * wi;
        let length = sum.length();
        let h = sum / if eta > 1.0 { -length } else { length };
        let (cos_o, cos_i) = (wo.dot(h).min(1.0), (-wi.dot(h)).min(1.0));
        // light passes a facet from its front to its back, and facets face upwards
        if !(cos_o > 0.0 && cos_i > 0.0 && h.z > 0.0) {
            return None;
        }
        Some(Refraction {
            h,
            cos_o,
            cos_i,
            jacobian: eta * eta * cos_i / (length * length),
        })
    }

    /// f_t but for T and the scaling of radiance, for `wo` above and `wi` below.
    fn refracted(&self, eta: f64, wo: DVec3, wi: DVec3) -> f64 {
        let Some(at) = Self::refracting(eta, wo, wi) else {
            return 0.0;
        };
        let cosines = cosines(wo, wi, at.h, at.cos_o);
        let shape = 4.0 * self.smith.visibility(self.correlated(), wo, wi, cosines) * at.jacobian;
        let passes = dielectric_passes(at.cos_o, eta * at.cos_i, eta);
        let density = self.distribution.d(at.h);
        if density == 0.0 {
            return 0.0;
        }
        (passes * at.cos_o * shape * density).min(LARGEST)
    }

    /// Density of the normals that `wo` sees, D_o(h).
    fn visible(&self, wo: DVec3, h: DVec3, cos_d: f64) -> f64 {
        self.distribution.d(h) * cos_d / self.smith.seen(wo, wo.z.abs())
    }

    /// The direction from which a facet refracts light into `wo`, with the cosine that it makes with the facet; both are
    /// those of the Fresnel term that is not 1.
    fn refract(eta: f64, wo: DVec3, wm: DVec3, theta_d: Polar) -> Option<(DVec3, f64)> {
        let square = squared_beyond(theta_d, eta);
        if square <= 0.0 {
            return None;
        }
        let g = square.sqrt();
        // g - o.h of nearly equal cosines, so that small bends keep their digits
        let rise = (eta - 1.0) * (eta + 1.0) / (g + theta_d.cos);
        Some((-(wo + wm * rise) / eta, g))
    }
}

/// Refraction at a facet.
struct Refraction {
    h: DVec3,
    cos_o: f64,
    cos_i: f64,
    jacobian: f64,
}

/// The cosines of two directions on any sides.
fn cosines(wo: DVec3, wi: DVec3, h: DVec3, cos_d: f64) -> Cosines {
    Cosines {
        o: wo.z.abs(),
        i: wi.z.abs(),
        h: h.z,
        d: cos_d,
    }
}

/// The angle between a direction and a facet: the sine from what is across, which a cosine near 1 does not tell.
fn facet_angle(wo: DVec3, h: DVec3, cos_d: f64) -> Polar {
    Polar {
        sin: wo.cross(h).length().min(1.0),
        cos: cos_d,
    }
}

/// Both directions with the first above the surface, mirrored in it where needed; a first one at the horizon is above.
fn upright(wo: DVec3, wi: DVec3) -> (DVec3, DVec3) {
    if wo.z < 0.0 { (-wo, -wi) } else { (wo, wi) }
}

impl Bxdf for RoughDielectric {
    fn channels(&self) -> Channels {
        self.reflectance.channels().max(self.transmittance.channels())
    }

    fn flags(&self) -> Flags {
        Flags::REFLECTION | Flags::TRANSMISSION | Flags::GLOSSY
    }

    fn f(&self, wo: DVec3, wi: DVec3) -> DVec3 {
        if opposite_sides(wo, wi) {
            let (above, below) = upright(wo, wi);
            let eta = self.interface.relative_eta(wo);
            return self.transmittance.value() * (self.interface.scale(wo) * self.refracted(eta, above, below));
        }
        // the sum, so that a direction at the horizon goes with either side
        let is_below = wo.z + wi.z < 0.0;
        let (above, other) = if is_below { (-wo, -wi) } else { (wo, wi) };
        if above.z.max(other.z) <= 0.0 {
            return DVec3::ZERO;
        }
        let side = if is_below { -DVec3::Z } else { DVec3::Z };
        self.reflectance.value() * self.reflected(self.interface.relative_eta(side), above, other)
    }

    /// F D_o(h)/(4 (o.h)), and (1 - F) D_o(h) dh/di across the surface.
    fn pdf(&self, wo: DVec3, wi: DVec3) -> f64 {
        let eta = self.interface.relative_eta(wo);
        let (above, other) = upright(wo, wi);
        if let Some(at) = Self::refracting(eta, above, other) {
            let passes = dielectric_passes(at.cos_o, eta * at.cos_i, eta);
            // facets refract light below the surface, or for eta < 1 above it too, where it is lost
            if other.z < 0.0 {
                return (passes * at.jacobian * self.visible(above, at.h, at.cos_o)).min(LARGEST);
            }
        }
        let Some(HalfVector { wh, cos_d }) = half_vector(above, other) else {
            return 0.0;
        };
        if wh.z <= 0.0 || other.z < 0.0 {
            return 0.0;
        }
        let fresnel = dielectric_at(facet_angle(above, wh, cos_d), eta);
        fresnel
            * self
                .masking
                .visible_pdf(&self.distribution, above, above.z.abs(), wh, cos_d)
    }

    /// Visible normals, and of the two ways that a facet sends light on, reflection with probability F: the third of `u`
    /// decides. F and 1 - F cancel in the weights, which are R or T times G2/G1(o).
    fn sample_f(&self, wo: DVec3, u: [f64; 3]) -> BxdfSample {
        let eta = self.interface.relative_eta(wo);
        let (above, turned) = (upright(wo, wo).0, wo.z < 0.0);
        let wm = self.smith.sample_visible(above, [u[0], u[1]]);
        let turn = |w: DVec3| if turned { -w } else { w };
        let cos_d = above.dot(wm).min(1.0);
        if !(cos_d > 0.0 && wm.z > 0.0) {
            return BxdfSample::lost(turn(reflect(above, wm)));
        }
        let theta_d = facet_angle(above, wm, cos_d);
        let refracted = Self::refract(eta, above, wm, theta_d);
        let passes = refracted.map_or(0.0, |(_, g)| dielectric_passes(cos_d, g, eta));
        let visible = self.visible(above, wm, cos_d);
        match refracted {
            Some((wi, g)) if u[2] < passes => {
                if wi.z > 0.0 {
                    return BxdfSample::lost(turn(wi));
                }
                let wi = across(above, wi);
                let seen = self
                    .smith
                    .visible_weight(self.correlated(), above, wi, cosines(above, wi, wm, cos_d));
                // |o + eta i| = |g - o.h|
                let bend = (eta - 1.0) * (eta + 1.0) / (g + cos_d);
                BxdfSample {
                    wi: turn(wi),
                    pdf: (passes * visible * eta * g / (bend * bend)).min(LARGEST),
                    weight: self.transmittance.value() * (self.interface.scale(wo) * seen),
                    flags: Flags::TRANSMISSION | Flags::GLOSSY,
                }
            }
            _ => {
                let wi = reflect(above, wm);
                let cos_i = 2.0 * cos_d * wm.z - above.z;
                if cos_i <= 0.0 {
                    return BxdfSample::lost(turn(wi));
                }
                let cosines = Cosines {
                    i: cos_i,
                    ..cosines(above, wi, wm, cos_d)
                };
                let seen = self.smith.visible_weight(self.correlated(), above, wi, cosines);
                BxdfSample {
                    wi: turn(wi),
                    // 1 - passes has no digits where the media are nearly matched
                    pdf: (dielectric_at(theta_d, eta) * visible / (4.0 * cos_d)).min(LARGEST),
                    weight: self.reflectance.value() * seen,
                    flags: Flags::REFLECTION | Flags::GLOSSY,
                }
            }
        }
    }

    fn supports(&self, sampling: Sampling) -> bool {
        sampling != Sampling::Normals
    }
}
