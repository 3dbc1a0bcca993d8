//! A table as an engine expects it, before it is computed.

use super::truth::{Lobe, Place, Quantity};
use crate::masking::Masking;
use crate::table::Storage;
use crate::table::axis::{Axis, AxisError, Mapping, TexelRule};
use crate::table::texture::{Channel, TextureAxis};

/// What an axis runs over, from 0 to 1.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Parameter {
    /// cos theta_o.
    Mu,
    /// Perceptual roughness r, alpha = r^2.
    Roughness,
    /// The parameter of the distribution itself.
    Alpha,
    /// z = sqrt(|eta - 1|/(eta + 1)), the fourth root of the reflectance at normal incidence. From outside eta = (1 + z^2)/(1 - z^2), from
    /// inside its inverse.
    Z(Side),
}

/// Where light comes from that meets an interface.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Side {
    /// From the medium of the smaller index.
    Outside,
    /// From that of the larger one: beyond an angle all is reflected.
    Inside,
}

/// Largest index that an axis of z reaches, the largest legal one; it stands for those beyond.
const LARGEST_ETA: f64 = 100.0;

/// z of [`LARGEST_ETA`], sqrt(99/101).
const LARGEST_Z: f64 = 0.990_049_502_487_531_2;

/// The index of interfaces without an axis of it: that of a varnish, r0 = 0.04.
const COAT_ETA: f64 = 1.5;

impl Parameter {
    /// The name as a shader variable.
    pub fn name(self) -> &'static str {
        match self {
            Self::Mu => "mu",
            Self::Roughness => "roughness",
            Self::Alpha => "alpha",
            Self::Z(_) => "z",
        }
    }
}

/// One axis of a sheet.
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

    /// Where errors count: mu from 0.01, roughness from 0.05 on. Below, lobes are mirrors but for a layer at grazing angles that no
    /// texture of such size resolves. All indices to 100 count.
    pub fn domain(&self) -> [f64; 2] {
        match self.parameter {
            Parameter::Mu => [0.01, 1.0],
            Parameter::Roughness => [0.05, 1.0],
            Parameter::Alpha => [0.0025, 1.0],
            Parameter::Z(_) => [0.0, LARGEST_Z],
        }
    }

    /// All that the axis is for: z to the largest index, everything else from 0 to 1.
    pub(super) fn whole(&self) -> [f64; 2] {
        match self.parameter {
            Parameter::Z(_) => [0.0, LARGEST_Z],
            _ => [0.0, 1.0],
        }
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
    /// The mean of what the first channel of a sheet before reads, over mu: of E the E_avg.
    Mean,
    /// The mean of Loss of a sheet before, 1 - E_avg.
    MeanLoss,
    /// Albedo of sheen.
    Sheen,
    /// Albedo of Burley's diffuse lobe less 1/2.
    DisneyDiffuse,
    /// Share that an interface reflects.
    Reflected,
    /// Share that it lets through.
    Transmitted,
    /// Both together.
    Interface,
}

