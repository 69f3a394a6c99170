//! A triangle's plane in space, with its chart's axes.

use glam::{DVec2, DVec3};

use crate::substrate::{Substrate, SurfacePoint};

/// Axes in space of a triangle's chart: x along its first edge, y towards its third corner.
#[derive(Clone, Copy, Debug)]
pub struct TrianglePlane {
    triangle: u32,
    origin: DVec3,
    x: DVec3,
    y: DVec3,
    corners: [DVec2; 3],
}

impl TrianglePlane {
    /// The plane of a triangle.
    pub fn new(substrate: &Substrate, triangle: u32) -> Self {
        let [a, b, c] = substrate.corners(triangle);
        let x = (b - a).normalize_or(DVec3::X);
        let along = (c - a).dot(x);
        let y = (c - a - x * along).normalize_or(x.any_orthonormal_vector());
        let corners = [
            DVec2::ZERO,
            DVec2::new((b - a).dot(x), 0.0),
            DVec2::new(along, (c - a).dot(y)),
        ];
        Self {
            triangle,
            origin: a,
            x,
            y,
            corners,
        }
    }

    /// The corners in the plane, counter-clockwise.
    pub fn corners(&self) -> &[DVec2; 3] {
        &self.corners
    }

    /// A point in space as its foot in the plane, and its squared distance from the plane.
    pub fn project(&self, p: DVec3) -> (DVec2, f64) {
        let d = p - self.origin;
        let foot = DVec2::new(d.dot(self.x), d.dot(self.y));
        (
            foot,
            (d - self.x * foot.x - self.y * foot.y).length_squared(),
        )
    }

    /// A point of the plane in space.
    pub fn lift(&self, p: DVec2) -> DVec3 {
        self.origin + self.x * p.x + self.y * p.y
    }

    /// A point of the plane as a surface point, clamped to the triangle.
    pub fn surface_point(&self, p: DVec2) -> SurfacePoint {
        let [a, b, c] = self.corners;
        let weights = [
            (b - p).perp_dot(c - p),
            (c - p).perp_dot(a - p),
            (a - p).perp_dot(b - p),
        ];
        let sum = (b - a).perp_dot(c - a);
        SurfacePoint::from_weights(self.triangle, weights.map(|w| w / sum))
    }
}
