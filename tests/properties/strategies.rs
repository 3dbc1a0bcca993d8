//! Random parameters over their whole legal ranges, random models of every kind, random directions.

use glam::DVec3;
use proptest::prelude::*;
use proptest::sample::select;
use std::f64::consts::{FRAC_PI_2, PI, TAU};
use std::fmt;
use std::sync::{Arc, LazyLock};
use whitefurnace::bxdf::{
    BrdfToBtdf, Coupling, DiffuseSpecular, FresnelBlend, FresnelSpecular, HalfAngle, Irregular, Lambertian, Media,
    Microfacet, Model, OrenNayar, RoughDielectric, Scaled, SpecularReflection, SpecularTransmission, Sum, Transport,
    other_hemisphere,
};
use whitefurnace::distribution::{Anisotropic, Distribution, Elliptic, Family, Isotropic};
use whitefurnace::fresnel::Fresnel;
use whitefurnace::geometry::Polar;
use whitefurnace::masking::Masking;
use whitefurnace::measured::irregular::IrregularSamples;
use whitefurnace::measured::merl::{MerlTable, write_merl};
use whitefurnace::parameter::{ETA, EXTINCTION, GGX_ALPHA, Legal, SIGMA_DEG};
use whitefurnace::spectrum::Spectrum;

/// The largest number below 1 that a uniform stream draws.
pub(crate) const BELOW_ONE: f64 = 1.0 - 0.5 * f64::EPSILON;

/// 10 to a power that is uniform between the given ones.
pub(crate) fn log_uniform(from: f64, to: f64) -> impl Strategy<Value = f64> + Clone {
    (from..=to).prop_map(|power| 10f64.powf(power))
}

/// Log-uniform over a legal range, often its ends; a range that starts at 0 is entered at 1e-18.
pub(crate) fn parameter(legal: Legal) -> BoxedStrategy<f64> {
    let least = if legal.min > 0.0 { legal.min.log10() } else { -18.0 };
    let usual = least.max(-3.0);
    prop_oneof![
        6 => log_uniform(usual, legal.max.log10()).prop_map(move |x| x.clamp(legal.min, legal.max)),
        2 => log_uniform(least, legal.max.log10()).prop_map(move |x| x.clamp(legal.min, legal.max)),
        1 => select(vec![legal.min, legal.max]),
    ]
    .boxed()
}

/// A number in [0, 1], often one of its ends.
pub(crate) fn share() -> BoxedStrategy<f64> {
    prop_oneof![2 => 0.0..1.0, 1 => Just(0.0), 2 => Just(1.0), 1 => log_uniform(-300.0, 0.0)].boxed()
}

/// Grey, or sometimes three numbers.
fn spectrum(one: BoxedStrategy<f64>) -> BoxedStrategy<Spectrum> {
    prop_oneof![
        3 => one.clone().prop_map(Spectrum::grey),
        1 => [one.clone(), one.clone(), one].prop_map(Spectrum::rgb),
    ]
    .boxed()
}

/// An index of refraction: anywhere, near 1 from both sides, usual ones.
fn index() -> BoxedStrategy<f64> {
    prop_oneof![
        2 => parameter(ETA),
        1 => (log_uniform(-16.0, -0.5), prop::bool::ANY).prop_map(|(step, up)| if up { 1.0 + step } else { 1.0 - step }),
        1 => select(vec![1.0, 1.00029, 1.0 / 1.00029, 1.329, 1.5, 1.0 / 1.5, 2.42]),
    ]
    .boxed()
}

pub(crate) fn fresnel() -> BoxedStrategy<Fresnel> {
    let metal = || (spectrum(index()), spectrum(parameter(EXTINCTION)));
    prop_oneof![
        1 => Just(Fresnel::None),
        2 => spectrum(index()).prop_map(|eta| Fresnel::dielectric(eta).unwrap()),
        2 => metal().prop_map(|(eta, k)| Fresnel::conductor(eta, k).unwrap()),
        1 => metal().prop_map(|(eta, k)| Fresnel::conductor_approximate(eta, k).unwrap()),
        1 => spectrum(share()).prop_map(|r0| Fresnel::schlick(r0).unwrap()),
    ]
    .boxed()
}

