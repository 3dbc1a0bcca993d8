//! Albedos of lobes, integrated afresh.

use glam::DVec3;
use std::f64::consts::TAU;
use whitefurnace::bxdf::{Microfacet, Model};
use whitefurnace::distribution::Family;
use whitefurnace::fresnel::Fresnel;
use whitefurnace::integrate::deterministic::quadrature;
use whitefurnace::integrate::{RoughInterface, Target};
use whitefurnace::masking::Masking;
use whitefurnace::spectrum::Spectrum;

fn albedo(family: Family, masking: Masking, fresnel: Fresnel, [mu, alpha]: [f64; 2], tolerance: f64) -> f64 {
    let lobe = Microfacet::new(Spectrum::grey(1.0), family.with(alpha).unwrap(), masking, fresnel).unwrap();
    let found = quadrature(&Model::Microfacet(lobe), Target::rho_hd(mu, 0.0), tolerance).unwrap();
    let DVec3 { x, .. } = found.value;
    x
}

/// E of metal with F = 1 at alpha.
pub(crate) fn metal(mu: f64, alpha: f64) -> f64 {
    let at = [mu, alpha];
    albedo(Family::Ggx, Masking::SmithCorrelated, Fresnel::None, at, 1e-8)
}

/// The albedo under Schlick's term with `r0`.
pub(crate) fn schlick(mu: f64, alpha: f64, r0: f64) -> f64 {
    let fresnel = Fresnel::schlick(Spectrum::grey(r0)).unwrap();
    albedo(Family::Ggx, Masking::SmithCorrelated, fresnel, [mu, alpha], 1e-8)
}

/// Charlie sheen of exponent 1/alpha.
pub(crate) fn sheen(mu: f64, alpha: f64) -> f64 {
    albedo(Family::Charlie, Masking::Neubelt, Fresnel::None, [mu, alpha], 1e-6)
}

/// Reflected and transmitted share of glass.
pub(crate) fn glass(mu: f64, alpha: f64, eta: f64) -> [f64; 2] {
    let interface = RoughInterface::new(Family::Ggx.with(alpha).unwrap(), Masking::SmithCorrelated, eta).unwrap();
    let found = interface.albedos(mu, 1e-6).unwrap();
    [found.reflected, found.transmitted]
}

/// Burley's diffuse lobe over 1.03571, by midpoints of n.l and of the azimuth: within 2e-5, as the test of the closed form has it for
/// 400 of the former, and the error goes with the square.
pub(crate) fn disney(mu: f64, r: f64) -> f64 {
    let (cells, turns) = (200, 16);
    let mut sum = 0.0;
    for i in 0..cells {
        let x = (f64::from(i) + 0.5) / f64::from(cells);
        for j in 0..turns {
            let phi = TAU * f64::from(j) / f64::from(turns);
            let light = [(1.0 - x * x).sqrt() * phi.cos(), (1.0 - x * x).sqrt() * phi.sin(), x];
            let view = [(1.0 - mu * mu).sqrt(), 0.0, mu];
            let half = [0, 1, 2].map(|k| light[k] + view[k]);
            let length = half.iter().map(|part| part * part).sum::<f64>().sqrt();
            let lh = light.iter().zip(half).map(|(l, h)| l * h).sum::<f64>() / length;
            let f90 = 0.5 + 2.0 * lh * lh * r;
            let arm = |cos: f64| 1.0 + (f90 - 1.0) * (1.0 - cos).powi(5);
            sum += 2.0 * x * arm(x) * arm(mu) / f64::from(cells * turns);
        }
    }
    sum / 1.03571
}
