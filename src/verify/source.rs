//! How much a run draws, and its random streams.

use crate::numerics::moments::Moments;
use crate::numerics::stream::{Stream, StreamId};
use glam::DVec3;
use rayon::prelude::*;

/// How thorough the tests are.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Settings {
    /// Seed of the run.
    pub seed: u64,
    /// Samples per direction.
    pub samples: u64,
    /// Samples that cells are built from.
    pub pilot: usize,
    /// Cells per direction.
    pub cells: usize,
    /// Pairs of directions for reciprocity.
    pub pairs: u64,
    /// Texels per table that are compared with Monte Carlo; sixteen times as many with deterministic integration.
    pub texels: usize,
}

impl Settings {
    /// What the command line uses: 1 % of energy or a cell that is off by a fifth are found in almost every run, in about
    /// a second for each material.
    pub fn thorough(seed: u64) -> Self {
        Self {
            seed,
            samples: 1 << 17,
            pilot: 1 << 12,
            cells: 128,
            pairs: 1 << 12,
            texels: 64,
        }
    }

    /// A hundredth of that, for tests that repeat a run many times.
    pub fn quick(seed: u64) -> Self {
        Self {
            seed,
            samples: 1 << 12,
            pilot: 1 << 10,
            cells: 32,
            pairs: 1 << 7,
            texels: 8,
        }
    }
}

/// A place in the tree of random streams: a function of the seed and of what is tested, and of nothing else, so that
/// neither the number of threads nor the other materials of a scene change a number.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Source {
    seed: u64,
    key: u64,
}

impl Source {
    /// The source of everything about `name`.
    pub fn new(seed: u64, name: &str) -> Self {
        let start = Self {
            seed,
            key: 0xcbf2_9ce4_8422_2325,
        };
        start.part(name)
    }

    /// The part called `name`: FNV-1a over all names on the way to it.
    pub fn part(self, name: &str) -> Self {
        let fold = |key: u64, byte: u8| (key ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3);
        Self {
            key: fold(name.bytes().fold(self.key, fold), 0xff),
            ..self
        }
    }

    /// The part with the given number.
    pub fn number(self, index: usize) -> Self {
        self.part(&index.to_string())
    }

    /// Its random stream for one batch of samples.
    pub fn stream(self, batch: u64) -> Stream {
        Stream::new(StreamId {
            seed: self.seed,
            cell: self.key,
            batch,
        })
    }

    /// Moments of `samples` values of `draw`, in batches with streams of their own that are merged in order.
    pub(super) fn mean(self, samples: u64, draw: impl Fn(&mut Stream) -> DVec3 + Sync) -> Moments {
        let batches: Vec<Moments> = (0..samples.div_ceil(BATCH))
            .into_par_iter()
            .map(|batch| {
                let mut stream = self.stream(batch);
                let mut moments = Moments::default();
                for _ in 0..BATCH.min(samples - batch * BATCH) {
                    moments.push(draw(&mut stream));
                }
                moments
            })
            .collect();
        batches.into_iter().fold(Moments::default(), Moments::merge)
    }

    /// A seed for others who make streams of their own.
    pub fn seed(self) -> u64 {
        self.seed ^ self.key.rotate_left(32)
    }
}

/// Samples per random stream.
pub(super) const BATCH: u64 = 1 << 13;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_have_streams_of_their_own() {
        let first = |source: Source| source.stream(0).uniform();
        let gold = Source::new(1, "gold");
        let sources = [
            gold,
            Source::new(2, "gold"),
            Source::new(1, "silver"),
            gold.part("energy"),
            gold.number(1),
            gold.number(11),
            gold.number(1).number(1),
            Source::new(1, "go").part("ld"),
        ];
        for (i, a) in sources.iter().enumerate() {
            assert_eq!(first(*a), first(*a));
            assert!(sources[..i].iter().all(|b| first(*a) != first(*b)), "{i}");
        }
    }
}
