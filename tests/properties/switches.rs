//! Every place where one formula takes over from another: both say the same there.
//!
//! Each test names the switch. The functions are asked at the switch and at the two numbers next to it on either side, where
//! the function itself has changed by a rounding times its condition and no more.

use glam::DVec3;
use std::f64::consts::{E, FRAC_1_SQRT_2};
use whitefurnace::bxdf::{Microfacet, Model};
use whitefurnace::distribution::{Anisotropic, Elliptic, Family};
use whitefurnace::estimate::{Effort, Estimate, Estimator};
use whitefurnace::fresnel::{Fresnel, conductor, conductor_approximate, dielectric, dielectric_mean};
use whitefurnace::geometry::{Polar, half_vector};
use whitefurnace::integrate::{Integrator, Target};
use whitefurnace::masking::{Masking, Smith};
use whitefurnace::numerics::gaussian::{ierfc, quantile};
use whitefurnace::spectrum::Spectrum;

/// The number itself and those next to it.
fn around(x: f64) -> [f64; 5] {
    [
        x,
        x.next_down().next_down(),
        x.next_down(),
        x.next_up(),
        x.next_up().next_up(),
    ]
}

/// All values of `f` around `at` are within `tolerance` of the one there, relative to it.
fn joins(name: &str, at: f64, tolerance: f64, f: impl Fn(f64) -> f64) {
    let [here, beside @ ..] = around(at).map(&f);
    for value in beside {
        let apart = (value - here).abs();
        assert!(
            here.is_finite() && apart <= tolerance * here.abs(),
            "{name} at {at:e}: {here:e} and {value:e}"
        );
    }
}

/// A few roundings of a formula whose condition is about 1.
const FEW: f64 = 4e-15;

#[test]
fn polar_angles() {
    joins("cosine from a large tangent", 1e150, FEW, |tan| {
        Polar::from_tan(tan).cos
    });
    joins("sine from a large tangent", 1e150, FEW, |tan| Polar::from_tan(tan).sin);
    joins("logarithm of the cosine, by the sine or by itself", 0.5, FEW, |sin| {
        Polar {
            sin,
            cos: (0.75f64).sqrt(),
        }
        .ln_cos()
    });
}

#[test]
fn half_vectors_of_nearly_opposite_directions() {
    let half = |y: f64| half_vector(DVec3::X, DVec3::new(-1.0, y, 0.0)).unwrap();
    joins("half vector", 1e-140, FEW, |y| half(y).wh.y);
    joins("its cosine", 1e-140, FEW, |y| half(y).cos_d);
}

