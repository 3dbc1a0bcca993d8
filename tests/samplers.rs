//! Samplers follow their densities, and densities add up to one.

mod common;

use common::cases::{
    aluminium, ashikhmin_shirley, beckmann, beckmann_xy, ggx, ggx_xy, grooves, methanol, phong, smith, vmf,
};
use common::rules::{both_ends, composite, octaves, stretched_angles, stretched_normal};
use common::statistics::{counts_p, sidak};
use glam::DVec3;
use rayon::prelude::*;
use statrs::distribution::{ContinuousCDF, Normal};
use std::f64::consts::{FRAC_PI_2, PI, TAU};
use whitefurnace::bxdf::{Bxdf, Coupling, DiffuseSpecular, Microfacet, Model, Sampling};
use whitefurnace::distribution::{Distribution, Isotropic};
use whitefurnace::geometry::Polar;
use whitefurnace::integrate::coupled_bxdf;
use whitefurnace::masking::{Masking, Smith, sample_visible_groove, visible_groove_pdf};
use whitefurnace::numerics::moments::Moments;
use whitefurnace::numerics::stream::{Stream, StreamId};
use whitefurnace::spectrum::Spectrum;

fn stream(seed: u64, cell: u64) -> Stream {
    Stream::new(StreamId { seed, cell, batch: 0 })
}

const DRAWS: u64 = 200_000;
const RINGS: usize = 12;
const SECTORS: usize = 8;

/// Angles between which a twelfth of the normals each lies, by bisection of the density's own integral.
fn ring_edges(d: &Isotropic) -> Vec<f64> {
    // a fine table of the integral, octave by octave, serves all twelve
    let mut table = vec![(0.0, 0.0)];
    let width = d.width();
    let mut sum = 0.0;
    let step = width / 200.0;
    let mut theta = 0.0;
    while theta < FRAC_PI_2 {
        let next: f64 = (theta + step.max(theta * 0.01)).min(FRAC_PI_2);
        sum += composite(theta, next, 1, |t| {
            let polar = Polar::from_angle(t);
            TAU * d.p(polar) * polar.sin
        });
        table.push((next, sum));
        theta = next;
    }
    (1..RINGS)
        .map(|i| {
            let wanted = i as f64 / RINGS as f64;
            let at = table.partition_point(|(_, sum)| *sum < wanted);
            let ((a, p), (b, q)) = (table[at - 1], table[at]);
            a + (b - a) * (wanted - p) / (q - p)
        })
        .chain([FRAC_PI_2])
        .collect()
}

fn ring(edges: &[f64], theta: f64) -> usize {
    edges.partition_point(|edge| *edge < theta).min(edges.len() - 1)
}

fn sector(w: DVec3) -> usize {
    ((w.y.atan2(w.x) / TAU + 1.0).fract() * SECTORS as f64) as usize % SECTORS
}

fn sampled_distributions() -> [Isotropic; 9] {
    [
        vmf(0.0),
        vmf(17.0),
        vmf(1e5),
        beckmann(0.01),
        beckmann(0.2),
        beckmann(3.0),
        phong(0.0),
        phong(48.0),
        phong(1e6),
    ]
}

/// Integral of a density of normals over the bins between ring edges and sector borders, times the number of draws.
fn expected(edges: &[f64], density: impl Fn(Polar, DVec3) -> f64 + Sync) -> Vec<f64> {
    (0..edges.len() * SECTORS)
        .into_par_iter()
        .map(|bin| {
            let (i, j) = (bin / SECTORS, (bin % SECTORS) as f64);
            let from = if i == 0 { 0.0 } else { edges[i - 1] };
            let over = |phi: f64| {
                let at = |theta: f64| {
                    let polar = Polar::from_angle(theta);
                    polar.sin * density(polar, polar.direction(phi))
                };
                if i + 1 < edges.len() {
                    composite(from, edges[i], 10, at)
                } else {
                    // the last ring reaches far beyond a narrow lobe
                    octaves(edges[i] - from, 22, 3, |x| at(from + x))
                }
            };
            let sector = TAU / SECTORS as f64;
            DRAWS as f64 * composite(j * sector, (j + 1.0) * sector, 12, over)
        })
        .collect()
}

