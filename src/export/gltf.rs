//! glTF 2.0, binary or as JSON with its buffer inside (Khronos, *glTF 2.0 Specification*): points,
//! lines, and instances by `EXT_mesh_gpu_instancing`.
//!
//! Attributes are application-specific ones, `_BIRTH` and so on, as float32: glTF has no 32-bit
//! integers for them, so that whole numbers are exact up to 2²⁴. Colours are linear light.

use std::io::{self, Write};

use serde_json::{Map, Value, json};

use super::AgeColor;
use super::base64::base64;
use super::columns::columns;
use super::glb::{
    FLOAT, INDICES, LINES, POINTS, TRIANGLES, UNSIGNED_INT, UNSIGNED_SHORT, VERTICES, document,
    node, write_head,
};
use super::lobe::Lobe;
use super::scene::Scene;
use crate::color::to_linear;

const INSTANCING: &str = "EXT_mesh_gpu_instancing";

/// A finished asset.
pub(super) struct Asset {
    root: Value,
    buffer: Vec<u8>,
}

pub(super) fn points(scene: &Scene, color: AgeColor<'_>) -> Asset {
    let mut parts = Parts::default();
    let attributes = parts.vertices(scene, color);
    let primitive = json!({"attributes": attributes, "mode": POINTS, "material": 0});
    let mesh = json!({"name": "elements", "primitives": [primitive]});
    parts.finish(mesh, node("lichen", scene.origin()), &[])
}

pub(super) fn curves(scene: &Scene, color: AgeColor<'_>) -> Asset {
    let mut parts = Parts::default();
    let attributes = parts.vertices(scene, color);
    let links = scene.streams.iter().flat_map(|s| s.windows(2)).flatten();
    let indices = parts.indices(links.copied());
    let primitive =
        json!({"attributes": attributes, "indices": indices, "mode": LINES, "material": 0});
    let mesh = json!({"name": "branches", "primitives": [primitive]});
    parts.finish(mesh, node("lichen", scene.origin()), &[])
}

pub(super) fn instances(scene: &Scene, color: AgeColor<'_>) -> Asset {
    let mut parts = Parts::default();
    let lobe = Lobe::new();
    let position = parts.bounded(&lobe.positions);
    let normal = parts.floats(VERTICES, "VEC3", lobe.normals.iter().copied());
    let indices = parts.indices(lobe.triangles.into_iter().flatten());
    let primitive = json!({
        "attributes": {"POSITION": position, "NORMAL": normal},
        "indices": indices, "mode": TRIANGLES, "material": 0,
    });
    let mesh = json!({"name": "lobe", "primitives": [primitive]});
    let mut node = node("lichen", scene.origin());
    node["extensions"] = json!({INSTANCING: {"attributes": parts.instances(scene, color)}});
    parts.finish(mesh, node, &[INSTANCING])
}

/// Accessors and the buffer that they look into.
#[derive(Default)]
struct Parts {
    buffer: Vec<u8>,
    views: Vec<Value>,
    accessors: Vec<Value>,
}

impl Parts {
    /// The elements as vertices.
    fn vertices(&mut self, scene: &Scene, color: AgeColor<'_>) -> Map<String, Value> {
        let elements = &scene.elements;
        let mut attributes = Map::new();
        let position = self.bounded(&scene.local_positions());
        attributes.insert("POSITION".into(), position.into());
        let normals = elements.normals.iter().copied();
        let normal = self.floats(VERTICES, "VEC3", normals);
        attributes.insert("NORMAL".into(), normal.into());
        let colors = (0..elements.len()).map(|i| color(elements.age(i)).map(to_linear));
        attributes.insert("COLOR_0".into(), self.colors(colors).into());
        self.columns(scene, VERTICES, &mut attributes);
        attributes
    }

    /// The elements as instances.
    fn instances(&mut self, scene: &Scene, color: AgeColor<'_>) -> Map<String, Value> {
        let elements = &scene.elements;
        let radius = elements.radius as f32;
        let mut attributes = Map::new();
        let positions = scene.local_positions();
        let translation = self.floats(0, "VEC3", positions.into_iter());
        attributes.insert("TRANSLATION".into(), translation.into());
        let rotation = self.floats(0, "VEC4", scene.orientations.iter().copied());
        attributes.insert("ROTATION".into(), rotation.into());
        let scales = elements.positions.iter().map(|_| [radius; 3]);
        attributes.insert("SCALE".into(), self.floats(0, "VEC3", scales).into());
        let colors = (0..elements.len()).map(|i| color(elements.age(i)).map(to_linear));
        attributes.insert("_COLOR_0".into(), self.floats(0, "VEC3", colors).into());
        self.columns(scene, 0, &mut attributes);
        attributes
    }

