use std::collections::{BTreeMap, BTreeSet};

use glam::DVec3;

use super::super::geometry::nearest_weights;
use super::surface::Surface;
use super::{Limits, Simplified, simplify, simplify_in_parts};

struct Mesh {
    vertices: Vec<DVec3>,
    triangles: Vec<[u32; 3]>,
}

impl Mesh {
    /// A grid of two triangles a cell; places from the unit square, joined where they coincide.
    fn grid(cells: [u32; 2], place: impl Fn(f64, f64) -> DVec3) -> Self {
        let number = |i: u32, j: u32| i * (cells[1] + 1) + j;
        let mut mesh = Self {
            vertices: Vec::new(),
            triangles: Vec::new(),
        };
        for i in 0..=cells[0] {
            for j in 0..=cells[1] {
                let [u, v] = [
                    f64::from(i) / f64::from(cells[0]),
                    f64::from(j) / f64::from(cells[1]),
                ];
                mesh.vertices.push(place(u, v));
            }
        }
        for (i, j) in (0..cells[0]).flat_map(|i| (0..cells[1]).map(move |j| (i, j))) {
            let [a, b, c, d] = [
                number(i, j),
                number(i + 1, j),
                number(i + 1, j + 1),
                number(i, j + 1),
            ];
            mesh.triangles.extend([[a, b, c], [a, c, d]]);
        }
        mesh.welded()
    }

    fn welded(mut self) -> Self {
        let mut number = BTreeMap::new();
        let mut kept = Vec::new();
        for corner in self.triangles.as_flattened_mut() {
            let p = self.vertices[*corner as usize];
            let key = p.to_array().map(|x| (x * 1e9).round() as i64);
            *corner = *number.entry(key).or_insert_with(|| {
                kept.push(p);
                kept.len() as u32 - 1
            });
        }
        self.triangles
            .retain(|[a, b, c]| a != b && b != c && c != a);
        self.vertices = kept;
        self
    }

    fn with(mut self, other: Self) -> Self {
        let first = self.vertices.len() as u32;
        self.vertices.extend(other.vertices);
        self.triangles
            .extend(other.triangles.iter().map(|t| t.map(|v| v + first)));
        self
    }

    fn moved(mut self, by: DVec3) -> Self {
        self.vertices.iter_mut().for_each(|p| *p += by);
        self
    }

    /// Every third triangle the other way round.
    fn badly_wound(mut self) -> Self {
        self.triangles
            .iter_mut()
            .step_by(3)
            .for_each(|t| t.swap(0, 1));
        self
    }

    fn simplified(&self, most_error: f64, least: usize) -> Simplified {
        simplify(&self.vertices, &self.triangles, to(most_error, least))
    }

    /// As a whole, in eight and in thirty parts, and in parts where what may go goes at once.
    fn all_ways(&self, most_error: f64, least: usize) -> [Simplified; 4] {
        let (all, limits) = (self.triangles.len(), to(most_error, least));
        let at_once = Limits {
            at_once: true,
            ..limits
        };
        [
            (usize::MAX, limits),
            (all / 8, limits),
            (all / 30, limits),
            (all / 8, at_once),
        ]
        .map(|(part, limits)| simplify_in_parts(&self.vertices, &self.triangles, limits, part))
    }

    fn with_triangles(&self, triangles: Vec<[u32; 3]>) -> Self {
        Self {
            vertices: self.vertices.clone(),
            triangles,
        }
    }

    fn corners(&self) -> impl Iterator<Item = [DVec3; 3]> + '_ {
        self.triangles
            .iter()
            .map(|t| t.map(|v| self.vertices[v as usize]))
    }
}

fn to(most_error: f64, least_triangles: usize) -> Limits {
    Limits {
        most_error,
        least_triangles,
        at_once: false,
    }
}

fn turn(x: f64) -> (f64, f64) {
    (x * std::f64::consts::TAU).sin_cos()
}

fn sphere(cells: u32) -> Mesh {
    Mesh::grid([2 * cells, cells], |u, v| {
        let ((s, c), (ring, height)) = (turn(u), turn(v / 2.0));
        DVec3::new(c * ring, s * ring, height)
    })
}

/// A sphere with bumps of three sizes, the smallest being noise.
fn bumpy_sphere(cells: u32, seed: u64) -> Mesh {
    let mut state = seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) + 1;
    let mut noise = move || {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        (state >> 11) as f64 / (1u64 << 53) as f64 - 0.5
    };
    let [a, b, size] = [
        3.0 + 4.0 * noise(),
        9.0 + 6.0 * noise(),
        0.02 * noise().abs(),
    ];
    let mut mesh = sphere(cells);
    for p in &mut mesh.vertices {
        let bumps = 0.2 * (a * p.x).sin() * (a * p.y).cos() + 0.05 * (b * p.z).sin();
        *p *= 1.0 + bumps + size * noise();
    }
    mesh
}

