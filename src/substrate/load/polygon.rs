//! Polygons to triangles.
//!
//! A quad is cut along a diagonal that lies inside it; larger polygons go to `earcut` in the
//! coordinate plane that their Newell normal (Newell 1972) faces most. `earcut` may drop a corner
//! that lies on the line between its neighbours; in a mesh that corner belongs to the neighbour
//! face too, and dropping it would open a crack. Such corners are put back, so that every polygon
//! of n corners becomes n − 2 triangles whose outline is the polygon's own.
//!
//! `earcut` is fast on outlines, but takes a time that grows with the square of the corners where they cross
//! themselves, and with their cube where they come to a few places again and again. The latter are cut as fans,
//! and of the former a file may have so many. Those that go once round their middle are mostly fast, but not all
//! of the largest.

use earcut::Earcut;
use glam::DVec2;

use super::error::{LoadFault, Parsed};
use super::{Format, counted};

/// Most corners of a polygon that may cross itself: cutting one that does takes seconds for this many.
const MOST_CORNERS: usize = 1 << 14;

/// Polygons of more corners are asked whether they are hard to cut.
const FEW: usize = 256;

/// What all of a file that may cross themselves or are large may cost, in corners squared: a minute.
const MOST_COST: u64 = 1 << 31;

/// How much less large ones cost that do not cross themselves, at the worst: where their corners' rounding is
/// as large as what the outline bends from one to the next. A circle of 130,000 corners then takes ten seconds.
const ROUND_COST: u64 = 8;

/// Share of a polygon that a triangle of it must have to count.
const FLAT: f64 = 1e-10;

/// Which corner of a face is at a vertex, the first of several.
pub(super) struct Corners<'a> {
    corners: &'a [u32],
    /// Of many: vertices with their corners, in order.
    sorted: Vec<(u32, usize)>,
}

impl<'a> Corners<'a> {
    pub(super) fn new(corners: &'a [u32]) -> Self {
        const MANY: usize = 16;
        let all = corners.iter().copied().zip(0..);
        let mut sorted: Vec<_> = all.filter(|_| corners.len() > MANY).collect();
        sorted.sort_unstable();
        Self { corners, sorted }
    }

    pub(super) fn at(&self, vertex: u32) -> Option<usize> {
        if self.sorted.is_empty() {
            return self.corners.iter().position(|&c| c == vertex);
        }
        let first = self.sorted.partition_point(|&(c, _)| c < vertex);
        let (found, corner) = *self.sorted.get(first)?;
        (found == vertex).then_some(corner)
    }
}

/// Cuts polygons, keeping its buffers between them.
pub(super) struct Triangulator {
    format: Format,
    earcut: Earcut<f64>,
    /// What those that may cross themselves or are large have cost: see [`MOST_COST`].
    cost: u64,
    flat: Vec<[f64; 2]>,
    cut: Vec<u32>,
    edges: Vec<(u32, u32)>,
    pending: Vec<Piece>,
    /// Polygons with more than three corners seen so far.
    pub(super) polygons: usize,
    /// Those that cross themselves, fold over in the plane that they face, or have no area.
    pub(super) without_inside: usize,
}

/// A triangle of the polygon's corners, and which of its edges (from each corner to the next)
/// pass over dropped corners.
struct Piece {
    corners: [u32; 3],
    open: [bool; 3],
}

impl Triangulator {
    pub(super) fn new(format: Format) -> Self {
        Self {
            format,
            earcut: Earcut::new(),
            cost: 0,
            flat: Vec::new(),
            cut: Vec::new(),
            edges: Vec::new(),
            pending: Vec::new(),
            polygons: 0,
            without_inside: 0,
        }
    }

    /// Appends the triangles of one polygon to `out`, unless those of its file take too long to cut.
    ///
    /// # Panics
    /// When a corner is not an index into `positions`.
    pub(super) fn polygon(
        &mut self,
        positions: &[[f64; 3]],
        corners: &[u32],
        out: &mut Vec<[u32; 3]>,
        place: impl FnOnce() -> String,
    ) -> Parsed<()> {
        match *corners {
            [] | [_] | [_, _] => {}
            [a, b, c] => out.push([a, b, c]),
            [a, b, c, d] => self.quad(positions, [a, b, c, d], out),
            _ => {
                self.charge(positions, corners, place)?;
                self.larger(positions, corners, out);
            }
        }
        Ok(())
    }

