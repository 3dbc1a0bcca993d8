//! Deterministic integration: stated errors hold over the whole legal range, tolerances are met, and evaluations are few.

mod common;

use common::cases::{Dice, aluminium, beckmann, conductor, dielectric, distributions, grooves, methanol, phong, vmf};
use common::rules::{composite, octaves};
use glam::DVec3;
use rayon::prelude::*;
use std::f64::consts::{FRAC_PI_2, PI, TAU};
use whitefurnace::bxdf::{Coupling, DiffuseSpecular, Microfacet, Model};
use whitefurnace::distribution::Isotropic;
use whitefurnace::fresnel::Fresnel;
use whitefurnace::integrate::deterministic::{quadrature, unspent};
use whitefurnace::integrate::{Angles, Estimate, Target};
use whitefurnace::masking::Masking;
use whitefurnace::spectrum::Spectrum;

/// A random material and quantity over the whole legal range.
fn random_case(case: u64) -> (Model, Target) {
    let mut dice = Dice::new(1, case);
    let lobe = dice.microfacet();
    let mu = dice.mu();
    // without masking the limit at the horizon is infinite
    let diverges = lobe.masking == Masking::None && mu == 0.0;
    let hemispherical = dice.uniform() < 0.2 || diverges;
    let quantity = if hemispherical {
        Target::rho_hh()
    } else {
        Target::rho_hd(mu, 0.0)
    };
    (Model::Microfacet(lobe), quantity)
}

/// The finest reference that the integrator itself gives.
fn reference(model: &Model, quantity: Target) -> Estimate {
    // 1e-13 is below what rounding allows for some
    [1e-13, 1e-12]
        .into_iter()
        .find_map(|tolerance| quadrature(model, quantity, tolerance).ok())
        .unwrap_or_else(|| panic!("1e-12 is out of reach for {quantity:?} of {model:?}"))
}

/// |value - reference| <= stated error + error of the reference, for every tolerance and every legal parameter.
#[test]
fn stated_errors_hold_over_the_whole_legal_range() {
    const CASES: u64 = 4000;
    let found: Vec<String> = (0..CASES)
        .into_par_iter()
        .map(|case| {
            let (model, quantity) = random_case(case);
            let mut found = Vec::new();
            let truth = reference(&model, quantity);
            for tolerance in [1e-3, 1e-6, 1e-10] {
                let what = || format!("case {case}: {quantity:?} of {model:?} at {tolerance:e}");
                match quadrature(&model, quantity, tolerance) {
                    Ok(estimate) => {
                        let difference = (estimate.value - truth.value).abs();
                        if difference.cmpgt(estimate.error + truth.error).any() {
                            found.push(format!("{}: {estimate:?}, but {truth:?}", what()));
                        }
                        // without masking values grow like ln(1/mu)/mu, and rounding with them
                        let rounding = match quantity.outgoing {
                            Some(Angles { mu, .. }) if is_unmasked(&model) => {
                                2e-13 / mu + 2e-14 * estimate.value.max_element()
                            }
                            _ => 2e-14,
                        };
                        let error = estimate.error.max_element();
                        if error.is_nan() || error > tolerance + rounding || !estimate.value.is_finite() {
                            found.push(format!("{}: {estimate:?} misses the tolerance", what()));
                        }
                    }
                    Err(error) => found.push(format!("{}: {error}", what())),
                }
            }
            found
        })
        .collect::<Vec<_>>()
        .concat();
    assert!(found.is_empty(), "{} of {CASES}:\n{}", found.len(), found.join("\n"));
}

fn is_unmasked(model: &Model) -> bool {
    matches!(model, Model::Microfacet(lobe) if lobe.masking == Masking::None)
}

