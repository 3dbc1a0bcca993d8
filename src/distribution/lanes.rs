//! Normals and densities of isotropic distributions for many draws at once.
//!
//! The formulae are those of the distributions, without branches: see there.

use super::Isotropic;
use crate::numerics::lanes::{exp, exp_m1, ln, ln_sum, sin_cos_turns};
use crate::numerics::points::BLOCK;
use multiversion::multiversion;
use std::f64::consts::{PI, TAU};

/// One number for each draw.
type Lane = [f64; BLOCK];

/// Normals drawn from p(h).
pub(crate) fn normals(distribution: &Isotropic, u: [&Lane; 2], h: &mut [Lane; 3]) {
    match distribution {
        Isotropic::Ggx(d) => draw(Ggx { alpha: d.alpha() }, u, h),
        Isotropic::Beckmann(d) => draw(Beckmann { m: d.m() }, u, h),
        Isotropic::Vmf(d) => draw(Vmf::new(d.kappa(), d.peak()), u, h),
        Isotropic::Phong(d) => draw(Phong { n: d.n() }, u, h),
        Isotropic::Charlie(d) => draw(Charlie { n: d.exponent() }, u, h),
    }
}

/// D(h) of unit vectors.
pub(crate) fn densities(distribution: &Isotropic, h: &[Lane; 3], out: &mut Lane) {
    match distribution {
        Isotropic::Ggx(d) => evaluate(Ggx { alpha: d.alpha() }, h, out),
        Isotropic::Beckmann(d) => evaluate(Beckmann { m: d.m() }, h, out),
        Isotropic::Vmf(d) => evaluate(Vmf::new(d.kappa(), d.peak()), h, out),
        Isotropic::Phong(d) => evaluate(Phong { n: d.n() }, h, out),
        Isotropic::Charlie(d) => evaluate(Charlie { n: d.exponent() }, h, out),
    }
}

#[multiversion(targets("x86_64+avx512f+avx512dq", "x86_64+avx2", "x86_64+avx"))]
fn draw<P: Profile>(profile: P, u: [&Lane; 2], h: &mut [Lane; 3]) {
    let [x, y, z] = h;
    for k in 0..BLOCK {
        let (sin, cos) = profile.polar(u[0][k]);
        let (along_y, along_x) = sin_cos_turns(u[1][k]);
        x[k] = sin * along_x;
        y[k] = sin * along_y;
        z[k] = cos;
    }
}

#[multiversion(targets("x86_64+avx512f+avx512dq", "x86_64+avx2", "x86_64+avx"))]
fn evaluate<P: Profile>(profile: P, h: &[Lane; 3], out: &mut Lane) {
    let [x, y, z] = h;
    for k in 0..BLOCK {
        out[k] = profile.d(x[k] * x[k] + y[k] * y[k], z[k]);
    }
}

/// A distribution made ready for loops.
trait Profile: Copy {
    /// Sine and cosine of the angle with P = u, for u in [0, 1).
    fn polar(self, u: f64) -> (f64, f64);

    /// D at the squared sine and the cosine of an angle.
    fn d(self, sin2: f64, cos: f64) -> f64;
}

#[derive(Clone, Copy)]
struct Ggx {
    alpha: f64,
}

impl Profile for Ggx {
    /// tan^2 = alpha^2 u/(1 - u)
    #[inline(always)]
    fn polar(self, u: f64) -> (f64, f64) {
        let square = self.alpha * self.alpha * u;
        let scale = 1.0 / (1.0 - u + square);
        ((square * scale).sqrt(), ((1.0 - u) * scale).sqrt())
    }

    #[inline(always)]
    fn d(self, sin2: f64, cos: f64) -> f64 {
        let stretched = self.alpha * cos;
        let root = self.alpha / (stretched * stretched + sin2);
        root * root / PI
    }
}

#[derive(Clone, Copy)]
struct Beckmann {
    m: f64,
}

/// Exposures beyond this leave nothing that a sum notices.
const FARTHEST: f64 = 700.0;

