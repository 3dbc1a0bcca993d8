//! Numbers on the command line, with errors that say what is allowed.

use super::AxisChoice;
use std::fmt::Display;
use std::ops::RangeInclusive;
use std::str::FromStr;
use whitefurnace::parameter::{Legal, MU, Number};
use whitefurnace::table::axis::{MAX_SIZE, Mapping};
use whitefurnace::verify::CONFIDENCE;

const TOLERANCE: Legal = Legal::new("tolerance", 1e-12, 0.5);
const SECONDS: Legal = Legal::new("seconds", 1.0, 86400.0);
const THETA: Legal = Legal::new("theta", 0.0, 90.0);
const PHI: Legal = Legal::new("phi", -360.0, 360.0);
/// Wide enough for every family; the range of the material decides.
const ROUGHNESS: Legal = Legal::new("roughness", 0.0, 1e12);

/// The legal number that `text` spells. The message leaves the text to the caller, who quotes it as it was written: 1e-400 is
/// not 0 to whoever wrote it.
fn number(text: &str, legal: Legal) -> Result<f64, String> {
    let value: Option<f64> = text.trim().parse().ok();
    match value.map(|value| legal.check(value)) {
        // + 0 makes 0 of -0
        Some(Ok(value)) => Ok(value + 0.0),
        Some(Err(_)) | None => {
            let Legal { name, min, max } = legal;
            Err(format!("{name} is a number in [{}, {}]", Number(min), Number(max)))
        }
    }
}

pub(super) fn tolerance(text: &str) -> Result<f64, String> {
    number(text, TOLERANCE)
}

/// Strictly between the ends of the range.
pub(super) fn confidence(text: &str) -> Result<f64, String> {
    match number(text, CONFIDENCE) {
        Ok(value) if value > CONFIDENCE.min && value < CONFIDENCE.max => Ok(value),
        _ => Err("confidence is a number between 0.5 and 1, ends excluded".into()),
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

pub(super) fn seed(text: &str) -> Result<u64, String> {
    whole(text, 0..=u64::MAX)
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

#[cfg(test)]
mod tests {
    use super::*;

    /// What people and scripts write by mistake, and what only an attacker writes.
    const STRANGE: [&str; 27] = [
        "",
        " ",
        "-",
        "--json",
        "-1",
        "-0",
        "+1",
        "1,5",
        "0x10",
        "1_000",
        "nan",
        "-nan",
        "inf",
        "-inf",
        "infinity",
        "1e999",
        "-1e999",
        "1e-400",
        "9007199254740993",
        "18446744073709551616",
        "340282366920938463463374607431768211456",
        "1e",
        ".",
        "\u{0}",
        "\u{661}",
        "\u{1b}[2J",
        "\u{202e}1",
    ];

    #[test]
    fn what_is_taken_is_legal_and_what_is_not_says_what_would_be() {
        type Parser = fn(&str) -> Result<f64, String>;
        let parsers: [(Parser, f64, f64, &str); 9] = [
            (tolerance, 1e-12, 0.5, "[1e-12, 0.5]"),
            (confidence, 0.5, 1.0, "between 0.5 and 1"),
            (seconds, 1.0, 86400.0, "[1, 86400]"),
            (mu, 0.0, 1.0, "[0, 1]"),
            (theta, 0.0, 90.0, "[0, 90]"),
            (phi, -360.0, 360.0, "[-360, 360]"),
            (roughness, 0.0, 1e12, "[0, 1e12]"),
            (
                |text| Ok(resolution(text)? as f64),
                2.0,
                MAX_SIZE as f64,
                "from 2 to 16384",
            ),
            (|text| Ok(samples(text)? as f64), 2.0, 1.1e12, "from 2 to 1099511627776"),
        ];
        let long = "9".repeat(100_000);
        for (parser, min, max, allowed) in parsers {
            for text in STRANGE.into_iter().chain([long.as_str()]) {
                match parser(text) {
                    Ok(value) => assert!(value >= min && value <= max, "{text:?} is {value}"),
                    Err(error) => assert!(error.contains(allowed) && error.len() < 100, "{text:?}: {error}"),
                }
            }
        }
        assert_eq!(seed("18446744073709551615"), Ok(u64::MAX));
        assert!(
            seed("18446744073709551616")
                .unwrap_err()
                .contains("from 0 to 18446744073709551615")
        );
        assert!(threads("0").unwrap_err().contains("from 1 to 1024"));
    }
}
