//! Drawings as PNG.

use super::canvas::{Anchor, Canvas, Colour, Item, MARKER, PAPER, Stroke as Line, outline};
use super::font;
use std::fmt;
use tiny_skia::{FillRule, LineJoin, Paint, Path, PathBuilder, Pixmap, Rect, Stroke, StrokeDash, Transform};
use ttf_parser::OutlineBuilder;

/// Pixels of a unit.
const SCALE: f32 = 2.0;

/// A drawing without pixels, or too many.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PngError(String);

impl fmt::Display for PngError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "the picture cannot be drawn: {}", self.0)
    }
}

impl std::error::Error for PngError {}

/// The whole file.
///
/// # Errors
/// [`PngError`] for a canvas of no size.
pub fn to_png(canvas: &Canvas) -> Result<Vec<u8>, PngError> {
    let size = |length: f64| (length as f32 * SCALE).ceil() as u32;
    let (width, height) = (size(canvas.width), size(canvas.height));
    let mut pixels = Pixmap::new(width, height).ok_or_else(|| PngError(format!("{width} x {height} pixels")))?;
    for item in &canvas.items {
        draw(&mut pixels, item);
    }
    pixels.encode_png().map_err(|error| PngError(error.to_string()))
}

fn draw(pixels: &mut Pixmap, item: &Item) {
    let view = Transform::from_scale(SCALE, SCALE);
    match item {
        Item::Line { points, stroke } => stroke_path(pixels, along(points, false), stroke),
        Item::Rectangle { at, colour } => {
            let [x, y, w, h] = at.map(|value| value as f32);
            if let Some(area) = Rect::from_xywh(x, y, w, h) {
                pixels.fill_rect(area, &paint(*colour), view, None);
            }
        }
        Item::Marker {
            shape,
            at,
            colour,
            filled,
            ..
        } => {
            let shape = along(&outline(*shape, *at, MARKER), true);
            fill_path(pixels, shape.as_ref(), if *filled { *colour } else { PAPER }, view);
            stroke_path(pixels, shape, &Line::solid(*colour, 1.0));
        }
        Item::Text {
            at: [x, y],
            text,
            size,
            bold,
            anchor,
            colour,
            upright,
        } => {
            let width = font::width(text, *size, *bold);
            let shift = match anchor {
                Anchor::Start => 0.0,
                Anchor::Middle => -0.5 * width,
                Anchor::End => -width,
            };
            let mut pen = Pen::default();
            font::draw(text, *bold, &mut pen, |pen, offset, unit| {
                pen.origin = (shift + offset * size) as f32;
                pen.unit = (unit * size) as f32;
            });
            let turn = if *upright { -90.0 } else { 0.0 };
            let place = view.pre_translate(*x as f32, *y as f32).pre_rotate(turn);
            fill_path(pixels, pen.path.finish().as_ref(), *colour, place);
        }
    }
}

fn along(points: &[[f64; 2]], closed: bool) -> Option<Path> {
    let mut path = PathBuilder::new();
    for (index, [x, y]) in points.iter().enumerate() {
        let (x, y) = (*x as f32, *y as f32);
        if index == 0 {
            path.move_to(x, y)
        } else {
            path.line_to(x, y)
        }
    }
    if closed {
        path.close();
    }
    path.finish()
}

fn fill_path(pixels: &mut Pixmap, path: Option<&Path>, colour: Colour, place: Transform) {
    if let Some(path) = path {
        pixels.fill_path(path, &paint(colour), FillRule::Winding, place, None);
    }
}

fn stroke_path(pixels: &mut Pixmap, path: Option<Path>, line: &Line) {
    let dashes = line.dashes.iter().map(|length| *length as f32).collect();
    let stroke = Stroke {
        width: line.width as f32,
        line_join: LineJoin::Round,
        // no dashes are no pattern
        dash: StrokeDash::new(dashes, 0.0),
        ..Stroke::default()
    };
    if let Some(path) = path {
        let view = Transform::from_scale(SCALE, SCALE);
        pixels.stroke_path(&path, &paint(line.colour), &stroke, view, None);
    }
}

fn paint([r, g, b]: Colour) -> Paint<'static> {
    let mut paint = Paint::default();
    paint.set_color_rgba8(r, g, b, 0xff);
    paint.anti_alias = true;
    paint
}

/// Collects outlines of letters.
#[derive(Default)]
struct Pen {
    path: PathBuilder,
    origin: f32,
    unit: f32,
}

impl Pen {
    /// Fonts count y upwards.
    fn at(&self, x: f32, y: f32) -> (f32, f32) {
        (self.origin + x * self.unit, -y * self.unit)
    }
}

impl OutlineBuilder for Pen {
    fn move_to(&mut self, x: f32, y: f32) {
        let (x, y) = self.at(x, y);
        self.path.move_to(x, y);
    }

    fn line_to(&mut self, x: f32, y: f32) {
        let (x, y) = self.at(x, y);
        self.path.line_to(x, y);
    }

    fn quad_to(&mut self, x1: f32, y1: f32, x: f32, y: f32) {
        let ((x1, y1), (x, y)) = (self.at(x1, y1), self.at(x, y));
        self.path.quad_to(x1, y1, x, y);
    }

    fn curve_to(&mut self, x1: f32, y1: f32, x2: f32, y2: f32, x: f32, y: f32) {
        let ((x1, y1), (x2, y2), (x, y)) = (self.at(x1, y1), self.at(x2, y2), self.at(x, y));
        self.path.cubic_to(x1, y1, x2, y2, x, y);
    }

    fn close(&mut self) {
        self.path.close();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cost::chart::canvas::{INK, Shape};

    #[test]
    fn pictures_hold_what_was_drawn() {
        let mut canvas = Canvas::new(40.0, 20.0, "test");
        canvas.items.push(Item::Marker {
            shape: Shape::Circle,
            at: [10.0, 10.0],
            colour: [0, 114, 178],
            filled: true,
            datum: None,
        });
        canvas.text([20.0, 14.0], "m", 12.0, Anchor::Start, INK);
        let pixels = Pixmap::decode_png(&to_png(&canvas).unwrap()).unwrap();
        assert_eq!((pixels.width(), pixels.height()), (80, 40));
        let at = |x: u32, y: u32| {
            let colour = pixels.pixel(x, y).unwrap().demultiply();
            [colour.red(), colour.green(), colour.blue()]
        };
        assert_eq!(at(20, 20), [0, 114, 178], "the marker");
        assert_eq!(at(2, 2), PAPER);
        let inked = (40..64).flat_map(|x| (12..30).map(move |y| (x, y)));
        assert!(inked.filter(|(x, y)| at(*x, *y) == INK).count() > 20, "the letter");
        assert!(to_png(&Canvas::new(0.0, 5.0, "none")).is_err());
    }
}
