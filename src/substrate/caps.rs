//! Triangles without area that hold a mesh together.
//!
//! The third corner of a cap lies on its longest edge. So a cap joins the triangle that has the whole
//! edge to those that have its parts: left out, it opens a crack where there is no hole. No walker can
//! cross it either. The edge between a cap and that triangle is flipped (M. Botsch and L. Kobbelt, *A
//! Robust Procedure to Eliminate Degenerate Faces from Triangle Meshes*, VMV 2001, 3.2, where this is
//! what is left of slicing when the third corner is on the edge): that divides the triangle in two at
//! the cap's third corner, and the surface is as it was.

use std::collections::{BinaryHeap, HashMap, HashSet};

use glam::DVec3;

use super::weld::{is_degenerate, lower};

/// A part of a triangle of the file.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Part {
    /// The triangle's number in the file.
    pub(super) of: u32,
    /// Weights in it of the part's corners.
    pub(super) weights: [[f64; 3]; 3],
}

/// Weights of a triangle's corners in itself.
pub(super) const WHOLE: [[f64; 3]; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

/// What is a part, by the number of the triangle whose place it takes: it takes that of the triangle itself or that
/// of a cap.
pub(super) type Parts = HashMap<u32, Part>;

/// Flips away caps of triangles. Those that are left have nothing to hold together, or are at an edge of more than
/// two triangles.
///
/// `flat` are those without area, or that are [to count](super::junctions) as such, ascending. Parts and what they
/// are of are named by their places in the list.
pub(super) fn flip(vertices: &[DVec3], triangles: &mut [[u32; 3]], flat: &[u32]) -> Parts {
    let is_cap = |t: &u32| !is_repeating(triangles[*t as usize]);
    let caps: Vec<u32> = flat.iter().copied().filter(is_cap).collect();
    if caps.is_empty() {
        return Parts::new();
    }
    let mut flips = Flips::new(vertices, triangles, &caps);
    while let Some(cap) = flips.left.pop() {
        // A flip may have changed it since.
        if flips.remembers(&cap) {
            flips.flip(cap.triangle);
        }
    }
    flips.parts
}

/// The weights in a part of a place that is given by its weights in the whole.
pub(super) fn weights_within(part: [[f64; 3]; 3], place: [f64; 3]) -> [f64; 3] {
    let [a, b, c] = part.map(DVec3::from);
    let p = DVec3::from(place);
    let volume = a.dot(b.cross(c));
    [
        p.dot(b.cross(c)) / volume,
        p.dot(c.cross(a)) / volume,
        p.dot(a.cross(b)) / volume,
    ]
}

fn is_repeating([a, b, c]: [u32; 3]) -> bool {
    a == b || b == c || c == a
}

struct Flips<'a> {
    vertices: &'a [DVec3],
    triangles: &'a mut [[u32; 3]],
    /// The triangles at each edge between vertices of caps.
    edges: HashMap<[u32; 2], Vec<u32>>,
    /// The triangles that are caps.
    caps: HashSet<u32>,
    left: BinaryHeap<Cap>,
    parts: Parts,
}

/// A cap to flip: those with the longest edges first, and of equal ones by places, so that the order of
/// the file changes nothing.
#[derive(PartialEq, Eq, PartialOrd, Ord)]
struct Cap {
    /// Bits of the edge's length squared, which order as it does.
    longest: u64,
    place: [u64; 3],
    triangle: u32,
}

/// The ends of an edge, in order.
pub(super) fn edge(a: u32, b: u32) -> [u32; 2] {
    [a.min(b), a.max(b)]
}

fn sides([a, b, c]: [u32; 3]) -> [[u32; 2]; 3] {
    [edge(a, b), edge(b, c), edge(c, a)]
}

impl<'a> Flips<'a> {
    fn new(vertices: &'a [DVec3], triangles: &'a mut [[u32; 3]], caps: &[u32]) -> Self {
        let mut is_at_cap = vec![false; vertices.len()];
        for v in caps.iter().flat_map(|&t| triangles[t as usize]) {
            is_at_cap[v as usize] = true;
        }
        let mut edges: HashMap<_, Vec<u32>> = HashMap::new();
        let all = (0..).zip(triangles.iter());
        for (t, corners) in all.filter(|(_, corners)| !is_repeating(**corners)) {
            let between = |side: &[u32; 2]| side.iter().all(|&v| is_at_cap[v as usize]);
            for side in sides(*corners).into_iter().filter(between) {
                edges.entry(side).or_default().push(t);
            }
        }
        let mut flips = Self {
            vertices,
            triangles,
            edges,
            caps: HashSet::new(),
            left: BinaryHeap::new(),
            parts: Parts::new(),
        };
        caps.iter().for_each(|&t| flips.remember(t));
        flips
    }

