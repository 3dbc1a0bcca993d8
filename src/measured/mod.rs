//! Data that somebody measured: reflectances and indices of refraction, read from files.
//!
//! A file is refused before memory is spent on what it announces: its size is known first, and every error names the file,
//! the place in it, the value and what is allowed.

pub mod cie;
mod file;
pub mod index;
pub mod irregular;
pub mod merl;

use crate::printable::printable;
use thiserror::Error;

/// A data file that cannot be used.
///
/// The system's reason is part of the message, and not a source of the error, so that an error chain says it once.
#[derive(Debug, Error)]
pub enum MeasuredError {
    /// The file could not be opened or read.
    #[error("{}: cannot be read: {reason}", printable(path))]
    Unreadable {
        /// The file as it was named.
        path: String,
        /// What the system said.
        reason: std::io::Error,
    },
    /// The file is longer or shorter than any file of its kind.
    #[error("{}: {bytes} bytes are not allowed: {allowed}", printable(path))]
    Size {
        /// The file as it was named.
        path: String,
        /// Its size.
        bytes: u64,
        /// What the size may be.
        allowed: String,
    },
    /// Something in the file is not what it has to be.
    #[error("{}: {place}: {what}", printable(path))]
    Refused {
        /// The file as it was named.
        path: String,
        /// Line, or byte, or sample, counted from 1.
        place: String,
        /// The value and what is allowed.
        what: String,
    },
}
