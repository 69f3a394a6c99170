//! A table's elements found again on the mesh that they grew on.

use std::borrow::Cow;

use glam::{DVec3, Vec3};
use rayon::prelude::*;

use super::{Elements, LENGTHS, TableError};
use crate::cluster::{Cluster, Element, LEAST_RADIUS, NO_PARENT};
use crate::substrate::{Substrate, SurfacePoint, UpAxis};

/// Elements that do not lie on a mesh.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum NotOnMesh {
    /// One is elsewhere.
    #[error(
        "element {element} is not on this mesh ({problem}): name the mesh that the lichen grew on, as \
         it was then"
    )]
    Element {
        /// Birth index of the first one.
        element: usize,
        /// What is wrong.
        problem: String,
    },
    /// Of a table that is not sound no element is anywhere.
    #[error(transparent)]
    Table(#[from] TableError),
}

/// How far the table's rounding may move an element, in radii.
const TOLERANCE: f64 = 0.05;

impl Elements {
    /// Where on the substrate each element is: by the stored triangle and weights if these give all stored positions,
    /// otherwise all by their positions, as on a mesh whose triangles were put in another order or cut in another way.
    ///
    /// # Errors
    /// When the table [is not sound](Self::check); when an element is farther than a twentieth of the radius from the
    /// surface that looks its way, beyond what float32 rounds; when no run on this mesh could have elements of their
    /// radius.
    pub fn places_on(&self, substrate: &Substrate) -> Result<Vec<SurfacePoint>, NotOnMesh> {
        self.check()?;
        self.check_radius(substrate)?;
        let places = self.places_by_number(substrate);
        places.map_or_else(|| self.places_by_position(substrate), Ok)
    }

    fn places_by_number(&self, substrate: &Substrate) -> Option<Vec<SurfacePoint>> {
        let triangles = substrate.triangles().len() as u32;
        let is_fine = self.has_fine_positions();
        let mut inner = vec![0; triangles as usize];
        (0..triangles).for_each(|t| inner[substrate.canonical_triangle(t) as usize] = t);
        let place = |i: usize| {
            let triangle = *inner.get(self.triangle[i] as usize)?;
            let [u, v] = self.uv[i].map(f64::from);
            let place = SurfacePoint { triangle, u, v };
            let off = self.distance(substrate, i, &place);
            let is_there = off <= self.tolerance(substrate, i, &place);
            is_there.then(|| match is_fine {
                true => substrate.nearest_in(triangle, self.local(substrate, i)),
                false => place,
            })
        };
        (0..self.len()).map(place).collect()
    }

    fn places_by_position(&self, substrate: &Substrate) -> Result<Vec<SurfacePoint>, NotOnMesh> {
        let place = |i: usize| {
            let position = self.local(substrate, i);
            let normal = Vec3::from(self.normals[i]).as_dvec3();
            let place = substrate.nearest_facing(position, normal, f64::INFINITY);
            let off = place.map(|place| self.distance(substrate, i, &place));
            let problem = match (place, off) {
                (Some(place), Some(off)) if off <= self.tolerance(substrate, i, &place) => {
                    return Ok(place);
                }
                (_, Some(off)) => format!("it is {off:.3e} away from it"),
                _ => "none of it looks that way".to_owned(),
            };
            let element = i;
            Err(NotOnMesh::Element { element, problem })
        };
        let found: Vec<_> = (0..self.len()).into_par_iter().map(place).collect();
        found.into_iter().collect()
    }

    /// The cluster that this is the table of, on the mesh that it grew on.
    ///
    /// Elements are where triangle and weights say, which files hold with 24 bits; in the triangle nearest to their
    /// positions where these have more; or [nearest to them anywhere](Self::places_on).
    ///
    /// # Errors
    /// Those of [`places_on`](Self::places_on); and [`TableError::Radius`] of an empty table without a radius, as files
    /// without rows give it.
    pub fn to_cluster(&self, substrate: &Substrate) -> Result<Cluster, NotOnMesh> {
        let places = self.places_on(substrate)?;
        self.cluster_at(substrate, places)
    }

