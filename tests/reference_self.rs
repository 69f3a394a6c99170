//! The literal reference against what is known: geometry, samplers, conservation laws, plain DLA.
//!
//! What the engine is held to must itself be held to something.

#[path = "common/stats.rs"]
mod common_stats;
mod reference;

use common_stats::{chi_square, threshold};
use glam::{DVec2, DVec3};
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};
use reference::cluster::Cluster;
use reference::join::{first_touch, pack};
use reference::launch::{Arc, cut, on_arcs, on_free_area};
use reference::mesh::{Mesh, Place};
use reference::nearby::nearby_sets;
use reference::shapes::{self, Shape};
use reference::stats;
use reference::walk::{end, trace};
use reference::{Params, Run, Search, Stop, grow};
use std::f64::consts::{PI, TAU};

fn run(shape: &Shape, params: &Params, elements: usize) -> Run {
    grow(&shape.0, &shape.1, params, Stop::at_elements(elements))
}

fn cells(params: Params) -> Params {
    Params {
        search: Search::Cells,
        ..params
    }
}

fn mesh(shape: &Shape) -> Mesh {
    Mesh::new(&shape.0, &shape.1)
}

/// A place uniform over triangles, not over area: enough to start traces from.
fn random_place(mesh: &Mesh, rng: &mut ChaCha8Rng) -> Place {
    let triangle = rng.random_range(0..mesh.triangles.len());
    let [a, b, c] = mesh.triangles[triangle].flat;
    let (u, v): (f64, f64) = (rng.random(), rng.random());
    let (u, v) = if u + v > 1.0 {
        (1.0 - u, 1.0 - v)
    } else {
        (u, v)
    };
    let at = a + (b - a) * u + (c - a) * v;
    Place { triangle, at }
}

fn random_direction(rng: &mut ChaCha8Rng) -> DVec2 {
    DVec2::from_angle(rng.random::<f64>() * TAU)
}

// Shapes and walking

#[test]
fn the_rock_is_the_size_of_the_thesis_and_closed() {
    let shape = shapes::rock(24);
    assert_eq!((shape.0.len(), shape.1.len()), (2306, 4608));
    let mesh = mesh(&shape);
    let open = mesh
        .triangles
        .iter()
        .flat_map(|t| &t.edges)
        .filter(|e| e.across.is_none());
    assert_eq!(open.count(), 0);
    let outwards = mesh
        .triangles
        .iter()
        .all(|t| t.normal.dot(t.centre()) > 0.0);
    assert!(
        outwards,
        "a triangle is wound inwards or the rock folds over itself"
    );
}

#[test]
fn lines_return_where_they_came_from() {
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    for shape in [shapes::rock(12), shapes::uneven_plane(1.0, 9)] {
        let mesh = mesh(&shape);
        for _ in 0..2000 {
            let start = random_place(&mesh, &mut rng);
            let there = trace(&mesh, start, random_direction(&mut rng), 3.0);
            let last = there.last().expect("a line has a piece");
            let back = trace(&mesh, end(&there), -last.direction, 3.0);
            let error = mesh.lift(end(&back)).distance(mesh.lift(start));
            assert!(error < 1e-6, "{start:?} came back {error} away");
        }
    }
}

#[test]
fn pieces_stay_in_their_triangles_and_add_up() {
    let mut rng = ChaCha8Rng::seed_from_u64(2);
    let mesh = mesh(&shapes::rock(12));
    for _ in 0..500 {
        let pieces = trace(
            &mesh,
            random_place(&mesh, &mut rng),
            random_direction(&mut rng),
            20.0,
        );
        let length: f64 = pieces.iter().map(|p| p.length).sum();
        assert!((length - 20.0).abs() < 1e-9);
        for pair in pieces.windows(2) {
            let gap = mesh
                .lift(pair[0].place(pair[0].length))
                .distance(mesh.lift(pair[1].place(0.0)));
            assert!(gap < 1e-8, "a jump of {gap}");
        }
        let inside = |p: &Place| mesh.triangles[p.triangle].distance(mesh.lift(*p)) < 1e-12;
        assert!(pieces.iter().all(|p| inside(&p.place(p.length))));
    }
}

