//! Choosing where to take the picture from.

use glam::{Vec2, Vec3A};
use rayon::prelude::*;

use super::Camera;
use super::camera::PORTRAIT;
use super::shape::Dome;
use super::trace::World;

/// Directions tried.
const TRIED: u32 = 96;

/// Discs, and triangles, looked at from each of them, at most.
const LOOKED_AT: usize = 3000;

/// The share of the picture that things may fill, across.
const FILLED: f32 = 0.84;

/// Where lichen alone would fill less than this share of the whole view, go nearer.
const SMALL: f32 = 0.45;

/// Of a view of everything, the least height in sizes of the scene: leaves the floor its shadow.
const WHOLE: f32 = 0.66;

/// Radii of a granule from it, at least: skins are up to so thick.
const NEAREST: f32 = 10.0;

/// One place of the lichen, or of the substrate where there is none.
struct Patch {
    place: Vec3A,
    normal: Vec3A,
    area: f32,
    clear: f32,
}

impl Camera {
    /// A camera that sees the lichen well, for pictures of this width over height: from the
    /// direction, upper ones preferred, in which most of it shows; of the whole substrate where
    /// lichen covers a good share of that view, otherwise nearer, with some of what is around it.
    ///
    /// # Panics
    /// When the width over height is not between a millionth and a million.
    pub fn best_view(world: &World, aspect: f32) -> Self {
        check_aspect(aspect);
        let patches = patches(world);
        let score = |i: u32| {
            let d = direction(i, world.up);
            (score(world, &patches, d), d)
        };
        let scored: Vec<(f32, Vec3A)> = (0..TRIED).into_par_iter().map(score).collect();
        let first = (0.0, direction(TRIED / 3, world.up));
        let best = |a: (f32, Vec3A), b: &(f32, Vec3A)| if b.0 > a.0 { *b } else { a };
        let (_, towards) = scored.iter().fold(first, best);
        frame(world, &patches, towards, aspect)
    }

    /// A camera that looks from this side, framed as [`Camera::best_view`] does.
    ///
    /// The azimuth goes round `up` counter-clockwise as seen from above, from the front: from +z
    /// where y is up and from −y where z is up, so that 90° is from +x. The elevation is the angle
    /// above the horizon. Both are in degrees. From straight above and below, the front is at the
    /// picture's bottom and at its top.
    ///
    /// # Panics
    /// When the width over height is not between a millionth and a million, or an angle not finite.
    pub fn from_side(world: &World, aspect: f32, azimuth: f32, elevation: f32) -> Self {
        check_aspect(aspect);
        assert!(
            azimuth.is_finite() && elevation.is_finite(),
            "a camera at {azimuth}°, {elevation}°"
        );
        let front = front(world.up);
        let right = world.up.cross(front);
        let (sin, cos) = libm::sincosf(azimuth.to_radians());
        let level = front * cos + right * sin;
        let (rise, run) = libm::sincosf(elevation.clamp(-90.0, 90.0).to_radians());
        let towards = world.up * rise + level * run;
        let above = world.up * run - level * rise;
        frame_with(world, &patches(world), towards, above, aspect)
    }
}

fn check_aspect(aspect: f32) {
    assert!(
        (1e-6..=1e6).contains(&aspect),
        "pictures {aspect} times as wide as high"
    );
}

/// What a camera shows of granules.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sight {
    /// At least one.
    Seen,
    /// None: the substrate hides those that are in its way.
    Hidden,
    /// None: it looks past all of them.
    Past,
}

impl Camera {
    /// What pictures of this width over height show of a world's granules.
    pub fn sight(&self, world: &World, aspect: f32) -> Sight {
        let domes = world.domes().iter();
        let mut inside = domes
            .filter(|dome| self.frames(dome.center().into(), aspect).is_some())
            .peekable();
        if inside.peek().is_none() {
            return Sight::Past;
        }
        match inside.any(|dome| self.meets(dome, world)) {
            true => Sight::Seen,
            false => Sight::Hidden,
        }
    }

