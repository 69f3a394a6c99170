//! The arguments of `thallus skin` as they are typed.

use std::path::PathBuf;
use std::str::FromStr;

use clap::Args;
use thallus::run::Length;
use thallus::skin::PALETTE;

use super::axes::AxesArgs;
use super::mesh_args::MeshArgs;
use super::run_args::{RUN, RunArgs};

#[derive(Debug, Args)]
#[command(mut_arg("up", |flag| flag.help(UP)))]
pub(crate) struct SkinArgs {
    /// The folder of a run, or its elements.ply
    #[arg(value_name = "DIR|elements.ply")]
    pub(crate) from: PathBuf,
    #[command(flatten)]
    pub(crate) mesh: MeshArgs,
    #[arg(short, long, value_name = "FILE", help = output_help())]
    pub(crate) output: PathBuf,
    #[command(flatten)]
    pub(crate) shape: ShapeArgs,
    #[command(flatten)]
    pub(crate) color: ColorArgs,
    #[command(flatten)]
    pub(crate) size: SizeArgs,
    #[command(flatten)]
    pub(crate) axes: AxesArgs,
    /// Say as JSON what was made
    #[arg(long, help_heading = RUN)]
    pub(crate) json: bool,
    /// Overwrite files that are there
    #[arg(long, help_heading = RUN)]
    pub(crate) force: bool,
    #[command(flatten)]
    pub(crate) run: RunArgs,
}

const UP: &str = "Up axis of the file; glTF has y and takes no other [default: z for PLY; y for OBJ; the mesh's for USD]";

#[derive(Debug, Args)]
#[command(next_help_heading = "Shape")]
pub(crate) struct ShapeArgs {
    #[command(flatten)]
    pub(crate) relief: ReliefArgs,
    /// Longest edge of a triangle, 0.1r to 10r: half the length gives four times the triangles; 1r gives smoother
    /// margins in close-ups [default: 2r; render takes finer ones from near]
    #[arg(long, value_name = "LEN", value_parser = Length::given, allow_negative_numbers = true)]
    pub(crate) resolution: Option<Length>,
}

/// The shape of the lichen itself, however it is drawn.
#[derive(Debug, Args)]
#[command(next_help_heading = "Shape")]
pub(crate) struct ReliefArgs {
    /// Height of closed lichen over the mesh, 0.05r to 20r: 0.7r for a thin crust, 3r for fleshy lobes
    /// [default: 1.5r]
    #[arg(long, value_name = "LEN", value_parser = Length::given, allow_negative_numbers = true)]
    pub(crate) thickness: Option<Length>,
    /// How much thinner the lichen is at its rim, as a share, 0 to 0.9: 0 for a blunt edge, 0.8 for one
    /// that thins out [default: 0.4]
    #[arg(long, value_name = "SHARE", allow_negative_numbers = true)]
    pub(crate) taper: Option<f64>,
    /// Distance at which an element's influence is halved, 0.8r to 8r: 1r shows every element as a
    /// granule, 3r fuses them [default: 1.8r]
    #[arg(long, value_name = "LEN", value_parser = Length::given, allow_negative_numbers = true)]
    pub(crate) falloff: Option<Length>,
}

#[derive(Clone, Debug, Args)]
#[command(next_help_heading = "Colour")]
pub(crate) struct ColorArgs {
    #[arg(long, value_name = "NAME|STOPS|FILE.toml", help = colormap_help())]
    pub(crate) colormap: Option<String>,
    /// How much darker the oldest part is, 0 to 1 [default: 0]
    #[arg(long, value_name = "SHARE", allow_negative_numbers = true)]
    pub(crate) age_darken: Option<f32>,
    /// A dark margin this wide, as many crustose lichens have, with a colour if it is not black:
    /// 6r or 6r,#303028; or 'none' [default: that of the colour map]
    #[arg(long, value_name = "LEN[,COLOR]", allow_hyphen_values = true)]
    pub(crate) prothallus: Option<String>,
    /// Crack the crust into plates this wide, with a colour if the cracks are not black: 9r or 9r,#303028; or 'none'
    /// [default: those of the colour map]
    #[arg(long, value_name = "LEN[,COLOR]", allow_hyphen_values = true)]
    pub(crate) areoles: Option<String>,
    /// Fruiting discs up to this wide, with a colour: 10r or 10r,#b04a10; or 'none' [default: those
    /// of the colour map]
    #[arg(long, value_name = "LEN[,COLOR]", allow_hyphen_values = true)]
    pub(crate) apothecia: Option<String>,
}

#[derive(Debug, Args)]
#[command(next_help_heading = "Size")]
pub(crate) struct SizeArgs {
    /// Keep fewer triangles: a share above 0 and up to 1, which is all; or how many, from 4
    #[arg(long, value_name = "RATIO|TRIANGLES", allow_hyphen_values = true)]
    pub(crate) decimate: Option<Goal>,
    /// Levels of detail, 1 to 16, each with half the triangles of the one before: FILE_lod0, FILE_lod1 and so on
    #[arg(long, value_name = "LEVELS", value_parser = clap::value_parser!(u8).range(1..=16), allow_negative_numbers = true)]
    pub(crate) lod: Option<u8>,
}

/// How many triangles to keep.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Goal {
    Share(f64),
    Triangles(usize),
}

impl Goal {
    /// Triangles to keep of a mesh of so many.
    pub(crate) fn of(self, triangles: usize) -> usize {
        match self {
            Self::Share(share) => (share * triangles as f64) as usize,
            Self::Triangles(n) => n,
        }
    }
}

/// Triangles of the smallest closed mesh.
pub(super) const FEWEST_TRIANGLES: usize = 4;

impl FromStr for Goal {
    type Err = &'static str;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        match (text.parse::<usize>(), text.parse::<f64>()) {
            (Ok(n), _) if n >= FEWEST_TRIANGLES => Ok(Self::Triangles(n)),
            (_, Ok(share)) if share > 0.0 && share <= 1.0 => Ok(Self::Share(share)),
            _ => Err("write a share above 0 and up to 1 (0.25), or a number of triangles from 4"),
        }
    }
}

fn output_help() -> String {
    let line = |f: &thallus::export::MeshFormat| format!("\n.{}: {}", f.extension, f.purpose);
    let formats: String = thallus::export::MESH_FORMATS.iter().map(line).collect();
    format!("The file to write; its extension says the format:{formats}")
}

fn colormap_help() -> String {
    let maps = PALETTE
        .iter()
        .map(|map| format!("\n{}: {}", map.name, map.look));
    let maps: String = maps.collect();
    format!(
        "Colours by local density, the share of the surface that elements cover: closed lichen has \
         0.5 to 0.75. \
         Stops as 0.1:#c9d0bd,0.65:#8d9a82, a .toml file with stops = [[0.1, \"#c9d0bd\"], ...], or \
         one of [default: {}]:{maps}",
        PALETTE[0].name
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_and_counts_are_told_apart() {
        assert_eq!("0.25".parse(), Ok(Goal::Share(0.25)));
        assert_eq!("1".parse(), Ok(Goal::Share(1.0)));
        assert_eq!("1e-3".parse(), Ok(Goal::Share(1e-3)));
        assert_eq!("20000".parse(), Ok(Goal::Triangles(20_000)));
        for wrong in ["0", "-0.5", "1.5", "2", "nan", "inf", "half", ""] {
            assert!(wrong.parse::<Goal>().is_err(), "{wrong}");
        }
        assert_eq!(Goal::Share(0.25).of(1000), 250);
        assert_eq!(Goal::Triangles(7).of(1000), 7);
    }
}
