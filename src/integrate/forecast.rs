//! What tables will cost, judged by a few of their integrals.

use super::between::{places, reference_effort};
use super::fill::{FillError, integrals, model_at};
use super::{Effort, Estimator, Integrator, Target};
use crate::plan::TablePlan;
use crate::table::Quantity;
use crate::table::axis::{AZIMUTH, Axis, MU};
use cpu_time::ThreadTime;
use rayon::ThreadPoolBuilder;
use std::time::Duration;

/// What a table will cost on one core of this machine.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Forecast {
    /// Name of the estimator.
    pub estimator: &'static str,
    /// Integrand evaluations at the texels.
    pub evaluations: f64,
    /// Seconds, with the error between texels measured and every alternative tried.
    pub seconds: f64,
}

/// Cosines at which the cost of a direction is sampled, one of the middle first.
const PROBES: [f64; 4] = [0.45, 0.02, 0.85, 0.15];

/// Azimuths at which it is.
const AZIMUTHS: [f64; 4] = [0.7, 0.05, 1.2, 1.5];

/// Places along a roughness range at which it is: lobes of one end may cost ten times those of the other.
const ROUGHNESSES: [f64; 3] = [0.5, 0.1, 0.9];

/// Probes of one kind end when they have taken this long.
const PATIENCE: Duration = Duration::from_millis(200);

/// Probes that take less are taken again until all have taken this long, and the quickest counts: rules are set up once, when first
/// asked for, and what else the machine does only ever adds.
const COLD: Duration = Duration::from_millis(50);

/// Times that they are taken at most.
const TIMES: usize = 5;

/// Directions whose integrals make up rho_hh of a slow isotropic model and of an anisotropic one to six digits, as a rule: rules take as
/// many nodes along each variable as they give digits.
const MEAN_OVER_LINE: f64 = 60.0;
const MEAN_OVER_DIRECTIONS: f64 = 1200.0;

/// A direction that takes longer is no longer a small part of a forecast of rho_hh by rho_hh itself.
const QUICK: f64 = 1e-3;

/// Places between texels that are looked at for each of several axes: few are dear, where layers are thin, and count. Some of them
/// one by one, as climbs take them, with a model for each.
const LOOKUPS: usize = 48;
const SINGLE_LOOKUPS: usize = 12;

/// Integrals that climbing to the largest error between texels takes from all starts along one axis, and from each of two.
const CLIMB_ON_LINE: f64 = 25.0;
const CLIMB_ON_SHEET: f64 = 40.0;

/// Of how many cells of a sheet one is climbed in as a rule, from 3 to 16 of them, and the most that are.
const CELLS_PER_START: f64 = 8.0;
const STARTS: f64 = 32.0;

/// Seconds to encode, write and put in place one file.
const FILE: f64 = 5e-4;

/// Times and evaluations of one integral and of what all directions share, on average.
#[derive(Debug, Clone, Copy, Default)]
struct Probe {
    seconds: f64,
    evaluations: f64,
    shared_seconds: f64,
    shared_evaluations: f64,
}

/// Integrates at a few directions and roughnesses of `plan` and scales up. What counts is the time of the processor, not that
/// on the wall: others at work on the machine make no difference.
///
/// # Errors
/// [`FillError`] with the direction that failed.
pub fn forecast(plan: &TablePlan) -> Result<Forecast, FillError> {
    alone(|| judged(plan))
}

/// Runs `work`, and all that it hands on, on one thread, whose clock then tells what it takes.
fn alone<T: Send>(work: impl FnOnce() -> T + Send) -> T {
    match ThreadPoolBuilder::new().num_threads(1).build() {
        Ok(pool) => pool.install(work),
        // a system without a thread to spare has other worries than the time
        Err(_) => work(),
    }
}

fn judged(plan: &TablePlan) -> Result<Forecast, FillError> {
    let axes: &[Axis] = plan.alternatives.first().map_or(&[], Vec::as_slice);
    let roughness = axes
        .iter()
        .find(|axis| axis.parameter != MU && axis.parameter != AZIMUTH);
    let (texel, estimator) = probes(plan, roughness, plan.estimator, plan.effort)?;
    let rows = roughness.map_or(1, |axis| axis.size) as f64;
    let alternatives = plan.alternatives.len() as f64;
    let texels = plan.texels() as f64;
    let mut seconds_of_lookups = 0.0;
    for axes in &plan.alternatives {
        let places = places(plan, axes);
        let [together, single] = looked_up(plan, axes, &places)?;
        seconds_of_lookups += places.len() as f64 * together + climbs(axes) * single;
    }
    Ok(Forecast {
        estimator,
        evaluations: texel.evaluations * texels + rows * texel.shared_evaluations,
        seconds: FILE + alternatives * (texels * texel.seconds + rows * texel.shared_seconds) + seconds_of_lookups,
    })
}

/// Integrals of the climbs to the largest error between texels.
fn climbs(axes: &[Axis]) -> f64 {
    match axes {
        [] => 0.0,
        [_] => CLIMB_ON_LINE,
        _ => {
            let cells: f64 = axes.iter().map(|axis| (axis.size + 1) as f64).product();
            CLIMB_ON_SHEET * (cells / CELLS_PER_START).clamp(1.0, STARTS)
        }
    }
}

