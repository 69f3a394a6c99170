//! The rim: where a disc of a given size can touch the lichen from outside.
//!
//! An element is on the rim when a disc of radius α can be laid on its tangent plane so that its
//! centre is on the edge and no other's is inside: when it is α-extreme (H. Edelsbrunner,
//! D. G. Kirkpatrick and R. Seidel, *On the shape of a set of points in the plane*, 1983). Gaps
//! between branches narrower than the disc count as lichen.

use std::cell::Cell;
use std::cmp::{Ordering, Reverse};
use std::collections::BinaryHeap;
use std::f64::consts::TAU;

use glam::DVec3;

use super::Neighbours;

/// Whether each element is α-extreme among its neighbours, α being half the neighbours' distance.
///
/// Directions are those of the tangent plane, distances those of the ways to the neighbours. Where
/// the surface curves strongly within the distance this is an approximation.
pub fn is_rim(neighbours: &Neighbours) -> Vec<bool> {
    is_rim_where(neighbours, |_| true)
}

/// The same for some of them, and false for the others.
///
/// Where a disc can touch, so can every smaller one: a rim by wide discs is part of that by narrower ones.
pub(crate) fn is_rim_where(
    neighbours: &Neighbours,
    is_asked: impl Fn(usize) -> bool + Sync,
) -> Vec<bool> {
    /// Inside the lichen the nearest neighbours take all directions, and others need not be asked.
    const SHARES: [f64; 3] = [0.3, 0.5, 1.0];
    neighbours.map(|i| {
        let ways = is_asked(i).then(|| ways(neighbours, i));
        ways.is_some_and(|ways| {
            let covered = |share| cover(&mut blocked(&ways, share));
            !SHARES.into_iter().any(covered)
        })
    })
}

/// The ways to an element's neighbours in its tangent plane, and how long they are, in the
/// neighbours' distance.
fn ways(neighbours: &Neighbours, of: usize) -> Vec<[f64; 3]> {
    let normal = neighbours.normal(of).as_dvec3();
    let (x, y) = normal.normalize_or(DVec3::Z).any_orthonormal_pair();
    let mut ways = Vec::new();
    neighbours.visit(of, |_, way, _| {
        let distance = way.length() / neighbours.within();
        ways.push([way.dot(x), way.dot(y), distance]);
    });
    ways
}

/// The arcs of directions that neighbours take away: those within a share of the neighbours' distance.
fn blocked(ways: &[[f64; 3]], share: f64) -> Vec<[f64; 2]> {
    let near = ways.iter().filter(|[_, _, distance]| *distance <= share);
    near.filter_map(|&[x, y, distance]| arc(x, y, distance))
        .collect()
}

/// For each element the angle, 0 to 2π, over which the edge of a disc of radius α about it lies in
/// no other's disc, α being half the neighbours' distance: α times its sum is the length of the
/// outline of all discs together. Directions and distances as for [`is_rim`], of whose elements it
/// is positive.
pub fn exposed_angles(neighbours: &Neighbours) -> Vec<f64> {
    neighbours.map(|i| uncovered(&mut blocked(&ways(neighbours, i), 1.0)))
}

/// For each element the number of elements up to which it is on the rim of the lichen as it grew: on
/// that of the first n it is when it is one of them and n is at most this. [`u32::MAX`] where it
/// still is.
///
/// An element that has left the rim does not come back to it, as others only close off more.
pub fn rim_until(neighbours: &Neighbours) -> Vec<u32> {
    let of = |i: usize| {
        let normal = neighbours.normal(i).as_dvec3();
        let (x, y) = normal.normalize_or(DVec3::Z).any_orthonormal_pair();
        let mut met = Vec::new();
        neighbours.visit(i, |j, way, _| {
            met.push((j, way.dot(x), way.dot(y), way.length()));
        });
        met.sort_unstable_by_key(|(j, ..)| *j);
        let mut open = vec![[0.0, TAU]];
        for (j, x, y, length) in met {
            close(&mut open, arc(x, y, length / neighbours.within()));
            if open.is_empty() {
                return j;
            }
        }
        u32::MAX
    };
    neighbours.map(of)
}

/// Takes an arc away from the open parts of a circle.
fn close(open: &mut Vec<[f64; 2]>, arc: Option<[f64; 2]>) {
    let Some([start, end]) = arc else { return };
    // As far as an arc goes on beyond a turn it starts anew.
    for [start, end] in [[start, end], [0.0, end - TAU]] {
        if start < end {
            let rest = |[a, b]: &[f64; 2]| {
                let parts = [[*a, b.min(start)], [a.max(end), *b]];
                parts.into_iter().filter(|[a, b]| a < b)
            };
            *open = open.iter().flat_map(rest).collect();
        }
    }
}

/// The directions, as an arc, in which the centre of the disc may not lie, lest a
/// neighbour towards (x, y) be inside; its distance is in diameters of the disc.
fn arc(x: f64, y: f64, distance: f64) -> Option<[f64; 2]> {
    let half = libm::acos(distance.min(1.0));
    (x != 0.0 || y != 0.0).then(|| {
        let start = libm::atan2(y, x) - half;
        let start = if start < 0.0 { start + TAU } else { start };
        [start, start + 2.0 * half]
    })
}

