//! Fewer triangles: meshoptimizer's simplifier, which weighs normals and colours with the shape.

use meshopt::{SimplifyOptions, VertexDataAdapter, simplify_with_attributes_and_locks};

use super::average::colors_of;
use super::manifold::faulty;
use super::outwards::{face_outwards, folded};
use crate::export::{MeshError, TriMesh, VertexAttribute, volume};

/// Weights of normal and colour against a length of the mesh's size.
const NORMAL_WEIGHT: f32 = 0.02;
const COLOR_WEIGHT: f32 = 0.05;

/// Times that faults are tried to be avoided.
const ATTEMPTS: usize = 6;

/// A mesh that has lost a larger share of its volume than this has lost its shape.
const LOSS: f64 = 0.15;

/// Times that the distance between too few triangles and enough of them is halved.
const HALVINGS: usize = 3;

/// Triangles that are left of so many, when there cannot be as few as asked for at once.
const STAGE: usize = 2;

/// The mesh with about as many triangles as asked for, or the fewest above that with which it stays
/// closed and manifold, and keeps its volume but for 15 %: vertices are kept where they are, with all
/// that is known of them, or dropped. Only normals that would look away from a triangle are turned, and colours are the
/// means of the light about vertices.
///
/// The simplifier does not promise to keep a manifold. Where it did not, the vertices about the
/// fault are held fast and it is done again, several times and with wider surroundings each time. Where
/// that does not help, half of the triangles go and again half of the rest, as far as that works.
///
/// # Errors
/// When the mesh is none that a file could hold ([`TriMesh::check`]).
pub fn decimate(mesh: &TriMesh, triangles: usize) -> Result<TriMesh, MeshError> {
    mesh.check()?;
    if mesh.positions.is_empty() {
        return Ok(mesh.clone());
    }
    let simplifier = Simplifier::new(mesh);
    let at_once = simplifier.unfolded(mesh, &mesh.triangles, triangles);
    let fewer = at_once.unwrap_or_else(|| simplifier.in_stages(mesh, triangles));
    let mut fewer = picked(mesh, fewer);
    face_outwards(&mut fewer);
    Ok(fewer)
}

/// Holds vertices, and so many rings of vertices about them.
fn hold(held: &mut [bool], triangles: &[[u32; 3]], vertices: &[u32], rings: usize) {
    let mut reached = vec![false; held.len()];
    vertices.iter().for_each(|&v| reached[v as usize] = true);
    for _ in 0..rings {
        let touched = |t: &&[u32; 3]| t.iter().any(|&v| reached[v as usize]);
        let ring: Vec<[u32; 3]> = triangles.iter().filter(touched).copied().collect();
        ring.iter()
            .flatten()
            .for_each(|&v| reached[v as usize] = true);
    }
    held.iter_mut().zip(reached).for_each(|(h, r)| *h |= r);
}

/// What the simplifier is given.
struct Simplifier {
    /// Positions, at a size of one.
    places: Vec<u8>,
    /// Normal and colour of each vertex.
    watched: Vec<f32>,
    volume: f64,
}

impl Simplifier {
    fn new(mesh: &TriMesh) -> Self {
        let [low, high] = mesh.bounds();
        let sizes = (0..3).map(|k| high[k] - low[k]);
        let size = sizes.fold(f64::MIN_POSITIVE, f64::max);
        let place = |p: &[f64; 3]| [0, 1, 2].map(|k| ((p[k] - low[k]) / size) as f32);
        let bytes = |p: &[f64; 3]| place(p).into_iter().flat_map(f32::to_ne_bytes);
        let both = mesh.normals.iter().zip(&mesh.colors);
        let watched = both.flat_map(|([x, y, z], c)| {
            let [r, g, b] = c.map(|byte| f32::from(byte) / 255.0);
            [*x, *y, *z, r, g, b]
        });
        Self {
            places: mesh.positions.iter().flat_map(bytes).collect(),
            watched: watched.collect(),
            volume: mesh.volume(),
        }
    }

    /// No fewer than so many triangles, and as few as can be that make a closed manifold.
    fn in_stages(&self, mesh: &TriMesh, triangles: usize) -> Vec<[u32; 3]> {
        let mut best = mesh.triangles.clone();
        let (mut too_few, mut enough) = (triangles.max(1), best.len());
        // What the best came from, and how many triangles were asked for.
        let mut before = None;
        while too_few < enough {
            let next = (enough / STAGE).max(too_few);
            let Some(fewer) = self.sound(mesh, &best, next) else {
                too_few = next;
                break;
            };
            before = Some((std::mem::replace(&mut best, fewer), next));
            enough = next;
        }
        for _ in 0..HALVINGS {
            if enough <= too_few {
                break;
            }
            let between = (too_few as f64 * enough as f64).sqrt() as usize;
            match self.sound(mesh, &best, between) {
                None => too_few = between,
                Some(fewer) => {
                    before = Some((std::mem::replace(&mut best, fewer), between));
                    enough = between;
                }
            }
        }
        let unfolded = before.and_then(|(from, count)| self.unfolded(mesh, &from, count));
        unfolded.unwrap_or(best)
    }

