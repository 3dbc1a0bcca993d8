//! The files of the cache: their names, how they come and go.

use crate::export::manifest::{self, Manifest};
use crate::export::sha256_hex;
use crate::export::write::PART;
use crate::regular;
use std::collections::HashSet;
use std::fs::{self, File};
use std::io::{self, Read};
use std::path::{Path, PathBuf};
use std::time::SystemTime;

/// Hexadecimal digits of key and hash in the name of an entry: 128 bits each.
const DIGITS: usize = 32;

/// What a file takes on most disks is a multiple of this.
const BLOCK: u64 = 4096;

/// A file that should hold a table.
#[derive(Debug, Clone)]
pub(super) struct Found {
    pub(super) path: PathBuf,
    /// What the hash of its bytes begins with.
    pub(super) hash: String,
    /// Whether it is one of the cache, and not in place.
    pub(super) is_entry: bool,
}

/// As much of a key or of a hash as the names of entries hold.
pub(super) fn short(digits: &str) -> &str {
    digits.get(..DIGITS).unwrap_or(digits)
}

/// Name of the entry with this key and this hash.
pub(super) fn entry_name(key: &str, sha256: &str) -> String {
    format!("{}-{}.exr", short(key), short(sha256))
}

/// Key and hash in the name of an entry.
fn entry_parts(name: &str) -> Option<(&str, &str)> {
    let parts = name.strip_suffix(".exr")?.split_once('-')?;
    let is_part = |part: &str| part.len() == DIGITS && is_hexadecimal(part);
    (is_part(parts.0) && is_part(parts.1)).then_some(parts)
}

fn is_hexadecimal(text: &str) -> bool {
    text.bytes().all(|digit| matches!(digit, b'0'..=b'9' | b'a'..=b'f'))
}

/// The entries of the cache with their keys, in the order of their names.
pub(super) fn list(cache: &Path) -> io::Result<Vec<(String, Found)>> {
    let mut found = Vec::new();
    for entry in fs::read_dir(cache)?.flatten() {
        let name = entry.file_name();
        if let Some((key, hash)) = name.to_str().and_then(entry_parts) {
            let file = Found {
                path: entry.path(),
                hash: hash.into(),
                is_entry: true,
            };
            found.push((key.to_string(), file));
        }
    }
    found.sort_by(|(_, a), (_, b)| a.path.cmp(&b.path));
    Ok(found)
}

/// What the manifest in `directory` says to be in place, with the keys; nothing when there is none that can be read.
pub(super) fn in_place(directory: &Path) -> Vec<(String, Found)> {
    let Ok(manifest) = Manifest::read(&directory.join(manifest::FILE_NAME)) else {
        return Vec::new();
    };
    let known = |entry: manifest::TableEntry| {
        let key = manifest.requests.get(&entry.id)?;
        // a manifest may come from anybody: no way out of the directory, and nothing but digits in names made of it
        let is_inside = Path::new(&entry.file).file_name() == Some(entry.file.as_ref());
        let are_hashes = [key, &entry.sha256]
            .iter()
            .all(|hash| hash.len() == 2 * DIGITS && is_hexadecimal(hash));
        let file = Found {
            path: directory.join(&entry.file),
            hash: entry.sha256,
            is_entry: false,
        };
        (is_inside && are_hashes).then(|| (short(key).to_string(), file))
    };
    manifest.tables.into_iter().filter_map(known).collect()
}

/// Removes what a killed bake has left unfinished, and the manifest that earlier versions kept here.
pub(super) fn sweep(cache: &Path) {
    for entry in fs::read_dir(cache).into_iter().flatten().flatten() {
        let name = entry.file_name();
        if name.to_string_lossy().ends_with(PART) || name == manifest::FILE_NAME {
            drop(fs::remove_file(entry.path()));
        }
    }
}

/// Removes an entry, whatever has become of it.
pub(super) fn remove(entry: &Path) {
    if fs::remove_file(entry).is_err() {
        drop(fs::remove_dir_all(entry));
    }
}

/// Says that an entry is used now.
pub(super) fn touch(entry: &Path) {
    // opening a pipe might wait for ever
    if fs::symlink_metadata(entry).is_ok_and(|about| about.is_file()) {
        let file = File::options().write(true).open(entry);
        drop(file.and_then(|file| file.set_modified(SystemTime::now())));
    }
}

/// Another name `to` for the file `from`; a copy where the system makes no link, or where `from` is one that only points to it.
pub(super) fn link_or_copy(from: &Path, to: &Path) -> io::Result<()> {
    if !fs::symlink_metadata(from)?.is_symlink() && fs::hard_link(from, to).is_ok() {
        return Ok(());
    }
    copy(from, to)
}

/// A copy under the name `to`, which must be free.
pub(super) fn copy(from: &Path, to: &Path) -> io::Result<()> {
    io::copy(&mut File::open(from)?, &mut File::create_new(to)?).map(drop)
}

/// Whether the file at `path` is the one that `entry` speaks of.
pub(super) fn is_in_place(path: &Path, entry: &manifest::TableEntry) -> bool {
    content(path, entry.bytes).is_some_and(|bytes| sha256_hex(&bytes) == entry.sha256)
}

/// Whether the regular file at `path` holds `bytes` and nothing else.
pub(super) fn holds(path: &Path, bytes: &[u8]) -> bool {
    content(path, bytes.len() as u64).is_some_and(|found| found == bytes)
}

/// What the regular file at `path` holds, if it is that long.
pub(super) fn content(path: &Path, length: u64) -> Option<Vec<u8>> {
    let (file, _) = regular::open(path).ok().filter(|(_, found)| *found == length)?;
    let mut bytes = Vec::new();
    file.take(length).read_to_end(&mut bytes).ok().map(|_| bytes)
}

/// Drops entries, those first that were used longest ago, until all that are not among `used` take `limit` bytes at most.
pub(super) fn evict(cache: &Path, used: &HashSet<String>, limit: u64) {
    let about = |(_, file): (String, Found)| {
        let is_used = file
            .path
            .file_name()
            .is_some_and(|name| used.contains(&*name.to_string_lossy()));
        let about = fs::symlink_metadata(&file.path).ok().filter(|_| !is_used)?;
        // what is no file is none of ours
        let length = about.is_file().then(|| about.len().next_multiple_of(BLOCK))?;
        Some((about.modified().ok()?, file.path, length))
    };
    let mut unused: Vec<_> = list(cache).unwrap_or_default().into_iter().filter_map(about).collect();
    unused.sort();
    let mut bytes: u64 = unused.iter().map(|(_, _, length)| length).sum();
    for (_, path, length) in unused {
        if bytes <= limit {
            break;
        }
        remove(&path);
        bytes -= length;
    }
}
