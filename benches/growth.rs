//! What growth costs: a table of workloads, in CPU time an element, of the program and of the system on its
//! behalf. What it takes to prepare the surface, once it is read, is told beside it.
//!
//!     cargo bench --bench growth                    # all of them, 100,000 elements, and the reference
//!     cargo bench --bench growth -- rock 20000      # those with 'rock' in their name, 20,000
//!     cargo bench --bench growth -- rock threads=2  # on two threads: one has no conflicts
//!     cargo bench --bench growth -- reference       # the thesis written out, against the engine
//!     cargo bench --bench growth -- scale           # 100,000 and a million on the plane: power and memory
//!
//! A lookup is a question to the index how far the lichen is: outside the sphere that holds the lichen, steps mostly
//! need none. They are counted in a run of their own, which is not timed. Contacts ask for the elements near them
//! besides.
#![allow(clippy::print_stdout)] // a table is what it is for

use std::path::Path;
use std::time::Instant;

use thallus::growth::{Join, Law, SeedPlace};
use thallus::run::{Execution, Growth, Length, Recipe, Settings, StopSetting, grow};
use thallus::substrate::{Substrate, load_soup};

mod counting;
mod cpu;
#[allow(unused, reason = "the tests use the rest")]
#[path = "../tests/common/finer.rs"]
mod finer;
mod memory;
#[allow(unused, reason = "the tests use the rest")]
#[path = "../tests/reference/mod.rs"]
mod reference;

struct Workload {
    name: &'static str,
    mesh: &'static str,
    /// In mesh units; on the plane so small that its border is far away at a million elements.
    radius: Option<f64>,
    bias: f64,
    gain: f64,
    join: Join,
    law: Law,
    /// How often each triangle is cut in four.
    subdivided: u32,
}

const LICHEN: Workload = Workload {
    name: "",
    mesh: "meshes/plane.obj",
    radius: None,
    bias: 0.5,
    gain: 1.0,
    join: Join::Pack,
    law: Law::Thesis,
    subdivided: 0,
};

const WORKLOADS: [Workload; 8] = [
    Workload {
        name: "plane, P = 1, touch",
        mesh: "meshes/plane.obj",
        radius: Some(0.02),
        bias: 1.0,
        gain: 0.0,
        join: Join::Touch,
        ..LICHEN
    },
    Workload {
        name: "plane, B = 0.5, pack",
        mesh: "meshes/plane.obj",
        radius: Some(0.02),
        ..LICHEN
    },
    Workload {
        name: "rock, B = 0.5, pack",
        mesh: "meshes/rock.obj",
        ..LICHEN
    },
    Workload {
        name: "rock, B = 0.1, pack",
        mesh: "meshes/rock.obj",
        bias: 0.1,
        ..LICHEN
    },
    Workload {
        name: "rock in 1.18M, B = 0.5",
        mesh: "meshes/rock.obj",
        subdivided: 4,
        ..LICHEN
    },
    Workload {
        name: "plane, P = 1, brownian",
        radius: Some(0.02),
        bias: 1.0,
        gain: 0.0,
        join: Join::Touch,
        law: Law::Brownian,
        ..LICHEN
    },
    Workload {
        name: "rock, B = 0.5, brownian",
        mesh: "meshes/rock.obj",
        law: Law::Brownian,
        ..LICHEN
    },
    Workload {
        name: "boulder, B = 0.5, pack",
        mesh: "meshes/boulder.glb",
        ..LICHEN
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
        "{:24} {:>9} {:>9} {:>9} {:>9} {:>9} {:>9} {:>9} {:>9} {:>9} {:>9}",
        "",
        "CPU µs",
        "prepare",
        "time µs",
        "walkers",
        "steps",
        "crossings",
        "lookups",
        "contacts",
        "conflicts",
        "serial µs"
    );
    for workload in &WORKLOADS {
        if wanted.iter().all(|w| workload.name.contains(w.as_str())) {
            measure(workload, elements, threads);
        }
    }
    let asked = |word: &str| wanted.iter().any(|w| w.as_str() == word);
    if wanted.is_empty() || asked("reference") {
        compare_with_reference();
    }
    if asked("scale") {
        scale();
    }
}

