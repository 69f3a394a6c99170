//! Where the surface ends: lichen is cut off there, has no margin of its own, and has neighbours on one side alone.
//!
//! A disc may not lie beyond a border, as if the lichen went on there like its mirror image. It is enough to mirror
//! each element by itself: that takes away just those directions in which the centre of a disc at its edge would lie
//! beyond the border.

use std::collections::HashMap;

use glam::{DVec3, I64Vec3, Vec3};

use super::base::Winding;
use crate::substrate::Substrate;

/// The open edges of a substrate near a lichen, to be found by place.
pub(super) struct Borders {
    edges: Vec<Edge>,
    /// The edges that come near each cell.
    cells: HashMap<I64Vec3, Vec<u32>>,
    /// How far mirror images are looked for.
    within: f64,
}

struct Edge {
    ends: [DVec3; 2],
    /// Of the surface beside it.
    normal: Vec3,
}

/// Surfaces whose normals differ by more than 60° are others.
const SAME_SHEET: f32 = 0.5;

/// Side of a cell, and from place to place along an edge that is noted, as shares of how far images are looked for: a
/// border is half as far, and the next place that is noted an eighth more.
const CELL: f64 = 0.625;
const STEP: f64 = 0.25;

impl Borders {
    /// For mirror images no farther than this, local units, of what is in a box.
    pub(super) fn new(
        substrate: &Substrate,
        winding: &Winding,
        [low, high]: [DVec3; 2],
        within: f64,
    ) -> Self {
        let near = [low - within, high + within];
        let open = |h: &u32| substrate.twin(*h).half_edge() == *h;
        let edge = |h: u32| {
            let (corners, k) = (substrate.corners(h / 3), h as usize % 3);
            let ends = part_inside([corners[k], corners[(k + 1) % 3]], near)?;
            let normal = winding.normal(substrate, h / 3).as_vec3();
            Some(Edge { ends, normal })
        };
        let all = 0..3 * substrate.triangles().len() as u32;
        let mut borders = Self {
            edges: all.filter(open).filter_map(edge).collect(),
            cells: HashMap::new(),
            within,
        };
        for number in 0..borders.edges.len() {
            borders.note(number);
        }
        borders
    }

    fn note(&mut self, number: usize) {
        let [a, b] = self.edges[number].ends;
        let steps = (a.distance(b) / (STEP * self.within)).ceil().max(1.0) as usize;
        for step in 0..=steps {
            let cell = self.cell(a.lerp(b, step as f64 / steps as f64));
            let listed = self.cells.entry(cell).or_default();
            if listed.last() != Some(&(number as u32)) {
                listed.push(number as u32);
            }
        }
    }

    fn cell(&self, place: DVec3) -> I64Vec3 {
        (place / (CELL * self.within)).floor().as_i64vec3()
    }

    /// The ways from a place on the surface, with its normal there, to its mirror images beyond borders.
    pub(super) fn mirrored(&self, place: DVec3, normal: Vec3) -> Vec<DVec3> {
        if self.edges.is_empty() {
            return Vec::new();
        }
        let at = self.cell(place);
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

/// The part of a line between two places that lies in a box, if any does.
fn part_inside([a, b]: [DVec3; 2], [low, high]: [DVec3; 2]) -> Option<[DVec3; 2]> {
    let (mut from, mut to) = (0.0_f64, 1.0_f64);
    for axis in 0..3 {
        let (start, way) = (a[axis], b[axis] - a[axis]);
        let [first, second] = [low[axis], high[axis]].map(|side| (side - start) / way);
        if way != 0.0 {
            (from, to) = (from.max(first.min(second)), to.min(first.max(second)));
        } else if start < low[axis] || start > high[axis] {
            return None;
        }
    }
    (from <= to).then(|| [a.lerp(b, from), a.lerp(b, to)])
}

fn nearest_on([a, b]: [DVec3; 2], p: DVec3) -> DVec3 {
    let along = (p - a).dot(b - a) / (b - a).length_squared();
    a.lerp(b, along.clamp(0.0, 1.0))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rng::{Purpose, Stream};
    use crate::substrate::Soup;

    /// A saw-toothed strip: long edges, short ones, and folds between them.
    fn strip() -> Substrate {
        let tooth = |i: u32| f64::from(i % 3) * 0.7;
        let row = |i: u32| {
            [
                [f64::from(i), 0.0, tooth(i)],
                [f64::from(i), 30.0, tooth(i)],
            ]
        };
        let triangles = (0..40).flat_map(|i| {
            [
                [2 * i, 2 * i + 2, 2 * i + 1],
                [2 * i + 1, 2 * i + 2, 2 * i + 3],
            ]
        });
        Substrate::from_soup(Soup {
            positions: (0..=40).flat_map(row).collect(),
            triangles: triangles.collect(),
            notes: Vec::new(),
        })
        .expect("a strip")
    }

    #[test]
    fn mirror_images_are_those_by_all_open_edges() {
        let substrate = strip();
        let winding = Winding::of(&substrate);
        let [low, high] = substrate.bounds();
        let size = low.distance(high);
        let mut random = Stream::new(3, Purpose::Walker, 0);
        let (mut found, mut none) = (0, 0);
        for within in [0.01, 0.1, 0.5].map(|share| share * size) {
            let middle = low.midpoint(high);
            let borders = Borders::new(&substrate, &winding, [low, middle], within);
            for _ in 0..600 {
                let t = (random.uniform() * 80.0) as u32;
                let [a, b, c] = substrate.corners(t);
                let place = a + (b - a) * random.uniform() * 0.5 + (c - a) * random.uniform() * 0.5;
                if place.cmpgt(middle).any() {
                    continue;
                }
                let normal = winding.normal(&substrate, t).as_vec3();
                let open = (0..240).filter(|&h| substrate.twin(h).half_edge() == h);
                let ways = open.filter_map(|h| {
                    let (corners, k) = (substrate.corners(h / 3), h as usize % 3);
                    let nearest = nearest_on([corners[k], corners[(k + 1) % 3]], place);
                    let other = winding.normal(&substrate, h / 3).as_vec3();
                    let way = 2.0 * (nearest - place);
                    (way.length() <= within && other.dot(normal) > SAME_SHEET).then_some(way)
                });
                let expected: Vec<DVec3> = ways.collect();
                let ways = borders.mirrored(place, normal);
                assert_eq!(ways.len(), expected.len());
                let error = |(a, b): (&DVec3, &DVec3)| a.distance(*b);
                let errors = ways.iter().zip(&expected).map(error);
                assert!(errors.fold(0.0, f64::max) < 1e-9 * size);
                let nearest = expected
                    .iter()
                    .map(|w| 0.5 * w.length())
                    .fold(0.25 * within, f64::min);
                let share = borders.share(place, normal, 0.25 * within);
                assert!(
                    (0.5..=1.0).contains(&share) && (share == 1.0) == (nearest == 0.25 * within)
                );
                (found, none) = (
                    found + expected.len(),
                    none + usize::from(expected.is_empty()),
                );
            }
        }
        assert!(found > 300 && none > 50, "{found}, {none}");
    }
}
