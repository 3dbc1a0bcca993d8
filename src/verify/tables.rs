//! Baked tables against the scene that they claim to belong to, and against fresh integrals.
//!
//! A table is compared by both kinds of integration: deterministically at a tenth of its tolerance, which no falsified texel
//! survives, and by Monte Carlo of the model's own f, which shares nothing with quadrature. Damage of one file is a failed
//! check that names it, and the other files are still tested; a directory without a readable manifest is an error.

use super::sampling::{FAR_OUT, Z99};
use super::statistics::{Spread, channels_p, common_sign, score, smallest};
use super::{Check, Outcome, Place, Settings, Source, Statistic, Test};
use crate::bxdf::{Bxdf, Model, Sampling};
use crate::estimate::{Effort, ErrorKind, Estimate, Estimator};
use crate::export::ExportError;
use crate::export::manifest::{self, Manifest, TableEntry};
use crate::export::read::{Contents, read_exr};
use crate::integrate::{Coordinates, IntegrateError, Integrator, Target, sampled};
use crate::plan::{Economy, Plan, Request, TablePlan};
use crate::scene::{Material, Scene};
use crate::table::Table;
use crate::table::axis::Axis;
use glam::DVec3;
use rayon::prelude::*;
use std::collections::{HashMap, HashSet};
use std::path::Path;

/// Share of the tolerance of a table to which its texels are integrated again.
const FINER: f64 = 0.1;

/// Texels that are compared deterministically for each that is compared by Monte Carlo, which costs more.
const CHEAPER: usize = 16;

/// Places at which lookups are compared.
const PLACES: usize = 64;

/// Tests the tables in `directory` that belong to `materials` of `scene`.
///
/// # Errors
/// [`ExportError`] when the manifest is missing, damaged, or of a later layout.
pub fn verify_tables(
    scene: &Scene,
    materials: &[&Material],
    directory: &Path,
    settings: &Settings,
) -> Result<Vec<Check>, ExportError> {
    let manifest = Manifest::read(&directory.join(manifest::FILE_NAME))?;
    let wanted: HashSet<&str> = materials.iter().map(|material| material.name.as_str()).collect();
    let selected = |names: &[String]| names.iter().any(|name| wanted.contains(name.as_str()));
    let all: HashSet<&str> = scene.materials.iter().map(|material| material.name.as_str()).collect();
    let request = Request {
        resolution: 2,
        roughness_resolution: 2,
        mapping: None,
        estimator: Estimator::Auto,
        azimuth_resolution: 2,
        tolerance: None,
        samples: None,
        economy: if manifest.all_effects {
            Economy::NONE
        } else {
            Economy::FULL
        },
        seed: settings.seed,
    };
    // two texels are legal along every axis
    let plans = Plan::new(scene, &request).map_or_else(|_| Vec::new(), |plan| plan.tables);
    let listed: HashSet<&str> = manifest.tables.iter().map(|entry| entry.id.as_str()).collect();
    let missing = |plan: &&TablePlan| selected(&plan.materials) && !listed.contains(plan.id.as_str());
    let absent = plans.iter().filter(missing).map(|plan| {
        failed(
            &plan.id,
            "the scene calls for it, and the manifest does not list it".into(),
        )
    });
    let known = |entry: &&TableEntry| {
        let of_scene = entry.materials.iter().any(|name| all.contains(name.as_str()));
        selected(&entry.materials) || !of_scene
    };
    let by_id: HashMap<&str, &TablePlan> = plans.iter().map(|plan| (plan.id.as_str(), plan)).collect();
    let entries: Vec<&TableEntry> = manifest.tables.iter().filter(known).collect();
    let checks: Vec<Vec<Check>> = entries
        .par_iter()
        .map(|entry| match by_id.get(entry.id.as_str()) {
            Some(plan) => verify_entry(entry, plan, directory, settings),
            None => {
                let names = entry.materials.join(", ");
                vec![failed(
                    &entry.id,
                    format!("the scene does not call for it; its materials are {names}"),
                )]
            }
        })
        .collect();
    Ok(checks.into_iter().flatten().chain(absent).collect())
}

