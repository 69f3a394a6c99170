//! Trees whose boxes have up to four boxes in them, and shapes in groups of four: a ray meets four
//! at once. Rays that leave a place in any direction have too little in common to go together,
//! and a binary tree makes them wait for memory at twice as many steps.

use glam::{BVec4A, Vec3A, Vec4};
use obvhs::aabb::Aabb;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::leaf_collapser::collapse;
use obvhs::bvh2::node::Bvh2Node;
use obvhs::bvh2::reinsertion::ReinsertionOptimizer;
use obvhs::fast_stack;
use obvhs::faststack::FastStack;
use obvhs::ploc::{PlocBuilder, PlocSearchDistance, SortPrecision};

/// Boxes in a box, and shapes in a group, at most.
pub(super) const WIDTH: usize = 4;

/// Four vectors, by coordinates.
#[derive(Clone, Copy)]
pub(super) struct Lanes {
    x: Vec4,
    y: Vec4,
    z: Vec4,
}

impl Lanes {
    pub(super) fn new(lanes: [Vec3A; WIDTH]) -> Self {
        let along = |axis: usize| Vec4::from_array(lanes.map(|v| v[axis]));
        Self {
            x: along(0),
            y: along(1),
            z: along(2),
        }
    }

    const fn all(x: f32) -> Self {
        Self {
            x: Vec4::splat(x),
            y: Vec4::splat(x),
            z: Vec4::splat(x),
        }
    }

    /// The same vector four times.
    pub(super) fn splat(v: Vec3A) -> Self {
        Self::new([v; WIDTH])
    }

    pub(super) fn get(&self, lane: usize) -> Vec3A {
        Vec3A::new(self.x[lane], self.y[lane], self.z[lane])
    }

    pub(super) fn dot(self, other: Self) -> Vec4 {
        self.x * other.x + self.y * other.y + self.z * other.z
    }

    pub(super) fn cross(self, other: Self) -> Self {
        Self {
            x: self.y * other.z - self.z * other.y,
            y: self.z * other.x - self.x * other.z,
            z: self.x * other.y - self.y * other.x,
        }
    }

    pub(super) fn minus(self, other: Self) -> Self {
        Self {
            x: self.x - other.x,
            y: self.y - other.y,
            z: self.z - other.z,
        }
    }

    /// This, and so many times the other.
    pub(super) fn plus(self, share: Vec4, other: Self) -> Self {
        Self {
            x: self.x + share * other.x,
            y: self.y + share * other.y,
            z: self.z + share * other.z,
        }
    }
}

/// A ray, ready to meet four things at once.
#[derive(Clone)]
pub(super) struct Ray {
    pub(super) origin: Lanes,
    /// Of length 1.
    pub(super) direction: Lanes,
    inverse: Lanes,
    /// Along each axis, whether it goes down.
    falls: [usize; 3],
    /// How far it goes.
    pub(super) end: f32,
}

impl Ray {
    /// From an origin in a direction of length 1, without end.
    pub(super) fn new(origin: Vec3A, direction: Vec3A) -> Self {
        let inverse = direction.map(|x| 1.0 / x.abs().max(1e-30).copysign(x));
        Self {
            origin: Lanes::splat(origin),
            direction: Lanes::splat(direction),
            inverse: Lanes::splat(inverse),
            falls: inverse.to_array().map(|x| usize::from(x < 0.0)),
            end: f32::INFINITY,
        }
    }

    /// The same from another origin.
    pub(super) fn starting_at(mut self, origin: Vec3A) -> Self {
        self.origin = Lanes::splat(origin);
        self
    }

    /// Which boxes it meets, and where it enters each.
    #[inline]
    fn enter(&self, node: &Node) -> (BVec4A, Vec4) {
        let (o, i) = (&self.origin, &self.inverse);
        let [x, y, z] = self.falls;
        let x0 = (node.bounds[x].x - o.x) * i.x;
        let y0 = (node.bounds[y].y - o.y) * i.y;
        let z0 = (node.bounds[z].z - o.z) * i.z;
        let x1 = (node.bounds[1 - x].x - o.x) * i.x;
        let y1 = (node.bounds[1 - y].y - o.y) * i.y;
        let z1 = (node.bounds[1 - z].z - o.z) * i.z;
        let near = x0.max(y0).max(z0.max(Vec4::ZERO));
        let far = x1.min(y1).min(z1.min(Vec4::splat(self.end)));
        (near.cmple(far), near)
    }
}

