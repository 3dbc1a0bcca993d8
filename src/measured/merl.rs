//! MERL's table of an isotropic BRDF over half and difference angles [Matusik et al. 2003; Rusinkiewicz 1998;
//! pbrt 2010, section 8.6.2].
//!
//! A `.binary` file holds three little-endian `i32`, the counts 90, 90 and 180, then the planes R, G and B of 1,458,000
//! little-endian `f64` each: 34,992,012 bytes. A value times the scale of its plane is f in sr^-1; the scales are 1/1500,
//! 1.15/1500 and 1.66/1500. With h = (wo + wi)/|wo + wi| and wi seen in a frame around h, cell (i, j, k) at position
//! k + 180 (j + 90 i) of a plane covers
//!
//! - theta_h, the angle of h to the normal, in (pi/2) [(i/90)^2, ((i + 1)/90)^2],
//! - theta_d, the angle of wi to h, in (pi/2) [j/90, (j + 1)/90],
//! - phi_d, the azimuth of wi around h, counted from the plane of n and h, in pi [k/180, (k + 1)/180]. The exchange of
//!   wo and wi adds pi to it; reciprocity folds it back.
//!
//! A negative value marks a sample that was not measured or not believed. It counts as 0, and how many there are is kept:
//! whoever integrates such a table integrates it as dark there.

use super::MeasuredError;
use crate::geometry::Polar;
use crate::regular;
use crate::spectrum::Channels;
use glam::DVec3;
use sha2::{Digest, Sha256};
use std::f64::consts::{FRAC_PI_2, PI};
use std::fmt;
use std::io::{self, BufWriter, Read, Write};
use std::path::Path;

/// Number of cells over theta_h.
pub const THETA_H_CELLS: usize = 90;
/// Number of cells over theta_d.
pub const THETA_D_CELLS: usize = 90;
/// Number of cells over phi_d.
pub const PHI_D_CELLS: usize = 180;
/// Number of cells, and of values in each plane.
pub const CELLS: usize = THETA_H_CELLS * THETA_D_CELLS * PHI_D_CELLS;
/// Bytes before the first value.
const HEADER_BYTES: u64 = 12;
/// The size of every MERL file.
pub const FILE_BYTES: u64 = HEADER_BYTES + 3 * 8 * CELLS as u64;
/// What a stored value is multiplied by, for R, G and B.
pub const SCALES: [f64; 3] = [1.0 / 1500.0, 1.15 / 1500.0, 1.66 / 1500.0];
/// Largest f, in sr^-1, that is taken for a measurement.
///
/// A mirror that reflects all light into one cell around the normal has about 2e6; with a margin for grazing angles anything
/// beyond this bound is a damaged file, and everything below it can be summed and squared without overflow.
pub const LARGEST: f64 = 1e15;

const PLANES: [&str; 3] = ["R", "G", "B"];

/// theta_h at which cell `i` starts, radians; `i` up to [`THETA_H_CELLS`].
pub fn theta_h_edge(i: usize) -> f64 {
    let root = i as f64 / THETA_H_CELLS as f64;
    FRAC_PI_2 * (root * root)
}

/// theta_d at which cell `j` starts, radians; `j` up to [`THETA_D_CELLS`].
pub fn theta_d_edge(j: usize) -> f64 {
    FRAC_PI_2 * (j as f64 / THETA_D_CELLS as f64)
}

/// phi_d at which cell `k` starts, radians; `k` up to [`PHI_D_CELLS`].
pub fn phi_d_edge(k: usize) -> f64 {
    PI * (k as f64 / PHI_D_CELLS as f64)
}

/// The cell of theta_h [pbrt 2010, section 8.6.2], radians; the last one beyond pi/2.
pub fn theta_h_cell(theta_h: f64) -> usize {
    // a conversion to an integer takes NaN and what is negative to 0
    ((THETA_H_CELLS as f64 * (theta_h / FRAC_PI_2).sqrt()) as usize).min(THETA_H_CELLS - 1)
}

