//! The command line: raw arguments → validated recipe → library.
//!
//! Results go to stdout; progress, notes and errors to stderr. A reader that closes the pipe early
//! has what it wanted, and is no failure.

mod also;
mod analyze;
mod analyze_args;
mod animate;
mod animate_args;
mod animate_growth;
mod animate_out;
mod animate_picture;
mod args;
mod axes;
mod bake;
mod bake_args;
mod bake_flags;
mod bake_parts;
mod bake_report;
mod bake_where;
mod bake_write;
mod buried;
mod check;
mod check_maps;
mod choice;
mod control_group;
mod cutout;
mod dress;
mod ended;
mod export;
mod facing;
mod failure;
mod foreseen;
mod given;
mod grow;
mod grown;
mod interrupt;
mod mask;
mod mask_layer;
mod mask_tiles;
mod memory;
mod mesh_args;
mod mesh_file;
mod moved;
mod named_mesh;
mod number;
mod output;
mod paths;
mod preset;
mod preview;
mod progress;
mod refusal;
mod render;
mod render_args;
mod render_by;
mod render_camera;
mod resume;
mod run_args;
mod settings_args;
mod skin;
mod skin_args;
mod skin_levels;
mod skin_look;
mod skin_paint;
mod stand_ins;
mod sweep;
mod sweep_args;
mod sweep_ended;
mod sweep_ends;
mod sweep_estimate;
mod sweep_files;
mod sweep_merge;
mod sweep_page;
mod sweep_part;
mod sweep_picture;
mod sweep_plan;
mod sweep_progress;
mod sweep_record;
mod sweep_run;
mod sweep_view;
mod terminal;
mod warnings;

use std::ffi::OsString;
use std::process::ExitCode;

use clap::Parser;

use args::{Cli, Command, PresetCommand};
use failure::Failure;
use terminal::Unsaid;

/// Exit code of a run that Ctrl-C ended, as shells have it: 128 + SIGINT.
const INTERRUPTED: u8 = 130;

pub(crate) fn main() -> ExitCode {
    let cli = match Cli::try_parse_from(typed()) {
        Ok(cli) => cli,
        Err(message) => return answer(message),
    };
    interrupt::survive_file_limits();
    let done = match cli.command {
        Command::Grow(args) => grow::grow(*args),
        Command::Check(args) => check::check(&args),
        Command::Export(args) => export::export(&args),
        Command::Skin(args) => skin::skin(&args),
        Command::Bake(args) => bake::bake(&args),
        Command::Animate(args) => animate::animate(&args),
        Command::Render(args) => render::render(&args),
        Command::Analyze(args) => analyze::analyze(&args),
        Command::Sweep(args) => sweep::sweep(&args),
        Command::Preset(PresetCommand::List) => preset::list(),
        Command::Preset(PresetCommand::Show { name }) => preset::show(&name),
    };
    done.map_or_else(|failure| failure.report(), |()| ExitCode::SUCCESS)
}

/// What was typed. `help` is answered for `help --help`, where clap looks for a command of that name.
fn typed() -> Vec<OsString> {
    let mut words: Vec<_> = std::env::args_os().collect();
    if words.get(1).is_some_and(|word| word == "help") {
        words.retain(|word| word != "--help" && word != "-h");
    }
    words
}

/// What clap has to say: help and version are results; the help that answers an empty command, and
/// errors, are wrong usage.
fn answer(message: clap::Error) -> ExitCode {
    use clap::error::ErrorKind;
    let help = message.kind() == ErrorKind::DisplayHelpOnMissingArgumentOrSubcommand;
    if message.use_stderr() && !help {
        return Failure::from(message).report();
    }
    match message.print() {
        Err(e) if e.kind() != std::io::ErrorKind::BrokenPipe => Failure::from(Unsaid(e)).report(),
        _ => ExitCode::from(u8::try_from(message.exit_code()).unwrap_or(2)),
    }
}