impl Term {
    /// A short name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Scale => "scale",
            Self::Bias => "bias",
            Self::Total => "total",
            Self::Loss => "loss",
            Self::Mean => "mean",
            Self::MeanLoss => "mean_loss",
            Self::Sheen => "sheen",
            Self::DisneyDiffuse => "diffuse",
            Self::Reflected => "reflected",
            Self::Transmitted => "transmitted",
            Self::Interface => "interface",
        }
    }

    /// What it is.
    pub fn meaning(self) -> &'static str {
        match self {
            Self::Scale => "A of rho(r0) = r0 A + B",
            Self::Bias => "B of rho(r0) = r0 A + B: rho for r0 = 0 of Schlick's Fresnel term",
            Self::Total => "E = A + B: rho for r0 = 1",
            Self::Loss => "1 - E, E = A + B: what one reflection loses where F = 1",
            Self::Mean => "2 int E mu dmu of the E that lookups read",
            Self::MeanLoss => "1 - 2 int E mu dmu of the E that lookups read",
            Self::Sheen => "rho of Charlie sheen of colour 1, visibility of Ashikhmin and Neubelt",
            Self::DisneyDiffuse => "rho of Burley's diffuse lobe, divided by 1.03571, less 1/2",
            Self::Reflected => "share that the interface reflects",
            Self::Transmitted => "share that the interface lets through",
            Self::Interface => "share that the interface reflects or lets through: less is lost between facets",
        }
    }

    /// The channel of a texture.
    pub(super) fn channel(self) -> Channel {
        Channel {
            name: self.name().into(),
            meaning: self.meaning().into(),
        }
    }

    /// How the stored number follows from a quantity: (quantity, constant, sign), stored = constant + sign quantity; `None` for means.
    pub(super) fn code(self) -> Option<(Quantity, f64, f64)> {
        match self {
            Self::Scale | Self::Total => Some((Quantity::Total, 0.0, 1.0)),
            Self::Bias => Some((Quantity::Bias, 0.0, 1.0)),
            Self::Loss => Some((Quantity::Total, 1.0, -1.0)),
            Self::Sheen => Some((Quantity::Sheen, 0.0, 1.0)),
            Self::DisneyDiffuse => Some((Quantity::DisneyDiffuse, -0.5, 1.0)),
            Self::Reflected => Some((Quantity::Reflected, 0.0, 1.0)),
            Self::Transmitted => Some((Quantity::Transmitted, 0.0, 1.0)),
            Self::Interface => Some((Quantity::Interface, 0.0, 1.0)),
            Self::Mean | Self::MeanLoss => None,
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
    /// One to three axes, along width, height and depth.
    pub axes: Vec<Along>,
    /// One to four channels.
    pub channels: Vec<Term>,
    /// How the engine keeps a channel.
    pub storage: Storage,
}

impl Sheet {
    /// Where an integral is wanted for these values along the axes.
    pub(super) fn place(&self, values: &[f64]) -> Place {
        let mut place = Place {
            mu: 1.0,
            alpha: 0.0,
            eta: COAT_ETA,
        };
        for (along, value) in self.axes.iter().zip(values) {
            match along.parameter {
                Parameter::Mu => place.mu = *value,
                Parameter::Roughness => place.alpha = value * value,
                Parameter::Alpha => place.alpha = *value,
                Parameter::Z(side) => {
                    let eta = ((1.0 + value * value) / (1.0 - value * value)).min(LARGEST_ETA);
                    place.eta = if side == Side::Outside { eta } else { 1.0 / eta };
                }
            }
        }
        place
    }

    /// Where errors count, see [`Along::domain`].
    pub fn domain(&self) -> Vec<[f64; 2]> {
        self.axes.iter().map(Along::domain).collect()
    }

    /// The integrals that its channels are made of, each once; E comes with B, which cost one integral together.
    pub(super) fn quantities(&self) -> Vec<Quantity> {
        let mut quantities: Vec<Quantity> = self.channels.iter().filter_map(|term| Some(term.code()?.0)).collect();
        if quantities.contains(&Quantity::Bias) {
            quantities.push(Quantity::Total);
        }
        quantities.sort();
        quantities.dedup();
        quantities
    }

    /// Places along each axis that are enough, and all that time allows, where there are three axes, or where integrals take a hundred
    /// times as long as those of a pair, as of sheen and of interfaces.
    pub(super) fn slow_places(&self) -> Option<usize> {
        let slow = [Term::Sheen, Term::Reflected, Term::Transmitted, Term::Interface];
        match self.axes.len() {
            3 => Some(32),
            _ => self.channels.iter().any(|term| slow.contains(term)).then_some(96),
        }
    }

    /// Whether what texels leave that are not fitted is worth a look beside those that are.
    pub(super) fn is_compared(&self) -> bool {
        self.axes.len() == 2 && !self.is_mean()
    }

    /// Names of distribution and masking of all lobes that its channels are of.
    pub(super) fn lobes(&self) -> (String, String) {
        let has = |wanted: &dyn Fn(&Term) -> bool| self.channels.iter().any(wanted);
        let lobe = has(&|term| !matches!(term, Term::Sheen | Term::DisneyDiffuse));
        let parts = [
            (lobe, self.lobe.family.name(), self.lobe.masking.name()),
            (has(&|term| *term == Term::Sheen), "charlie", Masking::Neubelt.name()),
        ];
        let names = |of: fn(&(bool, &'static str, &'static str)) -> &'static str| {
            let names: Vec<&str> = parts.iter().filter(|part| part.0).map(of).collect();
            names.join("; ")
        };
        (names(|part| part.1), names(|part| part.2))
    }

    /// Whether it is a mean of a sheet before it.
    pub(super) fn is_mean(&self) -> bool {
        self.quantities().is_empty()
    }
}
