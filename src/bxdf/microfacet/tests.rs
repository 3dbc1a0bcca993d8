//! Weights are the quotients that they stand for, one by one and in blocks.

use super::*;
use crate::bxdf::BLOCK;
use crate::distribution::{Anisotropic, Elliptic, Family};
use crate::numerics::stream::{Stream, StreamId};
use std::f64::consts::TAU;

fn extreme_lobes() -> Vec<Microfacet> {
    let isotropic = [
        (Family::Vmf, [0.0, 1e-9, 0.7, 17.0, 1e5, 1e12]),
        (Family::Beckmann, [1e-6, 1e-3, 0.2, 0.7, 2.0, 10.0]),
        (Family::Phong, [0.0, 1.5, 20.0, 1e3, 1e6, 1e8]),
        (Family::Ggx, [1e-6, 1e-3, 0.05, 0.3, 1.0, 10.0]),
    ];
    let mut distributions: Vec<Distribution> = isotropic
        .into_iter()
        .flat_map(|(family, sizes)| sizes.map(|size| family.with(size).unwrap().into()))
        .collect();
    distributions.extend([(1e-6, 10.0), (0.3, 0.1)].map(|(x, y)| {
        let ggx = Anisotropic::new(Elliptic::Ggx, x, y).unwrap();
        Distribution::from(ggx)
    }));
    let rgb = Spectrum::rgb([0.769, 1.0, 1.4]);
    let fresnels = [
        Fresnel::None,
        Fresnel::dielectric(Spectrum::grey(1.329)).unwrap(),
        Fresnel::dielectric(Spectrum::rgb([0.01, 1.0, 1.5])).unwrap(),
        Fresnel::conductor(rgb, Spectrum::grey(6.08)).unwrap(),
    ];
    let maskings = [
        Masking::None,
        Masking::VGroove,
        Masking::Smith,
        Masking::SmithCorrelated,
    ];
    let mut lobes = Vec::new();
    for (index, distribution) in distributions.into_iter().enumerate() {
        for (shift, masking) in maskings.into_iter().enumerate() {
            let fresnel = fresnels[(index + shift) % fresnels.len()];
            lobes.extend(Microfacet::new(
                Spectrum::rgb([0.7, 0.7, 1.0]),
                distribution,
                masking,
                fresnel,
            ));
        }
    }
    lobes
}

/// To 1e-13, or to what the last bits of u and wo are worth: lobes of 1e-6 multiply them by 1e6, and n.i and o.h cancel.
#[test]
fn blocks_agree_with_single_draws() {
    let mut stream = Stream::new(StreamId {
        seed: 3,
        cell: 0,
        batch: 0,
    });
    let (mut fast, mut worst) = (0, 0.0f64);
    for lobe in extreme_lobes() {
        for mu in [0.0, 1e-12, 1e-6, 0.01, 0.3, 0.9, 1.0] {
            if lobe.masking == Masking::None && mu == 0.0 {
                continue; // weights grow without bound there
            }
            for sampling in Sampling::ALL {
                let wo = Polar::from_cos(mu).direction(TAU * stream.uniform());
                let mut u = [[0.0; BLOCK]; 3];
                u.as_flattened_mut().fill_with(|| stream.uniform());
                u[0][..3].copy_from_slice(&[0.0, 1e-12, 1.0 - 0.5 * f64::EPSILON]);
                let draws = Draws {
                    wo: &wo.to_array().map(|w| [w; BLOCK]),
                    u: [&u[0], &u[1], &u[2]],
                    len: BLOCK,
                };
                let mut weights = [[0.0; BLOCK]; 3];
                if !lobe.lanes(sampling, Flags::REFLECTION, draws, &mut weights) {
                    continue;
                }
                fast += 1;
                for k in 0..BLOCK {
                    let at = [0, 1, 2].map(|axis: usize| u[axis][k]);
                    let one = |wo: DVec3, u: [f64; 3]| lobe.sample(sampling, wo, u).weight;
                    let exact = one(wo, at);
                    let mut varies = DVec3::ZERO;
                    for step in [-f64::EPSILON, f64::EPSILON] {
                        for axis in 0..2 {
                            let mut near = at;
                            near[axis] = (near[axis] + step).clamp(0.0, 1.0 - 0.5 * f64::EPSILON);
                            varies += (one(wo, near) - exact).abs();
                            let mut near = wo;
                            near[axis] *= 1.0 + step;
                            varies += (one(near, at) - exact).abs();
                        }
                        let near = DVec3::new(wo.x, wo.y, (wo.z * (1.0 + step)).min(1.0));
                        varies += (one(near, at) - exact).abs();
                    }
                    for channel in 0..lobe.channels().count() {
                        let (found, exact) = (weights[channel][k], exact[channel]);
                        if found == exact || (found >= LARGEST && exact >= LARGEST) {
                            continue;
                        }
                        let error = (found - exact).abs();
                        let allowed = 1e-13 * exact.max(1.0) + 16.0 * varies[channel];
                        assert!(
                            error <= allowed,
                            "{lobe:?} {mu} {sampling:?} {at:?}: {found:e} and {exact:e}, {allowed:e} allowed"
                        );
                        worst = worst.max(error / exact.max(1.0));
                    }
                }
            }
        }
    }
    assert!(fast > 2000, "{fast}");
    println!("{fast} blocks, worst {worst:e}");
}

