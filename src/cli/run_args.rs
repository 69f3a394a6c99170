//! Flags that every command has that works on a grown lichen.

use anyhow::Context;
use clap::Args;
use clap::builder::TypedValueParser;

use super::failure::Failure;
use super::terminal::Voice;

/// The heading of these flags in help texts.
pub(crate) const RUN: &str = "Run";

#[derive(Debug, Args)]
pub(crate) struct RunArgs {
    /// No progress, notes or warnings: only errors and what was asked for
    #[arg(long, help_heading = RUN)]
    pub(crate) quiet: bool,
    /// Threads to use, up to 1024; the result is the same for any number [default: all cores]
    #[arg(allow_negative_numbers = true, long, help_heading = RUN, value_name = "N", value_parser = threads())]
    pub(crate) threads: Option<u16>,
}

/// As many as `--threads` takes.
pub(super) fn threads() -> impl TypedValueParser<Value = u16> {
    clap::value_parser!(u16).range(1..=1024)
}

impl RunArgs {
    pub(crate) fn voice(&self) -> Voice {
        Voice { quiet: self.quiet }
    }
}

/// Starts so many threads, or one a core.
pub(super) fn start_threads(threads: Option<u16>) -> Result<(), Failure> {
    rayon::ThreadPoolBuilder::new()
        .num_threads(threads.map_or(0, usize::from))
        .build_global()
        .context(
            "threads could not be started: give fewer of them (--threads), end other processes, or raise what the \
             shell allows in processes (ulimit -u) and memory (ulimit -v)",
        )?;
    Ok(())
}
