//! What is shown of the substrate, as meshes that carry the maps.

use std::collections::HashMap;

use super::{Baked, order};
use crate::export::{Stance, TexturedMesh, TexturedObject, TriMesh};
use crate::substrate::Part;

/// Bits of all that vertices may differ in: the substrate's vertex, UV, normal and tangent.
type Key = (u32, [u32; 2], [u32; 3], [u32; 4]);

/// A mesh that is being made, and its vertices by what they are.
#[derive(Default)]
struct Making {
    mesh: TexturedMesh,
    seen: HashMap<Key, u32>,
}

impl Baked<'_> {
    /// What is shown of the substrate, object by object: wound outwards, with vertices split where UVs, normals or
    /// tangents differ, in the units and axes of its file. Triangles without UVs are at (0, 0).
    pub fn meshes(&self) -> Vec<(TexturedObject, TexturedMesh)> {
        let (objects, of_parts) = self.objects();
        let mut making: Vec<Making> = Vec::new();
        making.resize_with(objects.len(), Making::default);
        for triangle in self.shown.triangles() {
            let part = self.shown.part_of(triangle).map(|part| part as usize);
            let object = part.map_or(objects.len() - 1, |part| of_parts[part]);
            self.add(triangle, &mut making[object]);
        }
        let made = making.into_iter().map(|making| making.mesh);
        let is_there = |(_, mesh): &(_, TexturedMesh)| !mesh.shape.triangles.is_empty();
        objects.into_iter().zip(made).filter(is_there).collect()
    }

    /// The objects that parts of the file belong to, and of each part its object's place; last is one for what belongs
    /// to no part.
    fn objects(&self) -> (Vec<TexturedObject>, Vec<usize>) {
        let mut objects: Vec<TexturedObject> = Vec::new();
        let mut places = HashMap::new();
        let mut place = |part: &Part| {
            let name = part.objects.first().cloned();
            let bits = |frame: [[f64; 3]; 4]| frame.map(|column| column.map(f64::to_bits));
            let key = (name.clone(), part.frame.map(bits));
            *places.entry(key).or_insert_with(|| {
                objects.push(TexturedObject {
                    name,
                    stance: part.frame.and_then(Stance::from_columns),
                    meshes: Vec::new(),
                });
                objects.len() - 1
            })
        };
        let parts = self.shown.texturing.parts.iter();
        let of_parts = parts.map(&mut place).collect();
        objects.push(TexturedObject::default());
        (objects, of_parts)
    }

    fn add(&self, triangle: u32, making: &mut Making) {
        making.mesh.shape.up = self.shown.substrate.up_axis();
        let turned = self.shown.substrate.winding().side(triangle) < 0.0;
        let corners = order(turned).map(|k| self.vertex(triangle, k, making));
        making.mesh.shape.triangles.push(corners);
    }

    fn vertex(&self, triangle: u32, k: usize, Making { mesh, seen }: &mut Making) -> u32 {
        let substrate = self.shown.substrate;
        let uvs = self.shown.uvs_of(triangle);
        let uv = uvs.map_or([0.0; 2], |uvs| uvs[k].map(|x| x as f32));
        let frame = &self.frames[triangle as usize];
        let normal = frame.normals[k].to_array();
        let tangent = frame.tangents[k].to_array();
        let vertex = substrate.triangles()[triangle as usize][k];
        let key = (
            vertex,
            uv.map(f32::to_bits),
            normal.map(f32::to_bits),
            tangent.map(f32::to_bits),
        );
        *seen.entry(key).or_insert_with(|| {
            let place = substrate.vertices()[vertex as usize];
            let place = substrate.units().to_file(place);
            let TriMesh {
                positions, normals, ..
            } = &mut mesh.shape;
            positions.push(place.to_array());
            normals.push(normal);
            mesh.uvs.push(uv);
            mesh.tangents.push(tangent);
            positions.len() as u32 - 1
        })
    }
}
