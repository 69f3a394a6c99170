//! Lichen that lies over another and hides it.

use std::sync::{Mutex, PoisonError};

use glam::{DVec3, Vec3};
use rayon::prelude::*;

use super::field::{Field, NOTHING, Sample, cutoff};
use super::grid::{Grid, Nearness};
use super::lichen::Lichen;
use super::sheet::Sheet;
use super::{Shape, SkinError};
use crate::cluster::{Cluster, Element};
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
    /// Where a lichen is whose skin has this shape.
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
        let mut lichen = Lichen::unmeasured(substrate, cluster);
        let grid = lichen.sort(cutoff(shape) * cluster.radius());
        Ok(Self {
            nearness: Nearness::new(lichen.granules.iter().map(|g| g.position)),
            lichen,
            grid,
            shape: *shape,
        })
    }

    /// For each element of another lichen on the same substrate, in birth order, whether this one lies over it.
    ///
    /// # Panics
    /// When an element is in a triangle that the substrate does not have.
    pub fn hides(&self, substrate: &Substrate, other: &Cluster) -> Vec<bool> {
        let hides = |over: &mut Over, e: &Element| {
            let facing = substrate.normal(e.at.triangle).as_vec3();
            over.level(e.position, e.at.triangle, facing) > 0.0
        };
        let over = || Over::new(self, substrate);
        other.elements().par_iter().map_init(over, hides).collect()
    }
}

/// Asks a cover.
struct Over<'a> {
    field: Field<'a>,
    sheet: Sheet<'a>,
    nearness: &'a Nearness,
    felt: f64,
}

impl<'a> Over<'a> {
    fn new(cover: &'a Cover, substrate: &'a Substrate) -> Self {
        Self {
            field: Field::new(substrate, &cover.lichen, &cover.grid, &cover.shape),
            sheet: Sheet::new(substrate, cover.lichen.radius),
            nearness: &cover.nearness,
            felt: cutoff(&cover.shape) * cover.lichen.radius,
        }
    }

    /// The level of the cover at a place that lies on a triangle of the substrate, whose normal is `facing`: positive
    /// beneath it.
    fn level(&mut self, place: DVec3, home: u32, facing: Vec3) -> f32 {
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

/// All that lies over a lichen.
pub(super) struct Roof<'a> {
    substrate: &'a Substrate,
    covers: &'a [Cover],
    /// What asks them, while nobody uses it.
    spare: Mutex<Vec<Vec<Over<'a>>>>,
}

impl<'a> Roof<'a> {
    pub(super) fn new(substrate: &'a Substrate, covers: &'a [Cover]) -> Self {
        Self {
            substrate,
            covers,
            spare: Mutex::default(),
        }
    }

    /// What is left of a sample at a place: beneath covers its level is negative.
    pub(super) fn cut(&self, sample: Sample, place: DVec3, home: u32, facing: Vec3) -> Sample {
        if self.covers.is_empty() || sample.level <= 0.0 {
            return sample;
        }
        let spare = || self.spare.lock().unwrap_or_else(PoisonError::into_inner);
        let all = || self.covers.iter().map(|c| Over::new(c, self.substrate));
        let mut asked = spare().pop().unwrap_or_else(|| all().collect());
        let over = asked.iter_mut().map(|over| over.level(place, home, facing));
        let hidden = over.fold(NOTHING, f32::max);
        spare().push(asked);
        Sample {
            level: sample.level.min(-hidden),
            ..sample
        }
    }
}
