//! Whether a vertex may move onto its neighbour: topology first, then shape.

use glam::DVec3;

use super::super::geometry::nearest_weights;
use super::surface::{Kind, Surface};

/// Most triangles about a vertex that moves or is moved onto, before and after.
pub(super) const MOST_ABOUT: usize = 32;

/// Cosine of the farthest that a collapse may turn a triangle.
const LEAST_COS_TURN: f64 = 0.3;

/// Least twice the area over the longest edge squared: 1.73/2 where all sides are equal.
pub(super) const LEAST_ASPECT: f64 = 0.05;

/// Cosine of the least angle between the two triangles at an edge, 30°: thin plates keep their rim.
const SHARPEST_FOLD: f64 = 0.866;

/// Cosine of the greatest angle between two triangles at a sharp edge, 100°.
const LEAST_SHARP: f64 = -0.174;

/// Cosine of 40°: triangles that face 80° apart at most have no sharp edge between them.
const FACES_NO_SHARP_EDGE: f64 = 0.767;

/// Cosine of 75°.
const FACES_NO_FOLD: f64 = 0.259;

/// A vertex with what is around it; the lists are used again from one vertex to the next.
#[derive(Default)]
pub(super) struct Star {
    vertex: u32,
    /// For each triangle, its next two corners.
    fan: Vec<[u32; 2]>,
    /// Each once, and how many triangles it shares with the vertex.
    neighbours: Vec<(u32, usize)>,
    /// Of the triangles, twice their area long; by [`Star::find_normals`].
    normals: Vec<DVec3>,
}

impl Star {
    /// `is_ring` says that the triangles are one, and all run the same way round.
    pub(super) fn read(&mut self, surface: &Surface, vertex: u32, is_ring: bool) {
        self.vertex = vertex;
        surface.list_fan(vertex, &mut self.fan);
        self.neighbours.clear();
        if is_ring {
            let firsts = self.fan.iter().map(|&[first, _]| (first, 2));
            self.neighbours.extend(firsts);
        } else {
            let mut corners = self.fan.as_flattened().to_vec();
            corners.sort_unstable();
            let same = corners.chunk_by(|a, b| a == b);
            self.neighbours
                .extend(same.map(|same| (same[0], same.len())));
        }
    }

    /// Finds the normals of its triangles, which tell where it may go.
    pub(super) fn find_normals(&mut self, surface: &Surface) {
        let p = surface.place(self.vertex);
        let normals = self.fan.iter().map(|&ends| normal(surface, p, ends));
        self.normals.clear();
        self.normals.extend(normals);
    }

    /// Neighbours, and how many triangles each shares with the vertex.
    pub(super) fn neighbours(&self) -> impl Iterator<Item = (u32, usize)> + '_ {
        self.neighbours.iter().copied()
    }

    fn shares(&self, neighbour: u32) -> usize {
        let mut found = self.neighbours.iter().filter(|n| n.0 == neighbour);
        found.next().map_or(0, |n| n.1)
    }

    fn has_triangle(&self, a: u32, b: u32) -> bool {
        self.fan.iter().any(|&f| f == [a, b] || f == [b, a])
    }

    /// The third corners of the triangles at the edge to a neighbour.
    fn across(&self, neighbour: u32) -> impl Iterator<Item = u32> + '_ {
        self.fan.iter().filter_map(move |&[a, b]| match neighbour {
            _ if a == neighbour => Some(b),
            _ if b == neighbour => Some(a),
            _ => None,
        })
    }

    /// Triangles that stay when the vertex moves to a neighbour.
    fn staying(&self, neighbour: u32) -> impl Iterator<Item = [u32; 2]> + Clone + '_ {
        let stays = move |f: &&[u32; 2]| !f.contains(&neighbour);
        self.fan.iter().filter(stays).copied()
    }
}

/// The normal of a triangle at a place, twice its area long.
fn normal(surface: &Surface, p: DVec3, ends: [u32; 2]) -> DVec3 {
    let [a, b] = ends.map(|v| surface.place(v) - p);
    a.cross(b)
}

