//! The fast rules against the adaptive ones of facets, over the whole legal range.

use super::*;
use crate::distribution::Family;
use crate::integrate::facets;
use crate::numerics::stream::{Stream, StreamId};
use crate::spectrum::Spectrum;
use rayon::prelude::*;

fn grey(value: f64) -> Spectrum {
    Spectrum::grey(value)
}

fn lobe(family: Family, alpha: f64, masking: Masking, fresnel: Fresnel) -> Microfacet {
    Microfacet::new(grey(1.0), family.with(alpha).unwrap(), masking, fresnel).unwrap()
}

struct Case {
    microfacet: Microfacet,
    mu: f64,
    tolerance: f64,
}

/// A random lobe, direction and tolerance.
fn case(number: u64, fresnel: impl Fn(&mut Stream) -> Fresnel) -> Case {
    let mut random = Stream::new(StreamId {
        seed: 11,
        cell: number,
        batch: 0,
    });
    let family = [Family::Ggx, Family::Beckmann][number as usize % 2];
    let masking = [Masking::Smith, Masking::SmithCorrelated][number as usize / 2 % 2];
    let mu = match random.uniform() {
        u if u < 0.4 => random.uniform(),
        u if u < 0.6 => 10f64.powf(-4.0 * random.uniform()),
        u if u < 0.95 => 10f64.powf(-12.0 * random.uniform()),
        u if u < 0.975 => 0.0,
        _ => 1.0,
    };
    let alpha = match random.uniform() {
        u if u < 0.5 => 10f64.powf(-6.0 + 7.0 * random.uniform()),
        _ => random.uniform().powi(2).max(1e-6),
    };
    let fresnel = fresnel(&mut random);
    Case {
        microfacet: lobe(family, alpha.min(10.0), masking, fresnel),
        mu,
        tolerance: 10f64.powf(-3.0 - 8.0 * random.uniform()),
    }
}

/// What is wrong with the stated error of a case: the truth lies outside, or the tolerance was missed. And whether the rules
/// took it.
fn judge(number: u64, case: &Case) -> (bool, Option<String>) {
    let Case {
        microfacet,
        mu,
        tolerance,
    } = *case;
    let Some(found) = rho_hd(&microfacet, mu, tolerance) else {
        return (false, None);
    };
    let finest = (1e-2 * tolerance).clamp(1e-11, 1e-6);
    let truth = facets::rho_hd(&microfacet, mu, 0.0, finest).unwrap().bounded;
    let Bounded { value, error } = found.bounded;
    let beyond = ((value - truth.value).abs() - error - truth.error).max_element();
    let wrong = beyond > 0.0 || !(error.max_element() <= tolerance) || !value.is_finite();
    let said = || format!("case {number}: mu {mu:e} of {microfacet:?} at {tolerance:e}: {found:?}, but {truth:?}");
    (true, wrong.then(said))
}

fn judge_all(count: u64, least_share: f64, fresnel: impl Fn(&mut Stream) -> Fresnel + Sync) {
    let judged: Vec<(bool, Option<String>)> = (0..count)
        .into_par_iter()
        .map(|number| judge(number, &case(number, &fresnel)))
        .collect();
    let taken = judged.iter().filter(|(taken, _)| *taken).count();
    let found: Vec<String> = judged.into_iter().filter_map(|(_, found)| found).collect();
    assert!(found.is_empty(), "{} of {count}:\n{}", found.len(), found.join("\n"));
    assert!(taken as f64 > least_share * count as f64, "only {taken} of {count}");
}

#[test]
fn stated_errors_hold_for_random_lobes() {
    judge_all(6000, 0.75, |_| Fresnel::None);
}

#[test]
fn stated_errors_hold_under_fresnel_terms() {
    judge_all(1000, 0.4, |random| {
        let channels = [0; 3].map(|_| 10f64.powf(random.uniform()));
        let k = [0; 3].map(|_| 4.0 * random.uniform());
        match (5.0 * random.uniform()) as u64 {
            0 => Fresnel::schlick(Spectrum::rgb([0.0, random.uniform(), 1.0])).unwrap(),
            1 => Fresnel::dielectric(grey(channels[0])).unwrap(),
            2 => Fresnel::dielectric(Spectrum::rgb(channels)).unwrap(),
            3 => Fresnel::conductor(Spectrum::rgb(channels), Spectrum::rgb(k)).unwrap(),
            _ => Fresnel::conductor_approximate(grey(channels[0]), grey(k[0])).unwrap(),
        }
    });
}

