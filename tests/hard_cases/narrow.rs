//! Narrow lobes about the pole, and slopes at the horizon.

use crate::big::{Big, big, off, one, pi};
use crate::common::cases::{ashikhmin_shirley, beckmann, beckmann_xy, ggx_xy, phong, vmf};
use crate::row::Row;
use glam::DVec3;
use std::f64::consts::{FRAC_PI_2, PI, TAU};
use whitefurnace::distribution::Distribution;
use whitefurnace::geometry::Polar;

/// sin^2 of an angle in radians.
fn sine_squared(theta: f64) -> Big {
    let sine = big(theta).sin();
    &sine * &sine
}

/// Angles in typical widths of a lobe.
const WIDTHS: [f64; 5] = [0.0, 0.1, 0.5, 1.0, 3.0];

/// Some roundings of the factors and of E, which counts E times in e^-E.
fn allowed(exposure: f64) -> f64 {
    f64::EPSILON * (6.0 + 6.0 * exposure)
}

/// e^(kappa cos)/e^kappa as a falloff in 1 - cos theta, the form that no longer overflows; its peak is kappa/(2 pi) for
/// kappa > 40.
fn falloff_of_vmf(kappa: f64, theta: f64) -> f64 {
    kappa / TAU * libm::exp(-kappa * (1.0 - libm::cos(theta)))
}

/// The same with 1 - cos theta = 2 sin^2(theta/2).
fn true_vmf(kappa: f64, theta: f64) -> Big {
    big(kappa) / (big(2.0) * pi()) * (big(-2.0 * kappa) * sine_squared(0.5 * theta)).exp()
}

#[test]
fn one_minus_cos_of_narrow_lobes() {
    let mut worst = 0.0f64;
    for kappa in [1e4, 1e6, 1e8, 1e10, 1e12] {
        for width in WIDTHS {
            let theta = width / libm::sqrt(kappa);
            let versine = Polar::from_angle(theta).versine();
            // a sine, its square and a quotient
            assert!(off(versine, &(big(2.0) * sine_squared(0.5 * theta))) <= 4.0 * f64::EPSILON);
            let truth = true_vmf(kappa, theta);
            worst = worst.max(off(falloff_of_vmf(kappa, theta), &truth));
            let error = off(vmf(kappa).p(Polar::from_angle(theta)), &truth);
            assert!(error <= allowed(0.5 * width * width), "{kappa:e} {theta:e}: {error:e}");
        }
    }
    // 1 - cos is a multiple of 2^-53, and kappa = 1e12 makes 1e-4 of that
    assert!((1e-5..1e-3).contains(&worst), "{worst:e}");
    assert_eq!(1.0 - libm::cosf(1e-4), 0.0); // in f32 the whole lobe of kappa = 1e8 is flat
    assert_eq!(1.0 - libm::cos(1e-8), 0.0);
}

/// e^(-tan^2/m^2)/(pi m^2 cos^4) [Mikkelsen 2009, eq. 20] of the cosine alone, tan^2 = (1 - cos^2)/cos^2.
fn beckmann_of_cosine(m: f64, cos: f64) -> f64 {
    let square = cos * cos;
    libm::exp(-(1.0 - square) / (square * m * m)) / (PI * m * m * square * square)
}

fn beckmann_of_cosine_f32(m: f32, cos: f32) -> f32 {
    let square = cos * cos;
    libm::expf(-(1.0 - square) / (square * m * m)) / (std::f32::consts::PI * m * m * square * square)
}

/// The same of sin^2.
fn true_beckmann(m: f64, sine_squared: &Big) -> Big {
    let (width, square) = (big(m) * big(m), one() - sine_squared);
    (-(sine_squared / &square / &width)).exp() / (pi() * width * &square * &square)
}

#[test]
fn slopes_at_small_m() {
    let mut worst = 0.0f64;
    for m in [1e-6, 1e-5, 1e-4, 1e-3, 1e-2] {
        for width in WIDTHS {
            let theta = m * width;
            let truth = true_beckmann(m, &sine_squared(theta));
            worst = worst.max(off(beckmann_of_cosine(m, libm::cos(theta)), &truth));
            let error = off(beckmann(m).d(Polar::from_angle(theta)), &truth);
            assert!(error <= allowed(width * width), "{m:e} {theta:e}: {error:e}");
        }
    }
    // 1 - cos^2 is a multiple of 2^-53, and m = 1e-6 makes 1e-4 of that
    assert!((1e-5..1e-2).contains(&worst), "{worst:e}");
    // in f32 there is no falloff from m = 1e-4 on
    let (peak, beside) = (
        beckmann_of_cosine_f32(1e-4, 1.0),
        beckmann_of_cosine_f32(1e-4, libm::cosf(2e-4)),
    );
    assert_eq!(peak, beside);
}

