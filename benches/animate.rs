//! What frames cost: all of an animation's skins, written, over the last one by itself.
//!
//!     cargo bench --bench animate [elements [frames]]
//!
//! The last one by itself is `skin()` and the same file. Both on all cores; the lichen is grown first.
//! Other work on the machine changes the time gone by, and CPU seconds of all threads less.
#![allow(clippy::print_stdout)]

mod cpu;

use std::path::Path;
use std::time::Instant;

use thallus::animate::{Clock, Timing};
use thallus::cluster::{Cluster, Ease, Presence};
use thallus::export::{Elements, TriMesh, mesh_format_of};
use thallus::run::{Execution, Length, Settings, StopSetting, grow};
use thallus::skin::{Paint, Shape, SkinFrames, skin};
use thallus::substrate::Substrate;

fn main() {
    let words = std::env::args().skip(1);
    let mut numbers = words.filter_map(|w| w.parse().ok());
    let elements = numbers.next().unwrap_or(100_000);
    let frames = numbers.next().unwrap_or(100);
    let substrate = Substrate::load(Path::new("meshes/rock.obj")).expect("a mesh");
    let cluster = grown(&substrate, u64::from(elements));
    let folder = tempfile::tempdir().expect("a folder");
    println!("{elements} elements, {frames} frames, binary PLY");
    let last = Spent::on(|| {
        let alone = skin(&substrate, &cluster, &Shape::default(), &Paint::default());
        let alone = alone.expect("a skin");
        write(&alone, &folder.path().join("alone.ply"));
        println!("the last has {} triangles", alone.triangles.len());
    });
    println!("the last alone: {last}");
    for (name, clock) in [("birth", Clock::Birth), ("radius", Clock::Radius)] {
        for window in [None, Some(0.0)] {
            let timing = Timing {
                frames,
                window: window.unwrap_or(Timing::usual_window(cluster.len() as f64, frames)),
                ease: Ease::Linear,
                clock: clock.clone(),
            };
            let moments = timing.moments(&cluster).expect("moments");
            let all = Spent::on(|| animate(&substrate, &cluster, moments, folder.path()));
            let (times, window) = (all.cpu / last.cpu, timing.window);
            println!("by {name}, window {window}: {all}, {times:.1} times the last's CPU time");
        }
    }
}

/// Seconds.
struct Spent {
    cpu: f64,
    gone_by: f64,
}

impl Spent {
    fn on(work: impl FnOnce()) -> Self {
        let (cpu, started) = (cpu::seconds(), Instant::now());
        work();
        Self {
            cpu: cpu::seconds() - cpu,
            gone_by: started.elapsed().as_secs_f64(),
        }
    }
}

impl std::fmt::Display for Spent {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{:.2} s of CPU, {:.2} s", self.cpu, self.gone_by)
    }
}

fn animate(substrate: &Substrate, cluster: &Cluster, moments: Vec<Presence>, folder: &Path) {
    let (shape, paint) = (Shape::default(), Paint::default());
    let mut frames = SkinFrames::new(substrate, cluster, &shape, &paint, moments).expect("frames");
    let mut ready = frames.next();
    let mut number = 0;
    while let Some(mesh) = ready {
        number += 1;
        let path = folder.join(format!("frame_{number:04}.ply"));
        ready = rayon::join(|| write(&mesh, &path), || frames.next()).1;
    }
}

fn write(mesh: &TriMesh, path: &Path) {
    let mut file = std::fs::File::create(path).expect("a file");
    let format = mesh_format_of(path).expect("a format");
    format.write(mesh, 1.0, &mut file).expect("written");
}

fn grown(substrate: &Substrate, elements: u64) -> Cluster {
    let settings = Settings {
        radius: Some(Length::Percent(0.05)),
        stop: Some(StopSetting::Elements(elements)),
        ..Settings::default()
    };
    let recipe = settings.resolve(substrate, "rock").expect("fits");
    let growth = grow(substrate, &recipe, &Execution::default(), &mut ()).expect("grows");
    let table = Elements::of(substrate, &growth.cluster);
    table.to_cluster(substrate).expect("the same mesh")
}
