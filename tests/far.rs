//! Far jumps over a coarser copy of the surface against the same over the surface itself: where walkers come to a
//! lichen that does not grow.
//!
//! Walkers of one cluster hit its elements by one law. Hits are counted by the element's direction from the centroid
//! and by whether it is among the inner or the outer half of the tips that are hit at all; the two tables are compared
//! by the chi-square test of homogeneity at a false alarm in 10 000. With [`WALKERS`] a side, a law that favoured one
//! side of the lichen by a tenth would be told in 95 runs of 100: see `shares_that_differ_by_a_tenth_are_seen`.
#![allow(clippy::print_stderr)] // measurements, for whoever asks to see them

#[path = "common/chi_square.rs"]
mod chi_square;
mod common;
#[path = "common/finer.rs"]
mod finer;
#[path = "common/shapes.rs"]
mod shapes;

use std::f64::consts::TAU;
use std::path::Path;

use chi_square::{apart, homogeneity};
use glam::DVec3;
use rayon::prelude::*;
use thallus::cluster::Cluster;
use thallus::growth::{Counts, GrowthModel, Parameters, SeedPlace, Steps, WalkerModel};
use thallus::run::{Execution, Recipe, StopRule, grow};
use thallus::substrate::Substrate;

/// On each side of a comparison.
const WALKERS: usize = 30_000;

/// Times so many for a law that is off by 1.2 %, root mean square, as it once was: told in 96 runs of 100.
const MANY: u64 = 30;

/// Directions that hits are counted by.
const SECTORS: usize = 16;

/// Less than the share of a direction's hits that jumps of 60 radii at most over the mesh move on a large lichen, 2.46
/// %. With copies it is 1.81 %, with such as land too near 2.78 %: each is three standard deviations (0.15 %) from
/// this.
const LEAST_BY_JUMPS: f64 = 0.0228;

/// The share of the edges of the mesh that walkers cross where there are copies, at most.
const MOST_CROSSED: f64 = 0.85;

/// Edges crossed, a triangle, after which copies are made: of rough surfaces, and of such as have one that hardly
/// strays.
const ROUGH: u64 = 4;
const SMOOTH: u64 = 1;

/// Hits of walkers on a cluster, by element; the edges that a walker crosses, and its steps. The number is of those
/// that were sent before.
fn hits(
    substrate: &Substrate,
    cluster: &Cluster,
    recipe: &Recipe,
    (steps, number): (Steps, u64),
) -> (Vec<u64>, [f64; 2]) {
    let parameters = Parameters {
        bias: 1.0,
        gain: 0.0,
        steps,
        seed: 7 + steps as u64 + 1000 * number,
        ..recipe.parameters(substrate)
    };
    let mut model = WalkerModel::new(substrate, parameters);
    let mut so_far = Cluster::new(cluster.radius());
    for element in cluster.elements() {
        so_far.push(*element);
        model.born(&so_far);
    }
    // As after a long run, when the copy has come to pay.
    model.resume(Counts {
        crossings: u64::MAX / 2,
        ..Counts::default()
    });
    let mut hits = vec![0; cluster.len()];
    for _ in 0..WALKERS {
        let element = model.next(&so_far, &|| false).expect("there is room");
        hits[element.parent as usize] += 1;
    }
    let counts = model.counts();
    let each = [counts.crossings - u64::MAX / 2, counts.steps].map(|n| n as f64 / WALKERS as f64);
    (hits, each)
}

