//! What surfaces wear in binary glTF: images, textures of them, and materials.

use std::collections::BTreeSet;
use std::io;

use serde_json::{Value, json};

use super::textured::{SurfaceLook, TexturedMaterial};
use crate::substrate::{Alpha, Material, Texture, Wrap};

const TRANSFORM: &str = "KHR_texture_transform";

const LINEAR: u32 = 9729;
const LINEAR_MIPMAP_LINEAR: u32 = 9987;

/// The images of a file in the order in which it has them, and what is made of them.
#[derive(Default)]
pub(super) struct Worn<'a> {
    /// What the scene is called.
    scene: &'a str,
    images: Vec<(String, &'a [u8])>,
    /// Of the scene's own images, their places among all.
    places: Vec<Option<usize>>,
    /// Each an image and how it goes on beyond its borders.
    textures: Vec<(usize, [Wrap; 2])>,
    samplers: Vec<[Wrap; 2]>,
    extensions: BTreeSet<String>,
}

impl<'a> Worn<'a> {
    /// The materials of a scene of this name with such images of its own, and what they need.
    ///
    /// # Errors
    /// When a material names an image that is not there.
    pub(super) fn of(
        scene: &'a str,
        materials: &'a [TexturedMaterial],
        own: &'a [Vec<u8>],
    ) -> io::Result<(Self, Vec<Value>)> {
        let mut worn = Self {
            scene,
            places: vec![None; own.len()],
            ..Self::default()
        };
        let said = materials
            .iter()
            .map(|material| worn.material(material, own));
        let said = said.collect::<io::Result<Vec<Value>>>()?;
        Ok((worn, said))
    }

    /// PNG and JPEG files, and what they are called.
    pub(super) fn images(&self) -> impl Iterator<Item = (&str, &'a [u8])> {
        self.images.iter().map(|(name, file)| (&name[..], *file))
    }

    /// Says in a document what textures there are.
    pub(super) fn say(&self, document: &mut Value) {
        let place = |wrap: &[Wrap; 2]| self.samplers.iter().position(|other| other == wrap);
        let texture =
            |(image, wrap): &(usize, [Wrap; 2])| json!({"source": image, "sampler": place(wrap)});
        let sampler = |[across, down]: &[Wrap; 2]| {
            json!({
                "magFilter": LINEAR, "minFilter": LINEAR_MIPMAP_LINEAR,
                "wrapS": wrapping(*across), "wrapT": wrapping(*down),
            })
        };
        if !self.extensions.is_empty() {
            document["extensionsUsed"] = json!(self.extensions);
        }
        if self.textures.is_empty() {
            return;
        }
        document["textures"] = self.textures.iter().map(texture).collect();
        document["samplers"] = self.samplers.iter().map(sampler).collect();
    }

    fn material(
        &mut self,
        material: &'a TexturedMaterial,
        own: &'a [Vec<u8>],
    ) -> io::Result<Value> {
        let mut said = match &material.look {
            SurfaceLook::Maps(images) => {
                let [base_color, normal, orm] = images.named().map(|(name, png)| {
                    self.images.push((name.replace(char::is_control, " "), png));
                    let texture = self.texture_of(self.images.len() - 1, [Wrap::Repeat; 2]);
                    json!({"index": texture})
                });
                json!({
                    "pbrMetallicRoughness": {
                        "baseColorTexture": base_color,
                        "metallicRoughnessTexture": orm.clone(),
                    },
                    "normalTexture": normal,
                    "occlusionTexture": orm,
                })
            }
            SurfaceLook::Own(look) => self.own(look, own)?,
        };
        said["name"] = material.name.replace(char::is_control, " ").into();
        match material.alpha {
            Alpha::Opaque => {}
            Alpha::Blend => said["alphaMode"] = "BLEND".into(),
            Alpha::Mask { cutoff } => {
                said["alphaMode"] = "MASK".into();
                said["alphaCutoff"] = cutoff.into();
            }
        }
        if material.is_double_sided {
            said["doubleSided"] = true.into();
        }
        Ok(said)
    }

