//! What a walker can ask about the place it is at.

use glam::DVec3;

use super::Parameters;
use crate::cluster::{Element, ElementIndex, Population};
use crate::substrate::Substrate;
use crate::walk::{Ball, Connectivity, Place};

/// The surface and the lichen on it, as they are while one walker walks.
pub struct Surroundings<'a, I> {
    /// The surface.
    pub substrate: &'a Substrate,
    /// The law's numbers.
    pub parameters: &'a Parameters,
    /// The lichen so far.
    pub elements: Population<'a>,
    /// Where its elements are.
    pub index: &'a I,
}

impl<I> std::fmt::Debug for Surroundings<'_, I> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Surroundings")
            .field("parameters", &self.parameters)
            .field("elements", &self.elements.len())
            .finish_non_exhaustive()
    }
}

/// The surface that sheets are asked of: the mesh or a copy of it.
#[derive(Clone, Copy)]
pub(super) struct Ground<'a> {
    pub(super) surface: &'a Substrate,
    /// For each triangle of the mesh the one of the copy that stands for it; of the mesh itself, none.
    pub(super) stand_ins: Option<&'a [u32]>,
}

impl Ground<'_> {
    /// Where an element is.
    #[inline(always)]
    pub(super) fn place(&self, element: &Element) -> Place {
        let triangle = element.at.triangle;
        let triangle = self
            .stand_ins
            .map_or(triangle, |all| all[triangle as usize]);
        (triangle, element.position)
    }
}

impl<'a, I: ElementIndex> Surroundings<'a, I> {
    /// The mesh.
    pub(super) fn mesh(&self) -> Ground<'a> {
        Ground {
            surface: self.substrate,
            stand_ins: None,
        }
    }

    /// The distance at which two centres touch.
    pub fn contact_distance(&self) -> f64 {
        2.0 * self.parameters.radius
    }

    /// Whether two places are on the same sheet for contact: the surface joins them inside the
    /// ball of radius 1.5 r about their midpoint.
    ///
    /// Centres in contact are within r of the midpoint. The half radius to spare lets the surface
    /// between them be rough; over the rim of a fin it allows detours up to 3r, and through a fin
    /// none. The rule is the same seen from either place.
    pub fn same_sheet(&self, scratch: &mut Connectivity, one: Place, other: Place) -> bool {
        self.are_joined(self.substrate, scratch, [one, other])
    }

    #[inline(always)]
    fn are_joined(
        &self,
        surface: &Substrate,
        scratch: &mut Connectivity,
        [one, other]: [Place; 2],
    ) -> bool {
        // Most are, and then no ball is laid out in memory: on the rock that takes a fiftieth of the time.
        if one.0 == other.0 {
            return true;
        }
        let ball = Ball::of_contact([one.1, other.1], self.parameters.radius);
        scratch.joined(surface, [one, other], &ball)
    }

    /// The nearest element on the sheet of a place, which is given by its triangle and its position
    /// in space, with its centre nearer than `distance`, which is at most that of contact.
    pub fn touching(
        &self,
        scratch: &mut Connectivity,
        (triangle, p): (u32, DVec3),
        distance: f64,
    ) -> Option<u32> {
        let mut nearest: Option<(f64, u32)> = None;
        self.within(p, distance, &mut |id, element| {
            let candidate = (p.distance_squared(element.position), id);
            let nearer = nearest.is_none_or(|n| candidate < n);
            let there = (element.at.triangle, element.position);
            if nearer && self.same_sheet(scratch, (triangle, p), there) {
                nearest = Some(candidate);
            }
        });
        nearest.map(|(_, id)| id)
    }

    /// Whether an element on the same sheet is in contact with a walker.
    pub fn in_contact(&self, scratch: &mut Connectivity, place: Place) -> bool {
        let contact = self.contact_distance();
        self.index
            .any_within(&self.elements, place.1, contact, &mut |_, element| {
                let there = (element.at.triangle, element.position);
                self.same_sheet(scratch, place, there)
            })
    }

    /// The same for a walker that has looked from there.
    pub(super) fn touches_on(
        &self,
        (ground, scratch): (&Ground<'_>, &mut Connectivity),
        place: Place,
        notes: &mut I::Notes,
    ) -> bool {
        self.index
            .any_touching(&self.elements, place.1, notes, &mut |_, element| {
                self.are_joined(ground.surface, scratch, [place, ground.place(element)])
            })
    }

    /// One that was visited.
    pub(super) fn element(&self, id: u32) -> &'a Element {
        self.elements.get(id).expect("an element that was found")
    }

    /// Visits every element with its centre nearer than `radius` to a place, in no stated order.
    pub(super) fn within(&self, p: DVec3, radius: f64, visit: &mut dyn FnMut(u32, &Element)) {
        self.index.within(&self.elements, p, radius, visit);
    }
}
