//! The arguments as they are typed. `--help` is made from these comments and the parameter table.

use std::path::PathBuf;

use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use clap::{Args, Parser, Subcommand};
use thallus::export::{SCENE_FORMATS, SceneFormat, What};
use thallus::growth::{Boundary, Join, Law, Steps};
use thallus::run::{self, Length, SeedPlace, SeedTextError, Settings, Slope, StopSetting};
use thallus::substrate::UpAxis;

use super::analyze_args::AnalyzeArgs;
use super::animate_args::AnimateArgs;
use super::axes::AxesArgs;
use super::bake_args::BakeArgs;
use super::mesh_args::MeshArgs;
use super::render_args::RenderArgs;
use super::run_args::{RUN, RunArgs, threads};
use super::skin_args::SkinArgs;
use super::sweep_args::SweepArgs;

/// Grows lichen on triangle meshes.
///
/// One command is enough: `thallus grow rock.obj -o out/rock`.
#[derive(Debug, Parser)]
#[command(name = "thallus", version = env!("THALLUS_VERSION"), max_term_width = 100)]
pub(crate) struct Cli {
    #[command(subcommand)]
    pub(crate) command: Command,
}

#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// Grow a lichen on a mesh
    ///
    /// Lengths (LEN) are a number in mesh units (0.02), in element radii (10r), or in percent of
    /// the bounding box's diagonal (0.5%).
    Grow(Box<GrowArgs>),
    /// Say what a mesh file holds, what was repaired, and whether lichen can grow on it
    ///
    /// Exits with 1 when it cannot; loose triangles, and room for only a few elements, are warnings.
    Check(CheckArgs),
    /// Write a run's lichen for another program
    ///
    /// Points, instances or the tree of branches, with everything that can be measured on them.
    Export(ExportArgs),
    /// Turn the elements of a run into a triangle mesh with colours
    ///
    /// Lengths (LEN) are a number in mesh units (0.02), in element radii (2r), or in percent of the
    /// bounding box's diagonal (0.5%).
    Skin(Box<SkinArgs>),
    /// Bake the lichen into textures for a mesh with UVs
    ///
    /// Maps in the mesh's own layout, and the mesh as one GLB file that wears them. Lengths (LEN)
    /// are as for `thallus skin`.
    Bake(Box<BakeArgs>),
    /// Show the growth of a run's lichen, frame by frame
    ///
    /// Meshes, points, branches or pictures: numbered files in a folder, or all frames in one USD,
    /// glTF, GIF or video file. The next elements fade in before they are born, so that the lichen
    /// swells instead of jumping.
    Animate(Box<AnimateArgs>),
    /// Take a picture of a lichen on its mesh
    ///
    /// A PNG, by ray tracing on the processor. Lengths (LEN) are a number in mesh units (0.02), in
    /// element radii (2r), or in percent of the bounding box's diagonal (0.5%).
    Render(Box<RenderArgs>),
    /// Measure a lichen: fractal dimensions, width of the branches, tips, front, growth
    ///
    /// Every fit says its range and its error. Lengths are in mesh units, through space and, with the
    /// mesh, along the surface.
    Analyze(AnalyzeArgs),
    /// Grow a grid of lichens and compare them on one page
    ///
    /// Any settings may vary. Every cell is grown to the same size, measured and pictured from the
    /// same side. Lengths (LEN) are as for `thallus grow`.
    Sweep(Box<SweepArgs>),
    /// Named looks to start from
    #[command(subcommand)]
    Preset(PresetCommand),
}

#[derive(Debug, Subcommand)]
pub(crate) enum PresetCommand {
    /// The presets and what they look like
    List,
    /// A preset as a recipe file to start from
    Show {
        /// Its name
        name: String,
    },
}