#[test]
fn slopes_at_the_horizon() {
    let lowest = Polar { sin: 1.0, cos: 0.0 };
    for m in [1e-6, 1e-3, 0.1, 1.0, 10.0] {
        assert!(beckmann_of_cosine(m, 0.0).is_nan()); // 0/0
        assert!(beckmann_of_cosine(m, 1e-100).is_nan()); // cos^4 underflows
        for cos in [0.0, 5e-324, 1e-300, 1e-100, 1e-20] {
            // tan^2/m^2 is at least 1e38, and the smallest number is e^-745
            let theta = Polar { cos, ..lowest };
            assert_eq!((beckmann(m).d(theta), beckmann(m).p(theta)), (0.0, 0.0));
            for lobe in [beckmann_xy(m, 0.5), beckmann_xy(0.5, m)] {
                assert_eq!(lobe.d(DVec3::new(0.6, 0.8, cos)), 0.0);
            }
        }
        assert_eq!(beckmann(m).exposure(lowest), f64::INFINITY);
        assert_eq!(beckmann(m).cdf(lowest), 1.0);
    }
    // where something is left of it so low
    for cos in [0.5, 0.1, 0.03, 0.01, 0.004] {
        let theta = Polar::from_cos(cos);
        let square = one() - big(cos) * big(cos);
        let exposure = beckmann(10.0).exposure(theta);
        let error = off(beckmann(10.0).d(theta), &true_beckmann(10.0, &square));
        assert!(error <= allowed(exposure), "{cos}: {error:e}");
    }
}

/// (n + 2)/(2 pi) cos^n [pbrt 2010, eq. 8.9].
fn printed_power(n: f64, cos: f64) -> f64 {
    (n + 2.0) / TAU * libm::pow(cos, n)
}

fn printed_power_f32(n: f32, cos: f32) -> f32 {
    (n + 2.0) / std::f32::consts::TAU * libm::powf(cos, n)
}

fn true_power(n: f64, theta: f64) -> Big {
    let logarithm = (one() - sine_squared(theta)).ln() * big(0.5 * n);
    (big(n) + big(2.0)) / (big(2.0) * pi()) * logarithm.exp()
}

#[test]
fn large_powers_of_the_cosine() {
    let mut worst = 0.0f64;
    for n in [0.0, 1e-3, 50.0, 1e4, 1e6, 1e8] {
        for width in WIDTHS {
            let theta = (width / libm::sqrt(n + 2.0)).min(FRAC_PI_2);
            let truth = true_power(n, theta);
            worst = worst.max(off(printed_power(n, libm::cos(theta)), &truth));
            let error = off(phong(n).d(Polar::from_angle(theta)), &truth);
            let exposure = phong(n).exposure(Polar::from_angle(theta));
            assert!(error <= allowed(exposure), "{n:e} {theta:e}: {error:e}");
        }
    }
    // the rounding of the cosine, up to 2^-54, counts n times
    assert!((1e-9..1e-8).contains(&worst), "{worst:e}");
    assert_eq!(printed_power_f32(1e8, libm::cosf(1e-4)), printed_power_f32(1e8, 1.0)); // and in f32 the cosine is 1
}

/// D of Ashikhmin and Shirley as the code for it stands [pbrt 2010, section 8.4.3].
fn printed_anisotropic([x, y]: [f64; 2], h: DVec3) -> f64 {
    let d = 1.0 - h.z * h.z;
    if d == 0.0 {
        return 0.0;
    }
    let exponent = (x * h.x * h.x + y * h.y * h.y) / d;
    libm::sqrt((x + 2.0) * (y + 2.0)) / TAU * libm::pow(h.z, exponent)
}

/// e^(-tan^2 (cos^2 phi/x^2 + sin^2 phi/y^2))/(pi x y cos^4) with cos phi = h.x/sin theta [pbrt 2016, section 8.4.2].
fn printed_beckmann_xy([x, y]: [f64; 2], h: DVec3) -> f64 {
    let (cos2, sin2) = (h.z * h.z, 1.0 - h.z * h.z);
    let (along_x, along_y) = (h.x / libm::sqrt(sin2) / x, h.y / libm::sqrt(sin2) / y);
    let exponent = sin2 / cos2 * (along_x * along_x + along_y * along_y);
    libm::exp(-exponent) / (PI * x * y * cos2 * cos2)
}

