//! A table as its file states it: values rounded to f32, errors that count the rounding, and what follows from both.

use super::{ErrorKind, Table};
use glam::DVec3;
use statrs::distribution::{ContinuousCDF, Normal};

/// A value that exceeds 1 by more than its error.
#[derive(Debug, Clone, PartialEq)]
pub struct Excess {
    /// How far the value less its error lies above 1.
    pub excess: f64,
    /// The stored value.
    pub value: f64,
    /// Its error.
    pub error: f64,
    /// Channel, 0 to 2.
    pub channel: usize,
    /// Where: one value per axis, in the unit of that axis.
    pub at: Vec<f64>,
}

impl Table {
    /// The value of texel `i` as the file stores it: rounded to f32.
    pub fn stored(&self, i: usize) -> DVec3 {
        self.values[i].as_vec3().as_dvec3()
    }

    /// The error of the stored value of texel `i`: that of the integration plus the rounding to f32, itself rounded up
    /// to f32 so that the file never understates it.
    pub fn texel_error(&self, i: usize) -> DVec3 {
        let rounding = (self.stored(i) - self.values[i]).abs();
        let error = self.errors[i];
        DVec3::from_array([0, 1, 2].map(|channel| {
            let sum = error[channel] + rounding[channel];
            // A sum of two positive numbers may itself have been rounded down.
            let exact = error[channel] == 0.0 || rounding[channel] == 0.0;
            f64::from(round_up(if exact { sum } else { sum.next_up() }))
        }))
    }

    /// Largest error of any texel and channel: the tolerance reached.
    pub fn max_texel_error(&self) -> f64 {
        (0..self.errors.len()).fold(0.0, |max, i| self.texel_error(i).max_element().max(max))
    }

    /// Largest error that a shader may see: between texels where that was measured, and otherwise at them.
    pub fn max_lookup_error(&self) -> f64 {
        self.between
            .as_ref()
            .map_or_else(|| self.max_texel_error(), |between| between.error)
    }

    /// Smallest and largest stored value.
    pub fn range(&self) -> (f64, f64) {
        (0..self.values.len()).fold((f64::INFINITY, f64::NEG_INFINITY), |(min, max), i| {
            let stored = self.stored(i);
            (min.min(stored.min_element()), max.max(stored.max_element()))
        })
    }

    /// The texel that most exceeds 1 beyond its error, if any does: the model then does not conserve energy.
    ///
    /// Of many 99 % intervals some miss; there the error counts at the confidence that all of the table's together have
    /// 99 %.
    pub fn energy_excess(&self) -> Option<Excess> {
        let widening = match self.error_kind {
            ErrorKind::Ci99 => all_at_once(self.values.len() * self.channels.count()),
            ErrorKind::Bound | ErrorKind::Exact => 1.0,
        };
        let mut worst: Option<(f64, usize, usize)> = None;
        for i in 0..self.values.len() {
            let excess = self.stored(i) - widening * self.texel_error(i) - DVec3::ONE;
            let channel = excess.max_position();
            if excess[channel] > worst.map_or(0.0, |(most, ..)| most) {
                worst = Some((excess[channel], i, channel));
            }
        }
        worst.map(|(excess, i, channel)| Excess {
            excess,
            value: self.stored(i)[channel],
            error: self.texel_error(i)[channel],
            channel,
            at: self.texel_values(i),
        })
    }
}

/// Factor that widens each of `count` 99 % intervals so that all of them together cover at 99 %, by Sidak's correction for
/// normal errors.
fn all_at_once(count: usize) -> f64 {
    let normal = Normal::standard();
    let miss = -libm::expm1(libm::log(0.99f64) / count.max(1) as f64);
    normal.inverse_cdf(0.5 * miss) / normal.inverse_cdf(0.005)
}

/// The smallest f32 that is not below `value`.
pub(super) fn round_up(value: f64) -> f32 {
    let nearest = value as f32;
    if f64::from(nearest) < value {
        nearest.next_up()
    } else {
        nearest
    }
}

#[cfg(test)]
mod tests {
    use super::{ErrorKind, all_at_once};
    use crate::table::samples::{grey_2d, rgb_1d};
    use glam::DVec3;

    #[test]
    fn stored_errors_cover_the_rounding() {
        let mut table = grey_2d();
        for (i, value) in table.values.iter_mut().enumerate() {
            *value = DVec3::splat((i as f64 * 0.7311).fract());
        }
        for error in [0.0, 1e-300, 1e-12, 1e-7, 0.1] {
            table.errors.fill(DVec3::splat(error));
            for i in 0..table.values.len() {
                let distance = (table.stored(i) - table.values[i]).abs().x;
                let stated = table.texel_error(i).x;
                assert!(stated >= error && stated - error >= distance - 1e-23, "{i} {error}");
                assert!(stated <= (error + distance) * (1.0 + 1e-6) + 1e-44);
                assert_eq!(f64::from(stated as f32), stated);
            }
        }
        table.values.fill(DVec3::splat(0.5));
        table.errors.fill(DVec3::ZERO);
        assert_eq!(table.max_texel_error(), 0.0);
    }

    #[test]
    fn what_was_stored_states_the_same_errors_again() {
        let table = rgb_1d();
        let mut again = table.clone();
        for i in 0..table.values.len() {
            again.values[i] = table.stored(i);
            again.errors[i] = table.texel_error(i);
        }
        assert_eq!(again.max_texel_error(), table.max_texel_error());
        assert!((0..table.values.len()).all(|i| again.texel_error(i) == table.texel_error(i)));
        assert_eq!(again.range(), table.range());
    }

    #[test]
    fn energy_excess_is_found_where_it_is_worst_and_beyond_the_error_only() {
        let mut table = grey_2d();
        assert_eq!(table.energy_excess(), None);
        let [width, _] = table.size();
        table.values[2] = DVec3::splat(1.0 + 0.5e-4);
        table.errors[2] = DVec3::splat(1e-4);
        assert_eq!(table.energy_excess(), None, "within its error");
        table.values[width + 3] = DVec3::splat(1.25);
        table.values[2] = DVec3::splat(1.125);
        let excess = table.energy_excess().unwrap();
        assert_eq!((excess.value, excess.channel), (1.25, 0));
        assert_eq!(excess.at, vec![table.axes[0].texel(3), table.axes[1].texel(1)]);
        assert!((excess.excess - (0.25 - excess.error)).abs() < 1e-15);

        let mut table = rgb_1d();
        table.values[1].z = 2.0;
        assert_eq!(table.energy_excess().unwrap().channel, 2);
    }

    /// Of 4096 intervals of 99 % some forty miss: one that misses by a little is no finding, one that misses by far is.
    #[test]
    fn one_interval_of_many_is_no_finding() {
        assert!((all_at_once(1) - 1.0).abs() < 1e-12);
        let widening = all_at_once(4096);
        // two-sided normal quantiles at 0.01 and at 1 - 0.99^(1/4096), from another library
        assert!(
            (widening - 4.711940335836571 / 2.575829303548901).abs() < 1e-9,
            "{widening}"
        );
        let mut table = grey_2d();
        table.values.fill(DVec3::splat(0.5));
        table.errors.fill(DVec3::splat(0.01));
        table.error_kind = ErrorKind::Ci99;
        table.values[1] = DVec3::splat(1.0101);
        assert_eq!(table.energy_excess(), None);
        table.values[1] = DVec3::splat(1.03);
        assert!(table.energy_excess().is_some());
    }
}
