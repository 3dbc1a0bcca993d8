//! Texels whose *interpolated* values come nearest to the truth.
//!
//! A lookup reads s(x) = sum_t a_t(x) v_t, linear in the texels v. Texels that hold the truth at their own places leave errors of one
//! sign wherever the function is curved, and of many per cent in the half texels beyond the outermost centres. Here texels minimise
//!
//! sum_x m(x) lambda(x) |s(x)/t(x) - 1|^p,
//!
//! m the measure of the domain, p = 1.5, by weighted least squares whose weights are renewed from the errors: towards the mean
//! of the error by |e|^(p - 2), towards its maximum by lambda, which grows where the error is near the largest [Lawson 1961].
//! The normal equations couple neighbouring texels only and are solved by conjugate gradients. [`super::round`] rounds
//! them to a storage format.

use super::grid::Grid;
use rayon::prelude::*;

/// Ratio of the largest to the mean error that a fit aims at: half a per cent and a hundredth of it, say.
const MAX_OVER_MEAN: f64 = 45.0;

/// Weight of places outside the domain: they follow where they cost nothing.
const OUTSIDE: f64 = 3e-3;

/// Exponent of the error that is minimised.
const POWER: f64 = 1.5;

/// Rounds of reweighting: gains are below a per cent after twenty.
const ROUNDS: usize = 40;

/// Share of the best score so far from which on errors gain emphasis, and how slowly the others lose it. A share of 0.97 instead of
/// 0.9 ends at maxima that are a quarter larger.
const SHARE: f64 = 0.9;
const FADE: f64 = 0.7;

/// Most emphasis: beyond, the equations are no longer solved.
const MOST_EMPHASIS: f64 = 1e9;

/// Errors below this are as good as none.
const NEGLIGIBLE: f64 = 2e-5;

/// What one channel is fitted to.
pub(super) struct Problem<'a> {
    pub(super) grid: &'a Grid,
    /// The truth at every place of the grid.
    pub(super) truth: &'a [f64],
    /// What errors are divided by at every place: the truth for relative ones, 1 for absolute ones.
    pub(super) unit: &'a [f64],
    /// Lower and upper value per axis of where errors count.
    pub(super) domain: &'a [[f64; 2]],
    /// Least and largest texel.
    pub(super) legal: [f64; 2],
}

/// Texels for linear lookups, in the order of a texture, and how far lookups are off.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Fitted {
    pub(super) texels: Vec<f64>,
    pub(super) score: Score,
}

/// Mean and largest error over the domain.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct Score {
    pub(super) mean: f64,
    pub(super) max: f64,
}

impl Score {
    fn value(self) -> f64 {
        self.max.max(MAX_OVER_MEAN * self.mean)
    }
}

/// Texels before rounding.
pub(super) fn fit(problem: &Problem<'_>) -> Fitted {
    let [least, largest] = problem.legal;
    let count = problem.grid.len();
    let inside: Vec<bool> = (0..count)
        .map(|index| problem.grid.is_within(index, problem.domain))
        .collect();
    let base: Vec<f64> = (0..count)
        .map(|index| {
            let unit = problem.unit[index];
            problem.grid.measure(index) * if inside[index] { 1.0 } else { OUTSIDE } / (unit * unit)
        })
        .collect();
    let mut weights = base.clone();
    let mut emphasis = vec![1.0; count];
    let mut texels = vec![0.0; problem.grid.texels()];
    let mut best: Option<(Score, Vec<f64>)> = None;
    for _ in 0..ROUNDS {
        solve(problem, &weights, &mut texels);
        // no albedo is beyond, and what the places outside the domain ask for must not make it so
        let legal: Vec<f64> = texels.iter().map(|texel| texel.clamp(least, largest)).collect();
        let errors = errors(problem, &legal);
        let score = score(problem, &errors, &inside);
        if best.as_ref().is_none_or(|(least, _)| score.value() < least.value()) {
            best = Some((score, legal));
        }
        // where the maximum is what counts, it is pushed below the best; where the mean is, emphasis fades
        let limit = SHARE * best.as_ref().map_or(score, |(least, _)| *least).value();
        for index in 0..count {
            if inside[index] {
                let push = (errors[index] / limit).max(FADE);
                emphasis[index] = f64::clamp(emphasis[index] * push * push, 1.0, MOST_EMPHASIS);
            }
            let spread = libm::pow(errors[index].max(NEGLIGIBLE), POWER - 2.0);
            weights[index] = base[index] * emphasis[index] * spread;
        }
    }
    let (score, texels) = best.unwrap_or((Score::default(), texels));
    Fitted { texels, score }
}

