//! Corners on the open edges of others.
//!
//! Where one side of a line is cut finer than the other, as tiles of terrain at two levels of detail are, or what
//! booleans and CAD programs make, corners of one side lie on edges of the other, and all of these edges are open,
//! although there is no hole. At a corner that both sides share, two open edges go the same way, of which the
//! shorter one ends on the longer one. Between them a triangle without area (but for rounding) is put, which
//! [flipping](caps::flip) divides the other's triangle with: the surface is as it was. So it goes on from there.
//! Seams without any corner that both sides share stay open.

use std::collections::HashMap;

use glam::DVec3;

use super::caps::{self, Part, WHOLE, edge};
use super::weld::Welded;

/// Corners of more open edges than this are left alone: there triangles lie loose.
const MOST_EDGES: usize = 8;

/// Divides triangles at the corners of others on their open edges. Whether there are any.
///
/// `apart` is how far from an edge a corner may be that is meant to be on it, and `least` how long edges are that
/// are looked at; local units.
pub(super) fn close(welded: &mut Welded, open: &[[u32; 2]], [apart, least]: [f64; 2]) -> bool {
    let caps = Rims::new(&welded.vertices, open, apart, least).caps(&welded.triangles);
    if caps.is_empty() {
        return false;
    }
    let before = welded.triangles.len();
    let first = 1 + welded.source.iter().max().map_or(0, |&last| last);
    welded.source.extend((first..).take(caps.len()));
    welded.triangles.extend(caps);
    let all: Vec<u32> = (before as u32..welded.triangles.len() as u32).collect();
    let parts = caps::flip(&welded.vertices, &mut welded.triangles, &all);
    adopt(welded, &parts, before);
    let mut at = 0..;
    // A cap that is left is no part.
    welded.retain(|_| {
        let at = at.next();
        at.is_some_and(|at: u32| (at as usize) < before || parts.contains_key(&at))
    });
    welded.tidy();
    !parts.is_empty()
}