/// Hits by direction and by inner and outer half.
fn table(cluster: &Cluster, hits: &[u64], all: &[u64]) -> Vec<u64> {
    let elements = cluster.elements();
    let n = elements.len() as f64;
    let centre = elements.iter().map(|e| e.position).sum::<DVec3>() / n;
    let (x, y) = axes(cluster, centre);
    let away = |i: usize| elements[i].position.distance(centre);
    let mut by_distance: Vec<usize> = (0..elements.len()).collect();
    by_distance.sort_by(|&a, &b| away(a).total_cmp(&away(b)));
    let total: u64 = all.iter().sum();
    let (mut seen, mut table) = (0, vec![0; 2 * SECTORS]);
    for i in by_distance {
        let d = elements[i].position - centre;
        let angle = y.dot(d).atan2(x.dot(d)).rem_euclid(TAU) / TAU;
        let sector = ((angle * SECTORS as f64) as usize).min(SECTORS - 1);
        let outer = usize::from(2 * seen > total);
        table[2 * sector + outer] += hits[i];
        seen += all[i];
    }
    table
}

/// Two directions along which the cluster spreads: of the farthest element, and across.
fn axes(cluster: &Cluster, centre: DVec3) -> (DVec3, DVec3) {
    let offsets = || cluster.elements().iter().map(|e| e.position - centre);
    let longest = |all: &mut dyn Iterator<Item = DVec3>| {
        all.max_by(|a, b| a.length().total_cmp(&b.length()))
            .expect("elements")
    };
    let x = longest(&mut offsets()).normalize();
    let y = longest(&mut offsets().map(|d| d - x * d.dot(x))).normalize();
    (x, y)
}

/// A lichen of so wide and so many elements, grown without the copy, and so many times [`WALKERS`] with and without:
/// the share of the edges that they cross with it.
fn compare(name: &str, substrate: &Substrate, elements: (f64, u64), times: u64) -> f64 {
    let (cluster, hits, crossed) = sent(name, substrate, elements, times);
    assert_alike(name, &cluster, hits.each_ref().map(Vec::as_slice));
    crossed
}

/// The lichen of [`compare`], the hits with copies and without, and the share of the edges.
fn sent(
    name: &str,
    substrate: &Substrate,
    (radius, elements): (f64, u64),
    times: u64,
) -> (Cluster, [Vec<u64>; 2], f64) {
    let recipe = Recipe {
        steps: Steps::Exact,
        ..common::recipe(radius, elements)
    };
    let grown = grow(substrate, &recipe, &Execution::default(), &mut ()).expect("grows");
    assert_eq!(grown.cluster.len() as u64, elements, "{:?}", grown.counts);
    let some = |steps, number| hits(substrate, &grown.cluster, &recipe, (steps, number));
    let all = |steps| {
        let each = (0..times).into_par_iter().map(|number| some(steps, number));
        each.reduce_with(add).expect("walkers")
    };
    let [(large, [over_copies, _]), (exact, [over_mesh, _])] =
        [Steps::Large, Steps::Exact].map(all);
    assert!(over_copies < MOST_CROSSED * over_mesh, "{name}: no copy");
    eprintln!("{name}: {:.2} of the edges", over_copies / over_mesh);
    (grown.cluster, [large, exact], over_copies / over_mesh)
}

/// What two of [`hits`] come to.
fn add((a, of_a): (Vec<u64>, [f64; 2]), (b, of_b): (Vec<u64>, [f64; 2])) -> (Vec<u64>, [f64; 2]) {
    let hits = a.iter().zip(b).map(|(a, b)| a + b).collect();
    (hits, [of_a[0] + of_b[0], of_a[1] + of_b[1]])
}

/// Two [tables](table) of hits.
fn tables(cluster: &Cluster, [one, other]: [&[u64]; 2]) -> [Vec<u64>; 2] {
    let all: Vec<u64> = one.iter().zip(other).map(|(a, b)| a + b).collect();
    [one, other].map(|hits| table(cluster, hits, &all))
}

/// That hits are shared out alike.
fn assert_alike(name: &str, cluster: &Cluster, hits: [&[u64]; 2]) {
    let [a, b] = tables(cluster, hits);
    let p = homogeneity(&a, &b);
    eprintln!("{name}: p = {p:.3}, {}", difference(&a, &b));
    assert!(p > 1e-4, "{name}: {a:?} {b:?}");
}

