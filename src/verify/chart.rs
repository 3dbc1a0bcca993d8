//! Coordinates of a hemisphere in which lobes of any width are wide, and adaptive integration over rectangles in them.

use crate::numerics::patterson::{ABSCISSAE, WEIGHTS};
use glam::DVec3;
use std::cell::Cell;
use std::f64::consts::{FRAC_PI_2, PI, TAU};
use std::sync::LazyLock;

/// Graded polar coordinates x = asinh((theta - theta_0)/a), y = asinh((phi - phi_0)/b) of one hemisphere.
///
/// Far from the centre they grow with the logarithm of the distance, so that a lobe of 1e-6 radians and the hemisphere
/// around it are both a few units wide. The horizon, where densities end, is a coordinate line whichever axis theta is
/// measured from: anisotropic lobes are ridges of constant angle to a tangent.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Chart {
    /// Whether it is the hemisphere below the surface.
    pub(super) below: bool,
    /// The axis that theta is measured from.
    pub(super) axis: Axis,
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

/// An axis of polar coordinates.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Axis {
    /// The first tangent; phi is measured from the normal to the second, in [-pi/2, pi/2].
    X,
    /// The second tangent, and phi from the normal to the first.
    Y,
    /// The normal, on the side of the hemisphere.
    Z,
}

impl Axis {
    /// theta and phi of a direction, either of its hemispheres taken for the upper one.
    fn polar(self, w: DVec3) -> [f64; 2] {
        let up = w.z.abs();
        match self {
            Self::X => [w.y.hypot(up).atan2(w.x), w.y.atan2(up)],
            Self::Y => [w.x.hypot(up).atan2(w.y), w.x.atan2(up)],
            Self::Z => [w.x.hypot(w.y).atan2(up), w.y.atan2(w.x)],
        }
    }

    /// The direction of the upper hemisphere with those angles.
    fn direction(self, [theta, phi]: [f64; 2]) -> DVec3 {
        let (sin, cos) = theta.sin_cos();
        let (up, aside) = (sin * phi.cos(), sin * phi.sin());
        match self {
            Self::X => DVec3::new(cos, aside, up),
            Self::Y => DVec3::new(aside, cos, up),
            Self::Z => DVec3::new(up, aside, cos),
        }
    }

    /// Ranges of theta and of phi about `centre`.
    fn ranges(self, centre: [f64; 2]) -> [[f64; 2]; 2] {
        match self {
            Self::X | Self::Y => [[0.0, PI], [-FRAC_PI_2, FRAC_PI_2]],
            Self::Z => [[0.0, FRAC_PI_2], [centre[1] - PI, centre[1] + PI]],
        }
    }

    /// Centre and scale of the narrowest interval of theta with a twentieth of the directions, and of phi with half of those.
    fn narrowest(self, drawn: &[DVec3]) -> ([f64; 2], [f64; 2]) {
        let mut polar: Vec<[f64; 2]> = drawn.iter().map(|w| self.polar(*w)).collect();
        polar.sort_by(|a, b| a[0].total_cmp(&b[0]));
        let thetas: Vec<f64> = polar.iter().map(|[theta, _]| *theta).collect();
        let count = (polar.len() / 20).max(2);
        let start = narrowest(&thetas, count);
        let band = &polar[start..start + count];
        let mut phis: Vec<f64> = band.iter().map(|[_, phi]| *phi).collect();
        phis.sort_by(f64::total_cmp);
        let half = (count / 2).max(2);
        if self == Self::Z {
            // once more around the circle, so that no interval is cut
            let again: Vec<f64> = phis[..half].iter().map(|phi| phi + TAU).collect();
            phis.extend(again);
        }
        let first = narrowest(&phis, half);
        let ends = [[band[0][0], band[count - 1][0]], [phis[first], phis[first + half - 1]]];
        (
            ends.map(|[from, to]| 0.5 * (from + to)),
            ends.map(|[from, to]| (to - from).max(NARROWEST)),
        )
    }
}

