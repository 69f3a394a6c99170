//! Mesh files to [`Soup`], one file a format.

use std::path::Path;

use crate::substrate::Soup;

/// Why a mesh file could not become a substrate.
///
/// The text names the file, the place in it and the cure.
#[derive(Debug, thiserror::Error)]
#[error("{message}")]
pub struct LoadError {
    message: String,
}

/// Reads a mesh file of any supported format.
///
/// # Errors
/// When the file cannot be read, is malformed, or holds no triangles.
pub fn load_soup(path: &Path) -> Result<Soup, LoadError> {
    Err(LoadError {
        message: format!("{}: not supported yet", path.display()),
    })
}
