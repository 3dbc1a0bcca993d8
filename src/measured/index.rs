//! Indices of refraction eta + ik of metals over wavelength, as red, green and blue.
//!
//! Metals come by name, as pairs of `.spd` files (lines of a wavelength in nm and a value), and as `.yml` files of
//! refractiveindex.info, whose tables have wavelengths in micrometres. eta and k become linear RGB like any spectrum, see
//! [`super::cie`]. The Fresnel reflectance of these channels is not quite the colour of the spectral reflectance, since F is
//! not linear in eta and k: for the metals below it differs by up to 0.05 at normal incidence, most in gold's red, whose
//! spectral colour, 1.02, no channel of a passive surface can have. [pbrt 2010, section 8.2]

use super::MeasuredError;
use super::cie::{SpectralError, SpectralSamples};
use super::file::{lines, number, read_whole, shown};
use crate::parameter::{ETA, EXTINCTION, Legal};
use crate::spectrum::Spectrum;
use saphyr_parser::{Event, Parser, ScalarStyle};
use std::path::Path;

/// Largest file, in bytes; the longest of refractiveindex.info have some 100 kB.
pub const LARGEST_FILE: u64 = 1 << 20;

/// A table has samples within, or around, these wavelengths in nm: beyond them hardly anything is seen, and a table that
/// stays outside says nothing about colour.
pub const VISIBLE_NM: [f64; 2] = [400.0, 700.0];

/// The metals that [`ConductorIndex::named`] knows.
pub const NAMES: [&str; 4] = ["Ag", "Al", "Au", "Cu"];

/// eta and k of a conductor per channel, each within its legal range.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ConductorIndex {
    eta: Spectrum,
    k: Spectrum,
}

impl ConductorIndex {
    /// Silver, aluminium, gold or copper by chemical symbol; `None` for any name outside [`NAMES`].
    pub fn named(name: &str) -> Option<Self> {
        macro_rules! metal {
            ($symbol:literal) => {
                [
                    include_bytes!(concat!("metals/", $symbol, ".eta.spd")).as_slice(),
                    include_bytes!(concat!("metals/", $symbol, ".k.spd")).as_slice(),
                ]
            };
        }
        let [eta, k] = match name {
            "Ag" => metal!("Ag"),
            "Al" => metal!("Al"),
            "Au" => metal!("Au"),
            "Cu" => metal!("Cu"),
            _ => return None,
        };
        let (eta, k) = (parse_spd(name, eta).ok()?, parse_spd(name, k).ok()?);
        Self::from_samples(name, &eta, name, &k).ok()
    }

    /// From a pair of `.spd` files; their wavelengths need not be the same.
    ///
    /// # Errors
    /// [`MeasuredError`] when either cannot be used, or a channel leaves the legal range of eta or k.
    pub fn read_spd(eta: &Path, k: &Path) -> Result<Self, MeasuredError> {
        let (eta_samples, k_samples) = (read_spd(eta)?, read_spd(k)?);
        Self::from_samples(
            &eta.display().to_string(),
            &eta_samples,
            &k.display().to_string(),
            &k_samples,
        )
    }

    /// From a file of refractiveindex.info that tabulates n and k.
    ///
    /// # Errors
    /// [`MeasuredError`] when it cannot be used, or a channel leaves the legal range of eta or k.
    pub fn read_yaml(path: &Path) -> Result<Self, MeasuredError> {
        Self::parse_yaml(&path.display().to_string(), &read_whole(path, LARGEST_FILE)?)
    }

    /// The same from the bytes of the file, which messages call `name`.
    ///
    /// # Errors
    /// As [`ConductorIndex::read_yaml`].
    pub fn parse_yaml(name: &str, bytes: &[u8]) -> Result<Self, MeasuredError> {
        let (eta, k) = tables(name, bytes)?;
        Self::from_samples(name, &eta, name, &k)
    }