#[test]
fn lines_on_an_uneven_plane_are_straight() {
    let mut rng = ChaCha8Rng::seed_from_u64(3);
    let mesh = mesh(&shapes::uneven_plane(10.0, 20));
    for _ in 0..2000 {
        let start = mesh.nearest(DVec3::new(rng.random(), rng.random(), 0.0));
        let direction = random_direction(&mut rng);
        let triangle = &mesh.triangles[start.triangle];
        let goal = triangle.lift(start.at) + triangle.lift_direction(direction) * 8.0;
        let reached = mesh.lift(end(&trace(&mesh, start, direction, 8.0)));
        assert!(reached.distance(goal) < 1e-8, "{reached} is not {goal}");
    }
}

#[test]
fn lines_on_a_cylinder_are_helices() {
    let (around, along) = (12, 5);
    let mesh = mesh(&shapes::cylinder(1.0, 100.0, around, along));
    let side = 2.0 * (PI / f64::from(around)).sin();
    let mut rng = ChaCha8Rng::seed_from_u64(4);
    for _ in 0..500 {
        let start = mesh.nearest(DVec3::new(1.0, 0.1, 0.0));
        let direction = random_direction(&mut rng);
        let triangle = &mesh.triangles[start.triangle];
        let along = triangle.lift_direction(direction);
        let (before, after) = (
            mesh.lift(start),
            mesh.lift(end(&trace(&mesh, start, direction, 40.0))),
        );
        assert!((after.z - before.z - 40.0 * along.z).abs() < 1e-6);
        // Unrolled, the prism is a strip: faces of width `side`, one after the other.
        let unrolled = |p: DVec3| {
            let turn = p.y.atan2(p.x).rem_euclid(TAU) / TAU * f64::from(around);
            let middle = (turn.floor() + 0.5) * TAU / f64::from(around);
            let offset = p.y * middle.cos() - p.x * middle.sin();
            (turn.floor() + 0.5) * side + offset
        };
        let tangent = DVec3::new(-(PI / 12.0).sin(), (PI / 12.0).cos(), 0.0);
        let expected = unrolled(before) + 40.0 * along.dot(tangent);
        let strip = f64::from(around) * side;
        let error = (unrolled(after) - expected + strip / 2.0).rem_euclid(strip) - strip / 2.0;
        assert!(error.abs() < 1e-6, "off by {error} round the cylinder");
    }
}

#[test]
fn lines_aimed_at_vertices_and_along_edges_go_on() {
    let mesh = mesh(&shapes::rock(6));
    for (t, triangle) in mesh.triangles.iter().enumerate() {
        for k in 0..3 {
            let centre = (triangle.flat[0] + triangle.flat[1] + triangle.flat[2]) / 3.0;
            let corner = triangle.flat[k];
            let starts = [centre, corner, triangle.flat[(k + 1) % 3]];
            for (at, target) in starts.into_iter().zip([corner, centre, corner]) {
                let place = Place { triangle: t, at };
                let pieces = trace(&mesh, place, (target - at).normalize(), 5.0);
                let length: f64 = pieces.iter().map(|p| p.length).sum();
                assert!((length - 5.0).abs() < 1e-9);
            }
        }
    }
}

// Nearby sets

#[test]
fn whatever_is_within_two_radii_over_the_surface_is_in_the_nearby_set() {
    let (mesh, reach) = (mesh(&shapes::rock(16)), 0.05);
    let sets = nearby_sets(&mesh, reach);
    let mut rng = ChaCha8Rng::seed_from_u64(5);
    for _ in 0..20_000 {
        let start = random_place(&mesh, &mut rng);
        let other = end(&trace(
            &mesh,
            start,
            random_direction(&mut rng),
            reach * rng.random::<f64>(),
        ));
        assert!(sets[start.triangle].binary_search(&other.triangle).is_ok());
    }
}

