//! Where a bake keeps the tables that are finished, until all are.
//!
//! While a bake runs, finished tables wait in the directory [`UNFINISHED`] beside the tables of the last one, which stay as
//! they are. Each is named by its [`key`] and by the hash of its bytes, so that the next bake knows what it finds, and finds
//! out what is damaged. When all are there, the manifest is written beside them and everything is renamed into place: no data
//! move any more, so that a full disk is met before and not in the middle.
//!
//! Killed at any moment, the directory holds whole files only: the old set, or, among the few renames, some of the new set and
//! no manifest. The pending manifest then tells which are in place, and the next bake finishes the renames.
//!
//! A bake takes over what it finds by key, waiting or in place: an unchanged table is not computed again. Two bakes at once
//! would take each other's files apart; a lock on the directory, which the system drops with the process, keeps the second out.

use super::manifest::{self, Manifest};
use super::read::{Contents, read_exr};
use super::write::{PART, create_dir, sync_dir, write_checked_later, write_whole};
use super::{ExportError, FORMAT, VERSION, sha256_hex};
use crate::regular;
use crate::table::Table;
use std::collections::HashMap;
use std::fs::{self, File, TryLockError};
use std::io::{self, ErrorKind, Read};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

/// The directory of finished tables, within the directory of a bake.
pub const UNFINISHED: &str = ".furnace";

/// Hexadecimal digits of key and hash in the name of a waiting file: 128 bits each.
const DIGITS: usize = 32;

/// The key of a table: SHA-256 of the version of program and layout and of its `request`, everything else that it depends on.
pub fn key(request: &str) -> String {
    sha256_hex(format!("whitefurnace {VERSION}, layout {FORMAT}\n{request}").as_bytes())
}

/// The directory of a bake, locked.
#[derive(Debug)]
pub struct Store {
    directory: PathBuf,
    /// Directories that did not exist before, deepest first.
    made: Vec<PathBuf>,
    /// Files by the keys of their tables, as they were found.
    found: HashMap<String, Found>,
    /// Holds the lock for as long as it is open.
    _lock: Option<File>,
    /// How many tables are finished; locked while files are written.
    finished: Mutex<usize>,
}

#[derive(Debug, Clone)]
struct Found {
    path: PathBuf,
    /// What the hash of its bytes begins with.
    hash: String,
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
        let waiting = directory.join(UNFINISHED);
        if fs::symlink_metadata(&waiting).is_ok_and(|about| about.is_symlink()) {
            let reason = "it is a symbolic link, and tables have to wait beside those that they replace";
            return Err(ExportError::io("use", &waiting)(io::Error::other(reason)));
        }
        create_dir(&waiting)?;
        let mut found = HashMap::new();
        // what waits counts more than what is in place: it is named by what it answers
        for manifest in [directory.join(manifest::FILE_NAME), waiting.join(manifest::FILE_NAME)] {
            found.extend(in_place(directory, &manifest));
        }
        found.extend(waiting_in(&waiting)?);
        Ok(Self {
            directory: directory.to_path_buf(),
            made,
            found,
            _lock: lock,
            finished: Mutex::new(0),
        })
    }

    fn waiting(&self) -> PathBuf {
        self.directory.join(UNFINISHED)
    }

    /// The finished table `id` with this `key`, whole and as it was written; `None` when there is none or it was damaged.
    pub fn find(&self, key: &str, id: &str) -> Option<Kept> {
        let found = self.found.get(key.get(..DIGITS)?)?;
        // nothing waits or stands under a name that is not its own, unless somebody has had a hand in it
        let is_own = found.path == self.directory.join(file_name(id)) || found.path.starts_with(self.waiting());
        let file = is_own.then(|| read_exr(&found.path))?.ok()?;
        match file.contents {
            Contents::Table { table, .. } if file.sha256.starts_with(&found.hash) && table.id == id => {
                *self.finished() += 1;
                Some(Kept {
                    table: *table,
                    bytes: file.bytes,
                    sha256: file.sha256,
                })
            }
            _ => None,
        }
    }

    /// Keeps the file `bytes` of the table with this `key`.
    ///
    /// # Errors
    /// [`ExportError::Io`] with the path; nothing but whole files is left.
    pub fn keep(&self, key: &str, bytes: &[u8]) -> Result<(), ExportError> {
        let mut finished = self.finished();
        write_checked_later(&self.waiting().join(waiting_name(key, &sha256_hex(bytes))), bytes)?;
        *finished += 1;
        Ok(())
    }

    /// Puts all tables of `manifest`, each of which is kept or in place, under their names, and the manifest last.
    ///
    /// Files that are in place already are not touched.
    ///
    /// # Errors
    /// [`ExportError::Io`] with the path, and [`ExportError::Vanished`] when somebody has taken a table away. What is kept stays
    /// so.
    pub fn publish(&self, manifest: &Manifest) -> Result<(), ExportError> {
        let _finished = self.finished();
        let (waiting, name) = (self.waiting(), manifest::FILE_NAME);
        let (pending, last) = (waiting.join(name), self.directory.join(name));
        let json = manifest.to_json()?;
        let mut renames = Vec::new();
        for entry in &manifest.tables {
            let key = manifest.requests.get(&entry.id).map_or("", String::as_str);
            let from = waiting.join(waiting_name(key, &entry.sha256));
            let to = self.directory.join(&entry.file);
            if from.exists() {
                renames.push((from, to));
            } else if !fs::metadata(&to).is_ok_and(|about| about.is_file() && about.len() == entry.bytes) {
                return Err(ExportError::Vanished { path: from });
            }
        }
        // on the disk before they get their names
        for (from, _) in &renames {
            let sync = File::open(from).and_then(|file| file.sync_all());
            sync.map_err(ExportError::io("write", from))?;
        }
        // found out before the first rename, not in the midst of them
        if let Some((_, taken)) = renames.iter().find(|(_, to)| to.is_dir()) {
            let source = ErrorKind::IsADirectory.into();
            return Err(ExportError::io("write", taken)(source));
        }
        let is_new = !holds(&last, json.as_bytes());
        if is_new {
            write_whole(&pending, json.as_bytes())?;
        }
        // from here until the end there is no manifest: one that speaks of other files would be worse
        let before = regular::open(&last).ok().map(|(file, _)| file);
        if is_new && last.exists() {
            fs::remove_file(&last).map_err(ExportError::io("replace", &last))?;
        }
        for (index, (from, to)) in renames.iter().enumerate() {
            fs::rename(from, to).map_err(|source| {
                if let (0, Some(mut before)) = (index, before.as_ref()) {
                    // nothing is replaced yet
                    let mut json = Vec::new();
                    drop(before.read_to_end(&mut json).map(|_| write_whole(&last, &json)));
                }
                ExportError::io("write", to)(source)
            })?;
        }
        if is_new {
            sync_dir(&self.directory);
            fs::rename(&pending, &last).map_err(ExportError::io("write", &last))?;
        }
        sync_dir(&self.directory);
        clear(&waiting);
        Ok(())
    }

    /// Removes what holds nothing, directories that were made in vain, and tells how many tables are finished. Nothing is
    /// written while the guard lives.
    pub fn abandon(&self) -> MutexGuard<'_, usize> {
        let finished = self.finished();
        for path in std::iter::once(&self.waiting()).chain(&self.made) {
            // only what is empty goes
            drop(fs::remove_dir(path));
        }
        finished
    }

    fn finished(&self) -> MutexGuard<'_, usize> {
        self.finished.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The directory of the bake.
    pub fn directory(&self) -> &Path {
        &self.directory
    }
}

