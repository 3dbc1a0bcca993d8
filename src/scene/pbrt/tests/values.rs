//! Values of parameters: remapped, textured, spectral.

use super::materials::{diffuse, ggx, roughness};
use super::{effects, gaps, one, read, refused};
use crate::fresnel::Fresnel;
use crate::measured::index::ConductorIndex;
use crate::scene::effect::Effect;
use crate::scene::pbrt::build::remapped;
use crate::scene::spec::{DistributionSpec, ModelSpec, Roughness};

/// The quartic, term by term: 1.62142 + 0.819955 x + 0.1734 x^2 + 0.0171201 x^3 + 0.000640711 x^4 with x = ln roughness, rounded
/// to 16 digits.
#[test]
fn roughness_is_remapped_by_the_quartic() {
    for (roughness, alpha) in [
        (0.0, 0.047_269_450_828_606_2),
        (0.001, 0.047_269_450_828_606_2),
        (0.01, 0.138_924_409_278_076_7),
        (0.1, 0.461_760_032_008_633_7),
        (0.5, 1.130_827_539_419_718_8),
        (1.0, 1.62142),
    ] {
        // a few roundings of terms up to 9
        assert!(
            (remapped(roughness) - alpha).abs() < 1e-14,
            "{roughness}: {}",
            remapped(roughness)
        );
    }
    // so that the ends of a range become the ends of a range
    let curve: Vec<f64> = (0..=2000).map(|i| remapped(f64::from(i) * 1e-3)).collect();
    assert!(curve.is_sorted());
}

#[test]
fn textured_roughness_is_a_range() {
    let alpha = |text: &str| {
        let material = one(&format!("{text}\nMaterial \"plastic\" \"texture roughness\" \"r\""));
        let is_range = effects(&material).contains(&Effect::RoughnessRange);
        match roughness(&material.model) {
            DistributionSpec::Isotropic { roughness, .. } => {
                assert_eq!(is_range, matches!(roughness, Roughness::Range { .. }));
                roughness
            }
            other => panic!("{other:?}"),
        }
    };
    let range = |min, max| Roughness::Range {
        min: remapped(min),
        max: remapped(max),
    };
    let float = |class: &str| format!("Texture \"r\" \"float\" {class}");
    for (class, expected) in [
        ("\"constant\" \"float value\" .3", Roughness::Fixed(remapped(0.3))),
        ("\"constant\"", Roughness::Fixed(remapped(1.0))),
        ("\"imagemap\" \"string filename\" \"a.png\"", range(0.0, 1.0)),
        ("\"imagemap\" \"float scale\" .5", range(0.0, 0.5)),
        ("\"marble\"", range(0.0, 1.0)),
        ("\"checkerboard\" \"float tex1\" .2 \"float tex2\" .1", range(0.1, 0.2)),
        ("\"checkerboard\"", range(0.0, 1.0)),
        (
            "\"scale\" \"float tex1\" .5 \"float tex2\" .25",
            Roughness::Fixed(remapped(0.125)),
        ),
        (
            "\"mix\" \"float tex1\" .5 \"float tex2\" .25",
            Roughness::Fixed(remapped(0.375)),
        ),
        ("\"dots\" \"float inside\" .5", range(0.0, 0.5)),
        ("\"bilerp\" \"float v00\" .5 \"float v10\" .5", range(0.5, 1.0)),
    ] {
        assert_eq!(alpha(&float(class)), expected, "{class}");
    }
    let chain = "Texture \"i\" \"float\" \"imagemap\" Texture \"h\" \"float\" \"scale\" \"texture tex1\" \"i\" \"float tex2\" .5\n\
                 Texture \"r\" \"float\" \"mix\" \"float tex1\" .2 \"texture tex2\" \"h\"";
    assert_eq!(alpha(chain), range(0.1, 0.35));
    let text = "Texture \"r\" \"float\" \"windy\" Material \"plastic\" \"texture roughness\" \"r\" \"bool remaproughness\" \"false\"";
    // pbrt takes 0.001 for any alpha below
    let plain = ggx(Roughness::Range { min: 1e-3, max: 1.0 });
    assert_eq!(roughness(&one(text).model), plain);
    assert!(one(text).calls[2].by.ends_with("line 2: texture roughness \"r\""));
}

#[test]
fn roughnesses_that_vary_apart_are_a_gap() {
    let metal = |u: &str, v: &str| {
        one(&format!(
            "Texture \"r\" \"float\" \"fbm\" Texture \"q\" \"float\" \"fbm\"\nMaterial \"metal\" {u} {v}"
        ))
    };
    let (u, v) = ("\"texture uroughness\" \"r\"", "\"texture vroughness\" \"r\"");
    let same = metal(u, v);
    assert!(same.gaps.is_empty() && !effects(&same).contains(&Effect::Anisotropy));
    for other in ["\"texture vroughness\" \"q\"", "\"float vroughness\" .3", ""] {
        let apart = metal(u, other);
        assert_eq!(gaps(&apart), ["anisotropy"], "{other}");
        assert_eq!(roughness(&apart.model), roughness(&same.model));
        assert!(effects(&apart).contains(&Effect::Anisotropy));
    }
}

