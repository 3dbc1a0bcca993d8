//! Small multiples: panels in a grid, one legend above them that covers no data, words below.

use super::canvas::{Anchor, Canvas, Colour, FAINT, GREY, INK, Item, Shape, Stroke};
use super::font;
use super::scale::{Kind, Scale};

/// How the curve of one meaning looks in every panel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Look {
    pub(super) stroke: Stroke,
    /// None for a bare line.
    pub(super) marker: Option<Shape>,
}

/// One datum.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Datum {
    pub(super) x: f64,
    pub(super) y: f64,
    /// Ends of the bar of spread.
    pub(super) bar: Option<[f64; 2]>,
    /// Drawn hollow: an upper bound.
    pub(super) hollow: bool,
}

/// One curve.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Series {
    /// In data attributes.
    pub(super) name: String,
    pub(super) look: Look,
    pub(super) data: Vec<Datum>,
    /// Beside its end.
    pub(super) label: Option<String>,
}

/// One plot.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Panel {
    pub(super) title: String,
    /// Small, below the title.
    pub(super) note: String,
    pub(super) x: &'static str,
    pub(super) y: &'static str,
    pub(super) kinds: [Kind; 2],
    pub(super) series: Vec<Series>,
}

/// A row of the legend.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Legend {
    /// Before the entries, in bold; may be empty.
    pub(super) heading: &'static str,
    pub(super) entries: Vec<(String, Look)>,
}

/// All of it.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Figure {
    pub(super) title: String,
    pub(super) legend: Vec<Legend>,
    pub(super) panels: Vec<Panel>,
    pub(super) columns: usize,
    /// Whether all panels have the same axes.
    pub(super) shared: [bool; 2],
    /// Lines below the panels.
    pub(super) caption: Vec<String>,
    /// Room at the right of a panel for labels of curves.
    pub(super) margin: f64,
}

const PANEL: [f64; 2] = [232.0, 178.0];
const LEFT: f64 = 58.0;
const TOP: f64 = 34.0;
const BOTTOM: f64 = 38.0;
const EDGE: f64 = 16.0;
const SMALL: f64 = 9.0;
const NORMAL: f64 = 10.5;
const LARGE: f64 = 14.0;

impl Datum {
    pub(super) fn plain(x: f64, y: f64) -> Self {
        Self {
            x,
            y,
            bar: None,
            hollow: false,
        }
    }
}

impl Panel {
    fn values(&self, axis: usize) -> impl Iterator<Item = f64> + '_ {
        let data = self.series.iter().flat_map(|series| &series.data);
        data.flat_map(move |datum| match axis {
            0 => vec![datum.x],
            _ => [datum.y].into_iter().chain(datum.bar.into_iter().flatten()).collect(),
        })
    }
}

/// Draws everything.
pub(super) fn draw(figure: &Figure) -> Canvas {
    let columns = figure.columns.min(figure.panels.len()).max(1);
    let rows = figure.panels.len().div_ceil(columns);
    let cell = [LEFT + PANEL[0] + figure.margin + 6.0, TOP + PANEL[1] + BOTTOM];
    let lines = figure.caption.iter().map(|line| font::width(line, SMALL, false));
    let text = lines.fold(font::width(&figure.title, LARGE, true), f64::max);
    let width = EDGE + text.max(columns as f64 * cell[0]) + EDGE;
    let legend = legend_rows(&figure.legend, width - 2.0 * EDGE);
    let head = EDGE + 24.0 + 18.0 * legend.len() as f64 + 8.0;
    let foot = 14.0 * figure.caption.len() as f64 + EDGE;
    let mut canvas = Canvas::new(width, head + rows as f64 * cell[1] + foot, &figure.title);
    canvas.bold([EDGE, EDGE + 12.0], &figure.title, LARGE, Anchor::Start);
    for (row, (heading, entries)) in legend.iter().enumerate() {
        let y = EDGE + 36.0 + 18.0 * row as f64;
        canvas.bold([EDGE, y + 3.7], heading, NORMAL, Anchor::Start);
        draw_legend(&mut canvas, entries, y);
    }
    let common = [0, 1].map(|axis| {
        let kind = figure.panels.first().map_or(Kind::Linear, |panel| panel.kinds[axis]);
        Scale::around(kind, figure.panels.iter().flat_map(|panel| panel.values(axis)))
    });
    for (index, panel) in figure.panels.iter().enumerate() {
        let (column, row) = (index % columns, index / columns);
        let corner = [EDGE + column as f64 * cell[0] + LEFT, head + row as f64 * cell[1] + TOP];
        let scales = [0, 1].map(|axis| match figure.shared[axis] {
            true => common[axis],
            false => Scale::around(panel.kinds[axis], panel.values(axis)),
        });
        draw_panel(&mut canvas, panel, corner, scales);
    }
    for (line, text) in figure.caption.iter().enumerate() {
        let y = head + rows as f64 * cell[1] + 14.0 * line as f64 + 6.0;
        canvas.text([EDGE, y], text, SMALL, Anchor::Start, GREY);
    }
    canvas
}

type Entry<'a> = (&'a str, Look, f64);

/// Entries with their left ends, each group in as many rows as it needs.
fn legend_rows(groups: &[Legend], width: f64) -> Vec<(&'static str, Vec<Entry<'_>>)> {
    let indent = groups
        .iter()
        .map(|group| font::width(group.heading, NORMAL, true))
        .fold(0.0, f64::max);
    let indent = if indent > 0.0 { indent + 14.0 } else { 0.0 };
    let mut rows: Vec<(&'static str, Vec<Entry<'_>>)> = Vec::new();
    for group in groups {
        rows.push((group.heading, Vec::new()));
        let mut x = indent;
        for (text, look) in &group.entries {
            let needed = 34.0 + font::width(text, NORMAL, false) + 18.0;
            if x > indent && x + needed > width {
                rows.push(("", Vec::new()));
                x = indent;
            }
            if let Some((_, row)) = rows.last_mut() {
                row.push((text, *look, EDGE + x));
            }
            x += needed;
        }
    }
    rows
}

