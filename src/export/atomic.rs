//! A file that appears complete or not at all: written beside its place under another name,
//! flushed to the disk, then renamed.

use std::collections::BTreeSet;
use std::fs::{self, File, OpenOptions, TryLockError};
use std::io::{self, BufWriter, ErrorKind, Write};
use std::mem;
use std::path::{Component, Path, PathBuf};
use std::process;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};

use super::{OutputError, output_dir};

/// Writes one file through `fill`, so that it appears complete or not at all.
///
/// Missing parent folders are made. When anything fails, `fill` and a panic included, the
/// temporary file is removed and what stood at `path` is untouched. The mode is what the umask
/// says. Where `path` is a symbolic link, the link is replaced.
///
/// # Errors
/// [`OutputError::FileExists`] without `force` when something is at `path`, before `fill` is
/// called or when it appeared meanwhile; [`OutputError::NotAFile`] when that is a folder; the
/// errors of `fill` and the system in [`OutputError::Io`].
///
/// What a killed program has left of a file in the same folder is removed.
pub fn write_file_atomically(
    path: &Path,
    force: bool,
    fill: impl FnOnce(&mut dyn Write) -> io::Result<()>,
) -> Result<(), OutputError> {
    check_free(path, force)?;
    let folder = folder_of(path);
    let made = NewFolders::make(folder)?;
    let mut partial = Partial::create(folder, path)?;
    partial.fill(path, fill)?;
    partial.persist(path, force)?;
    sync_folder(folder);
    made.keep();
    Ok(())
}

/// Removes what [`write_file_atomically`] and [`OutputDir`](super::OutputDir) have not finished, with the folders
/// that they made for it, and lets them finish nothing more: for a program that is about to end in the middle of its
/// work, as on Ctrl-C.
///
/// From then on whoever writes, or calls this again, waits for the end of the program.
pub fn discard_unfinished_files() {
    let unfinished = unfinished();
    for path in unfinished.iter().rev() {
        let _ = match output_dir::is_stage_of_this_process(path) {
            true => fs::remove_dir_all(path),
            false => fs::remove_file(path).or_else(|_| fs::remove_dir(path)),
        };
    }
    mem::forget(unfinished);
}

/// Files and folders that are gone if what they are for is not finished, each after the folder that it is in.
pub(super) fn unfinished() -> MutexGuard<'static, Vec<PathBuf>> {
    static UNFINISHED: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());
    UNFINISHED.lock().unwrap_or_else(PoisonError::into_inner)
}

fn check_free(path: &Path, force: bool) -> Result<(), OutputError> {
    if path.as_os_str().is_empty() {
        return Err(OutputError::NoName);
    }
    if path.is_dir() || path.file_name().is_none() {
        return Err(OutputError::NotAFile(path.to_owned()));
    }
    // A dangling link exists too.
    if !force && path.symlink_metadata().is_ok() {
        return Err(OutputError::FileExists(path.to_owned()));
    }
    Ok(())
}

/// Folders that did not exist before: removed when dropped, as far as they are empty.
#[derive(Debug)]
pub(super) struct NewFolders(Vec<PathBuf>);

impl NewFolders {
    /// Makes a folder and its parents, as far as they are missing.
    pub(super) fn make(folder: &Path) -> Result<Self, OutputError> {
        let mut unfinished = unfinished();
        let made = Self(missing(folder));
        unfinished.extend_from_slice(&made.0);
        let result = make_folder(folder);
        drop(unfinished);
        result.map(|()| made)
    }

    /// Leaves them in place, durably.
    pub(super) fn keep(mut self) {
        unfinished().retain(|path| !self.0.contains(path));
        for folder in self.0.drain(..) {
            sync_folder(folder_of(&folder));
        }
    }
}

impl Drop for NewFolders {
    fn drop(&mut self) {
        let mut unfinished = unfinished();
        for folder in self.0.iter().rev() {
            let _ = fs::remove_dir(folder);
            unfinished.retain(|path| path != folder);
        }
    }
}

/// The folder and its parents as far as they do not exist, outermost first.
fn missing(folder: &Path) -> Vec<PathBuf> {
    let named = |path: &&Path| matches!(path.components().next_back(), Some(Component::Normal(_)));
    let absent = |path: &&Path| path.symlink_metadata().is_err();
    let mut missing: Vec<_> = folder
        .ancestors()
        .filter(named)
        .take_while(absent)
        .map(Path::to_owned)
        .collect();
    missing.reverse();
    missing
}

/// The folder that holds `path`.
fn folder_of(path: &Path) -> &Path {
    path.parent()
        .filter(|p| !p.as_os_str().is_empty())
        .unwrap_or(Path::new("."))
}

/// Makes a folder and its parents.
pub(super) fn make_folder(folder: &Path) -> Result<(), OutputError> {
    match fs::create_dir_all(folder) {
        Err(e) if e.kind() == ErrorKind::AlreadyExists => Err(OutputError::not_a_folder(folder)),
        result => result.map_err(OutputError::io(folder, "making the folder")),
    }
}

