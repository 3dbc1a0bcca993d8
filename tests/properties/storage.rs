//! What storing a value costs, over all that the formats hold and beyond.

use crate::strategies::log_uniform;
use crate::{check, ensure};
use glam::DVec3;
use proptest::prelude::*;
use proptest::sample::select;
use whitefurnace::estimate::ErrorKind;
use whitefurnace::table::Storage;

/// Values from the subnormal numbers of every format to beyond its largest, of both signs, and neighbours of its steps.
fn value() -> BoxedStrategy<f64> {
    let edges = [
        0.0,
        5e-324,
        f64::from(f32::MIN_POSITIVE),
        2f64.powi(-149),
        2f64.powi(-24),
        2f64.powi(-14),
        65504.0,
        65519.0,
        65520.0,
        65536.0,
        f64::from(f32::MAX),
        f64::MAX,
    ];
    let steps = (0..=65535u32, -1.0..1.0).prop_map(|(i, off)| (f64::from(i) + off) / 65535.0);
    let neighbour = (select(edges.to_vec()), -2..=2i32).prop_map(|(edge, ulps)| match ulps {
        -2 => edge.next_down().next_down(),
        -1 => edge.next_down(),
        1 => edge.next_up(),
        2 => edge.next_up().next_up(),
        _ => edge,
    });
    let size = prop_oneof![
        4 => 0.0..1.1,
        2 => log_uniform(-323.0, 0.0),
        2 => log_uniform(-12.0, 40.0),
        1 => steps,
        2 => neighbour,
    ];
    (size, prop::bool::weighted(0.1))
        .prop_map(|(size, below): (f64, bool)| if below { -size } else { size })
        .boxed()
}

/// Values that a format holds come back within the rounding that it states; others are told apart.
#[test]
fn rounding_is_bounded_and_overflow_is_told() {
    check(40_000, &value(), |value| {
        for storage in Storage::ALL {
            let (stored, rounding) = (storage.round(value), storage.rounding(value));
            if storage.holds(value) {
                ensure!(
                    (stored - value).abs() <= rounding,
                    "{storage:?} {value:e}: {stored:e} +- {rounding:e}"
                );
                ensure!(
                    storage.round(stored) == stored,
                    "{storage:?} {value:e}: {stored:e} is not stored as it is"
                );
            } else {
                // nothing is refused that could be kept within half a step
                ensure!(
                    !stored.is_finite() || (stored - value).abs() > rounding,
                    "{storage:?} {value:e}: refused, though {stored:e}"
                );
            }
            ensure!(
                storage != Storage::F16 || value.abs() < 65520.0 || !storage.holds(value),
                "{value:e} as f16"
            );
        }
        Ok(())
    });
}

/// The error of a texel covers its rounding to f32 with what was not known of it, and is an f32 itself.
#[test]
fn stored_errors_cover_what_storing_costs() {
    let error = prop_oneof![Just(0.0), log_uniform(-320.0, 0.0)];
    check(10_000, &(value(), error), |(value, error)| {
        if value.abs() > 1e38 {
            return Ok(()); // beyond f32: tables with it are refused, see below
        }
        let mut table = crate::tables::one_texel();
        table.values[0] = DVec3::splat(value);
        table.errors[0] = DVec3::splat(error);
        let (stored, stated) = (table.stored(0).x, table.texel_error(0).x);
        // in the order that loses nothing: the difference of neighbouring numbers is exact
        ensure!(
            (stored - value).abs() <= stated,
            "{value:e} +- {error:e}: {stored:e} +- {stated:e}"
        );
        ensure!(stated >= error, "{value:e} +- {error:e}: {stated:e}");
        ensure!(
            stated >= ((stored - value).abs() + error) * (1.0 - 1e-15),
            "{value:e} +- {error:e}: {stated:e}"
        );
        ensure!(f64::from(stated as f32) == stated, "{stated:e}");
        Ok(())
    });
}

/// What f32 does not hold does not become a table.
#[test]
fn values_beyond_f32_are_no_table() {
    for value in [1e39, f64::MAX, f64::INFINITY, f64::NAN] {
        let mut table = crate::tables::one_texel();
        table.error_kind = ErrorKind::Bound;
        table.values[0] = DVec3::splat(value);
        let refused = whitefurnace::export::exr::to_bytes(&table).is_err() || table.checked().is_err();
        assert!(refused, "{value:e}");
    }
}
