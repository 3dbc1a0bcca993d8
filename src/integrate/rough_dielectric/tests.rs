//! The rules against each other, and against integrals over the directions of light instead of the facets.

use super::*;
use crate::bxdf::{Bxdf, Media, Transport};
use crate::distribution::Family;
use crate::geometry::Polar;
use crate::numerics::quadrature::{Piece, integrate};
use crate::numerics::stream::{Stream, StreamId};
use rayon::prelude::*;
use std::f64::consts::PI;

fn stream(seed: u64, cell: u64) -> Stream {
    Stream::new(StreamId { seed, cell, batch: 0 })
}

struct Case {
    family: Family,
    alpha: f64,
    masking: Masking,
    eta: f64,
    mu: f64,
}

impl Case {
    fn random(number: u64, least_alpha: f64) -> Self {
        let mut random = stream(5, number);
        let family = [Family::Ggx, Family::Beckmann][number as usize % 2];
        let masking = [Masking::Smith, Masking::SmithCorrelated][number as usize / 2 % 2];
        let exponent = least_alpha.log10();
        let alpha = 10f64.powf(exponent + (1.0 - exponent) * random.uniform());
        let eta = match random.uniform() {
            u if u < 0.35 => 1.0 + 1.5 * random.uniform(),
            u if u < 0.7 => (1.0 + 1.5 * random.uniform()).recip(),
            u if u < 0.8 => 1.0 + (random.uniform() - 0.5) * 10f64.powf(-5.0 * random.uniform()),
            _ => 10f64.powf(3.0 * random.uniform() - 1.5),
        };
        let mu = match random.uniform() {
            u if u < 0.5 => random.uniform(),
            u if u < 0.7 => 10f64.powf(-6.0 * random.uniform()),
            // near the edge of total reflection of smooth facets
            u if u < 0.9 && eta < 1.0 => {
                let edge = ((1.0 - eta) * (1.0 + eta)).sqrt();
                (edge + alpha * 4.0 * (random.uniform() - 0.5)).clamp(0.0, 1.0)
            }
            u if u < 0.95 => 1.0,
            _ => 0.0,
        };
        Self {
            family,
            alpha: alpha.min(10.0),
            masking,
            eta,
            mu,
        }
    }

    fn interface(&self) -> RoughInterface {
        RoughInterface::new(self.family.with(self.alpha).unwrap(), self.masking, self.eta).unwrap()
    }

    fn glass(&self) -> RoughDielectric {
        let media = Media {
            eta_a: 1.0,
            eta_b: self.eta,
            transport: Transport::Importance,
        };
        let white = Spectrum::grey(1.0);
        RoughDielectric::new(white, white, self.family.with(self.alpha).unwrap(), self.masking, media).unwrap()
    }

    fn say(&self) -> String {
        let Self {
            family,
            alpha,
            masking,
            eta,
            mu,
        } = self;
        format!("{family:?} {alpha:e} {masking:?} eta {eta} mu {mu:e}")
    }
}

/// What a table over mu and sqrt(alpha) costs; evaluations, and with --nocapture the time.
#[test]
fn tables_take_some_thousand_evaluations_a_texel() {
    for (family, masking) in [
        (Family::Ggx, Masking::SmithCorrelated),
        (Family::Beckmann, Masking::Smith),
    ] {
        for eta in [1.5, 1.5f64.recip()] {
            for (tolerance, most) in [(1e-4, 5000), (1e-5, 8000)] {
                let start = std::time::Instant::now();
                let mut evaluations = 0;
                for i in 0..16 {
                    for j in 0..16 {
                        let alpha = ((f64::from(j) + 0.5) / 16.0).powi(2).max(0.0025);
                        let mu = (f64::from(i) + 0.5) / 16.0;
                        let of = RoughInterface::new(family.with(alpha).unwrap(), masking, eta).unwrap();
                        evaluations += of.albedos(mu, tolerance).unwrap().evaluations;
                    }
                }
                let mean = evaluations / 256;
                let time = start.elapsed().as_secs_f64() * 1e6 / 256.0;
                eprintln!("{family:?} eta {eta:.3} to {tolerance:e}: {mean} evaluations, {time:.1} us");
                assert!(
                    mean < most,
                    "{family:?} eta {eta:.3} to {tolerance:e}: {mean} evaluations"
                );
            }
        }
    }
}

