//! A straight step over the surface by unfolding (Sumner 2001, 6.1).
//!
//! Everything happens in one plane, with the walker at the origin and its path along the x axis.
//! The triangle beyond an edge is laid flat beside it from two numbers, its apex in terms of that
//! edge, so the loop has no division, no square root and no 3-D position. All lengths in this plane are
//! scaled by the step's length, so that aligning the start triangle needs no square root either.
//!
//! A boundary edge is its own twin (see the substrate's adjacency): the triangle beyond it is the
//! mirror image of this one, and going on straight into that is reflection.
//!
//! A path aimed exactly at a vertex passes it on the left. A straight path has no unique
//! continuation there (Polthier & Schmies 1998); for walkers this happens with probability zero.

use std::hint::select_unpredictable;

use glam::DVec2;
use wide::f64x2;

use crate::ahead::fetch;
use crate::substrate::{Crossing, HalfEdge, Substrate, SurfacePoint, Twin};

/// Why a trace ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum End {
    /// It covered the whole distance.
    Distance,
    /// It met a boundary edge that absorbs.
    Boundary,
    /// It crossed [`MOST_CROSSINGS`] edges: the distance is absurd beside the triangles, or the
    /// path is wound up on a needle's tip. The point is where it got to.
    Crossings,
}

/// Edges that one trace may cross.
pub const MOST_CROSSINGS: u32 = 1 << 20;

/// Where a straight path ended.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Trace {
    /// The last point.
    pub point: SurfacePoint,
    /// Why there.
    pub end: End,
    /// Edges crossed.
    pub crossings: u32,
}

/// Watches a trace from edge to edge.
pub trait Visitor {
    /// Whether a path ends at boundary edges, instead of being reflected.
    const ABSORB: bool;

    /// The path leaves a triangle through one of its half-edges, at `share` of the half-edge's
    /// length from its start, having come `distance_share` of the whole way.
    fn leave(&mut self, half_edge: HalfEdge, share: f64, distance_share: f64);

    /// The path has covered its distance; `onward` is the whole step, as a vector in the frame of
    /// the triangle where it ended. Going back is a step by `-onward`.
    fn arrive(&mut self, _onward: DVec2) {}

    /// Whether `leave` and `arrive` are to be called.
    const WATCHES: bool;
}

/// Reflects at boundaries, watches nothing.
pub(super) struct Reflecting;

impl Visitor for Reflecting {
    const ABSORB: bool = false;
    const WATCHES: bool = false;
    fn leave(&mut self, _: HalfEdge, _: f64, _: f64) {}
}

/// Ends at boundaries, watches nothing.
pub(super) struct Absorbing;

impl Visitor for Absorbing {
    const ABSORB: bool = true;
    const WATCHES: bool = false;
    fn leave(&mut self, _: HalfEdge, _: f64, _: f64) {}
}

/// Follows a straight path from a point by `step`, a vector in the frame of the point's
/// triangle (local units; see [`Chart::corners`](crate::substrate::Chart::corners)).
///
/// With `absorb` it ends at the first open edge, as [`End::Boundary`]; without, open edges reflect it.
/// The step must be finite, the point on the substrate: a step that is not gives a meaningless [`Trace`], perhaps only
/// after [`MOST_CROSSINGS`] crossings.
///
/// # Panics
/// When the substrate does not have the point's triangle; perhaps when the step is not finite.
pub fn trace(substrate: &Substrate, from: &SurfacePoint, step: DVec2, absorb: bool) -> Trace {
    if absorb {
        trace_visiting(substrate, from, step, &mut Absorbing)
    } else {
        trace_visiting(substrate, from, step, &mut Reflecting)
    }
}

/// Walks straight from a point as [`trace`] does, with a visitor that sees each crossing.
pub fn trace_visiting<V: Visitor>(
    substrate: &Substrate,
    from: &SurfacePoint,
    step: DVec2,
    visitor: &mut V,
) -> Trace {
    let corners = substrate.charts()[from.triangle as usize].corners();
    let [w0, w1, w2] = from.weights();
    let at = corners[0] * w0 + corners[1] * w1 + corners[2] * w2;
    let corners = corners.map(|c| c - at);
    if contains(&corners, step) || step == DVec2::ZERO {
        if V::WATCHES {
            visitor.arrive(step);
        }
        return Trace {
            point: weigh(from.triangle, areas(&corners, step)),
            end: End::Distance,
            crossings: 0,
        };
    }
    trace_out(substrate, from.triangle, corners, step, visitor)
}

