//! Contacts on a copy of the surface that hardly strays from it.
//!
//! Such a copy has a small share of the triangles, and its places are within a few hundredths of a radius of those
//! that they stand for. So a walker is on it right up to the lichen, and asks there whether it is in contact and
//! sticks. If it does, it lands, and the last of its way is walked again on the surface itself: elements are all there.
//! Where copy and surface do not agree that it is in contact it is thrown back, which counts as a refusal: that is
//! seldom (in a wedge of ten degrees one in a hundred of those that stick).

use glam::DVec2;

use super::far::{Far, Level};
use super::flight::Way;
use super::walker::{Fate, Meeting, Walk};
use crate::cluster::ElementIndex;
use crate::substrate::SurfacePoint;
use crate::walk::{Stand, Visitor, trace_visiting};

/// Radii of a way to a contact that are walked again on the surface: only the last one can be in contact.
const LAST: f64 = 1.5;

/// Of a way over the copy at least this share must lie in the triangle on the surface.
const LEAST_ALONG: f64 = 0.5;

/// What comes of a walker on its way.
pub(super) enum Met {
    /// It goes on to where its step led.
    Nothing,
    /// It goes back to where it was.
    Refused,
    /// It goes on from where it is now.
    OffCopy,
    End(Fate),
}

/// Notes the step as a vector where it ended.
#[derive(Default)]
struct Onward(DVec2);

impl Visitor for Onward {
    const ABSORB: bool = false;
    const WATCHES: bool = true;
    fn leave(&mut self, _: u32, _: f64, _: f64) {}
    fn arrive(&mut self, onward: DVec2) {
        self.0 = onward;
    }
}

impl<I: ElementIndex> Walk<'_, I> {
    /// What becomes of a walker whose step led over a copy to where it may touch lichen.
    #[inline(never)]
    pub(super) fn meet_on_copy(
        &mut self,
        far: &Far,
        now: &mut Way,
        there: &Stand,
        step: DVec2,
    ) -> Met {
        debug_assert!(far.is_near(now.level), "other copies end before contact");
        if !far.is_near(now.level) {
            return Met::Nothing;
        }
        match self.meet(Some(far.near()), there, &mut now.stream) {
            Meeting::Elsewhere => self.meet_below(far, now, there, step),
            Meeting::Refused => Met::Refused,
            Meeting::Sticks(probability) => {
                let landed = far.landed_from(now.level, self.around.substrate, there);
                self.stick((far, now), step, landed, probability)
            }
        }
    }

    /// The same on the surface itself: what stands for an element's triangle may be beside it.
    fn meet_below(&mut self, far: &Far, now: &mut Way, there: &Stand, step: DVec2) -> Met {
        let Some(landed) = far.landed_from(now.level, self.around.substrate, there) else {
            return Met::Nothing;
        };
        if !self.look_about(landed.position).touching {
            return Met::Nothing;
        }
        match self.meet(None, &landed, &mut now.stream) {
            Meeting::Elsewhere => {
                (now.here, now.level) = (landed, 0);
                now.bound = self.around.parameters.radius;
                Met::OffCopy
            }
            Meeting::Refused => Met::Refused,
            Meeting::Sticks(probability) => self.stick((far, now), step, Some(landed), probability),
        }
    }

    /// Joins a walker whose step over the copy led to a contact, given as the place on the surface.
    fn stick(
        &mut self,
        (far, now): (&Far, &mut Way),
        step: DVec2,
        contact: Option<Stand>,
        probability: f64,
    ) -> Met {
        let way = contact.and_then(|contact| self.last_of_way(far, (&now.here, step), &contact));
        match way {
            Some((from, step)) => self.join_from(now, (&from, step), probability),
            None => {
                self.track.counts.refusals += 1;
                Met::Refused
            }
        }
    }

    /// The place on the surface that one on the copy stands for, unless an element may be touched there.
    pub(super) fn landed_clear(&mut self, far: &Far, level: Level, here: &Stand) -> Option<Stand> {
        if !far.is_near(level) {
            return None;
        }
        let landed = far.landed_from(level, self.around.substrate, here)?;
        let is_clear = !self.look_about(landed.position).touching;
        is_clear.then_some(landed)
    }

    /// The last of a way over the copy to a contact, as one over the surface: where it begins, and the step. None
    /// where it does not come into contact there.
    fn last_of_way(
        &mut self,
        far: &Far,
        (from, step): (&Stand, DVec2),
        contact: &Stand,
    ) -> Option<(SurfacePoint, DVec2)> {
        let (substrate, copy) = (self.around.substrate, far.near().surface);
        let mut onward = Onward::default();
        let from = from.surface_point(copy);
        let end = trace_visiting(copy, &from, step, &mut onward)
            .point
            .triangle;
        let along = copy.facet(end).frame.turned_back(onward.0);
        let back = substrate.facet(contact.triangle).frame.turned(-along);
        // Beside a sharp edge the place on the surface may be on the other face.
        if back.length() < LEAST_ALONG * along.length() {
            return None;
        }
        let length = step.length().min(LAST * self.around.parameters.radius);
        let back = back.try_normalize()? * length;
        let place = (contact.triangle, contact.position);
        if !self.around.in_contact(self.scratch, place) {
            return None;
        }
        let mut onward = Onward::default();
        let contact = contact.surface_point(substrate);
        let begin = trace_visiting(substrate, &contact, back, &mut onward).point;
        let place = (begin.triangle, substrate.position(&begin));
        let is_clear = !self.around.in_contact(self.scratch, place);
        is_clear.then_some((begin, -onward.0))
    }
}
