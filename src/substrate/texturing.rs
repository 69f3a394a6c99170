//! What a mesh file says about the texture of its triangles.

use std::collections::{BTreeMap, BTreeSet};
use std::path::PathBuf;

use glam::{DVec2, DVec3, Vec3};
use rayon::prelude::*;

use super::division::Tile;
use super::{Part, Substrate};
use crate::image::{Image, Wrap};

/// Texture coordinates, normals, colours and materials, by the number that a triangle has in the file
/// ([`Substrate::source_triangle`](super::Substrate::source_triangle)).
///
/// Coordinates are glTF's: (0, 0) is the upper left corner of the image, (1, 1) the lower right one.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Texturing {
    /// For each triangle those of its corners; none where a corner has none, or none that is finite. This and the next
    /// four end with the last triangle that has any.
    pub uvs: Vec<Option<[[f64; 2]; 3]>>,
    /// As `uvs`, of the second set of a glTF file (`TEXCOORD_1`), which a [`Texture`] may be laid out in.
    pub second_uvs: Vec<Option<[[f64; 2]; 3]>>,
    /// For each triangle the unit normals of its corners, in the order of `uvs`; none where a corner has none that is a
    /// direction. Of glTF and OBJ, but not of skinned meshes.
    pub normals: Vec<Option<[Vec3; 3]>>,
    /// For each triangle the colours of its corners, linear light, in the order of `uvs`; none where a corner has none.
    pub colors: Vec<Option<[[f32; 3]; 3]>>,
    /// As `colors`, of the second set of a glTF file (`COLOR_1`), which pictures do not show.
    pub second_colors: Vec<Option<[[f32; 3]; 3]>>,
    /// What the file calls its parts.
    pub parts: Vec<Part>,
    /// For each triangle its place in `parts`, if it has one.
    pub part_of: Vec<Option<u32>>,
    /// For each triangle its place in `materials`, if it has one.
    pub material_of: Vec<Option<u32>>,
    /// As glTF has them, or as near as OBJ's libraries come to that.
    pub materials: Vec<Material>,
    /// Encoded image files, by the place that a [`Texture`] names.
    pub images: Vec<Vec<u8>>,
    /// Files that images were read from, where they are not part of the mesh's.
    pub image_files: Vec<PathBuf>,
    /// Whether the file has skeletons or animations, of which triangles have one pose.
    pub is_posed: bool,
    /// What had to be passed over, in words for the user.
    pub notes: Vec<String>,
}

/// What a surface is made of (Khronos, *glTF 2.0 Specification*, 3.9.2).
#[derive(Clone, Debug, PartialEq)]
pub struct Material {
    /// Linear red, green and blue: a factor where there is a texture.
    pub base_color: [f32; 3],
    /// The same where `base_color_texture` cannot be read.
    pub bare_color: [f32; 3],
    /// 0 for stone, 1 for metal; a factor where there is a texture.
    pub metallic: f32,
    /// 0 for a mirror, 1 for chalk; a factor where there is a texture.
    pub roughness: f32,
    /// sRGB.
    pub base_color_texture: Option<Texture>,
    /// Roughness in green, metal in blue.
    pub metallic_roughness_texture: Option<Texture>,
    /// Tangent space, +Y.
    pub normal_texture: Option<Texture>,
    /// Red.
    pub occlusion_texture: Option<Texture>,
    /// Light that it gives, linear red, green and blue, 0 to 1: a factor where there is a texture. Pictures and maps do
    /// not show it.
    pub emissive: [f32; 3],
    /// sRGB.
    pub emissive_texture: Option<Texture>,
    /// Extensions of a glTF file that name no textures, as JSON, by their names: pictures and maps do not show them.
    pub extensions: BTreeMap<String, String>,
    /// What is seen through it.
    pub alpha: Alpha,
    /// 0 for glass, 1 for stone, where `alpha` asks for it; a factor where the base colour's texture says it too.
    pub opacity: f32,
    /// What was to say its opacity besides and cannot be read, in words for the user.
    pub unread_opacity: Option<String>,
    /// Whether it shows from behind.
    pub is_double_sided: bool,
}

