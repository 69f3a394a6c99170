//! Lists of centres by the cell of a cubic grid that they are in.
//!
//! Centres are kept eight to a chunk, coordinate by coordinate and relative to their cell, so that
//! f32 resolves them and all of a chunk are tested at once. What f32 cannot decide
//! is decided again from the full positions.

use glam::{DVec3, Vec3};
use rustc_hash::FxHashMap;
use wide::f32x8;

use super::block::{Block, about, between};
use super::make_room;
use crate::ahead::fetch;

/// Eight centres, relative to the corner of their cell; free places are infinitely far away.
#[derive(Clone)]
#[repr(align(64))]
struct Chunk {
    x: [f32; LANES],
    y: [f32; LANES],
    z: [f32; LANES],
    id: [u32; LANES],
}

const LANES: usize = 8;

const FREE: Chunk = Chunk {
    x: [f32::INFINITY; LANES],
    y: [f32::INFINITY; LANES],
    z: [f32::INFINITY; LANES],
    id: [u32::MAX; LANES],
};

/// No chunk.
const NONE: u32 = u32::MAX;

/// A linked list of chunks; only the first may have free places.
#[derive(Clone, Copy)]
pub(super) struct List {
    head: u32,
    len: u32,
}

impl Default for List {
    fn default() -> Self {
        Self { head: NONE, len: 0 }
    }
}

/// Storage of the chunks of many lists.
#[derive(Default)]
pub(super) struct Chunks {
    chunks: Vec<Chunk>,
    next: Vec<u32>,
}

/// Cells up to this many times as large as a ball's radius are looked through faster than the finest
/// grid: eight centres take no longer there than one here.
const MOST_SIZES: f64 = 5.0;

/// Squared distances off by this share of the limit, or less, are not decided in f32. Rounding
/// adds up to less than a third of it for cells as large as that.
const UNSURE: f32 = 1e-5;

impl Chunks {
    pub(super) fn push(&mut self, list: &mut List, offset: DVec3, id: u32) {
        let lane = list.len as usize % LANES;
        if lane == 0 {
            self.next.push(list.head);
            self.chunks.push(FREE);
            list.head = self.chunks.len() as u32 - 1;
        }
        let chunk = &mut self.chunks[list.head as usize];
        (chunk.x[lane], chunk.y[lane], chunk.z[lane]) =
            (offset.x as f32, offset.y as f32, offset.z as f32);
        chunk.id[lane] = id;
        list.len += 1;
    }

    /// Counts the centres of a list that may be within √`limit` of a point.
    fn count(&self, list: List, p: DVec3, limit: f32) -> u32 {
        let (p, possible) = (p.as_vec3(), limit * (1.0 + UNSURE));
        let mut counts = f32x8::splat(0.0);
        let mut at = list.head;
        while at != NONE {
            counts += self.chunks[at as usize].nearer_than(p, possible) & f32x8::splat(1.0);
            at = self.next[at as usize];
        }
        counts.reduce_add() as u32
    }

    /// Whether one of the ids in a list that may be within √`limit` of a point passes a test.
    #[inline(always)]
    fn any(&self, list: List, p: DVec3, limit: f32, mut test: impl FnMut(u32) -> bool) -> bool {
        let (p, possible) = (p.as_vec3(), limit * (1.0 + UNSURE));
        let mut at = list.head;
        while at != NONE {
            let chunk = &self.chunks[at as usize];
            let mut left = chunk.nearer_than(p, possible).to_bitmask();
            while left != 0 {
                if test(chunk.id[left.trailing_zeros() as usize]) {
                    return true;
                }
                left &= left - 1;
            }
            at = self.next[at as usize];
        }
        false
    }

    /// Asks for the first of a list's chunks.
    #[inline(always)]
    fn fetch(&self, list: List) {
        let first = self.chunks.get(list.head as usize);
        fetch(first.map(|chunk| &chunk.x));
        fetch(first.map(|chunk| &chunk.z));
    }
}

/// How many wait to be tested.
const MOST_WAITING: usize = 64;

/// Ids that are still to be tested, so that there is time to read what they are about.
struct Waiting {
    ids: [u32; MOST_WAITING],
    n: usize,
}

impl Default for Waiting {
    fn default() -> Self {
        Self {
            ids: [0; MOST_WAITING],
            n: 0,
        }
    }
}

impl Waiting {
    /// One more; whether one of those before it passes, where it has no place.
    #[inline(always)]
    fn push(&mut self, id: u32, test: &mut dyn FnMut(u32) -> bool) -> bool {
        if self.n == MOST_WAITING && self.any(test) {
            return true;
        }
        self.ids[self.n] = id;
        self.n += 1;
        false
    }

    /// Whether one passes; none waits any longer.
    fn any(&mut self, test: &mut dyn FnMut(u32) -> bool) -> bool {
        let n = std::mem::take(&mut self.n);
        self.ids[..n].iter().any(|id| test(*id))
    }
}

impl Chunk {
    /// Which centres are nearer to a place than the root of a limit.
    #[inline(always)]
    fn nearer_than(&self, p: Vec3, limit: f32) -> f32x8 {
        let [x, y, z] = [(self.x, p.x), (self.y, p.y), (self.z, p.z)]
            .map(|(places, p)| f32x8::new(places) - f32x8::splat(p));
        (x * x + y * y + z * z).simd_lt(f32x8::splat(limit))
    }
}

/// A cell and those that touch it.
const MOST_BESIDE: usize = 27;

