//! Meshes that unroll exactly, and awkward ones.
#![allow(dead_code, reason = "each test crate uses its own part of this")]

use std::f64::consts::TAU;

use glam::{DVec2, DVec3};
use thallus::rng::{Purpose, Stream};
use thallus::substrate::Substrate;

use crate::common::substrate;

/// A stream for a test; tests use indices that no run reaches.
pub(crate) fn stream(index: u64) -> Stream {
    Stream::new(2001, Purpose::Walker, (1 << 40) + index)
}

/// Quads in rows as triangles: `at(i, j)` for i ≤ columns, j ≤ rows. With a stream, windings and
/// diagonals are chosen at random.
pub(crate) fn patch(
    columns: usize,
    rows: usize,
    at: impl Fn(usize, usize) -> DVec3,
    mut random: Option<Stream>,
) -> (Vec<[f64; 3]>, Vec<[u32; 3]>) {
    let (mut positions, mut triangles) = (Vec::new(), Vec::new());
    let mut coin = || random.as_mut().is_some_and(|s| s.uniform() < 0.5);
    for i in 0..columns {
        for j in 0..rows {
            let n = positions.len() as u32;
            let quad = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
            positions.extend(quad.map(|p| p.to_array()));
            let halves = if coin() {
                [[0, 1, 2], [0, 2, 3]]
            } else {
                [[0, 1, 3], [1, 2, 3]]
            };
            for [a, b, c] in halves {
                let half = if coin() { [a, c, b] } else { [a, b, c] };
                triangles.push(half.map(|k| n + k));
            }
        }
    }
    (positions, triangles)
}

/// A rectangle in the plane z = 0 with grid lines at these places.
pub(crate) fn rectangle(xs: &[f64], ys: &[f64], random: Option<Stream>) -> Substrate {
    let at = |i: usize, j: usize| DVec3::new(xs[i], ys[j], 0.0);
    let (positions, triangles) = patch(xs.len() - 1, ys.len() - 1, at, random);
    substrate(positions, triangles)
}

/// n + 1 places from 0 to `length`.
pub(crate) fn even(length: f64, n: usize) -> Vec<f64> {
    (0..=n).map(|i| length * i as f64 / n as f64).collect()
}

/// A prism inscribed in a cylinder of radius 1 about the y axis, open at both ends.
pub(crate) struct Prism {
    pub(crate) sides: usize,
    pub(crate) height: f64,
}

impl Prism {
    /// Width of one side.
    pub(crate) fn width(&self) -> f64 {
        2.0 * (0.5 * TAU / self.sides as f64).sin()
    }

    /// A point of the unrolled surface in space; s is periodic.
    pub(crate) fn roll(&self, s: f64, y: f64) -> DVec3 {
        let side = (s / self.width()).floor();
        let edge = |k: f64| {
            let (sin, cos) = (TAU * k / self.sides as f64).sin_cos();
            DVec3::new(cos, 0.0, sin)
        };
        let along = s / self.width() - side;
        let k = side.rem_euclid(self.sides as f64);
        edge(k).lerp(edge(k + 1.0), along) + DVec3::Y * y
    }

    pub(crate) fn mesh(&self, rows: usize) -> Substrate {
        let at = |i: usize, j: usize| {
            // The seam's corners are the same bits: sin 2π is not 0.
            let (sin, cos) = (TAU * (i % self.sides) as f64 / self.sides as f64).sin_cos();
            DVec3::new(cos, self.height * j as f64 / rows as f64, sin)
        };
        let (positions, triangles) = patch(self.sides, rows, at, Some(stream(1)));
        substrate(positions, triangles)
    }
}

/// A cone of flat faces, apex at the origin, of any total angle: a pyramid below 2π, a saddle
/// above, where the generators go up and down by turns.
pub(crate) struct Cone {
    pub(crate) angle: f64,
    pub(crate) faces: usize,
}

impl Cone {
    /// Angle of one face at the apex.
    pub(crate) fn face_angle(&self) -> f64 {
        self.angle / self.faces as f64
    }

    /// Unit vector along a generator.
    pub(crate) fn generator(&self, k: usize) -> DVec3 {
        let k = k % self.faces;
        let (sin, cos) = (TAU * k as f64 / self.faces as f64).sin_cos();
        let (half, turn) = (self.face_angle() / 2.0, 0.5 * TAU / self.faces as f64);
        let (flat, up) = if self.angle < TAU {
            let flat = half.sin() / turn.sin();
            (flat, -(1.0 - flat * flat).sqrt())
        } else {
            let flat_sq = (1.0 + (2.0 * half).cos()) / (1.0 + (2.0 * turn).cos());
            let up = (1.0 - flat_sq).sqrt();
            (flat_sq.sqrt(), if k.is_multiple_of(2) { up } else { -up })
        };
        DVec3::new(flat * cos, up, flat * sin)
    }

    /// The point at a distance from the apex and an angle about it, in space.
    pub(crate) fn roll(&self, distance: f64, angle: f64) -> DVec3 {
        let face = (angle / self.face_angle()).floor();
        let k = face.rem_euclid(self.faces as f64) as usize;
        let (a, b) = (self.generator(k), self.generator(k + 1));
        let across = (b - a * a.dot(b)).normalize();
        let (sin, cos) = (angle - face * self.face_angle()).sin_cos();
        (a * cos + across * sin) * distance
    }

