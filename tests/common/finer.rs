//! The same surface in smaller triangles.

use glam::DVec3;
use thallus::substrate::{Soup, Substrate};

/// Each triangle of a mesh in four, so many times.
pub(crate) fn in_fours(mesh: &Substrate, times: u32) -> Substrate {
    let file = |p| mesh.units().to_file(p);
    let triangles = 0..mesh.triangles().len() as u32;
    let all = triangles.map(|t| mesh.corners(t).map(file)).collect();
    let all: Vec<[DVec3; 3]> =
        (0..times).fold(all, |all: Vec<_>, _| all.iter().flat_map(four).collect());
    let corners = 0..3 * all.len() as u32;
    let soup = Soup {
        positions: all.as_flattened().iter().map(|p| p.to_array()).collect(),
        triangles: corners.collect::<Vec<_>>().as_chunks().0.to_vec(),
        notes: Vec::new(),
    };
    Substrate::from_soup(soup).expect("a mesh")
}

fn four([a, b, c]: &[DVec3; 3]) -> [[DVec3; 3]; 4] {
    let [d, e, f] = [(a, b), (b, c), (c, a)].map(|(p, q)| (*p + *q) * 0.5);
    [[*a, d, f], [d, *b, e], [f, e, *c], [d, e, f]]
}
