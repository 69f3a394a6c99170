//! Why a mesh file could not be loaded: every text names the place and the cure.

use std::fmt;
use std::path::{Path, PathBuf};

use super::Format;

/// Why a mesh file could not become a [`Soup`](crate::substrate::Soup).
///
/// The text names the file, the place in it and the cure.
#[derive(Debug)]
pub struct LoadError {
    /// The file, where one was read (`None` for [bytes](crate::substrate::parse_soup)).
    pub file: Option<PathBuf>,
    /// What is wrong with it.
    pub fault: LoadFault,
}

/// The kinds of [`LoadError`].
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum LoadFault {
    /// The file, or a buffer file that it refers to, could not be read.
    #[error("{what} cannot be read ({problem}): {cure}")]
    Unreadable {
        /// What was being read: `"the file"`, or the buffer's name.
        what: String,
        /// The system's answer.
        problem: std::io::Error,
        /// What to do.
        cure: &'static str,
    },
    /// Neither the extension nor the content is one of the supported formats.
    #[error("not a mesh that can be read ({found}): {cure}")]
    UnknownFormat {
        /// What the content looks like.
        found: String,
        /// What to do.
        cure: &'static str,
    },
    /// The content breaks the rules of its format.
    #[error("{format}, {place}: {problem}; {cure}")]
    Malformed {
        /// The format it was read as.
        format: Format,
        /// Line, byte offset, or name of the part (`"mesh 0, primitive 1, accessor 3"`).
        place: String,
        /// What is wrong there.
        problem: String,
        /// What to do.
        cure: String,
    },
    /// The file needs something that is not implemented.
    #[error("{format}, {place}: {feature} is not supported; {cure}")]
    Unsupported {
        /// The format it was read as.
        format: Format,
        /// Where it is needed.
        place: String,
        /// The extension or feature by name.
        feature: String,
        /// How to export without it.
        cure: String,
    },
    /// The file is readable but holds no triangle.
    #[error("no triangles to grow on: {held}; export the model as a mesh with faces")]
    NoTriangles {
        /// What it holds instead.
        held: String,
    },
}

/// The result of a step of loading, before the file's name is known.
pub(super) type Parsed<T> = Result<T, LoadFault>;

impl LoadError {
    pub(super) fn in_file(path: &Path, fault: LoadFault) -> Self {
        Self {
            file: Some(path.to_path_buf()),
            fault,
        }
    }
}

impl From<LoadFault> for LoadError {
    fn from(fault: LoadFault) -> Self {
        Self { file: None, fault }
    }
}

impl fmt::Display for LoadError {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.file {
            Some(file) => write!(out, "{}: {}", file.display(), self.fault),
            None => self.fault.fmt(out),
        }
    }
}

impl std::error::Error for LoadError {}

impl LoadFault {
    pub(super) fn malformed(
        format: Format,
        place: impl Into<String>,
        problem: impl Into<String>,
        cure: impl Into<String>,
    ) -> Self {
        Self::Malformed {
            format,
            place: place.into(),
            problem: problem.into(),
            cure: cure.into(),
        }
    }
}