#[test]
fn two_sheets_are_not_near_each_other() {
    // Two separate squares, closer than the reach.
    let (mut vertices, mut triangles) = shapes::uneven_plane(1.0, 8);
    let (count, faces) = (vertices.len(), triangles.len());
    vertices.extend_from_within(..);
    vertices[count..].iter_mut().for_each(|v| v[2] = 0.01);
    triangles.extend_from_within(..);
    triangles[faces..]
        .iter_mut()
        .for_each(|t| *t = t.map(|v| v + count as u32));
    let sets = nearby_sets(&Mesh::new(&vertices, &triangles), 0.1);
    for (t, set) in sets.iter().enumerate() {
        assert!(set.contains(&t) && set.len() > 3);
        assert!(set.iter().all(|&other| (other < faces) == (t < faces)));
    }
}

// Launch

fn total_length(arcs: &[Arc]) -> f64 {
    arcs.iter().map(Arc::length).sum()
}

#[test]
fn the_launch_circle_is_whole() {
    let centre = DVec3::new(0.3, -0.2, 0.4);
    let circle = TAU * (9.0_f64 - 0.16).sqrt();
    for shape in [shapes::plane(10.0), shapes::uneven_plane(10.0, 13)] {
        let mesh = mesh(&shape);
        let arcs = cut(&mesh, &mesh.component(0), centre, 3.0);
        assert!((total_length(&arcs) - circle).abs() < 1e-9);
    }
    let inside = mesh(&shapes::plane(100.0));
    let arcs = cut(&inside, &[0, 1], DVec3::new(50.0, -50.0, 0.0), 1.0);
    assert_eq!(arcs.len(), 1, "a circle inside one triangle is one arc");
    let globe = mesh(&shapes::sphere(1.0, 60));
    let arcs = cut(&globe, &globe.component(0), DVec3::Z, 0.8);
    // Chord 0.8 from the pole: the circle of latitude with sin(θ/2) = 0.4.
    let latitude = TAU * (2.0 * 0.4_f64.asin()).sin();
    assert!((total_length(&arcs) / latitude - 1.0).abs() < 1e-3);
    assert!(cut(&globe, &globe.component(0), DVec3::Z, 2.1).is_empty());
}

#[test]
fn launches_are_uniform_by_arc_length() {
    let mesh = mesh(&shapes::uneven_plane(10.0, 7));
    let centre = DVec3::new(0.7, 0.1, 0.0);
    let arcs = cut(&mesh, &mesh.component(0), centre, 6.0);
    let mut rng = ChaCha8Rng::seed_from_u64(6);
    let mut bins = [0; 72];
    for _ in 0..100_000 {
        let offset = mesh.lift(on_arcs(&arcs, &mut rng)) - centre;
        assert!((offset.length() - 6.0).abs() < 1e-9);
        let turn = offset.y.atan2(offset.x).rem_euclid(TAU) / TAU;
        bins[(turn * 72.0) as usize % 72] += 1;
    }
    let fit = chi_square(&bins, &[1.0; 72]);
    assert!(fit.p > threshold(1), "{fit:?}");
}

#[test]
fn area_launches_are_uniform_on_the_free_part() {
    let mesh = mesh(&shapes::uneven_plane(1.0, 9));
    let mut cluster = Cluster::new(&mesh, &Params::new(0.1, 0));
    cluster.push(mesh.nearest(DVec3::new(0.5, 0.5, 0.0)));
    let mut rng = ChaCha8Rng::seed_from_u64(7);
    let mut bins = [0; 16];
    for _ in 0..50_000 {
        let place = on_free_area(&cluster, &mesh.component(0), &mut rng).expect("free space");
        let p = mesh.lift(place);
        assert!(p.distance(cluster.positions[0]) >= 0.2);
        let bin = |x: f64| ((x + 1.0) * 2.0).clamp(0.0, 3.0) as usize;
        bins[4 * bin(p.y) + bin(p.x)] += 1;
    }
    // Cells of area 1/4; the element's disc of exclusion, area 0.04π, is shared by the four cells about (0.5, 0.5).
    let taken = |i: usize| if i % 4 >= 2 && i >= 8 { 0.01 * PI } else { 0.0 };
    let weights: Vec<f64> = (0..16).map(|i| 0.25 - taken(i)).collect();
    let fit = chi_square(&bins, &weights);
    assert!(fit.p > threshold(1), "{fit:?}");
}

