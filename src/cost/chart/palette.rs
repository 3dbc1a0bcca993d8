//! Which meaning has which look. Colours are those of Okabe and Ito, told apart with any eyes; dashes and markers tell the
//! curves apart without any colour.

use super::canvas::{INK, PALE, Shape, Stroke};
use super::figure::Look;

const BLUE: [u8; 3] = [0x00, 0x72, 0xb2];
const GREEN: [u8; 3] = [0x00, 0x9e, 0x73];
const ORANGE: [u8; 3] = [0xd5, 0x5e, 0x00];

/// Four looks, from the most to the least of something.
pub(super) const LOOKS: [Look; 4] = [
    look(INK, &[], Shape::Circle),
    look(BLUE, &[7.0, 2.5], Shape::Square),
    look(GREEN, &[3.5, 2.5], Shape::Triangle),
    look(ORANGE, &[1.2, 2.2], Shape::Diamond),
];

/// What is there for comparison.
pub(super) const BACKGROUND: Look = Look {
    stroke: Stroke {
        colour: PALE,
        width: 0.9,
        dashes: &[],
    },
    marker: None,
};

const fn look(colour: [u8; 3], dashes: &'static [f64], marker: Shape) -> Look {
    Look {
        stroke: Stroke {
            colour,
            width: 1.5,
            dashes,
        },
        marker: Some(marker),
    }
}
