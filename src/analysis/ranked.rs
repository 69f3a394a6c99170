//! Who of those that rank higher stands near: points that do not change, in a tree of cells.

use std::ops::Range;

use glam::{DVec3, Vec3};

/// Points with unit normals, those of the highest rank first.
pub(super) struct Ranked {
    points: Vec<Point>,
    /// A cell before the two that it is cut into.
    cells: Vec<Cell>,
}

#[derive(Clone, Copy)]
struct Point {
    rank: usize,
    position: DVec3,
    normal: Vec3,
}

struct Cell {
    low: DVec3,
    high: DVec3,
    /// Of the points within.
    highest: usize,
    points: Range<usize>,
    /// The second of the two that it is cut into; none of a cell that is not.
    second: Option<usize>,
}

impl Cell {
    /// From a place to the nearest place within.
    fn distance(&self, from: DVec3) -> f64 {
        from.distance(from.max(self.low).min(self.high))
    }
}

/// The most points that a cell is left whole with.
const WHOLE: usize = 8;

impl Ranked {
    pub(super) fn new(points: impl IntoIterator<Item = (DVec3, Vec3)>) -> Self {
        let point = |(rank, (position, normal))| Point {
            rank,
            position,
            normal,
        };
        let mut ranked = Self {
            points: points.into_iter().enumerate().map(point).collect(),
            cells: Vec::new(),
        };
        ranked.cut(0..ranked.points.len());
        ranked
    }

    /// Cuts the cell about these points in half across its longest side, and the halves likewise.
    fn cut(&mut self, range: Range<usize>) -> usize {
        let points = &mut self.points[range.clone()];
        let fold = |of: fn(DVec3, DVec3) -> DVec3, start| {
            points.iter().fold(start, |bound, p| of(bound, p.position))
        };
        let low = fold(DVec3::min, DVec3::INFINITY);
        let high = fold(DVec3::max, DVec3::NEG_INFINITY);
        let highest = points.iter().map(|p| p.rank).min().unwrap_or(usize::MAX);
        let middle = points.len() / 2;
        if points.len() > WHOLE {
            let axis = (high - low).max_position();
            let key = |p: &Point| p.position[axis];
            let order = |a: &Point, b: &Point| key(a).total_cmp(&key(b)).then(a.rank.cmp(&b.rank));
            points.select_nth_unstable_by(middle, order);
        }
        let this = self.cells.len();
        self.cells.push(Cell {
            low,
            high,
            highest,
            points: range.clone(),
            second: None,
        });
        if range.len() > WHOLE {
            let middle = range.start + middle;
            self.cut(range.start..middle);
            self.cells[this].second = Some(self.cut(middle..range.end));
        }
        this
    }

    /// Whether one that ranks higher than `rank` is no farther from a place than `within` and has a
    /// normal with a positive product with this one.
    pub(super) fn has_higher(&self, rank: usize, from: DVec3, normal: Vec3, within: f64) -> bool {
        let mut open = vec![0];
        while let Some(at) = open.pop() {
            let cell = &self.cells[at];
            if cell.highest >= rank || cell.distance(from) > within {
                continue;
            }
            if let Some(second) = cell.second {
                open.extend([second, at + 1]);
                continue;
            }
            let near = |p: &Point| {
                let is_near = from.distance(p.position) <= within;
                p.rank < rank && is_near && normal.dot(p.normal) > 0.0
            };
            if self.points[cell.points.clone()].iter().any(near) {
                return true;
            }
        }
        false
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn who_stands_near_is_who_a_search_through_all_finds() {
        let place = |i: usize| {
            let t = i as f64;
            // Twos in one place.
            let [x, y, z] = [0.7, 1.3, 0.37].map(|k: f64| libm::sin((t / 2.0).floor() * k * 7.1));
            (
                DVec3::new(x, y, z),
                DVec3::new(y, z, x).normalize().as_vec3(),
            )
        };
        let points: Vec<_> = (0..500).map(place).collect();
        for n in [0, 1, 8, 9, 100, 500] {
            let ranked = Ranked::new(points[..n].iter().copied());
            for within in [0.0, 0.05, 0.3, 9.0] {
                for (rank, &(from, normal)) in points[..n].iter().enumerate() {
                    let near =
                        |&(p, m): &(DVec3, Vec3)| from.distance(p) <= within && normal.dot(m) > 0.0;
                    let expected = points[..rank].iter().any(near);
                    let found = ranked.has_higher(rank, from, normal, within);
                    assert_eq!(found, expected, "{rank} of {n} within {within}");
                }
            }
        }
    }
}