/// Up to four boxes.
struct Node {
    /// Least and greatest corners; turned inside out where there is no box, so that no ray meets it.
    bounds: [Lanes; 2],
    /// What is in each: a node, or, with the highest bit set, a group of shapes.
    inside: [u32; WIDTH],
}

const GROUP: u32 = 1 << 31;

/// A tree over groups of shapes.
#[derive(Default)]
pub(super) struct Tree {
    nodes: Vec<Node>,
    /// The most nodes that wait while one is looked at.
    most_waiting: usize,
}

/// The numbers of the shapes in a group; the last is repeated where there are fewer.
pub(super) type Group = [u32; WIDTH];

/// Trees up to this size are made better at the price of time, which their rays repay.
pub(super) const WORTH_OPTIMIZING: usize = 400_000;

impl Tree {
    /// Of the shapes in these boxes, and the groups that they fall into.
    pub(super) fn new(boxes: &[Aabb]) -> (Self, Vec<Group>) {
        Self::grouped(boxes, WIDTH)
    }

    /// The same, where so many shapes at most make a group.
    pub(super) fn grouped(boxes: &[Aabb], most: usize) -> (Self, Vec<Group>) {
        if boxes.is_empty() {
            return Default::default();
        }
        let binary = binary(boxes, most);
        let mut tree = Self {
            nodes: Vec::with_capacity(binary.nodes.len() / 3),
            most_waiting: 1,
        };
        let mut groups = Vec::with_capacity(boxes.len() / 2);
        // What is to be copied, where to, and what may wait meanwhile.
        let mut copied = vec![(widened(&binary, &[binary.nodes[0]]), 0, 0)];
        tree.nodes.push(Node::EMPTY);
        while let Some((children, at, above)) = copied.pop() {
            let waiting = above + children.len();
            tree.most_waiting = tree.most_waiting.max(waiting);
            for (lane, child) in children.iter().enumerate() {
                let inside = if child.is_leaf() {
                    groups.push(group(&binary, child));
                    GROUP | (groups.len() - 1) as u32
                } else {
                    tree.nodes.push(Node::EMPTY);
                    let number = tree.nodes.len() - 1;
                    copied.push((widened(&binary, inner(&binary, child)), number, waiting - 1));
                    number as u32
                };
                tree.nodes[at].put(lane, [child.min, child.max].map(Vec3A::from), inside);
            }
        }
        (tree, groups)
    }

    /// Calls `meet` with the groups whose boxes a ray meets as far as it goes, which `meet` may
    /// shorten: the nearer first of those in one node.
    pub(super) fn meet(&self, ray: &mut Ray, mut meet: impl FnMut(&mut Ray, usize)) {
        fast_stack!((u32, f32), (48, 192), self.most_waiting, waiting, {
            if !self.nodes.is_empty() {
                waiting.push((0, 0.0));
            }
            while let Some((next, from)) = waiting.pop() {
                if from > ray.end {
                    continue;
                }
                if next & GROUP != 0 {
                    meet(ray, (next & !GROUP) as usize);
                    continue;
                }
                let node = &self.nodes[next as usize];
                let (met, near) = ray.enter(node);
                node.queue(met, near, &mut waiting);
            }
        });
    }

    /// Whether `is_met` says so of any group whose box a ray meets.
    pub(super) fn any(&self, ray: &Ray, is_met: impl Fn(&Ray, usize) -> bool) -> bool {
        fast_stack!(u32, (48, 192), self.most_waiting, waiting, {
            if !self.nodes.is_empty() {
                waiting.push(0);
            }
            while let Some(next) = waiting.pop() {
                let node = &self.nodes[next as usize];
                let mut met = ray.enter(node).0.bitmask();
                while met != 0 {
                    let inside = node.inside[met.trailing_zeros() as usize];
                    met &= met - 1;
                    if inside & GROUP == 0 {
                        waiting.push(inside);
                    } else if is_met(ray, (inside & !GROUP) as usize) {
                        return true;
                    }
                }
            }
            false
        })
    }
}

