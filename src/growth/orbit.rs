//! Rotation about an element, along the surface at contact distance (Sumner 2001, 6.4).
//!
//! The curve is the sphere of radius 2r about the element's centre, cut by the surface: a circular
//! arc in each triangle. It is followed exactly, arc by arc, until it meets the sphere of another
//! element of the same sheet.

use std::f64::consts::TAU;
use std::hint::select_unpredictable;

use glam::{DVec2, DVec3};

use super::Surroundings;
use super::launch::circle_crossings;
use super::nearby::{Found, Nearby};
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

/// Before the turn to anything, and older than any element.
const BEFORE_ALL: (f64, u32) = (-1.0, 0);

/// The longest arc that is asked whether it passes where it is nearest to a place: for half a turn and more it is
/// another question.
const LONGEST_ASKED: f64 = 3.0;

/// A rotation about one element.
pub(super) struct Orbit<'a, I> {
    around: &'a Surroundings<'a, I>,
    /// The element's triangle and centre.
    about: u32,
    centre: DVec3,
    reach: f64,
    /// The other elements that the rotation can meet.
    others: Vec<Found>,
}

/// A second contact, and how far along the curve it was.
struct SecondContact {
    at: SurfacePoint,
    length: f64,
}

/// A place on the curve, seen in one triangle's plane.
#[derive(Clone, Copy)]
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
    /// The place, from the circle's centre.
    point: DVec2,
}

/// Where another element's sphere cuts the curve's circle: beside the middle of a chord, by half of it on either side,
/// from the circle's centre.
#[derive(Clone, Copy, Debug)]
struct Chord {
    id: u32,
    middle: DVec2,
    half: DVec2,
}