/// |s - t|/unit at every place.
fn errors(problem: &Problem<'_>, texels: &[f64]) -> Vec<f64> {
    (0..problem.grid.len())
        .into_par_iter()
        .map(|index| (problem.grid.mix(index).of(texels) - problem.truth[index]).abs() / problem.unit[index])
        .collect()
}

fn score(problem: &Problem<'_>, errors: &[f64], inside: &[bool]) -> Score {
    let (mut sum, mut measure, mut max) = (0.0, 0.0, 0.0f64);
    for index in (0..errors.len()).filter(|index| inside[*index]) {
        let share = problem.grid.measure(index);
        sum += share * errors[index];
        measure += share;
        max = max.max(errors[index]);
    }
    Score {
        mean: sum / measure,
        max,
    }
}

/// The normal equations: for each texel the texels that share a place with it, and what couples them.
struct Normal {
    rows: Vec<Vec<(usize, f64)>>,
    right: Vec<f64>,
}

fn normal(problem: &Problem<'_>, weights: &[f64]) -> Normal {
    let texels = problem.grid.texels();
    let mut rows: Vec<Vec<(usize, f64)>> = vec![Vec::new(); texels];
    let mut right = vec![0.0; texels];
    for index in 0..problem.grid.len() {
        let mix = problem.grid.mix(index);
        for i in 0..mix.count {
            let share = weights[index] * mix.weights[i];
            if share == 0.0 {
                continue;
            }
            right[mix.texels[i]] += share * problem.truth[index];
            let row = &mut rows[mix.texels[i]];
            for j in 0..mix.count {
                let (texel, value) = (mix.texels[j], share * mix.weights[j]);
                match row.iter_mut().find(|(at, _)| *at == texel) {
                    Some((_, sum)) => *sum += value,
                    None => row.push((texel, value)),
                }
            }
        }
    }
    Normal { rows, right }
}

