//! A picture of a substrate with lichen on it: pure functions from finished values to pixels.
//!
//! Rays are cast through a BVH of the triangles and another of the discs, drawn as matte domes.
//! The light is a studio's: a soft key light, the glow of a pale room, and a shadow on the floor.
//! Every random number is a hash of the pixel, so the bytes do not depend on the number of
//! threads. The picture is for looking at: no measurement should be taken from it.

mod camera;
mod color;
mod gif;
mod image;
mod render;
mod sample;
mod shade;
mod smooth;
mod stone;
mod trace;
mod view;

pub use camera::Camera;
pub use color::age_color;
pub use gif::GifWriter;
pub use image::Image;
pub use render::{Settings, render};
pub(crate) use stone::albedo as stone_albedo;

/// A round granule, drawn as a dome of height 0.6 × `radius` on the side of `normal`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Disc {
    /// Its middle, on the surface.
    pub center: [f32; 3],
    /// Outwards; any length but zero.
    pub normal: [f32; 3],
    /// In the units of `center`.
    pub radius: f32,
    /// sRGB.
    pub color: [u8; 3],
}

/// What is to be drawn. Parts that cannot be (not finite, no area, no such vertex) are left out.
#[derive(Clone, Copy, Debug)]
pub struct Scene<'a> {
    /// Positions, any unit.
    pub vertices: &'a [[f32; 3]],
    /// Numbers of vertices; either winding.
    pub triangles: &'a [[u32; 3]],
    /// The lichen, in the same units.
    pub discs: &'a [Disc],
    /// The direction away from the floor.
    pub up: [f32; 3],
}
