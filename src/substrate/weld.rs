//! Welding by position and dropping what no walker can stand on.
//!
//! Exporters split vertices at UV and normal seams, so vertices are welded by position before
//! adjacency is built, or every seam would be a wall.
//! Triangles without area go, but for those that hold others together, which become parts of them
//! (`caps.rs`).
//!
//! Two vertices are one
//!
//! - when their coordinates are equal as f32, counted from the file's origin, or from the mesh's
//!   own centre where the mesh lies more than 16 diagonals away from it: nearly every file and
//!   every exporter means that by one place;
//! - or when they are within 2⁻³⁴ of the mesh's diagonal (6e-11) of each other in every coordinate:
//!   near 0 an f32 resolves the noise of computing, and sin 2π = -2.4e-16 is meant to be 0;
//! - or when both are one with a third.
//!
//! Vertices 2⁻³² of the diagonal apart are never one by the second; the smallest element is
//! thousands of times as large. (Open edges may be one where their ends are farther apart: `seams.rs`.)
//! Nothing here depends on the order of vertices or triangles.

use glam::DVec3;
use rayon::prelude::*;

use super::Soup;
use super::adjacency::{flatten, unite};
use super::caps::{self, Parts};
use super::units::Units;
use crate::ahead::fetch;

/// A soup after welding: no two vertices at one place, no degenerate or duplicate triangle.
pub(super) struct Welded {
    pub(super) units: Units,
    /// Positions in local units.
    pub(super) vertices: Vec<DVec3>,
    pub(super) triangles: Vec<[u32; 3]>,
    /// Number of each kept triangle in the soup; beyond those there, of some that are parts.
    pub(super) source: Vec<u32>,
    /// Which of these are parts of a triangle in the soup.
    pub(super) parts: Parts,
    pub(super) degenerate: usize,
    pub(super) duplicate: usize,
    /// Vertices that stood where another one does.
    pub(super) merged: usize,
    /// Open edges that were one with another but for rounding.
    pub(super) seams: usize,
}

/// Twice a triangle's area over its longest edge squared, at or below which it has no area.
///
/// A walker could cross such a triangle only through round-off.
const FLAT: f64 = 1e-12;

/// Coordinates this many diagonals away from the origin are rounded from the mesh's own centre.
const FAR: f64 = 16.0;

/// Differences up to this share of the diagonal are noise.
const NOISE: f64 = 1.0 / (1u64 << 34) as f64;

/// Look-ups ahead of which the table is asked for: it is larger than the caches.
const AHEAD: usize = 8;

pub(super) fn weld(soup: Soup) -> Welded {
    let Soup {
        positions,
        mut triangles,
        ..
    } = soup;
    let units = Units::of(&positions, &mut triangles);
    let used = count_used(positions.len(), &triangles);
    let vertices = merge_vertices(&units, &positions, &mut triangles);
    drop(positions);
    let merged = used - vertices.len();
    let read = triangles.len();
    let flat: Vec<u32> = (0..read as u32)
        .into_par_iter()
        .filter(|&t| is_degenerate(&vertices, triangles[t as usize]))
        .collect();
    let parts = caps::flip(&vertices, &mut triangles, &flat);
    let source: Vec<u32> = (0..read as u32).collect();
    let mut welded = Welded {
        units,
        vertices,
        triangles,
        source,
        parts,
        degenerate: 0,
        duplicate: 0,
        merged,
        seams: 0,
    };
    if !flat.is_empty() {
        let Welded {
            vertices,
            triangles,
            source,
            ..
        } = &mut welded;
        retain_pairs(triangles, source, |t| !is_degenerate(vertices, t));
        welded.degenerate = read - welded.triangles.len();
    }
    // Vertices have been numbered as triangles come to them.
    if welded.drop_repeated() || !flat.is_empty() {
        forget_unused(&mut welded.vertices, &mut welded.triangles);
    }
    welded
}

impl Welded {
    /// Keeps some of the triangles.
    pub(super) fn retain(&mut self, keep: impl FnMut([u32; 3]) -> bool) {
        retain_pairs(&mut self.triangles, &mut self.source, keep);
    }

    /// Of triangles with the same corners the first stays, and vertices that none uses go.
    pub(super) fn tidy(&mut self) {
        self.drop_repeated();
        forget_unused(&mut self.vertices, &mut self.triangles);
    }

