//! Rays against the substrate, painted meshes and domes.

use glam::{Vec3, Vec3A};
use obvhs::aabb::Aabb;
use rayon::prelude::*;

use super::shape::{Dome, Domes, HEIGHT, Triangles, triangle_box};
use super::smooth::corner_normals;
use super::stage::{measured, upward};
use super::wide::{Group, Ray, Tree, WIDTH, WORTH_OPTIMIZING};
use super::{Coat, Disc, Finish, Ground, Painted, Scene, Stage, color, longest_axis};

/// Distance, in sizes of the scene, at which a ray starts over a triangle that it left.
pub(super) const CLEAR: f32 = 4e-6;

/// Triangles made ready for rays, those without an area left out.
pub(super) struct Mesh {
    groups: Vec<Triangles>,
    tree: Tree,
    boxed: [Vec3A; 2],
}

/// Granules made ready for rays.
struct Granules {
    domes: Vec<Dome>,
    groups: Vec<Domes>,
    tree: Tree,
    boxed: [Vec3A; 2],
}

/// What a thing is made of.
#[derive(Clone, Copy)]
pub(super) enum Material {
    /// The substrate.
    Ground,
    /// The substrate where it has an albedo of its own.
    Own(Vec3A),
    /// Lichen of this albedo, in linear light.
    Lichen {
        color: Vec3A,
        /// See [`Painted::grain`].
        grain: f32,
        /// Whether something besides the shape decides the colour.
        is_structured: bool,
    },
}

/// What a ray met first.
pub(super) struct Hit {
    /// How far along.
    pub(super) end: f32,
    /// Where.
    pub(super) place: Vec3A,
    /// For shading, on the ray's side.
    pub(super) normal: Vec3A,
    /// The same without fine relief: what leaves the place below its horizon meets the thing itself.
    pub(super) horizon: Vec3A,
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

/// A substrate made ready for rays, for all pictures of it. On a fine mesh that takes longer than a picture.
pub struct Stone {
    pub(super) mesh: Mesh,
    /// At the corners of the triangles that are not left out.
    normals: Vec<[Vec3; 3]>,
    /// What numbers these had, if any is left out.
    numbers: Option<Vec<u32>>,
}

impl std::fmt::Debug for Stone {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Stone").finish_non_exhaustive()
    }
}

impl Stone {
    /// A substrate of vertices in any unit, and triangles by their numbers, of either winding. Triangles that cannot be
    /// drawn (not finite, no area, no such vertex) are left out.
    pub fn new(vertices: &[[f32; 3]], triangles: &[[u32; 3]]) -> Self {
        let sound = sound_triangles(vertices, triangles);
        let corners = |i: u32| corners(vertices, triangles[sound[i as usize] as usize]);
        let numbers: Vec<u32> = (0..sound.len() as u32).collect();
        let together = if numbers.len() > WORTH_OPTIMIZING {
            WIDTH
        } else {
            1
        };
        let mesh = Mesh::new(&numbers, together, corners);
        let drawn = sound.iter().map(|&t| triangles[t as usize]);
        let normals = corner_normals(vertices, &drawn.collect::<Vec<_>>());
        Self {
            mesh,
            normals,
            numbers: (sound.len() < triangles.len()).then_some(sound),
        }
    }

    /// The number that a triangle was given with.
    pub(super) fn number(&self, spot: &Spot) -> u32 {
        let numbers = self.numbers.as_ref();
        numbers.map_or(spot.number, |numbers| numbers[spot.number as usize])
    }

    /// The corners of the box about it, turned inside out where there is nothing.
    pub(super) fn boxed(&self) -> [Vec3A; 2] {
        self.mesh.boxed
    }

    /// The least height along `up`.
    pub(super) fn lowest(&self, up: Vec3A) -> f32 {
        self.mesh.lowest(up)
    }
}

/// A scene made ready for rays, for all pictures of it; parts that cannot be drawn are left out.
pub struct World<'a> {
    pub(super) stone: &'a Stone,
    skins: Vec<(Mesh, &'a Painted<'a>)>,
    granules: Granules,
    /// What the substrate is drawn as, and where it is longest.
    pub(super) ground: (Ground, Vec3A),
    finish: Option<&'a dyn Finish>,
    /// The same, if rays go through any place of it.
    pub(super) openings: Option<&'a dyn Finish>,
    pub(super) up: Vec3A,
    /// The diagonal of the box about everything; 1 where there is nothing.
    pub(super) size: f32,
    pub(super) stage: Stage,
}

