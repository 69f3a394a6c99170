//! Distances along the surface against closed forms, walks and each other.
#![allow(clippy::print_stdout)] // measurements, for whoever asks to see them

mod common;
#[path = "common/shapes.rs"]
mod shapes;

use std::f64::consts::{PI, TAU};
use std::path::Path;

use glam::DVec3;
use shapes::{Cone, Prism, even, stream};
use thallus::analysis::{Metric, SurfaceMetric};
use thallus::rng::Stream;
use thallus::substrate::{Substrate, SurfacePoint};

/// Places anywhere on a mesh.
fn places(substrate: &Substrate, n: usize, stream: &mut Stream) -> Vec<SurfacePoint> {
    let all = substrate.triangles().len() as f64;
    let place = |_| {
        let triangle = (stream.uniform() * all) as u32;
        let weights = [0; 3].map(|_| stream.uniform() + 1e-6);
        SurfacePoint::from_weights(triangle, weights)
    };
    (0..n).map(place).collect()
}

fn positions(substrate: &Substrate, places: &[SurfacePoint]) -> Vec<DVec3> {
    let position = |p| substrate.units().to_file(substrate.position(p));
    places.iter().map(position).collect()
}

/// Compares all distances from some places with what they should be.
fn assert_distances(
    substrate: &Substrate,
    places: &[SurfacePoint],
    within: f64,
    expected: impl Fn(DVec3, DVec3) -> f64,
) {
    let positions = positions(substrate, places);
    let metric = SurfaceMetric::new(substrate, places);
    for from in (0..places.len()).step_by(7) {
        for (to, found) in metric
            .distances(from, f64::INFINITY)
            .into_iter()
            .enumerate()
        {
            let expected = expected(positions[from], positions[to]);
            assert!(
                (found - expected).abs() <= within,
                "{from} to {to}: {found}, not {expected}"
            );
        }
    }
}

#[test]
fn on_a_plane_distances_are_straight() {
    let mut stream = stream(1);
    let coarse = common::plane(3.0);
    let lines = [0.0, 0.1, 0.5, 0.52, 1.3, 2.0];
    let uneven = shapes::rectangle(&lines, &even(1.0, 7), Some(shapes::stream(5)));
    for mesh in [coarse, uneven] {
        let places = places(&mesh, 60, &mut stream);
        assert_distances(&mesh, &places, 1e-9, |a, b| a.distance(b));
    }
}

/// Elements at vertices and on edges, which many of a coarse mesh may be.
#[test]
fn places_at_vertices_and_on_edges_are_as_good_as_others() {
    let mesh = shapes::rectangle(&even(2.0, 4), &even(2.0, 4), Some(stream(5)));
    let mut places = Vec::new();
    for triangle in 0..mesh.triangles().len() as u32 {
        for weights in [
            [1.0, 0.0, 0.0],
            [0.0, 0.0, 1.0],
            [0.0, 0.5, 0.5],
            [0.3, 0.7, 0.0],
        ] {
            places.push(SurfacePoint::from_weights(triangle, weights));
        }
    }
    assert_distances(&mesh, &places, 1e-6, |a, b| a.distance(b));
}

/// The prism unrolls: either way round, whichever is shorter.
#[test]
fn on_a_prism_distances_are_those_of_the_unrolled_one() {
    let prism = Prism {
        sides: 24,
        height: 3.0,
    };
    let mesh = prism.mesh(5);
    let places = places(&mesh, 80, &mut stream(2));
    let girth = 24.0 * prism.width();
    let unroll = |p: DVec3| {
        let side = (p.z.atan2(p.x).rem_euclid(TAU) / TAU * 24.0).floor();
        let corner = prism.roll(side * prism.width(), 0.0);
        side * prism.width() + corner.distance(DVec3::new(p.x, 0.0, p.z))
    };
    assert_distances(&mesh, &places, 1e-6, |a, b| {
        let around = (unroll(a) - unroll(b)).abs();
        around.min(girth - around).hypot(a.y - b.y)
    });
}

