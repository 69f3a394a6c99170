//! Which elements are felt at the vertices of a surface: what of the field does not change while a
//! lichen grows.
//!
//! Elements do not move, so how much of an element there is at a vertex changes only by its influence.
//! The falloffs are kept. With them the field is read anew as a short sum, and whether anything about a
//! vertex has changed is told by its elements.

use std::sync::atomic::{AtomicBool, Ordering::Relaxed};

use glam::DVec3;
use rayon::prelude::*;

use super::field::Field;
use super::grid::Grid;
use super::lichen::Granule;
use super::refine::Tree;
use super::sheet::Sheet;
use crate::cluster::{Cluster, Element};

/// An element by its place in the list, and its falloff at a vertex: 0 where it is not felt.
type Touch = (u32, f32);

/// Elements whose neighbours are counted, for a mean.
const COUNTED: usize = 100;

/// About how many elements are within `reach`, local units, of a place with lichen.
pub(super) fn mean_near(cluster: &Cluster, reach: f64) -> f64 {
    let elements = cluster.elements();
    let apart = elements.len().div_ceil(COUNTED).max(1);
    let is_near = |p: DVec3, q: DVec3| (q - p).length_squared() <= reach * reach;
    let near = |e: &Element| {
        let near = elements.iter().filter(|o| is_near(e.position, o.position));
        near.count()
    };
    let counted: Vec<usize> = elements.par_iter().step_by(apart).map(near).collect();
    counted.iter().sum::<usize>() as f64 / counted.len().max(1) as f64
}

/// The elements near each vertex.
pub(super) struct Felt {
    /// Ascending; with those that are not felt at the vertex, but may be farther along a side.
    near: Vec<Box<[Touch]>>,
    /// The vertices by place, and for each the first of the grid's run that it is in.
    grid: Grid,
    run_of: Vec<u32>,
}

impl Felt {
    /// Of the vertices of a tree, with the elements within `reach`, local units: as far as the field's
    /// are felt, or farther.
    pub(super) fn new(field: &Field, tree: &Tree, reach: f64) -> Self {
        let places: Vec<DVec3> = field.lichen.granules.iter().map(|g| g.position).collect();
        let (grid, order) = Grid::new(&places, reach);
        let sheet = || Sheet::new(field.substrate, field.lichen.radius);
        let near = |sheet: &mut Sheet, (&p, &home): (&DVec3, &u32)| {
            let facing = field.substrate.normal(home).as_vec3();
            let around = grid.around(p).flat_map(|run| &order[run]);
            let within = |&&i: &&u32| (places[i as usize] - p).length_squared() <= reach * reach;
            let mut near: Vec<u32> = around.filter(within).copied().collect();
            near.sort_unstable();
            let touch = |i: u32| {
                let granule = &field.lichen.granules[i as usize];
                (i, field.felt(p, home, facing, granule, sheet))
            };
            near.into_iter().map(touch).collect()
        };
        let vertices = tree.positions.par_iter().zip(&tree.homes);
        let near = vertices.map_init(sheet, near).collect();
        let (grid, order) = Grid::new(&tree.positions, reach);
        let mut run_of = vec![0; order.len()];
        for run in grid.runs() {
            for &v in &order[run.clone()] {
                run_of[v as usize] = run.start as u32;
            }
        }
        Self { near, grid, run_of }
    }

    /// What tells whether a vertex feels an element that has `moved`.
    pub(super) fn changed_by<'a>(
        &'a self,
        granules: &[Granule],
        moved: &'a [bool],
    ) -> impl Fn(usize) -> bool + Sync + 'a {
        let marks: Vec<AtomicBool> = self.run_of.iter().map(|_| false.into()).collect();
        let stirred = granules.par_iter().zip(moved).filter(|(_, moved)| **moved);
        stirred.for_each(|(granule, _)| {
            for run in self.grid.around(granule.position) {
                marks[run.start].store(true, Relaxed);
            }
        });
        move |vertex| {
            let is_near = marks[self.run_of[vertex] as usize].load(Relaxed);
            is_near && self.at(vertex).any(|(i, _)| moved[i as usize])
        }
    }

    /// The elements that are felt at a vertex, ascending, and their falloffs.
    pub(super) fn at(&self, vertex: usize) -> impl Iterator<Item = Touch> {
        let felt = self.near[vertex]
            .iter()
            .filter(|(_, falloff)| *falloff > 0.0);
        felt.copied()
    }

    /// The elements near a vertex, in their order.
    pub(super) fn near<'a>(
        &self,
        vertex: u32,
        granules: &'a [Granule],
    ) -> impl Iterator<Item = &'a Granule> {
        let near = self.near[vertex as usize].iter();
        near.map(|&(i, _)| &granules[i as usize])
    }

    /// Whether an element near a vertex has moved.
    pub(super) fn has_moved(&self, vertex: u32, moved: &[bool]) -> bool {
        let mut near = self.near[vertex as usize].iter();
        near.any(|&(i, _)| moved[i as usize])
    }
}
