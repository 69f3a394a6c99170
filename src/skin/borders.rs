//! Where the surface ends: lichen is cut off there, has no margin of its own, and has neighbours on one side alone.
//!
//! A disc whose centre would lie beyond a border is no disc in the open. So an element near a border is closed in
//! towards it: over the angle that the part of the border which is near enough takes up as it is seen from there.

use glam::{DVec3, I64Vec3, Vec3};
use rustc_hash::FxHashMap;

use super::grid::Nearness;
use crate::substrate::{Substrate, way_from_segment};

/// The open edges of a substrate near a lichen, to be found by place.
pub(super) struct Borders {
    edges: Vec<Edge>,
    /// The edges that come near each cell.
    cells: FxHashMap<I64Vec3, Vec<u32>>,
    /// How far borders are looked for.
    reach: f64,
}

struct Edge {
    ends: [DVec3; 2],
    /// Of the surface beside it.
    normal: Vec3,
    /// In that surface's plane, away from it.
    outwards: DVec3,
}

/// Surfaces whose normals differ by more than 60° are others.
const SAME_SHEET: f32 = 0.5;

/// So are those higher over the plane than this share of the reach and of the distance.
const STEP_UP: f64 = 0.1;
const SLOPE: f64 = 0.3;

/// From place to place along an edge that is noted, as a share of the reach.
const STRIDE: f64 = 0.5;

/// Side of a cell, as a share of the reach: with the next place that is noted.
const CELL: f64 = 1.0 + 0.5 * STRIDE;

/// Where more open edges are near, the surface is in shreds, and none of them is taken for a border.
const MOST_NEAR: usize = 4096;

/// Nearer than this share of the reach a place is on the edge.
const ON_EDGE: f64 = 1e-9;

impl Borders {
    /// Within this reach, local units, of some places.
    pub(super) fn new(substrate: &Substrate, places: &[DVec3], reach: f64) -> Self {
        let all = || places.iter().copied();
        let low = all().fold(DVec3::INFINITY, DVec3::min) - reach;
        let high = all().fold(DVec3::NEG_INFINITY, DVec3::max) + reach;
        let open = |h: &u32| substrate.twin(*h).half_edge() == *h;
        let near = |h| Edge::new(substrate, h, [low, high]);
        let half_edges = 0..3 * substrate.triangles().len() as u32;
        let mut borders = Self {
            edges: half_edges.filter(open).filter_map(near).collect(),
            cells: FxHashMap::default(),
            reach,
        };
        if !borders.edges.is_empty() {
            let nearness = Nearness::new(all());
            (0..borders.edges.len()).for_each(|number| borders.note(number, &nearness));
        }
        borders
    }

    fn note(&mut self, number: usize, nearness: &Nearness) {
        let [a, b] = self.edges[number].ends;
        let steps = (a.distance(b) / (STRIDE * self.reach)).ceil().max(1.0) as usize;
        for step in 0..=steps {
            let place = a.lerp(b, step as f64 / steps as f64);
            if !nearness.within(place, CELL * self.reach) {
                continue;
            }
            let cell = self.cell(place);
            let listed = self.cells.entry(cell).or_default();
            if listed.last() != Some(&(number as u32)) {
                listed.push(number as u32);
            }
        }
    }

    fn cell(&self, place: DVec3) -> I64Vec3 {
        (place / (CELL * self.reach)).floor().as_i64vec3()
    }

    /// The edges within reach of a place on the surface, with its normal there, and the ways to them.
    fn near(&self, place: DVec3, normal: Vec3) -> Vec<(&Edge, DVec3)> {
        if self.edges.is_empty() {
            return Vec::new();
        }
        let at = self.cell(place);
        let beside = (0..27).map(|i| I64Vec3::new(i % 3, i / 3 % 3, i / 9) - 1);
        let listed = beside.filter_map(|step| self.cells.get(&(at + step)));
        let mut near: Vec<u32> = listed.flatten().take(MOST_NEAR + 1).copied().collect();
        if near.len() > MOST_NEAR {
            return Vec::new();
        }
        near.sort_unstable();
        near.dedup();
        let edges = near.into_iter().map(|number| &self.edges[number as usize]);
        let way = |Edge { ends: [a, b], .. }: &Edge| -way_from_segment(place, *a, *b);
        let ways = edges.map(|edge| (edge, way(edge)));
        ways.filter(|(edge, way)| edge.belongs(*way, normal, self.reach))
            .collect()
    }

