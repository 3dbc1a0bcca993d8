//! Smith masking and anisotropic distributions: identities by rules that share nothing with the library, limits, and
//! numbers that stay numbers over the whole legal ranges.

mod common;

use common::cases::{Dice, ashikhmin_shirley, beckmann, beckmann_xy, ggx, ggx_xy, grooves, methanol, phong, smith};
use common::rules::{both_ends, octaves, stretched_normal};
use glam::DVec3;
use rayon::prelude::*;
use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI};
use whitefurnace::bxdf::{Bxdf, Microfacet, Sampling};
use whitefurnace::distribution::{Distribution, Isotropic};
use whitefurnace::fresnel::Fresnel;
use whitefurnace::geometry::Polar;
use whitefurnace::masking::{Masking, Smith};

const SAMPLINGS: [Sampling; 5] = [
    Sampling::Uniform,
    Sampling::Cosine,
    Sampling::Normals,
    Sampling::Visible,
    Sampling::Bxdf,
];

/// Widths along the tangents, from round to the most stretched lobe there is.
const AXES: [[f64; 2]; 8] = [
    [0.3, 0.3],
    [1e-6, 1e-6],
    [10.0, 10.0],
    [0.1, 0.7],
    [2.0, 0.05],
    [1e-3, 1.0],
    [10.0, 1e-6],
    [1e-6, 10.0],
];

fn families(axes: [f64; 2]) -> [Distribution; 2] {
    [beckmann_xy(axes[0], axes[1]), ggx_xy(axes[0], axes[1])]
}

/// int f(h) dh over the hemisphere in stretched coordinates, for f with its kinks at v = `kink(psi)` and at psi = `from`,
/// `from` + pi/2, ...
fn over_normals(axes: [f64; 2], from: f64, kink: impl Fn(f64) -> f64 + Sync, f: impl Fn(DVec3) -> f64 + Sync) -> f64 {
    let around = |psi: f64| {
        let at = |v: f64| {
            let (h, solid_angle) = stretched_normal(axes, v, psi);
            f(h) * solid_angle
        };
        let kink = kink(psi).min(FRAC_PI_2);
        both_ends(0.0, kink, 5, 2, at) + both_ends(kink, FRAC_PI_2, 5, 2, at)
    };
    (0..4)
        .into_par_iter()
        .map(|quadrant| {
            let start = from + f64::from(quadrant) * FRAC_PI_2;
            both_ends(start, start + FRAC_PI_2, 24, 1, around)
        })
        .sum()
}

/// int p dh = 1 without the exposure, on which sampling and quadrature rest.
#[test]
fn anisotropic_densities_integrate_to_one() {
    let mut cases: Vec<([f64; 2], Distribution)> = AXES
        .into_iter()
        .flat_map(|axes| families(axes).map(|d| (axes, d)))
        .collect();
    for (x, y) in [
        (10.0, 10.0),
        (10.0, 1000.0),
        (0.0, 50.0),
        (1e8, 1e8),
        (1e4, 1.0),
        (0.0, 1e8),
    ] {
        cases.push((
            [1.0 / f64::sqrt(x + 2.0), 1.0 / f64::sqrt(y + 2.0)],
            ashikhmin_shirley(x, y),
        ));
    }
    for (axes, d) in cases {
        let total = over_normals(axes, 0.0, |_| FRAC_PI_4, |h| d.p(h));
        // two panels an octave leave 2e-9 of a Gaussian
        assert!((total - 1.0).abs() < 1e-8, "{d:?}: {total}");
    }
}

/// Directions at several heights and azimuths: along the tangents, between them, and near them.
fn directions() -> Vec<DVec3> {
    let mut all = Vec::new();
    for mu in [1e-6, 1e-3, 0.05, 0.5, 1.0 - 1e-9, 1.0] {
        for phi in [0.0, 1e-4, FRAC_PI_2 - 1e-3, 4.0] {
            all.push(Polar::from_cos(mu).direction(phi));
        }
    }
    all
}

/// What wo sees of the facets is what it sees of the surface, int G1 max(0, o.h) D dh = n.o: the weak white furnace, and
/// the exact Lambda by a second method. So the density of visible normals integrates to 1.
#[test]
fn visible_facets_add_up_to_the_visible_surface_under_smith() {
    for axes in AXES {
        for d in families(axes) {
            let slopes = Smith::new(&d).unwrap();
            for wo in directions() {
                let (x, y) = (axes[0] * wo.x, axes[1] * wo.y);
                let azimuth = y.atan2(x);
                // o.h = 0 at tan v = -(n.o)/(t cos(psi - azimuth)), behind wo only
                let edge = |psi: f64| {
                    let towards = -x.hypot(y) * (psi - azimuth).cos();
                    if towards > 0.0 { wo.z.atan2(towards) } else { FRAC_PI_4 }
                };
                let faced = over_normals(axes, azimuth, edge, |h| match wo.dot(h) {
                    cos_d if cos_d > 0.0 => cos_d * d.d(h),
                    _ => 0.0,
                });
                let g1 = slopes.g1(wo, wo.z);
                let total = g1 * faced / wo.z;
                // two panels an octave leave 2e-9 of a Gaussian
                assert!((total - 1.0).abs() < 1e-8, "{d:?} {wo}: {total}");
                let density = Masking::Smith.visible_pdf(&d, wo, wo.z, DVec3::Z, wo.z);
                let expected = 0.25 * g1 * d.d(DVec3::Z) / wo.z;
                assert!((density / expected - 1.0).abs() < 1e-13); // a few roundings
            }
        }
    }
}

