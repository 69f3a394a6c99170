//! Objects with materials of textures, as binary glTF 2.0.

use std::collections::HashMap;
use std::error::Error;
use std::io::{self, Write};

use serde_json::{Value, json};

use super::worn::Worn;
use super::{MeshError, Stance, TriMesh, bounds, finite, needs_doubles};
use crate::export::Placement;
use crate::export::glb::{FLOAT, INDICES, UNSIGNED_INT, VERTICES, document, write_head};
use crate::substrate::{Alpha, Material};

/// A mesh to carry textures. All columns have a row for each vertex; `shape` has no colours and no
/// attributes.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TexturedMesh {
    /// Positions, normals and triangles.
    pub shape: TriMesh,
    /// Texture coordinates as glTF has them: (0, 0) is the upper left corner of an image.
    pub uvs: Vec<[f32; 2]>,
    /// Unit vectors towards the image's right, and the sign of the bitangent. May be left out, as the next two.
    pub tangents: Vec<[f32; 4]>,
    /// A second set of texture coordinates.
    pub second_uvs: Vec<[f32; 2]>,
    /// Colours, linear light: factors to the material's.
    pub colors: Vec<[f32; 3]>,
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
    /// What their names begin with, and end with: `rock_base_color.1001`.
    pub affixes: [String; 2],
    /// sRGB.
    pub base_color: Vec<u8>,
    /// Tangent space, +Y.
    pub normal: Vec<u8>,
    /// Red occlusion, green roughness, blue metallic.
    pub orm: Vec<u8>,
}

/// What a surface wears.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TexturedMaterial {
    /// What it is called.
    pub name: String,
    /// What it shows.
    pub look: SurfaceLook,
    /// What is seen through it, by the alpha of its base colour.
    pub alpha: Alpha,
    /// Whether it shows from behind.
    pub is_double_sided: bool,
}

/// What a material shows.
#[derive(Clone, Debug, PartialEq)]
pub enum SurfaceLook {
    /// What was baked.
    Maps(MapImages),
    /// What a mesh file says; its textures name [images of the scene](TexturedScene::images).
    Own(Box<Material>),
}

