//! Adaptive quadrature over smooth pieces, with an error bound from nested rules.
//!
//! The caller splits the domain where the integrand has kinks and says at which ends of a piece it is singular; each piece
//! is then integrated by [Patterson 1968]'s nested rules of 3, 7, 15, 31 and 63 nodes. The stated error of a piece is the
//! difference between its two finest rules (see `bound` below). Pieces whose rules do not converge fast are
//! halved instead of refined.
//!
//! Gauss-Kronrod pairs were the alternative: they state an error of the same quality for one order, but to raise the order
//! they start over.

pub use super::integral::{Bounded, Integral, NotConverged, ScalarIntegral};

use super::patterson::{ABSCISSAE, LEVELS, NODES_OF_LEVEL, WEIGHTS};
use glam::DVec3;

/// An interval on which the integrand is smooth inside.
///
/// An end is a *kink* when the integrand has half-integer powers of the distance to it; the variable is then quadratic
/// there, which turns them into whole ones. Kinks cost about one rule more, so they are declared and not assumed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Piece {
    from: f64,
    to: f64,
    kink_at_start: bool,
    kink_at_end: bool,
    /// ln(to/from) when the integrand varies with the logarithm of its variable.
    log_ratio: Option<f64>,
    /// Coarsest rule that may be believed.
    first_level: usize,
    /// Whether the variable has the opposite sign.
    mirror: bool,
}

impl Piece {
    /// An interval on which the integrand is smooth up to both ends.
    pub fn smooth(from: f64, to: f64) -> Self {
        Self::kinked(from, to, false, false)
    }

    /// An interval with kinks where said.
    pub fn kinked(from: f64, to: f64, kink_at_start: bool, kink_at_end: bool) -> Self {
        Self {
            from,
            to,
            kink_at_start,
            kink_at_end,
            log_ratio: None,
            first_level: 1,
            mirror: false,
        }
    }

    /// The same piece integrated in the logarithm of its variable, for integrands whose scale is the variable itself.
    /// Both ends must be positive.
    pub fn logarithmic(self) -> Self {
        Self {
            // the quotient may overflow, and of numbers near each other it keeps more digits
            log_ratio: Some(if self.from < 1e-150 {
                libm::log(self.to) - libm::log(self.from)
            } else {
                libm::log(self.to / self.from)
            }),
            // over several e-foldings 7 nodes do not see the shape yet, and what they agree on with 3 says little
            first_level: 2,
            ..self
        }
    }

    /// The same piece at the other side of 0, from -to to -from.
    pub fn mirrored(self) -> Self {
        Self {
            mirror: !self.mirror,
            ..self
        }
    }

    /// The same piece with 15 nodes against 7 as its first estimate, instead of 7 against 3: for integrands of many shapes.
    pub fn careful(self) -> Self {
        Self { first_level: 2, ..self }
    }

    /// The same piece with 3 nodes against the midpoint as its first estimate, instead of 7 against 3: for pieces that
    /// contribute little however wrong that is.
    pub fn thin(self) -> Self {
        Self { first_level: 0, ..self }
    }

    /// Integration variable and its derivative at x in [0, 1].
    fn at(&self, x: f64) -> (f64, f64) {
        let (y, slope) = self.unmirrored(x);
        (if self.mirror { -y } else { y }, slope)
    }

    fn unmirrored(&self, x: f64) -> (f64, f64) {
        // the share of the way from the start, from the end, and its slope; each small share keeps its digits
        let (share, rest, slope) = match (self.kink_at_start, self.kink_at_end) {
            (false, false) => (x, 1.0 - x, 1.0),
            (true, false) => (x * x, (1.0 - x) * (1.0 + x), 2.0 * x),
            (false, true) => (x * (2.0 - x), (1.0 - x) * (1.0 - x), 2.0 * (1.0 - x)),
            (true, true) => {
                let y = 1.0 - x;
                (x * x * (3.0 - 2.0 * x), y * y * (3.0 - 2.0 * y), 6.0 * x * y)
            }
        };
        match self.log_ratio {
            None => {
                let length = self.to - self.from;
                let y = if share < rest {
                    self.from + length * share
                } else {
                    self.to - length * rest
                };
                (y, length * slope)
            }
            Some(log) => {
                let y = if share < rest {
                    self.from * libm::exp(log * share)
                } else {
                    self.to * libm::exp(-log * rest)
                };
                (y, y * log * slope)
            }
        }
    }
}

/// Part of a piece under one nested rule.
struct Panel {
    piece: Piece,
    /// Part of [0, 1] that is covered.
    from: f64,
    to: f64,
    level: usize,
    /// Integrand times derivative at each node, summed over the pair of x and -x, in the order of [`ABSCISSAE`].
    nodes: Vec<Bounded>,
    value: DVec3,
    /// Error handed on by the integrand.
    inherited: DVec3,
    /// |Q_level - Q_(level - 1)|.
    difference: DVec3,
    /// |Q_(level - 1) - Q_(level - 2)|.
    previous: DVec3,
    /// Bound of the error of Q_level.
    bound: DVec3,
}

