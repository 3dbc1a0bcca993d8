//! Monte Carlo integration: estimates agree with quadrature, and stated intervals cover.
//!
//! Every test of a hypothesis belongs to one family per function, whose significance is shared out beforehand.

mod common;

use common::cases::{
    aluminium, beckmann, beckmann_xy, conductor, dielectric, ggx, grooves, methanol, phong, smith, vmf,
};
use common::statistics::{coverage_p, kolmogorov_p, sidak, squares_p};
use common::wrong::{Mistake, Wrong};
use glam::DVec3;
use rayon::prelude::*;
use std::path::Path;
use std::sync::Arc;
use whitefurnace::bxdf::{
    Bxdf, Coupling, DiffuseSpecular, FresnelBlend, FresnelSpecular, Irregular, Microfacet, Model, Sampling, Transport,
    cosine_hemisphere,
};
use whitefurnace::fresnel::Fresnel;
use whitefurnace::integrate::deterministic::quadrature;
use whitefurnace::integrate::monte_carlo::{CONFIDENCE, Outgoing, Samples, Trial, estimate, outgoing};
use whitefurnace::integrate::{Effort, Estimate, Estimator, IntegrateError, Integrator, Lobe, Target, coupled_bxdf};
use whitefurnace::masking::Masking;
use whitefurnace::measured::irregular::IrregularSamples;
use whitefurnace::numerics::moments::Moments;
use whitefurnace::numerics::points::Points;
use whitefurnace::numerics::stream::{Stream, StreamId};
use whitefurnace::spectrum::Spectrum;

fn stream(seed: u64, cell: u64) -> Stream {
    Stream::new(StreamId { seed, cell, batch: 0 })
}

/// rho_hd to 1e-9, far below what any sample resolves.
fn rho(lobe: &Microfacet, mu: f64) -> f64 {
    quadrature(&Model::Microfacet(*lobe), Target::rho_hd(mu, 0.0), 1e-9)
        .unwrap()
        .value
        .x
}

/// Lobes wide enough that every sampling hits them.
fn wide_lobes() -> Vec<Microfacet> {
    vec![
        grooves(vmf(0.0), methanol()),
        grooves(vmf(17.0), methanol()),
        grooves(beckmann(0.3), aluminium()),
        grooves(beckmann(2.0), Fresnel::None),
        grooves(phong(20.0), dielectric(1.0 / 1.5)),
        Microfacet::new(Spectrum::grey(0.5), phong(10.0), Masking::None, aluminium()).unwrap(),
    ]
}

const SAMPLES: u64 = 1 << 14;

/// Standard error of a mean of [`SAMPLES`], from a quarter of a million samples of its own: to
/// 0.2 % of itself where weights have no tails.
///
/// The stated error is wider, by what may not have been seen; it is tested by its coverage.
fn standard_error(bxdf: &dyn Bxdf, sampling: Sampling, outgoing: Outgoing, seed: u64) -> DVec3 {
    let batches: Vec<Moments> = (0..16)
        .into_par_iter()
        .map(|cell| {
            let mut moments = Moments::default();
            let mut random = stream(seed, 1_000_000 + cell);
            for _ in 0..1 << 14 {
                let wo = match outgoing {
                    Outgoing::Fixed(wo) => wo,
                    Outgoing::Cosine => cosine_hemisphere([random.uniform(), random.uniform()]),
                };
                moments.push(bxdf.sample(sampling, wo, random.uniform3()).weight);
            }
            moments
        })
        .collect();
    let all = batches.into_iter().fold(Moments::default(), Moments::merge);
    (all.variance() / SAMPLES as f64).powf(0.5)
}

/// (value - reference)/(standard error) of independent cells.
fn z_scores(bxdf: &dyn Bxdf, sampling: Sampling, mu: f64, truth: f64, cells: u64, seed: u64) -> Vec<f64> {
    // f depends on the difference of azimuths alone
    let error = standard_error(bxdf, sampling, outgoing(mu, 0.0), seed).x;
    (0..cells)
        .into_par_iter()
        .map(|cell| {
            let wo = outgoing(mu, 0.1 * cell as f64);
            let found = estimate(
                bxdf,
                Trial {
                    sampling,
                    points: Points::Random,
                    lobe: Lobe::Reflection,
                    outgoing: wo,
                    samples: Samples::Fixed(SAMPLES),
                    seed,
                    cell,
                },
            )
            .unwrap();
            (found.value.x - truth) / error
        })
        .collect()
}

