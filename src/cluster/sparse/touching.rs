//! The centres that can touch something in a block of the finest grid.
//!
//! Their places relative to the block are kept as bytes, eight centres to a cache line, and compared
//! in whole numbers of sixteen bits, eight at once. That tells whether something touches except in a
//! band of a twelfth of a radius; what falls into the band is decided by the full positions.

use glam::DVec3;

use super::CONTACT;
use super::finest::BLOCK;
use super::make_room;

/// A block and what can touch it span this much along an axis, in radii.
const SPAN: f64 = BLOCK + 2.0 * CONTACT;

/// Where that begins, from the middle of the block's lowest cell.
const BEGIN: f64 = -0.5 - CONTACT;

/// Steps of a byte along an axis.
const STEP: f64 = SPAN / 256.0;

/// Places are compared in half steps: the middle of a byte's step is a whole number of them.
const HALF: f64 = 0.5 * STEP;

/// A centre is off by up to half a step an axis, a point by up to a quarter: √3 times as much in all.
const ERROR: f64 = 1.7321 * 0.75 * STEP;

/// Squared distances in half steps below which a centre touches for sure.
const SURE: u16 = ((CONTACT - ERROR) * (CONTACT - ERROR) / (HALF * HALF)) as u16;

/// Squared distances in half steps from which on it does not.
const POSSIBLE: u16 = ((CONTACT + ERROR) * (CONTACT + ERROR) / (HALF * HALF)) as u16 + 2;

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
        Self {
            place: ((offset - BEGIN) * (1.0 / STEP))
                .to_array()
                .map(|x| x as u8),
            id,
        }
    }
}

/// Eight of them.
#[derive(Clone, Copy)]
#[repr(align(64))]
struct Line {
    x: [u8; LANES],
    y: [u8; LANES],
    z: [u8; LANES],
    id: [u32; LANES],
    next: List,
    /// Places that are taken.
    taken: u32,
}

/// A linked list of lines, by the number of its first: only that one may have free places.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) struct List(u32);

impl Default for List {
    fn default() -> Self {
        Self(u32::MAX)
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
#[derive(Default)]
pub(super) struct Lines(Vec<Line>);

impl Lines {
    pub(super) fn expect(&mut self, lines: usize) {
        make_room(&mut self.0, lines);
    }

    pub(super) fn push(&mut self, list: &mut List, Entry { place, id }: Entry) {
        if self.first(*list).is_none_or(|l| l.taken as usize == LANES) {
            self.0.push(Line {
                x: [0; LANES],
                y: [0; LANES],
                z: [0; LANES],
                id: [u32::MAX; LANES],
                next: *list,
                taken: 0,
            });
            *list = List(self.0.len() as u32 - 1);
        }
        let line = &mut self.0[list.0 as usize];
        let lane = line.taken as usize;
        [line.x[lane], line.y[lane], line.z[lane]] = place;
        line.id[lane] = id;
        line.taken += 1;
    }

    #[inline(always)]
    fn first(&self, list: List) -> Option<&Line> {
        self.0.get(list.0 as usize)
    }

    fn lines(&self, list: List) -> impl Iterator<Item = &Line> {
        std::iter::successors(self.first(list), |line| self.first(line.next))
    }

    /// Whether a point in the block touches something.
    #[inline]
    pub(super) fn touch(&self, list: List, offset: DVec3) -> Touch {
        let at = Place::new(offset);
        let mut nearest = u16::MAX;
        for line in self.lines(list) {
            nearest = nearest.min(line.nearest_sq(at));
        }
        match nearest {
            n if n < SURE => Touch::Yes,
            n if n < POSSIBLE => Touch::Unsure,
            _ => Touch::No,
        }
    }

    /// The ids of those that may touch a point in the block.
    pub(super) fn touching(&self, list: List, offset: DVec3) -> impl Iterator<Item = u32> {
        let at = Place::new(offset);
        let chosen = self.chosen(list, move |line| {
            bits(line.distances_sq(at).map(|d| d < POSSIBLE))
        });
        chosen.map(|(line, i)| line.id[i])
    }

    /// The ids of those that may be in the block itself and within a distance of a place.
    pub(super) fn inside(
        &self,
        list: List,
        offset: DVec3,
        reach: f64,
    ) -> impl Iterator<Item = u32> {
        let limit = (reach + ERROR) * (reach + ERROR);
        let chosen = self.chosen(list, |line| {
            bits(std::array::from_fn(|i| may_be_inside(line.place(i))))
        });
        chosen.filter_map(move |(line, i)| {
            let near = place_of(line.place(i)).distance_squared(offset) < limit;
            near.then_some(line.id[i])
        })
    }

    /// Those of a list whose bits are set. That they are worked out for a whole line at once spares
    /// a branch for each, which no processor foresees.
    fn chosen(
        &self,
        list: List,
        choose: impl Fn(&Line) -> u8,
    ) -> impl Iterator<Item = (&Line, usize)> {
        self.lines(list).flat_map(move |line| {
            let mut left = choose(line) & (u8::MAX >> (LANES as u32 - line.taken));
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

/// A bit for each that is true, the first lowest.
#[inline(always)]
fn bits(all: [bool; LANES]) -> u8 {
    (0..LANES).fold(0, |bits, i| bits | u8::from(all[i]) << i)
}

/// The middle of the bytes' steps.
fn place_of([x, y, z]: [u8; 3]) -> DVec3 {
    DVec3::new(x.into(), y.into(), z.into()) * STEP + (BEGIN + HALF)
}

/// Whether a centre is in its list's block, or beside it by no more than rounding.
#[inline(always)]
fn may_be_inside([x, y, z]: [u8; 3]) -> bool {
    const LOW: u8 = (CONTACT / STEP) as u8 - 1;
    const HIGH: u8 = ((CONTACT + BLOCK) / STEP) as u8;
    let inside = |x: u8| x.wrapping_sub(LOW) <= HIGH - LOW;
    inside(x) & inside(y) & inside(z)
}

/// A point relative to a block, in half steps.
#[derive(Clone, Copy)]
struct Place([i16; 3]);

impl Place {
    #[inline(always)]
    fn new(offset: DVec3) -> Self {
        // Half of it is added to round to the nearest.
        let half_steps = (offset - BEGIN) * (1.0 / HALF) + 0.5;
        Self(half_steps.to_array().map(|x| x as i16))
    }
}

impl Line {
    #[inline(always)]
    fn place(&self, i: usize) -> [u8; 3] {
        [self.x[i], self.y[i], self.z[i]]
    }

    /// Squared distances in half steps, as far as sixteen bits reach: twice that of contact.
    #[inline(always)]
    fn distances_sq(&self, Place([x, y, z]): Place) -> [u16; LANES] {
        std::array::from_fn(|i| {
            let (x, y, z) = (gap(self.x[i], x), gap(self.y[i], y), gap(self.z[i], z));
            (x * x).saturating_add(y * y).saturating_add(z * z)
        })
    }

    #[inline(always)]
    fn nearest_sq(&self, at: Place) -> u16 {
        let distances = self.distances_sq(at);
        let mut nearest = u16::MAX;
        for (i, distance) in (0..).zip(distances) {
            let taken = if i < self.taken { distance } else { u16::MAX };
            nearest = nearest.min(taken);
        }
        nearest
    }
}

#[inline(always)]
fn gap(byte: u8, place: i16) -> u16 {
    let middle = 2 * i16::from(byte) + 1;
    (middle - place).abs().min(255) as u16
}
