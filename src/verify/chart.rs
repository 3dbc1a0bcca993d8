//! Coordinates of a hemisphere in which lobes of any width are wide, and adaptive integration over rectangles in them.

use crate::geometry::Polar;
use crate::numerics::patterson::{ABSCISSAE, WEIGHTS};
use glam::DVec3;
use std::cell::Cell;
use std::f64::consts::{FRAC_PI_2, PI, TAU};
use std::sync::LazyLock;

/// Graded polar coordinates x = asinh((theta - theta_0)/a), y = asinh((phi - phi_0)/b) of one hemisphere.
///
/// Far from the centre they grow with the logarithm of the distance, so that a lobe of 1e-6 radians and the hemisphere
/// around it are both a few units wide. The horizon, where densities end, is a coordinate line.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Chart {
    /// Whether it is the hemisphere below the surface; theta is measured from its own pole.
    pub(super) below: bool,
    /// theta_0 and phi_0.
    pub(super) centre: [f64; 2],
    /// a and b.
    pub(super) scale: [f64; 2],
}

/// A rectangle of coordinates.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Rectangle {
    pub(super) low: [f64; 2],
    pub(super) high: [f64; 2],
}

impl Chart {
    /// The chart of a lobe that is known only from directions drawn from it: centre and scale are those of the narrowest
    /// interval of theta with a twentieth of them, and of phi with half of those.
    pub(super) fn around(below: bool, drawn: &[DVec3]) -> Self {
        let mut polar: Vec<[f64; 2]> = drawn.iter().map(|w| Self::polar(*w)).collect();
        if polar.len() < 40 {
            return Self {
                below,
                centre: [0.0, 0.0],
                scale: [1.0, PI],
            };
        }
        polar.sort_by(|a, b| a[0].total_cmp(&b[0]));
        let thetas: Vec<f64> = polar.iter().map(|[theta, _]| *theta).collect();
        let start = narrowest(&thetas, polar.len() / 20);
        let band = &polar[start..start + polar.len() / 20];
        let mut phis: Vec<f64> = band.iter().map(|[_, phi]| *phi).collect();
        phis.sort_by(f64::total_cmp);
        // once more around the circle, so that no interval is cut
        let around: Vec<f64> = phis.iter().copied().chain(phis.iter().map(|phi| phi + TAU)).collect();
        let half = phis.len() / 2;
        let first = narrowest(&around[..phis.len() + half], half);
        let middle = |from: f64, to: f64| [0.5 * (from + to), (to - from).max(NARROWEST)];
        let [theta, a] = middle(band[0][0], band[band.len() - 1][0]);
        let [phi, b] = middle(around[first], around[first + half - 1]);
        Self {
            below,
            centre: [theta, phi],
            scale: [a, b],
        }
    }

    /// theta from the nearer pole and phi of a direction.
    fn polar(w: DVec3) -> [f64; 2] {
        [w.x.hypot(w.y).atan2(w.z.abs()), w.y.atan2(w.x)]
    }

    /// Coordinates of a direction of this hemisphere.
    pub(super) fn at(&self, w: DVec3) -> [f64; 2] {
        let [theta, phi] = Self::polar(w);
        let turned = phi - self.centre[1];
        let turned = turned - TAU * (turned / TAU).round();
        [
            ((theta - self.centre[0]) / self.scale[0]).asinh(),
            (turned / self.scale[1]).asinh(),
        ]
    }

    /// theta from the nearer pole, and phi, at coordinates.
    pub(super) fn angles(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        let theta = (self.centre[0] + self.scale[0] * x.sinh()).clamp(0.0, FRAC_PI_2);
        [theta, self.centre[1] + self.scale[1] * y.sinh()]
    }

