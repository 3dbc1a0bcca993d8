//! Every estimator over a ladder of efforts, each result beside a reference.

use super::clock::{Seconds, timed};
use super::fit::Line;
use super::settings::{Budget, Settings};
use super::subject::Subject;
use super::{CostError, workers};
use crate::estimate::{Effort, Estimate, Estimator};
use crate::integrate::{IntegrateError, Integrator};
use glam::DVec3;
use std::collections::HashMap;
use std::sync::Mutex;

/// One step of a ladder.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Rung {
    /// Samples for each texel.
    Samples(u64),
    /// Tolerance of each texel.
    Tolerance(f64),
}

/// What a converged computation says.
#[derive(Debug, Clone)]
pub struct Reference {
    /// How it was computed.
    pub estimator: Estimator,
    /// The largest error that it states of itself: what is below is not known.
    pub error: f64,
    /// Evaluations of all texels.
    pub evaluations: u64,
    /// What it took.
    pub seconds: Seconds,
    pub(super) estimates: Vec<Estimate>,
}

/// One computation of the whole table.
#[derive(Debug, Clone, PartialEq)]
pub struct Run {
    /// The effort.
    pub rung: Rung,
    /// The seed; without effect on deterministic estimators.
    pub seed: u64,
    /// What came of it.
    pub outcome: Outcome,
}

/// What came of a run.
#[derive(Debug, Clone, PartialEq)]
pub enum Outcome {
    /// A table.
    Measured(Measured),
    /// The estimator stated no value for some texels.
    Refused {
        /// How many.
        texels: usize,
        /// What it said of the first.
        reason: String,
    },
    /// There was no time for it.
    LeftOut,
}

/// A table compared with the reference.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Measured {
    /// Largest absolute difference over all texels and channels.
    pub max_error: f64,
    /// Root of the mean square of the differences.
    pub rms_error: f64,
    /// Largest error that the estimator states.
    pub stated_error: f64,
    /// Values whose difference is within the stated error and that of the reference.
    pub covered: u64,
    /// Values in all.
    pub values: u64,
    /// Evaluations of all texels.
    pub evaluations: u64,
    /// What it took.
    pub seconds: Seconds,
}

/// One estimator on one material.
#[derive(Debug, Clone, PartialEq)]
pub struct Curve {
    /// The estimator.
    pub estimator: Estimator,
    /// Why it cannot compute the material at all.
    pub unsupported: Option<String>,
    /// Its runs, rung by rung from the cheapest, seed by seed.
    pub runs: Vec<Run>,
}

/// All estimators on one material.
#[derive(Debug)]
pub struct Accuracy {
    /// The material and its texels.
    pub subject: Subject,
    /// What is taken for true.
    pub reference: Reference,
    /// A curve for each estimator.
    pub curves: Vec<Curve>,
}

/// The runs of one rung that gave a table.
#[derive(Debug, Clone)]
pub struct Point<'a> {
    /// The effort.
    pub rung: Rung,
    /// One for each seed that gave a table.
    pub runs: Vec<&'a Measured>,
}

/// Tolerances of references, tried from the finest.
const REFERENCES: [f64; 6] = [1e-12, 1e-11, 1e-10, 1e-9, 1e-8, 1e-7];

/// Between the seed of a study and that of its references.
const REFERENCE_SEED: u64 = 1 << 32;

/// Every estimator that is one, and no choice among the others.
fn studied() -> impl Iterator<Item = Estimator> {
    Estimator::ALL
        .into_iter()
        .filter(|estimator| *estimator != Estimator::Auto)
}