/// Smallest probability of the two tests of z being standard normal.
fn normality(z: &[f64]) -> f64 {
    2.0 * squares_p(z).min(kolmogorov_p(z)) // either may fail
}

/// Differences from quadrature are standard normal in units of the stated error.
#[test]
fn every_estimator_agrees_with_quadrature() {
    let level = sidak(Sampling::ALL.len());
    for (index, sampling) in Sampling::ALL.into_iter().enumerate() {
        let mut z = Vec::new();
        for (material, lobe) in wide_lobes().iter().enumerate() {
            for (direction, mu) in [0.3, 0.7, 0.95].into_iter().enumerate() {
                let seed = (100 * index + 10 * material + direction) as u64;
                z.extend(z_scores(lobe, sampling, mu, rho(lobe, mu), 16, seed));
            }
        }
        let p = normality(&z);
        println!("{sampling:?}: {} cells, p = {p:.3}", z.len());
        assert!(p > level, "{sampling:?}: p = {p:e}");
    }
}

/// The same test rejects models that are wrong, and passes the right one that they are made of.
#[test]
fn wrong_models_are_rejected() {
    let lobe = grooves(vmf(17.0), methanol());
    let other = grooves(vmf(20.0), methanol());
    let mu = 0.3;
    let truth = rho(&lobe, mu);
    let level = sidak(5);
    for (mistake, passes) in [
        (Mistake::Nothing, true),
        (Mistake::Jacobian, false),
        (Mistake::Gain, false),
        (Mistake::AbsoluteMasking, false),
        (Mistake::Density(other), false),
    ] {
        let wrong = Wrong { lobe, mistake };
        let z = z_scores(&wrong, Sampling::Normals, mu, truth, 400, 7);
        let p = normality(&z);
        println!("{mistake:?}: p = {p:e}");
        assert_eq!(p > level, passes, "{mistake:?}: p = {p:e}");
    }
}

/// Cells whose intervals are counted.
#[derive(Default)]
struct Coverage {
    stated: u64,
    covered: u64,
    refused: u64,
}

impl Coverage {
    fn and(self, other: Self) -> Self {
        Self {
            stated: self.stated + other.stated,
            covered: self.covered + other.covered,
            refused: self.refused + other.refused,
        }
    }
}

fn coverage(estimates: impl ParallelIterator<Item = (Result<Estimate, IntegrateError>, f64)>) -> Coverage {
    estimates
        .map(|(estimate, truth)| match estimate {
            Ok(found) => Coverage {
                stated: 1,
                covered: u64::from((found.value.x - truth).abs() <= found.error.x + 1e-9), // of the reference
                refused: 0,
            },
            Err(IntegrateError::TooFewHits { .. } | IntegrateError::TooManySamples { .. }) => Coverage {
                refused: 1,
                ..Coverage::default()
            },
            Err(error) => panic!("{error}"),
        })
        .reduce(Coverage::default, Coverage::and)
}

/// Wide lobes, and narrow ones that uniform directions hardly ever hit, down to the horizon.
fn all_lobes() -> Vec<Microfacet> {
    let mut lobes = wide_lobes();
    lobes.extend([
        grooves(vmf(200.0), methanol()),
        grooves(phong(1000.0), Fresnel::None),
        grooves(vmf(5000.0), aluminium()),
        grooves(beckmann(1e-3), methanol()),
    ]);
    lobes
}

/// A model with its integral to 1e-9, far below what any sample resolves.
struct Case {
    bxdf: Box<dyn Bxdf + Send>,
    outgoing: Outgoing,
    truth: f64,
}

