//! Integrals that are sums of many small smooth parts, each times a weight of its own.
//!
//! The adaptive rules of [`crate::numerics::quadrature`] keep every node of every panel, to raise orders without evaluating
//! anything twice. Here there are tens of thousands of parts that three nodes settle: what is kept of a part is its value
//! and its bound.

use crate::numerics::patterson::{ABSCISSAE, NODES_OF_LEVEL, WEIGHTS};
use crate::numerics::quadrature::{Bounded, Integral, NotConverged};
use glam::DVec3;

/// A part of an integral: the region `place`, over which something geometric is integrated, and the weight of the result.
#[derive(Debug, Clone, Copy)]
pub(super) struct Part<P> {
    pub(super) place: P,
    pub(super) weight: DVec3,
}

/// Where a part is, and how it is integrated.
pub(super) trait Place: Copy + Sized {
    /// Its halves or quarters.
    fn split(self) -> impl IntoIterator<Item = Self>;
}

/// The integral of a place under a rule.
#[derive(Debug, Clone, Copy)]
pub(super) struct Ruled {
    pub(super) value: f64,
    /// Distance to the next coarser rule, which is the error of that one.
    pub(super) difference: f64,
    pub(super) evaluations: u64,
}

/// A part under a rule.
struct Panel<P> {
    part: Part<P>,
    level: usize,
    value: f64,
    /// Bound of the error, of the channel in which it is largest.
    bound: f64,
    /// Bound of the error of `value`.
    difference: f64,
}

/// Finest rule before a place is split.
const LAST_LEVEL: usize = 2;

/// Relative rounding error of a part: the sides of narrow cells know where they are to some 1e-14 only.
const ROUNDING: f64 = 1e-13;

/// The sum over all `parts` of weight times integral, until the stated error is at most `tolerance` in every channel.
///
/// `rule` integrates a place by the rule of a level; its difference to the one before is the stated error. In rounds the parts with the largest bounds move to the next rule, so many that those
/// of the others add up to half of the tolerance.
///
/// # Errors
/// [`NotConverged`] when `limit` evaluations do not suffice.
pub(super) fn integrate_parts<P: Place>(
    parts: impl IntoIterator<Item = Part<P>>,
    tolerance: f64,
    limit: u64,
    mut rule: impl FnMut(P, usize) -> Ruled,
) -> Result<Integral, NotConverged> {
    let mut evaluations = 0;
    let mut panel = |part: Part<P>, level: usize, evaluations: &mut u64| {
        let Ruled {
            value,
            difference,
            evaluations: spent,
        } = rule(part.place, level);
        *evaluations += spent;
        Panel {
            part,
            level,
            value,
            bound: difference * part.weight.abs().max_element(),
            difference,
        }
    };
    let mut panels: Vec<Panel<P>> = parts.into_iter().map(|part| panel(part, 0, &mut evaluations)).collect();
    loop {
        let mut value = DVec3::ZERO;
        let (mut open, mut size) = (DVec3::ZERO, DVec3::ZERO);
        for Panel {
            part,
            value: of_part,
            difference,
            ..
        } in &panels
        {
            value += part.weight * *of_part;
            open += part.weight.abs() * *difference;
            size += part.weight.abs() * of_part.abs();
        }
        let rounding = ROUNDING * size;
        let failure = |reached| NotConverged {
            reached,
            tolerance,
            evaluations,
        };
        if !(value.is_finite() && open.is_finite()) {
            return Err(failure(f64::INFINITY));
        }
        if open.cmple(DVec3::splat(tolerance).max(rounding)).all() {
            let error = open + rounding;
            return Ok(Integral {
                bounded: Bounded { value, error },
                evaluations,
            });
        }
        if evaluations >= limit {
            return Err(failure(open.max_element()));
        }
        // ascending and stable: the order, and with it every bit of the sum, depends on the parts alone
        panels.sort_by(|a, b| a.bound.total_cmp(&b.bound));
        let allowed = 0.5 * tolerance.max(rounding.min_element());
        let mut kept = 0.0;
        let first = panels.iter().position(|panel| {
            kept += panel.bound;
            kept > allowed
        });
        let Some(first) = first else {
            return Err(failure(open.max_element()));
        };
        for Panel { part, level, .. } in panels.split_off(first) {
            if level < LAST_LEVEL {
                panels.push(panel(part, level + 1, &mut evaluations));
            } else {
                for place in part.place.split() {
                    panels.push(panel(Part { place, ..part }, 1, &mut evaluations));
                }
            }
        }
    }
}