/// What is seen through a surface (Khronos, *glTF 2.0 Specification*, 3.9.4).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Alpha {
    /// Nothing.
    #[default]
    Opaque,
    /// All, where the opacity is less than this.
    Mask {
        /// From 0 to 1.
        cutoff: f32,
    },
    /// As much as the opacity leaves.
    Blend,
}

/// An image on a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Texture {
    /// Its place in [`Texturing::images`].
    pub image: usize,
    /// Whether it is laid out in the second set of coordinates.
    pub is_in_second: bool,
    /// How strongly a normal or occlusion texture counts: 1 as it is.
    pub strength: f32,
    /// From (u, v, 1) to the image's coordinates: the two rows of `KHR_texture_transform`.
    pub transform: [[f64; 3]; 2],
    /// Beyond its sides, and beyond its top and bottom.
    pub wrap: [Wrap; 2],
}

impl Material {
    /// Roughness of stone, where nothing says it.
    pub(crate) const ROUGH: f32 = 0.85;

    /// Whether all is seen through it where the opacity is this; of what is blended, where it is less than `least`.
    pub(crate) fn is_open(&self, opacity: f32, least: f32) -> bool {
        match self.alpha {
            Alpha::Opaque => false,
            Alpha::Mask { cutoff } => opacity < cutoff,
            Alpha::Blend => opacity < least,
        }
    }
}

impl Texture {
    /// Where coordinates are in the image, as its texels are asked for.
    pub(crate) fn place(&self, image: &Image, [u, v]: [f64; 2]) -> [f64; 2] {
        let place = self.transform.map(|[a, b, c]| a * u + b * v + c);
        image.wrapped(place, self.wrap)
    }
}

/// White stone without textures.
impl Default for Material {
    fn default() -> Self {
        Self {
            base_color: [1.0; 3],
            bare_color: [1.0; 3],
            metallic: 0.0,
            roughness: Self::ROUGH,
            base_color_texture: None,
            metallic_roughness_texture: None,
            normal_texture: None,
            occlusion_texture: None,
            emissive: [0.0; 3],
            emissive_texture: None,
            extensions: BTreeMap::new(),
            alpha: Alpha::Opaque,
            opacity: 1.0,
            unread_opacity: None,
            is_double_sided: false,
        }
    }
}

/// What is said of an image that is not used.
pub(crate) fn passed_over(image: usize, problem: &str) -> String {
    format!("image {image} of the mesh is passed over: {problem}")
}

impl Texturing {
    /// Of coordinates by vertex, as engines keep them, for the triangles of a [`Soup`](super::Soup); v counts from
    /// above, as everywhere here (1 − v where an engine counts from below). Triangles with a vertex that has none, or
    /// none that is finite, have none.
    pub fn from_vertices(triangles: &[[u32; 3]], uvs: &[[f32; 2]]) -> Self {
        let mut texturing = Self::default();
        for corners in triangles {
            let corner = |vertex: u32| Corner {
                uvs: [uvs.get(vertex as usize).map(|uv| uv.map(f64::from)), None],
                ..Corner::default()
            };
            texturing.push(corners.map(corner), Of::default());
        }
        texturing
    }

    /// Of images that cannot be decoded, in words for the user. All are, on all threads, and none is kept.
    pub fn damaged_images(&self) -> Vec<String> {
        let images = self.images.par_iter().enumerate();
        let damaged = |(i, bytes): (usize, &Vec<u8>)| {
            let problem = Image::decode_opacity(bytes).err()?;
            Some(passed_over(i, &problem))
        };
        images.filter_map(damaged).collect()
    }

    /// Coordinates of the corners of a substrate's triangle, as far as the file has any.
    pub fn uvs_of(&self, substrate: &Substrate, triangle: u32) -> Option<[[f64; 2]; 3]> {
        uvs_at(&self.uvs, substrate, triangle)
    }

    /// The numbers of the UDIM tiles in which triangles of a substrate are laid out: 1001 is the square of u and v from
    /// 0 to 1. Some tiles have none.
    pub fn tiles(&self, substrate: &Substrate) -> BTreeSet<u32> {
        let all = 0..substrate.triangles().len() as u32;
        let uvs = all.filter_map(|t| self.uvs_of(substrate, t));
        uvs.filter_map(|uvs| Tile::of(&uvs).number()).collect()
    }

