//! Other lichens on the same mesh: `--also DIR[,COLORMAP]`.

use std::path::{Path, PathBuf};

use super::failure::Failure;
use super::grown::Grown;
use super::skin_args::ColorArgs;

/// Why one cannot be beside the first.
pub(crate) const OTHER_MESH: &str = "it grew on another mesh than the first";

/// Another lichen, and the colours that it was asked for in.
pub(crate) struct Also {
    /// As it is typed.
    text: String,
    from: PathBuf,
    pub(crate) color: ColorArgs,
}

impl Also {
    /// One as it is typed; colours that it does not name are those of the first.
    pub(crate) fn parse(text: &str, first: &ColorArgs) -> Self {
        let (from, colormap) = match text.rsplit_once(',') {
            Some((from, map)) if !Path::new(text).exists() => (from, Some(map.to_owned())),
            _ => (text, first.colormap.clone()),
        };
        Self {
            text: text.to_owned(),
            from: from.into(),
            color: ColorArgs {
                colormap,
                ..first.clone()
            },
        }
    }

    pub(crate) fn read(&self) -> Result<Grown, Failure> {
        match self.from.as_os_str().is_empty() {
            true => Err(Failure::usage(
                "no folder is named: write DIR or DIR,COLORMAP",
            )),
            false => Grown::read(&self.from),
        }
    }

    /// What is wrong with it, and that it is of this one.
    pub(crate) fn failed(&self, failure: Failure) -> Failure {
        failure.at(format!("--also {}", self.text))
    }
}