    /// From samples; messages about them call the files `eta_name` and `k_name`.
    ///
    /// # Errors
    /// [`MeasuredError`] when either does not overlap [`VISIBLE_NM`], or a channel leaves the legal range of eta or k.
    pub fn from_samples(
        eta_name: &str,
        eta: &SpectralSamples,
        k_name: &str,
        k: &SpectralSamples,
    ) -> Result<Self, MeasuredError> {
        Ok(Self {
            eta: channels(eta_name, eta, ETA)?,
            k: channels(k_name, k, EXTINCTION)?,
        })
    }

    /// Index of refraction.
    pub fn eta(&self) -> Spectrum {
        self.eta
    }

    /// Extinction coefficient.
    pub fn k(&self) -> Spectrum {
        self.k
    }
}

fn refused(path: &str, place: impl Into<String>, what: impl Into<String>) -> MeasuredError {
    MeasuredError::Refused {
        path: path.into(),
        place: place.into(),
        what: what.into(),
    }
}

fn channels(path: &str, samples: &SpectralSamples, legal: Legal) -> Result<Spectrum, MeasuredError> {
    let nm = samples.wavelengths_nm();
    let (first, last) = (nm[0], nm[nm.len() - 1]);
    let [violet, red] = VISIBLE_NM;
    if last <= violet || first >= red {
        return Err(refused(
            path,
            format!("wavelengths of {}", legal.name),
            format!("{first} to {last} nm are not allowed: a table has to overlap {violet} to {red} nm"),
        ));
    }
    let rgb = samples.to_rgb();
    for (value, channel) in rgb.into_iter().zip(["red", "green", "blue"]) {
        if let Err(error) = legal.check(value) {
            let place = format!("{channel} channel of {}", legal.name);
            return Err(refused(path, place, error.to_string()));
        }
    }
    Ok(Spectrum::rgb(rgb))
}

/// Rows of a table as they are read: a wavelength and values that no physical index falls below.
struct Rows<'a> {
    path: &'a str,
    nm: Vec<f64>,
    places: Vec<String>,
}

impl<'a> Rows<'a> {
    fn new(path: &'a str) -> Self {
        Self {
            path,
            nm: Vec::new(),
            places: Vec::new(),
        }
    }

    /// The `N` numbers of a row, the first a wavelength in units of `unit` nm.
    fn read<'t, const N: usize>(
        &mut self,
        place: String,
        tokens: impl Iterator<Item = &'t [u8]>,
        names: [&str; N],
        unit: f64,
    ) -> Result<[f64; N], MeasuredError> {
        let tokens: Vec<&[u8]> = tokens.take(N + 1).collect();
        if tokens.len() != N {
            let count = if tokens.len() > N {
                "more".into()
            } else {
                tokens.len().to_string()
            };
            let what = format!("{count} numbers are not allowed: a row has {N}, {}", names.join(", "));
            return Err(refused(self.path, place, what));
        }
        let mut row = [0.0; N];
        for i in 0..N {
            row[i] = number(tokens[i], names[i]).map_err(|what| refused(self.path, &place, what))?;
            if row[i] < 0.0 {
                let what = format!("{} is not allowed: {} is at least 0", shown(tokens[i]), names[i]);
                return Err(refused(self.path, place, what));
            }
        }
        row[0] *= unit;
        self.nm.push(row[0]);
        self.places.push(place);
        Ok(row)
    }

    fn samples(&self, values: Vec<f64>) -> Result<SpectralSamples, MeasuredError> {
        SpectralSamples::new(self.nm.clone(), values).map_err(|SpectralError { sample, what }| {
            let place = sample.checked_sub(1).and_then(|i| self.places.get(i));
            refused(self.path, place.map_or("table", String::as_str), what)
        })
    }
}

/// Reads a `.spd` file: one quantity over wavelengths in nm.
///
/// # Errors
/// [`MeasuredError`] with the line, the value and what is allowed.
pub fn read_spd(path: &Path) -> Result<SpectralSamples, MeasuredError> {
    parse_spd(&path.display().to_string(), &read_whole(path, LARGEST_FILE)?)
}

