//! Lichen as textures in the substrate's own UV layout: for meshes that a game or a film has already.
//!
//! Each texel is a place of the surface, and is asked what the [skin](mod@crate::skin) is drawn from: the
//! field of Sumner 2001, 8.1, which says the height of the lichen over that place. So maps and skin
//! agree. Texels are sampled several times and averaged; in the gutter around charts the surface
//! goes on beyond the seam (`place.rs`), so that filtering reads the same on both sides.
//!
//! Not guaranteed: that parts of the surface which share texels look right (they are
//! [counted](Overlaps)), and that lichen finer than a texel is told apart.

mod cut;
mod frame;
mod ground;
mod judge;
mod layout;
mod map;
mod mesh;
mod occlusion;
mod place;
mod shown;
mod texel;
mod unwrap;
mod veil;
mod write;

use std::sync::Arc;

use glam::{DVec2, Vec3};
use rayon::prelude::*;

pub use ground::Base;
pub use judge::{LayoutJudgement, judge};
pub use layout::Overlaps;
pub use map::{MAPS, Map, MapKind};
pub use mesh::OwnMesh;
pub use write::{Green, MapFile, MapFormat, Meaning};

use frame::{Frame, frames, order};
use ground::{Beyond, Ground, Surface};
use layout::{Layout, NONE, WIDEST};
use occlusion::{Horizons, SHADED};
use place::Placer;
use shown::Shown;
use texel::{Layer, Sampler, Texels};
use veil::Veil;

use crate::appearance::InImages;
use crate::cluster::Cluster;
use crate::skin::{Paint, Relief, Shape, SkinError};
use crate::substrate::{Alpha, Material, Substrate, Texture, Texturing};

/// Texels in a row of the largest maps.
pub const MOST_ACROSS: u32 = 8192;

/// How large and how fine maps are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Settings {
    /// Texels in a row, and rows: 16 to 8192.
    pub size: u32,
    /// Texels around what the layout covers that are filled too, for filtering and smaller levels of
    /// the texture: 2 to 64.
    pub gutter: u32,
    /// Samples along each side of a texel, 1 to 8: the square of this in all.
    pub samples: u32,
    /// Whether maps are laid out in charts of their own, cut and packed for their size, and not as the mesh's file
    /// says.
    pub unwrap: bool,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            size: 2048,
            gutter: 16,
            samples: 2,
            unwrap: false,
        }
    }
}

/// Charts of their own that cover fewer texels show nothing.
const LEAST_COVERED: usize = 64;

/// UVs that a program has quantised are whole numbers up to 255 or more.
const QUANTISED: f64 = 200.0;

/// Why maps cannot be made.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum BakeError {
    /// There are no texture coordinates.
    #[error("there are no UVs to lay maps out in: unwrap the mesh")]
    NoUvs,
    /// There are texture coordinates, but no triangle has area in them.
    #[error(
        "no triangle has area in the UVs, so there is no place for lichen in a map: unwrap the mesh"
    )]
    FlatUvs,
    /// A triangle is larger than the image.
    #[error(
        "triangle {triangle} is {:.2} images wide in the UVs, which repeat a texture (up to {WIDEST} \
         overlaps itself a little): lichen needs a layout in which each place of the surface has \
         texels of its own; {}",
        (tiles * 100.0).ceil() / 100.0,
        match *tiles > QUANTISED {
            true => "UVs this large are whole numbers that a program has packed them into: give the file as it was before",
            false => "unwrap the mesh again",
        }
    )]
    Repeats {
        /// Its number in the file.
        triangle: u32,
        /// How many images it spans.
        tiles: f64,
    },
    /// Triangles lie on one another many times over.
    #[error(
        "the triangles cover the image {images:.0} times over in the UVs, which share a texture: \
         lichen needs a layout in which each place of the surface has texels of its own; unwrap the \
         mesh again"
    )]
    Stacked {
        /// How many images they would fill.
        images: f64,
    },
    /// Charts of their own do not fit into an image.
    #[error(
        "there are so many charts, or so much between them, that the mesh does not fit into one image: make the image \
         larger, or bake the mesh part by part"
    )]
    Crowded,
    /// There can be no charts of their own.
    #[error("laying out charts failed: {0}")]
    Unwrap(String),
    /// A setting that is out of its range.
    #[error("{name} is {value}: it may be {low} to {high}")]
    Range {
        /// What it is called.
        name: &'static str,
        /// What was asked for.
        value: u32,
        /// The least that it may be.
        low: u32,
        /// The most.
        high: u32,
    },
    /// The lichen's shape is not one, or there is none.
    #[error(transparent)]
    Skin(#[from] SkinError),
    /// An image for the substrate's colour that cannot be read.
    #[error("the image of the base colour cannot be read: {0}")]
    Base(String),
}

