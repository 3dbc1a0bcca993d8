//! Files written, read back and damaged.

use super::*;
use std::fs::File;
use std::sync::Arc;

/// The table of a model, by way of a file in memory.
pub(crate) fn table_of(f: impl Fn(f64, f64, f64) -> Option<[f64; 3]>) -> Arc<MerlTable> {
    let mut bytes = Vec::with_capacity(FILE_BYTES as usize);
    write_merl(&mut bytes, f).unwrap();
    Arc::new(MerlTable::read_from(&bytes[..], "memory").unwrap())
}

/// A diffuse base with a glossy lobe; samples near the horizon are invalid.
fn model(theta_h: f64, theta_d: f64, phi_d: f64) -> Option<[f64; 3]> {
    let (wo, wi) = directions(theta_h, theta_d, phi_d);
    let lobe = theta_h.cos().powi(40) * (1.0 + 0.1 * theta_d);
    (wo.z.min(wi.z) > 0.05).then_some([0.1 + lobe, 0.2 + lobe, 0.05 + 2.0 * lobe])
}

#[test]
fn edges_and_cells_are_inverse() {
    for i in 0..90 {
        let middle = |edge: fn(usize) -> f64| 0.5 * (edge(i) + edge(i + 1));
        assert_eq!(theta_h_cell(middle(theta_h_edge)), i);
        assert_eq!(theta_d_cell(middle(theta_d_edge)), i);
        assert_eq!(phi_d_cell(middle(phi_d_edge)), i);
    }
    for angle in [-1.0, 0.0, 1e-300, FRAC_PI_2, 3.2, 1e300, f64::INFINITY, f64::NAN] {
        assert!(theta_h_cell(angle) < 90 && theta_d_cell(angle) < 90 && phi_d_cell(angle) < 180);
    }
}

#[test]
fn a_written_model_is_read_back() {
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("model.binary");
    write_merl(File::create(&path).unwrap(), model).unwrap();
    let bytes = std::fs::read(&path).unwrap();
    assert_eq!(bytes.len() as u64, FILE_BYTES);
    let table = MerlTable::read(&path).unwrap();
    let hash: String = Sha256::digest(&bytes)
        .iter()
        .map(|byte| format!("{byte:02x}"))
        .collect();
    assert_eq!(table.sha256(), hash);
    assert_eq!(table.channels(), Channels::Rgb);
    let mut invalid = 0;
    for index in (0..CELLS).step_by(7) {
        let (i, j, k) = (index / 16200, index / 180 % 90, index % 180);
        let theta_h = FRAC_PI_2 * ((i as f64 + 0.5) / 90.0).powi(2);
        let (theta_d, phi_d) = ((j as f64 + 0.5).to_radians(), (k as f64 + 0.5).to_radians());
        let expected = model(theta_h, theta_d, phi_d).map_or(DVec3::ZERO, DVec3::from_array);
        invalid += u64::from(expected == DVec3::ZERO);
        // the quotient and the product by a scale round once each, angles in degrees a few times
        assert!((table.at(i, j, k) - expected).abs().max_element() < 1e-13 * expected.x.max(1.0));
        assert_eq!(table.cells()[index], table.at(i, j, k).to_array());
    }
    assert!(table.invalid().is_multiple_of(3));
    // a seventh of all cells, and some that rounding tips over the border of validity
    let sevenths = table.invalid() as f64 / 21.0;
    assert!((invalid as f64 / sevenths - 1.0).abs() < 1e-2, "{invalid} {sevenths}");

    // one byte more or less, without reading: the size is all that matters
    let file = File::options().append(true).open(&path).unwrap();
    for length in [0, 1, 12, 13, FILE_BYTES - 1, FILE_BYTES + 1, 1 << 40] {
        file.set_len(length).unwrap(); // extends by a hole
        let error = MerlTable::read(&path).unwrap_err();
        assert!(
            matches!(error, MeasuredError::Size { bytes, .. } if bytes == length),
            "{error}"
        );
    }
    let error = MerlTable::read(directory.path()).unwrap_err();
    assert!(matches!(error, MeasuredError::Unreadable { .. }), "{error}");
    let error = MerlTable::read(directory.path().join("none")).unwrap_err();
    assert!(matches!(error, MeasuredError::Unreadable { .. }), "{error}");
}

