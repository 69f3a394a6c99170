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
const MOST_PASSES: u8 = 32;

/// Normals at the corners of all triangles of the surface as it is without what is small on it, noise of a scan or
/// steps of a terrain: vector areas take the mean with those of neighbours time and again, that of a face the more
/// often the smaller it is, and of one as large as the scale never. The sum of vector areas is that of any surface with
/// the same border, so means of them know nothing of what lies within. Faces that have come to rest give nothing to
/// smaller ones beside them, which would soon be as they are.
pub(super) fn slope_normals(substrate: &Substrate) -> Vec<[Vec3; 3]> {
    let all = 0..substrate.triangles().len() as u32;
    let scale = SLOPE_SCALE * substrate.units().local_diagonal();
    let passes: Vec<u8> = all
        .clone()
        .into_par_iter()
        .map(|t| passes(scale, substrate.area(t)))
        .collect();
    let vector_area = |t| substrate.area_vector(t).as_vec3();
    let mut areas: Vec<Vec3> = all.clone().into_par_iter().map(vector_area).collect();
    for pass in 0..passes.iter().copied().max().unwrap_or(0) {
        let moves = |t: u32| passes[t as usize] > pass;
        let mean = |t: u32| match moves(t) {
            true => mean_about(substrate, t, &areas, &moves),
            false => areas[t as usize],
        };
        areas = all.clone().into_par_iter().map(mean).collect();
    }
    let unit = |(t, area): (usize, &mut Vec3)| {
        *area = area
            .try_normalize()
            .unwrap_or_else(|| substrate.normal(t as u32).as_vec3());
    };
    areas.par_iter_mut().enumerate().for_each(unit);
    let of_face = |t: u32| areas[t as usize].as_dvec3();
    let corners = |t| corners_by(substrate, t, &of_face).map(|normal| normal.as_vec3());
    all.into_par_iter().map(corners).collect()
}

/// With every pass the mean of equilateral triangles is that of places farther off by a quarter of an edge squared.
fn passes(scale: f64, area: f64) -> u8 {
    let edge_sq = 4.0 / 3f64.sqrt() * area;
    (4.0 * scale * scale / edge_sq).min(f64::from(MOST_PASSES)) as u8
}

/// The mean of what a face has and those with which it has edges, as far as they still move.
fn mean_about(
    substrate: &Substrate,
    triangle: u32,
    of: &[Vec3],
    moves: &impl Fn(u32) -> bool,
) -> Vec3 {
    let across = (3 * triangle..3 * triangle + 3).map(|half_edge| {
        let other = substrate.twin(half_edge).half_edge() / 3;
        of[if moves(other) { other } else { triangle } as usize]
    });
    (of[triangle as usize] + across.sum::<Vec3>()) / 4.0
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
