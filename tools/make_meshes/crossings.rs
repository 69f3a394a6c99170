//! Finds places where a mesh passes through itself.

use std::collections::HashMap;

use glam::DVec3;
use rayon::prelude::*;

use crate::surface::Surface;

/// Counts the pairs of triangles that share no vertex and cut each other. Works on welded meshes; cost is linear in
/// the triangles when they are of even size.
pub(crate) fn crossings(surface: &Surface) -> usize {
    let cell = longest_edge(surface);
    let buckets = bucket(surface, cell);
    (0..surface.triangles.len())
        .into_par_iter()
        .map(|t| {
            let mut near: Vec<usize> = cells(surface, t, cell)
                .filter_map(|c| buckets.get(&c))
                .flatten()
                .copied()
                .filter(|&o| o > t)
                .collect();
            near.sort_unstable();
            near.dedup();
            near.into_iter().filter(|&o| cut(surface, t, o)).count()
        })
        .sum()
}

fn longest_edge(surface: &Surface) -> f64 {
    let longest = surface.triangles.iter().map(|&t| {
        let [a, b, c] = surface.corners(t);
        (b - a)
            .length_squared()
            .max((c - b).length_squared())
            .max((a - c).length_squared())
    });
    longest.fold(0.0, f64::max).sqrt()
}

fn bucket(surface: &Surface, cell: f64) -> HashMap<[i64; 3], Vec<usize>> {
    let mut buckets: HashMap<[i64; 3], Vec<usize>> = HashMap::new();
    for t in 0..surface.triangles.len() {
        for c in cells(surface, t, cell) {
            buckets.entry(c).or_default().push(t);
        }
    }
    buckets
}

/// The grid cells that a triangle's bounding box covers.
fn cells(surface: &Surface, t: usize, cell: f64) -> impl Iterator<Item = [i64; 3]> {
    let [a, b, c] = surface.corners(surface.triangles[t]);
    let low = (a.min(b).min(c) / cell).floor();
    let high = (a.max(b).max(c) / cell).floor();
    let range = move |axis: usize| low[axis] as i64..=high[axis] as i64;
    range(0).flat_map(move |x| range(1).flat_map(move |y| range(2).map(move |z| [x, y, z])))
}

fn cut(surface: &Surface, s: usize, t: usize) -> bool {
    let (one, other) = (surface.triangles[s], surface.triangles[t]);
    if one.iter().any(|v| other.contains(v)) {
        return false;
    }
    let (one, other) = (surface.corners(one), surface.corners(other));
    (0..3).any(|i| {
        pierces(one[i], one[(i + 1) % 3], other) || pierces(other[i], other[(i + 1) % 3], one)
    })
}

/// Whether the segment p–q passes through the triangle: the signs of five tetrahedra.
fn pierces(p: DVec3, q: DVec3, [a, b, c]: [DVec3; 3]) -> bool {
    let volume = |u: DVec3, v: DVec3, w: DVec3, x: DVec3| (v - u).dot((w - u).cross(x - u));
    if (volume(p, a, b, c) > 0.0) == (volume(q, a, b, c) > 0.0) {
        return false;
    }
    let side = volume(p, q, a, b) > 0.0;
    side == (volume(p, q, b, c) > 0.0) && side == (volume(p, q, c, a) > 0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pair(height: f64) -> Surface {
        let flat = [DVec3::ZERO, DVec3::X, DVec3::Y];
        let upright = [
            DVec3::new(0.2, 0.2, height),
            DVec3::new(0.3, 0.2, height + 1.0),
            DVec3::new(0.2, 0.3, height + 1.0),
        ];
        Surface {
            positions: [flat, upright].concat(),
            triangles: vec![[0, 1, 2], [3, 4, 5]],
        }
    }

    #[test]
    fn a_piercing_triangle_is_found_and_a_hovering_one_is_not() {
        assert_eq!(crossings(&pair(-0.5)), 1);
        assert_eq!(crossings(&pair(0.01)), 0);
    }
}
