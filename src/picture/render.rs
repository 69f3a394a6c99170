//! From a scene and a camera to pixels.

use glam::{Vec2, Vec3A};
use rayon::prelude::*;

use super::sample::Sampler;
use super::shade::{Met, Studio};
use super::trace::World;
use super::{Camera, Image, Scene, color};

/// What is behind the things of a picture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Background {
    /// A pale sheet with a shadow on it.
    #[default]
    Studio,
    /// This sRGB colour, to the byte, without floor or shadow.
    Color([u8; 3]),
    /// Nothing: the picture has an [alpha](Image::alpha) channel.
    Transparent,
}

/// How large and how fine a picture is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Settings {
    /// Pixels in a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Rays through each pixel, at most: where the first few agree, they are enough.
    pub samples: u32,
    /// Behind everything.
    pub background: Background,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            width: 1280,
            height: 960,
            samples: 16,
            background: Background::Studio,
        }
    }
}

const WITHIN_PIXEL: u32 = 0;

/// Samples are taken by this many. A pixel is done when the standard error of its mean, were they
/// independent, is below a share of it: `ERROR` where as many as `USUAL` may be taken, half of it
/// for four times as many.
const BATCH: u32 = 4;
const ERROR: f32 = 0.1;
const USUAL: f32 = 24.0;

/// The sheet has no grain to hide an error behind, and is soon done.
const LEAST_ON_SHEET: u32 = 12;

/// Takes the picture; the same bytes for any number of threads. Zeros in the settings count as 1.
pub fn render(scene: &Scene, camera: &Camera, settings: &Settings) -> Image {
    let world = World::new(scene);
    let studio = Studio::new(&world, camera, settings.background);
    let (width, height) = (settings.width.max(1), settings.height.max(1));
    let frame = Frame {
        camera,
        studio: &studio,
        size: Vec2::new(width as f32, height as f32),
        samples: settings.samples.max(1),
        error: ERROR * (USUAL / settings.samples.max(1) as f32).sqrt(),
    };
    let (columns, rows) = (width as usize, height as usize);
    let mut pixels = vec![Pixel::default(); columns * rows];
    let lines = pixels.par_chunks_mut(columns).enumerate();
    lines.for_each(|(y, row)| {
        for (x, pixel) in row.iter_mut().enumerate() {
            *pixel = frame.pixel(x as u32, y as u32);
        }
    });
    finish(&pixels, width, height, settings.background)
}

/// The colour of what is there, and how much of the pixel that covers.
#[derive(Clone, Copy, Default)]
struct Pixel {
    rgb: [u8; 3],
    covered: u8,
}

fn finish(pixels: &[Pixel], width: u32, height: u32, background: Background) -> Image {
    let on = |p: &Pixel| match background {
        Background::Color(behind) => [0, 1, 2].map(|k| mix(behind[k], p.rgb[k], p.covered)),
        _ => p.rgb,
    };
    let is_transparent = background == Background::Transparent;
    Image {
        width,
        height,
        rgb: pixels.iter().flat_map(on).collect(),
        alpha: is_transparent.then(|| pixels.iter().map(|p| p.covered).collect()),
    }
}

fn mix(behind: u8, front: u8, covered: u8) -> u8 {
    let [b, f, c] = [behind, front, covered].map(u32::from);
    ((b * (255 - c) + f * c + 127) / 255) as u8
}

struct Frame<'a> {
    camera: &'a Camera,
    studio: &'a Studio<'a>,
    size: Vec2,
    samples: u32,
    /// Share of the light that a pixel may be wrong by.
    error: f32,
}

impl Frame<'_> {
    fn pixel(&self, x: u32, y: u32) -> Pixel {
        let sampler = Sampler::new(x, y, self.samples);
        let corner = Vec2::new(x as f32, y as f32);
        let aspect = self.size.x / self.size.y;
        let mut sums = Sums::default();
        while sums.taken < self.samples && !sums.is_enough(self.error) {
            let i = sums.taken;
            let place = (corner + sampler.point(i, WITHIN_PIXEL)) / self.size;
            let direction = self.camera.direction(place, aspect);
            let eye = self.camera.eye;
            let (light, met) = self.studio.light(eye, direction, &sampler, i, place.into());
            sums.add(light, met);
        }
        sums.pixel(sampler.dither())
    }
}

/// What the samples of a pixel came to.
#[derive(Default)]
struct Sums {
    taken: u32,
    /// How many met something.
    met: u32,
    on_sheet: bool,
    /// Nothing being black.
    light: Vec3A,
    light_sq: Vec3A,
}

impl Sums {
    fn add(&mut self, light: Vec3A, met: Met) {
        self.taken += 1;
        self.met += u32::from(met != Met::Nothing);
        self.on_sheet |= met == Met::Sheet;
        self.light += light;
        self.light_sq += light * light;
    }

    fn is_enough(&self, error: f32) -> bool {
        let least = if self.on_sheet { LEAST_ON_SHEET } else { BATCH };
        if self.taken < least || !self.taken.is_multiple_of(BATCH) {
            return false;
        }
        let n = self.taken as f32;
        let scatter = (self.light_sq - self.light * self.light / n).max_element() / (n - 1.0);
        (scatter.max(0.0) / n).sqrt() <= error * self.light.max_element() / n
    }

    fn pixel(&self, dither: f32) -> Pixel {
        let light = self.light / self.met.max(1) as f32;
        Pixel {
            rgb: color::to_pixel(light, dither),
            covered: (255 * self.met / self.taken) as u8,
        }
    }
}
