//! Cutting the surface finer where there is lichen.
//!
//! Sides are halved, and a triangle is cut by how many of its sides are. Whether a side is halved
//! depends on the side alone, so neighbours agree without asking one another and no crack opens.
//!
//! A side is halved once the lichen has a number of elements. So one tree holds the surface as it is
//! cut for the lichen at any age, each exactly as if the tree had been made for it: triangles have a
//! life, and one whose sides are halved one after the other is cut in as many ways.

use std::sync::atomic::{AtomicBool, Ordering::Relaxed};

use glam::DVec3;
use rayon::prelude::*;

use super::base::{Base, Face, NONE, bits};
use super::grid::WordMap;

/// The vertices at the middles of a triangle's sides; [`NONE`] where a side is whole.
type Middles = [u32; 3];

/// A surface and all that it was cut from.
pub(super) struct Tree {
    pub(super) positions: Vec<DVec3>,
    /// For each vertex a substrate triangle that it lies on.
    pub(super) homes: Vec<u32>,
    /// The triangles that were not cut from others, then what they are cut into, and so on.
    faces: Vec<Face>,
    roots: usize,
    middles: Vec<Middles>,
    /// For how many elements each side is halved; [`NEVER`].
    halved: Vec<Counts>,
    /// Where the first of what each is cut into is, and where they end.
    cut_into: Vec<[u32; 2]>,
    /// The middle of each side that is ever halved.
    middle_of: WordMap<u32>,
}

/// A number of elements for each of a triangle's sides.
type Counts = [u32; 3];

/// More elements than there are.
pub(super) const NEVER: u32 = u32::MAX;

/// As many elements as there may be.
pub(super) const ALL: u32 = NEVER - 1;

impl Tree {
    /// Halves each side that is longer than `longest` from as many elements on as `halved` says of its
    /// middle and length; [`NEVER`] leaves it.
    pub(super) fn grow(
        base: Base,
        longest: f64,
        halved: impl Fn(DVec3, f64) -> u32 + Sync,
    ) -> Self {
        let mut tree = Self {
            positions: base.positions,
            homes: base.homes,
            roots: base.faces.len(),
            faces: base.faces,
            middles: Vec::new(),
            halved: Vec::new(),
            cut_into: Vec::new(),
            middle_of: WordMap::default(),
        };
        let mut first = 0;
        while first < tree.faces.len() {
            tree.cut(first, longest, &halved);
            let below = tree.children(first);
            first = tree.faces.len();
            tree.faces.extend(below);
            tree.find_children(first);
        }
        tree
    }

    /// Notes where the children are that begin here.
    fn find_children(&mut self, first: usize) {
        self.cut_into.resize(first, [0; 2]);
        for (i, face) in (first as u32..).zip(&self.faces[first..]) {
            let run = &mut self.cut_into[face.parent as usize];
            *run = [if run[1] == 0 { i } else { run[0] }, i + 1];
        }
    }

    /// Makes the middles of the sides that are halved while their triangles live, from a triangle on.
    fn cut(&mut self, first: usize, longest: f64, halved: &(impl Fn(DVec3, f64) -> u32 + Sync)) {
        let sides = self.long_sides(first, longest);
        let count = |run: &[(u64, u32)]| {
            let [p, q] = self.ends(run[0].0);
            halved(0.5 * (p + q), (q - p).length())
        };
        let runs = sides.par_chunk_by(|a, b| a.0 == b.0);
        let counts: Vec<u32> = runs.map(count).collect();
        self.middles.resize(self.faces.len(), [NONE; 3]);
        self.halved.resize(self.faces.len(), [NEVER; 3]);
        for (run, count) in sides.chunk_by(|a, b| a.0 == b.0).zip(counts) {
            let face = |slot: u32| first + slot as usize / 3;
            let halved = |slot: u32| count < self.faces[face(slot)].life[1];
            let Some(&(key, slot)) = run.iter().find(|(_, slot)| halved(*slot)) else {
                continue;
            };
            let middle = self.positions.len() as u32;
            let [p, q] = self.ends(key);
            self.positions.push((p + q) * 0.5);
            self.homes.push(self.faces[face(slot)].home);
            let other = self.middle_of.insert(key, middle);
            debug_assert!(other.is_none(), "a side is halved once");
            for &(_, slot) in run.iter().filter(|(_, slot)| halved(*slot)) {
                self.middles[face(slot)][slot as usize % 3] = middle;
                self.halved[face(slot)][slot as usize % 3] = count;
            }
        }
    }

