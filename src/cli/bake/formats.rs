//! Tables in further formats.

use super::Baked;
use crate::cli::{Failure, format};
use clap::Args;
use std::collections::{BTreeSet, HashMap};
use whitefurnace::engine::{Profile, Sheet};
use whitefurnace::export::formats::beside::all_beside;
use whitefurnace::export::formats::{Format, identifier};
use whitefurnace::export::store::Store;
use whitefurnace::printable::printable;
use whitefurnace::table::Storage;

/// Which formats, and what they keep values in.
#[derive(Debug, Args)]
pub(super) struct Formats {
    /// Formats to write, separated by commas: exr, ktx2, dds, png, raw, c, rust, glsl, hlsl, wgsl. The exr of a scene's tables is
    /// written always, as f32 with the error of every texel; a profile has a format of its own, which this replaces.
    #[arg(long, value_name = "LIST", value_delimiter = ',', value_parser = parse_format)]
    format: Vec<Format>,
    /// What the other formats keep a value in: f32, f16, unorm16 or unorm8. By default f16 for ktx2, dds and raw, unorm16 for png,
    /// which takes unorm16 and unorm8 only, and f32 for c, rust, glsl, hlsl and wgsl.
    #[arg(long, value_name = "STORAGE", value_parser = parse_storage)]
    storage: Option<Storage>,
}

fn parse_format(name: &str) -> Result<Format, String> {
    let names: Vec<&str> = Format::ALL.into_iter().map(Format::name).collect();
    let shown = if name.is_empty() {
        "an empty name".into()
    } else {
        printable(name)
    };
    Format::from_name(name).ok_or_else(|| format!("{shown} is none of {}", names.join(", ")))
}

fn parse_storage(name: &str) -> Result<Storage, String> {
    let names: Vec<&str> = Storage::ALL.into_iter().map(Storage::name).collect();
    Storage::from_name(name).ok_or_else(|| format!("{} is none of {}", printable(name), names.join(", ")))
}

impl Formats {
    /// The formats of the tables of an engine that replace its own; none where it keeps those.
    pub(super) fn of_profile(&self) -> Result<Vec<Format>, Failure> {
        let refused = self
            .format
            .iter()
            .find(|format| self.storage.is_some_and(|storage| !format.takes(storage)));
        match (refused, self.storage) {
            (Some(format), Some(storage)) => Err(not_taken(*format, storage)),
            _ => {
                let mut formats = Vec::new();
                for format in &self.format {
                    if !formats.contains(format) {
                        formats.push(*format);
                    }
                }
                Ok(formats)
            }
        }
    }

    /// Refuses formats that cannot hold the tables of an engine, before the work.
    pub(super) fn check_sheets(&self, profile: Profile, sheets: &[Sheet]) -> Result<(), Failure> {
        for (format, sheet) in self
            .format
            .iter()
            .flat_map(|format| sheets.iter().map(move |sheet| (format, sheet)))
        {
            let storage = self.storage.unwrap_or(sheet.storage);
            if !format.takes(storage) {
                let (profile, sheet, storage, format) = (profile.name(), sheet.name, storage.name(), *format);
                let takes = allowed(format);
                return Err(format!(
                    "{profile} keeps {sheet} in {storage}, which is not allowed with --format {}: add --storage {takes}, or choose another \
                     format",
                    format.name()
                )
                .into());
            }
        }
        Ok(())
    }

    /// What replaces the storage of an engine.
    pub(super) fn storage(&self) -> Option<Storage> {
        self.storage
    }

    /// The formats beside the EXR, each once, with the storage of each.
    pub(super) fn wanted(&self) -> Result<Vec<(Format, Storage)>, Failure> {
        let mut wanted: Vec<(Format, Storage)> = Vec::new();
        for &format in self.format.iter().filter(|format| **format != Format::Exr) {
            let storage = self.storage.unwrap_or(format.default_storage());
            if !format.takes(storage) {
                return Err(not_taken(format, storage));
            }
            if !wanted.contains(&(format, storage)) {
                wanted.push((format, storage));
            }
        }
        match self.storage {
            Some(storage) if wanted.is_empty() => Err(format!(
                "--storage {} is not allowed with --format exr alone: the EXR of a table is f32; choose another format beside it",
                storage.name()
            )
            .into()),
            _ => Ok(wanted),
        }
    }
}

