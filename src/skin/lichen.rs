//! The elements as the skin needs them: with the surface's normal, the density about them and their
//! distance from the rim.

use std::f64::consts::PI;

use glam::{DVec3, Vec3};
use rayon::prelude::*;

use super::base::Winding;
use super::grid::Grid;
use super::rim::rim_distances;
use super::sheet::Sheet;
use crate::cluster::{Cluster, Element};
use crate::substrate::Substrate;

/// Radius in which elements are counted for the local density, in element radii.
const DENSITY_RADIUS: f64 = 6.0;

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
    /// Elements about it, as a share of what fits in densest packing.
    pub(super) density: f32,
    /// Distance from the outermost elements along the lichen, in element radii.
    pub(super) rim: f32,
}

/// All elements, kept in an order that follows space.
pub(super) struct Lichen {
    /// Element radius, local units.
    pub(super) radius: f64,
    pub(super) granules: Vec<Granule>,
}

impl Lichen {
    pub(super) fn new(substrate: &Substrate, winding: &Winding, cluster: &Cluster) -> Self {
        let radius = cluster.radius();
        let elements = cluster.elements();
        let places: Vec<DVec3> = elements.iter().map(|e| e.position).collect();
        let (grid, order) = Grid::new(&places, DENSITY_RADIUS * radius);
        let granule = |&birth: &u32| {
            let e = &elements[birth as usize];
            Granule {
                position: e.position,
                normal: smooth_normal(substrate, winding, e),
                home: e.at.triangle,
                birth,
                colony: e.colony,
                density: 0.0,
                rim: 0.0,
            }
        };
        let granules = order.par_iter().map(granule).collect();
        let mut lichen = Self { radius, granules };
        lichen.measure(substrate, &grid);
        lichen
    }

    /// Sorts the elements for questions of at most `reach`.
    pub(super) fn sort(&mut self, reach: f64) -> Grid {
        let places: Vec<DVec3> = self.granules.iter().map(|g| g.position).collect();
        let (grid, order) = Grid::new(&places, reach);
        let granules = order.iter().map(|&i| self.granules[i as usize]);
        self.granules = granules.collect();
        grid
    }

    /// Fills in density and distance from the rim.
    fn measure(&mut self, substrate: &Substrate, grid: &Grid) {
        let limit = (DENSITY_RADIUS * self.radius).powi(2);
        let packed = PI * DENSITY_RADIUS * DENSITY_RADIUS / (2.0 * 3f64.sqrt());
        let granules = &self.granules;
        let sheet = || Sheet::new(substrate, self.radius);
        let count = |sheet: &mut Sheet, g: &Granule| {
            let near = grid.around(g.position).flat_map(|run| &granules[run]);
            let near = near.filter(|o| (o.position - g.position).length_squared() <= limit);
            let around = near.filter(|o| sheet.joins(g.position, g.normal, g.home, o));
            (around.count() as f64 / packed) as f32
        };
        let density: Vec<f32> = granules.par_iter().map_init(sheet, count).collect();
        let rim = rim_distances(substrate, self.radius, granules, grid);
        for (granule, (density, rim)) in self.granules.iter_mut().zip(density.iter().zip(&rim)) {
            (granule.density, granule.rim) = (*density, *rim);
        }
    }
}

/// Cosine of the angle between faces beyond which an edge stays sharp: 40°.
const CREASE: f64 = 0.766;

/// Faces looked at around a vertex, at most: bounds the work at the hub of a huge fan.
const AROUND: usize = 64;

/// The mean of the normals at the triangle's corners, by the element's weights.
fn smooth_normal(substrate: &Substrate, winding: &Winding, element: &Element) -> Vec3 {
    let home = element.at.triangle;
    let own = winding.normal(substrate, home);
    let corners = substrate.triangles()[home as usize];
    let weighted = corners.iter().zip(element.at.weights());
    let sum: DVec3 = weighted
        .map(|(&vertex, weight)| corner_normal(substrate, winding, own, vertex) * weight)
        .sum();
    sum.try_normalize().unwrap_or(own).as_vec3()
}

/// The mean by area of the faces at a vertex that are within the crease angle of one of them.
fn corner_normal(substrate: &Substrate, winding: &Winding, own: DVec3, vertex: u32) -> DVec3 {
    let around = substrate.half_edges_at(vertex).iter().take(AROUND);
    let sum: DVec3 = around
        .map(|h| (h / 3, winding.normal(substrate, h / 3)))
        .filter(|(_, normal)| normal.dot(own) > CREASE)
        .map(|(t, normal)| normal * substrate.area(t))
        .sum();
    sum.try_normalize().unwrap_or(own)
}
