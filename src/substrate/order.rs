//! One order for one surface.
//!
//! Triangles are stored along a curve that fills space, piece by piece, so that what a walk crosses
//! next is near in memory too. Outside they have canonical numbers: pieces by area, in the file's
//! order inside each, so that the order in which unrelated pieces stand in the file changes nothing.

use std::ops::Range;

use glam::DVec3;
use rayon::prelude::*;

use super::adjacency::{self, Adjacency};
use super::weld::{Welded, forget_unused};
use super::{Component, area};

/// Orders the triangles and builds their adjacency.
pub(super) fn order(welded: &mut Welded) -> (Adjacency, Vec<Component>) {
    permute(welded, &triangles_along_curve(welded));
    let adjacency = adjacency::build(&welded.vertices, &welded.triangles);
    let mut pieces = pieces(welded, &adjacency.walkable);
    if pieces.len() == 1 {
        return (adjacency, pieces.into_iter().map(|p| p.component).collect());
    }
    pieces.sort_by(|a, b| a.compare(b));
    let order = number_pieces(&mut pieces, &adjacency.walkable);
    drop(adjacency);
    permute(welded, &order);
    let components = pieces.into_iter().map(|p| p.component).collect();
    (
        adjacency::build(&welded.vertices, &welded.triangles),
        components,
    )
}

/// Canonical numbers of the triangles: consecutive in each component, in the order of the file. No two have
/// the same place there.
pub(super) fn canonical_numbers(source: &[u32], components: &[Component]) -> Vec<u32> {
    const NONE: u32 = u32::MAX;
    let places = source.iter().max().map_or(0, |&last| last as usize + 1);
    let mut by_place = vec![NONE; places];
    for (t, &place) in (0..).zip(source) {
        by_place[place as usize] = t;
    }
    let mut next: Vec<u32> = components.iter().map(|c| c.triangles.start).collect();
    let mut numbers = vec![0; source.len()];
    for t in by_place.into_iter().filter(|&t| t != NONE) {
        let component = components.partition_point(|c| c.triangles.end <= t);
        numbers[t as usize] = next[component];
        next[component] += 1;
    }
    numbers
}

/// Bits of each coordinate that order places along the curve, at most: fewer where so many places leave
/// no room for them beside their numbers in one word. Of a mesh's triangles few are in one cell even then, unless
/// some lie far from the rest.
const CURVE_BITS: u32 = 16;

/// The triangles' numbers, ordered by their centroids.
fn triangles_along_curve(welded: &Welded) -> Vec<u32> {
    let bounds = welded.vertices.iter();
    let bounds = bounds.fold([DVec3::INFINITY, DVec3::NEG_INFINITY], |[l, h], &v| {
        [l.min(v), h.max(v)]
    });
    along_curve(bounds, welded.triangles.len(), |t| {
        let [a, b, c] = welded.triangles[t].map(|v| welded.vertices[v as usize]);
        (a + b + c) / 3.0
    })
}

/// The numbers of so many places within bounds, ordered along a Morton curve.
pub(crate) fn along_curve(
    [low, high]: [DVec3; 2],
    places: usize,
    place: impl Fn(usize) -> DVec3 + Sync,
) -> Vec<u32> {
    let number_bits = usize::BITS - places.leading_zeros();
    let bits = CURVE_BITS.min((u64::BITS - number_bits) / 3);
    let cells = f64::from(1u32 << bits) / (high - low).max_element();
    let key = |i: usize| {
        let cell = (place(i) - low) * cells;
        let along = |x: f64| spread((x as u64).min((1 << bits) - 1));
        let along = along(cell.x) | along(cell.y) << 1 | along(cell.z) << 2;
        along << number_bits | i as u64
    };
    let mut keys: Vec<u64> = (0..places).into_par_iter().map(key).collect();
    keys.par_sort_unstable();
    let number = |key: u64| (key & ((1 << number_bits) - 1)) as u32;
    keys.into_iter().map(number).collect()
}

/// Spreads 16 bits to every third place.
fn spread(x: u64) -> u64 {
    let x = (x | x << 32) & 0x001f_0000_0000_ffff;
    let x = (x | x << 16) & 0x001f_0000_ff00_00ff;
    let x = (x | x << 8) & 0x100f_00f0_0f00_f00f;
    let x = (x | x << 4) & 0x10c3_0c30_c30c_30c3;
    (x | x << 2) & 0x1249_2492_4924_9249
}

