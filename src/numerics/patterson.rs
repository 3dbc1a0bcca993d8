//! Patterson's nested quadrature rules on [-1, 1] with 3, 7, 15, 31 and 63 nodes.
//!
//! Each rule keeps every node of the one before it, so raising the order costs only the new nodes, and the difference of
//! two consecutive rules bounds the error of the finer one for integrands that both resolve. The exact degrees are 5, 11,
//! 23, 47 and 95; Gauss-Legendre rules of growing order share no nodes and would throw every evaluation away.
//!
//! Nodes and weights: [Patterson 1968], recomputed in 150-digit arithmetic from the orthogonality conditions that define
//! them; the tests check the degrees of exactness.

/// Number of nodes of each level.
pub const NODES_OF_LEVEL: [usize; LEVELS] = [3, 7, 15, 31, 63];

/// Number of nested rules.
pub const LEVELS: usize = 5;

/// Non-negative nodes in the order in which the levels add them: level `l` uses the first `(NODES_OF_LEVEL[l] + 1) / 2`.
///
/// The first is 0; each of the others stands for the pair of itself and its negative.
pub const ABSCISSAE: [f64; 32] = [
    0.0,
    0.7745966692414834,
    0.43424374934680254,
    0.9604912687080203,
    0.2233866864289669,
    0.6211029467372264,
    0.888459232872257,
    0.993831963212755,
    0.11248894313318662,
    0.3311353932579768,
    0.5313197436443756,
    0.7024962064915271,
    0.8367259381688688,
    0.9296548574297401,
    0.9815311495537401,
    0.9990981249676676,
    0.05634431304659279,
    0.16823525155220748,
    0.2777498220218243,
    0.38335932419873037,
    0.48361802694584105,
    0.5771957100520458,
    0.6629096600247806,
    0.7397560443526947,
    0.8069405319502176,
    0.8639079381936905,
    0.9103711569570043,
    0.9463428583734029,
    0.9721828747485818,
    0.9886847575474295,
    0.997206259372222,
    0.9998728881203576,
];

/// Weights of each level, in the order of [`ABSCISSAE`].
pub const WEIGHTS: [&[f64]; LEVELS] = [
    &[0.8888888888888888, 0.5555555555555556],
    &[
        0.45091653865847414,
        0.26848808986833345,
        0.40139741477596225,
        0.10465622602646726,
    ],
    &[
        0.2255104997982067,
        0.13441525524378423,
        0.20062852937698902,
        0.05160328299707974,
        0.2191568584015875,
        0.1715119091363914,
        0.09292719531512454,
        0.01700171962994026,
    ],
    &[
        0.11275525672076869,
        0.0672077542959907,
        0.10031427861179558,
        0.025807598096176654,
        0.10957842105592464,
        0.08575592004999034,
        0.04646289326175799,
        0.008434565739321106,
        0.11195687302095346,
        0.1056698935802348,
        0.09362710998126447,
        0.07687962049900353,
        0.05697950949412336,
        0.03595710330712932,
        0.01644604985438781,
        0.0025447807915618746,
    ],
    &[
        0.056377628360384714,
        0.03360387714820773,
        0.05015713930589954,
        0.012903800100351265,
        0.054789210527962866,
        0.04287796002500773,
        0.02323144663991027,
        0.004217630441558855,
        0.05597843651047632,
        0.05283494679011652,
        0.04681355499062801,
        0.03843981024945553,
        0.02848975474583355,
        0.01797855156812827,
        0.00822300795723593,
        0.001265156556230068,
        0.0562776998312543,
        0.05548140435655936,
        0.05390549933526606,
        0.051583253952048456,
        0.0485643304066732,
        0.0449145316536322,
        0.04071551011694432,
        0.03606443278078257,
        0.031073551111687966,
        0.025869679327214748,
        0.02059423391591271,
        0.015406750466559498,
        0.010498246909621322,
        0.006115506822117246,
        0.0025790497946856883,
        0.00036322148184553065,
    ],
];

#[cfg(test)]
mod tests {
    use super::*;

    /// A rule of the stated degree integrates every monomial up to it; odd ones vanish by symmetry.
    #[test]
    fn degrees_of_exactness_are_as_published() {
        for (level, degree) in [5_i32, 11, 23, 47, 95].into_iter().enumerate() {
            for k in (0..=degree).step_by(2) {
                let sum = moment(level, k);
                let exact = 2.0 / f64::from(k + 1);
                assert!(
                    (sum - exact).abs() < 4e-16,
                    "level {level}, x^{k}: {sum} instead of {exact}" // rounding of 63 products below 1
                );
            }
            let beyond = moment(level, degree + 1) - 2.0 / f64::from(degree + 2);
            if level < 3 {
                assert!(
                    beyond.abs() > 1e-9,
                    "level {level} is exact beyond its degree: {beyond:e}"
                );
            }
        }
    }

    fn moment(level: usize, k: i32) -> f64 {
        let weights = WEIGHTS[level];
        weights
            .iter()
            .zip(ABSCISSAE)
            .map(|(w, x)| {
                if x == 0.0 {
                    if k == 0 { *w } else { 0.0 }
                } else {
                    2.0 * w * x.powi(k)
                }
            })
            .sum()
    }
}