    /// Refuses a polygon with which those of the file may take too long to cut.
    fn charge(
        &mut self,
        positions: &[[f64; 3]],
        corners: &[u32],
        place: impl FnOnce() -> String,
    ) -> Parsed<()> {
        let count = corners.len();
        if count <= FEW {
            return Ok(());
        }
        let is_round = is_seen_from_its_middle(positions, corners);
        let is_large = count > MOST_CORNERS;
        if is_round && !is_large {
            return Ok(());
        }
        let cost = (count as u64).saturating_pow(2) / if is_round { ROUND_COST } else { 1 };
        self.cost = self.cost.saturating_add(cost);
        if (is_round || !is_large) && self.cost <= MOST_COST {
            return Ok(());
        }
        let problem = match (is_round, is_large) {
            (true, _) if cost > MOST_COST => {
                format!("a face with {count} corners may take too long to cut")
            }
            (true, _) => format!("a face with {count} corners, after too many as large"),
            (_, true) => format!(
                "a face with {count} corners, more than {MOST_CORNERS}, that may cross itself"
            ),
            (_, false) => format!(
                "a face with {count} corners that may cross itself, after too many of that kind"
            ),
        };
        let cure = "triangulate it in the program that made the file";
        Err(LoadFault::malformed(self.format, place(), problem, cure))
    }

    /// Words for what was done, for [`Soup::notes`](crate::substrate::Soup::notes).
    pub(super) fn notes(&self) -> Vec<String> {
        let mut notes = Vec::new();
        if self.polygons > 0 {
            notes.push(counted(self.polygons, "polygon", "polygons") + " triangulated");
        }
        if self.without_inside > 0 {
            let one = "polygon that crosses itself, folds over or has no area, cut all the same";
            let many =
                "polygons that cross themselves, fold over or have no area, cut all the same";
            notes.push(counted(self.without_inside, one, many));
        }
        notes
    }

    fn quad(&mut self, positions: &[[f64; 3]], quad: [u32; 4], out: &mut Vec<[u32; 3]>) {
        self.polygons += 1;
        let [a, b, c, d] = quad;
        let [p, q, r, s] = quad.map(|i| positions[i as usize]);
        let normal = cross(sub(r, p), sub(s, q));
        let facing = |t: [[f64; 3]; 3]| dot(cross(sub(t[1], t[0]), sub(t[2], t[0])), normal);
        let along_ac = facing([p, q, r]).min(facing([p, r, s]));
        let along_bd = facing([q, r, s]).min(facing([q, s, p]));
        let has_inside = normal != [0.0; 3] && (along_ac >= 0.0 || along_bd >= 0.0);
        self.without_inside += usize::from(!has_inside);
        // The first diagonal unless only the other leaves two triangles that face the same way. One along
        // which three corners lie leaves none, but for round-off.
        let none = FLAT * dot(normal, normal);
        if along_bd > none && along_ac <= none {
            out.extend([[b, c, d], [b, d, a]]);
        } else {
            out.extend([[a, b, c], [a, c, d]]);
        }
    }

    fn larger(&mut self, positions: &[[f64; 3]], corners: &[u32], out: &mut Vec<[u32; 3]>) {
        self.polygons += 1;
        let start = out.len();
        if self.cut_flat(positions, corners) && self.mend(corners.len() as u32, out) {
            self.without_inside += usize::from(self.turns_over(&out[start..]));
            for triangle in &mut out[start..] {
                *triangle = triangle.map(|i| corners[i as usize]);
            }
            return;
        }
        out.truncate(start);
        self.without_inside += 1;
        out.extend((1..corners.len() - 1).map(|i| [corners[0], corners[i], corners[i + 1]]));
    }

    /// Whether some of the triangles face one way in the plane and some the other, but for round-off.
    fn turns_over(&self, triangles: &[[u32; 3]]) -> bool {
        let area = |triangle: &[u32; 3]| {
            let [a, b, c] = triangle.map(|corner| DVec2::from(self.flat[corner as usize]));
            (b - a).perp_dot(c - a)
        };
        let share = |sign: f64| {
            triangles
                .iter()
                .map(|t| (sign * area(t)).max(0.0))
                .sum::<f64>()
        };
        let [left, right] = [1.0, -1.0].map(share);
        left.min(right) > FLAT * left.max(right)
    }

    /// Runs earcut on the projected polygon; `self.cut` then holds corner numbers, each triangle
    /// in ascending order: that is the polygon's own winding. False when it has no inside.
    fn cut_flat(&mut self, positions: &[[f64; 3]], corners: &[u32]) -> bool {
        let Some((u, v)) = facing_plane(positions, corners) else {
            return false;
        };
        // Relative to one corner, so that a far-away origin costs no precision.
        let base = positions[corners[0] as usize];
        self.flat.clear();
        self.flat.extend(corners.iter().map(|&i| {
            let p = sub(positions[i as usize], base);
            [p[u], p[v]]
        }));
        if self.flat.len() > FEW && comes_back(&self.flat) {
            return false;
        }
        self.earcut
            .earcut_slice::<u32>(&self.flat, &[], &mut self.cut);
        for triangle in self.cut.chunks_exact_mut(3) {
            triangle.sort_unstable();
        }
        !self.cut.is_empty()
    }

