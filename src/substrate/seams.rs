//! Seams that are open by a rounding error.
//!
//! Where two parts of a mesh were worked out apart, one place comes out as two that are a step of f32
//! from each other, and welding leaves a crack. No hole is to be seen there, and lichen stops. Two
//! open edges whose ends are so near to each other are one: both are far longer than that, and there
//! are no more than these two. Elsewhere vertices that near are left apart.

use std::collections::{HashMap, HashSet};

use glam::DVec3;

use super::adjacency::{Adjacency, flatten, unite};
use super::weld::{Welded, classes, is_degenerate, stand_for};
use super::{Component, junctions, order};

/// Steps of an f32 of the mesh's largest coordinate that ends may be apart.
const STEPS: f64 = 2.0;

/// The same as a share of the diagonal at most: what lies far from its origin may be written exactly.
const MOST: f64 = 3e-7;

/// An edge of a seam is as many times as long as its ends may be apart. Those that share a
/// [class](classes) are within four.
const LONG: f64 = 32.0;

/// [Orders](order::order) the triangles, with seams closed, also those on which only one side has
/// [corners](junctions).
pub(super) fn order_closed(welded: &mut Welded) -> (Adjacency, Vec<Component>) {
    let mut ordered = with_seams_closed(welded);
    let apart = apart(welded);
    if junctions::close(welded, &ordered.0.boundary, [apart, LONG * apart]) {
        // What is left of edges may be one with others.
        ordered = with_seams_closed(welded);
    }
    if !welded.parts.is_empty() {
        let kept: HashSet<u32> = welded.source.iter().copied().collect();
        welded.parts.retain(|part, _| kept.contains(part));
    }
    ordered
}

fn with_seams_closed(welded: &mut Welded) -> (Adjacency, Vec<Component>) {
    let ordered = order::order(welded);
    match close(welded, &ordered.0.boundary) {
        0 => ordered,
        _ => order::order(welded),
    }
}

/// Joins the open edges that are one but for rounding, and says how many pairs.
fn close(welded: &mut Welded, open: &[[u32; 2]]) -> usize {
    let mut pairs = pairs(welded, open, apart(welded));
    while !pairs.is_empty() {
        let (vertices, triangles) = joined(welded, &pairs);
        let is_flat = |(_, t): &(&[u32; 3], &[u32; 3])| is_degenerate(&vertices, **t);
        let flat = welded.triangles.iter().zip(&triangles).filter(is_flat);
        let spoilt: HashSet<u32> = flat.flat_map(|(t, _)| *t).collect();
        if spoilt.is_empty() {
            (welded.vertices, welded.triangles) = (vertices, triangles);
            welded.tidy();
            welded.seams += 2 * pairs.len();
            return pairs.len();
        }
        // Where a triangle would have no area any more the seam stays.
        pairs.retain(|pair| {
            !pair
                .iter()
                .any(|(u, v)| spoilt.contains(u) || spoilt.contains(v))
        });
    }
    0
}

/// Vertices and triangles with these vertices made one.
fn joined(welded: &Welded, pairs: &[[(u32, u32); 2]]) -> (Vec<DVec3>, Vec<[u32; 3]>) {
    let mut one: Vec<u32> = (0..welded.vertices.len() as u32).collect();
    for (u, v) in pairs.iter().flatten() {
        unite(&mut one, *u, *v);
    }
    flatten(&mut one);
    let (mut vertices, mut triangles) = (welded.vertices.clone(), welded.triangles.clone());
    stand_for(&one, &mut vertices, &mut triangles);
    (vertices, triangles)
}

/// How far places may be apart that are meant to be one, local units.
fn apart(welded: &Welded) -> f64 {
    let units = &welded.units;
    let step = f64::from(f32::EPSILON) * units.offset();
    let most = MOST * units.diagonal();
    units.length_to_local((STEPS * step).min(most))
}

/// The ends of open edges that are one.
fn pairs(welded: &Welded, open: &[[u32; 2]], apart: f64) -> Vec<[(u32, u32); 2]> {
    let place = |v: u32| welded.vertices[v as usize];
    let is_long = |[u, v]: &&[u32; 2]| place(*u).distance(place(*v)) > LONG * apart;
    let long: Vec<[u32; 2]> = open.iter().filter(is_long).copied().collect();
    let mut ends: Vec<u32> = long.as_flattened().to_vec();
    ends.sort_unstable();
    ends.dedup();
    let places: Vec<DVec3> = ends.iter().map(|&v| place(v)).collect();
    let low = places.iter().fold(DVec3::ZERO, |low, p| low.min(*p));
    let class = classes(&places, low, apart);
    let class: HashMap<u32, u32> = ends.iter().copied().zip(class).collect();
    let mut alike: HashMap<[u32; 2], Vec<[u32; 2]>> = HashMap::new();
    for &[u, v] in &long {
        let [u, v] = if class[&u] < class[&v] {
            [u, v]
        } else {
            [v, u]
        };
        alike
            .entry([class[&u], class[&v]])
            .or_default()
            .push([u, v]);
    }
    let pair = |edges: Vec<[u32; 2]>| match edges.as_slice() {
        [[u, v], [x, y]] => Some([(*u, *x), (*v, *y)]),
        _ => None,
    };
    let mut pairs: Vec<_> = alike.into_values().filter_map(pair).collect();
    pairs.sort_unstable();
    pairs
}

