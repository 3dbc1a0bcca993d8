//! Each material as the model that it comes to.

use super::{effects, gaps, one, read, refused};
use crate::bxdf::{FresnelSpecular, Lambertian, Media, OrenNayar, SpecularReflection, SpecularTransmission, Transport};
use crate::distribution::{Anisotropic, Elliptic, Family};
use crate::fresnel::Fresnel;
use crate::masking::Masking;
use crate::measured::index::ConductorIndex;
use crate::scene::effect::Effect;
use crate::scene::pbrt::build::remapped;
use crate::scene::spec::{DistributionSpec, ModelSpec, Roughness};
use crate::spectrum::Spectrum;

fn grey(value: f64) -> Spectrum {
    Spectrum::grey(value)
}

pub(super) fn diffuse(value: f64) -> ModelSpec {
    ModelSpec::Lambertian(Lambertian::new(grey(value)).unwrap())
}

pub(super) fn ggx(roughness: Roughness) -> DistributionSpec {
    DistributionSpec::Isotropic {
        family: Family::Ggx,
        roughness,
    }
}

fn lobe(reflectance: f64, distribution: DistributionSpec, fresnel: Fresnel) -> ModelSpec {
    ModelSpec::Microfacet {
        reflectance: grey(reflectance),
        distribution,
        masking: Masking::SmithCorrelated,
        fresnel,
    }
}

fn coat(reflectance: f64, alpha: f64) -> ModelSpec {
    lobe(
        reflectance,
        ggx(Roughness::Fixed(alpha)),
        Fresnel::dielectric(grey(1.5)).unwrap(),
    )
}

/// The alpha of the only lobe that has one.
pub(super) fn roughness(model: &ModelSpec) -> DistributionSpec {
    match model {
        ModelSpec::Microfacet { distribution, .. } | ModelSpec::FresnelBlend { distribution, .. } => *distribution,
        made => made.parts().into_iter().map(roughness).next_back().unwrap(),
    }
}

#[test]
fn without_statements_surfaces_are_matte() {
    let scene = read("WorldBegin\nShape \"sphere\" \"float radius\" 3\nShape \"disk\"\nWorldEnd");
    assert_eq!(super::names(&scene), ["default matte"]);
    let material = &scene.materials[0];
    assert_eq!(
        (&material.model, material.line, material.implied),
        (&diffuse(0.5), None, true)
    );
    assert_eq!(material.calls.len(), 1);
    assert_eq!(material.calls[0].by, "the default material, matte, default Kd");
    assert_eq!(
        (scene.means, scene.name.as_str(), scene.source.as_str()),
        (false, "s", "s.pbrt")
    );
    assert_eq!((scene.unused.len(), scene.warnings.len()), (0, 0));
}

#[test]
fn matte() {
    assert_eq!(one("Material \"matte\"").model, diffuse(0.5));
    let material = one("Material \"matte\" \"rgb Kd\" [.1 .2 .3]\n  \"float sigma\" [20]");
    let rough = OrenNayar::new(Spectrum::rgb([0.1, 0.2, 0.3]), 20.0).unwrap();
    assert_eq!(material.model, ModelSpec::OrenNayar(rough));
    assert_eq!(
        (material.name.as_str(), material.line, material.implied),
        ("matte at line 2", Some(2), false)
    );
    assert_eq!(material.calls[0].by, "line 2: rgb Kd");
    let black = one("Material \"matte\" \"color Kd\" [0 0 0] \"float sigma\" 99");
    assert_eq!((black.model, black.calls.len()), (ModelSpec::Sum(Vec::new()), 0));
    let varying = one("Texture \"t\" \"float\" \"fbm\" Material \"matte\" \"texture sigma\" \"t\"");
    assert_eq!(gaps(&varying), ["sigma"]);
}

