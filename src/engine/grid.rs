//! Places within a texture, cell by cell, and the texels that a lookup there mixes.

use crate::table::texture::TextureAxis;

/// A place along one axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Place {
    /// Value of the parameter.
    pub(super) value: f64,
    /// The stretch of values that it stands for.
    pub(super) measure: f64,
    /// The texels on both sides.
    pub(super) low: usize,
    pub(super) high: usize,
    /// Weight of the higher one.
    pub(super) weight: f64,
}

/// Where along an axis lookups are looked at.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Places(pub(super) Vec<Place>);

impl Places {
    /// A place in each of `per_cell` equal parts of each cell between neighbouring texels, before the first and behind the last texel
    /// centre; the ends of `domain` divide the cells that they lie in. Each place stands for the values of its part.
    ///
    /// What is fitted errs by much the same in neighbouring cells, of either sign within each: places at the same share of every
    /// cell would see too little of it, or too much. Steps of the golden section from cell to cell spread them over all shares.
    pub(super) fn spread(axis: &TextureAxis, per_cell: usize, domain: [f64; 2]) -> Self {
        let mut places = Vec::new();
        let mut borders = borders(axis);
        borders.extend(domain.map(|value| axis.axis.u(value)));
        borders.sort_by(f64::total_cmp);
        borders.dedup();
        for (cell, pair) in borders.windows(2).enumerate() {
            let [from, to] = [pair[0], pair[1]];
            let share = ((cell as f64 + 0.5) * GOLDEN).fract();
            for i in 0..per_cell {
                let at = |part: usize| axis.axis.value(from + (to - from) * (part as f64 / per_cell as f64));
                let (start, end) = (at(i), at(i + 1));
                // to both sides of the middle in turn: what grows along the cell is seen as it is on average
                let share = if i % 2 == 0 { share } else { 1.0 - share };
                places.push(place(axis, start + (end - start) * share, end - start));
            }
        }
        Self(places)
    }

    /// The places of the texels themselves.
    pub(super) fn texels(axis: &TextureAxis) -> Self {
        Self((0..axis.axis.size).map(|i| place(axis, axis.texel(i), 1.0)).collect())
    }

    /// The borders of `per_cell` equal parts of each cell, texels among them: what is interpolated has its kinks, and so the extremes
    /// of its error, there. Each stands for the values that are nearest to it.
    pub(super) fn borders(axis: &TextureAxis, per_cell: usize) -> Self {
        let mut at = vec![0.0];
        for pair in borders(axis).windows(2) {
            at.extend((1..=per_cell).map(|i| pair[0] + (pair[1] - pair[0]) * (i as f64 / per_cell as f64)));
        }
        let value = |k: usize| axis.axis.value(at[k]);
        let middle = |k: usize| axis.axis.value(0.5 * (at[k] + at[k + 1]));
        let last = at.len() - 1;
        let measure = |k: usize| {
            let from = if k == 0 { value(0) } else { middle(k - 1) };
            let to = if k == last { value(last) } else { middle(k) };
            to - from
        };
        Self((0..=last).map(|k| place(axis, value(k), measure(k))).collect())
    }

    /// The same places and the ends of `domain`, where errors are often the largest; each stands for a stretch of `end`.
    pub(super) fn and_ends(mut self, axis: &TextureAxis, domain: [f64; 2], end: f64) -> Self {
        self.0.extend(domain.map(|value| place(axis, value, end)));
        self
    }

    pub(super) fn len(&self) -> usize {
        self.0.len()
    }
}

/// The golden section, whose multiples fill [0, 1) most evenly.
const GOLDEN: f64 = 0.618_033_988_749_894_8;

/// Coordinates u of the texels, and the ends 0 and 1 where they lie beyond.
pub(super) fn borders(axis: &TextureAxis) -> Vec<f64> {
    let mut borders = vec![0.0];
    borders.extend((0..axis.axis.size).map(|i| axis.axis.texel_u(i)));
    borders.push(1.0);
    borders.dedup();
    borders
}

/// `value`, with the texels that hardware mixes there.
pub(super) fn place(axis: &TextureAxis, value: f64, measure: f64) -> Place {
    let n = axis.axis.size as f64;
    let position = (axis.coordinate(value) * n - 0.5).clamp(0.0, n - 1.0);
    let low = (position.floor() as usize).min(axis.axis.size.saturating_sub(2));
    Place {
        value,
        measure,
        low,
        high: (low + 1).min(axis.axis.size - 1),
        weight: position - low as f64,
    }
}

/// All combinations of places along up to three axes, the first axis fastest.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Grid {
    pub(super) places: Vec<Places>,
    /// Texels along each axis, 1 where there is none.
    size: [usize; 3],
}

/// Texels that a lookup mixes, with their weights; the first `count` entries count.
#[derive(Debug, Clone, Copy)]
pub(super) struct Mix {
    pub(super) texels: [usize; 8],
    pub(super) weights: [f64; 8],
    pub(super) count: usize,
}

