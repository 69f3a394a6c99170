//! The finest grid: cells of one radius, in blocks that know how far the nearest centre is from their samples, and
//! which centres can touch something in them.

use std::sync::atomic::AtomicU64;

use glam::DVec3;

use super::CONTACT;
use super::block::{Block, coarsen};
use super::corners::Inside;
use super::field::{
    Blocks, Distances, Gaps, Holders, address, lower_by_centre, seen_by, seen_from,
};
use super::slab::Slab;
use super::touching::{Entry, Lines, List, Place, SharedList, Touch};
use super::tree::Tree;

/// Cells in a block, along an axis.
pub(super) const BLOCK: f64 = 4.0;

/// A centre no farther from a block than the root of this can touch something in it, or nearly.
const TOUCHING: f64 = (CONTACT + BESIDE) * (CONTACT + BESIDE);

/// A place may be so far beside the block that it is said to be in.
const BESIDE: f64 = 0.007;

/// A block with greater numbers only is farther than that from all centres: no place in it is more than 1.16 from a
/// sample.
const MAY_TOUCH: u8 = 40;

/// The blocks of the finest grid, by their numbers in the tree. Lengths are in units of the radius.
#[derive(Default)]
pub(super) struct Finest {
    pub(super) blocks: Blocks,
    touching: Slab<SharedList>,
    lines: Lines,
}

/// Centres by their ids, in the grid's units.
pub(super) trait Centres {
    /// One of them; none where it is being born just now.
    fn centre(&self, id: u32) -> Option<DVec3>;
}

/// A place in the grid's units, and how far from it centres are looked for.
#[derive(Clone, Copy)]
pub(super) struct Ball {
    pub(super) p: DVec3,
    pub(super) reach: f64,
}

impl Finest {
    /// Takes memory for what so many elements may take: plain DLA on the plane, as sparse as lichen
    /// grows, has 1.26 blocks and 0.86 lines of centres an element.
    pub(super) fn expect(&mut self, elements: usize) {
        let blocks = elements + elements / 3;
        self.blocks.expect(blocks);
        self.touching.expect(blocks);
        self.lines.expect(elements);
    }

    /// Makes room for so many more blocks and lines.
    pub(super) fn make_room(&mut self, blocks: usize, lines: usize) {
        self.blocks.make_room(blocks);
        self.touching.make_room(blocks);
        self.lines.make_room(lines);
    }

    /// How many more blocks and lines there is room for.
    pub(super) fn room(&self) -> [usize; 2] {
        [
            self.touching.room().min(self.blocks.room()),
            self.lines.room(),
        ]
    }

    /// Adds a centre to the blocks that are there: a line to each at most.
    pub(super) fn insert(&self, tree: &Tree, p: DVec3, id: u32) {
        let cell = cell_of(p);
        let gaps = Gaps::to_centre(p, cell);
        tree.visit(0, seen_from(cell), |near, number| {
            let least = gaps.lower(&self.blocks.distances[number], near);
            if least > MAY_TOUCH {
                return;
            }
            let offset = p - corner_of(near);
            if gaps_sq(offset) <= TOUCHING {
                let entry = Entry::new(offset, id);
                self.lines.push(&self.touching[number], entry);
            }
        });
    }

    /// Keeps a block with the next number, and the centres that can touch something in it.
    pub(super) fn keep(&self, distances: &Distances, entries: Vec<Entry>) -> u32 {
        let number = self.blocks.keep(distances);
        let (_, list) = self.touching.take();
        for entry in entries {
            self.lines.push(list, entry);
        }
        number
    }

    /// The centres that can touch something in a block.
    pub(super) fn entries(
        &self,
        tree: &Tree,
        block: Block,
        distances: &Distances,
        centres: &impl Centres,
    ) -> Vec<Entry> {
        let mut entries = Vec::new();
        if distances.0.iter().all(|&d| d > MAY_TOUCH) {
            return entries;
        }
        let around = Ball {
            p: corner_of(block) + 0.5 * (BLOCK - 1.0),
            reach: 0.5 * BLOCK * 3f64.sqrt() + CONTACT + BESIDE,
        };
        self.visit(tree, around, centres, &mut |id, q| {
            let offset = q - corner_of(block);
            if gaps_sq(offset) <= TOUCHING {
                entries.push(Entry::new(offset, id));
            }
        });
        entries
    }

