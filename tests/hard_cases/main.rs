//! Regimes in which straightforward formulae fail: each shown to fail, and what the library has in its place compared with
//! true values.
//!
//! A straightforward formula stands here as its source prints it. True values are the same formulae, or others where those
//! are 0/0, in arithmetic of 1200 bits on the very f64 that the library is given, unless a test says otherwise. What is
//! allowed is some roundings, EPSILON = 2.2e-16 or two of them each, times the condition of the result: that of e^-E is E,
//! since E is known to a few roundings and no better.
//!
//! The table in the README is made of these numbers: [`the_readme_has_this_table`] says so when they differ, and prints it.

mod albedos;
mod big;
mod directions;
mod horizon;
mod interfaces;
mod metals;
mod narrow;
mod row;
mod spheres;

#[path = "../common/mod.rs"]
mod common;

use row::{Row, table};

/// In the order of the table.
fn rows() -> Vec<Row> {
    let rows = [
        spheres::rows(),
        narrow::rows(),
        directions::rows(),
        interfaces::rows(),
        metals::rows(),
        horizon::rows(),
        albedos::rows(),
    ];
    rows.into_iter().flatten().collect()
}

#[test]
fn the_readme_has_this_table() {
    let table = table(&rows());
    let readme = std::fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/README.md")).unwrap();
    assert!(
        readme.contains(&table),
        "the table of hard cases in README.md should be\n\n{table}"
    );
}
