//! Spectra to linear RGB: CIE 1931 observer, illuminant D65, the primaries of Rec. 709 that sRGB shares.
//!
//! Here a spectrum S(lambda) is a property of a material, a reflectance, an f or an index, and its channel c is
//!
//! S_c = int S(lambda) r_c(lambda) dlambda,  r_c = M_c . (x-bar, y-bar, z-bar) D65/n_c,  int r_c dlambda = 1,
//!
//! with M_c the row of the matrix from XYZ to linear RGB. That is the colour under D65, white being (1, 1, 1), and a constant
//! spectrum has that constant in all channels. [CIE 015:2018; ITU-R BT.709-6]
//!
//! r_c is negative in places, as those of any three real primaries are. A spectrum outside the triangle of the primaries
//! therefore has a channel below 0, and nothing here clamps it: what is linear stays linear, so that a mean or an integral of
//! spectra and its colour may be taken in either order.

use std::sync::LazyLock;
use thiserror::Error;

/// The tabulated functions; the file states its columns and its origin.
const TABLE: &str = include_str!("cie-1931-d65-5nm.tsv");

/// Chromaticities x, y of red, green and blue [ITU-R BT.709-6, item 1.3].
const PRIMARIES: [[f64; 2]; 3] = [[0.64, 0.33], [0.30, 0.60], [0.15, 0.06]];

/// Wavelengths, in nm, that a spectrum may be given at: from hard X-rays to radio, only to catch numbers in another unit's
/// place, since the eye ignores all but a sliver of it.
pub const WAVELENGTHS_NM: [f64; 2] = [1e-3, 1e9];

/// A spectrum that cannot be used.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[error("sample {sample}: {what}")]
pub struct SpectralError {
    /// Which sample, counted from 1.
    pub sample: usize,
    /// The value and what is allowed.
    pub what: String,
}

/// One wavelength at which the weights are tabulated.
#[derive(Debug, Clone, Copy)]
struct Node {
    nm: f64,
    /// r_c, nm^-1; linear between nodes.
    rgb: [f64; 3],
}

/// The normalised r_c. Trapezia of the table, so that the weights of any samples add up to 1.
static NODES: LazyLock<Vec<Node>> = LazyLock::new(|| {
    let mut nodes: Vec<Node> = TABLE
        .lines()
        .filter(|line| !line.starts_with('#'))
        .filter_map(|line| {
            let row: Vec<f64> = line.split('\t').filter_map(|cell| cell.parse().ok()).collect();
            let &[nm, x, y, z, d65] = row.as_slice() else {
                return None;
            };
            let rgb = channel_rows().map(|[m_x, m_y, m_z]| (m_x * x + m_y * y + m_z * z) * d65);
            Some(Node { nm, rgb })
        })
        .collect();
    let mut total = [0.0; 3];
    for pair in nodes.windows(2) {
        for c in 0..3 {
            total[c] += 0.5 * (pair[0].rgb[c] + pair[1].rgb[c]) * (pair[1].nm - pair[0].nm);
        }
    }
    for node in &mut nodes {
        for c in 0..3 {
            node.rgb[c] /= total[c];
        }
    }
    nodes
});

/// Multiples of the rows of the matrix from XYZ to linear RGB; the normalisation of r_c makes up for the multiple.
///
/// Row c vanishes on the other two primaries, so that it is the cross product of their (x, y, 1 - x - y).
fn channel_rows() -> [[f64; 3]; 3] {
    let xyz = PRIMARIES.map(|[x, y]| [x, y, 1.0 - x - y]);
    let cross = |a: [f64; 3], b: [f64; 3]| {
        [
            a[1] * b[2] - a[2] * b[1],
            a[2] * b[0] - a[0] * b[2],
            a[0] * b[1] - a[1] * b[0],
        ]
    };
    [cross(xyz[1], xyz[2]), cross(xyz[2], xyz[0]), cross(xyz[0], xyz[1])]
}

/// What every sample of a spectrum counts in every channel, for spectra that share their wavelengths.
///
/// The spectrum is linear between its samples and constant beyond its ends. Its integral against the weights, which are
/// linear between tabulated wavelengths, is exact: coarse samples are not mistaken for steps, and of fine ones none is passed
/// over.
#[derive(Debug, Clone, PartialEq)]
pub struct RgbWeights {
    weights: Vec<[f64; 3]>,
}

