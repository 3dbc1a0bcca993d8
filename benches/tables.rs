//! What tables of rho_hd over mu and roughness cost: 64 x 64 texels, computed one after the other by one thread.

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use std::hint::black_box;
use std::time::Duration;
use whitefurnace::bxdf::{Microfacet, Model};
use whitefurnace::distribution::Family;
use whitefurnace::fresnel::Fresnel;
use whitefurnace::integrate::Target;
use whitefurnace::integrate::deterministic::quadrature;
use whitefurnace::masking::Masking;
use whitefurnace::spectrum::Spectrum;

const SIZE: u32 = 64;
const TOLERANCES: [f64; 3] = [1e-4, 1e-6, 1e-9];

/// A row of lobes, from the first to the last roughness.
struct Lobes {
    name: &'static str,
    family: Family,
    masking: Masking,
    /// The parameter of the family at a place in [0, 1].
    roughness: fn(f64) -> f64,
}

/// Perceptual roughness r, alpha = r^2.
fn perceptual(r: f64) -> f64 {
    r * r
}

/// The same widths for the other families: kappa = 2/alpha^2, n = 2/alpha^2 - 2.
const LOBES: [Lobes; 5] = [
    Lobes {
        name: "ggx, smith-correlated",
        family: Family::Ggx,
        masking: Masking::SmithCorrelated,
        roughness: perceptual,
    },
    Lobes {
        name: "beckmann, smith-correlated",
        family: Family::Beckmann,
        masking: Masking::SmithCorrelated,
        roughness: perceptual,
    },
    Lobes {
        name: "vmf, v-groove",
        family: Family::Vmf,
        masking: Masking::VGroove,
        roughness: |r| 2.0 / r.powi(4),
    },
    Lobes {
        name: "beckmann, v-groove",
        family: Family::Beckmann,
        masking: Masking::VGroove,
        roughness: perceptual,
    },
    Lobes {
        name: "phong, v-groove",
        family: Family::Phong,
        masking: Masking::VGroove,
        roughness: |r| (2.0 / r.powi(4) - 2.0).min(1e8),
    },
];

/// Centre of a texel.
fn centre(i: u32) -> f64 {
    (f64::from(i) + 0.5) / f64::from(SIZE)
}

fn models(lobes: &Lobes) -> Vec<Model> {
    let model = |i| {
        let distribution = lobes.family.with((lobes.roughness)(centre(i))).unwrap();
        let lobe = Microfacet::new(Spectrum::grey(1.0), distribution, lobes.masking, Fresnel::None);
        Model::Microfacet(lobe.unwrap())
    };
    (0..SIZE).map(model).collect()
}

/// Sum of the values, most evaluations of a texel and their sum.
fn table(models: &[Model], tolerance: f64) -> (f64, u64, u64) {
    let mut total = (0.0, 0, 0);
    for model in models {
        for i in 0..SIZE {
            let texel = quadrature(model, Target::rho_hd(centre(i), 0.0), tolerance).unwrap();
            total.0 += texel.value.x;
            total.1 = texel.evaluations.max(total.1);
            total.2 += texel.evaluations;
        }
    }
    total
}

fn tables(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("64 x 64 table");
    group.throughput(Throughput::Elements(u64::from(SIZE * SIZE)));
    for lobes in &LOBES {
        let models = models(lobes);
        for tolerance in TOLERANCES {
            let (_, most, all) = table(&models, tolerance);
            let mean = all / u64::from(SIZE * SIZE);
            let id = format!(
                "{}, {tolerance:e}, {mean} evaluations a texel, at most {most}",
                lobes.name
            );
            group.bench_function(id, |bencher| bencher.iter(|| black_box(table(&models, tolerance))));
        }
    }
    group.finish();
}

/// Ten tables or more for each number.
fn quick() -> Criterion {
    Criterion::default()
        .sample_size(10)
        .warm_up_time(Duration::from_millis(300))
        .measurement_time(Duration::from_secs(1))
}

criterion_group! {
    name = benches;
    config = quick();
    targets = tables
}
criterion_main!(benches);
