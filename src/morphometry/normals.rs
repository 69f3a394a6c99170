//! Normals of the smooth surface that a mesh stands for.

use glam::DVec3;
use rayon::prelude::*;

use crate::substrate::{Substrate, SurfacePoint, corner_normals, weighted_normal};

/// For each place the unit normal of the surface that the triangles approximate, on the side of
/// [`Substrate::normal`]: the normals at the corners, interpolated by barycentric weights.
///
/// A corner's normal is the mean of the faces that meet there, weighted by their angles
/// (G. Thürmer and C. A. Wüthrich, *Computing vertex normals from polygonal facets*, 1998). Faces
/// that turn away from the place's own by more than 35° are left out, so that a cube keeps its
/// edges, and so does a blade. Of a fan of more than 64 faces the first 64 count, which bounds the work at the hub of a
/// huge one.
///
/// # Panics
/// When a place's triangle is not the substrate's.
pub fn smooth_normals(substrate: &Substrate, places: &[SurfacePoint]) -> Vec<DVec3> {
    let mut used: Vec<u32> = places.iter().map(|p| p.triangle).collect();
    used.par_sort_unstable();
    used.dedup();
    let corners = |&t: &u32| corner_normals(substrate, t);
    let corners: Vec<[DVec3; 3]> = used.par_iter().map(corners).collect();
    let at = |p: &SurfacePoint| {
        let known = used.partition_point(|&t| t < p.triangle);
        weighted_normal(substrate, p, corners[known])
    };
    places.par_iter().map(at).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::substrate::Soup;
    use std::f64::consts::PI;

    /// A unit sphere of squares cut in two, `flip` of them wound the other way.
    fn sphere(n: u32, flip: bool) -> Substrate {
        let mut soup = Soup {
            positions: Vec::new(),
            triangles: Vec::new(),
            notes: Vec::new(),
        };
        for row in 0..=n {
            for column in 0..2 * n {
                let (theta, phi) = (
                    PI * f64::from(row) / f64::from(n),
                    PI * f64::from(column) / f64::from(n),
                );
                soup.positions.push([
                    theta.sin() * phi.cos(),
                    theta.sin() * phi.sin(),
                    theta.cos(),
                ]);
                let (next, below) = ((column + 1) % (2 * n), row + 1);
                if row < n {
                    let [a, b, c, d] = [(row, column), (below, column), (below, next), (row, next)]
                        .map(|(r, c)| r * 2 * n + c);
                    let second = if flip && column % 3 == 0 {
                        [a, d, c]
                    } else {
                        [a, c, d]
                    };
                    soup.triangles.extend([[a, b, c], second]);
                }
            }
        }
        Substrate::from_soup(soup).unwrap()
    }

    #[test]
    fn on_a_sphere_normals_point_from_its_centre() {
        for flip in [false, true] {
            let sphere = sphere(24, flip);
            let places: Vec<_> = (0..sphere.triangles().len() as u32)
                .flat_map(|t| {
                    [[0.8, 0.1, 0.1], [0.1, 0.1, 0.8], [0.3, 0.3, 0.4]]
                        .map(|w| SurfacePoint::from_weights(t, w))
                })
                .collect();
            let flat = |p: &SurfacePoint| sphere.normal(p.triangle);
            let worst = |normals: Vec<DVec3>| {
                let error = |(n, p): (DVec3, &SurfacePoint)| {
                    let out = sphere.position(p).normalize();
                    (n - out).length()
                };
                normals
                    .into_iter()
                    .zip(&places)
                    .map(error)
                    .fold(0.0, f64::max)
            };
            let smooth = worst(smooth_normals(&sphere, &places));
            let facets = worst(places.iter().map(flat).collect());
            assert!(smooth < 0.012 && facets > 0.06, "{smooth} {facets}");
        }
    }

    #[test]
    fn a_blade_keeps_its_edge() {
        for degrees in [120.0, 150.0, 170.0] {
            let (sin, cos) = f64::to_radians(degrees).sin_cos();
            let blade = Substrate::from_soup(Soup {
                positions: vec![
                    [0.0, -1.0, 0.0],
                    [0.0, 1.0, 0.0],
                    [-1.0, 0.0, 0.0],
                    [cos, 0.0, -sin],
                ],
                triangles: vec![[0, 1, 2], [1, 0, 3]],
                notes: Vec::new(),
            })
            .unwrap();
            for t in 0..2 {
                let near_edge = SurfacePoint::from_weights(t, [0.45, 0.45, 0.1]);
                let normal = smooth_normals(&blade, &[near_edge])[0];
                assert!((normal - blade.normal(t)).length() < 1e-12, "{degrees}");
            }
        }
    }

    #[test]
    fn a_cube_keeps_its_edges() {
        let corner = |i: u32| [i & 1, i >> 1 & 1, i >> 2].map(f64::from);
        let faces = [
            [0, 2, 3, 1],
            [4, 5, 7, 6],
            [0, 1, 5, 4],
            [2, 6, 7, 3],
            [0, 4, 6, 2],
            [1, 3, 7, 5],
        ];
        let cube = Substrate::from_soup(Soup {
            positions: (0..8).map(corner).collect(),
            triangles: faces
                .iter()
                .flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]])
                .collect(),
            notes: Vec::new(),
        })
        .unwrap();
        for t in 0..12 {
            let near_edge = SurfacePoint::from_weights(t, [0.98, 0.01, 0.01]);
            let normal = smooth_normals(&cube, &[near_edge])[0];
            assert!((normal - cube.normal(t)).length() < 1e-12);
        }
    }
}
