//! Rays against the substrate, painted meshes and domes.

use glam::{Vec3, Vec3A};
use obvhs::aabb::Aabb;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::leaf_collapser::collapse;
use obvhs::bvh2::reinsertion::ReinsertionOptimizer;
use obvhs::ploc::{PlocBuilder, PlocSearchDistance, SortPrecision};
use obvhs::ray::{INVALID_ID, Ray, RayHit};
use rayon::prelude::*;

use super::smooth::corner_normals;
use super::{Disc, Painted, Scene, color};

/// Height of a dome over its radius.
const HEIGHT: f32 = 0.6;

/// Domes in a leaf, and triangles in a leaf, at most.
const LEAF: u32 = 4;

/// Distance, in sizes of the scene, at which a ray starts over a triangle that it left.
const CLEAR: f32 = 4e-6;

struct Tri {
    corner: Vec3A,
    sides: [Vec3A; 2],
}

/// Triangles made ready for rays, those without an area left out.
struct Mesh {
    /// In the order of the tree.
    triangles: Vec<Tri>,
    /// The number that each of them had.
    numbers: Vec<u32>,
    tree: Bvh2,
    boxed: [Vec3A; 2],
}

/// The upper half of an ellipsoid on the surface.
#[derive(Clone, Copy)]
pub(super) struct Dome {
    pub(super) center: Vec3A,
    pub(super) normal: Vec3A,
    pub(super) radius: f32,
    pub(super) color: Vec3A,
}

/// What a thing is made of.
#[derive(Clone, Copy)]
pub(super) enum Material {
    /// The substrate.
    Stone,
    /// Lichen of this albedo, in linear light.
    Lichen {
        color: Vec3A,
        /// See [`Painted::grain`].
        grain: f32,
    },
}

/// What a ray met first.
pub(super) struct Hit {
    /// Where.
    pub(super) place: Vec3A,
    /// For shading, on the ray's side.
    pub(super) normal: Vec3A,
    pub(super) material: Material,
    /// Where rays that leave the place start, to meet lichen and to meet stone.
    pub(super) starts: Starts,
}

/// Where a ray starts: off the shape that it leaves, so as not to meet it again.
#[derive(Clone, Copy)]
pub(super) struct Starts {
    /// For lichen in its way.
    pub(super) lichen: Vec3A,
    /// For stone in its way: over the smooth surface that coarse triangles stand for, or their
    /// shadows on each other would show them (Hanika, *Hacking the Shadow Terminator*, 2021).
    pub(super) stone: Vec3A,
}

impl From<Vec3A> for Starts {
    fn from(place: Vec3A) -> Self {
        Self {
            lichen: place,
            stone: place,
        }
    }
}

/// The scene made ready for rays, parts that cannot be drawn left out.
pub(super) struct World<'a> {
    stone: Mesh,
    /// At the corners of the substrate's triangles that are not left out.
    stone_normals: Vec<[Vec3; 3]>,
    skins: Vec<(Mesh, &'a Painted<'a>)>,
    pub(super) domes: Vec<Dome>,
    dome_tree: Bvh2,
    pub(super) up: Vec3A,
    /// The corners of the box about everything.
    pub(super) bounds: [Vec3A; 2],
    /// The diagonal of that box; 1 where there is nothing.
    pub(super) size: f32,
}