/// sqrt((x + 2)(y + 2))/(2 pi) cos^e with e = x cos^2 phi + y sin^2 phi, at the pole 1 in place of the power.
fn true_anisotropic([x, y]: [f64; 2], h: DVec3) -> Big {
    let norm = ((big(x) + big(2.0)) * (big(y) + big(2.0))).sqrt() / (big(2.0) * pi());
    let squares = [big(h.x) * big(h.x), big(h.y) * big(h.y)];
    let sum = &squares[0] + &squares[1];
    if sum == big(0.0) {
        return norm;
    }
    let exponent = (big(x) * &squares[0] + big(y) * &squares[1]) / &sum;
    norm * (exponent / big(2.0) * (one() - sum).ln()).exp()
}

#[test]
fn pole_of_anisotropic_distributions() {
    for exponents in [[10.0, 1000.0], [0.0, 5.0], [1e8, 1e2], [3.0, 3.0]] {
        let lobe = ashikhmin_shirley(exponents[0], exponents[1]);
        for radius in [0.0, 5e-324, 1e-300, 1e-160, 1e-20, 1e-9, 2e-8, 1e-6, 1e-4, 1e-2] {
            for azimuth in [0.0, 0.3, 1.2] {
                let (x, y) = (radius * libm::cos(azimuth), radius * libm::sin(azimuth));
                let h = DVec3::new(x, y, libm::sqrt(1.0 - radius * radius));
                let truth = true_anisotropic(exponents, h);
                let exposure = 0.5 * (exponents[0] * x * x + exponents[1] * y * y);
                if exposure > 700.0 {
                    continue; // below the smallest number
                }
                if radius <= 1e-9 {
                    assert_eq!(printed_anisotropic(exponents, h), 0.0);
                }
                let error = off(lobe.d(h), &truth);
                assert!(error <= allowed(exposure), "{exponents:?} {h}: {error:e}");
            }
        }
    }
    for widths in [[1e-6, 1e-6], [1e-6, 10.0], [0.1, 0.4]] {
        assert!(printed_beckmann_xy(widths, DVec3::Z).is_nan()); // cos phi = 0/0
        let peak = one() / (pi() * big(widths[0]) * big(widths[1]));
        let lobes: [Distribution; 2] = [beckmann_xy(widths[0], widths[1]), ggx_xy(widths[0], widths[1])];
        for lobe in lobes {
            assert!(off(lobe.d(DVec3::Z), &peak) <= allowed(0.0), "{lobe:?}");
        }
    }
}

pub(crate) fn rows() -> Vec<Row> {
    let angle = Polar::from_angle;
    let low = Polar { sin: 1.0, cos: 0.0 };
    vec![
        Row {
            example: "1 - cos: p of vMF, kappa = 1e12, theta = 1e-6",
            straightforward: falloff_of_vmf(1e12, 1e-6),
            ours: vmf(1e12).p(angle(1e-6)),
            truth: true_vmf(1e12, 1e-6),
            test: "one_minus_cos_of_narrow_lobes",
        },
        Row {
            example: "tan^2/m^2, small m: D of Beckmann, m = theta = 1e-6",
            straightforward: beckmann_of_cosine(1e-6, libm::cos(1e-6)),
            ours: beckmann(1e-6).d(angle(1e-6)),
            truth: true_beckmann(1e-6, &sine_squared(1e-6)),
            test: "slopes_at_small_m",
        },
        Row {
            example: "tan^2/m^2 at the horizon: the same, m = 0.1",
            straightforward: beckmann_of_cosine(0.1, 0.0),
            ours: beckmann(0.1).d(low),
            truth: big(0.0),
            test: "slopes_at_the_horizon",
        },
        Row {
            example: "cos^n: D of Phong, n = 1e8, theta = 1e-4, in f32",
            straightforward: printed_power_f32(1e8, libm::cosf(1e-4)).into(),
            ours: phong(1e8).d(angle(1e-4)),
            truth: true_power(1e8, 1e-4),
            test: "large_powers_of_the_cosine",
        },
        Row {
            example: "pole of anisotropic D: Ashikhmin-Shirley 10, 1000",
            straightforward: printed_anisotropic([10.0, 1e3], DVec3::Z),
            ours: ashikhmin_shirley(10.0, 1e3).d(DVec3::Z),
            truth: true_anisotropic([10.0, 1e3], DVec3::Z),
            test: "pole_of_anisotropic_distributions",
        },
    ]
}