#[test]
fn equal_planes_are_grey() {
    let table = table_of(|_, _, phi| Some([0.1 + phi / 3.0; 3]));
    assert_eq!((table.channels(), table.invalid()), (Channels::Grey, 0));
    assert!(table.cells().iter().all(|[r, g, b]| r == g && r == b));
}

fn refusal(bytes: &[u8]) -> String {
    MerlTable::read_from(bytes, "x.binary").unwrap_err().to_string()
}

#[test]
fn streams_of_any_wrong_length_are_refused() {
    let mut bytes = Vec::new();
    write_merl(&mut bytes, |_, _, _| Some([0.25; 3])).unwrap();
    for length in [0, 1, 11, 12, 13, 19, 20, 65_548, 11_664_012, 20_000_001, 34_992_011] {
        let message = refusal(&bytes[..length]);
        assert!(
            message.starts_with(&format!("x.binary: {length} bytes are not allowed")),
            "{message}"
        );
    }
    // an endless stream is given up after one byte too many
    let endless = (&bytes[..]).chain(io::repeat(0));
    let error = MerlTable::read_from(endless, "x").unwrap_err();
    assert!(
        matches!(error, MeasuredError::Size { bytes, .. } if bytes == FILE_BYTES + 1),
        "{error}"
    );
}

#[test]
fn damage_is_named_with_its_place() {
    let mut bytes = Vec::new();
    write_merl(&mut bytes, |_, _, _| Some([0.25; 3])).unwrap();
    for (at, name) in [(0, "theta_h"), (4, "theta_d"), (8, "phi_d")] {
        for wrong in [0, -1, 89, i32::MIN, i32::MAX] {
            let mut header = bytes[..12].to_vec();
            header[at..at + 4].copy_from_slice(&wrong.to_le_bytes());
            let message = refusal(&header);
            assert!(
                message.starts_with(&format!("x.binary: byte {}: {wrong} cells over {name}", at + 1)),
                "{message}"
            );
        }
    }
    let places = [(0, 0), (0, CELLS - 1), (1, 181), (2, CELLS - 1)];
    for ((plane, index), wrong) in places
        .into_iter()
        .zip([f64::NAN, f64::INFINITY, f64::NEG_INFINITY, -1e300])
    {
        let at = 12 + 8 * (plane * CELLS + index);
        let kept: [u8; 8] = bytes[at..at + 8].try_into().unwrap();
        bytes[at..at + 8].copy_from_slice(&wrong.to_le_bytes());
        let message = refusal(&bytes);
        let place = format!(
            "x.binary: byte {}, value {} of plane {}: ",
            at + 1,
            index + 1,
            PLANES[plane]
        );
        assert!(message.starts_with(&place), "{message}");
        bytes[at..at + 8].copy_from_slice(&kept);
    }
    // negative ones are counted, one by one, and -0 is not negative
    for (index, value) in [(5, -1.0), (CELLS + 5, -1e-300), (2 * CELLS, -0.0)] {
        bytes[12 + 8 * index..20 + 8 * index].copy_from_slice(&f64::to_le_bytes(value));
    }
    let table = MerlTable::read_from(&bytes[..], "x").unwrap();
    assert_eq!((table.invalid(), table.channels()), (2, Channels::Rgb));
    assert_eq!((table.cells()[5][0], table.cells()[5][1]), (0.0, 0.0));
    assert!((table.cells()[5][2] - 0.25).abs() < 1e-16);
}

#[test]
fn the_writer_refuses_what_the_reader_would_not_give_back() {
    for wrong in [-0.1, f64::NAN, f64::INFINITY, 2.0 * LARGEST] {
        let error = write_merl(io::sink(), |_, _, _| Some([0.1, wrong, 0.1])).unwrap_err();
        assert_eq!(error.kind(), io::ErrorKind::InvalidInput, "{error}");
    }
}
