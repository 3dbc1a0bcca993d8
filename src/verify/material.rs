//! All tests of one material.

use super::energy::{energy, sampled_energy};
use super::furnace::{loss, white_furnace};
use super::normalisation::{normals, visible_normals};
use super::reciprocity::{reciprocity, reciprocity_of_deltas};
use super::sampling::sampling;
use super::{Check, Evidence, Facts, Outcome, Settings, Source, Test, facts, fresnel, known_departure};
use crate::bxdf::{Bxdf, DiffuseSpecular, Flags, Model};
use crate::estimate::{Effort, ErrorKind, Estimate, Estimator, Lobe};
use crate::geometry::Polar;
use crate::integrate::{IntegrateError, Integrator, Target, sampled};
use crate::scene::{Material, ModelSpec};
use glam::{DMat3, DVec3};
use std::f64::consts::{FRAC_PI_2, TAU};
use std::fmt;

/// rho_hd of both sides together, from above, at cos theta_o = mu and azimuth phi in radians, computed deterministically.
pub type Stated<'a> = dyn Fn(f64, f64) -> Result<Estimate, IntegrateError> + Sync + 'a;

/// A model under test with what is known of it.
pub struct Subject<'a> {
    /// Its name; random streams depend on it.
    pub name: String,
    /// The model.
    pub bxdf: &'a dyn Bxdf,
    /// Its albedo, where that is computed deterministically.
    pub stated: Option<&'a Stated<'a>>,
    /// The model and its albedo as energy is accounted, without the scaling of radiance by refraction, where that differs.
    pub accounted: Option<(&'a dyn Bxdf, Option<&'a Stated<'a>>)>,
    /// What else is known.
    pub facts: Facts<'a>,
    /// Its parameters by their scene-file names, for known departures.
    pub parameters: Vec<(String, String)>,
}

impl Subject<'_> {
    fn check(&self, outcome: Outcome) -> Check {
        Check {
            departure: known_departure(&self.parameters, outcome.test),
            subject: self.name.clone(),
            outcome,
        }
    }
}

/// All tests that apply to `subject`.
pub fn verify_bxdf(subject: &Subject<'_>, settings: &Settings) -> Vec<Check> {
    let source = Source::new(settings.seed, &subject.name);
    let isotropic = is_isotropic(subject.bxdf, source);
    let Subject {
        bxdf, stated, facts, ..
    } = subject;
    let bxdf = *bxdf;
    let transmits = bxdf.flags().contains(Flags::TRANSMISSION);
    let (accounted, accounted_albedo) = subject.accounted.unwrap_or((bxdf, *stated));
    let mut outcomes = vec![match accounted_albedo {
        Some(stated) => energy(stated, isotropic),
        None => sampled_energy(accounted, false, isotropic, settings, source),
    }];
    if transmits {
        outcomes.push(sampled_energy(accounted, true, isotropic, settings, source));
    }
    if let Some(coupled) = facts.coupled {
        outcomes.push(match stated {
            None => Outcome::skipped(Test::WhiteFurnace, "its albedo is only known from samples"),
            Some(stated) => white_furnace(bxdf, stated, settings, source)
                .map(|outcome| outcome.noted(loss(coupled).ok().map(|loss| loss.to_string())))
                .unwrap_or_else(|error| Outcome::skipped(Test::WhiteFurnace, error)),
        });
    }
    outcomes.push(reciprocity(bxdf, facts.transmission, settings, source));
    if bxdf.flags().contains(Flags::SPECULAR) {
        outcomes.push(reciprocity_of_deltas(bxdf, facts.transmission, source));
    }
    outcomes.extend(sampling(bxdf, *stated, isotropic, settings, source));
    outcomes.extend(facts_outcomes(facts));
    outcomes.into_iter().map(|outcome| subject.check(outcome)).collect()
}