    /// The sides that are longer than this of triangles from one on: three numbers for each triangle.
    fn long_sides(&self, first: usize, longest: f64) -> Vec<(u64, u32)> {
        let long = |(i, face): (usize, &Face)| {
            let sides = sides(face).into_iter().zip(3 * i as u32..);
            let sides = sides.map(|((a, b), slot)| (side_key(a.min(b), a.max(b)), slot));
            sides.filter(|(key, _)| {
                let [p, q] = self.ends(*key);
                (q - p).length() > longest
            })
        };
        let faces = self.faces[first..].par_iter().enumerate();
        let mut sides: Vec<(u64, u32)> = faces.flat_map_iter(long).collect();
        sides.par_sort_unstable();
        sides
    }

    /// Where a side's lower end is, and its other end.
    fn ends(&self, side: u64) -> [DVec3; 2] {
        [(side >> 32) as u32, side as u32].map(|v| self.positions[v as usize])
    }

    /// Of the triangles that are ever not cut those that are `wanted`, with their lives as such.
    pub(super) fn leaves(&self, wanted: impl Fn(&Face) -> bool + Sync) -> Vec<Face> {
        let both = self.faces.par_iter().zip(&self.halved);
        let whole = both.filter_map(|(face, halved)| {
            let until = halved
                .iter()
                .fold(face.life[1], |end, &count| end.min(count));
            let life = [face.life[0], until];
            (life[0] < life[1]).then_some(Face { life, ..*face })
        });
        whole.filter(|face| wanted(face)).collect()
    }

    /// The surface for a lichen of so many elements, cut no finer than it takes to have the `needed`
    /// of its leaves: with the same vertices, and triangles wherever it can be without. Only what is
    /// `wanted` of it.
    pub(super) fn coarsened(
        &self,
        elements: u32,
        needed: &[&Face],
        wanted: impl Fn(&Face) -> bool + Sync,
    ) -> Vec<Face> {
        let kept = self.kept_middles(elements, needed);
        let cut = |root: usize| {
            let mut coarse = Vec::new();
            self.cut_where_kept(root, elements, &kept, &mut coarse);
            coarse.retain(&wanted);
            coarse
        };
        let roots = (0..self.roots).into_par_iter();
        roots.flat_map_iter(cut).collect()
    }

    /// Cuts one of the tree's triangles as the tree has it, as long as all middles are kept.
    fn cut_where_kept(
        &self,
        face: usize,
        elements: u32,
        kept: &[AtomicBool],
        coarse: &mut Vec<Face>,
    ) {
        let reached = by_count(self.middles[face], self.halved[face], elements);
        let kept_of = reached.map(|m| if is_kept(m, kept) { m } else { NONE });
        if kept_of != reached || reached == [NONE; 3] {
            self.cut_anew(&self.faces[face], kept_of, kept, coarse);
            return;
        }
        let [first, end] = self.cut_into[face];
        for child in (first..end).map(|child| child as usize) {
            if self.faces[child].lives(elements) {
                self.cut_where_kept(child, elements, kept, coarse);
            }
        }
    }