/// As [`trace_visiting`], for a step that is not zero and leaves the triangle, but for round-off: from
/// the origin of a frame in which the triangle's corners are given, its chart's, shifted.
#[inline(always)]
pub(super) fn trace_out<V: Visitor>(
    substrate: &Substrate,
    triangle: u32,
    corners: [DVec2; 3],
    step: DVec2,
    visitor: &mut V,
) -> Trace {
    let ended = |point, end, crossings| Trace {
        point,
        end,
        crossings,
    };
    let corners = corners.map(|c| DVec2::new(step.dot(c), step.perp_dot(c)));
    let end = step.length_squared();
    let mut front = Front::leaving(substrate, triangle, &corners);
    if !front.is_passed(end) {
        let weights = areas(&corners, DVec2::new(end, 0.0));
        if is_near(&corners, end, weights) {
            if V::WATCHES {
                visitor.arrive(step);
            }
            return ended(weigh(triangle, weights), End::Distance, 0);
        }
    }
    for crossings in 1..MOST_CROSSINGS + 1 {
        if V::WATCHES {
            let half_edge = front.half_edge(substrate);
            let (share, distance_share) = front.meeting(end);
            visitor.leave(half_edge, share, distance_share);
        }
        if V::ABSORB && front.is_boundary(substrate) {
            return ended(
                front.point_on_edge(substrate, end),
                End::Boundary,
                crossings - 1,
            );
        }
        let unfolded = front.cross(substrate.crossings());
        front = unfolded.next_front();
        if front.is_passed(end) {
            continue;
        }
        let corners = unfolded.corners_from_entry();
        let weights = areas(&corners, DVec2::new(end, 0.0));
        if is_near(&corners, end, weights) {
            if V::WATCHES {
                visitor.arrive(unfolded.in_chart(substrate) * step.length());
            }
            let weights = unfolded.in_own_order(weights);
            return ended(weigh(unfolded.entry / 3, weights), End::Distance, crossings);
        }
    }
    ended(
        front.point_on_edge(substrate, end),
        End::Crossings,
        MOST_CROSSINGS,
    )
}

/// True when a point is in a counter-clockwise triangle, its edges included.
pub(super) fn contains([a, b, c]: &[DVec2; 3], p: DVec2) -> bool {
    (*b - *a).perp_dot(p - *a) >= 0.0
        && (*c - *b).perp_dot(p - *b) >= 0.0
        && (*a - *c).perp_dot(p - *c) >= 0.0
}

/// Doubled areas of the triangles that a point makes with the edges across from each corner: the
/// point's weights, not normalised, all of one sign inside. A mirrored triangle's are negative.
fn areas([a, b, c]: &[DVec2; 3], p: DVec2) -> [f64; 3] {
    let (a, b, c) = (*a - p, *b - p, *c - p);
    [b.perp_dot(c), c.perp_dot(a), a.perp_dot(b)]
}

/// Whether the path's end, with these areas, is in the triangle, or outside by no more than round-off.
///
/// That is asked at the end of a path because one along an edge is only by round-off on this or
/// that side of it, and then seems to end at any edge that it runs along.
fn is_near([a, b, c]: &[DVec2; 3], end: f64, areas: [f64; 3]) -> bool {
    /// Of a place in the plane, beside the path's length; far above what builds up.
    const ROUND_OFF: f64 = 1e-11;
    let least = smaller(smaller(areas[0], areas[1]), areas[2]);
    let most = -smaller(smaller(-areas[0], -areas[1]), -areas[2]);
    if least * most >= 0.0 {
        return true;
    }
    let out = least.abs().min(most.abs());
    let edges_sq = (*b - *a).length_squared() + (*c - *a).length_squared();
    let error_sq = (end * end + edges_sq) * edges_sq * (ROUND_OFF * ROUND_OFF);
    out * out <= error_sq
}

/// The smaller of two numbers, in one instruction: nobody asks for what comes of none.
#[inline(always)]
fn smaller(a: f64, b: f64) -> f64 {
    if a < b { a } else { b }
}

/// The surface point with these areas.
fn weigh(triangle: u32, areas: [f64; 3]) -> SurfacePoint {
    let sum: f64 = areas.iter().sum();
    SurfacePoint::from_weights(triangle, areas.map(|w| w * 1f64.copysign(sum)))
}

