//! Density and distance from the rim of a lichen at every moment of its growth.
//!
//! Both are those that a skin of the elements so far has, so that a margin moves with the rim. They
//! change smoothly too. Density counts each neighbour by its influence. Elements come off the rim one
//! by one, so the distance from it is interpolated between the lichens of some numbers of elements, a
//! window or less apart: with no window it is that of the elements so far.

use std::cmp::{Ordering, Reverse};
use std::collections::BinaryHeap;

use glam::DVec3;
use rayon::prelude::*;

use super::borders::Borders;
use super::lichen::{BESIDE, HOLE, Lichen};
use crate::cluster::Presence;
use crate::morphometry::{LOOK, rim_until, rim_until_with};

/// A window of this many times the square root of the number of elements takes the rim of a round lichen
/// two radii on: n elements that cover 0.6 of their ground reach to r √(n / 0.6).
const STEADY: f64 = 3.1;

/// Who stands near whom, and who was on the rim until when. Elements are named by birth.
pub(super) struct History {
    radius: f64,
    positions: Vec<DVec3>,
    /// The neighbours of each element, ascending, and where they start.
    near: Vec<u32>,
    starts: Vec<usize>,
    /// For each element the share of the surface about it that is there.
    shares: Vec<f32>,
    rim_until: Vec<u32>,
    /// The same of the outline, where a margin is drawn by it.
    outline_until: Option<Vec<u32>>,
    /// Distances from the rim are not told apart beyond this, in element radii.
    farthest: f32,
}

/// Distances from the rim and from the outline, in element radii, of the first so many elements; the latter only
/// where a margin is drawn by it.
pub(super) struct Distances {
    rim: Vec<f32>,
    outline: Vec<f32>,
}

/// Numbers of elements whose distances from the rim are interpolated, and how far to the second.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Keys {
    pub(super) counts: [usize; 2],
    share: f32,
}

impl History {
    /// Of a lichen in birth order.
    pub(super) fn new(lichen: &Lichen, farthest: f32, has_margin: bool, borders: &Borders) -> Self {
        let neighbours = lichen.neighbours(LOOK);
        let all = lichen.granules.len();
        let near = |i: usize| {
            let mut near = Vec::new();
            neighbours.visit(i, |j, _, _| near.push(j));
            near.sort_unstable();
            near
        };
        let lists: Vec<Vec<u32>> = (0..all).into_par_iter().map(near).collect();
        let mut starts = vec![0; all + 1];
        for (i, list) in lists.iter().enumerate() {
            starts[i + 1] = starts[i] + list.len();
        }
        Self {
            radius: lichen.radius,
            positions: lichen.granules.iter().map(|g| g.position).collect(),
            near: lists.concat(),
            starts,
            rim_until: rim_until(&neighbours),
            shares: lichen.shares(borders),
            outline_until: has_margin
                .then(|| rim_until_with(&lichen.neighbours(HOLE), |i| lichen.closed(i, borders))),
            farthest,
        }
    }

    /// The neighbours of an element, ascending.
    pub(super) fn near(&self, i: usize) -> &[u32] {
        &self.near[self.starts[i]..self.starts[i + 1]]
    }

    /// See [`density`](crate::morphometry::density()), each neighbour by its influence; of the surface that is there.
    pub(super) fn density(&self, i: usize, presence: &Presence) -> f32 {
        let near = self.near(i);
        let all = self.positions.len();
        let below = |count: usize| near.partition_point(|&j| (j as usize) < count);
        let (settled, born) = (below(presence.settled(all)), below(presence.born(all)));
        let coming = near[settled..born].iter();
        let coming: f64 = coming
            .map(|&j| f64::from(presence.influence(j as usize)))
            .sum();
        let within = LOOK * self.radius;
        let share = (self.radius / within) * (self.radius / within);
        (((1 + settled) as f64 + coming) * share) as f32 / self.shares[i]
    }

    /// Where the distance from the rim comes from at a moment: halfway through the window elements
    /// count for it.
    pub(super) fn keys(&self, presence: &Presence) -> Keys {
        let all = self.positions.len();
        if presence.window <= 0.0 {
            return Keys {
                counts: [presence.born(all); 2],
                share: 0.0,
            };
        }
        let pace = Pace(presence.window.max(1.0));
        let count = (presence.time + 0.5 * presence.window).clamp(0.0, all as f64);
        // Counted from the grown lichen back, so that it is one of them.
        let last = pace.steps(all as f64);
        let back = last - pace.steps(count);
        let key = |steps: f64| (pace.count(last - steps).round() as usize).min(all);
        Keys {
            counts: [key(back.ceil()), key(back.floor())],
            share: (back.ceil() - back) as f32,
        }
    }

    /// Those of the first elements by themselves.
    pub(super) fn distances(&self, elements: usize) -> Distances {
        let still = |until: &[u32], i: usize| elements as u32 <= until[i];
        let is_rim = |i: usize| still(&self.rim_until, i);
        let outline = |until: &Vec<u32>| {
            let is_outermost = |i: usize| is_rim(i) && still(until, i);
            let outermost = self.distances_from(is_outermost, elements, BESIDE);
            let is_outline = |i: usize| is_rim(i) && outermost[i] < BESIDE;
            self.distances_from(is_outline, elements, self.farthest)
        };
        Distances {
            rim: self.distances_from(is_rim, elements, self.farthest),
            outline: self.outline_until.as_ref().map_or_else(Vec::new, outline),
        }
    }

