//! `furnace cost`

use super::{Failure, format, load, number, output_directory, select};
use clap::Args;
use indicatif::ProgressBar;
use serde_json::json;
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use whitefurnace::cost::{Accuracy, CONTEST_ERROR, Contest, Curve, Kin, Report, Settings, Shapes, Watch};
use whitefurnace::cost::{chart, data, default_scene, run};
use whitefurnace::export::write;
use whitefurnace::scene::Material;

/// Arguments of `furnace cost`.
#[derive(Debug, Args)]
#[command(after_help = "\
Runs every estimator over a ladder of sample counts, and quadrature over one of tolerances, and compares with a converged \
reference: largest and RMS error over a table, CPU and wall seconds, evaluations, repeated with several seeds. Then it \
shapes tables (texels, mapping of mu, storage) and measures what a shader sees between texels, lets the work grow (texels, \
sharpness, digits), and sets quadrature against quasi-Monte Carlo at equal error.

Seconds are CPU seconds of the one thread that computes a table alone; as many tables are computed at a time as there are \
threads. Errors and evaluations depend on the seed alone, unless --seconds leaves something out.

Writes accuracy, samples, tables and scaling as .svg and .png, estimators.csv, tables.csv, scaling.csv, contest.csv, and \
cost.json with everything.

Examples:
  furnace cost                          the built-in study, some minutes
  furnace cost --quick                  a first look, in seconds
  furnace cost scene.toml --material gold --seconds 60 --out gold-cost")]
pub(super) struct Cost {
    /// Scene file (TOML, glTF 2.0 or pbrt-v3); without one a telling few materials are studied.
    scene: Option<PathBuf>,
    /// Only this material; may be given several times.
    #[arg(long, value_name = "NAME")]
    material: Vec<String>,
    /// Smaller tables, fewer samples and seeds.
    #[arg(long)]
    quick: bool,
    /// Wall seconds that the study may take, 1 to 86400: what does not fit is left out, and named.
    #[arg(long, value_name = "S", value_parser = number::seconds, allow_hyphen_values = true)]
    seconds: Option<f64>,
    /// Directory for data and charts.
    #[arg(long, value_name = "DIR", default_value = "outputs/cost")]
    out: PathBuf,
    /// Seed of the random streams; the same seed gives the same errors on any number of threads.
    #[arg(long, default_value_t = 0, value_name = "N", value_parser = number::seed, allow_hyphen_values = true)]
    seed: u64,
    /// Tables to compute at a time, 1 to 1024; as many as there are cores by default.
    #[arg(long, value_name = "N", value_parser = number::threads, allow_hyphen_values = true)]
    threads: Option<usize>,
    /// Print JSON instead of text.
    #[arg(long)]
    json: bool,
}

/// A bar for each part of the study, on a terminal.
#[derive(Default)]
struct Bars(Mutex<Option<ProgressBar>>);

impl Bars {
    fn with(&self, act: impl FnOnce(&mut Option<ProgressBar>)) {
        act(&mut self.0.lock().unwrap_or_else(|poisoned| poisoned.into_inner()));
    }

    fn finish(&self) {
        self.with(|bar| {
            if let Some(bar) = bar.take() {
                bar.finish_and_clear();
            }
        });
    }
}

impl Watch for Bars {
    fn begin(&self, what: &'static str, work: u64) {
        self.finish();
        self.with(|bar| *bar = Some(format::progress_of(work, what, "steps")));
    }

    fn advance(&self, done: u64) {
        self.with(|bar| {
            if let Some(bar) = bar {
                bar.inc(done);
            }
        });
    }
}

