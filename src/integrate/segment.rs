//! Pieces of an azimuth integral on which the integrand is linear in x = cos phi.

use glam::DVec3;
use std::f64::consts::FRAC_1_PI;

/// A + B x on [from, to], part of [-1, 1].
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Segment {
    pub(super) from: f64,
    pub(super) to: f64,
    pub(super) a: f64,
    pub(super) b: f64,
}

impl Segment {
    /// The part of the segment within [lowest, 1]; `None` when it is empty.
    pub(super) fn clipped(from: f64, to: f64, lowest: f64, (a, b): (f64, f64)) -> Option<Self> {
        let (from, to) = (from.clamp(lowest, 1.0), to.clamp(lowest, 1.0));
        (to > from).then_some(Self { from, to, a, b })
    }

    /// Ends in psi = asin x = pi/2 - phi, which keeps the digits of small x.
    pub(super) fn psi(&self) -> (f64, f64) {
        (self.from.asin(), self.to.asin())
    }

    /// (1/pi) int (A + B cos phi) dphi over the segment.
    ///
    /// int cos phi dphi = cos psi_from - cos psi_to, written as a product of sines: B is large exactly where that
    /// difference is of second order.
    pub(super) fn azimuth_mean(&self) -> f64 {
        let (from, to) = self.psi();
        let width = to - from;
        let x_integral = 2.0 * (0.5 * (from + to)).sin() * (0.5 * width).sin();
        let slope = if x_integral == 0.0 { 0.0 } else { self.b * x_integral };
        FRAC_1_PI * (self.a * width + slope)
    }

    /// A + B x.
    pub(super) fn at(&self, x: f64) -> f64 {
        self.a + self.b * x
    }
}

/// Sum of the azimuth means.
pub(super) fn azimuth_mean(segments: impl IntoIterator<Item = Segment>) -> DVec3 {
    DVec3::splat(segments.into_iter().map(|segment| segment.azimuth_mean()).sum())
}
