//! Legal ranges: both ends are accepted wherever a parameter goes, and the next number beyond them is refused by name.

use std::collections::BTreeSet;
use whitefurnace::bxdf::{
    Coupling, DiffuseSpecular, FresnelBlend, FresnelSpecular, Lambertian, Microfacet, Model, OrenNayar, Scaled,
    SpecularReflection, SpecularTransmission, Transport,
};
use whitefurnace::distribution::{Anisotropic, Elliptic, Family};
use whitefurnace::fresnel::Fresnel;
use whitefurnace::masking::Masking;
use whitefurnace::parameter::{self, Legal, Number};
use whitefurnace::scene::Scene;
use whitefurnace::spectrum::Spectrum;

/// Hands a value to a constructor, and gives its message back.
type Constructor = fn(f64) -> Result<(), String>;

fn said<T, E: ToString>(result: Result<T, E>) -> Result<(), String> {
    result.map(drop).map_err(|error| error.to_string())
}

const HALF: Spectrum = Spectrum::grey(0.5);
const ONE: Spectrum = Spectrum::grey(1.0);

/// Blue is looked at as well as red.
fn blue(x: f64) -> Spectrum {
    Spectrum::rgb([0.5, 0.5, x])
}

fn diffuse() -> Model {
    Model::Lambertian(Lambertian::new(HALF).unwrap())
}

fn mode() -> Transport {
    Transport::Radiance
}

/// Every constructor that takes a parameter, with its range.
fn constructors() -> Vec<(Legal, Constructor)> {
    let elliptic = |kind: Elliptic| kind.legal();
    let [m_x, m_y] = elliptic(Elliptic::Beckmann);
    let [alpha_x, alpha_y] = elliptic(Elliptic::Ggx);
    let [e_x, e_y] = elliptic(Elliptic::AshikhminShirley);
    vec![
        (parameter::KAPPA, |x| said(Family::Vmf.with(x))),
        (parameter::BECKMANN_M, |x| said(Family::Beckmann.with(x))),
        (parameter::GGX_ALPHA, |x| said(Family::Ggx.with(x))),
        (parameter::PHONG_N, |x| said(Family::Phong.with(x))),
        (parameter::CHARLIE_ALPHA, |x| said(Family::Charlie.with(x))),
        (m_x, |x| said(Anisotropic::new(Elliptic::Beckmann, x, 0.5))),
        (m_y, |x| said(Anisotropic::new(Elliptic::Beckmann, 0.5, x))),
        (alpha_x, |x| said(Anisotropic::new(Elliptic::Ggx, x, 0.5))),
        (alpha_y, |x| said(Anisotropic::new(Elliptic::Ggx, 0.5, x))),
        (e_x, |x| said(Anisotropic::new(Elliptic::AshikhminShirley, x, 0.5))),
        (e_y, |x| said(Anisotropic::new(Elliptic::AshikhminShirley, 0.5, x))),
        (parameter::ETA, |x| said(Fresnel::dielectric(blue(x)))),
        (parameter::ETA, |x| said(Fresnel::conductor(blue(x), ONE))),
        (parameter::ETA, |x| said(Fresnel::conductor_approximate(blue(x), ONE))),
        (parameter::EXTINCTION, |x| said(Fresnel::conductor(ONE, blue(x)))),
        (parameter::EXTINCTION, |x| {
            said(Fresnel::conductor_approximate(ONE, blue(x)))
        }),
        (parameter::R0, |x| said(Fresnel::schlick(blue(x)))),
        (parameter::ETA_A, |x| {
            said(SpecularTransmission::new(ONE, x, 1.5, mode()))
        }),
        (parameter::ETA_B, |x| {
            said(SpecularTransmission::new(ONE, 1.5, x, mode()))
        }),
        (parameter::ETA_A, |x| {
            said(FresnelSpecular::new(ONE, ONE, x, 1.5, mode()))
        }),
        (parameter::ETA_B, |x| {
            said(FresnelSpecular::new(ONE, ONE, 1.5, x, mode()))
        }),
        (parameter::TRANSMITTANCE, |x| {
            said(SpecularTransmission::new(blue(x), 1.0, 1.5, mode()))
        }),
        (parameter::TRANSMITTANCE, |x| {
            said(FresnelSpecular::new(ONE, blue(x), 1.0, 1.5, mode()))
        }),
        (parameter::REFLECTANCE, |x| {
            said(FresnelSpecular::new(blue(x), ONE, 1.0, 1.5, mode()))
        }),
        (parameter::REFLECTANCE, |x| {
            said(SpecularReflection::new(blue(x), Fresnel::None))
        }),
        (parameter::REFLECTANCE, |x| said(Lambertian::new(blue(x)))),
        (parameter::REFLECTANCE, |x| said(OrenNayar::new(blue(x), 20.0))),
        (parameter::REFLECTANCE, |x| {
            let lobe = Family::Ggx.with(0.5).unwrap();
            said(Microfacet::new(blue(x), lobe, Masking::Smith, Fresnel::None))
        }),
        (parameter::SIGMA_DEG, |x| said(OrenNayar::new(ONE, x))),
        (parameter::RD, |x| {
            said(FresnelBlend::new(blue(x), HALF, Family::Phong.with(9.0).unwrap()))
        }),
        (parameter::RS, |x| {
            said(FresnelBlend::new(HALF, blue(x), Family::Phong.with(9.0).unwrap()))
        }),
        (parameter::SCALE, |x| said(Scaled::new(diffuse(), blue(x)))),
        (parameter::KS, |x| {
            said(DiffuseSpecular::new(diffuse(), blue(x), HALF, Coupling::Mikkelsen))
        }),
        (parameter::KD, |x| {
            said(DiffuseSpecular::new(diffuse(), HALF, blue(x), Coupling::Mikkelsen))
        }),
        (parameter::MU, |x| said(parameter::MU.check(x))),
    ]
}