impl std::fmt::Debug for World<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("World").finish_non_exhaustive()
    }
}

impl<'a> World<'a> {
    /// What it takes is the lichen's: the substrate is ready.
    pub fn new(scene: &Scene<'a>) -> Self {
        let stone = scene.stone;
        let skin = |skin: &'a Painted<'a>| {
            let mut sound = sound_triangles(skin.positions, skin.triangles);
            sound.retain(|&i| skin.is_known(i));
            let corners = |i: u32| corners(skin.positions, skin.triangles[i as usize]);
            (Mesh::new(&sound, 1, corners), skin)
        };
        let skins: Vec<_> = scene.skins.iter().map(skin).collect();
        let granules = Granules::new(scene.discs);
        let meshes = skins.iter().map(|(mesh, _)| mesh.boxed);
        let bounds = union(meshes.chain([stone.mesh.boxed, granules.boxed]));
        let (bounds, size) = measured(bounds);
        let mut world = Self {
            ground: (scene.ground, longest_axis(stone.mesh.boxed)),
            finish: scene.finish,
            openings: scene.finish.filter(|finish| finish.has_openings()),
            stone,
            skins,
            granules,
            up: upward(scene.up),
            size,
            stage: scene.stage.unwrap_or_default(),
        };
        if scene.stage.is_none() {
            world.stage = Stage::new(bounds, world.lowest());
        }
        world
    }

    /// The granules.
    pub(super) fn domes(&self) -> &[Dome] {
        &self.granules.domes
    }

    /// Corners of the substrate's triangles, at most about twelve times `most`, evenly taken.
    pub(super) fn some_corners(&self, most: usize) -> impl Iterator<Item = Vec3A> {
        let step = self.stone.mesh.groups.len() / most + 1;
        let some = self.stone.mesh.groups.iter().step_by(step);
        some.flat_map(Triangles::all_corners)
    }

    /// Triangles of the painted meshes, at most about `most` of each, evenly taken: middle, normal
    /// and area.
    pub(super) fn some_skin(&self, most: usize) -> impl Iterator<Item = (Vec3A, Vec3A, f32)> {
        self.skins.iter().flat_map(move |(mesh, _)| {
            let step = mesh.groups.len() / most + 1;
            mesh.groups.iter().step_by(step).map(|group| {
                let [a, b, c] = group.corners(0);
                let across = (b - a).cross(c - a);
                let middle = (a + b + c) / 3.0;
                (middle, across.normalize_or_zero(), 0.5 * across.length())
            })
        })
    }

    /// The least height of anything along `up`.
    fn lowest(&self) -> f32 {
        let meshes = self.skins.iter().map(|(mesh, _)| mesh);
        let meshes = meshes.chain([&self.stone.mesh]);
        let domes = self.domes().iter().map(|dome| dome.lowest(self.up));
        let lowest = meshes.map(|mesh| mesh.lowest(self.up)).chain(domes);
        lowest.fold(f32::INFINITY, f32::min)
    }

    /// The first thing in the way of a ray.
    pub(super) fn hit(&self, origin: Vec3A, direction: Vec3A) -> Option<Hit> {
        let mut ray = Ray::new(origin, direction);
        let mut first = None;
        if let Some(spot) = self.first_stone(&mut ray) {
            first = Some(Thing::Stone(spot));
        }
        for (k, (mesh, _)) in self.skins.iter().enumerate() {
            if let Some(spot) = mesh.first(&mut ray) {
                first = Some(Thing::Skin(k, spot));
            }
        }
        if let Some(i) = self.granules.first(&mut ray) {
            first = Some(Thing::Dome(i));
        }
        let met = RayEnd {
            end: ray.end,
            place: origin + direction * ray.end,
            direction,
        };
        first.map(|thing| match thing {
            Thing::Stone(spot) => self.stone_hit(&met, &spot),
            Thing::Skin(k, spot) => self.skin_hit(&met, k, &spot),
            Thing::Dome(i) => self.dome_hit(&met, i),
        })
    }

