//! The part of the substrate that carries lichen, as an oriented 2-manifold with boundary.
//!
//! A substrate may be wound inconsistently, may not be orientable, and may have vertices where
//! several sheets touch. Here every triangle is wound as the substrate has [settled](crate::substrate::Winding); where
//! no winding agrees (a Möbius band) the surface is cut along an edge; and a vertex is as many vertices
//! as it has fans of triangles. Where three sheets or more meet along a line, and a fan goes from one to another along
//! one edge and comes back along the next, the sheets are cut apart there.

use std::iter::zip;

use glam::DVec3;
use rayon::prelude::*;
use rustc_hash::{FxHashMap, FxHashSet};

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
        let whole = Sheets {
            substrate,
            cut: FxHashSet::default(),
        };
        let base = Self::of(&whole, triangles);
        let crowded = base.crowded(substrate);
        if crowded.is_empty() {
            return base;
        }
        let apart = Sheets {
            substrate,
            cut: branching(substrate, triangles, &crowded),
        };
        let cut = Self::of(&apart, triangles);
        // Where the sheets are one round the ends of an edge they cannot be told apart by their vertices.
        match cut.crowded(substrate).is_empty() {
            true => cut,
            false => base,
        }
    }

    fn of(sheets: &Sheets, triangles: &[u32]) -> Self {
        let mut base = Self::default();
        let corners = base.split_fans(sheets, triangles);
        let face = |(&t, c): (&u32, &[u32; 3])| {
            let open = [0, 1, 2].map(|k| sheets.is_open(3 * t + k));
            let face = Face {
                corners: *c,
                home: t,
                parent: NONE,
                open: bits(open),
                life: [0, NONE],
            };
            if sheets.substrate.winding().side(t) > 0.0 {
                face
            } else {
                face.turned()
            }
        };
        base.faces = triangles.iter().zip(&corners).map(face).collect();
        base
    }

    /// The substrate's vertices at the ends of sides that have the same ends as too many others: more than one, or an
    /// open one.
    fn crowded(&self, substrate: &Substrate) -> FxHashSet<u32> {
        let mut crowded = FxHashSet::default();
        if substrate.report().non_manifold_edges == 0 {
            return crowded;
        }
        let is_open = |side: u32| self.faces[side as usize / 3].open >> (side % 3) & 1 == 1;
        for sides in self.sides().chunk_by(|a, b| a.0 == b.0) {
            let is_pair = sides.len() == 2 && !sides.iter().any(|(_, side)| is_open(*side));
            if sides.len() == 1 || is_pair {
                continue;
            }
            let ends = sides[0].0.map(|v| self.positions[v as usize]);
            for home in sides
                .iter()
                .map(|(_, side)| self.faces[*side as usize / 3].home)
            {
                let corners = substrate.triangles()[home as usize];
                let at = zip(corners, substrate.corners(home));
                crowded.extend(at.filter(|(_, p)| ends.contains(p)).map(|(v, _)| v));
            }
        }
        crowded
    }

    /// The sides of all faces in the order of their ends, the lower first: three numbers for each face.
    fn sides(&self) -> Vec<([u32; 2], u32)> {
        let side = |side: u32| {
            let (corners, k) = (self.faces[side as usize / 3].corners, side as usize % 3);
            let [a, b] = [corners[k], corners[(k + 1) % 3]];
            ([a.min(b), a.max(b)], side)
        };
        let all = 0..3 * self.faces.len() as u32;
        let mut sides: Vec<_> = all.into_par_iter().map(side).collect();
        sides.par_sort_unstable();
        sides
    }

    /// A vertex for each fan of triangles: for each triangle those of its corners, as the substrate
    /// orders them.
    fn split_fans(&mut self, sheets: &Sheets, triangles: &[u32]) -> Vec<[u32; 3]> {
        let mut corners = vec![[NONE; 3]; triangles.len()];
        for (i, &t) in triangles.iter().enumerate() {
            for k in 0..3 {
                if corners[i][k] != NONE {
                    continue;
                }
                let vertex = self.positions.len() as u32;
                self.positions.push(sheets.substrate.corners(t)[k]);
                self.homes.push(t);
                let mut stack = vec![3 * t + k as u32];
                while let Some(corner) = stack.pop() {
                    let Ok(place) = triangles.binary_search(&(corner / 3)) else {
                        continue;
                    };
                    let slot = &mut corners[place][corner as usize % 3];
                    if *slot == NONE {
                        *slot = vertex;
                        stack.extend(sheets.beside(corner));
                    }
                }
            }
        }
        corners
    }
}

/// A substrate's sheets, as they go on across edges.
struct Sheets<'a> {
    substrate: &'a Substrate,
    /// Half-edges across which they do not, besides those where none does.
    cut: FxHashSet<u32>,
}

impl Sheets<'_> {
    fn is_open(&self, half_edge: u32) -> bool {
        let winding = self.substrate.winding();
        winding.is_open(self.substrate, half_edge) || self.cut.contains(&half_edge)
    }

    /// The corners at the same vertex in the triangles across the two edges that meet there.
    fn beside(&self, corner: u32) -> impl Iterator<Item = u32> {
        let (first, k) = (corner / 3 * 3, corner % 3);
        // The edge that leaves the vertex, and the one that comes to it.
        let edges = [(corner, true), (first + (k + 2) % 3, false)];
        let across = |(edge, leaves): (u32, bool)| {
            let twin = self.substrate.twin(edge);
            let other = twin.half_edge();
            let next = other / 3 * 3 + (other % 3 + 1) % 3;
            // A twin that is not flipped runs the other way.
            let corner = if leaves == twin.is_flipped() {
                other
            } else {
                next
            };
            (!self.is_open(edge)).then_some(corner)
        };
        edges.map(across).into_iter().flatten()
    }
}

/// The half-edges at these vertices along which three triangles or more meet.
fn branching(
    substrate: &Substrate,
    triangles: &[u32],
    vertices: &FxHashSet<u32>,
) -> FxHashSet<u32> {
    let mut along: FxHashMap<[u32; 2], Vec<u32>> = FxHashMap::default();
    for &t in triangles {
        let corners = substrate.triangles()[t as usize];
        for k in 0..3 {
            let [a, b] = [corners[k], corners[(k + 1) % 3]];
            if vertices.contains(&a) || vertices.contains(&b) {
                let ends = [a.min(b), a.max(b)];
                along.entry(ends).or_default().push(3 * t + k as u32);
            }
        }
    }
    let many = along
        .into_values()
        .filter(|half_edges| half_edges.len() > 2);
    many.flatten().collect()
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
