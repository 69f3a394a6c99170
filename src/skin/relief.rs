//! The lichen's surface as heights over places of the substrate: what the skin is drawn from, for
//! others to draw from too.

use glam::DVec3;

use super::cortex::{Cortex, Dress};
use super::field::{Field, Sample, cutoff};
use super::grid::{Grid, Nearness};
use super::lichen::Lichen;
use super::sheet::Sheet;
use super::{Paint, Shape, SkinError, last, may_carry};
use crate::cluster::Cluster;
use crate::substrate::{Substrate, SurfacePoint};

/// A lichen, ready to be asked for its height anywhere on its substrate.
pub(crate) struct Relief<'a> {
    substrate: &'a Substrate,
    shape: Shape,
    lichen: Lichen,
    grid: Grid,
    nearness: Nearness,
    cortex: Option<Cortex>,
    paint: Paint,
}

impl<'a> Relief<'a> {
    /// # Errors
    /// When a number of `shape` or `paint` is out of its range, or when there are no elements.
    pub(crate) fn new(
        substrate: &'a Substrate,
        cluster: &Cluster,
        shape: &Shape,
        paint: &Paint,
    ) -> Result<Self, SkinError> {
        shape.check()?;
        paint.check()?;
        if cluster.is_empty() {
            return Err(SkinError::Empty);
        }
        let mut lichen = Lichen::new(substrate, cluster, paint);
        let cortex = Cortex::new(&lichen, paint, shape.thickness);
        let grid = lichen.sort(cutoff(shape) * cluster.radius());
        let nearness = Nearness::new(lichen.granules.iter().map(|g| g.position));
        Ok(Self {
            substrate,
            shape: *shape,
            nearness,
            lichen,
            grid,
            cortex,
            paint: paint.clone(),
        })
    }

    /// Whether lichen may be felt within `margin` (local units) of a triangle.
    pub(crate) fn may_carry(&self, triangle: u32, margin: f64) -> bool {
        let felt = cutoff(&self.shape) * self.lichen.radius + margin;
        may_carry(self.substrate, &self.nearness, triangle, felt)
    }

    /// Whether lichen is felt within `margin` of a place, local units.
    pub(crate) fn is_near(&self, place: DVec3, margin: f64) -> bool {
        let felt = cutoff(&self.shape) * self.lichen.radius + margin;
        self.nearness.within(place, felt)
    }

    /// What asks, with scratch space for the answers: one for each thread. What is narrower than
    /// `blur`, local units, is not told apart.
    pub(crate) fn probe(&self, blur: f32) -> Probe<'_> {
        let last = last(self.lichen.granules.len());
        let dress = |cortex| Dress {
            cortex,
            paint: &self.paint,
            last,
            blur,
        };
        Probe {
            dress: self.cortex.as_ref().map(dress),
            field: Field::new(self.substrate, &self.lichen, &self.grid, &self.shape),
            sheet: Sheet::new(self.substrate, self.lichen.radius),
        }
    }
}

/// Asks a relief.
pub(crate) struct Probe<'a> {
    field: Field<'a>,
    dress: Option<Dress<'a>>,
    sheet: Sheet<'a>,
}

impl Probe<'_> {
    /// What the field says about a place, with areoles and apothecia.
    pub(crate) fn sample(&mut self, at: &SurfacePoint) -> Sample {
        let substrate = self.field.substrate;
        let facing = substrate.normal(at.triangle).as_vec3();
        let place = substrate.position(at);
        let bare = self
            .field
            .sample(place, at.triangle, facing, &mut self.sheet);
        match self.dress {
            Some(dress) if bare.is_near_lichen() => dress.sample(place, &bare),
            _ => bare,
        }
    }
}
