//! Where the surface ends: lichen is cut off there, has no margin of its own, and has neighbours on one side alone.
//!
//! A disc may not lie beyond a border, as if the lichen went on there like its mirror image. It is enough to mirror
//! each element by itself: that takes away just those directions in which the centre of a disc at its edge would lie
//! beyond the border.

use std::collections::HashMap;

use glam::{DVec3, I64Vec3, Vec3};

use super::base::Winding;
use crate::substrate::Substrate;

/// The open edges of a substrate, to be found by place.
pub(super) struct Borders {
    edges: Vec<Edge>,
    /// The edges that come near each cell.
    cells: HashMap<I64Vec3, Vec<u32>>,
    /// Side of a cell, and how far mirror images are looked for.
    within: f64,
}

struct Edge {
    ends: [DVec3; 2],
    /// Of the surface beside it.
    normal: Vec3,
}

/// Surfaces whose normals differ by more than 60° are others.
const SAME_SHEET: f32 = 0.5;

impl Borders {
    /// For mirror images no farther than this, local units.
    pub(super) fn new(substrate: &Substrate, winding: &Winding, within: f64) -> Self {
        let open = |h: &u32| substrate.twin(*h).half_edge() == *h;
        let edge = |h: u32| {
            let (corners, k) = (substrate.corners(h / 3), h as usize % 3);
            Edge {
                ends: [corners[k], corners[(k + 1) % 3]],
                normal: winding.normal(substrate, h / 3).as_vec3(),
            }
        };
        let all = 0..3 * substrate.triangles().len() as u32;
        let edges: Vec<Edge> = all.filter(open).map(edge).collect();
        let mut cells: HashMap<I64Vec3, Vec<u32>> = HashMap::new();
        for (number, Edge { ends: [a, b], .. }) in edges.iter().enumerate() {
            let steps = (a.distance(*b) / (0.5 * within)).ceil().max(1.0) as usize;
            for step in 0..=steps {
                let place = a.lerp(*b, step as f64 / steps as f64);
                let listed = cells.entry(cell(place, within)).or_default();
                if listed.last() != Some(&(number as u32)) {
                    listed.push(number as u32);
                }
            }
        }
        Self {
            edges,
            cells,
            within,
        }
    }

    /// The ways from a place on the surface, with its normal there, to its mirror images beyond borders.
    pub(super) fn mirrored(&self, place: DVec3, normal: Vec3) -> Vec<DVec3> {
        if self.edges.is_empty() {
            return Vec::new();
        }
        let at = cell(place, self.within);
        let beside = (0..27).map(|i| I64Vec3::new(i % 3, i / 3 % 3, i / 9) - 1);
        let listed = beside.filter_map(|step| self.cells.get(&(at + step)));
        let mut near: Vec<u32> = listed.flatten().copied().collect();
        near.sort_unstable();
        near.dedup();
        let way = |&number: &u32| {
            let edge = &self.edges[number as usize];
            let way = 2.0 * (nearest_on(edge.ends, place) - place);
            let counts = edge.normal.dot(normal) > SAME_SHEET && way.length() <= self.within;
            counts.then_some(way)
        };
        near.iter().filter_map(way).collect()
    }

    /// The share of a disc about a place that is surface, where the nearest border runs straight.
    pub(super) fn share(&self, place: DVec3, normal: Vec3, radius: f64) -> f64 {
        let ways = self.mirrored(place, normal).into_iter();
        let nearest = ways.map(|way| 0.5 * way.length()).fold(radius, f64::min);
        let x = nearest / radius;
        1.0 - (libm::acos(x) - x * (1.0 - x * x).sqrt()) / std::f64::consts::PI
    }
}

fn cell(place: DVec3, size: f64) -> I64Vec3 {
    (place / size).floor().as_i64vec3()
}

fn nearest_on([a, b]: [DVec3; 2], p: DVec3) -> DVec3 {
    let along = (p - a).dot(b - a) / (b - a).length_squared();
    a.lerp(b, along.clamp(0.0, 1.0))
}
