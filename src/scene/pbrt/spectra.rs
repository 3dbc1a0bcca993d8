//! Colours and indices of refraction of a pbrt scene as linear RGB.

use super::lookup::Files;
use super::parameters::{Kind, Parameter, Values};
use crate::measured::cie::SpectralSamples;
use crate::measured::index::{ConductorIndex, NAMES, VISIBLE_NM};
use crate::scene::error::SceneError;
use std::path::PathBuf;

/// A spectrum as linear RGB.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Tone {
    pub(super) rgb: [f64; 3],
    /// What stands in where the colour lies outside the triangle of the primaries, though no value of the spectrum is wrong:
    /// the mean over visible wavelengths, or the luminance. Colours that are given as RGB have none.
    pub(super) mean: Option<f64>,
}

/// From XYZ to linear RGB with the primaries of Rec. 709 and D65, to the digits of pbrt 3's matrix.
const RGB_OF_XYZ: [[f64; 3]; 3] = [
    [3.240479, -1.537150, -0.498535],
    [-0.969256, 1.875991, 0.041556],
    [0.055648, -0.204043, 1.057311],
];

/// Second radiation constant h c/k, in nm K.
const C2_NM_K: f64 = 1.438_776_877e7;
/// Wien's displacement constant, in nm K.
const WIEN_NM_K: f64 = 2.897_771_955e6;
/// Temperatures of a blackbody, in K.
const KELVIN: [f64; 2] = [1.0, 1e6];

impl Tone {
    pub(super) fn grey(value: f64) -> Self {
        Self {
            rgb: [value; 3],
            mean: None,
        }
    }

    /// Each channel by `f` of it and the same channel of `other`.
    pub(super) fn with(self, other: Self, f: impl Fn(f64, f64) -> f64) -> Self {
        let channel = |c: usize| f(self.rgb[c], other.rgb[c]);
        Self {
            rgb: [channel(0), channel(1), channel(2)],
            mean: None,
        }
    }

    fn of_samples(samples: &SpectralSamples) -> Self {
        let [violet, red] = VISIBLE_NM;
        let steps = 61;
        let nm = |i: usize| violet + (red - violet) * i as f64 / (steps - 1) as f64;
        let mean = (0..steps).map(|i| samples.at(nm(i))).sum::<f64>() / steps as f64;
        Self {
            rgb: samples.to_rgb(),
            mean: Some(mean),
        }
    }
}

/// The colour that `parameter` is.
pub(super) fn tone(parameter: &Parameter, files: &Files) -> Result<Tone, SceneError> {
    match parameter.kind {
        Kind::Xyz => {
            let xyz = three(parameter)?;
            let rgb = RGB_OF_XYZ.map(|row| row[0] * xyz[0] + row[1] * xyz[1] + row[2] * xyz[2]);
            Ok(Tone {
                rgb,
                mean: Some(xyz[1]),
            })
        }
        Kind::Blackbody => blackbody(parameter),
        Kind::Spectrum => match &parameter.values {
            Values::Strings(_) => file(parameter, files),
            Values::Numbers(numbers) => pairs(parameter, numbers),
        },
        _ => Ok(Tone {
            rgb: three(parameter)?,
            mean: None,
        }),
    }
}

fn three(parameter: &Parameter) -> Result<[f64; 3], SceneError> {
    let numbers = parameter.numbers()?;
    <[f64; 3]>::try_from(numbers)
        .map_err(|_| parameter.refuse(format!("is not allowed: {} is three numbers", parameter.declared)))
}

