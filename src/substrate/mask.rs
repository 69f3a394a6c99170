//! Where on a surface lichen may grow, as somebody has painted it or other lichens leave room.

use std::collections::BTreeMap;
use std::sync::Arc;

use glam::{DVec3, Vec3};

use super::division::Tile;
use super::neighbour::Neighbour;
use super::openings::Openings;
use super::{Selection, SelectionError, Substrate, SurfacePoint, Texturing};
use crate::image::{Image, Wrap};

/// What is darker counts as black, and what is lighter as white: an image that was compressed has few texels of either.
const BLACK: f32 = 1.0 / 16.0;
const WHITE: f32 = 15.0 / 16.0;

/// A mask for the triangles of one [`Substrate`]: black where nothing grows, white where lichen grows as anywhere; what
/// is grey in between is a factor on the chance to stick. See [`Substrate::with_mask`].
///
/// It may have several layers, whose order makes no difference: lichen grows only where all let it.
#[derive(Clone)]
pub struct Mask {
    /// The hash of its substrate's mesh.
    mesh: String,
    triangles: usize,
    /// By their hashes.
    layers: Vec<Arc<Layer>>,
}

impl std::fmt::Debug for Mask {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Mask")
            .field("hashes", &self.hashes())
            .finish()
    }
}

struct Layer {
    paint: Paint,
    hash: String,
    /// Whether it is all white, as far as triangles go by it.
    is_white: bool,
}

/// By the substrate's triangles; none where a triangle has nothing to go by, which is as good as black.
enum Paint {
    /// Brightness at the corners.
    Corners(Vec<Option<[f32; 3]>>),
    /// Whether it is chosen.
    Faces(Vec<bool>),
    /// Where the corners are in one of the images.
    Images(Vec<Image>, Vec<Option<Laid>>),
    /// Another lichen: of the room that it leaves.
    Lichen(Neighbour),
    /// What is not inside another piece of the mesh.
    Exposed,
    /// What its materials do not leave open.
    Seen(Openings),
}

/// Where a triangle lies in an image.
#[derive(Clone, Copy)]
struct Laid {
    /// The place of the image in a list.
    image: u32,
    uvs: [[f32; 2]; 3],
}

/// Why something is no mask for a substrate.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum MaskError {
    /// The image cannot be read.
    #[error("the mask cannot be read: {0}")]
    Image(String),
    /// Images need coordinates.
    #[error(
        "an image is a mask for a mesh with UVs, and this one has none: unwrap it and export it with its UVs, or paint its \
         vertices and use their colours"
    )]
    NoUvs,
    /// The mask is laid out in a second set of coordinates.
    #[error(
        "the mask is laid out in the mesh's second set of UVs (TEXCOORD_1 of glTF), and this mesh has none: lay it out in \
         the first, without uv1:"
    )]
    NoSecondUvs,
    /// Nothing is laid out in any of the tiles.
    #[error(
        "no triangle of the mesh is laid out in any of the UDIM tiles that have an image: they are squares with u from 0 to 10 \
         and v from 0 on"
    )]
    NoTile,
    /// No vertex has a colour.
    #[error("the mesh has no colours at its vertices: export it with its colour attribute")]
    NoColors,
    /// Nothing is chosen.
    #[error(transparent)]
    Selection(#[from] SelectionError),
}

impl Mask {
    /// A mask of an encoded PNG or JPEG image in the layout of the mesh's UVs, repeated beyond its borders. What
    /// counts is how bright it is, 0.2126 R + 0.7152 G + 0.0722 B of its numbers as they are; what is transparent is
    /// black.
    ///
    /// # Errors
    /// When it is no such image, or no triangle has UVs.
    pub fn from_image(
        substrate: &Substrate,
        texturing: &Texturing,
        bytes: &[u8],
    ) -> Result<Self, MaskError> {
        let uvs = |t| texturing.uvs_of(substrate, t);
        let hash = blake3::hash(bytes);
        Self::of_image(substrate, uvs, (bytes, hash))
    }

    /// The same of an image in the layout of the mesh's second set of UVs (`TEXCOORD_1` of glTF).
    ///
    /// # Errors
    /// When it is no such image, or no triangle has UVs of that set.
    pub fn from_second_image(
        substrate: &Substrate,
        texturing: &Texturing,
        bytes: &[u8],
    ) -> Result<Self, MaskError> {
        let uvs = |t| texturing.second_uvs_of(substrate, t);
        let mut hasher = blake3::Hasher::new();
        hasher.update(bytes).update(b"in the second set");
        let mask = Self::of_image(substrate, uvs, (bytes, hasher.finalize()));
        mask.map_err(|e| match e {
            MaskError::NoUvs => MaskError::NoSecondUvs,
            other => other,
        })
    }

