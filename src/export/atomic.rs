//! A file that appears complete or not at all: written beside its place under another name,
//! flushed to the disk, then renamed.

use std::collections::BTreeSet;
use std::fs::{self, File, OpenOptions, TryLockError};
use std::io::{self, BufWriter, ErrorKind, Write};
use std::mem;
use std::path::{Component, Path, PathBuf};
use std::process;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, OnceLock, PoisonError};

use super::{OutputError, output_dir};

/// Writes one file through `fill`, so that it appears complete or not at all.
///
/// Missing parent folders are made. What killed programs have left of files in the same folder is removed, the first
/// time that this process writes there. When anything fails, `fill` and a panic included, the
/// temporary file is removed and what stood at `path` is untouched. The mode is what the umask
/// says. Where `path` is a symbolic link, the link is replaced.
///
/// # Errors
/// [`OutputError::FileExists`] without `force` when something is at `path`, before `fill` is
/// called or when it appeared meanwhile; [`OutputError::NotAFile`] when that is a folder; the
/// errors of `fill` and the system in [`OutputError::Io`].
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
    unfinished.iter().rev().for_each(Unfinished::remove);
    mem::forget(unfinished);
}

/// What is gone if what it is for is not finished.
#[derive(Debug)]
pub(super) enum Unfinished {
    /// A file, or a folder as far as it is empty.
    Path(PathBuf),
    /// The hidden folder of a run, as long as it is the one with this lock.
    Stage { path: PathBuf, lock: Arc<File> },
}

impl Unfinished {
    pub(super) fn path(&self) -> &Path {
        match self {
            Self::Path(path) | Self::Stage { path, .. } => path,
        }
    }

    fn remove(&self) {
        let _ = match self {
            Self::Path(path) => fs::remove_file(path).or_else(|_| fs::remove_dir(path)),
            Self::Stage { path, lock } => match output_dir::is_locked_by(path, lock) {
                Ok(true) => fs::remove_dir_all(path),
                _ => Ok(()),
            },
        };
    }
}

/// All that is unfinished, each after the folder that it is in.
pub(super) fn unfinished() -> MutexGuard<'static, Vec<Unfinished>> {
    static UNFINISHED: Mutex<Vec<Unfinished>> = Mutex::new(Vec::new());
    UNFINISHED.lock().unwrap_or_else(PoisonError::into_inner)
}

pub(super) fn forget_unfinished(path: &Path) {
    unfinished().retain(|one| one.path() != path);
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
        unfinished.extend(made.0.iter().cloned().map(Unfinished::Path));
        let result = make_folder(folder);
        drop(unfinished);
        result.map(|()| made)
    }

    /// Leaves them in place, durably.
    pub(super) fn keep(mut self) {
        unfinished().retain(|one| !self.0.iter().any(|folder| folder == one.path()));
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
            unfinished.retain(|one| one.path() != folder);
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

/// Names the system that is running: whoever runs on the same one sees the same locks. Elsewhere than on Linux the
/// systems that share a disk see each other's.
fn system() -> &'static str {
    static SYSTEM: OnceLock<String> = OnceLock::new();
    SYSTEM.get_or_init(|| {
        let id = fs::read_to_string("/proc/sys/kernel/random/boot_id").unwrap_or_default();
        id.chars().filter(char::is_ascii_hexdigit).take(8).collect()
    })
}

/// Locks a file that is being written, and tells whether nobody has taken it for abandoned before.
fn is_kept(path: &Path, file: &File) -> bool {
    !matches!(file.try_lock(), Err(TryLockError::WouldBlock)) && path.exists()
}

/// Removes what killed processes of this system have left in a folder: what nobody has locked. It is looked through
/// once.
fn clear_abandoned(folder: &Path) {
    static LOOKED_THROUGH: Mutex<BTreeSet<PathBuf>> = Mutex::new(BTreeSet::new());
    let mut looked = LOOKED_THROUGH
        .lock()
        .unwrap_or_else(PoisonError::into_inner);
    if !looked.insert(folder.to_owned()) {
        return;
    }
    let ours = format!("{PREFIX}{}-", system());
    let is_part = |name: &str| name.starts_with(&ours) && name.ends_with(SUFFIX);
    let entries = fs::read_dir(folder).into_iter().flatten().flatten();
    for entry in entries.filter(|entry| entry.file_name().to_str().is_some_and(is_part)) {
        let is_file = entry.file_type().is_ok_and(|kind| kind.is_file());
        // Some network file systems lock only what is open for writing.
        let open = || OpenOptions::new().write(true).open(entry.path()).ok();
        let opened = is_file.then(open).flatten();
        if opened.is_some_and(|file| file.try_lock().is_ok()) {
            let _ = fs::remove_file(entry.path());
        }
    }
}

/// Names that are tried for one file.
const MOST_TRIES: u32 = 1000;

/// A name that this process has not given yet.
fn part_name() -> String {
    static COUNTER: AtomicU64 = AtomicU64::new(0);
    let count = COUNTER.fetch_add(1, Ordering::Relaxed);
    format!("{PREFIX}{}-{}-{count}{SUFFIX}", system(), process::id())
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
        let mut unfinished = unfinished();
        clear_abandoned(folder);
        let mut tries = 0..MOST_TRIES;
        loop {
            let path = folder.join(part_name());
            let made = OpenOptions::new().write(true).create_new(true).open(&path);
            let is_last = tries.next().is_none();
            match made {
                Ok(file) if is_last || is_kept(&path, &file) => {
                    unfinished.push(Unfinished::Path(path.clone()));
                    return Ok(Self { file, path });
                }
                Ok(_) => drop(fs::remove_file(&path)),
                // A killed process that had the same number left it.
                Err(e) if e.kind() == ErrorKind::AlreadyExists && !is_last => {}
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
        forget_unfinished(&self.path);
    }
}
