//! Small tables for the tests of this stage and the next, awkward on purpose: values that f32 cannot hold, names beyond
//! ASCII, integers beyond 2^53.

use super::axis::{Axis, Mapping, TexelRule};
use super::{Between, ErrorKind, Goal, Lobe, Quantity, Table};
use crate::spectrum::Channels;
use glam::DVec3;

/// One grey number, nothing measured between texels, nothing listed.
pub(crate) fn scalar() -> Table {
    Table {
        id: "methanol-hh".into(),
        quantity: Quantity::RhoHh,
        lobe: Lobe::Transmission,
        axes: vec![],
        channels: Channels::Grey,
        values: vec![DVec3::splat(1.0 / 3.0)],
        errors: vec![DVec3::splat(2.5e-7)],
        error_kind: ErrorKind::Ci99,
        parameters: vec![],
        estimator: "qmc-visible".into(),
        tolerance: 1e-6,
        evaluations: u64::MAX,
        seed: (1 << 53) + 1,
        goal: None,
        between: None,
    }
}

/// Eight linear RGB texels over mu.
pub(crate) fn rgb_1d() -> Table {
    let value = |i: usize| DVec3::new(0.1, 0.3, 0.7) * (1.0 + i as f64 * 0.01);
    Table {
        id: "gold".into(),
        quantity: Quantity::RhoHd,
        lobe: Lobe::Reflection,
        axes: vec![Axis::mu(8).unwrap()],
        channels: Channels::Rgb,
        values: (0..8).map(value).collect(),
        errors: (0..8).map(|i| DVec3::new(1e-6, 0.0, 3e-9) * i as f64).collect(),
        error_kind: ErrorKind::Bound,
        parameters: vec![("kappa".into(), "17.0".into()), ("formula".into(), "a = b\n= c".into())],
        estimator: "quadrature".into(),
        tolerance: 0.1 + 0.2,
        evaluations: 12345,
        seed: 0,
        goal: Some(Goal {
            tolerance: 1e-3 / 3.0,
            unmet: Some("mehr \"Größe\"\nals erlaubt".into()),
        }),
        between: Some(Between {
            error: 1.0 / 7.0,
            at: vec![1e-9 / 3.0],
            probes: 4096,
        }),
    }
}

/// Grey, 8 texels over mu times 4 over a logarithmic roughness.
pub(crate) fn grey_2d() -> Table {
    let value = |i: usize| DVec3::splat(0.9 - 0.01 * i as f64);
    Table {
        id: "vmf.rho_hd".into(),
        axes: vec![
            Axis::new("mu", Mapping::SqrtMu, TexelRule::Centres, [0.0, 1.0], 8).unwrap(),
            Axis::new("kappa", Mapping::Log1p, TexelRule::Ends, [0.1, 1e12], 4).unwrap(),
        ],
        channels: Channels::Grey,
        values: (0..32).map(value).collect(),
        errors: vec![DVec3::splat(1e-5); 32],
        error_kind: ErrorKind::Exact,
        goal: Some(Goal {
            tolerance: 0.5,
            unmet: None,
        }),
        between: Some(Between {
            error: 0.0,
            at: vec![0.5, 17.0],
            probes: 1,
        }),
        ..rgb_1d()
    }
}
