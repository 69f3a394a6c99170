//! Normals of the smooth surface that triangles approximate.

use glam::DVec3;

use super::{Substrate, SurfacePoint};

/// Cosine of the angle between faces beyond which an edge is one of the surface itself: 35°.
const CREASE: f64 = 0.819;

/// Faces looked at around a vertex, at most.
const AROUND: usize = 64;

/// Normals at the corners of a triangle, each the mean of the faces that meet there, weighted by their angles
/// (G. Thürmer and C. A. Wüthrich, *Computing vertex normals from polygonal facets*, 1998), but for those beyond a
/// [`CREASE`].
pub(crate) fn corner_normals(substrate: &Substrate, triangle: u32) -> [DVec3; 3] {
    let own = substrate.normal(triangle);
    substrate.triangles()[triangle as usize].map(|vertex| {
        let mut sum = DVec3::ZERO;
        for &half_edge in substrate.half_edges_at(vertex).iter().take(AROUND) {
            let face = half_edge / 3;
            let normal = substrate.normal(face);
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
