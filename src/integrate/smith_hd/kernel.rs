//! The integrand at all nodes of a rule, as loops over slices.

use super::Slopes;
use super::rules::{Circle, Legendre};
use crate::bxdf::Microfacet;
use crate::fresnel::Fresnel;
use crate::geometry::Polar;
use crate::numerics::lanes::{exp, ln, polynomial, scaled_ierfc};
use glam::DVec3;
use multiversion::multiversion;

/// What one direction and one lobe have in common at all nodes.
#[derive(Debug, Clone, Copy)]
pub(super) struct Constants {
    pub(super) slopes: Slopes,
    pub(super) alpha: f64,
    pub(super) mu: f64,
    pub(super) sin_o: f64,
    /// G2 (1 + x t) (n.i)/(n.o) over (mu + X t): factor (n.i)/(own (n.i) + other half), with half = sqrt of GGX or the
    /// hidden area of Beckmann.
    pub(super) factor: f64,
    pub(super) own: f64,
    pub(super) other: f64,
    /// The end of the inner variable where the lobe ends before the horizon: s for GGX, t for Beckmann.
    pub(super) end: f64,
}

/// Rows are azimuths, one for each outer node.
#[derive(Default)]
pub(super) struct Rows {
    /// tan theta_h at the horizon times n.o, and its reciprocal times (n.o)^2.
    pub(super) reach: Vec<f64>,
    pub(super) inverse: Vec<f64>,
    /// X = sin theta_o cos phi.
    pub(super) x: Vec<f64>,
    /// Length of the inner range.
    pub(super) length: Vec<f64>,
    /// dphi/dpsi times that.
    pub(super) scale: Vec<f64>,
}

/// Scratch of one thread: rows, and nodes row after row.
#[derive(Default)]
pub(super) struct Scratch {
    pub(super) rows: Rows,
    /// Inner variable, then the tangent t of the facet.
    pub(super) t: Vec<f64>,
    pub(super) reach: Vec<f64>,
    pub(super) inverse: Vec<f64>,
    pub(super) x: Vec<f64>,
    /// Values of the integrand.
    pub(super) value: Vec<f64>,
    /// 1 - cos phi, then 1 - cos theta_d, and cos theta_d.
    pub(super) versine: Vec<f64>,
    pub(super) cos: Vec<f64>,
    /// Values times the reflectance of the facets, per channel.
    pub(super) reflected: [Vec<f64>; 3],
    /// Number of nodes.
    pub(super) count: usize,
    /// Columns: sums over rows with the weights of the integral and of its last two coefficients.
    pub(super) columns: [Vec<f64>; 3],
}

/// Whole vectors of the widest machine: loops over a remainder are slow.
pub(super) const LANES: usize = 8;

/// Squared ratio of n.i and the stretched sine from which on nothing is hidden: e^-700.
const MOST_SQUARE: f64 = 700.0;

fn resize(vector: &mut Vec<f64>, length: usize) {
    if vector.len() < length {
        vector.resize(length, 0.0);
    }
}

impl Scratch {
    /// Computes the integrand at all nodes.
    pub(super) fn evaluate(&mut self, constants: &Constants, circle: &Circle, legendre: &Legendre) {
        let (height, width) = (circle.weights.len(), legendre.nodes.len());
        let rows = &mut self.rows;
        for vector in [
            &mut rows.reach,
            &mut rows.inverse,
            &mut rows.x,
            &mut rows.length,
            &mut rows.scale,
        ] {
            resize(vector, circle.sin2.len());
        }
        self.count = height * width;
        let padded = self.count.next_multiple_of(LANES);
        for vector in [
            &mut self.t,
            &mut self.reach,
            &mut self.inverse,
            &mut self.x,
            &mut self.value,
        ] {
            resize(vector, padded);
        }
        fill_rows(constants, circle, rows);
        for (j, start) in (0..self.count).step_by(width).enumerate() {
            let range = start..start + width;
            self.reach[range.clone()].fill(rows.reach[j]);
            self.inverse[range.clone()].fill(rows.inverse[j]);
            self.x[range.clone()].fill(rows.x[j]);
            let length = rows.length[j];
            for (t, node) in self.t[range].iter_mut().zip(&legendre.nodes) {
                *t = length * node;
            }
        }
        // nodes that nobody looks at
        for vector in [&mut self.t, &mut self.reach, &mut self.inverse, &mut self.x] {
            vector[self.count..padded].fill(0.5);
        }
        let run = match constants.slopes {
            Slopes::Ggx => ggx,
            Slopes::Gaussian => beckmann,
        };
        run(
            constants,
            &mut self.t[..padded],
            &self.reach[..padded],
            &self.inverse[..padded],
            &self.x[..padded],
            &mut self.value[..padded],
        );
    }

