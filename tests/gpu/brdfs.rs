//! BRDFs of the library in f32 against those of the program in f64, at the same rounded directions.

use crate::device::gpu;
use glam::DVec3;
use whitefurnace::bxdf::{Bxdf, Microfacet};
use whitefurnace::distribution::Family;
use whitefurnace::fresnel::Fresnel;
use whitefurnace::geometry::{Polar, half_vector};
use whitefurnace::masking::Masking;
use whitefurnace::numerics::stream::{Stream, StreamId};
use whitefurnace::shader::LIBRARY;
use whitefurnace::spectrum::Spectrum;

/// Families in the order of the shader, with roughnesses from narrow to wide.
const FAMILIES: [(Family, [f64; 2]); 5] = [
    (Family::Ggx, [1e-4, 2.0]),
    (Family::Beckmann, [1e-4, 2.0]),
    (Family::Vmf, [1e-3, 1e7]),
    (Family::Phong, [1e-3, 1e7]),
    (Family::Charlie, [0.05, 1.0]),
];

struct Case {
    numbers: Vec<f32>,
    expected: DVec3,
    /// What the lobe would be with a Fresnel term of 1: cancellation within that is measured by it.
    whole: f64,
    /// The exponent of the distribution, which multiplies the rounding of its argument.
    exponent: f64,
    what: String,
}

fn stream(cell: u64) -> Stream {
    Stream::new(StreamId {
        seed: 11,
        cell,
        batch: 0,
    })
}

fn rounded(value: f64) -> f64 {
    f64::from(value as f32)
}

fn case(stream: &mut Stream, number: usize) -> Case {
    let mut between = |from: f64, to: f64| from + (to - from) * stream.uniform();
    let index = number % 5;
    let (family, [low, high]) = FAMILIES[index];
    let roughness = rounded((between(low.ln(), high.ln())).exp());
    let masking_index = match family {
        Family::Ggx | Family::Beckmann => number / 5 % 5,
        Family::Vmf | Family::Phong => [0, 1, 4][number / 5 % 3],
        Family::Charlie => 4,
    };
    // half of the directions mirror each other but for a facet of the lobe's width: there the lobe is
    let theta_o = between(0.0, 1.55);
    let wo = Polar::from_angle(theta_o).direction(between(0.0, std::f64::consts::TAU));
    let wi = match number % 2 {
        0 if family != Family::Charlie => {
            let h = family
                .with(roughness)
                .unwrap()
                .sample([between(0.0, 0.999), between(0.0, 1.0)]);
            2.0 * wo.dot(h) * h - wo
        }
        _ => Polar::from_angle(between(0.0, 1.55)).direction(between(0.0, std::f64::consts::TAU)),
    };
    let [wo, wi] = [wo, wi].map(|w| DVec3::from_array(w.to_array().map(rounded)));
    let mut colour = |from: f64, to: f64| [0; 3].map(|_| rounded(between(from, to)));
    let (eta, k, reflectance) = (colour(1.05, 3.0), colour(0.5, 8.0), colour(0.1, 1.0));
    let fresnel_index = number / 25 % 5;
    let (eta_s, k_s) = (Spectrum::rgb(eta), Spectrum::rgb(k));
    let eta = if fresnel_index == 3 { reflectance } else { eta };
    let fresnel = match fresnel_index {
        0 => Fresnel::None,
        1 => Fresnel::dielectric(eta_s).unwrap(),
        2 => Fresnel::conductor(eta_s, k_s).unwrap(),
        3 => Fresnel::schlick(Spectrum::rgb(eta)).unwrap(),
        _ => Fresnel::conductor_approximate(eta_s, k_s).unwrap(),
    };
    let half = half_vector(wo, wi).filter(|_| wo.z >= 0.0 && wi.z >= 0.0);
    let theta = half.map_or(Polar::POLE, |half| Polar::of(half.wh));
    let smooth = |d: f64| match half {
        Some(_) => d / (4.0 * (wo.z + wi.z - wo.z * wi.z)),
        None => 0.0,
    };
    let scale = DVec3::from_array(reflectance);
    let factor = |lobe: f64| half.map_or(DVec3::ZERO, |half| scale * fresnel.reflectance(half.cos_d) * lobe);
    let (expected, whole) = match masking_index {
        // the smooth visibility of sheen, of any distribution
        4 => {
            let lobe = smooth(family.with(roughness).unwrap().d(theta));
            (factor(lobe), lobe)
        }
        masking => {
            let masking = [
                Masking::None,
                Masking::VGroove,
                Masking::Smith,
                Masking::SmithCorrelated,
            ][masking];
            let distribution = family.with(roughness).unwrap();
            let lobe = |reflectance, fresnel| Microfacet::new(reflectance, distribution, masking, fresnel).unwrap();
            let value = lobe(Spectrum::rgb(reflectance), fresnel).f(wo, wi);
            (value, lobe(Spectrum::grey(1.0), Fresnel::None).f(wo, wi).x)
        }
    };
    let exponent = match family {
        Family::Ggx => 0.0,
        Family::Beckmann => (theta.tan() / roughness).powi(2),
        Family::Vmf => roughness * theta.versine(),
        Family::Phong => -(roughness + 2.0) * theta.ln_cos(),
        Family::Charlie => -theta.sin.ln() / roughness,
    };
    let header = [index, masking_index, fresnel_index].map(|number| number as f32);
    let numbers: Vec<f32> = header
        .into_iter()
        .chain([roughness as f32])
        .chain(reflectance.into_iter().chain(eta).chain(k).map(|value| value as f32))
        .chain(wo.to_array().into_iter().chain(wi.to_array()).map(|value| value as f32))
        .collect();
    Case {
        numbers,
        expected,
        whole,
        exponent,
        what: format!("family {index}, masking {masking_index}, fresnel {fresnel_index}, {roughness}, {wo}, {wi}"),
    }
}

