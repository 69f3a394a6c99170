//! The index that growth uses: bytes of distance where it is far, lists of centres where it is near.
//!
//! See [`field`] for distances and [`lists`] for centres. A walker asks one or two cache lines a
//! step: the block of cells about it knows how far the nearest centre is at least, and only within
//! two radii and a cell are centres themselves looked at.

mod block_map;
mod field;
mod lists;

use glam::DVec3;

use super::index::{ElementIndex, Look};
use block_map::{Block, BlockMap, Recent, coarsen};
use field::{Distances, FAR, Gaps, Grid, WINDOW, address, bound, seen_from};
use lists::{CellLists, Chunks, List};

/// Sparse grids over the space that walkers ask about.
pub struct SparseIndex {
    low: DVec3,
    radius: f64,
    inverse: f64,
    positions: Vec<DVec3>,
    /// Centres by blocks of the finest grid.
    small: CellLists,
    /// Centres by cells of the widest ball.
    wide: CellLists,
    finest: Finest,
    /// Cells of 2, 4, 8 … radii.
    coarser: Vec<Grid>,
}

/// The finest grid: cells of one radius, and the centres that can touch each block.
#[derive(Default)]
struct Finest {
    asked: BlockMap,
    distances: Vec<Distances>,
    touching: Vec<List>,
    chunks: Chunks,
}

/// What one walker found out.
#[derive(Default)]
pub struct Notes {
    /// The grid that answered last.
    level: usize,
    /// For each grid, what was looked at last.
    tables: Tables,
    /// How many elements there were.
    known: usize,
    /// Whether what is seen goes into the lists below.
    remembers: bool,
    /// The cells that were looked at, in blocks that were there.
    reads: Vec<Read>,
    /// Places so near to elements that nothing matters but whether they touch.
    near: Vec<DVec3>,
    fine: Vec<FineNote>,
    coarse: Vec<(usize, Block, Distances)>,
}

/// A cell that was looked at, and what it said.
struct Read {
    block: u32,
    level: u8,
    within: u8,
    distance_sq: i16,
}

/// The last table of each grid.
#[derive(Default)]
struct Tables([Recent; MOST_LEVELS]);

/// A block of the finest grid that nobody had asked for.
struct FineNote {
    block: Block,
    distances: Distances,
    /// Offsets from the block's corner.
    touching: Vec<(DVec3, u32)>,
}

/// Grids at most: radii are more than a 10-millionth of the box.
const MOST_LEVELS: usize = 32;

/// Contact distance in radii.
const CONTACT: f64 = 2.0;

/// The grid to begin with: cells of 32 radii. Where it is not the right one, the search costs a few
/// looks more.
const FIRST_LEVEL: usize = 5;

/// A bound below this many radii serves no better than contact: growth's steps are a radius then.
/// As elements are added it only sinks, along with all that led to it.
const NEAR: f64 = 3.0;

/// Cells in a block, along an axis.
const BLOCK: f64 = 4.0;

/// A bound of this many cells is worth more than a look at the next finer grid.
const GOOD: f64 = 3.0;

impl ElementIndex for SparseIndex {
    type Notes = Notes;

    fn new(radius: f64, wide: f64, [low, high]: [DVec3; 2]) -> Self {
        let across = low.distance(high) / (radius * f64::from(WINDOW));
        let levels = across.max(1.0).log2().ceil() as usize;
        assert!(
            levels < MOST_LEVELS,
            "a radius above a 10-millionth of the box"
        );
        Self {
            low: low - radius,
            radius,
            inverse: 1.0 / radius,
            positions: Vec::new(),
            small: CellLists::new(BLOCK),
            wide: CellLists::new((wide / radius).max(BLOCK)),
            finest: Finest::default(),
            coarser: (0..levels).map(|_| Grid::default()).collect(),
        }
    }