    /// What is in the way of a ray: stone, or lichen, or nothing.
    pub(super) fn in_way(&self, from: &Starts, direction: Vec3A) -> InWay {
        let ray = Ray::new(from.stone, direction);
        if self.stone_blocks(&ray) {
            return InWay::Stone;
        }
        let ray = ray.starting_at(from.lichen);
        let is_met = self.skins.iter().any(|(mesh, _)| mesh.blocks(&ray));
        match is_met || self.granules.blocks(&ray) {
            true => InWay::Lichen,
            false => InWay::Nothing,
        }
    }

    /// Whether the substrate is in the way of a ray.
    pub(super) fn is_behind(&self, origin: Vec3A, direction: Vec3A) -> bool {
        self.stone_blocks(&Ray::new(origin, direction))
    }

    /// Whether the substrate is between two places.
    pub(super) fn is_between(&self, from: Vec3A, to: Vec3A) -> bool {
        let (direction, end) = (to - from).normalize_and_length();
        let mut ray = Ray::new(from, direction);
        ray.end = end;
        self.stone_blocks(&ray)
    }

    fn stone_hit(&self, met: &RayEnd, spot: &Spot) -> Hit {
        let normals = self.stone.normals[spot.number as usize].map(Vec3A::from);
        let facing = Facing::new(spot, met, normals);
        let off = facing.flat * (CLEAR * self.stage.size);
        let starts = Starts {
            lichen: facing.place + off,
            stone: facing.place + off + facing.lift(&spot.corners),
        };
        let number = self.stone.number(spot);
        let coat = |finish: &dyn Finish| finish.at(number, spot.weights, facing.smooth.to_array());
        let (normal, material) = match self.finish.and_then(coat) {
            Some(Coat { albedo, normal }) => (normal.into(), Material::Own(albedo.into())),
            None => (facing.smooth, Material::Ground),
        };
        Hit {
            end: met.end,
            place: facing.place,
            normal,
            horizon: facing.smooth,
            material,
            starts,
        }
    }

    fn skin_hit(&self, met: &RayEnd, k: usize, spot: &Spot) -> Hit {
        let (_, skin) = &self.skins[k];
        let corners = skin.triangles[spot.number as usize].map(|c| c as usize);
        let normals = corners.map(|c| Vec3A::from_array(skin.normals[c]));
        let facing = Facing::new(spot, met, normals);
        let colors = corners.map(|c| color::linear(skin.colors[c]));
        let grain = skin.grain;
        let (mut normal, mut color) = (facing.smooth, facing.mean(colors));
        if let Some(structure) = skin.structure {
            let feet = skin.triangles[spot.number as usize].map(|vertex| structure.foot(vertex));
            let place = match feet {
                [Some(a), Some(b), Some(c)] => facing.mean([a, b, c].map(Vec3A::from_array)),
                _ => facing.place,
            };
            let detail = structure.at(place.to_array(), normal.to_array());
            color = color * detail.shade + Vec3A::from(detail.cover);
            normal = (normal - Vec3A::from(detail.slope)).normalize_or(normal);
        }
        Hit {
            end: met.end,
            place: facing.place,
            normal,
            horizon: facing.smooth,
            material: Material::Lichen {
                color,
                grain,
                is_structured: skin.structure.is_some(),
            },
            starts: (facing.place + facing.flat * (CLEAR * self.stage.size)).into(),
        }
    }

    fn dome_hit(&self, met: &RayEnd, i: u32) -> Hit {
        let dome = &self.domes()[i as usize];
        let place = met.place;
        let (p, normal) = (place - dome.center(), dome.normal());
        let tall = normal * p.dot(normal);
        let out = ((p - tall) + tall / (HEIGHT * HEIGHT)).normalize_or_zero();
        let flat = towards(out, met);
        let clear = (0.03 * dome.radius).max(2e-6 * self.stage.size);
        Hit {
            end: met.end,
            place,
            normal: (flat + 0.35 * normal).normalize_or_zero(),
            horizon: flat,
            material: Material::Lichen {
                color: dome.albedo(),
                grain: 0.0,
                is_structured: false,
            },
            starts: (place + flat * clear).into(),
        }
    }
}