fn failed(id: &str, reason: String) -> Check {
    contents(id, vec![reason])
}

/// The check of what a table says of itself, by the differences that were found.
fn contents(id: &str, differences: Vec<String>) -> Check {
    let statistic = Statistic::new("differences", differences.len() as f64);
    let outcome = Outcome::certain(Test::TableContents, statistic, differences.is_empty());
    Check {
        subject: format!("table {id}"),
        outcome: outcome.noted((!differences.is_empty()).then(|| differences.join("; "))),
        departure: None,
    }
}

fn verify_entry(entry: &TableEntry, plan: &TablePlan, directory: &Path, settings: &Settings) -> Vec<Check> {
    if Path::new(&entry.file).file_name() != Some(entry.file.as_ref()) {
        return vec![failed(
            &entry.id,
            format!("{:?} is no name of a file beside the manifest", entry.file),
        )];
    }
    let file = match read_exr(&directory.join(&entry.file)) {
        Ok(file) => file,
        Err(error) => {
            let cause = std::error::Error::source(&error).map_or_else(String::new, |cause| format!(": {cause}"));
            return vec![failed(&entry.id, format!("{error}{cause}"))];
        }
    };
    let mut differences = Vec::new();
    if file.sha256 != entry.sha256 {
        differences.push(format!(
            "{} is not the file that was written: its content hash differs from the manifest",
            entry.file
        ));
    }
    let Contents::Table { table, .. } = file.contents else {
        differences.push(format!("{} has no attributes of this program", entry.file));
        return vec![contents(&entry.id, differences)];
    };
    let stated = TableEntry::new(
        &table,
        entry.file.clone(),
        entry.bytes,
        entry.sha256.clone(),
        &entry.materials,
    );
    if stated != *entry {
        differences.push(format!("{} and the manifest state different facts", entry.file));
    }
    let others = against_plan(&table, plan);
    let comparable = others.is_empty();
    differences.extend(others);
    if entry.materials != plan.materials {
        let [found, wanted] = [&entry.materials, &plan.materials].map(|names| names.join(", "));
        differences.push(format!("its materials are {found}, the scene says {wanted}"));
    }
    let check = contents(&entry.id, differences);
    let subject = check.subject.clone();
    let mut checks = vec![check];
    let source = Source::new(settings.seed, &subject);
    let outcomes = if comparable {
        verify_table(&table, plan, settings, source)
    } else {
        let reason = "it is not the table that the scene calls for";
        let tests = [Test::TableTexels, Test::TableSamples, Test::TableLookup];
        tests.map(|test| Outcome::skipped(test, reason)).to_vec()
    };
    checks.extend(outcomes.into_iter().map(|outcome| Check {
        subject: subject.clone(),
        outcome,
        departure: None,
    }));
    checks
}

/// What a table has that the scene asks for differently; resolutions, mappings and the like are free.
fn against_plan(table: &Table, plan: &TablePlan) -> Vec<String> {
    let mut differences = Vec::new();
    let mut differ = |what: &str, found: &str, wanted: &str| {
        if found != wanted {
            differences.push(format!("{what} is {found}, the scene says {wanted}"));
        }
    };
    differ("the quantity", table.quantity.name(), plan.quantity.name());
    differ("the lobe", table.lobe.name(), plan.lobe.name());
    let channels = [table.channels, plan.channels].map(|channels| channels.count().to_string());
    differ("the number of channels", &channels[0], &channels[1]);
    let ranges = |axes: &[Axis]| -> String {
        let range = |axis: &Axis| format!("{} in [{}, {}]", axis.parameter, axis.min, axis.max);
        let ranges: Vec<String> = axes.iter().map(range).collect();
        if ranges.is_empty() {
            "none".into()
        } else {
            ranges.join(", ")
        }
    };
    let wanted = plan.alternatives.first().map_or("none".into(), |axes| ranges(axes));
    differ("the list of axes", &ranges(&table.axes), &wanted);
    let parameters = plan.model.describe();
    let find = |all: &[(String, String)], name: &str| {
        let found = all.iter().find(|(key, _)| key == name);
        found.map_or_else(|| "missing".to_string(), |(_, value)| value.clone())
    };
    let new = table
        .parameters
        .iter()
        .filter(|(name, _)| parameters.iter().all(|(key, _)| key != name));
    for (name, _) in parameters.iter().chain(new) {
        differ(name, &find(&table.parameters, name), &find(&parameters, name));
    }
    differences
}

