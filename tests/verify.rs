//! The verification itself: it rejects models and tables that are wrong on purpose, and accepts right ones at the stated
//! rate.

mod common;

use common::cases::{aluminium, beckmann, dielectric, ggx, grooves, methanol, phong, vmf};
use common::statistics::coverage_p;
use common::wrong::{Mistake, Wrong};
use glam::DVec3;
use rayon::prelude::*;
use whitefurnace::bxdf::{
    Bxdf, BxdfSample, CoupledBxdf, Coupling, DiffuseSpecular, Flags, Lambertian, Microfacet, Model, other_hemisphere,
};
use whitefurnace::distribution::{Anisotropic, Distribution, Elliptic};
use whitefurnace::estimate::{Effort, Estimate, Estimator};
use whitefurnace::fresnel::Fresnel;
use whitefurnace::geometry::{reflect, refract};
use whitefurnace::integrate::{IntegrateError, Integrator, Target, coupled_bxdf, fill, sampled};
use whitefurnace::masking::{Masking, visible_groove_pdf};
use whitefurnace::plan::{Economy, Plan, Request, TablePlan};
use whitefurnace::scene::Scene;
use whitefurnace::spectrum::{Channels, Spectrum};
use whitefurnace::table::{ErrorKind, Table};
use whitefurnace::verify::tables::verify_table;
use whitefurnace::verify::{
    Check, Evidence, Facts, Outcome, Report, Settings, Source, Stated, Subject, Test, TransmissionRule, Verdict,
    energy, facts, furnace, normalisation, reciprocity, sampling, verify_bxdf, verify_material,
};

/// Family-wise confidence of single runs.
const CONFIDENCE: f64 = 0.999;

fn albedo(model: &Model) -> impl Fn(f64, f64) -> Result<Estimate, IntegrateError> + Sync + '_ {
    let effort = Effort {
        tolerance: 1e-7,
        samples: None,
        seed: 0,
    };
    let integrator = Integrator::new(model, Estimator::Auto, effort);
    move |mu, phi| {
        integrator
            .as_ref()
            .map_err(Clone::clone)?
            .estimate(Target::rho_hd(mu, phi), 0)
    }
}

/// The report on `bxdf`, which claims to be `model`.
fn report(bxdf: &dyn Bxdf, model: &Model, settings: &Settings, confidence: f64) -> Report {
    let stated = albedo(model);
    let subject = Subject {
        name: "subject".into(),
        bxdf,
        stated: stated(0.5, 0.0).is_ok().then_some(&stated),
        accounted: None,
        facts: facts(model),
        parameters: Vec::new(),
    };
    Report::judge(verify_bxdf(&subject, settings), confidence).unwrap()
}

/// Names of the tests that fail.
fn failing(report: &Report) -> Vec<Test> {
    let fails = report.results.iter().filter(|(_, verdict)| *verdict == Verdict::Fails);
    fails.map(|(check, _)| check.outcome.test).collect()
}

fn judged(outcomes: Vec<Outcome>) -> Report {
    let check = |outcome| Check {
        subject: "subject".into(),
        outcome,
        departure: None,
    };
    Report::judge(outcomes.into_iter().map(check).collect(), CONFIDENCE).unwrap()
}

fn coupled(lobe: Microfacet, coupling: Coupling) -> (Model, DiffuseSpecular) {
    let (ks, kd) = (Spectrum::grey(1.0), Spectrum::rgb([0.08, 0.172, 1.0]));
    let parameters = DiffuseSpecular::new(Model::Microfacet(lobe), ks, kd, coupling).unwrap();
    (Model::DiffuseSpecular(Box::new(parameters.clone())), parameters)
}

fn anisotropic(kind: Elliptic, x: f64, y: f64, fresnel: Fresnel) -> Microfacet {
    let distribution = Anisotropic::new(kind, x, y).unwrap();
    Microfacet::new(Spectrum::grey(1.0), distribution, Masking::VGroove, fresnel).unwrap()
}

/// A model with any of its functions replaced.
struct Altered<'a, B: ?Sized> {
    right: &'a B,
    f: &'a (dyn Fn(&B, DVec3, DVec3) -> DVec3 + Sync),
    pdf: &'a (dyn Fn(&B, DVec3, DVec3) -> f64 + Sync),
    sample: &'a (dyn Fn(&B, DVec3, [f64; 3]) -> BxdfSample + Sync),
}

impl<'a, B: Bxdf + ?Sized> Altered<'a, B> {
    fn of(right: &'a B) -> Self {
        Self {
            right,
            f: &|right, wo, wi| right.f(wo, wi),
            pdf: &|right, wo, wi| right.pdf(wo, wi),
            sample: &|right, wo, u| right.sample_f(wo, u),
        }
    }
}