/// rho_hd from grazing to steep, and rho_hh, of lobes of every width, of a coat, and of couplings.
fn cases() -> Vec<Case> {
    let smith =
        |alpha| Microfacet::new(Spectrum::grey(1.0), ggx(alpha), Masking::SmithCorrelated, Fresnel::None).unwrap();
    let mut lobes = all_lobes();
    // at 1e-2 and below, what is lost far off the lobe is as rare as one in ten thousand
    lobes.extend([1.5, 0.3, 0.05, 1e-2, 1e-3].map(smith));
    let mut models: Vec<Model> = lobes.into_iter().map(Model::Microfacet).collect();
    for kappa in [10.0, 3000.0] {
        let coat = FresnelBlend::new(Spectrum::grey(0.4), Spectrum::grey(0.1), phong(kappa)).unwrap();
        models.push(Model::FresnelBlend(coat));
    }
    let lobe = grooves(vmf(17.0), methanol());
    let (ks, kd) = (Spectrum::grey(0.9), Spectrum::grey(0.7));
    let coupled = DiffuseSpecular::new(Model::Microfacet(lobe), ks, kd, Coupling::Mikkelsen).unwrap();
    models.push(Model::DiffuseSpecular(Box::new(coupled)));
    let mut cases = Vec::new();
    let places = [0.01, 0.1, 0.5, 0.9].map(Some).into_iter().chain([None]);
    for (mu, model) in places.flat_map(|mu| models.iter().map(move |model| (mu, model))) {
        let (outgoing, target) = match mu {
            Some(mu) => (outgoing(mu, 0.2), Target::rho_hd(mu, 0.2)),
            None => (Outgoing::Cosine, Target::rho_hh()),
        };
        let Ok(truth) = quadrature(model, target, 1e-9) else {
            continue; // unmasked lobes have no mean
        };
        cases.push(Case {
            bxdf: boxed(model),
            outgoing,
            truth: truth.value.x,
        });
    }
    cases
}

fn boxed(model: &Model) -> Box<dyn Bxdf + Send> {
    match model {
        Model::Microfacet(lobe) => Box::new(*lobe),
        Model::FresnelBlend(coat) => Box::new(*coat),
        Model::DiffuseSpecular(coupled) => match coupled.specular() {
            Model::Microfacet(lobe) => Box::new(coupled_bxdf(coupled, *lobe).unwrap()),
            other => panic!("{other:?}"),
        },
        other => panic!("{other:?}"),
    }
}

/// Estimates of all cases that know the sampling, `rounds` of each, and the truth.
fn estimates<'a>(
    cases: &'a [Case],
    (sampling, points): (Sampling, Points),
    samples: impl Fn(f64) -> Samples + Send + Sync + 'a,
    seed: u64,
    rounds: usize,
) -> impl ParallelIterator<Item = (Result<Estimate, IntegrateError>, f64)> + 'a {
    (0..cases.len() * rounds).into_par_iter().filter_map(move |cell| {
        let case = &cases[cell % cases.len()];
        let trial = Trial {
            sampling,
            points,
            lobe: Lobe::Reflection,
            outgoing: case.outgoing,
            samples: samples(case.truth),
            seed,
            cell: cell as u64,
        };
        case.bxdf
            .supports(sampling)
            .then(|| (estimate(case.bxdf.as_ref(), trial), case.truth))
    })
}

/// Stated 99 % intervals cover 99 %, or no interval is stated: for any number of samples, and any narrowness.
#[test]
fn stated_intervals_cover() {
    let cases = cases();
    let counts = [150, 1000, 6000, 50_000];
    let level = sidak(3 * Points::ALL.len() * Sampling::ALL.len());
    let mut failures = Vec::new();
    for (index, sampling) in Sampling::ALL.into_iter().enumerate() {
        for (kind, points) in Points::ALL.into_iter().enumerate() {
            let name = Estimator::MonteCarlo { sampling, points }.name();
            let seed = 1000 + 100 * (5 * kind + index) as u64;
            let mut judge = |what: &str, found: &Coverage| {
                let p = coverage_p(found.covered, found.stated, CONFIDENCE);
                println!(
                    "{name}, {what}: {} of {} covered, {:.2} %, {} refused, p = {p:.3}",
                    found.covered,
                    found.stated,
                    100.0 * found.covered as f64 / found.stated as f64,
                    found.refused
                );
                if p <= level {
                    failures.push(format!("{name}, {what}: p = {p:e}"));
                }
            };
            let mut all = Coverage::default();
            for samples in counts {
                let rounds = if samples > 10_000 { 8 } else { 20 };
                let fixed = |_| Samples::Fixed(samples);
                let found = coverage(estimates(
                    &cases,
                    (sampling, points),
                    fixed,
                    seed + samples % 97,
                    rounds,
                ));
                println!(
                    "  {samples}: {} of {}, {} refused",
                    found.covered, found.stated, found.refused
                );
                all = all.and(found);
            }
            judge("fixed counts", &all);
            // the number of samples follows from what was drawn: looking must not pay
            for (what, share) in [("up to 3 %", 0.03), ("up to 0.3 %", 0.003)] {
                let adaptive = |truth| Samples::UpTo {
                    tolerance: share * truth,
                    limit: 200_000,
                };
                judge(
                    what,
                    &coverage(estimates(&cases, (sampling, points), adaptive, seed, 8)),
                );
            }
        }
    }
    assert!(failures.is_empty(), "{failures:#?}");
}