fn torus() -> Mesh {
    Mesh::grid([60, 30], |u, v| {
        let ((s, c), (height, out)) = (turn(u), turn(v));
        DVec3::new(c * (3.0 + out), s * (3.0 + out), height)
    })
}

fn moebius_strip() -> Mesh {
    Mesh::grid([90, 10], |u, v| {
        let ((s, c), (half_s, half_c), t) = (turn(u), turn(u / 2.0), v - 0.5);
        DVec3::new(c * (2.0 + t * half_c), s * (2.0 + t * half_c), t * half_s)
    })
}

fn open_grid(cells: u32) -> Mesh {
    Mesh::grid([cells, cells], |u, v| DVec3::new(u, v, 0.0))
}

/// A box of sides 1, 1 and `thickness`, with as many cells across each face.
fn slab(thickness: f64) -> Mesh {
    let faces = [[0, 1, 2], [1, 2, 0], [2, 0, 1]].map(|axes| {
        let side = |far: f64| {
            Mesh::grid([24, 24], |u, v| {
                let mut p = [0.0; 3];
                [p[axes[0]], p[axes[1]], p[axes[2]]] = [u, v, far];
                DVec3::from(p) * DVec3::new(1.0, 1.0, thickness)
            })
        };
        side(0.0).with(side(1.0))
    });
    let [a, b, c] = faces;
    a.with(b).with(c).welded()
}

/// Three wavy sheets that meet in a line.
fn three_sheets() -> Mesh {
    let sheets = [0.0, 0.3, 0.6].map(|angle| {
        let (s, c) = turn(angle);
        let sheet = move |u: f64, v: f64| {
            let wave = 0.05 * u * (9.0 * v).sin();
            DVec3::new(u * c - wave * s, u * s + wave * c, v)
        };
        Mesh::grid([16, 24], sheet)
    });
    let [a, b, c] = sheets;
    a.with(b).with(c).welded()
}

fn all_meshes() -> Vec<(&'static str, Mesh)> {
    vec![
        ("sphere", sphere(24)),
        ("badly wound sphere", sphere(24).badly_wound()),
        ("torus", torus()),
        ("open grid", open_grid(24)),
        (
            "soup",
            torus()
                .with(sphere(12).moved(DVec3::X * 9.0))
                .with(open_grid(5)),
        ),
        ("slab", slab(0.001)),
        ("three sheets", three_sheets()),
        ("Moebius strip", moebius_strip()),
        ("bumpy sphere", bumpy_sphere(40, 7)),
        ("badly wound Moebius strip", moebius_strip().badly_wound()),
    ]
}

/// What a homeomorphism keeps.
#[derive(Debug, PartialEq)]
struct Topology {
    pieces: usize,
    euler: i64,
    border_loops: usize,
    non_manifold_edges: BTreeSet<[u32; 2]>,
    non_manifold_vertices: BTreeSet<u32>,
    orientable: Option<bool>,
}

fn edge_counts(triangles: &[[u32; 3]]) -> BTreeMap<[u32; 2], usize> {
    let mut counts = BTreeMap::new();
    for &[a, b, c] in triangles {
        for [x, y] in [[a, b], [b, c], [c, a]] {
            *counts.entry([x.min(y), x.max(y)]).or_insert(0) += 1;
        }
    }
    counts
}

/// The number of classes of things joined by links.
fn classes(links: impl Iterator<Item = [u32; 2]>) -> usize {
    let mut neighbours: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
    for [a, b] in links {
        neighbours.entry(a).or_default().push(b);
        neighbours.entry(b).or_default().push(a);
    }
    let mut classes = 0;
    while let Some((_, first)) = neighbours.pop_first() {
        classes += 1;
        let mut open = first;
        while let Some(next) = open.pop() {
            open.extend(neighbours.remove(&next).into_iter().flatten());
        }
    }
    classes
}

