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

    /// A lower bound on the distance from a point to the nearest centre; at least the box's
    /// diagonal without elements. `hint` is scratch that a walker keeps from one question to the next.
    fn clearance(&self, p: DVec3, hint: &mut u8) -> f64;
}

/// Hash grids: one with cells of 2r and one with wide cells hold the centres; a pyramid of grids,
/// each twice as coarse, gives every cell near a centre the number of its ring: how many cells it
/// is away from the nearest one that has a centre in it.
///
/// A point in ring k is at least k − 1 cells away from every centre.
pub struct GridIndex {
    contact: CellLists,
    wide: CellLists,
    rings: Vec<CellMap>,
    positions: Vec<DVec3>,
    radius: f64,
}

impl ElementIndex for GridIndex {
    fn new(radius: f64, wide: f64, diagonal: f64) -> Self {
        let levels = (diagonal / (2.0 * radius)).max(1.0).log2().ceil() as usize + 1;
        Self {
            contact: CellLists::new(2.0 * radius),
            wide: CellLists::new(wide.max(2.0 * radius)),
            rings: (0..levels)
                .map(|k| CellMap::new(2.0 * radius * (1u64 << k) as f64))
                .collect(),
            positions: Vec::new(),
            radius,
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

    fn clearance(&self, p: DVec3, hint: &mut u8) -> f64 {
        let top = self.rings.len() - 1;
        let mut level = (*hint as usize + 1).min(top);
        while level < top && self.rings[level].ring(p) == BEYOND {
            level += 1;
        }
        // Down to where a finer level, its rings half as wide, could not tell more.
        let mut bound = 0.0f64;
        loop {
            let ring = self.rings[level].ring(p);
            bound = bound.max(self.rings[level].clear_distance(p, ring));
            if ring > FINE_ENOUGH || level == 0 {
                *hint = level as u8;
                return if ring <= 1 {
                    self.nearest_in_touching_cells(p)
                } else {
                    bound
                };
            }
            level -= 1;
        }
    }
}

impl GridIndex {
    /// Numbers the rings about a newly occupied cell, on every level where that is news.
    fn mark(&mut self, position: DVec3) {
        for level in &mut self.rings {
            let cell = level.cell(position);
            if level.get(cell) == Some(0) {
                return;
            }
            for (neighbour, ring) in rings_about(cell) {
                if level.get(neighbour).is_none_or(|known| ring < known) {
                    level.set(neighbour, ring);
                }
            }
        }
    }

    fn nearest_in_touching_cells(&self, p: DVec3) -> f64 {
        let farthest = self.contact.heads.clear_distance(p, 2);
        let mut nearest_sq = farthest * farthest;
        self.contact.visit(p, 2.0 * self.radius, |id| {
            nearest_sq = nearest_sq.min(self.positions[id as usize].distance_squared(p));
        });
        nearest_sq.sqrt()
    }
}

/// Rings that are numbered.
const RINGS: i32 = 3;

/// The ring of cells that have no number.
const BEYOND: u32 = RINGS as u32 + 1;

/// Past this ring a finer level tells little more.
const FINE_ENOUGH: u32 = 2;

/// No element follows in a list.
const LAST: u32 = u32::MAX;

/// The cells within the rings about a cell, and which ring each one is in.
fn rings_about(cell: IVec3) -> impl Iterator<Item = (IVec3, u32)> {
    let side = 2 * RINGS + 1;
    (0..side * side * side).map(move |i| {
        let offset = IVec3::new(i % side, i / side % side, i / side / side) - RINGS;
        (cell + offset, offset.abs().max_element() as u32)
    })
}

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
        for z in low.z..=high.z {
            for y in low.y..=high.y {
                for x in low.x..=high.x {
                    let mut id = self.heads.get(IVec3::new(x, y, z)).unwrap_or(LAST);
                    while id != LAST {
                        visit(id);
                        id = self.next[id as usize];
                    }
                }
            }
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

    /// The ring that a point is in.
    fn ring(&self, p: DVec3) -> u32 {
        self.get(self.cell(p)).unwrap_or(BEYOND)
    }

    /// How far a point in a ring is from everything at least: the whole rings within, and the
    /// way to the nearest wall of its own cell.
    fn clear_distance(&self, p: DVec3, ring: u32) -> f64 {
        let share = (p / self.size) - (p / self.size).floor();
        let to_wall = share.min(1.0 - share).min_element();
        (f64::from(ring) - 1.0 + to_wall).max(0.0) * self.size
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
    fn finds_what_brute_force_finds_and_never_overstates_clearance() {
        let mut stream = Stream::new(1, Purpose::Walker, 0);
        let radius = 0.002;
        let mut index = GridIndex::new(radius, 10.0 * radius, 1.5);
        let mut centres: Vec<DVec3> = Vec::new();
        let mut hint = 3;
        assert!(index.clearance(DVec3::ZERO, &mut hint) > 1.5);
        for _ in 0..1500 {
            centres.push(random_point(&mut stream) * 0.2);
            index.insert(centres[centres.len() - 1]);
            let p = random_point(&mut stream);
            let nearest = centres
                .iter()
                .map(|c| c.distance(p))
                .fold(f64::INFINITY, f64::min);
            assert!(index.clearance(p, &mut hint) <= nearest * (1.0 + 1e-12));
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