/// The cell of theta_d, radians; the last one beyond pi/2.
pub fn theta_d_cell(theta_d: f64) -> usize {
    ((THETA_D_CELLS as f64 * (theta_d / FRAC_PI_2)) as usize).min(THETA_D_CELLS - 1)
}

/// The cell of phi_d in [0, pi], radians; the last one beyond pi.
pub fn phi_d_cell(phi_d: f64) -> usize {
    ((PHI_D_CELLS as f64 * (phi_d / PI)) as usize).min(PHI_D_CELLS - 1)
}

/// The directions (wo, wi) of half and difference angles in radians, with h in the plane of x and z.
///
/// wi = cos theta_d h + sin theta_d (cos phi_d x_h + sin phi_d y), wo the same with phi_d + pi, where
/// x_h = (cos theta_h, 0, -sin theta_h). One of them may lie below the surface.
pub fn directions(theta_h: f64, theta_d: f64, phi_d: f64) -> (DVec3, DVec3) {
    let (h, d) = (Polar::from_angle(theta_h), Polar::from_angle(theta_d));
    let along = d.cos * DVec3::new(h.sin, 0.0, h.cos);
    let x_h = DVec3::new(h.cos, 0.0, -h.sin);
    let across = d.sin * (libm::cos(phi_d) * x_h + libm::sin(phi_d) * DVec3::Y);
    (along - across, along + across)
}

/// The content of a MERL file: f in sr^-1 per cell.
///
/// Cells are kept as `f64`, as large as the file: a table in memory is then exactly what the file says, and an integral of
/// it owes nothing to storage; with `f32` half the memory would do, and every stated error would carry 6e-8 of f.
pub struct MerlTable {
    /// R, G, B of a cell together, because a lookup wants all three.
    cells: Vec<[f64; 3]>,
    channels: Channels,
    invalid: u64,
    sha256: String,
}

impl MerlTable {
    /// Reads the file at `path`.
    ///
    /// Its size is checked before anything is read or allocated.
    ///
    /// # Errors
    /// [`MeasuredError`] when the file cannot be read, is not 34,992,012 bytes long, has other counts than 90, 90, 180, or
    /// holds a value that is not finite or beyond [`LARGEST`].
    pub fn read(path: impl AsRef<Path>) -> Result<Self, MeasuredError> {
        let path = path.as_ref();
        let name = path.display().to_string();
        let (file, length) = regular::open(path).map_err(|reason| MeasuredError::Unreadable {
            path: name.clone(),
            reason,
        })?;
        if length != FILE_BYTES {
            return Err(wrong_size(&name, length));
        }
        Self::read_from(file, &name)
    }

    /// Reads the content of a file from `source`, at most one byte more than a file has; errors call it `name`.
    ///
    /// # Errors
    /// As [`MerlTable::read`].
    pub fn read_from(source: impl Read, name: &str) -> Result<Self, MeasuredError> {
        let mut source = Source {
            bytes: source.take(FILE_BYTES + 1),
            position: 0,
            hash: Sha256::new(),
            name,
        };
        source.header()?;
        let mut cells = vec![[0.0; 3]; CELLS];
        let mut invalid = 0;
        let mut buffer = vec![0; 8 * BLOCK];
        for (plane, scale) in SCALES.into_iter().enumerate() {
            for (block, cells) in cells.chunks_mut(BLOCK).enumerate() {
                let bytes = &mut buffer[..8 * cells.len()];
                source.fill(bytes)?;
                for (index, (cell, word)) in cells.iter_mut().zip(bytes.as_chunks().0).enumerate() {
                    let stored = f64::from_le_bytes(*word);
                    let value = stored * scale;
                    if value.is_nan() || value.abs() > LARGEST {
                        return Err(refused_value(name, plane, block * BLOCK + index, stored));
                    }
                    if stored < 0.0 {
                        invalid += 1;
                    } else {
                        cell[plane] = value.abs(); // no -0
                    }
                }
            }
        }
        let sha256 = source.finish()?;
        let channels = Self::unify(&mut cells);
        Ok(Self {
            cells,
            channels,
            invalid,
            sha256,
        })
    }