    /// A material as its file has it.
    fn own(&mut self, look: &Material, own: &'a [Vec<u8>]) -> io::Result<Value> {
        let [red, green, blue] = look.base_color;
        let mut metallic_roughness = json!({
            "baseColorFactor": [red, green, blue, look.opacity],
            "metallicFactor": look.metallic,
            "roughnessFactor": look.roughness,
        });
        let mut said = json!({});
        if let Some(texture) = &look.base_color_texture {
            metallic_roughness["baseColorTexture"] = self.texture(texture, own)?;
        }
        if let Some(texture) = &look.metallic_roughness_texture {
            metallic_roughness["metallicRoughnessTexture"] = self.texture(texture, own)?;
        }
        if let Some(texture) = &look.normal_texture {
            said["normalTexture"] = self.texture(texture, own)?;
            said["normalTexture"]["scale"] = texture.strength.into();
        }
        if let Some(texture) = &look.occlusion_texture {
            said["occlusionTexture"] = self.texture(texture, own)?;
            said["occlusionTexture"]["strength"] = texture.strength.into();
        }
        if look.emissive != [0.0; 3] {
            said["emissiveFactor"] = json!(look.emissive);
        }
        if let Some(texture) = &look.emissive_texture {
            said["emissiveTexture"] = self.texture(texture, own)?;
        }
        for (name, extension) in &look.extensions {
            said["extensions"][name] = serde_json::from_str(extension)?;
            self.extensions.insert(name.clone());
        }
        said["pbrMetallicRoughness"] = metallic_roughness;
        Ok(said)
    }

    fn texture(&mut self, texture: &Texture, own: &'a [Vec<u8>]) -> io::Result<Value> {
        let Some(file) = own.get(texture.image) else {
            let problem = format!("there is no image {}", texture.image);
            return Err(io::Error::new(io::ErrorKind::InvalidData, problem));
        };
        let image = *self.places[texture.image].get_or_insert_with(|| {
            let name = format!("{}_own_{}", self.scene, texture.image);
            self.images
                .push((name.replace(char::is_control, " "), file));
            self.images.len() - 1
        });
        let mut said = json!({"index": self.texture_of(image, texture.wrap)});
        if texture.is_in_second {
            said["texCoord"] = 1.into();
        }
        if let Some(transform) = transform(&texture.transform) {
            self.extensions.insert(TRANSFORM.to_owned());
            said["extensions"] = json!({TRANSFORM: transform});
        }
        Ok(said)
    }

    fn texture_of(&mut self, image: usize, wrap: [Wrap; 2]) -> usize {
        if !self.samplers.contains(&wrap) {
            self.samplers.push(wrap);
        }
        let known = self
            .textures
            .iter()
            .position(|texture| *texture == (image, wrap));
        known.unwrap_or_else(|| {
            self.textures.push((image, wrap));
            self.textures.len() - 1
        })
    }
}

/// glTF's number for it.
fn wrapping(wrap: Wrap) -> u32 {
    match wrap {
        Wrap::Repeat => 10497,
        Wrap::Mirror => 33648,
        Wrap::Clamp => 33071,
    }
}

/// As `KHR_texture_transform` has it; none where nothing is moved.
fn transform([[a, b, u], [c, d, v]]: &[[f64; 3]; 2]) -> Option<Value> {
    let is_none = [a, d].iter().all(|x| **x == 1.0) && [b, u, c, v].iter().all(|x| **x == 0.0);
    let rotation = libm::atan2(-c, *a);
    let (sin, cos) = libm::sincos(rotation);
    (!is_none).then(|| {
        json!({
            "offset": [u, v],
            "rotation": rotation,
            "scale": [libm::hypot(*a, *c), b * sin + d * cos],
        })
    })
}
