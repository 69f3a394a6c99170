//! The outermost elements, and how far every other is from them.
//!
//! An element is outermost when a wide sector about it is empty. The distance of the others is the
//! shortest way over the lichen's neighbour graph.

use std::cmp::Ordering;
use std::collections::BinaryHeap;
use std::f32::consts::PI;

use rayon::prelude::*;

use super::grid::Grid;
use super::lichen::Granule;
use super::sheet::Sheet;
use crate::substrate::Substrate;

/// Elements this near, in radii, are neighbours: two, and the gap that packing leaves.
const NEIGHBOUR: f64 = 3.5;

/// How far the sector is looked into, in radii: gaps that are narrower are inside the lichen.
const LOOK: f64 = 5.0;

/// The empty sector that makes an element outermost: 140°.
const SECTOR: f32 = 140.0 / 180.0 * PI;

/// For each element its distance from the outermost ones, in radii. Elements that no chain of
/// neighbours joins to one have that of the farthest that has.
pub(super) fn rim_distances(
    substrate: &Substrate,
    radius: f64,
    granules: &[Granule],
    grid: &Grid,
) -> Vec<f32> {
    let sheet = || Sheet::new(substrate, radius);
    let look = |sheet: &mut Sheet, i: usize| neighbours(sheet, radius, granules, grid, i);
    let found: Vec<(bool, Vec<Neighbour>)> = (0..granules.len())
        .into_par_iter()
        .map_init(sheet, look)
        .collect();
    let mut distances = shortest(&found);
    let farthest = distances.iter().copied().filter(|d| d.is_finite());
    let farthest = farthest.fold(0.0, f32::max);
    distances.iter_mut().for_each(|d| *d = d.min(farthest));
    distances
}

#[derive(Clone, Copy)]
struct Neighbour {
    element: u32,
    /// In radii.
    distance: f32,
}

/// Whether an element is outermost, and its neighbours.
fn neighbours(
    sheet: &mut Sheet,
    radius: f64,
    granules: &[Granule],
    grid: &Grid,
    element: usize,
) -> (bool, Vec<Neighbour>) {
    let own = &granules[element];
    let (x, y) = own.normal.any_orthonormal_pair();
    let (mut directions, mut found) = (Vec::new(), Vec::new());
    for run in grid.around(own.position) {
        for i in run {
            let other = &granules[i];
            let away = ((other.position - own.position) / radius).as_vec3();
            let distance = away.length();
            let near = distance <= LOOK as f32 && i != element;
            if !near || !sheet.joins(own.position, own.normal, own.home, other) {
                continue;
            }
            directions.push(libm::atan2f(away.dot(y), away.dot(x)));
            if distance <= NEIGHBOUR as f32 {
                let element = i as u32;
                found.push(Neighbour { element, distance });
            }
        }
    }
    (widest_gap(&mut directions) > SECTOR, found)
}

/// The widest angle without a direction; a whole turn when there is one or none.
fn widest_gap(directions: &mut [f32]) -> f32 {
    directions.sort_unstable_by(f32::total_cmp);
    let (Some(first), Some(last)) = (directions.first(), directions.last()) else {
        return 2.0 * PI;
    };
    let around = first + 2.0 * PI - last;
    let between = directions.windows(2).map(|pair| pair[1] - pair[0]);
    between.fold(around, f32::max)
}

/// Dijkstra's shortest paths from all outermost elements at once.
fn shortest(found: &[(bool, Vec<Neighbour>)]) -> Vec<f32> {
    let mut distances = vec![f32::INFINITY; found.len()];
    let mut queue = BinaryHeap::new();
    for (element, (outermost, _)) in found.iter().enumerate() {
        if *outermost {
            distances[element] = 0.0;
            queue.push(Reached(0.0, element as u32));
        }
    }
    while let Some(Reached(distance, element)) = queue.pop() {
        if distance > distances[element as usize] {
            continue;
        }
        for neighbour in &found[element as usize].1 {
            let through = distance + neighbour.distance;
            let known = &mut distances[neighbour.element as usize];
            if through < *known {
                *known = through;
                queue.push(Reached(through, neighbour.element));
            }
        }
    }
    distances
}

/// An element at the end of a path of this length; the shortest is the greatest.
#[derive(PartialEq)]
struct Reached(f32, u32);

impl Eq for Reached {}

impl Ord for Reached {
    fn cmp(&self, other: &Self) -> Ordering {
        other.0.total_cmp(&self.0).then(other.1.cmp(&self.1))
    }
}

impl PartialOrd for Reached {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gaps_go_round_the_turn() {
        assert_eq!(widest_gap(&mut []), 2.0 * PI);
        assert!((widest_gap(&mut [0.3]) - 2.0 * PI).abs() < 1e-6);
        let mut cross = [0.5 * PI, 0.0, -0.5 * PI, PI];
        assert!((widest_gap(&mut cross) - 0.5 * PI).abs() < 1e-6);
        let mut right = [0.2, -0.2];
        assert!((widest_gap(&mut right) - (2.0 * PI - 0.4)).abs() < 1e-6);
    }

    #[test]
    fn paths_are_shortest() {
        let to = |element, distance| Neighbour { element, distance };
        // 0 is the rim; 0-1 direct is longer than 0-2-1, and 3 is alone.
        let found = [
            (true, vec![to(1, 5.0), to(2, 2.0)]),
            (false, vec![to(0, 5.0), to(2, 2.0)]),
            (false, vec![to(0, 2.0), to(1, 2.0)]),
            (false, vec![]),
        ];
        assert_eq!(shortest(&found)[..3], [0.0, 4.0, 2.0]);
        assert_eq!(shortest(&found)[3], f32::INFINITY);
    }
}