impl<B: Bxdf + ?Sized> Bxdf for Altered<'_, B> {
    fn channels(&self) -> Channels {
        self.right.channels()
    }

    fn flags(&self) -> Flags {
        self.right.flags()
    }

    fn f(&self, wo: DVec3, wi: DVec3) -> DVec3 {
        (self.f)(self.right, wo, wi)
    }

    fn pdf(&self, wo: DVec3, wi: DVec3) -> f64 {
        (self.pdf)(self.right, wo, wi)
    }

    fn sample_f(&self, wo: DVec3, u: [f64; 3]) -> BxdfSample {
        (self.sample)(self.right, wo, u)
    }

    fn albedo_error(&self, mu: f64) -> DVec3 {
        self.right.albedo_error(mu)
    }
}

fn scaled(factor: f64, draw: BxdfSample) -> BxdfSample {
    BxdfSample {
        weight: factor * draw.weight,
        ..draw
    }
}

/// Smooth glass with one index above and another below, in either transport; `scale` is what transmitted light is multiplied
/// by in excess.
struct Glass {
    eta: f64,
    radiance: bool,
    excess: f64,
    /// Transmits straight on instead of refracting, on the way up alone.
    one_way: bool,
}

impl Bxdf for Glass {
    fn channels(&self) -> Channels {
        Channels::Grey
    }

    fn flags(&self) -> Flags {
        Flags::REFLECTION | Flags::TRANSMISSION | Flags::SPECULAR
    }

    fn f(&self, _: DVec3, _: DVec3) -> DVec3 {
        DVec3::ZERO
    }

    fn pdf(&self, _: DVec3, _: DVec3) -> f64 {
        0.0
    }

    fn sample_f(&self, wo: DVec3, u: [f64; 3]) -> BxdfSample {
        let (eta, n) = if wo.z > 0.0 {
            (self.eta, DVec3::Z)
        } else {
            (self.eta.recip(), -DVec3::Z)
        };
        let reflected = dielectric(eta).reflectance(wo.z.abs()).x;
        let straight = self.one_way && wo.z < 0.0;
        let through = if straight { Some(-wo) } else { refract(wo, n, eta) };
        let flags = Flags::SPECULAR;
        match through {
            Some(wi) if u[2] >= reflected => BxdfSample {
                wi,
                pdf: 1.0 - reflected,
                weight: DVec3::splat(if self.radiance {
                    self.excess / (eta * eta)
                } else {
                    self.excess
                }),
                flags: flags | Flags::TRANSMISSION,
            },
            _ => BxdfSample {
                wi: reflect(wo, n),
                pdf: reflected,
                weight: DVec3::ONE,
                flags: flags | Flags::REFLECTION,
            },
        }
    }
}

/// A reflecting model that transmits instead: mirrored in the surface.
struct Through<B>(B);

impl<B: Bxdf> Bxdf for Through<B> {
    fn channels(&self) -> Channels {
        self.0.channels()
    }

    fn flags(&self) -> Flags {
        (self.0.flags() - Flags::REFLECTION) | Flags::TRANSMISSION
    }

    fn f(&self, wo: DVec3, wi: DVec3) -> DVec3 {
        self.0.f(wo, other_hemisphere(wi))
    }

    fn pdf(&self, wo: DVec3, wi: DVec3) -> f64 {
        self.0.pdf(wo, other_hemisphere(wi))
    }

    fn sample_f(&self, wo: DVec3, u: [f64; 3]) -> BxdfSample {
        let draw = self.0.sample_f(wo, u);
        let flags = if draw.flags.is_empty() {
            draw.flags
        } else {
            self.flags()
        };
        BxdfSample {
            wi: other_hemisphere(draw.wi),
            flags,
            ..draw
        }
    }
}

