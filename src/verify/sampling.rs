//! Samplers: that `sample_f` draws from `pdf`, that `pdf` is a density, that weights are what they stand for, and that they
//! average to the albedo.

use super::cells::Cells;
use super::energy::ROUNDING;
use super::reciprocity::{allowed, difference};
use super::source::BATCH;
use super::statistics::{CountsTest, Spread, channels_p, chi_squared, common_sign, score, smallest};
use super::{Outcome, Place, Settings, Source, Stated, Statistic, Test};
use crate::bxdf::{Bxdf, BxdfSample, Flags, Sampling, other_hemisphere};
use crate::estimate::Lobe;
use crate::geometry::Polar;
use crate::integrate::monte_carlo::{self, Outgoing, Samples, Trial};
use crate::numerics::moments::Moments;
use crate::numerics::points::Points;
use glam::DVec3;
use rayon::prelude::*;

/// Cosines of the directions that samplers are tested at: the normal, two between, and grazing.
pub const COSINES: [f64; 4] = [1.0, 0.6, 0.15, 0.02];

/// Azimuth of isotropic models, in radians: one that no axis prefers.
const OBLIQUE: f64 = 0.7;

/// How far int pdf may exceed 1 beyond the error of its quadrature. Where a kink of the density crosses many cells, their
/// rules have been seen to state 2e-5 too little.
const EXCESS: f64 = 1e-4;

/// Draws per direction whose weights are compared.
const SPOTS: usize = 1024;

/// Directions that samplers are tested at: along both tangents too where a model is anisotropic, and from below where light
/// comes through.
pub fn directions(bxdf: &dyn Bxdf, isotropic: bool) -> Vec<DVec3> {
    let azimuths: &[f64] = if isotropic {
        &[OBLIQUE]
    } else {
        &[OBLIQUE, 0.0, std::f64::consts::FRAC_PI_2]
    };
    let both = bxdf.flags().contains(Flags::TRANSMISSION);
    let mut all = Vec::new();
    for mu in COSINES {
        for phi in azimuths {
            let above = Polar::from_cos(mu).direction(*phi);
            all.push(above);
            if both {
                all.push(other_hemisphere(above));
            }
            if mu == 1.0 {
                break; // the normal has no azimuth
            }
        }
    }
    all
}

/// What was found at one direction.
struct Found {
    wo: DVec3,
    cells: Cells,
    counts: CountsTest,
    moments: Moments,
    spot: Spot,
}

/// The worst disagreement of a weight or a density with what it stands for, and the draws compared.
#[derive(Clone, Copy)]
struct Spot {
    difference: f64,
    allowed: f64,
    wi: DVec3,
    what: &'static str,
    compared: u64,
}

/// The tests [`Test::Density`], [`Test::Directions`], [`Test::Weights`] and [`Test::Albedo`], in this order.
///
/// The albedo is `stated`, or else that of another sampling of the same model; the weights tell it only when neither is
/// there.
pub fn sampling(
    bxdf: &dyn Bxdf,
    stated: Option<&Stated<'_>>,
    isotropic: bool,
    settings: &Settings,
    source: Source,
) -> [Outcome; 4] {
    let source = source.part("sampling");
    let found: Vec<Found> = directions(bxdf, isotropic)
        .into_par_iter()
        .enumerate()
        .map(|(index, wo)| at(bxdf, wo, settings, source.number(index)))
        .collect();
    [
        density(&found),
        counts(&found),
        weights(&found),
        albedo(bxdf, stated, &found, settings, source),
    ]
}

/// Draws of one direction: a pilot for the cells, and fresh ones for everything else.
fn at(bxdf: &dyn Bxdf, wo: DVec3, settings: &Settings, source: Source) -> Found {
    let mut stream = source.part("pilot").stream(0);
    let pilot: Vec<BxdfSample> = (0..settings.pilot)
        .map(|_| bxdf.sample_f(wo, stream.uniform3()))
        .collect();
    let cells = Cells::new(bxdf, wo, &pilot, settings.cells);
    let batches: Vec<(Vec<u64>, Moments)> = (0..settings.samples.div_ceil(BATCH))
        .into_par_iter()
        .map(|batch| {
            let mut stream = source.stream(batch);
            let mut counts = vec![0; cells.len()];
            let mut moments = Moments::default();
            for _ in 0..BATCH.min(settings.samples - batch * BATCH) {
                let draw = bxdf.sample_f(wo, stream.uniform3());
                counts[cells.of(bxdf, wo, &draw)] += 1;
                moments.push(draw.weight);
            }
            (counts, moments)
        })
        .collect();
    let mut counts = vec![0; cells.len()];
    let mut moments = Moments::default();
    for (part, of_part) in batches {
        counts.iter_mut().zip(part).for_each(|(sum, count)| *sum += count);
        moments = moments.merge(of_part);
    }
    let n = settings.samples as f64;
    let scaled = |values: &[f64]| -> Vec<f64> { values.iter().map(|value| value * n).collect() };
    Found {
        wo,
        counts: chi_squared(&counts, &scaled(&cells.expected), &scaled(&cells.slack)),
        spot: spot(bxdf, wo, &pilot),
        moments,
        cells,
    }
}

