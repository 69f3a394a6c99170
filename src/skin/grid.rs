//! Which elements are near a place: a hash grid, and a tree for longer distances.

use std::collections::HashMap;
use std::hash::{BuildHasherDefault, Hasher};
use std::ops::Range;

use glam::DVec3;
use rayon::prelude::*;

/// Mixes the one word that a key is.
#[derive(Default)]
pub(super) struct WordHasher(u64);

impl Hasher for WordHasher {
    fn write(&mut self, bytes: &[u8]) {
        bytes.iter().for_each(|&b| self.write_u64(u64::from(b)));
    }

    fn write_u64(&mut self, word: u64) {
        let mixed = (self.0 ^ word).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        self.0 = mixed ^ (mixed >> 32);
    }

    fn finish(&self) -> u64 {
        self.0
    }
}

type Words = BuildHasherDefault<WordHasher>;

/// A map from words, without the cost of a hash that withstands attacks.
pub(super) type WordMap<T> = HashMap<u64, T, Words>;

/// Local coordinates lie within ±1, and a key has 21 bits an axis.
const SMALLEST_CELL: f64 = 1.0 / (1 << 19) as f64;

/// The grid cell of a point, from its lower corner.
fn cell_of(p: DVec3, cell: f64) -> [i64; 3] {
    (p / cell).floor().to_array().map(|x| x as i64)
}

fn key(cell: [i64; 3]) -> u64 {
    let bits = |x: i64| ((x + (1 << 20)) & ((1 << 21) - 1)) as u64;
    bits(cell[0]) << 42 | bits(cell[1]) << 21 | bits(cell[2])
}

/// Points sorted into cubes.
pub(super) struct Grid {
    cell: f64,
    cells: WordMap<Range<u32>>,
}

impl Grid {
    /// For questions of at most `reach`, and the order in which points have to be kept for it: by
    /// cube, then by number.
    pub(super) fn new(points: &[DVec3], reach: f64) -> (Self, Vec<u32>) {
        let cell = (2.0 * reach).max(SMALLEST_CELL);
        let keyed = |(i, p): (usize, &DVec3)| (key(cell_of(*p, cell)), i as u32);
        let mut order: Vec<(u64, u32)> = points.par_iter().enumerate().map(keyed).collect();
        order.par_sort_unstable();
        let mut cells = WordMap::default();
        let mut first = 0;
        for run in order.chunk_by(|a, b| a.0 == b.0) {
            let end = first + run.len() as u32;
            cells.insert(run[0].0, first..end);
            first = end;
        }
        let order = order.into_iter().map(|(_, i)| i).collect();
        (Self { cell, cells }, order)
    }

    /// All runs of places that have a cube of their own.
    pub(super) fn runs(&self) -> impl Iterator<Item = Range<usize>> {
        self.cells.values().map(places)
    }

    /// Runs of places in the grid's order that hold every point within its reach of `p`, and some
    /// beyond it.
    pub(super) fn around(&self, p: DVec3) -> impl Iterator<Item = Range<usize>> {
        let [x, y, z] = cell_of(p - 0.5 * self.cell, self.cell);
        let cube = move |i: i64| key([x + (i >> 2), y + (i >> 1 & 1), z + (i & 1)]);
        let found = move |i| self.cells.get(&cube(i));
        (0..8).filter_map(found).map(places)
    }
}

fn places(run: &Range<u32>) -> Range<usize> {
    run.start as usize..run.end as usize
}

/// Whether anything of the lichen is near: an exact answer for any distance, from a tree of boxes.
///
/// Exact, because cutting the surface ends only when a side that is not near has no long neighbour
/// that is: an answer on the safe side here and not there could be cut about for ever.
pub(super) struct Nearness {
    points: Vec<Numbered>,
    /// Boxes of the points, halved and halved again: the children of i are 2i + 1 and 2i + 2.
    boxes: Vec<[DVec3; 2]>,
    /// The lowest number in each box.
    lowest: Vec<u32>,
}

/// A point and its number.
type Numbered = (DVec3, u32);

/// Points in a box that is not halved, at most.
const LEAF: usize = 8;

impl Nearness {
    pub(super) fn new(points: impl IntoIterator<Item = DVec3>) -> Self {
        let mut nearness = Self {
            points: points.into_iter().zip(0..).collect(),
            boxes: Vec::new(),
            lowest: Vec::new(),
        };
        let mut points = std::mem::take(&mut nearness.points);
        nearness.arrange(&mut points, 0);
        nearness.points = points;
        nearness
    }

    /// True when a point is within `distance` of `p`.
    pub(super) fn within(&self, p: DVec3, distance: f64) -> bool {
        self.any_in(0, 0..self.points.len(), p, distance * distance)
    }

