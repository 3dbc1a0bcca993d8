//! What one test found.

use glam::DVec3;
use std::fmt;

/// What is tested.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Test {
    /// rho_hd <= 1 from above.
    Energy,
    /// rho_hd <= 1 from below, of models that transmit.
    EnergyBelow,
    /// f of a coupling averages to its stated albedo.
    WhiteFurnace,
    /// f(wo, wi) = f(wi, wo).
    Reciprocity,
    /// Specular directions lead back with the same throughput.
    ReciprocityOfDeltas,
    /// int pdf <= 1.
    Density,
    /// `sample_f` draws from `pdf`.
    Directions,
    /// weight = f |cos|/pdf.
    Weights,
    /// Weights average to rho_hd.
    Albedo,
    /// int D (n.h) dh = 1.
    Normals,
    /// int G1 max(0, o.h) D dh = n.o.
    VisibleNormals,
    /// The Fresnel term is the exact one.
    Fresnel,
    /// A table belongs to the scene and is the file that was written.
    TableContents,
    /// Texels agree with deterministic integrals.
    TableTexels,
    /// Texels agree with Monte Carlo integrals.
    TableSamples,
    /// Lookups between texels err no more than stated.
    TableLookup,
}

impl Test {
    /// Its name in reports.
    pub fn name(self) -> &'static str {
        match self {
            Self::Energy => "energy",
            Self::EnergyBelow => "energy from below",
            Self::WhiteFurnace => "white furnace",
            Self::Reciprocity => "reciprocity",
            Self::ReciprocityOfDeltas => "reciprocity of deltas",
            Self::Density => "density",
            Self::Directions => "directions",
            Self::Weights => "weights",
            Self::Albedo => "albedo",
            Self::Normals => "normals",
            Self::VisibleNormals => "visible normals",
            Self::Fresnel => "fresnel",
            Self::TableContents => "contents",
            Self::TableTexels => "texels",
            Self::TableSamples => "texels, sampled",
            Self::TableLookup => "lookup",
        }
    }
}

/// A number with its name, and what it is measured against.
#[derive(Debug, Clone, PartialEq)]
pub struct Statistic {
    /// What it is: `chi2`, `max rho`, ...
    pub name: &'static str,
    /// Its value.
    pub value: f64,
    /// Degrees of freedom or the number of scores that it is the largest of.
    pub of: Option<u64>,
}

impl Statistic {
    /// A number that stands for itself.
    pub fn new(name: &'static str, value: f64) -> Self {
        Self { name, value, of: None }
    }

    /// A number that means something only beside `of`.
    pub fn of(name: &'static str, value: f64, of: u64) -> Self {
        Self {
            of: Some(of),
            ..Self::new(name, value)
        }
    }
}

impl fmt::Display for Statistic {
    /// `chi2 = 123.40 / 118`
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} = ", self.name)?;
        match (self.value, self.of) {
            (value, _) if value.is_infinite() => write!(f, "unbounded")?,
            (value, Some(_)) => write!(f, "{value:.2}")?,
            (0.0, None) => write!(f, "0")?,
            (value, None) if !(1e-3..1e5).contains(&value.abs()) => write!(f, "{value:.1e}")?,
            (value, None) => write!(f, "{value:.6}")?,
        }
        self.of.map_or(Ok(()), |of| write!(f, " / {of}"))
    }
}

/// What a statistic says about the hypothesis that everything is right.
#[derive(Debug, Clone, PartialEq)]
pub enum Evidence {
    /// The probability of a statistic at least as bad, by chance.
    Chance(f64),
    /// Chance has no part in it: it holds or not.
    Certain(bool),
    /// The test could not be made; why.
    Skipped(String),
}

/// Where something was found.
#[derive(Debug, Clone, PartialEq)]
pub enum Place {
    /// A direction: theta from the normal and azimuth, in degrees.
    Direction([f64; 2]),
    /// wo and wi.
    Pair([[f64; 2]; 2]),
    /// A place on the axes of a table, by their names.
    Axes(Vec<(String, f64)>),
    /// A file.
    File(String),
}

impl Place {
    /// The place of a direction.
    pub fn direction(w: DVec3) -> Self {
        Self::Direction(degrees(w))
    }

    /// The place of two directions.
    pub fn pair(wo: DVec3, wi: DVec3) -> Self {
        Self::Pair([degrees(wo), degrees(wi)])
    }
}

/// theta in [0, 180] and phi of a direction in degrees.
fn degrees(w: DVec3) -> [f64; 2] {
    let radius = w.x.hypot(w.y);
    // + 0 makes 0 of -0
    [radius.atan2(w.z), w.y.atan2(w.x)].map(|angle| angle.to_degrees() + 0.0)
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Direction([theta, phi]) => {
                write!(f, "theta {} phi {}", Angle(*theta), Angle(*phi))
            }
            Self::Pair([[theta_o, phi_o], [theta_i, phi_i]]) => write!(
                f,
                "theta_o {} phi_o {}, theta_i {} phi_i {}",
                Angle(*theta_o),
                Angle(*phi_o),
                Angle(*theta_i),
                Angle(*phi_i)
            ),
            Self::Axes(axes) if axes.is_empty() => f.write_str("its only texel"),
            Self::Axes(axes) => {
                for (index, (name, value)) in axes.iter().enumerate() {
                    let comma = if index > 0 { ", " } else { "" };
                    match *value {
                        small if small != 0.0 && small < 1e-3 => write!(f, "{comma}{name} = {small:.2e}")?,
                        value => write!(f, "{comma}{name} = {value:.6}")?,
                    }
                }
                Ok(())
            }
            Self::File(name) => f.write_str(name),
        }
    }
}

/// An angle in degrees, with more digits close to the horizon and to the normal.
struct Angle(f64);

impl fmt::Display for Angle {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let text = format!("{:.4}", self.0);
        let text = text.trim_end_matches('0').trim_end_matches('.');
        f.write_str(if text == "-0" { "0" } else { text })
    }
}

/// What one test found.
#[derive(Debug, Clone, PartialEq)]
pub struct Outcome {
    /// What was tested.
    pub test: Test,
    /// What it came to; `None` when it could not be made.
    pub statistic: Option<Statistic>,
    /// What that means.
    pub evidence: Evidence,
    /// Where the worst case lies.
    pub worst: Option<Place>,
    /// What else is worth knowing.
    pub note: Option<String>,
}

impl Outcome {
    /// A test that could not be made.
    pub fn skipped(test: Test, reason: impl fmt::Display) -> Self {
        Self {
            test,
            statistic: None,
            evidence: Evidence::Skipped(reason.to_string()),
            worst: None,
            note: None,
        }
    }

    /// A comparison in which chance has no part.
    pub fn certain(test: Test, statistic: Statistic, holds: bool) -> Self {
        Self {
            test,
            statistic: Some(statistic),
            evidence: Evidence::Certain(holds),
            worst: None,
            note: None,
        }
    }

    /// A statistical test with p-value `p`.
    pub fn chance(test: Test, statistic: Statistic, p: f64) -> Self {
        Self {
            test,
            statistic: Some(statistic),
            evidence: Evidence::Chance(p),
            worst: None,
            note: None,
        }
    }

    /// The same with a place.
    pub fn at(self, worst: impl Into<Option<Place>>) -> Self {
        Self {
            worst: worst.into(),
            ..self
        }
    }

    /// The same with a note.
    pub fn noted(self, note: impl Into<Option<String>>) -> Self {
        Self {
            note: note.into(),
            ..self
        }
    }
}
