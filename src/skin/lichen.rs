//! The elements as the skin needs them: with the surface's normal, the density about them and their
//! distance from the rim.

use glam::{DVec3, Vec3};
use rayon::prelude::*;

use super::borders::Borders;
use super::cortex::Cortex;
use super::grid::Grid;
use super::{Paint, last};
use crate::cluster::{Cluster, Element};
use crate::color::to_byte;
use crate::morphometry::{
    LOOK, Neighbours, density, is_rim, is_rim_where, rim_distance, smooth_normals,
};
use crate::substrate::{Substrate, SurfacePoint};

/// Narrower holes in a lichen have no margin, in element radii: the dark line of a prothallus runs ahead of a lichen,
/// not about every pinhole.
pub(super) const HOLE: f64 = 16.0;

/// How far from there the rim still counts, in element radii: such a disc leaves out the small bays of an outline.
pub(super) const BESIDE: f32 = 8.0;

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
    /// See [`density`]; of the surface that is there.
    pub(super) density: f32,
    /// See [`rim_distance`], in element radii; the mesh's diagonal where no rim can be reached.
    pub(super) rim: f32,
    /// The same from the outline, where a margin is drawn by it: that is the rim [`BESIDE`] places where a disc as wide
    /// as a [`HOLE`] can touch.
    pub(super) outline: f32,
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
    /// Measured as it is now, all of it there, as far as this paint shows it.
    pub(super) fn new(substrate: &Substrate, cluster: &Cluster, paint: &Paint) -> Self {
        let mut lichen = Self::unmeasured(substrate, cluster);
        let borders = lichen.borders(substrate);
        lichen.measure(far(substrate), paint.prothallus.is_some(), &borders);
        lichen
    }

    /// Without density and distance from the rim, in birth order.
    pub(super) fn unmeasured(substrate: &Substrate, cluster: &Cluster) -> Self {
        let elements = cluster.elements();
        let places: Vec<SurfacePoint> = elements.iter().map(|e| e.at).collect();
        let normals = smooth_normals(substrate, &places);
        let granule = |(birth, (e, normal)): (usize, (&Element, &DVec3))| Granule {
            position: e.position,
            normal: normal.as_vec3(),
            home: e.at.triangle,
            birth: birth as u32,
            colony: e.colony,
            density: 0.0,
            rim: 0.0,
            outline: 0.0,
            influence: 1.0,
        };
        let granules = elements.iter().zip(&normals).enumerate();
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
            let light = paint.light(g.density, g.birth as f32 / last, g.outline);
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

    /// Fills in density and distances from the rim, `far` where there is none.
    fn measure(&mut self, far: f64, has_margin: bool, borders: &Borders) {
        let neighbours = self.neighbours(LOOK);
        let density = density(self.radius, &neighbours);
        let radius = self.radius;
        let in_radii = |way: Option<f64>| (way.unwrap_or(far) / radius) as f32;
        let is_rim_at = is_rim(&neighbours);
        let rim = rim_distance(&is_rim_at, &neighbours);
        let outline = || {
            let outermost = is_rim_where(
                &self.neighbours(HOLE),
                |i| is_rim_at[i],
                |i| self.closed(i, borders),
            );
            let outermost = rim_distance(&outermost, &neighbours);
            let beside = |way: Option<f64>| way.is_some_and(|way| ((way / radius) as f32) < BESIDE);
            let both = std::iter::zip(&is_rim_at, outermost);
            let outline: Vec<bool> = both.map(|(rim, way)| *rim && beside(way)).collect();
            rim_distance(&outline, &neighbours)
        };
        let outline = has_margin.then(outline);
        let shares = self.shares(borders);
        for (i, granule) in self.granules.iter_mut().enumerate() {
            granule.density = density[i] as f32 / shares[i];
            granule.rim = in_radii(rim[i]);
            granule.outline = outline.as_ref().map_or(0.0, |outline| in_radii(outline[i]));
        }
    }

    /// Borders near it.
    pub(super) fn borders(&self, substrate: &Substrate) -> Borders {
        let places: Vec<DVec3> = self.granules.iter().map(|g| g.position).collect();
        Borders::new(substrate, &places, 0.5 * HOLE * self.radius)
    }

    /// The directions in which borders close in an element.
    pub(super) fn closed(&self, i: usize, borders: &Borders) -> Vec<[DVec3; 2]> {
        borders.closed(self.granules[i].position, self.granules[i].normal)
    }

    /// For each element the share of the surface about it that is there.
    pub(super) fn shares(&self, borders: &Borders) -> Vec<f32> {
        let reach = LOOK * self.radius;
        let share = |g: &Granule| borders.share(g.position, g.normal, reach) as f32;
        self.granules.par_iter().map(share).collect()
    }

    /// Who stands within so many radii of whom, by place in the list.
    pub(super) fn neighbours(&self, within: f64) -> Neighbours {
        let positions: Vec<_> = self
            .granules
            .iter()
            .map(|g| g.position.to_array())
            .collect();
        let normals: Vec<_> = self.granules.iter().map(|g| g.normal.to_array()).collect();
        Neighbours::new(&positions, &normals, within * self.radius)
    }
}

/// What stands for the distance from the rim where there is none: the mesh's diagonal, local units.
pub(super) fn far(substrate: &Substrate) -> f64 {
    substrate.units().local_diagonal()
}

#[cfg(test)]
pub(super) mod tests {
    use std::path::Path;

