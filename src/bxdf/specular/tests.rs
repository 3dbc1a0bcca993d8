//! The three smooth surfaces against each other, Snell's law and their means.

use super::*;
use crate::bxdf::{Bxdf, Flags, Sampling};
use crate::fresnel::{Fresnel, dielectric};
use crate::spectrum::Spectrum;

const WHITE: Spectrum = Spectrum::grey(1.0);
const MIRROR: Flags = Flags::REFLECTION.union(Flags::SPECULAR);
const REFRACTION: Flags = Flags::TRANSMISSION.union(Flags::SPECULAR);
const BOTH: Flags = Flags::REFLECTION.union(Flags::TRANSMISSION);
const PAIRS: [(f64, f64); 9] = [
    (1.0, 1.0),
    (1.0, 1.00029),
    (1.0, 1.5),
    (1.5, 1.0),
    (1.33, 1.5),
    (0.01, 100.0),
    (100.0, 0.01),
    (1.0, 100.0),
    (2.42, 1.0),
];
const COSINES: [f64; 8] = [0.0, 1e-300, 1e-160, 1e-9, 0.1, 0.6, 0.999_999_999, 1.0];

fn glass(eta_a: f64, eta_b: f64, transport: Transport) -> FresnelSpecular {
    FresnelSpecular::new(WHITE, WHITE, eta_a, eta_b, transport).unwrap()
}

fn pane(eta_a: f64, eta_b: f64, transport: Transport) -> SpecularTransmission {
    SpecularTransmission::new(WHITE, eta_a, eta_b, transport).unwrap()
}

/// Directions on both sides of the surface.
fn directions() -> impl Iterator<Item = DVec3> {
    COSINES.into_iter().enumerate().flat_map(|(i, cos)| {
        let above = Polar::from_cos(cos).direction(i as f64);
        [above, -above]
    })
}

#[test]
fn refraction_obeys_snell_and_stays_finite() {
    for (eta_a, eta_b) in PAIRS {
        let bxdf = pane(eta_a, eta_b, Transport::Importance);
        let interface = Interface::new(eta_a, eta_b, Transport::Importance).unwrap();
        for wo in directions() {
            let sample = bxdf.sample_f(wo, [0.5; 3]);
            let (near, far) = if wo.z < 0.0 { (eta_b, eta_a) } else { (eta_a, eta_b) };
            let sine = wo.x.hypot(wo.y);
            if sample.flags.is_empty() {
                // total internal reflection, exactly where the Fresnel term says so
                assert!(near * sine >= far * (1.0 - 4.0 * f64::EPSILON), "{eta_a} {eta_b} {wo}");
                assert_eq!(interface.reflectance(wo), 1.0);
                assert_eq!((sample.weight, sample.pdf), (DVec3::ZERO, 0.0));
                continue;
            }
            assert_eq!((sample.flags, sample.pdf), (REFRACTION, 1.0));
            assert_ne!(sample.wi.z < 0.0, wo.z < 0.0, "the other side");
            assert!((sample.wi.length() - 1.0).abs() < 4.0 * f64::EPSILON);
            let sine_t = sample.wi.x.hypot(sample.wi.y);
            assert!((near * sine - far * sine_t).abs() <= 4.0 * f64::EPSILON * near);
            assert!(
                sample.wi.x * wo.x <= 0.0 && sample.wi.y * wo.y <= 0.0,
                "in the plane of incidence"
            );
            assert!((0.0..=1.0).contains(&sample.weight.x));
        }
    }
}

#[test]
fn matched_indices_transmit_everything_straight_on() {
    for transport in [Transport::Radiance, Transport::Importance] {
        let (bxdf, both) = (pane(1.5, 1.5, transport), glass(1.5, 1.5, transport));
        for wo in directions() {
            let sample = bxdf.sample_f(wo, [0.0; 3]);
            assert_eq!((sample.weight, sample.pdf), (DVec3::ONE, 1.0));
            assert_eq!(sample.wi.truncate(), -wo.truncate());
            assert!((sample.wi.z + wo.z).abs() <= f64::MIN_POSITIVE);
            assert_eq!(both.sample_f(wo, [0.0; 3]), sample);
        }
        assert_eq!(both.rho_hh(Flags::REFLECTION).value, DVec3::ZERO);
        assert_eq!(both.rho_hd(Flags::TRANSMISSION, 0.0), DVec3::ONE);
    }
}