/// Least squares with `weights`, from where `texels` are; conjugate gradients scaled by the diagonal.
fn solve(problem: &Problem<'_>, weights: &[f64], texels: &mut [f64]) {
    let Normal { rows, right } = normal(problem, weights);
    let count = texels.len();
    let diagonal: Vec<f64> = (0..count)
        .map(|i| rows[i].iter().find(|(j, _)| *j == i).map_or(1.0, |(_, value)| *value))
        .collect();
    let times = |x: &[f64]| -> Vec<f64> {
        rows.iter()
            .map(|row| row.iter().map(|(j, value)| value * x[*j]).sum())
            .collect()
    };
    let dot = |a: &[f64], b: &[f64]| -> f64 { a.iter().zip(b).map(|(a, b)| a * b).sum() };
    let product = times(texels);
    let mut rest: Vec<f64> = (0..count).map(|i| right[i] - product[i]).collect();
    let scaled = |rest: &[f64]| -> Vec<f64> { (0..count).map(|i| rest[i] / diagonal[i]).collect() };
    let mut z = scaled(&rest);
    let mut direction = z.clone();
    let mut energy = dot(&rest, &z);
    let enough = 1e-24 * dot(&right, &scaled(&right));
    for _ in 0..4 * count.max(64) {
        if energy <= enough {
            break;
        }
        let image = times(&direction);
        let step = energy / dot(&direction, &image);
        for i in 0..count {
            texels[i] += step * direction[i];
            rest[i] -= step * image[i];
        }
        z = scaled(&rest);
        let next = dot(&rest, &z);
        let keep = next / energy;
        energy = next;
        for i in 0..count {
            direction[i] = z[i] + keep * direction[i];
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::grid::Places;
    use super::*;
    use crate::table::axis::{Axis, Mapping, TexelRule};
    use crate::table::texture::TextureAxis;

    const DOMAIN: [[f64; 2]; 2] = [[0.01, 1.0], [0.05, 1.0]];

    fn axes(rule: TexelRule, flipped: bool) -> Vec<TextureAxis> {
        let axis = |name: &str, flipped, size| TextureAxis {
            axis: Axis::new(name, Mapping::Linear, rule, [0.0, 1.0], size).unwrap(),
            flipped,
        };
        vec![axis("mu", false, 5), axis("roughness", flipped, 4)]
    }

    fn grid(axes: &[TextureAxis]) -> Grid {
        let pairs = axes.iter().zip(&DOMAIN);
        let places = pairs.map(|(axis, domain)| Places::borders(axis, 6).and_ends(axis, *domain, 1e-3));
        Grid::new(axes, places.collect())
    }

    /// Of `truth` on the places of `grid`, with relative errors.
    fn fitted(grid: &Grid, truth: &dyn Fn(f64, f64) -> f64) -> (Vec<f64>, Fitted) {
        let at = |index: usize| {
            let values = grid.values(index);
            truth(values[0], values[1])
        };
        let truth: Vec<f64> = (0..grid.len()).map(at).collect();
        let found = fit(&problem(grid, &truth));
        (truth, found)
    }

    fn problem<'a>(grid: &'a Grid, truth: &'a [f64]) -> Problem<'a> {
        Problem {
            grid,
            truth,
            unit: truth,
            domain: &DOMAIN,
            legal: [0.0, 1.0],
        }
    }

    /// The truth at the texels, as a generator samples it.
    fn sampled(axes: &[TextureAxis], truth: &dyn Fn(f64, f64) -> f64) -> Vec<f64> {
        let row = |y: usize| {
            let of = move |x: usize| truth(axes[0].texel(x), axes[1].texel(y));
            (0..axes[0].axis.size).map(of)
        };
        (0..axes[1].axis.size).flat_map(row).collect()
    }

    /// What texels can hold they do hold, flipped or not: nothing is left to fit.
    #[test]
    fn bilinear_truths_are_recovered() {
        let truth = |mu: f64, r: f64| 0.2 + 0.3 * mu + 0.1 * r + 0.25 * mu * r;
        for flipped in [false, true] {
            let axes = axes(TexelRule::Ends, flipped);
            let (_, found) = fitted(&grid(&axes), &truth);
            // the equations are solved to 1e-12 of their right-hand side, and their condition is below 1e3
            assert!(found.score.max < 1e-9, "{:?}", found.score);
            for (texel, expected) in found.texels.iter().zip(sampled(&axes, &truth)) {
                assert!((texel - expected).abs() < 1e-9, "{flipped}: {texel} {expected}");
            }
        }
    }

    #[test]
    fn constants_are_recovered() {
        for rule in TexelRule::ALL {
            for value in [1e-3, 0.7, 1.0] {
                let (_, found) = fitted(&grid(&axes(rule, false)), &|_, _| value);
                assert!(
                    found.texels.iter().all(|texel| (texel / value - 1.0).abs() < 1e-9),
                    "{rule:?} {value}"
                );
            }
        }
    }

    /// Truths like albedos, some of which no four rows can hold: fitted texels are better than sampled ones
    /// wherever the texels sit, and never leave what is legal.
    #[test]
    fn fitted_is_better_than_sampled() {
        let truths: [&dyn Fn(f64, f64) -> f64; 3] = [
            &|mu, r| 1.0 - 0.5 * r * r * (1.0 + mu) / 2.0,
            &|mu, r| 0.2 + 0.8 * (-4.0 * r * (1.0 - mu)).exp(),
            &|mu, r| mu.sqrt() * (1.0 - 0.9 * r.powi(3)) + 0.05,
        ];
        for (k, truth) in truths.into_iter().enumerate() {
            let truth = |mu: f64, r: f64| truth(mu, r).min(1.0);
            for (rule, flipped) in [
                (TexelRule::Centres, false),
                (TexelRule::Centres, true),
                (TexelRule::Ends, false),
            ] {
                let axes = axes(rule, flipped);
                let grid = grid(&axes);
                let (values, found) = fitted(&grid, &truth);
                let problem = problem(&grid, &values);
                let inside: Vec<bool> = (0..grid.len()).map(|index| grid.is_within(index, &DOMAIN)).collect();
                let own = score(&problem, &errors(&problem, &found.texels), &inside);
                assert_eq!(own, found.score, "the score is that of the texels");
                let plain = score(&problem, &errors(&problem, &sampled(&axes, &truth)), &inside);
                assert!(
                    found.score.value() < plain.value(),
                    "{k} {rule:?} {flipped}: {:?} {plain:?}",
                    found.score
                );
                assert!(found.texels.iter().all(|texel| (0.0..=1.0).contains(texel)));
            }
        }
    }

    /// The texels of a flipped axis are those of the plain one in reverse.
    #[test]
    fn a_flip_reverses_texels() {
        let truth = |mu: f64, r: f64| 1.0 - 0.5 * r * r * (1.0 + mu) / 2.0;
        let [plain, flipped] = [false, true].map(|flipped| {
            let (_, found) = fitted(&grid(&axes(TexelRule::Centres, flipped)), &truth);
            found.texels
        });
        for (row, mirrored) in plain.chunks(5).zip(flipped.chunks(5).rev()) {
            for (a, b) in row.iter().zip(mirrored) {
                // weights of 1 - v round otherwise than those of v, and forty rounds of reweighting carry that on
                assert!((a - b).abs() < 1e-6, "{a} {b}");
            }
        }
    }
}
