//! The one place that writes to stdout and stderr.

use std::io::{self, IsTerminal, Write};

/// What is said beside errors and results.
#[derive(Clone, Copy)]
pub(crate) struct Voice {
    pub(crate) quiet: bool,
}

impl Voice {
    pub(crate) fn note(self, line: &str) {
        if !self.quiet {
            note(line);
        }
    }

    pub(crate) fn warn(self, line: &str) {
        if !self.quiet {
            warn(line);
        }
    }
}

/// A line of the result, to stdout.
pub(crate) fn say(line: &str) -> io::Result<()> {
    writeln!(io::stdout(), "{line}")
}

/// A text that has its own line ends, to stdout.
pub(crate) fn say_text(text: &str) -> io::Result<()> {
    let mut out = io::stdout().lock();
    out.write_all(text.as_bytes())?;
    out.flush()
}

/// A remark, to stderr.
pub(crate) fn note(line: &str) {
    plain(&format!("{} {line}", painted("note:", "36")));
}

/// Something to look at, to stderr.
pub(crate) fn warn(line: &str) {
    plain(&format!("{} {line}", painted("warning:", "33;1")));
}

/// What went wrong, to stderr.
pub(crate) fn error(line: &str) {
    plain(&format!("{} {line}", painted("error:", "31;1")));
}

/// A line to stderr. Nobody can be told when that fails.
pub(crate) fn plain(line: &str) {
    let _ = writeln!(io::stderr(), "{line}");
}

/// Coloured where stderr is a terminal that has not asked for none.
fn painted(text: &str, style: &str) -> String {
    let plain = std::env::var_os("NO_COLOR").is_some_and(|value| !value.is_empty());
    match io::stderr().is_terminal() && !plain {
        true => format!("\x1b[{style}m{text}\x1b[0m"),
        false => text.to_owned(),
    }
}
