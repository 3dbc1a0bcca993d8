//! A function of mu in [0, 1], tabulated once to a stated error by piecewise Chebyshev interpolation.
//!
//! Couplings evaluate rho(mu) for every sample; an integral each time would cost a hundred times more than a curve does.
//! Pieces are halved until each meets the tolerance, which follows boundary layers of any width.

use super::quadrature::Bounded;
use glam::DVec3;
use std::f64::consts::PI;

/// Nodes of a piece.
const ORDER: usize = 12;
/// Halvings towards the thinnest layer: 2^-60 is below the rounding of mu.
const DEPTH: u32 = 60;

/// A piecewise Chebyshev interpolant over [0, 1].
#[derive(Debug, Clone)]
pub struct Curve {
    pieces: Vec<Piece>,
    error: f64,
}

#[derive(Debug, Clone)]
struct Piece {
    from: f64,
    to: f64,
    /// Chebyshev coefficients.
    coefficients: [DVec3; ORDER],
}

impl Curve {
    /// Interpolates `f` to `tolerance`; the stated error adds what `f` states of its own.
    ///
    /// `layer` is the width of the thinnest feature at mu = 0. Pieces there are halved down to it in any case: a layer
    /// between the nodes of a coarse piece would be invisible to it.
    ///
    /// # Errors
    /// The first error of `f`.
    pub fn fit<E>(tolerance: f64, layer: f64, f: &mut impl FnMut(f64) -> Result<Bounded, E>) -> Result<Self, E> {
        let mut curve = Self {
            pieces: Vec::new(),
            error: 0.0,
        };
        let mut inherited = 0.0;
        curve.fit_piece((0.0, 1.0), 0, (tolerance, layer), &mut inherited, f)?;
        curve.error += inherited;
        Ok(curve)
    }

    fn fit_piece<E>(
        &mut self,
        (from, to): (f64, f64),
        depth: u32,
        (tolerance, layer): (f64, f64),
        inherited: &mut f64,
        f: &mut impl FnMut(f64) -> Result<Bounded, E>,
    ) -> Result<(), E> {
        let mut values = [DVec3::ZERO; ORDER];
        for (j, value) in values.iter_mut().enumerate() {
            let x = libm::cos(PI * (j as f64 + 0.5) / ORDER as f64);
            let at = f(from + 0.5 * (to - from) * (1.0 + x))?;
            *value = at.value;
            *inherited = inherited.max(at.error.max_element());
        }
        let mut coefficients = [DVec3::ZERO; ORDER];
        for (k, coefficient) in coefficients.iter_mut().enumerate() {
            let scale = if k == 0 { 1.0 } else { 2.0 } / ORDER as f64;
            for (j, value) in values.iter().enumerate() {
                *coefficient += scale * libm::cos(PI * k as f64 * (j as f64 + 0.5) / ORDER as f64) * *value;
            }
        }
        // the last quarter of the coefficients stands in for all that were cut off, which also alias onto the kept ones;
        // the factor covers decay as slow as one halving per quarter
        let tail = 4.0
            * coefficients[ORDER - 3..]
                .iter()
                .map(|c| c.abs().max_element())
                .sum::<f64>();
        let coarse = from == 0.0 && to > layer;
        if (tail > tolerance || coarse) && depth < DEPTH {
            let middle = 0.5 * (from + to);
            self.fit_piece((from, middle), depth + 1, (tolerance, layer), inherited, f)?;
            self.fit_piece((middle, to), depth + 1, (tolerance, layer), inherited, f)?;
        } else {
            self.error = self.error.max(tail);
            self.pieces.push(Piece { from, to, coefficients });
        }
        Ok(())
    }

    /// The value at `mu` in [0, 1].
    pub fn at(&self, mu: f64) -> DVec3 {
        let index = self
            .pieces
            .partition_point(|piece| piece.to < mu)
            .min(self.pieces.len() - 1);
        let piece = &self.pieces[index];
        let x = 2.0 * (mu - piece.from) / (piece.to - piece.from) - 1.0;
        // Clenshaw's recurrence
        let (mut b1, mut b2) = (DVec3::ZERO, DVec3::ZERO);
        for c in piece.coefficients[1..].iter().rev() {
            (b1, b2) = (*c + 2.0 * x * b1 - b2, b1);
        }
        piece.coefficients[0] + x * b1 - b2
    }

    /// Bound of the error anywhere in [0, 1].
    pub fn error(&self) -> f64 {
        self.error
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::convert::Infallible;

    #[test]
    fn boundary_layers_of_any_width_are_followed() {
        for width in [1.0, 1e-3, 1e-6, 1e-9] {
            let f = |mu: f64| 1.0 - 0.3 * (mu / width) * (-mu / width).exp() + 0.1 * mu;
            let curve = Curve::fit(1e-10, width, &mut |mu| {
                Ok::<_, Infallible>(Bounded::exact(DVec3::splat(f(mu))))
            })
            .unwrap();
            assert!(curve.error() <= 1e-10);
            for i in 0..2000 {
                let mu = (f64::from(i) / 2000.0).powi(8);
                let error = (curve.at(mu).x - f(mu)).abs();
                assert!(error < 2e-10, "width {width}, mu {mu}: {error:e}"); // tolerance and rounding of 12 terms
            }
        }
    }
}
