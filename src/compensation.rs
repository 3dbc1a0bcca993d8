//! What tables of albedos are for: the light that a rough surface scatters more than once, and the diffuse base under a lobe.
//!
//! A lobe f_ss of facets that reflect everything loses 1 - E(o) of the light from wo, E its rho_hd for F = 1: what its facets
//! mask has met another facet and would leave later. E_avg is the cosine-weighted mean of E, rho_hh. Both come from the second
//! channel of a table for every r0, or from a table of the lobe without a Fresnel term; [`crate::shader`] has the same
//! formulae in f32.

use crate::bxdf::Coupling;
use glam::DVec3;
use std::f64::consts::FRAC_1_PI;

/// Cosine-weighted mean of Schlick's Fresnel term, 2 int (r0 + (1 - r0)(1 - mu)^5) mu dmu = (20 r0 + 1)/21.
pub fn mean_schlick(r0: DVec3) -> DVec3 {
    (20.0 * r0 + DVec3::ONE) / 21.0
}

/// The lobe of light that is scattered more than once [Kulla and Conty 2017], in sr^-1, to be added to f_ss.
///
/// f_ms = F_ms (1 - E(o)) (1 - E(i))/(pi (1 - E_avg)) reflects F_ms (1 - E(o)) of the light from wo, since the mean of 1 - E is
/// 1 - E_avg; it is reciprocal. Behind F_ms stands a walk that forgets where it came from: of what a facet reflects, the share
/// E_avg leaves, and 1 - E_avg meets another facet, which reflects F_avg of it. Of the light that has not left after its first
/// facet, and which that facet has dimmed by F_avg already,
///
/// F_ms = F_avg sum_k>=1 F_avg^k (1 - E_avg)^(k-1) E_avg = F_avg^2 E_avg/(1 - F_avg (1 - E_avg)).
///
/// Published forms differ in the power of F_avg. The first, F_avg E_avg/(1 - F_avg (1 - E_avg)), leaves out the first facet, and
/// reflects too much of coloured light; both are 1 at F_avg = 1.
///
/// Where E_avg is 1, or above by the error of a table, nothing is left to scatter, and the result is 0; likewise where E(o) or
/// E(i) is. `r0` in [0, 1].
pub fn kulla_conty(r0: DVec3, e_o: f64, e_i: f64, e_mean: f64) -> DVec3 {
    let missing = 1.0 - e_mean;
    if missing <= 0.0 {
        return DVec3::ZERO;
    }
    let mean = mean_schlick(r0);
    let colour = mean * mean * e_mean / (DVec3::ONE - mean * missing);
    // in this order the product does not change a bit when the directions are exchanged
    colour * ((1.0 - e_o).max(0.0) * (1.0 - e_i).max(0.0) * (FRAC_1_PI / missing))
}

/// The factor of f_ss that puts the same light into its own shape, 1 + r0 (1/E(o) - 1) [Turquin 2019].
///
/// The whole reflects E(o)/E(o) = 1 at r0 = 1 for every wo, exactly. It is not reciprocal: E of the other direction takes no
/// part. E(o) below 1e-4 counts as that; no lobe of a legal roughness comes near it. `r0` in [0, 1].
pub fn turquin(r0: DVec3, e_o: f64) -> DVec3 {
    DVec3::ONE + r0 * ((1.0 - e_o).max(0.0) / e_o.max(SMALLEST_ALBEDO))
}

/// Least albedo that [`turquin`] divides by.
const SMALLEST_ALBEDO: f64 = 1e-4;

