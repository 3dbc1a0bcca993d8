//! A drawing as a list of shapes, of which a vector file and a picture are made.

/// A colour, red, green and blue.
pub(super) type Colour = [u8; 3];

/// Where a text stands about its point.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Anchor {
    Start,
    Middle,
    End,
}

/// The shape of a marker, so that curves differ without their colours.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Shape {
    Circle,
    Square,
    Triangle,
    Diamond,
}

/// How a line is drawn.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Stroke {
    pub(super) colour: Colour,
    pub(super) width: f64,
    /// Lengths of dashes and gaps; none for a solid line.
    pub(super) dashes: &'static [f64],
}

/// One thing that is drawn, in units of a point, y downwards.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Item {
    /// A line through points.
    Line { points: Vec<[f64; 2]>, stroke: Stroke },
    /// A filled rectangle: left, top, width, height.
    Rectangle { at: [f64; 4], colour: Colour },
    /// A datum.
    Marker {
        shape: Shape,
        at: [f64; 2],
        colour: Colour,
        /// Filled, or with paper inside.
        filled: bool,
        /// The curve, and the numbers that it stands for, in the units of the axes.
        datum: Option<(String, [f64; 2])>,
    },
    /// Words.
    Text {
        at: [f64; 2],
        text: String,
        size: f64,
        bold: bool,
        anchor: Anchor,
        colour: Colour,
        /// Read from below to above.
        upright: bool,
    },
}

/// A drawing of a size.
#[derive(Debug, Clone, PartialEq)]
pub struct Canvas {
    pub(super) width: f64,
    pub(super) height: f64,
    pub(super) items: Vec<Item>,
    /// What it shows, in a sentence.
    pub(super) title: String,
}

/// Radius of a marker.
pub(super) const MARKER: f64 = 3.0;

pub(super) const INK: Colour = [0x22, 0x22, 0x22];
pub(super) const GREY: Colour = [0x66, 0x66, 0x66];
pub(super) const FAINT: Colour = [0xe2, 0xe2, 0xe2];
pub(super) const PALE: Colour = [0xc4, 0xc4, 0xc4];
pub(super) const PAPER: Colour = [0xff, 0xff, 0xff];

impl Stroke {
    pub(super) fn solid(colour: Colour, width: f64) -> Self {
        Self {
            colour,
            width,
            dashes: &[],
        }
    }
}

/// Corners of a marker about its centre; a circle has many.
pub(super) fn outline(shape: Shape, [x, y]: [f64; 2], radius: f64) -> Vec<[f64; 2]> {
    // shapes of about the same area
    let (corners, turn, scale) = match shape {
        Shape::Circle => (32, 0.0, 1.0),
        Shape::Square => (4, 0.125, 1.25),
        Shape::Triangle => (3, -0.25, 1.4),
        Shape::Diamond => (4, 0.0, 1.35),
    };
    (0..corners)
        .map(|k| {
            let angle = std::f64::consts::TAU * (f64::from(k) / f64::from(corners) + turn);
            [x + scale * radius * angle.cos(), y + scale * radius * angle.sin()]
        })
        .collect()
}

impl Canvas {
    pub(super) fn new(width: f64, height: f64, title: &str) -> Self {
        let paper = Item::Rectangle {
            at: [0.0, 0.0, width, height],
            colour: PAPER,
        };
        Self {
            width,
            height,
            items: vec![paper],
            title: title.into(),
        }
    }

    pub(super) fn line(&mut self, points: Vec<[f64; 2]>, stroke: Stroke) {
        self.items.push(Item::Line { points, stroke });
    }

    pub(super) fn text(&mut self, at: [f64; 2], text: &str, size: f64, anchor: Anchor, colour: Colour) {
        self.items.push(Item::Text {
            at,
            text: text.into(),
            size,
            bold: false,
            anchor,
            colour,
            upright: false,
        });
    }

    pub(super) fn bold(&mut self, at: [f64; 2], text: &str, size: f64, anchor: Anchor) {
        self.items.push(Item::Text {
            at,
            text: text.into(),
            size,
            bold: true,
            anchor,
            colour: INK,
            upright: false,
        });
    }

    pub(super) fn upright(&mut self, at: [f64; 2], text: &str, size: f64) {
        self.items.push(Item::Text {
            at,
            text: text.into(),
            size,
            bold: false,
            anchor: Anchor::Middle,
            colour: INK,
            upright: true,
        });
    }

    /// Number of markers that stand for data.
    pub fn data(&self) -> usize {
        let is_datum = |item: &&Item| matches!(item, Item::Marker { datum: Some(_), .. });
        self.items.iter().filter(is_datum).count()
    }
}
