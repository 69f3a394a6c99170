//! The arguments of `thallus bake` as they are typed.

use std::path::PathBuf;

use clap::Args;
use thallus::bake::{Green, MAPS, Map, MapFile, Settings};
use thallus::substrate::Selection;

use super::axes::UnitArgs;
use super::dress::Dress;
use super::mesh_args::MeshArgs;
use super::run_args::{RUN, RunArgs};
use super::skin_args::{ColorArgs, ReliefArgs};

#[derive(Debug, Args)]
#[command(mut_arg("unit", |flag| flag.help(UNIT)))]
pub(crate) struct BakeArgs {
    /// The folder of a run, or its elements.ply
    #[arg(value_name = "DIR|elements.ply")]
    pub(crate) from: PathBuf,
    #[command(flatten)]
    pub(crate) mesh: MeshArgs,
    #[arg(short, long, value_name = "OUT", help = output_help())]
    pub(crate) output: PathBuf,
    /// Another lichen on the same mesh, in the same maps, with its own colour map: out/b or out/b,xanthoria. It lies
    /// over those given before it. May be repeated
    #[arg(long, value_name = "DIR[,COLORMAP]")]
    pub(crate) also: Vec<String>,
    /// The part of the mesh to make maps of and to put into lichened.glb: object:NAME or material:NAME, as in grow
    /// --mask. May be repeated: only what is in every one of them is baked
    #[arg(long, value_name = "object:NAME|material:NAME")]
    pub(crate) only: Vec<Selection>,
    /// The set of UVs that maps are laid out in, of glTF files that have two: 1 for TEXCOORD_1
    #[arg(long, value_name = "0|1", default_value_t = 0, value_parser = clap::value_parser!(u8).range(0..=1))]
    pub(crate) uv_set: u8,
    /// Lay maps out in charts of their own, for a mesh without UVs, or whose UVs overlap, repeat an image or fill
    /// little of it: lichened.glb has the new UVs, and the mesh's textures are drawn anew in them
    #[arg(long)]
    pub(crate) unwrap: bool,
    /// Maps for each material, each object or each UDIM tile of the mesh that lichen is on, and all of the mesh in one
    /// lichened.glb. Several
    /// may be given, as --each object --each material, for each material of each object
    #[arg(
        long,
        value_enum,
        value_name = "material|object|tile",
        hide_possible_values = true
    )]
    pub(crate) each: Vec<Each>,
    #[command(flatten)]
    pub(crate) maps: MapArgs,
    #[command(flatten)]
    pub(crate) relief: ReliefArgs,
    #[command(flatten)]
    pub(crate) color: ColorArgs,
    #[command(flatten)]
    pub(crate) units: UnitArgs,
    /// Say as JSON what was made
    #[arg(long, help_heading = RUN)]
    pub(crate) json: bool,
    /// Overwrite files that are there
    #[arg(long, help_heading = RUN)]
    pub(crate) force: bool,
    #[command(flatten)]
    pub(crate) run: RunArgs,
}

const UNIT: &str = "What a unit of the mesh is: lichened.glb, maps.json and heights in EXR are in metres [default: m]";

#[derive(Debug, Args)]
#[command(next_help_heading = "Maps")]
pub(crate) struct MapArgs {
    /// Texels in a row, and number of rows, 16 to 8192
    #[arg(
        long,
        value_name = "TEXELS",
        default_value_t = Settings::default().size,
        allow_negative_numbers = true
    )]
    pub(crate) size: u32,
    #[arg(
        long,
        value_enum,
        value_name = "png|exr",
        default_value = "png",
        hide_possible_values = true,
        hide_default_value = true,
        help = "File format of the maps [default: png]\npng: 8 bits, and 16 for height, normal and birth\nexr: 16-bit floats, and 32 for height and birth; colours in linear light, height in metres"
    )]
    pub(crate) format: FileFormat,
    /// Green of the normal map: opengl points up (glTF, Blender, Unity, Godot), directx down (Unreal)
    #[arg(
        long,
        value_enum,
        value_name = "opengl|directx",
        default_value = "opengl",
        hide_possible_values = true
    )]
    pub(crate) normal: NormalFormat,
    /// Texels to fill all around the parts of the layout, so that filtering shows no seam, 2 to 64
    #[arg(
        long,
        value_name = "TEXELS",
        default_value_t = Settings::default().gutter,
        allow_negative_numbers = true
    )]
    pub(crate) gutter: u32,
    /// Samples along each side of a texel, 1 to 8: 4 gives smoother margins in four times the time
    #[arg(
        long,
        value_name = "N",
        default_value_t = Settings::default().samples,
        allow_negative_numbers = true
    )]
    pub(crate) samples: u32,
    /// Colour of the mesh under the lichen: mesh, as its file says, or stone where that says nothing; a colour such as
    /// #8a8478; stone or bark as pictures draw them; or a PNG or JPEG image in the layout of its UVs [default: mesh]
    #[arg(long, value_parser = Dress::parse, value_name = "mesh|stone|bark|#RRGGBB|IMAGE")]
    pub(crate) base: Option<Dress>,
}

/// What has maps of its own.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub(crate) enum Each {
    Material,
    Object,
    Tile,
}

/// A file format of maps.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub(crate) enum FileFormat {
    Png,
    Exr,
}

impl From<FileFormat> for MapFile {
    fn from(format: FileFormat) -> Self {
        match format {
            FileFormat::Png => Self::Png,
            FileFormat::Exr => Self::Exr,
        }
    }
}

/// Which way green points.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub(crate) enum NormalFormat {
    Opengl,
    Directx,
}

impl From<NormalFormat> for Green {
    fn from(format: NormalFormat) -> Self {
        match format {
            NormalFormat::Opengl => Self::Up,
            NormalFormat::Directx => Self::Down,
        }
    }
}

fn output_help() -> String {
    let line = |map: &Map| format!("\n{}: {}", map.name, map.what);
    let maps: String = MAPS.iter().map(line).collect();
    format!(
        "The folder to write to: lichened.glb, the mesh with the maps as its material; maps.json, what \
         their numbers mean; and the maps:{maps}"
    )
}
