//! Elementary functions without branches, for loops that the compiler turns into vector instructions.
//!
//! Each is a fixed sequence of additions, multiplications, divisions and integer operations, so a loop over them compiled for
//! 2, 4 or 8 lanes gives the same bits as one for a single lane; no product is contracted into a sum. Loops choose their
//! width at run time by `#[multiversion]`; the functions here are inlined into them. The standard library's functions are
//! calls, which keep a loop scalar, and are free to differ from one platform to the next.

use std::f64::consts::{LOG2_E, TAU};

/// 1.5 * 2^52: added to a number of at most 2^51, it rounds it to an integer, which the low bits of the sum then hold.
const ROUNDER: f64 = 6_755_399_441_055_744.0;

/// ln 2 in two parts, the first with 32 trailing zero bits, so that its products with exponents are exact.
const LN_2_HIGH: f64 = 0.693_147_180_369_123_8;
const LN_2_LOW: f64 = 1.908_214_929_270_587_7e-10;

/// e^x to 2e-16 of its value, for x in [-708, 709]; x beyond either end counts as that end.
#[inline(always)]
pub fn exp(x: f64) -> f64 {
    let x = x.clamp(-708.0, 709.0);
    let rounded = x * LOG2_E + ROUNDER;
    let n = rounded - ROUNDER;
    let r = (x - n * LN_2_HIGH) - n * LN_2_LOW;
    // |r| <= ln(2)/2: the Taylor series to r^13 leaves 4e-18
    let series = 1.0 + (r + r * r * polynomial(r, EXP));
    let power = f64::from_bits(rounded.to_bits().wrapping_add(1023) << 52);
    series * power
}

/// e^x - 1 to 4e-16 of its value, for x as of [`exp`].
#[inline(always)]
pub fn exp_m1(x: f64) -> f64 {
    let x = x.clamp(-708.0, 709.0);
    let rounded = x * LOG2_E + ROUNDER;
    let n = rounded - ROUNDER;
    let r = (x - n * LN_2_HIGH) - n * LN_2_LOW;
    let power = f64::from_bits(rounded.to_bits().wrapping_add(1023) << 52);
    // for n = 0 the power is 1 and nothing cancels
    power * (r + r * r * polynomial(r, EXP)) + (power - 1.0)
}

/// ln(a + b) for a >= |b|, a + b normal and positive, with what their sum loses by rounding put back.
#[inline(always)]
pub fn ln_sum(a: f64, b: f64) -> f64 {
    let sum = a + b;
    ln(sum) + ((a - sum) + b) / sum
}

/// 1/2! to 1/13!.
const EXP: [f64; 12] = [
    1.0 / 2.0,
    1.0 / 6.0,
    1.0 / 24.0,
    1.0 / 120.0,
    1.0 / 720.0,
    1.0 / 5_040.0,
    1.0 / 40_320.0,
    1.0 / 362_880.0,
    1.0 / 3_628_800.0,
    1.0 / 39_916_800.0,
    1.0 / 479_001_600.0,
    1.0 / 6_227_020_800.0,
];

/// c_0 + c_1 x + c_2 x^2 + ..., by Horner's rule.
#[inline(always)]
pub fn polynomial<const N: usize>(x: f64, c: [f64; N]) -> f64 {
    let mut sum = 0.0;
    let mut k = N;
    while k > 0 {
        k -= 1;
        sum = sum * x + c[k];
    }
    sum
}

/// ln x for normal positive x, to 4e-16 of the larger of its value and 1.
#[inline(always)]
pub fn ln(x: f64) -> f64 {
    // x = 2^n m with m in [1/sqrt 2, sqrt 2)
    const ROOT_HALF: u64 = 0x3fe6_a09e_667f_3bcd;
    let shifted = x.to_bits().wrapping_sub(ROOT_HALF);
    let exponent = shifted.wrapping_add(1023 << 52) >> 52;
    let mantissa = f64::from_bits((shifted & ((1 << 52) - 1)).wrapping_add(ROOT_HALF));
    // an integer below 2^52, as the low bits of 2^52 + n
    let n = f64::from_bits(exponent | 0x4330_0000_0000_0000) - (4_503_599_627_370_496.0 + 1023.0);
    // ln m = 2 artanh s, |s| < 0.1716: s^2 < 0.0295, the series to s^21 leaves 3e-19
    let s = (mantissa - 1.0) / (mantissa + 1.0);
    let z = s * s;
    let low = z * polynomial(z, ARTANH);
    n * LN_2_HIGH + (n * LN_2_LOW + (2.0 * s + s * low))
}

