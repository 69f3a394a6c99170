//! `slab.stl`, thinner than an element, and `plane.obj`, two triangles.

use std::collections::HashMap;

use glam::DVec3;

use crate::surface::Surface;

/// The slab's sides are cut into this many parts, its thickness into one.
const PARTS: i32 = 64;
/// Length of the slab's sides; the automatic radius is then √2/2000 ≈ 0.00071.
const SIDE: f64 = 1.0;
const THICKNESS: f64 = 0.0004;

/// A square plate in the x–z plane, centred at the origin.
pub(crate) fn slab() -> Surface {
    let size = [PARTS, 1, PARTS];
    let scale = DVec3::new(SIDE / f64::from(PARTS), THICKNESS, SIDE / f64::from(PARTS));
    let mut index = HashMap::new();
    let mut surface = Surface {
        positions: Vec::new(),
        triangles: Vec::new(),
    };
    for axis in 0..3 {
        for far in [false, true] {
            for quad in face_quads(size, axis, far) {
                let corners = quad.map(|lattice| {
                    *index.entry(lattice).or_insert_with(|| {
                        let at = DVec3::from_array(
                            [0, 1, 2]
                                .map(|a: usize| f64::from(lattice[a]) - f64::from(size[a]) / 2.0),
                        );
                        surface.positions.push(at * scale);
                        surface.positions.len() as u32 - 1
                    })
                });
                let [a, b, c, d] = corners;
                surface.triangles.extend([[a, b, c], [a, c, d]]);
            }
        }
    }
    surface
}

/// The unit squares on one side of a box of `size` cells, counter-clockwise seen from outside.
pub(crate) fn face_quads(size: [i32; 3], axis: usize, far: bool) -> Vec<[[i32; 3]; 4]> {
    let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
    let mut quads = Vec::new();
    for i in 0..size[u] {
        for j in 0..size[v] {
            let mut quad = [[i, j], [i + 1, j], [i + 1, j + 1], [i, j + 1]].map(|[i, j]| {
                let mut lattice = [0; 3];
                (lattice[u], lattice[v]) = (i, j);
                lattice[axis] = if far { size[axis] } else { 0 };
                lattice
            });
            if !far {
                quad.swap(1, 3);
            }
            quads.push(quad);
        }
    }
    quads
}

/// The square [−1000, 1000]² in the x–z plane, facing +y.
pub(crate) fn plane() -> Surface {
    let corners = [
        (-1000.0, -1000.0),
        (-1000.0, 1000.0),
        (1000.0, 1000.0),
        (1000.0, -1000.0),
    ];
    let positions = corners.map(|(x, z)| DVec3::new(x, 0.0, z)).to_vec();
    Surface {
        positions,
        triangles: vec![[0, 1, 2], [0, 2, 3]],
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::audit::{Audit, audit};

    #[test]
    fn the_slab_is_closed_and_thinner_than_an_automatic_element() {
        let slab = slab();
        assert!(audit(&slab).unwrap().is_closed_body());
        let (low, high) = slab.bounds();
        let radius = (high - low).length() / 2000.0;
        assert!(high.y - low.y < radius);
    }

    #[test]
    fn the_plane_is_two_triangles_facing_up() {
        let plane = plane();
        let found = audit(&plane).unwrap();
        assert_eq!(
            found,
            Audit {
                triangles: 2,
                vertices: 4,
                boundary_edges: 4,
                pieces: 1,
                volume: 0.0,
                euler: 1
            }
        );
        assert!(plane.normals().iter().all(|&n| n == DVec3::Y));
    }
}
