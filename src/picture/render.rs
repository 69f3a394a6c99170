//! From a scene and a camera to pixels.

use glam::{Vec2, Vec3A};
use rayon::prelude::*;

use super::sample::Sampler;
use super::shade::Studio;
use super::trace::World;
use super::{Camera, Image, Scene, color};

/// How large and how fine a picture is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Settings {
    /// Pixels in a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Rays through each pixel, at most: where the first few agree, they are enough.
    pub samples: u32,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            width: 1280,
            height: 960,
            samples: 16,
        }
    }
}

const WITHIN_PIXEL: u32 = 0;

/// After this many samples that differ by less than the share `ALIKE`, a pixel is done.
const ENOUGH: u32 = 4;
const ALIKE: f32 = 0.1;

/// Takes the picture; the same bytes for any number of threads. Zeros in the settings count as 1.
pub fn render(scene: &Scene, camera: &Camera, settings: &Settings) -> Image {
    let world = World::new(scene);
    let studio = Studio::new(&world, camera);
    let (width, height) = (settings.width.max(1), settings.height.max(1));
    let frame = Frame {
        camera,
        studio: &studio,
        size: Vec2::new(width as f32, height as f32),
        samples: settings.samples.max(1),
    };
    let mut rgb = vec![0; 3 * width as usize * height as usize];
    rgb.par_chunks_mut(3 * width as usize)
        .enumerate()
        .for_each(|(y, row)| {
            for (x, pixel) in row.chunks_exact_mut(3).enumerate() {
                pixel.copy_from_slice(&frame.pixel(x as u32, y as u32));
            }
        });
    Image { width, height, rgb }
}

struct Frame<'a> {
    camera: &'a Camera,
    studio: &'a Studio<'a>,
    size: Vec2,
    samples: u32,
}

impl Frame<'_> {
    fn pixel(&self, x: u32, y: u32) -> [u8; 3] {
        let sampler = Sampler::new(x, y, self.samples);
        let corner = Vec2::new(x as f32, y as f32);
        let aspect = self.size.x / self.size.y;
        let (mut sum, mut least, mut most) = (Vec3A::ZERO, Vec3A::INFINITY, Vec3A::ZERO);
        let mut taken = 0;
        while taken < self.samples {
            let place = (corner + sampler.point(taken, WITHIN_PIXEL)) / self.size;
            let direction = self.camera.direction(place, aspect);
            let eye = self.camera.eye;
            let light = self
                .studio
                .light(eye, direction, &sampler, taken, place.into());
            (sum, least, most) = (sum + light, least.min(light), most.max(light));
            taken += 1;
            if taken == ENOUGH && (most - least).max_element() < ALIKE * most.max_element() {
                break;
            }
        }
        color::to_pixel(sum / taken as f32, sampler.dither())
    }
}