/// Seconds that the reference at a place between texels takes among others and by itself, from some of the `places` over `axes`: where
/// layers are thin, and these crowd, integrals are dear.
fn looked_up(plan: &TablePlan, axes: &[Axis], places: &[Vec<f64>]) -> Result<[f64; 2], FillError> {
    // between texels the best estimator is the reference, to an error of its own
    let reference = reference_effort(plan);
    let chosen: Vec<usize> = spread(places.len()).take(LOOKUPS).collect();
    let together = quickest(|start| {
        let mut count = 0;
        for some in chosen.chunks(LOOKUPS / 4) {
            if count > 0 && start.elapsed() > PATIENCE {
                break;
            }
            // in the order in which a bake takes them: those of one roughness share a model
            let mut some = some.to_vec();
            some.sort_unstable();
            let at: Vec<Vec<f64>> = some.iter().map(|index| places[*index].clone()).collect();
            integrals(plan, axes, &at, Estimator::Auto, reference, &|_| {})?;
            count += at.len();
        }
        Ok((start.elapsed().as_secs_f64() / count.max(1) as f64, 0.0))
    })?;
    let single = quickest(|start| {
        let mut count = 0;
        for index in chosen.iter().take(SINGLE_LOOKUPS) {
            if count > 0 && start.elapsed() > PATIENCE {
                break;
            }
            let place = std::slice::from_ref(&places[*index]);
            integrals(plan, axes, place, Estimator::Auto, reference, &|_| {})?;
            count += 1;
        }
        Ok((start.elapsed().as_secs_f64() / f64::from(count.max(1)), 0.0))
    })?;
    Ok([together.0, single.0])
}

/// Seconds and evaluations of an integral that `work` finds from its start on, the quickest of several times if they are short.
fn quickest(work: impl Fn(ThreadTime) -> Result<(f64, f64), FillError>) -> Result<(f64, f64), FillError> {
    let start = ThreadTime::now();
    let mut best = work(start)?;
    for _ in 1..TIMES {
        if start.elapsed() >= COLD {
            break;
        }
        let again = work(ThreadTime::now())?;
        if again.0 < best.0 {
            best = again;
        }
    }
    Ok(best)
}

/// What an integral of `plan` takes, and the estimator that it gets.
fn probes(
    plan: &TablePlan,
    roughness: Option<&Axis>,
    estimator: Estimator,
    effort: Effort,
) -> Result<(Probe, &'static str), FillError> {
    let places: &[f64] = if roughness.is_some() {
        &ROUGHNESSES
    } else {
        &ROUGHNESSES[..1]
    };
    let (start, mut sum, mut count, mut name) = (ThreadTime::now(), Probe::default(), 0.0, "");
    for place in places {
        if count > 0.0 && start.elapsed() > PATIENCE {
            break;
        }
        let at = roughness.map(|axis| (axis.parameter.as_str(), axis.value(*place)));
        let (probe, found) = probe(plan, at, estimator, effort)?;
        sum.seconds += probe.seconds;
        sum.evaluations += probe.evaluations;
        sum.shared_seconds += probe.shared_seconds;
        sum.shared_evaluations += probe.shared_evaluations;
        count += 1.0;
        // that of the middle stands for all
        if name.is_empty() {
            name = found;
        }
    }
    let mean = Probe {
        seconds: sum.seconds / count,
        evaluations: sum.evaluations / count,
        shared_seconds: sum.shared_seconds / count,
        shared_evaluations: sum.shared_evaluations / count,
    };
    Ok((mean, name))
}

/// What an integral of `plan` takes at one roughness.
fn probe(
    plan: &TablePlan,
    roughness: Option<(&str, f64)>,
    estimator: Estimator,
    effort: Effort,
) -> Result<(Probe, &'static str), FillError> {
    let model = model_at(plan, roughness.map(|(_, value)| value))?;
    let failed = |target: &Target| {
        let angles = target.outgoing.map(|angles| format!("mu = {}", angles.mu));
        let roughness = roughness.map(|(name, value)| format!("{name} = {value}"));
        let at = angles.into_iter().chain(roughness).collect::<Vec<_>>().join(", ");
        move |source| FillError::Integral {
            id: plan.id.clone(),
            at,
            source,
        }
    };
    let mean = Target::rho_hh().of(plan.lobe);
    let start = ThreadTime::now();
    let integrator = Integrator::new(&model, estimator, effort).map_err(failed(&mean))?;
    let shared_seconds = start.elapsed().as_secs_f64();
    // the mean of all: their costs differ, and dear ones count
    let over = |targets: &[Target]| -> Result<(f64, f64), FillError> {
        quickest(|start| {
            let (mut evaluations, mut count) = (0.0, 0.0);
            for (cell, target) in targets.iter().enumerate() {
                if count > 0.0 && start.elapsed() > PATIENCE {
                    break;
                }
                let estimate = integrator.estimate(*target, cell as u64).map_err(failed(target))?;
                evaluations += estimate.evaluations as f64;
                count += 1.0;
            }
            Ok((start.elapsed().as_secs_f64() / count, evaluations / count))
        })
    };
    let directions: Vec<Target> = PROBES
        .iter()
        .zip(AZIMUTHS)
        .map(|(mu, phi)| Target::rho_hd(*mu, phi).of(plan.lobe))
        .collect();
    let (target, times, (seconds, evaluations)) = match plan.quantity {
        Quantity::RhoHd => (directions[0], 1.0, over(&directions)?),
        // a mean that takes long is told from its directions, and not paid for
        Quantity::RhoHh => {
            let direction = over(&directions)?;
            let digits = (-libm::log10(effort.tolerance) / 6.0).max(0.1);
            let samples = matches!(integrator.estimator(mean), Estimator::MonteCarlo { .. });
            if model.is_anisotropic() && !samples {
                (mean, MEAN_OVER_DIRECTIONS * digits * digits, direction)
            } else if direction.0 > QUICK && !samples {
                (mean, MEAN_OVER_LINE * digits, direction)
            } else {
                (mean, 1.0, over(&[mean])?)
            }
        }
    };
    let probe = Probe {
        seconds: seconds * times,
        evaluations: evaluations * times,
        shared_seconds,
        shared_evaluations: integrator.shared_evaluations() as f64,
    };
    Ok((probe, integrator.estimator(target).name()))
}

