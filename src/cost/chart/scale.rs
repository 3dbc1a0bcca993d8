//! Axes of charts: from numbers to places, and the marks beside them.

use super::font::power_of_ten;

/// An axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Scale {
    pub(super) min: f64,
    pub(super) max: f64,
    pub(super) kind: Kind,
}

/// How places follow numbers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    Linear,
    /// By powers of ten.
    Decades,
    /// By powers of two, which are named as they are.
    Octaves,
}

/// Most named marks along an axis.
const MARKS: usize = 7;

impl Scale {
    /// Wide enough for `values` and a little more; of logarithmic axes only positive values count.
    pub(super) fn around(kind: Kind, values: impl Iterator<Item = f64>) -> Self {
        let usable = values.filter(|value| value.is_finite() && (kind == Kind::Linear || *value > 0.0));
        let (min, max) = usable.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| (a.min(v), b.max(v)));
        let (min, max) = if min <= max { (min, max) } else { (1.0, 10.0) };
        let (min, max) = match kind {
            // these start at 0, unless something lies below
            Kind::Linear => (
                min.min(0.0),
                if max > min.min(0.0) {
                    max + 0.06 * max.abs()
                } else {
                    max + 1.0
                },
            ),
            Kind::Decades => {
                // a tenth of a decade of air, and never less than one decade
                let (low, high) = (min.log10() - 0.12, max.log10() + 0.12);
                let extra = (0.5 * (1.0 - (high - low))).max(0.0);
                (10f64.powf(low - extra), 10f64.powf(high + extra))
            }
            Kind::Octaves => (min / 1.25, max * 1.25),
        };
        Self { min, max, kind }
    }

    /// Where `value` lies, 0 at the minimum and 1 at the maximum.
    pub(super) fn place(&self, value: f64) -> f64 {
        match self.kind {
            Kind::Linear => (value - self.min) / (self.max - self.min),
            Kind::Decades | Kind::Octaves => (value / self.min).ln() / (self.max / self.min).ln(),
        }
    }

    /// Values that are named, with their names.
    pub(super) fn marks(&self) -> Vec<(f64, String)> {
        match self.kind {
            Kind::Linear => {
                let step = nice((self.max - self.min) / 5.0);
                let first = (self.min / step).ceil() as i64;
                let last = (self.max / step).floor() as i64;
                (first..=last)
                    .map(|k| (k as f64 * step, plain(k as f64 * step, step)))
                    .collect()
            }
            Kind::Decades => {
                let named = self.powers(10.0, power_of_ten);
                match named.len() {
                    0 | 1 => self.subdivided(),
                    _ => named,
                }
            }
            Kind::Octaves => self.powers(2.0, |k| plain(2f64.powi(k), 1.0)),
        }
    }

    /// Whole powers of `base`, thinned out evenly where there are many.
    fn powers(&self, base: f64, name: impl Fn(i32) -> String) -> Vec<(f64, String)> {
        let log = |value: f64| value.ln() / base.ln();
        let (first, last) = (
            (log(self.min) - 1e-9).ceil() as i32,
            (log(self.max) + 1e-9).floor() as i32,
        );
        let count = (last - first + 1).max(0) as usize;
        let step = count.div_ceil(MARKS).max(1) as i32;
        (first..=last)
            .filter(|k| k.rem_euclid(step) == 0)
            .map(|k| (base.powi(k), name(k)))
            .collect()
    }

    /// 1, 2 and 5 of every decade, for axes of little more than one.
    fn subdivided(&self) -> Vec<(f64, String)> {
        let decades = self.min.log10().floor() as i32..=self.max.log10().ceil() as i32;
        let marks = decades.flat_map(|k| [1.0, 2.0, 5.0].map(|d| (d * 10f64.powi(k), d, k)));
        marks
            .filter(|(value, ..)| *value >= self.min && *value <= self.max)
            .map(|(value, d, k)| match d {
                1.0 => (value, power_of_ten(k)),
                _ => (value, format!("{d}\u{b7}{}", power_of_ten(k))),
            })
            .collect()
    }
}

/// 1, 2 or 5 times a power of ten, not below `step`.
fn nice(step: f64) -> f64 {
    let power = 10f64.powf(step.log10().floor());
    let factor = [1.0, 2.0, 5.0].into_iter().find(|factor| factor * power >= step);
    factor.unwrap_or(10.0) * power
}

/// A number with the digits that its step calls for.
fn plain(value: f64, step: f64) -> String {
    let digits = (-step.log10().floor()).max(0.0) as usize;
    format!("{value:.digits$}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_run_from_end_to_end() {
        for kind in [Kind::Linear, Kind::Decades, Kind::Octaves] {
            let scale = Scale::around(kind, [3.0, 7.0, 40.0].into_iter());
            assert!(scale.place(scale.min).abs() < 1e-12 && (scale.place(scale.max) - 1.0).abs() < 1e-12);
            assert!(scale.place(3.0) > 0.0 && scale.place(7.0) < scale.place(40.0) && scale.place(40.0) < 1.0);
        }
    }

    #[test]
    fn marks_are_round_numbers_within_the_axis_and_few() {
        let names = |scale: &Scale| scale.marks().into_iter().map(|(_, name)| name).collect::<Vec<_>>();
        let errors = Scale::around(Kind::Decades, [1e-13, 1.0].into_iter());
        let shown = errors.marks();
        assert!(shown.len() >= 4 && shown.len() <= MARKS, "{shown:?}");
        assert!(
            shown
                .iter()
                .all(|(value, _)| *value >= errors.min && *value <= errors.max)
        );
        let sizes = Scale::around(Kind::Octaves, [8.0, 64.0].into_iter());
        assert_eq!(names(&sizes), ["8", "16", "32", "64"]);
        let linear = Scale::around(Kind::Linear, [0.0, 12.0].into_iter());
        assert_eq!(names(&linear), ["0", "5", "10"]);
        assert_eq!(
            names(&Scale::around(Kind::Linear, [0.2].into_iter())),
            ["0.00", "0.05", "0.10", "0.15", "0.20"]
        );
        assert!(Scale::around(Kind::Decades, [2.0, 3.0].into_iter()).marks().len() >= 2);
        // nothing to show is no reason to fail
        assert!(!Scale::around(Kind::Decades, std::iter::empty()).marks().is_empty());
        assert!(
            !Scale::around(Kind::Decades, [0.0, f64::NAN, f64::INFINITY].into_iter())
                .marks()
                .is_empty()
        );
    }
}