fn topology(triangles: &[[u32; 3]]) -> Topology {
    let edges = edge_counts(triangles);
    let vertices: BTreeSet<u32> = triangles.iter().flatten().copied().collect();
    let mut links: BTreeMap<u32, Vec<[u32; 2]>> = BTreeMap::new();
    for &[a, b, c] in triangles {
        for (v, link) in [(a, [b, c]), (b, [c, a]), (c, [a, b])] {
            links.entry(v).or_default().push(link);
        }
    }
    let of_count =
        |wanted: fn(usize) -> bool| edges.iter().filter(move |e| wanted(*e.1)).map(|e| *e.0);
    let non_manifold_edges: BTreeSet<_> = of_count(|n| n > 2).collect();
    let orientable = non_manifold_edges
        .is_empty()
        .then(|| is_orientable(triangles));
    Topology {
        pieces: classes(edges.keys().copied()),
        euler: vertices.len() as i64 - edges.len() as i64 + triangles.len() as i64,
        border_loops: classes(of_count(|n| n == 1)),
        non_manifold_edges,
        non_manifold_vertices: links
            .iter()
            .filter(|(_, link)| classes(link.iter().copied()) > 1)
            .map(|(&v, _)| v)
            .collect(),
        orientable,
    }
}

/// In the double cover every triangle is there both ways round; an orientable piece falls in two.
fn is_orientable(triangles: &[[u32; 3]]) -> bool {
    let mut sides: BTreeMap<[u32; 2], Vec<(u32, bool)>> = BTreeMap::new();
    for (t, &[a, b, c]) in triangles.iter().enumerate() {
        for [x, y] in [[a, b], [b, c], [c, a]] {
            sides
                .entry([x.min(y), x.max(y)])
                .or_default()
                .push((t as u32, x < y));
        }
    }
    let alone = (0..2 * triangles.len() as u32).map(|t| [t, t]);
    let joined = sides.values().filter(|s| s.len() == 2).flat_map(|s| {
        let same = u32::from(s[0].1 == s[1].1);
        [
            [2 * s[0].0, 2 * s[1].0 + same],
            [2 * s[0].0 + 1, 2 * s[1].0 + 1 - same],
        ]
    });
    let joined: Vec<[u32; 2]> = alone.chain(joined).collect();
    let pieces = classes(edge_counts(triangles).into_keys());
    classes(joined.into_iter()) == 2 * pieces
}

fn least_aspect(mesh: &Mesh) -> f64 {
    let aspects = mesh.corners().map(|[a, b, c]| {
        let sides = [b - a, c - b, a - c].map(DVec3::length_squared);
        (b - a).cross(c - a).length() / sides.into_iter().fold(0.0, f64::max)
    });
    aspects.fold(f64::INFINITY, f64::min)
}

fn distance(p: DVec3, mesh: &Mesh) -> f64 {
    let distances = mesh.corners().map(|c| {
        let w = nearest_weights(p, c);
        (c[0] * w[0] + c[1] * w[1] + c[2] * w[2] - p).length_squared()
    });
    distances.fold(f64::INFINITY, f64::min).sqrt()
}

/// The distances that a result is allowed, as a multiple of the error asked for.
const LAW: f64 = 2.5;

#[test]
fn topology_is_kept() {
    for (name, mesh) in all_meshes() {
        let before = topology(&mesh.triangles);
        for most_error in [0.0, 1e-3, 1e-2, 0.1, 1.0, f64::INFINITY] {
            for result in mesh.all_ways(most_error, 0) {
                let after = topology(&result.triangles);
                assert_eq!(after, before, "{name} at {most_error}");
            }
        }
    }
}

#[test]
fn no_degenerate_duplicate_or_sliver() {
    for (name, mesh) in all_meshes() {
        let before = least_aspect(&mesh);
        let errors = [1e-3, 0.1, f64::INFINITY];
        for simplified in errors.into_iter().flat_map(|e| mesh.all_ways(e, 0)) {
            let result = mesh.with_triangles(simplified.triangles);
            let distinct: BTreeSet<[u32; 3]> = result
                .triangles
                .iter()
                .map(|&t| {
                    let mut t = t;
                    t.sort_unstable();
                    t
                })
                .collect();
            assert_eq!(distinct.len(), result.triangles.len(), "{name}");
            let limit = before.min(super::checks::LEAST_ASPECT);
            assert!(least_aspect(&result) >= limit * (1.0 - 1e-9), "{name}");
        }
    }
}

#[test]
fn vertices_stay_near_the_result() {
    for (name, mesh) in all_meshes() {
        for most_error in [1e-3, 1e-2, 0.1] {
            for result in mesh.all_ways(most_error, 0) {
                assert!(result.error <= most_error);
                let coarse = mesh.with_triangles(result.triangles);
                let used: BTreeSet<u32> = mesh.triangles.iter().flatten().copied().collect();
                let farthest = used
                    .iter()
                    .step_by(3)
                    .map(|&v| distance(mesh.vertices[v as usize], &coarse))
                    .fold(0.0, f64::max);
                assert!(
                    farthest <= LAW * most_error,
                    "{name}: {farthest} at {most_error}"
                );
            }
        }
    }
}

