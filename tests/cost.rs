//! What accuracy costs: the study against laws that are known, its files against each other.

use serde_json::Value;
use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::process::{Command, Output};
use whitefurnace::cost::{Curve, Settings, Unwatched, default_scene, run};
use whitefurnace::estimate::Estimator;
use whitefurnace::integrate::seen::Reference;
use whitefurnace::integrate::texels;
use whitefurnace::plan::{Economy, Plan, Request};
use whitefurnace::scene::{Material, Scene};

fn furnace(directory: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_furnace"))
        .current_dir(directory)
        .args(arguments)
        .output()
        .unwrap()
}

fn material(name: &str) -> Material {
    let scene = default_scene();
    scene
        .materials
        .into_iter()
        .find(|material| material.name == name)
        .unwrap()
}

/// Small enough for a test.
fn small(seed: u64) -> Settings {
    Settings {
        samples: vec![1 << 10, 1 << 12, 1 << 14],
        seeds: 4,
        sizes: vec![8, 16, 32, 64],
        contest: 8,
        contest_stride: 4,
        ..Settings::quick(seed, 2)
    }
}

const FILES: [&str; 13] = [
    "accuracy.png",
    "accuracy.svg",
    "contest.csv",
    "cost.json",
    "estimators.csv",
    "samples.png",
    "samples.svg",
    "scaling.csv",
    "scaling.png",
    "scaling.svg",
    "tables.csv",
    "tables.png",
    "tables.svg",
];

/// Rows of a CSV file by the names of its columns. Cells of ours that hold commas are quoted, and none holds a line break.
fn csv(path: &Path) -> Vec<BTreeMap<String, String>> {
    let cells = |line: &str| -> Vec<String> {
        let mut cells = vec![String::new()];
        let mut quoted = false;
        for letter in line.chars() {
            match letter {
                '"' => quoted = !quoted,
                ',' if !quoted => cells.push(String::new()),
                other => cells.last_mut().unwrap().push(other),
            }
        }
        cells
    };
    let text = fs::read_to_string(path).unwrap();
    let mut lines = text.lines();
    let header = cells(lines.next().unwrap());
    let row = |line: &str| {
        let row = cells(line);
        assert_eq!(row.len(), header.len(), "{line}");
        header.iter().cloned().zip(row).collect()
    };
    lines.map(row).collect()
}

/// (series, x, y) of every marker that stands for data.
fn markers(path: &Path) -> Vec<(String, f64, f64)> {
    let text = fs::read_to_string(path).unwrap();
    let document = roxmltree::Document::parse(&text).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    let data = document
        .descendants()
        .filter(|node| node.attribute("class") == Some("datum"));
    let number = |text: Option<&str>| text.unwrap().parse::<f64>().unwrap();
    data.map(|node| {
        let series = node.attribute("data-series").unwrap().to_owned();
        (
            series,
            number(node.attribute("data-x")),
            number(node.attribute("data-y")),
        )
    })
    .collect()
}

