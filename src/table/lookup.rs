//! The lookup that a shader does, on the values that the file stores.

use super::{Storage, Table};
use glam::DVec3;

impl Table {
    /// A linear (1 axis) or bilinear (2 axes) clamp-to-edge lookup of the stored f32 values at `coords`, one value per
    /// axis in the unit of that axis; a NaN among them gives NaN.
    ///
    /// Weights are f64. Graphics hardware may quantise them to 8 bits, which costs up to 1/512 of the step between
    /// neighbouring texels per axis and is no property of the table.
    ///
    /// # Panics
    /// When `coords` does not hold exactly one value per axis.
    pub fn sample(&self, coords: &[f64]) -> DVec3 {
        self.sample_as(Storage::F32, coords)
    }

    /// The same lookup in a texture that keeps the values as `storage` holds them; filtering itself is exact.
    ///
    /// # Panics
    /// When `coords` does not hold exactly one value per axis.
    pub fn sample_as(&self, storage: Storage, coords: &[f64]) -> DVec3 {
        assert_eq!(coords.len(), self.axes.len(), "one coordinate per axis");
        let [width, _] = self.size();
        let x = self.neighbours(0, coords);
        let y = self.neighbours(1, coords);
        let texel = |i: usize| DVec3::from_array(self.values[i].to_array().map(|value| storage.round(value)));
        let row = |j: usize| mix(texel(j * width + x.low), texel(j * width + x.high), x.weight);
        mix(row(y.low), row(y.high), y.weight)
    }

    /// The two texels along axis `k` around a coordinate; texel 0 alone where the table has no such axis.
    fn neighbours(&self, k: usize, coords: &[f64]) -> Neighbours {
        let Some(axis) = self.axes.get(k) else {
            return Neighbours {
                low: 0,
                high: 0,
                weight: 0.0,
            };
        };
        let position = axis.texel_position(axis.u(coords[k]));
        let low = position.floor() as usize; // NaN becomes texel 0 and survives in the weight
        Neighbours {
            low,
            high: (low + 1).min(axis.size - 1),
            weight: position - position.floor(),
        }
    }
}

/// Two neighbouring texels and the weight of the higher one.
struct Neighbours {
    low: usize,
    high: usize,
    weight: f64,
}

/// `a` at `weight` 0, exactly, so that a lookup at a texel returns the texel.
fn mix(a: DVec3, b: DVec3, weight: f64) -> DVec3 {
    a + (b - a) * weight
}

#[cfg(test)]
mod tests {
    use crate::table::Storage;
    use crate::table::axis::{Axis, Mapping, TexelRule};
    use crate::table::samples::{grey_2d, rgb_1d, scalar};
    use glam::DVec3;

    #[test]
    fn texels_come_back_as_stored() {
        for table in [grey_2d(), rgb_1d(), scalar()] {
            for i in 0..table.values.len() {
                let found = table.sample(&table.texel_values(i));
                assert!((found - table.stored(i)).abs().max_element() < 1e-12, "{i}");
            }
        }
        assert_eq!(scalar().sample(&[]), scalar().stored(0));
    }

    /// A lookup mixes two or four stored values, so that it is off by their rounding at most.
    #[test]
    fn lookups_in_other_formats_are_off_by_their_rounding() {
        let table = grey_2d();
        for storage in Storage::ALL {
            let mut most: f64 = 0.0;
            for i in 0..500 {
                let place = [f64::from(i) / 499.0, 0.1 * 1e13f64.powf(f64::from(i * 7 % 500) / 499.0)];
                let [exact, found] = [Storage::F32, storage].map(|storage| table.sample_as(storage, &place).x);
                assert!(
                    (found - exact).abs() <= storage.rounding(1.0) + 6e-8,
                    "{storage:?} at {place:?}"
                );
                most = most.max((found - exact).abs());
            }
            assert_eq!(most > 0.0, storage != Storage::F32, "{storage:?}");
        }
        assert_eq!(table.sample(&[0.3, 17.0]), table.sample_as(Storage::F32, &[0.3, 17.0]));
    }

    #[test]
    fn lookups_are_linear_between_texels_and_clamped_beyond() {
        let mut table = grey_2d();
        let [width, height] = table.size();
        table.axes = vec![
            Axis::new("mu", Mapping::SqrtMu, TexelRule::Ends, [0.0, 1.0], width).unwrap(),
            Axis::new("kappa", Mapping::Log, TexelRule::Centres, [1.0, 4096.0], height).unwrap(),
        ];
        for (i, value) in table.values.iter_mut().enumerate() {
            *value = DVec3::splat((i % width) as f64 + 100.0 * (i / width) as f64);
        }
        let kappa = |u: f64| 4096f64.powf(u);
        // Column 2.5 of 0..=7, row 1.25 of 4 centres.
        let mu = (2.5f64 / 7.0).powi(2);
        let found = table.sample(&[mu, kappa((1.25 + 0.5) / 4.0)]).x;
        assert!((found - 127.5).abs() < 1e-10, "{found}");
        assert_eq!(table.sample(&[0.0, 1.0]).x, 0.0);
        assert_eq!(table.sample(&[1.0, 4096.0]).x, 307.0);
        assert_eq!(table.sample(&[9.0, 1e9]).x, 307.0);
        assert!(table.sample(&[f64::NAN, 2.0]).x.is_nan());
    }
}