impl RgbWeights {
    /// Weights for samples at `wavelengths_nm`, one or more, finite, strictly increasing, within [`WAVELENGTHS_NM`].
    ///
    /// # Errors
    /// [`SpectralError`] for the first wavelength that is not.
    pub fn for_wavelengths(wavelengths_nm: &[f64]) -> Result<Self, SpectralError> {
        check_wavelengths(wavelengths_nm)?;
        let samples = wavelengths_nm;
        let last = samples.len() - 1;
        let mut weights = vec![[0.0; 3]; samples.len()];
        // the sample at or before a wavelength, and the share of the one after it
        let place = |nm: f64| match samples.partition_point(|s| *s <= nm) {
            0 => (0, 0.0),
            after if after > last => (last, 0.0),
            after => {
                let (a, b) = (samples[after - 1], samples[after]);
                (after - 1, (nm - a) / (b - a))
            }
        };
        for pair in NODES.windows(2) {
            let (from, to) = (pair[0], pair[1]);
            let inside = samples.iter().copied().skip_while(|s| *s <= from.nm);
            let mut left = from.nm;
            for right in inside.take_while(|s| *s < to.nm).chain([to.nm]) {
                // within [left, right] both factors are linear: their product is a parabola, which Simpson's rule integrates
                let sixth = (right - left) / 6.0;
                for (nm, simpson) in [(left, sixth), (0.5 * (left + right), 4.0 * sixth), (right, sixth)] {
                    let t = (nm - from.nm) / (to.nm - from.nm);
                    let (at, share) = place(nm);
                    for c in 0..3 {
                        let r = simpson * (from.rgb[c] + t * (to.rgb[c] - from.rgb[c]));
                        weights[at][c] += r * (1.0 - share);
                        if share > 0.0 {
                            weights[at + 1][c] += r * share;
                        }
                    }
                }
                left = right;
            }
        }
        Ok(Self { weights })
    }

    /// Linear RGB of the spectrum with these values at the wavelengths; values beyond the last wavelength are ignored.
    ///
    /// The weights add up to 1, so that only differences to the first value need them: a constant spectrum has that constant
    /// in every channel, to the last bit.
    pub fn to_rgb(&self, values: &[f64]) -> [f64; 3] {
        let Some(&first) = values.first() else {
            return [0.0; 3];
        };
        let mut rgb = [first; 3];
        for (value, weights) in values.iter().zip(&self.weights) {
            for c in 0..3 {
                rgb[c] += (value - first) * weights[c];
            }
        }
        rgb
    }
}

/// A quantity sampled over wavelength: linear between samples, constant beyond the first and the last.
#[derive(Debug, Clone, PartialEq)]
pub struct SpectralSamples {
    wavelengths_nm: Vec<f64>,
    values: Vec<f64>,
}

impl SpectralSamples {
    /// `values` at `wavelengths_nm`: as many of each, two or more, all finite, the wavelengths strictly increasing and within
    /// [`WAVELENGTHS_NM`].
    ///
    /// # Errors
    /// [`SpectralError`] for the first sample that is not so.
    pub fn new(wavelengths_nm: Vec<f64>, values: Vec<f64>) -> Result<Self, SpectralError> {
        let refuse = |sample, what| Err(SpectralError { sample, what });
        if wavelengths_nm.len() != values.len() || values.len() < 2 {
            let what = format!(
                "{} wavelengths with {} values are not allowed: a spectrum has as many of each, and at least two",
                wavelengths_nm.len(),
                values.len()
            );
            return refuse(wavelengths_nm.len().min(values.len()), what);
        }
        check_wavelengths(&wavelengths_nm)?;
        if let Some(at) = values.iter().position(|value| !value.is_finite()) {
            return refuse(at + 1, format!("{} is not allowed: values are finite", values[at]));
        }
        Ok(Self { wavelengths_nm, values })
    }

    /// Wavelengths in nm, increasing.
    pub fn wavelengths_nm(&self) -> &[f64] {
        &self.wavelengths_nm
    }

    /// The value at every wavelength.
    pub fn values(&self) -> &[f64] {
        &self.values
    }

