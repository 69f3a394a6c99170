//! What of a substrate is near a place, a sphere or a line.

use std::ops::Range;

use glam::DVec3;
use obvhs::aabb::Aabb;

use super::bvh::{box_distance_sq, box_farthest_sq, line_meets, padded_box};
use super::{Substrate, SurfacePoint, nearest_weights};

impl Substrate {
    /// The point of the surface nearest to a point in space, and the distance; local units. Of a point that is not
    /// finite it may be any, and the distance no number.
    pub fn nearest(&self, p: DVec3) -> (SurfacePoint, f64) {
        let distance_sq = |t| (self.position(&self.nearest_in(t, p)) - p).length_squared();
        let (triangle, d) = self.bvh.nearest(p, distance_sq).unwrap_or((0, 0.0));
        (self.nearest_in(triangle, p), d.sqrt())
    }

    /// The point nearest to a point in space of the surface that looks along a direction, if any does within a
    /// distance, local units.
    pub(crate) fn nearest_facing(
        &self,
        p: DVec3,
        direction: DVec3,
        within: f64,
    ) -> Option<SurfacePoint> {
        let limit_sq = within * within;
        let distance_sq = |t| match self.normal(t).dot(direction) >= 0.0 {
            true => (self.position(&self.nearest_in(t, p)) - p).length_squared(),
            false => f64::INFINITY,
        };
        let (triangle, d) = self.bvh.nearest_within(p, limit_sq, distance_sq)?;
        (d.is_finite() && d <= limit_sq).then(|| self.nearest_in(triangle, p))
    }

    /// The point of some triangles nearest to a point in space.
    pub(crate) fn nearest_among(&self, p: DVec3, among: &Range<u32>) -> SurfacePoint {
        let distance_sq = |t| match among.contains(&t) {
            true => (self.position(&self.nearest_in(t, p)) - p).length_squared(),
            false => f64::INFINITY,
        };
        let (triangle, _) = self
            .bvh
            .nearest(p, distance_sq)
            .unwrap_or((among.start, 0.0));
        self.nearest_in(triangle, p)
    }

    /// The point of a triangle nearest to a point in space.
    pub(crate) fn nearest_in(&self, triangle: u32, p: DVec3) -> SurfacePoint {
        SurfacePoint::from_weights(triangle, nearest_weights(p, self.corners(triangle)))
    }

    /// Triangles of which some point lies within `radius` of a centre, ascending.
    ///
    /// This is the thesis's triangle list (Sumner 2001, 6.3.2), asked for when it is needed instead of
    /// stored: a triangle belongs when its nearest point does. None is within a negative radius.
    pub fn triangles_within(&self, centre: DVec3, radius: f64) -> Vec<u32> {
        let limit = radius * radius.abs();
        let mut found = Vec::new();
        self.bvh.visit(
            |b| box_distance_sq(b, centre) <= limit,
            |t| {
                let corners = self.corners(t);
                let [a, b, c] = nearest_weights(centre, corners);
                let nearest = corners[0] * a + corners[1] * b + corners[2] * c;
                if (nearest - centre).length_squared() <= limit {
                    found.push(t);
                }
            },
        );
        found
    }

    /// Triangles of a range whose bounding boxes a sphere's surface may cut, ascending.
    pub(crate) fn triangles_near_sphere(
        &self,
        centre: DVec3,
        radius: f64,
        among: &Range<u32>,
    ) -> Vec<u32> {
        let limit = radius * radius;
        let cuts =
            |b: &Aabb| box_distance_sq(b, centre) <= limit && box_farthest_sq(b, centre) >= limit;
        self.triangles_in_boxes(cuts, among)
    }

    /// Triangles of a range whose bounding boxes a line meets, ascending.
    pub(crate) fn triangles_near_line(
        &self,
        through: DVec3,
        along: DVec3,
        among: &Range<u32>,
    ) -> Vec<u32> {
        self.triangles_in_boxes(|b| line_meets(b, through, along), among)
    }

    /// Triangles of a range whose own boxes pass, and with them all boxes about them.
    fn triangles_in_boxes(&self, passes: impl Fn(&Aabb) -> bool, among: &Range<u32>) -> Vec<u32> {
        let own = |t: u32| {
            let [a, b, c] = self.corners(t);
            padded_box(a.min(b).min(c), a.max(b).max(c))
        };
        let mut found = Vec::new();
        self.bvh.visit_among(among, &passes, |t| {
            if passes(&own(t)) {
                found.push(t);
            }
        });
        found
    }
}
