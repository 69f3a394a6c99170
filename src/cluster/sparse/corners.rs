//! Lower bounds on the distance from a place, between samples of squared distances.
//!
//! For any obstacles d²(p) − |p|² is the least of functions that are linear in p, one for each of their points, and
//! therefore concave. So with the shares λ of some samples c whose mean is p
//!
//! ```text
//! d²(p) ≥ Σ λ d²(c) − Σ λ |c − p|²
//! ```
//!
//! Here these are the eight corners of a cube about p, with shares that are linear along each axis. Where d is several
//! times as large as the distance h between samples, some 3 h²/8d of it are lost at most and h²/4d on average, whereas
//! by the nearest sample alone 0.48 h would be.

use bytemuck::cast;
use glam::DVec3;
use wide::{i16x8, i32x4, i32x8, u8x16, u16x8};

use super::block::Block;
use super::field::{HALF_CELLS_SQ, SAMPLES};

/// Lanes are split by the order of their bytes.
const _: () = assert!(cfg!(target_endian = "little"));

/// A place in whole parts of a radius from where the grids begin, half a cell before the middle of the first.
#[derive(Clone, Copy)]
pub(super) struct Spot([u64; 3]);

/// Bits of a place in a cell.
const BITS: u32 = 7;

/// And in a block.
const BLOCK_BITS: u32 = BITS + 2;

/// Parts of a radius.
const PARTS: f64 = (1 << BITS) as f64;

/// What is added to a number of parts makes it whole, and leaves it at the end of the sum's bits.
const SHIFT: f64 = (3u64 << 51) as f64 + 0.5 * PARTS;

impl Spot {
    /// A place relative to the middle of the first cell, in radii.
    #[inline(always)]
    pub(super) fn new(place: DVec3) -> Self {
        Self::shifted(place * PARTS, DVec3::splat(SHIFT))
    }

    #[inline(always)]
    fn shifted(parts: DVec3, shift: DVec3) -> Self {
        Self((parts + shift).to_array().map(f64::to_bits))
    }

    /// The cell of the finest grid about it. A place on the border but for rounding may be in the one beside.
    #[inline(always)]
    pub(super) fn cell(self) -> Block {
        self.0.map(|along| (along >> BITS) as u32)
    }

    /// Where it is in the block of a level about it.
    #[inline(always)]
    pub(super) fn inside(self, level: usize) -> Inside {
        let place = |along: u64| (along >> (2 * level)) as u32 & ((1 << BLOCK_BITS) - 1);
        Inside(self.0.map(place))
    }
}

/// Where grids lie, for places that are not relative to them: a whole number of parts from the origin, so that
/// one product and one sum are enough.
#[derive(Clone, Copy)]
pub(super) struct Parts {
    /// Parts in a unit of length.
    in_unit: f64,
    /// What takes a place in parts to the grids' origin, and makes it whole, as [`SHIFT`] does.
    shift: DVec3,
}

impl Parts {
    /// For parts of a radius, and where the grids then begin: at the last place before `low` that will do.
    pub(super) fn before(low: DVec3, radius: f64) -> (Self, DVec3) {
        let in_unit = PARTS / radius;
        let first = (low * in_unit).floor();
        let shift = SHIFT - first;
        (Self { in_unit, shift }, first / in_unit)
    }

    #[inline(always)]
    pub(super) fn spot(&self, place: DVec3) -> Spot {
        Spot::shifted(place * self.in_unit, self.shift)
    }
}

/// A place in a block, in parts of a cell from the block's low corner.
#[derive(Clone, Copy)]
pub(super) struct Inside([u32; 3]);

impl Inside {
    #[inline(always)]
    fn lanes(self) -> i32x4 {
        let [x, y, z] = self.0.map(|along| along as i32);
        i32x4::new([x, y, z, 0])
    }

