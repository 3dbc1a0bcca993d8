//! Whether what a shader forms is within what the table states, at fresh places against fresh integrals.

use crate::engines::{Tables, albedo, cycles_3d, disney, index_coordinate, openpbr_glass, sheen, total};
use crate::shared::{Baked, places, stated, within};
use crate::truth;
use rayon::prelude::*;
use whitefurnace::engine::Profile;

/// What integrals of this test may be off by, relative to an albedo of at least 0.2, resp. of a dielectric of at least 1e-3.
const DOUBT: f64 = 5e-8;
const DIELECTRIC_DOUBT: f64 = 1e-5;

/// The table of a profile whose errors are those of the split sum, and of sheen.
fn of_metal(profile: Profile) -> &'static str {
    match profile {
        Profile::Generic => "pair",
        Profile::Filament | Profile::Bevy => "dfg",
        Profile::FilamentMultiscatter => "dfg_multiscatter",
        Profile::Three => "dfgLUT",
        Profile::Godot => "dfg_lut",
        Profile::Gltf => "lut_ggx",
        Profile::UnityHdrp => "preintegrated_fgd",
        Profile::Unreal => "preintegrated_gf",
        Profile::MaterialX => "albedo_table",
        Profile::Cycles => "table_ggx_E",
        Profile::OpenPbr => "ideal_metal_energy_complement",
    }
}

fn of_sheen(profile: Profile) -> &'static str {
    match profile {
        Profile::Generic => "sheen",
        Profile::Gltf => "lut_sheen_E",
        _ => of_metal(profile),
    }
}

/// The largest of `error` over `count` places of the domain, `from` per axis up to 1, is within `limit`, and not far below: a stated
/// maximum is one that is met, of 2000 places at least to a tenth.
fn largest<const N: usize>(
    (label, limit): (&str, f64),
    (count, seed): (usize, u64),
    from: [f64; N],
    error: impl Fn([f64; N]) -> f64 + Sync,
) {
    let all: Vec<([f64; N], f64)> = places::<N>(count, seed)
        .into_par_iter()
        .map(|parts| {
            let at = std::array::from_fn(|k| within(from[k], parts[k]));
            (at, error(at))
        })
        .collect();
    let (at, worst) = all
        .into_iter()
        .fold(([0.0; N], -1.0), |a, b| if b.1 > a.1 { b } else { a });
    eprintln!("{label}: {worst:.3e} of {limit:.3e} at {at:?}");
    assert!(worst <= limit, "{label}: {worst} > {limit} at {at:?}");
    assert!(
        count < 2000 || worst > 0.1 * limit,
        "{label}: {worst} is far below {limit}"
    );
}

/// Everything that the shaders of `profile` read from `tables`, whose stated errors are those of `baked`.
pub(crate) fn check(profile: Profile, baked: &Baked, tables: &Tables, count: usize) {
    let name = of_metal(profile);
    let is_alpha = profile == Profile::MaterialX;
    // the second axis, and alpha
    let (least, alpha) = match is_alpha {
        true => (0.0025, (|r| r) as fn(f64) -> f64),
        false => (0.05, (|r| r * r) as fn(f64) -> f64),
    };
    let from = [0.01, least];
    let limit = stated(baked, name, "furnace").max + DOUBT;
    largest((&format!("{profile:?} furnace"), limit), (count, 1), from, |[mu, r]| {
        (truth::metal(mu, alpha(r)) / total(profile, tables, mu, r) - 1.0).abs()
    });
    if !matches!(profile, Profile::Cycles | Profile::OpenPbr) {
        let limit = stated(baked, name, "r0 = 0.04").max + DIELECTRIC_DOUBT;
        largest(
            (&format!("{profile:?} r0 = 0.04"), limit),
            (count, 2),
            from,
            |[mu, r]| (albedo(profile, tables, mu, r, 0.04) / truth::schlick(mu, alpha(r), 0.04) - 1.0).abs(),
        );
    }
    if sheen(profile, tables, 0.5, 0.5).is_some() {
        let limit = stated(baked, of_sheen(profile), "sheen").max + 1e-6;
        largest((&format!("{profile:?} sheen"), limit), (count, 3), from, |[mu, r]| {
            (sheen(profile, tables, mu, r).unwrap() - truth::sheen(mu, alpha(r))).abs()
        });
    }
    match profile {
        Profile::UnityHdrp => {
            // midpoints: at most 4 times 1e-5
            let limit = stated(baked, name, "diffuse").max + 4e-5;
            largest((&format!("{profile:?} diffuse"), limit), (count, 4), from, |[mu, r]| {
                (disney(tables, mu, r) - truth::disney(mu, r)).abs()
            });
        }
        Profile::Cycles => cycles_glass(baked, tables, count),
        Profile::OpenPbr => openpbr(baked, tables, count),
        _ => (),
    }
}

/// A share of z to the largest index, 100, to the index of the far side, seen from outside or from inside.
fn eta(z: f64, is_inside: bool) -> f64 {
    let square = z * z * 99.0 / 101.0;
    let outside = (1.0 + square) / (1.0 - square);
    if is_inside { 1.0 / outside } else { outside }
}

fn cycles_glass(baked: &Baked, tables: &Tables, count: usize) {
    for (name, is_inside) in [("table_ggx_glass_E", false), ("table_ggx_glass_inv_E", true)] {
        let limit = stated(baked, name, "furnace").max + 1e-5;
        largest((name, limit), (count, 5), [0.01, 0.05, 0.0], |[mu, r, z]| {
            let eta = eta(z, is_inside);
            let found = cycles_3d(&tables[name], r, mu, index_coordinate(eta));
            let [reflected, transmitted] = truth::glass(mu, r * r, eta);
            ((reflected + transmitted) / found - 1.0).abs()
        });
    }
}

fn openpbr(baked: &Baked, tables: &Tables, count: usize) {
    for (name, is_inside) in [("dielectric", false), ("dielectric_inside", true)] {
        for (channel, of) in ["reflected", "transmitted"].into_iter().enumerate() {
            let limit = stated(baked, name, of).max + 1e-6;
            let label = format!("{name} {of}");
            largest((&label, limit), (count, 6), [0.01, 0.05, 0.0], |[mu, r, z]| {
                let eta = eta(z, is_inside);
                let found = openpbr_glass(&tables[name], mu, r, eta)[channel];
                (found - truth::glass(mu, r * r, eta)[channel]).abs()
            });
        }
    }
}
