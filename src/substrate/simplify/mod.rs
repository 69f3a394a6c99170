//! Fewer triangles for nearly the same surface.
//!
//! Vertices move onto neighbours, those first that stray least from the planes of the triangles
//! that they stood for: Garland & Heckbert, *Surface Simplification Using Quadric Error Metrics*
//! (1997), with half-edge collapses only, so that the vertices left are some of the given ones.
//! We depart from the paper in four ways.
//!
//! - Not from a heap but in passes, in the manner of meshoptimizer: each takes the cheapest vertices,
//!   in order of cost where they are few, and leaves alone until the next pass what a collapse has
//!   changed. Before that all goes, in the order of memory, that strays by a share of the error only.
//! - A collapse costs the mean, weighted by area, of the squared distances to the planes that the
//!   *moving* vertex stands for; so a spike on a large plane is not averaged away.
//! - The error allowed limits that, and besides the sum of steps: each vertex knows how far the
//!   vertices that went into it have strayed at most, and a collapse adds the distance from the
//!   vertex that goes to the triangles that it leaves behind. Vertices nearby are pulled along
//!   unaccounted: measured over the whole, given vertices lie within twice the error.
//! - Large meshes are cut into parts that lie together in memory, and these simplified each by itself,
//!   on all threads, before what is left is cut anew. Vertices that two parts share stay meanwhile, and
//!   nothing moves onto them: so all that is kept is kept as if there were no parts.
//!
//! What is kept: the pieces, their Euler characteristic and borders (the link condition), vertices
//! at edges of more than two triangles, and the sense of every triangle; no sliver, no sharp fold
//! and no crowd of triangles about one vertex comes to be. Border vertices move along the border,
//! and vertices on an edge sharper than 100° along that.
//! What is not: two sheets may come to cross each other where they lie closer than twice the error.
//!
//! The result decides walks: it is the same to the last bit on every machine.

mod checks;
mod numbers;
mod passes;
mod quadric;
mod surface;
#[cfg(test)]
mod tests;

use glam::DVec3;
use rayon::prelude::*;

use checks::larger;
use numbers::Numbers;
pub(super) use passes::Limits;
use passes::{Part, Simplifier, Vertex};
use quadric::Quadric;
use surface::{Kind, Surface, valid};

/// Weight of the planes that stand on the border, against triangles of that side.
const BORDER: f64 = 4.0;

/// Triangles of a part: with all that is known of them they fit into a second-level cache.
const PART: usize = 1 << 15;

/// What strays by less than this share of the error goes first, whatever is cheapest: to ask for that takes
/// longer, and leaves only one in forty triangles fewer.
const THIN: f64 = 0.5;

/// A simplified mesh.
pub(super) struct Simplified {
    /// Corners are numbers of the given vertices.
    pub(super) triangles: Vec<[u32; 3]>,
    /// For each, the number of the given triangle that it comes from.
    pub(super) source: Vec<u32>,
    /// For each given vertex, the one that it went into: itself where it stayed.
    pub(super) onto: Vec<u32>,
    /// How far vertices have strayed at most; not more than the error allowed.
    pub(super) error: f64,
}

/// Collapses edges until the next would stray farther than the limits say, or leave fewer triangles.
///
/// Triangles that repeat a corner, or have one that is not there, are left out.
pub(super) fn simplify(vertices: &[DVec3], triangles: &[[u32; 3]], limits: Limits) -> Simplified {
    simplify_in_parts(vertices, triangles, limits, PART)
}

/// The same with parts of about so many triangles.
fn simplify_in_parts(
    vertices: &[DVec3],
    triangles: &[[u32; 3]],
    limits: Limits,
    part: usize,
) -> Simplified {
    let mut whole = Whole::new(vertices, triangles);
    let limits = Limits {
        most_error: larger(0.0, limits.most_error),
        ..limits
    };
    if !limits.at_once {
        let thin = Limits {
            most_error: THIN * limits.most_error,
            at_once: true,
            ..limits
        };
        whole.round(part, &thin);
    }
    let mut shrinks = true;
    while shrinks && whole.parts(part) > 1 {
        let before = whole.triangles.len();
        whole.round(part, &limits);
        shrinks = 2 * whole.triangles.len() <= before;
    }
    whole.round(usize::MAX, &limits);
    whole.finish()
}

/// The mesh from round to round.
struct Whole<'a> {
    places: &'a [DVec3],
    triangles: Vec<[u32; 3]>,
    /// The number of each in the given list.
    source: Vec<u32>,
    known: Known,
    /// The vertex that each has gone into, itself where it is still there.
    onto: Vec<u32>,
}

/// What is known of the vertices that have been in a part so far.
struct Known {
    /// Where each is in the list, or nowhere.
    slots: Vec<u32>,
    vertices: Vec<Vertex>,
    /// Whether the triangles about each inner vertex all run the same way round, so that each of its
    /// neighbours is the first in one of them. Collapses leave that so.
    run_alike: bool,
}

impl<'a> Whole<'a> {
    fn new(places: &'a [DVec3], given: &[[u32; 3]]) -> Self {
        let (triangles, source) = valid(places.len(), given);
        Self {
            places,
            triangles,
            source,
            known: Known::none(places.len()),
            onto: (0..places.len() as u32).collect(),
        }
    }

    /// How many parts of so many triangles there are.
    fn parts(&self, part: usize) -> usize {
        (self.triangles.len() / part).max(1)
    }

