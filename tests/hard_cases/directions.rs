//! Half vectors and their weights at the horizon.

use crate::big::{Big, beckmann_lambda, big, off, one, pi};
use crate::common::cases::{beckmann, dielectric, ggx, ggx_xy, grooves, phong, smith, vmf};
use crate::row::Row;
use glam::DVec3;
use std::f64::consts::FRAC_PI_2;
use whitefurnace::bxdf::{BLOCK, Bxdf, Draws, Flags, Sampling};
use whitefurnace::distribution::{Distribution, Isotropic};
use whitefurnace::fresnel::Fresnel;
use whitefurnace::geometry::{Polar, half_vector, reflect};
use whitefurnace::masking::{Cosines, Masking};

/// min(1, 2 (n.h)(n.o)/(o.h), 2 (n.h)(n.i)/(o.h)) [Mikkelsen 2009, eq. 25].
fn printed_masking(cos: Cosines) -> f64 {
    let grooves = |n_w: f64| 2.0 * cos.h * n_w / cos.d;
    1f64.min(grooves(cos.o)).min(grooves(cos.i))
}

/// f cos theta_i/pdf with f = V' D/(4 (n.o)(n.i)) and pdf = D (n.h)/(4 o.h), each as a number of its own.
fn quotient(d: f64, cos: Cosines) -> f64 {
    let f = printed_masking(cos) * d / (4.0 * cos.o * cos.i);
    let pdf = d * cos.h / (4.0 * cos.d);
    f * cos.i / pdf
}

/// The cosines of a facet and of the direction that it mirrors `wo` into.
fn mirrored(wo: DVec3, wm: DVec3) -> (DVec3, Cosines) {
    let (o, h, d) = (wo.z, wm.z, wo.dot(wm));
    let i = 2.0 * d * h - o;
    (reflect(wo, wm), Cosines { o, i, h, d })
}

/// The weight of eq. 30 for V-grooves, min((o.h)/((n.o)(n.h)), 2, 2 (n.i)/(n.o)); for Smith (o.h)/((n.o)(n.h)) over
/// (1 + Lambda(o))(1 + Lambda(i)).
fn true_weight(masking: Masking, distribution: &Isotropic, cos: Cosines) -> Big {
    let unmasked = big(cos.d) / (big(cos.o) * big(cos.h));
    if masking == Masking::VGroove {
        let shadowed = big(2.0) * big(cos.i) / big(cos.o);
        return unmasked.min(big(2.0)).min(shadowed);
    }
    let seen = [cos.o, cos.i].map(|cos| {
        let cos = big(cos);
        let tan = (one() - &cos * &cos).sqrt() / &cos;
        let lambda = match distribution {
            Isotropic::Ggx(lobe) => {
                let slope = big(lobe.alpha()) * tan;
                ((one() + &slope * &slope).sqrt() - one()) / big(2.0)
            }
            Isotropic::Beckmann(lobe) => beckmann_lambda(&(one() / (big(lobe.m()) * tan))),
            _ => unreachable!("no Smith term"),
        };
        one() + lambda
    });
    unmasked / (&seen[0] * &seen[1])
}

#[test]
fn quotients_of_d_and_pdf() {
    let far = Polar::from_angle(0.5);
    let wo = Polar::from_angle(0.8).direction(0.0);
    for azimuth in [0.0, 1.0, 2.0, 3.0] {
        let wm = far.direction(azimuth);
        let (wi, cos) = mirrored(wo, wm);
        if cos.i <= 0.0 {
            continue;
        }
        let cases = [
            (vmf(1e6), Masking::VGroove),
            (phong(1e8), Masking::VGroove),
            (beckmann(1e-3), Masking::VGroove),
            (beckmann(1e-3), Masking::Smith),
            (beckmann(1e-6), Masking::Smith),
        ];
        for (lobe, masking) in cases {
            assert_eq!(lobe.d(far), 0.0);
            assert!(quotient(lobe.d(far), cos).is_nan());
            let distribution = Distribution::from(lobe);
            let weight = masking.weight(&distribution, wo, wi, cos);
            let error = off(weight, &true_weight(masking, &lobe, cos));
            // two quotients and what masks
            assert!(error <= 6.0 * f64::EPSILON, "{lobe:?} {masking:?}: {error:e}");
            let model = match masking {
                Masking::VGroove => grooves(lobe, Fresnel::None),
                _ => smith(lobe, Fresnel::None, false),
            };
            assert_eq!((model.f(wo, wi).x, model.pdf(wo, wi)), (0.0, 0.0));
        }
    }
    // and where D is infinite: p = D (n.h) of vMF at the horizon, kappa/(2 pi (e^kappa - 1))
    let horizon = Polar { sin: 1.0, cos: 0.0 };
    for kappa in [1e-3, 1.0, 17.0] {
        assert!((vmf(kappa).d(horizon) * horizon.cos).is_nan());
        let truth = big(kappa) / (big(2.0) * pi() * (big(kappa).exp() - one()));
        let error = off(vmf(kappa).p(horizon), &truth);
        assert!(error <= f64::EPSILON * (4.0 + kappa), "{kappa}: {error:e}");
    }
}

