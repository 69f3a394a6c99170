//! The blocks of all levels as a tree.
//!
//! A block is 4³ cells. Each cell of a level is as large as a block of the next finer one, so blocks
//! that are there have their numbers in the block of the level above, by cell, and the coarsest level
//! has one block that holds everything. This is the tree of Museth's VDB (2013), with one size of node
//! and, as there, a path from which a search begins instead of the root.

use std::sync::atomic::{AtomicU32, AtomicU64, Ordering};

use super::block::{Block, between, bits_between, cell_at, coarsen, within};
use super::slab::Slab;
use crate::ahead::fetch;

/// Levels at most: 4^13 cells along an axis.
pub(super) const MOST_LEVELS: usize = 13;

/// The number of a block that is not there.
const NONE: u32 = u32::MAX;

/// Numbers for some of the blocks of each level; nothing is ever removed.
///
/// Those above the finest level are counted here, whatever their level, the coarsest first. Those of
/// the finest get their numbers from whoever adds them.
pub(super) struct Tree {
    /// The coarsest level.
    top: usize,
    /// The blocks of the next finer level in each.
    finer: Slab<Finer>,
    /// Which of those are there, a bit each.
    taken: Slab<AtomicU64>,
}

/// Numbers of blocks by the cell that they are.
#[repr(align(64))]
struct Finer([AtomicU32; 64]);

impl Default for Finer {
    fn default() -> Self {
        Self([(); 64].map(|()| AtomicU32::new(NONE)))
    }
}

impl Finer {
    /// The number of a block. Whoever has it sees what the block was when it was added.
    #[inline(always)]
    fn number(&self, within: usize) -> u32 {
        self.0[within].load(Ordering::Acquire)
    }
}

/// The blocks that somebody went through last.
#[derive(Default)]
pub(super) struct Path {
    /// The cell of the finest level that it led to.
    cell: Block,
    /// The finest level with a block on it.
    end: usize,
    /// The block of each level from there on up.
    numbers: [u32; MOST_LEVELS],
}

impl Path {
    /// The number of the block of a level on it, where it goes so far.
    pub(super) fn number(&self, level: usize) -> Option<u32> {
        (level >= self.end).then(|| self.numbers[level])
    }
}

impl Tree {
    /// With room for cells of the finest level from 0 to below this, along each axis.
    pub(super) fn new(cells: f64) -> Self {
        let top = (1..MOST_LEVELS).find(|&level| cells <= f64::from(cells_across(level)));
        Self {
            top: top.expect("a radius above a 10-millionth of the box"),
            finer: Slab::of(Finer::default()),
            taken: Slab::of(AtomicU64::new(0)),
        }
    }

    /// The coarsest level.
    #[inline(always)]
    pub(super) fn top(&self) -> usize {
        self.top
    }

    /// The last cell of the finest level, along each axis.
    pub(super) fn last_cell(&self) -> u32 {
        cells_across(self.top) - 1
    }

    /// Whether a cell of the finest level is among those from 0 to the last.
    #[inline(always)]
    pub(super) fn holds(&self, [x, y, z]: Block) -> bool {
        (x | y | z) <= self.last_cell()
    }

    /// Takes memory for so many blocks above the finest level.
    pub(super) fn expect(&mut self, blocks: usize) {
        self.finer.expect(blocks);
        self.taken.expect(blocks);
    }

    /// Makes room for so many more.
    pub(super) fn make_room(&mut self, blocks: usize) {
        self.finer.make_room(blocks);
        self.taken.make_room(blocks);
    }

    /// How many more blocks above the finest level there is room for.
    pub(super) fn room(&self) -> usize {
        self.finer.room().min(self.taken.room())
    }

    /// The path to the finest level's block about a cell, or as far as there are blocks.
    pub(super) fn path_to(&self, cell: Block) -> Path {
        let mut path = Path::default();
        self.begin(&mut path);
        self.follow(&mut path, 0, cell);
        path
    }

    /// A path that is nowhere yet.
    pub(super) fn begin(&self, path: &mut Path) {
        (path.end, path.numbers[self.top]) = (self.top, 0);
    }

