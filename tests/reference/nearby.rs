//! Sumner's nearby-triangle sets (6.3.2, with the erratum), by trying every pair: O(n²).

use super::mesh::{Edge, Mesh, Triangle};
use glam::DVec3;

/// For every triangle T the sorted triangles within `q + reach` of its centre, q the distance from the centre to T's
/// farthest corner, that are connected to T inside that sphere over shared edges or vertices.
pub(crate) fn nearby_sets(mesh: &Mesh, reach: f64) -> Vec<Vec<usize>> {
    let spheres: Vec<(DVec3, f64)> = mesh
        .triangles
        .iter()
        .map(|t| (t.centre(), t.reach()))
        .collect();
    let set = |t: usize| {
        let (centre, q) = spheres[t];
        let radius = q + reach;
        let inside = |other: usize| {
            let (c, bound) = spheres[other];
            c.distance(centre) <= radius + bound && mesh.triangles[other].distance(centre) <= radius
        };
        let members: Vec<usize> = (0..mesh.triangles.len()).filter(|&o| inside(o)).collect();
        connected(mesh, t, &members, centre, radius)
    };
    (0..mesh.triangles.len()).map(set).collect()
}

/// The members that can be reached from `start` through vertices and edges that meet the sphere.
fn connected(
    mesh: &Mesh,
    start: usize,
    members: &[usize],
    centre: DVec3,
    radius: f64,
) -> Vec<usize> {
    let mut found = vec![start];
    let mut next = 0;
    while next < found.len() {
        for t in touching(mesh, found[next], centre, radius) {
            if members.binary_search(&t).is_ok() && !found.contains(&t) {
                found.push(t);
            }
        }
        next += 1;
    }
    found.sort_unstable();
    found
}

/// Triangles that share with `t` an edge or a vertex inside the sphere.
fn touching(mesh: &Mesh, t: usize, centre: DVec3, radius: f64) -> Vec<usize> {
    let triangle = &mesh.triangles[t];
    let mut found = Vec::new();
    for k in 0..3 {
        if triangle.corners[k].distance(centre) <= radius {
            found.extend(&mesh.around[triangle.ids[k]]);
        }
        let edge = &triangle.edges[k];
        if let Some((other, _)) = edge.across
            && edge_distance(triangle, edge, centre) <= radius
        {
            found.push(other);
        }
    }
    found
}

fn edge_distance(triangle: &Triangle, edge: &Edge, p: DVec3) -> f64 {
    let (foot, _) = triangle.project(p);
    let s = (foot - edge.base).dot(edge.along).clamp(0.0, edge.length);
    triangle.lift(edge.base + edge.along * s).distance(p)
}
