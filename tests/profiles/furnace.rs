//! The white furnace with what two compensations make of the generic pair.

use crate::engines::{albedo, total};
use crate::gpu::Raw;
use crate::shared::{Baked, baked, generic_16, places, stated, tables, within};
use crate::truth;
use whitefurnace::engine::Profile;

/// The lobe times 1 + F0 (1/E - 1), as Turquin has it: of F0 = 1 the furnace is E_true/E, off by what the table states. Of less F0 it
/// returns more than a single reflection and less than 1.
#[test]
fn scaled_lobes_keep_the_furnace() {
    for baked in [generic_16(), baked(Profile::Generic)] {
        let tables = tables(baked);
        let bound = stated(baked, "pair", "furnace").max + 5e-8; // and what the integral of this test is off by
        for parts in places::<2>(1000, 11) {
            let (mu, r) = (within(0.01, parts[0]), within(0.05, parts[1]));
            let e = total(Profile::Generic, &tables, mu, r);
            let factor = |f0: f64| 1.0 + f0 * (1.0 / e - 1.0);
            let furnace = truth::metal(mu, r * r) * factor(1.0);
            assert!((furnace - 1.0).abs() <= bound, "{mu} {r}: {furnace}");
            let single = albedo(Profile::Generic, &tables, mu, r, 0.5);
            let coloured = single * factor(0.5);
            assert!(coloured > single && coloured < 1.0, "{mu} {r}: {single} {coloured}");
        }
    }
}

/// The lobe of Kulla and Conty beside the single scattering,
/// (1 - E(i)) (1 - E(o))/(pi (1 - E_avg)), E of the pair as a shader reads it and 1 - E_avg of its mean.
///
/// With q = 2 int (1 - E) mu dmu/(1 - E_avg) the furnace is E_true + (1 - E) q, and
///
/// furnace - 1 = (E_true - E) + (1 - E) (q - 1).
///
/// |E_true - E| is at most e E, e the stated error of E_true/E. The mean is that of the very lookup: along r both are linear between the
/// same texels, and q is 1 but for the rounding of the mean to f32, 2^-24, and the midpoints of this test, below 1e-4 of 1 - E_avg.
/// The bound is e E + 1e-4 (1 - E).
#[test]
fn reciprocal_lobes_keep_the_furnace() {
    for baked in [generic_16(), baked(Profile::Generic)] {
        reciprocal(baked);
    }
}

fn reciprocal(baked: &Baked) {
    let tables = tables(baked);
    let error = stated(baked, "pair", "furnace").max;
    let mean: &Raw = &tables["pair_mean"];
    let loss = |mu: f64, r: f64| 1.0 - total(Profile::Generic, &tables, mu, r);
    let mut largest: f64 = 0.0;
    for parts in places::<2>(60, 12) {
        let r = within(0.05, parts[1]);
        // midpoints in sqrt mu, along which the loss is linear between texels: 2 mu dmu = 4 u^3 du
        let count = 4000;
        let lost: f64 = (0..count)
            .map(|i| {
                let u = (f64::from(i) + 0.5) / f64::from(count);
                4.0 * u * u * u * loss(u * u, r) / f64::from(count)
            })
            .sum();
        let n = mean.size[0] as f64;
        let mean_loss = mean.fetch([(r * r.sqrt()).sqrt() * (n - 1.0) / n + 0.5 / n], 0);
        let q = lost / mean_loss;
        assert!((q - 1.0).abs() < 1e-4, "{r}: {q}");
        for mu in [0.01, within(0.01, parts[0]), 0.2, 1.0] {
            let e = 1.0 - loss(mu, r);
            let furnace = truth::metal(mu, r * r) + (1.0 - e) * q;
            let bound = error * e + 1e-4 * (1.0 - e) + 1e-8;
            assert!((furnace - 1.0).abs() <= bound, "{mu} {r}: {furnace}, {bound}");
            largest = largest.max((furnace - 1.0).abs() / bound);
        }
    }
    assert!(largest > 0.05, "the bound is far: {largest}");
}
