//! Objects with materials of textures, as binary glTF 2.0.

use std::collections::HashMap;
use std::error::Error;
use std::io::{self, Write};

use serde_json::{Value, json};

use super::{MeshError, Stance, TriMesh, bounds, finite, needs_doubles};
use crate::export::Placement;
use crate::export::glb::{FLOAT, INDICES, UNSIGNED_INT, VERTICES, document, write_head};
use crate::substrate::Alpha;

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

/// An object of a scene.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TexturedObject {
    /// What it is called: as its scene, where it has no name.
    pub name: Option<String>,
    /// Where it stands, in the units and axes of its meshes: as the scene, where nothing is said.
    pub stance: Option<Stance>,
    /// What it consists of, each with the place of its material.
    pub meshes: Vec<(usize, TexturedMesh)>,
}

/// The images of a material, as PNG files.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct MapImages {
    /// sRGB.
    pub base_color: Vec<u8>,
    /// Tangent space, +Y.
    pub normal: Vec<u8>,
    /// Red occlusion, green roughness, blue metallic.
    pub orm: Vec<u8>,
}

/// Images as a surface wears them.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TexturedMaterial {
    /// What it is called.
    pub name: String,
    /// What it shows.
    pub images: MapImages,
    /// What is seen through it, by the alpha of its base colour.
    pub alpha: Alpha,
    /// Whether it shows from behind.
    pub is_double_sided: bool,
}

/// Objects and what they wear, for one file.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TexturedScene {
    /// What all of it is called.
    pub name: String,
    /// Each with the places of its materials.
    pub objects: Vec<TexturedObject>,
    /// What these wear.
    pub materials: Vec<TexturedMaterial>,
}

const REPEAT: u32 = 10497;
const LINEAR: u32 = 9729;
const LINEAR_MIPMAP_LINEAR: u32 = 9987;

impl TexturedScene {
    /// A scene without objects.
    pub fn new(name: &str) -> Self {
        Self {
            name: name.to_owned(),
            ..Self::default()
        }
    }

    /// Adds a material and the meshes that wear it, each to the object of its name and stance, if that is there.
    pub fn add(&mut self, material: TexturedMaterial, meshes: Vec<(TexturedObject, TexturedMesh)>) {
        let worn = self.materials.len();
        self.materials.push(material);
        let numbered = self.objects.iter().enumerate();
        let mut places: HashMap<_, usize> = numbered.map(|(i, o)| (o.key(), i)).collect();
        for (of, mesh) in meshes {
            let place = *places.entry(of.key()).or_insert(self.objects.len());
            if place == self.objects.len() {
                self.objects.push(of);
            }
            self.objects[place].meshes.push((worn, mesh));
        }
    }

    /// Turns and scales it into the axes and units of a file.
    pub fn place(&mut self, placement: &Placement) {
        for object in &mut self.objects {
            { object.stance.iter_mut() }.for_each(|stance| stance.place(placement));
            let meshes = object.meshes.iter_mut();
            meshes.for_each(|(_, mesh)| mesh.place(placement));
        }
    }

    /// Writes it as it is placed, with its images inside. Several objects are children of a node that is called as the
    /// scene.
    ///
    /// # Errors
    /// Those of `out`; `InvalidData` when there is no object, a mesh has a material that is not there, or around a
    /// [`MeshError`] when one is not sound; `InvalidInput` beyond 4 GiB.
    pub fn write_glb(&self, out: &mut dyn Write) -> io::Result<()> {
        self.check()?;
        let mut body = Body::default();
        let (nodes, shapes): (Vec<Value>, Vec<Value>) = { self.objects.iter().enumerate() }
            .map(|(number, object)| self.object(number, object, &mut body))
            .unzip();
        for images in self.materials.iter().map(|material| &material.images) {
            for (name, png) in images.named() {
                body.image(name, png.len());
            }
        }
        let mut document = document(Value::Null, Value::Null);
        document["nodes"] = self.rooted(nodes).into();
        document["meshes"] = shapes.into();
        let materials = self.materials.iter().enumerate();
        document["materials"] = materials.map(|(i, m)| m.said(i)).collect();
        let textures = 0..body.images.len();
        document["textures"] = textures
            .map(|i| json!({"source": i, "sampler": 0}))
            .collect();
        document["samplers"] = json!([{
            "magFilter": LINEAR, "minFilter": LINEAR_MIPMAP_LINEAR, "wrapS": REPEAT, "wrapT": REPEAT,
        }]);
        document["images"] = body.images.into();
        document["accessors"] = body.accessors.into();
        document["bufferViews"] = body.views.into();
        document["buffers"] = json!([{ "byteLength": body.length }]);
        write_head(&document, body.length, out)?;
        out.write_all(&body.bytes)?;
        let images = { self.materials.iter() }.flat_map(|material| material.images.named());
        for (_, png) in images {
            out.write_all(png)?;
            out.write_all(&[0; 3][..padding(png.len())])?;
        }
        Ok(())
    }