#[test]
fn a_quick_study_writes_data_and_charts_that_agree() {
    let directory = tempfile::tempdir().unwrap();
    let output = furnace(
        directory.path(),
        &["cost", "--quick", "--material", "beckmann-m0.5-glass", "--out", "out"],
    );
    let (out, errors) = (
        String::from_utf8(output.stdout).unwrap(),
        String::from_utf8(output.stderr).unwrap(),
    );
    assert_eq!(output.status.code(), Some(0), "{errors}");
    // no progress where no terminal looks on
    assert_eq!(errors, "");
    assert!(
        out.starts_with("The smallest table for an error on the screen"),
        "{out}"
    );
    let path = |name: &str| directory.path().join("out").join(name);
    let mut found: Vec<String> = fs::read_dir(path(""))
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    found.sort();
    assert_eq!(found, FILES);

    let json: Value = serde_json::from_slice(&fs::read(path("cost.json")).unwrap()).unwrap();
    let curves = json["accuracy"][0]["curves"].as_array().unwrap();
    // every estimator but auto has its curve, whether it can compute the material or not
    assert_eq!(curves.len() + 1, Estimator::ALL.len());
    let runs = |curve: &Value| curve["runs"].as_array().unwrap().clone();
    let rows = csv(&path("estimators.csv"));
    assert_eq!(rows.len(), curves.iter().map(|curve| runs(curve).len()).sum::<usize>());
    let mut in_json = curves
        .iter()
        .flat_map(|curve| runs(curve).into_iter().map(|run| (curve["estimator"].clone(), run)));
    for row in &rows {
        let (estimator, run) = in_json.next().unwrap();
        assert_eq!(row["estimator"], estimator.as_str().unwrap());
        assert_eq!(
            row["outcome"] == "measured",
            run["max_error"].is_number(),
            "{row:?} {run}"
        );
        if row["outcome"] == "measured" {
            for key in ["max_error", "rms_error", "stated_error", "cpu_seconds", "wall_seconds"] {
                assert_eq!(row[key].parse::<f64>().unwrap(), run[key].as_f64().unwrap(), "{key}");
            }
            assert_eq!(row["evaluations"], run["evaluations"].to_string());
        } else {
            // what is not there says why
            assert!(row["outcome"].starts_with("refused "), "{row:?}");
        }
    }
    let tables = csv(&path("tables.csv"));
    assert_eq!(tables.len(), json["tables"][0]["tables"].as_array().unwrap().len());

    // the error of every point of the quadrature curve stands in the chart, at the time that it took
    let reference = json["accuracy"][0]["reference"]["error"].as_f64().unwrap();
    let drawn = markers(&path("accuracy.svg"));
    let quadrature: Vec<_> = rows.iter().filter(|row| row["estimator"] == "quadrature").collect();
    let of_quadrature: Vec<_> = drawn
        .iter()
        .filter(|(name, ..)| name.ends_with(" quadrature"))
        .collect();
    assert!(!quadrature.is_empty() && quadrature.len() == of_quadrature.len());
    for (row, (_, x, y)) in quadrature.iter().zip(of_quadrature) {
        let error: f64 = row["max_error"].parse().unwrap();
        assert_eq!(*x, row["cpu_seconds"].parse::<f64>().unwrap());
        // a logarithm and an exponential round by some 1e-16 times the logarithm
        assert!((y / error.max(reference) - 1.0).abs() < 1e-12, "{y} {error}");
    }
    // of the shapes those kept as f32 with every mapping, and those of one mapping with every storage
    let f32s = tables.iter().filter(|row| row["storage"] == "f32").count();
    let mappings: std::collections::BTreeSet<_> = tables.iter().map(|row| &row["mapping"]).collect();
    assert_eq!(markers(&path("tables.svg")).len(), f32s + tables.len() / mappings.len());
    let grown = csv(&path("scaling.csv"));
    assert_eq!(markers(&path("scaling.svg")).len(), grown.len());

    for stem in ["accuracy", "samples", "tables", "scaling"] {
        let picture = tiny_skia::Pixmap::decode_png(&fs::read(path(&format!("{stem}.png"))).unwrap()).unwrap();
        let svg = fs::read_to_string(path(&format!("{stem}.svg"))).unwrap();
        let document = roxmltree::Document::parse(&svg).unwrap();
        let width: f64 = document.root_element().attribute("width").unwrap().parse().unwrap();
        assert_eq!(f64::from(picture.width()), (2.0 * width).ceil(), "{stem}");
        let inked = picture.pixels().iter().filter(|pixel| pixel.red() < 0x80).count();
        assert!(inked > 1000, "{stem}: {inked} dark pixels");
    }
}

#[test]
fn errors_fall_as_theory_says_and_stated_errors_hold() {
    let glass = material("ggx-a0.3-glass");
    let report = run(&[&glass], &small(1), &Unwatched).unwrap();
    let study = &report.accuracy[0];
    let curve = |name: &str| -> &Curve {
        study
            .curves
            .iter()
            .find(|curve| curve.estimator.name() == name)
            .unwrap()
    };
    let order = |name: &str| curve(name).order(&study.reference).unwrap();
    let (mc, qmc) = (order("mc-visible"), order("qmc-visible"));
    // three standard errors, and no less than 0.1: the residuals of twelve points know the spread to a quarter
    assert!((mc.slope + 0.5).abs() < (3.0 * mc.slope_error).max(0.1), "{mc:?}");
    // weights of visible normals are smooth in the numbers: well beyond -1/2
    assert!(qmc.slope < -0.75 && qmc.slope < mc.slope - 0.2, "{mc:?} {qmc:?}");
    // a bound holds always
    let [covered, values] = curve("quadrature").coverage();
    assert!(covered == values && values > 0, "{covered} of {values}");
    // intervals of 99 % in 99 % of cases: with 144 of each estimator three misses too many have a probability below 1e-3
    for curve in study
        .curves
        .iter()
        .filter(|curve| curve.estimator.name().starts_with("mc-"))
    {
        let [covered, values] = curve.coverage();
        assert!(
            values - covered <= 1 + values / 30,
            "{}: {covered} of {values}",
            curve.estimator
        );
    }
    // a digit of quadrature costs evaluations, not a factor
    assert!(curve("quadrature").per_digit().unwrap().slope > 0.0);
}

