//! The law of Brownian motion: a walker touches where a continuous path first would.
//!
//! Sumner 6.3 tests a step only where it ends, so a walker within r of the lichen may step over a
//! tip, and comes deeper into fjords than a continuous path. Here a walker far from the lichen goes
//! to a place on the rim of a disc that holds no element (Muller 1956, walk on spheres). Near the
//! lichen, where the triangle that it is in holds the disc, it goes on to where it first meets either
//! contact or the rim of a disc in which one element alone can be touched: exact, in one step. Where
//! edges are in the way it walks on discs until within [`SHELL`] of contact.
//!
//! A walker that is refused takes one of the thesis's steps from where it touched, which may be
//! another contact: the length r of that step is what makes P_s a rate.

use glam::{DVec2, DVec3};

use super::Steps;
use super::flight::Way;
use super::orbit::USUALLY_NEAR;
use super::passage::{Arrival, Lune};
use super::step::RandomStep;
use super::walker::Walk;
use crate::cluster::ElementIndex;
use crate::substrate::Chart;
use crate::walk::{Ball, Place, Stand};

/// Radii beyond contact within which elements near a walker are asked for.
const SPAN: f64 = 2.0;

/// Radii from contact that are as good as contact where the surface is not flat.
const SHELL: f64 = 0.01;

/// Radii on either side of contact that make sure which side is which.
const TUCK: f64 = 1e-7;

/// The elements near a walker, beyond contact and on its sheet.
#[derive(Clone, Copy)]
struct Near {
    /// The nearest: its distance, its number and its place.
    first: Option<(f64, u32, DVec3)>,
    /// The distance to the second.
    second: f64,
    /// Whether others are as near, but on another sheet.
    elsewhere: bool,
}

impl<I: ElementIndex> Walk<'_, I> {
    /// The next step. Where an element is touched, that is from beside the contact, and the walker goes
    /// there first.
    pub(super) fn brownian_step(&mut self, now: &mut Way) -> DVec2 {
        let radius = self.around.parameters.radius;
        if now.thrown_back {
            return now.random.within(radius, radius);
        }
        if now.level > 0 || now.bound >= radius {
            return now.random.of_length(now.bound.min(self.longest()));
        }
        let step;
        (now.here, step) = self.near_step(&now.here, &now.random);
        step
    }

    fn longest(&self) -> f64 {
        match self.around.parameters.steps {
            Steps::Small => self.around.parameters.radius,
            Steps::Large | Steps::Exact => f64::INFINITY,
        }
    }

    #[inline(never)]
    fn near_step(&mut self, here: &Stand, random: &RandomStep) -> (Stand, DVec2) {
        let (radius, contact) = (
            self.around.parameters.radius,
            self.around.contact_distance(),
        );
        let near = self.near(here);
        let longest = self.longest();
        let free = (near.second - contact).min(SPAN * radius).min(longest);
        let Some((distance, _, centre)) = near.first else {
            let free = if near.elsewhere {
                self.clear_on_sheet(here) - contact
            } else {
                free
            };
            return (*here, random.of_length(free.max(radius).min(longest)));
        };
        // Round a rim an element of another sheet becomes one of this all at once, however near it is: the
        // walker has to come there by steps that are looked at where they end.
        if near.elsewhere {
            let clear = (self.clear_on_sheet(here) - contact).max(radius);
            let length = clear.min(distance - contact + SHELL * radius);
            return (*here, random.of_length(length.min(longest)));
        }
        if let Some((lune, foot)) = self.lune(here, centre, free) {
            return match lune.first_arrival(random.cauchy()) {
                Arrival::Free(there) => (*here, there),
                Arrival::Contact(there) => {
                    let outward = (there - foot).normalize() * (TUCK * radius);
                    let beside = here.step(self.around.substrate, there + outward, false).to;
                    (beside, outward * -2.0)
                }
            };
        }
        let length = distance - contact + SHELL * radius;
        (*here, random.of_length(length.min(longest)))
    }

    /// The elements that a walker may touch soon.
    fn near(&mut self, here: &Stand) -> Near {
        let (radius, contact) = (
            self.around.parameters.radius,
            self.around.contact_distance(),
        );
        let reach = contact + SPAN * radius;
        self.asked(here.position, reach, 0);
        let mut near = Near {
            first: None,
            second: f64::INFINITY,
            elsewhere: false,
        };
        let (around, scratch) = (&self.around, &mut *self.scratch);
        let mut all: Vec<(u32, Place)> = Vec::with_capacity(USUALLY_NEAR);
        around.within(here.position, reach, &mut |id, element| {
            all.push((id, (element.at.triangle, element.position)));
        });
        let ball = Ball {
            centre: here.position,
            radius: reach + radius,
        };
        let mut others = std::mem::take(&mut scratch.others);
        others.clear();
        let places = all.iter().map(|(_, place)| *place);
        others.extend(places.filter(|place| place.0 != here.triangle));
        let place = (here.triangle, here.position);
        scratch.find(around.substrate, place, &ball, &mut others);
        scratch.others = others;
        for (id, (triangle, position)) in all {
            let distance = position.distance(here.position);
            // Nearer than contact without touching: joined by the surface only farther out.
            if scratch.has_reached(triangle) && distance > contact {
                near.add((distance, id, position));
            } else {
                near.elsewhere = true;
            }
        }
        near
    }

    /// The lune between a walker and an element, where the walker's triangle holds it; and from the
    /// walker to the middle of the circle in which the triangle's plane is in contact.
    fn lune(&self, here: &Stand, centre: DVec3, free: f64) -> Option<(Lune, DVec2)> {
        let substrate = self.around.substrate;
        let facet = substrate.facet(here.triangle);
        let room = room(&facet.chart, here.at);
        let across = centre - here.position;
        let foot = facet.frame.turned(across);
        let height_sq = across.length_squared() - foot.length_squared();
        let contact = self.around.contact_distance();
        let circle = (contact * contact - height_sq.max(0.0)).max(0.0).sqrt();
        let free = free.min(room).min(foot.length());
        Some((Lune::new(foot, circle, free)?, foot))
    }
}

impl Near {
    fn add(&mut self, one: (f64, u32, DVec3)) {
        match self.first {
            Some(first) if (first.0, first.1) < (one.0, one.1) => {
                self.second = self.second.min(one.0);
            }
            first => {
                self.second = first.map_or(f64::INFINITY, |first| first.0);
                self.first = Some(one);
            }
        }
    }
}

/// The distance from a place in a triangle to its rim.
fn room(chart: &Chart, at: DVec2) -> f64 {
    let corners = chart.corners();
    let to_edge = |k: usize| {
        let edge = corners[(k + 1) % 3] - corners[k];
        edge.perp_dot(at - corners[k]) / edge.length()
    };
    to_edge(0).min(to_edge(1)).min(to_edge(2))
}
