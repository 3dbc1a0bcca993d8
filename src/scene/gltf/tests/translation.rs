//! What becomes of each property.

use super::*;
use crate::distribution::Family;
use crate::fresnel::Fresnel;
use crate::masking::Masking;
use crate::scene::{DistributionSpec, ModelSpec, Roughness};
use crate::spectrum::Spectrum;

#[test]
fn without_any_property_a_material_is_a_white_rough_metal() {
    for properties in ["", "\"pbrMetallicRoughness\":{}"] {
        let made = material(properties);
        assert_eq!(made.name, "material 0");
        assert_eq!(
            made.model,
            ModelSpec::Microfacet {
                reflectance: Spectrum::grey(1.0),
                distribution: DistributionSpec::Isotropic {
                    family: Family::Ggx,
                    roughness: Roughness::Fixed(1.0),
                },
                masking: Masking::SmithCorrelated,
                fresnel: Fresnel::schlick(Spectrum::grey(1.0)).unwrap(),
            }
        );
        assert_eq!(made.calls.len(), 1);
        assert_eq!(made.calls[0].by, "pbrMetallicRoughness.metallicFactor = 1 (default)");
        assert!(made.gaps.is_empty() && made.line.is_none() && !made.implied);
    }
}

#[test]
fn a_dielectric_lies_over_its_base() {
    let made = surface(PLASTIC, &[]);
    assert_eq!(
        facts(&made),
        "type=diffuse-specular coupling=energy-preserving ks=1 kd=[0.2, 0.4, 0.6] specular.type=microfacet \
         specular.reflectance=1 specular.distribution=ggx specular.alpha=0.25 specular.masking=smith-correlated \
         specular.fresnel=schlick specular.r0=0.04000000000000001"
    );
    let by: Vec<&str> = made.calls.iter().map(|call| call.by.as_str()).collect();
    assert_eq!(effects(&made), ["dielectric", "diffuse"]);
    assert_eq!(by[0], "pbrMetallicRoughness.metallicFactor = 0");
    assert!(
        by[1].starts_with("pbrMetallicRoughness.baseColorFactor = [0.2, 0.4, 0.6] where"),
        "{}",
        by[1]
    );

    // a black base leaves the lobe, and specularFactor 0 leaves the base
    let black = surface(
        "\"metallicFactor\":0,\"baseColorFactor\":[0,0,0,1],\"baseColorTexture\":{\"index\":0}",
        &[],
    );
    assert_eq!(effects(&black), ["dielectric"]);
    assert!(matches!(black.model, ModelSpec::Microfacet { .. }));
    let dull = surface(
        PLASTIC,
        &[("specular", "\"specularFactor\":0,\"specularTexture\":{\"index\":0}")],
    );
    assert_eq!(effects(&dull), ["diffuse"]);
    assert_eq!(facts(&dull), "type=lambertian reflectance=[0.2, 0.4, 0.6]");
    let nothing = surface(
        "\"metallicFactor\":0,\"baseColorFactor\":[0,0,0,1]",
        &[("specular", "\"specularFactor\":0")],
    );
    assert_eq!((nothing.model, nothing.calls), (ModelSpec::Sum(vec![]), vec![]));
}

#[test]
fn reflectance_at_normal_incidence_follows_index_and_specular_factors() {
    for (extensions, expected) in [
        (vec![("ior", "\"ior\":2")], "ks=1 r0=0.1111111111111111"),
        (vec![("ior", "\"ior\":1.0")], "ks=1 r0=0"),
        (vec![("ior", "\"ior\":0")], "ks=1 r0=1"),
        (vec![("ior", "\"ior\":1e300")], "ks=1 r0=1"),
        (vec![("ior", "")], "ks=1 r0=0.04000000000000001"),
        (
            vec![("specular", "\"specularFactor\":0.5")],
            "ks=0.5 r0=0.04000000000000001",
        ),
        (vec![("specular", "\"specularColorFactor\":[25,25,50]")], "ks=1 r0=1"),
        (
            vec![("ior", "\"ior\":3"), ("specular", "\"specularColorFactor\":[0,1,8]")],
            "ks=1 r0=[0.0, 0.25, 1.0]",
        ),
    ] {
        let described = facts(&surface(PLASTIC, &extensions));
        let kept: Vec<&str> = described.split_inclusive(' ').collect();
        let kept: String = kept.concat().replace("specular.r0", "r0");
        let (ks, r0) = expected.split_once(" r0=").unwrap();
        assert!(
            kept.contains(&format!(" {ks} ")) && kept.ends_with(&format!(" r0={r0}")),
            "{extensions:?}: {kept}"
        );
    }
}

