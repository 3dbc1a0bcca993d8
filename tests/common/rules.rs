//! Integration rules that share nothing with the library: fixed, dense, and without knowledge of any integrand.

use glam::DVec3;

/// Nodes in [-1, 1] and weights of the Gauss-Legendre rule of five points [Abramowitz and Stegun 1964, table 25.4].
const GAUSS: [(f64, f64); 5] = [
    (0.0, 0.568_888_888_888_888_9),
    (-0.538_469_310_105_683_1, 0.478_628_670_499_366_5),
    (0.538_469_310_105_683_1, 0.478_628_670_499_366_5),
    (-0.906_179_845_938_664, 0.236_926_885_056_189_1),
    (0.906_179_845_938_664, 0.236_926_885_056_189_1),
];

/// Five Gauss points in each of `panels` equal parts of [from, to].
pub(crate) fn composite(from: f64, to: f64, panels: usize, mut f: impl FnMut(f64) -> f64) -> f64 {
    let half = 0.5 * (to - from) / panels as f64;
    let mut sum = 0.0;
    for i in 0..panels {
        let centre = from + (2 * i + 1) as f64 * half;
        for (x, weight) in GAUSS {
            sum += weight * f(centre + half * x);
        }
    }
    sum * half
}

/// [`composite`] on each octave [to/2, to], [to/4, to/2], ...: resolves every scale down to `to` times 2^-octaves alike.
pub(crate) fn octaves(to: f64, octaves: i32, panels: usize, mut f: impl FnMut(f64) -> f64) -> f64 {
    let mut sum = composite(0.0, to * 0.5f64.powi(octaves), panels, &mut f);
    for k in 0..octaves {
        let top = to * 0.5f64.powi(k);
        sum += composite(0.5 * top, top, panels, &mut f);
    }
    sum
}

/// [`octaves`] from both ends of [from, to] to its middle.
pub(crate) fn both_ends(from: f64, to: f64, count: i32, panels: usize, mut f: impl FnMut(f64) -> f64) -> f64 {
    let half = 0.5 * (to - from);
    octaves(half, count, panels, |x| f(from + x)) + octaves(half, count, panels, |x| f(to - x))
}

/// The normal with the slopes s (a_x cos psi, a_y sin psi), s = tan `v`, and dh/(dv dpsi), its solid angle per area of
/// (v, psi) in [0, pi/2) x [0, 2 pi): coordinates in which an elliptic lobe is as wide along every azimuth.
pub(crate) fn stretched_normal(axes: [f64; 2], v: f64, psi: f64) -> (DVec3, f64) {
    let s = v.tan();
    let (x, y) = (s * axes[0] * psi.cos(), s * axes[1] * psi.sin());
    let cos = 1.0 / 1f64.hypot(x.hypot(y));
    // dh = cos^3 dx dy and dx dy = a_x a_y s ds dpsi
    let solid_angle = cos.powi(3) * axes[0] * axes[1] * s * (1.0 + s * s);
    (DVec3::new(x * cos, y * cos, cos), solid_angle)
}

/// (v, psi) of a normal, the inverse of [`stretched_normal`]; psi in [-pi, pi].
pub(crate) fn stretched_angles(axes: [f64; 2], h: DVec3) -> (f64, f64) {
    let (x, y) = (h.x / axes[0], h.y / axes[1]);
    (x.hypot(y).atan2(h.z), y.atan2(x))
}