/// What hides a place from a light.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum InWay {
    Nothing,
    Stone,
    Lichen,
}

/// What a ray meets.
enum Thing {
    Stone(Spot),
    /// Of this painted mesh.
    Skin(usize, Spot),
    /// By its number.
    Dome(u32),
}

/// A place on a triangle.
pub(super) struct Spot {
    /// The triangle's number.
    pub(super) number: u32,
    corners: [Vec3A; 3],
    /// Of the corners.
    pub(super) weights: [f32; 3],
}

/// A ray where it met something.
struct RayEnd {
    end: f32,
    place: Vec3A,
    direction: Vec3A,
}

impl Mesh {
    /// Of the triangles with these numbers. Their corners are asked for time and again, for to keep them would
    /// take more memory than all that is made of them.
    ///
    /// The tree is over each so many, 1 or [`WIDTH`], which lie together where they come one after the other:
    /// over fours it takes a quarter of the memory and of the time.
    fn new(numbers: &[u32], together: usize, corners: impl Fn(u32) -> [Vec3A; 3] + Sync) -> Self {
        let box_of = |some: &[u32]| {
            let boxes = some.iter().map(|&number| triangle_box(&corners(number)));
            boxes.reduce(|a, b| a.union(&b)).unwrap_or_default()
        };
        let boxes: Vec<Aabb> = numbers.par_chunks(together).map(box_of).collect();
        let boxed = extent(&boxes);
        let (tree, groups) = Tree::grouped(&boxes, WIDTH / together);
        drop(boxes);
        let of = |group: &Group| {
            let place = |lane: usize| together * group[lane / together] as usize + lane % together;
            let number = |lane| numbers[place(lane).min(numbers.len() - 1)];
            let four = std::array::from_fn(number);
            Triangles::new(four, four.map(&corners))
        };
        Self {
            groups: groups.par_iter().map(of).collect(),
            boxed,
            tree,
        }
    }

    /// Where a ray meets it first, and to where it is cut.
    pub(super) fn first(&self, ray: &mut Ray) -> Option<Spot> {
        let mut first = None;
        self.tree.meet(ray, |ray, group| {
            if let Some(touch) = self.groups[group].first(ray) {
                ray.end = touch.at;
                first = Some((group, touch));
            }
        });
        first.map(|(group, touch)| {
            let [u, v] = touch.weights;
            Spot {
                number: self.groups[group].numbers[touch.lane],
                corners: self.groups[group].corners(touch.lane),
                weights: [1.0 - u - v, u, v],
            }
        })
    }

    pub(super) fn blocks(&self, ray: &Ray) -> bool {
        let is_met = |ray: &Ray, group: usize| self.groups[group].block(ray);
        self.tree.any(ray, is_met)
    }

    fn lowest(&self, up: Vec3A) -> f32 {
        let corners = self.groups.iter().flat_map(Triangles::all_corners);
        corners.map(|p| p.dot(up)).fold(f32::INFINITY, f32::min)
    }
}

impl Granules {
    fn new(discs: &[Disc]) -> Self {
        let domes: Vec<Dome> = discs.iter().filter_map(Dome::new).collect();
        let boxes: Vec<Aabb> = domes.par_iter().map(Dome::bounds).collect();
        let (tree, groups) = Tree::new(&boxes);
        let boxed = extent(&boxes);
        drop(boxes);
        let of = |&group: &Group| Domes::new(group, group.map(|i| domes[i as usize]));
        Self {
            groups: groups.par_iter().map(of).collect(),
            boxed,
            tree,
            domes,
        }
    }

    /// The number of the one that a ray meets first, to which it is cut.
    fn first(&self, ray: &mut Ray) -> Option<u32> {
        let mut first = None;
        self.tree.meet(ray, |ray, group| {
            if let Some((at, number)) = self.groups[group].first(ray) {
                ray.end = at;
                first = Some(number);
            }
        });
        first
    }

    fn blocks(&self, ray: &Ray) -> bool {
        let is_met = |ray: &Ray, group: usize| self.groups[group].block(ray);
        self.tree.any(ray, is_met)
    }
}

