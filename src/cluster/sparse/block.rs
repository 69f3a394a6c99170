//! Coordinates on cubic grids: cells, and blocks of 4³ of them.

/// Coordinates of a cell or a block on its grid.
pub(super) type Block = [u32; 3];

/// The coordinates of what holds a block or a cell on a grid 2^bits as coarse.
#[inline(always)]
pub(super) fn coarsen([x, y, z]: Block, bits: usize) -> Block {
    [x >> bits, y >> bits, z >> bits]
}

/// A bit for each cell of a block that is between two corners, both included; some are.
#[inline(always)]
pub(super) fn bits_between(block: Block, [low, high]: [Block; 2]) -> u64 {
    let row = |axis: usize| {
        let from = low[axis].saturating_sub(block[axis] << 2);
        let after = 3 - (high[axis] - (block[axis] << 2)).min(3);
        let (all, stride) = (ROWS[axis], 2 * axis);
        (all << (from << stride)) & (all >> (after << stride))
    };
    // Each axis has its own digits, so that there is nothing to carry.
    row(0) * row(1) * row(2)
}

/// The bits of the four cells along each axis from a block's first.
const ROWS: [u64; 3] = [0xf, 0x1111, 0x1_0001_0001_0001];

/// A cell's place in its block.
#[inline(always)]
pub(super) fn within([x, y, z]: Block) -> usize {
    ((x & 3) | (y & 3) << 2 | (z & 3) << 4) as usize
}

/// A block's cell by its place.
#[inline(always)]
pub(super) fn cell_at(block: Block, place: u32) -> Block {
    let offset = [place & 3, place >> 2 & 3, place >> 4];
    [0, 1, 2].map(|axis| block[axis] << 2 | offset[axis])
}

/// Visits the cells from one corner to another, both included.
#[inline]
pub(super) fn between([low, high]: [Block; 2], mut visit: impl FnMut(Block)) {
    for z in low[2]..=high[2] {
        for y in low[1]..=high[1] {
            for x in low[0]..=high[0] {
                visit([x, y, z]);
            }
        }
    }
}

/// The corners of the cube of cells that are at most `reach` away from one along each axis.
pub(super) fn about(cell: Block, reach: u32) -> [Block; 2] {
    [
        cell.map(|c| c.saturating_sub(reach)),
        cell.map(|c| c + reach),
    ]
}
