//! Long and thin triangles cut across, before lichen is looked for.
//!
//! To halve the sides of a long triangle time and again leaves ever thinner tips: three pieces where two would do, so
//! that a cylinder's sides are cut into a hundred slivers an element. Triangles whose two long sides border on others
//! of the kind, as those about a cylinder, a cone or a twig, are cut across instead, from one long side to the other,
//! into pieces that are about as wide as long. Whether a side is cut depends on the mesh and the length alone, so
//! neighbours agree.

use rayon::prelude::*;
use rustc_hash::FxHashMap;

use super::base::{Base, Face, bits};
use super::grid::WordMap;
use super::refine::side_key;
use crate::substrate::{Substrate, Winding};

/// A triangle is long if the longest side is so many times the shortest, and times its width.
const LONG: f64 = 4.0;

/// Pieces are so many times as long as wide.
const ASPECT: f64 = 1.4;

/// Pieces of a side, at most and at least.
const MOST: f64 = 512.0;
const LEAST: f64 = 3.0;

/// Pieces of all sides of a mesh, about, at most: where there are many, each is cut into fewer.
const MOST_IN_ALL: f64 = (1 << 20) as f64;

/// Into how many pieces sides of a substrate's triangles are cut, by half-edge; those that are not there stay.
pub(super) struct Cuts(WordMap<u32>);

/// The numbers of the long sides of a long triangle, 0 to 2, and how long its pieces are to be.
struct Long {
    sides: [u32; 2],
    length: f64,
}

impl Cuts {
    /// Where sides are halved that are longer than `longest`.
    pub(super) fn new(substrate: &Substrate, longest: f64) -> Self {
        let all = (0..substrate.triangles().len() as u32).into_par_iter();
        let long = |t: u32| Some((t, Long::of(substrate, t, longest)?));
        let all: Vec<(u32, Long)> = all.filter_map(long).collect();
        let most = (MOST_IN_ALL / all.len() as f64).clamp(LEAST, MOST);
        let mut cuts = Self(WordMap::default());
        for (t, long) in &all {
            for h in long.sides.map(|k| 3 * t + k) {
                let pieces = pieces(substrate, long.length, h, longest);
                let pieces = pieces.map(|pieces| pieces.min(most) as u32);
                cuts.0.extend(pieces.map(|pieces| (u64::from(h), pieces)));
            }
        }
        cuts.keep_pairs(
            substrate,
            longest,
            all.into_iter().map(|(t, _)| t).collect(),
        );
        cuts
    }

    /// Of two long sides both are cut or none.
    fn keep_pairs(&mut self, substrate: &Substrate, longest: f64, mut doubtful: Vec<u32>) {
        while let Some(t) = doubtful.pop() {
            let Some(long) = Long::of(substrate, t, longest) else {
                continue;
            };
            let sides = long.sides.map(|k| 3 * t + k);
            let [is_cut, other_is] = sides.map(|h| self.0.contains_key(&u64::from(h)));
            if is_cut == other_is {
                continue;
            }
            for h in sides {
                let across = substrate.twin(h).half_edge();
                for h in [h, across] {
                    self.0.remove(&u64::from(h));
                }
                doubtful.push(across / 3);
            }
        }
    }

    /// Of a face's sides, in its order.
    fn of(&self, winding: &Winding, face: &Face) -> [u32; 3] {
        let sides = match winding.side(face.home) > 0.0 {
            true => [0, 1, 2],
            false => [2, 1, 0],
        };
        let pieces = |k: u32| self.0.get(&u64::from(3 * face.home + k)).copied();
        sides.map(|k| pieces(k).unwrap_or(1))
    }
}

/// The first vertex between the ends of each side that is cut into so many pieces. Where a mesh is pinched, two sides
/// may have the same ends.
type Between = FxHashMap<(u64, u32), u32>;

impl Base {
    /// With its long and thin triangles cut across.
    pub(super) fn sliced(mut self, substrate: &Substrate, cuts: &Cuts) -> Self {
        let mut between = Between::default();
        let whole = std::mem::take(&mut self.faces);
        for face in whole {
            let pieces = cuts.of(substrate.winding(), &face);
            // The side that stays, after the corner where the long ones meet.
            match (0..3).find(|k| pieces[(k + 1) % 3] == 1 && pieces != [1; 3]) {
                None => self.faces.push(face),
                Some(apex) => self.slice(&face, apex, pieces, &mut between),
            }
        }
        self
    }

