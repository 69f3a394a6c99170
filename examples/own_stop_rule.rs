//! Stops by a rule of one's own: when the lichen has come down to half the mesh's height.
//!
//!     cargo run --release --example own_stop_rule -- meshes/rock.obj
#![allow(clippy::print_stdout)] // printing is what it is for

use std::error::Error;
use std::ops::ControlFlow;
use std::path::Path;

use thallus::run::{Execution, Settings, StopSetting, grow, watch};
use thallus::substrate::Substrate;

fn main() -> Result<(), Box<dyn Error>> {
    let file = std::env::args()
        .nth(1)
        .unwrap_or_else(|| "meshes/rock.obj".into());
    let substrate = Substrate::load(Path::new(&file))?;
    let settings = Settings {
        stop: Some(StopSetting::Elements(100_000)),
        ..Settings::default()
    };
    let recipe = settings.resolve(&substrate, &file)?;
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
    println!(
        "{} elements, ended by {:?}",
        growth.cluster.len(),
        growth.stopped
    );
    Ok(())
}
