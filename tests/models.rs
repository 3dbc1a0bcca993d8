//! Oren-Nayar, FresnelBlend, smooth surfaces and the adapters against rules and statistics that know nothing of them.

mod common;

use common::cases::{Dice, beckmann, dielectric, ggx, grooves, methanol, phong, vmf};
use common::rules::{both_ends, composite};
use common::statistics::{counts_p, sidak};
use glam::DVec3;
use rayon::prelude::*;
use statrs::distribution::{ContinuousCDF, Normal};
use std::f64::consts::{FRAC_1_PI, FRAC_PI_2, TAU};
use whitefurnace::bxdf::{
    BrdfToBtdf, Bxdf, BxdfSample, Flags, FresnelBlend, FresnelSpecular, Lambertian, OrenNayar, Sampling, Scaled,
    SpecularReflection, SpecularTransmission, Sum, Transport, other_hemisphere,
};
use whitefurnace::distribution::{Anisotropic, Distribution, Elliptic};
use whitefurnace::geometry::Polar;
use whitefurnace::numerics::moments::Moments;
use whitefurnace::spectrum::{Channels, Spectrum};

const WHITE: Spectrum = Spectrum::grey(1.0);

fn lambertian(reflectance: f64) -> Lambertian {
    Lambertian::new(Spectrum::grey(reflectance)).unwrap()
}

fn oren_nayar(sigma_deg: f64) -> OrenNayar {
    OrenNayar::new(WHITE, sigma_deg).unwrap()
}

fn blend(rd: f64, rs: f64, distribution: impl Into<Distribution>) -> FresnelBlend {
    FresnelBlend::new(Spectrum::grey(rd), Spectrum::grey(rs), distribution).unwrap()
}

fn glass(transport: Transport) -> FresnelSpecular {
    FresnelSpecular::new(Spectrum::grey(0.9), Spectrum::grey(0.8), 1.0, 1.5, transport).unwrap()
}

fn mirror() -> SpecularReflection {
    SpecularReflection::new(Spectrum::grey(0.6), dielectric(1.5)).unwrap()
}

fn wood() -> Anisotropic {
    Anisotropic::new(Elliptic::AshikhminShirley, 100.0, 5.0).unwrap()
}

type Any = Box<dyn Bxdf>;

/// A rough pane of glass: diffuse and glossy to both sides.
fn frosted() -> Sum<Any> {
    Sum::new(vec![
        Box::new(lambertian(0.2)),
        Box::new(Scaled::new(grooves(vmf(17.0), methanol()), Spectrum::grey(0.5)).unwrap()),
        Box::new(BrdfToBtdf::new(blend(0.3, 0.04, phong(20.0)))),
    ])
}

/// int f cos dwi over the whole sphere, with panels towards the pole, the horizon and the plane of incidence.
fn albedo(bxdf: &dyn Bxdf, wo: DVec3, count: i32, panels: usize) -> f64 {
    let azimuth = wo.y.atan2(wo.x);
    let theta_o = Polar::of(wo.with_z(wo.z.abs())).angle();
    let over = |theta: f64| {
        let polar = Polar::from_angle(theta);
        let circle = |from: f64, to: f64| {
            both_ends(from, to, count, panels, |phi| {
                let above = polar.direction(azimuth + phi);
                bxdf.f(wo, above).x + bxdf.f(wo, other_hemisphere(above)).x
            })
        };
        polar.sin
            * polar.cos
            * (0..4)
                .map(|i| circle(f64::from(i) * FRAC_PI_2, f64::from(i + 1) * FRAC_PI_2))
                .sum::<f64>()
    };
    both_ends(0.0, theta_o, count, panels, over) + both_ends(theta_o, FRAC_PI_2, count, panels, over)
}

/// The largest differences of Oren-Nayar's closed forms from quadrature are roundings.
#[test]
fn closed_forms_of_oren_nayar_match_quadrature() {
    for sigma_deg in [0.0, 1.0, 18.0, 30.0, 90.0] {
        let bxdf = oren_nayar(sigma_deg);
        for theta_deg in [0.0, 1e-3, 10.0, 45.0, 80.0, 89.9, 90.0_f64] {
            let polar = Polar::from_angle(theta_deg.to_radians());
            let reference = albedo(&bxdf, polar.direction(0.7), 6, 2);
            let apart = (bxdf.rho_hd(polar.cos).x - reference).abs();
            assert!(apart < 1e-13, "sigma {sigma_deg}, theta {theta_deg}: {apart:e}"); // some hundred roundings
        }
        // rho_hd has theta^3 terms alone at the pole and is analytic inside
        let mean = composite(0.0, FRAC_PI_2, 200, |theta| {
            let polar = Polar::from_angle(theta);
            2.0 * polar.sin * polar.cos * bxdf.rho_hd(polar.cos).x
        });
        assert!((bxdf.rho_hh().x - mean).abs() < 1e-14, "sigma {sigma_deg}"); // some ten roundings
    }
}

