//! Spatial queries over the triangles: a hierarchy of boxes over triangles that lie along a curve.
//!
//! Triangles are numbered along a curve that fills space, so those of consecutive numbers lie together, and
//! a box about each eight of them, about each eight of these boxes, and so on is all the tree there is: nothing
//! is sorted, linked or searched for to make it, and it takes five bytes a triangle (Lauterbach and others,
//! *Fast BVH Construction on GPUs*, 2009, whose nodes are split where the curve's keys are). Rays of pictures,
//! of which there are millions, have a better and dearer tree of their own (`picture`).
//!
//! Boxes are f32, padded by a few units in the last place, so that they hold the f64 triangles.

use std::ops::Range;

use glam::{DVec3, Vec3A};
use obvhs::aabb::Aabb;
use rayon::prelude::*;

/// Triangles under a box of the first level, and boxes under one of the others.
const FAN: usize = 8;

/// Boxes that one thread makes at a time.
const SHARE: usize = 1 << 10;

/// A bounding volume hierarchy over triangles in local units.
#[derive(Debug)]
pub(super) struct Bvh {
    triangles: usize,
    /// Boxes about eight triangles each, then about eight of those, and so on to no more than eight.
    levels: Vec<Vec<Aabb>>,
}

/// A box of the tree: its level and number there.
type Node = (usize, usize);

impl Bvh {
    pub(super) fn new(vertices: &[DVec3], triangles: &[[u32; 3]]) -> Self {
        Self::over(triangles, |triangle| {
            triangle.iter().map(|&i| vertices[i as usize])
        })
    }

    /// Over places instead of triangles, along a curve as they are.
    pub(super) fn of_places(places: &[DVec3]) -> Self {
        Self::over(places, |place| std::iter::once(*place))
    }

    /// Over boxes, by their lower and upper corners.
    pub(super) fn of_boxes(boxes: &[[DVec3; 2]]) -> Self {
        Self::over(boxes, |corners| corners.iter().copied())
    }

