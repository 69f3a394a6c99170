//! Stops by a rule of one's own: when the lichen has come down to half the mesh's height.
//!
//!     cargo run --release --example own_stop_rule -- meshes/rock.obj
#![allow(clippy::print_stdout, clippy::print_stderr)] // printing is what it is for

use std::error::Error;
use std::ops::ControlFlow;
use std::path::Path;
use std::process::ExitCode;

use thallus::run::{Execution, Length, Settings, StopSetting, Stopped, grow, watch};
use thallus::substrate::Substrate;

fn main() -> ExitCode {
    let file = std::env::args().nth(1);
    match run(file.as_deref().unwrap_or("meshes/rock.obj")) {
        Ok((elements, stopped)) => {
            println!("{elements} elements, ended by {stopped:?}");
            ExitCode::SUCCESS
        }
        Err(error) => {
            eprintln!("{error}");
            ExitCode::FAILURE
        }
    }
}

/// How many elements there are in the end, and why no more.
pub(crate) fn run(file: &str) -> Result<(usize, Stopped), Box<dyn Error>> {
    let substrate = Substrate::load(Path::new(file))?;
    let settings = Settings {
        radius: Some(Length::Percent(0.5)),
        // Far more than the rule below lets grow.
        stop: Some(StopSetting::Elements(100_000)),
        ..Settings::default()
    };
    let recipe = settings.resolve(&substrate, file)?;
    // Local units count from the middle of the bounding box, so half the height is 0.
    let mut half_way_down = watch(|element, _| {
        if element.position.dot(substrate.up()) < 0.0 {
            ControlFlow::Break(())
        } else {
            ControlFlow::Continue(())
        }
    });
    let growth = grow(
        &substrate,
        &recipe,
        &Execution::default(),
        &mut half_way_down,
    )?;
    Ok((growth.cluster.len(), growth.stopped))
}
