//! Points of the unit cube to integrate over: random, stratified, or quasi-random.
//!
//! Every point of every kind is uniform over the cube, to the last of 52 bits, so a mean over any of them is unbiased. The
//! kinds differ in how points of one set keep clear of each other:
//!
//! - random points do not: the error of a mean of n falls like n^-1/2;
//! - stratified points are drawn from one box of volume 1/n each: n^(-1/2 - 1/d) in d dimensions for smooth integrands;
//! - points of a Sobol sequence, scrambled as Owen does, are stratified over all boxes of volume 1/n with sides that are
//!   powers of two, when n is one: up to n^-3/2 for smooth integrands [Owen 1997].

use super::stream::{Stream, StreamId};
use multiversion::multiversion;
use sobol_burley::parts::{owen_scramble_rev, sobol_rev};
use std::sync::LazyLock;

/// What the points of a Monte Carlo estimate know of each other.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Points {
    /// Nothing: they are independent.
    Random,
    /// One in each of equal boxes.
    Stratified,
    /// Those of an Owen-scrambled Sobol sequence.
    Quasi,
}

impl Points {
    /// Every kind.
    pub const ALL: [Self; 3] = [Self::Random, Self::Stratified, Self::Quasi];
}

/// Most dimensions of a point: three to draw a direction, two for the direction that it is drawn for.
pub const DIMENSIONS: usize = 5;

/// Points that are made in one call, at most.
pub const BLOCK: usize = 256;

/// Points from one random stream.
pub const BATCH: u64 = 1 << 12;

/// Random streams start at multiples of this.
pub const START: u64 = 1 << 7;

/// Most points of one scrambled Sobol sequence: those that the crate has direction numbers for.
pub const LONGEST_SEQUENCE: u64 = 1 << 16;

/// A set of points that keep clear of each other. Sets of different identity are independent.
pub struct PointSet {
    points: Points,
    /// `batch` numbers the set.
    id: StreamId,
    count: u64,
    /// Slabs across each dimension but the last, into which stratified points are dealt.
    slabs: [u64; DIMENSIONS],
    dimensions: usize,
    scrambles: [Scramble; DIMENSIONS],
}

/// The randomisation of one dimension of a Sobol sequence.
#[derive(Clone, Copy, Default)]
struct Scramble {
    /// Seed of the nested scrambling, in which a hash stands for independent bits.
    owen: u32,
    /// 52 bits added modulo 2: they make every point uniform, whatever the hash.
    shift: u64,
}

impl PointSet {
    /// `count` points of `dimensions` coordinates; `id.batch` below 2^32 numbers the set.
    ///
    /// The first n of quasi-random points are the same for every count.
    pub fn new(points: Points, id: StreamId, count: u64, dimensions: usize) -> Self {
        let mut slabs = [1; DIMENSIONS];
        let mut rest = count as f64;
        for (dimension, slabs) in slabs.iter_mut().enumerate().take(dimensions) {
            let root = libm::pow(rest, 1.0 / (dimensions - dimension) as f64).round().max(1.0);
            *slabs = root as u64;
            rest /= root;
        }
        let mut stream = stream(id, u32::MAX);
        let scrambles = std::array::from_fn(|_| Scramble {
            owen: stream.bits() as u32,
            shift: stream.bits() >> 12,
        });
        Self {
            points,
            id,
            count,
            slabs,
            dimensions,
            scrambles,
        }
    }

    /// Random numbers for the points that start with the one numbered `start`, a multiple of [`START`] below 2^38.
    pub fn stream(&self, start: u64) -> Stream {
        stream(self.id, (start / START) as u32)
    }

    /// Fills one slice per dimension with `len` points, from the one numbered `from` to at most the next multiple of
    /// [`BLOCK`].
    pub fn fill(&self, stream: &mut Stream, from: u64, u: &mut [[f64; BLOCK]], len: usize) {
        match self.points {
            Points::Random => {
                for u in u {
                    u[..len].fill_with(|| stream.uniform());
                }
            }
            Points::Stratified => self.strata(stream, from, u, len),
            Points::Quasi => self.sobol(stream, from, u, len),
        }
    }

