//! Where on the surface a place of the image is.
//!
//! Beyond the border of a chart the image goes on as the surface does: the way from the border is
//! laid out on the surface from there, over the seam and into the chart on its other side. So
//! bilinear sampling reads the same function of the surface from both sides of a seam.

use glam::DVec2;

use super::layout::{Corners, FOOTPRINT, Layout, doubled_area, nearest_in, weights};
use crate::substrate::{Substrate, SurfacePoint};
use crate::walk::trace;

/// How many times the usual size of a texel one may have on the surface beyond a chart's border:
/// slivers would send it far away.
pub(super) const STRETCH: f64 = 4.0;

/// How far into a triangle a way out of it starts, as a share of the way to its middle: not on its
/// side, nor at a corner, where a way has no one continuation.
const INWARD: f64 = 1e-3;

/// Finds places.
pub(super) struct Placer<'a> {
    pub(super) substrate: &'a Substrate,
    pub(super) layout: &'a Layout,
    /// Usual side of a texel on the surface, local units.
    pub(super) texel: f64,
}

/// A place of the image on the surface.
pub(super) struct Place {
    /// The surface's point.
    pub(super) at: SurfacePoint,
    /// Weights of the owner's corners where its frame is taken.
    pub(super) weights: [f64; 3],
    /// The owner's point at the border, where bilinear sampling does not come so far beyond it. The
    /// gutter there is for smaller levels of the texture, and normals beyond a sharp edge would tilt
    /// those.
    pub(super) border: Option<SurfacePoint>,
}

impl<'a> Placer<'a> {
    pub(super) fn new(substrate: &'a Substrate, layout: &'a Layout) -> Self {
        let shown = |t: &usize| layout.corners[*t].is_some();
        let shown: Vec<usize> = (0..layout.corners.len()).filter(shown).collect();
        let surface: f64 = shown.iter().map(|&t| substrate.area(t as u32)).sum();
        let image = |&t: &usize| layout.corners[t].map_or(0.0, |c| 0.5 * doubled_area(&c).abs());
        let image: f64 = shown.iter().map(image).sum();
        Self {
            substrate,
            layout,
            texel: (surface / image.max(1.0)).sqrt(),
        }
    }

    /// The surface at a place of the image that a triangle owns.
    pub(super) fn place(&self, owner: u32, corners: &Corners, p: DVec2) -> Place {
        let p = self.layout.near(corners, p);
        let inside = weights(corners, p);
        if inside.iter().all(|&w| w >= 0.0) {
            return Place {
                at: SurfacePoint::from_weights(owner, inside),
                weights: inside,
                border: None,
            };
        }
        let border = nearest_in(corners, p);
        let weights_there = weights(corners, border).map(|w| w.max(0.0));
        let start = weights_there.map(|w| w + INWARD * (1.0 / 3.0 - w));
        let texels = (p - border).length();
        let is_far = texels > FOOTPRINT;
        Place {
            at: self.beyond(owner, start, inside, texels),
            weights: weights_there,
            border: is_far.then(|| SurfacePoint::from_weights(owner, start)),
        }
    }

    /// The end of the way from a point of a triangle to weights beyond it, so many texels away.
    fn beyond(&self, owner: u32, start: [f64; 3], end: [f64; 3], texels: f64) -> SurfacePoint {
        let chart = self.substrate.facet(owner).chart.corners();
        let at = |w: [f64; 3]| chart[0] * w[0] + chart[1] * w[1] + chart[2] * w[2];
        let way = at(end) - at(start);
        let longest = STRETCH * self.texel * texels + INWARD * way.length();
        let start = SurfacePoint::from_weights(owner, start);
        trace(self.substrate, &start, way.clamp_length_max(longest), true).point
    }
}