    /// A mask of several images, each in the layout of the UDIM tile of its number, as [one image](Self::from_image)
    /// is in the first, 1001. Nothing grows on tiles that have none.
    ///
    /// # Errors
    /// When one is no such image, no triangle has UVs, or none lies in any of these tiles.
    pub fn from_tiles(
        substrate: &Substrate,
        texturing: &Texturing,
        tiles: &BTreeMap<u32, Vec<u8>>,
    ) -> Result<Self, MaskError> {
        let decode = |(number, bytes): (&u32, &Vec<u8>)| {
            let image = Image::decode_mask(bytes);
            image.map_err(|problem| MaskError::Image(format!("tile {number}: {problem}")))
        };
        let images = tiles.iter().map(decode).collect::<Result<Vec<_>, _>>()?;
        let laid = |t| {
            let uvs = texturing.uvs_of(substrate, t)?;
            let tile = Tile::of(&uvs);
            let [column, row] = tile.place().map(|x| x as f64);
            Some(Laid {
                image: tiles.keys().position(|key| tile.number() == Some(*key))? as u32,
                // v counts from above.
                uvs: uvs.map(|[u, v]| [u - column, v + row].map(|x| x as f32)),
            })
        };
        let mut hasher = blake3::Hasher::new();
        for (number, bytes) in tiles {
            hasher.update(&number.to_le_bytes());
            hasher.update(blake3::hash(bytes).as_bytes());
        }
        let mask = Self::of_images(substrate, images, laid, hasher.finalize());
        let has_uvs = || all(substrate).any(|t| texturing.uvs_of(substrate, t).is_some());
        mask.ok_or_else(|| match has_uvs() {
            true => MaskError::NoTile,
            false => MaskError::NoUvs,
        })
    }

    fn of_image(
        substrate: &Substrate,
        uvs: impl Fn(u32) -> Option<[[f64; 2]; 3]>,
        (bytes, hash): (&[u8], blake3::Hash),
    ) -> Result<Self, MaskError> {
        let image = Image::decode_mask(bytes).map_err(MaskError::Image)?;
        let laid = |t| {
            let uvs = uvs(t)?.map(|uv| uv.map(|x| x as f32));
            Some(Laid { image: 0, uvs })
        };
        Self::of_images(substrate, vec![image], laid, hash).ok_or(MaskError::NoUvs)
    }

    /// None where no triangle lies in an image.
    fn of_images(
        substrate: &Substrate,
        images: Vec<Image>,
        laid: impl Fn(u32) -> Option<Laid>,
        hash: blake3::Hash,
    ) -> Option<Self> {
        let laid: Vec<_> = all(substrate).map(laid).collect();
        let is_white = |image: &Image| image.least() > WHITE;
        let layer = Layer {
            is_white: images.iter().all(is_white) && laid.iter().all(Option::is_some),
            hash: hash.to_hex().to_string(),
            paint: Paint::Images(images, laid),
        };
        let is_some = (0..substrate.triangles().len()).any(|t| layer.paint.covers(t));
        is_some.then(|| Self::of_layer(substrate, layer))
    }

    /// A mask of the colours at the mesh's vertices: how bright they are, as of an [image](Self::from_image), but of
    /// linear light. Of two sets it is [the painted one](Texturing::is_second_painted).
    ///
    /// # Errors
    /// When no triangle has colours.
    pub fn from_colors(substrate: &Substrate, texturing: &Texturing) -> Result<Self, MaskError> {
        let is_second = texturing.is_second_painted();
        let colors = |t| match is_second {
            true => texturing.second_colors_of(substrate, t),
            false => texturing.colors_of(substrate, t),
        };
        let at_corners = |t| Some(colors(t)?.map(brightness_of));
        let corners: Vec<_> = all(substrate).map(at_corners).collect();
        if corners.iter().all(Option::is_none) {
            return Err(MaskError::NoColors);
        }
        let mut hasher = blake3::Hasher::new();
        for value in corners.iter().flat_map(|c| c.unwrap_or([f32::NAN; 3])) {
            hasher.update(&value.to_le_bytes());
        }
        let is_white = |corners: &Option<[f32; 3]>| {
            corners.is_some_and(|corners| corners.into_iter().all(|x| x > WHITE))
        };
        let layer = Layer {
            is_white: corners.iter().all(is_white),
            paint: Paint::Corners(corners),
            hash: hasher.finalize().to_hex().to_string(),
        };
        Ok(Self::of_layer(substrate, layer))
    }

