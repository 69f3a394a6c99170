//! What every growth law offers to a run.

use std::iter::zip;

use serde::Serialize;

use crate::cluster::{Cluster, Element};

/// A law that chooses where the next element is born.
///
/// Whoever asks for elements owns the cluster: a [`Run`](crate::run::Run), whose model is a
/// [`WalkerModel`](super::WalkerModel), or a loop of one's own. It tells the model of every birth, the seed's too, so
/// that whatever the model keeps (an index, charges, potentials) can be rebuilt by telling it of them again.
pub trait GrowthModel {
    /// Makes room for so many elements in all. That is no promise that there will be as many.
    fn expect(&mut self, elements: usize);

    /// The youngest element of the cluster has just been added.
    fn born(&mut self, cluster: &Cluster);

    /// The next element.
    ///
    /// # Errors
    /// When there will be none, or when `cancelled` says so.
    ///
    /// # Panics
    /// When the model was not told of each element of the cluster once, or there is none yet.
    fn next(
        &mut self,
        cluster: &Cluster,
        cancelled: &(dyn Fn() -> bool + Sync),
    ) -> Result<Element, Halt>;

    /// What it took so far.
    fn counts(&self) -> &Counts;

    /// Goes on after births that it was told of as if they had taken this. Before the first [`next`](Self::next): what
    /// walks already does so by the counts that there were.
    fn resume(&mut self, counts: Counts);
}

/// Why a model gives no next element.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Halt {
    /// The lichen leaves no place free on its component.
    NoFreeSurface,
    /// Open edges took ten million walkers since the last birth.
    Starved,
    /// Where it may grow it is hemmed in: a thousand walkers or more since the last birth, or a million contacts at
    /// least, have come to nothing.
    Hemmed,
    /// It was told to stop.
    Cancelled,
}

/// How many counts there are.
pub(crate) const COUNTS: usize = 8;

/// What growth took: the whole run so far.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Counts {
    /// Walkers launched.
    pub walkers: u64,
    /// Walkers that left the kill radius.
    pub killed: u64,
    /// Walkers lost at an open edge.
    pub absorbed: u64,
    /// Steps taken.
    pub steps: u64,
    /// Triangle edges crossed by them.
    pub crossings: u64,
    /// Steps that ended in contact.
    pub contacts: u64,
    /// Contacts at which the walker did not stick.
    pub refusals: u64,
    /// Elements that were rotated to a second contact.
    pub packed: u64,
}

impl Counts {
    /// Whether so many elements can have taken this: a walker each but for the seeds, and no number larger than
    /// counting comes to.
    pub(crate) fn can_be_of(&self, elements: usize, seeds: usize) -> bool {
        const MOST: u64 = 1 << 60;
        let is_small = self.numbers().iter().all(|&n| n <= MOST);
        let born = elements.saturating_sub(seeds) as u64;
        is_small && self.walkers >= born && (born > 0 || self.walkers == 0)
    }

    /// All of them, in the order of logs. Taken apart by name: a new count does not compile until it is here.
    fn each(&mut self) -> [&mut u64; COUNTS] {
        let Self {
            walkers,
            killed,
            absorbed,
            steps,
            crossings,
            contacts,
            refusals,
            packed,
        } = self;
        [
            walkers, killed, absorbed, steps, crossings, contacts, refusals, packed,
        ]
    }

    pub(crate) fn numbers(&self) -> [u64; COUNTS] {
        self.clone().each().map(|number| *number)
    }

    pub(crate) fn from_numbers(numbers: [u64; COUNTS]) -> Self {
        let mut counts = Self::default();
        zip(counts.each(), numbers).for_each(|(count, number)| *count = number);
        counts
    }

    /// Adds what one walker took.
    pub(super) fn add(&mut self, walker: &Self) {
        zip(self.each(), walker.numbers()).for_each(|(sum, number)| *sum += number);
    }
}

/// How a run's work was shared among threads. It differs from run to run; the result does not.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Parallel {
    /// Walkers that came to their end while more than one thread was there to walk on.
    pub walks: u64,
    /// How often one of them was taken back, because an element born meanwhile might have changed
    /// its way.
    pub conflicts: u64,
    /// Seconds with several walkers on their way; the rest of growth runs on one thread.
    pub seconds: f64,
    /// How many of these, about, one thread took to land walkers and to add their elements, while the others walked: no
    /// two can at a time.
    pub landing: f64,
    /// Threads that walked at the end: where fewer than all are faster, these.
    pub threads: usize,
}
