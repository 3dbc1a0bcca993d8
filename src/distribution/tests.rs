//! Densities, exposures and their inverses over the whole legal ranges.

use super::*;
use crate::numerics::quadrature::{Piece, integrate_scalar};

fn all() -> Vec<Isotropic> {
    let mut all = Vec::new();
    for kappa in [0.0, 1e-17, 1e-9, 1e-3, 0.5, 1.0, 17.0, 720.0, 1e5, 1e12] {
        all.push(Family::Vmf.with(kappa).unwrap());
    }
    for m in [1e-6, 1e-3, 0.2, 1.0, 10.0] {
        all.push(Family::Beckmann.with(m).unwrap());
    }
    for n in [0.0, 1e-6, 1.0, 48.0, 1e4, 1e8] {
        all.push(Family::Phong.with(n).unwrap());
    }
    for alpha in [1e-6, 1e-3, 0.2, 1.0, 10.0] {
        all.push(Family::Ggx.with(alpha).unwrap());
    }
    for alpha in [1e-3, 0.01, 0.1, 0.5, 1.0] {
        all.push(Family::Charlie.with(alpha).unwrap());
    }
    all
}

/// Eq. 14: int D cos dh = 2 pi int p sin dtheta = 1, by quadrature of the density itself over the bulk and the tail.
#[test]
fn densities_integrate_to_one() {
    for d in all() {
        // panels between quantiles resolve any width; the tail beyond E = 40 holds 4e-18
        let angles: Vec<f64> = [0.0, 0.01, 0.1, 0.5, 1.0, 2.0, 4.0, 8.0, 16.0, 40.0]
            .iter()
            .map(|e| d.at_exposure(*e).angle())
            .collect();
        let pieces: Vec<Piece> = angles
            .windows(2)
            .filter(|w| w[1] > w[0])
            .map(|w| Piece::smooth(w[0], w[1]))
            .collect();
        let total = integrate_scalar(&pieces, 1e-12, |theta| {
            let polar = Polar::from_angle(theta);
            TAU * d.p(polar) * polar.sin
        })
        .unwrap();
        assert!((total.value - 1.0).abs() < 1e-11, "{d:?}: {total:?}"); // twice the tolerance and rounding of angles
        assert!(d.d(Polar::POLE) == d.p(Polar::POLE));
    }
}

/// The density is the derivative of the CDF: 2 pi sin theta p = exp(-E) dE/dtheta.
#[test]
fn exposure_and_its_inverse_agree_from_pole_to_tail() {
    for d in all() {
        let mut previous = -1.0;
        for exponent in -40..=12 {
            let e = 2f64.powi(exponent) * 0.01;
            let polar = d.at_exposure(e);
            assert!((polar.sin.hypot(polar.cos) - 1.0).abs() < 1e-15);
            let back = d.exposure(polar);
            if polar.cos > 0.0 {
                // where E is almost log cos, cos carries E as an exponent: rounding grows with E
                // and where it is a power of the sine, the logarithm of the sine carries it
                let powers = if d.family() == Family::Charlie {
                    e.ln().abs()
                } else {
                    0.0
                };
                assert!(
                    (back - e).abs() <= 1e-14 * e * (1.0 + e + powers),
                    "{d:?}: E {e} came back as {back}"
                );
            }
            let theta = polar.angle();
            assert!(theta >= previous, "{d:?}: not monotone at E {e}");
            previous = theta;
        }
    }
}

#[test]
fn exposure_covers_the_hemisphere() {
    for d in all() {
        assert_eq!(d.exposure(Polar::POLE), 0.0);
        assert_eq!(d.exposure(Polar { sin: 1.0, cos: 0.0 }), f64::INFINITY, "{d:?}");
        assert_eq!(d.inverse_cdf(0.0), Polar::POLE);
        assert!((d.cdf(d.inverse_cdf(0.25)) - 0.25).abs() < 1e-15);
    }
}

#[test]
fn parameters_outside_the_legal_range_are_refused() {
    for (family, values) in [
        (Family::Vmf, [-1.0, 1.1e12, f64::NAN]),
        (Family::Beckmann, [0.0, 10.1, f64::INFINITY]),
        (Family::Phong, [-1e-9, 1.1e8, f64::NAN]),
        (Family::Ggx, [0.0, 10.1, f64::INFINITY]),
        (Family::Charlie, [9e-4, 1.1, f64::NAN]),
    ] {
        for value in values {
            assert!(family.with(value).is_err(), "{family:?} {value}");
        }
    }
}

/// e^(E - kappa) overflows from E = kappa + 710 on, where the angle is the horizon long since.
#[test]
fn exposures_beyond_the_exponential_are_at_the_horizon() {
    for kappa in [1.0, 17.0, 500.0] {
        for beyond in [600.0, 709.0, 710.0, 1000.0, 1e300] {
            let theta = Family::Vmf.with(kappa).unwrap().at_exposure(kappa + beyond);
            assert!(
                theta.sin == 1.0 && (0.0..1e-250).contains(&theta.cos),
                "{kappa} {beyond}: {theta:?}"
            );
        }
    }
    // and a density that has vanished there is no 0/0
    assert_eq!(Family::Vmf.with(1e9).unwrap().d(Polar { sin: 1.0, cos: 0.0 }), 0.0);
}