/// A place of a table as an integral.
#[derive(Clone, Copy)]
struct Integral {
    target: Target,
    roughness: Option<f64>,
}

/// The integral at one value per axis.
fn target(table: &Table, at: &[f64]) -> Integral {
    let along = Coordinates::new(&table.axes);
    Integral {
        target: along.target(table.quantity, at).of(table.lobe),
        roughness: along.roughness(at),
    }
}

/// The tests [`Test::TableTexels`], [`Test::TableSamples`] and, for tables with axes, [`Test::TableLookup`].
pub fn verify_table(table: &Table, plan: &TablePlan, settings: &Settings, source: Source) -> Vec<Outcome> {
    let mut outcomes = vec![
        texels(table, plan, settings, source),
        samples(table, plan, settings, source),
    ];
    if !table.axes.is_empty() {
        outcomes.push(lookup(table, plan, source));
    }
    outcomes
}

/// All texels of a small table; of a large one its corners and random others.
fn chosen(table: &Table, most: usize, source: Source) -> Vec<usize> {
    let [width, height] = table.size();
    let count = width * height;
    if count <= most {
        return (0..count).collect();
    }
    let mut stream = source.part("texels").stream(0);
    let corners = [0, width - 1, count - width, count - 1];
    let random = (4..most).map(|_| (stream.uniform() * count as f64) as usize % count);
    let mut all: Vec<usize> = corners.into_iter().chain(random).collect();
    all.sort_unstable();
    all.dedup();
    all
}

/// Runs of places with one model each, integrated by `integrate`; the first error of any place, if there is one.
fn integrals<T: Send>(
    plan: &TablePlan,
    places: &[Integral],
    integrate: impl Fn(&Model, &[Integral], usize) -> Result<Vec<T>, String> + Sync,
) -> Result<Vec<T>, String> {
    let runs: Vec<&[Integral]> = places.chunk_by(|a, b| a.roughness == b.roughness).collect();
    let starts: Vec<usize> = runs
        .iter()
        .scan(0, |next, run| {
            let start = *next;
            *next += run.len();
            Some(start)
        })
        .collect();
    let results: Result<Vec<Vec<T>>, String> = runs
        .par_iter()
        .zip(starts)
        .map(|(run, start)| {
            let model = plan.model.at(run[0].roughness).map_err(|error| error.to_string())?;
            integrate(&model, run, start)
        })
        .collect();
    Ok(results?.into_iter().flatten().collect())
}

/// Deterministic integrals, or why there are none; places where the integral diverges have none.
fn references(plan: &TablePlan, places: &[Integral], tolerance: f64) -> Result<Vec<Option<Estimate>>, String> {
    let effort = Effort {
        tolerance,
        samples: None,
        seed: 0,
    };
    integrals(plan, places, |model, run, _| {
        let integrator = Integrator::new(model, Estimator::Auto, effort).map_err(|error| error.to_string())?;
        if run
            .iter()
            .any(|place| matches!(integrator.estimator(place.target), Estimator::MonteCarlo { .. }))
        {
            return Err("its integrals are only known from samples".into());
        }
        run.par_iter()
            .map(|place| match integrator.estimate(place.target, 0) {
                Ok(estimate) => Ok(Some(estimate)),
                Err(IntegrateError::Diverges(_)) => Ok(None),
                Err(error) => Err(error.to_string()),
            })
            .collect()
    })
}

/// The place of a texel.
fn place(table: &Table, at: &[f64]) -> Place {
    let names = table.axes.iter().map(|axis| axis.parameter.clone());
    Place::Axes(names.zip(at.iter().copied()).collect())
}

