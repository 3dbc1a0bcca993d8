//! Limits and identities of [Mikkelsen 2009], each by a rule that shares nothing with the integrators.

mod common;

use common::cases::{Dice, aluminium, beckmann, distributions, grooves, methanol, phong, vmf};
use common::rules::both_ends;
use glam::DVec3;
use std::f64::consts::{FRAC_PI_2, PI, TAU};
use whitefurnace::bxdf::{Bxdf, Coupling, DiffuseSpecular, Lambertian, Microfacet, Model};
use whitefurnace::distribution::Isotropic;
use whitefurnace::fresnel::Fresnel;
use whitefurnace::geometry::Polar;
use whitefurnace::integrate::deterministic::{quadrature, unspent};
use whitefurnace::integrate::{Target, coupled_bxdf};
use whitefurnace::masking::Masking;
use whitefurnace::spectrum::Spectrum;

/// rho_hd to 1e-10.
fn rho(distribution: Isotropic, fresnel: Fresnel, mu: f64) -> f64 {
    let model = Model::Microfacet(grooves(distribution, fresnel));
    quadrature(&model, Target::rho_hd(mu, 0.0), 1e-10).unwrap().value.x
}

/// Eq. 14 by a rule that resolves all scales of theta alike.
#[test]
fn projected_facets_cover_the_surface_once() {
    for d in distributions() {
        let total = TAU
            * both_ends(0.0, FRAC_PI_2, 40, 8, |theta| {
                let theta = Polar::from_angle(theta);
                d.d(theta) * theta.cos * theta.sin
            });
        // 40 panels per octave leave about 1e-11 of a lobe; n = 1e8 and m = 1e-6 carry rounding of theta besides
        assert!((total - 1.0).abs() < 1e-10, "{d:?}: {total}");
    }
}

/// The densities as the paper prints them, where plain evaluation is good enough.
#[test]
fn densities_are_the_printed_ones() {
    for i in 0..100 {
        let theta = 1.5 * f64::from(i) / 100.0;
        let (cos, tan2) = (theta.cos(), theta.tan().powi(2));
        let polar = Polar::from_angle(theta);
        for (d, printed) in [
            (vmf(17.0), 17.0 / (TAU * 17f64.exp_m1()) * (17.0 * cos).exp()), // eq. 29
            (
                beckmann(0.3),
                (-tan2 / 0.09).exp() / (PI * 0.09 * cos.powi(3)), // eq. 20 times n.h
            ),
            (phong(48.0), 50.0 / TAU * cos.powi(49)), // eq. 19 times n.h
        ] {
            let p = d.p(polar);
            // e^(17 cos), tan^2/m^2 and cos^49 multiply the rounding of cos by up to 50
            assert!(
                (p - printed).abs() <= 1e-12 * printed,
                "{d:?} {theta}: {p} and {printed}"
            );
        }
    }
}

/// int max(0, o.h) G1(o, h) D(h) dh, or with |o.h| in place of the indicator; over n.o.
fn visible_facets(d: &Isotropic, mu: f64, indicator: bool) -> f64 {
    let wo = Polar::from_cos(mu);
    let total = both_ends(0.0, FRAC_PI_2, 24, 4, |theta| {
        let theta = Polar::from_angle(theta);
        let density = d.d(theta) * theta.sin;
        if density < 1e-12 {
            return 0.0; // of an integral of about 1/(2 pi)
        }
        let seen = |phi: f64| {
            let cos_d = mu * theta.cos + wo.sin * theta.sin * phi.cos();
            let projected = if indicator { cos_d.max(0.0) } else { cos_d.abs() };
            projected.min(2.0 * theta.cos * mu)
        };
        // at grazing angles everything happens within mu of phi = pi/2
        let near = both_ends(0.0, FRAC_PI_2, 20, 8, seen);
        let far = both_ends(FRAC_PI_2, PI, 20, 8, seen);
        density * 2.0 * (near + far)
    });
    total / mu
}

