//! Who stands near whom, for points that do not change.

use glam::{DVec3, Vec3};
use rayon::prelude::*;

use super::fold::laid_out;

/// The neighbours within a distance: points sorted by the cells of a grid of that size.
pub struct Neighbours {
    within: f64,
    /// The number of every point, by the cells that they are in.
    numbers: Vec<u32>,
    /// Position and normal of every point, in the same order.
    places: Vec<(DVec3, Vec3)>,
    /// Where in that order each point is.
    slots: Vec<u32>,
    /// For each point in that order, which of the cells it is in, of those that hold any.
    cell_of: Vec<u32>,
    /// For each of those cells, where the points are that are in it or in one that touches it.
    around: Vec<Rows>,
}

impl std::fmt::Debug for Neighbours {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Neighbours").finish_non_exhaustive()
    }
}

/// Rows of three cells: the first point of each, and the one after the last.
type Rows = [[u32; 2]; 9];

/// Bits of a cell's number in each direction.
const BITS: u32 = 21;

impl Neighbours {
    /// Makes ready to look for neighbours among points with unit normals, within a distance.
    ///
    /// # Panics
    /// When the slices differ in length, or `within` is not a positive finite number.
    pub fn new(positions: &[[f64; 3]], normals: &[[f32; 3]], within: f64) -> Self {
        assert_eq!(positions.len(), normals.len(), "a normal for each position");
        assert!(within.is_finite() && within > 0.0, "a distance to look in");
        let points = || positions.iter().map(|&p| DVec3::from(p));
        let grid = Grid::of(points, within);
        let number = |(i, p)| (pack(grid.cell(p)), i as u32);
        let mut cells: Vec<(u64, u32)> = points().enumerate().map(number).collect();
        cells.par_sort_unstable();
        let place =
            |&(_, i): &(u64, u32)| (positions[i as usize].into(), normals[i as usize].into());
        let mut slots = vec![0; cells.len()];
        for (slot, &(_, i)) in cells.iter().enumerate() {
            slots[i as usize] = slot as u32;
        }
        let mut held: Vec<u64> = Vec::new();
        let cell_of = cells.iter().map(|&(cell, _)| {
            if held.last() != Some(&cell) {
                held.push(cell);
            }
            held.len() as u32 - 1
        });
        Self {
            within,
            cell_of: cell_of.collect(),
            numbers: cells.iter().map(|&(_, i)| i).collect(),
            places: cells.iter().map(place).collect(),
            slots,
            around: held.par_iter().map(|&c| rows_around(c, &cells)).collect(),
        }
    }

    /// The distance.
    pub fn within(&self) -> f64 {
        self.within
    }

    /// How many points there are.
    pub fn len(&self) -> usize {
        self.numbers.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.numbers.is_empty()
    }

    /// The unit normal of a point.
    ///
    /// # Panics
    /// When there is no such point.
    pub fn normal(&self, of: usize) -> Vec3 {
        self.places[self.slots[of] as usize].1
    }

    /// A value for each point, on all of rayon's threads: taken in the order of the grid, where
    /// what one point looks at is still at hand for the next.
    pub(crate) fn map<T: Copy + Send + Sync>(&self, of: impl Fn(usize) -> T + Sync) -> Vec<T> {
        let values: Vec<T> = self.numbers.par_iter().map(|&i| of(i as usize)).collect();
        self.by_point(&values)
    }

    /// Calls `visit` with the number of every other point that stands near point `of` on the
    /// surface, the way to it, and how far it is through space.
    ///
    /// Where the normals are within 60° of each other the way is that through space. Beyond it is
    /// laid out flat over the fold, in the tangent plane at `of`, and so longer than the distance.
    /// No way is longer than the neighbours' distance.
    ///
    /// # Panics
    /// When there is no such point.
    pub fn visit(&self, of: usize, mut visit: impl FnMut(u32, DVec3, f64)) {
        let visit = |slot: usize, way, distance| visit(self.numbers[slot], way, distance);
        self.visit_slots(self.slots[of] as usize, |_| true, visit);
    }

    /// As [`Self::visit`], of those alone that are wanted. All are told by their [`Self::slot`].
    pub(crate) fn visit_slots(
        &self,
        of: usize,
        wanted: impl Fn(usize) -> bool,
        mut visit: impl FnMut(usize, DVec3, f64),
    ) {
        let (p, normal) = self.places[of];
        let limit_sq = self.within * self.within;
        for [start, end] in self.around[self.cell_of[of] as usize] {
            for slot in start as usize..end as usize {
                let (q, other) = self.places[slot];
                let through_space = q - p;
                let distance_sq = through_space.length_squared();
                if distance_sq > limit_sq || slot == of || !wanted(slot) {
                    continue;
                }
                let way = laid_out(through_space, [normal, other], self.within);
                if let Some(way) = way {
                    visit(slot, way, distance_sq.sqrt());
                }
            }
        }
    }

    /// Where a point is in the order of the grid: points near each other mostly are there too.
    pub(crate) fn slot(&self, of: usize) -> usize {
        self.slots[of] as usize
    }

    /// The point in a place of that order.
    pub(crate) fn number(&self, slot: usize) -> u32 {
        self.numbers[slot]
    }

    /// Values in the order of the grid, in that of the points.
    pub(crate) fn by_point<T: Copy>(&self, by_slot: &[T]) -> Vec<T> {
        let slots = self.slots.iter();
        slots.map(|&slot| by_slot[slot as usize]).collect()
    }