    /// The direction at coordinates, and the solid angle per unit of both: sin theta dtheta/dx dphi/dy.
    pub(super) fn direction(&self, [x, y]: [f64; 2]) -> (DVec3, f64) {
        let [a, b] = self.scale;
        let [theta, phi] = self.angles([x, y]);
        let polar = Polar::from_angle(theta);
        let mut w = polar.direction(phi);
        if self.below {
            w.z = -w.z;
        }
        (w, polar.sin * (a * x.cosh()) * (b * y.cosh()))
    }

    /// The whole hemisphere.
    pub(super) fn domain(&self) -> Rectangle {
        let [a, b] = self.scale;
        let y = (PI / b).asinh();
        Rectangle {
            low: [(-self.centre[0] / a).asinh(), -y],
            high: [((FRAC_PI_2 - self.centre[0]) / a).asinh(), y],
        }
    }

    /// int density dw over a rectangle, to about `tolerance`.
    ///
    /// `drawn` are the coordinates of directions in it, each of which stands for `share` of all that are drawn: a part that
    /// holds some of them, and in which the rule sees next to nothing, is halved whatever the rule says.
    pub(super) fn integrate(
        &self,
        over: Rectangle,
        (drawn, share): (&[[f64; 2]], f64),
        tolerance: impl Fn(f64) -> f64,
        density: impl Fn(DVec3) -> f64,
    ) -> Mass {
        let integrand = |at: [f64; 2]| {
            let (w, area) = self.direction(at);
            area * density(w)
        };
        let evaluations = Cell::new(0);
        let panel = |over: Rectangle, drawn: Vec<[f64; 2]>, other: usize| {
            evaluations.set(evaluations.get() + NODES * NODES);
            Panel::new(over, drawn, share, other, &integrand)
        };
        let mut panels = vec![panel(over, drawn.to_vec(), 0)];
        loop {
            let value: f64 = panels.iter().map(|panel| panel.value).sum();
            let error: f64 = panels.iter().map(|panel| panel.error.max(panel.missed)).sum();
            if error <= tolerance(value) || panels.len() >= MOST_PANELS || !value.is_finite() {
                return Mass {
                    value,
                    error,
                    evaluations: evaluations.get() as u64,
                };
            }
            let worst = panels
                .iter()
                .map(|panel| panel.error.max(panel.missed))
                .fold(0.0, f64::max);
            let mut refined = Vec::with_capacity(panels.len() + 8);
            for old in panels {
                if old.error.max(old.missed) < 0.3 * worst {
                    refined.push(old);
                    continue;
                }
                let (axis, [low, high]) = (old.axis, old.over.halves(old.axis));
                let (below, above) = old.drawn.into_iter().partition(|at| at[axis] < low.high[axis]);
                refined.push(panel(low, below, 1 - axis));
                refined.push(panel(high, above, 1 - axis));
            }
            panels = refined;
        }
    }
}

/// Start of the narrowest run of `count` of the `sorted` values.
fn narrowest(sorted: &[f64], count: usize) -> usize {
    let width = |start: usize| sorted[start + count - 1] - sorted[start];
    (0..=sorted.len() - count)
        .min_by(|a, b| width(*a).total_cmp(&width(*b)))
        .unwrap_or(0)
}

/// Angles closer than this are one: their rounding is as large.
const NARROWEST: f64 = 1e-15;

/// Most parts of one rectangle; a density that is not known by then is far from smooth, and its error says so.
const MOST_PANELS: usize = 4000;

impl Rectangle {
    fn halves(self, axis: usize) -> [Self; 2] {
        self.cut(axis, 0.5 * (self.low[axis] + self.high[axis]))
    }

    /// Both parts on either side of `at` along `axis`.
    pub(super) fn cut(self, axis: usize, at: f64) -> [Self; 2] {
        let (mut low, mut high) = (self, self);
        low.high[axis] = at;
        high.low[axis] = at;
        [low, high]
    }
}

/// An integral of a density with a bound of its error.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Mass {
    pub(super) value: f64,
    pub(super) error: f64,
    pub(super) evaluations: u64,
}

impl Mass {
    pub(super) fn plus(self, other: Self) -> Self {
        Self {
            value: self.value + other.value,
            error: self.error + other.error,
            evaluations: self.evaluations + other.evaluations,
        }
    }
}

