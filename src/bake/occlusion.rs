//! How much light the lichen itself keeps from a texel.
//!
//! Horizons in the map of heights (L. Bavoil, M. Sainz and R. Dimitrov, *Image-space horizon-based
//! ambient occlusion*, 2008): in each of eight directions along the surface the steepest way up to
//! the lichen around, at an angle θ over the surface, leaves cos² θ of the light of an even sky. The
//! gutter continues the surface beyond the borders of charts, so horizons reach over seams; they
//! end with it. Not counted are the curvature of the substrate and the slope of the place itself.

use glam::{DMat2, DVec2};

use super::frame::Frame;
use super::layout::{Corners, weights};
use super::place::Placer;
use super::texel::{Texel, Texels};

/// Distances at which horizons are looked for, in element radii and, at least, in texels.
const DISTANCES: [(f64, f64); 4] = [(0.75, 1.0), (1.5, 2.0), (3.0, 3.0), (6.0, 4.0)];

/// The farthest of them.
pub(super) const SHADED: f64 = DISTANCES[3].0;

/// Half the directions, as cosine and sine: each counts both ways.
const DIRECTIONS: [[f64; 2]; 4] = [
    [1.0, 0.0],
    [
        std::f64::consts::FRAC_1_SQRT_2,
        std::f64::consts::FRAC_1_SQRT_2,
    ],
    [0.0, 1.0],
    [
        -std::f64::consts::FRAC_1_SQRT_2,
        std::f64::consts::FRAC_1_SQRT_2,
    ],
];

/// Looks for horizons.
pub(super) struct Horizons<'a> {
    pub(super) placer: &'a Placer<'a>,
    pub(super) frames: &'a [Frame],
    /// Element radius, of several the smallest; local units.
    pub(super) radius: f64,
    /// How far from a texel the image is known to go on as the surface does, in texels.
    pub(super) known: f64,
}

impl Horizons<'_> {
    /// The share of an even sky's light that comes to a texel.
    pub(super) fn light(&self, texels: &Texels, number: usize, texel: &Texel) -> f32 {
        let layout = self.placer.layout;
        let owner = layout.owners[number];
        let Some(corners) = layout.corners[owner as usize] else {
            return 1.0;
        };
        let p = layout.near(&corners, layout.middle(number));
        let to_image = self.to_image(owner, &corners);
        let [x, y] = self.axes(owner, &corners, p);
        let way = |[cos, sin]: [f64; 2]| to_image * (x * cos + y * sin);
        let both = DIRECTIONS.iter().flat_map(|&d| [way(d), -way(d)]);
        let left = both.map(|way| self.left(texels, p, way, f64::from(texel.height)));
        (left.sum::<f64>() / (2 * DIRECTIONS.len()) as f64) as f32
    }

    /// cos² of the horizon's angle, along a way in texels for a unit of length on the surface.
    fn left(&self, texels: &Texels, p: DVec2, way: DVec2, height: f64) -> f64 {
        let texels_per_length = way.length();
        let mut steepest = 0.0_f64;
        for (radii, least) in DISTANCES {
            let distance = (radii * self.radius).max(least / texels_per_length);
            if distance * texels_per_length <= self.known {
                let there = self.height(texels, p + way * distance);
                steepest = steepest.max((there - height) / distance);
            }
        }
        1.0 / (1.0 + steepest * steepest)
    }

    /// Height at a place of the image, by bilinear sampling.
    fn height(&self, texels: &Texels, p: DVec2) -> f64 {
        let (low, share) = (p.floor(), p - p.floor());
        let at = |dx: i64, dy: i64| {
            let texel = self
                .placer
                .layout
                .texel(low.x as i64 + dx, low.y as i64 + dy);
            texels.get(texel).map_or(0.0, |t| f64::from(t.height))
        };
        let row = |dy: i64| at(0, dy) + share.x * (at(1, dy) - at(0, dy));
        row(0) + share.y * (row(1) - row(0))
    }

    /// From directions in a triangle's chart to the image.
    fn to_image(&self, triangle: u32, corners: &Corners) -> DMat2 {
        let [a, b, c] = *corners;
        let [p, q, r] = self.placer.substrate.facet(triangle).chart.corners();
        DMat2::from_cols(b - a, c - a) * DMat2::from_cols(q - p, r - p).inverse()
    }

    /// Two directions in a triangle's chart that depend on the surface's normal and not on the chart,
    /// so that both sides of a seam look the same ways.
    fn axes(&self, triangle: u32, corners: &Corners, p: DVec2) -> [DVec2; 2] {
        let frame = self.frames[triangle as usize];
        let weights = weights(corners, p).map(|w| w.clamp(0.0, 1.0));
        let normal = frame.axes(weights).z_axis.normalize_or(frame.normals[0]);
        let (x, y) = normal.any_orthonormal_pair();
        let flat = self.placer.substrate.facet(triangle).frame;
        [x, y].map(|d| {
            let d = d.as_dvec3();
            DVec2::new(d.dot(flat.x), d.dot(flat.y)).normalize_or(DVec2::X)
        })
    }
}