    fn any_in(&self, node: usize, run: Range<usize>, p: DVec3, limit: f64) -> bool {
        let [low, high] = self.boxes[node];
        if (p - p.clamp(low, high)).length_squared() > limit {
            return false;
        }
        if (p - low).abs().max((p - high).abs()).length_squared() <= limit {
            return true;
        }
        if run.len() <= LEAF {
            let near = |(q, _): &Numbered| (*q - p).length_squared() <= limit;
            return self.points[run].iter().any(near);
        }
        let middle = run.start + run.len() / 2;
        self.any_in(2 * node + 1, run.start..middle, p, limit)
            || self.any_in(2 * node + 2, middle..run.end, p, limit)
    }

    /// The lowest number of the points within `distance` of `p`.
    pub(super) fn first_within(&self, p: DVec3, distance: f64) -> Option<u32> {
        let mut first = u32::MAX;
        self.first_in(0, 0..self.points.len(), p, distance * distance, &mut first);
        (first < u32::MAX).then_some(first)
    }

    fn first_in(&self, node: usize, run: Range<usize>, p: DVec3, limit: f64, first: &mut u32) {
        let [low, high] = self.boxes[node];
        let far = (p - p.clamp(low, high)).length_squared() > limit;
        if far || self.lowest[node] >= *first {
            return;
        }
        if (p - low).abs().max((p - high).abs()).length_squared() <= limit {
            *first = self.lowest[node];
        } else if run.len() <= LEAF {
            let near = |(q, _): &&Numbered| (*q - p).length_squared() <= limit;
            let near = self.points[run].iter().filter(near);
            *first = near.fold(*first, |first, (_, i)| first.min(*i));
        } else {
            let middle = run.start + run.len() / 2;
            let halves = [
                (2 * node + 1, run.start..middle),
                (2 * node + 2, middle..run.end),
            ];
            let swapped = self.lowest[halves[1].0] < self.lowest[halves[0].0];
            let [a, b] = halves;
            let order = if swapped { [b, a] } else { [a, b] };
            order
                .into_iter()
                .for_each(|(node, run)| self.first_in(node, run, p, limit, first));
        }
    }

    /// Orders points so that each half of a run has a box of its own.
    fn arrange(&mut self, points: &mut [Numbered], node: usize) {
        let places = || points.iter().map(|(p, _)| p);
        let low = places().fold(DVec3::INFINITY, |m, p| m.min(*p));
        let high = places().fold(DVec3::NEG_INFINITY, |m, p| m.max(*p));
        if self.boxes.len() <= node {
            self.boxes.resize(node + 1, [DVec3::ZERO; 2]);
            self.lowest.resize(node + 1, u32::MAX);
        }
        self.boxes[node] = [low, high];
        self.lowest[node] = points.iter().fold(u32::MAX, |m, (_, i)| m.min(*i));
        if points.len() <= LEAF {
            return;
        }
        let axis = (high - low).max_position();
        let middle = points.len() / 2;
        points.select_nth_unstable_by(middle, |a, b| a.0[axis].total_cmp(&b.0[axis]));
        let (lower, upper) = points.split_at_mut(middle);
        self.arrange(lower, 2 * node + 1);
        self.arrange(upper, 2 * node + 2);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rng::{Purpose, Stream};

    fn scattered(index: u64, n: u64) -> Vec<DVec3> {
        let mut stream = Stream::new(5, Purpose::Walker, (1 << 41) + index);
        let mut x = || 2.0 * stream.uniform() - 1.0;
        (0..n).map(|_| DVec3::new(x(), x(), 0.3 * x())).collect()
    }

    #[test]
    fn nothing_within_reach_is_missed() {
        let points = scattered(1, 3000);
        let (grid, order) = Grid::new(&points, 0.07);
        for p in scattered(2, 200) {
            let mut found: Vec<u32> = grid
                .around(p)
                .flat_map(|run| order[run].to_vec())
                .filter(|&i| (points[i as usize] - p).length() <= 0.07)
                .collect();
            found.sort_unstable();
            let near = |i: &u32| (points[*i as usize] - p).length() <= 0.07;
            let expected: Vec<u32> = (0..3000).filter(near).collect();
            assert_eq!(found, expected);
        }
    }

    #[test]
    fn nearness_is_exact() {
        let points = scattered(1, 500);
        let nearness = Nearness::new(points.clone());
        let mut told = [0, 0];
        for p in scattered(2, 500) {
            for distance in [0.005, 0.02, 0.05, 0.1, 0.2, 1.0, 5.0] {
                let first = points.iter().position(|q| (*q - p).length() <= distance);
                let near = first.is_some();
                assert_eq!(nearness.within(p, distance), near, "{p} {distance}");
                let found = nearness.first_within(p, distance);
                assert_eq!(found, first.map(|i| i as u32), "{p} {distance}");
                told[usize::from(near)] += 1;
            }
        }
        assert!(told[0] > 500 && told[1] > 500, "{told:?}");
    }
}