#[cfg(test)]
mod tests {
    use super::super::{Soup, Substrate};

    /// A sheet of two halves, each of n × n quads, that meet at x = 1 but for so much.
    fn halves(n: u32, apart: f64, shift: f64) -> Soup {
        let mut soup = Soup::default();
        for half in 0..2u32 {
            let base = soup.positions.len() as u32;
            for i in 0..=n {
                for j in 0..=n {
                    let [x, y] = [i, j].map(|k| f64::from(k) / f64::from(n));
                    let bump = 0.1 * (3.0 * y).sin();
                    let seam = apart * f64::from(u32::from(half == 1 && i == 0));
                    soup.positions
                        .push([shift + x + f64::from(half) + seam, y, bump + seam]);
                }
            }
            let at = |i, j| base + i * (n + 1) + j;
            for (i, j) in (0..n).flat_map(|i| (0..n).map(move |j| (i, j))) {
                let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
                soup.triangles.extend([[a, b, c], [a, c, d]]);
            }
        }
        soup
    }

    fn open_edges(soup: Soup) -> (usize, usize) {
        let substrate = Substrate::from_soup(soup).unwrap();
        let report = substrate.report();
        (report.boundary_edges, report.components.len())
    }

    #[test]
    fn seams_a_rounding_error_wide_are_closed() {
        let step = f64::from(f32::EPSILON);
        for n in [1, 7, 40] {
            let around = 6 * n as usize;
            for steps in [0.0, 0.5, 1.0, 1.9] {
                assert_eq!(
                    open_edges(halves(n, steps * 2.0 * step, 0.0)),
                    (around, 1),
                    "{steps}"
                );
            }
            // A gap that is one.
            assert_eq!(
                open_edges(halves(n, 1e-4, 0.0)),
                (around + 2 * n as usize, 2)
            );
        }
    }

    /// A needle whose short edge is as short as the seam is wide stays, and so does the seam about it alone.
    #[test]
    fn a_needle_does_not_keep_other_seams_open() {
        let step = f64::from(f32::EPSILON);
        let mut soup = halves(7, 2.0 * step, 0.0);
        let all = soup.triangles.len();
        let base = soup.positions.len() as u32;
        let needle = [
            [0.5, 0.5, 4.0],
            [0.9, 0.5, 4.0],
            [0.9, 0.5 + 2.0 * step, 4.0],
        ];
        soup.positions.extend(needle);
        soup.triangles.push([base, base + 1, base + 2]);
        let substrate = Substrate::from_soup(soup).unwrap();
        assert_eq!(substrate.triangles().len(), all + 1);
        assert_eq!(substrate.report().boundary_edges, 6 * 7 + 3);
    }

    /// Far from the origin a step of f32 may be a gap that somebody made.
    #[test]
    fn gaps_far_from_the_origin_stay() {
        assert_eq!(open_edges(halves(1, 1e-3, 1e4)), (8, 2));
    }

    /// Edges hardly longer than a step of f32 are left as they are, however near another is.
    #[test]
    fn small_triangles_keep_their_shape() {
        let soup = halves(7, 0.0, 0.0);
        let apart = 2.0 * f64::from(f32::EPSILON) * 3.0;
        for (long, pieces) in [(20.0, 3), (60.0, 2)] {
            let mut soup = soup.clone();
            let base = soup.positions.len() as u32;
            let [side, gap] = [long * apart, 0.5 * apart];
            let right = [[0.0, 0.0], [side, 0.0], [0.0, side]];
            let left = [[-gap, 0.0], [-gap, side], [-side, 0.0]];
            let places = right.into_iter().chain(left).map(|[x, y]| [x, y, 3.0]);
            soup.positions.extend(places);
            soup.triangles
                .extend([0, 3].map(|k| [base + k, base + k + 1, base + k + 2]));
            assert_eq!(open_edges(soup).1, pieces, "{long}");
        }
    }
}