/// Widths, f, pdf and samples of an anisotropic distribution whose parameters agree are those of the isotropic one.
#[test]
fn equal_parameters_make_an_isotropic_lobe() {
    let mut pairs: Vec<(Microfacet, Microfacet)> = Vec::new();
    let mut add = |round: Isotropic, stretched: Distribution, is_slope: bool| {
        pairs.push((grooves(round, methanol()), grooves(stretched, methanol())));
        for correlated in [false, true].into_iter().filter(|_| is_slope) {
            pairs.push((
                smith(round, methanol(), correlated),
                smith(stretched, methanol(), correlated),
            ));
        }
    };
    for width in [1e-6, 0.1, 1.0, 10.0] {
        add(beckmann(width), beckmann_xy(width, width), true);
        add(ggx(width), ggx_xy(width, width), true);
    }
    for exponent in [0.0, 48.0, 1e8] {
        add(phong(exponent), ashikhmin_shirley(exponent, exponent), false);
    }
    let mut dice = Dice::new(81, 0);
    for (round, stretched) in pairs {
        for _ in 0..200 {
            let wo = Polar::from_cos(dice.uniform()).direction(6.0 * dice.uniform());
            let u = dice.uniform3();
            for sampling in SAMPLINGS {
                let (a, b) = (round.sample(sampling, wo, u), stretched.sample(sampling, wo, u));
                // the azimuth goes through the axes and carries a few roundings, which a narrow lobe does not see
                assert!(
                    (a.wi - b.wi).length() < 1e-14,
                    "{stretched:?} {sampling:?}: {a:?} {b:?}"
                );
                // near n.i = 0 and o.h = 0 weights are quotients of differences; tails multiply the rounding of the slope
                let same = |x: f64, y: f64| (x - y).abs() <= 1e-9 * x.abs().max(y.abs()).max(1e-290);
                assert!(same(a.weight.x, b.weight.x), "{stretched:?} {sampling:?}: {a:?} {b:?}");
                assert!(same(a.pdf, b.pdf), "{stretched:?} {sampling:?}: {a:?} {b:?}");
                assert!(
                    same(round.f(wo, a.wi).x, stretched.f(wo, a.wi).x),
                    "{stretched:?} {sampling:?}"
                );
                assert!(
                    same(round.pdf(wo, a.wi), stretched.pdf(wo, a.wi)),
                    "{stretched:?} {sampling:?}"
                );
            }
        }
    }
}

/// A lobe stretched along y, seen from wo, is the lobe stretched along x, seen from wo turned by a quarter.
#[test]
fn turning_the_surface_turns_the_lobe() {
    let turned = |w: DVec3| DVec3::new(-w.y, w.x, w.z);
    let mut dice = Dice::new(82, 0);
    for [x, y] in AXES {
        for correlated in [false, true] {
            for (a, b) in families([x, y]).into_iter().zip(families([y, x])) {
                let (a, b) = (smith(a, methanol(), correlated), smith(b, methanol(), correlated));
                for _ in 0..100 {
                    let wo = Polar::from_cos(dice.uniform()).direction(6.0 * dice.uniform());
                    let wi = a.sample_f(wo, dice.uniform3()).wi;
                    // the same products in another order
                    let same = |x: f64, y: f64| (x - y).abs() <= 1e-13 * x.abs().max(y.abs());
                    assert!(same(a.f(wo, wi).x, b.f(turned(wo), turned(wi)).x), "{a:?} {wo} {wi}");
                    assert!(same(a.pdf(wo, wi), b.pdf(turned(wo), turned(wi))), "{a:?} {wo} {wi}");
                }
            }
        }
    }
}

