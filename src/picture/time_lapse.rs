//! Pictures of a growing lichen from one place, of which only what has changed is taken anew.
//!
//! What came of each ray from the camera is kept, with the ways to the lights that were looked at for
//! it. It is the same in the next picture if none of these goes through the box of a triangle or granule
//! that has come, gone or changed since. So that nothing else changes, all pictures have one
//! [`Stage`](super::Stage).

use std::hash::Hasher;

use glam::{Vec3, Vec3A};
use obvhs::aabb::Aabb;
use rayon::prelude::*;
use rustc_hash::FxHasher;

use super::render::{Frame, finish};
use super::shade::{Rays, Seen, Studio};
use super::shape::{Dome, triangle_box};
use super::trace::{corners, sound_triangles};
use super::wide::{Boxes, Ray};
use super::{Camera, Disc, Image, Painted, Scene, Settings, World};

/// Rays of which something is kept, at most: half a gigabyte of them.
const MOST_KEPT: usize = 1 << 23;

/// Part of a ray's length by which it is taken for longer: what it met is at its very end.
const LONGER: f32 = 1e-5;

/// Takes pictures of one substrate, on one stage, from one camera.
pub struct TimeLapse<'a> {
    bare: Scene<'a>,
    camera: Camera,
    settings: Settings,
    kept: Vec<Kept>,
    /// The shapes of the lichen in the last picture.
    before: Vec<Shape>,
    /// How many rays from the camera the last picture took anew.
    taken: usize,
}

impl std::fmt::Debug for TimeLapse<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("TimeLapse").finish_non_exhaustive()
    }
}

impl<'a> TimeLapse<'a> {
    /// Begins with a scene without lichen, whose stage is that of all pictures.
    ///
    /// # Panics
    /// When the camera was moved to where numbers are not finite.
    pub fn new(bare: Scene<'a>, camera: Camera, settings: Settings) -> Self {
        camera.assert_finite();
        Self {
            bare,
            camera,
            settings,
            kept: Vec::new(),
            before: Vec::new(),
            taken: 0,
        }
    }

    /// The next picture: what [`render`](super::render()) makes of the scene with this lichen, but for rays that
    /// meet the very edge of a triangle. The same bytes for any number of threads.
    pub fn take(&mut self, discs: &[Disc], skins: &[Painted]) -> Image {
        let world = World::new(&Scene {
            discs,
            skins,
            ..self.bare
        });
        let shapes = shapes(discs, skins);
        let changes = Changes::between(&self.before, &shapes);
        self.before = shapes;
        let studio = Studio::new(&world, &self.camera, self.settings.background);
        let frame = Frame::new(&self.camera, &studio, &self.settings);
        let tiles = frame.tiles();
        if self.kept.is_empty() {
            let pixels: usize = frame.sides().map(|side| side as usize).iter().product();
            let most = MOST_KEPT / pixels;
            self.kept = tiles.iter().map(|_| Kept::new(most)).collect();
        }
        let picture = frame.of_lapse(&tiles, &mut self.kept, &changes);
        self.taken = self
            .kept
            .iter_mut()
            .map(|kept| std::mem::take(&mut kept.taken))
            .sum();
        let [width, height] = frame.sides();
        finish(&picture, width, height, self.settings.background)
    }

    /// How many rays from the camera the last picture took anew.
    pub fn taken(&self) -> usize {
        self.taken
    }
}

/// What came of a ray from the camera.
#[derive(Clone, Copy)]
struct Ended {
    light: Vec3,
    end: f32,
    from: Vec3,
    /// Of no length where there is none.
    to: [Vec3; 2],
    seen: Seen,
    around: Seen,
    is_structured: bool,
}

impl Ended {
    fn new((light, seen): (Vec3A, Seen), rays: &Rays, around: Seen) -> Self {
        Self {
            light: light.into(),
            end: rays.end,
            from: rays.from.into(),
            to: rays.to.map(Vec3::from),
            seen,
            around,
            is_structured: rays.is_structured,
        }
    }
}

/// What came of the rays through the pixels of a tile.
pub(super) struct Kept {
    pixels: Vec<Vec<Ended>>,
    /// Of how many rays of each pixel it is kept.
    most: usize,
    taken: usize,
}

impl Kept {
    fn new(most: usize) -> Self {
        Self {
            pixels: Vec::new(),
            most,
            taken: 0,
        }
    }

    /// Makes room for so many; of none where nothing is kept of any.
    pub(super) fn of_pixels(&mut self, count: usize) {
        if self.most > 0 {
            self.pixels.resize_with(count, Vec::new);
        }
    }

    /// What comes of a pixel's ray with this number, if it is known.
    #[inline]
    pub(super) fn known(
        &self,
        (pixel, number): (usize, u32),
        [eye, direction]: [Vec3A; 2],
        (around, changes): (Seen, &Changes),
    ) -> Option<(Vec3A, Seen)> {
        let ended = self.pixels.get(pixel)?.get(number as usize)?;
        let holds = ended.around == around && changes.leave(ended, eye, direction);
        holds.then(|| (ended.light.into(), ended.seen))
    }

