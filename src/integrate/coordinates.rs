//! From places in a table to the integrals that they hold.

use super::Target;
use crate::table::Quantity;
use crate::table::axis::{AZIMUTH, Axis, MU};

/// Which axis of a table is which coordinate.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Coordinates {
    mu: Option<usize>,
    phi: Option<usize>,
    roughness: Option<usize>,
}

impl Coordinates {
    /// By the names of the axes.
    pub fn new(axes: &[Axis]) -> Self {
        let find = |name: &str| axes.iter().position(|axis| axis.parameter == name);
        Self {
            mu: find(MU),
            phi: find(AZIMUTH),
            roughness: axes
                .iter()
                .position(|axis| axis.parameter != MU && axis.parameter != AZIMUTH),
        }
    }

    /// The reflection integral at `place`, one value per axis.
    pub fn target(&self, quantity: Quantity, place: &[f64]) -> Target {
        let at = |index: Option<usize>| index.and_then(|index| place.get(index)).copied();
        match quantity {
            // a table without an axis of mu holds the normal, and one without azimuth any
            Quantity::RhoHd => Target::rho_hd(at(self.mu).unwrap_or(1.0), at(self.phi).unwrap_or(0.0)),
            Quantity::RhoHh => Target::rho_hh(),
        }
    }

    /// The roughness at `place`, where there is an axis for it.
    pub fn roughness(&self, place: &[f64]) -> Option<f64> {
        self.roughness.and_then(|index| place.get(index)).copied()
    }
}
