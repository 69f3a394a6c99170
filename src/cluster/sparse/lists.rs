//! Lists of centres by the cell of a cubic grid that they are in.
//!
//! Centres are kept eight to a chunk, coordinate by coordinate and relative to their cell, so that
//! f32 resolves them and all of a chunk are tested at once. What f32 cannot decide
//! is decided again from the full positions.

use std::hash::Hasher;
use std::sync::atomic::{AtomicU32, AtomicU64, Ordering};

use bytemuck::cast;
use glam::{DVec3, Vec3};
use rustc_hash::FxHasher;
use wide::{f32x8, i32x8};

use super::block::{Block, about, between};
use super::lanes::{self, Floats};
use super::slab::Slab;
use crate::ahead::fetch;

/// Eight centres, relative to the corner of their cell; free places are infinitely far away.
#[repr(align(64))]
struct Chunk {
    /// Along each axis.
    places: Floats,
    id: [AtomicU32; LANES],
}

const LANES: usize = 8;

impl Default for Chunk {
    fn default() -> Self {
        Self {
            places: [(); 3 * LANES].map(|()| AtomicU32::new(f32::INFINITY.to_bits())),
            id: [(); LANES].map(|()| AtomicU32::new(u32::MAX)),
        }
    }
}

/// No chunk.
const NONE: u32 = u32::MAX;

/// A linked list of chunks; only the first may have free places.
#[derive(Clone, Copy, Default)]
struct List {
    head: u32,
    len: u32,
}

/// The same where walkers may read it while a birth adds to it.
struct SharedList(AtomicU64);

impl Default for SharedList {
    fn default() -> Self {
        Self(AtomicU64::new(NONE.into()))
    }
}

impl SharedList {
    /// As it is now. Whoever has it sees what is in its chunks.
    #[inline(always)]
    fn get(&self) -> List {
        let both = self.0.load(Ordering::Acquire);
        List {
            head: both as u32,
            len: (both >> 32) as u32,
        }
    }

    fn set(&self, List { head, len }: List) {
        let both = u64::from(len) << 32 | u64::from(head);
        self.0.store(both, Ordering::Release);
    }
}

/// Storage of the chunks of many lists.
#[derive(Default)]
struct Chunks {
    chunks: Slab<Chunk>,
    next: Slab<AtomicU32>,
}

/// Cells up to this many times as large as a ball's radius are looked through faster than the finest
/// grid: eight centres take no longer there than one here.
const MOST_SIZES: f64 = 5.0;

/// Squared distances off by this share of the limit, or less, are not decided in f32. Rounding
/// adds up to less than a third of it for cells as large as that.
const UNSURE: f32 = 1e-5;

impl Chunks {
    fn push(&self, shared: &SharedList, offset: DVec3, id: u32) {
        let List { mut head, len } = shared.get();
        let lane = len as usize % LANES;
        if lane == 0 {
            self.next.take().1.store(head, Ordering::Relaxed);
            head = self.chunks.take().0;
        }
        let chunk = &self.chunks[head];
        chunk.id[lane].store(id, Ordering::Relaxed);
        for (axis, place) in offset.as_vec3().to_array().into_iter().enumerate() {
            chunk.places[axis * LANES + lane].store(place.to_bits(), Ordering::Relaxed);
        }
        shared.set(List { head, len: len + 1 });
    }

    /// Counts the centres of a list that may be within √`limit` of a point.
    fn count(&self, list: List, p: DVec3, limit: f32) -> u32 {
        let (p, possible) = (p.as_vec3(), limit * (1.0 + UNSURE));
        let mut counts = i32x8::splat(0);
        let mut at = list.head;
        while at != NONE {
            // What is nearer is -1.
            counts -= cast::<f32x8, i32x8>(self.chunks[at].nearer_than(p, possible));
            at = self.next(at);
        }
        counts.reduce_add() as u32
    }

    /// Whether one of the ids in a list that may be within √`limit` of a point passes a test.
    #[inline(always)]
    fn any(&self, list: List, p: DVec3, limit: f32, mut test: impl FnMut(u32) -> bool) -> bool {
        let (p, possible) = (p.as_vec3(), limit * (1.0 + UNSURE));
        let mut at = list.head;
        while at != NONE {
            let chunk = &self.chunks[at];
            let mut left = chunk.nearer_than(p, possible).to_bitmask();
            while left != 0 {
                if test(chunk.id[left.trailing_zeros() as usize].load(Ordering::Relaxed)) {
                    return true;
                }
                left &= left - 1;
            }
            at = self.next(at);
        }
        false
    }

