//! Finished tables in a cache beside the outputs, and how they come from there under their names.
//!
//! The directory [`CACHE`] within that of a bake holds each finished table as a file that is named by the [`key`] of what was
//! asked for and by the hash of its bytes, so that any bake knows what it finds, and finds out what is damaged. Whatever a table
//! is called, and whichever material uses it, one that was computed once is not computed again. What is in place under its name
//! is a hard link to the entry, which takes no room of its own, or a copy where the file system knows no links.
//!
//! While a bake runs, the tables of the last one stay as they are. When all are finished, each that is not in place yet is linked
//! under a temporary name, and the manifest is written beside them: a full disk is met here. Then everything is renamed into
//! place, the manifest last, and no data move any more. Killed at any moment, the directory holds whole files only: the old set,
//! or, among the few renames, some of the new set and no manifest. All of them are in the cache by then, and the next bake
//! begins the renames anew.
//!
//! Two bakes at once would take each other's files apart; a lock on the directory, which the system drops with the process,
//! keeps the second out.

mod entries;
#[cfg(test)]
mod tests;
mod textures;

use super::manifest::{self, Manifest, TableEntry};
use super::read::{Contents, read_exr};
use super::write::{PART, check_replaceable, create_dir, replaceable, sync_dir, write_checked_later, write_whole};
use super::{ExportError, FORMAT, VERSION, sha256_hex, shown};
use crate::printable::printable;
use crate::table::Table;
use entries::{Found, entry_name, holds, is_in_place, link_or_copy, short};
use std::collections::{HashMap, HashSet};
use std::fs::{self, File, TryLockError};
use std::io::{self, ErrorKind};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};
use thiserror::Error;

/// The cache, within the directory of a bake.
pub const CACHE: &str = ".furnace";

/// Most bytes that entries take together which no table of the manifest uses, unless [`Store::with_limit`] says otherwise.
pub const CACHE_BYTES: u64 = 256 << 20;

/// The key of a table: SHA-256 of the version of program and layout and of its `request`, everything that it depends on.
pub fn key(request: &str) -> String {
    sha256_hex(format!("whitefurnace {VERSION}, layout {FORMAT}\n{request}").as_bytes())
}

/// The directory of a bake and its cache, locked.
#[derive(Debug)]
pub struct Store {
    directory: PathBuf,
    /// Directories that did not exist before, deepest first.
    made: Vec<PathBuf>,
    /// Files by the keys of their tables, as they were found: those of the cache before those in place.
    found: HashMap<String, Vec<Found>>,
    /// Most bytes of entries that are not in use.
    limit: u64,
    uses_cache: bool,
    /// Holds the lock for as long as it is open.
    _lock: Option<File>,
    /// Locked while files are written.
    finished: Mutex<Finished>,
}

/// How far a bake has come.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Finished {
    /// Number of tables that are finished, those that were found so among them.
    pub tables: usize,
    /// Whether they have their names.
    pub published: bool,
}

/// A finished table and the hash of its file.
#[derive(Debug, Clone, PartialEq)]
pub struct Kept {
    /// The table as its file holds it.
    pub table: Table,
    /// Length of the file.
    pub bytes: u64,
    /// SHA-256 of the file.
    pub sha256: String,
}

/// What is known of a table before it is computed.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Lookup {
    /// The table, when it was computed before.
    pub kept: Option<Kept>,
    /// Files that should have held it.
    pub damaged: Vec<Damaged>,
}

/// A file that is not the table that was written. In the cache it is removed, in place it stays until it is replaced.
#[derive(Debug, Clone, PartialEq, Error)]
#[error("{} is damaged: {}", shown(path), printable(reason))]
pub struct Damaged {
    /// The file.
    pub path: PathBuf,
    /// What is wrong with it.
    pub reason: String,
}

impl Store {
    /// Makes the directory where it does not exist, locks it, and looks what it holds.
    ///
    /// # Errors
    /// [`ExportError::NotADirectory`], [`ExportError::Io`] naming the directory, and [`ExportError::Busy`] while another bake
    /// is at it.
    pub fn open(directory: &Path) -> Result<Self, ExportError> {
        let made = directory.ancestors().take_while(|part| !part.exists());
        let made = made.map(Path::to_path_buf).collect();
        create_dir(directory)?;
        let lock = lock(directory)?;
        let cache = directory.join(CACHE);
        if fs::symlink_metadata(&cache).is_ok_and(|about| about.is_symlink()) {
            let reason = "it is a symbolic link, and tables have to be kept beside those that they replace";
            return Err(ExportError::io("use", &cache)(io::Error::other(reason)));
        }
        create_dir(&cache)?;
        entries::sweep(&cache);
        let mut found: HashMap<String, Vec<Found>> = HashMap::new();
        let cached = entries::list(&cache).map_err(ExportError::io("read", &cache))?;
        for (key, file) in cached.into_iter().chain(entries::in_place(directory)) {
            found.entry(key).or_default().push(file);
        }
        Ok(Self {
            directory: directory.to_path_buf(),
            made,
            found,
            limit: CACHE_BYTES,
            uses_cache: true,
            _lock: lock,
            finished: Mutex::default(),
        })
    }

