//! Rays against the triangles and the domes.

use glam::{Vec3, Vec3A};
use obvhs::aabb::Aabb;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::leaf_collapser::collapse;
use obvhs::ploc::{PlocBuilder, PlocSearchDistance, SortPrecision};
use obvhs::ray::{INVALID_ID, Ray, RayHit};
use rayon::prelude::*;

use super::smooth::corner_normals;
use super::{Disc, Scene, color};

/// Height of a dome over its radius.
const HEIGHT: f32 = 0.6;

/// Domes in a leaf, and triangles in a leaf, at most.
const LEAF: u32 = 4;

struct Tri {
    corner: Vec3A,
    sides: [Vec3A; 2],
}

/// The upper half of an ellipsoid on the surface.
pub(super) struct Dome {
    pub(super) center: Vec3A,
    pub(super) normal: Vec3A,
    pub(super) radius: f32,
    pub(super) color: Vec3A,
}

/// What a ray met first.
pub(super) struct Hit {
    pub(super) t: f32,
    /// Across the shape itself, on the ray's side.
    pub(super) flat: Vec3A,
    /// For shading, on the same side.
    pub(super) normal: Vec3A,
    /// The colour of a dome; none on stone.
    pub(super) color: Option<Vec3A>,
    /// How far to start from the surface so as not to meet it again.
    pub(super) clear: f32,
}

/// The scene made ready for rays, parts that cannot be drawn left out.
pub(super) struct World {
    triangles: Vec<Tri>,
    normals: Vec<[Vec3; 3]>,
    triangle_tree: Bvh2,
    pub(super) domes: Vec<Dome>,
    dome_tree: Bvh2,
    pub(super) up: Vec3A,
    /// The corners of the box about everything.
    pub(super) bounds: [Vec3A; 2],
    /// The diagonal of that box; 1 where there is nothing.
    pub(super) size: f32,
}

impl World {
    pub(super) fn new(scene: &Scene) -> Self {
        let shapes = sound_triangles(scene);
        let boxes: Vec<Aabb> = shapes.par_iter().map(triangle_box).collect();
        let triangle_tree = tree(&boxes);
        let order = &triangle_tree.primitive_indices;
        let all_normals = corner_normals(&shapes);
        let domes: Vec<Dome> = scene.discs.iter().filter_map(Dome::new).collect();
        let dome_boxes: Vec<Aabb> = domes.par_iter().map(Dome::bounds).collect();
        let dome_tree = tree(&dome_boxes);
        let bounds = extent(boxes.iter().chain(&dome_boxes));
        let size = bounds[0].distance(bounds[1]);
        let sorted = |i: &u32| {
            let [a, b, c] = shapes[*i as usize];
            Tri {
                corner: a,
                sides: [b - a, c - a],
            }
        };
        let dome_order = &dome_tree.primitive_indices;
        Self {
            triangles: order.iter().map(sorted).collect(),
            normals: order.iter().map(|&i| all_normals[i as usize]).collect(),
            domes: dome_order
                .iter()
                .map(|&i| domes[i as usize].copy())
                .collect(),
            triangle_tree,
            dome_tree,
            up: Vec3A::from_array(scene.up)
                .try_normalize()
                .unwrap_or(Vec3A::Y),
            bounds,
            size: if size > 0.0 { size } else { 1.0 },
        }
    }

    /// Corners of triangles and middles of domes, at most about `most` of each, evenly taken.
    pub(super) fn some_corners(&self, most: usize) -> impl Iterator<Item = Vec3A> {
        let step = self.triangles.len() / most + 1;
        self.triangles.iter().step_by(step).flat_map(|t| {
            let [a, b] = t.sides;
            [t.corner, t.corner + a, t.corner + b]
        })
    }

    /// The first thing in the way of a ray.
    pub(super) fn hit(&self, origin: Vec3A, direction: Vec3A) -> Option<Hit> {
        let mut ray = Ray::new_inf(origin, direction);
        let mut on_stone = RayHit::none();
        self.triangle_tree
            .ray_traverse(ray, &mut on_stone, |ray, i| self.triangles[i].hit(ray).0);
        if on_stone.primitive_id != INVALID_ID {
            ray.tmax = on_stone.t;
        }
        let mut on_dome = RayHit::none();
        self.dome_tree
            .ray_traverse(ray, &mut on_dome, |ray, i| self.domes[i].hit(ray));
        if on_dome.primitive_id != INVALID_ID {
            return Some(self.dome_hit(&ray, &on_dome));
        }
        (on_stone.primitive_id != INVALID_ID).then(|| self.stone_hit(&ray, &on_stone))
    }

    /// Whether anything is in the way of a ray.
    pub(super) fn is_blocked(&self, origin: Vec3A, direction: Vec3A) -> bool {
        self.is_behind(origin, direction)
            || !self
                .dome_tree
                .ray_traverse_miss(Ray::new_inf(origin, direction), |ray, i| {
                    self.domes[i].hit(ray)
                })
    }

    /// Whether the substrate is in the way of a ray.
    pub(super) fn is_behind(&self, origin: Vec3A, direction: Vec3A) -> bool {
        let ray = Ray::new_inf(origin, direction);
        !self
            .triangle_tree
            .ray_traverse_miss(ray, |ray, i| self.triangles[i].hit(ray).0)
    }

