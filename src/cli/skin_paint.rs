//! The colours that `thallus skin` was asked for.

use std::fs;
use std::path::Path;

use anyhow::Context;
use serde::Deserialize;
use thallus::run::Length;
use thallus::skin::{Colormap, ColormapError, PALETTE, Paint, Prothallus, parse_color};

use super::failure::Failure;
use super::skin_args::ColorArgs;

/// Lengths in element radii.
pub(super) type InRadii<'a> = &'a dyn Fn(Length) -> f64;

/// A colour map of one's own.
#[derive(Debug, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
struct ColormapFile {
    stops: Vec<(f32, String)>,
    age_darken: Option<f32>,
    prothallus: Option<String>,
}

/// What the flags say, over what a colour map of its own says.
pub(super) fn paint(args: &ColorArgs, in_radii: InRadii) -> Result<Paint, Failure> {
    let mut paint = match args.colormap.as_deref() {
        None => Paint::default(),
        Some(file) if file.to_lowercase().ends_with(".toml") => read(Path::new(file), in_radii)?,
        Some(text) => named(text)?,
    };
    if let Some(share) = args.age_darken {
        paint.age_darken = checked_share(share, "--age-darken")?;
    }
    if let Some(text) = &args.prothallus {
        paint.prothallus = prothallus(text, in_radii).map_err(usage("--prothallus"))?;
    }
    Ok(paint)
}

fn named(text: &str) -> Result<Paint, Failure> {
    if let Some(map) = PALETTE.iter().find(|map| map.name == text) {
        return Ok(Paint::of(map));
    }
    let colormap = text.parse().map_err(usage("--colormap"))?;
    Ok(plain(colormap))
}

fn plain(colormap: Colormap) -> Paint {
    Paint {
        colormap,
        age_darken: 0.0,
        prothallus: None,
    }
}

fn usage<E: std::error::Error + Send + Sync + 'static>(flag: &str) -> impl Fn(E) -> Failure {
    let flag = flag.to_owned();
    move |error| Failure::Usage(anyhow::Error::new(error).context(flag.clone()))
}

fn checked_share(share: f32, flag: &str) -> Result<f32, Failure> {
    match (0.0..=1.0).contains(&share) {
        true => Ok(share),
        false => Err(Failure::usage(format!(
            "{flag} is {share}: it may be 0 to 1"
        ))),
    }
}

fn read(path: &Path, in_radii: InRadii) -> Result<Paint, Failure> {
    let shown = path.display().to_string();
    let text = fs::read_to_string(path)
        .with_context(|| format!("{shown}: reading the colour map failed"))?;
    let file: ColormapFile = toml::from_str(&text).map_err(usage(&shown))?;
    let color = |(at, color): &(f32, String)| Ok((*at, parse_color(color)?));
    let stops: Result<Vec<_>, ColormapError> = file.stops.iter().map(color).collect();
    let stops = stops.map_err(usage(&shown))?;
    let mut paint = plain(Colormap::new(&stops).map_err(usage(&shown))?);
    if let Some(share) = file.age_darken {
        paint.age_darken = checked_share(share, &format!("{shown}: age-darken"))?;
    }
    if let Some(text) = &file.prothallus {
        paint.prothallus = prothallus(text, in_radii).map_err(usage(&shown))?;
    }
    Ok(paint)
}

/// A margin that cannot be drawn.
#[derive(Debug, thiserror::Error)]
enum ProthallusError {
    #[error(transparent)]
    Length(#[from] thallus::run::LengthError),
    #[error(transparent)]
    Color(#[from] thallus::skin::ColormapError),
    #[error("'{0}' is no width of a margin: write a positive length, as 6r, or 'none'")]
    Width(String),
}

const BLACK: [u8; 3] = [0x1c, 0x1c, 0x1a];

/// `6r`, `6r,#303028` or `none`.
fn prothallus(text: &str, in_radii: InRadii) -> Result<Option<Prothallus>, ProthallusError> {
    if text == "none" {
        return Ok(None);
    }
    let (width, color) = match text.split_once(",#") {
        None => (text, BLACK),
        Some((width, digits)) => (width, parse_color(&format!("#{digits}"))?),
    };
    let radii = in_radii(width.parse()?) as f32;
    match radii > 0.0 && radii.is_finite() {
        true => Ok(Some(Prothallus {
            width: radii,
            color,
        })),
        false => Err(ProthallusError::Width(width.to_owned())),
    }
}