impl Panel {
    fn error(&self) -> f64 {
        self.bound.max_element()
    }

    /// A panel under the first rule of its piece, with the coarser ones on the way.
    fn new(piece: Piece, (from, to): (f64, f64), f: &mut impl FnMut(f64) -> Bounded, evaluations: &mut u64) -> Self {
        let mut panel = Self {
            piece,
            from,
            to,
            level: 0,
            nodes: Vec::with_capacity(NODES_OF_LEVEL[2].div_ceil(2)),
            value: DVec3::ZERO,
            inherited: DVec3::ZERO,
            difference: DVec3::ZERO,
            previous: DVec3::ZERO,
            bound: DVec3::ZERO,
        };
        for level in 0..=piece.first_level {
            panel.evaluate(level, f, evaluations);
        }
        panel
    }

    /// Moves to the rule of `level`, evaluating the nodes that it adds.
    fn evaluate(&mut self, level: usize, f: &mut impl FnMut(f64) -> Bounded, evaluations: &mut u64) {
        let (centre, half) = (0.5 * (self.from + self.to), 0.5 * (self.to - self.from));
        let mut at = |x: f64| {
            let (y, slope) = self.piece.at(centre + half * x);
            *evaluations += 1;
            f(y).scaled(slope * half)
        };
        for x in &ABSCISSAE[self.nodes.len()..NODES_OF_LEVEL[level].div_ceil(2)] {
            let mut node = at(*x);
            if *x > 0.0 {
                let mirror = at(-x);
                node = Bounded {
                    value: node.value + mirror.value,
                    error: node.error + mirror.error,
                };
            }
            self.nodes.push(node);
            if self.nodes.len() == 1 {
                self.value = 2.0 * node.value; // the midpoint rule, the coarsest of the family
            }
        }
        let (mut value, mut inherited) = (DVec3::ZERO, DVec3::ZERO);
        for (weight, node) in WEIGHTS[level].iter().zip(&self.nodes) {
            value += *weight * node.value;
            inherited += *weight * node.error;
        }
        self.level = level;
        self.previous = self.difference;
        self.difference = (value - self.value).abs();
        self.value = value;
        self.inherited = inherited;
        self.bound = bound(self.difference, self.previous, value.abs());
    }

    /// Whether one more rule promises more than halving the panel: the last one gained at least a digit.
    fn converges(&self) -> bool {
        self.level + 1 < LEVELS
            && (self.level < 2 || self.difference.max_element() <= 0.1 * self.previous.max_element())
    }
}

/// Bound of the error of a rule: its difference d to the rule before, which is the error of that one.
///
/// Crediting the finer rule with the factor d/d' that the last step gained (d' the difference before) would save about a
/// third of the evaluations, and states too small an error for one integral in a hundred: a feature of the integrand that
/// the coarser rules missed shows up in d first, and only then in the gain.
///
/// Agreement by accident is ruled out: no step is taken to gain more than twice the digits that were there
/// (d >= d'^2/10 relative to the value).
fn bound(difference: DVec3, previous: DVec3, size: DVec3) -> DVec3 {
    let relative = DVec3::select(size.cmpgt(previous), previous / size, DVec3::ONE);
    difference.max(0.1 * previous * relative)
}

/// Integrates `f` over all `pieces` until the stated error is at most `tolerance` in every channel.
///
/// In rounds, every panel within a factor of two of the largest error is refined. The stated error adds up the bounds of all panels, the errors
/// that `f` states, and the rounding of the sum; errors that `f` states are the caller's to keep below the tolerance.
///
/// # Errors
/// [`NotConverged`] when `limit` evaluations of `f` do not suffice.
pub fn integrate(
    pieces: &[Piece],
    tolerance: f64,
    limit: u64,
    f: impl FnMut(f64) -> Bounded,
) -> Result<Integral, NotConverged> {
    integrate_while(pieces, tolerance, |evaluations| evaluations < limit, f)
}

