//! Distributions of normals: densities, distribution functions and their inverses, from the pole to the far tail.

use crate::strategies::{distribution, isotropic, log_uniform, uniform};
use crate::{check, ensure};
use glam::DVec3;
use proptest::prelude::*;
use proptest::sample::select;
use std::f64::consts::FRAC_PI_2;
use whitefurnace::distribution::Family;
use whitefurnace::geometry::Polar;

/// A polar angle: both ends in octaves of the small quantity.
fn polar() -> BoxedStrategy<Polar> {
    prop_oneof![
        2 => (0.0..FRAC_PI_2).prop_map(Polar::from_angle),
        2 => log_uniform(-12.0, 0.0).prop_map(Polar::from_angle),
        2 => log_uniform(-300.0, 0.0).prop_map(|cos| Polar::from_cos(cos.min(1.0))),
        1 => select(vec![Polar::POLE, Polar::from_tan(f64::INFINITY), Polar::from_tan(1e150), Polar::from_tan(1e151)]),
    ]
    .boxed()
}

/// Relative distance; of equal numbers, infinities and zeros included, 0.
fn apart(a: f64, b: f64) -> f64 {
    if a == b { 0.0 } else { ((a - b) / b).abs() }
}

/// theta(E(theta)) = theta and E(theta(E)) = E, relative to sine and cosine both: what is small keeps its digits too.
#[test]
fn exposures_and_angles_are_inverses() {
    // 1e-280 times a kappa of 1e-18 is no subnormal number yet
    let exposure = prop_oneof![log_uniform(-280.0, 3.0), 0.0..1000.0];
    check(8000, &(isotropic(), exposure, polar()), |(lobe, exposure, theta)| {
        // what a rounding of E does to the angle it belongs to, and the other way round, is not the inverse's fault
        let steps = [1.0 - 4e-16, 1.0, 1.0 + 4e-16];
        let found = lobe.at_exposure(exposure);
        ensure!(
            (0.0..=1.0).contains(&found.sin) && (0.0..=1.0).contains(&found.cos),
            "{lobe:?} {exposure:e}: {found:?}"
        );
        let back = steps.map(|step| {
            let polar = Polar {
                sin: found.sin * step,
                cos: found.cos,
            };
            let other = Polar {
                sin: found.sin,
                cos: found.cos * step,
            };
            [lobe.exposure(polar), lobe.exposure(other)]
        });
        let spread = back
            .as_flattened()
            .iter()
            .map(|e| apart(*e, back[1][0]))
            .fold(0.0, f64::max);
        // a cosine below the smallest number has no angle of its own, and its product with the smallest kappa no digits
        if found.cos > 1e-285 && found.sin > f64::MIN_POSITIVE {
            let off = apart(back[1][0], exposure);
            // the angle of Charlie is a root of E, whose rounded logarithm is multiplied by the power again
            let root = if lobe.family() == Family::Charlie {
                3e-16 * exposure.ln().abs()
            } else {
                0.0
            };
            ensure!(
                off <= 4.0 * spread + 1e-14 + root,
                "{lobe:?}: E = {exposure:e} comes back {off:e} off, +- {spread:e}"
            );
        }
        let exposure = lobe.exposure(theta);
        ensure!(exposure >= 0.0, "{lobe:?} {theta:?}: {exposure}");
        if exposure.is_finite() && exposure > 1e-280 && theta.cos > 1e-285 {
            let back = steps.map(|step| lobe.at_exposure(exposure * step));
            let off = apart(back[1].sin, theta.sin).max(apart(back[1].cos, theta.cos));
            let spread = back
                .iter()
                .map(|b| apart(b.sin, back[1].sin).max(apart(b.cos, back[1].cos)))
                .fold(0.0, f64::max);
            ensure!(
                off <= 4.0 * spread + 1e-14,
                "{lobe:?}: {theta:?} comes back as {:?}, +- {spread:e}",
                back[1]
            );
        }
        Ok(())
    });
}

/// P(theta(u)) = u relative to u, and monotone.
#[test]
fn distribution_functions_and_their_inverses_agree() {
    check(6000, &(isotropic(), uniform(), uniform()), |(lobe, u, v)| {
        let theta = lobe.inverse_cdf(u);
        let cdf = lobe.cdf(theta);
        let rest = lobe.cdf(Polar {
            cos: theta.cos * (1.0 + 4e-16),
            ..theta
        });
        let spread = (rest - cdf).abs();
        ensure!(
            (cdf - u).abs() <= 2e-14 * u + 4.0 * spread,
            "{lobe:?}: P = {u:e} comes back as {cdf:e}"
        );
        let (low, high) = (lobe.inverse_cdf(u.min(v)), lobe.inverse_cdf(u.max(v)));
        ensure!(
            low.sin <= high.sin * (1.0 + 4e-15),
            "{lobe:?} {u} {v}: {low:?} {high:?}"
        ); // a few roundings
        Ok(())
    });
}

/// p and D are finite above the horizon, D (n.h) = p, and draws are unit normals above it.
#[test]
fn densities_are_finite_and_draws_are_normals() {
    let normal = (polar(), crate::strategies::phi()).prop_map(|(theta, phi)| theta.direction(phi));
    check(
        8000,
        &(distribution(), normal, [uniform(), uniform()]),
        |(lobe, h, u): (_, DVec3, _)| {
            let (p, d) = (lobe.p(h), lobe.d(h));
            ensure!(
                p.is_finite() && p >= 0.0 && d >= 0.0,
                "{lobe:?} {h:?}: p = {p:e}, D = {d:e}"
            );
            if h.z > 1e-150 {
                let product = d * h.z;
                ensure!(
                    (product - p).abs() <= 1e-12 * p + f64::MIN_POSITIVE, // exponents up to 700 multiply roundings
                    "{lobe:?} {h:?}: {p:e} and {product:e}"
                );
            }
            let drawn = lobe.sample(u);
            ensure!(
                (drawn.length() - 1.0).abs() < 1e-14 && drawn.z >= 0.0, // a few roundings
                "{lobe:?} {u:?}: {drawn:?}"
            );
            ensure!(lobe.p(drawn).is_finite(), "{lobe:?} {u:?}: {drawn:?}");
            Ok(())
        },
    );
}
