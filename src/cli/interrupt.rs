//! Ctrl-C: the first ends the growth well, the second quits at once, without half of a file.

use std::io;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError, mpsc};
use std::thread;
use std::time::Duration;

use tempfile::TempDir;
use thallus::export::discard_unfinished_files;

use super::failure::Failure;
use super::{INTERRUPTED, terminal};

/// Makes Ctrl-C (and a polite kill) set `cancel`, and a second one quit.
pub(crate) fn listen(cancel: Arc<AtomicBool>) {
    let saying = "\nStopping: what there is gets written. Ctrl-C again quits at once.";
    if let Err(e) = set(cancel, saying, || {}) {
        terminal::warn(&format!("Ctrl-C will lose what has grown: {e}"));
    }
}

/// `first` is done at the first one, after it has been said.
fn set(
    cancel: Arc<AtomicBool>,
    saying: &'static str,
    first: impl Fn() + Send + 'static,
) -> Result<(), ctrlc::Error> {
    ctrlc::set_handler(move || {
        if cancel.swap(true, Ordering::Relaxed) {
            quit();
        }
        say(saying);
        first();
    })
}

/// How long it may take to say something, before what is to be done is done all the same.
const PATIENCE: Duration = Duration::from_millis(200);

/// Says something without waiting for ever for whoever should read it: the second Ctrl-C would never come.
fn say(line: &'static str) {
    let (said, heard) = mpsc::channel();
    let saying = thread::Builder::new().spawn(move || {
        terminal::plain(line);
        said.send(())
    });
    if saying.is_ok() {
        let _ = heard.recv_timeout(PATIENCE);
    }
}

/// Makes Ctrl-C (and a polite kill) quit at once, but without the file that is being written.
pub(crate) fn leave_no_part() {
    if let Err(e) = ctrlc::set_handler(|| quit()) {
        terminal::warn(&format!("Ctrl-C may leave a hidden file behind: {e}"));
    }
}

/// Folders of other programs' files that are gone when this one quits.
static HIDDEN: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());

/// A hidden folder in another one, for what is gone in the end.
pub(crate) struct Hidden(TempDir);

impl Hidden {
    pub(crate) fn make_in(folder: &Path) -> io::Result<Self> {
        let mut hidden = HIDDEN.lock().unwrap_or_else(PoisonError::into_inner);
        let made = tempfile::tempdir_in(folder)?;
        hidden.push(made.path().to_owned());
        Ok(Self(made))
    }

    pub(crate) fn path(&self) -> &Path {
        self.0.path()
    }
}

fn quit() -> ! {
    let hidden = HIDDEN.lock().unwrap_or_else(PoisonError::into_inner);
    hidden
        .iter()
        .for_each(|folder| drop(std::fs::remove_dir_all(folder)));
    discard_unfinished_files();
    std::process::exit(i32::from(INTERRUPTED))
}

/// Makes a file that grows beyond what the system lets it be an error, as a full disk is: otherwise the
/// system ends the program without a word.
pub(crate) fn survive_file_limits() {
    #[cfg(unix)]
    if let Err(e) = signal_hook::flag::register(signal_hook::consts::SIGXFSZ, Arc::default()) {
        terminal::warn(&format!(
            "a file beyond the system's limit will end this: {e}"
        ));
    }
}

/// Whether something that leaves nothing when it is stopped has been told to.
#[derive(Clone, Default)]
pub(crate) struct Stop(Arc<AtomicBool>);

impl Stop {
    /// Told by Ctrl-C, or a polite kill.
    pub(crate) fn listen() -> Self {
        Self::listen_and(|| {})
    }

    fn listen_and(first: impl Fn() + Send + 'static) -> Self {
        let stop = Self::default();
        let saying = "\nStopping: nothing is written. Ctrl-C again quits at once.";
        if let Err(e) = set(Arc::clone(&stop.0), saying, first) {
            terminal::warn(&format!("Ctrl-C will leave a hidden folder behind: {e}"));
        }
        stop
    }

    /// An error once it has been told.
    pub(crate) fn check(&self) -> io::Result<()> {
        match self.is_told() {
            true => Err(io::Error::other("interrupted")),
            false => Ok(()),
        }
    }

    /// The end of a command once it has been told.
    pub(crate) fn go_on(&self) -> Result<(), Failure> {
        self.check().map_err(|_| Failure::Interrupted)
    }

    /// Why something failed: an error, or that it was told to stop.
    pub(crate) fn reason(&self, error: impl Into<Failure>) -> Failure {
        match self.is_told() {
            true => Failure::Interrupted,
            false => error.into(),
        }
    }

    pub(crate) fn is_told(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }
}

/// What Ctrl-C drops before it quits at once, in the middle of work that cannot be stopped; once it has
/// been taken, who took it is told to stop.
pub(crate) struct Held<T> {
    what: Arc<Mutex<Option<T>>>,
    stop: Stop,
}

impl<T> Drop for Held<T> {
    /// Ctrl-C is listened to for as long as the program runs.
    fn drop(&mut self) {
        drop(taken(&self.what));
    }
}

impl<T: Send + 'static> Held<T> {
    pub(crate) fn listen(what: T) -> Self {
        let what = Arc::new(Mutex::new(Some(what)));
        let held = Arc::clone(&what);
        let stop = Stop::listen_and(move || {
            // Whoever asks for it meanwhile waits until the program is gone.
            let mut held = held.lock().unwrap_or_else(PoisonError::into_inner);
            if let Some(what) = held.take() {
                drop(what);
                quit();
            }
        });
        Self { what, stop }
    }

    /// Lends it to work that looks whether it is told to stop; nothing where Ctrl-C came before or meanwhile.
    pub(crate) fn lend<R>(&self, work: impl FnOnce(&mut T, &Stop) -> R) -> Option<R> {
        let mut what = taken(&self.what)?;
        let done = work(&mut what, &self.stop);
        let mut place = self.what.lock().unwrap_or_else(PoisonError::into_inner);
        *place = Some(what);
        (!self.stop.is_told()).then_some(done)
    }

    /// Nothing where Ctrl-C came first: the program is about to end.
    pub(crate) fn take(self) -> Option<(T, Stop)> {
        taken(&self.what).map(|what| (what, self.stop.clone()))
    }
}

fn taken<T>(held: &Mutex<Option<T>>) -> Option<T> {
    held.lock().unwrap_or_else(PoisonError::into_inner).take()
}
