//! rho_hd against independent integrals: exact ones for tables of one variable, Monte Carlo of f for the others.

use super::*;
use crate::bxdf::{Bxdf, Lambertian, Microfacet};
use crate::distribution::Family;
use crate::fresnel::Fresnel;
use crate::integrate::microfacet_hd;
use crate::masking::Masking;
use crate::measured::merl::{self, tests::table_of};
use crate::numerics::quadrature::{Piece, integrate_scalar};
use crate::numerics::stream::{Stream, StreamId};
use crate::spectrum::Spectrum;
use rayon::prelude::*;
use std::f64::consts::TAU;

fn bxdf(f: impl Fn(f64, f64, f64) -> Option<[f64; 3]>) -> HalfAngle {
    HalfAngle::new(table_of(f))
}

/// Unrelated values in [0, 1) in all cells and channels; a tenth of the cells invalid: the hardest case there is.
fn random(theta_h: f64, theta_d: f64, phi_d: f64) -> Option<[f64; 3]> {
    let place = theta_h * 91.7 + theta_d * 53.3 + phi_d * 17.9;
    let mix = |salt: f64| ((place + salt).sin() * 43758.5453).fract().abs();
    (mix(3.0) > 0.1).then_some([mix(0.0), mix(1.0), mix(2.0)])
}

#[test]
fn a_diffuse_table_reflects_its_reflectance() {
    let reflectance = DVec3::new(0.18, 0.5, 0.93);
    let bxdf = bxdf(|_, _, _| Some((reflectance / PI).to_array()));
    for mu in [0.0, 1e-300, 1e-9, 0.01, 0.5, 0.999, 1.0 - 1e-15, 1.0] {
        for tolerance in [1e-3, 1e-12] {
            let integral = rho_hd(&bxdf, mu, tolerance).unwrap();
            let error = (integral.bounded.value - reflectance).abs();
            assert!(error.cmple(integral.bounded.error).all(), "{mu}: {integral:?}");
            // every cell has rounded once on its way through the file
            assert!(integral.bounded.error.max_element() < 2e-14, "{mu}: {integral:?}");
        }
    }
}

/// int_0^pi (m + a cos x)+ dx, twice: the azimuth integral of a cosine that may go negative.
fn clipped_mean(m: f64, a: f64) -> f64 {
    let end = (-m / a).clamp(-1.0, 1.0).acos();
    2.0 * (m * end + a * end.sin())
}

/// f of theta_d alone: i lies on the circle of radius 2 theta_d around o, and int f (n.i)+ di is elementary on each.
#[test]
fn tables_of_the_difference_angle_agree_with_circles_around_o() {
    let f = |theta_d: f64| (7.3 * theta_d).sin().powi(2) + 20.0 * (-(theta_d / 0.05).powi(2)).exp();
    let bxdf = bxdf(|_, theta_d, _| Some([f(theta_d); 3]));
    for mu in [1e-7, 0.03, 0.4, 0.8, 0.9999] {
        let polar = Polar::from_cos(mu);
        let elevation = 0.5 * mu.asin();
        let mut edges: Vec<f64> = (0..=THETA_D_CELLS).map(theta_d_edge).collect();
        edges.extend([elevation, FRAC_PI_2 - elevation]); // kinks where the circle meets the horizon
        edges.sort_by(f64::total_cmp);
        let exact: f64 = edges
            .windows(2)
            .map(|ring| {
                let value = f((theta_d_cell(0.5 * (ring[0] + ring[1])) as f64 + 0.5).to_radians());
                let piece = [Piece::kinked(ring[0], ring[1], true, true)];
                let integral = integrate_scalar(&piece, 1e-13, |theta_d| {
                    let (sin, cos) = (2.0 * theta_d).sin_cos();
                    2.0 * sin * clipped_mean(mu * cos, polar.sin * sin)
                });
                value * integral.unwrap().value
            })
            .sum();
        for tolerance in [1e-3, 1e-6, 1e-10] {
            let integral = rho_hd(&bxdf, mu, tolerance).unwrap();
            let Bounded { value, error } = integral.bounded;
            assert!((value.x - exact).abs() <= error.x + 1e-11, "{mu}: {exact} {integral:?}"); // of the 92 rings
            assert!(error.x <= tolerance + 1e-11, "{mu}: {integral:?}");
        }
    }
}

