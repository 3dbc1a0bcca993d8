//! Lambda, the Smith terms made of it and their limits; visible slopes.

use super::smith::Shape;
use super::visible::visible_slope;
use super::*;
use crate::distribution::{Anisotropic, Elliptic, Family};
use crate::geometry::{Polar, half_vector};
use crate::numerics::gaussian::{HALF_STEP, ierfc};
use glam::DVec2;
use std::f64::consts::PI;

fn smith(shape: Shape, x: f64, y: f64) -> Smith {
    let axes = DVec2::new(x, y);
    Smith { shape, axes }
}

/// Lambda as a function of a = cot/width, at 60 digits by mpmath 1.3: ierfc(a)/(2 a) and (sqrt(1 + 1/a^2) - 1)/2.
#[test]
fn lambda_is_exact() {
    for (a, beckmann, ggx) in [
        (1e-300, 2.8209479177387813e299, 4.9999999999999995e299),
        (1e-8, 28209478.677387815, 49999999.5),
        (0.1, 2.349110474981485, 4.524937810560445),
        (1.0, 0.02512727083000611, 0.20710678118654752),
        (1.9, 0.00041162783281923894, 0.06502396193641813),
        (2.5, 1.4352414312791502e-5, 0.0385164807134504),
        (8.0, 4.318515368348727e-32, 0.0038911092686593532),
        (25.0, 3.3147780416353554e-277, 0.0003998401278721432),
    ] {
        for (shape, value) in [(Shape::Gaussian, beckmann), (Shape::Ggx, ggx)] {
            // Lambda depends on the ratio of n.w and t alone
            let found = smith(shape, 1.0, 1.0).lambda(DVec3::X, a);
            assert!((found / value - 1.0f64).abs() < 2e-15, "{shape:?} {a}: {found:e}"); // some roundings of ierfc
        }
    }
}

/// Lambda(0+) is infinite, hidden and seen are t/(2 sqrt(pi)) and t/2; upright, everything is seen.
#[test]
fn areas_have_their_limits() {
    for (shape, horizon) in [(Shape::Gaussian, 0.5 / PI.sqrt()), (Shape::Ggx, 0.5)] {
        for (x, y) in [(1e-6, 1e-6), (1e-6, 10.0), (10.0, 1e-6), (0.3, 0.3)] {
            let smith = smith(shape, x, y);
            for (w, t) in [(DVec3::X, x), (DVec3::Y, y)] {
                for mu in [0.0, 1e-300] {
                    assert!((smith.seen(w, mu) / (horizon * t) - 1.0).abs() < 1e-15); // a few roundings
                }
                assert_eq!(smith.lambda(w, 0.0), f64::INFINITY);
                assert_eq!(smith.g1(w, 0.0), 0.0);
            }
            assert_eq!((smith.hidden(DVec3::Z, 1.0), smith.seen(DVec3::Z, 1.0)), (0.0, 1.0));
        }
    }
}

/// Uncorrelated is at most correlated, both tend to 1 with the roughness at fixed angles, and both are what their names say.
#[test]
fn smith_terms_are_ordered_and_tend_to_one() {
    for kind in [Elliptic::Beckmann, Elliptic::Ggx] {
        for i in 0..300 {
            let t = f64::from(i);
            let wo = Polar::from_cos(0.02 + 0.98 * (t * 0.618).fract()).direction(t);
            let wi = Polar::from_cos(0.02 + 0.98 * (t * 0.414).fract()).direction(2.1 * t);
            let half = half_vector(wo, wi).unwrap();
            let (h, d) = (half.wh.z, half.cos_d);
            let cos = Cosines { o: wo.z, i: wi.z, h, d };
            let mut previous = [0.0; 2];
            for width in [10.0, 1.0, 0.1, 1e-2, 1e-3, 1e-4] {
                let distribution = Anisotropic::new(kind, width, 0.5 * width).unwrap().into();
                let both = [Masking::Smith, Masking::SmithCorrelated].map(|masking| {
                    let g2 = 4.0 * cos.o * cos.i * cos.h * masking.shape(&distribution, wo, wi, cos);
                    let weight = masking.weight(&distribution, wo, wi, cos);
                    assert!((weight * cos.o * cos.h / cos.d / g2 - 1.0).abs() < 1e-13); // some roundings
                    g2
                });
                let slopes = Smith::new(&distribution).unwrap();
                let [lambda_o, lambda_i] = [wo, wi].map(|w| slopes.lambda(w, w.z));
                let named = [
                    1.0 / ((1.0 + lambda_o) * (1.0 + lambda_i)),
                    1.0 / (1.0 + lambda_o + lambda_i),
                ];
                for k in 0..2 {
                    assert!((both[k] / named[k] - 1.0).abs() < 1e-13, "{kind:?} {width}");
                    assert!(both[k] >= previous[k] - 1e-15 && both[k] <= 1.0 + 1e-15); // monotone, but for rounding
                }
                assert!(both[0] <= both[1] + 1e-15);
                previous = both;
            }
            // GGX is the slower: 1 - G2 is about (width/mu)^2/2 = (1e-4/0.02)^2/2
            assert!(previous[0] > 1.0 - 2e-5, "{previous:?}");
        }
    }
}

