//! Rough surfaces seen along the surface: Smith's Lambda, Ashikhmin's diffuse base, Oren and Nayar's tangent.

use crate::big::{Big, beckmann_lambda, big, off, one, pi};
use crate::common::cases::{beckmann, ggx};
use crate::common::rules::composite;
use crate::row::Row;
use glam::DVec3;
use std::f64::consts::{FRAC_1_PI, FRAC_PI_2, PI};
use whitefurnace::bxdf::{Bxdf, FresnelBlend, OrenNayar};
use whitefurnace::distribution::{Anisotropic, Distribution, Elliptic, Family, Isotropic};
use whitefurnace::geometry::Polar;
use whitefurnace::masking::Smith;
use whitefurnace::spectrum::Spectrum;

/// alpha^2/(pi ((n.h)^2 (alpha^2 - 1) + 1)^2) [Walter et al. 2007, eq. 33], as it stands in most shaders.
fn printed_ggx(alpha: f64, cos: f64) -> f64 {
    let square = alpha * alpha;
    let stretched = cos * cos * (square - 1.0) + 1.0;
    square / (PI * stretched * stretched)
}

fn true_ggx(alpha: f64, sin: &Big) -> Big {
    let square = big(alpha) * big(alpha);
    let stretched = &square * (one() - sin * sin) + sin * sin;
    square / (pi() * &stretched * &stretched)
}

/// (sqrt(1 + alpha^2 tan^2) - 1)/2 [Heitz 2014, eq. 72].
fn printed_lambda(alpha: f64, mu: f64) -> f64 {
    let tan_squared = (1.0 - mu * mu) / (mu * mu);
    0.5 * (libm::sqrt(1.0 + alpha * alpha * tan_squared) - 1.0)
}

fn true_lambda(alpha: f64, sin: f64, mu: f64) -> Big {
    let slope = big(alpha) * big(sin) / big(mu);
    ((one() + &slope * &slope).sqrt() - one()) / big(2.0)
}

fn slopes(distribution: impl Into<Distribution>) -> Smith {
    Smith::new(&distribution.into()).unwrap()
}

/// Lambda for widths and cosines over hundreds of decades, and D.
#[test]
fn ggx_of_narrow_width_at_the_horizon() {
    // narrower lobes are refused: a table of them would be one of a mirror
    for family in [Family::Ggx, Family::Beckmann] {
        let refused = family.with(1e-8).unwrap_err().to_string();
        assert!(refused.contains("1e-8") && refused.contains("[1e-6, 10]"), "{refused}");
    }
    assert!(Anisotropic::new(Elliptic::Ggx, 1e-8, 1.0).is_err());
    assert!(off(printed_ggx(1e-8, 1.0), &true_ggx(1e-8, &big(0.0))) > 0.1); // alpha^2 - 1 rounds alpha^2 to 1.1e-16
    assert!(off(printed_ggx(1e-6, 1.0), &true_ggx(1e-6, &big(0.0))) > 1e-5);
    assert_eq!(printed_lambda(1e-6, 1e-160), f64::INFINITY); // of 5e153
    assert!(off(printed_lambda(1e-6, 0.5), &true_lambda(1e-6, libm::sqrt(0.75), 0.5)) > 1e-5); // 7.5e-13 beside 1
    for alpha in [1e-6, 1e-3, 0.3, 1.0, 10.0] {
        for sin in [0.0, 1e-9, 1e-7, 1e-6, 1e-5, 1e-3, 0.5] {
            let theta = Polar::from_angle(libm::asin(sin));
            let error = off(ggx(alpha).d(theta), &true_ggx(alpha, &big(theta.sin)));
            assert!(error <= 8.0 * f64::EPSILON, "{alpha} {sin}: {error:e}"); // two squares, their sum, a square
        }
        let slopes = slopes(ggx(alpha));
        for mu in [1.0, 0.5, 1e-3, 1e-6, 1e-20, 1e-160, 1e-300] {
            let w = Polar::from_cos(mu).direction(0.0);
            let lambda = true_lambda(alpha, w.x, mu);
            let error = off(slopes.lambda(w, mu), &lambda);
            assert!(error <= 6.0 * f64::EPSILON, "{alpha} {mu:e}: {error:e}"); // a root, a sum, two quotients
            let error = off(slopes.g1(w, mu), &(one() / (one() + lambda)));
            assert!(error <= 6.0 * f64::EPSILON, "{alpha} {mu:e}: {error:e}");
        }
    }
}

