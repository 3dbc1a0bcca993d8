//! Quadrature against our own best quasi-Monte Carlo estimator, at equal error, on the table that engines bake: mu by
//! perceptual roughness.

use super::clock::{Seconds, timed};
use super::families::Kin;
use super::ladder::compute;
use super::scaling::microfacet;
use super::settings::{Budget, Settings};
use super::subject::{Subject, plan_of};
use super::{CostError, workers};
use crate::bxdf::Model;
use crate::estimate::{Effort, Estimate, Estimator};
use crate::integrate::Target;
use crate::parameter::PHONG_N;
use crate::scene::Material;

/// Largest error that both sides keep.
pub const ERROR: f64 = 1e-4;

/// A table computed by both.
#[derive(Debug, Clone, PartialEq)]
pub struct Contest {
    /// Distribution and masking.
    pub lobe: &'static str,
    /// Texels along each axis.
    pub size: usize,
    /// CPU time of the whole table by quadrature, to a tolerance of [`ERROR`].
    pub quadrature: Seconds,
    /// Its largest true error.
    pub quadrature_error: f64,
    /// Its evaluations.
    pub quadrature_evaluations: u64,
    /// The other side, if any sampling has come to the error in time.
    pub rival: Option<Rival>,
}

/// The best of the random estimators on a table.
#[derive(Debug, Clone, PartialEq)]
pub struct Rival {
    /// The estimator.
    pub estimator: Estimator,
    /// Samples of each texel: the least power of two at which the largest error is at most [`ERROR`].
    pub samples: u64,
    /// Its largest true error.
    pub error: f64,
    /// CPU time of the whole table, from that of the texels that were computed.
    pub cpu: f64,
    /// Texels that were computed.
    pub texels: usize,
    /// Whether the error was reached; otherwise time was up, and the table takes longer than `cpu`.
    pub reached: bool,
}

impl Contest {
    /// CPU seconds of the rival over those of quadrature.
    pub fn ratio(&self) -> Option<f64> {
        self.rival.as_ref().map(|rival| rival.cpu / self.quadrature.cpu)
    }
}

/// The lobes, with the roughness parameter that goes with alpha = roughness^2: kappa = 2/alpha^2 and n = 2/alpha^2 - 2 make
/// lobes as wide as Beckmann's with m = alpha, as far as n goes.
const LOBES: [(&str, &str); 5] = [
    ("GGX, Smith correlated", "smith-correlated"),
    ("Beckmann, Smith correlated", "smith-correlated"),
    ("Beckmann, V-groove", "v-groove"),
    ("vMF, V-groove", "v-groove"),
    ("Phong, V-groove", "v-groove"),
];

fn distribution(lobe: usize, alpha: f64) -> String {
    match lobe {
        0 => format!("{{ type = \"ggx\", alpha = {alpha:?} }}"),
        1 | 2 => format!("{{ type = \"beckmann\", m = {alpha:?} }}"),
        3 => format!("{{ type = \"vmf\", kappa = {:?} }}", 2.0 / (alpha * alpha)),
        _ => format!(
            "{{ type = \"phong\", n = {:?} }}",
            (2.0 / (alpha * alpha) - 2.0).clamp(0.0, PHONG_N.max)
        ),
    }
}

/// Every `stride`-th texel of the table, of which a material of each row is known.
fn texels(rows: &[Material], size: usize, stride: usize) -> Result<Subject, CostError> {
    let chosen = || (stride / 2..size).step_by(stride);
    let centre = |i: usize| (i as f64 + 0.5) / size as f64;
    let targets: Vec<Target> = chosen().map(|i| Target::rho_hd(centre(i), 0.0)).collect();
    let models = chosen().map(|row| Ok((rows[row].model.at(None)?, targets.clone())));
    let runs: Vec<(Model, Vec<Target>)> = models.collect::<Result<_, CostError>>()?;
    Ok(Subject {
        material: rows[0].name.clone(),
        plan: plan_of(&rows[0], size, 2)?,
        runs,
    })
}

/// Finest tolerance of what both are compared with.
const REFERENCE: f64 = 1e-8;

/// Samples of the heats that find the best sampling.
const HEAT: u64 = 1 << 12;