#[test]
fn fresnel_terms() {
    for eta in [0.01f64, 0.5, 0.99, 1.000_1, 1.5, 100.0] {
        // 1 - 1/eta of the sine is what beyond and within 45 degrees differ in
        let condition = 1.0 / (eta - 1.0).abs().min(1.0);
        joins("dielectric at 45 degrees", FRAC_1_SQRT_2, FEW * condition, |cos| {
            dielectric(cos, eta)
        });
    }
    for eta in [0.01f64, 0.5, 0.9] {
        let edge = f64::sqrt((1.0 - eta) * (1.0 + eta));
        // F has a square root there: a rounding of the cosine is 1e-8 of it, over eta^2
        joins("total internal reflection", edge, 1e-7 / (eta * eta), |cos| {
            dielectric(cos, eta)
        });
    }
    let absolute = |name: &str, at: f64, most: f64, f: &dyn Fn(f64) -> f64| {
        let [here, beside @ ..] = around(at).map(f);
        assert!(
            beside.iter().all(|value| (value - here).abs() <= most),
            "{name}: {here:e}, {beside:?}"
        );
    };
    absolute("matched indices", 1.0, 1e-15, &|eta| dielectric(0.3, eta));
    absolute("matched indices of a conductor", 1.0, 1e-15, &|eta| {
        conductor(0.3, eta, 0.0)
    });
    for (eta, k) in [(1.5, 0.0), (0.2, 3.0), (100.0, 100.0)] {
        let f = [0.0, 5e-324, 1e-300].map(|cos| conductor(cos, eta, k));
        assert!(f.iter().all(|f| (f - 1.0).abs() < 1e-15), "the horizon: {f:?}"); // a few roundings
    }
    assert!(
        [0.0, 5e-324]
            .iter()
            .all(|cos| (dielectric(*cos, 1.5) - 1.0).abs() < 1e-15)
    );
    // the real part of n^2 - sin^2 changes its sign
    for (eta, k) in [(0.8f64, 0.3f64), (0.05, 0.001), (0.3, 0.2)] {
        let cos = (1.0 - (eta - k) * (eta + k)).sqrt();
        joins("root of a conductor", cos, FEW / (eta * k), |cos| {
            conductor(cos, eta, k)
        }); // n^2 - sin^2 is 2 eta k there
        let approximate = |cos| conductor_approximate(cos, eta, k);
        joins("approximate conductor", FRAC_1_SQRT_2, FEW, approximate);
    }
    // what absorbs nothing is a dielectric
    for cos in [1e-9, 0.1, 0.7, 0.99, 1.0] {
        for eta in [0.01, 0.3, 0.9, 1.1, 1.5, 100.0] {
            let (a, b) = (conductor(cos, eta, 0.0), dielectric(cos, eta));
            // beyond the edge a rounding of F = 1, before it of r^2, whose root is lost once
            assert!((a - b).abs() < 1e-13, "{cos} {eta}: {a} {b}");
        }
    }
}

#[test]
fn means_of_fresnel_terms() {
    for (name, eta) in [
        ("denser or rarer side", 1.0),
        ("logarithm of n by its step", 2.0),
        ("series of q", E),
        ("logarithm of (n - 1)/(n + 1)", 3.0),
    ] {
        for eta in [eta, 1.0 / eta] {
            let [(here, error), beside @ ..] = around(eta).map(dielectric_mean);
            for (value, other) in beside {
                // and two roundings of eta, of which the mean changes by 7/3 at most
                let most = error + other + 14.0 / 3.0 * f64::EPSILON * eta;
                assert!((value - here).abs() <= most, "{name}, {eta}: {here:e} {value:e}");
            }
        }
    }
}

#[test]
fn gaussian_integrals() {
    joins("ierfc, difference or sum", 2.0, 8e-15, ierfc); // its stated error on either side
    assert!(
        ierfc(26.5) > 0.0 && ierfc(26.5) < 1e-300 && ierfc(27.5) == 0.0,
        "underflow"
    );
    for u in around(0.5) {
        assert!(quantile(u).abs() < 1e-15, "halves of the quantile");
    }
    // the largest slope that a uniform number reaches, at both ends
    assert_eq!(quantile(0.0), -quantile(1.0));
}

/// Slopes that are seen, from the lower and from the upper half of their distribution.
#[test]
fn visible_slopes() {
    for mu in [0.0, 1e-3, 0.4, 0.999, 1.0] {
        for kind in [Elliptic::Beckmann, Elliptic::Ggx] {
            let smith = Smith::new(&Anisotropic::new(kind, 0.3, 0.7).unwrap().into()).unwrap();
            let wo = Polar::from_cos(mu).direction(0.4);
            let [here, beside @ ..] = around(0.5).map(|u| smith.sample_visible(wo, [u, 0.3]));
            // the density of slopes is about 1 there
            assert!(beside.iter().all(|h| (*h - here).length() < 1e-14), "{mu} {kind:?}");
        }
    }
}

