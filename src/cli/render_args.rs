//! The arguments of `thallus render` as they are typed.

use std::fmt;
use std::path::PathBuf;
use std::str::FromStr;

use clap::Args;
use clap::builder::TypedValueParser;
use thallus::picture::{Background, Camera, World, unwritable};
use thallus::skin::parse_color;

use super::choice::choice;
use super::dress::Dress;
use super::given::Given;
use super::mesh_args::MeshArgs;
use super::render_by::Quantity;
use super::render_camera::View;
use super::run_args::{RUN, RunArgs};
use super::skin_args::{ColorArgs, ShapeArgs};

#[derive(Debug, Args)]
pub(crate) struct RenderArgs {
    /// The folder of a run, or its elements.ply
    #[arg(value_name = "DIR|elements.ply")]
    pub(crate) from: PathBuf,
    #[command(flatten)]
    pub(crate) mesh: MeshArgs,
    /// The picture to write, a PNG
    #[arg(short, long, value_name = "FILE.png")]
    pub(crate) output: PathBuf,
    /// The lichen as a closed skin, or each element as a granule, which takes none of the flags for the shape of skins
    #[arg(long, value_parser = what(), hide_possible_values = true, value_name = "skin|points", default_value = "skin")]
    pub(crate) what: What,
    /// Another lichen on the same mesh, with its own colour map: out/b or out/b,xanthoria. It lies over those given
    /// before it. May be repeated; not with --by
    #[arg(long, value_name = "DIR[,COLORMAP]")]
    pub(crate) also: Vec<String>,
    #[command(flatten)]
    pub(crate) view: ViewArgs,
    #[command(flatten)]
    pub(crate) by: ByArgs,
    #[command(flatten)]
    pub(crate) color: ColorArgs,
    #[command(flatten)]
    pub(crate) shape: Given<ShapeArgs>,
    /// Say as JSON what was made, with the camera to use again
    #[arg(long, help_heading = RUN)]
    pub(crate) json: bool,
    /// Overwrite the picture if it is there
    #[arg(long, help_heading = RUN)]
    pub(crate) force: bool,
    #[command(flatten)]
    pub(crate) run: RunArgs,
}

#[derive(Debug, Args)]
#[command(next_help_heading = "View")]
pub(crate) struct ViewArgs {
    #[command(flatten)]
    pub(crate) shot: ShotArgs,
    /// Pixels across and down, up to 16384 each
    #[arg(
        long,
        value_name = "WIDTHxHEIGHT",
        default_value = "1600x1200",
        allow_hyphen_values = true
    )]
    pub(crate) size: Size,
    /// Draw a scale bar, and with --by what the colours mean
    #[arg(long)]
    pub(crate) legend: bool,
    /// What a unit of the mesh is called in the legend, such as mm
    #[arg(long, value_name = "NAME", requires = "legend", value_parser = unit)]
    pub(crate) unit: Option<String>,
}

/// How any picture of a lichen on its mesh is taken.
#[derive(Debug, Args)]
pub(crate) struct ShotArgs {
    /// Where to look from: 'auto' finds the side that shows most of the lichen; front, back, left, right, top or
    /// bottom; degrees round the mesh from its front and above the horizon, as 30,45; or {"eye": [x,y,z], "target":
    /// [x,y,z], "up": [x,y,z], "opening": degrees} in mesh units, opening 0.1 to 170, given here or in a file; what
    /// 'thallus render --json' prints will do too
    #[arg(
        long,
        value_name = "auto|SIDE|AZIMUTH,ELEVATION|JSON",
        default_value = "auto",
        allow_hyphen_values = true
    )]
    pub(crate) camera: View,
    /// Go nearer to lichen that is seen, 0.01 to 1000: 2 shows half as much of it across
    #[arg(long, value_name = "FACTOR", value_parser = zoom, default_value_t = 1.0, allow_negative_numbers = true)]
    pub(crate) zoom: f32,
    /// Rays through a pixel, at most, 1 to 65536: more remove grain but take longer
    #[arg(long, value_name = "N", default_value_t = 8, value_parser = clap::value_parser!(u32).range(1..=65_536), allow_negative_numbers = true)]
    pub(crate) samples: u32,
    /// What is behind everything: a pale sheet with a shadow on it; nothing, in a PNG; or one colour
    #[arg(long, value_parser = background, value_name = "studio|transparent|#RRGGBB", default_value = "studio")]
    pub(crate) background: Background,
    /// What the mesh is drawn as: the colours and textures of its own file; granite; bark, with furrows along its
    /// longest side; one colour; or an image in the layout of its UVs [default: mesh where that has several colours, or
    /// stone]
    #[arg(long, value_parser = Dress::parse, value_name = "mesh|stone|bark|#RRGGBB|IMAGE")]
    pub(crate) ground: Option<Dress>,
}

