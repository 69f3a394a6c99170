//! The light of the studio.

use glam::Vec3A;

use super::material::{self, Look};
use super::sample::{Sampler, cone_about, cosine_about};
use super::trace::{Hit, InWay, Material, Starts, World};
use super::{Background, Camera};

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

/// What rays came to, one or many.
#[derive(Clone, Copy, Default, PartialEq, Eq)]
pub(super) struct Seen(u8);

impl Seen {
    pub(super) const THING: Self = Self(1);
    pub(super) const SHEET: Self = Self(2);
    pub(super) const NOTHING: Self = Self(4);
    const LIT: Self = Self(8);
    const SHADED: Self = Self(16);
    const OPEN: Self = Self(32);
    const CLOSED: Self = Self(64);

    /// All that either came to.
    pub(super) fn and(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }

    pub(super) fn has(self, other: Self) -> bool {
        self.0 & other.0 != 0
    }

    /// Which of two it was each time; none where it was both, or never asked.
    fn always(self, yes: Self, no: Self) -> Option<bool> {
        (self.has(yes) != self.has(no)).then_some(self.has(yes))
    }

    /// Whether every question had one answer each time.
    pub(super) fn is_even(self) -> bool {
        let both = |a: Self, b: Self| self.has(a) && self.has(b);
        !both(Self::LIT, Self::SHADED) && !both(Self::OPEN, Self::CLOSED)
    }

    /// Whether it was this and nothing else, each time.
    pub(super) fn is_only(self, what: Self) -> bool {
        let of = Self::THING.and(Self::SHEET).and(Self::NOTHING);
        self.0 & of.0 == what.0
    }
}

/// What is asked along one ray from the camera.
pub(super) struct Asked<'a> {
    pub(super) direction: Vec3A,
    /// In the picture, 0 to 1.
    pub(super) place: [f32; 2],
    pub(super) sampler: &'a Sampler,
    /// The number of the sample.
    pub(super) number: u32,
    /// What is seen round about: no ray is sent for an answer that was always the same there.
    pub(super) around: Seen,
}

/// What was looked at for one ray from the camera: while no lichen in these ways comes or goes, its light is the
/// same.
#[derive(Clone, Copy)]
pub(super) struct Rays {
    /// How far the ray itself went.
    pub(super) end: f32,
    /// Where those to the key light and to the room left.
    pub(super) from: Vec3A,
    /// Their directions; of no length where none was sent, or stone is in the way.
    pub(super) to: [Vec3A; 2],
    /// Whether something besides shapes told the colour.
    pub(super) is_structured: bool,
}

impl Default for Rays {
    fn default() -> Self {
        Self {
            end: f32::INFINITY,
            from: Vec3A::ZERO,
            to: [Vec3A::ZERO; 2],
            is_structured: false,
        }
    }
}

/// Which of the ways to lights is which.
const KEY_WAY: usize = 0;
const ROOM_WAY: usize = 1;