    /// Multiplies the values by the reflectance of the facets, of as many channels as differ.
    pub(super) fn reflect(
        &mut self,
        constants: &Constants,
        (circle, legendre): (&Circle, &Legendre),
        microfacet: &Microfacet,
        channels: usize,
    ) {
        let (count, width) = (self.count, legendre.nodes.len());
        let padded = count.next_multiple_of(LANES);
        for vector in self.reflected[..channels]
            .iter_mut()
            .chain([&mut self.versine, &mut self.cos])
        {
            resize(vector, padded);
        }
        for (row, sin2) in self.versine[..count].chunks_exact_mut(width).zip(&circle.sin2) {
            row.fill(versine(constants, *sin2));
        }
        self.versine[count..padded].fill(0.5);
        let Self { t, x, versine, cos, .. } = self;
        facet_angles(
            [constants.mu, constants.sin_o],
            &t[..padded],
            &x[..padded],
            &mut versine[..padded],
            &mut cos[..padded],
        );
        let (versine, cos, value) = (&self.versine[..padded], &self.cos[..padded], &self.value[..padded]);
        if let Fresnel::Schlick { r0 } = microfacet.fresnel {
            for (channel, reflected) in self.reflected[..channels].iter_mut().enumerate() {
                let reflectance = microfacet.reflectance.value()[channel];
                schlick(reflectance, r0.value()[channel], cos, value, &mut reflected[..padded]);
            }
            return;
        }
        for i in 0..count {
            let theta_d = Polar::from_versine(versine[i], cos[i]);
            let weighted = value[i] * microfacet.facet_reflectance_at(theta_d);
            for (channel, value) in self.reflected[..channels].iter_mut().zip(weighted.to_array()) {
                channel[i] = value;
            }
        }
    }

    /// The integral of the values over both variables, and the largest coefficients that the outer and the inner rule
    /// resolve: of all that is reflected, or of a channel.
    pub(super) fn sums(&mut self, circle: &Circle, legendre: &Legendre, channel: Option<usize>) -> Sums {
        let width = legendre.nodes.len();
        for column in &mut self.columns {
            resize(column, width);
        }
        let [all, last, second] = &mut self.columns;
        let (all, last, second) = (&mut all[..width], &mut last[..width], &mut second[..width]);
        all.fill(0.0);
        last.fill(0.0);
        second.fill(0.0);
        let scale = &self.rows.scale[..circle.weights.len()];
        let value = channel.map_or(&self.value, |channel| &self.reflected[channel]);
        add_rows(&value[..self.count], scale, circle, all, last, second);
        let weights = &legendre.weights;
        let outer = dot(last, weights).abs().max(dot(second, weights).abs());
        let [last, second] = [0, 1].map(|k| dot(all, &legendre.last[k]).abs());
        Sums {
            value: DVec3::splat(dot(all, weights)),
            outer: DVec3::splat(outer),
            inner: DVec3::splat(last.max(second)),
        }
    }
}

/// An integral with the coefficients that tell its error.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Sums {
    pub(super) value: DVec3,
    /// The larger of the last two coefficients of the outer rule.
    pub(super) outer: DVec3,
    /// And of the inner rule.
    pub(super) inner: DVec3,
}

impl Sums {
    pub(super) fn scaled(self, factor: DVec3) -> Self {
        Self {
            value: factor * self.value,
            outer: factor * self.outer,
            inner: factor * self.inner,
        }
    }

    /// Channels that were summed apart.
    pub(super) fn of_channels([r, g, b]: [Self; 3]) -> Self {
        let join = |part: fn(&Self) -> DVec3| DVec3::new(part(&r).x, part(&g).x, part(&b).x);
        Self {
            value: join(|sums| sums.value),
            outer: join(|sums| sums.outer),
            inner: join(|sums| sums.inner),
        }
    }
}

/// 1 - cos phi = (1 + e^(p - 2 A)) (1 - e^-p)/(1 - e^(-2 A)) at a node of the outer rule.
fn versine(constants: &Constants, sin2: f64) -> f64 {
    let Constants { mu, sin_o, .. } = *constants;
    if sin_o == 0.0 {
        return 0.0;
    }
    let whole = 1.0 + sin_o;
    let p = 2.0 * libm::log(whole / mu) * sin2;
    // 1 - e^(-2 A) = 2 sin theta_o/(1 + sin theta_o)
    (1.0 + libm::exp(p) * (mu / whole).powi(2)) * -libm::expm1(-p) * whole / (2.0 * sin_o)
}