pub(crate) fn isotropic() -> BoxedStrategy<Isotropic> {
    select(Family::ALL.to_vec())
        .prop_flat_map(|family| parameter(family.legal()).prop_map(move |roughness| family.with(roughness).unwrap()))
        .boxed()
}

pub(crate) fn distribution() -> BoxedStrategy<Distribution> {
    let elliptic = select(vec![Elliptic::Beckmann, Elliptic::Ggx, Elliptic::AshikhminShirley]);
    let elliptic = elliptic.prop_flat_map(|kind| {
        let [x, y] = kind.legal();
        (parameter(x), parameter(y)).prop_map(move |(x, y)| Anisotropic::new(kind, x, y).unwrap().into())
    });
    prop_oneof![2 => isotropic().prop_map(Distribution::from), 1 => elliptic].boxed()
}

/// Facets that lie in the surface: those that stand off it gain energy, and go with maskings of their own only.
fn lying() -> BoxedStrategy<Distribution> {
    let lies = |distribution: &Distribution| distribution.name() != "charlie";
    distribution().prop_filter("it stands off the surface", lies).boxed()
}

/// A lobe of facets with one of the given maskings, of which those after Smith go with some distributions only.
fn microfacet_of(distribution: BoxedStrategy<Distribution>, maskings: Vec<Masking>) -> BoxedStrategy<Microfacet> {
    (distribution, select(maskings), fresnel(), spectrum(share()))
        .prop_map(|(distribution, masking, fresnel, reflectance)| {
            Microfacet::new(reflectance, distribution, masking, fresnel)
                .or_else(|_| Microfacet::new(reflectance, distribution, Masking::VGroove, fresnel))
                .or_else(|_| Microfacet::new(reflectance, distribution, Masking::Charlie, fresnel))
                .unwrap()
        })
        .boxed()
}

const MASKED: [Masking; 3] = [Masking::VGroove, Masking::Smith, Masking::SmithCorrelated];

pub(crate) fn microfacet() -> BoxedStrategy<Microfacet> {
    let all = [
        MASKED[0],
        MASKED[1],
        MASKED[1],
        MASKED[2],
        MASKED[2],
        Masking::None,
        Masking::Neubelt,
    ];
    microfacet_of(distribution(), all.to_vec())
}

/// A measured table in MERL's layout with a diffuse floor, a lobe, noise of its own and cells marked as invalid.
static TABLE: LazyLock<HalfAngle> = LazyLock::new(|| {
    let mut bytes = Vec::new();
    write_merl(&mut bytes, |theta_h, theta_d, phi_d| {
        let lobe = 4.0 * (-(theta_h / 0.1).powi(2)).exp();
        let f = 0.05 + lobe * (0.04 + 0.96 * (1.0 - theta_d.cos()).powi(5)) * (1.0 + 0.2 * (2.0 * phi_d).cos());
        (theta_h < 1.5 || phi_d > 0.5).then_some([f, 0.5 * f, 0.1 * f])
    })
    .unwrap();
    HalfAngle::new(Arc::new(MerlTable::read_from(&bytes[..], "synthetic").unwrap()))
});

static SAMPLES: LazyLock<Irregular> = LazyLock::new(|| {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/acryl-blue-30.brdf");
    Irregular::new(Arc::new(IrregularSamples::read(path.as_ref()).unwrap()))
});

/// A model that says of measured data only what it is.
#[derive(Clone)]
pub(crate) struct Subject(pub(crate) Model);

impl fmt::Debug for Subject {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if is_measured(&self.0) {
            let parts: Vec<Subject> = self.0.parts().into_iter().cloned().map(Subject).collect();
            return write!(f, "measured, or made of {parts:?}");
        }
        self.0.fmt(f)
    }
}

fn is_measured(model: &Model) -> bool {
    matches!(model, Model::HalfAngle(_) | Model::Irregular(_)) || model.parts().into_iter().any(is_measured)
}

