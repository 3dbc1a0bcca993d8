//! Smooth interfaces of two dielectrics.

use crate::big::{Big, big, off, one};
use crate::common::cases::dielectric;
use crate::row::Row;
use glam::DVec3;
use whitefurnace::bxdf::{Bxdf, SpecularTransmission, Transport};
use whitefurnace::fresnel::{self, dielectric_mean};
use whitefurnace::geometry::{Polar, refract};
use whitefurnace::spectrum::Spectrum;

/// F by the amplitudes of pbrt 2010, section 8.2.1, with Snell's cos_t = sqrt(1 - sin^2/eta^2), eta = eta_t/eta_i.
fn printed(cos: f64, eta: f64) -> f64 {
    let cos_t = libm::sqrt(1.0 - (1.0 - cos * cos) / (eta * eta));
    let parallel = (eta * cos - cos_t) / (eta * cos + cos_t);
    let perpendicular = (cos - eta * cos_t) / (cos + eta * cos_t);
    0.5 * (parallel * parallel + perpendicular * perpendicular)
}

fn printed_f32(cos: f32, eta: f32) -> f32 {
    let cos_t = (1.0 - (1.0 - cos * cos) / (eta * eta)).sqrt();
    let parallel = (eta * cos - cos_t) / (eta * cos + cos_t);
    let perpendicular = (cos - eta * cos_t) / (cos + eta * cos_t);
    0.5 * (parallel * parallel + perpendicular * perpendicular)
}

/// eta^2 - sin^2 of the smaller of sine and cosine as given.
fn beyond(theta: Polar, eta: f64) -> Big {
    let square = if theta.sin < theta.cos {
        big(theta.sin) * big(theta.sin)
    } else {
        one() - big(theta.cos) * big(theta.cos)
    };
    big(eta) * big(eta) - square
}

fn cosine(theta: Polar) -> Big {
    if theta.sin < theta.cos {
        (one() - big(theta.sin) * big(theta.sin)).sqrt()
    } else {
        big(theta.cos)
    }
}

/// The same amplitudes, and 1 under total internal reflection.
fn truth(theta: Polar, eta: f64) -> Big {
    let (square, cos, eta) = (beyond(theta, eta), cosine(theta), big(eta));
    if square < big(0.0) {
        return one();
    }
    let cos_t = square.sqrt() / &eta;
    let parallel = (&eta * &cos - &cos_t) / (&eta * &cos + &cos_t);
    let perpendicular = (&cos - &eta * &cos_t) / (&cos + &eta * &cos_t);
    (&parallel * &parallel + &perpendicular * &perpendicular) / big(2.0)
}

/// The angle with the sine `sin`, its cosine to a rounding.
fn of_sine(sin: f64) -> Polar {
    let cos = libm::sqrt((1.0 - sin) * (1.0 + sin));
    Polar { sin, cos }
}

#[test]
fn edge_of_total_internal_reflection() {
    let mut worst = 0.0f64;
    for eta in [0.01, 0.1, 0.5, 0.7, 0.75, 0.9, 0.999, 1.0 / 1.000_29] {
        for exponent in 1..=14 {
            let distance = 0.1f64.powi(exponent);
            let inside = of_sine(eta * (1.0 - distance));
            let exact = truth(inside, eta);
            worst = worst.max(off(printed(inside.cos, eta), &exact));
            let found = dielectric(eta).reflectance_at(inside).x;
            let error = off(found, &exact);
            // F = 1 - c sqrt(g^2): g^2 is formed from the sine without a rounding, or to some of cos^2, which is how well the
            // cosine is known
            let known = if inside.cos < inside.sin {
                (1.0 - found) / found * inside.cos.powi(2) / ((eta - inside.sin) * (eta + inside.sin))
            } else {
                0.0
            };
            let allowed = f64::EPSILON * (8.0 + known);
            assert!(
                error <= allowed,
                "eta {eta}, {distance:e} inside: {error:e} of {allowed:e}"
            );
            // refracted, the cosine is sqrt(eta^2 - sin^2)/eta
            let exact = beyond(inside, eta).sqrt() / big(eta);
            let through = refract(inside.direction(0.0), DVec3::Z, eta).unwrap();
            let window = SpecularTransmission::new(Spectrum::grey(1.0), 1.0, eta, Transport::Importance).unwrap();
            let seen = window.sample_f(inside.direction(0.0), [0.5; 3]);
            // its square is as known as that of the smaller one, over the distance
            let known = if inside.cos < inside.sin {
                (inside.cos / eta).powi(2)
            } else {
                1.0
            };
            let allowed = f64::EPSILON * (4.0 + known / distance);
            for cos in [-through.z, -seen.wi.z] {
                let error = off(cos, &exact);
                assert!(
                    error <= allowed,
                    "eta {eta}, {distance:e} inside: {error:e} of {allowed:e}"
                );
            }
            if inside.sin < inside.cos {
                // a sine without rounding, which a direction off the tangents does not have
                assert!(off(-through.z, &exact) <= 4.0 * f64::EPSILON);
            }
            let sin = eta * (1.0 + distance);
            if sin <= 1.0 {
                let outside = dielectric(eta).reflectance_at(of_sine(sin)).x;
                assert_eq!(outside, 1.0, "eta {eta}, {distance:e} outside");
            }
        }
        let grazing = 0.5 * libm::sqrt((1.0 - eta) * (1.0 + eta));
        assert!(printed(grazing, eta).is_nan());
        assert_eq!(fresnel::dielectric(grazing, eta), 1.0);
        let wo = Polar::from_cos(grazing).direction(0.0);
        assert_eq!(refract(wo, DVec3::Z, eta), None);
    }
    // for eta = 0.01 all of F happens where cos is within 5e-5 of 1
    assert!(worst > 1e-7, "{worst:e}");
}

