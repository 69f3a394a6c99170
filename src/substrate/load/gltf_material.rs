//! The part of a glTF 2.0 document that says what its triangles look like.
//!
//! Read apart from the geometry, and only where textures are asked for: a fault here is a note, and
//! never keeps lichen from growing. Read are metallic-roughness materials with `KHR_texture_transform`;
//! textures of another coordinate set than the first two, and images other than PNG and JPEG, are passed
//! over.

use std::collections::{BTreeMap, BTreeSet};

use glam::DAffine3;
use serde::Deserialize;
use serde::de::IgnoredAny;
use serde_json::Value;

use crate::substrate::{Alpha, Material, Part, Texture, Texturing, Wrap};

use super::encoded_image;
use super::gltf_buffers::Buffers;
use super::gltf_schema::or_absent;

/// Whether a document has modes of alpha other than that which is usual, as far as words tell.
pub(super) fn speaks_of_openings(json: &[u8]) -> bool {
    let has = |word: &[u8]| memchr::memmem::find(json, word).is_some();
    has(b"\"alphaMode\"") && (has(b"\"MASK\"") || has(b"\"BLEND\""))
}

/// Materials, and which primitives have them.
#[derive(Default, Deserialize)]
pub(super) struct Looks {
    #[serde(default)]
    nodes: Vec<Named>,
    #[serde(default)]
    meshes: Vec<MeshLooks>,
    #[serde(default)]
    materials: Vec<Said>,
    #[serde(default)]
    textures: Vec<JsonTexture>,
    #[serde(default)]
    samplers: Vec<JsonSampler>,
    #[serde(default)]
    images: Vec<JsonImage>,
    #[serde(default, deserialize_with = "or_absent")]
    skins: Vec<IgnoredAny>,
    #[serde(default, deserialize_with = "or_absent")]
    animations: Vec<IgnoredAny>,
    /// Why nothing could be read.
    #[serde(skip)]
    fault: Option<String>,
}

#[derive(Deserialize)]
struct Named {
    #[serde(default)]
    name: Value,
}

#[derive(Deserialize)]
struct MeshLooks {
    #[serde(default)]
    name: Value,
    #[serde(default)]
    primitives: Vec<PrimitiveLooks>,
}

#[derive(Deserialize)]
struct PrimitiveLooks {
    material: Option<u32>,
}

/// A material and its name, which does not depend on whether the rest can be read.
#[derive(Deserialize)]
#[serde(from = "Value")]
struct Said {
    name: Value,
    material: Result<JsonMaterial, String>,
}

impl From<Value> for Said {
    fn from(said: Value) -> Self {
        let name = said.get("name").cloned().unwrap_or_default();
        let material = serde_json::from_value(said).map_err(|e| e.to_string());
        Self { name, material }
    }
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct JsonMaterial {
    #[serde(default)]
    pbr_metallic_roughness: MetallicRoughness,
    normal_texture: Option<TextureInfo>,
    occlusion_texture: Option<TextureInfo>,
    #[serde(default)]
    alpha_mode: Value,
    alpha_cutoff: Option<f32>,
    #[serde(default)]
    double_sided: bool,
    #[serde(default)]
    emissive_factor: [f32; 3],
    emissive_texture: Option<TextureInfo>,
    #[serde(default)]
    extensions: Value,
}

impl JsonMaterial {
    fn alpha(&self) -> Alpha {
        match self.alpha_mode.as_str() {
            Some("MASK") => Alpha::Mask {
                cutoff: self.alpha_cutoff.unwrap_or(0.5).max(0.0),
            },
            Some("BLEND") => Alpha::Blend,
            _ => Alpha::Opaque,
        }
    }