/// Nodes along one axis of a panel.
const NODES: usize = 7;

/// Part of a rectangle under the product of two rules of seven nodes.
struct Panel {
    over: Rectangle,
    drawn: Vec<[f64; 2]>,
    value: f64,
    /// The difference to the rules of three nodes along either axis, which are nested in those of seven, and what hides
    /// beyond the nodes.
    error: f64,
    /// What the directions drawn here say is missing.
    missed: f64,
    /// Along which the difference is larger.
    axis: usize,
}

impl Panel {
    /// `other` is the axis to halve along where the rules do not say.
    fn new(
        over: Rectangle,
        drawn: Vec<[f64; 2]>,
        share: f64,
        other: usize,
        integrand: &impl Fn([f64; 2]) -> f64,
    ) -> Self {
        let half = [0, 1].map(|axis| 0.5 * (over.high[axis] - over.low[axis]));
        let centre = [0, 1].map(|axis| 0.5 * (over.high[axis] + over.low[axis]));
        let at = |x: f64, y: f64| integrand([centre[0] + half[0] * x, centre[1] + half[1] * y]);
        let rule = &*RULE;
        let mut sums = [[0.0; 2]; 2];
        // the polynomial through all nodes, at the corners and in the middle of the edges
        let mut corners = [[0.0; 2]; 2];
        let mut edges = [[0.0; 2]; 2];
        for (i, a) in rule.iter().enumerate() {
            for (j, b) in rule.iter().enumerate() {
                let f = at(a.node, b.node);
                for (row, weight_x) in [a.fine, a.coarse].into_iter().enumerate() {
                    for (column, weight_y) in [b.fine, b.coarse].into_iter().enumerate() {
                        sums[row][column] += weight_x * weight_y * f;
                    }
                }
                for side_x in 0..2 {
                    for side_y in 0..2 {
                        corners[side_x][side_y] += a.at_ends[side_x] * b.at_ends[side_y] * f;
                    }
                    edges[0][side_x] += if j == 0 { a.at_ends[side_x] * f } else { 0.0 };
                    edges[1][side_x] += if i == 0 { b.at_ends[side_x] * f } else { 0.0 };
                }
            }
        }
        let strays = |expected: f64, x: f64, y: f64| {
            let found = at(x, y);
            if found.is_finite() {
                (found - expected).abs()
            } else {
                0.0
            }
        };
        let mut stray: f64 = 0.0;
        for (i, x) in [-1.0, 1.0].into_iter().enumerate() {
            for (j, y) in [-1.0, 1.0].into_iter().enumerate() {
                stray = stray.max(strays(corners[i][j], x, y));
            }
            stray = stray.max(strays(edges[0][i], x, 0.0)).max(strays(edges[1][i], 0.0, x));
        }
        let area = half[0] * half[1];
        let value = area * sums[0][0];
        let [along_x, along_y] = [sums[1][0], sums[0][1]].map(|sum| (area * sum - value).abs());
        let expected = drawn.len() as f64 * share;
        let missed = if drawn.len() >= 4 && value < 0.05 * expected {
            expected
        } else {
            0.0
        };
        let hidden = AT_ENDS * area * stray;
        // where the rules see nothing at all, the directions drawn say where to look
        let axis = if hidden > along_x + along_y {
            other
        } else if along_x + along_y > 0.0 || drawn.is_empty() {
            usize::from(along_y > along_x)
        } else {
            let spread = [0, 1].map(|axis| {
                let mean = drawn.iter().map(|at| at[axis]).sum::<f64>() / drawn.len() as f64;
                let deviation = drawn.iter().map(|at| (at[axis] - mean).abs()).sum::<f64>() / drawn.len() as f64;
                deviation / half[axis]
            });
            usize::from(spread[1] < spread[0])
        };
        Self {
            over,
            drawn,
            value,
            error: along_x + along_y + hidden,
            missed,
            axis,
        }
    }
}