    /// The number of a level's block about a cell, if it is there.
    #[inline(always)]
    pub(super) fn follow(&self, path: &mut Path, level: usize, cell: Block) -> Option<u32> {
        let [x, y, z] = [0, 1, 2].map(|axis| cell[axis] ^ path.cell[axis]);
        let common = (x | y | z | 1).ilog2() as usize / 2;
        path.cell = cell;
        path.end = path.end.max(common);
        while path.end > level {
            let place = within(coarsen(cell, 2 * path.end));
            let number = self.finer[path.numbers[path.end]].number(place);
            if number == NONE {
                return None;
            }
            path.end -= 1;
            path.numbers[path.end] = number;
        }
        Some(path.numbers[level])
    }

    /// The number of the finest level's block about a cell, if it is there, for somebody who mostly asks
    /// near where he asked last.
    #[inline(always)]
    pub(super) fn follow_near(&self, path: &mut Path, cell: Block) -> Option<u32> {
        let [x, y, z] = [0, 1, 2].map(|axis| cell[axis] ^ path.cell[axis]);
        if (x | y | z) >> 4 != 0 || path.end > 1 {
            return self.follow_far(path, cell);
        }
        let number = self.finer[path.numbers[1]].number(within(coarsen(cell, 2)));
        (number != NONE).then_some(number)
    }

    #[inline(never)]
    fn follow_far(&self, path: &mut Path, cell: Block) -> Option<u32> {
        self.holds(cell)
            .then(|| self.follow(path, 0, cell))
            .flatten()
    }

    /// Asks for the number of the block that a cell of a block above the finest level is.
    #[inline(always)]
    pub(super) fn fetch_finer(&self, number: u32, within: usize) {
        fetch(self.finer.get(number).map(|block| &block.0[within]));
    }

    /// The number of a block, if it is there.
    #[inline]
    pub(super) fn get(&self, level: usize, block: Block) -> Option<u32> {
        if coarsen(block, 2 * (self.top - level)) != [0; 3] {
            return None;
        }
        let mut number = 0;
        for finer in (level..self.top).rev() {
            number = self.finer[number].number(within(coarsen(block, 2 * (finer - level))));
            if number == NONE {
                return None;
            }
        }
        Some(number)
    }

    /// The number of a block that is not there, but whose block of the next coarser level is: `new`, or
    /// the next where it is not of the finest level.
    pub(super) fn add(&self, level: usize, block: Block, new: u32) -> Option<u32> {
        let above = self.get(level + 1, coarsen(block, 2))?;
        let number = match level {
            0 => new,
            _ => {
                self.taken.take();
                self.finer.take().0
            }
        };
        self.finer[above].0[within(block)].store(number, Ordering::Release);
        let taken = self.taken[above].load(Ordering::Relaxed) | 1 << within(block);
        self.taken[above].store(taken, Ordering::Release);
        Some(number)
    }

    /// Visits a level's blocks from one corner to another, both included.
    #[inline]
    pub(super) fn visit(&self, level: usize, range: [Block; 2], visit: impl FnMut(Block, u32)) {
        self.visit_among(level, &self.taken, range, visit);
    }

    /// The same for blocks whose bit is set in the block of the next coarser level, by its number.
    #[inline]
    pub(super) fn visit_among(
        &self,
        level: usize,
        among: &Slab<AtomicU64>,
        [low, high]: [Block; 2],
        mut visit: impl FnMut(Block, u32),
    ) {
        if level == self.top {
            return visit([0; 3], 0);
        }
        let end = (1 << (2 * (self.top - level))) - 1;
        let range = [low, high.map(|c| c.min(end))];
        self.visit_above(level + 1, range.map(|c| coarsen(c, 2)), |above, number| {
            let left = among[number].load(Ordering::Acquire) & bits_between(above, range);
            self.each(number, above, left, &mut visit);
        });
    }

    /// Visits a level's blocks from one corner to another, by those of the next coarser level, each of
    /// which is looked for.
    #[inline(always)]
    fn visit_above(&self, level: usize, range: [Block; 2], mut visit: impl FnMut(Block, u32)) {
        if level == self.top {
            return visit([0; 3], 0);
        }
        let mut path = Path::default();
        self.begin(&mut path);
        between(range.map(|c| coarsen(c, 2)), |above| {
            let cell = above.map(|c| c << (2 * level + 4));
            let Some(number) = self.follow(&mut path, level + 1, cell) else {
                return;
            };
            let left = self.taken[number].load(Ordering::Acquire) & bits_between(above, range);
            self.each(number, above, left, &mut visit);
        });
    }