/// f is a delta in wi. Turned into one in wo, with cos_i eta_i^2 dwi = cos_o eta_o^2 dwo, f(wo, wi)/eta_o^2 is symmetric for
/// radiance when weight (eta_i/eta_o)^2 is; for importance the weights themselves are equal.
#[test]
fn the_same_light_crosses_both_ways() {
    for (eta_a, eta_b) in PAIRS {
        // the way back from grazing angles knows their cosine to 1e-8 only
        for wo in directions().filter(|wo| wo.z.abs() > 0.05) {
            for transport in [Transport::Radiance, Transport::Importance] {
                let bxdf = pane(eta_a, eta_b, transport);
                let there = bxdf.sample_f(wo, [0.5; 3]);
                if there.flags.is_empty() {
                    continue;
                }
                let back = bxdf.sample_f(there.wi, [0.5; 3]);
                let (near, far) = if wo.z < 0.0 { (eta_b, eta_a) } else { (eta_a, eta_b) };
                let ratio = match transport {
                    Transport::Radiance => far / near,
                    Transport::Importance => 1.0,
                };
                let (there, back) = (there.weight.x * ratio * ratio, back.weight.x / ratio / ratio);
                // a rounding of the cosine, 2e-16/0.1, times the slope 4 eta = 4e4 of the transmitted fraction
                assert!((there - back).abs() < 1e-9, "{eta_a} {eta_b} {wo}: {there} and {back}");
            }
        }
    }
    // away from the edge, to a few roundings
    let bxdf = pane(1.0, 1.5, Transport::Importance);
    for i in 1..=100 {
        let wo = Polar::from_cos(f64::from(i) / 100.0).direction(0.3);
        let there = bxdf.sample_f(wo, [0.5; 3]);
        let back = bxdf.sample_f(there.wi, [0.5; 3]);
        assert!((there.weight.x - back.weight.x).abs() < 1e-13);
        assert!((back.wi - wo).length() < 1e-13);
    }
}

#[test]
fn what_is_not_reflected_is_transmitted() {
    for (eta_a, eta_b) in PAIRS {
        let bxdf = glass(eta_a, eta_b, Transport::Importance);
        for wo in directions() {
            let fresnel = bxdf.sample_f(wo, [0.0; 3]);
            let fresnel = if fresnel.flags == MIRROR { fresnel.pdf } else { 0.0 };
            // both ends of what u decides
            for (u, reflected) in [(0.0, fresnel > 0.0), (0.999_999_999_999_999_9, fresnel >= 1.0)] {
                let sample = bxdf.sample_f(wo, [u, 0.5, 0.5]);
                assert_eq!(sample.flags, if reflected { MIRROR } else { REFRACTION });
                assert_eq!(sample.pdf, if reflected { fresnel } else { 1.0 - fresnel });
                assert_eq!(sample.weight, DVec3::ONE);
            }
            // each part alone has the weight that the other draws with
            let mirror = SpecularReflection::new(WHITE, Fresnel::dielectric(Spectrum::grey(1.5)).unwrap()).unwrap();
            if (eta_a, eta_b) == (1.0, 1.5) {
                let alone = mirror.sample_f(wo, [0.5; 3]).weight.x;
                assert!(
                    (alone - fresnel).abs() <= 4.0 * f64::EPSILON,
                    "{wo}: {alone} and {fresnel}"
                ); // 1/1.5 rounds
            }
            let alone = pane(eta_a, eta_b, Transport::Importance)
                .sample_f(wo, [0.5; 3])
                .weight
                .x;
            assert_eq!(alone, 1.0 - fresnel);
        }
    }
}

#[test]
fn closed_forms_are_what_samples_average_to() {
    let (r, t) = (Spectrum::rgb([0.2, 0.5, 1.0]), Spectrum::grey(0.7));
    for (eta_a, eta_b) in PAIRS {
        for transport in [Transport::Radiance, Transport::Importance] {
            let both = FresnelSpecular::new(r, t, eta_a, eta_b, transport).unwrap();
            let refraction = SpecularTransmission::new(t, eta_a, eta_b, transport).unwrap();
            for cos in COSINES {
                let wo = Polar::from_cos(cos).direction(0.4);
                let fresnel = dielectric(cos, eta_b / eta_a);
                let transmitted = refraction.rho_hd(Flags::TRANSMISSION, cos);
                // the direction and the cosine know the angle to some roundings, which an edge magnifies to half of them
                let sampled = refraction.sample_f(wo, [0.5; 3]).weight;
                let scale = transmitted.max_element().max(1.0);
                assert!((sampled - transmitted).abs().max_element() < 1e-7 * scale, "{cos}");
                let apart = (both.rho_hd(Flags::TRANSMISSION, cos) - transmitted).abs();
                assert!(apart.cmple(4.0 * f64::EPSILON * transmitted).all()); // four roundings
                assert_eq!(both.rho_hd(MIRROR, cos), r.value() * fresnel);
                let sum = both.rho_hd(Flags::REFLECTION, cos) + both.rho_hd(Flags::TRANSMISSION, cos);
                assert_eq!(both.rho_hd(BOTH, cos), sum);
                assert_eq!(refraction.rho_hd(Flags::REFLECTION, cos), DVec3::ZERO);
            }
            let (reflected, transmitted) = (both.rho_hh(Flags::REFLECTION), both.rho_hh(Flags::TRANSMISSION));
            let alone = refraction.rho_hh(Flags::TRANSMISSION);
            assert!((alone.value - transmitted.value).abs().cmple(alone.error).all());
            let sum = both.rho_hh(BOTH);
            let error = reflected.error + transmitted.error;
            assert!(
                (sum.value - reflected.value - transmitted.value)
                    .abs()
                    .cmple(error)
                    .all()
            );
            // some roundings more, where the parts state theirs by different formulae
            let roundings = (reflected.value + transmitted.value) * (8.0 * f64::EPSILON);
            assert!(sum.error.cmple(error + roundings).all());
            // the energy that crosses does so both ways: eta_a^2 (1 - F_bar) is that from the other side
            let reverse = SpecularTransmission::new(t, eta_b, eta_a, Transport::Importance).unwrap();
            let forth = SpecularTransmission::new(t, eta_a, eta_b, Transport::Importance).unwrap();
            let (forth, reverse) = (forth.rho_hh(Flags::TRANSMISSION), reverse.rho_hh(Flags::TRANSMISSION));
            let (a, b) = (eta_a * eta_a, eta_b * eta_b);
            let rounding = (a + b) * 8.0 * f64::EPSILON;
            assert!(
                (a * forth.value.x - b * reverse.value.x).abs() <= a * forth.error.x + b * reverse.error.x + rounding
            );
        }
    }
    let mirror = SpecularReflection::new(r, Fresnel::None).unwrap();
    assert_eq!(mirror.rho_hd(Flags::REFLECTION, 0.3), r.value());
    assert_eq!(mirror.rho_hh(Flags::REFLECTION).unwrap().value, r.value());
    assert_eq!(mirror.rho_hh(Flags::TRANSMISSION).unwrap().value, DVec3::ZERO);
    let metal = Fresnel::conductor(Spectrum::grey(0.769), Spectrum::grey(6.08)).unwrap();
    assert!(SpecularReflection::new(r, metal).unwrap().rho_hh(MIRROR).is_none());
}

