//! Error against CPU time, a panel for each material.

use super::canvas::Canvas;
use super::figure::{Datum, Figure, Legend, Panel, Series, draw};
use super::palette::{BACKGROUND, LOOKS};
use super::scale::Kind;
use crate::cost::families::Kin;
use crate::cost::ladder::{Accuracy, Curve, Reference};

/// Largest error over the table against the CPU seconds that the table takes.
pub fn accuracy(studies: &[Accuracy]) -> Canvas {
    let texels = studies
        .iter()
        .map(|study| study.subject.texels())
        .max()
        .unwrap_or_default();
    let seeds = studies.iter().flat_map(|study| &study.curves);
    let seeds = seeds
        .flat_map(|curve| curve.points())
        .map(|point| point.runs.len())
        .max();
    draw(&Figure {
        title: "What accuracy costs: error of a table against the time to compute it".into(),
        legend: legend(),
        panels: studies.iter().map(panel).collect(),
        columns: 3,
        shared: [true, true],
        caption: vec![
            format!(
                "Markers: geometric mean of {} seeds; bars: smallest and largest. Hollow: below the error of the reference, \
                 which is shown instead.",
                seeds.unwrap_or(1)
            ),
            format!(
                "Tables of {texels} texels, a quarter of that for measured samples. Above each panel: of each kind of points the \
                 sampling that does most with its time; all others are grey."
            ),
        ],
        margin: 4.0,
    })
}

/// What the curves of the materials mean.
pub(super) fn legend() -> Vec<Legend> {
    let compared = Kin::COMPARED.iter().zip(LOOKS);
    let mut legend: Vec<_> = compared.map(|(kin, look)| (kin.name().to_owned(), look)).collect();
    legend.push(("other samplings".into(), BACKGROUND));
    vec![Legend {
        heading: "",
        entries: legend,
    }]
}

/// The best of each kind, and all the others behind them.
pub(super) fn chosen(study: &Accuracy) -> (Vec<(Kin, &Curve)>, Vec<&Curve>) {
    let best: Vec<(Kin, &Curve)> = Kin::COMPARED
        .into_iter()
        .filter_map(|kin| Some((kin, study.best(kin)?)))
        .collect();
    let is_best = |curve: &Curve| best.iter().any(|(_, best)| best.estimator == curve.estimator);
    let others = study.curves.iter().filter(|curve| !is_best(curve)).collect();
    (best, others)
}

/// The samplings of the best curves: `all visible`, or `qmc visible, mc bxdf` where they differ.
pub(super) fn samplings(best: &[(Kin, &Curve)]) -> String {
    let random = best.iter().filter(|(kin, _)| *kin != Kin::Quadrature);
    let split: Vec<(&str, &str)> = random
        .filter_map(|(_, curve)| curve.estimator.name().split_once('-'))
        .collect();
    match split.first() {
        Some((_, first)) if split.iter().all(|(_, sampling)| sampling == first) => format!("all {first}"),
        _ => {
            let each: Vec<String> = split
                .iter()
                .map(|(kin, sampling)| format!("{kin} {sampling}"))
                .collect();
            each.join(", ")
        }
    }
}

/// Data of a curve; errors that the reference does not resolve stand at its own.
pub(super) fn data(
    curve: &Curve,
    reference: &Reference,
    x: impl Fn(&crate::cost::ladder::Point<'_>) -> f64,
) -> Vec<Datum> {
    let points = curve.points();
    let datum = points.iter().map(|point| {
        let [low, mean, high] = point.max_errors();
        let hollow = mean <= reference.error;
        Datum {
            x: x(point),
            y: mean.max(reference.error),
            bar: (point.runs.len() > 1 && !hollow).then_some([low, high]),
            hollow,
        }
    });
    datum.collect()
}

fn panel(study: &Accuracy) -> Panel {
    let (best, others) = chosen(study);
    let series = |curve: &Curve, look| Series {
        name: format!("{} {}", study.subject.material, curve.estimator),
        look,
        data: data(curve, &study.reference, |point| point.cpu()),
        label: None,
    };
    let behind = others.into_iter().map(|curve| {
        let mut behind = series(curve, BACKGROUND);
        behind.data.iter_mut().for_each(|datum| datum.bar = None);
        behind
    });
    // the best in front
    let front = best.iter().rev().map(|(kin, curve)| {
        let index = Kin::COMPARED.iter().position(|other| other == kin).unwrap_or_default();
        series(curve, LOOKS[index])
    });
    Panel {
        title: study.subject.material.clone(),
        note: samplings(&best),
        x: "CPU time of the table / s",
        y: "largest error",
        kinds: [Kind::Decades, Kind::Decades],
        series: behind.chain(front).collect(),
    }
}
