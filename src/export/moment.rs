//! A scene as it was at a moment of its growth.

use super::elements::{Attribute, Values};
use super::scene::Scene;
use crate::cluster::Presence;
use crate::morphometry::Tree;

impl Scene {
    /// The elements that have any influence at a moment, `least` at least. An attribute `influence`
    /// says how much each has.
    ///
    /// Branches, their order and their widths are those of the elements so far, widths times the
    /// influence. `nage`, `density`, `rim_distance` and `orient` are those of the grown lichen, so
    /// that an element keeps them.
    pub fn at(&self, presence: &Presence, least: usize) -> Self {
        let all = self.elements.len();
        let born = presence.born(all).max(least.min(all));
        let influences: Vec<f32> = (0..born).map(|i| presence.influence(i)).collect();
        let tree = Tree::new(&self.elements.parent[..born]);
        let widths = tree.taper().into_iter().zip(&influences);
        let radius = self.elements.radius;
        let widths: Vec<f32> = widths
            .map(|(taper, &share)| (taper * radius) as f32 * share)
            .collect();
        let whole = |column: Vec<u32>| Values::I32(column.into_iter().map(|x| x as i32).collect());
        let mut elements = self.elements.first(born);
        for attribute in &mut elements.attributes {
            attribute.values = match attribute.name {
                "strahler" => whole(tree.strahler()),
                "depth" => whole(tree.depth()),
                "branch_radius" => Values::F32(widths.clone()),
                _ => continue,
            };
        }
        elements.attributes.push(Attribute {
            name: "influence",
            values: Values::F32(influences),
        });
        Self {
            elements,
            orientations: self.orientations[..born].to_vec(),
            streams: tree.streams(),
            branch_radii: widths,
            fixed_origin: Some(self.origin()),
            ..*self
        }
    }

    /// How much of each element there is, by the attribute `influence`: 1 where there is none.
    pub(super) fn influences(&self) -> Vec<f32> {
        let all = || vec![1.0; self.elements.len()];
        self.floats("influence").map_or_else(all, <[f32]>::to_vec)
    }

    /// The attribute of this name, if there is one of such numbers.
    pub(super) fn floats(&self, name: &str) -> Option<&[f32]> {
        let mut attributes = self.elements.attributes.iter();
        match &attributes.find(|a| a.name == name)?.values {
            Values::F32(column) => Some(column),
            _ => None,
        }
    }

    /// The radius that each element is shown with.
    pub(super) fn shown_radii(&self) -> Vec<f32> {
        let radius = self.elements.radius as f32;
        let shares = self.influences().into_iter();
        shares.map(|share| radius * share).collect()
    }
}