    /// Puts a cap among those that are left.
    fn remember(&mut self, triangle: u32) {
        self.caps.insert(triangle);
        self.left.push(self.cap(triangle));
    }

    /// Whether a triangle is still the cap that it was.
    fn remembers(&self, cap: &Cap) -> bool {
        self.caps.contains(&cap.triangle) && self.cap(cap.triangle) == *cap
    }

    fn cap(&self, triangle: u32) -> Cap {
        let [x, y, _] = self.turned(triangle);
        let [p, q] = [x, y].map(|v| self.vertices[v as usize]);
        Cap {
            longest: p.distance_squared(q).to_bits(),
            place: lower(p, q).to_array().map(f64::to_bits),
            triangle,
        }
    }

    /// A triangle's corners with its longest edge first.
    fn turned(&self, triangle: u32) -> [u32; 3] {
        let corners = self.triangles[triangle as usize];
        let place = |v: u32| self.vertices[v as usize];
        let turns = [0, 1, 2].map(|k| [0, 1, 2].map(|i| corners[(k + i) % 3]));
        let length = |t: &[u32; 3]| place(t[0]).distance_squared(place(t[1]));
        let longest = turns.iter().max_by(|s, t| length(s).total_cmp(&length(t)));
        *longest.unwrap_or(&corners)
    }

    /// Flips a cap's longest edge, or leaves the cap as one that joins nothing.
    fn flip(&mut self, cap: u32) {
        let [a, b, middle] = self.turned(cap);
        let Some(other) = self.beyond(cap, edge(a, b)) else {
            return self.forget(cap);
        };
        let corners = self.triangles[other as usize];
        let k = (0..3).find(|&k| edge(corners[k], corners[(k + 1) % 3]) == edge(a, b));
        let k = k.unwrap_or(0);
        let [x, y, apex] = [k, (k + 1) % 3, (k + 2) % 3].map(|i| corners[i]);
        let halves = [[x, middle, apex], [middle, y, apex]];
        let was_flat = self.caps.contains(&other);
        let are_flat = halves.map(|half| is_degenerate(self.vertices, half));
        if !was_flat && (are_flat.contains(&true) || !self.face_alike(corners, halves)) {
            return self.forget(cap);
        }
        self.caps.remove(&other);
        self.caps.remove(&cap);
        if !was_flat {
            self.divide(other, cap, k, middle);
        }
        [self.triangles[other as usize], self.triangles[cap as usize]] = halves;
        self.edges.remove(&edge(a, b));
        self.give(edge(x, middle), cap, other);
        self.give(edge(y, apex), other, cap);
        let between = self.edges.entry(edge(middle, apex)).or_default();
        between.extend([other, cap]);
        for (half, is_flat) in [other, cap].into_iter().zip(are_flat) {
            if is_flat {
                self.remember(half);
            }
        }
    }

    /// Whether both halves of a triangle look to its side: not where it is as thin as its edge is rounded.
    fn face_alike(&self, whole: [u32; 3], halves: [[u32; 3]; 2]) -> bool {
        let normal = |t: [u32; 3]| {
            let [a, b, c] = t.map(|v| self.vertices[v as usize]);
            (b - a).cross(c - a)
        };
        halves
            .iter()
            .all(|half| normal(*half).dot(normal(whole)) > 0.0)
    }

    /// The one triangle beyond a cap's edge.
    fn beyond(&self, cap: u32, edge: [u32; 2]) -> Option<u32> {
        let sorted = |t: u32| {
            let mut corners = self.triangles[t as usize];
            corners.sort_unstable();
            corners
        };
        // The same cap once more joins nothing.
        let others = self.edges.get(&edge)?.iter();
        let mut others = others.filter(|&&t| sorted(t) != sorted(cap));
        let other = *others.next()?;
        others.next().is_none().then_some(other)
    }

    /// A cap that stays one is at no edge any more.
    fn forget(&mut self, cap: u32) {
        for side in sides(self.triangles[cap as usize]) {
            if let Some(at) = self.edges.get_mut(&side) {
                at.retain(|&t| t != cap);
            }
        }
    }

    /// An edge is one of another triangle from now on.
    fn give(&mut self, edge: [u32; 2], from: u32, to: u32) {
        for t in self.edges.get_mut(&edge).into_iter().flatten() {
            if *t == from {
                *t = to;
            }
        }
    }