/// All texels of `subject`; the first error, and how many texels have one.
pub(super) fn compute(
    subject: &Subject,
    estimator: Estimator,
    effort: Effort,
) -> Result<(Vec<Estimate>, u64), (IntegrateError, usize)> {
    let mut estimates = Vec::with_capacity(subject.texels());
    let mut shared = 0;
    let mut refused = None;
    for (model, targets) in &subject.runs {
        let integrator = Integrator::new(model, estimator, effort).map_err(|error| (error, targets.len()))?;
        shared += integrator.shared_evaluations();
        for target in targets {
            // a stream for every texel, as in a bake
            match integrator.estimate(*target, estimates.len() as u64) {
                Ok(estimate) => estimates.push(estimate),
                Err(error) => {
                    let (_, texels) = refused.get_or_insert((error, 0));
                    *texels += 1;
                }
            }
        }
    }
    let evaluations = shared + estimates.iter().map(|estimate| estimate.evaluations).sum::<u64>();
    match refused {
        Some(refused) => Err(refused),
        None => Ok((estimates, evaluations)),
    }
}

/// The closed form, the finest quadrature that converges, or a long run of the best samples that there are.
fn reference(subject: &Subject, settings: &Settings) -> Result<Reference, CostError> {
    let efforts = REFERENCES.map(|tolerance| Effort {
        tolerance,
        samples: None,
        seed: settings.seed,
    });
    let deterministic = efforts.into_iter().map(|effort| (Estimator::Quadrature, effort));
    let long = Effort {
        tolerance: 0.5,
        samples: Some(settings.reference_samples),
        seed: settings.seed.wrapping_add(REFERENCE_SEED),
    };
    let sampled = ["qmc-bxdf", "mc-bxdf"]
        .into_iter()
        .filter_map(|name| name.parse().ok())
        .map(|estimator| (estimator, long));
    let mut failure = None;
    for (estimator, effort) in deterministic.chain(sampled) {
        let (result, seconds) = timed(|| compute(subject, estimator, effort));
        match result {
            Ok((estimates, evaluations)) => {
                let error = estimates.iter().map(|estimate| estimate.error.max_element());
                return Ok(Reference {
                    // of a material with a closed form quadrature says so
                    estimator: estimates.first().map_or(estimator, |estimate| estimate.estimator),
                    error: error.fold(0.0, f64::max),
                    evaluations,
                    seconds,
                    estimates,
                });
            }
            Err((error, _)) => failure = Some(error),
        }
    }
    Err(failure.map_or_else(
        || CostError::Nothing(subject.material.clone()),
        |source| CostError::Reference {
            material: subject.material.clone(),
            source,
        },
    ))
}

/// Compares what was computed with what is true.
fn compare(subject: &Subject, estimates: &[Estimate], reference: &Reference) -> Measured {
    let channels = subject.plan.channels.count();
    let (mut max, mut squares, mut stated, mut covered, mut values) = (0.0f64, 0.0, 0.0f64, 0, 0);
    for (found, truth) in estimates.iter().zip(&reference.estimates) {
        let difference: DVec3 = (found.value - truth.value).abs();
        for channel in 0..channels {
            max = max.max(difference[channel]);
            squares += difference[channel] * difference[channel];
            stated = stated.max(found.error[channel]);
            covered += u64::from(difference[channel] <= found.error[channel] + truth.error[channel]);
            values += 1;
        }
    }
    Measured {
        max_error: max,
        rms_error: (squares / (values as f64).max(1.0)).sqrt(),
        stated_error: stated,
        covered,
        values,
        evaluations: 0,
        seconds: Seconds::default(),
    }
}

fn measure(subject: &Subject, reference: &Reference, estimator: Estimator, rung: Rung, seed: u64) -> Outcome {
    let effort = match rung {
        Rung::Samples(samples) => Effort {
            tolerance: 0.5,
            samples: Some(samples),
            seed,
        },
        Rung::Tolerance(tolerance) => Effort {
            tolerance,
            samples: None,
            seed,
        },
    };
    let (result, seconds) = timed(|| compute(subject, estimator, effort));
    match result {
        Ok((estimates, evaluations)) => Outcome::Measured(Measured {
            evaluations,
            seconds,
            ..compare(subject, &estimates, reference)
        }),
        Err((error, texels)) => Outcome::Refused {
            texels,
            reason: error.to_string(),
        },
    }
}

/// A run to be done.
struct Job {
    subject: usize,
    curve: usize,
    rung: Rung,
    seed: u64,
    /// Position of the rung in its ladder.
    height: usize,
}