    fn stone_hit(&self, ray: &Ray, hit: &RayHit) -> Hit {
        let triangle = &self.triangles[hit.primitive_id as usize];
        let [na, nb, nc] = self.normals[hit.primitive_id as usize].map(Vec3A::from);
        let (_, u, v) = triangle.hit(&Ray::new_inf(ray.origin, ray.direction));
        let flat = triangle.sides[0]
            .cross(triangle.sides[1])
            .normalize_or_zero();
        let flat = if flat.dot(ray.direction) > 0.0 {
            -flat
        } else {
            flat
        };
        let smooth = (na * (1.0 - u - v) + nb * u + nc * v).normalize_or_zero();
        let smooth = if smooth.dot(flat) < 0.0 {
            -smooth
        } else {
            smooth
        };
        Hit {
            t: hit.t,
            flat,
            normal: smooth,
            color: None,
            clear: 2e-5 * self.size,
        }
    }

    fn dome_hit(&self, ray: &Ray, hit: &RayHit) -> Hit {
        let dome = &self.domes[hit.primitive_id as usize];
        let p = ray.origin + ray.direction * hit.t - dome.center;
        let tall = dome.normal * p.dot(dome.normal);
        let out = ((p - tall) + tall / (HEIGHT * HEIGHT)).normalize_or_zero();
        let flat = if out.dot(ray.direction) > 0.0 {
            -out
        } else {
            out
        };
        Hit {
            t: hit.t,
            flat,
            normal: (flat + 0.35 * dome.normal).normalize_or_zero(),
            color: Some(dome.color),
            clear: (0.03 * dome.radius).max(2e-6 * self.size),
        }
    }
}

impl Tri {
    /// Distance, and the weights of the second and third corner (Möller & Trumbore 1997).
    fn hit(&self, ray: &Ray) -> (f32, f32, f32) {
        const MISS: (f32, f32, f32) = (f32::INFINITY, 0.0, 0.0);
        let [e1, e2] = self.sides;
        let p = ray.direction.cross(e2);
        let scale = 1.0 / e1.dot(p);
        let s = ray.origin - self.corner;
        let u = s.dot(p) * scale;
        let q = s.cross(e1);
        let v = ray.direction.dot(q) * scale;
        let t = e2.dot(q) * scale;
        let inside = u >= -1e-6 && v >= -1e-6 && u + v <= 1.000_001;
        if inside && t > 0.0 { (t, u, v) } else { MISS }
    }
}

impl Dome {
    fn new(disc: &Disc) -> Option<Self> {
        let center = Vec3A::from_array(disc.center);
        let normal = Vec3A::from_array(disc.normal).try_normalize()?;
        let sound = center.is_finite() && disc.radius.is_finite() && disc.radius > 0.0;
        sound.then(|| Self {
            center,
            normal,
            radius: disc.radius,
            color: color::linear(disc.color),
        })
    }

    fn copy(&self) -> Self {
        Self { ..*self }
    }

    fn bounds(&self) -> Aabb {
        let across = Vec3A::ONE - self.normal * self.normal;
        let half = across.max(Vec3A::ZERO).map(f32::sqrt) * self.radius;
        let top = self.center + self.normal * (HEIGHT * self.radius);
        let (low, high) = (self.center - half, self.center + half);
        let pad = Vec3A::splat(0.2 * self.radius);
        Aabb::new(low.min(top) - pad, high.max(top) + pad)
    }

    /// Distance to the upper half, from without or within.
    fn hit(&self, ray: &Ray) -> f32 {
        let near = (self.center - ray.origin).dot(ray.direction);
        let inverse = 1.0 / self.radius;
        let o = (ray.origin + ray.direction * near - self.center) * inverse;
        let (rise, climb) = (o.dot(self.normal), ray.direction.dot(self.normal));
        const STRETCH: f32 = 1.0 / HEIGHT - 1.0;
        let p = o + self.normal * (rise * STRETCH);
        let d = ray.direction + self.normal * (climb * STRETCH);
        let (a, b, c) = (d.dot(d), p.dot(d), p.dot(p) - 1.0);
        let square = b * b - a * c;
        if square < 0.0 {
            return f32::INFINITY;
        }
        let root = square.sqrt();
        [-b - root, -b + root]
            .into_iter()
            .map(|s| s / a)
            .find(|s| rise + s * climb > 0.0 && near + s * self.radius > 0.0)
            .map_or(f32::INFINITY, |s| near + s * self.radius)
    }
}

fn sound_triangles(scene: &Scene) -> Vec<[Vec3A; 3]> {
    let corner = |i: u32| {
        scene
            .vertices
            .get(i as usize)
            .copied()
            .map(Vec3A::from_array)
    };
    let shape = |t: &[u32; 3]| {
        let shape = [corner(t[0])?, corner(t[1])?, corner(t[2])?];
        let area = (shape[1] - shape[0]).cross(shape[2] - shape[0]).length();
        (area.is_finite() && area > 0.0).then_some(shape)
    };
    scene.triangles.iter().filter_map(shape).collect()
}

fn triangle_box(&[a, b, c]: &[Vec3A; 3]) -> Aabb {
    let (low, high) = (a.min(b).min(c), a.max(b).max(c));
    let pad = low.abs().max(high.abs()) * (4.0 * f32::EPSILON) + (high - low).max_element() * 1e-6;
    Aabb::new(low - pad, high + pad)
}

fn extent<'a>(boxes: impl Iterator<Item = &'a Aabb>) -> [Vec3A; 2] {
    boxes
        .map(|b| [b.min, b.max])
        .reduce(|[a, b], [c, d]| [a.min(c), b.max(d)])
        .unwrap_or([Vec3A::ZERO; 2])
}

fn tree(boxes: &[Aabb]) -> Bvh2 {
    if boxes.is_empty() {
        return Bvh2::zeroed(0);
    }
    let indices = (0..boxes.len() as u32).collect();
    let mut tree = PlocBuilder::with_capacity(boxes.len()).build(
        PlocSearchDistance::Low,
        boxes,
        indices,
        SortPrecision::U64,
        0,
    );
    collapse(&mut tree, LEAF, 1.0);
    tree
}