    /// Notes that two triangles become parts of the first one, which a place on its k-th edge divides.
    fn divide(&mut self, triangle: u32, second: u32, k: usize, middle: u32) {
        let whole = Part {
            of: triangle,
            weights: WHOLE,
        };
        let Part { of, weights } = *self.parts.get(&triangle).unwrap_or(&whole);
        let corners = self.triangles[triangle as usize];
        let [x, y, apex] = [k, (k + 1) % 3, (k + 2) % 3].map(|i| weights[i]);
        let [p, q] = [k, (k + 1) % 3].map(|i| self.vertices[corners[i] as usize]);
        let along = self.vertices[middle as usize].distance(p) / q.distance(p);
        let between = [0, 1, 2].map(|i| (1.0 - along) * x[i] + along * y[i]);
        for (t, weights) in [(triangle, [x, between, apex]), (second, [between, y, apex])] {
            self.parts.insert(t, Part { of, weights });
        }
    }
}

#[cfg(test)]
mod tests {
    use rand::rngs::SmallRng;
    use rand::seq::SliceRandom;
    use rand::{RngExt, SeedableRng};

    use super::super::{Soup, Substrate, SurfacePoint, Texturing};
    use super::*;

    /// An octahedron, each edge of which has up to three places on either side, at which the triangles
    /// there are divided, and between both sides a strip of triangles without area.
    fn zipped(random: &mut SmallRng) -> Soup {
        let mut soup = Soup {
            positions: [DVec3::X, DVec3::Y, DVec3::Z]
                .iter()
                .flat_map(|p| [p.to_array(), (-*p).to_array()])
                .collect(),
            ..Soup::default()
        };
        let mut sides: HashMap<[u32; 2], Vec<Vec<u32>>> = HashMap::new();
        for face in 0..8u32 {
            let corners = [face & 1, 2 + (face >> 1 & 1), 4 + (face >> 2)];
            let mut outline = Vec::new();
            for k in 0..3 {
                let ends = [corners[k], corners[(k + 1) % 3]];
                let side = side(&mut soup.positions, ends, random.random_range(0..=3));
                outline.extend(&side[..side.len() - 1]);
                let mut ordered = side;
                if ordered[0] != edge(ends[0], ends[1])[0] {
                    ordered.reverse();
                }
                sides
                    .entry(edge(ends[0], ends[1]))
                    .or_default()
                    .push(ordered);
            }
            // From a place inside, so that no triangle of the face is flat.
            let middle = corners.map(|c| DVec3::from(soup.positions[c as usize]));
            let middle = (middle[0] + middle[1] + middle[2]) / 3.0;
            let inside = soup.positions.len() as u32;
            soup.positions.push(middle.to_array());
            let next = outline.iter().cycle().skip(1);
            let fan = outline.iter().zip(next).map(|(&a, &b)| [a, b, inside]);
            soup.triangles.extend(fan);
        }
        for pair in sides.into_values() {
            zip(&pair[0], &pair[1], &mut soup.triangles, random);
        }
        soup.triangles.shuffle(random);
        for t in &mut soup.triangles {
            t.rotate_left(random.random_range(0..3));
        }
        soup
    }

    /// An edge with so many new places on it, from its one end to the other.
    fn side(positions: &mut Vec<[f64; 3]>, [a, b]: [u32; 2], places: usize) -> Vec<u32> {
        let [p, q] = [a, b].map(|v| DVec3::from(positions[v as usize]));
        let mut side = vec![a];
        for i in 1..=places {
            side.push(positions.len() as u32);
            // No two sides have places in common.
            let share = (i as f64 + 0.001 * positions.len() as f64) / (places + 1) as f64;
            positions.push(p.lerp(q, share.min(0.999)).to_array());
        }
        side.push(b);
        side
    }

    /// Triangles between two sides of one edge, chosen by chance.
    fn zip(one: &[u32], other: &[u32], triangles: &mut Vec<[u32; 3]>, random: &mut SmallRng) {
        let (mut i, mut j) = (0, 0);
        while i + 1 < one.len() || j + 1 < other.len() {
            let first = j + 1 == other.len() || (i + 1 < one.len() && random.random());
            let [here, there] = [one[i], other[j]];
            if first {
                i += 1;
                triangles.push([here, one[i], there]);
            } else {
                j += 1;
                triangles.push([here, there, other[j]]);
            }
        }
    }

    #[test]
    fn no_crack_is_left_where_triangles_without_area_were() {
        let mut random = SmallRng::seed_from_u64(1);
        let mut divided = 0;
        for _ in 0..300 {
            let soup = zipped(&mut random);
            let substrate = Substrate::from_soup(soup.clone()).unwrap();
            let report = substrate.report();
            assert_eq!(report.boundary_edges, 0, "{soup:?}");
            assert_eq!((report.components.len(), report.non_manifold_edges), (1, 0));
            assert!(
                (report.area - 4.0 * 3f64.sqrt()).abs() < 1e-9,
                "{}",
                report.area
            );
            divided += report
                .repairs
                .iter()
                .filter(|r| r.contains("on whose edges"))
                .count();
        }
        assert_eq!(divided, 300);
    }

