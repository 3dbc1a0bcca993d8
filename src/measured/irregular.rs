//! Irregularly spaced samples of an isotropic BRDF, and the value between them [pbrt 2010, section 8.6.1].
//!
//! The file is text; `#` starts a comment. It holds numbers that white space separates: the count of wavelengths, the
//! wavelengths in nm, then records of theta_i, phi_i, theta_o, phi_o in radians and one f in sr^-1, without the cosine, per
//! wavelength.

use super::MeasuredError;
use super::cie::RgbWeights;
use super::file::{lines, number, read_whole, sha256_hex, shown};
use crate::spectrum::Channels;
use glam::DVec3;
use kdtree::KdTree;
use std::f64::consts::{FRAC_1_PI, FRAC_PI_2, PI, TAU};
use std::path::Path;

/// Largest file, in bytes: some 150 times the published ones.
pub const LARGEST_FILE: u64 = 64 << 20;
/// Most wavelengths in a file; published ones have 31.
pub const MOST_WAVELENGTHS: usize = 1000;
/// Most records in a file; published ones have 1439.
pub const MOST_SAMPLES: usize = 1 << 18;
/// Wavelengths of a file, in nm.
pub const WAVELENGTHS_NM: [f64; 2] = [100.0, 10_000.0];
/// Largest f, sr^-1: far above any measurement, and small enough for sums of all samples to stay finite.
pub const LARGEST_F: f64 = 1e12;
/// Angles are printed with six decimals, which round pi/2 up by less than this.
const ANGLE_SLACK: f64 = 1e-6;

/// First squared search radius, the factor between radii, and the radius beyond which the search stops
/// [pbrt 2010, section 8.6.1].
const FIRST_RADIUS2: f64 = 0.001;
const RADIUS2_STEP: f64 = 2.0;
const LAST_RADIUS2: f64 = 1.5;
/// Samples that are enough.
const ENOUGH: usize = 3;
/// A sample at the squared distance d2 counts exp(-FALLOFF d2).
const FALLOFF: f64 = 100.0;

/// Coordinates are rounded to multiples of this, so that the tree, which halves intervals, ends after some forty halvings
/// even where samples are packed on purpose. It is a thousandth of the last digit of a file's angles or less.
const GRID: f64 = 1.0 / (1u64 << 40) as f64;

/// Where a sample or a lookup lies: (sin theta_i sin theta_o, dphi/pi, cos theta_i cos theta_o), Marschner's mapping.
///
/// It knows isotropy and reciprocity: turning both directions about the normal, or swapping them, leads to the same point.
/// [pbrt 2010, section 8.6.1]
type Point = [f64; 3];

/// One record.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Sample {
    at: Point,
    /// Linear RGB, sr^-1; a channel may be negative, see [`super::cie`].
    f: DVec3,
}

/// A file of samples, ready for lookups.
#[derive(Debug, Clone)]
pub struct IrregularSamples {
    path: String,
    sha256: String,
    channels: Channels,
    /// In an order of their own, so that the order of the file cannot change the last bit of a sum.
    samples: Vec<Sample>,
    tree: KdTree<f64, u32, Point>,
}

/// The same file by name and content.
impl PartialEq for IrregularSamples {
    fn eq(&self, other: &Self) -> bool {
        self.path == other.path && self.sha256 == other.sha256
    }
}

impl IrregularSamples {
    /// Reads the file at `path`.
    ///
    /// # Errors
    /// [`MeasuredError`] with the line, the value and what is allowed.
    pub fn read(path: &Path) -> Result<Self, MeasuredError> {
        Self::parse(&path.display().to_string(), &read_whole(path, LARGEST_FILE)?)
    }