impl Default for SurfaceLook {
    fn default() -> Self {
        Self::Maps(MapImages::default())
    }
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
    /// PNG and JPEG files that materials of a mesh file name. Those that none names are not written.
    pub images: Vec<Vec<u8>>,
}

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
        self.materials.push(material);
        self.add_meshes(self.materials.len() - 1, meshes);
    }

    /// The same for a material that is there, or will be, at this place.
    pub fn add_meshes(&mut self, worn: usize, meshes: Vec<(TexturedObject, TexturedMesh)>) {
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
            object
                .stance
                .iter_mut()
                .for_each(|stance| stance.place(placement));
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
        let (nodes, shapes): (Vec<Value>, Vec<Value>) = self
            .objects
            .iter()
            .enumerate()
            .map(|(number, object)| self.object(number, object, &mut body))
            .unzip();
        let (worn, materials) = Worn::of(&self.name, &self.materials, &self.images)?;
        for (name, file) in worn.images() {
            body.image(name, file);
        }
        let mut document = document(Value::Null, Value::Null);
        document["nodes"] = self.rooted(nodes).into();
        document["meshes"] = shapes.into();
        document["materials"] = materials.into();
        worn.say(&mut document);
        if !body.images.is_empty() {
            document["images"] = body.images.into();
        }
        document["accessors"] = body.accessors.into();
        document["bufferViews"] = body.views.into();
        document["buffers"] = json!([{ "byteLength": body.length }]);
        write_head(&document, body.length, out)?;
        out.write_all(&body.bytes)?;
        for (_, file) in worn.images() {
            out.write_all(file)?;
            out.write_all(&[0; 3][..padding(file.len())])?;
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

    /// Bytes of all images.
    pub fn image_bytes(&self) -> usize {
        let maps = self
            .materials
            .iter()
            .flat_map(|material| match &material.look {
                SurfaceLook::Maps(images) => images.named().map(|(_, png)| png.len()).to_vec(),
                SurfaceLook::Own(_) => Vec::new(),
            });
        let own = self.images.iter().map(Vec::len);
        maps.chain(own).sum()
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
        let name = object
            .name
            .as_ref()
            .filter(|_| !is_alone)
            .unwrap_or(&self.name);
        let name = name.replace(char::is_control, " ");
        let stance = object.stored_from();
        let primitives = object
            .meshes
            .iter()
            .map(|(material, mesh)| mesh.primitive(*material, &stance, body))
            .collect::<Vec<Value>>();
        let mut node = json!({"name": name, "mesh": number});
        stance.said_in(&mut node);
        (node, json!({"name": name, "primitives": primitives}))
    }
}

impl MapImages {
    /// In the order in which a file has them.
    pub(super) fn named(&self) -> [(String, &[u8]); 3] {
        let [first, last] = &self.affixes;
        let all = [
            ("base_color", &self.base_color),
            ("normal", &self.normal),
            ("orm", &self.orm),
        ];
        all.map(|(kind, png)| (format!("{first}{kind}{last}"), &png[..]))
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
        let needed = [("normal", self.shape.normals.len()), ("uv", self.uvs.len())];
        let others = [
            ("tangent", self.tangents.len()),
            ("second uv", self.second_uvs.len()),
            ("color", self.colors.len()),
        ];
        let others = others.into_iter().filter(|(_, length)| *length > 0);
        self.shape.check_with(needed.into_iter().chain(others))?;
        finite("normal", &self.shape.normals)?;
        finite("uv", &self.uvs)?;
        finite("tangent", &self.tangents)?;
        finite("second uv", &self.second_uvs)?;
        finite("color", &self.colors)
    }

    fn vertices(&self, stance: &Stance, body: &mut Body) -> Value {
        let count = self.shape.positions.len();
        let stored = |p: &[f64; 3]| stance.point(*p).map(|x| x as f32);
        let positions: Vec<[f32; 3]> = self.shape.positions.iter().map(stored).collect();
        let normals: Vec<[f32; 3]> = self
            .shape
            .normals
            .iter()
            .map(|normal| stance.direction(*normal))
            .collect();
        let tangents: Vec<[f32; 4]> = self
            .tangents
            .iter()
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
        let mut attributes = json!({
            "POSITION": floats("VEC3", positions.as_flattened()),
            "NORMAL": floats("VEC3", normals.as_flattened()),
        });
        for (name, shape, values) in [
            ("TANGENT", "VEC4", tangents.as_flattened()),
            ("TEXCOORD_0", "VEC2", self.uvs.as_flattened()),
            ("TEXCOORD_1", "VEC2", self.second_uvs.as_flattened()),
            ("COLOR_0", "VEC3", self.colors.as_flattened()),
        ] {
            if !values.is_empty() {
                attributes[name] = floats(shape, values).into();
            }
        }
        let wide = positions.iter().map(|p| p.map(f64::from));
        let [low, high] = bounds(wide).map(|corner| corner.map(|x| x as f32));
        let position = attributes["POSITION"].as_u64().unwrap_or(0) as usize;
        body.accessors[position]["min"] = json!(low);
        body.accessors[position]["max"] = json!(high);
        attributes
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
    /// An image, after which there is nothing but images.
    fn image(&mut self, name: &str, file: &[u8]) {
        let length = file.len();
        let kind = match file.starts_with(b"\xff\xd8") {
            true => "image/jpeg",
            false => "image/png",
        };
        let view = json!({"buffer": 0, "byteOffset": self.length, "byteLength": length});
        self.views.push(view);
        self.length += length + padding(length);
        let view = self.views.len() - 1;
        let image = json!({"bufferView": view, "mimeType": kind, "name": name});
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
