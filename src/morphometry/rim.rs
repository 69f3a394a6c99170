//! The rim: where a disc of a given size can touch the lichen from outside.
//!
//! An element is on the rim when a disc of radius α can be laid on its tangent plane so that its
//! centre is on the edge and no other's is inside: when it is α-extreme (H. Edelsbrunner,
//! D. G. Kirkpatrick and R. Seidel, *On the shape of a set of points in the plane*, 1983). Gaps
//! between branches narrower than the disc count as lichen.

use std::collections::BTreeMap;
use std::f64::consts::TAU;
use std::sync::atomic::AtomicU64;
use std::sync::atomic::Ordering::Relaxed;

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use super::Neighbours;

/// Whether each element is α-extreme among its neighbours, α being half the neighbours' distance.
///
/// Directions are those of the tangent plane, distances those of the ways to the neighbours. Where
/// the surface curves strongly within the distance this is an approximation.
pub fn is_rim(neighbours: &Neighbours) -> Vec<bool> {
    is_rim_where(neighbours, |_| true, |_| Vec::new())
}

/// The same for some of them, and false for the others; with more directions in which no disc may lie, each lot from
/// one to another by less than half a turn.
///
/// Where a disc can touch, so can every smaller one: a rim by wide discs is part of that by narrower ones.
pub(crate) fn is_rim_where(
    neighbours: &Neighbours,
    is_asked: impl Fn(usize) -> bool + Sync,
    closed: impl Fn(usize) -> Vec<[DVec3; 2]> + Sync,
) -> Vec<bool> {
    /// Inside the lichen the nearest neighbours take all directions, and others need not be asked.
    const SHARES: [f64; 3] = [0.3, 0.5, 1.0];
    neighbours.map(|i| {
        if !is_asked(i) {
            return false;
        }
        let ways = ways(neighbours, i);
        let closed = closed_arcs(neighbours, i, &closed(i));
        let covered = |share| {
            let mut arcs = blocked(&ways, share);
            arcs.extend(&closed);
            cover(&mut arcs)
        };
        !SHARES.into_iter().any(covered)
    })
}

/// The ways to an element's neighbours in its tangent plane, and how long they are, in the
/// neighbours' distance.
fn ways(neighbours: &Neighbours, of: usize) -> Vec<[f64; 3]> {
    let (x, y) = axes(neighbours, of);
    let mut ways = Vec::new();
    neighbours.visit(of, |_, way, _| {
        let distance = way.length() / neighbours.within();
        ways.push([way.dot(x), way.dot(y), distance]);
    });
    ways
}

/// Two axes of an element's tangent plane.
fn axes(neighbours: &Neighbours, of: usize) -> (DVec3, DVec3) {
    let normal = neighbours.normal(of).as_dvec3();
    normal.normalize_or(DVec3::Z).any_orthonormal_pair()
}

/// The arcs between directions, by the shorter way round; one that begins where another ends leaves no gap.
fn closed_arcs(neighbours: &Neighbours, of: usize, closed: &[[DVec3; 2]]) -> Vec<[f64; 2]> {
    const ROUNDED: f64 = 1e-9;
    let (x, y) = axes(neighbours, of);
    let arc = |ends: &[DVec3; 2]| {
        let [a, b] = ends.map(|way| DVec2::new(way.dot(x), way.dot(y)));
        let turn = libm::atan2(a.perp_dot(b), a.dot(b));
        let first = if turn < 0.0 { b } else { a };
        let start = libm::atan2(first.y, first.x);
        let start = if start < 0.0 { start + TAU } else { start };
        [start, start + turn.abs() + ROUNDED]
    };
    closed.iter().map(arc).collect()
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
    rim_until_with(neighbours, |_| Vec::new())
}

