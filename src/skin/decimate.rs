//! Fewer triangles: meshoptimizer's simplifier, which weighs normals and colours with the shape.

use meshopt::{SimplifyOptions, VertexDataAdapter, simplify_with_attributes_and_locks};

use super::manifold::{Faults, faults};
use crate::export::{TriMesh, VertexAttribute};

/// A mesh with fewer triangles.
#[derive(Clone, Debug)]
pub struct Decimated {
    /// The mesh.
    pub mesh: TriMesh,
    /// Where it is no longer a closed manifold.
    pub faults: Faults,
}

/// Weights of normal and colour against a length of the mesh's size.
const NORMAL_WEIGHT: f32 = 0.02;
const COLOR_WEIGHT: f32 = 0.05;

/// Numbers for each vertex that the simplifier looks at: normal and colour.
const WATCHED: usize = 6;

/// The mesh with about as many triangles as asked for: vertices are kept where they are, with all
/// that is known of them, or dropped. What cannot go without changing the topology stays, so there
/// may be more; [`Decimated::faults`] tells where it is no manifold all the same.
pub fn decimate(mesh: &TriMesh, triangles: usize) -> Decimated {
    let indices = simplified(mesh, triangles);
    let kept = indices.as_chunks().0.to_vec();
    let mesh = picked(mesh, kept);
    let faults = faults(mesh.positions.len(), &mesh.triangles);
    Decimated { mesh, faults }
}

fn simplified(mesh: &TriMesh, triangles: usize) -> Vec<u32> {
    let [low, high] = mesh.bounds();
    let size = (0..3)
        .map(|k| high[k] - low[k])
        .fold(f64::MIN_POSITIVE, f64::max);
    let place = |p: &[f64; 3]| [0, 1, 2].map(|k| ((p[k] - low[k]) / size) as f32);
    let places: Vec<[f32; 3]> = mesh.positions.iter().map(place).collect();
    let watched = mesh.normals.iter().zip(&mesh.colors).flat_map(|(n, c)| {
        let [r, g, b] = c.map(|byte| f32::from(byte) / 255.0);
        [n[0], n[1], n[2], r, g, b]
    });
    let watched: Vec<f32> = watched.collect();
    let weights = [[NORMAL_WEIGHT; 3], [COLOR_WEIGHT; 3]].concat();
    let bytes: Vec<u8> = places
        .as_flattened()
        .iter()
        .flat_map(|x| x.to_ne_bytes())
        .collect();
    let stride = size_of::<[f32; 3]>();
    let Ok(vertices) = VertexDataAdapter::new(&bytes, stride, 0) else {
        return mesh.triangles.as_flattened().to_vec();
    };
    simplify_with_attributes_and_locks(
        mesh.triangles.as_flattened(),
        &vertices,
        &watched,
        &weights,
        WATCHED * size_of::<f32>(),
        &vec![false; places.len()],
        3 * triangles,
        1.0,
        SimplifyOptions::None,
        None,
    )
}

/// The mesh of these triangles, with the vertices that they use.
fn picked(mesh: &TriMesh, mut triangles: Vec<[u32; 3]>) -> TriMesh {
    let mut used = vec![false; mesh.positions.len()];
    let corners = triangles.as_flattened().iter();
    corners.for_each(|&v| used[v as usize] = true);
    let kept: Vec<usize> = (0..used.len()).filter(|&v| used[v]).collect();
    let mut number = vec![0; used.len()];
    kept.iter()
        .enumerate()
        .for_each(|(new, &old)| number[old] = new as u32);
    let corners = triangles.as_flattened_mut().iter_mut();
    corners.for_each(|v| *v = number[*v as usize]);
    TriMesh {
        positions: kept.iter().map(|&v| mesh.positions[v]).collect(),
        normals: kept.iter().map(|&v| mesh.normals[v]).collect(),
        colors: kept.iter().map(|&v| mesh.colors[v]).collect(),
        attributes: mesh
            .attributes
            .iter()
            .map(|a| VertexAttribute {
                name: a.name,
                values: kept.iter().map(|&v| a.values[v]).collect(),
            })
            .collect(),
        triangles,
        up: mesh.up,
    }
}