/// The weight of eq. 30 as it stands there, V' (o.h)/((n.o)(n.h)).
fn printed_weight(cos: Cosines) -> f64 {
    printed_masking(cos) * cos.d / (cos.o * cos.h)
}

#[test]
fn weights_of_equation_30_at_the_horizon() {
    let lobes = [
        vmf(0.0),
        vmf(17.0),
        vmf(1e12),
        beckmann(1e-6),
        beckmann(10.0),
        ggx(0.3),
        phong(1e8),
    ];
    for lobe in lobes {
        let model = grooves(lobe, Fresnel::None);
        for mu in [1.0, 0.5, 1e-3, 1e-8, 1e-20, 1e-160, 1e-300, 5e-324, 0.0] {
            let wo = Polar::from_cos(mu).direction(0.0);
            for u in [
                [0.01, 0.0],
                [0.3, 0.1],
                [0.6, 0.2],
                [0.9, 0.45],
                [0.999, 0.9],
                [0.5, 0.5],
            ] {
                let wm = lobe.sample(u);
                let (_, cos) = mirrored(wo, wm);
                let drawn = model.sample(Sampling::Normals, wo, [u[0], u[1], 0.0]);
                assert!((0.0..=2.0).contains(&drawn.weight.x), "{lobe:?} {mu:e}: {drawn:?}");
                if cos.d <= 0.0 || cos.i <= 0.0 {
                    assert_eq!(drawn.weight.x, 0.0);
                    continue;
                }
                if mu == 0.0 {
                    // min(infinity, 2, infinity)
                    assert!(printed_weight(cos).is_nan());
                    assert_eq!(drawn.weight.x, 2.0);
                    continue;
                }
                let error = off(drawn.weight.x, &true_weight(Masking::VGroove, &lobe, cos));
                assert!(error <= 4.0 * f64::EPSILON, "{lobe:?} {mu:e}: {error:e}"); // two quotients
            }
        }
    }
    // the printed form keeps no digit of a subnormal n.o: its product with n.h has none
    let (_, cos) = mirrored(
        Polar::from_cos(5e-324).direction(0.0),
        Polar::from_angle(1.1).direction(0.0),
    );
    let printed = printed_weight(cos);
    assert!(!printed.is_finite() || (printed - 2.0).abs() > 0.1, "{printed}");
}

/// Many draws at once weigh what one does, in the corners too.
#[test]
fn blocks_of_weights_at_the_horizon() {
    // uniform numbers are multiples of 2^-53
    let step = 0.5 * f64::EPSILON;
    let ends = [
        0.0,
        step,
        1e6 * step,
        1e12 * step,
        0.25,
        0.5,
        1.0 - 1e3 * step,
        1.0 - step,
    ];
    let mut u = [[0.5; BLOCK]; 3];
    for k in 0..BLOCK {
        u[0][k] = ends[k % ends.len()];
        // no quarter turns, of which one sine is 0 and the other 6e-17
        u[1][k] = [0.0, 0.1, 0.3, 0.6, 0.9][k / ends.len() % 5];
        u[2][k] = 0.25 + 0.5 * (k % 2) as f64;
    }
    let lobes = [
        vmf(0.0),
        vmf(1e-300),
        vmf(1e12),
        beckmann(1e-6),
        beckmann(10.0),
        phong(0.0),
        phong(1e8),
        ggx(1e-6),
        ggx(10.0),
    ];
    for lobe in lobes {
        let mut models = vec![grooves(lobe, Fresnel::None), grooves(lobe, dielectric(0.01))];
        if matches!(lobe, Isotropic::Ggx(_)) {
            models.extend([true, false].map(|correlated| smith(lobe, Fresnel::None, correlated)));
        }
        for model in models {
            for mu in [1.0, 0.3, 1e-8, 1e-160, 5e-324, 0.0] {
                let wo = Polar::from_cos(mu).direction(0.0);
                let wos = wo.to_array().map(|x| [x; BLOCK]);
                for sampling in Sampling::ALL {
                    let draws = Draws {
                        wo: &wos,
                        u: [&u[0], &u[1], &u[2]],
                        len: BLOCK,
                    };
                    let mut found = [[0.0; BLOCK]; 3];
                    model.weights(sampling, Flags::REFLECTION, draws, &mut found);
                    for k in 0..BLOCK {
                        let single = model.sample(sampling, wo, [u[0][k], u[1][k], u[2][k]]);
                        let what = || format!("{model:?} {sampling:?} {mu:e} {k}: {} and {single:?}", found[0][k]);
                        assert!(found[0][k].is_finite() && found[0][k] >= 0.0, "{}", what());
                        assert!(single.weight.is_finite() && single.pdf.is_finite(), "{}", what());
                        let drawn_by_normals = matches!(sampling, Sampling::Normals | Sampling::Visible);
                        if drawn_by_normals && model.fresnel == Fresnel::None {
                            // o.h and n.i are sums of numbers of up to 2 sin theta_h, of which a weight has the share of n.o
                            let wm = (wo + single.wi).normalize();
                            let share = (libm::hypot(wm.x, wm.y) / mu).min(1e12);
                            let difference = (found[0][k] - single.weight.x).abs() / single.weight.x.max(1.0);
                            assert!(difference <= 16.0 * f64::EPSILON * (1.0 + share), "{}", what());
                        }
                    }
                }
            }
        }
    }
}

