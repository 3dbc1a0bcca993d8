//! How long a study goes on.

use super::ladder::Rung;
use super::subject::Subject;
use crate::estimate::Estimator;
use std::time::{Duration, Instant};

/// The shape of a study. The same settings give the same errors and evaluations, however fast the machine is; only a
/// [`Budget`] of time makes what is left out depend on it.
#[derive(Debug, Clone, PartialEq)]
pub struct Settings {
    /// Texels of the tables that estimators compute.
    pub texels: usize,
    /// Samples for each texel, from the fewest, a ladder for random estimators.
    pub samples: Vec<u64>,
    /// Tolerances, from the loosest, a ladder for quadrature.
    pub tolerances: Vec<f64>,
    /// Seeds of every rung of random estimators.
    pub seeds: u64,
    /// Samples for each texel of the reference of a material that only samples know.
    pub reference_samples: u64,
    /// Texels along mu of the tables that lookups are studied on.
    pub sizes: Vec<usize>,
    /// Texels of the largest table with two axes.
    pub crossed: usize,
    /// Error of the texels of these tables, well below what their shapes cost; the reference has a tenth of it.
    pub texel_tolerance: f64,
    /// Places at which a lookup is compared.
    pub places: usize,
    /// Texels along each axis of the tables by which quadrature and quasi-Monte Carlo are compared.
    pub contest: usize,
    /// Every so many of these texels is computed by quasi-Monte Carlo, along each axis.
    pub contest_stride: usize,
    /// First seed.
    pub seed: u64,
    /// Runs at a time, each on a thread of its own.
    pub threads: usize,
    /// Wall seconds for everything.
    pub seconds: Option<f64>,
}

impl Settings {
    /// What a paper would show, in some minutes of two cores.
    pub fn full(seed: u64, threads: usize) -> Self {
        Self {
            texels: 64,
            samples: [9, 11, 13, 15].map(|k| 1 << k).to_vec(),
            tolerances: (2..=11).map(|digits| 10f64.powi(-digits)).collect(),
            seeds: 3,
            reference_samples: 1 << 18,
            sizes: (3..=9).map(|k| 1 << k).collect(),
            crossed: 8192,
            texel_tolerance: 1e-7,
            places: 1024,
            contest: 64,
            contest_stride: 8,
            seed,
            threads,
            seconds: None,
        }
    }

    /// The same questions with smaller tables, in some seconds.
    pub fn quick(seed: u64, threads: usize) -> Self {
        Self {
            texels: 12,
            samples: [9, 11, 13].map(|k| 1 << k).to_vec(),
            tolerances: (1..=5).map(|k| 10f64.powi(-2 * k)).collect(),
            seeds: 2,
            reference_samples: 1 << 17,
            sizes: (3..=8).map(|k| 1 << k).collect(),
            crossed: 512,
            texel_tolerance: 1e-6,
            places: 128,
            contest: 64,
            contest_stride: 16,
            seed,
            threads,
            seconds: None,
        }
    }

    /// The rungs of `estimator` on `subject` and how many seeds each gets. Lookups in irregular samples take microseconds:
    /// their ladder ends earlier, and well before their reference.
    pub(super) fn ladder(&self, subject: &Subject, estimator: Estimator) -> Vec<(Rung, u64)> {
        match estimator {
            Estimator::MonteCarlo { .. } => {
                let most = if subject.is_irregular() {
                    self.reference_samples / 16
                } else {
                    u64::MAX
                };
                let rungs = self.samples.iter().filter(|samples| **samples <= most);
                rungs.map(|samples| (Rung::Samples(*samples), self.seeds)).collect()
            }
            Estimator::ClosedForm => vec![(Rung::Tolerance(1e-12), 1)],
            Estimator::Quadrature | Estimator::Auto => self
                .tolerances
                .iter()
                .map(|tolerance| (Rung::Tolerance(*tolerance), 1))
                .collect(),
        }
    }
}

/// Time that may be spent, and when it is over.
#[derive(Debug, Clone, Copy)]
pub struct Budget {
    end: Option<Instant>,
}

impl Budget {
    /// `seconds` from `begin`, or as long as it takes.
    pub(super) fn until(begin: Instant, seconds: Option<f64>) -> Self {
        Self {
            end: seconds.map(|seconds| begin + Duration::from_secs_f64(seconds)),
        }
    }

    /// Whether work of about so many seconds still fits.
    pub(super) fn allows(&self, seconds: f64) -> bool {
        let finish = Instant::now() + Duration::from_secs_f64(seconds);
        self.end.is_none_or(|end| finish <= end)
    }
}