/// Wavelengths in nm and values, taken in turn; as in pbrt their order does not matter.
fn pairs(parameter: &Parameter, numbers: &[f64]) -> Result<Tone, SceneError> {
    if numbers.is_empty() || !numbers.len().is_multiple_of(2) {
        let rule = "is not allowed: a spectrum is pairs of a wavelength in nm and a value, or the name of an .spd file";
        return Err(parameter.refuse(rule));
    }
    if let [_, value] = numbers {
        return Ok(Tone::grey(*value));
    }
    let mut pairs: Vec<(f64, f64)> = numbers.chunks_exact(2).map(|pair| (pair[0], pair[1])).collect();
    pairs.sort_by(|a, b| a.0.total_cmp(&b.0));
    let (nm, values) = pairs.into_iter().unzip();
    let samples = SpectralSamples::new(nm, values).map_err(|error| parameter.unusable(&error))?;
    Ok(Tone::of_samples(&samples))
}

/// Planck's law over its largest value, times a scale.
fn blackbody(parameter: &Parameter) -> Result<Tone, SceneError> {
    let [kelvin, scale] = parameter.numbers()? else {
        return Err(parameter.refuse("is not allowed: a blackbody is a temperature in K and a scale"));
    };
    let [least, most] = KELVIN;
    if !(*kelvin >= least && *kelvin <= most) {
        return Err(parameter.refuse(format!(
            "is not allowed: the temperature of a blackbody lies in [{least}, {most}] K"
        )));
    }
    let peak = WIEN_NM_K / kelvin;
    let shape = |nm: f64| {
        let exponents = libm::expm1(C2_NM_K / (peak * kelvin)) / libm::expm1(C2_NM_K / (nm * kelvin));
        (peak / nm).powi(5) * exponents
    };
    let nm: Vec<f64> = (0..=94).map(|i| 360.0 + 5.0 * f64::from(i)).collect();
    let values = nm.iter().map(|nm| scale * shape(*nm)).collect();
    let samples = SpectralSamples::new(nm, values).map_err(|error| parameter.unusable(&error))?;
    Ok(Tone::of_samples(&samples))
}

/// An `.spd` file; where there is none, an index of refraction may still be that of a metal which the name begins with.
fn file(parameter: &Parameter, files: &Files) -> Result<Tone, SceneError> {
    let name = parameter.string()?;
    let Some(path) = found(name, parameter, files) else {
        return metal(name, parameter, files);
    };
    let samples = files
        .library
        .spectrum(&path)
        .map_err(|error| parameter.unusable(&error))?;
    let (first, last) = (
        samples.wavelengths_nm()[0],
        samples.wavelengths_nm()[samples.values().len() - 1],
    );
    let [violet, red] = VISIBLE_NM;
    if last <= violet || first >= red {
        return Err(parameter.refuse(format!(
            "cannot be used: it spans {first} to {last} nm, and a spectrum has to overlap {violet} to {red} nm"
        )));
    }
    Ok(Tone::of_samples(&samples))
}

/// pbrt looks beside the scene file; a file that is included may have brought its own.
fn found(name: &str, parameter: &Parameter, files: &Files) -> Option<PathBuf> {
    let places = [parameter.place.directory(), files.root.as_path()];
    places
        .map(|place| place.join(name))
        .into_iter()
        .find(|path| path.exists())
}

fn metal(name: &str, parameter: &Parameter, files: &Files) -> Result<Tone, SceneError> {
    let stem = name.rsplit(['/', '\\']).next().unwrap_or_default();
    let stem = stem.strip_prefix("metal-").unwrap_or(stem);
    let symbol = stem.split(|c: char| !c.is_alphanumeric()).next().unwrap_or_default();
    let index = ConductorIndex::named(symbol);
    let spectrum = match (parameter.name, index) {
        ("eta", Some(index)) => index.eta(),
        ("k", Some(index)) => index.k(),
        _ => {
            return Err(parameter.refuse(format!(
                "cannot be used: there is no such file; without one only {} are known, as in \"Al.eta.spd\"",
                NAMES.join(", ")
            )));
        }
    };
    files.warnings.add(
        &parameter.place,
        format!(
            "there is no file {}: {symbol} as it is built in stands in",
            super::tokens::quote(name)
        ),
    );
    Ok(Tone {
        rgb: spectrum.value().to_array(),
        mean: None,
    })
}
