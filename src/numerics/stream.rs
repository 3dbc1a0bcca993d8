//! Random streams: one per batch of samples, a function of the seed and of where the batch belongs, and of nothing else.
//!
//! That makes results independent of the number of threads and of the order in which they run.

use rand::{Rng, SeedableRng};
use rand_pcg::Pcg64;

/// Names one stream: the seed of the run, the table cell, and the batch within the cell.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct StreamId {
    /// Seed of the run.
    pub seed: u64,
    /// Table cell, or direction in a list.
    pub cell: u64,
    /// Batch of samples within the cell.
    pub batch: u64,
}

/// Uniform numbers in [0, 1).
pub struct Stream(Pcg64);

impl Stream {
    /// The stream named `id`.
    ///
    /// The 24 bytes of the identity are spread over the generator's 32-byte seed by a mixing function, because generators
    /// of this family that differ only in the increment are correlated.
    pub fn new(id: StreamId) -> Self {
        let mut state = id.seed;
        let mut bytes = [0; 32];
        for (chunk, word) in bytes.chunks_exact_mut(8).zip([id.cell, id.batch, 0, 0]) {
            state = mix(state ^ word);
            chunk.copy_from_slice(&state.to_le_bytes());
        }
        Self(Pcg64::from_seed(bytes))
    }

    /// 64 random bits.
    pub fn bits(&mut self) -> u64 {
        self.0.next_u64()
    }

    /// One number in [0, 1) with 53 random bits.
    pub fn uniform(&mut self) -> f64 {
        (self.0.next_u64() >> 11) as f64 * (1.0 / (1u64 << 53) as f64)
    }

    /// Three numbers in [0, 1).
    pub fn uniform3(&mut self) -> [f64; 3] {
        [self.uniform(), self.uniform(), self.uniform()]
    }
}

/// A bijection of 64 bits in which every input bit flips every output bit with probability one half: the finaliser of
/// SplitMix64 [Steele et al. 2014].
fn mix(word: u64) -> u64 {
    let mut z = word.wrapping_add(0x9e37_79b9_7f4a_7c15);
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn streams_repeat_and_differ_from_their_neighbours() {
        let id = StreamId {
            seed: 1,
            cell: 2,
            batch: 3,
        };
        let first: Vec<f64> = (0..4).map(|_| Stream::new(id).uniform()).collect();
        assert!(first.iter().all(|u| *u == first[0]));
        let draw = |id| Stream::new(id).uniform3();
        let reference = draw(id);
        for other in [
            StreamId { seed: 2, ..id },
            StreamId { cell: 3, ..id },
            StreamId { batch: 4, ..id },
        ] {
            assert_ne!(draw(other), reference);
        }
        assert_ne!(
            draw(StreamId {
                cell: 3,
                batch: 2,
                ..id
            }),
            reference
        );
    }

    /// Mean and correlation of the first numbers of consecutive streams; bounds are 5 standard deviations of 10^5 draws.
    #[test]
    fn consecutive_streams_are_independent() {
        let n = 100_000;
        let draws: Vec<f64> = (0..n)
            .map(|batch| {
                Stream::new(StreamId {
                    seed: 0,
                    cell: 0,
                    batch,
                })
                .uniform()
                    - 0.5
            })
            .collect();
        let mean = draws.iter().sum::<f64>() / n as f64;
        let correlation = draws.windows(2).map(|w| w[0] * w[1]).sum::<f64>() / n as f64;
        assert!(mean.abs() < 5.0 * (1.0 / 12.0f64 / n as f64).sqrt());
        assert!(correlation.abs() < 5.0 / 12.0 / (n as f64).sqrt());
    }
}