#[test]
fn the_diffuse_part_of_fresnel_blend_is_what_a_lobe_adds_to_its_coat() {
    for mu in [1e-3, 0.1, 0.6, 1.0] {
        let wo = Polar::from_cos(mu).direction(0.3);
        let (both, coat) = (blend(0.7, 0.04, phong(20.0)), blend(0.0, 0.04, phong(20.0)));
        let added = albedo(&both, wo, 12, 4) - albedo(&coat, wo, 12, 4);
        let apart = (both.diffuse_rho_hd(mu).x - added).abs();
        assert!(apart < 1e-13, "{mu}: {apart:e}"); // the coat's errors cancel, roundings of numbers below 1 stay
    }
}

/// At the horizon and for rs = 1 the coat reflects half the mean of 1/(n.h): with lobes for which that mean is 2 at most the
/// albedo stays below 1, and loses half of it there for narrow ones. Wider lobes than the sources have gain energy.
#[test]
fn fresnel_blend_conserves_energy_unless_its_lobe_is_too_wide() {
    let narrow: [Distribution; 7] = [
        phong(0.0).into(),
        phong(48.0).into(),
        wood().into(),
        beckmann(0.2).into(),
        ggx(0.2).into(),
        ggx(1.0).into(),
        vmf(17.0).into(),
    ];
    let largest = |lobe: Distribution, rd: f64, rs: f64| {
        [1e-6, 1e-3, 0.05, 0.3, 0.7, 1.0]
            .map(|mu| albedo(&blend(rd, rs, lobe), Polar::from_cos(mu).direction(0.3), 9, 1))
            .into_iter()
            .fold(0.0, f64::max)
    };
    narrow.into_par_iter().for_each(|lobe| {
        for (rd, rs) in [(1.0, 0.0), (1.0, 0.5), (0.0, 1.0)] {
            let rho = largest(lobe, rd, rs);
            assert!(rho <= 1.0, "{lobe:?}, rd {rd}, rs {rs}: {rho}");
        }
        let grazing = albedo(&blend(0.0, 1.0, lobe), Polar::from_cos(1e-6).direction(0.3), 9, 1);
        assert!((0.5..=1.0).contains(&grazing), "{lobe:?}: {grazing}");
    });
    for lobe in [ggx(2.0), beckmann(4.0), vmf(0.0)] {
        let rho = largest(lobe.into(), 0.0, 1.0);
        assert!(rho > 1.1, "{lobe:?}: {rho}");
    }
}

const DRAWS: u64 = 200_000;

/// Mean weight and its distance from `exact` in standard errors; 0 where all weights are equal, and to rounding so.
fn z_score(bxdf: &dyn Bxdf, sampling: Sampling, wo: DVec3, sides: Flags, exact: f64, dice: &mut Dice) -> f64 {
    let mut moments = Moments::default();
    for _ in 0..DRAWS {
        let sample = bxdf.sample(sampling, wo, dice.uniform3());
        let counts = sample.flags.intersects(sides);
        moments.push(if counts { sample.weight } else { DVec3::ZERO });
    }
    let (apart, variance) = (moments.mean().x - exact, moments.variance().x);
    if variance < 1e-20 {
        return if apart.abs() < 1e-12 { 0.0 } else { f64::INFINITY };
    }
    apart / (variance / DRAWS as f64).sqrt()
}

struct Case {
    name: &'static str,
    bxdf: Any,
    sampling: Sampling,
    sides: Flags,
    exact: Box<dyn Fn(DVec3) -> f64 + Sync>,
}

fn case(
    name: &'static str,
    bxdf: impl Bxdf + 'static,
    sampling: Sampling,
    sides: Flags,
    exact: impl Fn(DVec3) -> f64 + Sync + 'static,
) -> Case {
    Case {
        name,
        bxdf: Box::new(bxdf),
        sampling,
        sides,
        exact: Box::new(exact),
    }
}

