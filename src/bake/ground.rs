//! The substrate's own material, under and beside the lichen.

use std::sync::OnceLock;

use glam::{DVec3, Vec3, Vec3A};

use super::shown::Shown;
use crate::appearance::{Appearance, InImages};
use crate::picture::{self, longest_axis};
use crate::substrate::{Material, Substrate, SurfacePoint, Texture, Texturing};

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
    /// The mesh file's material and colours of vertices, or grey stone where it has neither.
    #[default]
    Mesh,
    /// Colour as pictures have it.
    Ground(picture::Ground),
    /// An encoded PNG or JPEG image in the layout of the mesh.
    Image(Vec<u8>),
}

/// What is under the lichen, ready to be sampled.
pub(super) struct Ground<'a> {
    substrate: &'a Substrate,
    own: Appearance<'a>,
    texturing: &'a Texturing,
    /// What is drawn instead of its own material.
    drawn: Option<picture::Ground>,
    middle: DVec3,
    size: f64,
    /// Where the mesh is longest.
    along: Vec3A,
}

/// What stands for all that is shown, where there is no triangle.
pub(super) struct Beyond<'a> {
    shown: Shown<'a>,
    /// The first triangle that is shown.
    pub(super) first: u32,
    /// Whether one image lies under all that is shown, in the layout of the maps, and so also where there is no
    /// triangle.
    has_image: bool,
    /// The mean colour, once it is asked for.
    mean: OnceLock<Vec3>,
}

impl<'a> Beyond<'a> {
    pub(super) fn new(shown: Shown<'a>, ground: &Ground) -> Self {
        let is_files = shown.charts.is_none();
        let first = shown.triangles().next().unwrap_or(0);
        Self {
            first,
            has_image: is_files && (ground.own.is_of_image() || ground.is_on_one_image(&shown)),
            mean: OnceLock::new(),
            shown,
        }
    }
}

impl<'a> Ground<'a> {
    /// # Errors
    /// When the image of `base` cannot be read; those of materials become notes.
    pub(super) fn new(
        substrate: &'a Substrate,
        texturing: &'a Texturing,
        base: &Base,
    ) -> Result<Self, String> {
        let own = Appearance::whole(substrate, texturing);
        let (own, drawn) = match base {
            Base::Mesh => (own, None),
            Base::Ground(ground) => (own, Some(*ground)),
            Base::Image(bytes) => (own.with_image(bytes)?, None),
        };
        let [low, high] = substrate.bounds();
        Ok(Self {
            substrate,
            own,
            texturing,
            drawn,
            middle: 0.5 * (low + high),
            size: (high - low).length(),
            along: longest_axis([low, high].map(|c| c.as_vec3a())),
        })
    }

    /// Texels along the longer side of the largest image of the colours of what is shown; 0 where there is none or
    /// nothing is seen of it.
    pub(super) fn largest_image(&self, shown: &Shown) -> usize {
        match self.drawn {
            Some(_) => 0,
            None => self.own.largest(shown.materials().into_iter()),
        }
    }

    /// Whether an image of the file was read.
    pub(super) fn has_image(&self, image: usize) -> bool {
        self.own.has_image(image)
    }

    /// Whether it is the mesh's own material.
    pub(super) fn is_own(&self) -> bool {
        self.drawn.is_none() && !self.own.is_of_image()
    }

    /// What of the mesh's material could not be used, in words for the user.
    pub(super) fn notes(&self) -> impl Iterator<Item = &str> {
        self.own.notes()
    }

    /// Whether all that is shown has the same image in the layout of the maps, and the same factor to it.
    fn is_on_one_image(&self, shown: &Shown) -> bool {
        let materials = shown.materials();
        let is_first = |material: &&Material| {
            let of = |material: &Material| (material.base_color_texture, material.base_color);
            of(material) == of(materials[0])
        };
        let texture = materials.first().and_then(|first| first.base_color_texture);
        let is_there = |texture: Texture| !texture.is_in_second && self.has_image(texture.image);
        texture.is_some_and(is_there)
            && materials.iter().all(is_first)
            && shown.triangles().all(|t| shown.material_of(t).is_some())
    }

