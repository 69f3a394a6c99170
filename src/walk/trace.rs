//! A straight step over the surface by unfolding (Sumner 2001, 6.1).
//!
//! Everything happens in one plane, with the path along the x axis. An edge is known by the way across it, from its
//! end on the left of the path to the one on the right, and by the way from the one on the left to the path's end.
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
use crate::substrate::{Chart, Crossing, HalfEdge, Substrate, SurfacePoint, Twin, Unscaled};

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
    let chart = &substrate.facet(from.triangle).chart;
    let at = chart.place(from.weights());
    let there = at + step;
    let reached = if chart.contains(there) || step == DVec2::ZERO {
        if V::WATCHES {
            visitor.arrive(step);
        }
        Reached::inside(chart, from.triangle, there)
    } else {
        trace_out(substrate, (from.triangle, chart, at), step, visitor)
    };
    Trace {
        point: reached.place.surface_point(substrate),
        end: reached.end,
        crossings: reached.crossings,
    }
}

/// A place in a triangle, in terms of one of its half-edges: at start + along·e + height·e⊥, as the triangle's
/// apex is in a [`Crossing`].
#[derive(Clone, Copy)]
pub(super) struct Beside {
    pub(super) half_edge: HalfEdge,
    along: f64,
    height: f64,
}

/// Where a trace ended.
pub(super) struct Reached {
    pub(super) place: Beside,
    pub(super) end: End,
    pub(super) crossings: u32,
}

impl Beside {
    /// On its triangle as it lies flat.
    #[inline(always)]
    pub(super) fn on(&self, triangle: &Unscaled) -> DVec2 {
        triangle.place(self.half_edge as usize % 3, (self.along, self.height))
    }

    fn surface_point(&self, substrate: &Substrate) -> SurfacePoint {
        let apex = &substrate.crossings()[self.half_edge as usize];
        let mut weights = weights((self.along, self.height), (apex.along, apex.height));
        weights.rotate_right(self.half_edge as usize % 3);
        SurfacePoint::from_weights(self.half_edge / 3, weights)
    }
}

/// Of the half-edge's start, its end, and the apex.
fn weights((along, height): (f64, f64), apex: (f64, f64)) -> [f64; 3] {
    let of_apex = height / apex.1;
    let of_end = along - of_apex * apex.0;
    [1.0 - of_end - of_apex, of_end, of_apex]
}

/// The place in the triangle for one that is outside by round-off. A next step may be so short that it would be far
/// outside for that.
#[cold]
#[inline(never)]
fn clamped(place: (f64, f64), apex: (f64, f64)) -> (f64, f64) {
    let [start, end, third] = weights(place, apex).map(|weight| weight.max(0.0));
    let sum = start + end + third;
    ((end + third * apex.0) / sum, third * apex.1 / sum)
}

impl Reached {
    /// A place in the triangle where the path began.
    fn inside(chart: &Chart, triangle: u32, at: DVec2) -> Self {
        let base = chart.corners()[1].x;
        Self {
            place: Beside {
                half_edge: 3 * triangle,
                along: at.x / base,
                height: at.y / base,
            },
            end: End::Distance,
            crossings: 0,
        }
    }
}

/// As [`trace_visiting`], for a step that is not zero and leaves the triangle, but for round-off, from a place in the
/// triangle's chart.
#[inline(always)]
pub(super) fn trace_out<V: Visitor>(
    substrate: &Substrate,
    (triangle, chart, at): (u32, &Chart, DVec2),
    step: DVec2,
    visitor: &mut V,
) -> Reached {
    let corners = along_path(chart, (at, step));
    let end = step.length_squared();
    let mut front = Front::leaving(substrate, triangle, &corners, end);
    for crossings in 0..MOST_CROSSINGS {
        if !front.is_passed() {
            let mut behind = front.behind(substrate.crossings());
            if behind.is_narrow() && behind.may_hold_end() {
                behind = behind.or_wider(substrate, (triangle, at, step), crossings);
            }
            if let Some(place) = behind.end(end) {
                if V::WATCHES {
                    visitor.arrive(behind.in_chart(substrate) * step.length());
                }
                return Reached {
                    place,
                    end: End::Distance,
                    crossings,
                };
            }
        }
        if V::WATCHES {
            let half_edge = front.half_edge();
            let (share, distance_share) = front.meeting(end);
            visitor.leave(half_edge, share, distance_share);
        }
        if V::ABSORB && front.is_boundary() {
            return front.ended(end, End::Boundary, crossings);
        }
        front = front.cross(substrate);
    }
    front.ended(end, End::Crossings, MOST_CROSSINGS)
}

