//! Which texel is where: rows, columns, flips, ends.

use crate::engines::{Tables, albedo, cycles_1d, cycles_2d, cycles_3d, total};
use crate::gpu::Raw;
use crate::shared::{baked, stated, tables};
use crate::truth;
use whitefurnace::engine::Profile;

fn of(profile: Profile) -> (Tables, f64) {
    let baked = baked(profile);
    let error = stated(baked, baked[0].0.name, "furnace").max;
    (tables(baked), error)
}

/// At grazing angles of rough metal and at normal incidence of smooth metal E differs by more than a tenth: rows and columns that were
/// swapped would show.
#[test]
fn rows_and_columns_are_not_swapped() {
    for profile in Profile::ALL {
        let (tables, error) = of(profile);
        let (mu, r) = (0.9, 0.3);
        let alpha = |r: f64| if profile == Profile::MaterialX { r } else { r * r };
        let (here, swapped) = (truth::metal(mu, alpha(r)), truth::metal(r, alpha(mu)));
        assert!((here / swapped - 1.0).abs() > 0.1, "a probe that tells nothing");
        for (mu, r, expected) in [(mu, r, here), (r, mu, swapped)] {
            let found = total(profile, &tables, mu, r);
            assert!(
                (expected / found - 1.0).abs() <= error,
                "{profile:?}: {found} {expected}"
            );
        }
    }
}

/// The table reads its first and last texels at 0 and 1, beyond them no others, and those are where the engine expects them: E falls
/// from smooth to rough.
#[test]
fn ends_are_where_the_engine_looks() {
    // name, column and row of the texel nearest to mu = 1 and the roughest, and channels whose sum is E
    for (profile, name, is_transposed, is_flipped, channels) in [
        (Profile::Filament, "dfg", false, false, &[0, 1][..]),
        (Profile::FilamentMultiscatter, "dfg_multiscatter", false, false, &[1]),
        (Profile::Three, "dfgLUT", true, false, &[0, 1]),
        (Profile::Bevy, "dfg", false, false, &[0, 1]),
        (Profile::Godot, "dfg_lut", false, true, &[1]),
        (Profile::Gltf, "lut_ggx", false, false, &[0, 1]),
        (Profile::UnityHdrp, "preintegrated_fgd", false, false, &[1]),
        (Profile::Unreal, "preintegrated_gf", false, false, &[0, 1]),
        (Profile::MaterialX, "albedo_table", false, false, &[0, 1]),
        (Profile::Cycles, "table_ggx_E", true, false, &[0]),
        (Profile::OpenPbr, "ideal_metal_energy_complement", false, false, &[0]),
    ] {
        let (tables, _) = of(profile);
        let raw: &Raw = &tables[name];
        let [width, height, _] = raw.size;
        let texel = |is_smooth: bool| {
            let (x, y) = match (is_transposed, is_smooth) {
                (true, true) => (0, height - 1),
                (true, false) => (width - 1, height - 1),
                (false, _) => (width - 1, if is_smooth == is_flipped { height - 1 } else { 0 }),
            };
            let sum: f64 = channels.iter().map(|channel| raw.texel(x, y, *channel)).sum();
            if profile == Profile::OpenPbr { 1.0 - sum } else { sum }
        };
        // E of rough metal at normal incidence is 0.45, of smooth metal 1
        assert!(
            texel(true) > 0.97 && texel(false) < 0.6,
            "{profile:?}: {} {}",
            texel(true),
            texel(false)
        );
        for (r, is_smooth) in [(0.0, true), (1.0, false)] {
            let found = total(profile, &tables, 1.0, r);
            // the weights of texels add up to 1 within a few units in the last place
            assert!((found - texel(is_smooth)).abs() < 1e-13, "{profile:?} {r}: {found}");
        }
    }
}

/// Where texels sit on the ends of an axis, the ends are known as well as all else; where they sit on centres, half a texel is not.
#[test]
fn ends_are_stored_where_the_rule_says_so() {
    for (profile, is_stored) in [
        (Profile::Generic, true),
        (Profile::UnityHdrp, true),
        (Profile::Cycles, true),
        (Profile::Three, false),
    ] {
        let (tables, error) = of(profile);
        let moved = (total(profile, &tables, 1.0, 0.999) - total(profile, &tables, 1.0, 1.0)).abs();
        assert_eq!(moved > 1e-6, is_stored, "{profile:?}: {moved}");
        let expected = truth::metal(1.0, 1.0);
        assert!(
            (expected / total(profile, &tables, 1.0, 1.0) - 1.0).abs() <= error,
            "{profile:?}"
        );
    }
}

/// Godot's rows begin with the roughest: the same lookup without the flip is far off.
#[test]
fn godot_is_flipped() {
    let (tables, error) = of(Profile::Godot);
    let raw = &tables["dfg_lut"];
    let expected = truth::metal(0.5, 0.9f64.powi(2));
    assert!((expected / raw.fetch([0.5, 1.0 - 0.9], 1) - 1.0).abs() <= error);
    assert!((expected / raw.fetch([0.5, 0.9], 1) - 1.0).abs() > 0.2);
}

/// B at normal incidence is nearly 0 and A nearly E: channels are in the order of the shader.
#[test]
fn channels_are_in_the_order_of_the_shader() {
    for profile in Profile::ALL
        .into_iter()
        .filter(|profile| !matches!(profile, Profile::Cycles | Profile::OpenPbr))
    {
        let (tables, _) = of(profile);
        let r = if profile == Profile::MaterialX { 0.4 * 0.4 } else { 0.4 };
        let [black, white] = [0.0, 1.0].map(|f0| albedo(profile, &tables, 0.95, r, f0));
        assert!(black < 0.01 && white > 0.9, "{profile:?}: {black} {white}");
    }
}

/// 2 int E mu dmu by 4000 midpoints, whose error is below 1e-6.
fn mean(e: impl Fn(f64) -> f64) -> f64 {
    let count = 4000;
    let one = |i: i32| {
        let mu = (f64::from(i) + 0.5) / f64::from(count);
        2.0 * mu * e(mu) / f64::from(count)
    };
    (0..count).map(one).sum()
}

/// The means of Cycles are those of what its lookups read, at the texels and between.
#[test]
fn means_of_cycles_are_those_of_its_lookups() {
    let (tables, _) = of(Profile::Cycles);
    for r in [0.0, 0.31, 0.77, 1.0] {
        let found = cycles_1d(&tables["table_ggx_Eavg"].values, r);
        let expected = mean(|mu| cycles_2d(&tables["table_ggx_E"], r, mu));
        assert!((found - expected).abs() < 1e-6, "{r}: {found} {expected}");
        let z = (0.21 + r).fract();
        for (e, average) in [
            ("table_ggx_glass_E", "table_ggx_glass_Eavg"),
            ("table_ggx_glass_inv_E", "table_ggx_glass_inv_Eavg"),
        ] {
            let found = cycles_2d(&tables[average], r, z);
            let expected = mean(|mu| cycles_3d(&tables[e], r, mu, z));
            assert!((found - expected).abs() < 1e-6, "{e} {r} {z}: {found} {expected}");
        }
    }
}