/// The same with more directions in which no disc may lie, from the beginning, as for [`is_rim_where`]; 0 where an
/// element is never on the rim.
pub(crate) fn rim_until_with(
    neighbours: &Neighbours,
    closed: impl Fn(usize) -> Vec<[DVec3; 2]> + Sync,
) -> Vec<u32> {
    let of = |i: usize| {
        let (x, y) = axes(neighbours, i);
        let mut met = Vec::new();
        neighbours.visit(i, |j, way, _| {
            met.push((j, way.dot(x), way.dot(y), way.length()));
        });
        met.sort_unstable_by_key(|(j, ..)| *j);
        let mut open = vec![[0.0, TAU]];
        let arcs = closed_arcs(neighbours, i, &closed(i)).into_iter();
        arcs.for_each(|arc| close(&mut open, Some(arc)));
        if open.is_empty() {
            return 0;
        }
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
/// through space from neighbour to neighbour; none where no rim can be reached, as on a
/// closed surface that is grown over.
///
/// # Panics
/// When `rim` and `neighbours` are those of different numbers of elements.
pub fn rim_distance(rim: &[bool], neighbours: &Neighbours) -> Vec<Option<f64>> {
    assert_eq!(rim.len(), neighbours.len(), "a neighbourhood for each");
    let start = |is_rim: bool| if is_rim { 0.0 } else { f64::INFINITY };
    let by_slot = neighbours.by_slot(rim).into_iter();
    let distances: Vec<_> = by_slot.map(|r| AtomicF64::new(start(r))).collect();
    let inwards = Inwards {
        neighbours,
        distances: &distances,
        ring: RING * neighbours.within(),
    };
    // From inside the pool, as most rings are short.
    rayon::scope(|_| inwards.find());
    let finite = |d: &AtomicF64| Some(d.get()).filter(|d| d.is_finite());
    let by_slot: Vec<_> = distances.iter().map(finite).collect();
    neighbours.by_point(&by_slot)
}

/// How wide the rings are that are taken together, in the neighbours' distance: no wider than an element, so
/// that the ways to all of a ring are known when it comes to its turn.
const RING: f64 = 0.25;

/// Elements of a ring that are worth a thread.
const SOME: usize = 128;

/// Shortest ways from the rim, ring by ring, all of a ring at the same time (U. Meyer and P. Sanders,
/// *Δ-stepping: a parallelizable shortest path algorithm*, 2003). A length is the least over all ways of the sum from the
/// rim on, whatever comes first.
struct Inwards<'a> {
    neighbours: &'a Neighbours,
    /// By slot.
    distances: &'a [AtomicF64],
    /// How wide a ring is.
    ring: f64,
}

impl Inwards<'_> {
    fn find(&self) {
        let slots = 0..self.distances.len() as u32;
        let rim = slots.filter(|slot| self.distances[*slot as usize].get() == 0.0);
        let mut rings = BTreeMap::from([(0, rim.collect::<Vec<_>>())]);
        while let Some((ring, slots)) = rings.pop_first() {
            let slots = slots.par_iter().with_min_len(SOME);
            let nearer = slots.fold(Vec::new, |mut nearer, slot| {
                self.pass(ring, *slot as usize, &mut nearer);
                nearer
            });
            for (ring, slot) in nearer.collect::<Vec<_>>().into_iter().flatten() {
                rings.entry(ring).or_default().push(slot);
            }
        }
    }

    /// Goes on from an element of a ring to those that are nearer by way of it, and notes them with their rings.
    fn pass(&self, ring: u64, at: usize, nearer: &mut Vec<(u64, u32)>) {
        let length = self.distances[at].get();
        // It may have been found to be of another ring, and then it was there.
        if self.ring_of(length) != ring {
            return;
        }
        let is_farther = |next: usize| self.distances[next].get() > length;
        self.neighbours.visit_slots(at, is_farther, |next, _, hop| {
            let way = length + hop;
            let before = self.distances[next].lower(way);
            let (new, old) = (self.ring_of(way), self.ring_of(before));
            if way < before && (new != old || new == ring) {
                nearer.push((new, next as u32));
            }
        });
    }

    fn ring_of(&self, length: f64) -> u64 {
        (length / self.ring) as u64
    }
}

/// A number, 0 or more, that several threads may lower.
struct AtomicF64(AtomicU64);

impl AtomicF64 {
    fn new(value: f64) -> Self {
        Self(AtomicU64::new(value.to_bits()))
    }

    fn get(&self) -> f64 {
        f64::from_bits(self.0.load(Relaxed))
    }

    /// What it was; it is no more than this now. Numbers that are not negative are in order as their bits are.
    fn lower(&self, value: f64) -> f64 {
        f64::from_bits(self.0.fetch_min(value.to_bits(), Relaxed))
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
            assert_eq!(
                is_rim_where(&neighbours, |i| narrow[i], |_| Vec::new()),
                wide
            );
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

    /// Bellman and Ford's relaxation over all pairs, until nothing changes; of many elements on several threads.
    #[test]
    fn distances_are_those_of_the_shortest_ways() {
        for (elements, within, far) in [(200, 0.5, 0.5), (5000, 0.12, 0.2)] {
            let lichen = blob(elements, 2);
            let (mut rim, neighbours) = rim_of(&lichen, within);
            let some = rim.iter_mut().enumerate();
            some.for_each(|(i, r)| *r &= i % 7 == 0);
            let start = |&is_rim: &bool| if is_rim { 0.0 } else { f64::INFINITY };
            let mut expected: Vec<f64> = rim.iter().map(start).collect();
            let mut before = Vec::new();
            while before != expected {
                before.clone_from(&expected);
                for i in 0..rim.len() {
                    neighbours.visit(i, |j, _, hop| {
                        expected[i] = expected[i].min(expected[j as usize] + hop);
                    });
                }
            }
            let pool = rayon::ThreadPoolBuilder::new().num_threads(4).build();
            let found = pool.unwrap().install(|| rim_distance(&rim, &neighbours));
            let found = found.into_iter().map(|d| d.unwrap_or(f64::INFINITY));
            assert_eq!(found.collect::<Vec<_>>(), expected);
            let inside = expected.iter().filter(|d| **d > far && d.is_finite());
            assert!(rim.iter().any(|&r| r) && inside.count() > elements / 100);
        }
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
