//! Light runs the same way back: f(wo, wi) = f(wi, wo), and a specular direction leads back to where it came from.

use super::{Outcome, Place, Settings, Source, Statistic, Test, TransmissionRule};
use crate::bxdf::{Bxdf, BxdfSample, Flags, cosine_hemisphere, other_hemisphere};
use crate::estimate::Lobe;
use crate::geometry::Polar;
use crate::numerics::stream::Stream;
use glam::DVec3;
use rayon::prelude::*;
use std::f64::consts::TAU;

/// Relative difference that is put down to the arithmetic of a model.
const ROUNDING: f64 = 1e-9;

/// How far directions are moved to see what their own rounding does: a few units in the last place.
const NUDGE: f64 = 1e-15;

/// Multiple of the change by [`NUDGE`] that is allowed: a half vector takes some ten roundings.
const NUDGES: f64 = 32.0;

/// f below this is as good as 0: it underflows in one order of the arithmetic and not in the other.
const LEAST: f64 = 1e-200;

/// The share of a difference that rounding of directions explains: `allowed` relative to the values compared.
pub(super) fn allowed(value: DVec3, moved: impl Fn(DVec3) -> DVec3, w: DVec3) -> f64 {
    let mut most: f64 = 0.0;
    // rounding changes the length too, and a half vector is a small difference at grazing angles
    for axis in DVec3::AXES {
        for side in [-NUDGE, NUDGE] {
            most = most.max(difference(value, moved(w + side * axis)));
        }
    }
    ROUNDING + NUDGES * most
}

/// Largest relative difference of any channel; infinite where one is no number.
pub(super) fn difference(a: DVec3, b: DVec3) -> f64 {
    (0..3)
        .map(|channel| {
            let (a, b) = (a[channel], b[channel]);
            let size = a.abs().max(b.abs());
            if a == b || size < LEAST {
                0.0
            } else if (a - b).is_nan() {
                f64::INFINITY
            } else {
                (a - b).abs() / size
            }
        })
        .fold(0.0, f64::max)
}

/// A pair that was compared.
#[derive(Clone, Copy)]
struct Pair {
    wo: DVec3,
    wi: DVec3,
    /// Relative difference, and what of it rounding explains.
    difference: f64,
    allowed: f64,
}

impl Pair {
    fn worse(self, other: Self) -> Self {
        let rank = |pair: &Self| pair.difference / pair.allowed;
        if rank(&other) > rank(&self) { other } else { self }
    }
}

/// A direction above or below, often close to grazing.
fn outgoing(stream: &mut Stream, both: bool) -> DVec3 {
    let u = stream.uniform3();
    let mu = if u[0] < 0.5 {
        2.0 * u[0]
    } else {
        10f64.powf(-8.0 * (u[0] - 0.5))
    };
    let w = Polar::from_cos(mu).direction(TAU * u[1]);
    if both && u[2] < 0.5 { other_hemisphere(w) } else { w }
}

/// Compares f both ways over random pairs: half of them drawn from the lobe, half anywhere.
///
/// A pair differs when rounding of f and of the directions does not explain it, which is measured by moving a direction by
/// 1e-15. Transmitted pairs follow `rule`.
pub fn reciprocity(bxdf: &dyn Bxdf, rule: TransmissionRule, settings: &Settings, source: Source) -> Outcome {
    let flags = bxdf.flags();
    if !flags.intersects(Flags::DIFFUSE | Flags::GLOSSY) {
        return Outcome::skipped(Test::Reciprocity, "all its directions are specular");
    }
    let source = source.part("reciprocity");
    let both = flags.contains(Flags::TRANSMISSION);
    let batch = 256;
    let worst = (0..settings.pairs.div_ceil(batch))
        .into_par_iter()
        .map(|number| {
            let mut stream = source.stream(number);
            let pairs = (0..batch.min(settings.pairs - number * batch)).map(|index| {
                let wo = outgoing(&mut stream, both);
                let wi = if index % 2 == 0 {
                    bxdf.sample_f(wo, stream.uniform3()).wi
                } else {
                    let u = stream.uniform3();
                    let above = cosine_hemisphere([u[0], u[1]]);
                    let here = if wo.z < 0.0 { other_hemisphere(above) } else { above };
                    let across =
                        flags.contains(Flags::TRANSMISSION) && (u[2] < 0.5 || !flags.contains(Flags::REFLECTION));
                    if across { other_hemisphere(here) } else { here }
                };
                compare(bxdf, rule, wo, wi)
            });
            pairs.reduce(Pair::worse)
        })
        .collect::<Vec<_>>();
    let Some(worst) = worst.into_iter().flatten().reduce(Pair::worse) else {
        return Outcome::skipped(Test::Reciprocity, "no pair was drawn");
    };
    let holds = worst.difference <= worst.allowed;
    let statistic = Statistic::new("difference", worst.difference);
    let place = (worst.difference > 0.0).then(|| Place::pair(worst.wo, worst.wi));
    Outcome::certain(Test::Reciprocity, statistic, holds).at(place)
}