/// Whether moving a vertex onto its neighbour leaves the topology as it is: the link condition of
/// Dey, Edelsbrunner, Guha & Nekhayev, *Topology preserving edge contraction* (1999).
///
/// The triangles about the vertex are a disc, and those that it leaves behind fill the same outline
/// from the neighbour; so all that can go wrong is that one of their edges is there already.
pub(super) fn keeps_topology(star: &Star, target: &Star, kind: Kind) -> bool {
    let common = common_neighbours(star, target);
    let mut across = star.across(target.vertex);
    match (kind, across.next(), across.next()) {
        (Kind::Inner, Some(c), Some(d)) => {
            let is_tetrahedron = star.has_triangle(c, d) && target.has_triangle(c, d);
            common == 2 && !is_tetrahedron
        }
        (Kind::Border, Some(c), None) => {
            let is_whole_border = star.shares(c) == 1 && target.shares(c) == 1;
            common == 1 && !is_whole_border
        }
        _ => false,
    }
}

fn common_neighbours(a: &Star, b: &Star) -> usize {
    // So few that to compare each with each takes less time than to put them in order, or to leave off where one is
    // found.
    let times_of_b = |n: u32| b.neighbours().map(|m| usize::from(m.0 == n)).sum::<usize>();
    a.neighbours().map(|n| times_of_b(n.0)).sum()
}

/// Whether no vertex gets more triangles than are good for it.
pub(super) fn keeps_crowd_small(star: &Star, target: &Star) -> bool {
    let stay = star.staying(target.vertex).count() + target.staying(star.vertex).count();
    stay <= MOST_ABOUT.max(target.fan.len())
}

/// Whether no triangle turns over or becomes a sliver, unless it is one. The normals of those that stay, as they
/// would be, are listed in `moved`.
pub(super) fn keeps_triangles(
    surface: &Surface,
    star: &Star,
    onto: u32,
    moved: &mut Vec<DVec3>,
) -> bool {
    let [old, new] = [star.vertex, onto].map(|v| surface.place(v));
    moved.clear();
    let stays = |(ends, _): &(&[u32; 2], &DVec3)| !ends.contains(&onto);
    let mut staying = star.fan.iter().zip(&star.normals).filter(stays);
    staying.all(|(ends, &before)| {
        let [a, b] = ends.map(|v| surface.place(v));
        let after = (a - new).cross(b - new);
        moved.push(after);
        is_within(before, after, LEAST_COS_TURN) && is_no_sliver(after, [new, a, b], before, old)
    })
}

/// Whether a triangle is no sliver, or is one before its first corner moves, with what normal that was where.
fn is_no_sliver(after: DVec3, corners: [DVec3; 3], before: DVec3, old: DVec3) -> bool {
    let [_, a, b] = corners;
    let longest_sq = longest_sq(corners);
    let is_wide = after.length_squared() >= LEAST_ASPECT * LEAST_ASPECT * longest_sq * longest_sq;
    is_wide || {
        let aspect = |normal: DVec3, longest_sq: f64| normal.length() / longest_sq;
        aspect(after, longest_sq) >= aspect(before, self::longest_sq([old, a, b]))
    }
}

/// Of the sides.
fn longest_sq([a, b, c]: [DVec3; 3]) -> f64 {
    let sides = [b - a, c - b, a - c].map(DVec3::length_squared);
    larger(larger(sides[0], sides[1]), sides[2])
}

/// Whether the angle between two vectors has a greater cosine than this positive one. Without a root, which would be
/// waited for.
fn is_within(a: DVec3, b: DVec3, least_cos: f64) -> bool {
    let dot = a.dot(b);
    let lengths_sq = a.length_squared() * b.length_squared();
    dot > 0.0 && dot * dot > least_cos * least_cos * lengths_sq
}

/// f64::max may return either of two zeros.
pub(super) fn larger(a: f64, b: f64) -> f64 {
    if b > a { b } else { a }
}