    /// The same from the bytes of the file, which messages call `name`.
    ///
    /// # Errors
    /// As [`IrregularSamples::read`].
    pub fn parse(name: &str, bytes: &[u8]) -> Result<Self, MeasuredError> {
        if bytes.len() as u64 > LARGEST_FILE {
            return Err(MeasuredError::Size {
                path: name.into(),
                bytes: bytes.len() as u64,
                allowed: format!("a file of this kind has at most {LARGEST_FILE} bytes"),
            });
        }
        let refused = |place: String, what: String| MeasuredError::Refused {
            path: name.into(),
            place,
            what,
        };
        let mut samples = parse_samples(bytes).map_err(|(place, what)| refused(place, what))?;
        samples.sort_by(|a, b| {
            let (f, g) = (a.f.to_array(), b.f.to_array());
            let pairs = a.at.iter().chain(&f).zip(b.at.iter().chain(&g));
            pairs.fold(std::cmp::Ordering::Equal, |order, (a, b)| order.then(a.total_cmp(b)))
        });
        let mut tree = KdTree::new(3);
        for (i, sample) in (0..).zip(&samples) {
            // the coordinates are finite, the only thing that the tree could object to
            tree.add(sample.at, i)
                .map_err(|error| refused(format!("sample {}", i + 1), error.to_string()))?;
        }
        let grey = samples.iter().all(|s| s.f.x == s.f.y && s.f.y == s.f.z);
        Ok(Self {
            path: name.into(),
            sha256: sha256_hex(bytes),
            channels: if grey { Channels::Grey } else { Channels::Rgb },
            samples,
            tree,
        })
    }

    /// The file as it was named.
    pub fn path(&self) -> &str {
        &self.path
    }

    /// SHA-256 of its bytes, in hexadecimal digits.
    pub fn sha256(&self) -> &str {
        &self.sha256
    }

    /// How many records it has.
    #[allow(clippy::len_without_is_empty, reason = "a file without records is refused")]
    pub fn len(&self) -> usize {
        self.samples.len()
    }

    /// How many samples are below 0 in red, green and blue: their colours lie outside the gamut of sRGB.
    pub fn negative(&self) -> [usize; 3] {
        [0, 1, 2].map(|c| self.samples.iter().filter(|s| s.f[c] < 0.0).count())
    }

    /// Whether every sample is grey.
    pub fn channels(&self) -> Channels {
        self.channels
    }

    /// f in sr^-1 for two unit vectors, either side of the surface; only the absolute cosines enter.
    ///
    /// The mean of the samples around the point of the mapping, each counted exp(-100 d^2) with its distance d. They are
    /// those within the smallest of the squared radii 0.001, 0.002, 0.004, ... 2.048 that has three of them, or within the last.
    /// Channels that the mean leaves below 0 become 0 [pbrt 2010, section 8.6.1]. As printed that is 0/0 where there is no
    /// sample within the last radius, or all are so far away that they count nothing: then the nearest sample is the value.
    ///
    /// Swapping the directions changes no bit, and neither does the order of the records.
    pub fn f(&self, wo: DVec3, wi: DVec3) -> DVec3 {
        self.at(remap(wo, wi)).max(DVec3::ZERO)
    }

    fn at(&self, point: Point) -> DVec3 {
        // one search tells which radius is enough, instead of a search for every radius
        let nearest = self.tree.nearest(&point, ENOUGH, &squared_distance).unwrap_or_default();
        let mut radius2 = FIRST_RADIUS2;
        let reached = |radius2| nearest.len() == ENOUGH && nearest.iter().all(|(d2, _)| *d2 < radius2);
        while !reached(radius2) && radius2 <= LAST_RADIUS2 {
            radius2 *= RADIUS2_STEP;
        }
        let mut found = self.tree.within(&point, radius2, &squared_distance).unwrap_or_default();
        // a sum in the order of the samples, not in that of the search
        found.sort_unstable_by_key(|(_, i)| **i);
        let (mut sum, mut weights) = (DVec3::ZERO, 0.0);
        for (d2, i) in found {
            if d2 < radius2 {
                let weight = libm::exp(-FALLOFF * d2);
                sum += weight * self.samples[*i as usize].f;
                weights += weight;
            }
        }
        if weights > 0.0 {
            return sum / weights;
        }
        // of equally near ones the first
        let least = nearest.iter().map(|(d2, _)| *d2).fold(f64::INFINITY, f64::min);
        let first = nearest.iter().filter(|(d2, _)| *d2 == least).map(|(_, i)| **i).min();
        first.map_or(DVec3::ZERO, |i| self.samples[i as usize].f)
    }
}

