//! Charts for a paper: drawn once, written as SVG and as PNG.

mod accuracy;
mod canvas;
mod figure;
mod font;
mod palette;
mod png;
mod samples;
mod scale;
mod scaling;
mod svg;
mod tables;

pub use accuracy::accuracy;
pub use canvas::Canvas;
pub use png::{PngError, to_png};
pub use samples::samples;
pub use scaling::scaling;
pub use svg::to_svg;
pub use tables::tables;

use super::report::Report;

/// All charts of a study, with the stems of their files.
pub fn all(report: &Report) -> [(&'static str, Canvas); 4] {
    [
        ("accuracy", accuracy(&report.accuracy)),
        ("samples", samples(&report.accuracy)),
        ("tables", tables(&report.shapes)),
        ("scaling", scaling(&report.scaling)),
    ]
}