/// All lobes, from the widest to the narrowest, isotropic or not, bare or over a base: nothing fails.
#[test]
fn right_models_of_any_width_pass() {
    let settings = Settings {
        samples: 1 << 15,
        ..Settings::thorough(11)
    };
    let mut models: Vec<Model> = Vec::new();
    for distribution in [
        vmf(0.0),
        vmf(17.0),
        vmf(1e5),
        vmf(1e12),
        beckmann(1e-6),
        beckmann(0.3),
        beckmann(10.0),
        phong(0.0),
        phong(1e8),
        ggx(1e-6),
        ggx(0.1),
        ggx(10.0),
    ] {
        models.push(Model::Microfacet(grooves(distribution, methanol())));
    }
    for (kind, x, y) in [
        (Elliptic::Beckmann, 0.05, 0.5),
        (Elliptic::Ggx, 1e-3, 0.3),
        (Elliptic::AshikhminShirley, 10.0, 1e4),
        (Elliptic::Beckmann, 1e-6, 1.0),
    ] {
        models.push(Model::Microfacet(anisotropic(kind, x, y, aluminium())));
    }
    for distribution in [vmf(17.0), vmf(1e6), beckmann(1e-4)] {
        for coupling in [Coupling::Mikkelsen, Coupling::EnergyPreserving] {
            models.push(coupled(grooves(distribution, methanol()), coupling).0);
        }
    }
    models.push(Model::Lambertian(
        Lambertian::new(Spectrum::rgb([0.0, 0.5, 1.0])).unwrap(),
    ));
    // the whole list is one family
    let checks: Vec<Check> = models
        .par_iter()
        .enumerate()
        .flat_map_iter(|(index, model)| {
            let bxdf = sampled(model).unwrap();
            let stated = albedo(model);
            let subject = Subject {
                name: format!("{index}: {model:?}"),
                bxdf: bxdf.as_ref(),
                stated: stated(0.5, 0.0).is_ok().then_some(&stated),
                accounted: None,
                facts: facts(model),
                parameters: Vec::new(),
            };
            verify_bxdf(&subject, &settings)
        })
        .collect();
    let report = Report::judge(checks, CONFIDENCE).unwrap();
    let fails = report.results.iter().filter(|(_, verdict)| *verdict == Verdict::Fails);
    let fails: Vec<&Check> = fails.map(|(check, _)| check).collect();
    assert!(fails.is_empty(), "{fails:#?}");
    assert!(report.count(Verdict::Holds) > 7 * models.len());
}

/// A family of tests fails no more often than it says: 100 runs with other seeds, at a confidence of 90 %, of two families
/// with few samples each. The bound is exceeded once in 1000 such trials.
#[test]
fn right_models_fail_no_more_often_than_stated() {
    let lobe = grooves(vmf(17.0), methanol());
    let (model, parameters) = coupled(lobe, Coupling::Mikkelsen);
    let bxdf = coupled_bxdf(&parameters, lobe).unwrap();
    let stated = albedo(&model);
    let bare = anisotropic(Elliptic::Ggx, 0.1, 0.4, methanol());
    let run = |bxdf: &dyn Bxdf, stated: Option<&Stated>, seed: u64| {
        let settings = Settings::quick(seed);
        let source = Source::new(seed, "rate");
        let mut outcomes = sampling::sampling(bxdf, stated, stated.is_some(), &settings, source).to_vec();
        outcomes.push(match stated {
            Some(stated) => furnace::white_furnace(bxdf, stated, &settings, source).unwrap(),
            None => energy::sampled_energy(bxdf, false, false, &settings, source),
        });
        let check = |outcome| Check {
            subject: "rate".into(),
            outcome,
            departure: None,
        };
        let report = Report::judge(outcomes.into_iter().map(check).collect(), 0.9).unwrap();
        assert_eq!(report.statistical, 3);
        report.is_good(true)
    };
    let runs = 100;
    for (name, passed) in [
        (
            "stated albedo",
            (0..runs)
                .into_par_iter()
                .filter(|seed| run(&bxdf, Some(&stated), *seed))
                .count(),
        ),
        (
            "samples alone",
            (0..runs).into_par_iter().filter(|seed| run(&bare, None, *seed)).count(),
        ),
    ] {
        let p = coverage_p(passed as u64, runs, 0.9);
        println!("{name}: {passed} of {runs} passed, p = {p:.3}");
        assert!(p > 5e-4, "{name}: {passed} of {runs}");
    }
}

/// p-values of right models are spread as they should be: those of counts evenly, all others no lower than evenly.
#[test]
fn p_values_are_uniform_or_larger() {
    let lobe = grooves(beckmann(0.3), methanol());
    let runs = 200;
    let ps: Vec<[f64; 2]> = (0..runs)
        .into_par_iter()
        .map(|seed| {
            let source = Source::new(seed, "p");
            let [_, counts, _, albedo] = sampling::sampling(&lobe, None, true, &Settings::quick(seed), source);
            [counts, albedo].map(|outcome| match outcome.evidence {
                Evidence::Chance(p) => p,
                other => panic!("{other:?}"),
            })
        })
        .collect();
    for (index, name) in ["counts", "albedo"].into_iter().enumerate() {
        for share in [0.05, 0.2, 0.5] {
            let above = ps.iter().filter(|p| p[index] > share).count() as u64;
            let least = coverage_p(above, runs, 1.0 - share);
            println!("{name}: {above} of {runs} above {share}");
            // six comparisons, each wrong once in 10^4
            assert!(least > 1e-4, "{name}: {above} of {runs} above {share}");
        }
    }
    // not all of them near 1 either: 200 p-values of counts above one half have a probability of 2^-200
    assert!(ps.iter().any(|p| p[0] < 0.5));
}

