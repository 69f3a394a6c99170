//! A run's folder: each of its files appears complete when the run is done, or not at all. Only what
//! a killed run needs to go on ([`OutputDir::place`]) is there from the start.
//!
//! Files are written into a hidden folder `.thallus-run` inside the run's folder, and renamed from
//! there by [`OutputDir::commit`]; being on the same disk even where the folder is a mount or a
//! link, a rename cannot fail halfway through a file. A file in the hidden folder is locked while
//! the run lives, and the system lets go of it however the process ends, so what a killed run left
//! is recognized and cleared by the next.
//!
//! Not guaranteed: that a machine which loses power between two renames has all of the files.

use std::ffi::OsStr;
use std::fs::{self, File, OpenOptions, TryLockError};
use std::io::{self, ErrorKind, Write};
use std::path::{Path, PathBuf};
use std::process;
use std::sync::Arc;

use super::OutputError;
use super::atomic::{
    NewFolders, Unfinished, forget_unfinished, make_folder, sync_folder, unfinished, write_new,
};
use super::file_id::FileId;

const STAGE: &str = ".thallus-run";
const LOCK: &str = "lock";
const FILES: &str = "files";

/// A folder that is being written, and that no other run can write meanwhile.
///
/// Dropped without [`OutputDir::commit`] it leaves everything as it was, folders that it made
/// included, but for what was placed or removed at once.
#[derive(Debug)]
pub struct OutputDir {
    folder: PathBuf,
    force: bool,
    /// Names written so far, in order.
    written: Vec<String>,
    /// Names of files that these take the place of.
    outdated: Vec<String>,
    /// Names that are in their place already.
    placed: Vec<String>,
    /// Files that are not to be touched, in full.
    spared: Vec<PathBuf>,
    made: Option<NewFolders>,
    /// Held locked; closed before the stage is removed.
    lock: Option<Arc<File>>,
}

impl OutputDir {
    /// Makes the folder (and its parents), or takes over an empty one; with `force` also one that
    /// has files.
    ///
    /// # Errors
    /// [`OutputError::FolderExists`] without `force` when it has files; [`OutputError::NoName`];
    /// [`OutputError::NotAFolder`] when it or a parent is a file; [`OutputError::Locked`] when
    /// another run writes there; [`OutputError::Io`] when the system refuses, as in a folder that
    /// cannot be written.
    pub fn create(folder: &Path, force: bool) -> Result<Self, OutputError> {
        if folder.as_os_str().is_empty() {
            return Err(OutputError::NoName);
        }
        check_vacant(folder, force)?;
        let made = Some(NewFolders::make(folder)?);
        let folder = folder.to_owned();
        let mut dir = Self {
            folder,
            force,
            written: Vec::new(),
            outdated: Vec::new(),
            placed: Vec::new(),
            spared: Vec::new(),
            made,
            lock: None,
        };
        dir.stage()?;
        // Another run may have finished between the look and the lock.
        check_vacant(&dir.folder, force)?;
        Ok(dir)
    }

    /// The folder.
    pub fn path(&self) -> &Path {
        &self.folder
    }

    /// Writes a file of the folder through `fill`. It appears at [`OutputDir::commit`]; written
    /// twice, the later one does.
    ///
    /// # Errors
    /// The errors of `fill` and the system in [`OutputError::Io`], with the name under which the
    /// file would have appeared; before it is filled [`OutputError::IsRead`] when what it would replace is
    /// [spared](Self::spare). The file is then not part of the commit.
    ///
    /// # Panics
    /// When `name` is not a plain file name.
    pub fn write(
        &mut self,
        name: &str,
        fill: impl FnOnce(&mut dyn Write) -> io::Result<()>,
    ) -> Result<(), OutputError> {
        let paths = self.make_way(name)?;
        let result = fill_new(&paths, fill);
        self.note(name, result)
    }

    /// Writes two files as [`OutputDir::write`] does, at the same time where the present rayon pool has two threads.
    /// Both are filled also where that fails for one.
    ///
    /// # Errors
    /// As [`OutputDir::write`]; those of the first where both fail.
    ///
    /// # Panics
    /// When a name is not a plain file name, or both are the same.
    pub fn write_both<F, G>(
        &mut self,
        first: (&str, F),
        second: (&str, G),
    ) -> Result<(), OutputError>
    where
        F: FnOnce(&mut dyn Write) -> io::Result<()> + Send,
        G: FnOnce(&mut dyn Write) -> io::Result<()> + Send,
    {
        assert_ne!(first.0, second.0, "two files of one name");
        let paths = [self.make_way(first.0)?, self.make_way(second.0)?];
        let (one, other) = rayon::join(
            || fill_new(&paths[0], first.1),
            || fill_new(&paths[1], second.1),
        );
        let one = self.note(first.0, one);
        let other = self.note(second.0, other);
        one.and(other)
    }