/// A component before it has its final place.
struct Piece {
    root: u32,
    count: u32,
    component: Component,
}

impl Piece {
    /// Largest area first; equal areas by bounding box.
    fn compare(&self, other: &Self) -> std::cmp::Ordering {
        let key = |p: &Self| p.component.bounds.map(|b| b.to_array());
        let (a, b) = (key(self), key(other));
        let mut bounds = a
            .as_flattened()
            .iter()
            .zip(b.as_flattened())
            .map(|(x, y)| x.total_cmp(y));
        let first_difference = bounds
            .find(|o| o.is_ne())
            .unwrap_or(std::cmp::Ordering::Equal);
        other
            .component
            .area
            .total_cmp(&self.component.area)
            .then(first_difference)
    }
}

/// The components in order of their first triangles.
fn pieces(welded: &Welded, roots: &[u32]) -> Vec<Piece> {
    let mut slot = vec![u32::MAX; roots.len()];
    let mut pieces: Vec<Piece> = Vec::new();
    for (t, &root) in roots.iter().enumerate() {
        let corners = welded.triangles[t].map(|i| welded.vertices[i as usize]);
        if slot[root as usize] == u32::MAX {
            slot[root as usize] = pieces.len() as u32;
            pieces.push(Piece {
                root,
                count: 0,
                component: empty_component(corners[0]),
            });
        }
        let piece = &mut pieces[slot[root as usize] as usize];
        piece.count += 1;
        piece.component.area += area(corners);
        piece.component.triangles.end = t as u32 + 1;
        let [min, max] = &mut piece.component.bounds;
        *min = corners.iter().fold(*min, |m, &c| m.min(c));
        *max = corners.iter().fold(*max, |m, &c| m.max(c));
    }
    pieces
}

fn empty_component(at: DVec3) -> Component {
    Component {
        triangles: 0..0,
        area: 0.0,
        bounds: [at, at],
    }
}

/// Gives every piece its range of numbers; returns the old number for every new one.
fn number_pieces(pieces: &mut [Piece], roots: &[u32]) -> Vec<u32> {
    let mut next_of_root = vec![0u32; roots.len()];
    let mut start = 0;
    for piece in pieces {
        let range: Range<u32> = start..start + piece.count;
        next_of_root[piece.root as usize] = start;
        start = range.end;
        piece.component.triangles = range;
    }
    let mut order = vec![0u32; roots.len()];
    for (old, &root) in roots.iter().enumerate() {
        let next = &mut next_of_root[root as usize];
        order[*next as usize] = old as u32;
        *next += 1;
    }
    order
}

fn permute(welded: &mut Welded, order: &[u32]) {
    let order = || order.par_iter().map(|&old| old as usize);
    welded.triangles = order().map(|old| welded.triangles[old]).collect();
    welded.source = order().map(|old| welded.source[old]).collect();
    forget_unused(&mut welded.vertices, &mut welded.triangles);
}

#[cfg(test)]
mod tests {
    use super::*;

    /// So many that there is room for 15 bits of each coordinate.
    const MANY: usize = 1 << 17;

    /// A place that is not where its number says, the same for two.
    fn place(i: usize) -> DVec3 {
        let at = |shift: u32| ((i / 2 * 40_503) >> shift & 63) as f64 / 63.0;
        DVec3::new(at(0), at(6), at(12))
    }

    #[test]
    fn all_places_are_there_once_cell_by_cell_and_each_cell_in_the_order_of_numbers() {
        for places in [1, 2, 1000, MANY] {
            let order = along_curve([DVec3::ZERO, DVec3::ONE], places, place);
            let mut sorted = order.clone();
            sorted.sort_unstable();
            assert!(sorted.into_iter().eq(0..places as u32));
            // Of places in eight cubes, and in eight parts of each, no part is left and come to again.
            let part = |&i: &u32| (place(i as usize) * 4.0).min(DVec3::splat(3.0)).as_uvec3();
            let parts = order.chunk_by(|i, j| part(i) == part(j)).count();
            let different: std::collections::HashSet<_> = order.iter().map(part).collect();
            assert_eq!(parts, different.len(), "{places}");
            let at = |i: &u32| place(*i as usize);
            let same = order.chunk_by(|i, j| at(i) == at(j));
            let twos = same
                .filter(|same| same.len() == 2 && same.is_sorted())
                .count();
            assert_eq!(twos, places / 2);
        }
    }
}
