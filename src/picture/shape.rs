//! The shapes that rays meet: triangles, and domes for granules.

use glam::{BVec4A, Vec3, Vec3A, Vec4};
use obvhs::aabb::Aabb;

use super::wide::{Lanes, Ray, WIDTH};
use super::{Disc, color};

/// Height of a dome over its radius.
pub(super) const HEIGHT: f32 = 0.6;

/// Four triangles, ready for rays.
pub(super) struct Triangles {
    corner: Lanes,
    /// To the second and to the third corner.
    sides: [Lanes; 2],
    /// Their numbers.
    pub(super) numbers: [u32; WIDTH],
}

/// Where a ray meets a triangle.
#[derive(Clone, Copy)]
pub(super) struct Touch {
    /// How far along.
    pub(super) at: f32,
    /// The weights of the second and third corner.
    pub(super) weights: [f32; 2],
    /// Which of the four.
    pub(super) lane: usize,
}

/// The upper half of an ellipsoid on the surface. There are millions of them: no wider than it has to be.
#[derive(Clone, Copy)]
pub(super) struct Dome {
    center: Vec3,
    normal: Vec3,
    pub(super) radius: f32,
    /// sRGB.
    color: [u8; 3],
}

impl Triangles {
    pub(super) fn new(numbers: [u32; WIDTH], corners: [[Vec3A; 3]; WIDTH]) -> Self {
        Self {
            corner: Lanes::new(corners.map(|[a, ..]| a)),
            sides: [1, 2].map(|k| Lanes::new(corners.map(|c| c[k] - c[0]))),
            numbers,
        }
    }

    /// The corners of one of them.
    pub(super) fn corners(&self, lane: usize) -> [Vec3A; 3] {
        let [a, b] = self.sides.map(|side| side.get(lane));
        let corner = self.corner.get(lane);
        [corner, corner + a, corner + b]
    }

    /// The corners of all of them.
    pub(super) fn all_corners(&self) -> impl Iterator<Item = Vec3A> + use<> {
        let corners: [_; WIDTH] = std::array::from_fn(|lane| self.corners(lane));
        corners.into_iter().flatten()
    }

    /// Which of them a ray meets, where, and by which weights of their second and third corners
    /// (Möller & Trumbore 1997).
    fn hits(&self, ray: &Ray) -> (BVec4A, Vec4, [Vec4; 2]) {
        let [e1, e2] = self.sides;
        let p = ray.direction.cross(e2);
        let scale = e1.dot(p).recip();
        let s = ray.origin.minus(self.corner);
        let u = s.dot(p) * scale;
        let q = s.cross(e1);
        let v = ray.direction.dot(q) * scale;
        let t = e2.dot(q) * scale;
        let least = Vec4::splat(-1e-6);
        let inside = u.cmpge(least) & v.cmpge(least) & (u + v).cmple(Vec4::splat(1.000_001));
        let on_way = t.cmpgt(Vec4::ZERO) & t.cmplt(Vec4::splat(ray.end));
        (inside & on_way, t, [u, v])
    }

    /// Whether a ray meets any of them.
    pub(super) fn block(&self, ray: &Ray) -> bool {
        self.hits(ray).0.any()
    }

    /// The first that a ray meets.
    pub(super) fn first(&self, ray: &Ray) -> Option<Touch> {
        let (met, t, weights) = self.hits(ray);
        if !met.any() {
            return None;
        }
        let nearest = |a: &usize, b: &usize| t[*a].total_cmp(&t[*b]);
        let lane = (0..WIDTH).filter(|&lane| met.test(lane)).min_by(nearest)?;
        Some(Touch {
            at: t[lane],
            weights: weights.map(|w| w[lane]),
            lane,
        })
    }
}

/// Four domes, ready for rays.
pub(super) struct Domes {
    center: Lanes,
    normal: Lanes,
    radius: Vec4,
    /// Their numbers.
    pub(super) numbers: [u32; WIDTH],
}