    /// Where a file is to be written now, and its name in the folder; nothing is in either's way.
    fn make_way(&mut self, name: &str) -> Result<[PathBuf; 2], OutputError> {
        let plain = Path::new(name).file_name() == Some(OsStr::new(name));
        assert!(plain && name != STAGE, "'{name}' is not a plain file name");
        self.check_ours()?;
        self.check_spared(name)?;
        let shown = self.folder.join(name);
        if shown.is_dir() {
            return Err(OutputError::NotAFile(shown));
        }
        let staged = self.staged(name);
        if fs::remove_file(&staged).is_ok() {
            self.written.retain(|written| written != name);
        }
        Ok([staged, shown])
    }

    /// Takes in what came of writing a file.
    fn note(&mut self, name: &str, result: Result<(), OutputError>) -> Result<(), OutputError> {
        result.map(|()| self.written.push(name.to_owned()))
    }

    /// Writes a file of the folder through `fill` and puts it in its place at once, durably: a run
    /// that is killed leaves it there. What stood under its name is replaced.
    ///
    /// # Errors
    /// As [`OutputDir::write`], and when the system refuses the rename.
    ///
    /// # Panics
    /// When `name` is not a plain file name.
    pub fn place(
        &mut self,
        name: &str,
        fill: impl FnOnce(&mut dyn Write) -> io::Result<()>,
    ) -> Result<(), OutputError> {
        self.write(name, fill)?;
        self.written.pop();
        let place = self.folder.join(name);
        fs::rename(self.staged(name), &place).map_err(OutputError::io(&place, "writing"))?;
        sync_folder(&self.folder);
        if let Some(made) = self.made.take() {
            made.keep();
        }
        self.placed.push(name.to_owned());
        Ok(())
    }

    /// Takes files away at once, as far as they are there, and puts others in their place, durably, replacing files of
    /// the same names. Nothing is changed where that fails; a process killed in the middle may leave some of the old
    /// files away and some of the new ones not there yet.
    ///
    /// # Errors
    /// As [`OutputDir::place`]; [`OutputError::NotAFile`] when one of them is a folder, [`OutputError::IsRead`] when
    /// one is [spared](Self::spare).
    ///
    /// # Panics
    /// When a name is not a plain file name.
    pub fn replace(&mut self, away: &[&str], by: &[(&str, &[u8])]) -> Result<(), OutputError> {
        let named = by.iter().map(|(name, _)| *name);
        let named = named.filter(|name| !away.contains(name));
        let away = &away.iter().copied().chain(named).collect::<Vec<_>>();
        self.check_files(away)?;
        away.iter().try_for_each(|name| self.check_spared(name))?;
        for (name, bytes) in by {
            self.write(name, |out| out.write_all(bytes))?;
            self.written.pop();
        }
        self.exchange_or_not(away, by)?;
        sync_folder(&self.folder);
        if let Some(made) = self.made.take() {
            made.keep();
        }
        self.placed
            .extend(by.iter().map(|(name, _)| (*name).to_owned()));
        away.iter()
            .for_each(|name| drop(fs::remove_file(self.staged(&aside(name)))));
        Ok(())
    }

    /// All of it, or nothing where it fails or the program is told to end meanwhile.
    fn exchange_or_not(&self, away: &[&str], by: &[(&str, &[u8])]) -> Result<(), OutputError> {
        let _whole = unfinished();
        let mut moved = Vec::new();
        let done = self.exchange(away, by, &mut moved);
        if done.is_err() {
            for (from, to) in moved.iter().rev() {
                let _ = fs::rename(to, from);
            }
        }
        done
    }

    /// Renames files aside, and the staged ones into their places; what was renamed is told.
    fn exchange(
        &self,
        away: &[&str],
        by: &[(&str, &[u8])],
        moved: &mut Vec<(PathBuf, PathBuf)>,
    ) -> Result<(), OutputError> {
        let away = away
            .iter()
            .map(|name| (self.folder.join(name), self.staged(&aside(name))));
        let by = by
            .iter()
            .map(|(name, _)| (self.staged(name), self.folder.join(name)));
        let there = away.filter(|(place, _)| place.symlink_metadata().is_ok());
        for (from, to) in there.chain(by) {
            fs::rename(&from, &to).map_err(OutputError::io(&from, "replacing"))?;
            moved.push((from, to));
        }
        Ok(())
    }