#[test]
fn metals_and_dielectrics_are_mixed() {
    let mixed = surface("\"metallicFactor\":0.25,\"roughnessFactor\":0.5", &[]);
    assert_eq!(effects(&mixed), ["metal", "dielectric", "diffuse"]);
    let ModelSpec::Sum(parts) = &mixed.model else {
        panic!("{:?}", mixed.model)
    };
    let scales = |parts: &[ModelSpec]| -> Vec<f64> {
        let scale = |part: &ModelSpec| match part {
            ModelSpec::Scaled { scale, .. } => scale.value().x,
            other => panic!("{other:?}"),
        };
        parts.iter().map(scale).collect()
    };
    assert_eq!(scales(parts), [0.25, 0.75]);

    // a texture of metal: the middle of [0, 1], and a roughness of all that it may be
    let texture = "\"metallicRoughnessTexture\":{\"index\":0}";
    let textured = surface(&format!("\"roughnessFactor\":0.5,{texture}"), &[]);
    assert_eq!(
        effects(&textured),
        ["metal", "dielectric", "diffuse", "roughness-range"]
    );
    assert_eq!(textured.model.ranges(), [(Family::Ggx, 1e-6, 0.25); 2]);
    let ModelSpec::Sum(parts) = &textured.model else {
        panic!("{:?}", textured.model)
    };
    assert_eq!(scales(parts), [0.5, 0.5]);
    assert!(
        textured.calls[0]
            .by
            .ends_with("metallicFactor = 1 (default), times a texture")
    );

    // factors of 0 stay 0 under a texture
    let plain = surface(&format!("\"metallicFactor\":0,\"roughnessFactor\":0,{texture}"), &[]);
    assert_eq!(effects(&plain), ["dielectric", "diffuse"]);
    assert_eq!(plain.model.ranges(), []);
}

#[test]
fn smooth_surfaces_are_mirrors() {
    for (roughness, smooth) in [("0", true), ("9.9e-4", true), ("0.0011", false), ("-0.0", true)] {
        let made = surface(&format!("\"roughnessFactor\":{roughness}"), &[]);
        assert_eq!(
            matches!(made.model, ModelSpec::SpecularReflection(_)),
            smooth,
            "{roughness}"
        );
        assert_eq!(effects(&made), ["metal"]);
    }
}

#[test]
fn anisotropy_stretches_the_lobe_along_the_tangent() {
    let strength = |strength: f64| format!("\"anisotropyStrength\":{strength}");
    let made = |roughness: f64, anisotropy: &str| {
        surface(
            &format!("\"roughnessFactor\":{roughness}"),
            &[("anisotropy", anisotropy)],
        )
    };
    let along = |material: &Material| match &material.model {
        ModelSpec::Microfacet {
            distribution: DistributionSpec::Anisotropic(lobe),
            ..
        } => lobe.parameters(),
        other => panic!("{other:?}"),
    };
    let half = made(0.5, &strength(0.5));
    assert_eq!(effects(&half), ["metal", "anisotropy"]);
    // mix(0.25, 1, 0.25)
    assert_eq!((along(&half), gaps(&half)), ([0.4375, 0.25], vec![]));
    assert_eq!(along(&made(0.5, &strength(1.0))), [1.0, 0.25]);
    let sharp = made(0.0, &strength(1.0));
    assert_eq!((along(&sharp), gaps(&sharp)), ([1.0, 1e-3], vec!["anisotropy"]));

    // equal along both tangents
    let round = made(1.0, &strength(0.5));
    assert_eq!((effects(&round), gaps(&round)), (vec!["metal", "anisotropy"], vec![]));
    assert!(facts(&round).contains(" alpha=1 "), "{}", facts(&round));
    assert_eq!(effects(&made(0.5, "\"anisotropyTexture\":{\"index\":0}")), ["metal"]);

    let textured = made(0.5, "\"anisotropyStrength\":1,\"anisotropyTexture\":{\"index\":0}");
    assert_eq!((along(&textured), gaps(&textured)), ([1.0, 0.25], vec!["anisotropy"]));
    let range = surface(
        "\"metallicRoughnessTexture\":{\"index\":0}",
        &[("anisotropy", &strength(0.5))],
    );
    assert_eq!(gaps(&range), ["anisotropy"]);
    assert_eq!(range.model.roughness_range(), Some((Family::Ggx, 1e-6, 1.0)));
    // no lobe that it could stretch
    let dull = surface(
        PLASTIC,
        &[("anisotropy", &strength(1.0)), ("specular", "\"specularFactor\":0")],
    );
    assert_eq!(effects(&dull), ["diffuse"]);
}