/// Rough interfaces; indices that are as good as equal are refused, and 1.5 takes the place of one.
fn rough_dielectric(modes: Vec<Transport>) -> BoxedStrategy<Model> {
    let shares = (spectrum(share()), spectrum(share()));
    let facets = (
        select(vec![Family::Ggx, Family::Beckmann]),
        parameter(GGX_ALPHA),
        select(MASKED[1..].to_vec()),
    );
    (shares, facets, index(), index(), select(modes))
        .prop_map(|((r, t), (family, alpha, masking), eta_a, eta_b, transport)| {
            let lobe = family.with(alpha).unwrap();
            let made = |eta_b| {
                let media = Media {
                    eta_a,
                    eta_b,
                    transport,
                };
                RoughDielectric::new(r, t, lobe, masking, media)
            };
            let other = if eta_a > 1.2 { 1.0 } else { 1.5 };
            Model::RoughDielectric(made(eta_b).or_else(|_| made(other)).unwrap())
        })
        .boxed()
}

/// Every model that is not made of others.
fn leaf() -> BoxedStrategy<Subject> {
    let transport = || select(vec![Transport::Radiance, Transport::Importance]);
    let reflectance = || spectrum(share());
    prop_oneof![
        1 => reflectance().prop_map(|r| Model::Lambertian(Lambertian::new(r).unwrap())),
        1 => (reflectance(), parameter(SIGMA_DEG))
            .prop_map(|(r, sigma)| Model::OrenNayar(OrenNayar::new(r, sigma).unwrap())),
        6 => microfacet().prop_map(Model::Microfacet),
        3 => (reflectance(), reflectance(), lying())
            .prop_map(|(rd, rs, lobe)| Model::FresnelBlend(FresnelBlend::new(rd, rs, lobe).unwrap())),
        1 => (reflectance(), fresnel())
            .prop_map(|(r, f)| Model::SpecularReflection(SpecularReflection::new(r, f).unwrap())),
        1 => (reflectance(), index(), index(), transport())
            .prop_map(|(t, a, b, mode)| Model::SpecularTransmission(SpecularTransmission::new(t, a, b, mode).unwrap())),
        1 => (reflectance(), reflectance(), index(), index(), transport())
            .prop_map(|(r, t, a, b, mode)| Model::FresnelSpecular(FresnelSpecular::new(r, t, a, b, mode).unwrap())),
        2 => rough_dielectric(vec![Transport::Radiance, Transport::Importance]),
        1 => Just(()).prop_map(|()| Model::HalfAngle(TABLE.clone())),
        1 => Just(()).prop_map(|()| Model::Irregular(SAMPLES.clone())),
    ]
    .prop_map(Subject)
    .boxed()
}

/// Every model but the couplings, adapters around adapters included.
pub(crate) fn model() -> BoxedStrategy<Subject> {
    leaf()
        .prop_recursive(2, 6, 3, |inner| {
            prop_oneof![
                inner
                    .clone()
                    .prop_map(|s| Model::BrdfToBtdf(Box::new(BrdfToBtdf::new(s.0)))),
                (inner.clone(), spectrum(share()))
                    .prop_map(|(s, scale)| Model::Scaled(Box::new(Scaled::new(s.0, scale).unwrap()))),
                prop::collection::vec(inner, 0..4)
                    .prop_map(|parts| Model::Sum(Sum::new(parts.into_iter().map(|s| s.0).collect()))),
            ]
            .prop_map(Subject)
        })
        .boxed()
}

/// Both couplings over a lobe of `specular`.
pub(crate) fn coupling(specular: BoxedStrategy<Model>) -> BoxedStrategy<Subject> {
    let variant = select(vec![Coupling::Mikkelsen, Coupling::EnergyPreserving]);
    (specular, spectrum(share()), spectrum(share()), variant)
        .prop_map(|(specular, ks, kd, variant)| {
            let coupled = DiffuseSpecular::new(specular, ks, kd, variant).unwrap();
            Subject(Model::DiffuseSpecular(Box::new(coupled)))
        })
        .boxed()
}

/// Isotropic lobes and smooth surfaces, whose albedos over all directions are had in milliseconds.
pub(crate) fn specular() -> BoxedStrategy<Model> {
    let isotropic = isotropic().prop_map(Distribution::from);
    let isotropic = isotropic
        .prop_filter("it stands off the surface", |d| d.name() != "charlie")
        .boxed();
    prop_oneof![
        4 => microfacet_of(isotropic, MASKED.to_vec()).prop_map(Model::Microfacet),
        1 => (spectrum(share()), fresnel())
            .prop_map(|(r, f)| Model::SpecularReflection(SpecularReflection::new(r, f).unwrap())),
    ]
    .boxed()
}

