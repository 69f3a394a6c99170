//! What a mesh file says about the texture of its triangles.

use super::Substrate;

/// Texture coordinates and materials, by the number that a triangle has in the file
/// ([`Substrate::source_triangle`](super::Substrate::source_triangle)).
///
/// Coordinates are glTF's: (0, 0) is the upper left corner of the image, (1, 1) the lower right one.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Texturing {
    /// For each triangle those of its corners; none where a corner has none, or none that is finite.
    pub uvs: Vec<Option<[[f64; 2]; 3]>>,
    /// For each triangle its place in `materials`, if it has one.
    pub material_of: Vec<Option<u32>>,
    /// As glTF has them. Those of OBJ's libraries are not read.
    pub materials: Vec<Material>,
    /// Encoded image files, by the place that a [`Texture`] names.
    pub images: Vec<Vec<u8>>,
    /// What had to be passed over, in words for the user.
    pub notes: Vec<String>,
}

/// What a surface is made of (Khronos, *glTF 2.0 Specification*, 3.9.2).
#[derive(Clone, Debug, PartialEq)]
pub struct Material {
    /// Linear red, green and blue: a factor where there is a texture.
    pub base_color: [f32; 3],
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
}

/// An image on a surface, repeated beyond its borders.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Texture {
    /// Its place in [`Texturing::images`].
    pub image: usize,
    /// How strongly a normal or occlusion texture counts: 1 as it is.
    pub strength: f32,
    /// From (u, v, 1) to the image's coordinates: the two rows of `KHR_texture_transform`.
    pub transform: [[f64; 3]; 2],
}

impl Texturing {
    /// Coordinates of the corners of a substrate's triangle, as far as the file has any.
    pub fn uvs_of(&self, substrate: &Substrate, triangle: u32) -> Option<[[f64; 2]; 3]> {
        let source = substrate.source_triangle(triangle) as usize;
        let uvs = self.uvs.get(source).copied().flatten()?;
        let at = |weights: [f64; 3]| {
            [0, 1].map(|axis| {
                let all = uvs.iter().zip(weights);
                all.map(|(uv, weight)| weight * uv[axis]).sum()
            })
        };
        match substrate.is_part(triangle) {
            false => Some(uvs),
            true => Some(substrate.source_weights(triangle).map(at)),
        }
    }

    /// Adds the next triangle.
    pub(super) fn push(&mut self, corners: [Option<[f64; 2]>; 3], material: Option<u32>) {
        let sound = |uv: Option<[f64; 2]>| uv.filter(|uv| uv.iter().all(|x| x.is_finite()));
        let [a, b, c] = corners.map(sound);
        let all = || Some([a?, b?, c?]);
        self.uvs.push(all());
        self.material_of.push(material);
    }
}