/// Finite and not negative: f, pdf and weight of any legal lobe from any direction, the horizon included.
#[test]
fn smith_is_finite_over_the_whole_legal_range() {
    (0..20_000).into_par_iter().for_each(|case| {
        let mut dice = Dice::new(83, case);
        let lobe = dice.smith();
        let fine = |x: f64| x.is_finite() && x >= 0.0;
        let mut direction = |mu: f64| {
            let phi = match dice.pick(&[0, 1, 2]) {
                0 => dice.pick(&[0.0, FRAC_PI_2, PI, -FRAC_PI_2, 1e-300, 1e-9]),
                _ => 7.0 * dice.uniform(),
            };
            Polar::from_cos(mu).direction(phi)
        };
        let mut dice = Dice::new(84, case);
        let wo = direction(dice.mu());
        let others = [
            direction(dice.mu()),
            DVec3::new(-wo.x, -wo.y, wo.z),
            wo,
            DVec3::new(-wo.x, -wo.y, 0.0),
        ];
        for wi in others {
            let (f, pdf) = (lobe.f(wo, wi), lobe.pdf(wo, wi));
            assert!(
                fine(f.min_element()) && fine(f.max_element()) && fine(pdf),
                "{lobe:?} {wo:?} {wi:?}: {f} {pdf:e}"
            );
            assert_eq!(f, lobe.f(wi, wo));
        }
        let mut us = vec![[0.0; 3], [1.0 - 0.5 * f64::EPSILON; 3]];
        us.extend((0..6).map(|_| dice.uniform3()));
        for sampling in SAMPLINGS {
            for u in &us {
                let sample = lobe.sample(sampling, wo, *u);
                let (least, most) = (sample.weight.min_element(), sample.weight.max_element());
                assert!(
                    fine(least) && fine(most) && fine(sample.pdf),
                    "{lobe:?} {sampling:?} {wo:?} {u:?}: {sample:?}"
                );
                assert!(
                    (sample.wi.length() - 1.0).abs() < 1e-14,
                    "{lobe:?} {sampling:?} {wo:?} {u:?}"
                ); // some roundings
                let visible = matches!(sampling, Sampling::Visible | Sampling::Bxdf);
                assert!(!visible || most <= 1.0 + 1e-15, "{lobe:?} {wo:?} {u:?}: {sample:?}"); // F itself is rounded
            }
        }
    });
}

/// Mirrored at mu = 1e-160, f = D G2/(4 mu^2) = 1/(pi alpha^2) over alpha^2 uncorrelated, 4 mu alpha correlated: the
/// squares of everything in between underflow.
#[test]
fn deep_grazing_has_its_closed_form() {
    for mu in [1e-12, 1e-100, 1e-160, 1e-300] {
        for alpha in [1e-6, 1e-3] {
            let wo = DVec3::new(1.0, 0.0, mu);
            let wi = DVec3::new(-1.0, 0.0, mu);
            for d in [ggx(alpha).into(), ggx_xy(alpha, alpha)] {
                let uncorrelated = 1.0 / (PI * alpha.powi(4));
                let correlated: f64 = 1.0 / (PI * alpha * alpha) / (4.0 * mu * alpha);
                // 1 - (mu/alpha)^2 is left out, and the infinite is the largest number
                let same = |found: f64, value: f64| (found / value.min(1e300) - 1.0).abs() < 1e-5;
                assert!(
                    same(smith(d, Fresnel::None, false).f(wo, wi).x, uncorrelated),
                    "{mu:e} {alpha}"
                );
                assert!(
                    same(smith(d, Fresnel::None, true).f(wo, wi).x, correlated),
                    "{mu:e} {alpha}"
                );
            }
        }
    }
    // at the horizon itself a visible normal has the weight 1 - what Smith masks of wi
    let lobe = smith(ggx_xy(1e-6, 10.0), Fresnel::None, true);
    let sample = lobe.sample_f(DVec3::X, [0.3, 0.2, 0.0]);
    assert_eq!(sample.weight, DVec3::ONE);
}

/// int pdf over the hemisphere above and below is 1: nothing that is seen is lost but to the other side.
#[test]
fn densities_of_directions_add_up_over_the_sphere() {
    for d in [
        ggx(0.5).into(),
        beckmann(0.4).into(),
        ggx_xy(0.3, 0.8),
        beckmann_xy(0.7, 0.3),
    ] {
        for mu in [0.2, 0.7, 1.0] {
            let lobe = smith(d, Fresnel::None, true);
            let wo = Polar::from_cos(mu).direction(0.4);
            let sphere = |side: f64| {
                octaves(FRAC_PI_2, 8, 8, |below| {
                    let theta = Polar::from_angle(FRAC_PI_2 - below);
                    let circle = |from: f64| {
                        both_ends(from, from + PI, 10, 4, |phi| {
                            let w = theta.direction(phi);
                            lobe.pdf(wo, DVec3::new(w.x, w.y, side * w.z))
                        })
                    };
                    theta.sin * (circle(0.4) + circle(0.4 + PI))
                })
            };
            let total = sphere(1.0) + sphere(-1.0);
            // directions with h at the horizon end the density in a step that the panels, 0.02 rad, do not know of
            assert!((total - 1.0).abs() < 2e-3, "{d:?} {mu}: {total}");
            assert!(sphere(1.0) <= 1.0);
        }
    }
}
