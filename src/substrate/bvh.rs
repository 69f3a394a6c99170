//! Spatial queries over the triangles: a binary BVH built by `obvhs`, walked in f64.
//!
//! `obvhs` is f32 only and has no closest-point query. Its boxes are padded by a few units in the
//! last place, so that they hold the f64 triangles, and the queries below go over its public
//! nodes.

use glam::{DVec3, Vec3A};
use obvhs::aabb::Aabb;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::leaf_collapser::collapse;
use obvhs::ploc::{PlocBuilder, PlocSearchDistance, SortPrecision};
use rayon::prelude::*;

/// A bounding volume hierarchy over triangles in local units.
pub(super) struct Bvh {
    tree: Bvh2,
}

/// Triangles in a leaf, at most.
const LEAF: u32 = 4;

impl Bvh {
    pub(super) fn new(vertices: &[DVec3], triangles: &[[u32; 3]]) -> Self {
        let boxes: Vec<Aabb> = {
            let boxes = triangles.par_iter();
            boxes.map(|t| padded_box(vertices, t)).collect()
        };
        let indices = (0..boxes.len() as u32).collect();
        let mut tree = PlocBuilder::with_capacity(boxes.len()).build(
            PlocSearchDistance::Minimum,
            &boxes,
            indices,
            SortPrecision::U64,
            0,
        );
        drop(boxes);
        collapse(&mut tree, LEAF, 2.0);
        tree.nodes.shrink_to_fit();
        Self { tree }
    }

    /// Calls `leaf` with the triangles of every leaf whose box passes `enter`.
    pub(super) fn visit(&self, enter: impl Fn(&Aabb) -> bool, mut leaf: impl FnMut(u32)) {
        let mut stack = vec![0usize];
        while let Some(i) = stack.pop() {
            let Some(node) = self.tree.nodes.get(i) else {
                continue;
            };
            if !enter(node.aabb()) {
                continue;
            }
            let first = node.first_index as usize;
            if node.is_leaf() {
                let end = first + node.prim_count as usize;
                self.tree.primitive_indices[first..end]
                    .iter()
                    .for_each(|&t| leaf(t));
            } else {
                stack.extend([first + 1, first]);
            }
        }
    }

    /// The triangle that minimises `distance_sq`, and that value; ties go to the lower number.
    pub(super) fn nearest(
        &self,
        p: DVec3,
        mut distance_sq: impl FnMut(u32) -> f64,
    ) -> Option<(u32, f64)> {
        let mut best: Option<(u32, f64)> = None;
        let mut stack = vec![(0usize, 0.0)];
        while let Some((i, bound)) = stack.pop() {
            let Some(node) = self.tree.nodes.get(i) else {
                continue;
            };
            if best.is_some_and(|(_, d)| bound > d) {
                continue;
            }
            let first = node.first_index as usize;
            if node.is_leaf() {
                let end = first + node.prim_count as usize;
                for &t in &self.tree.primitive_indices[first..end] {
                    let d = distance_sq(t);
                    if best.is_none_or(|(n, least)| d < least || (d == least && t < n)) {
                        best = Some((t, d));
                    }
                }
            } else {
                let [a, b] =
                    [first, first + 1].map(|c| (c, box_distance_sq(self.tree.nodes[c].aabb(), p)));
                stack.extend(if a.1 < b.1 { [b, a] } else { [a, b] });
            }
        }
        best
    }
}

fn padded_box(vertices: &[DVec3], t: &[u32; 3]) -> Aabb {
    let [a, b, c] = t.map(|i| vertices[i as usize]);
    let (min, max) = (a.min(b).min(c), a.max(b).max(c));
    let pad = Vec3A::splat(4.0 * f32::EPSILON);
    Aabb::new(min.as_vec3a() - pad, max.as_vec3a() + pad)
}

/// Squared distance from a point to the nearest point of a box.
pub(super) fn box_distance_sq(aabb: &Aabb, p: DVec3) -> f64 {
    let (min, max) = (aabb.min.as_dvec3(), aabb.max.as_dvec3());
    (p - p.clamp(min, max)).length_squared()
}

/// Squared distance from a point to the farthest corner of a box.
pub(super) fn box_farthest_sq(aabb: &Aabb, p: DVec3) -> f64 {
    let (min, max) = (aabb.min.as_dvec3(), aabb.max.as_dvec3());
    (p - min).abs().max((p - max).abs()).length_squared()
}
