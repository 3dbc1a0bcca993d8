//! Tables in further formats: written under temporary names while nothing is published, and renamed with the tables.

use super::entries::{content, entry_name};
use super::{Store, read_exr};
use crate::export::formats::FormatError;
use crate::export::manifest::{self, FileEntry, Manifest, TableEntry};
use crate::export::read::Contents;
use crate::export::write::{PART, check_replaceable};
use crate::export::{ExportError, sha256_hex};
use crate::table::Table;
use std::collections::HashSet;
use std::fs::{self, File};
use std::io::{self, ErrorKind};
use std::path::{Path, PathBuf};

impl Store {
    /// The table that was kept, or found, with this `key` and the hash in `entry`, under the name in `entry`.
    ///
    /// # Errors
    /// [`ExportError`] when somebody has taken the file away or changed it.
    pub fn kept(&self, key: &str, entry: &TableEntry) -> Result<Table, ExportError> {
        let path = self.cache().join(entry_name(key, &entry.sha256));
        let read = read_exr(&path)?;
        match read.contents {
            Contents::Table { mut table, .. } if read.sha256 == entry.sha256 => {
                table.id.clone_from(&entry.id);
                Ok(*table)
            }
            _ => Err(ExportError::Unreadable {
                path,
                reason: "it is not the table that was written: bake again".into(),
            }),
        }
    }

    /// Writes a file under a temporary name, until [`Store::publish`] gives it the one in `entry`; nothing where it is in place.
    ///
    /// # Errors
    /// [`ExportError::Io`] with the path.
    pub fn put_aside(&self, entry: &FileEntry, bytes: &[u8]) -> Result<(), ExportError> {
        let _finished = self.finished();
        if is_in_place(&self.directory.join(&entry.file), entry) {
            return Ok(());
        }
        let part = self.part_of(entry);
        let write = || -> io::Result<()> {
            drop(fs::remove_file(&part)); // whatever stands there, it is not followed
            io::Write::write_all(&mut File::create_new(&part)?, bytes)
        };
        write().map_err(ExportError::io("write", &part))
    }

    fn part_of(&self, entry: &FileEntry) -> PathBuf {
        self.cache().join(format!("{}{PART}", entry.file))
    }

    /// Adds the files in further formats that are not in place to what is to be renamed.
    pub(super) fn stage_textures(
        &self,
        manifest: &Manifest,
        staged: &mut Vec<(PathBuf, PathBuf)>,
    ) -> Result<(), ExportError> {
        check_names(manifest)?;
        for entry in manifest.tables.iter().flat_map(|table| &table.files) {
            let to = self.directory.join(&entry.file);
            if is_in_place(&to, entry) {
                continue;
            }
            check_replaceable(&to)?;
            let part = self.part_of(entry);
            let sync = File::open(&part).and_then(|file| file.sync_all());
            sync.map_err(|source| match source.kind() {
                ErrorKind::NotFound => ExportError::Vanished { path: part.clone() },
                _ => ExportError::io("write", &part)(source),
            })?;
            staged.push((part, to));
        }
        Ok(())
    }
}

/// Whether the file at `path` is the one that `entry` speaks of.
fn is_in_place(path: &Path, entry: &FileEntry) -> bool {
    content(path, entry.bytes).is_some_and(|bytes| sha256_hex(&bytes) == entry.sha256)
}

/// Refuses two files of one name: the raw format of a table called `manifest` would replace the manifest.
fn check_names(manifest: &Manifest) -> Result<(), ExportError> {
    let mut names: HashSet<&str> = HashSet::from([manifest::FILE_NAME]);
    names.extend(manifest.tables.iter().map(|table| table.file.as_str()));
    for table in &manifest.tables {
        for file in &table.files {
            if !names.insert(&file.file) {
                return Err(FormatError::Taken {
                    id: table.id.clone(),
                    file: file.file.clone(),
                }
                .into());
            }
        }
    }
    Ok(())
}
