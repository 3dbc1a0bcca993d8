//! Conductors: eta below 1, and k near 0.

use crate::big::{Big, big, off, one};
use crate::common::cases::conductor;
use crate::row::Row;
use whitefurnace::fresnel;
use whitefurnace::geometry::Polar;

/// F as eq. 8.3 of pbrt 2016 has it, with a^2 = (sqrt(t^2 + 4 eta^2 k^2) + t)/2, t = eta^2 - k^2 - sin^2.
fn printed(cos: f64, eta: f64, k: f64) -> f64 {
    let (cos2, sin2) = (cos * cos, 1.0 - cos * cos);
    let t = eta * eta - k * k - sin2;
    let sum = libm::sqrt(t * t + 4.0 * eta * eta * k * k);
    let a = libm::sqrt(0.5 * (sum + t));
    let perpendicular = (sum + cos2 - 2.0 * a * cos) / (sum + cos2 + 2.0 * a * cos);
    let (wide, cross) = (cos2 * sum + sin2 * sin2, 2.0 * a * cos * sin2);
    0.5 * perpendicular * (1.0 + (wide - cross) / (wide + cross))
}

fn printed_f32(cos: f32, eta: f32, k: f32) -> f32 {
    let (cos2, sin2) = (cos * cos, 1.0 - cos * cos);
    let t = eta * eta - k * k - sin2;
    let sum = (t * t + 4.0 * eta * eta * k * k).sqrt();
    let a = (0.5 * (sum + t)).sqrt();
    let perpendicular = (sum + cos2 - 2.0 * a * cos) / (sum + cos2 + 2.0 * a * cos);
    let (wide, cross) = (cos2 * sum + sin2 * sin2, 2.0 * a * cos * sin2);
    0.5 * perpendicular * (1.0 + (wide - cross) / (wide + cross))
}

fn truth(cos: f64, eta: f64, k: f64) -> Big {
    let sin2 = one() - big(cos) * big(cos);
    of_squared_sine(sin2, eta, k)
}

/// The same equation, in which 1200 bits hold a^2 for k down to 1e-100.
fn of_squared_sine(sin2: Big, eta: f64, k: f64) -> Big {
    let (eta, k) = (big(eta), big(k));
    let (two, cos2) = (big(2.0), one() - &sin2);
    let cos = cos2.sqrt();
    let t = &eta * &eta - &k * &k - &sin2;
    let sum = (&t * &t + big(4.0) * &eta * &eta * &k * &k).sqrt();
    let a = ((&sum + &t) / &two).sqrt();
    let part = &two * &a * &cos;
    let perpendicular = (&sum + &cos2 - &part) / (&sum + &cos2 + &part);
    let (wide, cross) = (&cos2 * &sum + &sin2 * &sin2, part * &sin2);
    perpendicular * (one() + (&wide - &cross) / (&wide + &cross)) / two
}

/// How much F follows the rounding of its arguments: as a function of (eta + ik)^2 - sin^2 it has a square root at 0.
fn condition(cos: f64, eta: f64, k: f64, f: f64) -> f64 {
    let re = (eta - 1.0) * (eta + 1.0) + cos * cos - k * k;
    (1.0 - f) * (1.0 + cos * cos) / libm::hypot(re, 2.0 * eta * k)
}

fn holds(cos: f64, eta: f64, k: f64) {
    let (found, exact) = (fresnel::conductor(cos, eta, k), truth(cos, eta, k));
    let error = off(found, &exact);
    let allowed = f64::EPSILON * (8.0 + condition(cos, eta, k, found));
    assert!(
        error <= allowed,
        "mu {cos:e}, {eta} + {k:e}i: {found} off by {error:e} of {allowed:e}"
    );
}

const COSINES: [f64; 8] = [1e-160, 1e-9, 1e-3, 0.1, 0.3, 0.7, 0.99, 1.0];