    fn insert(&mut self, position: DVec3) {
        let id = self.positions.len() as u32;
        self.positions.push(position);
        let p = self.scaled(position);
        self.small.insert(p, id);
        self.wide.insert(p, id);
        self.finest.insert(p, id);
        let cell = cell_of(p);
        for (i, grid) in self.coarser.iter_mut().enumerate() {
            if !grid.occupy(coarsen(cell, i + 2)) {
                break;
            }
        }
    }

    fn adopt(&mut self, notes: &mut Notes) {
        for mut note in notes.fine.drain(..) {
            self.catch_up(&mut note, notes.known);
            self.finest.keep(&note);
        }
        for (level, block, mut distances) in notes.coarse.drain(..) {
            self.catch_up_coarse(level, block, &mut distances, notes.known);
            self.coarser[level - 1].keep(block, &distances);
        }
    }

    fn holds(&self, notes: &Notes) -> bool {
        let same = |read: &Read| {
            let grid = match read.level {
                0 => &self.finest.distances,
                level => &self.coarser[usize::from(level) - 1].distances,
            };
            grid[read.block as usize][usize::from(read.within)] == read.distance_sq
        };
        let fine = |note: &FineNote| {
            let mut now = note.distances;
            self.lower_fine(note.block, &mut now, notes.known);
            now == note.distances
        };
        let coarse = |(level, block, distances): &(usize, Block, Distances)| {
            let mut now = *distances;
            self.catch_up_coarse(*level, *block, &mut now, notes.known);
            now == *distances
        };
        let limit = (CONTACT * self.radius).powi(2);
        let births = &self.positions[notes.known..];
        let untouched = |p: &DVec3| births.iter().all(|q| q.distance_squared(*p) >= limit);
        notes.near.iter().all(untouched)
            && notes.reads.iter().all(same)
            && notes.fine.iter().all(fine)
            && notes.coarse.iter().all(coarse)
    }

    fn begin(&self, notes: &mut Notes, others_walk: bool) {
        notes.remembers = others_walk;
        notes.level = self.coarser.len().min(FIRST_LEVEL);
        notes.known = self.positions.len();
        notes.reads.clear();
        notes.near.clear();
        notes.fine.clear();
        notes.coarse.clear();
    }

    fn look(&self, position: DVec3, notes: &mut Notes) -> Look {
        let p = self.scaled(position);
        let cell = cell_of(p);
        let top = self.coarser.len();
        let seen_before = notes.reads.len();
        let mut coarser_says: Option<f64> = None;
        let mut finer_says = f64::NEG_INFINITY;
        // The search begins with the grid that answered last: a step seldom changes the scale.
        loop {
            let level = notes.level;
            let size = (1u64 << level) as f64;
            let distance_sq = if level == 0 {
                let (distance_sq, known) = self.finest_distance_sq(cell, notes);
                if distance_sq != FAR {
                    let bound = bound(distance_sq, size, cell, p);
                    if bound < NEAR && notes.remembers {
                        notes.reads.truncate(seen_before);
                        notes.near.push(position);
                    }
                    return self.look_near(position, bound, known, p);
                }
                distance_sq
            } else {
                self.distance_sq(level, cell, notes)
            };
            let here = bound(distance_sq, size, coarsen(cell, level), p);
            if distance_sq == FAR && level < top {
                if let Some(bound) = coarser_says {
                    return self.nothing_nearer_than(bound.max(here));
                }
                finer_says = here;
                notes.level = level + 1;
            } else if finer_says > 0.0 || here >= GOOD * size || level == 0 {
                return self.nothing_nearer_than(here.max(finer_says));
            } else {
                coarser_says = Some(here);
                notes.level = level - 1;
            }
        }
    }

    fn count(&self, position: DVec3, radius: f64) -> usize {
        let p = self.scaled(position);
        let tally = self.wide.tally(p, radius * self.inverse);
        if tally.unsure == 0 {
            return tally.inside as usize;
        }
        let mut n = 0;
        self.within(position, radius, &mut |_, _| n += 1);
        n
    }

