//! Sample points: low-discrepancy sequences, shifted by a hash of the pixel.

use glam::{Vec2, Vec3A};
use wide::u32x4;

/// A well mixed 32-bit hash (Wellons' lowbias32).
pub(super) fn hash(x: u32) -> u32 {
    let x = (x ^ (x >> 16)).wrapping_mul(0x7feb_352d);
    let x = (x ^ (x >> 15)).wrapping_mul(0x846c_a68b);
    x ^ (x >> 16)
}

/// The same of four numbers.
#[inline(always)]
pub(super) fn hash_four(x: u32x4) -> u32x4 {
    let x = (x ^ (x >> 16)) * u32x4::splat(0x7feb_352d);
    let x = (x ^ (x >> 15)) * u32x4::splat(0x846c_a68b);
    x ^ (x >> 16)
}

/// 0 ≤ x < 1.
pub(super) fn unit(h: u32) -> f32 {
    (h >> 8) as f32 / (1 << 24) as f32
}

/// The sample points of one pixel.
#[derive(Clone, Copy)]
pub(super) struct Sampler {
    seed: u32,
    count: u32,
}

impl Sampler {
    pub(super) fn new(x: u32, y: u32, count: u32) -> Self {
        let seed = hash(x ^ hash(y ^ 0x51ed_270b));
        Self { seed, count }
    }

    /// Point `i` of `count` in the unit square, for one purpose. The points of a pixel follow
    /// Roberts' R2 sequence, and each purpose takes them in an order of its own.
    pub(super) fn point(&self, i: u32, purpose: u32) -> Vec2 {
        const STEP: [u32; 2] = [0xC13F_A9A9, 0x91E1_0DA5];
        let shift = hash(self.seed ^ purpose.wrapping_mul(0x9E37_79B9));
        let j = (i + hash(shift ^ 1) % self.count) % self.count;
        let k = if purpose.is_multiple_of(2) {
            j
        } else {
            self.count - 1 - j
        };
        let along = |axis: usize| {
            let start = hash(shift ^ (7 + axis as u32));
            unit(start.wrapping_add(k.wrapping_mul(STEP[axis])))
        };
        Vec2::new(along(0), along(1))
    }

    /// One number for the whole pixel.
    pub(super) fn dither(&self) -> f32 {
        unit(hash(self.seed ^ 0x00d1_7e44))
    }
}

/// A point of the unit disc, evenly spread (Shirley & Chiu 1997, by polar angle).
fn on_disc(u: Vec2) -> Vec2 {
    let angle = core::f32::consts::TAU * u.y;
    let (sin, cos) = libm::sincosf(angle);
    Vec2::new(cos, sin) * u.x.sqrt()
}

/// A direction about `n`, with density by the cosine.
pub(super) fn cosine_about(n: Vec3A, u: Vec2) -> Vec3A {
    let d = on_disc(u);
    let (a, b) = n.any_orthonormal_pair();
    a * d.x + b * d.y + n * (1.0 - u.x).max(1e-4).sqrt()
}

/// A direction in the cone about `axis` whose tangent is `spread`.
pub(super) fn cone_about(axis: Vec3A, spread: f32, u: Vec2) -> Vec3A {
    let d = on_disc(u) * spread;
    let (a, b) = axis.any_orthonormal_pair();
    (axis + a * d.x + b * d.y).normalize()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn four_numbers_are_hashed_as_each_alone() {
        for x in [0, 1, 77, 1 << 16, u32::MAX - 3] {
            let four = [x, x + 1, x ^ 0x8000_0001, !x];
            assert_eq!(hash_four(u32x4::new(four)).to_array(), four.map(hash));
        }
    }
}
