//! A triangle's plane in space, with its chart's axes.

use glam::{DVec2, DVec3};

use crate::substrate::{Frame, Substrate, SurfacePoint};

/// A triangle's chart and where it lies in space.
#[derive(Clone, Copy, Debug)]
pub struct TrianglePlane {
    triangle: u32,
    frame: Frame,
    corners: [DVec2; 3],
}

impl TrianglePlane {
    /// The plane of a triangle.
    pub fn new(substrate: &Substrate, triangle: u32) -> Self {
        let facet = substrate.facet(triangle);
        Self {
            triangle,
            frame: facet.frame,
            corners: facet.chart.corners(),
        }
    }

    /// The corners in the plane, counter-clockwise.
    pub fn corners(&self) -> &[DVec2; 3] {
        &self.corners
    }

    /// A point in space as its foot in the plane, and its squared distance from the plane.
    pub fn project(&self, p: DVec3) -> (DVec2, f64) {
        let Frame { origin, x, y } = self.frame;
        let d = p - origin;
        let foot = DVec2::new(d.dot(x), d.dot(y));
        (foot, (d - x * foot.x - y * foot.y).length_squared())
    }

    /// A point of the plane in space.
    pub fn lift(&self, p: DVec2) -> DVec3 {
        self.frame.lift(p)
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