    fn check(&self) -> io::Result<()> {
        let invalid =
            |e: Box<dyn Error + Send + Sync>| io::Error::new(io::ErrorKind::InvalidData, e);
        if self.objects.is_empty() {
            return Err(invalid("there is no object to write".into()));
        }
        for (material, mesh) in self.objects.iter().flat_map(|object| &object.meshes) {
            mesh.check().map_err(|e| invalid(e.into()))?;
            if *material >= self.materials.len() {
                return Err(invalid(format!("there is no material {material}").into()));
            }
        }
        Ok(())
    }

    /// Bytes of the images of all materials.
    pub fn image_bytes(&self) -> usize {
        let images = { self.materials.iter() }.flat_map(|material| material.images.named());
        images.map(|(_, png)| png.len()).sum()
    }

    /// All nodes, the scene's first.
    fn rooted(&self, mut nodes: Vec<Value>) -> Vec<Value> {
        if nodes.len() != 1 {
            let children: Vec<usize> = (1..=nodes.len()).collect();
            nodes.insert(0, json!({"name": self.name, "children": children}));
        }
        nodes
    }

    /// The node and the mesh of an object of this number.
    fn object(&self, number: usize, object: &TexturedObject, body: &mut Body) -> (Value, Value) {
        let is_alone = self.objects.len() == 1;
        let name = { object.name.as_ref().filter(|_| !is_alone) }.unwrap_or(&self.name);
        let name = name.replace(char::is_control, " ");
        let stance = object.stored_from();
        let primitives = { object.meshes.iter() }
            .map(|(material, mesh)| mesh.primitive(*material, &stance, body))
            .collect::<Vec<Value>>();
        let mut node = json!({"name": name, "mesh": number});
        stance.said_in(&mut node);
        (node, json!({"name": name, "primitives": primitives}))
    }
}

impl MapImages {
    /// In the order in which a file has them.
    fn named(&self) -> [(&'static str, &[u8]); 3] {
        [
            ("base_color", &self.base_color),
            ("normal", &self.normal),
            ("orm", &self.orm),
        ]
    }
}

/// What tells objects of a scene from one another.
type Key = (Option<String>, Option<[u64; 8]>);

impl TexturedObject {
    fn key(&self) -> Key {
        (self.name.clone(), self.stance.map(|stance| stance.bits()))
    }

    /// Where its node puts it: as it stands, unless float32 would then move vertices.
    fn stored_from(&self) -> Stance {
        let stance = self.stance.unwrap_or(Stance::NONE);
        let [low, high] = self.bounds(|p| stance.point(p));
        if !needs_doubles([low, high]) {
            return stance;
        }
        let [low, high] = self.bounds(|p| p);
        Stance {
            origin: [0, 1, 2].map(|k| 0.5 * low[k] + 0.5 * high[k]),
            ..Stance::NONE
        }
    }

    /// Lower and upper corner of all places as they are stored.
    fn bounds(&self, stored: impl Fn([f64; 3]) -> [f64; 3]) -> [[f64; 3]; 2] {
        let meshes = self.meshes.iter();
        let places = meshes.flat_map(|(_, mesh)| mesh.shape.positions.iter().copied());
        bounds(places.map(stored))
    }
}

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

