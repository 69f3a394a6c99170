//! A mesh as binary little-endian PLY.
//!
//! Each attribute is a float property of the vertices, which Blender reads as a float attribute.
//! Colours are sRGB bytes.

use std::fmt::Write as _;
use std::io::{self, Write};

use super::TriMesh;

/// Bytes that are handed on at once, about.
const BLOCK: usize = 1 << 15;

pub(super) fn write(mesh: &TriMesh, out: &mut dyn Write) -> io::Result<()> {
    let wide = mesh.needs_doubles();
    let mut block = header(mesh, wide).into_bytes();
    for vertex in 0..mesh.positions.len() {
        push_vertex(&mut block, mesh, vertex, wide);
        hand_on(&mut block, BLOCK, out)?;
    }
    for [a, b, c] in &mesh.triangles {
        let [a, b, c] = [a, b, c].map(|v| v.to_le_bytes());
        block.push(3);
        block.extend_from_slice([a, b, c].as_flattened());
        hand_on(&mut block, BLOCK, out)?;
    }
    hand_on(&mut block, 1, out)
}

/// Writes a block that has at least so many bytes, and begins the next.
fn hand_on(block: &mut Vec<u8>, least: usize, out: &mut dyn Write) -> io::Result<()> {
    if block.len() >= least {
        out.write_all(block)?;
        block.clear();
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

fn push_vertex(block: &mut Vec<u8>, mesh: &TriMesh, vertex: usize, wide: bool) {
    let place = mesh.positions[vertex];
    match wide {
        true => block.extend_from_slice(place.map(f64::to_le_bytes).as_flattened()),
        false => block.extend_from_slice(place.map(|x| (x as f32).to_le_bytes()).as_flattened()),
    }
    let normal = mesh.normals[vertex].map(f32::to_le_bytes);
    block.extend_from_slice(normal.as_flattened());
    block.extend_from_slice(&mesh.colors[vertex]);
    for attribute in &mesh.attributes {
        block.extend_from_slice(&attribute.values[vertex].to_le_bytes());
    }
}