/// A node of [Patterson 1968]'s rule of seven.
struct Node {
    node: f64,
    /// Its weight, and its weight in the nested rule of three.
    fine: f64,
    coarse: f64,
    /// Value at -1 and at 1 of the polynomial that is 1 at this node and 0 at the others.
    at_ends: [f64; 2],
}

/// All seven, the middle first.
static RULE: LazyLock<Vec<Node>> = LazyLock::new(|| {
    let mut rule: Vec<Node> = (0..4)
        .flat_map(|i| [(i, 1.0), (i, -1.0)])
        .filter(|(i, sign)| *i > 0 || *sign > 0.0)
        .map(|(i, sign)| Node {
            node: sign * ABSCISSAE[i],
            fine: WEIGHTS[1][i],
            coarse: WEIGHTS[0].get(i).copied().unwrap_or(0.0),
            at_ends: [0.0; 2],
        })
        .collect();
    let all: Vec<f64> = rule.iter().map(|node| node.node).collect();
    for (i, node) in rule.iter_mut().enumerate() {
        let others = all.iter().enumerate().filter(|(j, _)| *j != i);
        node.at_ends = [-1.0, 1.0].map(|x| {
            let factor = |(_, other): (usize, &f64)| (x - other) / (node.node - other);
            others.clone().map(factor).product()
        });
    }
    rule
});

/// Share of a panel that lies beyond its outermost nodes about a corner or an edge, where a feature may hide: what the
/// integrand strays there from the polynomial through the nodes counts by it.
const AT_ENDS: f64 = 0.01;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bxdf::cosine_hemisphere;

    #[test]
    fn directions_and_coordinates_are_inverse() {
        let chart = Chart {
            below: false,
            centre: [1e-4, 3.0],
            scale: [1e-7, 0.2],
        };
        for (theta, phi) in [(1e-9, 0.3), (1.0001e-4, -3.0), (1.5, 2.9)] {
            let w = Polar::from_angle(theta).direction(phi);
            let back = chart.direction(chart.at(w)).0;
            assert!((back - w).length() < 1e-14, "{theta}"); // some roundings of angles near pi
        }
    }

    /// Densities of all widths add up to one, whatever was drawn of them.
    #[test]
    fn masses_of_lobes_of_any_width_are_found() {
        for width in [1.0, 1e-3, 1e-6, 1e-9] {
            // a lobe about theta = 0.8 that is a normal distribution in the plane it touches, with a diffuse part
            let pole = Polar::from_angle(0.8).direction(2.0);
            let density = |w: DVec3| {
                let distance = (w - pole).length() / width;
                let peak = (-0.5 * distance * distance).exp() / (TAU * width * width);
                0.5 * w.z / PI + 0.5 * peak
            };
            let (s, t) = pole.any_orthonormal_pair();
            let drawn: Vec<DVec3> = (0..4000)
                .map(|i| {
                    let u = [0.618_033_988_75, 0.754_877_666_25].map(|x| (x * f64::from(i)).fract());
                    if i % 2 == 0 {
                        return cosine_hemisphere(u);
                    }
                    let radius = width * (-2.0 * (-u[0]).ln_1p()).sqrt();
                    (pole + radius * ((TAU * u[1]).cos() * s + (TAU * u[1]).sin() * t)).normalize()
                })
                .filter(|w| w.z > 0.0)
                .collect();
            let chart = Chart::around(false, &drawn);
            let coordinates: Vec<[f64; 2]> = drawn.iter().map(|w| chart.at(*w)).collect();
            let mass = chart.integrate(chart.domain(), (&coordinates, 1.0 / 4000.0), |_| 1e-6, density);
            assert!(mass.error <= 1e-6, "{width}: {mass:?}");
            if width < 0.1 {
                // the plane bends away by the squared width
                assert!((mass.value - 1.0).abs() < 1e-6 + width * width, "{width}: {mass:?}");
            }
        }
    }
}
