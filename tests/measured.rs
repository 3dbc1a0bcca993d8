//! Measured data as others published it. The files of a folder beside the project are read where there is one; a few records
//! of them are in `tests/data`.

mod skip;

use glam::DVec3;
use skip::skip;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use whitefurnace::bxdf::{Bxdf, Irregular, Sampling};
use whitefurnace::fresnel::Fresnel;
use whitefurnace::geometry::Polar;
use whitefurnace::measured::MeasuredError;
use whitefurnace::measured::index::{ConductorIndex, NAMES, read_spd};
use whitefurnace::measured::irregular::IrregularSamples;
use whitefurnace::numerics::stream::{Stream, StreamId};
use whitefurnace::spectrum::Channels;

const FEW: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/acryl-blue-30.brdf");
const GOLD: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/Au__nk__Johnson.yml");

/// The folder of published files; `None`, and a note, where there is none.
fn published(folder: &str) -> Option<PathBuf> {
    let path = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../shared/data")).join(folder);
    if path.is_dir() {
        return Some(path);
    }
    skip(format!("{} is not there", path.display()));
    None
}

fn directions(count: u64) -> Vec<[DVec3; 2]> {
    let mut stream = Stream::new(StreamId {
        seed: 4,
        cell: 2,
        batch: 0,
    });
    let mut draw = || {
        let [mu, phi, _] = stream.uniform3();
        Polar::from_cos(mu).direction(std::f64::consts::TAU * phi)
    };
    (0..count).map(|_| [draw(), draw()]).collect()
}

fn mean_and_variance(bxdf: &Irregular, sampling: Sampling, mu: f64) -> (DVec3, DVec3) {
    let mut stream = Stream::new(StreamId {
        seed: 1,
        cell: mu.to_bits(),
        batch: 0,
    });
    let wo = Polar::from_cos(mu).direction(0.3);
    let n = 50_000;
    let weights: Vec<DVec3> = (0..n)
        .map(|_| bxdf.sample(sampling, wo, stream.uniform3()).weight)
        .collect();
    let mean = weights.iter().sum::<DVec3>() / f64::from(n);
    let squares: DVec3 = weights.iter().map(|w| (*w - mean) * (*w - mean)).sum();
    (mean, squares / f64::from(n - 1))
}

#[test]
fn a_few_records_make_a_brdf() {
    let samples = IrregularSamples::read(Path::new(FEW)).unwrap();
    assert_eq!((samples.len(), samples.channels()), (30, Channels::Rgb));
    assert_eq!((samples.path(), samples.sha256().len()), (FEW, 64));
    let bxdf = Irregular::new(Arc::new(samples));
    assert_eq!(bxdf, bxdf.clone());
    for [wo, wi] in directions(200) {
        let f = bxdf.f(wo, wi);
        assert!(f.is_finite() && f.min_element() >= 0.0);
        assert_eq!(f, bxdf.f(wi, wo));
    }
}

/// What the published files hold, and what is strange about them: saturated colours have channels below 0, which a lookup
/// raises to 0, and the one peak of mystique at 80 degrees reflects more than it receives.
#[test]
fn published_brdfs_are_read() {
    let Some(folder) = published("measured") else { return };
    for (name, sampled) in [("acryl_blue", [782, 1352, 0]), ("mystique", [77, 670, 17])] {
        let samples = IrregularSamples::read(&folder.join(format!("{name}.brdf"))).unwrap();
        assert_eq!((samples.len(), samples.negative()), (1439, sampled));
        let bxdf = Irregular::new(Arc::new(samples));
        for [wo, wi] in directions(2000) {
            let f = bxdf.f(wo, wi);
            assert!(f.is_finite() && f.min_element() >= 0.0);
            assert_eq!(f, bxdf.f(wi, wo));
        }
        for mu in [0.2, 0.5, 0.9] {
            let (mean, variance) = mean_and_variance(&bxdf, Sampling::Bxdf, mu);
            let (other, other_variance) = mean_and_variance(&bxdf, Sampling::Cosine, mu);
            let ratio = other_variance / variance;
            println!("{name} mu {mu}: rho {mean:.5}, variance {variance:.6}, of cosine sampling {ratio:.1} times that");
            // five standard errors, which fail once in a million
            let error = 5.0 * ((variance + other_variance) / 50_000.0).map(f64::sqrt);
            assert!((mean - other).abs().cmple(error).all(), "{name} {mu}: {mean} {other}");
            // near the normal both are small, and neither need win in every channel
            if mu < 0.6 {
                assert!((variance * 10.0).cmplt(other_variance).all());
            }
        }
        let (rho, _) = mean_and_variance(&bxdf, Sampling::Bxdf, 0.2);
        assert_eq!(rho.min_element() > 1.0, name == "mystique");
    }
}

