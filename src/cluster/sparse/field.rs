//! Lower bounds on the distance to the nearest centre, on cubic grids of doubling cell size.
//!
//! A grid holds for each of its cells the squared distance from the cell's middle to the nearest
//! obstacle, rounded down to 16 bits, and says nothing beyond a window of eight cells. Its obstacles are the
//! centres themselves on the finest grid, and on the others occupied boxes, each as large as eight
//! cells: few births occupy a new one of those, so that a birth changes the finest grid and seldom
//! another.
//!
//! Cells are kept in blocks of 4³, and only where somebody has asked. A block made
//! late is the same as one that was there from the beginning.
//!
//! All lengths here are in units of the element radius.

use glam::DVec3;

use super::block_map::{Block, BlockMap, coarsen};

/// Squared distances from the middles of a block of 4³ cells, x fastest.
pub(super) type Distances = [i16; 64];

/// Cells that a grid sees; farther is the same as this far.
pub(super) const WINDOW: u32 = 8;

/// The unit of squared distances is a cell's size squared over this. It is a multiple of 4 and the
/// largest for which the window's square is an i16, which vector code has a minimum for.
const SCALE: i16 = ((i16::MAX as u32 / (WINDOW * WINDOW)) & !3) as i16;

/// The squared distance of a cell that sees no obstacle.
pub(super) const FAR: i16 = SCALE * (WINDOW * WINDOW) as i16;

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
}

impl Grid {
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
fn box_gap_sq(cell: u32, obstacle: u32) -> i16 {
    // In half cells everything is whole: a middle is at 2c + 1, the box from 4v to 4v + 4.
    let (middle, low) = (2 * cell + 1, 4 * obstacle);
    let below = low.saturating_sub(middle);
    let gap = below.max(middle.saturating_sub(low + 4)).min(2 * WINDOW);
    (gap * gap) as i16 * (SCALE / 4)
}

/// Squared distances along each axis from the cells of some blocks to an obstacle.
pub(super) struct Gaps {
    low: Block,
    by_axis: [[[i16; 4]; MOST_BLOCKS]; 3],
}

/// Blocks along an axis that an obstacle is seen from.
const MOST_BLOCKS: usize = (2 * WINDOW as usize + 2).div_ceil(4) + 1;

impl Gaps {
    /// For the blocks from one corner to another, by a function of axis and cell.
    #[inline]
    fn new([low, high]: [Block; 2], gap_sq: impl Fn(usize, u32) -> i16) -> Self {
        let mut by_axis = [[[FAR; 4]; MOST_BLOCKS]; 3];
        for (axis, blocks) in by_axis.iter_mut().enumerate() {
            for (gaps, block) in blocks.iter_mut().zip(low[axis]..=high[axis]) {
                for (i, gap) in (0..).zip(gaps) {
                    *gap = gap_sq(axis, block << 2 | i);
                }
            }
        }
        Self { low, by_axis }
    }

    /// For an occupied box on a coarser grid.
    pub(super) fn to_box(blocks: [Block; 2], obstacle: Block) -> Self {
        Self::new(blocks, |axis, cell| box_gap_sq(cell, obstacle[axis]))
    }

    /// For a centre on the finest grid.
    pub(super) fn to_centre(blocks: [Block; 2], p: DVec3) -> Self {
        let p = p.to_array();
        Self::new(blocks, |axis, cell| {
            let gap = p[axis] - f64::from(cell) - 0.5;
            (gap * gap * f64::from(SCALE)).min(f64::from(FAR)) as i16
        })
    }

    /// Lowers the squared distances of one of the blocks.
    #[inline]
    pub(super) fn lower(&self, distances: &mut Distances, block: Block) {
        let of = |axis: usize| self.by_axis[axis][(block[axis] - self.low[axis]) as usize];
        let (x, y, z) = (of(0), of(1), of(2));
        // Two rows at a time: eight numbers, one register.
        let x = [x[0], x[1], x[2], x[3], x[0], x[1], x[2], x[3]];
        for (j, rows) in distances.as_chunks_mut::<8>().0.iter_mut().enumerate() {
            let z = z[j >> 1];
            let (first, second) = (
                y[2 * (j & 1)].saturating_add(z),
                y[2 * (j & 1) + 1].saturating_add(z),
            );
            let across = [first, first, first, first, second, second, second, second];
            for (i, distance) in rows.iter_mut().enumerate() {
                *distance = (*distance).min(x[i].saturating_add(across[i]));
            }
        }
    }
}

/// The bound that a cell gives at a point, from a grid of this cell size. May be negative.
#[inline]
pub(super) fn bound(distance_sq: i16, size: f64, cell: Block, p: DVec3) -> f64 {
    let corner = DVec3::new(cell[0].into(), cell[1].into(), cell[2].into());
    let middle = (corner + 0.5) * size;
    (f64::from(distance_sq) * (1.0 / f64::from(SCALE))).sqrt() * size - p.distance(middle)
}