    /// Refuses folders in the places of files.
    ///
    /// # Errors
    /// [`OutputError::NotAFile`], which names the folder.
    pub fn check_files(&self, names: &[&str]) -> Result<(), OutputError> {
        let mut places = names.iter().map(|name| self.folder.join(name));
        match places.find(|place| place.is_dir()) {
            Some(folder) => Err(OutputError::NotAFile(folder)),
            None => Ok(()),
        }
    }

    /// Removes a file of the folder at once, if it is there.
    ///
    /// # Errors
    /// When the system refuses; [`OutputError::IsRead`] when it is [spared](Self::spare).
    pub fn remove(&mut self, name: &str) -> Result<(), OutputError> {
        self.check_ours()?;
        self.check_spared(name)?;
        self.take_away(name)
    }

    /// Removes a file of the folder once what was written is in its place: one that this replaces under another name.
    pub fn outdate(&mut self, name: &str) {
        self.outdated.push(name.to_owned());
    }

    /// Keeps what is written or outdated from now on from replacing these files, or taking them away: what is read for
    /// it.
    pub fn spare(&mut self, files: &[PathBuf]) {
        let places = files.iter().filter_map(|file| file.canonicalize().ok());
        self.spared.extend(places);
    }

    /// Refuses to touch a file that is spared.
    fn check_spared(&self, name: &str) -> Result<(), OutputError> {
        let file = self.folder.join(name);
        match file.canonicalize() {
            Ok(place) if self.spared.contains(&place) => Err(OutputError::IsRead(file)),
            _ => Ok(()),
        }
    }

    fn take_away(&self, name: &str) -> Result<(), OutputError> {
        let place = self.folder.join(name);
        match fs::remove_file(&place) {
            Err(e) if e.kind() != ErrorKind::NotFound => {
                Err(OutputError::io(&place, "removing")(e))
            }
            _ => Ok(()),
        }
    }

    /// Puts every file in its place, in the order in which they were written, and takes away what they
    /// [outdate](Self::outdate). All other files are left alone.
    ///
    /// # Errors
    /// [`OutputError::FolderExists`] without `force` when one of the files appeared meanwhile, [`OutputError::IsRead`]
    /// when one that is to go is [spared](Self::spare), [`OutputError::NotAFile`] when a folder has the name of one,
    /// and nothing is put in place then; [`OutputError::Io`] when the system refuses a rename.
    pub fn commit(mut self) -> Result<(), OutputError> {
        self.check_ours()?;
        self.outdated
            .iter()
            .try_for_each(|name| self.check_spared(name))?;
        let names: Vec<&str> = self
            .written
            .iter()
            .chain(&self.outdated)
            .map(String::as_str)
            .collect();
        self.check_files(&names)?;
        let taken = |name: &String| {
            !self.placed.contains(name) && self.folder.join(name).symlink_metadata().is_ok()
        };
        if !self.force && self.written.iter().any(taken) {
            return Err(OutputError::FolderExists(self.folder.clone()));
        }
        self.put_in_place()?;
        sync_folder(&self.folder);
        if let Some(made) = self.made.take() {
            made.keep();
        }
        Ok(())
    }

    /// All of it, or nothing where the program is told to end meanwhile.
    fn put_in_place(&self) -> Result<(), OutputError> {
        let _whole = unfinished();
        for name in &self.written {
            let place = self.folder.join(name);
            fs::rename(self.staged(name), &place).map_err(OutputError::io(&place, "writing"))?;
        }
        self.outdated
            .iter()
            .try_for_each(|name| self.take_away(name))
    }

    /// Whether the hidden folder is still the one that this locked: the run's folder may have been moved or
    /// removed, and another run may have made a new one.
    fn is_ours(&self) -> io::Result<bool> {
        let stage = self.folder.join(STAGE);
        let lock = self.lock.as_ref();
        lock.map_or(Ok(false), |lock| is_locked_by(&stage, lock))
    }

    fn check_ours(&self) -> Result<(), OutputError> {
        let moved = || {
            let moved = "the folder was moved, replaced or removed while the run went on";
            Err(io::Error::new(ErrorKind::NotFound, moved))
        };
        let ours = self
            .is_ours()
            .and_then(|ours| if ours { Ok(()) } else { moved() });
        ours.map_err(OutputError::io(&self.folder, "writing"))
    }

    fn staged(&self, name: &str) -> PathBuf {
        self.folder.join(STAGE).join(FILES).join(name)
    }

