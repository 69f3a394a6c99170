//! Watches a lichen grow: an observer of one's own prints its effective radius as it doubles.
//!
//!     cargo run --release --example own_observer -- meshes/rock.obj
#![allow(clippy::print_stdout, clippy::print_stderr)] // printing is what it is for

use std::error::Error;
use std::ops::ControlFlow;
use std::path::Path;
use std::process::ExitCode;

use thallus::cluster::Element;
use thallus::run::{Execution, Observer, Progress, Settings, StopSetting, grow};
use thallus::substrate::Substrate;

/// Prints a line whenever the number of elements has doubled.
struct Doubling {
    next: u64,
}

impl Observer for Doubling {
    fn born(&mut self, element: &Element, progress: &Progress) -> ControlFlow<()> {
        if progress.elements >= self.next {
            self.next *= 2;
            let (n, radius) = (progress.elements, progress.effective_radius);
            println!(
                "{n} elements reach {radius:.4}; the last stuck at P = {:.2}",
                element.probability
            );
        }
        ControlFlow::Continue(())
    }
}

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
        stop: Some(StopSetting::Elements(8192)),
        ..Settings::default()
    };
    let recipe = settings.resolve(&substrate, file)?;
    grow(
        &substrate,
        &recipe,
        &Execution::default(),
        &mut Doubling { next: 64 },
    )?;
    Ok(())
}
