//! What becomes of extensions that change which lobes there are.

use super::*;
use crate::bxdf::Veil;
use crate::distribution::Family;
use crate::fresnel::Fresnel;
use crate::masking::Masking;
use crate::scene::{DistributionSpec, Effect, ModelSpec, Roughness};
use crate::spectrum::Spectrum;

#[test]
fn transmission_takes_the_place_of_the_base() {
    let glass = surface(
        SMOOTH,
        &[("transmission", "\"transmissionFactor\":1"), ("ior", "\"ior\":1.33")],
    );
    assert_eq!(effects(&glass), ["transmission"]);
    assert_eq!(
        facts(&glass),
        "type=fresnel-specular reflectance=1 transmittance=[0.2, 0.4, 0.6] eta_a=1 eta_b=1.33 transport=importance"
    );
    assert_eq!(gaps(&glass), [""; 0]);

    let volume = surface(
        SMOOTH,
        &[
            ("transmission", "\"transmissionFactor\":1"),
            ("volume", "\"thicknessFactor\":1"),
        ],
    );
    assert!(volume.calls[0].by.contains("needs no table"), "{}", volume.calls[0].by);
    assert_eq!(volume.gaps, []);

    for half in [
        "\"transmissionFactor\":0.5",
        "\"transmissionFactor\":1,\"transmissionTexture\":{\"index\":0}",
    ] {
        let made = surface(SMOOTH, &[("transmission", half)]);
        assert_eq!(effects(&made), ["dielectric", "diffuse", "transmission"], "{half}");
        assert!(facts(&made).starts_with("type=sum"), "{half}");
        assert!(
            facts(&made).contains("bxdfs.0.scale=0.5") && facts(&made).contains("bxdfs.1.scale=0.5"),
            "{half}"
        );
    }

    let rough = surface(PLASTIC, &[("transmission", "\"transmissionFactor\":1")]);
    assert_eq!(
        (effects(&rough), gaps(&rough)),
        (vec!["transmission"], vec!["transmission"])
    );
    assert!(matches!(rough.model, ModelSpec::Microfacet { .. }));
    // a thin wall, until a volume gives it a thickness
    let through = ("transmission", "\"transmissionFactor\":1");
    let flat = surface(PLASTIC, &[through, ("volume", "\"thicknessFactor\":0")]);
    assert_eq!((gaps(&flat), &flat.model), (vec!["transmission"], &rough.model));
    let solid = surface(PLASTIC, &[through, ("volume", "\"thicknessFactor\":0.1")]);
    assert_eq!((effects(&solid), gaps(&solid)), (vec!["transmission"], vec![]));
    assert!(
        facts(&solid).starts_with("type=rough-dielectric reflectance=1 transmittance="),
        "{}",
        facts(&solid)
    );
    assert!(facts(&solid).contains("masking=smith-correlated eta_a=1 eta_b=1.5 transport=importance"));
    let matched = surface(
        PLASTIC,
        &[through, ("volume", "\"thicknessFactor\":1"), ("ior", "\"ior\":1")],
    );
    assert!(matches!(matched.model, ModelSpec::FresnelSpecular(_)));
    let dense = surface(
        SMOOTH,
        &[("transmission", "\"transmissionFactor\":1"), ("ior", "\"ior\":200")],
    );
    assert_eq!(
        (effects(&dense), gaps(&dense)),
        (vec!["transmission"], vec!["transmission"])
    );
    let tinted = surface(
        SMOOTH,
        &[
            ("transmission", "\"transmissionFactor\":1"),
            ("specular", "\"specularFactor\":0.5"),
        ],
    );
    assert_eq!(gaps(&tinted), ["KHR_materials_specular"]);

    // what an index of 0 lets pass is not known
    let all = surface(
        SMOOTH,
        &[("transmission", "\"transmissionFactor\":1"), ("ior", "\"ior\":0")],
    );
    assert_eq!(
        (effects(&all), gaps(&all)),
        (vec!["transmission"], vec!["transmission"])
    );
    // and a roughness counts, whatever the reflected part is scaled with
    let rough = surface(
        "\"metallicFactor\":0,\"roughnessFactor\":0.3",
        &[
            ("transmission", "\"transmissionFactor\":1"),
            ("specular", "\"specularFactor\":0"),
        ],
    );
    assert_eq!(
        (effects(&rough), gaps(&rough)),
        (vec!["transmission"], vec!["transmission"])
    );

    // nothing passes a metal, a factor of 0 or a black base
    for (base, extension, calls) in [
        ("\"roughnessFactor\":0", ("ior", ""), vec!["metal"]),
        (
            "\"metallicFactor\":0,\"baseColorFactor\":[0,0,0,1]",
            ("ior", ""),
            vec!["dielectric"],
        ),
    ] {
        let made = surface(base, &[("transmission", "\"transmissionFactor\":1"), extension]);
        assert_eq!(effects(&made), calls, "{base}");
    }
    let off = surface(
        SMOOTH,
        &[
            ("transmission", "\"transmissionTexture\":{\"index\":0}"),
            ("volume", ""),
        ],
    );
    assert_eq!(effects(&off), ["dielectric", "diffuse"]);
}

