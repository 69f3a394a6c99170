//! A sweep whose runs have ended.

use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use thallus::run::shell_path;
use thallus::substrate::Substrate;
use thallus::sweep::{Grid, Outcome, Plan, Results};

use super::cutout::Cutout;
use super::failure::Failure;
use super::number::count;
use super::sweep_files::GRID;
use super::terminal::{self, Voice};

/// Everything that is known of it.
pub(super) struct Ended<'a> {
    pub(super) substrate: &'a Substrate,
    /// What of it is seen, if not all is.
    pub(super) cutout: Option<&'a Cutout>,
    pub(super) grid: &'a Grid,
    pub(super) plan: &'a Plan,
    pub(super) folder: &'a Path,
    pub(super) outcomes: &'a [Result<Outcome, String>],
    /// Set when somebody asks to stop.
    pub(super) cancel: Arc<AtomicBool>,
    pub(super) voice: Voice,
}

impl Ended<'_> {
    pub(super) fn results(&self) -> Results<'_> {
        Results {
            grid: self.grid,
            plan: self.plan,
            outcomes: self.outcomes,
        }
    }

    /// Ends the command when somebody asked to stop.
    pub(super) fn check_cancelled(&self) -> Result<(), Failure> {
        match self.cancel.load(Ordering::Relaxed) {
            true => Err(self.interrupted()),
            false => Ok(()),
        }
    }

    /// Tells that somebody asked to stop.
    pub(super) fn interrupted(&self) -> Failure {
        let failed = match self.failed() {
            0 => String::new(),
            failed => format!(", {} of them failed", count(failed as u64)),
        };
        terminal::warn(&format!(
            "interrupted: every run has ended{failed}; the page is not made: thallus sweep {} -o {} makes it",
            shell_path(&self.folder.join(GRID)),
            shell_path(self.folder)
        ));
        Failure::Interrupted
    }

    /// How many runs failed.
    pub(super) fn failed(&self) -> usize {
        self.outcomes.iter().filter(|o| o.is_err()).count()
    }
}