    /// The directions, each lot from one to another by less than half a turn, in which a disc that wide has its centre
    /// beyond a border when its edge touches a place.
    pub(super) fn closed(&self, place: DVec3, normal: Vec3) -> Vec<[DVec3; 2]> {
        let near = self.near(place, normal);
        let normal = normal.as_dvec3();
        let closed = near.iter().flat_map(|(edge, way)| {
            let ends = edge.ends.map(|end| (end - place).reject_from(normal));
            let part = part_within(ends, self.reach);
            match (part, way.length() > ON_EDGE * self.reach) {
                (None, _) => [None, None],
                (Some(part), true) => [Some(part), None],
                (Some([a, b]), false) => [Some([a, edge.outwards]), Some([edge.outwards, b])],
            }
        });
        closed.flatten().collect()
    }

    /// The share of a disc of this radius, no more than the reach, about a place that is surface, where the nearest
    /// border runs straight: 0.5 to 1.
    pub(super) fn share(&self, place: DVec3, normal: Vec3, radius: f64) -> f64 {
        debug_assert!(radius <= self.reach);
        let ways = self.near(place, normal).into_iter();
        let nearest = ways.map(|(_, way)| way.length()).fold(radius, f64::min);
        let x = nearest / radius;
        1.0 - (libm::acos(x) - x * (1.0 - x * x).sqrt()) / std::f64::consts::PI
    }
}

impl Edge {
    /// The part of a half-edge that lies in a box, if any does.
    fn new(substrate: &Substrate, half_edge: u32, near: [DVec3; 2]) -> Option<Self> {
        let (triangle, k) = (half_edge / 3, half_edge as usize % 3);
        let corners = substrate.corners(triangle);
        let [a, b, apex] = [0, 1, 2].map(|i| corners[(k + i) % 3]);
        let along = (b - a).normalize_or_zero();
        Some(Self {
            ends: part_inside([a, b], near)?,
            normal: substrate.normal(triangle).as_vec3(),
            outwards: (a - apex).reject_from_normalized(along).normalize_or_zero(),
        })
    }

    /// Whether it is of the sheet at a place with this normal, to which this is the way.
    fn belongs(&self, way: DVec3, normal: Vec3, reach: f64) -> bool {
        let length = way.length();
        let height = way.dot(normal.as_dvec3()).abs();
        length <= reach
            && self.normal.dot(normal) > SAME_SHEET
            && height <= STEP_UP * reach + SLOPE * length
    }
}

/// The part of a line between two places that lies in a box, if any does.
fn part_inside([a, b]: [DVec3; 2], [low, high]: [DVec3; 2]) -> Option<[DVec3; 2]> {
    let (mut from, mut to) = (0.0_f64, 1.0_f64);
    for axis in 0..3 {
        let (start, way) = (a[axis], b[axis] - a[axis]);
        let [first, second] = [low[axis], high[axis]].map(|side| (side - start) / way);
        if way != 0.0 {
            (from, to) = (from.max(first.min(second)), to.min(first.max(second)));
        } else if start < low[axis] || start > high[axis] {
            return None;
        }
    }
    (from <= to).then(|| [a.lerp(b, from), a.lerp(b, to)])
}

