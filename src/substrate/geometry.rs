//! Per-triangle geometry: charts for walking, and exact queries against one triangle.

use glam::{DVec2, DVec3};

use super::adjacency::Twin;

/// What a walk needs to know when it comes into a triangle through one of its half-edges.
///
/// The triangle's third corner (the apex) is at start + along·e + height·e⊥, with e the vector of
/// the half-edge and e⊥ the same vector turned to the triangle's inside. No length is stored, so
/// the triangle unfolds into whatever frame the half-edge is known in. It lies in one cache line.
#[derive(Clone, Copy, Debug)]
#[repr(align(32))]
pub struct Crossing {
    /// Apex along the half-edge, in lengths of the half-edge.
    pub along: f64,
    /// Apex away from the half-edge, in lengths of the half-edge; positive.
    pub height: f64,
    /// What lies across the other two: the one from this half-edge's end to the apex, and the one
    /// from there to its start.
    pub exits: [Twin; 2],
    /// The number of the apex among the vertices. Who comes in asks for its place in space by it, and so need not look
    /// up the triangle's corners first.
    pub apex: u32,
}

/// A triangle laid flat: its first corner at the origin, its second on the positive x axis.
#[derive(Clone, Copy, Debug)]
pub struct Chart {
    /// Length of the edge from the first to the second corner.
    pub base: f64,
    /// The third corner.
    pub apex: DVec2,
}

/// By how much a place is on the inner side of each edge of a triangle that lies flat: of the first the distance, of
/// the others twice the area that it spans with them.
#[inline(always)]
fn inside(base: f64, apex: DVec2, p: DVec2) -> [f64; 3] {
    [
        p.y,
        (apex.x - base) * p.y - apex.y * (p.x - base),
        apex.y * p.x - apex.x * p.y,
    ]
}

/// A triangle's crossings by the half-edges that leave its first, second and third corner, given by where these are and
/// by their numbers.
pub(super) fn crossings(corners: [DVec3; 3], numbers: [u32; 3], twins: [Twin; 3]) -> [Crossing; 3] {
    let one = |k: usize| {
        let (next, previous) = ((k + 1) % 3, (k + 2) % 3);
        let (e, f) = (corners[next] - corners[k], corners[previous] - corners[k]);
        let length_sq = e.length_squared();
        Crossing {
            along: e.dot(f) / length_sq,
            height: e.cross(f).length() / length_sq,
            exits: [twins[next], twins[previous]],
            apex: numbers[previous],
        }
    };
    [one(0), one(1), one(2)]
}

impl Chart {
    /// The corners in the triangle's own frame, counter-clockwise.
    pub fn corners(&self) -> [DVec2; 3] {
        [DVec2::ZERO, DVec2::new(self.base, 0.0), self.apex]
    }

    /// A point by its barycentric weights.
    #[inline(always)]
    pub(crate) fn place(&self, [a, b, c]: [f64; 3]) -> DVec2 {
        let [first, second, third] = self.corners();
        first * a + second * b + third * c
    }

    /// A point as shares of the edges from the first corner to the second and to the third.
    #[inline]
    pub fn shares(&self, p: DVec2) -> DVec2 {
        let y = p.y / self.apex.y;
        DVec2::new((p.x - y * self.apex.x) / self.base, y)
    }

    /// True for a point in the triangle, its edges included.
    #[inline]
    pub fn contains(&self, p: DVec2) -> bool {
        let [above, right, left] = inside(self.base, self.apex, p);
        // One branch and not three: which edge a step crosses is not to be foreseen.
        let least = |a: f64, b: f64| if a < b { a } else { b };
        least(above, least(left, right)) >= 0.0
    }
}

/// Where a triangle's chart lies in space.
#[derive(Clone, Copy, Debug)]
pub struct Frame {
    /// The first corner.
    pub origin: DVec3,
    /// The direction of the first edge, a unit vector.
    pub x: DVec3,
    /// The direction at right angles to `x` in the triangle's plane, towards the third corner; a unit vector, but on
    /// slivers: both are off by round-off times the triangle's length over its width, at most by a thousandth.
    pub y: DVec3,
}

