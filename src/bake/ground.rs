//! The substrate's own material, under and beside the lichen.

use std::sync::OnceLock;

use glam::{DVec3, Vec3, Vec3A};

use super::image::Image;
use crate::picture::{self, longest_axis};
use crate::substrate::{Material, Substrate, Texture, Texturing};

/// How the bare substrate at a place throws light back, besides its colour.
#[derive(Clone, Copy, Debug)]
pub(super) struct Surface {
    pub(super) metallic: f32,
    pub(super) roughness: f32,
    /// Unit vector in tangent space.
    pub(super) normal: Vec3,
    pub(super) occlusion: f32,
}

/// What is under the lichen where no file says it.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum Base {
    /// The mesh file's material, or grey stone where it has none.
    #[default]
    Mesh,
    /// Colour as pictures have it.
    Ground(picture::Ground),
    /// An encoded PNG or JPEG image in the layout of the mesh.
    Image(Vec<u8>),
}

/// Roughness of stone that no material describes.
const ROUGH: f32 = 0.85;

/// The materials of a substrate, ready to be sampled.
pub(super) struct Ground<'a> {
    substrate: &'a Substrate,
    texturing: &'a Texturing,
    images: Vec<Option<Image>>,
    base: OwnBase,
    middle: DVec3,
    size: f64,
    /// Where the mesh is longest.
    along: Vec3A,
    /// The mean of what is drawn, once it is asked for.
    mean: OnceLock<Vec3>,
    /// Images that could not be read, in words for the user.
    pub(super) notes: Vec<String>,
}

enum OwnBase {
    Mesh,
    Drawn(picture::Ground),
    Image(Image),
}

impl<'a> Ground<'a> {
    /// # Errors
    /// When the image of `base` cannot be read; those of materials become notes.
    pub(super) fn new(
        substrate: &'a Substrate,
        texturing: &'a Texturing,
        base: &Base,
    ) -> Result<Self, String> {
        let mut notes = Vec::new();
        let mut decode = |(i, bytes): (usize, &Vec<u8>)| {
            let image = Image::decode(bytes);
            image
                .map_err(|e| notes.push(format!("image {i} of the mesh is passed over: {e}")))
                .ok()
        };
        let images = texturing.images.iter().enumerate();
        let images = images.map(&mut decode).collect();
        let base = match base {
            Base::Mesh => OwnBase::Mesh,
            Base::Ground(ground) => OwnBase::Drawn(*ground),
            Base::Image(bytes) => OwnBase::Image(Image::decode(bytes)?),
        };
        let [low, high] = substrate.bounds();
        Ok(Self {
            substrate,
            texturing,
            images,
            base,
            middle: 0.5 * (low + high),
            size: (high - low).length(),
            along: longest_axis([low, high].map(|c| c.as_vec3a())),
            mean: OnceLock::new(),
            notes,
        })
    }

    /// Colour at a place of the image that a triangle owns, linear light; `place` is asked only where
    /// colour depends on it.
    pub(super) fn base_color(
        &self,
        triangle: Option<u32>,
        uv: [f64; 2],
        place: impl FnOnce() -> Option<DVec3>,
    ) -> Vec3 {
        match (&self.base, self.material(triangle)) {
            (OwnBase::Image(image), _) => image.color(uv),
            (OwnBase::Mesh, Some(material)) => {
                let factor = Vec3::from_array(material.base_color);
                let texture = self.image(&material.base_color_texture, uv);
                texture.map_or(factor, |(image, _, uv)| factor * image.color(uv))
            }
            (OwnBase::Drawn(ground), _) => self.drawn(*ground, place),
            (OwnBase::Mesh, None) => self.drawn(picture::Ground::default(), place),
        }
    }