impl BakeError {
    /// Whether triangles share texels that would have some of their own in another layout.
    pub fn is_of_sharing(&self) -> bool {
        match self {
            Self::Repeats { tiles, .. } => *tiles <= QUANTISED,
            Self::Stacked { .. } => true,
            _ => false,
        }
    }

    /// Whether the file gives triangles no place in a layout at all.
    pub fn is_of_missing_uvs(&self) -> bool {
        matches!(self, Self::NoUvs | Self::FlatUvs)
    }
}

impl Settings {
    /// Checks that every number is in its range.
    ///
    /// # Errors
    /// [`BakeError::Range`] for the first that is not.
    pub fn check(&self) -> Result<(), BakeError> {
        let ranges = [
            ("size (in texels)", self.size, 16, MOST_ACROSS),
            ("gutter (in texels)", self.gutter, 2, 64),
            ("samples", self.samples, 1, 8),
        ];
        let outside = |(_, value, low, high): &(_, u32, u32, u32)| !(low..=high).contains(&value);
        let wrong = ranges.into_iter().find(outside);
        wrong.map_or(Ok(()), |(name, value, low, high)| {
            Err(BakeError::Range {
                name,
                value,
                low,
                high,
            })
        })
    }
}

/// A lichen and how it looks.
#[derive(Clone, Copy, Debug)]
pub struct Look<'a> {
    /// Its elements.
    pub cluster: &'a Cluster,
    /// The shape of its skin; the resolution is the texel's.
    pub shape: &'a Shape,
    /// Its colours.
    pub paint: &'a Paint,
}

/// Lichens in the texels of their substrate: every [`Map`] is read from it.
pub struct Baked<'a> {
    shown: Shown<'a>,
    layout: Layout,
    frames: Vec<Frame>,
    texels: Texels,
    ground: &'a Ground<'a>,
    beyond: Beyond<'a>,
    veil: Veil,
    texel: f64,
    /// Height of the highest texel, local units.
    highest: f32,
}

impl std::fmt::Debug for Baked<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Baked").finish_non_exhaustive()
    }
}

/// What a layout was found to be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LayoutReport {
    /// Texels of the image.
    pub texels: usize,
    /// Those under a triangle.
    pub covered: usize,
    /// Those under several.
    pub overlaps: Overlaps,
    /// Triangles that were to be shown.
    pub triangles: usize,
    /// Those of them that have no area in the layout, or no UVs: lichen on them is in no map.
    pub not_shown: usize,
    /// Usual side of a texel on the surface, in the mesh file's units.
    pub texel: f64,
}

/// Lichens on their substrate, to be baked into the layout of the whole or of parts of it; the same on any number of
/// threads.
///
/// Lichens know nothing of each other: where several cover a place, the last of them is seen.
pub struct Baker<'a> {
    substrate: &'a Substrate,
    texturing: &'a Texturing,
    layers: Vec<Layer<'a>>,
    ground: Ground<'a>,
    settings: Settings,
    /// That of elements, of several lichens the least; local units.
    radius: f64,
    /// For each triangle whether lichen may be on it, or shade it.
    carried: Vec<bool>,
}

impl std::fmt::Debug for Baker<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Baker").finish_non_exhaustive()
    }
}

impl<'a> Baker<'a> {
    /// Lichens over what their substrate looks like without them.
    ///
    /// # Errors
    /// When a number of the settings or of a shape is out of its range, when there is no lichen or one without
    /// elements, or when the image of the base cannot be read.
    ///
    /// # Panics
    /// Those of [`skin`](crate::skin::skin()), here or when maps are made.
    pub fn new(
        substrate: &'a Substrate,
        texturing: &'a Texturing,
        lichens: &[Look],
        base: &Base,
        settings: &Settings,
    ) -> Result<Self, BakeError> {
        settings.check()?;
        let layers: Result<Vec<Layer>, _> = lichens.iter().map(|l| layer(substrate, l)).collect();
        let layers = layers?;
        if layers.is_empty() {
            return Err(SkinError::Empty.into());
        }
        let radii = lichens.iter().map(|l| l.cluster.radius());
        let radius = radii.fold(f64::INFINITY, f64::min);
        Ok(Self {
            carried: carried(substrate, &layers, SHADED * radius),
            substrate,
            texturing,
            layers,
            ground: Ground::new(substrate, texturing, base).map_err(BakeError::Base)?,
            settings: *settings,
            radius,
        })
    }