/// Compares weights and densities of draws with f |cos theta_i|/pdf and `pdf`, where those can be formed.
fn spot(bxdf: &dyn Bxdf, wo: DVec3, draws: &[BxdfSample]) -> Spot {
    let mut worst = Spot {
        difference: 0.0,
        allowed: 1.0,
        wi: wo,
        what: "weight",
        compared: 0,
    };
    let smooth = |draw: &&BxdfSample| !draw.flags.contains(Flags::SPECULAR) && !draw.flags.is_empty();
    for draw in draws.iter().filter(smooth).take(SPOTS) {
        let pdf = |wi: DVec3| bxdf.pdf(wo, wi);
        let quotient = |wi: DVec3| bxdf.f(wo, wi) * (wi.z.abs() / bxdf.pdf(wo, wi));
        let wi = draw.wi;
        // densities that underflow or overflow have no quotient
        let formed = pdf(wi).is_normal() && quotient(wi).is_finite();
        if !formed {
            continue;
        }
        worst.compared += 1;
        let mut add = |difference: f64, allowed: &dyn Fn() -> f64, what: &'static str| {
            if difference / ROUGHLY <= worst.difference / worst.allowed {
                return;
            }
            let allowed = allowed();
            if difference / allowed > worst.difference / worst.allowed {
                worst = Spot {
                    difference,
                    allowed,
                    wi,
                    what,
                    ..worst
                };
            }
        };
        add(
            difference(draw.weight, quotient(wi)),
            &|| allowed(quotient(wi), quotient, wi),
            "weight",
        );
        add(
            difference(DVec3::splat(draw.pdf), DVec3::splat(pdf(wi))),
            &|| allowed(DVec3::splat(pdf(wi)), |wi| DVec3::splat(pdf(wi)), wi),
            "density",
        );
    }
    worst
}

/// The least that is allowed of any difference, see [`allowed`].
const ROUGHLY: f64 = 1e-9;

fn density(found: &[Found]) -> Outcome {
    // what exceeds 1 for certain, wherever that is most
    let least = |found: &Found| {
        let total = found.cells.total;
        let least = total.value - total.error;
        if least.is_nan() { f64::INFINITY } else { least }
    };
    let Some(worst) = found.iter().reduce(|a, b| if least(b) > least(a) { b } else { a }) else {
        return Outcome::skipped(Test::Density, "no direction");
    };
    let total = worst.cells.total;
    let finite = total.value.is_finite();
    let statistic = Statistic::new("int pdf", if finite { total.value } else { f64::INFINITY });
    Outcome::certain(Test::Density, statistic, least(worst) <= 1.0 + EXCESS)
        .at(Place::direction(worst.wo))
        .noted((!finite).then(|| "pdf is infinite or no number somewhere".to_string()))
}

fn counts(found: &[Found]) -> Outcome {
    let ps: Vec<f64> = found.iter().map(|found| found.counts.p).collect();
    let Some(worst) = found.iter().reduce(|a, b| if b.counts.p < a.counts.p { b } else { a }) else {
        return Outcome::skipped(Test::Directions, "no direction");
    };
    let p = smallest(&ps);
    let cell = worst.counts.worst.filter(|_| p < 0.01);
    Outcome::chance(
        Test::Directions,
        Statistic::of("chi2", worst.counts.chi_squared, worst.counts.freedom),
        p,
    )
    .at(Place::direction(worst.wo))
    .noted(cell.map(|cell| format!("most of it: {}", worst.cells.describe(cell))))
}

fn weights(found: &[Found]) -> Outcome {
    let rank = |found: &Found| found.spot.difference / found.spot.allowed;
    let compared: u64 = found.iter().map(|found| found.spot.compared).sum();
    if compared == 0 {
        return Outcome::skipped(
            Test::Weights,
            "no draw has a weight that f and pdf could be compared with",
        );
    }
    let Some(worst) = found.iter().reduce(|a, b| if rank(b) > rank(a) { b } else { a }) else {
        return Outcome::skipped(Test::Weights, "no direction");
    };
    let spot = worst.spot;
    let place = (spot.difference > 0.0).then(|| Place::pair(worst.wo, spot.wi));
    let holds = spot.difference <= spot.allowed;
    Outcome::certain(Test::Weights, Statistic::new("difference", spot.difference), holds)
        .at(place)
        .noted((!holds).then(|| format!("the {} of the draw is not what f and pdf say", spot.what)))
}