/// Every mistake is found by the test that is made for it.
#[test]
fn wrong_samplers_are_rejected() {
    let lobe = grooves(vmf(17.0), methanol());
    let model = Model::Microfacet(lobe);
    let settings = Settings::thorough(1);
    let found = |bxdf: &dyn Bxdf| failing(&report(bxdf, &model, &settings, CONFIDENCE));
    assert_eq!(found(&lobe), []);
    assert_eq!(found(&Altered::of(&lobe)), []);

    let jacobian = Wrong {
        lobe,
        mistake: Mistake::Jacobian,
    };
    assert_eq!(found(&jacobian), [Test::Weights, Test::Albedo]);
    let density = Altered {
        pdf: &|right: &Microfacet, wo, wi| right.pdf(wo, wi) * 2.0 * (wo + wi).length(),
        ..Altered::of(&lobe)
    };
    for test in [Test::Directions, Test::Weights] {
        assert!(found(&density).contains(&test), "{test:?}");
    }

    // 2 % in the weights alone, and 1 % of energy, consistently in f and weights
    let weights = Altered {
        sample: &|right: &Microfacet, wo, u| scaled(1.02, right.sample_f(wo, u)),
        ..Altered::of(&lobe)
    };
    assert_eq!(found(&weights), [Test::Weights, Test::Albedo]);
    for factor in [1.01, 0.99] {
        let f = move |right: &Microfacet, wo, wi| factor * right.f(wo, wi);
        let sample = move |right: &Microfacet, wo, u| scaled(factor, right.sample_f(wo, u));
        let gain = Altered {
            f: &f,
            sample: &sample,
            ..Altered::of(&lobe)
        };
        assert_eq!(found(&gain), [Test::Albedo], "{factor}");
    }

    // a density that adds up to 1.01, with weights that fit it
    let excess = Altered {
        pdf: &|right: &Microfacet, wo, wi| 1.01 * right.pdf(wo, wi),
        sample: &|right: &Microfacet, wo, u| {
            let draw = right.sample_f(wo, u);
            BxdfSample {
                pdf: 1.01 * draw.pdf,
                weight: draw.weight / 1.01,
                ..draw
            }
        },
        ..Altered::of(&lobe)
    };
    let tests = found(&excess);
    assert!(
        tests.contains(&Test::Density) && tests.contains(&Test::Albedo),
        "{tests:?}"
    );

    // a sampler of a lobe that is 10 % wider
    let wide = grooves(vmf(14.0), methanol());
    let other = Altered {
        sample: &|right: &Microfacet, wo, u| {
            let draw = wide.sample_f(wo, u);
            let pdf = right.pdf(wo, draw.wi);
            BxdfSample {
                pdf,
                weight: if draw.weight == DVec3::ZERO {
                    DVec3::ZERO
                } else {
                    right.f(wo, draw.wi) * (draw.wi.z / pdf)
                },
                ..draw
            }
        },
        ..Altered::of(&lobe)
    };
    assert!(found(&other).contains(&Test::Directions));
    // and one that loses a hundredth of what it draws
    let loses = Altered {
        sample: &|right: &Microfacet, wo, u| {
            let draw = right.sample_f(wo, [u[0], u[1], (97.0 * u[2]).fract()]);
            if (u[2] * 100.0).floor() == 17.0 {
                return BxdfSample {
                    pdf: 0.0,
                    weight: DVec3::ZERO,
                    flags: Flags::empty(),
                    ..draw
                };
            }
            draw
        },
        ..Altered::of(&lobe)
    };
    assert!(found(&loses).contains(&Test::Directions));
}

/// The narrowest legal lobes are resolved like any other: a sampler that is 10 % too wide is rejected.
#[test]
fn wrong_widths_of_narrow_lobes_are_rejected() {
    let settings = Settings {
        samples: 1 << 16,
        ..Settings::thorough(10)
    };
    for (right, wide) in [
        (vmf(1e12), vmf(0.8e12)),
        (beckmann(1e-6), beckmann(1.1e-6)),
        (phong(1e8), phong(0.8e8)),
        (ggx(1e-6), ggx(1.1e-6)),
    ] {
        let (lobe, wide) = (grooves(right, methanol()), grooves(wide, methanol()));
        let sample = |right: &Microfacet, wo, u| {
            let draw = wide.sample_f(wo, u);
            let pdf = right.pdf(wo, draw.wi);
            let weight = right.f(wo, draw.wi) * (draw.wi.z.abs() / pdf);
            let lost = draw.flags.is_empty();
            BxdfSample {
                pdf: if lost { 0.0 } else { pdf },
                weight: if lost { DVec3::ZERO } else { weight },
                ..draw
            }
        };
        let wrong = Altered {
            sample: &sample,
            ..Altered::of(&lobe)
        };
        let run = |bxdf: &dyn Bxdf| {
            let outcomes = sampling::sampling(bxdf, None, true, &settings, Source::new(10, "narrow"));
            failing(&judged(outcomes.to_vec()))
        };
        assert_eq!(run(&lobe), [], "{right:?}");
        assert!(run(&wrong).contains(&Test::Directions), "{right:?}");
    }
}

