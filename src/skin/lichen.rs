//! The elements as the skin needs them: with the surface's normal, the density about them and their
//! distance from the rim.

use glam::{DVec3, Vec3};
use rayon::prelude::*;

use super::base::Winding;
use super::cortex::Cortex;
use super::grid::Grid;
use super::{Paint, last};
use crate::cluster::{Cluster, Element};
use crate::color::to_byte;
use crate::morphometry::{Neighbours, density, is_rim, rim_distance, smooth_normals};
use crate::substrate::{Substrate, SurfacePoint};

/// How far density and rim are looked for, in element radii: narrower gaps are inside the lichen.
pub(super) const LOOK: f64 = 6.0;

/// One element.
#[derive(Clone, Copy, Debug)]
pub(super) struct Granule {
    pub(super) position: DVec3,
    /// The surface's, smoothed over blunt edges.
    pub(super) normal: Vec3,
    /// The substrate's triangle that it is on.
    pub(super) home: u32,
    pub(super) birth: u32,
    pub(super) colony: u32,
    /// See [`density`].
    pub(super) density: f32,
    /// See [`rim_distance`], in element radii; the mesh's diagonal where no rim can be reached.
    pub(super) rim: f32,
    /// How much of it is there, 0 to 1.
    pub(super) influence: f32,
}

/// All elements, kept in an order that follows space.
pub(super) struct Lichen {
    /// Element radius, local units.
    pub(super) radius: f64,
    pub(super) granules: Vec<Granule>,
}

impl Lichen {
    /// Measured as it is now, all of it there.
    pub(super) fn new(substrate: &Substrate, winding: &Winding, cluster: &Cluster) -> Self {
        let mut lichen = Self::unmeasured(substrate, winding, cluster);
        lichen.measure(far(substrate));
        lichen
    }

    /// Without density and distance from the rim, in birth order.
    pub(super) fn unmeasured(substrate: &Substrate, winding: &Winding, cluster: &Cluster) -> Self {
        let elements = cluster.elements();
        let places: Vec<SurfacePoint> = elements.iter().map(|e| e.at).collect();
        let outwards = |(normal, place): (DVec3, &SurfacePoint)| {
            let side = winding.side(place.triangle);
            (side * normal).as_vec3()
        };
        let normals = smooth_normals(substrate, &places).into_iter().zip(&places);
        let granule = |(birth, (e, normal)): (usize, (&Element, Vec3))| Granule {
            position: e.position,
            normal,
            home: e.at.triangle,
            birth: birth as u32,
            colony: e.colony,
            density: 0.0,
            rim: 0.0,
            influence: 1.0,
        };
        let granules = elements.iter().zip(normals.map(outwards)).enumerate();
        Self {
            radius: cluster.radius(),
            granules: granules.map(granule).collect(),
        }
    }

    /// The colour of each element, in birth order, before it is sorted.
    pub(super) fn colors(&self, paint: &Paint) -> Vec<[u8; 3]> {
        let last = last(self.granules.len());
        let cortex = Cortex::new(self, paint, 0.0);
        let color = |g: &Granule| {
            let light = paint.light(g.density, g.birth as f32 / last, g.rim);
            let detail = |cortex: &Cortex| {
                let (place, normal) = (g.position.to_array(), g.normal.to_array());
                cortex.at(place, normal, self.radius as f32)
            };
            let detail = cortex.as_ref().map(detail);
            detail.map_or(light, |d| d.over(light)).map(to_byte)
        };
        self.granules.par_iter().map(color).collect()
    }

    /// Sorts the elements for questions of at most `reach`.
    pub(super) fn sort(&mut self, reach: f64) -> Grid {
        let places: Vec<DVec3> = self.granules.iter().map(|g| g.position).collect();
        let (grid, order) = Grid::new(&places, reach);
        let granules = order.iter().map(|&i| self.granules[i as usize]);
        self.granules = granules.collect();
        grid
    }

    /// Fills in density and distance from the rim, `far` where there is none.
    fn measure(&mut self, far: f64) {
        let neighbours = self.neighbours();
        let density = density(self.radius, &neighbours);
        let rim = rim_distance(&is_rim(&neighbours), &neighbours);
        for (granule, (density, rim)) in self.granules.iter_mut().zip(density.iter().zip(&rim)) {
            granule.density = *density as f32;
            granule.rim = (rim.unwrap_or(far) / self.radius) as f32;
        }
    }

    /// Who stands near whom, by place in the list.
    pub(super) fn neighbours(&self) -> Neighbours {
        let positions: Vec<_> = self
            .granules
            .iter()
            .map(|g| g.position.to_array())
            .collect();
        let normals: Vec<_> = self.granules.iter().map(|g| g.normal.to_array()).collect();
        Neighbours::new(&positions, &normals, LOOK * self.radius)
    }
}

/// What stands for the distance from the rim where there is none: the mesh's diagonal, local units.
pub(super) fn far(substrate: &Substrate) -> f64 {
    let units = substrate.units();
    units.length_to_local(units.diagonal())
}
