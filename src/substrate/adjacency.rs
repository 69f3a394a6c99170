//! Which triangle lies across each edge.
//!
//! Edges are undirected, so walks do not notice how triangles are wound. An edge of one triangle is a
//! boundary: it is its own twin, so that a walk that crosses it unfolds into the mirror image of
//! the triangle that it came from, which is reflection. At an edge of more than two triangles they
//! are [paired](super::pairing).

use std::ops::Range;

use glam::DVec3;
use rayon::prelude::*;

use super::pairing::pairs;
use crate::ahead::fetch;

/// A corner of a triangle, or the directed edge from it to the next corner: 3 · triangle + k.
pub type HalfEdge = u32;

/// For each half-edge, the one on the other side, and whether the two run the same way: in the last bit, so that one
/// shift takes it off.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Twin(u32);

impl Twin {
    fn new(half_edge: HalfEdge, flipped: bool) -> Self {
        Self(half_edge << 1 | u32::from(flipped))
    }

    /// A half-edge that runs the other way.
    #[inline(always)]
    pub(crate) fn of(half_edge: HalfEdge) -> Self {
        Self(half_edge << 1)
    }

    #[inline(always)]
    pub(crate) fn bits(self) -> u32 {
        self.0
    }

    #[inline(always)]
    pub(crate) fn from_bits(bits: u32) -> Self {
        Self(bits)
    }

    /// The half-edge across.
    pub fn half_edge(self) -> HalfEdge {
        self.0 >> 1
    }

    /// True where both run from the same vertex, as at a boundary or where windings disagree.
    pub fn is_flipped(self) -> bool {
        self.0 & 1 != 0
    }
}

/// Adjacency of a welded mesh.
pub(super) struct Adjacency {
    pub(super) twins: Vec<Twin>,
    pub(super) corners: VertexCorners,
    /// A vertex pair for each edge of one triangle.
    pub(super) boundary: Vec<[u32; 2]>,
    /// A vertex pair for each edge of more than two triangles.
    pub(super) non_manifold: Vec<[u32; 2]>,
    /// A vertex pair for each edge of two triangles that are wound differently.
    pub(super) conflicts: Vec<[u32; 2]>,
    /// Whether some that are joined over an edge of any kind are.
    pub(super) winds_differently: bool,
    /// Triangles joined over shared edges, non-manifold ones too.
    pub(super) piece: Vec<u32>,
    /// Triangles joined by twins: where a walker can get to.
    pub(super) walkable: Vec<u32>,
}

/// The corners at each vertex, as one list with offsets.
#[derive(Clone, Debug, Default)]
pub(super) struct VertexCorners {
    offsets: Vec<u32>,
    corners: Vec<HalfEdge>,
}

impl VertexCorners {
    fn new(vertices: usize, triangles: &[[u32; 3]]) -> Self {
        let flat = triangles.as_flattened();
        let mut offsets = vec![0u32; vertices + 1];
        flat.iter().for_each(|&v| offsets[v as usize + 1] += 1);
        (0..vertices).for_each(|v| offsets[v + 1] += offsets[v]);
        let mut corners = vec![0; flat.len()];
        for (corner, &v) in flat.iter().enumerate().rev() {
            offsets[v as usize + 1] -= 1;
            corners[offsets[v as usize + 1] as usize] = corner as u32;
        }
        offsets.rotate_left(1);
        *offsets.last_mut().unwrap_or(&mut 0) = flat.len() as u32;
        Self { offsets, corners }
    }

    /// The half-edges that leave a vertex, one a triangle, ascending.
    pub(super) fn of(&self, vertex: u32) -> &[HalfEdge] {
        let v = vertex as usize;
        &self.corners[self.offsets[v] as usize..self.offsets[v + 1] as usize]
    }

    /// Asks for where these are.
    #[inline]
    pub(super) fn fetch(&self, vertex: u32) {
        fetch(self.offsets.get(vertex as usize));
    }
}

pub(super) fn build(vertices: &[DVec3], triangles: &[[u32; 3]]) -> Adjacency {
    let mut adjacency = Adjacency {
        twins: (0..3 * triangles.len() as u32)
            .map(|h| Twin::new(h, true))
            .collect(),
        corners: VertexCorners::new(vertices.len(), triangles),
        boundary: Vec::new(),
        non_manifold: Vec::new(),
        conflicts: Vec::new(),
        winds_differently: false,
        piece: (0..triangles.len() as u32).collect(),
        walkable: (0..triangles.len() as u32).collect(),
    };
    let numbers = 0..vertices.len() as u32;
    let shares = numbers.clone().into_par_iter().step_by(SHARE as usize);
    let of_share = |first: u32| {
        let share = first..numbers.end.min(first + SHARE);
        Edges::of(triangles, &adjacency.corners, share)
    };
    let found: Vec<Edges> = shares.map(of_share).collect();
    for edges in found {
        adjacency.take(vertices, triangles, edges);
    }
    flatten(&mut adjacency.walkable);
    adjacency.join_pieces();
    adjacency
}