/// F for eta + ik with complex arithmetic written out, as in the textbooks.
fn textbook_fresnel(cos: f64, eta: f64, k: f64) -> f64 {
    // n cos_t = sqrt(n^2 - sin^2) = a + ib
    let (re, im) = (eta * eta - k * k - (1.0 - cos * cos), 2.0 * eta * k);
    let modulus = re.hypot(im);
    let (a, b) = (
        (0.5 * (modulus + re)).max(0.0).sqrt(),
        (0.5 * (modulus - re)).max(0.0).sqrt(),
    );
    let norm = |re: f64, im: f64| re * re + im * im;
    let perpendicular = norm(cos - a, b) / norm(cos + a, b);
    // (n^2 cos - n cos_t)/(n^2 cos + n cos_t)
    let (n2_re, n2_im) = ((eta * eta - k * k) * cos, 2.0 * eta * k * cos);
    let parallel = norm(n2_re - a, n2_im - b) / norm(n2_re + a, n2_im + b);
    0.5 * (perpendicular + parallel)
}

/// rho_hd as eq. 33 has it, with vectors written out: int p(h) F V' (o.h)/((n.o)(n.h)) dh over the hemisphere of normals.
fn brute_force(p: impl Fn(f64) -> f64, top: f64, (eta, k): (f64, f64), grooves: bool, mu: f64, panels: usize) -> f64 {
    let sin_o = (1.0 - mu * mu).sqrt();
    composite(0.0, top, panels, |theta| {
        let (s, c) = theta.sin_cos();
        let circle = composite(0.0, PI, panels, |phi| {
            let cos_d = mu * c + sin_o * s * phi.cos();
            let cos_i = 2.0 * cos_d * c - mu;
            if cos_d <= 0.0 || cos_i <= 0.0 {
                return 0.0;
            }
            let masked = if grooves {
                (2.0 * c * mu / cos_d).min(2.0 * c * cos_i / cos_d).min(1.0)
            } else {
                1.0
            };
            textbook_fresnel(cos_d.min(1.0), eta, k) * masked * cos_d / (mu * c)
        });
        2.0 * circle * p(c) * s
    })
}

/// A dense rule that knows nothing of kinks, lobes or segments agrees within what it can resolve.
#[test]
fn values_agree_with_brute_force() {
    let beckmann_p = |m: f64| {
        move |c: f64| {
            let tan2 = 1.0 / (c * c) - 1.0;
            (-tan2 / (m * m)).exp() / (PI * m * m * c.powi(3))
        }
    };
    let vmf_p = |kappa: f64| move |c: f64| kappa / (TAU * (1.0 - (-kappa).exp())) * (kappa * (c - 1.0)).exp();
    let phong_p = |n: f64| move |c: f64| (n + 2.0) / TAU * c.powf(n + 1.0);
    type Density = Box<dyn Fn(f64) -> f64 + Sync>;
    // beyond the given angle the lobe holds less than 1e-12
    let lobes: [(Isotropic, Density, f64); 7] = [
        (vmf(0.5), Box::new(vmf_p(0.5)), FRAC_PI_2),
        (vmf(17.0), Box::new(vmf_p(17.0)), FRAC_PI_2),
        (vmf(1e4), Box::new(vmf_p(1e4)), 0.08),
        (beckmann(0.2), Box::new(beckmann_p(0.2)), 0.85),
        (beckmann(1.0), Box::new(beckmann_p(1.0)), FRAC_PI_2),
        (phong(3.0), Box::new(phong_p(3.0)), FRAC_PI_2),
        (phong(1e4), Box::new(phong_p(1e4)), 0.08),
    ];
    // methanol, aluminium, glass from inside, silver-like
    let indices = [(1.329, 0.0), (0.769, 6.08), (1.0 / 1.5, 0.0), (0.05, 3.3)];
    lobes.par_iter().for_each(|(distribution, p, top)| {
        for (eta, k) in indices {
            for (masking, mu) in [
                (Masking::VGroove, 0.05),
                (Masking::VGroove, 0.3),
                (Masking::VGroove, 0.7),
                (Masking::VGroove, 0.999),
                (Masking::None, 0.3),
                (Masking::None, 0.9),
            ] {
                let lobe = Microfacet::new(Spectrum::grey(1.0), *distribution, masking, conductor(eta, k)).unwrap();
                let stated = quadrature(&Model::Microfacet(lobe), Target::rho_hd(mu, 0.0), 1e-8).unwrap();
                let grooves = masking == Masking::VGroove;
                let coarse = brute_force(p, *top, (eta, k), grooves, mu, 45);
                let fine = brute_force(p, *top, (eta, k), grooves, mu, 90);
                // across kinks the rule is of second order, so that the step to it bounds what is left; 2e-6 are for steps
                // that happen to be small. The square root at the edge of total reflection costs half an order
                let kink = if eta < 1.0 && k == 0.0 { 1e-4 } else { 2e-6 };
                let allowed = (fine - coarse).abs() + kink * fine.max(1.0);
                let difference = (stated.value.x - fine).abs();
                assert!(
                    difference <= allowed + stated.error.x,
                    "{lobe:?} mu {mu}: {} and {fine}, coarse {coarse}",
                    stated.value.x
                );
            }
        }
    });
}

