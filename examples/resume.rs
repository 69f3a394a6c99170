//! Grows a lichen and logs it; called again, goes on with the log. Kill it and see.
//!
//!     cargo run --release --example resume -- meshes/rock.obj rock.log
#![allow(clippy::print_stdout, clippy::print_stderr)] // printing is what it is for

use std::error::Error;
use std::path::Path;
use std::process::ExitCode;

use thallus::log::{Log, LogWriter};
use thallus::run::{Begun, Execution, Recipe, Run, Settings, StopSetting};
use thallus::substrate::Substrate;

/// The log, and what it has of an earlier call.
fn log_of(recipe: &Recipe, path: &Path) -> Result<(LogWriter, Begun), Box<dyn Error>> {
    if !path.exists() {
        return Ok((LogWriter::create(path, recipe)?, Begun::default()));
    }
    let log = Log::read(path)?;
    log.check(recipe)?;
    Ok(LogWriter::open(log)?)
}

fn main() -> ExitCode {
    let mut words = std::env::args().skip(1);
    let file = words.next().unwrap_or_else(|| "meshes/rock.obj".into());
    let log = words.next().unwrap_or_else(|| "rock.log".into());
    match run(&file, Path::new(&log)) {
        Ok(elements) => {
            println!("{log} has {elements} elements");
            ExitCode::SUCCESS
        }
        Err(error) => {
            eprintln!("{error}");
            ExitCode::FAILURE
        }
    }
}

/// How many elements the log has in the end.
pub(crate) fn run(file: &str, log: &Path) -> Result<usize, Box<dyn Error>> {
    let substrate = Substrate::load(Path::new(file))?;
    let settings = Settings {
        stop: Some(StopSetting::Elements(100_000)),
        ..Settings::default()
    };
    let recipe = settings.resolve(&substrate, file)?;
    let (mut writer, begun) = log_of(&recipe, log)?;
    println!("going on from {} elements", begun.elements.len());
    let run = Run::new(&substrate, &recipe, begun)?;
    let growth = run.grow(&Execution::default(), &mut writer);
    writer.finish()?;
    Ok(growth.cluster.len())
}