#[test]
fn plastic_is_a_coat_in_air_over_a_diffuse_base() {
    let material = one("Material \"plastic\"");
    assert_eq!(
        material.model,
        ModelSpec::Sum(vec![diffuse(0.25), coat(0.25, remapped(0.1))])
    );
    let calls: Vec<(Effect, &str)> = material
        .calls
        .iter()
        .map(|call| (call.effect, call.by.as_str()))
        .collect();
    let by = |name: &str| format!("line 2: Material \"plastic\", default {name}");
    assert_eq!(
        calls,
        [
            (Effect::Dielectric, by("Ks").as_str()),
            (Effect::Diffuse, by("Kd").as_str())
        ]
    );
    let text = "Material \"plastic\" \"rgb Kd\" [0 0 0] \"rgb Ks\" [.5 .5 .5] \"float roughness\" .2 \"bool remaproughness\" \"false\"";
    let material = one(text);
    assert_eq!(material.model, coat(0.5, 0.2));
    assert_eq!(effects(&material), [Effect::Dielectric]);
    // a closed lobe calls for nothing, whatever its roughness
    let closed =
        one("Texture \"t\" \"float\" \"fbm\"\nMaterial \"plastic\" \"rgb Ks\" [0 0 0] \"texture roughness\" \"t\"");
    assert_eq!(
        (closed.model.clone(), effects(&closed)),
        (diffuse(0.25), vec![Effect::Diffuse])
    );
}

#[test]
fn metal() {
    let copper = ConductorIndex::named("Cu").unwrap();
    let material = one("Material \"metal\"");
    let fresnel = Fresnel::conductor(copper.eta(), copper.k()).unwrap();
    assert_eq!(
        material.model,
        lobe(1.0, ggx(Roughness::Fixed(remapped(0.01))), fresnel)
    );
    assert_eq!(effects(&material), [Effect::Metal, Effect::Colour]);
    assert_eq!(material.calls[0].by, "line 2: Material \"metal\"");
    assert_eq!(material.calls[1].by, "line 2: Material \"metal\", default eta");
    let material = one("Material \"metal\" \"rgb eta\" [1 1 1] \"spectrum k\" [400 2 700 2]\n\"float vroughness\" .3");
    let pair = Anisotropic::new(Elliptic::Ggx, remapped(0.01), remapped(0.3)).unwrap();
    let fresnel = Fresnel::conductor(grey(1.0), grey(2.0)).unwrap();
    assert_eq!(material.model, lobe(1.0, DistributionSpec::Anisotropic(pair), fresnel));
    assert_eq!(effects(&material), [Effect::Metal, Effect::Anisotropy]);
    let by = &material.calls[1].by;
    assert!(
        by.contains("default roughness and line 3: float vroughness: alpha_x = "),
        "{by}"
    );
    // as rough along both tangents
    let material = one("Material \"metal\" \"float uroughness\" .3 \"float vroughness\" .3");
    assert_eq!(roughness(&material.model), ggx(Roughness::Fixed(remapped(0.3))));
}

