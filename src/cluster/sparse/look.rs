//! How near the nearest centre is to a place.

use std::hint::select_unpredictable;

use glam::DVec3;

use super::block::{Block, coarsen};
use super::corners::{Corners, Inside, NOTHING_SEEN, Said, Samples, Spot};
use super::field::{Distances, address};
use super::touching::Touch;
use super::{CONTACT, ElementIndex, NewBlock, Notes, Read, SparseIndex, is_near};
use crate::cluster::{Look, Population};

/// A bound below this many radii serves no better than contact: growth's steps are a radius then.
/// As elements are added it only sinks, along with all that led to it.
const NEAR: f64 = 3.0;

/// A bound of this many cells is worth more than a look at the next finer grid.
const GOOD: f64 = 1.9;

impl SparseIndex {
    /// How near the nearest centre is. The place comes in registers: what is in memory has just been written, and is
    /// waited for.
    #[inline(never)]
    pub(super) fn look_at(
        &self,
        elements: &Population<'_>,
        x: f64,
        y: f64,
        z: f64,
        notes: &mut Notes,
    ) -> Look {
        let position = DVec3 { x, y, z };
        if notes.level == 0 {
            let spot = self.scale.spot(position);
            let cell = spot.cell();
            if let Some(number) = self.tree.follow_near(&mut notes.path, cell) {
                let inside = spot.inside(0);
                let corners = Corners::about(inside);
                let samples = self.finest.blocks.distances[number].about(corners.first);
                let said = samples.said();
                if said != NOTHING_SEEN {
                    let clear = corners.bound(samples, &self.clear);
                    if notes.remembers {
                        let read = Read::new(0, number, &corners, said);
                        notes.keep_one_of(position, read, clear < NEAR * self.radius);
                    }
                    // Asked of all places here, for how near it is is not to be foreseen.
                    let touching = match self.finest.touch(number, inside) {
                        Touch::No => false,
                        Touch::Yes => true,
                        Touch::Unsure => self.touches_in((number, inside), elements, position),
                    };
                    return look_near(clear, touching);
                }
            }
        }
        self.search(elements, x, y, z, notes)
    }

    /// Looks at one grid after the other for the one that can tell most.
    ///
    /// The search begins with the grid that answered last: a step seldom changes the scale. What a grid
    /// said is remembered only if less would have led elsewhere: as elements are added bounds only sink.
    #[inline(never)]
    fn search(&self, elements: &Population<'_>, x: f64, y: f64, z: f64, notes: &mut Notes) -> Look {
        let position = DVec3 { x, y, z };
        let spot = self.scale.spot(position);
        // As above, to the last part: which of the two is asked may depend on what other walkers have made.
        let (outside, spot) = match self.tree.holds(spot.cell()) {
            true => (0.0, spot),
            false => self.nearest_in_grids(position),
        };
        let cell = spot.cell();
        let mut coarser_says: Option<(f64, Option<Read>)> = None;
        let mut finer_says = f64::NEG_INFINITY;
        loop {
            let level = notes.level;
            let size = f64::from(1u32 << (2 * level));
            let corners = Corners::about(spot.inside(level));
            let (samples, read) = self.said(elements, level, (cell, &corners), notes);
            let (said, bound) = (samples.said(), corners.bound(samples, &self.cells));
            let here = bound * size - outside;
            if level == 0 && said != NOTHING_SEEN {
                let number = read.as_ref().map(|read| read.block);
                if here >= NEAR {
                    notes.keep(read);
                } else if notes.remembers {
                    notes.near.push(position);
                }
                let touching = here < CONTACT
                    && match number {
                        Some(number) => {
                            self.touches_in((number, spot.inside(0)), elements, position)
                        }
                        None => self.touches(elements, position),
                    };
                return look_near(clear(here) * self.radius, touching);
            }
            if said == NOTHING_SEEN && level < self.tree.top() {
                notes.keep(read);
                if let Some((bound, read)) = coarser_says {
                    notes.keep_if(read, bound > here);
                    return self.nothing_nearer_than(here.max(bound));
                }
                finer_says = here;
                notes.level = level + 1;
            } else if finer_says > 0.0 || here >= GOOD * size || level == 0 {
                notes.keep_if(read, here > finer_says);
                return self.nothing_nearer_than(here.max(finer_says));
            } else {
                coarser_says = Some((here, read));
                notes.level = level - 1;
            }
        }
    }

