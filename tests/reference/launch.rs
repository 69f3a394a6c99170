//! Where walkers start (Sumner 6.1): on the arcs that the launch sphere cuts from the surface, or anywhere.

use super::cluster::Cluster;
use super::mesh::{Mesh, Place, Triangle};
use glam::{DVec2, DVec3};
use rand::RngExt;
use rand::rngs::ChaCha8Rng;
use std::f64::consts::TAU;

/// Tries at a free place before the surface is called full.
const MOST_TRIES: usize = 100_000;

/// Part of a circle inside a triangle, in the triangle's frame; `start` and `sweep` in radians.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Arc {
    pub(crate) triangle: usize,
    pub(crate) centre: DVec2,
    pub(crate) radius: f64,
    pub(crate) start: f64,
    pub(crate) sweep: f64,
}

impl Arc {
    pub(crate) fn length(&self) -> f64 {
        self.radius * self.sweep
    }

    fn place(&self, angle: f64) -> Place {
        Place {
            triangle: self.triangle,
            at: self.centre + DVec2::from_angle(self.start + angle) * self.radius,
        }
    }
}

/// The arcs in which the sphere cuts the listed triangles.
pub(crate) fn cut(mesh: &Mesh, triangles: &[usize], centre: DVec3, radius: f64) -> Vec<Arc> {
    let mut arcs = Vec::new();
    for &t in triangles {
        cut_triangle(&mesh.triangles[t], t, centre, radius, &mut arcs);
    }
    arcs
}

fn cut_triangle(triangle: &Triangle, t: usize, centre: DVec3, radius: f64, arcs: &mut Vec<Arc>) {
    if triangle.corners.iter().all(|p| p.distance(centre) < radius) {
        return;
    }
    let (foot, height) = triangle.project(centre);
    let square = radius * radius - height * height;
    if square <= 0.0 {
        return;
    }
    let circle = square.sqrt();
    let mut angles = edge_angles(triangle, foot, circle);
    if angles.is_empty() {
        angles.push(0.0);
    }
    angles.sort_by(f64::total_cmp);
    angles.push(angles[0] + TAU);
    for pair in angles.windows(2) {
        let middle = DVec2::from_angle(0.5 * (pair[0] + pair[1]));
        if triangle.contains(foot + middle * circle) {
            arcs.push(Arc {
                triangle: t,
                centre: foot,
                radius: circle,
                start: pair[0],
                sweep: pair[1] - pair[0],
            });
        }
    }
}

/// Angles at which the circle meets the triangle's edges.
fn edge_angles(triangle: &Triangle, centre: DVec2, radius: f64) -> Vec<f64> {
    let mut angles = Vec::new();
    for edge in &triangle.edges {
        let (s, height) = ((centre - edge.base).dot(edge.along), edge.height(centre));
        let square = radius * radius - height * height;
        if square <= 0.0 {
            continue;
        }
        let roots = [s - square.sqrt(), s + square.sqrt()];
        for root in roots
            .into_iter()
            .filter(|root| (0.0..=edge.length).contains(root))
        {
            angles.push((edge.base + edge.along * root - centre).to_angle());
        }
    }
    angles
}

/// A place uniform by arc length.
pub(crate) fn on_arcs(arcs: &[Arc], rng: &mut ChaCha8Rng) -> Place {
    let total: f64 = arcs.iter().map(Arc::length).sum();
    let mut left = rng.random::<f64>() * total;
    for arc in arcs {
        if left < arc.length() {
            return arc.place(left / arc.radius);
        }
        left -= arc.length();
    }
    let last = arcs.last().expect("a cut surface has an arc");
    last.place(last.sweep)
}

/// A place uniform by area over the listed triangles, not in contact with the cluster; none if there seems to be none.
pub(crate) fn on_free_area(
    cluster: &Cluster,
    triangles: &[usize],
    rng: &mut ChaCha8Rng,
) -> Option<Place> {
    let areas: Vec<f64> = triangles
        .iter()
        .map(|&t| cluster.mesh.triangles[t].area())
        .collect();
    let total: f64 = areas.iter().sum();
    for _ in 0..MOST_TRIES {
        let mut left = rng.random::<f64>() * total;
        let chosen = areas.iter().position(|area| {
            left -= area;
            left < 0.0
        });
        let triangle = triangles[chosen.unwrap_or(triangles.len() - 1)];
        let place = in_triangle(cluster.mesh, triangle, rng);
        if cluster.overlapped(place, 2.0 * cluster.radius).is_empty() {
            return Some(place);
        }
    }
    None
}

fn in_triangle(mesh: &Mesh, triangle: usize, rng: &mut ChaCha8Rng) -> Place {
    let [a, b, c] = mesh.triangles[triangle].flat;
    let (root, v) = (rng.random::<f64>().sqrt(), rng.random::<f64>());
    let at = a * (1.0 - root) + b * (root * (1.0 - v)) + c * (root * v);
    Place { triangle, at }
}