    /// See [`rim_distance`](crate::morphometry::rim_distance); this far at most, in element radii.
    fn distances_from(
        &self,
        is_rim: impl Fn(usize) -> bool,
        elements: usize,
        farthest: f32,
    ) -> Vec<f32> {
        let limit = f64::from(farthest) * self.radius;
        let mut distance = vec![f64::INFINITY; elements];
        let rim: Vec<usize> = (0..elements).filter(|&i| is_rim(i)).collect();
        rim.iter().for_each(|&i| distance[i] = 0.0);
        // None is nearer than the rim itself, in whatever order.
        let mut queue = BinaryHeap::new();
        for i in rim {
            self.relax(i, limit, &mut distance, &mut queue);
        }
        while let Some(Reverse(Way(length, at))) = queue.pop() {
            if length <= distance[at as usize] {
                self.relax(at as usize, limit, &mut distance, &mut queue);
            }
        }
        let in_radii = |d: f64| ((d / self.radius) as f32).min(farthest);
        distance.into_iter().map(in_radii).collect()
    }

    /// Shortens the ways to the neighbours of an element, as far as there are distances, by going over
    /// it.
    fn relax(
        &self,
        at: usize,
        limit: f64,
        distance: &mut [f64],
        queue: &mut BinaryHeap<Reverse<Way>>,
    ) {
        let (place, length) = (self.positions[at], distance[at]);
        for &next in self.near(at) {
            let Some(known) = distance.get_mut(next as usize) else {
                break;
            };
            if *known <= length {
                continue;
            }
            let way = length + (self.positions[next as usize] - place).length();
            if way < *known && way <= limit {
                *known = way;
                queue.push(Reverse(Way(way, next)));
            }
        }
    }
}

/// A length, never NaN, and where it leads.
#[derive(PartialEq)]
struct Way(f64, u32);

impl Eq for Way {}

impl PartialOrd for Way {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Way {
    fn cmp(&self, other: &Self) -> Ordering {
        self.0.total_cmp(&other.0).then(self.1.cmp(&other.1))
    }
}

/// The numbers of elements whose distances from the rim are interpolated, a step apart: this window, or what
/// takes the rim two radii on where that is less. Further apart, half of what is born between two of them would be
/// ahead of the rim that is seen, and that would seem to have none.
struct Pace(f64);

impl Pace {
    /// So many elements as at which both are the same.
    fn turn(&self) -> f64 {
        (self.0 / STEADY).powi(2)
    }

    /// Steps from no element to this number of them.
    fn steps(&self, count: f64) -> f64 {
        let turn = self.turn();
        2.0 * count.min(turn).sqrt() / STEADY + (count - turn).max(0.0) / self.0
    }

    /// The number of elements after so many steps; none before.
    fn count(&self, steps: f64) -> f64 {
        let turn = self.turn();
        let early = 2.0 * turn.sqrt() / STEADY;
        (0.5 * STEADY * steps.clamp(0.0, early)).powi(2) + (steps - early).max(0.0) * self.0
    }
}

impl Keys {
    /// The distance from the rim of an element; one that is not among them yet is on the rim.
    pub(super) fn rim(&self, i: usize, of: [&Distances; 2]) -> f32 {
        self.between(i, of.map(|distances| &distances.rim))
    }

    /// The same from the outline.
    pub(super) fn outline(&self, i: usize, of: [&Distances; 2]) -> f32 {
        self.between(i, of.map(|distances| &distances.outline))
    }

    fn between(&self, i: usize, of: [&Vec<f32>; 2]) -> f32 {
        let [a, b] = of.map(|distances| distances.get(i).copied().unwrap_or(0.0));
        a + self.share * (b - a)
    }
}

#[cfg(test)]
mod tests {
    use super::super::lichen::tests::{no_borders, packed};
    use super::*;
    use crate::cluster::Ease;

    #[test]
    fn whatever_the_window_distances_are_from_the_rim_that_is_there() {
        let lichen = packed(|p| p.length() < 100.0);
        let (all, history) = (
            lichen.granules.len(),
            History::new(&lichen, 20.0, false, &no_borders()),
        );
        let (mut off, mut between) = (0.0f32, 0);
        for window in [0.0, 20.0, 90.0, 400.0, 3000.0] {
            for time in (0..all).step_by(211) {
                let presence = Presence {
                    time: time as f64,
                    window,
                    ease: Ease::Linear,
                };
                let keys = history.keys(&presence);
                let [a, b] = keys.counts.map(|count| history.distances(count));
                let half = (time as f64 + 0.5 * window) as usize;
                let exact = history.distances(half.min(all)).rim;
                between += usize::from(a.rim.len() != b.rim.len());
                for (i, exact) in exact.iter().enumerate() {
                    off = off.max((keys.rim(i, [&a, &b]) - exact).abs());
                }
            }
        }
        assert!(off < 2.5 && between > 50, "{off}, {between}");
        for window in [1.0, 30.0, 1e4] {
            let pace = Pace(window);
            let there_and_back = |n: f64| (pace.count(pace.steps(n)) - n).abs();
            assert!((0..5000).all(|n| there_and_back(f64::from(n)) < 1e-6));
        }
    }
}
