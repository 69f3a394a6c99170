//! Corners on the open edges of others.
//!
//! Where one side of a line is cut finer than the other, as tiles of terrain at two levels of detail are, or what
//! booleans and CAD programs make, corners of one side lie on edges of the other, and all of these edges are open,
//! although there is no hole. At a corner that both sides share, two open edges go the same way, of which the
//! shorter one ends on the longer one. Between them a triangle without area is put, which [flipping](caps::flip)
//! divides the other's triangle with: the surface is as it was. So it goes on from there.

use std::collections::HashMap;

use glam::DVec3;

use super::caps::{self, Part, WHOLE};
use super::weld::{Welded, is_degenerate};

/// Corners of more open edges than this are left alone: there triangles lie loose.
const MOST_EDGES: usize = 8;

/// Divides triangles at the corners of others on their open edges, and says at how many.
///
/// `apart` is how far from an edge a corner may be that is meant to be on it, and `least` how long edges are that
/// are looked at; local units.
pub(super) fn close(welded: &mut Welded, open: &[[u32; 2]], [apart, least]: [f64; 2]) -> usize {
    let lines = Rims::new(&welded.vertices, open, apart, least).lines();
    if lines.is_empty() {
        return 0;
    }
    straighten(welded, &lines);
    let all = lines.iter().flat_map(|line| &line.caps);
    let is_flat = |cap: &&[u32; 3]| is_degenerate(&welded.vertices, **cap);
    let caps: Vec<[u32; 3]> = all.filter(is_flat).copied().collect();
    let before = welded.triangles.len();
    let first = 1 + welded.source.iter().max().map_or(0, |&last| last);
    welded.source.extend((first..).take(caps.len()));
    welded.triangles.extend(caps);
    let all: Vec<u32> = (before as u32..welded.triangles.len() as u32).collect();
    let parts = caps::flip(&welded.vertices, &mut welded.triangles, &all);
    adopt(welded, &parts, before);
    welded.drop_flat();
    welded.tidy();
    all.iter().filter(|t| parts.contains_key(t)).count()
}

/// Open edges that lie on one another, from a corner that both sides share to where they meet again or part.
struct Line {
    ends: [u32; 2],
    /// Triangles without area between two of them: from where both begin to the end of the shorter one and on to that
    /// of the longer one.
    caps: Vec<[u32; 3]>,
}

/// The open edges, and for each vertex where those at it end.
struct Rims<'a> {
    vertices: &'a [DVec3],
    /// As they were: one vertex after the other, and where each one's begin.
    ends: Vec<u32>,
    begin: Vec<u32>,
    /// As they are at vertices where they have changed.
    changed: HashMap<u32, Vec<u32>>,
    apart: f64,
    least: f64,
}

impl<'a> Rims<'a> {
    fn new(vertices: &'a [DVec3], open: &[[u32; 2]], apart: f64, least: f64) -> Self {
        let mut begin = vec![0u32; vertices.len() + 1];
        let all = open.as_flattened();
        all.iter().for_each(|&v| begin[v as usize + 1] += 1);
        (0..vertices.len()).for_each(|v| begin[v + 1] += begin[v]);
        let (mut next, mut ends) = (begin.clone(), vec![0; all.len()]);
        for (from, to) in open.iter().flat_map(|&[a, b]| [(a, b), (b, a)]) {
            ends[next[from as usize] as usize] = to;
            next[from as usize] += 1;
        }
        Self {
            vertices,
            ends,
            begin,
            changed: HashMap::new(),
            apart,
            least,
        }
    }

    fn ends_at(&self, v: u32) -> &[u32] {
        let [begin, end] = [0, 1].map(|k| self.begin[v as usize + k] as usize);
        let as_they_were = &self.ends[begin..end];
        self.changed.get(&v).map_or(as_they_were, Vec::as_slice)
    }

    /// Removes an open edge that there is, or adds one.
    fn toggle(&mut self, [a, b]: [u32; 2]) {
        for [from, to] in [[a, b], [b, a]] {
            let mut ends = self.ends_at(from).to_vec();
            match ends.iter().position(|&end| end == to) {
                Some(at) => _ = ends.remove(at),
                None => ends.push(to),
            }
            self.changed.insert(from, ends);
        }
    }

    fn lines(mut self) -> Vec<Line> {
        let all = 0..self.vertices.len() as u32;
        let mut left: Vec<u32> = all.filter(|&v| self.cap_at(v).is_some()).collect();
        let mut lines = Vec::new();
        while let Some(start) = left.pop() {
            let mut line = Line {
                ends: [start; 2],
                caps: Vec::new(),
            };
            let mut at = start;
            while let Some([a, middle, b]) = self.cap_at(at) {
                if !self.goes_on(&line, [a, b]) {
                    break;
                }
                self.toggle([a, middle]);
                self.toggle([a, b]);
                self.toggle([middle, b]);
                line.caps.push([a, middle, b]);
                line.ends[1] = b;
                at = middle;
            }
            if !line.caps.is_empty() {
                left.extend([at, line.ends[1], start]);
                lines.push(line);
            }
        }
        lines
    }