/// What many tables will cost.
#[derive(Debug, Clone, PartialEq)]
pub struct Forecasts {
    /// One for each table, in their order. Tables that were not looked at, or whose integrals fail, get the mean of the others.
    pub each: Vec<Forecast>,
    /// How many were looked at.
    pub studied: usize,
    /// The first failure that was met.
    pub failed: Option<FillError>,
}

impl Forecasts {
    /// Seconds of one core for all of them.
    pub fn seconds(&self) -> f64 {
        self.each.iter().fold(0.0, |sum, forecast| sum + forecast.seconds)
    }

    /// Evaluations at the texels of all of them.
    pub fn evaluations(&self) -> f64 {
        self.each.iter().fold(0.0, |sum, forecast| sum + forecast.evaluations)
    }
}

/// Looks at as many of the `plans` as `patience` allows, and at one at least.
pub fn forecasts(plans: &[&TablePlan], patience: Duration) -> Forecasts {
    alone(|| looked_at(plans, patience))
}

fn looked_at(plans: &[&TablePlan], patience: Duration) -> Forecasts {
    let start = ThreadTime::now();
    let mut found: Vec<Option<Forecast>> = vec![None; plans.len()];
    let (mut studied, mut failed) = (0, None);
    for index in spread(plans.len()) {
        if studied > 0 && start.elapsed() > patience {
            break;
        }
        match judged(plans[index]) {
            Ok(forecast) => found[index] = Some(forecast),
            Err(error) => failed = failed.or(Some(error)),
        }
        studied += 1;
    }
    let known = || found.iter().flatten();
    let count = known().count().max(1) as f64;
    let mean = |of: fn(&Forecast) -> f64| known().map(of).sum::<f64>() / count;
    let (evaluations, seconds) = (mean(|forecast| forecast.evaluations), mean(|forecast| forecast.seconds));
    let guess = |plan: &TablePlan| Forecast {
        estimator: estimator(plan),
        evaluations,
        seconds,
    };
    let each = found.iter().zip(plans);
    Forecasts {
        each: each.map(|(found, plan)| found.unwrap_or_else(|| guess(plan))).collect(),
        studied,
        failed,
    }
}

/// Name of the estimator that the first texel of `plan` gets.
fn estimator(plan: &TablePlan) -> &'static str {
    let target = match plan.quantity {
        Quantity::RhoHd => Target::rho_hd(PROBES[0], AZIMUTHS[0]),
        Quantity::RhoHh => Target::rho_hh(),
    };
    let model = model_at(plan, None).ok();
    let integrator = model
        .as_ref()
        .and_then(|model| Integrator::new(model, plan.estimator, plan.effort).ok());
    integrator.map_or(plan.estimator.name(), |integrator| {
        integrator.estimator(target.of(plan.lobe)).name()
    })
}

/// All of 0..count, each one far from those before: neighbours in a scene tend to be alike.
fn spread(count: usize) -> impl Iterator<Item = usize> {
    // steps of about the golden section, and of no common divisor with the count
    let divisor = |mut a: usize, mut b: usize| {
        while b > 0 {
            (a, b) = (b, a % b);
        }
        a
    };
    let golden = (count as f64 * 0.618) as usize;
    let step = (golden.max(1)..).find(|step| divisor(*step, count) == 1).unwrap_or(1);
    (0..count).map(move |i| (i as u128 * step as u128 % count as u128) as usize)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    #[test]
    fn every_place_is_visited_once() {
        for count in [0, 1, 2, 3, 10, 97, 1024, 7919] {
            let visited: BTreeSet<usize> = spread(count).collect();
            assert_eq!(visited, (0..count).collect());
            assert_eq!(spread(count).count(), count);
        }
    }
}
