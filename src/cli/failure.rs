//! How a command ends when it does not end well.

use std::io;
use std::process::ExitCode;

use thallus::run::{RecipeFileError, SettingsError};

use super::{INTERRUPTED, terminal};

/// What went wrong, by exit code.
#[derive(Debug)]
pub(crate) enum Failure {
    /// 1: the work could not be done.
    Failed(anyhow::Error),
    /// 2: it was asked for wrongly.
    Usage(anyhow::Error),
    /// 130: Ctrl-C, and what there was to say has been said.
    Interrupted,
    /// 0: the reader of stdout closed it, having read enough.
    PipeClosed,
}

impl Failure {
    /// Something asked for wrongly.
    pub(crate) fn usage(message: impl Into<String>) -> Self {
        Self::Usage(anyhow::Error::msg(message.into()))
    }

    /// Tells the user and gives the exit code.
    pub(crate) fn report(self) -> ExitCode {
        match self {
            Self::PipeClosed => ExitCode::SUCCESS,
            Self::Interrupted => ExitCode::from(INTERRUPTED),
            Self::Failed(error) => {
                terminal::error(&format!("{error:#}"));
                ExitCode::FAILURE
            }
            Self::Usage(error) => {
                terminal::error(&format!("{error:#}\n\nFor more, try 'thallus --help'."));
                ExitCode::from(2)
            }
        }
    }
}

impl From<io::Error> for Failure {
    /// From writing to stdout.
    fn from(error: io::Error) -> Self {
        match error.kind() {
            io::ErrorKind::BrokenPipe => Self::PipeClosed,
            _ => Self::Failed(anyhow::Error::new(error).context("writing to stdout")),
        }
    }
}

impl From<anyhow::Error> for Failure {
    fn from(error: anyhow::Error) -> Self {
        Self::Failed(error)
    }
}

impl From<thallus::export::OutputError> for Failure {
    fn from(error: thallus::export::OutputError) -> Self {
        Self::Failed(error.into())
    }
}

impl From<SettingsError> for Failure {
    fn from(error: SettingsError) -> Self {
        Self::Usage(error.into())
    }
}

impl From<RecipeFileError> for Failure {
    fn from(error: RecipeFileError) -> Self {
        match error {
            RecipeFileError::Read { .. } => Self::Failed(error.into()),
            RecipeFileError::Text { .. } => Self::Usage(error.into()),
        }
    }
}
