//! The one place that writes to stdout and stderr.

use std::borrow::Cow;
use std::io::{self, IsTerminal, Write};
use std::time::Duration;

use indicatif::ProgressBar;
use serde::Serialize;

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

    /// Turns on a terminal while something takes its time.
    pub(crate) fn spinner(self, doing: &str) -> ProgressBar {
        if self.quiet {
            return ProgressBar::hidden();
        }
        let spinner = ProgressBar::new_spinner();
        spinner.set_message(doing.to_owned());
        spinner.enable_steady_tick(Duration::from_millis(200));
        spinner
    }
}

/// Why stdout takes nothing.
#[derive(Debug)]
pub(crate) struct Unsaid(pub(crate) io::Error);

/// A line of the result, to stdout.
pub(crate) fn say(line: &str) -> Result<(), Unsaid> {
    writeln!(io::stdout(), "{}", for_stdout(line)).map_err(Unsaid)
}

/// An answer for programs, to stdout.
pub(crate) fn say_json(answer: &impl Serialize) -> Result<(), Unsaid> {
    say(&serde_json::to_string_pretty(answer).map_err(|e| Unsaid(e.into()))?)
}

/// A text that has its own line ends, to stdout.
pub(crate) fn say_text(text: &str) -> Result<(), Unsaid> {
    let mut out = io::stdout().lock();
    let written = out.write_all(for_stdout(text).as_bytes());
    written.and_then(|()| out.flush()).map_err(Unsaid)
}

/// A remark, to stderr.
pub(crate) fn note(line: &str) {
    tell(painted("note:", "36"), line);
}

/// Something to look at, to stderr.
pub(crate) fn warn(line: &str) {
    tell(painted("warning:", "33;1"), line);
}

/// What went wrong, to stderr.
pub(crate) fn error(line: &str) {
    tell(painted("error:", "31;1"), line);
}

fn tell(kind: String, line: &str) {
    plain(&format!("{kind} {}", harmless(line)));
}

/// As it is for programs, and harmless for terminals.
fn for_stdout(text: &str) -> Cow<'_, str> {
    match io::stdout().is_terminal() {
        true => Cow::Owned(harmless(text)),
        false => Cow::Borrowed(text),
    }
}

/// Names of files may hold what moves a terminal's cursor or changes its colours.
fn harmless(line: &str) -> String {
    let shown = |c: char| match c.is_control() && c != '\n' && c != '\t' {
        true => c.escape_default().to_string(),
        false => c.to_string(),
    };
    line.chars().map(shown).collect()
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

#[cfg(test)]
mod tests {
    use super::harmless;

    #[test]
    fn names_cannot_command_a_terminal() {
        assert_eq!(
            harmless("a\u{1b}[2J\r.obj: é\n  b"),
            "a\\u{1b}[2J\\r.obj: é\n  b"
        );
    }
}