    /// Colour at a place of the image that a triangle owns, linear light; `place` is asked only where
    /// colour depends on it. Beyond all charts it is what the mesh's own image has there, if it has the layout of the
    /// maps, or else the mean: smaller levels of the texture mix it into their rims.
    pub(super) fn base_color(
        &self,
        (triangle, beyond): (Option<u32>, &Beyond),
        at: &InImages,
        place: impl Fn() -> Option<SurfacePoint>,
    ) -> Vec3 {
        match self.drawn {
            Some(ground @ picture::Ground::Color(_)) => return self.drawn_at(ground, self.middle),
            Some(ground) => {
                return self.at_or_mean(place(), beyond, |at| self.drawn_on(ground, at));
            }
            None => {}
        }
        if triangle.is_none() && !beyond.has_image {
            return self.at_or_mean(None, beyond, |at| self.own_color(at));
        }
        let textured = self.own.textured(triangle.unwrap_or(beyond.first), at);
        match (textured, self.own.has_painted_vertices()) {
            (Some(color), false) => color,
            (Some(color), true) => color * self.at_or_mean(place(), beyond, |at| self.painted(at)),
            (None, _) => self.at_or_mean(place(), beyond, |at| self.bare(at)),
        }
    }

    /// What the mesh's file says of a place, or that of stone.
    fn own_color(&self, at: &SurfacePoint) -> Vec3 {
        let mesh = (self.substrate, self.texturing);
        let in_images = InImages::of(mesh, at.triangle, at.weights());
        let textured = self.own.textured(at.triangle, &in_images);
        textured.map_or_else(|| self.bare(at), |color| color * self.painted(at))
    }

    /// How little is seen through a material at a place of the image.
    pub(super) fn opacity(&self, material: &Material, at: &InImages) -> f32 {
        self.own.opacity(material, at)
    }

    /// That of a place, or the mean of all.
    fn at_or_mean(
        &self,
        at: Option<SurfacePoint>,
        beyond: &Beyond,
        of: impl Fn(&SurfacePoint) -> Vec3,
    ) -> Vec3 {
        match at {
            Some(at) => of(&at),
            None => *beyond.mean.get_or_init(|| self.mean(&beyond.shown, of)),
        }
    }

    /// Of a place without a material.
    fn bare(&self, at: &SurfacePoint) -> Vec3 {
        let drawn = || self.drawn_on(picture::Ground::default(), at);
        self.own.painted(at).unwrap_or_else(drawn)
    }

    fn painted(&self, at: &SurfacePoint) -> Vec3 {
        self.own.painted(at).unwrap_or(Vec3::ONE)
    }

    /// What pictures draw there.
    fn drawn_on(&self, ground: picture::Ground, at: &SurfacePoint) -> Vec3 {
        self.drawn_at(ground, self.substrate.position(at))
    }

    fn drawn_at(&self, ground: picture::Ground, place: DVec3) -> Vec3 {
        let place = ((place - self.middle) / self.size).as_vec3a();
        Vec3::from(ground.albedo(place, self.along)).clamp(Vec3::ZERO, Vec3::ONE)
    }

    /// The mean over places spread evenly over what is shown.
    fn mean(&self, shown: &Shown, of: impl Fn(&SurfacePoint) -> Vec3) -> Vec3 {
        const PLACES: usize = 4096;
        let places = self.substrate.spread_over(|| shown.triangles(), PLACES);
        places.iter().map(of).sum::<Vec3>() / places.len().max(1) as f32
    }

    /// Whether a triangle's normal texture is laid out in other coordinates than maps are.
    pub(super) fn is_tilted_elsewhere(&self, triangle: u32) -> bool {
        let material = self.texturing.material_of(self.substrate, triangle);
        let texture = material.and_then(|material| material.normal_texture);
        texture.is_some_and(|texture| texture.is_in_second)
    }

    /// A normal of a triangle tilted as its normal texture says.
    pub(super) fn tilted(&self, triangle: u32, at: &InImages, normal: Vec3) -> Option<Vec3> {
        self.own.tilted(triangle, at, normal)
    }

    /// Everything else there; its normal in the tangent space of its texture.
    pub(super) fn surface(&self, triangle: u32, at: &InImages) -> Surface {
        let mut surface = Surface {
            metallic: 0.0,
            roughness: Material::ROUGH,
            normal: Vec3::Z,
            occlusion: 1.0,
        };
        let material = self.texturing.material_of(self.substrate, triangle);
        let Some(material) = material else {
            return surface;
        };
        (surface.metallic, surface.roughness) = (material.metallic, material.roughness);
        if let Some((image, _, uv)) = self.own.image(&material.metallic_roughness_texture, at) {
            let [_, roughness, metallic] = image.values(uv).to_array();
            surface.roughness *= roughness;
            surface.metallic *= metallic;
        }
        surface.normal = self.own.relief(material, at).unwrap_or(Vec3::Z);
        if let Some((image, strength, uv)) = self.own.image(&material.occlusion_texture, at) {
            surface.occlusion = 1.0 + strength * (image.values(uv).x - 1.0);
        }
        surface
    }
}
