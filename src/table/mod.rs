//! A lookup table: values on a grid, the error of each, and the facts of its making.
//!
//! Values are computed in f64 and stored in f32. Whatever reports on a table speaks of the *stored* values, and what
//! the rounding costs is part of every error: the file has to keep its promise, not the arithmetic before it.

/// Declares an enum whose variants have names in files.
macro_rules! named {
    ($(#[$of_enum:meta])* $name:ident { $($(#[$of_variant:meta])* $variant:ident = $text:literal,)* }) => {
        $(#[$of_enum])*
        #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
        pub enum $name { $($(#[$of_variant])* $variant,)* }

        impl $name {
            /// The name in files, manifests and messages.
            pub fn name(self) -> &'static str {
                match self { $($name::$variant => $text,)* }
            }

            /// The variant called `name`, if there is one.
            pub fn from_name(name: &str) -> Option<Self> {
                match name { $($text => Some($name::$variant),)* _ => None }
            }
        }
    };
}

pub mod axis;
mod lookup;
pub mod names;
#[cfg(test)]
pub(crate) mod samples;
pub mod storage;
mod stored;
pub mod texture;

pub use storage::Storage;
pub use stored::Excess;

use crate::spectrum::Channels;
use axis::{Axis, AxisError};
use glam::DVec3;
use stored::round_up;
use thiserror::Error;

/// Largest number of texels of a table (16384 x 1024), so that every file written is one that is read back.
pub const MAX_TEXELS: usize = 1 << 24;

named!(
    /// The integral that a table holds.
    Quantity {
        /// Directional-hemispherical reflectance, a function of the fixed direction.
        RhoHd = "rho_hd",
        /// Hemispherical-hemispherical reflectance.
        RhoHh = "rho_hh",
    }
);

pub use crate::estimate::{ErrorKind, Lobe};

/// How far a linear-filtered lookup strays from the true value anywhere in the domain.
#[derive(Debug, Clone, PartialEq)]
pub struct Between {
    /// Largest absolute error found, rounding to the stored format included; infinite where the function itself grows
    /// without bound within the domain.
    pub error: f64,
    /// Where it occurs: one value per axis, in the unit of that axis.
    pub at: Vec<f64>,
    /// Number of places looked at.
    pub probes: u64,
}

/// The error of a lookup that a table was sized for.
#[derive(Debug, Clone, PartialEq)]
pub struct Goal {
    /// Largest absolute error of a linear-filtered lookup anywhere in the domain.
    pub tolerance: f64,
    /// Why lookups err by more, and what to do; `None` when they do not.
    pub unmet: Option<String>,
}

/// A lookup table of reflectance, with 0, 1 or 2 axes.
///
/// `values` and `errors` have one entry per texel, row-major: axis 0 runs along the image width and fastest, axis 1
/// along the height; row 0 comes first. A table without axes has one texel.
#[derive(Debug, Clone, PartialEq)]
pub struct Table {
    /// The name that it goes by: the stem of its file, see [`names`]. Nothing in the file depends on it.
    pub id: String,
    /// The integral.
    pub quantity: Quantity,
    /// The side that it covers.
    pub lobe: Lobe,
    /// At most two axes.
    pub axes: Vec<Axis>,
    /// How many channels of the values are independent; grey values fill all three alike.
    pub channels: Channels,
    /// Reflectance per texel, before rounding to f32.
    pub values: Vec<DVec3>,
    /// Bound or half-width per texel, see `error_kind`, before rounding to f32.
    pub errors: Vec<DVec3>,
    /// What `errors` mean.
    pub error_kind: ErrorKind,
    /// Names and values of the parameters that are constant over the table.
    pub parameters: Vec<(String, String)>,
    /// Name of the estimator that computed it.
    pub estimator: String,
    /// Largest absolute error asked for.
    pub tolerance: f64,
    /// Integrand evaluations over all texels.
    pub evaluations: u64,
    /// Seed of the random streams.
    pub seed: u64,
    /// The lookup error that axes and sizes were chosen for; `None` where they were given.
    pub goal: Option<Goal>,
    /// The error between texels; `None` while nobody has measured it.
    pub between: Option<Between>,
}

/// A table that must not be written.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum TableError {
    /// An axis cannot be sampled.
    #[error("table {id}: {source}")]
    Axis {
        /// The table.
        id: String,
        /// What is wrong with the axis.
        source: AxisError,
    },
    /// Sizes that do not fit together, or facts that a file cannot hold.
    #[error("table {id}: {reason}")]
    Shape {
        /// The table.
        id: String,
        /// What does not fit.
        reason: String,
    },
    /// A value or error that is NaN, infinite, beyond f32, or a negative error.
    #[error("table {id}: {what} {value} at texel {texel:?} is not allowed: {allowed}")]
    Texel {
        /// The table.
        id: String,
        /// `value` or `error`.
        what: &'static str,
        /// Column and row.
        texel: [usize; 2],
        /// The refused number.
        value: f64,
        /// What would be legal.
        allowed: &'static str,
    },
}

impl Table {
    /// The table itself when it may be written.
    ///
    /// # Errors
    /// Those of [`Table::check`].
    pub fn checked(self) -> Result<Self, TableError> {
        self.check()?;
        Ok(self)
    }

    /// Whether sizes fit together and all numbers are finite in the stored format.
    ///
    /// # Errors
    /// [`TableError`] naming the axis, the sizes, or the texel and its value.
    pub fn check(&self) -> Result<(), TableError> {
        self.check_shape()?;
        self.check_facts()?;
        let [width, _] = self.size();
        for (i, (value, error)) in self.values.iter().zip(&self.errors).enumerate() {
            let refuse = |what, value, allowed| TableError::Texel {
                id: self.id.clone(),
                what,
                texel: [i % width, i / width],
                value,
                allowed,
            };
            for channel in 0..3 {
                if !(value[channel] as f32).is_finite() {
                    return Err(refuse("value", value[channel], "values are finite and fit f32"));
                }
                if !(error[channel] >= 0.0 && round_up(error[channel]).is_finite()) {
                    return Err(refuse(
                        "error",
                        error[channel],
                        "errors are finite, fit f32 and are >= 0",
                    ));
                }
            }
            if self.channels == Channels::Grey && (*value != DVec3::splat(value.x) || *error != DVec3::splat(error.x)) {
                return Err(refuse("value", value.y, "a grey table has three equal channels"));
            }
        }
        Ok(())
    }

    fn check_shape(&self) -> Result<(), TableError> {
        for axis in &self.axes {
            axis.check().map_err(|source| TableError::Axis {
                id: self.id.clone(),
                source,
            })?;
        }
        if self.axes.len() > 2 {
            return Err(self.refuse(format!("{} axes, where an image has at most 2", self.axes.len())));
        }
        let [width, height] = self.size();
        let texels = width * height;
        if texels > MAX_TEXELS {
            return Err(self.refuse(format!("{width} x {height} texels are more than {MAX_TEXELS}")));
        }
        if self.values.len() != texels || self.errors.len() != texels {
            let (values, errors) = (self.values.len(), self.errors.len());
            return Err(self.refuse(format!(
                "{values} values and {errors} errors for {width} x {height} texels"
            )));
        }
        Ok(())
    }

    fn check_facts(&self) -> Result<(), TableError> {
        if !(self.tolerance >= 0.0 && self.tolerance.is_finite()) {
            return Err(self.refuse(format!("tolerance {} is not finite and >= 0", self.tolerance)));
        }
        for (i, (name, _)) in self.parameters.iter().enumerate() {
            // Files keep "name = value" lines and the manifest a JSON object.
            if name.is_empty() || name.contains('=') || name.trim() != name {
                return Err(self.refuse(format!("parameter name {name:?} is empty or holds '=' or outer spaces")));
            }
            if self.parameters[..i].iter().any(|(other, _)| other == name) {
                return Err(self.refuse(format!("parameter {name:?} occurs twice")));
            }
        }
        if let Some(goal) = &self.goal
            && !(goal.tolerance >= 0.0 && goal.tolerance.is_finite())
        {
            return Err(self.refuse(format!("lookup tolerance {} is not finite and >= 0", goal.tolerance)));
        }
        let Some(between) = &self.between else { return Ok(()) };
        if between.error.is_nan() || between.error < 0.0 {
            return Err(self.refuse(format!("error between texels {} is not >= 0", between.error)));
        }
        if between.at.len() != self.axes.len() || between.at.iter().any(|value| !value.is_finite()) {
            return Err(self.refuse(format!(
                "error between texels at {:?}, not one value per axis",
                between.at
            )));
        }
        Ok(())
    }

    fn refuse(&self, reason: String) -> TableError {
        TableError::Shape {
            id: self.id.clone(),
            reason,
        }
    }

    /// Width and height in texels; 1 for an axis that the table has not.
    pub fn size(&self) -> [usize; 2] {
        let size = |k: usize| self.axes.get(k).map_or(1, |axis| axis.size);
        [size(0), size(1)]
    }

    /// The axis values of texel `i`.
    pub fn texel_values(&self, i: usize) -> Vec<f64> {
        let [width, _] = self.size();
        let index = [i % width, i / width];
        self.axes.iter().zip(index).map(|(axis, k)| axis.texel(k)).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::table::samples::{grey_2d, scalar};

    #[test]
    fn tables_that_must_not_be_written_are_refused() {
        assert_eq!(grey_2d().check(), Ok(()));
        assert_eq!(scalar().check(), Ok(()));
        let refused = |edit: &dyn Fn(&mut Table)| {
            let mut table = grey_2d();
            edit(&mut table);
            table.checked().unwrap_err().to_string()
        };
        let nan = refused(&|table| table.values[9].y = f64::NAN);
        assert!(nan.contains("value NaN at texel [1, 1]"), "{nan}");
        for (edit, reason) in [
            (
                (|table| table.values[0] = DVec3::splat(1e39)) as fn(&mut Table),
                "fit f32",
            ),
            (|table| table.errors[0] = DVec3::splat(-1e-9), "error -0.000000001"),
            (|table| table.errors[0] = DVec3::INFINITY, "error inf"),
            (|table| table.values[0].z = 0.25, "three equal channels"),
            (|table| table.values.truncate(31), "31 values"),
            (|table| table.axes.push(Axis::mu(1).unwrap()), "3 axes"),
            (|table| table.axes[0].size = 0, "0 texels"),
            (|table| table.tolerance = f64::NAN, "tolerance NaN"),
            (
                |table| table.goal.as_mut().unwrap().tolerance = f64::INFINITY,
                "lookup tolerance inf",
            ),
            (|table| table.parameters[0].0 = "a=b".into(), "a=b"),
            (|table| table.parameters.push(table.parameters[0].clone()), "twice"),
            (
                |table| table.between.as_mut().unwrap().at.clear(),
                "not one value per axis",
            ),
            (
                |table| table.axes.iter_mut().for_each(|axis| axis.size = 16384),
                "more than",
            ),
        ] {
            let error = refused(&edit);
            assert!(error.contains(reason), "{error}");
        }
    }
}
