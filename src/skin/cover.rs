//! Lichen that lies over another and hides it.

use glam::{DVec3, Vec3};
use rayon::prelude::*;

use super::base::Winding;
use super::field::{Field, NOTHING, cutoff};
use super::grid::{Grid, Nearness};
use super::lichen::Lichen;
use super::sheet::Sheet;
use super::{Shape, SkinError};
use crate::cluster::Cluster;
use crate::substrate::Substrate;

/// Where a lichen is, for others beneath it.
pub struct Cover {
    lichen: Lichen,
    grid: Grid,
    nearness: Nearness,
    shape: Shape,
}

impl std::fmt::Debug for Cover {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Cover")
            .field("elements", &self.lichen.granules.len())
            .finish_non_exhaustive()
    }
}

impl Cover {
    /// Of a lichen with a skin of this shape.
    ///
    /// # Errors
    /// When a number of `shape` is out of its range, or when there are no elements.
    ///
    /// # Panics
    /// When an element is in a triangle that the substrate does not have.
    pub fn new(substrate: &Substrate, cluster: &Cluster, shape: &Shape) -> Result<Self, SkinError> {
        shape.check()?;
        if cluster.is_empty() {
            return Err(SkinError::Empty);
        }
        let mut lichen = Lichen::unmeasured(substrate, &Winding::of(substrate), cluster);
        let grid = lichen.sort(cutoff(shape) * cluster.radius());
        Ok(Self {
            nearness: Nearness::new(lichen.granules.iter().map(|g| g.position)),
            lichen,
            grid,
            shape: *shape,
        })
    }

    /// For each element of another lichen on the same substrate, in birth order, whether this one lies over it.
    pub fn hides(&self, substrate: &Substrate, other: &Cluster) -> Vec<bool> {
        let winding = Winding::of(substrate);
        let elements = other.elements().par_iter();
        let hides = |over: &mut Over, e: &crate::cluster::Element| {
            let facing = winding.normal(substrate, e.at.triangle).as_vec3();
            over.level(e.position, e.at.triangle, facing) > 0.0
        };
        let over = || self.over(substrate);
        elements.map_init(over, hides).collect()
    }

    /// What tells where it is, one for each thread.
    pub(super) fn over<'a>(&'a self, substrate: &'a Substrate) -> Over<'a> {
        Over {
            field: Field::new(substrate, &self.lichen, &self.grid, &self.shape),
            sheet: Sheet::new(substrate, self.lichen.radius),
            nearness: &self.nearness,
            felt: cutoff(&self.shape) * self.lichen.radius,
        }
    }
}

/// Asks a cover.
pub(super) struct Over<'a> {
    field: Field<'a>,
    sheet: Sheet<'a>,
    nearness: &'a Nearness,
    felt: f64,
}

impl Over<'_> {
    /// The level of the cover at a place that lies on a triangle of the substrate, whose normal is `facing`: positive
    /// beneath it.
    pub(super) fn level(&mut self, place: DVec3, home: u32, facing: Vec3) -> f32 {
        match self.nearness.within(place, self.felt) {
            true => {
                self.field
                    .sample(place, home, facing, &mut self.sheet)
                    .level
            }
            false => NOTHING,
        }
    }
}
