//! Lower bounds on the distance to the nearest centre, on cubic grids of doubling cell size.
//!
//! A grid holds for each of its cells the squared distance from the cell's middle to the nearest
//! obstacle, rounded down to a byte, and says nothing beyond a window of eight cells. Its obstacles are the
//! centres themselves on the finest grid, and on the others occupied boxes, each as large as eight
//! cells: few births occupy a new one of those, so that a birth changes the finest grid and seldom
//! another.
//!
//! Cells are kept in blocks of 4³, one cache line each, and only where somebody has asked. A block
//! made late is the same as one that was there from the beginning.
//!
//! All lengths here are in units of the element radius. Cells of the finest grid have whole numbers
//! for their middles, so that a point's cell is found by rounding.

use glam::DVec3;
use wide::u8x16;

use super::block_map::{Block, BlockMap, coarsen};
use super::make_room;

/// Squared distances from the middles of a block of 4³ cells, x fastest.
pub(super) type Distances = [u8; 64];

/// Cells that a grid sees; farther is the same as this far.
pub(super) const WINDOW: u32 = 8;

/// Squared distances are counted in quarters of a cell's size squared: in half cells, squared.
const QUARTERS: f64 = 4.0;

/// The squared distance of a cell that sees no obstacle.
pub(super) const FAR: u8 = u8::MAX;

/// The blocks with cells at most the window away from a cell, or from any between two.
pub(super) fn seen_from(low: Block, high: Block) -> [Block; 2] {
    [
        low.map(|c| c.saturating_sub(WINDOW) >> 2),
        high.map(|c| (c + WINDOW) >> 2),
    ]
}

/// Which block of which cell, and which byte in it.
#[inline(always)]
pub(super) fn address(cell: Block) -> (Block, usize) {
    let within = (cell[0] & 3) | (cell[1] & 3) << 2 | (cell[2] & 3) << 4;
    (coarsen(cell, 2), within as usize)
}

/// One grid but the finest: 2^level radii a cell.
#[derive(Default)]
pub(super) struct Grid {
    pub(super) asked: BlockMap,
    pub(super) distances: Vec<Distances>,
    /// Boxes of twice the cells' size, by blocks of 4³.
    occupied: BlockMap,
    /// Which boxes of a block are occupied.
    boxes: Vec<u64>,
    /// The last centre that occupied one; nothing here has changed since.
    pub(super) changed_by: u32,
}

impl Grid {
    /// Makes room for so many blocks.
    pub(super) fn expect(&mut self, blocks: usize) {
        make_room(&mut self.distances, blocks);
        self.asked.expect(blocks);
        make_room(&mut self.boxes, blocks / 4);
        self.occupied.expect(blocks / 4);
    }

    /// Keeps a block's distances, unless it has them.
    pub(super) fn keep(&mut self, block: Block, distances: &Distances) {
        let new = self.distances.len() as u32;
        if self.asked.get_or_insert(block, new) == new {
            self.distances.push(*distances);
        }
    }

    /// Marks a box as occupied; false when it was.
    pub(super) fn occupy(&mut self, obstacle: Block) -> bool {
        let (block, within) = address(obstacle);
        let new = self.boxes.len() as u32;
        let number = self.occupied.get_or_insert(block, new);
        if number == new {
            self.boxes.push(0);
        }
        let (bits, bit) = (&mut self.boxes[number as usize], 1 << within);
        if *bits & bit != 0 {
            return false;
        }
        *bits |= bit;
        let low = obstacle.map(|v| 2 * v);
        let seen = seen_from(low, low.map(|c| c + 1));
        let gaps = Gaps::to_box(seen, obstacle);
        self.asked.visit(seen, |near, n| {
            gaps.lower(&mut self.distances[n as usize], near);
        });
        true
    }

    /// The distances of a block, worked out from the occupied boxes.
    pub(super) fn survey(&self, block: Block) -> Distances {
        let mut distances = [FAR; 64];
        let low = block.map(|b| b << 2);
        let seen = seen_from(low, low.map(|c| c + 3)).map(|b| b.map(|c| c >> 1));
        self.occupied.visit(seen, |near, number| {
            let mut bits = self.boxes[number as usize];
            while bits != 0 {
                let within = bits.trailing_zeros();
                let offset = [within & 3, within >> 2 & 3, within >> 4];
                let obstacle = [0, 1, 2].map(|i| near[i] << 2 | offset[i]);
                Gaps::to_box([block; 2], obstacle).lower(&mut distances, block);
                bits &= bits - 1;
            }
        });
        distances
    }
}