impl Painted<'_> {
    /// Whether the corners of a triangle have normals and colours.
    pub(super) fn is_known(&self, triangle: u32) -> bool {
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
    fn new(spot: &Spot, met: &RayEnd, normals: [Vec3A; 3]) -> Self {
        let weights = spot.weights;
        let [a, b, c] = spot.corners;
        let flat = towards((b - a).cross(c - a).normalize_or_zero(), met);
        let normals = normals.map(|n| if n.dot(flat) < 0.0 { -n } else { n });
        let smooth = weighted(weights, normals).normalize_or(flat);
        Self {
            place: met.place,
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
    fn lift(&self, corners: &[Vec3A; 3]) -> Vec3A {
        let mut corners = corners.iter();
        let lifts = self.normals.map(|n| {
            let below = (self.place - corners.next().unwrap_or(&self.place)).dot(n);
            n * -below.min(0.0)
        });
        self.mean(lifts)
    }
}

fn weighted(weights: [f32; 3], values: [Vec3A; 3]) -> Vec3A {
    values[0] * weights[0] + values[1] * weights[1] + values[2] * weights[2]
}

/// The direction, or its opposite, against the ray.
fn towards(direction: Vec3A, met: &RayEnd) -> Vec3A {
    match direction.dot(met.direction) > 0.0 {
        true => -direction,
        false => direction,
    }
}

/// The numbers of the triangles that have an area.
pub(super) fn sound_triangles(places: &[[f32; 3]], triangles: &[[u32; 3]]) -> Vec<u32> {
    let exist = |t: &[u32; 3]| t.iter().all(|&i| (i as usize) < places.len());
    let has_area = |t: [u32; 3]| {
        let [a, b, c] = corners(places, t);
        let area = (b - a).cross(c - a).length();
        area.is_finite() && area > 0.0
    };
    let sound = |(i, t): (usize, &[u32; 3])| (exist(t) && has_area(*t)).then_some(i as u32);
    triangles.par_iter().enumerate().filter_map(sound).collect()
}

/// The corners of a triangle.
pub(super) fn corners(places: &[[f32; 3]], triangle: [u32; 3]) -> [Vec3A; 3] {
    triangle.map(|i| Vec3A::from_array(places[i as usize]))
}

/// The box about boxes, turned inside out where there are none.
fn extent(boxes: &[Aabb]) -> [Vec3A; 2] {
    union(boxes.iter().map(|b| [b.min, b.max]))
}

pub(super) fn union(boxes: impl Iterator<Item = [Vec3A; 2]>) -> [Vec3A; 2] {
    let nothing = [Vec3A::INFINITY, Vec3A::NEG_INFINITY];
    boxes.fold(nothing, |[a, b], [c, d]| [a.min(c), b.max(d)])
}

#[cfg(test)]
mod tests {
    use super::super::sample::{hash, unit};
    use super::*;

    /// Numbers from -1 to 1, in order.
    fn place(at: u32) -> Vec3A {
        let number = |axis| 2.0 * unit(hash(3 * at + axis)) - 1.0;
        Vec3A::new(number(0), number(1), number(2))
    }

    #[test]
    fn fours_of_triangles_stop_the_same_rays_at_the_same_places() {
        let triangle = |i: u32| {
            let middle = place(4 * i);
            [1, 2, 3].map(|k| middle + 0.2 * place(4 * i + k))
        };
        let mut met = 0;
        for count in [1, 2, 3, 4, 5, 7, 40, 2001] {
            let numbers: Vec<u32> = (0..count).map(|i| 2 * i + 1).collect();
            let [alone, by_fours] = [1, WIDTH].map(|n| Mesh::new(&numbers, n, triangle));
            assert_eq!(alone.boxed, by_fours.boxed);
            for i in 0..500 {
                let origin = 2.0 * place(9000 + 2 * i);
                let direction = (place(9001 + 2 * i) - origin).normalize();
                let ray = Ray::new(origin, direction);
                assert_eq!(alone.blocks(&ray), by_fours.blocks(&ray));
                let [one, other] = [&alone, &by_fours].map(|mesh| {
                    let mut ray = ray.clone();
                    mesh.first(&mut ray).map(|spot| (spot.number, ray.end))
                });
                assert_eq!(one, other, "{count}");
                met += usize::from(one.is_some());
            }
        }
        assert!(met > 500, "{met}");
    }
}