    /// Keeps at most so many bytes of entries that no table of the manifest uses.
    pub fn with_limit(self, bytes: u64) -> Self {
        Self { limit: bytes, ..self }
    }

    /// Finds nothing, and leaves no entries of its own tables once they are published.
    pub fn without_cache(self) -> Self {
        let uses_cache = false;
        Self { uses_cache, ..self }
    }

    /// Whether a later bake is meant to find what this one finished.
    pub fn uses_cache(&self) -> bool {
        self.uses_cache
    }

    fn cache(&self) -> PathBuf {
        self.directory.join(CACHE)
    }

    /// The finished table with this `key`, whole and as it was written, under the name `id`: from the cache, or in place under
    /// whatever name, from where it comes into the cache. `is_answer` refuses tables that somebody has put under the key of
    /// another.
    pub fn find(&self, key: &str, id: &str, is_answer: &dyn Fn(&Table) -> bool) -> Lookup {
        let mut lookup = Lookup::default();
        let files = self.found.get(short(key)).filter(|_| self.uses_cache);
        for file in files.into_iter().flatten() {
            match self.take(file, key, id, is_answer) {
                Ok(Some(kept)) => {
                    self.finished().tables += 1;
                    lookup.kept = Some(kept);
                    break;
                }
                Ok(None) => {}
                Err(reason) => {
                    if file.is_entry {
                        entries::remove(&file.path);
                    }
                    let path = file.path.clone();
                    lookup.damaged.push(Damaged { path, reason });
                }
            }
        }
        lookup
    }

    /// The table in `file`, which is an entry of the cache afterwards; `None` where it is gone, or cannot become one.
    fn take(
        &self,
        file: &Found,
        key: &str,
        id: &str,
        is_answer: &dyn Fn(&Table) -> bool,
    ) -> Result<Option<Kept>, String> {
        match fs::symlink_metadata(&file.path) {
            Err(error) if error.kind() == ErrorKind::NotFound => return Ok(None),
            // a link would lead out of the cache, and be in place what a table should be
            Ok(about) if file.is_entry && !about.is_file() => return Err("it is no regular file".into()),
            _ => {}
        }
        let read = read_exr(&file.path).map_err(|error| match error {
            ExportError::Io { source, .. } => source.to_string(),
            ExportError::Unreadable { reason, .. } => reason,
            other => other.to_string(),
        })?;
        if !read.sha256.starts_with(&file.hash) {
            return Err("its hash is not the one that was written".into());
        }
        let mut table = match read.contents {
            Contents::Table { table, .. } if is_answer(&table) => *table,
            _ => return Err("it is another table than it should be".into()),
        };
        if !file.is_entry {
            let (part, entry) = (self.cache().join(format!("found{PART}")), entry_name(key, &read.sha256));
            let adopted = link_or_copy(&file.path, &part).and_then(|()| fs::rename(&part, self.cache().join(entry)));
            if adopted.is_err() {
                return Ok(None);
            }
        }
        table.id = id.into();
        Ok(Some(Kept {
            table,
            bytes: read.bytes,
            sha256: read.sha256,
        }))
    }

    /// Keeps the file `bytes` of the table with this `key`, instead of whatever the cache had for it.
    ///
    /// # Errors
    /// [`ExportError::Io`] with the path; nothing but whole files is left.
    pub fn keep(&self, key: &str, bytes: &[u8]) -> Result<(), ExportError> {
        let mut finished = self.finished();
        let earlier = self.found.get(short(key)).into_iter().flatten();
        for file in earlier.filter(|file| file.is_entry) {
            entries::remove(&file.path);
        }
        write_checked_later(&self.cache().join(entry_name(key, &sha256_hex(bytes))), bytes)?;
        finished.tables += 1;
        Ok(())
    }

    /// Puts all tables of `manifest`, each of which is kept, under their names, and the manifest last.
    ///
    /// Files that are in place already are not touched. Then the cache drops what is too much.
    ///
    /// # Errors
    /// [`ExportError::Io`] with the path, and [`ExportError::Vanished`] when somebody has taken a table away. What is kept stays
    /// so.
    pub fn publish(&self, manifest: &Manifest) -> Result<(), ExportError> {
        let mut finished = self.finished();
        let placed = self.stage(manifest).and_then(|staged| self.place(manifest, &staged));
        entries::sweep(&self.cache());
        placed?;
        finished.published = true;
        self.tidy(manifest);
        Ok(())
    }

