//! The lookup against its formula, its symmetries, and the sampler against its density.

use super::*;
use crate::measured::merl::tests::table_of;
use crate::numerics::stream::{Stream, StreamId};
use std::f64::consts::PI;

fn stream(cell: u64) -> Stream {
    Stream::new(StreamId {
        seed: 7,
        cell,
        batch: 0,
    })
}

/// A different value in every cell, and other values in every channel.
fn hash(theta_h: f64, theta_d: f64, phi_d: f64) -> Option<[f64; 3]> {
    let mix = |salt: f64| {
        ((theta_h * 91.7 + theta_d * 53.3 + phi_d * 17.9 + salt).sin() * 43758.5453)
            .fract()
            .abs()
    };
    Some([mix(0.0), mix(1.0), mix(2.0)])
}

/// A lobe of about a degree over a weak base.
fn narrow(theta_h: f64, _: f64, _: f64) -> Option<[f64; 3]> {
    Some([0.05 + 500.0 * (-(theta_h / 0.02).powi(2)).exp(); 3])
}

fn direction(stream: &mut Stream) -> DVec3 {
    Polar::from_cos(stream.uniform()).direction(TAU * stream.uniform())
}

/// The printed lookup: rotate by -phi_h about z and -theta_h about y, in its own way.
fn printed(table: &MerlTable, wo: DVec3, wi: DVec3) -> (DVec3, f64) {
    let wh = (wo + wi).normalize();
    let (theta_h, phi_h) = (wh.z.acos(), wh.y.atan2(wh.x));
    let whx = DVec3::new(phi_h.cos() * theta_h.cos(), phi_h.sin() * theta_h.cos(), -theta_h.sin());
    let why = DVec3::new(-phi_h.sin(), phi_h.cos(), 0.0);
    let wd = DVec3::new(wi.dot(whx), wi.dot(why), wi.dot(wh));
    let phi_d = wd.y.atan2(wd.x).rem_euclid(PI);
    let places = [
        90.0 * (theta_h / (PI / 2.0)).sqrt(),
        90.0 * wd.z.acos() / (PI / 2.0),
        180.0 * phi_d / PI,
    ];
    // how far the place is from where a cell begins or ends
    let margin = places.map(|p| (p - p.round()).abs()).into_iter().fold(1.0, f64::min);
    (
        table.at(places[0] as usize, places[1] as usize, places[2] as usize),
        margin,
    )
}

/// Directions that are all but opposite, both just above the surface, keep theta_h and phi_d however low they are.
#[test]
fn nearly_opposite_directions_have_their_half_vector() {
    let bxdf = HalfAngle::new(table_of(hash));
    for aside in [0.0, 0.7, -1.6] {
        let at = |low: f64| {
            let (wo, wi) = (
                DVec3::new(1.0, 0.1 * low, low),
                DVec3::new(-1.0, aside * low, 0.3 * low),
            );
            bxdf.f(wo, wi)
        };
        assert!(at(1e-20).x > 0.0);
        for low in [1e-100, 1e-150, 1e-160, 1e-200, 1e-300] {
            assert_eq!(at(low), at(1e-20), "{aside} {low:e}");
        }
    }
}

#[test]
fn the_lookup_is_that_of_the_book() {
    let bxdf = HalfAngle::new(table_of(hash));
    let mut stream = stream(0);
    let mut compared = 0;
    for _ in 0..100_000 {
        let (wo, wi) = (direction(&mut stream), direction(&mut stream));
        let (value, margin) = printed(bxdf.table(), wo, wi);
        // the printed form loses digits of small angles, 1e-8 at worst; its last cells are open at the upper end
        if margin > 1e-5 {
            assert_eq!(bxdf.f(wo, wi), value, "{wo} {wi}");
            compared += 1;
        }
    }
    assert!(compared > 99_000, "{compared}");
}

#[test]
fn directions_meet_their_cell() {
    let bxdf = HalfAngle::new(table_of(hash));
    for (i, j, k) in [
        (0, 0, 0),
        (0, 3, 179),
        (10, 20, 30),
        (45, 30, 90),
        (60, 10, 120),
        (5, 80, 100),
    ] {
        let theta_h = 0.5 * (merl::theta_h_edge(i) + merl::theta_h_edge(i + 1));
        let (theta_d, phi_d) = ((j as f64 + 0.5).to_radians(), (k as f64 + 0.5).to_radians());
        let (wo, wi) = merl::directions(theta_h, theta_d, phi_d);
        assert!((wo.length() - 1.0).abs() < 1e-15 && (wi.length() - 1.0).abs() < 1e-15);
        assert_eq!(bxdf.f(wo, wi), bxdf.table().at(i, j, k));
        let (wo, wi) = merl::directions(theta_h, theta_d, phi_d + PI);
        assert_eq!(bxdf.f(wo, wi), bxdf.table().at(i, j, k));
    }
}

#[test]
fn f_is_symmetric_to_the_last_bit_and_keeps_to_its_side() {
    let bxdf = HalfAngle::new(table_of(hash));
    assert_eq!(bxdf.channels(), Channels::Rgb);
    let mut stream = stream(1);
    let awkward = [
        DVec3::Z,
        DVec3::X,
        DVec3::NEG_X,
        DVec3::Y,
        DVec3::new(1.0, 0.0, -0.0),
        DVec3::new(0.6, 0.0, 0.8),
    ];
    for n in 0..20_000 {
        let (mut wo, mut wi) = (direction(&mut stream), direction(&mut stream));
        if n < 36 {
            (wo, wi) = (awkward[n / 6], awkward[n % 6]);
        } else if n % 3 == 0 {
            // on the plane of incidence, the seam of phi_d
            (wo.y, wi.y) = (0.0, 0.0);
        }
        let value = bxdf.f(wo, wi);
        assert!(value.is_finite() && value.min_element() >= 0.0);
        assert_eq!(value, bxdf.f(wi, wo), "{wo} {wi}");
        assert_eq!(value, bxdf.f(-wo, -wi), "{wo} {wi}");
        if wo.z > 0.0 && wi.z > 0.0 {
            assert_eq!(bxdf.f(wo, -wi), DVec3::ZERO);
        }
    }
    assert_eq!(bxdf.f(DVec3::X, DVec3::NEG_X), DVec3::ZERO);
}

