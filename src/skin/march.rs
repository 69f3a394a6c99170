//! From the field over the surface to a closed mesh: marching triangles.
//!
//! The lichen's outline is cut out of the surface where the level is 0. What is inside is drawn
//! twice, on the upper side at the field's height and on the underside just beneath the substrate,
//! and both sides share the vertices of the outline. Where the surface ends under lichen, as at the
//! border of an open mesh, a wall joins them. So each edge has two triangles, whatever the substrate
//! looks like.

use std::borrow::Borrow;

use glam::{DVec3, Vec3};
use rayon::prelude::*;

use super::base::{Face, NONE};
use super::cortex::Dress;
use super::cover::{Cover, Roof};
use super::field::{Attributes, Field, Sample};
use super::refine::{ALL, Tree, side_key, sides};
use super::sheet::Sheet;

/// How near to a corner the outline may cross a side, as a share of it: keeps vertices apart.
const APART: f32 = 0.02;

/// Places that one task samples.
const BATCH: usize = 1024;

/// Vertices that are made before they are put in their order.
const AT_ONCE: usize = 1 << 16;

/// A mesh in local units, with the field's attributes for each vertex.
#[derive(Debug, Default)]
pub(super) struct Marched {
    pub(super) positions: Vec<DVec3>,
    pub(super) normals: Vec<Vec3>,
    pub(super) attributes: Vec<Attributes>,
    pub(super) triangles: Vec<[u32; 3]>,
}

/// The level at every vertex of the tree, and what the field says where it is positive.
pub(super) struct Samples<'a> {
    levels: &'a [f32],
    /// Of every vertex, or of those inside, in their order.
    told: &'a [Sample],
    /// For each vertex its place among those inside; [`NONE`] outside.
    rank: Vec<u32>,
    /// The vertices that are inside, ascending.
    inside: Vec<u32>,
}

/// The iso-surface of a field over a surface, on an underside so deep, in local units; without what is
/// beneath others.
pub(super) fn march(
    field: &Field,
    tree: &Tree,
    underside: f64,
    dress: Option<Dress>,
    above: &[Cover],
) -> Marched {
    let roof = Roof::new(field.substrate, above);
    let (levels, inside) = sample_all(field, tree, &roof);
    let leaves = tree.leaves(|leaf| is_touched(leaf, &levels));
    let leaves: Vec<&Face> = leaves.iter().collect();
    let samples = Samples::new(&levels, &inside, &leaves);
    let read = |place: DVec3, [inner, _]: [u32; 2], sheet: &mut Sheet| {
        let home = tree.homes[inner as usize];
        let facing = field.substrate.normal(home).as_vec3();
        let sample = field.sample(place, home, facing, sheet);
        roof.cut(sample, place, home, facing)
    };
    let cross = |sides| Outline::default().moved(field, tree, &samples, sides, &|_, _| true, &read);
    close(tree, ALL, &leaves, &samples, underside, dress, cross).0
}

/// The closed mesh of these samples, dressed, for a lichen of so many elements, which touches these
/// leaves of the tree, with the outline that `cross` makes of the sides that it crosses.
pub(super) fn close(
    tree: &Tree,
    elements: u32,
    leaves: &[&Face],
    samples: &Samples,
    underside: f64,
    dress: Option<Dress>,
    cross: impl FnOnce(Vec<u64>) -> Outline,
) -> (Marched, Outline) {
    let outline = cross(crossed_sides(samples, leaves));
    let needed = leaves.par_iter().copied();
    let needed = needed.filter(|f| !samples.covers(f) || f.open != 0);
    let needed: Vec<&Face> = needed.collect();
    let below = tree.coarsened(elements, &needed, |f| samples.touches(f));
    let mut weaver = Weaver::new(tree, samples, &outline, underside);
    weaver.add_upper(dress);
    weaver.add_outline(dress);
    weaver.number_underside(&below);
    let mut triangles = weaver.woven(leaves, Weaver::upper);
    triangles.extend(weaver.woven(&below, Weaver::under));
    let mesh = Marched {
        triangles: triangles.concat(),
        ..weaver.mesh
    };
    (mesh, outline)
}

/// Whether the level is positive at a corner.
pub(super) fn is_touched(face: &Face, levels: &[f32]) -> bool {
    face.corners.iter().any(|&v| levels[v as usize] > 0.0)
}

/// The sides between an inner and an outer vertex, ascending.
fn crossed_sides(samples: &Samples, leaves: &[&Face]) -> Vec<u64> {
    let crossed = |face: &&Face| {
        let face = **face;
        let mixed = |&(a, b): &(u32, u32)| samples.is_inside(a) != samples.is_inside(b);
        let sides = sides(&face).into_iter().filter(mixed);
        sides.map(|(a, b)| side_key(a.min(b), a.max(b)))
    };
    let mut sides: Vec<u64> = leaves.par_iter().flat_map_iter(crossed).collect();
    sides.par_sort_unstable();
    sides.dedup();
    sides
}

