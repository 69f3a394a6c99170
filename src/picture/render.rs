//! From a scene and a camera to pixels.

use std::ops::Range;

use glam::{Vec2, Vec3A};
use rayon::prelude::*;

use super::sample::Sampler;
use super::shade::{Asked, Rays, Seen, Studio};
use super::time_lapse::{Changes, Kept};
use super::trace::World;
use super::{Camera, Image, color};

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
    /// Rays through each pixel, at most: where the first few agree, they are enough. 0 counts as 1, and more than a
    /// million (2^20) as that.
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

/// Columns and rows of a part of the picture.
pub(super) type Tile = [Range<usize>; 2];

/// Pixels along a tile's side: what is about those of one fits into a processor's own memory.
const TILE: usize = 64;

/// Samples of every pixel, before it is decided where more are needed: the least, and the share
/// of the most.
const PILOT: u32 = 1;
const PILOT_SHARE: u32 = 8;

/// Nobody waits for more, and numbers of them are added up in 32 bits.
const MOST_SAMPLES: u32 = 1 << 20;

/// Pixels to each side that are looked at for that.
const REACH: usize = 2;

const WITHIN_PIXEL: u32 = 0;

/// Samples are taken by this many. A pixel is done when the standard error of its mean, were they
/// independent, is below a share of it: `ERROR` where as many as `USUAL` may be taken, half of it
/// for four times as many.
const BATCH: u32 = 4;
const ERROR: f32 = 0.1;
const USUAL: f32 = 24.0;

/// Where light and shade are even all about, only the grain of things is left to be sampled.
const LEAST_EVEN: u32 = 2;

/// The sheet has no grain to hide an error behind, and is soon done.
const LEAST_ON_SHEET: u32 = 12;

/// Takes the picture; the same bytes for any number of threads. Zeros in the settings count as 1.
///
/// # Panics
/// When the camera was moved to where numbers are not finite.
pub fn render(world: &World, camera: &Camera, settings: &Settings) -> Image {
    render_unless(world, camera, settings, &|| false).unwrap_or_default()
}

/// Takes the picture as [`render`] does, unless it is told to stop before all of it is taken: then there is none.
///
/// # Panics
/// As [`render`].
pub fn render_unless(
    world: &World,
    camera: &Camera,
    settings: &Settings,
    stopped: &(dyn Fn() -> bool + Sync),
) -> Option<Image> {
    let studio = Studio::new(world, camera, settings.background);
    let frame = Frame::new(camera, &studio, settings);
    let pixels = frame.pixels(TILE, stopped)?;
    let [width, height] = frame.sides();
    Some(finish(&pixels, width, height, settings.background))
}

/// The colour of what is there, and how much of the pixel that covers.
#[derive(Clone, Copy, Default, PartialEq)]
pub(super) struct Pixel {
    rgb: [u8; 3],
    covered: u8,
}

pub(super) fn finish(pixels: &[Pixel], width: u32, height: u32, background: Background) -> Image {
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

pub(super) struct Frame<'a> {
    camera: &'a Camera,
    studio: &'a Studio<'a>,
    size: Vec2,
    samples: u32,
    /// Those that are taken of every pixel.
    pilot: u32,
    /// Share of the light that a pixel may be wrong by.
    error: f32,
}

impl<'a> Frame<'a> {
    pub(super) fn new(camera: &'a Camera, studio: &'a Studio<'a>, settings: &Settings) -> Self {
        camera.assert_finite();
        let [width, height] = [settings.width, settings.height].map(|side| side.max(1));
        let samples = settings.samples.clamp(1, MOST_SAMPLES);
        Self {
            camera,
            studio,
            size: Vec2::new(width as f32, height as f32),
            samples,
            pilot: (samples / PILOT_SHARE).max(PILOT),
            error: ERROR * (USUAL / samples as f32).sqrt(),
        }
    }

    pub(super) fn sides(&self) -> [u32; 2] {
        self.size.to_array().map(|side| side as u32)
    }

    /// All of them, row by row, rendered in tiles of this side. None if told to stop.
    fn pixels(&self, side: usize, stopped: &(dyn Fn() -> bool + Sync)) -> Option<Vec<Pixel>> {
        let tiles = self.tiles_of(side);
        let filled = tiles
            .par_iter()
            .map(|tile| (!stopped()).then(|| self.filled(tile, None)));
        let filled: Vec<Vec<Pixel>> = filled.collect::<Option<_>>()?;
        Some(self.joined(&tiles, filled))
    }

    /// The same with what is kept of each tile since the picture before.
    pub(super) fn of_lapse(
        &self,
        tiles: &[Tile],
        kept: &mut [Kept],
        changes: &Changes,
    ) -> Vec<Pixel> {
        let filled = tiles.par_iter().zip(kept);
        let filled = filled.map(|(tile, kept)| self.filled(tile, Some((kept, changes))));
        self.joined(tiles, filled.collect())
    }

    pub(super) fn tiles(&self) -> Vec<Tile> {
        self.tiles_of(TILE)
    }