#[test]
fn glass_is_smooth_or_rough() {
    let smooth = |r: f64, t: f64, eta: f64| {
        let glass = FresnelSpecular::new(grey(r), grey(t), 1.0, eta, Transport::Importance);
        ModelSpec::FresnelSpecular(glass.unwrap())
    };
    let material = one("Material \"glass\"");
    assert_eq!((&material.model, gaps(&material).len()), (&smooth(1.0, 1.0, 1.5), 0));
    assert_eq!(effects(&material), [Effect::Transmission]);
    assert_eq!(material.calls[0].by, "line 2: Material \"glass\", default Kt");
    assert_eq!(
        one("Material \"glass\" \"float index\" 1.33").model,
        smooth(1.0, 1.0, 1.33)
    );
    let material =
        one("Material \"glass\" \"float index\" 1.33 \"float eta\" 2 \"rgb Kt\" [0 0 0] \"rgb Kr\" [.5 .5 .5]");
    assert_eq!(material.model, smooth(0.5, 0.0, 2.0));
    assert_eq!(effects(&material), [Effect::Dielectric]);
    let rough = one("Material \"glass\" \"float uroughness\" .1 \"float vroughness\" .1 \"rgb Kr\" [.5 .5 .5]");
    let facets = |alpha| ModelSpec::RoughDielectric {
        reflectance: grey(0.5),
        transmittance: grey(1.0),
        family: Family::Ggx,
        roughness: Roughness::Fixed(alpha),
        masking: Masking::SmithCorrelated,
        media: Media {
            eta_a: 1.0,
            eta_b: 1.5,
            transport: Transport::Importance,
        },
    };
    assert_eq!(rough.model, facets(remapped(0.1)));
    assert_eq!(effects(&rough), [Effect::Transmission]);
    assert!(rough.gaps.is_empty());
    let plain = one(
        "Material \"glass\" \"float uroughness\" .1 \"float vroughness\" .1 \"rgb Kr\" [.5 .5 .5] \"bool remaproughness\" \"false\"",
    );
    assert_eq!(plain.model, facets(0.1));
    // two roughnesses are half of it
    let half = one("Material \"glass\" \"float uroughness\" .1");
    assert_eq!(gaps(&half), ["transmission"]);
    assert!(half.gaps[0].why.contains("two roughnesses"));
    // of two roughnesses one alone is rough, too
    let rough = one("Material \"glass\" \"float uroughness\" .1 \"rgb Kt\" [0 0 0]");
    let pair = Anisotropic::new(Elliptic::Ggx, remapped(0.1), remapped(0.0)).unwrap();
    assert_eq!(roughness(&rough.model), DistributionSpec::Anisotropic(pair));
    assert!(rough.gaps.is_empty());
}

#[test]
fn mirror() {
    let material = one("Material \"mirror\"");
    let mirror = SpecularReflection::new(grey(0.9), Fresnel::None).unwrap();
    assert_eq!(material.model, ModelSpec::SpecularReflection(mirror));
    assert_eq!(effects(&material), [Effect::Metal]);
}

#[test]
fn uber_adds_up_its_lobes() {
    assert_eq!(
        one("Material \"uber\"").model,
        ModelSpec::Sum(vec![diffuse(0.25), coat(0.25, remapped(0.1))])
    );
    let material = one(
        "Material \"uber\" \"rgb Kr\" [.5 .5 .5] \"rgb Kt\" [.25 .25 .25] \"rgb opacity\" [.5 .5 .5] \"float eta\" 1.5\n\
         \"float roughness\" .2",
    );
    let window = |tint: f64, eta: f64| {
        let window = SpecularTransmission::new(grey(tint), 1.0, eta, Transport::Importance);
        ModelSpec::SpecularTransmission(window.unwrap())
    };
    let mirror = SpecularReflection::new(grey(0.25), Fresnel::dielectric(grey(1.5)).unwrap()).unwrap();
    assert_eq!(
        material.model,
        ModelSpec::Sum(vec![
            window(0.5, 1.0),
            diffuse(0.125),
            coat(0.125, remapped(0.2)),
            ModelSpec::SpecularReflection(mirror),
            window(0.125, 1.5),
        ])
    );
    assert_eq!(
        effects(&material),
        [Effect::Dielectric, Effect::Diffuse, Effect::Transmission]
    );
    assert_eq!(material.calls[2].by, "line 2: rgb opacity");
    let cut = one("Texture \"leaf\" \"spectrum\" \"imagemap\" Material \"uber\" \"texture opacity\" \"leaf\"");
    assert_eq!(
        (gaps(&cut), &cut.model),
        (vec!["opacity"], &one("Material \"uber\"").model)
    );
}

