//! The centres that can touch something in a block of the finest grid.
//!
//! Their places relative to the block are kept as bytes, eight centres to a cache line, and compared
//! as such, eight at once. That tells whether something touches except in a band of a ninth of a radius;
//! what falls into the band is decided by the full positions.

use glam::DVec3;
use wide::{i16x8, u8x16};

use super::CONTACT;
use super::finest::{BLOCK, cell_of, rounded};
use super::make_room;

/// A block and what can touch it span this much along an axis, in radii.
const SPAN: f64 = BLOCK + 2.0 * CONTACT;

/// Where that begins, from the middle of the block's lowest cell.
const BEGIN: f64 = -0.5 - CONTACT;

/// Steps of a byte along an axis.
const STEP: f64 = SPAN / 256.0;

/// Steps that a block is wide.
const STEPS: u32 = (BLOCK / STEP) as u32;

/// The first step, from the middle of the block's lowest cell.
const FIRST: u32 = (BEGIN / STEP) as i32 as u32;

/// A centre and a point are each off by up to half a step an axis: √3 times as much in all.
const ERROR: f64 = 1.7321 * STEP;

/// Squared distances in steps below which a centre touches for sure.
const SURE: i16 = ((CONTACT - ERROR) * (CONTACT - ERROR) / (STEP * STEP)) as i16;

/// Squared distances in steps from which on it does not.
const POSSIBLE: i16 = ((CONTACT + ERROR) * (CONTACT + ERROR) / (STEP * STEP)) as i16 + 2;

/// A gap along an axis, in steps, that counts for every larger one: its square is beyond contact, and three
/// of them fit into sixteen bits.
const MOST_GAP: u8 = 104;

const LANES: usize = 8;

/// A centre relative to a block.
#[derive(Clone, Copy)]
pub(super) struct Entry {
    place: [u8; 3],
    id: u32,
}

impl Entry {
    /// A centre that can touch something in the block, or nearly.
    pub(super) fn new(offset: DVec3, id: u32) -> Self {
        let steps = (offset - BEGIN) * (1.0 / STEP);
        Self {
            // The nearest; at the far end the last, which nothing in the block touches for sure.
            place: (steps + 0.5).to_array().map(|x| x as u8),
            id,
        }
    }
}

/// Eight of them.
#[derive(Clone, Copy)]
#[repr(C, align(64))]
struct Line {
    xy: [u8; 2 * LANES],
    /// The places along the third axis, a byte each, and the ids, four each.
    z_and_ids: [u8; 5 * LANES],
    next: List,
    /// Places that are taken.
    taken: u32,
}

/// A linked list of lines, by the number of its first: only that one may have free places. All end in
/// line 0, which is free, and is followed by itself.
#[derive(Clone, Copy, Default, PartialEq, Eq)]
pub(super) struct List(u32);

const FREE: Line = Line {
    xy: [0; 2 * LANES],
    z_and_ids: [0; 5 * LANES],
    next: List(0),
    taken: 0,
};

/// Whether a point touches a centre of a list.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Touch {
    Yes,
    No,
    /// It is for the full positions to tell.
    Unsure,
}

/// The lines of many lists.
pub(super) struct Lines(Vec<Line>);

impl Default for Lines {
    fn default() -> Self {
        Self(vec![FREE])
    }
}

impl Lines {
    pub(super) fn expect(&mut self, lines: usize) {
        make_room(&mut self.0, lines);
    }

    pub(super) fn push(&mut self, list: &mut List, Entry { place, id }: Entry) {
        if *list == List(0) || self.line(*list).taken as usize == LANES {
            self.0.push(Line {
                next: *list,
                ..FREE
            });
            *list = List(self.0.len() as u32 - 1);
        }
        self.0[list.0 as usize].push(place, id);
    }

    #[inline(always)]
    fn line(&self, list: List) -> &Line {
        &self.0[list.0 as usize]
    }

    fn lines(&self, list: List) -> impl Iterator<Item = &Line> {
        let filled = |list: List| (list != List(0)).then(|| self.line(list));
        std::iter::successors(filled(list), move |line| filled(line.next))
    }

    /// Whether a place in the block touches something.
    #[inline]
    pub(super) fn touch(&self, list: List, at: Place) -> Touch {
        // Most lists have one line or two: how many is not to be foreseen.
        let first = self.line(list);
        let second = self.line(first.next);
        let mut nearest = first.distances_sq(at).min(second.distances_sq(at));
        let mut next = second.next;
        while next != List(0) {
            let line = self.line(next);
            nearest = nearest.min(line.distances_sq(at));
            next = line.next;
        }
        if !nearest.simd_lt(POSSIBLE).any() {
            return Touch::No;
        }
        match nearest.simd_lt(SURE).any() {
            true => Touch::Yes,
            false => Touch::Unsure,
        }
    }

    /// The ids of those that may touch a place in the block.
    pub(super) fn touching(&self, list: List, at: Place) -> impl Iterator<Item = u32> {
        let may_touch = move |line: &Line| line.distances_sq(at).simd_lt(POSSIBLE);
        self.chosen(list, may_touch).map(|(line, i)| line.id(i))
    }