/// One lobe of each distribution under each masking that goes with it.
fn lobes(reflectance: f64, fresnel: Fresnel) -> Vec<Microfacet> {
    let isotropic = [
        (Family::Vmf, 17.0),
        (Family::Beckmann, 0.2),
        (Family::Phong, 1e4),
        (Family::Ggx, 0.3),
        (Family::Charlie, 0.1),
    ];
    let elliptic = [
        (Elliptic::Beckmann, 0.1, 0.6),
        (Elliptic::Ggx, 0.5, 0.05),
        (Elliptic::AshikhminShirley, 10.0, 200.0),
    ];
    let isotropic = isotropic.map(|(family, x)| Distribution::from(family.with(x).unwrap()));
    let elliptic = elliptic.map(|(kind, x, y)| Distribution::from(Anisotropic::new(kind, x, y).unwrap()));
    let mut lobes = Vec::new();
    for distribution in isotropic.into_iter().chain(elliptic) {
        for masking in [
            Masking::None,
            Masking::VGroove,
            Masking::Smith,
            Masking::SmithCorrelated,
            Masking::Neubelt,
            Masking::Charlie,
        ] {
            match Microfacet::new(Spectrum::grey(reflectance), distribution, masking, fresnel) {
                Ok(lobe) => lobes.push(lobe),
                Err(_) if masking.is_sheen() != (distribution.name() == "charlie") => {}
                Err(error) => assert!(masking.is_smith() && Smith::new(&distribution).is_none(), "{error}"),
            }
        }
    }
    assert_eq!(lobes.len(), 2 * 7 + 2 * 4 + 2);
    lobes
}

#[test]
fn f_is_symmetric_to_the_last_bit() {
    for bxdf in lobes(1.0, Fresnel::dielectric(Spectrum::grey(1.329)).unwrap()) {
        for i in 0..400 {
            let t = f64::from(i);
            let wo = Polar::from_cos((0.5 + 0.5 * (t * 0.7).sin()).powi(3)).direction(t);
            let wi = Polar::from_cos((0.5 + 0.5 * (t * 1.3).cos()).powi(3)).direction(2.1 * t);
            assert_eq!(bxdf.f(wo, wi), bxdf.f(wi, wo));
            assert_eq!(bxdf.f(wo, wi), bxdf.f(-wo, -wi));
        }
    }
}

