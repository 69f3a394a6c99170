//! Opens a finished run, writes its lichen as a skin and as a table for other programs, and grows on it until it is
//! told to stop.
//!
//!     cargo run --release -- grow meshes/rock.obj -o out/rock
//!     cargo run --release --example files -- out/rock lichen
#![allow(clippy::print_stdout, clippy::print_stderr)] // printing is what it is for

use std::error::Error;
use std::io::ErrorKind;
use std::path::Path;
use std::process::ExitCode;
use std::sync::atomic::Ordering;
use std::thread;
use std::time::Duration;

use thallus::cluster::Cluster;
use thallus::export::{
    Elements, OutputError, Placement, UpAxis, format_of, mesh_format_of, write_file_atomically,
};
use thallus::growth::SeedPlace;
use thallus::log::{Log, LogError};
use thallus::picture::age_color;
use thallus::run::{Execution, Settings, StopSetting, Stopped, grow};
use thallus::skin::{Paint, Shape, skin};
use thallus::substrate::Substrate;

fn main() -> ExitCode {
    let mut words = std::env::args().skip(1);
    let folder = words.next().unwrap_or_else(|| "out/rock".into());
    let name = words.next().unwrap_or_else(|| "lichen".into());
    match run(Path::new(&folder), &name) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("{error}{}", advice(&*error));
            ExitCode::FAILURE
        }
    }
}

/// What to do about an error, where that depends on which it is.
fn advice(error: &(dyn Error + 'static)) -> &'static str {
    match (error.downcast_ref(), error.downcast_ref()) {
        (Some(LogError::Read { problem, .. }), _) if problem.kind() == ErrorKind::NotFound => {
            ": grow a lichen there first"
        }
        (_, Some(OutputError::FileExists(_))) => ": give another name",
        _ => "",
    }
}

/// Writes `NAME.glb` and `NAME.ply` of the run in a folder.
pub(crate) fn run(folder: &Path, name: &str) -> Result<(), Box<dyn Error>> {
    let (substrate, cluster) = open(folder)?;
    println!("{} elements", cluster.len());
    write_skin(&substrate, &cluster, Path::new(&format!("{name}.glb")))?;
    write_table(&substrate, &cluster, Path::new(&format!("{name}.ply")))?;
    let (elements, stopped) = grow_for(Duration::from_millis(200), &substrate)?;
    println!("another has {elements} elements by now, ended by {stopped:?}");
    Ok(())
}

/// The mesh of a run, and the lichen on it, every element to the last bit.
fn open(folder: &Path) -> Result<(Substrate, Cluster), Box<dyn Error>> {
    let log = Log::read(&folder.join("run.log"))?;
    let mesh = log.recipe.mesh.as_ref().ok_or("the log names no mesh")?;
    let substrate = Substrate::load(Path::new(mesh))?.with_up(log.recipe.mesh_up);
    let cluster = log.cluster(&substrate)?;
    Ok((substrate, cluster))
}

/// A skin in the format that the file's name says, in its axes: glTF has y up and is in metres, which this takes the
/// mesh's units for.
fn write_skin(substrate: &Substrate, cluster: &Cluster, file: &Path) -> Result<(), Box<dyn Error>> {
    let format = mesh_format_of(file)?;
    let mut mesh = skin(substrate, cluster, &Shape::default(), &Paint::default())?;
    mesh.place(&Placement {
        from: substrate.up_axis(),
        to: UpAxis::Y,
        scale: 1.0,
    });
    write_file_atomically(file, false, |out| format.write(&mesh, 1.0, out))?;
    println!("{}: {} triangles", file.display(), mesh.triangles.len());
    Ok(())
}

/// A point per element, with its attributes.
fn write_table(
    substrate: &Substrate,
    cluster: &Cluster,
    file: &Path,
) -> Result<(), Box<dyn Error>> {
    let format = format_of(file)?;
    let elements = Elements::of(substrate, cluster);
    write_file_atomically(file, false, |out| format.write(&elements, &age_color, out))?;
    println!("{}: {} points", file.display(), elements.len());
    Ok(())
}

/// Grows a lichen at a random place for so long: another thread, as that of a window with a button, says when to stop.
fn grow_for(time: Duration, substrate: &Substrate) -> Result<(usize, Stopped), Box<dyn Error>> {
    let settings = Settings {
        mesh_up: substrate.unusual_up(),
        at: Some(vec![SeedPlace::Random]),
        stop: Some(StopSetting::Cover(1.0)),
        ..Settings::default()
    };
    let recipe = settings.resolve(substrate, "the same mesh")?;
    let execution = Execution::default();
    let cancel = execution.cancel.clone();
    let button = thread::spawn(move || {
        thread::sleep(time);
        cancel.store(true, Ordering::Relaxed);
    });
    let growth = grow(substrate, &recipe, &execution, &mut ())?;
    button.join().map_err(|_| "the other thread panicked")?;
    Ok((growth.cluster.len(), growth.stopped))
}
