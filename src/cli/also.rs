//! Other lichens on the same mesh: `--also DIR[,COLORMAP]`.

use std::path::{Path, PathBuf};

use super::failure::Failure;
use super::grown::Grown;
use super::skin_args::ColorArgs;

/// Another lichen, and the colours that it was asked for in.
pub(crate) struct Also {
    pub(crate) from: PathBuf,
    pub(crate) color: ColorArgs,
}

impl Also {
    /// One as it is typed; colours that it does not name are those of the first.
    pub(crate) fn parse(text: &str, first: &ColorArgs) -> Self {
        let (from, colormap) = match text.split_once(',') {
            Some((from, map)) if !Path::new(text).exists() => (from, Some(map.to_owned())),
            _ => (text, first.colormap.clone()),
        };
        Self {
            from: from.into(),
            color: ColorArgs {
                colormap,
                ..first.clone()
            },
        }
    }

    pub(crate) fn read(&self) -> Result<Grown, Failure> {
        Grown::read(&self.from)
    }

    /// Where something is wrong with it.
    pub(crate) fn flag(&self) -> String {
        format!("--also {}", self.from.display())
    }
}
