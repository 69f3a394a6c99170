//! The index that growth uses: bytes of distance where it is far, lists of centres where it is near.
//!
//! See [`field`] for distances and [`lists`] for centres. A walker asks one or two cache lines a
//! step: the block of cells about it knows how far the nearest centre is at least, and only where
//! that leaves in doubt whether one touches are centres themselves looked at.

mod block;
mod corners;
mod field;
mod finest;
mod lanes;
mod lists;
mod look;
mod slab;
mod touching;
mod tree;

use std::hint::black_box;
use std::sync::atomic::{AtomicU32, AtomicUsize, Ordering};

use crossbeam_utils::CachePadded;
use glam::DVec3;

use super::index::{ElementIndex, Look, Mark};
use super::{Element, Population, make_room};
use crate::ahead::fetch;
use block::{Block, coarsen};
use corners::{Parts, Roots, Said, Spot};
use field::{Blocks, Distances, SharedDistances, WINDOW, address, lower_by_cell, lower_by_centre};
use finest::{Ball, Centres, Finest, cell_of};
use lists::CellLists;
use slab::Slab;
use touching::lines_of;
use tree::{MOST_LEVELS, Path, Tree};

/// Sparse grids over the space that walkers ask about.
pub struct SparseIndex {
    radius: f64,
    /// Distances in cells, and how far it is at least by the finest grid, in local units.
    cells: Roots,
    clear: Roots,
    scale: Scale,
    tree: Tree,
    finest: Finest,
    /// Cells of 4, 16, 64 … radii.
    coarser: Blocks,
    /// The last centre that changed each level.
    changed_by: CachePadded<[AtomicU32; MOST_LEVELS]>,
    /// Lines that a block would have taken for which there was no room.
    wanted: AtomicUsize,
    /// Centres by cells of the widest ball, where wide balls are asked for.
    wide: Option<CellLists>,
}

impl std::fmt::Debug for SparseIndex {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("SparseIndex")
            .field("radius", &self.radius)
            .finish_non_exhaustive()
    }
}

/// From the units that elements come in to the grids'.
#[derive(Clone, Copy)]
struct Scale {
    low: DVec3,
    inverse: f64,
    parts: Parts,
}

/// The centres in the grids' units.
struct Scaled<'a> {
    elements: &'a Population<'a>,
    scale: Scale,
}

/// What one walker found out.
#[derive(Default)]
pub struct Notes {
    /// The grid that answered last.
    level: usize,
    /// The blocks that were looked at last.
    path: Path,
    /// How many elements there were.
    known: usize,
    /// Whether what is seen goes into the lists below.
    remembers: bool,
    /// The samples that were looked at, in blocks that were there.
    reads: Vec<Read>,
    /// Places so near to elements that nothing matters but whether they touch.
    near: Vec<DVec3>,
    /// Blocks that nobody had asked for.
    new: Vec<NewBlock>,
}

impl std::fmt::Debug for Notes {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Notes").finish_non_exhaustive()
    }
}

/// Samples that were looked at, and what they said.
struct Read {
    block: u32,
    level: u8,
    first: u8,
    said: Said,
}

/// A block that was worked out by a walker.
struct NewBlock {
    level: usize,
    block: Block,
    distances: Distances,
}

/// Contact distance in radii.
const CONTACT: f64 = 2.0;

/// The grid to begin with: cells of 64 radii. Where it is not the right one, the search costs a few
/// looks more.
const FIRST_LEVEL: usize = 3;

/// Room that is made ahead: blocks of the finest grid and of the others, lines of what can touch something in a
/// block, and centres in wide cells.
const BLOCKS: usize = 512;
const COARSER_BLOCKS: usize = 256;
const LINES: usize = 512;
const CENTRES: usize = 256;

/// A centre is no farther than contact from so many blocks at most: three along an axis, from the middle of one.
const LINES_OF_A_BIRTH: usize = 27;

/// The grids reach beyond the box by this share of its diagonal, as coarser copies of a surface do, and
/// by as many cells more as the finest of them sees: what lies beyond that is far from all centres.
const MARGIN: f64 = 0.25;

impl ElementIndex for SparseIndex {
    type Notes = Notes;