fn cases() -> Vec<Case> {
    let (r, t) = (Flags::REFLECTION, Flags::TRANSMISSION);
    let quadrature = |bxdf: Any| move |wo: DVec3| albedo(&bxdf, wo, 9, 2);
    let mut all = vec![
        case("rough diffuse", oren_nayar(20.0), Sampling::Bxdf, r, |wo| {
            oren_nayar(20.0).rho_hd(wo.z).x
        }),
        case("very rough diffuse", oren_nayar(90.0), Sampling::Uniform, r, |wo| {
            oren_nayar(90.0).rho_hd(wo.z).x
        }),
        case(
            "glass, reflected",
            glass(Transport::Radiance),
            Sampling::Bxdf,
            r,
            move |wo| glass(Transport::Radiance).rho_hd(r, wo.z).x,
        ),
        case(
            "glass, radiance",
            glass(Transport::Radiance),
            Sampling::Bxdf,
            t,
            move |wo| glass(Transport::Radiance).rho_hd(t, wo.z).x,
        ),
        case(
            "glass",
            glass(Transport::Importance),
            Sampling::Bxdf,
            t | r,
            move |wo| glass(Transport::Importance).rho_hd(t | r, wo.z).x,
        ),
        case(
            "diffuse and a mirror",
            Sum::new(vec![Box::new(lambertian(0.3)) as Any, Box::new(mirror())]),
            Sampling::Bxdf,
            r,
            move |wo| 0.3 + mirror().rho_hd(r, wo.z).x,
        ),
        case(
            "the mirrored mirror",
            BrdfToBtdf::new(mirror()),
            Sampling::Bxdf,
            t,
            move |wo| mirror().rho_hd(r, wo.z).x,
        ),
        case(
            "diffuse over a mirror, drawn by half vectors",
            Sum::new(vec![
                Box::new(blend(0.4, 0.04, ggx(0.4))) as Any,
                Box::new(blend(0.2, 0.1, phong(5.0))),
            ]),
            Sampling::Normals,
            r,
            quadrature(Box::new(Sum::new(vec![
                blend(0.4, 0.04, Distribution::from(ggx(0.4))),
                blend(0.2, 0.1, phong(5.0)),
            ]))),
        ),
        case(
            "frosted glass, both sides",
            frosted(),
            Sampling::Bxdf,
            r | t,
            quadrature(Box::new(frosted())),
        ),
        case(
            "frosted glass, drawn by cosine",
            frosted(),
            Sampling::Cosine,
            r | t,
            quadrature(Box::new(frosted())),
        ),
    ];
    for sampling in [Sampling::Bxdf, Sampling::Normals, Sampling::Cosine] {
        for lobe in [
            Distribution::from(phong(20.0)),
            vmf(2.0).into(),
            ggx(0.3).into(),
            wood().into(),
        ] {
            let bxdf = blend(0.5, 0.04, lobe);
            all.push(case("blend", bxdf, sampling, r, quadrature(Box::new(bxdf))));
        }
    }
    all
}

/// The mean of the weights is the closed form, or the quadrature that knows nothing of samples.
#[test]
fn mean_weights_are_albedos() {
    let cosines = [0.02, 0.3, 0.8, 1.0];
    let cases = cases();
    let level = sidak(cases.len() * cosines.len());
    let limit = Normal::standard().inverse_cdf(1.0 - 0.5 * level);
    cases.par_iter().enumerate().for_each(|(index, case)| {
        for (direction, mu) in cosines.into_iter().enumerate() {
            let wo = Polar::from_cos(mu).direction(0.7);
            let mut dice = Dice::new(81 + direction as u64, index as u64);
            let z = z_score(&case.bxdf, case.sampling, wo, case.sides, (case.exact)(wo), &mut dice);
            assert!(
                z.abs() < limit,
                "{} {index}, {:?} from {mu}: z = {z}",
                case.name,
                case.sampling
            );
        }
    });
}

/// A coat that is 2 % too bright does not get through.
#[test]
fn the_test_of_means_rejects_a_gain() {
    let wo = Polar::from_cos(0.3).direction(0.7);
    let exact = oren_nayar(20.0).rho_hd(0.3).x / 1.02;
    let z = z_score(
        &oren_nayar(20.0),
        Sampling::Bxdf,
        wo,
        Flags::REFLECTION,
        exact,
        &mut Dice::new(91, 0),
    );
    assert!(z > 6.0, "{z}");
}

const RINGS: usize = 10;
const SECTORS: usize = 8;

/// One of the bins into which both hemispheres are divided.
fn bin(w: DVec3) -> usize {
    let ring = (Polar::of(w.with_z(w.z.abs())).angle() / FRAC_PI_2 * RINGS as f64) as usize;
    let sector = ((w.y.atan2(w.x) / TAU + 1.0).fract() * SECTORS as f64) as usize;
    (usize::from(w.z < 0.0) * RINGS + ring.min(RINGS - 1)) * SECTORS + sector % SECTORS
}