    /// Appends the triangles of `self.cut` with dropped corners put back. False when the result is
    /// not a disc with exactly the polygon's outline.
    fn mend(&mut self, n: u32, out: &mut Vec<[u32; 3]>) -> bool {
        self.edges.clear();
        for t in self.cut.chunks_exact(3) {
            self.edges
                .extend([(t[0], t[1]), (t[1], t[2]), (t[2], t[0])]);
        }
        self.edges.sort_unstable();
        if self.edges.windows(2).any(|pair| pair[0] == pair[1]) {
            return false;
        }
        let start = out.len();
        for t in self.cut.chunks_exact(3) {
            let corners = [t[0], t[1], t[2]];
            let open = |from: u32, to: u32| {
                to != (from + 1) % n && self.edges.binary_search(&(to, from)).is_err()
            };
            let open = [
                open(corners[0], corners[1]),
                open(corners[1], corners[2]),
                open(corners[2], corners[0]),
            ];
            self.pending.push(Piece { corners, open });
            split_open_edges(&mut self.pending, n, out);
            if out.len() - start > n as usize {
                self.pending.clear();
                return false;
            }
        }
        out.len() - start == n as usize - 2
    }
}

/// Splits each pending piece at the corners that its open edges pass over.
fn split_open_edges(pending: &mut Vec<Piece>, n: u32, out: &mut Vec<[u32; 3]>) {
    while let Some(Piece {
        corners: [a, b, c],
        open: [ab, bc, ca],
    }) = pending.pop()
    {
        let next = (a + 1) % n;
        if ab && next != b {
            pending.push(Piece {
                corners: [a, next, c],
                open: [false, false, ca],
            });
            pending.push(Piece {
                corners: [next, b, c],
                open: [true, bc, false],
            });
        } else if bc || ca {
            pending.push(Piece {
                corners: [b, c, a],
                open: [bc, ca, false],
            });
        } else {
            out.push([a, b, c]);
        }
    }
}

/// Whether an outline is at each of its places more than twice, in the mean. Bridges to holes are passed twice.
fn comes_back(outline: &[[f64; 2]]) -> bool {
    let mut places: Vec<[u64; 2]> = outline.iter().map(|p| p.map(f64::to_bits)).collect();
    places.sort_unstable();
    places.dedup();
    2 * places.len() < outline.len()
}

/// Whether a polygon's outline goes once round the mean of its corners, and never back: then it does not cross
/// itself. The caps of cylinders are such, however coarsely their corners are rounded.
fn is_seen_from_its_middle(positions: &[[f64; 3]], corners: &[u32]) -> bool {
    let Some((u, v)) = facing_plane(positions, corners) else {
        return false;
    };
    let flat = |corner: u32| {
        let p = positions[corner as usize];
        DVec2::new(p[u], p[v])
    };
    let middle = corners.iter().map(|c| flat(*c)).sum::<DVec2>() / corners.len() as f64;
    let (mut forth, mut back, mut rounds) = (false, false, 0);
    let mut before = flat(corners[corners.len() - 1]) - middle;
    for corner in corners {
        let here = flat(*corner) - middle;
        let turn = before.perp_dot(here);
        (forth, back) = (forth || turn >= 0.0, back || turn <= 0.0);
        rounds += usize::from(before.y < 0.0 && here.y >= 0.0);
        before = here;
    }
    forth != back && rounds == 1
}

/// The two axes that span the coordinate plane nearest to the polygon's own.
fn facing_plane(positions: &[[f64; 3]], corners: &[u32]) -> Option<(usize, usize)> {
    let base = positions[corners[0] as usize];
    let mut normal = [0.0_f64; 3];
    let mut before = sub(positions[corners[corners.len() - 1] as usize], base);
    for &corner in corners {
        let here = sub(positions[corner as usize], base);
        let turn = cross(before, here);
        normal = [
            normal[0] + turn[0],
            normal[1] + turn[1],
            normal[2] + turn[2],
        ];
        before = here;
    }
    let [x, y, z] = normal.map(f64::abs);
    let largest = x.max(y).max(z);
    if !(largest > 0.0 && largest.is_finite()) {
        return None;
    }
    Some(if z == largest {
        (0, 1)
    } else if x == largest {
        (1, 2)
    } else {
        (2, 0)
    })
}

fn sub(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}