#[test]
fn distributions() {
    let vmf = |kappa: f64| Family::Vmf.with(kappa).unwrap();
    let theta = Polar::from_angle(0.7);
    // as good as uniform, and nearly so
    joins("uniform density", 1e-16, FEW, |kappa| vmf(kappa).p(theta));
    joins("uniform exposure", 1e-16, FEW, |kappa| vmf(kappa).exposure(theta));
    for exposure in [1e-9, 0.3, 3.0, 50.0] {
        joins("uniform angle", 1e-16, FEW, |kappa| {
            vmf(kappa).at_exposure(exposure).sin
        });
        joins("uniform cosine", 1e-16, FEW, |kappa| {
            vmf(kappa).at_exposure(exposure).cos
        });
        joins("angle of a wide lobe", 1.0, 10.0 * FEW, |kappa| {
            vmf(kappa).at_exposure(exposure).sin
        });
        joins("cosine of a wide lobe", 1.0, 10.0 * FEW, |kappa| {
            vmf(kappa).at_exposure(exposure).cos
        });
    }
    for (name, kappa, exposure) in [
        ("nothing reaches the horizon", 50.0, 10.0),
        ("nothing reaches the horizon", 1e12, 1e12 - 40.0),
        ("logarithm of the sum", 30.0, 0.7),
        ("logarithm of the sum", 2.0, 0.7),
        ("large exposures", 630.0, 600.0),
        ("underflow of the exponential", 5.0, 45.0),
        ("underflow of the exponential", 700.0, 740.0),
    ] {
        // what a rounding of E changes: kappa cos = kappa - E nearly, or ln cos = -E
        let condition = 1.0 + exposure;
        joins(name, exposure, FEW * condition, |e| vmf(kappa).at_exposure(e).cos);
        joins(name, exposure, FEW * condition, |e| vmf(kappa).at_exposure(e).versine());
    }
    for kappa in [0.5, 2.0, 17.0, 1e3] {
        let median = vmf(kappa).inverse_cdf(0.5);
        joins("halves of the distribution", median.sin, FEW, |sin| {
            vmf(kappa).exposure(Polar { sin, ..median })
        });
        let middle = vmf(kappa).exposure(Polar::from_cos(0.5));
        joins("versine or cosine", middle, FEW * (1.0 + middle), |e| {
            vmf(kappa).at_exposure(e).cos
        });
    }
    for alpha in [1e-6, 0.3, 10.0] {
        let ggx = Family::Ggx.with(alpha).unwrap();
        joins("steep slopes", 1e-150 / alpha, FEW, |cos| {
            ggx.exposure(Polar { sin: 1.0, cos })
        });
        joins("large exposures", 40.0, 100.0 * FEW, |e| ggx.at_exposure(e).cos); // E is 40 and its rounding so large
    }
}

const ONE: Spectrum = Spectrum::grey(1.0);

fn estimate(model: &Model, mu: f64, phi: f64) -> Estimate {
    let effort = Effort {
        tolerance: 1e-9,
        samples: None,
        seed: 0,
    };
    let integrator = Integrator::new(model, Estimator::Quadrature, effort).unwrap();
    integrator.estimate(Target::rho_hd(mu, phi), 0).unwrap()
}

fn agree(name: &str, a: Estimate, b: Estimate) {
    let beyond = (a.value - b.value).abs() - a.error - b.error;
    assert!(beyond.max_element() <= 1e-15, "{name}: {a:?} and {b:?}"); // and the rounding of the argument
}

/// Integrals on both sides of a cosine at which another method takes over.
fn continue_at(name: &str, model: &Model, mu: f64) {
    let [here, beside @ ..] = around(mu).map(|mu| estimate(model, mu.clamp(0.0, 1.0), 0.3));
    beside.into_iter().for_each(|other| agree(name, here, other));
}

fn lobe(
    distribution: impl Into<whitefurnace::distribution::Distribution>,
    masking: Masking,
    fresnel: Fresnel,
) -> Model {
    Model::Microfacet(Microfacet::new(ONE, distribution, masking, fresnel).unwrap())
}

fn glass(eta: f64) -> Fresnel {
    Fresnel::dielectric(Spectrum::grey(eta)).unwrap()
}

