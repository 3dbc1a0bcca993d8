//! rho_hd and rho_hh of a rough interface of two dielectrics, both sides, deterministically.
//!
//! With D_o the density of the normals that wo sees, rho_r = int D_o F G2/G1(o) and rho_t = int D_o (1 - F) G2/G1(o)
//! [Walter et al. 2007], energy accounted without the radiance scaling. `view` has the integrand in the slopes of the facets,
//! `rules` the quadrature.
//!
//! Of light that comes from the thinner medium F is smooth, and what is reflected has the rules of [`super::smith_hd`] where
//! those converge. From the denser one the kinks of total reflection stay out of what is reflected, too: it is what F = 1
//! would reflect, which those rules know, less int D_o (1 - F) G2/G1 over the facets that let light through.

mod rules;
#[cfg(test)]
mod tests;
mod view;

use super::hemisphere::Mean;
use super::{Angles, IntegrateError, Lobe, Target, facets, smith_hd};
use crate::bxdf::{Microfacet, ModelError, RoughDielectric};
use crate::distribution::{Distribution, Isotropic};
use crate::fresnel::Fresnel;
use crate::masking::{Cosines, Masking, Smith};
use crate::numerics::quadrature::{Bounded, Integral};
use crate::parameter::Legal;
use crate::spectrum::Spectrum;
use glam::DVec3;
use rules::{TAIL_SHARE, over_slopes};
use view::{Facets, View, Way};

/// The quotient of two legal indices.
const QUOTIENT: Legal = Legal::new("eta", 1e-4, 1e4);

/// Facets between two media of unit reflectance and transmittance: albedos for one direction at a time, for tables over more
/// than a scene has axes for.
#[derive(Debug, Clone, Copy)]
pub struct RoughInterface {
    lobe: Microfacet,
    facets: Facets,
    smith: Smith,
}

/// What of the light from one direction is sent back and what is let through, without the radiance scaling.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct InterfaceAlbedos {
    /// rho_hd of the reflected part.
    pub reflected: f64,
    /// Bound of its error.
    pub reflected_error: f64,
    /// rho_hd of the transmitted part.
    pub transmitted: f64,
    /// Bound of its error.
    pub transmitted_error: f64,
    /// Evaluations of both integrands.
    pub evaluations: u64,
}

impl RoughInterface {
    /// GGX or Beckmann facets under one of the two Smith terms, and eta, the index of the far side over that of the side
    /// that the light comes from, in [1e-4, 1e4]: 1/1.5 is light that meets glass from inside.
    ///
    /// eta = 1 is the limit eta -> 1 at fixed mu > 0, in which nothing is reflected and facets hide light that they do not
    /// bend. At mu = 0 it is the limit of that for mu -> 0: there the order of both limits matters.
    ///
    /// # Errors
    /// [`ModelError`] for other distributions, maskings and indices.
    pub fn new(distribution: Isotropic, masking: Masking, eta: f64) -> Result<Self, ModelError> {
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
        Ok(Self::assembled(distribution, smith, masking, QUOTIENT.check(eta)?))
    }

    fn assembled(distribution: Distribution, smith: Smith, masking: Masking, eta: f64) -> Self {
        Self {
            lobe: Microfacet {
                reflectance: Spectrum::grey(1.0),
                distribution,
                masking,
                fresnel: Fresnel::Dielectric {
                    eta: Spectrum::grey(eta),
                },
            },
            facets: Facets::round(&smith, masking == Masking::SmithCorrelated, eta),
            smith,
        }
    }

    fn of(glass: &RoughDielectric) -> Self {
        Self::assembled(*glass.distribution(), glass.smith(), glass.masking(), glass.eta())
    }

    /// Both albedos at cos theta_o = `mu` in [0, 1], each with an absolute error of at most `tolerance`.
    ///
    /// # Errors
    /// [`IntegrateError::NotConverged`] where the tolerance is out of reach, as below the rounding of the terms.
    pub fn albedos(&self, mu: f64, tolerance: f64) -> Result<InterfaceAlbedos, IntegrateError> {
        let reflected = self.rho_hd(Lobe::Reflection, mu, tolerance)?;
        let transmitted = self.rho_hd(Lobe::Transmission, mu, tolerance)?;
        Ok(InterfaceAlbedos {
            reflected: reflected.bounded.value.x,
            reflected_error: reflected.bounded.error.x,
            transmitted: transmitted.bounded.value.x,
            transmitted_error: transmitted.bounded.error.x,
            evaluations: reflected.evaluations + transmitted.evaluations,
        })
    }