/// How time and memory grow with the lichen.
fn scale() {
    let plane = &WORKLOADS[0];
    let (substrate, _) = surface(plane);
    let [small, large] = [100_000, 1_000_000].map(|elements| {
        let (spent, _, growth) = grown(plane, &substrate, elements, 1);
        spent * 1e6 / growth.cluster.len() as f64
    });
    let bytes = memory::peak_bytes() / 1e6;
    let power = 1.0 + (large / small).log10();
    println!(
        "{}: {small:.2} µs an element for 100,000, {large:.2} for a million: the power {power:.3}; at the peak \
         {bytes:.0} bytes an element of the million, the program with it",
        plane.name
    );
}

/// The rock at B = 0.5 by the literal program of the tests and by the engine, as far as the first
/// comes in reasonable time.
fn compare_with_reference() {
    const ELEMENTS: usize = 2000;
    let soup = load_soup(Path::new("meshes/rock.obj"))
        .expect("a mesh")
        .soup;
    let substrate = Substrate::from_soup(soup.clone()).expect("a surface");
    let params = reference::Params::new(substrate.auto_radius(), 1);
    let before = cpu::seconds();
    let stop = reference::Stop::at_elements(ELEMENTS);
    let run = reference::grow(&soup.positions, &soup.triangles, &params, stop);
    let literal = (cpu::seconds() - before) * 1e6 / run.elements.len() as f64;
    let settings = Settings {
        at: Some(vec![SeedPlace::Center]),
        stop: Some(StopSetting::Elements(ELEMENTS as u64)),
        ..Settings::default()
    };
    let recipe = settings.resolve(&substrate, "").expect("fits");
    let before = cpu::seconds();
    grow(&substrate, &recipe, &Execution::default(), &mut ()).expect("grows");
    let engine = (cpu::seconds() - before) * 1e6 / ELEMENTS as f64;
    println!(
        "rock, B = 0.5, {ELEMENTS} elements: the thesis written out {literal:.0} µs, here {engine:.1} µs: \
         {:.0} times as fast",
        literal / engine
    );
}

/// The surface of a workload, and the CPU seconds that it took to prepare it.
fn surface(workload: &Workload) -> (Substrate, f64) {
    let soup = load_soup(Path::new(workload.mesh)).expect("a mesh").soup;
    let soup = finer::in_fours(soup, workload.subdivided);
    let before = cpu::seconds();
    let substrate = Substrate::from_soup(soup).expect("a surface");
    (substrate, cpu::seconds() - before)
}

fn recipe(workload: &Workload, substrate: &Substrate, elements: u64) -> Recipe {
    let settings = Settings {
        radius: workload.radius.map(Length::Units),
        at: Some(vec![SeedPlace::Center]),
        bias: Some(workload.bias),
        gain: Some(workload.gain),
        join: Some(workload.join),
        law: Some(workload.law),
        stop: Some(StopSetting::Elements(elements)),
        ..Settings::default()
    };
    settings.resolve(substrate, workload.mesh).expect("fits")
}

/// CPU seconds, seconds gone by, and what grew.
fn grown(
    workload: &Workload,
    substrate: &Substrate,
    elements: u64,
    threads: usize,
) -> (f64, f64, Growth) {
    let recipe = recipe(workload, substrate, elements);
    let execution = Execution {
        threads,
        uses_all_threads: true,
        ..Execution::default()
    };
    let (before, started) = (cpu::seconds(), Instant::now());
    let growth = grow(substrate, &recipe, &execution, &mut ()).expect("grows");
    let (spent, time) = (cpu::seconds() - before, started.elapsed());
    (spent, time.as_secs_f64(), growth)
}

fn measure(workload: &Workload, elements: u64, threads: usize) {
    let (substrate, prepared) = surface(workload);
    let (spent, time, growth) = grown(workload, &substrate, elements, threads);
    let recipe = recipe(workload, &substrate, elements);
    let parameters = recipe.parameters(&substrate);
    let lookups = counting::lookups(&substrate, parameters, &growth.cluster);
    let counts = &growth.counts;
    let each = |n: u64| n as f64 / growth.cluster.len() as f64;
    let micros = |seconds: f64| seconds * 1e6 / growth.cluster.len() as f64;
    println!(
        "{:24} {:>9.2} {:>9.2} {:>9.2} {:>9.2} {:>9.1} {:>9.1} {:>9.1} {:>9.2} {:>9.3} {:>9.2}",
        workload.name,
        micros(spent),
        micros(prepared),
        micros(time),
        each(counts.walkers),
        each(counts.steps),
        each(counts.crossings),
        each(lookups),
        each(counts.contacts),
        each(growth.parallel.conflicts),
        micros(time - growth.parallel.seconds),
    );
}