    /// About so many triangles in place of these, if they make a closed manifold that has kept its volume.
    fn sound(&self, mesh: &TriMesh, from: &[[u32; 3]], triangles: usize) -> Option<Vec<[u32; 3]>> {
        self.try_without(mesh, from, triangles, |_| Vec::new())
    }

    /// The same with as few folds as can be had.
    fn unfolded(
        &self,
        mesh: &TriMesh,
        from: &[[u32; 3]],
        triangles: usize,
    ) -> Option<Vec<[u32; 3]>> {
        self.try_without(mesh, from, triangles, |kept| folded(mesh, kept))
    }

    /// About so many triangles in place of these, sound, with as few of the vertices that are `unwanted` as can be had.
    fn try_without(
        &self,
        mesh: &TriMesh,
        from: &[[u32; 3]],
        triangles: usize,
        unwanted: impl Fn(&[[u32; 3]]) -> Vec<u32>,
    ) -> Option<Vec<[u32; 3]>> {
        /// Triangles that may be left more for fewer unwanted vertices.
        const MORE: f64 = 1.1;
        let mut held = vec![false; mesh.positions.len()];
        let mut best: Option<(usize, Vec<[u32; 3]>)> = None;
        let mut most = usize::MAX;
        for rings in 1..=ATTEMPTS {
            let kept = self.run(from, triangles, &held);
            let share = volume(&mesh.positions, &kept) / self.volume;
            if (share - 1.0).abs() > LOSS {
                break;
            }
            let mut wrong = faulty(held.len(), &kept);
            if wrong.is_empty() {
                if kept.len() > most {
                    break;
                }
                if best.is_none() {
                    most = (MORE * kept.len() as f64) as usize;
                }
                wrong = unwanted(&kept);
                if best.as_ref().is_none_or(|(least, _)| wrong.len() < *least) {
                    best = Some((wrong.len(), kept));
                }
                if wrong.is_empty() {
                    break;
                }
            }
            hold(&mut held, from, &wrong, rings);
        }
        best.map(|(_, kept)| kept)
    }

    fn run(&self, from: &[[u32; 3]], triangles: usize, held: &[bool]) -> Vec<[u32; 3]> {
        let stride = size_of::<[f32; 3]>();
        let Ok(places) = VertexDataAdapter::new(&self.places, stride, 0) else {
            return from.to_vec();
        };
        let weights = [[NORMAL_WEIGHT; 3], [COLOR_WEIGHT; 3]].concat();
        let corners = simplify_with_attributes_and_locks(
            from.as_flattened(),
            &places,
            &self.watched,
            &weights,
            weights.len() * size_of::<f32>(),
            held,
            3 * triangles.min(from.len()),
            1.0,
            SimplifyOptions::None,
            None,
        );
        corners.as_chunks().0.to_vec()
    }
}

/// The mesh of these triangles, with the vertices that they use, in colours of those that they do not use too.
fn picked(mesh: &TriMesh, mut triangles: Vec<[u32; 3]>) -> TriMesh {
    let mut used = vec![false; mesh.positions.len()];
    let corners = triangles.as_flattened().iter();
    corners.for_each(|&v| used[v as usize] = true);
    let kept: Vec<usize> = (0..used.len()).filter(|&v| used[v]).collect();
    let mut number = vec![0; used.len()];
    kept.iter()
        .enumerate()
        .for_each(|(new, &old)| number[old] = new as u32);
    let corners = triangles.as_flattened_mut().iter_mut();
    corners.for_each(|v| *v = number[*v as usize]);
    TriMesh {
        name: mesh.name.clone(),
        positions: kept.iter().map(|&v| mesh.positions[v]).collect(),
        normals: kept.iter().map(|&v| mesh.normals[v]).collect(),
        colors: colors_of(mesh, &kept),
        attributes: mesh
            .attributes
            .iter()
            .map(|a| VertexAttribute {
                values: kept.iter().map(|&v| a.values[v]).collect(),
                ..*a
            })
            .collect(),
        triangles,
        up: mesh.up,
        fixed_origin: mesh.fixed_origin,
    }
}
