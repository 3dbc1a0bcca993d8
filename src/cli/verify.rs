//! `furnace verify`

use super::{Failure, Outcome, format, in_pool, load, number, select};
use clap::Args;
use rayon::prelude::*;
use serde_json::{Map, Value, json};
use std::path::PathBuf;
use whitefurnace::scene::{Material, Scene};
use whitefurnace::verify::{Check, Evidence, Place, Report, Settings, Verdict, verify_material, verify_tables};

/// Arguments of `furnace verify`.
#[derive(Debug, Args)]
#[command(after_help = "\
Materials are tested for energy conservation (the largest albedo, searched for), the white furnace of couplings, \
reciprocity, sampling (int pdf, counts, weights, their mean) and the normalisation of their normals; a roughness range at \
both of its ends. With --tables, the tables of a bake are compared with fresh integrals, by both kinds of integration.

Chance has a part in some tests. All of them together wrongly fail in one run of 1000 (1 - confidence), each at the level \
that the last line states. Known departures of a published model from physics are findings, and no failures.

Exit codes: 0 everything holds, 1 something fails (or is a finding, with --strict), 2 wrong usage, input or output.

Examples:
  furnace verify scene.toml --material gold
  furnace verify --tables outputs/default
  furnace verify --seed 7 --confidence 0.99 --json")]
pub(super) struct Verify {
    /// Scene file (TOML, glTF 2.0 or pbrt-v3); without one the built-in scene is used.
    scene: Option<PathBuf>,
    /// Only this material; may be given several times.
    #[arg(long, value_name = "NAME")]
    material: Vec<String>,
    /// Test the tables in this directory too, those of a bake of the scene.
    #[arg(long, value_name = "DIR")]
    tables: Option<PathBuf>,
    /// Probability that everything passes when everything is right, above 0.5 and below 1.
    #[arg(long, default_value = "0.999", value_name = "P", value_parser = number::confidence, allow_hyphen_values = true)]
    confidence: f64,
    /// Findings are failures.
    #[arg(long)]
    strict: bool,
    /// Seed of the random streams; the same seed gives the same report on any number of threads.
    #[arg(long, default_value_t = 0, value_name = "N", value_parser = number::seed, allow_hyphen_values = true)]
    seed: u64,
    /// Threads to use, 1 to 1024; as many as there are cores by default.
    #[arg(long, value_name = "N", value_parser = number::threads, allow_hyphen_values = true)]
    threads: Option<usize>,
    /// Print JSON instead of text.
    #[arg(long)]
    json: bool,
}

impl Verify {
    pub(super) fn run(&self) -> Result<Outcome, Failure> {
        let scene = load(self.scene.as_deref())?;
        let materials = select(&scene.materials, &self.material)?;
        let settings = Settings::thorough(self.seed);
        let checks = in_pool(self.threads, || self.checks(&scene, &materials, &settings))?;
        let report = Report::judge(checks, self.confidence)?;
        if self.json {
            format::say(serde_json::to_string_pretty(&self.as_json(&scene, &report))?);
        } else {
            self.tell(&report);
        }
        Ok(if report.is_good(self.strict) {
            Outcome::Good
        } else {
            Outcome::Failed
        })
    }

    fn checks(&self, scene: &Scene, materials: &[&Material], settings: &Settings) -> Result<Vec<Check>, Failure> {
        let steps = materials.len() as u64 + u64::from(self.tables.is_some());
        let bar = format::progress_of(steps, "verifying", "steps");
        // first, so that a directory that is none is found before the work and not after it
        let of_tables = match &self.tables {
            None => Vec::new(),
            Some(directory) => verify_tables(scene, materials, directory, settings)?,
        };
        bar.inc(u64::from(self.tables.is_some()));
        let of_materials: Vec<Vec<Check>> = materials
            .par_iter()
            .map(|material| {
                let checks = verify_material(material, settings);
                bar.inc(1);
                checks
            })
            .collect();
        bar.finish_and_clear();
        Ok(of_materials.into_iter().flatten().chain(of_tables).collect())
    }