impl<'a> World<'a> {
    pub(super) fn new(scene: &Scene<'a>) -> Self {
        let shapes = sound_triangles(scene.vertices, scene.triangles);
        let stone_normals = corner_normals(&shapes.iter().map(|s| s.1).collect::<Vec<_>>());
        let numbered = shapes.into_iter().enumerate();
        let stone = Mesh::new(numbered.map(|(i, (_, shape))| (i as u32, shape)).collect());
        let skin = |skin: &'a Painted<'a>| {
            let sound = sound_triangles(skin.positions, skin.triangles);
            let known = sound.into_iter().filter(|(i, _)| skin.is_known(*i));
            (Mesh::new(known.collect()), skin)
        };
        let skins: Vec<_> = scene.skins.iter().map(skin).collect();
        let domes: Vec<Dome> = scene.discs.iter().filter_map(Dome::new).collect();
        let boxes: Vec<Aabb> = domes.par_iter().map(Dome::bounds).collect();
        let dome_tree = tree(&boxes);
        let domes = order(&dome_tree).map(|i| domes[i as usize]).collect();
        let meshes = skins.iter().map(|(mesh, _)| mesh.boxed);
        let bounds = union(meshes.chain([stone.boxed, extent(&boxes)]));
        let is_empty = bounds[0].x > bounds[1].x;
        let bounds = if is_empty { [Vec3A::ZERO; 2] } else { bounds };
        let size = bounds[0].distance(bounds[1]);
        Self {
            stone,
            stone_normals,
            skins,
            domes,
            dome_tree,
            up: Vec3A::from_array(scene.up)
                .try_normalize()
                .unwrap_or(Vec3A::Y),
            bounds,
            size: if size > 0.0 { size } else { 1.0 },
        }
    }

    /// Corners of the substrate's triangles, at most about three times `most`, evenly taken.
    pub(super) fn some_corners(&self, most: usize) -> impl Iterator<Item = Vec3A> {
        let step = self.stone.triangles.len() / most + 1;
        self.stone
            .triangles
            .iter()
            .step_by(step)
            .flat_map(Tri::corners)
    }

    /// Triangles of the painted meshes, at most about `most` of each, evenly taken: middle, normal
    /// and area.
    pub(super) fn some_skin(&self, most: usize) -> impl Iterator<Item = (Vec3A, Vec3A, f32)> {
        self.skins.iter().flat_map(move |(mesh, _)| {
            let step = mesh.triangles.len() / most + 1;
            mesh.triangles.iter().step_by(step).map(|t| {
                let across = t.sides[0].cross(t.sides[1]);
                let middle = t.corner + (t.sides[0] + t.sides[1]) / 3.0;
                (middle, across.normalize_or_zero(), 0.5 * across.length())
            })
        })
    }

    /// The least height of anything along `up`.
    pub(super) fn lowest(&self) -> f32 {
        let skins = self.skins.iter().flat_map(|(mesh, _)| &mesh.triangles);
        let corners = self.stone.triangles.iter().chain(skins);
        corners
            .flat_map(Tri::corners)
            .chain(self.domes.iter().map(|d| d.center))
            .map(|p| p.dot(self.up))
            .fold(f32::INFINITY, f32::min)
    }

    /// The first thing in the way of a ray.
    pub(super) fn hit(&self, origin: Vec3A, direction: Vec3A) -> Option<Hit> {
        let mut ray = Ray::new_inf(origin, direction);
        let mut first = None;
        if let Some(i) = self.stone.first(&mut ray) {
            first = Some(Thing::Stone(i));
        }
        for (k, (mesh, _)) in self.skins.iter().enumerate() {
            if let Some(i) = mesh.first(&mut ray) {
                first = Some(Thing::Skin(k, i));
            }
        }
        if let Some(i) = first_of(&self.dome_tree, &mut ray, |ray, i| self.domes[i].hit(ray)) {
            first = Some(Thing::Dome(i));
        }
        first.map(|thing| match thing {
            Thing::Stone(i) => self.stone_hit(&ray, i),
            Thing::Skin(k, i) => self.skin_hit(&ray, k, i),
            Thing::Dome(i) => self.dome_hit(&ray, i),
        })
    }

    /// Whether anything is in the way of a ray.
    pub(super) fn is_blocked(&self, from: &Starts, direction: Vec3A) -> bool {
        let ray = || Ray::new_inf(from.lichen, direction);
        self.is_behind(from.stone, direction)
            || self.skins.iter().any(|(mesh, _)| mesh.blocks(ray()))
            || !self
                .dome_tree
                .ray_traverse_miss(ray(), |ray, i| self.domes[i].hit(ray))
    }

    /// Whether the substrate is in the way of a ray.
    pub(super) fn is_behind(&self, origin: Vec3A, direction: Vec3A) -> bool {
        self.stone.blocks(Ray::new_inf(origin, direction))
    }