/// Models of which no direction gets more back than it sends.
pub(crate) fn conserving() -> BoxedStrategy<Subject> {
    let lobes = || {
        microfacet_of(lying(), MASKED.to_vec())
            .prop_map(Model::Microfacet)
            .boxed()
    };
    let smooth = (spectrum(share()), spectrum(share()), index(), index()).prop_map(|(r, t, a, b)| {
        Model::FresnelSpecular(FresnelSpecular::new(r, t, a, b, Transport::Importance).unwrap())
    });
    let rough = rough_dielectric(vec![Transport::Importance]);
    let single =
        || prop_oneof![4 => lobes(), 1 => specular(), 1 => smooth.clone(), 1 => rough.clone()].prop_map(Subject);
    prop_oneof![
        4 => single(),
        1 => single().prop_map(|s| Subject(Model::BrdfToBtdf(Box::new(BrdfToBtdf::new(s.0))))),
        1 => (single(), spectrum(share()))
            .prop_map(|(s, scale)| Subject(Model::Scaled(Box::new(Scaled::new(s.0, scale).unwrap())))),
        2 => coupling(specular()),
    ]
    .boxed()
}

/// A cosine with the normal: much weight on both ends, where 0 stands for the limit.
pub(crate) fn mu() -> BoxedStrategy<f64> {
    prop_oneof![
        4 => 0.0..1.0,
        1 => Just(1.0),
        2 => log_uniform(-16.0, 0.0).prop_map(|distance| 1.0 - distance),
        2 => log_uniform(-9.0, 0.0),
        1 => log_uniform(-323.0, -9.0),
        1 => select(vec![0.0, f64::MIN_POSITIVE, 5e-324, 1e-300, 1e-160, 1e-9]),
    ]
    .boxed()
}

/// An azimuth: anywhere, along the tangents and next to them.
pub(crate) fn phi() -> BoxedStrategy<f64> {
    prop_oneof![
        3 => 0.0..TAU,
        1 => select(vec![0.0, FRAC_PI_2, PI, -FRAC_PI_2]),
        1 => (0..4i32, log_uniform(-16.0, 0.0)).prop_map(|(quarter, off)| f64::from(quarter) * FRAC_PI_2 + off),
    ]
    .boxed()
}

/// A direction of either hemisphere.
pub(crate) fn direction() -> BoxedStrategy<DVec3> {
    (mu(), phi(), prop::bool::weighted(0.3))
        .prop_map(|(mu, phi, below)| {
            let above = Polar::from_cos(mu).direction(phi);
            if below { -above } else { above }
        })
        .boxed()
}

/// Two directions: anywhere, opposite, mirrored, equal, and next to these.
pub(crate) fn pair() -> BoxedStrategy<(DVec3, DVec3)> {
    let near = prop_oneof![Just(0.0), log_uniform(-16.0, -1.0)];
    (direction(), direction(), 0..6u8, near)
        .prop_map(|(wo, free, kind, off)| {
            let base = match kind {
                0 => -wo,
                1 => other_hemisphere(wo),
                2 => DVec3::new(-wo.x, -wo.y, wo.z),
                3 => wo,
                _ => return (wo, free),
            };
            (
                wo,
                if off == 0.0 {
                    base
                } else {
                    (base + off * free).normalize()
                },
            )
        })
        .boxed()
}

/// A number of [0, 1), its ends included.
pub(crate) fn uniform() -> BoxedStrategy<f64> {
    prop_oneof![
        6 => 0.0..1.0,
        1 => select(vec![0.0, 0.5, BELOW_ONE]),
        1 => log_uniform(-16.0, 0.0).prop_map(|u| u.min(BELOW_ONE)),
        1 => log_uniform(-16.0, 0.0).prop_map(|u| (1.0 - u).clamp(0.0, BELOW_ONE)),
    ]
    .boxed()
}