/// Gold by Johnson and Christy against gold of pbrt, another sample: metals measured apart differ by a few percent of F, and
/// more in the blue, at the edge of the interband transitions.
#[test]
fn gold_is_gold_in_both_formats() {
    let reflectance = |index: ConductorIndex| {
        let fresnel = Fresnel::conductor(index.eta(), index.k()).unwrap();
        fresnel.reflectance(1.0)
    };
    let table = reflectance(ConductorIndex::read_yaml(Path::new(GOLD)).unwrap());
    let named = reflectance(ConductorIndex::named("Au").unwrap());
    println!("{table} {named}");
    assert!((table - named).abs().max_element() < 0.1, "{table} {named}");
    assert!(table.x > table.y && table.y > table.z);
}

#[test]
fn published_indices_are_read_or_refused_for_what_they_lack() {
    let Some(folder) = published("metals") else { return };
    for name in NAMES {
        let file = |kind: &str| folder.join(format!("{name}.{kind}.spd"));
        let index = ConductorIndex::read_spd(&file("eta"), &file("k")).unwrap();
        assert_eq!(Some(index), ConductorIndex::named(name));
    }
    ConductorIndex::read_yaml(&folder.join("Al__nk__Rakic.yml")).unwrap();
    for (glass, lacking) in [("SiO2__nk__Malitson.yml", "n"), ("schott__optical__N-BK7.yml", "n")] {
        let text = ConductorIndex::read_yaml(&folder.join(glass)).unwrap_err().to_string();
        let reason = format!("a table of {lacking} is missing: a conductor needs n and k tabulated, and a formula");
        assert!(text.contains(glass) && text.contains(&reason), "{text}");
    }
}

/// Truncations, flipped bits, and files of another kind: an answer or an error that names the file.
#[test]
fn damaged_files_are_refused() {
    let brdf = std::fs::read(FEW).unwrap();
    let yaml = std::fs::read(GOLD).unwrap();
    let check = |bytes: &[u8]| {
        if let Ok(samples) = IrregularSamples::parse("x", bytes) {
            assert!(directions(3).iter().all(|[wo, wi]| samples.f(*wo, *wi).is_finite()));
        }
        for error in [
            IrregularSamples::parse("x", bytes).err(),
            ConductorIndex::parse_yaml("x", bytes).err(),
        ] {
            assert!(error.is_none_or(|e| e.to_string().starts_with("x: ")));
        }
    };
    for bytes in [&brdf, &yaml] {
        for end in (0..bytes.len()).step_by(37) {
            check(&bytes[..end]);
        }
        for bit in (0..bytes.len() * 8).step_by(101) {
            let mut damaged = bytes.clone();
            damaged[bit / 8] ^= 1 << (bit % 8);
            check(&damaged);
        }
        for token in ["nan", "inf", "-inf", "1e999", "18446744073709551616", "\u{0}"] {
            let text = String::from_utf8_lossy(bytes).replace("0.4", token);
            check(text.as_bytes());
        }
    }
    let missing = Path::new("none/such.brdf");
    assert!(matches!(
        IrregularSamples::read(missing),
        Err(MeasuredError::Unreadable { .. })
    ));
    assert!(matches!(read_spd(missing), Err(MeasuredError::Unreadable { .. })));
}