    /// What pictures draw at a place; beyond all charts, whose mean it is: smaller levels of the texture mix it
    /// into their rims.
    fn drawn(&self, ground: picture::Ground, place: impl FnOnce() -> Option<DVec3>) -> Vec3 {
        match ground {
            picture::Ground::Color(_) => self.drawn_at(ground, self.middle),
            _ => place().map_or_else(
                || *self.mean.get_or_init(|| self.mean_drawn(ground)),
                |p| self.drawn_at(ground, p),
            ),
        }
    }

    fn drawn_at(&self, ground: picture::Ground, place: DVec3) -> Vec3 {
        let place = ((place - self.middle) / self.size).as_vec3a();
        Vec3::from(ground.albedo(place, self.along)).clamp(Vec3::ZERO, Vec3::ONE)
    }

    /// The mean over places spread evenly over the surface.
    fn mean_drawn(&self, ground: picture::Ground) -> Vec3 {
        const PLACES: f64 = 4096.0;
        let all = 0..self.substrate.triangles().len() as u32;
        let apart = all.clone().map(|t| self.substrate.area(t)).sum::<f64>() / PLACES;
        let (mut sum, mut count, mut left) = (Vec3::ZERO, 0u32, 0.5 * apart);
        for t in all {
            left += self.substrate.area(t);
            let [a, b, c] = self.substrate.corners(t);
            while left >= apart {
                left -= apart;
                let [u, v] = evenly_spread(count);
                let place = a + (b - a) * (u * (1.0 - v)) + (c - a) * (u * v);
                sum += self.drawn_at(ground, place);
                count += 1;
            }
        }
        sum / count.max(1) as f32
    }

    /// Everything else there.
    pub(super) fn surface(&self, triangle: Option<u32>, uv: [f64; 2]) -> Surface {
        let mut surface = Surface {
            metallic: 0.0,
            roughness: ROUGH,
            normal: Vec3::Z,
            occlusion: 1.0,
        };
        let Some(material) = self.material(triangle) else {
            return surface;
        };
        (surface.metallic, surface.roughness) = (material.metallic, material.roughness);
        if let Some((image, _, uv)) = self.image(&material.metallic_roughness_texture, uv) {
            let [_, roughness, metallic] = image.values(uv).to_array();
            surface.roughness *= roughness;
            surface.metallic *= metallic;
        }
        if let Some((image, strength, uv)) = self.image(&material.normal_texture, uv) {
            let n = image.values(uv) * 2.0 - 1.0;
            surface.normal = Vec3::new(n.x * strength, n.y * strength, n.z).normalize_or(Vec3::Z);
        }
        if let Some((image, strength, uv)) = self.image(&material.occlusion_texture, uv) {
            surface.occlusion = 1.0 + strength * (image.values(uv).x - 1.0);
        }
        surface
    }

    /// The material of a triangle; where there is none, that of the first.
    fn material(&self, triangle: Option<u32>) -> Option<&Material> {
        let source = self.substrate.source_triangle(triangle.unwrap_or(0)) as usize;
        let material = self.texturing.material_of.get(source).copied().flatten()?;
        self.texturing.materials.get(material as usize)
    }

    fn image(&self, texture: &Option<Texture>, uv: [f64; 2]) -> Option<(&Image, f32, [f64; 2])> {
        let texture = texture.as_ref()?;
        let image = self.images.get(texture.image)?.as_ref()?;
        let place = texture.transform.map(|[a, b, c]| a * uv[0] + b * uv[1] + c);
        Some((image, texture.strength, place))
    }
}

/// The n-th place of a triangle in a sequence that fills it evenly: the share of the way from a corner and the share of
/// the way across there (R2, M. Roberts, *The Unreasonable Effectiveness of Quasirandom Sequences*, 2018).
fn evenly_spread(n: u32) -> [f64; 2] {
    const PLASTIC: f64 = 1.324_717_957_244_746;
    let n = f64::from(n) + 0.5;
    let [s, t] = [n / PLASTIC, n / (PLASTIC * PLASTIC)].map(f64::fract);
    [s.sqrt(), t]
}