    fn within(&self, position: DVec3, radius: f64, visit: &mut dyn FnMut(u32, DVec3)) {
        let (p, reach, limit) = (
            self.scaled(position),
            radius * self.inverse,
            radius * radius,
        );
        let mut one = |id: u32| {
            let q = self.positions[id as usize];
            if q.distance_squared(position) < limit {
                visit(id, q);
            }
        };
        let (block, _) = address(cell_of(p));
        let known = self.finest.asked.get(block).filter(|_| reach <= CONTACT);
        if let Some(number) = known {
            let (list, limit) = (self.finest.touching[number as usize], reach * reach);
            let offset = p - corner_of(block);
            self.finest
                .chunks
                .visit(list, offset, limit as f32, &mut one);
        } else if reach > 1.5 * BLOCK {
            self.wide.visit(p, reach, &mut one);
        } else {
            self.small.visit(p, reach, &mut one);
        }
    }
}

impl SparseIndex {
    /// In units of the radius, from the grids' origin.
    fn scaled(&self, position: DVec3) -> DVec3 {
        (position - self.low) * self.inverse
    }

    fn nothing_nearer_than(&self, bound: f64) -> Look {
        Look {
            clear: bound * self.radius,
            touching: false,
        }
    }

    /// What a grid but the finest says of the cell about a point.
    #[inline]
    fn distance_sq(&self, level: usize, cell: Block, notes: &mut Notes) -> i16 {
        let (block, within) = address(coarsen(cell, level));
        let grid = &self.coarser[level - 1];
        match grid.asked.get_again(block, &mut notes.tables.0[level]) {
            Some(block) => {
                let distance_sq = grid.distances[block as usize][within];
                notes.read(level, block, within, distance_sq);
                distance_sq
            }
            None => self.coarse_note(level, block, notes)[within],
        }
    }

    /// What the finest grid says, and the block's number if it has one.
    #[inline]
    fn finest_distance_sq(&self, cell: Block, notes: &mut Notes) -> (i16, Option<u32>) {
        let (block, within) = address(cell);
        match self.finest.asked.get_again(block, &mut notes.tables.0[0]) {
            Some(block) => {
                let distance_sq = self.finest.distances[block as usize][within];
                notes.read(0, block, within, distance_sq);
                (distance_sq, Some(block))
            }
            None => (self.fine_note(block, notes).distances[within], None),
        }
    }

    /// Lowers a noted block by the elements after the first `known`.
    fn lower_fine(&self, block: Block, distances: &mut Distances, known: usize) {
        for &position in &self.positions[known..] {
            let p = self.scaled(position);
            Gaps::to_centre([block; 2], p).lower(distances, block);
        }
    }

    /// Brings a noted block up to the present.
    fn catch_up(&self, note: &mut FineNote, known: usize) {
        self.lower_fine(note.block, &mut note.distances, known);
        for (id, &position) in self.positions.iter().enumerate().skip(known) {
            let offset = self.scaled(position) - corner_of(note.block);
            if touches(offset) {
                note.touching.push((offset, id as u32));
            }
        }
    }

    fn catch_up_coarse(&self, level: usize, block: Block, distances: &mut Distances, known: usize) {
        for &position in &self.positions[known..] {
            let obstacle = coarsen(cell_of(self.scaled(position)), level + 1);
            Gaps::to_box([block; 2], obstacle).lower(distances, block);
        }
    }

