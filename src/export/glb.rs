//! The container of binary glTF ("GLB File Format" in Khronos, *glTF 2.0 Specification*), and what
//! every file of ours says in it.

use std::io::{self, Write};

use serde_json::{Value, json};

/// Modes of primitives, by their numbers in the specification, as all of these are.
pub(super) const POINTS: u32 = 0;
pub(super) const LINES: u32 = 1;
pub(super) const TRIANGLES: u32 = 4;

/// Types of numbers.
pub(super) const UNSIGNED_SHORT: u32 = 5123;
pub(super) const UNSIGNED_INT: u32 = 5125;
pub(super) const FLOAT: u32 = 5126;

/// What a view is for: `ARRAY_BUFFER` and `ELEMENT_ARRAY_BUFFER`.
pub(super) const VERTICES: u32 = 34962;
pub(super) const INDICES: u32 = 34963;

/// A document of one node with one mesh, without its buffer and what lies in it.
pub(super) fn document(node: Value, mesh: Value) -> Value {
    let material = json!({
        "name": "lichen",
        "pbrMetallicRoughness": {"metallicFactor": 0.0, "roughnessFactor": 0.9},
    });
    json!({
        "asset": {"version": "2.0", "generator": concat!("thallus ", env!("CARGO_PKG_VERSION"))},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [node],
        "meshes": [mesh],
        "materials": [material],
    })
}

/// The node of the first mesh, moved by a vector.
pub(super) fn node(name: &str, translation: [f64; 3]) -> Value {
    let mut node = json!({"name": name, "mesh": 0});
    if translation != [0.0; 3] {
        node["translation"] = json!(translation);
    }
    node
}

/// The file up to the buffer, which has so many bytes, a multiple of four.
pub(super) fn write_head(document: &Value, buffer: usize, out: &mut dyn Write) -> io::Result<()> {
    const HEADS: usize = 12 + 8 + 8;
    let mut text = document.to_string().into_bytes();
    text.resize(text.len().next_multiple_of(4), b' ');
    let heads = if buffer == 0 { HEADS - 8 } else { HEADS };
    let total = u32::try_from(heads + text.len() + buffer).map_err(|_| {
        let problem = "a .glb ends at 4 GiB and this needs more: write it to .ply or .usda";
        io::Error::new(io::ErrorKind::InvalidInput, problem)
    })?;
    out.write_all(b"glTF")?;
    out.write_all(&2_u32.to_le_bytes())?;
    out.write_all(&total.to_le_bytes())?;
    out.write_all(&(text.len() as u32).to_le_bytes())?;
    out.write_all(b"JSON")?;
    out.write_all(&text)?;
    if buffer == 0 {
        return Ok(());
    }
    out.write_all(&(buffer as u32).to_le_bytes())?;
    out.write_all(b"BIN\0")
}