#[derive(Debug, Args)]
pub(crate) struct CheckArgs {
    /// The mesh: OBJ, glTF (.gltf, .glb), STL or PLY
    #[arg(value_name = "MESH")]
    pub(crate) mesh: PathBuf,
    /// As JSON
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Debug, Args)]
pub(crate) struct ExportArgs {
    /// The folder of a run, or its elements.ply
    #[arg(value_name = "DIR|elements.ply")]
    pub(crate) from: PathBuf,
    /// The file to write; its extension says the format
    #[arg(short, long, visible_alias = "to", value_name = "FILE", help = export_help())]
    pub(crate) output: PathBuf,
    /// One point per element; one lobe per element, turned to the surface and to the direction of growth; or the tree
    /// of parents as lines that taper from the seed
    #[arg(long, value_parser = what(), hide_possible_values = true, value_name = "points|instances|curves", default_value = "points")]
    pub(crate) what: What,
    #[command(flatten)]
    pub(crate) mesh: MeshArgs,
    #[command(flatten)]
    pub(crate) axes: AxesArgs,
    /// Overwrite the file if it is there
    #[arg(long, help_heading = RUN)]
    pub(crate) force: bool,
    #[command(flatten)]
    pub(crate) run: RunArgs,
}

fn export_help() -> String {
    let line = |f: &SceneFormat| format!("\n.{}: {}", f.extension, f.purpose);
    let formats: String = SCENE_FORMATS.iter().map(line).collect();
    format!("The file to write; its extension says the format:{formats}")
}

fn what() -> impl TypedValueParser<Value = What> {
    choice([
        ("points", What::Points),
        ("instances", What::Instances),
        ("curves", What::Curves),
    ])
}

pub(super) fn up() -> impl TypedValueParser<Value = UpAxis> {
    choice([("y", UpAxis::Y), ("z", UpAxis::Z)])
}

#[derive(Debug, Args)]
#[command(after_help = AFTER_GROW)]
pub(crate) struct GrowArgs {
    /// The mesh: OBJ, glTF (.gltf, .glb), STL or PLY. Not needed with a recipe that names it
    #[arg(value_name = "MESH")]
    pub(crate) mesh: Option<PathBuf>,
    /// Folder to write to: elements.ply, recipe.toml, report.json, preview.png and run.log [default:
    /// out/ and the mesh's name, with -2, -3 and so on when that is taken]
    #[arg(short, long, value_name = "DIR")]
    pub(crate) output: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) look: LookArgs,
    #[command(flatten)]
    pub(crate) stop: StopArgs,
    #[command(flatten)]
    pub(crate) place: PlaceArgs,
    #[command(flatten)]
    pub(crate) mask: MaskArgs,
    #[command(flatten)]
    pub(crate) stand: StandArgs,
    #[command(flatten)]
    pub(crate) walk: WalkArgs,
    /// A recipe file, such as the recipe.toml of an earlier run, to repeat that run exactly; its folder will do too.
    /// Flags override it; it overrides the preset
    #[arg(long, help_heading = RUN, value_name = "FILE.toml")]
    pub(crate) recipe: Option<PathBuf>,
    /// Go on with the run in a folder, whether killed, interrupted or finished, as if it had never stopped: the files
    /// come out the same. A larger size (--elements, --reach, --cover) extends it; MESH says where its mesh is now, and --mask
    /// where its mask is
    #[arg(long, help_heading = RUN, value_name = "DIR", conflicts_with_all = ["output", "recipe", "force", "LookArgs", "PlaceArgs", "StandArgs", "WalkArgs"])]
    pub(crate) resume: Option<PathBuf>,
    /// With --resume: where run.log is damaged, go on from what is sound before that place
    #[arg(long, help_heading = RUN)]
    pub(crate) keep_sound: bool,
    /// Threads to use at most, up to 1024; the result is the same for any number, and growth uses only as many as make it faster
    /// [default: as many as there are cores]
    #[arg(allow_negative_numbers = true, long, help_heading = RUN, value_name = "N", value_parser = threads())]
    pub(crate) threads: Option<u16>,
    /// No progress, notes or warnings: only errors
    #[arg(long, help_heading = RUN)]
    pub(crate) quiet: bool,
    /// Width of preview.png in pixels, 16 to 16384, or 0 for none; it is three quarters as high. A wide one takes longer; one of 640 takes as long
    /// as 20,000 elements
    #[arg(long, value_name = "PIXELS", default_value_t = 640, value_parser = preview_width, help_heading = RUN, allow_negative_numbers = true)]
    pub(crate) preview: u32,
    /// Replace what an earlier run wrote to the folder; that is gone as soon as growth starts
    #[arg(long, help_heading = RUN)]
    pub(crate) force: bool,
}