/// What wo sees of the facets is what it sees of the surface: int max(0, o.h) G1 D dh = n.o.
#[test]
fn visible_facets_add_up_to_the_visible_surface() {
    for d in distributions() {
        for mu in [1e-5, 1e-3, 0.03, 0.3, 0.8, 1.0] {
            let ratio = visible_facets(&d, mu, true);
            // G1 has kinks that the rule does not know of: panels of 0.08 rad leave (0.08)^2/50
            assert!((ratio - 1.0).abs() < 1e-4, "{d:?} mu {mu}: {ratio}");
        }
    }
}

/// With an absolute value in place of the indicator facets that face away are counted too.
#[test]
fn an_absolute_value_in_place_of_the_indicator_creates_energy() {
    for d in [vmf(17.0), beckmann(0.5), phong(10.0)] {
        // at grazing angles as many facets face away as face wo, and both are cut at 2 (n.h)(n.o)
        assert!(visible_facets(&d, 1e-3, false) > 1.9, "{d:?}");
        assert!(visible_facets(&d, 0.1, false) > 1.1, "{d:?}");
        let upright = visible_facets(&d, 1.0, false);
        assert!((upright - 1.0).abs() < 1e-4, "{d:?}: {upright}");
    }
}

/// Narrow lobes reflect like the smooth interface at each fixed angle, off by the squared width.
#[test]
fn narrow_lobes_tend_to_the_fresnel_term() {
    for fresnel in [methanol(), aluminium(), Fresnel::None] {
        for mu in [0.3, 0.7, 1.0] {
            let smooth = fresnel.reflectance(mu).x;
            let families: [[Isotropic; 4]; 3] = [
                [1e3, 1e5, 1e7, 1e12].map(vmf),
                [1e-2, 1e-3, 1e-4, 1e-6].map(beckmann),
                [1e3, 1e5, 1e7, 1e8].map(phong),
            ];
            for family in families {
                for d in family {
                    let difference = (rho(d, fresnel, mu) - smooth).abs();
                    let width = d.width();
                    // the second derivative of F over theta is below 40 down to mu = 0.3; rho itself is good to 1e-10
                    assert!(difference < 20.0 * width * width + 2e-10, "{d:?} {mu}: {difference:e}");
                }
            }
        }
    }
}

/// With F = 1 nothing is lost at mu = 0, and at mu of about the width of the lobe about 0.066 is, however narrow it is.
#[test]
fn the_boundary_layer_dips_to_the_same_depth_for_every_width() {
    for d in distributions() {
        let model = Model::Microfacet(grooves(d, Fresnel::None));
        let horizon = quadrature(&model, Target::rho_hd(0.0, 0.0), 1e-12).unwrap();
        assert!((horizon.value.x - 1.0).abs() <= horizon.error.x, "{d:?}: {horizon:?}");
    }
    let narrow = [[1e4, 1e6, 1e9, 1e12].map(vmf), [1e-2, 1e-3, 1e-4, 1e-6].map(beckmann)];
    for d in narrow.into_iter().flatten().chain([1e4, 1e8].map(phong)) {
        let deepest = (1..=60)
            .map(|i| rho(d, Fresnel::None, 0.05 * f64::from(i) * d.width()))
            .fold(1.0, f64::min);
        // all three are Gaussian in the slope up to the squared width, 1e-4 here
        assert!((deepest - 0.934).abs() < 5e-4, "{d:?}: {deepest}");
    }
}

