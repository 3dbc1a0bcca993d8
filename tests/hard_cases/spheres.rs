//! von Mises-Fisher lobes of large and of small kappa.

use crate::big::{Big, big, exp_beside_one, off, one, pi};
use crate::common::cases::vmf;
use crate::row::Row;
use std::f64::consts::TAU;
use whitefurnace::geometry::Polar;

/// kappa/(2 pi (e^kappa - 1)) e^(kappa n.h) [Mikkelsen 2009, eq. 29].
fn printed(kappa: f64, cos: f64) -> f64 {
    kappa / (TAU * (libm::exp(kappa) - 1.0)) * libm::exp(kappa * cos)
}

/// The same in f32, as a shader has it.
fn printed_f32(kappa: f32, cos: f32) -> f32 {
    kappa / (std::f32::consts::TAU * (libm::expf(kappa) - 1.0)) * libm::expf(kappa * cos)
}

/// cos r of eq. 31, ln(t e^kappa + (1 - t))/kappa, for the share t of normals that lie further from the pole.
fn printed_inverse(kappa: f64, t: f64) -> f64 {
    libm::log(t * libm::exp(kappa) + (1.0 - t)) / kappa
}

/// 1 - e^-kappa.
fn whole(kappa: f64) -> Big {
    one() - exp_beside_one(&big(-kappa))
}

/// kappa (1 - n.h), for the smaller of sine and cosine as given.
fn exponent(kappa: f64, theta: Polar) -> Big {
    let cos = if theta.sin < theta.cos {
        (one() - big(theta.sin) * big(theta.sin)).sqrt()
    } else {
        big(theta.cos)
    };
    big(kappa) * (one() - cos)
}

/// p, with e^-kappa taken out of both parts of eq. 29, and 1/(2 pi) at kappa = 0.
fn truth(kappa: f64, theta: Polar) -> Big {
    if kappa == 0.0 {
        return one() / (big(2.0) * pi());
    }
    big(kappa) * (-exponent(kappa, theta)).exp() / (big(2.0) * pi() * whole(kappa))
}

/// 1 - cos r for the share u of normals that lie nearer to the pole: -ln(1 - u (1 - e^-kappa))/kappa, and u at kappa = 0.
fn true_versine(kappa: f64, u: f64) -> Big {
    if kappa == 0.0 {
        return big(u);
    }
    -(one() - big(u) * whole(kappa)).ln() / big(kappa)
}

/// p and the inverse of its distribution against the truth, from the pole to 1 - P = e^-30.
fn holds(kappa: f64) {
    let lobe = vmf(kappa);
    for exposure in [0.0, 1e-12, 1e-3, 0.5, 1.0, 5.0, 30.0] {
        let theta = lobe.at_exposure(exposure);
        let error = off(lobe.p(theta), &truth(kappa, theta));
        // sin^2/(1 + cos), kappa times it, and the exponential with its factors
        let allowed = f64::EPSILON * (4.0 + 4.0 * exposure);
        assert!(error <= allowed, "kappa {kappa:e}, E {exposure}: {error:e}");
    }
    for u in [1e-12, 1e-3, 0.25, 0.5, 0.75, 0.999] {
        let error = off(lobe.inverse_cdf(u).versine(), &true_versine(kappa, u));
        // two logarithms, an exponential between them, a square root and its square
        assert!(error <= 8.0 * f64::EPSILON, "kappa {kappa:e}, u {u}: {error:e}");
    }
}

#[test]
fn kappa_above_709() {
    // e^707 with its factor 2 pi is the last that fits; the exponential makes 707 roundings of one
    assert!(off(printed(707.0, 1.0), &truth(707.0, Polar::POLE)) < 707.0 * f64::EPSILON);
    for kappa in [710.0, 1e3, 1e4, 1e6, 1e9, 1e12] {
        assert!(printed(kappa, 1.0).is_nan());
        assert_eq!(printed(kappa, 0.5).is_nan(), kappa > 1420.0); // 0 times something finite, or infinite
        assert!(kappa > 1420.0 || printed(kappa, 0.5) == 0.0);
        assert!(printed_inverse(kappa, 0.5).is_infinite());
        holds(kappa);
    }
}

#[test]
fn kappa_above_88_in_f32() {
    for kappa in [17.0, 88.0, 89.0, 100.0, 500.0, 1e12] {
        let exact = truth(kappa, Polar::POLE);
        assert_eq!(printed_f32(kappa as f32, 1.0).is_nan(), kappa > 88.0);
        // rounded to f32 what is computed in f64 is the nearest, but for ties: half a step of f32 and a rounding
        let ours = vmf(kappa).p(Polar::POLE) as f32;
        assert!(off(ours.into(), &exact) <= 0.5 * f64::from(f32::EPSILON) + 4.0 * f64::EPSILON);
        holds(kappa);
    }
}

#[test]
fn kappa_below_1e_8() {
    for kappa in [1e-8, 1e-9, 1e-10, 1e-12, 1e-14, 1e-15] {
        // e^kappa - 1 keeps its distance from the grid of numbers near 1
        assert!(off(printed(kappa, 1.0), &truth(kappa, Polar::POLE)) > 1e-9);
        assert!(off(1.0 - printed_inverse(kappa, 0.5), &true_versine(kappa, 0.5)) > 1e-9);
        holds(kappa);
    }
    for kappa in [1e-17, 1e-100, 1e-300, 0.0] {
        assert!(!printed(kappa, 1.0).is_finite());
        assert!(kappa > 0.0 || printed_inverse(kappa, 0.5).is_nan());
        holds(kappa);
    }
    assert!(printed_f32(1e-8, 1.0).is_infinite());
}

pub(crate) fn rows() -> Vec<Row> {
    let at_the_pole = |kappa: f64, straightforward: f64| Row {
        example: "",
        straightforward,
        ours: vmf(kappa).p(Polar::POLE),
        truth: truth(kappa, Polar::POLE),
        test: "",
    };
    vec![
        Row {
            example: "kappa > 709: p of vMF at the pole, kappa = 1000",
            test: "kappa_above_709",
            ..at_the_pole(1e3, printed(1e3, 1.0))
        },
        Row {
            example: "kappa > 88 in f32: the same, kappa = 100",
            test: "kappa_above_88_in_f32",
            ..at_the_pole(100.0, printed_f32(100.0, 1.0).into())
        },
        Row {
            example: "kappa < 1e-8: the same, kappa = 1e-12",
            test: "kappa_below_1e_8",
            ..at_the_pole(1e-12, printed(1e-12, 1.0))
        },
    ]
}
