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
    // + 0 makes -0 a 0: the steps around it are those of its bits
    let ideal = |t: usize| f64::max(code.sign * (texels[t] - code.constant[t]), 0.0) + 0.0;
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

#[cfg(test)]
mod tests {
    use super::super::fit::fit;
    use super::super::grid::{Grid, Places};
    use super::*;
    use crate::table::axis::{Axis, Mapping, TexelRule};
    use crate::table::texture::TextureAxis;

    const DOMAIN: [[f64; 2]; 2] = [[0.01, 1.0], [0.05, 1.0]];

    fn grid() -> Grid {
        let axis = |name: &str, size| {
            TextureAxis::along(Axis::new(name, Mapping::Linear, TexelRule::Ends, [0.0, 1.0], size).unwrap())
        };
        let axes = [axis("mu", 9), axis("roughness", 7)];
        let places = axes.iter().map(|axis| Places::borders(axis, 5)).collect();
        Grid::new(&axes, places)
    }

    /// Largest distance between neighbours at `value`.
    fn step(storage: Storage, value: f64) -> f64 {
        match storage {
            Storage::F32 => value * 2f64.powi(-23),
            Storage::F16 => value.max(2f64.powi(-14)) * 2f64.powi(-10),
            Storage::Unorm16 => 1.0 / 65535.0,
            Storage::Unorm8 => 1.0 / 255.0,
        }
    }

    /// Rounding weighs its sum: it is never above that of the nearest steps, below it for coarse ones, and no texel leaves the two steps
    /// around its fitted value. The truth reaches 1, where what is stored of the loss is 0.
    #[test]
    fn steps_are_chosen_for_the_sum() {
        let grid = grid();
        let at = |index: usize| {
            let values = grid.values(index);
            1.0 - 0.6 * values[1].powi(3) * (1.0 - 0.5 * values[0] * values[0])
        };
        let truth: Vec<f64> = (0..grid.len()).map(at).collect();
        let problem = Problem {
            grid: &grid,
            truth: &truth,
            unit: &truth,
            domain: &DOMAIN,
            legal: [0.0, 1.0],
        };
        let fitted = fit(&problem);
        for (constant, sign) in [(0.0, 1.0), (1.0, -1.0)] {
            let constant = vec![constant; fitted.texels.len()];
            let code = Code {
                constant: &constant,
                sign,
            };
            let sum = |stored: &[f64]| -> f64 {
                let decoded: Vec<f64> = stored.iter().zip(&constant).map(|(s, c)| c + sign * s).collect();
                let one = |index: usize| {
                    let error = ((grid.mix(index).of(&decoded) - truth[index]) / truth[index]).abs();
                    grid.measure(index) * error.powf(1.5) * (1.0 + (error / fitted.score.max).powi(8))
                };
                let inside = (0..grid.len()).filter(|index| grid.is_within(*index, &DOMAIN));
                inside.map(one).sum()
            };
            for storage in Storage::ALL {
                let ideal: Vec<f64> = fitted
                    .texels
                    .iter()
                    .zip(&constant)
                    .map(|(t, c)| sign * (t - c))
                    .collect();
                let nearest: Vec<f64> = ideal.iter().map(|value| storage.round(value.max(0.0))).collect();
                let stored = round(&problem, &fitted, &code, storage);
                // sums are formed in two orders
                assert!(sum(&stored) <= sum(&nearest) * (1.0 + 1e-9), "{storage:?} {sign}");
                if storage == Storage::Unorm8 {
                    // steps of 0.4 % are as large as what the fit leaves, so that choosing among them must pay
                    assert!(
                        sum(&stored) < 0.95 * sum(&nearest),
                        "{} {}",
                        sum(&stored),
                        sum(&nearest)
                    );
                }
                for (stored, ideal) in stored.iter().zip(&ideal) {
                    assert_eq!(storage.round(*stored), *stored, "{storage:?} holds it");
                    assert!(stored.is_sign_positive(), "{storage:?}: {stored}");
                    // the two values around it are one step of the larger apart
                    let bound = 1.001 * step(storage, stored.max(*ideal));
                    assert!((stored - ideal).abs() <= bound, "{storage:?} {sign}: {stored} {ideal}");
                }
            }
        }
    }
}