/// The numbers read off figure 6 (c): what the specular lobe leaves for the base.
#[test]
fn what_methanol_transmits_at_grazing_angles() {
    let left = |kappa: f64, degrees: f64| 1.0 - rho(vmf(kappa), methanol(), degrees.to_radians().cos().max(0.0));
    let limit = |kappa: f64| 1.0 - rho(vmf(kappa), methanol(), 0.0);
    assert!(left(1024.0, 74.45) > 0.8 && left(1024.0, 74.47) < 0.8);
    assert!((limit(1024.0) - 0.1389).abs() < 5e-5); // stated to 0.01 %
    assert!((limit(17.0) - 0.5800).abs() < 5e-5);
    assert!(left(17.0, 89.56) > 0.6 && left(17.0, 89.58) < 0.6);
    for degrees in 0..=89 {
        assert!(left(17.0, f64::from(degrees)) > 0.6);
    }
}

/// Random pairs of directions: anywhere, at the horizon, opposite, mirrored, equal.
fn pair(dice: &mut Dice) -> (DVec3, DVec3) {
    let direction = |dice: &mut Dice| {
        let cos = match dice.pick(&[0, 1, 2, 2]) {
            0 => dice.pick(&[0.0, 1.0]),
            1 => dice.log(-100.0, 0.0).min(1.0),
            _ => dice.uniform(),
        };
        Polar::from_cos(cos).direction(TAU * dice.uniform())
    };
    let wo = direction(dice);
    let wi = match dice.pick(&[0, 1, 1, 1, 1, 1]) {
        0 => dice.pick(&[wo, -wo, DVec3::new(-wo.x, -wo.y, wo.z), DVec3::new(wo.x, wo.y, -wo.z)]),
        _ => direction(dice),
    };
    (wo, wi)
}

fn check_symmetry(name: &str, bxdf: &dyn Bxdf, dice: &mut Dice) {
    for _ in 0..200 {
        let (wo, wi) = pair(dice);
        let f = bxdf.f(wo, wi);
        assert!(f.is_finite() && f.min_element() >= 0.0, "{name} {wo} {wi}: {f}");
        assert_eq!(f, bxdf.f(wi, wo), "{name} {wo} {wi}");
        assert_eq!(f, bxdf.f(-wo, -wi), "{name} {wo} {wi}");
    }
}

/// f(wo, wi) = f(wi, wo) to the last bit, and f is finite and not negative.
#[test]
fn every_model_is_reciprocal_to_the_last_bit() {
    for case in 0..300 {
        let mut dice = Dice::new(2, case);
        let lobe = dice.microfacet();
        check_symmetry(&format!("{lobe:?}"), &lobe, &mut dice);
    }
    let mut dice = Dice::new(3, 0);
    check_symmetry("lambertian", &Lambertian::new(Spectrum::grey(0.5)).unwrap(), &mut dice);
    for coupling in [Coupling::Mikkelsen, Coupling::EnergyPreserving] {
        for (d, fresnel) in [
            (vmf(17.0), methanol()),
            (beckmann(1e-3), aluminium()),
            (phong(1e4), Fresnel::None),
        ] {
            let lobe = grooves(d, fresnel);
            let kd = Spectrum::rgb([0.08, 0.172, 1.0]);
            let coupled = DiffuseSpecular::new(Model::Microfacet(lobe), Spectrum::grey(1.0), kd, coupling).unwrap();
            let bxdf = coupled_bxdf(&coupled, lobe).unwrap();
            check_symmetry(&format!("{coupled:?}"), &bxdf, &mut dice);
        }
    }
}

