//! The engine against the literal reference: the same statistics of grown clusters, on flat and on curved meshes.
//!
//! Both draw their own random numbers, so only distributions can agree. Each case grows `seeds` clusters by each
//! program, measures every cluster, and compares the means by Welch. The number of seeds is chosen from the measured
//! scatter σ of one cluster's R_g, so that a shift of 3 % is [`ALARM`] standard errors of the difference: σ·√(2/n) with
//! n seeds a side. A case also fails if the error comes out larger than that, for it could not see what it is there to
//! see.
#![allow(clippy::print_stdout, clippy::print_stderr)] // measurements, for whoever asks to see them

#[path = "common/stats.rs"]
mod common_stats;
#[path = "common/finer.rs"]
mod finer;
mod reference;

use rayon::prelude::*;
use reference::shapes::{self, Shape};
use reference::{Params, Run, Search, Stop, grow, stats};
use thallus::cluster::{Cluster, Element, NO_PARENT};
use thallus::growth::{Boundary, Counts, GrowthModel, Join, Law, SeedPlace, Steps, WalkerModel};
use thallus::run::{Execution, MeshId, Recipe, StopRule};
use thallus::substrate::{Soup, Substrate};

/// A shift of R_g that must be seen.
const SHIFT: f64 = 0.03;

/// Standard errors beyond which two means differ. At 22 degrees of freedom equal laws do that with p = 2e-4; with eight
/// measures in eight cases a correct engine fails about once in a hundred changes of all its random numbers.
const ALARM: f64 = 4.5;

fn mesh((vertices, triangles): &Shape) -> Substrate {
    let soup = Soup {
        positions: vertices.clone(),
        triangles: triangles.clone(),
        notes: Vec::new(),
    };
    Substrate::from_soup(soup).expect("a mesh")
}

/// Grows with the crate's engine and gives its cluster as the reference does: positions in the mesh's own units.
fn engine_run(shape: &Shape, params: &Params, elements: usize) -> Run {
    let (substrate, recipe) = (mesh(shape), recipe(params, elements));
    let growth =
        thallus::run::grow(&substrate, &recipe, &Execution::default(), &mut ()).expect("grows");
    run_of(&substrate, &growth.cluster, &growth.counts)
}

fn recipe(params: &Params, elements: usize) -> Recipe {
    Recipe {
        version: String::new(),
        mesh: MeshId {
            file: String::new(),
            hash: String::new(),
        },
        mask: None,
        slope: None,
        mesh_up: None,
        radius: params.radius,
        curvature_radius: params.curvature_radius,
        bias: params.bias,
        gain: params.gain,
        min_stick: params.min_stick,
        seed: params.seed,
        at: vec![SeedPlace::Point(params.at)],
        launch: params.launch,
        kill: params.kill,
        law: Law::Thesis,
        join: if params.pack { Join::Pack } else { Join::Touch },
        steps: if params.large_steps {
            Steps::Large
        } else {
            Steps::Small
        },
        boundary: Boundary::Reflect,
        stop: StopRule::Elements(elements as u64),
    }
}

fn run_of(substrate: &Substrate, cluster: &Cluster, counts: &Counts) -> Run {
    let element = |e: &thallus::cluster::Element| reference::Element {
        position: substrate.units().to_file(e.position).to_array(),
        triangle: substrate.source_triangle(e.at.triangle) as usize,
        parent: (e.parent != NO_PARENT).then_some(e.parent as usize),
        probability: e.probability,
    };
    Run {
        elements: cluster.elements().iter().map(element).collect(),
        counters: reference::Counters {
            walkers: counts.walkers,
            killed: counts.killed,
            steps: counts.steps,
            contacts: counts.contacts,
            refusals: counts.refusals,
            unpacked: cluster.len() as u64 - 1 - counts.packed,
        },
    }
}

struct Case {
    name: &'static str,
    shape: Shape,
    params: Params,
    elements: usize,
    seeds: u64,
}

/// Everything measured on one cluster, with its name. Lengths in r.
fn measure(run: &Run, r: f64, scale: f64) -> Vec<(&'static str, f64)> {
    let positions = run.positions();
    let mass = stats::mass_radius(&positions, &[0.5 * scale, scale, 1.5 * scale]);
    let (joined, counters) = (positions.len() as f64 - 1.0, &run.counters);
    vec![
        (
            "radius of gyration",
            stats::radius_of_gyration(&positions) / r,
        ),
        ("effective radius", stats::effective_radius(&positions) / r),
        ("mass within half the reference's R_g", mass[0]),
        ("mass within the reference's R_g", mass[1]),
        ("mass within 1.5 times the reference's R_g", mass[2]),
        (
            "neighbours touched",
            stats::mean_contacts(&positions, r, 1e-6),
        ),
        ("contacts per element", counters.contacts as f64 / joined),
        (
            "walkers killed per element",
            counters.killed as f64 / joined,
        ),
    ]
}

