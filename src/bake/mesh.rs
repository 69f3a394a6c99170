//! The substrate as a mesh that carries the maps.

use std::collections::HashMap;

use super::{Baked, order};
use crate::export::{TexturedMesh, TriMesh};

/// Bits of all that vertices may differ in: the substrate's vertex, UV, normal and tangent.
type Key = (u32, [u32; 2], [u32; 3], [u32; 4]);

impl Baked<'_> {
    /// The substrate, wound outwards, with vertices split where UVs, normals or tangents differ, in
    /// the units and axes of its file. Triangles without UVs are at (0, 0).
    pub fn mesh(&self) -> TexturedMesh {
        self.mesh_of(|_| true)
    }

    /// As [`mesh`](Self::mesh), of those triangles of the substrate alone that are asked for.
    pub fn mesh_of(&self, is_asked_for: impl Fn(u32) -> bool) -> TexturedMesh {
        let mut mesh = TexturedMesh {
            shape: TriMesh {
                name: Some("lichened".to_owned()),
                up: self.substrate.up_axis(),
                ..TriMesh::default()
            },
            ..TexturedMesh::default()
        };
        let mut seen: HashMap<Key, u32> = HashMap::new();
        let all = 0..self.substrate.triangles().len() as u32;
        for t in all.filter(|&t| is_asked_for(t)) {
            let corners = order(self.turned[t as usize]);
            let triangle = corners.map(|k| self.vertex(t, k, &mut seen, &mut mesh));
            mesh.shape.triangles.push(triangle);
        }
        mesh
    }

    fn vertex(
        &self,
        triangle: u32,
        k: usize,
        seen: &mut HashMap<Key, u32>,
        mesh: &mut TexturedMesh,
    ) -> u32 {
        let uvs = self.texturing.uvs_of(self.substrate, triangle);
        let uv = uvs.map_or([0.0; 2], |uvs| uvs[k].map(|x| x as f32));
        let frame = &self.frames[triangle as usize];
        let normal = frame.normals[k].to_array();
        let tangent = frame.tangents[k].to_array();
        let vertex = self.substrate.triangles()[triangle as usize][k];
        let key = (
            vertex,
            uv.map(f32::to_bits),
            normal.map(f32::to_bits),
            tangent.map(f32::to_bits),
        );
        *seen.entry(key).or_insert_with(|| {
            let place = self.substrate.vertices()[vertex as usize];
            let place = self.substrate.units().to_file(place);
            mesh.shape.positions.push(place.to_array());
            mesh.shape.normals.push(normal);
            mesh.uvs.push(uv);
            mesh.tangents.push(tangent);
            mesh.shape.positions.len() as u32 - 1
        })
    }
}