/// f of a pair both ways, in units in which they should agree.
fn compare(bxdf: &dyn Bxdf, rule: TransmissionRule, wo: DVec3, wi: DVec3) -> Pair {
    let scale = |from: DVec3, to: DVec3| match rule {
        TransmissionRule::Scaled { eta_above, eta_below } if Lobe::Transmission.holds(from, to) => {
            let eta = if from.z > 0.0 { eta_above } else { eta_below };
            (eta * eta).recip()
        }
        TransmissionRule::Refracted { eta_above, eta_below } if Lobe::Transmission.holds(from, to) => {
            let eta = if from.z > 0.0 { eta_above } else { eta_below };
            eta * eta
        }
        _ => 1.0,
    };
    let forth = bxdf.f(wo, wi) * scale(wo, wi);
    let back = bxdf.f(wi, wo) * scale(wi, wo);
    let difference = difference(forth, back);
    let allowed = if difference <= ROUNDING {
        ROUNDING
    } else {
        let of_wi = allowed(bxdf.f(wo, wi), |moved| bxdf.f(wo, moved), wi);
        of_wi + allowed(bxdf.f(wo, wi), |moved| bxdf.f(moved, wi), wo)
    };
    Pair {
        wo,
        wi,
        difference,
        allowed,
    }
}

/// Directions from which deltas are followed.
const DELTA_DIRECTIONS: u64 = 64;

/// Draws that look for the deltas of a direction; what they miss is left to the other directions.
const DELTA_DRAWS: u64 = 64;

/// Draws that look for the way back, over the probability of the way there: a way back that is ten times rarer is missed
/// once in e^40 searches.
const SEARCH: f64 = 400.0;

/// Probability below which a delta is not followed, for the way back would take too long to find.
const RAREST: f64 = 1e-3;

/// Distance that a direction may miss its origin by, there and back: refraction near its edge loses half the digits.
const MISS: f64 = 1e-6;

/// Follows specular directions and looks for the way back: it has to be there, with the throughput that `rule` says.
///
/// The throughput of a delta is its probability times its weight, int f |cos theta_i| dwi over it alone.
pub fn reciprocity_of_deltas(bxdf: &dyn Bxdf, rule: TransmissionRule, source: Source) -> Outcome {
    let test = Test::ReciprocityOfDeltas;
    if !bxdf.flags().contains(Flags::SPECULAR) {
        return Outcome::skipped(test, "no direction is specular");
    }
    let source = source.part("reciprocity of deltas");
    let both = bxdf.flags().contains(Flags::TRANSMISSION);
    let mut worst: Option<Pair> = None;
    let mut missing = None;
    for number in 0..DELTA_DIRECTIONS {
        let mut stream = source.stream(number);
        let wo = outgoing(&mut stream, both);
        for forth in deltas(bxdf, wo, &mut stream) {
            let throughput = forth.weight * forth.pdf;
            if throughput == DVec3::ZERO || forth.pdf < RAREST {
                continue;
            }
            let draws = (SEARCH / forth.pdf) as u64;
            let scale = |from: DVec3, to: DVec3| match rule {
                TransmissionRule::Scaled { eta_above, eta_below } if Lobe::Transmission.holds(from, to) => {
                    let (here, there) = if from.z > 0.0 {
                        (eta_above, eta_below)
                    } else {
                        (eta_below, eta_above)
                    };
                    (there / here) * (there / here)
                }
                _ => 1.0,
            };
            let back = (0..draws).map(|_| bxdf.sample_f(forth.wi, stream.uniform3()));
            let leads_back = |back: &BxdfSample| back.flags.contains(Flags::SPECULAR) && (back.wi - wo).length() < MISS;
            let pairs = back.filter(leads_back).map(|back| Pair {
                wo,
                wi: forth.wi,
                difference: difference(
                    throughput * scale(wo, forth.wi),
                    back.weight * back.pdf * scale(forth.wi, wo),
                ),
                // the direction comes back with some roundings, in which a Fresnel term near its edge is steep
                allowed: ROUNDING + NUDGES * (back.wi - wo).length().sqrt(),
            });
            // parts of a sum may share a direction: the one that it came by leads back alike
            let mut nearest: Option<Pair> = None;
            for pair in pairs {
                let holds = pair.difference <= pair.allowed;
                if nearest.is_none_or(|nearest| pair.difference < nearest.difference) {
                    nearest = Some(pair);
                }
                if holds {
                    break;
                }
            }
            let Some(pair) = nearest else {
                missing.get_or_insert((wo, forth.wi));
                continue;
            };
            worst = Some(worst.map_or(pair, |worst| worst.worse(pair)));
        }
    }
    if let Some((wo, wi)) = missing {
        return Outcome::certain(test, Statistic::new("difference", f64::INFINITY), false)
            .at(Place::pair(wo, wi))
            .noted("the specular direction does not lead back".to_string());
    }
    let Some(worst) = worst else {
        return Outcome::skipped(test, "no specular direction has any throughput");
    };
    let statistic = Statistic::new("difference", worst.difference);
    let place = (worst.difference > 0.0).then(|| Place::pair(worst.wo, worst.wi));
    Outcome::certain(test, statistic, worst.difference <= worst.allowed).at(place)
}

/// The different deltas among some draws.
fn deltas(bxdf: &dyn Bxdf, wo: DVec3, stream: &mut Stream) -> Vec<BxdfSample> {
    let mut found: Vec<BxdfSample> = Vec::new();
    for _ in 0..DELTA_DRAWS {
        let draw = bxdf.sample_f(wo, stream.uniform3());
        let known = found.iter().any(|other| (other.wi - draw.wi).length() < MISS);
        if draw.flags.contains(Flags::SPECULAR) && !known {
            found.push(draw);
        }
    }
    found
}
