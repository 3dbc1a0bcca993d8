//! Pieces of an azimuth integral on which the integrand is linear in x = cos phi.

use std::f64::consts::{FRAC_1_PI, FRAC_PI_2};

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
        (libm::asin(self.from), libm::asin(self.to))
    }

    /// (1/pi) int (A + B cos phi) dphi over the segment.
    pub(super) fn azimuth_mean(&self) -> f64 {
        mean_between(Place::at(self.from), Place::at(self.to), (self.a, self.b))
    }

    /// A + B x.
    pub(super) fn at(&self, x: f64) -> f64 {
        self.a + self.b * x
    }
}

/// A place x on the circle, with psi = asin x and cos psi.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Place {
    x: f64,
    psi: f64,
    cos: f64,
}

impl Place {
    /// x = 1 and x = -1, where most segments begin or end.
    pub(super) const FIRST: Self = Self {
        x: -1.0,
        psi: -FRAC_PI_2,
        cos: 0.0,
    };
    pub(super) const LAST: Self = Self {
        x: 1.0,
        psi: FRAC_PI_2,
        cos: 0.0,
    };

    /// The place at `x`, or the nearer end of [-1, 1].
    pub(super) fn at(x: f64) -> Self {
        if x <= -1.0 {
            return Self::FIRST;
        }
        if x >= 1.0 {
            return Self::LAST;
        }
        Self {
            x,
            psi: libm::asin(x),
            cos: ((1.0 - x) * (1.0 + x)).sqrt(),
        }
    }
}

/// (1/pi) int (A + B cos phi) dphi for the line (A, B) between two places, the first not after the second.
///
/// int cos phi dphi = cos psi_from - cos psi_to, written as (to - from)(to + from)/(cos psi_from + cos psi_to): B is
/// large exactly where that difference is of second order.
pub(super) fn mean_between(from: Place, to: Place, (a, b): (f64, f64)) -> f64 {
    let cosines = from.cos + to.cos;
    if to.x <= from.x {
        return 0.0;
    }
    let x_integral = if cosines > 0.0 {
        (to.x - from.x) * (to.x + from.x) / cosines
    } else {
        0.0
    };
    let slope = if x_integral == 0.0 { 0.0 } else { b * x_integral };
    FRAC_1_PI * (a * (to.psi - from.psi) + slope)
}

/// Sum of the azimuth means.
pub(super) fn azimuth_mean(segments: impl IntoIterator<Item = Segment>) -> f64 {
    segments.into_iter().map(|segment| segment.azimuth_mean()).sum()
}