/// [`integrate`] for as long as `more`, told after every round how often `f` was evaluated, allows another one.
///
/// # Errors
/// [`NotConverged`] when it does not and the tolerance is not met.
pub fn integrate_while(
    pieces: &[Piece],
    tolerance: f64,
    more: impl Fn(u64) -> bool,
    mut f: impl FnMut(f64) -> Bounded,
) -> Result<Integral, NotConverged> {
    let mut evaluations = 0;
    let mut panels: Vec<Panel> = pieces
        .iter()
        .map(|piece| Panel::new(*piece, (0.0, 1.0), &mut f, &mut evaluations))
        .collect();
    loop {
        let open: DVec3 = panels.iter().map(|panel| panel.bound).sum();
        let value: DVec3 = panels.iter().map(|panel| panel.value).sum();
        let size: DVec3 = panels.iter().map(|panel| panel.value.abs()).sum();
        let inherited: DVec3 = panels.iter().map(|panel| panel.inherited).sum();
        let rounding = size * ROUNDING;
        if !value.is_finite() {
            return Err(NotConverged {
                reached: f64::INFINITY,
                tolerance,
                evaluations,
            });
        }
        // refining cannot go below the rounding of the integrand itself
        if open.cmple(DVec3::splat(tolerance).max(rounding)).all() {
            let error = open + inherited + rounding;
            return Ok(Integral {
                bounded: Bounded { value, error },
                evaluations,
            });
        }
        if !more(evaluations) {
            return Err(NotConverged {
                reached: open.max_element(),
                tolerance,
                evaluations,
            });
        }
        let worst = panels.iter().map(Panel::error).fold(0.0, f64::max);
        for i in 0..panels.len() {
            let panel = &mut panels[i];
            if panel.error() < 0.5 * worst {
                continue;
            }
            if panel.converges() {
                panel.evaluate(panel.level + 1, &mut f, &mut evaluations);
                continue;
            }
            let (piece, from, to) = (panel.piece, panel.from, panel.to);
            let middle = 0.5 * (from + to);
            if middle <= from || middle >= to {
                return Err(NotConverged {
                    reached: open.max_element(),
                    tolerance,
                    evaluations,
                });
            }
            *panel = Panel::new(piece, (from, middle), &mut f, &mut evaluations);
            panels.push(Panel::new(piece, (middle, to), &mut f, &mut evaluations));
        }
    }
}

/// Relative rounding error of a sum of some hundred terms, each good to a few units in the last place.
const ROUNDING: f64 = 2e-15;

/// [`integrate`] for a plain function of one channel.
///
/// # Errors
/// [`NotConverged`] after a million evaluations.
pub fn integrate_scalar(
    pieces: &[Piece],
    tolerance: f64,
    mut f: impl FnMut(f64) -> f64,
) -> Result<ScalarIntegral, NotConverged> {
    let integral = integrate(pieces, tolerance, 1_000_000, |x| Bounded::exact(DVec3::splat(f(x))))?;
    Ok(ScalarIntegral {
        value: integral.bounded.value.x,
        error: integral.bounded.error.x,
        evaluations: integral.evaluations,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn check(pieces: &[Piece], tolerance: f64, most: u64, exact: f64, f: impl FnMut(f64) -> f64) {
        let integral = integrate_scalar(pieces, tolerance, f).unwrap();
        let error = (integral.value - exact).abs();
        assert!(
            error <= integral.error,
            "true error {error:e}, stated {:e}",
            integral.error
        );
        assert!(
            integral.error <= tolerance + 1e-14 * (1.0 + exact.abs()),
            "{integral:?}"
        ); // and rounding
        assert!(integral.evaluations <= most, "{integral:?}");
    }

    #[test]
    fn stated_errors_hold_for_smooth_integrands() {
        for exponent in 2..=14 {
            let tolerance = 10f64.powi(-exponent);
            check(&[Piece::smooth(0.0, 1.0)], tolerance, 31, 1f64.exp_m1(), libm::exp);
            check(
                &[Piece::smooth(-1.0, 2.0)],
                tolerance,
                400,
                2f64.atan() + 1f64.atan(),
                |x| 1.0 / (1.0 + x * x),
            );
            check(&[Piece::smooth(0.0, 40.0)], tolerance, 2000, 40f64.sin(), libm::cos);
        }
    }

    #[test]
    fn half_integer_powers_at_the_ends_cost_no_more_than_smooth_ones() {
        for exponent in 2..=13 {
            let tolerance = 10f64.powi(-exponent);
            check(
                &[Piece::kinked(0.0, 1.0, true, true)],
                tolerance,
                63,
                2.0 / 3.0,
                f64::sqrt,
            );
            check(&[Piece::kinked(0.0, 1.0, true, true)], tolerance, 63, 0.4, |x| {
                (1.0 - x).powf(1.5)
            });
            check(
                &[Piece::kinked(0.0, 1.0, true, true)],
                tolerance,
                127,
                std::f64::consts::FRAC_PI_8,
                |x| (x * (1.0 - x)).sqrt(),
            );
        }
    }

    #[test]
    fn scales_of_many_magnitudes_cost_logarithmically() {
        check(
            &[Piece::smooth(1e-12, 1.0).logarithmic()],
            1e-9,
            500,
            1e12f64.ln(),
            |x| 1.0 / x,
        );
    }

    #[test]
    fn panels_are_halved_around_hidden_kinks() {
        check(&[Piece::smooth(0.0, 1.0)], 1e-8, 1500, 0.5 * (0.09 + 0.49), |x| {
            (x - 0.3).abs()
        });
    }

    #[test]
    fn failure_is_reported_with_what_was_reached() {
        let error = integrate_scalar(&[Piece::smooth(0.0, 1.0)], 1e-9, |x| 1.0 / x).unwrap_err();
        assert!(error.reached > 1e-9);
        assert!(integrate_scalar(&[Piece::smooth(0.0, 1.0)], 1e-9, |_| f64::NAN).is_err());
    }
}
