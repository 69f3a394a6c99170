//! What a mesh looks like by its own file: colours of vertices, materials and their textures, ready to be sampled by
//! [maps](crate::bake) and [pictures](crate::picture).

use std::collections::BTreeSet;

use glam::{DVec2, DVec3, Vec3};

use crate::image::Image;
use crate::picture::{Coat, Finish};
use crate::substrate::{Alpha, Material, Substrate, SurfacePoint, Texture, Texturing, passed_over};

/// The colours, materials and textures of a substrate.
pub struct Appearance<'a> {
    substrate: &'a Substrate,
    texturing: &'a Texturing,
    images: Vec<Option<Image>>,
    /// Instead of the materials' colours, in the layout of the mesh.
    instead: Option<Image>,
    /// Whether nothing of it is known but where it is open.
    is_shape: bool,
    /// What could not be read, in words for the user.
    notes: Vec<String>,
}

/// Where a place of the surface is in images, by the first set of coordinates and by the second.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct InImages(pub(crate) [Option<[f64; 2]>; 2]);

impl InImages {
    /// Of a place between the corners of a triangle, or beyond them.
    pub(crate) fn of(
        (substrate, texturing): (&Substrate, &Texturing),
        triangle: u32,
        weights: [f64; 3],
    ) -> Self {
        let at = |uvs: Option<[[f64; 2]; 3]>| uvs.map(|uvs| place(&uvs, weights));
        let second = (!texturing.second_uvs.is_empty())
            .then(|| texturing.second_uvs_of(substrate, triangle));
        Self([
            at(texturing.uvs_of(substrate, triangle)),
            at(second.flatten()),
        ])
    }

    fn by(&self, texture: &Texture) -> Option<[f64; 2]> {
        self.0[usize::from(texture.is_in_second)]
    }
}

/// A material's colour where no texture says it.
fn untextured(material: &Material) -> [f32; 3] {
    match material.base_color_texture {
        Some(_) => material.bare_color,
        None => material.base_color,
    }
}

impl std::fmt::Debug for Appearance<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Appearance").finish_non_exhaustive()
    }
}

impl<'a> Appearance<'a> {
    /// The looks of a substrate by what its file says, for pictures, which take colours and normals of it. Images
    /// that cannot be read are passed over, with a [note](Self::notes).
    pub fn new(substrate: &'a Substrate, texturing: &'a Texturing) -> Self {
        let shown = |m: &Material| [m.base_color_texture, m.normal_texture];
        let shown = texturing.materials.iter().flat_map(shown).flatten();
        let shown: BTreeSet<usize> = shown.map(|texture| texture.image).collect();
        Self::with(substrate, texturing, |image| shown.contains(&image))
    }

    /// The same for maps, which take all of it.
    pub(crate) fn whole(substrate: &'a Substrate, texturing: &'a Texturing) -> Self {
        Self::with(substrate, texturing, |_| true)
    }

    /// The looks of a substrate that has the colours of an encoded PNG or JPEG image in the layout of its UVs, and
    /// nothing else of what its file says.
    ///
    /// # Errors
    /// When the image cannot be read.
    pub fn of_image(
        substrate: &'a Substrate,
        texturing: &'a Texturing,
        bytes: &[u8],
    ) -> Result<Self, String> {
        let shape = Self {
            notes: Vec::new(),
            is_shape: false,
            ..Self::of_shape(substrate, texturing)
        };
        shape.with_image(bytes)
    }

    /// Of all that the file says of a substrate's looks only what is seen through it: the rest is for the scene to say.
    pub fn of_shape(substrate: &'a Substrate, texturing: &'a Texturing) -> Self {
        let open = texturing
            .materials
            .iter()
            .filter(|m| m.alpha != Alpha::Opaque);
        let images = open.filter_map(|material| material.base_color_texture);
        let images: BTreeSet<usize> = images.map(|texture| texture.image).collect();
        Self {
            is_shape: true,
            ..Self::with(substrate, texturing, |image| images.contains(&image))
        }
    }

