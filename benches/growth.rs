//! What growth costs: a table of workloads, in user CPU time an element.
//!
//!     cargo bench --bench growth                    # all of them, 100,000 elements
//!     cargo bench --bench growth -- rock 20000      # those with 'rock' in their name, 20,000
//!     cargo bench --bench growth -- rock threads=2  # on two threads
#![allow(clippy::print_stdout)] // a table is what it is for

use std::path::Path;
use std::time::Instant;

use thallus::growth::{Join, SeedPlace};
use thallus::run::{Execution, Length, Settings, StopSetting, grow};
use thallus::substrate::Substrate;

struct Workload {
    name: &'static str,
    mesh: &'static str,
    /// In mesh units; on the plane so small that its border is far away at a million elements.
    radius: Option<f64>,
    bias: f64,
    gain: f64,
    join: Join,
}

const WORKLOADS: [Workload; 5] = [
    Workload {
        name: "plane, P = 1, touch",
        mesh: "meshes/plane.obj",
        radius: Some(0.02),
        bias: 1.0,
        gain: 0.0,
        join: Join::Touch,
    },
    Workload {
        name: "plane, B = 0.5, pack",
        mesh: "meshes/plane.obj",
        radius: Some(0.02),
        bias: 0.5,
        gain: 1.0,
        join: Join::Pack,
    },
    Workload {
        name: "rock, B = 0.5, pack",
        mesh: "meshes/rock.obj",
        radius: None,
        bias: 0.5,
        gain: 1.0,
        join: Join::Pack,
    },
    Workload {
        name: "rock, B = 0.1, pack",
        mesh: "meshes/rock.obj",
        radius: None,
        bias: 0.1,
        gain: 1.0,
        join: Join::Pack,
    },
    Workload {
        name: "boulder, B = 0.5, pack",
        mesh: "meshes/boulder.glb",
        radius: None,
        bias: 0.5,
        gain: 1.0,
        join: Join::Pack,
    },
];

fn main() {
    let words: Vec<String> = std::env::args()
        .skip(1)
        .filter(|a| !a.starts_with("--"))
        .collect();
    let elements = words.iter().find_map(|w| w.parse().ok()).unwrap_or(100_000);
    let wanted: Vec<&String> = words
        .iter()
        .filter(|w| w.parse::<u64>().is_err() && !w.starts_with("threads="))
        .collect();
    let threads = words.iter().find_map(|w| w.strip_prefix("threads="));
    let threads = threads.map_or(1, |n| n.parse().expect("a number of threads"));
    println!("{elements} elements; per element:");
    println!(
        "{:24} {:>9} {:>9} {:>9} {:>9} {:>9} {:>9} {:>9} {:>9}",
        "",
        "user µs",
        "time µs",
        "walkers",
        "steps",
        "crossings",
        "contacts",
        "conflicts",
        "serial µs"
    );
    for workload in &WORKLOADS {
        if wanted.iter().all(|w| workload.name.contains(w.as_str())) {
            measure(workload, elements, threads);
        }
    }
}

fn measure(workload: &Workload, elements: u64, threads: usize) {
    let substrate = Substrate::load(Path::new(workload.mesh)).expect("a mesh");
    let settings = Settings {
        radius: workload.radius.map(Length::Units),
        at: Some(SeedPlace::Center),
        bias: Some(workload.bias),
        gain: Some(workload.gain),
        join: Some(workload.join),
        stop: Some(StopSetting::Elements(elements)),
        ..Settings::default()
    };
    let recipe = settings.resolve(&substrate, workload.mesh).expect("fits");
    let execution = Execution {
        threads,
        ..Execution::default()
    };
    let (before, started) = (cpu_seconds(), Instant::now());
    let growth = grow(&substrate, &recipe, &execution, &mut ()).expect("grows");
    let (spent, time) = (cpu_seconds() - before, started.elapsed().as_secs_f64());
    let counts = &growth.counts;
    let each = |n: u64| n as f64 / growth.cluster.len() as f64;
    println!(
        "{:24} {:>9.2} {:>9.2} {:>9.2} {:>9.1} {:>9.1} {:>9.2} {:>9.3} {:>9.2}",
        workload.name,
        spent * 1e6 / growth.cluster.len() as f64,
        time * 1e6 / growth.cluster.len() as f64,
        each(counts.walkers),
        each(counts.steps),
        each(counts.crossings),
        each(counts.contacts),
        each(growth.parallel.conflicts),
        (time - growth.parallel.seconds) * 1e6 / growth.cluster.len() as f64,
    );
}

/// CPU time of this process's threads, where Linux tells it; otherwise time.
fn cpu_seconds() -> f64 {
    static START: std::sync::OnceLock<Instant> = std::sync::OnceLock::new();
    let start = START.get_or_init(Instant::now);
    let tasks = std::fs::read_dir("/proc/self/task").into_iter().flatten();
    let told = |path: std::path::PathBuf| {
        let text = std::fs::read_to_string(path.join("schedstat")).ok()?;
        text.split(' ').next()?.parse::<f64>().ok()
    };
    let nanoseconds: f64 = tasks.flatten().filter_map(|task| told(task.path())).sum();
    match nanoseconds {
        0.0 => start.elapsed().as_secs_f64(),
        n => n * 1e-9,
    }
}
