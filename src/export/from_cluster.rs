//! A cluster as a table.

use super::Elements;
use crate::cluster::{Cluster, Element, NO_PARENT};
use crate::substrate::Substrate;

impl Elements {
    /// The table of a cluster's elements, in the mesh file's units and axes.
    ///
    /// The cluster must have grown on this substrate. Of another it may give numbers without meaning. Normals are
    /// those of the triangles; `thallus export` puts [`smooth_normals`](crate::morphometry::smooth_normals) in
    /// their place.
    ///
    /// # Panics
    /// When an element is in a triangle that the substrate does not have.
    pub fn of(substrate: &Substrate, cluster: &Cluster) -> Self {
        let elements = cluster.elements();
        let triangle = |e: &Element| e.at.triangle;
        let normal = |e: &Element| substrate.normal(triangle(e)).as_vec3().to_array();
        let position = |e: &Element| substrate.units().to_file(e.position).to_array();
        Self {
            radius: substrate.units().length_to_file(cluster.radius()),
            positions: elements.iter().map(position).collect(),
            normals: elements.iter().map(normal).collect(),
            parent: elements.iter().map(parent).collect(),
            colony: elements.iter().map(|e| e.colony).collect(),
            triangle: elements
                .iter()
                .map(|e| substrate.canonical_triangle(triangle(e)))
                .collect(),
            uv: elements
                .iter()
                .map(|e| [e.at.u as f32, e.at.v as f32])
                .collect(),
            probability: elements.iter().map(|e| e.probability as f32).collect(),
            source_triangle: Some(
                elements
                    .iter()
                    .map(|e| substrate.source_triangle(triangle(e)))
                    .collect(),
            ),
            attributes: Vec::new(),
        }
    }
}

fn parent(element: &Element) -> i32 {
    match element.parent {
        NO_PARENT => -1,
        parent => parent as i32,
    }
}
