//! What every growth law offers to a run.

use serde::Serialize;

use crate::cluster::{Cluster, Element};

/// A law that chooses where the next element is born.
///
/// The run owns the cluster. It tells the model of every birth, the seed's too, so that whatever
/// the model keeps (an index, charges, potentials) can be rebuilt by telling it of them again.
pub trait GrowthModel {
    /// The youngest element of the cluster has just been added.
    fn born(&mut self, cluster: &Cluster);

    /// The next element.
    ///
    /// # Errors
    /// When there will be none, or when `cancelled` says so.
    fn next(&mut self, cluster: &Cluster, cancelled: &dyn Fn() -> bool) -> Result<Element, Halt>;

    /// What it took so far.
    fn counts(&self) -> &Counts;

    /// Goes on after births that it was told of as if they had taken this.
    fn resume(&mut self, counts: Counts);
}

/// Why a model gives no next element.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Halt {
    /// The lichen leaves no place free on its component.
    NoFreeSurface,
    /// It was told to stop.
    Cancelled,
}

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
