//! The growing cluster: element lists in the triangles, and the same elements in boxes.

use super::mesh::{Mesh, Place};
use super::nearby::nearby_sets;
use super::{Params, Search};
use glam::DVec3;
use std::collections::HashMap;

/// Which of a triangle's nearby sets to look in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Within {
    /// Elements that a walker on the triangle can touch (q + 2r).
    Contact,
    /// Elements that count for its density (q + L).
    Density,
}

/// Elements of one cube of space and the box around their centres.
#[derive(Clone, Debug)]
struct Cell {
    low: DVec3,
    high: DVec3,
    elements: Vec<usize>,
}

impl Cell {
    fn distance_squared(&self, p: DVec3) -> f64 {
        p.distance_squared(p.clamp(self.low, self.high))
    }
}

/// Elements so far, with everything that the walk asks of them.
pub(crate) struct Cluster<'a> {
    pub(crate) mesh: &'a Mesh,
    pub(crate) radius: f64,
    pub(crate) places: Vec<Place>,
    pub(crate) positions: Vec<DVec3>,
    pub(crate) centroid: DVec3,
    /// R_e: distance from the centroid to the farthest centre.
    pub(crate) reach: f64,
    search: Search,
    contact_sets: Vec<Vec<usize>>,
    density_sets: Vec<Vec<usize>>,
    lists: Vec<Vec<usize>>,
    cells: Vec<Cell>,
    cell_of: HashMap<[i64; 3], usize>,
    sum: DVec3,
}

impl<'a> Cluster<'a> {
    pub(crate) fn new(mesh: &'a Mesh, params: &Params) -> Self {
        Self {
            mesh,
            radius: params.radius,
            places: Vec::new(),
            positions: Vec::new(),
            centroid: DVec3::ZERO,
            reach: 0.0,
            search: params.search,
            contact_sets: nearby_sets(mesh, 2.0 * params.radius),
            density_sets: nearby_sets(mesh, params.curvature_radius),
            lists: vec![Vec::new(); mesh.triangles.len()],
            cells: Vec::new(),
            cell_of: HashMap::new(),
            sum: DVec3::ZERO,
        }
    }

    /// Adds an element; centroid and effective radius are computed anew from all elements.
    pub(crate) fn push(&mut self, place: Place) {
        let p = self.mesh.lift(place);
        let index = self.positions.len();
        self.places.push(place);
        self.positions.push(p);
        self.lists[place.triangle].push(index);
        self.push_to_cell(p, index);
        self.sum += p;
        self.centroid = self.sum / self.positions.len() as f64;
        let far = self
            .positions
            .iter()
            .map(|q| q.distance_squared(self.centroid));
        self.reach = far.fold(0.0, f64::max).sqrt();
    }

    fn push_to_cell(&mut self, p: DVec3, index: usize) {
        let size = 16.0 * self.radius;
        let key = (p / size).floor().to_array().map(|x| x as i64);
        let slot = *self.cell_of.entry(key).or_insert(self.cells.len());
        if slot == self.cells.len() {
            self.cells.push(Cell {
                low: p,
                high: p,
                elements: Vec::new(),
            });
        }
        let cell = &mut self.cells[slot];
        cell.low = cell.low.min(p);
        cell.high = cell.high.max(p);
        cell.elements.push(index);
    }

    /// Elements on the sheet of `triangle` with centres nearer than `distance` to `p`.
    ///
    /// With [`Search::Lists`] `distance` may be anything; the answer is what the nearby set holds.
    pub(crate) fn near(
        &self,
        triangle: usize,
        p: DVec3,
        distance: f64,
        within: Within,
    ) -> Vec<usize> {
        let set = match within {
            Within::Contact => &self.contact_sets[triangle],
            Within::Density => &self.density_sets[triangle],
        };
        let limit = distance * distance;
        let close = |e: &usize| self.positions[*e].distance_squared(p) < limit;
        match self.search {
            Search::Lists => {
                let listed = set.iter().flat_map(|&t| &self.lists[t]);
                listed.copied().filter(close).collect()
            }
            Search::Cells => {
                let boxes = self.cells.iter().filter(|c| c.distance_squared(p) < limit);
                let found = boxes.flat_map(|c| c.elements.iter().copied()).filter(close);
                found
                    .filter(|&e| set.binary_search(&self.places[e].triangle).is_ok())
                    .collect()
            }
        }
    }

    /// Elements that a disc at `place` would overlap.
    pub(crate) fn overlapped(&self, place: Place, diameter: f64) -> Vec<usize> {
        self.near(
            place.triangle,
            self.mesh.lift(place),
            diameter,
            Within::Contact,
        )
    }

    /// Distance in space from `p` to the nearest element, whatever its sheet.
    pub(crate) fn nearest_distance(&self, p: DVec3) -> f64 {
        let nearest = match self.search {
            Search::Lists => self.nearest_squared(0..self.positions.len(), p),
            Search::Cells => self.cells.iter().fold(f64::INFINITY, |best, cell| {
                if cell.distance_squared(p) >= best {
                    return best;
                }
                best.min(self.nearest_squared(cell.elements.iter().copied(), p))
            }),
        };
        nearest.sqrt()
    }

    fn nearest_squared(&self, elements: impl Iterator<Item = usize>, p: DVec3) -> f64 {
        let squares = elements.map(|e| self.positions[e].distance_squared(p));
        squares.fold(f64::INFINITY, f64::min)
    }
}