/// The open edges, and for each vertex where those at it end.
struct Rims<'a> {
    vertices: &'a [DVec3],
    /// As they were: one vertex after the other, and where each one's begin.
    ends: Vec<u32>,
    begin: Vec<u32>,
    /// As they are at vertices where they have changed.
    changed: HashMap<u32, Vec<u32>>,
    /// The third corners of the triangles at edges between such vertices.
    apexes: HashMap<[u32; 2], u32>,
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
            apexes: HashMap::new(),
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

    /// Triangles between two open edges that lie on one another: from where both begin to the end of the shorter one
    /// and on to that of the longer one.
    fn caps(mut self, triangles: &[[u32; 3]]) -> Vec<[u32; 3]> {
        let all = 0..self.vertices.len() as u32;
        let mut left: Vec<u32> = all.filter(|&v| self.cap_at(v).is_some()).collect();
        if !left.is_empty() {
            self.find_apexes(triangles);
        }
        let mut caps = Vec::new();
        while let Some(a) = left.pop() {
            let Some([a, middle, b]) = self.cap_at(a) else {
                continue;
            };
            caps.push([a, middle, b]);
            if let Some(&apex) = self.apexes.get(&edge(a, b)) {
                self.apexes.insert(edge(middle, b), apex);
            }
            self.toggle([a, middle]);
            self.toggle([a, b]);
            self.toggle([middle, b]);
            left.extend([a, b, middle]);
        }
        caps
    }

    fn find_apexes(&mut self, triangles: &[[u32; 3]]) {
        for &[a, b, c] in triangles {
            for [from, to, apex] in [[a, b, c], [b, c, a], [c, a, b]] {
                if [from, to].iter().all(|&v| !self.ends_at(v).is_empty()) {
                    self.apexes.insert(edge(from, to), apex);
                }
            }
        }
    }

    /// Whether the triangles at two edges that go the same way lie on one another: as where a surface is there twice,
    /// which is no seam.
    fn is_fold(&self, [a, v, b]: [u32; 3]) -> bool {
        const FOLDED: f64 = 0.985;
        let place = |v: u32| self.vertices[v as usize];
        let along = (place(b) - place(a)).normalize_or_zero();
        let aside = |end: u32| {
            let to = place(*self.apexes.get(&edge(a, end))?) - place(a);
            Some((to - to.dot(along) * along).normalize_or_zero())
        };
        let both = aside(v).zip(aside(b));
        both.is_some_and(|(one, other)| one.dot(other) > FOLDED)
    }

    /// One at this vertex where no third edge goes the same way.
    fn cap_at(&self, a: u32) -> Option<[u32; 3]> {
        let is_loose = |v: u32| self.ends_at(v).len() > MOST_EDGES;
        if is_loose(a) {
            return None;
        }
        let ends = self.ends_at(a);
        let is_third = |&v: &u32, b: u32| self.is_cap([a, v, b]) || self.is_cap([a, b, v]);
        let is_alone = |&[_, middle, b]: &[u32; 3]| {
            let mut others = ends.iter().filter(|v| ![middle, b].contains(v));
            !others.any(|v| is_third(v, b)) && !is_loose(middle) && !is_loose(b)
        };
        let pairs = ends
            .iter()
            .flat_map(|&b| ends.iter().map(move |&v| [a, v, b]));
        let mut caps = pairs.filter(|corners| self.is_cap(*corners));
        caps.find(|cap| is_alone(cap) && !self.is_fold(*cap))
    }

    /// Whether the second corner lies between the others.
    fn is_cap(&self, [a, v, b]: [u32; 3]) -> bool {
        let [p, q, r] = [a, v, b].map(|v| self.vertices[v as usize]);
        let along = r - p;
        let share = (q - p).dot(along) / along.length_squared();
        let length = along.length();
        v != b
            && (p + share * along).distance(q) <= self.apart
            && [share, 1.0 - share]
                .iter()
                .all(|part| part * length > self.least)
    }
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

    /// All corners that its sides share are those of two seams.
    #[test]
    fn a_cube_with_one_side_cut_finer_is_closed() {
        for n in 2..7u32 {
            let mut soup = Soup::default();
            for face in 0..6 {
                let n = if face == 0 { n } else { 1 };
                let at = soup.positions.len() as u32;
                for (k, l) in (0..=n).flat_map(|k| (0..=n).map(move |l| (k, l))) {
                    let [x, y] = [k, l].map(|k| f64::from(k) / f64::from(n));
                    let mut place = if face < 3 { [x, y, 1.0] } else { [y, x, 0.0] };
                    place.rotate_left(face % 3);
                    soup.positions.push(place);
                }
                for (k, l) in (0..n).flat_map(|k| (0..n).map(move |l| (k, l))) {
                    let [a, b] = [at + k * (n + 1) + l, at + (k + 1) * (n + 1) + l];
                    soup.triangles.extend([[a, b, b + 1], [a, b + 1, a + 1]]);
                }
            }
            let substrate = Substrate::from_soup(soup).unwrap();
            let report = substrate.report();
            assert_eq!(report.boundary_edges, 0, "{n}");
            assert_eq!((report.components.len(), report.winding_conflicts), (1, 0));
            assert_eq!(report.triangles as u32, 2 * n * n + 10 + 4 * (n - 1));
        }
    }

    /// Tiles of terrain at two levels of detail, like a chessboard.
    #[test]
    fn tiles_of_two_levels_are_one_surface() {
        const TILES: u32 = 5;
        let mut soup = Soup::default();
        for (i, j) in (0..TILES).flat_map(|i| (0..TILES).map(move |j| (i, j))) {
            let n = if (i + j) % 2 > 0 { 7 } else { 3 };
            let at = soup.positions.len() as u32;
            let place = |tile: u32, k: u32| f64::from(tile) + f64::from(k) / f64::from(n);
            let rows = (0..=n).flat_map(|k| (0..=n).map(move |l| (k, l)));
            soup.positions
                .extend(rows.map(|(k, l)| [place(i, k), place(j, l), 0.0]));
            for (k, l) in (0..n).flat_map(|k| (0..n).map(move |l| (k, l))) {
                let [a, b] = [at + k * (n + 1) + l, at + (k + 1) * (n + 1) + l];
                soup.triangles.extend([[a, b, b + 1], [a, b + 1, a + 1]]);
            }
        }
        let substrate = Substrate::from_soup(soup).unwrap();
        let report = substrate.report();
        assert_eq!(report.components.len(), 1);
        assert_eq!(report.non_manifold_edges, 0);
        // Each side has three tiles of the coarser level and two of the finer one.
        assert_eq!(report.boundary_edges, 4 * (3 * 3 + 2 * 7));
    }

    /// A surface that is there twice, cut otherwise the second time, has no seam with itself at its border.
    #[test]
    fn what_lies_on_one_another_is_not_joined() {
        let mut random = SmallRng::seed_from_u64(6);
        let mut soup = halves(&mut random, [0, 3], 0.0);
        soup.triangles.retain(|t| t.iter().all(|&v| v > 4));
        let once = soup.clone();
        let mut again = halves(&mut random, [0, 5], 0.0);
        again.positions[5] = [0.4, 0.5, 0.0];
        let base = soup.positions.len() as u32;
        soup.positions.extend(again.positions);
        let second = again.triangles.iter().filter(|t| t.iter().all(|&v| v > 4));
        soup.triangles.extend(second.map(|t| t.map(|v| v + base)));
        let report = |soup| Substrate::from_soup(soup).unwrap().report().clone();
        assert_eq!(report(once).components.len(), 1);
        let twice = report(soup);
        assert_eq!(twice.triangles, twice.triangles_read);
    }

    /// Where three sheets meet at a line it is not known which belong together.
    #[test]
    fn a_line_of_three_sheets_is_left_alone() {
        let mut soup = halves(&mut SmallRng::seed_from_u64(5), [1, 2], 0.0);
        let at = soup.positions.len() as u32;
        let third = [
            [0.0, 0.0, 0.0],
            [0.0, 0.9, 0.0],
            [0.0, 1.0, 0.0],
            [0.0, 0.5, 1.0],
        ];
        soup.positions.extend(third);
        soup.triangles
            .extend([[at, at + 1, at + 3], [at + 1, at + 2, at + 3]]);
        let substrate = Substrate::from_soup(soup).unwrap();
        let report = substrate.report();
        assert_eq!(report.components.len(), 3);
        assert_eq!(report.triangles, report.triangles_read);
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
