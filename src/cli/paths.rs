//! Where files are, and which.

use std::io;
use std::path::{MAIN_SEPARATOR_STR, Path};

use thallus::input;

/// The folder that a file is in.
pub(crate) fn folder_of(file: &Path) -> &Path {
    let folder = file.parent().filter(|p| !p.as_os_str().is_empty());
    folder.unwrap_or(Path::new("."))
}

/// A hash of what a file holds, hexadecimal; an error where it is none.
pub(crate) fn hash_of(file: &Path) -> io::Result<String> {
    let mut hasher = blake3::Hasher::new();
    hasher.update_reader(input::regular(file)?)?;
    Ok(hasher.finalize().to_string())
}

/// A path as files name it, for all systems to read: folders are parted by slashes.
pub(crate) fn portable(path: &Path) -> String {
    path.display().to_string().replace(MAIN_SEPARATOR_STR, "/")
}