#[test]
fn brdfs_are_those_of_the_program() {
    let Some(gpu) = gpu() else { return };
    let mut stream = stream(0);
    let count = 200_000;
    let cases: Vec<Case> = (0..count).map(|number| case(&mut stream, number)).collect();
    let inputs: Vec<f32> = cases.iter().flat_map(|case| case.numbers.iter().copied()).collect();
    let body = "let at = 19u * i;
    let lobe = FurnaceLobe(u32(inputs[at]), u32(inputs[at + 1u]), u32(inputs[at + 2u]), inputs[at + 3u],
        vec3f(inputs[at + 4u], inputs[at + 5u], inputs[at + 6u]),
        vec3f(inputs[at + 7u], inputs[at + 8u], inputs[at + 9u]),
        vec3f(inputs[at + 10u], inputs[at + 11u], inputs[at + 12u]));
    let wo = vec3f(inputs[at + 13u], inputs[at + 14u], inputs[at + 15u]);
    let wi = vec3f(inputs[at + 16u], inputs[at + 17u], inputs[at + 18u]);
    let f = furnace_f(lobe, wo, wi);
    outputs[3u * i] = f.x; outputs[3u * i + 1u] = f.y; outputs[3u * i + 2u] = f.z;";
    let found = gpu.run(LIBRARY, body, &[], &inputs, (count, 3 * count));
    let (mut worst, mut lit) = ((0.0, String::new()), [0usize; 5]);
    for (number, case) in cases.iter().enumerate() {
        for channel in 0..3 {
            let (found, expected) = (f64::from(found[3 * number + channel]), case.expected[channel]);
            assert!(found.is_finite(), "{}: {found}", case.what);
            // some thirty roundings of 6e-8; the exponent multiplies four of its argument and two of itself, and exponentials
            // are off by 2^-23 of it
            let allowed = case.whole * (2e-6 + 6e-7 * case.exponent) + 1e-36;
            // e^-87 is the smallest normal number, and smaller ones may be 0
            if case.exponent > 86.0 {
                assert!(
                    (0.0..=1.1 * expected).contains(&found),
                    "{}: {found:e} and {expected:e}",
                    case.what
                );
                continue;
            }
            let off = (found - expected).abs();
            if off / allowed > worst.0 {
                worst = (off / allowed, format!("{}: {found:e} and {expected:e}", case.what));
            }
        }
        lit[number % 5] += usize::from(case.expected.x > 1e-3);
    }
    println!("largest share of the tolerance {}: {}", worst.0, worst.1);
    assert!(worst.0 <= 1.0, "{} of the tolerance: {}", worst.0, worst.1);
    // the lobes were met, and not only their feet
    assert!(lit.iter().all(|lit| *lit > count / 50), "{lit:?}");
}

/// Also from the denser side, where light is reflected totally, and where extinction takes the place of that.
#[test]
fn fresnel_terms_are_those_of_the_program() {
    let Some(gpu) = gpu() else { return };
    let mut stream = stream(1);
    let count = 100_000;
    let mut inputs = Vec::new();
    let mut expected = Vec::new();
    for number in 0..count {
        let cos = rounded(stream.uniform());
        let eta = rounded(0.3 * 33f64.powf(stream.uniform()));
        let k = rounded(5.0 * stream.uniform().powi(3));
        let term = [1, 2, 4][number % 3];
        let (eta_s, k_s) = (Spectrum::grey(eta), Spectrum::grey(k));
        let fresnel = match term {
            1 => Fresnel::dielectric(eta_s),
            2 => Fresnel::conductor(eta_s, k_s),
            _ => Fresnel::conductor_approximate(eta_s, k_s),
        };
        let beyond = eta * eta - 1.0 + cos * cos;
        // g, the root of what is beyond the edge of total reflection, is off by 1e-7/(2 g), and F varies with g by up to
        // 4/(eta^2 cos): at its edge, and where an extinction rounds that, f32 holds some digits less
        let allowed = if eta < 1.0 {
            1e-6 + 2.5e-6 / beyond.abs().sqrt().max(1e-3)
        } else {
            5e-6
        };
        expected.push((fresnel.unwrap().reflectance(cos).x, allowed));
        inputs.extend([term as f32, eta as f32, k as f32, cos as f32]);
    }
    let body = "let at = 4u * i;
    let lobe = FurnaceLobe(0u, 0u, u32(inputs[at]), 1.0, vec3f(1.0), vec3f(inputs[at + 1u]), vec3f(inputs[at + 2u]));
    outputs[i] = furnace_fresnel(lobe, inputs[at + 3u]).y;";
    let found = gpu.run(LIBRARY, body, &[], &inputs, (count, count));
    let mut worst = (0.0, 0);
    for (number, (found, (expected, allowed))) in found.iter().zip(&expected).enumerate() {
        let share = (f64::from(*found) - expected).abs() / allowed;
        assert!(found.is_finite());
        if share > worst.0 {
            worst = (share, number);
        }
    }
    let (case, value) = (&inputs[4 * worst.1..4 * worst.1 + 4], found[worst.1]);
    println!("largest share of the tolerance {}: {case:?}", worst.0);
    assert!(worst.0 <= 1.0, "{case:?}: {value} and {:?}", expected[worst.1]);
}