/// Exchanged axes are seen in anisotropic lobes, and sine for cosine in any lobe that leans over.
#[test]
fn swapped_axes_are_rejected() {
    let settings = Settings {
        samples: 1 << 15,
        ..Settings::thorough(2)
    };
    let lobe = anisotropic(Elliptic::Ggx, 0.2, 0.25, methanol());
    let swap = |w: DVec3| DVec3::new(w.y, w.x, w.z);
    let sample = |right: &Microfacet, wo, u| {
        let draw = right.sample_f(swap(wo), u);
        let wi = swap(draw.wi);
        let pdf = right.pdf(wo, wi);
        let lost = draw.flags.is_empty();
        BxdfSample {
            wi,
            pdf: if lost { 0.0 } else { pdf },
            weight: if lost {
                DVec3::ZERO
            } else {
                right.f(wo, wi) * (wi.z / pdf)
            },
            ..draw
        }
    };
    let swapped = Altered {
        sample: &sample,
        ..Altered::of(&lobe)
    };
    let run = |bxdf: &dyn Bxdf, isotropic| {
        let outcomes = sampling::sampling(bxdf, None, isotropic, &settings, Source::new(2, "swap"));
        failing(&judged(outcomes.to_vec()))
    };
    assert_eq!(run(&lobe, false), []);
    assert!(run(&swapped, false).contains(&Test::Directions));
    // an isotropic lobe that leans over, from oblique wo: the same mistake
    let lobe = grooves(vmf(50.0), methanol());
    let leaning = Altered {
        sample: &|right: &Microfacet, wo, u| {
            let draw = right.sample_f(wo, u);
            BxdfSample {
                wi: swap(draw.wi),
                ..draw
            }
        },
        ..Altered::of(&lobe)
    };
    assert_eq!(run(&lobe, true), []);
    let tests = run(&leaning, true);
    assert!(
        tests.contains(&Test::Directions) && tests.contains(&Test::Weights),
        "{tests:?}"
    );
}

/// Eq. 28 with the factor (1 - ks rho) of one direction only.
#[test]
fn a_coupling_that_is_not_reciprocal_is_rejected() {
    let lobe = grooves(vmf(17.0), methanol());
    let (model, parameters) = coupled(lobe, Coupling::Mikkelsen);
    let bxdf = coupled_bxdf(&parameters, lobe).unwrap();
    let specular = Model::Microfacet(lobe);
    let stated = albedo(&specular);
    let left = |w: DVec3| 1.0 - stated(w.z.abs(), 0.0).unwrap().value.x;
    let f = |right: &CoupledBxdf<Microfacet>, wo: DVec3, wi: DVec3| {
        let specular = lobe.f(wo, wi);
        specular + (right.f(wo, wi) - specular) / left(wi)
    };
    let one_sided = Altered {
        f: &f,
        ..Altered::of(&bxdf)
    };
    let settings = Settings::quick(3);
    let source = Source::new(3, "reciprocity");
    let check = |bxdf: &dyn Bxdf| {
        let outcome = reciprocity::reciprocity(bxdf, TransmissionRule::Plain, &settings, source);
        judged(vec![outcome]).is_good(true)
    };
    assert!(check(&bxdf));
    assert!(!check(&one_sided));
    // the right one passes everything, the white furnace among it
    assert_eq!(failing(&report(&bxdf, &model, &Settings::thorough(3), CONFIDENCE)), []);
    let loses = Altered {
        f: &|right: &CoupledBxdf<Microfacet>, wo, wi| 0.99 * right.f(wo, wi),
        ..Altered::of(&bxdf)
    };
    let tests = failing(&report(&loses, &model, &Settings::thorough(3), CONFIDENCE));
    assert_eq!(tests, [Test::WhiteFurnace, Test::Weights]);
}