/// Edges of total reflection could hide between the nodes; the limit at the horizon and the finest tolerances have no rule.
#[test]
fn what_is_out_of_reach_is_left_to_facets() {
    let water = Fresnel::dielectric(grey(0.75)).unwrap();
    let smooth = lobe(Family::Ggx, 0.3, Masking::SmithCorrelated, Fresnel::None);
    let edged = lobe(Family::Ggx, 0.3, Masking::SmithCorrelated, water);
    assert!(rho_hd(&smooth, 0.5, 1e-6).is_some());
    assert!(rho_hd(&edged, 0.5, 1e-6).is_none());
    assert!(rho_hd(&smooth, 0.0, 1e-6).is_none());
    assert!(rho_hd(&smooth, 0.5, 1e-13).is_none());
    let grooves = lobe(Family::Ggx, 0.3, Masking::VGroove, Fresnel::None);
    assert!(rho_hd(&grooves, 0.5, 1e-6).is_none());
}

/// A 64 x 64 table at its texel centres, over mu and sqrt(alpha): all of it is within reach, at the stated cost.
#[test]
fn tables_take_some_hundred_evaluations_a_texel() {
    for (family, tolerance, most) in [
        (Family::Ggx, 1e-4, 180),
        (Family::Ggx, 1e-6, 380),
        (Family::Beckmann, 1e-4, 240),
        (Family::Beckmann, 1e-6, 500),
    ] {
        let centre = |i: u32| (f64::from(i) + 0.5) / 64.0;
        let mut evaluations = 0;
        for i in 0..64 {
            for j in 0..64 {
                let lobe = lobe(family, centre(j).powi(2), Masking::SmithCorrelated, Fresnel::None);
                evaluations += rho_hd(&lobe, centre(i), tolerance).unwrap().evaluations;
            }
        }
        let mean = evaluations / 4096;
        assert!(mean < most, "{family:?} to {tolerance:e}: {mean} evaluations a texel");
    }
}

/// Degrees of exactness 2 n - 1 on [0, 1], and the last coefficients of the polynomials that they stand for.
#[test]
fn gauss_legendre_rules_are_exact() {
    for n in [4, 8, 36, 256] {
        let rule = legendre(n);
        for k in [0, 1, n, 2 * n - 1] {
            let sum: f64 = rule
                .nodes
                .iter()
                .zip(&rule.weights)
                .map(|(x, w)| w * x.powi(k as i32))
                .sum();
            let exact = 1.0 / (k as f64 + 1.0);
            // roundings of n weights that add up to 1
            assert!((sum - exact).abs() < 4e-15, "{n}, x^{k}: {sum}");
        }
        // int P_k^2 = 1/(2 k + 1)
        for (back, last) in rule.last.iter().enumerate() {
            let k = (n - 1 - back) as f64;
            let norm: f64 = last.iter().zip(&rule.weights).map(|(l, w)| l * l / w).sum();
            assert!((norm - 1.0).abs() < 1e-13, "{n}, {k}: {norm}"); // roundings of n steps of the recurrence
        }
    }
}

/// Trapezoidal rules hold cos(k psi) for k < 2 N, and tell the last two of them apart.
#[test]
fn circles_hold_their_cosines() {
    for n in [2, 10, 128] {
        let rule = circle(n);
        let cosine = |k: usize, j: usize| (PI * (k * j) as f64 / n as f64).cos();
        let sum = |weights: &[f64], k: usize| (0..=n).map(|j| weights[j] * cosine(k, j)).sum::<f64>();
        for k in 0..2 * n {
            let mean = sum(&rule.weights, k);
            assert!((mean - f64::from(u8::from(k == 0))).abs() < 1e-13, "{n}, {k}: {mean}"); // roundings of k j
        }
        for (back, last) in rule.last.iter().enumerate() {
            for k in 0..=n {
                let expected = f64::from(u8::from(k == n - back));
                assert!((sum(last, k) - expected).abs() < 1e-13, "{n}, {k} by {back}");
            }
        }
    }
}