    #[test]
    fn parts_lie_where_their_weights_say() {
        let mut random = SmallRng::seed_from_u64(2);
        for _ in 0..30 {
            let soup = zipped(&mut random);
            let substrate = Substrate::from_soup(soup.clone()).unwrap();
            let in_file = |t: u32, weights: [f64; 3]| {
                let corners = soup.triangles[t as usize].map(|v| soup.positions[v as usize]);
                let all = corners.into_iter().zip(weights);
                all.map(|(p, w)| DVec3::from(p) * w).sum::<DVec3>()
            };
            for t in 0..substrate.triangles().len() as u32 {
                let source = substrate.source_triangle(t);
                let corners = substrate.corners(t).map(|p| substrate.units().to_file(p));
                for (corner, weights) in corners.into_iter().zip(substrate.source_weights(t)) {
                    assert!(in_file(source, weights).distance(corner) < 1e-12);
                }
                let [x, y]: [f64; 2] = [random.random(), random.random()];
                let weights = [1.0 - x.max(y), (x - y).abs(), x.min(y)];
                let place = substrate.place_of_source(source, weights).unwrap();
                assert_eq!(substrate.source_triangle(place.triangle), source);
                let place = substrate.units().to_file(substrate.position(&place));
                assert!(in_file(source, weights).distance(place) < 1e-12);
            }
        }
    }

    /// Where texture coordinates follow the places, they do so on parts.
    #[test]
    fn parts_have_the_texture_coordinates_of_their_places() {
        let mut random = SmallRng::seed_from_u64(4);
        let uv = |p: DVec3| [0.3 * p.x + 0.1 * p.y, 0.2 * p.z - 0.4 * p.y];
        for _ in 0..30 {
            let soup = zipped(&mut random);
            let at = |t: &[u32; 3]| Some(t.map(|v| uv(DVec3::from(soup.positions[v as usize]))));
            let texturing = Texturing {
                uvs: soup.triangles.iter().map(at).collect(),
                ..Texturing::default()
            };
            let substrate = Substrate::from_soup(soup.clone()).unwrap();
            for t in 0..substrate.triangles().len() as u32 {
                let expected = substrate
                    .corners(t)
                    .map(|p| uv(substrate.units().to_file(p)));
                let found = texturing.uvs_of(&substrate, t).unwrap();
                let mut apart = found.as_flattened().iter().zip(expected.as_flattened());
                assert!(
                    apart.all(|(a, b)| (a - b).abs() < 1e-12),
                    "{found:?} {expected:?}"
                );
            }
        }
    }

    #[test]
    fn a_part_is_named_by_its_own_number() {
        let mut random = SmallRng::seed_from_u64(3);
        let substrate = Substrate::from_soup(zipped(&mut random)).unwrap();
        let triangles = 0..substrate.triangles().len() as u32;
        let mut numbers: Vec<u32> = triangles
            .clone()
            .map(|t| substrate.canonical_triangle(t))
            .collect();
        numbers.sort_unstable();
        assert!(numbers.into_iter().eq(triangles.clone()));
        assert!(triangles.clone().any(|t| substrate.is_part(t)));
        let whole = triangles.clone().find(|&t| !substrate.is_part(t)).unwrap();
        let place = substrate.place_of_source(substrate.source_triangle(whole), [1.0; 3]);
        assert_eq!(place, Some(SurfacePoint::centroid(whole)));
    }

    /// A flat triangle that hangs on an edge of two others joins nothing; nor does one at a border.
    #[test]
    fn flaps_without_area_go() {
        let positions = [[0.0, 0.0], [1.0, 0.0], [0.5, 1.0], [0.5, -1.0], [0.3, 0.0]];
        let both = vec![[0, 1, 2], [1, 0, 3], [0, 1, 4]];
        for triangles in [both, vec![[0, 1, 2], [0, 1, 4], [0, 4, 1]]] {
            let soup = Soup {
                positions: positions.iter().map(|[x, y]| [*x, *y, 0.0]).collect(),
                triangles,
                ..Soup::default()
            };
            let all = soup.triangles.len();
            let substrate = Substrate::from_soup(soup).unwrap();
            let report = substrate.report();
            assert_eq!(
                report.triangles + report.degenerate_triangles + report.duplicate_triangles,
                all
            );
        }
    }
}
