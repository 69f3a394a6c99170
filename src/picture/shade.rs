//! The light of the studio.

use glam::Vec3A;

use super::sample::{Sampler, cone_about, cosine_about};
use super::trace::{Hit, World};
use super::{Camera, stone};

const KEY: Vec3A = Vec3A::new(1.20, 1.15, 1.07);
const ROOM: Vec3A = Vec3A::new(0.46, 0.475, 0.50);
const FILL: Vec3A = Vec3A::new(0.11, 0.115, 0.125);

/// Tangent of half the angle that the key light fills: a large soft box.
const SOFT: f32 = 0.16;

/// The floor's middle and rim, linear light.
const BACKDROP: [Vec3A; 2] = [
    Vec3A::new(0.745, 0.735, 0.715),
    Vec3A::new(0.43, 0.42, 0.405),
];

/// Lights, and the floor that takes the shadow.
pub(super) struct Studio<'a> {
    world: &'a World,
    key: Vec3A,
    fill: Vec3A,
    /// Height of the floor along `up`.
    floor: f32,
    middle: Vec3A,
}

/// Which purpose takes which sequence of sample points.
const TO_KEY: u32 = 1;
const TO_ROOM: u32 = 2;

impl<'a> Studio<'a> {
    /// Lights placed about the camera: the key to its upper left, a weak fill to its right.
    pub(super) fn new(world: &'a World, camera: &Camera) -> Self {
        let back = -(camera.forward - world.up * camera.forward.dot(world.up)).normalize_or_zero();
        let key = world.up * 0.85 + camera.above * 0.25 - camera.right * 0.95 + back * 0.55;
        let fill = camera.right * 0.8 + world.up * 0.2 + back * 0.6;
        let middle = 0.5 * (world.bounds[0] + world.bounds[1]);
        let floor = world
            .some_corners(usize::MAX - 1)
            .chain(world.domes.iter().map(|d| d.center))
            .map(|p| p.dot(world.up))
            .fold(f32::INFINITY, f32::min);
        Self {
            world,
            key: key.normalize_or(Vec3A::Y),
            fill: fill.normalize_or(Vec3A::Y),
            floor: floor - 2e-3 * world.size,
            middle,
        }
    }

    /// Light that comes back along sample `i` of a pixel; `place` is in the picture, 0 to 1.
    pub(super) fn light(
        &self,
        origin: Vec3A,
        direction: Vec3A,
        s: &Sampler,
        i: u32,
        place: [f32; 2],
    ) -> Vec3A {
        match self.world.hit(origin, direction) {
            Some(hit) => self.surface(origin + direction * hit.t, &hit, s, i),
            None => backdrop(place) * self.floor_light(origin, direction, s, i),
        }
    }

    fn surface(&self, p: Vec3A, hit: &Hit, s: &Sampler, i: u32) -> Vec3A {
        let start = p + hit.flat * hit.clear;
        let albedo = hit
            .color
            .unwrap_or_else(|| stone::albedo((p - self.middle) / self.world.size));
        let mut light = FILL * (0.5 + 0.5 * hit.normal.dot(self.fill));
        let facing = hit.normal.dot(self.key);
        if facing > 0.0 && self.is_lit(start, s, i) {
            light += KEY * facing;
        }
        let out = cosine_about(hit.normal, s.point(i, TO_ROOM));
        let height = 0.5 + 0.5 * out.dot(self.world.up);
        light += if self.world.is_blocked(start, out) {
            ROOM * albedo * 0.55
        } else {
            ROOM * (0.62 + 0.5 * height)
        };
        albedo * light
    }

    fn is_lit(&self, start: Vec3A, s: &Sampler, i: u32) -> bool {
        let to_light = cone_about(self.key, SOFT, s.point(i, TO_KEY));
        !self.world.is_blocked(start, to_light)
    }

    /// The share of its light that the floor keeps where a ray would meet it; it fades away from
    /// the scene, so that the floor has no end.
    fn floor_light(&self, origin: Vec3A, direction: Vec3A, s: &Sampler, i: u32) -> f32 {
        let up = self.world.up;
        let (above, fall) = (origin.dot(up) - self.floor, -direction.dot(up));
        if above <= 0.0 || fall <= 1e-3 {
            return 1.0;
        }
        let p = origin + direction * (above / fall);
        let far = p.distance(self.middle) / self.world.size;
        let near = 1.0 - ((far - 0.9) / 1.1).clamp(0.0, 1.0);
        if near <= 0.0 {
            return 1.0;
        }
        let start = p + up * (1e-4 * self.world.size);
        let key = if self.is_lit(start, s, i) { 0.0 } else { 0.38 };
        let out = cosine_about(up, s.point(i, TO_ROOM));
        let room = if self.world.is_blocked(start, out) {
            0.42
        } else {
            0.0
        };
        1.0 - near * near * (3.0 - 2.0 * near) * (key + room)
    }
}

/// A pale sheet, brighter behind the middle of the picture.
fn backdrop([x, y]: [f32; 2]) -> Vec3A {
    let (dx, dy) = (x - 0.5, y - 0.42);
    let far = ((dx * dx + dy * dy) * 1.9).min(1.0);
    BACKDROP[0] + (BACKDROP[1] - BACKDROP[0]) * far
}
