//! Which triangles continue each other at an edge that more than two share.
//!
//! Where solids touch along an edge, every second wedge about it is free, and the two triangles that face each other
//! over it are joined: walkers stay outside. So it is where the triangles about the edge are wound by turns one way
//! and the other. Elsewhere the two that continue each other most straightly are joined, then the next two, and so on:
//! first those on one side of the surface, by their winding, then the rest; an odd one out ends there. Edges of more
//! than 64 triangles are walls to all of them.
//!
//! Places alone decide, never the numbers of vertices and triangles: what is as straight but for rounding, as three
//! plates at 120°, must be joined in the same way when triangles have been put in another order.

use std::cmp::Ordering;

use glam::{DVec2, DVec3};

use super::adjacency::{HalfEdge, ends};

/// Most triangles about one edge that are still paired.
const MOST_PAIRED: usize = 64;

/// Angles, of which four are a full turn, that are told apart.
const APART: f64 = 1e-3;

/// A triangle at an edge.
#[derive(Clone, Copy)]
struct Side {
    half_edge: HalfEdge,
    /// Unit vector in its plane, perpendicular to the edge and away from it.
    away: DVec3,
    /// Whether it is wound along the edge.
    is_along: bool,
}

/// Pairs the triangles about a non-manifold edge.
pub(super) fn pairs(
    vertices: &[DVec3],
    triangles: &[[u32; 3]],
    edge: [u32; 2],
    group: &[HalfEdge],
) -> Vec<[HalfEdge; 2]> {
    if group.len() > MOST_PAIRED {
        return Vec::new();
    }
    let mut edge = edge;
    edge.sort_by(|&u, &v| by_place(vertices[u as usize], vertices[v as usize]));
    let [a, b] = edge.map(|v| vertices[v as usize]);
    let axis = (b - a).normalize_or_zero();
    let apex = |half_edge: HalfEdge| apex(vertices, triangles, half_edge);
    let side = |half_edge: HalfEdge| Side {
        half_edge,
        away: away_from_edge(apex(half_edge), (a, axis)),
        is_along: ends(triangles, half_edge)[0] == edge[0],
    };
    let mut group = group.to_vec();
    group.sort_by(|&g, &h| by_place(apex(g), apex(h)));
    let sides: Vec<Side> = group.into_iter().map(side).collect();
    let joined = facing(&sides, axis).unwrap_or_else(|| straightest(&sides));
    let half_edges = |pair: [usize; 2]| pair.map(|i| sides[i].half_edge);
    joined.into_iter().map(half_edges).collect()
}

/// Pairs that face each other over the wedges between them, if every second one is free. What lies in one plane may be
/// in either order: in that in which the pairs are straighter.
fn facing(sides: &[Side], axis: DVec3) -> Option<Vec<[usize; 2]>> {
    let turns = turns(sides, axis)?;
    let in_order = |along_first: bool| {
        let mut order: Vec<usize> = (0..sides.len()).collect();
        order.sort_by_key(|&i| (turns[i], sides[i].is_along != along_first, i));
        let next = |k: usize| order[(k + 1) % order.len()];
        let all = || order.iter().enumerate().map(|(k, &i)| [i, next(k)]);
        let by_turns = all().all(|[i, j]| sides[i].is_along != sides[j].is_along);
        // A triangle wound along the edge faces the one that comes next as angles go up.
        let pairs = || all().filter(|[i, _]| sides[*i].is_along);
        by_turns.then(|| pairs().collect::<Vec<_>>())
    };
    let folded = |pairs: &Vec<[usize; 2]>| {
        let fold = |&[i, j]: &[usize; 2]| sides[i].away.dot(sides[j].away);
        pairs.iter().map(fold).sum::<f64>()
    };
    let both = [true, false].into_iter().filter_map(in_order);
    both.min_by(|a, b| folded(a).total_cmp(&folded(b)))
}

/// The places of the triangles in a turn about the edge, from the first on; the same for those in one plane. None where
/// one has no direction.
fn turns(sides: &[Side], axis: DVec3) -> Option<Vec<usize>> {
    let (x, y) = (sides[0].away, axis.cross(sides[0].away));
    let angle = |side: &Side| {
        let angle = quarters(DVec2::new(side.away.dot(x), side.away.dot(y)))?;
        Some(if angle > 4.0 - APART { 0.0 } else { angle })
    };
    let angles: Vec<f64> = sides.iter().map(angle).collect::<Option<_>>()?;
    let mut order: Vec<usize> = (0..sides.len()).collect();
    order.sort_by(|&i, &j| angles[i].total_cmp(&angles[j]));
    let mut turns = vec![0; sides.len()];
    for (&i, &j) in order.iter().zip(order.iter().skip(1)) {
        turns[j] = turns[i] + usize::from(angles[j] - angles[i] > APART);
    }
    Some(turns)
}

/// What grows with the angle of a direction, 1 each quarter turn, by arithmetic that is the same everywhere.
fn quarters(direction: DVec2) -> Option<f64> {
    let DVec2 { x, y } = direction;
    let size = x.abs() + y.abs();
    (size > 0.0).then(|| match (x >= 0.0, y >= 0.0) {
        (true, true) => y / size,
        (false, true) => 1.0 - x / size,
        (false, false) => 2.0 - y / size,
        (true, false) => 3.0 + x / size,
    })
}