/// The corners of the triangle in which a path begins, in the path's plane.
#[inline(always)]
fn along_path(chart: &Chart, (at, step): (DVec2, DVec2)) -> [DVec2; 3] {
    let turned = |c: DVec2| DVec2::new(step.dot(c - at), step.perp_dot(c - at));
    chart.corners().map(turned)
}

/// Whether the origin is in a triangle, or outside by no more than round-off.
///
/// That is asked of a path's end because one along an edge is only by round-off on this or
/// that side of it, and then seems to end at any edge that it runs along. Numbers come in registers: most ends
/// need not be asked for, and had rather not be written to memory.
#[cold]
#[inline(never)]
fn is_near(a: (f64, f64), b: (f64, f64), c: (f64, f64), length: f64) -> bool {
    /// Of a place in the plane, beside the path's length; far above what builds up.
    const ROUND_OFF: f64 = 1e-11;
    let [a, b, c] = [a, b, c].map(DVec2::from);
    let areas = [b.perp_dot(c), c.perp_dot(a), a.perp_dot(b)];
    // A mirrored triangle's are negative.
    let sign = 1f64.copysign(areas.iter().sum());
    let least = areas
        .iter()
        .fold(f64::INFINITY, |least, area| least.min(sign * area));
    let edges_sq = (b - a).length_squared() + (c - a).length_squared();
    let error_sq = (length * length + edges_sq) * edges_sq * (ROUND_OFF * ROUND_OFF);
    least >= 0.0 || least * least <= error_sq
}

/// An edge that the path is about to cross.
#[derive(Clone, Copy)]
struct Front {
    /// From the edge's end on the left of the path to the one on the right.
    across: DVec2,
    /// From the one on the left to the path's end.
    to_end: DVec2,
    /// The half-edge through which the path came into the triangle being left, whether the corner across from that is
    /// on the left of the path, and whether the triangle lies as its mirror image.
    came: Twin,
    apex_is_left: bool,
    mirrored: bool,
    /// The half-edge through which the path comes into what lies beyond.
    entry: Twin,
    /// What lies beyond: its third corner, and what lies across its other two edges.
    apex: DVec2,
    exits: Exits,
}

/// What lies across two edges, the one after the other, in one number: that is taken as a whole, and stays in a
/// register.
#[derive(Clone, Copy)]
struct Exits(u64);

impl Exits {
    #[inline(always)]
    fn of(crossing: &Crossing) -> Self {
        let [first, second] = crossing.exits.map(|twin| u64::from(twin.bits()));
        Self(first | second << 32)
    }

    #[inline(always)]
    fn both(self) -> [Twin; 2] {
        [self.0 as u32, (self.0 >> 32) as u32].map(Twin::from_bits)
    }

    #[inline(always)]
    fn swapped(self) -> Self {
        Self(self.0.rotate_left(32))
    }
}

impl Front {
    /// The edge through which the path leaves a counter-clockwise triangle about its start.
    #[inline(always)]
    fn leaving(substrate: &Substrate, triangle: u32, corners: &[DVec2; 3], end: f64) -> Self {
        let side = corners.map(|c| c.y);
        let bit = |k: usize| usize::from(side[k] > 0.0) << k;
        let (k, [left, right]) = match EXITS[bit(0) | bit(1) | bit(2)] {
            3 => {
                let k = grazing(side);
                (k, [corners[(k + 1) % 3], corners[k]])
            }
            k => (k, ends_of_exit(corners)),
        };
        // As if it had come through the edge before, which lies where the path has just been.
        let came = Twin::of(3 * triangle + BEFORE[k & 3]);
        let entry = substrate.crossings()[came.half_edge() as usize].exits[0];
        let beyond = &substrate.crossings()[entry.half_edge() as usize];
        substrate.fetch_vertex(beyond.apex);
        Self {
            across: right - left,
            to_end: DVec2::new(end, 0.0) - left,
            came,
            apex_is_left: true,
            mirrored: false,
            entry,
            apex: apex(beyond),
            exits: Exits::of(beyond),
        }
    }

