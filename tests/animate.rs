//! Growing lichens: frames that swell without jumps, and end as what does not move.

mod common;
#[path = "common/shapes.rs"]
mod shapes;

use std::collections::BTreeMap;

use common::{plane, recipe, rock, slab, sphere};
use glam::DVec3;
use thallus::cluster::{Cluster, Ease, Presence};
use thallus::export::TriMesh;
use thallus::run::{Execution, grow};
use thallus::skin::{PALETTE, Paint, Shape, SkinFrames, faults, skin};
use thallus::substrate::Substrate;

fn grown(substrate: &Substrate, radius: f64, elements: u64) -> Cluster {
    let recipe = recipe(radius, elements);
    let growth = grow(substrate, &recipe, &Execution::default(), &mut ()).expect("grows");
    growth.cluster
}

fn first(cluster: &Cluster, count: usize) -> Cluster {
    let mut first = Cluster::new(cluster.radius());
    first.extend(cluster.elements()[..count].iter().copied());
    first
}

fn frames(
    substrate: &Substrate,
    cluster: &Cluster,
    paint: &Paint,
    moments: Vec<Presence>,
) -> Vec<TriMesh> {
    let shape = Shape::default();
    let frames = SkinFrames::new(substrate, cluster, &shape, paint, moments);
    let frames: Vec<TriMesh> = frames.expect("frames").collect();
    for mesh in &frames {
        mesh.check().expect("sound");
        let found = faults(mesh.positions.len(), &mesh.triangles);
        assert!(found.is_empty(), "{found:?}");
    }
    frames
}

#[test]
fn moments_that_are_none_are_refused() {
    let substrate = plane(1.0);
    let cluster = grown(&substrate, 0.02, 30);
    let (shape, paint) = (Shape::default(), Paint::default());
    let refused = |moments: &[(f64, f64)]| {
        let moment = |&(time, window)| Presence {
            time,
            window,
            ease: Ease::Linear,
        };
        let moments = moments.iter().map(moment).collect();
        let frames = SkinFrames::new(&substrate, &cluster, &shape, &paint, moments);
        frames.err().map(|error| error.to_string())
    };
    assert_eq!(refused(&[(-3.0, 2.0), (15.0, 0.0), (5.0, 2.0)]), None);
    for wrong in [
        (20.0, -5.0),
        (20.0, f64::NAN),
        (20.0, f64::INFINITY),
        (f64::NAN, 0.0),
    ] {
        let said = refused(&[(10.0, 0.0), wrong]).expect("an error");
        assert!(said.starts_with("moment 1 is at"), "{said}");
    }
}

/// Everything that files have of a vertex, but for the distance from the rim, to the bit.
fn bits(mesh: &TriMesh, vertex: u32) -> Vec<u64> {
    let v = vertex as usize;
    let mut bits: Vec<u64> = mesh.positions[v].map(f64::to_bits).to_vec();
    bits.extend(mesh.normals[v].map(|x| u64::from(x.to_bits())));
    bits.extend(mesh.colors[v].map(u64::from));
    let told = mesh.attributes.iter().filter(|a| !a.is_length);
    bits.extend(told.map(|a| u64::from(a.values[v].to_bits())));
    bits
}

/// Triangles by what their corners are, each begun at its least corner, and how often they come.
fn told(mesh: &TriMesh) -> BTreeMap<[Vec<u64>; 3], usize> {
    let mut told = BTreeMap::new();
    for corners in &mesh.triangles {
        let [a, b, c] = corners.map(|v| bits(mesh, v));
        let turned = [
            [a.clone(), b.clone(), c.clone()],
            [b.clone(), c.clone(), a.clone()],
            [c, a, b],
        ];
        let least = turned.into_iter().min().expect("three");
        *told.entry(least).or_default() += 1;
    }
    told
}

fn volume(mesh: &TriMesh) -> f64 {
    let corner = |v: u32| DVec3::from(mesh.positions[v as usize]);
    let volumes = mesh.triangles.iter().map(|t| {
        let [a, b, c] = t.map(corner);
        a.dot(b.cross(c)) / 6.0
    });
    volumes.sum()
}

#[test]
fn without_a_window_frames_are_the_skins_of_the_first_elements() {
    // Of long triangles, windings at random.
    let pole = shapes::Prism {
        sides: 24,
        height: 12.0,
    };
    let surfaces = [
        ("plane", plane(2.0), 0.01),
        ("board that is nearly full", plane(0.6), 0.01),
        ("sphere", sphere(16), 0.012),
        ("rock", rock(24), 0.01),
        ("a pole", pole.mesh(1), 0.02),
        ("slab", slab(16, 1.0, 0.004), 0.007),
        ("fine rock", rock(120), 0.02),
    ];
    let counts = [1, 2, 40, 41, 333, 700];
    for (name, surface, radius) in &surfaces {
        let cluster = grown(surface, *radius, 700);
        for map in [0, 2] {
            let paint = Paint {
                age_darken: 0.4,
                ..Paint::of(&PALETTE[map])
            };
            let moments = counts.map(Presence::first).to_vec();
            let frames = frames(surface, &cluster, &paint, moments);
            assert_eq!(frames.len(), counts.len());
            for (count, mesh) in counts.into_iter().zip(&frames) {
                let alone = skin(surface, &first(&cluster, count), &Shape::default(), &paint);
                let alone = alone.expect("a skin");
                assert_eq!(
                    mesh.positions.len(),
                    alone.positions.len(),
                    "{name}: {count}"
                );
                assert!(told(mesh) == told(&alone), "{name}: {count} elements");
            }
        }
    }
}

