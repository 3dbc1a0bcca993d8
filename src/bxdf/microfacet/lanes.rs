//! Weights of microfacets for many draws at once.
//!
//! Every step is a loop over lanes that vector units run: normals, cosines and masking, Fresnel. What has no such formulae,
//! anisotropic distributions but for the visible normals of GGX, and the Smith terms of Beckmann, is left to one draw after
//! the other.

use super::Microfacet;
use crate::bxdf::weights::{BLOCK, Draws, Lane};
use crate::bxdf::{Bxdf, Flags, Sampling};
use crate::distribution::{Isotropic, lanes as distribution};
use crate::masking::Masking;
use crate::masking::lanes::{Facets, Mask, visible_slopes, visible_walls};
use crate::numerics::lanes::sin_cos_turns;
use multiversion::multiversion;
use std::f64::consts::{PI, TAU};

impl Microfacet {
    /// Writes the weights when there are formulae for them, or says that there are none.
    pub(super) fn lanes(&self, sampling: Sampling, side: Flags, draws: Draws<'_>, weights: &mut [Lane; 3]) -> bool {
        let Some(mask) = Mask::new(self.masking, &self.distribution) else {
            return false;
        };
        let profile = self.distribution.isotropic();
        // f depends on the sides of the directions alone, and these loops are for those above
        let heights = &draws.wo[2][..draws.len];
        if heights.iter().any(|z| *z < 0.0) || !side.contains(Flags::REFLECTION) {
            return false;
        }
        // where f has no limit
        if self.masking == Masking::None && heights.contains(&0.0) {
            return false;
        }
        let mut facets = Facets {
            h: [[0.0; BLOCK]; 3],
            cos_d: [0.0; BLOCK],
        };
        let mut base = [0.0; BLOCK];
        let [u, v, w] = draws.u;
        match (self.drawn(sampling), profile, mask.slopes()) {
            (Sampling::Visible | Sampling::Bxdf, _, Some(axes)) => {
                visible_slopes(axes, draws.wo, [u, v], &mut facets.h);
                mask.visible_weights(draws.wo, &mut facets, &mut base);
            }
            (Sampling::Visible | Sampling::Bxdf, Some(profile), None) => {
                distribution::normals(profile, [u, v], &mut facets.h);
                visible_walls(draws.wo, w, &mut facets.h);
                mask.visible_weights(draws.wo, &mut facets, &mut base);
            }
            (Sampling::Normals, Some(profile), _) => {
                distribution::normals(profile, [u, v], &mut facets.h);
                mask.weights(draws.wo, &mut facets, &mut base);
            }
            (Sampling::Uniform | Sampling::Cosine, Some(profile), _) => {
                let uniform = self.drawn(sampling) == Sampling::Uniform;
                hemispheres(
                    profile,
                    mask,
                    uniform,
                    [draws.wo, &[*u, *v, *w]],
                    &mut facets,
                    &mut base,
                );
            }
            _ => return false,
        }
        let channels = self.channels().count();
        for (channel, weights) in weights.iter_mut().enumerate().take(channels) {
            *weights = base;
            let scale = self.reflectance.value()[channel];
            self.fresnel
                .attenuate(channel, scale, &facets.cos_d, weights, draws.len);
        }
        true
    }
}

/// D V'/(4 (n.o)(n.i)) |cos theta_i|/pdf of directions drawn uniformly or by their cosines.
fn hemispheres(
    profile: &Isotropic,
    mask: Mask,
    uniform: bool,
    [wo, u]: [&[Lane; 3]; 2],
    facets: &mut Facets,
    out: &mut Lane,
) {
    let mut wi = [[0.0; BLOCK]; 3];
    let mut density = [0.0; BLOCK];
    directions(uniform, &u[0], &u[1], &mut wi);
    mask.visibilities(wo, &wi, facets, out);
    distribution::densities(profile, &facets.h, &mut density);
    quotients(uniform, &wi[2], &density, out);
}

#[multiversion(targets("x86_64+avx512f+avx512dq", "x86_64+avx2", "x86_64+avx"))]
fn directions(uniform: bool, u: &Lane, v: &Lane, [x, y, z]: &mut [Lane; 3]) {
    for k in 0..BLOCK {
        let by_height = (((1.0 - u[k]) * (1.0 + u[k])).sqrt(), u[k]);
        let by_cosine = (u[k].sqrt(), (1.0 - u[k]).sqrt());
        let radius = if uniform { by_height.0 } else { by_cosine.0 };
        let (sin, cos) = sin_cos_turns(v[k]);
        x[k] = radius * cos;
        y[k] = radius * sin;
        z[k] = if uniform { by_height.1 } else { by_cosine.1 };
    }
}

#[multiversion(targets("x86_64+avx512f+avx512dq", "x86_64+avx2", "x86_64+avx"))]
fn quotients(uniform: bool, cos_i: &Lane, density: &Lane, out: &mut Lane) {
    for k in 0..BLOCK {
        let factor = if uniform { TAU * cos_i[k] } else { PI };
        let lobe = (out[k] * density[k]).min(crate::masking::LARGEST);
        // a density that vanishes outweighs a shape that has overflowed
        out[k] = if density[k] > 0.0 { lobe * factor } else { 0.0 };
    }
}
