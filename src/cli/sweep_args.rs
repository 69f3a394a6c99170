//! The arguments of `thallus sweep` as they are typed.

use std::fmt;
use std::path::PathBuf;
use std::str::FromStr;

use clap::error::ErrorKind;
use clap::{Arg, ArgAction, ArgMatches, Args, Command, FromArgMatches, Subcommand};
use thallus::picture::Ground;
use thallus::run::Settings;
use thallus::sweep::Axis;

use super::dress::ground;
use super::render_args::Size;
use super::render_camera::View;
use super::run_args::{RUN, RunArgs, threads};
use super::settings_args::{
    LookArgs, MaskArgs, PlaceArgs, StandArgs, StopArgs, WalkArgs, settings,
};

/// Rays through a pixel, at most.
pub(super) const MOST_SAMPLES: u32 = 65_536;

#[derive(Debug, Args)]
#[command(args_conflicts_with_subcommands = true, subcommand_negates_reqs = true, after_help = AFTER)]
pub(crate) struct SweepArgs {
    #[command(subcommand)]
    pub(crate) command: Option<SweepCommand>,
    /// The mesh to grow on; or a grid: a recipe file with a table [axes], such as the grid.toml of an
    /// earlier sweep
    #[arg(value_name = "MESH|GRID.toml", required = true)]
    pub(crate) from: Option<PathBuf>,
    /// Folder to write to. If it is that of the same sweep, what is there is kept, and the rest grows
    #[arg(short, long, value_name = "DIR", required = true)]
    pub(crate) output: Option<PathBuf>,
    /// Where the mesh of a grid lies; or another mesh for it to grow on, where its lengths stay as they are [default:
    /// where the grid says, seen from here or from the grid]
    #[arg(long, value_name = "MESH")]
    pub(crate) mesh: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) axes: AxisArgs,
    /// Runs per cell, with the seed of --seed and the numbers after it, the same in every cell [default: 1]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..), help_heading = AXES, allow_negative_numbers = true)]
    pub(crate) seeds: Option<u32>,
    /// Grow only the I-th of N parts of the runs, which take about equally long: see 'thallus sweep
    /// merge --help'
    #[arg(long, value_name = "I/N", help_heading = PARTS, conflicts_with = "only")]
    pub(crate) shard: Option<Shard>,
    /// Grow only this cell: its name, such as L=5r_B=0.2. Its unfinished runs go on; if all are finished, the cell
    /// grows anew. What is there of another run is replaced
    #[arg(long, value_name = "CELL", help_heading = PARTS)]
    pub(crate) only: Option<String>,
    #[command(flatten)]
    pub(crate) pictures: PictureArgs,
    #[command(flatten)]
    pub(crate) look: LookArgs,
    #[command(flatten)]
    pub(crate) stop: SizeArgs,
    #[command(flatten)]
    pub(crate) place: PlaceArgs,
    #[command(flatten)]
    pub(crate) mask: MaskArgs,
    #[command(flatten)]
    pub(crate) stand: StandArgs,
    #[command(flatten)]
    pub(crate) walk: WalkArgs,
    /// A recipe file for what all cells share. Flags override it; it overrides the preset
    #[arg(long, help_heading = RUN, value_name = "FILE.toml")]
    pub(crate) recipe: Option<PathBuf>,
    /// Runs at a time, and threads for everything else, up to 1024; the result is the same for any number
    /// [default: all cores]
    #[arg(allow_negative_numbers = true, long, help_heading = RUN, value_name = "N", value_parser = threads())]
    pub(crate) threads: Option<u16>,
    /// No progress, notes or warnings: only errors
    #[arg(long, help_heading = RUN)]
    pub(crate) quiet: bool,
}

#[derive(Debug, Subcommand)]
pub(crate) enum SweepCommand {
    /// Join the folders of parts that were grown with --shard
    ///
    /// The parts have the same command except for I and -o. Every run of the grid, or its error, must be in one of
    /// them: what is missing is named. Files come out as those of a sweep that was grown in one go, except for the
    /// seconds. Parts that share one folder need no joining: the last one to finish makes the page.
    Merge(MergeArgs),
}

#[derive(Debug, Args)]
pub(crate) struct MergeArgs {
    /// The folders of the parts
    #[arg(value_name = "DIR", required = true)]
    pub(crate) parts: Vec<PathBuf>,
    /// Folder to write to: a new one, or one that holds a part, which the others are added to; after
    /// an interruption the same command goes on
    #[arg(short, long, value_name = "OUT")]
    pub(crate) output: PathBuf,
    /// Where the mesh lies now [default: where the grid says, seen from here or from the grid]
    #[arg(long, value_name = "MESH")]
    pub(crate) mesh: Option<PathBuf>,
    /// Where the mask lies now, if the sweep has one; several as they were given to it [default: where the grid says,
    /// seen from here or from the grid]
    #[arg(
        long,
        value_name = "IMAGE|uv1:IMAGE|vertex-colors|object:NAME|material:NAME|exposed|opaque|DIR"
    )]
    pub(crate) mask: Vec<String>,
    #[command(flatten)]
    pub(crate) pictures: PictureArgs,
    #[command(flatten)]
    pub(crate) run: RunArgs,
}