    /// Values in the order of the points, in that of the grid.
    pub(crate) fn by_slot<T: Copy>(&self, by_point: &[T]) -> Vec<T> {
        let numbers = self.numbers.iter();
        numbers.map(|&i| by_point[i as usize]).collect()
    }
}

/// The rows of a cell and of those that touch it, where points are sorted by their cells.
fn rows_around(of: u64, cells: &[(u64, u32)]) -> Rows {
    let [x, y, z] = [0, 1, 2].map(|axis| of >> (axis * BITS) & MOST);
    std::array::from_fn(|row| {
        let [dy, dz] = [row as u64 % 3, row as u64 / 3];
        let beside = |c: u64, d: u64| (c + d).checked_sub(1).filter(|&c| c <= MOST);
        let (Some(y), Some(z)) = (beside(y, dy), beside(z, dz)) else {
            return [0; 2];
        };
        let [first, last] = [x.saturating_sub(1), (x + 1).min(MOST)].map(|x| pack([x, y, z]));
        let start = cells.partition_point(|&(c, _)| c < first);
        let row = cells[start..].partition_point(|&(c, _)| c <= last);
        [start, start + row].map(|slot| slot as u32)
    })
}

const MOST: u64 = (1 << BITS) - 1;

/// Cells of one size, numbered from the lowest corner.
struct Grid {
    low: DVec3,
    size: f64,
    /// The cells in each direction that hold points, and their numbers, where there are more in a row than numbers:
    /// empty ones between them are left out, but for one, so that what lay apart does.
    renumbered: Option<[Vec<(u64, u64)>; 3]>,
}

impl Grid {
    fn of<I: Iterator<Item = DVec3>>(points: impl Fn() -> I, size: f64) -> Self {
        let low = points().fold(DVec3::INFINITY, DVec3::min);
        let high = points().fold(DVec3::NEG_INFINITY, DVec3::max);
        let mut grid = Self {
            low,
            size,
            renumbered: None,
        };
        if grid.raw(high).into_iter().any(|last| last > MOST) {
            let axis = |k: usize| renumbered(points().map(|p| grid.raw(p)[k]).collect());
            grid.renumbered = Some([0, 1, 2].map(axis));
        }
        grid
    }

    fn raw(&self, p: DVec3) -> [u64; 3] {
        ((p - self.low) / self.size).to_array().map(|c| c as u64)
    }

    fn cell(&self, p: DVec3) -> [u64; 3] {
        let raw = self.raw(p);
        let Some(renumbered) = &self.renumbered else {
            return raw;
        };
        std::array::from_fn(|k| {
            let cells = &renumbered[k];
            let at = cells.partition_point(|&(cell, _)| cell < raw[k]);
            cells[at].1
        })
    }
}

/// Numbers in the same order, side by side where cells are. Beyond the last all count as the last: neighbours stay
/// neighbours.
fn renumbered(mut cells: Vec<u64>) -> Vec<(u64, u64)> {
    cells.par_sort_unstable();
    cells.dedup();
    let mut last: Option<(u64, u64)> = None;
    let number = |cell: u64| {
        let number = last.map_or(0, |(before, number)| number + (cell - before).min(2));
        last = Some((cell, number));
        (cell, number.min(MOST))
    };
    cells.into_iter().map(number).collect()
}

fn pack([x, y, z]: [u64; 3]) -> u64 {
    (z << (2 * BITS)) | (y << BITS) | x
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::morphometry::test_lichen::{are_near, blob};

    #[test]
    fn neighbours_are_those_of_a_search_through_all() {
        let blob = blob(400, 7);
        for within in [1e-9, 0.05, 0.3, 10.0] {
            let neighbours = Neighbours::new(&blob.positions, &blob.normals, within);
            for i in 0..blob.positions.len() {
                let mut found = Vec::new();
                neighbours.visit(i, |j, way, distance| {
                    let through_space = blob.position(j as usize) - blob.position(i);
                    assert_eq!(distance, through_space.length());
                    assert!(way.length() <= within * (1.0 + 1e-9), "{i} to {j}");
                    found.push(j as usize);
                });
                found.sort_unstable();
                let near = |&j: &usize| j != i && are_near(&blob, [i, j], within);
                let expected: Vec<_> = (0..blob.positions.len()).filter(near).collect();
                assert_eq!(found, expected, "{i} within {within}");
            }
        }
    }

    /// Or all would be asked of each.
    #[test]
    fn a_far_point_leaves_the_others_their_cells() {
        let mut blob = blob(400, 7);
        let cells = |positions: &[[f64; 3]]| {
            let normals = vec![[0.0, 0.0, 1.0]; positions.len()];
            Neighbours::new(positions, &normals, 0.05).around.len()
        };
        let alone = cells(&blob.positions);
        for far in [1e9, -1e9, 1e300] {
            blob.positions.push([far, 0.0, far]);
            let found = cells(&blob.positions);
            // Cells of a corner elsewhere.
            assert!(found > alone / 3, "{far}: {found} of {alone}");
            blob.positions.pop();
        }
    }

    /// With more cells in a row than numbers for them.
    #[test]
    fn a_far_point_keeps_the_others_neighbours() {
        let positions = [
            [0.0; 3],
            [0.5, 0.0, 0.0],
            [1e12, 0.0, 0.0],
            [1e12, 1.0, 0.0],
        ];
        let neighbours = Neighbours::new(&positions, &[[0.0, 0.0, 1.0]; 4], 1.0);
        for (i, expected) in [1, 0, 3, 2].into_iter().enumerate() {
            let mut found = Vec::new();
            neighbours.visit(i, |j, _, _| found.push(j));
            assert_eq!(found, [expected]);
        }
    }
}