    fn primitive(&self, material: usize, stance: &Stance, body: &mut Body) -> Value {
        let attributes = self.vertices(stance, body);
        let corners = self.shape.triangles.as_flattened();
        let indices = body.column(UNSIGNED_INT, "SCALAR", corners.len(), INDICES, |bytes| {
            corners.iter().for_each(|i| bytes.extend(i.to_le_bytes()));
        });
        json!({"attributes": attributes, "indices": indices, "material": material})
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

    fn vertices(&self, stance: &Stance, body: &mut Body) -> Value {
        let count = self.shape.positions.len();
        let stored = |p: &[f64; 3]| stance.point(*p).map(|x| x as f32);
        let positions: Vec<[f32; 3]> = self.shape.positions.iter().map(stored).collect();
        let normals: Vec<[f32; 3]> = { self.shape.normals.iter() }
            .map(|normal| stance.direction(*normal))
            .collect();
        let tangents: Vec<[f32; 4]> = { self.tangents.iter() }
            .map(|&[x, y, z, sign]| {
                let [x, y, z] = stance.direction([x, y, z]);
                [x, y, z, sign]
            })
            .collect();
        let mut floats = |shape, values: &[f32]| {
            body.column(FLOAT, shape, count, VERTICES, |bytes| {
                values.iter().for_each(|x| bytes.extend(x.to_le_bytes()));
            })
        };
        let attributes = json!({
            "POSITION": floats("VEC3", positions.as_flattened()),
            "NORMAL": floats("VEC3", normals.as_flattened()),
            "TANGENT": floats("VEC4", tangents.as_flattened()),
            "TEXCOORD_0": floats("VEC2", self.uvs.as_flattened()),
        });
        let wide = positions.iter().map(|p| p.map(f64::from));
        let [low, high] = bounds(wide).map(|corner| corner.map(|x| x as f32));
        let position = attributes["POSITION"].as_u64().unwrap_or(0) as usize;
        body.accessors[position]["min"] = json!(low);
        body.accessors[position]["max"] = json!(high);
        attributes
    }
}

impl TexturedMaterial {
    /// As the material of this number, whose images come after those before it.
    fn said(&self, number: usize) -> Value {
        let texture = |image: usize| json!({"index": 3 * number + image});
        let mut said = json!({
            "name": self.name.replace(char::is_control, " "),
            "pbrMetallicRoughness": {
                "baseColorTexture": texture(0),
                "metallicRoughnessTexture": texture(2),
            },
            "normalTexture": texture(1),
            "occlusionTexture": texture(2),
        });
        match self.alpha {
            Alpha::Opaque => {}
            Alpha::Blend => said["alphaMode"] = "BLEND".into(),
            Alpha::Mask { cutoff } => {
                said["alphaMode"] = "MASK".into();
                said["alphaCutoff"] = cutoff.into();
            }
        }
        if self.is_double_sided {
            said["doubleSided"] = true.into();
        }
        said
    }
}

/// How many bytes are missing to a multiple of four.
fn padding(length: usize) -> usize {
    length.next_multiple_of(4) - length
}

/// A buffer that is being filled, and what describes it.
#[derive(Default)]
struct Body {
    /// Of all but images, which come after it and are not copied.
    bytes: Vec<u8>,
    /// With them.
    length: usize,
    views: Vec<Value>,
    accessors: Vec<Value>,
    images: Vec<Value>,
}

impl Body {
    /// An image of so many bytes, after which there is nothing but images.
    fn image(&mut self, name: &str, length: usize) {
        let view = json!({"buffer": 0, "byteOffset": self.length, "byteLength": length});
        self.views.push(view);
        self.length += length + padding(length);
        let view = self.views.len() - 1;
        let image = json!({"bufferView": view, "mimeType": "image/png", "name": name});
        self.images.push(image);
    }

    /// A view of what `fill` adds, its end padded to a multiple of four.
    fn view(&mut self, target: Option<u32>, fill: impl FnOnce(&mut Vec<u8>)) -> usize {
        let start = self.bytes.len();
        fill(&mut self.bytes);
        let length = self.bytes.len() - start;
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        self.length = self.bytes.len();
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
