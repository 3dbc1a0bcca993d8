//! Albedos: what a nearly lossless lobe loses, and the narrowest GGX along the surface.

use crate::big::{Big, big, off, one};
use crate::common::cases::{beckmann, ggx, grooves, phong, smith, vmf};
use crate::common::rules::{composite, octaves};
use crate::row::Row;
use std::f64::consts::{FRAC_PI_2, PI};
use whitefurnace::bxdf::{Coupling, DiffuseSpecular, Model};
use whitefurnace::distribution::Isotropic;
use whitefurnace::estimate::Estimate;
use whitefurnace::fresnel::Fresnel;
use whitefurnace::integrate::Target;
use whitefurnace::integrate::deterministic::{quadrature, unspent};
use whitefurnace::spectrum::Spectrum;

const TOLERANCE: f64 = 1e-10;

/// 1 - rho_bar of V-grooves with F = 1, as the energy-preserving coupling divides by it.
fn lost(lobe: Isotropic) -> Estimate {
    let one = Spectrum::grey(1.0);
    let model = Model::Microfacet(grooves(lobe, Fresnel::None));
    let coupled = DiffuseSpecular::new(model, one, one, Coupling::EnergyPreserving).unwrap();
    unspent(&coupled, TOLERANCE).unwrap()
}

/// 1 - rho_bar, rho_bar computed first.
fn one_minus(lobe: Isotropic) -> f64 {
    let model = Model::Microfacet(grooves(lobe, Fresnel::None));
    1.0 - quadrature(&model, Target::rho_hh(), TOLERANCE).unwrap().value.x
}

/// What facets of one tilt theta lose: (1/pi) int max(0, s - 2 max(0, n.i)) do with s = max(0, min((o.h)/(n.h), 2 (n.o))),
/// o in polar coordinates around h, by the same points for every theta.
fn lost_by_tilt(theta: f64) -> f64 {
    let (sin_h, cos_h) = (libm::sin(theta), libm::cos(theta));
    2.0 / PI
        * composite(0.0, FRAC_PI_2, 120, |theta_d| {
            let (sin, cos) = (libm::sin(theta_d), libm::cos(theta_d));
            sin * composite(0.0, PI, 120, |phi| {
                let (level, swing) = (cos_h * cos, sin_h * sin * libm::cos(phi));
                let seen = (cos / cos_h).min(2.0 * (level - swing)).max(0.0);
                (seen - 2.0 * (level + swing).max(0.0)).max(0.0)
            })
        })
}

/// 1/kappa + 2!/kappa^2 + 3!/kappa^3 + ..., the mean of 1/cos - 1 over the lobe: kappa (1 - cos) is an exponential variate.
/// For kappa = 1000 and 1e6 it is what `tests/quadrature.rs` has from the definition in 30 digits.
fn true_loss_of_vmf(kappa: f64) -> Big {
    let (mut term, mut sum) = (one(), big(0.0));
    for j in 1..=30 {
        term = term * big(f64::from(j)) / big(kappa);
        sum += &term;
    }
    sum
}

/// The same mean for Beckmann, where 1/cos = sqrt(1 + m^2 E) of an exponential variate E: the binomial series of its moments j!.
fn true_loss_of_beckmann(m: f64) -> Big {
    let (mut term, mut sum) = (one(), big(0.0));
    for j in 1..=12 {
        let j = f64::from(j);
        // binomial (1/2 over j) j!
        term = term * big(1.5 - j) * big(m) * big(m);
        sum += &term;
    }
    sum
}

/// And for Phong, where 1/cos = e^(E/(n + 2)): 1/(n + 1).
fn true_loss_of_phong(n: f64) -> Big {
    one() / (big(n) + one())
}

#[test]
fn one_minus_rho_bar_of_narrow_lobes() {
    // every tilt up to 45 degrees loses 1/cos - 1; rules of five points, blind to the corners of the integrand
    for theta in [0.05, 0.2, 0.5, 0.75] {
        let difference = lost_by_tilt(theta) - (1.0 / libm::cos(theta) - 1.0);
        assert!(difference.abs() < 1e-5, "{theta}: {difference:e}");
    }
    let mut cases: Vec<(Isotropic, Big)> = Vec::new();
    // of these lobes less than e^-90 is steeper
    for kappa in [400.0, 1e3, 1e6, 1e9, 1e12] {
        cases.push((vmf(kappa), true_loss_of_vmf(kappa)));
    }
    for m in [0.03, 1e-3, 1e-6] {
        cases.push((beckmann(m), true_loss_of_beckmann(m)));
    }
    for n in [400.0, 1e4, 1e8] {
        cases.push((phong(n), true_loss_of_phong(n)));
    }
    for (lobe, truth) in &cases {
        let found = lost(*lobe);
        let (error, stated) = (off(found.value.x, truth), found.error.x / found.value.x);
        // the tolerance is relative to the squared width, up to twice what is lost
        assert!(stated <= 4.0 * TOLERANCE, "{lobe:?}: {found:?}");
        assert!(error <= stated + 1e-13, "{lobe:?}: {found:?} off by {error:e}");
    }
    assert!(off(one_minus(vmf(1e12)), &true_loss_of_vmf(1e12)) > 1e-6);
    // and in f32, as a shader has it from a table of rho_bar, nothing is left from kappa = 2^25 on
    assert_eq!(1.0 - (1.0 - one_minus(vmf(3.4e7))) as f32, 0.0);
    assert!(1.0 - (1.0 - one_minus(vmf(3.3e7))) as f32 > 0.0);
}

/// rho_hd of GGX with F = 1 along the surface.
///
/// Seen from there the slope x towards wo has the density x/(1 + x^2)^(3/2), and wi leaves at (n.i)/alpha = 2x. With
/// G1(i) = 4x/(2x + sqrt(4x^2 + 1)) uncorrelated Smith keeps int G1(i) x/(1 + x^2)^(3/2) dx, here with x = tan v;
/// correlated Smith keeps everything.
#[test]
fn albedo_of_ggx_at_the_horizon() {
    let kept = octaves(FRAC_PI_2, 30, 8, |v| {
        let x = libm::tan(v);
        4.0 * x / (2.0 * x + libm::sqrt(4.0 * x * x + 1.0)) * libm::sin(v)
    });
    for alpha in [1e-6, 1e-5] {
        for mu in [0.0, 1e-300, 1e-160, 1e-20] {
            for (correlated, truth) in [(false, kept), (true, 1.0)] {
                let model = Model::Microfacet(smith(ggx(alpha), Fresnel::None, correlated));
                let found = quadrature(&model, Target::rho_hd(mu, 0.0), 1e-7).unwrap();
                let difference = (found.value.x - truth).abs();
                // facets as steep as 1/alpha slopes, one in 1/alpha, are what the limit leaves out
                assert!(
                    difference <= found.error.x + 10.0 * alpha,
                    "{alpha} {mu:e}: {found:?}, {truth}"
                );
            }
        }
    }
}

pub(crate) fn rows() -> Vec<Row> {
    vec![Row {
        example: "1 - rho_bar: V-grooves of vMF, kappa = 1e12, F = 1",
        straightforward: one_minus(vmf(1e12)),
        ours: lost(vmf(1e12)).value.x,
        truth: true_loss_of_vmf(1e12),
        test: "one_minus_rho_bar_of_narrow_lobes",
    }]
}