/// Makes renames durable. Best effort: not every system can open or flush a folder, and the
/// files' contents are on the disk already.
pub(super) fn sync_folder(folder: &Path) {
    if let Ok(opened) = File::open(folder) {
        let _ = opened.sync_all();
    }
}

/// Creates `path`, fills it, and flushes it to the disk. `path` must not exist.
pub(super) fn write_new(
    path: &Path,
    shown: &Path,
    fill: impl FnOnce(&mut dyn Write) -> io::Result<()>,
) -> Result<(), OutputError> {
    let file = OpenOptions::new().write(true).create_new(true).open(path);
    let file = file.map_err(OutputError::io(shown, "making the file"))?;
    fill_file(&file, fill).map_err(OutputError::io(shown, "writing"))
}

fn fill_file(file: &File, fill: impl FnOnce(&mut dyn Write) -> io::Result<()>) -> io::Result<()> {
    let mut out = BufWriter::with_capacity(1 << 16, file);
    let result = fill(&mut out).and_then(|()| out.flush());
    // A writer that failed must not try again when it is dropped.
    drop(out.into_parts());
    result?;
    file.sync_all()
}

const PREFIX: &str = ".thallus-";
const SUFFIX: &str = ".part";

/// Locks a file that is being written, and tells whether it is still there.
fn is_kept(path: &Path, file: &File) -> bool {
    !matches!(file.try_lock(), Err(TryLockError::WouldBlock))
        && output_dir::is_still_at(path, file).unwrap_or(true)
}

/// Removes what killed processes have left in a folder: what nobody has locked. It is looked through once.
fn clear_abandoned(folder: &Path) {
    static LOOKED_THROUGH: Mutex<BTreeSet<PathBuf>> = Mutex::new(BTreeSet::new());
    let mut looked = LOOKED_THROUGH
        .lock()
        .unwrap_or_else(PoisonError::into_inner);
    if !looked.insert(folder.to_owned()) {
        return;
    }
    let names = fs::read_dir(folder).into_iter().flatten().flatten();
    let is_part = |name: &str| name.starts_with(PREFIX) && name.ends_with(SUFFIX);
    for entry in names.filter(|entry| entry.file_name().to_str().is_some_and(is_part)) {
        let is_file = entry.file_type().is_ok_and(|kind| kind.is_file());
        let opened = is_file.then(|| File::open(entry.path()).ok()).flatten();
        if opened.is_some_and(|file| file.try_lock().is_ok()) {
            let _ = fs::remove_file(entry.path());
        }
    }
}

/// A temporary file that is removed when dropped.
struct Partial {
    file: File,
    path: PathBuf,
}

impl Partial {
    /// Opened by hand and not by `tempfile`, which makes files that only their owner can read. It stays locked
    /// until it is whole, or the process ends.
    fn create(folder: &Path, shown: &Path) -> Result<Self, OutputError> {
        static COUNTER: AtomicU64 = AtomicU64::new(0);
        let mut unfinished = unfinished();
        clear_abandoned(folder);
        loop {
            let count = COUNTER.fetch_add(1, Ordering::Relaxed);
            let path = folder.join(format!("{PREFIX}{}-{count}{SUFFIX}", process::id()));
            match OpenOptions::new().write(true).create_new(true).open(&path) {
                // Somebody took it for abandoned before it was locked.
                Ok(file) if !is_kept(&path, &file) => {}
                Ok(file) => {
                    unfinished.push(path.clone());
                    return Ok(Self { file, path });
                }
                // A killed process that had the same number left it.
                Err(e) if e.kind() == ErrorKind::AlreadyExists && count < 1 << 20 => {}
                Err(e) => return Err(OutputError::io(shown, "making the file")(e)),
            }
        }
    }

    fn fill(
        &mut self,
        shown: &Path,
        fill: impl FnOnce(&mut dyn Write) -> io::Result<()>,
    ) -> Result<(), OutputError> {
        fill_file(&self.file, fill).map_err(OutputError::io(shown, "writing"))
    }

    fn persist(self, path: &Path, force: bool) -> Result<(), OutputError> {
        let unfinished = unfinished();
        if force {
            return fs::rename(&self.path, path).map_err(OutputError::io(path, "writing"));
        }
        // A second name is refused when the first is taken, which a rename is not.
        match fs::hard_link(&self.path, path) {
            Ok(()) => Ok(()),
            Err(e) if e.kind() == ErrorKind::AlreadyExists => {
                Err(OutputError::FileExists(path.to_owned()))
            }
            // Not every file system has hard links.
            Err(_) => {
                check_free(path, false)?;
                drop(unfinished);
                self.persist(path, true)
            }
        }
    }
}

impl Drop for Partial {
    fn drop(&mut self) {
        // Not there where it was renamed.
        let _ = fs::remove_file(&self.path);
        unfinished().retain(|path| *path != self.path);
    }
}
