//! A table as a texture: the numbers that a file holds in the storage format of a texture, and the lookup of graphics hardware.
//!
//! A [`Texture`] is what all texture formats are written from. Unlike a [`Table`] it has no error per texel: values are
//! those that the storage format holds, and errors are what a lookup anywhere in the domain was measured to be off by.

use super::axis::{Axis, AxisError, MAX_SIZE, TexelRule};
use super::{Storage, Table};
use crate::spectrum::Channels;
use thiserror::Error;

/// Most texels along each axis of a texture with three axes: what every current GPU takes.
pub const MAX_DEPTH_SIZE: usize = 256;

/// An axis of a texture, along or against the order of its texels.
#[derive(Debug, Clone, PartialEq)]
pub struct TextureAxis {
    /// Parameter, mapping and texel rule, see [`Axis`].
    pub axis: Axis,
    /// Whether the texture coordinate is 1 - u, so that the first texel belongs to the upper end of the axis.
    pub flipped: bool,
}

/// What one channel of a texture holds.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Channel {
    /// A short name, an identifier: `bias`, `total`.
    pub name: String,
    /// The formula or sentence that says what it is.
    pub meaning: String,
}

/// How far lookups are off, over a domain.
#[derive(Debug, Clone, PartialEq)]
pub struct LookupError {
    /// What is measured: the name of a channel, or `furnace`.
    pub of: String,
    /// Largest error found.
    pub max: f64,
    /// Mean error over the domain, uniform in every parameter.
    pub mean: f64,
    /// Where the largest was found: one value per axis, in the unit of that axis.
    pub at: Vec<f64>,
    /// The domain: lower and upper value per axis, in the unit of that axis.
    pub domain: Vec<[f64; 2]>,
    /// Number of places looked at.
    pub probes: u64,
}

/// The texels of a lookup table as a texture holds them.
#[derive(Debug, Clone, PartialEq)]
pub struct Texture {
    /// The stem of its file name.
    pub id: String,
    /// One to three axes, along width, height and depth.
    pub axes: Vec<TextureAxis>,
    /// One to four channels.
    pub channels: Vec<Channel>,
    /// How each channel of a texel is kept.
    pub storage: Storage,
    /// Values that `storage` holds exactly, channels fastest, then width, height, depth.
    pub values: Vec<f64>,
    /// Measured errors of lookups; empty where nobody has measured them.
    pub errors: Vec<LookupError>,
    /// Further facts by name, in the order in which people read them: lobe, masking, generator, how it was fitted.
    pub facts: Vec<(String, String)>,
}

/// A texture that no file can hold.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum TextureError {
    /// An axis cannot be sampled.
    #[error("texture {id}: {source}")]
    Axis {
        /// The texture.
        id: String,
        /// What is wrong with the axis.
        source: AxisError,
    },
    /// Sizes, channels or values that do not fit together.
    #[error("texture {id}: {reason}")]
    Shape {
        /// The texture.
        id: String,
        /// What does not fit.
        reason: String,
    },
    /// A value that the storage format cannot hold.
    #[error("texture {id}: {value} in channel {channel} at texel {texel:?} is beyond {storage}: choose f16 or f32", storage = storage.name())]
    Beyond {
        /// The texture.
        id: String,
        /// Name of the channel.
        channel: String,
        /// Column, row and slice.
        texel: [usize; 3],
        /// The refused value.
        value: f64,
        /// The format.
        storage: Storage,
    },
}

impl TextureAxis {
    /// An axis along the order of its texels.
    pub fn along(axis: Axis) -> Self {
        Self { axis, flipped: false }
    }

    /// The texture coordinate in [0, 1] at which hardware reads `value` of the parameter, scaling for
    /// [`TexelRule::Ends`] and flip included.
    pub fn coordinate(&self, value: f64) -> f64 {
        let n = self.axis.size as f64;
        let u = self.axis.u(value);
        let u = match self.axis.rule {
            TexelRule::Centres => u,
            TexelRule::Ends => u * ((n - 1.0) / n) + 0.5 / n,
        };
        if self.flipped { 1.0 - u } else { u }
    }

