//! Rotation about an element, along the surface at contact distance (Sumner 2001, 6.4).
//!
//! The curve is the sphere of radius 2r about the element's centre, cut by the surface: a circular
//! arc in each triangle. It is followed exactly, arc by arc, until it meets the sphere of another
//! element of the same sheet.

use std::f64::consts::TAU;

use glam::{DVec2, DVec3};

use super::Surroundings;
use super::launch::circle_crossings;
use super::nearby::Nearby;
use crate::cluster::ElementIndex;
use crate::substrate::{HalfEdge, SurfacePoint};
use crate::walk::{Connectivity, TrianglePlane};

/// Arcs that one rotation may follow: a full turn over triangles a hundredth of r in size.
const MOST_ARCS: u32 = 4096;

/// Angles this close before the start are at the start, up to round-off.
const ROUND_OFF: f64 = 1e-9;

/// Elements that there seldom are more of within a few radii. Lists are made for as many at once: one
/// that grows takes the allocator's lock, and threads wait for each other there.
pub(super) const USUALLY_NEAR: usize = 24;

/// A rotation about one element.
pub(super) struct Orbit<'a, I> {
    around: &'a Surroundings<'a, I>,
    /// The element's triangle and centre.
    about: u32,
    centre: DVec3,
    reach: f64,
    /// The other elements that the rotation can meet.
    others: Vec<(u32, DVec3)>,
}

/// A second contact, and how far along the curve it was.
struct Met {
    at: SurfacePoint,
    length: f64,
}

/// A place on the curve, seen in one triangle's plane.
struct Here {
    triangle: u32,
    plane: TrianglePlane,
    /// The circle that the sphere cuts from the plane.
    centre: DVec2,
    radius: f64,
    point: DVec2,
    /// 1 counter-clockwise, −1 clockwise in the plane.
    sense: f64,
}

/// How the curve leaves a triangle.
struct Exit {
    angle: f64,
    edge: usize,
    share: f64,
}

impl<'a, I: ElementIndex> Orbit<'a, I> {
    pub(super) fn new(around: &'a Surroundings<'a, I>, nearby: &Nearby, about: u32) -> Self {
        let element = around.element(about);
        let (triangle, centre) = (element.at.triangle, element.position);
        let reach = around.contact_distance();
        let mut others = Vec::with_capacity(USUALLY_NEAR);
        around.within_found(nearby, (centre, 2.0 * reach), |id, place| {
            if id != about {
                others.push((id, place));
            }
        });
        Self {
            around,
            about: triangle,
            centre,
            reach,
            others,
        }
    }

    /// The nearer, along the curve, of the two places at which a rotation from a place first
    /// touches a second element.
    pub(super) fn second_touch(
        &self,
        scratch: &mut Connectivity,
        from: &SurfacePoint,
    ) -> Option<SurfacePoint> {
        if self.others.is_empty() {
            return None;
        }
        let ways = [1.0, -1.0].map(|sense| self.rotate(scratch, from, sense));
        let nearer = |a: Met, b: Met| if b.length < a.length { b } else { a };
        let [a, b] = ways;
        a.into_iter().chain(b).reduce(nearer).map(|met| met.at)
    }

    fn rotate(&self, scratch: &mut Connectivity, from: &SurfacePoint, sense: f64) -> Option<Met> {
        let start = self.around.substrate.position(from);
        let mut here = self.begin(from, sense)?;
        let mut length = 0.0;
        for arcs in 0..MOST_ARCS {
            let exit = here.exit();
            let end = exit.as_ref().map_or(TAU, |e| e.angle);
            if let Some((angle, at)) = self.first_met(scratch, &here, end) {
                let met = Met {
                    at,
                    length: length + angle * here.radius,
                };
                return self.stays_with(scratch, &met.at).then_some(met);
            }
            let exit = exit?;
            if arcs > 0 && here.triangle == from.triangle && here.passes(start, exit.angle) {
                return None;
            }
            length += exit.angle * here.radius;
            here = self.cross(&here, &exit)?;
        }
        None
    }

    /// Whether a place is still on the sheet of the element that it turned about: near a rim the
    /// curve can run on to where only the plate's thickness lies between them.
    fn stays_with(&self, scratch: &mut Connectivity, at: &SurfacePoint) -> bool {
        let here = (at.triangle, self.around.substrate.position(at));
        self.around
            .same_sheet(scratch, here, (self.about, self.centre))
    }

    fn begin(&self, from: &SurfacePoint, sense: f64) -> Option<Here> {
        let plane = TrianglePlane::new(self.around.substrate, from.triangle);
        let point = plane.project(self.around.substrate.position(from)).0;
        self.circle(&plane).map(|(centre, radius)| Here {
            triangle: from.triangle,
            plane,
            centre,
            radius,
            point,
            sense,
        })
    }

