//! The arguments as they are typed. `--help` is made from these comments and the parameter table.

use std::path::PathBuf;

use clap::builder::TypedValueParser;
use clap::{Args, Parser, Subcommand};
use thallus::export::{SCENE_FORMATS, SceneFormat, What};
use thallus::run::Settings;

use super::analyze_args::AnalyzeArgs;
use super::animate_args::AnimateArgs;
use super::axes::AxesArgs;
use super::bake_args::BakeArgs;
use super::choice::choice;
use super::mesh_args::MeshArgs;
use super::render_args::RenderArgs;
use super::run_args::{RUN, RunArgs, threads};
use super::settings_args::{
    LookArgs, MaskArgs, PlaceArgs, StandArgs, StopArgs, WalkArgs, settings,
};
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
    /// Bake the lichen into textures for a mesh
    ///
    /// Maps in the mesh's own UVs, or in new ones with --unwrap, and the mesh as one GLB file that wears
    /// them. Lengths (LEN) are as for `thallus skin`.
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
    /// come out the same. A larger size (--elements, --reach, --cover) extends it; MESH says where its mesh is now, and
    /// --mask where its mask is
    #[arg(long, help_heading = RUN, value_name = "DIR", conflicts_with_all = ["output", "recipe", "force", "LookArgs", "PlaceArgs", "StandArgs", "WalkArgs"])]
    pub(crate) resume: Option<PathBuf>,
    /// With --resume: where run.log is damaged, go on from what is sound before that place
    #[arg(long, help_heading = RUN)]
    pub(crate) keep_sound: bool,
    /// Threads to use at most, up to 1024; the result is the same for any number, and growth uses only as many as make
    /// it faster [default: as many as there are cores]
    #[arg(allow_negative_numbers = true, long, help_heading = RUN, value_name = "N", value_parser = threads())]
    pub(crate) threads: Option<u16>,
    /// No progress, notes or warnings: only errors
    #[arg(long, help_heading = RUN)]
    pub(crate) quiet: bool,
    /// Width of preview.png in pixels, 16 to 16384, or 0 for none; it is three quarters as high. A wide one takes
    /// longer; one of 640 takes as long as 50,000 elements
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

fn preview_width(text: &str) -> Result<u32, &'static str> {
    let width = text.parse().ok();
    let width = width.filter(|width| *width == 0 || (16..=16384).contains(width));
    width.ok_or("give a width from 16 to 16384, or 0 for no picture")
}

impl GrowArgs {
    /// What the flags say.
    pub(crate) fn settings(&self) -> Settings {
        let place = (&self.place, &self.mask, &self.stand);
        settings(&self.look, &self.stop, place, &self.walk)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;
    use thallus::growth::{Boundary, Join, Law, Steps};
    use thallus::run::{self, Length, ParameterInfo, SeedPlace, Slope, StopSetting};
    use thallus::substrate::UpAxis;

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
