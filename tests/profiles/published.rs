//! Tables that engines ship, beside ours.

use crate::engines::total;
use crate::gpu::Raw;
use crate::metric::{self, Error};
use crate::shared::{Baked, baked, generic_16, tables};
use half::f16;
use std::fs;
use std::path::Path;
use whitefurnace::engine::Profile;

/// A published table: two half floats a texel, in the layout of a profile.
fn published(file: &str, side: usize) -> Raw {
    let path = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("tests/data/engines")
        .join(file);
    let bytes = fs::read(path).unwrap();
    assert_eq!(bytes.len(), side * side * 4);
    let number = |pair: &[u8]| f16::from_le_bytes([pair[0], pair[1]]).to_f64();
    Raw {
        size: [side, side, 1],
        channels: 2,
        values: bytes.chunks_exact(2).map(number).collect(),
    }
}

fn ours(profile: Profile, baked: &Baked) -> (usize, Error) {
    let tables = tables(baked);
    let error = metric::error(|mu, r| total(profile, &tables, mu, r));
    (baked[0].1.bytes(), error)
}

fn theirs(profile: Profile, name: &'static str, raw: Raw) -> (usize, Error) {
    let bytes = raw.values.len() * 2;
    let tables = [(name, raw)].into();
    (bytes, metric::error(|mu, r| total(profile, &tables, mu, r)))
}

#[test]
fn ours_are_better_at_the_same_bytes() {
    let three = theirs(Profile::Three, "dfgLUT", published("three-dfg.bin", 16));
    let bevy = theirs(Profile::Bevy, "dfg", published("bevy-dfg.bin", 64));
    let our_three = ours(Profile::Three, baked(Profile::Three));
    let our_bevy = ours(Profile::Bevy, baked(Profile::Bevy));
    let small = ours(Profile::Generic, generic_16());
    let large = ours(Profile::Generic, baked(Profile::Generic));
    let rows = [
        ("three.js 0.187.0", "16 x 16", three),
        ("`--profile three`", "16 x 16", our_three),
        ("`--profile generic`", "16 x 16", small),
        ("Bevy 0.20.1", "64 x 64", bevy),
        ("`--profile bevy`", "64 x 64", our_bevy),
        ("`--profile generic`", "32 x 32", large),
    ];
    let mut table = String::from("| table | texels | bytes | mean | largest |\n| --- | --- | ---: | ---: | ---: |\n");
    for (name, texels, (bytes, Error { mean, max })) in rows {
        table += &format!(
            "| {name} | {texels} | {bytes} | {:.4} % | {:.2} % |\n",
            100.0 * mean,
            100.0 * max
        );
    }
    eprintln!("{table}");
    // the files are what they are taken for: a swap of rows and columns would leave tens of per cent
    assert!(
        (three.1.mean - 0.0027).abs() < 3e-4 && (three.1.max - 0.111).abs() < 5e-3,
        "{three:?}"
    );
    assert!(
        (bevy.1.mean - 0.00029).abs() < 3e-5 && (bevy.1.max - 0.0296).abs() < 3e-3,
        "{bevy:?}"
    );
    for (ours, theirs) in [(our_three, three), (our_bevy, bevy), (small, three), (large, bevy)] {
        assert!(ours.0 <= theirs.0, "{ours:?} {theirs:?}");
        assert!(
            ours.1.mean < theirs.1.mean && ours.1.max < theirs.1.max,
            "{ours:?} {theirs:?}"
        );
    }
}
