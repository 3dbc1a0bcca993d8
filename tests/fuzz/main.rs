//! Every parser against damaged and hostile input.
//!
//! Mutations of good files and of everything that ever went wrong (`tests/data/corpus/<parser>`) are fed to the parsers for a
//! bounded time: 10 seconds for all of them, or as many as the environment variable `FURNACE_FUZZ_SECONDS` says. For each input
//! a parser has to come back without a panic, within [`run::CPU_SECONDS`] of CPU time and the memory that its target allows; what
//! it takes has to be well, and what it refuses it has to refuse in a few printable words. An input whose answer was not seen
//! before joins those that are mutated, which leads deeper than blind damage.
//!
//! An input that breaks a rule is cut down, written to the directory for temporary files of the tests, and named in the failure.
//! Once the cause is mended it belongs into the corpus, which a test of its own replays.

mod mutate;
mod run;
mod scenes;
mod seeds;
mod targets;
mod textures;

use peak_alloc::PeakAlloc;
use run::{Tally, execute, fuzz};
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::Duration;
use targets::{TARGETS, Target};

/// Counts what is allocated.
#[global_allocator]
static MEMORY: PeakAlloc = PeakAlloc;

/// The memory and the CPU time of the process are measured: one test at a time.
fn alone() -> MutexGuard<'static, ()> {
    static RUNNING: Mutex<()> = Mutex::new(());
    RUNNING.lock().unwrap_or_else(PoisonError::into_inner)
}

/// The inputs that are kept for a parser, in the order of their names.
fn corpus(target: &Target) -> Vec<(PathBuf, Vec<u8>)> {
    let directory = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("tests/data/corpus")
        .join(target.name);
    let entries = fs::read_dir(&directory).unwrap_or_else(|error| panic!("{}: {error}", directory.display()));
    let mut paths: Vec<PathBuf> = entries.map(|entry| entry.unwrap().path()).collect();
    paths.sort();
    paths
        .into_iter()
        .map(|path| (path.clone(), fs::read(path).unwrap()))
        .collect()
}

#[test]
fn everything_in_the_corpus_is_answered_well() {
    let _alone = alone();
    for target in &TARGETS {
        let kept = corpus(target);
        assert!(!kept.is_empty(), "{} has no corpus", target.name);
        for (path, bytes) in kept {
            if let Err(broken) = execute(target, &bytes) {
                panic!("{}: {broken}", path.display());
            }
        }
    }
}

/// Seeds are good files: a parser that refuses them all would pass every other test here.
#[test]
fn seeds_are_taken() {
    let _alone = alone();
    for target in &TARGETS {
        for (index, seed) in (target.seeds)().iter().enumerate() {
            let answer = execute(target, seed).unwrap_or_else(|broken| panic!("{} {index}: {broken}", target.name));
            assert!(
                answer.taken,
                "{} refuses its seed {index}: {}",
                target.name, answer.words
            );
        }
    }
}

#[test]
fn mutations_are_answered_well() {
    let _alone = alone();
    let seconds = std::env::var("FURNACE_FUZZ_SECONDS").map_or(10.0, |text| {
        let seconds: f64 = text.parse().expect("FURNACE_FUZZ_SECONDS is a number");
        assert!((0.0..=1e6).contains(&seconds), "FURNACE_FUZZ_SECONDS lies in [0, 1e6]");
        seconds
    });
    let each = Duration::from_secs_f64(seconds / TARGETS.len() as f64);
    for target in &TARGETS {
        let kept = corpus(target).into_iter().map(|(_, bytes)| bytes);
        let tally: Tally = fuzz(target, (target.seeds)().into_iter().chain(kept).collect(), each);
        println!("{}: {tally}", target.name);
    }
}
