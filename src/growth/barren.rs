//! Walkers where lichen may not grow everywhere: see [`Habitat`](super::Habitat).

use super::enclosed::Enclosed;
use super::far::{Level, NEAR, on_mesh};
use super::flight::Way;
use super::habitat::MOST_PLACES;
use super::near::Met;
use super::walker::{MOST_TRIES, Walk};
use super::{Counts, Parameters};
use crate::cluster::{ElementIndex, Look};
use crate::rng::Stream;
use crate::substrate::SurfacePoint;
use crate::walk::Stand;

/// Contacts of one walker, at most: then it is dropped for another one, for on a closed surface it might go on for ever
/// about a lichen that is hemmed in.
const MOST_CONTACTS: u64 = 1 << 14;

/// It has so many times as many at least as sticking by the least chance takes.
const PATIENCE: f64 = 100.0;

/// Contacts that come to nothing in a row before growth ends: a second at least, and a minute or two at most.
const LEAST_IN_VAIN: f64 = 1e6;
const MOST_IN_VAIN: f64 = 1e8;

/// The same for the square root of the elements, as many as a compact lichen has at its rim but for a factor, and for
/// each contact that the least chance to stick takes.
const IN_VAIN: f64 = 200.0;

/// The same for walkers: those launched inside the launch sphere come to whatever can be reached there. So many at
/// least, and for each that sticking by the least chance takes.
const LEAST_WALKERS: f64 = 1e3;
const WALKERS: f64 = 10.0;

/// Curvature radii, of so many radii at least, within which the border of the habitat is one to walkers.
const NEAR_RADII: f64 = 2.0;
const NEAR_AT_LEAST: f64 = 10.0;

/// How often a walker is kept from leaving the habitat, at most: it may be in a crumb of it that nothing leads out of.
const MOST_KEPT: u32 = 1 << 8;

/// Walkers lost since the last birth before others are launched inside the launch sphere; and the same where an element
/// has taken more than so many walkers, on average: most come in nowhere.
const MOST_LOST: u64 = 64;
const MOST_LOST_OF_MANY: u64 = 8;
const MANY: u64 = 16;

/// Places on the launch sphere that are tried.
const LAUNCHES: usize = 32;

impl<I: ElementIndex> Walk<'_, I> {
    /// The factor on the chance to stick where a walker may be in contact, on the surface or on the copy of it that
    /// hardly strays.
    #[inline(always)]
    pub(super) fn factor(&self, on_copy: bool, there: &Stand) -> f64 {
        match self.habitat.is_everywhere() {
            true => 1.0,
            false => self.factor_there(if on_copy { NEAR } else { 0 }, there),
        }
    }

    #[inline(never)]
    fn factor_there(&self, level: Level, there: &Stand) -> f64 {
        let on_mesh = on_mesh(self.far, self.around.substrate, level, there);
        // Where none is known the place at which it comes to rest decides.
        on_mesh.map_or(1.0, |at| self.habitat.at(&at))
    }

    /// Sends a walker back that is about to leave the habitat near the lichen, and drops one that comes near over
    /// barren ground.
    #[inline(always)]
    pub(super) fn keeps_to_habitat(
        &mut self,
        now: &mut Way,
        (from, there): (Option<Stand>, &Stand),
        look: &Look,
    ) -> Met {
        match self.habitat.is_everywhere() {
            true => Met::Nothing,
            false => self.met_border(now, (from, there), look),
        }
    }

    #[inline(never)]
    fn met_border(
        &mut self,
        now: &mut Way,
        (from, there): (Option<Stand>, &Stand),
        look: &Look,
    ) -> Met {
        let Parameters {
            radius,
            curvature_radius,
            ..
        } = *self.around.parameters;
        let near = NEAR_RADII * curvature_radius.max(NEAR_AT_LEAST * radius);
        if look.clear > near || self.factor_there(now.level, there) > 0.0 {
            return Met::Nothing;
        }
        now.here = from.unwrap_or(now.here);
        if now.kept >= MOST_KEPT || self.factor_there(now.level, &now.here) == 0.0 {
            return Met::End(self.kill());
        }
        now.kept += 1;
        // A shorter step may stay within a narrow place.
        if now.bound > radius {
            now.bound = (0.5 * now.bound).max(radius);
        }
        Met::Refused
    }

    /// Launches a walker where something may grow, as far as places tried say so. What is launched elsewhere is mostly
    /// dropped where it comes near the lichen.
    pub(super) fn launch_on_habitat(&mut self, stream: &mut Stream) -> Option<(Level, Stand)> {
        if self.habitat.is_everywhere() {
            return self.launch(stream);
        }
        if let Some(enclosed) = self.launcher.enclosed() {
            if let Some(start) = self.free_habitat(enclosed, stream) {
                let here = Stand::new(self.around.substrate, &start);
                self.asked(here.position, self.around.contact_distance(), 0);
                return Some((0, here));
            }
            if self.launcher.encloses_habitat() {
                return None;
            }
        }
        let mut start = self.launch(stream)?;
        for _ in 1..LAUNCHES {
            if self.factor_there(start.0, &start.1) > 0.0 {
                break;
            }
            start = self.launch(stream)?;
        }
        Some(start)
    }

    /// A place of the habitat that is in contact with nothing, uniform by area; none where so many are not that it
    /// counts as full.
    fn free_habitat(&mut self, inside: &Enclosed, stream: &mut Stream) -> Option<SurfacePoint> {
        let substrate = self.around.substrate;
        let places = (0..MOST_PLACES).filter_map(|_| inside.sample(substrate, stream));
        let suited = places.filter(|at| self.habitat.at(at) > 0.0);
        let place = |at: &SurfacePoint| (at.triangle, substrate.position(at));
        let is_free = |at: &SurfacePoint| !self.around.in_contact(self.scratch, place(at));
        suited.take(MOST_TRIES).find(is_free)
    }

    /// Whether a walker has come into contact so often that another one may have better luck.
    #[inline(always)]
    pub(super) fn is_tired(&self) -> bool {
        self.track.counts.contacts >= MOST_CONTACTS
            && !self.habitat.is_everywhere()
            && self.track.counts.contacts as f64 * self.around.parameters.min_stick >= PATIENCE
    }
}

/// Whether so many walkers from outside are lost in a row that others had better start inside the launch sphere.
pub(super) fn comes_in(elements: usize, [then, now]: [&Counts; 2]) -> bool {
    let most = match then.walkers > MANY * elements as u64 {
        true => MOST_LOST_OF_MANY,
        false => MOST_LOST,
    };
    lost(then, now) < most
}

/// Walkers since then, but for those that open edges took: they say nothing of the habitat.
fn lost(then: &Counts, now: &Counts) -> u64 {
    now.walkers - then.walkers - (now.absorbed - then.absorbed)
}

/// Whether so much has come to nothing since the last birth that a lichen counts as hemmed in.
pub(super) fn is_hemmed(
    parameters: &Parameters,
    elements: usize,
    [then, now]: [&Counts; 2],
) -> bool {
    let rim = (elements as f64).sqrt();
    let in_vain = (IN_VAIN * rim / parameters.min_stick).clamp(LEAST_IN_VAIN, MOST_IN_VAIN);
    let contacts = (now.contacts - then.contacts) as f64;
    let walkers = (WALKERS / parameters.min_stick).max(LEAST_WALKERS);
    contacts >= in_vain || lost(then, now) as f64 >= walkers
}
