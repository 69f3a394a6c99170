//! What must hold of a mesh before it is shipped, checked on the coordinates that the file will hold.

use std::collections::HashMap;

use anyhow::{Result, ensure};
use glam::DVec3;

use crate::surface::Surface;

/// The topology of a mesh whose vertices have been welded by equal position.
#[derive(Debug, PartialEq)]
pub(crate) struct Audit {
    pub(crate) triangles: usize,
    pub(crate) vertices: usize,
    pub(crate) boundary_edges: usize,
    pub(crate) pieces: usize,
    /// Enclosed by the triangles; positive when they face outwards.
    pub(crate) volume: f64,
    /// Vertices − edges + triangles: 2 for a closed body without handles.
    pub(crate) euler: i64,
}

impl Audit {
    pub(crate) fn is_closed_body(&self) -> bool {
        self.boundary_edges == 0 && self.pieces == 1 && self.euler == 2 && self.volume > 0.0
    }
}

/// Joins vertices of equal position, to the bit.
pub(crate) fn weld(split: &Surface) -> Surface {
    let mut index: HashMap<[u64; 3], u32> = HashMap::new();
    let mut positions = Vec::new();
    let mut welded = Vec::with_capacity(split.positions.len());
    for p in &split.positions {
        let key = p.to_array().map(f64::to_bits);
        welded.push(*index.entry(key).or_insert_with(|| {
            positions.push(*p);
            (positions.len() - 1) as u32
        }));
    }
    let triangles = split
        .triangles
        .iter()
        .map(|t| t.map(|v| welded[v as usize]))
        .collect();
    Surface {
        positions,
        triangles,
    }
}

/// Welds `surface` and checks that it is an oriented 2-manifold, possibly with a boundary, without degenerate
/// triangles.
///
/// # Errors
/// Names the first triangle, edge or vertex at fault.
pub(crate) fn audit(surface: &Surface) -> Result<Audit> {
    let welded = weld(surface);
    check_triangles(&welded)?;
    let sides = directed_edges(&welded)?;
    let mut fans = Groups::new(welded.triangles.len() * 3);
    let mut pieces = Groups::new(welded.triangles.len());
    let mut boundary_edges = 0;
    for (&(a, b), &side) in &sides {
        let Some(&twin) = sides.get(&(b, a)) else {
            boundary_edges += 1;
            continue;
        };
        fans.join(corner(side, 0), corner(twin, 1));
        fans.join(corner(side, 1), corner(twin, 0));
        pieces.join(side / 3, twin / 3);
    }
    ensure!(
        fans.count() == welded.positions.len(),
        "a vertex joins separate fans of triangles"
    );
    let edges = (sides.len() + boundary_edges) / 2;
    Ok(Audit {
        triangles: welded.triangles.len(),
        vertices: welded.positions.len(),
        boundary_edges,
        pieces: pieces.count(),
        volume: volume(&welded),
        euler: welded.positions.len() as i64 - edges as i64 + welded.triangles.len() as i64,
    })
}

fn volume(surface: &Surface) -> f64 {
    let corners = surface.triangles.iter().map(|&t| surface.corners(t));
    corners.map(|[a, b, c]| a.dot(b.cross(c)) / 6.0).sum()
}

/// The corner of side `side`'s triangle at the side's start (0) or end (1).
fn corner(side: usize, end: usize) -> usize {
    side / 3 * 3 + (side % 3 + end) % 3
}

fn check_triangles(welded: &Surface) -> Result<()> {
    for (t, &triangle) in welded.triangles.iter().enumerate() {
        let [a, b, c] = welded.corners(triangle);
        let longest = (b - a)
            .length_squared()
            .max((c - b).length_squared())
            .max((a - c).length_squared());
        let area = (b - a).cross(c - a).length();
        ensure!(
            area > 1e-3 * longest,
            "triangle {t} is degenerate: {a} {b} {c}"
        );
    }
    Ok(())
}