fn draw_legend(canvas: &mut Canvas, entries: &[Entry<'_>], y: f64) {
    for (text, look, x) in entries {
        canvas.line(vec![[*x, y], [x + 28.0, y]], look.stroke);
        if let Some(shape) = look.marker {
            canvas.items.push(Item::Marker {
                shape,
                at: [x + 14.0, y],
                colour: look.stroke.colour,
                filled: true,
                datum: None,
            });
        }
        canvas.text([x + 34.0, y + 3.7], text, NORMAL, Anchor::Start, INK);
    }
}

fn draw_panel(canvas: &mut Canvas, panel: &Panel, [left, top]: [f64; 2], scales: [Scale; 2]) {
    let [width, height] = PANEL;
    let at = |x: f64, y: f64| {
        [
            left + width * scales[0].place(x),
            top + height * (1.0 - scales[1].place(y)),
        ]
    };
    canvas.bold([left, top - 18.0], &panel.title, NORMAL, Anchor::Start);
    canvas.text([left, top - 6.0], &panel.note, SMALL, Anchor::Start, GREY);
    for (value, name) in scales[0].marks() {
        let x = at(value, scales[1].min)[0];
        canvas.line(vec![[x, top], [x, top + height]], Stroke::solid(FAINT, 0.7));
        canvas.text([x, top + height + 13.0], &name, SMALL, Anchor::Middle, INK);
    }
    for (value, name) in scales[1].marks() {
        let y = at(scales[0].min, value)[1];
        canvas.line(vec![[left, y], [left + width, y]], Stroke::solid(FAINT, 0.7));
        canvas.text([left - 5.0, y + 3.2], &name, SMALL, Anchor::End, INK);
    }
    let corners = [[0.0, 0.0], [0.0, height], [width, height]];
    let frame = corners.map(|[x, y]| [left + x, top + y]).to_vec();
    canvas.line(frame, Stroke::solid(INK, 0.9));
    canvas.text(
        [left + 0.5 * width, top + height + 27.0],
        panel.x,
        SMALL + 0.5,
        Anchor::Middle,
        INK,
    );
    canvas.upright([left - 40.0, top + 0.5 * height], panel.y, SMALL + 0.5);
    // lines below all markers
    for series in &panel.series {
        for run in shown(&series.data, &scales) {
            let line: Vec<[f64; 2]> = run.iter().map(|datum| at(datum.x, datum.y)).collect();
            if line.len() > 1 {
                canvas.line(line, series.look.stroke);
            }
        }
    }
    let mut labels = Vec::new();
    for series in &panel.series {
        for datum in shown(&series.data, &scales).into_iter().flatten() {
            draw_datum(canvas, series, datum, &scales, at);
        }
        if let (Some(label), Some(last)) = (&series.label, series.data.last()) {
            labels.push((at(last.x, last.y)[1], label.as_str(), series.look.stroke.colour));
        }
    }
    draw_labels(canvas, labels, left + width + 6.0, [top, top + height]);
}

fn draw_datum(
    canvas: &mut Canvas,
    series: &Series,
    datum: &Datum,
    scales: &[Scale; 2],
    at: impl Fn(f64, f64) -> [f64; 2],
) {
    let colour = series.look.stroke.colour;
    if let Some(bar) = datum.bar {
        let [x, low] = at(datum.x, bar[0].max(scales[1].min));
        let [_, high] = at(datum.x, bar[1]);
        for line in [
            [[x, low], [x, high]],
            [[x - 2.5, low], [x + 2.5, low]],
            [[x - 2.5, high], [x + 2.5, high]],
        ] {
            canvas.line(line.to_vec(), Stroke::solid(colour, 0.9));
        }
    }
    if let Some(shape) = series.look.marker {
        canvas.items.push(Item::Marker {
            shape,
            at: at(datum.x, datum.y),
            colour,
            filled: !datum.hollow,
            datum: Some((series.name.clone(), [datum.x, datum.y])),
        });
    }
}

/// Runs of data that the axes can show.
fn shown<'a>(data: &'a [Datum], scales: &[Scale; 2]) -> Vec<&'a [Datum]> {
    let fits = |datum: &Datum| {
        let places = [scales[0].place(datum.x), scales[1].place(datum.y)];
        places.iter().all(|place| (-1e-9..=1.0 + 1e-9).contains(place))
    };
    data.split(|datum| !fits(datum)).filter(|run| !run.is_empty()).collect()
}

/// Words at the right of the panel, as high as the ends of their curves, moved apart where they would cover each other.
fn draw_labels(canvas: &mut Canvas, mut labels: Vec<(f64, &str, Colour)>, x: f64, [top, bottom]: [f64; 2]) {
    const STEP: f64 = 10.5;
    labels.sort_by(|(a, ..), (b, ..)| a.total_cmp(b));
    let mut next = top;
    let mut ys = Vec::new();
    for (y, ..) in &labels {
        ys.push(y.max(next));
        next = ys.last().copied().unwrap_or(next) + STEP;
    }
    // back from below, where the last ones left the panel
    let mut limit = bottom + 4.0;
    for y in ys.iter_mut().rev() {
        *y = y.min(limit);
        limit = *y - STEP;
    }
    for ((_, text, colour), y) in labels.into_iter().zip(ys) {
        canvas.text([x, y + 3.2], text, SMALL, Anchor::Start, colour);
    }
}
