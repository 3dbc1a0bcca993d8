//! Verdicts over all tests of a run.

use super::departures::Departure;
use super::statistics::sidak;
use super::{Evidence, Outcome};
use crate::parameter::{Legal, ParameterError};

/// The probability with which a run passes when everything is right.
pub const CONFIDENCE: Legal = Legal::new("confidence", 0.5, 1.0);

/// A test of something that has a name.
#[derive(Debug, Clone, PartialEq)]
pub struct Check {
    /// The material or the table.
    pub subject: String,
    /// What the test found.
    pub outcome: Outcome,
    /// What is known of the model in this respect.
    pub departure: Option<Departure>,
}

/// What is said of a check.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Verdict {
    /// Nothing speaks against it.
    Holds,
    /// Chance or rounding do not explain it.
    Fails,
    /// A known property of the published model, which departs from physics.
    Finding,
    /// The test could not be made.
    Skipped,
}

impl Verdict {
    /// Its name in reports; failures are to be seen.
    pub fn name(self) -> &'static str {
        match self {
            Self::Holds => "holds",
            Self::Fails => "FAILS",
            Self::Finding => "finding",
            Self::Skipped => "skipped",
        }
    }
}

/// All checks of a run with their verdicts.
#[derive(Debug, Clone, PartialEq)]
pub struct Report {
    /// Probability that all checks pass when everything is right.
    pub confidence: f64,
    /// The p-value below which a check fails.
    pub level: f64,
    /// Number of checks that share the significance.
    pub statistical: usize,
    /// In the order in which they were given.
    pub results: Vec<(Check, Verdict)>,
}

impl Report {
    /// Speaks the verdicts at a family-wise `confidence` strictly between 0.5 and 1.
    ///
    /// # Errors
    /// [`ParameterError`] for any other confidence.
    pub fn judge(checks: Vec<Check>, confidence: f64) -> Result<Self, ParameterError> {
        if CONFIDENCE.check(confidence)? >= CONFIDENCE.max || confidence <= CONFIDENCE.min {
            return Err(ParameterError {
                parameter: CONFIDENCE.name,
                value: confidence,
                min: CONFIDENCE.min,
                max: CONFIDENCE.max,
            });
        }
        let by_chance = |check: &&Check| matches!(check.outcome.evidence, Evidence::Chance(_));
        let statistical = checks.iter().filter(by_chance).count();
        let level = sidak(1.0 - confidence, statistical);
        let verdict = |check: &Check| {
            let holds = match check.outcome.evidence {
                Evidence::Chance(p) => p >= level,
                Evidence::Certain(holds) => holds,
                Evidence::Skipped(_) => return Verdict::Skipped,
            };
            match check.departure {
                Some(departure) if !holds || departure.untestable => Verdict::Finding,
                _ if holds => Verdict::Holds,
                _ => Verdict::Fails,
            }
        };
        Ok(Self {
            confidence,
            level,
            statistical,
            results: checks
                .into_iter()
                .map(|check| {
                    let verdict = verdict(&check);
                    (check, verdict)
                })
                .collect(),
        })
    }

    /// Number of checks with the given verdict.
    pub fn count(&self, verdict: Verdict) -> usize {
        self.results.iter().filter(|(_, found)| *found == verdict).count()
    }

    /// Whether nothing failed; with `strict`, whether nothing departs from physics either.
    pub fn is_good(&self, strict: bool) -> bool {
        self.count(Verdict::Fails) == 0 && !(strict && self.count(Verdict::Finding) > 0)
    }
}
