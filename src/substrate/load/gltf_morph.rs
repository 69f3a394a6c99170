//! Morphed glTF meshes, as the weights in the file have them (glTF 2.0, section 3.7.2.2).

use super::error::{LoadFault, Parsed};
use super::gltf_accessor::Accessors;
use super::gltf_buffers::EXPORT_AGAIN;
use super::gltf_schema::{Mesh, Node, Primitive};

/// The weights of a node's morph targets: its own, or else those of its mesh.
pub(super) struct Morphs<'a>(&'a [f64]);

impl<'a> Morphs<'a> {
    pub(super) fn of(node: &'a Node, mesh: &'a Mesh) -> Self {
        let weights = node.weights.as_ref().or(mesh.weights.as_ref());
        Self(weights.map_or(&[], Vec::as_slice))
    }

    /// The targets that move a primitive's attribute, each with its accessor.
    pub(super) fn movers(&self, primitive: &Primitive, attribute: &str) -> Vec<[usize; 2]> {
        let targets = primitive.targets.iter().zip(self.0).enumerate();
        let moving = targets.filter(|(_, (_, weight))| **weight != 0.0);
        let accessors = moving.filter_map(|(n, (target, _))| Some([n, *target.get(attribute)?]));
        accessors.collect()
    }

    /// Adds what the targets add to an attribute of all a primitive's vertices.
    pub(super) fn apply(
        &self,
        primitive: &Primitive,
        attribute: &str,
        accessors: &Accessors,
        place: &str,
        values: &mut [[f64; 3]],
    ) -> Parsed<()> {
        for [target, accessor] in self.movers(primitive, attribute) {
            let place = format!("{place}, morph target {target}");
            let count = accessors.get(accessor, &place)?.count;
            if count != values.len() {
                let problem = format!("it moves {count} of {} vertices", values.len());
                let format = accessors.format;
                return Err(LoadFault::malformed(format, place, problem, EXPORT_AGAIN));
            }
            let moves = accessors.vectors::<3>(accessor, &place)?;
            let weight = self.0[target];
            for (value, by) in values.iter_mut().zip(moves) {
                *value = std::array::from_fn(|axis| value[axis] + weight * by[axis]);
            }
        }
        Ok(())
    }
}
