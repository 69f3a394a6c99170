//! A mesh as binary glTF 2.0.
//!
//! glTF has y up: a mesh with z up is turned by its node. Coordinates are 32-bit: one that lies far
//! from its origin is stored about its middle and moved there by its node. Colours are linear, 16
//! bits a channel, as glTF wants them; attributes are named `_DENSITY` and the like, as its
//! specification says of those of one's own.

use std::io::{self, Write};

use serde_json::{Value, json};

use super::TriMesh;
use crate::color::to_linear;
use crate::export::UpAxis;

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
    let body: usize = columns.iter().map(|c| c.bytes).sum();
    let middle = middle(mesh);
    let mut text = document(mesh, &columns, body, middle).to_string();
    while !text.len().is_multiple_of(4) {
        text.push(' ');
    }
    let too_large = |_| {
        let message = "glTF binary files end at 4 GiB; make the mesh coarser, or write .ply";
        io::Error::new(io::ErrorKind::InvalidInput, message)
    };
    let total = u32::try_from(28 + text.len() + body).map_err(too_large)?;
    let chunk = |length: usize, kind: &[u8; 4]| [&(length as u32).to_le_bytes()[..], kind].concat();
    out.write_all(b"glTF")?;
    out.write_all(&2u32.to_le_bytes())?;
    out.write_all(&total.to_le_bytes())?;
    out.write_all(&chunk(text.len(), b"JSON"))?;
    out.write_all(text.as_bytes())?;
    out.write_all(&chunk(body, b"BIN\0"))?;
    write_body(mesh, middle, out)
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

/// What positions are stored relative to.
fn middle(mesh: &TriMesh) -> [f64; 3] {
    let [low, high] = mesh.bounds();
    match mesh.needs_doubles() {
        true => [0, 1, 2].map(|k| 0.5 * low[k] + 0.5 * high[k]),
        false => [0.0; 3],
    }
}

fn document(mesh: &TriMesh, columns: &[Column], body: usize, middle: [f64; 3]) -> Value {
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
    let stored = |p: [f64; 3]| [0, 1, 2].map(|k| (p[k] - middle[k]) as f32);
    let [low, high] = mesh.bounds();
    accessors[0]["min"] = json!(stored(low));
    accessors[0]["max"] = json!(stored(high));
    let (indices, attributes) = (columns.len() - 1, &columns[..columns.len() - 1]);
    let attributes = attributes.iter().enumerate();
    let attributes = attributes.map(|(i, c)| (c.name.clone(), json!(i)));
    let attributes: serde_json::Map<_, _> = attributes.collect();
    json!({
        "asset": { "version": "2.0", "generator": concat!("thallus ", env!("CARGO_PKG_VERSION")) },
        "scene": 0,
        "scenes": [{ "nodes": [0] }],
        "nodes": [node(mesh.up, middle)],
        "meshes": [{ "name": "lichen", "primitives": [{
            "attributes": attributes, "indices": indices, "material": 0,
        }] }],
        "materials": [{ "name": "lichen", "pbrMetallicRoughness": {
            "metallicFactor": 0.0, "roughnessFactor": 0.9,
        } }],
        "accessors": accessors,
        "bufferViews": views,
        "buffers": [{ "byteLength": body }],
    })
}

fn node(up: UpAxis, [x, y, z]: [f64; 3]) -> Value {
    let mut node = json!({ "name": "lichen", "mesh": 0 });
    let place = match up {
        UpAxis::Y => [x, y, z],
        UpAxis::Z => [x, z, -y],
    };
    if place != [0.0; 3] {
        node["translation"] = json!(place);
    }
    if up == UpAxis::Z {
        let half = -std::f32::consts::FRAC_1_SQRT_2;
        node["rotation"] = json!([half, 0.0, 0.0, -half]);
    }
    node
}

fn write_body(mesh: &TriMesh, middle: [f64; 3], out: &mut dyn Write) -> io::Result<()> {
    let mut floats = |values: &[f32]| -> io::Result<()> {
        values
            .iter()
            .try_for_each(|x| out.write_all(&x.to_le_bytes()))
    };
    for p in &mesh.positions {
        floats(&[0, 1, 2].map(|k| (p[k] - middle[k]) as f32))?;
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
