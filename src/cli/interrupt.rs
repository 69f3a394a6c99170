//! Ctrl-C: the first ends the growth well, the second quits at once.

use std::io;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use super::{INTERRUPTED, terminal};

/// Makes Ctrl-C (and a polite kill) set `cancel`, and a second one quit.
pub(crate) fn listen(cancel: Arc<AtomicBool>) {
    let saying = "\nStopping: the current element is finished and what there is gets written. \
                  Ctrl-C again quits at once.";
    if let Err(e) = set(cancel, saying) {
        terminal::warn(&format!("Ctrl-C will lose what has grown: {e}"));
    }
}

fn set(cancel: Arc<AtomicBool>, saying: &'static str) -> Result<(), ctrlc::Error> {
    ctrlc::set_handler(move || {
        if cancel.swap(true, Ordering::Relaxed) {
            std::process::exit(i32::from(INTERRUPTED));
        }
        terminal::plain(saying);
    })
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
#[derive(Default)]
pub(crate) struct Stop(Arc<AtomicBool>);

impl Stop {
    /// Told by Ctrl-C, or a polite kill.
    pub(crate) fn listen() -> Self {
        let stop = Self::default();
        let saying = "\nStopping: nothing is written. Ctrl-C again quits at once.";
        if let Err(e) = set(Arc::clone(&stop.0), saying) {
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

    pub(crate) fn is_told(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }
}
