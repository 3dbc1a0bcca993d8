//! Nodes and weights of both rules, with what reads their errors off.

use super::kernel::LANES;
use crate::numerics::lanes::sin_cos_turns;
use std::sync::OnceLock;

/// Largest order of the Gauss-Legendre rules.
pub(super) const MOST_INNER: usize = 256;

/// The next Gauss-Legendre order of those in use: even numbers to 32, then eight for every factor of 2, so that few rules
/// are ever made.
pub(in crate::integrate) fn inner_order(least: usize) -> usize {
    let step = match least {
        0..=32 => 2,
        33..=64 => 4,
        65..=128 => 8,
        _ => 16,
    };
    least.next_multiple_of(step)
}

/// Step and largest order of the trapezoidal rules; even, for their halves.
pub(super) const OUTER_STEP: usize = 2;
pub(super) const MOST_OUTER: usize = 128;

/// A Gauss-Legendre rule on [0, 1].
pub(in crate::integrate) struct Legendre {
    pub(in crate::integrate) nodes: Vec<f64>,
    pub(in crate::integrate) weights: Vec<f64>,
    /// sqrt(2 k + 1) w P_k(node) for k = n - 1 and n - 2: the last coefficients that the rule resolves.
    pub(in crate::integrate) last: [Vec<f64>; 2],
}

/// The rule of `n` nodes, an even number up to [`MOST_INNER`].
pub(in crate::integrate) fn legendre(n: usize) -> &'static Legendre {
    static RULES: [OnceLock<Legendre>; MOST_INNER / 2] = [const { OnceLock::new() }; MOST_INNER / 2];
    RULES[n / 2 - 1].get_or_init(|| Legendre::new(n))
}

impl Legendre {
    /// Newton's method from Tricomi's cos(pi (i - 1/4)/(n + 1/2)); w = 2/((1 - x^2) P_n'(x)^2) [Abramowitz and Stegun 1964,
    /// 25.4.29].
    fn new(n: usize) -> Self {
        let mut rule = Self {
            nodes: vec![0.0; n],
            weights: vec![0.0; n],
            last: [vec![0.0; n], vec![0.0; n]],
        };
        let order = n as f64;
        for i in 0..n {
            // the roots come in pairs of opposite sign
            let upper = i.min(n - 1 - i);
            let (_, mut x) = sin_cos_turns(0.5 * (upper as f64 + 0.75) / (order + 0.5));
            let mut slope = 1.0;
            for _ in 0..5 {
                let [p, before, _] = polynomials(n, x);
                slope = order * (before - x * p) / ((1.0 - x) * (1.0 + x));
                x -= p / slope;
            }
            let sign = if i == upper { 1.0 } else { -1.0 };
            let [_, before, second] = polynomials(n, sign * x);
            // half of it, as the interval is half as long
            let weight = 1.0 / ((1.0 - x) * (1.0 + x) * slope * slope);
            rule.nodes[i] = 0.5 * (1.0 - sign * x);
            rule.weights[i] = weight;
            rule.last[0][i] = (2.0 * order - 1.0).sqrt() * weight * before;
            rule.last[1][i] = (2.0 * order - 3.0).sqrt() * weight * second;
        }
        rule
    }
}

/// P_n, P_(n-1) and P_(n-2) at `x`.
fn polynomials(n: usize, x: f64) -> [f64; 3] {
    let (mut p, mut before, mut second) = (x, 1.0, 0.0);
    for k in 1..n {
        let k = k as f64;
        let next = ((2.0 * k + 1.0) * x * p - k * before) / (k + 1.0);
        (p, before, second) = (next, p, before);
    }
    [p, before, second]
}

/// A trapezoidal rule of `N` intervals on psi in [0, pi], for functions that are even and periodic.
pub(super) struct Circle {
    /// sin^2(psi/2) and cos^2(psi/2), up to whole vectors.
    pub(super) sin2: Vec<f64>,
    pub(super) cos2: Vec<f64>,
    /// 1/N, and half of that at both ends.
    pub(super) weights: Vec<f64>,
    /// Weights of the coefficients N and N - 1: (-1)^j and 2 (-1)^j cos psi_j, times those above.
    pub(super) last: [Vec<f64>; 2],
}

/// The rule of `intervals` intervals, a multiple of [`OUTER_STEP`] up to [`MOST_OUTER`].
pub(super) fn circle(intervals: usize) -> &'static Circle {
    static RULES: [OnceLock<Circle>; MOST_OUTER / OUTER_STEP] = [const { OnceLock::new() }; MOST_OUTER / OUTER_STEP];
    RULES[intervals / OUTER_STEP - 1].get_or_init(|| Circle::new(intervals))
}

impl Circle {
    fn new(intervals: usize) -> Self {
        let count = intervals as f64;
        let mut rule = Self {
            sin2: Vec::new(),
            cos2: Vec::new(),
            weights: Vec::new(),
            last: [Vec::new(), Vec::new()],
        };
        for j in 0..(intervals + 1).next_multiple_of(LANES) {
            let (sin, cos) = sin_cos_turns(0.25 * j as f64 / count);
            rule.sin2.push(sin * sin);
            rule.cos2.push(cos * cos);
            if j > intervals {
                continue;
            }
            let weight = if j == 0 || j == intervals { 0.5 } else { 1.0 } / count;
            let sign = if j % 2 == 0 { 1.0 } else { -1.0 };
            rule.weights.push(weight);
            rule.last[0].push(sign * weight);
            rule.last[1].push(2.0 * sign * (cos - sin) * (cos + sin) * weight);
        }
        rule
    }
}
