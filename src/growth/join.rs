//! How a walker that sticks becomes an element (Sumner 2001, 6.4).
//!
//! It is moved back along its step until it just touches. To `pack`, it is then rotated about the
//! element that it touched until it touches a second one: see [`orbit`](super::orbit).

use glam::{DVec2, DVec3};

use super::nearby::{Found, Nearby};
use super::orbit::{Orbit, USUALLY_NEAR};
use super::{Join, Surroundings};
use crate::cluster::ElementIndex;
use crate::substrate::{HalfEdge, Substrate, SurfacePoint};
use crate::walk::{Connectivity, TrianglePlane, Visitor, trace_visiting};

/// Where a walker came to rest.
#[derive(Clone, Copy, Debug)]
pub struct Joined {
    /// The place.
    pub at: SurfacePoint,
    /// The element that it touched first.
    pub touched: u32,
    /// Whether it was rotated to a second one.
    pub packed: bool,
}

/// A place nearer to a centre than contact by this share overlaps it.
const OVERLAP: f64 = 1e-9;

/// An element is not nearer to the one that it touches than contact by more than this share, where it can be helped.
const SHORT: f64 = 1e-6;

/// A step traced again may end short of contact by round-off: by less than this much more than its distance.
const ALMOST: f64 = 1.0 + 1e-6;

impl<I: ElementIndex> Surroundings<'_, I> {
    /// The resting place of a walker whose step from `from` ended in contact; none if it did not, or was so near to
    /// contact that round-off decides, or if it would overlap what it touches.
    pub fn join(
        &self,
        scratch: &mut Connectivity,
        from: &SurfacePoint,
        step: DVec2,
    ) -> Option<Joined> {
        self.join_where((scratch, &Nearby::default()), (from, step), false, |_| true)
    }

    /// The same; it is not packed to a place that does not suit. It may overlap what it touches if that is said.
    pub(super) fn join_where(
        &self,
        (scratch, nearby): (&mut Connectivity, &Nearby),
        (from, step): (&SurfacePoint, DVec2),
        may_overlap: bool,
        suits: impl Fn(&SurfacePoint) -> bool,
    ) -> Option<Joined> {
        let path = Path::follow(self.substrate, from, step);
        let (at, touched, at_distance) = self.first_touch((scratch, nearby), &path)?;
        if !at_distance && !may_overlap && self.is_short(&at, touched) {
            return None;
        }
        let first = Joined {
            at,
            touched,
            packed: false,
        };
        if self.parameters.join == Join::Touch || !at_distance {
            return Some(first);
        }
        let packed = Orbit::new(self, nearby, touched).second_touch(scratch, &at);
        let clear = |at: &SurfacePoint| !self.overlaps(scratch, at);
        let packed = packed.filter(&suits).filter(clear);
        Some(packed.map_or(first, |at| Joined {
            at,
            packed: true,
            ..first
        }))
    }

    /// Whether a place is nearer to an element than contact.
    fn is_short(&self, at: &SurfacePoint, id: u32) -> bool {
        let apart = self
            .element(id)
            .position
            .distance(self.substrate.position(at));
        apart < self.contact_distance() * (1.0 - SHORT)
    }

    /// After packing on a curved mesh, check again.
    fn overlaps(&self, scratch: &mut Connectivity, at: &SurfacePoint) -> bool {
        let distance = self.contact_distance() * (1.0 - OVERLAP);
        self.touching(
            scratch,
            (at.triangle, self.substrate.position(at)),
            distance,
        )
        .is_some()
    }

    /// The first place on a path that is at contact distance from an element of its sheet.
    ///
    /// Only the last r of a path can be in contact, so the element is within 3r of the path's end.
    /// False comes with a place that is nearer than that: see
    /// [`last_place_clear`](Self::last_place_clear).
    fn first_touch(
        &self,
        (scratch, found): (&mut Connectivity, &Nearby),
        path: &Path,
    ) -> Option<(SurfacePoint, u32, bool)> {
        let reach = 1.001 * (self.contact_distance() + self.parameters.radius);
        let mut nearby: Vec<Found> = Vec::with_capacity(USUALLY_NEAR);
        self.within_found(found, (path.end(), reach), |element| nearby.push(element));
        let touch = path
            .legs
            .iter()
            .find_map(|leg| self.first_touch_on(scratch, leg, &nearby));
        // What was of another sheet when the path came near it may be of the walker's here.
        let least = self.contact_distance() * (1.0 - OVERLAP);
        let touch = touch.filter(|(at, _)| {
            let p = self.substrate.position(at);
            let is_near = |f: &Found| f.place.distance_squared(p) < least * least;
            !nearby.iter().any(is_near) || !self.overlaps(scratch, at)
        });
        let (at, id) = touch.or_else(|| self.last_place_clear(scratch, path))?;
        Some((at, id, touch.is_some()))
    }

    fn first_touch_on(
        &self,
        scratch: &mut Connectivity,
        leg: &Leg,
        nearby: &[Found],
    ) -> Option<(SurfacePoint, u32)> {
        let touch = |f: &Found| Some((leg.meets(f.place, self.contact_distance())?, f.id()));
        let mut touches: Vec<(f64, u32)> = Vec::with_capacity(nearby.len());
        touches.extend(nearby.iter().filter_map(touch));
        touches.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        touches.into_iter().find_map(|(t, id)| {
            let (here, there) = ((leg.triangle, leg.at(t)), self.element(id));
            let same = self.same_sheet(scratch, here, (there.at.triangle, there.position));
            same.then(|| (leg.surface_point(self.substrate, t), id))
        })
    }

    /// The last place before a path comes into contact, by bisection.
    ///
    /// This is for walkers that come round a rim: an element of another sheet, already nearer
    /// than contact, becomes one of theirs without its distance passing 2r. They are refused there, while they can go
    /// elsewhere.
    fn last_place_clear(
        &self,
        scratch: &mut Connectivity,
        path: &Path,
    ) -> Option<(SurfacePoint, u32)> {
        let (mut clear, mut met) = (0.0, path.legs.len() as f64);
        let touched = |scratch: &mut Connectivity, t: f64, distance: f64| {
            let at = path.surface_point(self.substrate, t);
            let p = self.substrate.position(&at);
            self.touching(scratch, (at.triangle, p), distance)
        };
        let contact = self.contact_distance();
        let mut touching = touched(scratch, met, contact * ALMOST)?;
        for _ in 0..60 {
            let middle = 0.5 * (clear + met);
            match touched(scratch, middle, contact) {
                Some(id) => (met, touching) = (middle, id),
                None => clear = middle,
            }
        }
        Some((path.surface_point(self.substrate, clear), touching))
    }
}

