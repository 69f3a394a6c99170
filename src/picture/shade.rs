//! The light of the studio.

use glam::Vec3A;

use super::sample::{Sampler, cone_about, cosine_about};
use super::trace::{Hit, Material, Starts, World};
use super::{Background, Camera, material};

const KEY: Vec3A = Vec3A::new(1.75, 1.60, 1.38);
const ROOM: Vec3A = Vec3A::new(0.44, 0.465, 0.515);
const FILL: Vec3A = Vec3A::new(0.07, 0.075, 0.09);

/// Tangent of half the angle that the key light fills: a large soft box.
const SOFT: f32 = 0.12;

/// The share of the room's light that what hides it gives back, over its albedo.
const BOUNCE: f32 = 0.7;

/// The sheet's middle and rim, linear light.
const SHEET: [Vec3A; 2] = [Vec3A::new(1.25, 1.22, 1.17), Vec3A::new(0.62, 0.60, 0.575)];

/// Shares of the light on the floor that the key and the room give.
const KEY_ON_FLOOR: f32 = 0.50;
const ROOM_ON_FLOOR: f32 = 0.34;

/// What a ray from the camera came to.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Met {
    Thing,
    Sheet,
    Nothing,
}

/// Lights, and the floor that takes the shadow.
pub(super) struct Studio<'a> {
    world: &'a World<'a>,
    background: Background,
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
    pub(super) fn new(world: &'a World<'a>, camera: &Camera, background: Background) -> Self {
        let back = -(camera.forward - world.up * camera.forward.dot(world.up)).normalize_or_zero();
        let key = world.up * 0.85 + camera.above * 0.25 - camera.right * 0.95 + back * 0.40;
        let fill = camera.right * 0.8 + world.up * 0.2 + back * 0.6;
        Self {
            world,
            background,
            key: key.normalize_or(Vec3A::Y),
            fill: fill.normalize_or(Vec3A::Y),
            floor: world.lowest() - 2e-3 * world.size,
            middle: 0.5 * (world.bounds[0] + world.bounds[1]),
        }
    }

    /// Light that comes back along sample `i` of a pixel, and from what;
    /// `place` is in the picture, 0 to 1.
    pub(super) fn light(
        &self,
        origin: Vec3A,
        direction: Vec3A,
        s: &Sampler,
        i: u32,
        place: [f32; 2],
    ) -> (Vec3A, Met) {
        match (self.world.hit(origin, direction), self.background) {
            (Some(hit), _) => (self.surface(&hit, s, i), Met::Thing),
            (None, Background::Studio) => {
                let floor = self.floor_light(origin, direction, s, i);
                (sheet(place) * floor, Met::Sheet)
            }
            (None, _) => (Vec3A::ZERO, Met::Nothing),
        }
    }

    fn surface(&self, hit: &Hit, s: &Sampler, i: u32) -> Vec3A {
        let p = hit.place - self.middle;
        let look = match hit.material {
            Material::Stone => material::stone(p / self.world.size, hit.normal),
            Material::Lichen { color, grain } => material::lichen(p, hit.normal, color, grain),
        };
        let mut light = FILL * (0.5 + 0.5 * look.normal.dot(self.fill));
        let facing = look.normal.dot(self.key);
        if facing > 0.0 && self.is_lit(&hit.starts, s, i) {
            light += KEY * facing;
        }
        let out = cosine_about(look.normal, s.point(i, TO_ROOM));
        light += if self.world.is_blocked(&hit.starts, out) {
            ROOM * look.albedo * BOUNCE
        } else {
            ROOM * (0.62 + 0.5 * (0.5 + 0.5 * out.dot(self.world.up)))
        };
        look.albedo * light
    }

    fn is_lit(&self, starts: &Starts, s: &Sampler, i: u32) -> bool {
        let to_light = cone_about(self.key, SOFT, s.point(i, TO_KEY));
        !self.world.is_blocked(starts, to_light)
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
        let starts = (p + up * (1e-4 * self.world.size)).into();
        let key = match self.is_lit(&starts, s, i) {
            true => 0.0,
            false => KEY_ON_FLOOR,
        };
        let out = cosine_about(up, s.point(i, TO_ROOM));
        let room = match self.world.is_blocked(&starts, out) {
            true => ROOM_ON_FLOOR,
            false => 0.0,
        };
        1.0 - near * near * (3.0 - 2.0 * near) * (key + room)
    }
}

/// A pale sheet, brighter behind the middle of the picture.
fn sheet([x, y]: [f32; 2]) -> Vec3A {
    let (dx, dy) = (x - 0.5, y - 0.42);
    let far = ((dx * dx + dy * dy) * 1.9).min(1.0);
    SHEET[0] + (SHEET[1] - SHEET[0]) * far
}
