//! Where elements are: the questions that growth asks of space.

use glam::{DVec3, IVec3};

/// Answers growth's questions about the elements' centres. Ids are ages.
///
/// Growth depends on nothing else, so an index can be replaced without touching it.
pub trait ElementIndex {
    /// An empty index for elements of this radius within a box of this diagonal; `wide` is the
    /// largest radius that [`within`](Self::within) will be asked for.
    fn new(radius: f64, wide: f64, diagonal: f64) -> Self
    where
        Self: Sized;

    /// Adds the next element.
    fn insert(&mut self, position: DVec3);

    /// Visits every centre nearer than `radius` to a point, in no stated order.
    fn within(&self, p: DVec3, radius: f64, visit: &mut dyn FnMut(u32, DVec3));

    /// The distance from a point to the nearest centre; `at_most` when none is nearer than that.
    fn nearest_distance(&self, p: DVec3, at_most: f64) -> f64;
}

/// Hash grids: one with cells of 2r and one with wide cells hold the centres. A pyramid over the
/// first, each level twice as coarse, knows which cells have a centre in them: an octree without
/// pointers, searched best first for the nearest centre.
pub struct GridIndex {
    contact: CellLists,
    wide: CellLists,
    /// Occupied cells of 4r, 8r and so on.
    occupied: Vec<CellMap>,
    positions: Vec<DVec3>,
}

impl ElementIndex for GridIndex {
    fn new(radius: f64, wide: f64, diagonal: f64) -> Self {
        let levels = (diagonal / (2.0 * radius)).max(1.0).log2().ceil() as usize + 1;
        Self {
            contact: CellLists::new(2.0 * radius),
            wide: CellLists::new(wide.max(2.0 * radius)),
            occupied: (1..levels)
                .map(|k| CellMap::new(2.0 * radius * (1u64 << k) as f64))
                .collect(),
            positions: Vec::new(),
        }
    }

    fn insert(&mut self, position: DVec3) {
        let id = self.positions.len() as u32;
        self.positions.push(position);
        let is_new = self.contact.insert(position, id);
        self.wide.insert(position, id);
        if is_new {
            self.mark(position);
        }
    }

    fn within(&self, p: DVec3, radius: f64, visit: &mut dyn FnMut(u32, DVec3)) {
        let lists = if radius > 2.0 * self.contact.heads.size {
            &self.wide
        } else {
            &self.contact
        };
        let limit = radius * radius;
        lists.visit(p, radius, |id| {
            let q = self.positions[id as usize];
            if q.distance_squared(p) < limit {
                visit(id, q);
            }
        });
    }

    fn nearest_distance(&self, p: DVec3, at_most: f64) -> f64 {
        let mut best_sq = at_most * at_most;
        let level = (0..self.occupied.len())
            .find(|&k| self.size(k) >= at_most)
            .unwrap_or(self.occupied.len());
        let size = self.size(level);
        let reach = at_most.min(size);
        let (low, high) = ((p - reach) / size, (p + reach) / size);
        let (low, high) = (low.floor().as_ivec3(), high.floor().as_ivec3());
        for cell in cells_between(low, high) {
            if box_distance_sq(cell, size, p) < best_sq && self.is_occupied(level, cell) {
                self.search(level, cell, p, &mut best_sq);
            }
        }
        best_sq.sqrt()
    }
}

impl GridIndex {
    /// Marks the coarser cells about a newly occupied one.
    fn mark(&mut self, position: DVec3) {
        for level in &mut self.occupied {
            let cell = level.cell(position);
            if level.get(cell).is_some() {
                return;
            }
            level.set(cell, OCCUPIED);
        }
    }

    /// The cells' size on a level; level 0 is the contact grid.
    fn size(&self, level: usize) -> f64 {
        self.contact.heads.size * (1u64 << level) as f64
    }

    fn is_occupied(&self, level: usize, cell: IVec3) -> bool {
        match level {
            0 => self.contact.heads.get(cell).is_some(),
            _ => self.occupied[level - 1].get(cell).is_some(),
        }
    }

    /// Lowers the least squared distance to what is in an occupied cell.
    fn search(&self, level: usize, cell: IVec3, p: DVec3, best_sq: &mut f64) {
        if level == 0 {
            self.contact.visit_cell(cell, |id| {
                *best_sq = best_sq.min(self.positions[id as usize].distance_squared(p));
            });
            return;
        }
        // The child that holds p, or is nearest to it, first: then those beside it.
        let size = self.size(level - 1);
        let middle = (2 * cell + 1).as_dvec3() * size;
        let first = p.cmpge(middle);
        for turn in 0..8 {
            let upper = |axis: usize| i32::from(first.test(axis) ^ (turn >> axis & 1 == 1));
            let child = 2 * cell + IVec3::new(upper(0), upper(1), upper(2));
            if box_distance_sq(child, size, p) < *best_sq && self.is_occupied(level - 1, child) {
                self.search(level - 1, child, p, best_sq);
            }
        }
    }
}

/// Squared distance from a point to a cell.
fn box_distance_sq(cell: IVec3, size: f64, p: DVec3) -> f64 {
    let low = cell.as_dvec3() * size;
    (p - p.clamp(low, low + size)).length_squared()
}

fn cells_between(low: IVec3, high: IVec3) -> impl Iterator<Item = IVec3> {
    (low.z..=high.z).flat_map(move |z| {
        (low.y..=high.y).flat_map(move |y| (low.x..=high.x).map(move |x| IVec3::new(x, y, z)))
    })
}