impl<'a> Samples<'a> {
    /// Of a level for each vertex, and a sample for each, or for each with a positive level. Only the
    /// corners of these leaves can be inside.
    pub(super) fn new(levels: &'a [f32], told: &'a [Sample], leaves: &[&Face]) -> Self {
        let mut corner = vec![false; levels.len()];
        for &v in leaves.iter().flat_map(|leaf| &leaf.corners) {
            corner[v as usize] = true;
        }
        let is_inside = |&v: &u32| corner[v as usize] && levels[v as usize] > 0.0;
        let inside: Vec<u32> = (0..levels.len() as u32).filter(is_inside).collect();
        let mut rank = vec![NONE; levels.len()];
        for (number, &v) in inside.iter().enumerate() {
            rank[v as usize] = number as u32;
        }
        Self {
            levels,
            told,
            rank,
            inside,
        }
    }

    /// Of a vertex that is inside.
    fn sample(&self, vertex: u32) -> &Sample {
        match self.told.len() == self.levels.len() {
            true => &self.told[vertex as usize],
            false => &self.told[self.rank[vertex as usize] as usize],
        }
    }

    fn is_inside(&self, vertex: u32) -> bool {
        self.rank[vertex as usize] != NONE
    }

    /// Whether some of a triangle is under lichen.
    fn touches(&self, face: &Face) -> bool {
        face.corners.iter().any(|&v| self.is_inside(v))
    }

    /// Whether all of a triangle is.
    fn covers(&self, face: &Face) -> bool {
        face.corners.iter().all(|&v| self.is_inside(v))
    }
}

/// The level at each vertex, and the samples of those where it is positive. It is negative beneath others.
fn sample_all(field: &Field, tree: &Tree, roof: &Roof) -> (Vec<f32>, Vec<Sample>) {
    let batches = tree
        .positions
        .par_chunks(BATCH)
        .zip(tree.homes.par_chunks(BATCH));
    let batch = |sheet: &mut Sheet, (positions, homes): (&[DVec3], &[u32])| {
        let (mut levels, mut inside) = (Vec::with_capacity(positions.len()), Vec::new());
        for (&p, &home) in positions.iter().zip(homes) {
            let facing = field.substrate.normal(home).as_vec3();
            let sample = field.sample(p, home, facing, sheet);
            let sample = roof.cut(sample, p, home, facing);
            levels.push(sample.level);
            if sample.level > 0.0 {
                inside.push(sample);
            }
        }
        (levels, inside)
    };
    let sheet = || Sheet::new(field.substrate, field.lichen.radius);
    let batches: Vec<_> = batches.map_init(sheet, batch).collect();
    let (mut levels, mut inside) = (Vec::new(), Vec::new());
    for (more_levels, more_inside) in batches {
        levels.extend(more_levels);
        inside.extend(more_inside);
    }
    (levels, inside)
}

/// Where the outline crosses sides.
#[derive(Default)]
pub(super) struct Outline {
    /// The sides, ascending.
    sides: Vec<u64>,
    /// For each vertex the first of the sides whose lower end it is, and their number at the end.
    starts: Vec<u32>,
    crossings: Vec<Told>,
}

/// A place of the surface and what the field says there.
type Told = (DVec3, Sample);

/// Reads the field between the ends of a side: the inner one is told, and the nearer one.
pub(super) type Read<'s, 'a> = dyn Fn(DVec3, [u32; 2], &mut Sheet<'s>) -> Sample + Sync + 'a;

impl Outline {
    /// The outline across these sides, where this one's crossings serve as far as nothing has
    /// `changed` between the ends, and the others are read.
    pub(super) fn moved<'s>(
        &self,
        field: &Field<'s>,
        tree: &Tree,
        samples: &Samples,
        sides: Vec<u64>,
        changed: &(dyn Fn(u32, u32) -> bool + Sync),
        read: &Read<'s, '_>,
    ) -> Self {
        let sheet = || Sheet::new(field.substrate, field.lichen.radius);
        let cross = |sheet: &mut Sheet<'s>, side: &u64| {
            let [a, b] = [(*side >> 32) as u32, *side as u32];
            match self.find(a, b) {
                Some(known) if !changed(a, b) => self.crossings[known as usize],
                _ => cross(tree, samples, [a, b], |place, ends| {
                    read(place, ends, sheet)
                }),
            }
        };
        let crossings = sides.par_iter().map_init(sheet, cross).collect();
        let mut starts = vec![0; tree.positions.len() + 1];
        sides
            .iter()
            .for_each(|side| starts[(side >> 32) as usize + 1] += 1);
        (1..starts.len()).for_each(|v| starts[v] += starts[v - 1]);
        Self {
            sides,
            starts,
            crossings,
        }
    }

    /// The number of the crossing of a side, the lower end first, if it has one.
    fn find(&self, a: u32, b: u32) -> Option<u32> {
        let &[first, end] = self.starts.get(a as usize..a as usize + 2)? else {
            return None;
        };
        (first..end).find(|&i| self.sides[i as usize] as u32 == b)
    }

    /// The number of the crossing of a side that has one.
    fn number(&self, a: u32, b: u32) -> u32 {
        self.find(a.min(b), a.max(b)).unwrap_or(NONE)
    }
}