/// The samples of every measure, one a cluster.
fn sample(
    case: &Case,
    scale: f64,
    run: impl Fn(&Params) -> Run + Sync,
) -> Vec<(&'static str, Vec<f64>)> {
    let clusters = (0..case.seeds).into_par_iter().map(|seed| {
        let params = Params {
            seed,
            ..case.params.clone()
        };
        measure(&run(&params), params.radius, scale)
    });
    let clusters: Vec<_> = clusters.collect();
    let column = |i: usize| (clusters[0][i].0, clusters.iter().map(|c| c[i].1).collect());
    (0..clusters[0].len()).map(column).collect()
}

fn check(case: &Case) {
    check_engine(case, |params| {
        engine_run(&case.shape, params, case.elements)
    });
}

/// Whether what an engine grows is what the reference grows on the case's shape.
fn check_engine(case: &Case, run: impl Fn(&Params) -> Run + Sync) {
    let (vertices, triangles) = &case.shape;
    let literal = |params: &Params| {
        grow(
            vertices,
            triangles,
            params,
            Stop::at_elements(case.elements),
        )
    };
    let scale = stats::radius_of_gyration(&literal(&case.params).positions());
    let reference = sample(case, scale, literal);
    let engine = sample(case, scale, run);
    for ((name, ours), (_, theirs)) in engine.iter().zip(&reference) {
        let (difference, error) = stats::compare(ours, theirs);
        println!("{}: {name} {difference:.4} ± {error:.4}", case.name);
        let report = format!("{}: {name} differs by {difference} ± {error}", case.name);
        if *name == "radius of gyration" {
            assert!(
                ALARM * error < SHIFT,
                "too few seeds to see a shift of {SHIFT}: {report}"
            );
        }
        assert!(difference.abs() <= ALARM * error + 1e-9, "{report}");
    }
}

/// Long steps end at the touch at most, as the engine's do. The thesis's may end r inside contact, which makes another
/// law where walkers are refused: see `Params::margin`, and the engine's `StepBounds`.
const MARGIN: f64 = 2.0;

fn case(name: &'static str, shape: Shape, params: Params, elements: usize, seeds: u64) -> Case {
    let params = Params {
        margin: MARGIN,
        ..params
    };
    Case {
        name,
        shape,
        params,
        elements,
        seeds,
    }
}

// σ below is the scatter of one cluster's R_g, measured with the reference.

/// σ = 2.9 % (32 seeds).
#[test]
fn plain_dla_on_two_triangles() {
    let params = Params {
        search: Search::Cells,
        ..Params::plain_dla(1.0, 0)
    };
    check(&case(
        "plain DLA, plane",
        shapes::plane(1e5),
        params,
        4000,
        48,
    ));
}

/// σ = 1.2 % (8 seeds).
#[test]
fn packed_lichen_on_two_triangles() {
    let params = Params {
        search: Search::Cells,
        ..Params::new(1.0, 0)
    };
    check(&case(
        "L = 10r, B = 0.5, plane",
        shapes::plane(1e5),
        params,
        3000,
        12,
    ));
}

/// The same law must not notice triangles or windings. 10,000 triangles of about 4 r.
#[test]
fn packed_lichen_on_an_uneven_triangulation_of_the_plane() {
    let params = Params {
        search: Search::Cells,
        ..Params::new(1.0, 0)
    };
    check(&case(
        "L = 10r, B = 0.5, uneven plane",
        shapes::uneven_plane(280.0, 70),
        params,
        1500,
        14,
    ));
}

/// Steps, arcs and packing over edges that bend, round the whole girth (63 diameters). σ = 3.0 % (20 seeds):
/// round the girth the lichen closes sooner or later.
#[test]
fn packed_lichen_on_a_cylinder() {
    let params = Params {
        at: [20.0, 0.0, 0.0],
        search: Search::Cells,
        ..Params::new(1.0, 0)
    };
    check(&case(
        "cylinder",
        shapes::cylinder(20.0, 1000.0, 20, 60),
        params,
        1500,
        48,
    ));
}

