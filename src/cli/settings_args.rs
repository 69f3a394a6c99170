//! Flags that say what a recipe does, of commands that grow.

use clap::Args;
use clap::builder::TypedValueParser;
use thallus::growth::{Boundary, Join, Law, Steps};
use thallus::run::{self, Length, SeedPlace, SeedTextError, Settings, Slope, StopSetting};
use thallus::substrate::UpAxis;

use super::choice::{choice, up};
use super::mask_layer;

#[derive(Debug, Args)]
#[command(next_help_heading = "Look")]
pub(crate) struct LookArgs {
    /// A named look to start from: see 'thallus preset list'
    #[arg(long, value_name = "NAME")]
    preset: Option<String>,
    #[arg(long, value_name = "LEN", help = run::RADIUS.help(), allow_negative_numbers = true)]
    radius: Option<Length>,
    #[arg(long, value_name = "LEN", help = run::CURVATURE_RADIUS.help(), allow_negative_numbers = true)]
    curvature_radius: Option<Length>,
    #[arg(long, value_name = "B", help = run::BIAS.help(), allow_negative_numbers = true)]
    bias: Option<f64>,
    #[arg(long, value_name = "A", help = run::GAIN.help(), allow_negative_numbers = true)]
    gain: Option<f64>,
    #[arg(long, value_name = "P", help = run::MIN_STICK.help(), allow_negative_numbers = true)]
    min_stick: Option<f64>,
    /// Texture: 'pack' rolls each element into a notch between two others, for solid, even tissue;
    /// 'touch' leaves it where it first touched, for loose, stringy growth [default: pack]
    #[arg(long, value_parser = join(), hide_possible_values = true, value_name = "pack|touch")]
    join: Option<Join>,
    /// Another lichen of the same look: everything random comes from this number [range: 0 to
    /// 18446744073709551615] [default: 1]
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    seed: Option<u64>,
}

#[derive(Debug, Args)]
#[command(next_help_heading = "Size (one of them)")]
#[group(multiple = false)]
pub(crate) struct StopArgs {
    #[arg(long, visible_alias = "until-elements", value_name = "N", help = run::ELEMENTS.help(), allow_negative_numbers = true)]
    elements: Option<u64>,
    #[arg(long, visible_alias = "until-reach", value_name = "LEN", help = run::REACH.help(), allow_negative_numbers = true)]
    reach: Option<Length>,
    #[arg(long, visible_alias = "until-cover", value_name = "FRACTION", help = run::COVER.help(), allow_negative_numbers = true)]
    cover: Option<f64>,
}

#[derive(Debug, Args)]
#[command(next_help_heading = "Place")]
pub(crate) struct PlaceArgs {
    /// Where a lichen begins: the surface nearest to a point in mesh units; 'top', above the middle of the largest
    /// piece; 'highest', its highest point; 'center', nearest to the bounding box's centre; 'random', anywhere by area;
    /// 'triangle T', as --at-triangle. Given several times, a colony begins at each [default: top]
    #[arg(
        long,
        value_name = "X,Y,Z|top|highest|center|random",
        conflicts_with = "at_triangle",
        allow_hyphen_values = true
    )]
    at: Vec<SeedPlace>,
    /// The same, by a triangle's number in the file, from 0, and the weights of its second and third corners [default:
    /// its centroid]
    #[arg(long, value_name = "T[,U,V]", value_parser = triangle, allow_hyphen_values = true)]
    at_triangle: Vec<SeedPlace>,
    #[arg(long, value_name = "N", help = run::COLONIES.help(), allow_negative_numbers = true)]
    colonies: Option<u64>,
    /// How steep the surface may be where lichen grows: degrees between its normal and up, from 0 for level ground over
    /// 90 for a wall to 180 for an underside; the steepest, or the least steep and the steepest, as in 30,90 [default:
    /// 0,180]
    #[arg(long, value_name = "[LEAST,]MOST", allow_hyphen_values = true)]
    slope: Option<Slope>,
}

/// Where lichen may grow.
#[derive(Debug, Args)]
#[command(next_help_heading = "Place")]
pub(crate) struct MaskArgs {
    /// Where lichen may grow, painted: a PNG or JPEG image in the layout of the mesh's UVs, 'damp.<UDIM>.png' one for
    /// each of its tiles, 'uv1:IMAGE' one in the layout of its second set, or 'vertex-colors' for the colours in the
    /// mesh file. White is as without a mask, on black and where it is transparent nothing grows, and grey is a factor
    /// on the chance to stick: growth is slower and denser there. 'object:NAME' and 'material:NAME' are those parts of
    /// the mesh ('check' lists them): 'material:Bark,Stone*' any of these, 'material:!Leaves' all but one. 'exposed' is
    /// what is not inside another piece of the mesh or right beneath one, as mortar is behind bricks; 'opaque' what
    /// materials do not leave open, as leaves are cut out of an image. The folder of another run on the same mesh is
    /// one too: this lichen grows beside that one, not over it. May be given several times, for where all of them let
    /// it; 'none' is for a recipe that has one
    #[arg(
        long,
        value_name = "IMAGE|uv1:IMAGE|vertex-colors|object:NAME|material:NAME|exposed|opaque|DIR|none"
    )]
    mask: Vec<String>,
}