    /// Cuts a triangle in a way that the tree may not have.
    fn cut_anew(&self, face: &Face, middles: Middles, kept: &[AtomicBool], coarse: &mut Vec<Face>) {
        let (count, pieces) = pieces(face, middles, &self.positions);
        if count == 0 {
            coarse.push(*face);
        }
        for (corners, open) in pieces.into_iter().take(count) {
            let open = bits(open);
            let piece = Face {
                corners,
                open,
                ..*face
            };
            let middles = sides(&piece).map(|(a, b)| {
                let middle = self.middle_of.get(&side_key(a.min(b), a.max(b)));
                middle
                    .copied()
                    .filter(|m| is_kept(*m, kept))
                    .unwrap_or(NONE)
            });
            self.cut_anew(&piece, middles, kept, coarse);
        }
    }

    /// For each vertex whether it is the middle of a side of what these leaves were cut from.
    fn kept_middles(&self, elements: u32, needed: &[&Face]) -> Vec<AtomicBool> {
        let [kept, held] = [self.positions.len(), self.faces.len()].map(marks);
        needed.par_iter().for_each(|leaf| {
            let mut above = leaf.parent;
            // Twice is no harm.
            while above != NONE && !held[above as usize].load(Relaxed) {
                let i = above as usize;
                held[i].store(true, Relaxed);
                let reached = by_count(self.middles[i], self.halved[i], elements);
                for middle in reached.into_iter().filter(|&middle| middle != NONE) {
                    kept[middle as usize].store(true, Relaxed);
                }
                above = self.faces[i].parent;
            }
        });
        kept
    }

    /// What triangles from one on are cut into, once for each number of sides that are halved while
    /// they live; those without a middle have ended.
    fn children(&self, first: usize) -> Vec<Face> {
        let all = (first..self.faces.len()).into_par_iter();
        all.flat_map_iter(|i| {
            let (face, middles, halved) = (&self.faces[i], self.middles[i], self.halved[i]);
            let lives = lives_of_children(face.life, halved).into_iter().flatten();
            lives.flat_map(move |life| {
                let middles = by_count(middles, halved, life[0]);
                let (count, pieces) = pieces(face, middles, &self.positions);
                let piece = move |(corners, open): Piece| Face {
                    corners,
                    home: face.home,
                    parent: i as u32,
                    open: bits(open),
                    life,
                };
                pieces.into_iter().take(count).map(piece)
            })
        })
        .collect()
    }
}

fn is_kept(middle: u32, kept: &[AtomicBool]) -> bool {
    middle != NONE && kept[middle as usize].load(Relaxed)
}

fn marks(count: usize) -> Vec<AtomicBool> {
    (0..count).map(|_| AtomicBool::new(false)).collect()
}

/// The ends of a triangle's sides, in its order.
pub(super) fn sides(face: &Face) -> [(u32, u32); 3] {
    let [a, b, c] = face.corners;
    [(a, b), (b, c), (c, a)]
}

/// The middles of the sides that are halved for so many elements.
fn by_count(middles: Middles, halved: Counts, elements: u32) -> Middles {
    [0, 1, 2].map(|k| {
        if halved[k] <= elements {
            middles[k]
        } else {
            NONE
        }
    })
}

/// A side's number: its ends, the lower first.
pub(super) fn side_key(a: u32, b: u32) -> u64 {
    u64::from(a) << 32 | u64::from(b)
}

/// A triangle's life from when its first side is halved, cut where another is.
fn lives_of_children(life: [u32; 2], mut halved: Counts) -> [Option<[u32; 2]>; 3] {
    halved.sort_unstable();
    let [a, b, c] = halved;
    [[a, b], [b, c], [c, NEVER]].map(|[from, until]| {
        let part = [from.max(life[0]), until.min(life[1])];
        (part[0] < part[1]).then_some(part)
    })
}

/// Corners, and which sides are open.
type Piece = ([u32; 3], [bool; 3]);

const NO_PIECE: Piece = ([NONE; 3], [false; 3]);