#[test]
fn substrate() {
    let material = one("Material \"substrate\"");
    let blend = |rd, distribution| ModelSpec::FresnelBlend {
        rd,
        rs: grey(0.5),
        distribution,
    };
    assert_eq!(material.model, blend(grey(0.5), ggx(Roughness::Fixed(remapped(0.1)))));
    assert_eq!(effects(&material), [Effect::Dielectric, Effect::Diffuse]);
    let material = one("Material \"substrate\" \"rgb Kd\" [.1 .2 .3] \"float uroughness\" .2");
    let pair = Anisotropic::new(Elliptic::Ggx, remapped(0.2), remapped(0.1)).unwrap();
    let red = Spectrum::rgb([0.1, 0.2, 0.3]);
    assert_eq!(material.model, blend(red, DistributionSpec::Anisotropic(pair)));
    assert_eq!(material.calls[3].by, "line 2: rgb Kd");
    assert_eq!(material.calls[3].effect, Effect::Colour);
    assert_eq!(
        one("Material \"substrate\" \"rgb Kd\" [0 0 0] \"rgb Ks\" [0 0 0]").model,
        ModelSpec::Sum(vec![])
    );
}

#[test]
fn translucent_lets_diffuse_light_through() {
    let material = one("Material \"translucent\"");
    assert_eq!(
        material.model,
        ModelSpec::Sum(vec![
            diffuse(0.125),
            ModelSpec::BrdfToBtdf(Box::new(diffuse(0.125))),
            coat(0.125, remapped(0.1)),
        ])
    );
    assert_eq!(
        effects(&material),
        [Effect::Dielectric, Effect::Diffuse, Effect::Transmission]
    );
    assert_eq!(gaps(&material), ["transmission"]);
    let matte = one("Material \"translucent\" \"rgb Ks\" [0 0 0] \"rgb reflect\" [0 0 0] \"rgb transmit\" [1 1 1]");
    assert_eq!(matte.model, ModelSpec::BrdfToBtdf(Box::new(diffuse(0.25))));
    assert!(matte.gaps.is_empty());
}

const TWO: &str =
    "MakeNamedMaterial \"a\" \"string type\" \"matte\"\nMakeNamedMaterial \"b\" \"string type\" [\"mirror\"]\n";

#[test]
fn mixtures_are_sums_of_shares() {
    let mixture = |text: &str| {
        let scene = read(&format!(
            "{TWO}{text}\nMaterial \"mix\" \"string namedmaterial1\" \"a\" \"string namedmaterial2\" \"b\" {}\nShape \"sphere\"",
            if text.contains("amount") {
                "\"texture amount\" \"amount\""
            } else {
                "\"rgb amount\" [.25 .25 .25]"
            }
        ));
        assert_eq!(scene.unused.len(), 0, "{:?}", scene.unused);
        scene.materials[0].clone()
    };
    let scaled = |bxdf, scale: f64| ModelSpec::Scaled {
        bxdf: Box::new(bxdf),
        scale: grey(scale),
    };
    let mirror = ModelSpec::SpecularReflection(SpecularReflection::new(grey(0.9), Fresnel::None).unwrap());
    let material = mixture("");
    let sum = |share: f64| ModelSpec::Sum(vec![scaled(diffuse(0.5), share), scaled(mirror.clone(), 1.0 - share)]);
    assert_eq!(material.model, sum(0.25));
    let calls: Vec<&str> = material.calls.iter().map(|call| call.by.as_str()).collect();
    assert_eq!(
        calls,
        [
            "line 2: MakeNamedMaterial \"b\" of type mirror, default Kr",
            "line 1: MakeNamedMaterial \"a\" of type matte, default Kd"
        ]
    );
    let varying = mixture("Texture \"amount\" \"spectrum\" \"imagemap\"");
    assert_eq!((&varying.model, gaps(&varying)), (&sum(0.5), vec!["amount"]));
    let all = mixture("Texture \"amount\" \"spectrum\" \"constant\"");
    assert_eq!(all.model, scaled(diffuse(0.5), 1.0));
    assert_eq!(effects(&all), [Effect::Diffuse]);
}

#[test]
fn a_mixture_has_one_axis_for_roughness() {
    let text = "Texture \"r\" \"float\" \"fbm\" MakeNamedMaterial \"a\" \"string type\" \"plastic\" \"texture roughness\" \"r\"\n\
                Material \"mix\" \"string namedmaterial1\" \"a\" \"string namedmaterial2\" \"a\" Shape \"sphere\"";
    let scene = read(text);
    let material = &scene.materials[0];
    assert_eq!(material.model.ranges().len(), 1);
    assert_eq!(gaps(material), ["roughness-range"]);
    assert_eq!(
        effects(material),
        [Effect::Dielectric, Effect::Diffuse, Effect::RoughnessRange]
    );
}

