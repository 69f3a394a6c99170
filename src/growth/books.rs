//! What came of the walkers that have landed.

use std::collections::VecDeque;

use super::flight::Flight;
use super::scene::Scene;
use super::{Counts, Halt, barren};
use crate::cluster::{Cluster, Element, ElementIndex, Extent, Population};

/// Walkers that open edges take in a row before growth ends: some seconds at least. A lichen that grows slowly
/// because they take most loses some thousands for each element.
const MOST_ABSORBED: u64 = 10_000_000;

/// What the walkers that have landed took, and the elements of theirs that nobody has asked for yet.
#[derive(Default)]
pub(super) struct Books {
    pub(super) counts: Counts,
    /// What they were at the last birth.
    pub(super) at_birth: Counts,
    /// Those born ahead, with the counts at their births.
    pub(super) ahead: VecDeque<(Element, Counts)>,
    /// Walkers that landed while there was more than one thread to walk on.
    pub(super) landed_together: u64,
    /// That of so many elements.
    extent: (Extent, usize),
}

impl Books {
    /// A walker has landed.
    pub(super) fn add<I: ElementIndex>(&mut self, flight: &Flight<I>) {
        self.counts.add(&flight.track.counts);
    }

    /// Walkers since the last birth.
    pub(super) fn lost(&self) -> u64 {
        self.counts.walkers - self.at_birth.walkers
    }

    /// Makes the extent that of a cluster.
    pub(super) fn measure(&mut self, cluster: &Cluster) {
        if self.extent.1 != cluster.len() {
            self.extent = (cluster.extent().clone(), cluster.len());
        }
    }

    /// The youngest of some elements has been born ahead.
    pub(super) fn born_ahead(&mut self, elements: &Population<'_>) {
        let Some((age, youngest)) = elements.youngest() else {
            return;
        };
        self.at_birth.clone_from(&self.counts);
        self.ahead.push_back((*youngest, self.counts.clone()));
        self.extent.0.add(elements);
        self.extent.1 = age as usize + 1;
    }

    /// That of all elements, those born ahead too, once it was [measured](Self::measure).
    pub(super) fn extent(&self) -> &Extent {
        &self.extent.0
    }

    /// Whether so many walkers came to nothing that there is no use in going on.
    pub(super) fn in_vain<I: ElementIndex>(
        &self,
        scene: &Scene<'_, I>,
        elements: usize,
    ) -> Option<Halt> {
        if self.counts.absorbed - self.at_birth.absorbed >= MOST_ABSORBED {
            return Some(Halt::Starved);
        }
        let is_hemmed = !scene.habitat.is_everywhere()
            && barren::is_hemmed(&scene.parameters, elements, [&self.at_birth, &self.counts]);
        is_hemmed.then_some(Halt::Hemmed)
    }

    /// Whether so many walkers from outside the launch sphere were lost that they seem to find no way over habitat.
    pub(super) fn none_comes_in<I: ElementIndex>(
        &self,
        scene: &Scene<'_, I>,
        elements: usize,
    ) -> bool {
        !scene.habitat.is_everywhere()
            && !barren::comes_in(elements, [&self.at_birth, &self.counts])
    }
}
