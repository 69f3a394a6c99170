//! Where files are.

use std::path::{MAIN_SEPARATOR_STR, Path};

/// The folder that a file is in.
pub(crate) fn folder_of(file: &Path) -> &Path {
    let folder = file.parent().filter(|p| !p.as_os_str().is_empty());
    folder.unwrap_or(Path::new("."))
}

/// A path as files name it, for all systems to read: folders are parted by slashes.
pub(crate) fn portable(path: &Path) -> String {
    path.display().to_string().replace(MAIN_SEPARATOR_STR, "/")
}