    #[inline(always)]
    fn next(&self, at: u32) -> u32 {
        self.next[at].load(Ordering::Relaxed)
    }

    /// Asks for the first of a list's chunks.
    #[inline(always)]
    fn fetch(&self, list: List) {
        let first = self.chunks.get(list.head);
        fetch(first.map(|chunk| &chunk.places[0]));
        fetch(first.map(|chunk| &chunk.places[2 * LANES]));
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
        let [x, y, z] = lanes::floats(&self.places);
        let (x, y, z) = (
            x - f32x8::splat(p.x),
            y - f32x8::splat(p.y),
            z - f32x8::splat(p.z),
        );
        (x * x + y * y + z * z).simd_lt(f32x8::splat(limit))
    }
}

/// A cell and those that touch it.
const MOST_BESIDE: usize = 27;

/// Centres by cell. Lengths are in units of the radius, and so is the cells' size.
pub(super) struct CellLists {
    size: f64,
    inverse: f64,
    cells: Slab<Cell>,
    /// Their numbers, each at the first free place from where its coordinates say; a power of two, half of them free.
    numbers: Vec<AtomicU32>,
    chunks: Chunks,
}

#[derive(Default)]
struct Cell {
    block: [AtomicU32; 3],
    /// The bits of its lowest corner.
    corner: [AtomicU64; 3],
    list: SharedList,
    /// The cells that touch this one and hold something, itself included.
    beside: [AtomicU32; MOST_BESIDE],
    n: AtomicU32,
}

impl Cell {
    #[inline(always)]
    fn block(&self) -> Block {
        [0, 1, 2].map(|axis| self.block[axis].load(Ordering::Relaxed))
    }

    /// The numbers of those beside it.
    #[inline(always)]
    fn beside(&self) -> impl Iterator<Item = u32> {
        let n = self.n.load(Ordering::Acquire) as usize;
        self.beside[..n].iter().map(|n| n.load(Ordering::Relaxed))
    }

    fn add_beside(&self, number: u32) {
        let n = self.n.load(Ordering::Relaxed);
        self.beside[n as usize].store(number, Ordering::Relaxed);
        self.n.store(n + 1, Ordering::Release);
    }
}

/// Cells that a ball may touch, and how many centres each had when that was found: others may be added since.
#[derive(Default)]
struct Touched {
    cells: [(u32, u32); MOST_BESIDE],
    n: usize,
    /// In all of them.
    centres: u32,
}

impl Touched {
    #[inline(always)]
    fn push(&mut self, number: u32, centres: u32) {
        self.cells[self.n] = (number, centres);
        self.n += 1;
        self.centres += centres;
    }