/// f of theta_h alone, with a peak of 1e6 in a tenth of a degree: the azimuth integral around n is elementary.
#[test]
fn tables_of_the_half_angle_agree_with_circles_around_n() {
    let f = |theta_h: f64| 0.1 + 1e6 * (-(theta_h / 1e-3).powi(2)).exp() + (9.0 * theta_h).cos().powi(2);
    let bxdf = bxdf(|theta_h, _, _| Some([f(theta_h); 3]));
    let centre = |i: usize| FRAC_PI_2 * ((i as f64 + 0.5) / 90.0).powi(2);
    for mu in [1e-7, 0.03, 0.4, 0.8, 0.9999] {
        let view = View::new(mu);
        let mut edges: Vec<f64> = (0..=THETA_H_CELLS).map(theta_h_edge).collect();
        let kinks = [FRAC_PI_4 - 0.5 * view.theta_o, FRAC_PI_4 + 0.5 * view.theta_o];
        edges.extend(kinks);
        edges.retain(|edge| *edge <= kinks[1]);
        edges.sort_by(f64::total_cmp);
        let exact: f64 = edges
            .windows(2)
            .map(|ring| {
                let value = f(centre(theta_h_cell(0.5 * (ring[0] + ring[1]))));
                let piece = [Piece::kinked(ring[0], ring[1], true, true)];
                let integral = integrate_scalar(&piece, 1e-13 / value.max(1.0), |theta| {
                    let theta = Polar::from_angle(theta);
                    let (m, a) = (mu * theta.cos, view.sin_o * theta.sin);
                    let x = ((0.5 * mu / theta.cos - m) / a).clamp(-1.0, 1.0).acos();
                    // int d (2 d c - mu) = (2 c (m^2 + a^2/2) - mu m) x + a (4 c m - mu) sin x + (a^2 c/2) sin 2x
                    let c = theta.cos;
                    let linear = (2.0 * c * (m * m + 0.5 * a * a) - mu * m) * x;
                    8.0 * theta.sin * (linear + a * (4.0 * c * m - mu) * x.sin() + 0.5 * a * a * c * (2.0 * x).sin())
                });
                value * integral.unwrap().value
            })
            .sum();
        for tolerance in [1e-3, 1e-6, 1e-10] {
            let integral = rho_hd(&bxdf, mu, tolerance).unwrap();
            let Bounded { value, error } = integral.bounded;
            assert!((value.x - exact).abs() <= error.x + 1e-11, "{mu}: {exact} {integral:?}"); // of the 92 rings
            assert!(error.x <= tolerance + 1e-11, "{mu}: {integral:?}");
        }
    }
}

/// rho_hd by stratified sampling of f, over equal cells of (cos^2 theta_i, phi_i), with its deviation per channel.
fn monte_carlo(bxdf: &HalfAngle, mu: f64) -> (DVec3, DVec3) {
    let (strata, repeats) = (600, 16);
    let wo = Polar::from_cos(mu).direction(0.3);
    let means: Vec<DVec3> = (0..repeats)
        .into_par_iter()
        .map(|cell| {
            let mut stream = Stream::new(StreamId {
                seed: 3,
                cell,
                batch: mu.to_bits(),
            });
            let mut sum = DVec3::ZERO;
            for row in 0..strata {
                for column in 0..strata {
                    let square = (f64::from(row) + stream.uniform()) / f64::from(strata);
                    let turn = (f64::from(column) + stream.uniform()) / f64::from(strata);
                    sum += bxdf.f(wo, Polar::from_cos(square.sqrt()).direction(TAU * turn));
                }
            }
            sum * (PI / f64::from(strata * strata))
        })
        .collect();
    let n = repeats as f64;
    let mean = means.iter().sum::<DVec3>() / n;
    let square: DVec3 = means.iter().map(|m| (*m - mean) * (*m - mean)).sum();
    (mean, (square / (n * (n - 1.0))).map_sqrt())
}

trait MapSqrt {
    fn map_sqrt(self) -> Self;
}

impl MapSqrt for DVec3 {
    fn map_sqrt(self) -> Self {
        Self::new(self.x.sqrt(), self.y.sqrt(), self.z.sqrt())
    }
}

/// Six deviations of a mean of 16 have a chance of 3e-5 for each of the channels (Student's t), 1e-3 for all that follow.
fn compare(bxdf: &HalfAngle, mu: f64) {
    let (mean, deviation) = monte_carlo(bxdf, mu);
    let integral = rho_hd(bxdf, mu, 1e-9).unwrap();
    let Bounded { value, error } = integral.bounded;
    let distance = (value - mean).abs();
    assert!(
        distance.cmple(6.0 * deviation + error + 1e-15).all(),
        "{mu}: {value} {mean} {deviation}"
    );
    assert!(deviation.max_element() < 3e-4 * mean.max_element(), "{mu}: {deviation}");
    for tolerance in [1e-2, 1e-3, 1e-4, 1e-6] {
        let coarse = rho_hd(bxdf, mu, tolerance).unwrap().bounded;
        assert!(
            (coarse.value - value).abs().cmple(coarse.error + error).all(),
            "{mu} {tolerance}"
        );
        assert!(coarse.error.max_element() <= 1.001 * tolerance, "{mu} {tolerance}"); // and rounding
    }
}