    /// Distance from the apex and angle about it of a point in a face's plane.
    pub(crate) fn unroll(&self, face: usize, p: DVec3) -> (f64, f64) {
        let (a, b) = (self.generator(face), self.generator(face + 1));
        let across = (b - a * a.dot(b)).normalize();
        let within = p.dot(across).atan2(p.dot(a));
        (p.length(), within + face as f64 * self.face_angle())
    }

    /// With rings of vertices at these distances; `face_of` gives each source triangle's face.
    pub(crate) fn mesh(&self, rings: &[f64]) -> (Substrate, Vec<usize>) {
        let (mut positions, mut triangles, mut faces) = (Vec::new(), Vec::new(), Vec::new());
        for k in 0..self.faces {
            let (a, b) = (self.generator(k), self.generator(k + 1));
            let mut add = |corners: [DVec3; 3]| {
                let n = positions.len() as u32;
                positions.extend(corners.map(|p| p.to_array()));
                triangles.push([n, n + 1, n + 2]);
                faces.push(k);
            };
            add([DVec3::ZERO, a * rings[0], b * rings[0]]);
            for w in rings.windows(2) {
                add([a * w[0], a * w[1], b * w[1]]);
                add([a * w[0], b * w[1], b * w[0]]);
            }
        }
        (substrate(positions, triangles), faces)
    }
}

/// A cube of side 2 about the origin, faces in n × n squares.
pub(crate) fn cube(n: usize) -> Substrate {
    let (mut positions, mut triangles) = (Vec::new(), Vec::new());
    for axis in 0..3 {
        for sign in [-1.0, 1.0] {
            let at = |i: usize, j: usize| {
                let c = |i: usize| 2.0 * i as f64 / n as f64 - 1.0;
                let mut p = [0.0; 3];
                p[axis] = sign;
                p[(axis + 1) % 3] = c(i);
                p[(axis + 2) % 3] = c(j) * sign;
                DVec3::from(p)
            };
            let (more, faces) = patch(n, n, at, None);
            let first = positions.len() as u32;
            positions.extend(more);
            triangles.extend(faces.iter().map(|t| t.map(|k| first + k)));
        }
    }
    substrate(positions, triangles)
}

/// A Möbius band of width 0.6 and radius 1, windings at random.
pub(crate) fn moebius(n: usize, rows: usize) -> Substrate {
    let at = |i: usize, j: usize| {
        // The band's end is its start turned over: the same corners, bit for bit.
        let (i, j) = if i == n { (0, rows - j) } else { (i, j) };
        let t = TAU * i as f64 / n as f64;
        let w = 0.6 * (j as f64 / rows as f64 - 0.5);
        let r = 1.0 + w * (0.5 * t).cos();
        DVec3::new(r * t.cos(), w * (0.5 * t).sin(), r * t.sin())
    };
    let (positions, triangles) = patch(n, rows, at, Some(stream(2)));
    substrate(positions, triangles)
}

/// A lattice fan of needles: strips 1e-6 wide between strips of ordinary width, on a wavy sheet.
pub(crate) fn needles() -> Substrate {
    let mut places = vec![0.0];
    for i in 1..12 {
        let x = f64::from(i) / 12.0;
        places.extend([x, x + 1e-6]);
    }
    places.push(1.0);
    let at = |i: usize, j: usize| {
        let (x, y) = (places[i], places[j]);
        DVec3::new(x, y, 0.1 * (7.0 * x).sin() * (5.0 * y).cos())
    };
    let n = places.len() - 1;
    let (positions, triangles) = patch(n, n, at, Some(stream(3)));
    substrate(positions, triangles)
}

/// Five sheets that share one edge.
pub(crate) fn book() -> Substrate {
    let (mut positions, mut triangles) = (Vec::new(), Vec::new());
    for page in 0..5u32 {
        let (sin, cos) = (TAU * f64::from(page) / 7.0).sin_cos();
        let at = |i: usize, j: usize| DVec3::new(cos * i as f64, j as f64, sin * i as f64) * 0.25;
        let (more, faces) = patch(4, 4, at, Some(stream(4 + u64::from(page))));
        let first = positions.len() as u32;
        positions.extend(more);
        triangles.extend(faces.iter().map(|t| t.map(|k| first + k)));
    }
    substrate(positions, triangles)
}

/// Axes in space of a triangle's chart, made from its corners alone.
pub(crate) fn axes(substrate: &Substrate, triangle: u32) -> [DVec3; 2] {
    let [a, b, c] = substrate.corners(triangle);
    let x = (b - a).normalize();
    let y = c - a - x * (c - a).dot(x);
    [x, y.normalize()]
}

/// A vector in space in the frame of a triangle's chart.
pub(crate) fn in_chart(substrate: &Substrate, triangle: u32, v: DVec3) -> DVec2 {
    let [x, y] = axes(substrate, triangle);
    DVec2::new(v.dot(x), v.dot(y))
}

/// A direction uniform on the circle.
pub(crate) fn direction(stream: &mut Stream) -> DVec2 {
    stream.in_unit_disc().normalize()
}

/// Places from the middle outwards.
pub(crate) fn outwards(mut places: Vec<DVec2>) -> Vec<DVec2> {
    places.sort_by(|a, b| a.length_squared().total_cmp(&b.length_squared()));
    places
}

/// A hexagonal packing of discs of radius 1, so many rows to either side of the middle.
pub(crate) fn packing(rows: i32) -> impl Iterator<Item = DVec2> {
    let place = move |row: i32, column: i32| {
        let x = f64::from(2 * column + (row & 1));
        DVec2::new(x, f64::from(row) * 3f64.sqrt())
    };
    (-rows..=rows).flat_map(move |row| (-rows..=rows).map(move |column| place(row, column)))
}
