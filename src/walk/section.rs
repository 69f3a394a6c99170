//! Along the surface straight towards a place: the cut of the surface by a plane.
//!
//! Mostly two places that belong together are joined by the line in which the plane through both
//! and their normals cuts the surface. It crosses a few triangles where a ball about them holds
//! thousands.

use glam::DVec3;

use crate::substrate::{HalfEdge, Substrate};

/// A triangle and a position on it.
pub type Place = (u32, DVec3);

/// A ball in space.
#[derive(Clone, Copy, Debug)]
pub struct Ball {
    /// Its centre, local units.
    pub centre: DVec3,
    /// Its radius, local units, above 0.
    pub radius: f64,
}

impl Ball {
    /// The ball in which the surface joins two elements of this radius in contact, or none does: on one sheet they are
    /// joined well inside of it.
    pub(crate) fn of_contact([one, other]: [DVec3; 2], radius: f64) -> Self {
        Self {
            centre: (one + other) * 0.5,
            radius: 1.5 * radius,
        }
    }
}

/// Lines longer than this go round in circles.
const MOST_CROSSED: usize = 4096;

/// What rounding may add to a squared distance.
const ROUNDED: f64 = 1e-9;

/// A line on the surface, at an edge that it crosses.
struct Section<'a> {
    substrate: &'a Substrate,
    /// The normal of the plane and a place in it.
    side: DVec3,
    start: DVec3,
    /// Where the line leaves a triangle.
    exit: HalfEdge,
    /// The ends of that edge and their heights over the plane.
    ends: [(DVec3, f64); 2],
}

/// Follows the surface from one place towards another until it comes to a triangle that is `there`.
///
/// Writes the triangles passed before that to `path`. False where the line ends at a border, leaves
/// the ball or goes astray: then nothing is said about the two places.
pub(super) fn leads(
    substrate: &Substrate,
    [from, to]: [Place; 2],
    ball: &Ball,
    there: impl Fn(u32) -> bool,
    path: &mut Vec<u32>,
) -> bool {
    path.clear();
    path.push(from.0);
    let Some(mut section) = Section::new(substrate, from, to) else {
        return false;
    };
    let limit = ball.radius * ball.radius * (1.0 - ROUNDED);
    while path.len() < MOST_CROSSED && section.crossed().distance_squared(ball.centre) <= limit {
        let Some(triangle) = section.cross() else {
            return false;
        };
        if there(triangle) {
            return true;
        }
        if triangle == from.0 {
            return false;
        }
        path.push(triangle);
    }
    false
}

impl<'a> Section<'a> {
    /// None where rounding has the line miss the triangle that it starts in.
    fn new(substrate: &'a Substrate, from: Place, to: Place) -> Option<Self> {
        let along = to.1 - from.1;
        let up = substrate.normal(from.0) + substrate.normal(to.0);
        let mut section = Self {
            substrate,
            side: along.cross(up),
            start: from.1,
            exit: 0,
            ends: [(DVec3::ZERO, 0.0); 2],
        };
        let corners = substrate.corners(from.0).map(|p| (p, section.height(p)));
        let ways = (0..3).map(|k| (k, [corners[k], corners[(k + 1) % 3]]));
        let crossed = ways.filter(|(_, ends)| is_crossed(ends));
        let ahead = |ends: &[(DVec3, f64); 2]| crossing(ends).dot(along);
        let (k, ends) = crossed.max_by(|a, b| ahead(&a.1).total_cmp(&ahead(&b.1)))?;
        (section.exit, section.ends) = (3 * from.0 + k as HalfEdge, ends);
        Some(section)
    }

    fn height(&self, p: DVec3) -> f64 {
        (p - self.start).dot(self.side)
    }

    /// The place on the edge.
    fn crossed(&self) -> DVec3 {
        crossing(&self.ends)
    }

    /// Goes on to the next edge, and says in which triangle; none beyond a border.
    fn cross(&mut self) -> Option<u32> {
        let twin = self.substrate.twin(self.exit);
        let entry = twin.half_edge();
        if entry == self.exit {
            return None;
        }
        let (triangle, k) = (entry / 3, entry % 3);
        let vertices = self.substrate.triangles()[triangle as usize];
        let apex = self.substrate.vertices()[vertices[(k as usize + 2) % 3] as usize];
        let apex = (apex, self.height(apex));
        let [a, b] = match twin.is_flipped() {
            true => self.ends,
            false => [self.ends[1], self.ends[0]],
        };
        let (ends, next) = match is_crossed(&[b, apex]) {
            true => ([b, apex], (k + 1) % 3),
            false => ([apex, a], (k + 2) % 3),
        };
        (self.ends, self.exit) = (ends, 3 * triangle + next);
        Some(triangle)
    }
}

/// Whether the ends of an edge are on either side.
fn is_crossed(ends: &[(DVec3, f64); 2]) -> bool {
    (ends[0].1 > 0.0) != (ends[1].1 > 0.0)
}

fn crossing([a, b]: &[(DVec3, f64); 2]) -> DVec3 {
    a.0.lerp(b.0, a.1 / (a.1 - b.1))
}