    /// The distances of a block, worked out from the centres about it.
    ///
    /// Which blocks hold some is given by the numbers of the next coarser level's.
    pub(super) fn survey(
        &self,
        tree: &Tree,
        block: Block,
        holding: &Slab<AtomicU64>,
        centres: &impl Centres,
    ) -> Distances {
        let mut holders = Holders::about(block, BLOCK as u32);
        let seen = seen_by(block).map(|cell| coarsen(cell, 2));
        tree.visit_among(0, holding, seen, |near, number| holders.add(near, number));
        holders.nearest_first(|distances, near, number| {
            self.each_inside(near, number, DVec3::ZERO, f64::INFINITY, centres, |_, q| {
                lower_by_centre(distances, block, q);
            });
        })
    }

    /// Whether a place touches a centre, by its block.
    #[inline]
    pub(super) fn touch(&self, number: u32, inside: Inside) -> Touch {
        self.lines.touch(self.list(number), Place::new(inside))
    }

    /// The ids of those that may touch a place, by its block.
    pub(super) fn touching(&self, number: u32, inside: Inside) -> impl Iterator<Item = u32> {
        self.lines.touching(self.list(number), Place::new(inside))
    }

    #[inline(always)]
    fn list(&self, number: u32) -> List {
        self.touching[number].get()
    }

    /// Visits all centres nearer than the ball's reach, and perhaps some others.
    pub(super) fn visit(
        &self,
        tree: &Tree,
        ball: Ball,
        centres: &impl Centres,
        visit: &mut dyn FnMut(u32, DVec3),
    ) {
        near(tree, ball, |block, number, offset| {
            self.each_inside(block, number, offset, ball.reach, centres, &mut *visit);
        });
    }

    /// Visits the centres in a block that are within a distance of a place, and perhaps others in
    /// it.
    fn each_inside(
        &self,
        block: Block,
        number: u32,
        offset: DVec3,
        reach: f64,
        centres: &impl Centres,
        mut visit: impl FnMut(u32, DVec3),
    ) {
        for id in self.lines.inside(self.list(number), offset, reach) {
            let Some(q) = centres.centre(id) else {
                continue;
            };
            // A centre is in the lists of several blocks, but only in one block.
            if address(cell_of(q)).0 == block {
                visit(id, q);
            }
        }
    }
}

/// The blocks that have places in a ball, with the ball's middle relative to each.
#[inline]
fn near(tree: &Tree, Ball { p, reach }: Ball, mut visit: impl FnMut(Block, u32, DVec3)) {
    let low = address(cell_of((p - reach).max(DVec3::ZERO))).0;
    let high = address(cell_of(p + reach)).0;
    let limit = reach * reach * (1.0 + 1e-5);
    tree.visit(0, [low, high], |block, number| {
        let offset = p - corner_of(block);
        if gaps_sq(offset) <= limit {
            visit(block, number, offset);
        }
    });
}

/// The cell of the finest grid that holds a point: the nearest whole numbers.
#[inline(always)]
pub(super) fn cell_of(p: DVec3) -> Block {
    rounded(p)
}

/// The nearest whole numbers.
#[inline(always)]
pub(super) fn rounded(p: DVec3) -> [u32; 3] {
    (p + SHIFT).to_array().map(|x| x.to_bits() as u32)
}

/// What is added to it loses all digits behind the point, and ends in its bits as an integer.
const SHIFT: f64 = (3u64 << 51) as f64;

/// The middle of a block's lowest cell.
#[inline(always)]
fn corner_of([x, y, z]: Block) -> DVec3 {
    DVec3::new(x.into(), y.into(), z.into()) * BLOCK
}

/// Squared distance of a place from a block.
#[inline(always)]
fn gaps_sq(offset: DVec3) -> f64 {
    gap_sq(offset.x) + gap_sq(offset.y) + gap_sq(offset.z)
}

/// Squared distance along an axis to a block, from a place given relative to the middle of its
/// lowest cell.
#[inline(always)]
fn gap_sq(offset: f64) -> f64 {
    let gap = (-0.5 - offset).max(offset - (BLOCK - 0.5)).max(0.0);
    gap * gap
}