/// Centres by cell. Lengths are in units of the radius, and so is the cells' size.
pub(super) struct CellLists {
    size: f64,
    inverse: f64,
    /// Their numbers by their coordinates.
    numbers: FxHashMap<(u32, u32, u32), u32>,
    cells: Vec<Cell>,
    chunks: Chunks,
}

struct Cell {
    corner: DVec3,
    list: List,
    /// The cells that touch this one and hold something, itself included.
    beside: Vec<u32>,
}

/// Cells that a ball may touch.
#[derive(Default)]
struct Touched {
    numbers: [u32; MOST_BESIDE],
    n: usize,
    /// In all of them.
    centres: u32,
}

impl Touched {
    #[inline(always)]
    fn push(&mut self, number: u32, centres: u32) {
        self.numbers[self.n] = number;
        self.n += 1;
        self.centres += centres;
    }

    fn numbers(&self) -> &[u32] {
        &self.numbers[..self.n]
    }
}

/// One length worked out in two ways differs by a smaller share than this.
const ROUNDING: f64 = 1e-12;

impl CellLists {
    /// For balls of up to this radius.
    pub(super) fn new(widest: f64) -> Self {
        let size = widest * (1.0 + ROUNDING);
        Self {
            size,
            inverse: 1.0 / size,
            numbers: FxHashMap::default(),
            cells: Vec::new(),
            chunks: Chunks::default(),
        }
    }

    /// Makes room for what so many elements may take, when half of the places are free.
    pub(super) fn expect(&mut self, elements: usize) {
        make_room(&mut self.chunks.chunks, elements / 4);
        make_room(&mut self.chunks.next, elements / 4);
    }

    pub(super) fn block(&self, p: DVec3) -> Block {
        (p * self.inverse).to_array().map(|x| x as u32)
    }

    pub(super) fn insert(&mut self, p: DVec3, id: u32) {
        let block = self.block(p);
        let new = self.cells.len() as u32;
        let number = *self.numbers.entry(block.into()).or_insert(new);
        if number == new {
            self.add_cell(block);
        }
        let cell = &mut self.cells[number as usize];
        self.chunks.push(&mut cell.list, p - cell.corner, id);
    }

    #[cold]
    fn add_cell(&mut self, block: Block) {
        let new = self.cells.len() as u32;
        let mut beside = Vec::new();
        self.touching(block, |n| beside.push(n));
        for &other in beside.iter().filter(|&&o| o != new) {
            self.cells[other as usize].beside.push(new);
        }
        self.cells.push(Cell {
            corner: DVec3::from(block.map(f64::from)) * self.size,
            list: List::default(),
            beside,
        });
    }

    /// The cells that a ball no larger than a cell may touch. The first centres of each are asked for.
    #[inline(always)]
    fn touched(&self, p: DVec3, limit: f64) -> Touched {
        let mut touched = Touched::default();
        let block = self.block(p);
        let mut one = |number: u32| {
            let cell = &self.cells[number as usize];
            let offset = p - cell.corner;
            let half = DVec3::splat(0.5 * self.size);
            let gaps = ((offset - half).abs() - half).max(DVec3::ZERO);
            if gaps.length_squared() < limit {
                self.chunks.fetch(cell.list);
                touched.push(number, cell.list.len);
            }
        };
        match self.numbers.get(&block.into()) {
            Some(&number) => self.cells[number as usize]
                .beside
                .iter()
                .for_each(|&n| one(n)),
            None => self.touching(block, one),
        }
        touched
    }

    /// The cells with these numbers.
    fn cells(&self, numbers: &[u32]) -> impl Iterator<Item = &Cell> {
        numbers.iter().map(|number| &self.cells[*number as usize])
    }

    /// Visits the numbers of a cell and of those that touch it.
    fn touching(&self, block: Block, mut visit: impl FnMut(u32)) {
        between(about(block, 1), |beside| {
            if let Some(&number) = self.numbers.get(&beside.into()) {
                visit(number);
            }
        });
    }

    /// Whether balls of this radius are looked for here faster than in the finest grid.
    pub(super) fn holds(&self, radius: f64) -> bool {
        radius <= self.size && self.size <= MOST_SIZES * radius
    }

    /// At least the number of centres within a radius that is [held](Self::holds): less than
    /// `enough`, or all that f32 cannot tell from those.
    ///
    /// A list counts whole until it is looked at.
    pub(super) fn at_most(&self, p: DVec3, radius: f64, enough: usize) -> usize {
        let limit = radius * radius;
        let touched = self.touched(p, limit);
        let mut most = touched.centres;
        for Cell { corner, list, .. } in self.cells(touched.numbers()) {
            if (most as usize) < enough {
                break;
            }
            most = most - list.len + self.chunks.count(*list, p - corner, limit as f32);
        }
        most as usize
    }

    /// Whether one that may be within a radius that is [held](Self::holds) passes a test. `ahead` is told of
    /// each some time before it is tested.
    pub(super) fn any(
        &self,
        p: DVec3,
        radius: f64,
        ahead: impl Fn(u32),
        test: &mut dyn FnMut(u32) -> bool,
    ) -> bool {
        let limit = radius * radius;
        let touched = self.touched(p, limit);
        let mut waiting = Waiting::default();
        let mut cells = self.cells(touched.numbers());
        let found = cells.any(|Cell { corner, list, .. }| {
            self.chunks.any(*list, p - corner, limit as f32, |id| {
                ahead(id);
                waiting.push(id, test)
            })
        });
        found || waiting.any(test)
    }
}
