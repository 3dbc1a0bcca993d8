//! The error that a shader sees, against texels for each mapping of mu and against bytes for each storage.

use super::canvas::Canvas;
use super::figure::{Datum, Figure, Legend, Look, Panel, Series, draw};
use super::palette::LOOKS;
use super::scale::Kind;
use crate::cost::shape::{Shape, Shapes};
use crate::table::Storage;

/// Most materials that are shown.
const SHOWN: usize = 3;

/// A column for each of the first materials: above the mappings, below the storages of the best mapping.
pub fn tables(found: &[Shapes]) -> Canvas {
    let shown: Vec<&Shapes> = spread(found);
    let mappings = mappings(&shown);
    let above = shown.iter().map(|shapes| Panel {
        title: shapes.material.clone(),
        note: "mapping of mu, kept as f32".into(),
        x: "texels along mu",
        y: "largest error on the screen",
        kinds: [Kind::Octaves, Kind::Decades],
        series: mappings
            .iter()
            .zip(LOOKS)
            .map(|(mapping, look)| {
                let of = shapes
                    .shapes
                    .iter()
                    .filter(|shape| shape.storage == Storage::F32 && shape.mapping() == *mapping);
                let width = |shape: &Shape| shape.axes.first().map_or(1.0, |axis| axis.size as f64);
                series(format!("{} {mapping}", shapes.material), look, of, width)
            })
            .collect(),
    });
    let below = shown.iter().map(|shapes| {
        let best = best_mapping(shapes);
        Panel {
            title: shapes.material.clone(),
            note: format!("storage, {best}"),
            x: "bytes of the texture",
            y: "largest error on the screen",
            kinds: [Kind::Octaves, Kind::Decades],
            series: Storage::ALL
                .into_iter()
                .zip(LOOKS)
                .map(|(storage, look)| {
                    let of = shapes
                        .shapes
                        .iter()
                        .filter(|shape| shape.storage == storage && shape.mapping() == best);
                    let name = format!("{} {}", shapes.material, storage.name());
                    series(name, look, of, |shape| shape.bytes as f64)
                })
                .collect(),
        }
    });
    let entries = |names: Vec<String>| names.into_iter().zip(LOOKS).collect();
    let legend = vec![
        Legend {
            heading: "above: mapping",
            entries: entries(mappings.clone()),
        },
        Legend {
            heading: "below: storage",
            entries: entries(Storage::ALL.map(|storage| storage.name().to_owned()).to_vec()),
        },
    ];
    draw(&Figure {
        title: "What a shader sees between texels".into(),
        legend,
        panels: above.chain(below).collect(),
        columns: shown.len(),
        shared: [false, true],
        caption: vec![
            "Largest error of a linear-filtered lookup at random mu, the rounding of the storage included.".into(),
        ],
        margin: 4.0,
    })
}

/// Materials that have tables, evenly from the first to the last.
fn spread(found: &[Shapes]) -> Vec<&Shapes> {
    let with: Vec<&Shapes> = found.iter().filter(|shapes| !shapes.shapes.is_empty()).collect();
    let n = with.len().min(SHOWN);
    (0..n).map(|k| with[k * (with.len() - 1) / (n - 1).max(1)]).collect()
}

/// Every mapping, in the order of the tables.
fn mappings(shown: &[&Shapes]) -> Vec<String> {
    let mut names: Vec<String> = Vec::new();
    for shape in shown.iter().flat_map(|shapes| &shapes.shapes) {
        if !names.contains(&shape.mapping()) {
            names.push(shape.mapping());
        }
    }
    names
}

/// That of the table that errs least.
fn best_mapping(shapes: &Shapes) -> String {
    let least = shapes.shapes.iter().min_by(|a, b| a.max_error.total_cmp(&b.max_error));
    least.map_or_else(String::new, Shape::mapping)
}

fn series<'a>(name: String, look: Look, of: impl Iterator<Item = &'a Shape>, x: impl Fn(&Shape) -> f64) -> Series {
    Series {
        name,
        look,
        data: of.map(|shape| Datum::plain(x(shape), shape.max_error)).collect(),
        label: None,
    }
}