/// Most samples of a texel.
const MOST: u64 = 1 << 24;

/// Compares both on every lobe.
///
/// # Errors
/// [`CostError`] when the reference does not converge.
pub(super) fn contests(
    settings: &Settings,
    budget: &Budget,
    progress: &(dyn Fn(u64) + Sync),
) -> Result<Vec<Contest>, CostError> {
    let lobes: Vec<usize> = (0..LOBES.len()).collect();
    let results = workers::run(settings.threads, &lobes, |lobe| {
        let found = contest(*lobe, settings, budget);
        progress(1);
        found
    })?;
    results.into_iter().collect()
}

/// Number of contests.
pub(super) fn work() -> u64 {
    LOBES.len() as u64
}

fn contest(lobe: usize, settings: &Settings, budget: &Budget) -> Result<Contest, CostError> {
    let (name, masking) = LOBES[lobe];
    let size = settings.contest;
    let rows: Vec<Material> = (0..size)
        .map(|row| {
            let roughness = (row as f64 + 0.5) / size as f64;
            microfacet(name, &distribution(lobe, roughness * roughness), masking, "\"none\"")
        })
        .collect();
    let effort = |tolerance| Effort {
        tolerance,
        samples: None,
        seed: settings.seed,
    };
    let failed = |(source, _)| CostError::Reference {
        material: name.into(),
        source,
    };
    let whole = texels(&rows, size, 1)?;
    let (table, quadrature) = timed(|| compute(&whole, Estimator::Quadrature, effort(ERROR)));
    let (_, quadrature_evaluations) = table.map_err(failed)?;
    // both sides are compared with the truth at the same texels
    let some = texels(&rows, size, settings.contest_stride)?;
    let (found, _) = compute(&some, Estimator::Quadrature, effort(ERROR)).map_err(failed)?;
    let (known, _) = compute(&some, Estimator::Quadrature, effort(REFERENCE)).map_err(failed)?;
    Ok(Contest {
        lobe: name,
        size,
        quadrature,
        quadrature_error: distance(&found, &known),
        quadrature_evaluations,
        rival: rival(&some, &known, settings, budget),
    })
}

fn distance(found: &[Estimate], truth: &[Estimate]) -> f64 {
    let pairs = found.iter().zip(truth);
    pairs
        .map(|(a, b)| (a.value - b.value).abs().max_element())
        .fold(0.0, f64::max)
}

/// The sampling that does most with its time, with as many samples as the error needs.
fn rival(some: &Subject, known: &[Estimate], settings: &Settings, budget: &Budget) -> Option<Rival> {
    let run = |estimator, samples| {
        let effort = Effort {
            tolerance: 0.5,
            samples: Some(samples),
            seed: settings.seed,
        };
        let (result, seconds) = timed(|| compute(some, estimator, effort));
        let (found, _) = result.ok()?;
        Some((distance(&found, known), seconds.cpu))
    };
    let of_kind = |kin| {
        Estimator::ALL
            .into_iter()
            .filter(move |estimator| Kin::of(*estimator) == kin)
    };
    // without quasi-random points the independent ones stand in
    let kin = [Kin::Qmc, Kin::MonteCarlo]
        .into_iter()
        .find(|kin| of_kind(*kin).next().is_some())?;
    let heats = of_kind(kin).filter_map(|estimator| {
        let (error, cpu) = run(estimator, HEAT)?;
        Some((error * cpu.sqrt(), estimator))
    });
    let (_, estimator) = heats.min_by(|(a, _), (b, _)| a.total_cmp(b))?;
    let scale = (settings.contest * settings.contest) as f64 / some.texels() as f64;
    let mut best = None;
    let (mut samples, mut expected) = (HEAT, 0.0);
    while samples <= MOST && budget.allows(expected) {
        let (error, cpu) = run(estimator, samples)?;
        best = Some(Rival {
            estimator,
            samples,
            error,
            cpu: cpu * scale,
            texels: some.texels(),
            reached: error <= ERROR,
        });
        if error <= ERROR {
            break;
        }
        expected = 2.0 * cpu;
        samples *= 2;
    }
    best
}