    /// Grey, with the three values of each cell made the same, when they are equal to the rounding of their scales.
    fn unify(cells: &mut [[f64; 3]]) -> Channels {
        let same = |a: f64, b: f64| (a - b).abs() <= 4.0 * f64::EPSILON * a;
        if cells.iter().any(|[r, g, b]| !same(*r, *g) || !same(*r, *b)) {
            return Channels::Rgb;
        }
        cells.iter_mut().for_each(|cell| *cell = [cell[0]; 3]);
        Channels::Grey
    }

    /// All cells in the order of the file: k + 180 (j + 90 i).
    pub fn cells(&self) -> &[[f64; 3]] {
        &self.cells
    }

    /// f in sr^-1 in the cell (i, j, k) of (theta_h, theta_d, phi_d).
    ///
    /// # Panics
    /// Never for indices that the `_cell` functions return.
    pub fn at(&self, i: usize, j: usize, k: usize) -> DVec3 {
        DVec3::from_array(self.cells[k + PHI_D_CELLS * (j + THETA_D_CELLS * i)])
    }

    /// Grey when the planes, scaled, are equal.
    pub fn channels(&self) -> Channels {
        self.channels
    }

    /// How many of the 4,374,000 values are negative, marked as invalid, and count as 0.
    pub fn invalid(&self) -> u64 {
        self.invalid
    }

    /// SHA-256 of the file's bytes, in hexadecimal.
    pub fn sha256(&self) -> &str {
        &self.sha256
    }
}

/// A million values are of no use in a message.
impl fmt::Debug for MerlTable {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut about = formatter.debug_struct("MerlTable");
        about.field("channels", &self.channels).field("invalid", &self.invalid);
        about.field("sha256", &self.sha256).finish_non_exhaustive()
    }
}

/// Tables are equal when the files are.
impl PartialEq for MerlTable {
    fn eq(&self, other: &Self) -> bool {
        self.sha256 == other.sha256
    }
}

/// Values that are read at once.
const BLOCK: usize = 8192;

/// Bytes that are counted and hashed as they are read.
struct Source<'a, R> {
    bytes: io::Take<R>,
    position: u64,
    hash: Sha256,
    name: &'a str,
}

impl<R: Read> Source<'_, R> {
    /// Reads all of `buffer`.
    fn fill(&mut self, buffer: &mut [u8]) -> Result<(), MeasuredError> {
        let mut filled = 0;
        while filled < buffer.len() {
            let count = self.some(&mut buffer[filled..])?;
            if count == 0 {
                return Err(wrong_size(self.name, self.position));
            }
            filled += count;
        }
        self.hash.update(buffer);
        Ok(())
    }

    /// Reads some bytes, none at the end.
    fn some(&mut self, buffer: &mut [u8]) -> Result<usize, MeasuredError> {
        loop {
            match self.bytes.read(buffer) {
                Ok(count) => {
                    self.position += count as u64;
                    return Ok(count);
                }
                Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
                Err(reason) => {
                    let path = self.name.to_owned();
                    return Err(MeasuredError::Unreadable { path, reason });
                }
            }
        }
    }

    fn header(&mut self) -> Result<(), MeasuredError> {
        let mut header = [0; HEADER_BYTES as usize];
        self.fill(&mut header)?;
        let allowed = [THETA_H_CELLS, THETA_D_CELLS, PHI_D_CELLS];
        for (index, (word, allowed)) in header.as_chunks().0.iter().zip(allowed).enumerate() {
            let count = i32::from_le_bytes(*word);
            if i64::from(count) != allowed as i64 {
                let what = ["theta_h", "theta_d", "phi_d"][index];
                return Err(MeasuredError::Refused {
                    path: self.name.to_owned(),
                    place: format!("byte {}", 4 * index + 1),
                    what: format!("{count} cells over {what} are not allowed: a MERL file has {allowed}"),
                });
            }
        }
        Ok(())
    }

    /// SHA-256 of everything, when nothing is left.
    fn finish(mut self) -> Result<String, MeasuredError> {
        if self.some(&mut [0])? > 0 {
            return Err(wrong_size(self.name, self.position));
        }
        let hash = self.hash.finalize();
        Ok(hash.iter().map(|byte| format!("{byte:02x}")).collect())
    }
}