/// Half vectors follow p(h), and visible ones min(...) p(h), in rings of equal mass and sectors.
#[test]
fn sampled_normals_follow_their_densities() {
    let directions = [0.05, 0.4, 1.0];
    let level = sidak(sampled_distributions().len() * (1 + directions.len()));
    for (index, d) in sampled_distributions().iter().enumerate() {
        let edges = ring_edges(d);
        let count = |draw: &dyn Fn([f64; 3]) -> DVec3, seed: u64| {
            let mut counts = vec![0; RINGS * SECTORS];
            let mut random = stream(seed, index as u64);
            for _ in 0..DRAWS {
                let w = draw(random.uniform3());
                counts[ring(&edges, Polar::of(w).angle()) * SECTORS + sector(w)] += 1;
            }
            counts
        };
        let p = counts_p(
            &count(&|u| d.sample([u[0], u[1]]), 51),
            &expected(&edges, |theta, _| d.p(theta)),
        );
        assert!(p > level, "{d:?}: p = {p:e}");
        for (direction, mu) in directions.into_iter().enumerate() {
            let wo = Polar::from_cos(mu).direction(0.7);
            let facets = Distribution::from(*d);
            let density = |_: Polar, wm: DVec3| visible_groove_pdf(&facets, mu, wm, wo.dot(wm));
            let counts = count(&|u| sample_visible_groove(&facets, wo, u), 52 + direction as u64);
            let p = counts_p(&counts, &expected(&edges, density));
            assert!(p > level, "{d:?} visible from {mu}: p = {p:e}");
        }
    }
}

/// A sampler of another concentration fails the same test.
#[test]
fn the_test_of_samplers_rejects_another_lobe() {
    let (right, wrong) = (vmf(17.0), vmf(17.5));
    let edges = ring_edges(&right);
    let mut counts = vec![0; RINGS * SECTORS];
    let mut random = stream(61, 0);
    for _ in 0..DRAWS {
        let w = wrong.sample([random.uniform(), random.uniform()]);
        counts[ring(&edges, Polar::of(w).angle()) * SECTORS + sector(w)] += 1;
    }
    let p = counts_p(&counts, &expected(&edges, |theta, _| right.p(theta)));
    assert!(p < 1e-6, "{p}");
}

/// Directions that `sample_f` draws follow `pdf`, above and below the horizon, and `pdf` adds up to 1 over all of them.
#[test]
fn sampled_directions_follow_their_density() {
    let mut models: Vec<(String, Box<dyn Bxdf>)> = Vec::new();
    for d in [vmf(0.0), vmf(17.0), beckmann(0.4), phong(20.0)] {
        let lobe = grooves(d, methanol());
        models.push((format!("{d:?}"), Box::new(lobe)));
        let coupled = DiffuseSpecular::new(
            Model::Microfacet(lobe),
            Spectrum::grey(1.0),
            Spectrum::grey(0.5),
            Coupling::Mikkelsen,
        )
        .unwrap();
        models.push((
            format!("coupled {d:?}"),
            Box::new(coupled_bxdf(&coupled, lobe).unwrap()),
        ));
    }
    let slopes = [
        ggx(0.3).into(),
        beckmann(0.4).into(),
        ggx_xy(0.2, 0.6),
        beckmann_xy(0.6, 0.25),
    ];
    for (index, d) in slopes.into_iter().enumerate() {
        models.push((format!("Smith {d:?}"), Box::new(smith(d, methanol(), index % 2 == 0))));
    }
    models.push((
        "Ashikhmin-Shirley".into(),
        Box::new(grooves(ashikhmin_shirley(5.0, 40.0), methanol())),
    ));
    let directions = [0.1, 0.6, 1.0];
    let level = sidak(models.len() * directions.len());
    let edges: Vec<f64> = (1..=RINGS).map(|i| FRAC_PI_2 * i as f64 / RINGS as f64).collect();
    for (index, (name, bxdf)) in models.iter().enumerate() {
        for (direction, mu) in directions.into_iter().enumerate() {
            let wo = Polar::from_cos(mu).direction(0.7);
            let mut counts = vec![0; RINGS * SECTORS + 1];
            let mut random = stream(71 + direction as u64, index as u64);
            for _ in 0..DRAWS {
                let wi = bxdf.sample_f(wo, random.uniform3()).wi;
                let bin = if wi.z > 0.0 {
                    ring(&edges, Polar::of(wi).angle()) * SECTORS + sector(wi)
                } else {
                    RINGS * SECTORS
                };
                counts[bin] += 1;
            }
            let mut expected = expected(&edges, |_, wi| bxdf.pdf(wo, wi));
            let above = expected.iter().sum::<f64>() / DRAWS as f64;
            // kinks of the density between the nodes of 120 x 50 points leave less than 1e-4
            assert!(above <= 1.0 + 1e-4, "{name} {mu}: {above}");
            expected.push(((1.0 - above) * DRAWS as f64).max(0.0));
            let p = counts_p(&counts, &expected);
            assert!(p > level, "{name} from {mu}: p = {p:e}");
        }
    }
}

