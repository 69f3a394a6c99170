//! A mesh as binary glTF 2.0.
//!
//! Coordinates are 32-bit: a mesh that lies far from its origin is stored about its middle and moved
//! there by its node. Colours are linear, 16 bits a channel, as glTF wants them; attributes are named `_DENSITY` and
//! the like, as its specification says of those of one's own.

use std::io::{self, Write};

use serde_json::{Value, json};

use super::TriMesh;
use crate::color::to_linear;
use crate::export::glb::{
    FLOAT, INDICES, UNSIGNED_INT, UNSIGNED_SHORT, VERTICES, document, node, write_head,
};

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
    if mesh.triangles.is_empty() {
        return write_head(&nothing(), 0, out);
    }
    let origin = mesh.origin();
    let mut parts = Parts::default();
    let primitive = parts.describe(mesh, origin);
    let name = mesh.object();
    let shape = json!({"name": name, "primitives": [primitive]});
    let mut document = document(node(&name, origin), shape);
    let size = parts.describe_in(&mut document);
    write_head(&document, size, out)?;
    write_body(mesh, origin, out)
}

/// glTF has no meshes without vertices: a scene of a node without one.
fn nothing() -> Value {
    let mut document = document(json!({"name": "lichen"}), Value::Null);
    for unused in ["meshes", "materials"] {
        document.as_object_mut().map(|object| object.remove(unused));
    }
    document
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

/// Accessors, each of a buffer view of its own, one after the other in the buffer.
#[derive(Debug, Default)]
pub(in crate::export) struct Parts {
    views: Vec<Value>,
    accessors: Vec<Value>,
    size: usize,
}

impl Parts {
    /// The primitive of a mesh, whose [body](write_body) comes next in the buffer.
    pub(in crate::export) fn describe(&mut self, mesh: &TriMesh, origin: [f64; 3]) -> Value {
        let columns = columns(mesh);
        let first = self.accessors.len();
        for column in &columns {
            self.add(
                column.bytes,
                Some(column.target),
                json!({
                    "componentType": column.component, "count": column.count,
                    "type": column.shape, "normalized": column.normalized,
                }),
            );
        }
        let stored = |p: [f64; 3]| [0, 1, 2].map(|k| (p[k] - origin[k]) as f32);
        let [low, high] = mesh.bounds();
        self.accessors[first]["min"] = json!(stored(low));
        self.accessors[first]["max"] = json!(stored(high));
        let (indices, attributes) = (first + columns.len() - 1, &columns[..columns.len() - 1]);
        let attributes = attributes.iter().zip(first..);
        let attributes = attributes.map(|(c, i)| (c.name.clone(), json!(i)));
        let attributes: serde_json::Map<_, _> = attributes.collect();
        json!({"attributes": attributes, "indices": indices, "material": 0})
    }

    /// An accessor of floats, so many to a value, with their bounds; they come next in the buffer.
    pub(in crate::export) fn floats(
        &mut self,
        width: usize,
        values: &[f32],
        target: Option<u32>,
    ) -> usize {
        let component = |k: usize| values.iter().skip(k).step_by(width).copied();
        let bound = |pick: fn(f32, f32) -> f32| -> Vec<f32> {
            let of = |k| component(k).reduce(pick).unwrap_or_default();
            (0..width).map(of).collect()
        };
        let shape = if width == 1 { "SCALAR" } else { "VEC3" };
        let accessor = json!({
            "componentType": FLOAT, "count": values.len() / width, "type": shape,
            "min": bound(f32::min), "max": bound(f32::max),
        });
        self.add(size_of_val(values), target, accessor)
    }

    fn add(&mut self, bytes: usize, target: Option<u32>, mut accessor: Value) -> usize {
        let mut view = json!({"buffer": 0, "byteOffset": self.size, "byteLength": bytes});
        if let Some(target) = target {
            view["target"] = target.into();
        }
        self.size += bytes;
        accessor["bufferView"] = self.views.len().into();
        self.views.push(view);
        self.accessors.push(accessor);
        self.accessors.len() - 1
    }

    /// Puts all of them into a document, and gives the size of its buffer.
    pub(in crate::export) fn describe_in(self, document: &mut Value) -> usize {
        document["accessors"] = self.accessors.into();
        document["bufferViews"] = self.views.into();
        document["buffers"] = json!([{ "byteLength": self.size }]);
        self.size
    }
}

/// The bytes of a mesh's columns.
pub(in crate::export) fn write_body(
    mesh: &TriMesh,
    origin: [f64; 3],
    out: &mut dyn Write,
) -> io::Result<()> {
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