/// Tests of what a model is made of.
fn facts_outcomes(facts: &Facts<'_>) -> Vec<Outcome> {
    let mut outcomes = Vec::new();
    for found in &facts.normals {
        outcomes.push(normals(&found.all));
        outcomes.push(match &found.visible {
            Ok(visible) => visible_normals(visible),
            Err(reason) => Outcome::skipped(Test::VisibleNormals, reason),
        });
    }
    for [approximate, exact] in &facts.approximations {
        outcomes.push(fresnel::compare(*approximate, *exact));
    }
    outcomes
}

/// Largest error of stated albedos: below what samples resolve, and dear for anisotropic models.
const TOLERANCE: f64 = 1e-7;
const ANISOTROPIC_TOLERANCE: f64 = 1e-5;

/// All tests of a material of a scene: at both ends of its roughness range, where it has one.
pub fn verify_material(material: &Material, settings: &Settings) -> Vec<Check> {
    let Some((family, min, max)) = material.model.roughness_range() else {
        return verify_at(material, None, material.name.clone(), settings);
    };
    let at = |roughness: f64| {
        let name = format!("{} ({} = {roughness})", material.name, family.legal().name);
        verify_at(material, Some(roughness), name, settings)
    };
    [at(min), at(max)].concat()
}

fn verify_at(material: &Material, roughness: Option<f64>, name: String, settings: &Settings) -> Vec<Check> {
    // what needs samples
    let skipped = |reason: &dyn fmt::Display| {
        let tests = [
            Test::WhiteFurnace,
            Test::Reciprocity,
            Test::Density,
            Test::Directions,
            Test::Weights,
            Test::Albedo,
        ];
        let furnace = matches!(material.model, ModelSpec::DiffuseSpecular { .. });
        let check = |test: Test| Check {
            subject: name.clone(),
            outcome: Outcome::skipped(test, reason),
            departure: None,
        };
        let applies = |test: &Test| furnace || *test != Test::WhiteFurnace;
        tests.into_iter().filter(applies).map(check).collect::<Vec<_>>()
    };
    let model = match material.model.at(roughness) {
        Ok(model) => model,
        Err(error) => return skipped(&error),
    };
    let parameters = material.model.describe();
    let facts = facts(&model);
    let bxdf = sampled(&model);
    let isotropic = bxdf
        .as_ref()
        .is_ok_and(|bxdf| is_isotropic(bxdf.as_ref(), Source::new(settings.seed, &name)));
    let effort = Effort {
        tolerance: if isotropic { TOLERANCE } else { ANISOTROPIC_TOLERANCE },
        samples: None,
        seed: settings.seed,
    };
    let integrator = Integrator::new(&model, Estimator::Auto, effort);
    let both = |mu: f64, phi: f64| both_sides(&integrator, &model, mu, phi);
    // an estimator that draws samples is no independent judge of samples
    let deterministic = !model.is_irregular() && both(0.5, 0.0).is_ok_and(|estimate| estimate.kind != ErrorKind::Ci99);
    let accounted = Some(model.accounted()).filter(|accounted| *accounted != model);
    let accounted_bxdf = accounted.as_ref().map(sampled);
    let accounted_integrator = accounted
        .as_ref()
        .map(|model| Integrator::new(model, Estimator::Auto, effort));
    let accounted_both = |mu: f64, phi: f64| match (&accounted_integrator, &accounted) {
        (Some(integrator), Some(model)) => both_sides(integrator, model, mu, phi),
        _ => both(mu, phi),
    };
    match bxdf {
        Ok(bxdf) => {
            let subject = Subject {
                name,
                bxdf: bxdf.as_ref(),
                stated: deterministic.then_some(&both as &Stated<'_>),
                accounted: match &accounted_bxdf {
                    Some(Ok(bxdf)) => Some((bxdf.as_ref(), deterministic.then_some(&accounted_both as &Stated<'_>))),
                    _ => None,
                },
                facts,
                parameters,
            };
            let mut checks = verify_bxdf(&subject, settings);
            let lobe = subject.facts.coupled.filter(|_| deterministic);
            checks.extend(
                lobe.and_then(|coupled| lobe_energy(coupled, effort, isotropic))
                    .map(|outcome| subject.check(outcome)),
            );
            checks
        }
        // what needs no samples is tested all the same
        Err(error) => {
            let mut outcomes = Vec::new();
            if deterministic {
                outcomes.push(energy(&both, isotropic));
            }
            outcomes.extend(facts_outcomes(&facts));
            let checks = outcomes.into_iter().map(|outcome| Check {
                departure: known_departure(&parameters, outcome.test),
                subject: name.clone(),
                outcome,
            });
            checks.chain(skipped(&error)).collect()
        }
    }
}

/// The energy of the specular lobe of a coupling alone, when that exceeds 1: the whole does not show it, because the base
/// turns negative where more is spent than there is.
fn lobe_energy(coupled: &DiffuseSpecular, effort: Effort, isotropic: bool) -> Option<Outcome> {
    let lobe = coupled.specular();
    let integrator = Integrator::new(lobe, Estimator::Auto, effort);
    let outcome = energy(&|mu, phi| both_sides(&integrator, lobe, mu, phi), isotropic);
    let exceeds = matches!(outcome.evidence, Evidence::Certain(false));
    let note = format!("the specular lobe alone: {}", outcome.note.clone().unwrap_or_default());
    exceeds.then(|| outcome.noted(note))
}

/// rho_hd of both sides together.
fn both_sides(
    integrator: &Result<Integrator<'_>, IntegrateError>,
    model: &Model,
    mu: f64,
    phi: f64,
) -> Result<Estimate, IntegrateError> {
    let integrator = integrator.as_ref().map_err(Clone::clone)?;
    let mut sum: Option<Estimate> = None;
    for lobe in Lobe::ALL.into_iter().filter(|lobe| model.flags().contains(lobe.flag())) {
        let part = integrator.estimate(Target::rho_hd(mu, phi).of(lobe), 0)?;
        sum = Some(match sum {
            None => part,
            Some(sum) => Estimate {
                value: sum.value + part.value,
                error: sum.error + part.error,
                kind: sum.kind.max(part.kind),
                evaluations: sum.evaluations + part.evaluations,
                ..sum
            },
        });
    }
    sum.ok_or(IntegrateError::Unsupported {
        estimator: Estimator::Auto,
        reason: "it scatters to neither side",
    })
}

/// Whether f keeps its value when both directions are turned about the normal, over directions drawn from the lobe.
pub(super) fn is_isotropic(bxdf: &dyn Bxdf, source: Source) -> bool {
    let mut stream = source.part("isotropy").stream(0);
    let quarter = |w: DVec3| DVec3::new(-w.y, w.x, w.z);
    let mut turned = 0;
    for _ in 0..PROBES {
        let u = stream.uniform3();
        let wo = Polar::from_angle(FRAC_PI_2 * u[0]).direction(TAU * u[1]);
        let wi = bxdf.sample_f(wo, stream.uniform3()).wi;
        let turn = DMat3::from_rotation_z(TAU * u[2]);
        let f = bxdf.f(wo, wi);
        let differs = |other: DVec3| super::reciprocity::difference(f, other) > TURNED;
        // a quarter turn is exact; any other rounds
        if differs(bxdf.f(quarter(wo), quarter(wi))) || differs(bxdf.f(turn * wo, turn * wi)) {
            turned += 1;
        }
    }
    turned <= PROBES / 16
}

/// Pairs that are turned; data that is looked up may jump at some of them.
const PROBES: usize = 64;

/// Relative change of f that rounding of directions does not explain for the narrowest lobes: 1e-16 over 1e-6, some digits
/// in an exponent.
const TURNED: f64 = 1e-6;
