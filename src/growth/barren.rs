//! Walkers where lichen may not grow everywhere: see [`Habitat`](super::Habitat).

use super::far::NEAR;
use super::walker::Walk;
use super::{Counts, Parameters};
use crate::cluster::ElementIndex;
use crate::substrate::SurfacePoint;
use crate::walk::Stand;

/// Contacts of one walker, at most: then it is dropped for another one, for on a closed surface it might go on for ever
/// about a lichen that is hemmed in.
const MOST_CONTACTS: u64 = 1 << 14;

/// Contacts that come to nothing in a row before growth ends: a second at least, and a minute or two at most.
const LEAST_IN_VAIN: f64 = 1e6;
const MOST_IN_VAIN: f64 = 1e8;

/// The same for the square root of the elements, as many as a compact lichen has at its rim but for a factor, and for
/// each contact that the least chance to stick takes.
const IN_VAIN: f64 = 200.0;

impl<I: ElementIndex> Walk<'_, I> {
    /// The factor on the chance to stick where a walker may be in contact, on the surface or on the copy of it that
    /// hardly strays.
    #[inline(always)]
    pub(super) fn factor(&self, on_copy: bool, there: &Stand) -> f64 {
        match self.habitat.is_everywhere() {
            true => 1.0,
            false => self.factor_there(on_copy, there),
        }
    }

    #[inline(never)]
    fn factor_there(&self, on_copy: bool, there: &Stand) -> f64 {
        let substrate = self.around.substrate;
        let on_mesh = match self.far.filter(|_| on_copy) {
            None => Some(*there),
            Some(far) => far.landed(NEAR, substrate, there),
        };
        let factor = |there: Stand| self.habitat.at(&there.surface_point(substrate));
        on_mesh.map_or(0.0, factor)
    }

    /// Whether nothing may grow at a place.
    #[inline(always)]
    pub(super) fn is_barren(&self, at: &SurfacePoint) -> bool {
        !self.habitat.is_everywhere() && self.habitat.at(at) == 0.0
    }

    /// Whether a walker has been refused so often that another one may have better luck.
    #[inline(always)]
    pub(super) fn is_tired(&self) -> bool {
        self.track.counts.contacts >= MOST_CONTACTS && !self.habitat.is_everywhere()
    }
}

/// Whether so much has come to nothing since the last birth that a lichen counts as hemmed in.
pub(super) fn is_hemmed(
    parameters: &Parameters,
    elements: usize,
    [then, now]: [&Counts; 2],
) -> bool {
    let rim = (elements as f64).sqrt();
    let in_vain = (IN_VAIN * rim / parameters.min_stick).clamp(LEAST_IN_VAIN, MOST_IN_VAIN);
    (now.contacts - then.contacts) as f64 >= in_vain
}