    fn with(
        substrate: &'a Substrate,
        texturing: &'a Texturing,
        is_wanted: impl Fn(usize) -> bool,
    ) -> Self {
        let mut notes = texturing.notes.clone();
        let mut decode = |(i, bytes): (usize, &Vec<u8>)| {
            let image = is_wanted(i).then(|| Image::decode(bytes))?;
            image.map_err(|e| notes.push(passed_over(i, &e))).ok()
        };
        let images = texturing.images.iter().enumerate();
        let images = images.map(&mut decode).collect();
        Self {
            substrate,
            texturing,
            images,
            instead: None,
            is_shape: false,
            notes,
        }
    }

    /// The same, with the colours of an image in the layout of the mesh in place of its own.
    pub(crate) fn with_image(self, bytes: &[u8]) -> Result<Self, String> {
        Ok(Self {
            instead: Some(Image::decode(bytes)?),
            ..self
        })
    }

    /// What could not be used, in words for the user.
    pub fn notes(&self) -> impl Iterator<Item = &str> {
        self.notes.iter().map(String::as_str)
    }

    /// Whether more than one colour is said: by an image, at vertices, or by materials.
    pub fn has_colors(&self) -> bool {
        let is_read = |t: Texture| self.has_image(t.image);
        let numbers: BTreeSet<&u32> = self.texturing.material_of.iter().flatten().collect();
        let materials = &self.texturing.materials;
        let all = numbers.iter().filter_map(|&&n| materials.get(n as usize));
        let textures = all.clone().filter_map(|m| m.base_color_texture);
        let mut colors = all.map(untextured);
        let first = colors.next();
        let mut painted = self.texturing.colors.iter().flatten().flatten();
        let first_painted = painted.next();
        self.instead.is_some()
            || painted.any(|color| Some(color) != first_painted)
            || textures.clone().any(is_read)
            || colors.any(|color| Some(color) != first)
    }

    /// Texels along the longer side of the largest image that says the colours of some materials, 0 where none does.
    pub(crate) fn largest<'m>(&self, materials: impl Iterator<Item = &'m Material>) -> usize {
        let textures = materials.filter_map(|material| material.base_color_texture);
        let images = textures.filter_map(|texture| self.images.get(texture.image)?.as_ref());
        let all = self.instead.iter().chain(images);
        all.map(Image::longer_side).max().unwrap_or(0)
    }

    /// Whether an image of the file was read.
    pub(crate) fn has_image(&self, image: usize) -> bool {
        self.images.get(image).is_some_and(Option::is_some)
    }

    /// Whether an image is in place of the materials' colours.
    pub(crate) fn is_of_image(&self) -> bool {
        self.instead.is_some()
    }

    /// Whether triangles have colours at their corners.
    pub(crate) fn has_painted_vertices(&self) -> bool {
        self.instead.is_none() && !self.texturing.colors.is_empty()
    }

    /// Linear light of a place's texture and material, if it has any of them.
    pub(crate) fn textured(&self, triangle: u32, at: &InImages) -> Option<Vec3> {
        if let Some(image) = &self.instead {
            return at.0[0].map(|uv| image.color(uv));
        }
        let material = self.texturing.material_of(self.substrate, triangle)?;
        let texture = self.image(&material.base_color_texture, at);
        let color = match texture {
            Some((image, _, uv)) => Vec3::from_array(material.base_color) * image.color(uv),
            None => Vec3::from_array(untextured(material)),
        };
        Some(color)
    }

    /// How little is seen through a place of a material, before its alpha decides: 1 for nothing.
    pub(crate) fn opacity(&self, material: &Material, at: &InImages) -> f32 {
        let texture = self.image(&material.base_color_texture, at);
        material.opacity * texture.map_or(1.0, |(image, _, uv)| image.opacity(uv))
    }

    /// Linear light of a place between painted vertices.
    pub(crate) fn painted(&self, at: &SurfacePoint) -> Option<Vec3> {
        if !self.has_painted_vertices() {
            return None;
        }
        let [a, b, c] = self.texturing.colors_of(self.substrate, at.triangle)?;
        let [s, t, u] = at.weights().map(|w| w as f32);
        Some(Vec3::from(a) * s + Vec3::from(b) * t + Vec3::from(c) * u)
    }

    /// The normal of a normal texture there, in the tangent space of its coordinates.
    pub(crate) fn relief(&self, material: &Material, at: &InImages) -> Option<Vec3> {
        let (image, strength, uv) = self.image(&material.normal_texture, at)?;
        let n = image.values(uv) * 2.0 - 1.0;
        Vec3::new(n.x * strength, n.y * strength, n.z).try_normalize()
    }

    /// The image of a texture, its strength and the place in it.
    pub(crate) fn image(
        &self,
        texture: &Option<Texture>,
        at: &InImages,
    ) -> Option<(&Image, f32, [f64; 2])> {
        let texture = texture.as_ref()?;
        let uv = at.by(texture)?;
        let image = self.images.get(texture.image)?.as_ref()?;
        Some((image, texture.strength, texture.place(image, uv)))
    }

    /// A normal of a triangle tilted as a normal texture says.
    pub(crate) fn tilted(&self, triangle: u32, at: &InImages, normal: Vec3) -> Option<Vec3> {
        let material = self.texturing.material_of(self.substrate, triangle)?;
        let relief = self.relief(material, at)?;
        let texture = material.normal_texture?;
        let uvs = self.texturing.uvs_for(&texture, self.substrate, triangle)?;
        let [right, top] = axes(self.substrate.corners(triangle), &uvs)?;
        let along = |axis: Vec3| (axis - normal * normal.dot(axis)).try_normalize();
        (along(right)? * relief.x + along(top)? * relief.y + normal * relief.z).try_normalize()
    }
}