/// Whether the regular file at `path` holds `bytes` and nothing else.
fn holds(path: &Path, bytes: &[u8]) -> bool {
    let same = |(mut file, length): (File, u64)| {
        let mut found = Vec::new();
        length == bytes.len() as u64 && file.read_to_end(&mut found).is_ok() && found == bytes
    };
    regular::open(path).is_ok_and(same)
}

/// Removes what waits of bakes that were given up, and the directory unless somebody keeps files of another kind there. All is
/// done by then, and nothing depends on it.
fn clear(waiting: &Path) {
    for entry in fs::read_dir(waiting).into_iter().flatten().flatten() {
        let name = entry.file_name();
        let name = name.to_string_lossy();
        if waiting_parts(&name).is_some() || name.ends_with(PART) || name == manifest::FILE_NAME {
            drop(fs::remove_file(entry.path()));
        }
    }
    drop(fs::remove_dir(waiting));
}

/// Name of the file of the table `id`.
pub fn file_name(id: &str) -> String {
    format!("{id}.exr")
}

/// Key and hash in the name of a waiting file.
fn waiting_parts(name: &str) -> Option<(&str, &str)> {
    let parts = name.strip_suffix(".exr")?.split_once('-')?;
    [parts.0, parts.1]
        .iter()
        .all(|part| part.len() == DIGITS && part.bytes().all(|digit| digit.is_ascii_hexdigit()))
        .then_some(parts)
}

/// Name of the waiting file with this key and this hash.
fn waiting_name(key: &str, sha256: &str) -> String {
    let part = |text: &str| text.get(..DIGITS).unwrap_or(text).to_owned();
    format!("{}-{}.exr", part(key), part(sha256))
}

/// What waits, by key. Parts of files that a killed bake left behind are removed.
fn waiting_in(waiting: &Path) -> Result<Vec<(String, Found)>, ExportError> {
    let entries = fs::read_dir(waiting).map_err(ExportError::io("read", waiting))?;
    let mut found = Vec::new();
    for entry in entries.flatten() {
        let path = entry.path();
        let Some(name) = path.file_name().and_then(|name| name.to_str()) else {
            continue;
        };
        if name.ends_with(PART) {
            drop(fs::remove_file(&path));
        } else if let Some((key, hash)) = waiting_parts(name) {
            let (key, hash) = (key.to_owned(), hash.to_owned());
            found.push((key, Found { path, hash }));
        }
    }
    Ok(found)
}

/// What the manifest at `path` says to be in place, by key; nothing when there is none that can be read.
fn in_place(directory: &Path, path: &Path) -> Vec<(String, Found)> {
    let Ok(manifest) = Manifest::read(path) else {
        return Vec::new();
    };
    let known = |entry: manifest::TableEntry| {
        let key = manifest.requests.get(&entry.id)?.get(..DIGITS)?.to_owned();
        // a manifest may come from anybody: no way out of the directory
        let is_inside = Path::new(&entry.file).file_name() == Some(entry.file.as_ref());
        (is_inside && entry.sha256.len() == 64).then(|| {
            let found = Found {
                path: directory.join(&entry.file),
                hash: entry.sha256,
            };
            (key, found)
        })
    };
    manifest.tables.into_iter().filter_map(known).collect()
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
