//! Lower bounds on the distance to the nearest centre, on cubic grids whose cells grow fourfold.
//!
//! A grid is kept in blocks of 4³ cells, and only where somebody has asked. A block has one cache line of 4³ samples,
//! from its one end to the other along each axis: squared distances to the nearest obstacle, rounded down to bytes,
//! which say nothing beyond a window of eight cells. What they say of places in between is for
//! [`corners`](super::corners). A block made late is the same as one that was there from the beginning.
//!
//! Obstacles are the centres themselves on the finest grid, and on each other one the cells of the next finer that hold
//! centres: so a birth changes two grids and seldom more.
//!
//! All lengths here are in units of the element radius. Cells of the finest grid have whole numbers
//! for their middles, so that a point's cell is found by rounding.

use std::sync::atomic::{AtomicU8, AtomicU64, Ordering};

use glam::DVec3;
use wide::{f32x8, i16x8, u8x16};

use super::block::{Block, cell_at, coarsen, within};
use super::corners::Samples;
use super::lanes::{self, Bytes};
use super::slab::Slab;
use super::tree::Tree;

/// Squared distances from the 4³ samples of a block, x fastest: a cache line.
#[derive(Clone, Copy, PartialEq)]
#[repr(align(64))]
pub(super) struct Distances(pub(super) [u8; 64]);

impl Distances {
    /// Those of the eight samples from one on, two along each axis.
    pub(super) fn about(&self, first: u8) -> Samples {
        let bytes = CUBE.map(|step| self.0[usize::from(first) + step]);
        Samples(bytemuck::cast([u64::from_le_bytes(bytes), 0]))
    }
}

/// From the first of eight samples, two along each axis, to each of them.
pub(super) const CUBE: [usize; 8] = [0, 1, 16, 17, 4, 5, 20, 21];

impl Default for Distances {
    fn default() -> Self {
        Self([FAR; 64])
    }
}

/// The same where walkers may read it while a birth lowers it.
#[repr(align(64))]
pub(super) struct SharedDistances(Bytes);

impl Default for SharedDistances {
    fn default() -> Self {
        Self([(); 64].map(|()| AtomicU8::new(FAR)))
    }
}

impl SharedDistances {
    /// Those of the eight samples from one on, two along each axis.
    #[inline(always)]
    pub(super) fn about(&self, first: u8) -> Samples {
        Samples(lanes::cube(&self.0, first.into()))
    }

    #[cfg(test)]
    pub(super) fn all(&self) -> Distances {
        Distances(std::array::from_fn(|sample| {
            self.0[sample].load(Ordering::Relaxed)
        }))
    }

    fn set(&self, distances: &Distances) {
        lanes::set_bytes(&self.0, bytemuck::cast(distances.0));
    }

    /// Lowers them by those across a layer, the same for all layers, and up along the third axis.
    #[inline(always)]
    fn lower(&self, across: u8x16, up: [u8x16; 4]) {
        let now = lanes::bytes(&self.0);
        let lowered = |i: usize| now[i].min(across.saturating_add(up[i]));
        lanes::set_bytes(&self.0, [0, 1, 2, 3].map(lowered));
    }
}

/// The distances of some blocks, and which of their cells hold centres, a bit each.
#[derive(Default)]
pub(super) struct Blocks {
    pub(super) distances: Slab<SharedDistances>,
    pub(super) occupied: Slab<AtomicU64>,
}

impl Blocks {
    /// Takes memory for so many.
    pub(super) fn expect(&mut self, blocks: usize) {
        self.distances.expect(blocks);
        self.occupied.expect(blocks);
    }

    /// Makes room for so many more.
    pub(super) fn make_room(&mut self, blocks: usize) {
        self.distances.make_room(blocks);
        self.occupied.make_room(blocks);
    }

    /// How many more there is room for.
    pub(super) fn room(&self) -> usize {
        self.distances.room().min(self.occupied.room())
    }

    /// Keeps a block without centres, with the next number.
    pub(super) fn keep(&self, distances: &Distances) -> u32 {
        let (number, place) = self.distances.take();
        place.set(distances);
        self.occupied.take();
        number
    }

