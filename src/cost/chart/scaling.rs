//! How cost grows with the work.

use super::canvas::Canvas;
use super::figure::{Datum, Figure, Legend, Panel, Series, draw};
use super::palette::LOOKS;
use super::scale::Kind;
use crate::cost::Line;
use crate::cost::scaling::{Grown, Growth};

/// A panel each for texels, sharpness and digits.
pub fn scaling(found: &[Grown]) -> Canvas {
    let mut lobes: Vec<&str> = Vec::new();
    for grown in found {
        if !lobes.contains(&grown.lobe) {
            lobes.push(grown.lobe);
        }
    }
    let legend = lobes.iter().zip(LOOKS).map(|(lobe, look)| ((*lobe).to_owned(), look));
    draw(&Figure {
        title: "How the cost of quadrature grows with the work".into(),
        legend: vec![Legend {
            heading: "",
            entries: legend.collect(),
        }],
        panels: Growth::ALL
            .into_iter()
            .map(|growth| panel(found, &lobes, growth))
            .collect(),
        columns: 3,
        shared: [false, false],
        caption: vec![
            "Glass; where they do not grow: 32 texels of sqrt mu, a roughness of 0.2, a tolerance of 1e-6.".into(),
            "Beside curves: the exponent as a power of the texels; evaluations of a texel for each further digit."
                .into(),
        ],
        margin: 60.0,
    })
}

fn panel(found: &[Grown], lobes: &[&str], growth: Growth) -> Panel {
    let (title, note, x, y, kinds) = match growth {
        Growth::Texels => (
            "texels",
            "linear in texels",
            "texels",
            "CPU time of the table / s",
            [Kind::Decades, Kind::Decades],
        ),
        Growth::Sharpness => (
            "sharpness of the lobe",
            "no faster than logarithmic in 1/alpha",
            "1/alpha, 1/m",
            "evaluations of a texel",
            [Kind::Decades, Kind::Linear],
        ),
        Growth::Digits => (
            "digits",
            "grows with digits, no power of the error",
            "digits of the tolerance",
            "evaluations of a texel",
            [Kind::Linear, Kind::Linear],
        ),
    };
    let series = lobes.iter().zip(LOOKS).map(|(lobe, look)| {
        let of = found
            .iter()
            .filter(|grown| grown.growth == growth && grown.lobe == *lobe);
        let data: Vec<Datum> = of
            .filter_map(|grown| {
                let y = match growth {
                    Growth::Texels => grown.seconds?.cpu,
                    Growth::Sharpness | Growth::Digits => {
                        grown.seconds?;
                        grown.evaluations as f64 / grown.texels as f64
                    }
                };
                Some(Datum::plain(grown.value, y))
            })
            .collect();
        Series {
            name: format!("{lobe} {}", growth.name()),
            look,
            label: label(&data, growth),
            data,
        }
    });
    Panel {
        title: title.into(),
        note: note.into(),
        x,
        y,
        kinds,
        series: series.collect(),
    }
}

/// The law that the curve follows.
fn label(data: &[Datum], growth: Growth) -> Option<String> {
    let points: Vec<[f64; 2]> = data.iter().map(|datum| [datum.x, datum.y]).collect();
    match growth {
        Growth::Texels => Line::through_logarithms(&points).map(|line| format!("n^{:.2}", line.slope)),
        // neither rises all the way, nor falls
        Growth::Sharpness => None,
        Growth::Digits => Line::through(&points).map(|line| format!("{:+.0}/digit", line.slope)),
    }
}