impl Frame {
    /// A point of the chart in space.
    #[inline]
    pub fn lift(&self, p: DVec2) -> DVec3 {
        self.origin + self.x * p.x + self.y * p.y
    }

    /// A place in space, straight down on the chart.
    #[inline]
    pub fn flatten(&self, p: DVec3) -> DVec2 {
        self.turned(p - self.origin)
    }

    /// A vector of the chart in space.
    pub fn turned_back(&self, v: DVec2) -> DVec3 {
        self.x * v.x + self.y * v.y
    }

    /// The part of a vector that lies in the chart.
    #[inline]
    pub fn turned(&self, v: DVec3) -> DVec2 {
        DVec2::new(self.x.dot(v), self.y.dot(v))
    }
}

/// A triangle's chart and where that lies in space.
#[derive(Clone, Copy, Debug)]
pub struct Facet {
    /// The triangle.
    pub triangle: u32,
    /// The chart.
    pub chart: Chart,
    /// Where it lies.
    pub frame: Frame,
}

/// The same in lengths of the first edge: without a root, which a walker that comes to the triangle would wait for.
pub(crate) struct Unscaled {
    triangle: u32,
    apex: DVec2,
    origin: DVec3,
    /// The first edge, and at right angles to it as long a vector towards the third corner.
    edge: DVec3,
    up: DVec3,
}

impl Unscaled {
    /// A triangle by its corners and the third one in terms of the first edge, as a [`Crossing`] has it.
    #[inline(always)]
    pub(super) fn new(triangle: u32, [a, b, c]: [DVec3; 3], apex: DVec2) -> Self {
        let edge = b - a;
        Self {
            triangle,
            apex,
            origin: a,
            edge,
            up: (c - a - edge * apex.x) * (1.0 / apex.y),
        }
    }

    /// A place that is known in terms of the k-th edge, as a [`Crossing`] has the third corner.
    #[inline(always)]
    pub(crate) fn place(&self, k: usize, (along, height): (f64, f64)) -> DVec2 {
        let corners = [DVec2::ZERO, DVec2::X, self.apex];
        let edges = [DVec2::X, self.apex - DVec2::X, -self.apex];
        corners[k] + edges[k] * along + edges[k].perp() * height
    }

    /// A place in space.
    #[inline(always)]
    pub(crate) fn lift(&self, p: DVec2) -> DVec3 {
        self.origin + self.edge * p.x + self.up * p.y
    }

    /// Where a line comes through the triangle's plane. None where its direction, a unit vector, is not within an angle
    /// with this cosine of the normal.
    #[inline(always)]
    pub(crate) fn pierced(&self, from: DVec3, along: DVec3, least_cos: f64) -> Option<DVec2> {
        let (normal, length_sq) = (self.edge.cross(self.up), self.edge.length_squared());
        let steep = normal.dot(along);
        (steep > least_cos * length_sq).then(|| {
            let way = from - self.origin;
            let way = way - along * (way.dot(normal) / steep);
            DVec2::new(way.dot(self.edge), way.dot(self.up)) / length_sq
        })
    }

    /// The edge that a place of the plane is beyond, of two the one with which it spans more; none of a place in the
    /// triangle.
    #[inline(always)]
    pub(crate) fn edge_towards(&self, p: DVec2) -> Option<u32> {
        let inside = inside(1.0, self.apex, p);
        let (mut edge, mut least) = (0, inside[0]);
        for (k, &inside) in (1..).zip(&inside[1..]) {
            if inside < least {
                (edge, least) = (k, inside);
            }
        }
        let is_inside = least >= 0.0;
        (!is_inside).then_some(edge)
    }

    /// In local units.
    #[inline(always)]
    pub(crate) fn scaled(&self) -> Facet {
        let base = self.edge.length();
        let inverse = 1.0 / base;
        Facet {
            triangle: self.triangle,
            chart: Chart {
                base,
                apex: self.apex * base,
            },
            frame: Frame {
                origin: self.origin,
                x: self.edge * inverse,
                y: self.up * inverse,
            },
        }
    }
}