    /// In steps of four parts each, rounded, of which so many lie before the block: x and y, and z twice, eight times
    /// each.
    #[inline(always)]
    pub(super) fn steps(self, before: i32) -> [u8x16; 2] {
        let steps: i32x4 = (self.lanes() + i32x4::splat(2)) >> 2;
        let twice = cast::<[i32x4; 2], i32x8>([steps + i32x4::splat(before); 2]);
        let words = i16x8::from_i32x8_saturate(twice);
        let bytes = u8x16::narrow_i16x8(words, words);
        let pairs = u8x16::unpack_low(bytes, bytes);
        let [x, y, z, _] = cast::<_, [u32; 4]>(u8x16::unpack_low(pairs, pairs));
        [cast([x, x, y, y]), cast([z; 4])]
    }
}

/// Squared distances of the eight samples about a place, in the order of [`CUBE`](super::field::CUBE), and eight
/// times 0.
#[derive(Clone, Copy)]
pub(super) struct Samples(pub(super) u8x16);

/// The same as a number.
pub(super) type Said = u64;

impl Samples {
    #[inline(always)]
    pub(super) fn said(self) -> Said {
        cast::<_, [Said; 2]>(self.0)[0]
    }
}

/// What is said of a place that sees no obstacle.
pub(super) const NOTHING_SEEN: Said = u64::MAX;

/// The samples about a place, and their shares.
#[derive(Clone, Copy)]
pub(super) struct Corners {
    /// The first sample.
    pub(super) first: u8,
    /// Of each sample, of 2^[`ALL_BITS`] or a little less: rounded down, they make bounds no larger.
    shares: u16x8,
    /// Σ λ |c − p|² along each axis, in squared half cells by shares; less, in all, what [`Roots`] begin before 0.
    bow: i32x4,
}

/// Shares of a whole along an axis: a place on the way from a sample to the next.
const WHOLE: i32 = 1 << BLOCK_BITS;

/// Shares along an axis before they are multiplied, and of a whole in space.
const LONG_BITS: u32 = 15;
const ALL_BITS: u32 = 13;

/// Lengths by squared distances from −[`BEFORE`] on.
pub(super) struct Roots([f64; 1 << (9 + ROOT_BITS)]);

/// In steps between roots, more than what a bow takes from a sample of 0: 5⅓ squared half cells.
const BEFORE: i32 = 11;

/// Bits of a squared distance that tell roots apart, besides those of samples.
const ROOT_BITS: u32 = 1;
const ROOT_SHIFT: u32 = ALL_BITS - ROOT_BITS;

/// More than the cells between a place and where it is taken to be: less than a part along each axis, half of one on
/// the finest grid. That is 0.0136 in all; what [`bow`] is rounded down by takes 0.0002.
const ASIDE: f64 = 0.0155;

impl Roots {
    /// What is said of distances in cells, less [`ASIDE`].
    pub(super) fn new(length: impl Fn(f64) -> f64) -> Self {
        const TO_ONE: f64 = HALF_CELLS_SQ * (1 << ROOT_BITS) as f64;
        let root = |i: usize| (i.saturating_sub(BEFORE as usize) as f64 / TO_ONE).sqrt() - ASIDE;
        Self(std::array::from_fn(|i| length(root(i))))
    }
}

impl Corners {
    #[inline(always)]
    pub(super) fn about(inside: Inside) -> Self {
        // Three times from a sample to the next are a block.
        const { assert!(SAMPLES == 4) };
        let [x, y, z] = inside.0.map(|place| (3 * place) >> BLOCK_BITS);
        let place = inside.lanes();
        let after = (place + place + place) & i32x4::splat(WHOLE - 1);
        let before = i32x4::splat(WHOLE) - after;
        let both: i32x4 =
            (before << (LONG_BITS - BLOCK_BITS)) | (after << (16 + LONG_BITS - BLOCK_BITS));
        Self {
            first: (x | y << 2 | z << 4) as u8,
            shares: in_space(cast(both)),
            bow: bow(after, before),
        }
    }