    /// The value of the parameter at texel `i` of `0..size`.
    pub fn texel(&self, i: usize) -> f64 {
        self.axis.texel(if self.flipped { self.axis.size - 1 - i } else { i })
    }

    /// The texture coordinate as an expression that GLSL, HLSL, MSL and WGSL all read.
    pub fn shader_expression(&self) -> String {
        let expression = self.axis.shader_expression();
        if self.flipped {
            format!("1.0 - ({expression})")
        } else {
            expression
        }
    }
}

impl Texture {
    /// The texture of `table` in `storage`: one channel `rho`, or of a pair `rho0` and `rho1`, or `red`, `green` and `blue`. A table
    /// without axes has one texel along `mu`.
    ///
    /// # Errors
    /// [`TextureError::Beyond`] where a value does not fit the storage format.
    pub fn of(table: &Table, storage: Storage) -> Result<Self, TextureError> {
        let named = |name: &str, meaning: &str| Channel {
            name: name.into(),
            meaning: meaning.into(),
        };
        let quantity = table.quantity.name();
        let channels = match table.channels {
            Channels::Grey => vec![named("rho", quantity)],
            Channels::Pair => vec![
                named(
                    "rho0",
                    &format!("{quantity} for r0 = 0 of Schlick's Fresnel term: of any r0 it is mix(rho0, rho1, r0)"),
                ),
                named("rho1", &format!("{quantity} for r0 = 1 of Schlick's Fresnel term")),
            ],
            Channels::Rgb => ["red", "green", "blue"]
                .map(|name| named(name, &format!("{quantity}, linear {name}")))
                .into(),
        };
        let values = table.values.iter();
        let mut texture = Self {
            id: table.id.clone(),
            axes: table.axes.iter().cloned().map(TextureAxis::along).collect(),
            channels,
            storage,
            values: values.flat_map(|value| table.channels.of(*value)).collect(),
            errors: Vec::new(),
            facts: [
                ("quantity", quantity),
                ("lobe", table.lobe.name()),
                ("estimator", &table.estimator),
            ]
            .map(|(name, value)| (name.to_owned(), value.to_owned()))
            .into(),
        };
        texture.facts.extend(table.parameters.iter().cloned());
        if texture.axes.is_empty() {
            let axis = Axis::mu(1).map_err(|source| TextureError::Axis {
                id: table.id.clone(),
                source,
            })?;
            texture.axes.push(TextureAxis::along(axis));
        }
        texture.rounded()
    }

    /// The texture with its values rounded to its storage format.
    ///
    /// # Errors
    /// [`TextureError`] where sizes do not fit together, or a value does not fit the format.
    pub fn rounded(mut self) -> Result<Self, TextureError> {
        self.check_shape()?;
        let [width, height, _] = self.size();
        let count = self.channels.len();
        for index in 0..self.values.len() {
            let value = self.values[index];
            if !self.storage.holds(value) {
                let texel = index / count;
                return Err(TextureError::Beyond {
                    id: self.id,
                    channel: self.channels[index % count].name.clone(),
                    texel: [texel % width, texel / width % height, texel / (width * height)],
                    value,
                    storage: self.storage,
                });
            }
            self.values[index] = self.storage.round(value);
        }
        Ok(self)
    }

    fn check_shape(&self) -> Result<(), TextureError> {
        let refuse = |reason: String| {
            Err(TextureError::Shape {
                id: self.id.clone(),
                reason,
            })
        };
        let [width, height, depth] = self.size();
        if !(1..=3).contains(&self.axes.len()) {
            return refuse(format!(
                "{} axes are not allowed: a texture has 1 to 3",
                self.axes.len()
            ));
        }
        if !(1..=4).contains(&self.channels.len()) {
            return refuse(format!(
                "{} channels are not allowed: a texture has 1 to 4",
                self.channels.len()
            ));
        }
        let most = if self.axes.len() == 3 { MAX_DEPTH_SIZE } else { MAX_SIZE };
        for TextureAxis { axis, .. } in &self.axes {
            axis.check().map_err(|source| TextureError::Axis {
                id: self.id.clone(),
                source,
            })?;
            if axis.size > most {
                let (name, size) = (&axis.parameter, axis.size);
                return refuse(format!("{size} texels along {name} are not allowed: at most {most}"));
            }
        }
        let expected = width * height * depth * self.channels.len();
        match self.values.len() {
            found if found != expected => refuse(format!("{found} values where the sizes ask for {expected}")),
            _ => Ok(()),
        }
    }

