//! Whether triangles make a closed, oriented 2-manifold.

use rayon::prelude::*;

/// What is wrong with a mesh's topology.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Faults {
    /// Edges that do not have exactly two triangles, which run along them in opposite ways.
    pub edges: usize,
    /// Vertices whose triangles are not one fan.
    pub vertices: usize,
    /// Triangles that have a corner twice.
    pub degenerate: usize,
}

impl Faults {
    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        *self == Self::default()
    }
}

/// Looks for faults in triangles with shared vertices.
///
/// # Panics
/// When a corner is not below `vertices`.
pub fn faults(vertices: usize, triangles: &[[u32; 3]]) -> Faults {
    let degenerate = |t: &&[u32; 3]| t[0] == t[1] || t[1] == t[2] || t[2] == t[0];
    Faults {
        edges: faulty_edges(triangles).len(),
        vertices: faulty_vertices(vertices, triangles).len(),
        degenerate: triangles.par_iter().filter(degenerate).count(),
    }
}

/// The vertices at which there are faults; some may come twice.
pub(super) fn faulty(vertices: usize, triangles: &[[u32; 3]]) -> Vec<u32> {
    let mut found = faulty_vertices(vertices, triangles);
    let ends = faulty_edges(triangles).into_iter().flatten();
    found.extend(ends);
    found
}

fn faulty_edges(triangles: &[[u32; 3]]) -> Vec<[u32; 2]> {
    let directed = |t: &[u32; 3]| {
        let [a, b, c] = *t;
        [(a, b), (b, c), (c, a)].map(|(a, b)| (a.min(b), a.max(b), a < b))
    };
    let mut edges: Vec<_> = triangles.par_iter().flat_map_iter(directed).collect();
    edges.par_sort_unstable();
    let sound = |run: &[(u32, u32, bool)]| run.len() == 2 && run[0].2 != run[1].2;
    let runs = edges.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1));
    let wrong = runs.filter(|run| !sound(run));
    wrong.map(|run| [run[0].0, run[0].1]).collect()
}

/// A vertex is sound when its triangles, each followed to the one that begins where it ends, come
/// round after all of them.
fn faulty_vertices(vertices: usize, triangles: &[[u32; 3]]) -> Vec<u32> {
    let mut starts = vec![0usize; vertices + 1];
    let corners = || triangles.as_flattened().iter();
    corners().for_each(|&v| starts[v as usize + 1] += 1);
    (0..vertices).for_each(|v| starts[v + 1] += starts[v]);
    let mut next = starts.clone();
    // For each vertex the sides opposite to it, of its triangles.
    let mut opposite = vec![[0u32; 2]; triangles.len() * 3];
    for [a, b, c] in triangles {
        for (v, side) in [(a, [*b, *c]), (b, [*c, *a]), (c, [*a, *b])] {
            opposite[next[*v as usize]] = side;
            next[*v as usize] += 1;
        }
    }
    let fan = |v: usize| &opposite[starts[v]..starts[v + 1]];
    let torn = |v: &u32| !is_one_fan(fan(*v as usize));
    (0..vertices as u32).into_par_iter().filter(torn).collect()
}

fn is_one_fan(sides: &[[u32; 2]]) -> bool {
    let Some(&[first, mut at]) = sides.first() else {
        return true;
    };
    let mut met = 1;
    while at != first && met <= sides.len() {
        match sides.iter().find(|side| side[0] == at) {
            Some(side) => at = side[1],
            None => return false,
        }
        met += 1;
    }
    met == sides.len()
}

#[cfg(test)]
mod tests {
    use super::*;

    const TETRAHEDRON: [[u32; 3]; 4] = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];

    fn moved(by: u32) -> impl Iterator<Item = [u32; 3]> {
        TETRAHEDRON.into_iter().map(move |t| t.map(|v| v + by))
    }

    #[test]
    fn a_tetrahedron_is_sound_and_without_a_face_is_not() {
        assert!(faults(4, &TETRAHEDRON).is_empty());
        let open = faults(4, &TETRAHEDRON[..3]);
        assert_eq!((open.edges, open.vertices), (3, 3));
    }

    #[test]
    fn a_face_turned_over_is_found() {
        let mut turned = TETRAHEDRON;
        turned[2].swap(0, 1);
        assert_eq!(faults(4, &turned).edges, 3);
    }

    #[test]
    fn two_bodies_that_touch_in_a_vertex_are_found() {
        // The second tetrahedron's vertex 0 is the first's.
        let second = moved(3).map(|t| t.map(|v| if v == 3 { 0 } else { v }));
        let both: Vec<_> = moved(0).chain(second).collect();
        let found = faults(7, &both);
        assert_eq!((found.edges, found.vertices), (0, 1));
    }

    #[test]
    fn two_bodies_that_touch_along_an_edge_are_found() {
        let second = moved(4).map(|t| t.map(|v| if v < 6 { v - 4 } else { v }));
        let both: Vec<_> = moved(0).chain(second).collect();
        assert_eq!(faults(8, &both).edges, 1);
    }

    #[test]
    fn a_triangle_with_a_corner_twice_is_found() {
        assert_eq!(faults(4, &[[0, 1, 1]]).degenerate, 1);
    }
}
