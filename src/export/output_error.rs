//! Why an output could not be written.

use std::io;
use std::path::{Path, PathBuf};

/// Why an output could not be written. Each message says what to do.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum OutputError {
    /// The name is empty, as from an unset variable.
    #[error("the output has no name: say where it goes")]
    NoName,
    /// The file is there already.
    #[error("{} exists already, and is overwritten only by force: choose another name", .0.display())]
    FileExists(PathBuf),
    /// The folder is there already and is not empty.
    #[error(
        "{} exists already and is not empty, and what an earlier run wrote there is replaced only by force: \
         choose another folder", .0.display()
    )]
    FolderExists(PathBuf),
    /// A file, or a link that leads to no folder, stands where a folder is needed.
    #[error("{} is {}, and a folder is needed there: choose another name", .0.display(), kind(.0))]
    NotAFolder(PathBuf),
    /// A folder stands where a file is needed.
    #[error("{} is a folder, and a file is needed there: choose another name", .0.display())]
    NotAFile(PathBuf),
    /// What stands there is read for what is to be written.
    #[error("{} is read for this, which would replace it or take it away: choose another place", .0.display())]
    IsRead(PathBuf),
    /// Another run writes into the folder now.
    #[error(
        "{} is being written by another run{}: wait for it, or choose another folder",
        .folder.display(), number(.process)
    )]
    Locked {
        /// The folder.
        folder: PathBuf,
        /// The other run's process number, as far as it is known.
        process: Option<u32>,
    },
    /// The system refused.
    #[error("{}: {}{problem}{}", .path.display(), tried(.doing, .problem), cure(.problem))]
    Io {
        /// The file or folder.
        path: PathBuf,
        /// What was tried.
        doing: &'static str,
        /// The system's reason.
        problem: io::Error,
    },
}

impl OutputError {
    /// Wraps the system's reason; for `map_err`.
    pub(super) fn io(path: &Path, doing: &'static str) -> impl FnOnce(io::Error) -> Self {
        move |problem| match problem.kind() {
            io::ErrorKind::NotADirectory => Self::not_a_folder(path),
            _ => Self::Io {
                path: path.to_owned(),
                doing,
                problem,
            },
        }
    }

    /// Names the file among `path` and its parents that stands where a folder is needed.
    pub(super) fn not_a_folder(path: &Path) -> Self {
        let file = path
            .ancestors()
            .find(|p| p.symlink_metadata().is_ok() && !p.is_dir());
        Self::NotAFolder(file.unwrap_or(path).to_owned())
    }
}

fn kind(path: &Path) -> &'static str {
    // A slash at its end, which asks for a folder, is no part of its name.
    match path.components().as_path().exists() {
        true => "a file",
        false => "a link that leads nowhere",
    }
}

fn number(id: &Option<u32>) -> String {
    id.map_or_else(String::new, |id| format!(" (process {id})"))
}

/// What was tried, where the system refused; what cannot be written is not its fault.
fn tried(doing: &str, reason: &io::Error) -> String {
    match reason.kind() == io::ErrorKind::InvalidInput && reason.raw_os_error().is_none() {
        true => String::new(),
        false => format!("{doing} failed: "),
    }
}

fn cure(reason: &io::Error) -> &'static str {
    use io::ErrorKind as Kind;
    match reason.kind() {
        Kind::StorageFull | Kind::QuotaExceeded => "; make room or choose another disk",
        Kind::FileTooLarge => "; raise the limit on the size of files (ulimit -f)",
        Kind::PermissionDenied | Kind::ReadOnlyFilesystem => "; choose a place where you may write",
        Kind::InvalidFilename => "; choose a shorter name",
        _ => "",
    }
}