/// Studies all estimators on all `subjects`, each run beside the reference of its material.
///
/// # Errors
/// [`CostError::Reference`] for a material that no estimator can compute.
pub(super) fn study(
    subjects: Vec<Subject>,
    settings: &Settings,
    budget: &Budget,
    progress: &(dyn Fn(u64) + Sync),
) -> Result<Vec<Accuracy>, CostError> {
    let references = workers::run(settings.threads, &subjects, |subject| {
        let found = reference(subject, settings);
        progress(subject.texels() as u64);
        found
    })?;
    let mut studies = Vec::new();
    for (subject, reference) in subjects.into_iter().zip(references) {
        let curve = |estimator: Estimator| Curve {
            estimator,
            unsupported: subject.unsupported(estimator),
            runs: Vec::new(),
        };
        studies.push(Accuracy {
            curves: studied().map(curve).collect(),
            subject,
            reference: reference?,
        });
    }
    let jobs = jobs(&studies, settings);
    // CPU seconds of a unit of effort, of each curve, as the last run told them
    let known: Mutex<HashMap<(usize, usize), f64>> = Mutex::default();
    let outcomes = workers::run(settings.threads, &jobs, |job| {
        let study = &studies[job.subject];
        let key = (job.subject, job.curve);
        let lock = || known.lock().unwrap_or_else(|poisoned| poisoned.into_inner());
        let expected = lock().get(&key).map_or(0.0, |unit| unit * size(job.rung));
        let outcome = if budget.allows(expected) {
            let estimator = study.curves[job.curve].estimator;
            let outcome = measure(&study.subject, &study.reference, estimator, job.rung, job.seed);
            if let Outcome::Measured(measured) = &outcome {
                lock().insert(key, measured.seconds.cpu / size(job.rung));
            }
            outcome
        } else {
            Outcome::LeftOut
        };
        progress(weight(&study.subject, job.rung));
        outcome
    })?;
    for (job, outcome) in jobs.iter().zip(outcomes) {
        studies[job.subject].curves[job.curve].runs.push(Run {
            rung: job.rung,
            seed: job.seed,
            outcome,
        });
    }
    Ok(studies)
}

/// All runs, the cheap rungs of all curves first: when time is up, all curves have come equally far.
fn jobs(studies: &[Accuracy], settings: &Settings) -> Vec<Job> {
    let mut jobs = Vec::new();
    for (s, study) in studies.iter().enumerate() {
        for (c, curve) in study.curves.iter().enumerate() {
            if curve.unsupported.is_some() {
                continue;
            }
            for (height, (rung, seeds)) in settings.ladder(&study.subject, curve.estimator).into_iter().enumerate() {
                jobs.extend((0..seeds).map(|seed| Job {
                    subject: s,
                    curve: c,
                    rung,
                    seed: settings.seed.wrapping_add(seed),
                    // deterministic rules are cheap on every rung
                    height: if matches!(rung, Rung::Samples(_)) {
                        height + 1
                    } else {
                        0
                    },
                }));
            }
        }
    }
    jobs.sort_by_key(|job| job.height);
    jobs
}

/// What the time of a run is about proportional to.
fn size(rung: Rung) -> f64 {
    match rung {
        Rung::Samples(samples) => samples as f64,
        Rung::Tolerance(tolerance) => 1.0 - tolerance.log10(),
    }
}

/// About how many evaluations a run takes.
fn weight(subject: &Subject, rung: Rung) -> u64 {
    let texels = subject.texels() as u64;
    match rung {
        Rung::Samples(samples) => texels * samples,
        Rung::Tolerance(_) => texels * 512,
    }
}

/// The weights of all runs of a study together, what its progress counts up to.
pub(super) fn work(subjects: &[Subject], settings: &Settings) -> u64 {
    let one = |subject: &Subject| {
        let supported = studied().filter(|estimator| subject.unsupported(*estimator).is_none());
        let rungs = supported.flat_map(|estimator| settings.ladder(subject, estimator));
        rungs.map(|(rung, seeds)| seeds * weight(subject, rung)).sum::<u64>() + subject.texels() as u64
    };
    subjects.iter().map(one).sum()
}