    /// Of triangles with the same corners the first stays. Whether there were any.
    fn drop_repeated(&mut self) -> bool {
        let repeated = repeated(self.vertices.len(), &self.triangles);
        self.duplicate += repeated.len();
        let is_any = !repeated.is_empty();
        if is_any {
            let mut repeated = repeated.into_iter().peekable();
            let mut next = 0..;
            retain_pairs(&mut self.triangles, &mut self.source, |_| {
                let number = next.next();
                repeated.next_if(|r| Some(*r) == number).is_none()
            });
        }
        is_any
    }
}

/// The numbers of triangles with the same corners as one before, ascending.
fn repeated(vertices: usize, triangles: &[[u32; 3]]) -> Vec<u32> {
    // Those with the same lowest corner, in order.
    let lowest = |t: &[u32; 3]| t.iter().fold(u32::MAX, |low, &v| low.min(v)) as usize;
    let mut ends = vec![0u32; vertices + 1];
    triangles.iter().for_each(|t| ends[lowest(t) + 1] += 1);
    (0..vertices).for_each(|v| ends[v + 1] += ends[v]);
    let mut alike = vec![0; triangles.len()];
    for (i, t) in (0..).zip(triangles) {
        let end = &mut ends[lowest(t)];
        alike[*end as usize] = i;
        *end += 1;
    }
    let groups = (0..vertices).into_par_iter().flat_map_iter(|v| {
        let begin = if v > 0 { ends[v - 1] } else { 0 };
        let group = &alike[begin as usize..ends[v] as usize];
        repeated_among(group, triangles)
    });
    let mut all: Vec<u32> = groups.collect();
    all.par_sort_unstable();
    all
}

/// The same of some of the triangles.
fn repeated_among(group: &[u32], triangles: &[[u32; 3]]) -> Vec<u32> {
    /// So few are compared each with each.
    const FEW: usize = 8;
    let corners = |i: u32| sorted(triangles[i as usize]);
    if group.len() <= FEW {
        let before = |k: &usize| {
            let this = corners(group[*k]);
            group[..*k].iter().any(|&other| corners(other) == this)
        };
        let repeated = (1..group.len()).filter(before);
        return repeated.map(|k| group[k]).collect();
    }
    let mut group: Vec<([u32; 3], u32)> = group.iter().map(|&i| (corners(i), i)).collect();
    group.sort_unstable();
    let pairs = group.windows(2).filter(|pair| pair[0].0 == pair[1].0);
    pairs.map(|pair| pair[1].1).collect()
}

/// Puts the lowest of the places that are one where the one that stands for them is, and that one in the
/// corners.
pub(super) fn stand_for(one: &[u32], places: &mut [DVec3], triangles: &mut [[u32; 3]]) {
    for (i, &root) in one.iter().enumerate() {
        places[root as usize] = lower(places[root as usize], places[i]);
    }
    let corners = triangles.as_flattened_mut();
    corners.iter_mut().for_each(|c| *c = one[*c as usize]);
}

fn count_used(vertices: usize, triangles: &[[u32; 3]]) -> usize {
    let mut used = vec![false; vertices];
    triangles
        .as_flattened()
        .iter()
        .for_each(|&i| used[i as usize] = true);
    used.into_iter().filter(|&u| u).count()
}

/// Replaces corner indices by those of merged vertices and returns the merged positions.
fn merge_vertices(units: &Units, positions: &[[f64; 3]], triangles: &mut [[u32; 3]]) -> Vec<DVec3> {
    let (mut places, equal) = merge_equal(units, positions, triangles);
    let [min, _] = units.bounding_box();
    let mut one = classes(&places, min, NOISE * units.diagonal());
    for [a, b] in equal {
        unite(&mut one, a, b);
    }
    flatten(&mut one);
    if one.iter().enumerate().any(|(i, &root)| root as usize != i) {
        stand_for(&one, &mut places, triangles);
        forget_unused(&mut places, triangles);
    }
    places
        .iter_mut()
        .for_each(|p| *p = units.to_local(p.to_array()));
    places
}

