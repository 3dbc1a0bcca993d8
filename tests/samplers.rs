//! Samplers follow their densities, and densities add up to one.

mod common;

use common::cases::{beckmann, grooves, methanol, phong, vmf};
use common::rules::{both_ends, composite, octaves};
use common::statistics::{counts_p, sidak};
use glam::DVec3;
use rayon::prelude::*;
use std::f64::consts::{FRAC_PI_2, PI, TAU};
use whitefurnace::bxdf::{Bxdf, Coupling, DiffuseSpecular, Model};
use whitefurnace::distribution::{Distribution, Isotropic};
use whitefurnace::geometry::Polar;
use whitefurnace::integrate::coupled_bxdf;
use whitefurnace::masking::{sample_visible_groove, visible_groove_pdf};
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