/// theta_d between wo and the facets of tangent `t`, as 1 - cos theta_d in place of the 1 - cos phi of `versine`, and cos theta_d.
///
/// It keeps its digits near the normal in the form
/// versin theta_d = versin(theta_o - theta_h) + sin theta_o sin theta_h versin phi.
#[multiversion(targets("x86_64+avx512f+avx512dq", "x86_64+avx2", "x86_64+avx"))]
fn facet_angles([mu, sin_o]: [f64; 2], t: &[f64], x: &[f64], versine: &mut [f64], cos: &mut [f64]) {
    let count = t.len();
    let (x, versine, cos) = (&x[..count], &mut versine[..count], &mut cos[..count]);
    for i in 0..count {
        let tan = t[i];
        // beyond, the square overflows
        let is_upright = tan > 1e150;
        let cos_h = if is_upright { tan } else { (1.0 + tan * tan).sqrt() }.recip();
        let sin_h = if is_upright { 1.0 } else { tan * cos_h };
        let in_plane = sin_o * cos_h - mu * sin_h;
        let closest = in_plane * in_plane / (1.0 + mu * cos_h + sin_o * sin_h);
        versine[i] = (closest + sin_o * sin_h * versine[i]).clamp(0.0, 1.0);
        cos[i] = ((mu + x[i] * tan) * cos_h).clamp(0.0, 1.0);
    }
}

/// `value` times R (r0 + (1 - r0)(1 - cos theta_d)^5).
#[multiversion(targets("x86_64+avx512f+avx512dq", "x86_64+avx2", "x86_64+avx"))]
fn schlick(reflectance: f64, r0: f64, cos: &[f64], value: &[f64], reflected: &mut [f64]) {
    let rest = 1.0 - r0;
    let count = cos.len();
    let (value, reflected) = (&value[..count], &mut reflected[..count]);
    for i in 0..count {
        let versine = 1.0 - cos[i];
        let square = versine * versine;
        reflected[i] = value[i] * (reflectance * (r0 + rest * (square * square * versine)));
    }
}

/// Four sums side by side, in an order of its own whatever the width of the machine.
fn dot(a: &[f64], b: &[f64]) -> f64 {
    let (a, a_rest) = a.as_chunks::<4>();
    let (b, b_rest) = b.as_chunks::<4>();
    let mut sums = [0.0; 4];
    for (a, b) in a.iter().zip(b) {
        for lane in 0..4 {
            sums[lane] += a[lane] * b[lane];
        }
    }
    let rest: f64 = a_rest.iter().zip(b_rest).map(|(a, b)| a * b).sum();
    (sums[0] + sums[1]) + (sums[2] + sums[3]) + rest
}

#[multiversion(targets("x86_64+avx512f+avx512dq", "x86_64+avx2", "x86_64+avx"))]
fn add_rows(value: &[f64], scale: &[f64], circle: &Circle, all: &mut [f64], last: &mut [f64], second: &mut [f64]) {
    let width = all.len();
    for (j, row) in value.chunks_exact(width).take(scale.len()).enumerate() {
        let weights = [circle.weights[j], circle.last[0][j], circle.last[1][j]].map(|weight| weight * scale[j]);
        for (((value, all), last), second) in row.iter().zip(&mut *all).zip(&mut *last).zip(&mut *second) {
            *all += weights[0] * value;
            *last += weights[1] * value;
            *second += weights[2] * value;
        }
    }
}

/// sinh(p)/p = 1 + p^2/3! + ..., to p^14; what is left is 1e-17 of it below p = 1/2.
const SHC: [f64; 8] = [
    1.0,
    1.0 / 6.0,
    1.0 / 120.0,
    1.0 / 5_040.0,
    1.0 / 362_880.0,
    1.0 / 39_916_800.0,
    1.0 / 6_227_020_800.0,
    1.0 / 1_307_674_368_000.0,
];

#[inline(always)]
fn shc(p: f64, power: f64) -> f64 {
    let series = polynomial(p * p, SHC);
    let direct = 0.5 * (power - power.recip()) / p.max(0.5);
    if p < 0.5 { series } else { direct }
}

