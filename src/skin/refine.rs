//! Cutting the surface finer where there is lichen.
//!
//! Sides are halved, and a triangle is cut by how many of its sides are. Whether a side is halved
//! depends on the side alone, so neighbours agree without asking one another and no crack opens.
//!
//! A side is halved once the lichen has a number of elements. So one tree holds the surface as it is
//! cut for the lichen at any age, each exactly as if the tree had been made for it: triangles have a
//! life, and one whose sides are halved one after the other is cut in as many ways.

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
    levels: Vec<Level>,
}

struct Level {
    faces: Vec<Face>,
    middles: Vec<Middles>,
    /// For how many elements each side is halved; [`NEVER`].
    halved: Vec<Counts>,
}

/// A number of elements for each of a triangle's sides.
type Counts = [u32; 3];

/// More elements than there are.
pub(super) const NEVER: u32 = u32::MAX;

/// As many elements as there may be.
pub(super) const ALL: u32 = NEVER - 1;

impl Tree {
    /// Halves each side from as many elements on as `halved` says of its ends; [`NEVER`] leaves it.
    pub(super) fn grow(base: Base, halved: impl Fn(DVec3, DVec3) -> u32 + Sync) -> Self {
        let mut tree = Self {
            positions: base.positions,
            homes: base.homes,
            levels: Vec::new(),
        };
        let mut faces = base.faces;
        while !faces.is_empty() {
            let (middles, counts) = tree.cut(&faces, &halved);
            let below = children(&faces, &middles, &counts, &tree.positions);
            tree.levels.push(Level {
                faces,
                middles,
                halved: counts,
            });
            faces = below;
        }
        tree
    }

    /// Makes the middles of the sides that are halved while their triangles live.
    fn cut(
        &mut self,
        faces: &[Face],
        halved: &(impl Fn(DVec3, DVec3) -> u32 + Sync),
    ) -> (Vec<Middles>, Vec<Counts>) {
        let positions = &self.positions;
        let sides = |(i, face): (usize, &Face)| {
            let face = *face;
            (0..3).filter_map(move |k| {
                let (a, b) = (face.corners[k], face.corners[(k + 1) % 3]);
                let (a, b) = (a.min(b), a.max(b));
                let count = halved(positions[a as usize], positions[b as usize]);
                let slot = (3 * i + k) as u32;
                (count < face.life[1]).then(|| (side_key(a, b), slot, count))
            })
        };
        let mut sides: Vec<(u64, u32, u32)> =
            faces.par_iter().enumerate().flat_map_iter(sides).collect();
        sides.par_sort_unstable();
        let mut middles = vec![[NONE; 3]; faces.len()];
        let mut counts = vec![[NEVER; 3]; faces.len()];
        let (slots, count_slots) = (middles.as_flattened_mut(), counts.as_flattened_mut());
        for run in sides.chunk_by(|a, b| a.0 == b.0) {
            let (key, first, _) = run[0];
            let [a, b] = [(key >> 32) as usize, key as u32 as usize];
            let middle = self.positions.len() as u32;
            let halfway = (self.positions[a] + self.positions[b]) * 0.5;
            self.positions.push(halfway);
            self.homes.push(faces[first as usize / 3].home);
            for (_, slot, count) in run {
                slots[*slot as usize] = middle;
                count_slots[*slot as usize] = *count;
            }
        }
        (middles, counts)
    }

    /// The triangles that are not cut for a lichen of so many elements.
    pub(super) fn leaves(&self, elements: u32) -> Vec<Face> {
        let of_level = |level: &Level| {
            let both = level.faces.par_iter().zip(&level.halved);
            let whole = both.filter(|(face, halved)| is_leaf(face, halved, elements));
            whole.map(|(face, _)| *face).collect::<Vec<_>>()
        };
        self.levels.iter().flat_map(of_level).collect()
    }