#[test]
fn mirrors_reflect_on_both_sides_and_dielectrics_exchange_their_indices() {
    let water = Fresnel::dielectric(Spectrum::grey(1.329)).unwrap();
    let mirror = SpecularReflection::new(Spectrum::grey(0.5), water).unwrap();
    for wo in directions() {
        let sample = mirror.sample_f(wo, [0.5; 3]);
        assert_eq!(sample.wi, DVec3::new(-wo.x, -wo.y, wo.z));
        assert_eq!((sample.flags, sample.pdf), (MIRROR, 1.0));
        let eta = if wo.z < 0.0 { 1.0 / 1.329 } else { 1.329 };
        assert_eq!(sample.weight.x, 0.5 * dielectric_at(polar(wo), eta));
    }
    // beyond 48.8 degrees from below everything is reflected
    let wo = -Polar::from_angle(0.9).direction(0.0);
    assert_eq!(mirror.sample_f(wo, [0.5; 3]).weight.x, 0.5);
    let metal = Fresnel::conductor(Spectrum::grey(0.769), Spectrum::grey(6.08)).unwrap();
    let metal = SpecularReflection::new(WHITE, metal).unwrap();
    assert_eq!(
        metal.sample_f(wo, [0.5; 3]).weight,
        metal.sample_f(-wo, [0.5; 3]).weight
    );
}

#[test]
fn deltas_are_seen_by_sampling_alone() {
    let glass = glass(1.0, 1.5, Transport::Importance);
    let wo = Polar::from_angle(0.7).direction(0.1);
    for wi in [wo, -wo, mirrored(wo), glass.sample_f(wo, [0.9; 3]).wi] {
        assert_eq!((glass.f(wo, wi), glass.pdf(wo, wi)), (DVec3::ZERO, 0.0));
    }
    assert!(glass.supports(Sampling::Bxdf) && !glass.supports(Sampling::Cosine));
    assert_eq!(glass.flags(), MIRROR | REFRACTION);
}

#[test]
fn parameters_are_refused_with_their_range() {
    let error = |a, b| {
        SpecularTransmission::new(WHITE, a, b, Transport::default())
            .unwrap_err()
            .to_string()
    };
    assert_eq!(error(0.0, 1.0), "eta_a = 0 is not allowed: eta_a lies in [0.01, 100]");
    assert_eq!(
        error(1.0, 101.0),
        "eta_b = 101 is not allowed: eta_b lies in [0.01, 100]"
    );
    let bright = SpecularTransmission::new(Spectrum::grey(1.5), 1.0, 1.5, Transport::Radiance).unwrap_err();
    assert_eq!(
        bright.to_string(),
        "transmittance = 1.5 is not allowed: transmittance lies in [0, 1]"
    );
    assert!(FresnelSpecular::new(WHITE, WHITE, f64::NAN, 1.5, Transport::Radiance).is_err());
    assert!(SpecularReflection::new(Spectrum::grey(-0.1), Fresnel::None).is_err());
    assert_eq!(Transport::from_name("radiance"), Some(Transport::Radiance));
    assert_eq!(
        Transport::from_name(Transport::default().name()),
        Some(Transport::Importance)
    );
    assert_eq!(Transport::from_name("photons"), None);
}