impl MaskArgs {
    fn layers(&self) -> Vec<String> {
        let named = |layer: &String| mask_layer::named_portably(layer);
        self.mask.iter().map(named).collect()
    }
}

/// How the mesh stands.
#[derive(Debug, Args)]
#[command(next_help_heading = "Mesh")]
pub(crate) struct StandArgs {
    /// Up axis of the mesh, for a file that does not follow its format's convention: 'top' and 'highest', pictures and
    /// exports go by it [default: y for OBJ and glTF, z for STL and PLY]
    #[arg(long, value_parser = up(), hide_possible_values = true, value_name = "y|z")]
    mesh_up: Option<UpAxis>,
}

#[derive(Debug, Args)]
#[command(next_help_heading = "Walk (changes accuracy and speed rather than look)")]
pub(crate) struct WalkArgs {
    #[arg(long, value_name = "K", help = run::LAUNCH.help(), allow_negative_numbers = true)]
    launch: Option<f64>,
    #[arg(long, value_name = "K", help = run::KILL.help(), allow_negative_numbers = true)]
    kill: Option<f64>,
    /// How walkers move: 'thesis' in steps that are tested where they end; 'brownian' on a continuous path, which gets
    /// less deep into hollows: thinner branches that reach farther [default: thesis]
    #[arg(long, value_parser = law(), hide_possible_values = true, value_name = "thesis|brownian")]
    law: Option<Law>,
    /// 'large' lets walkers leap where nothing can be missed, and far from the lichen over coarser copies of a fine
    /// mesh; 'exact' leaps without copies; 'small' never leaps: all the same look, each slower than the one before, for
    /// checking [default: large]
    #[arg(
        long,
        value_parser = steps(),
        hide_possible_values = true,
        value_name = "large|exact|small"
    )]
    steps: Option<Steps>,
    /// Open edges of the mesh: 'reflect' lets lichen fill up to the edge; 'absorb' starves it there
    /// [default: reflect]
    #[arg(long, value_parser = boundary(), hide_possible_values = true, value_name = "reflect|absorb")]
    boundary: Option<Boundary>,
}

fn triangle(text: &str) -> Result<SeedPlace, SeedTextError> {
    SeedPlace::from_triangle_text(text)
}

fn join() -> impl TypedValueParser<Value = Join> {
    choice([("pack", Join::Pack), ("touch", Join::Touch)])
}

fn law() -> impl TypedValueParser<Value = Law> {
    choice([("thesis", Law::Thesis), ("brownian", Law::Brownian)])
}

fn steps() -> impl TypedValueParser<Value = Steps> {
    choice([
        ("large", Steps::Large),
        ("exact", Steps::Exact),
        ("small", Steps::Small),
    ])
}

fn boundary() -> impl TypedValueParser<Value = Boundary> {
    choice([("reflect", Boundary::Reflect), ("absorb", Boundary::Absorb)])
}

/// What the flags of a recipe say.
pub(super) fn settings(
    look: &LookArgs,
    stop: &StopArgs,
    (place, mask, stand): (&PlaceArgs, &MaskArgs, &StandArgs),
    walk: &WalkArgs,
) -> Settings {
    Settings {
        mesh_up: stand.mesh_up,
        mask: (!mask.mask.is_empty()).then(|| mask.layers()),
        slope: place.slope,
        preset: look.preset.clone(),
        radius: look.radius,
        curvature_radius: look.curvature_radius,
        bias: look.bias,
        gain: look.gain,
        min_stick: look.min_stick,
        seed: look.seed,
        at: place.places(),
        colonies: place.colonies,
        launch: walk.launch,
        kill: walk.kill,
        join: look.join,
        law: walk.law,
        steps: walk.steps,
        boundary: walk.boundary,
        stop: stop.setting(),
        ..Settings::default()
    }
}

impl PlaceArgs {
    fn places(&self) -> Option<Vec<SeedPlace>> {
        let places = [&self.at[..], &self.at_triangle[..]].concat();
        Some(places).filter(|places| !places.is_empty())
    }
}

impl StopArgs {
    fn setting(&self) -> Option<StopSetting> {
        let elements = self.elements.map(StopSetting::Elements);
        let reach = self.reach.map(StopSetting::Reach);
        elements.or(reach).or(self.cover.map(StopSetting::Cover))
    }
}
