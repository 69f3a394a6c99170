//! Normals for smooth shading that stay crisp at sharp edges.

use glam::{Vec3, Vec3A};
use rayon::prelude::*;

use super::trace::corners;

/// Cosines of the angles between faces to which an edge is smooth and from which it is sharp: 35°
/// and 65°. Faces in between count in part, or coarse triangles would show along a blunt edge.
const SMOOTH: f32 = 0.819;
const SHARP: f32 = 0.423;

/// Faces looked at around a vertex, at most: bounds the work at the hub of a huge fan.
const AROUND: usize = 64;

/// For each triangle, the normals at its corners: the mean, by area, of the faces that meet there at a blunt
/// angle. Vertices at the same place count as one, and faces wound the other way are turned. All triangles
/// are sound.
pub(super) fn corner_normals(vertices: &[[f32; 3]], triangles: &[[u32; 3]]) -> Vec<[Vec3; 3]> {
    let face = |t: &[u32; 3]| {
        let [a, b, c] = corners(vertices, *t);
        (b - a).cross(c - a)
    };
    let faces: Vec<Vec3A> = triangles.par_iter().map(face).collect();
    let (welded, places) = weld(vertices);
    let at_places = |t: &[u32; 3]| t.map(|v| welded[v as usize]);
    let triangles: Vec<[u32; 3]> = triangles.par_iter().map(at_places).collect();
    let (starts, meeting) = fans(triangles.as_flattened(), places);
    let at = |face: usize, place: u32| {
        let fan = starts[place as usize] as usize..starts[place as usize + 1] as usize;
        corner(&faces, face, &meeting[fan])
    };
    let all = triangles.par_iter().enumerate();
    all.map(|(t, places)| places.map(|place| at(t, place)))
        .collect()
}

fn corner(faces: &[Vec3A], face: usize, fan: &[u32]) -> Vec3 {
    let own = faces[face].normalize_or_zero();
    let mut sum = faces[face];
    for &other in fan.iter().take(AROUND).filter(|&&o| o as usize != face) {
        let n = faces[other as usize];
        let along = own.dot(n);
        let t = (along.abs() / n.length() - SHARP) / (SMOOTH - SHARP);
        if t > 0.0 {
            let t = t.min(1.0);
            sum += n * (along.signum() * t * t * (3.0 - 2.0 * t));
        }
    }
    sum.try_normalize().unwrap_or(own).into()
}

/// The number of the place of each vertex, and how many places there are.
fn weld(vertices: &[[f32; 3]]) -> (Vec<u32>, usize) {
    // Of two zeros one.
    let bits = |p: &[f32; 3]| p.map(|x| (x + 0.0).to_bits());
    let all = vertices.par_iter().enumerate();
    let mut all: Vec<([u32; 3], u32)> = all.map(|(i, p)| (bits(p), i as u32)).collect();
    all.par_sort_unstable();
    let mut first = vec![0; all.len()];
    for same in all.chunk_by(|a, b| a.0 == b.0) {
        same.iter()
            .for_each(|&(_, v)| first[v as usize] = same[0].1);
    }
    // In the order of the vertices, for those of triangles that lie together mostly do so too.
    let (mut welded, mut places) = (vec![0; all.len()], 0);
    for (v, first) in first.into_iter().enumerate() {
        if first as usize == v {
            welded[v] = places;
            places += 1;
        } else {
            welded[v] = welded[first as usize];
        }
    }
    (welded, places as usize)
}

/// The triangles at each place, as starts into one list.
fn fans(welded: &[u32], places: usize) -> (Vec<u32>, Vec<u32>) {
    let mut starts = vec![0u32; places + 1];
    for &p in welded {
        starts[p as usize + 1] += 1;
    }
    for i in 0..places {
        starts[i + 1] += starts[i];
    }
    let mut next = starts.clone();
    let mut meeting = vec![0u32; welded.len()];
    for (corner, &p) in welded.iter().enumerate() {
        meeting[next[p as usize] as usize] = corner as u32 / 3;
        next[p as usize] += 1;
    }
    (starts, meeting)
}