    /// A mask of a choice of triangles: those white, the others black.
    ///
    /// # Errors
    /// When the file has no such names.
    pub fn from_selection(
        substrate: &Substrate,
        texturing: &Texturing,
        selection: &Selection,
    ) -> Result<Self, MaskError> {
        let chosen = selection.triangles(texturing)?;
        let of = |t| chosen.get(substrate.source_triangle(t) as usize) == Some(&true);
        let faces: Vec<bool> = all(substrate).map(of).collect();
        let bytes: Vec<u8> = faces.iter().map(|&face| u8::from(face)).collect();
        let layer = Layer {
            is_white: !faces.contains(&false),
            paint: Paint::Faces(faces),
            hash: blake3::hash(&bytes).to_hex().to_string(),
        };
        Ok(Self::of_layer(substrate, layer))
    }

    /// A mask of the room that another lichen leaves: elements do not overlap its elements, which are at these
    /// positions with this radius; local units. That is asked of distances through space, as packed elements are told
    /// apart.
    ///
    /// # Panics
    /// When a position or the radius is not finite, or the radius is negative.
    pub fn beside(substrate: &Substrate, positions: &[DVec3], radius: f64) -> Self {
        let is_there =
            radius >= 0.0 && radius.is_finite() && positions.iter().all(|p| p.is_finite());
        assert!(
            is_there,
            "another lichen that is nowhere, with a radius of {radius}"
        );
        let mut hasher = blake3::Hasher::new();
        for value in positions.iter().flat_map(DVec3::to_array).chain([radius]) {
            hasher.update(&value.to_le_bytes());
        }
        let layer = Layer {
            is_white: positions.is_empty(),
            paint: Paint::Lichen(Neighbour::new(positions, radius)),
            hash: hasher.finalize().to_hex().to_string(),
        };
        Self::of_layer(substrate, layer)
    }

    /// A mask of what is exposed: no element grows where it would be inside another piece of the mesh, as where bricks
    /// are put into mortar, or right beneath one.
    pub fn exposed(substrate: &Substrate) -> Self {
        let layer = Layer {
            paint: Paint::Exposed,
            hash: blake3::hash(b"exposed").to_hex().to_string(),
            is_white: substrate.components().len() == 1,
        };
        Self::of_layer(substrate, layer)
    }

    /// A mask of what the materials of the mesh's file do not leave open: nothing grows where leaves are cut out of an
    /// image (`alphaMode` `MASK`, below the cutoff), and on glass (`BLEND`, an opacity below one half).
    ///
    /// # Errors
    /// When an image that says what is open cannot be read.
    pub fn opaque(substrate: &Substrate, texturing: &Texturing) -> Result<Self, MaskError> {
        let openings = Openings::new(substrate, texturing).map_err(MaskError::Image)?;
        let layer = Layer {
            is_white: openings.are_none(),
            hash: openings.hash(texturing),
            paint: Paint::Seen(openings),
        };
        Ok(Self::of_layer(substrate, layer))
    }

    fn of_layer(substrate: &Substrate, layer: Layer) -> Self {
        Self {
            mesh: substrate.mesh_hash().to_owned(),
            triangles: substrate.triangles().len(),
            layers: vec![Arc::new(layer)],
        }
    }

    /// This mask and another: where either has nothing grow nothing does, and factors are multiplied.
    ///
    /// # Panics
    /// When they were made for different meshes.
    #[must_use]
    pub fn and(mut self, other: Self) -> Self {
        let are_of_one = (&self.mesh, self.triangles) == (&other.mesh, other.triangles);
        assert!(are_of_one, "masks of different meshes");
        self.layers.extend(other.layers);
        self.layers.sort_by(|a, b| a.hash.cmp(&b.hash));
        self
    }

