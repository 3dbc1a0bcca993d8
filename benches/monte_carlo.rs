//! What a sample costs: every sampling of several models, for every kind of points, on one thread and on two.

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use std::hint::black_box;
use std::time::Duration;
use whitefurnace::bxdf::{Bxdf, Microfacet, Sampling};
use whitefurnace::distribution::Family;
use whitefurnace::estimate::{Estimator, Points};
use whitefurnace::fresnel::Fresnel;
use whitefurnace::integrate::Lobe;
use whitefurnace::integrate::monte_carlo::{Outgoing, Samples, Trial, estimate, outgoing};
use whitefurnace::masking::Masking;
use whitefurnace::spectrum::Spectrum;

const COUNT: u64 = 1 << 20;

fn models() -> [(&'static str, Microfacet); 5] {
    let dielectric = Fresnel::dielectric(Spectrum::grey(1.329)).unwrap();
    let lobe = |family: Family, size, masking, fresnel| {
        Microfacet::new(Spectrum::grey(1.0), family.with(size).unwrap(), masking, fresnel).unwrap()
    };
    let correlated = Masking::SmithCorrelated;
    [
        ("ggx", lobe(Family::Ggx, 0.3, correlated, Fresnel::None)),
        ("ggx dielectric", lobe(Family::Ggx, 0.3, correlated, dielectric)),
        (
            "beckmann v-groove",
            lobe(Family::Beckmann, 0.3, Masking::VGroove, Fresnel::None),
        ),
        ("beckmann smith", lobe(Family::Beckmann, 0.3, correlated, Fresnel::None)),
        ("vmf v-groove", lobe(Family::Vmf, 17.0, Masking::VGroove, Fresnel::None)),
    ]
}

/// The throughput is samples per second.
fn samples(criterion: &mut Criterion) {
    for threads in [1, 2] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let mut group = criterion.benchmark_group(format!("samples, {threads} thread(s)"));
        group.throughput(Throughput::Elements(COUNT));
        for (name, bxdf) in models() {
            for points in Points::ALL {
                for sampling in Sampling::ALL {
                    assert!(bxdf.supports(sampling));
                    for (quantity, outgoing) in [("rho_hd", outgoing(0.5, 0.0)), ("rho_hh", Outgoing::Cosine)] {
                        let trial = Trial {
                            sampling,
                            points,
                            lobe: Lobe::Reflection,
                            outgoing,
                            samples: Samples::Fixed(COUNT),
                            seed: 0,
                            cell: 0,
                        };
                        let estimator = Estimator::MonteCarlo { sampling, points };
                        group.bench_function(format!("{name}, {quantity}, {estimator}"), |bencher| {
                            let run = || pool.install(|| estimate(&bxdf, trial).unwrap());
                            bencher.iter(|| black_box(run()));
                        });
                    }
                }
            }
        }
        group.finish();
    }
}

criterion_group! {
    name = benches;
    config = Criterion::default()
        .sample_size(10)
        .warm_up_time(Duration::from_millis(50))
        .measurement_time(Duration::from_millis(300));
    targets = samples
}
criterion_main!(benches);