impl Mix {
    /// What the lookup reads.
    pub(super) fn of(&self, values: &[f64]) -> f64 {
        (0..self.count).map(|k| self.weights[k] * values[self.texels[k]]).sum()
    }
}

impl Grid {
    pub(super) fn new(axes: &[TextureAxis], places: Vec<Places>) -> Self {
        let size = [0, 1, 2].map(|k| axes.get(k).map_or(1, |axis| axis.axis.size));
        Self { places, size }
    }

    /// Number of places.
    pub(super) fn len(&self) -> usize {
        self.places.iter().map(Places::len).product()
    }

    /// The place along each axis.
    fn at(&self, index: usize) -> impl Iterator<Item = &Place> {
        let mut rest = index;
        self.places.iter().map(move |places| {
            let place = &places.0[rest % places.len()];
            rest /= places.len();
            place
        })
    }

    /// Values of the parameters, one per axis.
    pub(super) fn values(&self, index: usize) -> Vec<f64> {
        self.at(index).map(|place| place.value).collect()
    }

    /// Product of the measures.
    pub(super) fn measure(&self, index: usize) -> f64 {
        self.at(index).map(|place| place.measure).product()
    }

    /// Whether every value lies within `domain`.
    pub(super) fn is_within(&self, index: usize, domain: &[[f64; 2]]) -> bool {
        let within = |(place, [from, to]): (&Place, &[f64; 2])| place.value >= *from && place.value <= *to;
        self.at(index).zip(domain).all(within)
    }

    /// The texels that a lookup mixes.
    pub(super) fn mix(&self, index: usize) -> Mix {
        let mut mix = Mix {
            texels: [0; 8],
            weights: [0.0; 8],
            count: 1,
        };
        mix.weights[0] = 1.0;
        let mut stride = 1;
        for (k, place) in self.at(index).enumerate() {
            for i in 0..mix.count {
                let (texel, weight) = (mix.texels[i], mix.weights[i]);
                mix.texels[i] = texel + place.low * stride;
                mix.weights[i] = weight * (1.0 - place.weight);
                mix.texels[mix.count + i] = texel + place.high * stride;
                mix.weights[mix.count + i] = weight * place.weight;
            }
            mix.count *= 2;
            stride *= self.size[k];
        }
        mix
    }

    /// Number of texels.
    pub(super) fn texels(&self) -> usize {
        self.size.iter().product()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::table::Storage;
    use crate::table::axis::{Axis, Mapping, TexelRule};
    use crate::table::texture::{Channel, Texture};

    fn axes(rule: TexelRule, flipped: bool) -> Vec<TextureAxis> {
        let axis = |name: &str, mapping, size| TextureAxis {
            axis: Axis::new(name, mapping, rule, [0.0, 1.0], size).unwrap(),
            flipped,
        };
        vec![axis("mu", Mapping::SqrtMu, 5), axis("roughness", Mapping::Linear, 4)]
    }

    /// Weights come from the coordinate, and values of a texture by the lookup of hardware: two ways to the same number.
    #[test]
    fn mixes_are_lookups() {
        for (rule, flipped) in [
            (TexelRule::Centres, false),
            (TexelRule::Ends, false),
            (TexelRule::Centres, true),
        ] {
            let axes = axes(rule, flipped);
            let values: Vec<f64> = (0..20).map(|i| (f64::from(i) * 0.618).fract()).collect();
            let texture = Texture {
                id: "t".into(),
                axes: axes.clone(),
                channels: vec![Channel {
                    name: "x".into(),
                    meaning: "x".into(),
                }],
                storage: Storage::F32,
                values: values.iter().map(|value| Storage::F32.round(*value)).collect(),
                errors: Vec::new(),
                facts: Vec::new(),
            };
            let places = axes
                .iter()
                .map(|axis| Places::borders(axis, 3).and_ends(axis, [0.0, 1.0], 0.0));
            let places = places.collect();
            let grid = Grid::new(&axes, places);
            for index in 0..grid.len() {
                let found = grid.mix(index).of(&texture.values);
                let expected = texture.lookup(&grid.values(index))[0];
                assert!((found - expected).abs() < 1e-14, "{index}: {found} {expected}");
            }
        }
    }

    #[test]
    fn measures_add_up_to_the_range() {
        for rule in TexelRule::ALL {
            for axis in axes(rule, false) {
                for places in [Places::spread(&axis, 4, [0.1, 0.9]), Places::borders(&axis, 4)] {
                    let sum: f64 = places.0.iter().map(|place| place.measure).sum();
                    assert!((sum - 1.0).abs() < 1e-14, "{axis:?}: {sum}");
                    let mean: f64 = places.0.iter().map(|place| place.measure * place.value).sum();
                    assert!((mean - 0.5).abs() < 2e-3, "{axis:?}: {mean}"); // places of a part are not in its middle
                }
            }
        }
    }
}