/// An edge that the path is about to cross: `left` and `right` of it as the path looks.
struct Front {
    left: DVec2,
    right: DVec2,
    /// The half-edge through which the path comes into what lies beyond.
    entry: Twin,
    /// The triangle being left lies as its mirror image.
    mirrored: bool,
    /// What lies beyond.
    beyond: Crossing,
}

impl Front {
    /// The edge through which the path leaves a counter-clockwise triangle about its start.
    #[inline(always)]
    fn leaving(substrate: &Substrate, triangle: u32, corners: &[DVec2; 3]) -> Self {
        let side = corners.map(|c| c.y);
        let is_left = |k: usize| usize::from(side[k] > 0.0) << k;
        let k = match EXITS[is_left(0) | is_left(1) | is_left(2)] {
            3 => grazing(side),
            k => k,
        };
        // From the crossing that comes before it, which lies where the path has just been.
        let before = 3 * triangle as usize + (k + 2) % 3;
        let entry = substrate.crossings()[before].exits[0];
        Self {
            left: corners[(k + 1) % 3],
            right: corners[k],
            entry,
            mirrored: false,
            beyond: substrate.crossings()[entry.half_edge() as usize],
        }
    }

    /// Whether the path ends beyond the edge.
    #[inline(always)]
    fn is_passed(&self, end: f64) -> bool {
        (self.left - self.right).perp_dot(DVec2::new(end, 0.0) - self.right) < 0.0
    }

    /// The half-edge on the near side.
    fn half_edge(&self, substrate: &Substrate) -> HalfEdge {
        substrate.twin(self.entry.half_edge()).half_edge()
    }

    fn is_boundary(&self, substrate: &Substrate) -> bool {
        self.half_edge(substrate) == self.entry.half_edge()
    }

    /// Lays the triangle beyond the edge flat.
    ///
    /// What lies beyond both its other edges is fetched now, while it is worked out which one the
    /// path takes, and what lies beyond the next four: on a fine mesh that takes longer than all the
    /// arithmetic.
    #[inline(always)]
    fn cross(self, crossings: &[Crossing]) -> Unfolded {
        let mirrored = self.mirrored ^ self.entry.is_flipped();
        let entry = self.entry.half_edge();
        let crossing = self.beyond;
        let e = self.right - self.left;
        // A mirrored triangle's half-edge runs from right to left.
        let along = if mirrored {
            1.0 - crossing.along
        } else {
            crossing.along
        };
        let beyond = |exit: Twin| crossings[exit.half_edge() as usize];
        let [a, b] = [beyond(crossing.exits[0]), beyond(crossing.exits[1])];
        for exit in [a.exits, b.exits].as_flattened() {
            fetch(crossings.get(exit.half_edge() as usize));
        }
        Unfolded {
            left: self.left,
            right: self.right,
            apex: self.left + e * along + e.perp() * crossing.height,
            entry,
            exits: crossing.exits,
            beyond: [a, b],
            mirrored,
        }
    }

    /// Where the path meets the edge: share of the half-edge from its start, share of the step.
    fn meeting(&self, end: f64) -> (f64, f64) {
        let (r, l) = (self.right.y, self.left.y);
        let from_right = if l > r {
            (-r / (l - r)).clamp(0.0, 1.0)
        } else {
            0.5
        };
        let edge = self.left - self.right;
        let crossed = self.right + edge * from_right;
        // Along an edge round-off says where the two meet: anywhere on the path is as true.
        let ahead = crossed.x / end;
        let from_right = if (0.0..=1.0).contains(&ahead) {
            from_right
        } else {
            let nearest = DVec2::new(crossed.x.clamp(0.0, end), 0.0);
            ((nearest - self.right).dot(edge) / edge.length_squared()).clamp(0.0, 1.0)
        };
        let point = self.right + edge * from_right;
        let share = if self.mirrored {
            1.0 - from_right
        } else {
            from_right
        };
        (share, (point.x / end).clamp(0.0, 1.0))
    }

    fn point_on_edge(&self, substrate: &Substrate, end: f64) -> SurfacePoint {
        let (share, _) = self.meeting(end);
        let half_edge = self.half_edge(substrate);
        let k = half_edge as usize % 3;
        let mut weights = [0.0; 3];
        weights[k] = 1.0 - share;
        weights[(k + 1) % 3] = share;
        SurfacePoint::from_weights(half_edge / 3, weights)
    }
}