/// Where the outline crosses the side between two vertices.
fn cross(
    tree: &Tree,
    samples: &Samples,
    ends: [u32; 2],
    mut read: impl FnMut(DVec3, [u32; 2]) -> Sample,
) -> Told {
    let [mut a, mut b] = ends;
    if samples.levels[a as usize] <= 0.0 {
        (a, b) = (b, a);
    }
    let levels = [a, b].map(|v| samples.levels[v as usize]);
    let [inner, outer] = [a, b].map(|v| tree.positions[v as usize]);
    crossing(levels, |share| {
        let place = inner.lerp(outer, f64::from(share));
        let nearer = if share <= 0.5 { a } else { b };
        (place, read(place, [a, nearer]))
    })
}

/// The place between an inner and an outer end of these levels where the level is about 0.
///
/// The level falls as the square of the distance, so a straight line between the ends misses by
/// more the longer the side is, and the outline would be jagged: two steps of the method of false
/// position mend it.
fn crossing([mut inner, mut outer]: [f32; 2], mut sampled: impl FnMut(f32) -> Told) -> Told {
    const STEPS: usize = 2;
    let (mut low, mut high) = (0.0, 1.0);
    let within = |share: f32| share.clamp(APART, 1.0 - APART);
    let mut share = within(inner / (inner - outer));
    for _ in 0..STEPS {
        let level = sampled(share).1.level;
        match level > 0.0 {
            true => (low, inner) = (share, level),
            false => (high, outer) = (share, level),
        }
        share = within(low + (high - low) * inner / (inner - outer));
    }
    sampled(share)
}

/// Puts the mesh together: vertices of the upper side, of the outline, of the underside.
struct Weaver<'a> {
    tree: &'a Tree,
    samples: &'a Samples<'a>,
    outline: &'a Outline,
    /// For each vertex of the tree its number on the underside.
    under: Vec<u32>,
    underside: f64,
    mesh: Marched,
}

/// The part of a triangle that is inside: three or four corners, and which of its sides lie on
/// open edges of the surface.
struct Part {
    corners: [Corner; 4],
    open: [bool; 4],
    count: usize,
}

#[derive(Clone, Copy)]
enum Corner {
    Vertex(u32),
    Crossing(u32),
}

impl<'a> Weaver<'a> {
    fn new(tree: &'a Tree, samples: &'a Samples<'a>, outline: &'a Outline, underside: f64) -> Self {
        Self {
            tree,
            samples,
            outline,
            under: vec![NONE; tree.positions.len()],
            underside,
            mesh: Marched::default(),
        }
    }

    fn add_upper(&mut self, dress: Option<Dress>) {
        self.mesh.reserve(2 * self.samples.inside.len());
        let told = |v: &u32| {
            let place = self.tree.positions[*v as usize];
            dressed(dress, place, self.samples.sample(*v))
        };
        for batch in self.samples.inside.chunks(AT_ONCE) {
            let batch: Vec<Told> = batch.par_iter().map(told).collect();
            for (place, sample) in batch {
                let place = place + sample.up.as_dvec3() * f64::from(sample.height);
                self.mesh.add(place, sample.normal, sample.attributes);
            }
        }
    }

    fn add_outline(&mut self, dress: Option<Dress>) {
        let told = |(place, sample): &Told| dressed(dress, *place, sample);
        let crossings: Vec<Told> = self.outline.crossings.par_iter().map(told).collect();
        for (place, sample) in crossings {
            // At the outline the height is 0, and the iso-surface stands upright.
            let Sample { normal, up, .. } = sample;
            let flat = (normal - up * normal.dot(up)).try_normalize();
            self.mesh
                .add(place, flat.unwrap_or(normal), sample.attributes);
        }
    }

    fn number_underside(&mut self, faces: &[Face]) {
        for &v in faces.iter().flat_map(|face| &face.corners) {
            if !self.samples.is_inside(v) || self.under[v as usize] != NONE {
                continue;
            }
            let sample = self.samples.sample(v);
            let place = self.tree.positions[v as usize];
            let place = place - sample.up.as_dvec3() * self.underside;
            self.under[v as usize] = self.mesh.positions.len() as u32;
            self.mesh.add(place, -sample.up, sample.attributes);
        }
    }

