//! Numbers on the command line, with errors that say what is allowed.

use super::AxisChoice;
use whitefurnace::parameter::{Legal, MU};
use whitefurnace::table::axis::{MAX_SIZE, Mapping};

const TOLERANCE: Legal = Legal::new("tolerance", 1e-12, 0.5);
const THETA: Legal = Legal::new("theta", 0.0, 90.0);
const PHI: Legal = Legal::new("phi", -360.0, 360.0);
/// Wide enough for every family; the range of the material decides.
const ROUGHNESS: Legal = Legal::new("roughness", 0.0, 1e12);

fn number(text: &str, legal: Legal) -> Result<f64, String> {
    let value: f64 = text.trim().parse().map_err(|_| format!("`{text}` is not a number"))?;
    legal.check(value).map_err(|error| error.to_string())
}

pub(super) fn tolerance(text: &str) -> Result<f64, String> {
    number(text, TOLERANCE)
}

pub(super) fn mu(text: &str) -> Result<f64, String> {
    number(text, MU)
}

pub(super) fn theta(text: &str) -> Result<f64, String> {
    number(text, THETA)
}

pub(super) fn phi(text: &str) -> Result<f64, String> {
    number(text, PHI)
}

pub(super) fn roughness(text: &str) -> Result<f64, String> {
    number(text, ROUGHNESS)
}

pub(super) fn resolution(text: &str) -> Result<usize, String> {
    match text.parse() {
        Ok(size) if (2..=MAX_SIZE).contains(&size) => Ok(size),
        Ok(size) => Err(format!("{size} texels are not allowed: an axis has 2 to {MAX_SIZE}")),
        Err(_) => Err(format!("`{text}` is not a whole number")),
    }
}

pub(super) fn mapping(text: &str) -> Result<AxisChoice, String> {
    match text {
        "auto" => Ok(AxisChoice(None)),
        "mu" => Ok(AxisChoice(Some(Mapping::Mu))),
        "sqrt-mu" => Ok(AxisChoice(Some(Mapping::SqrtMu))),
        _ => Err("known mappings are auto, mu and sqrt-mu".into()),
    }
}