impl Node {
    const EMPTY: Self = Self {
        bounds: [Lanes::all(f32::INFINITY), Lanes::all(f32::NEG_INFINITY)],
        inside: [0; WIDTH],
    };

    fn put(&mut self, lane: usize, corners: [Vec3A; 2], inside: u32) {
        for (bound, corner) in self.bounds.iter_mut().zip(corners) {
            bound.x[lane] = corner.x;
            bound.y[lane] = corner.y;
            bound.z[lane] = corner.z;
        }
        self.inside[lane] = inside;
    }

    /// Has what is in the boxes that are met wait, the nearest to come first.
    #[inline(always)]
    fn queue(&self, met: BVec4A, near: Vec4, waiting: &mut impl FastStack<(u32, f32)>) {
        let (mut met, near) = (met.bitmask(), near.to_array());
        if met.is_power_of_two() {
            let lane = met.trailing_zeros() as usize % WIDTH;
            return waiting.push((self.inside[lane], near[lane]));
        }
        let mut found = [(0, 0.0); WIDTH];
        let mut count = 0;
        while met != 0 {
            let lane = met.trailing_zeros() as usize % WIDTH;
            met &= met - 1;
            let mut at = count;
            while at > 0 && found[at - 1].1 < near[lane] {
                found[at] = found[at - 1];
                at -= 1;
            }
            found[at] = (self.inside[lane], near[lane]);
            count += 1;
        }
        found[..count].iter().for_each(|&f| waiting.push(f));
    }
}

/// Boxes that rays may go through.
pub(super) struct Boxes {
    tree: Tree,
    groups: Vec<Node>,
}

impl Boxes {
    pub(super) fn new(boxes: &[Aabb]) -> Self {
        let (tree, groups) = Tree::new(boxes);
        let of = |group: &Group| {
            let mut node = Node::EMPTY;
            for (lane, &i) in group.iter().enumerate() {
                let Aabb { min, max } = boxes[i as usize];
                node.put(lane, [min, max], 0);
            }
            node
        };
        let groups = groups.iter().map(of).collect();
        Self { tree, groups }
    }

    /// Whether a ray meets any, as far as it goes.
    pub(super) fn are_met(&self, ray: &Ray) -> bool {
        let is_met = |ray: &Ray, group: usize| ray.enter(&self.groups[group]).0.any();
        self.tree.any(ray, is_met)
    }
}

fn binary(boxes: &[Aabb], most: usize) -> Bvh2 {
    let indices = (0..boxes.len() as u32).collect();
    let mut tree = PlocBuilder::with_capacity(boxes.len()).build(
        PlocSearchDistance::Low,
        boxes,
        indices,
        SortPrecision::U64,
        0,
    );
    if boxes.len() <= WORTH_OPTIMIZING {
        ReinsertionOptimizer::default().run(&mut tree, 0.1, None);
    }
    collapse(&mut tree, most as u32, 1.0);
    tree
}

fn inner<'a>(tree: &'a Bvh2, node: &Bvh2Node) -> &'a [Bvh2Node] {
    &tree.nodes[node.first_index as usize..][..2]
}

/// Up to four boxes in place of one or two: the largest is replaced by those in it, again and again.
fn widened(tree: &Bvh2, children: &[Bvh2Node]) -> Vec<Bvh2Node> {
    let mut wide = children.to_vec();
    while wide.len() < WIDTH {
        let inner_ones = (0..wide.len()).filter(|&k| !wide[k].is_leaf());
        let area = |k: &usize| wide[*k].aabb().half_area();
        let Some(largest) = inner_ones.max_by(|a, b| area(a).total_cmp(&area(b))) else {
            break;
        };
        let node = wide.swap_remove(largest);
        wide.extend_from_slice(inner(tree, &node));
    }
    wide
}

