//! A function of a direction that is even in its azimuth about both tangents, tabulated once to a stated error.
//!
//! f(mu, phi) = sum_k c_k(mu) cos 2 k phi: such a function is smooth in cos 2 phi, and is interpolated through the Chebyshev
//! nodes of that variable by one [`Curve`] over mu for each. One node is an isotropic function.

use super::curve::Curve;
use super::quadrature::Bounded;
use glam::DVec3;
use rayon::prelude::*;
use std::f64::consts::PI;

/// Most nodes along the azimuth.
const MOST_NODES: usize = 64;

/// Cosines at which the number of nodes is settled: grazing directions see a brushed surface change most.
const PROBES: [f64; 4] = [0.02, 0.1, 0.4, 0.8];

/// An interpolant over the directions of a hemisphere.
#[derive(Debug, Clone)]
pub struct Surface {
    curves: Vec<Curve>,
    /// cos 2 phi of each curve, and its weight in barycentric interpolation.
    nodes: Vec<(f64, f64)>,
    error: f64,
}

impl Surface {
    /// Interpolates a function of mu alone, see [`Curve::fit`].
    ///
    /// # Errors
    /// The first error of `f`.
    pub fn isotropic<E>(tolerance: f64, layer: f64, mut f: impl FnMut(f64) -> Result<Bounded, E>) -> Result<Self, E> {
        let curve = Curve::fit(tolerance, layer, &mut f)?;
        Ok(Self {
            error: curve.error(),
            curves: vec![curve],
            nodes: vec![(0.0, 1.0)],
        })
    }

    /// Interpolates f(mu, phi) to about `tolerance`, as far as 64 azimuths go; the stated error is what came out.
    ///
    /// # Errors
    /// The first error of `f`.
    pub fn anisotropic<E: Send>(
        tolerance: f64,
        layer: f64,
        f: impl Fn(f64, f64) -> Result<Bounded, E> + Sync,
    ) -> Result<Self, E> {
        let mut count = 4;
        let cut_off = loop {
            let cut_off = tail(count, &f)?;
            if cut_off <= tolerance || 2 * count > MOST_NODES {
                break cut_off;
            }
            count *= 2;
        };
        let curves: Vec<Curve> = (0..count)
            .into_par_iter()
            .map(|k| Curve::fit(tolerance, layer, &mut |mu| f(mu, node(k, count))))
            .collect::<Result<_, E>>()?;
        let worst = curves.iter().map(Curve::error).fold(0.0, f64::max);
        // interpolation through Chebyshev nodes magnifies errors of its values by at most 1 + (2/pi) ln(count)
        let magnified = worst * (1.0 + 2.0 / PI * libm::log(count as f64));
        // the weights of Chebyshev nodes are (-1)^k sin of the node's angle
        let nodes = (0..count).map(|k| {
            let (sin, cos) = libm::sincos(2.0 * node(k, count));
            (cos, if k % 2 == 0 { sin } else { -sin })
        });
        Ok(Self {
            nodes: nodes.collect(),
            curves,
            error: magnified + cut_off,
        })
    }

    /// The value in the direction of the unit vector `w`, whose z is taken without its sign.
    pub fn at(&self, w: DVec3) -> DVec3 {
        let mu = w.z.abs();
        if let [curve] = &self.curves[..] {
            return curve.at(mu);
        }
        let (x2, y2) = (w.x * w.x, w.y * w.y);
        // at the normal all azimuths are one
        let cos = if x2 + y2 > 0.0 { (x2 - y2) / (x2 + y2) } else { 1.0 };
        let (mut sum, mut weights) = (DVec3::ZERO, 0.0);
        for (curve, (node, weight)) in self.curves.iter().zip(&self.nodes) {
            let distance = cos - node;
            if distance == 0.0 {
                return curve.at(mu);
            }
            let weight = weight / distance;
            sum += weight * curve.at(mu);
            weights += weight;
        }
        sum / weights
    }

    /// Bound of the error in any direction.
    pub fn error(&self) -> f64 {
        self.error
    }
}

/// Azimuth of node k of `count`: 2 phi = pi (k + 1/2)/count.
fn node(k: usize, count: usize) -> f64 {
    0.5 * PI * (k as f64 + 0.5) / count as f64
}

/// What `count` nodes leave out, judged as for a [`Curve`] by the last quarter of the coefficients.
fn tail<E: Send>(count: usize, f: &(impl Fn(f64, f64) -> Result<Bounded, E> + Sync)) -> Result<f64, E> {
    let tails = PROBES.par_iter().map(|mu| {
        let values: Vec<DVec3> = (0..count)
            .map(|j| f(*mu, node(j, count)).map(|bounded| bounded.value))
            .collect::<Result<_, E>>()?;
        let last = count - (count / 4).max(1)..count;
        let size = |k: usize| {
            let terms = values.iter().enumerate();
            let sum: DVec3 = terms
                .map(|(j, value)| libm::cos(2.0 * k as f64 * node(j, count)) * *value)
                .sum();
            (2.0 / count as f64 * sum).abs().max_element()
        };
        Ok(4.0 * last.map(size).sum::<f64>())
    });
    tails
        .collect::<Result<Vec<f64>, E>>()
        .map(|tails| tails.into_iter().fold(0.0, f64::max))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Polar;
    use std::convert::Infallible;

    #[test]
    fn values_between_the_nodes_are_within_the_stated_error() {
        let f = |mu: f64, phi: f64| mu / (1.3 - (2.0 * phi).cos() * (1.0 - mu)) + 0.1 * (-mu / 0.05).exp();
        let surface = Surface::anisotropic(1e-8, 0.05, |mu, phi| {
            Ok::<_, Infallible>(Bounded::exact(DVec3::splat(f(mu, phi))))
        })
        .unwrap();
        assert!(surface.error() < 1e-7, "{}", surface.error());
        for i in 0..4000 {
            let t = f64::from(i) * 0.618_034;
            let (mu, phi) = (t.fract().powi(2), 7.0 * t);
            let w = Polar::from_cos(mu).direction(phi);
            let difference = (surface.at(w).x - f(mu, phi)).abs();
            assert!(difference <= surface.error() + 1e-13, "{mu} {phi}: {difference:e}"); // rounding of cos 2 phi
        }
    }
}