/// By how much shares of as many hits each differ, root mean square, beyond what chance makes of equal ones; and the
/// most that this may be.
fn difference(a: &[u64], b: &[u64]) -> String {
    let (statistic, free) = apart(a, b);
    let [share, most] = [0.0, 2.0].map(|sigmas| 100.0 * differing(a, b, sigmas));
    format!(
        "chi-square {statistic:.1} of {free}, {share:.2} % of a direction's hits, {most:.2} % at most (two sigma)"
    )
}

/// That difference as a share, and so many standard deviations more.
fn differing(a: &[u64], b: &[u64], sigmas: f64) -> f64 {
    let (statistic, free) = apart(a, b);
    let each = a.iter().sum::<u64>() as f64;
    let beyond = statistic - free + sigmas * (2.0 * free).sqrt();
    (2.0 * beyond.max(0.0) / each).sqrt()
}

#[test]
fn on_a_smooth_rock() {
    let rock = common::rock(90);
    compare("rock", &rock, (3.0 * rock.auto_radius(), 1000), MANY);
}

/// With bumps of a few radii, on which walkers that land too near to the lichen come to other places.
#[test]
fn on_a_boulder() {
    let boulder = Substrate::load(Path::new("meshes/boulder.glb")).expect("a mesh");
    compare("boulder", &boulder, (boulder.auto_radius(), 4000), MANY);
}

/// That walkers walk to from far away, some by a copy of the copy. There it shows how long jumps are, also over the
/// mesh:
/// 2.5 % of a direction's hits are elsewhere with jumps of 60 radii at most (`docs/study.md`). With copies fewer are to be.
#[test]
fn on_a_large_lichen() {
    let boulder = Substrate::load(Path::new("meshes/boulder.glb")).expect("a mesh");
    let lichen = (boulder.auto_radius(), 80_000);
    let (cluster, hits, _) = sent("large lichen", &boulder, lichen, MANY);
    let [a, b] = tables(&cluster, hits.each_ref().map(Vec::as_slice));
    eprintln!("large lichen: {}", difference(&a, &b));
    let differs = differing(&a, &b, 0.0);
    assert!(differs < LEAST_BY_JUMPS, "{differs}");
}

/// So small that there is a coarser copy of the copy.
#[test]
fn for_small_elements() {
    let rock = common::rock(90);
    compare("small elements", &rock, (rock.auto_radius(), 1000), MANY);
}

/// So that walkers are on a copy that hardly strays, up to the lichen.
#[test]
fn on_flat_faces_in_small_triangles() {
    let rock = finer::finer(&common::rock(12), 4);
    let crossed = compare("flat faces", &rock, (3.0 * rock.auto_radius(), 1000), 1);
    assert!(
        crossed < 0.1,
        "{crossed}: copies for far steps alone leave more"
    );
}

