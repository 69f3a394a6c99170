//! Loading, tracing, walking and growing.
//!
//!     cargo bench
//!
//! `load` reports the time per triangle to prepare a height field of a million; reading files too is
//! in `tests/load_cost.rs`.

use std::hint::black_box;

use criterion::{BatchSize, Criterion, Throughput, criterion_group, criterion_main};
use thallus::growth::{SeedPlace, random_step};
use thallus::rng::{Purpose, Stream};
use thallus::run::{Execution, Settings, StopSetting, grow};
use thallus::substrate::{Soup, Substrate, SurfacePoint};
use thallus::walk::{Stand, trace};

/// A wavy height field of 2·n² triangles.
fn field(n: u32) -> Soup {
    let height = |x: f64, z: f64| 3.0 * (x / 9.0).sin() * (z / 7.0).cos();
    let at = |i: u32| [f64::from(i % (n + 1)), f64::from(i / (n + 1))];
    let positions = (0..(n + 1) * (n + 1))
        .map(at)
        .map(|[x, z]| [x, height(x, z), z]);
    let cells = (0..n).flat_map(|j| (0..n).map(move |i| j * (n + 1) + i));
    let halves = cells.flat_map(|a| [[a, a + n + 1, a + 1], [a + 1, a + n + 1, a + n + 2]]);
    Soup {
        positions: positions.collect(),
        triangles: halves.collect(),
        notes: Vec::new(),
    }
}

fn load(c: &mut Criterion) {
    let soup = field(707);
    let mut group = c.benchmark_group("load");
    group.sample_size(10);
    group.throughput(Throughput::Elements(soup.triangles.len() as u64));
    let prepare = |soup| Substrate::from_soup(soup).expect("a mesh");
    group.bench_function("prepare a million triangles", |b| {
        b.iter_batched(|| soup.clone(), prepare, BatchSize::LargeInput);
    });
    group.finish();
}

fn traces(c: &mut Criterion) {
    let substrate = Substrate::from_soup(field(200)).expect("a mesh");
    let mut stream = Stream::new(1, Purpose::Walker, 0);
    let mut at = SurfacePoint::centroid(0);
    for length in [0.001, 0.1] {
        c.bench_function(&format!("trace {length} of the diagonal"), |b| {
            b.iter(|| {
                at = trace(&substrate, &at, stream.in_unit_disc() * length, false).point;
                black_box(at)
            });
        });
    }
}

fn walks(c: &mut Criterion) {
    let substrate = Substrate::from_soup(field(200)).expect("a mesh");
    let mut stream = Stream::new(1, Purpose::Walker, 0);
    let mut here = Stand::new(&substrate, &SurfacePoint::centroid(0));
    let mut group = c.benchmark_group("walk");
    group.throughput(Throughput::Elements(1000));
    // A triangle's edge is about 1/283 of the diagonal, which is 1 to 2.
    for (name, radius) in [("a twentieth of an edge", 2e-4), ("five edges", 2e-2)] {
        group.bench_function(format!("1,000 steps of {name}"), |b| {
            b.iter(|| {
                for _ in 0..1000 {
                    let step = random_step(&mut stream, radius, radius);
                    here = here.step(&substrate, step, false).to;
                }
                black_box(here)
            });
        });
    }
    group.finish();
}

fn growth(c: &mut Criterion) {
    let plane = Soup {
        positions: vec![
            [-1.0, 0.0, -1.0],
            [1.0, 0.0, -1.0],
            [1.0, 0.0, 1.0],
            [-1.0, 0.0, 1.0],
        ],
        triangles: vec![[0, 2, 1], [0, 3, 2]],
        notes: Vec::new(),
    };
    let mut group = c.benchmark_group("grow 5000");
    group.sample_size(10);
    group.throughput(Throughput::Elements(5000));
    for (name, soup) in [("two triangles", plane), ("80,000 triangles", field(200))] {
        let substrate = Substrate::from_soup(soup).expect("a mesh");
        let settings = Settings {
            at: Some(vec![SeedPlace::Center]),
            stop: Some(StopSetting::Elements(5000)),
            ..Settings::default()
        };
        let recipe = settings.resolve(&substrate, name).expect("a recipe");
        let run = || grow(&substrate, &recipe, &Execution::default(), &mut ());
        group.bench_function(name, |b| b.iter(|| run().expect("grows")));
    }
    group.finish();
}

criterion_group!(benches, load, traces, walks, growth);
criterion_main!(benches);
