//! The parsers, what each may cost, and what has to be true of the things that they take.

use crate::scenes::{glb, gltf, pbrt, scene};
use crate::{seeds, textures};
use glam::DVec3;
use std::f64::consts::TAU;
use std::io::Read;
use std::path::Path;
use whitefurnace::export::exr::to_bytes;
use whitefurnace::export::manifest::Manifest;
use whitefurnace::export::read::{Contents, ForeignLayer, parse_exr};
use whitefurnace::geometry::Polar;
use whitefurnace::measured::index::{ConductorIndex, parse_spd};
use whitefurnace::measured::irregular::{IrregularSamples, LARGEST_F};
use whitefurnace::measured::merl::{FILE_BYTES, LARGEST, MerlTable};
use whitefurnace::parameter::{ETA, EXTINCTION};

/// A parser on trial.
pub(crate) struct Target {
    /// The directory of its corpus.
    pub(crate) name: &'static str,
    /// Good files.
    pub(crate) seeds: fn() -> Vec<Vec<u8>>,
    /// Words of its language.
    pub(crate) dictionary: &'static [&'static str],
    /// Most memory for an input: bytes in any case, and for every byte of it.
    pub(crate) memory: [usize; 2],
    /// Parses and looks at what comes out: a few words on it, or the message of the refusal. Panics where a rule is broken.
    pub(crate) parse: fn(&[u8]) -> Result<String, String>,
}

pub(crate) const TARGETS: [Target; 11] = [
    Target {
        name: "scene",
        seeds: seeds::scenes,
        dictionary: &seeds::SCENE_WORDS,
        // a dotted key builds a table of 1.2 kB for each two bytes; the measured files of the seeds are small
        memory: [8 << 20, 1200],
        parse: scene,
    },
    Target {
        name: "gltf",
        seeds: seeds::gltf,
        dictionary: &seeds::GLTF_WORDS,
        // a material of three bytes, `{},`, comes to 2.2 kB with what calls for it and its place in a plan
        memory: [4 << 20, 1200],
        parse: gltf,
    },
    Target {
        name: "glb",
        seeds: seeds::glb,
        dictionary: &seeds::GLTF_WORDS,
        // as text
        memory: [4 << 20, 1200],
        parse: glb,
    },
    Target {
        name: "pbrt",
        seeds: seeds::pbrt,
        dictionary: &seeds::PBRT_WORDS,
        // of `Material"uber"Shape""` each comes to some 2 kB; a mixture may repeat 64 gaps in a statement of 80 bytes
        memory: [4 << 20, 400],
        parse: pbrt,
    },
    Target {
        name: "merl",
        seeds: seeds::merl,
        dictionary: &[],
        // the cells, 35 MB
        memory: [36 << 20, 16],
        parse: merl,
    },
    Target {
        name: "irregular",
        seeds: seeds::irregular,
        dictionary: &seeds::NUMBER_WORDS,
        memory: [1 << 20, 100],
        parse: irregular,
    },
    Target {
        name: "yaml",
        seeds: seeds::yaml,
        dictionary: &seeds::YAML_WORDS,
        memory: [1 << 20, 400],
        parse: yaml,
    },
    Target {
        name: "spd",
        seeds: seeds::spd,
        dictionary: &seeds::NUMBER_WORDS,
        memory: [1 << 20, 400],
        parse: spd,
    },
    Target {
        name: "exr",
        seeds: seeds::exr,
        dictionary: &seeds::EXR_WORDS,
        // samples take 1100 times the file at most, see MAX_COMPRESSION in the reader; a table of ours is held several times over
        memory: [8 << 20, 5 * 1100],
        parse: exr,
    },
    Target {
        name: "texture",
        seeds: textures::seeds,
        dictionary: &textures::WORDS,
        // pixels of a PNG take 1100 times the file at most, as samples of OpenEXR, and are held once
        memory: [4 << 20, 1200],
        parse: textures::parse,
    },
    Target {
        name: "manifest",
        seeds: seeds::manifests,
        dictionary: &seeds::JSON_WORDS,
        memory: [1 << 20, 100],
        parse: manifest,
    },
];

pub(crate) fn text(bytes: &[u8]) -> Result<&str, String> {
    std::str::from_utf8(bytes).map_err(|_| "no UTF-8".into())
}

/// Directions of all kinds: along the normal, grazing, nearly below, on either side of the plane.
pub(crate) fn directions() -> [DVec3; 5] {
    [(1.0, 0.0), (0.7, 0.1), (0.3, 0.6), (1e-3, 0.9), (1e-12, 0.5)]
        .map(|(mu, turns)| Polar::from_cos(mu).direction(TAU * turns))
}