    #[cold]
    fn coarse_note<'a>(&self, level: usize, block: Block, notes: &'a mut Notes) -> &'a Distances {
        let noted = notes
            .coarse
            .iter()
            .position(|n| n.0 == level && n.1 == block);
        let number = noted.unwrap_or_else(|| {
            let distances = self.coarser[level - 1].survey(block);
            notes.coarse.push((level, block, distances));
            notes.coarse.len() - 1
        });
        &notes.coarse[number].2
    }

    #[cold]
    fn fine_note<'a>(&self, block: Block, notes: &'a mut Notes) -> &'a FineNote {
        let noted = notes.fine.iter().position(|n| n.block == block);
        let number = noted.unwrap_or_else(|| {
            notes.fine.push(self.survey(block));
            notes.fine.len() - 1
        });
        &notes.fine[number]
    }

    /// A block of the finest grid, worked out from the centres about it.
    fn survey(&self, block: Block) -> FineNote {
        let corner = corner_of(block);
        let mut note = FineNote {
            block,
            distances: [FAR; 64],
            touching: Vec::new(),
        };
        let low = block.map(|b| b << 2);
        let seen = seen_from(low, low.map(|c| c + 3));
        self.small.visit_cells(seen, |id| {
            let p = self.scaled(self.positions[id as usize]);
            Gaps::to_centre([block; 2], p).lower(&mut note.distances, block);
            if touches(p - corner) {
                note.touching.push((p - corner, id));
            }
        });
        note
    }

    /// The finest grid's answer, and that of the centres where it is too near to tell.
    #[inline]
    fn look_near(&self, position: DVec3, bound: f64, block: Option<u32>, p: DVec3) -> Look {
        let touching = bound < CONTACT && self.touches(position, p, block);
        let clear = match bound {
            _ if touching => 0.0,
            b if b < NEAR => CONTACT,
            b => b,
        };
        Look {
            clear: clear * self.radius,
            touching,
        }
    }

    fn touches(&self, position: DVec3, p: DVec3, block: Option<u32>) -> bool {
        let limit = (CONTACT * CONTACT) as f32;
        if let Some(number) = block {
            let offset = p - corner_of(address(cell_of(p)).0);
            let list = self.finest.touching[number as usize];
            let tally = self.finest.chunks.tally(list, offset, limit);
            if tally.inside > 0 || tally.unsure == 0 {
                return tally.inside > 0;
            }
        }
        let mut touching = false;
        self.within(position, CONTACT * self.radius, &mut |_, _| touching = true);
        touching
    }
}

impl Notes {
    #[inline]
    fn read(&mut self, level: usize, block: u32, within: usize, distance_sq: i16) {
        if self.remembers {
            self.reads.push(Read {
                block,
                level: level as u8,
                within: within as u8,
                distance_sq,
            });
        }
    }
}

/// The cell of the finest grid that holds a point.
#[inline(always)]
fn cell_of(p: DVec3) -> Block {
    [p.x as u32, p.y as u32, p.z as u32]
}

/// The lower corner of a block of the finest grid.
#[inline(always)]
fn corner_of([x, y, z]: Block) -> DVec3 {
    DVec3::new(x.into(), y.into(), z.into()) * BLOCK
}

/// Whether a centre can touch something in a block, given from the block's corner.
fn touches(offset: DVec3) -> bool {
    let gap = offset - offset.clamp(DVec3::ZERO, DVec3::splat(BLOCK));
    gap.length_squared() < CONTACT * CONTACT * (1.0 + 1e-5)
}

impl Finest {
    fn insert(&mut self, p: DVec3, id: u32) {
        let cell = cell_of(p);
        let seen = seen_from(cell, cell);
        let gaps = Gaps::to_centre(seen, p);
        self.asked.visit(seen, |near, number| {
            let number = number as usize;
            gaps.lower(&mut self.distances[number], near);
            let offset = p - corner_of(near);
            if touches(offset) {
                self.chunks.push(&mut self.touching[number], offset, id);
            }
        });
    }

    /// Keeps a block, unless it is there.
    fn keep(&mut self, note: &FineNote) {
        let new = self.distances.len() as u32;
        if self.asked.get_or_insert(note.block, new) != new {
            return;
        }
        let mut list = List::default();
        for &(offset, id) in &note.touching {
            self.chunks.push(&mut list, offset, id);
        }
        self.distances.push(note.distances);
        self.touching.push(list);
    }
}

#[cfg(test)]
mod tests;
