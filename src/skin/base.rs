//! The part of the substrate that carries lichen, as an oriented 2-manifold with boundary.
//!
//! A substrate may be wound inconsistently, may not be orientable, and may have vertices where
//! several sheets touch. Here every triangle runs the way that most of its component does, by area;
//! where that cannot be had (a Möbius band) the surface is cut along an edge; and a vertex is as
//! many vertices as it has fans of triangles.

use glam::DVec3;

use crate::substrate::{Component, Substrate};

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

/// Which way each triangle of a substrate is wound, against its file: false where it is turned.
pub(super) struct Winding {
    kept: Vec<bool>,
    /// Half-edges along which no choice agrees.
    cut: Vec<u32>,
}

impl Winding {
    pub(super) fn of(substrate: &Substrate) -> Self {
        let mut winding = Self {
            kept: vec![true; substrate.triangles().len()],
            cut: Vec::new(),
        };
        let mut seen = vec![false; winding.kept.len()];
        for component in substrate.components() {
            winding.settle(substrate, component, &mut seen);
        }
        winding.cut.sort_unstable();
        winding
    }

    /// Follows the edges of a component from its first triangle, then turns all of it if most of
    /// it, by area, is against the file.
    fn settle(&mut self, substrate: &Substrate, component: &Component, seen: &mut [bool]) {
        let mut stack = vec![component.triangles.start];
        seen[component.triangles.start as usize] = true;
        while let Some(t) = stack.pop() {
            for h in 3 * t..3 * t + 3 {
                let twin = substrate.twin(h);
                let other = twin.half_edge() / 3;
                if !seen[other as usize] {
                    seen[other as usize] = true;
                    self.kept[other as usize] = self.kept[t as usize] != twin.is_flipped();
                    stack.push(other);
                }
            }
        }
        self.cut_and_turn(substrate, component);
    }

    fn cut_and_turn(&mut self, substrate: &Substrate, component: &Component) {
        let mut turned = 0.0;
        for t in component.triangles.clone() {
            for h in 3 * t..3 * t + 3 {
                let twin = substrate.twin(h);
                let agrees = self.kept[t as usize] == self.kept[(twin.half_edge() / 3) as usize];
                if twin.half_edge() != h && agrees == twin.is_flipped() {
                    self.cut.push(h);
                }
            }
            turned += if self.kept[t as usize] {
                0.0
            } else {
                substrate.area(t)
            };
        }
        if turned > 0.5 * component.area {
            let range = component.triangles.start as usize..component.triangles.end as usize;
            self.kept[range].iter_mut().for_each(|kept| *kept = !*kept);
        }
    }

    /// 1 where a triangle is wound as in its file, −1 where it is turned.
    pub(super) fn side(&self, triangle: u32) -> f64 {
        match self.kept[triangle as usize] {
            true => 1.0,
            false => -1.0,
        }
    }

    /// The unit normal of a triangle by this winding.
    pub(super) fn normal(&self, substrate: &Substrate, triangle: u32) -> DVec3 {
        self.side(triangle) * substrate.normal(triangle)
    }

    fn is_open(&self, substrate: &Substrate, half_edge: u32) -> bool {
        substrate.twin(half_edge).half_edge() == half_edge
            || self.cut.binary_search(&half_edge).is_ok()
    }
}

impl Base {
    /// Of these triangles of a substrate, ascending. Edges to others count as closed.
    pub(super) fn new(substrate: &Substrate, winding: &Winding, triangles: &[u32]) -> Self {
        let mut base = Self::default();
        let corners = base.split_fans(substrate, winding, triangles);
        let face = |(&t, c): (&u32, &[u32; 3])| {
            let open = [0, 1, 2].map(|k| winding.is_open(substrate, 3 * t + k));
            let face = Face {
                corners: *c,
                home: t,
                parent: NONE,
                open: bits(open),
                life: [0, NONE],
            };
            if winding.kept[t as usize] {
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
    fn split_fans(
        &mut self,
        substrate: &Substrate,
        winding: &Winding,
        triangles: &[u32],
    ) -> Vec<[u32; 3]> {
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
                        stack.extend(beside(substrate, winding, corner));
                    }
                }
            }
        }
        corners
    }
}

/// The corners at the same vertex in the triangles across the two edges that meet there.
fn beside(substrate: &Substrate, winding: &Winding, corner: u32) -> impl Iterator<Item = u32> {
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
        (!winding.is_open(substrate, edge)).then_some(corner)
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