/// The peak of an excess is found and named, by stated albedos and by samples.
#[test]
fn gains_of_energy_are_found_where_they_are() {
    // 1.004 in a band of 0.02 about mu = 0.37, 0.97 elsewhere
    let bump = |mu: f64| 0.97 + 0.034 * (-((mu - 0.37) / 0.02).powi(2)).exp();
    let lambertian = Lambertian::new(Spectrum::grey(1.0)).unwrap();
    let stated = |mu: f64, _: f64| {
        Ok(Estimate {
            value: DVec3::splat(bump(mu)),
            error: DVec3::splat(1e-6),
            kind: ErrorKind::Bound,
            estimator: Estimator::Quadrature,
            evaluations: 1,
        })
    };
    let outcome = energy::energy(&stated, true);
    assert_eq!(outcome.evidence, Evidence::Certain(false));
    let theta = 0.37f64.acos().to_degrees();
    let at = |outcome: &Outcome| match outcome.worst {
        Some(whitefurnace::verify::Place::Direction([theta, _])) => theta,
        ref other => panic!("{other:?}"),
    };
    assert!((at(&outcome) - theta).abs() < 0.1, "{outcome:?}"); // a tenth of the band
    assert!((outcome.statistic.as_ref().unwrap().value - 1.004).abs() < 1e-4);
    assert!(outcome.note.unwrap().contains("beyond"));

    let sample = |right: &Lambertian, wo: DVec3, u: [f64; 3]| {
        // weights that vary, so that the mean is uncertain
        let draw = right.sample_f(wo, u);
        scaled(bump(wo.z.abs()) * (0.5 + u[0]), draw)
    };
    let bxdf = Altered {
        sample: &sample,
        ..Altered::of(&lambertian)
    };
    let settings = Settings {
        samples: 1 << 20,
        ..Settings::thorough(4)
    };
    let outcome = energy::sampled_energy(&bxdf, false, true, &settings, Source::new(4, "bump"));
    assert!(
        matches!(outcome.evidence, Evidence::Chance(p) if p < 1e-6),
        "{outcome:?}"
    );
    assert!((at(&outcome) - theta).abs() < 2.0, "{outcome:?}"); // samples leave a peak of 1.2 degrees flat
    let right = energy::sampled_energy(&lambertian, false, true, &settings, Source::new(4, "right"));
    assert_eq!(right.evidence, Evidence::Chance(1.0));
    // the limit at grazing angles counts: 1.01 at mu = 0 and less everywhere else
    let grazing = |mu: f64, _: f64| {
        let mut estimate = stated(mu, 0.0)?;
        estimate.value = DVec3::splat(1.01 - 1e3 * mu);
        Ok(estimate)
    };
    assert_eq!(energy::energy(&grazing, true).evidence, Evidence::Certain(false));
}

/// Smooth glass: importance transport is plain, radiance follows the indices, and nothing else passes.
#[test]
fn specular_directions_lead_back_with_the_throughput_of_their_transport() {
    let glass = |radiance, excess, one_way| Glass {
        eta: 1.5,
        radiance,
        excess,
        one_way,
    };
    let indices = TransmissionRule::Scaled {
        eta_above: 1.0,
        eta_below: 1.5,
    };
    let check = |glass: Glass, rule| {
        let outcome = reciprocity::reciprocity_of_deltas(&glass, rule, Source::new(5, "glass"));
        judged(vec![outcome]).is_good(true)
    };
    assert!(check(glass(false, 1.0, false), TransmissionRule::Plain));
    assert!(check(glass(true, 1.0, false), indices));
    assert!(!check(glass(true, 1.0, false), TransmissionRule::Plain));
    assert!(!check(glass(false, 1.0, false), indices));
    let upside_down = TransmissionRule::Scaled {
        eta_above: 1.5,
        eta_below: 1.0,
    };
    assert!(!check(glass(true, 1.0, false), upside_down));
    assert!(!check(glass(false, 1.0, true), TransmissionRule::Plain));

    // as a whole: from both sides, with no smooth part; 1 % of energy is found
    let run = |glass: Glass, rule| {
        let subject = Subject {
            name: "glass".into(),
            bxdf: &glass,
            stated: None,
            accounted: None,
            facts: Facts {
                transmission: rule,
                ..Facts::default()
            },
            parameters: Vec::new(),
        };
        failing(&Report::judge(verify_bxdf(&subject, &Settings::quick(5)), CONFIDENCE).unwrap())
    };
    assert_eq!(run(glass(false, 1.0, false), TransmissionRule::Plain), []);
    let tests = run(glass(false, 1.01, false), TransmissionRule::Plain);
    assert_eq!(tests, [Test::Energy, Test::EnergyBelow]);
    // radiance is compressed on the way out of glass, by 1.5^2: more than 1 is right for it
    let tests = run(glass(true, 1.0, false), indices);
    assert_eq!(tests, [Test::EnergyBelow]);
}

