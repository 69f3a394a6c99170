//! How often walkers ask how far the lichen is, counted by an index that counts.

use std::sync::atomic::{AtomicU64, Ordering};

use glam::DVec3;
use thallus::cluster::{
    Cluster, Element, ElementIndex, Look, Mark, Notes, Population, SparseIndex,
};
use thallus::growth::{GrowthModel, Parameters, WalkerModel};
use thallus::substrate::Substrate;

static LOOKUPS: AtomicU64 = AtomicU64::new(0);

/// The index that growth uses, with a count.
struct Counting(SparseIndex);

/// The lookups of the walkers that made a lichen: it is grown once more.
pub(crate) fn lookups(substrate: &Substrate, parameters: Parameters, grown: &Cluster) -> u64 {
    LOOKUPS.store(0, Ordering::Relaxed);
    let mut model = WalkerModel::<Counting>::with_index(substrate, parameters);
    let mut cluster = Cluster::new(grown.radius());
    cluster.push(grown.elements()[0]);
    model.born(&cluster);
    while cluster.len() < grown.len() {
        let next = model.next(&cluster, &|| false).expect("as it grew before");
        cluster.push(next);
        model.born(&cluster);
    }
    assert_eq!(cluster.elements(), grown.elements());
    LOOKUPS.load(Ordering::Relaxed)
}

impl ElementIndex for Counting {
    type Notes = Notes;

    fn new(radius: f64, wide: Option<f64>, bounds: [DVec3; 2]) -> Self {
        Self(SparseIndex::new(radius, wide, bounds))
    }

    fn expect(&mut self, elements: usize) {
        self.0.expect(elements);
    }

    fn make_room(&mut self) {
        self.0.make_room();
    }

    fn insert(&self, elements: &Population<'_>) -> bool {
        self.0.insert(elements)
    }

    fn adopt(&self, elements: &Population<'_>, notes: &mut Notes) {
        self.0.adopt(elements, notes);
    }

    fn mark(&self, notes: &Notes) -> Mark {
        self.0.mark(notes)
    }

    fn held(&self, elements: &Population<'_>, notes: &Notes) -> Mark {
        self.0.held(elements, notes)
    }

    fn rewind(&self, known: usize, notes: &mut Notes, mark: Mark) {
        self.0.rewind(known, notes, mark);
    }

    fn begin(&self, known: usize, notes: &mut Notes, others_walk: bool) {
        self.0.begin(known, notes, others_walk);
    }

    fn forget(&self, notes: &mut Notes) {
        self.0.forget(notes);
    }

    fn look(&self, elements: &Population<'_>, p: DVec3, notes: &mut Notes) -> Look {
        LOOKUPS.fetch_add(1, Ordering::Relaxed);
        self.0.look(elements, p, notes)
    }

    fn count_bound(
        &self,
        elements: &Population<'_>,
        p: DVec3,
        radius: f64,
        enough: usize,
    ) -> usize {
        self.0.count_bound(elements, p, radius, enough)
    }

    fn read_ahead(&self, elements: &Population<'_>, p: DVec3) {
        self.0.read_ahead(elements, p);
    }

    fn any_within(
        &self,
        elements: &Population<'_>,
        p: DVec3,
        radius: f64,
        test: &mut dyn FnMut(u32, &Element) -> bool,
    ) -> bool {
        self.0.any_within(elements, p, radius, test)
    }

    fn any_touching(
        &self,
        elements: &Population<'_>,
        p: DVec3,
        notes: &mut Self::Notes,
        test: &mut dyn FnMut(u32, &Element) -> bool,
    ) -> bool {
        self.0.any_touching(elements, p, notes, test)
    }
}
