//! The data of a study, for programs: CSV files and one JSON document with the same numbers.

use super::contest::{Contest, ERROR};
use super::ladder::{Accuracy, Curve, Outcome, Run, Rung};
use super::report::Report;
use super::scaling::Grown;
use super::shape::{Answer, Shape, Shapes};
use super::{Kin, Line};
use serde_json::{Value, json};

/// The CSV files, with their names.
pub fn csv(report: &Report) -> [(&'static str, String); 4] {
    let estimators = report.accuracy.iter().flat_map(|study| {
        let rows = study.curves.iter().flat_map(move |curve| {
            curve.runs.iter().map(move |run| {
                let mut row = vec![study.subject.material.clone(), curve.estimator.name().into()];
                row.extend(of_run(run));
                row
            })
        });
        rows.collect::<Vec<_>>()
    });
    let tables = report.shapes.iter().flat_map(|found| {
        let rows = found.shapes.iter().map(|shape| {
            let mut row = vec![found.material.clone()];
            row.extend(of_shape(shape));
            row
        });
        rows.collect::<Vec<_>>()
    });
    [
        (
            "estimators.csv",
            lines(
                "material,estimator,samples,tolerance,seed,outcome,max_error,rms_error,stated_error,covered,values,\
                 evaluations,cpu_seconds,wall_seconds",
                estimators,
            ),
        ),
        (
            "tables.csv",
            lines(
                "material,size,mapping,storage,bytes,max_error,rms_error,max_error_anywhere,evaluations,cpu_seconds,wall_seconds",
                tables,
            ),
        ),
        (
            "scaling.csv",
            lines(
                "lobe,growth,value,texels,evaluations,cpu_seconds,wall_seconds",
                report.scaling.iter().map(of_grown),
            ),
        ),
        (
            "contest.csv",
            lines(
                "lobe,size,error,quadrature_cpu_seconds,quadrature_max_error,quadrature_evaluations,rival,rival_samples,\
                 rival_max_error,rival_cpu_seconds,rival_texels,rival_reached,ratio",
                report.contests.iter().map(of_contest),
            ),
        ),
    ]
}

fn lines(header: &str, rows: impl Iterator<Item = Vec<String>>) -> String {
    let mut out = format!("{header}\n");
    for row in rows {
        let cells: Vec<String> = row.iter().map(|cell| quoted(cell)).collect();
        out.push_str(&cells.join(","));
        out.push('\n');
    }
    out
}

/// A cell by RFC 4180: quoted where it holds what separates cells.
fn quoted(cell: &str) -> String {
    if cell.contains([',', '"', '\n', '\r']) {
        format!("\"{}\"", cell.replace('"', "\"\""))
    } else {
        cell.into()
    }
}

fn number(value: f64) -> String {
    format!("{value:e}")
}

fn of_run(run: &Run) -> Vec<String> {
    let (samples, tolerance) = match run.rung {
        Rung::Samples(samples) => (samples.to_string(), String::new()),
        Rung::Tolerance(tolerance) => (String::new(), number(tolerance)),
    };
    let mut row = vec![samples, tolerance, run.seed.to_string()];
    match &run.outcome {
        Outcome::Measured(found) => row.extend([
            "measured".into(),
            number(found.max_error),
            number(found.rms_error),
            number(found.stated_error),
            found.covered.to_string(),
            found.values.to_string(),
            found.evaluations.to_string(),
            number(found.seconds.cpu),
            number(found.seconds.wall),
        ]),
        Outcome::Refused { texels, reason } => row.push(format!("refused {texels} texels: {reason}")),
        Outcome::LeftOut => row.push("left out: no time".into()),
    }
    row.resize(12, String::new());
    row
}

fn of_shape(shape: &Shape) -> Vec<String> {
    vec![
        shape.size(),
        shape.mapping(),
        shape.storage.name().into(),
        shape.bytes.to_string(),
        number(shape.max_error),
        number(shape.rms_error),
        number(shape.anywhere),
        shape.evaluations.to_string(),
        number(shape.seconds.cpu),
        number(shape.seconds.wall),
    ]
}

fn of_grown(grown: &Grown) -> Vec<String> {
    let seconds = |clock: fn(super::Seconds) -> f64| grown.seconds.map_or_else(String::new, |s| number(clock(s)));
    vec![
        grown.lobe.into(),
        grown.growth.name().into(),
        number(grown.value),
        grown.texels.to_string(),
        grown.evaluations.to_string(),
        seconds(|s| s.cpu),
        seconds(|s| s.wall),
    ]
}

fn of_contest(contest: &Contest) -> Vec<String> {
    let mut row = vec![
        contest.lobe.into(),
        contest.size.to_string(),
        number(ERROR),
        number(contest.quadrature.cpu),
        number(contest.quadrature_error),
        contest.quadrature_evaluations.to_string(),
    ];
    if let Some(rival) = &contest.rival {
        row.extend([
            rival.estimator.name().into(),
            rival.samples.to_string(),
            number(rival.error),
            number(rival.cpu),
            rival.texels.to_string(),
            rival.reached.to_string(),
        ]);
    }
    row.resize(12, String::new());
    row.push(contest.ratio().map_or_else(String::new, number));
    row
}

/// Everything.
pub fn json(report: &Report) -> Value {
    let settings = &report.settings;
    json!({
        "seed": settings.seed,
        "threads": settings.threads,
        "seconds": report.wall,
        "budget": settings.seconds,
        "parts": report.parts.iter().map(|(what, seconds)| json!({ "part": what, "seconds": seconds })).collect::<Vec<_>>(),
        "cpu_seconds": "CPU time of the one thread that computed a table alone",
        "accuracy": report.accuracy.iter().map(accuracy).collect::<Vec<_>>(),
        "tables": report.shapes.iter().map(shapes).collect::<Vec<_>>(),
        "scaling": report.scaling.iter().map(grown).collect::<Vec<_>>(),
        "contests": report.contests.iter().map(contest).collect::<Vec<_>>(),
    })
}

fn accuracy(study: &Accuracy) -> Value {
    let reference = &study.reference;
    json!({
        "material": study.subject.material,
        "texels": study.subject.texels(),
        "channels": study.subject.plan.channels.count(),
        "reference": {
            "estimator": reference.estimator.name(),
            "error": reference.error,
            "evaluations": reference.evaluations,
            "cpu_seconds": reference.seconds.cpu,
            "wall_seconds": reference.seconds.wall,
        },
        "curves": study.curves.iter().map(|curve| self::curve(study, curve)).collect::<Vec<_>>(),
    })
}

fn curve(study: &Accuracy, curve: &Curve) -> Value {
    let [covered, values] = curve.coverage();
    json!({
        "estimator": curve.estimator.name(),
        "kind": Kin::of(curve.estimator).name(),
        "unsupported": curve.unsupported,
        "order": curve.order(&study.reference).map(line),
        "evaluations_per_digit": curve.per_digit().map(line),
        "covered": covered,
        "values": values,
        "runs": curve.runs.iter().map(run).collect::<Vec<_>>(),
    })
}

fn line(line: Line) -> Value {
    json!({ "slope": line.slope, "slope_error": line.slope_error, "points": line.points })
}

fn run(run: &Run) -> Value {
    let mut value = json!({ "seed": run.seed });
    match run.rung {
        Rung::Samples(samples) => value["samples"] = json!(samples),
        Rung::Tolerance(tolerance) => value["tolerance"] = json!(tolerance),
    }
    match &run.outcome {
        Outcome::Measured(found) => {
            value["max_error"] = json!(found.max_error);
            value["rms_error"] = json!(found.rms_error);
            value["stated_error"] = json!(found.stated_error);
            value["covered"] = json!(found.covered);
            value["values"] = json!(found.values);
            value["evaluations"] = json!(found.evaluations);
            value["cpu_seconds"] = json!(found.seconds.cpu);
            value["wall_seconds"] = json!(found.seconds.wall);
        }
        Outcome::Refused { texels, reason } => value["refused"] = json!({ "texels": texels, "reason": reason }),
        Outcome::LeftOut => value["left_out"] = json!(true),
    }
    value
}

fn shapes(found: &Shapes) -> Value {
    json!({
        "material": found.material,
        "skipped": found.skipped,
        "left_out": found.left_out,
        "answers": found.answers.iter().map(answer).collect::<Vec<_>>(),
        "tables": found.shapes.iter().map(shape).collect::<Vec<_>>(),
    })
}

fn answer(answer: &Answer) -> Value {
    json!({ "error": answer.error, "table": answer.table.as_ref().map(shape) })
}

fn shape(shape: &Shape) -> Value {
    json!({
        "size": shape.axes.iter().map(|axis| axis.size).collect::<Vec<_>>(),
        "mapping": shape.mapping(),
        "storage": shape.storage.name(),
        "bytes": shape.bytes,
        "max_error": shape.max_error,
        "rms_error": shape.rms_error,
        "max_error_anywhere": shape.anywhere,
        "evaluations": shape.evaluations,
        "cpu_seconds": shape.seconds.cpu,
        "wall_seconds": shape.seconds.wall,
    })
}

fn grown(grown: &Grown) -> Value {
    json!({
        "lobe": grown.lobe,
        "growth": grown.growth.name(),
        "value": grown.value,
        "texels": grown.texels,
        "evaluations": grown.evaluations,
        "cpu_seconds": grown.seconds.map(|seconds| seconds.cpu),
        "wall_seconds": grown.seconds.map(|seconds| seconds.wall),
    })
}

fn contest(contest: &Contest) -> Value {
    json!({
        "lobe": contest.lobe,
        "size": contest.size,
        "error": ERROR,
        "quadrature": {
            "cpu_seconds": contest.quadrature.cpu,
            "max_error": contest.quadrature_error,
            "evaluations": contest.quadrature_evaluations,
        },
        "rival": contest.rival.as_ref().map(|rival| json!({
            "estimator": rival.estimator.name(),
            "samples": rival.samples,
            "max_error": rival.error,
            "cpu_seconds": rival.cpu,
            "texels": rival.texels,
            "reached": rival.reached,
        })),
        "ratio": contest.ratio(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_are_quoted_where_they_have_to_be() {
        assert_eq!(quoted("plain text"), "plain text");
        assert_eq!(quoted("a,b"), "\"a,b\"");
        assert_eq!(quoted("say \"x\""), "\"say \"\"x\"\"\"");
    }
}