/// Models that transmit are tested from both sides.
#[test]
fn transmitting_models_are_tested_from_both_sides() {
    let lobe = grooves(ggx(0.3), Fresnel::None);
    let through = Through(lobe);
    let settings = Settings {
        samples: 1 << 15,
        ..Settings::thorough(6)
    };
    let run = |bxdf: &dyn Bxdf| {
        let subject = Subject {
            name: "through".into(),
            bxdf,
            stated: None,
            accounted: None,
            facts: Facts::default(),
            parameters: Vec::new(),
        };
        Report::judge(verify_bxdf(&subject, &settings), CONFIDENCE).unwrap()
    };
    assert_eq!(failing(&run(&through)), []);
    // right from above, wrong from below
    let wrong = Altered {
        sample: &|right: &Through<Microfacet>, wo: DVec3, u| {
            let draw = right.sample_f(wo, u);
            if wo.z < 0.0 { scaled(1.05, draw) } else { draw }
        },
        ..Altered::of(&through)
    };
    assert_eq!(failing(&run(&wrong)), [Test::EnergyBelow, Test::Weights, Test::Albedo]);
    let report = run(&wrong);
    let below = report
        .results
        .iter()
        .find(|(check, _)| check.outcome.test == Test::Weights);
    assert!(format!("{:?}", below.unwrap().0.outcome.worst).contains("Pair"));
}

/// Densities of normals that are not normalised, or not of the visible ones.
#[test]
fn wrong_normalisations_are_rejected() {
    for distribution in [
        vmf(1e12),
        vmf(3.0),
        beckmann(1e-6),
        beckmann(0.4),
        phong(1e8),
        ggx(1e-6),
        ggx(2.0),
    ] {
        let facets = Distribution::from(distribution);
        let holds = |outcome: Outcome| outcome.evidence == Evidence::Certain(true);
        assert!(
            holds(normalisation::normals(&(Box::new(|h| facets.p(h)) as _))),
            "{facets:?}"
        );
        assert!(!holds(normalisation::normals(
            &(Box::new(|h| 1.0001 * facets.p(h)) as _)
        )));
        let visible = |wo: DVec3, h: DVec3| visible_groove_pdf(&facets, wo.z, h, wo.dot(h));
        let outcome = normalisation::visible_normals(&(Box::new(visible) as _));
        assert!(holds(outcome.clone()), "{facets:?} {outcome:?}");
        if facets.width() > 1e-2 {
            // |o.h| instead of the indicator, as eq. 25 is printed
            let absolute = |wo: DVec3, h: DVec3| visible_groove_pdf(&facets, wo.z, h, wo.dot(h).abs());
            assert!(
                !holds(normalisation::visible_normals(&(Box::new(absolute) as _))),
                "{facets:?}"
            );
        }
    }
}

fn plans(scene: &Scene, tolerance: f64, estimator: Estimator, samples: Option<u64>) -> Vec<TablePlan> {
    let request = Request {
        resolution: 16,
        roughness_resolution: 4,
        mapping: None,
        estimator,
        azimuth_resolution: 4,
        tolerance: Some(tolerance),
        samples,
        seed: 3,
        economy: Economy::FULL,
    };
    Plan::new(scene, &request).unwrap().tables
}

/// One texel that is off by three times its error is found, in tables of quadrature and of Monte Carlo.
#[test]
fn falsified_texels_are_rejected() {
    let scene = Scene::default_scene();
    let settings = Settings::thorough(7);
    let named = |estimator, tolerance, samples| -> Vec<(TablePlan, Table)> {
        plans(&scene, tolerance, estimator, samples)
            .into_iter()
            .filter(|plan| {
                [
                    "methanol-k17.specular.rho_hd",
                    "vmf-any-roughness.rho_hd",
                    "phong-n48.rho_hh",
                ]
                .contains(&&*plan.id)
            })
            .map(|plan| {
                let table = fill(&plan, &|_| {}).unwrap();
                (plan, table)
            })
            .collect()
    };
    let visible = "mc-visible".parse().unwrap();
    let mut tables = named(Estimator::Auto, 1e-6, None);
    tables.extend(named(visible, 1e-3, Some(20_000)));
    assert_eq!(tables.len(), 6);
    for (plan, table) in tables {
        let source = Source::new(7, &plan.id);
        let right = judged(verify_table(&table, &plan, &settings, source));
        assert_eq!(failing(&right), [], "{} {right:#?}", plan.id);
        let mut wrong = table.clone();
        let texel = table.values.len() / 2;
        wrong.values[texel] += 3.0 * table.texel_error(texel);
        let found = failing(&judged(verify_table(&wrong, &plan, &settings, source)));
        assert!(
            found.contains(&Test::TableTexels),
            "{} {}: {found:?}",
            plan.id,
            table.estimator
        );
        // 1 % too much everywhere is seen by independent samples too
        let mut gain = table.clone();
        gain.values.iter_mut().for_each(|value| *value *= 1.01);
        let found = failing(&judged(verify_table(&gain, &plan, &settings, source)));
        assert!(
            found.contains(&Test::TableSamples),
            "{} {}: {found:?}",
            plan.id,
            table.estimator
        );
        if let Some(between) = &table.between
            && table.error_kind == ErrorKind::Bound
        {
            let mut modest = table.clone();
            let error = 0.3 * between.error;
            modest.between.as_mut().unwrap().error = error;
            let found = failing(&judged(verify_table(&modest, &plan, &settings, source)));
            assert_eq!(found, [Test::TableLookup], "{}", plan.id);
        }
    }
}