    /// A BLAKE3 hash of each layer, ascending: of the image's file, of that and words where it is laid out in the
    /// second set of UVs, of tiles' numbers and files, of the brightness at the corners, of which triangles are chosen,
    /// of the positions and the radius of another lichen, of what says where materials are open, or of the word
    /// `exposed`. Hexadecimal.
    pub fn hashes(&self) -> Vec<&str> {
        self.layers
            .iter()
            .map(|layer| layer.hash.as_str())
            .collect()
    }

    /// Whether it keeps lichen from growing nowhere.
    pub fn is_white(&self) -> bool {
        self.layers.iter().all(|layer| layer.is_white)
    }

    /// How many triangles have neither UVs nor colours, as a layer goes by the ones or the others: nothing grows on
    /// them.
    pub fn unpainted(&self) -> usize {
        let is_unpainted = |t: &usize| self.layers.iter().any(|layer| !layer.paint.covers(*t));
        (0..self.triangles).filter(is_unpainted).count()
    }

    /// From 0, where nothing grows, to 1, as it is painted; what room other lichens leave is [another
    /// question](Self::leaves_room), and so is [what is exposed](Self::asks_for_exposed).
    ///
    /// # Panics
    /// When the substrate that it was made for has no such triangle.
    pub fn at(&self, at: &SurfacePoint) -> f64 {
        assert!((at.triangle as usize) < self.triangles, "no triangle of it");
        self.layers.iter().map(|layer| layer.paint.at(at)).product()
    }

    /// Whether it asks for what is [exposed](Self::exposed), which [`at`](Self::at) does not say.
    pub fn asks_for_exposed(&self) -> bool {
        let is_of_that = |layer: &Arc<Layer>| matches!(layer.paint, Paint::Exposed);
        self.layers.iter().any(is_of_that)
    }

    /// Whether other lichens leave room for an element of this radius; local units.
    pub fn leaves_room(&self, here: DVec3, radius: f64) -> bool {
        self.layers.iter().all(|layer| match &layer.paint {
            Paint::Lichen(neighbour) => neighbour.leaves_room(here, radius),
            _ => true,
        })
    }

    /// Whether it was made for a substrate of this mesh.
    pub(super) fn is_for(&self, substrate: &Substrate) -> bool {
        self.mesh == substrate.mesh_hash() && self.triangles == substrate.triangles().len()
    }
}

impl Paint {
    /// Whether a triangle has something to go by.
    fn covers(&self, triangle: usize) -> bool {
        match self {
            Self::Corners(corners) => corners[triangle].is_some(),
            Self::Images(_, laid) => laid[triangle].is_some(),
            Self::Faces(_) | Self::Lichen(_) | Self::Exposed | Self::Seen(_) => true,
        }
    }

    fn at(&self, at: &SurfacePoint) -> f64 {
        let triangle = at.triangle as usize;
        let brightness = match self {
            Self::Corners(corners) => corners[triangle].map(|corners| mean(corners, at)),
            Self::Images(images, laid) => laid[triangle].map(|Laid { image, uvs }| {
                let image = &images[image as usize];
                let place = [0, 1].map(|axis| f64::from(mean(uvs.map(|uv| uv[axis]), at)));
                // Only what is laid out beyond its borders is meant to repeat it.
                let is_within = uvs.as_flattened().iter().all(|x| (0.0..=1.0).contains(x));
                let place = match is_within {
                    true => image.wrapped(place, [Wrap::Clamp; 2]),
                    false => place,
                };
                brightness_of(image.values(place).to_array())
            }),
            Self::Faces(faces) => return f64::from(u8::from(faces[triangle])),
            Self::Seen(openings) => return f64::from(u8::from(!openings.has(at))),
            Self::Lichen(_) | Self::Exposed => return 1.0,
        };
        match brightness {
            Some(x) if x > WHITE => 1.0,
            Some(x) if x >= BLACK => f64::from(x),
            _ => 0.0,
        }
    }
}

fn all(substrate: &Substrate) -> std::ops::Range<u32> {
    0..substrate.triangles().len() as u32
}

/// Luma, as ITU-R BT.709 weighs it.
fn brightness_of(color: [f32; 3]) -> f32 {
    Vec3::from_array(color).dot(Vec3::new(0.2126, 0.7152, 0.0722))
}

/// The mean of a triangle's corners by weight.
pub(super) fn mean(corners: [f32; 3], at: &SurfacePoint) -> f32 {
    let weighted = std::iter::zip(corners, at.weights()).map(|(x, weight)| f64::from(x) * weight);
    weighted.sum::<f64>() as f32
}
