//! Numbers for some of the blocks of a cubic grid.
//!
//! Tables of 4³ neighbouring blocks are found by hashing, so that a walk over all blocks about a
//! place hashes a few times instead of once a block.

use super::make_room;

/// Coordinates of a block on its grid.
pub(super) type Block = [u32; 3];

/// The coordinates of what holds a block or a cell on a grid 2^bits as coarse.
#[inline(always)]
pub(super) fn coarsen([x, y, z]: Block, bits: usize) -> Block {
    [x >> bits, y >> bits, z >> bits]
}

/// From blocks to numbers; nothing is ever removed.
#[derive(Default)]
pub(super) struct BlockMap {
    map: TableMap,
    tables: Vec<[u32; 64]>,
    /// Which of its blocks each table has numbers for, a bit each.
    taken: Vec<u64>,
}

/// The table that somebody looked at last, to be found again without hashing.
#[derive(Clone, Copy)]
pub(super) struct Recent {
    table: Block,
    number: u32,
}

impl Default for Recent {
    fn default() -> Self {
        Self {
            table: [u32::MAX; 3],
            number: EMPTY,
        }
    }
}

impl BlockMap {
    /// Makes room for so many blocks, if at least eight share a table.
    pub(super) fn expect(&mut self, blocks: usize) {
        make_room(&mut self.tables, blocks / 8);
        make_room(&mut self.taken, blocks / 8);
    }

    /// As [`get`](Self::get), for somebody who often asks near where he asked last.
    #[inline]
    pub(super) fn get_again(&self, block: Block, recent: &mut Recent) -> Option<u32> {
        let table = coarsen(block, 2);
        if recent.table != table {
            *recent = self.look_up(table)?;
        }
        let number = self.tables[recent.number as usize][within(block)];
        (number != EMPTY).then_some(number)
    }

    fn look_up(&self, table: Block) -> Option<Recent> {
        let number = self.map.get(table)?;
        Some(Recent { table, number })
    }

    #[inline]
    pub(super) fn get(&self, block: Block) -> Option<u32> {
        let table = self.map.get(coarsen(block, 2))?;
        let number = self.tables[table as usize][within(block)];
        (number != EMPTY).then_some(number)
    }

    /// The block's number, or `new` after storing it.
    pub(super) fn get_or_insert(&mut self, block: Block, new: u32) -> u32 {
        let next = self.tables.len() as u32;
        let table = self.map.get_or_insert(coarsen(block, 2), next);
        if table == next {
            self.tables.push([EMPTY; 64]);
            self.taken.push(0);
        }
        let number = &mut self.tables[table as usize][within(block)];
        if *number == EMPTY {
            *number = new;
            self.taken[table as usize] |= 1 << within(block);
        }
        *number
    }

    /// Visits the numbered blocks from one corner to another, both included.
    #[inline]
    pub(super) fn visit(&self, [low, high]: [Block; 2], mut visit: impl FnMut(Block, u32)) {
        visit_between([coarsen(low, 2), coarsen(high, 2)], |table| {
            let Some(number) = self.map.get(table) else {
                return;
            };
            let numbers = &self.tables[number as usize];
            let mut left = self.taken[number as usize] & bits_between(table, low, high);
            while left != 0 {
                let bit = left.trailing_zeros();
                let offset = [bit & 3, bit >> 2 & 3, bit >> 4];
                visit(
                    [0, 1, 2].map(|i| table[i] << 2 | offset[i]),
                    numbers[bit as usize],
                );
                left &= left - 1;
            }
        });
    }
}

/// The bits of a table's blocks that are between two corners, both included.
fn bits_between(table: Block, low: Block, high: Block) -> u64 {
    let row = |axis: usize| {
        let from = low[axis].saturating_sub(table[axis] << 2).min(3);
        let to = (high[axis] - (table[axis] << 2)).min(3);
        (0b1111 << from) & (0b1111 >> (3 - to))
    };
    let (x, y, z) = (row(0), row(1), row(2));
    let mut bits = 0;
    for i in 0..4 {
        let in_row = (y >> i & 1) * x;
        bits |= in_row << (4 * i);
    }
    (0..4).fold(0, |all, i| all | ((z >> i & 1) * (bits << (16 * i))))
}

/// A block's place in its table.
fn within([x, y, z]: Block) -> usize {
    ((x & 3) | (y & 3) << 2 | (z & 3) << 4) as usize
}

#[inline]
fn visit_between([low, high]: [Block; 2], mut visit: impl FnMut(Block)) {
    for z in low[2]..=high[2] {
        for y in low[1]..=high[1] {
            for x in low[0]..=high[0] {
                visit([x, y, z]);
            }
        }
    }
}

/// The corners of the cube of blocks that are at most `reach` away from one along each axis.
pub(super) fn about(block: Block, reach: u32) -> [Block; 2] {
    [
        block.map(|c| c.saturating_sub(reach)),
        block.map(|c| c + reach),
    ]
}

/// Numbers of tables by open addressing with linear probing; nothing is ever removed.
struct TableMap {
    slots: Vec<Slot>,
    shift: u32,
    used: usize,
}

#[derive(Clone, Copy)]
struct Slot {
    table: Block,
    value: u32,
}

/// The value of a slot that holds nothing.
const EMPTY: u32 = u32::MAX;

const VACANT: Slot = Slot {
    table: [0; 3],
    value: EMPTY,
};

impl Default for TableMap {
    fn default() -> Self {
        Self {
            slots: vec![VACANT; 16],
            shift: 60,
            used: 0,
        }
    }
}

impl TableMap {
    fn get(&self, table: Block) -> Option<u32> {
        let slot = &self.slots[self.find(table)];
        (slot.value != EMPTY).then_some(slot.value)
    }

    /// The table's number, or `new` after storing it.
    fn get_or_insert(&mut self, table: Block, new: u32) -> u32 {
        let at = self.find(table);
        if self.slots[at].value != EMPTY {
            return self.slots[at].value;
        }
        self.slots[at] = Slot { table, value: new };
        self.used += 1;
        if 2 * self.used > self.slots.len() {
            self.grow();
        }
        new
    }

    /// The slot that holds a table, or the empty one where it would go.
    fn find(&self, table: Block) -> usize {
        let mask = self.slots.len() - 1;
        let mut at = (mix(table) >> self.shift) as usize;
        while self.slots[at].value != EMPTY && self.slots[at].table != table {
            at = (at + 1) & mask;
        }
        at
    }

    fn grow(&mut self) {
        let larger = vec![VACANT; 2 * self.slots.len()];
        self.shift -= 1;
        for slot in std::mem::replace(&mut self.slots, larger) {
            if slot.value != EMPTY {
                let at = self.find(slot.table);
                self.slots[at] = slot;
            }
        }
    }
}

/// A table's coordinates spread over 64 bits, the upper ones best.
fn mix([x, y, z]: Block) -> u64 {
    u64::from(x).wrapping_mul(0x9e37_79b9_7f4a_7c15)
        ^ u64::from(y).wrapping_mul(0xc2b2_ae3d_27d4_eb4f)
        ^ u64::from(z).wrapping_mul(0x1656_67b1_9e37_79f9)
}
