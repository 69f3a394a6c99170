//! A mesh as binary glTF 2.0.
//!
//! Coordinates are 32-bit: a mesh that lies far from its origin is stored about its middle and moved
//! there by its node. Colours are linear, 16 bits a channel, as glTF wants them; attributes are named `_DENSITY` and the like, as its
//! specification says of those of one's own.

use std::io::{self, Write};

use serde_json::{Value, json};

use super::TriMesh;
use crate::color::to_linear;
use crate::export::glb::{document, node, write_head};

const FLOAT: u32 = 5126;
const UNSIGNED_INT: u32 = 5125;
const UNSIGNED_SHORT: u32 = 5123;
const VERTICES: u32 = 34962;
const INDICES: u32 = 34963;

/// An accessor of its own buffer view.
struct Column {
    name: String,
    component: u32,
    shape: &'static str,
    normalized: bool,
    target: u32,
    count: usize,
    bytes: usize,
}

pub(super) fn write(mesh: &TriMesh, out: &mut dyn Write) -> io::Result<()> {
    let columns = columns(mesh);
    let body = columns.iter().map(|c| c.bytes).sum();
    let origin = mesh.origin();
    write_head(&described(mesh, &columns, body, origin), body, out)?;
    write_body(mesh, origin, out)
}

fn columns(mesh: &TriMesh) -> Vec<Column> {
    let count = mesh.positions.len();
    let floats = |name: &str, shape: &'static str, width: usize| Column {
        name: name.to_owned(),
        component: FLOAT,
        shape,
        normalized: false,
        target: VERTICES,
        count,
        bytes: 4 * width * count,
    };
    let mut columns = vec![
        floats("POSITION", "VEC3", 3),
        floats("NORMAL", "VEC3", 3),
        Column {
            component: UNSIGNED_SHORT,
            normalized: true,
            bytes: 8 * count,
            ..floats("COLOR_0", "VEC4", 0)
        },
    ];
    let named = |a: &super::VertexAttribute| format!("_{}", a.name.to_uppercase());
    let own = mesh
        .attributes
        .iter()
        .map(|a| floats(&named(a), "SCALAR", 1));
    columns.extend(own);
    let corners = 3 * mesh.triangles.len();
    columns.push(Column {
        component: UNSIGNED_INT,
        target: INDICES,
        count: corners,
        bytes: 4 * corners,
        ..floats("", "SCALAR", 0)
    });
    columns
}

fn described(mesh: &TriMesh, columns: &[Column], body: usize, origin: [f64; 3]) -> Value {
    let mut offset = 0;
    let mut views = Vec::new();
    let mut accessors: Vec<Value> = Vec::new();
    for (i, column) in columns.iter().enumerate() {
        views.push(json!({
            "buffer": 0, "byteOffset": offset, "byteLength": column.bytes, "target": column.target,
        }));
        offset += column.bytes;
        accessors.push(json!({
            "bufferView": i, "componentType": column.component, "count": column.count,
            "type": column.shape, "normalized": column.normalized,
        }));
    }
    let stored = |p: [f64; 3]| [0, 1, 2].map(|k| (p[k] - origin[k]) as f32);
    let [low, high] = mesh.bounds();
    accessors[0]["min"] = json!(stored(low));
    accessors[0]["max"] = json!(stored(high));
    let (indices, attributes) = (columns.len() - 1, &columns[..columns.len() - 1]);
    let attributes = attributes.iter().enumerate();
    let attributes = attributes.map(|(i, c)| (c.name.clone(), json!(i)));
    let attributes: serde_json::Map<_, _> = attributes.collect();
    let primitive = json!({"attributes": attributes, "indices": indices, "material": 0});
    let shape = json!({"name": "lichen", "primitives": [primitive]});
    let mut document = document(node(origin), shape);
    document["accessors"] = accessors.into();
    document["bufferViews"] = views.into();
    document["buffers"] = json!([{ "byteLength": body }]);
    document
}

fn write_body(mesh: &TriMesh, origin: [f64; 3], out: &mut dyn Write) -> io::Result<()> {
    let mut floats = |values: &[f32]| -> io::Result<()> {
        values
            .iter()
            .try_for_each(|x| out.write_all(&x.to_le_bytes()))
    };
    for p in &mesh.positions {
        floats(&[0, 1, 2].map(|k| (p[k] - origin[k]) as f32))?;
    }
    for normal in &mesh.normals {
        floats(normal)?;
    }
    let linear: Vec<u16> = (0..=255)
        .map(|byte| (to_linear(byte) * 65535.0 + 0.5) as u16)
        .collect();
    for color in &mesh.colors {
        let [r, g, b] = color.map(|byte| linear[byte as usize].to_le_bytes());
        out.write_all(&[r, g, b, [255; 2]].concat())?;
    }
    for attribute in &mesh.attributes {
        for x in &attribute.values {
            out.write_all(&x.to_le_bytes())?;
        }
    }
    for v in mesh.triangles.as_flattened() {
        out.write_all(&v.to_le_bytes())?;
    }
    Ok(())
}
