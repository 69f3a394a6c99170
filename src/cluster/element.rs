//! One disc of the lichen.

use glam::DVec3;

use crate::substrate::{Substrate, SurfacePoint};

/// The parent of an element that has none: a seed.
pub const NO_PARENT: u32 = u32::MAX;

/// One aggregated disc. Its age is its place in the [`Cluster`](super::Cluster).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Element {
    /// Where it is on the surface.
    pub at: SurfacePoint,
    /// Where it is in space, local units.
    pub position: DVec3,
    /// Age of the element that it stuck to; [`NO_PARENT`] for a seed.
    pub parent: u32,
    /// Which seed it descends from.
    pub colony: u32,
    /// The sticking probability that it stuck with: P_s, times the factor of a mask that is grey there; 1 for a seed.
    pub probability: f64,
}

impl Element {
    /// A seed of the first colony.
    pub fn seed(substrate: &Substrate, at: SurfacePoint) -> Self {
        Self {
            at,
            position: substrate.position(&at),
            parent: NO_PARENT,
            colony: 0,
            probability: 1.0,
        }
    }
}