/// The diffuse base under a specular lobe [Mikkelsen 2009, eq. 28], in sr^-1: (1 - ks rho(i)) kd/pi (1 - ks rho(o)), over
/// 1 - ks rho_bar where `coupling` preserves energy. The lobe itself, ks f_s, is to be added.
///
/// `rho_o` and `rho_i` are rho_hd of the lobe at both cosines, `rho_mean` its rho_hh, all at ks = 1. Albedos above 1, by the
/// error of a table or because a model does not conserve energy, leave nothing.
pub fn base(coupling: Coupling, [ks, kd]: [DVec3; 2], rho_o: DVec3, rho_i: DVec3, rho_mean: DVec3) -> DVec3 {
    let left = |rho: DVec3| (DVec3::ONE - ks * rho).max(DVec3::ZERO);
    let base = kd * FRAC_1_PI * (left(rho_o) * left(rho_i));
    match coupling {
        Coupling::Mikkelsen => base,
        Coupling::EnergyPreserving => {
            let unspent = DVec3::ONE - ks * rho_mean;
            DVec3::select(unspent.cmpgt(DVec3::ZERO), base / unspent, DVec3::ZERO)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The walk, bounce by bounce.
    #[test]
    fn the_coloured_factor_is_the_sum_over_bounces() {
        for r0 in [0.0, 0.04, 0.5, 0.97, 1.0] {
            for e_mean in [0.3, 0.7, 0.999] {
                let f = mean_schlick(DVec3::splat(r0)).x;
                let (mut sum, mut light) = (0.0, f);
                for _ in 0..2000 {
                    light *= f;
                    sum += light * e_mean;
                    light *= 1.0 - e_mean;
                }
                // with E(o) = 0 and E(i) = E_avg the lobe is F_ms/pi
                let lobe = kulla_conty(DVec3::splat(r0), 0.0, e_mean, e_mean).x;
                // 2000 roundings of a sum of positive terms
                assert!((lobe / FRAC_1_PI - sum).abs() < 1e-12, "{r0} {e_mean}: {lobe} {sum}");
            }
        }
    }

    #[test]
    fn the_mean_of_schlick_is_its_integral() {
        let (r0, n) = (0.3, 100_000);
        let sum: f64 = (0..n)
            .map(|i| (f64::from(i) + 0.5) / f64::from(n))
            .map(|mu| 2.0 * mu * (r0 + (1.0 - r0) * (1.0 - mu).powi(5)) / f64::from(n))
            .sum();
        // the midpoint rule errs by f'(1) - f'(0) over 24 n^2, 1e-10
        assert!((sum - mean_schlick(DVec3::splat(r0)).x).abs() < 1e-9);
    }

    #[test]
    fn lobes_that_lose_nothing_add_nothing() {
        let one = DVec3::ONE;
        for e in [1.0, 1.0 + 1e-7] {
            assert_eq!(kulla_conty(one, e, e, e), DVec3::ZERO);
            assert_eq!(turquin(one, e), one);
            assert_eq!(
                base(Coupling::EnergyPreserving, [one, one], one, one, DVec3::splat(e)),
                DVec3::ZERO
            );
        }
        assert!(turquin(one, 0.0).is_finite());
        // the quotient stays what it is however little is lost
        for tiny in [1e-6, 1e-12] {
            let lobe = kulla_conty(one, 1.0 - tiny, 1.0 - tiny, 1.0 - tiny).x;
            assert!((lobe / (tiny * FRAC_1_PI) - 1.0).abs() < 1e-3, "{lobe:e}"); // 1 - tiny holds 1e-16 of 1
        }
    }

    #[test]
    fn directions_may_be_exchanged() {
        let (r0, kd) = (DVec3::new(0.1, 0.5, 0.9), DVec3::new(0.9, 0.3, 0.2));
        let (a, b) = (DVec3::new(0.31, 0.62, 0.47), DVec3::new(0.93, 0.71, 0.11));
        assert_eq!(kulla_conty(r0, 0.93, 0.41, 0.6), kulla_conty(r0, 0.41, 0.93, 0.6));
        for coupling in [Coupling::Mikkelsen, Coupling::EnergyPreserving] {
            assert_eq!(base(coupling, [r0, kd], a, b, a), base(coupling, [r0, kd], b, a, a));
        }
        assert_ne!(turquin(r0, 0.93), turquin(r0, 0.41));
    }
}
