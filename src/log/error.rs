//! Why a log cannot be gone on with.

use std::io;
use std::path::{Path, PathBuf};

use crate::run::GrowError;

/// Why a log cannot be gone on with.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum LogError {
    /// The system refused.
    #[error("{}: reading the log failed: {problem}", .path.display())]
    Read {
        /// The log.
        path: PathBuf,
        /// The system's reason.
        problem: io::Error,
    },
    /// The file is something else.
    #[error("{} is not a log of thallus", .0.display())]
    NoLog(PathBuf),
    /// The part that says what run it is of is damaged.
    #[error(
        "{}: the head of the log is damaged, so that nothing in it can be trusted: grow again by the same \
         recipe, into another folder", .0.display()
    )]
    Head(PathBuf),
    /// Another version of the program wrote it.
    #[error(
        "{} was written by thallus {found}, and this is {}: only the version that began a run goes \
         on with it; to grow it again with this one, take the same recipe and another folder",
        .path.display(), env!("CARGO_PKG_VERSION")
    )]
    Version {
        /// The log.
        path: PathBuf,
        /// The version that wrote it.
        found: String,
    },
    /// It is of a run on another mesh.
    #[error(
        "{} is of a run on another mesh: the mesh's hash is {found}, the log's {expected}; give the \
         right file", .path.display()
    )]
    Mesh {
        /// The log.
        path: PathBuf,
        /// Hash of the mesh that was loaded.
        found: String,
        /// Hash of the mesh that the run was on.
        expected: String,
    },
    /// It is of a run by another recipe.
    #[error(
        "{} is of a run by another recipe: {differences}; put recipe.toml back as it was, or grow \
         into another folder", .path.display()
    )]
    Recipe {
        /// The log.
        path: PathBuf,
        /// What differs.
        differences: String,
    },
    /// Its run cannot have been on this substrate: that has another mask or another axis up, or no place for an
    /// element.
    #[error("{}: {problem}", .path.display())]
    Run {
        /// The log.
        path: PathBuf,
        /// Why a run could not go on from it.
        problem: Box<GrowError>,
    },
    /// A block with others after it is damaged.
    #[error(
        "{} is damaged at byte {at}: the {elements} elements before that are sound, and Log::read_sound reads them",
        .path.display()
    )]
    Damaged {
        /// The log.
        path: PathBuf,
        /// Where the damaged block begins.
        at: u64,
        /// Elements before it.
        elements: usize,
    },
}

impl LogError {
    /// Wraps the system's reason; for `map_err`.
    pub(super) fn read(path: &Path) -> impl Fn(io::Error) -> Self {
        move |problem| Self::Read {
            path: path.to_owned(),
            problem,
        }
    }
}
