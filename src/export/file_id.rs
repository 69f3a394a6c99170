//! Which file an open one is, whatever its name is by now.

use std::fs::File;
use std::io::{self, ErrorKind};
use std::path::Path;

/// The disk that a file is on, and its number there: another file may have both once it is gone.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct FileId(u64, u64);

impl FileId {
    /// # Errors
    /// When the system does not tell.
    #[cfg(unix)]
    pub(crate) fn of(file: &File) -> io::Result<Self> {
        file.metadata().map(Self::told_by)
    }

    #[cfg(windows)]
    pub(crate) fn of(file: &File) -> io::Result<Self> {
        let known = winapi_util::file::information(file)?;
        Ok(Self(known.volume_serial_number(), known.file_index()))
    }

    /// Elsewhere all are taken for the same.
    #[cfg(not(any(unix, windows)))]
    pub(crate) fn of(_file: &File) -> io::Result<Self> {
        Ok(Self(0, 0))
    }

    /// Whether it is still the file that others find under a name.
    ///
    /// # Errors
    /// When that cannot be told.
    pub(crate) fn is_still_at(self, path: &Path) -> io::Result<bool> {
        match Self::named(path) {
            Err(e) if e.kind() == ErrorKind::NotFound => Ok(false),
            named => Ok(named? == self),
        }
    }

    /// Not opened: a file that may not be read can be known.
    #[cfg(unix)]
    fn named(path: &Path) -> io::Result<Self> {
        path.metadata().map(Self::told_by)
    }

    #[cfg(unix)]
    fn told_by(known: std::fs::Metadata) -> Self {
        use std::os::unix::fs::MetadataExt;
        Self(known.dev(), known.ino())
    }

    #[cfg(not(unix))]
    fn named(path: &Path) -> io::Result<Self> {
        Self::of(&File::open(path)?)
    }
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;

    #[test]
    fn a_file_that_has_lost_its_name_is_told_from_the_one_that_has_it() {
        let folder = tempfile::tempdir().unwrap();
        let [path, away] = ["it", "away"].map(|name| folder.path().join(name));
        let file = File::create(&path).unwrap();
        let is_there = || FileId::of(&file).unwrap().is_still_at(&path).unwrap();
        assert!(is_there());
        fs::rename(&path, &away).unwrap();
        assert!(!is_there());
        fs::write(&path, "another").unwrap();
        assert!(!is_there());
        fs::remove_file(&path).unwrap();
        fs::rename(&away, &path).unwrap();
        assert!(is_there());
    }
}