    /// The nearest place in the grids to one outside, and how far that is.
    #[cold]
    fn nearest_in_grids(&self, position: DVec3) -> (f64, Spot) {
        let p = self.scaled(position);
        let in_grids = p.clamp(DVec3::ZERO, DVec3::splat(self.tree.last_cell().into()));
        (p.distance(in_grids), Spot::new(in_grids))
    }

    fn nothing_nearer_than(&self, bound: f64) -> Look {
        Look {
            clear: bound * self.radius,
            touching: false,
        }
    }

    /// What a grid says of a place in a cell; also as something to remember, where the block is there.
    #[inline]
    fn said(
        &self,
        elements: &Population<'_>,
        level: usize,
        (cell, corners): (Block, &Corners),
        notes: &mut Notes,
    ) -> (Samples, Option<Read>) {
        let (block, within) = address(coarsen(cell, 2 * level));
        match self.tree.follow(&mut notes.path, level, cell) {
            Some(number) => {
                if level > 0 {
                    self.tree.fetch_finer(number, within);
                }
                let samples = self.grid(level)[number].about(corners.first);
                let read = Read::new(level, number, corners, samples.said());
                (samples, Some(read))
            }
            None => {
                let new = self.new_block(elements, level, block, notes);
                (new.about(corners.first), None)
            }
        }
    }

    /// A block that is not there, worked out once a walker.
    #[cold]
    fn new_block<'a>(
        &self,
        elements: &Population<'_>,
        level: usize,
        block: Block,
        notes: &'a mut Notes,
    ) -> &'a Distances {
        let noted = |new: &NewBlock| new.level == level && new.block == block;
        let number = notes.new.iter().position(noted).unwrap_or_else(|| {
            let distances = self.survey(level, block, &self.scale.of(elements));
            notes.new.push(NewBlock {
                level,
                block,
                distances,
            });
            notes.new.len() - 1
        });
        &notes.new[number].distances
    }

    /// Whether a place in a block touches a centre.
    fn touches_in(
        &self,
        (number, inside): (u32, Inside),
        elements: &Population<'_>,
        position: DVec3,
    ) -> bool {
        let contact = CONTACT * self.radius;
        let mut ids = self.finest.touching(number, inside);
        ids.any(|id| is_near(elements, id, (position, contact), &mut |_, _| true))
    }

    #[cold]
    fn touches(&self, elements: &Population<'_>, position: DVec3) -> bool {
        let contact = CONTACT * self.radius;
        self.any_within(elements, position, contact, &mut |_, _| true)
    }
}

/// What a bound by the finest grid serves for, in radii.
pub(super) fn clear(bound: f64) -> f64 {
    if bound < NEAR { CONTACT } else { bound }
}

/// The finest grid's answer.
#[inline(always)]
fn look_near(clear: f64, touching: bool) -> Look {
    Look {
        clear: select_unpredictable(touching, 0.0, clear),
        touching,
    }
}

impl Notes {
    /// Remembers a place that is near, or what was read where it is not: without a branch, which is not to be foreseen.
    #[inline(always)]
    fn keep_one_of(&mut self, place: DVec3, read: Read, is_near: bool) {
        self.near.push(place);
        self.near.truncate(self.near.len() - usize::from(!is_near));
        self.reads.push(read);
        self.reads.truncate(self.reads.len() - usize::from(is_near));
    }

    /// Remembers what was read.
    #[inline(always)]
    fn keep(&mut self, read: Option<Read>) {
        self.keep_if(read, true);
    }

    /// The same if something holds, which is not to be foreseen either.
    #[inline(always)]
    fn keep_if(&mut self, read: Option<Read>, holds: bool) {
        if self.remembers
            && let Some(read) = read
        {
            self.reads.push(read);
            self.reads.truncate(self.reads.len() - usize::from(!holds));
        }
    }
}

impl Read {
    #[inline(always)]
    fn new(level: usize, block: u32, corners: &Corners, said: Said) -> Self {
        Self {
            block,
            level: level as u8,
            first: corners.first,
            said,
        }
    }
}