/// weight = f cos/pdf wherever the quotient itself can be formed.
#[test]
fn weights_are_the_quotients_they_stand_for() {
    let fresnel = Fresnel::conductor(Spectrum::grey(0.769), Spectrum::grey(6.08)).unwrap();
    for bxdf in lobes(0.7, fresnel) {
        for sampling in [
            Sampling::Uniform,
            Sampling::Cosine,
            Sampling::Normals,
            Sampling::Visible,
            Sampling::Bxdf,
        ] {
            for i in 0..200 {
                let t = f64::from(i) * 0.618;
                let u = [t.fract(), (t * 1.7).fract(), (t * 2.9).fract()];
                let wo = Polar::from_cos((t * 3.1).fract()).direction(0.3 * t);
                let sample = bxdf.sample(sampling, wo, u);
                // what has underflowed has no digits left to compare
                if sample.weight.x < 1e-290 {
                    continue;
                }
                // n.i and o.h cancel near 0, and narrow lobes multiply the rounding of h by the inverse of their width
                let tolerance = 1e-9;
                let quotient = bxdf.f(wo, sample.wi) * sample.wi.z / sample.pdf;
                let relative = (quotient / sample.weight - DVec3::ONE).abs().max_element();
                assert!(
                    relative < tolerance,
                    "{bxdf:?} {sampling:?} {i}: {quotient} and {}",
                    sample.weight
                );
                if sampling == Sampling::Bxdf {
                    assert!((bxdf.pdf(wo, sample.wi) / sample.pdf - 1.0).abs() < tolerance);
                }
            }
        }
    }
}

#[test]
fn smith_goes_with_slopes_only() {
    for masking in [Masking::Smith, Masking::SmithCorrelated] {
        for distribution in [
            Distribution::from(Family::Phong.with(10.0).unwrap()),
            Anisotropic::new(Elliptic::AshikhminShirley, 10.0, 20.0).unwrap().into(),
        ] {
            let refused = Microfacet::new(Spectrum::grey(1.0), distribution, masking, Fresnel::None).unwrap_err();
            let message = format!(
                "masking \"{}\" is not allowed with distribution \"{}\": it goes with beckmann and ggx only",
                masking.name(),
                distribution.name()
            );
            assert_eq!(refused.to_string(), message);
        }
    }
    let too_much = Spectrum::grey(1.5);
    let beckmann = Family::Beckmann.with(0.2).unwrap();
    let refused = Microfacet::new(too_much, beckmann, Masking::Smith, Fresnel::None).unwrap_err();
    assert!(matches!(refused, ModelError::Parameter(error) if error.parameter == "reflectance"));
}

/// Directions below the surface and at the horizon are turned over to a cosine of -0, which is 0.
#[test]
fn a_cosine_of_minus_zero_is_that_of_the_horizon() {
    let lobe = Family::Vmf.with(1.0).unwrap();
    let grooves = Microfacet::new(Spectrum::grey(1.0), lobe, Masking::VGroove, Fresnel::None).unwrap();
    let steep = DVec3::new(0.6, 0.0, 0.8);
    let (above, below) = (DVec3::new(1.0, 0.0, 0.0), DVec3::new(1.0, 0.0, -0.0));
    assert_eq!(grooves.f(steep, below), grooves.f(steep, above));
    assert_eq!(grooves.f(-steep, -above), grooves.f(steep, above));
    assert!(grooves.f(steep, below).is_finite());
    assert_eq!(grooves.pdf(below, steep), grooves.pdf(above, steep));
    for sampling in [Sampling::Normals, Sampling::Visible] {
        let drawn = grooves.sample(sampling, -below, [0.3, 0.4, 0.5]);
        assert!(drawn.pdf.is_finite() && drawn.pdf >= 0.0, "{drawn:?}");
    }
}

/// Without masking f has no limit where wo is at the horizon: it counts 0, and so does every draw.
#[test]
fn nothing_is_drawn_at_the_horizon_without_masking() {
    let lobe = Family::Vmf.with(1.0).unwrap();
    let open = Microfacet::new(Spectrum::grey(0.0), lobe, Masking::None, Fresnel::None).unwrap();
    for sampling in Sampling::ALL {
        for u in [[0.3, 0.0, 0.5], [0.9, 0.5, 0.1]] {
            assert_eq!(open.sample(sampling, DVec3::X, u).weight, DVec3::ZERO, "{sampling:?}");
        }
    }
}
