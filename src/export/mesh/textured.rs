//! A mesh with a material of textures, as binary glTF 2.0.

use std::io::{self, Write};

use serde_json::{Value, json};

use super::{MeshError, TriMesh, finite};
use crate::export::Placement;
use crate::export::glb::{FLOAT, INDICES, UNSIGNED_INT, VERTICES, document, node, write_head};

/// A mesh to carry textures. All columns have a row for each vertex; `shape` has no colours and no
/// attributes.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TexturedMesh {
    /// Positions, normals and triangles.
    pub shape: TriMesh,
    /// Texture coordinates as glTF has them: (0, 0) is the upper left corner of an image.
    pub uvs: Vec<[f32; 2]>,
    /// Unit vectors towards the image's right, and the sign of the bitangent.
    pub tangents: Vec<[f32; 4]>,
}

/// The images of a material, as PNG files.
#[derive(Clone, Copy, Debug)]
pub struct MapImages<'a> {
    /// sRGB.
    pub base_color: &'a [u8],
    /// Tangent space, +Y.
    pub normal: &'a [u8],
    /// Red occlusion, green roughness, blue metallic.
    pub orm: &'a [u8],
}

const REPEAT: u32 = 10497;
const LINEAR: u32 = 9729;
const LINEAR_MIPMAP_LINEAR: u32 = 9987;

impl TexturedMesh {
    /// Turns and scales the mesh into the axes and units of a file.
    pub fn place(&mut self, placement: &Placement) {
        self.shape.place(placement);
        for tangent in &mut self.tangents {
            let [x, y, z, sign] = *tangent;
            let [x, y, z] = placement.turn([x, y, z]);
            *tangent = [x, y, z, sign];
        }
    }

    /// Writes it as it is placed, with its images inside.
    ///
    /// # Errors
    /// Those of `out`; `InvalidData` around a [`MeshError`] when the mesh is not sound; `InvalidInput`
    /// beyond 4 GiB.
    pub fn write_glb(&self, images: &MapImages, out: &mut dyn Write) -> io::Result<()> {
        self.check()
            .map_err(|e| io::Error::new(io::ErrorKind::InvalidData, e))?;
        let mut body = Body::default();
        let origin = self.shape.origin();
        let attributes = self.vertices(origin, &mut body);
        let corners = self.shape.triangles.as_flattened();
        let indices = body.column(UNSIGNED_INT, "SCALAR", corners.len(), INDICES, |bytes| {
            corners.iter().for_each(|i| bytes.extend(i.to_le_bytes()));
        });
        for (name, png) in [
            ("base_color", images.base_color),
            ("normal", images.normal),
            ("orm", images.orm),
        ] {
            let view = body.view(None, |bytes| bytes.extend_from_slice(png));
            body.images
                .push(json!({"bufferView": view, "mimeType": "image/png", "name": name}));
        }
        let primitive = json!({"attributes": attributes, "indices": indices, "material": 0});
        let name = self.shape.object();
        let shape = json!({"name": name, "primitives": [primitive]});
        let mut document = document(node(&name, origin), shape);
        document["materials"] = json!([material()]);
        document["textures"] = (0..3).map(|i| json!({"source": i, "sampler": 0})).collect();
        document["samplers"] = json!([{
            "magFilter": LINEAR, "minFilter": LINEAR_MIPMAP_LINEAR, "wrapS": REPEAT, "wrapT": REPEAT,
        }]);
        document["images"] = body.images.into();
        document["accessors"] = body.accessors.into();
        document["bufferViews"] = body.views.into();
        document["buffers"] = json!([{ "byteLength": body.bytes.len() }]);
        write_head(&document, body.bytes.len(), out)?;
        out.write_all(&body.bytes)
    }

    /// As [`TriMesh::check`], of the columns that are written.
    pub(super) fn check(&self) -> Result<(), MeshError> {
        self.shape.check_with([
            ("normal", self.shape.normals.len()),
            ("uv", self.uvs.len()),
            ("tangent", self.tangents.len()),
        ])?;
        finite("normal", &self.shape.normals)?;
        finite("uv", &self.uvs)?;
        finite("tangent", &self.tangents)
    }

    fn vertices(&self, origin: [f64; 3], body: &mut Body) -> Value {
        let count = self.shape.positions.len();
        let stored = |p: [f64; 3]| [0, 1, 2].map(|k| (p[k] - origin[k]) as f32);
        let positions: Vec<[f32; 3]> = self.shape.positions.iter().map(|p| stored(*p)).collect();
        let mut floats = |shape, values: &[f32]| {
            body.column(FLOAT, shape, count, VERTICES, |bytes| {
                values.iter().for_each(|x| bytes.extend(x.to_le_bytes()));
            })
        };
        let attributes = json!({
            "POSITION": floats("VEC3", positions.as_flattened()),
            "NORMAL": floats("VEC3", self.shape.normals.as_flattened()),
            "TANGENT": floats("VEC4", self.tangents.as_flattened()),
            "TEXCOORD_0": floats("VEC2", self.uvs.as_flattened()),
        });
        let [low, high] = self.shape.bounds();
        let position = attributes["POSITION"].as_u64().unwrap_or(0) as usize;
        body.accessors[position]["min"] = json!(stored(low));
        body.accessors[position]["max"] = json!(stored(high));
        attributes
    }
}

fn material() -> Value {
    json!({
        "name": "lichened",
        "pbrMetallicRoughness": {
            "baseColorTexture": {"index": 0},
            "metallicRoughnessTexture": {"index": 2},
        },
        "normalTexture": {"index": 1},
        "occlusionTexture": {"index": 2},
    })
}

/// A buffer that is being filled, and what describes it.
#[derive(Default)]
struct Body {
    bytes: Vec<u8>,
    views: Vec<Value>,
    accessors: Vec<Value>,
    images: Vec<Value>,
}

impl Body {
    /// A view of what `fill` adds, its end padded to a multiple of four.
    fn view(&mut self, target: Option<u32>, fill: impl FnOnce(&mut Vec<u8>)) -> usize {
        let start = self.bytes.len();
        fill(&mut self.bytes);
        let length = self.bytes.len() - start;
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        let mut view = json!({"buffer": 0, "byteOffset": start, "byteLength": length});
        if let Some(target) = target {
            view["target"] = target.into();
        }
        self.views.push(view);
        self.views.len() - 1
    }

    /// An accessor of its own view.
    fn column(
        &mut self,
        component: u32,
        shape: &str,
        count: usize,
        target: u32,
        fill: impl FnOnce(&mut Vec<u8>),
    ) -> usize {
        let view = self.view(Some(target), fill);
        self.accessors.push(json!({
            "bufferView": view, "componentType": component, "count": count, "type": shape,
        }));
        self.accessors.len() - 1
    }
}
