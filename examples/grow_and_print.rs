//! Grows a lichen on a mesh file and prints where its elements are.
//!
//!     cargo run --release --example grow_and_print -- meshes/rock.obj
#![allow(clippy::print_stdout, clippy::print_stderr)] // printing is what it is for

use std::error::Error;
use std::path::Path;
use std::process::ExitCode;

use thallus::run::{Execution, Settings, StopSetting, grow};
use thallus::substrate::Substrate;

fn main() -> ExitCode {
    let file = std::env::args().nth(1);
    match run(file.as_deref().unwrap_or("meshes/rock.obj")) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("{error}");
            ExitCode::FAILURE
        }
    }
}

pub(crate) fn run(file: &str) -> Result<(), Box<dyn Error>> {
    let substrate = Substrate::load(Path::new(file))?;
    let settings = Settings {
        stop: Some(StopSetting::Elements(1000)),
        ..Settings::default()
    };
    let recipe = settings.resolve(&substrate, file)?;
    let growth = grow(&substrate, &recipe, &Execution::default(), &mut ())?;
    for element in growth.cluster.elements() {
        let p = substrate.units().to_file(element.position);
        println!("{} {} {}", p.x, p.y, p.z);
    }
    Ok(())
}