    fn tell(&self, report: &Report) {
        for group in report.results.chunk_by(|(a, _), (b, _)| a.subject == b.subject) {
            if let Some((first, _)) = group.first() {
                format::say(format!("{}\n", first.subject));
            }
            let header = ["  test", "statistic", "p", "verdict", "worst case"];
            let rows = group.iter().map(row).collect();
            format::say(format::table(&header, &["p"], rows).to_string());
            for (check, verdict) in group {
                let known = check.departure.filter(|_| *verdict == Verdict::Finding);
                let notes = known.map(|known| known.reason.to_string()).into_iter();
                for note in notes.chain(check.outcome.note.clone()) {
                    format::say(format!("  {}: {note}", check.outcome.test.name()));
                }
            }
            format::say("\n");
        }
        let count = |verdict| report.count(verdict);
        format::say(format!(
            "{} tests, {} of them statistical, each at level {:.1e}: all would pass in {} of runs if everything were right.",
            report.results.len(),
            report.statistical,
            report.level,
            share(report.confidence)
        ));
        format::say(format!(
            "{} hold, {} failed, {} {}, {} skipped.",
            count(Verdict::Holds),
            count(Verdict::Fails),
            count(Verdict::Finding),
            if count(Verdict::Finding) == 1 {
                "finding"
            } else {
                "findings"
            },
            count(Verdict::Skipped)
        ));
    }

    fn as_json(&self, scene: &Scene, report: &Report) -> Value {
        let results: Vec<Value> = report.results.iter().map(result).collect();
        json!({
            "scene": scene.name,
            "confidence": report.confidence,
            "seed": self.seed,
            "level": report.level,
            "statistical": report.statistical,
            "strict": self.strict,
            "results": results,
            "failed": report.count(Verdict::Fails),
            "findings": report.count(Verdict::Finding),
            "skipped": report.count(Verdict::Skipped),
            "ok": report.is_good(self.strict),
        })
    }
}

/// A confidence as `99.9 %`.
fn share(confidence: f64) -> String {
    let text = format!("{:.6}", 100.0 * confidence);
    format!("{} %", text.trim_end_matches('0').trim_end_matches('.'))
}

fn row((check, verdict): &(Check, Verdict)) -> Vec<String> {
    let outcome = &check.outcome;
    let worst = match &outcome.evidence {
        Evidence::Skipped(reason) => reason.clone(),
        _ => outcome.worst.as_ref().map_or_else(|| "-".into(), Place::to_string),
    };
    vec![
        format!("  {}", outcome.test.name()),
        outcome
            .statistic
            .as_ref()
            .map_or_else(|| "-".into(), ToString::to_string),
        match outcome.evidence {
            Evidence::Chance(p) => probability(p),
            _ => "-".into(),
        },
        verdict.name().into(),
        worst,
    ]
}

fn probability(p: f64) -> String {
    match p {
        0.0 => "0".into(),
        p if p < 1e-3 => format!("{p:.1e}"),
        p => format!("{p:.3}"),
    }
}

fn result((check, verdict): &(Check, Verdict)) -> Value {
    let outcome = &check.outcome;
    let finite = |value: f64| value.is_finite().then_some(value);
    let statistic = outcome.statistic.as_ref().map(|statistic| {
        // null stands for what has no bound
        json!({ "name": statistic.name, "value": finite(statistic.value), "of": statistic.of })
    });
    let p = match outcome.evidence {
        Evidence::Chance(p) => Some(p),
        Evidence::Certain(_) | Evidence::Skipped(_) => None,
    };
    let reason = match &outcome.evidence {
        Evidence::Skipped(reason) => Some(reason.as_str()),
        _ => check
            .departure
            .filter(|_| *verdict == Verdict::Finding)
            .map(|known| known.reason),
    };
    json!({
        "material": check.subject,
        "test": outcome.test.name(),
        "statistic": statistic,
        "p_value": p,
        "verdict": verdict.name().to_lowercase(),
        "worst": outcome.worst.as_ref().map(place),
        "reason": reason,
        "note": outcome.note,
    })
}

fn place(place: &Place) -> Value {
    match place {
        Place::Direction([theta, phi]) => json!({ "theta_deg": theta, "phi_deg": phi }),
        Place::Pair([[theta_o, phi_o], [theta_i, phi_i]]) => json!({
            "theta_o_deg": theta_o, "phi_o_deg": phi_o, "theta_i_deg": theta_i, "phi_i_deg": phi_i,
        }),
        Place::Axes(axes) => {
            let axes: Map<String, Value> = axes.iter().map(|(name, value)| (name.clone(), json!(value))).collect();
            Value::Object(axes)
        }
        Place::File(name) => json!({ "file": name }),
    }
}
