//! Triangles as they lie there, for what stands above them.

use glam::DVec3;

use super::{Facet, Substrate};

/// A triangle as it lies there.
pub(super) struct Lying {
    pub(super) facet: Facet,
    pub(super) normal: DVec3,
    /// A ball that holds it.
    pub(super) ball: (DVec3, f64),
}

impl Lying {
    pub(super) fn new(surface: &Substrate, triangle: u32) -> Self {
        let corners = surface.corners(triangle);
        Self {
            facet: surface.facet(triangle),
            normal: normal(corners),
            ball: ball_about(corners),
        }
    }
}

/// At right angles to a triangle, of no particular length.
pub(super) fn normal([a, b, c]: [DVec3; 3]) -> DVec3 {
    (b - a).cross(c - a)
}

/// How far a point stands straight above or below a triangle, if it does.
pub(super) fn height(Facet { chart, frame, .. }: &Facet, p: DVec3) -> Option<f64> {
    let foot = frame.flatten(p);
    let is_above = chart.contains(foot);
    is_above.then(|| frame.lift(foot).distance(p))
}

/// The mean of the corners.
pub(super) fn middle(corners: [DVec3; 3]) -> DVec3 {
    (corners[0] + corners[1] + corners[2]) / 3.0
}

/// A ball that holds a triangle, and a little more for rounding.
pub(super) fn ball_about(corners: [DVec3; 3]) -> (DVec3, f64) {
    let middle = middle(corners);
    let radius = corners.map(|c| c.distance(middle));
    (
        middle,
        (1.0 + 1e-9) * radius.into_iter().fold(0.0, f64::max),
    )
}