/// Squared distance along an axis from a cell's middle to an obstacle's box.
fn box_gap_sq(cell: u32, obstacle: u32) -> u8 {
    // In half cells everything is whole: a middle is at 2c + 1, the box from 4v to 4v + 4.
    let (middle, low) = (2 * cell + 1, 4 * obstacle);
    let below = low.saturating_sub(middle);
    let gap = below.max(middle.saturating_sub(low + 4));
    gap.saturating_mul(gap).min(FAR.into()) as u8
}

/// Squared distances along each axis from the cells of some blocks to an obstacle.
///
/// Along the first two axes they are laid out as the cells of one height in a block are, sixteen to a
/// register.
pub(super) struct Gaps {
    low: Block,
    across: [[u8x16; MOST_BLOCKS]; 2],
    up: [[u8; 4]; MOST_BLOCKS],
    /// The least of each four.
    least: [[u8; MOST_BLOCKS]; 3],
}

/// Blocks along an axis that an obstacle is seen from.
const MOST_BLOCKS: usize = (2 * WINDOW as usize + 2).div_ceil(4) + 1;

impl Gaps {
    /// For the blocks from one corner to another, by a function of axis and cell.
    #[inline]
    fn new([low, high]: [Block; 2], gap_sq: impl Fn(usize, u32) -> u8) -> Self {
        let mut by_axis = [[[FAR; 4]; MOST_BLOCKS]; 3];
        for (axis, blocks) in by_axis.iter_mut().enumerate() {
            for (gaps, block) in blocks.iter_mut().zip(low[axis]..=high[axis]) {
                for (i, gap) in (0..).zip(gaps) {
                    *gap = gap_sq(axis, block << 2 | i);
                }
            }
        }
        let least = by_axis.map(|blocks| blocks.map(|[a, b, c, d]| a.min(b).min(c.min(d))));
        let [x, y, up] = by_axis;
        Self {
            low,
            across: [
                x.map(|x| layer([x; 4])),
                y.map(|y| layer(y.map(|y| [y; 4]))),
            ],
            up,
            least,
        }
    }

    /// For an occupied box on a coarser grid.
    pub(super) fn to_box(blocks: [Block; 2], obstacle: Block) -> Self {
        Self::new(blocks, |axis, cell| box_gap_sq(cell, obstacle[axis]))
    }

    /// For a centre on the finest grid.
    pub(super) fn to_centre(blocks: [Block; 2], p: DVec3) -> Self {
        let p = p.to_array();
        Self::new(blocks, |axis, cell| {
            let gap = p[axis] - f64::from(cell);
            (gap * gap * QUARTERS) as u8
        })
    }

    /// Whether any cell of one of the blocks sees the obstacle.
    #[inline]
    pub(super) fn reach(&self, block: Block) -> bool {
        let of = |axis: usize| self.least[axis][(block[axis] - self.low[axis]) as usize];
        of(0).saturating_add(of(1)).saturating_add(of(2)) < FAR
    }

    /// Lowers the squared distances of one of the blocks.
    #[inline]
    pub(super) fn lower(&self, distances: &mut Distances, block: Block) {
        let [x, y, z] = [0, 1, 2].map(|axis| (block[axis] - self.low[axis]) as usize);
        let across = self.across[0][x].saturating_add(self.across[1][y]);
        let layers = distances.as_chunks_mut().0.iter_mut();
        for (layer, up) in layers.zip(self.up[z]) {
            let gaps = across.saturating_add(u8x16::splat(up));
            *layer = u8x16::new(*layer).min(gaps).to_array();
        }
    }
}

/// Four rows of cells in one register.
#[inline(always)]
fn layer(rows: [[u8; 4]; 4]) -> u8x16 {
    let mut cells = [0; 16];
    cells.as_chunks_mut().0.copy_from_slice(&rows);
    u8x16::new(cells)
}

/// Whole numbers of half cells squared as distances in cells.
pub(super) struct Roots([f64; 256]);

impl Default for Roots {
    fn default() -> Self {
        Self(std::array::from_fn(|quarters| {
            (quarters as f64 / QUARTERS).sqrt()
        }))
    }
}

impl Roots {
    /// The distance between middle and obstacle that a cell has, in cells: no more than that.
    #[inline(always)]
    pub(super) fn least(&self, distance_sq: u8) -> f64 {
        self.0[usize::from(distance_sq)]
    }

    /// No centre that made the cell of the finest grid what it is, is farther.
    #[inline(always)]
    pub(super) fn most(&self, distance_sq: u8) -> f64 {
        // Rounded down once an axis.
        self.0[usize::from(distance_sq.saturating_add(3))]
    }
}

/// The middle of a cell, from a grid of this cell size: of the finest cells in it.
#[inline(always)]
pub(super) fn middle(cell: Block, size: f64) -> DVec3 {
    let low = DVec3::new(cell[0].into(), cell[1].into(), cell[2].into());
    low * size + 0.5 * (size - 1.0)
}