    fn strata(&self, stream: &mut Stream, from: u64, u: &mut [[f64; BLOCK]], len: usize) {
        let mut made = 0;
        while made < len {
            let row = self.row(from + made as u64);
            let run = ((row.count - row.index) as usize).min(len - made);
            let (outer, last) = u.split_at_mut(self.dimensions - 1);
            let last = &mut last[0];
            let scale = 1.0 / row.count as f64;
            for i in 0..run {
                for (u, (start, width)) in outer.iter_mut().zip(row.sides) {
                    u[made + i] = (start + width * stream.uniform()).min(BELOW_ONE);
                }
                let place = (row.index + i as u64) as f64 + stream.uniform();
                last[made + i] = (place * scale).min(BELOW_ONE);
            }
            made += run;
        }
    }

    /// The row of boxes that the point `index` is in.
    ///
    /// The cube is cut into slabs across the first dimension, with widths in proportion to the points that go to each, these
    /// across the second, and so on, and the rows that are left into one box for each point: of equal volume for any count.
    fn row(&self, index: u64) -> Row {
        let mut row = Row {
            sides: [(0.0, 1.0); DIMENSIONS],
            index,
            count: self.count,
        };
        for dimension in 0..self.dimensions - 1 {
            let n = row.count;
            let slabs = self.slabs[dimension].min(n);
            // slab j holds the points from j n/slabs, rounded up
            let j = row.index * slabs / n;
            let start = (j * n).div_ceil(slabs);
            let end = ((j + 1) * n).div_ceil(slabs);
            row.sides[dimension] = (start as f64 / n as f64, (end - start) as f64 / n as f64);
            (row.index, row.count) = (row.index - start, end - start);
        }
        row
    }

    fn sobol(&self, stream: &mut Stream, from: u64, u: &mut [[f64; BLOCK]], len: usize) {
        let skipped = from as usize % BLOCK;
        let mut low = [0; BLOCK];
        for (dimension, u) in u.iter_mut().enumerate() {
            // the numbers of bits below the 32 of the sequence, for three dimensions at once
            if dimension % 3 == 0 {
                low[..len].fill_with(|| stream.bits());
            }
            let first = sobol_rev((from as u32 - skipped as u32).reverse_bits(), dimension as u32);
            let bits = 20 * (dimension % 3) as u32;
            scramble(
                first,
                &FIRST_BLOCK[dimension][skipped..],
                &low,
                bits,
                self.scrambles[dimension],
                &mut u[..len],
            );
        }
    }
}

/// Boxes that differ in the last dimension alone.
struct Row {
    /// Low end and width of each of the other dimensions.
    sides: [(f64, f64); DIMENSIONS],
    /// Of the boxes in the row, the one asked for.
    index: u64,
    count: u64,
}

/// The largest number below 1.
pub const BELOW_ONE: f64 = 1.0 - 0.5 * f64::EPSILON;

fn stream(id: StreamId, batch: u32) -> Stream {
    Stream::new(StreamId {
        batch: id.batch << 32 | u64::from(batch),
        ..id
    })
}

/// The first points of the sequence, bits reversed. Those of any later block are these, with the first of that block added
/// modulo 2.
static FIRST_BLOCK: LazyLock<[[u32; BLOCK]; DIMENSIONS]> = LazyLock::new(|| {
    std::array::from_fn(|dimension| {
        std::array::from_fn(|index| sobol_rev((index as u32).reverse_bits(), dimension as u32))
    })
});