    /// Width, height and depth in texels.
    pub fn size(&self) -> [usize; 3] {
        [0, 1, 2].map(|k| self.axes.get(k).map_or(1, |axis| axis.axis.size))
    }

    /// Bytes of the texels, without padding.
    pub fn bytes(&self) -> usize {
        self.values.len() * self.storage.bytes()
    }

    /// The channels of the texel in column `x`, row `y` and slice `z`.
    pub fn texel(&self, [x, y, z]: [usize; 3]) -> &[f64] {
        let [width, height, _] = self.size();
        let start = ((z * height + y) * width + x) * self.channels.len();
        &self.values[start..start + self.channels.len()]
    }

    /// What hardware reads at texture coordinates in [0, 1], one per axis: linear filtering between texel centres at (i + 0.5)/n,
    /// clamped to the edge, with exact weights. NaN gives NaN.
    ///
    /// # Panics
    /// When `coordinates` does not hold exactly one value per axis.
    pub fn filtered(&self, coordinates: &[f64]) -> Vec<f64> {
        self.filtered_with(coordinates, None)
    }

    /// The same with weights rounded to so many bits: graphics hardware may keep as few as 8.
    ///
    /// # Panics
    /// When `coordinates` does not hold exactly one value per axis.
    pub fn filtered_with(&self, coordinates: &[f64], weight_bits: Option<u32>) -> Vec<f64> {
        assert_eq!(coordinates.len(), self.axes.len(), "one coordinate per axis");
        let size = self.size();
        let (mut low, mut high, mut weight) = ([0; 3], [0; 3], [0.0; 3]);
        for (k, coordinate) in coordinates.iter().enumerate() {
            let n = size[k] as f64;
            let position = (coordinate * n - 0.5).clamp(0.0, n - 1.0);
            low[k] = position.floor() as usize; // NaN becomes texel 0 and survives in the weight
            high[k] = (low[k] + 1).min(size[k] - 1);
            weight[k] = position - position.floor();
            if let Some(bits) = weight_bits {
                let steps = f64::from(1u32 << bits.min(24));
                weight[k] = (weight[k] * steps).round() / steps;
            }
        }
        let mut sum = vec![0.0; self.channels.len()];
        for corner in 0..1usize << self.axes.len() {
            let mut at = [0; 3];
            let mut share = 1.0;
            for k in 0..self.axes.len() {
                let is_high = corner >> k & 1 == 1;
                at[k] = if is_high { high[k] } else { low[k] };
                share *= if is_high { weight[k] } else { 1.0 - weight[k] };
            }
            for (sum, value) in sum.iter_mut().zip(self.texel(at)) {
                *sum += share * value;
            }
        }
        sum
    }