/// The same for measured samples, whose f has no formula; means of half a million quasi-random draws stand for the truth.
#[test]
fn intervals_of_measured_samples_cover() {
    const FEW: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/acryl-blue-30.brdf");
    let bxdf = Irregular::new(Arc::new(IrregularSamples::read(Path::new(FEW)).unwrap()));
    let trial = |points, outgoing, samples, cell| Trial {
        sampling: Sampling::Bxdf,
        points,
        lobe: Lobe::Reflection,
        outgoing,
        samples: Samples::Fixed(samples),
        seed: 90,
        cell,
    };
    let places = [0.05, 0.3, 0.5].map(|mu| outgoing(mu, 0.2)).into_iter();
    for place in places.chain([Outgoing::Cosine]) {
        let reference = estimate(&bxdf, trial(Points::Quasi, place, 1 << 19, u64::MAX)).unwrap();
        for points in Points::ALL {
            let found = coverage((0..200).into_par_iter().map(|cell| {
                let samples = if cell % 2 == 0 { 1000 } else { 4000 };
                (estimate(&bxdf, trial(points, place, samples, cell)), reference.value.x)
            }));
            let p = coverage_p(found.covered, found.stated, CONFIDENCE);
            println!("{points:?} {place:?}: {} of {}", found.covered, found.stated);
            assert!(found.stated > 50, "{points:?} {place:?}");
            assert!(
                p > sidak(12),
                "{points:?} {place:?}: {} of {}",
                found.covered,
                found.stated
            );
        }
    }
}

/// A narrow lobe over a diffuse base: every sample contributes and hardly any sees the lobe, which holds half the energy.
#[test]
fn a_lobe_that_no_sample_hits_is_within_the_interval() {
    let lobe = grooves(vmf(1e5), Fresnel::None);
    let (ks, kd) = (Spectrum::grey(0.5), Spectrum::grey(0.5));
    let coupled = DiffuseSpecular::new(Model::Microfacet(lobe), ks, kd, Coupling::Mikkelsen).unwrap();
    let bxdf = coupled_bxdf(&coupled, lobe).unwrap();
    let model = Model::DiffuseSpecular(Box::new(coupled));
    for mu in [0.1, 0.5, 0.9] {
        let truth = quadrature(&model, Target::rho_hd(mu, 0.0), 1e-8).unwrap().value.x;
        let samplings = [Sampling::Uniform, Sampling::Cosine];
        for (sampling, points) in samplings.into_iter().flat_map(|s| Points::ALL.map(|p| (s, p))) {
            let found = coverage((0..300).into_par_iter().map(|cell| {
                let found = estimate(
                    &bxdf,
                    Trial {
                        sampling,
                        points,
                        lobe: Lobe::Reflection,
                        outgoing: outgoing(mu, 0.0),
                        samples: Samples::Fixed(2000),
                        seed: 80,
                        cell,
                    },
                );
                (found, truth)
            }));
            assert!(found.stated > 0, "{sampling:?} {points:?} {mu}");
            let p = coverage_p(found.covered, found.stated, CONFIDENCE);
            assert!(
                p > sidak(18),
                "{sampling:?} {points:?} {mu}: {} of {}",
                found.covered,
                found.stated
            );
        }
    }
}

/// Importance sampling never refuses what it is made for.
#[test]
fn half_vectors_reach_every_lobe() {
    for lobe in all_lobes() {
        for mu in [1e-5, 0.01, 0.5, 1.0] {
            let samplings = [Sampling::Normals, Sampling::Visible, Sampling::Bxdf];
            for (sampling, points) in samplings.into_iter().flat_map(|s| Points::ALL.map(|p| (s, p))) {
                if lobe.masking == Masking::None && mu < 0.1 {
                    continue; // unmasked weights grow without bound towards the horizon
                }
                let found = estimate(
                    &lobe,
                    Trial {
                        sampling,
                        points,
                        lobe: Lobe::Reflection,
                        outgoing: outgoing(mu, 0.0),
                        samples: Samples::Fixed(4000),
                        seed: 3,
                        cell: 0,
                    },
                );
                assert!(found.is_ok(), "{lobe:?} {mu} {sampling:?} {points:?}: {found:?}");
            }
        }
    }
}