/// Lights, and the floor that takes the shadow.
pub(super) struct Studio<'a> {
    world: &'a World<'a>,
    background: Background,
    key: Vec3A,
    fill: Vec3A,
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
        }
    }

    /// Light that comes back along a ray from an eye, and what it met. What was looked at is noted.
    pub(super) fn light(&self, eye: Vec3A, asked: &Asked, rays: &mut Rays) -> (Vec3A, Seen) {
        match (self.world.hit(eye, asked.direction), self.background) {
            (Some(hit), _) => self.surface(&hit, asked, rays),
            (None, Background::Studio) => self.sheet(eye, asked, rays),
            (None, _) => (Vec3A::ZERO, Seen::NOTHING),
        }
    }

    fn surface(&self, hit: &Hit, asked: &Asked, rays: &mut Rays) -> (Vec3A, Seen) {
        let p = hit.place - self.world.stage.middle;
        rays.end = hit.end;
        rays.from = hit.starts.lichen;
        let look = match hit.material {
            Material::Ground => {
                let (ground, along) = self.world.ground;
                ground.look(p / self.world.stage.size, hit.normal, along)
            }
            Material::Own(albedo) => Look {
                albedo,
                normal: hit.normal,
            },
            Material::Lichen {
                color,
                grain,
                is_structured,
            } => {
                rays.is_structured = is_structured;
                material::lichen(p, hit.normal, color, grain)
            }
        };
        let mut ways = Ways {
            starts: &hit.starts,
            asked,
            seen: Seen::THING,
            rays,
        };
        let mut light = FILL * (0.5 + 0.5 * look.normal.dot(self.fill));
        let facing = look.normal.dot(self.key);
        if facing > 0.0 && self.is_lit(hit.horizon, &mut ways) {
            light += KEY * facing;
        }
        light += match self.room([look.normal, hit.horizon], &mut ways) {
            None => ROOM * look.albedo * BOUNCE,
            Some(out) => ROOM * (0.62 + 0.5 * (0.5 + 0.5 * out.dot(self.world.up))),
        };
        (look.albedo * light, ways.seen)
    }

    /// Whether the key light reaches a place with this horizon.
    fn is_lit(&self, horizon: Vec3A, ways: &mut Ways) -> bool {
        let asked = ways.asked;
        let known = asked.around.always(Seen::LIT, Seen::SHADED);
        let all_is_above = self.key.dot(horizon) > SOFT;
        let is_lit = match known {
            Some(is_lit) if all_is_above => is_lit,
            _ => {
                let u = asked.sampler.point(asked.number, TO_KEY);
                let to_light = cone_about(self.key, SOFT, u);
                if to_light.dot(horizon) <= 0.0 {
                    return false;
                }
                known.unwrap_or_else(|| ways.is_open(self.world, KEY_WAY, to_light))
            }
        };
        ways.saw(if is_lit { Seen::LIT } else { Seen::SHADED });
        is_lit
    }

    /// A direction about a normal in which the room is seen; none where something hides it, or it is
    /// below the horizon.
    fn room(&self, [normal, horizon]: [Vec3A; 2], ways: &mut Ways) -> Option<Vec3A> {
        let asked = ways.asked;
        let out = cosine_about(normal, asked.sampler.point(asked.number, TO_ROOM));
        if out.dot(horizon) <= 0.0 {
            return None;
        }
        let is_open = asked.around.always(Seen::OPEN, Seen::CLOSED);
        let is_open = is_open.unwrap_or_else(|| ways.is_open(self.world, ROOM_WAY, out));
        ways.saw(if is_open { Seen::OPEN } else { Seen::CLOSED });
        is_open.then_some(out)
    }

    /// The sheet, and the share of its light that the floor keeps where a ray would meet it; it
    /// fades away from the scene, so that the floor has no end.
    fn sheet(&self, eye: Vec3A, asked: &Asked, rays: &mut Rays) -> (Vec3A, Seen) {
        let sheet = sheet(asked.place);
        let (up, stage) = (self.world.up, &self.world.stage);
        let (above, fall) = (eye.dot(up) - stage.floor, -asked.direction.dot(up));
        if above <= 0.0 || fall <= 1e-3 {
            return (sheet, Seen::SHEET);
        }
        let p = eye + asked.direction * (above / fall);
        let far = p.distance(stage.middle) / stage.size;
        let near = 1.0 - ((far - 0.9) / 1.1).clamp(0.0, 1.0);
        if near <= 0.0 {
            return (sheet, Seen::SHEET);
        }
        let starts: Starts = (p + up * (1e-4 * stage.size)).into();
        rays.from = starts.lichen;
        let mut ways = Ways {
            starts: &starts,
            asked,
            seen: Seen::SHEET,
            rays,
        };
        let key = match self.is_lit(up, &mut ways) {
            true => 0.0,
            false => KEY_ON_FLOOR,
        };
        let room = match self.room([up; 2], &mut ways) {
            None => ROOM_ON_FLOOR,
            Some(_) => 0.0,
        };
        let floor = 1.0 - near * near * (3.0 - 2.0 * near) * (key + room);
        (sheet * floor, ways.seen)
    }
}

/// The ways from one place to the lights.
struct Ways<'a> {
    starts: &'a Starts,
    asked: &'a Asked<'a>,
    seen: Seen,
    rays: &'a mut Rays,
}

impl Ways<'_> {
    /// Whether nothing is in the way in a direction.
    fn is_open(&mut self, world: &World, which: usize, direction: Vec3A) -> bool {
        let in_way = world.in_way(self.starts, direction);
        if in_way != InWay::Stone {
            self.rays.to[which] = direction;
        }
        in_way == InWay::Nothing
    }

    fn saw(&mut self, what: Seen) {
        self.seen = self.seen.and(what);
    }
}

/// A pale sheet, brighter behind the middle of the picture.
fn sheet([x, y]: [f32; 2]) -> Vec3A {
    let (dx, dy) = (x - 0.5, y - 0.42);
    let far = ((dx * dx + dy * dy) * 1.9).min(1.0);
    SHEET[0] + (SHEET[1] - SHEET[0]) * far
}