    /// Every further column as `_NAME`: single numbers, as Blender 5.0 fails over attributes of
    /// different widths.
    fn columns(&mut self, scene: &Scene, target: u32, attributes: &mut Map<String, Value>) {
        const HELD: [&str; 6] = ["x", "y", "z", "nx", "ny", "nz"];
        let columns = columns(&scene.elements);
        for column in columns.iter().filter(|c| !HELD.contains(&c.name.as_str())) {
            let value = |row| [column.at(row).single()];
            let accessor = self.floats(target, "SCALAR", (0..scene.elements.len()).map(value));
            attributes.insert(format!("_{}", column.name.to_uppercase()), accessor.into());
        }
    }

    fn bounded(&mut self, positions: &[[f32; 3]]) -> usize {
        let accessor = self.floats(VERTICES, "VEC3", positions.iter().copied());
        let corner = |pick: fn(f32, f32) -> f32| {
            [0, 1, 2].map(|k| {
                positions
                    .iter()
                    .map(|p| p[k])
                    .reduce(pick)
                    .unwrap_or_default()
            })
        };
        self.accessors[accessor]["min"] = json!(corner(f32::min));
        self.accessors[accessor]["max"] = json!(corner(f32::max));
        accessor
    }

    fn floats<const N: usize>(
        &mut self,
        target: u32,
        kind: &str,
        values: impl ExactSizeIterator<Item = [f32; N]>,
    ) -> usize {
        let (start, count) = (self.buffer.len(), values.len());
        for value in values {
            let bytes = value.map(f32::to_le_bytes);
            self.buffer.extend_from_slice(bytes.as_flattened());
        }
        self.accessor(
            start,
            target,
            json!({"componentType": FLOAT, "count": count, "type": kind}),
        )
    }

    /// Opaque colours in 16 bits a channel.
    fn colors(&mut self, colors: impl ExactSizeIterator<Item = [f32; 3]>) -> usize {
        let (start, count) = (self.buffer.len(), colors.len());
        for [r, g, b] in colors {
            let bytes = [r, g, b, 1.0].map(|c| ((c * 65535.0 + 0.5) as u16).to_le_bytes());
            self.buffer.extend_from_slice(bytes.as_flattened());
        }
        let accessor = json!({
            "componentType": UNSIGNED_SHORT, "normalized": true, "count": count, "type": "VEC4",
        });
        self.accessor(start, VERTICES, accessor)
    }

    fn indices(&mut self, indices: impl Iterator<Item = u32>) -> usize {
        let start = self.buffer.len();
        indices.for_each(|i| self.buffer.extend_from_slice(&i.to_le_bytes()));
        let count = (self.buffer.len() - start) / 4;
        let accessor = json!({"componentType": UNSIGNED_INT, "count": count, "type": "SCALAR"});
        self.accessor(start, INDICES, accessor)
    }

    /// An accessor to what the buffer holds from `start`; target 0 is none.
    fn accessor(&mut self, start: usize, target: u32, mut accessor: Value) -> usize {
        let length = self.buffer.len() - start;
        let mut view = json!({"buffer": 0, "byteOffset": start, "byteLength": length});
        if target != 0 {
            view["target"] = target.into();
        }
        accessor["bufferView"] = self.views.len().into();
        self.views.push(view);
        self.accessors.push(accessor);
        self.accessors.len() - 1
    }

    fn finish(self, mesh: Value, node: Value, extensions: &[&str]) -> Asset {
        let mut root = document(node, mesh);
        root["accessors"] = self.accessors.into();
        root["bufferViews"] = self.views.into();
        root["buffers"] = json!([{"byteLength": self.buffer.len()}]);
        if !extensions.is_empty() {
            root["extensionsUsed"] = json!(extensions);
            root["extensionsRequired"] = json!(extensions);
        }
        Asset {
            root,
            buffer: self.buffer,
        }
    }
}

impl Asset {
    /// One binary file.
    pub(super) fn write_glb(self, out: &mut dyn Write) -> io::Result<()> {
        write_head(&self.root, self.buffer.len(), out)?;
        out.write_all(&self.buffer)
    }

    /// One text file, its buffer as a data URI.
    pub(super) fn write_gltf(mut self, out: &mut dyn Write) -> io::Result<()> {
        let uri = format!(
            "data:application/octet-stream;base64,{}",
            base64(&self.buffer)
        );
        self.root["buffers"][0]["uri"] = uri.into();
        serde_json::to_writer_pretty(&mut *out, &self.root)?;
        out.write_all(b"\n")
    }
}