impl Profile for Beckmann {
    /// tan^2 = -m^2 ln(1 - u)
    #[inline(always)]
    fn polar(self, u: f64) -> (f64, f64) {
        let tan2 = self.m * self.m * -ln_sum(1.0, -u);
        let cos = 1.0 / (1.0 + tan2).sqrt();
        (tan2.sqrt() * cos, cos)
    }

    #[inline(always)]
    fn d(self, sin2: f64, cos: f64) -> f64 {
        let cos2 = cos * cos;
        let m2 = self.m * self.m;
        let exposure = sin2 / (cos2 * m2);
        let d = exp(-exposure) / (PI * m2 * cos2 * cos2);
        if exposure < FARTHEST { d } else { 0.0 }
    }
}

#[derive(Clone, Copy)]
struct Vmf {
    kappa: f64,
    /// e^(-kappa v) = (1 - linear u) + rest u, both terms free of cancellation.
    linear: f64,
    rest: f64,
    peak: f64,
}

impl Vmf {
    fn new(kappa: f64, peak: f64) -> Self {
        // uniform to the last bit as kappa = 0 is; it divides, and its product with u does not underflow
        let kappa = kappa.max(1e-30);
        let (linear, rest) = if kappa < 1.0 {
            (0.0, libm::expm1(-kappa))
        } else {
            (1.0, libm::exp(-kappa))
        };
        Self {
            kappa,
            linear,
            rest,
            peak,
        }
    }
}

impl Profile for Vmf {
    /// e^(-kappa v) = 1 - (1 - e^-kappa) u
    #[inline(always)]
    fn polar(self, u: f64) -> (f64, f64) {
        let versine = -ln_sum(1.0 - self.linear * u, self.rest * u) / self.kappa;
        let versine = versine.clamp(0.0, 1.0);
        let cos = 1.0 - versine;
        ((versine * (1.0 + cos)).sqrt(), cos)
    }

    #[inline(always)]
    fn d(self, sin2: f64, cos: f64) -> f64 {
        let exponent = self.kappa * (sin2 / (1.0 + cos));
        let p = self.peak * exp(-exponent);
        if exponent < FARTHEST { p / cos } else { 0.0 }
    }
}

#[derive(Clone, Copy)]
struct Phong {
    n: f64,
}

impl Profile for Phong {
    /// cos^(n + 2) = 1 - u
    #[inline(always)]
    fn polar(self, u: f64) -> (f64, f64) {
        let ln_cos = ln_sum(1.0, -u) / (self.n + 2.0);
        let versine = -exp_m1(ln_cos);
        let cos = exp(ln_cos);
        ((versine * (1.0 + cos)).sqrt(), cos)
    }

    #[inline(always)]
    fn d(self, sin2: f64, cos: f64) -> f64 {
        // of the two forms of ln cos, the one that cancels is not chosen
        let near = 0.5 * ln_sum(1.0, -sin2.min(0.75));
        let far = ln(cos.max(f64::MIN_POSITIVE));
        let ln_cos = if sin2 < 0.5 { near } else { far };
        let exponent = -self.n * ln_cos;
        let d = (self.n + 2.0) / TAU * exp(-exponent);
        if exponent < FARTHEST { d } else { 0.0 }
    }
}

#[derive(Clone, Copy)]
struct Charlie {
    n: f64,
}

impl Profile for Charlie {
    /// sin^(n + 2) = u
    #[inline(always)]
    fn polar(self, u: f64) -> (f64, f64) {
        let ln_sin = ln(u.max(f64::MIN_POSITIVE)) / (self.n + 2.0);
        (exp(ln_sin), (-exp_m1(2.0 * ln_sin)).sqrt())
    }

    #[inline(always)]
    fn d(self, sin2: f64, cos: f64) -> f64 {
        // of the two forms of ln sin, the one that cancels is not chosen
        let near = 0.5 * ln(sin2.max(f64::MIN_POSITIVE));
        let far = 0.5 * ln_sum(1.0, -(cos * cos).min(0.75));
        let ln_sin = if sin2 < 0.5 { near } else { far };
        let exponent = -self.n * ln_sin;
        let d = (self.n + 2.0) / TAU * exp(-exponent);
        if exponent < FARTHEST { d } else { 0.0 }
    }
}
