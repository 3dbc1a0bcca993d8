//! The formats that textures keep values in, and what each costs in accuracy.

use super::Table;
use half::f16;

named!(
    /// How a texture keeps one channel of one texel.
    Storage {
        /// 32-bit float: 24 bits of every value.
        F32 = "f32",
        /// 16-bit float: 11 bits of every value, finer steps where values are small.
        F16 = "f16",
        /// 16-bit unsigned normalised integer: [0, 1] in 65535 equal steps.
        Unorm16 = "unorm16",
        /// 8-bit unsigned normalised integer: [0, 1] in 255 equal steps.
        Unorm8 = "unorm8",
    }
);

impl Storage {
    /// Every format, from the most exact to the smallest.
    pub const ALL: [Self; 4] = [Self::F32, Self::F16, Self::Unorm16, Self::Unorm8];

    /// Bytes of one channel of one texel.
    pub fn bytes(self) -> usize {
        match self {
            Self::F32 => 4,
            Self::F16 | Self::Unorm16 => 2,
            Self::Unorm8 => 1,
        }
    }

    /// What a shader reads where `value` was stored: the value of the format that is nearest to its f32, for that is what
    /// files hold and textures are packed from.
    ///
    /// Beyond the ends of a format that is its end, or infinity, as when a texture is packed; whether that happens, and
    /// [`Storage::rounding`] then says nothing, is what [`Storage::holds`] tells.
    pub fn round(self, value: f64) -> f64 {
        let stored = value as f32;
        match self {
            Self::F32 => f64::from(stored),
            Self::F16 => f16::from_f32(stored).to_f64(),
            Self::Unorm16 => steps(f64::from(stored), 65535.0),
            Self::Unorm8 => steps(f64::from(stored), 255.0),
        }
    }

    /// Bound of |round(value) - value| for a `value` that the format [holds](Storage::holds).
    pub fn rounding(self, value: f64) -> f64 {
        // half a unit in the last of 24 or 11 bits; below the smallest normal number, half of the smallest step
        let single = (value.abs() * 2f64.powi(-24)).max(2f64.powi(-150));
        match self {
            Self::F32 => single,
            Self::F16 => (value.abs() * 2f64.powi(-11)).max(2f64.powi(-25)) + single,
            Self::Unorm16 => 0.5 / 65535.0 + single,
            Self::Unorm8 => 0.5 / 255.0 + single,
        }
    }

    /// Whether `value` lies within half a step of what the format can say.
    ///
    /// Integers end at 1: an albedo of 1 that its own error puts at 1 + 1e-7 is held, one of 1.02 is not.
    pub fn holds(self, value: f64) -> bool {
        match self {
            Self::F32 => (value as f32).is_finite(),
            Self::F16 => f16::from_f32(value as f32).is_finite(),
            Self::Unorm16 | Self::Unorm8 => (self.round(value) - value).abs() <= self.rounding(value),
        }
    }
}

/// The nearest of the fractions i/`count`, ties away from 0.
fn steps(value: f64, count: f64) -> f64 {
    (value.clamp(0.0, 1.0) * count).round() / count
}

impl Table {
    /// Whether every texel can be kept in `storage` without clipping.
    pub fn fits(&self, storage: Storage) -> bool {
        self.values
            .iter()
            .all(|value| value.to_array().into_iter().all(|value| storage.holds(value)))
    }

    /// Bytes of all texels as a texture: its channels in `storage`, without padding.
    pub fn texture_bytes(&self, storage: Storage) -> usize {
        let [width, height] = self.size();
        width * height * self.channels.count() * storage.bytes()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::table::samples::{grey_2d, rgb_1d};
    use glam::DVec3;

    /// Values of all magnitudes that tables have, ends and neighbours of steps included.
    fn values() -> Vec<f64> {
        let spread = (0..4000).map(|i| (f64::from(i) * 0.618_033_988_749_895).fract());
        let small = (0..400).map(|i| 10f64.powf(-0.025 * f64::from(i)));
        let edges = [
            0.0,
            1.0,
            0.5,
            1.0 / 255.0,
            0.5 / 255.0,
            1.5 / 65535.0,
            1e-40,
            6.1e-5,
            5.9e-8,
        ];
        spread.chain(small).chain(edges).collect()
    }

    #[test]
    fn rounding_is_bounded_and_reached() {
        for storage in Storage::ALL {
            let mut most: f64 = 0.0;
            for value in values() {
                let found = storage.round(value);
                let (error, bound) = ((found - value).abs(), storage.rounding(value));
                assert!(error <= bound, "{storage:?} {value}: {error} > {bound}");
                assert!(storage.holds(value));
                assert_eq!(
                    storage.round(found),
                    found,
                    "{storage:?}: what was stored is stored again"
                );
                most = most.max(error / bound);
            }
            // a bound that nothing comes near would hide a wrong format
            assert!(most > 0.99, "{storage:?} uses {most} of its bound");
        }
    }

    /// Values and bits from the definition of the formats: 1/3 in IEEE 754 binary32 and binary16, 21845 = 65535/3, 85 = 255/3.
    #[test]
    fn formats_are_those_of_their_definitions() {
        let third = |storage: Storage| storage.round(1.0 / 3.0);
        assert_eq!(third(Storage::F32), f64::from(f32::from_bits(0x3eaa_aaab)));
        assert_eq!(third(Storage::F16), f16::from_bits(0x3555).to_f64());
        assert_eq!(third(Storage::Unorm16), 21845.0 / 65535.0);
        assert_eq!(third(Storage::Unorm8), 85.0 / 255.0);
        // halfway between 1 and 1 + 2^-10 for every bit that f32 keeps: ties go to the even one
        let tie = 1.0 + 2f64.powi(-11) + 2f64.powi(-40);
        assert_eq!(Storage::F16.round(tie), 1.0);
        assert_eq!(Storage::F16.round(tie + 2f64.powi(-23)), 1.0 + 2f64.powi(-10));
        assert_eq!(Storage::ALL.map(Storage::bytes), [4, 2, 2, 1]);
        for storage in Storage::ALL {
            assert_eq!(Storage::from_name(storage.name()), Some(storage));
        }
    }

    #[test]
    fn clipping_is_told() {
        for (value, held) in [
            (1.0, [true, true, true, true]),
            (1.0 + 1e-7, [true, true, true, true]),
            (1.001, [true, true, false, true]),
            (1.02, [true, true, false, false]),
            (-1e-7, [true, true, true, true]),
            (-0.01, [true, true, false, false]),
            (1e5, [true, false, false, false]),
            (1e39, [false, false, false, false]),
            (f64::NAN, [false, false, false, false]),
        ] {
            assert_eq!(Storage::ALL.map(|storage| storage.holds(value)), held, "{value}");
        }
        let mut table = grey_2d();
        assert!(Storage::ALL.iter().all(|storage| table.fits(*storage)));
        table.values[31] = DVec3::splat(1.02);
        assert_eq!(
            Storage::ALL.map(|storage| table.fits(storage)),
            [true, true, false, false]
        );
    }

    #[test]
    fn textures_have_the_bytes_of_their_channels() {
        assert_eq!(rgb_1d().texture_bytes(Storage::F16), 8 * 3 * 2);
        assert_eq!(grey_2d().texture_bytes(Storage::Unorm8), 32);
    }
}