#[test]
fn dispersion_needs_light_that_is_refracted() {
    let made = |dispersion: &str, others: &[(&str, &str)]| {
        let extensions = [&[("dispersion", dispersion), ("volume", "")], others].concat();
        let made = surface(SMOOTH, &extensions);
        made.calls.iter().any(|call| call.effect == Effect::Dispersion)
    };
    let through = ("transmission", "\"transmissionFactor\":1");
    assert!(made("\"dispersion\":0.1", &[through]));
    assert!(!made("\"dispersion\":0", &[through]));
    assert!(!made("", &[through]));
    assert!(!made("\"dispersion\":0.1", &[]));
    // the index of air at every wavelength
    assert!(!made("\"dispersion\":0.1", &[through, ("ior", "\"ior\":1")]));
}

#[test]
fn layers_are_called_for_when_they_are_on() {
    for (extension, on, off, effect, covered) in [
        (
            "clearcoat",
            "\"clearcoatFactor\":0.5",
            "\"clearcoatRoughnessFactor\":0.5,\"clearcoatTexture\":{\"index\":0}",
            "clearcoat",
            true,
        ),
        (
            "sheen",
            "\"sheenColorFactor\":[0,0.1,0]",
            "\"sheenRoughnessFactor\":1,\"sheenColorTexture\":{\"index\":0}",
            "sheen",
            true,
        ),
        (
            "iridescence",
            "\"iridescenceFactor\":1,\"iridescenceIor\":1.3",
            "\"iridescenceFactor\":0,\"iridescenceTexture\":{\"index\":0}",
            "iridescence",
            false,
        ),
    ] {
        let with = surface("", &[(extension, on)]);
        assert_eq!(
            (effects(&with), gaps(&with)),
            (vec!["metal", effect], if covered { vec![] } else { vec![effect] }),
            "{extension}"
        );
        let by = format!("extensions.KHR_materials_{extension}.{effect}");
        assert!(with.calls[1].by.starts_with(&by), "{}", with.calls[1].by);
        let without = surface("", &[(extension, off)]);
        assert_eq!(
            (effects(&without), gaps(&without)),
            (vec!["metal"], vec![]),
            "{extension}"
        );
    }
}