/// (erf(a) - 1)/2 + e^(-a^2)/(2 a sqrt(pi)) [Heitz 2014, eq. 66].
fn printed_beckmann_lambda(a: f64) -> f64 {
    0.5 * (libm::erf(a) - 1.0) + libm::exp(-a * a) / (2.0 * a * libm::sqrt(PI))
}

#[test]
fn lambda_of_beckmann_for_large_arguments() {
    let mut worst = 0.0f64;
    for m in [1e-6, 0.05, 0.4, 10.0] {
        let slopes = slopes(beckmann(m));
        for mu in [1e-160, 1e-6, 1e-3, 0.02, 0.1, 0.2, 0.3, 0.5, 0.7, 0.8, 0.95] {
            let w = Polar::from_cos(mu).direction(0.0);
            let a = big(mu) / (big(m) * big(w.x));
            if a > big(26.0) {
                continue;
            }
            let (size, truth) = (off(mu / (m * w.x), &big(0.0)), beckmann_lambda(&a));
            if size > 4.0 {
                worst = worst.max(off(printed_beckmann_lambda(size), &truth));
            }
            let error = off(slopes.lambda(w, mu), &truth);
            // e^(-a^2) of an a of two roundings, which count 2 a^2 times each, and a dozen of ierfc
            let allowed = f64::EPSILON * (18.0 + 4.0 * size * size);
            assert!(error <= allowed, "m {m} mu {mu:e}, a {size}: {error:e}");
        }
    }
    // erf is 1, and what is left is the second term, 2 a^2 times too large
    assert!(worst > 30.0, "{worst}");
    // beyond the smallest number Lambda is 0, and never less
    assert_eq!(
        slopes(beckmann(1e-6)).lambda(Polar::from_cos(0.5).direction(0.0), 0.5),
        0.0
    );
}

/// 1 - (1 - mu/2)^5 [pbrt 2010, section 8.5].
fn printed_base(mu: f64) -> f64 {
    let rest = 1.0 - 0.5 * mu;
    1.0 - rest * rest * rest * rest * rest
}

fn true_base(mu: f64) -> Big {
    one() - (one() - big(mu) / big(2.0)).powi(5.into())
}

/// rd (1 - rs) (1 - (1 - mu/2)^5), the albedo of the base, at rd = 1 and rs = 0.
fn base(mu: f64) -> f64 {
    let blend = FresnelBlend::new(Spectrum::grey(1.0), Spectrum::grey(0.0), ggx(0.3)).unwrap();
    blend.diffuse_rho_hd(mu).x
}

#[test]
fn fifth_power_for_small_mu() {
    for mu in [1e-6, 1e-9, 1e-12, 1e-15, 1e-17, 1e-160, 1e-300] {
        assert!(off(printed_base(mu), &true_base(mu)) > 1e-12, "{mu:e}");
    }
    assert_eq!(printed_base(1e-17), 0.0);
    for mu in [
        1.0, 0.7, 0.1, 1e-3, 1e-6, 1e-9, 1e-12, 1e-15, 1e-17, 1e-160, 1e-300, 0.0,
    ] {
        let error = off(base(mu), &true_base(mu));
        assert!(error <= 4.0 * f64::EPSILON, "{mu:e}: {error:e}"); // a sum of positive terms
    }
}