/// Those that continue each other most straightly first, but before them those that are on one side of the surface,
/// being wound opposite ways along the edge; ties go to those that come first.
fn straightest(sides: &[Side]) -> Vec<[usize; 2]> {
    let all = 0..sides.len();
    let turns_over = |i: usize, j: usize| sides[i].is_along == sides[j].is_along;
    let mut pairs: Vec<(bool, f64, [usize; 2])> = all
        .clone()
        .flat_map(|i| (i + 1..all.end).map(move |j| [i, j]))
        .map(|[i, j]| (turns_over(i, j), sides[i].away.dot(sides[j].away), [i, j]))
        .collect();
    let by_sides = |a: &(bool, f64, _), b: &(bool, f64, _)| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1));
    pairs.sort_by(|a, b| by_sides(a, b).then(a.2.cmp(&b.2)));
    let mut free = vec![true; sides.len()];
    pairs.retain(|(_, _, pair)| {
        let both = pair.iter().all(|&i| free[i]);
        if both {
            pair.iter().for_each(|&i| free[i] = false);
        }
        both
    });
    pairs.into_iter().map(|(_, _, pair)| pair).collect()
}

/// The corner of a triangle across from an edge of it.
fn apex(vertices: &[DVec3], triangles: &[[u32; 3]], half_edge: HalfEdge) -> DVec3 {
    let corners = triangles[half_edge as usize / 3];
    vertices[corners[(half_edge as usize + 2) % 3] as usize]
}

/// Some order that does not go by numbers.
fn by_place(a: DVec3, b: DVec3) -> Ordering {
    let along = |axis: usize| a[axis].total_cmp(&b[axis]);
    along(0).then(along(1)).then(along(2))
}

/// Unit vector in a triangle's plane, perpendicular to its edge, which begins at a, and away from it.
fn away_from_edge(apex: DVec3, (a, along): (DVec3, DVec3)) -> DVec3 {
    let to_apex = apex - a;
    (to_apex - along * to_apex.dot(along)).normalize_or_zero()
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::*;

    /// The numbers of those joined, of triangles about the z axis at these angles, of a full turn, wound along it or
    /// against it.
    fn joined(sides: &[(f64, bool)]) -> Vec<[u32; 2]> {
        let mut vertices = vec![DVec3::ZERO, DVec3::Z];
        let mut triangles = Vec::new();
        for (&(turn, is_along), apex) in sides.iter().zip(2..) {
            let (y, x) = (TAU * turn).sin_cos();
            vertices.push(DVec3::new(x, y, 0.3));
            triangles.push(if is_along { [0, 1, apex] } else { [1, 0, apex] });
        }
        let group: Vec<HalfEdge> = (0..sides.len() as u32).map(|t| 3 * t).collect();
        let mut pairs: Vec<[u32; 2]> = pairs(&vertices, &triangles, [0, 1], &group)
            .into_iter()
            .map(|pair| pair.map(|half_edge| half_edge / 3))
            .map(|[i, j]| [i.min(j), i.max(j)])
            .collect();
        pairs.sort_unstable();
        pairs
    }

    #[test]
    fn quarters_grow_with_the_angle() {
        let of = |k: i32| {
            let (y, x) = (TAU * f64::from(k) / 360.0).sin_cos();
            quarters(DVec2::new(x, y)).expect("an angle")
        };
        assert!((1..360).all(|k| of(k - 1) < of(k)));
        assert!(of(359) < 4.0 && of(90) == 1.0, "{}", of(90));
        assert_eq!(quarters(DVec2::ZERO), None);
    }

    /// Two cubes that share an edge: the top of each and the side of the other are about the two free quarters.
    #[test]
    fn solids_that_touch_are_walked_on_outside() {
        let (along, against) = (true, false);
        let cubes = [(0.0, along), (0.25, against), (0.5, along), (0.75, against)];
        assert_eq!(joined(&cubes), [[0, 1], [2, 3]]);
        assert_eq!(joined(&cubes.map(|(turn, w)| (turn, !w))), [[0, 3], [1, 2]]);
        let mixed = [cubes[2], cubes[1], cubes[0], cubes[3]];
        assert_eq!(joined(&mixed), [[0, 3], [1, 2]]);
    }

    /// Where solids run into each other too: walkers do not come to the inside.
    #[test]
    fn nothing_is_turned_over_that_need_not_be() {
        let (along, against) = (true, false);
        let ring = [
            (0.041, against),
            (0.046, along),
            (0.219, along),
            (0.414, against),
        ];
        assert_eq!(joined(&ring), [[0, 2], [1, 3]]);
        let wall_within = [(0.0, along), (0.3, along), (0.46, along), (0.9, against)];
        assert_eq!(joined(&wall_within), [[0, 1], [2, 3]]);
    }

    /// A block on a plate, welded to it: from the plate up the wall, and what is under the block among itself.
    #[test]
    fn from_a_plate_it_is_up_the_wall_of_a_block_on_it() {
        let (under, bottom, wall, plate) = ((0.0, true), (0.0, false), (0.25, true), (0.5, false));
        assert_eq!(joined(&[under, bottom, wall, plate]), [[0, 1], [2, 3]]);
        assert_eq!(joined(&[plate, bottom, under, wall]), [[0, 3], [1, 2]]);
    }

    /// The two faces of a sheet without thickness.
    #[test]
    fn a_sheet_of_two_faces_has_two_sides() {
        let faces = [(0.0, true), (0.0, false), (0.5, false), (0.5, true)];
        assert_eq!(joined(&faces), [[0, 2], [1, 3]]);
        let turned = faces.map(|(turn, w)| (turn, !w));
        assert_eq!(joined(&turned), [[0, 2], [1, 3]]);
    }

    #[test]
    fn sheets_go_straight_on_through_others() {
        let crossing = [(0.1, true), (0.35, false), (0.6, false), (0.85, true)];
        assert_eq!(joined(&crossing), [[0, 2], [1, 3]]);
        assert_eq!(joined(&[(0.0, true), (0.5, false), (0.25, true)]), [[0, 1]]);
        assert_eq!(joined(&[(0.2, true), (0.3, true), (0.78, true)]), [[1, 2]]);
    }
}