/// a = A - p, with p = 2 A sin^2(psi/2) and q = 2 A - p.
#[multiversion(targets("x86_64+avx512f+avx512dq", "x86_64+avx2", "x86_64+avx"))]
fn fill_rows(constants: &Constants, circle: &Circle, rows: &mut Rows) {
    let Constants {
        slopes,
        alpha,
        mu,
        sin_o,
        end,
        ..
    } = *constants;
    let whole = 1.0 + sin_o;
    let twice = 2.0 * ln(whole / mu); // 2 A
    let ggx = slopes == Slopes::Ggx;
    let limit = if ggx { f64::INFINITY } else { end };
    let height = circle.sin2.len();
    let (sin2, cos2) = (&circle.sin2[..height], &circle.cos2[..height]);
    let (reach, inverse, x) = (
        &mut rows.reach[..height],
        &mut rows.inverse[..height],
        &mut rows.x[..height],
    );
    let (length, scale) = (&mut rows.length[..height], &mut rows.scale[..height]);
    for j in 0..height {
        let (p, q) = (twice * sin2[j], twice * cos2[j]);
        let (power, other) = (exp(p), exp(q));
        let y = whole / power;
        let inverse_t = mu / y;
        let (shc_p, shc_q) = (shc(p, power), shc(q, other));
        let cosh = 0.5 * (y / mu + inverse_t);
        let jacobian = cosh / (shc_p * shc_q).sqrt();
        reach[j] = y;
        inverse[j] = inverse_t;
        x[j] = 0.5 * (y - mu * inverse_t);
        let last = inverse_t.recip().min(limit);
        let ratio = if ggx { last / alpha } else { last };
        let root = (1.0 + ratio * ratio).sqrt();
        let span = if ggx {
            ln(ratio + root).min(end)
        } else {
            ratio / (1.0 + root)
        };
        length[j] = span;
        scale[j] = jacobian * span;
    }
}

/// t = alpha sinh s, of density 2 sinh s/cosh^3 s.
#[multiversion(targets("x86_64+avx512f+avx512dq", "x86_64+avx2", "x86_64+avx"))]
fn ggx(constants: &Constants, t: &mut [f64], reach: &[f64], inverse: &[f64], x: &[f64], value: &mut [f64]) {
    let Constants {
        alpha,
        mu,
        factor,
        own,
        other,
        ..
    } = *constants;
    let (square, rest) = (alpha * alpha, (1.0 - alpha) * (1.0 + alpha));
    let twice = 2.0 * factor;
    let count = t.len();
    let (reach, inverse, x, value) = (&reach[..count], &inverse[..count], &x[..count], &mut value[..count]);
    for i in 0..count {
        let power = exp(t[i]);
        let reciprocal = power.recip();
        let (sinh, cosh) = (0.5 * (power - reciprocal), 0.5 * (power + reciprocal));
        let tan = alpha * sinh;
        let q = 1.0 + tan * tan;
        // n.i q = (mu T - mu t)(t + 1/T)
        let seen = (reach[i] - mu * tan).max(0.0) * (tan + inverse[i]);
        let half = (square * (q * q) + rest * (seen * seen)).max(0.0).sqrt();
        let numerator = twice * sinh * (mu + x[i] * tan) * seen;
        value[i] = numerator / (cosh * cosh * cosh * (own * seen + other * half));
        t[i] = tan;
    }
}

/// t = 2 u/(1 - u^2), of density 2 (t/alpha^2) e^(-t^2/alpha^2) dt.
#[multiversion(targets("x86_64+avx512f+avx512dq", "x86_64+avx2", "x86_64+avx"))]
fn beckmann(constants: &Constants, t: &mut [f64], reach: &[f64], inverse: &[f64], x: &[f64], value: &mut [f64]) {
    let Constants {
        alpha,
        mu,
        factor,
        own,
        other,
        ..
    } = *constants;
    let count = t.len();
    let (reach, inverse, x, value) = (&reach[..count], &inverse[..count], &x[..count], &mut value[..count]);
    let over = alpha.recip();
    let scale = 4.0 * factor * over;
    for i in 0..count {
        let u = t[i];
        let (square, less) = (u * u, (1.0 - u) * (1.0 + u));
        let both = (less * (1.0 + square)).recip();
        let one = both * (1.0 + square); // 1/(1 - u^2)
        let cos_h = both * less * less; // (1 - u^2)/(1 + u^2)
        let tan = 2.0 * u * one;
        let slope = tan * over;
        let jacobian = (1.0 + square) * one * one;
        let cos_i = (reach[i] - mu * tan).max(0.0) * (tan + inverse[i]) * (cos_h * cos_h);
        let stretched = alpha * ((1.0 - cos_i) * (1.0 + cos_i)).max(0.0).sqrt();
        // ierfc of (n.i)/stretched, times (n.i + stretched)^2/stretched^2
        let sum = cos_i + stretched;
        let ratio = (cos_i * cos_i / (stretched * stretched).max(f64::MIN_POSITIVE)).min(MOST_SQUARE);
        let scaled = scaled_ierfc((cos_i - 3.0 * stretched) / (cos_i + 3.0 * stretched));
        let hidden = 0.5 * (stretched * stretched * stretched) * exp(-ratio) * scaled;
        let numerator = scale * slope * exp(-slope * slope) * jacobian * (mu + x[i] * tan) * cos_i;
        value[i] = numerator * (sum * sum) / (own * cos_i * (sum * sum) + other * hidden);
        t[i] = tan;
    }
}
