//! What a texture unit does, from the numbers of a file alone.

use whitefurnace::table::texture::Texture;

/// Texels as they are uploaded.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Raw {
    /// Width, height and depth.
    pub(crate) size: [usize; 3],
    pub(crate) channels: usize,
    /// Channels fastest, then width, height and depth.
    pub(crate) values: Vec<f64>,
}

impl Raw {
    pub(crate) fn of(texture: &Texture) -> Self {
        Self {
            size: texture.size(),
            channels: texture.channels.len(),
            values: texture.values.clone(),
        }
    }

    /// One channel of the texel in column `x`, row `y`.
    pub(crate) fn texel(&self, x: usize, y: usize, channel: usize) -> f64 {
        self.values[(y * self.size[0] + x) * self.channels + channel]
    }

    /// A channel at texture coordinates, linear and clamped to the edge. Each texel weighs by the product of its tents,
    /// max(0, 1 - distance in texels); a place beyond the outermost centres is at distance 0 from those.
    pub(crate) fn fetch<const N: usize>(&self, at: [f64; N], channel: usize) -> f64 {
        let mut sum = 0.0;
        let around = |k: usize| {
            let n = self.size[k];
            let place = (at[k] * n as f64).max(0.5).min(n as f64 - 0.5);
            let first = (place - 0.5) as usize;
            [first, first + 1].map(|i| (i.min(n - 1), (1.0 - (place - i as f64 - 0.5).abs()).max(0.0)))
        };
        let one = [(0, 1.0), (0, 0.0)];
        let along = [0, 1, 2].map(|k| if k < N { around(k) } else { one });
        for (z, c) in along[2] {
            for (y, b) in along[1] {
                for (x, a) in along[0] {
                    let index = ((z * self.size[1] + y) * self.size[0] + x) * self.channels + channel;
                    sum += a * b * c * self.values[index];
                }
            }
        }
        sum
    }
}