    fn cells(&self) -> &[(u32, u32)] {
        &self.cells[..self.n]
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
            cells: Slab::default(),
            numbers: [(); 2].map(|()| AtomicU32::new(NONE)).into(),
            chunks: Chunks::default(),
        }
    }

    /// Takes memory for what so many elements may take, when half of the places are free.
    pub(super) fn expect(&mut self, elements: usize) {
        self.chunks.chunks.expect(elements / 4);
        self.chunks.next.expect(elements / 4);
    }

    /// Makes room for so many more elements.
    pub(super) fn make_room(&mut self, elements: usize) {
        self.chunks.chunks.make_room(elements);
        self.chunks.next.make_room(elements);
        self.cells.make_room(elements);
        let places = 2 * (self.cells.len() + self.cells.room()).next_power_of_two();
        if self.numbers.len() < places {
            self.numbers = (0..places).map(|_| AtomicU32::new(NONE)).collect();
            (0..self.cells.len() as u32).for_each(|number| self.note(number));
        }
    }

    /// How many more elements there is room for.
    pub(super) fn room(&self) -> usize {
        self.chunks.chunks.room().min(self.cells.room())
    }

    pub(super) fn block(&self, p: DVec3) -> Block {
        (p * self.inverse).to_array().map(|x| x as u32)
    }

    pub(super) fn insert(&self, p: DVec3, id: u32) {
        let block = self.block(p);
        let number = self.number(block).unwrap_or_else(|| self.add_cell(block));
        let offset = self.offset_in(number, p);
        self.chunks.push(&self.cells[number].list, offset, id);
    }

    #[cold]
    fn add_cell(&self, block: Block) -> u32 {
        let (new, cell) = self.cells.take();
        for ((own, c), corner) in cell.block.iter().zip(block).zip(&cell.corner) {
            own.store(c, Ordering::Relaxed);
            corner.store((f64::from(c) * self.size).to_bits(), Ordering::Relaxed);
        }
        self.touching(block, |other| cell.add_beside(other));
        cell.add_beside(new);
        self.note(new);
        for other in cell.beside().filter(|&other| other != new) {
            self.cells[other].add_beside(new);
        }
        new
    }

    /// Makes it known that there is a cell.
    fn note(&self, number: u32) {
        let mut place = self.first_place(self.cells[number].block());
        while self.numbers[place].load(Ordering::Relaxed) != NONE {
            place = self.place_after(place);
        }
        self.numbers[place].store(number, Ordering::Release);
    }

    /// The number of the cell of a block, where it holds something.
    #[inline(always)]
    fn number(&self, block: Block) -> Option<u32> {
        let mut place = self.first_place(block);
        loop {
            let number = self.numbers[place].load(Ordering::Acquire);
            if number == NONE {
                return None;
            }
            if self.cells[number].block() == block {
                return Some(number);
            }
            place = self.place_after(place);
        }
    }

    /// Where the number of a block is, or after which.
    #[inline(always)]
    fn first_place(&self, block: Block) -> usize {
        let mut hasher = FxHasher::default();
        block.iter().for_each(|&c| hasher.write_u32(c));
        hasher.finish() as usize & (self.numbers.len() - 1)
    }

    #[inline(always)]
    fn place_after(&self, place: usize) -> usize {
        (place + 1) & (self.numbers.len() - 1)
    }

    /// A place relative to the lowest corner of a cell.
    #[inline(always)]
    fn offset_in(&self, number: u32, p: DVec3) -> DVec3 {
        let bits = |axis: usize| self.cells[number].corner[axis].load(Ordering::Relaxed);
        p - DVec3::from([0, 1, 2].map(|axis| f64::from_bits(bits(axis))))
    }

    /// Finds the cells that a ball no larger than a cell may touch. The first centres of each are asked for.
    #[inline(always)]
    fn find(&self, touched: &mut Touched, p: DVec3, limit: f64) {
        let block = self.block(p);
        let mut one = |number: u32| {
            let cell = &self.cells[number];
            let offset = self.offset_in(number, p);
            let half = DVec3::splat(0.5 * self.size);
            let gaps = ((offset - half).abs() - half).max(DVec3::ZERO);
            if gaps.length_squared() < limit {
                let list = cell.list.get();
                self.chunks.fetch(list);
                touched.push(number, list.len);
            }
        };
        match self.number(block) {
            Some(number) => self.cells[number].beside().for_each(one),
            None => self.touching(block, &mut one),
        }
    }

    /// Visits the numbers of a cell and of those that touch it.
    fn touching(&self, block: Block, mut visit: impl FnMut(u32)) {
        between(about(block, 1), |beside| {
            if let Some(number) = self.number(beside) {
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
    pub(super) fn count_bound(&self, p: DVec3, radius: f64, enough: usize) -> usize {
        let limit = radius * radius;
        let mut touched = Touched::default();
        self.find(&mut touched, p, limit);
        let mut most = touched.centres;
        for &(number, centres) in touched.cells() {
            if (most as usize) < enough {
                break;
            }
            let (list, offset) = (self.cells[number].list.get(), self.offset_in(number, p));
            most = most - centres + self.chunks.count(list, offset, limit as f32);
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
        let mut touched = Touched::default();
        self.find(&mut touched, p, limit);
        let mut waiting = Waiting::default();
        let found = touched.cells().iter().any(|&(number, _)| {
            let (list, offset) = (self.cells[number].list.get(), self.offset_in(number, p));
            self.chunks.any(list, offset, limit as f32, |id| {
                ahead(id);
                waiting.push(id, test)
            })
        });
        found || waiting.any(test)
    }
}
