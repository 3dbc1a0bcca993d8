//! Tables in the layouts that engines read, with texels fitted for what their lookups interpolate.

mod bake;
mod fit;
mod grid;
mod mean;
mod measure;
mod round;
mod sheet;
mod truth;

pub use bake::{DIELECTRIC_R0, SheetError, Texels, bake, work};
pub use sheet::{Along, Parameter, Sheet, Term};
pub use truth::{Lobe, Place, Quantity, TruthError};
