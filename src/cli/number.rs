//! Numbers on the command line, with errors that say what is allowed.

use super::AxisChoice;
use std::fmt::Display;
use std::ops::RangeInclusive;
use std::str::FromStr;
use whitefurnace::parameter::{Legal, MU};
use whitefurnace::table::axis::{MAX_SIZE, Mapping};
use whitefurnace::verify::CONFIDENCE;

const TOLERANCE: Legal = Legal::new("tolerance", 1e-12, 0.5);
const SECONDS: Legal = Legal::new("seconds", 1.0, 86400.0);
const THETA: Legal = Legal::new("theta", 0.0, 90.0);
const PHI: Legal = Legal::new("phi", -360.0, 360.0);
/// Wide enough for every family; the range of the material decides.
const ROUGHNESS: Legal = Legal::new("roughness", 0.0, 1e12);

fn number(text: &str, legal: Legal) -> Result<f64, String> {
    let value: f64 = text.trim().parse().map_err(|_| format!("`{text}` is not a number"))?;
    // + 0 makes 0 of -0
    legal
        .check(value)
        .map(|value| value + 0.0)
        .map_err(|error| error.to_string())
}

pub(super) fn tolerance(text: &str) -> Result<f64, String> {
    number(text, TOLERANCE)
}

/// Strictly between the ends of the range.
pub(super) fn confidence(text: &str) -> Result<f64, String> {
    match number(text, CONFIDENCE) {
        Ok(value) if value > CONFIDENCE.min && value < CONFIDENCE.max => Ok(value),
        Ok(value) => Err(format!(
            "confidence = {value} is not allowed: confidence lies between 0.5 and 1, ends excluded"
        )),
        Err(error) => Err(error),
    }
}

pub(super) fn seconds(text: &str) -> Result<f64, String> {
    number(text, SECONDS)
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
    whole(text, 2..=MAX_SIZE)
}

pub(super) fn threads(text: &str) -> Result<usize, String> {
    whole(text, 1..=1024)
}

pub(super) fn samples(text: &str) -> Result<u64, String> {
    whole(text, 2..=1 << 40)
}

fn whole<T: FromStr + PartialOrd + Display>(text: &str, legal: RangeInclusive<T>) -> Result<T, String> {
    let (least, most) = (legal.start(), legal.end());
    match text.parse() {
        Ok(number) if legal.contains(&number) => Ok(number),
        _ => Err(format!("not a whole number from {least} to {most}")),
    }
}

pub(super) fn mapping(text: &str) -> Result<AxisChoice, String> {
    match text {
        "auto" => Ok(AxisChoice(None)),
        "mu" => Ok(AxisChoice(Some(Mapping::Mu))),
        "sqrt-mu" => Ok(AxisChoice(Some(Mapping::SqrtMu))),
        "fourth-root-mu" => Ok(AxisChoice(Some(Mapping::FourthRootMu))),
        _ => Err("known mappings are auto, mu, sqrt-mu and fourth-root-mu".into()),
    }
}