    fn new(radius: f64, wide: Option<f64>, [low, high]: [DVec3; 2]) -> Self {
        let across = low.distance(high) / radius;
        let margin = (MARGIN * across).ceil() + f64::from(WINDOW) + 1.0;
        let wide = wide
            .map(|wide| wide / radius)
            .filter(|&wide| wide > CONTACT);
        let (parts, low) = Parts::before(low - margin * radius, radius);
        let mut coarser = Blocks::default();
        coarser.make_room(1);
        coarser.keep(&Distances::default());
        let mut index = Self {
            radius,
            cells: Roots::new(|cells| cells),
            clear: Roots::new(|cells| look::clear(cells) * radius),
            scale: Scale {
                low,
                inverse: 1.0 / radius,
                parts,
            },
            tree: Tree::new(across + 2.0 * margin),
            finest: Finest::default(),
            coarser,
            changed_by: Default::default(),
            wanted: AtomicUsize::new(0),
            wide: wide.map(CellLists::new),
        };
        index.make_room();
        index
    }

    fn expect(&mut self, elements: usize) {
        self.finest.expect(elements);
        self.tree.expect(elements / 4);
        self.coarser.expect(elements / 4);
        if let Some(wide) = &mut self.wide {
            wide.expect(elements);
        }
    }

    fn make_room(&mut self) {
        let lines = LINES.max(*self.wanted.get_mut() + LINES_OF_A_BIRTH);
        self.finest.make_room(BLOCKS, lines);
        self.tree.make_room(COARSER_BLOCKS);
        self.coarser.make_room(COARSER_BLOCKS);
        if let Some(wide) = &mut self.wide {
            wide.make_room(CENTRES);
        }
    }

    fn insert(&self, elements: &Population<'_>) -> bool {
        let Some((id, last)) = elements.youngest() else {
            return true;
        };
        let p = self.scaled(last.position);
        let cell = cell_of(p);
        let mut path = self.tree.path_to(cell);
        if path.number(0).is_none() {
            self.make(0, address(cell).0, &self.scale.of(elements));
            path = self.tree.path_to(cell);
        }
        let has_room = self.wide.as_ref().is_none_or(|wide| wide.room() > 0)
            && self.finest.room()[1] >= LINES_OF_A_BIRTH;
        if path.number(0).is_none() || !has_room {
            return false;
        }
        self.finest.insert(&self.tree, p, id);
        self.occupy(&path, cell, id);
        if let Some(wide) = &self.wide {
            wide.insert(p, id);
        }
        true
    }

    fn adopt(&self, elements: &Population<'_>, notes: &mut Notes) {
        let centres = self.scale.of(elements);
        for mut new in notes.new.drain(..) {
            self.make(new.level + 1, coarsen(new.block, 2), &centres);
            if self.tree.get(new.level, new.block).is_none() {
                self.catch_up(&mut new, elements.since(notes.known));
                self.keep(new.level, new.block, &new.distances, &centres);
            }
        }
    }

    fn mark(&self, notes: &Notes) -> Mark {
        let seen = [notes.reads.len(), notes.near.len(), notes.new.len()];
        Mark {
            seen: seen.map(|n| n as u32),
            level: notes.level as u32,
        }
    }

    fn held(&self, elements: &Population<'_>, notes: &Notes) -> Mark {
        let young = elements.since(notes.known);
        let unchanged_since = self.unchanged_since(notes.known);
        let same = |read: &Read| {
            if unchanged_since[usize::from(read.level)] {
                return true;
            }
            let now = &self.grid(read.level.into())[read.block];
            now.about(read.first).said() == read.said
        };
        let unchanged = |new: &NewBlock| {
            let mut now = NewBlock { ..*new };
            self.catch_up(&mut now, young.clone());
            now.distances == new.distances
        };
        let contact = CONTACT * self.radius;
        let [low, high] = box_about(&notes.near, contact);
        let births: Vec<DVec3> = young
            .clone()
            .map(|e| e.position)
            .filter(|q| q.cmpge(low).all() && q.cmple(high).all())
            .collect();
        let limit = contact * contact;
        let untouched = |p: &DVec3| births.iter().all(|q| q.distance_squared(*p) >= limit);
        Mark {
            seen: [
                first_not(&notes.reads, same),
                first_not(&notes.near, untouched),
                first_not(&notes.new, unchanged),
            ],
            level: 0,
        }
    }

    fn rewind(&self, known: usize, notes: &mut Notes, mark: Mark) {
        let [reads, near, new] = mark.seen.map(|n| n as usize);
        notes.reads.truncate(reads);
        notes.near.truncate(near);
        notes.new.truncate(new);
        notes.level = mark.level as usize;
        notes.known = known;
    }

