//! What walkers walk on and ask.

use std::sync::Mutex;

use crossbeam_utils::CachePadded;

use super::far::Far;
use super::flight::{Flight, Stage};
use super::launcher::Launcher;
use super::step::StepBounds;
use super::stick::Crowd;
use super::walker::{Interrupts, Walk};
use super::{Habitat, Parameters, Stickiness, Surroundings};
use crate::cluster::{ElementIndex, Population};
use crate::substrate::Substrate;
use crate::walk::Connectivity;

/// All that walkers share. Nothing in it but the index changes while some of them walk.
pub(super) struct Scene<'a, I: ElementIndex> {
    pub(super) substrate: &'a Substrate,
    pub(super) habitat: Habitat<'a>,
    pub(super) parameters: Parameters,
    pub(super) law: Stickiness,
    pub(super) index: I,
    pub(super) launcher: Launcher,
    /// None also where it is not worth having.
    pub(super) far: Option<Far>,
    /// For each that walk at the same time, on the surface and on a copy.
    pub(super) scratch: Vec<CachePadded<Mutex<[Connectivity; 2]>>>,
}

impl<I: ElementIndex> Scene<'_, I> {
    /// Takes a walker back to where it was disturbed, and lets it walk on. Whether it was taken
    /// back. `others_walk` says whether others may land before it, and the number which of those who
    /// walk now this is.
    pub(super) fn advance(
        &self,
        flight: &mut Flight<I>,
        elements: Population<'_>,
        (job, others_walk): (usize, bool),
        interrupts: Interrupts<'_>,
    ) -> bool {
        let again = self.catch_up(flight, &elements);
        if !others_walk {
            flight.track.forget(&self.index);
        }
        let mut scratch = match self.scratch[job].lock() {
            Ok(scratch) => scratch,
            // Scratch is good in any state.
            Err(poisoned) => poisoned.into_inner(),
        };
        let [scratch, on_copy] = &mut *scratch;
        let mut walk = Walk {
            around: Surroundings {
                substrate: self.substrate,
                parameters: &self.parameters,
                elements,
                index: &self.index,
            },
            law: &self.law,
            launcher: &self.launcher,
            far: self.far.as_ref(),
            habitat: self.habitat,
            scratch,
            on_copy,
            crowd: Crowd::default(),
            bounds: StepBounds::new(&self.parameters),
            track: &mut flight.track,
            others_walk,
            interrupts,
        };
        if let Stage::Ready = flight.stage {
            flight.launcher = self.launcher.version;
            flight.stage = match walk.set_out(flight.number) {
                Ok(way) => Stage::UnderWay(way),
                Err(fate) => Stage::Ended(fate),
            };
        }
        if let Stage::UnderWay(way) = &mut flight.stage
            && let Some(fate) = walk.go_on(way)
        {
            flight.stage = Stage::Ended(fate);
        }
        again
    }

    /// Takes a walker back to before whatever it would see otherwise now. Whether there was such a thing.
    pub(super) fn catch_up(&self, flight: &mut Flight<I>, elements: &Population<'_>) -> bool {
        flight.catch_up(&self.index, elements, self.launcher.version)
    }
}