// Joining

/// Random elements that do not overlap, on the square |x|, |y| < 6.
fn scattered(mesh: &Mesh, count: usize) -> Cluster<'_> {
    let mut rng = ChaCha8Rng::seed_from_u64(8);
    let mut cluster = Cluster::new(mesh, &Params::new(0.5, 0));
    while cluster.positions.len() < count {
        let [x, y]: [f64; 2] = rng.random();
        let p = DVec3::new(12.0 * x - 6.0, 12.0 * y - 6.0, 0.0);
        if cluster.nearest_distance(p) >= 1.0 {
            cluster.push(mesh.nearest(p));
        }
    }
    cluster
}

/// Where a disc of diameter 1 rolls to about `pivot` in the plane: the intersection of two circles, nearest by angle to
/// `touch`, that overlaps nothing.
fn roll_in_the_plane(centres: &[DVec3], touch: DVec3, pivot: usize) -> Option<DVec3> {
    let c = centres[pivot];
    let mut best: Option<(f64, DVec3)> = None;
    for &other in centres
        .iter()
        .filter(|o| o.distance(c) > 0.0 && o.distance(c) < 2.0)
    {
        let middle = (c + other) / 2.0;
        let half = (1.0 - middle.distance_squared(c)).sqrt();
        let side = (other - c).cross(DVec3::Z).normalize() * half;
        for place in [middle + side, middle - side] {
            let free = centres.iter().all(|e| e.distance(place) > 1.0 - 1e-9);
            let angle = (place - c).angle_between(touch - c);
            if free && best.is_none_or(|(least, _)| angle < least) {
                best = Some((angle, place));
            }
        }
    }
    best.map(|(_, place)| place)
}

#[test]
fn touching_and_packing_equal_plane_geometry_on_every_triangulation() {
    for shape in [
        shapes::plane(20.0),
        shapes::uneven_plane(20.0, 5),
        shapes::uneven_plane(20.0, 36),
    ] {
        let mesh = mesh(&shape);
        let cluster = scattered(&mesh, 45);
        let centres = &cluster.positions;
        let mut rng = ChaCha8Rng::seed_from_u64(9);
        let mut compared = 0;
        while compared < 400 {
            let start = DVec3::new(
                rng.random::<f64>() * 12.0 - 6.0,
                rng.random::<f64>() * 12.0 - 6.0,
                0.0,
            );
            let place = mesh.nearest(start);
            let pieces = trace(&mesh, place, random_direction(&mut rng), 0.6);
            if cluster.nearest_distance(start) < 1.0
                || cluster.overlapped(end(&pieces), 1.0).is_empty()
            {
                continue;
            }
            compared += 1;
            let (touch, pivot) = first_touch(&cluster, &pieces);
            let p = mesh.lift(touch);
            assert!((p.distance(centres[pivot]) - 1.0).abs() < 1e-9);
            assert!(
                (cluster.nearest_distance(p) - 1.0).abs() < 1e-9,
                "an earlier touch was missed"
            );
            let (found, expected) = (
                pack(&cluster, touch, pivot),
                roll_in_the_plane(centres, p, pivot),
            );
            match (found.map(|place| mesh.lift(place)), expected) {
                (Some(a), Some(b)) => assert!(a.distance(b) < 1e-6, "rolled to {a} instead of {b}"),
                (None, None) => {}
                (a, b) => panic!("rolled to {a:?}, expected {b:?}"),
            }
        }
    }
}

// Growth

fn check_counters(run: &Run) {
    let (c, joined) = (&run.counters, run.elements.len() as u64 - 1);
    assert_eq!(c.walkers, joined + c.killed);
    assert_eq!(c.contacts, joined + c.refusals);
    assert!(c.steps >= c.contacts);
}

