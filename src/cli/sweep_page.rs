//! What a finished sweep is looked at by: tables, pictures, a contact sheet, one page.

use std::io::{self, Write};
use std::path::Path;

use thallus::export::write_file_atomically;
use thallus::substrate::Substrate;
use thallus::sweep::{Grid, Outcome, Plan, Results};

use super::failure::Failure;
use super::number::{duration, plural};
use super::sweep_args::PictureArgs;
use super::terminal::{self, Voice};

const CSV: &str = "results.csv";
const PARQUET: &str = "results.parquet";

/// Everything that is known of a sweep whose runs have ended.
pub(super) struct Page<'a> {
    pub(super) substrate: &'a Substrate,
    pub(super) grid: &'a Grid,
    pub(super) plan: &'a Plan,
    pub(super) folder: &'a Path,
    pub(super) outcomes: &'a [Result<Outcome, String>],
    pub(super) voice: Voice,
}

impl Page<'_> {
    /// Makes all of it; what stood there is replaced.
    pub(super) fn make(&self, _args: &PictureArgs) -> Result<(), Failure> {
        let table = self.results().table();
        self.write(CSV, |out| table.write_csv(out))?;
        self.write(PARQUET, |out| table.write_parquet(out))
    }

    pub(super) fn results(&self) -> Results<'_> {
        Results {
            grid: self.grid,
            plan: self.plan,
            outcomes: self.outcomes,
        }
    }

    fn write(
        &self,
        name: &str,
        fill: impl FnOnce(&mut dyn Write) -> io::Result<()>,
    ) -> Result<(), Failure> {
        Ok(write_file_atomically(&self.folder.join(name), true, fill)?)
    }

    /// Tells what there is now.
    pub(super) fn tell(&self) -> Result<(), Failure> {
        if self.voice.quiet {
            return Ok(());
        }
        let seconds = self.outcomes.iter().flatten().map(|o| o.seconds).sum();
        terminal::say(&format!(
            "{}: {} of {}, {} of growing\n  {CSV}, {PARQUET}",
            self.folder.display(),
            plural(self.plan.runs.len(), "run", "runs"),
            plural(self.plan.cells.len(), "cell", "cells"),
            duration(seconds),
        ))?;
        Ok(())
    }
}
