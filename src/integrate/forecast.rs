//! What tables will cost, judged by a few of their integrals.

use super::fill::{FillError, model_at, work};
use super::{Integrator, Target};
use crate::plan::TablePlan;
use crate::table::Quantity;
use crate::table::axis::{AZIMUTH, MU};
use std::time::{Duration, Instant};

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

/// Azimuth at which it is: neither tangent.
const PROBE_AZIMUTH: f64 = 0.7;

/// Probes end when they have taken this long.
const PATIENCE: Duration = Duration::from_millis(200);

/// Directions whose integrals make up rho_hh of a slow isotropic model and of an anisotropic one, as a rule.
const MEAN_OVER_LINE: f64 = 60.0;
const MEAN_OVER_DIRECTIONS: f64 = 1000.0;

/// A direction that takes longer is no longer a small part of a forecast of rho_hh by rho_hh itself.
const QUICK: f64 = 1e-3;

/// Integrates at a few directions in the middle of the roughness range of `plan` and scales up.
///
/// # Errors
/// [`FillError`] with the direction that failed.
pub fn forecast(plan: &TablePlan) -> Result<Forecast, FillError> {
    let mut axes = plan.alternatives.iter().flatten();
    let roughness = axes.find(|axis| axis.parameter != MU && axis.parameter != AZIMUTH);
    let middle = roughness.map(|axis| axis.value(0.5));
    // what directions share is computed anew for each roughness
    let shared = roughness.map_or(1, |axis| axis.size) as f64;
    let model = model_at(plan, middle)?;
    let failed = |at: String| {
        move |source| FillError::Integral {
            id: plan.id.clone(),
            at,
            source,
        }
    };
    let place = |target: &Target| {
        let roughness = roughness.map(|axis| axis.parameter.as_str()).zip(middle);
        let roughness = roughness.map(|(name, value)| format!("{name} = {value}"));
        let angles = target.outgoing.map(|angles| format!("mu = {}", angles.mu));
        let parts: Vec<String> = angles.into_iter().chain(roughness).collect();
        parts.join(", ")
    };
    let start = Instant::now();
    let integrator = Integrator::new(&model, plan.estimator, plan.effort).map_err(failed(place(&Target::rho_hh())))?;
    let beginning = start.elapsed().as_secs_f64();
    let probe = |targets: &[Target]| -> Result<Probe, FillError> {
        let begin = Instant::now();
        let mut found = Vec::new();
        for (cell, target) in targets.iter().enumerate() {
            if !found.is_empty() && begin.elapsed() > PATIENCE {
                break;
            }
            let start = Instant::now();
            let estimate = integrator
                .estimate(*target, cell as u64)
                .map_err(failed(place(target)))?;
            found.push((start.elapsed().as_secs_f64(), estimate.evaluations as f64));
        }
        // the median: one interruption by the system outweighs all directions together
        found.sort_by(|a, b| a.0.total_cmp(&b.0));
        let count = found.len();
        Ok(Probe {
            seconds: found.get(count / 2).map_or(0.0, |probe| probe.0),
            evaluations: found.iter().map(|probe| probe.1).sum::<f64>() / count.max(1) as f64,
        })
    };
    let directions = PROBES.map(|mu| Target::rho_hd(mu, PROBE_AZIMUTH).of(plan.lobe));
    let mean = Target::rho_hh().of(plan.lobe);
    let (each, times, estimator) = match plan.quantity {
        Quantity::RhoHd => (probe(&directions)?, 1.0, integrator.estimator(directions[0])),
        Quantity::RhoHh => {
            // a mean that takes long is told from its directions, and not paid for
            let direction = probe(&directions)?;
            let estimator = integrator.estimator(mean);
            if model.is_anisotropic() {
                (direction, MEAN_OVER_DIRECTIONS, estimator)
            } else if direction.seconds > QUICK {
                (direction, MEAN_OVER_LINE, estimator)
            } else {
                (probe(&[mean])?, 1.0, estimator)
            }
        }
    };
    Ok(Forecast {
        estimator: estimator.name(),
        evaluations: each.evaluations * times * plan.texels() as f64 + shared * integrator.shared_evaluations() as f64,
        seconds: each.seconds * times * work(plan) as f64 + shared * beginning,
    })
}

/// What a direction takes.
struct Probe {
    seconds: f64,
    evaluations: f64,
}

/// The seconds of each of the `plans`, and how many of them were looked at within `patience`: the others get the mean of
/// those, as do those whose integrals fail, which is for the bake to tell.
pub fn forecasts(plans: &[&TablePlan], patience: Duration) -> (Vec<f64>, usize) {
    let start = Instant::now();
    let mut seconds: Vec<Option<f64>> = vec![None; plans.len()];
    let mut studied = 0;
    for index in spread(plans.len()) {
        if studied > 0 && start.elapsed() > patience {
            break;
        }
        seconds[index] = forecast(plans[index]).ok().map(|forecast| forecast.seconds);
        studied += 1;
    }
    let known: Vec<f64> = seconds.iter().flatten().copied().collect();
    let mean = known.iter().sum::<f64>() / known.len().max(1) as f64;
    (
        seconds.into_iter().map(|seconds| seconds.unwrap_or(mean)).collect(),
        studied,
    )
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
