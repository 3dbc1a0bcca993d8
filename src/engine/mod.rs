//! Tables in the layouts that engines read, with texels fitted for what their lookups interpolate.

mod bake;
mod disney;
mod fit;
mod grid;
mod layout;
mod mean;
mod measure;
mod profile;
mod round;
mod sheet;
mod truth;

pub use bake::{Baked, DIELECTRIC_R0, SheetError, bake, work};
pub use profile::{LOBES, Profile, Sizes};
pub use sheet::{Along, Parameter, Sheet, Side, Term};
pub use truth::{Lobe, Place, Quantity, TruthError};