    /// Those that name no textures.
    fn plain_extensions(&self) -> BTreeMap<String, String> {
        let all = self.extensions.as_object().into_iter().flatten();
        all.filter(|(_, said)| !names_texture(said))
            .map(|(name, said)| (name.clone(), said.to_string()))
            .collect()
    }
}

/// Whether an extension says `index` anywhere, as all that name a texture do.
fn names_texture(said: &Value) -> bool {
    match said {
        Value::Object(fields) => fields.contains_key("index") || fields.values().any(names_texture),
        Value::Array(values) => values.iter().any(names_texture),
        _ => false,
    }
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase", default)]
struct MetallicRoughness {
    base_color_factor: [f32; 4],
    metallic_factor: f32,
    roughness_factor: f32,
    base_color_texture: Option<TextureInfo>,
    metallic_roughness_texture: Option<TextureInfo>,
}

impl Default for MetallicRoughness {
    fn default() -> Self {
        Self {
            base_color_factor: [1.0; 4],
            metallic_factor: 1.0,
            roughness_factor: 1.0,
            base_color_texture: None,
            metallic_roughness_texture: None,
        }
    }
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct TextureInfo {
    index: usize,
    #[serde(default)]
    tex_coord: u32,
    /// Of normals.
    scale: Option<f32>,
    /// Of occlusion.
    strength: Option<f32>,
    #[serde(default, deserialize_with = "or_absent")]
    extensions: TextureExtensions,
}

#[derive(Default, Deserialize)]
struct TextureExtensions {
    #[serde(rename = "KHR_texture_transform")]
    transform: Option<Transform>,
}

#[derive(Clone, Deserialize)]
#[serde(rename_all = "camelCase", default)]
struct Transform {
    offset: [f64; 2],
    rotation: f64,
    scale: [f64; 2],
    tex_coord: Option<u32>,
}

impl Default for Transform {
    fn default() -> Self {
        Self {
            offset: [0.0; 2],
            rotation: 0.0,
            scale: [1.0; 2],
            tex_coord: None,
        }
    }
}

impl Transform {
    /// Translation × rotation × scale, as the extension says.
    fn rows(&self) -> [[f64; 3]; 2] {
        let (sin, cos) = (libm::sin(self.rotation), libm::cos(self.rotation));
        let ([x, y], [sx, sy]) = (self.offset, self.scale);
        [[cos * sx, sin * sy, x], [-sin * sx, cos * sy, y]]
    }
}

#[derive(Deserialize)]
struct JsonTexture {
    source: Option<usize>,
    sampler: Option<usize>,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct JsonSampler {
    wrap_s: Option<u32>,
    wrap_t: Option<u32>,
}

impl JsonSampler {
    /// By the numbers of OpenGL that the specification has.
    fn wrap(&self) -> [Wrap; 2] {
        [self.wrap_s, self.wrap_t].map(|number| match number {
            Some(33_071) => Wrap::Clamp,
            Some(33_648) => Wrap::Mirror,
            _ => Wrap::Repeat,
        })
    }
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct JsonImage {
    uri: Option<String>,
    buffer_view: Option<usize>,
}

impl Looks {
    pub(super) fn read(json: &[u8]) -> Self {
        serde_json::from_slice(json).unwrap_or_else(|e| Self {
            fault: Some(e.to_string()),
            ..Self::default()
        })
    }

    /// The material of a mesh's primitive.
    pub(super) fn material_of(&self, mesh: usize, primitive: usize) -> Option<u32> {
        let material = self.meshes.get(mesh)?.primitives.get(primitive)?.material?;
        ((material as usize) < self.materials.len()).then_some(material)
    }

    /// What the triangles of a node's primitive are part of, by the node and those above it; nothing, where nothing has
    /// a name.
    pub(super) fn part_of(
        &self,
        (mut line, world): (impl Iterator<Item = usize>, DAffine3),
        mesh: usize,
        material: Option<u32>,
    ) -> Option<Part> {
        let text = |name: &Value| text_of(name).map(str::to_owned);
        let mut named = || {
            Some(
                self.nodes
                    .get(line.next()?)
                    .and_then(|node| text(&node.name)),
            )
        };
        let node = named().flatten();
        let above: Vec<String> = std::iter::from_fn(named).flatten().collect();
        let mesh = self.meshes.get(mesh).and_then(|mesh| text(&mesh.name));
        let material = material.and_then(|material| self.materials.get(material as usize));
        let part = Part {
            has_own_name: node.is_some() || mesh.is_some(),
            objects: node.into_iter().chain(mesh).chain(above).collect(),
            material: material.and_then(|material| text(&material.name)),
            frame: Some(world.to_cols_array_2d()),
        };
        (!part.objects.is_empty() || part.material.is_some()).then_some(part)
    }

    /// Adds the materials and the images that they name.
    pub(super) fn materials_into(&self, out: &mut Texturing, buffers: &Buffers) {
        if let Some(fault) = &self.fault {
            out.notes
                .push(format!("materials cannot be read ({fault})"));
        }
        out.is_posed = !self.skins.is_empty() || !self.animations.is_empty();
        let numbers: BTreeSet<u32> = out.material_of.iter().flatten().copied().collect();
        let known = self.materials.len() as u32;
        let named = self.meshes.iter().flat_map(|mesh| &mesh.primitives);
        let mut named = named.filter_map(|primitive| primitive.material);
        if let Some(number) = named.find(|number| *number >= known) {
            out.notes.push(format!(
                "a part is made of material {number}, and the file has {known}: what it looks like is not known"
            ));
        }
        let all = 0..known;
        let used: Vec<bool> = all.map(|m| numbers.contains(&m)).collect();
        let mut images = Images {
            looks: self,
            buffers,
            places: vec![None; self.images.len()],
            out,
        };
        for (said, used) in self.materials.iter().zip(used) {
            let name = text_of(&said.name).unwrap_or("without a name");
            let read = match &said.material {
                Ok(material) => images.material((material, name), used),
                Err(problem) => {
                    let note = format!("material {name} cannot be read ({problem})");
                    images.out.notes.push(note);
                    Material::default()
                }
            };
            images.out.materials.push(read);
        }
    }
}

/// Reads each image that a material names once.
struct Images<'a> {
    looks: &'a Looks,
    buffers: &'a Buffers<'a>,
    /// Where images of the document went; `Some(None)` for one that cannot be read.
    places: Vec<Option<Option<usize>>>,
    out: &'a mut Texturing,
}

/// What is no text, or nothing but space, is no name, and no fault of the materials.
fn text_of(name: &Value) -> Option<&str> {
    name.as_str().filter(|name| !name.trim().is_empty())
}

/// A factor, which by the schema is from 0 to 1.
fn share(factor: f32) -> f32 {
    factor.clamp(0.0, 1.0)
}

impl Images<'_> {
    fn material(&mut self, (material, name): (&JsonMaterial, &str), used: bool) -> Material {
        let pbr = &material.pbr_metallic_roughness;
        let [r, g, b, opacity] = pbr.base_color_factor;
        let color = [r, g, b].map(share);
        let emissive = material.emissive_factor.map(share);
        let shines = emissive != [0.0; 3];
        if used && shines {
            let note = format!(
                "material {name} gives light of its own, which pictures and maps do not show"
            );
            self.out.notes.push(note);
        }
        let mut texture = |info: &Option<TextureInfo>, what| {
            let info = info.as_ref().filter(|_| used)?;
            self.texture(info, what)
        };
        let base_color_texture = texture(&pbr.base_color_texture, "base colour");
        let is_unread = used
            && material.alpha() != Alpha::Opaque
            && pbr.base_color_texture.is_some()
            && base_color_texture.is_none();
        Material {
            base_color: color,
            bare_color: color,
            metallic: share(pbr.metallic_factor),
            roughness: share(pbr.roughness_factor),
            base_color_texture,
            metallic_roughness_texture: texture(&pbr.metallic_roughness_texture, "roughness"),
            normal_texture: texture(&material.normal_texture, "normal"),
            occlusion_texture: texture(&material.occlusion_texture, "occlusion"),
            emissive,
            emissive_texture: match shines {
                true => texture(&material.emissive_texture, "emissive"),
                false => None,
            },
            extensions: material.plain_extensions(),
            alpha: material.alpha(),
            opacity: share(opacity),
            unread_opacity: is_unread.then(|| format!("the image of material {name}")),
            is_double_sided: material.double_sided,
        }
    }

    fn texture(&mut self, info: &TextureInfo, what: &str) -> Option<Texture> {
        let transform = info.extensions.transform.clone().unwrap_or_default();
        let set = transform.tex_coord.unwrap_or(info.tex_coord);
        if set > 1 {
            let note = format!(
                "a {what} texture is in TEXCOORD_{set} and is passed over: only the first two sets are read"
            );
            self.out.notes.push(note);
            return None;
        }
        if set == 1 && self.out.second_uvs.is_empty() {
            let note = format!(
                "the {what} texture is in TEXCOORD_1, which no mesh has or can be read, and is passed over"
            );
            self.out.notes.push(note);
            return None;
        }
        let known = self.looks.textures.len();
        let Some(texture) = self.looks.textures.get(info.index) else {
            let note = format!(
                "the {what} texture is passed over: it is number {}, and the file has {known}",
                info.index
            );
            self.out.notes.push(note);
            return None;
        };
        let sampler = texture.sampler.and_then(|s| self.looks.samplers.get(s));
        let wrap = sampler.map_or_else(Default::default, JsonSampler::wrap);
        let source = texture.source;
        let Some(source) = source.filter(|&s| s < self.places.len()) else {
            let note = format!(
                "the {what} texture is passed over: it has no PNG or JPEG image (WebP and KTX2 are not read: save it as one of \
                 those)"
            );
            self.out.notes.push(note);
            return None;
        };
        Some(Texture {
            image: self.image(source)?,
            is_in_second: set == 1,
            strength: info.scale.or(info.strength.map(share)).unwrap_or(1.0),
            transform: transform.rows(),
            wrap,
        })
    }

    /// What is wrong with it is told once.
    fn image(&mut self, source: usize) -> Option<usize> {
        if let Some(place) = self.places[source] {
            return place;
        }
        let place = match self.bytes(source) {
            Ok(bytes) => {
                self.out.images.push(bytes);
                Some(self.out.images.len() - 1)
            }
            Err(problem) => {
                let note = format!("image {source} is passed over: {problem}");
                self.out.notes.push(note);
                None
            }
        };
        self.places[source] = Some(place);
        place
    }

    fn bytes(&mut self, source: usize) -> Result<Vec<u8>, String> {
        let image = &self.looks.images[source];
        let bytes = match (image.buffer_view, &image.uri) {
            (Some(view), _) => {
                let view = self.buffers.view(view).map_err(|fault| fault.to_string())?;
                view.bytes.to_vec()
            }
            (None, Some(uri)) => {
                let (bytes, file) = self.buffers.outside(uri)?;
                self.out.image_files.extend(file);
                bytes
            }
            (None, None) => return Err("it has no data".into()),
        };
        encoded_image(bytes).map_err(|problem| problem + ": save it as one of those")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn samplers_say_how_images_go_on() {
        let wrap = |json: &str| serde_json::from_str::<JsonSampler>(json).map(|s| s.wrap());
        let is = |json, expected| assert_eq!(wrap(json).expect(json), expected);
        is("{}", [Wrap::Repeat, Wrap::Repeat]);
        is(
            r#"{"wrapS": 33071, "magFilter": 9729}"#,
            [Wrap::Clamp, Wrap::Repeat],
        );
        is(
            r#"{"wrapS": 10497, "wrapT": 33648}"#,
            [Wrap::Repeat, Wrap::Mirror],
        );
    }
}
