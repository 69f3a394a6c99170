//! A mesh as USD in its text form: `Mesh` (Pixar, *UsdGeom schemas*), a polygon mesh that is not
//! subdivided, with attributes as primvars of the vertices and linear colours as `displayColor`, which its material
//! reads.

use std::io::{self, Write};

use super::TriMesh;
use crate::color::to_linear;
use crate::export::usda::{NO_EXTENT, Stage, VERTEX};

/// Its box from an origin.
pub(in crate::export) fn extent(mesh: &TriMesh, origin: [f64; 3]) -> [[f32; 3]; 2] {
    match mesh.positions.is_empty() {
        true => NO_EXTENT,
        false => mesh
            .bounds()
            .map(|p| [0, 1, 2].map(|k| (p[k] - origin[k]) as f32)),
    }
}

pub(super) fn write(mesh: &TriMesh, meters_per_unit: f64, out: &mut dyn Write) -> io::Result<()> {
    let origin = mesh.origin();
    let local = |p: &[f64; 3]| [0, 1, 2].map(|k| (p[k] - origin[k]) as f32);
    let mut stage = Stage::begin(mesh.up, meters_per_unit, origin, out)?;
    stage.open_skin("skin")?;
    stage.line("uniform token subdivisionScheme = \"none\"")?;
    let counts = mesh.triangles.iter().map(|_| 3);
    stage.list("int[] faceVertexCounts", "", counts)?;
    let corners = mesh.triangles.as_flattened().iter();
    stage.list("int[] faceVertexIndices", "", corners)?;
    stage.vectors("float3[] extent", "", extent(mesh, origin).into_iter())?;
    let points = mesh.positions.iter().map(local);
    stage.vectors("point3f[] points", "", points)?;
    let normals = mesh.normals.iter().copied();
    stage.vectors("normal3f[] normals", VERTEX, normals)?;
    let light: Vec<f32> = (0..=255).map(to_linear).collect();
    let colors = mesh
        .colors
        .iter()
        .map(|c| c.map(|byte| light[byte as usize]));
    stage.vectors("color3f[] primvars:displayColor", VERTEX, colors)?;
    for attribute in &mesh.attributes {
        let declared = format!("float[] primvars:{}", attribute.name);
        stage.numbers(&declared, VERTEX, attribute.values.iter().copied())?;
    }
    stage.close()?;
    stage.close()
}
