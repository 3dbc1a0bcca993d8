//! The largest value of a function of a direction: a graded grid, and climbs from its best places.

use rayon::prelude::*;

/// A place with its value.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Top {
    pub(super) mu: f64,
    pub(super) phi: f64,
    pub(super) value: f64,
}

/// Share of an interval that a step of a golden section keeps.
const GOLDEN: f64 = 0.618_033_988_749_894_8;

/// Steps of a climb; each keeps 0.618 of an interval, and at a maximum the square of what is left counts: 2e-4 of the
/// difference to the neighbours.
const CLIMB: usize = 9;

/// Places of the grid that are climbed from.
const STARTS: usize = 3;

/// mu = 0 and 1, `decade` values in each decade above `least`, and `uniform` equal steps between.
pub(super) fn graded(least: f64, decade: i32, uniform: u32) -> Vec<f64> {
    let decades = -least.log10();
    let count = (decades * f64::from(decade)).round() as i32;
    let logarithmic = (0..=count).map(|k| 10f64.powf(-decades * f64::from(k) / f64::from(count)));
    let equal = (1..uniform).map(|k| f64::from(k) / f64::from(uniform));
    let mut all: Vec<f64> = [0.0].into_iter().chain(logarithmic).chain(equal).collect();
    all.sort_by(f64::total_cmp);
    all.dedup();
    all
}

/// Searches [0, 1] x [0, pi) for the maximum of `f`: all combinations of `mus` and `phis`, and from the best local maxima
/// along mu golden sections along both in turn. NaN and infinity count as largest of all.
pub(super) fn largest(mus: &[f64], phis: &[f64], f: impl Fn(f64, f64) -> f64 + Sync) -> Top {
    let at = |mu: f64, phi: f64| {
        let value = f(mu, phi);
        let value = if value.is_nan() { f64::INFINITY } else { value };
        Top { mu, phi, value }
    };
    let lines: Vec<Vec<Top>> = phis
        .par_iter()
        .map(|phi| mus.par_iter().map(|mu| at(*mu, *phi)).collect())
        .collect();
    let mut peaks: Vec<(usize, Top)> = Vec::new();
    for line in &lines {
        for (index, top) in line.iter().enumerate() {
            let beside = [index.checked_sub(1), Some(index + 1)];
            let higher = |other: &Option<usize>| {
                let other = other.and_then(|other| line.get(other));
                other.is_none_or(|other| other.value <= top.value)
            };
            if beside.iter().all(higher) {
                peaks.push((index, *top));
            }
        }
    }
    peaks.sort_by(|a, b| b.1.value.total_cmp(&a.1.value));
    let step = phis.get(1).map_or(0.0, |second| second - phis[0]);
    let climbed: Vec<Top> = peaks
        .par_iter()
        .take(STARTS)
        .map(|(index, top)| {
            let interval = [mus[index.saturating_sub(1)], mus[(index + 1).min(mus.len() - 1)]];
            let mut best = climb(interval, *top, |mu, top| at(mu, top.phi));
            if step > 0.0 && best.value.is_finite() {
                let around = [best.phi - step, best.phi + step];
                best = climb(around, best, |phi, top| at(top.mu, phi));
                best = climb(interval, best, |mu, top| at(mu, top.phi));
            }
            best
        })
        .collect();
    let higher = |a: Top, b: Top| if b.value > a.value { b } else { a };
    climbed.into_iter().reduce(higher).unwrap_or(Top {
        mu: 0.0,
        phi: 0.0,
        value: f64::NEG_INFINITY,
    })
}

/// The highest place of a golden section of [low, high], or `start` where that is higher.
fn climb([mut low, mut high]: [f64; 2], start: Top, at: impl Fn(f64, Top) -> Top) -> Top {
    let mut best = start;
    if !start.value.is_finite() || low >= high {
        return best;
    }
    let mut look = |x: f64| {
        let top = at(x, start);
        if top.value > best.value {
            best = top;
        }
        top.value
    };
    let mut inner = [high - GOLDEN * (high - low), low + GOLDEN * (high - low)];
    let mut found = inner.map(&mut look);
    for _ in 0..CLIMB {
        if found[0] > found[1] {
            high = inner[1];
            inner = [high - GOLDEN * (high - low), inner[0]];
            found = [look(inner[0]), found[0]];
        } else {
            low = inner[0];
            inner = [inner[1], low + GOLDEN * (high - low)];
            found = [found[1], look(inner[1])];
        }
    }
    best
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Peaks of any width at any scale are found to the square of what the climb leaves.
    #[test]
    fn peaks_at_all_scales_are_found() {
        let mus = graded(1e-9, 6, 24);
        assert_eq!((mus[0], mus[mus.len() - 1]), (0.0, 1.0));
        for centre in [1e-8, 1e-4, 0.03, 0.61] {
            let f = |mu: f64, phi: f64| {
                let x = (mu / centre - 1.0) / 0.3;
                1.0 / (1.0 + x * x) + 0.2 * (2.0 * (phi - 0.4)).cos()
            };
            let phis: Vec<f64> = (0..8).map(|k| std::f64::consts::PI * f64::from(k) / 8.0).collect();
            let top = largest(&mus, &phis, f);
            assert!((top.value - 1.2).abs() < 1e-3, "{centre}: {top:?}");
            let level = largest(&mus, &[0.0], |_, _| 0.5);
            assert_eq!(level.value, 0.5);
        }
        assert_eq!(largest(&mus, &[0.0], |mu, _| 1.0 / mu).value, f64::INFINITY);
        assert_eq!(largest(&mus, &[0.0], |_, _| f64::NAN).value, f64::INFINITY);
    }
}
