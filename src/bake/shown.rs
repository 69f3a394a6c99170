//! The part of a mesh that maps are made of.

use std::sync::Arc;

use super::unwrap::Charts;
use crate::substrate::{Material, Substrate, Texturing};

/// Triangles that are shown, and what their file says of them.
#[derive(Clone)]
pub(super) struct Shown<'a> {
    pub(super) substrate: &'a Substrate,
    pub(super) texturing: &'a Texturing,
    /// By the numbers of triangles in the file: those past its end are not shown. None where all are.
    pub(super) chosen: Option<&'a [bool]>,
    /// What they are laid out in instead of what their file says.
    pub(super) charts: Option<Arc<Charts>>,
}

impl<'a> Shown<'a> {
    pub(super) fn has(&self, triangle: u32) -> bool {
        let source = self.substrate.source_triangle(triangle) as usize;
        self.chosen
            .is_none_or(|chosen| chosen.get(source) == Some(&true))
    }

    /// In the substrate's order.
    pub(super) fn triangles(&self) -> impl Iterator<Item = u32> {
        let all = 0..self.substrate.triangles().len() as u32;
        all.filter(|&triangle| self.has(triangle))
    }

    /// The place of a triangle's part in those of the file, if it is of one.
    pub(super) fn part_of(&self, triangle: u32) -> Option<u32> {
        let source = self.substrate.source_triangle(triangle) as usize;
        self.texturing.part_of.get(source).copied().flatten()
    }

    /// The place of a triangle's material in those of the file, if it has one that is there.
    pub(super) fn material_of(&self, triangle: u32) -> Option<usize> {
        self.texturing.material_at(self.substrate, triangle)
    }

    /// Those of the file that its triangles have.
    pub(super) fn materials(&self) -> Vec<&'a Material> {
        let mut is_used = vec![false; self.texturing.materials.len()];
        let numbers = self.triangles().filter_map(|t| self.material_of(t));
        numbers.for_each(|number| is_used[number] = true);
        let all = self.texturing.materials.iter().zip(is_used);
        all.filter_map(|(material, is_used)| is_used.then_some(material))
            .collect()
    }

    /// The second set of the UVs of a triangle, if it has one: those of its file where maps have charts of their own.
    pub(super) fn second_uvs_of(&self, triangle: u32) -> Option<[[f64; 2]; 3]> {
        match self.charts {
            Some(_) => self.texturing.uvs_of(self.substrate, triangle),
            None => self.texturing.second_uvs_of(self.substrate, triangle),
        }
    }

    /// Whether there is such a set.
    pub(super) fn has_second_uvs(&self) -> bool {
        match self.charts {
            Some(_) => !self.texturing.uvs.is_empty(),
            None => !self.texturing.second_uvs.is_empty(),
        }
    }

    /// UVs of a triangle that is shown, if it has any.
    pub(super) fn uvs_of(&self, triangle: u32) -> Option<[[f64; 2]; 3]> {
        let shown = self.has(triangle).then_some(triangle)?;
        match &self.charts {
            Some(charts) => charts[shown as usize],
            None => self.texturing.uvs_of(self.substrate, shown),
        }
    }
}