/// The same from the bytes of the file, which messages call `name`.
///
/// # Errors
/// As [`read_spd`].
pub fn parse_spd(name: &str, bytes: &[u8]) -> Result<SpectralSamples, MeasuredError> {
    let (mut rows, mut values) = (Rows::new(name), Vec::new());
    for line in lines(bytes) {
        if line.tokens().next().is_some() {
            let place = format!("line {}", line.number);
            let [_, value] = rows.read(place, line.tokens(), ["the wavelength in nm", "the value"], 1.0)?;
            values.push(value);
        }
    }
    rows.samples(values)
}

/// eta and k of a refractiveindex.info file.
fn tables(name: &str, bytes: &[u8]) -> Result<(SpectralSamples, SpectralSamples), MeasuredError> {
    let text = std::str::from_utf8(bytes).map_err(|error| {
        let place = format!("byte {}", error.valid_up_to() + 1);
        refused(name, place, "these bytes are not allowed: YAML is UTF-8 here")
    })?;
    let root = parse_tree(name, text)?;
    let data = root.get("DATA");
    let Some(Tree::Sequence(entries)) = data else {
        let what = "a list is missing: a file of refractiveindex.info holds its tables in DATA";
        return Err(refused(name, "DATA", what));
    };
    let (mut eta, mut k, mut formula) = (None, None, false);
    for (i, entry) in entries.iter().enumerate() {
        let place = format!("DATA entry {}", i + 1);
        let Some(Tree::Scalar { text: kind, line, .. }) = entry.get("type") else {
            return Err(refused(name, place, "its type is missing"));
        };
        let (for_eta, for_k) = match kind.trim() {
            "tabulated nk" => (true, true),
            "tabulated n" => (true, false),
            "tabulated k" => (false, true),
            other if other.starts_with("formula ") => {
                formula = true;
                continue;
            }
            other => {
                let what = format!(
                    "type {} is not allowed: it is \"tabulated nk\", \"tabulated n\" or \"tabulated k\"",
                    shown(other.as_bytes())
                );
                return Err(refused(name, format!("line {line}"), what));
            }
        };
        if (for_eta && eta.is_some()) || (for_k && k.is_some()) {
            let what = format!("a second table of this kind, \"{}\", is not allowed", kind.trim());
            return Err(refused(name, format!("line {line}"), what));
        }
        let Some(data) = entry.get("data") else {
            return Err(refused(name, place, "its data is missing"));
        };
        let (new_eta, new_k) = table(name, &place, data, [for_eta, for_k])?;
        eta = eta.or(new_eta);
        k = k.or(new_k);
    }
    match (eta, k) {
        (Some(eta), Some(k)) => Ok((eta, k)),
        (eta, _) => {
            let missing = if eta.is_none() { "n" } else { "k" };
            let only = if formula {
                ", and a formula does not stand in for one"
            } else {
                ""
            };
            let what = format!("a table of {missing} is missing: a conductor needs n and k tabulated{only}");
            Err(refused(name, "DATA", what))
        }
    }
}

/// eta and k, whichever are wanted, of the block of text that one entry holds.
#[allow(clippy::type_complexity, reason = "two optional columns, taken apart at once")]
fn table(
    name: &str,
    place: &str,
    data: &Tree,
    [for_eta, for_k]: [bool; 2],
) -> Result<(Option<SpectralSamples>, Option<SpectralSamples>), MeasuredError> {
    let Tree::Scalar { text, line, literal } = data else {
        return Err(refused(name, place, "its data is no block of text"));
    };
    let (mut rows, mut etas, mut ks) = (Rows::new(name), Vec::new(), Vec::new());
    let micrometres = "the wavelength in micrometres";
    // the block is said to begin with its first line that is not empty, yet its text has those before
    let first = (line + 1).saturating_sub(text.bytes().take_while(|byte| *byte == b'\n').count());
    for row in lines(text.as_bytes()) {
        if row.tokens().next().is_none() {
            continue;
        }
        // only a literal block keeps its lines
        let place = if *literal {
            format!("line {}", first + row.number - 2)
        } else {
            format!("{place}, row {}", row.number)
        };
        if for_eta && for_k {
            let [_, eta, k] = rows.read(place, row.tokens(), [micrometres, "n", "k"], 1000.0)?;
            etas.push(eta);
            ks.push(k);
        } else {
            let column = if for_eta { "n" } else { "k" };
            let [_, value] = rows.read(place, row.tokens(), [micrometres, column], 1000.0)?;
            if for_eta { &mut etas } else { &mut ks }.push(value);
        }
    }
    Ok((
        for_eta.then(|| rows.samples(etas)).transpose()?,
        for_k.then(|| rows.samples(ks)).transpose()?,
    ))
}