#[test]
fn the_normal_sees_both_sides_of_the_seam() {
    let bxdf = HalfAngle::new(table_of(|_, _, phi| Some([if phi < PI / 2.0 { 1.0 } else { 3.0 }; 3])));
    assert_eq!(bxdf.channels(), Channels::Grey);
    let wi = Polar::from_angle(0.7).direction(0.3);
    assert!((bxdf.f(DVec3::Z, wi) - DVec3::splat(2.0)).abs().max_element() < 1e-15);
}

/// Counts in equal bins of (cos theta, phi) over the sphere against the integral of the density over each bin, and the
/// total against 1. Pearson's statistic of n bins has mean n and variance 2 n; 6 deviations leave 1e-9 to chance, and the
/// integrals, means over 576 places each, add a tenth of n.
#[test]
fn samples_follow_their_density() {
    let (rings, sectors, draws) = (40, 16, 400_000);
    for (cell, model) in [hash as fn(f64, f64, f64) -> _, narrow, |_, _, _| Some([0.0; 3])]
        .into_iter()
        .enumerate()
    {
        let bxdf = HalfAngle::new(table_of(model));
        for (n, cos_o) in [1.0, 0.9, 0.3, 0.02, -0.5].into_iter().enumerate() {
            let wo = Polar::from_cos(f64::abs(cos_o)).direction(0.4) * f64::signum(cos_o);
            let mut counts = vec![0.0; rings * sectors];
            let mut stream = stream(10 + 10 * cell as u64 + n as u64);
            for _ in 0..draws {
                let sample = bxdf.sample_f(wo, stream.uniform3());
                assert!((sample.wi.length() - 1.0).abs() < 1e-12);
                assert_eq!(sample.pdf, bxdf.pdf(wo, sample.wi));
                let expected = bxdf.f(wo, sample.wi) * (sample.wi.z.abs() / sample.pdf);
                assert_eq!(sample.weight, expected);
                let ring = ((0.5 + 0.5 * sample.wi.z) * rings as f64) as usize;
                let sector = ((sample.wi.y.atan2(sample.wi.x) / TAU + 1.0).fract() * sectors as f64) as usize;
                counts[ring.min(rings - 1) * sectors + sector.min(sectors - 1)] += 1.0;
            }
            // a stratified mean over 24 x 24 places, too coarse for a narrow lobe, which has a test of its own
            if cell == 1 {
                continue;
            }
            let fine = 24;
            let (mut statistic, mut total) = (0.0, 0.0);
            for (bin, count) in counts.iter().enumerate() {
                let mut mass = 0.0;
                for a in 0..fine * fine {
                    let ring = (bin / sectors) as f64 + ((a / fine) as f64 + stream.uniform()) / fine as f64;
                    let sector = (bin % sectors) as f64 + ((a % fine) as f64 + stream.uniform()) / fine as f64;
                    let z = 2.0 * ring / rings as f64 - 1.0;
                    let phi = TAU * sector / sectors as f64;
                    let wi = (Polar::from_cos(z).sin * glam::DVec2::from_angle(phi)).extend(z);
                    mass += bxdf.pdf(wo, wi) * 2.0 * TAU / (counts.len() * fine * fine) as f64;
                }
                total += mass;
                let expected = mass * f64::from(draws);
                statistic += (count - expected).powi(2) / expected.max(1.0);
            }
            let bins = counts.len() as f64;
            assert!((total - 1.0).abs() < 2e-3, "{cell} {cos_o}: {total}");
            assert!(
                statistic < bins + 6.0 * (2.0 * bins).sqrt() + 60.0,
                "{cell} {cos_o}: {statistic}"
            );
        }
    }
}

/// Mean weights of the model's own samples and of cosine samples both estimate rho_hd, and must agree within 5 of their joint
/// deviations. The lobe is found: the variance is far smaller.
#[test]
fn a_narrow_lobe_is_found() {
    let bxdf = HalfAngle::new(table_of(narrow));
    for (n, cos_o) in [1.0, 0.7, 0.2].into_iter().enumerate() {
        let wo = Polar::from_cos(cos_o).direction(0.0);
        let mut stream = stream(100 + n as u64);
        let draws = 400_000;
        let mut means = [[0.0; 2]; 2];
        for _ in 0..draws {
            let u = stream.uniform3();
            let own = bxdf.sample_f(wo, u).weight.x;
            let wi = cosine_hemisphere([u[0], u[1]]);
            let cosine = bxdf.f(wo, wi).x * PI;
            for (mean, weight) in means.iter_mut().zip([own, cosine]) {
                mean[0] += weight / f64::from(draws);
                mean[1] += weight * weight / f64::from(draws);
            }
        }
        let variance = means.map(|[mean, square]| (square - mean * mean) / f64::from(draws));
        let distance = (means[0][0] - means[1][0]).abs();
        assert!(
            distance < 5.0 * (variance[0] + variance[1]).sqrt(),
            "{cos_o}: {means:?}"
        );
        assert!(variance[0] < 0.05 * variance[1], "{cos_o}: {variance:?}");
    }
}