/// The stored value of a texel, and its error as a bound and as a standard deviation.
fn stored(table: &Table, texel: usize) -> (DVec3, DVec3, DVec3) {
    let error = table.texel_error(texel);
    match table.error_kind {
        ErrorKind::Ci99 => (table.stored(texel), DVec3::ZERO, error / Z99),
        ErrorKind::Bound | ErrorKind::Exact => (table.stored(texel), error, DVec3::ZERO),
    }
}

/// Texels against deterministic integrals: by both errors where the table states bounds, by chance where it states intervals.
fn texels(table: &Table, plan: &TablePlan, settings: &Settings, source: Source) -> Outcome {
    let test = Test::TableTexels;
    let chosen = chosen(table, CHEAPER * settings.texels, source);
    let places: Vec<Integral> = chosen.iter().map(|i| target(table, &table.texel_values(*i))).collect();
    let tolerance = (FINER * table.tolerance).clamp(1e-12, 1e-6);
    let references = match references(plan, &places, tolerance) {
        Ok(references) => references,
        Err(reason) => return Outcome::skipped(test, reason),
    };
    let compared: Vec<(usize, Estimate)> = chosen
        .iter()
        .zip(references)
        .filter_map(|(texel, reference)| reference.map(|reference| (*texel, reference)))
        .collect();
    if compared.is_empty() {
        return Outcome::skipped(test, "its integrals diverge");
    }
    let by_chance = table.error_kind == ErrorKind::Ci99;
    let found: Vec<(usize, f64, f64)> = compared
        .iter()
        .map(|(texel, reference)| {
            let (value, bound, deviation) = stored(table, *texel);
            let distance = (value - reference.value).abs();
            let beyond = distance - reference.error;
            let spreads = deviation.to_array().map(|deviation| Spread { deviation, unseen: 0.0 });
            let p = channels_p(spreads, beyond, table.channels.count());
            // beyond both errors, in units of theirs
            let allowed = (bound + reference.error).max(DVec3::splat(f64::MIN_POSITIVE));
            (*texel, p, (distance / allowed).max_element())
        })
        .collect();
    let count = found.len() as u64;
    if by_chance {
        let ps: Vec<f64> = found.iter().map(|(_, p, _)| *p).collect();
        let worst = found.iter().reduce(|a, b| if b.1 < a.1 { b } else { a });
        let (texel, p) = worst.map_or((0, 1.0), |(texel, p, _)| (*texel, *p));
        return Outcome::chance(test, Statistic::of("max z", score(p), count), smallest(&ps))
            .at(place(table, &table.texel_values(texel)));
    }
    let worst = found.iter().reduce(|a, b| if b.2 > a.2 { b } else { a });
    let (texel, ratio) = worst.map_or((0, 0.0), |(texel, _, ratio)| (*texel, *ratio));
    Outcome::certain(test, Statistic::of("max difference/error", ratio, count), ratio <= 1.0)
        .at(place(table, &table.texel_values(texel)))
}