#[multiversion(targets("x86_64+avx512f+avx512dq", "x86_64+avx2", "x86_64+avx"))]
fn scramble(first: u32, block: &[u32], low: &[u64; BLOCK], bits: u32, by: Scramble, u: &mut [f64]) {
    for ((point, low), u) in block.iter().zip(low).zip(u) {
        let high = owen_scramble_rev(point ^ first, by.owen).reverse_bits();
        let word = (u64::from(high) << 20 | (low >> bits & 0xf_ffff)) ^ by.shift;
        // 1 + word/2^52
        *u = f64::from_bits(word | 1023 << 52) - 1.0;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn points(kind: Points, set: u64, count: u64, dimensions: usize) -> Vec<Vec<f64>> {
        let id = StreamId {
            seed: 1,
            cell: 2,
            batch: set,
        };
        let set = PointSet::new(kind, id, count, dimensions);
        let mut all = vec![Vec::new(); dimensions];
        let mut stream = set.stream(0);
        for from in (0..count).step_by(BLOCK) {
            let len = (count - from).min(BLOCK as u64) as usize;
            let mut u = [[0.0; BLOCK]; DIMENSIONS];
            set.fill(&mut stream, from, &mut u[..dimensions], len);
            for (all, u) in all.iter_mut().zip(u) {
                all.extend_from_slice(&u[..len]);
            }
        }
        all
    }

    /// Every elementary box of volume 1/n holds one of n = 2^k points in two dimensions; 256 and more test block after block.
    #[test]
    fn quasi_random_points_are_nets() {
        for log in [0, 5, 8, 11] {
            let all = points(Points::Quasi, 7, 1 << log, 2);
            for x_log in 0..=log {
                let (columns, rows) = (1u64 << x_log, 1u64 << (log - x_log));
                let mut seen = vec![false; 1 << log];
                for (x, y) in all[0].iter().zip(&all[1]) {
                    let index = (x * columns as f64) as u64 * rows + (y * rows as f64) as u64;
                    assert!(!std::mem::replace(&mut seen[index as usize], true), "{log} {x_log}");
                }
            }
        }
    }

    /// Boxes of stratified points have volume 1/n, hold their point, and are disjoint and so fill the cube.
    #[test]
    fn strata_are_equal_boxes() {
        for (count, dimensions) in [(1, 2), (7, 1), (64, 2), (101, 2), (1000, 3), (777, 5)] {
            let id = StreamId {
                seed: 0,
                cell: 0,
                batch: 0,
            };
            let set = PointSet::new(Points::Stratified, id, count, dimensions);
            let mut boxes: Vec<Vec<(f64, f64)>> = Vec::new();
            for index in 0..count {
                let row = set.row(index);
                let outer = row.sides[..dimensions - 1].iter();
                let mut sides: Vec<(f64, f64)> = outer.map(|(start, width)| (*start, start + width)).collect();
                let [low, high] = [row.index, row.index + 1].map(|k| k as f64 / row.count as f64);
                sides.push((low, high));
                let volume: f64 = sides.iter().map(|(low, high)| high - low).product();
                assert!(
                    (volume * count as f64 - 1.0).abs() < 1e-12,
                    "{count} {dimensions} {index}"
                );
                for other in &boxes {
                    let apart = sides
                        .iter()
                        .zip(other)
                        .any(|(a, b)| a.0 >= b.1 - 1e-12 || b.0 >= a.1 - 1e-12);
                    assert!(apart, "{count} {dimensions} {index}");
                }
                boxes.push(sides);
            }
            for (dimension, u) in points(Points::Stratified, 0, count, dimensions).iter().enumerate() {
                for (u, sides) in u.iter().zip(&boxes) {
                    let (low, high) = sides[dimension];
                    assert!(*u >= low - 1e-15 && *u <= high + 1e-15 && *u < 1.0); // rounding of the ends
                }
            }
        }
    }

    /// The mean of x y over sets of points has the error that their kind promises, and none is biased.
    #[test]
    fn sets_are_unbiased_and_converge() {
        let spread = |kind, count| {
            let sets = 400;
            let errors: Vec<f64> = (0..sets)
                .map(|set| {
                    let all = points(kind, set, count, 2);
                    let sum: f64 = all[0].iter().zip(&all[1]).map(|(x, y)| x * y).sum();
                    sum / count as f64 - 0.25
                })
                .collect();
            let mean = errors.iter().sum::<f64>() / sets as f64;
            let spread = (errors.iter().map(|e| e * e).sum::<f64>() / sets as f64).sqrt();
            assert!(
                mean.abs() < 5.0 * spread / (sets as f64).sqrt(),
                "{kind:?} {count}: {mean}"
            );
            spread
        };
        // orders 1/2, 1 and 3/2 over a factor of 16, and the spread of a spread: 4 % each
        for (kind, order) in [(Points::Random, 0.5), (Points::Stratified, 1.0), (Points::Quasi, 1.5)] {
            let found = (spread(kind, 64) / spread(kind, 1024)).ln() / 16f64.ln();
            assert!((found - order).abs() < 0.15, "{kind:?}: {found}");
        }
    }

    /// Every point of every kind is uniform below the resolution of the sequence too.
    #[test]
    fn points_have_all_their_bits() {
        for kind in Points::ALL {
            let low: Vec<f64> = (0..64)
                .flat_map(|set| points(kind, set, 256, 3).concat())
                .map(|u| (u * 2f64.powi(40)).fract())
                .collect();
            let mean = low.iter().sum::<f64>() / low.len() as f64;
            // 5 standard deviations; the last of the 12 bits left is worth 1e-4
            assert!(
                (mean - 0.5).abs() < 5.0 * (12.0 * low.len() as f64).powf(-0.5) + 2e-4,
                "{kind:?}: {mean}"
            );
        }
    }
}