/// How the pictures of the cells are taken.
#[derive(Debug, Args)]
#[command(next_help_heading = "Pictures (of the first seed of each cell)")]
pub(crate) struct PictureArgs {
    /// Where to look from, the same for all cells: 'auto' finds the side that shows most of all lichens together;
    /// a side, as front or top; degrees round the mesh and above the horizon, as 30,45; or JSON as for 'thallus
    /// render' [default: as before in this sweep, or auto]
    #[arg(
        long,
        value_name = "auto|SIDE|AZIMUTH,ELEVATION|JSON",
        allow_hyphen_values = true
    )]
    pub(crate) camera: Option<View>,
    /// Pixels across and down, up to 16384 each [default: as before in this sweep, or 800x800]
    #[arg(long, value_name = "WIDTHxHEIGHT", allow_hyphen_values = true)]
    pub(crate) size: Option<Size>,
    /// Rays through a pixel, at most: more remove grain but take longer [default: as before in this sweep, or 4]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=i64::from(MOST_SAMPLES)), allow_negative_numbers = true)]
    pub(crate) samples: Option<u32>,
    /// What the mesh is drawn as in pictures: granite; bark, with furrows along its longest side; or one
    /// colour [default: as before in this sweep, or stone]
    #[arg(long, value_parser = ground, value_name = "stone|bark|#RRGGBB")]
    pub(crate) ground: Option<Ground>,
}

const AXES: &str = "Axes";
const PARTS: &str = "Parts of a sweep";

/// A paragraph is one line here, as clap breaks lines to the width of the terminal.
const AFTER: &str = "\
An axis takes VALUES: a list such as 5r,10r,20r, whose parts may be ranges: 0.2..1.0/5 is five \
values at equal distances, 3r..300r/5log five of equal ratio, with both ends. Separate values by \
';' where they have commas, as in --axis 'at=0,1,0; 1,0,0'. The first axis goes across the page, \
the second down; each combination of further ones is a page.
Every cell grows to the same effective radius, 150 radii of the largest elements, unless \
--elements, --reach or --cover says otherwise.
A grid file is a recipe file with seeds = N and, at its end, a table [axes] with one line per axis: \
L = \"5r,10r,20r\" or bias = [0.2, 0.5].
DIR gets grid.toml, pictures.toml, cells/CELL/seed-N/ with all that 'thallus grow' writes but the \
preview, results.csv, results.parquet, pictures/, contact-sheet.png and report.html.
After Ctrl-C, a kill or a power cut the same command goes on. A kill or a power cut loses the \
elements that were not on the disk yet: as a rule those of some seconds, of two minutes or more \
where the disk stalls.
A run that fails or is impossible leaves cells/CELL/seed-N.error.txt, and the others go on.
Exit codes: 0 done, 1 a run failed or is missing, 2 wrong usage, 130 interrupted.
To try: thallus sweep rock.obj -o out/grid --L 5r,10r,20r --B 0.3,0.5,0.9";

/// As many as runs.
const MOST_PARTS: usize = 1_000_000;

/// A part of the runs: the I-th of N.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Shard {
    pub(crate) part: usize,
    pub(crate) parts: usize,
}

impl fmt::Display for Shard {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}/{}", self.part, self.parts)
    }
}

impl FromStr for Shard {
    type Err = &'static str;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        const FORM: &str = "write I/N, the I-th of N parts, from 1, as 2/8";
        let (part, parts) = text.split_once('/').ok_or(FORM)?;
        let number = |text: &str| text.trim().parse::<usize>().map_err(|_| FORM);
        let (part, parts) = (number(part)?, number(parts)?);
        match (1..=parts).contains(&part) {
            true if parts > MOST_PARTS => {
                Err("there are a million parts at most, as there are runs")
            }
            true => Ok(Self { part, parts }),
            false => Err(FORM),
        }
    }
}

/// The size of each cell. The default is not that of `thallus grow`.
#[derive(Debug)]
pub(crate) struct SizeArgs(StopArgs);

impl Args for SizeArgs {
    fn augment_args(command: Command) -> Command {
        StopArgs::augment_args(command)
            .mut_arg("elements", |arg| arg.help("Stop at this many elements"))
            .mut_arg("reach", |arg| {
                arg.help(
                    "Stop at this effective radius, as 300r; of several colonies, when one extends \
                     this far from its seed [default: 150 radii of the largest elements, in every \
                     cell]",
                )
            })
    }

    fn augment_args_for_update(command: Command) -> Command {
        Self::augment_args(command)
    }
}

impl FromArgMatches for SizeArgs {
    fn from_arg_matches(matches: &ArgMatches) -> Result<Self, clap::Error> {
        StopArgs::from_arg_matches(matches).map(Self)
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), clap::Error> {
        self.0.update_from_arg_matches(matches)
    }
}