    /// Links the tables that are not in place under temporary names, each with the name that it is to have.
    fn stage(&self, manifest: &Manifest) -> Result<Vec<(PathBuf, PathBuf)>, ExportError> {
        let cache = self.cache();
        let mut staged = Vec::new();
        for (index, entry) in manifest.tables.iter().enumerate() {
            let to = self.directory.join(&entry.file);
            if is_in_place(&to, entry) {
                continue;
            }
            // found out before the first rename, not in the midst of them
            check_replaceable(&to)?;
            let from = cache.join(entry_of(manifest, entry));
            let part = cache.join(format!("{index}{PART}"));
            // a name that gets another file gets a new time with it, also when that file is an old one
            entries::touch(&from);
            link_or_copy(&from, &part).map_err(|source| match source.kind() {
                ErrorKind::NotFound => ExportError::Vanished { path: from.clone() },
                _ => ExportError::io("write", &part)(source),
            })?;
            // on the disk before they get their names
            let sync = File::open(&part).and_then(|file| file.sync_all());
            sync.map_err(ExportError::io("write", &part))?;
            staged.push((part, to));
        }
        self.stage_textures(manifest, &mut staged)?;
        sync_dir(&cache);
        Ok(staged)
    }

    /// Renames what is staged, and the manifest last.
    fn place(&self, manifest: &Manifest, staged: &[(PathBuf, PathBuf)]) -> Result<(), ExportError> {
        let (cache, last) = (self.cache(), self.directory.join(manifest::FILE_NAME));
        let [pending, before] = ["manifest", "before"].map(|name| cache.join(format!("{name}{PART}")));
        replaceable(&last).map_err(ExportError::io("replace", &last))?;
        let json = manifest.to_json()?;
        let is_new = !holds(&last, json.as_bytes());
        if is_new {
            write_whole(&pending, json.as_bytes())?;
        }
        // from here until the end there is no manifest: one that speaks of other files would be worse
        let is_away = is_new && !staged.is_empty() && fs::symlink_metadata(&last).is_ok();
        if is_away {
            fs::rename(&last, &before).map_err(ExportError::io("replace", &last))?;
        }
        for (index, (part, to)) in staged.iter().enumerate() {
            fs::rename(part, to).map_err(|source| {
                if is_away && index == 0 {
                    // nothing is replaced yet
                    drop(fs::rename(&before, &last));
                }
                ExportError::io("write", to)(source)
            })?;
        }
        if is_new {
            sync_dir(&self.directory);
            fs::rename(&pending, &last).map_err(ExportError::io("write", &last))?;
        }
        sync_dir(&self.directory);
        Ok(())
    }

    /// Drops entries that are not to stay. All is done by then, and nothing depends on it.
    fn tidy(&self, manifest: &Manifest) {
        let cache = self.cache();
        let mut used: HashSet<String> = HashSet::new();
        for entry in &manifest.tables {
            used.insert(entry_of(manifest, entry));
        }
        if !self.uses_cache {
            let keys: HashSet<&str> = manifest.requests.values().map(|key| short(key)).collect();
            let cached = entries::list(&cache).unwrap_or_default().into_iter();
            for (_, file) in cached.filter(|(key, _)| keys.contains(key.as_str())) {
                entries::remove(&file.path);
            }
        }
        // those that were in use until now have been used last
        for (key, placed) in &self.found {
            for file in placed.iter().filter(|file| !file.is_entry) {
                let name = entry_name(key, &file.hash);
                if !used.contains(&name) {
                    entries::touch(&cache.join(name));
                }
            }
        }
        entries::evict(&cache, &used, self.limit);
        drop(fs::remove_dir(cache));
    }

    /// Removes what is not finished or holds nothing, directories that were made in vain, and tells how far the bake has come. Nothing is written
    /// while the guard lives.
    pub fn abandon(&self) -> MutexGuard<'_, Finished> {
        let finished = self.finished();
        entries::sweep(&self.cache());
        for path in std::iter::once(&self.cache()).chain(&self.made) {
            // only what is empty goes
            drop(fs::remove_dir(path));
        }
        finished
    }

    fn finished(&self) -> MutexGuard<'_, Finished> {
        self.finished.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The directory of the bake.
    pub fn directory(&self) -> &Path {
        &self.directory
    }
}

/// Name of the file of the table `id`.
pub fn file_name(id: &str) -> String {
    format!("{id}.exr")
}

/// Name of the entry of a table in `manifest`.
fn entry_of(manifest: &Manifest, entry: &TableEntry) -> String {
    let key = manifest.requests.get(&entry.id).map_or("", String::as_str);
    entry_name(key, &entry.sha256)
}

/// Keeps others out for as long as the file is open. Where the system knows no such locks, which some network drives do not,
/// files still appear whole, and there is nobody to keep out but by agreement.
fn lock(directory: &Path) -> Result<Option<File>, ExportError> {
    // a directory can be opened and locked on Unix; elsewhere a file within has to stand for it
    let file = if cfg!(unix) {
        File::open(directory)
    } else {
        File::create(directory.join(".furnace.lock"))
    };
    let file = file.map_err(ExportError::io("open", directory))?;
    match file.try_lock() {
        Ok(()) => Ok(Some(file)),
        Err(TryLockError::WouldBlock) => Err(ExportError::Busy {
            path: directory.to_path_buf(),
        }),
        Err(TryLockError::Error(_)) => Ok(None),
    }
}