fn group(tree: &Bvh2, leaf: &Bvh2Node) -> Group {
    let first = leaf.first_index as usize;
    let last = leaf.prim_count as usize - 1;
    std::array::from_fn(|lane| tree.primitive_indices[first + lane.min(last)])
}

#[cfg(test)]
mod tests {
    use super::super::sample::{hash, unit};
    use super::*;
    use crate::picture::shape::{Triangles, triangle_box};

    /// Numbers from -1 to 1.
    fn random(seed: u32) -> impl FnMut() -> f32 {
        let mut at = seed;
        move || {
            at += 1;
            2.0 * unit(hash(at)) - 1.0
        }
    }

    fn point(next: &mut impl FnMut() -> f32) -> Vec3A {
        Vec3A::new(next(), next(), next())
    }

    /// Where a ray meets a triangle, by the plane and the sides of the point in it.
    fn distance(origin: Vec3A, direction: Vec3A, [a, b, c]: [Vec3A; 3]) -> Option<f32> {
        let normal = (b - a).cross(c - a);
        let t = (a - origin).dot(normal) / direction.dot(normal);
        let p = origin + direction * t;
        let side = |from: Vec3A, to: Vec3A| (to - from).cross(p - from).dot(normal);
        let inside = side(a, b).min(side(b, c)).min(side(c, a));
        (t > 0.0 && inside > 0.0).then_some(t)
    }

    /// For sets from none to many, some triangles in one place and all sizes; also along the axes.
    #[test]
    fn rays_meet_what_a_search_through_all_finds() {
        for count in [0, 1, 2, 3, 5, 40, 2000] {
            let mut next = random(1000 * count);
            let triangle = |i: u32| {
                let middle = if i.is_multiple_of(7) {
                    Vec3A::ZERO
                } else {
                    point(&mut next)
                };
                let size = if i.is_multiple_of(11) { 1.0 } else { 0.1 };
                [(); 3].map(|()| middle + size * point(&mut next))
            };
            let shapes: Vec<[Vec3A; 3]> = (0..count).map(triangle).collect();
            let boxes: Vec<Aabb> = shapes.iter().map(triangle_box).collect();
            let (tree, groups) = Tree::new(&boxes);
            let four = |g: &Group| Triangles::new(*g, g.map(|i| shapes[i as usize]));
            let groups: Vec<Triangles> = groups.iter().map(four).collect();
            let mut met = 0;
            for k in 0..500 {
                let origin = 2.0 * point(&mut next);
                let to = 0.5 * point(&mut next);
                let direction = match k % 10 {
                    0 => Vec3A::NEG_Y,
                    _ => (to - origin).normalize(),
                };
                let all = shapes.iter();
                let expected = all.filter_map(|s| distance(origin, direction, *s));
                let expected = expected.reduce(f32::min);
                let mut ray = Ray::new(origin, direction);
                let blocks = tree.any(&ray, |ray, g| groups[g].block(ray));
                tree.meet(&mut ray, |ray, g| {
                    ray.end = groups[g].first(ray).map_or(ray.end, |t| t.at);
                });
                assert_eq!(blocks, ray.end < f32::INFINITY);
                met += u32::from(blocks);
                // A ray through the very edge may be counted either way.
                if let Some(expected) = expected {
                    assert!(
                        ray.end <= expected + 1e-4,
                        "{count} {k}: {expected} {}",
                        ray.end
                    );
                }
                let near = |s: &[Vec3A; 3]| {
                    let larger = s.map(|c| c + 1e-3 * (c - (s[0] + s[1] + s[2]) / 3.0));
                    distance(origin, direction, larger)
                };
                let least = shapes.iter().filter_map(near).reduce(f32::min);
                assert!(
                    least.unwrap_or(f32::INFINITY) <= ray.end + 1e-4,
                    "{count} {k}"
                );
            }
            assert!(met > 200 || count < 2000);
        }
    }
}