    /// Visits the blocks in another whose bits are set.
    #[inline(always)]
    fn each(&self, number: u32, block: Block, mut left: u64, mut visit: impl FnMut(Block, u32)) {
        let numbers = &self.finer[number];
        while left != 0 {
            let bit = left.trailing_zeros();
            visit(cell_at(block, bit), numbers.number(bit as usize));
            left &= left - 1;
        }
    }
}

/// Cells of the finest level that a block of a level holds, along an axis.
fn cells_across(level: usize) -> u32 {
    4 << (2 * level)
}

#[cfg(test)]
mod tests {
    use std::collections::HashMap;

    use super::*;
    use crate::rng::{Purpose, Stream};

    /// A block that is not far from others, with an axis along which all are within a few.
    fn random_block(stream: &mut Stream) -> Block {
        let [x, y] = (stream.in_unit_disc() * 60.0 + 61.0).to_array();
        [x as u32, y as u32, (3.0 * stream.uniform()) as u32]
    }

    /// A tree with some blocks of the finest level, and their numbers.
    fn some_blocks(stream: &mut Stream) -> (Tree, HashMap<Block, u32>) {
        let (mut tree, mut numbers) = (Tree::new(600.0), HashMap::new());
        tree.make_room(4 * 900);
        for new in 0..900 {
            let block = random_block(stream);
            for level in (0..tree.top()).rev() {
                let about = coarsen(block, 2 * level);
                if tree.get(level, about).is_none() {
                    tree.add(level, about, new);
                }
            }
            numbers.entry(block).or_insert(new);
        }
        (tree, numbers)
    }

    #[test]
    fn blocks_are_found_from_the_root_and_from_any_path() {
        let mut stream = Stream::new(4, Purpose::Walker, 0);
        let (tree, numbers) = some_blocks(&mut stream);
        assert_eq!((tree.top(), tree.last_cell()), (4, 1023));
        let (mut path, mut near) = (Path::default(), Path::default());
        tree.begin(&mut path);
        tree.begin(&mut near);
        for _ in 0..4000 {
            let block = random_block(&mut stream);
            let cell = block.map(|c| 4 * c + (4.0 * stream.uniform()) as u32);
            let expected = numbers.get(&block).copied();
            assert_eq!(tree.get(0, block), expected);
            assert_eq!(tree.follow(&mut path, 0, cell), expected);
            assert_eq!(tree.follow_near(&mut near, cell), expected);
            let above = tree.get(2, coarsen(block, 4));
            assert_eq!(tree.follow(&mut path, 2, cell), above);
        }
    }

    #[test]
    fn nothing_is_found_beyond_the_last_cell() {
        let (tree, _) = some_blocks(&mut Stream::new(5, Purpose::Walker, 0));
        let mut path = Path::default();
        tree.begin(&mut path);
        for far in [256, 1 << 20, u32::MAX >> 2] {
            assert_eq!(tree.get(0, [far, 0, 0]), None);
            assert_eq!(tree.follow_near(&mut path, [0, 4 * far, 0]), None);
        }
    }

    #[test]
    fn a_range_holds_what_lies_between_its_corners() {
        let mut stream = Stream::new(6, Purpose::Walker, 0);
        let (tree, numbers) = some_blocks(&mut stream);
        for _ in 0..400 {
            let low = random_block(&mut stream);
            let high = low.map(|c| c + (9.0 * stream.uniform()) as u32);
            let mut found = HashMap::new();
            tree.visit(0, [low, high], |block, number| {
                assert_eq!(found.insert(block, number), None);
            });
            let inside = |block: &Block| (0..3).all(|k| (low[k]..=high[k]).contains(&block[k]));
            let expected = numbers.iter().filter(|(block, _)| inside(block));
            assert_eq!(found, expected.map(|(b, n)| (*b, *n)).collect());
        }
    }
}
