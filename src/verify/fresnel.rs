//! How far an approximate Fresnel term is from the exact one.

use super::search::{graded, largest};
use super::{Outcome, Place, Statistic, Test};
use crate::fresnel::Fresnel;
use crate::geometry::Polar;

/// A difference that no table resolves.
const SAME: f64 = 1e-9;

/// The largest difference over all facet angles.
pub(super) fn compare(approximate: Fresnel, exact: Fresnel) -> Outcome {
    let difference = |cos: f64| {
        let theta = Polar::from_cos(cos);
        let difference = approximate.reflectance_at(theta) - exact.reflectance_at(theta);
        difference.abs().max_element()
    };
    let top = largest(&graded(1e-9, 6, 48), &[0.0], |cos, _| difference(cos));
    Outcome::certain(
        Test::Fresnel,
        Statistic::new("max |F - exact F|", top.value),
        top.value <= SAME,
    )
    .at(Place::Direction([top.mu.acos().to_degrees(), 0.0]))
}