    /// Bakes them into the layout of the whole mesh.
    ///
    /// # Errors
    /// When the mesh has no UVs, repeats a texture or shares it many times over.
    pub fn whole(&self) -> Result<Baked<'_>, BakeError> {
        self.bake(None)
    }

    /// Bakes them into the layout of some triangles, chosen by their numbers in the file; what comes after the last
    /// number is not.
    ///
    /// # Errors
    /// As for the [whole](Self::whole), of these triangles.
    pub fn part<'b>(&'b self, chosen: &'b [bool]) -> Result<Baked<'b>, BakeError> {
        self.bake(Some(chosen))
    }

    /// What of the mesh's material could not be used, in words for the user.
    pub fn notes(&self) -> impl Iterator<Item = &str> {
        self.ground.notes()
    }

    /// Whether the [whole](Self::whole), or a [part](Self::part) where some are chosen, can be baked: found out much
    /// sooner than by baking it. Charts of their own are laid out only then.
    ///
    /// # Errors
    /// Those of baking it, but for [`BakeError::Crowded`].
    pub fn check(&self, chosen: Option<&[bool]>) -> Result<(), BakeError> {
        if self.settings.unwrap {
            return Ok(());
        }
        layout::check(&self.shown(chosen), self.settings.size as usize)
    }

    /// A material of the mesh's file without textures that could not be read.
    ///
    /// # Panics
    /// When there is no such material.
    pub fn own_material(&self, number: usize) -> Material {
        let mut material = self.texturing.materials[number].clone();
        let is_lost = |texture: &mut Texture| !self.ground.has_image(texture.image);
        if material.base_color_texture.take_if(is_lost).is_some() {
            material.base_color = material.bare_color;
        }
        material.metallic_roughness_texture.take_if(is_lost);
        material.normal_texture.take_if(is_lost);
        material.occlusion_texture.take_if(is_lost);
        material.emissive_texture.take_if(is_lost);
        material
    }

    /// For each triangle of the file whether lichen may be on it, or shade it.
    pub fn lichened(&self) -> Vec<bool> {
        let mut lichened = vec![false; self.texturing.material_of.len()];
        for t in (0..self.carried.len() as u32).filter(|&t| self.carried[t as usize]) {
            let source = self.substrate.source_triangle(t) as usize;
            lichened
                .get_mut(source)
                .into_iter()
                .for_each(|is| *is = true);
        }
        lichened
    }

    /// Whether a triangle of the substrate has a place in the layout of maps, whatever part it is in.
    ///
    /// # Panics
    /// When there is no such triangle.
    pub fn has_place(&self, triangle: u32) -> bool {
        let size = f64::from(self.settings.size);
        let corners = || layout::corners_of(&self.shown(None), triangle, size);
        self.settings.unwrap || !matches!(corners(), Ok(None))
    }

    /// Whether nothing is left of a part: its triangles lie where others do, or have no area.
    pub fn is_gone(&self, chosen: Option<&[bool]>) -> bool {
        self.shown(chosen).triangles().next().is_none()
    }

    /// Whether a part needs no maps: no lichen is on it, and all of it has a material that may stay as it is.
    pub fn is_bare(&self, chosen: Option<&[bool]>) -> bool {
        let shown = self.shown(chosen);
        let needs_maps = |t: u32| shown.material_of(t).is_none() || self.carried[t as usize];
        self.ground.is_own() && !shown.triangles().any(needs_maps)
    }

    fn shown<'b>(&'b self, chosen: Option<&'b [bool]>) -> Shown<'b> {
        Shown {
            substrate: self.substrate,
            texturing: self.texturing,
            chosen,
            charts: None,
        }
    }

    /// With the coordinates that maps are laid out in.
    fn laid_out<'b>(&'b self, chosen: Option<&'b [bool]>) -> Result<Shown<'b>, BakeError> {
        let mut shown = self.shown(chosen);
        if self.settings.unwrap {
            shown.charts = Some(Arc::new(unwrap::unwrap(&shown, &self.settings)?));
        }
        Ok(shown)
    }

    fn bake<'b>(&'b self, chosen: Option<&'b [bool]>) -> Result<Baked<'b>, BakeError> {
        let (size, gutter) = (self.settings.size as usize, self.settings.gutter as usize);
        let shown = self.laid_out(chosen)?;
        let layout = Layout::new(&shown, size, gutter)?;
        if shown.charts.is_some() && layout.covered < LEAST_COVERED {
            return Err(BakeError::Crowded);
        }
        let frames = frames(&shown);
        let placer = Placer::new(self.substrate, &layout);
        let sampler = Sampler {
            placer: &placer,
            layers: &self.layers,
            frames: &frames,
            along: self.settings.samples,
        };
        let mut texels = sampler.sample(gutter);
        let horizons = Horizons {
            placer: &placer,
            frames: &frames,
            radius: self.radius,
            known: gutter as f64 - 1.0,
        };
        texels.occlude(|texels, number, texel| horizons.light(texels, number, texel));
        Ok(Baked {
            highest: texels.iter().fold(0.0, |most, t| most.max(t.height)),
            texel: placer.texel,
            layout,
            frames,
            texels,
            ground: &self.ground,
            beyond: Beyond::new(shown.clone(), &self.ground),
            veil: Veil::new(&shown),
            shown,
        })
    }
}

