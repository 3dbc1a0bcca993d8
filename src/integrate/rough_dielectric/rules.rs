//! Rules over the slopes: Gauss-Legendre at fixed orders where they converge, nested adaptive ones elsewhere.
//!
//! The parts of a row and the pieces of the rows are smooth up to their ends, so that Gauss-Legendre rules converge
//! geometrically, and the last two coefficients of the Legendre polynomials that a rule resolves bound what it leaves: that is
//! made of the coefficients from twice the order on, about the square of the last ones. Orders grow until
//! the bound is met; where features hide in the corners of the domain that no order reaches, the adaptive rules take over.

use super::super::smith_hd::{inner_order, legendre};
use super::view::{MOST_PARTS, Row, View};
use crate::numerics::quadrature::{Bounded, Integral, NotConverged, Piece, integrate};
use glam::DVec3;

/// Ratio of the stated error to the last coefficients, as in [`super::super::smith_hd`] for unknown Fresnel terms.
const SAFETY: f64 = 3.0;

/// The bound of what a rule leaves whose last coefficients are `left`.
///
/// A power of them between the first and the square would save a fifth of the nodes, and states too small an error for one
/// integral in a thousand: where a layer is not quite resolved, convergence is slower than geometric.
fn bound(left: f64) -> f64 {
    SAFETY * left
}

/// Rounding of some thousand terms that add up to 1.
const ROUNDING: f64 = 2e-14;

/// Largest orders before the adaptive rules take over.
const MOST_OUTER: usize = 64;
const MOST_INNER: usize = 64;

/// Share of the tolerance for what is cut off in the tail.
pub(super) const TAIL_SHARE: f64 = 0.05;

/// int of the view over all slopes, with an absolute error of at most `tolerance`, of which the tail has had its share.
pub(super) fn over_slopes(view: &View, tolerance: f64) -> Result<Integral, NotConverged> {
    let allowed = (1.0 - TAIL_SHARE) * tolerance - ROUNDING;
    let mut spent = 0;
    let found = match fixed(view, allowed, &mut spent) {
        Some(found) => found,
        None => adaptive(view, allowed.max(0.1 * tolerance))?,
    };
    let bounded = Bounded {
        value: found.bounded.value,
        error: found.bounded.error + DVec3::splat(TAIL_SHARE * tolerance + ROUNDING),
    };
    Ok(Integral {
        bounded,
        evaluations: found.evaluations + spent,
    })
}

/// A piece of w in x of [0, 1]: w, and dw/dx; quadratic at ends with roots.
fn along(x: f64, (from, kink_from): (f64, bool), (to, kink_to): (f64, bool)) -> (f64, f64) {
    let length = to - from;
    let (share, slope) = match (kink_from, kink_to) {
        (false, false) => (x, 1.0),
        (true, false) => (x * x, 2.0 * x),
        (false, true) => (x * (2.0 - x), 2.0 * (1.0 - x)),
        (true, true) => (x * x * (3.0 - 2.0 * x), 6.0 * x * (1.0 - x)),
    };
    (from + length * share, length * slope)
}

/// The order for a part of the given length, of the order for one of typical length.
fn order_of(order: usize, length: f64) -> usize {
    inner_order((order as f64 * (0.4 + 0.2 * length.min(6.0))) as usize).clamp(LEAST_INNER, MOST_INNER)
}

const LEAST_INNER: usize = 4;

/// Room for the nodes of a row and their du/dy, which all rows of an integral share: to clear it takes as long as many a row.
struct Scratch {
    nodes: [f64; MOST_PARTS * MOST_INNER],
    slopes: [f64; MOST_PARTS * MOST_INNER],
}

/// Sums over a row, and the last coefficients of its parts.
fn over_row(view: &View, row: &Row, order: usize, scratch: &mut Scratch, spent: &mut u64) -> (f64, f64) {
    let Scratch { nodes, slopes } = scratch;
    let mut count = 0;
    for part in row.parts() {
        let length = part.to - part.from;
        let rule = legendre(order_of(order, length));
        for node in &rule.nodes {
            (nodes[count], slopes[count]) = part.at(part.from + length * node);
            count += 1;
        }
    }
    view.values(row, &mut nodes[..count]);
    *spent += count as u64;
    let (mut sum, mut left, mut start) = (0.0, 0.0, 0);
    for part in row.parts() {
        let length = part.to - part.from;
        let rule = legendre(order_of(order, length));
        let (mut whole, mut last, mut second) = (0.0, 0.0, 0.0);
        for (i, weight) in rule.weights.iter().enumerate() {
            let value = nodes[start + i] * slopes[start + i];
            whole += weight * value;
            last += rule.last[0][i] * value;
            second += rule.last[1][i] * value;
        }
        start += rule.weights.len();
        sum += whole * length;
        left += f64::max(last.abs(), second.abs()) * length;
    }
    (sum, left)
}

