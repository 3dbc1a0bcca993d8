//! Tables as files: OpenEXR images that any viewer opens and that say how they were made, and a manifest of them.
//!
//! Bytes depend on the tables alone, never on the run: no dates, no timings, no hash order.

mod attributes;
pub mod exr;
pub mod formats;
pub mod manifest;
pub mod read;
pub mod store;
pub mod write;

use crate::printable::printable;
use crate::table::TableError;
use sha2::{Digest, Sha256};
use std::path::{Path, PathBuf};
use thiserror::Error;

/// The name under which files are signed.
pub const SOFTWARE: &str = "whitefurnace";
/// The version of the program, in every file that it writes.
pub const VERSION: &str = env!("CARGO_PKG_VERSION");
/// Version of the layout of attributes and manifest; files of a later layout are refused, not guessed at.
pub const FORMAT: i32 = 2;

/// Why a file could not be written or read.
#[derive(Debug, Error)]
pub enum ExportError {
    /// The table breaks its own rules.
    #[error(transparent)]
    Table(#[from] TableError),
    /// The table cannot be written in a further format.
    #[error(transparent)]
    Format(#[from] formats::FormatError),
    /// The system refused.
    #[error("cannot {action} {}", shown(path))]
    Io {
        /// What was tried: `write`, `read`, `create directory`, ...
        action: &'static str,
        /// The file or directory.
        path: PathBuf,
        /// The reason of the system.
        source: std::io::Error,
    },
    /// A file stands where a directory is needed.
    #[error("cannot create directory {}: {} is a file", shown(path), shown(file))]
    NotADirectory {
        /// The directory asked for.
        path: PathBuf,
        /// The file in its way.
        file: PathBuf,
    },
    /// Another bake writes into the same directory.
    #[error(
        "another bake is writing into {}: wait until it has ended, or choose another directory with --out",
        shown(path)
    )]
    Busy {
        /// The directory.
        path: PathBuf,
    },
    /// A finished table that is no longer where it was put.
    #[error("{} is gone, where this bake had put a finished table: bake again", shown(path))]
    Vanished {
        /// The file.
        path: PathBuf,
    },
    /// A table that the format cannot hold.
    #[error("cannot encode table {id}: {reason}")]
    Encode {
        /// The table.
        id: String,
        /// What went wrong.
        reason: String,
    },
    /// A file that is damaged, too large, or not what it is taken for.
    #[error("cannot read {}: {}", shown(path), printable(reason))]
    Unreadable {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        reason: String,
    },
    /// A manifest that is no JSON or lacks facts.
    #[error("the manifest cannot be read or written: {reason}")]
    Manifest {
        /// What is wrong, and the line and column.
        reason: String,
    },
}

impl From<serde_json::Error> for ExportError {
    fn from(error: serde_json::Error) -> Self {
        let reason = json_reason(&error);
        Self::Manifest { reason }
    }
}

/// What is wrong with JSON. The message quotes what stands in place of a number, which may be as long as the file: of that the
/// middle is left out.
fn json_reason(error: &serde_json::Error) -> String {
    const HALF: usize = 200;
    let text = error.to_string();
    let count = text.chars().count();
    if count <= 2 * HALF {
        return text;
    }
    let start: String = text.chars().take(HALF).collect();
    let end: String = text.chars().skip(count - HALF).collect();
    format!("{start}...{end}")
}

fn shown(path: &Path) -> String {
    printable(&path.display().to_string())
}

impl ExportError {
    /// An [`ExportError::Io`] for `path`.
    fn io(action: &'static str, path: &Path) -> impl FnOnce(std::io::Error) -> Self {
        let path = path.to_path_buf();
        move |source| Self::Io { action, path, source }
    }
}

/// SHA-256 of `bytes`, 64 lower-case hexadecimal digits.
pub fn sha256_hex(bytes: &[u8]) -> String {
    Sha256::digest(bytes).iter().map(|byte| format!("{byte:02x}")).collect()
}