/// The thesis's rock: 4,608 triangles, lichen over about a third of it. σ = 0.8 % (8 seeds).
#[test]
fn packed_lichen_on_the_rock() {
    let params = Params {
        at: [0.0, 0.0, 1.0],
        search: Search::Cells,
        ..Params::new(0.01, 0)
    };
    check(&case(
        "L = 10r, B = 0.5, rock",
        shapes::rock(24),
        params,
        3000,
        10,
    ));
}

/// Grows with walkers that are from the first one on where those of a long run are. Also the edges crossed a step.
fn late_run(substrate: &Substrate, params: &Params, elements: usize) -> (Run, f64) {
    let parameters = recipe(params, elements).parameters(substrate);
    let at = SeedPlace::Point(params.at).locate(substrate, params.seed, 0);
    let mut cluster = Cluster::new(parameters.radius);
    let mut model = WalkerModel::new(substrate, parameters);
    cluster.push(Element::seed(substrate, at.expect("a place")));
    model.born(&cluster);
    model.resume(Counts {
        crossings: u64::MAX / 2,
        ..Counts::default()
    });
    while cluster.len() < elements {
        cluster.push(model.next(&cluster, &|| false).expect("there is room"));
        model.born(&cluster);
    }
    let counts = model.counts();
    let crossed = (counts.crossings - u64::MAX / 2) as f64 / counts.steps as f64;
    (run_of(substrate, &cluster, counts), crossed)
}

/// The same rock in 294,912 triangles: walkers are on a copy of it that hardly strays. How many more edges a step
/// crosses there than on the large triangles scatters by σ = 5 % from seed to seed about 11 %.
#[test]
fn packed_lichen_on_the_rock_in_small_triangles() {
    let params = Params {
        at: [0.0, 0.0, 1.0],
        search: Search::Cells,
        ..Params::new(0.01, 0)
    };
    let case = case(
        "L = 10r, B = 0.5, rock in small triangles",
        shapes::rock(24),
        params,
        3000,
        10,
    );
    let substrate = finer::finer(&mesh(&case.shape), 3);
    assert_eq!(substrate.triangles().len(), 294_912);
    check_engine(&case, |params| {
        late_run(&substrate, params, case.elements).0
    });
    let large = mesh(&case.shape);
    let crossed = |substrate: &Substrate, seed| {
        let params = Params {
            seed,
            ..case.params
        };
        late_run(substrate, &params, case.elements).1
    };
    let more = |seed| crossed(&substrate, seed) / crossed(&large, seed);
    let more = (0..10).map(more).sum::<f64>() / 10.0;
    println!("{more:.3} times as many edges crossed a step as on the large triangles");
    assert!(more < 1.2, "{more} times as many edges");
    let (run, _) = late_run(&substrate, &case.params, case.elements);
    let smallest = stats::smallest_distance(&run.positions()) / (2.0 * case.params.radius);
    assert!(smallest > 1.0 - 1e-6, "a pair at {smallest} diameters");
}

/// Elements about as large as triangles: every contact and every packing crosses edges, and from some size on the
/// launch sphere encloses the rock, so that walkers start by area.
#[test]
fn large_elements_cover_the_rock() {
    let params = Params {
        at: [0.0, 0.0, 1.0],
        bias: 0.9,
        ..Params::new(0.04, 0)
    };
    check(&case(
        "B = 0.9, large elements, rock",
        shapes::rock(24),
        params,
        1000,
        10,
    ));
}

/// The thin uneven end of the grid: L small, B high, where the touched element's place decides. σ = 3.5 % (48 seeds).
#[test]
fn touching_lichen_on_the_rock() {
    let params = Params {
        at: [0.0, 0.0, 1.0],
        bias: 0.9,
        pack: false,
        curvature_radius: 0.05,
        search: Search::Cells,
        ..Params::new(0.01, 0)
    };
    check(&case(
        "L = 5r, B = 0.9, touch, rock",
        shapes::rock(24),
        params,
        1000,
        80,
    ));
}

/// Small steps all the way.
#[test]
fn small_steps_on_the_plane() {
    let params = Params {
        large_steps: false,
        kill: 3.0,
        ..Params::new(1.0, 0)
    };
    check(&case(
        "small steps, plane",
        shapes::plane(1e5),
        params,
        200,
        24,
    ));
}

#[test]
fn engine_keeps_off_what_it_packed_against() {
    let params = Params {
        at: [0.0, 0.0, 1.0],
        ..Params::new(0.01, 1)
    };
    let run = engine_run(&shapes::rock(24), &params, 3000);
    let smallest = stats::smallest_distance(&run.positions()) / (2.0 * params.radius);
    assert!(smallest > 1.0 - 1e-6, "a pair at {smallest} diameters");
}