    fn begin(&self, known: usize, notes: &mut Notes, others_walk: bool) {
        notes.remembers = others_walk;
        notes.level = self.tree.top().min(FIRST_LEVEL);
        self.tree.begin(&mut notes.path);
        notes.known = known;
        notes.reads.clear();
        notes.near.clear();
        notes.new.clear();
    }

    fn forget(&self, notes: &mut Notes) {
        notes.remembers = false;
        notes.reads.clear();
        notes.near.clear();
    }

    #[inline(always)]
    fn look(&self, elements: &Population<'_>, position: DVec3, notes: &mut Notes) -> Look {
        let DVec3 { x, y, z } = position;
        self.look_at(elements, x, y, z, notes)
    }

    fn count_bound(
        &self,
        elements: &Population<'_>,
        position: DVec3,
        radius: f64,
        enough: usize,
    ) -> usize {
        let (p, reach) = (self.scaled(position), radius * self.scale.inverse);
        if let Some(wide) = self.wide.as_ref().filter(|wide| wide.holds(reach)) {
            return wide.count_bound(p, reach, enough);
        }
        let mut n = 0;
        self.within(elements, position, radius, &mut |_, _| n += 1);
        n
    }

    fn read_ahead(&self, elements: &Population<'_>, position: DVec3) {
        let spot = self.scale.spot(position);
        if let Some(number) = self.tree.get(0, address(spot.cell()).0) {
            let first = self.finest.touching(number, spot.inside(0)).next();
            let first = first.and_then(|id| elements.get(id));
            black_box(first.map(|first| first.position.x));
        }
    }

    fn any_within(
        &self,
        elements: &Population<'_>,
        position: DVec3,
        radius: f64,
        test: &mut dyn FnMut(u32, &Element) -> bool,
    ) -> bool {
        let (p, reach) = (self.scaled(position), radius * self.scale.inverse);
        let mut passes = |id: u32| is_near(elements, id, (position, radius), test);
        let spot = self.scale.spot(position);
        let (block, _) = address(spot.cell());
        let known = self.tree.get(0, block).filter(|_| reach <= CONTACT);
        match (known, &self.wide) {
            (Some(number), _) => self.finest.touching(number, spot.inside(0)).any(passes),
            (_, Some(wide)) if wide.holds(reach) => {
                let ahead = |id: u32| fetch(elements.get(id));
                wide.any(p, reach, ahead, &mut passes)
            }
            _ => {
                let mut found = false;
                let centres = self.scale.of(elements);
                self.finest
                    .visit(&self.tree, Ball { p, reach }, &centres, &mut |id, _| {
                        found = found || passes(id);
                    });
                found
            }
        }
    }

    fn any_touching(
        &self,
        elements: &Population<'_>,
        position: DVec3,
        notes: &mut Notes,
        test: &mut dyn FnMut(u32, &Element) -> bool,
    ) -> bool {
        let (spot, contact) = (self.scale.spot(position), CONTACT * self.radius);
        let Some(number) = self.tree.follow_near(&mut notes.path, spot.cell()) else {
            return self.any_within(elements, position, contact, test);
        };
        let mut ids = self.finest.touching(number, spot.inside(0));
        ids.any(|id| is_near(elements, id, (position, contact), test))
    }
}

/// Whether an element is nearer than a radius to a place and passes a test.
#[inline(always)]
fn is_near(
    elements: &Population<'_>,
    id: u32,
    (position, radius): (DVec3, f64),
    test: &mut dyn FnMut(u32, &Element) -> bool,
) -> bool {
    let near = |e: &&Element| e.position.distance_squared(position) < radius * radius;
    let found = elements.get(id).filter(near);
    found.is_some_and(|element| test(id, element))
}

impl SparseIndex {
    /// For each grid, whether no element after the first so many changed what it says.
    fn unchanged_since(&self, known: usize) -> [bool; MOST_LEVELS] {
        let mut unchanged = [false; MOST_LEVELS];
        for (unchanged, changed_by) in unchanged.iter_mut().zip(&*self.changed_by) {
            *unchanged = (changed_by.load(Ordering::Relaxed) as usize) < known;
        }
        unchanged
    }

    /// In units of the radius, from the grids' origin.
    #[inline(always)]
    fn scaled(&self, position: DVec3) -> DVec3 {
        self.scale.scaled(position)
    }