    /// As [`uvs_of`](Self::uvs_of), of the second set.
    pub fn second_uvs_of(&self, substrate: &Substrate, triangle: u32) -> Option<[[f64; 2]; 3]> {
        uvs_at(&self.second_uvs, substrate, triangle)
    }

    /// Those of the two in which a texture is laid out.
    pub(crate) fn uvs_for(
        &self,
        texture: &Texture,
        substrate: &Substrate,
        triangle: u32,
    ) -> Option<[[f64; 2]; 3]> {
        match texture.is_in_second {
            false => self.uvs_of(substrate, triangle),
            true => self.second_uvs_of(substrate, triangle),
        }
    }

    /// Makes the second set of coordinates the first, in which maps are laid out; textures stay where they are.
    pub fn swap_uv_sets(&mut self) {
        std::mem::swap(&mut self.uvs, &mut self.second_uvs);
        for material in &mut self.materials {
            let textures = [
                &mut material.base_color_texture,
                &mut material.metallic_roughness_texture,
                &mut material.normal_texture,
                &mut material.occlusion_texture,
            ];
            let textures = textures.into_iter().flatten();
            textures.for_each(|texture| texture.is_in_second ^= true);
        }
    }

    /// Unit normals of the corners of a substrate's triangle, on the side of its winding, as far as the file has any.
    pub fn normals_of(&self, substrate: &Substrate, triangle: u32) -> Option<[DVec3; 3]> {
        let source = substrate.source_triangle(triangle) as usize;
        let normals = self.normals.get(source).copied().flatten()?;
        let corners = at_corners(normals.map(Vec3::as_dvec3), substrate, triangle);
        let [a, b, c] = corners.map(DVec3::try_normalize);
        let (normals, own) = ([a?, b?, c?], substrate.normal(triangle));
        let along = own.dot(normals.iter().sum());
        Some(normals.map(|normal| normal * 1f64.copysign(along)))
    }

    /// Colours of the corners of a substrate's triangle, linear light, as far as the file has any.
    pub fn colors_of(&self, substrate: &Substrate, triangle: u32) -> Option<[[f32; 3]; 3]> {
        colors_at(&self.colors, substrate, triangle)
    }

    /// As [`colors_of`](Self::colors_of), of the second set.
    pub fn second_colors_of(&self, substrate: &Substrate, triangle: u32) -> Option<[[f32; 3]; 3]> {
        colors_at(&self.second_colors, substrate, triangle)
    }

    /// Whether of two sets of colours the first is white, as far as there is any, and the second is not: so Blender
    /// exports a colour attribute to glTF that no material shows.
    pub fn is_second_painted(&self) -> bool {
        let is_white = |column: &[Option<[[f32; 3]; 3]>]| {
            let mut numbers = column.iter().flatten().flatten().flatten();
            numbers.all(|&x| x > 0.999)
        };
        is_white(&self.colors) && !is_white(&self.second_colors)
    }

    /// Whether it has colours that are shades of grey, all of them, and not all white: as of masks, not of rocks.
    pub fn is_grey(&self) -> bool {
        let colors = || self.colors.iter().flatten().flatten();
        let is_grey = |&[r, g, b]: &[f32; 3]| (r - g).abs().max((g - b).abs()) < 0.01;
        colors().all(is_grey) && colors().flatten().any(|&x| x < 0.999)
    }

    /// The material of a substrate's triangle, if it has one.
    pub fn material_of(&self, substrate: &Substrate, triangle: u32) -> Option<&Material> {
        Some(&self.materials[self.material_at(substrate, triangle)?])
    }

    /// The place in `materials` of the material of a substrate's triangle, if it has one that is there.
    pub(crate) fn material_at(&self, substrate: &Substrate, triangle: u32) -> Option<usize> {
        let source = substrate.source_triangle(triangle) as usize;
        let material = self.material_of.get(source).copied().flatten()? as usize;
        (material < self.materials.len()).then_some(material)
    }

    /// Adds a part, for triangles that come; the last one again where that is the same.
    pub(super) fn add_part(&mut self, part: Part) -> u32 {
        if self.parts.last() != Some(&part) {
            self.parts.push(part);
        }
        self.parts.len() as u32 - 1
    }