    fn rho_hd(&self, lobe: Lobe, mu: f64, tolerance: f64) -> Result<Integral, IntegrateError> {
        let mu = if mu < f64::MIN_POSITIVE { 0.0 } else { mu.min(1.0) };
        if self.facets.eta == 1.0 {
            return Ok(self.unbent(lobe, mu));
        }
        match lobe {
            Lobe::Transmission => self.along(Way::Refracted, mu, tolerance),
            Lobe::Reflection => self.reflected(mu, tolerance),
        }
    }

    /// The limit of facets that bend nothing: G2/G1(o) with i = -o.
    fn unbent(&self, lobe: Lobe, mu: f64) -> Integral {
        let wo = DVec3::new(((1.0 - mu) * (1.0 + mu)).sqrt(), 0.0, mu);
        let cosines = Cosines {
            o: mu,
            i: mu,
            h: 1.0,
            d: mu,
        };
        let passes = match lobe {
            Lobe::Reflection => 0.0,
            Lobe::Transmission if mu == 0.0 && self.facets.correlated => 0.5,
            Lobe::Transmission => self.smith.visible_weight(self.facets.correlated, wo, -wo, cosines),
        };
        Integral {
            bounded: Bounded {
                value: DVec3::splat(passes),
                error: DVec3::splat(8.0 * f64::EPSILON),
            },
            evaluations: 1,
        }
    }

    fn along(&self, way: Way, mu: f64, tolerance: f64) -> Result<Integral, IntegrateError> {
        let view = View::new(self.facets, way, mu, TAIL_SHARE * tolerance);
        Ok(over_slopes(&view, tolerance)?)
    }

    fn reflected(&self, mu: f64, tolerance: f64) -> Result<Integral, IntegrateError> {
        if self.facets.eta > 1.0 {
            if let Some(found) = smith_hd::rho_hd(&self.lobe, mu, tolerance) {
                return Ok(found);
            }
            return self.along(Way::Reflected, mu, tolerance);
        }
        let mirrors = Microfacet {
            fresnel: Fresnel::None,
            ..self.lobe
        };
        let all = match smith_hd::rho_hd(&mirrors, mu, 0.4 * tolerance) {
            Some(all) => all,
            None => facets::rho_hd(&mirrors, mu, 0.0, 0.4 * tolerance)?,
        };
        let missing = self.along(Way::Missing, mu, 0.6 * tolerance)?;
        Ok(Integral {
            bounded: Bounded {
                value: all.bounded.value - missing.bounded.value,
                error: all.bounded.error + missing.bounded.error,
            },
            evaluations: all.evaluations + missing.evaluations,
        })
    }

    /// rho_hh, the mean of rho_hd.
    fn rho_hh(&self, lobe: Lobe, tolerance: f64) -> Result<Integral, IntegrateError> {
        Mean {
            marks: &facets::mean_marks(&self.lobe),
            anisotropic: false,
            bound: 1.0,
            grows: false,
        }
        .integrate(tolerance, |mu, _, allowed| self.rho_hd(lobe, mu, allowed))
    }
}

/// The albedo of one side of `glass` with an absolute error of at most `tolerance`.
pub(super) fn quadrature(glass: &RoughDielectric, target: Target, tolerance: f64) -> Result<Integral, IntegrateError> {
    let scale = match target.lobe {
        Lobe::Reflection => glass.reflectance().value(),
        Lobe::Transmission => glass.transmittance().value() * glass.scale(),
    };
    let most = scale.max_element();
    if most == 0.0 {
        return Ok(Integral {
            bounded: Bounded::exact(DVec3::ZERO),
            evaluations: 0,
        });
    }
    let interface = RoughInterface::of(glass);
    let allowed = tolerance / most;
    let unit = match target.outgoing {
        Some(Angles { mu, .. }) => interface.rho_hd(target.lobe, mu, allowed)?,
        None => interface.rho_hh(target.lobe, allowed)?,
    };
    Ok(unit.scaled(scale))
}