    use super::*;
    use crate::substrate::Soup;

    /// Elements of radius 1, packed hexagonally on a plane where there are to be some, from the origin outwards.
    pub(in crate::skin) fn packed(is_lichen: impl Fn(DVec3) -> bool) -> Lichen {
        let place = |row: i32, column: i32| {
            let (row, column) = (f64::from(row), f64::from(2 * column + (row & 1)));
            DVec3::new(column, row * 3f64.sqrt(), 0.0)
        };
        let rows = (-60..=60).flat_map(|row| (-60..=60).map(move |column| place(row, column)));
        let mut places: Vec<DVec3> = rows.filter(|p| is_lichen(*p)).collect();
        places.sort_by(|a, b| a.length().total_cmp(&b.length()));
        let granule = |(birth, position)| Granule {
            position,
            normal: Vec3::Z,
            home: 0,
            birth,
            colony: 0,
            density: 0.0,
            rim: 0.0,
            outline: 0.0,
            influence: 1.0,
        };
        Lichen {
            radius: 1.0,
            granules: (0..).zip(places).map(granule).collect(),
        }
    }

    /// A board in the plane z = 0 from y = 0 to so much, whose borders there are of edges so long.
    fn board(width: f64, length: f64) -> Substrate {
        let count = (1000.0 / length) as u32;
        let column = |i: u32| {
            let x = length * f64::from(i) - 500.0;
            [[x, 0.0, 0.0], [x, width, 0.0]]
        };
        let square = |i: u32| [[2 * i, 2 * i + 2, 2 * i + 3], [2 * i, 2 * i + 3, 2 * i + 1]];
        let soup = Soup {
            positions: (0..=count).flat_map(column).collect(),
            triangles: (0..count).flat_map(square).collect(),
            notes: Vec::new(),
        };
        Substrate::from_soup(soup).expect("a board")
    }

    /// Measured on a board, with a margin.
    fn measured(substrate: &Substrate, is_lichen: impl Fn(DVec3) -> bool) -> Lichen {
        let units = substrate.units();
        let mut lichen = packed(is_lichen);
        for granule in &mut lichen.granules {
            granule.position = units.to_local(granule.position.to_array());
        }
        lichen.radius = units.length_to_local(1.0);
        let borders = lichen.borders(substrate);
        lichen.measure(1e3 * lichen.radius, true, &borders);
        lichen
    }

    pub(in crate::skin) fn no_borders() -> Borders {
        let closed = Substrate::load(Path::new("meshes/rock.obj")).expect("a mesh");
        packed(|p| p.length() < 3.0).borders(&closed)
    }

    /// Half a disc, cut off by the border: the outline is the arc, however the border is divided.
    #[test]
    fn where_the_surface_ends_there_is_no_outline() {
        for length in [500.0, 20.0, 1.0] {
            let substrate = board(900.0, length);
            let lichen = measured(&substrate, |p| p.length() < 60.0 && p.y > 0.5);
            let (mut at_border, mut at_arc) = (0, 0);
            for granule in &lichen.granules {
                let p = substrate.units().to_file(granule.position);
                let arc = (60.0 - p.length()) as f32;
                // It goes on along the border for as far as the rim counts that is beside it.
                let error = granule.outline - arc;
                assert!((-BESIDE..5.0).contains(&error), "{p}: {error}");
                if arc > 9.0 {
                    let density = granule.density;
                    assert!((0.75..1.08).contains(&density), "{p}: {density}");
                }
                at_border += usize::from(granule.rim < 1.0 && granule.outline > 10.0);
                at_arc += usize::from(granule.outline == 0.0);
            }
            assert!(at_border > 20 && at_arc > 50, "{at_border}, {at_arc}");
        }
    }

    /// Lichen all over a narrow strip: the outline is at its ends.
    #[test]
    fn a_narrow_strip_has_its_outline_at_the_ends() {
        for length in [500.0, 20.0, 1.0] {
            let substrate = board(9.0, length);
            let lichen = measured(&substrate, |p| {
                p.x.abs() < 50.0 && (0.5..8.8).contains(&p.y)
            });
            for granule in &lichen.granules {
                let p = substrate.units().to_file(granule.position);
                let error = granule.outline - (50.0 - p.x.abs()) as f32;
                assert!((-BESIDE..5.0).contains(&error), "{p}: {error}");
            }
        }
    }

    #[test]
    fn narrow_holes_have_a_rim_and_are_no_outline() {
        let (narrow, wide) = (DVec3::new(22.0, 5.0, 0.0), DVec3::new(-20.0, 0.0, 0.0));
        let mut lichen =
            packed(|p| p.length() < 60.0 && p.distance(narrow) > 6.0 && p.distance(wide) > 14.0);
        lichen.measure(1e3, true, &no_borders());
        for granule in &lichen.granules {
            let from = |hole: DVec3, radius: f64| granule.position.distance(hole) - radius;
            let outside = (60.0 - granule.position.length()).min(from(wide, 14.0)) as f32;
            let nearest = outside.min(from(narrow, 6.0) as f32);
            let [rim, outline] = [granule.rim - nearest, granule.outline - outside].map(f32::abs);
            // Ways go from element to element, and end on the outermost.
            assert!(
                rim < 3.5 && outline < 4.5,
                "{:?}: {rim}, {outline}",
                granule.position
            );
        }
        lichen.measure(1e3, false, &no_borders());
        assert!(lichen.granules.iter().all(|g| g.outline == 0.0));
    }
}