    fn stone_hit(&self, ray: &Ray, i: usize) -> Hit {
        let triangle = &self.stone.triangles[i];
        let normals = self.stone_normals[self.stone.numbers[i] as usize].map(Vec3A::from);
        let facing = Facing::new(triangle, ray, normals);
        let off = facing.flat * (CLEAR * self.size);
        let starts = Starts {
            lichen: facing.place + off,
            stone: facing.place + off + facing.lift(triangle),
        };
        Hit {
            place: facing.place,
            normal: facing.smooth,
            material: Material::Stone,
            starts,
        }
    }

    fn skin_hit(&self, ray: &Ray, k: usize, i: usize) -> Hit {
        let (mesh, skin) = &self.skins[k];
        let corners = skin.triangles[mesh.numbers[i] as usize].map(|c| c as usize);
        let normals = corners.map(|c| Vec3A::from_array(skin.normals[c]));
        let facing = Facing::new(&mesh.triangles[i], ray, normals);
        let colors = corners.map(|c| color::linear(skin.colors[c]));
        let grain = skin.grain;
        Hit {
            place: facing.place,
            normal: facing.smooth,
            material: Material::Lichen {
                color: facing.mean(colors),
                grain,
            },
            starts: (facing.place + facing.flat * (CLEAR * self.size)).into(),
        }
    }

    fn dome_hit(&self, ray: &Ray, i: usize) -> Hit {
        let dome = &self.domes[i];
        let place = ray.origin + ray.direction * ray.tmax;
        let p = place - dome.center;
        let tall = dome.normal * p.dot(dome.normal);
        let out = ((p - tall) + tall / (HEIGHT * HEIGHT)).normalize_or_zero();
        let flat = towards(out, ray);
        let clear = (0.03 * dome.radius).max(2e-6 * self.size);
        Hit {
            place,
            normal: (flat + 0.35 * dome.normal).normalize_or_zero(),
            material: Material::Lichen {
                color: dome.color,
                grain: 0.0,
            },
            starts: (place + flat * clear).into(),
        }
    }
}

/// What a ray meets, by its number in the order of its tree.
enum Thing {
    Stone(usize),
    Skin(usize, usize),
    Dome(usize),
}

/// The nearest thing of a tree, to which the ray is cut; `hit` gives the distance.
fn first_of(tree: &Bvh2, ray: &mut Ray, mut hit: impl FnMut(&Ray, usize) -> f32) -> Option<usize> {
    let mut nearest = RayHit::none();
    tree.ray_traverse(*ray, &mut nearest, |ray, i| hit(ray, i));
    (nearest.primitive_id != INVALID_ID).then(|| {
        ray.tmax = nearest.t;
        nearest.primitive_id as usize
    })
}

impl Mesh {
    fn new(shapes: Vec<(u32, [Vec3A; 3])>) -> Self {
        let boxes: Vec<Aabb> = shapes.par_iter().map(|(_, s)| triangle_box(s)).collect();
        let tree = tree(&boxes);
        let sorted = |i: u32| {
            let [a, b, c] = shapes[i as usize].1;
            Tri {
                corner: a,
                sides: [b - a, c - a],
            }
        };
        Self {
            triangles: order(&tree).map(sorted).collect(),
            numbers: order(&tree).map(|i| shapes[i as usize].0).collect(),
            boxed: extent(&boxes),
            tree,
        }
    }

    fn first(&self, ray: &mut Ray) -> Option<usize> {
        first_of(&self.tree, ray, |ray, i| self.triangles[i].hit(ray).0)
    }

    fn blocks(&self, ray: Ray) -> bool {
        !self
            .tree
            .ray_traverse_miss(ray, |ray, i| self.triangles[i].hit(ray).0)
    }
}

impl Painted<'_> {
    /// Whether the corners of a triangle have normals and colours.
    fn is_known(&self, triangle: u32) -> bool {
        let known = self.normals.len().min(self.colors.len());
        let corners = self.triangles[triangle as usize];
        corners.into_iter().all(|c| (c as usize) < known)
    }
}