/// Both rules at orders that grow; `None` where they do not get there.
fn fixed(view: &View, allowed: f64, spent: &mut u64) -> Option<Integral> {
    if allowed <= 0.0 {
        return None;
    }
    let ends = view.outer();
    let digits = -libm::log10(allowed).min(-1.0);
    let (mut outer, mut inner) = (first_order(2.6 * digits), first_order(2.3 * digits));
    let mut scratch = Scratch {
        nodes: [0.0; MOST_PARTS * MOST_INNER],
        slopes: [0.0; MOST_PARTS * MOST_INNER],
    };
    loop {
        let rule = legendre(outer);
        let (mut sum, mut left_outer, mut left_inner) = (0.0, 0.0, 0.0);
        for piece in ends.windows(2) {
            let (mut last, mut second) = (0.0, 0.0);
            for (i, x) in rule.nodes.iter().enumerate() {
                let (w, slope) = along(*x, piece[0], piece[1]);
                let row = view.row(w, allowed);
                let (value, left) = over_row(view, &row, inner, &mut scratch, spent);
                // both signs of q
                let slope = 2.0 * slope;
                sum += rule.weights[i] * slope * value;
                left_inner += rule.weights[i] * slope * left;
                last += rule.last[0][i] * slope * value;
                second += rule.last[1][i] * slope * value;
            }
            left_outer += f64::max(last.abs(), second.abs());
        }
        let (error_outer, error_inner) = (bound(left_outer), bound(left_inner));
        let error = error_outer + error_inner;
        if error <= allowed {
            return Some(Integral {
                bounded: Bounded {
                    value: DVec3::splat(sum),
                    error: DVec3::splat(error),
                },
                evaluations: 0,
            });
        }
        let most = error_outer.max(error_inner).min(0.5 * allowed);
        for (left, order, limit) in [
            (error_outer, &mut outer, MOST_OUTER),
            (error_inner, &mut inner, MOST_INNER),
        ] {
            if left >= most {
                if *order >= limit || !left.is_finite() {
                    return None;
                }
                // by the digits that are missing, at the rate of those that are there
                *order = inner_order((1.35 * *order as f64) as usize + 1).min(limit);
            }
        }
    }
}

fn first_order(order: f64) -> usize {
    inner_order((order as usize).clamp(8, 24))
}

/// Most nodes along either variable.
const NODE_LIMIT: u64 = 20_000;

/// Nested adaptive rules.
pub(super) fn adaptive(view: &View, allowed: f64) -> Result<Integral, NotConverged> {
    let ends = view.outer();
    let pieces: Vec<Piece> = ends
        .windows(2)
        .filter(|w| w[1].0 > w[0].0)
        .map(|w| Piece::kinked(w[0].0, w[1].0, w[0].1, w[1].1).careful())
        .collect();
    let length = ends.last().map_or(1.0, |end| end.0);
    let mut evaluations = 0;
    let mut failure = None;
    let whole = integrate(&pieces, 0.3 * allowed, NODE_LIMIT, |w| {
        let row = view.row(w, 0.1 * allowed);
        let mut sum = Bounded::exact(DVec3::ZERO);
        for part in row.parts() {
            let piece = [Piece::smooth(part.from, part.to).careful()];
            let share = 0.3 * allowed / (length * row.count as f64);
            match integrate(&piece, share, NODE_LIMIT, |y| {
                Bounded::exact(view.splatted(&row, part, y))
            }) {
                Ok(found) => {
                    evaluations += found.evaluations;
                    sum.value += found.bounded.value;
                    sum.error += found.bounded.error;
                }
                Err(error) => {
                    failure.get_or_insert(error);
                    sum = Bounded::exact(DVec3::NAN);
                }
            }
        }
        sum.scaled(2.0)
    });
    match (failure, whole) {
        (Some(error), _) | (None, Err(error)) => Err(error),
        (None, Ok(found)) => Ok(Integral { evaluations, ..found }),
    }
}