/// For each triangle whether lichen may be on it, or within a margin of it on its piece of the mesh.
fn carried(substrate: &Substrate, layers: &[Layer], margin: f64) -> Vec<bool> {
    let carries = |triangle: u32| {
        let piece = substrate.component_of(triangle).triangles.start;
        let mut layers = layers.iter();
        layers.any(|l| l.pieces.contains(&piece) && l.relief.may_carry(triangle, margin))
    };
    let all = 0..substrate.triangles().len() as u32;
    all.into_par_iter().map(carries).collect()
}

fn layer<'a>(substrate: &'a Substrate, lichen: &Look) -> Result<Layer<'a>, SkinError> {
    Ok(Layer {
        relief: Relief::new(substrate, lichen.cluster, lichen.shape, lichen.paint)?,
        paint: lichen.paint.clone(),
        last: lichen.cluster.len().saturating_sub(1) as f32,
        pieces: lichen
            .cluster
            .elements()
            .iter()
            .map(|element| substrate.component_of(element.at.triangle).triangles.start)
            .collect(),
    })
}

impl Baked<'_> {
    /// Texels in a row, and rows.
    pub fn size(&self) -> usize {
        self.layout.size
    }

    /// Texels along the longer side of the largest image that its colours are read from; 0 where there is none.
    pub fn largest_image(&self) -> usize {
        self.ground.largest_image(&self.shown)
    }

    /// What the layout was found to be.
    pub fn report(&self) -> LayoutReport {
        let is_hidden = |t: &u32| self.layout.corners[*t as usize].is_none();
        LayoutReport {
            texels: self.layout.owners.len(),
            covered: self.layout.covered,
            overlaps: self.layout.overlaps,
            triangles: self.shown.triangles().count(),
            not_shown: self.shown.triangles().filter(is_hidden).count(),
            texel: self.shown.substrate.units().length_to_file(self.texel),
        }
    }

    /// Whether a triangle of the substrate is in the part that was baked.
    ///
    /// # Panics
    /// When there is no such triangle.
    pub fn shows(&self, triangle: u32) -> bool {
        self.shown.has(triangle)
    }

    /// Half-edges where the layout is cut, each with its ends as UVs: those of the substrate's
    /// triangle h / 3, from its corner h % 3 to the next.
    pub fn seams(&self) -> Vec<(u32, [[f64; 2]; 2])> {
        let size = self.size() as f64;
        let uv = |p: DVec2| ((p + 0.5) / size).to_array();
        let ends = |h: u32| Some((h, self.layout.edge(h)?.map(uv)));
        let seams = self.layout.seams(self.shown.substrate);
        seams.into_iter().filter_map(ends).collect()
    }

    /// The axes of the normal map at a place of a triangle: tangent, bitangent and normal, as
    /// interpolated by weight from its corners.
    ///
    /// Of a triangle that is not [shown](Self::shows) they mean nothing.
    ///
    /// # Panics
    /// When there is no such triangle.
    pub fn tangent_frame(&self, triangle: u32, weights: [f64; 3]) -> [[f32; 3]; 3] {
        self.frames[triangle as usize]
            .axes(weights)
            .to_cols_array_2d()
    }

    /// The owner of a texel, if it has one, and where its middle is in images: as the owner has it, whose coordinates
    /// may lie whole images away.
    fn owner(&self, texel: usize) -> (Option<u32>, InImages) {
        let owner = Some(self.layout.owners[texel]).filter(|&o| o != NONE);
        let placed = owner.and_then(|owner| Some((owner, self.weights(owner, texel)?)));
        let Some((owner, weights)) = placed else {
            return (owner, self.beside(texel));
        };
        let Shown {
            substrate,
            texturing,
            ..
        } = &self.shown;
        let at = InImages::of((substrate, texturing), owner, weights);
        (Some(owner), at)
    }

    /// Where a texel that shows no triangle is in images: in those of the maps' own layout, if there are such.
    fn beside(&self, texel: usize) -> InImages {
        let uv = (self.layout.middle(texel) + 0.5) / self.layout.size as f64;
        let is_files = self.shown.charts.is_none();
        InImages([is_files.then_some(uv.to_array()), None])
    }

    /// The weights of a triangle's corners in the middle of a texel, if it is in the layout.
    fn weights(&self, triangle: u32, texel: usize) -> Option<[f64; 3]> {
        let corners = self.layout.corners[triangle as usize]?;
        let middle = self.layout.near(&corners, self.layout.middle(texel));
        Some(layout::weights(&corners, middle))
    }

    /// What the substrate is like at a texel, without its colour.
    fn surface(&self, texel: usize) -> Surface {
        let (owner, at) = self.owner(texel);
        let mut surface = self.ground.surface(owner.unwrap_or(self.beyond.first), &at);
        let has_own_axes =
            |owner: &u32| self.shown.charts.is_some() || self.ground.is_tilted_elsewhere(*owner);
        if let Some(owner) = owner.filter(has_own_axes) {
            surface.normal = self.tilted(owner, texel, &at).unwrap_or(Vec3::Z);
        }
        surface
    }

    /// Its normal, where its texture has a tangent space of its own, if that is one.
    fn tilted(&self, owner: u32, texel: usize, at: &InImages) -> Option<Vec3> {
        let (frame, weights) = (self.frames[owner as usize], self.weights(owner, texel)?);
        let smooth = frame.axes(weights).z_axis.normalize_or(Vec3::Y);
        let normal = self.ground.tilted(owner, at, smooth)?;
        Some(frame.to_tangent_space(weights, normal))
    }

    /// What is seen through what was baked: all of it in one, as its materials say.
    pub fn alpha(&self) -> Alpha {
        self.veil.alpha
    }

    /// Whether any of its materials shows from behind.
    pub fn is_double_sided(&self) -> bool {
        self.veil.is_double_sided
    }

    /// The opacity at a texel in a column and a row, from the upper left, by which its [alpha](Self::alpha) decides.
    /// Lichen hides what is blended, as glass, but leaves holes open, and what is cut out as it is.
    ///
    /// # Panics
    /// Beyond the image.
    pub fn opacity(&self, x: usize, y: usize) -> f32 {
        assert!(x < self.size(), "column {x} of {}", self.size());
        let texel = y * self.size() + x;
        let (owner, at) = self.owner(texel);
        let material = self.shown.material_of(owner.unwrap_or(self.beyond.first));
        let material = material.map(|number| &self.shown.texturing.materials[number]);
        let lichen = self.texels.get(texel).map_or(0.0, |t| t.mask);
        self.veil.opacity(self.ground, material, (&at, lichen))
    }

    /// Its colour.
    fn bare_color(&self, texel: usize) -> Vec3 {
        let (owner, at) = self.owner(texel);
        self.ground.base_color((owner, &self.beyond), &at, || {
            let placer = Placer {
                substrate: self.shown.substrate,
                layout: &self.layout,
                texel: self.texel,
            };
            let corners = self.layout.corners[owner? as usize]?;
            let place = placer.place(owner?, &corners, self.layout.middle(texel));
            Some(place.at)
        })
    }

    /// The lichen over the substrate's own normal map.
    fn normal(&self, texel: usize) -> Vec3 {
        let under = self.surface(texel).normal;
        let Some(lichen) = self.texels.get(texel) else {
            return under;
        };
        under.lerp(lichen.normal, lichen.mask).normalize_or(Vec3::Z)
    }
}