    /// Whether the path ends beyond the edge.
    #[inline(always)]
    fn is_passed(&self) -> bool {
        self.across.perp_dot(self.to_end) > 0.0
    }

    /// The half-edge on the near side.
    #[inline(always)]
    fn half_edge(&self) -> HalfEdge {
        let came = self.came.half_edge();
        let (triangle, k) = (came / 3, came % 3);
        let leaves_by_first = self.apex_is_left != self.mirrored;
        3 * triangle + (k + 2 - u32::from(leaves_by_first)) % 3
    }

    fn is_boundary(&self) -> bool {
        self.half_edge() == self.entry.half_edge()
    }

    /// Goes on to the edge by which the path leaves what lies beyond, laid flat.
    ///
    /// It is as often the one as the other, which no processor foresees: so both are worked out, and one is taken
    /// without a branch. What decides stays in the registers of the corners, for these are what the next edge
    /// waits for.
    ///
    /// What lies beyond both is fetched now, while it is worked out which one the path takes, and what lies beyond
    /// the next four: on a fine mesh that takes longer than all the arithmetic. So is then the far corner in space, for
    /// the path may end there.
    #[inline(always)]
    fn cross(self, substrate: &Substrate) -> Self {
        let crossings = substrate.crossings();
        let mirrored = self.mirrored ^ self.entry.is_flipped();
        // In its own winding a triangle's entry begins on the left and ends on the right, where its first exit is. A
        // mirrored one has it the other way.
        let (along, exits) = match mirrored {
            false => (self.apex.x, self.exits),
            true => (1.0 - self.apex.x, self.exits.swapped()),
        };
        let [right, left] = exits.both();
        let [a, b] = [right, left].map(|exit| &crossings[exit.half_edge() as usize]);
        let (exits_a, exits_b) = (Exits::of(a), Exits::of(b));
        for exit in [exits_a.both(), exits_b.both()].as_flattened() {
            fetch(crossings.get(exit.half_edge() as usize));
        }
        let to_apex = combined(self.across, along, self.apex.y);
        let is_left = f64x2::splat(to_apex.y).simd_gt(f64x2::splat(self.to_end.y));
        let apex_is_left = is_left.to_bitmask() != 0;
        substrate.fetch_vertex(select_unpredictable(apex_is_left, a.apex, b.apex));
        Self {
            across: either(is_left, self.across - to_apex, to_apex),
            to_end: self.to_end - either(is_left, to_apex, DVec2::ZERO),
            came: self.entry,
            apex_is_left,
            mirrored,
            entry: select_unpredictable(apex_is_left, right, left),
            apex: either(is_left, apex(a), apex(b)),
            exits: Exits(select_unpredictable(apex_is_left, exits_a.0, exits_b.0)),
        }
    }

    /// The triangle on the near side.
    #[inline(always)]
    fn behind(&self, crossings: &[Crossing]) -> Behind {
        let half_edge = self.half_edge();
        Behind {
            across: self.across,
            to_end: self.to_end,
            half_edge,
            mirrored: self.mirrored,
            apex: crossings[half_edge as usize],
        }
    }

    /// The triangle beyond, as if the path had turned round.
    fn ahead(&self, crossings: &[Crossing]) -> Behind {
        let half_edge = self.entry.half_edge();
        Behind {
            across: -self.across,
            to_end: self.to_end - self.across,
            half_edge,
            mirrored: self.mirrored ^ self.entry.is_flipped(),
            apex: crossings[half_edge as usize],
        }
    }

    /// Where the path meets the edge: share of the half-edge from its start, share of the step.
    fn meeting(&self, end: f64) -> (f64, f64) {
        let left = DVec2::new(end, 0.0) - self.to_end;
        let right = left + self.across;
        let from_right = if left.y > right.y {
            (-right.y / (left.y - right.y)).clamp(0.0, 1.0)
        } else {
            0.5
        };
        let edge = -self.across;
        let crossed = right + edge * from_right;
        // Along an edge round-off says where the two meet: anywhere on the path is as true.
        let ahead = crossed.x / end;
        let from_right = if (0.0..=1.0).contains(&ahead) {
            from_right
        } else {
            let nearest = DVec2::new(crossed.x.clamp(0.0, end), 0.0);
            ((nearest - right).dot(edge) / edge.length_squared()).clamp(0.0, 1.0)
        };
        let point = right + edge * from_right;
        let share = if self.mirrored {
            1.0 - from_right
        } else {
            from_right
        };
        (share, (point.x / end).clamp(0.0, 1.0))
    }