/// Compares mean weights with the albedo.
fn albedo(
    bxdf: &dyn Bxdf,
    stated: Option<&Stated<'_>>,
    found: &[Found],
    settings: &Settings,
    source: Source,
) -> Outcome {
    let channels = bxdf.channels().count();
    let mut compared = Vec::new();
    let mut refused = None;
    for (index, found) in found.iter().enumerate() {
        let above = found.wo.z > 0.0;
        let phi = found.wo.y.atan2(found.wo.x);
        let truth = match stated.filter(|_| above) {
            Some(stated) => stated(found.wo.z, phi)
                .map(|estimate| Truth {
                    value: estimate.value,
                    error: estimate.error,
                    deviation: DVec3::ZERO,
                })
                .map_err(|error| error.to_string()),
            None => other_sampling(bxdf, found.wo, settings, source.part("other").number(index)),
        };
        let truth = match truth {
            Ok(truth) => truth,
            Err(reason) => {
                refused.get_or_insert(reason);
                continue;
            }
        };
        let mean = found.moments.mean();
        let allowed = truth.error + bxdf.albedo_error(found.wo.z.abs()) + truth.value.abs() * ROUNDING;
        let spreads = Spread::of(&found.moments);
        let spreads = [0, 1, 2].map(|channel| {
            let deviation = truth.deviation[channel];
            spreads[channel].with(Spread { deviation, unseen: 0.0 })
        });
        let difference = mean - truth.value;
        let p = channels_p(spreads, difference.abs() - allowed, channels);
        let sign = difference[difference.abs().max_position()].signum();
        compared.push((found.wo, p, sign * score(p), difference));
    }
    let Some(worst) = compared.iter().reduce(|a, b| if b.1 < a.1 { b } else { a }) else {
        return Outcome::skipped(Test::Albedo, refused.unwrap_or_else(|| "no direction".into()));
    };
    let scores: Vec<f64> = compared.iter().map(|(_, _, score, _)| *score).collect();
    let ps: Vec<f64> = compared.iter().map(|(_, p, ..)| *p).collect();
    // three channels share their samples, and a score that is 0 for want of a difference has no sign: only conservative
    let p = smallest(&[smallest(&ps), common_sign(&scores)]);
    let (wo, _, score, difference) = *worst;
    let off = difference[difference.abs().max_position()];
    let missing = (compared.len() < found.len()).then(|| {
        let left = found.len() - compared.len();
        format!(
            "{left} of {} directions left out: {}",
            found.len(),
            refused.unwrap_or_default()
        )
    });
    Outcome::chance(Test::Albedo, Statistic::of("max z", score, compared.len() as u64), p)
        .at(Place::direction(wo))
        .noted(if p < 0.01 {
            Some(format!("off by {off:.2e}"))
        } else {
            missing
        })
}

/// An albedo that weights are compared with.
struct Truth {
    value: DVec3,
    error: DVec3,
    deviation: DVec3,
}

/// Factor by which a 99 % interval, over its normal quantile, is widened to stand for a standard error far out: its part for
/// unseen values grows by ln(1e-5)/ln(1e-2) = 2.5 at a level of 1e-5, where the normal part grows by 4.42/2.58 = 1.71.
pub(super) const FAR_OUT: f64 = 1.47;

/// Two-sided quantile of the normal distribution at 99 %.
pub(super) const Z99: f64 = 2.575_829_303_548_901;

/// The albedo by a sampling that is not the model's own.
fn other_sampling(bxdf: &dyn Bxdf, wo: DVec3, settings: &Settings, source: Source) -> Result<Truth, String> {
    let samplings = [Sampling::Normals, Sampling::Cosine, Sampling::Uniform];
    let Some(sampling) = samplings.into_iter().find(|sampling| bxdf.supports(*sampling)) else {
        return Err("there is no other way to compute it".into());
    };
    let mut truth = Truth {
        value: DVec3::ZERO,
        error: DVec3::ZERO,
        deviation: DVec3::ZERO,
    };
    for (cell, lobe) in (0..).zip(Lobe::ALL) {
        if !bxdf.flags().contains(lobe.flag()) {
            continue;
        }
        let trial = Trial {
            sampling,
            points: Points::Random,
            lobe,
            outgoing: Outgoing::Fixed(wo),
            samples: Samples::Fixed(settings.samples),
            seed: source.seed(),
            cell,
        };
        let estimate = monte_carlo::estimate(bxdf, trial).map_err(|error| error.to_string())?;
        truth.value += estimate.value;
        // both lobes may share their errors
        truth.deviation += estimate.error * (FAR_OUT / Z99);
    }
    Ok(truth)
}
