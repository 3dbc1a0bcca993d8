//! Arbitrary-precision arithmetic for true values.

use dashu_float::FBig;
use dashu_float::round::mode::HalfEven;

/// A binary number of [`PRECISION`] bits and practically unlimited exponent.
pub(crate) type Big = FBig<HalfEven, 2>;

/// 1e-160 squared keeps 40 digits beside 1: 320 + 40 decimal digits.
const PRECISION: usize = 1200;

/// e^x for x below this is lost beside 1.
const LOST: f64 = -1000.0;

/// `x` itself: every finite f64 is exact.
pub(crate) fn big(x: f64) -> Big {
    Big::try_from(x).unwrap().with_precision(PRECISION).value()
}

pub(crate) fn one() -> Big {
    big(1.0)
}

pub(crate) fn pi() -> Big {
    Big::pi(PRECISION)
}

/// e^x, to be added to something near 1: 0 where it is less than the precision.
pub(crate) fn exp_beside_one(x: &Big) -> Big {
    if *x < big(LOST) { big(0.0) } else { x.exp() }
}

/// The f64 nearest to `x`.
pub(crate) fn nearest(x: &Big) -> f64 {
    x.to_f64().value()
}

/// |found/truth - 1|, or |found| where the truth is 0; not a number or infinite where `found` is.
pub(crate) fn off(found: f64, truth: &Big) -> f64 {
    if !found.is_finite() {
        return found.abs();
    }
    let difference = big(found) - truth;
    let relative = if *truth == big(0.0) {
        difference
    } else {
        difference / truth
    };
    nearest(&relative).abs()
}

/// What is lost beside 1.
fn smallest() -> Big {
    one() >> PRECISION as isize
}

/// erfc(x) for x >= 0, from erf(x) = (2/sqrt(pi)) e^(-x^2) sum_n 2^n x^(2n+1)/(1 3 5 ... (2n+1)), a sum of positive terms
/// [Abramowitz and Stegun 1964, 7.1.6]. 1 - erf keeps 60 digits where erfc = 1e-300.
pub(crate) fn erfc(x: &Big) -> Big {
    let twice_square = big(2.0) * x * x;
    let (mut term, mut sum) = (x.clone(), x.clone());
    let mut odd = 3.0;
    while &term / &sum > smallest() {
        term = term * &twice_square / big(odd);
        sum += &term;
        odd += 2.0;
    }
    one() - big(2.0) * (-(x * x)).exp() * sum / pi().sqrt()
}

/// Beckmann's Lambda at a = cot theta/m: (e^(-a^2)/(a sqrt(pi)) - erfc(a))/2 [Walter et al. 2007, section 5.2].
pub(crate) fn beckmann_lambda(a: &Big) -> Big {
    // from here on it is below 1e-297
    if *a > big(26.0) {
        return big(0.0);
    }
    ((-(a * a)).exp() / (a * pi().sqrt()) - erfc(a)) / big(2.0)
}