    fn over<'a, T: Sync, P: Iterator<Item = DVec3>>(
        items: &'a [T],
        places: impl Fn(&'a T) -> P + Sync,
    ) -> Self {
        let about = |items: &'a [T]| {
            let places = items.iter().flat_map(&places);
            let [low, high] = places.fold(EMPTY, |[low, high], place| {
                [low.min(place), high.max(place)]
            });
            padded_box(low, high)
        };
        let first = items.par_chunks(FAN).with_min_len(SHARE).map(about);
        let mut levels: Vec<Vec<Aabb>> = vec![first.collect()];
        while let Some(below) = levels.last().filter(|below| below.len() > FAN) {
            let about = |boxes: &[Aabb]| boxes[1..].iter().fold(boxes[0], |sum, b| sum.union(b));
            let above = below.chunks(FAN).map(about).collect();
            levels.push(above);
        }
        Self {
            triangles: items.len(),
            levels,
        }
    }

    /// Calls `leaf` with the triangles under every box of the first level that passes `enter` with all boxes
    /// about it.
    pub(super) fn visit(&self, enter: impl Fn(&Aabb) -> bool, leaf: impl FnMut(u32)) {
        self.visit_among(&(0..self.triangles as u32), enter, leaf);
    }

    /// As [`visit`](Self::visit), of the triangles of a range alone.
    pub(super) fn visit_among(
        &self,
        among: &Range<u32>,
        enter: impl Fn(&Aabb) -> bool,
        mut leaf: impl FnMut(u32),
    ) {
        let [start, end] = [among.start, among.end].map(|t| t as usize);
        let has_some = |(level, i): Node| {
            let under = FAN.pow(level as u32 + 1);
            i * under < end && (i + 1) * under > start
        };
        let mut stack: Vec<Node> = self.top().rev().collect();
        while let Some((level, i)) = stack.pop() {
            if !has_some((level, i)) || !enter(&self.levels[level][i]) {
                continue;
            }
            match level.checked_sub(1) {
                None => self
                    .triangles_of(i)
                    .filter(|t| among.contains(t))
                    .for_each(&mut leaf),
                Some(below) => stack.extend(self.boxes_of(below, i).rev()),
            }
        }
    }

    /// The triangle that minimises `distance_sq`, and that value; ties go to the lower number.
    pub(super) fn nearest(
        &self,
        p: DVec3,
        distance_sq: impl FnMut(u32) -> f64,
    ) -> Option<(u32, f64)> {
        self.nearest_within(p, f64::INFINITY, distance_sq)
    }

    /// As [`nearest`](Self::nearest), in boxes no farther away than a limit, squared: what is farther may be found or
    /// not.
    pub(super) fn nearest_within(
        &self,
        p: DVec3,
        limit_sq: f64,
        mut distance_sq: impl FnMut(u32) -> f64,
    ) -> Option<(u32, f64)> {
        let away = |(level, i): Node| (box_distance_sq(&self.levels[level][i], p), (level, i));
        let mut best: Option<(u32, f64)> = None;
        let mut stack: Vec<(f64, Node)> = Vec::with_capacity(FAN * (self.levels.len() + 1));
        stack.extend(self.top().map(away));
        farthest_first(&mut stack);
        while let Some((bound, (level, i))) = stack.pop() {
            if bound > best.map_or(limit_sq, |(_, d)| d.min(limit_sq)) {
                continue;
            }
            let Some(below) = level.checked_sub(1) else {
                for t in self.triangles_of(i) {
                    let d = distance_sq(t);
                    if best.is_none_or(|(n, least)| d < least || (d == least && t < n)) {
                        best = Some((t, d));
                    }
                }
                continue;
            };
            let known = stack.len();
            stack.extend(self.boxes_of(below, i).map(away));
            farthest_first(&mut stack[known..]);
        }
        best
    }

    /// The boxes that no other is about.
    fn top(&self) -> impl DoubleEndedIterator<Item = Node> + use<> {
        let level = self.levels.len() - 1;
        (0..self.levels[level].len()).map(move |i| (level, i))
    }

    /// The boxes of a level that one of the level above is about.
    fn boxes_of(
        &self,
        level: usize,
        above: usize,
    ) -> impl DoubleEndedIterator<Item = Node> + use<> {
        let end = self.levels[level].len().min(FAN * (above + 1));
        (FAN * above..end).map(move |i| (level, i))
    }

    fn triangles_of(&self, first_level: usize) -> impl Iterator<Item = u32> + use<> {
        let end = self.triangles.min(FAN * (first_level + 1));
        (FAN * first_level..end).map(|t| t as u32)
    }
}

const EMPTY: [DVec3; 2] = [DVec3::INFINITY, DVec3::NEG_INFINITY];

/// So that the nearest is taken first from the end.
fn farthest_first(boxes: &mut [(f64, Node)]) {
    boxes.sort_unstable_by(|a, b| b.0.total_cmp(&a.0));
}

