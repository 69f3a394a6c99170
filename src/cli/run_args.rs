//! Flags that every command has that works on a grown lichen.

use clap::Args;

use super::terminal::Voice;

/// The heading of these flags in help texts.
pub(crate) const RUN: &str = "Run";

#[derive(Debug, Args)]
pub(crate) struct RunArgs {
    /// No progress, notes or warnings: only errors and what was asked for
    #[arg(long, help_heading = RUN)]
    pub(crate) quiet: bool,
    /// Threads to use, up to 1024; the result is the same for any number [default: all cores]
    #[arg(allow_negative_numbers = true, long, help_heading = RUN, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub(crate) threads: Option<u16>,
}

impl RunArgs {
    pub(crate) fn voice(&self) -> Voice {
        Voice { quiet: self.quiet }
    }
}