/// As much of YAML as these files use: no aliases, which let a short file grow without bound.
enum Tree {
    Scalar { text: String, line: usize, literal: bool },
    Sequence(Vec<Tree>),
    Mapping(Vec<(Tree, Tree)>),
}

/// Collections within collections; these files have three.
const DEEPEST: usize = 16;

impl Tree {
    fn get(&self, key: &str) -> Option<&Tree> {
        let Self::Mapping(pairs) = self else {
            return None;
        };
        let is_key = |tree: &Tree| matches!(tree, Self::Scalar { text, .. } if text == key);
        pairs.iter().find(|(k, _)| is_key(k)).map(|(_, value)| value)
    }
}

fn parse_tree(name: &str, text: &str) -> Result<Tree, MeasuredError> {
    // collections that are still open, each with the line it began on, and a key that waits for its value
    let mut open: Vec<(Tree, Option<Tree>)> = Vec::new();
    for event in Parser::new_from_str(text) {
        let (event, span) = event.map_err(|error| {
            let place = format!("line {}", error.marker().line());
            refused(name, place, format!("this is no YAML: {}", error.info()))
        })?;
        let line = span.start.line();
        let done = match event {
            Event::Scalar(text, style, ..) => Tree::Scalar {
                text: text.into_owned(),
                line,
                literal: style == ScalarStyle::Literal,
            },
            Event::SequenceStart(..) | Event::MappingStart(..) => {
                if open.len() == DEEPEST {
                    let what = format!("more than {DEEPEST} levels of collections are not allowed");
                    return Err(refused(name, format!("line {line}"), what));
                }
                open.push(match event {
                    Event::SequenceStart(..) => (Tree::Sequence(Vec::new()), None),
                    _ => (Tree::Mapping(Vec::new()), None),
                });
                continue;
            }
            Event::SequenceEnd | Event::MappingEnd => match open.pop() {
                Some((tree, _)) => tree,
                None => continue,
            },
            Event::Alias(_) => {
                return Err(refused(name, format!("line {line}"), "an alias is not allowed here"));
            }
            // the first document is the file
            Event::DocumentEnd => break,
            _ => continue,
        };
        match open.last_mut() {
            Some((Tree::Sequence(items), _)) => items.push(done),
            Some((Tree::Mapping(pairs), key)) => match key.take() {
                Some(key) => pairs.push((key, done)),
                None => *key = Some(done),
            },
            _ => return Ok(done),
        }
    }
    let what = "nothing is in it: a file of refractiveindex.info holds its tables in DATA";
    Err(refused(name, "line 1", what))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fresnel::{Fresnel, conductor};
    use crate::measured::cie::RgbWeights;

    const GOLD: &str = "REFERENCES: |\n    a: b\nDATA:\n  - type: tabulated nk\n    data: |\n        0.4 1.5 1.9\n        0.55 0.4 2.4\n        0.7 0.13 4.1\n";

    fn message(yaml: &str) -> String {
        ConductorIndex::parse_yaml("x.yml", yaml.as_bytes())
            .unwrap_err()
            .to_string()
    }

    /// F of the channels against the colour of F at every wavelength, computed apart. F is not linear in eta and k, so the
    /// two differ; by 0.047 in gold's red, where the index changes most within the channel and the colour is 1.022.
    #[test]
    fn metals_have_their_colours() {
        let nm: Vec<f64> = (360..=830).map(f64::from).collect();
        let weights = RgbWeights::for_wavelengths(&nm).unwrap();
        for name in NAMES {
            let index = ConductorIndex::named(name).unwrap();
            let f = Fresnel::conductor(index.eta(), index.k())
                .unwrap()
                .reflectance(1.0)
                .to_array();
            let file = |kind: &str| {
                let path = format!("{}/src/measured/metals/{name}.{kind}.spd", env!("CARGO_MANIFEST_DIR"));
                read_spd(Path::new(&path)).unwrap()
            };
            let (eta, k) = (file("eta"), file("k"));
            let spectral: Vec<f64> = nm.iter().map(|nm| conductor(1.0, eta.at(*nm), k.at(*nm))).collect();
            let colour = weights.to_rgb(&spectral);
            println!(
                "{name}: eta {:?} k {:?} F {f:?} colour of F {colour:?}",
                index.eta(),
                index.k()
            );
            for c in 0..3 {
                assert!((f[c] - colour[c]).abs() < 0.05, "{name} {f:?} {colour:?}");
            }
            match name {
                "Ag" => assert!(f.iter().all(|f| *f > 0.9)),
                "Al" => assert!(f.iter().all(|f| (0.88..0.94).contains(f))),
                _ => assert!(f[0] > 0.9 && f[0] > f[1] && f[1] > f[2] && f[2] > 0.2),
            }
        }
        assert_eq!(ConductorIndex::named("au"), None);
    }

    #[test]
    fn micrometres_become_nanometres() {
        let from_yaml = ConductorIndex::parse_yaml("gold", GOLD.as_bytes()).unwrap();
        let eta = parse_spd("eta", b"# gold\r\n400 1.5\r\n\r\n550 0.4 # green\r\n700 0.13").unwrap();
        let k = parse_spd("k", b"400 1.9\n550 2.4\n700 4.1\n").unwrap();
        let from_spd = ConductorIndex::from_samples("eta", &eta, "k", &k).unwrap();
        for (a, b) in [(from_yaml.eta(), from_spd.eta()), (from_yaml.k(), from_spd.k())] {
            // 0.55 * 1000 is not quite 550
            assert!((a.value() - b.value()).abs().max_element() < 1e-13);
        }
        let split = "DATA:\n  - type: tabulated k\n    data: |\n        0.4 1.9\n        0.55 2.4\n        0.7 4.1\n  - type: tabulated n\n    data: \"0.4 1.5\\n0.55 0.4\\n0.7 0.13\"\n";
        assert_eq!(ConductorIndex::parse_yaml("gold", split.as_bytes()).unwrap(), from_yaml);
    }

    #[test]
    fn bad_rows_are_refused_with_their_line() {
        let refused = |text: &str| parse_spd("x.spd", text.as_bytes()).unwrap_err().to_string();
        let cases = [
            (
                "400 1\n500 nan",
                "x.spd: line 2: \"nan\" is not allowed: the value is a finite number",
            ),
            (
                "400 1\n500 1e999",
                "x.spd: line 2: \"1e999\" is not allowed: the value is a finite number",
            ),
            (
                "# c\n400 -1",
                "x.spd: line 2: \"-1\" is not allowed: the value is at least 0",
            ),
            (
                "400",
                "x.spd: line 1: 1 numbers are not allowed: a row has 2, the wavelength in nm, the value",
            ),
            (
                "400 1 2",
                "x.spd: line 1: more numbers are not allowed: a row has 2, the wavelength in nm, the value",
            ),
            (
                "400 1\n\n400 2",
                "x.spd: line 3: 400 nm after 400 nm is not allowed: wavelengths increase",
            ),
            (
                "400 1",
                "x.spd: line 1: 1 wavelengths with 1 values are not allowed: a spectrum has as many of each, and at least two",
            ),
            (
                "",
                "x.spd: table: 0 wavelengths with 0 values are not allowed: a spectrum has as many of each, and at least two",
            ),
        ];
        for (text, wanted) in cases {
            assert_eq!(refused(text), wanted);
        }
        assert_eq!(
            message(&GOLD.replace("0.4 2.4", "0.4 oops")),
            "x.yml: line 7: \"oops\" is not allowed: k is a finite number"
        );
        assert_eq!(
            message(
                &GOLD
                    .replace("data: |\n", "data: |\n\n\n")
                    .replace("0.4 2.4", "0.4 oops")
            ),
            "x.yml: line 9: \"oops\" is not allowed: k is a finite number"
        );
        assert_eq!(
            message(&GOLD.replace("0.55 0.4", "0.35 0.4")),
            "x.yml: line 7: 350 nm after 400 nm is not allowed: wavelengths increase"
        );
    }

    #[test]
    fn files_without_an_index_of_a_conductor_are_refused() {
        let cases = [
            (
                "DATA:\n  - type: formula 1\n    coefficients: 0 1 2\n",
                "a conductor needs n and k tabulated, and a formula does not",
            ),
            (
                "DATA:\n  - type: tabulated n\n    data: |\n        0.4 1\n        0.7 1\n",
                "a table of k is missing",
            ),
            ("DATA:\n  - type: [1]\n", "DATA entry 1: its type is missing"),
            ("DATA:\n  - type: tabulated nk\n", "DATA entry 1: its data is missing"),
            (
                "DATA:\n  - type: tabulated nk\n    data: [1]\n",
                "DATA entry 1: its data is no block of text",
            ),
            (
                "DATA:\n  - type: tabulated q\n",
                "line 2: type \"tabulated q\" is not allowed",
            ),
            ("DATA: 1\n", "DATA: a list is missing"),
            ("", "nothing is in it"),
            ("17", "DATA: a list is missing"),
            ("a: &x 1\nb: *x\n", "an alias is not allowed here"),
            ("a: [1, 2\n", "this is no YAML"),
        ];
        for (text, wanted) in cases {
            let message = message(text);
            assert!(
                message.starts_with("x.yml: ") && message.contains(wanted),
                "{text}: {message}"
            );
        }
        assert!(message(&format!("{GOLD}{}", &GOLD[GOLD.find("  - ").unwrap()..])).contains("a second table"));
        assert!(message(&"[".repeat(100)).contains("more than 16 levels"));
        let infrared = GOLD
            .replace("0.4 1.5", "4.4 1.5")
            .replace("0.55", "4.55")
            .replace("0.7", "4.7");
        assert!(message(&infrared).contains("4400 to 4700 nm are not allowed: a table has to overlap 400 to 700 nm"));
        let huge = message(&GOLD.replace("4.1", "4100"));
        assert!(
            huge.starts_with("x.yml: red channel of k: k = ") && huge.ends_with("k lies in [0, 100]"),
            "{huge}"
        );
    }

    /// Every truncation, and flips of every bit, are an answer or an error.
    #[test]
    fn damaged_files_never_panic() {
        for end in 0..GOLD.len() {
            let _ = ConductorIndex::parse_yaml("x", &GOLD.as_bytes()[..end]);
        }
        let spd = b"# gold\r\n400 1.5\r\n\r\n550 0.4 # green\r\n700 0.13";
        for (bytes, yaml) in [(GOLD.as_bytes(), true), (spd.as_slice(), false)] {
            for bit in 0..bytes.len() * 8 {
                let mut damaged = bytes.to_vec();
                damaged[bit / 8] ^= 1 << (bit % 8);
                if yaml {
                    let _ = ConductorIndex::parse_yaml("x", &damaged);
                } else {
                    let _ = parse_spd("x", &damaged);
                }
            }
        }
        // nothing takes more than a moment: a mebibyte of openings, of anchors, of one long key
        for text in [
            "[", "{", "- ", "? ", "a: ", "&a ", "- - - ", "\"", "|\n ", "\t", "%", "!",
        ] {
            let large = text.repeat(LARGEST_FILE as usize / text.len());
            let _ = ConductorIndex::parse_yaml("x", large.as_bytes());
            let _ = parse_spd("x", large.as_bytes());
        }
    }
}
