//! Estimators that differ by the points they draw, and the best sampling of each.

use super::ladder::{Accuracy, Curve};
use crate::estimate::Estimator;

/// What an estimator's name starts with.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Kin {
    /// A formula.
    ClosedForm,
    /// Deterministic rules.
    Quadrature,
    /// Randomised quasi-Monte Carlo.
    Qmc,
    /// One random point in every cell of a grid.
    Stratified,
    /// Independent random points.
    MonteCarlo,
}

impl Kin {
    /// Those that charts compare, from the most accurate.
    pub const COMPARED: [Self; 4] = [Self::Quadrature, Self::Qmc, Self::Stratified, Self::MonteCarlo];

    /// By the name, so that every estimator has a place, whichever there are.
    pub fn of(estimator: Estimator) -> Self {
        match estimator.name() {
            "closed-form" | "auto" => Self::ClosedForm,
            "quadrature" => Self::Quadrature,
            name if name.starts_with("qmc-") => Self::Qmc,
            name if name.starts_with("stratified-") => Self::Stratified,
            _ => Self::MonteCarlo,
        }
    }

    /// In legends.
    pub fn name(self) -> &'static str {
        match self {
            Self::ClosedForm => "closed form",
            Self::Quadrature => "quadrature",
            Self::Qmc => "quasi-Monte Carlo",
            Self::Stratified => "stratified",
            Self::MonteCarlo => "Monte Carlo",
        }
    }
}

impl Accuracy {
    /// Of the estimators of one kind the one that does most with its time: the least RMS error, at its last rung, times the
    /// root of the CPU time, by which Monte Carlo would pay for as much.
    pub fn best(&self, kin: Kin) -> Option<&Curve> {
        let merit = |curve: &Curve| {
            let points = curve.points();
            points.last().map(|point| point.rms_errors()[1] * point.cpu().sqrt())
        };
        let curves = self.curves.iter().filter(|curve| Kin::of(curve.estimator) == kin);
        let rated = curves.filter_map(|curve| Some((merit(curve)?, curve)));
        rated.min_by(|(a, _), (b, _)| a.total_cmp(b)).map(|(_, curve)| curve)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_estimator_has_its_kind() {
        for estimator in Estimator::ALL {
            let prefix = match Kin::of(estimator) {
                Kin::ClosedForm | Kin::Quadrature => continue,
                Kin::Qmc => "qmc-",
                Kin::Stratified => "stratified-",
                Kin::MonteCarlo => "mc-",
            };
            assert!(estimator.name().starts_with(prefix), "{estimator}");
        }
    }
}
