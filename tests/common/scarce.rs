//! An index that has no room time and again.

use std::sync::atomic::{AtomicU64, Ordering};

use glam::DVec3;
use thallus::cluster::{Element, ElementIndex, Look, Mark, Notes, Population, SparseIndex};

/// The index that growth uses, but for every third element it has no room before some is made, and for its blocks
/// never.
pub(crate) struct Scarce {
    index: SparseIndex,
    asked: AtomicU64,
}

impl ElementIndex for Scarce {
    type Notes = Notes;

    fn new(radius: f64, wide: Option<f64>, bounds: [DVec3; 2]) -> Self {
        Self {
            index: SparseIndex::new(radius, wide, bounds),
            asked: AtomicU64::new(0),
        }
    }

    fn expect(&mut self, elements: usize) {
        self.index.expect(elements);
    }

    fn make_room(&mut self) {
        self.index.make_room();
    }

    fn insert(&self, elements: &Population<'_>) -> bool {
        let asked = self.asked.fetch_add(1, Ordering::Relaxed);
        !asked.is_multiple_of(3) && self.index.insert(elements)
    }

    fn adopt(&self, _: &Population<'_>, _: &mut Notes) {}

    fn mark(&self, notes: &Notes) -> Mark {
        self.index.mark(notes)
    }

    fn held(&self, elements: &Population<'_>, notes: &Notes) -> Mark {
        self.index.held(elements, notes)
    }

    fn rewind(&self, known: usize, notes: &mut Notes, mark: Mark) {
        self.index.rewind(known, notes, mark);
    }

    fn begin(&self, known: usize, notes: &mut Notes, others_walk: bool) {
        self.index.begin(known, notes, others_walk);
    }

    fn forget(&self, notes: &mut Notes) {
        self.index.forget(notes);
    }

    fn look(&self, elements: &Population<'_>, p: DVec3, notes: &mut Notes) -> Look {
        self.index.look(elements, p, notes)
    }

    fn count_bound(
        &self,
        elements: &Population<'_>,
        p: DVec3,
        radius: f64,
        enough: usize,
    ) -> usize {
        self.index.count_bound(elements, p, radius, enough)
    }

    fn read_ahead(&self, elements: &Population<'_>, p: DVec3) {
        self.index.read_ahead(elements, p);
    }

    fn any_within(
        &self,
        elements: &Population<'_>,
        p: DVec3,
        radius: f64,
        test: &mut dyn FnMut(u32, &Element) -> bool,
    ) -> bool {
        self.index.any_within(elements, p, radius, test)
    }

    fn any_touching(
        &self,
        elements: &Population<'_>,
        p: DVec3,
        notes: &mut Self::Notes,
        test: &mut dyn FnMut(u32, &Element) -> bool,
    ) -> bool {
        self.index.any_touching(elements, p, notes, test)
    }
}
