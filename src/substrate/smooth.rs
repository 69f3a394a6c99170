//! Normals of the smooth surface that triangles approximate.

use glam::{DVec3, Vec3};
use rayon::prelude::*;

use super::{Substrate, SurfacePoint};

/// Cosine of the angle between faces beyond which an edge is one of the surface itself: 35°.
const CREASE: f64 = 0.819;

/// Faces looked at around a vertex, at most.
const AROUND: usize = 64;

/// Normals at the corners of a triangle, each the mean of the faces that meet there, weighted by their angles
/// (G. Thürmer and C. A. Wüthrich, *Computing vertex normals from polygonal facets*, 1998), but for those beyond a
/// [`CREASE`].
pub(crate) fn corner_normals(substrate: &Substrate, triangle: u32) -> [DVec3; 3] {
    corners_by(substrate, triangle, &|face| substrate.normal(face))
}

/// The same by other normals of the faces.
fn corners_by(substrate: &Substrate, triangle: u32, normal: &impl Fn(u32) -> DVec3) -> [DVec3; 3] {
    let own = normal(triangle);
    substrate.triangles()[triangle as usize].map(|vertex| {
        let mut sum = DVec3::ZERO;
        for &half_edge in substrate.half_edges_at(vertex).iter().take(AROUND) {
            let face = half_edge / 3;
            let normal = normal(face);
            if own.dot(normal) > CREASE {
                sum += normal * angle(substrate, face, vertex);
            }
        }
        sum.normalize_or(own)
    })
}

/// A triangle's angle at one of its corners.
fn angle(substrate: &Substrate, triangle: u32, vertex: u32) -> f64 {
    let numbers = substrate.triangles()[triangle as usize];
    let k = numbers.iter().position(|&v| v == vertex).unwrap_or(0);
    let corners = substrate.corners(triangle);
    let [a, b, c] = [0, 1, 2].map(|i| corners[(k + i) % 3]);
    let (u, v) = ((b - a).normalize_or_zero(), (c - a).normalize_or_zero());
    libm::acos(u.dot(v).clamp(-1.0, 1.0))
}

/// Of the diagonal of the mesh's bounding box: how far [`slope_normals`] look, as the root of a mean square.
const SLOPE_SCALE: f64 = 0.01;

/// Times that they take the mean with neighbours, at most: that of some hundred triangles.
const MOST_PASSES: usize = 32;

/// Normals at the corners of all triangles of the surface as it is without what is small on it, noise of a scan or steps
/// of a terrain: faces take the mean with their neighbours, by area, time and again, a face the more often the smaller it
/// is, and one as large as the scale never.
pub(super) fn slope_normals(substrate: &Substrate) -> Vec<[Vec3; 3]> {
    let all = 0..substrate.triangles().len() as u32;
    let areas: Vec<f32> = { all.clone().into_par_iter() }
        .map(|t| substrate.area(t) as f32)
        .collect();
    let mut faces: Vec<Vec3> = { all.clone().into_par_iter() }
        .map(|t| substrate.normal(t).as_vec3())
        .collect();
    let units = substrate.units();
    let scale = SLOPE_SCALE * units.length_to_local(units.diagonal());
    let passes = |t: u32| passes(scale, areas[t as usize]);
    let most = { all.clone().into_par_iter() }.map(passes).max();
    for pass in 0..most.unwrap_or(0) {
        let mean = |t: u32| match passes(t) > pass {
            true => mean_about(substrate, t, &faces, &areas),
            false => faces[t as usize],
        };
        faces = all.clone().into_par_iter().map(mean).collect();
    }
    let of_face = |face: u32| faces[face as usize].as_dvec3();
    let corners = |t| corners_by(substrate, t, &of_face).map(|normal| normal.as_vec3());
    all.into_par_iter().map(corners).collect()
}

/// With every pass the mean of equilateral triangles is that of places farther off by a quarter of an edge squared.
fn passes(scale: f64, area: f32) -> usize {
    let edge_sq = 4.0 / 3f64.sqrt() * f64::from(area);
    ((4.0 * scale * scale / edge_sq) as usize).min(MOST_PASSES)
}

/// The mean of the normals of a face and those that it has edges with.
fn mean_about(substrate: &Substrate, triangle: u32, faces: &[Vec3], areas: &[f32]) -> Vec3 {
    let own = triangle as usize;
    let mut sum = faces[own] * areas[own];
    for half_edge in 3 * triangle..3 * triangle + 3 {
        let across = substrate.twin(half_edge).half_edge() as usize / 3;
        if across != own {
            sum += faces[across] * areas[across];
        }
    }
    sum.normalize_or(faces[own])
}

/// The unit normal between a triangle's corners, which have these.
pub(crate) fn weighted_normal(
    substrate: &Substrate,
    at: &SurfacePoint,
    corners: [DVec3; 3],
) -> DVec3 {
    let sum: DVec3 = std::iter::zip(corners, at.weights())
        .map(|(normal, weight)| normal * weight)
        .sum();
    sum.normalize_or(substrate.normal(at.triangle))
}