/// A bxdf for each parameter of a scene file, with `#` in the place of the value.
const SCENES: [(&str, &str); 24] = [
    (
        "kappa",
        "type = \"microfacet\"\ndistribution = { type = \"vmf\", kappa = # }\nmasking = \"v-groove\"\nfresnel = \"none\"",
    ),
    (
        "m",
        "type = \"microfacet\"\ndistribution = { type = \"beckmann\", m = # }\nmasking = \"v-groove\"\nfresnel = \"none\"",
    ),
    (
        "m_x",
        "type = \"microfacet\"\ndistribution = { type = \"beckmann\", m_x = #, m_y = 1.0 }\nmasking = \"smith\"\nfresnel = \"none\"",
    ),
    (
        "m_y",
        "type = \"microfacet\"\ndistribution = { type = \"beckmann\", m_x = 1.0, m_y = # }\nmasking = \"smith\"\nfresnel = \"none\"",
    ),
    (
        "alpha",
        "type = \"microfacet\"\ndistribution = { type = \"ggx\", alpha = # }\nmasking = \"smith\"\nfresnel = \"none\"",
    ),
    (
        "alpha_x",
        "type = \"microfacet\"\ndistribution = { type = \"ggx\", alpha_x = #, alpha_y = 1.0 }\nmasking = \"smith\"\nfresnel = \"none\"",
    ),
    (
        "alpha_y",
        "type = \"microfacet\"\ndistribution = { type = \"ggx\", alpha_x = 1.0, alpha_y = # }\nmasking = \"smith\"\nfresnel = \"none\"",
    ),
    (
        "n",
        "type = \"microfacet\"\ndistribution = { type = \"phong\", n = # }\nmasking = \"none\"\nfresnel = \"none\"",
    ),
    (
        "e_x",
        "type = \"fresnel-blend\"\nrd = 0.5\nrs = 0.5\ndistribution = { type = \"ashikhmin-shirley\", e_x = #, e_y = 1.0 }",
    ),
    (
        "e_y",
        "type = \"fresnel-blend\"\nrd = 0.5\nrs = 0.5\ndistribution = { type = \"ashikhmin-shirley\", e_x = 1.0, e_y = # }",
    ),
    (
        "rd",
        "type = \"fresnel-blend\"\nrd = #\nrs = 0.5\ndistribution = { type = \"phong\", n = 1.0 }",
    ),
    (
        "rs",
        "type = \"fresnel-blend\"\nrd = 0.5\nrs = [0.5, #, 0.5]\ndistribution = { type = \"phong\", n = 1.0 }",
    ),
    ("reflectance", "type = \"lambertian\"\nreflectance = [0.5, 0.5, #]"),
    ("sigma_deg", "type = \"oren-nayar\"\nreflectance = 1.0\nsigma_deg = #"),
    (
        "eta",
        "type = \"specular-reflection\"\nreflectance = 1.0\nfresnel = { type = \"dielectric\", eta = # }",
    ),
    (
        "k",
        "type = \"specular-reflection\"\nreflectance = 1.0\nfresnel = { type = \"conductor\", eta = 1.0, k = [1.0, #, 1.0] }",
    ),
    (
        "r0",
        "type = \"specular-reflection\"\nreflectance = 1.0\nfresnel = { type = \"schlick\", r0 = # }",
    ),
    (
        "eta_a",
        "type = \"fresnel-specular\"\nreflectance = 1.0\ntransmittance = 1.0\neta_a = #\neta_b = 1.5",
    ),
    (
        "eta_b",
        "type = \"specular-transmission\"\ntransmittance = 1.0\neta_b = #",
    ),
    (
        "transmittance",
        "type = \"specular-transmission\"\ntransmittance = #\neta_b = 1.5",
    ),
    (
        "scale",
        "type = \"scaled\"\nscale = #\n[material.bxdf.bxdf]\ntype = \"lambertian\"\nreflectance = 1.0",
    ),
    (
        "ks",
        "type = \"diffuse-specular\"\nks = #\nkd = 0.5\n[material.bxdf.specular]\ntype = \"lambertian\"\nreflectance = 1.0",
    ),
    (
        "kd",
        "type = \"diffuse-specular\"\nks = 0.5\nkd = [0.5, #, 0.5]\n[material.bxdf.specular]\ntype = \"lambertian\"\nreflectance = 1.0",
    ),
    (
        "exponent",
        "type = \"microfacet\"\ndistribution = { type = \"blinn\", exponent = # }\nmasking = \"none\"\nfresnel = \"none\"",
    ),
];