    /// Whether an edge goes on as a line has gone.
    fn goes_on(&self, line: &Line, edge: [u32; 2]) -> bool {
        const STRAIGHT: f64 = 0.999;
        let along = |ends: [u32; 2]| {
            let [from, to] = ends.map(|v| self.vertices[v as usize]);
            (to - from).normalize_or_zero()
        };
        line.caps.is_empty() || along(line.ends).dot(along(edge)) > STRAIGHT
    }

    /// The one at this vertex, unless more than two edges go that way.
    fn cap_at(&self, a: u32) -> Option<[u32; 3]> {
        let ends = self.ends_at(a);
        if ends.len() > MOST_EDGES {
            return None;
        }
        let pairs = ends
            .iter()
            .flat_map(|&b| ends.iter().map(move |&v| [a, v, b]));
        let mut found = pairs.filter(|corners| self.is_cap(*corners));
        let first = found.next()?;
        found.next().is_none().then_some(first)
    }

    /// Whether the second corner lies between the others.
    fn is_cap(&self, [a, v, b]: [u32; 3]) -> bool {
        let [p, q, r] = [a, v, b].map(|v| self.vertices[v as usize]);
        let on = on_line([p, r], q);
        let is_between = (on - p).dot(r - p) > 0.0 && (on - r).dot(p - r) > 0.0;
        let ends = [on.distance(p), on.distance(r)];
        v != b
            && is_between
            && on.distance(q) <= self.apart
            && ends.into_iter().all(|length| length > self.least)
    }
}

/// The place nearest to another on a line.
fn on_line([from, to]: [DVec3; 2], place: DVec3) -> DVec3 {
    let along = to - from;
    from + (place - from).dot(along) / along.length_squared() * along
}

/// Moves corners onto the lines that they are on, but for those whose triangles would have no area any more.
fn straighten(welded: &mut Welded, lines: &[Line]) {
    let mut vertices = welded.vertices.clone();
    // An end of one line may be on another.
    const PASSES: usize = 4;
    for line in (0..PASSES).flat_map(|_| lines) {
        let is_bent = |cap: &[u32; 3]| !is_degenerate(&vertices, *cap);
        if line.caps.iter().any(is_bent) {
            let ends = line.ends.map(|v| vertices[v as usize]);
            for v in line.caps.iter().flat_map(|[_, middle, b]| [*middle, *b]) {
                if !line.ends.contains(&v) {
                    vertices[v as usize] = on_line(ends, vertices[v as usize]);
                }
            }
        }
    }
    let is_moved = |v: &u32| vertices[*v as usize] != welded.vertices[*v as usize];
    let touched = welded.triangles.iter().filter(|t| t.iter().any(is_moved));
    let spoilt = touched.filter(|t| is_degenerate(&vertices, **t));
    let spoilt: Vec<u32> = spoilt.flatten().copied().collect();
    for v in spoilt {
        vertices[v as usize] = welded.vertices[v as usize];
    }
    welded.vertices = vertices;
}

/// Numbers the parts that triangles were divided into, which are those of the file where these are parts already.
fn adopt(welded: &mut Welded, parts: &caps::Parts, before: usize) {
    let part = |(&at, part): (&u32, &Part)| {
        let place = welded.source[part.of as usize];
        let whole = Part {
            of: place,
            weights: WHOLE,
        };
        let Part { of, weights } = *welded.parts.get(&place).unwrap_or(&whole);
        let corners = weights.map(DVec3::from);
        let of_file = |[a, b, c]: [f64; 3]| a * corners[0] + b * corners[1] + c * corners[2];
        let weights = part.weights.map(|w| of_file(w).to_array());
        (at, Part { of, weights })
    };
    let mut found: Vec<(u32, Part)> = parts.iter().map(part).collect();
    // In the order of what they are parts of: that of other pieces in the file changes nothing.
    let key = |part: &Part| (part.of, part.weights.map(|w| w.map(f64::to_bits)));
    found.sort_unstable_by_key(|(_, part)| key(part));
    let mut numbers: Vec<u32> = welded.source[before..].to_vec();
    numbers.reverse();
    for (at, part) in found {
        if at as usize >= before
            && let Some(number) = numbers.pop()
        {
            welded.source[at as usize] = number;
        }
        welded.parts.insert(welded.source[at as usize], part);
    }
    for at in before..welded.triangles.len() {
        if !parts.contains_key(&(at as u32))
            && let Some(number) = numbers.pop()
        {
            welded.source[at] = number;
        }
    }
}

#[cfg(test)]
mod tests {
    use glam::{DMat3, DQuat};
    use rand::rngs::SmallRng;
    use rand::{RngExt, SeedableRng};

    use super::super::{Soup, Substrate};
    use super::*;