#[test]
fn lists_and_cells_grow_the_same_cluster() {
    for shape in [shapes::plane(1e4), shapes::cylinder(8.0, 400.0, 16, 40)] {
        let lists = Params::new(1.0, 11);
        assert_eq!(run(&shape, &lists, 300), run(&shape, &cells(lists), 300));
    }
}

#[test]
fn touching_clusters_are_trees_of_discs_that_just_touch() {
    let shapes = [(shapes::plane(1e5), 1.0), (shapes::rock(24), 0.02)];
    for (shape, r) in shapes {
        let run = run(&shape, &Params::plain_dla(r, 12), 800);
        check_counters(&run);
        for element in &run.elements[1..] {
            let parent = &run.elements[element.parent.expect("only the seed has no parent")];
            let distance = DVec3::from(element.position).distance(parent.position.into());
            assert!((distance / (2.0 * r) - 1.0).abs() < 1e-9);
            assert_eq!(element.probability, 1.0);
        }
        let contacts = stats::mean_contacts(&run.positions(), r, 1e-9);
        assert!(
            (contacts - 2.0 * 799.0 / 800.0).abs() < 1e-9,
            "{contacts} contacts an element"
        );
    }
}

#[test]
fn packed_discs_do_not_overlap_and_touch_two() {
    let shapes = [
        (shapes::plane(1e5), 1.0, 2000),
        (shapes::cylinder(20.0, 1000.0, 20, 60), 1.0, 2000),
        (shapes::rock(24), 0.01, 2000),
    ];
    for (shape, r, elements) in shapes {
        let at = [0.0, 0.0, 1.0];
        let run = run(
            &shape,
            &Params {
                at,
                ..Params::new(r, 13)
            },
            elements,
        );
        check_counters(&run);
        let positions = run.positions();
        let smallest = stats::smallest_distance(&positions) / (2.0 * r);
        assert!(smallest > 1.0 - 1e-6, "a pair at {smallest} diameters");
        let limit = 2.0 * r * (1.0 + 1e-9);
        let touched = |i: usize| {
            let p = DVec3::from(positions[i]);
            positions[..i]
                .iter()
                .filter(|q| p.distance(DVec3::from(**q)) <= limit)
                .count()
        };
        let single = (1..elements).filter(|&i| touched(i) < 2).count() as u64;
        assert_eq!(
            single, run.counters.unpacked,
            "elements that rest on one other"
        );
        assert!(run.counters.unpacked < elements as u64 / 100);
    }
}

#[test]
fn plain_dla_has_the_dimension_of_dla() {
    let plane = shapes::plane(1e5);
    let dimension = |seed| {
        let run = run(&plane, &cells(Params::plain_dla(1.0, seed)), 4000);
        check_counters(&run);
        stats::gyration_dimension(&run.positions())
    };
    // One cluster of 4,000 scatters by 0.058 (32 seeds), the mean of eight by 0.02.
    let (mean, variance) = stats::mean_variance(&[1, 2, 3, 4, 5, 6, 7, 8].map(dimension));
    assert!(
        (mean - 1.71).abs() < 0.08,
        "D = {mean} ± {}",
        (variance / 8.0).sqrt()
    );
}

#[test]
fn a_lower_bias_grows_denser() {
    let plane = shapes::plane(1e5);
    let gyration = |bias| {
        let grow = |seed| {
            run(
                &plane,
                &cells(Params {
                    bias,
                    ..Params::new(1.0, seed)
                }),
                2000,
            )
        };
        [21, 22, 23].map(|seed| stats::radius_of_gyration(&grow(seed).positions()))
    };
    let samples = [0.9, 0.6, 0.3].map(gyration);
    for pair in samples.windows(2) {
        let (difference, error) = stats::compare(&pair[0], &pair[1]);
        assert!(
            difference > 4.0 * error,
            "wider by {difference} ± {error} only"
        );
    }
}

