//! Rough interfaces of dielectrics: the lobe against what it stands for, with refraction at both sides.

use glam::DVec3;
use whitefurnace::bxdf::{Bxdf, Media, ModelError, RoughDielectric, Transport};
use whitefurnace::distribution::Family;
use whitefurnace::geometry::Polar;
use whitefurnace::masking::Masking;
use whitefurnace::numerics::stream::{Stream, StreamId};
use whitefurnace::spectrum::Spectrum;
use whitefurnace::verify::reciprocity::reciprocity;
use whitefurnace::verify::sampling::sampling;
use whitefurnace::verify::{Evidence, Settings, Source, TransmissionRule};

fn glass(family: Family, alpha: f64, masking: Masking, eta_b: f64, transport: Transport) -> RoughDielectric {
    let media = Media {
        eta_a: 1.0,
        eta_b,
        transport,
    };
    let white = Spectrum::grey(1.0);
    RoughDielectric::new(white, white, family.with(alpha).unwrap(), masking, media).unwrap()
}

fn all() -> Vec<RoughDielectric> {
    let mut all = Vec::new();
    for family in [Family::Ggx, Family::Beckmann] {
        for masking in [Masking::Smith, Masking::SmithCorrelated] {
            for (alpha, eta) in [(0.3, 1.5), (0.05, 1.00029), (1.0, 0.6), (0.6, 2.42)] {
                all.push(glass(family, alpha, masking, eta, Transport::Importance));
            }
        }
    }
    all
}

/// Samples follow their density, weights are f cos/pdf, and their mean is the albedo of uniform samples.
#[test]
fn samplers_pass_their_trial() {
    for glass in all().into_iter().step_by(3) {
        let outcomes = sampling(&glass, None, true, &Settings::quick(4), Source::new(4, "rough"));
        for outcome in outcomes {
            let holds = match outcome.evidence {
                Evidence::Chance(p) => p > 1e-5,
                Evidence::Certain(holds) => holds,
                // cosine samples, against which the mean is held, hardly ever meet it
                Evidence::Skipped(_) => glass.eta_b() == 1.00029,
            };
            assert!(holds, "{glass:?}: {outcome:?}");
        }
    }
}

#[test]
fn light_runs_the_same_way_back() {
    for glass in all() {
        let rule = TransmissionRule::Refracted {
            eta_above: glass.eta_a(),
            eta_below: glass.eta_b(),
        };
        let found = reciprocity(&glass, rule, &Settings::quick(2), Source::new(2, "rough"));
        assert_eq!(found.evidence, Evidence::Certain(true), "{glass:?}: {found:?}");
        let plain = reciprocity(
            &glass,
            TransmissionRule::Plain,
            &Settings::quick(2),
            Source::new(2, "rough"),
        );
        assert_eq!(plain.evidence, Evidence::Certain(false), "{glass:?}: {plain:?}");
    }
}

/// Walter's own form of eq. 21, with eta_o^2 and both indices, is radiance transport but for (eta_o/eta_i)^2.
#[test]
fn eq_21_in_its_own_terms() {
    let (eta_o, eta_i, alpha) = (1.0, 1.5, 0.4);
    let glass = glass(Family::Ggx, alpha, Masking::Smith, eta_i, Transport::Radiance);
    let wo = Polar::from_cos(0.7).direction(0.2);
    let wi = Polar::from_cos(0.8).direction(3.0);
    let wi = DVec3::new(wi.x, wi.y, -wi.z);
    let h = -(eta_i * wi + eta_o * wo).normalize();
    let (oh, ih) = (wo.dot(h), wi.dot(h));
    let sin_h2 = 1.0 - h.z * h.z;
    let d = (alpha / (alpha * alpha * h.z * h.z + sin_h2)).powi(2) / std::f64::consts::PI;
    let g1 = |cos: f64| 2.0 / (1.0 + (1.0 + alpha * alpha * (1.0 - cos * cos) / (cos * cos)).sqrt());
    let passes = 1.0 - whitefurnace::fresnel::dielectric(oh, eta_i / eta_o);
    let jacobian = eta_o * eta_o / (eta_i * ih + eta_o * oh).powi(2);
    let expected = (oh * ih / (wo.z * wi.z)).abs() * jacobian * passes * g1(wo.z) * g1(-wi.z) * d;
    let found = glass.f(wo, wi).x;
    assert!((found / expected - 1.0).abs() < 1e-12, "{found} {expected}"); // some hundred roundings
}

/// Nothing is lost but what masking takes, from either side: weights are at most 1 and the lobe is finite everywhere.
#[test]
fn extreme_directions_and_indices_stay_finite() {
    let mut random = Stream::new(StreamId {
        seed: 3,
        cell: 0,
        batch: 0,
    });
    for family in [Family::Ggx, Family::Beckmann] {
        for alpha in [1e-6, 0.01, 1.0, 10.0] {
            for eta in [0.01, 0.6, 1.0 / 1.00029, 1.000002, 1.00029, 1.5, 100.0] {
                let glass = glass(family, alpha, Masking::SmithCorrelated, eta, Transport::Importance);
                for mu in [0.0, 1e-300, 1e-9, 0.3, 1.0] {
                    for turned in [false, true] {
                        let above = Polar::from_cos(mu).direction(1.0);
                        let wo = if turned { -above } else { above };
                        for _ in 0..20 {
                            let draw = glass.sample_f(wo, random.uniform3());
                            assert!(
                                draw.weight.is_finite() && draw.weight.x <= 1.0 + 1e-12,
                                "{glass:?} {wo}: {draw:?}"
                            );
                            assert!(draw.pdf.is_finite() && draw.pdf >= 0.0, "{glass:?} {wo}: {draw:?}");
                            let f = glass.f(wo, draw.wi);
                            assert!(f.is_finite() && f.x >= 0.0, "{glass:?} {wo}: {draw:?} {f}");
                            assert!(glass.pdf(wo, draw.wi).is_finite());
                        }
                    }
                }
            }
        }
    }
}

#[test]
fn what_makes_no_rough_interface_is_refused() {
    let media = |eta_a, eta_b| Media {
        eta_a,
        eta_b,
        transport: Transport::Importance,
    };
    let (white, ggx) = (Spectrum::grey(1.0), Family::Ggx.with(0.1).unwrap());
    let made = |lobe, masking, media| RoughDielectric::new(white, white, lobe, masking, media);
    for (a, b) in [(1.5, 1.5), (1.0, 1.0 + 1e-7)] {
        let error = made(ggx, Masking::Smith, media(a, b)).unwrap_err();
        assert!(matches!(error, ModelError::NoBend { .. }), "{error}");
    }
    assert!(made(ggx, Masking::Smith, media(1.0, 1.00029)).is_ok());
    let error = made(ggx, Masking::None, media(1.0, 1.5)).unwrap_err();
    assert!(matches!(error, ModelError::NeedsSmith { masking: "none" }), "{error}");
    let error = made(Family::Vmf.with(9.0).unwrap(), Masking::Smith, media(1.0, 1.5)).unwrap_err();
    assert!(matches!(error, ModelError::SmithNeedsSlopes { .. }), "{error}");
    for bad in [0.0, f64::NAN, 101.0] {
        assert!(matches!(
            made(ggx, Masking::Smith, media(1.0, bad)),
            Err(ModelError::Parameter(_))
        ));
    }
}
