//! Whether the lichen at one place belongs to the surface at another.
//!
//! Lichen is felt through space, and on a thin plate the other face is near. Two places of one piece belong
//! together when they are nearly in one plane; where that is in doubt the surface is asked whether
//! it joins them nearby (`docs/architecture.md`).

use std::ops::Range;

use glam::{DVec3, Vec3};

use super::lichen::Granule;
use crate::substrate::Substrate;
use crate::walk::{Ball, Connectivity};

/// Height over the other's plane, in element radii and as a share of the distance, from which two
/// places are in doubt.
const STEP: f32 = 0.1;
const SLOPE: f32 = 0.3;

/// Cosine of the angle between normals below which two places are in doubt: 45°.
const TURNED: f32 = 0.7;

/// Cosine below which lichen is not felt even round a rim: the way along the surface is far longer
/// than that through space.
const FACED_AWAY: f32 = -0.5;

/// Radius of the ball about their middle in which two places must be joined, over their distance.
const BALL: f64 = 0.75;

/// The question, with scratch space for its answer.
pub(super) struct Sheet<'a> {
    substrate: &'a Substrate,
    radius: f32,
    /// Triangles of the piece that was asked for last.
    piece: Range<u32>,
    search: Connectivity,
}

impl<'a> Sheet<'a> {
    /// For elements of this radius.
    pub(super) fn new(substrate: &'a Substrate, radius: f64) -> Self {
        Self {
            substrate,
            radius: radius as f32,
            piece: 0..0,
            search: Connectivity::new(),
        }
    }

    /// Whether an element belongs to the surface at a place: there the surface has this normal,
    /// and the place lies on the triangle `home`.
    pub(super) fn joins(&mut self, p: DVec3, normal: Vec3, home: u32, element: &Granule) -> bool {
        if home == element.home {
            return true;
        }
        if !self.piece.contains(&home) {
            self.piece = self.substrate.component_of(home).triangles.clone();
        }
        if !self.piece.contains(&element.home) {
            return false;
        }
        let along = normal.dot(element.normal);
        if along < FACED_AWAY {
            return false;
        }
        let away = (p - element.position).as_vec3();
        let height = (0.5 * away.dot(normal + element.normal)).abs();
        if along > TURNED && height < STEP * self.radius + SLOPE * away.length() {
            return true;
        }
        let ball = Ball {
            centre: 0.5 * (p + element.position),
            radius: BALL * f64::from(away.length()),
        };
        let places = [(home, p), (element.home, element.position)];
        self.search.likely_joined(self.substrate, places, &ball)
    }
}
