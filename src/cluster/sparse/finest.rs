//! The finest grid: cells of one radius, in blocks that know how far the nearest centre is from
//! each of their cells, and which centres can touch something in them.

use glam::DVec3;

use super::CONTACT;
use super::block::{Block, coarsen};
use super::field::{Distances, Gaps, Holders, address, lower_by_centre, seen_by, seen_from};
use super::make_room;
use super::touching::{Entry, Lines, List, Place, Touch};
use super::tree::Tree;

/// Cells in a block, along an axis.
pub(super) const BLOCK: f64 = 4.0;

/// A centre no farther from a block than the root of this can touch something in it, or nearly.
const TOUCHING: f64 = CONTACT * CONTACT * (1.0 + 1e-5);

/// A block with greater numbers only is farther than that from all centres: its cells reach 0.87 from their
/// middles.
const MAY_TOUCH: u8 = 33;

/// The blocks of the finest grid, by their numbers in the tree. Lengths are in units of the radius.
#[derive(Default)]
pub(super) struct Finest {
    pub(super) distances: Vec<Distances>,
    /// Which cells hold centres, a bit each.
    pub(super) occupied: Vec<u64>,
    touching: Vec<List>,
    lines: Lines,
}

/// Centres by their ids, in the grid's units.
pub(super) trait Centres {
    /// One of them.
    fn centre(&self, id: u32) -> DVec3;
}

/// A place in the grid's units, and how far from it centres are looked for.
#[derive(Clone, Copy)]
pub(super) struct Ball {
    pub(super) p: DVec3,
    pub(super) reach: f64,
}

impl Finest {
    /// Makes room for what so many elements may take: plain DLA on the plane, as sparse as lichen
    /// grows, has 1.26 blocks and 0.86 lines of centres an element.
    pub(super) fn expect(&mut self, elements: usize) {
        let blocks = elements + elements / 3;
        make_room(&mut self.distances, blocks);
        make_room(&mut self.occupied, blocks);
        make_room(&mut self.touching, blocks);
        self.lines.expect(elements);
    }

    /// Adds a centre to the blocks that are there.
    pub(super) fn insert(&mut self, tree: &Tree, p: DVec3, id: u32) {
        let cell = cell_of(p);
        let gaps = Gaps::to_centre(p, cell);
        tree.visit(0, seen_from(cell), |near, number| {
            let least = gaps.lower(&mut self.distances[number as usize], near);
            if least > MAY_TOUCH {
                return;
            }
            let offset = p - corner_of(near);
            if gaps_sq(offset) <= TOUCHING {
                let entry = Entry::new(offset, id);
                self.lines.push(&mut self.touching[number as usize], entry);
            }
        });
    }

    /// Keeps the block with the next number.
    pub(super) fn keep(
        &mut self,
        tree: &Tree,
        block: Block,
        distances: &Distances,
        centres: &impl Centres,
    ) {
        let mut list = List::default();
        for entry in self.entries(tree, block, distances, centres) {
            self.lines.push(&mut list, entry);
        }
        self.distances.push(*distances);
        self.occupied.push(0);
        self.touching.push(list);
    }

    /// The centres that can touch something in a block.
    fn entries(
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
            reach: 0.5 * BLOCK * 3f64.sqrt() + CONTACT,
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
        holding: &[u64],
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
    pub(super) fn touch(&self, number: u32, p: DVec3) -> Touch {
        let list = self.touching[number as usize];
        self.lines.touch(list, Place::new(p))
    }

    /// The ids of those that may touch a place, by its block.
    pub(super) fn touching(&self, number: u32, p: DVec3) -> impl Iterator<Item = u32> {
        let list = self.touching[number as usize];
        self.lines.touching(list, Place::new(p))
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
        let list = self.touching[number as usize];
        for id in self.lines.inside(list, offset, reach) {
            let q = centres.centre(id);
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

/// The middle of that cell.
#[inline(always)]
pub(super) fn middle_of(p: DVec3) -> DVec3 {
    (p + SHIFT) - SHIFT
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