/// Whether a bin is near -wo. Mirror images in facets that wo hardly sees go there, in vain, with a density like 1/(o.h)
/// that no fixed rule integrates. Models that transmit may send them to the other side; those that also reflect send their
/// lobe there, and few of these from steep directions.
fn opposite(index: usize, wo: DVec3, flags: Flags) -> bool {
    let (side, i, j) = (index / SECTORS / RINGS, index / SECTORS % RINGS, index % SECTORS);
    let theta = FRAC_PI_2 * (i as f64 + 0.5) / RINGS as f64;
    let centre = Polar::from_angle(theta).direction(TAU * (j as f64 + 0.5) / SECTORS as f64);
    let centre = if side == 0 { centre } else { other_hemisphere(centre) };
    let lobe_there = flags.contains(Flags::REFLECTION) && wo.z.abs() >= 0.3;
    let grazing = flags.contains(Flags::TRANSMISSION) && !lobe_there;
    // within 0.85 radians; half the diagonal of a bin is 0.4
    centre.dot(-wo) > 0.66 || (grazing && centre.dot(other_hemisphere(-wo)) > 0.66)
}

/// Draws expected in each bin, and last in none.
fn expected(bxdf: &dyn Bxdf, wo: DVec3) -> Vec<f64> {
    let mut counts: Vec<f64> = (0..2 * RINGS * SECTORS)
        .into_par_iter()
        .map(|index| {
            let (side, i, j) = (index / SECTORS / RINGS, index / SECTORS % RINGS, index % SECTORS);
            if opposite(index, wo, bxdf.flags()) {
                return 0.0;
            }
            let edge = |i: usize| FRAC_PI_2 * i as f64 / RINGS as f64;
            let ring = |phi: f64| {
                composite(edge(i), edge(i + 1), 8, |theta| {
                    let polar = Polar::from_angle(theta);
                    let above = polar.direction(phi);
                    polar.sin * bxdf.pdf(wo, if side == 0 { above } else { other_hemisphere(above) })
                })
            };
            let sector = TAU / SECTORS as f64;
            DRAWS as f64 * composite(j as f64 * sector, (j + 1) as f64 * sector, 8, ring)
        })
        .collect();
    let all: f64 = counts.iter().sum();
    // kinks between the nodes of 40 x 40 points leave less than 1e-4
    assert!(all <= DRAWS as f64 * (1.0 + 1e-4), "{all}");
    counts.push((DRAWS as f64 - all).max(0.0));
    counts
}

/// Probability of the directions that `sample_f` draws under `pdf`, over both hemispheres; lost ones count where the
/// density does.
fn directions_p(bxdf: &dyn Bxdf, pdf: &dyn Bxdf, wo: DVec3, dice: &mut Dice) -> f64 {
    let mut counts = vec![0; 2 * RINGS * SECTORS + 1];
    for _ in 0..DRAWS {
        let BxdfSample { wi, .. } = bxdf.sample_f(wo, dice.uniform3());
        let counted = pdf.pdf(wo, wi) > 0.0 && !opposite(bin(wi), wo, pdf.flags());
        counts[if counted { bin(wi) } else { 2 * RINGS * SECTORS }] += 1;
    }
    counts_p(&counts, &expected(pdf, wo))
}

#[test]
fn sampled_directions_follow_their_density() {
    let models: Vec<Any> = vec![
        Box::new(oren_nayar(20.0)),
        Box::new(oren_nayar(90.0)),
        Box::new(blend(0.5, 0.04, phong(20.0))),
        Box::new(blend(0.5, 0.04, vmf(17.0))),
        Box::new(blend(0.0, 0.04, ggx(0.5))),
        Box::new(blend(1.0, 0.0, wood())),
        Box::new(BrdfToBtdf::new(blend(0.5, 0.04, beckmann(0.4)))),
        Box::new(Sum::new(vec![
            blend(0.5, 0.04, phong(5.0)),
            blend(0.2, 0.5, phong(50.0)),
        ])),
        Box::new(frosted()),
    ];
    let cosines = [-0.5, 0.1, 0.6, 1.0];
    let level = sidak(models.len() * cosines.len());
    for (index, bxdf) in models.iter().enumerate() {
        for (direction, mu) in cosines.into_iter().enumerate() {
            let wo = Polar::from_cos(f64::abs(mu)).direction(0.7);
            let wo = if mu < 0.0 { -wo } else { wo };
            let p = directions_p(bxdf, bxdf, wo, &mut Dice::new(101 + direction as u64, index as u64));
            assert!(p > level, "{index} from {mu}: p = {p:e}");
        }
    }
    // and another roughness is told apart
    let wo = Polar::from_cos(0.6).direction(0.7);
    let (right, wrong) = (blend(0.0, 0.04, phong(20.0)), blend(0.0, 0.04, phong(22.0)));
    let p = directions_p(&right, &wrong, wo, &mut Dice::new(111, 0));
    assert!(p < 1e-6, "{p}");
}

