//! A table in a further format, beside the OpenEXR file that holds the error of every texel.

use super::{Format, FormatError, files};
use crate::export::manifest::FileEntry;
use crate::export::sha256_hex;
use crate::table::texture::Texture;
use crate::table::{Storage, Table};

/// The files of `table` in `format` with values rounded to `storage`, and what a manifest says of each.
///
/// # Errors
/// [`FormatError`] when a value does not fit the storage, or the format cannot hold the table.
pub fn beside(table: &Table, format: Format, storage: Storage) -> Result<Vec<(FileEntry, Vec<u8>)>, FormatError> {
    let mut texture = Texture::of(table, storage)?;
    let lookup_error = lookup_error(table, &texture);
    texture.facts.extend(stated(table, &texture, lookup_error));
    let written = files(&texture, format)?.into_iter();
    let entry = |(file, bytes): (String, Vec<u8>)| {
        let entry = FileEntry {
            file,
            format: format.name().into(),
            storage: storage.name().into(),
            bytes: bytes.len() as u64,
            sha256: sha256_hex(&bytes),
            lookup_error,
        };
        (entry, bytes)
    };
    Ok(written.map(entry).collect())
}

/// The files of a table in the formats, see [`beside`].
///
/// # Errors
/// Those of [`beside`].
pub fn all_beside(table: &Table, formats: &[(Format, Storage)]) -> Result<Vec<(FileEntry, Vec<u8>)>, FormatError> {
    let mut all = Vec::new();
    for (format, storage) in formats {
        all.extend(beside(table, *format, *storage)?);
    }
    Ok(all)
}

/// Largest difference between a texel of the texture and that of the file of its table. Lookups weigh texels by shares that add up
/// to 1, so that none is off by more.
fn rounding(table: &Table, texture: &Texture) -> f64 {
    let stored = (0..table.values.len()).flat_map(|i| table.channels.of(table.stored(i)));
    let differences = stored
        .zip(&texture.values)
        .map(|(stored, value)| (stored - value).abs());
    differences.fold(0.0, f64::max)
}

/// Bound of the error of a lookup in `texture`: that of `table`, and what rounding adds; `None` where the former was not measured
/// or is not bounded.
fn lookup_error(table: &Table, texture: &Texture) -> Option<f64> {
    let of_table = match &table.between {
        Some(between) => between.error,
        // one texel, wherever a lookup reads
        None if table.axes.is_empty() => table.max_texel_error(),
        None => return None,
    };
    let rounding = rounding(table, texture);
    let sum = of_table + rounding;
    // a sum of two positive numbers may itself have been rounded down
    let sum = if rounding == 0.0 { sum } else { sum.next_up() };
    sum.is_finite().then_some(sum)
}

/// The errors as facts.
fn stated(table: &Table, texture: &Texture, lookup_error: Option<f64>) -> Vec<(String, String)> {
    let mut facts = vec![
        (
            "texel error of the table",
            format!("{:e} ({})", table.max_texel_error(), table.error_kind.name()),
        ),
        (
            "rounding",
            format!("at most {:e} to {}", rounding(table, texture), texture.storage.name()),
        ),
        (
            "lookup error",
            match lookup_error {
                Some(error) => format!("at most {error:e}, that of the table and rounding"),
                None if table.between.is_some() => "unbounded".into(),
                None => "not measured".into(),
            },
        ),
    ];
    if let Some(between) = table.between.as_ref().filter(|between| between.error.is_finite()) {
        let found = format!("{:e}, the largest of {} places", between.error, between.probes);
        facts.insert(1, ("lookup error of the table", found));
    }
    let owned = facts.into_iter().map(|(name, value)| (name.to_owned(), value));
    owned.collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::table::samples::{grey_2d, rgb_1d, scalar};

    /// The stated error is that of the file's lookups: nowhere is the texture further from the table than rounding says.
    #[test]
    fn rounding_bounds_every_lookup() {
        let table = rgb_1d();
        for storage in Storage::ALL {
            let texture = Texture::of(&table, storage).unwrap();
            let rounding = rounding(&table, &texture);
            let a_priori = storage.rounding(1.0);
            assert!(rounding <= a_priori && (rounding > 0.0) == (storage != Storage::F32));
            for i in 0..=1000 {
                let place = [f64::from(i) / 1000.0];
                let exact = table.channels.of(table.sample(&place));
                for (found, exact) in texture.lookup(&place).iter().zip(exact) {
                    // the sums of both lookups round
                    assert!((found - exact).abs() <= rounding + 1e-15, "{storage:?} {place:?}");
                }
            }
            let stated = lookup_error(&table, &texture).unwrap();
            assert!(stated >= table.max_lookup_error() + rounding && stated <= 1.0 / 7.0 + a_priori + 1e-15);
        }
    }

    #[test]
    fn what_is_not_known_is_not_said() {
        let mut table = grey_2d();
        let stated = |table: &Table| {
            let all = beside(table, Format::Ktx2, Storage::F16).unwrap();
            all[0].0.lookup_error
        };
        assert!(stated(&table).is_some());
        table.between.as_mut().unwrap().error = f64::INFINITY;
        assert_eq!(stated(&table), None);
        table.between = None;
        assert_eq!(stated(&table), None);
        assert!(stated(&scalar()).unwrap() >= 2.5e-7);
    }
}