/// Merges vertices at one place; the places in the file's units, and pairs of them that are equal as f32.
fn merge_equal(
    units: &Units,
    positions: &[[f64; 3]],
    triangles: &mut [[u32; 3]],
) -> (Vec<DVec3>, Vec<[u32; 2]>) {
    let far = units.offset() > FAR * units.diagonal();
    let shift = if far { units.origin() } else { DVec3::ZERO };
    let place = |i: u32| DVec3::from(positions[i as usize]);
    let key = |p: DVec3| (p - shift).to_array().map(rounded_bits);
    let mut seen = HashIndex::with_capacity(positions.len());
    let mut places: Vec<DVec3> = Vec::with_capacity(positions.len().min(triangles.len()));
    let mut equal = Vec::new();
    // Most corners are at positions that others were at.
    let mut numbers = vec![HashIndex::EMPTY; positions.len()];
    for corner in triangles.as_flattened_mut() {
        let number = &mut numbers[*corner as usize];
        if *number == HashIndex::EMPTY {
            let (p, next) = (place(*corner), places.len() as u32);
            let k = key(p);
            *number = seen.find_or_insert(k, next, |i| key(places[i as usize]) == k);
            if *number == next {
                places.push(p);
            } else if places[*number as usize] != p {
                // It stays a place of its own: what is one with it need not be one with the other.
                equal.push([*number, next]);
                places.push(p);
                *number = next;
            }
        }
        *corner = *number;
    }
    (places, equal)
}

/// The first of two places by x, then y, then z: which of many stands for all must not depend on
/// their order.
pub(super) fn lower(a: DVec3, b: DVec3) -> DVec3 {
    if b.to_array() < a.to_array() { b } else { a }
}

/// For each place, the number of the place that stands for all within the noise of it.
///
/// Four grids have cells four noises wide, and each lies one noise further along all axes. Of two
/// places within a noise of each other an axis can part them in one grid only, so three axes leave
/// one grid in which they share a cell. That takes four look-ups a place, however many crowd; and
/// only places that have company are looked up at all.
pub(super) fn classes(places: &[DVec3], min: DVec3, noise: f64) -> Vec<u32> {
    let per_unit = 1.0 / noise;
    let cell = |i: u32| {
        let noises = (places[i as usize] - min) * per_unit;
        // Half a room away from a room's wall, in which a flat mesh would lie otherwise.
        noises
            .to_array()
            .map(|x| (x as u64).saturating_add(ROOM / 2))
    };
    let mut one: Vec<u32> = (0..places.len() as u32).collect();
    let company = in_company(cell, places.len());
    for shift in 0..4 {
        let shifted = |i: u32| cell(i).map(|x| x.saturating_add(shift) / 4);
        let mut seen = HashIndex::with_capacity(company.len());
        for &i in &company {
            let found = seen.find_or_insert_cell(i, shifted);
            if found != i {
                unite(&mut one, found, i);
            }
        }
    }
    flatten(&mut one);
    one
}

/// Width in noises of the rooms that places are sorted into first: wide enough that few places are
/// at a wall, narrow enough that few share a room.
const ROOM: u64 = 1024;

/// Places that share a room with another or touch a wall, beyond which the other may be.
fn in_company(cell: impl Fn(u32) -> [u64; 3], places: usize) -> Vec<u32> {
    let room = |i: u32| cell(i).map(|x| x / ROOM);
    let at_wall = |x: &u64| [0, ROOM - 1].contains(&(x % ROOM));
    let mut seen = HashIndex::with_capacity(places);
    let mut company = vec![false; places];
    for i in 0..places as u32 {
        let later = i as usize + AHEAD;
        if later < places {
            seen.fetch(low_bits(room(later as u32)));
        }
        let found = seen.find_or_insert_cell(i, room);
        if found != i || cell(i).iter().any(at_wall) {
            company[i as usize] = true;
            company[found as usize] = true;
        }
    }
    (0..places as u32)
        .filter(|&i| company[i as usize])
        .collect()
}

/// Bits of a coordinate as f32, the two zeros being one.
fn rounded_bits(x: f64) -> u32 {
    (x as f32 + 0.0).to_bits()
}

pub(super) fn is_degenerate(vertices: &[DVec3], t: [u32; 3]) -> bool {
    let corners = t.map(|i| vertices[i as usize]);
    t[0] == t[1] || t[1] == t[2] || t[2] == t[0] || is_flat(corners)
}

/// Whether a triangle has no area.
pub(super) fn is_flat([a, b, c]: [DVec3; 3]) -> bool {
    let longest = (b - a)
        .length_squared()
        .max((c - b).length_squared())
        .max((a - c).length_squared());
    (b - a).cross(c - a).length() <= FLAT * longest
}