/// Whether a vertex on a sharp edge stays on it: else the faces of a plate thinner than the error
/// allowed would come to lie on one another.
///
/// Where three sharp edges meet it is free, or a mesh of cubes would stay as it is.
pub(super) fn keeps_sharp_edge(
    surface: &Surface,
    star: &Star,
    onto: u32,
    apexes: &mut Vec<[u32; 2]>,
) -> bool {
    if face_one_way(star.normals.iter().copied(), FACES_NO_SHARP_EDGE) {
        return true;
    }
    apexes.clear();
    spread(star.fan.iter().copied(), apexes);
    let folds = folds(surface, star.vertex, apexes);
    let (mut sharp, mut along) = (0, false);
    for (end, _) in folds.filter(|fold| fold.1 > LEAST_SHARP) {
        sharp += 1;
        along |= end == onto;
    }
    sharp != 2 || along
}

/// Whether no two triangles come to lie closer upon each other about their edge than the sharpest
/// fold that is allowed, or that is there. `moved` are the normals of those that [stay](keeps_triangles).
pub(super) fn keeps_folds_open(
    surface: &Surface,
    star: &Star,
    target: &Star,
    moved: &[DVec3],
    apexes: &mut Vec<[u32; 2]>,
) -> bool {
    let p = surface.place(target.vertex);
    let others = target.staying(star.vertex);
    let normals = others.clone().map(|ends| normal(surface, p, ends));
    if face_one_way(moved.iter().copied().chain(normals), FACES_NO_FOLD) {
        return true;
    }
    apexes.clear();
    spread(star.staying(target.vertex).chain(others), apexes);
    let after = sharpest(surface, target.vertex, apexes);
    after <= SHARPEST_FOLD || {
        let mut sharpest_about = |star: &Star| {
            apexes.clear();
            spread(star.fan.iter().copied(), apexes);
            sharpest(surface, star.vertex, apexes)
        };
        after <= larger(sharpest_about(star), sharpest_about(target))
    }
}

/// Whether none of the normals points away from the first by more than an angle, given as its
/// cosine; so no two differ by more than twice that, and most fans need no closer look.
fn face_one_way(mut normals: impl Iterator<Item = DVec3>, least_cos: f64) -> bool {
    let first = normals.next().unwrap_or(DVec3::ZERO);
    normals.all(|n| is_within(n, first, least_cos))
}

/// Lists, for each triangle of a fan, both edges from the middle with the corner across.
fn spread(fan: impl Iterator<Item = [u32; 2]>, apexes: &mut Vec<[u32; 2]>) {
    fan.for_each(|[a, b]| apexes.extend([[a, b], [b, a]]));
    apexes.sort_unstable();
}

/// Cosine of the least angle between two triangles at an edge from the middle of a fan.
fn sharpest(surface: &Surface, middle: u32, apexes: &[[u32; 2]]) -> f64 {
    folds(surface, middle, apexes).fold(-1.0, |most, fold| larger(most, fold.1))
}

/// The far end of each edge from the middle of a fan, and the cosine of the angle between the two
/// triangles at it: -1 where they are in a plane.
fn folds(surface: &Surface, middle: u32, apexes: &[[u32; 2]]) -> impl Iterator<Item = (u32, f64)> {
    let p = surface.place(middle);
    let pairs = apexes.windows(2).filter(|w| w[0][0] == w[1][0]);
    pairs.map(move |w| {
        let [edge, a, b] = [w[0][0], w[0][1], w[1][1]].map(|v| surface.place(v) - p);
        (w[0][0], cos_fold(edge, a, b))
    })
}

/// Cosine of the angle between two half-planes that meet in a line.
fn cos_fold(line: DVec3, a: DVec3, b: DVec3) -> f64 {
    let [a, b] = [a, b].map(|p| line.cross(p));
    a.dot(b) / (a.length_squared() * b.length_squared()).sqrt()
}

/// Distance from a vertex to the triangles that it leaves behind when it moves.
pub(super) fn distance_left(surface: &Surface, star: &Star, onto: u32) -> f64 {
    let p = surface.place(star.vertex);
    let distances_sq = star.staying(onto).map(|[a, b]| {
        let corners = [onto, a, b].map(|v| surface.place(v));
        let weights = nearest_weights(p, corners);
        let at = corners[0] * weights[0] + corners[1] * weights[1] + corners[2] * weights[2];
        (at - p).length_squared()
    });
    let least = |a: f64, b: f64| if b < a { b } else { a };
    distances_sq.fold(f64::INFINITY, least).sqrt()
}