    /// Simplifies each part of about so many triangles by itself.
    fn round(&mut self, part: usize, limits: &Limits) {
        let all = self.triangles.len();
        let part = all.div_ceil(self.parts(part)).max(1);
        let shared = self.shared(part);
        self.know_shared(&shared);
        let parts = self.triangles.par_chunks(part);
        let simplified: Vec<_> = parts
            .map(|triangles| {
                let limits = limits.of_part(triangles.len(), all);
                self.simplified_part(triangles, &shared, &limits)
            })
            .collect();
        let source = std::mem::take(&mut self.source);
        self.triangles.clear();
        for (part, source) in simplified.into_iter().zip(source.chunks(part)) {
            self.triangles.extend(part.triangles);
            let numbers = part.source.iter().map(|&t| source[t as usize]);
            self.source.extend(numbers);
            self.known.run_alike &= part.run_alike;
            for (v, vertex) in part.left {
                self.known.put(v, vertex);
            }
            for [from, onto] in part.gone {
                self.onto[from as usize] = onto;
            }
        }
    }

    /// Looks at the vertices that are shared and have not been in a part: no part has all triangles about them.
    fn know_shared(&mut self, shared: &[bool]) {
        let is_new = |v: &u32| shared[*v as usize] && self.known.get(*v).is_none();
        let about = self.triangles.iter().filter(|t| t.iter().any(&is_new));
        let about: Vec<[u32; 3]> = about.copied().collect();
        if about.is_empty() {
            return;
        }
        let mut new: Vec<u32> = about.as_flattened().to_vec();
        new.retain(is_new);
        new.sort_unstable();
        new.dedup();
        let surface = Surface::new(self.places, about);
        for v in new {
            let (vertex, is_turned) = first_look(&surface, v);
            self.known.run_alike &= !is_turned;
            self.known.put(v, vertex);
        }
    }

    /// The part with these triangles, simplified.
    fn simplified_part(&self, triangles: &[[u32; 3]], shared: &[bool], limits: &Limits) -> Part {
        let numbers = Numbers::of(triangles.as_flattened());
        let all: Vec<u32> = numbers.iter().collect();
        let places: Vec<DVec3> = all.iter().map(|&v| self.places[v as usize]).collect();
        let triangles = triangles.iter().map(|t| t.map(|v| numbers.place(v)));
        let surface = Surface::new(&places, triangles.collect());
        let mut run_alike = self.known.run_alike;
        let vertices = (0..).zip(&all).map(|(place, &v)| {
            let vertex = self.known.get(v).copied().unwrap_or_else(|| {
                let (vertex, is_turned) = first_look(&surface, place);
                run_alike &= !is_turned;
                vertex
            });
            let stays = shared[v as usize];
            Vertex { stays, ..vertex }
        });
        let vertices = vertices.collect();
        let mut simplifier = Simplifier::new(surface, vertices, run_alike, *limits);
        while simplifier.pass() {}
        simplifier.finish(&all)
    }

    /// Which vertices are corners of several parts.
    fn shared(&self, part: usize) -> Vec<bool> {
        let mut owners = vec![u32::MAX; self.places.len()];
        let mut shared = vec![false; self.places.len()];
        for (number, triangles) in (0..).zip(self.triangles.chunks(part)) {
            for &v in triangles.as_flattened() {
                let owner = &mut owners[v as usize];
                shared[v as usize] |= *owner != u32::MAX && *owner != number;
                *owner = number;
            }
        }
        shared
    }

    fn finish(mut self) -> Simplified {
        for v in 0..self.onto.len() {
            let mut w = self.onto[v];
            while self.onto[w as usize] != w {
                w = self.onto[w as usize];
            }
            self.onto[v] = w;
        }
        Simplified {
            triangles: self.triangles,
            source: self.source,
            onto: self.onto,
            error: self
                .known
                .vertices
                .iter()
                .map(|v| v.strayed)
                .fold(0.0, larger),
        }
    }
}

impl Known {
    const NOWHERE: u32 = u32::MAX;

    fn none(vertices: usize) -> Self {
        Self {
            slots: vec![Self::NOWHERE; vertices],
            vertices: Vec::new(),
            run_alike: true,
        }
    }

    fn get(&self, v: u32) -> Option<&Vertex> {
        self.vertices.get(self.slots[v as usize] as usize)
    }

    fn put(&mut self, v: u32, vertex: Vertex) {
        let slot = &mut self.slots[v as usize];
        if *slot == Self::NOWHERE {
            *slot = self.vertices.len() as u32;
            self.vertices.push(vertex);
        } else {
            self.vertices[*slot as usize] = vertex;
        }
    }
}

/// What there is to know of a vertex with all triangles about it, and whether these run differently round an
/// inner one.
fn first_look(surface: &Surface, v: u32) -> (Vertex, bool) {
    let (kind, runs_alike) = surface.kind(v);
    let is_turned = kind == Kind::Inner && !runs_alike;
    (Vertex::new(kind, quadric(surface, v, kind)), is_turned)
}

/// The planes of the triangles about a vertex, and of the border: at right angles to its triangle.
fn quadric(surface: &Surface, v: u32, kind: Kind) -> Quadric {
    let p = surface.place(v);
    let mut sum = Quadric::default();
    for ends in surface.fan(v) {
        let [a, b] = ends.map(|end| surface.place(end) - p);
        let normal = a.cross(b);
        let length_sq = normal.length_squared();
        sum.add_plane(normal, length_sq, length_sq.sqrt());
        if kind == Kind::Border {
            for (end, side) in ends.into_iter().zip([a, b]) {
                if surface.fan(v).filter(|f| f.contains(&end)).count() == 1 {
                    let outwards = side.cross(normal);
                    let weight = BORDER * side.length_squared();
                    sum.add_plane(outwards, outwards.length_squared(), weight);
                }
            }
        }
    }
    sum
}
