//! Vectors that one thread adds to while others read.

use std::ops::Index;
use std::sync::atomic::{AtomicUsize, Ordering};

use crossbeam_utils::CachePadded;

/// Places, of which the first so many are taken. Whoever adds takes the next and fills it through its atomics;
/// only one thread may at a time. Others read what they have been led to.
///
/// All places up to the end of the room are there, and only an exclusive owner can make more: so nothing moves
/// while others read.
pub(super) struct Slab<T> {
    places: Vec<T>,
    /// On cache lines of its own: others read all else here while it changes.
    taken: CachePadded<AtomicUsize>,
}

impl<T> Default for Slab<T> {
    fn default() -> Self {
        Self {
            places: Vec::new(),
            taken: CachePadded::default(),
        }
    }
}

/// Room is made for a share of what there is, and for so many at least.
const MORE: (usize, usize) = (32, 256);

impl<T: Default> Slab<T> {
    /// With the first place taken.
    pub(super) fn of(first: T) -> Self {
        Self {
            places: vec![first],
            taken: AtomicUsize::new(1).into(),
        }
    }

    /// Takes memory for so many, where there is any: room that is not used costs none.
    pub(super) fn expect(&mut self, places: usize) {
        super::make_room(&mut self.places, places);
    }

    /// Makes room for at least so many more, if there is less.
    pub(super) fn make_room(&mut self, more: usize) {
        if self.room() < more {
            let (share, least) = MORE;
            let all = self.len() + more.max(self.len() / share).max(least);
            self.places.resize_with(all, T::default);
        }
    }

    /// How many more there is room for.
    pub(super) fn room(&self) -> usize {
        self.places.len() - self.len()
    }

    pub(super) fn len(&self) -> usize {
        self.taken.load(Ordering::Relaxed)
    }

    /// Takes the next place: its number, and what is there from the beginning. There must be room.
    pub(super) fn take(&self) -> (u32, &T) {
        let number = self.len();
        let place = &self.places[number];
        self.taken.store(number + 1, Ordering::Relaxed);
        (number as u32, place)
    }
}

impl<T> Index<u32> for Slab<T> {
    type Output = T;

    #[inline(always)]
    fn index(&self, number: u32) -> &T {
        &self.places[number as usize]
    }
}

impl<T> Slab<T> {
    #[inline(always)]
    pub(super) fn get(&self, number: u32) -> Option<&T> {
        self.places.get(number as usize)
    }
}
