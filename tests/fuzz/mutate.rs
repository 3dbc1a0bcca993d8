//! Damage: what bad discs, wrong tools and attackers do to a file.

use whitefurnace::numerics::stream::Stream;

/// Longest input that is made.
const LONGEST: usize = 1 << 16;

/// Values at which lengths, counts and signs go wrong, as little-endian words of four and eight bytes.
const WORDS: [i64; 18] = [
    0,
    1,
    -1,
    2,
    7,
    8,
    255,
    256,
    32767,
    32768,
    65535,
    65536,
    i32::MAX as i64,
    i32::MIN as i64,
    u32::MAX as i64,
    1 << 40,
    i64::MAX,
    i64::MIN,
];
/// Floats that few expect.
const FLOATS: [f64; 8] = [
    f64::NAN,
    f64::INFINITY,
    f64::NEG_INFINITY,
    -0.0,
    5e-324,
    f64::MAX,
    1e15,
    -1.0,
];
/// Numbers that few expect, as text.
const LITERALS: [&str; 26] = [
    "0",
    "-0",
    "-1",
    "1",
    "nan",
    "inf",
    "-inf",
    "1e999",
    "-1e999",
    "1e-400",
    "5e-324",
    "1.7976931348623157e308",
    "1e15",
    "1e12",
    "1e8",
    "1e-6",
    "9007199254740993",
    "9223372036854775807",
    "-9223372036854775808",
    "18446744073709551616",
    "340282366920938463463374607431768211456",
    "0xffffffffffffffff",
    "0o7",
    "1979-05-27T07:32:00Z",
    "1_000",
    "",
];
/// Bytes that mean something somewhere.
const BYTES: [u8; 12] = [0, 1, 0x7f, 0x80, 0xff, b'\n', b'\r', b' ', b'"', b'-', 0x1b, b'9'];

/// Draws for mutations.
pub(crate) struct Dice(pub(crate) Stream);

impl Dice {
    /// One of `0..count`.
    pub(crate) fn below(&mut self, count: usize) -> usize {
        (self.0.bits() % count.max(1) as u64) as usize
    }

    fn one_of<T: Copy>(&mut self, all: &[T]) -> T {
        all[self.below(all.len())]
    }

    /// A range within `length`, short more often than long.
    fn block(&mut self, length: usize) -> std::ops::Range<usize> {
        let start = self.below(length + 1);
        let most = (length - start).min(1 << self.below(14));
        start..start + self.below(most + 1)
    }
}

/// An input of `pool` with one, two, four or eight mutations, mostly one.
pub(crate) fn mutated(dice: &mut Dice, pool: &[Vec<u8>], dictionary: &[&str]) -> Vec<u8> {
    let index = dice.below(pool.len());
    let mut input = pool[index].clone();
    for _ in 0..1 << dice.below(5).saturating_sub(1) {
        mutate(dice, &mut input, pool, dictionary);
        input.truncate(LONGEST);
    }
    input
}

fn mutate(dice: &mut Dice, input: &mut Vec<u8>, pool: &[Vec<u8>], dictionary: &[&str]) {
    let length = input.len();
    let at = dice.below(length + 1);
    match dice.below(14) {
        0 if length > 0 => input[at % length] ^= 1 << dice.below(8),
        1 if length > 0 => input[at % length] = dice.one_of(&BYTES),
        2 if length > 0 => input[at % length] = dice.0.bits() as u8,
        3 => drop(input.drain(dice.block(length))),
        4 => {
            let block = input[dice.block(length)].to_vec();
            insert(input, at, &block);
        }
        // many times: nesting, long lists, giant names
        5 => {
            let block = input[dice.block(length.min(64))].to_vec();
            let times = 1 << dice.below(12);
            insert(input, at, &block.repeat(times.min(LONGEST / block.len().max(1))));
        }
        6 => {
            let (a, b) = (dice.block(length), dice.block(length));
            let (first, second) = if a.end <= b.start { (a, b) } else { (b, a) };
            if first.end <= second.start {
                let swapped = [
                    &input[..first.start],
                    &input[second.clone()],
                    &input[first.end..second.start],
                    &input[first.clone()],
                    &input[second.end..],
                ];
                *input = swapped.concat();
            }
        }
        7 => {
            let other = &pool[dice.below(pool.len())];
            let block = &other[dice.block(other.len())];
            insert(input, at, block);
        }
        // the head of one file, the tail of another
        8 => {
            let other = &pool[dice.below(pool.len())];
            input.truncate(at);
            input.extend_from_slice(&other[dice.below(other.len() + 1)..]);
        }
        9 => replace_number(dice, input),
        10 | 11 if !dictionary.is_empty() => {
            let word = dice.one_of(dictionary).as_bytes();
            if dice.below(2) == 0 {
                insert(input, at, word);
            } else {
                overwrite(input, at, word);
            }
        }
        12 => {
            let word = dice.one_of(&WORDS);
            if dice.below(4) == 0 {
                overwrite(input, at, &word.to_le_bytes());
            } else {
                overwrite(input, at, &(word as i32).to_le_bytes());
            }
        }
        13 => {
            let float = dice.one_of(&FLOATS);
            overwrite(input, at, &float.to_le_bytes());
        }
        _ => input.truncate(at),
    }
}

fn insert(input: &mut Vec<u8>, at: usize, block: &[u8]) {
    input.splice(at..at, block.iter().copied());
}

fn overwrite(input: &mut Vec<u8>, at: usize, block: &[u8]) {
    let end = input.len().min(at + block.len());
    input.splice(at..end, block.iter().copied());
}

/// Another number where one is written in digits.
fn replace_number(dice: &mut Dice, input: &mut Vec<u8>) {
    let start = dice.below(input.len() + 1);
    let digit = |byte: &u8| byte.is_ascii_digit() || b".+-eE".contains(byte);
    let Some(from) = input[start..]
        .iter()
        .position(u8::is_ascii_digit)
        .map(|from| start + from)
    else {
        return;
    };
    let to = input[from..]
        .iter()
        .position(|byte| !digit(byte))
        .map_or(input.len(), |to| from + to);
    let literal = dice.one_of(&LITERALS);
    input.splice(from..to, literal.bytes());
}