fn squared_distance(a: &[f64], b: &[f64]) -> f64 {
    let [x, y, z] = [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
    x * x + y * y + z * z
}

fn on_grid(point: Point) -> Point {
    point.map(|x| (x / GRID).round() * GRID)
}

/// The point of a pair of unit vectors.
///
/// dphi comes from one arc tangent of |wo x wi| and wo . wi in the plane, which folds it to [0, pi] and keeps it symmetric to
/// the last bit. At the pole, which has no azimuth, it is that of the x axis, as an arc tangent of (0, 0) has it.
pub(crate) fn remap(wo: DVec3, wi: DVec3) -> Point {
    let plane = |w: DVec3| {
        if w.x == 0.0 && w.y == 0.0 {
            (1.0, 0.0)
        } else {
            (w.x, w.y)
        }
    };
    let ((xo, yo), (xi, yi)) = (plane(wo), plane(wi));
    let dphi = libm::atan2((xo * yi - yo * xi).abs(), xo * xi + yo * yi);
    let (sin_o, sin_i) = (libm::hypot(wo.x, wo.y), libm::hypot(wi.x, wi.y));
    [sin_i * sin_o, dphi * FRAC_1_PI, (wi.z * wo.z).abs()]
}

/// Place and reason of a refusal.
type Refusal = (String, String);

fn parse_samples(bytes: &[u8]) -> Result<Vec<Sample>, Refusal> {
    let mut tokens = lines(bytes).flat_map(|line| {
        let number = line.number;
        line.tokens().map(move |token| (number, token))
    });
    let refuse = |line: usize, what: String| Err((format!("line {line}"), what));
    let next = |tokens: &mut dyn Iterator<Item = (usize, &[u8])>, name: &str| {
        let Some((line, token)) = tokens.next() else {
            return Err(("end".into(), format!("the file ends where {name} should be")));
        };
        let value = number(token, name).map_err(|what| (format!("line {line}"), what))?;
        Ok((line, value, shown(token)))
    };

    let (line, count, token) = next(&mut tokens, "the count of wavelengths")?;
    if count.fract() != 0.0 || !(1.0..=MOST_WAVELENGTHS as f64).contains(&count) {
        let what = format!("{token} is not allowed: the count of wavelengths is 1 to {MOST_WAVELENGTHS}");
        return refuse(line, what);
    }
    let count = count as usize;
    let mut wavelengths: Vec<f64> = Vec::new();
    let [shortest, longest] = WAVELENGTHS_NM;
    for _ in 0..count {
        let (line, nm, token) = next(&mut tokens, "a wavelength")?;
        if !(shortest..=longest).contains(&nm) {
            let what = format!("{token} is not allowed: wavelengths lie in [{shortest}, {longest}] nm");
            return refuse(line, what);
        }
        if wavelengths.last().is_some_and(|last| nm <= *last) {
            return refuse(line, format!("{token} is not allowed: wavelengths increase"));
        }
        wavelengths.push(nm);
    }
    let weights =
        RgbWeights::for_wavelengths(&wavelengths).map_err(|error| ("wavelengths".into(), error.to_string()))?;

    let mut samples = Vec::new();
    let mut record = vec![0.0; 4 + count];
    let mut filled = 0;
    for (line, token) in tokens {
        let name = match filled {
            0 => "theta_i",
            1 => "phi_i",
            2 => "theta_o",
            3 => "phi_o",
            _ => "f",
        };
        let [least, most] = match filled {
            0 | 2 => [0.0, FRAC_PI_2 + ANGLE_SLACK],
            1 | 3 => [-TAU - ANGLE_SLACK, TAU + ANGLE_SLACK],
            // noise around 0 may be negative
            _ => [-LARGEST_F, LARGEST_F],
        };
        let place = || format!("line {line}, record {}", samples.len() + 1);
        let value = number(token, name).map_err(|what| (place(), what))?;
        if !(least..=most).contains(&value) {
            let range = match filled {
                0 | 2 => "[0, pi/2]".into(),
                1 | 3 => "[-2 pi, 2 pi]".into(),
                _ => format!("[-{LARGEST_F:e}, {LARGEST_F:e}]"),
            };
            return Err((
                place(),
                format!("{} is not allowed: {name} lies in {range}", shown(token)),
            ));
        }
        record[filled] = value;
        filled += 1;
        if filled == record.len() {
            filled = 0;
            if samples.len() == MOST_SAMPLES {
                return refuse(line, format!("more than {MOST_SAMPLES} records are not allowed"));
            }
            samples.push(sample(&record, &weights));
        }
    }
    if filled > 0 {
        let what = format!(
            "{filled} numbers are not allowed: a record has {}, four angles and {count} values of f",
            record.len()
        );
        return Err((format!("record {}, the last", samples.len() + 1), what));
    }
    if samples.is_empty() {
        return Err((
            "end".into(),
            "0 records are not allowed: a file has at least one".into(),
        ));
    }
    Ok(samples)
}

fn sample(record: &[f64], weights: &RgbWeights) -> Sample {
    let (theta_i, phi_i, theta_o, phi_o) = (record[0], record[1], record[2], record[3]);
    let dphi = (phi_i - phi_o).abs() % TAU;
    let dphi = if dphi > PI { TAU - dphi } else { dphi };
    Sample {
        at: on_grid([
            libm::sin(theta_i) * libm::sin(theta_o),
            dphi * FRAC_1_PI,
            // the slack of the angles may take a cosine below 0
            (libm::cos(theta_i) * libm::cos(theta_o)).max(0.0),
        ]),
        f: DVec3::from_array(weights.to_rgb(&record[4..])),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Polar;
    use crate::numerics::stream::{Stream, StreamId};

    /// Three wavelengths and a few hundred records of `f(theta_i, theta_o, dphi, wavelength)`.
    fn written(f: impl Fn(f64, f64, f64, f64) -> f64) -> String {
        let mut text = String::from("# a model\r\n3\r\n450 550 650 # nm\r\n");
        for (i, j, k) in (0..8).flat_map(|i| (0..8).flat_map(move |j| (0..7).map(move |k| (i, j, k)))) {
            let (theta_i, theta_o, dphi) = (f64::from(i) * 0.2, f64::from(j) * 0.2, f64::from(k) * PI / 6.0);
            let values = [450.0, 550.0, 650.0].map(|nm| f(theta_i, theta_o, dphi, nm));
            text += &format!("{theta_i:.6} 0.5 {theta_o:.6} {:.6} {values:?}\r\n", 0.5 - dphi)
                .replace(['[', ']', ','], " ");
        }
        text
    }

    fn parse(text: &str) -> IrregularSamples {
        IrregularSamples::parse("x.brdf", text.as_bytes()).unwrap()
    }

    fn message(text: &str) -> String {
        IrregularSamples::parse("x.brdf", text.as_bytes())
            .unwrap_err()
            .to_string()
    }

    fn directions(count: u64) -> Vec<[DVec3; 2]> {
        let mut stream = Stream::new(StreamId {
            seed: 8,
            cell: 6,
            batch: 1,
        });
        let mut draw = || {
            let [a, b, c] = stream.uniform3();
            let w = Polar::from_cos(a.powi(2)).direction(TAU * b);
            if c < 0.5 { w } else { DVec3::new(w.x, w.y, -w.z) }
        };
        (0..count).map(|_| [draw(), draw()]).collect()
    }

    #[test]
    fn a_constant_is_a_constant_and_grey() {
        let samples = parse(&written(|_, _, _, _| 0.25));
        assert_eq!((samples.len(), samples.channels()), (448, Channels::Grey));
        for [wo, wi] in directions(500) {
            // a weighted mean of equal values, rounded a few times
            assert!((samples.f(wo, wi) - 0.25).abs().max_element() < 1e-15);
        }
    }

    #[test]
    fn lookups_are_symmetric_and_know_no_order() {
        let text = written(|i, o, d, nm| (i * o).cos() + 0.1 * d + nm / 1000.0);
        let samples = parse(&text);
        let mut backwards: Vec<&str> = text.lines().collect();
        backwards[3..].reverse();
        let backwards = parse(&backwards.join("\n"));
        assert_ne!(samples.sha256(), backwards.sha256());
        for [wo, wi] in directions(500) {
            let f = samples.f(wo, wi);
            assert_eq!(f, samples.f(wi, wo));
            assert_eq!(f, samples.f(-wo, -wi));
            assert_eq!(f, backwards.f(wo, wi));
        }
    }

    /// The printed procedure, search by search over all samples in the order of the file, in f64.
    fn as_printed(samples: &[Sample], wo: DVec3, wi: DVec3) -> DVec3 {
        let sin = |w: DVec3| (1.0 - w.z * w.z).max(0.0).sqrt();
        let phi = |w: DVec3| {
            let phi = w.y.atan2(w.x);
            if phi < 0.0 { phi + TAU } else { phi }
        };
        let mut dphi = phi(wi) - phi(wo);
        if dphi < 0.0 {
            dphi += TAU;
        }
        if dphi > TAU {
            dphi -= TAU;
        }
        if dphi > PI {
            dphi = TAU - dphi;
        }
        let m = [sin(wi) * sin(wo), dphi / PI, wi.z.abs() * wo.z.abs()];
        let mut radius2 = 0.001;
        loop {
            let (mut v, mut sum, mut found) = (DVec3::ZERO, 0.0, 0);
            for sample in samples {
                let d2: f64 = (0..3).map(|i| (m[i] - sample.at[i]).powi(2)).sum();
                if d2 < radius2 {
                    v += (-100.0 * d2).exp() * sample.f;
                    sum += (-100.0 * d2).exp();
                    found += 1;
                }
            }
            if found > 2 || radius2 > 1.5 {
                return v.max(DVec3::ZERO) / sum;
            }
            radius2 *= 2.0;
        }
    }

    /// Rounding moves a point by 1e-12 and exp(-100 d^2) by up to 2e-10 of itself; at the border of a radius it may also move
    /// a sample in or out, which one pair in ten thousand could show.
    #[test]
    fn lookups_are_the_printed_ones() {
        let samples = parse(&written(|i, o, d, nm| (i * o).cos() - 0.3 * d + nm / 1000.0 - 0.6));
        assert!(samples.negative().iter().all(|n| *n > 0));
        for [wo, wi] in directions(500) {
            let reference = as_printed(&samples.samples, wo, wi);
            assert!((samples.f(wo, wi) - reference).abs().max_element() < 1e-8);
        }
    }

    #[test]
    fn far_from_all_samples_the_nearest_one_counts() {
        let samples = parse("1\n500\n0 0 0 0 0.5\n");
        let horizon = DVec3::X;
        // (1, 1, 0) is sqrt 3 away from (0, 0, 1), beyond the last radius
        assert_eq!(samples.f(horizon, -horizon), DVec3::splat(0.5));
    }

    #[test]
    fn damage_is_refused_with_its_place() {
        let cases = [
            ("", "end: the file ends where the count of wavelengths should be"),
            (
                "# nothing",
                "end: the file ends where the count of wavelengths should be",
            ),
            ("2\n400", "end: the file ends where a wavelength should be"),
            (
                "0",
                "line 1: \"0\" is not allowed: the count of wavelengths is 1 to 1000",
            ),
            (
                "1e9",
                "line 1: \"1e9\" is not allowed: the count of wavelengths is 1 to 1000",
            ),
            (
                "2.5",
                "line 1: \"2.5\" is not allowed: the count of wavelengths is 1 to 1000",
            ),
            (
                "-3",
                "line 1: \"-3\" is not allowed: the count of wavelengths is 1 to 1000",
            ),
            ("2\n400 400", "line 2: \"400\" is not allowed: wavelengths increase"),
            (
                "1\n0.5",
                "line 2: \"0.5\" is not allowed: wavelengths lie in [100, 10000] nm",
            ),
            ("1\n500\n", "end: 0 records are not allowed: a file has at least one"),
            (
                "1\n500\n0 0 0 0",
                "record 1, the last: 4 numbers are not allowed: a record has 5, four angles and 1 values of f",
            ),
            (
                "1\n500\n0 0 0 0 1\n1.6 0 0 0 1",
                "line 4, record 2: \"1.6\" is not allowed: theta_i lies in [0, pi/2]",
            ),
            (
                "1\n500\n0 0 -0.1 0 1",
                "line 3, record 1: \"-0.1\" is not allowed: theta_o lies in [0, pi/2]",
            ),
            (
                "1\n500\n0 7 0 0 1",
                "line 3, record 1: \"7\" is not allowed: phi_i lies in [-2 pi, 2 pi]",
            ),
            (
                "1\n500\n0 0 0 0 NaN",
                "line 3, record 1: \"NaN\" is not allowed: f is a finite number",
            ),
            (
                "1\n500\n0 0 0 0 1e999",
                "line 3, record 1: \"1e999\" is not allowed: f is a finite number",
            ),
            (
                "1\n500\n0 0 0 0 1e13",
                "line 3, record 1: \"1e13\" is not allowed: f lies in [-1e12, 1e12]",
            ),
        ];
        for (text, wanted) in cases {
            assert_eq!(message(text), format!("x.brdf: {wanted}"), "{text}");
        }
        // the angles' own rounding is allowed
        assert_eq!(parse("1\n500\n1.570797 6.283186 1.570797 -6.283186 1").len(), 1);
    }

    #[test]
    fn damaged_files_never_panic() {
        let text = "# c\r\n2\r\n450 550\r\n0.1 0 0.2 1.5 0.25 0.5\r\n0.3 0 0.2 -1.5 0.25 1e-3\r\n";
        let check = |bytes: &[u8]| {
            if let Ok(samples) = IrregularSamples::parse("x", bytes) {
                for [wo, wi] in directions(5) {
                    assert!(samples.f(wo, wi).is_finite());
                }
            }
        };
        for end in 0..text.len() {
            check(&text.as_bytes()[..end]);
        }
        for bit in 0..text.len() * 8 {
            let mut damaged = text.as_bytes().to_vec();
            damaged[bit / 8] ^= 1 << (bit % 8);
            check(&damaged);
        }
        check(&(0..=255).cycle().take(100_000).collect::<Vec<u8>>());
        // more records than are allowed, all in one place
        let many = format!("1\n500\n{}", "0 0 0 0 1\n".repeat(MOST_SAMPLES + 1));
        assert!(message(&many).contains("more than 262144 records are not allowed"));
        // samples packed so that a tree of halved intervals would be as deep as f64 has binary places
        let packed: String = (0..1000).map(|i| format!("1e-{} 0 1 0 1\n", i % 300)).collect();
        check(format!("1\n500\n{packed}").as_bytes());
    }
}