/// Straight over the unfolded cone, or through its apex: by the law of cosines below half a turn.
#[test]
fn on_cones_distances_are_those_of_the_unfolded_ones() {
    for angle in [1.2 * PI, 3.1 * PI] {
        let cone = Cone { angle, faces: 16 };
        let (mesh, faces) = cone.mesh(&[0.3, 0.6, 1.0]);
        let places = places(&mesh, 60, &mut stream(3));
        let metric = SurfaceMetric::new(&mesh, &places);
        let at = |k: usize| {
            let face = faces[mesh.source_triangle(places[k].triangle) as usize];
            let p = mesh.units().to_file(mesh.position(&places[k]));
            cone.unroll(face, p)
        };
        for from in 0..places.len() {
            for (to, found) in metric
                .distances(from, f64::INFINITY)
                .into_iter()
                .enumerate()
            {
                let ((r, a), (s, b)) = (at(from), at(to));
                let turn = (a - b).abs();
                let turn = turn.min(angle - turn);
                let straight = (r * r + s * s - 2.0 * r * s * turn.cos()).max(0.0).sqrt();
                let expected = if turn < PI { straight } else { r + s };
                assert!(
                    (found - expected).abs() < 1e-7,
                    "{angle} {found} {expected}"
                );
            }
        }
    }
}

/// What the mesh lacks of the sphere: second order in its edges.
#[test]
fn on_a_sphere_distances_come_close_to_great_circles() {
    let worst = [8, 16, 32].map(|n| {
        let mesh = common::sphere(n);
        let places = places(&mesh, 60, &mut stream(4));
        let positions = positions(&mesh, &places);
        let metric = SurfaceMetric::new(&mesh, &places);
        let mut worst = 0f64;
        for from in 0..places.len() {
            for (to, found) in metric
                .distances(from, f64::INFINITY)
                .into_iter()
                .enumerate()
            {
                let (a, b) = (positions[from].normalize(), positions[to].normalize());
                let arc = a.cross(b).length().atan2(a.dot(b));
                worst = worst.max((found - arc).abs());
            }
        }
        println!("sphere of 8·{n}² triangles: worst {worst:.2e} of a radius");
        worst
    });
    assert!(
        worst[0] < 0.05 && worst[1] < worst[0] / 2.5 && worst[2] < worst[1] / 2.5,
        "{worst:?}"
    );
}

/// On a rough rock: the same there and back, no shorter than through space, and no detour: the
/// shortest way over points strewn along the edges (Dijkstra) is a little longer.
#[test]
fn on_a_rock_distances_are_those_of_shortest_ways() {
    let mesh = common::rock(10);
    let places = places(&mesh, 90, &mut stream(6));
    let positions = positions(&mesh, &places);
    let metric = SurfaceMetric::new(&mesh, &places);
    let all: Vec<_> = (0..places.len())
        .map(|i| metric.distances(i, f64::INFINITY))
        .collect();
    let slow = shortest_over_edges(&mesh, &places, 10);
    for i in 0..places.len() {
        assert_eq!(all[i][i], 0.0);
        for j in 0..places.len() {
            let found = all[i][j];
            assert!(
                (found - all[j][i]).abs() < 1e-7,
                "{i} {j}: {found} {}",
                all[j][i]
            );
            assert!(found >= positions[i].distance(positions[j]) - 1e-9);
            if i < 6 {
                let slow = slow[i][j];
                assert!(
                    found <= slow + 1e-9 && slow < 1.02 * found + 0.01,
                    "{found} {slow}"
                );
            }
        }
    }
}