/// On a mesh of a few radii nothing is far from the outline, and yet there may be none.
#[test]
fn the_dark_margin_of_a_frame_is_that_of_its_skin_on_a_tiny_mesh_too() {
    let surface = plane(1.0);
    let cluster = grown(&surface, 0.19, 4);
    let dark = PALETTE.iter().filter(|map| map.prothallus.is_some());
    for paint in dark.map(Paint::of) {
        let moments = (1..=cluster.len()).map(Presence::first).collect();
        for (count, mesh) in (1..).zip(frames(&surface, &cluster, &paint, moments)) {
            let alone = skin(&surface, &first(&cluster, count), &Shape::default(), &paint);
            assert!(
                told(&mesh) == told(&alone.expect("a skin")),
                "{count} elements"
            );
        }
    }
}

/// A frame says the same whatever came before it: steps of all lengths, none, and back.
#[test]
fn frames_do_not_depend_on_the_frames_before() {
    let surface = rock(24);
    let cluster = grown(&surface, 0.01, 1200);
    let marked = Paint::of(&PALETTE[2]);
    let darkened = Paint {
        age_darken: 0.4,
        ..Paint::default()
    };
    for (window, ease, paint) in [
        (90.0, Ease::Smooth, &marked),
        (0.0, Ease::Linear, &darkened),
        (3.5, Ease::Linear, &marked),
        (700.0, Ease::Smoother, &darkened),
    ] {
        let at = |time: f64| Presence { time, window, ease };
        let even = (0..20).map(|k| at(60.5 * f64::from(k) - 40.0));
        let uneven = [1100.0, 1101.0, 1101.0, 1101.3, 300.0, 301.0, 299.25, 1200.0];
        let moments: Vec<Presence> = even.chain(uneven.map(at)).collect();
        let all = frames(&surface, &cluster, paint, moments.clone());
        for k in [2, 9, 18, 21, 22, 23, 24, 26, 27] {
            let alone = frames(&surface, &cluster, paint, vec![moments[k]]);
            assert!(alone[0] == all[k], "{:?}", moments[k]);
        }
    }
}

#[test]
fn threads_change_no_frame() {
    let surface = rock(24);
    let cluster = grown(&surface, 0.01, 1200);
    let paint = Paint::of(&PALETTE[2]);
    let at = |k: u32| Presence {
        time: 40.0 * f64::from(k),
        window: 90.0,
        ease: Ease::Linear,
    };
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        let moments = (0..30).map(at).collect();
        pool.expect("threads")
            .install(|| frames(&surface, &cluster, &paint, moments))
    };
    let one = with(1);
    assert!([2, 3].into_iter().all(|threads| with(threads) == one));
}

/// From one moment to the next, dt elements later, influences grow by dt elements in all, so the
/// volume grows by no more than a few elements have of it: a bound that goes to 0 with dt.
#[test]
fn volume_grows_without_jumps() {
    const STEP: f64 = 0.125;
    for (surface, radius) in [(plane(2.0), 0.02), (sphere(24), 0.02)] {
        let cluster = grown(&surface, radius, 500);
        let whole = skin(&surface, &cluster, &Shape::default(), &Paint::default());
        let each = volume(&whole.expect("a skin")) / 500.0;
        for ease in [Ease::Linear, Ease::Smooth, Ease::Smoother] {
            let steps = |window: f64| -> Vec<f64> {
                let at = |k: i32| Presence {
                    time: 300.0 + STEP * f64::from(k),
                    window,
                    ease,
                };
                let moments = (0..96).map(at).collect();
                let frames = frames(&surface, &cluster, &Paint::default(), moments);
                let volumes: Vec<f64> = frames.iter().map(volume).collect();
                volumes
                    .windows(2)
                    .map(|pair| (pair[1] - pair[0]) / each)
                    .collect()
            };
            let range = |steps: Vec<f64>| {
                let empty = [f64::MAX, f64::MIN];
                let wider = |[l, h]: [f64; 2], &x: &f64| [l.min(x), h.max(x)];
                steps.iter().fold(empty, wider)
            };
            let [least, most] = range(steps(60.0));
            let [_, jump] = range(steps(0.0));
            assert!(
                least > -0.02 * STEP && most < 5.0 * STEP,
                "{ease:?}: {least} {most}"
            );
            assert!(jump > 0.6, "a hard cut jumps: {jump}");
        }
    }
}