    /// Marks a cell of a block as holding a centre. False where it was that already.
    pub(super) fn occupy(&self, number: u32, within: usize) -> bool {
        let (cells, cell) = (&self.occupied[number], 1 << within);
        let before = cells.load(Ordering::Relaxed);
        cells.store(before | cell, Ordering::Release);
        before & cell == 0
    }

    /// Lowers the distances of a level above the finest about a cell of the next finer one that holds a centre now.
    #[inline(never)] // Births go through more code than the cache for it holds.
    pub(super) fn lower(&self, tree: &Tree, level: usize, obstacle: Block) {
        let gaps = Gaps::to_cell(obstacle);
        tree.visit(level, seen_from(coarsen(obstacle, 2)), |near, number| {
            gaps.lower(&self.distances[number], near);
        });
    }
}

/// Cells that a grid sees; farther is the same as this far.
pub(super) const WINDOW: u32 = 8;

/// Squared distances are counted in quarters of a cell's size squared: in half cells, squared.
pub(super) const HALF_CELLS_SQ: f64 = 4.0;

/// Samples of a block along an axis.
pub(super) const SAMPLES: u32 = 4;

/// Cells from one to the next.
const APART: f64 = 4.0 / (SAMPLES - 1) as f64;

/// The squared distance of a sample that sees no obstacle.
pub(super) const FAR: u8 = u8::MAX;

/// The cells at most the window away from those between two.
fn window([low, high]: [Block; 2]) -> [Block; 2] {
    [
        low.map(|c| c.saturating_sub(WINDOW)),
        high.map(|c| c + WINDOW),
    ]
}

/// The blocks with cells at most the window away from a cell.
pub(super) fn seen_from(cell: Block) -> [Block; 2] {
    window([cell, cell]).map(|c| coarsen(c, 2))
}

/// The cells that some sample of a block sees.
pub(super) fn seen_by(block: Block) -> [Block; 2] {
    let low = block.map(|b| b << 2);
    window([low, low.map(|c| c + 3)])
}

/// The block that a cell is in, and its place there.
#[inline(always)]
pub(super) fn address(cell: Block) -> (Block, usize) {
    (coarsen(cell, 2), within(cell))
}

/// The distances of a block above the finest level, worked out from which cells of the next finer one's
/// blocks hold centres. Those are given by the numbers of the finer level's blocks, and which of the
/// finer blocks hold some by the numbers of this level's.
pub(super) fn survey(
    tree: &Tree,
    level: usize,
    block: Block,
    [cells, blocks]: [&Slab<AtomicU64>; 2],
) -> Distances {
    let mut holders = Holders::about(block, 1);
    tree.visit_among(level - 1, blocks, seen_by(block), |near, number| {
        holders.add(near, number);
    });
    holders.nearest_first(|distances, near, number| {
        let mut bits = cells[number].load(Ordering::Acquire);
        while bits != 0 {
            lower_by_cell(distances, block, cell_at(near, bits.trailing_zeros()));
            bits &= bits - 1;
        }
    })
}

/// What holds obstacles that a block may see, in cubes of equal size on the same grid.
pub(super) struct Holders {
    block: Block,
    /// A cube's size in cells.
    size: u32,
    all: Vec<(u32, Block, u32)>,
}

/// There seldom are more of them.
const USUAL_HOLDERS: usize = 64;

impl Holders {
    pub(super) fn about(block: Block, size: u32) -> Self {
        Self {
            block,
            size,
            all: Vec::with_capacity(USUAL_HOLDERS),
        }
    }

    pub(super) fn add(&mut self, cube: Block, number: u32) {
        let least = self.least_gap_sq(cube);
        if least < FAR.into() {
            self.all.push((least, cube, number));
        }
    }

    /// No sample of the block gets a smaller number by an obstacle in a cube.
    fn least_gap_sq(&self, cube: Block) -> u32 {
        let gap_sq = |axis: usize| {
            let (low, cube) = (self.block[axis] << 2, cube[axis] * self.size);
            let beyond = cube.saturating_sub(low + 4);
            let before = low.saturating_sub(cube + self.size);
            let half_cells = 2 * beyond.max(before);
            half_cells * half_cells
        };
        // Rounding takes off less than one an axis.
        (gap_sq(0) + gap_sq(1) + gap_sq(2)).saturating_sub(3)
    }