impl Domes {
    pub(super) fn new(numbers: [u32; WIDTH], domes: [Dome; WIDTH]) -> Self {
        Self {
            center: Lanes::new(domes.map(|d| d.center())),
            normal: Lanes::new(domes.map(|d| d.normal())),
            radius: Vec4::from_array(domes.map(|d| d.radius)),
            numbers,
        }
    }

    /// Distances to the upper halves, from without or within; infinite for those missed.
    fn hits(&self, ray: &Ray) -> Vec4 {
        const STRETCH: Vec4 = Vec4::splat(1.0 / HEIGHT - 1.0);
        let to = self.center.minus(ray.origin);
        let near = to.dot(ray.direction);
        // From the centre to the nearest point of the ray; then stretched to a sphere.
        let o = Lanes::splat(Vec3A::ZERO)
            .minus(to)
            .plus(near, ray.direction);
        let (rise, climb) = (o.dot(self.normal), ray.direction.dot(self.normal));
        let p = o.plus(rise * STRETCH, self.normal);
        let d = ray.direction.plus(climb * STRETCH, self.normal);
        let (a, b) = (d.dot(d), p.dot(d));
        let square = b * b - a * (p.dot(p) - self.radius * self.radius);
        let root = square.max(Vec4::ZERO).map(f32::sqrt);
        let on_top = |s: Vec4| {
            let is_above = (rise + s * climb).cmpgt(Vec4::ZERO);
            let met = is_above & (near + s).cmpgt(Vec4::ZERO) & square.cmpge(Vec4::ZERO);
            Vec4::select(met, near + s, Vec4::INFINITY)
        };
        on_top((-b - root) / a).min(on_top((-b + root) / a))
    }

    /// Whether a ray meets any of them.
    pub(super) fn block(&self, ray: &Ray) -> bool {
        self.hits(ray).cmplt(Vec4::splat(ray.end)).any()
    }

    /// The first that a ray meets: where, and its number.
    pub(super) fn first(&self, ray: &Ray) -> Option<(f32, u32)> {
        let at = self.hits(ray);
        let nearest = |a: &usize, b: &usize| at[*a].total_cmp(&at[*b]);
        let lane = (0..WIDTH).min_by(nearest)?;
        (at[lane] < ray.end).then_some((at[lane], self.numbers[lane]))
    }
}

impl Dome {
    pub(super) fn new(disc: &Disc) -> Option<Self> {
        let center = Vec3::from_array(disc.center);
        let normal = Vec3A::from_array(disc.normal).try_normalize()?.into();
        let sound = center.is_finite() && disc.radius.is_finite() && disc.radius > 0.0;
        sound.then_some(Self {
            center,
            normal,
            radius: disc.radius,
            color: disc.color,
        })
    }

    pub(super) fn center(&self) -> Vec3A {
        self.center.into()
    }

    pub(super) fn normal(&self) -> Vec3A {
        self.normal.into()
    }

    /// No part of it is lower along a direction of length 1.
    pub(super) fn lowest(&self, up: Vec3A) -> f32 {
        self.center().dot(up) - self.radius
    }

    /// Linear light that it gives back.
    pub(super) fn albedo(&self) -> Vec3A {
        color::linear(self.color)
    }

    pub(super) fn bounds(&self) -> Aabb {
        let (center, normal) = (self.center(), self.normal());
        let across = Vec3A::ONE - normal * normal;
        let half = across.max(Vec3A::ZERO).map(f32::sqrt) * self.radius;
        let top = center + normal * (HEIGHT * self.radius);
        let (low, high) = (center - half, center + half);
        let pad = Vec3A::splat(0.2 * self.radius);
        Aabb::new(low.min(top) - pad, high.max(top) + pad)
    }
}

/// The box of a triangle, a little larger than it.
pub(super) fn triangle_box(&[a, b, c]: &[Vec3A; 3]) -> Aabb {
    let (low, high) = (a.min(b).min(c), a.max(b).max(c));
    let pad = low.abs().max(high.abs()) * (4.0 * f32::EPSILON) + (high - low).max_element() * 1e-6;
    Aabb::new(low - pad, high + pad)
}
