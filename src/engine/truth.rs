//! What the tables of engines hold, as integrals over the hemisphere.

use super::disney::disney_diffuse;
use crate::bxdf::{Microfacet, Model, ModelError};
use crate::distribution::Family;
use crate::fresnel::{Fresnel, dielectric};
use crate::integrate::deterministic::quadrature;
use crate::integrate::{IntegrateError, RoughInterface, Target};
use crate::masking::Masking;
use crate::spectrum::Spectrum;
use thiserror::Error;

/// A family of lobes that share one table.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Lobe {
    /// Distribution of the normals; its parameter follows from the axes of the table.
    pub family: Family,
    /// Masking-shadowing.
    pub masking: Masking,
}

/// An integral that channels are made of, a function of mu, the roughness and, of glass, the index.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Quantity {
    /// B = int f (1 - o.h)^5 |cos theta_i| dwi with F = 1 in f: the albedo for r0 = 0 of Schlick's Fresnel term.
    Bias,
    /// E = A + B, the albedo for r0 = 1, that is with F = 1.
    Total,
    /// Albedo of Charlie sheen under the visibility of Ashikhmin and Neubelt. It exceeds 1 at grazing angles of smooth cloth.
    Sheen,
    /// Albedo of Burley's diffuse lobe as Unity normalises it.
    DisneyDiffuse,
    /// Share that a rough dielectric interface reflects.
    Reflected,
    /// Share that it lets through.
    Transmitted,
    /// Both together: what is missing to 1 is lost between the facets.
    Interface,
}

impl Quantity {
    /// The values that it has: texels stay within.
    pub(super) fn legal(self) -> [f64; 2] {
        match self {
            // no bound is known beyond which sheen does not go
            Self::Sheen => [0.0, f64::INFINITY],
            Self::DisneyDiffuse => [0.0, 2.0],
            _ => [0.0, 1.0],
        }
    }

    /// Largest error of its truth.
    pub(super) fn tolerance(self) -> f64 {
        match self {
            Self::Bias | Self::Total => 1e-7,
            Self::Sheen => 2e-5,
            Self::DisneyDiffuse => 1e-14,
            Self::Reflected | Self::Transmitted => 1e-5,
            Self::Interface => 2e-5,
        }
    }
}

/// Where an integral is wanted.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Place {
    /// cos theta_o in [0, 1].
    pub mu: f64,
    /// The parameter of the distribution: alpha or m.
    pub alpha: f64,
    /// Of an interface, the index of the far side over that of the side that the light comes from.
    pub eta: f64,
}

/// Why there is no truth.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum TruthError {
    /// The lobe does not exist.
    #[error(transparent)]
    Model(#[from] ModelError),
    /// The integral was not computed.
    #[error("at mu = {mu}, alpha = {alpha}, eta = {eta}: {source}", mu = place.mu, alpha = place.alpha, eta = place.eta)]
    Integral {
        /// Where.
        place: Place,
        /// Why.
        source: IntegrateError,
    },
}

impl Lobe {
    /// The `quantities` at `place`, in their order. Facets smoother than any legal lobe count as a mirror.
    ///
    /// # Errors
    /// [`TruthError`] where the lobe does not exist or its integral is not computed.
    pub fn values(&self, quantities: &[Quantity], place: Place) -> Result<Vec<f64>, TruthError> {
        let wants = |some: &[Quantity]| quantities.iter().any(|quantity| some.contains(quantity));
        let pair = match wants(&[Quantity::Bias, Quantity::Total]) {
            true => self.pair(place)?,
            false => [0.0; 2],
        };
        let sides = match wants(&[Quantity::Reflected, Quantity::Transmitted, Quantity::Interface]) {
            true => self.interface(place)?,
            false => [0.0; 2],
        };
        let value = |quantity: &Quantity| {
            Ok(match quantity {
                Quantity::Bias => pair[0],
                Quantity::Total => pair[1],
                Quantity::Reflected => sides[0],
                Quantity::Transmitted => sides[1],
                Quantity::Interface => sides[0] + sides[1],
                Quantity::Sheen => sheen(place)?,
                Quantity::DisneyDiffuse => disney_diffuse(place.mu, place.alpha.sqrt()),
            })
        };
        quantities.iter().map(value).collect()
    }

    /// B and E.
    fn pair(&self, place: Place) -> Result<[f64; 2], TruthError> {
        if place.alpha < self.family.legal().min {
            return Ok([schlick(place.mu), 1.0]);
        }
        let distribution = self.family.with(place.alpha).map_err(ModelError::from)?;
        let fresnel = Fresnel::Schlick {
            r0: Spectrum::rgb([0.0, 1.0, 1.0]),
        };
        let lobe = Microfacet::new(Spectrum::grey(1.0), distribution, self.masking, fresnel)?;
        let tolerance = Quantity::Total.tolerance();
        let found = quadrature(&Model::Microfacet(lobe), Target::rho_hd(place.mu, 0.0), tolerance);
        let found = found.map_err(|source| TruthError::Integral { place, source })?;
        Ok([found.value.x, found.value.y])
    }

    /// What an interface reflects and lets through.
    fn interface(&self, place: Place) -> Result<[f64; 2], TruthError> {
        if place.alpha < self.family.legal().min {
            // indices beyond those of a model, as the axes of tables reach
            let reflected = dielectric(place.mu, place.eta);
            return Ok([reflected, 1.0 - reflected]);
        }
        let distribution = self.family.with(place.alpha).map_err(ModelError::from)?;
        let interface = RoughInterface::new(distribution, self.masking, place.eta)?;
        let found = interface.albedos(place.mu, Quantity::Reflected.tolerance());
        let found = found.map_err(|source| TruthError::Integral { place, source })?;
        Ok([found.reflected, found.transmitted])
    }
}

/// Albedo of Charlie sheen; below the smallest legal alpha, that of the smallest.
fn sheen(place: Place) -> Result<f64, TruthError> {
    let alpha = place.alpha.max(Family::Charlie.legal().min);
    let distribution = Family::Charlie.with(alpha).map_err(ModelError::from)?;
    let lobe = Microfacet::new(Spectrum::grey(1.0), distribution, Masking::Neubelt, Fresnel::None)?;
    let tolerance = Quantity::Sheen.tolerance();
    let found = quadrature(&Model::Microfacet(lobe), Target::rho_hd(place.mu, 0.0), tolerance);
    let found = found.map_err(|source| TruthError::Integral { place, source })?;
    Ok(found.value.x)
}

/// (1 - mu)^5.
fn schlick(mu: f64) -> f64 {
    let square = (1.0 - mu) * (1.0 - mu);
    square * square * (1.0 - mu)
}