/// Distances from the first six places over straight ways within triangles between points that
/// divide every edge into so many parts.
fn shortest_over_edges(mesh: &Substrate, places: &[SurfacePoint], parts: u32) -> Vec<Vec<f64>> {
    let triangles = mesh.triangles();
    let mut points: Vec<DVec3> = places.iter().map(|p| mesh.position(p)).collect();
    let mut members: Vec<Vec<usize>> = vec![Vec::new(); triangles.len()];
    places
        .iter()
        .enumerate()
        .for_each(|(i, p)| members[p.triangle as usize].push(i));
    let mut known = std::collections::HashMap::new();
    for (t, corners) in triangles.iter().enumerate() {
        for k in 0..3 {
            let (a, b) = (corners[k], corners[(k + 1) % 3]);
            for part in 0..=parts {
                let place = (a.min(b), a.max(b), if a < b { part } else { parts - part });
                // The ends of edges are one point each.
                let key = match place {
                    (low, _, 0) => (low, low, 0),
                    (_, high, part) if part == parts => (high, high, 0),
                    inner => inner,
                };
                let node = *known.entry(key).or_insert_with(|| {
                    let share = f64::from(place.2) / f64::from(parts);
                    let [low, high] = [place.0, place.1].map(|v| mesh.vertices()[v as usize]);
                    points.push(low.lerp(high, share));
                    points.len() - 1
                });
                members[t].push(node);
            }
        }
    }
    let mut lies_in = vec![Vec::new(); points.len()];
    for (t, members) in members.iter().enumerate() {
        members.iter().for_each(|&m| lies_in[m].push(t));
    }
    let graph = Graph {
        points,
        members,
        lies_in,
    };
    let local = (0..6).map(|from| graph.distances(from));
    let units = mesh.units();
    let of_places = |all: Vec<f64>| {
        all[..places.len()]
            .iter()
            .map(|d| units.length_to_file(*d))
            .collect()
    };
    local.map(of_places).collect()
}

/// Points, those of each triangle, and the triangles of each.
struct Graph {
    points: Vec<DVec3>,
    members: Vec<Vec<usize>>,
    lies_in: Vec<Vec<usize>>,
}

impl Graph {
    /// Bellman and Ford's relaxation.
    fn distances(&self, from: usize) -> Vec<f64> {
        let mut best = vec![f64::INFINITY; self.points.len()];
        best[from] = 0.0;
        let mut changed = vec![from];
        while !changed.is_empty() {
            let mut next = Vec::new();
            for at in changed {
                for &to in self.lies_in[at].iter().flat_map(|&t| &self.members[t]) {
                    let way = best[at] + self.points[at].distance(self.points[to]);
                    if way < best[to] {
                        best[to] = way;
                        next.push(to);
                    }
                }
            }
            next.sort_unstable();
            next.dedup();
            changed = next;
        }
        best
    }
}

#[test]
fn what_lies_within_the_limit_is_the_same_with_it() {
    let mesh = common::rock(12);
    let places = places(&mesh, 300, &mut stream(7));
    let metric = SurfaceMetric::new(&mesh, &places);
    let whole = metric.distances(5, f64::INFINITY);
    let part = metric.distances(5, 0.7);
    let near = whole.iter().filter(|d| **d <= 0.7).count();
    assert!(near > 20 && near < 250, "{near}");
    for (whole, part) in whole.into_iter().zip(part) {
        assert!(if whole <= 0.7 {
            whole == part
        } else {
            part > 0.7
        });
    }
}

/// A Möbius band of random windings, and pieces that do not hang together.
#[test]
fn a_search_knows_nothing_of_those_before_it() {
    let mesh = Substrate::load(Path::new("meshes/rock.obj")).expect("a mesh");
    let places = places(&mesh, 40, &mut stream(7));
    let one_for_all = SurfaceMetric::new(&mesh, &places);
    for (from, limit) in [(3, f64::INFINITY), (17, 0.2), (3, 0.1), (31, f64::INFINITY)] {
        let alone = SurfaceMetric::new(&mesh, &places).distances(from, limit);
        assert_eq!(one_for_all.distances(from, limit), alone, "{from}");
    }
}

#[test]
fn any_winding_will_do_and_other_pieces_are_out_of_reach() {
    let band = shapes::moebius(40, 4);
    let places_there = places(&band, 60, &mut stream(8));
    let metric = SurfaceMetric::new(&band, &places_there);
    let all: Vec<_> = (0..60)
        .map(|i| metric.distances(i, f64::INFINITY))
        .collect();
    for (i, row) in all.iter().enumerate() {
        for (j, there) in row.iter().enumerate() {
            assert!(there.is_finite() && (there - all[j][i]).abs() < 1e-9);
        }
    }
    let positions = [0.0, 5.0].map(|x| [[x, 0.0, 0.0], [x + 1.0, 0.0, 0.0], [x, 1.0, 0.0]]);
    let two = common::substrate(positions.concat(), vec![[0, 1, 2], [3, 4, 5]]);
    let both = [0, 1].map(SurfacePoint::centroid);
    let found = SurfaceMetric::new(&two, &both).distances(0, f64::INFINITY);
    assert_eq!(found, [0.0, f64::INFINITY]);
}