    fn cluster_at(
        &self,
        substrate: &Substrate,
        places: Vec<SurfacePoint>,
    ) -> Result<Cluster, NotOnMesh> {
        if !LENGTHS.contains(&self.radius) {
            return Err(TableError::Radius.into());
        }
        let radius = substrate.units().length_to_local(self.radius);
        let mut cluster = Cluster::new(radius);
        for (i, at) in places.into_iter().enumerate() {
            cluster.push(Element {
                at,
                position: substrate.position(&at),
                parent: u32::try_from(self.parent[i]).unwrap_or(NO_PARENT),
                colony: self.colony[i],
                probability: f64::from(self.probability[i]),
            });
        }
        Ok(cluster)
    }

    /// The cluster that these elements are on a mesh that a program may have turned since, from z up to y up or back,
    /// as many exporters do; and whether one has.
    ///
    /// # Errors
    /// Those of [`to_cluster`](Self::to_cluster), of the mesh as it is.
    pub fn to_cluster_on_turned(
        &self,
        substrate: &Substrate,
    ) -> Result<(Cluster, bool), NotOnMesh> {
        let (table, places) = self.on_turned(substrate)?;
        let is_turned = matches!(table, Cow::Owned(_));
        Ok((table.cluster_at(substrate, places)?, is_turned))
    }

    /// The table on such a mesh, turned as that is where it is, and where each element is there.
    ///
    /// # Errors
    /// Those of [`places_on`](Self::places_on), of the mesh as it is.
    pub fn on_turned(
        &self,
        substrate: &Substrate,
    ) -> Result<(Cow<'_, Self>, Vec<SurfacePoint>), NotOnMesh> {
        self.check()?;
        self.check_radius(substrate)?;
        let turned = || [UpAxis::Y, UpAxis::Z].map(|up| self.turned(up));
        // A ball lies on itself however it is turned: numbers know better than positions.
        if let Some(places) = self.places_by_number(substrate) {
            return Ok((Cow::Borrowed(self), places));
        }
        for table in turned() {
            if let Some(places) = table.places_by_number(substrate) {
                return Ok((Cow::Owned(table), places));
            }
        }
        let problem = match self.places_by_position(substrate) {
            Ok(places) => return Ok((Cow::Borrowed(self), places)),
            Err(problem) => problem,
        };
        for table in turned() {
            if let Ok(places) = table.places_by_position(substrate) {
                return Ok((Cow::Owned(table), places));
            }
        }
        Err(problem)
    }

    /// Elements whose up axis becomes this one, from the other.
    fn turned(&self, up: UpAxis) -> Self {
        let turn = |[x, y, z]: [f64; 3]| match up {
            UpAxis::Y => [x, z, -y],
            UpAxis::Z => [x, -z, y],
        };
        let normal = |normal: &[f32; 3]| turn(normal.map(f64::from)).map(|x| x as f32);
        Self {
            positions: self.positions.iter().map(|p| turn(*p)).collect(),
            normals: self.normals.iter().map(normal).collect(),
            ..self.clone()
        }
    }

    /// Refuses a radius with which nothing grows on this mesh, as of a table in other units.
    fn check_radius(&self, substrate: &Substrate) -> Result<(), NotOnMesh> {
        let (radius, diagonal) = (self.radius, substrate.units().diagonal());
        let grows = (LEAST_RADIUS * diagonal..=diagonal).contains(&radius);
        match grows || self.is_empty() {
            true => Ok(()),
            false => Err(NotOnMesh::Element {
                element: 0,
                problem: format!("its radius is {radius:e}, and the mesh {diagonal:e} across"),
            }),
        }
    }

    /// Whether positions have more bits than weights, as where triangles are very much larger than elements.
    fn has_fine_positions(&self) -> bool {
        let is_single = |x: &f64| f64::from(*x as f32) == *x;
        !self.positions.iter().flatten().all(is_single)
    }