    fn tiles_of(&self, side: usize) -> Vec<Tile> {
        let [columns, rows] = self.sides().map(|side| side as usize);
        let starts = (0..rows).step_by(side);
        let starts = starts.flat_map(|y| (0..columns).step_by(side).map(move |x| (x, y)));
        starts
            .map(|(x, y)| [x..(x + side).min(columns), y..(y + side).min(rows)])
            .collect()
    }

    fn joined(&self, tiles: &[Tile], filled: Vec<Vec<Pixel>>) -> Vec<Pixel> {
        let [columns, rows] = self.sides().map(|side| side as usize);
        let mut pixels = vec![Pixel::default(); columns * rows];
        for ([across, down], filled) in tiles.iter().zip(filled) {
            for (y, row) in down.clone().zip(filled.chunks(across.len())) {
                pixels[y * columns..][across.clone()].copy_from_slice(row);
            }
        }
        pixels
    }

    /// The pixels of a tile, row by row: a few samples of each, and more as what is seen round about
    /// asks for them. A pixel's own samples alone would tell too little, and to stop
    /// where they happen to agree would favour what they agree on.
    fn filled(&self, [across, down]: &Tile, lapse: Option<(&mut Kept, &Changes)>) -> Vec<Pixel> {
        let wider = |range: &Range<usize>, end: f32| {
            range.start.saturating_sub(REACH)..(range.end + REACH).min(end as usize)
        };
        let (columns, rows) = (wider(across, self.size.x), wider(down, self.size.y));
        let at = |i: usize| {
            let (x, y) = (i % columns.len(), i / columns.len());
            ((columns.start + x) as u32, (rows.start + y) as u32)
        };
        let mut sums = vec![Sums::default(); columns.len() * rows.len()];
        let mut taking = Taking { frame: self, lapse };
        taking.begin(sums.len());
        for (i, sums) in sums.iter_mut().enumerate() {
            taking.sample((i, at(i)), self.pilot, Seen::default(), sums);
        }
        let squares = Squares::new(&sums, columns.len());
        let place = |y: usize, x: usize| (y - rows.start) * columns.len() + x - columns.start;
        let places = down
            .clone()
            .flat_map(|y| across.clone().map(move |x| (y, x)));
        let mut pixel = |i: usize| taking.pixel((i, at(i)), &sums[i], &squares.at(i));
        places.map(|(y, x)| pixel(place(y, x))).collect()
    }
}

/// How the pixels of one tile are taken.
struct Taking<'a> {
    frame: &'a Frame<'a>,
    /// What is kept of the picture before, and what has changed since.
    lapse: Option<(&'a mut Kept, &'a Changes)>,
}

/// A pixel by its number in the tile, and where it is in the picture.
type Place = (usize, (u32, u32));

impl Taking<'_> {
    fn begin(&mut self, pixels: usize) {
        if let Some((kept, _)) = &mut self.lapse {
            kept.of_pixels(pixels);
        }
    }

    /// A pixel that some samples were taken of, by what they came to and what those of the square
    /// about it did. Where nothing falls on the sheet the square is enough; in its shadows the
    /// squares would show as blotches. Where light and shade are even, how things scatter in the square
    /// tells how many samples are enough.
    fn pixel(&mut self, at: Place, sums: &Sums, square: &Sums) -> Pixel {
        let (x, y) = at.1;
        let dither = Sampler::new(x, y, self.frame.samples).dither();
        let is_bare = square.seen.is_only(Seen::SHEET) && square.seen.is_even();
        if is_bare || square.seen.is_only(Seen::NOTHING) {
            self.end(at, sums.taken);
            return square.pixel(dither);
        }
        let mut sums = sums.clone();
        self.complete(at, &mut sums, square);
        self.end(at, sums.taken);
        sums.pixel(dither)
    }

    /// Takes as many samples of a pixel as are enough.
    fn complete(&mut self, at: Place, sums: &mut Sums, square: &Sums) {
        let (most, error) = (self.frame.samples, self.frame.error);
        let is_even = square.seen.is_only(Seen::THING) && square.seen.is_even();
        while sums.taken < most {
            let is_enough = if is_even {
                sums.taken >= LEAST_EVEN && square.is_enough(sums.taken, error)
            } else {
                sums.is_enough_alone(error)
            };
            if is_enough {
                break;
            }
            let batch = if is_even { LEAST_EVEN } else { BATCH };
            let next = (sums.taken / batch + 1) * batch;
            self.sample(at, next.min(most), square.seen, sums);
        }
    }

    fn end(&mut self, (pixel, _): Place, taken: u32) {
        if let Some((kept, _)) = &mut self.lapse {
            kept.forget_beyond(pixel, taken);
        }
    }

    /// Takes samples of a pixel until there are so many.
    fn sample(&mut self, (pixel, (x, y)): Place, until: u32, around: Seen, sums: &mut Sums) {
        let Frame {
            camera,
            studio,
            size,
            samples,
            ..
        } = self.frame;
        let sampler = Sampler::new(x, y, *samples);
        let corner = Vec2::new(x as f32, y as f32);
        for number in sums.taken..until {
            let place = (corner + sampler.point(number, WITHIN_PIXEL)) / *size;
            let asked = Asked {
                direction: camera.direction(place, size.x / size.y),
                place: place.into(),
                sampler: &sampler,
                number,
                around,
            };
            let known = self.lapse.as_ref().and_then(|(kept, changes)| {
                let ray = [camera.eye, asked.direction];
                kept.known((pixel, number), ray, (around, changes))
            });
            let (light, seen) = known.unwrap_or_else(|| {
                let mut rays = Rays::default();
                let lit = studio.light(camera.eye, &asked, &mut rays);
                if let Some((kept, _)) = &mut self.lapse {
                    kept.keep((pixel, number), lit, (around, &rays));
                }
                lit
            });
            sums.add(light, seen);
        }
    }
}

