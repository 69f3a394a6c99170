//! The centres that can touch something in a block of the finest grid.
//!
//! Their places relative to the block are kept as bytes, eight centres to a cache line, and compared
//! as such, eight at once. That tells whether something touches except in a band of an eighth of a radius;
//! what falls into the band is decided by the full positions.

use std::sync::atomic::{AtomicU8, AtomicU32, Ordering};

use glam::DVec3;
use wide::{i16x8, u8x16};

use super::CONTACT;
use super::corners::Inside;
use super::finest::BLOCK;
use super::lanes;
use super::slab::Slab;

/// A block and what can touch it span this much along an axis, in radii.
const SPAN: f64 = BLOCK + 2.0 * CONTACT;

/// Where that begins, from the middle of the block's lowest cell.
const BEGIN: f64 = -0.5 - CONTACT;

/// Steps of a byte along an axis.
const STEP: f64 = SPAN / 256.0;

/// A centre is off by up to half a step an axis, and a point by an eighth more: √3 times as much in all.
const ERROR: f64 = 1.7321 * 1.125 * STEP;

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

/// Eight of them. All zeros are free places.
#[derive(Default)]
#[repr(C, align(64))]
struct Line {
    /// The places along each axis.
    xyz: [AtomicU8; 3 * LANES],
    ids: [AtomicU32; LANES],
    /// Places that are taken.
    taken: AtomicU32,
    next: SharedList,
}

/// A linked list of lines, by the number of its first: only that one may have free places. All end in
/// line 0, which is free, and is followed by itself.
#[derive(Clone, Copy, Default, PartialEq, Eq)]
pub(super) struct List(u32);

/// The same where walkers may read it while a birth adds to it.
#[derive(Default)]
pub(super) struct SharedList(AtomicU32);

impl SharedList {
    /// As it is now. Whoever has it sees what was in its lines when it was set.
    #[inline(always)]
    pub(super) fn get(&self) -> List {
        List(self.0.load(Ordering::Acquire))
    }

    fn set(&self, List(first): List) {
        self.0.store(first, Ordering::Release);
    }
}

/// Whether a point touches a centre of a list.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Touch {
    Yes,
    No,
    /// It is for the full positions to tell.
    Unsure,
}

/// The lines of many lists.
pub(super) struct Lines(Slab<Line>);

impl Default for Lines {
    fn default() -> Self {
        Self(Slab::of(Line::default()))
    }
}

/// Lines that so many entries take at most.
pub(super) fn lines_of(entries: usize) -> usize {
    entries.div_ceil(LANES)
}

impl Lines {
    pub(super) fn expect(&mut self, lines: usize) {
        self.0.expect(lines);
    }

    pub(super) fn make_room(&mut self, lines: usize) {
        self.0.make_room(lines);
    }

    pub(super) fn room(&self) -> usize {
        self.0.room()
    }

    pub(super) fn push(&self, list: &SharedList, entry: Entry) {
        let first = list.get();
        let line = self.line(first);
        if first != List(0) && line.taken() < LANES {
            return line.push(entry);
        }
        let (number, line) = self.0.take();
        line.next.set(first);
        line.push(entry);
        list.set(List(number));
    }

    #[inline(always)]
    fn line(&self, list: List) -> &Line {
        &self.0[list.0]
    }

    fn lines(&self, list: List) -> impl Iterator<Item = &Line> {
        let filled = |list: List| (list != List(0)).then(|| self.line(list));
        std::iter::successors(filled(list), move |line| filled(line.next.get()))
    }

    /// Whether a place in the block touches something.
    #[inline]
    pub(super) fn touch(&self, list: List, at: Place) -> Touch {
        // Most lists have one line or two: how many is not to be foreseen.
        let first = self.line(list);
        let second = self.line(first.next.get());
        let mut nearest = first.distances_sq(at).min(second.distances_sq(at));
        let mut next = second.next.get();
        while next != List(0) {
            let line = self.line(next);
            nearest = nearest.min(line.distances_sq(at));
            next = line.next.get();
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
            let taken = line.taken();
            let mut left = choose(line).to_bitmask() & (0xff >> (LANES - taken));
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

impl Place {
    #[inline(always)]
    pub(super) fn new(inside: Inside) -> Self {
        const BEFORE: i32 = (CONTACT / STEP) as i32;
        let [xy, z] = inside.steps(BEFORE);
        Self { xy, z }
    }
}

impl Line {
    fn push(&self, Entry { place, id }: Entry) {
        let lane = self.taken();
        self.ids[lane].store(id, Ordering::Relaxed);
        for (axis, place) in self.axes(lane).into_iter().zip(place) {
            axis.store(place, Ordering::Relaxed);
        }
        self.taken.store(lane as u32 + 1, Ordering::Release);
    }

    /// How many there are. Whoever knows sees them.
    #[inline(always)]
    fn taken(&self) -> usize {
        self.taken.load(Ordering::Acquire) as usize
    }

    #[inline(always)]
    fn id(&self, lane: usize) -> u32 {
        self.ids[lane].load(Ordering::Relaxed)
    }

    #[inline(always)]
    fn axes(&self, lane: usize) -> [&AtomicU8; 3] {
        [0, 1, 2].map(|axis| &self.xyz[axis * LANES + lane])
    }

    #[inline(always)]
    fn place(&self, lane: usize) -> [u8; 3] {
        self.axes(lane).map(|axis| axis.load(Ordering::Relaxed))
    }

    /// Places along the first and the second axis, and along the third in the lower half.
    #[inline(always)]
    fn places(&self) -> [u8x16; 2] {
        lanes::three_halves(&self.xyz)
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