/// A traced step as straight legs through space, one a triangle. Never empty.
struct Path {
    legs: Vec<Leg>,
}

/// A straight line through one triangle.
struct Leg {
    triangle: u32,
    from: DVec3,
    to: DVec3,
}

/// Notes where a trace crosses edges.
#[derive(Default)]
struct Crossed(Vec<(HalfEdge, f64)>);

impl Visitor for Crossed {
    const ABSORB: bool = false;
    const WATCHES: bool = true;
    fn leave(&mut self, half_edge: HalfEdge, share: f64, _: f64) {
        self.0.push((half_edge, share));
    }
}

impl Path {
    /// Traces a step again. It did not end at a boundary the first time, so it may reflect.
    fn follow(substrate: &Substrate, start: &SurfacePoint, step: DVec2) -> Self {
        let mut crossed = Crossed::default();
        let end = trace_visiting(substrate, start, step, &mut crossed).point;
        let mut from = substrate.position(start);
        let mut legs = Vec::with_capacity(crossed.0.len() + 1);
        for (half_edge, share) in crossed.0 {
            let (triangle, k) = (half_edge / 3, half_edge as usize % 3);
            let corners = substrate.corners(triangle);
            let to = corners[k].lerp(corners[(k + 1) % 3], share);
            legs.push(Leg { triangle, from, to });
            from = to;
        }
        legs.push(Leg {
            triangle: end.triangle,
            from,
            to: substrate.position(&end),
        });
        Self { legs }
    }

    fn end(&self) -> DVec3 {
        self.legs[self.legs.len() - 1].to
    }

    /// The place at t: the leg's number, and the share of it as fraction.
    fn surface_point(&self, substrate: &Substrate, t: f64) -> SurfacePoint {
        let leg = (t as usize).min(self.legs.len() - 1);
        self.legs[leg].surface_point(substrate, t - leg as f64)
    }
}

impl Leg {
    fn at(&self, t: f64) -> DVec3 {
        self.from.lerp(self.to, t)
    }

    fn surface_point(&self, substrate: &Substrate, t: f64) -> SurfacePoint {
        let plane = TrianglePlane::new(substrate, self.triangle);
        plane.surface_point(plane.project(self.at(t)).0)
    }

    /// The share of the leg at which it comes as near as `distance` to a centre.
    fn meets(&self, centre: DVec3, distance: f64) -> Option<f64> {
        let (e, f) = (self.to - self.from, self.from - centre);
        let (ee, ef) = (e.length_squared(), e.dot(f));
        let outside = f.length_squared() - distance * distance;
        let discriminant = ef * ef - ee * outside;
        if ef >= 0.0 || outside < 0.0 || discriminant < 0.0 {
            return None;
        }
        // The smaller root, in the form that does not cancel.
        let t = outside / (discriminant.sqrt() - ef);
        (t <= 1.0).then_some(t)
    }
}