impl Finish for Appearance<'_> {
    fn at(&self, triangle: u32, weights: [f32; 3], normal: [f32; 3]) -> Option<Coat> {
        if self.is_shape {
            return None;
        }
        let at = SurfacePoint::from_weights(triangle, weights.map(f64::from));
        let in_images = InImages::of((self.substrate, self.texturing), triangle, at.weights());
        let (textured, painted) = (self.textured(triangle, &in_images), self.painted(&at));
        let albedo = textured.or(painted.map(|_| Vec3::ONE))? * painted.unwrap_or(Vec3::ONE);
        let smooth = Vec3::from(normal);
        let tilted = self.tilted(triangle, &in_images, smooth);
        Some(Coat {
            albedo: albedo.to_array(),
            normal: tilted.unwrap_or(smooth).to_array(),
        })
    }

    fn has_openings(&self) -> bool {
        let is_open = |material: &Material| material.alpha != Alpha::Opaque;
        self.texturing.materials.iter().any(is_open)
    }

    fn is_open(&self, triangle: u32, weights: [f32; 3], chance: f32) -> bool {
        let material = self.texturing.material_of(self.substrate, triangle);
        let may_be_open = |material: &&Material| material.alpha != Alpha::Opaque;
        material.filter(may_be_open).is_some_and(|material| {
            let at = SurfacePoint::from_weights(triangle, weights.map(f64::from));
            let at = InImages::of((self.substrate, self.texturing), triangle, at.weights());
            material.is_open(self.opacity(material, &at), chance)
        })
    }
}

/// The mean of corners by weight.
fn place(corners: &[[f64; 2]; 3], weights: [f64; 3]) -> [f64; 2] {
    [0, 1].map(|axis| (0..3).map(|k| weights[k] * corners[k][axis]).sum())
}

/// The ways on a triangle to the right and to the top of its image; none where it has no area there.
fn axes([a, b, c]: [DVec3; 3], uvs: &[[f64; 2]; 3]) -> Option<[Vec3; 2]> {
    let [p, q, r] = uvs.map(DVec2::from);
    let (ab, ac) = (q - p, r - p);
    let area = ab.perp_dot(ac);
    let right = ((b - a) * ac.y - (c - a) * ab.y) / area;
    let down = ((c - a) * ab.x - (b - a) * ac.x) / area;
    let axes = [right, -down].map(|axis| axis.as_vec3());
    axes.iter().all(|axis| axis.is_finite()).then_some(axes)
}
