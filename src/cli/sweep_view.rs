//! How the pictures of a sweep are taken: the flags, and what the folder remembers of them.

use std::io::{ErrorKind, Write};
use std::path::Path;

use anyhow::Context;
use serde::{Deserialize, Serialize};
use thallus::export::write_file_atomically;
use thallus::input;
use thallus::picture::Ground;

use super::dress::{ground, ground_text};
use super::failure::Failure;
use super::render_args::Size;
use super::render_camera::View;
use super::sweep_args::{MOST_SAMPLES, PictureArgs};

/// The record in a sweep's folder.
const FILE: &str = "pictures.toml";

const HEAD: &str = "# How the pictures of this sweep are taken: --camera, --size, --samples and --ground say otherwise.\n";

/// How the pictures of the cells are taken.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct PictureStyle {
    pub(super) camera: View,
    pub(super) size: Size,
    /// Rays through a pixel, at most.
    pub(super) samples: u32,
    pub(super) ground: Ground,
}

/// As it is written down: the flags' words.
#[derive(Debug, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
struct Said {
    camera: String,
    size: String,
    samples: u32,
    #[serde(default = "stone")]
    ground: String,
}

fn stone() -> String {
    ground_text(Ground::Stone)
}

impl PictureStyle {
    /// What the flags say, over what the first of these folders remembers that does, over what is usual.
    pub(super) fn new(args: &PictureArgs, folders: &[&Path]) -> Result<Self, Failure> {
        let remembered = folders.iter().map(|folder| read(folder));
        let there = remembered.collect::<Result<Vec<_>, _>>()?;
        let below = there.into_iter().flatten().next();
        let below = below.unwrap_or_else(Self::usual);
        let camera = args.camera.clone().map(View::in_full).transpose()?;
        Ok(Self {
            camera: camera.unwrap_or(below.camera),
            size: args.size.unwrap_or(below.size),
            samples: args.samples.unwrap_or(below.samples),
            ground: args.ground.unwrap_or(below.ground),
        })
    }

    pub(super) fn usual() -> Self {
        Self {
            camera: View::Auto,
            size: Size {
                width: 800,
                height: 800,
            },
            samples: 4,
            ground: Ground::Stone,
        }
    }

    /// Remembers it in a folder.
    pub(super) fn keep(&self, folder: &Path) -> Result<(), Failure> {
        if read(folder).is_ok_and(|there| there.as_ref() == Some(self)) {
            return Ok(());
        }
        let said = Said {
            camera: self.camera.to_string(),
            size: self.size.to_string(),
            samples: self.samples,
            ground: ground_text(self.ground),
        };
        let text = toml::to_string(&said).context("how pictures are taken, as TOML")?;
        let text = format!("{HEAD}{text}");
        let fill = |out: &mut dyn Write| out.write_all(text.as_bytes());
        Ok(write_file_atomically(&folder.join(FILE), true, fill)?)
    }
}

/// What a folder remembers, if it does.
fn read(folder: &Path) -> Result<Option<PictureStyle>, Failure> {
    let file = folder.join(FILE);
    let place = || file.display().to_string();
    const CURE: &str = "remove it, and pictures are taken as the command says";
    let text = match input::text(&file) {
        Err(error) if error.kind() == ErrorKind::NotFound => return Ok(None),
        text => text.map_err(|problem| anyhow::anyhow!("{}: {problem}; {CURE}", place()))?,
    };
    let said: Said = toml::from_str(&text)
        .map_err(|problem| anyhow::anyhow!("{}: {problem}\n{CURE}", place()))?;
    let wrong = |what: String| anyhow::anyhow!("{}: {what}; {CURE}", place());
    if !(1..=MOST_SAMPLES).contains(&said.samples) {
        return Err(wrong(format!("samples may be 1 to {MOST_SAMPLES}")).into());
    }
    Ok(Some(PictureStyle {
        camera: said.camera.parse().map_err(wrong)?,
        size: said.size.parse().map_err(wrong)?,
        samples: said.samples,
        ground: ground(&said.ground).map_err(wrong)?,
    }))
}