    /// The circle that the sphere about the element cuts from a plane.
    fn circle(&self, plane: &TrianglePlane) -> Option<(DVec2, f64)> {
        circle_in(plane, self.centre, self.reach)
    }

    /// The first element of the same sheet that the curve meets before an angle.
    fn first_met(
        &self,
        scratch: &mut Connectivity,
        here: &Here,
        end: f64,
    ) -> Option<(f64, SurfacePoint)> {
        let mut meetings: Vec<(f64, u32, DVec2)> = Vec::with_capacity(USUALLY_NEAR);
        meetings.extend(self.others.iter().filter_map(|&(id, q)| {
            let (centre, radius) = circle_in(&here.plane, q, self.reach)?;
            let p = here.meeting(centre, radius)?;
            Some((here.turn_to(p), id, p))
        }));
        // The first mostly is the one: to put all in order would be to do so for nothing.
        while let Some(first) = first_of(&meetings) {
            let (_, id, p) = meetings.swap_remove(first);
            let angle = here.angle_to(p);
            if angle > end {
                return None;
            }
            let p = here.at_angle(angle);
            let there = self.around.element(id);
            let there = (there.at.triangle, there.position);
            let place = (here.triangle, here.plane.lift(p));
            if self.around.same_sheet(scratch, place, there) {
                return Some((angle, here.plane.surface_point(p)));
            }
        }
        None
    }

    /// Goes on in the triangle beyond an exit; none at a boundary edge.
    fn cross(&self, here: &Here, exit: &Exit) -> Option<Here> {
        let left = 3 * here.triangle + exit.edge as HalfEdge;
        let twin = self.around.substrate.twin(left);
        let entry = twin.half_edge();
        if entry == left {
            return None;
        }
        let (triangle, k) = (entry / 3, entry as usize % 3);
        let plane = TrianglePlane::new(self.around.substrate, triangle);
        let (centre, radius) = self.circle(&plane)?;
        let share = if twin.is_flipped() {
            exit.share
        } else {
            1.0 - exit.share
        };
        let (a, b) = (plane.corners()[k], plane.corners()[(k + 1) % 3]);
        let point = a.lerp(b, share);
        let inward = (b - a).perp_dot((point - centre).perp());
        let sense = if inward >= 0.0 { 1.0 } else { -1.0 };
        Some(Here {
            triangle,
            plane,
            centre,
            radius,
            point,
            sense,
        })
    }
}

/// Which of some meetings comes first; of several in one place, the oldest element's.
fn first_of(meetings: &[(f64, u32, DVec2)]) -> Option<usize> {
    let before = |a: usize, b: usize| {
        let ((turn, id, _), (other_turn, other, _)) = (meetings[a], meetings[b]);
        turn < other_turn || (turn == other_turn && id < other)
    };
    (0..meetings.len()).reduce(|first, i| if before(i, first) { i } else { first })
}

/// The circle that a sphere cuts from a plane.
fn circle_in(plane: &TrianglePlane, centre: DVec3, radius: f64) -> Option<(DVec2, f64)> {
    let (foot, height_sq) = plane.project(centre);
    let circle_sq = radius * radius - height_sq;
    (circle_sq > 0.0).then(|| (foot, circle_sq.sqrt()))
}

impl Here {
    /// How far the curve turns from here to a point of the circle, in [0, 2π).
    fn angle_to(&self, p: DVec2) -> f64 {
        let (sin, cos) = self.turned(p);
        let angle = libm::atan2(sin, cos);
        match if angle < 0.0 { angle + TAU } else { angle } {
            a if a > TAU - ROUND_OFF => 0.0,
            a => a,
        }
    }

    /// A number that grows with that angle, in [0, 4), and takes less time.
    fn turn_to(&self, p: DVec2) -> f64 {
        let (sin, cos) = self.turned(p);
        let is_start = cos > 0.0 && -sin < ROUND_OFF * cos;
        let share = cos / (sin.abs() + cos.abs());
        match sin >= 0.0 {
            true => 1.0 - share,
            false if is_start => 0.0,
            false => 3.0 + share,
        }
    }

    /// Sine and cosine of that angle, times the circle's radius squared.
    fn turned(&self, p: DVec2) -> (f64, f64) {
        let (from, to) = (self.point - self.centre, p - self.centre);
        (self.sense * from.perp_dot(to), from.dot(to))
    }

    /// Direction of travel at a point of the circle, of the circle's radius in length.
    fn velocity(&self, p: DVec2) -> DVec2 {
        (p - self.centre).perp() * self.sense
    }

