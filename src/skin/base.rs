//! The part of the substrate that carries lichen, as an oriented 2-manifold with boundary.
//!
//! A substrate may be wound inconsistently, may not be orientable, and may have vertices where
//! several sheets touch. Here every triangle is wound as the substrate has [settled](crate::substrate::Winding); where
//! no winding agrees (a Möbius band) the surface is cut along an edge; and a vertex is as many vertices
//! as it has fans of triangles.

use glam::DVec3;

use crate::substrate::Substrate;

/// No vertex, no triangle.
pub(super) const NONE: u32 = u32::MAX;

/// A triangle of the surface that is being cut finer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Face {
    /// Numbers of vertices, counter-clockwise from outside.
    pub(super) corners: [u32; 3],
    /// The substrate's triangle that it is part of.
    pub(super) home: u32,
    /// The number of the triangle that it was cut from.
    pub(super) parent: u32,
    /// Bit k: the side from corner k to the next is an open edge of the surface.
    pub(super) open: u8,
    /// It is there for lichens of so many elements, and until they have so many.
    pub(super) life: [u32; 2],
}

/// Triangles, and where their vertices are.
#[derive(Debug, Default)]
pub(super) struct Base {
    pub(super) positions: Vec<DVec3>,
    /// For each vertex a substrate triangle that it lies on.
    pub(super) homes: Vec<u32>,
    pub(super) faces: Vec<Face>,
}

impl Base {
    /// Of these triangles of a substrate, ascending. Edges to others count as closed.
    pub(super) fn new(substrate: &Substrate, triangles: &[u32]) -> Self {
        let mut base = Self::default();
        let corners = base.split_fans(substrate, triangles);
        let winding = substrate.winding();
        let face = |(&t, c): (&u32, &[u32; 3])| {
            let open = [0, 1, 2].map(|k| winding.is_open(substrate, 3 * t + k));
            let face = Face {
                corners: *c,
                home: t,
                parent: NONE,
                open: bits(open),
                life: [0, NONE],
            };
            if winding.side(t) > 0.0 {
                face
            } else {
                face.turned()
            }
        };
        base.faces = triangles.iter().zip(&corners).map(face).collect();
        base
    }

    /// A vertex for each fan of triangles: for each triangle those of its corners, as the substrate
    /// orders them.
    fn split_fans(&mut self, substrate: &Substrate, triangles: &[u32]) -> Vec<[u32; 3]> {
        let mut corners = vec![[NONE; 3]; triangles.len()];
        for (i, &t) in triangles.iter().enumerate() {
            for k in 0..3 {
                if corners[i][k] != NONE {
                    continue;
                }
                let vertex = self.positions.len() as u32;
                self.positions.push(substrate.corners(t)[k]);
                self.homes.push(t);
                let mut stack = vec![3 * t + k as u32];
                while let Some(corner) = stack.pop() {
                    let Ok(place) = triangles.binary_search(&(corner / 3)) else {
                        continue;
                    };
                    let slot = &mut corners[place][corner as usize % 3];
                    if *slot == NONE {
                        *slot = vertex;
                        stack.extend(beside(substrate, corner));
                    }
                }
            }
        }
        corners
    }
}

/// The corners at the same vertex in the triangles across the two edges that meet there.
fn beside(substrate: &Substrate, corner: u32) -> impl Iterator<Item = u32> {
    let (first, k) = (corner / 3 * 3, corner % 3);
    // The edge that leaves the vertex, and the one that comes to it.
    let edges = [(corner, true), (first + (k + 2) % 3, false)];
    let across = |(edge, leaves): (u32, bool)| {
        let twin = substrate.twin(edge);
        let other = twin.half_edge();
        let next = other / 3 * 3 + (other % 3 + 1) % 3;
        // A twin that is not flipped runs the other way.
        let corner = if leaves == twin.is_flipped() {
            other
        } else {
            next
        };
        let is_open = substrate.winding().is_open(substrate, edge);
        (!is_open).then_some(corner)
    };
    edges.map(across).into_iter().flatten()
}

impl Face {
    /// Whether it is there for a lichen of so many elements.
    pub(super) fn lives(&self, elements: u32) -> bool {
        (self.life[0]..self.life[1]).contains(&elements)
    }

    /// The same, wound the other way.
    fn turned(self) -> Self {
        let [a, b, c] = self.corners;
        let open = [0, 1, 2].map(|k| self.open >> k & 1 == 1);
        Self {
            corners: [a, c, b],
            open: bits([open[2], open[1], open[0]]),
            ..self
        }
    }
}

/// Truths as bits, the first lowest.
pub(super) fn bits(truths: [bool; 3]) -> u8 {
    u8::from(truths[0]) | u8::from(truths[1]) << 1 | u8::from(truths[2]) << 2
}