    /// Makes the hidden folder, locks it, and clears what a killed run left there.
    fn stage(&mut self) -> Result<(), OutputError> {
        let stage = self.folder.join(STAGE);
        let lock = Arc::new(lock_in(&stage, &self.folder)?);
        unfinished().push(Unfinished::Stage {
            path: stage.clone(),
            lock: Arc::clone(&lock),
        });
        self.lock = Some(lock);
        let files = stage.join(FILES);
        let doing = "making the folder";
        match fs::remove_dir_all(&files) {
            Err(e) if e.kind() != ErrorKind::NotFound => Err(OutputError::io(&files, doing)(e)),
            _ => make_folder(&files),
        }
    }
}

/// Writes a file through `fill`, or leaves none.
fn fill_new(
    [staged, shown]: &[PathBuf; 2],
    fill: impl FnOnce(&mut dyn Write) -> io::Result<()>,
) -> Result<(), OutputError> {
    let result = write_new(staged, shown, fill);
    if result.is_err() {
        let _ = fs::remove_file(staged);
    }
    result
}

impl Drop for OutputDir {
    fn drop(&mut self) {
        let stage = self.folder.join(STAGE);
        // Without the lock the hidden folder is another run's.
        if self.is_ours().unwrap_or(false) {
            let _ = fs::remove_dir_all(stage.join(FILES));
            let _ = fs::remove_file(stage.join(LOCK));
        }
        if self.lock.take().is_some() {
            forget_unfinished(&stage);
        }
        let _ = fs::remove_dir(stage);
    }
}

/// Whether a hidden folder is still the one with this lock.
pub(super) fn is_locked_by(stage: &Path, lock: &File) -> io::Result<bool> {
    FileId::of(lock)?.is_still_at(&stage.join(LOCK))
}

fn check_vacant(folder: &Path, force: bool) -> Result<(), OutputError> {
    let entries = match fs::read_dir(folder) {
        Ok(entries) => entries,
        Err(e) if e.kind() == ErrorKind::NotFound => return Ok(()),
        Err(e) => return Err(OutputError::io(folder, "opening the folder")(e)),
    };
    let foreign = |entry: io::Result<fs::DirEntry>| !entry.is_ok_and(|e| e.file_name() == STAGE);
    if !force && entries.into_iter().any(foreign) {
        return Err(OutputError::FolderExists(folder.to_owned()));
    }
    Ok(())
}

/// Makes the hidden folder and locks the file in it.
fn lock_in(stage: &Path, folder: &Path) -> Result<File, OutputError> {
    const TRIES: usize = 100;
    for _ in 0..TRIES {
        make_folder(stage)?;
        if let Some(file) = lock(&stage.join(LOCK), folder)? {
            return Ok(file);
        }
    }
    Err(OutputError::Locked {
        folder: folder.to_owned(),
        process: None,
    })
}

/// Locks the file, or `None` when its last holder removed it in this moment: try again then.
fn lock(path: &Path, folder: &Path) -> Result<Option<File>, OutputError> {
    let doing = "locking the folder";
    let opened = OpenOptions::new()
        .read(true)
        .write(true)
        .create(true)
        .truncate(false)
        .open(path);
    let mut file = match opened {
        // A link that leads nowhere stays.
        Err(e) if e.kind() == ErrorKind::NotFound && !path.is_symlink() => return Ok(None),
        result => result.map_err(OutputError::io(folder, doing))?,
    };
    match file.try_lock() {
        Ok(()) => {}
        // Some network file systems have no locks; a run is worth more than the precaution.
        Err(TryLockError::Error(e)) if e.kind() == ErrorKind::Unsupported => {}
        Err(TryLockError::WouldBlock) => return Err(locked(path, folder)),
        Err(TryLockError::Error(e)) => return Err(OutputError::io(folder, doing)(e)),
    }
    let is_still_there = FileId::of(&file).and_then(|id| id.is_still_at(path));
    if !is_still_there.map_err(OutputError::io(folder, doing))? {
        return Ok(None);
    }
    let write = file
        .set_len(0)
        .and_then(|()| write!(file, "{}", process::id()));
    if let Err(e) = write {
        let _ = fs::remove_file(path);
        return Err(OutputError::io(folder, doing)(e));
    }
    Ok(Some(file))
}

fn locked(path: &Path, folder: &Path) -> OutputError {
    let process = fs::read_to_string(path)
        .ok()
        .and_then(|text| text.trim().parse().ok());
    OutputError::Locked {
        folder: folder.to_owned(),
        process,
    }
}

/// The name under which a file waits for what takes its place.
fn aside(name: &str) -> String {
    format!("{name}.earlier")
}
