//! What a manifest says of a table in a further format.

use serde::{Deserialize, Serialize};

/// A table in a further format.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct FileEntry {
    /// Name of the file, beside the manifest.
    pub file: String,
    /// Name of the format.
    pub format: String,
    /// Name of the storage that values are rounded to.
    pub storage: String,
    /// Size of the file in bytes.
    pub bytes: u64,
    /// SHA-256 of the file, hexadecimal.
    pub sha256: String,
    /// Error of a lookup: that of the table, and what rounding adds to it. Null where that of the table is not known or not
    /// bounded.
    pub lookup_error: Option<f64>,
}