impl Cost {
    pub(super) fn run(&self) -> Result<(), Failure> {
        let scene = match &self.scene {
            Some(path) => load(Some(path))?,
            None => default_scene(),
        };
        let materials: Vec<&Material> = select(&scene.materials, &self.material)?;
        let cores = || std::thread::available_parallelism().map_or(1, usize::from);
        let threads = self.threads.unwrap_or_else(cores);
        let settings = Settings {
            seconds: self.seconds,
            ..if self.quick {
                Settings::quick(self.seed, threads)
            } else {
                Settings::full(self.seed, threads)
            }
        };
        // an unusable directory is found before the work, not after it
        output_directory(&self.out)?;
        let bars = Bars::default();
        let report = run(&materials, &settings, &bars);
        bars.finish();
        let report = report?;
        let mut value = data::json(&report);
        value["scene"] = json!(scene.name);
        let files = write_all(&self.out, &report, &value)?;
        if self.json {
            format::say(serde_json::to_string_pretty(&value)?);
        } else {
            tell(&self.out, &report, &files);
        }
        Ok(())
    }
}

/// All files are made before the first is written.
fn write_all(directory: &Path, report: &Report, value: &serde_json::Value) -> Result<Vec<String>, Failure> {
    let mut files: Vec<(String, Vec<u8>)> = Vec::new();
    for (stem, canvas) in chart::all(report) {
        files.push((format!("{stem}.svg"), chart::to_svg(&canvas).into_bytes()));
        files.push((format!("{stem}.png"), chart::to_png(&canvas)?));
    }
    for (name, text) in data::csv(report) {
        files.push((name.into(), text.into_bytes()));
    }
    files.push(("cost.json".into(), serde_json::to_vec_pretty(value)?));
    for (name, bytes) in &files {
        write::write_whole(&directory.join(name), bytes)?;
    }
    Ok(files.into_iter().map(|(name, _)| name).collect())
}

fn tell(directory: &Path, report: &Report, files: &[String]) {
    tell_answers(&report.shapes);
    tell_contests(&report.contests);
    tell_accuracy(&report.accuracy);
    tell_missing(report);
    let parts = report
        .parts
        .iter()
        .map(|(what, wall)| format!("{what} {}", format::seconds(*wall)));
    format::say(format!(
        "\n{} ({}) on {} threads, each table on one. In {}:\n  {}",
        format::seconds(report.wall),
        parts.collect::<Vec<_>>().join(", "),
        report.settings.threads,
        directory.display(),
        files.join("  ")
    ));
}

/// The smallest tables that are good enough.
fn tell_answers(found: &[Shapes]) {
    format::say("The smallest table for an error on the screen, anywhere in its domain:\n\n");
    let rows = found.iter().flat_map(|shapes| {
        shapes.answers.iter().map(|answer| {
            let mut row = vec![shapes.material.clone(), format!("{:.0e}", answer.error)];
            match &answer.table {
                Some(table) => row.extend([
                    table.size(),
                    table.mapping(),
                    table.storage.name().into(),
                    table.bytes.to_string(),
                    format::seconds(table.seconds.cpu),
                    format::error(table.anywhere),
                ]),
                None if shapes.shapes.is_empty() => row.push("not studied: more --seconds".into()),
                None => row.push("none of this study".into()),
            }
            row
        })
    });
    let header = [
        "material",
        "for",
        "texels",
        "axis of mu",
        "storage",
        "bytes",
        "CPU time",
        "error",
    ];
    let right = ["texels", "bytes", "CPU time"];
    format::say(format::table(&header, &right, rows.map(|row| filled(row, header.len())).collect()).to_string());
    for shapes in found {
        if let Some(reason) = &shapes.skipped {
            format::say(format!("{}: no tables: {reason}", shapes.material));
        }
    }
}

fn tell_contests(contests: &[Contest]) {
    format::say(format!(
        "\nQuadrature against the best quasi-random estimator, tables of mu x perceptual roughness, largest error {CONTEST_ERROR:.0e}:\n\n"
    ));
    let rows = contests.iter().map(|contest| {
        let mut row = vec![
            contest.lobe.into(),
            format!("{0} x {0}", contest.size),
            format::seconds(contest.quadrature.cpu),
        ];
        if let (Some(rival), Some(ratio)) = (&contest.rival, contest.ratio()) {
            let more = if rival.reached { "" } else { "> " };
            row.extend([
                rival.estimator.name().into(),
                format::count(rival.samples),
                format!("{more}{}", format::seconds(rival.cpu)),
                format!("{more}{ratio:.0}"),
            ]);
        }
        row
    });
    let header = [
        "lobe",
        "texels",
        "quadrature",
        "rival",
        "samples/texel",
        "its CPU time",
        "ratio",
    ];
    let right = ["quadrature", "samples/texel", "its CPU time", "ratio"];
    format::say(format::table(&header, &right, rows.map(|row| filled(row, header.len())).collect()).to_string());
    if let Some(rival) = contests.iter().find_map(|contest| contest.rival.as_ref()) {
        format::say(format!(
            "The rival is timed on {} texels of each table, spread evenly, with the fewest samples that a table of one count needs.",
            rival.texels
        ));
    }
}