    fn grid(&self, level: usize) -> &Slab<SharedDistances> {
        match level {
            0 => &self.finest.blocks.distances,
            _ => &self.coarser.distances,
        }
    }

    /// Lowers a noted block by the elements born since.
    fn catch_up<'a>(&self, new: &mut NewBlock, young: impl Iterator<Item = &'a Element>) {
        let block = new.block;
        for element in young {
            let p = self.scaled(element.position);
            match new.level {
                0 => lower_by_centre(&mut new.distances, block, p),
                level => {
                    let obstacle = coarsen(cell_of(p), 2 * level - 2);
                    lower_by_cell(&mut new.distances, block, obstacle);
                }
            }
        }
    }

    /// The distances of a block, worked out from all centres.
    fn survey(&self, level: usize, block: Block, centres: &impl Centres) -> Distances {
        let (finest, coarser) = (&self.finest.blocks.occupied, &self.coarser.occupied);
        match level {
            0 => self.finest.survey(&self.tree, block, coarser, centres),
            1 => field::survey(&self.tree, 1, block, [finest, coarser]),
            _ => field::survey(&self.tree, level, block, [coarser; 2]),
        }
    }

    /// Makes a block and those of the coarser levels about it, where they are not there and there is room.
    fn make(&self, level: usize, block: Block, centres: &impl Centres) {
        if level > self.tree.top() || self.tree.get(level, block).is_some() {
            return;
        }
        self.make(level + 1, coarsen(block, 2), centres);
        let distances = self.survey(level, block, centres);
        self.keep(level, block, &distances, centres);
    }

    /// Keeps a block, where that of the next coarser level is there and there is room.
    fn keep(&self, level: usize, block: Block, distances: &Distances, centres: &impl Centres) {
        if self.tree.get(level + 1, coarsen(block, 2)).is_none() {
            return;
        }
        if level > 0 {
            if self.tree.room().min(self.coarser.room()) > 0 {
                self.coarser.keep(distances);
                self.tree.add(level, block, 0);
            }
            return;
        }
        let entries = self.finest.entries(&self.tree, block, distances, centres);
        let ([blocks, lines], wanted) = (self.finest.room(), lines_of(entries.len()));
        if blocks > 0 && lines >= wanted {
            let new = self.finest.keep(distances, entries);
            self.tree.add(level, block, new);
        } else {
            self.wanted.fetch_max(wanted, Ordering::Relaxed);
        }
    }

    /// Marks a cell of the finest level as occupied, and on coarser levels what holds it, until that was.
    fn occupy(&self, path: &Path, mut cell: Block, id: u32) {
        self.changed_by[0].store(id, Ordering::Relaxed);
        for level in 0..self.tree.top() {
            let (block, within) = address(cell);
            let Some(number) = path.number(level) else {
                return;
            };
            let blocks = match level {
                0 => &self.finest.blocks,
                _ => &self.coarser,
            };
            if !blocks.occupy(number, within) {
                return;
            }
            self.coarser.lower(&self.tree, level + 1, cell);
            self.changed_by[level + 1].store(id, Ordering::Relaxed);
            cell = block;
        }
    }
}

impl Scale {
    /// In units of the radius, from the grids' origin.
    #[inline(always)]
    fn scaled(self, position: DVec3) -> DVec3 {
        (position - self.low) * self.inverse
    }

    #[inline(always)]
    fn spot(self, position: DVec3) -> Spot {
        self.parts.spot(position)
    }

    fn of<'a>(self, elements: &'a Population<'a>) -> Scaled<'a> {
        let scale = self;
        Scaled { elements, scale }
    }
}

impl Centres for Scaled<'_> {
    #[inline(always)]
    fn centre(&self, id: u32) -> Option<DVec3> {
        let element = self.elements.get(id)?;
        Some(self.scale.scaled(element.position))
    }
}

/// The corners of a box that holds some places, a distance wider.
fn box_about(places: &[DVec3], distance: f64) -> [DVec3; 2] {
    let none = [DVec3::INFINITY, DVec3::NEG_INFINITY];
    let [low, high] = places
        .iter()
        .fold(none, |[low, high], p| [low.min(*p), high.max(*p)]);
    [low - distance, high + distance]
}

/// The number of the first that something does not hold for, or how many there are.
fn first_not<T>(all: &[T], holds: impl Fn(&T) -> bool) -> u32 {
    all.iter().position(|one| !holds(one)).unwrap_or(all.len()) as u32
}

#[cfg(test)]
mod tests;