/// Above mu = 1e-9 and for alpha up to 1, or without a Fresnel term, whole rules integrate Smith lobes; facets do the rest.
#[test]
fn rules_of_smith_lobes() {
    for family in [Family::Ggx, Family::Beckmann] {
        for masking in [Masking::Smith, Masking::SmithCorrelated] {
            for fresnel in [Fresnel::None, glass(1.5), glass(0.7)] {
                for width in [1e-3, 0.3, 1.0] {
                    let model = lobe(family.with(width).unwrap(), masking, fresnel);
                    continue_at("grazing", &model, 1e-9);
                }
                let [here, beside @ ..] =
                    around(1.0).map(|width| estimate(&lobe(family.with(width).unwrap(), masking, fresnel), 0.4, 0.0));
                beside.into_iter().for_each(|other| agree("wide lobes", here, other));
            }
        }
    }
}

/// Isotropic lobes have rules of their own, and an anisotropic one with equal axes is the same lobe.
#[test]
fn isotropic_and_elliptic_lobes() {
    for (kind, parameter) in [
        (Elliptic::Beckmann, 0.2),
        (Elliptic::Beckmann, 1e-4),
        (Elliptic::Ggx, 0.3),
        (Elliptic::AshikhminShirley, 0.0),
        (Elliptic::AshikhminShirley, 1e4),
    ] {
        let round = kind.family().with(parameter).unwrap();
        let elliptic = Anisotropic::new(kind, parameter, parameter).unwrap();
        for fresnel in [Fresnel::None, glass(1.5), glass(0.7)] {
            for mu in [0.0, 1e-12, 1e-3, 0.5, 1.0] {
                let of = |model: Model| estimate(&model, mu, 0.3);
                let (a, b) = (
                    lobe(round, Masking::VGroove, fresnel),
                    lobe(elliptic, Masking::VGroove, fresnel),
                );
                agree("V-grooves", of(a), of(b));
                if kind != Elliptic::AshikhminShirley {
                    let [a, b] = [round.into(), elliptic.into()]
                        .map(|d: whitefurnace::distribution::Distribution| lobe(d, Masking::SmithCorrelated, fresnel));
                    agree("Smith", of(a), of(b));
                }
            }
        }
    }
}

/// Cosines at which the integrals are set up differently: the smallest normal number, the horizon, the normal, 45 degrees.
#[test]
fn cosines_of_integrals() {
    let streak = Anisotropic::new(Elliptic::Ggx, 0.04, 1.0).unwrap();
    let models = [
        lobe(Family::Vmf.with(17.0).unwrap(), Masking::VGroove, glass(1.5)),
        lobe(Family::Beckmann.with(1e-4).unwrap(), Masking::VGroove, glass(0.7)),
        lobe(Family::Ggx.with(0.3).unwrap(), Masking::SmithCorrelated, glass(0.7)),
        lobe(streak, Masking::Smith, glass(0.7)),
        lobe(streak, Masking::VGroove, Fresnel::None),
    ];
    for model in &models {
        continue_at("the smallest normal number", model, f64::MIN_POSITIVE);
        continue_at("45 degrees", model, FRAC_1_SQRT_2);
        // theta = 1e-7, below which distances from it are not resolved
        continue_at("next to the normal", model, 1.0 - 0.5e-14);
        for mu in [5e-324, 1e-300, 1e-200] {
            agree("the horizon", estimate(model, 0.0, 0.3), estimate(model, mu, 0.3));
        }
        agree(
            "the normal",
            estimate(model, 1.0, 0.3),
            estimate(model, 1.0f64.next_down(), 0.3),
        );
    }
}

/// Axes in a ratio of which the turn of the azimuth is split, and is not.
#[test]
fn ratios_of_axes() {
    for ratio in [LARGEST_TURN, 1.0] {
        for masking in [Masking::VGroove, Masking::Smith] {
            let [here, beside @ ..] = around(0.5 * ratio).map(|x| {
                let streak = Anisotropic::new(Elliptic::Ggx, x, 0.5).unwrap();
                estimate(&lobe(streak, masking, glass(0.7)), 0.3, 1.0)
            });
            beside
                .into_iter()
                .for_each(|other| agree("ratio of the axes", here, other));
        }
    }
}

/// The ratio in `integrate::facets`.
const LARGEST_TURN: f64 = 0.35;
