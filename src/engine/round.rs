//! Fitted texels in the steps of a storage format.
//!
//! Each texel takes the nearest step first. Then each in turn takes of the two steps around its fitted value the one that leaves the
//! smallest sum of e^(3/2) (1 + (e/e_max)^8) over the errors e of the places that read it, e_max the largest that the fit left:
//! errors of neighbours cancel where they can, and none grows far beyond the largest. Steps further away are not tried, as
//! texels would wander off to where the fit has come from.

use super::fit::{Fitted, Problem};
use crate::table::Storage;
use half::f16;

/// How a texel that is stored becomes one that lookups mix: `constant` of the texel and `sign` times what is stored.
pub(super) struct Code<'a> {
    pub(super) constant: &'a [f64],
    pub(super) sign: f64,
}

/// Rounds over all texels: the third changes next to nothing.
const ROUNDS: usize = 2;

/// What to store, at least 0, for the decoded texels that were `fitted`.
pub(super) fn round(problem: &Problem<'_>, fitted: &Fitted, code: &Code<'_>, storage: Storage) -> Vec<f64> {
    let Fitted { texels, score } = fitted;
    let ideal = |t: usize| f64::max(code.sign * (texels[t] - code.constant[t]), 0.0);
    let mut stored: Vec<f64> = (0..texels.len()).map(|t| storage.round(ideal(t))).collect();
    if storage == Storage::F32 {
        return stored;
    }
    let decoded = |t: usize, value: f64| code.constant[t] + code.sign * value;
    let readers = readers(problem, texels.len());
    let all: Vec<f64> = (0..texels.len()).map(|t| decoded(t, stored[t])).collect();
    let mut errors: Vec<f64> = (0..problem.grid.len())
        .map(|index| (problem.grid.mix(index).of(&all) - problem.truth[index]) / problem.unit[index])
        .collect();
    for _ in 0..ROUNDS {
        for t in 0..texels.len() {
            let own = stored[t];
            let other = beyond(storage, own, ideal(t));
            let change = decoded(t, other) - decoded(t, own);
            let [stays, moves] = [0.0, change].map(|change| cost(&readers[t], &errors, change, score.max));
            if moves < stays {
                for reader in &readers[t] {
                    errors[reader.place] += reader.slope * change;
                }
                stored[t] = other;
            }
        }
    }
    stored
}

/// A place that reads a texel.
struct Reader {
    place: usize,
    /// d error/d texel.
    slope: f64,
    measure: f64,
}

/// The places of the domain that read each texel.
fn readers(problem: &Problem<'_>, texels: usize) -> Vec<Vec<Reader>> {
    let mut readers: Vec<Vec<Reader>> = (0..texels).map(|_| Vec::new()).collect();
    for place in (0..problem.grid.len()).filter(|place| problem.grid.is_within(*place, problem.domain)) {
        let mix = problem.grid.mix(place);
        for k in (0..mix.count).filter(|k| mix.weights[*k] != 0.0) {
            readers[mix.texels[k]].push(Reader {
                place,
                slope: mix.weights[k] / problem.unit[place],
                measure: problem.grid.measure(place),
            });
        }
    }
    readers
}

/// The sum after a texel has changed by `change`.
fn cost(readers: &[Reader], errors: &[f64], change: f64, largest: f64) -> f64 {
    let one = |reader: &Reader| {
        let error = (errors[reader.place] + reader.slope * change).abs();
        let square = (error / largest) * (error / largest);
        let fourth = square * square;
        reader.measure * error * error.sqrt() * (1.0 + fourth * fourth)
    };
    readers.iter().map(one).sum()
}

/// The step on the other side of `ideal` than `own`, one of the two around it; at least 0.
fn beyond(storage: Storage, own: f64, ideal: f64) -> f64 {
    let is_up = ideal > own;
    let step = |count: f64| storage.round(own + if is_up { 1.0 } else { -1.0 } / count);
    match storage {
        Storage::F32 => own,
        Storage::F16 => {
            let bits = f16::from_f64(own).to_bits();
            let other = if is_up { bits + 1 } else { bits.saturating_sub(1) };
            f16::from_bits(other).to_f64()
        }
        Storage::Unorm16 => step(65535.0),
        Storage::Unorm8 => step(255.0),
    }
}