/// The adaptive rules stay within what the fixed ones state, everywhere.
#[test]
fn stated_errors_hold_for_random_interfaces() {
    let wrong: Vec<String> = (0..3000u64)
        .into_par_iter()
        .flat_map(|number| {
            let case = Case::random(number, 1e-6);
            let of = case.interface();
            let tolerance = 10f64.powf(-3.0 - 4.0 * stream(6, number).uniform());
            let ways = match of.facets.eta > 1.0 {
                true => [Way::Reflected, Way::Refracted],
                false => [Way::Missing, Way::Refracted],
            };
            ways.into_iter()
                .filter_map(|way| {
                    let finest = (1e-2 * tolerance).max(1e-9);
                    let view = View::new(of.facets, way, case.mu, TAIL_SHARE * finest);
                    let truth = rules::adaptive(&view, finest).map(|truth| truth.bounded);
                    let found = of.along(way, case.mu, tolerance);
                    let (Ok(truth), Ok(found)) = (&truth, &found) else {
                        return Some(format!("{} {way:?} to {tolerance:e}: {truth:?} {found:?}", case.say()));
                    };
                    let (a, b) = (found.bounded, *truth);
                    let beyond = (a.value.x - b.value.x).abs() - a.error.x - b.error.x - TAIL_SHARE * finest;
                    let fails = beyond > 0.0 || a.error.x > tolerance || !a.value.is_finite();
                    fails.then(|| format!("{} {way:?} to {tolerance:e}: {a:?} {b:?}", case.say()))
                })
                .collect::<Vec<_>>()
        })
        .collect();
    assert!(wrong.is_empty(), "{}:\n{}", wrong.len(), wrong.join("\n"));
}

/// int f |cos theta_i| dwi over a hemisphere, of which the refracted part ends at the cone of total reflection.
fn over_directions(glass: &RoughDielectric, lobe: Lobe, mu: f64, tolerance: f64) -> Option<Bounded> {
    let wo = Polar::from_cos(mu).direction(0.0);
    let sign = if lobe == Lobe::Reflection { 1.0 } else { -1.0 };
    let middle = Polar::from_cos(mu).sin
        * if lobe == Lobe::Reflection {
            1.0
        } else {
            glass.eta().recip()
        };
    let eta = glass.eta();
    let sin_o = Polar::from_cos(mu).sin;
    let mut cuts = vec![0.0, 1.0];
    // of cos theta_i: around the mirrored or refracted direction, and where n.h = 0
    if middle < 1.0 {
        let centre = (1.0 - middle * middle).sqrt();
        cuts.extend([centre, 0.9 * centre, 0.5 * (1.0 + centre)]);
    }
    if lobe == Lobe::Transmission && mu < eta {
        cuts.extend([0.3, 1.0, 3.0].map(|factor| factor * mu / eta));
    }
    // o.i where F reaches 1: of light that is refracted, o.h = 0 or i.h = 0
    let edge = match lobe {
        Lobe::Transmission => -eta.min(eta.recip()),
        Lobe::Reflection => 1.0 - 2.0 * eta * eta,
    };
    // where that meets phi = 0 and phi = pi: cos(theta_o -+ theta_i) = edge
    for sign_s in [1.0, -1.0] {
        let theta = edge.acos() + sign_s * mu.acos();
        cuts.push(theta.cos().abs());
    }
    cuts.retain(|cut| (0.0..=1.0).contains(cut));
    cuts.sort_by(f64::total_cmp);
    cuts.dedup_by(|a, b| *a - *b < 1e-9);
    let outer: Vec<Piece> = cuts
        .windows(2)
        .map(|w| Piece::kinked(w[0], w[1], true, true).careful())
        .collect();
    let found = integrate(&outer, 0.5 * tolerance, 4000, |cos| {
        let above = Polar::from_cos(cos);
        let cos_phi = (edge - mu * sign * cos) / (sin_o * above.sin);
        let mut cuts = vec![0.0, 0.2, 1.0, 2.1, PI - 0.2, PI];
        if cos_phi.abs() < 1.0 {
            cuts.push(cos_phi.acos());
        }
        cuts.sort_by(f64::total_cmp);
        let inner: Vec<Piece> = cuts
            .windows(2)
            .map(|w| Piece::kinked(w[0], w[1], true, true).careful())
            .collect();
        let around = integrate(&inner, 0.1 * tolerance, 20_000, |phi| {
            let wi = above.direction(phi);
            let wi = DVec3::new(wi.x, wi.y, sign * wi.z);
            Bounded::exact(2.0 * glass.f(wo, wi) * cos)
        });
        around.map_or(Bounded::exact(DVec3::NAN), |around| around.bounded)
    });
    found.ok().map(|found| found.bounded)
}