#[test]
fn adapters_that_change_nothing_change_no_bit() {
    let inner = blend(0.5, 0.04, phong(20.0));
    let one = Scaled::new(inner, WHITE).unwrap();
    let alone = Sum::new(vec![inner]);
    let twice = BrdfToBtdf::new(BrdfToBtdf::new(inner));
    let boxed: Any = Box::new(inner);
    let through = BrdfToBtdf::new(lambertian(0.7));
    assert_eq!(through.flags(), Flags::TRANSMISSION | Flags::DIFFUSE);
    let mut dice = Dice::new(121, 0);
    for _ in 0..1000 {
        let wo = Polar::from_cos(dice.uniform()).direction(TAU * dice.uniform());
        let wi = Polar::from_cos(dice.uniform()).direction(TAU * dice.uniform());
        let u = dice.uniform3();
        for (same, samplings) in [
            (&one as &dyn Bxdf, [Sampling::Bxdf, Sampling::Normals]),
            (&alone, [Sampling::Bxdf, Sampling::Normals]),
            (&twice, [Sampling::Bxdf, Sampling::Normals]),
            (&boxed, [Sampling::Bxdf, Sampling::Normals]),
        ] {
            assert_eq!(same.f(wo, wi), inner.f(wo, wi));
            assert_eq!(same.pdf(wo, wi), inner.pdf(wo, wi));
            assert_eq!((same.flags(), same.channels()), (inner.flags(), inner.channels()));
            for sampling in samplings {
                assert_eq!(same.supports(sampling), inner.supports(sampling));
                let (a, b) = (same.sample(sampling, wo, u), inner.sample(sampling, wo, u));
                assert_eq!((a.wi, a.pdf, a.weight), (b.wi, b.pdf, b.weight));
            }
        }
        assert_eq!(through.f(wo, wi), DVec3::ZERO);
        assert_eq!(through.f(wo, other_hemisphere(wi)), DVec3::splat(0.7 * FRAC_1_PI));
        let sample = through.sample_f(wo, u);
        assert!(sample.wi.z < 0.0 && through.sample_f(-wo, u).wi.z > 0.0);
        assert_eq!((sample.weight, sample.flags), (DVec3::splat(0.7), through.flags()));
    }
}

#[test]
fn sums_choose_parts_by_their_flags() {
    let pane = SpecularTransmission::new(WHITE, 1.0, 1.5, Transport::default()).unwrap();
    let coloured = Lambertian::new(Spectrum::rgb([0.1, 0.2, 0.3])).unwrap();
    let sum = Sum::new(vec![Box::new(coloured) as Any, Box::new(mirror()), Box::new(pane)]);
    assert_eq!(sum.flags(), Flags::all() - Flags::GLOSSY);
    assert_eq!(sum.channels(), Channels::Rgb);
    let count = |wanted| sum.matching(wanted).parts().len();
    assert_eq!(count(Flags::all()), 3);
    assert_eq!(count(Flags::REFLECTION | Flags::DIFFUSE), 1);
    assert_eq!(count(Flags::all() - Flags::SPECULAR), 1);
    assert_eq!(count(Flags::REFLECTION | Flags::SPECULAR | Flags::GLOSSY), 1);
    assert_eq!(count(Flags::REFLECTION), 0);
    let mirrors = sum.matching(Flags::REFLECTION | Flags::SPECULAR);
    assert_eq!(
        mirrors.sample_f(DVec3::Z, [0.5; 3]),
        mirror().sample_f(DVec3::Z, [0.5; 3])
    );
    assert!(sum.supports(Sampling::Bxdf) && !sum.supports(Sampling::Cosine));
    // a sum of nothing is black
    let none: Sum<Any> = Sum::new(Vec::new());
    assert_eq!(
        (none.f(DVec3::Z, DVec3::Z), none.pdf(DVec3::Z, DVec3::Z)),
        (DVec3::ZERO, 0.0)
    );
    assert_eq!(none.sample_f(DVec3::Z, [0.5; 3]).weight, DVec3::ZERO);
    let error = Scaled::new(coloured, Spectrum::grey(1.5)).unwrap_err();
    assert_eq!(error.to_string(), "scale = 1.5 is not allowed: scale lies in [0, 1]");
}
