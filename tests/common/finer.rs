//! The same surface in smaller triangles.

use std::collections::HashMap;

use thallus::substrate::{Soup, Substrate};

/// A mesh with each triangle in four, so many times.
pub(crate) fn finer(mesh: &Substrate, times: u32) -> Substrate {
    let file = |p| mesh.units().to_file(p).to_array();
    let soup = Soup {
        positions: mesh.vertices().iter().copied().map(file).collect(),
        triangles: mesh.triangles().to_vec(),
        notes: Vec::new(),
    };
    Substrate::from_soup(in_fours(soup, times)).expect("a mesh")
}

/// Each triangle in four, so many times.
pub(crate) fn in_fours(soup: Soup, times: u32) -> Soup {
    (0..times).fold(soup, |soup, _| four_each(&soup))
}

/// Every triangle as four: the same surface in finer triangles.
fn four_each(soup: &Soup) -> Soup {
    let mut positions = soup.positions.clone();
    let mut halves: HashMap<[u32; 2], u32> = HashMap::new();
    let mut half = |a: u32, b: u32| {
        *halves.entry([a.min(b), a.max(b)]).or_insert_with(|| {
            let [p, q] = [a, b].map(|i| soup.positions[i as usize]);
            positions.push(std::array::from_fn(|k| 0.5 * (p[k] + q[k])));
            positions.len() as u32 - 1
        })
    };
    let mut triangles = Vec::with_capacity(4 * soup.triangles.len());
    for &[a, b, c] in &soup.triangles {
        let [d, e, f] = [half(a, b), half(b, c), half(c, a)];
        triangles.extend([[a, d, f], [d, b, e], [f, e, c], [d, e, f]]);
    }
    Soup {
        positions,
        triangles,
        notes: Vec::new(),
    }
}