#[test]
fn errors_and_evaluations_depend_on_the_seed_alone() {
    let paint = material("acrylic-paint-measured");
    let settings = |seed, threads| Settings {
        samples: vec![1 << 11],
        reference_samples: 1 << 15,
        seeds: 2,
        contest: 4,
        contest_stride: 4,
        ..Settings::quick(seed, threads)
    };
    let numbers = |settings: Settings| {
        let report = run(&[&paint], &settings, &Unwatched).unwrap();
        let curves = report.accuracy[0].curves.iter();
        let points = curves.flat_map(|curve| {
            let points = curve.points().into_iter();
            points
                .map(|point| (point.max_errors(), point.rms_errors(), point.evaluations()))
                .collect::<Vec<_>>()
        });
        points.collect::<Vec<_>>()
    };
    let first = numbers(settings(3, 1));
    assert!(!first.is_empty());
    assert_eq!(first, numbers(settings(3, 3)));
    assert_ne!(first, numbers(settings(4, 1)));
}

#[test]
fn answers_keep_their_promise_at_other_places() {
    let metal = material("vmf-k1024-aluminium");
    let settings = small(0);
    let report = run(&[&metal], &settings, &Unwatched).unwrap();
    let scene = Scene::new("answers", vec![metal]);
    let request = Request {
        resolution: 2,
        roughness_resolution: 2,
        azimuth_resolution: 2,
        mapping: None,
        estimator: Estimator::Auto,
        tolerance: Some(1e-7),
        samples: None,
        seed: 0,
        economy: Economy::FULL,
    };
    let plan = Plan::new(&scene, &request).unwrap().tables.remove(0);
    // other places than the study knew, and four times as many
    let judge = Reference::new(&plan, 1e-8, 77, 512).unwrap();
    let answers = &report.shapes[0].answers;
    let given: Vec<_> = answers
        .iter()
        .filter_map(|answer| Some((answer.error, answer.table.as_ref()?)))
        .collect();
    assert!(given.len() >= 2, "{answers:?}");
    for (error, shape) in given {
        let table = texels(&plan, &shape.axes, &|_| {}).unwrap();
        let seen = judge.seen(&table, shape.storage);
        // both found the worst of a finite number of places; between them lie a few per cent
        assert!(seen.anywhere <= 1.1 * error, "{error:e}: {seen:?}");
        assert_eq!(shape.bytes, table.texture_bytes(shape.storage));
        // nothing smaller was enough
        let smaller = report.shapes[0].shapes.iter().filter(|other| other.bytes < shape.bytes);
        assert!(smaller.filter(|other| other.anywhere <= 0.99 * error).count() == 0);
    }
}

#[test]
fn the_time_asked_for_is_kept_and_what_it_cost_is_said() {
    let directory = tempfile::tempdir().unwrap();
    let output = furnace(directory.path(), &["cost", "--seconds", "4", "--json", "--out", "out"]);
    assert_eq!(output.status.code(), Some(0));
    let json: Value = serde_json::from_slice(&output.stdout).unwrap();
    // the full study takes some minutes; what is under way when time is up is finished, on a machine that may have other work
    let seconds = json["seconds"].as_f64().unwrap();
    assert!(seconds < 30.0, "{seconds} s");
    let text = output.stdout;
    assert!(String::from_utf8(text).unwrap().contains("\"left_out\": true"));
}

#[test]
fn wrong_usage_is_refused_before_the_work() {
    let directory = tempfile::tempdir().unwrap();
    fs::write(directory.path().join("file"), b"x").unwrap();
    for (arguments, reason) in [
        (&["cost", "--seconds", "0"][..], "seconds is a number in [1, 86400]"),
        (
            &["cost", "--material", "none-such"][..],
            "the scene has no material `none-such`",
        ),
        (&["cost", "--out", "file/below"][..], "file"),
        (&["cost", "missing.toml"][..], "missing.toml"),
    ] {
        let output = furnace(directory.path(), arguments);
        let errors = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {errors}");
        assert!(errors.contains(reason), "{arguments:?}: {errors}");
    }
}