    /// The same surface, cut no finer than it takes to have the leaves that `needed` wants: with
    /// the same vertices, and triangles wherever it can be without.
    pub(super) fn coarsened(
        &self,
        elements: u32,
        needed: impl Fn(&Face) -> bool + Sync,
    ) -> Vec<Face> {
        let kept = self.kept_middles(elements, needed);
        let mut coarse = Vec::new();
        let mut faces = self.levels.first().map_or(Vec::new(), |l| l.faces.clone());
        while !faces.is_empty() {
            let middle = |a: u32, b: u32| kept.get(&side_key(a.min(b), a.max(b)));
            let middles: Vec<Middles> = faces
                .par_iter()
                .map(|f| {
                    let [a, b, c] = f.corners;
                    [(a, b), (b, c), (c, a)].map(|(a, b)| middle(a, b).copied().unwrap_or(NONE))
                })
                .collect();
            let whole = faces.iter().zip(&middles).filter(|(_, m)| **m == [NONE; 3]);
            coarse.extend(whole.map(|(face, _)| *face));
            let halved: Vec<Counts> = middles
                .iter()
                .map(|m| m.map(|m| if m == NONE { NEVER } else { 0 }))
                .collect();
            faces = children(&faces, &middles, &halved, &self.positions);
        }
        coarse
    }

    /// By side, the middles of all that has a needed leaf below it.
    fn kept_middles(&self, elements: u32, needed: impl Fn(&Face) -> bool + Sync) -> WordMap<u32> {
        let mut kept = WordMap::default();
        let mut holds_below: Vec<bool> = Vec::new();
        for (depth, level) in self.levels.iter().enumerate().rev() {
            let both = level.faces.par_iter().zip(&level.halved);
            let holds = both.map(|(face, halved)| is_leaf(face, halved, elements) && needed(face));
            let mut holds: Vec<bool> = holds.collect();
            if let Some(below) = self.levels.get(depth + 1) {
                let children = below.faces.iter().zip(&holds_below);
                for (child, _) in children.filter(|(_, holds)| **holds) {
                    holds[child.parent as usize] = true;
                }
            }
            for (i, _) in holds.iter().enumerate().filter(|(_, holds)| **holds) {
                keep(&mut kept, &level.faces[i], &reached(level, i, elements));
            }
            holds_below = holds;
        }
        kept
    }
}

fn lives(face: &Face, elements: u32) -> bool {
    (face.life[0]..face.life[1]).contains(&elements)
}

fn is_leaf(face: &Face, halved: &Counts, elements: u32) -> bool {
    lives(face, elements) && halved.iter().all(|&count| count > elements)
}

/// The middles of a triangle's sides that are halved for so many elements.
fn reached(level: &Level, i: usize, elements: u32) -> Middles {
    by_count(level.middles[i], level.halved[i], elements)
}

fn by_count(middles: Middles, halved: Counts, elements: u32) -> Middles {
    [0, 1, 2].map(|k| {
        if halved[k] <= elements {
            middles[k]
        } else {
            NONE
        }
    })
}

fn keep(kept: &mut WordMap<u32>, face: &Face, middles: &Middles) {
    let [a, b, c] = face.corners;
    let sides = [(a, b), (b, c), (c, a)].into_iter().zip(middles);
    for ((a, b), middle) in sides.filter(|(_, middle)| **middle != NONE) {
        kept.insert(side_key(a.min(b), a.max(b)), *middle);
    }
}

/// A side's number: its ends, the lower first.
pub(super) fn side_key(a: u32, b: u32) -> u64 {
    u64::from(a) << 32 | u64::from(b)
}

/// What triangles are cut into, once for each number of sides that are halved while they live; those
/// without a middle have ended.
fn children(
    faces: &[Face],
    middles: &[Middles],
    halved: &[Counts],
    positions: &[DVec3],
) -> Vec<Face> {
    let all = faces.par_iter().zip(middles).zip(halved).enumerate();
    all.flat_map_iter(|(i, ((face, middles), halved))| {
        let lives = lives_of_children(face.life, *halved).into_iter().flatten();
        lives.flat_map(move |life| {
            let middles = by_count(*middles, *halved, life[0]);
            let (count, pieces) = pieces(face, middles, positions);
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
            let inner = ([m[0], m[1], m[2]], [false; 3]);
            (4, [corners[0], corners[1], corners[2], inner])
        }
    }
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