/// The half-edges between v and vertices of higher number, sorted by that vertex.
fn edges_to_later_vertices(
    triangles: &[[u32; 3]],
    corners: &[HalfEdge],
    v: u32,
    edges: &mut Vec<(u32, HalfEdge)>,
) {
    edges.clear();
    for &corner in corners {
        let (t, k) = (corner / 3, corner % 3);
        let [next, previous] = [(k + 1) % 3, (k + 2) % 3];
        let triangle = triangles[t as usize];
        edges.push((triangle[next as usize], corner));
        edges.push((triangle[previous as usize], 3 * t + previous));
    }
    edges.retain(|e| e.0 > v);
    edges.sort_unstable();
}

/// Vertices whose edges one thread looks for at a time.
const SHARE: u32 = 1 << 12;

/// The edges from some vertices to such of higher numbers, by how many triangles they have.
#[derive(Default)]
struct Edges {
    open: Vec<[u32; 2]>,
    /// The half-edges that are one.
    pairs: Vec<[HalfEdge; 2]>,
    many: Vec<Crowded>,
}

/// An edge of more than two triangles.
struct Crowded {
    ends: [u32; 2],
    /// Each with the end of the higher number, sorted.
    half_edges: Vec<(u32, HalfEdge)>,
}

impl Edges {
    fn of(triangles: &[[u32; 3]], corners: &VertexCorners, vertices: Range<u32>) -> Self {
        let mut found = Self::default();
        let mut edges: Vec<(u32, HalfEdge)> = Vec::new();
        for v in vertices {
            edges_to_later_vertices(triangles, corners.of(v), v, &mut edges);
            for group in edges.chunk_by(|a, b| a.0 == b.0) {
                let ends = [v, group[0].0];
                match group {
                    [_] => found.open.push(ends),
                    [a, b] => found.pairs.push([a.1, b.1]),
                    many => {
                        let half_edges = many.to_vec();
                        found.many.push(Crowded { ends, half_edges });
                    }
                }
            }
        }
        found
    }
}

impl Adjacency {
    fn take(&mut self, vertices: &[DVec3], triangles: &[[u32; 3]], edges: Edges) {
        self.boundary.extend(edges.open);
        for [a, b] in edges.pairs {
            if self.join(triangles, a, b) {
                self.conflicts.push(ends(triangles, a));
            }
        }
        for Crowded { ends, half_edges } in edges.many {
            self.non_manifold.push(ends);
            for other in &half_edges[1..] {
                unite(&mut self.piece, half_edges[0].1 / 3, other.1 / 3);
            }
            let half_edges: Vec<HalfEdge> = half_edges.iter().map(|e| e.1).collect();
            for [a, b] in pairs(vertices, triangles, ends, &half_edges) {
                self.join(triangles, a, b);
            }
        }
    }

    /// Pieces from what is joined at edges of many triangles, and from where walkers can get to.
    fn join_pieces(&mut self) {
        if self.non_manifold.is_empty() {
            self.piece.clone_from(&self.walkable);
            return;
        }
        for (t, &root) in (0..).zip(&self.walkable) {
            unite(&mut self.piece, t, root);
        }
        flatten(&mut self.piece);
    }

    /// Makes each the other's twin, and says whether they run the same way.
    fn join(&mut self, triangles: &[[u32; 3]], a: HalfEdge, b: HalfEdge) -> bool {
        let start = |h| ends(triangles, h)[0];
        let flipped = start(a) == start(b);
        self.winds_differently |= flipped;
        self.twins[a as usize] = Twin::new(b, flipped);
        self.twins[b as usize] = Twin::new(a, flipped);
        unite(&mut self.walkable, a / 3, b / 3);
        flipped
    }
}

pub(super) fn ends(triangles: &[[u32; 3]], half_edge: HalfEdge) -> [u32; 2] {
    let (corners, k) = (triangles[half_edge as usize / 3], half_edge as usize % 3);
    [corners[k], corners[(k + 1) % 3]]
}

/// Root of a node in a union-find forest, halving the path on the way.
fn root(parents: &mut [u32], mut node: u32) -> u32 {
    while parents[node as usize] != node {
        parents[node as usize] = parents[parents[node as usize] as usize];
        node = parents[node as usize];
    }
    node
}

/// Makes one set of two; the lower root stands for both.
pub(super) fn unite(parents: &mut [u32], a: u32, b: u32) {
    let (a, b) = (root(parents, a), root(parents, b));
    parents[a.max(b) as usize] = a.min(b);
}

/// Points every node straight at its root, which is the lowest number of its set.
pub(super) fn flatten(parents: &mut [u32]) {
    for node in 0..parents.len() as u32 {
        parents[node as usize] = root(parents, node);
    }
}