/// 2/3, 2/5, ..., 2/21.
const ARTANH: [f64; 10] = [
    2.0 / 3.0,
    2.0 / 5.0,
    2.0 / 7.0,
    2.0 / 9.0,
    2.0 / 11.0,
    2.0 / 13.0,
    2.0 / 15.0,
    2.0 / 17.0,
    2.0 / 19.0,
    2.0 / 21.0,
];

/// sin and cos of 2 pi u, to 2e-16, for u of at most 2^48.
#[inline(always)]
pub fn sin_cos_turns(u: f64) -> (f64, f64) {
    let rounded = 4.0 * u + ROUNDER;
    let quarter = rounded.to_bits();
    let angle = TAU * (u - 0.25 * (rounded - ROUNDER));
    let z = angle * angle;
    // |angle| <= pi/4: the series to z^8 leave 3e-19 and 6e-18
    let sin = angle + angle * z * polynomial(z, SIN);
    let cos = 1.0 + z * polynomial(z, COS);
    // quarter turns: (s, c), (c, -s), (-s, -c), (-c, s)
    let swap = 0u64.wrapping_sub(quarter & 1);
    let (s, c) = (sin.to_bits(), cos.to_bits());
    let (first, second) = ((s & !swap) | (c & swap), (c & !swap) | (s & swap));
    let first = first ^ ((quarter & 2) << 62);
    let second = second ^ ((quarter.wrapping_add(1) & 2) << 62);
    (f64::from_bits(first), f64::from_bits(second))
}

/// -1/3!, 1/5!, ..., -1/15!.
const SIN: [f64; 7] = [
    -1.0 / 6.0,
    1.0 / 120.0,
    -1.0 / 5_040.0,
    1.0 / 362_880.0,
    -1.0 / 39_916_800.0,
    1.0 / 6_227_020_800.0,
    -1.0 / 1_307_674_368_000.0,
];

/// -1/2!, 1/4!, ..., 1/16!.
const COS: [f64; 8] = [
    -1.0 / 2.0,
    1.0 / 24.0,
    -1.0 / 720.0,
    1.0 / 40_320.0,
    -1.0 / 3_628_800.0,
    1.0 / 479_001_600.0,
    -1.0 / 87_178_291_200.0,
    1.0 / 20_922_789_888_000.0,
];

/// e^(x^2) (1 + x)^2 ierfc(x) at y = (x - 3)/(x + 3) in [-1, 1], with ierfc as in [`super::gaussian`]; to 1e-15 of its value.
///
/// e^(x^2) ierfc(x) falls from 1/sqrt(pi) to 1/(2 sqrt(pi) x^2), smoothly and without a change of sign: times (1 + x)^2 it is
/// all but a polynomial in y. It was expanded in Chebyshev polynomials at 40 digits; what follows the 26th is below 3e-17.
/// Even and odd powers are summed apart, which halves the chain of dependent operations.
#[inline(always)]
pub fn scaled_ierfc(y: f64) -> f64 {
    let z = y * y;
    polynomial(z, TAIL_EVEN) + y * polynomial(z, TAIL_ODD)
}

/// Coefficients of y^0, y^2, ..., y^24.
const TAIL_EVEN: [f64; 13] = [
    0.434_978_080_057_383,
    0.054_264_794_784_577_25,
    -0.069_485_199_764_245_2,
    -0.000_104_558_555_115_103_39,
    0.004_174_188_769_112_765,
    -0.000_801_232_158_250_458_8,
    0.000_138_056_393_330_897_18,
    -2.668_375_460_356_187e-5,
    5.827_646_963_353_39e-6,
    -1.319_562_449_710_461_5e-6,
    2.737_221_273_327_217e-7,
    -4.375_222_383_488_66e-8,
    3.834_210_555_830_317e-9,
];