#[test]
fn mixtures_are_bounded() {
    let mut text = "MakeNamedMaterial \"m0\" \"string type\" \"none\"\n".to_owned();
    for i in 1..=9 {
        let before = i - 1;
        text += &format!(
            "MakeNamedMaterial \"m{i}\" \"string type\" \"mix\" \"string namedmaterial1\" \"m{before}\" \"string namedmaterial2\" \"m{before}\"\n"
        );
    }
    let error = refused(&text);
    assert!(
        error.starts_with("s.pbrt:10:1: ") && error.contains("at most 8 lie within one another"),
        "{error}"
    );
    let error = refused(&text.replace("\"none\"", "\"plastic\""));
    assert!(
        error.starts_with("s.pbrt:4:1: ") && error.contains("it has 16 lobes, and pbrt takes at most 8"),
        "{error}"
    );
    let error = refused("Material \"mix\" \"string namedmaterial1\" \"a\"");
    assert!(error.contains("\"a\" is not allowed: no MakeNamedMaterial"), "{error}");
    let error = refused(&format!("{TWO}Material \"mix\" \"string namedmaterial1\" \"a\""));
    assert!(error.contains("has no namedmaterial2"), "{error}");
}

#[test]
fn surfaces_between_media_scatter_nothing() {
    for kind in ["", "none"] {
        let material = one(&format!("Material \"{kind}\""));
        assert_eq!(
            (material.name.as_str(), &material.model),
            ("none at line 2", &ModelSpec::Sum(vec![]))
        );
        assert!(material.calls.is_empty() && material.gaps.is_empty());
    }
}

#[test]
fn materials_without_a_model_are_gaps() {
    for kind in ["disney", "hair", "fourier", "subsurface", "kdsubsurface", "velvet"] {
        let material = one(&format!("Material \"{kind}\" \"float whatever\" 3 \"rgb Kd\" [7 7 7]"));
        assert_eq!(
            (&material.model, gaps(&material)),
            (&ModelSpec::Sum(vec![]), vec![kind])
        );
    }
    let disney = one("Material \"disney\" \"float metallic\" .5 \"float clearcoat\" 1 \"float sheen\" 0");
    let expected = [Effect::Metal, Effect::Dielectric, Effect::Diffuse, Effect::Clearcoat];
    assert_eq!(effects(&disney), expected);
}

#[test]
fn gaps_of_blank_types_have_a_name() {
    assert_eq!(gaps(&one("Material \" \"")), ["\" \""]);
}

#[test]
fn gaps_of_mixtures_do_not_double_and_have_a_limit() {
    let mix = |name: &str, a: &str, b: &str| {
        format!(
            "MakeNamedMaterial \"{name}\" \"string type\" \"mix\" \"string namedmaterial1\" \"{a}\" \"string namedmaterial2\" \
             \"{b}\"\n"
        )
    };
    let same = "MakeNamedMaterial \"a\" \"string type\" \"hair\"\n".to_owned() + &mix("a", "a", "a").repeat(8);
    assert_eq!(gaps(&one(&format!("{same}NamedMaterial \"a\""))), ["hair"]);
    // a binary tree of 2^7 types that are not known
    let mut text = String::new();
    for i in 0..128 {
        text += &format!("MakeNamedMaterial \"0 {i}\" \"string type\" \"type {i}\"\n");
    }
    for level in 1..=7 {
        for i in 0..128 >> level {
            let part = |i: usize| format!("{} {i}", level - 1);
            text += &mix(&format!("{level} {i}"), &part(2 * i), &part(2 * i + 1));
        }
    }
    let error = refused(&text);
    assert!(
        error.contains("leave 128 different things out, and at most 64 are told"),
        "{error}"
    );
}