/// Texels against Monte Carlo integrals of the model's own f.
fn samples(table: &Table, plan: &TablePlan, settings: &Settings, source: Source) -> Outcome {
    let test = Test::TableSamples;
    let source = source.part("samples");
    let positive = |texel: &usize| {
        // the limit at mu = 0 is no direction
        target(table, &table.texel_values(*texel))
            .target
            .outgoing
            .is_none_or(|angles| angles.mu > 0.0)
    };
    let chosen: Vec<usize> = chosen(table, settings.texels, source)
        .into_iter()
        .filter(positive)
        .collect();
    let places: Vec<Integral> = chosen.iter().map(|i| target(table, &table.texel_values(*i))).collect();
    let estimates = integrals(plan, &places, |model, run, start| {
        let bxdf = sampled(model).map_err(|error| error.to_string())?;
        let sampling = if bxdf.supports(Sampling::Visible) {
            Sampling::Visible
        } else {
            Sampling::Bxdf
        };
        let effort = Effort {
            tolerance: 0.5,
            samples: Some((settings.samples / 8).max(1024)),
            seed: source.seed(),
        };
        let integrator =
            Integrator::new(model, Estimator::random(sampling), effort).map_err(|error| error.to_string())?;
        run.par_iter()
            .enumerate()
            .map(
                |(index, place)| match integrator.estimate(place.target, (start + index) as u64) {
                    Ok(estimate) => Ok(Some(estimate)),
                    Err(IntegrateError::TooFewHits { .. }) => Ok(None),
                    Err(error) => Err(error.to_string()),
                },
            )
            .collect()
    });
    let estimates: Vec<Option<Estimate>> = match estimates {
        Ok(estimates) => estimates,
        Err(reason) => return Outcome::skipped(test, reason),
    };
    let mut found = Vec::new();
    for (texel, estimate) in chosen.iter().zip(estimates) {
        let Some(estimate) = estimate else { continue };
        let (value, bound, deviation) = stored(table, *texel);
        let difference = value - estimate.value;
        let spreads = [0, 1, 2].map(|channel| {
            let fresh = estimate.error[channel] * (FAR_OUT / Z99);
            Spread {
                deviation: deviation[channel].hypot(fresh),
                unseen: 0.0,
            }
        });
        let p = channels_p(spreads, difference.abs() - bound, table.channels.count());
        let sign = difference[difference.abs().max_position()].signum();
        found.push((*texel, p, sign * score(p)));
    }
    let Some((texel, _, worst)) = found.iter().copied().reduce(|a, b| if b.1 < a.1 { b } else { a }) else {
        return Outcome::skipped(test, "too few samples hit the lobe");
    };
    let ps: Vec<f64> = found.iter().map(|(_, p, _)| *p).collect();
    let scores: Vec<f64> = found.iter().map(|(_, _, score)| *score).collect();
    let p = smallest(&[smallest(&ps), common_sign(&scores)]);
    Outcome::chance(test, Statistic::of("max z", worst, found.len() as u64), p)
        .at(place(table, &table.texel_values(texel)))
}

/// Lookups at random places between texels, half of them at all scales towards mu = 0, against the error that is stated.
fn lookup(table: &Table, plan: &TablePlan, source: Source) -> Outcome {
    let test = Test::TableLookup;
    let Some(between) = &table.between else {
        return Outcome::skipped(test, "its error between texels was not measured");
    };
    let mut stream = source.part("lookup").stream(0);
    let mut places: Vec<Vec<f64>> = Vec::new();
    // one model for all places of a row
    let rows = if table.axes.iter().any(|axis| axis.parameter != "mu") {
        8
    } else {
        1
    };
    for _ in 0..rows {
        let along: Vec<f64> = table.axes.iter().map(|_| stream.uniform()).collect();
        for index in 0..PLACES / rows {
            let value = |(axis, u): (&Axis, &f64)| {
                if axis.parameter != "mu" {
                    return axis.value(*u);
                }
                let u = stream.uniform();
                if index % 2 == 0 {
                    axis.value(u)
                } else {
                    10f64.powf(-6.0 * u).clamp(axis.min, axis.max)
                }
            };
            places.push(table.axes.iter().zip(&along).map(value).collect());
        }
    }
    let targets: Vec<Integral> = places.iter().map(|at| target(table, at)).collect();
    let tolerance = (0.01 * between.error).min(table.tolerance).clamp(1e-12, 1e-6);
    let references = match references(plan, &targets, tolerance) {
        Ok(references) => references,
        Err(reason) => return Outcome::skipped(test, reason),
    };
    let channels = table.channels.count();
    let worst = places
        .iter()
        .zip(references)
        .filter_map(|(at, reference)| {
            let reference = reference?;
            let beyond = (table.sample(at) - reference.value).abs() - reference.error;
            let most = beyond.to_array()[..channels].iter().copied().fold(0.0, f64::max);
            Some((at, most))
        })
        .reduce(|a, b| if b.1 > a.1 { b } else { a });
    let Some((at, most)) = worst else {
        return Outcome::skipped(test, "its integrals diverge");
    };
    let statistic = Statistic::of(
        "max error/stated",
        most / between.error.max(f64::MIN_POSITIVE),
        PLACES as u64,
    );
    Outcome::certain(test, statistic, most <= between.error).at(place(table, at))
}