/// An interval under the rule of `level`, of 3, 7 or 15 nodes; the one before the first is the midpoint.
pub(super) fn interval(from: f64, to: f64, level: usize, mut f: impl FnMut(f64) -> f64) -> Ruled {
    let (centre, half) = (0.5 * (from + to), 0.5 * (to - from));
    let mut at = [0.0; NODES_OF_LEVEL[LAST_LEVEL].div_ceil(2)];
    let nodes = NODES_OF_LEVEL[level].div_ceil(2);
    at[0] = f(centre);
    for (at, x) in at[1..nodes].iter_mut().zip(&ABSCISSAE[1..]) {
        *at = f(centre - half * x) + f(centre + half * x);
    }
    let rule = |level: usize| -> f64 { WEIGHTS[level].iter().zip(at).map(|(weight, at)| weight * at).sum() };
    let fine = rule(level);
    let coarse = if level == 0 { 2.0 * at[0] } else { rule(level - 1) };
    Ruled {
        value: half * fine,
        difference: (half * (fine - coarse)).abs(),
        evaluations: NODES_OF_LEVEL[level] as u64,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[derive(Debug, Clone, Copy)]
    struct Line(f64, f64);

    impl Place for Line {
        fn split(self) -> impl IntoIterator<Item = Self> {
            let middle = 0.5 * (self.0 + self.1);
            [Self(self.0, middle), Self(middle, self.1)]
        }
    }

    /// int e^x, and int (x - 1/3)+^2 = 8/81 of weight -2, the kink of a cell that the horizon passes through.
    #[test]
    fn stated_errors_hold_at_every_tolerance() {
        let exact = 1f64.exp_m1() - 2.0 * (8.0 / 81.0);
        for exponent in 1..=12 {
            let tolerance = 10f64.powi(-exponent);
            let parts = [1.0, -2.0].map(|weight| Part {
                place: (weight > 0.0, Line(0.0, 1.0)),
                weight: DVec3::splat(weight),
            });
            let integral = integrate_parts(parts, tolerance, 100_000, |(smooth, line), level| {
                interval(line.0, line.1, level, |x| {
                    if smooth {
                        x.exp()
                    } else {
                        (x - 1.0 / 3.0).max(0.0).powi(2)
                    }
                })
            })
            .unwrap();
            let Bounded { value, error } = integral.bounded;
            assert!((value.x - exact).abs() <= error.x, "{exponent}: {integral:?}");
            assert!(error.x <= tolerance + 1e-12, "{exponent}: {integral:?}"); // and rounding
        }
    }

    impl Place for (bool, Line) {
        fn split(self) -> impl IntoIterator<Item = Self> {
            self.1.split().into_iter().map(move |line| (self.0, line))
        }
    }

    #[test]
    fn failure_says_how_far_it_got() {
        let part = Part {
            place: Line(0.0, 1.0),
            weight: DVec3::ONE,
        };
        let error = integrate_parts([part], 1e-9, 10_000, |line, level| {
            interval(line.0, line.1, level, |x| (1e4 * x).sin().abs())
        })
        .unwrap_err();
        assert!(
            error.reached > 1e-9 && error.reached < 1.0 && error.evaluations >= 10_000,
            "{error:?}"
        );
        let endless = integrate_parts([part], 1e-9, 10_000, |line, level| {
            interval(line.0, line.1, level, |x| 1.0 / (x - x))
        });
        assert_eq!(endless.unwrap_err().reached, f64::INFINITY);
        let none = integrate_parts([] as [Part<Line>; 0], 1e-9, 1, |_, _| unreachable!()).unwrap();
        assert_eq!(none.bounded, Bounded::exact(DVec3::ZERO));
    }
}