#[test]
fn matched_indices() {
    assert!(printed(0.0, 1.0).is_nan()); // 0/0
    assert_eq!(printed(1e-9, 1.0), 1.0); // of 0: 1 - (1 - cos^2) has no digit left
    assert_eq!(printed_f32(1e-4, 1.0), 1.0);
    for cos in [0.0, 5e-324, 1e-160, 1e-9, 1e-4, 0.3, 1.0] {
        assert_eq!(fresnel::dielectric(cos, 1.0), 0.0);
        assert_eq!(fresnel::conductor(cos, 1.0, 0.0), 0.0);
        let wo = Polar::from_cos(cos).direction(0.7);
        let through = refract(wo, DVec3::Z, 1.0).unwrap();
        assert!((through + wo).length() < 4.0 * f64::EPSILON, "{cos:e}: {through}"); // straight on
    }
    assert_eq!(dielectric_mean(1.0), (0.0, 0.0));
}

/// F_bar for n > 1, in the form of Walsh 1926.
fn printed_mean(n: f64) -> f64 {
    let (n2, n4) = (n * n, n * n * n * n);
    0.5 + (n - 1.0) * (3.0 * n + 1.0) / (6.0 * (n + 1.0) * (n + 1.0))
        + n2 * (n2 - 1.0) * (n2 - 1.0) / ((n2 + 1.0) * (n2 + 1.0) * (n2 + 1.0)) * libm::log((n - 1.0) / (n + 1.0))
        - 2.0 * n2 * n * (n2 + 2.0 * n - 1.0) / ((n2 + 1.0) * (n4 - 1.0))
        + 8.0 * n4 * (n4 + 1.0) / ((n2 + 1.0) * (n4 - 1.0) * (n4 - 1.0)) * libm::log(n)
}

fn true_mean(n: f64) -> Big {
    let (n, number) = (big(n), big);
    let (n2, n4) = (&n * &n, &n * &n * &n * &n);
    let (sum, difference) = (&n2 + one(), &n4 - one());
    let normal = (&n - one()) * (number(3.0) * &n + one()) / (number(6.0) * (&n + one()) * (&n + one()));
    let step = &n2 - one();
    let ratio = &n2 * &step * &step / (&sum * &sum * &sum) * ((&n - one()) / (&n + one())).ln();
    let third = number(2.0) * &n2 * &n * (&n2 + number(2.0) * &n - one()) / (&sum * &difference);
    let fourth = number(8.0) * &n4 * (&n4 + one()) / (&sum * &difference * &difference) * n.ln();
    number(0.5) + normal + ratio - third + fourth
}

#[test]
fn nearly_matched_indices() {
    let mut worst = [0.0f64; 2];
    for eta in [
        1.000_29,
        1.0 / 1.000_29,
        1.0 + 1e-6,
        1.0 - 1e-6,
        1.0 + 1e-12,
        1.0 + f64::EPSILON,
    ] {
        for cos in [1.0, 0.9, 0.5, 0.25, 0.1] {
            let exact = truth(Polar::from_cos(cos), eta);
            worst[0] = worst[0].max(off(printed(cos, eta), &exact));
            worst[1] = worst[1].max(off(printed_f32(cos as f32, eta as f32).into(), &exact));
            // eta - 1 is exact; the sine behind cos = 0.9 counts (sin/cos)^2 times
            let error = off(fresnel::dielectric(cos, eta), &exact);
            assert!(error <= 32.0 * f64::EPSILON, "{cos} {eta}: {error:e}");
        }
    }
    assert!(worst[0] > 0.1 && worst[1] > 0.1, "{worst:?}");
    // the mean over the hemisphere, whose last two terms grow like 1/(n - 1)
    assert!(off(printed_mean(1.000_29), &true_mean(1.000_29)) > 1e-6);
    for eta in [1.0 + 1e-12, 1.0 + 1e-6, 1.000_29, 1.01, 1.5, 10.0, 100.0] {
        let (mean, error) = dielectric_mean(eta);
        let exact = true_mean(eta);
        assert!(off(mean, &exact) * mean <= error, "{eta}: {mean:e} {error:e}");
        assert!(error <= 2e-14 * mean); // the terms are at most ten times their sum
    }
}

pub(crate) fn rows() -> Vec<Row> {
    let edge = of_sine(0.01 * (1.0 - 1e-12));
    let of_cosine = |cos: f64, eta: f64| (fresnel::dielectric(cos, eta), truth(Polar::from_cos(cos), eta));
    let (matched, air) = (of_cosine(1e-9, 1.0), of_cosine(0.9, 1.000_29));
    vec![
        Row {
            example: "edge of total reflection: F, eta = 0.01, sin = eta (1 - 1e-12)",
            straightforward: printed(edge.cos, 0.01),
            ours: dielectric(0.01).reflectance_at(edge).x,
            truth: truth(edge, 0.01),
            test: "edge_of_total_internal_reflection",
        },
        Row {
            example: "eta = 1: F, mu = 1e-9",
            straightforward: printed(1e-9, 1.0),
            ours: matched.0,
            truth: matched.1,
            test: "matched_indices",
        },
        Row {
            example: "eta = 1.00029: F, mu = 0.9, in f32",
            straightforward: printed_f32(0.9, 1.000_29).into(),
            ours: air.0,
            truth: air.1,
            test: "nearly_matched_indices",
        },
        Row {
            example: "eta = 1.00029: mean of F over the hemisphere",
            straightforward: printed_mean(1.000_29),
            ours: dielectric_mean(1.000_29).0,
            truth: true_mean(1.000_29),
            test: "nearly_matched_indices",
        },
    ]
}
