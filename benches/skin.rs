//! The skin's cost by elements: seconds on all threads, triangles and bytes.
//!
//!     cargo bench --bench skin [elements ...]
//!
//! Elements are grown on the shared rock first, small enough that all of them find room, which takes
//! far longer. On Linux the most memory that the process had so far is told too: the mesh, the
//! growth and the skins before this one are in it.
#![allow(clippy::print_stdout)]

use std::path::Path;
use std::time::Instant;

use thallus::cluster::Cluster;
use thallus::export::{Elements, mesh_format_of};
use thallus::run::{Execution, Length, Settings, StopSetting, grow};
use thallus::skin::{Paint, Shape, decimate, skin};
use thallus::substrate::Substrate;

mod memory;

fn main() {
    let words = std::env::args().skip(1);
    let mut counts: Vec<u64> = words.filter_map(|w| w.parse().ok()).collect();
    if counts.is_empty() {
        counts = vec![20_000, 80_000, 335_732];
    }
    let substrate = Substrate::load(Path::new("meshes/rock.obj")).expect("a mesh");
    println!(
        "{:>10} {:>9} {:>9} {:>11} {:>10} {:>9} {:>9} {:>8}",
        "elements", "skin s", "µs each", "triangles", "glb MB", "write s", "halve s", "peak MB"
    );
    for elements in counts {
        measure(&substrate, &grown(&substrate, elements));
    }
}

fn grown(substrate: &Substrate, elements: u64) -> Cluster {
    // At 0.02 % of the diagonal the rock has room for two million.
    let radius = if elements > 400_000 { 0.02 } else { 0.05 };
    let settings = Settings {
        radius: Some(Length::Percent(radius)),
        stop: Some(StopSetting::Elements(elements)),
        ..Settings::default()
    };
    let recipe = settings.resolve(substrate, "rock").expect("fits");
    let growth = grow(substrate, &recipe, &Execution::default(), &mut ()).expect("grows");
    // As the command has them: read back from a table.
    let table = Elements::of(substrate, &growth.cluster);
    table.to_cluster(substrate).expect("the same mesh")
}

fn measure(substrate: &Substrate, cluster: &Cluster) {
    let started = Instant::now();
    let mesh = skin(substrate, cluster, &Shape::default(), &Paint::default()).expect("a skin");
    let seconds = started.elapsed().as_secs_f64();
    let started = Instant::now();
    let mut bytes = Vec::new();
    let glb = mesh_format_of("lichen.glb".as_ref()).expect("a format");
    glb.write(&mesh, 1.0, &mut bytes).expect("written");
    let write = started.elapsed().as_secs_f64();
    let started = Instant::now();
    let half = decimate(&mesh, mesh.triangles.len() / 2).unwrap();
    assert!(half.triangles.len() < mesh.triangles.len());
    let halve = started.elapsed().as_secs_f64();
    println!(
        "{:>10} {:>9.2} {:>9.1} {:>11} {:>10.0} {:>9.2} {:>9.2} {:>8.0}",
        cluster.len(),
        seconds,
        seconds * 1e6 / cluster.len() as f64,
        mesh.triangles.len(),
        bytes.len() as f64 / 1e6,
        write,
        halve,
        memory::peak_bytes() / 1e6,
    );
}
