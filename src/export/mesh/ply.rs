//! A mesh as binary little-endian PLY.
//!
//! Each attribute is a float property of the vertices, which Blender reads as a float attribute.
//! Colours are sRGB bytes.

use std::fmt::Write as _;
use std::io::{self, Write};

use super::TriMesh;

pub(super) fn write(mesh: &TriMesh, out: &mut dyn Write) -> io::Result<()> {
    let wide = mesh.needs_doubles();
    out.write_all(header(mesh, wide).as_bytes())?;
    let mut record = Vec::with_capacity(96);
    for vertex in 0..mesh.positions.len() {
        record.clear();
        push_vertex(&mut record, mesh, vertex, wide);
        out.write_all(&record)?;
    }
    for corners in &mesh.triangles {
        record.clear();
        record.push(3);
        let numbers = corners.iter().flat_map(|v| v.to_le_bytes());
        record.extend(numbers);
        out.write_all(&record)?;
    }
    Ok(())
}

fn header(mesh: &TriMesh, wide: bool) -> String {
    let (vertices, faces) = (mesh.positions.len(), mesh.triangles.len());
    let version = env!("CARGO_PKG_VERSION");
    let mut text = format!(
        "ply\n\
         format binary_little_endian 1.0\n\
         comment thallus {version}: skin of a lichen\n\
         element vertex {vertices}\n"
    );
    let place = if wide { "double" } else { "float" };
    let mut property = |kind: &str, name: &str| {
        let _ = writeln!(text, "property {kind} {name}");
    };
    let own = mesh.attributes.iter().map(|a| ("float", a.name));
    let fixed = [
        (place, ["x", "y", "z"]),
        ("float", ["nx", "ny", "nz"]),
        ("uchar", ["red", "green", "blue"]),
    ];
    let fixed = fixed
        .into_iter()
        .flat_map(|(kind, names)| names.map(|name| (kind, name)));
    fixed
        .chain(own)
        .for_each(|(kind, name)| property(kind, name));
    text + &format!(
        "element face {faces}\n\
         property list uchar int vertex_indices\n\
         end_header\n"
    )
}

fn push_vertex(record: &mut Vec<u8>, mesh: &TriMesh, vertex: usize, wide: bool) {
    for x in mesh.positions[vertex] {
        match wide {
            true => record.extend_from_slice(&x.to_le_bytes()),
            false => record.extend_from_slice(&(x as f32).to_le_bytes()),
        }
    }
    let normal = mesh.normals[vertex];
    record.extend(normal.iter().flat_map(|x| x.to_le_bytes()));
    record.extend(mesh.colors[vertex]);
    let values = mesh.attributes.iter().map(|a| a.values[vertex]);
    record.extend(values.flat_map(f32::to_le_bytes));
}