/// The other way round: no triangle of the result bridges a gap.
#[test]
fn the_result_stays_near_the_mesh() {
    for (name, mesh) in all_meshes() {
        let most_error = 0.01;
        for simplified in mesh.all_ways(most_error, 0) {
            let coarse = mesh.with_triangles(simplified.triangles);
            let middles = coarse.corners().map(|[a, b, c]| (a + b + c) / 3.0);
            let farthest = middles.map(|p| distance(p, &mesh)).fold(0.0, f64::max);
            assert!(farthest <= LAW * most_error, "{name}: {farthest}");
        }
    }
}

#[test]
fn meshes_become_much_smaller() {
    let few = |mesh: Mesh, most_error, most: usize| {
        let [at_once, in_eight, in_thirty, ..] = mesh
            .all_ways(most_error, 0)
            .map(|result| result.triangles.len());
        assert!(at_once <= most, "{at_once} > {most}");
        let in_parts = in_eight.max(in_thirty);
        assert!(in_parts <= most + most / 5, "{in_parts} > {most} in parts");
    };
    few(open_grid(64), 1e-9, 40);
    few(open_grid(64).badly_wound(), 1e-9, 40);
    few(sphere(64), 0.01, 1500);
    few(sphere(64).badly_wound(), 0.01, 1500);
    few(torus(), 0.1, 500);
    few(three_sheets(), 0.1, 250);
    few(moebius_strip(), 0.05, 200);
}

#[test]
fn faces_of_a_plate_stay_apart() {
    let plate = slab(0.001);
    let errors = [1e-4, 0.01, 1.0];
    for simplified in errors.into_iter().flat_map(|e| plate.all_ways(e, 0)) {
        let coarse = plate.with_triangles(simplified.triangles);
        let heights = |t: &[DVec3; 3]| t.map(|p| p.z);
        let is_in = |t: &[DVec3; 3], z: f64| heights(t).iter().all(|&h| h == z);
        let area = |z: f64| -> f64 {
            let flat = coarse.corners().filter(|t| is_in(t, z));
            flat.map(|[a, b, c]| (b - a).cross(c - a).length() / 2.0)
                .sum()
        };
        assert!(
            area(0.0) > 0.3 && area(0.001) > 0.3,
            "{} {} of {} triangles",
            area(0.0),
            area(0.001),
            coarse.triangles.len()
        );
    }
}

#[test]
fn borders_keep_their_shape() {
    let disc = Mesh::grid([200, 20], |u, v| {
        let (s, c) = turn(u);
        DVec3::new(c, s, 0.0) * (0.5 + 0.5 * v)
    });
    let most_error = 0.01;
    let area = |m: &Mesh| {
        m.corners()
            .map(|[a, b, c]| (b - a).cross(c - a).length() / 2.0)
            .sum::<f64>()
    };
    // As far from their place as is allowed the rims would lose `most_error` all along.
    let rims = std::f64::consts::TAU * (0.5 + 1.0);
    for simplified in disc.all_ways(most_error, 0) {
        let coarse = disc.with_triangles(simplified.triangles);
        let lost = (area(&disc) - area(&coarse)).abs();
        assert!(lost < 0.75 * most_error * rims, "{lost}");
        assert!(coarse.triangles.len() < 200, "{}", coarse.triangles.len());
    }
}

#[test]
fn stops_at_the_least_triangles() {
    let mesh = bumpy_sphere(40, 1);
    for least in [0, 1, 100, 1001, 1_000_000, usize::MAX] {
        for result in mesh.all_ways(f64::INFINITY, least) {
            let left = result.triangles.len();
            assert!(left >= least.min(mesh.triangles.len()));
            assert!(
                left <= least.saturating_add(1).max(100),
                "{left} for {least}"
            );
        }
    }
}

#[test]
fn same_again_and_random_spheres_hold() {
    for seed in 0..12 {
        let mesh = bumpy_sphere(24, seed);
        let most_error = 0.002 * (seed + 1) as f64;
        let [a, b] = [(); 2].map(|()| mesh.simplified(most_error, 0));
        assert_eq!(
            (&a.triangles, &a.source, &a.onto),
            (&b.triangles, &b.source, &b.onto)
        );
        assert_eq!(a.error.to_bits(), b.error.to_bits());
        assert_eq!(topology(&a.triangles), topology(&mesh.triangles));
        let coarse = mesh.with_triangles(a.triangles);
        let farthest = mesh
            .vertices
            .iter()
            .map(|&p| distance(p, &coarse))
            .fold(0.0, f64::max);
        assert!(
            farthest <= LAW * most_error,
            "seed {seed}: {farthest} at {most_error}"
        );
    }
}

