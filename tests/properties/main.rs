//! What holds over the whole legal range of every parameter, as properties of random models and directions.
//!
//! proptest draws the cases and shrinks those that fail: of a coupling over a sum of lobes it leaves the lobe and the
//! parameter at fault. Seeds are fixed, so that a failure comes back by itself; `FURNACE_PROPERTY_CASES` multiplies the number
//! of cases of every property (1 unless given), `FURNACE_PROPERTY_SEED` starts from another seed. What a case has found once
//! becomes a test with a name beside the code that was wrong, and no file of seeds is kept.

mod directions;
mod distributions;
mod estimates;
mod legal;
mod storage;
mod strategies;
mod switches;
mod tables;

use proptest::strategy::Strategy;
use proptest::test_runner::{Config, RngSeed, TestCaseError, TestRunner};

/// A number from the environment.
fn from_environment(name: &str, otherwise: u64) -> u64 {
    match std::env::var(name) {
        Ok(text) => text
            .parse()
            .unwrap_or_else(|_| panic!("{name}={text} is not allowed: a whole number")),
        Err(_) => otherwise,
    }
}

/// Runs `property` on `cases` draws, times what the environment asks for.
fn check<S: Strategy>(cases: u32, strategy: &S, property: impl Fn(S::Value) -> Result<(), TestCaseError>) {
    let times = from_environment("FURNACE_PROPERTY_CASES", 1);
    let config = Config {
        cases: u32::try_from(u64::from(cases) * times).unwrap_or(u32::MAX),
        failure_persistence: None,
        rng_seed: RngSeed::Fixed(from_environment("FURNACE_PROPERTY_SEED", 20_091)),
        max_shrink_time: 60_000, // milliseconds
        ..Config::default()
    };
    if let Err(failure) = TestRunner::new(config).run(strategy, property) {
        panic!("{failure}");
    }
}

/// Fails a property with a message.
macro_rules! ensure {
    ($holds:expr, $($message:tt)+) => {
        let holds: bool = $holds;
        if !holds {
            return Err(proptest::test_runner::TestCaseError::fail(format!($($message)+)));
        }
    };
}
pub(crate) use ensure;