impl<'a, I: ElementIndex> Orbit<'a, I> {
    pub(super) fn new(around: &'a Surroundings<'a, I>, nearby: &Nearby, about: u32) -> Self {
        let element = around.element(about);
        let (triangle, centre) = (element.at.triangle, element.position);
        let reach = around.contact_distance();
        let mut others = Vec::with_capacity(USUALLY_NEAR);
        around.within_found(nearby, (centre, 2.0 * reach), |found| {
            if found.id() != about {
                others.push(found);
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
        let begin = self.begin(from)?;
        let [mut chords, mut further] = [Vec::new(), Vec::new()];
        self.find_chords(&begin, None, &mut chords);
        let back = Here {
            sense: -1.0,
            ..begin
        };
        let ways = [begin, back].map(|begin| self.rotate(scratch, begin, (&chords, &mut further)));
        let nearer = |a: SecondContact, b: SecondContact| if b.length < a.length { b } else { a };
        let [a, b] = ways;
        a.into_iter().chain(b).reduce(nearer).map(|met| met.at)
    }

    /// Rotates from a place in whose plane the first list is of the others' chords; the second is room for those in
    /// other planes.
    fn rotate(
        &self,
        scratch: &mut Connectivity,
        begin: Here,
        (chords, further): (&[Chord], &mut Vec<Chord>),
    ) -> Option<SecondContact> {
        let mut here = begin;
        let mut length = 0.0;
        for arcs in 0..MOST_ARCS {
            let exit = here.exit();
            let end = exit.as_ref().map_or(TAU, |e| e.angle);
            let chords = match arcs {
                0 => chords,
                _ => {
                    self.find_chords(&here, exit.as_ref(), further);
                    &*further
                }
            };
            if let Some((angle, at)) = self.first_met(scratch, &here, end, chords) {
                let met = SecondContact {
                    at,
                    length: length + angle * here.radius,
                };
                return self.stays_with(scratch, &met.at).then_some(met);
            }
            let exit = exit?;
            if arcs > 0 && here.triangle == begin.triangle && here.passes(begin.point, exit.angle) {
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

    /// The place from which to rotate, counter-clockwise.
    fn begin(&self, from: &SurfacePoint) -> Option<Here> {
        let plane = TrianglePlane::new(self.around.substrate, from.triangle);
        let point = plane.project(self.around.substrate.position(from)).0;
        self.circle(&plane).map(|(centre, radius)| Here {
            triangle: from.triangle,
            plane,
            centre,
            radius,
            point,
            sense: 1.0,
        })
    }

    /// The circle that the sphere about the element cuts from a plane.
    fn circle(&self, plane: &TrianglePlane) -> Option<(DVec2, f64)> {
        let (centre, radius_sq) = self.cut(plane, self.centre);
        (radius_sq > 0.0).then(|| (centre, radius_sq.sqrt()))
    }

    /// The circle that the sphere about an element cuts from a plane: its centre, and its radius squared, which is not
    /// positive where it cuts none.
    fn cut(&self, plane: &TrianglePlane, element: DVec3) -> (DVec2, f64) {
        let (foot, height_sq) = plane.project(element);
        (foot, self.reach * self.reach - height_sq)
    }

    /// The chords of the others' spheres, but for those that the curve does not come into before an exit.
    fn find_chords(&self, here: &Here, exit: Option<&Exit>, chords: &mut Vec<Chord>) {
        chords.clear();
        chords.reserve(USUALLY_NEAR);
        chords.extend(self.others.iter().filter_map(|other| {
            let (centre, radius_sq) = self.cut(&here.plane, other.place);
            let circle = (centre - here.centre, radius_sq);
            let meets = exit.is_none_or(|exit| here.may_meet(circle, exit));
            meets.then(|| here.chord(other.id(), circle)).flatten()
        }));
    }

    /// The first element of the same sheet that the curve meets before an angle.
    fn first_met(
        &self,
        scratch: &mut Connectivity,
        here: &Here,
        end: f64,
        chords: &[Chord],
    ) -> Option<(f64, SurfacePoint)> {
        // The first mostly is the one: to put all in order would be to do so for nothing.
        let mut first = here.first_of(chords, BEFORE_ALL);
        while let Some((turn, chord)) = first {
            let entry = here.entry(chord);
            let angle = here.angle_to(entry);
            if angle > end {
                return None;
            }
            let p = match angle > 0.0 {
                true => here.centre + entry,
                false => here.point,
            };
            let there = self.around.element(chord.id);
            let there = (there.at.triangle, there.position);
            let place = (here.triangle, here.plane.lift(p));
            if self.around.same_sheet(scratch, place, there) {
                return Some((angle, here.plane.surface_point(p)));
            }
            first = here.first_of(chords, (turn, chord.id));
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

impl Here {
    /// How far the curve turns from here to a point of the circle, given from its centre, in [0, 2π).
    fn angle_to(&self, p: DVec2) -> f64 {
        let (sin, cos) = self.turned(p);
        let angle = libm::atan2(sin, cos);
        match if angle < 0.0 { angle + TAU } else { angle } {
            a if a > TAU - ROUND_OFF => 0.0,
            a => a,
        }
    }

    /// A number that grows with that angle, in [0, 4), and takes less time.
    #[inline(always)]
    fn turn_to(&self, p: DVec2) -> f64 {
        let (sin, cos) = self.turned(p);
        if cos > 0.0 && sin < 0.0 && -sin < ROUND_OFF * cos {
            return 0.0;
        }
        let share = cos / (sin.abs() + cos.abs());
        select_unpredictable(sin >= 0.0, 1.0 - share, 3.0 + share)
    }

    /// Sine and cosine of that angle, times the circle's radius squared.
    #[inline(always)]
    fn turned(&self, p: DVec2) -> (f64, f64) {
        let from = self.point - self.centre;
        (self.sense * from.perp_dot(p), from.dot(p))
    }

    /// Direction of travel at a point of the circle, given from its centre; of the circle's radius in length.
    fn velocity(&self, p: DVec2) -> DVec2 {
        p.perp() * self.sense
    }

    /// Where the curve first goes out through an edge.
    fn exit(&self) -> Option<Exit> {
        let corners = self.plane.corners();
        let mut first: Option<Exit> = None;
        for edge in 0..3 {
            let a = corners[edge] - self.centre;
            let e = corners[(edge + 1) % 3] - corners[edge];
            for share in circle_crossings(a, e, self.radius * self.radius) {
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
                        point: p,
                    });
                }
            }
        }
        first
    }

    /// Whether the curve may come into another circle before its exit from the triangle. That circle is given by its
    /// centre, as seen from this one's, and its radius squared.
    ///
    /// It does not if the exit is outside of it and the curve does not pass where it is nearest to its centre. Of long
    /// arcs that is not asked.
    fn may_meet(&self, (centre, radius_sq): (DVec2, f64), exit: &Exit) -> bool {
        let begin = self.point - self.centre;
        let is_onward = |from: DVec2, to: DVec2| self.sense * from.perp_dot(to) > 0.0;
        let ends_inside = exit.point.distance_squared(centre) <= radius_sq;
        let misses_nearest = is_onward(exit.point, centre) || is_onward(centre, begin);
        ends_inside || !misses_nearest || exit.angle > LONGEST_ASKED
    }

    /// Where another circle, given in the same way, cuts this one, if it does.
    #[inline(always)]
    fn chord(&self, id: u32, (centre, radius_sq): (DVec2, f64)) -> Option<Chord> {
        let inverse = 1.0 / centre.length_squared();
        let own_sq = self.radius * self.radius;
        let along = 0.5 + 0.5 * (own_sq - radius_sq) * inverse;
        let across_sq = own_sq * inverse - along * along;
        (across_sq > 0.0).then(|| Chord {
            id,
            middle: centre * along,
            half: centre.perp() * across_sq.sqrt(),
        })
    }

    /// The end of a chord at which the curve comes in, from the circle's centre.
    ///
    /// Of its two ends p that is the one where the curve's direction v goes into the other circle, with the centre c:
    /// v·(p − c) is sense · |half| · |c| on the left of the way to c, and minus that on the right.
    #[inline(always)]
    fn entry(&self, chord: &Chord) -> DVec2 {
        chord.middle - chord.half * self.sense
    }

    /// Of some chords the one that the curve comes to first, of those after a turn and an element; of several in one
    /// place the oldest element's.
    fn first_of<'c>(&self, chords: &'c [Chord], after: (f64, u32)) -> Option<(f64, &'c Chord)> {
        let before = |a: (f64, u32), b: (f64, u32)| a.0 < b.0 || (a.0 == b.0 && a.1 < b.1);
        let mut first = None;
        let mut least = (f64::INFINITY, u32::MAX);
        for chord in chords {
            let turn = (self.turn_to(self.entry(chord)), chord.id);
            if before(turn, least) && before(after, turn) {
                (first, least) = (Some(chord), turn);
            }
        }
        first.map(|chord| (least.0, chord))
    }

    /// Whether the curve passes a point of the circle within an angle.
    fn passes(&self, p: DVec2, angle: f64) -> bool {
        self.angle_to(p - self.centre) <= angle
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::rng::{Purpose, Stream};
    use crate::substrate::Substrate;

    /// On circles of radius 1 about the origin of a triangle's chart, begun anywhere, both ways: so many, numbered.
    fn at_random_places(index: u64, times: usize, mut test: impl FnMut(usize, Here, &mut Stream)) {
        let substrate = Substrate::load(Path::new("meshes/plane.obj")).expect("a mesh");
        let mut stream = Stream::new(index, Purpose::Walker, 0);
        for i in 0..times {
            let here = Here {
                triangle: 0,
                plane: TrianglePlane::new(&substrate, 0),
                centre: DVec2::ZERO,
                radius: 1.0,
                point: stream.in_unit_disc().normalize(),
                sense: if stream.uniform() < 0.5 { 1.0 } else { -1.0 },
            };
            test(i, here, &mut stream);
        }
    }

    #[test]
    fn meetings_are_where_the_curve_comes_in() {
        let mut met = 0;
        at_random_places(10, 4000, |_, here, stream| {
            let (centre, radius) = (3.0 * stream.in_unit_disc(), 0.2 + stream.uniform());
            let cross = (1.0 - radius).abs() < centre.length() && centre.length() < 1.0 + radius;
            for none in [0.0, -radius] {
                assert!(here.chord(0, (centre, none)).is_none());
            }
            assert!(here.chord(0, (DVec2::ZERO, radius * radius)).is_none());
            let meeting = here.chord(0, (centre, radius * radius));
            let meeting = meeting.map(|chord| here.entry(&chord));
            assert_eq!(meeting.is_some(), cross, "{centre:?}, {radius}");
            let Some(p) = meeting else { return };
            assert!((p.length() - 1.0).abs() < 1e-9 && (p.distance(centre) - radius).abs() < 1e-9);
            assert!(here.velocity(p).dot(p - centre) < 0.0, "{p:?}");
            met += 1;
        });
        assert!(met > 1000, "{met}");
    }

    #[test]
    fn none_is_passed_over_that_the_curve_meets_before_its_exit() {
        let (mut met, mut passed_over, mut kept) = (0, 0, 0);
        at_random_places(11, 20_000, |i, here, stream| {
            // Short arcs too, as in small triangles.
            let angle = TAU * stream.uniform() * [1.0, 0.3, 0.03][i % 3];
            let exit = Exit {
                angle,
                edge: 0,
                share: 0.0,
                point: DVec2::from_angle(here.sense * angle).rotate(here.point),
            };
            let other = (3.0 * stream.in_unit_disc(), 0.2 + stream.uniform());
            let chord = here.chord(0, other);
            let meets = chord.is_some_and(|c| here.angle_to(here.entry(&c)) <= angle);
            match (meets, here.may_meet(other, &exit)) {
                (true, passes) => {
                    assert!(passes, "{other:?}, {angle}");
                    met += 1;
                }
                (false, false) => passed_over += 1,
                (false, true) => kept += 1,
            }
        });
        assert!(
            met > 1000 && passed_over > 2 * kept,
            "{met}, {passed_over}, {kept}"
        );
    }

    #[test]
    fn chords_come_in_the_order_of_their_turns_and_of_age() {
        at_random_places(12, 500, |_, here, stream| {
            let mut chords: Vec<Chord> = (0..9)
                .filter_map(|id| here.chord(id, (2.0 * stream.in_unit_disc(), stream.uniform())))
                .collect();
            // Others in the same places, and younger.
            chords.extend(chords.clone().iter().map(|c| Chord {
                id: c.id + 20,
                ..*c
            }));
            let turn = |c: &Chord| (here.turn_to(here.entry(c)), c.id);
            let mut expected: Vec<(f64, u32)> = chords.iter().map(turn).collect();
            expected.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
            let next = |after: &(f64, u32)| {
                let (turn, chord) = here.first_of(&chords, *after)?;
                Some((turn, chord.id))
            };
            let found: Vec<(f64, u32)> = std::iter::successors(next(&BEFORE_ALL), next).collect();
            assert_eq!(found, expected);
        });
    }

    #[test]
    fn turns_are_in_the_order_of_angles() {
        at_random_places(9, 4000, |_, here, stream| {
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
        });
    }
}
