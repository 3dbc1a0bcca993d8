//! What a cell, a table and a whole bake cost.

use criterion::{BenchmarkId, Criterion, criterion_group, criterion_main};
use std::hint::black_box;
use std::time::Duration;
use whitefurnace::bxdf::{Microfacet, Model};
use whitefurnace::distribution::Family;
use whitefurnace::estimate::Estimator;
use whitefurnace::export::exr;
use whitefurnace::fresnel::Fresnel;
use whitefurnace::integrate::deterministic::quadrature;
use whitefurnace::integrate::{Target, fill};
use whitefurnace::masking::Masking;
use whitefurnace::plan::{Economy, Plan, Request, TablePlan};
use whitefurnace::scene::Scene;
use whitefurnace::spectrum::Spectrum;

const METHANOL: Spectrum = Spectrum::grey(1.329);

fn lobe(kappa: f64, fresnel: Fresnel) -> Microfacet {
    let distribution = Family::Vmf.with(kappa).unwrap();
    Microfacet::new(Spectrum::grey(1.0), distribution, Masking::VGroove, fresnel).unwrap()
}

fn fresnels() -> [(&'static str, Fresnel); 2] {
    [
        ("none", Fresnel::None),
        ("dielectric", Fresnel::dielectric(METHANOL).unwrap()),
    ]
}

/// rho_hd at one direction. The evaluations of a cell stand beside its name, so that the time of one can be read off.
fn cells(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("cell");
    for (name, fresnel) in fresnels() {
        for kappa in [17.0, 1e5] {
            let model = Model::Microfacet(lobe(kappa, fresnel));
            for (mu, tolerance) in [(0.5, 1e-6), (0.5, 1e-10), (1e-5, 1e-6)] {
                let cell = || quadrature(&model, Target::rho_hd(mu, 0.0), tolerance).unwrap();
                let evaluations = cell().evaluations;
                let id = format!("{name}, kappa {kappa}, mu {mu}, {tolerance:e}, {evaluations} evaluations");
                group.bench_function(id, |bencher| bencher.iter(|| black_box(cell())));
            }
        }
    }
    for alpha in [0.01, 0.25] {
        let distribution = Family::Charlie.with(alpha).unwrap();
        let sheen = Microfacet::new(Spectrum::grey(1.0), distribution, Masking::Neubelt, Fresnel::None).unwrap();
        let model = Model::Microfacet(sheen);
        for mu in [0.5, 1e-5] {
            let cell = || quadrature(&model, Target::rho_hd(mu, 0.0), 1e-6).unwrap();
            let evaluations = cell().evaluations;
            let id = format!("sheen, alpha {alpha}, mu {mu}, {evaluations} evaluations");
            group.bench_function(id, |bencher| bencher.iter(|| black_box(cell())));
        }
    }
    group.finish();
}

/// rho_hh of one material.
fn means(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("rho_hh");
    for (name, fresnel) in fresnels() {
        let model = Model::Microfacet(lobe(17.0, fresnel));
        group.bench_function(BenchmarkId::from_parameter(name), |bencher| {
            bencher.iter(|| black_box(quadrature(&model, Target::rho_hh(), 1e-6).unwrap()));
        });
    }
    group.finish();
}

fn default_plan() -> Plan {
    let request = Request {
        resolution: 64,
        roughness_resolution: 32,
        mapping: None,
        estimator: Estimator::Auto,
        azimuth_resolution: 16,
        tolerance: None,
        samples: None,
        seed: 0,
        economy: Economy::FULL,
    };
    Plan::new(&Scene::default_scene(), &request).unwrap()
}

fn bake(plan: &TablePlan) -> Vec<u8> {
    exr::to_bytes(&fill(plan, &|_| {}).unwrap()).unwrap()
}

/// Tables with the search for their lookup errors, on all cores.
fn tables(criterion: &mut Criterion) {
    let plan = default_plan();
    let mut group = criterion.benchmark_group("table");
    group.sample_size(10).measurement_time(Duration::from_secs(5));
    for id in ["methanol-k17.specular.rho_hd", "beckmann-m0.2.rho_hd"] {
        let table = plan.tables.iter().find(|table| table.id == id).unwrap();
        group.bench_function(id, |bencher| bencher.iter(|| black_box(bake(table))));
    }
    group.bench_function("the default scene", |bencher| {
        bencher.iter(|| plan.tables.iter().map(bake).collect::<Vec<_>>());
    });
    group.finish();
}

/// Half a second for each number: spreads of a few per cent, and a run of less than two minutes.
fn quick() -> Criterion {
    Criterion::default()
        .sample_size(20)
        .warm_up_time(Duration::from_millis(300))
        .measurement_time(Duration::from_secs(1))
}

criterion_group! {
    name = benches;
    config = quick();
    targets = cells, means, tables
}
criterion_main!(benches);