/// A short input stands for a long file: its bytes after the header are repeated to the right size, unless it is odd.
fn merl(bytes: &[u8]) -> Result<String, String> {
    let (header, cells) = bytes.split_at(bytes.len().min(12));
    let repeated = bytes.len().is_multiple_of(2) && !cells.is_empty();
    let table = if repeated {
        let body: Vec<u8> = cells.repeat((1 << 14) / cells.len() + 1);
        let rest = Repeated { body: &body, at: 0 };
        MerlTable::read_from(header.chain(rest).take(FILE_BYTES), "fuzz")
    } else {
        MerlTable::read_from(bytes, "fuzz")
    };
    let table = table.map_err(|error| error.to_string())?;
    let well = |f: &f64| (0.0..=LARGEST).contains(f);
    assert!(table.cells().iter().flatten().all(well));
    Ok(format!("{:?} {}", table.channels(), table.invalid() == 0))
}

/// The same bytes again and again.
struct Repeated<'a> {
    body: &'a [u8],
    at: usize,
}

impl Read for Repeated<'_> {
    fn read(&mut self, buffer: &mut [u8]) -> std::io::Result<usize> {
        let count = buffer.len().min(self.body.len() - self.at);
        buffer[..count].copy_from_slice(&self.body[self.at..self.at + count]);
        self.at = (self.at + count) % self.body.len();
        Ok(count)
    }
}

fn irregular(bytes: &[u8]) -> Result<String, String> {
    let samples = IrregularSamples::parse("fuzz", bytes).map_err(|error| error.to_string())?;
    assert!(samples.len() > 0, "a file without records is refused");
    for (wo, wi) in directions().iter().flat_map(|wo| directions().map(|wi| (*wo, wi))) {
        let f = samples.f(wo, wi);
        // the matrix to RGB has entries up to some ten
        assert!(
            f.is_finite() && f.min_element() >= 0.0 && f.max_element() <= 1e3 * LARGEST_F,
            "{f}"
        );
    }
    Ok(format!("{:?} {}", samples.channels(), samples.len().ilog2()))
}

fn yaml(bytes: &[u8]) -> Result<String, String> {
    let index = ConductorIndex::parse_yaml("fuzz", bytes).map_err(|error| error.to_string())?;
    for (spectrum, legal) in [(index.eta(), ETA), (index.k(), EXTINCTION)] {
        for value in spectrum.value().to_array() {
            legal.check(value).unwrap();
        }
    }
    Ok(format!("{:?} {:?}", index.eta().channels(), index.k().channels()))
}

fn spd(bytes: &[u8]) -> Result<String, String> {
    let samples = parse_spd("fuzz", bytes).map_err(|error| error.to_string())?;
    let nm = samples.wavelengths_nm();
    assert!(!nm.is_empty() && nm.iter().all(|nm| nm.is_finite()) && nm.is_sorted());
    assert!(samples.to_rgb().iter().all(|channel| !channel.is_nan()));
    Ok(format!("{} samples", nm.len().ilog2()))
}

fn exr(bytes: &[u8]) -> Result<String, String> {
    let path = Path::new("fuzz.exr");
    let file = parse_exr(path, bytes).map_err(|error| error.to_string())?;
    assert_eq!(file.bytes, bytes.len() as u64);
    match file.contents {
        Contents::Table { table, .. } => {
            table.check().unwrap();
            let again = parse_exr(path, &to_bytes(&table).unwrap()).unwrap();
            let Contents::Table { table: again, .. } = again.contents else {
                panic!("a table is written as a table");
            };
            assert_eq!(*again, *table);
            Ok(format!("a table of {} axes", table.axes.len()))
        }
        Contents::Foreign(layers) => {
            layers.iter().for_each(foreign);
            Ok(layers.iter().map(|layer| layer.compression.as_str()).take(3).collect())
        }
    }
}

fn foreign(layer: &ForeignLayer) {
    let pixels = (layer.size[0] * layer.size[1]) as u64;
    for samples in layer.channels.iter().filter_map(|channel| channel.samples) {
        assert!(samples.not_finite <= pixels);
        let (min, max) = samples.range.unwrap_or_default();
        assert!(min <= max && min.is_finite() && max.is_finite(), "{samples:?}");
    }
}

fn manifest(bytes: &[u8]) -> Result<String, String> {
    let manifest = Manifest::from_json(text(bytes)?).map_err(|error| error.to_string())?;
    let again = Manifest::from_json(&manifest.to_json().unwrap()).unwrap();
    assert_eq!(again, manifest);
    Ok(format!("{} tables", manifest.tables.len()))
}