const AFTER_GROW: &str = "\
Ctrl-C stops growing, writes what there is and exits with 130.
What grows is logged to run.log as it does: a run that was killed goes on with --resume DIR.
Exit codes: 0 done, 1 failed, 2 wrong usage, 130 interrupted.
To try: thallus grow rock.obj -o out/rock --preset foliose";

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
    /// 90 for a wall to 180 for an underside; the steepest, or the least steep and the steepest, as in 30,90 [default: 0,180]
    #[arg(long, value_name = "[LEAST,]MOST", allow_hyphen_values = true)]
    slope: Option<Slope>,
}

/// Where lichen may grow.
#[derive(Debug, Args)]
#[command(next_help_heading = "Place")]
pub(crate) struct MaskArgs {
    /// Where lichen may grow, painted: a PNG or JPEG image in the layout of the mesh's UVs, 'uv1:IMAGE' in that of its second set, or 'vertex-colors' for the
    /// colours in the mesh file. White is as without a mask, on black and where it is transparent nothing grows, and grey
    /// is a factor on the chance to stick: growth is slower and denser there. 'object:NAME' and 'material:NAME' are those
    /// parts of the mesh ('check' lists them): 'material:Bark,Stone*' any of these, 'material:!Leaves' all but one. 'exposed'
    /// is what is not inside another piece of the mesh or right beneath one, as mortar is behind bricks; 'opaque' what materials do not leave open, as leaves
    /// are cut out of an image. The folder of another run on the same mesh is one too: this lichen grows beside that one, not over it. May be given
    /// several times, for where all of them let it; 'none' is for a recipe that has one
    #[arg(
        long,
        value_name = "IMAGE|uv1:IMAGE|vertex-colors|object:NAME|material:NAME|exposed|opaque|DIR|none"
    )]
    mask: Vec<String>,
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

fn preview_width(text: &str) -> Result<u32, &'static str> {
    let width = text.parse().ok();
    let width = width.filter(|width| *width == 0 || (16..=16384).contains(width));
    width.ok_or("give a width from 16 to 16384, or 0 for no picture")
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

