//! Bakes that several tests look at, each done once; and places.

use crate::engines::Tables;
use crate::gpu::Raw;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use std::sync::OnceLock;
use whitefurnace::engine::{Profile, Sheet, Sizes, bake};
use whitefurnace::table::texture::{LookupError, Texture};

pub(crate) type Baked = Vec<(Sheet, Texture)>;

/// Sizes at which profiles are baked here: all that have cloth or 128 x 128 texels are smaller than they are by default, for time.
fn sizes(profile: Profile) -> Sizes {
    let (mu, roughness) = match profile {
        Profile::Filament | Profile::FilamentMultiscatter | Profile::MaterialX => (20, 12),
        Profile::Godot | Profile::Gltf => (16, 24),
        Profile::Unreal => (32, 16),
        Profile::OpenPbr => (8, 8),
        // full sizes
        Profile::Generic | Profile::Three | Profile::Bevy | Profile::UnityHdrp | Profile::Cycles => {
            return Sizes::default();
        }
    };
    Sizes {
        mu: Some(mu),
        roughness: Some(roughness),
    }
}

pub(crate) fn baked_with(sheets: Vec<Sheet>) -> Baked {
    let mut baked: Baked = Vec::new();
    for sheet in sheets {
        let earlier: Vec<(&Sheet, &Texture)> = baked.iter().map(|(sheet, texture)| (sheet, texture)).collect();
        let texture = bake(&sheet, &earlier, &|_| ()).unwrap().texture;
        baked.push((sheet, texture));
    }
    baked
}

pub(crate) fn baked(profile: Profile) -> &'static Baked {
    static ALL: [OnceLock<Baked>; Profile::ALL.len()] = [const { OnceLock::new() }; Profile::ALL.len()];
    let index = Profile::ALL.iter().position(|other| *other == profile).unwrap();
    ALL[index].get_or_init(|| baked_with(profile.sheets(sizes(profile))))
}

/// The generic pair at 16 x 16 and its mean; that at 32 x 32 is among [`baked`].
pub(crate) fn generic_16() -> &'static Baked {
    static ONE: OnceLock<Baked> = OnceLock::new();
    ONE.get_or_init(|| {
        let size = Sizes {
            mu: Some(16),
            roughness: Some(16),
        };
        let mut sheets = Profile::Generic.sheets(size);
        sheets.retain(|sheet| sheet.name != "sheen");
        baked_with(sheets)
    })
}

pub(crate) fn tables(baked: &Baked) -> Tables {
    baked
        .iter()
        .map(|(sheet, texture)| (sheet.name, Raw::of(texture)))
        .collect()
}

/// What the table `name` states about `of` over its domain.
pub(crate) fn stated<'a>(baked: &'a Baked, name: &str, of: &str) -> &'a LookupError {
    let (sheet, texture) = baked.iter().find(|(sheet, _)| sheet.name == name).unwrap();
    let domain = sheet.domain();
    let mut errors = texture.errors.iter();
    errors.find(|error| error.of == of && error.domain == domain).unwrap()
}

/// Places of the unit cube, one value in twelve on an end, the same in every run.
pub(crate) fn places<const N: usize>(count: usize, seed: u64) -> Vec<[f64; N]> {
    let mut random = Pcg64Mcg::seed_from_u64(seed);
    let mut value = || match random.random_range(0..24) {
        0 => 0.0,
        1 => 1.0,
        _ => random.random::<f64>(),
    };
    (0..count).map(|_| std::array::from_fn(|_| value())).collect()
}

/// From `from` to 1.
pub(crate) fn within(from: f64, part: f64) -> f64 {
    (from + part * (1.0 - from)).min(1.0)
}