/// Tight tolerances are met for ordinary and for narrow materials, from normal incidence to the horizon.
#[test]
fn ten_digits_are_within_reach() {
    let fresnels = [
        Fresnel::None,
        methanol(),
        aluminium(),
        dielectric(1.0 / 1.5),
        dielectric(1.00029),
        dielectric(1.0),
        conductor(0.05, 3.3),
        Fresnel::conductor_approximate(Spectrum::grey(0.769), Spectrum::grey(6.08)).unwrap(),
        Fresnel::schlick(Spectrum::rgb([0.04, 0.5, 1.0])).unwrap(),
    ];
    let cells: Vec<(Isotropic, Fresnel)> = distributions()
        .into_iter()
        .flat_map(|d| fresnels.map(|fresnel| (d, fresnel)))
        .collect();
    cells.into_par_iter().for_each(|(d, fresnel)| {
        let model = Model::Microfacet(grooves(d, fresnel));
        let directions = [0.0, 1e-300, 1e-9, 1e-5, 1e-2, 0.3, 0.8, 1.0].map(|mu| Target::rho_hd(mu, 0.0));
        for quantity in directions.into_iter().chain([Target::rho_hh()]) {
            let estimate = quadrature(&model, quantity, 1e-10).unwrap();
            assert!(
                estimate.error.max_element() <= 1.0001e-10,
                "{model:?} {quantity:?}: {estimate:?}"
            );
        }
    });
}

/// Evaluations that rho_hd takes at a tolerance of 1e-6; shown by `--nocapture`.
#[test]
fn evaluations_are_few() {
    let lobes = [
        vmf(17.0),
        vmf(1e5),
        vmf(1e12),
        beckmann(0.2),
        beckmann(10.0),
        phong(1e4),
    ];
    let directions = [0.0, 1e-5, 1e-3, 0.03, 0.3, 0.7, 1.0];
    let mut table = Vec::new();
    for (name, fresnel, most, most_of_mean) in [
        ("none", Fresnel::None, 200, 4500),
        ("methanol", methanol(), 3700, 3700),
        ("aluminium", aluminium(), 3700, 3900),
        ("eta 1/1.5", dielectric(1.0 / 1.5), 6500, 9000),
    ] {
        println!("\n{name:>10} mu = {directions:?}, rho_hh");
        for d in lobes {
            let model = Model::Microfacet(grooves(d, fresnel));
            let count = |quantity| quadrature(&model, quantity, 1e-6).unwrap().evaluations;
            let counts = directions.map(|mu| count(Target::rho_hd(mu, 0.0)));
            let mean = count(Target::rho_hh());
            println!("{:>10} {counts:?}, {mean} {d:?}", "");
            table.extend(counts.map(|count| (name, count, most)));
            table.push((name, mean, most_of_mean));
        }
    }
    for (name, count, most) in table {
        assert!(count <= most, "{name}: {count}");
    }
}

