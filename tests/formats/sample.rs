//! Textures of all shapes.

use whitefurnace::table::Storage;
use whitefurnace::table::axis::{Axis, Mapping, TexelRule};
use whitefurnace::table::texture::{Channel, LookupError, Texture, TextureAxis};

/// A texture with so many axes and channels. Its values need every bit of f32, and 0 and 1 are among them.
pub(crate) fn texture(axes: usize, channels: usize, storage: Storage) -> Texture {
    let axis = |name: &str, mapping, rule, range, size| Axis::new(name, mapping, rule, range, size).unwrap();
    let mut all = vec![
        TextureAxis::along(axis("mu", Mapping::SqrtMu, TexelRule::Centres, [0.0, 1.0], 7)),
        TextureAxis::along(axis("kappa", Mapping::Log1p, TexelRule::Ends, [0.5, 4096.0], 5)),
        TextureAxis::along(axis("f0", Mapping::Linear, TexelRule::Ends, [-0.25, 1.0], 3)),
    ];
    all[1].flipped = true;
    all.truncate(axes);
    let count = all.iter().map(|axis| axis.axis.size).product::<usize>() * channels;
    let mut values: Vec<f64> = (0..count).map(|i| (i as f64 * 0.618_033_988_749_895).fract()).collect();
    values[count / 2] = 1.0;
    let channel = |index: usize| Channel {
        name: ["scale", "bias", "total", "rest"][index].into(),
        meaning: format!("channel {index}: größer als null,\n{index} in all */ and // more"),
    };
    let texture = Texture {
        id: format!("sample-{axes}.{channels}_{}", storage.name()),
        errors: vec![LookupError {
            of: "scale".into(),
            max: 1.0 / 3.0,
            mean: 1e-7,
            at: all.iter().map(|axis| axis.axis.max).collect(),
            domain: all.iter().map(|axis| [axis.axis.min, axis.axis.max]).collect(),
            probes: 1 << 60,
        }],
        axes: all,
        channels: (0..channels).map(channel).collect(),
        storage,
        values,
        facts: vec![
            ("lobe".into(), "reflection".into()),
            ("Größe".into(), "17\n#error \u{2028} int x; \\".into()),
        ],
    };
    texture.rounded().unwrap()
}

/// Every number of axes and channels in `storage`.
pub(crate) fn shapes(storage: Storage) -> impl Iterator<Item = Texture> {
    (1..=3).flat_map(move |axes| (1..=4).map(move |channels| texture(axes, channels, storage)))
}

/// Every shape in every storage.
pub(crate) fn all() -> impl Iterator<Item = Texture> {
    Storage::ALL.into_iter().flat_map(shapes)
}