/// The coat lies over the sheen, and both over the metal; alpha is the square of each roughness.
#[test]
fn layers_lie_over_each_other() {
    let coat = ("clearcoat", "\"clearcoatFactor\":0.5,\"clearcoatRoughnessFactor\":0.5");
    let sheen = ("sheen", "\"sheenColorFactor\":[0,0.1,0],\"sheenRoughnessFactor\":0.5");
    let made = surface("", &[sheen, coat]);
    let ModelSpec::Layered {
        top,
        base,
        veil: Veil::Fresnel,
    } = &made.model
    else {
        panic!("{:?}", made.model)
    };
    let lobe = |model: &ModelSpec| match model {
        ModelSpec::Microfacet {
            reflectance,
            distribution,
            masking,
            fresnel,
        } => (reflectance.value().to_array(), *distribution, *masking, *fresnel),
        other => panic!("{other:?}"),
    };
    let fixed = |family, alpha| DistributionSpec::Isotropic {
        family,
        roughness: Roughness::Fixed(alpha),
    };
    let schlick = Fresnel::schlick(Spectrum::grey(0.04)).unwrap();
    assert_eq!(
        lobe(top),
        ([0.5; 3], fixed(Family::Ggx, 0.25), Masking::SmithCorrelated, schlick)
    );
    let ModelSpec::Layered {
        top,
        base,
        veil: Veil::Albedo,
    } = base.as_ref()
    else {
        panic!("{base:?}")
    };
    assert_eq!(
        lobe(top),
        (
            [0.0, 0.1, 0.0],
            fixed(Family::Charlie, 0.25),
            Masking::Charlie,
            Fresnel::None
        )
    );
    assert!(matches!(base.as_ref(), ModelSpec::Microfacet { .. }), "{base:?}");
}

/// Fibres have a least alpha, a smooth coat is a mirror, and of two textured roughnesses one is an axis.
#[test]
fn roughnesses_of_layers_have_their_limits() {
    let top = |properties: &str, extension: (&str, &str)| match surface(properties, &[extension]).model {
        ModelSpec::Layered { top, .. } => *top,
        other => panic!("{other:?}"),
    };
    let sharp = top("", ("sheen", "\"sheenColorFactor\":[1,1,1]"));
    assert_eq!(sharp.roughness(), Some(Roughness::Fixed(1e-3)));
    let smooth = top("", ("clearcoat", "\"clearcoatFactor\":1"));
    assert!(matches!(smooth, ModelSpec::SpecularReflection(_)), "{smooth:?}");
    let textured = "\"sheenColorFactor\":[1,1,1],\"sheenRoughnessFactor\":0.5,\"sheenRoughnessTexture\":{\"index\":0}";
    let range = surface("", &[("sheen", textured)]);
    assert_eq!(range.model.roughness_range(), Some((Family::Charlie, 1e-3, 0.25)));
    assert_eq!(
        (effects(&range), gaps(&range)),
        (vec!["metal", "sheen", "roughness-range"], vec![])
    );
    let both = surface("\"metallicRoughnessTexture\":{\"index\":0}", &[("sheen", textured)]);
    assert_eq!(gaps(&both), ["sheen"]);
    assert_eq!(both.model.ranges().first().map(|range| range.0), Some(Family::Ggx));
}

#[test]
fn unlit_beats_everything() {
    let made = surface(
        PLASTIC,
        &[
            ("unlit", ""),
            ("clearcoat", "\"clearcoatFactor\":1"),
            ("pbrSpecularGlossiness", ""),
        ],
    );
    assert_eq!(
        (made.model, made.calls, made.gaps),
        (ModelSpec::Sum(vec![]), vec![], vec![])
    );
    // what it has for those who do not know the extension is not needed
    let told = message(&library(&format!(
        "{{{}}}",
        properties("\"roughnessFactor\":7", &[("unlit", "")])
    )));
    assert!(
        told.contains("roughnessFactor = 7 is not allowed") && told.ends_with("no effect on this material"),
        "{told}"
    );
}