/// One of some named values.
pub(super) fn choice<T: Copy + Send + Sync + 'static, const N: usize>(
    values: [(&'static str, T); N],
) -> impl TypedValueParser<Value = T> {
    let names = values.map(|(name, _)| PossibleValue::new(name));
    let named = move |name: String| values.into_iter().find(|(known, _)| name == *known);
    PossibleValuesParser::new(names).try_map(move |name| {
        let value = named(name).map(|(_, value)| value);
        value.ok_or("not one of the values")
    })
}

impl GrowArgs {
    /// What the flags say.
    pub(crate) fn settings(&self) -> Settings {
        let place = (&self.place, &self.mask, &self.stand);
        settings(&self.look, &self.stop, place, &self.walk)
    }
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
        mask: (!mask.mask.is_empty()).then(|| mask.mask.clone()),
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

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;
    use thallus::run::ParameterInfo;

    fn grow(flags: &str) -> Result<Settings, clap::Error> {
        let words = ["thallus", "grow", "rock.obj"];
        let cli = Cli::try_parse_from(words.into_iter().chain(flags.split_whitespace()))?;
        match cli.command {
            Command::Grow(args) => Ok(args.settings()),
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn the_flags_are_sound() {
        Cli::command().debug_assert();
    }

    /// Where a line is broken by hand, a narrower terminal breaks it again and leaves words alone on a line.
    #[test]
    fn paragraphs_below_the_flags_are_broken_by_clap() {
        for command in Cli::command().get_subcommands() {
            let below = command.get_after_help().map(ToString::to_string);
            let lines: Vec<_> = below.iter().flat_map(|text| text.lines()).collect();
            for line in lines.iter().take(lines.len().saturating_sub(1)) {
                assert!(line.ends_with('.'), "{}: {line}", command.get_name());
            }
        }
    }

    #[test]
    fn flags_about_the_file_have_their_own_heading() {
        let mut told = 0;
        for command in Cli::command().get_subcommands() {
            let about_file =
                |flag: &&clap::Arg| ["up", "unit", "scale"].contains(&flag.get_id().as_str());
            for flag in command.get_arguments().filter(about_file) {
                let heading = (command.get_name(), flag.get_help_heading());
                assert!(
                    matches!(heading, ("render", Some("View")) | (_, Some("File"))),
                    "{heading:?}"
                );
                told += 1;
            }
            let runs = command
                .get_arguments()
                .filter(|flag| flag.get_help_heading() == Some("File"));
            assert!(runs.count() <= 3, "{}", command.get_name());
        }
        assert_eq!(told, 12);
    }

    #[test]
    fn no_flags_say_nothing() {
        assert_eq!(grow("").unwrap(), Settings::default());
    }

    #[test]
    fn every_flag_arrives() {
        let flags = "--preset foliose --radius 0.5% --curvature-radius 12r --bias -0.25 --gain 2 \
                     --min-stick 0.1 --seed 18446744073709551615 --at -1,-2,3 --mask m.png --mask out/grey --slope 10,60 \
                     --mesh-up z --launch 2 --kill 20 \
                     --join touch --law brownian --steps small --boundary absorb --reach 30r";
        let expected = Settings {
            preset: Some("foliose".to_owned()),
            radius: Some(Length::Percent(0.5)),
            curvature_radius: Some(Length::Radii(12.0)),
            bias: Some(-0.25),
            gain: Some(2.0),
            min_stick: Some(0.1),
            seed: Some(u64::MAX),
            at: Some(vec![SeedPlace::Point([-1.0, -2.0, 3.0])]),
            mask: Some(vec!["m.png".to_owned(), "out/grey".to_owned()]),
            slope: Slope::new(10.0, 60.0),
            mesh_up: Some(UpAxis::Z),
            launch: Some(2.0),
            kill: Some(20.0),
            join: Some(Join::Touch),
            law: Some(Law::Brownian),
            steps: Some(Steps::Small),
            boundary: Some(Boundary::Absorb),
            stop: Some(StopSetting::Reach(Length::Radii(30.0))),
            ..Settings::default()
        };
        assert_eq!(grow(flags).unwrap(), expected);
    }

    #[test]
    fn sizes_and_places_exclude_one_another() {
        assert!(grow("--elements 5 --cover 0.5").is_err());
        assert!(grow("--reach 5 --cover 0.5").is_err());
        assert!(grow("--at top --at-triangle 3").is_err());
        assert!(grow("--at highest --cover 0.5").is_ok());
    }

    #[test]
    fn help_says_every_parameter_by_its_look_and_range() {
        let mut command = Cli::command();
        let grow = command.find_subcommand_mut("grow").unwrap();
        let help = grow.render_long_help().to_string();
        let words = |text: &str| text.split_whitespace().collect::<Vec<_>>().join(" ");
        let help = words(&help);
        for ParameterInfo { name, .. } in run::PARAMETERS {
            assert!(help.contains(&format!("--{name} <")), "{name}");
        }
        for parameter in run::PARAMETERS {
            assert!(
                help.contains(&words(&parameter.help())),
                "{}",
                parameter.name
            );
        }
    }
}