    /// The value at `nm`, in nm.
    pub fn at(&self, nm: f64) -> f64 {
        let after = self.wavelengths_nm.partition_point(|s| *s <= nm);
        if after == 0 || after == self.values.len() {
            return self.values[after.saturating_sub(1)];
        }
        let (a, b) = (self.wavelengths_nm[after - 1], self.wavelengths_nm[after]);
        let (from, to) = (self.values[after - 1], self.values[after]);
        from + (to - from) * ((nm - a) / (b - a))
    }

    /// Linear RGB under D65; a channel may be negative where a spectrum is more saturated than the primaries.
    pub fn to_rgb(&self) -> [f64; 3] {
        // the constructor made sure of the wavelengths
        RgbWeights::for_wavelengths(&self.wavelengths_nm).map_or([f64::NAN; 3], |weights| weights.to_rgb(&self.values))
    }
}

fn check_wavelengths(wavelengths_nm: &[f64]) -> Result<(), SpectralError> {
    let refuse = |sample, what| Err(SpectralError { sample, what });
    if wavelengths_nm.is_empty() {
        return refuse(0, "no wavelengths are not allowed: a spectrum has at least one".into());
    }
    let [least, most] = WAVELENGTHS_NM;
    for (i, nm) in wavelengths_nm.iter().enumerate() {
        if !(*nm >= least && *nm <= most) {
            return refuse(
                i + 1,
                format!("{nm} nm is not allowed: wavelengths lie in [{least:e}, {most:e}] nm"),
            );
        }
        if i > 0 && *nm <= wavelengths_nm[i - 1] {
            let before = wavelengths_nm[i - 1];
            return refuse(
                i + 1,
                format!("{nm} nm after {before} nm is not allowed: wavelengths increase"),
            );
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rows() -> Vec<Vec<f64>> {
        let rows = TABLE.lines().filter(|line| !line.starts_with('#'));
        rows.map(|line| line.split('\t').map(|cell| cell.parse().unwrap()).collect())
            .collect()
    }

    fn spectrum(f: impl Fn(f64) -> f64, step: usize) -> SpectralSamples {
        let nm: Vec<f64> = (360..=830).step_by(step).map(|nm| nm as f64).collect();
        let values = nm.iter().map(|nm| f(*nm)).collect();
        SpectralSamples::new(nm, values).unwrap()
    }

    /// The published sum of y-bar at 1 nm is 106.857 and D65 is at x = 0.31272, y = 0.32903; steps of 5 nm keep both within
    /// 2e-5 of themselves.
    #[test]
    fn the_table_is_that_of_the_cie() {
        let rows = rows();
        assert_eq!(rows.len(), 95);
        assert!(
            rows.iter()
                .zip((360..).step_by(5))
                .all(|(row, nm)| row[0] == f64::from(nm))
        );
        let y_bar = 5.0 * rows.iter().map(|row| row[2]).sum::<f64>();
        assert!((y_bar - 106.857).abs() < 2e-5 * 106.857, "{y_bar}");
        let [x, y, z] = [1, 2, 3].map(|c| rows.iter().map(|row| row[c] * row[4]).sum::<f64>());
        let sum = x + y + z;
        assert!((x / sum - 0.31272).abs() < 2e-5 && (y / sum - 0.32903).abs() < 3e-5);
        assert_eq!(rows.iter().find(|row| row[0] == 560.0).unwrap()[4], 100.0);
    }

    /// The matrix that IEC 61966-2-1 prints, up to the multiple of every row. It is the inverse of one of four decimals,
    /// which moves its own by some 1e-4.
    #[test]
    fn rows_are_those_of_the_srgb_matrix() {
        let printed = [
            [3.2406, -1.5372, -0.4986],
            [-0.9689, 1.8758, 0.0415],
            [0.0557, -0.2040, 1.0570],
        ];
        for (row, printed) in channel_rows().iter().zip(printed) {
            let scale =
                (0..3).map(|i| printed[i] * printed[i]).sum::<f64>() / (0..3).map(|i| printed[i] * row[i]).sum::<f64>();
            for i in 0..3 {
                assert!((scale * row[i] - printed[i]).abs() < 5e-4);
            }
        }
    }

    #[test]
    fn a_constant_is_itself_whatever_its_wavelengths() {
        for value in [0.0, 1.0, 0.1, -3.7, 1e300] {
            for nm in [
                vec![550.0],
                vec![100.0, 200.0],
                vec![400.0, 401.5, 699.0, 2000.0],
                (300..900).map(f64::from).collect(),
            ] {
                let weights = RgbWeights::for_wavelengths(&nm).unwrap();
                assert_eq!(weights.to_rgb(&vec![value; nm.len()]), [value; 3]);
                for c in 0..3 {
                    // some hundred terms, each rounded to 1e-16
                    let sum: f64 = weights.weights.iter().map(|w| w[c]).sum();
                    assert!((sum - 1.0).abs() < 1e-13, "{sum}");
                }
            }
        }
    }

    /// A line is the same spectrum whether two samples state it or hundreds.
    #[test]
    fn linear_spectra_do_not_depend_on_their_sampling() {
        let line = |nm: f64| 0.1 + nm / 1000.0;
        let two = SpectralSamples::new(vec![360.0, 830.0], vec![line(360.0), line(830.0)]).unwrap();
        for step in [1, 5, 10, 47] {
            for (a, b) in two.to_rgb().into_iter().zip(spectrum(line, step).to_rgb()) {
                assert!((a - b).abs() < 1e-13, "{a} {b}"); // rounding of some hundred terms
            }
        }
    }

    /// Against the sum over the rows of the table through the printed matrix, the way that the CIE recommends. Both are
    /// quadratures of the same integrand with errors of second order in 5 nm; the printed matrix has 4 decimals, which its
    /// own white, (0.9999 .. 1.0001), shows.
    #[test]
    fn smooth_spectra_agree_with_the_sum_and_the_printed_matrix() {
        let f = |nm: f64| 0.5 + 0.4 * ((nm - 400.0) / 60.0).sin();
        let rows = rows();
        let white: f64 = rows.iter().map(|row| row[2] * row[4]).sum();
        let [x, y, z] = [1, 2, 3].map(|c| rows.iter().map(|row| f(row[0]) * row[c] * row[4]).sum::<f64>() / white);
        let reference = [
            3.2406 * x - 1.5372 * y - 0.4986 * z,
            -0.9689 * x + 1.8758 * y + 0.0415 * z,
            0.0557 * x - 0.2040 * y + 1.0570 * z,
        ];
        for (a, b) in spectrum(f, 5).to_rgb().into_iter().zip(reference) {
            assert!((a - b).abs() < 1e-3, "{a} {b}");
        }
    }

    #[test]
    fn saturated_spectra_leave_the_gamut() {
        let green = spectrum(|nm| if (500.0..540.0).contains(&nm) { 1.0 } else { 0.0 }, 5);
        let [r, g, b] = green.to_rgb();
        assert!(r < 0.0 && g > 0.0 && b < g, "{r} {g} {b}");
    }

    #[test]
    fn values_between_and_beyond_samples() {
        let s = SpectralSamples::new(vec![400.0, 500.0], vec![1.0, 3.0]).unwrap();
        assert_eq!(
            [300.0, 400.0, 450.0, 500.0, 600.0].map(|nm| s.at(nm)),
            [1.0, 1.0, 2.0, 3.0, 3.0]
        );
    }

    #[test]
    fn bad_samples_are_refused_with_their_place() {
        let refused = |nm: &[f64], values: &[f64]| SpectralSamples::new(nm.to_vec(), values.to_vec()).unwrap_err();
        assert_eq!(refused(&[400.0, 400.0], &[1.0, 1.0]).sample, 2);
        assert_eq!(refused(&[400.0, 500.0], &[1.0, f64::NAN]).sample, 2);
        assert_eq!(refused(&[f64::NAN, 500.0], &[1.0, 1.0]).sample, 1);
        assert_eq!(refused(&[400.0, f64::INFINITY], &[1.0, 1.0]).sample, 2);
        let text = refused(&[-400.0, 500.0], &[1.0, 1.0]).to_string();
        assert_eq!(
            text,
            "sample 1: -400 nm is not allowed: wavelengths lie in [1e-3, 1e9] nm"
        );
        for (nm, values) in [(&[][..], &[][..]), (&[400.0], &[1.0]), (&[400.0, 500.0], &[1.0])] {
            assert!(refused(nm, values).what.contains("at least two"));
        }
        assert!(RgbWeights::for_wavelengths(&[]).is_err());
    }
}