/// The triangles that one is cut into, and how many they are.
fn pieces(face: &Face, middles: Middles, positions: &[DVec3]) -> (usize, [Piece; 4]) {
    let halved = middles.map(|m| m != NONE);
    // Turned so that one halved side comes first, or the whole one last.
    let turn = match halved {
        [false, true, false] | [false, true, true] => 1,
        [false, false, true] | [true, false, true] => 2,
        _ => 0,
    };
    let at = |k: usize| (k + turn) % 3;
    let [v, m] = [face.corners, middles].map(|x| [x[at(0)], x[at(1)], x[at(2)]]);
    let open = [0, 1, 2].map(|k| face.open >> at(k) & 1 == 1);
    let [o0, o1, o2] = open;
    match halved.iter().filter(|h| **h).count() {
        0 => (0, [NO_PIECE; 4]),
        1 => {
            let two = [
                ([v[0], m[0], v[2]], [o0, false, o2]),
                ([m[0], v[1], v[2]], [o0, o1, false]),
            ];
            (2, [two[0], two[1], NO_PIECE, NO_PIECE])
        }
        2 => {
            let [a, b] = quad(v, m, open, positions);
            let tip = ([m[0], v[1], m[1]], [o0, o1, false]);
            (3, [tip, a, b, NO_PIECE])
        }
        _ => {
            let corners = [
                ([v[0], m[0], m[2]], [o0, false, o2]),
                ([m[0], v[1], m[1]], [o0, o1, false]),
                ([m[2], m[1], v[2]], [false, o1, o2]),
            ];
            match obtuse(v, m, positions) {
                None => {
                    let inner = ([m[0], m[1], m[2]], [false; 3]);
                    (4, [corners[0], corners[1], corners[2], inner])
                }
                Some(k) => {
                    let [base, right, apex, left] =
                        [m[k], m[(k + 1) % 3], v[(k + 2) % 3], m[(k + 2) % 3]];
                    let [right_open, left_open] = [open[(k + 1) % 3], open[(k + 2) % 3]];
                    let halves = [
                        ([base, right, apex], [false, right_open, false]),
                        ([base, apex, left], [false, left_open, false]),
                    ];
                    (4, [corners[k], corners[(k + 1) % 3], halves[0], halves[1]])
                }
            }
        }
    }
}

/// A triangle is a sliver when so many of its heights are no more than the side they stand on.
const SLIVER: f64 = 8.0;

/// The side, from its corner k to the next, across from the obtuse corner of a sliver. Middles of the other two are
/// farther from each other than that corner is from the middle of this one, and triangles between them as long as half
/// of the whole: cut so time and again, a sliver ends in as many as the square of its length over theirs.
fn obtuse(v: [u32; 3], m: Middles, positions: &[DVec3]) -> Option<usize> {
    let at = |vertex: u32| positions[vertex as usize];
    (0..3).find(|&k| {
        let [from, to, apex] = [v[k], v[(k + 1) % 3], v[(k + 2) % 3]].map(at);
        let side = to - from;
        let twice_area = side.cross(apex - from).length();
        SLIVER * twice_area < side.length_squared()
            && 4.0 * (apex - at(m[k])).length_squared() < side.length_squared()
    })
}

/// The trapezium that is left when the tip at corner 1 is cut off, by its shorter diagonal.
fn quad(v: [u32; 3], m: Middles, [o0, o1, o2]: [bool; 3], positions: &[DVec3]) -> [Piece; 2] {
    let distance_sq = |a: u32, b: u32| {
        let (a, b) = (positions[a as usize], positions[b as usize]);
        (a - b).length_squared()
    };
    match distance_sq(v[0], m[1]) <= distance_sq(m[0], v[2]) {
        true => [
            ([v[0], m[0], m[1]], [o0, false, false]),
            ([v[0], m[1], v[2]], [false, o1, o2]),
        ],
        false => [
            ([m[0], m[1], v[2]], [false, o1, false]),
            ([v[0], m[0], v[2]], [o0, false, o2]),
        ],
    }
}