/// As scans are: bumps of all sizes down to a triangle's, noise from corner to corner, and so large that copies
/// are simplified in parts.
fn rough_field() -> Substrate {
    let noise = |i: usize, j: usize| {
        let bits = (i as u64 * 7919 + j as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        (bits >> 40) as f64 / f64::from(1u32 << 24) - 0.5
    };
    let at = |i: usize, j: usize| {
        let (x, y) = (i as f64, j as f64);
        let bumps = 6.0 * (0.045 * x).sin() * (0.06 * y).cos()
            + 1.5 * (0.21 * x + 0.1 * y).sin()
            + 0.5 * (0.77 * y - 0.3 * x).cos();
        DVec3::new(x, y, bumps + 0.6 * noise(i, j))
    };
    let (positions, triangles) = shapes::patch(280, 280, at, None);
    common::substrate(positions, triangles)
}

#[test]
fn on_a_rough_field() {
    let field = rough_field();
    compare(
        "rough field",
        &field,
        (3.0 * field.auto_radius(), 500),
        MANY,
    );
}

/// With elements nearly as wide as an edge.
#[test]
fn for_wide_elements_on_a_rough_field() {
    let field = rough_field();
    compare(
        "wide elements",
        &field,
        (5.0 * field.auto_radius(), 300),
        MANY,
    );
}

/// Two that others made: a rover's view of rocks, and the porous shell of a CT scan.
#[test]
fn on_scans() {
    let Some(folder) = common::shared_folder() else {
        return;
    };
    for (file, radii) in [
        ("large/dingo_gap/dingo_gap_leaf_tiles.ply", 1.0),
        ("large/qim3d_ct/ct_shell.ply", 2.0),
    ] {
        let scan = Substrate::load(&folder.join(file)).expect("a mesh");
        compare(file, &scan, (radii * scan.auto_radius(), 500), 1);
    }
}

/// When the copy is made depends on what was crossed up to the last birth, and on nothing else.
#[test]
fn threads_and_interruptions_change_nothing() {
    let rock = common::rock(60);
    interrupt(&rock, ROUGH, 3.0 * rock.auto_radius(), [150, 4000, 5000]);
}

/// As there, with a copy that hardly strays.
#[test]
fn nor_do_they_on_a_copy_that_hardly_strays() {
    let rock = finer::finer(&common::rock(12), 3);
    interrupt(&rock, SMOOTH, 3.0 * rock.auto_radius(), [20, 4000, 5000]);
}

/// Runs that end before the copy is made, after that, and later are parts of one run.
fn interrupt(mesh: &Substrate, crossings: u64, radius: f64, [before, after, all]: [u64; 3]) {
    let recipe = common::recipe(radius, all);
    let run = |elements: u64, threads: usize| {
        let recipe = Recipe {
            stop: StopRule::Elements(elements),
            ..recipe.clone()
        };
        let execution = Execution {
            threads,
            uses_all_threads: true,
            ..Execution::default()
        };
        grow(mesh, &recipe, &execution, &mut ()).expect("grows")
    };
    let whole = run(all, 1);
    let sticking = whole.counts.contacts - whole.counts.refusals;
    assert_eq!(sticking, all - 1, "each contact is a refusal or a birth");
    for threads in [2, 5] {
        let other = run(all, threads);
        assert_eq!(other.cluster.elements(), whole.cluster.elements());
        assert_eq!(other.counts, whole.counts);
    }
    for (elements, is_after) in [(before, false), (after, true)] {
        let part = run(elements, 1);
        let made_after = crossings * mesh.triangles().len() as u64;
        assert_eq!(part.counts.crossings > made_after, is_after);
        let mut model = WalkerModel::new(mesh, recipe.parameters(mesh));
        let mut cluster = Cluster::new(part.cluster.radius());
        for element in part.cluster.elements() {
            cluster.push(*element);
            model.born(&cluster);
        }
        model.resume(part.counts);
        while (cluster.len() as u64) < all {
            let element = model.next(&cluster, &|| false).expect("there is room");
            cluster.push(element);
            model.born(&cluster);
        }
        assert_eq!(cluster.elements(), whole.cluster.elements());
    }
}

#[test]
fn shares_that_differ_by_a_tenth_are_seen() {
    let cells = 2 * SECTORS;
    let mut random = shapes::stream(77);
    let mut draw = |favour: f64| {
        let mut table = vec![0; cells];
        let mut drawn = 0;
        while drawn < WALKERS {
            let cell = (random.uniform() * cells as f64) as usize;
            let share = 1.0 + favour * (TAU * cell as f64 / cells as f64).cos();
            if random.uniform() * (1.0 + favour) < share {
                table[cell] += 1;
                drawn += 1;
            }
        }
        table
    };
    let seen = (0..100)
        .filter(|_| homogeneity(&draw(0.1), &draw(0.0)) < 1e-4)
        .count();
    assert!(seen >= 95, "{seen} of 100");
}

/// A plate of unit sides, this thick, each face a grid of so many squares along its sides, closed at the rim.
/// Places inside are raised by up to `rough` from there.
fn plate(squares: usize, thickness: f64, rough: f64) -> Substrate {
    let at = |i: usize| i as f64 / squares as f64;
    let raised = |i: usize, j: usize| match [i, j].iter().any(|&k| k == 0 || k == squares) {
        true => 0.0,
        false => rough * ((i * 7919 + j * 104_729) as f64).sin(),
    };
    let (mut positions, mut triangles) = (Vec::new(), Vec::new());
    let mut add = |rows: usize, place: &dyn Fn(usize, usize) -> DVec3| {
        let (more, faces) = shapes::patch(squares, rows, place, None);
        let first = positions.len() as u32;
        positions.extend(more);
        triangles.extend(faces.into_iter().map(|t| t.map(|corner| first + corner)));
    };
    add(squares, &|i, j| DVec3::new(at(j), raised(i, j), at(i)));
    add(squares, &|i, j| {
        DVec3::new(at(i), raised(i, j) - thickness, at(j))
    });
    for side in 0..4 {
        add(1, &|i, j| {
            let (along, back, y) = (at(i), at(squares - i), -thickness * j as f64);
            match side {
                0 => DVec3::new(along, y, 0.0),
                1 => DVec3::new(1.0, y, along),
                2 => DVec3::new(back, y, 1.0),
                _ => DVec3::new(0.0, y, back),
            }
        });
    }
    common::substrate(positions, triangles)
}

/// Below lichen on the other face of a thin plate steps are as long as its own face is free. That says nothing of
/// space, so no such step may lead to a copy of the surface, where contacts are not asked for: in tests the
/// engine asserts that nothing is touched there.
#[test]
fn walkers_below_lichen_of_the_other_face_stay_on_the_mesh() {
    grow_on_plate(ROUGH, 0.2);
}

/// A smooth one has a copy where they are asked for.
#[test]
fn or_on_a_copy_that_hardly_strays() {
    grow_on_plate(SMOOTH, 0.0);
}

/// With faces that are so rough, in radii. By the index alone a walker takes 2,400 steps, and 750 otherwise.
fn grow_on_plate(crossings: u64, rough: f64) {
    let diagonal = 2f64.sqrt();
    let radius = diagonal / 600.0;
    let plate = plate(130, 2.0 * radius, rough * radius);
    assert!(plate.triangles().len() > 60_000);
    let mut steps = 0.0;
    for seed in 0..6 {
        let recipe = Recipe {
            at: vec![SeedPlace::Random],
            bias: 0.3 + 0.1 * seed as f64,
            seed,
            ..common::recipe(radius, 800)
        };
        let growth = grow(&plate, &recipe, &Execution::default(), &mut ()).expect("grows");
        assert_eq!(growth.cluster.len(), 800);
        let made_after = crossings * plate.triangles().len() as u64;
        assert!(growth.counts.crossings > made_after, "no copies");
        steps += growth.counts.steps as f64 / growth.counts.walkers as f64 / 6.0;
    }
    assert!(steps < 1500.0, "{steps} steps a walker: none is long");
}

/// Below lichen of the other face of a plate that is some radii thick walkers are near lichen that they cannot touch.
/// By the index alone a walker takes 570 steps there, and 270 by what is on its own sheet. Small ones are looked at
/// wherever they end.
#[test]
fn walkers_below_a_plate_come_to_its_lichen_as_small_steps_do() {
    let radius = 1.0 / 120.0;
    let plate = plate(1, 4.5 * radius, 0.0);
    let recipe = Recipe {
        at: vec![SeedPlace::Point([0.5, 0.0, 0.5])],
        ..common::recipe(radius, 1000)
    };
    let grown = grow(&plate, &recipe, &Execution::default(), &mut ()).expect("grows");
    let [(large, [_, steps]), (small, _)] =
        [Steps::Large, Steps::Small].map(|steps| hits(&plate, &grown.cluster, &recipe, (steps, 0)));
    assert!(steps < 400.0, "{steps} steps a walker");
    assert_alike("plate", &grown.cluster, [&large, &small]);
}