    /// A path that goes no farther than this edge.
    fn ended(&self, length: f64, end: End, crossings: u32) -> Reached {
        let (along, _) = self.meeting(length);
        Reached {
            place: Beside {
                half_edge: self.half_edge(),
                along,
                height: 0.0,
            },
            end,
            crossings,
        }
    }
}

/// Along and height.
#[inline(always)]
fn apex(crossing: &Crossing) -> DVec2 {
    DVec2::new(crossing.along, crossing.height)
}

/// `v * along + v.perp() * height`, to the same bit, with a sign turned in both lanes at once where that takes them
/// apart.
#[inline(always)]
fn combined(v: DVec2, along: f64, height: f64) -> DVec2 {
    let [turned, v] = [[v.y, v.x], [v.x, v.y]].map(f64x2::new);
    let heights = f64x2::splat(height) ^ f64x2::new([-0.0, 0.0]);
    (v * f64x2::splat(along) + turned * heights)
        .to_array()
        .into()
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

/// The edge before each.
const BEFORE: [u32; 4] = [2, 0, 1, 0];

/// The ends, on the left and on the right of the path, of the edge by which it leaves a triangle that lies on both
/// sides. By masks: in memory, where they have just been written, corners would be waited for.
#[inline(always)]
fn ends_of_exit(&[a, b, c]: &[DVec2; 3]) -> [DVec2; 2] {
    let is_left = |c: DVec2| f64x2::splat(c.y).simd_gt(f64x2::ZERO);
    let [a_is_left, b_is_left, c_is_left] = [a, b, c].map(is_left);
    let is_exit = [
        !a_is_left & b_is_left,
        !b_is_left & c_is_left,
        !c_is_left & a_is_left,
    ];
    [[b, c, a], [a, b, c]].map(|ends| {
        let [one, other, third] = ends.map(|end| f64x2::new(end.to_array()));
        let end = is_exit[0] & one | is_exit[1] & other | is_exit[2] & third;
        end.to_array().into()
    })
}

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

/// How many times as long as an edge the way to the third corner may be for places to be told by that edge. A direction
/// is off by round-off over the edge's length, so a place by up to this times what it would be by the longest edge: far
/// less than [`is_near`] forgives.
const NARROW: f64 = 1000.0;

/// A triangle before an edge that the path would cross next, did it not end there.
struct Behind {
    /// As they are of a [`Front`].
    across: DVec2,
    to_end: DVec2,
    mirrored: bool,
    /// The edge as a half-edge of this triangle, and the triangle's third corner.
    half_edge: HalfEdge,
    apex: Crossing,
}

impl Behind {
    /// Whether the edge is so short beside the others that places far from it are not told well in its terms.
    #[inline(always)]
    fn is_narrow(&self) -> bool {
        let Crossing { along, height, .. } = self.apex;
        along * along + height * height > NARROW * NARROW
    }

    /// Whether the path's end seems to be about the triangle, as far as a narrow edge can tell. A path along many such
    /// edges is not to be followed anew at each.
    #[cold]
    #[inline(never)]
    fn may_hold_end(&self) -> bool {
        /// How far off weights may be, beside the square of how narrow the edge is; far above what they are.
        const ROUND_OFF: f64 = 1e-14;
        let Crossing { along, height, .. } = self.apex;
        let off = 1.0 + ROUND_OFF * (along * along + height * height);
        let weights = weights(self.end_beside(), (along, height));
        weights.into_iter().all(|weight| weight > -off)
    }

    /// The same in terms of the edge that the path came through, or of the longest where it began, if that is longer.
    /// The path is followed once more.
    #[cold]
    #[inline(never)]
    fn or_wider(self, substrate: &Substrate, path: (u32, DVec2, DVec2), crossings: u32) -> Self {
        let chart = substrate.facet(path.0).chart;
        let corners = along_path(&chart, (path.1, path.2));
        let end = path.2.length_squared();
        let others: Vec<Self> = match crossings.checked_sub(1) {
            None => (0..3)
                .map(|k| Self::of_start(substrate, (path.0, &corners), k, end))
                .collect(),
            Some(before) => {
                let first = Front::leaving(substrate, path.0, &corners, end);
                let front = (0..before).fold(first, |front, _| front.cross(substrate));
                vec![front.ahead(substrate.crossings())]
            }
        };
        let longer = |a: Self, b: Self| match b.across.length_squared() > a.across.length_squared()
        {
            true => b,
            false => a,
        };
        others.into_iter().fold(self, longer)
    }

    /// The triangle where a path begins, by one of its edges.
    fn of_start(
        substrate: &Substrate,
        (triangle, corners): (u32, &[DVec2; 3]),
        k: u32,
        end: f64,
    ) -> Self {
        let [from, to] = [k, (k + 1) % 3].map(|k| corners[k as usize]);
        let half_edge = 3 * triangle + k;
        Self {
            across: from - to,
            to_end: DVec2::new(end, 0.0) - to,
            half_edge,
            mirrored: false,
            apex: substrate.crossings()[half_edge as usize],
        }
    }

    /// The path's end, which is not beyond the edge, if it is in the triangle, or outside by round-off.
    #[inline(always)]
    fn end(&self, length: f64) -> Option<Beside> {
        let (along, height) = self.end_beside();
        let of_end = along * self.apex.height - height * self.apex.along;
        let of_others = self.apex.height - height;
        let at = |(along, height): (f64, f64)| Beside {
            half_edge: self.half_edge,
            along,
            height,
        };
        if height >= 0.0 && of_end >= 0.0 && of_end <= of_others {
            return Some(at((along, height)));
        }
        let [a, b, c] = self.corners().map(|c| (c - self.to_end).into());
        let apex = (self.apex.along, self.apex.height);
        is_near(a, b, c, length).then(|| at(clamped((along, height), apex)))
    }

    /// How far along the half-edge the path's end is, and how far beside it.
    #[inline(always)]
    fn end_beside(&self) -> (f64, f64) {
        let inverse = 1.0 / self.across.length_squared();
        let from_left = self.across.dot(self.to_end) * inverse;
        let along = match self.mirrored {
            false => 1.0 - from_left,
            true => from_left,
        };
        (along, -self.across.perp_dot(self.to_end) * inverse)
    }

    /// The corners in the triangle's winding, from the start of the half-edge on, as seen from the end on the left.
    fn corners(&self) -> [DVec2; 3] {
        let Crossing { along, height, .. } = self.apex;
        let apex = |from_left: f64| self.across * from_left - self.across.perp() * height;
        match self.mirrored {
            false => [self.across, DVec2::ZERO, apex(1.0 - along)],
            true => [DVec2::ZERO, self.across, apex(along)],
        }
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
        let chart = &substrate.facet(self.half_edge / 3).chart;
        let ([from, to, _], k) = (self.corners(), self.half_edge as usize % 3);
        let (lying, own) = (upright(to - from), chart.corners());
        let edge = own[(k + 1) % 3] - own[k];
        // What takes the edge as it lies to that of the chart, as a complex number.
        let turn = edge.rotate(DVec2::new(lying.x, -lying.y));
        turn.normalize_or(DVec2::X)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rng::{Purpose, Stream};

    #[test]
    fn masks_and_numbers_name_the_same_edge() {
        let mut stream = Stream::new(6, Purpose::Walker, 0);
        let mut seen = [0; 3];
        for _ in 0..3_000 {
            let corners = [0; 3].map(|_| stream.in_unit_disc());
            let bit = |k: usize| usize::from(corners[k].y > 0.0) << k;
            let k = EXITS[bit(0) | bit(1) | bit(2)];
            if k < 3 {
                let [left, right] = [corners[(k + 1) % 3], corners[k]];
                assert!(left.y > 0.0 && right.y <= 0.0);
                assert_eq!(ends_of_exit(&corners), [left, right]);
                assert_eq!(BEFORE[k] as usize, (k + 2) % 3);
                seen[k] += 1;
            }
        }
        assert!(seen.iter().all(|&seen| seen > 500), "{seen:?}");
    }
}