    /// The triangles of all faces, in their order, by batches.
    fn woven<F: Borrow<Face> + Sync>(
        &self,
        faces: &[F],
        weave: fn(&Self, &Face, &mut Vec<[u32; 3]>),
    ) -> Vec<Vec<[u32; 3]>> {
        let batch = |faces: &[F]| {
            let mut triangles = Vec::with_capacity(2 * faces.len());
            let faces = faces.iter().map(Borrow::borrow);
            faces.for_each(|face| weave(self, face, &mut triangles));
            triangles
        };
        faces.par_chunks(BATCH).map(batch).collect()
    }

    fn upper(&self, face: &Face, triangles: &mut Vec<[u32; 3]>) {
        let part = self.part(face);
        let number = |corner| self.upper_number(corner);
        self.fill(part.corners.map(number), part.count, triangles);
        for k in 0..part.count {
            if part.open[k] {
                let (a, b) = (part.corners[k], part.corners[(k + 1) % part.count]);
                self.wall(a, b, triangles);
            }
        }
    }

    fn under(&self, face: &Face, triangles: &mut Vec<[u32; 3]>) {
        let part = self.part(face);
        let mut corners = part.corners.map(|corner| self.under_number(corner));
        corners[..part.count].reverse();
        self.fill(corners, part.count, triangles);
    }

    /// Closes the gap between both sides along an open edge.
    fn wall(&self, a: Corner, b: Corner, triangles: &mut Vec<[u32; 3]>) {
        let [au, bu] = [a, b].map(|c| self.upper_number(c));
        let [al, bl] = [a, b].map(|c| self.under_number(c));
        if bu != bl {
            triangles.push([bu, au, bl]);
        }
        if au != al {
            triangles.push([au, al, bl]);
        }
    }

    fn fill(&self, [a, b, c, d]: [u32; 4], count: usize, triangles: &mut Vec<[u32; 3]>) {
        if count == 3 {
            triangles.push([a, b, c]);
            return;
        }
        let distance_sq = |i: u32, j: u32| {
            let places = &self.mesh.positions;
            (places[i as usize] - places[j as usize]).length_squared()
        };
        let halves = match distance_sq(a, c) <= distance_sq(b, d) {
            true => [[a, b, c], [a, c, d]],
            false => [[a, b, d], [b, c, d]],
        };
        triangles.extend(halves);
    }

    fn upper_number(&self, corner: Corner) -> u32 {
        match corner {
            Corner::Vertex(v) => self.samples.rank[v as usize],
            Corner::Crossing(c) => self.samples.inside.len() as u32 + c,
        }
    }

    fn under_number(&self, corner: Corner) -> u32 {
        match corner {
            Corner::Vertex(v) => self.under[v as usize],
            Corner::Crossing(_) => self.upper_number(corner),
        }
    }

    fn part(&self, face: &Face) -> Part {
        let inside = face.corners.map(|v| self.samples.is_inside(v));
        let count = inside.iter().filter(|i| **i).count();
        // Turned so that the corner that differs from the others comes first.
        let odd = (0..3).find(|&k| inside[k] == (count == 1)).unwrap_or(0);
        let at = |k: usize| (odd + k) % 3;
        let v = [0, 1, 2].map(|k| face.corners[at(k)]);
        let [o0, o1, o2] = [0, 1, 2].map(|k| face.open >> at(k) & 1 == 1);
        let vertex = Corner::Vertex;
        let cross = |a: u32, b: u32| Corner::Crossing(self.outline.number(a, b));
        match count {
            3 => Part {
                corners: [vertex(v[0]), vertex(v[1]), vertex(v[2]), vertex(v[2])],
                open: [o0, o1, o2, false],
                count: 3,
            },
            1 => {
                let [first, last] = [cross(v[0], v[1]), cross(v[2], v[0])];
                Part {
                    corners: [vertex(v[0]), first, last, last],
                    open: [o0, false, o2, false],
                    count: 3,
                }
            }
            _ => Part {
                corners: [
                    cross(v[0], v[1]),
                    vertex(v[1]),
                    vertex(v[2]),
                    cross(v[2], v[0]),
                ],
                open: [o0, o1, o2, false],
                count: 4,
            },
        }
    }
}

fn dressed(dress: Option<Dress>, place: DVec3, sample: &Sample) -> Told {
    let sample = dress.map_or(*sample, |dress| dress.sample(place, sample));
    (place, sample)
}

impl Marched {
    fn reserve(&mut self, vertices: usize) {
        self.positions.reserve(vertices);
        self.normals.reserve(vertices);
        self.attributes.reserve(vertices);
    }

    fn add(&mut self, place: DVec3, normal: Vec3, attributes: Attributes) {
        self.positions.push(place);
        self.normals.push(normal);
        self.attributes.push(attributes);
    }
}