#[test]
fn random_tables_agree_with_monte_carlo() {
    let bxdf = bxdf(random);
    assert!(bxdf.table().invalid() > 0);
    for mu in [1.0, 0.9999, 0.97, 0.6, 0.2, 0.01, 0.0] {
        compare(&bxdf, mu);
    }
}

/// phi_d varies alone: its curves have no other witness.
#[test]
fn tables_of_the_azimuth_agree_with_monte_carlo() {
    let bxdf = bxdf(|_, _, phi| Some([phi.cos().powi(2), (5.0 * phi).sin().powi(2), phi]));
    for mu in [0.95, 0.5, 0.05] {
        compare(&bxdf, mu);
    }
}

#[test]
fn rho_is_continuous_where_the_triangle_degenerates() {
    let bxdf = bxdf(random);
    for (end, near) in [(1.0, 1.0 - 1e-14), (0.0, 1e-12)] {
        let [end, near] = [end, near].map(|mu| rho_hd(&bxdf, mu, 1e-10).unwrap().bounded.value);
        // the curves move by theta_o = 1.4e-7, or by mu
        assert!((end - near).abs().max_element() < 1e-5, "{end} {near}");
    }
    for mu in [1e-300, 1e-30, 1e-16, 1e-5, 1.0 - 1e-10, 1.0 - f64::EPSILON / 2.0] {
        let integral = rho_hd(&bxdf, mu, 1e-6).unwrap();
        assert!(integral.bounded.error.max_element() <= 1.001e-6, "{mu}: {integral:?}");
    }
}

/// A table of a smooth model has the albedo of the model but for the size of its cells. Towards the horizon, where the lobe
/// changes most within a degree, that is 3.5e-4 at mu = 0.2, and 5e-5 or less at the others.
#[test]
fn the_table_of_a_microfacet_lobe_has_its_albedo() {
    let fresnel = Fresnel::dielectric(Spectrum::grey(1.5)).unwrap();
    let normals = Family::Beckmann.with(0.4).unwrap();
    let lobe = Microfacet::new(Spectrum::grey(1.0), normals, Masking::VGroove, fresnel).unwrap();
    let base = Lambertian::new(Spectrum::rgb([0.1, 0.4, 0.3])).unwrap();
    let bxdf = bxdf(|theta_h, theta_d, phi_d| {
        let (wo, wi) = merl::directions(theta_h, theta_d, phi_d);
        let valid = wo.z > 0.0 && wi.z > 0.0;
        valid.then(|| (lobe.f(wo, wi) + base.f(wo, wi)).to_array())
    });
    for mu in [0.2, 0.5, 0.9, 1.0] {
        let model = microfacet_hd::rho_hd(&lobe, &normals, mu, 1e-8).unwrap().bounded.value + base.albedo();
        let table = rho_hd(&bxdf, mu, 1e-8).unwrap().bounded.value;
        assert!((table - model).abs().max_element() < 1e-3, "{mu}: {table} {model}");
    }
    compare(&bxdf, 0.7);
}

/// Arcs one by one, also those next to o and n, where curves turn fast.
#[test]
fn stated_errors_hold_on_every_arc() {
    for mu in [0.0, 1e-9, 1e-4, 0.01, 0.5, 0.3, 0.77, 0.999, 1.0 - 1e-9] {
        let view = View::new(mu);
        let mut arcs = Vec::new();
        for curve in Curve::all() {
            view.arcs(curve, |from, to, _| arcs.push(Arc { curve, from, to }));
        }
        let mut over = [0; 3];
        for arc in &arcs {
            let halves = arc.split().into_iter().flat_map(Arc::split);
            let fine: f64 = halves.map(|arc| view.along(arc, 2).value).sum();
            for level in 0..3 {
                let ruled = view.along(*arc, level);
                // of v next to the plane of incidence, where p moves a hundred times as fast; and of cos p as a difference
                let rounding = 2e-13 * ruled.value.abs() + 2e-16;
                let error = (ruled.value - fine).abs();
                if error > ruled.difference + rounding {
                    println!(
                        "{mu} {level} {error:e} {:e} {:e} {arc:?}",
                        ruled.difference, ruled.value
                    );
                    over[level] += 1;
                }
            }
        }
        assert_eq!(over, [0; 3], "{mu}");
    }
}