#[test]
fn conductors_of_small_eta() {
    let mut worst = 0.0f64;
    for eta in [0.01, 0.05, 0.2, 0.5, 0.769, 0.999] {
        for k in [0.03, 0.5, 1.0, 6.08, 10.0, 100.0] {
            for cos in COSINES {
                holds(cos, eta, k);
            }
            let absorbed = one() - truth(0.8, eta, k);
            worst = worst.max(off((1.0 - printed_f32(0.8, eta as f32, k as f32)).into(), &absorbed));
        }
    }
    // where total reflection would begin, by the sine: of |n| = 0.01 the cosine resolves nothing there
    for eta in [0.01, 0.1, 0.5] {
        for k in [1e-12, 1e-9, 1e-6, 1e-3, 0.01] {
            for distance in [-0.5, -1e-3, -1e-9, -1e-13, 0.0, 1e-13, 1e-9, 1e-3, 0.5] {
                let sin = eta * (1.0 + distance);
                let theta = Polar {
                    sin,
                    cos: libm::sqrt((1.0 - sin) * (1.0 + sin)),
                };
                let exact = of_squared_sine(big(sin) * big(sin), eta, k);
                let error = off(conductor(eta, k).reflectance_at(theta).x, &exact);
                assert!(error <= 16.0 * f64::EPSILON, "{eta} + {k:e}i, {distance:e}: {error:e}");
            }
        }
    }
    // a^2 is the difference of numbers near k^2, and with it goes all that is absorbed
    assert!(worst > 0.3, "{worst}");
    assert!(off(1.0 - printed(0.8, 0.01, 100.0), &(one() - truth(0.8, 0.01, 100.0))) > 1e-10);
}

#[test]
fn conductors_of_vanishing_k() {
    assert!(printed(0.0, 1.0, 0.0).is_nan()); // 0/0
    for eta in [0.01, 0.3, 0.5, 0.999, 1.0, 1.00029, 1.5, 100.0] {
        for k in [1e-3, 1e-6, 1e-9, 1e-15, 1e-60, 1e-100] {
            for cos in COSINES {
                holds(cos, eta, k);
            }
        }
        for cos in COSINES {
            // and without k it is the dielectric: 1 - F has a square root at the edge of total reflection, and its rounding
            let (metal, glass) = (fresnel::conductor(cos, eta, 0.0), fresnel::dielectric(cos, eta));
            assert!(
                (metal - glass).abs() <= 8.0 * f64::EPSILON,
                "{eta} {cos:e}: {metal} {glass}"
            );
        }
    }
    // what little is absorbed under total reflection, 4 Re(...) k: with 4 eta^2 k^2 lost beside t^2 it is 0
    let absorbed = one() - truth(0.3, 0.5, 1e-9);
    assert_eq!(1.0 - printed(0.3, 0.5, 1e-9), 0.0);
    assert!(off(1.0 - fresnel::conductor(0.3, 0.5, 1e-9), &absorbed) < 1e-6); // 1 - F of an F near 1
}

pub(crate) fn rows() -> Vec<Row> {
    vec![
        Row {
            example: "conductor, eta < 1: 1 - F, 0.01 + 100i, mu = 0.8, in f32",
            straightforward: (1.0 - printed_f32(0.8, 0.01, 100.0)).into(),
            ours: 1.0 - fresnel::conductor(0.8, 0.01, 100.0),
            truth: one() - truth(0.8, 0.01, 100.0),
            test: "conductors_of_small_eta",
        },
        Row {
            example: "conductor, k -> 0: 1 - F, 0.5 + 1e-9i, mu = 0.3",
            straightforward: 1.0 - printed(0.3, 0.5, 1e-9),
            ours: 1.0 - fresnel::conductor(0.3, 0.5, 1e-9),
            truth: one() - truth(0.3, 0.5, 1e-9),
            test: "conductors_of_vanishing_k",
        },
    ]
}