fn wrong_size(name: &str, bytes: u64) -> MeasuredError {
    MeasuredError::Size {
        path: name.to_owned(),
        bytes,
        allowed: format!("a MERL file has {FILE_BYTES}, 90 x 90 x 180 cells of three values"),
    }
}

fn refused_value(name: &str, plane: usize, index: usize, stored: f64) -> MeasuredError {
    let (k, j) = (index % PHI_D_CELLS, index / PHI_D_CELLS % THETA_D_CELLS);
    let i = index / (PHI_D_CELLS * THETA_D_CELLS);
    let byte = HEADER_BYTES + 8 * (plane * CELLS + index) as u64 + 1;
    let plane_name = PLANES[plane];
    let most = LARGEST / SCALES[plane];
    MeasuredError::Refused {
        path: name.to_owned(),
        place: format!("byte {byte}, value {} of plane {plane_name}", index + 1),
        what: format!(
            "{stored:e} at theta_h {i}, theta_d {j}, phi_d {k} is not allowed: values are finite and at most {most:.1e} \
             in size, negative ones mark invalid samples"
        ),
    }
}

/// Writes a MERL file of the model `f(theta_h, theta_d, phi_d)`, in sr^-1 at the centre of each cell, angles in radians;
/// `None` marks the three values of the cell as invalid, with -1.
///
/// The centre is half way between the cell's edges, in theta_h half way between their square roots. The model is asked once
/// per cell. [`directions`] turns the angles into the directions that other models take.
///
/// # Errors
/// What `to` reports, and [`io::ErrorKind::InvalidInput`] for a value that [`MerlTable::read`] would not take as it is: one
/// that is negative, not finite, or above [`LARGEST`].
pub fn write_merl(to: impl Write, f: impl Fn(f64, f64, f64) -> Option<[f64; 3]>) -> io::Result<()> {
    let mut to = BufWriter::with_capacity(8 * BLOCK, to);
    for count in [THETA_H_CELLS, THETA_D_CELLS, PHI_D_CELLS] {
        to.write_all(&(count as i32).to_le_bytes())?;
    }
    let mut later = Vec::with_capacity(CELLS);
    for i in 0..THETA_H_CELLS {
        let root = (i as f64 + 0.5) / THETA_H_CELLS as f64;
        let theta_h = FRAC_PI_2 * (root * root);
        for j in 0..THETA_D_CELLS {
            let theta_d = FRAC_PI_2 * ((j as f64 + 0.5) / THETA_D_CELLS as f64);
            for k in 0..PHI_D_CELLS {
                let phi_d = PI * ((k as f64 + 0.5) / PHI_D_CELLS as f64);
                let [r, g, b] = match f(theta_h, theta_d, phi_d) {
                    Some(rgb) => stored(rgb, [i, j, k])?,
                    None => [-1.0; 3],
                };
                to.write_all(&r.to_le_bytes())?;
                later.push([g, b]);
            }
        }
    }
    for plane in 0..2 {
        for values in &later {
            to.write_all(&values[plane].to_le_bytes())?;
        }
    }
    to.flush()
}

/// The values to store for f = `rgb`.
fn stored(rgb: [f64; 3], [i, j, k]: [usize; 3]) -> io::Result<[f64; 3]> {
    if let Some(value) = rgb.into_iter().find(|value| !(0.0..=LARGEST).contains(value)) {
        let message = format!(
            "f = {value:e} at theta_h {i}, theta_d {j}, phi_d {k} is not allowed: a MERL file holds 0 to {LARGEST:e}"
        );
        return Err(io::Error::new(io::ErrorKind::InvalidInput, message));
    }
    Ok([rgb[0] / SCALES[0], rgb[1] / SCALES[1], rgb[2] / SCALES[2]])
}

#[cfg(test)]
pub(crate) mod tests;