impl Curve {
    /// The rungs at which there is something to show.
    pub fn points(&self) -> Vec<Point<'_>> {
        let rungs = self.runs.chunk_by(|a, b| a.rung == b.rung);
        let points = rungs.map(|runs| Point {
            rung: runs[0].rung,
            runs: runs
                .iter()
                .filter_map(|run| match &run.outcome {
                    Outcome::Measured(measured) => Some(measured),
                    _ => None,
                })
                .collect(),
        });
        points.filter(|point| !point.runs.is_empty()).collect()
    }

    fn measured(&self) -> impl Iterator<Item = (&Run, &Measured)> {
        self.runs.iter().filter_map(|run| match &run.outcome {
            Outcome::Measured(measured) => Some((run, measured)),
            _ => None,
        })
    }

    /// The exponent of the RMS error as a power of the samples, over all runs whose error is above that of the reference.
    pub fn order(&self, reference: &Reference) -> Option<Line> {
        let points: Vec<[f64; 2]> = self
            .measured()
            .filter(|(_, measured)| measured.rms_error > reference.error)
            .filter_map(|(run, measured)| match run.rung {
                Rung::Samples(samples) => Some([samples as f64, measured.rms_error]),
                Rung::Tolerance(_) => None,
            })
            .collect();
        Line::through_logarithms(&points)
    }

    /// Of a deterministic rule: evaluations for each further digit of tolerance, of the whole table.
    pub fn per_digit(&self) -> Option<Line> {
        let points: Vec<[f64; 2]> = self
            .measured()
            .filter_map(|(run, measured)| match run.rung {
                Rung::Tolerance(tolerance) => Some([-tolerance.log10(), measured.evaluations as f64]),
                Rung::Samples(_) => None,
            })
            .collect();
        Line::through(&points)
    }

    /// The CPU seconds at which the largest error falls to `error`: those of the cheapest rung that keeps below it with
    /// every seed.
    pub fn seconds_for(&self, error: f64) -> Option<f64> {
        let points = self.points();
        let enough = points.iter().find(|point| point.max_errors()[2] <= error);
        enough.map(Point::cpu)
    }

    /// Values within their stated errors, and values in all.
    pub fn coverage(&self) -> [u64; 2] {
        self.measured().fold([0, 0], |[covered, values], (_, measured)| {
            [covered + measured.covered, values + measured.values]
        })
    }

    /// Runs that were refused, and runs that there was no time for.
    pub fn missing(&self) -> [usize; 2] {
        let count = |test: fn(&Outcome) -> bool| self.runs.iter().filter(|run| test(&run.outcome)).count();
        [
            count(|outcome| matches!(outcome, Outcome::Refused { .. })),
            count(|outcome| matches!(outcome, Outcome::LeftOut)),
        ]
    }
}

impl Point<'_> {
    /// Smallest, geometric mean and largest of the largest errors of the seeds.
    pub fn max_errors(&self) -> [f64; 3] {
        spread(self.runs.iter().map(|run| run.max_error))
    }

    /// The same of the RMS errors.
    pub fn rms_errors(&self) -> [f64; 3] {
        spread(self.runs.iter().map(|run| run.rms_error))
    }

    /// CPU seconds of one table, the mean over the seeds.
    pub fn cpu(&self) -> f64 {
        self.runs.iter().map(|run| run.seconds.cpu).sum::<f64>() / self.runs.len() as f64
    }

    /// Evaluations of one table.
    pub fn evaluations(&self) -> u64 {
        self.runs.iter().map(|run| run.evaluations).max().unwrap_or_default()
    }
}

/// Smallest, geometric mean, largest.
fn spread(values: impl Iterator<Item = f64> + Clone) -> [f64; 3] {
    let (n, logs) = values
        .clone()
        .fold((0.0, 0.0), |(n, sum), value| (n + 1.0, sum + value.ln()));
    let least = values.clone().fold(f64::INFINITY, f64::min);
    let most = values.fold(0.0, f64::max);
    // the mean of a zero and others is zero
    [least, (logs / n).exp().clamp(least, most), most]
}
