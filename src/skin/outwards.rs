//! Normals that look the way that their triangles do: renderers show the others black.

use std::collections::BTreeMap;

use glam::DVec3;
use rayon::prelude::*;

use crate::export::TriMesh;

/// Gives vertices whose normal looks away from one of their triangles one that looks the way that all of these do, or
/// as nearly as can be. The same for any order of the triangles and their corners.
pub(super) fn face_outwards(mesh: &mut TriMesh) {
    let turned = turned_away(mesh, &mesh.triangles);
    let facing = |(v, faces): (u32, Vec<DVec3>)| (v, facing(faces).0);
    let normals: Vec<_> = turned.into_par_iter().map(facing).collect();
    for (v, normal) in normals {
        mesh.normals[v as usize] = normal.as_vec3().to_array();
    }
}

/// Vertices of these triangles at which the surface is folded over: no normal looks the way that all of their triangles
/// do.
pub(super) fn folded(mesh: &TriMesh, triangles: &[[u32; 3]]) -> Vec<u32> {
    let turned = turned_away(mesh, triangles).into_iter();
    let folded = turned.filter(|(_, faces)| !facing(faces.clone()).1);
    folded.map(|(v, _)| v).collect()
}

/// Vertices whose normal looks away from one of these triangles, with the normals of all of theirs.
fn turned_away(mesh: &TriMesh, triangles: &[[u32; 3]]) -> BTreeMap<u32, Vec<DVec3>> {
    let normal = |v: u32| DVec3::from(mesh.normals[v as usize].map(f64::from));
    let away = triangles.par_iter().flat_map_iter(|triangle| {
        let across = across(mesh, triangle);
        let away = move |v: &u32| normal(*v).dot(across) < 0.0;
        triangle.iter().copied().filter(away)
    });
    let away: Vec<u32> = away.collect();
    let mut is_turned = vec![false; mesh.positions.len()];
    away.iter().for_each(|&v| is_turned[v as usize] = true);
    let about = triangles.par_iter().flat_map_iter(|triangle| {
        let turned = triangle.iter().copied().filter(|&v| is_turned[v as usize]);
        turned.map(|v| (v, across(mesh, triangle).normalize_or_zero()))
    });
    let mut turned = BTreeMap::<u32, Vec<DVec3>>::new();
    for (v, outward) in about.collect::<Vec<_>>() {
        if outward != DVec3::ZERO {
            turned.entry(v).or_default().push(outward);
        }
    }
    turned
}

/// A vector along the normal of a triangle, to the bit whichever of its corners comes first.
fn across(mesh: &TriMesh, triangle: &[u32; 3]) -> DVec3 {
    let mut corners = triangle.map(|v| DVec3::from(mesh.positions[v as usize]));
    let least = (0..3).min_by(|&i, &j| in_order(&corners[i], &corners[j]));
    corners.rotate_left(least.unwrap_or(0));
    let [a, b, c] = corners;
    (b - a).cross(c - a)
}

fn in_order(a: &DVec3, b: &DVec3) -> std::cmp::Ordering {
    let by = |k: usize| a[k].total_cmp(&b[k]);
    by(0).then_with(|| by(1)).then_with(|| by(2))
}

/// A direction that looks the way that all of these do, and whether there is one: that which looks away most is added
/// until none does (the perceptron, Rosenblatt 1958). Where that finds none, the one that looks away least: of what
/// looks the way of two or three to the same degree, as the best one does. Of many faces that is nearly so.
fn facing(mut faces: Vec<DVec3>) -> (DVec3, bool) {
    const TURNS: i32 = 100;
    // Less would be lost in the 32 bits of files.
    const CLEAR: f64 = 1e-3;
    faces.sort_unstable_by(in_order);
    let mut sum: DVec3 = faces.iter().sum();
    let mut best = (f64::NEG_INFINITY, faces[0]);
    for turn in 0..TURNS {
        let direction = sum.normalize_or(faces[0]);
        let (least, face) = least(&faces, direction);
        if least > best.0 {
            best = (least, direction);
        }
        if least > CLEAR {
            return (direction, true);
        }
        // Smaller and smaller steps come nearer to the best there is than whole ones.
        sum += face / f64::from(1 + turn).sqrt();
    }
    // So many triples of all would be too many.
    let mut away = faces.clone();
    away.sort_by(|a, b| a.dot(best.1).total_cmp(&b.dot(best.1)));
    away.dedup();
    away.truncate(MOST_BALANCED);
    for direction in balanced(&away) {
        let (least, _) = least(&faces, direction);
        if least > best.0 {
            best = (least, direction);
        }
    }
    (best.1, best.0 > 0.0)
}