/// One of two, by a mask.
#[inline(always)]
fn either(first: f64x2, a: DVec2, b: DVec2) -> DVec2 {
    let [a, b] = [a, b].map(|v| f64x2::new(v.to_array()));
    first.bitselect(a, b).to_array().into()
}

/// The edge from a corner on the right of the path to one on its left, by the bits of the corners on
/// the left; 3 where all are on one side.
const EXITS: [usize; 8] = [3, 2, 0, 2, 1, 1, 0, 3];

/// The edge to leave by when a triangle lies on one side of the path: the path starts on its rim,
/// exactly or but for round-off. It turns about the corner nearest to the path, the near way.
fn grazing(side: [f64; 3]) -> usize {
    let nearer = |&a: &usize, &b: &usize| side[a].abs().total_cmp(&side[b].abs());
    let corner = (0..3).min_by(nearer).unwrap_or(0);
    if side[corner] > 0.0 {
        corner
    } else {
        (corner + 2) % 3
    }
}

/// A triangle laid flat beyond the edge that the path came through.
struct Unfolded {
    left: DVec2,
    right: DVec2,
    apex: DVec2,
    /// The half-edge that the path came through, and what lies across the two after it.
    entry: HalfEdge,
    exits: [Twin; 2],
    beyond: [Crossing; 2],
    mirrored: bool,
}

impl Unfolded {
    /// The edge that the path leaves by. It is as often the one as the other, which no processor
    /// foresees: so both are worked out, and one is taken without a branch. What decides stays in the
    /// registers of the corners, for these are what the next edge waits for.
    #[inline(always)]
    fn next_front(&self) -> Front {
        let is_left = f64x2::splat(self.apex.y).simd_gt(f64x2::ZERO);
        // In its own winding the triangle runs entry, then the edge at the entry's end. That end
        // is on the right, or on the left where the triangle lies mirrored.
        let is_second = if self.mirrored { is_left } else { !is_left };
        let second = (self.apex.y > 0.0) == self.mirrored;
        let [a, b] = &self.beyond;
        let exit = |i: usize| select_unpredictable(second, b.exits[i], a.exits[i]);
        let apart = |c: &Crossing| DVec2::new(c.along, c.height);
        let beyond = either(is_second, apart(b), apart(a));
        Front {
            left: either(is_left, self.apex, self.left),
            right: either(is_left, self.right, self.apex),
            entry: select_unpredictable(second, self.exits[1], self.exits[0]),
            mirrored: self.mirrored,
            beyond: Crossing {
                along: beyond.x,
                height: beyond.y,
                exits: [exit(0), exit(1)],
            },
        }
    }

    /// The corners in the triangle's winding, from the start of the entry on.
    #[inline(always)]
    fn corners_from_entry(&self) -> [DVec2; 3] {
        if self.mirrored {
            [self.right, self.left, self.apex]
        } else {
            [self.left, self.right, self.apex]
        }
    }

    /// What each of these corners has, in the triangle's own order. Which one is its first is not to be
    /// foreseen: numbers are chosen without a branch, and not by way of memory, where a number that has just
    /// been written is waited for.
    #[inline(always)]
    fn in_own_order(&self, [start, end, apex]: [f64; 3]) -> [f64; 3] {
        let k = self.entry % 3;
        let of_three = |numbers: [f64; 3]| {
            let [first, second, third] = numbers.map(f64::to_bits);
            let later = select_unpredictable(k == 1, second, third);
            f64::from_bits(select_unpredictable(k == 0, first, later))
        };
        [
            of_three([start, apex, end]),
            of_three([end, start, apex]),
            of_three([apex, end, start]),
        ]
    }

    /// The path's direction in the frame of this triangle's chart.
    fn in_chart(&self, substrate: &Substrate) -> DVec2 {
        let upright = |v: DVec2| {
            if self.mirrored {
                v.reflect(DVec2::Y)
            } else {
                v
            }
        };
        let chart = &substrate.charts()[self.entry as usize / 3];
        let (flat, mut own) = (self.corners_from_entry(), chart.corners());
        own.rotate_left(self.entry as usize % 3);
        // The rotation that best takes the edges as they lie to those of the chart, as a complex
        // number: a needle's short edge alone would not tell it well.
        let turn = (0..3).fold(DVec2::ZERO, |sum, k| {
            let lying = upright(flat[(k + 1) % 3] - flat[k]);
            let edge = own[(k + 1) % 3] - own[k];
            sum + edge.rotate(DVec2::new(lying.x, -lying.y))
        });
        turn.normalize_or(DVec2::X)
    }
}