/// rho_hh is the cosine-weighted mean of rho_hd: two routes through the code that share little.
#[test]
fn mean_of_directions_is_the_hemispherical_albedo() {
    let cells: Vec<(Isotropic, Fresnel, Masking)> = [vmf(0.0), vmf(17.0), vmf(1024.0), beckmann(0.3), phong(48.0)]
        .into_iter()
        .flat_map(|d| [Fresnel::None, methanol(), aluminium(), dielectric(1.0 / 1.5)].map(|fresnel| (d, fresnel)))
        .flat_map(|(d, fresnel)| [Masking::VGroove, Masking::None].map(|masking| (d, fresnel, masking)))
        .collect();
    cells.into_par_iter().for_each(|(d, fresnel, masking)| {
        let lobe = Microfacet::new(Spectrum::grey(1.0), d, masking, fresnel).unwrap();
        let model = Model::Microfacet(lobe);
        let whole = quadrature(&model, Target::rho_hh(), 1e-9).unwrap().value.x;
        let mean = octaves(1.0, 16, 6, |mu| {
            2.0 * mu * quadrature(&model, Target::rho_hd(mu, 0.0), 1e-8).unwrap().value.x
        });
        // what the octaves leave of the square root at the edge of total reflection; the rest is smooth
        let allowed = if fresnel == dielectric(1.0 / 1.5) { 2e-5 } else { 1e-7 };
        assert!((mean - whole).abs() < allowed, "{model:?}: {mean} and {whole}");
    });
}

/// 1 - rho_hh keeps its digits however little is lost.
///
/// The references are the definition in 30 digits: (1/pi) int p(h) dh int sin theta_d dtheta_d int dphi_d of
/// min(cos theta_d/(n.h), 2 (n.o))+ - min(cos theta_d/(n.h), 2 (n.o), 2 (n.i))+, the azimuth exactly between the roots of
/// the linear comparisons, the rest by tanh-sinh quadrature (mpmath 1.3). For narrow lobes they tend to 1/kappa.
#[test]
fn lost_energy_keeps_its_digits() {
    for (kappa, lost) in [
        (17.0, 0.067_091_973_135_900_87),
        (1e3, 0.001_002_006_024_120_725_1),
        (1e6, 1.000_002_000_006e-6),
        (1e12, 1.000_000_000_002e-12),
    ] {
        let lobe = Model::Microfacet(grooves(vmf(kappa), Fresnel::None));
        let one = Spectrum::grey(1.0);
        let coupled = DiffuseSpecular::new(lobe, one, one, Coupling::EnergyPreserving).unwrap();
        for tolerance in [1e-6, 1e-10] {
            let found = unspent(&coupled, tolerance).unwrap();
            let difference = (found.value.x - lost).abs();
            // the tolerance is relative to the squared width, ln 4/kappa
            assert!(
                found.error.x <= 2.0 * tolerance * lost.max(1.0 / kappa),
                "{kappa} {found:?}"
            );
            assert!(
                difference <= found.error.x + 1e-13 * lost,
                "{kappa}: {found:?} and {lost:e}"
            );
        }
    }
}

/// A grey term in three equal channels costs and gives the same as in one.
#[test]
fn channels_do_not_disturb_each_other() {
    let rgb = Fresnel::dielectric(Spectrum::rgb([1.329, 1.5, 0.7])).unwrap();
    for mu in [0.0, 1e-3, 0.4, 1.0] {
        let together = quadrature(
            &Model::Microfacet(grooves(vmf(50.0), rgb)),
            Target::rho_hd(mu, 0.0),
            1e-9,
        )
        .unwrap();
        let alone = [1.329, 1.5, 0.7].map(|eta| {
            let model = Model::Microfacet(grooves(vmf(50.0), dielectric(eta)));
            quadrature(&model, Target::rho_hd(mu, 0.0), 1e-9).unwrap().value.x
        });
        let difference = (together.value - DVec3::from_array(alone)).abs().max_element();
        assert!(difference <= 2e-9, "{mu}: {difference:e}"); // both tolerances
    }
}
