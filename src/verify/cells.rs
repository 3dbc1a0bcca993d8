//! The sphere of directions cut into cells that a sampler fills about equally, whatever the width of its lobes.
//!
//! A first set of draws builds a k-d tree by median splits in the [`Chart`] of each hemisphere; the density is integrated
//! over every cell, and other draws are counted. Cells of their own are each direction of a delta distribution and, all
//! together, the draws that belong to no direction.

use super::chart::{Axis, Chart, Mass, Rectangle};
use crate::bxdf::{Bxdf, BxdfSample, Flags};
use crate::estimate::Lobe;
use glam::DVec3;

/// Cells of one sampler, seen from one direction.
pub(super) struct Cells {
    sides: Vec<Side>,
    /// Directions of delta distributions.
    deltas: Vec<BxdfSample>,
    /// Number of cells of all sides.
    smooth: usize,
    /// Probability of each cell by the density, and how far that may be off; the last cell is that of lost draws.
    pub(super) expected: Vec<f64>,
    pub(super) slack: Vec<f64>,
    /// int pdf over all directions, with the probability of deltas.
    pub(super) total: Mass,
}

/// One hemisphere.
struct Side {
    chart: Chart,
    tree: Tree,
    /// Number of the first cell.
    first: usize,
}

enum Tree {
    Split {
        axis: usize,
        at: f64,
        children: Box<[Tree; 2]>,
    },
    Cell(usize),
}

/// A cell of one hemisphere with the draws that it was built from.
struct Leaf {
    over: Rectangle,
    drawn: Vec<([f64; 2], DVec3)>,
}

/// Distance below which two directions of a delta distribution are one: refraction near its edge loses half the digits.
const SAME: f64 = 1e-7;

/// Relative error to which cells are integrated; counts of some thousand do not see it.
const CELL_TOLERANCE: f64 = 2e-4;

/// Largest share of all draws that the error of one cell may be, for cells that hold next to nothing.
const LEAST_MASS: f64 = 2e-7;

/// Most panels of a cell. A ridge that follows no coordinate line may take more; the error of its cells then says so, and
/// the counts are judged by it.
const MOST_PANELS: usize = 600;

/// What a draw belongs to.
enum Kind {
    /// A direction with a density.
    Smooth,
    /// A direction of a delta distribution.
    Delta,
    /// Nothing.
    Lost,
}

/// Draws without density and flags, and draws to a side on which the model does not scatter, are lost.
fn kind(flags: Flags, wo: DVec3, draw: &BxdfSample) -> Kind {
    if draw.flags.contains(Flags::SPECULAR) {
        return Kind::Delta;
    }
    let side = Lobe::ALL.into_iter().find(|lobe| lobe.holds(wo, draw.wi));
    let scatters = side.is_some_and(|lobe| flags.contains(lobe.flag()));
    let nowhere = draw.flags.is_empty() && draw.pdf == 0.0;
    if scatters && !nowhere && draw.wi.is_finite() {
        Kind::Smooth
    } else {
        Kind::Lost
    }
}

impl Cells {
    /// Cells for directions seen from `wo`, about `cells` of them, from the draws `pilot`.
    pub(super) fn new(bxdf: &dyn Bxdf, wo: DVec3, pilot: &[BxdfSample], cells: usize) -> Self {
        let flags = bxdf.flags();
        let share = (pilot.len() as f64).recip();
        let each = (pilot.len() / cells).max(1);
        let mut all = Self {
            sides: Vec::new(),
            deltas: Vec::new(),
            smooth: 0,
            expected: Vec::new(),
            slack: Vec::new(),
            total: Mass::default(),
        };
        let smooth_part = flags.intersects(Flags::DIFFUSE | Flags::GLOSSY);
        for lobe in Lobe::ALL {
            if !(flags.contains(lobe.flag()) && smooth_part) {
                continue;
            }
            let below = (wo.z < 0.0) == (lobe == Lobe::Reflection);
            let drawn: Vec<DVec3> = pilot
                .iter()
                .filter(|draw| matches!(kind(flags, wo, draw), Kind::Smooth) && lobe.holds(wo, draw.wi))
                .map(|draw| draw.wi)
                .collect();
            let chart = Chart::around(below, &drawn);
            let mut leaves = Vec::new();
            let root = Leaf {
                over: chart.domain(),
                drawn: drawn.iter().map(|w| (chart.at(*w), *w)).collect(),
            };
            let tree = Tree::grow(root, each, 0, &mut leaves);
            all.sides.push(Side {
                chart,
                tree,
                first: all.smooth,
            });
            all.smooth += leaves.len();
            for leaf in leaves {
                let tolerance = |value: f64| (CELL_TOLERANCE * value).max(LEAST_MASS);
                let drawn: Vec<DVec3> = leaf.drawn.iter().map(|(_, w)| *w).collect();
                let density = |wi: DVec3| bxdf.pdf(wo, wi);
                let mass = chart.integrate(leaf.over, (&drawn, share), tolerance, MOST_PANELS, density);
                all.push(mass);
            }
        }
        for draw in pilot {
            if matches!(kind(flags, wo, draw), Kind::Delta) && all.delta(draw).is_none() {
                all.deltas.push(*draw);
                all.push(Mass {
                    value: draw.pdf,
                    // a few roundings
                    error: 1e-12,
                    evaluations: 1,
                });
            }
        }
        // without any direction there is nothing to be lost beside
        let lost = 1.0 - all.total.value;
        all.expected.push(lost.max(0.0));
        all.slack.push(all.total.error);
        all
    }