    /// The ids of those that may be in the block itself and within a distance of a place.
    pub(super) fn inside(
        &self,
        list: List,
        offset: DVec3,
        reach: f64,
    ) -> impl Iterator<Item = u32> {
        let limit = (reach + ERROR) * (reach + ERROR);
        let chosen = self.chosen(list, Line::may_be_inside);
        chosen.filter_map(move |(line, i)| {
            let near = place_of(line.place(i)).distance_squared(offset) < limit;
            near.then_some(line.id(i))
        })
    }

    /// Those of a list that are chosen. That this is worked out for a whole line at once spares a branch
    /// for each, which no processor foresees.
    fn chosen(
        &self,
        list: List,
        choose: impl Fn(&Line) -> i16x8,
    ) -> impl Iterator<Item = (&Line, usize)> {
        self.lines(list).flat_map(move |line| {
            let mut left = choose(line).to_bitmask() & (0xff >> (LANES as u32 - line.taken));
            std::iter::from_fn(move || {
                let i = left.trailing_zeros() as usize;
                (left != 0).then(|| {
                    left &= left - 1;
                    (line, i)
                })
            })
        })
    }
}

/// Where the bytes' steps begin.
fn place_of([x, y, z]: [u8; 3]) -> DVec3 {
    DVec3::new(x.into(), y.into(), z.into()) * STEP + BEGIN
}

/// The bytes of each axis, widened.
#[inline(always)]
fn axes([xy, z]: [u8x16; 2]) -> [i16x8; 3] {
    [
        i16x8::from_u8x16_low(xy),
        i16x8::from_u8x16_high(xy),
        i16x8::from_u8x16_low(z),
    ]
}

/// A point in a block: the nearest step along each axis, for eight centres at once.
#[derive(Clone, Copy)]
pub(super) struct Place {
    xy: u8x16,
    z: u8x16,
}

/// The lowest byte of a number.
#[inline(always)]
fn eight_times(step: u32) -> [u8; LANES] {
    let four_times = u64::from(step as u8) * 0x0101_0101;
    (four_times | four_times << 32).to_ne_bytes()
}

impl Place {
    /// For a point in the cell of the finest grid about it.
    #[inline(always)]
    pub(super) fn new(p: DVec3) -> Self {
        let steps = rounded(p * (1.0 / STEP));
        let blocks = cell_of(p).map(|c| c >> 2);
        // From the grids' origin, but for what does not fit into a byte anyway.
        let step = |axis: usize| {
            steps[axis]
                .wrapping_sub(blocks[axis] * STEPS)
                .wrapping_sub(FIRST)
        };
        let [x, y, z] = [0, 1, 2].map(|axis| eight_times(step(axis)));
        let register =
            |halves: [[u8; LANES]; 2]| u8x16::new(halves.as_flattened().as_chunks().0[0]);
        Self {
            xy: register([x, y]),
            z: register([z, z]),
        }
    }
}

impl Line {
    fn push(&mut self, [x, y, z]: [u8; 3], id: u32) {
        let lane = self.taken as usize;
        (self.xy[lane], self.xy[LANES + lane], self.z_and_ids[lane]) = (x, y, z);
        let ids = self.z_and_ids[LANES..].as_chunks_mut::<4>().0;
        ids[lane] = id.to_ne_bytes();
        self.taken += 1;
    }

    #[inline(always)]
    fn id(&self, lane: usize) -> u32 {
        u32::from_ne_bytes(self.z_and_ids[LANES..].as_chunks::<4>().0[lane])
    }

    #[inline(always)]
    fn place(&self, lane: usize) -> [u8; 3] {
        [self.xy[lane], self.xy[LANES + lane], self.z_and_ids[lane]]
    }

    /// Places along the first and the second axis, and along the third in the lower half.
    #[inline(always)]
    fn places(&self) -> [u8x16; 2] {
        [self.xy, self.z_and_ids.as_chunks().0[0]].map(u8x16::new)
    }

    /// Squared distances in steps from a point in the block, as far as is of interest. Free places are
    /// beyond contact: all zeros are a corner two radii out along each axis.
    #[inline(always)]
    fn distances_sq(&self, at: Place) -> i16x8 {
        let gap = |a: u8x16, b: u8x16| {
            let either = a.saturating_sub(b) | b.saturating_sub(a);
            either.min(u8x16::splat(MOST_GAP))
        };
        let [xy, z] = self.places();
        let (xy, z) = (gap(xy, at.xy), gap(z, at.z));
        let [x, y, z] = axes([xy, z]);
        x * x + y * y + z * z
    }

    /// Which centres are in the list's block, or beside it by no more than rounding.
    #[inline(always)]
    fn may_be_inside(&self) -> i16x8 {
        const LOW: i16 = (CONTACT / STEP) as i16 - 1;
        const HIGH: i16 = ((CONTACT + BLOCK) / STEP) as i16;
        let [x, y, z] = axes(self.places())
            .map(|p| p.simd_gt(i16x8::splat(LOW - 1)) & p.simd_lt(i16x8::splat(HIGH + 1)));
        x & y & z
    }
}
