//! Drawings as SVG.

use super::canvas::{Anchor, Canvas, Colour, INK, Item, MARKER, PAPER, Stroke, outline};
use super::font::FAMILY;
use std::fmt::Write;

/// The whole file.
pub fn to_svg(canvas: &Canvas) -> String {
    let (width, height) = (canvas.width, canvas.height);
    let mut out = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{height}\" viewBox=\"0 0 {width} {height}\" \
         role=\"img\" font-family=\"{FAMILY}\">\n<title>{}</title>\n",
        escaped(&canvas.title)
    );
    for item in &canvas.items {
        out.push_str(&element(item));
        out.push('\n');
    }
    out.push_str("</svg>\n");
    out
}

fn element(item: &Item) -> String {
    match item {
        Item::Line { points, stroke } => {
            format!(
                "<path d=\"{}\" fill=\"none\"{}/>",
                path(points, false),
                of_stroke(stroke)
            )
        }
        Item::Rectangle {
            at: [x, y, w, h],
            colour,
        } => {
            format!(
                "<rect x=\"{x:.2}\" y=\"{y:.2}\" width=\"{w:.2}\" height=\"{h:.2}\" fill=\"{}\"/>",
                hex(*colour)
            )
        }
        Item::Marker {
            shape,
            at,
            colour,
            filled,
            datum,
        } => {
            let fill = if *filled { *colour } else { PAPER };
            let data = datum.as_ref().map_or_else(String::new, |(series, [x, y])| {
                format!(
                    " class=\"datum\" data-series=\"{}\" data-x=\"{x:e}\" data-y=\"{y:e}\"",
                    escaped(series)
                )
            });
            format!(
                "<path d=\"{}\" fill=\"{}\" stroke=\"{}\" stroke-width=\"1\"{data}/>",
                path(&outline(*shape, *at, MARKER), true),
                hex(fill),
                hex(*colour)
            )
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
            let mut attributes = format!("x=\"{x:.2}\" y=\"{y:.2}\" font-size=\"{size}\"");
            // a String takes what is written to it
            let _ = match anchor {
                Anchor::Start => Ok(()),
                Anchor::Middle => write!(attributes, " text-anchor=\"middle\""),
                Anchor::End => write!(attributes, " text-anchor=\"end\""),
            };
            if *bold {
                attributes.push_str(" font-weight=\"bold\"");
            }
            if *upright {
                let _ = write!(attributes, " transform=\"rotate(-90 {x:.2} {y:.2})\"");
            }
            let fill = if *colour == INK { hex(INK) } else { hex(*colour) };
            format!("<text {attributes} fill=\"{fill}\">{}</text>", escaped(text))
        }
    }
}

fn path(points: &[[f64; 2]], closed: bool) -> String {
    let mut out = String::new();
    for (index, [x, y]) in points.iter().enumerate() {
        let _ = write!(out, "{}{x:.2} {y:.2}", if index == 0 { 'M' } else { 'L' });
    }
    if closed {
        out.push('Z');
    }
    out
}

fn of_stroke(stroke: &Stroke) -> String {
    let mut out = format!(
        " stroke=\"{}\" stroke-width=\"{}\" stroke-linejoin=\"round\"",
        hex(stroke.colour),
        stroke.width
    );
    if !stroke.dashes.is_empty() {
        let dashes: Vec<String> = stroke.dashes.iter().map(f64::to_string).collect();
        let _ = write!(out, " stroke-dasharray=\"{}\"", dashes.join(" "));
    }
    out
}

fn hex([r, g, b]: Colour) -> String {
    format!("#{r:02x}{g:02x}{b:02x}")
}

/// Text as XML has it; what XML has no way to say at all becomes a box.
fn escaped(text: &str) -> String {
    let mut out = String::new();
    for letter in text.chars() {
        match letter {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            c if c.is_control() || c == '\u{fffe}' || c == '\u{ffff}' => out.push('\u{fffd}'),
            c => out.push(c),
        }
    }
    out
}
