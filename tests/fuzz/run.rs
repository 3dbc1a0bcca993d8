//! One input, many inputs, and what is learned from them.

use crate::MEMORY;
use crate::mutate::{Dice, mutated};
use crate::targets::Target;
use cpu_time::ProcessTime;
use std::collections::HashSet;
use std::fmt;
use std::fs::{self, File};
use std::io::{self, Seek, Write};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::PathBuf;
use std::sync::Mutex;
use std::time::{Duration, Instant};
use whitefurnace::export::sha256_hex;
use whitefurnace::numerics::stream::{Stream, StreamId};
use whitefurnace::printable::is_hidden;

/// Most CPU time for an input, in seconds: a thousand times what the slowest of the seeds takes.
pub(crate) const CPU_SECONDS: f64 = 2.0;
/// Longest message of a refusal, in bytes: a place, a quotation, the names of all types and an excerpt of two lines.
const LONGEST_MESSAGE: usize = 2000;
/// Inputs that are mutated, at most.
const POOL: usize = 2000;
/// Refused inputs among them: from one with a mistake come those with two.
const REFUSED: usize = 200;

/// How a parser answered.
pub(crate) struct Answer {
    /// Whether the input was taken.
    pub(crate) taken: bool,
    /// The message of a refusal, or a few words on what was taken.
    pub(crate) words: String,
    seconds: f64,
    memory: usize,
}

/// Feeds `input` to the parser; says which rule it breaks, if any.
pub(crate) fn execute(target: &Target, input: &[u8]) -> Result<Answer, String> {
    MEMORY.reset_peak_usage();
    let (before, start) = (MEMORY.current_usage(), ProcessTime::now());
    let result = quietly(|| (target.parse)(input));
    let seconds = start.elapsed().as_secs_f64();
    let memory = MEMORY.peak_usage().saturating_sub(before);
    let result = result?;
    if seconds > CPU_SECONDS {
        return Err(format!("takes {seconds} s, where {CPU_SECONDS} s are allowed"));
    }
    let allowed = target.memory[0] + target.memory[1] * input.len();
    if memory > allowed {
        return Err(format!(
            "takes {memory} bytes of memory, where {allowed} are allowed for {} bytes of input",
            input.len()
        ));
    }
    if let Err(message) = &result {
        if message.is_empty() || message.len() > LONGEST_MESSAGE {
            return Err(format!("is refused in {} bytes: {message}", message.len()));
        }
        if message.contains(|c: char| is_hidden(c) && c != '\n') {
            return Err(format!("is refused with control characters: {message:?}"));
        }
    }
    Ok(Answer {
        taken: result.is_ok(),
        words: result.unwrap_or_else(|message| message),
        seconds,
        memory,
    })
}

/// Runs `parse`; a panic becomes an error that tells where, and is not printed.
fn quietly(parse: impl FnOnce() -> Result<String, String>) -> Result<Result<String, String>, String> {
    static LAST: Mutex<String> = Mutex::new(String::new());
    let hook = std::panic::take_hook();
    std::panic::set_hook(Box::new(|panic| *LAST.lock().unwrap() = panic.to_string()));
    let result = catch_unwind(AssertUnwindSafe(parse));
    std::panic::set_hook(hook);
    result.map_err(|_| format!("panics: {}", LAST.lock().unwrap()))
}

/// What many inputs taught.
pub(crate) struct Tally {
    inputs: u64,
    taken: u64,
    answers: usize,
    slowest: f64,
    /// Bytes of memory, and bytes of the input that took them.
    largest: (usize, usize),
}

impl fmt::Display for Tally {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "{} inputs, {} taken, {} kinds of answers, slowest {:.1} ms, largest {} KiB for {} bytes",
            self.inputs,
            self.taken,
            self.answers,
            1e3 * self.slowest,
            self.largest.0 / 1024,
            self.largest.1
        )
    }
}

/// Mutates the inputs of `pool`, which grows, until `time` is over.
pub(crate) fn fuzz(target: &Target, mut pool: Vec<Vec<u8>>, time: Duration) -> Tally {
    let (end, known) = (Instant::now() + time, pool.len());
    let mut dice = Dice(Stream::new(StreamId {
        seed: 1,
        cell: target.name.bytes().map(u64::from).sum(),
        batch: 0,
    }));
    let (mut seen, mut refused) = (HashSet::new(), 0);
    let mut tally = Tally {
        inputs: 0,
        taken: 0,
        answers: 0,
        slowest: 0.0,
        largest: (0, 0),
    };
    let path = temporary(target, "current");
    let mut current = File::create(&path).unwrap();
    for index in 0.. {
        // those that are known go first, as they are
        let input = match pool.get(index) {
            Some(input) if index < known => input.clone(),
            _ if Instant::now() > end => break,
            _ => mutated(&mut dice, &pool, target.dictionary),
        };
        // an abort, for want of memory or stack, leaves nothing else behind
        keep(&mut current, &input).unwrap();
        let answer = execute(target, &input).unwrap_or_else(|broken| report(target, input.clone(), &broken));
        tally.inputs += 1;
        tally.taken += u64::from(answer.taken);
        tally.slowest = tally.slowest.max(answer.seconds);
        tally.largest = tally.largest.max((answer.memory, input.len()));
        let is_new = seen.insert(kind(&answer)) && index >= known;
        if is_new && pool.len() < POOL && (answer.taken || refused < REFUSED) {
            refused += usize::from(!answer.taken);
            pool.push(input);
        }
    }
    tally.answers = seen.len();
    fs::remove_file(path).unwrap();
    tally
}

/// Makes `input` the content of a file.
fn keep(file: &mut File, input: &[u8]) -> io::Result<()> {
    file.rewind()?;
    file.write_all(input)?;
    file.set_len(input.len() as u64)
}

/// What tells answers apart: the words without what they quote and count.
fn kind(answer: &Answer) -> (bool, String) {
    let first = answer.words.lines().next().unwrap_or_default();
    let quote = |c: char| "\"'`".contains(c);
    // a quotation may hold quotes of its own: everything from the first to the last
    let (before, behind) = match (first.find(quote), first.rfind(quote)) {
        (Some(from), Some(to)) => (&first[..from], &first[to..]),
        _ => (first, ""),
    };
    let words = before.chars().chain(behind.chars()).filter(|c| !c.is_ascii_digit());
    (answer.taken, words.take(100).collect())
}

/// Fails with the shortest input found that still breaks a rule.
fn report(target: &Target, input: Vec<u8>, broken: &str) -> Answer {
    let input = shortened(target, input);
    let broken = execute(target, &input).err().unwrap_or_else(|| broken.to_owned());
    let path = temporary(target, &sha256_hex(&input)[..8]);
    fs::write(&path, &input).unwrap();
    panic!(
        "{}: {} ({} bytes) {broken}\nOnce that is mended it belongs into tests/data/corpus/{}.",
        target.name,
        path.display(),
        input.len(),
        target.name
    );
}

/// `input` without the blocks that it does not need to break a rule, as far as twenty seconds go.
fn shortened(target: &Target, mut input: Vec<u8>) -> Vec<u8> {
    let end = Instant::now() + Duration::from_secs(20);
    let mut block = input.len().next_power_of_two() / 2;
    while block > 0 {
        let mut at = 0;
        while at < input.len() && Instant::now() < end {
            let without = [&input[..at], &input[input.len().min(at + block)..]].concat();
            if execute(target, &without).is_err() {
                input = without;
            } else {
                at += block;
            }
        }
        block /= 2;
    }
    input
}

fn temporary(target: &Target, name: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(format!("fuzz-{}-{name}", target.name))
}