/// R/pi (A + B max(0, cos phi) sin alpha tan beta) [pbrt 2010, section 8.4.1], for R = 1.
fn printed_oren_nayar(sigma_deg: f64, wo: DVec3, wi: DVec3) -> f64 {
    let (a, b) = constants(sigma_deg);
    let sine = |w: DVec3| libm::sqrt(f64::max(0.0, 1.0 - w.z * w.z));
    let cos_phi = (wo.x * wi.x + wo.y * wi.y) / (sine(wo) * sine(wi));
    let (sin_alpha, tan_beta) = if wi.z.abs() > wo.z.abs() {
        (sine(wo), sine(wi) / wi.z.abs())
    } else {
        (sine(wi), sine(wo) / wo.z.abs())
    };
    FRAC_1_PI * (a + b * f64::max(0.0, cos_phi) * sin_alpha * tan_beta)
}

fn constants(sigma_deg: f64) -> (f64, f64) {
    let variance = sigma_deg.to_radians().powi(2);
    (
        1.0 - variance / (2.0 * (variance + 0.33)),
        0.45 * variance / (variance + 0.09),
    )
}

/// rho_hd with the integral over theta_i split at theta_o: A + (2B/pi) ((theta - sin cos) sin/2 + (sin/cos) (1 - sin^3)/3).
fn printed_rho(sigma_deg: f64, mu: f64) -> f64 {
    let (a, b) = constants(sigma_deg);
    let sin = libm::sqrt(1.0 - mu * mu);
    let theta = libm::acos(mu);
    a + 2.0 * b / PI * (0.5 * sin * (theta - sin * mu) + sin / mu * (1.0 - sin * sin * sin) / 3.0)
}

fn true_rho(sigma_deg: f64, mu: f64) -> Big {
    let (a, b) = constants(sigma_deg);
    let cos = big(mu);
    let sin = (one() - &cos * &cos).sqrt();
    let theta = sin.atan2(&cos);
    let below = &sin * (theta - &sin * &cos) / big(2.0);
    // at the horizon (1 - sin^3)/cos tends to 0
    let above = if mu == 0.0 {
        big(0.0)
    } else {
        &sin / cos * (one() - &sin * &sin * &sin) / big(3.0)
    };
    big(a) + big(2.0) * big(b) / pi() * (below + above)
}