    /// This camera brought nearer to granules that it sees, so that they are about `factor` times as large, for
    /// pictures of this width over height: to one that has as many others about it as any, or nearly, and of these to
    /// the one nearest to the middle of what it sees. It stays on this side of the substrate, and ten radii above the
    /// granule. None where it sees none.
    ///
    /// # Panics
    /// When the factor is not above 0.
    pub fn nearer(&self, world: &World, aspect: f32, factor: f32) -> Option<Self> {
        assert!(factor > 0.0, "{factor} times as near");
        let target = self.crowded(world, aspect, 0.35 / factor)?;
        let center = target.center();
        let depth = self.depth(center.into());
        let slant = target.normal().dot(-self.forward).max(0.1);
        let factor = factor
            .min(depth * slant / (NEAREST * target.radius))
            .max(1.0);
        let centred = self
            .zoomed(depth, factor)
            .centred(center.into(), aspect, 0.0);
        let on_the_way = Self {
            eye: center + (self.eye - center) / factor,
            ..*self
        };
        Some(match centred.meets(target, world) {
            true => centred,
            false => on_the_way,
        })
    }

    /// Of the granules that it sees one with others about it, as far away as this share of the picture. On a side that
    /// is turned away they lie closer together in the picture, and count for less.
    fn crowded<'w>(&self, world: &'w World, aspect: f32, share: f32) -> Option<&'w Dome> {
        let seen_of = |step: usize| {
            let some = world.domes().par_iter().step_by(step);
            let seen = some.filter_map(|dome| {
                let place = self.frames(dome.center().into(), aspect)?;
                self.meets(dome, world).then_some((place.into(), dome))
            });
            seen.collect::<Vec<(Vec2, &Dome)>>()
        };
        let mut seen = seen_of(world.domes().len() / LOOKED_AT + 1);
        if seen.is_empty() {
            seen = seen_of(1);
            seen.truncate(LOOKED_AT);
        }
        let shown = |dome: &Dome| {
            let towards = (self.eye - dome.center()).normalize_or_zero();
            dome.normal().dot(towards).max(0.0)
        };
        let about = |place: Vec2| {
            let is_near = |other: &Vec2| (*other - place).abs().max_element() < share;
            let near = seen.iter().filter(|(other, _)| is_near(other));
            near.map(|(_, dome)| shown(dome)).sum::<f32>()
        };
        let counts: Vec<f32> = seen.par_iter().map(|(place, _)| about(*place)).collect();
        let enough = 0.95 * counts.iter().copied().reduce(f32::max)?;
        let middle = seen.iter().map(|(place, _)| *place).sum::<Vec2>() / seen.len() as f32;
        let crowded = seen
            .iter()
            .zip(counts)
            .filter(|&(_, count)| count >= enough);
        let off = |(place, _): &(Vec2, &Dome)| place.distance_squared(middle);
        let nearest = crowded.min_by(|(a, _), (b, _)| off(a).total_cmp(&off(b)));
        nearest.map(|((_, dome), _)| *dome)
    }

    /// Whether no substrate is before a granule.
    fn meets(&self, dome: &Dome, world: &World) -> bool {
        let clear = clear_of(dome, world);
        !world.is_between(dome.center() + dome.normal() * clear, self.eye)
    }
}

/// How far above a granule's foot a ray is clear of the substrate.
fn clear_of(dome: &Dome, world: &World) -> f32 {
    (0.3 * dome.radius).max(1e-4 * world.size)
}

/// Directions spread evenly about `up` (a Fibonacci sphere), from 60° above to 50° below.
fn direction(i: u32, up: Vec3A) -> Vec3A {
    const GOLDEN: f32 = 2.399_963_2;
    let rise = 0.87 - 1.64 * i as f32 / TRIED as f32;
    let flat = (1.0 - rise * rise).sqrt();
    let (a, b) = up.any_orthonormal_pair();
    let turn = GOLDEN * i as f32;
    up * rise + (a * libm::cosf(turn) + b * libm::sinf(turn)) * flat
}