#[test]
fn parts_come_to_the_same_on_any_number_of_threads() {
    let mesh = bumpy_sphere(40, 7);
    let [one, two, three] = [1, 2, 3].map(|threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        let all_ways = pool.expect("a pool").install(|| mesh.all_ways(0.02, 0));
        all_ways.map(|way| (way.triangles, way.source, way.onto))
    });
    assert!(one == two && two == three);
    let [at_once, in_eight, in_thirty, ..] = one;
    assert!(at_once != in_eight && in_eight != in_thirty && in_thirty != at_once);
}

/// Changes when the result does: on every machine it must be this.
#[test]
fn the_result_is_the_recorded_one() {
    // A mesh from + - * / only: sines differ between machines.
    let mesh = Mesh::grid([64, 64], |u, v| {
        let hill = |x: f64| 1.0 / (1.0 + 30.0 * (x - 0.4) * (x - 0.4));
        DVec3::new(u, v, 0.3 * hill(u) * hill(v))
    });
    let result = mesh.simplified(1e-3, 0);
    let mut hash = 0xcbf2_9ce4_8422_2325u64;
    for &corner in result.triangles.as_flattened() {
        hash = (hash ^ u64::from(corner)).wrapping_mul(0x0100_0000_01b3);
    }
    assert_eq!((result.triangles.len(), hash), (889, 3628194663818597912));
}

#[test]
fn numbers_lead_back() {
    let mesh = torus().with(sphere(12).moved(DVec3::X * 9.0));
    for result in mesh.all_ways(0.05, 0) {
        for (t, &source) in result.triangles.iter().zip(&result.source) {
            let given = mesh.triangles[source as usize];
            assert_eq!(*t, given.map(|v| result.onto[v as usize]));
        }
        for &v in &result.onto {
            assert_eq!(result.onto[v as usize], v);
        }
    }
}

#[test]
fn bad_input_does_no_harm() {
    let nothing = simplify(&[], &[], to(1.0, 0));
    assert!(nothing.triangles.is_empty());
    let points = [DVec3::ZERO, DVec3::X, DVec3::Y];
    let bad = [[0, 1, 3], [0, 0, 1], [0, 1, 2], [0, 1, 2], [u32::MAX; 3]];
    let pillow = simplify(&points, &bad, to(f64::INFINITY, 0));
    assert_eq!(
        (pillow.triangles, pillow.source),
        (vec![[0, 1, 2]; 2], vec![2, 3])
    );
    let mut mesh = sphere(12);
    for most_error in [f64::NAN, -1.0, 0.0] {
        assert_eq!(mesh.simplified(most_error, 0).triangles, mesh.triangles);
    }
    mesh.vertices
        .iter_mut()
        .step_by(5)
        .for_each(|p| p.y = f64::NAN);
    mesh.vertices[1].x = f64::INFINITY;
    mesh.simplified(f64::INFINITY, 0);
    mesh.vertices.fill(DVec3::ONE);
    assert_eq!(mesh.simplified(1.0, 0).triangles, mesh.triangles);
}

#[test]
fn a_crowded_vertex_stays() {
    let fan = Mesh::grid([5000, 1], |u, v| {
        let (s, c) = turn(u);
        DVec3::new(c * v, s * v, 1.0 - v)
    });
    let result = fan.simplified(0.01, 0);
    assert_eq!(topology(&result.triangles), topology(&fan.triangles));
    assert!(result.triangles.len() < 100, "{}", result.triangles.len());
}

#[test]
fn a_turned_triangle_is_seen_at_its_corners() {
    let hexagon = |i: u32| {
        let angle = f64::from(i) * std::f64::consts::FRAC_PI_3;
        DVec3::new(libm::cos(angle), libm::sin(angle), 0.0)
    };
    let places: Vec<DVec3> = [DVec3::ZERO]
        .into_iter()
        .chain((0..6).map(hexagon))
        .collect();
    let mut triangles: Vec<[u32; 3]> = (0..6).map(|i| [0, 1 + i, 1 + (i + 1) % 6]).collect();
    assert!(Surface::new(&places, triangles.clone()).is_ring_about(0));
    triangles[2].swap(1, 2);
    assert!(!Surface::new(&places, triangles).is_ring_about(0));
}