    fn push(&mut self, mass: Mass) {
        self.expected.push(mass.value);
        self.slack.push(mass.error);
        self.total = self.total.plus(mass);
    }

    /// The specular direction of a draw. Parts of a sum may share one; their throughputs tell them apart.
    fn delta(&self, draw: &BxdfSample) -> Option<usize> {
        let throughput = draw.weight * draw.pdf;
        self.deltas.iter().position(|known| {
            let difference = (known.weight * known.pdf - throughput).abs().max_element();
            (known.wi - draw.wi).length() < SAME && difference <= SAME * throughput.abs().max_element()
        })
    }

    /// Number of cells.
    pub(super) fn len(&self) -> usize {
        self.expected.len()
    }

    /// The cell of a draw.
    pub(super) fn of(&self, bxdf: &dyn Bxdf, wo: DVec3, draw: &BxdfSample) -> usize {
        let lost = self.len() - 1;
        match kind(bxdf.flags(), wo, draw) {
            Kind::Lost => lost,
            // a direction so rare that the first draws did not meet it counts among what they leave over
            Kind::Delta => self.delta(draw).map_or(lost, |delta| self.smooth + delta),
            Kind::Smooth => {
                let below = draw.wi.z < 0.0;
                let side = self.sides.iter().find(|side| side.chart.below == below);
                side.map_or(lost, |side| side.first + side.tree.find(side.chart.at(draw.wi)))
            }
        }
    }

    /// What a cell is, for people.
    pub(super) fn describe(&self, cell: usize) -> String {
        if cell + 1 == self.len() {
            return "draws that belong to no direction".into();
        }
        if let Some(delta) = cell.checked_sub(self.smooth) {
            let w = self.deltas[delta].wi;
            return format!(
                "the specular direction at {:.2} deg",
                w.z.clamp(-1.0, 1.0).acos().to_degrees()
            );
        }
        let Some(side) = self.sides.iter().rev().find(|side| side.first <= cell) else {
            return "no cell".into();
        };
        let over = side.tree.rectangle(cell - side.first, side.chart.domain());
        over.map_or_else(String::new, |over| {
            let corner = |at: [f64; 2]| {
                let polar = side.chart.angles(at);
                polar.map(f64::to_degrees)
            };
            let ([theta, phi], [theta_to, phi_to]) = (corner(over.low), corner(over.high));
            let about = match side.chart.axis {
                Axis::X => " about the x axis",
                Axis::Y => " about the y axis",
                Axis::Z => "",
            };
            format!(
                "wi between theta {} and {}, phi {} and {} deg{about}",
                angle(theta),
                angle(theta_to),
                angle(phi),
                angle(phi_to)
            )
        })
    }
}

/// An angle in degrees with as many digits as narrow lobes need.
fn angle(degrees: f64) -> String {
    let text = format!("{degrees:.6}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    if text == "-0" { "0".into() } else { text.into() }
}

impl Tree {
    /// Splits at medians, along both axes in turn, until a leaf holds at most `each` draws.
    fn grow(leaf: Leaf, each: usize, depth: usize, leaves: &mut Vec<Leaf>) -> Self {
        if leaf.drawn.len() >= 2 * each {
            for axis in [depth % 2, (depth + 1) % 2] {
                if let Some(at) = median(&leaf, axis) {
                    let [low, high] = leaf.over.cut(axis, at);
                    let (below, above) = leaf.drawn.into_iter().partition(|(place, _)| place[axis] < at);
                    let children = [(low, below), (high, above)]
                        .map(|(over, drawn)| Self::grow(Leaf { over, drawn }, each, depth + 1, leaves));
                    return Self::Split {
                        axis,
                        at,
                        children: Box::new(children),
                    };
                }
            }
        }
        leaves.push(leaf);
        Self::Cell(leaves.len() - 1)
    }

    fn find(&self, place: [f64; 2]) -> usize {
        match self {
            Self::Cell(cell) => *cell,
            Self::Split { axis, at, children } => children[usize::from(place[*axis] >= *at)].find(place),
        }
    }

    fn rectangle(&self, wanted: usize, over: Rectangle) -> Option<Rectangle> {
        match self {
            Self::Cell(cell) => (*cell == wanted).then_some(over),
            Self::Split { axis, at, children } => {
                let parts = over.cut(*axis, *at);
                let mut found = children.iter().zip(parts);
                found.find_map(|(child, part)| child.rectangle(wanted, part))
            }
        }
    }
}

/// Half way between the two middle draws; `None` where they are one.
fn median(leaf: &Leaf, axis: usize) -> Option<f64> {
    let mut places: Vec<f64> = leaf.drawn.iter().map(|(place, _)| place[axis]).collect();
    places.sort_by(f64::total_cmp);
    let middle = places.len() / 2;
    let (low, high) = (places[middle - 1], places[middle]);
    let at = 0.5 * (low + high);
    (at > low && at <= high).then_some(at)
}
