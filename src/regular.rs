//! Opening of files that others have named.

use std::fs::{File, FileType, Metadata};
use std::io;
use std::path::Path;

/// The regular file at `path`, open for reading, and its length in bytes.
///
/// What it is gets asked before it is opened: opening a pipe waits for somebody to write to it, perhaps for ever, and opening a
/// device may act on it.
///
/// # Errors
/// What the system says, and [`io::ErrorKind::InvalidInput`] for a directory, a pipe, a socket or a device.
pub(crate) fn open(path: &Path) -> io::Result<(File, u64)> {
    length(&path.metadata()?)?;
    let file = File::open(path)?;
    // another file may have come under the name
    let length = length(&file.metadata()?)?;
    Ok((file, length))
}

fn length(about: &Metadata) -> io::Result<u64> {
    if about.is_file() {
        return Ok(about.len());
    }
    let found = kind(about.file_type());
    let reason = format!("it is {found}, where only a regular file is allowed");
    Err(io::Error::new(io::ErrorKind::InvalidInput, reason))
}

/// What a file is that is not regular.
fn kind(kind: FileType) -> &'static str {
    #[cfg(unix)]
    {
        use std::os::unix::fs::FileTypeExt;
        if kind.is_fifo() {
            return "a pipe";
        }
        if kind.is_socket() {
            return "a socket";
        }
    }
    if kind.is_dir() { "a directory" } else { "a device" }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn reason(path: &Path) -> String {
        open(path).unwrap_err().to_string()
    }

    #[test]
    fn regular_files_tell_their_length() {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("three");
        std::fs::write(&path, "abc").unwrap();
        assert_eq!(open(&path).unwrap().1, 3);
        assert_eq!(
            reason(directory.path()),
            "it is a directory, where only a regular file is allowed"
        );
        assert!(open(&directory.path().join("none")).is_err());
    }

    /// Opening a pipe that nobody writes to would never return.
    #[cfg(unix)]
    #[test]
    fn pipes_and_devices_are_not_opened() {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("pipe");
        let made = std::process::Command::new("mkfifo").arg(&path).status();
        assert!(made.unwrap().success());
        assert_eq!(reason(&path), "it is a pipe, where only a regular file is allowed");
        let zero = Path::new("/dev/zero");
        assert_eq!(reason(zero), "it is a device, where only a regular file is allowed");
        let link = directory.path().join("link");
        std::os::unix::fs::symlink(&path, &link).unwrap();
        assert_eq!(reason(&link), "it is a pipe, where only a regular file is allowed");
    }
}