fn tell_accuracy(studies: &[Accuracy]) {
    format::say("\nEstimators, of each kind the sampling that does most with its time (all are in the files):\n\n");
    let header = [
        "material",
        "estimator",
        "order",
        "CPU for 1e-3",
        "for 1e-4",
        "for 1e-6",
        "stated errors that hold",
    ];
    let rows = studies.iter().flat_map(|study| {
        let best = Kin::COMPARED.into_iter().filter_map(|kin| study.best(kin));
        best.map(|curve| row(study, curve)).collect::<Vec<_>>()
    });
    let right = ["CPU for 1e-3", "for 1e-4", "for 1e-6"];
    format::say(format::table(&header, &right, rows.collect()).to_string());
    for study in studies {
        let reference = &study.reference;
        let subject = &study.subject;
        format::say(format!(
            "{}: {} texels, reference by {} to {}",
            subject.material,
            subject.texels(),
            reference.estimator,
            format::error(reference.error)
        ));
    }
}

fn row(study: &Accuracy, curve: &Curve) -> Vec<String> {
    let order = match Kin::of(curve.estimator) {
        Kin::Quadrature | Kin::ClosedForm => curve
            .per_digit()
            .map(|line| format!("{:.0}/digit", line.slope / study.subject.texels() as f64)),
        _ => curve
            .order(&study.reference)
            .map(|line| format!("{:.2} +- {:.2}", line.slope, line.slope_error)),
    };
    let time = |error| curve.seconds_for(error).map_or_else(|| "-".into(), format::seconds);
    let [covered, values] = curve.coverage();
    vec![
        study.subject.material.clone(),
        curve.estimator.name().into(),
        order.unwrap_or_else(|| "-".into()),
        time(1e-3),
        time(1e-4),
        time(1e-6),
        format!(
            "{:.2} % of {}",
            100.0 * covered as f64 / values.max(1) as f64,
            format::count(values)
        ),
    ]
}

/// What is not there, and why.
fn tell_missing(report: &Report) {
    let curves = || report.accuracy.iter().flat_map(|study| &study.curves);
    let [refused, left_out] = curves().fold([0, 0], |[a, b], curve| {
        let [refused, left_out] = curve.missing();
        [a + refused, b + left_out]
    });
    let runs: usize = curves().map(|curve| curve.runs.len()).sum();
    let coverage = curves()
        .filter(|curve| Kin::of(curve.estimator) != Kin::ClosedForm)
        .map(Curve::coverage)
        .fold([0, 0], |[a, b], [covered, values]| [a + covered, b + values]);
    let runs = runs - left_out;
    if coverage[1] == 0 {
        format::say("\nNo estimator was run: references alone took the time.");
    } else {
        format::say(format!(
            "\nOf all estimators and samplings {:.3} % of {} stated errors hold; {refused} of {runs} runs stated none, for too few hits.",
            100.0 * coverage[0] as f64 / coverage[1].max(1) as f64,
            format::count(coverage[1]),
        ));
    }
    let tables: usize = report.shapes.iter().map(|shapes| shapes.left_out).sum();
    let grown = report.scaling.iter().filter(|grown| grown.seconds.is_none()).count();
    if left_out + tables + grown > 0 {
        format::say(format!(
            "Left out: {left_out} runs of estimators, {tables} shapes of tables, {grown} points of growth; more --seconds brings them."
        ));
    }
}

/// A row with empty cells to its end.
fn filled(mut row: Vec<String>, columns: usize) -> Vec<String> {
    row.resize(columns, String::new());
    row
}