/// Eq. 28 never gives back more than it gets; divided by 1 - ks rho_bar it gives back everything at ks = kd = 1.
#[test]
fn couplings_conserve_energy() {
    let lobes: Vec<Microfacet> = [
        vmf(17.0),
        vmf(1024.0),
        beckmann(0.2),
        phong(1e4),
        vmf(0.0),
        beckmann(10.0),
    ]
    .into_iter()
    .flat_map(|d| [methanol(), aluminium(), Fresnel::None].map(|fresnel| grooves(d, fresnel)))
    .collect();
    for lobe in lobes {
        let alone = Model::Microfacet(lobe);
        for (ks, kd) in [0.0, 0.5, 1.0]
            .into_iter()
            .flat_map(|ks| [0.0, 0.5, 1.0].map(|kd| (ks, kd)))
        {
            for coupling in [Coupling::Mikkelsen, Coupling::EnergyPreserving] {
                let coupled =
                    DiffuseSpecular::new(alone.clone(), Spectrum::grey(ks), Spectrum::grey(kd), coupling).unwrap();
                let rest = unspent(&coupled, 1e-9).unwrap();
                let model = Model::DiffuseSpecular(Box::new(coupled));
                for mu in [0.0, 1e-5, 1e-2, 0.1, 0.5, 1.0] {
                    let total = quadrature(&model, Target::rho_hd(mu, 0.0), 1e-8).unwrap();
                    assert!(total.value.x <= 1.0 + total.error.x, "{model:?} {mu}: {total:?}");
                    if (ks, kd) == (1.0, 1.0) {
                        let rho = quadrature(&alone, Target::rho_hd(mu, 0.0), 1e-9).unwrap().value.x;
                        let lost = match coupling {
                            Coupling::Mikkelsen => (1.0 - rho) * (1.0 - rest.value.x),
                            Coupling::EnergyPreserving => 0.0,
                        };
                        let allowed = match coupling {
                            Coupling::Mikkelsen => 2e-8, // both tolerances
                            Coupling::EnergyPreserving => 1e-12,
                        };
                        let found = 1.0 - total.value.x;
                        assert!((found - lost).abs() < allowed, "{model:?} {mu}: {found} and {lost}");
                    }
                }
            }
        }
    }
}

/// The albedo that eq. 28 integrates to, by the density of its own sampler: nothing but f and pdf are used.
#[test]
fn coupled_f_integrates_to_the_albedo_that_is_stated() {
    let lobe = grooves(vmf(17.0), methanol());
    for coupling in [Coupling::Mikkelsen, Coupling::EnergyPreserving] {
        let kd = Spectrum::grey(0.7);
        let coupled = DiffuseSpecular::new(Model::Microfacet(lobe), Spectrum::grey(0.9), kd, coupling).unwrap();
        let bxdf = coupled_bxdf(&coupled, lobe).unwrap();
        let model = Model::DiffuseSpecular(Box::new(coupled));
        for mu in [0.1, 0.5, 0.9] {
            let wo = Polar::from_cos(mu).direction(0.3);
            let n = 800;
            let mut sum = 0.0;
            for (i, j) in (0..n).flat_map(|i| (0..n).map(move |j| (i, j))) {
                let (u, v) = ((f64::from(i) + 0.5) / f64::from(n), (f64::from(j) + 0.5) / f64::from(n));
                let wi = Polar {
                    sin: u.sqrt(),
                    cos: (1.0 - u).sqrt(),
                }
                .direction(TAU * v);
                sum += PI * bxdf.f(wo, wi).x;
            }
            let found = sum / f64::from(n * n);
            let stated = quadrature(&model, Target::rho_hd(mu, 0.0), 1e-9).unwrap().value.x;
            // f has steep kinks near the horizon, which midpoints in u = sin^2 resolve to the 3/2 power of 1/800, times 7
            assert!((found - stated).abs() < 3e-4, "{coupling:?} {mu}: {found} and {stated}");
        }
    }
}

/// Masking::None has no limit at the horizon, and says so.
#[test]
fn without_masking_the_albedo_diverges() {
    let lobe = Microfacet::new(Spectrum::grey(1.0), vmf(17.0), Masking::None, Fresnel::None).unwrap();
    let model = Model::Microfacet(lobe);
    assert!(quadrature(&model, Target::rho_hd(0.0, 0.0), 1e-6).is_err());
    let grazing = quadrature(&model, Target::rho_hd(1e-3, 0.0), 1e-6).unwrap().value.x;
    assert!(grazing > 50.0, "{grazing}");
}