    fn at_angle(&self, angle: f64) -> DVec2 {
        let (sin, cos) = libm::sincos(self.sense * angle);
        let from = (self.point - self.centre).normalize_or(DVec2::X) * self.radius;
        self.centre + DVec2::new(cos, sin).rotate(from)
    }

    /// Where the curve first goes out through an edge.
    fn exit(&self) -> Option<Exit> {
        let corners = self.plane.corners();
        let mut first: Option<Exit> = None;
        for edge in 0..3 {
            let (a, e) = (corners[edge], corners[(edge + 1) % 3] - corners[edge]);
            for share in circle_crossings(a - self.centre, e, self.radius * self.radius) {
                let p = a + e * share;
                let inside = (-ROUND_OFF..=1.0 + ROUND_OFF).contains(&share);
                if !inside || e.perp_dot(self.velocity(p)) >= 0.0 {
                    continue;
                }
                let angle = self.angle_to(p);
                if first.as_ref().is_none_or(|f| angle < f.angle) {
                    first = Some(Exit {
                        angle,
                        edge,
                        share: share.clamp(0.0, 1.0),
                    });
                }
            }
        }
        first
    }

    /// Where the curve comes into another circle, if it does.
    ///
    /// Of the two places p where the circles cross, that is the one where its direction v goes inwards: v·(p − centre)
    /// is sense · across · distance² on the left of the way to the other centre, and minus that on the right.
    fn meeting(&self, centre: DVec2, radius: f64) -> Option<DVec2> {
        let between = centre - self.centre;
        let distance_sq = between.length_squared();
        let along =
            (self.radius * self.radius - radius * radius + distance_sq) / (2.0 * distance_sq);
        let across_sq = self.radius * self.radius / distance_sq - along * along;
        (across_sq > 0.0).then(|| {
            let aside = between.perp() * (-self.sense * across_sq.sqrt());
            self.centre + between * along + aside
        })
    }

    /// Whether the curve passes a point in space, on its circle, within an angle.
    fn passes(&self, p: DVec3, angle: f64) -> bool {
        self.angle_to(self.plane.project(p).0) <= angle
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::rng::{Purpose, Stream};
    use crate::substrate::Substrate;

    /// Circles of radius 1 about the origin of a triangle's chart, begun anywhere, both ways.
    fn random_place(stream: &mut Stream, plane: TrianglePlane) -> Here {
        Here {
            triangle: 0,
            plane,
            centre: DVec2::ZERO,
            radius: 1.0,
            point: stream.in_unit_disc().normalize(),
            sense: if stream.uniform() < 0.5 { 1.0 } else { -1.0 },
        }
    }

    #[test]
    fn meetings_are_where_the_curve_comes_in() {
        let substrate = Substrate::load(Path::new("meshes/plane.obj")).expect("a mesh");
        let mut stream = Stream::new(10, Purpose::Walker, 0);
        let mut met = 0;
        for _ in 0..4000 {
            let here = random_place(&mut stream, TrianglePlane::new(&substrate, 0));
            let (centre, radius) = (3.0 * stream.in_unit_disc(), 0.2 + stream.uniform());
            let cross = (1.0 - radius).abs() < centre.length() && centre.length() < 1.0 + radius;
            let meeting = here.meeting(centre, radius);
            assert_eq!(meeting.is_some(), cross, "{centre:?}, {radius}");
            let Some(p) = meeting else { continue };
            assert!((p.length() - 1.0).abs() < 1e-9 && (p.distance(centre) - radius).abs() < 1e-9);
            assert!(here.velocity(p).dot(p - centre) < 0.0, "{p:?}");
            met += 1;
        }
        assert!(met > 1000, "{met}");
    }

    #[test]
    fn turns_are_in_the_order_of_angles() {
        let substrate = Substrate::load(Path::new("meshes/plane.obj")).expect("a mesh");
        let mut stream = Stream::new(9, Purpose::Walker, 0);
        for _ in 0..4000 {
            let here = random_place(&mut stream, TrianglePlane::new(&substrate, 0));
            let mut points: Vec<DVec2> =
                (0..12).map(|_| stream.in_unit_disc().normalize()).collect();
            points.push(here.point);
            // As round-off leaves it just before the start.
            let back = DVec2::from_angle(-here.sense * 1e-12);
            points.push(back.rotate(here.point));
            points.sort_by(|a, b| here.turn_to(*a).total_cmp(&here.turn_to(*b)));
            let angles: Vec<f64> = points.iter().map(|p| here.angle_to(*p)).collect();
            assert_eq!(&angles[..2], [0.0; 2]);
            assert!(angles.is_sorted(), "{angles:?}");
        }
    }
}