    /// The block's distances, lowered by what is in each cube until all others are too far.
    pub(super) fn nearest_first(
        mut self,
        mut lower: impl FnMut(&mut Distances, Block, u32),
    ) -> Distances {
        let mut distances = Distances::default();
        self.all.sort_unstable();
        for (least, cube, number) in self.all {
            if least >= farthest(&distances).into() {
                break;
            }
            lower(&mut distances, cube, number);
        }
        distances
    }
}

fn farthest(distances: &Distances) -> u8 {
    let layers = distances.0.as_chunks().0.iter();
    let most = layers.fold(u8x16::splat(0), |most, layer| most.max(u8x16::new(*layer)));
    most.reduce_max()
}

/// Squared distances along an axis from the samples of a block.
type Row = [u8; 4];

/// Lowers the squared distances of a block by those along each axis.
#[inline(always)]
fn lower_by(distances: &mut Distances, [x, y, z]: [Row; 3]) {
    let (across, up) = (layer([x; 4]).saturating_add(each_four_times(y)), layers(z));
    let layers = distances.0.as_chunks_mut().0.iter_mut();
    for (layer, up) in layers.zip(up) {
        let gaps = across.saturating_add(up);
        *layer = u8x16::new(*layer).min(gaps).to_array();
    }
}

/// Four rows of samples in one register.
#[inline(always)]
fn layer(rows: [Row; 4]) -> u8x16 {
    let mut samples = [0; 16];
    samples.as_chunks_mut().0.copy_from_slice(&rows);
    u8x16::new(samples)
}

/// Each of four bytes four times.
#[inline(always)]
fn each_four_times(row: Row) -> u8x16 {
    let rows = layer([row; 4]);
    let twice = u8x16::unpack_low(rows, rows);
    u8x16::unpack_low(twice, twice)
}

/// Each of four bytes in a register of its own.
#[inline(always)]
fn layers(row: Row) -> [u8x16; 4] {
    let four_times = each_four_times(row);
    let low = u8x16::unpack_low(four_times, four_times);
    let high = u8x16::unpack_high(four_times, four_times);
    [
        u8x16::unpack_low(low, low),
        u8x16::unpack_high(low, low),
        u8x16::unpack_low(high, high),
        u8x16::unpack_high(high, high),
    ]
}

/// Lowers the squared distances of a block by those to a cell of the next finer grid.
#[inline(always)]
pub(super) fn lower_by_cell(distances: &mut Distances, block: Block, obstacle: Block) {
    let rows = [0, 1, 2].map(|axis| row_to_cell(block[axis], obstacle[axis]));
    lower_by(distances, rows);
}

/// Squared distances along an axis from a block's samples to a cell of the next finer grid.
#[inline(always)]
fn row_to_cell(block: u32, obstacle: u32) -> Row {
    let aside = block.wrapping_sub(obstacle >> 4).wrapping_add(ASIDE);
    let (rows, place) = (&TO_CELLS, obstacle as usize & 15);
    rows[place].get(aside as usize).copied().unwrap_or([FAR; 4])
}

/// Blocks to either side that an obstacle is seen from.
const ASIDE: u32 = WINDOW / 4;

/// And all of them along an axis.
const MOST_BLOCKS: usize = 2 * ASIDE as usize + 1;

/// What [`row_to_cell`] says, by the obstacle's place in its block and the other block's beside that.
static TO_CELLS: [[Row; MOST_BLOCKS]; 16] = {
    let mut rows = [[[0; 4]; MOST_BLOCKS]; 16];
    let mut i = 0;
    while i < 64 * MOST_BLOCKS {
        let (place, block, sample) = (i / (4 * MOST_BLOCKS), i / 4 % MOST_BLOCKS, i % 4);
        // In twelfths of a cell, from the corner of the first of these blocks.
        let at = 16 * (3 * block + sample);
        let low = 48 * ASIDE as usize + 3 * place;
        let gap = if at < low {
            low - at
        } else {
            at.saturating_sub(low + 3)
        };
        let half_cells_sq = gap * gap / 36;
        rows[place][block][sample] = if half_cells_sq < FAR as usize {
            half_cells_sq as u8
        } else {
            FAR
        };
        i += 1;
    }
    rows
};