impl ShotArgs {
    /// The camera brought nearer: to what it sees of lichens, if anything; one that was given to their middle.
    pub(super) fn zoomed(
        &self,
        camera: &Camera,
        world: &World,
        (middle, aspect): ([f32; 3], f32),
    ) -> Camera {
        let is_free = matches!(self.camera, View::Auto | View::Side { .. }) && self.zoom > 1.0;
        match is_free {
            true => camera.nearer(world, aspect, self.zoom).unwrap_or(*camera),
            false => camera.zoomed(camera.depth(middle), self.zoom),
        }
    }
}

#[derive(Debug, Args)]
#[command(next_help_heading = "Colour by a quantity")]
pub(crate) struct ByArgs {
    #[arg(long, value_parser = Quantity::parser(), hide_possible_values = true, value_name = "QUANTITY", conflicts_with_all = ["also", "age_darken", "prothallus", "areoles", "apothecia"], help = Quantity::help())]
    pub(crate) by: Option<Quantity>,
    /// The numbers at the ends of the colours, as 0,0.5; not with --by colony [default: the least and the greatest]
    #[arg(long, value_name = "LOW,HIGH", value_parser = range, requires = "by", allow_hyphen_values = true)]
    pub(crate) range: Option<[f64; 2]>,
}

/// What the lichen is drawn as.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum What {
    Skin,
    Points,
}

pub(super) fn what() -> impl TypedValueParser<Value = What> {
    choice([("skin", What::Skin), ("points", What::Points)])
}

/// Width and height in pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Size {
    pub(crate) width: u32,
    pub(crate) height: u32,
}

impl Size {
    pub(crate) fn aspect(self) -> f32 {
        self.width as f32 / self.height as f32
    }
}

/// The longest side of a picture.
const LONGEST: u32 = 16_384;

impl fmt::Display for Size {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}x{}", self.width, self.height)
    }
}

impl FromStr for Size {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let side = |side: &str| side.parse().ok().filter(|n| (1..=LONGEST).contains(n));
        let sides = text.split_once('x').map(|(w, h)| (side(w), side(h)));
        match sides {
            Some((Some(width), Some(height))) => Ok(Self { width, height }),
            _ => Err(format!(
                "write width x height, each 1 to {LONGEST}, as 1600x1200"
            )),
        }
    }
}

fn zoom(text: &str) -> Result<f32, &'static str> {
    match text.parse() {
        Ok(factor) if (0.01..=1000.0).contains(&factor) => Ok(factor),
        _ => Err("give a number from 0.01 to 1000"),
    }
}

/// A name that the legend can show as it is: one letter less may be a thousand times as much.
fn unit(text: &str) -> Result<String, String> {
    match unwritable(text) {
        None => Ok(text.to_owned()),
        Some(letter) => Err(format!(
            "the letters of pictures have no {letter:?}: write it with those of English, µ, ° and ×, as mm^2"
        )),
    }
}

fn background(text: &str) -> Result<Background, String> {
    match text {
        "studio" => Ok(Background::Studio),
        "transparent" => Ok(Background::Transparent),
        color => parse_color(color)
            .map(Background::Color)
            .map_err(|e| format!("{e}; or write studio or transparent")),
    }
}

fn range(text: &str) -> Result<[f64; 2], &'static str> {
    let number = |text: &str| text.trim().parse::<f64>().ok().filter(|x| x.is_finite());
    let ends = text
        .split_once(',')
        .map(|(low, high)| (number(low), number(high)));
    match ends {
        Some((Some(low), Some(high))) if low < high => Ok([low, high]),
        _ => Err("write two numbers, the lower first, as 0,0.5"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_are_two_numbers_of_pixels() {
        let size = |width, height| Ok(Size { width, height });
        assert_eq!("1600x1200".parse(), size(1600, 1200));
        assert_eq!("1x16384".parse(), size(1, 16_384));
        for wrong in [
            "", "x", "0x5", "5x0", "16385x5", "5", "5x5x5", "-5x5", "5X5", "1e3x5",
        ] {
            assert!(wrong.parse::<Size>().is_err(), "{wrong}");
        }
    }

    #[test]
    fn units_are_in_letters_that_pictures_have() {
        assert_eq!(unit("μm").as_deref(), Ok("μm"));
        assert!(unit("mm²").is_err_and(|e| e.contains("'²'") && e.contains("mm^2")));
    }

    #[test]
    fn ranges_ascend() {
        assert_eq!(range("-1, 0.5"), Ok([-1.0, 0.5]));
        for wrong in ["", "1", "1,1", "2,1", "a,b", "0,inf", "nan,1", "1,2,3"] {
            assert!(range(wrong).is_err(), "{wrong}");
        }
    }
}