#[test]
fn integrals_over_directions_agree() {
    let compared: Vec<usize> = (0..160u64)
        .into_par_iter()
        .map(|number| {
            let mut case = Case::random(number, 0.15);
            case.mu = case.mu.max(1e-3);
            if (case.eta - 1.0).abs() < 0.05 || !(0.2..5.0).contains(&case.eta) {
                return 0;
            }
            let mut count = 0;
            for lobe in Lobe::ALL {
                let Some(truth) = over_directions(&case.glass(), lobe, case.mu, 1e-6) else {
                    continue;
                };
                let found = case.interface().rho_hd(lobe, case.mu, 1e-6).unwrap().bounded;
                let difference = (found.value.x - truth.value.x).abs();
                assert!(
                    difference <= found.error.x + truth.error.x,
                    "{} {lobe:?}: {found:?} {truth:?}",
                    case.say()
                );
                count += 1;
            }
            count
        })
        .collect();
    let compared: usize = compared.iter().sum();
    assert!(compared > 150, "only {compared}");
}

/// The mean weight of the sampler, of lobes that are too narrow for integrals over directions.
#[test]
fn samples_of_narrow_lobes_agree() {
    (0..64u64).into_par_iter().for_each(|number| {
        let mut case = Case::random(number, 1e-6);
        if (case.eta - 1.0).abs() < 1e-6 {
            case.eta = 1.3;
        }
        let glass = case.glass();
        let wo = Polar::from_cos(case.mu).direction(0.3);
        let mut random = stream(7, number);
        let count = 40_000;
        let (mut sums, mut squares) = ([0.0; 2], [0.0; 2]);
        for _ in 0..count {
            let draw = glass.sample_f(wo, random.uniform3());
            let side = usize::from(draw.wi.z < 0.0);
            sums[side] += draw.weight.x;
            squares[side] += draw.weight.x * draw.weight.x;
        }
        for (side, lobe) in Lobe::ALL.into_iter().enumerate() {
            let mean = sums[side] / f64::from(count);
            let spread = ((squares[side] / f64::from(count) - mean * mean).max(0.0) / f64::from(count)).sqrt();
            let found = case.interface().rho_hd(lobe, case.mu, 1e-6).unwrap().bounded.value.x;
            // five standard deviations of 128 normal variables, and a sample that may be missing
            let allowed = 5.0 * spread + 10.0 / f64::from(count);
            assert!(
                (found - mean).abs() < allowed,
                "{} {lobe:?}: {found} {mean} {spread}",
                case.say()
            );
        }
    });
}

/// alpha -> 0 is the smooth interface, but within a few alpha of the edge of total reflection and of the horizon.
#[test]
fn narrow_lobes_are_smooth_interfaces() {
    for eta in [1.5, 1.0 / 1.5, 1.00029, 0.9, 30.0] {
        for mu in [1.0, 0.9, 0.4, 0.1] {
            let fresnel = crate::fresnel::dielectric(mu, eta);
            for family in [Family::Ggx, Family::Beckmann] {
                let of = RoughInterface::new(family.with(1e-6).unwrap(), Masking::SmithCorrelated, eta).unwrap();
                let found = of.albedos(mu, 1e-8).unwrap();
                // of the order of alpha where F has a slope
                assert!(
                    (found.reflected - fresnel).abs() < 2e-6,
                    "{eta} {mu}: {found:?} {fresnel}"
                );
                assert!(
                    (found.transmitted + fresnel - 1.0).abs() < 2e-6,
                    "{eta} {mu}: {found:?} {fresnel}"
                );
            }
        }
    }
}

#[test]
fn matched_indices_are_the_limit() {
    for masking in [Masking::Smith, Masking::SmithCorrelated] {
        for mu in [0.05, 0.2, 1.0] {
            let at = |eta| {
                let of = RoughInterface::new(Family::Ggx.with(0.5).unwrap(), masking, eta).unwrap();
                of.albedos(mu, 1e-7).unwrap()
            };
            let limit = at(1.0);
            assert_eq!(limit.reflected, 0.0);
            let near = at(1.0 + 1e-6);
            // F and the bend vanish like eta - 1, but for facets that are seen at less than its root
            assert!(
                (near.transmitted - limit.transmitted).abs() < 1e-4,
                "{mu}: {near:?} {limit:?}"
            );
        }
    }
}
