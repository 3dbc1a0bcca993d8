//! V-shaped grooves: the normals that a direction sees of them.

use crate::distribution::Distribution;
use glam::DVec3;

/// A normal drawn from those that `wo` sees on V-grooves: density G1(o, h) max(0, o.h) D(h)/(n.o), with `u` in [0, 1)^3.
///
/// A groove has the two normals h and h' = (-h.x, -h.y, h.z), and their cosines add up to 2 (n.h)(n.o). The groove is drawn
/// from p(h); of its two walls each is seen in proportion to max(0, o.h) and max(0, o.h').
pub fn sample_visible_groove(distribution: &Distribution, wo: DVec3, u: [f64; 3]) -> DVec3 {
    let wm = distribution.sample([u[0], u[1]]);
    let twin = DVec3::new(-wm.x, -wm.y, wm.z);
    let (near, far) = (wo.dot(wm).max(0.0), wo.dot(twin).max(0.0));
    if u[2] * (near + far) < near { wm } else { twin }
}

/// Density of [`sample_visible_groove`] over solid angle, p(h) min((o.h)/((n.h)(n.o)), 2), for o.h > 0; 0 otherwise.
pub fn visible_groove_pdf(distribution: &Distribution, cos_o: f64, h: DVec3, cos_d: f64) -> f64 {
    if cos_d <= 0.0 {
        return 0.0;
    }
    distribution.p(h) * (cos_d / (h.z * cos_o)).min(2.0)
}
