//! What loading found, what it repaired and what is left, for the user to read.

use std::collections::HashSet;

use glam::DVec3;
use rayon::prelude::*;

use super::adjacency::Adjacency;
use super::load::counted;
use super::weld::Welded;

/// One connected piece of the mesh.
#[derive(Clone, Debug, PartialEq)]
pub struct PieceReport {
    /// Triangles kept.
    pub triangles: usize,
    /// Area, file units squared.
    pub area: f64,
}

/// What a mesh holds, in the file's own units.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct SubstrateReport {
    /// Triangles in the file, polygons being counted as their triangles.
    pub triangles_read: usize,
    /// Triangles kept.
    pub triangles: usize,
    /// Vertices after welding.
    pub vertices: usize,
    /// Pieces joined over shared edges, largest area first.
    pub components: Vec<PieceReport>,
    /// Edges of one triangle.
    pub boundary_edges: usize,
    /// Midpoints of some of them, spread over the mesh.
    pub boundary_places: Vec<[f64; 3]>,
    /// Edges of more than two triangles.
    pub non_manifold_edges: usize,
    /// Midpoints of some of them, spread over the mesh.
    pub non_manifold_places: Vec<[f64; 3]>,
    /// Edges of two triangles that are wound differently.
    pub winding_conflicts: usize,
    /// Midpoints of some of them, spread over the mesh.
    pub winding_conflict_places: Vec<[f64; 3]>,
    /// Triangles dropped for a repeated corner or no area.
    pub degenerate_triangles: usize,
    /// Triangles dropped because another has the same three vertices.
    pub duplicate_triangles: usize,
    /// Area of what was kept.
    pub area: f64,
    /// Lower and upper corner of the bounding box.
    pub bounding_box: [[f64; 3]; 2],
    /// 5th, 50th and 95th percentile of the edges' lengths.
    pub edge_length: [f64; 3],
    /// What the loader and the cleaning did, in words.
    pub repairs: Vec<String>,
}

/// Places named in a report, at most.
const PLACES: usize = 5;

pub(super) fn report(
    read: usize,
    notes: Vec<String>,
    welded: &Welded,
    adjacency: &Adjacency,
) -> SubstrateReport {
    let components = pieces(welded, &adjacency.piece);
    let units = &welded.units;
    SubstrateReport {
        triangles_read: read,
        triangles: welded.triangles.len(),
        vertices: welded.vertices.len(),
        area: components.iter().map(|c| c.area).sum(),
        components,
        boundary_edges: adjacency.boundary.len(),
        boundary_places: places(welded, &adjacency.boundary),
        non_manifold_edges: adjacency.non_manifold.len(),
        non_manifold_places: places(welded, &adjacency.non_manifold),
        winding_conflicts: adjacency.conflicts.len(),
        winding_conflict_places: places(welded, &adjacency.conflicts),
        degenerate_triangles: welded.degenerate,
        duplicate_triangles: welded.duplicate,
        bounding_box: units.bounding_box().map(|p| p.to_array()),
        edge_length: edge_percentiles(welded).map(|l| units.length_to_file(l)),
        repairs: repairs(notes, welded),
    }
}

/// Areas and counts of the pieces, largest area first.
fn pieces(welded: &Welded, roots: &[u32]) -> Vec<PieceReport> {
    let mut by_root = vec![(0usize, 0.0f64); roots.len()];
    for (t, &root) in roots.iter().enumerate() {
        let corners = welded.triangles[t].map(|i| welded.vertices[i as usize]);
        let (count, area) = &mut by_root[root as usize];
        *count += 1;
        *area += super::area(corners);
    }
    by_root.retain(|p| p.0 > 0);
    by_root.sort_by(|a, b| b.1.total_cmp(&a.1));
    let area = |local| welded.units.area_to_file(local);
    by_root
        .into_iter()
        .map(|(triangles, a)| PieceReport {
            triangles,
            area: area(a),
        })
        .collect()
}