#[test]
fn specular_glossiness_wins() {
    let gloss = |members: &str| surface("\"metallicFactor\":1", &[("pbrSpecularGlossiness", members)]);
    let made = gloss("\"diffuseFactor\":[0.1,0.2,0.3,1],\"specularFactor\":[0.2,0.2,0.2],\"glossinessFactor\":0.5");
    assert_eq!(effects(&made), ["dielectric", "diffuse"]);
    let described = facts(&made);
    assert!(
        described.contains("kd=[0.1, 0.2, 0.3]") && described.ends_with("specular.r0=0.2"),
        "{described}"
    );
    assert!(described.contains("specular.alpha=0.25"), "{described}");
    assert!(facts(&gloss("")).contains("specular.type=specular-reflection"));
    let black = gloss("\"diffuseFactor\":[0,0,0,1]");
    assert_eq!(effects(&black), ["dielectric"]);
    let range = |factor: &str| {
        let texture = "\"specularGlossinessTexture\":{\"index\":0}";
        gloss(&format!("\"glossinessFactor\":{factor},{texture}"))
            .model
            .roughness_range()
    };
    assert_eq!(range("1"), Some((Family::Ggx, 1e-6, 1.0)));
    assert_eq!(range("0.5"), Some((Family::Ggx, 0.25, 1.0)));
    assert_eq!(range("0"), None);

    let both = properties(
        "",
        &[("pbrSpecularGlossiness", ""), ("clearcoat", "\"clearcoatFactor\":1")],
    );
    let scene = file(&library(&format!("{{{both}}}"))).unwrap();
    assert_eq!(effects(&scene.materials[0]), ["dielectric", "diffuse"]);
    assert!(
        scene.warnings[0].contains("KHR_materials_clearcoat was passed over"),
        "{:?}",
        scene.warnings
    );
}

#[test]
fn what_calls_for_nothing_is_no_gap_and_what_is_not_known_is_one() {
    let idle = surface(
        "",
        &[
            ("emissive_strength", "\"emissiveStrength\":5"),
            ("volume", "\"thicknessFactor\":1"),
        ],
    );
    assert_eq!((effects(&idle), idle.gaps), (vec!["metal"], vec![]));
    let transformed = "\"baseColorTexture\":{\"index\":0,\"extensions\":{\"KHR_texture_transform\":{\"scale\":[2,2]}}}";
    assert_eq!(surface(transformed, &[]).gaps, []);
    let cut = material("\"alphaMode\":\"MASK\",\"alphaCutoff\":0.3,\"doubleSided\":true,\"extras\":{\"any\":[1]}");
    assert_eq!((effects(&cut), cut.gaps), (vec!["metal"], vec![]));

    let scene = file(
        "\"extensionsUsed\":[\"X_fur\"],\"extensionsRequired\":[\"X_fur\",\"KHR_materials_variants\"],\
         \"materials\":[{\"extensions\":{\"X_fur\":{\"roughnessFactor\":[7]}}}]",
    )
    .unwrap();
    assert_eq!(gaps(&scene.materials[0]), ["X_fur"]);
    let told = scene.warnings.join("\n");
    assert!(
        told.contains("extensionsRequired holds \"X_fur\", which is not known"),
        "{told}"
    );
    assert!(
        told.contains("\"KHR_materials_variants\", which extensionsUsed does not"),
        "{told}"
    );
    assert!(!told.contains("variants\", which is not known"), "{told}");
}

#[test]
fn names_of_unknown_extensions_are_shown_short_and_harmless() {
    let long = "x".repeat(5000);
    let extensions = format!("\"\\u001b[2J\\u202e\":{{}},\"\":{{}},\"{long}\":{{}}");
    let scene = file(&format!("\"materials\":[{{\"extensions\":{{{extensions}}}}}]")).unwrap();
    let cut = format!("{}...", "x".repeat(40));
    assert_eq!(gaps(&scene.materials[0]), ["\u{fffd}[2J\u{fffd}", "\"\"", &cut]);
}

#[test]
fn extreme_numbers_are_told_in_few_digits() {
    let glossy = "\"specularGlossinessTexture\":{\"index\":0},\"glossinessFactor\":5e-324";
    let material = surface("", &[("pbrSpecularGlossiness", glossy)]);
    assert!(
        material.calls.iter().all(|call| call.by.len() < 150),
        "{:?}",
        material.calls
    );
    let dense = [("transmission", "\"transmissionFactor\":1"), ("ior", "\"ior\":1e308")];
    let material = surface("\"metallicFactor\":0,\"roughnessFactor\":0", &dense);
    assert_eq!(gaps(&material), ["transmission"]);
    assert!(material.gaps[0].why.len() < 150, "{:?}", material.gaps);
}
