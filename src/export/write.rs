//! Files that appear whole or not at all, and the directories that they go to.

use super::ExportError;
use std::fs::File;
use std::io::{self, Write};
use std::path::Path;
use tempfile::{Builder, NamedTempFile};

/// Writes `bytes` to `path`, replacing what was there. Whoever looks sees the old file or the new one, never a part:
/// the bytes go to a temporary file in the same directory, to the disk, and only then under their name.
///
/// # Errors
/// [`ExportError::Io`] with the path and the reason of the system; nothing is left behind.
pub fn write_whole(path: &Path, bytes: &[u8]) -> Result<(), ExportError> {
    write_and_rename(path, bytes, Durable::Yes)
}

/// [`write_whole`] for files that somebody checks before using them: a power cut may leave such a file damaged.
pub(super) fn write_checked_later(path: &Path, bytes: &[u8]) -> Result<(), ExportError> {
    write_and_rename(path, bytes, Durable::No)
}

/// Whether bytes have to be on the disk, which takes milliseconds, before they get their name.
#[derive(PartialEq)]
enum Durable {
    Yes,
    No,
}

/// Writes `files`, names and bytes, into `directory`, and last `description`, which speaks of them.
///
/// All of them are on the disk under temporary names before the first takes its own: a full disk changes nothing. An earlier
/// description is taken away before the first file is replaced, so that none ever speaks of other files; killed in between, the
/// directory holds whole files, old and new, and no description.
///
/// # Errors
/// [`ExportError::Io`] with the path and the reason of the system; no temporary file is left.
pub fn write_described(
    directory: &Path,
    files: &[(&str, &[u8])],
    description: (&str, &[u8]),
) -> Result<(), ExportError> {
    let mut staged = Vec::new();
    for (name, bytes) in files.iter().chain([&description]) {
        let path = directory.join(name);
        let stage = || -> io::Result<NamedTempFile> {
            // found out before the first rename, not in the midst of them
            replaceable(&path)?;
            let mut temporary = temporary_in(directory)?;
            temporary.write_all(bytes)?;
            temporary.as_file().sync_all()?;
            Ok(temporary)
        };
        let temporary = stage().map_err(ExportError::io("write", &path))?;
        staged.push((temporary.into_temp_path(), path));
    }
    let last = directory.join(description.0);
    match std::fs::remove_file(&last) {
        Err(error) if error.kind() != io::ErrorKind::NotFound => return Err(ExportError::io("replace", &last)(error)),
        _ => sync_dir(directory),
    }
    for (index, (temporary, path)) in staged.into_iter().enumerate() {
        if index == files.len() {
            // the files before what speaks of them
            sync_dir(directory);
        }
        let persisted = temporary.persist(&path).map_err(|error| error.error);
        persisted.map_err(ExportError::io("write", &path))?;
    }
    sync_dir(directory);
    Ok(())
}

/// Whether a file may take the name `path`, found out without changing anything: where a directory, a device, a pipe or a link to
/// nothing has it, a rename would fail, or take away what is no file.
///
/// # Errors
/// [`ExportError::Io`] with the path and what is there.
pub fn check_replaceable(path: &Path) -> Result<(), ExportError> {
    replaceable(path).map_err(ExportError::io("write", path))
}

pub(super) fn replaceable(path: &Path) -> io::Result<()> {
    if path.file_name().is_none() {
        return Err(io::Error::new(io::ErrorKind::InvalidInput, "the path names no file"));
    }
    // a file that is not there yet, or whose directory cannot be looked into, which making the file tells better
    let Ok(about) = std::fs::symlink_metadata(path) else {
        return Ok(());
    };
    let about = match about.is_symlink() {
        true => std::fs::metadata(path).map_err(|_| io::Error::other("it is a symbolic link to nothing"))?,
        false => about,
    };
    if about.is_dir() {
        return Err(io::ErrorKind::IsADirectory.into());
    }
    match about.is_file() {
        true => Ok(()),
        false => Err(io::Error::other("it is a device, a pipe or a socket, and not a file")),
    }
}

fn write_and_rename(path: &Path, bytes: &[u8], durable: Durable) -> Result<(), ExportError> {
    replaceable(path).map_err(ExportError::io("write", path))?;
    // what a link leads to is replaced, and the link stays
    let target = match path.is_symlink() {
        true => std::fs::canonicalize(path).map_err(ExportError::io("write", path))?,
        false => path.to_path_buf(),
    };
    let path = target.as_path();
    let directory = match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    };
    let write = || -> io::Result<()> {
        let mut temporary = temporary_in(directory)?;
        temporary.write_all(bytes)?;
        if durable == Durable::Yes {
            temporary.as_file().sync_all()?;
        }
        temporary.persist(path).map_err(|error| error.error)?;
        Ok(())
    };
    write().map_err(ExportError::io("write", path))?;
    if durable == Durable::Yes {
        sync_dir(directory);
    }
    Ok(())
}

/// Makes sure that names survive a power cut, as far as the file system lets directories be synchronised. Their files are
/// complete by then, whether it does or not.
pub(super) fn sync_dir(directory: &Path) {
    let _ = File::open(directory).and_then(|directory| directory.sync_all());
}

/// What the names of files end with that are not complete.
pub(super) const PART: &str = ".part";