fn patches(world: &World) -> Vec<Patch> {
    let step = world.domes().len() / LOOKED_AT + 1;
    let granules = world.domes().iter().step_by(step).map(|d| Patch {
        place: d.center(),
        normal: d.normal(),
        area: d.radius * d.radius,
        clear: clear_of(d, world),
    });
    let skins = world.some_skin(LOOKED_AT);
    let triangles = skins.map(|(place, normal, area)| Patch {
        place,
        normal,
        area,
        clear: 1e-5 * world.size,
    });
    granules.chain(triangles).collect()
}

fn score(world: &World, patches: &[Patch], towards: Vec3A) -> f32 {
    let rise = towards.dot(world.up);
    let liking = 1.0 - 0.5 * (0.45 - rise).max(0.0) - 0.25 * (rise - 0.7).max(0.0);
    let seen: f32 = patches
        .iter()
        .filter(|p| p.is_seen(world, towards))
        .map(|p| p.area * p.normal.dot(towards))
        .sum();
    seen * liking
}

impl Patch {
    fn is_seen(&self, world: &World, towards: Vec3A) -> bool {
        self.normal.dot(towards) > 0.05
            && !world.is_behind(self.place + self.normal * self.clear, towards)
    }
}

/// The side that programs call the front.
fn front(up: Vec3A) -> Vec3A {
    let side = match up.y.abs() < 0.9 {
        true => Vec3A::NEG_Y,
        false => Vec3A::Z,
    };
    (side - up * side.dot(up)).normalize_or_zero()
}

fn frame(world: &World, patches: &[Patch], towards: Vec3A, aspect: f32) -> Camera {
    frame_with(world, patches, towards, world.up, aspect)
}

fn frame_with(
    world: &World,
    patches: &[Patch],
    towards: Vec3A,
    above: Vec3A,
    aspect: f32,
) -> Camera {
    let camera = Camera::along(Vec3A::ZERO, -towards, above, PORTRAIT);
    let everything = world
        .some_corners(20_000)
        .chain(patches.iter().map(|p| p.place));
    let (whole, whole_depth) = fit(&camera, everything, aspect, WHOLE * world.size);
    let seen: Vec<&Patch> = patches
        .iter()
        .filter(|p| p.is_seen(world, towards))
        .collect();
    let least = seen.iter().map(|p| p.area.sqrt()).fold(0.0, f32::max) * 16.0;
    let (close, close_depth) = fit(&camera, seen.iter().map(|p| p.place), aspect, least);
    let eye = if seen.is_empty() || close_depth > SMALL * whole_depth {
        whole
    } else {
        let depth = close_depth / SMALL.sqrt();
        close + towards * (depth.min(whole_depth) - close_depth)
    };
    Camera { eye, ..camera }
}

/// The nearest eye from which all of the points are in the picture, and how far it is from their
/// middle; no nearer than would show a sphere of diameter `least`.
fn fit(
    camera: &Camera,
    points: impl Iterator<Item = Vec3A>,
    aspect: f32,
    least: f32,
) -> (Vec3A, f32) {
    let open = [camera.half_height * aspect, camera.half_height].map(|t| t * FILLED);
    let mut most = [[f32::NEG_INFINITY; 2]; 3];
    for p in points {
        let z = p.dot(camera.forward);
        for (k, axis) in [camera.right, camera.above].into_iter().enumerate() {
            let x = p.dot(axis);
            most[k][0] = most[k][0].max(x - z * open[k]);
            most[k][1] = most[k][1].max(-x - z * open[k]);
        }
        most[2] = [most[2][0].max(z), most[2][1].max(-z)];
    }
    if most[2][0] == f32::NEG_INFINITY {
        most = [[0.0; 2]; 3];
    }
    let [x, y] = [0, 1].map(|k| 0.5 * (most[k][0] - most[k][1]));
    let fitted = |k: usize| -0.5 * (most[k][0] + most[k][1]) / open[k];
    let middle = 0.5 * (most[2][0] - most[2][1]);
    let z = fitted(0).min(fitted(1)).min(middle - 0.5 * least / open[1]);
    let eye = camera.right * x + camera.above * y + camera.forward * z;
    (eye, middle - z)
}