/// A box about places in a box.
pub(super) fn padded_box(min: DVec3, max: DVec3) -> Aabb {
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

/// Whether a line along one of the axes, or another direction, through a point meets a box.
pub(super) fn line_meets(aabb: &Aabb, through: DVec3, along: DVec3) -> bool {
    let (min, max) = (aabb.min.as_dvec3(), aabb.max.as_dvec3());
    let (middle, half) = ((min + max) * 0.5 - through, (max - min) * 0.5);
    // Separating axes: those at right angles to the line and to one side of the box.
    let aside = along.cross(middle).abs();
    let reach = DVec3::new(
        along.y.abs() * half.z + along.z.abs() * half.y,
        along.z.abs() * half.x + along.x.abs() * half.z,
        along.x.abs() * half.y + along.y.abs() * half.x,
    );
    aside.cmple(reach).all()
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::super::Substrate;
    use super::*;
    use crate::rng::{Purpose, Stream};

    /// The rock, and as many triangles of it as make trees of one, two and more levels, full and not.
    fn some_meshes() -> Vec<(Vec<DVec3>, Vec<[u32; 3]>)> {
        let rock = Substrate::load(Path::new("meshes/rock.obj")).expect("a mesh");
        let of = |n: usize| (rock.vertices().to_vec(), rock.triangles()[..n].to_vec());
        [1, 7, 8, 9, 64, 65, 513, 4608].map(of).to_vec()
    }

    fn somewhere(stream: &mut Stream) -> DVec3 {
        DVec3::from([0; 3].map(|_| 1.4 * (stream.uniform() - 0.5)))
    }

    fn visited(bvh: &Bvh, enter: impl Fn(&Aabb) -> bool) -> Vec<u32> {
        let mut visited = Vec::new();
        bvh.visit(enter, |t| visited.push(t));
        visited
    }

    #[test]
    fn all_are_visited_once_in_order() {
        for (vertices, triangles) in some_meshes() {
            let bvh = Bvh::new(&vertices, &triangles);
            let all: Vec<u32> = (0..triangles.len() as u32).collect();
            assert_eq!(visited(&bvh, |_| true), all);
            assert!(bvh.levels.iter().rev().skip(1).all(|l| l.len() > FAN));
        }
    }

    #[test]
    fn of_a_range_those_are_visited_that_are_of_all() {
        let mut stream = Stream::new(12, Purpose::Walker, 0);
        for (vertices, triangles) in some_meshes() {
            let bvh = Bvh::new(&vertices, &triangles);
            let count = triangles.len() as f64;
            for _ in 0..50 {
                let [a, b] = [(); 2].map(|()| ((count + 1.0) * stream.uniform()) as u32);
                let among = a.min(b)..a.max(b);
                let here = somewhere(&mut stream);
                let enter = |b: &Aabb| box_distance_sq(b, here) < 0.1;
                let mut found = Vec::new();
                bvh.visit_among(&among, enter, |t| found.push(t));
                let mut all = visited(&bvh, enter);
                all.retain(|t| among.contains(t));
                assert_eq!(found, all, "{among:?}");
            }
        }
    }

    #[test]
    fn the_nearest_is_that_of_all() {
        let mut stream = Stream::new(11, Purpose::Walker, 0);
        for (vertices, triangles) in some_meshes() {
            let bvh = Bvh::new(&vertices, &triangles);
            let middle = |t: u32| triangles[t as usize].map(|v| vertices[v as usize])[0];
            for _ in 0..200 {
                let p = somewhere(&mut stream);
                let away = |t: u32| middle(t).distance_squared(p);
                let all = (0..triangles.len() as u32).map(|t| (t, away(t)));
                let least = all.reduce(|a, b| if b.1 < a.1 { b } else { a });
                assert_eq!(bvh.nearest(p, away), least);
            }
        }
    }

    #[test]
    fn boxes_that_a_line_meets_hold_all_triangles_that_it_does() {
        let mut stream = Stream::new(12, Purpose::Walker, 0);
        let (vertices, triangles) = some_meshes().remove(7);
        let bvh = Bvh::new(&vertices, &triangles);
        let (mut met, mut passed) = (0, 0);
        for round in 0..300 {
            let along = match round % 4 {
                3 => somewhere(&mut stream).normalize(),
                axis => DVec3::AXES[axis],
            };
            let through = 0.6 * somewhere(&mut stream);
            let near = visited(&bvh, |b| line_meets(b, through, along));
            passed += triangles.len() - near.len();
            for (t, corners) in (0..).zip(&triangles) {
                let [a, b, c] = corners.map(|v| vertices[v as usize] - through);
                let sides = [a.cross(b), b.cross(c), c.cross(a)].map(|side| side.dot(along));
                if sides.iter().all(|s| *s >= 0.0) || sides.iter().all(|s| *s <= 0.0) {
                    assert!(near.contains(&t));
                    met += 1;
                }
            }
        }
        assert!(met > 300, "{met}");
        assert!(passed > 250 * triangles.len(), "{passed}");
    }
}