    /// What a shader reads for these values of the parameters, one per axis in the unit of that axis.
    ///
    /// # Panics
    /// When `parameters` does not hold exactly one value per axis.
    pub fn lookup(&self, parameters: &[f64]) -> Vec<f64> {
        let coordinates: Vec<f64> = self
            .axes
            .iter()
            .zip(parameters)
            .map(|(axis, value)| axis.coordinate(*value))
            .collect();
        self.filtered(&coordinates)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::table::axis::Mapping;
    use crate::table::samples::{grey_2d, rgb_1d, scalar};

    /// Two implementations of one lookup: that of a table scales the index, that of a texture the coordinate.
    #[test]
    fn lookups_are_those_of_the_table() {
        for (table, places) in [
            (grey_2d(), vec![[0.0, 0.5], [0.3, 17.0], [0.99, 1e9]]),
            (rgb_1d(), vec![[0.0, 0.0], [0.41, 0.0], [1.0, 0.0]]),
        ] {
            for storage in [Storage::F32, Storage::F16] {
                let texture = Texture::of(&table, storage).unwrap();
                for place in &places {
                    let place = &place[..table.axes.len()];
                    let expected = table.channels.of(table.sample_as(storage, place));
                    for (found, expected) in texture.lookup(place).iter().zip(&expected) {
                        // weights that are formed in two ways, of values up to 1
                        assert!((found - expected).abs() < 1e-12, "{place:?} {found} {expected}");
                    }
                }
            }
        }
        let one = Texture::of(&scalar(), Storage::F32).unwrap();
        assert_eq!(one.filtered(&[0.7]), vec![scalar().stored(0).x]);
    }

    #[test]
    fn a_flip_reads_the_same_from_mirrored_texels() {
        let table = rgb_1d();
        let plain = Texture::of(&table, Storage::F32).unwrap();
        let mut flipped = plain.clone();
        flipped.axes[0].flipped = true;
        flipped.values = plain.values.chunks(3).rev().flatten().copied().collect();
        for i in 0..=100 {
            let mu = f64::from(i) / 100.0;
            for (a, b) in plain.lookup(&[mu]).iter().zip(flipped.lookup(&[mu])) {
                assert!((a - b).abs() < 1e-13, "{mu}: {a} {b}"); // rounding of 1 - u
            }
        }
        let size = table.axes[0].size;
        assert!((0..size).all(|i| flipped.axes[0].texel(i) == plain.axes[0].texel(size - 1 - i)));
        assert_eq!(
            flipped.axes[0].shader_expression(),
            format!("1.0 - ({})", plain.axes[0].shader_expression())
        );
    }

    #[test]
    fn three_axes_are_interpolated_along_each() {
        let axis = |name: &str, size| {
            TextureAxis::along(Axis::new(name, Mapping::Linear, TexelRule::Ends, [0.0, 1.0], size).unwrap())
        };
        let channel = Channel {
            name: "sum".into(),
            meaning: "x + 10 y + 100 z".into(),
        };
        let (w, h, d) = (3, 4, 5);
        let value = |i: usize| {
            let [x, y, z] = [i % w, i / w % h, i / (w * h)].map(|i| i as f64);
            x / 2.0 + 10.0 * y / 3.0 + 100.0 * z / 4.0
        };
        let texture = Texture {
            id: "sum".into(),
            axes: vec![axis("x", w), axis("y", h), axis("z", d)],
            channels: vec![channel],
            storage: Storage::F32,
            values: (0..w * h * d).map(value).collect(),
            errors: Vec::new(),
            facts: Vec::new(),
        };
        let texture = texture.rounded().unwrap();
        let found = texture.lookup(&[0.3, 0.6, 0.9])[0];
        assert!((found - 96.3).abs() < 1e-5, "{found}"); // texels rounded to f32
        assert!(texture.lookup(&[0.3, f64::NAN, 0.9])[0].is_nan());
        let coarse = texture.filtered_with(&[0.5, 0.5, 0.61], Some(2))[0];
        assert!(
            (coarse - (0.5 + 5.0 + 100.0 * (2.0 + 0.5) / 4.0)).abs() < 1e-5,
            "{coarse}"
        );
    }

    #[test]
    fn what_does_not_fit_is_refused() {
        let texture = Texture::of(&rgb_1d(), Storage::F16).unwrap();
        let edited = |edit: &dyn Fn(&mut Texture)| {
            let mut texture = texture.clone();
            edit(&mut texture);
            texture.rounded().unwrap_err().to_string()
        };
        assert!(edited(&|texture| texture.values.truncate(3)).contains("3 values where the sizes ask for"));
        assert!(edited(&|texture| texture.axes.clear()).contains("0 axes are not allowed"));
        assert!(edited(&|texture| texture.channels.clear()).contains("0 channels are not allowed"));
        let beyond = edited(&|texture| {
            texture.storage = Storage::Unorm16;
            texture.values[4] = 1.5;
        });
        assert_eq!(
            beyond,
            format!(
                "texture {}: 1.5 in channel green at texel [1, 0, 0] is beyond unorm16: choose f16 or f32",
                texture.id
            )
        );
    }
}