/// Both ends are taken; the next numbers beyond them, infinities and no numbers are refused with value and range.
fn keeps(legal: Legal, names: &[&str], give: impl Fn(f64) -> Result<(), String>) {
    let Legal { name, min, max } = legal;
    for value in [min, max, 0.5 * (min + max)] {
        assert_eq!(give(value), Ok(()), "{name} = {value:e}");
    }
    for value in [
        min.next_down(),
        max.next_up(),
        f64::NAN,
        f64::INFINITY,
        f64::NEG_INFINITY,
    ] {
        let Err(message) = give(value) else {
            panic!("{name} = {value:e} is taken")
        };
        let range = format!("lies in [{}, {}]", Number(min), Number(max));
        let value = Number(value).to_string();
        let lower = message.to_lowercase();
        assert!(
            message.contains(&range) && lower.contains(&value.to_lowercase()),
            "{name} = {value}: {message}"
        );
        assert!(
            names.iter().any(|name| message.contains(&format!("{name} {range}"))),
            "{name}: {message}"
        );
    }
}

#[test]
fn constructors_keep_their_ranges() {
    for (legal, constructor) in constructors() {
        keeps(legal, &[legal.name], constructor);
    }
}

/// The list of ranges has every range that a constructor checks, and nothing else.
#[test]
fn the_list_of_ranges_is_whole() {
    let listed: BTreeSet<&str> = parameter::ALL.iter().map(|legal| legal.name).collect();
    assert_eq!(listed.len(), parameter::ALL.len(), "names are unique");
    let axes = ["m_x", "m_y", "alpha_x", "alpha_y", "e_x", "e_y"];
    let built: BTreeSet<&str> = constructors()
        .iter()
        .map(|(legal, _)| legal.name)
        .filter(|name| !axes.contains(name))
        .collect();
    assert_eq!(listed, built);
    for (legal, _) in constructors() {
        let known = parameter::ALL
            .iter()
            .chain([&parameter::CHARLIE_ALPHA])
            .any(|of| (of.min, of.max) == (legal.min, legal.max));
        assert!(known, "{legal:?}");
    }
}

/// The same of scene files, whose messages name the line too.
#[test]
fn scenes_keep_the_same_ranges() {
    let built = constructors();
    for (key, bxdf) in SCENES {
        let name = if key == "exponent" { "n" } else { key };
        let (legal, _) = built.iter().find(|(legal, _)| legal.name == name).unwrap();
        keeps(*legal, &[key, name], |value| {
            let written = Number(value).to_string().to_lowercase();
            let text = format!(
                "[scene]\nname = \"s\"\n[[material]]\nname = \"m\"\n[material.bxdf]\n{}\n",
                bxdf.replace('#', &written)
            );
            match Scene::parse(&text, "scene.toml") {
                Ok(_) => Ok(()),
                Err(error) => {
                    let message = error.to_string();
                    assert!(message.starts_with("scene.toml:"), "{message}");
                    Err(message)
                }
            }
        });
    }
    let scenes: BTreeSet<&str> = SCENES.iter().map(|(key, _)| *key).collect();
    for (legal, _) in &built {
        assert!(scenes.contains(legal.name) || legal.name == "mu", "{}", legal.name);
    }
}
