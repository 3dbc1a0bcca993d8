//! The measured files of a scene: each is read once, however often and by whatever names it is used, and all of them together
//! have a limit. Without either, a scene of a few lines could ask for any amount of memory.

use crate::bxdf::{HalfAngle, Irregular};
use crate::measured::MeasuredError;
use crate::measured::cie::SpectralSamples;
use crate::measured::index::{ConductorIndex, read_spd};
use crate::measured::irregular::IrregularSamples;
use crate::measured::merl::MerlTable;
use std::cell::{Cell, RefCell};
use std::collections::HashMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Most bytes that the measured files of a scene may have together: a little more than the hundred materials that MERL
/// published.
pub(super) const MOST_BYTES: u64 = 4 << 30;

/// What has been read of one kind, by the true name of its file.
type Shelf<T> = RefCell<HashMap<PathBuf, Arc<T>>>;

/// What has been read for one scene.
#[derive(Default)]
pub(super) struct Library {
    merl: Shelf<HalfAngle>,
    irregular: Shelf<Irregular>,
    index: Shelf<ConductorIndex>,
    spectra: Shelf<SpectralSamples>,
    bytes: Cell<u64>,
}

impl Library {
    /// A half-angle table, with what its sampling needs.
    pub(super) fn merl(&self, path: &Path) -> Result<Arc<HalfAngle>, MeasuredError> {
        let read = |path: &Path| Ok(HalfAngle::new(Arc::new(MerlTable::read(path)?)));
        self.fetch(&self.merl, path, read)
    }

    /// Irregular samples, with what their sampling needs: of a large file that takes most of a second.
    pub(super) fn irregular(&self, path: &Path) -> Result<Arc<Irregular>, MeasuredError> {
        let read = |path: &Path| Ok(Irregular::new(Arc::new(IrregularSamples::read(path)?)));
        self.fetch(&self.irregular, path, read)
    }

    /// A table of eta and k.
    pub(super) fn index(&self, path: &Path) -> Result<Arc<ConductorIndex>, MeasuredError> {
        self.fetch(&self.index, path, ConductorIndex::read_yaml)
    }

    /// A quantity over wavelengths.
    pub(super) fn spectrum(&self, path: &Path) -> Result<Arc<SpectralSamples>, MeasuredError> {
        self.fetch(&self.spectra, path, read_spd)
    }

    fn fetch<T>(
        &self,
        shelf: &Shelf<T>,
        path: &Path,
        read: impl FnOnce(&Path) -> Result<T, MeasuredError>,
    ) -> Result<Arc<T>, MeasuredError> {
        // what is not there has no true name, and reading it says so
        let name = fs::canonicalize(path).unwrap_or_else(|_| path.to_path_buf());
        if let Some(found) = shelf.borrow().get(&name) {
            return Ok(found.clone());
        }
        let data = Arc::new(read(path)?);
        let bytes = fs::metadata(path).map_or(0, |about| about.len());
        let total = self.bytes.get().saturating_add(bytes);
        if total > MOST_BYTES {
            return Err(MeasuredError::Size {
                path: path.display().to_string(),
                bytes,
                allowed: format!(
                    "the measured files of a scene have at most {MOST_BYTES} bytes together, and these would make it {total}"
                ),
            });
        }
        self.bytes.set(total);
        shelf.borrow_mut().insert(name, data.clone());
        Ok(data)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_is_read_once_under_all_of_its_names() {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("white.spd");
        fs::write(&path, "400 1\n700 1\n").unwrap();
        let library = Library::default();
        let first = library.spectrum(&path).unwrap();
        let again = library.spectrum(&directory.path().join("./white.spd")).unwrap();
        assert!(Arc::ptr_eq(&first, &again));
        assert_eq!(library.bytes.get(), 12);
    }

    #[test]
    fn all_files_together_have_a_limit() {
        let directory = tempfile::tempdir().unwrap();
        let library = Library::default();
        library.bytes.set(MOST_BYTES - 12);
        let path = |name: &str| directory.path().join(name);
        for name in ["a.spd", "b.spd"] {
            fs::write(path(name), "400 1\n700 1\n").unwrap();
        }
        library.spectrum(&path("a.spd")).unwrap();
        library.spectrum(&path("a.spd")).unwrap();
        let error = library.spectrum(&path("b.spd")).unwrap_err().to_string();
        assert!(
            error.contains("b.spd: 12 bytes are not allowed") && error.contains("4294967296"),
            "{error}"
        );
    }
}
