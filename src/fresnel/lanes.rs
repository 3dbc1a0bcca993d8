//! Fresnel terms of many facets at once.

use super::{Fresnel, beyond_brewster};
use crate::geometry::Polar;
use crate::numerics::points::BLOCK;
use multiversion::multiversion;

/// One number for each facet.
type Lane = [f64; BLOCK];

impl Fresnel {
    /// Multiplies the first `len` of `weights` by the reflectance of `channel` at the cosines `cos`, and by `scale`.
    pub(crate) fn attenuate(&self, channel: usize, scale: f64, cos: &Lane, weights: &mut Lane, len: usize) {
        match self {
            Self::None => weights.iter_mut().for_each(|weight| *weight *= scale),
            Self::Dielectric { eta } => dielectrics(eta.value()[channel], scale, cos, weights),
            Self::Conductor { .. } | Self::ConductorApproximate { .. } | Self::Schlick { .. } => {
                for (weight, cos) in weights.iter_mut().zip(cos).take(len) {
                    if *weight > 0.0 {
                        *weight *= scale * self.reflectance(*cos)[channel];
                    }
                }
            }
        }
    }
}

/// [`super::dielectric`] of every cosine in [0, 1]; what others multiply is of no interest.
#[multiversion(targets("x86_64+avx512f+avx512dq", "x86_64+avx2", "x86_64+avx"))]
fn dielectrics(eta: f64, scale: f64, cos: &Lane, weights: &mut Lane) {
    let step = (eta - 1.0) * (eta + 1.0);
    let whole = if step == 0.0 { 0.0 } else { 1.0 };
    let eta_squared = eta * eta;
    for k in 0..BLOCK {
        let c = cos[k];
        let sin = ((1.0 - c) * (1.0 + c)).max(0.0).sqrt();
        let low = step + c * c;
        let high = (eta - sin) * (eta + sin);
        let g_squared = if c < sin { low } else { high };
        let g = g_squared.max(0.0).sqrt();
        let r_perp = -step / ((c + g) * (c + g));
        let par = eta_squared * c + g;
        let r_par = step * beyond_brewster(Polar { sin, cos: c }, eta, g) / (par * par);
        let partial = (0.5 * (r_perp * r_perp + r_par * r_par)).min(1.0);
        let f = if (c > 0.0) & (g_squared > 0.0) { partial } else { whole };
        // nothing is lost twice: 0 times what a facet out of sight has for a reflectance
        weights[k] = if weights[k] > 0.0 { weights[k] * scale * f } else { 0.0 };
    }
}