/// The weight of a given facet at mu = 0 is what it tends to as mu -> 0.
#[test]
fn smith_weights_have_their_limit_at_the_horizon() {
    for kind in [Elliptic::Beckmann, Elliptic::Ggx] {
        for (x, y) in [(1e-6, 1e-6), (1e-6, 10.0), (0.3, 0.1), (10.0, 10.0)] {
            let distribution = Anisotropic::new(kind, x, y).unwrap().into();
            for masking in [Masking::Smith, Masking::SmithCorrelated] {
                for steep in [1e-3, 1.0, 30.0] {
                    // a facet that faces wo = x
                    let wm = DVec3::new(steep * x, 0.2 * steep * y, 1.0).normalize();
                    let at = |mu: f64| {
                        let wo = Polar::from_cos(mu).direction(0.0);
                        let d = wo.dot(wm);
                        let wi = crate::geometry::reflect(wo, wm);
                        let (o, i, h) = (mu, 2.0 * d * wm.z - mu, wm.z);
                        let cos = Cosines { o, i, h, d };
                        masking.weight(&distribution, wo, wi, cos)
                    };
                    let limit = at(0.0);
                    assert!(
                        limit.is_finite() && limit > 0.0,
                        "{kind:?} {masking:?} {x} {y} {steep}: {limit}"
                    );
                    for mu in [1e-300, 1e-160, 1e-20] {
                        // Lambda falls by mu/width of itself, and everything else by less
                        let relative = at(mu) / limit - 1.0;
                        assert!(
                            relative.abs() < 1e-10,
                            "{kind:?} {masking:?} {x} {y} {steep}: {relative:e}"
                        );
                    }
                }
            }
        }
    }
}

/// V' masks everything where a Smith term has no distribution to go with; no model can be made of such a pair.
#[test]
fn smith_without_slopes_masks_everything() {
    let distribution = Family::Vmf.with(17.0).unwrap().into();
    let (o, i, h, d) = (0.5, 0.5, 1.0, 0.5);
    let wo = Polar::from_cos(0.5).direction(0.0);
    let wi = Polar::from_cos(0.5).direction(PI);
    let cos = Cosines { o, i, h, d };
    assert_eq!(Masking::Smith.weight(&distribution, wo, wi, cos), 0.0);
    assert_eq!(Masking::SmithCorrelated.lobe(&distribution, wo, wi, DVec3::Z, cos), 0.0);
}

/// F(x) = u to rounding over all angles, both tails included, and monotone in u.
#[test]
fn visible_slopes_invert_their_distribution() {
    for cot in [
        0.0,
        1e-300,
        1e-9,
        1e-3,
        0.1,
        0.35,
        1.0,
        1.8,
        3.0,
        6.0,
        30.0,
        1e9,
        f64::INFINITY,
    ] {
        let (sin, cos) = if cot < 1e9 {
            (1.0 / 1f64.hypot(cot), cot / 1f64.hypot(cot))
        } else {
            (1.0 / cot, 1.0)
        };
        let hidden = if sin > 0.0 { 0.5 * sin * ierfc(cos / sin) } else { 0.0 };
        let whole = cos + hidden;
        let mut previous = f64::NEG_INFINITY;
        let mut us = vec![0.0, HALF_STEP, 1e-16, 1e-12, 1e-6, 1e-3];
        us.extend((1..200).map(|i| f64::from(i) / 200.0));
        us.extend([1e-3, 1e-6, 1e-12, 4.0 * HALF_STEP].map(|rest| 1.0 - rest));
        for u in us {
            let x = visible_slope(cos, sin, u);
            let gauss = sin * (-x * x).exp() / (2.0 * PI.sqrt());
            let below = (0.5 * cos * libm::erfc(-x) + gauss) / whole;
            // x is off by a rounding and so is F, which is made of three terms
            let rounding = 8e-16;
            assert!((below - u).abs() <= rounding, "{cot} {u}: {x} {:e}", below - u);
            if u < 0.5 {
                let u = u.max(HALF_STEP);
                // relative to the tail a rounding of x counts x^2 times
                assert!(
                    (below / u - 1.0).abs() <= rounding * (4.0 + 4.0 * x * x),
                    "{cot} {u}: {x}"
                );
            }
            assert!(
                x >= previous - 1e-15 && x <= cos / sin,
                "{cot} {u}: {x} after {previous}"
            );
            previous = x;
        }
    }
}