/// A file that vanishes unless it is persisted, readable by whom the umask allows: temporary files are private by
/// default, and tables are made to be read by others.
fn temporary_in(directory: &Path) -> io::Result<NamedTempFile> {
    let mut builder = Builder::new();
    builder.prefix(".furnace-").suffix(PART);
    #[cfg(unix)]
    let permissions = std::os::unix::fs::PermissionsExt::from_mode(0o666);
    #[cfg(unix)]
    builder.permissions(permissions);
    // the error would name the temporary file, which nobody knows
    builder.tempfile_in(directory).map_err(|error| match error.kind() {
        kind @ (io::ErrorKind::NotFound | io::ErrorKind::PermissionDenied) => kind.into(),
        _ => error,
    })
}

/// Makes the directory `path` and those above it, and tries that files can be made in it; it may exist already.
///
/// # Errors
/// [`ExportError::NotADirectory`] when a file is in the way, [`ExportError::Io`] for every other reason.
pub fn create_dir(path: &Path) -> Result<(), ExportError> {
    std::fs::create_dir_all(path).map_err(|source| {
        // The system says "exists" or "not a directory" without saying which part of the path it means.
        let file = path.ancestors().find(|part| part.is_file());
        match file {
            Some(file) => ExportError::NotADirectory {
                path: path.to_path_buf(),
                file: file.to_path_buf(),
            },
            None => ExportError::io("create directory", path)(source),
        }
    })?;
    tempfile::tempfile_in(path).map_err(ExportError::io("write into", path))?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::error::Error;
    use std::fs;

    fn entries(directory: &Path) -> usize {
        fs::read_dir(directory).unwrap().count()
    }

    #[test]
    fn files_are_replaced_and_nothing_else_stays() {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("table.exr");
        write_whole(&path, b"first, longer").unwrap();
        write_whole(&path, b"second").unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"second");
        assert_eq!(entries(directory.path()), 1);
    }

    #[cfg(unix)]
    #[test]
    fn files_are_as_readable_as_any_other() {
        use std::os::unix::fs::PermissionsExt;
        let directory = tempfile::tempdir().unwrap();
        let [ours, plain] = ["ours", "plain"].map(|name| directory.path().join(name));
        write_whole(&ours, b"x").unwrap();
        fs::write(&plain, b"x").unwrap();
        let mode = |path| fs::metadata(path).unwrap().permissions().mode();
        assert_eq!(mode(&ours), mode(&plain));
    }

    #[test]
    fn failures_name_path_and_reason_and_leave_nothing() {
        let directory = tempfile::tempdir().unwrap();
        let taken = directory.path().join("taken.exr");
        fs::create_dir(&taken).unwrap();
        fs::write(taken.join("inside"), b"x").unwrap();
        let file = directory.path().join("file");
        fs::write(&file, b"x").unwrap();
        for path in [
            taken.clone(),
            file.join("table.exr"),
            directory.path().join("missing/table.exr"),
        ] {
            let error = write_whole(&path, b"bytes").unwrap_err();
            assert!(error.to_string().contains(&path.display().to_string()), "{error}");
            assert!(!error.source().unwrap().to_string().is_empty());
        }
        assert!(write_whole(Path::new(""), b"x").is_err() && write_whole(Path::new("/"), b"x").is_err());
        assert_eq!(entries(directory.path()), 2);
        assert_eq!(entries(&taken), 1);
    }

    #[cfg(unix)]
    #[test]
    fn links_are_followed_and_what_is_no_file_stays() {
        use std::os::unix::fs::{FileTypeExt, symlink};
        let directory = tempfile::tempdir().unwrap();
        let [file, link, lost, socket] = ["file", "link", "lost", "socket"].map(|name| directory.path().join(name));
        fs::write(&file, b"before").unwrap();
        symlink(&file, &link).unwrap();
        write_whole(&link, b"after").unwrap();
        assert!(link.is_symlink() && fs::read(&file).unwrap() == b"after");
        symlink(directory.path().join("nothing"), &lost).unwrap();
        let error = write_whole(&lost, b"x").unwrap_err();
        assert!(format!("{:?}", error.source()).contains("link to nothing"), "{error}");
        let _open = std::os::unix::net::UnixListener::bind(&socket).unwrap();
        for taken in [&socket, Path::new("/dev/null")] {
            check_replaceable(taken).unwrap_err();
            write_described(
                taken.parent().unwrap(),
                &[(taken.file_name().unwrap().to_str().unwrap(), b"x")],
                ("d", b"x"),
            )
            .unwrap_err();
            write_whole(taken, b"x").unwrap_err();
        }
        assert!(fs::symlink_metadata(&socket).unwrap().file_type().is_socket());
        assert_eq!(entries(directory.path()), 4);
    }

    #[test]
    fn directories_are_made_unless_a_file_is_in_the_way() {
        let directory = tempfile::tempdir().unwrap();
        let deep = directory.path().join("a/b/c");
        create_dir(&deep).unwrap();
        create_dir(&deep).unwrap();
        let file = directory.path().join("file");
        fs::write(&file, b"x").unwrap();
        for path in [file.clone(), file.join("a/b")] {
            match create_dir(&path).unwrap_err() {
                ExportError::NotADirectory { path: asked, file: way } => assert_eq!((asked, way), (path, file.clone())),
                other => panic!("{other}"),
            }
        }
    }
}
