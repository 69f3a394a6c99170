//! A picture of a substrate with lichen on it: pure functions from finished values to pixels.
//!
//! Rays are cast through BVHs of the triangles and the discs, which are drawn as matte domes. The
//! light is a studio's: a soft key light, the glow of a pale room that reaches into hollows as far
//! as it can (ambient occlusion, with one bounce of the hollow's own colour), and a shadow on the
//! floor; a film's response turns light into bytes. Every random number is a hash of the pixel, so
//! the bytes do not depend on the number of threads. The picture is for looking at: no measurement
//! should be taken from it.

mod camera;
mod color;
mod drawing;
mod gif;
mod image;
mod legend;
mod marked;
mod material;
mod openings;
mod render;
mod sample;
mod shade;
mod shape;
mod sheet;
mod smooth;
mod stage;
mod text;
mod time_lapse;
mod trace;
mod view;
mod wide;

use std::fmt;

pub use camera::Camera;
pub use color::{age_color, hue_color};
pub use gif::{FASTEST_GIF, GifPacker, GifPalette, GifPicture, GifWriter};
pub use image::Image;
pub use legend::{Key, draw_legend, number, round_below};
pub use material::Ground;
pub(crate) use material::longest_axis;
pub use render::{Background, Settings, render, render_unless};
pub use sheet::{ContactSheet, Tile};
pub use stage::Stage;
pub use text::unwritable;
pub use time_lapse::TimeLapse;
pub use trace::{Stone, World};
pub use view::Sight;

/// A round granule, drawn as a dome of height 0.6 × `radius` on the side of `normal`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Disc {
    /// Its middle, on the surface.
    pub center: [f32; 3],
    /// Outwards; any length but zero.
    pub normal: [f32; 3],
    /// Its radius, in the units of `center`.
    pub radius: f32,
    /// sRGB.
    pub color: [u8; 3],
}

/// A triangle mesh with colours, such as a skin.
#[derive(Clone, Copy, Debug)]
pub struct Painted<'a> {
    /// Any unit.
    pub positions: &'a [[f32; 3]],
    /// Unit normals at the vertices, for smooth shading.
    pub normals: &'a [[f32; 3]],
    /// sRGB at the vertices.
    pub colors: &'a [[u8; 3]],
    /// Numbers of vertices; either winding.
    pub triangles: &'a [[u32; 3]],
    /// The size of the fine relief and of the mottles that the surface is drawn with, in the units
    /// of `positions`: about an element's radius for lichen, 0 for a plain surface.
    pub grain: f32,
    /// What is finer than the triangles.
    pub structure: Option<&'a dyn Structure>,
}

/// The structure of a painted mesh, read at every sample.
pub trait Structure: Sync {
    /// At a place between the [feet](Self::foot) of vertices, where the mesh has this unit normal; in the units of the
    /// mesh's positions.
    fn at(&self, place: [f32; 3], normal: [f32; 3]) -> Detail;

    /// The place that it is known at, for a vertex of the mesh: by default that of the vertex.
    fn foot(&self, _vertex: u32) -> Option<[f32; 3]> {
        None
    }
}

impl fmt::Debug for dyn Structure + '_ {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Structure")
    }
}

/// What a structure does to a place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Detail {
    /// What the mesh's own colour is multiplied by, linear.
    pub shade: f32,
    /// Linear colour that is added to that.
    pub cover: [f32; 3],
    /// The gradient along the mesh of the height over it, for shading.
    pub slope: [f32; 3],
}

/// What the substrate looks like by itself, read at every sample.
pub trait Finish: Sync {
    /// At a place of a triangle, by the number it has in [`Stone::new`] and by weights of its corners, where the smooth
    /// surface has this unit normal. None where nothing is known: there it is the scene's [`Ground`].
    fn at(&self, triangle: u32, weights: [f32; 3], normal: [f32; 3]) -> Option<Coat>;

    /// Whether rays go through any place of it. By default none does.
    fn has_openings(&self) -> bool {
        false
    }

    /// Whether a ray goes through a place, by the triangle and the weights of [`at`](Self::at). `chance` is evenly
    /// spread between 0 and 1: of what is half transparent, places with an opacity above it stop the ray.
    fn is_open(&self, _triangle: u32, _weights: [f32; 3], _chance: f32) -> bool {
        false
    }
}

impl fmt::Debug for dyn Finish + '_ {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Finish")
    }
}

/// What a place of the substrate looks like.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Coat {
    /// Share of the light that comes back, linear.
    pub albedo: [f32; 3],
    /// Unit normal for shading.
    pub normal: [f32; 3],
}

/// What is to be drawn. Parts that cannot be (not finite, no area) are left out.
#[derive(Clone, Copy)]
pub struct Scene<'a> {
    /// The substrate.
    pub stone: &'a Stone,
    /// The lichen as granules, in the same units.
    pub discs: &'a [Disc],
    /// The lichen as meshes, in the same units.
    pub skins: &'a [Painted<'a>],
    /// What the substrate is drawn as, where `finish` does not say it.
    pub ground: Ground,
    /// What the substrate looks like by itself, if it is to be drawn so.
    pub finish: Option<&'a dyn Finish>,
    /// The direction away from the floor; +y where it has no length.
    pub up: [f32; 3],
    /// Where it stands, if not on a stage of its own.
    pub stage: Option<Stage>,
}

impl std::fmt::Debug for Scene<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Scene").finish_non_exhaustive()
    }
}

impl<'a> Scene<'a> {
    /// A substrate without lichen, drawn as stone.
    pub fn bare(stone: &'a Stone, up: [f32; 3]) -> Self {
        Self {
            stone,
            discs: &[],
            skins: &[],
            ground: Ground::default(),
            finish: None,
            up,
            stage: None,
        }
    }
}