/// Taken off squared distances in half cells, for what single precision may have added.
const ROUNDED: f32 = 1e-4;

/// Squared distances along an axis from the samples of the finest grid's blocks, from one on, to a place.
/// Each row is worked out from its own block, so that it is the same wherever one begins.
#[inline(always)]
fn rows_to_centre(low: u32, p: f64) -> [Row; MOST_BLOCKS] {
    const S: f32 = APART as f32;
    let first = |block: u32| (p + 0.5 - f64::from(block << 2)) as f32;
    let two = |i: u32| {
        let [a, b] = [first(low + i), first(low + i + 1)];
        let gaps = f32x8::new([a, a, a, a, b, b, b, b])
            - f32x8::new([0.0, S, 2.0 * S, 3.0 * S, 0.0, S, 2.0 * S, 3.0 * S]);
        let half_cells_sq =
            gaps * gaps * f32x8::splat(HALF_CELLS_SQ as f32) - f32x8::splat(ROUNDED);
        let limited = half_cells_sq.fast_min(f32x8::splat(FAR.into()));
        i16x8::from_i32x8_saturate(limited.fast_trunc_int())
    };
    let [a, b, c] = [0, 2, 4].map(two);
    let [near, far] = [(a, b), (c, c)].map(|(a, b)| u8x16::narrow_i16x8(a, b).to_array());
    let row = |i: usize| std::array::from_fn(|k| if i < 4 { near[4 * i + k] } else { far[k] });
    [row(0), row(1), row(2), row(3), row(4)]
}

/// Lowers the squared distances of a block of the finest grid by those to a centre.
pub(super) fn lower_by_centre(distances: &mut Distances, block: Block, p: DVec3) {
    let rows = [0, 1, 2].map(|axis| rows_to_centre(block[axis], p[axis])[0]);
    lower_by(distances, rows);
}

/// Squared distances along each axis to one obstacle, from all blocks that see it, and ready to lower
/// those.
pub(super) struct Gaps {
    /// The lowest of the blocks.
    low: Block,
    /// No more than the least of each block's.
    least: [[u8; MOST_BLOCKS]; 3],
    x: [u8x16; MOST_BLOCKS],
    y: [u8x16; MOST_BLOCKS],
    /// A layer of samples each.
    z: [[u8x16; 4]; MOST_BLOCKS],
}

impl Gaps {
    /// To a centre, on the finest grid.
    pub(super) fn to_centre(p: DVec3, cell: Block) -> Self {
        let [low, _] = seen_from(cell);
        let rows = [0, 1, 2].map(|axis| rows_to_centre(low[axis], p[axis]));
        Self::new(low, coarsen(cell, 2), rows)
    }

    /// To a cell of the next finer grid.
    fn to_cell(obstacle: Block) -> Self {
        let [low, _] = seen_from(coarsen(obstacle, 2));
        let row = |axis: usize, i: usize| row_to_cell(low[axis] + i as u32, obstacle[axis]);
        let rows = |axis: usize| std::array::from_fn(|i| row(axis, i));
        Self::new(low, coarsen(obstacle, 4), [0, 1, 2].map(rows))
    }

    /// From the blocks from one on to an obstacle in another.
    #[inline(never)]
    fn new(low: Block, own: Block, [x, y, z]: [[Row; MOST_BLOCKS]; 3]) -> Self {
        // One end of a row is nearest to what lies beyond.
        let mut least = [x, y, z].map(|rows| rows.map(|[first, _, _, last]| first.min(last)));
        for (axis, least) in least.iter_mut().enumerate() {
            least[(own[axis] - low[axis]) as usize] = 0;
        }
        Self {
            low,
            least,
            x: x.map(|row| layer([row; 4])),
            y: y.map(each_four_times),
            z: z.map(layers),
        }
    }