/// Barycentric weights of the point of a triangle that is nearest to p, after Ericson,
/// *Real-Time Collision Detection* (2005), 5.1.5.
pub(crate) fn nearest_weights(p: DVec3, [a, b, c]: [DVec3; 3]) -> [f64; 3] {
    let (ab, ac) = (b - a, c - a);
    let (d1, d2) = (ab.dot(p - a), ac.dot(p - a));
    if d1 <= 0.0 && d2 <= 0.0 {
        return [1.0, 0.0, 0.0];
    }
    let (d3, d4) = (ab.dot(p - b), ac.dot(p - b));
    if d3 >= 0.0 && d4 <= d3 {
        return [0.0, 1.0, 0.0];
    }
    let vc = d1 * d4 - d3 * d2;
    if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        let t = ratio(d1, d1 - d3);
        return [1.0 - t, t, 0.0];
    }
    let (d5, d6) = (ab.dot(p - c), ac.dot(p - c));
    if d6 >= 0.0 && d5 <= d6 {
        return [0.0, 0.0, 1.0];
    }
    let vb = d5 * d2 - d1 * d6;
    if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
        let t = ratio(d2, d2 - d6);
        return [1.0 - t, 0.0, t];
    }
    let va = d3 * d6 - d5 * d4;
    if va <= 0.0 && d4 - d3 >= 0.0 && d5 - d6 >= 0.0 {
        let t = ratio(d4 - d3, (d4 - d3) + (d5 - d6));
        return [0.0, 1.0 - t, t];
    }
    let sum = va + vb + vc;
    if sum < THIN * ab.length_squared() * ac.length_squared() {
        return weights_on_thin(p - a, ab, ac);
    }
    [va / sum, vb / sum, vc / sum]
}

/// The square of an angle below which differences of products are rounded to less than lengths are.
const THIN: f64 = 1e-6;

/// The weights of what a place is above, given from the corner between two sides with a small angle: rounded by
/// the length over the width, where [`nearest_weights`] is by the square of that.
#[cold]
fn weights_on_thin(p: DVec3, ab: DVec3, ac: DVec3) -> [f64; 3] {
    let normal = ab.cross(ac);
    let share = |area: DVec3| ratio(area.dot(normal), normal.length_squared()).clamp(0.0, 1.0);
    let (b, c) = (share(p.cross(ac)), share(ab.cross(p)));
    let c = c.min(1.0 - b);
    [1.0 - b - c, b, c]
}

/// a/b, or 0 for 0/0.
fn ratio(a: f64, b: f64) -> f64 {
    if b == 0.0 { 0.0 } else { a / b }
}

/// Squared distance from p to the segment ab.
pub(crate) fn segment_distance_sq(p: DVec3, a: DVec3, b: DVec3) -> f64 {
    way_from_segment(p, a, b).length_squared()
}