/// Faces that are balanced against one another, at most: those that look away most.
const MOST_BALANCED: usize = 16;

/// Directions that look the way of two or three of these to the same degree, and some beside each: between two that are
/// against one another.
fn balanced(faces: &[DVec3]) -> impl Iterator<Item = DVec3> {
    let pairs = (0..faces.len()).flat_map(move |i| (0..i).map(move |j| (faces[i], faces[j])));
    let thirds = faces.iter().enumerate();
    let of_three = thirds.flat_map(move |(k, &c)| {
        let before = (0..k).flat_map(move |i| (0..i).map(move |j| (faces[i], faces[j])));
        before.flat_map(move |(a, b)| {
            let direction = (a - b).cross(b - c);
            [direction, -direction]
        })
    });
    let of_two = pairs.map(|(a, b)| a + b);
    let beside = faces.iter().flat_map(|face| {
        let (a, b) = face.any_orthonormal_pair();
        [a, b, -a, -b]
    });
    let all = of_two.chain(of_three).chain(beside);
    all.filter_map(DVec3::try_normalize)
}

/// How much a direction looks the way of that of some faces from which it looks away most, and that one.
fn least(faces: &[DVec3], direction: DVec3) -> (f64, DVec3) {
    let all = faces.iter().map(|face| (direction.dot(*face), *face));
    let less = |a: (f64, DVec3), b: (f64, DVec3)| if b.0 < a.0 { b } else { a };
    all.reduce(less).unwrap_or((1.0, direction))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rng::{Purpose, Stream};

    /// Random faces of one half space, and with one more that is against another of them: then about as well as the
    /// best of many directions.
    #[test]
    fn a_normal_looks_away_from_none_if_it_can_and_else_as_little_as_it_can() {
        let mut stream = Stream::new(2, Purpose::Walker, 0);
        let mut direction = || {
            let numbers = [(); 3].map(|()| stream.uniform() - 0.5);
            DVec3::from(numbers).normalize()
        };
        let directions: Vec<DVec3> = (0..1000).map(|_| direction()).collect();
        for _ in 0..200 {
            let out = direction();
            let mut faces: Vec<_> = (0..7).map(|_| direction()).collect();
            faces.retain(|face| face.dot(out) > 0.1);
            let Some(first) = faces.first().copied() else {
                continue;
            };
            let (normal, all) = facing(faces.clone());
            assert!(all && least(&faces, normal).0 > 0.0);
            faces.push(-first);
            let (normal, all) = facing(faces.clone());
            let best = directions.iter().map(|d| least(&faces, *d).0);
            let best = best.fold(f64::NEG_INFINITY, f64::max);
            assert!(!all && least(&faces, normal).0 >= best);
        }
    }

    /// Faces all about a direction, nearly at right angles to it.
    #[test]
    fn a_normal_is_found_however_little_room_there_is() {
        let mut stream = Stream::new(3, Purpose::Walker, 0);
        for (room, faces) in [
            (0.2, 8),
            (0.05, 8),
            (0.01, 8),
            (1e-3, 8),
            (1e-6, 8),
            (1e-3, 400),
        ] {
            for _ in 0..50 {
                let numbers = [(); 3].map(|()| stream.uniform() - 0.5);
                let out = DVec3::from(numbers).normalize();
                let (a, b) = out.any_orthonormal_pair();
                let about = (0..faces).map(|_| {
                    let (sin, cos) = (std::f64::consts::TAU * stream.uniform()).sin_cos();
                    (cos * a + sin * b + room * out).normalize()
                });
                let faces: Vec<_> = about.collect();
                let (normal, all) = facing(faces.clone());
                assert!(all && least(&faces, normal).0 > 0.0, "{room}");
            }
        }
    }

    #[test]
    fn the_order_of_triangles_and_corners_means_nothing() {
        let mut stream = Stream::new(3, Purpose::Walker, 0);
        let mut place = || [(); 3].map(|()| stream.uniform());
        let mut mesh = TriMesh {
            positions: (0..30).map(|_| place()).collect(),
            normals: vec![[0.0, 0.0, 1.0]; 30],
            triangles: (0..28).map(|i| [i, i + 1, i + 2]).collect(),
            ..TriMesh::default()
        };
        let mut other = mesh.clone();
        other.triangles.reverse();
        other.triangles.iter_mut().for_each(|t| t.rotate_left(1));
        face_outwards(&mut mesh);
        face_outwards(&mut other);
        assert_eq!(mesh.normals, other.normals);
        assert_ne!(mesh.normals, vec![[0.0, 0.0, 1.0]; 30]);
    }
}
