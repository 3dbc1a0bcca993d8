//! rho_hh against the mean of rho_hd.

use super::*;
use crate::integrate::half_angle_hd::rho_hd;
use crate::measured::merl::tests::table_of;
use crate::numerics::quadrature::{Piece, integrate};

fn bxdf(f: impl Fn(f64, f64, f64) -> Option<[f64; 3]>) -> HalfAngle {
    HalfAngle::new(table_of(f))
}

#[test]
fn a_diffuse_table_reflects_its_reflectance() {
    let reflectance = DVec3::new(0.18, 0.5, 0.93);
    let bxdf = bxdf(|_, _, _| Some((reflectance / PI).to_array()));
    let integral = rho_hh(&bxdf, 1e-3).unwrap();
    let error = (integral.bounded.value - reflectance).abs();
    assert!(error.cmple(integral.bounded.error).all(), "{integral:?}");
    assert!(integral.bounded.error.max_element() < 2e-14, "{integral:?}"); // some rounding
}

/// One value up to each of some angles and another beyond: every moment of a cell is needed, and rho_hh of a diffuse table
/// comes out when the base is not taken off, as the total of all weights.
#[test]
fn the_weights_of_all_cells_add_up() {
    let bxdf = bxdf(|theta_h, theta_d, _| {
        let base = theta_h_edge(45)..theta_h_edge(46);
        let typical = base.contains(&theta_h) && theta_d_edge(45) < theta_d && theta_d < theta_d_edge(46);
        Some([if typical { 0.0 } else { 1.0 / PI }; 3])
    });
    let typical = {
        let (theta_h, theta_d) = (
            [theta_h_edge(45), theta_h_edge(46)],
            [theta_d_edge(45), theta_d_edge(46)],
        );
        let (c2_h, s2_h) = half_angle_moments(theta_h);
        let (c2_d, s2_d) = difference_angle_moments(theta_d);
        // above the horizon for every phi_d, with f + f = 2/pi over half of the azimuths
        16.0 * (2.0 / PI) * (c2_h * c2_d * FRAC_PI_2 - s2_h * s2_d * cos_squared(0.0, FRAC_PI_2))
    };
    for tolerance in [1e-2, 1e-4, 1e-6] {
        let Bounded { value, error } = rho_hh(&bxdf, tolerance).unwrap().bounded;
        assert!(
            (value.x - (1.0 - typical)).abs() <= error.x,
            "{value} {error} {typical}"
        );
        assert!(error.x <= 1.001 * tolerance);
    }
}

/// With f of phi_d alone rho_hd is smooth in mu.
#[test]
fn tables_of_the_azimuth_agree_with_the_mean_of_rho_hd() {
    let bxdf = bxdf(|_, _, phi| Some([phi.cos().powi(2), (5.0 * phi).sin().powi(2), phi]));
    let mean = integrate(&[Piece::kinked(0.0, 1.0, true, true)], 1e-5, 2000, |mu| {
        rho_hd(&bxdf, mu, 1e-7).unwrap().bounded.scaled(2.0 * mu)
    })
    .unwrap();
    let hh = rho_hh(&bxdf, 1e-6).unwrap();
    let distance = (hh.bounded.value - mean.bounded.value).abs();
    let allowed = hh.bounded.error + mean.bounded.error;
    assert!(distance.cmple(allowed).all(), "{hh:?} {mean:?}");
}

/// A random table varies by about 1e-2 between directions, and the mean of a hundred that are spread evenly over mu^2 by
/// no more than the deviation of as many that are not; 4 of them.
#[test]
fn random_tables_agree_with_the_mean_of_rho_hd() {
    let bxdf = bxdf(|theta_h, theta_d, phi_d| {
        let place = theta_h * 91.7 + theta_d * 53.3 + phi_d * 17.9;
        let mix = |salt: f64| ((place + salt).sin() * 43758.5453).fract().abs();
        Some([mix(0.0), mix(1.0), mix(2.0)])
    });
    let directions = 100;
    let rho: Vec<DVec3> = (0..directions)
        .map(|n| {
            let mu = ((f64::from(n) + 0.5) / f64::from(directions)).sqrt();
            rho_hd(&bxdf, mu, 1e-3).unwrap().bounded.value
        })
        .collect();
    let mean = rho.iter().sum::<DVec3>() / f64::from(directions);
    let deviation = rho.iter().map(|rho| (*rho - mean).length_squared()).sum::<f64>().sqrt() / f64::from(directions);
    let fine = rho_hh(&bxdf, 1e-6).unwrap().bounded;
    assert!(deviation < 2e-3, "{deviation}");
    assert!((fine.value - mean).length() < 4.0 * deviation, "{fine:?} {mean}");
    for tolerance in [1e-2, 1e-3, 1e-4, 1e-5] {
        let coarse = rho_hh(&bxdf, tolerance).unwrap().bounded;
        assert!(
            (coarse.value - fine.value).abs().cmple(coarse.error + fine.error).all(),
            "{tolerance}"
        );
    }
}

/// Cells one by one: the stated error of each holds, also where one cell outshines all others.
#[test]
fn stated_errors_hold_in_every_strip() {
    let mut strips = Vec::new();
    for i in (0..THETA_H_CELLS).step_by(7).chain([THETA_H_CELLS - 1]) {
        for j in 0..THETA_D_CELLS {
            for k in (0..90).step_by(11).chain([89]) {
                let theta_h = [theta_h_edge(i), theta_h_edge(i + 1)];
                let theta_d = [theta_d_edge(j), theta_d_edge(j + 1)];
                strips.extend(Strip::all(theta_h, theta_d, [phi_d_edge(k), phi_d_edge(k + 1)]));
            }
        }
    }
    assert!(strips.len() > 3000, "{}", strips.len());
    let mut over = [0; 3];
    for strip in strips {
        let quarters = strip.split().into_iter().flat_map(Strip::split);
        let fine: f64 = quarters.map(|quarter| quarter.ruled(2).value).sum();
        for level in 0..3 {
            let ruled = strip.ruled(level);
            let error = (ruled.value - fine).abs();
            // what is left of the rounding of terms of the order of 16 (degree)^3
            if error > ruled.difference + 1e-18 {
                println!("{level} {error:e} {:e} {:e} {strip:?}", ruled.difference, ruled.value);
                over[level] += 1;
            }
        }
    }
    assert_eq!(over, [0; 3]);
}