#[test]
fn oren_nayar_at_the_horizon() {
    let across = (DVec3::X, DVec3::Y);
    for sigma_deg in [1.0, 20.0, 90.0] {
        let (a, b) = constants(sigma_deg);
        let model = OrenNayar::new(Spectrum::grey(1.0), sigma_deg).unwrap();
        // azimuths apart by a right angle or more: no light from facet to facet, A/pi at every height
        assert!(printed_oren_nayar(sigma_deg, across.0, across.1).is_nan());
        for wi in [DVec3::Y, DVec3::NEG_X, DVec3::new(-0.6, 0.8, 0.0)] {
            let error = off(model.f(DVec3::X, wi).x, &(big(a) / pi()));
            assert!(error <= 2.0 * f64::EPSILON, "{sigma_deg}: {error:e}");
        }
        // along the same azimuth f grows like 1/cos: finite, and what is integrated of it too
        assert_eq!(printed_oren_nayar(sigma_deg, DVec3::X, DVec3::X), f64::INFINITY);
        assert!(model.f(DVec3::X, DVec3::X).x.is_finite());
        for low in [0.1, 1e-8, 1e-160, 1e-300] {
            let (wo, wi) = (
                Polar::from_cos(low).direction(0.0),
                Polar::from_cos(0.5 * low).direction(0.0),
            );
            let truth = (big(a) + big(b) * big(wo.x) * big(wi.x) / big(low)) / pi();
            let error = off(model.f(wo, wi).x, &truth);
            assert!(error <= 6.0 * f64::EPSILON, "{sigma_deg} {low:e}: {error:e}"); // A and B, a quotient, a sum
        }
        for wo in [DVec3::X, DVec3::new(1.0, 0.0, 1e-300)] {
            for u in [[0.0, 0.3, 0.99], [1e-12, 0.5, 0.999], [0.9, 0.1, 0.0]] {
                let drawn = model.sample_f(wo, u);
                assert!((0.0..=1.04).contains(&drawn.weight.x), "{drawn:?}"); // A + 2B/pi
            }
        }
        assert!(printed_rho(sigma_deg, 0.0).is_nan());
        for mu in [1.0, 0.5, 1e-3, 1e-8, 1e-160, 0.0] {
            let error = off(model.rho_hd(mu).x, &true_rho(sigma_deg, mu));
            assert!(error <= 8.0 * f64::EPSILON, "{sigma_deg} {mu:e}: {error:e}"); // A, B, and a sum of three
        }
        // the formula itself by the midpoints of theta_i, whose integrand has a corner at theta_o
        for mu in [0.0, 0.3] {
            let theta_o = libm::acos(mu);
            let integrand = |theta: f64| {
                let (alpha, beta) = (theta.max(theta_o), theta.min(theta_o));
                2.0 * libm::sin(alpha) * libm::tan(beta) * libm::sin(theta) * libm::cos(theta)
            };
            let [low, high] =
                [(0.0, theta_o), (theta_o, FRAC_PI_2)].map(|(from, to)| composite(from, to, 40, integrand));
            let rho = a + b / PI * (low + high);
            assert!(off(rho, &true_rho(sigma_deg, mu)) < 1e-13, "{sigma_deg} {mu}: {rho}"); // five points a panel
        }
    }
}

pub(crate) fn rows() -> Vec<Row> {
    let mu = 1e-160;
    let low = Polar::from_cos(mu).direction(0.0);
    let upright = Polar::from_cos(0.8).direction(0.0);
    let argument = 0.8 / (0.2 * upright.x);
    let rough = OrenNayar::new(Spectrum::grey(1.0), 20.0).unwrap();
    let narrow: Isotropic = ggx(1e-6);
    vec![
        Row {
            example: "GGX at the pole: D, alpha = 1e-6",
            straightforward: printed_ggx(1e-6, 1.0),
            ours: narrow.d(Polar::POLE),
            truth: true_ggx(1e-6, &big(0.0)),
            test: "ggx_of_narrow_width_at_the_horizon",
        },
        Row {
            example: "GGX at the horizon: Lambda, alpha = 1e-6, mu = 1e-160",
            straightforward: printed_lambda(1e-6, mu),
            ours: slopes(narrow).lambda(low, mu),
            truth: true_lambda(1e-6, low.x, mu),
            test: "ggx_of_narrow_width_at_the_horizon",
        },
        Row {
            example: "Lambda of Beckmann: m = 0.2, mu = 0.8",
            straightforward: printed_beckmann_lambda(argument),
            ours: slopes(beckmann(0.2)).lambda(upright, 0.8),
            truth: beckmann_lambda(&(big(0.8) / (big(0.2) * big(upright.x)))),
            test: "lambda_of_beckmann_for_large_arguments",
        },
        Row {
            example: "1 - (1 - mu/2)^5: mu = 1e-15",
            straightforward: printed_base(1e-15),
            ours: base(1e-15),
            truth: true_base(1e-15),
            test: "fifth_power_for_small_mu",
        },
        Row {
            example: "Oren-Nayar at the horizon: f, sigma = 20 deg, phi = 90 deg",
            straightforward: printed_oren_nayar(20.0, DVec3::X, DVec3::Y),
            ours: rough.f(DVec3::X, DVec3::Y).x,
            truth: big(constants(20.0).0) / pi(),
            test: "oren_nayar_at_the_horizon",
        },
    ]
}
