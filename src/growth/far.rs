//! Far jumps on a coarser copy of the surface.
//!
//! Most of the edges that a walker crosses lie far from the lichen. There it walks on a copy with
//! fewer triangles, and comes back to the surface before it is near. Contacts, sheets and joining
//! know nothing of it. On the copy bumps are flatter, so far jumps go over them straighter; what that
//! changes in where walkers come to the lichen is measured in `tests/far.rs`.

use std::sync::Arc;

use super::Parameters;
use crate::substrate::{Coarse, Substrate, SurfacePoint};
use crate::walk::Stand;

/// How far the copy's vertices may stray from the surface, in element radii.
const ERROR: f64 = 8.0;

/// Bounds below the copy's deviation, or below this many element radii, are for the surface.
const LEAST_LAND: f64 = 8.0;

/// Bounds this many times as large as those are for the copy.
const LIFT: f64 = 2.0;

/// Walks on the surface to a place on the copy, at most.
const MOST_WALKS: usize = 3;

/// A coarser copy, and when to walk on it.
pub(super) struct Far {
    coarse: Arc<Coarse>,
    /// A walker on the copy with a smaller bound lands.
    pub(super) land: f64,
    /// One on the surface with a larger bound is lifted.
    pub(super) lift: f64,
}

impl Far {
    /// None where a copy would not be worth having.
    pub(super) fn new(substrate: &Substrate, parameters: &Parameters) -> Option<Self> {
        let coarse = substrate.coarser(ERROR * parameters.radius)?;
        let land = coarse.deviation().max(LEAST_LAND * parameters.radius);
        Some(Self {
            coarse,
            land,
            lift: LIFT * land,
        })
    }

    /// The surface to walk on there.
    pub(super) fn surface(&self) -> &Substrate {
        self.coarse.surface()
    }

    /// How much farther from the lichen than a place on the copy the place on the surface may be.
    pub(super) fn deviation(&self) -> f64 {
        self.coarse.deviation()
    }

    /// From the surface to the copy.
    pub(super) fn lifted(&self, here: &Stand) -> Stand {
        let above = self.coarse.above(here.triangle, here.position);
        Stand::new(self.surface(), &above)
    }

    /// From the copy to the surface: from a triangle near there by short walks over the surface, each
    /// towards the place on the copy, as long as they lead nearer.
    pub(super) fn landed(&self, substrate: &Substrate, here: &Stand) -> Option<Stand> {
        let triangle = self.coarse.below(here.triangle, here.at);
        if triangle == u32::MAX {
            return None;
        }
        let mut there = Stand::new(substrate, &SurfacePoint::from_weights(triangle, [1.0; 3]));
        for _ in 0..MOST_WALKS {
            let frame = &substrate.frames()[there.triangle as usize];
            let onward = frame.turned(here.position - there.position);
            let next = there.step(substrate, onward, false).to;
            let [before, after] = [there, next].map(|s| s.position.distance_squared(here.position));
            if after >= before {
                break;
            }
            there = next;
        }
        Some(there)
    }
}