    /// Lowers the squared distances of one of the blocks, where it may have samples that see the obstacle.
    /// No more than the least there is.
    #[inline(always)]
    pub(super) fn lower(&self, distances: &SharedDistances, block: Block) -> u8 {
        let [x, y, z] = [0, 1, 2].map(|axis| (block[axis] - self.low[axis]) as usize);
        let least = self.least[0][x].saturating_add(self.least[1][y]);
        let least = least.saturating_add(self.least[2][z]);
        if least < FAR {
            distances.lower(self.x[x].saturating_add(self.y[y]), self.z[z]);
        }
        least
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rng::{Purpose, Stream};

    /// Blocks that an obstacle in a cell is looked for from, some of them.
    fn some_seen_from(cell: Block, stream: &mut Stream) -> [Block; 8] {
        let [low, high] = seen_from(cell);
        let between = |axis: usize, chance: f64| {
            low[axis] + (chance * f64::from(high[axis] - low[axis] + 1)) as u32
        };
        std::array::from_fn(|_| [0, 1, 2].map(|axis| between(axis, stream.uniform())))
    }

    #[test]
    fn a_block_alone_is_lowered_as_one_of_many() {
        let mut stream = Stream::new(7, Purpose::Walker, 0);
        for _ in 0..5_000 {
            let p = 1000.0 * DVec3::from([0; 3].map(|_| stream.uniform() * stream.uniform()));
            let cell = p.to_array().map(|x| x.round() as u32);
            let gaps = Gaps::to_centre(p, cell);
            for block in some_seen_from(cell, &mut stream) {
                let (mut lowered, shared) = (Distances::default(), SharedDistances::default());
                lower_by_centre(&mut lowered, block, p);
                let least = gaps.lower(&shared, block);
                assert!(lowered == shared.all(), "{p:?}, block {block:?}");
                assert!(lowered.0.iter().all(|d| *d >= least), "{p:?}");
            }
            let gaps = Gaps::to_cell(cell);
            for block in some_seen_from(coarsen(cell, 2), &mut stream) {
                let (mut lowered, shared) = (Distances::default(), SharedDistances::default());
                lower_by_cell(&mut lowered, block, cell);
                gaps.lower(&shared, block);
                assert!(lowered == shared.all(), "cell {cell:?}, block {block:?}");
            }
        }
    }

    #[test]
    fn centres_as_far_as_can_be_lower_nothing() {
        for far in [20.0, 1e3, 3e4, 1e6, 1e7] {
            for p in [DVec3::splat(far), DVec3::new(far, 2.0, 2.0)] {
                let mut distances = Distances::default();
                lower_by_centre(&mut distances, [0; 3], p);
                assert!(distances == Distances::default(), "{p:?}");
                let block = [(far / 4.0) as u32; 3];
                lower_by_centre(&mut distances, block, DVec3::splat(2.0));
                assert!(distances == Distances::default(), "{p:?} backwards");
            }
        }
    }

    #[test]
    fn samples_get_the_squared_distance_to_an_occupied_cell() {
        let mut stream = Stream::new(8, Purpose::Walker, 0);
        for _ in 0..2000 {
            let obstacle = [0; 3].map(|_| (400.0 * stream.uniform()) as u32);
            let block =
                obstacle.map(|c| (c / 16 + (5.0 * stream.uniform()) as u32).saturating_sub(2));
            let mut distances = Distances::default();
            lower_by_cell(&mut distances, block, obstacle);
            for place in 0..64 {
                let half_cells = |axis: usize| {
                    let thirds = 24 * block[axis] + 8 * (place >> (2 * axis) & 3);
                    let sample = f64::from(thirds) / 3.0;
                    let low = 0.5 * f64::from(obstacle[axis]);
                    let gap = (low - sample).max(sample - low - 0.5).max(0.0);
                    (gap * gap + 1e-9).floor()
                };
                let expected = (half_cells(0) + half_cells(1) + half_cells(2)).min(255.0);
                assert_eq!(distances.0[place as usize], expected as u8);
            }
        }
    }
}
