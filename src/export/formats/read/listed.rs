//! What the list beside a file says of it.

use super::limited;
use crate::export::manifest;
use serde::Deserialize;
use std::path::Path;

/// The lists that bakes write.
const LISTS: [&str; 2] = [manifest::FILE_NAME, "profile.json"];
/// Longest list that is read, in bytes.
const MAX_LIST_BYTES: u64 = 1 << 26;

/// The place of a file in a list of tables.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Listed {
    /// Name of the list.
    pub list: &'static str,
    /// Hash of the file that it speaks of.
    pub sha256: String,
}

#[derive(Deserialize)]
struct List {
    tables: Vec<Table>,
}

#[derive(Deserialize)]
struct Table {
    #[serde(default)]
    files: Vec<File>,
}

#[derive(Deserialize)]
struct File {
    file: String,
    sha256: String,
}

/// What the manifest or the description of a profile beside the texture at `path` says of it; `None` where there is none, or none
/// that can be read, or it lists other files only.
pub fn listed_beside(path: &Path) -> Option<Listed> {
    let name = path.file_name()?.to_str()?;
    LISTS.into_iter().find_map(|list| {
        let bytes = limited(&path.with_file_name(list), MAX_LIST_BYTES, &|_| Ok(())).ok()?;
        let found: List = serde_json::from_slice(&bytes).ok()?;
        let mut files = found.tables.into_iter().flat_map(|table| table.files);
        let sha256 = files.find(|entry| entry.file == name)?.sha256;
        Some(Listed { list, sha256 })
    })
}