/// The value of a cell that has a centre in it.
const OCCUPIED: u32 = 1;

/// No element follows in a list.
const LAST: u32 = u32::MAX;

/// The elements of each cell, as linked lists.
struct CellLists {
    heads: CellMap,
    next: Vec<u32>,
}

impl CellLists {
    fn new(size: f64) -> Self {
        Self {
            heads: CellMap::new(size),
            next: Vec::new(),
        }
    }

    /// Adds an element; true when its cell was empty.
    fn insert(&mut self, p: DVec3, id: u32) -> bool {
        let cell = self.heads.cell(p);
        let head = self.heads.get(cell);
        self.next.push(head.unwrap_or(LAST));
        self.heads.set(cell, id);
        head.is_none()
    }

    /// Visits the elements of all cells that a ball touches.
    fn visit(&self, p: DVec3, radius: f64, mut visit: impl FnMut(u32)) {
        let (low, high) = (self.heads.cell(p - radius), self.heads.cell(p + radius));
        for cell in cells_between(low, high) {
            self.visit_cell(cell, &mut visit);
        }
    }

    fn visit_cell(&self, cell: IVec3, mut visit: impl FnMut(u32)) {
        let mut id = self.heads.get(cell).unwrap_or(LAST);
        while id != LAST {
            visit(id);
            id = self.next[id as usize];
        }
    }
}

/// A hash map from the cells of a cubic grid to numbers, with open addressing.
struct CellMap {
    size: f64,
    slots: Vec<Slot>,
    used: usize,
}

#[derive(Clone, Copy)]
struct Slot {
    cell: IVec3,
    value: u32,
}

/// The value of a slot that holds nothing.
const EMPTY: u32 = u32::MAX;

impl CellMap {
    fn new(size: f64) -> Self {
        Self {
            size,
            slots: vec![
                Slot {
                    cell: IVec3::ZERO,
                    value: EMPTY
                };
                64
            ],
            used: 0,
        }
    }

    fn cell(&self, p: DVec3) -> IVec3 {
        (p / self.size).floor().as_ivec3()
    }

    fn get(&self, cell: IVec3) -> Option<u32> {
        let slot = &self.slots[self.find(cell)];
        (slot.value != EMPTY).then_some(slot.value)
    }

    fn set(&mut self, cell: IVec3, value: u32) {
        if 2 * self.used >= self.slots.len() {
            self.grow();
        }
        let at = self.find(cell);
        self.used += usize::from(self.slots[at].value == EMPTY);
        self.slots[at] = Slot { cell, value };
    }

    /// The slot that holds a cell, or the empty one where it would go.
    fn find(&self, cell: IVec3) -> usize {
        let mask = self.slots.len() - 1;
        let mut at = mix(cell) as usize & mask;
        while self.slots[at].value != EMPTY && self.slots[at].cell != cell {
            at = (at + 1) & mask;
        }
        at
    }

    fn grow(&mut self) {
        let larger = vec![
            Slot {
                cell: IVec3::ZERO,
                value: EMPTY
            };
            2 * self.slots.len()
        ];
        for slot in std::mem::replace(&mut self.slots, larger) {
            if slot.value != EMPTY {
                let at = self.find(slot.cell);
                self.slots[at] = slot;
            }
        }
    }
}

/// Spreads a cell's coordinates over 64 bits.
fn mix(cell: IVec3) -> u64 {
    let word = |x: i32, factor: u64| u64::from(x as u32).wrapping_mul(factor);
    let h = word(cell.x, 0x9e37_79b9_7f4a_7c15)
        ^ word(cell.y, 0xc2b2_ae3d_27d4_eb4f).rotate_left(21)
        ^ word(cell.z, 0x1656_67b1_9e37_79f9).rotate_left(42);
    (h ^ (h >> 32)).wrapping_mul(0xbf58_476d_1ce4_e5b9) >> 20
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rng::{Purpose, Stream};

    fn random_point(stream: &mut Stream) -> DVec3 {
        DVec3::new(stream.uniform(), stream.uniform(), stream.uniform() * 0.1) - 0.5
    }

    #[test]
    fn finds_what_brute_force_finds() {
        let mut stream = Stream::new(1, Purpose::Walker, 0);
        let radius = 0.002;
        let mut index = GridIndex::new(radius, 10.0 * radius, 1.5);
        let mut centres: Vec<DVec3> = Vec::new();
        assert_eq!(index.nearest_distance(DVec3::ZERO, 7.0), 7.0);
        for i in 0..3000 {
            centres.push(random_point(&mut stream) * 0.2);
            index.insert(centres[centres.len() - 1]);
            let p = random_point(&mut stream) * [1.0, 0.3, 0.21][i % 3];
            let nearest = centres
                .iter()
                .map(|c| c.distance(p))
                .fold(f64::INFINITY, f64::min);
            for at_most in [3.0, 1.1 * nearest, 0.9 * nearest] {
                let found = index.nearest_distance(p, at_most);
                assert!(
                    (found - nearest.min(at_most)).abs() < 1e-15,
                    "{found} {nearest}"
                );
            }
        }
        for radius in [2.0 * radius, 4.0 * radius, 10.0 * radius] {
            let p = random_point(&mut stream) * 0.2;
            let mut found = Vec::new();
            index.within(p, radius, &mut |id, _| found.push(id));
            found.sort_unstable();
            let near = |i: &u32| centres[*i as usize].distance(p) < radius;
            let expected: Vec<u32> = (0..centres.len() as u32).filter(near).collect();
            assert_eq!(found, expected);
        }
    }
}