/// The axes, in the order in which they were given.
#[derive(Debug, Default)]
pub(crate) struct AxisArgs(pub(crate) Vec<Axis>);

/// The flags of axes, and which setting each varies; `--axis` says it itself.
const FLAGS: [(&str, Option<&str>, &str, &str); 3] = [
    (
        "L",
        Some("curvature-radius"),
        "VALUES",
        "Vary the curvature radius, as 5r,10r,20r: the width of the branches",
    ),
    (
        "B",
        Some("bias"),
        "VALUES",
        "Vary the sticking bias, as 0.2..1.0/5: openness",
    ),
    (
        "axis",
        None,
        "NAME=VALUES",
        "Vary any setting of a recipe but mesh, mesh-up, mask and seed, as gain=1..4/3log or \
         preset=foliose,crustose. May be repeated",
    ),
];

impl Args for AxisArgs {
    fn augment_args(command: Command) -> Command {
        let flag = |(name, _, values, help): (&'static str, _, &'static str, &'static str)| {
            Arg::new(name)
                .long(name)
                .value_name(values)
                .help(help)
                .help_heading(AXES)
                .action(ArgAction::Append)
                .allow_hyphen_values(true)
        };
        FLAGS
            .into_iter()
            .fold(command, |command, f| command.arg(flag(f)))
    }

    fn augment_args_for_update(command: Command) -> Command {
        Self::augment_args(command)
    }
}

impl FromArgMatches for AxisArgs {
    fn from_arg_matches(matches: &ArgMatches) -> Result<Self, clap::Error> {
        let mut axes = Vec::new();
        for (flag, name, ..) in FLAGS {
            let texts = matches.get_many::<String>(flag).unwrap_or_default();
            let places = matches.indices_of(flag).unwrap_or_default();
            for (place, text) in places.zip(texts) {
                axes.push((place, axis(name, text).map_err(wrong)?));
            }
        }
        axes.sort_by_key(|(place, _)| *place);
        Ok(Self(axes.into_iter().map(|(_, axis)| axis).collect()))
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), clap::Error> {
        *self = Self::from_arg_matches(matches)?;
        Ok(())
    }
}

fn axis(name: Option<&str>, text: &str) -> Result<Axis, String> {
    let (name, values) = match (name, text.split_once('=')) {
        (Some(name), _) => (name, text),
        (None, Some(parts)) => parts,
        (None, None) => return Err(format!("--axis {text}: write NAME=VALUES, as gain=1,2,4")),
    };
    Axis::parse(name, values).map_err(|e| e.to_string())
}

fn wrong(message: String) -> clap::Error {
    clap::Error::raw(ErrorKind::ValueValidation, message)
}

impl SweepArgs {
    /// What the flags say.
    pub(crate) fn settings(&self) -> Settings {
        let place = (&self.place, &self.mask, &self.stand);
        settings(&self.look, &self.stop.0, place, &self.walk)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cli::args::{Cli, Command};
    use clap::Parser;

    fn sweep(words: &str) -> Result<SweepArgs, String> {
        let words = ["thallus", "sweep"]
            .into_iter()
            .chain(words.split_whitespace());
        match Cli::try_parse_from(words)
            .map_err(|e| e.to_string())?
            .command
        {
            Command::Sweep(args) => Ok(*args),
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn axes_keep_their_order() {
        let keys = |words: &str| -> Vec<&str> {
            let args = sweep(&format!("rock.obj -o out {words}")).unwrap();
            args.axes.0.iter().map(Axis::key).collect()
        };
        assert_eq!(keys("--L 5r --B 0.5"), ["curvature-radius", "bias"]);
        assert_eq!(
            keys("--axis gain=1,2 --B=-0.5,1 --axis join=pack --L 5r --bias 1"),
            ["gain", "bias", "join", "curvature-radius"]
        );
        let wrong = sweep("rock.obj -o out --axis gain").unwrap_err();
        assert!(wrong.contains("NAME=VALUES"), "{wrong}");
        let wrong = sweep("rock.obj -o out --B 0.5,x").unwrap_err();
        assert!(wrong.contains("axis bias"), "{wrong}");
    }

    #[test]
    fn shards_are_one_of_so_many() {
        assert_eq!("2/8".parse(), Ok(Shard { part: 2, parts: 8 }));
        assert!("1/1000000".parse::<Shard>().is_ok());
        for text in [
            "",
            "2",
            "0/3",
            "4/3",
            "1/0",
            "a/b",
            "-1/2",
            "1/2/3",
            "1/1000001",
        ] {
            assert!(text.parse::<Shard>().is_err(), "{text}");
        }
    }

    #[test]
    fn merge_is_a_command_of_its_own() {
        let args = sweep("merge a b -o c").unwrap();
        let Some(SweepCommand::Merge(merge)) = args.command else {
            panic!("{args:?}")
        };
        assert_eq!((merge.parts.len(), merge.output), (2, PathBuf::from("c")));
        assert!(sweep("rock.obj").unwrap_err().contains("--output"));
        assert!(sweep("-o out").unwrap_err().contains("MESH"));
    }
}
