//! rho_hh as the cosine-weighted mean of rho_hd, for models without a shorter way.
//!
//! rho_hh = (1/pi) int rho_hd(o) (n.o) do = int_0^1 2 mu (1/2 pi) int rho_hd(mu, phi) dphi dmu.

use super::IntegrateError;
use super::lobe::{Kink, pieces};
use crate::numerics::quadrature::{Bounded, Integral, Piece, integrate_while};
use glam::DVec3;
use std::cell::{Cell, RefCell};
use std::f64::consts::FRAC_PI_2;

/// Shares of the tolerance: what is cut off at the horizon, what rho_hd may leave, and the rest for the mean.
const HORIZON_SHARE: f64 = 0.05;
const INNER_SHARE: f64 = 0.35;
const OUTER_SHARE: f64 = 0.6;

/// Most directions along either angle.
const NODE_LIMIT: u64 = 4000;

/// Most evaluations of all directions together, beyond which no further one is begun: some minutes of one core.
const EVALUATION_LIMIT: u64 = 1 << 30;

/// What is known of rho_hd as a function of the direction.
pub(super) struct Mean<'a> {
    /// Widths of layers at mu = 0, and other cosines at which rho_hd changes its behaviour; true where it has a kink.
    pub(super) marks: &'a [(f64, bool)],
    /// Whether rho_hd depends on phi; it is then even in phi and about pi/2.
    pub(super) anisotropic: bool,
    /// Bound of mu rho_hd near mu = 0 where rho_hd itself grows, of rho_hd otherwise.
    pub(super) bound: f64,
    /// Whether rho_hd grows like 1/mu.
    pub(super) grows: bool,
}

impl Mean<'_> {
    /// The mean of `rho_hd`, a function of mu, phi and the tolerance that it has to meet.
    pub(super) fn integrate(
        &self,
        tolerance: f64,
        mut rho_hd: impl FnMut(f64, f64, f64) -> Result<Integral, IntegrateError>,
    ) -> Result<Integral, IntegrateError> {
        // int_0^cut 2 mu rho_hd dmu is at most bound cut^2, or 2 bound cut
        let part = HORIZON_SHARE * tolerance / self.bound;
        let cut = if self.grows { 0.5 * part } else { part.sqrt() }.min(0.5);
        let mut cuts: Vec<(f64, Kink)> = self
            .marks
            .iter()
            .map(|(mu, kink)| (*mu, Kink::between_pieces(*kink)))
            .collect();
        cuts.retain(|(mu, _)| *mu > cut && *mu < 1.0);
        cuts.extend([cut, 1.0].map(|end| (end, Kink::between_pieces(false))));
        cuts.sort_by(|(a, _), (b, _)| a.total_cmp(b));
        let along_mu: Vec<Piece> = cuts
            .windows(2)
            .filter(|w| w[1].0 > w[0].0)
            .flat_map(|w| pieces(w[0], w[1]))
            .collect();
        let along_phi = [Piece::smooth(0.0, FRAC_PI_2)];
        let spent = Cell::new(0);
        let failure: RefCell<Option<IntegrateError>> = RefCell::new(None);
        let failed = |error: IntegrateError| {
            failure.borrow_mut().get_or_insert(error);
            Bounded::exact(DVec3::NAN)
        };
        let more = |directions: u64| directions < NODE_LIMIT && spent.get() < EVALUATION_LIMIT;
        let mut at = |mu: f64, phi: f64, allowed: f64| {
            if failure.borrow().is_some() {
                return Bounded::exact(DVec3::NAN);
            }
            match rho_hd(mu, phi, allowed) {
                Ok(integral) => {
                    spent.set(spent.get() + integral.evaluations);
                    integral.bounded
                }
                Err(IntegrateError::NotConverged(error)) => failed(error.of_whole(tolerance).into()),
                Err(error) => failed(error),
            }
        };
        let outer = integrate_while(&along_mu, OUTER_SHARE * tolerance, more, |mu| {
            // spread evenly over mu rho_hd where that is what is bounded
            let allowed = INNER_SHARE * tolerance / if self.grows { 2.0 * mu } else { 1.0 };
            if !self.anisotropic {
                return at(mu, 0.0, allowed).scaled(2.0 * mu);
            }
            let around = integrate_while(&along_phi, 0.5 * allowed * FRAC_PI_2, more, |phi| {
                at(mu, phi, 0.5 * allowed)
            });
            match around {
                Ok(around) => around.bounded.scaled(2.0 * mu / FRAC_PI_2),
                Err(error) => failed(error.of_whole(tolerance).into()),
            }
        });
        let evaluations = spent.get();
        match (failure.into_inner(), outer) {
            (Some(error), _) => Err(error.costing(evaluations)),
            (None, Err(error)) => Err(IntegrateError::from(error.of_whole(tolerance)).costing(evaluations)),
            (None, Ok(mut integral)) => {
                integral.bounded.error += DVec3::splat(HORIZON_SHARE * tolerance);
                Ok(Integral {
                    evaluations,
                    ..integral
                })
            }
        }
    }
}
