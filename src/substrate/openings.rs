//! What materials leave open, as leaves do that are cut out of an image.

use std::collections::BTreeSet;

use super::mask::mean;
use super::{Alpha, Material, Substrate, SurfacePoint, Texture, Texturing};
use crate::image::Image;

/// Of the materials that are blended, what is more transparent than this is open.
const HALF: f32 = 0.5;

/// The places of a substrate that its materials leave open.
pub(super) struct Openings {
    /// Of the file; those that are read, without their colours.
    images: Vec<Option<Image>>,
    /// Of the file.
    materials: Vec<Material>,
    /// By the substrate's triangles, if anything is open; none where nothing is.
    triangles: Vec<Option<Sheet>>,
}

/// What is in front of a triangle.
#[derive(Clone, Copy)]
struct Sheet {
    /// A place among the materials.
    material: usize,
    /// Of the corners, in its image, if it has one and they have any.
    uvs: Option<[[f32; 2]; 3]>,
}

impl Openings {
    /// # Errors
    /// When an image that says what is open cannot be read, or was not: which, and why.
    pub(super) fn new(substrate: &Substrate, texturing: &Texturing) -> Result<Self, String> {
        if let Some(unread) = unread(texturing) {
            return Err(format!(
                "{unread} says what is open, and is not read: have the opacity in the alpha of the base colour's image, a PNG \
                 where the mesh's file looks for it"
            ));
        }
        let images = images(texturing)?;
        let materials = texturing.materials.clone();
        let is_open: Vec<bool> = materials.iter().map(|m| may_be_open(m, &images)).collect();
        if !is_open.contains(&true) {
            return Ok(Self {
                images,
                materials,
                triangles: Vec::new(),
            });
        }
        let sheet = |t: u32| {
            let material = texturing.material_at(substrate, t)?;
            is_open[material].then(|| Sheet {
                material,
                uvs: uvs(texturing, &materials[material], substrate, t),
            })
        };
        let all = 0..substrate.triangles().len() as u32;
        Ok(Self {
            triangles: all.map(sheet).collect(),
            images,
            materials,
        })
    }

    /// Whether nothing is open.
    pub(super) fn are_none(&self) -> bool {
        self.triangles.iter().all(Option::is_none)
    }

    /// Whether a place is open.
    pub(super) fn has(&self, at: &SurfacePoint) -> bool {
        let sheet = self.triangles.get(at.triangle as usize).copied().flatten();
        sheet.is_some_and(|sheet| {
            let material = &self.materials[sheet.material];
            let in_image = |(texture, uvs): (Texture, [[f32; 2]; 3])| {
                let image = self.images.get(texture.image)?.as_ref()?;
                let uv = [0, 1].map(|axis| f64::from(mean(uvs.map(|uv| uv[axis]), at)));
                Some(image.opacity(texture.place(image, uv)))
            };
            let texture = material.base_color_texture.zip(sheet.uvs);
            let seen = texture.and_then(in_image).unwrap_or(1.0);
            material.is_open(material.opacity * seen, HALF)
        })
    }

    /// A BLAKE3 hash of all that says what is open.
    pub(super) fn hash(&self, texturing: &Texturing) -> String {
        let mut hasher = blake3::Hasher::new();
        for (material, is_open) in self.materials.iter().zip(self.used()) {
            if is_open {
                add(&mut hasher, material, texturing);
            }
        }
        for (t, sheet) in self.triangles.iter().enumerate() {
            let Some(sheet) = sheet else { continue };
            hasher.update(&(t as u64).to_le_bytes());
            hasher.update(&(sheet.material as u64).to_le_bytes());
            for x in sheet.uvs.unwrap_or([[f32::NAN; 2]; 3]).as_flattened() {
                hasher.update(&x.to_le_bytes());
            }
        }
        hasher.finalize().to_hex().to_string()
    }

    /// Of each material whether a triangle has it that may be open.
    fn used(&self) -> Vec<bool> {
        let mut used = vec![false; self.materials.len()];
        let sheets = self.triangles.iter().flatten();
        sheets.for_each(|sheet| used[sheet.material] = true);
        used
    }
}

/// What says what is open and was not read, of the materials that triangles have.
fn unread(texturing: &Texturing) -> Option<&str> {
    let used: BTreeSet<u32> = texturing.material_of.iter().flatten().copied().collect();
    let mut materials = used
        .iter()
        .filter_map(|&number| texturing.materials.get(number as usize));
    materials.find_map(|material| material.unread_opacity.as_deref())
}

/// What a material says of what is open.
fn add(hasher: &mut blake3::Hasher, material: &Material, texturing: &Texturing) {
    let cutoff = match material.alpha {
        Alpha::Opaque => f32::INFINITY,
        Alpha::Mask { cutoff } => cutoff,
        Alpha::Blend => -1.0,
    };
    hasher.update(&material.opacity.to_le_bytes());
    hasher.update(&cutoff.to_le_bytes());
    let Some(texture) = material.base_color_texture else {
        return;
    };
    let image = texturing.images.get(texture.image);
    hasher.update(blake3::hash(image.map_or(&[], Vec::as_slice)).as_bytes());
    hasher.update(&texture.wrap.map(|wrap| wrap as u8));
    for x in texture.transform.as_flattened() {
        hasher.update(&x.to_le_bytes());
    }
}

/// The images that say what is open.
fn images(texturing: &Texturing) -> Result<Vec<Option<Image>>, String> {
    let open = texturing.materials.iter();
    let open = open.filter(|material| material.alpha != Alpha::Opaque);
    let textures = open.filter_map(|material| material.base_color_texture);
    let mut images = vec![None; texturing.images.len()];
    for Texture { image, .. } in textures {
        let at = images.get_mut(image).filter(|at| at.is_none());
        if let (Some(at), Some(bytes)) = (at, texturing.images.get(image)) {
            let read = Image::decode_opacity(bytes);
            *at = Some(read.map_err(|e| format!("image {image} of the mesh: {e}"))?);
        }
    }
    Ok(images)
}

/// Whether a place of a material may be open.
fn may_be_open(material: &Material, images: &[Option<Image>]) -> bool {
    let image = |texture: Texture| images.get(texture.image)?.as_ref();
    let image = material.base_color_texture.and_then(image);
    let least = image.map_or(1.0, Image::least_opacity);
    material.is_open(material.opacity * least, HALF)
}

/// Coordinates in the image that says what is open.
fn uvs(
    texturing: &Texturing,
    material: &Material,
    substrate: &Substrate,
    triangle: u32,
) -> Option<[[f32; 2]; 3]> {
    let texture = material.base_color_texture?;
    let uvs = texturing.uvs_for(&texture, substrate, triangle)?;
    Some(uvs.map(|uv| uv.map(|x| x as f32)))
}