fn sorted(mut t: [u32; 3]) -> [u32; 3] {
    t.sort_unstable();
    t
}

/// Keeps the triangles that pass, and their source numbers beside them, in order.
fn retain_pairs(
    triangles: &mut Vec<[u32; 3]>,
    source: &mut Vec<u32>,
    mut keep: impl FnMut([u32; 3]) -> bool,
) {
    let mut kept = 0;
    for i in 0..triangles.len() {
        if keep(triangles[i]) {
            triangles[kept] = triangles[i];
            source[kept] = source[i];
            kept += 1;
        }
    }
    triangles.truncate(kept);
    source.truncate(kept);
}

/// Renumbers vertices in the order in which triangles use them; unused ones go.
pub(super) fn forget_unused(vertices: &mut Vec<DVec3>, triangles: &mut [[u32; 3]]) {
    let mut number = vec![u32::MAX; vertices.len()];
    let mut used = Vec::with_capacity(vertices.len());
    for corner in triangles.as_flattened_mut() {
        let n = &mut number[*corner as usize];
        if *n == u32::MAX {
            *n = used.len() as u32;
            used.push(vertices[*corner as usize]);
        }
        *corner = *n;
    }
    *vertices = used;
}

/// Open addressing from a three-word key to a number; the keys live with the caller.
struct HashIndex {
    slots: Vec<u32>,
    mask: usize,
}

impl HashIndex {
    const EMPTY: u32 = u32::MAX;

    fn with_capacity(keys: usize) -> Self {
        let size = (keys.max(8) * 3 / 2).next_power_of_two();
        Self {
            slots: vec![Self::EMPTY; size],
            mask: size - 1,
        }
    }

    /// Asks for where a key is looked up.
    fn fetch(&self, key: [u32; 3]) {
        fetch(self.slots.get(mix(key) as usize & self.mask));
    }

    /// The number already stored for this key, or `new` after storing it.
    fn find_or_insert(&mut self, key: [u32; 3], new: u32, same: impl Fn(u32) -> bool) -> u32 {
        let mut slot = mix(key) as usize & self.mask;
        loop {
            match self.slots[slot] {
                Self::EMPTY => {
                    self.slots[slot] = new;
                    return new;
                }
                found if same(found) => return found,
                _ => slot = (slot + 1) & self.mask,
            }
        }
    }

    /// The first number that was stored for a cell, or `i` after storing it for its own.
    fn find_or_insert_cell(&mut self, i: u32, cell: impl Fn(u32) -> [u64; 3]) -> u32 {
        let here = cell(i);
        self.find_or_insert(low_bits(here), i, |j| cell(j) == here)
    }
}

fn low_bits(cell: [u64; 3]) -> [u32; 3] {
    cell.map(|x| x as u32)
}

/// Spreads a three-word key over 64 bits (the finaliser of splitmix64 on each word).
fn mix(key: [u32; 3]) -> u64 {
    key.iter().fold(0x9e37_79b9_7f4a_7c15, |h, &word| {
        let h = (h ^ u64::from(word)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        (h ^ (h >> 29)).wrapping_mul(0x94d0_49bb_1331_11eb) ^ (h >> 32)
    })
}

#[cfg(test)]
mod tests {
    use std::collections::HashSet;

    use super::*;
    use crate::rng::{Purpose, Stream};

    #[test]
    fn of_triangles_with_the_same_corners_all_but_the_first_are_repeated() {
        let mut stream = Stream::new(5, Purpose::Walker, 0);
        for (vertices, count) in [(4, 0), (4, 3), (5, 60), (40, 900), (200, 30_000)] {
            let mut corner = || (stream.uniform() * f64::from(vertices)) as u32;
            let triangles: Vec<[u32; 3]> =
                (0..count).map(|_| [corner(), corner(), corner()]).collect();
            let mut seen = HashSet::new();
            let expected = (0..).zip(&triangles);
            let expected = expected.filter(|(_, t)| !seen.insert(sorted(**t)));
            let expected: Vec<u32> = expected.map(|(i, _)| i).collect();
            assert_eq!(repeated(vertices as usize, &triangles), expected);
            assert_eq!(expected.is_empty(), count < 60);
        }
    }
}
