//! The colours that `thallus skin` was asked for.

use std::path::Path;

use anyhow::Context;
use serde::Deserialize;
use thallus::input;
use thallus::run::{Length, preset};
use thallus::skin::{
    Apothecia, Areoles, Colormap, ColormapError, PALETTE, Paint, Prothallus, SkinError, parse_color,
};

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
    areoles: Option<String>,
    apothecia: Option<ApotheciaTable>,
}

/// Fruiting bodies of one's own.
#[derive(Debug, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
struct ApotheciaTable {
    width: String,
    color: Option<String>,
    spacing: Option<String>,
    from: Option<String>,
    margin: Option<f32>,
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
    if let Some(text) = &args.areoles {
        paint.areoles = areoles(text, in_radii).map_err(usage("--areoles"))?;
    }
    if let Some(text) = &args.apothecia {
        let own = paint.apothecia;
        paint.apothecia = apothecia(text, own, in_radii).map_err(usage("--apothecia"))?;
    }
    Ok(paint)
}

fn named(text: &str) -> Result<Paint, Failure> {
    if let Some(map) = PALETTE.iter().find(|map| map.name == text) {
        return Ok(Paint::of(map));
    }
    let colormap: Result<Colormap, _> = text.parse();
    match colormap {
        Ok(colormap) => Ok(colormap.into()),
        Err(error) if preset::find(text).is_ok() => Err(Failure::usage(format!(
            "--colormap: {error}; {text} is a shape to grow in: thallus grow MESH --preset {text}"
        ))),
        Err(error) => Err(usage("--colormap")(error)),
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
    let text =
        input::text(path).with_context(|| format!("{shown}: reading the colour map failed"))?;
    let file: ColormapFile = toml::from_str(&text).map_err(usage(&shown))?;
    let color = |(at, color): &(f32, String)| Ok((*at, parse_color(color)?));
    let stops: Result<Vec<_>, ColormapError> = file.stops.iter().map(color).collect();
    let stops = stops.map_err(usage(&shown))?;
    let mut paint: Paint = Colormap::new(&stops).map_err(usage(&shown))?.into();
    if let Some(share) = file.age_darken {
        paint.age_darken = checked_share(share, &format!("{shown}: age-darken"))?;
    }
    if let Some(text) = &file.prothallus {
        paint.prothallus = prothallus(text, in_radii).map_err(usage(&shown))?;
    }
    if let Some(text) = &file.areoles {
        paint.areoles = areoles(text, in_radii).map_err(usage(&shown))?;
    }
    if let Some(table) = &file.apothecia {
        let apothecia = table.apothecia(in_radii).map_err(usage(&shown))?;
        paint.apothecia = Some(apothecia);
    }
    Ok(paint)
}

/// A structure that cannot be drawn.
#[derive(Debug, thiserror::Error)]
enum StructureError {
    #[error(transparent)]
    Length(#[from] thallus::run::LengthError),
    #[error(transparent)]
    Color(#[from] thallus::skin::ColormapError),
    #[error("'{0}' is not a margin width: write a positive length, as 6r, or 'none'")]
    Width(String),
    #[error(transparent)]
    Range(#[from] SkinError),
}

const BLACK: [u8; 3] = [0x1c, 0x1c, 0x1a];

/// `6r`, `6r,#303028` or `none`.
fn prothallus(text: &str, in_radii: InRadii) -> Result<Option<Prothallus>, StructureError> {
    if text == "none" {
        return Ok(None);
    }
    let (width, color) = width_and_color(text)?;
    let color = color.unwrap_or(BLACK);
    let radii = in_radii(Length::given(width)?) as f32;
    if radii <= 0.0 {
        return Err(StructureError::Width(width.to_owned()));
    }
    let prothallus = Prothallus {
        width: radii,
        color,
    };
    prothallus.check()?;
    Ok(Some(prothallus))
}

/// `9r,#303028` or `9r`.
fn width_and_color(text: &str) -> Result<(&str, Option<[u8; 3]>), ColormapError> {
    match text.split_once(",#") {
        None => Ok((text, None)),
        Some((width, digits)) => Ok((width, Some(parse_color(&format!("#{digits}"))?))),
    }
}

/// `9r`, `9r,#303028` or `none`.
fn areoles(text: &str, in_radii: InRadii) -> Result<Option<Areoles>, StructureError> {
    if text == "none" {
        return Ok(None);
    }
    let (width, color) = width_and_color(text)?;
    let areoles = Areoles {
        width: in_radii(Length::given(width)?) as f32,
        color: color.unwrap_or(BLACK),
    };
    areoles.check()?;
    Ok(Some(areoles))
}

/// `10r`, `10r,#b04a10` or `none`; all else is that of the colour map's own.
fn apothecia(
    text: &str,
    own: Option<Apothecia>,
    in_radii: InRadii,
) -> Result<Option<Apothecia>, StructureError> {
    if text == "none" {
        return Ok(None);
    }
    let (width, color) = width_and_color(text)?;
    let width = in_radii(Length::given(width)?) as f32;
    let scaled = own.map(|own| Apothecia {
        spacing: own.spacing * width / own.width,
        width,
        ..own
    });
    let mut apothecia = scaled.unwrap_or(usual_apothecia(width));
    apothecia.color = color.unwrap_or(apothecia.color);
    apothecia.check()?;
    Ok(Some(apothecia))
}

/// Brown discs with a margin, side by side.
fn usual_apothecia(width: f32) -> Apothecia {
    Apothecia {
        width,
        spacing: 1.2 * width,
        from: 3.0 * width,
        color: [0x6b, 0x4a, 0x34],
        margin: 0.25,
    }
}

impl ApotheciaTable {
    fn apothecia(&self, in_radii: InRadii) -> Result<Apothecia, StructureError> {
        let radii = |text: &str| Ok::<_, StructureError>(in_radii(Length::given(text)?) as f32);
        let mut apothecia = usual_apothecia(radii(&self.width)?);
        if let Some(color) = &self.color {
            apothecia.color = parse_color(color)?;
        }
        if let Some(text) = &self.spacing {
            apothecia.spacing = radii(text)?;
        }
        if let Some(text) = &self.from {
            apothecia.from = radii(text)?;
        }
        if let Some(margin) = self.margin {
            apothecia.margin = margin;
        }
        apothecia.check()?;
        Ok(apothecia)
    }
}