/// The way to p from the nearest point of the segment ab.
#[inline]
pub(crate) fn way_from_segment(p: DVec3, a: DVec3, b: DVec3) -> DVec3 {
    let e = b - a;
    let t = ratio((p - a).dot(e), e.length_squared()).clamp(0.0, 1.0);
    p - a - e * t
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rng::{Purpose, Stream};

    /// A triangle of length 1 and this width, with its third corner so far along it, turned somehow, and begun at any
    /// corner.
    fn sliver(width: f64, along: f64, begin: usize, stream: &mut Stream) -> [DVec3; 3] {
        let axis = DVec3::from([0; 3].map(|_| stream.uniform() - 0.5));
        let x = axis.normalize();
        let y = x.any_orthonormal_vector();
        let corners = [DVec3::ZERO, x, x * along + y * width];
        let aside = DVec3::new(3.0, -1.0, 2.0) * stream.uniform();
        [0, 1, 2].map(|k| corners[(begin + k) % 3] + aside)
    }

    #[test]
    fn facets_lie_on_their_triangles() {
        let mut stream = Stream::new(4, Purpose::Walker, 0);
        for i in 0..6_000 {
            let width = [1.0, 1e-2, 1e-4, 1e-6, 1e-8, 1e-11][i % 6];
            let along = [0.0, 0.4, 1.0, 0.97][i / 6 % 4];
            let corners = sliver(width, along, i / 24 % 3, &mut stream);
            let [first, ..] = crossings(corners, [0; 3], [Twin::from_bits(0); 3]);
            let unscaled = Unscaled::new(7, corners, DVec2::new(first.along, first.height));
            let Facet { chart, frame, .. } = unscaled.scaled();
            for (at, corner) in chart.corners().into_iter().zip(corners) {
                assert!(frame.lift(at).distance(corner) < 1e-14, "{width}, {along}");
                assert!(unscaled.lift(at / chart.base).distance(corner) < 1e-14);
            }
            let off = [
                frame.x.length() - 1.0,
                frame.y.length() - 1.0,
                frame.x.dot(frame.y),
            ];
            assert!(
                off.iter().all(|off| off.abs() < 1e-14 / width),
                "{off:?} at {width}"
            );
        }
    }

    #[test]
    fn lines_come_through_planes_where_both_are() {
        let mut stream = Stream::new(5, Purpose::Walker, 0);
        let mut beyond = [0; 4];
        for i in 0..6_000 {
            let width = [1.0, 0.3, 1e-2][i % 3];
            let corners = sliver(width, [0.2, 0.8][i % 2], i / 6 % 3, &mut stream);
            let [first, ..] = crossings(corners, [0; 3], [Twin::from_bits(0); 3]);
            let flat = Unscaled::new(7, corners, DVec2::new(first.along, first.height));
            let normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
            let [u, v] = [0; 2].map(|_| 2.0 * stream.uniform() - 0.7);
            let at = |[a, b, c]: [f64; 3]| corners[0] * a + corners[1] * b + corners[2] * c;
            let weights = [1.0 - u - v, u, v];
            let place = at(weights);
            let aside = DVec3::from([0; 3].map(|_| stream.uniform() - 0.5));
            let along = (normal.normalize() + aside).normalize();
            let from = place + along * (4.0 * stream.uniform() - 2.0);
            let cos = along.dot(normal.normalize());
            assert_eq!(flat.pierced(from, along, cos + 1e-9), None);
            let there = flat.pierced(from, along, cos - 1e-9).expect("a place");
            assert!(flat.lift(there).distance(place) < 1e-11 / width);
            // The weight of a corner is what a place spans with the edge across, as a share of the triangle.
            let across = [weights[2], weights[0], weights[1]];
            let least = across.into_iter().fold(0.0, f64::min);
            let expected = (0..3).find(|&k| across[k as usize] == least && least < 0.0);
            if across.iter().all(|w| w.abs() > 1e-9) {
                assert_eq!(flat.edge_towards(there), expected, "{weights:?}");
                beyond[expected.unwrap_or(3) as usize] += 1;
            }
        }
        assert!(beyond.iter().all(|&n| n > 500), "{beyond:?}");
    }

    #[test]
    fn what_is_on_a_sliver_is_nearest_to_itself() {
        let mut stream = Stream::new(3, Purpose::Walker, 0);
        for i in 0..6_000 {
            let width = [1e-2, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8][i % 6];
            let along = [0.0, 0.4, 1.0, 0.97][i / 6 % 4];
            let corners = sliver(width, along, i / 24 % 3, &mut stream);
            let [u, v] = [0; 2].map(|_| 0.5 * stream.uniform());
            let at = |[a, b, c]: [f64; 3]| corners[0] * a + corners[1] * b + corners[2] * c;
            let place = at([1.0 - u - v, u, v]);
            let weights = nearest_weights(place, corners);
            assert!(
                weights.iter().all(|w| (0.0..=1.0).contains(w)),
                "{weights:?}"
            );
            let aside = at(weights).distance(place);
            assert!(aside < 1e-14 / width + 1e-10, "{aside} at {width}, {along}");
        }
    }
}
