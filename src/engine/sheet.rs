//! A table as an engine expects it, before it is computed.

use super::truth::{Lobe, Place, Quantity};
use crate::table::Storage;
use crate::table::axis::{Axis, AxisError, Mapping, TexelRule};
use crate::table::texture::TextureAxis;

/// What an axis runs over.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Parameter {
    /// cos theta_o.
    Mu,
    /// Perceptual roughness r, alpha = r^2.
    Roughness,
    /// The parameter of the distribution itself.
    Alpha,
}

impl Parameter {
    /// The name as a shader variable.
    pub fn name(self) -> &'static str {
        match self {
            Self::Mu => "mu",
            Self::Roughness => "roughness",
            Self::Alpha => "alpha",
        }
    }
}

/// One axis of a sheet; every parameter runs over [0, 1].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Along {
    /// What it runs over.
    pub parameter: Parameter,
    /// How coordinate and value correspond.
    pub mapping: Mapping,
    /// Where texels sit.
    pub rule: TexelRule,
    /// Whether the texture coordinate is 1 - u.
    pub flipped: bool,
    /// Number of texels.
    pub size: usize,
}

impl Along {
    /// The axis of a texture.
    ///
    /// # Errors
    /// [`AxisError`] for a size that no axis has.
    pub fn axis(&self) -> Result<TextureAxis, AxisError> {
        let axis = Axis::new(self.parameter.name(), self.mapping, self.rule, [0.0, 1.0], self.size)?;
        Ok(TextureAxis {
            axis,
            flipped: self.flipped,
        })
    }
}

/// What a channel holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Term {
    /// A of r0 A + B.
    Scale,
    /// B of r0 A + B, which is the albedo for r0 = 0.
    Bias,
    /// E = A + B, the albedo for r0 = 1.
    Total,
    /// 1 - E, what a single reflection loses.
    Loss,
    /// E_avg = 2 int_0^1 E mu dmu of the E that lookups in the sheet before read.
    MeanTotal,
    /// 1 - E_avg of the same.
    MeanLoss,
    /// Nothing: the engine reads no such channel.
    Unused,
}

impl Term {
    /// A short name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Scale => "scale",
            Self::Bias => "bias",
            Self::Total => "total",
            Self::Loss => "loss",
            Self::MeanTotal => "mean",
            Self::MeanLoss => "mean_loss",
            Self::Unused => "unused",
        }
    }

    /// What it is.
    pub fn meaning(self) -> &'static str {
        match self {
            Self::Scale => "A of rho(r0) = r0 A + B",
            Self::Bias => "B of rho(r0) = r0 A + B: rho for r0 = 0 of Schlick's Fresnel term",
            Self::Total => "E = A + B: rho for r0 = 1",
            Self::Loss => "1 - E, E = A + B: what one reflection loses where F = 1",
            Self::MeanTotal => "E_avg = 2 int E mu dmu of the E that lookups read",
            Self::MeanLoss => "1 - E_avg, E_avg = 2 int E mu dmu of the E that lookups read",
            Self::Unused => "0",
        }
    }

    /// How the channel follows from fitted quantities: constant, and a factor for each.
    pub(super) fn parts(self) -> &'static [(Quantity, f64)] {
        match self {
            Self::Scale => &[(Quantity::Total, 1.0), (Quantity::Bias, -1.0)],
            Self::Bias => &[(Quantity::Bias, 1.0)],
            Self::Total => &[(Quantity::Total, 1.0)],
            Self::Loss => &[(Quantity::Total, -1.0)],
            Self::MeanTotal | Self::MeanLoss | Self::Unused => &[],
        }
    }
}

/// A table of an engine.
#[derive(Debug, Clone, PartialEq)]
pub struct Sheet {
    /// The stem of its file.
    pub name: &'static str,
    /// What the engine uses it for.
    pub purpose: &'static str,
    /// The lobes that it serves.
    pub lobe: Lobe,
    /// One or two axes, along width and height.
    pub axes: Vec<Along>,
    /// One to four channels.
    pub channels: Vec<Term>,
    /// How the engine keeps a channel.
    pub storage: Storage,
}

impl Sheet {
    /// Where an integral is wanted for these values along the axes.
    pub(super) fn place(&self, values: &[f64]) -> Place {
        let mut place = Place { mu: 1.0, alpha: 0.0 };
        for (along, value) in self.axes.iter().zip(values) {
            match along.parameter {
                Parameter::Mu => place.mu = *value,
                Parameter::Roughness => place.alpha = value * value,
                Parameter::Alpha => place.alpha = *value,
            }
        }
        place
    }

    /// Where errors count: mu from 0.01, roughness from 0.05 on. Below, lobes are mirrors but for a layer at grazing angles that no
    /// texture of this size resolves.
    pub fn domain(&self) -> Vec<[f64; 2]> {
        let from = |along: &Along| match along.parameter {
            Parameter::Mu => 0.01,
            Parameter::Roughness => 0.05,
            Parameter::Alpha => 0.0025,
        };
        self.axes.iter().map(|along| [from(along), 1.0]).collect()
    }
}