/// int pdf <= 1 by a rule of its own, from the pole to the horizon, for directions and for normals.
#[test]
fn densities_do_not_exceed_one() {
    for d in [vmf(17.0), beckmann(0.2), phong(48.0)] {
        for mu in [1e-3, 0.1, 0.6, 1.0] {
            let wo = Polar::from_cos(mu).direction(0.0);
            let total = both_ends(0.0, FRAC_PI_2, 12, 10, |theta| {
                let polar = Polar::from_angle(theta);
                let circle = |from: f64, to: f64| {
                    both_ends(from, to, 12, 10, |phi| {
                        visible_groove_pdf(&d.into(), mu, polar.direction(phi), wo.dot(polar.direction(phi)))
                    })
                };
                2.0 * polar.sin * (circle(0.0, FRAC_PI_2) + circle(FRAC_PI_2, PI))
            });
            // visible normals add up to the visible surface; kinks leave the squared panel, 1e-4
            assert!((total - 1.0).abs() < 1e-4, "{d:?} {mu}: {total}");
        }
    }
}

/// Draws in bins of [`stretched_angles`], in which an elliptic lobe is as wide along every azimuth.
fn stretched_counts(axes: [f64; 2], seed: u64, cell: u64, draw: impl Fn([f64; 3]) -> DVec3) -> Vec<u64> {
    let mut counts = vec![0; RINGS * SECTORS];
    let mut random = stream(seed, cell);
    for _ in 0..DRAWS {
        let (v, psi) = stretched_angles(axes, draw(random.uniform3()));
        let ring = (v / FRAC_PI_2 * RINGS as f64) as usize;
        let sector = ((psi / TAU + 1.0).fract() * SECTORS as f64) as usize;
        counts[ring.min(RINGS - 1) * SECTORS + sector.min(SECTORS - 1)] += 1;
    }
    counts
}

/// What a density of normals expects of [`stretched_counts`].
fn stretched_expected(axes: [f64; 2], density: impl Fn(DVec3) -> f64 + Sync) -> Vec<f64> {
    let (height, width) = (FRAC_PI_2 / RINGS as f64, TAU / SECTORS as f64);
    (0..RINGS * SECTORS)
        .into_par_iter()
        .map(|bin| {
            let (i, j) = ((bin / SECTORS) as f64, (bin % SECTORS) as f64);
            let over = |psi: f64| {
                composite(i * height, (i + 1.0) * height, 12, |v| {
                    let (h, solid_angle) = stretched_normal(axes, v, psi);
                    density(h) * solid_angle
                })
            };
            DRAWS as f64 * composite(j * width, (j + 1.0) * width, 12, over)
        })
        .collect()
}

/// Half vectors of anisotropic distributions follow p(h).
#[test]
fn anisotropic_normals_follow_their_density() {
    let mut lobes = Vec::new();
    for axes @ [x, y] in [[0.3, 0.3], [0.1, 0.7], [3.0, 0.2], [1e-6, 10.0]] {
        lobes.extend([(axes, beckmann_xy(x, y)), (axes, ggx_xy(x, y))]);
    }
    for [x, y] in [[10.0, 10.0], [3.0, 300.0], [1e6, 0.0]] {
        let axes = [x, y].map(|e| 1.0 / f64::sqrt(e + 2.0));
        lobes.push((axes, ashikhmin_shirley(x, y)));
    }
    let level = sidak(lobes.len());
    for (index, (axes, d)) in lobes.into_iter().enumerate() {
        let counts = stretched_counts(axes, 91, index as u64, |u| d.sample([u[0], u[1]]));
        let p = counts_p(&counts, &stretched_expected(axes, |h| d.p(h)));
        assert!(p > level, "{d:?}: p = {p:e}");
    }
}

/// Lobes under Smith masking, with their widths along the tangents.
fn smith_lobes() -> Vec<([f64; 2], Distribution)> {
    let mut lobes: Vec<([f64; 2], Distribution)> = Vec::new();
    for width in [1e-3, 0.3, 2.0] {
        lobes.extend([([width; 2], beckmann(width).into()), ([width; 2], ggx(width).into())]);
    }
    for axes @ [x, y] in [[0.1, 0.7], [3.0, 0.2], [1e-6, 10.0]] {
        lobes.extend([(axes, beckmann_xy(x, y)), (axes, ggx_xy(x, y))]);
    }
    lobes
}

/// G1(o) max(0, o.h) D(h)/(n.o)
fn visible_density(d: &Distribution, wo: DVec3, h: DVec3) -> f64 {
    let slopes = Smith::new(d).unwrap();
    wo.dot(h).max(0.0) * d.d(h) / slopes.seen(wo, wo.z)
}

/// Visible normals under Smith follow G1 max(0, o.h) D/(n.o).
#[test]
fn smith_visible_normals_follow_their_density() {
    let directions = [0.0, 1e-3, 0.05, 0.5, 1.0];
    let level = sidak(smith_lobes().len() * directions.len());
    for (index, (axes, d)) in smith_lobes().into_iter().enumerate() {
        for (direction, mu) in directions.into_iter().enumerate() {
            let wo = Polar::from_cos(mu).direction(0.7);
            let draw = |u| Masking::SmithCorrelated.sample_visible(&d, wo, u);
            let counts = stretched_counts(axes, 92 + direction as u64, index as u64, draw);
            let p = counts_p(&counts, &stretched_expected(axes, |h| visible_density(&d, wo, h)));
            assert!(p > level, "{d:?} from {mu}: p = {p:e}");
        }
    }
}