/// Maps each directed edge to its triangle and place in it, 3t + i.
fn directed_edges(welded: &Surface) -> Result<HashMap<(u32, u32), usize>> {
    let mut sides = HashMap::with_capacity(welded.triangles.len() * 3);
    for (t, triangle) in welded.triangles.iter().enumerate() {
        for i in 0..3 {
            let (a, b) = (triangle[i], triangle[(i + 1) % 3]);
            let earlier = sides.insert((a, b), 3 * t + i);
            ensure!(
                earlier.is_none(),
                "triangle {t}: a third triangle, or an opposed one, at {}",
                welded.positions[a as usize]
            );
        }
    }
    Ok(sides)
}

/// Checks that every ray from `centre` meets the body once: then it can't cut itself.
///
/// # Errors
/// Names the triangle that turns away from the centre.
pub(crate) fn check_star(surface: &Surface, centre: DVec3) -> Result<()> {
    for (t, &triangle) in surface.triangles.iter().enumerate() {
        let [a, b, c] = surface.corners(triangle).map(|p| p - centre);
        ensure!(
            a.dot(b.cross(c)) > 0.0,
            "triangle {t} faces away from the centre"
        );
    }
    Ok(())
}

/// Disjoint sets of 0..n.
struct Groups {
    parent: Vec<usize>,
    count: usize,
}

impl Groups {
    fn new(n: usize) -> Self {
        Self {
            parent: (0..n).collect(),
            count: n,
        }
    }

    fn root(&mut self, mut i: usize) -> usize {
        while self.parent[i] != i {
            self.parent[i] = self.parent[self.parent[i]];
            i = self.parent[i];
        }
        i
    }

    fn join(&mut self, a: usize, b: usize) {
        let (a, b) = (self.root(a), self.root(b));
        if a != b {
            self.parent[a] = b;
            self.count -= 1;
        }
    }

    fn count(&self) -> usize {
        self.count
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tetrahedron(offset: DVec3) -> Surface {
        let corners = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z];
        let positions = corners.iter().map(|&c| c + offset).collect();
        Surface {
            positions,
            triangles: vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]],
        }
    }

    fn both(mut a: Surface, b: Surface) -> Surface {
        let base = a.positions.len() as u32;
        a.positions.extend(b.positions);
        a.triangles
            .extend(b.triangles.iter().map(|t| t.map(|v| v + base)));
        a
    }

    #[test]
    fn a_tetrahedron_passes() {
        let found = audit(&tetrahedron(DVec3::ZERO)).unwrap();
        assert_eq!(
            found,
            Audit {
                triangles: 4,
                vertices: 4,
                boundary_edges: 0,
                pieces: 1,
                volume: 1.0 / 6.0,
                euler: 2
            }
        );
        assert!(found.is_closed_body());
    }

    #[test]
    fn a_hole_two_pieces_and_a_shared_vertex_are_seen() {
        let mut open = tetrahedron(DVec3::ZERO);
        open.triangles.pop();
        assert_eq!(audit(&open).unwrap().boundary_edges, 3);
        let apart = both(tetrahedron(DVec3::ZERO), tetrahedron(DVec3::splat(5.0)));
        assert_eq!(audit(&apart).unwrap().pieces, 2);
        let touching = both(tetrahedron(DVec3::ZERO), tetrahedron(DVec3::X));
        assert!(audit(&touching).unwrap_err().to_string().contains("fans"));
    }

    #[test]
    fn turned_doubled_and_flat_triangles_are_refused() {
        let mut turned = tetrahedron(DVec3::ZERO);
        turned.triangles[0].swap(0, 1);
        assert!(audit(&turned).is_err());
        let mut inside_out = tetrahedron(DVec3::ZERO);
        inside_out.triangles.iter_mut().for_each(|t| t.swap(0, 1));
        assert!(!audit(&inside_out).unwrap().is_closed_body());
        let mut flat = tetrahedron(DVec3::ZERO);
        flat.positions[3] = DVec3::new(0.5, 0.0, 0.0);
        assert!(audit(&flat).unwrap_err().to_string().contains("degenerate"));
    }
}