/// Whether arcs that start in [0, 2π), none longer than a turn, cover the circle.
fn cover(arcs: &mut [[f64; 2]]) -> bool {
    arcs.sort_unstable_by(|a, b| a[0].total_cmp(&b[0]));
    let farthest = arcs.iter().map(|a| a[1]).reduce(f64::max);
    let Some(mut reach) = farthest.map(|end| end - TAU) else {
        return false;
    };
    for &[start, end] in arcs.iter() {
        if start > reach {
            return false;
        }
        reach = reach.max(end);
    }
    true
}

/// The part of the circle that arcs as those of [`cover`] leave.
fn uncovered(arcs: &mut [[f64; 2]]) -> f64 {
    arcs.sort_unstable_by(|a, b| a[0].total_cmp(&b[0]));
    let farthest = arcs.iter().map(|a| a[1]).reduce(f64::max);
    let Some(mut reach) = farthest.map(|end| end - TAU) else {
        return TAU;
    };
    let mut left = 0.0;
    for &[start, end] in arcs.iter() {
        left += (start - reach).max(0.0);
        reach = reach.max(end);
    }
    left
}

/// For each element the length of the shortest way to an element of the rim over others, in hops
/// through space from neighbour to neighbour (Dijkstra 1959); none where no rim can be reached, as on a
/// closed surface that is grown over.
///
/// # Panics
/// When `rim` and `neighbours` are those of different numbers of elements.
pub fn rim_distance(rim: &[bool], neighbours: &Neighbours) -> Vec<Option<f64>> {
    assert_eq!(rim.len(), neighbours.len(), "a neighbourhood for each");
    let mut distance = vec![f64::INFINITY; rim.len()];
    let mut queue = BinaryHeap::new();
    for (i, _) in rim.iter().enumerate().filter(|(_, is_rim)| **is_rim) {
        distance[neighbours.slot(i)] = 0.0;
        queue.push(Reverse(Way(0.0, neighbours.slot(i) as u32)));
    }
    let distance = Cell::from_mut(distance.as_mut_slice()).as_slice_of_cells();
    while let Some(Reverse(Way(length, at))) = queue.pop() {
        if length > distance[at as usize].get() {
            continue;
        }
        let is_farther = |next: usize| distance[next].get() > length;
        neighbours.visit_slots(at as usize, is_farther, |next, _, hop| {
            let way = length + hop;
            if way < distance[next].get() {
                distance[next].set(way);
                queue.push(Reverse(Way(way, next as u32)));
            }
        });
    }
    let finite = |d: &Cell<f64>| d.get().is_finite().then_some(d.get());
    let by_slot: Vec<_> = distance.iter().map(finite).collect();
    neighbours.by_point(&by_slot)
}

/// A length, never NaN, and where it leads.
#[derive(PartialEq)]
pub(crate) struct Way(pub(crate) f64, pub(crate) u32);

impl Eq for Way {}