/// Samplers of visible normals with a mistake fail the same test.
#[test]
fn the_test_of_visible_normals_rejects_mistakes() {
    let (axes, swapped) = ([0.3, 0.6], [0.6, 0.3]);
    let wo = Polar::from_cos(0.4).direction(0.7);
    for (family, d, other) in [
        (0, beckmann_xy(axes[0], axes[1]), beckmann_xy(swapped[0], swapped[1])),
        (1, ggx_xy(axes[0], axes[1]), ggx_xy(swapped[0], swapped[1])),
    ] {
        let (right, round) = (
            Smith::new(&d).unwrap(),
            [beckmann_xy(1.0, 1.0), ggx_xy(1.0, 1.0)][family],
        );
        let (swapped, round) = (Smith::new(&other).unwrap(), Smith::new(&round).unwrap());
        let expected = stretched_expected(axes, |h| visible_density(&d, wo, h));
        let p_of = |draw: &dyn Fn([f64; 2]) -> DVec3| {
            counts_p(
                &stretched_counts(axes, 101, family as u64, |u| draw([u[0], u[1]])),
                &expected,
            )
        };
        let right = p_of(&|u| right.sample_visible(wo, u));
        assert!(right > sidak(2), "{d:?}: {right:e}");
        let stretched = |h: DVec3| DVec3::new(axes[0] * h.x, axes[1] * h.y, h.z).normalize();
        for (mistake, p) in [
            ("axes swapped", p_of(&|u| swapped.sample_visible(wo, u))),
            ("wo not stretched", p_of(&|u| stretched(round.sample_visible(wo, u)))),
            ("not weighted by o.h", p_of(&|u| d.sample(u))),
        ] {
            assert!(p < 1e-6, "{d:?}, {mistake}: {p}");
        }
        // the Jacobian 4 (o.h) left out of the density, normalised all the same
        let mut expected = stretched_expected(axes, |h| visible_density(&d, wo, h) / (4.0 * wo.dot(h).max(1e-9)));
        let sum: f64 = expected.iter().sum();
        expected.iter_mut().for_each(|e| *e *= DRAWS as f64 / sum);
        let right = Smith::new(&d).unwrap();
        let counts = stretched_counts(axes, 101, family as u64, |u| right.sample_visible(wo, [u[0], u[1]]));
        let p = counts_p(&counts, &expected);
        assert!(p < 1e-6, "{d:?}, Jacobian: {p}");
    }
}

/// All samplings have the same mean weight, rho_hd.
#[test]
fn samplings_of_a_lobe_agree() {
    let lobes: Vec<Microfacet> = vec![
        smith(ggx(0.5), aluminium(), false),
        smith(ggx(0.5), methanol(), true),
        smith(beckmann(0.4), aluminium(), true),
        smith(ggx_xy(0.3, 0.9), methanol(), true),
        smith(beckmann_xy(0.9, 0.3), aluminium(), false),
        grooves(ggx_xy(0.3, 0.9), aluminium()),
        grooves(beckmann_xy(0.9, 0.3), methanol()),
        grooves(ashikhmin_shirley(5.0, 40.0), aluminium()),
    ];
    let others = [Sampling::Bxdf, Sampling::Normals, Sampling::Cosine, Sampling::Uniform];
    let directions = [0.1, 0.5, 0.95];
    let level = sidak(lobes.len() * others.len() * directions.len());
    let normal = Normal::standard();
    for (index, lobe) in lobes.iter().enumerate() {
        for (direction, mu) in directions.into_iter().enumerate() {
            let wo = Polar::from_cos(mu).direction(0.7);
            let mean = |sampling: Sampling, seed: u64| {
                let mut moments = Moments::default();
                let mut random = stream(seed + direction as u64, index as u64);
                for _ in 0..DRAWS {
                    moments.push(lobe.sample(sampling, wo, random.uniform3()).weight);
                }
                (moments.mean().x, moments.variance().x / DRAWS as f64)
            };
            let (visible, variance) = mean(Sampling::Visible, 110);
            for (k, sampling) in others.into_iter().enumerate() {
                let (other, other_variance) = mean(sampling, 120 + 10 * k as u64);
                let z = (other - visible) / (variance + other_variance).sqrt();
                let p = 2.0 * normal.sf(z.abs());
                assert!(
                    p > level,
                    "{lobe:?} {sampling:?} from {mu}: {other} and {visible}, p = {p:e}"
                );
            }
        }
    }
}