/// A place on a triangle as a ray sees it.
struct Facing {
    place: Vec3A,
    /// Weights of the corners.
    weights: [f32; 3],
    /// Normals at the corners, of the place and of the triangle, on the ray's side.
    normals: [Vec3A; 3],
    smooth: Vec3A,
    flat: Vec3A,
}

impl Facing {
    fn new(triangle: &Tri, ray: &Ray, normals: [Vec3A; 3]) -> Self {
        let (_, u, v) = triangle.hit(&Ray::new_inf(ray.origin, ray.direction));
        let weights = [1.0 - u - v, u, v];
        let [a, b] = triangle.sides;
        let flat = towards(a.cross(b).normalize_or_zero(), ray);
        let normals = normals.map(|n| if n.dot(flat) < 0.0 { -n } else { n });
        let smooth = weighted(weights, normals).normalize_or(flat);
        Self {
            place: ray.origin + ray.direction * ray.tmax,
            weights,
            normals,
            smooth,
            flat,
        }
    }

    fn mean(&self, corners: [Vec3A; 3]) -> Vec3A {
        weighted(self.weights, corners)
    }

    /// From the flat triangle to the smooth surface through its corners, where that is outside.
    fn lift(&self, triangle: &Tri) -> Vec3A {
        let mut corners = triangle.corners();
        let lifts = self.normals.map(|n| {
            let below = (self.place - corners.next().unwrap_or(self.place)).dot(n);
            n * -below.min(0.0)
        });
        self.mean(lifts)
    }
}

fn weighted(weights: [f32; 3], values: [Vec3A; 3]) -> Vec3A {
    values[0] * weights[0] + values[1] * weights[1] + values[2] * weights[2]
}

/// The direction, or its opposite, against the ray.
fn towards(direction: Vec3A, ray: &Ray) -> Vec3A {
    match direction.dot(ray.direction) > 0.0 {
        true => -direction,
        false => direction,
    }
}

impl Tri {
    fn corners(&self) -> impl Iterator<Item = Vec3A> + use<> {
        let [a, b] = self.sides;
        [self.corner, self.corner + a, self.corner + b].into_iter()
    }

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

/// Triangles that have an area, with their numbers.
fn sound_triangles(places: &[[f32; 3]], triangles: &[[u32; 3]]) -> Vec<(u32, [Vec3A; 3])> {
    let corner = |i: u32| places.get(i as usize).copied().map(Vec3A::from_array);
    let shape = |(i, t): (usize, &[u32; 3])| {
        let shape = [corner(t[0])?, corner(t[1])?, corner(t[2])?];
        let area = (shape[1] - shape[0]).cross(shape[2] - shape[0]).length();
        (area.is_finite() && area > 0.0).then_some((i as u32, shape))
    };
    triangles.par_iter().enumerate().filter_map(shape).collect()
}

fn triangle_box(&[a, b, c]: &[Vec3A; 3]) -> Aabb {
    let (low, high) = (a.min(b).min(c), a.max(b).max(c));
    let pad = low.abs().max(high.abs()) * (4.0 * f32::EPSILON) + (high - low).max_element() * 1e-6;
    Aabb::new(low - pad, high + pad)
}

/// The box about boxes, turned inside out where there are none.
fn extent(boxes: &[Aabb]) -> [Vec3A; 2] {
    union(boxes.iter().map(|b| [b.min, b.max]))
}

fn union(boxes: impl Iterator<Item = [Vec3A; 2]>) -> [Vec3A; 2] {
    let nothing = [Vec3A::INFINITY, Vec3A::NEG_INFINITY];
    boxes.fold(nothing, |[a, b], [c, d]| [a.min(c), b.max(d)])
}

fn order(tree: &Bvh2) -> impl Iterator<Item = u32> {
    tree.primitive_indices.iter().copied()
}

/// Trees up to this size are made better at the price of time, which their rays repay.
const WORTH_OPTIMIZING: usize = 400_000;

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
    if boxes.len() <= WORTH_OPTIMIZING {
        ReinsertionOptimizer::default().run(&mut tree, 0.1, None);
    }
    collapse(&mut tree, LEAF, 1.0);
    tree
}