/// The part of a line between two places that lies in a ball about the origin, if any does.
fn part_within([a, b]: [DVec3; 2], radius: f64) -> Option<[DVec3; 2]> {
    let way = b - a;
    let length_sq = way.length_squared();
    let middle = -a.dot(way) / length_sq;
    let nearest_sq = (a + way * middle).length_squared();
    let left = radius * radius - nearest_sq;
    if left < 0.0 {
        return None;
    }
    let half = (left / length_sq).sqrt();
    let (from, to) = ((middle - half).max(0.0), (middle + half).min(1.0));
    (from < to).then(|| [a + way * from, a + way * to])
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::*;
    use crate::rng::{Purpose, Stream};
    use crate::substrate::{Soup, segment_distance_sq};

    /// Directions in the plane z = 0, none along the board's squares.
    fn directions() -> impl Iterator<Item = DVec3> {
        let angle = |k: u32| TAU * (f64::from(k) + 0.37) / 90.0;
        (0..90).map(move |k| DVec3::new(angle(k).cos(), angle(k).sin(), 0.0))
    }

    /// A flat board of squares, each of which is there or not.
    fn board(is_there: impl Fn(u32, u32) -> bool) -> Substrate {
        const SIDE: u32 = 12;
        let corner = |i: u32| [f64::from(i % (SIDE + 1)), f64::from(i / (SIDE + 1)), 0.0];
        let squares = (0..SIDE * SIDE).map(|i| (i % SIDE, i / SIDE));
        let there = squares.filter(|&(x, y)| is_there(x, y));
        let triangles = there.flat_map(|(x, y)| {
            let a = y * (SIDE + 1) + x;
            [[a, a + 1, a + SIDE + 2], [a, a + SIDE + 2, a + SIDE + 1]]
        });
        Substrate::from_soup(Soup {
            positions: (0..(SIDE + 1) * (SIDE + 1)).map(corner).collect(),
            triangles: triangles.collect(),
            notes: Vec::new(),
        })
        .expect("a board")
    }

    fn open_edges(substrate: &Substrate) -> Vec<[DVec3; 2]> {
        let half_edges = 0..3 * substrate.triangles().len() as u32;
        let open = half_edges.filter(|&h| substrate.twin(h).half_edge() == h);
        let ends = |h: u32| {
            let (corners, k) = (substrate.corners(h / 3), h as usize % 3);
            [corners[k], corners[(k + 1) % 3]]
        };
        open.map(ends).collect()
    }

    /// Whether two lines in the plane z = 0 cross.
    fn cross([a, b]: [DVec3; 2], [c, d]: [DVec3; 2]) -> bool {
        let side = |p: DVec3, q: DVec3, r: DVec3| (q - p).cross(r - p).z > 0.0;
        side(a, b, c) != side(a, b, d) && side(c, d, a) != side(c, d, b)
    }

    fn is_closed(closed: &[[DVec3; 2]], direction: DVec3) -> bool {
        closed.iter().any(|[a, b]| {
            let turn = a.cross(*b).z.signum();
            turn * a.cross(direction).z >= 0.0 && turn * direction.cross(*b).z >= 0.0
        })
    }

    #[test]
    fn closed_are_the_directions_in_which_a_border_comes_before_the_centre() {
        let mut random = Stream::new(3, Purpose::Walker, 0);
        let there: Vec<bool> = (0..144).map(|_| random.uniform() < 0.8).collect();
        let substrate = board(|x, y| there[(12 * y + x) as usize]);
        let edges = open_edges(&substrate);
        let all = substrate.triangles().len() as u32;
        let place = |random: &mut Stream| {
            let [a, b, c] = substrate.corners((random.uniform() * f64::from(all)) as u32);
            a + (b - a) * (0.5 * random.uniform()) + (c - a) * (0.5 * random.uniform())
        };
        let places: Vec<DVec3> = (0..400).map(|_| place(&mut random)).collect();
        let unit = substrate.units().length_to_local(1.0);
        for reach in [0.4, 1.3, 5.0].map(|length| length * unit) {
            let borders = Borders::new(&substrate, &places, reach);
            let mut seen = [0, 0];
            for &p in &places {
                let closed = borders.closed(p, Vec3::Z);
                for way in directions().map(|direction| direction * reach) {
                    let meets = edges.iter().any(|edge| cross([p, p + way], *edge));
                    assert_eq!(is_closed(&closed, way), meets, "{p} {way}");
                    seen[usize::from(meets)] += 1;
                }
                let away = edges.iter().map(|&[a, b]| segment_distance_sq(p, a, b));
                let nearest = away.fold(f64::INFINITY, f64::min).sqrt();
                let share = borders.share(p, Vec3::Z, reach);
                assert!((0.5..=1.0).contains(&share) && (share == 1.0) == (nearest >= reach));
            }
            assert!(seen.iter().all(|n| *n > 1000), "{seen:?}");
        }
    }

    /// There round-off would say on which side it is.
    #[test]
    fn on_a_border_all_beyond_it_is_closed() {
        let substrate = board(|_, _| true);
        let [low, high] = substrate.bounds();
        let unit = substrate.units().length_to_local(1.0);
        let place = low.with_x(low.midpoint(high).x + 0.3 * unit);
        let borders = Borders::new(&substrate, &[place], 3.0 * unit);
        let closed = borders.closed(place, Vec3::Z);
        for way in directions() {
            assert_eq!(is_closed(&closed, way), way.y < 0.0, "{way}");
        }
        assert!((borders.share(place, Vec3::Z, unit) - 0.5).abs() < 1e-6);
    }

    #[test]
    fn borders_of_other_sheets_are_passed_over() {
        let substrate = board(|_, _| true);
        let [low, high] = substrate.bounds();
        let unit = substrate.units().length_to_local(1.0);
        let beneath = low.with_x(low.midpoint(high).x) - DVec3::Z * unit;
        let borders = Borders::new(&substrate, &[beneath], 2.0 * unit);
        assert!(borders.closed(beneath, Vec3::Z).is_empty());
        let place = beneath + DVec3::Z * unit;
        assert!(
            borders.closed(place, -Vec3::Z).is_empty()
                && !borders.closed(place, Vec3::Z).is_empty()
        );
    }
}