    fn local(&self, substrate: &Substrate, i: usize) -> DVec3 {
        substrate.units().to_local(self.positions[i])
    }

    fn distance(&self, substrate: &Substrate, i: usize, place: &SurfacePoint) -> f64 {
        let there = substrate.units().to_file(substrate.position(place));
        (there - DVec3::from(self.positions[i])).length()
    }

    /// Weights and positions are float32, the latter unless they are far from the origin. Then they are float64,
    /// and in the file's units even that may be coarse beside the radius.
    fn tolerance(&self, substrate: &Substrate, i: usize, place: &SurfacePoint) -> f64 {
        let [a, b, c] = substrate.corners(place.triangle);
        let edge = (b - a).length().max((c - a).length());
        let edge = substrate.units().length_to_file(edge);
        let from_origin = DVec3::from(self.positions[i]).abs().max_element();
        TOLERANCE * self.radius + f64::from(f32::EPSILON) * edge + 2.0 * f64::EPSILON * from_origin
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::substrate::Soup;

    /// Weights of 24 bits in a triangle of a million radii are a seventeenth of the radius apart.
    #[test]
    fn in_huge_triangles_elements_are_where_their_positions_say() {
        let soup = Soup {
            positions: vec![[0.0; 3], [1e6, 0.0, 0.0], [0.0, 1e6, 0.0]],
            triangles: vec![[0, 1, 2]],
            ..Soup::default()
        };
        let substrate = Substrate::from_soup(soup).expect("a mesh");
        let radius = substrate.units().length_to_local(1.0);
        let mut cluster = Cluster::new(radius);
        for i in 0..1000 {
            let [u, v] = [0.3 + f64::from(i) * 2e-6, 0.6 - f64::from(i) * 1.1e-6];
            let at = SurfacePoint { triangle: 0, u, v };
            cluster.push(Element::seed(&substrate, at));
        }
        let again = Elements::of(&substrate, &cluster).to_cluster(&substrate);
        let again = again.expect("the same mesh");
        for (a, b) in std::iter::zip(cluster.elements(), again.elements()) {
            assert!(a.position.distance(b.position) < 1e-6 * radius);
        }
    }

    /// A hundred-thousandth across and five million from the origin, where float64 is a fifth of the radius apart.
    #[test]
    fn a_speck_far_from_its_origin_has_the_elements_that_grew_on_it() {
        let far = |x: f64, y: f64| [x * 1e-5, y * 1e-5 - 1e5, 5e6 + (x - y) * 1e-5];
        let soup = Soup {
            positions: vec![far(0.1, 0.0), far(1.0, 0.3), far(0.2, 0.9)],
            triangles: vec![[0, 1, 2]],
            ..Soup::default()
        };
        let substrate = Substrate::from_soup(soup).expect("a mesh");
        let radius = substrate.units().length_to_local(5e-9);
        let mut cluster = Cluster::new(radius);
        for i in 0..10_000 {
            let [u, v] = [0.5 + f64::from(i) * 1.1e-5, 0.3 - f64::from(i) * 2.3e-5];
            cluster.push(Element::seed(
                &substrate,
                SurfacePoint { triangle: 0, u, v },
            ));
        }
        let elements = Elements::of(&substrate, &cluster);
        assert_eq!(elements.places_on(&substrate).map(|p| p.len()), Ok(10_000));
    }

    #[test]
    fn a_mesh_that_was_turned_has_the_elements_that_grew_on_it() {
        let corners = [[0.1, 0.0, 0.3], [1.0, 0.3, 0.7], [0.2, 0.9, -0.4]];
        let mesh = |turn: fn([f64; 3]) -> [f64; 3]| {
            let soup = Soup {
                positions: corners.map(turn).to_vec(),
                triangles: vec![[0, 1, 2]],
                ..Soup::default()
            };
            Substrate::from_soup(soup).expect("a mesh")
        };
        let grown_on = mesh(|p| p);
        let mut cluster = Cluster::new(grown_on.units().length_to_local(0.01));
        let at = SurfacePoint {
            triangle: 0,
            u: 0.6,
            v: 0.1,
        };
        cluster.push(Element::seed(&grown_on, at));
        let elements = Elements::of(&grown_on, &cluster);
        let to_y_up = mesh(|[x, y, z]| [x, z, -y]);
        let to_z_up = mesh(|[x, y, z]| [x, -z, y]);
        for turned in [&to_y_up, &to_z_up] {
            assert!(elements.to_cluster(turned).is_err());
            let (found, is_turned) = elements.to_cluster_on_turned(turned).expect("fits");
            assert!(is_turned);
            let off = turned.position(&at).distance(found.elements()[0].position);
            assert!(off < 1e-6, "{off}");
        }
        let as_grown = elements.to_cluster_on_turned(&grown_on);
        assert!(as_grown.is_ok_and(|(_, is_turned)| !is_turned));
        let other = mesh(|[x, y, z]| [-x, y, z]);
        assert!(elements.to_cluster_on_turned(&other).is_err());
    }

    /// As programs leave a mesh: triangles in another order, corners too, and one cut into two. Of two faces in one
    /// place an element stays on its own.
    #[test]
    fn a_mesh_with_other_triangles_has_the_elements_that_grew_on_it() {
        let mesh = |positions: &[[f64; 3]], triangles: &[[u32; 3]]| {
            let soup = Soup {
                positions: positions.to_vec(),
                triangles: triangles.to_vec(),
                ..Soup::default()
            };
            Substrate::from_soup(soup).expect("a mesh")
        };
        let square = [
            [0.0, 0.0, 0.0],
            [1.0, 0.0, 0.0],
            [1.0, 1.0, 0.0],
            [0.0, 1.0, 0.0],
        ];
        let beneath = square.map(|[x, y, z]| [x, y, z - 1e-4]);
        let middle = [0.5, 0.0, 0.0];
        let corners = [&square[..], &beneath, &[middle]].concat();
        let grown_on = mesh(&corners, &[[0, 1, 2], [0, 2, 3], [4, 6, 5], [4, 7, 6]]);
        let other = mesh(
            &corners,
            &[[7, 6, 4], [6, 5, 4], [3, 0, 2], [8, 2, 0], [2, 8, 1]],
        );
        let mut cluster = Cluster::new(grown_on.units().length_to_local(0.01));
        for triangle in 0..4 {
            let (u, v) = (0.3, 0.2);
            cluster.push(Element::seed(&grown_on, SurfacePoint { triangle, u, v }));
        }
        let elements = Elements::of(&grown_on, &cluster);
        let found = elements.to_cluster(&other).expect("the same surface");
        for (before, after) in cluster.elements().iter().zip(found.elements()) {
            assert!(before.position.distance(after.position) < 1e-5);
            let sides =
                [(&grown_on, before), (&other, after)].map(|(mesh, e)| mesh.normal(e.at.triangle));
            assert!(sides[0].dot(sides[1]) > 0.99);
        }
        let lifted = mesh(
            &corners
                .iter()
                .map(|[x, y, z]| [*x, *y, z * x])
                .collect::<Vec<_>>(),
            &[[0, 1, 2]],
        );
        assert!(elements.to_cluster(&lifted).is_err());
    }

    #[test]
    fn radii_that_fit_no_run_on_the_mesh_are_refused() {
        let substrate = Substrate::load(Path::new("meshes/plane.obj")).expect("a mesh");
        let (at, _) = substrate.nearest(DVec3::ZERO);
        let mut cluster = Cluster::new(0.01);
        cluster.push(Element::seed(&substrate, at));
        let elements = Elements::of(&substrate, &cluster);
        assert_eq!(elements.places_on(&substrate), Ok(vec![at]));
        for radius in [1e-30, 1e30] {
            let other = Elements {
                radius,
                ..elements.clone()
            };
            let refused = other.places_on(&substrate).expect_err("no lichen");
            let expected = format!("radius is {radius:e}");
            assert!(refused.to_string().contains(&expected), "{refused}");
        }
    }
}
