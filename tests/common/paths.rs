//! Follows traced paths in space, edge by edge, and says how far they are from being geodesics.

use glam::{DVec2, DVec3};
use thallus::rng::Stream;
use thallus::substrate::{HalfEdge, Substrate};
use thallus::walk::{End, SurfacePoint, Trace, Visitor, trace_visiting};

use crate::shapes::direction;

/// All that a trace tells.
#[derive(Default)]
pub(crate) struct Path {
    pub(crate) crossings: Vec<(HalfEdge, f64, f64)>,
    pub(crate) onward: DVec2,
}

impl Visitor for Path {
    const ABSORB: bool = false;
    const WATCHES: bool = true;
    fn leave(&mut self, half_edge: HalfEdge, share: f64, distance_share: f64) {
        self.crossings.push((half_edge, share, distance_share));
    }
    fn arrive(&mut self, onward: DVec2) {
        self.onward = onward;
    }
}

/// The worst of some paths, lengths in local units.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Worst {
    /// Sum of the legs in space less the distance asked for, over that distance or 1 if it is less.
    pub(crate) length: f64,
    /// Change of direction against the edge that is crossed, times the shorter leg.
    pub(crate) bend: f64,
    /// A barycentric weight's way out of [0, 1].
    pub(crate) outside: f64,
    pub(crate) crossings: u64,
    /// Traces that gave up.
    pub(crate) gave_up: u64,
}

impl Worst {
    fn take(&mut self, other: Self) {
        self.length = self.length.max(other.length);
        self.bend = self.bend.max(other.bend);
        self.outside = self.outside.max(other.outside);
        self.crossings += other.crossings;
        self.gave_up += other.gave_up;
    }
}

/// Where a half-edge is crossed, and its unit vector.
fn on_edge(substrate: &Substrate, half_edge: HalfEdge, share: f64) -> (DVec3, DVec3) {
    let corners = substrate.corners(half_edge / 3);
    let k = half_edge as usize % 3;
    let (a, b) = (corners[k], corners[(k + 1) % 3]);
    (a.lerp(b, share), (b - a).normalize())
}

/// Follows one trace.
///
/// # Panics
/// When it goes from a triangle to one that is not its neighbour, or ends in another one.
pub(crate) fn follow(
    substrate: &Substrate,
    from: &SurfacePoint,
    step: DVec2,
    path: &Path,
    end: &Trace,
) -> Worst {
    let (mut here, mut triangle) = (substrate.position(from), from.triangle);
    let (mut sum, mut bend) = (0.0, 0.0f64);
    let mut last: Option<(DVec3, DVec3, f64)> = None;
    let mut leg = |to: DVec3, edge: DVec3| {
        let (vector, length) = (to - here, (to - here).length());
        if let Some((before, edge, before_length)) = last
            && length > 0.0
            && before_length > 0.0
        {
            let turn = before.dot(edge) / before_length - vector.dot(edge) / length;
            bend = bend.max(turn.abs() * length.min(before_length));
        }
        sum += length;
        here = to;
        last = Some((vector, edge, length));
    };
    for &(half_edge, share, _) in &path.crossings {
        assert_eq!(
            half_edge / 3,
            triangle,
            "left a triangle that it was not in"
        );
        let (at, edge) = on_edge(substrate, half_edge, share);
        leg(at, edge);
        triangle = substrate.twin(half_edge).half_edge() / 3;
    }
    assert_eq!(triangle, end.point.triangle);
    leg(substrate.position(&end.point), DVec3::ZERO);
    let weights = end.point.weights();
    Worst {
        length: (sum - step.length()).abs() / step.length().max(1.0),
        bend,
        outside: weights
            .iter()
            .fold(0.0, |o: f64, &w| o.max(-w).max(w - 1.0)),
        crossings: u64::from(end.crossings),
        gave_up: u64::from(end.end != End::Distance),
    }
}

/// Traces and follows.
pub(crate) fn walk(
    substrate: &Substrate,
    from: &SurfacePoint,
    step: DVec2,
    path: &mut Path,
) -> Worst {
    path.crossings.clear();
    let end = trace_visiting(substrate, from, step, path);
    follow(substrate, from, step, path, &end)
}

/// Many traces over one mesh: from anywhere in a triangle, from vertices and edges, aimed at
/// nothing, at vertices, and along edges.
pub(crate) fn survey(substrate: &Substrate, traces: usize, stream: &mut Stream) -> Worst {
    let longest = (400.0 / edges_met(substrate)).min(20.0);
    let (mut worst, mut path) = (Worst::default(), Path::default());
    for i in 0..traces {
        let triangle = (stream.uniform() * substrate.triangles().len() as f64) as u32;
        let from = start(i % 4, triangle, stream);
        let corners = substrate.facet(triangle).chart.corners();
        let [w0, w1, w2] = from.weights();
        let at = corners[0] * w0 + corners[1] * w1 + corners[2] * w2;
        let to_corner = corners[(stream.uniform() * 3.0) as usize] - at;
        let length = stream.uniform() * stream.uniform() * longest;
        let step = match i / 4 % 4 {
            0 if to_corner != DVec2::ZERO => to_corner,
            1 if to_corner != DVec2::ZERO => to_corner.normalize() * length,
            _ => direction(stream) * length,
        };
        worst.take(walk(substrate, &from, step, &mut path));
    }
    worst
}

/// Edges that a path meets in unit length, on average over all straight paths: the length of the
/// triangles' edges over π times their area (Crofton).
fn edges_met(substrate: &Substrate) -> f64 {
    let all = 0..substrate.triangles().len() as u32;
    let perimeter = |t| {
        let [a, b, c] = substrate.corners(t);
        a.distance(b) + b.distance(c) + c.distance(a)
    };
    let length: f64 = all.clone().map(perimeter).sum();
    length / (std::f64::consts::PI * all.map(|t| substrate.area(t)).sum::<f64>())
}

/// A point inside, two kinds on an edge, a corner.
fn start(kind: usize, triangle: u32, stream: &mut Stream) -> SurfacePoint {
    let (a, b) = (stream.uniform(), stream.uniform());
    let mut weights = match kind {
        0 | 1 => [a * (1.0 - b), a * b, 1.0 - a],
        2 => [a, 1.0 - a, 0.0],
        _ => [1.0, 0.0, 0.0],
    };
    weights.rotate_left((stream.uniform() * 3.0) as usize);
    SurfacePoint::from_weights(triangle, weights)
}