/// rho_hh by drawing both directions agrees with the deterministic route.
#[test]
fn hemispherical_albedo_agrees_with_quadrature() {
    let level = sidak(3);
    for (index, sampling) in [Sampling::Normals, Sampling::Visible, Sampling::Bxdf]
        .into_iter()
        .enumerate()
    {
        let mut z = Vec::new();
        for (material, lobe) in wide_lobes()
            .into_iter()
            .filter(|l| l.masking == Masking::VGroove)
            .enumerate()
        {
            let truth = quadrature(&Model::Microfacet(lobe), Target::rho_hh(), 1e-9)
                .unwrap()
                .value
                .x;
            let seed = (300 + 10 * index + material) as u64;
            let error = standard_error(&lobe, sampling, Outgoing::Cosine, seed).x;
            let scores = (0..24).into_par_iter().map(|cell| {
                let found = estimate(
                    &lobe,
                    Trial {
                        sampling,
                        points: Points::Random,
                        lobe: Lobe::Reflection,
                        outgoing: Outgoing::Cosine,
                        samples: Samples::Fixed(SAMPLES),
                        seed,
                        cell,
                    },
                )
                .unwrap();
                (found.value.x - truth) / error
            });
            z.extend(scores.collect::<Vec<_>>());
        }
        let p = normality(&z);
        assert!(p > level, "{sampling:?}: p = {p:e}");
    }
}

/// The coupled model is sampled as what quadrature integrates, for both couplings and every sampling, by way of the
/// command line's integrator.
#[test]
fn couplings_agree_with_quadrature() {
    let tests = 2 * Sampling::ALL.len();
    let level = sidak(tests);
    for (variant, coupling) in [Coupling::Mikkelsen, Coupling::EnergyPreserving]
        .into_iter()
        .enumerate()
    {
        let lobe = grooves(vmf(17.0), methanol());
        let (ks, kd) = (Spectrum::grey(0.9), Spectrum::rgb([0.7, 0.2, 1.0]));
        let coupled = DiffuseSpecular::new(Model::Microfacet(lobe), ks, kd, coupling).unwrap();
        let bxdf = coupled_bxdf(&coupled, lobe).unwrap();
        let model = Model::DiffuseSpecular(Box::new(coupled));
        for (index, sampling) in Sampling::ALL.into_iter().enumerate() {
            let effort = Effort {
                tolerance: 1e-3,
                samples: Some(SAMPLES),
                seed: (400 + 10 * variant + index) as u64,
            };
            let integrator = Integrator::new(&model, Estimator::random(sampling), effort).unwrap();
            let mut z = Vec::new();
            for mu in [0.2, 0.6, 1.0] {
                let truth = quadrature(&model, Target::rho_hd(mu, 0.0), 1e-8).unwrap().value;
                let error = standard_error(&bxdf, sampling, outgoing(mu, 0.3), effort.seed).y;
                let scores = (0..40).into_par_iter().map(|cell| {
                    let found = integrator.estimate(Target::rho_hd(mu, 0.3), cell).unwrap();
                    // one channel: the three share their samples
                    (found.value.y - truth.y) / error
                });
                z.extend(scores.collect::<Vec<_>>());
            }
            let p = normality(&z);
            assert!(p > level, "{coupling:?} {sampling:?}: p = {p:e}");
        }
    }
}

/// The same bits on any number of threads, and every time.
#[test]
fn threads_do_not_change_a_bit() {
    let lobe = grooves(vmf(17.0), methanol());
    let coupled = DiffuseSpecular::new(
        Model::Microfacet(lobe),
        Spectrum::grey(1.0),
        Spectrum::grey(0.5),
        Coupling::Mikkelsen,
    )
    .unwrap();
    let coupled = coupled_bxdf(&coupled, lobe).unwrap();
    let models: [&dyn Bxdf; 2] = [&lobe, &coupled];
    for (sampling, points) in Sampling::ALL.into_iter().flat_map(|s| Points::ALL.map(|p| (s, p))) {
        for samples in [
            Samples::Fixed(100_001),
            Samples::UpTo {
                tolerance: 2e-2,
                limit: 10_000_000,
            },
        ] {
            for outgoing in [outgoing(0.4, 1.0), Outgoing::Cosine] {
                for bxdf in models {
                    let run = || {
                        estimate(
                            bxdf,
                            Trial {
                                sampling,
                                points,
                                lobe: Lobe::Reflection,
                                outgoing,
                                samples,
                                seed: 5,
                                cell: 6,
                            },
                        )
                        .unwrap()
                    };
                    let bits = |e: Estimate| {
                        let values = e.value.to_array().into_iter().chain(e.error.to_array());
                        (values.map(f64::to_bits).collect::<Vec<_>>(), e.evaluations)
                    };
                    let on = |threads: usize| {
                        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
                        bits(pool.install(run))
                    };
                    let first = on(1);
                    assert_eq!(first, on(8), "{sampling:?} {points:?} {samples:?}");
                    // and on as many as the machine has
                    assert_eq!(first, bits(run()), "{sampling:?} {points:?} {samples:?}");
                }
            }
        }
    }
}

