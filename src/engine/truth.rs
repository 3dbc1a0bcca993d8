//! What the tables of engines hold, as integrals.

use crate::bxdf::{Microfacet, Model, ModelError};
use crate::distribution::Family;
use crate::fresnel::Fresnel;
use crate::integrate::deterministic::quadrature;
use crate::integrate::{IntegrateError, Target};
use crate::masking::Masking;
use crate::spectrum::Spectrum;
use thiserror::Error;

/// Largest error of a truth: a tenth of the smallest error that tables are fitted to.
pub(super) const TOLERANCE: f64 = 1e-6;

/// A family of lobes that share one table.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Lobe {
    /// Distribution of the normals; its parameter follows from the axes of the table.
    pub family: Family,
    /// Masking-shadowing.
    pub masking: Masking,
}

/// An integral that channels are made of, a function of mu and the roughness.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Quantity {
    /// B = int f (1 - o.h)^5 |cos theta_i| dwi with F = 1 in f: the albedo for r0 = 0 of Schlick's Fresnel term.
    Bias,
    /// E = A + B, the albedo for r0 = 1, that is with F = 1.
    Total,
}

/// Where an integral is wanted.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Place {
    /// cos theta_o in [0, 1].
    pub mu: f64,
    /// The parameter of the distribution: alpha or m.
    pub alpha: f64,
}

/// Why there is no truth.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum TruthError {
    /// The lobe does not exist.
    #[error(transparent)]
    Model(#[from] ModelError),
    /// The integral was not computed.
    #[error("at mu = {mu}, alpha = {alpha}: {source}", mu = place.mu, alpha = place.alpha)]
    Integral {
        /// Where.
        place: Place,
        /// Why.
        source: IntegrateError,
    },
}

impl Lobe {
    /// B and E at `place`, each within 1e-6.
    ///
    /// A facet that is smoother than any legal lobe is a mirror: B = (1 - mu)^5, E = 1.
    ///
    /// # Errors
    /// [`TruthError`] where the lobe does not exist or its integral is not computed.
    pub fn pair(&self, place: Place) -> Result<[f64; 2], TruthError> {
        if place.alpha < self.family.legal().min {
            return Ok([mirror(place.mu), 1.0]);
        }
        let distribution = self.family.with(place.alpha).map_err(ModelError::from)?;
        let fresnel = Fresnel::Schlick {
            r0: Spectrum::rgb([0.0, 1.0, 1.0]),
        };
        let lobe = Microfacet::new(Spectrum::grey(1.0), distribution, self.masking, fresnel)?;
        let found = quadrature(&Model::Microfacet(lobe), Target::rho_hd(place.mu, 0.0), TOLERANCE);
        let found = found.map_err(|source| TruthError::Integral { place, source })?;
        Ok([found.value.x, found.value.y])
    }
}

/// (1 - mu)^5.
fn mirror(mu: f64) -> f64 {
    let square = (1.0 - mu) * (1.0 - mu);
    square * square * (1.0 - mu)
}
