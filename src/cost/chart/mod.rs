//! Charts for a paper: drawn once, written as SVG and as PNG.

mod accuracy;
mod canvas;
mod figure;
mod font;
mod palette;
mod png;
mod samples;
mod scale;
mod svg;

pub use accuracy::accuracy;
pub use canvas::Canvas;
pub use png::{PngError, to_png};
pub use samples::samples;
pub use svg::to_svg;