/// Points that keep clear of each other meet either side of a jump equally often in every set, and may miss thin layers and
/// rare tails altogether: their spread says nothing of that. Each case by itself, as others would outvote it.
#[test]
fn jumps_and_rare_tails_are_within_the_interval() {
    let glass = |eta_a: f64, eta_b: f64| {
        let bxdf = FresnelSpecular::new(
            Spectrum::grey(1.0),
            Spectrum::grey(1.0),
            eta_a,
            eta_b,
            Transport::Importance,
        );
        Model::FresnelSpecular(bxdf.unwrap())
    };
    let narrow = |alpha: f64, fresnel: Fresnel| Model::Microfacet(smith(ggx(alpha), fresnel, true));
    let unmasked = Microfacet::new(Spectrum::grey(1.0), vmf(0.0), Masking::None, Fresnel::None).unwrap();
    let streak = grooves(beckmann_xy(0.001_774_04, 0.000_144_515), conductor(0.683_772, 1.0));
    let rho = |mu: f64, lobe: Lobe| Target::rho_hd(mu, 2.173_617).of(lobe);
    let (up, down) = (Lobe::Reflection, Lobe::Transmission);
    let (to_3, to_4) = (Err(1e-3), Err(1e-4));
    let cases = [
        (glass(1.0, 1.5), Sampling::Bxdf, rho(0.03, up), to_3),
        (glass(1.0, 1.5), Sampling::Bxdf, rho(0.3, down), to_4),
        (glass(1.0, 1.5), Sampling::Bxdf, rho(0.7, down), to_3),
        (glass(0.0131, 21.7), Sampling::Bxdf, rho(1.0, down), Ok(1024)),
        (Model::Microfacet(unmasked), Sampling::Normals, rho(1.0, up), to_3),
        (Model::Microfacet(unmasked), Sampling::Normals, rho(1.0, up), Ok(16_384)),
        (narrow(0.01, Fresnel::None), Sampling::Visible, rho(0.2, up), to_3),
        (narrow(0.004, Fresnel::None), Sampling::Visible, rho(0.2, up), to_3),
        (
            narrow(3.29e-5, Fresnel::None),
            Sampling::Visible,
            rho(0.01175, up),
            Ok(65_536),
        ),
        (
            narrow(3.76e-4, dielectric(0.537_766_5)),
            Sampling::Visible,
            rho(1.0, up),
            Ok(65_536),
        ),
        (
            Model::Microfacet(streak),
            Sampling::Visible,
            rho(1.484_545_17e-6, up),
            Ok(4096),
        ),
    ];
    const RUNS: u64 = 100;
    let level = sidak(cases.len() * Points::ALL.len());
    for (index, (model, sampling, target, samples)) in cases.iter().enumerate() {
        let effort = |tolerance: f64, samples: Option<u64>, seed: u64| Effort {
            tolerance,
            samples,
            seed,
        };
        let truth = Integrator::new(model, Estimator::Auto, effort(1e-9, None, 0)).unwrap();
        let truth = truth.estimate(*target, 0).unwrap();
        for points in Points::ALL {
            let way = Estimator::MonteCarlo {
                sampling: *sampling,
                points,
            };
            let runs = (0..RUNS).into_par_iter().map(|seed| {
                // random points take the square of what they gain
                let tolerance = samples.err().map_or(1.0, |tolerance| match points {
                    Points::Random => 1e-2,
                    _ => tolerance,
                });
                let effort = effort(tolerance, samples.ok(), 31_000 + seed);
                let found = Integrator::new(model, way, effort)
                    .unwrap()
                    .estimate(*target, index as u64);
                (found, truth.value.x)
            });
            let found = coverage(runs);
            let p = coverage_p(found.covered, found.stated, CONFIDENCE);
            println!(
                "{way}, case {index}: {} of {} covered, {} refused",
                found.covered, found.stated, found.refused
            );
            assert!(p > level, "{way}, case {index}: {} of {}", found.covered, found.stated);
        }
    }
}