#[test]
fn textured_colours_count_as_their_value_or_one() {
    let plastic = |texture: &str| {
        one(&format!(
            "{texture} Material \"plastic\" \"texture Kd\" \"t\" \"rgb Ks\" [0 0 0]"
        ))
        .model
    };
    assert_eq!(plastic("Texture \"t\" \"spectrum\" \"imagemap\""), diffuse(1.0));
    assert_eq!(
        plastic("Texture \"t\" \"color\" \"constant\" \"rgb value\" [.2 .2 .2]"),
        diffuse(0.2)
    );
    let scale = "Texture \"t\" \"color\" \"scale\" \"rgb tex1\" [.5 .5 .5] \"rgb tex2\" [.5 .5 .5]";
    assert_eq!(plastic(scale), diffuse(0.25));
    let mix = "Texture \"t\" \"spectrum\" \"mix\" \"rgb tex1\" [.5 .5 .5] \"float amount\" .25";
    assert_eq!(plastic(mix), diffuse(0.625));
    let error =
        refused("Texture \"t\" \"color\" \"constant\" \"rgb value\" [2 2 2] Material \"matte\" \"texture Kd\" \"t\"");
    assert!(
        error.contains("Kd = \"t\" is not allowed: Kd lies in [0, 1]"),
        "{error}"
    );
    // pbrt goes on with the default
    let scene = read("Material \"matte\" \"texture Kd\" \"t\" Shape \"sphere\"");
    assert_eq!(scene.materials[0].model, diffuse(0.5));
    assert!(
        scene.warnings[0].contains("line 1: texture Kd names no spectrum texture"),
        "{:?}",
        scene.warnings
    );
}

#[test]
fn spectra_become_colours() {
    let kd = |value: &str| match one(&format!("Material \"matte\" {value}")).model {
        ModelSpec::Lambertian(diffuse) => diffuse.albedo().to_array(),
        other => panic!("{other:?}"),
    };
    assert_eq!(kd("\"spectrum Kd\" [700 .5 400 .5]"), [0.5; 3]);
    assert_eq!(kd("\"spectrum Kd\" [500 .25]"), [0.25; 3]);
    // half the white of D65; its coordinates and the matrix are rounded to 1e-4
    for channel in kd("\"xyz Kd\" [0.47523 0.5 0.54453]") {
        assert!((channel - 0.5).abs() < 1e-3, "{channel}");
    }
    // warmer than D65: blue falls off
    let [r, g, b] = kd("\"blackbody Kd\" [3500 .5]");
    assert!(r > g && g > b, "{r} {g} {b}");
    // a single line of green is outside the triangle of the primaries, and its mean over the visible is grey
    let scene = read("Material \"matte\" \"spectrum Kd\" [519 0 520 1 540 1 541 0] Shape \"sphere\"");
    let ModelSpec::Lambertian(diffuse) = &scene.materials[0].model else {
        panic!("{:?}", scene.materials[0].model)
    };
    let mean = diffuse.albedo();
    // 20 of 300 nm, sampled every 5 nm: 5 of 61 samples
    assert_eq!(mean.to_array(), [5.0 / 61.0; 3]);
    assert!(
        scene.warnings[0].starts_with("line 1: spectrum Kd is more saturated"),
        "{:?}",
        scene.warnings
    );
}

#[test]
fn metals_by_name_stand_in_for_their_files() {
    let gold = ConductorIndex::named("Au").unwrap();
    for (eta, k) in [
        ("spds/Au.eta.spd", "spds/Au.k.spd"),
        ("metal-Au-eta", "metal-Au-k"),
        ("Au_n.spd", "a\\\\b\\\\Au.k.spd"),
    ] {
        let scene = read(&format!(
            "Material \"metal\" \"spectrum eta\" \"{eta}\" \"spectrum k\" [\"{k}\"] Shape \"sphere\""
        ));
        let ModelSpec::Microfacet { fresnel, .. } = scene.materials[0].model else {
            panic!("{:?}", scene.materials[0].model)
        };
        assert_eq!(fresnel, Fresnel::conductor(gold.eta(), gold.k()).unwrap());
        assert_eq!(scene.warnings.len(), 2, "{:?}", scene.warnings);
    }
    for name in ["spds/Aurum.spd", "missing.spd", ""] {
        let error = refused(&format!("Material \"metal\" \"spectrum eta\" \"{name}\""));
        assert!(
            error.contains("eta = \"") && error.contains("Ag, Al, Au, Cu"),
            "{error}"
        );
    }
    assert!(refused("Material \"matte\" \"spectrum Kd\" \"Au.eta.spd\"").contains("there is no such file"));
}