/// What the samples in the square about each pixel of some rows came to.
struct Squares {
    /// Over the columns of each square.
    across: Vec<Sums>,
    columns: usize,
}

impl Squares {
    fn new(sums: &[Sums], columns: usize) -> Self {
        let rows = sums.chunks(columns);
        let of = |row: &[Sums], x| Sums::of(&row[near(x, columns)]);
        let across = rows.flat_map(|row| (0..columns).map(move |x| of(row, x)));
        Self {
            across: across.collect(),
            columns,
        }
    }

    fn at(&self, pixel: usize) -> Sums {
        let rows = near(pixel / self.columns, self.across.len() / self.columns);
        Sums::of(rows.map(|y| &self.across[y * self.columns + pixel % self.columns]))
    }
}

/// The places at most so far from one of so many.
fn near(at: usize, of: usize) -> Range<usize> {
    at.saturating_sub(REACH)..(at + REACH + 1).min(of)
}

/// What the samples of a pixel came to.
#[derive(Clone, Default)]
struct Sums {
    taken: u32,
    /// How many met something.
    met: u32,
    seen: Seen,
    /// Nothing being black.
    light: Vec3A,
    light_sq: Vec3A,
}

impl Sums {
    /// Together.
    fn of<'a>(some: impl IntoIterator<Item = &'a Self>) -> Self {
        let add = |a: Self, b: &Self| Self {
            taken: a.taken + b.taken,
            met: a.met + b.met,
            seen: a.seen.and(b.seen),
            light: a.light + b.light,
            light_sq: a.light_sq + b.light_sq,
        };
        some.into_iter().fold(Self::default(), add)
    }

    fn add(&mut self, light: Vec3A, seen: Seen) {
        self.taken += 1;
        self.met += u32::from(!seen.has(Seen::NOTHING));
        self.seen = self.seen.and(seen);
        self.light += light;
        self.light_sq += light * light;
    }

    fn is_enough_alone(&self, error: f32) -> bool {
        let least = if self.seen.has(Seen::SHEET) {
            LEAST_ON_SHEET
        } else {
            BATCH
        };
        let may_be = self.taken >= least && self.taken.is_multiple_of(BATCH);
        may_be && self.is_enough(self.taken, error)
    }

    /// Whether the mean of so many samples that scatter as these do is known well enough.
    fn is_enough(&self, taken: u32, error: f32) -> bool {
        let n = self.taken as f32;
        let scatter = (self.light_sq - self.light * self.light / n).max_element() / (n - 1.0);
        (scatter.max(0.0) / taken as f32).sqrt() <= error * self.light.max_element() / n
    }

    fn pixel(&self, dither: f32) -> Pixel {
        let light = self.light / self.met.max(1) as f32;
        Pixel {
            rgb: color::to_pixel(light, dither),
            covered: (255 * self.met / self.taken) as u8,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::picture::{Disc, Scene, Stone};

    /// However many pixels are rendered together, they are the same.
    #[test]
    fn where_tiles_begin_does_not_show() {
        let disc = |center| Disc {
            center,
            normal: [0.0, 1.0, 0.0],
            radius: 0.4,
            color: [200, 120, 40],
        };
        let discs = [disc([0.0; 3]), disc([0.5, 0.2, 0.1])];
        let stone = Stone::new(&[], &[]);
        let world = World::new(&Scene {
            discs: &discs,
            ..Scene::bare(&stone, [0.0; 3])
        });
        let camera = Camera::best_view(&world, 1.0);
        let studio = Studio::new(&world, &camera, Background::Studio);
        let settings = Settings {
            width: 40,
            height: 40,
            samples: 16,
            ..Settings::default()
        };
        let frame = Frame::new(&camera, &studio, &settings);
        let pixels = |side| frame.pixels(side, &|| false).expect("not stopped");
        let whole = pixels(40);
        assert!(whole.iter().any(|p| p.rgb != whole[0].rgb));
        for side in [1, 2, 7, 32] {
            assert!(pixels(side) == whole, "{side}");
        }
        assert!(frame.pixels(7, &|| true).is_none());
    }
}