    /// Cuts a face across its two long sides, which begin at one of its corners.
    fn slice(&mut self, face: &Face, apex: usize, pieces: [u32; 3], between: &mut Between) {
        let [first, last] = [apex, (apex + 2) % 3];
        let corner = |k: usize| face.corners[k % 3];
        let right = [corner(apex), corner(apex + 1)];
        let left = [corner(apex), corner(apex + 2)];
        let right = self.points(right, pieces[first], face.home, between);
        let left = self.points(left, pieces[last], face.home, between);
        let is_open = |k: usize| face.open >> (k % 3) & 1 == 1;
        let (mut i, mut j) = (0, 0);
        while i + 1 < right.len() || j + 1 < left.len() {
            let goes_right = match (right.get(i + 1), left.get(j + 1)) {
                (Some(&next), Some(&other)) => {
                    self.apart(next, left[j]) <= self.apart(right[i], other)
                }
                (next, _) => next.is_some(),
            };
            let is_end = |i: usize, j: usize| i + 1 == right.len() && j + 1 == left.len();
            let (corners, open) = if i == 0 && j == 0 {
                (i, j) = (1, 1);
                let corners = [right[0], right[1], left[1]];
                (corners, [is_open(first), false, is_open(last)])
            } else if goes_right {
                i += 1;
                let end = is_end(i, j) && is_open(apex + 1);
                (
                    [right[i - 1], right[i], left[j]],
                    [is_open(first), end, false],
                )
            } else {
                j += 1;
                let end = is_end(i, j) && is_open(apex + 1);
                (
                    [right[i], left[j], left[j - 1]],
                    [end, is_open(last), false],
                )
            };
            let open = bits(open);
            self.faces.push(Face {
                corners,
                open,
                ..*face
            });
        }
    }

    fn apart(&self, a: u32, b: u32) -> f64 {
        self.positions[a as usize].distance_squared(self.positions[b as usize])
    }

    /// The vertices along a side from one end to the other, those between them made where they are not yet.
    fn points(
        &mut self,
        [from, to]: [u32; 2],
        pieces: u32,
        home: u32,
        between: &mut Between,
    ) -> Vec<u32> {
        let (low, high) = (from.min(to), from.max(to));
        let next = self.positions.len() as u32;
        let side = (side_key(low, high), pieces);
        let first = *between.entry(side).or_insert(next);
        if first == next {
            let [p, q] = [low, high].map(|v| self.positions[v as usize]);
            // Vertices are numbered by where there is lichen, and places must not be rounded by that.
            let place = |k: u32| match p.to_array() <= q.to_array() {
                true => p.lerp(q, f64::from(k) / f64::from(pieces)),
                false => q.lerp(p, f64::from(pieces - k) / f64::from(pieces)),
            };
            self.positions.extend((1..pieces).map(place));
            self.homes.extend((1..pieces).map(|_| home));
        }
        let inner = first..first + pieces - 1;
        let mut all = vec![low];
        all.extend(inner);
        all.push(high);
        if from > to {
            all.reverse();
        }
        all
    }
}

impl Long {
    /// None of a triangle that is not long, or has no side longer than `longest`.
    fn of(substrate: &Substrate, t: u32, longest: f64) -> Option<Self> {
        let corners = substrate.corners(t);
        let sides = [0, 1, 2].map(|k| corners[k].distance(corners[(k + 1) % 3]));
        let shortest = (0..3).min_by(|&i, &j| sides[i].total_cmp(&sides[j]))?;
        let most = sides.into_iter().fold(0.0, f64::max);
        let width = 2.0 * substrate.area(t) / most;
        let is_long = most > LONG * sides[shortest].max(width).max(longest);
        is_long.then_some(Self {
            sides: [1, 2].map(|k| (shortest as u32 + k) % 3),
            length: (ASPECT * width).max(longest),
        })
    }
}

/// Into how many pieces a long side is to be cut, if it is long in the triangle across too; an open one has none.
fn pieces(substrate: &Substrate, length: f64, h: u32, longest: f64) -> Option<f64> {
    let across = substrate.twin(h).half_edge();
    let other = Long::of(substrate, across / 3, longest)?;
    let corners = substrate.corners(h / 3);
    let k = h as usize % 3;
    let long = corners[k].distance(corners[(k + 1) % 3]);
    let pieces = (long / length.max(other.length)).ceil();
    let is_cut = other.sides.contains(&(across % 3)) && pieces >= LEAST;
    is_cut.then_some(pieces)
}