    /// What is said of no more than the distance to the nearest obstacle.
    #[inline(always)]
    pub(super) fn bound(&self, samples: Samples, Roots(roots): &Roots) -> f64 {
        let samples = i16x8::from_u8x16_low(samples.0);
        let [a, b, c, d] = (samples.dot(cast(self.shares)) - self.bow).to_array();
        let sq = (a + b + (c + d)) >> ROOT_SHIFT;
        roots[sq as usize % roots.len()]
    }
}

/// Each sample's share, by those along each axis of the one before and the one after.
#[inline(always)]
fn in_space([x, after_x, y, after_y, z, after_z, ..]: [u16; 8]) -> u16x8 {
    let along_x = u16x8::new([x, after_x, x, after_x, x, after_x, x, after_x]);
    let along_y = u16x8::new([y, y, y, y, after_y, after_y, after_y, after_y]);
    let along_z = u16x8::new([z, z, after_z, after_z, z, z, after_z, after_z]);
    // Of each product the upper sixteen bits are kept.
    const { assert!(3 * LONG_BITS - 2 * 16 == ALL_BITS) };
    along_x.mul_keep_high(along_y).mul_keep_high(along_z)
}

/// The product of the shares along each axis, times the square of what lies between two samples, 64/9, times what
/// shares in space are of squared shares along an axis, 1/32: 2/9 in all, or a little more, rounded down.
#[inline(always)]
fn bow(after: i32x4, before: i32x4) -> i32x4 {
    const IN_256: i16 = 57;
    const MOST: i32 = 3 * ((WHOLE / 2 * IN_256 as i32 * (WHOLE / 2)) >> 8);
    const { assert!(MOST <= BEFORE << ROOT_SHIFT) };
    let [after, before]: [i16x8; 2] = [after, before].map(cast);
    let bow: i32x4 = after.dot(before * i16x8::splat(IN_256)) >> 8;
    bow - i32x4::new([0, 0, 0, BEFORE << ROOT_SHIFT])
}

#[cfg(test)]
mod tests {
    use super::super::field::{Distances, lower_by_cell, lower_by_centre};
    use super::*;
    use crate::rng::{Purpose, Stream};

    /// In the middle of a grid, and at the end of the largest.
    const BLOCKS: [Block; 2] = [[40, 50, 60], [(1 << 20) - 1, 1 << 19, 3]];

    fn random(stream: &mut Stream) -> DVec3 {
        DVec3::from([0; 3].map(|_| stream.uniform()))
    }

    /// A place in a block of a level, in cells of the finest grid from the middle of the first, not on the border but
    /// for rounding.
    fn in_block(block: Block, level: usize, stream: &mut Stream) -> DVec3 {
        let low = DVec3::from(block.map(|c| f64::from(c << (2 * level + 2)) - 0.5));
        low + (0.001 + 0.998 * random(stream)) * f64::from(4 << (2 * level))
    }

    /// The bound on the distance from a place, in cells of the finest grid, by its block.
    fn bound(distances: &Distances, level: usize, p: DVec3) -> f64 {
        let corners = Corners::about(Spot::new(p).inside(level));
        let size = f64::from(1 << (2 * level));
        corners.bound(distances.about(corners.first), &Roots::new(|cells| cells)) * size
    }

    #[test]
    fn places_anywhere_have_the_spots_that_they_have_in_the_grids() {
        let mut stream = Stream::new(25, Purpose::Walker, 0);
        for i in 0..10_000 {
            let radius = 0.001 + stream.uniform();
            let low = (random(&mut stream) - 0.5) * 10f64.powi(i % 7);
            let (parts, first) = Parts::before(low, radius);
            let before = (low - first) / radius * PARTS;
            assert!(before.min_element() > -1e-3 && before.max_element() < 1.001);
            let place = in_block(BLOCKS[0], 0, &mut stream);
            let [there, expected] = [parts.spot(first + place * radius), Spot::new(place)];
            let off = [0, 1, 2].map(|axis| there.0[axis].abs_diff(expected.0[axis]));
            assert!(off.iter().all(|parts| *parts <= 1), "{off:?} parts");
        }
    }