impl Chart {
    /// The chart of a lobe that is known only from directions drawn from it.
    ///
    /// Theta is measured from the normal, unless the lobe is a ridge that is much narrower seen from a tangent.
    pub(super) fn around(below: bool, drawn: &[DVec3]) -> Self {
        if drawn.len() < FEWEST {
            return Self {
                below,
                axis: Axis::Z,
                centre: [0.0, 0.0],
                scale: [1.0, PI],
            };
        }
        let [mut chosen, x, y] = [Axis::Z, Axis::X, Axis::Y].map(|axis| {
            let (centre, scale) = axis.narrowest(drawn);
            Self {
                below,
                axis,
                centre,
                scale,
            }
        });
        for other in [x, y] {
            let handicap = if chosen.axis == Axis::Z { RIDGE } else { 1.0 };
            if other.scale[0] < handicap * chosen.scale[0] {
                chosen = other;
            }
        }
        chosen
    }

    /// Coordinates of a direction of this hemisphere.
    pub(super) fn at(&self, w: DVec3) -> [f64; 2] {
        let [theta, phi] = self.axis.polar(w);
        let turned = phi - self.centre[1];
        let turned = match self.axis {
            Axis::Z => turned - TAU * (turned / TAU).round(),
            Axis::X | Axis::Y => turned,
        };
        [
            ((theta - self.centre[0]) / self.scale[0]).asinh(),
            (turned / self.scale[1]).asinh(),
        ]
    }

    /// theta and phi at coordinates.
    pub(super) fn angles(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        let ranges = self.axis.ranges(self.centre);
        let theta = self.centre[0] + self.scale[0] * x.sinh();
        let phi = self.centre[1] + self.scale[1] * y.sinh();
        [
            theta.clamp(ranges[0][0], ranges[0][1]),
            phi.clamp(ranges[1][0], ranges[1][1]),
        ]
    }

    /// The direction at coordinates, and the solid angle per unit of both: sin theta dtheta/dx dphi/dy.
    pub(super) fn direction(&self, [x, y]: [f64; 2]) -> (DVec3, f64) {
        let [a, b] = self.scale;
        let angles = self.angles([x, y]);
        let mut w = self.axis.direction(angles);
        // rounding of the right angle is no direction below the horizon
        w.z = w.z.max(0.0);
        if self.below {
            w.z = -w.z;
        }
        (w, angles[0].sin() * (a * x.cosh()) * (b * y.cosh()))
    }

    /// The whole hemisphere.
    pub(super) fn domain(&self) -> Rectangle {
        let ranges = self.axis.ranges(self.centre);
        let corner =
            |end: usize| [0, 1].map(|axis: usize| ((ranges[axis][end] - self.centre[axis]) / self.scale[axis]).asinh());
        Rectangle {
            low: corner(0),
            high: corner(1),
        }
    }

    /// int density dw over a rectangle, to about `tolerance`, in at most `most` parts.
    ///
    /// `drawn` are directions in it, each of which stands for `share` of all that are drawn: where the density is high at
    /// some of them and the rule sees next to nothing, their share is missing, and counts as error until it is found.
    pub(super) fn integrate(
        &self,
        over: Rectangle,
        (drawn, share): (&[DVec3], f64),
        tolerance: impl Fn(f64) -> f64,
        most: usize,
        density: impl Fn(DVec3) -> f64,
    ) -> Mass {
        let integrand = |at: [f64; 2]| {
            let (w, area) = self.direction(at);
            area * density(w)
        };
        let evaluations = Cell::new(0);
        let panel = |over: Rectangle, drawn: Vec<Drawn>, other: usize| {
            evaluations.set(evaluations.get() + NODES * NODES);
            Panel::new(over, drawn, share, other, &integrand)
        };
        let drawn = drawn.iter().map(|w| {
            let at = self.at(*w);
            let (_, area) = self.direction(at);
            Drawn {
                at,
                f: area * density(*w),
            }
        });
        let mut panels = vec![panel(over, drawn.collect(), 0)];
        loop {
            let value: f64 = panels.iter().map(|panel| panel.value).sum();
            let error: f64 = panels.iter().map(|panel| panel.error.max(panel.missed)).sum();
            if error <= tolerance(value) || panels.len() >= most || !value.is_finite() {
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
                let (below, above) = old.drawn.into_iter().partition(|drawn| drawn.at[axis] < low.high[axis]);
                refined.push(panel(low, below, 1 - axis));
                refined.push(panel(high, above, 1 - axis));
            }
            panels = refined;
        }
    }
}

