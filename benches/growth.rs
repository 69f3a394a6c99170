//! What growth costs: a table of workloads, in user CPU time an element.
//!
//!     cargo bench --bench growth                    # all of them, 100,000 elements
//!     cargo bench --bench growth -- rock 20000      # those with 'rock' in their name, 20,000
#![allow(clippy::print_stdout)] // a table is what it is for

use std::path::Path;
use std::time::Instant;

use thallus::growth::{Join, SeedPlace};
use thallus::run::{Execution, Settings, StopSetting, grow};
use thallus::substrate::Substrate;

struct Workload {
    name: &'static str,
    mesh: &'static str,
    bias: f64,
    gain: f64,
    join: Join,
}

const WORKLOADS: [Workload; 5] = [
    Workload {
        name: "plane, P = 1, touch",
        mesh: "meshes/plane.obj",
        bias: 1.0,
        gain: 0.0,
        join: Join::Touch,
    },
    Workload {
        name: "plane, B = 0.5, pack",
        mesh: "meshes/plane.obj",
        bias: 0.5,
        gain: 1.0,
        join: Join::Pack,
    },
    Workload {
        name: "rock, B = 0.5, pack",
        mesh: "meshes/rock.obj",
        bias: 0.5,
        gain: 1.0,
        join: Join::Pack,
    },
    Workload {
        name: "rock, B = 0.1, pack",
        mesh: "meshes/rock.obj",
        bias: 0.1,
        gain: 1.0,
        join: Join::Pack,
    },
    Workload {
        name: "boulder, B = 0.5, pack",
        mesh: "meshes/boulder.glb",
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
    let wanted: Vec<&String> = words.iter().filter(|w| w.parse::<u64>().is_err()).collect();
    println!("{elements} elements; per element:");
    println!(
        "{:24} {:>9} {:>9} {:>9} {:>9} {:>9}",
        "", "user µs", "walkers", "steps", "crossings", "contacts"
    );
    for workload in &WORKLOADS {
        if wanted.iter().all(|w| workload.name.contains(w.as_str())) {
            measure(workload, elements);
        }
    }
}

fn measure(workload: &Workload, elements: u64) {
    let substrate = Substrate::load(Path::new(workload.mesh)).expect("a mesh");
    let settings = Settings {
        at: Some(SeedPlace::Center),
        bias: Some(workload.bias),
        gain: Some(workload.gain),
        join: Some(workload.join),
        stop: Some(StopSetting::Elements(elements)),
        ..Settings::default()
    };
    let recipe = settings.resolve(&substrate, workload.mesh).expect("fits");
    let before = cpu_seconds();
    let growth = grow(&substrate, &recipe, &Execution::default(), &mut ()).expect("grows");
    let spent = cpu_seconds() - before;
    let counts = &growth.counts;
    let each = |n: u64| n as f64 / growth.cluster.len() as f64;
    println!(
        "{:24} {:>9.2} {:>9.2} {:>9.1} {:>9.1} {:>9.2}",
        workload.name,
        spent * 1e6 / growth.cluster.len() as f64,
        each(counts.walkers),
        each(counts.steps),
        each(counts.crossings),
        each(counts.contacts),
    );
}

/// CPU time of this process, where Linux tells it; otherwise time.
fn cpu_seconds() -> f64 {
    static START: std::sync::OnceLock<Instant> = std::sync::OnceLock::new();
    let start = START.get_or_init(Instant::now);
    let told = std::fs::read_to_string("/proc/self/schedstat").ok();
    let nanoseconds = told.and_then(|s| s.split(' ').next()?.parse::<f64>().ok());
    nanoseconds.map_or_else(|| start.elapsed().as_secs_f64(), |n| n * 1e-9)
}