/// Coefficients of y^1, y^3, ..., y^25.
const TAIL_ODD: [f64; 13] = [
    -0.219_965_391_175_499_6,
    0.054_510_079_805_696_77,
    0.032_909_121_863_577_896,
    -0.008_775_245_297_591_891,
    0.000_195_014_087_874_854_8,
    0.000_102_749_578_562_229_57,
    -2.821_693_517_321_41e-5,
    5.046_062_933_642_402e-6,
    -5.273_774_118_277_856e-7,
    -6.900_381_091_247_381e-8,
    5.563_544_554_569_264e-8,
    -1.485_356_833_309_927e-8,
    1.722_025_379_097_322_4e-9,
];

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numerics::stream::{Stream, StreamId};
    use multiversion::multiversion;
    use std::f64::consts::{LN_2, PI};

    const ID: StreamId = StreamId {
        seed: 0,
        cell: 0,
        batch: 0,
    };

    #[test]
    fn functions_match_those_of_the_library() {
        let mut stream = Stream::new(ID);
        for _ in 0..200_000 {
            let [u, v, w] = stream.uniform3();
            let x = 1417.0 * u - 708.0;
            assert!((exp(x) / x.exp() - 1.0).abs() < 1e-15, "{x}"); // half a unit of either, and the rounding of r
            let x = 2.0 * u - 1.0;
            assert!((exp(x) / x.exp() - 1.0).abs() < 5e-16, "{x}");
            for x in [x, 40.0 * x, 1e-9 * x] {
                assert!((exp_m1(x) / x.exp_m1() - 1.0).abs() < 1e-15, "{x}");
                let x = -w * 10f64.powf(-15.0 * v);
                assert!((ln_sum(1.0, x) / x.ln_1p() - 1.0).abs() < 1e-15, "{x}");
            }
            let y = (1400.0 * v - 700.0).exp();
            assert!((ln(y) - y.ln()).abs() <= 4e-16 * y.ln().abs().max(1.0), "{y}");
            let y = 1.0 + 1e-3 * (v - 0.5);
            assert!((ln(y) / y.ln() - 1.0).abs() < 5e-16, "{y}");
            let turns = 4.0 * w - 2.0;
            let (sin, cos) = sin_cos_turns(turns);
            let exact = (2.0 * PI * (turns - turns.round())).sin_cos(); // the angle is rounded to 4e-16
            assert!(
                (sin - exact.0).abs() < 6e-16 && (cos - exact.1).abs() < 6e-16,
                "{turns}"
            );
        }
    }

    #[test]
    fn scaled_integrals_of_the_gaussian_match_the_exact_form() {
        for i in 0..=26_000 {
            let x = 1e-3 * f64::from(i);
            let found = scaled_ierfc((x - 3.0) / (x + 3.0));
            let exact = crate::numerics::gaussian::ierfc(x) / crate::numerics::gaussian::exp_minus_square(x);
            // that of the library errs by 4e-15 just below 2
            assert!(
                (found / (exact * (1.0 + x).powi(2)) - 1.0).abs() < 6e-15,
                "{x}: {found:e}"
            );
        }
        // 1/(2 sqrt(pi)) at infinity
        assert!((scaled_ierfc(1.0) * 2.0 * PI.sqrt() - 1.0).abs() < 2e-15);
    }

    #[test]
    fn simple_places_are_exact() {
        assert_eq!([exp(0.0), exp(-1e9), exp(1e9)], [1.0, exp(-708.0), exp(709.0)]);
        assert!(exp(-708.0) > 0.0 && exp(709.0).is_finite());
        assert_eq!(
            [ln(1.0), ln(2.0), ln(f64::MIN_POSITIVE)],
            [0.0, LN_2, f64::MIN_POSITIVE.ln()]
        );
        let quarters = [
            (0.0, (0.0, 1.0)),
            (0.25, (1.0, 0.0)),
            (0.5, (0.0, -1.0)),
            (0.75, (-1.0, 0.0)),
            (1.0, (0.0, 1.0)),
        ];
        for (turns, exact) in quarters {
            assert_eq!(sin_cos_turns(turns), exact, "{turns}");
        }
    }

    #[multiversion(targets("x86_64+avx512f+avx512dq", "x86_64+avx2", "x86_64+avx"))]
    fn all(x: &[f64], out: &mut [f64]) {
        for (x, out) in x.iter().zip(out) {
            let (sin, cos) = sin_cos_turns(*x);
            *out = exp(*x) + ln(1.0 + *x) * sin + cos.abs().sqrt();
        }
    }

    #[test]
    fn every_width_gives_the_same_bits() {
        let mut stream = Stream::new(ID);
        let x: Vec<f64> = (0..4099).map(|_| 40.0 * stream.uniform()).collect();
        let mut wide = vec![0.0; x.len()];
        all(&x, &mut wide);
        for (x, wide) in x.iter().zip(&wide) {
            let (sin, cos) = sin_cos_turns(*x);
            let one = exp(*x) + ln(1.0 + *x) * sin + cos.abs().sqrt();
            assert_eq!(one.to_bits(), wide.to_bits(), "{x}");
        }
    }
}