    /// Two squares beside each other, cut into triangles about their middles, with places of their own on the side
    /// that they share: so many, and so far from it.
    fn halves(random: &mut SmallRng, places: [usize; 2], off: f64) -> Soup {
        let mut soup = Soup::default();
        for (side, places) in [-1.0, 1.0].into_iter().zip(places) {
            // No two are as near to each other as those that are meant to be one.
            let place = |i: usize| 2.0 * i as f64 + 0.5 * side + random.random_range(0.6..1.4);
            let seam: Vec<f64> = (0..places).map(place).collect();
            let seam = seam.iter().map(|&y| [off * side, y / 14.0, 0.0]);
            let first = [[side, 0.0, 0.0], [0.0; 3]];
            let last = [[0.0, 1.0, 0.0], [side, 1.0, 0.0]];
            let outline: Vec<[f64; 3]> = first.into_iter().chain(seam).chain(last).collect();
            let at = soup.positions.len() as u32;
            let count = outline.len() as u32;
            soup.positions.push([0.5 * side, 0.5, 0.0]);
            soup.positions.extend(outline);
            soup.triangles.extend((0..count).map(|i| {
                let [a, b] = [at + 1 + i, at + 1 + (i + 1) % count];
                if side < 0.0 { [at, a, b] } else { [at, b, a] }
            }));
        }
        soup
    }

    /// Turned and moved anywhere, as single precision has it.
    fn turned(soup: &mut Soup, random: &mut SmallRng) {
        let mut turn = || random.random_range(-1.0..1.0);
        let q = DQuat::from_xyzw(turn(), turn(), turn(), turn()).normalize();
        let (turn, by) = (DMat3::from_quat(q), DVec3::new(turn(), turn(), turn()));
        for p in &mut soup.positions {
            let to = turn * DVec3::from(*p) + by;
            *p = to.to_array().map(|x| f64::from(x as f32));
        }
    }

    #[test]
    fn a_line_with_other_corners_on_either_side_is_no_crack() {
        let mut random = SmallRng::seed_from_u64(2);
        let mut divided = 0;
        for case in 0..400 {
            let places = [0, 1].map(|_| random.random_range(0..6));
            let mut soup = halves(&mut random, places, 0.0);
            if case % 2 > 0 {
                turned(&mut soup, &mut random);
            }
            let substrate = Substrate::from_soup(soup.clone()).unwrap();
            let report = substrate.report();
            assert_eq!(report.components.len(), 1, "{soup:?}");
            assert_eq!(
                (report.boundary_edges, report.non_manifold_edges),
                (6, 0),
                "{soup:?}"
            );
            assert!((report.area - 2.0).abs() < 1e-5, "{}", report.area);
            assert_eq!(report.degenerate_triangles + report.duplicate_triangles, 0);
            divided += report.triangles - report.triangles_read;
            for t in 0..report.triangles as u32 {
                let source = soup.triangles[substrate.source_triangle(t) as usize];
                let of_file = source.map(|v| DVec3::from(soup.positions[v as usize]));
                let here = substrate.corners(t).map(|p| substrate.units().to_file(p));
                for (weights, here) in substrate.source_weights(t).into_iter().zip(here) {
                    let there: DVec3 = weights.iter().zip(of_file).map(|(w, p)| *w * p).sum();
                    assert!(there.distance(here) < 1e-6, "{there} {here}");
                }
            }
        }
        assert!(divided > 1000, "{divided}");
    }

    #[test]
    fn corners_beside_an_edge_leave_it_open() {
        let mut random = SmallRng::seed_from_u64(3);
        for _ in 0..20 {
            let substrate = Substrate::from_soup(halves(&mut random, [0, 3], 1e-4)).unwrap();
            assert_eq!(substrate.report().components.len(), 2);
            assert_eq!(
                substrate.report().triangles,
                substrate.report().triangles_read
            );
        }
    }

    #[test]
    fn parts_are_numbered_alike_wherever_other_pieces_stand_in_the_file() {
        let mut random = SmallRng::seed_from_u64(4);
        for _ in 0..20 {
            let soup = halves(&mut random, [5, 4], 0.0);
            let other = halves(&mut random, [3, 0], 0.0);
            let places = |first: &Soup, second: &Soup| {
                let mut both = first.clone();
                let base = both.positions.len() as u32;
                both.positions.extend(&second.positions);
                let later = second.triangles.iter().map(|t| t.map(|v| v + base));
                both.triangles.extend(later);
                let substrate = Substrate::from_soup(both).unwrap();
                assert_eq!(substrate.components().len(), 2);
                let all = 0..substrate.triangles().len() as u32;
                let place = |t| (substrate.canonical_triangle(t), substrate.corners(t));
                let mut all: Vec<_> = all.map(place).collect();
                all.sort_by_key(|(number, _)| *number);
                all
            };
            let beside = |mut soup: Soup| {
                soup.positions
                    .iter_mut()
                    .for_each(|p| *p = p.map(|x| 0.5 * x + 3.0));
                soup
            };
            let other = beside(other);
            assert_eq!(places(&soup, &other), places(&other, &soup));
        }
    }
}