/// Known departures are findings with their numbers; what they do not excuse still fails.
#[test]
fn known_departures_are_findings() {
    let scene = |masking: &str, fresnel: &str| {
        let text = format!(
            "[[material]]\nname = \"m\"\n[material.bxdf]\ntype = \"microfacet\"\n\
             distribution = {{ type = \"vmf\", kappa = 17 }}\nmasking = \"{masking}\"\nfresnel = {fresnel}\n"
        );
        Scene::parse(&text, "test").unwrap()
    };
    let run =
        |scene: &Scene| Report::judge(verify_material(&scene.materials[0], &Settings::quick(8)), CONFIDENCE).unwrap();
    let findings = |report: &Report| -> Vec<Test> {
        let found = report
            .results
            .iter()
            .filter(|(_, verdict)| *verdict == Verdict::Finding);
        found.map(|(check, _)| check.outcome.test).collect()
    };
    let unmasked = run(&scene("none", "{ type = \"none\" }"));
    assert_eq!(findings(&unmasked), [Test::Energy], "{unmasked:#?}");
    assert!(unmasked.is_good(false) && !unmasked.is_good(true));
    let approximate = run(&scene(
        "v-groove",
        "{ type = \"conductor-approximate\", eta = 0.769, k = 6.08 }",
    ));
    assert_eq!(findings(&approximate), [Test::Fresnel]);
    let difference = approximate
        .results
        .iter()
        .find(|(check, _)| check.outcome.test == Test::Fresnel);
    let statistic = difference.unwrap().0.outcome.statistic.clone().unwrap();
    // within 2.4e-3 for aluminium
    assert!((2.0e-3..2.4e-3).contains(&statistic.value), "{statistic}");
    // a coupling over it cannot be evaluated, which is said and takes no time
    let text = "[[material]]\nname = \"c\"\n[material.bxdf]\ntype = \"diffuse-specular\"\nks = 1\nkd = 1\n\
                specular = { type = \"microfacet\", distribution = { type = \"beckmann\", m = 10 }, masking = \"none\", \
                fresnel = { type = \"none\" } }\n";
    let over = run(&Scene::parse(text, "test").unwrap());
    assert!(over.is_good(false), "{over:#?}");
    let skipped = over.results.iter().filter(|(_, verdict)| *verdict == Verdict::Skipped);
    for (check, _) in skipped {
        let Evidence::Skipped(reason) = &check.outcome.evidence else {
            panic!("{check:?}")
        };
        assert!(reason.contains("masking"), "{reason}");
    }
    // a gain of a masked model is nobody's property
    let lobe = grooves(vmf(17.0), Fresnel::None);
    let gain = Wrong {
        lobe,
        mistake: Mistake::Gain,
    };
    let subject = Subject {
        name: "gain".into(),
        bxdf: &gain,
        stated: None,
        accounted: None,
        facts: Facts::default(),
        parameters: scene("v-groove", "{ type = \"none\" }").materials[0].model.describe(),
    };
    let report = Report::judge(verify_bxdf(&subject, &Settings::quick(8)), CONFIDENCE).unwrap();
    assert!(failing(&report).contains(&Test::Energy), "{report:#?}");
}

/// The same numbers on any number of threads, and levels only between the ends.
#[test]
fn reports_do_not_depend_on_threads() {
    let scene = Scene::default_scene();
    let run = || {
        let checks = scene
            .materials
            .iter()
            .flat_map(|m| verify_material(m, &Settings::quick(9)));
        Report::judge(checks.collect(), CONFIDENCE).unwrap()
    };
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(run)
    };
    assert_eq!(on(1), on(3));
    for confidence in [0.5, 1.0, 0.3, f64::NAN, 1.1] {
        assert!(Report::judge(Vec::new(), confidence).is_err(), "{confidence}");
    }
}