    #[test]
    fn spots_are_where_places_are() {
        let mut stream = Stream::new(21, Purpose::Walker, 0);
        for i in 0..10_000 {
            let p = in_block(BLOCKS[i % 2], 0, &mut stream);
            let spot = Spot::new(p);
            let inside = DVec3::from(spot.inside(0).0.map(f64::from)) / PARTS;
            let low = DVec3::from(spot.cell().map(|c| f64::from(c / 4 * 4) - 0.5));
            assert!((low + inside - p).abs().max_element() <= 0.5 / PARTS);
            let steps: [[u8; 16]; 2] = spot.inside(0).steps(64).map(|s| s.to_array());
            let nearest = (inside * 32.0).to_array().map(|x| 64 + x.round() as u8);
            assert_eq!([steps[0][0], steps[0][8], steps[1][0]], nearest);
            assert!(steps[0][1..8].iter().all(|s| *s == nearest[0]));
        }
    }

    #[test]
    fn bounds_are_no_larger_than_distances_and_little_smaller() {
        let mut stream = Stream::new(22, Purpose::Walker, 0);
        let (mut sum, mut n) = (0.0, 0.0);
        for i in 0..4_000 {
            let (block, mut distances) = (BLOCKS[i % 2], Distances::default());
            let centres: Vec<DVec3> = (0..1 + (6.0 * stream.uniform()) as usize)
                .map(|_| in_block(block, 0, &mut stream) + 16.0 * (random(&mut stream) - 0.5))
                .collect();
            for &q in &centres {
                lower_by_centre(&mut distances, block, q);
            }
            for _ in 0..20 {
                let p = in_block(block, 0, &mut stream);
                let nearest = centres
                    .iter()
                    .fold(f64::INFINITY, |d, q| d.min(q.distance(p)));
                let bound = bound(&distances, 0, p);
                assert!(bound <= nearest, "{bound} of {nearest}");
                if (3.0..7.0).contains(&nearest) {
                    (sum, n) = (sum + bound / nearest, n + 1.0);
                }
            }
        }
        assert!(sum / n > 0.95, "{} of the distance", sum / n);
    }

    #[test]
    fn so_are_those_to_cells_on_a_coarser_grid() {
        let mut stream = Stream::new(23, Purpose::Walker, 0);
        let (mut sum, mut n) = (0.0, 0.0);
        for i in 0..4_000 {
            let (block, mut distances) = (BLOCKS[i % 2], Distances::default());
            let cells: Vec<Block> = (0..1 + (6.0 * stream.uniform()) as usize)
                .map(|_| {
                    let p = in_block(block, 2, &mut stream) + 200.0 * (random(&mut stream) - 0.5);
                    Spot::new(p).cell().map(|c| c >> 2)
                })
                .collect();
            for &cell in &cells {
                lower_by_cell(&mut distances, block, cell);
            }
            let away = |p: DVec3, cell: &Block| {
                let low = DVec3::from(cell.map(|c| f64::from(c << 2) - 0.5));
                let gaps = (low - p).max(p - low - 4.0).max(DVec3::ZERO);
                gaps.length()
            };
            for _ in 0..20 {
                let p = in_block(block, 2, &mut stream);
                let nearest = cells
                    .iter()
                    .fold(f64::INFINITY, |d, cell| d.min(away(p, cell)));
                let bound = bound(&distances, 2, p);
                assert!(bound <= nearest, "{bound} of {nearest}");
                if (48.0..112.0).contains(&nearest) {
                    (sum, n) = (sum + bound / nearest, n + 1.0);
                }
            }
        }
        assert!(sum / n > 0.95, "{} of the distance", sum / n);
    }

    #[test]
    fn where_nothing_is_seen_a_block_says_how_far_it_sees() {
        let mut stream = Stream::new(24, Purpose::Walker, 0);
        for _ in 0..1_000 {
            let p = in_block(BLOCKS[0], 0, &mut stream);
            let bound = bound(&Distances::default(), 0, p);
            assert!((7.7..8.0).contains(&bound), "{bound}");
        }
    }
}