    /// Keeps what came of one.
    pub(super) fn keep(
        &mut self,
        (pixel, number): (usize, u32),
        lit: (Vec3A, Seen),
        (around, rays): (Seen, &Rays),
    ) {
        self.taken += 1;
        let Some(known) = self.pixels.get_mut(pixel) else {
            return;
        };
        let ended = Ended::new(lit, rays, around);
        let number = number as usize;
        if number < known.len() {
            known[number] = ended;
        } else if number < self.most {
            // Of most pixels one or two are kept, for which a vector by itself makes room for four.
            if known.len() == known.capacity() {
                known.reserve_exact(known.len().max(1));
            }
            known.push(ended);
        }
    }

    /// Forgets rays that a pixel did not need this time: of them nobody asks what has changed.
    pub(super) fn forget_beyond(&mut self, pixel: usize, taken: u32) {
        if let Some(known) = self.pixels.get_mut(pixel) {
            known.truncate(taken as usize);
        }
    }
}

/// Where lichen has come, gone or changed between two pictures.
pub(super) struct Changes(Boxes);

impl Changes {
    fn between(before: &[Shape], now: &[Shape]) -> Self {
        Self(Boxes::new(&differing(before, now)))
    }

    /// Whether nothing of what decided over a ray has changed.
    fn leave(&self, ended: &Ended, eye: Vec3A, direction: Vec3A) -> bool {
        let crosses = |from: Vec3A, direction: Vec3A, end: f32| {
            let mut ray = Ray::new(from, direction);
            ray.end = end * (1.0 + LONGER);
            self.0.are_met(&ray)
        };
        let from = ended.from.into();
        let mut lights = ended.to.into_iter().filter(|to| *to != Vec3::ZERO);
        !ended.is_structured
            && !crosses(eye, direction, ended.end)
            && lights.all(|to| !crosses(from, to.into(), f32::INFINITY))
    }
}

/// A triangle or granule: a hash of all that it looks like, and its box.
#[derive(Clone, Copy)]
struct Shape {
    key: u64,
    bounds: [Vec3; 2],
}

impl Shape {
    fn new(key: u64, bounds: &Aabb) -> Self {
        Self {
            key,
            bounds: [bounds.min.into(), bounds.max.into()],
        }
    }
}

/// All of them, by their keys.
fn shapes(discs: &[Disc], skins: &[Painted]) -> Vec<Shape> {
    let granule = |disc: &Disc| {
        let [r, g, b] = disc.color.map(f32::from);
        let key = key([disc.center, disc.normal, [r, g, b], [disc.radius; 3]]);
        Some(Shape::new(key, &Dome::new(disc)?.bounds()))
    };
    let mut all: Vec<Shape> = discs.par_iter().filter_map(granule).collect();
    for skin in skins {
        let corner = |i: u32| {
            let i = i as usize;
            let color = skin.colors[i].map(f32::from);
            let is_structured = f32::from(u8::from(skin.structure.is_some()));
            let surface = [skin.grain, is_structured, 0.0];
            key([skin.positions[i], skin.normals[i], color, surface])
        };
        let triangle = |number: u32| {
            let triangle = skin.triangles[number as usize];
            let mut hasher = FxHasher::default();
            for i in triangle {
                hasher.write(&corner(i).to_le_bytes());
            }
            let shape = corners(skin.positions, triangle);
            Shape::new(hasher.finish(), &triangle_box(&shape))
        };
        let sound = sound_triangles(skin.positions, skin.triangles).into_par_iter();
        let known = sound.filter(|&i| skin.is_known(i));
        all.par_extend(known.map(triangle));
    }
    all.par_sort_unstable_by_key(|shape| shape.key);
    all
}

/// A hash of the bits of some numbers.
fn key(numbers: [[f32; 3]; 4]) -> u64 {
    let mut bytes = [0; 48];
    let numbers = numbers.as_flattened().iter();
    for (four, number) in bytes.chunks_exact_mut(4).zip(numbers) {
        four.copy_from_slice(&number.to_le_bytes());
    }
    let mut hasher = FxHasher::default();
    hasher.write(&bytes);
    hasher.finish()
}

/// The boxes of those that are in one of two lists, sorted by their keys, and not in the other.
fn differing(mut before: &[Shape], mut now: &[Shape]) -> Vec<Aabb> {
    let mut boxes = Vec::new();
    while let Some(least) = [before.first(), now.first()]
        .into_iter()
        .flatten()
        .map(|s| s.key)
        .min()
    {
        let first_of = |list: &mut &[Shape]| {
            let (first, rest) = list.split_first().filter(|(first, _)| first.key == least)?;
            *list = rest;
            Some(*first)
        };
        let firsts = [first_of(&mut before), first_of(&mut now)];
        if let [Some(shape), None] | [None, Some(shape)] = firsts {
            let [low, high] = shape.bounds.map(Vec3A::from);
            boxes.push(Aabb::new(low, high));
        }
    }
    boxes
}