/// R_g and contacts an element of `seeds` clusters.
fn gyrations_and_contacts(
    params: &Params,
    elements: usize,
    seeds: std::ops::Range<u64>,
) -> [Vec<f64>; 2] {
    let plane = shapes::plane(1e5);
    let grown = seeds.map(|seed| {
        run(
            &plane,
            &Params {
                seed,
                ..params.clone()
            },
            elements,
        )
    });
    let measure = |run: Run| {
        let contacts = run.counters.contacts as f64 / elements as f64;
        (stats::radius_of_gyration(&run.positions()), contacts)
    };
    let (gyrations, contacts) = grown.map(measure).unzip();
    [gyrations, contacts]
}

fn check_small_steps(params: &Params, elements: usize) {
    let near = Params {
        kill: 3.0,
        ..params.clone()
    };
    let small = Params {
        large_steps: false,
        ..near.clone()
    };
    let large = gyrations_and_contacts(&near, elements, 100..140);
    let small = gyrations_and_contacts(&small, elements, 200..240);
    for (a, b) in large.iter().zip(&small) {
        let (difference, error) = stats::compare(a, b);
        assert!(error < 0.04, "{error} is too coarse a test");
        assert!(
            difference.abs() <= 3.5 * error,
            "large steps shift the mean by {difference} ± {error}"
        );
    }
}

#[test]
fn where_all_contacts_stick_the_large_steps_of_the_thesis_are_its_small_ones() {
    check_small_steps(&Params::plain_dla(1.0, 0), 60);
}

#[test]
fn where_contacts_are_refused_large_steps_that_end_at_the_touch_are_small_ones() {
    check_small_steps(
        &Params {
            margin: 2.0,
            ..Params::new(1.0, 0)
        },
        100,
    );
}

#[test]
fn a_closed_surface_fills_and_the_run_ends() {
    let r = 0.15;
    let run = run(&shapes::sphere(1.0, 8), &Params::new(r, 31), usize::MAX);
    let covered = run.elements.len() as f64 * PI * r * r / (4.0 * PI);
    // Random sequential addition jams at 0.547, hexagonal packing at 0.907.
    assert!(
        (0.6..0.95).contains(&covered),
        "{covered} of the sphere is covered"
    );
    assert!(stats::smallest_distance(&run.positions()) > 2.0 * r * (1.0 - 1e-6));
}

#[test]
fn a_seed_decides_everything() {
    let plane = shapes::plane(1e5);
    let grown = |seed| run(&plane, &Params::new(1.0, seed), 200);
    assert_eq!(grown(1), grown(1));
    assert_ne!(grown(1), grown(2));
}

/// The counts printed in the shared grid of L and B: elements at R_e = 300 r for L = 10 r, and 9 contacts an element at
/// B = 0.5. Theirs is one cluster each, ours the mean of three, one scatters by 10 %: three standard errors of the
/// difference are 3·√(10² + 10²/3) = 35 %. It takes a step margin of 2; with the thesis's 1, B = 0.5 gives 56 % more
/// elements and 6.5 contacts.
#[test]
#[ignore = "the slow reference takes over two minutes; the engine is held to the same counts in physics.rs"]
fn counts_agree_with_the_shared_grid() {
    let (vertices, triangles) = shapes::plane(1e5);
    for (bias, count) in [
        (0.9, 19_006.0),
        (0.7, 22_256.0),
        (0.5, 25_553.0),
        (0.3, 45_242.0),
    ] {
        let params = |seed| {
            cells(Params {
                bias,
                margin: 2.0,
                ..Params::new(1.0, seed)
            })
        };
        let runs =
            [1, 2, 3].map(|seed| grow(&vertices, &triangles, &params(seed), Stop::at_reach(300.0)));
        let elements = runs.each_ref().map(|run| run.elements.len() as f64);
        let (mean, _) = stats::mean_variance(&elements);
        assert!(
            (mean / count - 1.0).abs() < 0.35,
            "B = {bias}: {elements:?}, shared {count}"
        );
        let contacts: u64 = runs.iter().map(|run| run.counters.contacts).sum();
        let contacts = contacts as f64 / elements.iter().sum::<f64>();
        assert!(
            bias != 0.5 || (contacts - 9.0).abs() < 1.0,
            "{contacts} contacts an element"
        );
    }
}
