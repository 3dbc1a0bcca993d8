//! The lines of the engines' shaders that read their tables, written down again.

use crate::gpu::Raw;
use std::collections::BTreeMap;
use whitefurnace::engine::Profile;

/// The tables of a profile by name.
pub(crate) type Tables = BTreeMap<&'static str, Raw>;

/// Unity's Remap01ToHalfTexelCoord.
fn remap(u: f64, n: f64) -> f64 {
    u * ((n - 1.0) / n) + 0.5 / n
}

/// sqrt mu and r^(3/4) of the generic layout, for a table of this size.
fn bent(raw: &Raw, mu: f64, r: f64) -> [f64; 2] {
    [
        remap(mu.sqrt(), raw.size[0] as f64),
        remap((r * r.sqrt()).sqrt(), raw.size[1] as f64),
    ]
}

fn mix(x: f64, y: f64, t: f64) -> f64 {
    x * (1.0 - t) + y * t
}

/// What the shader takes for the albedo of a lobe with Schlick's term of reflectance `f0`, `r` along the axis of the table: the
/// perceptual roughness, or alpha where the engine has that.
pub(crate) fn albedo(profile: Profile, tables: &Tables, mu: f64, r: f64, f0: f64) -> f64 {
    let pair = |name: &str, at: [f64; 2]| [0, 1].map(|channel| tables[name].fetch(at, channel));
    let f90 = 1.0;
    match profile {
        Profile::Generic => {
            let [bias, loss] = pair("pair", bent(&tables["pair"], mu, r));
            mix(bias, 1.0 - loss, f0)
        }
        Profile::Filament => {
            let [x, y] = pair("dfg", [mu, r]);
            f0 * x + f90 * y
        }
        Profile::FilamentMultiscatter => {
            let [x, y] = pair("dfg_multiscatter", [mu, r]);
            mix(x, y, f0)
        }
        Profile::Three => {
            let [x, y] = pair("dfgLUT", [r, mu]);
            f0 * x + f90 * y
        }
        Profile::Bevy => {
            let [x, y] = pair("dfg", [mu, r]);
            f0 * x + y
        }
        Profile::Godot => {
            let [x, y] = pair("dfg_lut", [mu, 1.0 - r]);
            (f90 - f0) * x + f0 * y
        }
        Profile::Gltf => {
            let [x, y] = pair("lut_ggx", [mu, r]);
            f0 * x + y
        }
        Profile::UnityHdrp => {
            let raw = &tables["preintegrated_fgd"];
            let at = [remap(mu.sqrt(), raw.size[0] as f64), remap(r, raw.size[1] as f64)];
            let [x, y] = pair("preintegrated_fgd", at);
            mix(x, y, f0)
        }
        Profile::Unreal => {
            let [x, y] = pair("preintegrated_gf", [mu, r]);
            f0 * x + (50.0 * f0).clamp(0.0, 1.0) * y
        }
        Profile::MaterialX => {
            let [x, y] = pair("albedo_table", [mu, r]);
            f0 * x + f90 * y
        }
        Profile::Cycles | Profile::OpenPbr => panic!("their tables are of F = 1 alone"),
    }
}

/// E, the albedo where F = 1, as what compensates divides by it.
pub(crate) fn total(profile: Profile, tables: &Tables, mu: f64, r: f64) -> f64 {
    // the factor on single scattering, 1 + F0 (1/y - 1) and the like, at F0 = 1
    let compensated = |y: f64| 1.0 / (1.0 + 1.0 * (1.0 / y - 1.0));
    match profile {
        Profile::FilamentMultiscatter => compensated(tables["dfg_multiscatter"].fetch([mu, r], 1)),
        Profile::Godot => compensated(tables["dfg_lut"].fetch([mu, 1.0 - r], 1)),
        Profile::Cycles => cycles_2d(&tables["table_ggx_E"], r, mu),
        Profile::OpenPbr => {
            let raw = &tables["ideal_metal_energy_complement"];
            let at = [remap(mu, raw.size[0] as f64), remap(r, raw.size[1] as f64)];
            1.0 - raw.fetch(at, 0)
        }
        _ => albedo(profile, tables, mu, r, 1.0),
    }
}

/// The albedo of sheen, of tables that have it.
pub(crate) fn sheen(profile: Profile, tables: &Tables, mu: f64, r: f64) -> Option<f64> {
    Some(match profile {
        Profile::Generic => tables["sheen"].fetch(bent(&tables["sheen"], mu, r), 0),
        Profile::Filament => tables["dfg"].fetch([mu, r], 2),
        Profile::FilamentMultiscatter => tables["dfg_multiscatter"].fetch([mu, r], 2),
        Profile::Godot => tables["dfg_lut"].fetch([mu, 1.0 - r], 2),
        Profile::Gltf => tables["lut_sheen_E"].fetch([mu, r], 0),
        Profile::MaterialX => tables["albedo_table"].fetch([mu, r], 2),
        _ => return None,
    })
}

/// Unity's Disney diffuse.
pub(crate) fn disney(tables: &Tables, mu: f64, r: f64) -> f64 {
    let raw = &tables["preintegrated_fgd"];
    let at = [remap(mu.sqrt(), raw.size[0] as f64), remap(r, raw.size[1] as f64)];
    raw.fetch(at, 2) + 0.5
}

/// An array over x alone, from end to end, as Cycles reads it.
pub(crate) fn cycles_1d(array: &[f64], x: f64) -> f64 {
    let x = x.clamp(0.0, 1.0) * (array.len() - 1) as f64;
    let index = (x as usize).min(array.len() - 1);
    let next = (index + 1).min(array.len() - 1);
    let t = x - index as f64;
    (1.0 - t) * array[index] + t * array[next]
}

/// Rows of `width` numbers one behind the other: x along each.
pub(crate) fn cycles_2d(raw: &Raw, x: f64, y: f64) -> f64 {
    let rows: Vec<f64> = raw.values.chunks(raw.size[0]).map(|row| cycles_1d(row, x)).collect();
    cycles_1d(&rows, y)
}

/// Slices of such rows.
pub(crate) fn cycles_3d(raw: &Raw, x: f64, y: f64, z: f64) -> f64 {
    let slice = |values: &[f64]| {
        cycles_2d(
            &Raw {
                size: [raw.size[0], raw.size[1], 1],
                channels: 1,
                values: values.to_vec(),
            },
            x,
            y,
        )
    };
    let slices: Vec<f64> = raw.values.chunks(raw.size[0] * raw.size[1]).map(slice).collect();
    cycles_1d(&slices, z)
}

/// z of an index of refraction.
pub(crate) fn index_coordinate(ior: f64) -> f64 {
    ((ior - 1.0) / (ior + 1.0)).abs().sqrt()
}

/// OpenPBR's reflected and transmitted share at an index of refraction, of one of its two tables.
pub(crate) fn openpbr_glass(raw: &Raw, mu: f64, r: f64, eta: f64) -> [f64; 2] {
    let [u, v] = bent(raw, mu, r);
    let w = remap(index_coordinate(eta), raw.size[2] as f64);
    [0, 1].map(|channel| raw.fetch([u, v, w], channel))
}