    /// Adds the next triangle.
    pub(super) fn push(&mut self, corners: [Corner; 3], of: Of) {
        let is_finite = |uv: &[f64; 2]| uv.iter().all(|x| x.is_finite());
        let uv = |corner: &Corner, set: usize| corner.uvs[set].filter(is_finite);
        let normal = |corner: &Corner| {
            let normal = corner.normal.map(DVec3::from_array)?;
            normal.try_normalize().map(|normal| normal.as_vec3())
        };
        let at = self.material_of.len();
        let [uvs, second_uvs] = [0, 1].map(|set| all(corners.each_ref().map(|c| uv(c, set))));
        put(&mut self.uvs, at, uvs);
        put(&mut self.second_uvs, at, second_uvs);
        put(&mut self.normals, at, all(corners.each_ref().map(normal)));
        let [colors, second] = [0, 1].map(|set| all(corners.map(|corner| corner.colors[set])));
        put(&mut self.colors, at, colors);
        put(&mut self.second_colors, at, second);
        self.material_of.push(of.material);
        self.part_of.push(of.part);
    }
}

/// What a file says of a triangle's corner.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Corner {
    /// Of two sets.
    pub(super) uvs: [Option<[f64; 2]>; 2],
    pub(super) normal: Option<[f64; 3]>,
    /// Linear light, of two sets.
    pub(super) colors: [Option<[f32; 3]>; 2],
}

/// What a file says of a triangle: its places in `materials` and `parts`.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Of {
    pub(super) material: Option<u32>,
    pub(super) part: Option<u32>,
}

/// Puts what there is at its place in a column.
fn put<T: Clone>(column: &mut Vec<Option<T>>, at: usize, value: Option<T>) {
    if value.is_some() {
        column.resize(at, None);
        column.push(value);
    }
}

fn all<T>([a, b, c]: [Option<T>; 3]) -> Option<[T; 3]> {
    Some([a?, b?, c?])
}

/// Of a column of coordinates, those at the corners of a substrate's triangle.
fn uvs_at(
    column: &[Option<[[f64; 2]; 3]>],
    substrate: &Substrate,
    triangle: u32,
) -> Option<[[f64; 2]; 3]> {
    let source = substrate.source_triangle(triangle) as usize;
    let uvs = column.get(source).copied().flatten()?;
    let uvs = at_corners(uvs.map(DVec2::from_array), substrate, triangle);
    Some(uvs.map(|uv| uv.to_array()))
}

/// Of a column of colours, those at the corners of a substrate's triangle.
fn colors_at(
    column: &[Option<[[f32; 3]; 3]>],
    substrate: &Substrate,
    triangle: u32,
) -> Option<[[f32; 3]; 3]> {
    let source = substrate.source_triangle(triangle) as usize;
    let colors = column.get(source).copied().flatten()?;
    let colors = colors.map(|color| Vec3::from_array(color).as_dvec3());
    let at_corners = at_corners(colors, substrate, triangle);
    Some(at_corners.map(|color| color.as_vec3().to_array()))
}

/// What the file's triangle has at its corners, at those of a substrate's triangle, which may be a part of it.
fn at_corners<T>(corners: [T; 3], substrate: &Substrate, triangle: u32) -> [T; 3]
where
    T: Copy + std::ops::Mul<f64, Output = T> + std::ops::Add<Output = T>,
{
    let at = |[a, b, c]: [f64; 3]| corners[0] * a + corners[1] * b + corners[2] * c;
    match substrate.is_part(triangle) {
        false => corners,
        true => substrate.source_weights(triangle).map(at),
    }
}

#[cfg(test)]
mod tests {
    use super::Texturing;

    #[test]
    fn coordinates_by_vertex_are_those_of_the_corners() {
        let uvs = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [f32::NAN, 1.0]];
        let triangles = [[0, 1, 3], [0, 1, 2], [0, 2, 4]];
        let texturing = Texturing::from_vertices(&triangles, &uvs);
        let corners = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]];
        assert_eq!(texturing.uvs, [None, Some(corners)]);
        assert_eq!(texturing.material_of, [None; 3]);
    }
}