/// (wo + wi)/|wo + wi|, and half its length.
fn printed_half(wo: DVec3, wi: DVec3) -> (DVec3, f64) {
    let sum = wo + wi;
    let length = libm::sqrt(sum.x * sum.x + sum.y * sum.y + sum.z * sum.z);
    (sum / length, 0.5 * length)
}

#[test]
fn half_vectors_of_opposite_directions() {
    for theta in [0.0, 1e-9, 0.7, FRAC_PI_2] {
        let wo = Polar::from_angle(theta).direction(0.4);
        assert!(printed_half(wo, -wo).0.is_nan());
        assert_eq!(half_vector(wo, -wo), None);
    }
    // at the horizon, where opposite directions are both above the surface
    let (wo, wi) = (DVec3::X, DVec3::NEG_X);
    for lobe in [vmf(17.0), beckmann(0.2), phong(0.0), ggx(0.5)] {
        for model in [grooves(lobe, dielectric(1.5)), grooves(lobe, Fresnel::None)] {
            assert_eq!((model.f(wo, wi), model.pdf(wo, wi)), (DVec3::ZERO, 0.0));
        }
    }
    let stretched = smith(ggx_xy(0.1, 0.5), Fresnel::None, true);
    assert_eq!((stretched.f(wo, wi), stretched.pdf(wo, wi)), (DVec3::ZERO, 0.0));
    // and nearly there: what is left of the sum is exact, its square is not
    for low in [1e-3, 1e-8, 1e-20, 1e-155, 1e-160, 1e-200, 1e-300] {
        for aside in [0.0, 0.5, 3.0] {
            let (wo, wi) = (DVec3::new(1.0, 0.0, low), DVec3::new(-1.0, aside * low, 0.25 * low));
            let sum = [big(wo.x) + big(wi.x), big(wi.y), big(wo.z) + big(wi.z)];
            let length = sum
                .iter()
                .map(|x| x * x)
                .fold(big(0.0), |total, square| total + square)
                .sqrt();
            let half = half_vector(wo, wi).unwrap();
            for (found, part) in half.wh.to_array().into_iter().zip(&sum) {
                assert!(off(found, &(part / &length)) <= 4.0 * f64::EPSILON, "{low:e}: {half:?}");
            }
            assert!(
                off(half.cos_d, &(length / big(2.0))) <= 4.0 * f64::EPSILON,
                "{low:e}: {half:?}"
            );
            assert!(low > 1e-170 || printed_half(wo, wi).1 == 0.0);
        }
    }
}

pub(crate) fn rows() -> Vec<Row> {
    let wo = Polar::from_angle(0.8).direction(0.0);
    let far = Polar::from_angle(0.5);
    let (wi, cos) = mirrored(wo, far.direction(1.0));
    let narrow = beckmann(1e-3);
    let low = DVec3::X;
    let (low_wi, low_cos) = mirrored(low, far.direction(0.0));
    let tilt = 1e-200;
    let (near, opposite) = (DVec3::new(1.0, 0.0, tilt), DVec3::new(-1.0, tilt, 0.0));
    vec![
        Row {
            example: "f cos/pdf far off the lobe: Beckmann, m = 0.001, h at 0.5",
            straightforward: quotient(narrow.d(far), cos),
            ours: Masking::VGroove.weight(&narrow.into(), wo, wi, cos),
            truth: true_weight(Masking::VGroove, &narrow, cos),
            test: "quotients_of_d_and_pdf",
        },
        Row {
            example: "weight of eq. 30 at n.o = 0",
            straightforward: printed_weight(low_cos),
            ours: Masking::VGroove.weight(&narrow.into(), low, low_wi, low_cos),
            truth: big(2.0),
            test: "weights_of_equation_30_at_the_horizon",
        },
        Row {
            example: "nearly opposite at the horizon: n.h, sum of (0, 1, 1) 1e-200",
            straightforward: printed_half(near, opposite).0.z,
            ours: half_vector(near, opposite).map_or(f64::NAN, |half| half.wh.z),
            truth: one() / big(2.0).sqrt(),
            test: "half_vectors_of_opposite_directions",
        },
    ]
}
