//! Error against samples, with the fitted order of each curve beside it.

use super::accuracy::{chosen, data, legend, samplings};
use super::canvas::Canvas;
use super::figure::{Figure, Panel, Series, draw};
use super::palette::{BACKGROUND, LOOKS};
use super::scale::Kind;
use crate::cost::families::Kin;
use crate::cost::ladder::{Accuracy, Curve};

/// Largest error over the table against the evaluations of a texel.
pub fn samples(studies: &[Accuracy]) -> Canvas {
    draw(&Figure {
        title: "How errors fall with evaluations".into(),
        legend: legend(),
        panels: studies.iter().map(panel).collect(),
        columns: 3,
        shared: [true, true],
        caption: vec![
            "Beside random curves: fitted exponent of the RMS error as a power of the samples, with its standard error.".into(),
            "Beside quadrature: evaluations of a texel for each further digit of tolerance. Hollow: below the error of the reference.".into(),
        ],
        margin: 66.0,
    })
}

fn panel(study: &Accuracy) -> Panel {
    let (best, others) = chosen(study);
    let texels = study.subject.texels() as f64;
    let series = |curve: &Curve, look, label| Series {
        name: format!("{} {}", study.subject.material, curve.estimator),
        look,
        data: data(curve, &study.reference, |point| point.evaluations() as f64 / texels),
        label,
    };
    let behind = others.into_iter().map(|curve| {
        let mut behind = series(curve, BACKGROUND, None);
        behind.data.iter_mut().for_each(|datum| datum.bar = None);
        behind
    });
    let front = best.iter().rev().map(|(kin, curve)| {
        let index = Kin::COMPARED.iter().position(|other| other == kin).unwrap_or_default();
        let label = match kin {
            Kin::Quadrature => curve
                .per_digit()
                .map(|line| format!("{:.0}/digit", line.slope / texels)),
            _ => curve
                .order(&study.reference)
                .map(|line| format!("{} \u{b1} {:.2}", signed(line.slope), line.slope_error)),
        };
        series(curve, LOOKS[index], label)
    });
    Panel {
        title: study.subject.material.clone(),
        note: samplings(&best),
        x: "evaluations of a texel",
        y: "largest error",
        kinds: [Kind::Decades, Kind::Decades],
        series: behind.chain(front).collect(),
    }
}

/// With a minus sign as wide as a digit.
fn signed(value: f64) -> String {
    format!("{value:.2}").replace('-', "\u{2212}")
}