/// A direction that was drawn, by its coordinates, with the integrand there.
#[derive(Clone, Copy)]
struct Drawn {
    at: [f64; 2],
    f: f64,
}

/// Directions below which nothing is known of a lobe.
const FEWEST: usize = 40;

/// How much narrower a lobe has to be from a tangent than from the normal.
const RIDGE: f64 = 0.1;

/// Start of the narrowest run of `count` of the `sorted` values.
fn narrowest(sorted: &[f64], count: usize) -> usize {
    let width = |start: usize| sorted[start + count - 1] - sorted[start];
    (0..=sorted.len() - count)
        .min_by(|a, b| width(*a).total_cmp(&width(*b)))
        .unwrap_or(0)
}

/// Angles closer than this are one: their rounding is as large.
const NARROWEST: f64 = 1e-15;

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

/// A mean density in a panel, over the mean at the directions drawn in it, below which the rules miss what was drawn. Within
/// a steep flank of a lobe both differ too; halving that is harmless.
const UNSEEN: f64 = 0.05;

/// Nodes along one axis of a panel.
const NODES: usize = 7;

/// Part of a rectangle under the product of two rules of seven nodes.
struct Panel {
    over: Rectangle,
    drawn: Vec<Drawn>,
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
    fn new(over: Rectangle, drawn: Vec<Drawn>, share: f64, other: usize, integrand: &impl Fn([f64; 2]) -> f64) -> Self {
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
        let count = drawn.len() as f64;
        let seen = 4.0 * area * drawn.iter().map(|drawn| drawn.f).sum::<f64>();
        let missed = if value < UNSEEN * seen / count {
            count * share
        } else {
            0.0
        };
        let hidden = AT_ENDS * area * stray;
        let axis = if hidden.max(missed) > along_x + along_y {
            other
        } else {
            usize::from(along_y > along_x)
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
    use crate::geometry::Polar;

    #[test]
    fn directions_and_coordinates_are_inverse() {
        for axis in [Axis::X, Axis::Y, Axis::Z] {
            let chart = Chart {
                below: true,
                axis,
                centre: [1e-4, 1.0],
                scale: [1e-7, 0.2],
            };
            for (theta, phi) in [(1e-9, 0.3), (1.0001e-4, -3.0), (1.5, 2.9)] {
                let w = -Polar::from_angle(theta).direction(phi);
                let back = chart.direction(chart.at(w)).0;
                assert!((back - w).length() < 1e-14, "{axis:?} {theta}"); // some roundings of angles near pi
            }
            let Rectangle { low, high } = chart.domain();
            assert!(chart.direction(low).0.z <= 0.0 && chart.direction(high).0.z <= 0.0);
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
            let mass = chart.integrate(chart.domain(), (&drawn, 1.0 / 4000.0), |_| 1e-6, 4000, density);
            assert!(mass.error <= 1e-6, "{width}: {mass:?}");
            if width < 0.1 {
                // the plane bends away by the squared width
                assert!((mass.value - 1.0).abs() < 1e-6 + width * width, "{width}: {mass:?}");
            }
        }
    }
}