fn not_taken(format: Format, storage: Storage) -> Failure {
    format!(
        "--storage {} is not allowed with --format {}: choose --storage {}, or another format",
        storage.name(),
        format.name(),
        allowed(format)
    )
    .into()
}

/// The storages that a format takes.
fn allowed(format: Format) -> String {
    let takes = Storage::ALL.into_iter().filter(|storage| format.takes(*storage));
    takes.map(Storage::name).collect::<Vec<_>>().join(" or ")
}

/// Refuses tables whose source text would have the same identifiers: a compiler takes the first and drops the second without a word.
pub(super) fn check_identifiers<'a>(
    ids: impl Iterator<Item = &'a str>,
    formats: &[(Format, Storage)],
) -> Result<(), Failure> {
    let is_source = |(format, _): &&(Format, Storage)| matches!(format, Format::Source(_));
    let Some((format, _)) = formats.iter().find(is_source) else {
        return Ok(());
    };
    let mut taken: HashMap<String, &str> = HashMap::new();
    for id in ids {
        // guards of headers are in capitals
        if let Some(other) = taken.insert(identifier(id).to_ascii_uppercase(), id) {
            return Err(format!(
                "--format {}: the tables {} and {} would have the same identifiers in source text: rename a material",
                format.name(),
                printable(other),
                printable(id)
            )
            .into());
        }
    }
    Ok(())
}

/// Writes the finished tables in these formats under temporary names, and lists them in their entries.
///
/// One table after the other is read again: all of them need not be in memory at once, and those that were found are treated like
/// those that were computed.
pub(super) fn put_aside(
    store: &Store,
    keys: &[String],
    baked: &mut [Baked],
    formats: &[(Format, Storage)],
) -> Result<(), Failure> {
    if formats.is_empty() {
        return Ok(());
    }
    for (Baked { entry, .. }, key) in baked.iter_mut().zip(keys) {
        let table = store.kept(key, entry)?;
        for (file, bytes) in all_beside(&table, formats)? {
            store.put_aside(&file, &bytes)?;
            entry.files.push(file);
        }
    }
    Ok(())
}

/// Whether file names of some format end so.
pub(super) fn is_extension(end: &str) -> bool {
    Format::ALL.iter().any(|format| format.extensions().contains(&end))
}

/// A line for each format: files, bytes, and the largest error of a lookup.
pub(super) fn lines(baked: &[Baked], tolerance: Option<f64>) -> Vec<String> {
    let files = || baked.iter().flat_map(|baked| &baked.entry.files);
    let kinds: BTreeSet<(&str, &str)> = files()
        .map(|file| (file.format.as_str(), file.storage.as_str()))
        .collect();
    let line = |(kind, storage): (&str, &str)| {
        let of_kind = || files().filter(|file| file.format == kind && file.storage == storage);
        let bytes: u64 = of_kind().map(|file| file.bytes).sum();
        // not measured or not bounded
        let errors = of_kind().map(|file| file.lookup_error.unwrap_or(f64::INFINITY));
        let largest = errors.fold(0.0, f64::max);
        let more = match tolerance {
            Some(tolerance) if largest > tolerance => {
                format!(
                    ", more than {tolerance:e}: rounding adds to what the EXR has; choose --storage f32, or a smaller --tolerance"
                )
            }
            _ => String::new(),
        };
        format!(
            "{kind} in {storage}: {}, {} KiB, lookups off by up to {}{more}.",
            format::counted(of_kind().count(), "file"),
            bytes.div_ceil(1024),
            format::error(largest),
        )
    };
    kinds.into_iter().map(line).collect()
}