impl PartialOrd for Way {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Way {
    fn cmp(&self, other: &Self) -> Ordering {
        self.0.total_cmp(&other.0).then(self.1.cmp(&other.1))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::morphometry::test_lichen::{Lichen, blob, flat};

    fn rim_of(lichen: &Lichen, within: f64) -> (Vec<bool>, Neighbours) {
        let neighbours = Neighbours::new(&lichen.positions, &lichen.normals, within);
        (is_rim(&neighbours), neighbours)
    }

    /// Discs laid at many places round each element, by the definition.
    #[test]
    fn the_rim_is_where_an_empty_disc_touches() {
        let lichen = flat(250, 5);
        let within = 0.25;
        let (rim, _) = rim_of(&lichen, within);
        let mut both = [0; 2];
        for (i, &is_rim) in rim.iter().enumerate() {
            let room = |k: i32| {
                let (sin, cos) = (f64::from(k) * TAU / 3600.0).sin_cos();
                let centre = lichen.position(i) + DVec3::new(cos, sin, 0.0) * (within / 2.0);
                let others = (0..rim.len()).filter(|&j| j != i);
                let clear = |j| (lichen.position(j) - centre).length() - within / 2.0;
                others.map(clear).fold(f64::INFINITY, f64::min)
            };
            let best = (0..3600).map(room).fold(f64::NEG_INFINITY, f64::max);
            // Between two of the places, the room differs by less than this.
            if best.abs() > within * TAU / 7200.0 {
                assert_eq!(is_rim, best > 0.0, "{i}: {best}");
                both[usize::from(is_rim)] += 1;
            }
        }
        assert!(both[0] > 20 && both[1] > 20, "{both:?}");
    }

    #[test]
    fn the_rim_by_wide_discs_is_part_of_that_by_narrower_ones() {
        for (lichen, within) in [(flat(400, 9), 0.2), (blob(400, 4), 0.4)] {
            let rim = |within: f64| rim_of(&lichen, within);
            let (narrow, (wide, neighbours)) = (rim(within).0, rim(2.5 * within));
            assert_eq!(is_rim_where(&neighbours, |i| narrow[i]), wide);
            let count = |rim: &[bool]| rim.iter().filter(|rim| **rim).count();
            assert!(count(&wide) > 5 && count(&narrow) > count(&wide));
        }
    }

    /// Points on the edges of the discs, counted where no other disc holds them.
    #[test]
    fn exposed_angles_are_what_no_other_disc_covers() {
        const POINTS: u32 = 720;
        let lichen = flat(250, 6);
        let (rim, neighbours) = rim_of(&lichen, 0.25);
        for (i, angle) in exposed_angles(&neighbours).into_iter().enumerate() {
            let free = |k: &u32| {
                let (sin, cos) = (f64::from(*k) * TAU / f64::from(POINTS)).sin_cos();
                let point = lichen.position(i) + DVec3::new(cos, sin, 0.0) * 0.125;
                let holds = |j| j != i && lichen.position(j).distance(point) < 0.125;
                !(0..rim.len()).any(holds)
            };
            let counted = (0..POINTS).filter(free).count() as f64 / f64::from(POINTS) * TAU;
            // Each end of an open arc lies between two of the points.
            assert!((angle - counted).abs() < 0.05, "{i}: {angle} {counted}");
            assert_eq!(angle > 0.0, rim[i], "{i}: {angle}");
        }
    }

    #[test]
    fn the_rim_of_a_younger_lichen_is_told_by_the_grown_one() {
        for (lichen, within) in [(flat(400, 9), 0.25), (blob(400, 4), 0.6)] {
            let (_, grown) = rim_of(&lichen, within);
            let until = rim_until(&grown);
            for n in [1, 2, 7, 50, 133, 255, 399, 400] {
                let (positions, normals) = (&lichen.positions[..n], &lichen.normals[..n]);
                let rim = is_rim(&Neighbours::new(positions, normals, within));
                let told: Vec<bool> = (0..n).map(|i| n as u32 <= until[i]).collect();
                assert_eq!(told, rim, "of {n}");
            }
            assert!(until.iter().any(|&n| n < 400) && until.contains(&u32::MAX));
        }
    }

    /// Bellman and Ford's relaxation over all pairs.
    #[test]
    fn distances_are_those_of_the_shortest_ways() {
        let lichen = blob(200, 2);
        let (mut rim, neighbours) = rim_of(&lichen, 0.5);
        rim.iter_mut()
            .enumerate()
            .for_each(|(i, r)| *r &= i % 7 == 0);
        let mut expected: Vec<f64> = rim
            .iter()
            .map(|&r| if r { 0.0 } else { f64::INFINITY })
            .collect();
        for _ in 0..rim.len() {
            for i in 0..rim.len() {
                neighbours.visit(i, |j, _, hop| {
                    expected[i] = expected[i].min(expected[j as usize] + hop);
                });
            }
        }
        let found = rim_distance(&rim, &neighbours);
        let found: Vec<f64> = found
            .into_iter()
            .map(|d| d.unwrap_or(f64::INFINITY))
            .collect();
        assert_eq!(found, expected);
        assert!(rim.iter().any(|&r| r) && found.iter().any(|&d| d > 0.5));
    }

    /// A disc of hexagonally packed elements: the rim is its edge, and the distance the way to it.
    #[test]
    fn in_a_round_lichen_the_distance_is_the_way_to_the_edge() {
        let mut lichen = Lichen::default();
        for row in -30..=30 {
            for column in -30..=30 {
                let p = [
                    f64::from(2 * column + (row & 1)),
                    f64::from(row) * 3f64.sqrt(),
                    0.0,
                ];
                if DVec3::from(p).length() < 40.0 {
                    lichen.push(p, [0.0, 0.0, 1.0], -1);
                }
            }
        }
        let (rim, neighbours) = rim_of(&lichen, 10.0);
        for (i, d) in rim_distance(&rim, &neighbours).into_iter().enumerate() {
            let from_centre = lichen.position(i).length();
            assert_eq!(rim[i], d == Some(0.0));
            assert!(
                (from_centre + d.unwrap() - 39.0).abs() < 2.0,
                "{from_centre} {d:?}"
            );
        }
    }

    #[test]
    fn a_lone_element_is_rim_and_a_closed_lichen_has_none() {
        let mut alone = Lichen::default();
        alone.push([1.0, 2.0, 3.0], [0.0, 1.0, 0.0], -1);
        let (rim, neighbours) = rim_of(&alone, 1.0);
        assert_eq!(rim_distance(&rim, &neighbours), [Some(0.0)]);
        let sphere = blob(4000, 1).onto_sphere();
        let (rim, neighbours) = rim_of(&sphere, 0.8);
        assert!(rim_distance(&rim, &neighbours).iter().all(Option::is_none));
    }
}