fn places(welded: &Welded, edges: &[[u32; 2]]) -> Vec<[f64; 3]> {
    let stride = edges.len().div_ceil(PLACES).max(1);
    let midpoint =
        |[a, b]: [u32; 2]| (welded.vertices[a as usize] + welded.vertices[b as usize]) * 0.5;
    let place = |&e: &[u32; 2]| welded.units.to_file(midpoint(e)).to_array();
    edges.iter().step_by(stride).map(place).collect()
}

/// 5th, 50th and 95th percentile of edge length, each side of each triangle counted.
fn edge_percentiles(welded: &Welded) -> [f64; 3] {
    let vertex = |i: u32| -> DVec3 { welded.vertices[i as usize] };
    let sides = |t: &[u32; 3]| {
        let [a, b, c] = t.map(vertex);
        [
            (b - a).length_squared(),
            (c - b).length_squared(),
            (a - c).length_squared(),
        ]
    };
    let lengths_sq: Vec<f64> = welded.triangles.par_iter().flat_map_iter(sides).collect();
    of_ranks(&lengths_sq, [0.05, 0.5, 0.95]).map(f64::sqrt)
}

/// Numbers of one sign that differ in these lowest bits alone lie together in their order, within a sixteenth.
const ALIKE: u32 = 48;

/// What stands at shares of the way through numbers, none of them below 0, if they were sorted.
fn of_ranks<const N: usize>(numbers: &[f64], shares: [f64; N]) -> [f64; N] {
    let group = |x: &f64| (x.to_bits() >> ALIKE) as usize;
    let mut counts = vec![0; 1 << (u64::BITS - ALIKE)];
    numbers.iter().for_each(|x| counts[group(x)] += 1);
    shares.map(|share| {
        let mut at = (share * (numbers.len() - 1) as f64) as usize;
        let mut found = 0;
        while counts[found] <= at {
            at -= counts[found];
            found += 1;
        }
        let mut alike: Vec<f64> = numbers
            .iter()
            .copied()
            .filter(|x| group(x) == found)
            .collect();
        *alike.select_nth_unstable_by(at, f64::total_cmp).1
    })
}

fn repairs(mut notes: Vec<String>, welded: &Welded) -> Vec<String> {
    let mut note = |n: usize, one: &str, many: &str, rest: &str| {
        if n > 0 {
            notes.push(format!("{} {rest}", counted(n, one, many)));
        }
    };
    note(
        welded.degenerate,
        "degenerate triangle (no area)",
        "degenerate triangles (no area)",
        "dropped",
    );
    let of: HashSet<u32> = welded.parts.values().map(|part| part.of).collect();
    let made = format!("made of {}, on whose edges others have corners", of.len());
    note(welded.parts.len(), "triangle", "triangles", &made);
    note(
        welded.duplicate,
        "duplicate triangle",
        "duplicate triangles",
        "dropped",
    );
    let joined = "joined to others a rounding error away";
    note(welded.seams, "open edge", "open edges", joined);
    let welded_to = "welded to others at the same place";
    note(welded.merged, "vertex", "vertices", welded_to);
    notes
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rng::{Purpose, Stream};

    #[test]
    fn what_stands_at_shares_is_that_of_sorted_numbers() {
        let mut stream = Stream::new(21, Purpose::Walker, 0);
        for count in [1, 2, 3, 20, 1000] {
            let mut number = || match stream.uniform() {
                zero if zero < 0.1 => 0.0,
                same if same < 0.3 => 0.75,
                other => libm::pow(10.0, 600.0 * (other - 0.65)),
            };
            let mut numbers: Vec<f64> = (0..count).map(|_| number()).collect();
            let shares = [0.0, 0.05, 0.5, 0.95, 1.0];
            let found = of_ranks(&numbers, shares);
            numbers.sort_by(f64::total_cmp);
            let at = |share: f64| numbers[(share * (count - 1) as f64) as usize];
            assert_eq!(found, shares.map(at), "{count}");
        }
    }
}
