//! Letters: widths for the layout, outlines for pictures. The font comes along, because not every machine has one.

use std::sync::LazyLock;
use ttf_parser::{Face, GlyphId, OutlineBuilder};

/// What vector files ask their viewers for; widths of the others are close enough for the layout.
pub(super) const FAMILY: &str = "DejaVu Sans, Verdana, Geneva, sans-serif";

static REGULAR: LazyLock<Face<'static>> = LazyLock::new(|| face(include_bytes!("../data/DejaVuSans-subset.ttf")));
static BOLD: LazyLock<Face<'static>> = LazyLock::new(|| face(include_bytes!("../data/DejaVuSans-Bold-subset.ttf")));

fn face(bytes: &'static [u8]) -> Face<'static> {
    Face::parse(bytes, 0).unwrap_or_else(|error| unreachable!("{error}"))
}

fn of(bold: bool) -> &'static Face<'static> {
    if bold { &BOLD } else { &REGULAR }
}

/// The letter, or the box that stands for one that the font does not have.
fn glyph(face: &Face<'_>, letter: char) -> GlyphId {
    face.glyph_index(letter).unwrap_or(GlyphId(0))
}

fn advance(face: &Face<'_>, letter: char) -> f64 {
    let units = face.glyph_hor_advance(glyph(face, letter)).unwrap_or(0);
    f64::from(units) / f64::from(face.units_per_em())
}

/// Width of `text` at `size`.
pub(super) fn width(text: &str, size: f64, bold: bool) -> f64 {
    size * text.chars().map(|letter| advance(of(bold), letter)).sum::<f64>()
}

/// Draws the outlines of `text` to `pen`, which is told of each letter how far from the start of the text it stands, in units
/// of the size.
pub(super) fn draw<P: OutlineBuilder>(text: &str, bold: bool, pen: &mut P, mut place: impl FnMut(&mut P, f64, f64)) {
    let face = of(bold);
    let mut x = 0.0;
    for letter in text.chars() {
        place(pen, x, 1.0 / f64::from(face.units_per_em()));
        face.outline_glyph(glyph(face, letter), pen);
        x += advance(face, letter);
    }
}

/// A power of ten with raised digits, 10 to the `exponent`.
pub(super) fn power_of_ten(exponent: i32) -> String {
    const RAISED: [char; 10] = [
        '\u{2070}', '\u{b9}', '\u{b2}', '\u{b3}', '\u{2074}', '\u{2075}', '\u{2076}', '\u{2077}', '\u{2078}',
        '\u{2079}',
    ];
    let raise = |letter: char| match letter.to_digit(10) {
        Some(digit) => RAISED[digit as usize],
        None => '\u{207b}',
    };
    match exponent {
        0 => "1".into(),
        1 => "10".into(),
        _ => format!("10{}", exponent.to_string().chars().map(raise).collect::<String>()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_font_has_all_letters_of_charts() {
        let raised = power_of_ten(-1_234_567_890);
        assert!(raised.starts_with("10\u{207b}\u{b9}"));
        let letters = (' '..='~')
            .chain(raised.chars())
            .chain("\u{2212}\u{b1}\u{b5}\u{d7}\u{b7}\u{221a}\u{3b1}".chars());
        for letter in letters {
            assert!(REGULAR.glyph_index(letter).is_some(), "{letter:?}");
        }
        assert!((' '..='~').all(|letter| BOLD.glyph_index(letter).is_some()));
    }

    #[test]
    fn widths_add_up() {
        assert_eq!(width("", 10.0, false), 0.0);
        let (one, two) = (width("m", 10.0, false), width("mm", 10.0, false));
        assert!(one > 5.0 && (two - 2.0 * one).abs() < 1e-12);
        assert!(width("m", 10.0, true) > one);
    }
}
