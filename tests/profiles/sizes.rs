//! What the generic pair keeps at 1 KB and at 4 KB.

use crate::engines::total;
use crate::metric;
use crate::shared::{Baked, baked, generic_16, stated, tables};
use whitefurnace::engine::Profile;

fn keeps(baked: &Baked, bytes: usize, [mean, max]: [f64; 2]) {
    assert_eq!(baked[0].1.bytes(), bytes);
    let stated = stated(baked, "pair", "furnace");
    let tables = tables(baked);
    let found = metric::error(|mu, r| total(Profile::Generic, &tables, mu, r));
    eprintln!(
        "{bytes} bytes: found {found:?}, stated {:.3e} {:.3e}",
        stated.mean, stated.max
    );
    assert!(
        found.max <= stated.max && stated.max <= max,
        "{found:?}, stated {}",
        stated.max
    );
    // two grids of different places: their means agree as far as sums over some 50 places a texel do
    assert!(
        (found.mean / stated.mean - 1.0).abs() < 0.1,
        "{found:?}, stated {}",
        stated.mean
    );
    assert!(
        found.mean <= mean && stated.mean <= mean,
        "{found:?}, stated {}",
        stated.mean
    );
}

#[test]
fn one_kilobyte_is_off_by_a_twentieth_per_cent_and_two_at_worst() {
    keeps(generic_16(), 1024, [5e-4, 2e-2]);
}

#[test]
fn four_kilobytes_are_off_by_a_hundredth_per_cent_and_half_a_per_cent_at_worst() {
    keeps(baked(Profile::Generic), 4096, [1e-4, 5e-3]);
}
